! SPDX-License-Identifier: GPL-3.0-or-later
!> Linear statics of the bodies of a problem, interface left aside: Cholesky factors by MUMPS in a METIS order.
module hd_static
  use hd_kinds, only: dp
  use hd_block_matrix, only: multiply
  use hd_error, only: code_linear_solver, error_t, raise
  use hd_metis, only: nested_dissection
  use hd_mumps, only: mumps_t, positive_definite
  use hd_problem, only: problem_t, assemble_stiffness
  implicit none
  private
  public :: solve_static

  !> residual forces over all of a body that is held: far above rounding, far below its load
  real(dp), parameter :: balanced = 1e-6_dp

contains

  !> Displacements under nodal forces and prescribed displacements.
  subroutine solve_static(problem, displacement, force, u, error)
    type(problem_t), intent(inout) :: problem         !< bodies and supports; gets its sparse stiffness
    real(dp), intent(in) :: displacement(:, :)        !< values of the fixed dofs, the rest is not read (3, n) [m]
    real(dp), intent(in) :: force(:, :)               !< nodal forces (3, n) [N]
    real(dp), intent(out) :: u(:, :)                  !< displacements (3, n) [m]
    type(error_t), allocatable, intent(out) :: error  !< a body is not held, out of memory
    type(mumps_t) :: mumps
    integer, allocatable :: equation(:, :), position(:)
    integer, allocatable, target :: row(:), col(:)
    real(dp), allocatable, target :: val(:)
    real(dp), allocatable :: b(:, :), r(:, :)
    integer :: n
    u = merge(displacement, 0._dp, problem%fixed)
    call assemble_stiffness(problem, error)
    if (allocated(error)) return
    call number_unknowns(problem, equation, position, n, error)
    if (allocated(error) .or. n == 0) return
    call lower_triangle(problem, equation, row, col, val)
    call mumps%analyse(positive_definite, n, row, col, val, position, error)
    if (.not. allocated(error)) call mumps%factorise(error)
    if (.not. allocated(error)) then
      r = force - multiply(problem%stiffness, u)
      b = reshape(pack(r, equation > 0), [n, 1])
      call mumps%solve(b, error)
      u = unpack(b(:, 1), equation > 0, u)
      r = force - multiply(problem%stiffness, u)
      if (.not. allocated(error) .and. .not. norm2(pack(r, equation > 0)) < balanced*(norm2(force) + norm2(r)) + tiny(1._dp)) then
        call raise(error, code_linear_solver, &
          'out-of-balance forces remain after the solution: a body is not held; fix more of its nodes')
      end if
    end if
    call mumps%release()
  end subroutine solve_static

  !> Numbers of the free dofs in their order of storage, and their places in the elimination order.
  subroutine number_unknowns(problem, equation, position, n, error)
    type(problem_t), intent(in) :: problem               !< problem
    integer, allocatable, intent(out) :: equation(:, :)  !< number of each dof, 0 where fixed (3, n)
    integer, allocatable, intent(out) :: position(:)     !< place of each unknown
    integer, intent(out) :: n                            !< unknowns
    type(error_t), allocatable, intent(out) :: error     !< out of memory
    integer, allocatable :: place(:), at(:)
    integer :: a, c, i
    allocate (equation(3, problem%n), source=0)
    n = 0
    do a = 1, problem%n
      do c = 1, 3
        if (problem%fixed(c, a)) cycle
        n = n + 1
        equation(c, a) = n
      end do
    end do
    allocate (position(n), place(problem%n), at(problem%n))
    call nested_dissection(problem%stiffness%ptr, problem%stiffness%col, max(1, count(equation > 0, 1)), place, error)
    if (allocated(error)) return
    at(place) = [(i, i=1, problem%n)]
    n = 0
    do i = 1, problem%n
      do c = 1, 3
        if (equation(c, at(i)) == 0) cycle
        n = n + 1
        position(equation(c, at(i))) = n
      end do
    end do
  end subroutine number_unknowns

  !> Entries of the free dofs on and below the diagonal.
  subroutine lower_triangle(problem, equation, row, col, val)
    type(problem_t), intent(in) :: problem                 !< problem
    integer, intent(in) :: equation(:, :)                  !< number of each dof, 0 where fixed
    integer, allocatable, intent(out) :: row(:), col(:)    !< coordinates
    real(dp), allocatable, intent(out) :: val(:)           !< values
    integer :: a, b, c, d, i, j, k, n, pass
    do pass = 1, 2
      n = 0
      do a = 1, problem%n
        do k = problem%stiffness%ptr(a), problem%stiffness%ptr(a + 1) - 1
          b = problem%stiffness%col(k)
          if (b > a) exit
          do d = 1, 3
            do c = 1, 3
              i = equation(c, a)
              j = equation(d, b)
              if (j == 0 .or. i < j) cycle
              n = n + 1
              if (pass == 1) cycle
              row(n) = i
              col(n) = j
              val(n) = problem%stiffness%val(c, d, k)
            end do
          end do
        end do
      end do
      if (pass == 1) allocate (row(n), col(n), val(n))
    end do
  end subroutine lower_triangle
end module hd_static
