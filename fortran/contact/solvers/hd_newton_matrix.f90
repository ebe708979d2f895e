! SPDX-License-Identifier: GPL-3.0-or-later
!> The Newton matrix of displacements and multipliers, factorised by MUMPS in a METIS order.
!>
!>   [ K          -B^T a c ] [ du   ]   [ -r_u   ]      K stiffness of the free dofs, B the mortar coupling,
!>   [ -a R_w B   -a c R_t ] [ dt/c ] = [  a r_c ]      R_w, R_t derivatives of the contact law, a areas, c its scale.
!> The pattern holds every contact state, so it is analysed once; only the entries of the law change, and where faces are paired
!> anew those of B. Other pairs may need another pattern.
module hd_newton_matrix
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: coupling_block
  use hd_problem, only: problem_t, assemble_stiffness, stiffness_blocks
  use hd_metis, only: nested_dissection
  use hd_mumps, only: mumps_t, unsymmetric, ordering_given
  implicit none
  private
  public :: newton_matrix_t, new_newton_matrix, lay_out_newton_matrix

  type, extends(linear_solver_t) :: newton_matrix_t
    integer :: dofs = 0                          !< free displacement dofs
    integer, allocatable :: equation(:, :)       !< number of each dof, 0 where fixed (3, n)
    type(mumps_t) :: mumps                       !< factors
    integer, pointer :: row(:) => null(), col(:) => null()
    real(dp), pointer :: val(:) => null()
    integer :: law_start = 0                     !< entries after this one depend on the contact state
    integer :: pattern = 0                       !< of the mortar coupling that was laid out
    integer :: struts = 0                        !< unknown forces, the last unknowns
  contains
    procedure :: update => update_matrix
    procedure :: solve => solve_newton
    procedure :: release
  end type newton_matrix_t

  real(dp), parameter :: held = 1e6_dp  !< stiffness that holds a wheel, over that of a piece of the bodies

