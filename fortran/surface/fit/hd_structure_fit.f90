! SPDX-License-Identifier: GPL-3.0-or-later
!> Fit of the fractal dimension D and the roughness G to the structure function of a map: least squares of ln S, each lag weighted
!> by the number of patches of its size that the map holds, or all by the covariance of S; with standard errors. Amplitude and
!> white noise are solved for at each D, so the search is along a line (or two) and cannot be lost.
module hd_structure_fit
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  use hd_lapack, only: inverse_factor, solve_dense
  use hd_band_integral, only: kind_isotropic, kind_profile
  use hd_observation, only: observation_t
  use hd_wave_sum, only: wave_numbers, levels_of, wave_covariance
  use hd_random_field, only: radial_t, new_radial, field_covariance, noise_covariance
  use hd_uncertainty, only: identity, left_over, alike, unexplained, interval_95
  use hd_expectation, only: band_spectrum_t, expectation_t, new_expectation, expected_log, d_lowest, d_highest, &
    model_profile, model_ridges, model_paper
  implicit none
  private
  public :: fit_options_t, fit_t, fit_surface, try_noise

  !> How to fit.
  type :: fit_options_t
    logical :: fit_noise = .false.    !< white instrument noise is a third unknown
    real(dp) :: noise = 0             !< known rms noise, taken off S [m]
    logical :: told_band = .false.    !< the band of the model is told, not a guess: a spectrum is fitted over it
    logical :: mask = .true.          !< single wrong points are taken for holes
  end type fit_options_t

  !> What was found.
  type :: fit_t
    real(dp) :: d = 0, ln_g = 0               !< D, ln (G / 1 m)
    real(dp) :: noise_variance = 0            !< white noise [m^2]
    real(dp) :: cov(3, 3) = 0                 !< covariance of D, ln G, noise variance, were that free to be negative
    real(dp) :: interval(2, 2) = 0            !< 95 % intervals (low and high; D, ln G) of sampling and of misfit
    real(dp) :: interval_sampling(2, 2) = 0   !< the same of sampling alone: right if the model is
    real(dp) :: rms = 0                       !< rms of the residuals of ln S
    real(dp) :: rms_expected = 0              !< what sampling alone leaves, on average
    real(dp) :: misfit = 0                    !< rms of ln S the model itself must be off by
    real(dp) :: chi2 = 0                      !< residuals weighted by their covariance (an exact model)
    integer :: freedom = 0                    !< degrees of freedom
    real(dp), allocatable :: curve(:)         !< S of the model at the lags, noise included [m^2]
    real(dp), allocatable :: sd_sample(:)     !< standard deviation of measured ln S about the model's
    real(dp), allocatable :: sd_curve(:)      !< standard error of the model's ln S
  end type fit_t

  real(dp), parameter :: whole = 0.99_dp        !< share of a direction in a lag's S that is all of it
  real(dp), parameter :: change_of_d = 1e-4_dp  !< in central differences: they are right to its square
  real(dp), parameter :: misfit_range = 0.3_dp  !< of ln tau over which a model is off alike, by judgement
  real(dp), parameter :: least_jitter = 1e-15_dp !< relative, of a covariance that rounding makes indefinite
  real(dp), parameter :: most_noise = 0.999_dp  !< share of noise at the first lag: at 1 nothing is left of the surface

