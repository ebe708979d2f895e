! SPDX-License-Identifier: GPL-3.0-or-later
!> Keys of a cup by sections of its meridian, and what they settle of the simple keys of &geometry.
module hd_cup_sections
  use hd_kinds, only: dp
  use hd_meridian, only: meridian_t, new_meridian
  use hd_parameter_row, only: parameter_table_t, add_reals, tolerate
  use hd_scene, only: scene_t
  use hd_text, only: string_t, push, to_text
  implicit none
  private
  public :: add_cup_keys, has_sections, meridian_of, straight_end, thickness_on_wall, adopt_sections

  real(dp), parameter :: near = 1e-9_dp  !< of equal lengths, relative

contains

  !> Sections of the cup's meridian.
  subroutine add_cup_keys(s, t)
    type(scene_t), intent(inout), target :: s       !< scene
    type(parameter_table_t), intent(inout) :: t     !< table
    real(dp), parameter :: big = huge(1._dp)
    call add_reals(t, 'cup', 'sections_r', 'model', s%sections_r, 'm', 0._dp, big, &
      "distances from the axis of points on the cup's inside, from the opening along bore and bottom or flange to the hub; "// &
      '0: the simple cup of &geometry', s%sections_count(1))
    call add_reals(t, 'cup', 'sections_z', 'model', s%sections_z, 'm', 0._dp, big, &
      'distances of these points from the opening', s%sections_count(2))
    call add_reals(t, 'cup', 'sections_thickness', 'model', s%sections_thickness, 'm', 0._dp, big, &
      'thickness of the wall at these points; where it jumps, the point stands twice, with the thickness before and behind it', &
      s%sections_count(3))
    call tolerate(t, 0.1_dp, 'value', 'estimate')
    call add_reals(t, 'cup', 'sections_fillet', 'model', s%sections_fillet, 'm', 0._dp, big, &
      'radius of the inside at these points; 0: sharp; left out: all sharp', s%sections_count(4))
  end subroutine add_cup_keys

  !> Is the cup given by sections?
  pure logical function has_sections(scene)
    type(scene_t), intent(in) :: scene  !< scene
    has_sections = any(scene%sections_count(:3) > 1) .or. scene%sections_r(1) > 0
  end function has_sections

  !> The meridian of the sections; `fault` says what is wrong with them.
  pure subroutine meridian_of(scene, meridian, fault)
    type(scene_t), intent(in) :: scene                    !< scene with sections
    type(meridian_t), intent(out) :: meridian             !< from the opening to the hub
    character(len=:), allocatable, intent(out) :: fault   !< empty: none
    real(dp) :: fillet(scene%sections_count(1))
    integer :: n
    n = scene%sections_count(1)
    fillet = 0
    if (scene%sections_count(4) == n) fillet = scene%sections_fillet(:n)
    call new_meridian(scene%sections_r(:n), scene%sections_z(:n), scene%sections_thickness(:n), fillet, meridian, fault)
  end subroutine meridian_of

  !> Where the straight bore ends behind the opening [m].
  pure real(dp) function straight_end(meridian, bore)
    type(meridian_t), intent(in) :: meridian  !< meridian
    real(dp), intent(in) :: bore              !< radius [m]
    integer :: k
    straight_end = 0
    do k = 1, size(meridian%piece)
      if (any(abs([meridian%piece(k)%from(1), meridian%piece(k)%to(1)] - bore) > near*bore)) exit
      straight_end = meridian%piece(k)%to(2)
    end do
  end function straight_end

  !> Thickness of the straight wall at a distance from the opening [m].
  pure real(dp) function thickness_on_wall(meridian, z) result(t)
    type(meridian_t), intent(in) :: meridian  !< meridian
    real(dp), intent(in) :: z                 !< [m]
    real(dp) :: f
    integer :: k
    do k = 1, size(meridian%piece)
      associate (p => meridian%piece(k))
        f = (z - p%from(2))/(p%to(2) - p%from(2))
        t = (1 - f)*p%thickness(1) + f*p%thickness(2)
        if (z <= p%to(2)*(1 + near)) return
      end associate
    end do
  end function thickness_on_wall

  !> Check sections and let the simple keys follow from them: a key that is given and says something else is a fault.
  subroutine adopt_sections(scene, table, faults)
    type(scene_t), intent(inout), target :: scene             !< scene whose keys are in range
    type(parameter_table_t), intent(in) :: table              !< which of them are given
    type(string_t), allocatable, intent(inout) :: faults(:)   !< gets mistakes
    character(len=*), parameter :: names(4) = [character(len=9) :: 'r', 'z', 'thickness', 'fillet']
    type(scene_t) :: standard
    type(meridian_t) :: meridian
    character(len=:), allocatable :: fault
    real(dp) :: inner(2), outer(2), last(2)
    integer :: i, n
    if (.not. has_sections(scene)) return
    n = scene%sections_count(1)
    do i = 2, 4
      if (i == 4 .and. scene%sections_count(4) == 1 .and. .not. scene%sections_fillet(1) > 0) cycle
      if (scene%sections_count(i) /= n) call tell(trim(names(i)), scene%sections_count(i), to_text(n)// &
        ' values, one for each of cup.sections_r')
    end do
    if (size(faults) > 0) return
    if (.not. minval(scene%sections_r(:n)) > 0) call tell('r', 0, 'above 0 everywhere')
    if (.not. minval(scene%sections_thickness(:n)) > 0) call tell('thickness', 0, 'above 0 everywhere')
    if (abs(scene%sections_z(1)) > 0) call tell('z', 0, 'beginning with 0 at the opening, not with '//to_text(scene%sections_z(1)))
    if (n < 3) call tell('r', n, 'three points or more: opening, end of the bore, hub')
    if (size(faults) > 0) return
    call meridian_of(scene, meridian, fault)
    if (len(fault) > 0) then
      call push(faults, 'error: cup.sections: '//fault//new_line('a')//'      valid: points in order from the opening to '// &
        'the hub, apart from each other; the same point twice is a corner with two thicknesses')
      return
    end if
    last = [scene%sections_r(n), scene%sections_z(n)]
    if (abs(scene%sections_z(n - 1) - last(2)) > near*last(1)) call tell('z', n, 'ending with two points of one z: the hub '// &
      'is the edge of a bottom or flange square to the axis, not '//to_text(scene%sections_z(n - 1))//' and '//to_text(last(2)))
    i = size(meridian%piece)
    call meridian%at(i, 1._dp, inner, outer)
    call follow('bore_radius', scene%bore_radius, scene%sections_r(1), 'the first radius of the sections')
    call follow('rim_thickness', scene%rim_thickness, scene%sections_thickness(1), &
      'the thickness of the first section')
    call follow('wall_thickness', scene%wall_thickness, minval(scene%sections_thickness(:n), &
      mask=abs(scene%sections_r(:n) - scene%sections_r(1)) <= near*scene%sections_r(1)), 'the least thickness at the bore')
    call follow('bottom_thickness', scene%bottom_thickness, scene%sections_thickness(n), &
      'the thickness of the last section')
    call follow('hub_radius', scene%hub_radius, last(1), 'the radius of the last section')
    call follow('cup_length', scene%cup_length, max(maxval(scene%sections_z(:n)), outer(2)), &
      'the length of the sections')
    call follow('rim_taper', scene%rim_taper, standard%rim_taper, 'without meaning for a cup by sections: its default')
    associate (band_end => scene%band_start + scene%band_length, bore_end => straight_end(meridian, scene%bore_radius))
      if (.not. band_end < bore_end) call push(faults, 'error: geometry.band_length = '//to_text(scene%band_length)// &
        new_line('a')//'      valid: so that the band ends on the straight bore of the sections: below '// &
        to_text(bore_end - scene%band_start))
      if (.not. scene%rim_length < bore_end) call push(faults, 'error: geometry.rim_length = '//to_text(scene%rim_length)// &
        new_line('a')//'      valid: on the straight bore of the sections: below '//to_text(bore_end))
    end associate
  contains
    subroutine tell(key, value, rule)
      character(len=*), intent(in) :: key, rule
      integer, intent(in) :: value
      character(len=:), allocatable :: seen
      seen = ''
      if (value > 0) seen = ': '//to_text(value)//' values'
      call push(faults, 'error: cup.sections_'//key//seen//new_line('a')//'      valid: '//rule)
    end subroutine tell

    subroutine follow(key, value, settled, what)
      character(len=*), intent(in) :: key, what
      real(dp), intent(inout) :: value
      real(dp), intent(in) :: settled
      if (table%given('geometry', key) .and. abs(value - settled) > near*settled) call push(faults, &
        'error: geometry.'//key//' = '//to_text(value)//new_line('a')//'      valid: '//what//', '//to_text(settled)// &
        ', or left out: the cup is given by cup.sections')
      value = settled
    end subroutine follow
  end subroutine adopt_sections
end module hd_cup_sections