contains

  !> Number the unknowns, lay out the pattern, order and analyse it.
  subroutine new_newton_matrix(problem, matrix, error)
    type(problem_t), intent(inout) :: problem         !< problem with supports and interface; gets its sparse stiffness
    type(newton_matrix_t), intent(out) :: matrix      !< analysed matrix
    type(error_t), allocatable, intent(out) :: error  !< out of memory
    call assemble_stiffness(problem, error)
    if (.not. allocated(error)) call lay_out_newton_matrix(problem, matrix, error)
  end subroutine new_newton_matrix

  !> The same where the sparse stiffness is there already.
  subroutine lay_out_newton_matrix(problem, matrix, error)
    type(problem_t), intent(in) :: problem            !< problem
    type(newton_matrix_t), intent(inout) :: matrix    !< new, or with another pattern; analysed
    type(error_t), allocatable, intent(out) :: error  !< out of memory
    integer, allocatable :: position(:)
    integer :: a, c
    call release(matrix)
    matrix%dofs = 0
    matrix%pattern = problem%mortar%pattern
    allocate (matrix%equation(3, problem%n), source=0)
    do a = 1, problem%n
      do c = 1, 3
        if (problem%fixed(c, a)) cycle
        matrix%dofs = matrix%dofs + 1
        matrix%equation(c, a) = matrix%dofs
      end do
    end do
    if (allocated(problem%wheel)) then  ! one unknown for all of them
      matrix%dofs = matrix%dofs + 1
      matrix%equation(2, problem%wheel) = matrix%dofs
    end if
    matrix%struts = 0
    if (allocated(problem%struts)) matrix%struts = size(problem%struts)
    matrix%unknowns = matrix%dofs + 3*problem%mortar%n + matrix%struts
    call lay_out(problem, matrix)
    call order_unknowns(problem, matrix, position, error)
    if (allocated(error)) return
    call matrix%mumps%analyse(unsymmetric, matrix%unknowns, matrix%row, matrix%col, matrix%val, position, error)
    matrix%name = 'Newton matrix, MUMPS'
    matrix%ordering_asked = ordering_given
    if (.not. allocated(error)) matrix%ordering_used = matrix%mumps%ordering_used
    matrix%library = matrix%mumps%version
  end subroutine lay_out_newton_matrix

  !> Coordinates of all entries, and the values that never change.
  subroutine lay_out(problem, matrix)
    type(problem_t), intent(in) :: problem           !< problem
    type(newton_matrix_t), intent(inout) :: matrix   !< gets row, col, val
    real(dp), allocatable :: val(:, :, :)
    integer :: a, b, c, d, j, k, pass, n
    logical :: turned
    val = stiffness_blocks(problem)
    turned = allocated(problem%mortar%turn)
    do pass = 1, 2
      n = 0
      do a = 1, problem%n
        do k = problem%stiffness%ptr(a), problem%stiffness%ptr(a + 1) - 1
          b = problem%stiffness%col(k)
          do d = 1, 3
            do c = 1, 3
              call put(matrix%equation(c, a), matrix%equation(d, b), val(c, d, k))
            end do
          end do
        end do
      end do
      if (allocated(problem%wheel)) call put(matrix%dofs, matrix%dofs, 0._dp)
      matrix%law_start = n
      do j = 1, problem%mortar%n
        do k = problem%mortar%ptr(j), problem%mortar%ptr(j + 1) - 1
          do d = 1, 3
            do c = 1, 3
              if (c == d .or. turned) call put(matrix%equation(d, problem%mortar%col(k)), multiplier(j, c), 0._dp)
              if (c > 1 .or. d == 1 .or. turned) call put(multiplier(j, c), matrix%equation(d, problem%mortar%col(k)), 0._dp)
            end do
          end do
        end do
        do d = 1, 3
          do c = 1, 3
            call put(multiplier(j, c), multiplier(j, d), 0._dp)
          end do
        end do
      end do
      do j = 1, matrix%struts
        associate (strut => problem%struts(j), at => matrix%unknowns - matrix%struts + j)
          do k = 1, size(strut%node)
            do c = 1, 3
              if (.not. abs(strut%weight(c, k)) > 0) cycle
              call put(matrix%equation(c, strut%node(k)), at, 0._dp)
              call put(at, matrix%equation(c, strut%node(k)), 0._dp)
            end do
          end do
          call put(at, at, 0._dp)
          k = companion_of(problem, j)
          if (k > 0) call put(at, at - j + problem%rub%partner(k), 0._dp)
          k = other_way(problem, j)
          if (k > 0) call put(at, at - j + k, 0._dp)
          if (.not. allocated(problem%strut_give)) cycle
          do k = 1, matrix%struts
            call put(at, at - j + k, 0._dp)
          end do
        end associate
      end do
      if (pass == 1) allocate (matrix%row(n), matrix%col(n), matrix%val(n))
    end do
  contains
    pure integer function multiplier(j, c)
      integer, intent(in) :: j, c
      multiplier = matrix%dofs + 3*(j - 1) + c
    end function multiplier

    subroutine put(row, col, value)
      integer, intent(in) :: row, col
      real(dp), intent(in) :: value
      if (row == 0 .or. col == 0) return
      n = n + 1
      if (pass == 1) return
      matrix%row(n) = row
      matrix%col(n) = col
      matrix%val(n) = value
    end subroutine put
  end subroutine lay_out

  !> Number of a strut among the companions of others, 0 for others.
  pure integer function companion_of(problem, strut)
    type(problem_t), intent(in) :: problem  !< problem
    integer, intent(in) :: strut            !< number
    companion_of = 0
    if (allocated(problem%rub)) companion_of = max(0, strut - size(problem%struts) + size(problem%rub%partner))
  end function companion_of

  !> The other one of the two struts of a ball in its grooves, 0 for other struts.
  pure integer function other_way(problem, strut)
    type(problem_t), intent(in) :: problem  !< problem
    integer, intent(in) :: strut            !< number
    other_way = 0
    if (.not. allocated(problem%groove)) return
    associate (balls => problem%groove%balls, before => problem%groove%before)
      if (strut <= balls) other_way = before + strut
      if (strut > before .and. strut <= before + balls) other_way = strut - before
    end associate
  end function other_way

  !> Enter the present stiffness, in the order of lay_out.
  subroutine enter_stiffness(problem, matrix)
    type(problem_t), intent(in) :: problem           !< problem
    type(newton_matrix_t), intent(inout) :: matrix   !< gets the first values
    real(dp), allocatable :: val(:, :, :)
    integer :: a, b, c, d, k, n
    val = stiffness_blocks(problem)
    n = 0
    do a = 1, problem%n
      do k = problem%stiffness%ptr(a), problem%stiffness%ptr(a + 1) - 1
        b = problem%stiffness%col(k)
        do d = 1, 3
          do c = 1, 3
            if (matrix%equation(c, a) == 0 .or. matrix%equation(d, b) == 0) cycle
            n = n + 1
            matrix%val(n) = val(c, d, k)
          end do
        end do
      end do
    end do
  end subroutine enter_stiffness

  !> Elimination order: METIS on the graph of nodes, a multiplier standing right behind the dofs of its slave node.
  subroutine order_unknowns(problem, matrix, position, error)
    type(problem_t), intent(in) :: problem            !< problem
    type(newton_matrix_t), intent(in) :: matrix       !< numbered unknowns
    integer, allocatable, intent(out) :: position(:)  !< place of each unknown
    type(error_t), allocatable, intent(out) :: error  !< out of memory
    integer, allocatable :: ptr(:), col(:), weight(:), place(:), at(:), owner(:)
    integer :: a, c, i, n
    call coupled_graph(problem, ptr, col)
    allocate (weight(problem%n), place(problem%n), at(problem%n), position(matrix%unknowns))
    allocate (owner(problem%n), source=0)
    owner(problem%mortar%node) = [(i, i=1, problem%mortar%n)]
    weight = max(1, count(matrix%equation > 0, 1) + merge(3, 0, owner > 0))
    call nested_dissection(ptr, col, weight, place, error)
    if (allocated(error)) return
    at(place) = [(i, i=1, problem%n)]
    n = 0
    do i = 1, problem%n
      a = at(i)
      do c = 1, 3
        if (matrix%equation(c, a) == 0) cycle
        if (allocated(problem%wheel)) then
          if (c == 2 .and. any(problem%wheel == a)) cycle
        end if
        n = n + 1
        position(matrix%equation(c, a)) = n
      end do
      if (owner(a) == 0) cycle
      position(matrix%dofs + 3*owner(a) - 2:matrix%dofs + 3*owner(a)) = [n + 1, n + 2, n + 3]
      n = n + 3
    end do
    if (allocated(problem%wheel)) then
      n = n + 1
      position(matrix%dofs) = n
    end if
    position(matrix%unknowns - matrix%struts + 1:) = [(n + i, i=1, matrix%struts)]
  end subroutine order_unknowns

  !> Graph of the nodes with the edges of the interface added.
  subroutine coupled_graph(problem, ptr, col)
    type(problem_t), intent(in) :: problem        !< problem
    integer, allocatable, intent(out) :: ptr(:)   !< row pointers
    integer, allocatable, intent(out) :: col(:)   !< neighbours
    integer, allocatable :: extra(:), start(:), list(:), mark(:)
    integer :: a, j, k, m, pass
    associate (mortar => problem%mortar, graph => problem%stiffness)
      allocate (start(problem%n + 1), mark(problem%n), ptr(problem%n + 1))
      do pass = 1, 2
        if (pass == 1) start = 0
        do j = 1, mortar%n
          do k = mortar%ptr(j), mortar%ptr(j + 1) - 1
            call edge(mortar%node(j), mortar%col(k))
            call edge(mortar%col(k), mortar%node(j))
          end do
        end do
        if (pass == 2) exit
        do a = 1, problem%n
          start(a + 1) = start(a + 1) + start(a)
        end do
        allocate (list(start(problem%n + 1)))
        extra = start(:problem%n)
      end do
      allocate (col(size(graph%col) + size(list)))
      mark = 0
      m = 0
      do a = 1, problem%n
        ptr(a) = m + 1
        do k = graph%ptr(a), graph%ptr(a + 1) - 1
          call neighbour(graph%col(k))
        end do
        do k = start(a) + 1, start(a + 1)
          call neighbour(list(k))
        end do
      end do
      ptr(problem%n + 1) = m + 1
      col = col(:m)
    end associate
  contains
    subroutine edge(from, to)
      integer, intent(in) :: from, to
      if (pass == 1) then
        start(from + 1) = start(from + 1) + 1
      else
        extra(from) = extra(from) + 1
        list(extra(from)) = to
      end if
    end subroutine edge

    subroutine neighbour(b)
      integer, intent(in) :: b
      if (mark(b) == a .or. b == a) return
      mark(b) = a
      m = m + 1
      col(m) = b
    end subroutine neighbour
  end subroutine coupled_graph

  !> Enter coupling and derivatives of the contact law, and factorise.
  subroutine update_matrix(self, problem, dw, dt, error)
    class(newton_matrix_t), intent(inout) :: self     !< matrix
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: dw(:, :, :)               !< dR/dw (3, 3, multipliers) [Pa/m]
    real(dp), intent(in) :: dt(:, :, :)               !< dR/dt (3, 3, multipliers)
    type(error_t), allocatable, intent(out) :: error  !< singular, out of memory
    real(dp) :: block(3, 3), rows(3, 3)
    integer :: c, d, i, j, k, n
    logical :: holds, turned
    if (problem%mortar%pattern /= self%pattern) call lay_out_newton_matrix(problem, self, error)
    if (allocated(error)) return
    if (allocated(problem%lagrangian)) call enter_stiffness(problem, self)
    turned = allocated(problem%mortar%turn)
    n = self%law_start
    if (allocated(problem%wheel)) self%val(n) = merge(0._dp, held*problem%law%scale*problem%bodies(1)%x(1, 1)**2, &
      problem%wheel_turns)
    do j = 1, problem%mortar%n
      do k = problem%mortar%ptr(j), problem%mortar%ptr(j + 1) - 1
        block = -problem%mortar%area(j)*coupling_block(problem%mortar, j, k)
        rows = matmul(dw(:, :, j), block)
        block = problem%law%scale*block
        do d = 1, 3
          if (self%equation(d, problem%mortar%col(k)) == 0) cycle
          do c = 1, 3
            if (c == d .or. turned) call enter(block(c, d))
            if (c > 1 .or. d == 1 .or. turned) call enter(rows(c, d))
          end do
        end do
      end do
      do d = 1, 3
        self%val(n + 1:n + 3) = -max(problem%mortar%area(j), tiny(1._dp))*problem%law%scale*dt(:, d, j)
        n = n + 3
      end do
    end do
    do j = 1, self%struts
      i = companion_of(problem, j)
      holds = problem%strut_rate(j) > 0
      if (i > 0) holds = holds .and. .not. problem%rub%slides(i)
      associate (strut => problem%struts(j))
        do k = 1, size(strut%node)
          do c = 1, 3
            if (.not. abs(strut%weight(c, k)) > 0 .or. self%equation(c, strut%node(k)) == 0) cycle
            call enter(-strut%weight(c, k))
            call enter(merge(-strut%weight(c, k), 0._dp, holds))
          end do
        end do
        call enter(merge(-1/max(problem%strut_rate(j), tiny(1._dp)), -1/strut%rate, problem%strut_rate(j) > 0))
        if (i > 0) call enter(merge(problem%rub%lean(i), 0._dp, problem%strut_rate(j) > 0)/max(problem%strut_rate(j), tiny(1._dp)))
        k = other_way(problem, j)
        if (k > 0) call enter(-problem%groove%cross(min(j, k)))
        if (.not. allocated(problem%strut_give)) cycle
        do k = 1, self%struts
          call enter(merge(-problem%strut_give(j, k), 0._dp, holds .and. problem%strut_rate(k) > 0))
        end do
      end associate
    end do
    call self%mumps%factorise(error)
    self%factor_entries = self%mumps%factor_entries
    self%flops = self%mumps%flops
  contains
    subroutine enter(value)
      real(dp), intent(in) :: value
      n = n + 1
      self%val(n) = value
    end subroutine enter
  end subroutine update_matrix

  !> Newton correction for given residuals.
  subroutine solve_newton(self, problem, r_u, r_c, du, dtraction, error)
    class(newton_matrix_t), intent(inout) :: self     !< factorised matrix
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :)                 !< out-of-balance forces (3, n) [N]
    real(dp), intent(in) :: r_c(:, :)                 !< residuals of the law (3, multipliers) [Pa]
    real(dp), intent(out) :: du(:, :)                 !< correction of the displacements (3, n) [m]
    real(dp), intent(out) :: dtraction(:, :)                 !< correction of the tractions (3, multipliers) [Pa]
    type(error_t), allocatable, intent(out) :: error  !< solver failure
    real(dp), allocatable :: b(:, :)
    integer :: a, c, j
    allocate (b(self%unknowns, 1), source=0._dp)
    do a = 1, problem%n
      do c = 1, 3
        if (self%equation(c, a) > 0) b(self%equation(c, a), 1) = b(self%equation(c, a), 1) - r_u(c, a)
      end do
    end do
    do j = 1, problem%mortar%n
      b(self%dofs + 3*j - 2:self%dofs + 3*j, 1) = max(problem%mortar%area(j), tiny(1._dp))*r_c(:, j)
    end do
    call self%mumps%solve(b, error)
    if (allocated(error)) return
    du = 0
    do a = 1, problem%n
      do c = 1, 3
        if (self%equation(c, a) > 0) du(c, a) = b(self%equation(c, a), 1)
      end do
    end do
    if (allocated(problem%wheel) .and. .not. problem%wheel_turns) du(2, problem%wheel) = 0
    dtraction = problem%law%scale*reshape(b(self%dofs + 1:self%unknowns - self%struts, 1), shape(dtraction))
  end subroutine solve_newton

  !> Give back all memory.
  subroutine release(self)
    class(newton_matrix_t), intent(inout) :: self  !< matrix
    call self%mumps%release()
    if (associated(self%row)) deallocate (self%row, self%col, self%val)
    if (allocated(self%equation)) deallocate (self%equation)
  end subroutine release
end module hd_newton_matrix
