! SPDX-License-Identifier: GPL-3.0-or-later
!> The model of the last run: mesh, coupling and factors, kept for the next run of this process if that differs in nothing
!> they depend on. A study over torque, eccentricity, w, interference, friction or joint parameters so pays for them once.
module hd_model_cache
  use hd_cost, only: forecast_t
  use hd_drive, only: drive_t, frictionless, new_drive, renew_drive
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_kinds, only: dp
  use hd_parameter_row, only: stage_model, stage_assembly
  use hd_parameters, only: parameter_table_t, new_table, value_text
  use hd_problem, only: use_lagrangian, state_t
  use hd_scene, only: scene_t
  use hd_solver_choice, only: choose_solver, forgets_struts, renew_solver
  implicit none
  private
  public :: take_model, keep_model, forget_model, put_aside, take_back, assembly_t

  !> Converged states of an assembly, for later runs that differ in their torque only; of a planned run also those under torque.
  type :: assembly_t
    real(dp), allocatable :: place(:, :)     !< fractions of the assembly, torques [N m] (2, states)
    type(state_t), allocatable :: state(:)   !< states there
  contains
    procedure :: add => add_state
    procedure :: recall
  end type assembly_t

  type(scene_t), save :: kept_scene
  type(drive_t), allocatable, save :: kept_drive
  class(linear_solver_t), allocatable, save :: kept_solver
  type(assembly_t), save :: kept_assembly
  type(forecast_t), save :: kept_choice

  !> A kept model that a trial run leaves alone.
  type :: model_t
    type(scene_t) :: scene
    type(drive_t), allocatable :: drive
    class(linear_solver_t), allocatable :: solver
    type(assembly_t) :: assembly
    type(forecast_t) :: choice
  end type model_t
  type(model_t), save :: aside

