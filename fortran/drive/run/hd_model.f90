! SPDX-License-Identifier: GPL-3.0-or-later
!> The model of a run: mesh, coupling, factors, and what is known of the assembly. A run hands it on to one that differs in nothing
!> they depend on: a study over torque, eccentricity, w, interference, friction or joint parameters so pays for them once.
module hd_model
  use hd_cost, only: forecast_t
  use hd_drive, only: drive_t, new_drive, renew_drive
  use hd_error, only: error_t
  use hd_joint, only: joint_t
  use hd_linear_solver, only: linear_solver_t
  use hd_kinds, only: dp
  use hd_parameter_row, only: stage_model, stage_assembly
  use hd_parameters, only: parameter_table_t, new_table, value_text
  use hd_problem, only: use_lagrangian, move_state, state_t
  use hd_scene, only: scene_t
  use hd_solver_choice, only: choose_solver, forgets_struts, renew_solver
  implicit none
  private
  public :: model_t, fit_model, hand_on, forget_states, give_back

  !> Converged states of an assembly, for later runs that differ in their torque only; for first guesses of a finer mesh also those
  !> under torque.
  type :: assembly_t
    real(dp), allocatable :: place(:, :)     !< fractions of the assembly, torques [N m] (2, states)
    type(state_t), allocatable :: state(:)   !< states there
  contains
    procedure :: add => add_state
    procedure :: recall
  end type assembly_t

  type :: model_t
    type(scene_t) :: scene                              !< that it was fitted to last
    type(joint_t) :: joint                              !< of that scene
    logical :: kept = .false.                           !< mesh and factors are those of an earlier run
    type(drive_t) :: drive                              !< its problem and loads
    class(linear_solver_t), allocatable :: solver       !< its linear solver
    type(assembly_t) :: assembly                        !< states of the assembly, also of an earlier run
    type(forecast_t) :: choice                          !< what was predicted when the solver was chosen
  end type model_t

contains

  !> Fit the model of an earlier run to a scene, or make a new one.
  subroutine fit_model(scene, model, error)
    type(scene_t), intent(in) :: scene                    !< scene
    type(model_t), allocatable, intent(inout) :: model    !< of an earlier run or none; none after an error
    type(error_t), allocatable, intent(out) :: error      !< mesh, memory
    logical :: kept
    kept = .false.
    if (allocated(model)) kept = same_model(scene, model%scene, .false., .false.)
    if (kept) kept = scene%frictionless() .eqv. model%scene%frictionless()  ! soft springs hold a ring that no friction does
    if (kept) then
      if (struts_move(scene, model%scene)) kept = forgets_struts(model%solver)
    end if
    if (kept) then
      if (.not. same_model(scene, model%scene, .true., allocated(model%drive%problem%law%joint))) model%assembly = assembly_t()
      call renew_drive(scene, model%drive, error)
      call renew_solver(scene, model%solver)
    else
      call give_back(model)
      allocate (model)
      call new_drive(scene, model%drive, error)
      if (.not. allocated(error) .and. scene%large()) call use_lagrangian(model%drive%problem, error)
      if (.not. allocated(error)) call choose_solver(scene, model%drive, model%solver, model%choice, error)
    end if
    model%scene = scene
    model%kept = kept
    if (allocated(error)) call give_back(model)
  end subroutine fit_model

  !> Hand a model on, in place of what is there; one with large displacements is given back, its stiffness has changed.
  subroutine hand_on(from, to)
    type(model_t), allocatable, intent(inout) :: from   !< moved away
    type(model_t), allocatable, intent(inout) :: to     !< gets it, if there is one
    if (.not. allocated(from)) return
    call give_back(to)
    if (allocated(from%drive%problem%lagrangian)) call give_back(from)
    call move_alloc(from, to)
  end subroutine hand_on

  !> Forget the states of earlier runs: what comes next is as in a process that has solved nothing before.
  subroutine forget_states(model)
    type(model_t), allocatable, intent(inout) :: model  !< keeps mesh and factors, if there is one
    if (allocated(model)) model%assembly = assembly_t()
  end subroutine forget_states

  !> Give back the memory of a model.
  subroutine give_back(model)
    type(model_t), allocatable, intent(inout) :: model  !< none afterwards
    if (.not. allocated(model)) return
    if (allocated(model%solver)) call model%solver%release()
    deallocate (model)
  end subroutine give_back

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
      call move_state(self%state(i), longer(i))
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
    logical, intent(out) :: found              !< there is such a state
    integer :: i
    i = 0
    if (allocated(self%place)) i = find(self, fraction, torque)
    if (i > 0) state = self%state(i)
    found = i > 0
  end subroutine recall

  !> Number of the state at a place, 0 if there is none.
  pure integer function find(self, fraction, torque)
    type(assembly_t), intent(in) :: self       !< states
    real(dp), intent(in) :: fraction, torque   !< place
    real(dp), parameter :: same = 1e-12_dp     !< rounding of a place
    find = findloc(abs(self%place(1, :) - fraction) < same .and. abs(self%place(2, :) - torque) <= same*abs(torque), &
      .true., 1)
  end function find

  !> Balls or teeth of two scenes of one model stand in other places, or those of one scene rub.
  pure logical function struts_move(a, b)
    type(scene_t), intent(in) :: a, b  !< scenes
    struts_move = a%support%struts .and. (abs(a%cage_angle_deg - b%cage_angle_deg) > 0 .or. &
      abs(a%tooth_phase - b%tooth_phase) > 0 .or. (a%tooth_friction > 0 .neqv. b%tooth_friction > 0))
  end function struts_move

  !> Two scenes agree in every key that affects the model (and the assembly), and in what the tables hold that keys name.
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
    same_model = a%files == b%files
    do i = 1, size(one%rows)
      if (one%rows(i)%stage(a%formed(), joint) > last) cycle
      same_model = same_model .and. value_text(one%rows(i)) == value_text(two%rows(i))
    end do
  end function same_model
end module hd_model
