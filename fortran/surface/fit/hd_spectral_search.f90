! SPDX-License-Identifier: GPL-3.0-or-later
!> Search for the most likely spectrum of rings: slope, amplitude, a Gaussian probe, what folds back from beyond the grid, and white
!> noise. Likelihood of independent exponential modes (Whittle). At one slope the deviance has several minima: each that a grid of
!> probes shows is followed to its bottom by Fisher's scoring within the bounds (Levenberg and Marquardt).
module hd_spectral_search
  use hd_kinds, only: dp, pi
  use hd_lapack, only: solve_definite
  use hd_ring_table, only: ring_table_t
  use hd_spectral_model, only: spectral_model_t, slope_t, at_slope, power_of, mixed, shares
  implicit none
  private
  public :: trial_t, fixed_t, most_likely, best_at

  real(dp), parameter :: eased = 0.1_dp       !< what a step that succeeds makes of the damping
  real(dp), parameter :: held = 0.1_dp        !< width of a range of the share below which it is held: no slope is taken over it
  real(dp), parameter :: least_step = 0.1_dp  !< of its amplitude that a step leaves at least: it stays positive
  real(dp), parameter :: most_damp = 1e5_dp   !< where steps are so short that rounding rules,
  real(dp), parameter :: least_damp = 1e-7_dp !< and where they are Newton's
  real(dp), parameter :: settled = 1e-5_dp    !< fall of the deviance, whose 95 % lie at 3.84, that ends a search
  real(dp), parameter :: unchanged = 1e-7_dp  !< the same, relative, of amplitude and noise
  real(dp), parameter :: above_noise = 0.05_dp !< share of a ring's power that counts as signal at least, to begin with
  real(dp), parameter :: least_change = 0.2_dp, most_change = 5   !< of amplitude and noise in one step: they stay positive
  real(dp), parameter :: singular = 1e-14_dp  !< determinant over its largest value where noise and signal have one shape
  integer, parameter :: slopes = 17           !< of the grid over the slope, at a pass
  real(dp), parameter :: widest(2) = [4, 8]   !< probe: spacings, and 1/(2 pi f) of the last ring, of whose power it leaves e^-64
  integer, parameter :: probes = 9            !< of the grid over the probe

  !> One trial of the likelihood.
  type :: trial_t
    real(dp) :: n = 0, a = 0, v = 0, sigma = 0, alpha = 0   !< slope, amplitude, noise power, probe [m], detail that folds back
    real(dp) :: deviance = huge(0._dp)                      !< twice the ln likelihood below that of the data themselves
  end type trial_t

  !> What a search leaves alone.
  type :: fixed_t
    real(dp) :: noise = -1                    !< rms [m]; negative: free
    logical :: sharp = .false.                !< the probe is a point
    real(dp) :: fold = -1                     !< share of finer detail; negative: free
  end type fixed_t

