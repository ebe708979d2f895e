! SPDX-License-Identifier: GPL-3.0-or-later
!> Fit of D and G to the power over rings of frequency, told nothing: slope, amplitude, a Gaussian probe, what folds back from
!> beyond the grid, and white noise. Likelihood of independent exponential modes (Whittle); intervals by the profile of the
!> likelihood, so they lie within the range of D, hold the estimate and are as wide as the data cannot tell.
module hd_spectral_fit
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t, raise, code_input
  use hd_ring_table, only: ring_table_t
  use hd_crossover, only: crossover_t, find_crossover
  use hd_spectral_model, only: spectral_model_t, new_spectral_model, at_slope, power_of, mixed
  use hd_spectral_search, only: trial_t, fixed_t, most_likely, best_at
  use hd_text, only: to_text
  implicit none
  private
  public :: spectral_fit_t, fit_spectrum, quantile

  integer, parameter :: fewest = 6                      !< rings of a window: one more than unknowns
  real(dp), parameter :: better = 0.7_dp   !< misfit over that of the window before, none accepted, that a narrower one must reach
  real(dp), parameter :: of_two = 2.5_dp                !< `excused` of two laws: they are asked of all rings, which a window is not
  real(dp), parameter :: in_thousand = 3.09_dp          !< of a Gaussian, exceeded once in a thousand
  real(dp), parameter :: quantile = 3.841459_dp         !< of chi^2, one degree of freedom, 95 %
  !> Windows tried: tops over Nyquist's frequency, a factor 1.2 to 1.3 apart from where rings end; feet in waves over the shorter
  !> side, about a factor 1.6 apart from where they begin.
  real(dp), parameter :: tops(11) = [0.98_dp, 0.83_dp, 0.7_dp, 0.6_dp, 0.5_dp, 0.42_dp, 0.35_dp, 0.28_dp, 0.22_dp, 0.17_dp, 0.13_dp]
  real(dp), parameter :: feet(5) = [3.5_dp, 6._dp, 9._dp, 14._dp, 22._dp]
  real(dp), parameter :: shortest_window = 3            !< highest over lowest frequency
  real(dp), parameter :: excused = 0.02_dp              !< rms departure from the model that no test is asked about
  real(dp), parameter :: beside_probe = 3               !< highest frequency over the place where a bend down may be a probe
  integer, parameter :: fine = 5, coarse = 2            !< passes of the search over slopes

  !> What was found.
  type :: spectral_fit_t
    real(dp) :: d = 0, ln_g = 0               !< D, ln (G / 1 m)
    real(dp) :: interval(2, 2) = 0            !< 95 % (low and high; D, ln G) with misfit
    real(dp) :: sampling(2, 2) = 0            !< of sampling alone
    real(dp) :: cov(2, 2) = 0                 !< of D and ln G, from the interval and the ridge of the likelihood
    real(dp) :: probe = 0                     !< sigma of the Gaussian probe [m]
    real(dp) :: noise_variance = 0            !< white noise [m^2]
    real(dp) :: fold = 0                      !< share of finer detail that folds back
    real(dp) :: f_lo = 0, f_hi = 0            !< window [1/m]
    real(dp) :: deviance = 0                  !< goodness of fit
    integer :: freedom = 0                    !< its degrees of freedom
    real(dp) :: misfit = 0                    !< rms of ln power that the model is off by
    logical :: accepted = .false.             !< the window's misfit is within chance (one in a thousand) or 2 %
    real(dp) :: scatter = 1                   !< of single modes about their ring; 1 of a Gaussian isotropic field
    real(dp) :: aside = 1                     !< about those of nearly their direction; 1 of a Gaussian field
    real(dp), allocatable :: model(:)         !< expected power of the rings of the window
    integer :: first = 0, last = 0            !< rings of the window
    type(crossover_t) :: two                  !< two laws over all rings
    real(dp) :: one = 0                       !< deviance of one law over all rings, with probe, noise and finer detail
    logical :: crossed = .false.              !< two laws explain all rings as well as that, or better
  end type spectral_fit_t

