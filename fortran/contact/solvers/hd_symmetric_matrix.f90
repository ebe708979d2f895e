! SPDX-License-Identifier: GPL-3.0-or-later
!> Symmetric part of Newton's matrix, factorised by MUMPS (L D L^T) in double or single precision, on the part of the bodies
!> that symmetry leaves. It misses what friction couples one way only, and in single precision the last digits: hd_newton_krylov
!> refines.
!>
!>   [ K            -B^T a c R^T ] [ du  ]   [ -r_u + B^T a q  ]     R, P, T, q, s: local form of the law (hd_face_system) with
!>   [ -a c R B     -a c^2 T P   ] [ y/c ] = [ -a c (s - T q)  ]     P = R^T but for friction, dt = P y + q, c its scale
module hd_symmetric_matrix
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_face_system, only: face_system_t, new_face_system
  use hd_linear_solver, only: linear_solver_t
  use hd_metis, only: nested_dissection
  use hd_mortar, only: add_nodal_forces, coupling_block
  use hd_mumps, only: mumps_t, symmetric, ordering_given
  use hd_mumps_single, only: mumps_single_t
  use hd_newton_matrix, only: coupled_graph
  use hd_problem, only: problem_t, load_t, state_t, assemble_stiffness
  use hd_symmetry, only: symmetry_t, use_symmetry, choose_agents, symmetry_name, mirror_sign
  implicit none
  private
  public :: symmetric_matrix_t, new_symmetric_matrix

  type, extends(linear_solver_t) :: symmetric_matrix_t
    logical :: single = .false.                  !< precision of the factors
    logical :: analysed = .false.                !< pattern is that of the symmetry
    integer :: pattern = 0                       !< of the mortar coupling that was laid out
    integer :: dofs = 0                          !< displacement unknowns
    integer, allocatable :: representative(:)             !< node that stands for each node, itself for some
    integer, allocatable :: images(:)            !< nodes that an representative stands for, 0 elsewhere
    logical, allocatable :: turned(:)            !< mirrored against its representative
    logical, allocatable :: on_plane(:)          !< its own mirror image: no circumferential component
    integer, allocatable :: equation(:, :)       !< number of each dof of the representatives, 0 where fixed (3, n)
    integer, allocatable :: owned(:)             !< multiplier at each node, 0 without
    integer, allocatable :: list(:)              !< multipliers at representatives
    integer, allocatable :: at(:)                !< place of each multiplier in list, that of its representative for the others
    integer, pointer :: row(:) => null(), col(:) => null()
    real(dp), pointer :: val(:) => null()        !< in single precision only while factorising
    type(mumps_t) :: mumps
    type(mumps_single_t) :: mumps_single
    real(dp), allocatable :: dw(:, :, :), dt(:, :, :)  !< law that is factorised
  contains
    procedure :: begin => begin_symmetric
    procedure :: update => update_symmetric
    procedure :: solve => solve_symmetric
    procedure :: release => release_symmetric
  end type symmetric_matrix_t

