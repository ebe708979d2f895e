! SPDX-License-Identifier: GPL-3.0-or-later
!> Meridian sections of the drive: the ring, and the cup from its opening over rim, wall and bottom to the hub.
module hd_section
  use hd_kinds, only: dp
  use hd_revolution, only: strip_t, growth, append_intervals
  use hd_scene, only: scene_t
  implicit none
  private
  public :: ring_strip, cup_strip, rim_end, band_rows

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
      if (edge > 0) ends = scene%rim_length + [0._dp, scene%rim_taper]
      ends = [pack(ends, ends > scene%band_start + 4*edge .and. ends < last - 4*edge), last]
      do i = 1, size(ends)
        times = min(i, 2)
        share = (ends(i) - z(size(z)))/scene%band_length
        call append_intervals(z, ends(i), max(times, nint(times*share*facets)), row_length(scene, z(size(z))), &
          row_length(scene, ends(i)))
      end do
    end associate
  end subroutine append_band

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
    rim_end = 1 + count(cup%outer(2, :) < scene%rim_length*(1 - 1e-9_dp) .and. cup%outer(1, :) >= scene%bore_radius)
  end function rim_end

  !> Meridian section of the ring.
  pure subroutine ring_strip(scene, strip)
    type(scene_t), intent(in) :: scene   !< scene
    type(strip_t), intent(out) :: strip  !< section
    real(dp), allocatable :: z(:)
    z = [scene%band_start]
    call append_band(scene, merge(scene%ring_facets, scene%band_facets, scene%ring_facets > 0), z)
    allocate (strip%inner(2, size(z)), strip%outer(2, size(z)))
    strip%inner(1, :) = scene%bore_radius - scene%ring_thickness
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
    real(dp), allocatable :: z(:), r(:)
    real(dp) :: h, corner, wall_start
    integer :: i, wall, bottom
    h = scene%band_length/scene%band_facets
    corner = scene%cup_length - scene%bottom_thickness
    z = [0._dp]
    if (scene%band_start > 0) call append_intervals(z, scene%band_start, max(1, nint(scene%band_start/h)), 0._dp, scene%edge_length)
    first = size(z)
    call append_band(scene, scene%band_facets, z)
    last = size(z)
    wall_start = z(last)
    if (scene%rim_length > wall_start .and. scene%rim_length < corner) then
      call append_intervals(z, scene%rim_length, max(1, nint((scene%rim_length - wall_start)/h)), &
        row_length(scene, wall_start), row_length(scene, scene%rim_length))
      wall_start = scene%rim_length
    end if
    wall = merge(scene%wall_elements, max(1, nint((corner - wall_start)/h)), scene%wall_elements > 0)
    call append_intervals(z, corner, wall, row_length(scene, wall_start), 0._dp)
    r = [scene%bore_radius]
    bottom = merge(scene%bottom_elements, max(1, nint((scene%bore_radius - scene%hub_radius)/h)), scene%bottom_elements > 0)
    call append_intervals(r, scene%hub_radius, bottom, 0._dp, 0._dp)
    wall = size(z)
    allocate (strip%inner(2, wall + bottom), strip%outer(2, wall + bottom))
    do i = 1, wall
      strip%inner(:, i) = [scene%bore_radius, z(i)]
      strip%outer(:, i) = [scene%bore_radius + thickness(scene, z(i)), z(i)]
    end do
    strip%outer(2, wall) = scene%cup_length
    do i = 1, bottom
      strip%inner(:, wall + i) = [r(i + 1), corner]
      strip%outer(:, wall + i) = [r(i + 1), scene%cup_length]
    end do
    strip%layers = scene%through_wall
  end subroutine cup_strip

  !> Wall thickness: the toothed rim, a linear taper, the smooth wall [m].
  elemental real(dp) function thickness(scene, z)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), intent(in) :: z           !< distance from the opening [m]
    real(dp) :: f
    f = min(max((z - scene%rim_length)/scene%rim_taper, 0._dp), 1._dp)
    if (f < 1e-9_dp) f = 0
    thickness = (1 - f)*scene%rim_thickness + f*scene%wall_thickness
  end function thickness
end module hd_section
