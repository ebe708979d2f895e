! SPDX-License-Identifier: GPL-3.0-or-later
module test_parameters
  use hd_check, only: check
  use hd_parameter_row, only: stage_model, stage_assembly, stage_load, stage_control, stage_output
  use hd_parameters, only: parameter_table_t, new_table
  use hd_scene, only: scene_t
  implicit none
  private
  public :: run_parameters

contains

  subroutine run_parameters()
    type(scene_t), target :: scene
    type(parameter_table_t) :: table
    integer :: i
    call new_table(scene, table)
    do i = 1, size(table%rows)
      call check(table%rows(i)%stage(.false., .false.) > 0, &
        'the table says what '//table%rows(i)%group//'.'//table%rows(i)%key//' affects')
    end do
    call check(stage('mesh', 'divisions') == stage_model .and. stage('load', 'assembly_steps') == stage_assembly .and. &
      stage('load', 'torque') == stage_load .and. stage('solver', 'time_limit_s') == stage_control .and. &
      stage('output', 'vtu') == stage_output, 'mesh, assembly, torque, time limit and files each affect their own stage')
    call check(stage('wave_generator', 'w') == stage_assembly .and. stage('wave_generator', 'w', formed=.true.) == stage_model, &
      'w affects the mesh only of bodies formed to the cam')
    call check(stage('joint', 'roughness') == stage_load .and. stage('joint', 'roughness', joint_law=.true.) == stage_assembly, &
      'the joint affects the assembly only where it is the contact law')
    call check(all([changes('solver', 'max_iterations'), changes('solver', 'time_limit_s'), changes('output', 'vtu'), &
      changes('mesh', 'memory_limit_mb'), .not. changes('load', 'torque'), .not. changes('joint', 'roughness'), &
      .not. changes('wave_generator', 'w'), .not. changes('mesh', 'divisions')]), &
      'a stopped run goes on with other limits and other output, with no other torque, joint, cam or mesh')
  contains
    integer function stage(group, key, formed, joint_law)
      character(len=*), intent(in) :: group, key
      logical, intent(in), optional :: formed, joint_law
      stage = table%rows(table%find(group, key))%stage(present(formed), present(joint_law))
    end function stage

    logical function changes(group, key)
      character(len=*), intent(in) :: group, key
      changes = table%rows(table%find(group, key))%may_change()
    end function changes
  end subroutine run_parameters
end module test_parameters
