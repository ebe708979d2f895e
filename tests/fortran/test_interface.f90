! SPDX-License-Identifier: GPL-3.0-or-later
!> The compliant interface law against closed forms of the exponential joint p = p_0 exp(x / h), k_t = 0.8 p / h.
module test_interface
  use hd_check, only: check, check_close
  use hd_tabulated_law, only: closure_table_t, new_closure_table, resolve_pressure, stiffness_at_pressure
  use hd_contact_law, only: contact_law_t, evaluate_law, frictional, open_state, slip_state, stick_state
  use hd_error, only: error_t
  use hd_kinds, only: dp
  use hd_micro_slip, only: micro_slip_t, new_micro_slip, sampled_shares
  use hd_problem, only: load_t, problem_t, state_t
  use hd_rate_law, only: asked_state, missed_work, rate_drive, rate_point_t, rate_slip, rate_stick
  use hd_test_bodies, only: press_blocks, solve
  implicit none
  private
  public :: run_interface

  real(dp), parameter :: h = 0.4e-6_dp, p0 = 1e3_dp

contains

  subroutine run_interface()
    call table_is_exact()
    call law_tangent(exponential())
    call law_tangent(mindlin())
    call shear_loop()
    call mindlin_curve(8._dp, 1e-9_dp)
    call mindlin_curve(8.2_dp, 1e-4_dp)  ! midway between two pressures of the table
    call steep_curve()
    call raised_bound()
    call turning_shear()
    call asked_states()
    call pressed_blocks()
  end subroutine run_interface

  !> Where k_t falls at once the slip still only grows between the samples: no slope is above three times a chord beside it.
  subroutine steep_curve()
    type(micro_slip_t) :: table
    real(dp) :: k(size(sampled_shares()), 2)
    real(dp), allocatable :: chord(:)
    integer :: n
    k = 1
    k(2*(size(k, 1)/4) + 1:, :) = 0.9_dp  ! from the end of a panel on
    table = new_micro_slip([0._dp, 1._dp], k)
    n = ubound(table%g, 1)
    chord = n*(table%g(1:, 1) - table%g(:n - 1, 1))
    call check(all(max(table%slope(:n - 1, 1), table%slope(1:, 1)) <= 3*chord + 1e-9_dp*maxval(chord)), &
      'a steep curve of slip does not fall')
  end subroutine steep_curve

  !> Table of the exponential joint from 1 kPa to 10 GPa.
  function exponential() result(table)
    type(closure_table_t) :: table
    type(error_t), allocatable :: error
    real(dp) :: x(41)
    integer :: i
    x = [(h*0.4_dp*i, i=0, 40)]
    call new_closure_table(x, p0*exp(x/h), p0*exp(x/h)/h, reshape(0.8_dp*p0*exp(x/h)/h, [1, 41]), table, error)
    call check(.not. allocated(error), 'a rising table is accepted')
  end function exponential

  !> The same, its k_t falling under shear as (1 - q/(mu p))^a; a = 1/3 (spheres, Mindlin) at x = 8 h, growing with x.
  function mindlin() result(table)
    type(closure_table_t) :: table
    type(error_t), allocatable :: error
    real(dp) :: x(41), share(size(sampled_shares())), k(size(share), 41)
    integer :: i
    share = sampled_shares()
    do i = 1, 41
      x(i) = h*0.4_dp*(i - 1)
      k(:, i) = 0.8_dp*p0*exp(x(i)/h)/h*(1 - share)**((i - 1)/60._dp)
    end do
    call new_closure_table(x, p0*exp(x/h), p0*exp(x/h)/h, k, table, error)
    call check(.not. allocated(error), 'a table over the shear is accepted')
  end function mindlin

  !> The interpolation reproduces the exponential, its tangent and the resolvent; falling tables are refused.
  subroutine table_is_exact()
    type(closure_table_t) :: table, bad
    type(error_t), allocatable :: error
    real(dp) :: x, p, found, k, kt, slope, c, worst(3), trial
    real(dp), parameter :: soft = 1e-3_dp*p0/h
    integer :: i
    table = exponential()
    worst = 0
    c = 1e13_dp
    do i = 1, 199
      x = 16*h*i/200._dp
      p = p0*exp(x/h)
      call stiffness_at_pressure(table, p, kt, slope)
      worst(2) = max(worst(2), abs(kt/(0.8_dp*p/h) - 1), abs(slope*h/0.8_dp - 1))
      trial = p + c*x
      call resolve_pressure(table, c, trial, found, k)
      worst(3) = max(worst(3), abs(found/p - 1))
      call resolve_pressure(table, soft, p + soft*x, found, k)
      worst(1) = max(worst(1), abs(found/p - 1), abs(k/(p/h) - 1))
    end do
    call check_close(worst(1), 0._dp, 1e-12_dp, 'the table interpolates pressure and tangent of an exponential joint exactly')
    call check_close(worst(2), 0._dp, 1e-12_dp, 'the table interpolates the tangential stiffness')
    call check_close(worst(3), 0._dp, 1e-6_dp, 'the resolvent finds the closure under a trial pressure')
    call resolve_pressure(table, c, -1.001_dp*h*c, p, k)
    call check_close(p, 0._dp, 0._dp, 'the faces part where the tangent of the first entry ends')
    call new_closure_table([0._dp, 1._dp], [2._dp, 1._dp], [1._dp, 1._dp], reshape([1._dp, 1._dp], [1, 2]), bad, error)
    call check(allocated(error), 'a falling table is refused')
  end subroutine table_is_exact

  !> The derivatives of the joint law agree with central differences in every state.
  subroutine law_tangent(table)
    type(closure_table_t), intent(in) :: table
    type(contact_law_t) :: law
    real(dp) :: t(3), w(3), before(3), r(3), dw(3, 3), dt(3, 3), plus(3), minus(3), step(3), worst, cases(8, 5), c
    real(dp) :: skip(3, 3), leave(3, 3)
    real(dp) :: lead(2, 5)
    integer :: i, k, state, seen(0:2)
    c = 1e13_dp
    law = contact_law_t(frictional, 0.3_dp, c)
    law%joint = table
    cases = reshape([-1e6_dp, 0.1e6_dp, 0.05e6_dp, 1e-6_dp, 0.1e-6_dp, 0.2e-6_dp, 0._dp, 0._dp, &       ! open
      20e6_dp, 1e6_dp, -1e6_dp, -4e-6_dp, 0.01e-6_dp, 0.02e-6_dp, 2e6_dp, 1e6_dp, &                     ! stick
      20e6_dp, 9e6_dp, -4e6_dp, -4e-6_dp, 3e-6_dp, -2e-6_dp, 2e6_dp, 1e6_dp, &                          ! slip
      1e6_dp, -7e6_dp, 6e6_dp, -3e-6_dp, -5e-6_dp, 9e-6_dp, 0._dp, -1e6_dp, &
      20e6_dp, 3e6_dp, 2e6_dp, -4e-6_dp, -0.1e-6_dp, 0.02e-6_dp, 2e6_dp, 1e6_dp], [8, 5])               ! stick, shear grows
    lead = 1e6_dp*reshape([0._dp, 0._dp, 0.6_dp, 0.8_dp, 0.6_dp, -0.8_dp, 0._dp, 0._dp, 0._dp, 0._dp], [2, 5])
    worst = 0
    seen = 0
    do k = 1, 5
      t = cases(:3, k)
      w = cases(4:6, k)
      before = [0.8_dp*t(1), cases(7:, k)]
      call evaluate_law(law, t, w, before, lead(:, k), r, dw, dt, state)
      seen(state) = seen(state) + 1
      do i = 1, 3
        step = 0
        step(i) = 1e2_dp
        call evaluate_law(law, t + step, w, before, lead(:, k), plus, skip, leave, state)
        call evaluate_law(law, t - step, w, before, lead(:, k), minus, skip, leave, state)
        worst = max(worst, maxval(abs((plus - minus)/2e2_dp - dt(:, i))))
        step = step/c
        call evaluate_law(law, t, w + step, before, lead(:, k), plus, skip, leave, state)
        call evaluate_law(law, t, w - step, before, lead(:, k), minus, skip, leave, state)
        worst = max(worst, maxval(abs((plus - minus)/2e2_dp - dw(:, i)/c)))
      end do
    end do
    call check(all(seen > 0), 'the cases of the joint tangent test cover open, stick and slip')
    call check_close(worst, 0._dp, 1e-6_dp, 'the derivatives of the joint law agree with differences')
  end subroutine law_tangent

  !> Sheared to and fro under constant pressure, the law follows the elastoplastic loop of stiffness k_t and bound mu p.
  subroutine shear_loop()
    type(contact_law_t) :: law
    real(dp) :: t(3), u, old, tau, kt, p, worst, path(8)
    integer :: i, state, seen(0:2)
    law = contact_law_t(frictional, 0.3_dp, 1e13_dp)
    law%joint = exponential()
    p = p0*exp(8._dp)
    kt = 0.8_dp*p/h
    path = [0.2_dp, 0.35_dp, 0.6_dp, 0.4_dp, 0.1_dp, -0.5_dp, -0.4_dp, 0.7_dp]*h
    tau = 0
    old = 0
    worst = 0
    seen = 0
    t = [p, 0._dp, 0._dp]
    state = open_state
    do i = 1, size(path)
      u = path(i)
      tau = max(-0.3_dp*p, min(0.3_dp*p, tau - kt*(u - old)))
      call converge(law, [-8*h, u - old, 0._dp], t, state)
      worst = max(worst, abs(t(2) - tau)/p)
      seen(state) = seen(state) + 1
      old = u
    end do
    call check(seen(stick_state) > 2 .and. seen(slip_state) > 2 .and. seen(open_state) == 0, 'the shear loop sticks and slips')
    call check_close(worst, 0._dp, 1e-10_dp, 'the joint law follows the elastoplastic loop of stiffness k_t and bound mu p')
  end subroutine shear_loop

  !> Sheared from zero, Mindlin's joint follows q = mu p (1 - (1 - u/u_1)^(3/2)), u_1 = 3/2 mu p/k_t, whatever the steps, and slides
  !> beyond; unloaded, it goes back with k_t.
  subroutine mindlin_curve(closure, tolerance)
    real(dp), intent(in) :: closure    !< over h: the exponent of k_t there is a 24th of it
    real(dp), intent(in) :: tolerance  !< of shears, over the pressure
    type(contact_law_t) :: law
    real(dp) :: t(3), u, exact, kt, p, worst, last, power
    integer :: i, n, state
    law = contact_law_t(frictional, 0.3_dp, 1e13_dp)
    law%joint = mindlin()
    p = p0*exp(closure)
    kt = 0.8_dp*p/h
    power = 1/(1 - closure/24)
    last = power*0.3_dp*p/kt
    worst = 0
    do n = 1, 9, 4
      t = [p, 0._dp, 0._dp]
      state = open_state
      do i = 1, n + 1
        u = last*i/n
        call converge(law, [-closure*h, -0.6_dp*last/n, -0.8_dp*last/n], t, state)
        exact = 0.3_dp*p*(1 - max(0._dp, 1 - u/last)**power)
        worst = max(worst, norm2(t(2:) - exact*[0.6_dp, 0.8_dp])/p)
        if (i < n) call check(state == stick_state, 'micro-slip is not sliding')
      end do
      call check(state == slip_state, 'past the end of its curve the joint slides')
    end do
    call check_close(worst, 0._dp, tolerance, "the joint law follows Mindlin's curve under growing shear, whatever the steps")
    call converge(law, [-closure*h, 0.06_dp*last, 0.08_dp*last], t, state)
    call check_close(norm2(t(2:))/p, 0.3_dp*(1 - 0.1_dp*power), tolerance, 'unloaded, the joint goes back with k_t')
  end subroutine mindlin_curve

  !> A shear at its bound stays there while the pressure raises that by more or fewer steps and the point slips on; where it does
  !> not slip as far, the shear stays behind (Mindlin and Deresiewicz 1953).
  subroutine raised_bound()
    type(contact_law_t) :: law
    real(dp) :: t(3), p, way, worst(2)
    integer :: i, k, n, state
    law = contact_law_t(frictional, 0.3_dp, 1e13_dp)
    law%joint = mindlin()
    worst = 0
    do k = 1, 2
      do n = 1, 41, 20
        p = p0*exp(8._dp)
        way = merge(0.5_dp, 0.1_dp, k == 1)*h  ! to stay at the bound takes 0.3 dp/k_t, up to 0.083 h
        t = [p, 0.3_dp*p, 0._dp]
        state = slip_state
        do i = 1, n
          call converge(law, [-(8 + 0.2_dp*i/n)*h, -way/n, 0._dp], t, state)
        end do
        call check(state == slip_state, 'a point slides on under a pressure that rises')
        worst(k) = max(worst(k), abs(t(2)/(0.3_dp*t(1)) - 1))
      end do
    end do
    call check_close(worst(1), 0._dp, 1e-9_dp, 'the shear of a sliding point follows its bound, whatever the steps')
    call check_close(worst(2), 0._dp, 1e-9_dp, 'it does so as soon as the slip makes up for the rise')
  end subroutine raised_bound

  !> Tractions of a point whose gap and slip are given.
  subroutine converge(law, w, t, state)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: w(3)
    real(dp), intent(inout) :: t(3)
    integer, intent(inout) :: state
    real(dp) :: before(3), lead(2), r(3), dw(3, 3), dt(3, 3)
    integer :: k
    before = t
    lead = 0
    if (state == slip_state) lead = t(2:)
    do k = 1, 2000
      call evaluate_law(law, t, w, before, lead, r, dw, dt, state)
      t = t - r
    end do
  end subroutine converge

  !> Dragged in a new direction, the shear of a slipping point turns by tan(phi/2) = tan(phi_0/2) exp(-k_t u/(mu p)): second order.
  subroutine turning_shear()
    type(contact_law_t) :: law
    real(dp) :: t(3), p, u, error(3), exact
    integer :: i, k, n, state
    law = contact_law_t(frictional, 0.3_dp, 1e13_dp)
    law%joint = exponential()
    p = p0*exp(8._dp)
    u = 1.5_dp*0.3_dp*h/0.8_dp
    exact = 2*atan(tan(0.6_dp)*exp(-1.5_dp))
    do k = 1, 3
      n = 2**(k + 1)
      t = [p, 0.3_dp*p*cos(1.2_dp), 0.3_dp*p*sin(1.2_dp)]
      state = slip_state
      do i = 1, n
        call converge(law, [-8*h, -u/n, 0._dp], t, state)
      end do
      error(k) = abs(atan2(t(3), t(2)) - exact)
    end do
    call check(error(1) < 0.01_dp .and. error(3) < 1e-3_dp, 'the shear of a slipping point turns into the new direction')
    call check(all(error(2:)/error(:2) < 0.3_dp), 'the turn of the shear is of second order in the steps')
  end subroutine turning_shear

  !> Whatever state the rates of a point at its bound were found in, they ask for the state that obeys Coulomb's law; work misses it
  !> in the other state alone.
  subroutine asked_states()
    real(dp), parameter :: mu = 0.2_dp, k_0 = 3e13_dp, moves(4) = [-2e-9_dp, -1e-9_dp, 1e-10_dp, 1e-9_dp], &
      presses(3) = [-3e4_dp, 1e4_dp, 2e5_dp]
    type(rate_point_t) :: point, next
    real(dp) :: slip(2), traction(3), missed
    integer :: i, j, state, want
    logical :: alike, obeyed
    alike = .true.
    obeyed = .true.
    do i = 1, size(moves)
      do j = 1, size(presses)
        want = merge(rate_slip, rate_stick, -k_0*moves(i) > mu*presses(j))
        do state = rate_stick, rate_slip
          point = rate_point_t(state=state, at_bound=.true., direction=[0.6_dp, 0.8_dp], k_n=k_0, k_t=k_0/100, &
            k_0=k_0, grows=.false.)
          slip = moves(i)*point%direction
          traction(1) = presses(j)
          traction(2:) = merge(mu*presses(j), -k_0*moves(i), state == rate_slip)*point%direction
          next = asked_state(point, rate_drive(point, mu, 1e12_dp, slip, traction))
          alike = alike .and. next%state == want
          missed = missed_work(next, mu, slip, traction)/abs(k_0*moves(i)**2)
          obeyed = obeyed .and. merge(missed < 1e-12_dp, missed > 1e-6_dp, state == want)
        end do
      end do
    end do
    call check(alike, 'the state that rates ask for does not depend on the state they were found in')
    call check(obeyed, 'work misses the law in the wrong state alone')
  end subroutine asked_states

  !> Blocks whose meshes do not match, pressed by 80 MPa on an exponential joint, come closer by h ln(p / p_0) more than hard ones.
  subroutine pressed_blocks()
    real(dp), parameter :: pressure = 80e6_dp
    type(problem_t) :: problem
    type(load_t) :: load
    type(state_t) :: state
    real(dp), allocatable :: x(:, :), exact(:)
    call press_blocks(pressure, .false., problem, load, x)
    problem%law%joint = exponential()
    call solve(problem, spread(0._dp, 1, problem%mortar%n), load, state)
    exact = -pressure/200e9_dp*x(1, :)
    associate (first => problem%bodies(1)%nodes())
      exact(first + 1:) = exact(first + 1:) - h*log(pressure/p0)
    end associate
    call check_close(maxval(abs(state%u(1, :) - exact))/1e-5_dp, 0._dp, 1e-10_dp, &
      'blocks pressed on an exponential joint come closer by its closure')
    call check_close(maxval(abs(state%traction(1, :) - pressure))/pressure, 0._dp, 1e-9_dp, &
      'the pressure on an exponential joint is even')
  end subroutine pressed_blocks
end module test_interface
