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
  use hd_surface_fit, only: fit_options_t, fit_t, try_noise
  implicit none
  private
  public :: verdict_t, judge_map, judge_fit, fractal, not_fractal, noise_dominated

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
    if (high - low <= 4 * epsilon(low) * max(abs(high), abs(low))) then
      v = verdict_t(not_fractal, 'constant', 'all heights are equal')
    else if (rest <= max(1e-9_dp * (high - low), 16 * epsilon(low) * max(abs(high), abs(low)))) then
      v = verdict_t(not_fractal, 'plane', 'heights lie on a plane to '//to_text(rest)//' m')
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
    if (size(z, 2) > 7) then
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
    if (quiet > 0.5_dp .and. jumps > 0.7_dp) then
      v%kind = not_fractal
      v%name = 'steps'
      good = abs(z) <= huge(quiet)
      flat = 0.4_dp * (maxval(z, good) - minval(z, good))
      if (period > 0 .and. sum(z**2, good) > flat**2 * count_of(good)) v%name = 'square wave'
      v%reason = percent(jumps)//' of S(1) sits in few jumps, '//percent(quiet)//' of the increments are nearly 0: S ~ tau, '// &
        'D_s = 1.5 without being fractal'
    else if (period > 0) then
      v%kind = not_fractal
      v%name = trim(merge('sine    ', 'periodic', sine))
      v%reason = 'S returns to nearly 0 at a lag of '//to_text(period)//' points: the profile repeats'
    else if (flat > 0.9_dp .and. s(1) > 0.9_dp * s(min(2 * first, size(s)))) then
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
            if (d < 0.01_dp * square) quiet = quiet + 1
            if (d > 4 * square) jumps = jumps + d
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
      if (s(k) < 0.05_dp * top .and. s(k) <= s(k + 1)) then
        period = k
        exit
      end if
    end do
    if (period == 0) return
    sine = sqrt(sum((s(:period) - 0.5_dp * top * (1 - cos(2 * pi * [(i, i=1, period)] / real(period, dp))))**2) / period) &
      < 0.02_dp * top
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
    m = max(2, n / 4)
    head = log(o%s(m) / o%s(1)) / log(o%tau(m) / o%tau(1))
    foot = log(o%s(n) / o%s(n - m)) / log(o%tau(n) / o%tau(n - m))
    share = r%noise_variance * 2 / r%curve(1)
    if (.not. options%fit_noise .and. options%noise <= 0 .and. r%misfit > 0.03_dp) then
      call try_noise(o, p, trial, rms)
      if (rms < 0.5_dp * r%rms) share = trial
    end if
    if (share > 0.5_dp) then
      v%kind = noise_dominated
      v%name = 'noise'
      v%reason = 'white noise makes '//percent(share)//' of S at the first lag'
    else if (r%d > min(2.97_dp, d_highest - 1e-3_dp)) then
      v%kind = noise_dominated
      v%name = 'noise'
      v%reason = 'S hardly rises with the lag (slope '//to_text(head)//' to '//to_text(foot)//'), as instrument noise does'
    else if (r%d < max(2.02_dp, d_lowest + 1e-3_dp)) then
      v%kind = not_fractal
      v%name = 'smooth'
      v%reason = 'S ~ tau^'//to_text(0.5_dp * (head + foot))//': the map is differentiable over these lags'
    else if (r%misfit > 0.1_dp) then
      v%kind = not_fractal
      v%name = 'bent'
      v%reason = 'ln S bends: its slope goes from '//to_text(head)//' to '//to_text(foot)//', the model is off by '// &
        percent(r%misfit)
    else if (r%interval(1, 1) < 2.005_dp) then
      v%kind = not_fractal
      v%name = 'smooth'
      v%reason = 'the 95 % interval of D reaches 2, a differentiable map: G = exp(b/(D - 2)) is not determined'
    else
      v%reason = 'S follows the model within '//percent(merge(r%rms, r%misfit, p%model == model_ridges))//' over lags '// &
        to_text(o%lag(1))//' to '//to_text(maxval(o%lag))
      if (share > 0.05_dp) v%reason = v%reason//'; white noise makes '//percent(share)//' of S at the first lag'
    end if
  end subroutine judge_fit

  !> Mean of what is a number.
  pure real(dp) function mean_good(s)
    real(dp), intent(in) :: s(:)    !< numbers
    mean_good = sum(s, s <= huge(s)) / max(1, count(s <= huge(s)))
  end function mean_good
end module hd_verdict
