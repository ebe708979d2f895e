! SPDX-License-Identifier: GPL-3.0-or-later
!> Compliance of bodies of any shape at their contact: MUMPS eliminates all but the face nodes of each body, LAPACK inverts
!> the Schur complement that is left.
module hd_schur
  use hd_kinds, only: dp
  use hd_compliance, only: compliance_t
  use hd_error, only: error_t
  use hd_lapack, only: invert_symmetric, multiply_symmetric
  use hd_metis, only: nested_dissection
  use hd_mumps, only: mumps_t, positive_definite, ordering_given
  use hd_problem, only: problem_t, assemble_stiffness
  use hd_symmetry, only: symmetry_t
  implicit none
  private
  public :: schur_t, new_schur

  !> One body: its factors, and the compliance of its free face dofs.
  type :: schur_side_t
    type(mumps_t) :: mumps                          !< interior
    integer, pointer :: row(:) => null(), col(:) => null()
    real(dp), pointer :: val(:) => null()
    integer :: first = 0, nodes = 0                 !< nodes before the body, and of it
    integer :: dofs = 0                             !< free dofs
    integer, allocatable :: equation(:, :)          !< their numbers, 0 where fixed (3, nodes)
    integer, allocatable :: face(:)                 !< equation of each row of c
    integer, allocatable :: place(:, :)             !< row of c of each dof, 0 elsewhere (3, nodes)
    real(dp), pointer :: c(:, :) => null()          !< compliance (face dofs, face dofs) [m/N]
    integer, allocatable :: ptr(:), node(:)         !< weights by multiplier: node of the body
    real(dp), allocatable :: weight(:)
  end type schur_side_t

  type, extends(compliance_t) :: schur_t
    type(schur_side_t), allocatable :: sides(:)
    logical :: ready = .false.
  contains
    procedure :: prepare => prepare_schur
    procedure :: solve => solve_schur
    procedure :: apply => apply_schur
    procedure :: precondition => precondition_schur
    procedure :: add_column => add_schur_column
    procedure :: release => release_schur
  end type schur_t

