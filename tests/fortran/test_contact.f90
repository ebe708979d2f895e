! SPDX-License-Identifier: GPL-3.0-or-later
module test_contact
  use hd_body, only: body_t
  use hd_check, only: check, check_close
  use hd_contact_law, only: contact_law_t, evaluate_law, frictional
  use hd_error, only: error_t, code_memory
  use hd_face, only: face_t
  use hd_hexahedron, only: hex8i
  use hd_kinds, only: dp, pi
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: mortar_t, new_mortar, relative_displacement
  use hd_mumps, only: check_mumps
  use hd_newton, only: iterate, iteration_t, newton_options_t
  use hd_newton_krylov, only: new_newton_krylov, newton_krylov_t
  use hd_problem, only: load_t, new_state, problem_t, state_t
  use hd_test_bodies, only: press_blocks, solve, two_rings
  implicit none
  private
  public :: run_contact

  !> A preconditioner that does nothing useful.
  type, extends(linear_solver_t) :: useless_t
  contains
    procedure :: update => keep_nothing
    procedure :: solve => give_back
    procedure :: release => release_nothing
  end type useless_t

contains

  subroutine run_contact()
    call law_tangent()
    call mortar_sums()
    call flat_patch(swap=.false.)
    call flat_patch(swap=.true.)
    call memory_message()
  end subroutine run_contact

  !> Where MUMPS runs out of memory the message holds its estimate and what to reduce.
  subroutine memory_message()
    type(error_t), allocatable :: error
    integer :: infog(16), i, codes(4)
    codes = [-8, -9, -13, -19]
    infog = 0
    infog(16) = 4321
    do i = 1, 4
      infog(1) = codes(i)
      call check_mumps(infog, 99, error)
      call check(error%code == code_memory .and. index(error%message, '4321 MB') > 0 .and. &
        index(error%message, 'take a coarser mesh') > 0, &
        'out of memory in MUMPS: estimate and what to reduce')
    end do
  end subroutine memory_message

  !> The derivatives of the law agree with central differences in every state.
  subroutine law_tangent()
    type(contact_law_t) :: law
    real(dp) :: t(3), w(3), r(3), dw(3, 3), dt(3, 3), plus(3), minus(3), step(3), worst, cases(6, 4), lead(2, 4)
    real(dp) :: skip(3, 3), leave(3, 3)
    real(dp), parameter :: none(3) = 0
    integer :: i, k, state, seen(0:2)
    law = contact_law_t(frictional, 0.3_dp, 2._dp)
    cases = reshape([1._dp, 0.1_dp, 0.05_dp, 3._dp, 0.1_dp, 0.2_dp, &      ! open
      2._dp, 0.1_dp, -0.1_dp, -0.2_dp, 0.05_dp, 0.02_dp, &                 ! stick
      2._dp, 0.9_dp, -0.4_dp, -0.1_dp, 0.3_dp, -0.2_dp, &                  ! slip
      1._dp, -0.7_dp, 0.6_dp, 0.1_dp, -0.5_dp, 0.9_dp], [6, 4])            ! slip the other way
    lead = reshape([0.6_dp, 0.8_dp, 0._dp, 1._dp, -0.6_dp, 0.8_dp, 0._dp, 0._dp], [2, 4])
    worst = 0
    seen = 0
    do k = 1, 4
      t = cases(:3, k)
      w = cases(4:, k)
      call evaluate_law(law, t, w, none, lead(:, k), r, dw, dt, state)
      seen(state) = seen(state) + 1
      do i = 1, 3
        step = 0
        step(i) = 1e-6_dp
        call evaluate_law(law, t + step, w, none, lead(:, k), plus, skip, leave, state)
        call evaluate_law(law, t - step, w, none, lead(:, k), minus, skip, leave, state)
        worst = max(worst, maxval(abs((plus - minus)/2e-6_dp - dt(:, i))))
        call evaluate_law(law, t, w + step, none, lead(:, k), plus, skip, leave, state)
        call evaluate_law(law, t, w - step, none, lead(:, k), minus, skip, leave, state)
        worst = max(worst, maxval(abs((plus - minus)/2e-6_dp - dw(:, i))))
      end do
    end do
    call check(all(seen > 0), 'the cases of the tangent test cover open, stick and slip')
    call check_close(worst, 0._dp, 1e-8_dp, 'the derivatives of the contact law agree with differences')
    call evaluate_law(law, [2._dp, 0._dp, 0._dp], none, none, [1e-170_dp, 0._dp], r, dw, dt, state)
    call check(all(abs(r) <= 0) .and. all(abs(dw) < huge(worst)), 'a shear whose square vanishes leads nowhere')
  end subroutine law_tangent

  !> On cylinders that do not match, equal rigid motions give no relative displacement and the areas add up.
  subroutine mortar_sums()
    type(body_t) :: a, b
    type(face_t) :: slave, master
    type(mortar_t) :: mortar
    real(dp), allocatable :: u(:, :)
    call two_rings(hex8i, 24, 17, a, b, slave, master)
    call new_mortar(slave, master, mortar)
    call check_close(sum(mortar%area)/(2*pi*20e-3_dp*5e-3_dp), 1._dp, 1e-13_dp, 'the mortar areas cover the cylinder')
    allocate (u(3, a%nodes() + b%nodes()))
    u(1, :) = 1
    u(2, :) = -2
    u(3, :) = 3
    call check_close(maxval(abs(relative_displacement(mortar, u))), 0._dp, 1e-11_dp, &
      'swelling, turning and shifting both cylinders alike opens no gap and causes no slip')
  end subroutine mortar_sums

  !> GMRES around a solver that is none stalls; exact factors give the same state.
  subroutine stall(problem, load, expected)
    type(problem_t), intent(inout) :: problem
    type(load_t), intent(in) :: load
    type(state_t), intent(in) :: expected
    class(linear_solver_t), allocatable :: near
    type(newton_krylov_t) :: solver
    type(state_t) :: rest, state
    type(iteration_t), allocatable :: history(:)
    type(error_t), allocatable :: error
    logical :: converged, sliding
    allocate (useless_t :: near)
    call new_newton_krylov(near, solver)
    call new_state(problem, rest)
    state = rest
    call iterate(problem, solver, newton_options_t(tolerance=1e-12_dp), load, rest, state, history, converged, sliding, error)
    call check(converged .and. .not. allocated(error) .and. allocated(solver%exact), 'exact factors take over where GMRES stalls')
    call check_close(maxval(abs(state%u - expected%u))/maxval(abs(expected%u)), 0._dp, 1e-10_dp, 'with the same answer')
    call solver%release()
  end subroutine stall

  subroutine keep_nothing(self, problem, dw, dt, error)
    class(useless_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    real(dp), intent(in) :: dw(:, :, :), dt(:, :, :)
    type(error_t), allocatable, intent(out) :: error
    self%unknowns = 3*problem%n + size(dw) - size(dt)
    if (allocated(error)) self%unknowns = 0
  end subroutine keep_nothing

  subroutine give_back(self, problem, r_u, r_c, du, dtraction, error)
    class(useless_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    real(dp), intent(in) :: r_u(:, :), r_c(:, :)
    real(dp), intent(out) :: du(:, :), dtraction(:, :)
    type(error_t), allocatable, intent(out) :: error
    du = merge(0._dp, -1e-12_dp*r_u, problem%fixed)
    dtraction = -r_c
    if (allocated(error)) self%unknowns = 0
  end subroutine give_back

  subroutine release_nothing(self)
    class(useless_t), intent(inout) :: self
    self%unknowns = 0
  end subroutine release_nothing

  !> Contact patch test: two blocks whose meshes do not match, pressed under load control, carry an even stress.
  subroutine flat_patch(swap)
    logical, intent(in) :: swap
    real(dp), parameter :: pressure = 80e6_dp
    type(problem_t) :: problem
    type(load_t) :: load
    type(state_t) :: state
    real(dp), allocatable :: x(:, :)
    call press_blocks(pressure, swap, problem, load, x)
    call solve(problem, spread(0._dp, 1, problem%mortar%n), load, state)
    call stall(problem, load, state)
    call check_close(maxval(abs(state%traction(1, :) - pressure))/pressure, 0._dp, 1e-10_dp, &
      'contact patch test, meshes that do not match, load control: even pressure')
    call check_close(maxval(abs(state%u(1, :) + pressure/200e9_dp*x(1, :)))/1e-5_dp, 0._dp, 1e-10_dp, &
      'contact patch test: exact displacements')
  end subroutine flat_patch
end module test_contact
