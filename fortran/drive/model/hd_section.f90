! SPDX-License-Identifier: GPL-3.0-or-later
!> Meridian sections of the drive: the ring, and the cup from its opening over rim, wall and bottom to the hub.
module hd_section
  use hd_kinds, only: dp, pi, hair
  use hd_cup_sections, only: has_sections, meridian_of, straight_end, thickness_on_wall
  use hd_meridian, only: meridian_t
  use hd_race, only: groove_depths
  use hd_revolution, only: strip_t, growth, append_intervals
  use hd_scene, only: scene_t
  implicit none
  private
  public :: ring_strip, cup_strip, rim_end, band_rows

  integer, parameter :: clear_cells = 4         !< edge cells that the band's ends keep clear of stations of their own
  integer, parameter :: arc_cells = 8           !< of a half turn, at least
  real(dp), parameter :: rounding = 1e-6_dp     !< a quarter turn of four cells that rounding lengthens has no fifth

contains

  !> Rows of facets along the band, those at its edges included.
  pure integer function band_rows(scene)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), allocatable :: z(:)
    z = [scene%band_start]
    call append_band(scene, scene%band_facets, z)
    band_rows = size(z) - 1
  end function band_rows

  !> Append the stations of the band after its first: equal rows; with shorter ones at its edges also stations where the rim
  !> begins to thin and where it has, without which the section changes with the rows, and from there on rows half as long: there
  !> the cup lifts off, and K_TS jumps with the row that this falls on.
  pure subroutine append_band(scene, facets, z)
    type(scene_t), intent(in) :: scene            !< scene
    integer, intent(in) :: facets                 !< rows, were they equal
    real(dp), allocatable, intent(inout) :: z(:)  !< stations, the first of the band at the end [m]
    real(dp), allocatable :: ends(:)
    real(dp) :: last, share
    integer :: i, times
    associate (edge => scene%edge_length)
      last = scene%band_start + scene%band_length
      ends = [real(dp) ::]
      if (edge > 0) ends = thinning(scene)
      ends = [pack(ends, ends > scene%band_start + clear_cells*edge .and. ends < last - clear_cells*edge), last]
      do i = 1, size(ends)
        times = min(i, 2)
        share = (ends(i) - z(size(z)))/scene%band_length
        call append_intervals(z, ends(i), max(times, rows_in(times*share*facets)), row_length(scene, z(size(z))), &
          row_length(scene, ends(i)))
      end do
    end associate
  end subroutine append_band

  !> Whole rows on a stretch. Halves, which round sizes meet, go up: neither rounding nor a small change of a key decides.
  elemental integer function rows_in(lengths)
    real(dp), intent(in) :: lengths  !< of the stretch over that of a row
    real(dp), parameter :: nudge = 1e-4_dp
    rows_in = max(1, nint(lengths + nudge))
  end function rows_in

  !> Where the wall begins or ends to thin: of the simple cup its rim's end and the taper's, else the points of its straight bore.
  pure function thinning(scene) result(ends)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), allocatable :: ends(:)
    type(meridian_t) :: meridian
    character(len=:), allocatable :: fault
    integer :: k
    ends = scene%rim_length + [0._dp, scene%rim_taper]
    if (.not. has_sections(scene)) return
    call meridian_of(scene, meridian, fault)
    ends = pack([(meridian%piece(k)%to(2), k=1, size(meridian%piece))], &
      [(meridian%piece(k)%to(2) <= straight_end(meridian, scene%bore_radius), k=1, size(meridian%piece))])
  end function thinning

  !> Length that rows growing from the nearest edge of the band have at a station; 0 without cells at the edges [m]. So rows go on
  !> growing where one stretch of them ends: K_TS rises by per cents if the next begins twenty times as long.
  pure real(dp) function row_length(scene, z)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), intent(in) :: z           !< distance from the opening [m]
    row_length = 0
    if (scene%edge_length > 0) row_length = scene%edge_length + &
      (growth - 1)*min(abs(z - scene%band_start), abs(z - (scene%band_start + scene%band_length)))
  end function row_length

  !> First station of the cup at or behind the end of the rim.
  pure integer function rim_end(scene, cup)
    type(scene_t), intent(in) :: scene  !< scene
    type(strip_t), intent(in) :: cup    !< section
    rim_end = 1 + count(cup%outer(2, :) < scene%rim_length*(1 - hair) .and. cup%outer(1, :) >= scene%bore_radius)
  end function rim_end

  !> Meridian section of the ring.
  pure subroutine ring_strip(scene, strip)
    type(scene_t), intent(in) :: scene   !< scene
    type(strip_t), intent(out) :: strip  !< section
    real(dp), allocatable :: z(:)
    z = [scene%band_start]
    call append_band(scene, merge(scene%ring_facets, scene%band_facets, scene%ring_facets > 0), z)
    allocate (strip%inner(2, size(z)), strip%outer(2, size(z)))
    strip%inner(1, :) = scene%bore_radius - scene%ring_thickness + groove_depths(scene, z)
    strip%outer(1, :) = scene%bore_radius
    strip%inner(2, :) = z
    strip%outer(2, :) = z
    strip%layers = scene%through_ring
  end subroutine ring_strip

  !> Meridian section of the cup: wall from the opening to a mitred corner, bottom from there to the hub.
  pure subroutine cup_strip(scene, strip, first, last)
    type(scene_t), intent(in) :: scene      !< scene
    type(strip_t), intent(out) :: strip     !< section
    integer, intent(out) :: first, last     !< stations at the ends of the contact band
    real(dp), allocatable :: z(:), way(:)
    real(dp) :: h, corner, wall_start
    integer :: i, wall, bottom
    if (has_sections(scene)) then
      call sectioned_strip(scene, strip, first, last)
      return
    end if
    h = scene%band_length/scene%band_facets
    corner = scene%cup_length - scene%bottom_thickness
    z = [0._dp]
    if (scene%band_start > 0) call append_intervals(z, scene%band_start, rows_in(scene%band_start/h), 0._dp, scene%edge_length)
    first = size(z)
    call append_band(scene, scene%band_facets, z)
    last = size(z)
    wall_start = z(last)
    if (scene%rim_length > wall_start .and. scene%rim_length < corner) then
      call append_intervals(z, scene%rim_length, rows_in((scene%rim_length - wall_start)/h), &
        row_length(scene, wall_start), row_length(scene, scene%rim_length))
      wall_start = scene%rim_length
    end if
    wall = merge(scene%wall_elements, rows_in((corner - wall_start)/h), scene%wall_elements > 0)
    call append_intervals(z, corner, wall, row_length(scene, wall_start), 0._dp)
    way = [0._dp]
    bottom = merge(scene%bottom_elements, rows_in((scene%bore_radius - scene%hub_radius)/h), scene%bottom_elements > 0)
    call append_intervals(way, scene%bore_radius - scene%hub_radius, bottom, 0._dp, clamped_cell(scene, scene%bottom_thickness))
    wall = size(z)
    bottom = size(way) - 1
    allocate (strip%inner(2, wall + bottom), strip%outer(2, wall + bottom))
    do i = 1, wall
      strip%inner(:, i) = [scene%bore_radius, z(i)]
      strip%outer(:, i) = [scene%bore_radius + thickness(scene, z(i)), z(i)]
    end do
    strip%outer(2, wall) = scene%cup_length
    do i = 1, bottom
      strip%inner(:, wall + i) = [scene%bore_radius - way(i + 1), corner]
      strip%outer(:, wall + i) = [scene%bore_radius - way(i + 1), scene%cup_length]
    end do
    strip%layers = scene%through_wall
  end subroutine cup_strip

  !> Meridian section of a cup by sections: stations of band and rim as in the simple cup, then on every piece of the meridian.
  pure subroutine sectioned_strip(scene, strip, first, last)
    type(scene_t), intent(in) :: scene      !< scene
    type(strip_t), intent(out) :: strip     !< section
    integer, intent(out) :: first, last     !< stations at the ends of the contact band
    type(meridian_t) :: meridian
    character(len=:), allocatable :: fault
    real(dp), allocatable :: z(:), part(:)
    real(dp) :: h, inner(2), outer(2)
    integer :: i, k
    call meridian_of(scene, meridian, fault)
    h = scene%band_length/scene%band_facets
    z = [0._dp]
    if (scene%band_start > 0) call append_intervals(z, scene%band_start, rows_in(scene%band_start/h), 0._dp, scene%edge_length)
    first = size(z)
    call append_band(scene, scene%band_facets, z)
    last = size(z)
    if (scene%rim_length > z(last)) call append_intervals(z, scene%rim_length, rows_in((scene%rim_length - z(last))/h), &
      row_length(scene, z(last)), row_length(scene, scene%rim_length))
    allocate (strip%inner(2, 0), strip%outer(2, 0))
    do i = 1, size(z)
      call add_station(strip, [scene%bore_radius, z(i)], [scene%bore_radius + thickness_on_wall(meridian, z(i)), z(i)])
    end do
    do k = 1, size(meridian%piece)
      associate (from => meridian%piece(k)%from, to => meridian%piece(k)%to, done => z(size(z)))
        part = [0._dp]
        if (to(2) > from(2) .and. to(2) <= straight_end(meridian, scene%bore_radius)) then  ! of the bore: what the rim has left
          if (to(2) <= done*(1 + hair)) cycle
          part = [max(0._dp, (done - from(2))/(to(2) - from(2)))]
        end if
        call meridian%at(k, 1._dp, inner, outer)
        call append_intervals(part, 1._dp, cells_of(scene, meridian, k, part(1)), merge(row_length(scene, done), 0._dp, &
          part(1) > 0)/meridian%length(k), merge(clamped_cell(scene, norm2(inner - outer)), 0._dp, &
          k == size(meridian%piece))/meridian%length(k))
        do i = 2, size(part)
          call meridian%at(k, part(i), inner, outer)
          call add_station(strip, inner, outer)
        end do
      end associate
    end do
    strip%layers = scene%through_wall
  end subroutine sectioned_strip

  !> Length of the cell at the clamped edge, where bending is largest and dies away within some thicknesses: a quarter of one, or an
  !> eighth of a facet on coarse meshes; 0: as long as the others, whose number a key gives [m].
  pure real(dp) function clamped_cell(scene, thickness)
    type(scene_t), intent(in) :: scene      !< scene
    real(dp), intent(in) :: thickness       !< there [m]
    clamped_cell = merge(0._dp, max(thickness/4, scene%band_length/scene%band_facets/8), scene%bottom_elements > 0)
  end function clamped_cell

  !> Append a station.
  pure subroutine add_station(strip, inner, outer)
    type(strip_t), intent(inout) :: strip         !< strip
    real(dp), intent(in) :: inner(2), outer(2)    !< r, z [m]
    strip%inner = reshape([strip%inner, inner], [2, size(strip%inner, 2) + 1])
    strip%outer = reshape([strip%outer, outer], [2, size(strip%outer, 2) + 1])
  end subroutine add_station

  !> Cells along a piece of the meridian behind band and rim: as long as the facets, or its share of those that the keys give; of a
  !> fillet four in a quarter turn at least.
  pure integer function cells_of(scene, meridian, k, from) result(n)
    type(scene_t), intent(in) :: scene          !< scene
    type(meridian_t), intent(in) :: meridian    !< its cup's
    integer, intent(in) :: k                    !< piece
    real(dp), intent(in) :: from                !< part of it that has its cells
    real(dp) :: whole, behind
    integer :: i, wanted
    wanted = merge(scene%wall_elements, scene%bottom_elements, meridian%axial(k))
    behind = max(scene%band_start + scene%band_length, scene%rim_length)
    whole = 0
    do i = 1, size(meridian%piece)
      associate (p => meridian%piece(i))
        if (meridian%axial(i) .neqv. meridian%axial(k)) cycle
        if (meridian%axial(i) .and. p%to(2) <= straight_end(meridian, scene%bore_radius)) then
          whole = whole + max(0._dp, p%to(2) - max(behind, p%from(2)))
        else
          whole = whole + meridian%length(i)
        end if
      end associate
    end do
    n = rows_in((1 - from)*meridian%length(k)*merge(wanted/whole, scene%band_facets/scene%band_length, wanted > 0))
    n = max(n, ceiling(abs(meridian%piece(k)%turn)/(pi/arc_cells) - rounding))
  end function cells_of

  !> Wall thickness: the toothed rim, a linear taper, the smooth wall [m].
  elemental real(dp) function thickness(scene, z)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), intent(in) :: z           !< distance from the opening [m]
    real(dp) :: f
    f = min(max((z - scene%rim_length)/scene%rim_taper, 0._dp), 1._dp)
    if (f < hair) f = 0
    thickness = (1 - f)*scene%rim_thickness + f*scene%wall_thickness
  end function thickness
end module hd_section
