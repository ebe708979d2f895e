! SPDX-License-Identifier: GPL-3.0-or-later
! Flat entries for Python: structure function and fit. Maps come in Fortran order, first index along a row.

!> S along a direction; second = 1: its second-difference form.
subroutine structure_direction(z, nx, ny, step_x, step_y, second, lags, n, s, pairs, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_structure_function, only: check_map, structure_line, structure_second
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: nx, ny, n, step_x, step_y, second
  real(c_double), intent(in) :: z(nx, ny)
  integer(c_int), intent(in) :: lags(n)
  real(c_double), intent(out) :: s(n), pairs(n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
  !f2py integer(c_int), intent(hide), depend(lags) :: n = len(lags)
  !f2py threadsafe
  type(error_t), allocatable :: error
  s = 0
  pairs = 0
  call check_map(z, 1._c_double, 1._c_double, error)
  if (.not. allocated(error)) then
    if (second > 0) then
      call structure_second(z, [step_x, step_y], lags, s, pairs, error)
    else
      call structure_line(z, [step_x, step_y], lags, s, pairs, error)
    end if
  end if
  call tell(error, status, message)
end subroutine structure_direction

!> S over rings.
subroutine structure_rings(z, nx, ny, dx, dy, n, tau, s, pairs, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_structure_function, only: check_map, structure_radial
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: nx, ny, n
  real(c_double), intent(in) :: z(nx, ny)
  real(c_double), intent(in) :: dx, dy
  real(c_double), intent(out) :: tau(n), s(n), pairs(n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
  !f2py threadsafe
  type(error_t), allocatable :: error
  tau = 0
  s = 0
  pairs = 0
  call check_map(z, dx, dy, error)
  if (.not. allocated(error)) call structure_radial(z, dx, dy, tau, s, pairs, error)
  call tell(error, status, message)
end subroutine structure_rings

!> Least-squares plane of a map, taken off in place; tilt per point along x and y.
subroutine surface_level(z, nx, ny, tilt, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_observation, only: level_plane
  use hd_structure_function, only: check_map
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: nx, ny
  real(c_double), intent(inout) :: z(nx, ny)
  real(c_double), intent(out) :: tilt(2)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
  !f2py threadsafe
  type(error_t), allocatable :: error
  tilt = 0
  call check_map(z, 1._c_double, 1._c_double, error)
  if (.not. allocated(error)) call level_plane(z, tilt)
  call tell(error, status, message)
end subroutine surface_level

!> Sa, Sq, Sz, Ssk, Sku, Sdq, shortest and longest wavelength, Nayak's parameter.
subroutine surface_roughness(z, nx, ny, dx, dy, numbers, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_roughness, only: roughness_t, new_roughness
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: nx, ny
  real(c_double), intent(in) :: z(nx, ny)
  real(c_double), intent(in) :: dx, dy
  real(c_double), intent(out) :: numbers(9)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
  !f2py threadsafe
  type(error_t), allocatable :: error
  type(roughness_t) :: r
  call new_roughness(z, dx, dy, r, error)
  numbers = [r%sa, r%sq, r%sz, r%ssk, r%sku, r%sdq, r%bandwidth, r%nayak]
  call tell(error, status, message)
end subroutine surface_roughness

!> Spectrum of the rows (radial = 0) or over rings of frequency.
subroutine surface_spectrum(z, nx, ny, dx, dy, radial, n, frequency, density, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_roughness, only: line_spectrum, ring_spectrum
  use hd_structure_function, only: check_map
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: nx, ny, radial, n
  real(c_double), intent(in) :: z(nx, ny)
  real(c_double), intent(in) :: dx, dy
  real(c_double), intent(out) :: frequency(n), density(n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
  !f2py threadsafe
  type(error_t), allocatable :: error
  frequency = 0
  density = 0
  call check_map(z, dx, dy, error)
  if (.not. allocated(error)) then
    if (radial > 0) then
      call ring_spectrum(z, dx, dy, frequency, density, error)
    else
      call line_spectrum(z, dx, frequency, density, error)
    end if
  end if
  call tell(error, status, message)
end subroutine surface_spectrum

!> Fit of one map (`other` of one point) or of the sum of two. Whole numbers: first lag, last lag, level, model, weighted, known,
!> fit_noise, M, n_max, band told. Reals: f_lo, f_hi, gamma, L, noise. Numbers out: D, ln G, noise variance, covariance (9), rms,
!> rms expected, misfit, chi2, freedom, tilt (2), verdict, size, intervals (8), spectrum fitted (0, 1),
!> spikes, holes, lines (0, 1); of the spectrum: probe, fold, f_lo, f_hi, accepted, scatter, tail, excess, shares of spikes and
!> holes, D and window of a second range, deviance; power on both axes over that of rings. Rings: f, power, modes, model.
!> Curves out, one column each: lag [m], S, S of the model, its standard error and that of a sample (of ln S), S_x, S_y.
subroutine surface_fit(z, nx, ny, other, mx, my, dx, dy, whole, reals, columns, rows, numbers, curves, rings, name, reason, &
    status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_error, only: error_t
  use hd_expectation, only: band_spectrum_t
  use hd_measurement, only: measure, measurement_t
  use hd_surface_fit, only: fit_options_t
  use hd_wave_sum, only: ridges_t
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: nx, ny, mx, my, columns, rows
  real(c_double), intent(in) :: z(nx, ny), other(mx, my)
  real(c_double), intent(in) :: dx, dy, reals(5)
  integer(c_int), intent(in) :: whole(10)
  real(c_double), intent(out) :: numbers(52), curves(columns, 7), rings(rows, 4)
  character(len=32), intent(out) :: name
  character(len=512), intent(out) :: reason
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
  !f2py integer(c_int), intent(hide), depend(other) :: mx = shape(other, 0), my = shape(other, 1)
  !f2py threadsafe
  type(error_t), allocatable :: error
  type(measurement_t) :: m
  integer :: n, k
  numbers = ieee_value(dx, ieee_quiet_nan)
  curves = ieee_value(dx, ieee_quiet_nan)
  rings = ieee_value(dx, ieee_quiet_nan)
  numbers([21, 30]) = 0
  name = ''
  reason = ''
  call measure(z, other, dx, dy, whole(1), whole(2), whole(3) > 0, &
    band_spectrum_t(whole(4), reals(1), reals(2), ridges_t(reals(3), whole(8), whole(9), reals(4))), &
    fit_options_t(whole(5) > 0, whole(6) > 0, whole(7) > 0, reals(5), whole(10) > 0), m, error)
  if (.not. allocated(error)) then
    n = min(size(m%o%s), columns)
    numbers(18:21) = [m%tilt, real(m%verdict%kind, c_double), real(n, c_double)]
    associate (b => m%blind, f => m%blind%fit)
      if (allocated(b%rings%f)) then
        numbers(31:33) = [real(c_double) :: b%spikes, b%holes, merge(1, 0, m%of_lines)]
        numbers(48:49) = b%rings%axis
        k = min(rows, size(b%rings%f))
        rings(:k, 1) = b%rings%f(:k)
        rings(:k, 2) = b%rings%p(:k)
        rings(:k, 3) = b%rings%m(:k)
        if (f%last > 0 .and. .not. m%of_lines) then
          numbers(30) = 1
          numbers(34:47) = [real(c_double) :: f%probe, f%fold, f%f_lo, f%f_hi, merge(1, 0, f%accepted), f%scatter, b%tail, &
            b%excess, b%spike_share, b%hole_share, b%above%d, b%above%f_lo, b%above%f_hi, f%deviance]
          rings(f%first:min(k, f%last), 4) = f%model(:min(k, f%last) - f%first + 1)
        end if
      end if
    end associate
    curves(:n, 1) = m%o%tau(:n)
    curves(:n, 2) = m%o%s(:n)
    curves(:size(m%o%s_x), 6) = m%o%s_x
    curves(:size(m%o%s_y), 7) = m%o%s_y
    if (allocated(m%fit%curve)) then
      numbers(:12) = [m%fit%d, m%fit%ln_g, m%fit%noise_variance, reshape(m%fit%cov, [9])]
      numbers(13:17) = [m%fit%rms, m%fit%rms_expected, m%fit%misfit, m%fit%chi2, real(m%fit%freedom, c_double)]
      numbers(22:29) = [m%fit%interval, m%fit%interval_sampling]
      curves(:n, 3) = m%fit%curve(:n)
      curves(:n, 4) = m%fit%sd_curve(:n)
      curves(:n, 5) = m%fit%sd_sample(:n)
    end if
    name = m%verdict%name
    reason = m%verdict%reason
  end if
  call tell(error, status, message)
end subroutine surface_fit

!> S of a continuous band per G^(2(D-2)).
subroutine structure_expected(model, d, f_lo, f_hi, tau, n, s, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_band_integral, only: band_integral
  use hd_error, only: error_t
  use hd_expectation, only: band_spectrum_t, check_spectrum
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: model, n
  real(c_double), intent(in) :: d, f_lo, f_hi, tau(n)
  real(c_double), intent(out) :: s(n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(tau) :: n = len(tau)
  !f2py threadsafe
  type(error_t), allocatable :: error
  s = 0
  call check_spectrum(band_spectrum_t(model, f_lo, f_hi), error)
  if (.not. allocated(error)) s = band_integral(model, d, tau, f_lo, f_hi)
  call tell(error, status, message)
end subroutine structure_expected
