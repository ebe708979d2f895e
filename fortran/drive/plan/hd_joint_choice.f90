! SPDX-License-Identifier: GPL-3.0-or-later
!> joint.model = 'auto': theory where it holds for the surface and the pressures of the scene, else the table of boundary elements.
!>
!> The pressures come from a coarse trial with the joint by theory, before the scene is planned or run. What is chosen stands in the
!> scene, and the scene is then one that names its model.
module hd_joint_choice
  use hd_kinds, only: dp
  use hd_error, only: error_t, code_not_converged
  use hd_joint, only: joint_t
  use hd_load_path, only: path_end
  use hd_log, only: say, set_log_level, quiet
  use hd_march, only: march
  use hd_mesh_series, only: coarse, meshed, small_displacements
  use hd_model, only: give_back
  use hd_run, only: run_t, new_run, close_run
  use hd_scene, only: scene_t
  use hd_scene_joint, only: scene_joint
  use hd_section, only: band_rows
  use hd_text, only: percent, rounded
  use hd_persson_error, only: theory_error_t, in_words, may_be_taken, steep, trust
  implicit none
  private
  public :: choose_joint

  integer, parameter :: few = 2  !< load steps of each leg of a loop, and of the torque

contains

  !> Name the model of a scene that leaves it open.
  subroutine choose_joint(scene, error)
    type(scene_t), intent(inout) :: scene             !< gets its model, the reason and what speaks against it
    type(error_t), allocatable, intent(out) :: error  !< spectrum, table, whatever ended the trial early
    type(theory_error_t) :: found
    type(scene_t) :: other
    type(joint_t) :: joint
    logical :: table
    if (scene%surface_only .or. scene%joint_model /= 'auto') return
    scene%joint_model = 'spectrum'
    table = len_trim(scene%joint_table) > 0
    if (table) then
      other = scene
      other%joint_model = 'boundary_elements'
      call scene_joint(other, joint, error)
      if (allocated(error)) return
    end if
    if (.not. scene%support%contact) then
      scene%joint_reason = 'no joint takes part'
      return
    end if
    call try_theory(scene, found, error)
    if (allocated(error)) then
      if (error%code /= code_not_converged) return
      deallocate (error)
    end if
    call decide(found, table, scene)
    if (.not. scene%planned_tolerance > 0) call say('joint     '//trim(scene%joint_model)//': '//trim(scene%joint_reason))
  end subroutine choose_joint

  !> Error of the theory at the last load step of a coarse trial.
  subroutine try_theory(scene, found, error)
    type(scene_t), intent(in) :: scene                !< scene with the joint by theory
    type(theory_error_t), intent(out) :: found        !< its area is 0 where nothing touches
    type(error_t), allocatable, intent(out) :: error  !< whatever ended it early
    type(error_t), allocatable :: trouble
    type(run_t), allocatable :: run
    type(scene_t) :: s
    integer :: level
    s = meshed(scene, coarse(scene))
    if (s%divisions*band_rows(s) >= scene%divisions*band_rows(scene)) s = scene
    s = small_displacements(s)
    s%planned_tolerance = 0
    s%turning_positions = 0
    s%torque_steps = min(s%torque_steps, few)
    if (.not. s%support%loop) s%assembly_steps = 1
    call set_log_level(quiet, level)
    allocate (run)
    call new_run(s, '', '', .false., run, error)
    run%asks_tangent = .false.
    if (.not. allocated(error)) call march(run, path_end(run%scene), error)
    if (run%step%number > 0) found = run%sums%theory
    call close_run(run, trouble)
    call give_back(run%model)
    call set_log_level(level)
  end subroutine try_theory

  !> The rule.
  subroutine decide(found, table, scene)
    type(theory_error_t), intent(in) :: found  !< error of the theory on the contact
    logical, intent(in) :: table               !< there is a table of boundary elements
    type(scene_t), intent(inout) :: scene      !< gets model, reason, doubt
    scene%joint_reason = in_words(found)
    if (.not. found%area > 0) scene%joint_reason = 'a coarse trial did not converge or nothing touches, so the pressures are '// &
      'not known'
    if (may_be_taken(found)) return
    if (table) then
      scene%joint_model = 'boundary_elements'
    else
      scene%joint_doubt = 'the theory is taken for want of a table of boundary elements, though not within its rule ('// &
        percent(trust)//', '//rounded(steep)//' hardnesses): '//trim(scene%joint_reason)
      if (found%area > 0) scene%joint_doubt = trim(scene%joint_doubt)//'. '//remedy(found)
    end if
  end subroutine decide

  !> The command that makes the table, at pressures about those of the scene.
  function remedy(found) result(text)
    type(theory_error_t), intent(in) :: found  !< pressures
    character(len=:), allocatable :: text
    real(dp), parameter :: about(5) = [0.1_dp, 0.3_dp, 1._dp, 3._dp, 10._dp]
    integer :: i
    text = ''
    do i = 1, size(about)
      text = text//','//rounded(about(i)*found%pressure)
    end do
    text = "With maps of both faces: 'hdengine joint MAP MAP --model boundary_elements --pressure "//text(2:)// &
      " --loaded-area "//rounded(found%area)//" --out DIR', then joint.table_file=DIR/joint.csv"
    if (found%steepness > steep) text = text//'; on so steep faces it may not converge'
  end function remedy
end module hd_joint_choice
