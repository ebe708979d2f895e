! SPDX-License-Identifier: GPL-3.0-or-later
!> Large displacements: tangent, rigid turns, patch, stretched bar, elastica, Newton's rate.
module test_rotation
  use hd_body, only: body_t
  use hd_check, only: check, check_close
  use hd_error, only: error_t
  use hd_hexahedron, only: elasticity_matrix, element_stiffness, hex20r, hex8, hex8i, points
  use hd_kinds, only: dp, pi
  use hd_problem, only: use_lagrangian, internal_residual, load_t, new_problem, new_state, problem_t, state_t, update_tangent
  use hd_static, only: solve_static
  use hd_total_lagrangian, only: cell_response, cell_t, lanes, new_cell
  use hd_test_bodies, only: block
  implicit none
  private
  public :: run_rotation

contains

  subroutine run_rotation()
    real(dp) :: worst(3)
    integer :: i
    call element_tangent(hex8, 8)
    call element_tangent(hex8i, 8)
    call element_tangent(hex20r, 20)
    call rigid_turn()
    call turned_patch()
    call stretched_bar()
    do i = 1, 3
      call elastica(20*2**(i - 1), worst(i))
    end do
    call check_close(worst(3), 0._dp, 1e-4_dp, 'cantilever against the elastica, displacement of the tip over the length')
    call check(all(worst(:2) > 7*worst(2:)), 'the error against the elastica falls with the cube of the cells')
  end subroutine run_rotation

  !> A distorted element: rigid turns are free of force, the tangent is symmetric and equals differences of the forces, at rest it
  !> is the linear stiffness.
  subroutine element_tangent(kind, n)
    integer, intent(in) :: kind, n
    real(dp) :: x(3, n), u(3, n), c(6, 6), ke(3*n, 3*n), k(3*n, 3*n)
    real(dp) :: f(3, n), plus(3, n), minus(3, n), noise(3, n), step, worst
    type(cell_t) :: cell
    type(error_t), allocatable :: error
    integer :: i, j
    call element(kind, x)
    do j = 1, n
      do i = 1, 3
        noise(i, j) = sin(7.3_dp*i + 3.1_dp*j*j)
      end do
    end do
    x = x + 0.05_dp*noise
    c = elasticity_matrix(1._dp, 0.3_dp)
    call element_stiffness(kind, x, c, ke, error)
    call new_cell(kind, x, spread(0._dp, 1, n), c, cell, error)
    call respond(cell, 0*x, f, k)
    call check_close(maxval(abs(k - ke)), 0._dp, 1e-15_dp, 'at rest the tangent is the linear stiffness')
    worst = 0
    do i = 1, 6
      call respond(cell, turned(x, 0.5_dp*i) - x, f)
      worst = max(worst, maxval(abs(f)))
    end do
    call check_close(worst, 0._dp, 1e-14_dp, 'a distorted element turned rigidly by up to 3 rad is free of forces')
    u = turned(x, 0.9_dp) - x + 0.08_dp*noise(:, n:1:-1)
    call respond(cell, u, f, k)
    call check_close(maxval(abs(k - transpose(k))), 0._dp, 1e-15_dp, 'the tangent is symmetric')
    call respond(cell, u, plus, along=noise)
    call check_close(maxval(abs(reshape(plus, [3*n]) - matmul(k, reshape(noise, [3*n])))), 0._dp, 1e-14_dp, &
      'the tangent times displacements is its product with them')
    worst = 0
    step = 1e-6_dp
    do j = 1, n
      do i = 1, 3
        u(i, j) = u(i, j) + step
        call respond(cell, u, plus)
        u(i, j) = u(i, j) - 2*step
        call respond(cell, u, minus)
        u(i, j) = u(i, j) + step
        worst = max(worst, maxval(abs(reshape(plus - minus, [3*n])/(2*step) - k(:, 3*(j - 1) + i))))
      end do
    end do
    call check_close(worst, 0._dp, 1e-9_dp, 'the tangent agrees with central differences')
    call check_close(norm2(sum(f, 2)), 0._dp, 1e-14_dp, 'the forces of a turned and strained element balance')
  end subroutine element_tangent

  !> Forces and tangent of one sector, the last; the others are strained otherwise.
  subroutine respond(cell, u, f, k, along)
    type(cell_t), intent(in) :: cell
    real(dp), intent(in) :: u(:, :)
    real(dp), intent(out) :: f(:, :)
    real(dp), intent(out), optional :: k(:, :)
    real(dp), intent(in), optional :: along(:, :)
    real(dp) :: many(lanes, 3, size(u, 2)), forces(lanes, 3, size(u, 2)), tangents(lanes, 3*size(u, 2), 3*size(u, 2))
    real(dp) :: kept(15*lanes*points), again(lanes, 3, size(u, 2))
    integer :: i, at(size(u, 2))
    at = [(i, i=1, size(at))]
    do i = 1, lanes
      many(i, :, :) = u*i/lanes
    end do
    forces = 0
    if (present(k)) then
      call cell_response(cell, at, many, forces, tangents)
      k = tangents(lanes, :, :)
    else if (present(along)) then
      call cell_response(cell, at, many, forces, along=spread(along, 1, lanes))
      again = 0
      call cell_response(cell, at, many, keep=kept)
      call cell_response(cell, at, 0*many, again, along=spread(along, 1, lanes), kept=kept)
      call check(all(again == forces), 'what is kept of the displacements gives the same product')
    else
      call cell_response(cell, at, many, forces)
    end if
    f = forces(lanes, :, :)
  end subroutine respond

  !> Corners (and mid-sides) of the cube [-1, 1]^3.
  subroutine element(kind, x)
    integer, intent(in) :: kind
    real(dp), intent(out) :: x(:, :)
    integer, parameter :: ends(2, 12) = reshape([1, 2, 2, 3, 3, 4, 4, 1, 5, 6, 6, 7, 7, 8, 8, 5, 1, 5, 2, 6, 3, 7, 4, 8], [2, 12])
    integer :: i
    x(:, :8) = reshape([-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1]*1._dp, [3, 8])
    if (kind /= hex20r) return
    do i = 1, 12
      x(:, 8 + i) = (x(:, ends(1, i)) + x(:, ends(2, i)))/2
    end do
  end subroutine element

  !> Points turned about an oblique axis.
  pure function turned(x, angle) result(y)
    real(dp), intent(in) :: x(:, :), angle
    real(dp) :: y(3, size(x, 2)), axis(3), c(3)
    integer :: i
    axis = [2._dp, -1._dp, 2._dp]/3
    do i = 1, size(x, 2)
      c = [axis(2)*x(3, i) - axis(3)*x(2, i), axis(3)*x(1, i) - axis(1)*x(3, i), axis(1)*x(2, i) - axis(2)*x(1, i)]
      y(:, i) = x(:, i)*cos(angle) + c*sin(angle) + axis*dot_product(axis, x(:, i))*(1 - cos(angle))
    end do
  end function turned

  !> A body turned rigidly by 90 degrees has no forces.
  subroutine rigid_turn()
    type(problem_t) :: problem
    type(state_t) :: state
    type(load_t) :: load
    real(dp) :: scale
    real(dp), allocatable :: r(:, :)
    call new_bar([3, 2, 2], [3._dp, 1._dp, 1._dp], 0.3_dp, problem, state, load)
    scale = maxval(abs(problem%stiffness%val))
    state%u = turned(problem%bodies(1)%x, pi/2) - problem%bodies(1)%x
    allocate (r, mold=state%u)
    call internal_residual(problem, load, state, r)
    call check_close(maxval(abs(r))/scale, 0._dp, 1e-14_dp, &
      'a body turned rigidly by 90 degrees is free of forces')
  end subroutine rigid_turn

  !> A bar of one element kind whose interface is empty.
  subroutine new_bar(n, size_of, nu, problem, state, load)
    integer, intent(in) :: n(3)
    real(dp), intent(in) :: size_of(3), nu
    type(problem_t), intent(out) :: problem
    type(state_t), intent(out) :: state
    type(load_t), intent(out) :: load
    type(error_t), allocatable :: error
    type(body_t) :: bodies(1)
    bodies(1) = block(n, [0._dp, 0._dp, 0._dp], size_of)
    bodies(1)%poisson = nu
    call new_problem(bodies, problem, error)
    if (.not. allocated(error)) call use_lagrangian(problem, error)
    call check(.not. allocated(error), 'the bar assembles')
    allocate (problem%mortar%node(0), problem%mortar%area(0))
    call new_state(problem, state)
    allocate (load%force(3, problem%n), load%displacement(3, problem%n), source=0._dp)
    allocate (load%gap(0))
  end subroutine new_bar

  !> A bar of distorted cells pulled to 1.2 times its length: with E = (1.2^2 - 1)/2 the St. Venant-Kirchhoff force is
  !> 1.2 young E per area at rest, the width shrinks by sqrt(1 - 2 nu E).
  subroutine stretched_bar()
    real(dp), parameter :: stretch = 1.2_dp, strain = (stretch**2 - 1)/2
    type(problem_t) :: problem
    type(state_t) :: state
    type(load_t) :: load
    real(dp), allocatable :: residuals(:)
    real(dp), allocatable :: r(:, :)
    call new_bar([3, 3, 3], [1._dp, 1._dp, 1._dp], 0.3_dp, problem, state, load)
    associate (x => problem%bodies(1)%x)
      call distort(problem)
      problem%fixed = abs(x) < 1e-9_dp
      problem%fixed(1, :) = problem%fixed(1, :) .or. abs(x(1, :) - 1) < 1e-9_dp
      where (problem%fixed(1, :)) load%displacement(1, :) = (stretch - 1)*x(1, :)
      state%u(1, :) = (stretch - 1)*x(1, :)
      call newton(problem, load, state, 12, residuals)
      allocate (r, mold=state%u)
      call internal_residual(problem, load, state, r)
      call check_close(sum(r(1, :), mask=abs(x(1, :) - 1) < 1e-9_dp)/(problem%bodies(1)%young*stretch*strain), 1._dp, 1e-12_dp, &
        'force of a bar pulled to 1.2 times its length')
      call check_close(maxval(abs(state%u(2:, :) - (sqrt(1 - 0.6_dp*strain) - 1)*x(2:, :))), 0._dp, 1e-12_dp, &
        'width of a bar pulled to 1.2 times its length')
    end associate
  end subroutine stretched_bar

  !> Move the inner nodes of the unit cube.
  subroutine distort(problem)
    type(problem_t), intent(inout) :: problem
    type(error_t), allocatable :: error
    integer :: i
    associate (x => problem%bodies(1)%x)
      do i = 1, problem%n
        if (.not. any(abs(x(:, i)) < 1e-9_dp .or. abs(x(:, i) - 1) < 1e-9_dp)) then
          x(:, i) = x(:, i) + 0.08_dp*[sin(5._dp*i), sin(3._dp*i), cos(2._dp*i)]
        end if
      end do
    end associate
    deallocate (problem%lagrangian)
    call use_lagrangian(problem, error)
  end subroutine distort

  !> Patch test: the surface follows a turn of 60 degrees with a uniform stretch, inner nodes (moved at rest) find the same field.
  subroutine turned_patch()
    type(problem_t) :: problem
    type(state_t) :: state
    type(load_t) :: load
    real(dp), allocatable :: exact(:, :), residuals(:)
    real(dp) :: stretch(3, 3)
    call new_bar([3, 3, 3], [1._dp, 1._dp, 1._dp], 0.3_dp, problem, state, load)
    associate (x => problem%bodies(1)%x)
      problem%fixed = spread(any(abs(x) < 1e-9_dp .or. abs(x - 1) < 1e-9_dp, 1), 1, 3)
      call distort(problem)
      stretch = reshape([1.002_dp, 1e-3_dp, 0._dp, 1e-3_dp, 0.999_dp, -5e-4_dp, 0._dp, -5e-4_dp, 1.001_dp], [3, 3])
      exact = turned(matmul(stretch, x), pi/3) - x
    end associate
    load%displacement = exact
    where (problem%fixed) state%u = exact
    where (.not. problem%fixed) state%u = turned(problem%bodies(1)%x, pi/3) - problem%bodies(1)%x
    call newton(problem, load, state, 12, residuals)
    call check_close(maxval(abs(state%u - exact)), 0._dp, 1e-10_dp, 'patch test under a turn of 60 degrees')
  end subroutine turned_patch

  !> Newton's method without contact; residuals relative to the first reactions.
  subroutine newton(problem, load, state, iterations, residuals)
    type(problem_t), intent(inout) :: problem
    type(load_t), intent(in) :: load
    type(state_t), intent(inout) :: state
    integer, intent(in) :: iterations
    real(dp), allocatable, intent(out) :: residuals(:)
    real(dp) :: r(3, problem%n), du(3, problem%n)
    type(error_t), allocatable :: error
    integer :: k
    allocate (residuals(0))
    do k = 1, iterations
      call internal_residual(problem, load, state, r)
      residuals = [residuals, norm2(pack(r, .not. problem%fixed))/norm2(r)]
      if (residuals(k) < 1e-12_dp) exit
      call update_tangent(problem, state%u)
      call solve_static(problem, 0*r, -r, du, error)
      if (allocated(error)) exit
      state%u = state%u + du
    end do
    call check(.not. allocated(error), 'the tangent can be solved')
  end subroutine newton

  !> Cantilever under a dead tip load against the elastica (Mattiasson 1981): P L^2 / E I = 1, 2, 5, 10; quadratic convergence.
  subroutine elastica(n, worst)
    integer, intent(in) :: n        !< cells
    real(dp), intent(out) :: worst  !< error of the tip's displacement over the length
    real(dp), parameter :: loads(4) = [1._dp, 2._dp, 5._dp, 10._dp], down(4) = [0.30172_dp, 0.49346_dp, 0.71379_dp, 0.81061_dp]
    real(dp), parameter :: in(4) = [0.05643_dp, 0.16064_dp, 0.38763_dp, 0.55500_dp]
    real(dp), parameter :: h = 0.005_dp
    type(problem_t) :: problem
    type(state_t) :: state
    type(load_t) :: load
    real(dp), allocatable :: residuals(:)
    logical, allocatable :: tip(:)
    real(dp) :: ratio
    integer :: i, k, m
    call new_bar([n, 1, 1], [1._dp, h, h], 0._dp, problem, state, load)
    problem%fixed = spread(problem%bodies(1)%x(1, :) < 1e-9_dp, 1, 3)
    tip = problem%bodies(1)%x(1, :) > 1 - 1e-9_dp
    worst = 0
    ratio = 0
    do i = 1, 4
      do k = 1, 4
        load%force = 0
        where (tip) load%force(2, :) = -(merge(0._dp, loads(max(1, i - 1)), i == 1)*(4 - k) + loads(i)*k)/4 &
          *200e9_dp*h**4/12/4
        call newton(problem, load, state, 25, residuals)
      end do
      m = size(residuals)
      ratio = max(ratio, residuals(m)/max(residuals(m - 1)**2, 1e-12_dp))
      worst = max(worst, abs(-sum(state%u(2, :), mask=tip)/4 - down(i)), abs(-sum(state%u(1, :), mask=tip)/4 - in(i)))
    end do
    call check(ratio < 1e4_dp, 'Newton converges quadratically on the elastica')
  end subroutine elastica
end module test_rotation
