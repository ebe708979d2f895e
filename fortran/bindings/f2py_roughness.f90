! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: structure function and fit. Maps come in Fortran order, first index along a row.
module f2py_roughness
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_structure_function, only: check_map, structure_line, structure_second, structure_radial
  use hd_status, only: tell, hand_over
  use hd_observation, only: level_plane
  use hd_cleaning, only: clean_map
  use hd_seams, only: seams_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_fit_entry, only: measure_flat, fit_numbers, fit_curves, fit_rings
  use hd_measurement, only: measurement_t
  use hd_band_integral, only: band_integral
  use hd_expectation, only: band_spectrum_t, check_spectrum
  use hd_verdict, only: determined
  implicit none
  private
  public :: structure_direction, structure_rings, surface_level, surface_clean, surface_fit, structure_expected, &
    determined_dimension

contains

  !> S along a direction; second = 1: its second-difference form.
  subroutine structure_direction(z, nx, ny, step_x, step_y, second, lags, n, s, pairs, status)
    integer(c_int), intent(in) :: nx, ny, n, step_x, step_y, second
    real(c_double), intent(in) :: z(nx, ny)
    integer(c_int), intent(in) :: lags(n)
    real(c_double), intent(out) :: s(n), pairs(n)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
    !f2py integer(c_int), intent(hide), depend(lags) :: n = len(lags)
    !f2py threadsafe
    type(error_t), allocatable :: error
    call check_map(z, 1._c_double, 1._c_double, error)
    if (.not. allocated(error)) then
      if (second > 0) then
        call structure_second(z, [step_x, step_y], lags, s, pairs, error)
      else
        call structure_line(z, [step_x, step_y], lags, s, pairs, error)
      end if
    end if
    call tell(error, status)
  end subroutine structure_direction

  !> S over rings.
  subroutine structure_rings(z, nx, ny, dx, dy, n, tau, s, pairs, status)
    integer(c_int), intent(in) :: nx, ny, n
    real(c_double), intent(in) :: z(nx, ny)
    real(c_double), intent(in) :: dx, dy
    real(c_double), intent(out) :: tau(n), s(n), pairs(n)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
    !f2py threadsafe
    type(error_t), allocatable :: error
    call check_map(z, dx, dy, error)
    if (.not. allocated(error)) call structure_radial(z, dx, dy, tau, s, pairs, error)
    call tell(error, status)
  end subroutine structure_rings

  !> Least-squares plane of a map, taken off in place; tilt per point along x and y.
  subroutine surface_level(z, nx, ny, tilt, status)
    integer(c_int), intent(in) :: nx, ny
    real(c_double), intent(inout) :: z(nx, ny)
    real(c_double), intent(out) :: tilt(2)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
    !f2py threadsafe
    type(error_t), allocatable :: error
    call check_map(z, 1._c_double, 1._c_double, error)
    if (.not. allocated(error)) call level_plane(z, tilt)
    call tell(error, status)
  end subroutine surface_level

  !> Steps of stitching levelled (mend > 0), wrong points taken for holes (mask > 0), holes filled (fill > 0), in place; numbers of
  !> wrong points, of seams across x and y; the largest step.
  subroutine surface_clean(z, nx, ny, dx, dy, mend, mask, fill, found, step, status)
    integer(c_int), intent(in) :: nx, ny, mend, mask, fill
    real(c_double), intent(inout) :: z(nx, ny)
    real(c_double), intent(in) :: dx, dy
    integer(c_int), intent(out) :: found(3)
    real(c_double), intent(out) :: step
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(seams_t) :: seams
    call check_map(z, dx, dy, error)
    if (.not. allocated(error)) call clean_map(z, [dx, dy], mend > 0, mask > 0, fill > 0, seams, found(1))
    found(2:) = seams%count
    step = seams%largest
    call tell(error, status)
  end subroutine surface_clean

  !> Fit of one map (`other` of one point) or of the sum of two. Options, numbers, and the columns of curves over the lag and over
  !> the rings of frequency have their names in hd_named_values; what was not found is NaN. The text: the kind of surface, a line
  !> end, the reason of the verdict.
  subroutine surface_fit(z, nx, ny, other, mx, my, dx, dy, options, no, n, columns, rows, numbers, curves, nc, rings, nr, status)
    integer(c_int), intent(in) :: nx, ny, mx, my, no, n, columns, nc, rows, nr
    real(c_double), intent(in) :: z(nx, ny), other(mx, my)
    real(c_double), intent(in) :: dx, dy, options(no)
    real(c_double), intent(out) :: numbers(n), curves(columns, nc), rings(rows, nr)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(z) :: nx = shape(z, 0), ny = shape(z, 1)
    !f2py integer(c_int), intent(hide), depend(other) :: mx = shape(other, 0), my = shape(other, 1)
    !f2py integer(c_int), intent(hide), depend(options) :: no = len(options)
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(measurement_t) :: m
    numbers = ieee_value(dx, ieee_quiet_nan)
    curves = numbers(1)
    rings = numbers(1)
    call measure_flat(z, other, dx, dy, options, m, error)
    if (.not. allocated(error)) then
      call fit_numbers(m, columns, numbers, error)
      if (.not. allocated(error)) call fit_curves(m, curves, error)
      if (.not. allocated(error)) call fit_rings(m, rings, error)
      if (.not. allocated(error)) call hand_over(trim(m%verdict%name)//new_line('a')//m%verdict%reason)
    end if
    call tell(error, status)
  end subroutine surface_fit

  !> S of a continuous band per G^(2(D-2)).
  subroutine structure_expected(model, d, f_lo, f_hi, tau, n, s, status)
    integer(c_int), intent(in) :: model, n
    real(c_double), intent(in) :: d, f_lo, f_hi, tau(n)
    real(c_double), intent(out) :: s(n)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(tau) :: n = len(tau)
    !f2py threadsafe
    type(error_t), allocatable :: error
    call check_spectrum(band_spectrum_t(model, f_lo, f_hi), error)
    if (.not. allocated(error)) s = band_integral(model, d, tau, f_lo, f_hi)
    call tell(error, status)
  end subroutine structure_expected

  !> Low end of the interval of D from which on G is determined.
  subroutine determined_dimension(d)
    real(c_double), intent(out) :: d
    d = determined
  end subroutine determined_dimension
end module f2py_roughness
