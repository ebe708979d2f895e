! SPDX-License-Identifier: GPL-3.0-or-later
!> Which linear solver a scene gets: condensation to the face where it applies, the sparse Newton matrix elsewhere.
module hd_solver_choice
  use hd_circulant, only: circulant_t, new_circulant, has_circulant
  use hd_compliance, only: compliance_t
  use hd_condensed, only: condensed_t, new_condensed
  use hd_drive, only: drive_t, new_drive
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_newton_krylov, only: newton_krylov_t, new_newton_krylov
  use hd_newton_matrix, only: newton_matrix_t, new_newton_matrix
  use hd_symmetric_matrix, only: symmetric_matrix_t, new_symmetric_matrix
  use hd_problem, only: assemble_stiffness
  use hd_schur, only: schur_t, new_schur
  use hd_scene, only: scene_t
  implicit none
  private
  public :: choose_solver, renew_solver

contains

  !> Make the solver that `solver.method` asks for, or the cheaper one.
  subroutine choose_solver(scene, drive, solver, error)
    type(scene_t), intent(in) :: scene                            !< scene
    type(drive_t), intent(inout) :: drive                         !< its problem
    class(linear_solver_t), allocatable, intent(out) :: solver    !< ready to use
    type(error_t), allocatable, intent(out) :: error              !< does not apply, body not held, memory
    class(compliance_t), pointer :: compliance
    type(circulant_t), pointer :: circulant
    type(schur_t), pointer :: schur
    type(condensed_t), allocatable :: condensed
    nullify (compliance)
    if (scene%method == 'condensed' .or. (scene%method == 'auto' .and. scene%support /= 'teeth' .and. &
      scene%kinematics /= 'nonlinear' .and. has_circulant(drive%problem))) then
      allocate (circulant)
      call new_circulant(drive%problem, circulant, error)
      if (allocated(error)) return
      compliance => circulant
    else if (scene%method == 'schur') then
      allocate (schur)
      call new_schur(drive%problem, schur, error)
      if (allocated(error)) return
      compliance => schur
    end if
    if (associated(compliance)) then
      allocate (condensed)
      call new_condensed(drive%problem, compliance, condensed)
      call move_alloc(condensed, solver)
    else
      call choose_factors(scene, drive, solver, error)
    end if
    if (allocated(error)) return
    call renew_solver(scene, solver)
  end subroutine choose_solver

  !> Factors of the Newton matrix.
  subroutine choose_factors(scene, drive, solver, error)
    type(scene_t), intent(in) :: scene                            !< scene
    type(drive_t), intent(inout) :: drive                         !< its problem
    class(linear_solver_t), allocatable, intent(out) :: solver    !< ready to use
    type(error_t), allocatable, intent(out) :: error              !< does not apply, body not held, memory
    type(newton_matrix_t), allocatable :: exact
    type(symmetric_matrix_t), allocatable :: part
    type(circulant_t), pointer :: circulant
    class(compliance_t), pointer :: compliance
    type(condensed_t), allocatable :: condensed
    type(newton_krylov_t), allocatable :: krylov
    class(linear_solver_t), allocatable :: near
    type(scene_t) :: pressed
    type(drive_t) :: round
    select case (scene%factors)
    case ('symmetric', 'single')
      allocate (part)
      call new_symmetric_matrix(drive%problem, scene%factors == 'single', part, error)
      if (allocated(error)) return
      call move_alloc(part, near)
    case ('harmonic')
      call assemble_stiffness(drive%problem, error)
      allocate (circulant)
      if (scene%shape == 'as_formed') then
        pressed = scene
        pressed%shape = 'pressed'
        call new_drive(pressed, round, error)
        if (.not. allocated(error)) call new_circulant(round%problem, circulant, error)
      else if (.not. allocated(error)) then
        call new_circulant(drive%problem, circulant, error)
      end if
      if (allocated(error)) return
      compliance => circulant
      allocate (condensed)
      if (scene%shape == 'as_formed') then
        call new_condensed(round%problem, compliance, condensed)
      else
        call new_condensed(drive%problem, compliance, condensed)
      end if
      call move_alloc(condensed, near)
    case default
      allocate (exact)
      call new_newton_matrix(drive%problem, exact, error)
      call move_alloc(exact, solver)
      return
    end select
    allocate (krylov)
    call new_newton_krylov(near, krylov)
    if (scene%factors == 'harmonic' .and. scene%shape == 'as_formed') krylov%round = round%problem
    call move_alloc(krylov, solver)
  end subroutine choose_factors

  !> Enter what `solver.symmetry` allows or asks for; counts start again.
  subroutine renew_solver(scene, solver)
    type(scene_t), intent(in) :: scene                !< scene
    class(linear_solver_t), intent(inout) :: solver   !< solver
    solver%inner = 0
    solver%most_images = 4
    if (scene%symmetry == 'half') solver%most_images = 2
    if (scene%symmetry == 'full') solver%most_images = 1
    solver%demanded = scene%symmetry == 'half' .or. scene%symmetry == 'quarter'
  end subroutine renew_solver
end module hd_solver_choice