contains

  !> Fit an observation.
  subroutine fit_surface(o, p, options, r, error)
    type(observation_t), intent(in) :: o              !< S over the window
    type(band_spectrum_t), intent(in) :: p                 !< model
    type(fit_options_t), intent(in) :: options        !< how
    type(fit_t), intent(out) :: r                     !< result
    type(error_t), allocatable, intent(out) :: error  !< S not positive, bad model
    type(expectation_t) :: e
    real(dp), dimension(size(o%lag), size(o%lag)) :: cov, white
    real(dp), allocatable :: about(:)
    real(dp) :: y(size(o%lag)), shift(size(o%lag)), d, b, share, off
    integer :: i
    off = 2 * options%noise**2
    if (.not. all(o%s - off > 0)) then
      i = findloc(o%s - off > 0, .false., 1)
      call raise(error, code_input, 'S = '//to_text(o%s(i))//' m^2 at lag '//to_text(o%lag(i))//' is not above 2 noise^2 = '// &
        to_text(off)//' m^2: nothing is left to fit')
      return
    end if
    y = log(o%s - off)
    e = new_expectation(o, p)
    white = patches(o, p%model == model_ridges .or. p%model == model_paper)
    shift = 0
    if (p%model /= model_ridges) call split_directions(o, e, y, white, shift)
    y = y - shift
    call search(e, y, white, about, options%fit_noise, d, b, share)
    do i = 1, 2
      call covariance(o, p, e, d, b, share, off, cov)
      if (p%model /= model_ridges) exit  ! the inverse covariance is a sound weight where the model is exact
      about = b + shape_of(e, d, share)
      call whiten(cov, white)
      call search(e, y, white, about, options%fit_noise, d, b, share)
    end do
    call complete_fit(o, p, options, e, y, cov, white, about, d, b, share, off, r, error)
    if (.not. allocated(error)) r%curve = r%curve * exp(shift)
  end subroutine fit_surface

  !> Whitening by the number of patches of size tau that the map holds, (L/tau)^2 or L/tau of a single line: the variance of ln S is
  !> its inverse. The first lag has 1.
  pure function patches(o, even) result(white)
    type(observation_t), intent(in) :: o    !< observation
    logical, intent(in) :: even             !< all lags alike instead
    real(dp) :: white(size(o%lag), size(o%lag))
    integer :: i
    white = identity(size(o%lag))
    if (even) return
    do i = 1, size(o%lag)
      white(i, i) = (o%tau(1) / o%tau(i))**merge(0.5_dp, 1._dp, o%ny == 1)
    end do
  end function patches

  !> Rows and columns observed one after the other: half of what lies between their ln S, beyond the model. Taking it off fits the
  !> geometric mean of both, as pooling does where points are squares.
  subroutine split_directions(o, e, y, white, shift)
    type(observation_t), intent(in) :: o    !< observation
    type(expectation_t), intent(in) :: e    !< table
    real(dp), intent(in) :: y(:)            !< ln S
    real(dp), intent(in) :: white(:, :)     !< whitening matrix
    real(dp), intent(out) :: shift(:)       !< to be taken off y
    real(dp), allocatable :: about(:)
    real(dp) :: d, b, share, res(size(y))
    integer :: i, n
    shift = 0
    n = size(y) / 2
    if (.not. (any(o%share(1, :) > whole) .and. any(o%share(2, :) > whole))) return
    do i = 1, 4
      call search(e, y - shift, white, about, .false., d, b, share)
      res = y - b - shape_of(e, d, share)
      shift(:n) = 0.5_dp * (sum(res(:n)) - sum(res(n + 1:))) / n
      shift(n + 1:) = -shift(1)
    end do
  end subroutine split_directions

  !> Least squares with white noise as a third unknown, without errors: its share of S at the first lag, and the residual.
  subroutine try_noise(o, p, share, rms)
    type(observation_t), intent(in) :: o    !< S over the window, positive
    type(band_spectrum_t), intent(in) :: p       !< model
    real(dp), intent(out) :: share, rms     !< share of noise at the first lag, rms of the residuals of ln S
    type(expectation_t) :: e
    real(dp), allocatable :: about(:)
    real(dp) :: d, b, y(size(o%lag)), shift(size(o%lag))
    e = new_expectation(o, p)
    y = log(o%s)
    call split_directions(o, e, y, patches(o, .false.), shift)
    y = y - shift
    call search(e, y, patches(o, .false.), about, .true., d, b, share)
    rms = sqrt(sum((y - b - shape_of(e, d, share))**2) / size(y))
  end subroutine try_noise

  !> Model of ln S up to its amplitude, 0 at the first lag: share is the part of the noise there.
  pure function shape_of(e, d, share) result(v)
    type(expectation_t), intent(in) :: e    !< table
    real(dp), intent(in) :: d, share        !< D, share of noise in S at the first lag
    real(dp) :: v(size(e%v, 1))
    v = expected_log(e, d)
    v = v - v(1)
    if (share > 0) v = log((1 - share) * exp(v) + share)
  end function shape_of

  !> Least squares over D and the share of noise, each on grids that close in on the minimum; the amplitude b is solved for.
  subroutine search(e, y, white, about, noise, d, b, share)
    type(expectation_t), intent(in) :: e            !< table
    real(dp), intent(in) :: y(:)                    !< ln S
    real(dp), intent(in) :: white(:, :)             !< whitening matrix
    real(dp), allocatable, intent(in) :: about(:)   !< ln S that residuals of S are relative to; none: residuals of ln S
    logical, intent(in) :: noise                    !< noise is unknown
    real(dp), intent(out) :: d, b, share            !< D, ln S of the model at the first lag, share of noise there
    real(dp) :: low, high, best, chi, at
    integer :: pass, i
    share = 0
    if (noise) then
      low = 0
      high = most_noise
      do pass = 1, 7
        best = huge(best)
        do i = 0, 16
          at = low + i * (high - low) / 16
          call search_d(e, y, white, about, at, d, b, chi)
          if (chi >= best) cycle
          best = chi
          share = at
        end do
        at = (high - low) / 16
        low = max(0._dp, share - at)
        high = min(most_noise, share + at)
      end do
    end if
    call search_d(e, y, white, about, share, d, b, chi)
  end subroutine search

  !> Least squares over D at a share of noise.
  pure subroutine search_d(e, y, white, about, share, d, b, chi)
    type(expectation_t), intent(in) :: e            !< table
    real(dp), intent(in) :: y(:)                    !< ln S
    real(dp), intent(in) :: white(:, :)             !< whitening matrix
    real(dp), allocatable, intent(in) :: about(:)   !< ln S that residuals of S are relative to; none: residuals of ln S
    real(dp), intent(in) :: share                   !< share of noise
    real(dp), intent(out) :: d, b                   !< D, amplitude
    real(dp), intent(out) :: chi                    !< sum of squares
    real(dp) :: low, high, at, c, u(size(y)), v(size(y)), amplitude
    integer :: pass, i
    u = sum(white, 2)
    if (allocated(about)) v = matmul(white, exp(y - about))
    d = d_lowest
    b = 0
    low = d_lowest
    high = d_highest
    do pass = 1, 9
      chi = huge(chi)
      do i = 0, 20
        at = low + i * (high - low) / 20
        if (allocated(about)) then
          u = matmul(white, exp(shape_of(e, at, share) - about))
        else
          v = matmul(white, y - shape_of(e, at, share))
        end if
        amplitude = sum(u * v) / sum(u * u)
        c = sum((v - amplitude * u)**2)
        if (c >= chi) cycle
        chi = c
        d = at
        b = amplitude
      end do
      at = (high - low) / 20
      low = max(d_lowest, d - at)
      high = min(d_highest, d + at)
    end do
    if (allocated(about)) b = log(b)
  end subroutine search_d

  !> Covariance of ln S at the estimate: of random phases if the sum is known, else of an isotropic Gaussian field; plus noise.
  subroutine covariance(o, p, e, d, b, share, off, cov)
    type(observation_t), intent(in) :: o          !< geometry and lags
    type(band_spectrum_t), intent(in) :: p        !< model
    type(expectation_t), intent(in) :: e          !< table
    real(dp), intent(in) :: d, b, share, off      !< estimate; noise taken off S [m^2]
    real(dp), intent(out) :: cov(:, :)            !< of ln S
    real(dp), allocatable :: qx(:), qy(:), a2(:)
    real(dp) :: v(size(o%lag)), scale, s(size(o%lag)), f_lo, f_hi
    type(radial_t) :: t
    integer :: i, kind
    v = expected_log(e, d)
    scale = exp(b - v(1)) * (1 - share)
    f_lo = p%f_lo
    f_hi = p%f_hi
    if (p%model > model_profile) then
      f_lo = 1 / max(o%nx * o%dx, o%ny * o%dy)
      f_hi = 1 / min(o%dx, o%dy)
    end if
    kind = merge(kind_profile, kind_isotropic, p%model == model_profile)
    t = new_radial(kind, d, scale, f_lo, f_hi, min(o%dx, o%dy), 2 * hypot(o%nx * o%dx, o%ny * o%dy))
    if (p%model == model_ridges) then
      call wave_numbers(p%ridges, qx, qy)
      a2 = [(levels_of(p%ridges, d) * scale, i=1, p%ridges%count)]
      call wave_covariance(o, qx, qy, a2, cov)
    else
      call field_covariance(o, t, cov)
    end if
    call noise_covariance(o, t, 0.5_dp * (share * exp(b) + off), cov)
    s = exp(b + shape_of(e, d, share))
    do i = 1, size(s)
      cov(:, i) = cov(:, i) * o%parts / (s * s(i) * o%filled)
    end do
  end subroutine covariance

  !> Inverse of the Cholesky factor; the diagonal is raised by as little as that takes.
  subroutine whiten(cov, white)
    real(dp), intent(in) :: cov(:, :)       !< covariance
    real(dp), intent(out) :: white(:, :)    !< lower triangle W, W cov W^T = 1
    real(dp) :: jitter
    integer :: i
    logical :: definite
    jitter = least_jitter
    do
      white = cov
      do i = 1, size(cov, 1)
        white(i, i) = cov(i, i) * (1 + jitter) + jitter * maxval(cov)
      end do
      call inverse_factor(white, definite)
      if (definite) exit
      jitter = 10 * jitter
    end do
    do i = 2, size(cov, 1)
      white(:i - 1, i) = 0
    end do
  end subroutine whiten

  !> Standard errors, goodness of fit, curve and bands.
  subroutine complete_fit(o, p, options, e, y, cov, white, about, d, b, share, off, r, error)
    type(observation_t), intent(in) :: o                !< observation
    type(band_spectrum_t), intent(in) :: p                   !< model
    type(fit_options_t), intent(in) :: options          !< how
    type(expectation_t), intent(in) :: e                !< table
    real(dp), intent(in) :: y(:), cov(:, :), white(:, :)!< ln S, its covariance, whitening
    real(dp), allocatable, intent(in) :: about(:)       !< ln S that residuals of S are relative to; none: residuals of ln S
    real(dp), intent(in) :: d, b, share, off            !< estimate; noise taken off S [m^2]
    type(fit_t), intent(out) :: r                       !< result
    type(error_t), allocatable, intent(out) :: error    !< internal
    real(dp), allocatable :: j(:, :), h(:, :), hat(:, :), total(:, :), sure(:, :), like(:, :), curved(:, :)
    real(dp) :: res(size(y)), spare
    integer :: i, n, unknowns
    n = size(y)
    unknowns = merge(3, 2, options%fit_noise)
    res = y - b - shape_of(e, d, share)
    r%rms = sqrt(sum(res**2) / n)
    j = jacobian(e, d, share, unknowns)
    if (allocated(about)) then
      res = exp(y - about) - exp(y - res - about)
      j = j * spread(exp(y - about) - res, 2, unknowns)
    end if
    h = transpose(matmul(white, j))
    hat = matmul(h, transpose(h))
    h = matmul(h, white)
    call solve_dense(hat, h, error)                     ! estimator: d(unknowns) = h d(ln S)
    if (allocated(error)) return
    hat = identity(n) - matmul(j, h)
    r%rms_expected = sqrt(max(left_over(identity(n), hat, cov), 0._dp) / n)
    total = cov
    sure = cov
    if (p%model == model_ridges) then
      r%chi2 = sum(matmul(white, res)**2)
    else
      like = alike(o, misfit_range)
      spare = max(0._dp, sum(matmul(white, res)**2) - left_over(white, hat, cov))
      r%misfit = sqrt(spare / left_over(white, hat, like))
      total = cov + r%misfit**2 * like
      sure = cov + unexplained(o, res, hat) * spare / sum(matmul(white, res)**2)
    end if
    curved = matmul(j, h)
    r%sd_curve = sqrt([(sum(matmul(curved(i, :), sure) * curved(i, :)), i=1, n)])
    r%sd_sample = sqrt([(total(i, i), i=1, n)])
    r%curve = exp(b + shape_of(e, d, share)) + off
    r%freedom = n - unknowns
    call to_surface(e, d, b, share, h, res, cov, sure, r)
    r%noise_variance = r%noise_variance + 0.5_dp * off
  end subroutine complete_fit

  !> From (D, b, share) to (D, ln G, noise variance), with covariances and intervals. Where the noise came out as 0, the linear
  !> estimate, which may be negative, is a step away.
  subroutine to_surface(e, d, b, share, h, res, cov, sure, r)
    type(expectation_t), intent(in) :: e            !< table
    real(dp), intent(in) :: d, b, share             !< estimate
    real(dp), intent(in) :: h(:, :), res(:)         !< estimator (unknowns, n), residuals of ln S
    real(dp), intent(in) :: cov(:, :), sure(:, :)   !< covariance of ln S by sampling, with misfit
    type(fit_t), intent(inout) :: r                 !< result
    real(dp) :: first(size(e%v, 1)), change(size(e%v, 1)), t(3, 3), g(3, size(res)), u(3)
    integer :: i
    first = expected_log(e, d)
    change = (expected_log(e, d + change_of_d) - expected_log(e, d - change_of_d)) / (2 * change_of_d)
    r%d = d
    r%ln_g = (b + log(1 - share) - first(1)) / (2 * (d - 2))
    r%noise_variance = 0.5_dp * share * exp(b)
    t = 0
    t(1, 1) = 1
    t(2, 1) = -r%ln_g / (d - 2) - change(1) / (2 * (d - 2))
    t(2, 2) = 1 / (2 * (d - 2))
    t(2, 3) = -1 / ((1 - share) * 2 * (d - 2))
    t(3, 2) = r%noise_variance
    t(3, 3) = 0.5_dp * exp(b)
    g = matmul(t(:, :size(h, 1)), h)
    if (size(h, 1) < 3) g(3, :) = 0
    u = [r%d, r%ln_g, r%noise_variance] + matmul(g, res)
    r%cov = matmul(g, matmul(sure, transpose(g)))
    do i = 1, 2
      r%interval(:, i) = interval_95(u, r%cov, i)
      r%interval_sampling(:, i) = interval_95(u, matmul(g, matmul(cov, transpose(g))), i)
    end do
  end subroutine to_surface

  !> Derivatives of ln S with respect to D, the amplitude and the share of noise.
  pure function jacobian(e, d, share, unknowns) result(j)
    type(expectation_t), intent(in) :: e      !< table
    real(dp), intent(in) :: d, share          !< estimate
    integer, intent(in) :: unknowns           !< 2 or 3
    real(dp) :: j(size(e%v, 1), unknowns), s(size(e%v, 1))
    j(:, 1) = (shape_of(e, d + change_of_d, share) - shape_of(e, d - change_of_d, share)) / (2 * change_of_d)
    j(:, 2) = 1
    if (unknowns < 3) return
    s = expected_log(e, d)
    s = exp(s - s(1))
    j(:, 3) = (1 - s) / ((1 - share) * s + share)
  end function jacobian
end module hd_structure_fit
