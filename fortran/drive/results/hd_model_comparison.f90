! SPDX-License-Identifier: GPL-3.0-or-later
!> K_TS (Eq. 45) of one state by every model of the joint that the scene has the inputs of, and what each model rests on.
!>
!> The pressures are those of the run: under a joint's contact law they are the chosen model's.
module hd_model_comparison
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_drive, only: drive_t
  use hd_error, only: error_t
  use hd_facets, only: facets_t, sums_t, evaluate_facets, sum_stiffness
  use hd_joint, only: joint_t, at_friction
  use hd_json, only: json_t
  use hd_problem, only: state_t
  use hd_scene, only: scene_t
  use hd_scene_joint, only: scene_joint
  implicit none
  private
  public :: compare_models, add_models

  character(len=17), parameter :: models(4) = [character(len=17) :: 'hu2023', 'spectrum', 'boundary_elements', 'table']

contains

  !> K_TS by each of `models` [N m/rad]; NaN where the scene lacks its inputs.
  function compare_models(scene, drive, state, torque, sums) result(k_ts)
    type(scene_t), intent(in) :: scene    !< scene
    type(drive_t), intent(in) :: drive    !< drive
    type(state_t), intent(in) :: state    !< converged state
    real(dp), intent(in) :: torque        !< of the step [N m]
    type(sums_t), intent(in) :: sums      !< of the step
    real(dp) :: k_ts(size(models))
    type(scene_t) :: other
    type(joint_t) :: joint
    type(facets_t) :: facets
    type(sums_t) :: found
    type(error_t), allocatable :: error
    logical :: offered   !< a table that the choice of the model did not take
    integer :: i
    offered = len_trim(scene%joint_reason) > 0 .and. len_trim(scene%joint_table) > 0
    k_ts = ieee_value(1._dp, ieee_quiet_nan)
    if (.not. scene%support%contact) return
    do i = 1, size(models)
      if (models(i) == scene%joint_model) k_ts(i) = sums%k_ts
      if (models(i) == scene%joint_model .or. (i > 2 .and. .not. (offered .and. models(i) == 'boundary_elements'))) cycle
      other = scene
      other%joint_model = models(i)
      call scene_joint(other, joint, error)
      if (allocated(error)) cycle
      call evaluate_facets(drive, at_friction(joint, sums%friction), state, facets)
      found = sums
      call sum_stiffness(scene, drive, torque, state, facets, found)
      k_ts(i) = found%k_ts
    end do
  end function compare_models

  !> What a model's K_N rests on, in a line.
  pure function rests_on(scene) result(text)
    type(scene_t), intent(in) :: scene  !< scene
    character(len=:), allocatable :: text
    select case (scene%joint_model)
    case ('spectrum')
      text = 'D, G, sample_length, shortest_wavelength, E*, hardness'
      if (len_trim(scene%joint_spectrum) > 0) text = 'the spectrum in '//trim(scene%joint_spectrum)//', E*, hardness'
    case ('boundary_elements', 'table')
      text = 'the table '//trim(scene%joint_table)
    case default
      text = 'D, G, gamma, E*, hardness, and the unmeasured asperity_radius and s_min'
    end select
  end function rests_on

  !> The block of the summary.
  subroutine add_models(json, scene, k_ts)
    type(json_t), intent(inout) :: json    !< document
    type(scene_t), intent(in) :: scene     !< scene
    real(dp), intent(in) :: k_ts(:)        !< by `models`
    integer :: i
    call json%begin('k_ts_by_model')
    call json%add('chosen', trim(scene%joint_model))
    call json%add('chosen_rests_on', rests_on(scene))
    do i = 1, size(models)
      if (k_ts(i) >= 0) call json%add(trim(models(i))//'_nm_per_rad', k_ts(i))
    end do
    call json%finish()
  end subroutine add_models
end module hd_model_comparison