contains

  !> Number the dofs of every body; factors are made by prepare.
  subroutine new_schur(problem, schur, error)
    type(problem_t), intent(inout) :: problem         !< problem; gets its sparse stiffness
    type(schur_t), intent(out) :: schur               !< compliance
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    integer :: a, b, c, i, j, k, n
    logical, allocatable :: on_face(:)
    call assemble_stiffness(problem, error)
    if (allocated(error)) return
    schur%name = 'condensed by Schur complement'
    schur%ordering_asked = ordering_given
    allocate (schur%sides(size(problem%bodies)))
    do b = 1, size(problem%bodies)
      associate (side => schur%sides(b), mortar => problem%mortar)
        side%first = problem%first(b)
        side%nodes = problem%bodies(b)%nodes()
        allocate (side%equation(3, side%nodes), side%place(3, side%nodes), source=0)
        allocate (on_face(side%nodes), source=.false.)
        allocate (side%ptr(mortar%n + 1), side%node(size(mortar%col)), side%weight(size(mortar%col)))
        n = 0
        do j = 1, mortar%n
          side%ptr(j) = n + 1
          do k = mortar%ptr(j), mortar%ptr(j + 1) - 1
            i = mortar%col(k) - side%first
            if (i < 1 .or. i > side%nodes) cycle
            n = n + 1
            side%node(n) = i
            side%weight(n) = mortar%val(k)
            on_face(i) = .true.
          end do
        end do
        side%ptr(mortar%n + 1) = n + 1
        allocate (side%face(0))
        do a = 1, side%nodes
          do c = 1, 3
            if (problem%fixed(c, side%first + a)) cycle
            side%dofs = side%dofs + 1
            side%equation(c, a) = side%dofs
            if (.not. on_face(a)) cycle
            side%face = [side%face, side%dofs]
            side%place(c, a) = size(side%face)
          end do
        end do
        deallocate (on_face)
      end associate
    end do
  end subroutine new_schur

  !> Eliminate the interiors and invert what is left, once.
  subroutine prepare_schur(self, problem, symmetry, error)
    class(schur_t), intent(inout) :: self             !< compliance
    type(problem_t), intent(in) :: problem            !< problem
    type(symmetry_t), intent(in) :: symmetry          !< not used
    type(error_t), allocatable, intent(out) :: error  !< body not held, memory
    integer, allocatable :: position(:)
    integer :: b
    if (self%ready .or. symmetry%order() > 4) return
    self%factor_entries = 0
    do b = 1, size(self%sides)
      associate (side => self%sides(b))
        call lay_out(problem, side)
        if (size(side%face) == side%dofs) then
          call take_whole(side, error)
          if (allocated(error)) return
          cycle
        end if
        call order_side(problem, side, position, error)
        if (allocated(error)) return
        call side%mumps%analyse(positive_definite, side%dofs, side%row, side%col, side%val, position, error, side%face)
        if (allocated(error)) return
        allocate (side%c(size(side%face), size(side%face)), source=0._dp)
        call side%mumps%factorise(error, side%c)
        if (allocated(error)) return
        call invert_symmetric(side%c, error)
        if (allocated(error)) return
        self%library = side%mumps%version
        if (self%ordering_used == 'none') then
          self%ordering_used = side%mumps%ordering_used
        else if (self%ordering_used /= side%mumps%ordering_used) then
          self%ordering_used = trim(self%ordering_used)//', '//side%mumps%ordering_used
        end if
        self%factor_entries = self%factor_entries + side%mumps%factor_entries
      end associate
    end do
    self%ready = .true.
  end subroutine prepare_schur

  !> Compliance of a body all of whose dofs are on the face: there is nothing to eliminate.
  subroutine take_whole(side, error)
    type(schur_side_t), intent(inout) :: side         !< laid out; gets its compliance
    type(error_t), allocatable, intent(out) :: error  !< body not held
    integer :: i
    allocate (side%c(side%dofs, side%dofs), source=0._dp)
    do i = 1, size(side%val)
      side%c(side%col(i), side%row(i)) = side%c(side%col(i), side%row(i)) + side%val(i)
    end do
    call invert_symmetric(side%c, error)
  end subroutine take_whole

  !> Lower triangle of the stiffness of a body.
  subroutine lay_out(problem, side)
    type(problem_t), intent(in) :: problem  !< problem
    type(schur_side_t), intent(inout) :: side     !< gets row, col, val
    integer :: a, b, c, d, k, n, pass, p, q
    do pass = 1, 2
      n = 0
      do a = 1, side%nodes
        do k = problem%stiffness%ptr(side%first + a), problem%stiffness%ptr(side%first + a + 1) - 1
          b = problem%stiffness%col(k) - side%first
          do d = 1, 3
            do c = 1, 3
              p = side%equation(c, a)
              q = side%equation(d, b)
              if (q == 0 .or. p < q) cycle
              n = n + 1
              if (pass == 1) cycle
              side%row(n) = p
              side%col(n) = q
              side%val(n) = problem%stiffness%val(c, d, k)
            end do
          end do
        end do
      end do
      if (pass == 1) allocate (side%row(n), side%col(n), side%val(n))
    end do
  end subroutine lay_out

  !> Nested dissection of the body, the face last.
  subroutine order_side(problem, side, position, error)
    type(problem_t), intent(in) :: problem            !< problem
    type(schur_side_t), intent(in) :: side                  !< body
    integer, allocatable, intent(out) :: position(:)  !< place of each unknown
    type(error_t), allocatable, intent(out) :: error  !< memory
    integer :: place(side%nodes), at(side%nodes), weight(side%nodes), a, c, i, n, pass
    associate (k => problem%stiffness, low => side%first)
      weight = max(1, count(side%equation > 0, 1))
      call nested_dissection(k%ptr(low + 1:low + side%nodes + 1) - k%ptr(low + 1) + 1, &
        k%col(k%ptr(low + 1):k%ptr(low + side%nodes + 1) - 1) - low, weight, place, error)
    end associate
    if (allocated(error)) return
    at(place) = [(i, i=1, side%nodes)]
    allocate (position(side%dofs))
    n = 0
    do i = 1, side%nodes
      a = at(i)
      do c = 1, 3
        if (side%equation(c, a) == 0 .or. side%place(c, a) > 0) cycle
        n = n + 1
        position(side%equation(c, a)) = n
      end do
    end do
    position(side%face) = n + [(pass, pass=1, size(side%face))]
  end subroutine order_side

  !> u = K^-1 f: condense to the face, multiply, expand.
  subroutine solve_schur(self, problem, f, u, error)
    class(schur_t), intent(inout) :: self             !< prepared
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: f(:, :)                   !< nodal forces (3, n) [N]
    real(dp), intent(out) :: u(:, :)                  !< displacements (3, n) [m]
    type(error_t), allocatable, intent(out) :: error  !< MUMPS
    real(dp), allocatable :: b(:, :), face(:)
    integer :: a, c, k
    if (problem%n == 0) return
    u = 0
    do k = 1, size(self%sides)
      associate (side => self%sides(k))
        b = reshape([(0._dp, a=1, side%dofs)], [side%dofs, 1])
        do a = 1, side%nodes
          do c = 1, 3
            if (side%equation(c, a) > 0) b(side%equation(c, a), 1) = f(c, side%first + a)
          end do
        end do
        allocate (face(size(side%face)))
        if (size(face) == side%dofs) then
          b(:, 1) = multiply_symmetric(side%c, b(:, 1))
        else
          call side%mumps%condense(b, face, error)
          if (.not. allocated(error)) call side%mumps%expand(multiply_symmetric(side%c, face), b, error)
          if (allocated(error)) return
        end if
        do a = 1, side%nodes
          do c = 1, 3
            if (side%equation(c, a) > 0) u(c, side%first + a) = b(side%equation(c, a), 1)
          end do
        end do
        deallocate (face)
      end associate
    end do
  end subroutine solve_schur

  !> w = F f.
  subroutine apply_schur(self, f, w)
    class(schur_t), intent(inout) :: self  !< prepared
    real(dp), intent(in) :: f(:, :)        !< forces (3, multipliers) [N]
    real(dp), intent(out) :: w(:, :)       !< relative displacements (3, multipliers) [m]
    real(dp), allocatable :: x(:)
    integer :: b, c, j, k, p
    w = 0
    do b = 1, size(self%sides)
      associate (side => self%sides(b))
        x = [(0._dp, j=1, size(side%face))]
        do j = 1, size(f, 2)
          do k = side%ptr(j), side%ptr(j + 1) - 1
            do c = 1, 3
              p = side%place(c, side%node(k))
              if (p > 0) x(p) = x(p) + side%weight(k)*f(c, j)
            end do
          end do
        end do
        x = multiply_symmetric(side%c, x)
        do j = 1, size(f, 2)
          do k = side%ptr(j), side%ptr(j + 1) - 1
            do c = 1, 3
              p = side%place(c, side%node(k))
              if (p > 0) w(c, j) = w(c, j) + side%weight(k)*x(p)
            end do
          end do
        end do
      end associate
    end do
  end subroutine apply_schur

  !> There is none; dense LU is used instead.
  subroutine precondition_schur(self, w, f, error)
    class(schur_t), intent(inout) :: self             !< compliance
    real(dp), intent(in) :: w(:, :)                   !< (3, multipliers)
    real(dp), intent(out) :: f(:, :)                  !< the same
    type(error_t), allocatable, intent(out) :: error  !< never set
    f = w
    if (.not. self%ready .or. allocated(error)) f = 0
  end subroutine precondition_schur

  !> Add the blocks F(list, j) diag(sign) to a column of blocks.
  subroutine add_schur_column(self, j, sign, list, column)
    class(schur_t), intent(in) :: self             !< prepared
    integer, intent(in) :: j                       !< multiplier that is loaded
    real(dp), intent(in) :: sign(3)                !< signs of its components
    integer, intent(in) :: list(:)                 !< multipliers that are looked at
    real(dp), intent(inout) :: column(:, :, :)     !< (3, 3, list) [m/N]
    integer :: b, c, d, i, k, l, p, q
    do b = 1, size(self%sides)
      associate (side => self%sides(b))
        do l = side%ptr(j), side%ptr(j + 1) - 1
          do i = 1, size(list)
            do k = side%ptr(list(i)), side%ptr(list(i) + 1) - 1
              do c = 1, 3
                q = side%place(c, side%node(l))
                if (q == 0) cycle
                do d = 1, 3
                  p = side%place(d, side%node(k))
                  if (p > 0) column(d, c, i) = column(d, c, i) + sign(c)*side%weight(k)*side%weight(l)*side%c(p, q)
                end do
              end do
            end do
          end do
        end do
      end associate
    end do
  end subroutine add_schur_column

  !> Give back all memory.
  subroutine release_schur(self)
    class(schur_t), intent(inout) :: self  !< compliance
    integer :: b
    if (.not. allocated(self%sides)) return
    do b = 1, size(self%sides)
      call self%sides(b)%mumps%release()
      if (associated(self%sides(b)%row)) deallocate (self%sides(b)%row, self%sides(b)%col, self%sides(b)%val)
      if (associated(self%sides(b)%c)) deallocate (self%sides(b)%c)
    end do
    deallocate (self%sides)
  end subroutine release_schur
end module hd_schur
