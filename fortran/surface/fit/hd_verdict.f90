! SPDX-License-Identifier: GPL-3.0-or-later
!> Is a map fractal over the window of lags? A power law alone proves nothing (a sine gives D_s = 1.00, a square wave 1.50), so
!> the map is asked first for what is known not to be fractal, and the fit afterwards for bends and noise.
module hd_verdict
  use hd_kinds, only: dp, i8, pi
  use hd_error, only: error_t
  use hd_text, only: to_text, percent
  use hd_observation, only: observation_t
  use hd_structure_function, only: structure_line
  use hd_expectation, only: band_spectrum_t, d_lowest, d_highest, model_ridges
  use hd_structure_fit, only: fit_options_t, fit_t, try_noise
  implicit none
  private
  public :: verdict_t, judge_map, judge_fit, fractal, not_fractal, noise_dominated
  public :: noisy, noisy_estimate, smooth_end, smooth_estimate, determined, bent

  ! Bounds that both fits, of S and of the spectrum, are judged by. At D = 3 a map is noise, at D = 2 it is differentiable.
  !> D from which on it cannot be told from noise: the estimate of S, the low end of a spectrum's interval
  real(dp), parameter :: noisy = 2.97_dp
  real(dp), parameter :: noisy_estimate = 2.99_dp  !< the same of a spectrum's estimate over a window too narrow for an interval
  real(dp), parameter :: smooth = 2.02_dp          !< D below which it cannot be told from a differentiable map: the estimate of S
  real(dp), parameter :: smooth_end = 2.03_dp      !< the same of the high end of a spectrum's interval,
  real(dp), parameter :: smooth_estimate = 2.01_dp !< and of its estimate where the model is off by more than `bent`
  real(dp), parameter :: determined = 2.005_dp     !< low end of the interval of D from which on G = exp(b/(D - 2)) is determined
  real(dp), parameter :: bent = 0.1_dp             !< rms of ln S or ln power that a model may be off by: a tenth of S
  ! Bounds on a map alone.
  real(dp), parameter :: level_left = 1e-9_dp      !< range of heights less their plane, over their range, that a plane leaves
  integer, parameter :: rounding = 4   !< units in the last place that equal heights may differ by; four times that of a plane
  integer, parameter :: fewest_rows = 8            !< that S along columns is asked of
  real(dp), parameter :: still = 0.01_dp           !< square of an increment over the mean below which there is none,
  real(dp), parameter :: large = 4                 !< and above which it is a jump
  real(dp), parameter :: most_still = 0.5_dp       !< share of increments of a map of steps that are none; 0.08 of a Gaussian map,
  real(dp), parameter :: most_jumps = 0.7_dp       !< and of S in jumps; 0.26 of a Gaussian map
  real(dp), parameter :: square_wave = 0.4_dp      !< rms over range: 0.5 of a square wave, 0.35 of a sine
  real(dp), parameter :: returns = 0.05_dp   !< share of its largest value to which S falls at a period; S of noise never falls
  real(dp), parameter :: of_sine = 0.02_dp         !< rms distance of S from a sine's over its largest value
  real(dp), parameter :: flat_from = 0.9_dp   !< S at the first lag over its plateau, and over S at twice that lag, of white noise
  ! Bounds on noise in S.
  integer, parameter :: parts = 4                  !< of the window, of which the first and the last give its slopes
  real(dp), parameter :: asks = 0.03_dp            !< misfit from which on noise that was not asked for is tried
  real(dp), parameter :: explained = 0.5_dp        !< share of the residual that it must leave at most to be believed
  real(dp), parameter :: mostly = 0.5_dp           !< share of S at the first lag from which on the map is noise there,
  real(dp), parameter :: worth_saying = 0.05_dp    !< and is told of
  real(dp), parameter :: edge = 1e-3_dp   !< distance from an end of the range of D that is searched, where an estimate stands at it
  integer, parameter :: fractal = 1, not_fractal = 2, noise_dominated = 3

  !> One of the three, a name for what it is, and why.
  type :: verdict_t
    integer :: kind = fractal
    character(len=:), allocatable :: name, reason
  end type verdict_t