contains

  !> Model of a scene: the kept one, or a new one.
  subroutine take_model(scene, drive, solver, assembly, kept, choice, error)
    type(scene_t), intent(in) :: scene                            !< scene
    type(drive_t), allocatable, intent(out) :: drive              !< its problem and loads
    class(linear_solver_t), allocatable, intent(out) :: solver    !< its linear solver
    type(assembly_t), intent(out) :: assembly                     !< states of the same assembly, if there are any
    logical, intent(out) :: kept                                  !< mesh and factors are those of an earlier run
    type(forecast_t), intent(out) :: choice                       !< what was predicted when the solver was chosen
    type(error_t), allocatable, intent(out) :: error              !< mesh, memory
    kept = .false.
    if (allocated(kept_drive)) kept = same_model(scene, kept_scene, .false., .false.)
    if (kept) kept = frictionless(scene) .eqv. frictionless(kept_scene)  ! soft springs hold a ring that no friction does
    if (kept .and. struts_move(scene, kept_scene)) kept = forgets_struts(kept_solver)
    if (kept) then
      if (same_model(scene, kept_scene, .true., allocated(kept_drive%problem%law%joint))) assembly = kept_assembly
      call move_alloc(kept_drive, drive)
      call move_alloc(kept_solver, solver)
      choice = kept_choice
      call renew_drive(scene, drive, error)
      call renew_solver(scene, solver)
    else
      call forget_model()
      allocate (drive)
      call new_drive(scene, drive, error)
      if (.not. allocated(error) .and. scene%kinematics == 'nonlinear') call use_lagrangian(drive%problem, error)
      if (.not. allocated(error)) call choose_solver(scene, drive, solver, choice, error)
    end if
  end subroutine take_model

  !> Keep the model of a run that is over; one with large displacements is given back, its stiffness has changed.
  subroutine keep_model(scene, drive, solver, assembly, choice)
    type(scene_t), intent(in) :: scene                              !< its scene
    type(drive_t), allocatable, intent(inout) :: drive              !< moved away
    class(linear_solver_t), allocatable, intent(inout) :: solver    !< moved away
    type(assembly_t), intent(in) :: assembly                        !< states of its assembly
    type(forecast_t), intent(in) :: choice                          !< of its solver
    call forget_model()
    if (.not. allocated(solver)) return
    if (allocated(drive%problem%lagrangian)) then
      call solver%release()
      return
    end if
    kept_scene = scene
    kept_assembly = assembly
    kept_choice = choice
    call move_alloc(drive, kept_drive)
    call move_alloc(solver, kept_solver)
  end subroutine keep_model

  !> Put the kept model aside for the time of a trial run.
  subroutine put_aside()
    aside%scene = kept_scene
    aside%assembly = kept_assembly
    aside%choice = kept_choice
    call move_alloc(kept_drive, aside%drive)
    call move_alloc(kept_solver, aside%solver)
  end subroutine put_aside

  !> Forget the model of the trial; the one before is kept again, if there was one.
  subroutine take_back()
    call forget_model()
    if (.not. allocated(aside%drive)) return
    kept_scene = aside%scene
    kept_assembly = aside%assembly
    kept_choice = aside%choice
    call move_alloc(aside%drive, kept_drive)
    call move_alloc(aside%solver, kept_solver)
  end subroutine take_back

  !> Give back the memory of the kept model.
  subroutine forget_model()
    if (allocated(kept_solver)) call kept_solver%release()
    if (allocated(kept_solver)) deallocate (kept_solver)
    if (allocated(kept_drive)) deallocate (kept_drive)
  end subroutine forget_model

  !> Keep a converged state, once.
  subroutine add_state(self, fraction, torque, state)
    class(assembly_t), intent(inout) :: self  !< grows
    real(dp), intent(in) :: fraction          !< of the assembly
    real(dp), intent(in) :: torque            !< [N m]
    type(state_t), intent(in) :: state        !< state there
    type(state_t), allocatable :: longer(:)
    integer :: i, n
    if (.not. allocated(self%place)) allocate (self%place(2, 0), self%state(0))
    if (find(self, fraction, torque) > 0) return
    n = size(self%state)
    allocate (longer(n + 1))
    do i = 1, n
      longer(i) = self%state(i)
    end do
    longer(n + 1) = state
    call move_alloc(longer, self%state)
    self%place = reshape([self%place, fraction, torque], [2, n + 1])
  end subroutine add_state

  !> Replace a first guess by the state that was found at the same place before.
  subroutine recall(self, fraction, torque, state, found)
    class(assembly_t), intent(in) :: self      !< states
    real(dp), intent(in) :: fraction           !< of the assembly
    real(dp), intent(in) :: torque             !< [N m]
    type(state_t), intent(inout) :: state      !< guess
    logical, intent(out), optional :: found    !< there is such a state
    integer :: i
    i = 0
    if (allocated(self%place)) i = find(self, fraction, torque)
    if (i > 0) state = self%state(i)
    if (present(found)) found = i > 0
  end subroutine recall

  !> Number of the state at a place, 0 if there is none.
  pure integer function find(self, fraction, torque)
    type(assembly_t), intent(in) :: self       !< states
    real(dp), intent(in) :: fraction, torque   !< place
    find = findloc(abs(self%place(1, :) - fraction) < 1e-12_dp .and. abs(self%place(2, :) - torque) <= 1e-12_dp*abs(torque), &
      .true., 1)
  end function find

  !> Balls or teeth of two scenes of one model stand in other places, or those of one scene rub.
  pure logical function struts_move(a, b)
    type(scene_t), intent(in) :: a, b  !< scenes
    struts_move = a%support == 'drive' .and. (abs(a%cage_angle_deg - b%cage_angle_deg) > 0 .or. &
      abs(a%tooth_phase - b%tooth_phase) > 0 .or. (a%tooth_friction > 0 .neqv. b%tooth_friction > 0))
  end function struts_move

  !> Two scenes agree in every key that affects the model (and the assembly).
  logical function same_model(a, b, assembly, joint)
    type(scene_t), intent(in) :: a, b  !< scenes
    logical, intent(in) :: assembly    !< their loads up to the torque must be the same too
    logical, intent(in) :: joint       !< the joint's parameters are part of the contact law
    type(scene_t), target :: first, second
    type(parameter_table_t) :: one, two
    integer :: i, last
    first = a
    second = b
    call new_table(first, one)
    call new_table(second, two)
    last = merge(stage_assembly, stage_model, assembly)
    same_model = .true.
    do i = 1, size(one%rows)
      if (one%rows(i)%stage(a%shape /= 'pressed', joint) > last) cycle
      same_model = same_model .and. value_text(one%rows(i)) == value_text(two%rows(i))
    end do
  end function same_model
end module hd_model_cache
