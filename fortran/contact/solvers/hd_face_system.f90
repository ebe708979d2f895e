! SPDX-License-Identifier: GPL-3.0-or-later
!> The linearised contact law on the face, in local form: at every multiplier R (F f)_i + T t = s with orthonormal rows R,
!> and tractions t = P y + q that already obey those rows of the law that do not see displacements (R P = 1).
!>
!> Open points have no y, slipping ones two, sticking ones three. Unknowns are y, here as forces (times area). A border (hd_border)
!> may add unknowns x: S x joins w, and  S^T f + D x = e  the equations. GMRES does not meet the struts among them: they are
!> eliminated before, F gives way to the compliance of bodies that stand on their struts. Left in the border they take it two to
!> three times the steps, and without their hold the right-hand side is not one of forces in balance.
module hd_face_system
  use hd_kinds, only: dp
  use hd_border, only: border_t
  use hd_circulant, only: circulant_t
  use hd_error, only: error_t
  use hd_krylov, only: operator_t, solve_gmres
  use hd_lapack, only: solve_dense
  use hd_symmetry, only: mirror_sign
  use hd_system, only: stop_requested, check_stop
  use hd_vector, only: add_columns, cross, dot, many, product_of, thread_share
  implicit none
  private
  public :: face_system_t, new_face_system

  !> length of a row of the law, relative, that rounding leaves of one without displacements
  real(dp), parameter :: unseen = 1e-11_dp
  integer, parameter :: few = 2000               !< points, whose law takes some time, that one thread does as fast as two
  integer, parameter :: small_matrix = 200       !< order of a matrix that one thread forms as fast as two
  real(dp), parameter :: single_above = 1e-6_dp  !< residual to which GMRES gets along with F in single precision

  type, extends(operator_t) :: face_system_t
    type(circulant_t), pointer :: compliance => null()  !< F
    integer, allocatable :: rank(:)              !< unknowns of each multiplier (multipliers)
    real(dp), allocatable :: r(:, :, :)          !< rows that see displacements (3, 3, multipliers); rank rows count
    real(dp), allocatable :: p(:, :, :)          !< tractions per unknown (3, 3, multipliers); rank columns count
    real(dp), allocatable :: d(:, :, :)          !< T P / area (3, 3, multipliers) [m/N]
    real(dp), allocatable :: t(:, :, :)          !< rows T
    real(dp), allocatable :: q(:, :, :)          !< tractions that are known (3, multipliers, sides) [Pa]
    real(dp), allocatable :: s(:, :, :)          !< right-hand sides (3, multipliers, sides)
    real(dp), allocatable :: area(:)             !< areas [m^2]
    real(dp), allocatable :: f(:, :), w(:, :)    !< workspace (3, multipliers)
    real(dp), allocatable :: share(:)            !< of the compliance in the preconditioner of each unknown
    real(dp), allocatable :: diagonal(:)         !< the rest, of the inverse diagonal
    integer, allocatable :: fringe(:), from(:)   !< open points that the preconditioner gives values, and the points they come from
    real(dp), allocatable :: fade(:)             !< weights of these values
    integer, allocatable :: list(:)              !< multipliers that are solved for
    integer, allocatable :: start(:)             !< unknowns before each of them, and their number
    integer, allocatable :: at(:)                !< multiplier of each unknown
    integer, allocatable :: span(:, :)           !< first and last unknown of each multiplier (2, multipliers)
    real(dp), allocatable :: rows(:, :), columns(:, :), law(:, :)  !< R, P, T P / area of each unknown (3, unknowns)
    integer :: more = 0                          !< unknowns of the border
    integer :: struts = 0                        !< of these the first are struts, which GMRES eliminates
    logical, allocatable :: blind(:)             !< struts whose equation has no S^T f (struts)
    real(dp) :: fold = 1                         !< points that each of the list stands for in sums over the face
    integer, allocatable :: column(:)            !< columns of the border's `side` that are S, 0: one of zeros (more)
    real(dp), allocatable :: corner(:, :)        !< D (more, more) [m/N]
    real(dp), allocatable :: known(:, :)         !< e (more, sides) [m]
    real(dp), allocatable :: x(:, :)             !< the solutions' x (more, sides) [N]
    real(dp), allocatable :: right(:, :), below(:, :)   !< R S and S^T P (unknowns, more)
    real(dp), allocatable :: strut_right(:, :)   !< R S of struts that are eliminated (struts, unknowns)
    real(dp), allocatable :: strut_forces(:, :)  !< their forces for each unknown, and for none (struts, unknowns + rest + sides)
    logical :: single = .false.                  !< GMRES gets along with F in single precision
    real(dp), allocatable :: whole(:, :)         !< D with the struts that are eliminated (more, more) [m/N]
    real(dp), allocatable :: answer(:, :)        !< preconditioned R S (unknowns, more)
    real(dp), allocatable :: factor(:, :)        !< inverse of D less what that leaves (more, more)
  contains
    procedure :: multiply => multiply_face
    procedure :: approximate => approximate_face
    procedure :: solve_direct
    procedure :: solve_krylov
    procedure :: renew
  end type face_system_t

