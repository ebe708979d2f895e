! SPDX-License-Identifier: GPL-3.0-or-later
!> The linear solver of a scene: the cheapest by prediction among those that apply and are allowed.
module hd_solver_choice
  use hd_circulant, only: circulant_t, new_circulant, has_circulant
  use hd_condensed, only: condensed_t, new_condensed
  use hd_cost, only: forecast_t, forecast, cost_text
  use hd_drive, only: drive_t, new_drive
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_log, only: say
  use hd_newton_krylov, only: newton_krylov_t, new_newton_krylov
  use hd_newton_matrix, only: newton_matrix_t, new_newton_matrix
  use hd_problem, only: problem_t, assemble_stiffness
  use hd_scene, only: scene_t
  implicit none
  private
  public :: choose_solver, renew_solver, forgets_struts

contains

  !> Choose, say why, and make.
  subroutine choose_solver(scene, drive, solver, choice, error)
    type(scene_t), intent(in) :: scene                            !< scene
    type(drive_t), intent(inout) :: drive                         !< its problem
    class(linear_solver_t), allocatable, intent(out) :: solver    !< ready to use
    type(forecast_t), intent(out) :: choice                       !< what was predicted, and the solver that was made
    type(error_t), allocatable, intent(out) :: error              !< does not apply, body not held, memory
    choice = forecast(scene, scene%formed() .or. has_circulant(drive%problem))
    if (count(choice%costs%applies) > 1) call say('solver    predicted: '//cost_text(choice%costs))
    select case (choice%costs(choice%chosen)%name)
    case ('condensed')
      call make_condensed(drive%problem, solver, error)
    case ('exact')
      call make_exact(drive%problem, solver, error)
    case default
      call make_krylov(scene, drive, solver, error)
    end select
    if (.not. allocated(error)) call renew_solver(scene, solver)
  end subroutine choose_solver

  !> Condensation to the face, bodies by harmonics.
  subroutine make_condensed(problem, solver, error)
    type(problem_t), intent(in) :: problem                        !< problem
    class(linear_solver_t), allocatable, intent(out) :: solver    !< solver
    type(error_t), allocatable, intent(out) :: error              !< bodies are not round, inverted element
    type(circulant_t), pointer :: circulant
    type(condensed_t), allocatable :: condensed
    allocate (circulant)
    call new_circulant(problem, circulant, error)
    if (allocated(error)) return
    allocate (condensed)
    call new_condensed(problem, circulant, condensed)
    call move_alloc(condensed, solver)
  end subroutine make_condensed

  !> Newton's matrix itself.
  subroutine make_exact(problem, solver, error)
    type(problem_t), intent(inout) :: problem                     !< problem; gets its sparse stiffness
    class(linear_solver_t), allocatable, intent(out) :: solver    !< solver
    type(error_t), allocatable, intent(out) :: error              !< memory
    type(newton_matrix_t), allocatable :: matrix
    allocate (matrix)
    call new_newton_matrix(problem, matrix, error)
    call move_alloc(matrix, solver)
  end subroutine make_exact

  !> GMRES around condensation of the round bodies.
  subroutine make_krylov(scene, drive, solver, error)
    type(scene_t), intent(in) :: scene                            !< scene
    type(drive_t), intent(inout) :: drive                         !< its problem; gets its sparse stiffness
    class(linear_solver_t), allocatable, intent(out) :: solver    !< solver
    type(error_t), allocatable, intent(out) :: error              !< bodies are not round, inverted element
    class(linear_solver_t), allocatable :: near
    type(newton_krylov_t), allocatable :: krylov
    type(scene_t) :: pressed
    type(drive_t) :: round
    allocate (krylov)
    if (scene%formed()) then
      pressed = scene
      pressed%shape = 'pressed'
      call new_drive(pressed, round, error)
      if (.not. allocated(error)) call make_condensed(round%problem, near, error)
      if (allocated(round%problem%pairing)) deallocate (round%problem%pairing)
      krylov%round = round%problem
    else
      call assemble_stiffness(drive%problem, error)
      if (.not. allocated(error)) call make_condensed(drive%problem, near, error)
      if (allocated(drive%problem%pairing)) then
        krylov%round = drive%problem
        deallocate (krylov%round%lagrangian, krylov%round%pairing, krylov%round%stiffness%val)
        deallocate (drive%problem%stiffness%val)  ! GMRES gets along with products
      end if
    end if
    if (allocated(error)) return
    call new_newton_krylov(near, krylov)
    call move_alloc(krylov, solver)
  end subroutine make_krylov

  !> Give up what a solver knows of balls and teeth, if that leaves the rest: bodies condensed to their face do not know them.
  logical function forgets_struts(solver)
    class(linear_solver_t), intent(inout) :: solver   !< solver
    select type (solver)
    type is (condensed_t)
      if (allocated(solver%border)) deallocate (solver%border)
      forgets_struts = .true.
    class default
      forgets_struts = .false.
    end select
  end function forgets_struts

  !> Enter what `solver.symmetry` allows or asks for; counts start again.
  subroutine renew_solver(scene, solver)
    type(scene_t), intent(in) :: scene                !< scene
    class(linear_solver_t), intent(inout) :: solver   !< solver
    solver%inner = 0
    solver%most_images = scene%most_images()
    solver%demanded = solver%most_images > 1 .and. scene%symmetry /= 'auto'
  end subroutine renew_solver
end module hd_solver_choice
