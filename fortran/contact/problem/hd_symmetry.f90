! SPDX-License-Identifier: GPL-3.0-or-later
!> Symmetry of a load step: half a turn about the axis, mirror planes that contain it. Found from the loads and the state
!> that the step starts from, never assumed.
module hd_symmetry
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_problem, only: problem_t, load_t, state_t
  use hd_vector, only: many
  implicit none
  private
  public :: symmetry_t, sharing_t, use_symmetry, symmetrise, share_law, same_shape, symmetry_name, image_sector, &
    node_images

  real(dp), parameter :: given = 1e-11_dp   !< relative difference of loads and places that are images: they differ by rounding,
  real(dp), parameter :: solved = 1e-7_dp   !< of displacements and tractions by what Newton's method leaves, above its tolerance
  !> Signs of (u_r, u_theta, u_z) and of tractions behind a mirror that contains the axis.
  real(dp), parameter, public :: mirror_sign(3) = [1._dp, -1._dp, 1._dp]

  type :: symmetry_t
    logical :: half_turn = .false.   !< fields repeat after half a turn
    integer :: mirror = 0            !< 0 none, 1 theta -> -theta, 2 theta -> pi - theta
  contains
    procedure :: order
    procedure, private :: equals
    generic :: operator(==) => equals
  end type symmetry_t

  !> Multipliers whose law counts for their images: rounding would close a point and open its image.
  type :: sharing_t
    integer, allocatable :: representative(:)      !< multiplier that counts for each one; unallocated without symmetry
    real(dp), allocatable :: sign(:, :)   !< of the components against the representative's (3, multipliers)
    logical, allocatable :: on_plane(:)   !< their own mirror images
  contains
    procedure :: take_law
  end type sharing_t

