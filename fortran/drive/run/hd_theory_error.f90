! SPDX-License-Identifier: GPL-3.0-or-later
!> What the error of the joint's theory is on the contact that a run found, and by how much it moves the tangent K_TS.
module hd_theory_error
  use hd_kinds, only: dp
  use hd_checkpoint, only: flexibility_t
  use hd_contact_law, only: stick_state
  use hd_coupled_tangent, only: answer_t, coupled_response
  use hd_drive, only: drive_t, drive_load, step_friction
  use hd_elastic_law, only: scaled_law
  use hd_error, only: error_t
  use hd_joint, only: joint_t, at_friction
  use hd_lapack, only: blas_threads
  use hd_linear_solver, only: linear_solver_t
  use hd_problem, only: load_t, state_t, update_tangent
  use hd_scene, only: scene_t
  use hd_persson_error, only: theory_error_t, theory_error_of, steep
  implicit none
  private
  public :: theory_on, move_tangent

contains

  !> Error of the theory on a contact; none for a joint that is not by theory.
  pure function theory_on(joint, drive, state) result(found)
    type(joint_t), intent(in) :: joint   !< joint
    type(drive_t), intent(in) :: drive   !< drive
    type(state_t), intent(in) :: state   !< converged state
    type(theory_error_t) :: found
    integer :: m
    if (.not. allocated(joint%theory)) return
    m = drive%problem%mortar%n - drive%problem%mortar%rigid
    found = theory_error_of(joint%theory, state%traction(1, :m), drive%problem%mortar%area(:m), state%contact(:m) == stick_state)
  end function theory_on

  !> Change of the tangent K_TS if k_N is softer by the error; half as stiff where the error is not known. The pressures stay.
  subroutine move_tangent(scene, drive, solver, joint, flexibility, before, state, found, error)
    type(scene_t), intent(in) :: scene                !< scene, at the end of its torque
    type(drive_t), intent(inout) :: drive             !< drive
    class(linear_solver_t), intent(inout) :: solver   !< its linear solver
    type(joint_t), intent(in) :: joint                !< joint by theory
    type(flexibility_t), intent(in) :: flexibility    !< of the last load step
    type(state_t), intent(in) :: before, state        !< last two converged states
    type(theory_error_t), intent(inout) :: found      !< gets the change
    type(error_t), allocatable, intent(out) :: error  !< of the solver, or a signal: the change is not known
    type(joint_t) :: softer
    type(load_t) :: load
    type(answer_t) :: now
    integer :: threads
    if (.not. (found%area > 0 .and. flexibility%known .and. .not. scene%support%loop)) return
    call drive_load(drive, 1._dp, flexibility%torque, step_friction(scene, .true.), load, state, before)
    call update_tangent(drive%problem, state%u)
    threads = 0
    if (solver%own_threads) threads = blas_threads(1)
    softer = at_friction(joint, load%friction)
    softer%elastic = scaled_law(joint%elastic, merge(0.5_dp, exp(-found%half_width), found%steepness > steep))
    call coupled_response(drive, solver, softer, load, sign(1._dp, scene%torque), state, now, error)
    if (solver%own_threads) threads = blas_threads(threads)
    if (allocated(error) .or. .not. (now%settled .and. now%flexibility > flexibility%glued)) return
    found%tangent = (flexibility%coupled - flexibility%glued)/(now%flexibility - flexibility%glued) - 1
  end subroutine move_tangent
end module hd_theory_error
