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

!> Fit. Whole numbers: first lag, last lag, level, model, weighted, known, fit_noise, M, n_max. Reals: f_lo, f_hi, gamma, L, noise.
!> Numbers out: D, ln G, noise variance, their covariance (9), rms, rms expected, misfit, chi2, freedom, tilt (2), verdict, size.
!> Curves out, one column each: lag [m], S, S of the model, its standard error and that of a sample (of ln S), S_x, S_y.
subroutine surface_fit(z, nx, ny, dx, dy, whole, reals, columns, numbers, curves, name, reason, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_error, only: error_t
  use hd_expectation, only: spectrum_t
  use hd_observation, only: level_plane, observation_t, observe
  use hd_structure_function, only: check_map
  use hd_surface_fit, only: fit_options_t, fit_surface, fit_t
  use hd_verdict, only: judge_fit, judge_map, verdict_t
  use hd_wave_sum, only: ridges_t
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: nx, ny, columns
  real(c_double), intent(in) :: z(nx, ny)
  real(c_double), intent(in) :: dx, dy, reals(5)
  integer(c_int), intent(in) :: whole(9)
  real(c_double), intent(out) :: numbers(21), curves(columns, 7)
  character(len=32), intent(out) :: name
  character(len=512), intent(out) :: reason
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
  !f2py threadsafe
  type(error_t), allocatable :: error
  type(observation_t) :: o
  type(fit_options_t) :: options
  type(spectrum_t) :: p
  type(fit_t) :: r
  type(verdict_t) :: v
  real(c_double), allocatable :: flat(:, :), used(:, :)
  integer :: n
  numbers = ieee_value(dx, ieee_quiet_nan)
  curves = ieee_value(dx, ieee_quiet_nan)
  name = ''
  reason = ''
  p = spectrum_t(whole(4), reals(1), reals(2), ridges_t(reals(3), whole(8), whole(9), reals(4)))
  options = fit_options_t(whole(5) > 0, whole(6) > 0, whole(7) > 0, reals(5))
  numbers(21) = 0
  call check_map(z, dx, dy, error)
  if (.not. allocated(error)) then
    flat = z
    call level_plane(flat, numbers(18:19))
    used = z
    if (whole(3) > 0) used = flat
    call observe(used, dx, dy, whole(1), whole(2), whole(3) > 0, o, error)
  end if
  if (.not. allocated(error)) call judge_map(z, flat, whole(1), v, error)
  if (.not. allocated(error)) then
    numbers(20) = v%kind
    n = min(size(o%s), columns)
    numbers(21) = n
    curves(:n, 1) = o%tau(:n)
    curves(:n, 2) = o%s(:n)
    curves(:size(o%s_x), 6) = o%s_x
    curves(:size(o%s_y), 7) = o%s_y
    if (v%name /= 'constant' .and. v%name /= 'plane') then
      call fit_surface(o, p, options, r, error)
      if (.not. allocated(error)) then
        call judge_fit(o, p, options, r, v)
        numbers(:12) = [r%d, r%ln_g, r%noise_variance, reshape(r%cov, [9])]
        numbers(13:17) = [r%rms, r%rms_expected, r%misfit, r%chi2, real(r%freedom, c_double)]
        numbers(20) = v%kind
        curves(:n, 3) = r%curve(:n)
        curves(:n, 4) = r%sd_curve(:n)
        curves(:n, 5) = r%sd_sample(:n)
      end if
    end if
    name = v%name
    reason = v%reason
  end if
  call tell(error, status, message)
end subroutine surface_fit