contains

  !> Constant, plane, steps, square wave, sine, other period, white noise; else `fractal`, still to be proved.
  subroutine judge_map(raw, z, first, v, error)
    real(dp), intent(in), contiguous :: raw(:, :)     !< heights as they came (nx, ny) [m]
    real(dp), intent(in), contiguous :: z(:, :)       !< heights less their plane [m]
    integer, intent(in) :: first                      !< first lag of the window
    type(verdict_t), intent(out) :: v                 !< what it is
    type(error_t), allocatable, intent(out) :: error  !< memory
    real(dp) :: low, high, rest
    logical, allocatable :: good(:, :)
    good = abs(raw) <= huge(low)
    low = minval(raw, good)
    high = maxval(raw, good)
    rest = maxval(z, good) - minval(z, good)
    v%name = 'fractal'
    v%reason = ''
    if (high - low <= rounding * epsilon(low) * max(abs(high), abs(low))) then
      v = verdict_t(not_fractal, 'constant', 'all heights are equal')
    else if (rest <= max(level_left * (high - low), 4 * rounding * epsilon(low) * max(abs(high), abs(low)))) then
      v = verdict_t(not_fractal, 'plane', 'heights lie on a plane to '//to_text(1e6_dp * rest)//' um')
    else
      call judge_line(raw, z, first, v, error)
    end if
  end subroutine judge_map

  !> Look at increments and at S over all lags, in the direction where the map is rougher.
  subroutine judge_line(raw, z, first, v, error)
    real(dp), intent(in), contiguous :: raw(:, :)     !< heights as they came (nx, ny) [m]
    real(dp), intent(in), contiguous :: z(:, :)       !< heights less their plane [m]
    integer, intent(in) :: first                      !< first lag of the window
    type(verdict_t), intent(inout) :: v               !< what it is
    type(error_t), allocatable, intent(out) :: error  !< memory
    real(dp), allocatable :: s(:), other(:), count(:)
    real(dp) :: quiet, jumps, flat
    integer :: period, i
    logical :: sine
    logical, allocatable :: good(:, :)
    allocate (s(size(z, 1) / 2), count(size(z, 1) / 2))
    call structure_line(z, [1, 0], [(i, i=1, size(s))], s, count, error)
    if (allocated(error)) return
    call increments(raw, z, quiet, jumps)
    if (size(z, 2) >= fewest_rows) then
      allocate (other(size(z, 2) / 2))
      deallocate (count)
      allocate (count(size(other)))
      call structure_line(z, [0, 1], [(i, i=1, size(other))], other, count, error)
      if (allocated(error)) return
      if (mean_good(other) > mean_good(s)) then
        s = other
        call increments(transpose(raw), transpose(z), quiet, jumps)
      end if
    end if
    where (.not. s <= huge(s)) s = 0
    call find_period(s, period, sine)
    flat = s(min(first, size(s))) / mean_good(s(size(s) / 2:))
    if (quiet > most_still .and. jumps > most_jumps) then
      v%kind = not_fractal
      v%name = 'steps'
      good = abs(z) <= huge(quiet)
      flat = square_wave * (maxval(z, good) - minval(z, good))
      if (period > 0 .and. sum(z**2, good) > flat**2 * count_of(good)) v%name = 'square wave'
      v%reason = percent(jumps)//' of S(1) sits in few jumps, '//percent(quiet)//' of the increments are nearly 0: S ~ tau, '// &
        'D_s = 1.5 without being fractal'
    else if (period > 0) then
      v%kind = not_fractal
      v%name = trim(merge('sine    ', 'periodic', sine))
      v%reason = 'S returns to nearly 0 at a lag of '//to_text(period)//' points: the profile repeats'
    else if (flat > flat_from .and. s(1) > flat_from * s(min(2 * first, size(s)))) then
      v%kind = noise_dominated
      v%name = 'white noise'
      v%reason = 'S is flat from the first lag on ('//percent(flat)//' of its plateau)'
    end if
  end subroutine judge_line

  !> Number of true entries.
  pure real(dp) function count_of(mask)
    logical, intent(in) :: mask(:, :)   !< entries
    count_of = real(count(mask, kind=i8), dp)
  end function count_of

  !> Shares of increments and jumps of the heights as they came or levelled, whichever is quieter.
  pure subroutine increments(raw, z, quiet, jumps)
    real(dp), intent(in) :: raw(:, :), z(:, :)  !< heights as they came, levelled [m]
    real(dp), intent(out) :: quiet, jumps       !< share of increments; share of S(1)
    real(dp) :: q, j
    call increments_of(z, quiet, jumps)
    call increments_of(raw, q, j)
    if (q <= quiet) return
    quiet = q
    jumps = j
  end subroutine increments

  !> Shares of nearly no increment (below a tenth of the rms) and of S carried by large ones (above twice the rms).
  pure subroutine increments_of(z, quiet, jumps)
    real(dp), intent(in) :: z(:, :)           !< heights [m]
    real(dp), intent(out) :: quiet, jumps     !< share of increments; share of S(1)
    real(dp) :: n, total, d, square
    integer :: i, j, pass
    total = 0
    n = 0
    quiet = 0
    jumps = 0
    do pass = 1, 2
      if (pass == 2) square = total / max(n, 1._dp)
      do j = 1, size(z, 2)
        do i = 1, size(z, 1) - 1
          d = (z(i + 1, j) - z(i, j))**2
          if (.not. d <= huge(d)) cycle
          if (pass == 1) then
            total = total + d
            n = n + 1
          else
            if (d < still * square) quiet = quiet + 1
            if (d > large * square) jumps = jumps + d
          end if
        end do
      end do
    end do
    quiet = quiet / max(n, 1._dp)
    jumps = jumps / max(total, tiny(total))
  end subroutine increments_of

  !> A lag at which S falls back to a twentieth of what it was before; and whether S is that of a sine.
  pure subroutine find_period(s, period, sine)
    real(dp), intent(in) :: s(:)        !< S at lags 1, 2, ... [m^2]
    integer, intent(out) :: period      !< lag, 0 if none
    logical, intent(out) :: sine        !< S(k) ~ 1 - cos(2 pi k / period)
    real(dp) :: top
    integer :: k, i
    period = 0
    sine = .false.
    top = 0
    do k = 1, size(s) - 1
      top = max(top, s(k))
      if (s(k) < returns * top .and. s(k) <= s(k + 1)) then
        period = k
        exit
      end if
    end do
    if (period == 0) return
    sine = sqrt(sum((s(:period) - 0.5_dp * top * (1 - cos(2 * pi * [(i, i=1, period)] / real(period, dp))))**2) / period) &
      < of_sine * top
  end subroutine find_period

  !> Judge what is left by the fit: bounds, bends, noise.
  subroutine judge_fit(o, p, options, r, v)
    type(observation_t), intent(in) :: o          !< S over the window
    type(band_spectrum_t), intent(in) :: p             !< model
    type(fit_options_t), intent(in) :: options    !< how it was fitted
    type(fit_t), intent(in) :: r                  !< the fit
    type(verdict_t), intent(inout) :: v           !< as it came from judge_map
    real(dp) :: head, foot, share, trial, rms
    integer :: n, m
    if (v%kind /= fractal) return
    n = count(o%share(1, :) > 0)            ! along the rows
    m = max(2, n / parts)
    head = log(o%s(m) / o%s(1)) / log(o%tau(m) / o%tau(1))
    foot = log(o%s(n) / o%s(n - m)) / log(o%tau(n) / o%tau(n - m))
    share = r%noise_variance * 2 / r%curve(1)
    if (.not. options%fit_noise .and. options%noise <= 0 .and. r%misfit > asks) then
      call try_noise(o, p, trial, rms)
      if (rms < explained * r%rms) share = trial
    end if
    if (share > mostly) then
      v%kind = noise_dominated
      v%name = 'noise'
      v%reason = 'white noise makes '//percent(share)//' of S at the first lag'
    else if (r%d > min(noisy, d_highest - edge)) then
      v%kind = noise_dominated
      v%name = 'noise'
      v%reason = 'S hardly rises with the lag (slope '//to_text(head)//' to '//to_text(foot)//'), as instrument noise does'
    else if (r%d < max(smooth, d_lowest + edge)) then
      v%kind = not_fractal
      v%name = 'smooth'
      v%reason = 'S ~ tau^'//to_text(0.5_dp * (head + foot))//': the map is differentiable over these lags'
    else if (r%misfit > bent) then
      v%kind = not_fractal
      v%name = 'bent'
      v%reason = 'ln S bends: its slope goes from '//to_text(head)//' to '//to_text(foot)//', the model is off by '// &
        percent(r%misfit)
    else if (r%interval(1, 1) < determined) then
      v%kind = not_fractal
      v%name = 'smooth'
      v%reason = 'the 95 % interval of D reaches 2, a differentiable map: G = exp(b/(D - 2)) is not determined'
    else
      v%reason = 'S follows the model within '//percent(merge(r%rms, r%misfit, p%model == model_ridges))//' over lags '// &
        to_text(o%lag(1))//' to '//to_text(maxval(o%lag))
      if (share > worth_saying) v%reason = v%reason//'; white noise makes '//percent(share)//' of S at the first lag'
    end if
  end subroutine judge_fit

  !> Mean of what is a number.
  pure real(dp) function mean_good(s)
    real(dp), intent(in) :: s(:)    !< numbers
    mean_good = sum(s, s <= huge(s)) / max(1, count(s <= huge(s)))
  end function mean_good
end module hd_verdict
