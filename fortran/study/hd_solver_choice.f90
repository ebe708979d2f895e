! SPDX-License-Identifier: GPL-3.0-or-later
!> Which linear solver a scene gets: condensation to the face where it applies, the sparse Newton matrix elsewhere.
module hd_solver_choice
  use hd_condensed, only: condensed_t, new_condensed, can_condense
  use hd_drive, only: drive_t
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_newton_matrix, only: newton_matrix_t, new_newton_matrix
  use hd_scene, only: scene_t, largest_face
  implicit none
  private
  public :: choose_solver

contains

  !> Make the solver that `solver.method` asks for, or the cheaper one.
  subroutine choose_solver(scene, drive, solver, error)
    type(scene_t), intent(in) :: scene                            !< scene
    type(drive_t), intent(in) :: drive                            !< its problem
    class(linear_solver_t), allocatable, intent(out) :: solver    !< ready to use
    type(error_t), allocatable, intent(out) :: error              !< does not apply, body not held, memory
    type(condensed_t), allocatable :: condensed
    type(newton_matrix_t), allocatable :: matrix
    logical :: condense
    condense = can_condense(drive%problem) .and. scene%solved_points() <= largest_face
    if (scene%method == 'condensed' .or. (scene%method == 'auto' .and. condense)) then
      allocate (condensed)
      call new_condensed(drive%problem, scene%repeats(), condensed, error)
      call move_alloc(condensed, solver)
    else
      allocate (matrix)
      call new_newton_matrix(drive%problem, matrix, error)
      call move_alloc(matrix, solver)
    end if
  end subroutine choose_solver
end module hd_solver_choice