contains

  !> Local forms of R_w w + R_t t = -r_c, for some r_c.
  subroutine new_face_system(dw, dt, r_c, area, system)
    real(dp), intent(in) :: dw(:, :, :)              !< R_w (3, 3, multipliers) [Pa/m]
    real(dp), intent(in) :: dt(:, :, :)              !< R_t (3, 3, multipliers)
    real(dp), intent(in) :: r_c(:, :, :)             !< residuals of the law (3, multipliers, sides) [Pa]
    real(dp), intent(in) :: area(:)                  !< (multipliers) [m^2]
    type(face_system_t), intent(out) :: system       !< without list
    integer :: j, k, m
    m = size(area)
    allocate (system%r(3, 3, m), system%p(3, 3, m), system%d(3, 3, m), system%t(3, 3, m))
    allocate (system%q, system%s, mold=r_c)
    allocate (system%rank(m), system%f(3, m), system%w(3, m))
    system%area = area
    !$omp parallel do schedule(static) private(k) if(m > few)
    do j = 1, m
      system%r(:, :, j) = dw(:, :, j)
      system%t(:, :, j) = dt(:, :, j)
      system%s(:, j, :) = -r_c(:, j, :)
      call reduce_rows(system%r(:, :, j), system%t(:, :, j), system%s(:, j, :), system%rank(j))
      k = system%rank(j)
      call split_tractions(system%r(:, :, j), system%t(:, :, j), system%s(:, j, :), k, system%p(:, :, j), system%q(:, j, :))
      system%d(:, :, j) = matmul(system%t(:, :, j), system%p(:, :, j))/area(j)
    end do
    !$omp end parallel do
  end subroutine new_face_system

  !> Orthonormal rows by Gram-Schmidt with pivots; rows without displacement come last. The same is done to T and s.
  pure subroutine reduce_rows(r, t, s, rank)
    real(dp), intent(inout) :: r(3, 3), t(3, 3), s(:, :)  !< rows of the law
    integer, intent(out) :: rank                       !< rows that see displacements
    real(dp) :: size, length, factor, row(3), sides(ubound(s, 2))
    integer :: i, k
    size = maxval(abs(r))
    rank = 0
    if (.not. size > 0) return
    do k = 1, 3
      i = k - 1 + maxloc(sum(r(k:, :)**2, 2), 1)
      length = norm2(r(i, :))
      if (length <= unseen*size) exit
      row = r(i, :); r(i, :) = r(k, :); r(k, :) = row/length
      row = t(i, :); t(i, :) = t(k, :); t(k, :) = row/length
      sides = s(i, :); s(i, :) = s(k, :); s(k, :) = sides/length
      do i = k + 1, 3
        factor = dot_product(r(i, :), r(k, :))
        r(i, :) = r(i, :) - factor*r(k, :)
        t(i, :) = t(i, :) - factor*t(k, :)
        s(i, :) = s(i, :) - factor*s(k, :)
      end do
      rank = k
    end do
  end subroutine reduce_rows

  !> t = P y + q obeys rows rank + 1..3 of T t = s, and R P = 1.
  pure subroutine split_tractions(r, t, s, rank, p, q)
    real(dp), intent(in) :: r(3, 3), t(3, 3), s(:, :)  !< reduced rows
    integer, intent(in) :: rank                     !< rows that see displacements
    real(dp), intent(out) :: p(3, 3), q(:, :)       !< tractions per unknown (rank columns), known ones
    real(dp) :: a(3, 3), inverse(3, 3)
    integer :: k
    a = r
    a(rank + 1:, :) = t(rank + 1:, :)
    inverse(:, 1) = cross(a(2, :), a(3, :))
    inverse(:, 2) = cross(a(3, :), a(1, :))
    inverse(:, 3) = cross(a(1, :), a(2, :))
    inverse = inverse/dot_product(a(1, :), inverse(:, 1))
    p = 0
    p(:, :rank) = inverse(:, :rank)
    do k = 1, size(q, 2)
      q(:, k) = matmul(inverse(:, rank + 1:), s(rank + 1:, k))
    end do
  end subroutine split_tractions

  !> Right-hand sides for relative displacements w that are known.
  function right_sides(self, w) result(b)
    class(face_system_t), intent(in) :: self  !< system
    real(dp), intent(in) :: w(:, :, :)        !< (3, multipliers, sides) [m]
    real(dp) :: b(self%start(size(self%start)) + self%more, size(w, 3))
    integer :: i, j, k, side
    if (self%more > 0) b(self%start(size(self%start)) + 1:, :) = self%known
    !$omp parallel do schedule(static) private(j, k, side) if(size(self%list) > few)
    do i = 1, size(self%list)
      j = self%list(i)
      do side = 1, size(w, 3)
        do k = 1, self%rank(j)
          b(self%start(i) + k, side) = self%s(k, j, side) - dot_product(self%r(k, :, j), w(:, j, side)) - &
            dot_product(self%t(k, :, j), self%q(:, j, side))
        end do
      end do
    end do
    !$omp end parallel do
  end function right_sides

  !> Tractions of a solution at the multipliers of the list.
  subroutine enter(self, side, y, traction)
    class(face_system_t), intent(inout) :: self     !< system; gets x
    integer, intent(in) :: side                     !< number of the right-hand side
    real(dp), intent(in) :: y(:)                    !< unknowns [N]
    real(dp), intent(inout) :: traction(:, :)       !< gets them (3, multipliers) [Pa]
    integer :: i, j, k
    !$omp parallel do schedule(static) private(j, k) if(size(self%list) > few)
    do i = 1, size(self%list)
      j = self%list(i)
      k = self%rank(j)
      traction(:, j) = self%q(:, j, side) + matmul(self%p(:, :k, j), y(self%start(i) + 1:self%start(i) + k))/self%area(j)
    end do
    !$omp end parallel do
    if (allocated(self%x)) self%x(size(self%x, 1) - self%more + 1:, side) = y(self%start(size(self%start)) + 1:)
  end subroutine enter

  !> Number the unknowns of a list.
  subroutine number(self, list)
    class(face_system_t), intent(inout) :: self  !< gets list, start
    integer, intent(in) :: list(:)               !< multipliers
    integer :: i
    self%list = list
    allocate (self%start(size(list) + 1))
    self%start(1) = 0
    do i = 1, size(list)
      self%start(i + 1) = self%start(i) + self%rank(list(i))
    end do
  end subroutine number

  !> Dense LU. Images behind a mirror plane are folded in.
  subroutine solve_direct(self, list, mirrored, w, border, traction, flops, factors, pivot, error)
    class(face_system_t), intent(inout) :: self       !< system
    integer, intent(in) :: list(:)                    !< multipliers to solve for
    integer, intent(in) :: mirrored(:)                !< image of each, itself where there is none
    real(dp), intent(in) :: w(:, :, :)                !< relative displacements without y (3, multipliers, sides) [m]
    type(border_t), allocatable, intent(in) :: border !< what stands beside, with S; unallocated: nothing
    real(dp), intent(inout) :: traction(:, :, :)      !< gets the tractions of the list [Pa]
    real(dp), intent(out) :: flops                    !< operations
    real(dp), allocatable, intent(inout) :: factors(:, :)   !< of the same matrix; unallocated: gets them
    integer, allocatable, intent(inout) :: pivot(:)         !< their rows
    type(error_t), allocatable, intent(out) :: error  !< singular
    real(dp), allocatable :: b(:, :)
    integer :: k, n
    call number(self, list)
    n = self%start(size(self%start))
    flops = 2*real(n, dp)**3/3
    if (.not. allocated(factors)) call form_matrix(self, mirrored, border, factors, error)
    if (allocated(error)) return
    b = right_sides(self, w)
    call solve_dense(factors, b, error, pivot)
    if (allocated(error)) return
    do k = 1, size(b, 2)
      call enter(self, k, b(:, k), traction(:, :, k))
    end do
  end subroutine solve_direct

  !> Dense matrix of a list.
  subroutine form_matrix(self, mirrored, border, a, error)
    class(face_system_t), intent(inout) :: self       !< numbered
    integer, intent(in) :: mirrored(:)                !< as of solve_direct
    type(border_t), allocatable, intent(in) :: border !< what stands beside, with S; unallocated: nothing
    real(dp), allocatable, intent(out) :: a(:, :)     !< matrix
    type(error_t), allocatable, intent(out) :: error  !< memory, a stop asked for
    real(dp), allocatable :: column(:, :, :)
    real(dp) :: rp(3, 3)
    integer :: c, d, i, j, k, n
    call self%compliance%prepare_columns(error)
    if (allocated(error)) return
    n = self%start(size(self%start))
    allocate (a(n + self%more, n + self%more))
    associate (list => self%list)
      !$omp parallel private(column, rp, c, d, j, k) if(n > small_matrix)
      allocate (column(3, 3, size(list)))
      !$omp do schedule(static)
      do i = 1, size(list)
        if (stop_requested()) cycle
        j = list(i)
        column = 0
        call self%compliance%add_column(j, [1._dp, 1._dp, 1._dp], list, column)
        if (mirrored(i) /= j) call self%compliance%add_column(mirrored(i), mirror_sign, list, column)
        do c = 1, self%rank(j)
          call fill_column(self, column, self%p(:, c, j), a(:n, self%start(i) + c))
        end do
        k = self%rank(j)
        rp = self%d(:, :, j)
        do c = 1, k
          do d = 1, k
            a(self%start(i) + d, self%start(i) + c) = a(self%start(i) + d, self%start(i) + c) + rp(d, c)
          end do
        end do
      end do
      !$omp end do
      !$omp end parallel
      call check_stop(error)
      if (allocated(error)) return
      if (self%more > 0) then
        call pack_rows(self, border)
        a(:n, n + 1:) = self%right
        a(n + 1:, :n) = transpose(self%below)
        do i = 1, size(list)
          if (mirrored(i) == list(i)) cycle
          a(n + 1:, self%start(i) + 1:self%start(i + 1)) = 2*a(n + 1:, self%start(i) + 1:self%start(i + 1))
        end do
        a(n + 1:, n + 1:) = self%corner
      end if
    end associate
  end subroutine form_matrix

  !> R F p at all multipliers of the list.
  pure subroutine fill_column(self, column, p, a)
    class(face_system_t), intent(in) :: self    !< system
    real(dp), intent(in) :: column(:, :, :)     !< F for three forces (3, 3, list)
    real(dp), intent(in) :: p(3)                !< their amounts
    real(dp), intent(out) :: a(:)               !< column of the matrix
    real(dp) :: v(3)
    integer :: i, j, k
    do i = 1, size(self%list)
      j = self%list(i)
      v = column(:, 1, i)*p(1) + column(:, 2, i)*p(2) + column(:, 3, i)*p(3)
      do k = 1, self%rank(j)
        a(self%start(i) + k) = self%r(k, 1, j)*v(1) + self%r(k, 2, j)*v(2) + self%r(k, 3, j)*v(3)
      end do
    end do
  end subroutine fill_column

  !> GMRES with F applied by its own means.
  subroutine solve_krylov(self, list, w, border, tolerance, most, traction, steps, residual, error)
    class(face_system_t), intent(inout) :: self       !< system
    integer, intent(in) :: list(:)                    !< multipliers to solve for
    real(dp), intent(in) :: w(:, :, :)                !< relative displacements without y (3, multipliers, sides) [m]
    type(border_t), allocatable, intent(in) :: border !< what stands beside, with S; unallocated: nothing
    real(dp), intent(in) :: tolerance                 !< relative residual
    integer, intent(in) :: most                       !< steps of each side at most
    real(dp), intent(inout) :: traction(:, :, :)      !< gets the tractions of the list [Pa]
    integer, intent(out) :: steps                     !< taken
    real(dp), intent(out) :: residual                 !< reached by all
    type(error_t), allocatable, intent(out) :: error  !< memory
    real(dp), allocatable :: b(:, :), y(:)
    real(dp) :: left
    integer :: k, taken
    call number(self, list)
    call pack_rows(self, border)
    call weigh(self)
    if (self%struts > 0) then  ! elsewhere it is no gain: CD-14-100 from rest takes 32 Newton iterations, 21 without
      call self%compliance%surround(closed_of(self), self%fringe, self%from, self%fade)
    else
      allocate (self%fringe(0), self%from(0), self%fade(0), self%strut_forces(0, size(self%at)), self%strut_right(0, size(self%at)))
    end if
    self%single = tolerance >= single_above
    b = right_sides(self, w)
    if (self%struts > 0) call eliminate_struts(self, b, error)
    if (self%more > 0 .and. .not. allocated(error)) call eliminate_border(self, error)
    if (allocated(error)) return
    steps = 0
    residual = 0
    allocate (y(size(b, 1)))
    do k = 1, size(b, 2)
      call solve_gmres(self, b(:, k), tolerance, most, y, taken, left, error)  ! a preconditioner that rounds
      if (allocated(error)) return
      steps = steps + taken
      residual = max(residual, left)
      call enter(self, k, y, traction(:, :, k))
      if (self%struts > 0) self%x(:self%struts, k) = self%strut_forces(:, size(y) + k) - matmul(self%strut_forces(:, :size(y)), y)
    end do
  end subroutine solve_krylov

  !> As before GMRES.
  subroutine renew(self)
    class(face_system_t), intent(inout) :: self  !< system
    if (allocated(self%whole)) call move_alloc(self%whole, self%corner)
    if (allocated(self%corner)) self%more = size(self%corner, 1)
    deallocate (self%start, self%at, self%span, self%rows, self%columns, self%law, self%share, self%diagonal, self%fringe, &
      self%from, self%fade, self%right, self%below, self%strut_right, self%strut_forces)
  end subroutine renew

  !> Points that are solved for.
  pure function closed_of(self) result(closed)
    class(face_system_t), intent(in) :: self  !< system with its list
    logical :: closed(size(self%rank))
    closed = .false.
    closed(self%list) = .true.
  end function closed_of

  !> Leave the rest of the border, and bodies that stand on their struts.
  subroutine eliminate_struts(self, b, error)
    class(face_system_t), intent(inout) :: self       !< packed; gets strut_right, strut_forces
    real(dp), allocatable, intent(inout) :: b(:, :)   !< right-hand sides, lose the struts
    type(error_t), allocatable, intent(out) :: error  !< singular
    real(dp), allocatable :: own(:, :), cross(:, :)
    real(dp) :: left(size(b, 1) - self%struts, size(b, 2))
    integer :: k, m, n, rest
    n = size(self%at)
    m = self%struts
    rest = size(left, 1)
    own = self%corner(:m, :m)
    self%whole = self%corner
    cross = self%corner(m + 1:, :m)
    allocate (self%strut_forces(m, rest + size(b, 2)))
    self%strut_forces(:, :n) = transpose(self%below(:, :m))
    self%strut_forces(:, n + 1:rest) = self%corner(:m, m + 1:)
    self%strut_forces(:, rest + 1:) = b(n + 1:n + m, :)
    call solve_dense(own, self%strut_forces, error)
    if (allocated(error)) return
    associate (forces => self%strut_forces)
      self%strut_right = transpose(self%right(:, :m))
      do k = 1, size(b, 2)
        left(:n, k) = b(:n, k) - matmul(forces(:, rest + k), self%strut_right)
        left(n + 1:, k) = b(n + m + 1:, k) - matmul(cross, forces(:, rest + k))
      end do
      b = left
      self%corner = self%corner(m + 1:, m + 1:) - matmul(cross, forces(:, n + 1:rest))
      self%right = self%right(:, m + 1:) - matmul(self%right(:, :m), forces(:, n + 1:rest))
      self%below = self%below(:, m + 1:) - transpose(matmul(cross, forces(:, :n)))
    end associate
    self%more = self%more - m
  end subroutine eliminate_struts

  !> Shares of compliance and law in the preconditioner: squares of those in the diagonal (a fifth fewer steps than the shares
  !> themselves on meshes with edge cells, a tenth on others).
  subroutine weigh(self)
    type(face_system_t), intent(inout) :: self  !< gets share and diagonal
    real(dp) :: block(3, 3), f, d
    integer :: i, j, k
    allocate (self%share(self%start(size(self%start))), self%diagonal(self%start(size(self%start))))
    !$omp parallel do schedule(static) private(block, f, d, j, k) if(size(self%list) > few)
    do i = 1, size(self%list)
      j = self%list(i)
      block = self%compliance%own(j)
      do k = 1, self%rank(j)
        f = dot_product(self%r(k, :, j), matmul(block, self%r(k, :, j)))
        d = max(0._dp, self%d(k, k, j))
        self%share(self%start(i) + k) = (f/(f + d))**2
        self%diagonal(self%start(i) + k) = (1 - (f/(f + d))**2)/(f + d)
      end do
    end do
    !$omp end parallel do
  end subroutine weigh

  !> Rows and columns of the unknowns one behind the other, for fast products.
  subroutine pack_rows(self, border)
    class(face_system_t), intent(inout) :: self  !< gets at, span, rows, columns, law
    type(border_t), allocatable, intent(in) :: border  !< with S
    real(dp) :: side(3)
    integer :: i, j, k, l, n
    n = self%start(size(self%start))
    allocate (self%at(n), self%rows(3, n), self%columns(3, n), self%law(3, n), self%span(2, size(self%rank)))
    allocate (self%right(n, self%more), self%below(n, self%more))
    self%span(1, :) = 1
    self%span(2, :) = 0
    !$omp parallel do schedule(static) private(j, k, l, side) if(size(self%list)*(8 + self%more) > 8*few)
    do i = 1, size(self%list)
      j = self%list(i)
      self%span(:, j) = self%start(i:i + 1) + [1, 0]
      do l = self%span(1, j), self%span(2, j)
        self%at(l) = j
        self%rows(:, l) = self%r(l - self%start(i), :, j)
        self%columns(:, l) = self%p(:, l - self%start(i), j)
        self%law(:, l) = self%d(l - self%start(i), :, j)
        do k = 1, self%more
          side = 0
          if (self%column(k) > 0) side = border%side(:, j, self%column(k))
          self%right(l, k) = sum(self%rows(:, l)*side)
          self%below(l, k) = self%fold*sum(self%columns(:, l)*side)
        end do
      end do
    end do
    !$omp end parallel do
    do k = 1, self%struts
      if (self%blind(k)) self%below(:, k) = 0
    end do
  end subroutine pack_rows

  !> Preconditioner of the border: D less S^T F^-1 S, with the preconditioner of the face for F^-1.
  subroutine eliminate_border(self, error)
    class(face_system_t), intent(inout) :: self       !< gets answer, factor
    type(error_t), allocatable, intent(out) :: error  !< singular
    real(dp) :: matrix(self%more, self%more)
    integer :: k
    allocate (self%answer, mold=self%right)
    allocate (self%factor(self%more, self%more), source=0._dp)
    do k = 1, self%more
      call approximate_points(self, self%right(:, k), self%answer(:, k), error)
      if (allocated(error)) return
      self%factor(k, k) = 1
    end do
    matrix = self%corner - matmul(transpose(self%below), self%answer)
    call solve_dense(matrix, self%factor, error)
  end subroutine eliminate_border

  !> y = (R F P + T P / a) x.
  subroutine multiply_face(self, x, y)
    class(face_system_t), intent(inout) :: self  !< system
    real(dp), intent(in), contiguous :: x(:)     !< unknowns [N]
    real(dp), intent(out), contiguous :: y(:)    !< rows [m]
    real(dp) :: force(size(self%strut_forces, 1))
    integer :: j, k, l, n
    n = size(self%at)
    !$omp parallel do schedule(static, thread_share) private(l) if(n > many/8)
    do j = 1, size(self%f, 2)
      self%f(:, j) = 0
      do l = self%span(1, j), self%span(2, j)
        self%f(:, j) = self%f(:, j) + self%columns(:, l)*x(l)
      end do
    end do
    !$omp end parallel do
    call self%compliance%apply(self%single, self%f, self%w)
    force = product_of(self%strut_forces(:, :n), x(:n))
    !$omp parallel do schedule(static) private(j, k) if(n > many/8)
    do l = 1, n
      j = self%at(l)
      y(l) = sum(self%rows(:, l)*self%w(:, j)) - dot_product(self%strut_right(:, l), force)
      do k = self%span(1, j), self%span(2, j)
        y(l) = y(l) + self%law(k - self%span(1, j) + 1, l)*x(k)
      end do
    end do
    !$omp end parallel do
    if (self%more == 0) return
    call add_columns(self%right, x(n + 1:), y(:n))
    do k = 1, self%more
      y(n + k) = dot(n, x, self%below(:, k)) + dot_product(self%corner(k, :), x(n + 1:))
    end do
  end subroutine multiply_face

  !> Block elimination of the border, where there is one.
  subroutine approximate_face(self, x, y, error)
    class(face_system_t), intent(inout) :: self       !< system
    real(dp), intent(in), contiguous :: x(:)          !< rows [m]
    real(dp), intent(out), contiguous :: y(:)         !< unknowns [N]
    type(error_t), allocatable, intent(out) :: error  !< memory
    integer :: k, n
    n = size(self%at)
    call approximate_points(self, x(:n), y(:n), error)
    if (self%more == 0 .or. allocated(error)) return
    y(n + 1:) = matmul(self%factor, x(n + 1:) - [(dot(n, y, self%below(:, k)), k=1, self%more)])
    call add_columns(self%answer, -y(n + 1:), y(:n))
  end subroutine approximate_face

  !> Inverse of F between the rows, blended with the inverse diagonal where the law dominates. Values fade out beyond the closed
  !> points, and what is found there counts for these in the same way.
  subroutine approximate_points(self, x, y, error)
    class(face_system_t), intent(inout) :: self       !< system
    real(dp), intent(in), contiguous :: x(:)          !< rows [m]
    real(dp), intent(out), contiguous :: y(:)         !< unknowns [N]
    type(error_t), allocatable, intent(out) :: error  !< memory
    integer :: j, l
    !$omp parallel do schedule(static, thread_share) private(l) if(size(x) > many/8)
    do j = 1, size(self%w, 2)
      self%w(:, j) = 0
      do l = self%span(1, j), self%span(2, j)
        self%w(:, j) = self%w(:, j) + self%rows(:, l)*(self%share(l)*x(l))
      end do
    end do
    !$omp end parallel do
    do l = 1, size(self%fringe)
      self%w(:, self%fringe(l)) = self%w(:, self%fringe(l)) + self%fade(l)*self%w(:, self%from(l))
    end do
    call self%compliance%precondition(self%w, self%f, error)
    if (allocated(error)) return
    do l = size(self%fringe), 1, -1
      self%f(:, self%from(l)) = self%f(:, self%from(l)) + self%fade(l)*self%f(:, self%fringe(l))
    end do
    !$omp parallel do schedule(static) if(size(x) > many/8)
    do l = 1, size(x)
      y(l) = self%share(l)*sum(self%rows(:, l)*self%f(:, self%at(l))) + self%diagonal(l)*x(l)
    end do
    !$omp end parallel do
  end subroutine approximate_points
end module hd_face_system