contains

  !> Nothing is laid out before the first load step shows its symmetry.
  subroutine new_symmetric_matrix(problem, single, matrix, error)
    type(problem_t), intent(inout) :: problem         !< problem with supports and interface; gets its sparse stiffness
    logical, intent(in) :: single                     !< precision of the factors
    type(symmetric_matrix_t), intent(out) :: matrix   !< solver
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    call assemble_stiffness(problem, error)
    matrix%single = single
    matrix%name = merge('symmetric factors in single precision', 'symmetric factors                    ', single)
    matrix%unknowns = count(.not. problem%fixed) + 3*problem%mortar%n
  end subroutine new_symmetric_matrix

  !> Find the symmetry of a load step; another one needs another pattern.
  subroutine begin_symmetric(self, problem, load, state, error)
    class(symmetric_matrix_t), intent(inout) :: self  !< solver
    type(problem_t), intent(in) :: problem            !< problem
    type(load_t), intent(in) :: load                  !< load at the end of the step
    type(state_t), intent(in) :: state                !< state at its beginning
    type(error_t), allocatable, intent(out) :: error  !< symmetry asked for is not there, memory
    type(symmetry_t) :: found
    call use_symmetry(problem, load, state, .true., self%most_images, self%demanded, found, error)
    if (allocated(error)) return
    self%symmetry_used = symmetry_name(found)
    if (self%analysed .and. (found%half_turn .eqv. self%symmetry%half_turn) .and. found%mirror == self%symmetry%mirror) return
    self%symmetry = found
    call analyse(problem, self, error)
  end subroutine begin_symmetric

  !> Number, lay out, order, analyse.
  subroutine analyse(problem, matrix, error)
    type(problem_t), intent(in) :: problem            !< problem
    type(symmetric_matrix_t), intent(inout) :: matrix !< gets its pattern
    type(error_t), allocatable, intent(out) :: error  !< memory
    integer, allocatable :: position(:)
    integer :: a
    call release_symmetric(matrix)
    matrix%pattern = problem%mortar%pattern
    allocate (matrix%representative(problem%n), matrix%turned(problem%n), matrix%on_plane(problem%n))
    call choose_agents(problem, matrix%symmetry, matrix%representative, matrix%turned, matrix%on_plane)
    allocate (matrix%images(problem%n), source=0)
    do a = 1, problem%n
      matrix%images(matrix%representative(a)) = matrix%images(matrix%representative(a)) + 1
    end do
    call number(problem, matrix)
    call lay_out(problem, matrix)
    call order_unknowns(problem, matrix, position, error)
    if (allocated(error)) return
    if (matrix%single) then
      call matrix%mumps_single%analyse(symmetric, matrix%unknowns, matrix%row, matrix%col, position, error)
      matrix%library = matrix%mumps_single%version
      if (.not. allocated(error)) matrix%ordering_used = matrix%mumps_single%ordering_used
    else
      allocate (matrix%val(size(matrix%row)))
      call matrix%mumps%analyse(symmetric, matrix%unknowns, matrix%row, matrix%col, matrix%val, position, error)
      matrix%library = matrix%mumps%version
      if (.not. allocated(error)) matrix%ordering_used = matrix%mumps%ordering_used
    end if
    matrix%ordering_asked = ordering_given
    matrix%analysed = .not. allocated(error)
  end subroutine analyse

  !> Numbers of the unknowns: dofs of the representatives, then three for each of their multipliers.
  subroutine number(problem, matrix)
    type(problem_t), intent(in) :: problem             !< problem
    type(symmetric_matrix_t), intent(inout) :: matrix  !< gets equation, owned, list, at
    integer :: a, c, j
    allocate (matrix%equation(3, problem%n), source=0)
    allocate (matrix%owned(problem%n), source=0)
    matrix%dofs = 0
    do a = 1, problem%n
      if (matrix%images(a) == 0) cycle
      do c = 1, 3
        if (problem%fixed(c, a) .or. (c == 2 .and. matrix%on_plane(a))) cycle
        matrix%dofs = matrix%dofs + 1
        matrix%equation(c, a) = matrix%dofs
      end do
    end do
    matrix%owned(problem%mortar%node) = [(j, j=1, problem%mortar%n)]
    matrix%list = pack([(j, j=1, problem%mortar%n)], matrix%images(problem%mortar%node) > 0)
    allocate (matrix%at(problem%mortar%n), source=0)
    matrix%at(matrix%list) = [(j, j=1, size(matrix%list))]
    matrix%at = matrix%at(matrix%owned(matrix%representative(problem%mortar%node)))
    matrix%unknowns = matrix%dofs + 3*size(matrix%list)
  end subroutine number

  !> Pattern: one triangle of the stiffness, then coupling and law of every multiplier.
  subroutine lay_out(problem, matrix)
    type(problem_t), intent(in) :: problem             !< problem
    type(symmetric_matrix_t), intent(inout) :: matrix  !< gets row, col
    integer :: a, b, c, d, i, k, n, p, pass
    do pass = 1, 2
      n = 0
      do a = 1, problem%n
        if (matrix%images(a) == 0) cycle
        do k = problem%stiffness%ptr(a), problem%stiffness%ptr(a + 1) - 1
          b = matrix%representative(problem%stiffness%col(k))
          do d = 1, 3
            do c = 1, 3
              if (matrix%equation(c, a) >= matrix%equation(d, b)) call put(matrix%equation(c, a), matrix%equation(d, b))
            end do
          end do
        end do
      end do
      do i = 1, size(matrix%list)
        p = matrix%dofs + 3*(i - 1)
        do k = problem%mortar%ptr(matrix%list(i)), problem%mortar%ptr(matrix%list(i) + 1) - 1
          b = matrix%representative(problem%mortar%col(k))
          do d = 1, 3
            do c = 1, 3
              call put(p + c, matrix%equation(d, b))
            end do
          end do
        end do
        do d = 1, 3
          do c = d, 3
            call put(p + c, p + d)
          end do
        end do
      end do
      if (pass == 1) allocate (matrix%row(n), matrix%col(n))
    end do
  contains
    subroutine put(row, col)
      integer, intent(in) :: row, col
      if (row == 0 .or. col == 0) return
      n = n + 1
      if (pass == 1) return
      matrix%row(n) = row
      matrix%col(n) = col
    end subroutine put
  end subroutine lay_out

  !> Values in the order of lay_out; the row of an representative counts for all its images.
  subroutine enter_values(problem, matrix)
    type(problem_t), intent(in) :: problem             !< problem
    type(symmetric_matrix_t), intent(inout) :: matrix  !< gets val
    type(face_system_t) :: system
    real(dp) :: block(3, 3), scale, largest
    integer :: a, b, c, d, i, j, k, n
    n = 0
    do a = 1, problem%n
      if (matrix%images(a) == 0) cycle
      do k = problem%stiffness%ptr(a), problem%stiffness%ptr(a + 1) - 1
        b = matrix%representative(problem%stiffness%col(k))
        block = matrix%images(a)*problem%stiffness%val(:, :, k)
        if (matrix%turned(problem%stiffness%col(k))) block(:, 2) = -block(:, 2)
        do d = 1, 3
          do c = 1, 3
            if (matrix%equation(c, a) < matrix%equation(d, b) .or. matrix%equation(d, b) == 0) cycle
            n = n + 1
            matrix%val(n) = block(c, d)
          end do
        end do
      end do
    end do
    call new_face_system(matrix%dw, matrix%dt, 0*matrix%dw(:, 1, :), max(problem%mortar%area, tiny(1._dp)), system)
    largest = maxval(problem%mortar%area)*problem%law%scale
    do i = 1, size(matrix%list)
      j = matrix%list(i)
      scale = problem%mortar%area(j)*problem%law%scale*matrix%images(problem%mortar%node(j))
      do k = problem%mortar%ptr(j), problem%mortar%ptr(j + 1) - 1
        block = -scale*matmul(system%r(:, :, j), coupling_block(problem%mortar, j, k))
        block(system%rank(j) + 1:, :) = 0
        b = matrix%representative(problem%mortar%col(k))
        if (matrix%turned(problem%mortar%col(k))) block(:, 2) = -block(:, 2)
        do d = 1, 3
          if (matrix%equation(d, b) == 0) cycle
          matrix%val(n + 1:n + 3) = block(:, d)
          n = n + 3
        end do
      end do
      block = -scale*problem%law%scale*system%area(j)*0.5_dp*(system%d(:, :, j) + transpose(system%d(:, :, j)))
      do d = 1, 3
        do c = d, 3
          n = n + 1
          matrix%val(n) = block(c, d)
          if (c > system%rank(j)) matrix%val(n) = merge(-largest, 0._dp, c == d)
        end do
      end do
    end do
  end subroutine enter_values

  !> METIS on the graph of the representatives, a multiplier right behind the dofs of its node.
  subroutine order_unknowns(problem, matrix, position, error)
    type(problem_t), intent(in) :: problem              !< problem
    type(symmetric_matrix_t), intent(in) :: matrix      !< numbered
    integer, allocatable, intent(out) :: position(:)    !< place of each unknown
    type(error_t), allocatable, intent(out) :: error    !< memory
    integer, allocatable :: ptr(:), col(:), representatives(:), short(:), start(:), near(:), mark(:), place(:), at(:), weight(:)
    integer :: a, c, i, k, n
    call coupled_graph(problem, ptr, col)
    representatives = pack([(a, a=1, problem%n)], matrix%images > 0)
    allocate (short(problem%n), mark(problem%n), source=0)
    short(representatives) = [(i, i=1, size(representatives))]
    allocate (start(size(representatives) + 1), near(size(col)), place(size(representatives)), &
      at(size(representatives)), position(matrix%unknowns))
    n = 0
    do i = 1, size(representatives)
      start(i) = n + 1
      mark(representatives(i)) = i
      do k = ptr(representatives(i)), ptr(representatives(i) + 1) - 1
        a = matrix%representative(col(k))
        if (mark(a) == i) cycle
        mark(a) = i
        n = n + 1
        near(n) = short(a)
      end do
    end do
    start(size(representatives) + 1) = n + 1
    weight = max(1, count(matrix%equation(:, representatives) > 0, 1) + merge(3, 0, matrix%owned(representatives) > 0))
    call nested_dissection(start, near(:n), weight, place, error)
    if (allocated(error)) return
    at(place) = representatives
    n = 0
    do i = 1, size(representatives)
      a = at(i)
      do c = 1, 3
        if (matrix%equation(c, a) == 0) cycle
        n = n + 1
        position(matrix%equation(c, a)) = n
      end do
      if (matrix%owned(a) == 0) cycle
      k = matrix%dofs + 3*matrix%at(matrix%owned(a))
      position(k - 2:k) = [n + 1, n + 2, n + 3]
      n = n + 3
    end do
  end subroutine order_unknowns

  !> Factorise for the present derivatives of the law.
  subroutine update_symmetric(self, problem, dw, dt, error)
    class(symmetric_matrix_t), intent(inout) :: self  !< matrix
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: dw(:, :, :)               !< dR/dw (3, 3, multipliers) [Pa/m]
    real(dp), intent(in) :: dt(:, :, :)               !< dR/dt (3, 3, multipliers)
    type(error_t), allocatable, intent(out) :: error  !< singular, out of memory
    integer :: j
    if (self%pattern /= problem%mortar%pattern) self%analysed = .false.
    if (.not. self%analysed) call analyse(problem, self, error)
    if (allocated(error)) return
    self%dw = dw
    self%dt = dt
    do j = 1, problem%mortar%n
      if (.not. self%on_plane(problem%mortar%node(j))) cycle
      self%dw(2, :, j) = 0
      self%dw(:, 2, j) = 0
      self%dt(:, 2, j) = 0
      self%dt(2, :, j) = [0, 1, 0]
    end do
    if (self%single) allocate (self%val(size(self%row)))
    call enter_values(problem, self)
    if (self%single) then
      call self%mumps_single%factorise(self%val, error)
      deallocate (self%val)
      self%factor_entries = self%mumps_single%factor_entries
      self%flops = self%mumps_single%flops
    else
      call self%mumps%factorise(error)
      self%factor_entries = self%mumps%factor_entries
      self%flops = self%mumps%flops
    end if
  end subroutine update_symmetric

  !> Correction for given residuals, near the true one.
  subroutine solve_symmetric(self, problem, r_u, r_c, du, dtraction, error)
    class(symmetric_matrix_t), intent(inout) :: self  !< factorised matrix
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :)                 !< out-of-balance forces (3, n) [N]
    real(dp), intent(in) :: r_c(:, :)                 !< residuals of the law (3, multipliers) [Pa]
    real(dp), intent(out) :: du(:, :)                 !< correction of the displacements (3, n) [m]
    real(dp), intent(out) :: dtraction(:, :)          !< correction of the tractions (3, multipliers) [Pa]
    type(error_t), allocatable, intent(out) :: error  !< solver failure
    type(face_system_t) :: system
    real(dp) :: b(self%unknowns, 1), f(3, problem%n), law(3, problem%mortar%n), factor
    integer :: a, c, i, j, k, p
    law = r_c
    where (self%on_plane(problem%mortar%node)) law(2, :) = 0
    call new_face_system(self%dw, self%dt, law, max(problem%mortar%area, tiny(1._dp)), system)
    f = -r_u
    call add_nodal_forces(problem%mortar, system%q, f)
    where (self%turned) f(2, :) = -f(2, :)
    b = 0
    do a = 1, problem%n
      do c = 1, 3
        k = self%equation(c, self%representative(a))
        if (k > 0) b(k, 1) = b(k, 1) + f(c, a)
      end do
    end do
    do i = 1, size(self%list)
      j = self%list(i)
      factor = problem%mortar%area(j)*problem%law%scale*self%images(problem%mortar%node(j))
      p = self%dofs + 3*(i - 1)
      do k = 1, system%rank(j)
        b(p + k, 1) = -factor*(system%s(k, j) - dot_product(system%t(k, :, j), system%q(:, j)))
      end do
    end do
    if (self%single) then
      call self%mumps_single%solve(b(:, 1), error)
    else
      call self%mumps%solve(b, error)
    end if
    if (allocated(error)) return
    do a = 1, problem%n
      do c = 1, 3
        k = self%equation(c, self%representative(a))
        du(c, a) = 0
        if (k > 0) du(c, a) = merge(-1, 1, c == 2 .and. self%turned(a))*b(k, 1)
      end do
    end do
    do j = 1, problem%mortar%n
      i = self%list(self%at(j))
      p = self%dofs + 3*(self%at(j) - 1)
      dtraction(:, j) = system%q(:, i) + problem%law%scale*matmul(system%p(:, :system%rank(i), i), b(p + 1:p + system%rank(i), 1))
      if (self%turned(problem%mortar%node(j))) dtraction(:, j) = mirror_sign*dtraction(:, j)
    end do
  end subroutine solve_symmetric

  !> Give back all memory.
  subroutine release_symmetric(self)
    class(symmetric_matrix_t), intent(inout) :: self  !< matrix
    call self%mumps%release()
    call self%mumps_single%release()
    if (associated(self%row)) deallocate (self%row, self%col)
    if (associated(self%val)) deallocate (self%val)
    if (allocated(self%representative)) deallocate (self%representative, self%turned, self%on_plane, self%images, &
      self%equation, self%owned, self%at)
    self%analysed = .false.
  end subroutine release_symmetric
end module hd_symmetric_matrix