contains

  !> Fit the widest window of frequencies that the model describes: among all from 3.5 waves per side to Nyquist's frequency.
  subroutine fit_spectrum(t, noise, r, error, from, to)
    type(ring_table_t), intent(in) :: t               !< rings
    real(dp), intent(in) :: noise                     !< known noise, rms [m]; negative: fitted
    type(spectral_fit_t), intent(out) :: r            !< result
    type(error_t), allocatable, intent(out) :: error  !< too few rings
    real(dp), intent(in), optional :: from, to        !< window that is wanted [1/m]
    type(spectral_model_t) :: m
    type(spectral_fit_t) :: trial
    type(fixed_t) :: fixed
    type(trial_t) :: best, b
    real(dp) :: widths(size(feet), size(tops))
    integer :: i, j, k, at(2), top
    fixed%noise = noise
    top = 1
    if (size(t%f) < fewest) then
      call raise(error, code_input, 'the map is too small for a spectrum: it gives '//to_text(size(t%f))//' rings of four '// &
        'modes; valid: six or more, about 24 x 24 points (a line: 64)')
      return
    end if
    m = new_spectral_model(t)
    do j = 1, size(tops)
      do i = 1, size(feet)
        widths(i, j) = tops(j) * t%nyquist / (feet(i) * t%df)
      end do
    end do
    do k = 1, size(widths)
      at = maxloc(widths)
      if (present(from) .and. present(to)) then
        call window(t, from, to, trial)
      else
        if (widths(at(1), at(2)) < shortest_window .and. k > 1) exit
        widths(at(1), at(2)) = 0
        call window(t, feet(at(1)) * t%df, tops(at(2)) * t%nyquist, trial)
      end if
      if (trial%last - trial%first + 1 < fewest) cycle
      b = most_likely(t, m, trial%first, trial%last, fixed, coarse)
      call judge(t, b, trial, noise)
      if (r%last == 0 .or. trial%accepted .or. (trial%misfit < better * r%misfit .and. .not. r%accepted)) then
        r = trial
        best = b
        top = at(2)
      end if
      if (trial%accepted .or. present(from)) exit
    end do
    if (r%last == 0) then
      call raise(error, code_input, 'no window of frequencies holds six rings of the spectrum; valid: a larger map, or a '// &
        'wider band')
      return
    end if
    if (top > 1 .and. top < size(tops) .and. r%accepted .and. .not. present(from)) then
      call window(t, r%f_lo, tops(top + 1) * t%nyquist, trial)      ! what lies beside a cliff is blurred by it
      if (trial%last - trial%first + 1 >= fewest) r = trial
    end if
    best = most_likely(t, m, r%first, r%last, fixed, fine)
    call judge(t, best, r, noise)
    call complete(t, m, best, fixed, r)
    if (.not. present(from)) call look_for_two(t, m, fixed, r)
  end subroutine fit_spectrum

  !> Whether two power laws explain all rings as well as one with probe, noise and finer detail, where that needs probe or noise.
  !> Both have five unknowns. In a map two laws may be less likely by what chance does once in twenty; but not where they bend down
  !> within a factor 3 of the highest frequency, as a probe does. In a profile, where white noise and a law of D = 3 are nearly
  !> alike, two laws that bend down must be likelier, and two that bend up by as much.
  subroutine look_for_two(t, m, fixed, r)
    type(ring_table_t), intent(in) :: t           !< rings
    type(spectral_model_t), intent(in) :: m       !< tables
    type(fixed_t), intent(in) :: fixed            !< what is known
    type(spectral_fit_t), intent(inout) :: r      !< two and crossed are set
    type(spectral_fit_t) :: whole
    type(trial_t) :: b
    real(dp) :: less
    call window(t, t%f(1), t%f(size(t%f)), whole)
    if (.not. (r%probe > 0 .or. r%noise_variance > 0) .and. r%accepted) return
    b = most_likely(t, m, whole%first, whole%last, fixed, fine)
    r%two = find_crossover(t, m, 1, size(t%f))
    r%one = b%deviance
    less = quantile
    if (r%two%n(2) > r%two%n(1) .and. r%two%f > t%f(size(t%f)) / beside_probe) less = 0
    if (t%dim == 1) less = merge(-quantile, 0._dp, r%two%n(2) < r%two%n(1))
    if (.not. r%two%inside .or. r%two%deviance > b%deviance + less) return
    b%deviance = r%two%deviance
    call judge(t, b, whole, -1._dp)
    r%crossed = whole%accepted .or. whole%misfit < of_two * excused
  end subroutine look_for_two

  !> The simplest explanation: of all with and without noise, probe and finer detail, the least deviance plus 2 for each that is
  !> there (Akaike). An estimate that leaves them free is off where they are absent, for none can be negative.
  function simplest(t, m, r, fixed) result(best)
    type(ring_table_t), intent(in) :: t       !< rings
    type(spectral_model_t), intent(in) :: m   !< tables
    type(spectral_fit_t), intent(in) :: r     !< window
    type(fixed_t), intent(in) :: fixed        !< what is known
    type(trial_t) :: best, b
    type(fixed_t) :: some
    real(dp) :: cost, least
    integer :: i, j, k
    least = huge(least)
    do k = 0, 1
      do j = 0, 1
        do i = 0, 2
          if (fixed%noise >= 0 .and. j > 0) cycle
          some = fixed_t(fixed%noise, k == 0, 0.5_dp * i)
          if (fixed%noise < 0 .and. j == 0) some%noise = 0
          b = most_likely(t, m, r%first, r%last, some, fine)
          cost = b%deviance + 2 * (j + k)
          if (cost < least) best = b
          least = min(cost, least)
        end do
      end do
    end do
  end function simplest

  !> Rings between two frequencies.
  subroutine window(t, lo, hi, r)
    type(ring_table_t), intent(in) :: t       !< rings
    real(dp), intent(in) :: lo, hi            !< frequencies [1/m]
    type(spectral_fit_t), intent(out) :: r    !< window set
    r%first = count(t%f < lo) + 1
    r%last = count(t%f <= hi)
    if (r%last < r%first) return
    r%f_lo = t%f(r%first)
    r%f_hi = t%f(r%last)
  end subroutine window

  !> Goodness of fit of a window.
  subroutine judge(t, b, r, noise)
    type(ring_table_t), intent(in) :: t           !< rings
    type(trial_t), intent(in) :: b                !< most likely point
    type(spectral_fit_t), intent(inout) :: r      !< window
    real(dp), intent(in) :: noise                 !< known noise or negative
    real(dp) :: more
    r%deviance = b%deviance
    r%freedom = max(1, r%last - r%first + 1 - merge(4, 3, noise < 0))
    more = r%deviance - r%freedom
    r%misfit = sqrt(max(0._dp, more) / (sum(t%m(r%first:r%last)) / t%kappa))
    ! chi^2 is exceeded once in a thousand (Wilson and Hilferty)
    r%accepted = r%misfit < excused .or. r%deviance < r%freedom * (1 - 2 / (9._dp * r%freedom) + in_thousand * &
      sqrt(2 / (9._dp * r%freedom)))**3
  end subroutine judge

  !> Estimates and intervals.
  subroutine complete(t, m, b, fixed, r)
    type(ring_table_t), intent(in) :: t           !< rings
    type(spectral_model_t), intent(in) :: m       !< tables
    type(trial_t), intent(inout) :: b             !< most likely point
    type(fixed_t), intent(in) :: fixed            !< what is known
    type(spectral_fit_t), intent(inout) :: r      !< result
    real(dp) :: straight(r%last - r%first + 1), folded(r%last - r%first + 1, 2)
    real(dp) :: more, variance, bend
    type(trial_t) :: c
    c = simplest(t, m, r, fixed)
    if (c%deviance < b%deviance) b = c
    r%d = d_of(t, c%n)
    r%ln_g = ln_g_of(t, c%n, log(c%a))
    r%probe = c%sigma
    r%fold = c%alpha
    r%noise_variance = c%v / (t%step(1) * merge(t%step(2), 1._dp, t%dim == 2))
    call power_of(m, at_slope(m, c%n), c%sigma, r%first, r%last, straight, folded)
    r%model = c%a * mixed(straight, folded, c%alpha) + c%v
    r%scatter = sum(t%m(r%first:r%last) * (t%scatter(r%first:r%last) - 1)) / sum(t%m(r%first:r%last))
    r%aside = sum(t%m(r%first:r%last) * (t%aside(r%first:r%last) - 1)) / sum(t%m(r%first:r%last))
    more = max(1._dp, r%deviance / r%freedom) * max(1._dp, r%scatter)
    call profile(t, m, b, fixed, r, quantile, r%sampling, bend)
    r%interval = r%sampling
    if (more > 1) call profile(t, m, b, fixed, r, quantile * more, r%interval, bend)
    r%sampling = reshape([min(r%sampling(1, 1), r%d), max(r%sampling(2, 1), r%d), min(r%sampling(1, 2), r%ln_g), &
      max(r%sampling(2, 2), r%ln_g)], [2, 2])
    r%interval = reshape([min(r%interval(1, :), r%sampling(1, :)), max(r%interval(2, :), r%sampling(2, :))], [2, 2], order=[2, 1])
    variance = ((r%interval(2, 1) - r%interval(1, 1)) / (2 * sqrt(quantile)))**2
    r%cov = variance * reshape([1._dp, bend, bend, bend**2], [2, 2])
    r%cov(2, 2) = r%cov(2, 2) + more * t%kappa / sum(t%m(r%first:r%last)) / (2 * (r%d - 2))**2
  end subroutine complete

  !> Slopes whose deviance is within a limit of the least, and the range of ln G along them.
  subroutine profile(t, m, b, fixed, r, limit, x, bend)
    type(ring_table_t), intent(in) :: t           !< rings
    type(spectral_model_t), intent(in) :: m       !< tables
    type(trial_t), intent(in) :: b                !< most likely point
    type(fixed_t), intent(in) :: fixed            !< what is known
    type(spectral_fit_t), intent(in) :: r         !< window
    real(dp), intent(in) :: limit                 !< of the deviance above the least
    real(dp), intent(out) :: x(2, 2)              !< low and high of D and ln G
    real(dp), intent(out) :: bend                 !< change of ln G with D along the profile
    integer, parameter :: count_of = 12
    type(trial_t) :: p
    real(dp) :: bound(2), in, out, room, each, lng, d(count_of + 1), g(count_of + 1)
    integer :: side, i
    do side = 1, 2
      in = b%n
      out = b%n
      do i = 0, 12                                ! outwards until outside
        out = b%n + (2 * side - 3) * 0.01_dp * 2**i
        out = min(max(out, m%n_low), m%n_high)
        p = best_at(t, m, r%first, r%last, fixed, out)
        if (p%deviance - b%deviance > limit .or. out <= m%n_low .or. out >= m%n_high) exit
        in = out
      end do
      if (p%deviance - b%deviance > limit) then
        do i = 1, 9
          p = best_at(t, m, r%first, r%last, fixed, 0.5_dp * (in + out))
          if (p%deviance - b%deviance > limit) then
            out = 0.5_dp * (in + out)
          else
            in = 0.5_dp * (in + out)
          end if
        end do
        bound(side) = 0.5_dp * (in + out)
      else
        bound(side) = out
      end if
    end do
    x(:, 1) = [d_of(t, bound(2)), d_of(t, bound(1))]
    x(:, 2) = r%ln_g
    each = t%kappa / sum(t%m(r%first:r%last))
    do i = 1, count_of + 1
      p = best_at(t, m, r%first, r%last, fixed, bound(1) + (i - 1) * (bound(2) - bound(1)) / count_of)
      d(i) = d_of(t, p%n)
      lng = ln_g_of(t, p%n, log(p%a))
      g(i) = lng
      room = sqrt(max(0._dp, limit - max(0._dp, p%deviance - b%deviance)) * each) / (2 * (d(i) - 2))
      x(1, 2) = min(x(1, 2), lng - room)
      x(2, 2) = max(x(2, 2), lng + room)
    end do
    d = d - sum(d) / size(d)
    bend = sum(d * g) / max(sum(d**2), tiny(bend))
  end subroutine profile

  !> D of a slope: the density of a map falls as f^-(8 - 2D), of a line as f^-(7 - 2D).
  pure real(dp) function d_of(t, n)
    type(ring_table_t), intent(in) :: t     !< rings
    real(dp), intent(in) :: n               !< slope
    d_of = 0.5_dp * (6 + t%dim - n)
  end function d_of

  !> ln G of an amplitude: A = G^(2(D-2)) / (4 pi), of a line (two-sided, Eq. 2) G^(2(D-2)) / 4.
  pure real(dp) function ln_g_of(t, n, ln_a)
    type(ring_table_t), intent(in) :: t     !< rings
    real(dp), intent(in) :: n, ln_a         !< slope, ln of the amplitude
    ln_g_of = (ln_a + log(merge(4 * pi, 4._dp, t%dim == 2))) / (2 * (d_of(t, n) - 2))
  end function ln_g_of
end module hd_spectral_fit
