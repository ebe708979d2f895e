! SPDX-License-Identifier: GPL-3.0-or-later
!> Keys that say something of a part that the scene does not have.
module hd_idle_keys
  use hd_cup_sections, only: has_sections
  use hd_parameters, only: parameter_table_t, new_table
  use hd_scene, only: scene_t
  use hd_text, only: string_t, push
  implicit none
  private
  public :: idle_keys, is_idle

contains

  !> Keys that differ from their defaults, and change nothing.
  function idle_keys(scene) result(names)
    type(scene_t), intent(in) :: scene  !< checked scene
    type(string_t), allocatable :: names(:)
    type(scene_t), target :: copy, plain
    type(parameter_table_t) :: table, defaults
    integer :: i
    copy = scene
    call new_table(copy, table)  ! the values of a scene are the defaults of its own table
    call new_table(plain, defaults)
    allocate (names(0))
    do i = 1, size(table%rows)
      associate (row => table%rows(i))
        if (row%default == defaults%rows(i)%default) cycle
        if (row%group == 'geometry' .or. row%key == 'w') cycle  ! which take what sections and table say
        if (is_idle(scene, row%group, row%key)) call push(names, row%group//'.'//row%key)
      end associate
    end do
  end function idle_keys

  !> The part that a key is of is not there.
  pure logical function is_idle(s, group, key)
    type(scene_t), intent(in) :: s           !< scene
    character(len=*), intent(in) :: group, key  !< of the table
    logical :: named_model
    is_idle = .false.
    named_model = s%joint_model /= 'auto'
    select case (group)
    case ('geometry')
      is_idle = has_sections(s) .and. any(key == [character(len=16) :: 'wall_thickness', 'rim_thickness', 'cup_length', &
        'bottom_thickness', 'hub_radius'])
    case ('cup')
      is_idle = .not. has_sections(s)
    case ('bearing')
      is_idle = .not. s%support%struts .or. (s%balls == 0 .and. key /= 'balls' .and. key /= 'model')
    case ('loop', 'fatigue')
      is_idle = .not. s%support%loop
    case ('turning')
      is_idle = s%turning_positions == 0
    case ('wave_generator')
      is_idle = (key == 'arc_angle_deg' .and. s%cam /= 'arcs') .or. (key == 'w' .and. s%cam == 'table') .or. &
        (s%support%struts .and. s%balls > 0 .and. (key == 'cone_angle_deg' .or. key == 'ring_tangent')) .or. &
        (key == 'eccentricity_angle_deg' .and. .not. s%eccentricity > 0)
    case ('contact')
      is_idle = index(key, 'friction') > 0 .and. (s%bonded() .or. s%frictionless())
    case ('load')
      select case (key)
      case ('teeth', 'tooth_pairs', 'pressure_angle_deg', 'spline_width')
        is_idle = .not. (s%support%struts .or. s%support%against_teeth .or. s%torque_load == 'teeth')
      case ('tooth_stiffness', 'tooth_gaps', 'tooth_gaps_back', 'tooth_clearance')
        is_idle = .not. (s%support%struts .or. s%support%against_teeth)
      case ('spline', 'spline_diameter', 'spline_root_diameter')
        is_idle = .not. s%support%struts .or. (key /= 'spline' .and. s%spline == 'rigid')
      end select
    case ('joint')
      select case (key)
      case ('table_file')
        is_idle = named_model .and. s%joint_model /= 'table' .and. s%joint_model /= 'boundary_elements'
      case ('spectrum_file')
        is_idle = named_model .and. s%joint_model /= 'spectrum'
      case ('asperity_radius', 's_min', 'gamma', 'closure', 'plastic_spots')
        is_idle = named_model .and. s%joint_model /= 'hu2023'
      end select
    end select
  end function is_idle
end module hd_idle_keys