contains

  !> The most likely point: over slopes on a grid that closes in, all else at its best.
  function most_likely(t, m, first, last, fixed, passes) result(best)
    type(ring_table_t), intent(in) :: t       !< rings
    type(spectral_model_t), intent(in) :: m   !< tables
    integer, intent(in) :: first, last        !< rings of the window
    type(fixed_t), intent(in) :: fixed        !< what is known
    integer, intent(in) :: passes             !< of the grid
    type(trial_t) :: best, x(slopes)
    real(dp) :: low, high
    integer :: i, pass, k
    low = m%n_low
    high = m%n_high
    do pass = 1, passes
      !$omp parallel do schedule(dynamic)
      do i = 1, slopes
        x(i) = best_at(t, m, first, last, fixed, low + (i - 1) * (high - low) / (slopes - 1))
      end do
      k = minloc(x%deviance, 1)
      if (x(k)%deviance < best%deviance .or. pass == 1) best = x(k)
      low = max(m%n_low, best%n - (high - low) / (slopes - 1))
      high = min(m%n_high, 2 * best%n - low)
    end do
  end function most_likely

  !> The most likely point at one slope. The share of finer detail has two ranges, with a kink of the expectation between them.
  type(trial_t) function best_at(t, m, first, last, fixed, n) result(best)
    type(ring_table_t), intent(in) :: t       !< rings
    type(spectral_model_t), intent(in) :: m   !< tables
    integer, intent(in) :: first, last        !< rings of the window
    type(fixed_t), intent(in) :: fixed        !< what is known
    real(dp), intent(in) :: n                 !< slope
    type(slope_t) :: s
    type(trial_t) :: x(0:probes)
    real(dp) :: straight(last - first + 1), folded(last - first + 1, 2), low(4), high(4), noise
    integer :: range, i, count_of
    s = at_slope(m, n)
    noise = noise_power(t, fixed%noise)
    low = [0._dp, max(noise, 0._dp), 0._dp, 0._dp]            ! of amplitude, noise, square of the probe, share
    high = [huge(n), merge(noise, huge(n), noise >= 0), min(widest(1) * m%spacing, widest(2) / (2 * pi * t%f(last)))**2, 1._dp]
    if (fixed%sharp) high(3) = 0
    count_of = merge(1, probes, fixed%sharp)
    do range = 1, merge(1, 2, fixed%fold >= 0)
      low(4) = merge(fixed%fold, 0.5_dp * (range - 1), fixed%fold >= 0)
      high(4) = merge(fixed%fold, 0.5_dp * range, fixed%fold >= 0)
      x%deviance = huge(n)
      do i = 1, count_of
        x(i)%sigma = sqrt(high(3)) * (real(i - 1, dp) / (probes - 1))**1.5_dp
        x(i)%alpha = 0.5_dp * (low(4) + high(4))
        call power_of(m, s, x(i)%sigma, first, last, straight, folded)
        call solve(t%p(first:last), t%m(first:last) / t%kappa, mixed(straight, folded, x(i)%alpha), noise, x(i))
      end do
      do i = 1, count_of
        if (x(i)%deviance > min(x(i - 1)%deviance, x(min(i + 1, probes))%deviance)) cycle
        call descend(t, m, s, first, last, low, high, x(i))
        if (x(i)%deviance < best%deviance) best = x(i)
      end do
    end do
    best%n = n
  end function best_at

  !> Power of known noise per area of the frequency plane; negative if not known.
  pure real(dp) function noise_power(t, noise)
    type(ring_table_t), intent(in) :: t       !< rings
    real(dp), intent(in) :: noise             !< rms [m]
    noise_power = -1
    if (noise >= 0) noise_power = noise**2 * t%step(1) * merge(t%step(2), 1._dp, t%dim == 2)
  end function noise_power

  !> From a point to the bottom of its valley, within bounds.
  subroutine descend(t, m, s, first, last, low, high, b)
    type(ring_table_t), intent(in) :: t       !< rings
    type(spectral_model_t), intent(in) :: m   !< tables
    type(slope_t), intent(in) :: s            !< tables at the slope
    integer, intent(in) :: first, last        !< rings of the window
    real(dp), intent(in) :: low(4), high(4)   !< bounds of amplitude, noise, square of the probe, share
    type(trial_t), intent(inout) :: b         !< where to start, with its deviance; the bottom
    real(dp), dimension(last - first + 1) :: p, w, straight, near, e
    real(dp) :: folded(last - first + 1, 2), nearby(last - first + 1, 2), j(last - first + 1, 4)
    real(dp) :: q(4), g(4), h(4, 4), step(4), damp, more, deviance
    logical :: free(4)
    integer :: turn, i
    p = t%p(first:last)
    w = t%m(first:last) / t%kappa
    q = [b%a, b%v, b%sigma**2, b%alpha]
    more = 1e-4_dp * m%spacing**2
    damp = 1e-3_dp
    call power_of(m, s, b%sigma, first, last, straight, folded)
    do turn = 1, 40
      call power_of(m, s, sqrt(q(3) + more), first, last, near, nearby)
      j(:, 1) = mixed(straight, folded, q(4))
      e = q(1) * j(:, 1) + q(2)
      j(:, 2) = 1
      j(:, 3) = q(1) * (mixed(near, nearby, q(4)) - j(:, 1)) / more
      j(:, 4) = q(1) * matmul(folded, (shares(high(4)) - shares(low(4))) / max(high(4) - low(4), held))
      do i = 1, 4
        j(:, i) = j(:, i) / e * sqrt(w)
      end do
      g = matmul((p / e - 1) * sqrt(w), j)
      h = matmul(transpose(j), j)
      free = high > low .and. .not. ((q <= low .and. g <= 0) .or. (q >= high .and. g >= 0)) .and. &
        [(h(i, i), i=1, 4)] > 0
      do
        step = newton_step(h, g, free, damp)
        step = min(max(q + step, low, [least_step * q(1), 0._dp, 0._dp, 0._dp]), high)
        call power_of(m, s, sqrt(step(3)), first, last, near, nearby)
        deviance = deviance_of(p, w, step(1) * mixed(near, nearby, step(4)) + step(2))
        if (deviance < b%deviance .or. damp > most_damp) exit
        damp = 10 * damp
      end do
      if (.not. deviance < b%deviance) exit
      q = step
      straight = near
      folded = nearby
      damp = max(eased * damp, least_damp)
      step(1) = b%deviance - deviance
      b%deviance = deviance
      if (step(1) < settled) exit
    end do
    b%a = q(1)
    b%v = q(2)
    b%sigma = sqrt(q(3))
    b%alpha = q(4)
  end subroutine descend

  !> Step of a damped normal equation (Levenberg and Marquardt) among the free unknowns; none where it is singular.
  function newton_step(h, g, free, damp) result(x)
    real(dp), intent(in) :: h(4, 4), g(4)     !< information and slope of the ln likelihood
    logical, intent(in) :: free(4)            !< unknowns that move
    real(dp), intent(in) :: damp              !< what is added to the diagonal, over it
    real(dp) :: x(4), a(4, 4), scale(4)
    logical :: definite
    integer :: i
    scale = [(merge(1 / sqrt(max(h(i, i), tiny(damp))), 0._dp, free(i)), i=1, 4)]
    do i = 1, 4
      a(:, i) = h(:, i) * scale * scale(i)
      a(i, i) = a(i, i) + merge(damp, 1._dp, free(i))
    end do
    x = g * scale
    call solve_definite(a, x, definite)
    x = merge(x * scale, 0._dp, definite)
  end function newton_step

  !> Amplitude and noise, neither negative, of least deviance for a given shape: weighted least squares again and again.
  pure subroutine solve(p, m, x, known, b)
    real(dp), intent(in) :: p(:), m(:)        !< power, independent modes of the rings
    real(dp), intent(in) :: x(:)              !< shape
    real(dp), intent(in) :: known             !< noise power, or negative
    type(trial_t), intent(inout) :: b         !< a, v and deviance are set
    real(dp) :: a, v, w(size(p)), xx, x1, one, px, p1, det, deviance, old
    integer :: i
    b%v = max(known, 0._dp)
    b%a = sum(m * p / x) / sum(m)
    if (known <= 0) b%deviance = deviance_of(p, m, b%a * x)
    if (known == 0) return
    if (known < 0) v = 0.5_dp * minval(p)
    if (known > 0) v = known
    a = max(sum(m * max(p - v, above_noise * p) / x) / sum(m), tiny(a))
    if (known > 0) b%deviance = huge(a)
    old = huge(a)
    do i = 1, 14
      w = m / (a * x + v)**2
      xx = sum(w * x * x)
      px = sum(w * x * p)
      x1 = sum(w * x)
      one = sum(w)
      p1 = sum(w * p)
      if (known > 0) then
        a = min(max((px - v * x1) / xx, least_change * a), most_change * a)
      else
        det = xx * one - x1**2
        if (.not. det > singular * xx * one) exit
        a = min(max((one * px - x1 * p1) / det, least_change * a), most_change * a)
        v = min(max((xx * p1 - x1 * px) / det, least_change * v), most_change * v)
      end if
      deviance = deviance_of(p, m, a * x + v)
      if (deviance < b%deviance) then
        b%a = a
        b%v = v
        b%deviance = deviance
      end if
      if (abs(deviance - old) < unchanged * (1 + deviance)) exit
      old = deviance
    end do
  end subroutine solve

  !> Twice the ln likelihood that an expectation loses against the data themselves.
  pure real(dp) function deviance_of(p, m, e)
    real(dp), intent(in) :: p(:), m(:), e(:)  !< power, independent modes, expectation
    deviance_of = 2 * sum(m * (p / e - 1 - log(p / e)))
  end function deviance_of
end module hd_spectral_search