contains

  !> Parts of the model that are images of the one that is solved: 1, 2 or 4.
  elemental integer function order(self)
    class(symmetry_t), intent(in) :: self  !< symmetry
    order = merge(2, 1, self%half_turn)*merge(2, 1, self%mirror > 0)
  end function order

  !> Two symmetries are the same.
  elemental logical function equals(self, other)
    class(symmetry_t), intent(in) :: self   !< symmetry
    class(symmetry_t), intent(in) :: other  !< another
    equals = (self%half_turn .eqv. other%half_turn) .and. self%mirror == other%mirror
  end function equals

  !> full, half or quarter.
  pure function symmetry_name(symmetry) result(name)
    type(symmetry_t), intent(in) :: symmetry  !< symmetry
    character(len=7) :: name
    name = 'full'
    if (symmetry%order() == 2) name = 'half'
    if (symmetry%order() == 4) name = 'quarter'
  end function symmetry_name

  !> Use at most so many images.
  pure type(symmetry_t) function limit_symmetry(symmetry, most) result(less)
    type(symmetry_t), intent(in) :: symmetry  !< symmetry of the step
    integer, intent(in) :: most               !< 1, 2 or 4
    less = symmetry
    if (less%order() > most .and. less%half_turn) less%mirror = 0
    if (less%order() > most) less = symmetry_t()
  end function limit_symmetry

  !> Sector of the image of a node: half a turn, or behind a mirror.
  elemental integer function image_sector(sectors, sector, offset, mirror) result(image)
    integer, intent(in) :: sectors  !< of the body
    integer, intent(in) :: sector   !< of the node, from 0
    integer, intent(in) :: offset   !< 1 for nodes halfway to the next sector
    integer, intent(in) :: mirror   !< 0 half a turn, 1 theta -> -theta, 2 theta -> pi - theta
    select case (mirror)
    case (0); image = sector + sectors/2
    case (1); image = -sector - offset
    case default; image = sectors/2 - sector - offset
    end select
    image = modulo(image, sectors)
  end function image_sector

  !> Symmetry to be used in a load step: what it has, at most so many images.
  subroutine use_symmetry(problem, load, state, most, demanded, symmetry, error)
    type(problem_t), intent(in) :: problem            !< problem
    type(load_t), intent(in) :: load                  !< load at the end of the step
    type(state_t), intent(in) :: state                !< state at its beginning
    integer, intent(in) :: most                       !< images: 1, 2 or 4
    logical, intent(inout) :: demanded                !< fewer are an error; asked for in the first step only
    type(symmetry_t), intent(out) :: symmetry         !< to be used
    type(error_t), allocatable, intent(out) :: error  !< symmetry asked for is not there
    if (most > 1) symmetry = limit_symmetry(find_symmetry(problem, load, state), most)
    if (demanded .and. symmetry%order() < most) call raise(error, code_input, 'solver.symmetry asks for more than the '// &
      'scene has in its assembly: '//trim(symmetry_name(symmetry))//"; valid: 'auto'")
    demanded = .false.
  end subroutine use_symmetry

  !> Symmetry that meshes, load and state share.
  type(symmetry_t) function find_symmetry(problem, load, state) result(symmetry)
    type(problem_t), intent(in) :: problem  !< revolved bodies, supports the same in every sector
    type(load_t), intent(in) :: load        !< load at the end of the step
    type(state_t), intent(in) :: state      !< state at its beginning
    if (.not. all(problem%bodies%revolved) .or. allocated(problem%struts)) return
    symmetry%half_turn = holds(problem, load, state, 0)
    if (holds(problem, load, state, 1)) then
      symmetry%mirror = 1
    else if (holds(problem, load, state, 2)) then
      symmetry%mirror = 2
    end if
  end function find_symmetry

  !> One operation leaves load and state as they are.
  logical function holds(problem, load, state, mirror) result(yes)
    type(problem_t), intent(in) :: problem  !< problem
    type(load_t), intent(in) :: load        !< load
    type(state_t), intent(in) :: state      !< state
    integer, intent(in) :: mirror           !< operation, see image_sector
    integer :: image(problem%n), number(problem%n), partner(problem%mortar%n), j
    real(dp) :: sign(3)
    yes = .false.
    if (mirror /= 1 .and. any(modulo(problem%bodies%sectors, 2) == 1)) return
    sign = merge(mirror_sign, [1._dp, 1._dp, 1._dp], mirror > 0)
    image = node_images(problem, mirror)
    number = 0
    number(problem%mortar%node) = [(j, j=1, problem%mortar%n)]
    partner = number(image(problem%mortar%node))
    if (any(partner == 0)) return
    yes = same(load%displacement, image, sign, given)
    if (yes) yes = same(load%force, image, sign, given)
    if (yes) yes = all(abs(load%gap - load%gap(partner)) <= given*maxval(abs(load%gap)))
    if (yes) yes = same(state%u, image, sign, solved)
    if (yes) yes = same(state%traction, partner, sign, solved)
  end function holds

  !> Image of every node.
  function node_images(problem, mirror) result(image)
    type(problem_t), intent(in) :: problem  !< problem
    integer, intent(in) :: mirror           !< operation
    integer :: image(problem%n)
    integer :: a, b, m, s, offset
    do b = 1, size(problem%bodies)
      associate (body => problem%bodies(b))
        m = body%nodes_per_sector
        !$omp parallel do schedule(static) private(a, offset) if(body%nodes() > many)
        do s = 0, body%sectors - 1
          do a = 1, m
            offset = merge(1, 0, body%angle(a) > 0)
            image(problem%first(b) + s*m + a) = problem%first(b) + image_sector(body%sectors, s, offset, mirror)*m + a
          end do
        end do
        !$omp end parallel do
      end associate
    end do
  end function node_images

  !> Radii and heights of bodies that were formed have the symmetry too.
  logical function same_shape(round, formed, symmetry) result(yes)
    type(problem_t), intent(in) :: round      !< round bodies
    type(problem_t), intent(in) :: formed     !< bodies with the same nodes
    type(symmetry_t), intent(in) :: symmetry  !< of the load step
    real(dp) :: x(3, round%n)
    integer :: b
    do b = 1, size(formed%bodies)
      associate (body => formed%bodies(b))
        x(1, formed%first(b) + 1:formed%first(b) + body%nodes()) = hypot(body%x(1, :), body%x(2, :))
        x(2, formed%first(b) + 1:formed%first(b) + body%nodes()) = 0
        x(3, formed%first(b) + 1:formed%first(b) + body%nodes()) = body%x(3, :)
      end associate
    end do
    yes = .true.
    if (symmetry%half_turn) yes = same(x, node_images(round, 0), mirror_sign, given)
    if (yes .and. symmetry%mirror > 0) yes = same(x, node_images(round, symmetry%mirror), mirror_sign, given)
  end function same_shape

  !> A nodal field without what rounding has left of its other parts.
  subroutine symmetrise(problem, symmetry, u)
    type(problem_t), intent(in) :: problem    !< problem
    type(symmetry_t), intent(in) :: symmetry  !< of the field
    real(dp), intent(inout) :: u(:, :)        !< nodal field (3, n)
    if (symmetry%half_turn) u = (u + u(:, node_images(problem, 0)))/2
    if (symmetry%mirror > 0) u = (u + spread(mirror_sign, 2, problem%n)*u(:, node_images(problem, symmetry%mirror)))/2
  end subroutine symmetrise

  !> The first of its images stands for every node.
  subroutine choose_agents(problem, symmetry, representative, turned, on_plane)
    type(problem_t), intent(in) :: problem    !< problem
    type(symmetry_t), intent(in) :: symmetry  !< in use
    integer, intent(out) :: representative(:)          !< node that stands for each node, itself for some (n)
    logical, intent(out) :: turned(:)         !< mirrored against its representative (n)
    logical, intent(out) :: on_plane(:)       !< its own mirror image (n)
    integer :: image(problem%n), a, pass
    representative = [(a, a=1, problem%n)]
    turned = .false.
    on_plane = .false.
    if (symmetry%half_turn) representative = min(representative, node_images(problem, 0))
    if (symmetry%mirror == 0) return
    image = node_images(problem, symmetry%mirror)
    do pass = 1, merge(2, 1, symmetry%half_turn)
      if (pass == 2) image = image(node_images(problem, 0))
      on_plane = on_plane .or. image == [(a, a=1, problem%n)]
      turned = turned .or. image < representative
      representative = min(representative, image)
    end do
  end subroutine choose_agents

  !> Find the multipliers whose law counts for others.
  subroutine share_law(problem, symmetry, sharing)
    type(problem_t), intent(in) :: problem    !< problem
    type(symmetry_t), intent(in) :: symmetry  !< of the load step
    type(sharing_t), intent(out) :: sharing   !< who counts for whom
    integer :: representative(problem%n), number(problem%n), j
    logical :: turned(problem%n), on_plane(problem%n)
    if (symmetry%order() == 1) return
    call choose_agents(problem, symmetry, representative, turned, on_plane)
    associate (node => problem%mortar%node, n => problem%mortar%n)
      number(node) = [(j, j=1, n)]
      sharing%representative = number(representative(node))
      sharing%sign = spread(mirror_sign, 2, n)
      where (spread(.not. turned(node), 1, 3)) sharing%sign = 1
      sharing%on_plane = on_plane(node)
    end associate
  end subroutine share_law

  !> Replace the derivatives of the law by those that count.
  subroutine take_law(self, dw, dt)
    class(sharing_t), intent(in) :: self            !< sharing
    real(dp), intent(inout) :: dw(:, :, :)          !< dR/dw (3, 3, multipliers) [Pa/m]
    real(dp), intent(inout) :: dt(:, :, :)          !< dR/dt (3, 3, multipliers)
    integer :: i, j, k
    if (.not. allocated(self%representative)) return
    !$omp parallel do schedule(static) private(i, k) if(9*size(self%representative) > many)
    do j = 1, size(self%representative)
      i = self%representative(j)  ! stays as it is
      if (i == j) cycle
      do k = 1, 3
        dw(:, k, j) = dw(:, k, i)*self%sign(:, j)*self%sign(k, j)
        dt(:, k, j) = dt(:, k, i)*self%sign(:, j)*self%sign(k, j)
      end do
    end do
    !$omp end parallel do
  end subroutine take_law

  !> A field equals its image.
  logical function same(field, image, sign, tolerance) result(yes)
    real(dp), intent(in) :: field(:, :)  !< (3, points)
    integer, intent(in) :: image(:)      !< image of each point
    real(dp), intent(in) :: sign(3)      !< signs of the components
    real(dp), intent(in) :: tolerance    !< relative to the largest entry
    real(dp) :: largest, apart
    integer :: i
    largest = 0
    apart = 0
    !$omp parallel do schedule(static) reduction(max: largest, apart) if(size(field) > many)
    do i = 1, size(image)
      largest = max(largest, maxval(abs(field(:, i))))
      apart = max(apart, maxval(abs(field(:, i) - sign*field(:, image(i)))))
    end do
    !$omp end parallel do
    yes = apart <= tolerance*largest
  end function same
end module hd_symmetry
