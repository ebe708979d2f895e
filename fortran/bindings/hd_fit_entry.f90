! SPDX-License-Identifier: GPL-3.0-or-later
!> Fit of a surface from the named list of its options, as Python hands it over, and what it found as named numbers and columns.
module hd_fit_entry
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_expectation, only: band_spectrum_t
  use hd_measurement, only: measure, measurement_t
  use hd_named_values, only: named_list_t
  use hd_observation, only: anisotropy
  use hd_structure_fit, only: fit_options_t, fit_t
  use hd_uncertainty, only: error_of
  use hd_wave_sum, only: ridges_t
  implicit none
  private
  public :: measure_flat, fit_numbers, fit_curves, fit_rings

contains

  !> Fit.
  subroutine measure_flat(z, other, dx, dy, options, m, error)
    real(dp), intent(in), contiguous :: z(:, :), other(:, :)   !< maps, the second of one point: none [m]
    real(dp), intent(in) :: dx, dy                             !< spacing [m]
    real(dp), intent(in) :: options(:)                         !< in the order of 'fit_options'
    type(measurement_t), intent(out) :: m                      !< what was found
    type(error_t), allocatable, intent(out) :: error           !< bad map, window, model
    type(band_spectrum_t) :: spectrum
    type(fit_options_t) :: how
    type(named_list_t) :: names
    integer :: lags(2)
    logical :: level
    names%list = 'fit_options'
    lags = [whole('first_lag'), whole('last_lag')]
    level = yes('level')
    spectrum = band_spectrum_t(whole('model'), number('f_lo'), number('f_hi'), &
      ridges_t(number('gamma'), whole('ridges'), whole('n_max'), number('length')))
    how = fit_options_t(yes('fit_noise'), number('noise'), yes('told'), yes('mask'))
    call names%check(error)
    if (.not. allocated(error)) call measure(z, other, dx, dy, lags(1), lags(2), level, spectrum, how, m, error)
  contains
    real(dp) function number(name)
      character(len=*), intent(in) :: name
      number = names%take(options, name)
    end function number

    integer function whole(name)
      character(len=*), intent(in) :: name
      whole = nint(number(name))
    end function whole

    logical function yes(name)
      character(len=*), intent(in) :: name
      yes = number(name) > 0
    end function yes
  end subroutine measure_flat

  !> Numbers; those that were not found stay as they are.
  subroutine fit_numbers(m, room, numbers, error)
    type(measurement_t), intent(in) :: m               !< what was found
    integer, intent(in) :: room                        !< rows that there is room for in the curves
    real(dp), intent(inout) :: numbers(:)              !< in the order of 'fit'
    type(error_t), allocatable, intent(out) :: error   !< unknown name
    type(named_list_t) :: names
    names%list = 'fit'
    call enter('of_spectrum', 0._dp)
    call enter('tilt_x', m%tilt(1))
    call enter('tilt_y', m%tilt(2))
    call enter('anisotropy', anisotropy(m%o))
    call enter('verdict', real(m%verdict%kind, dp))
    call enter('size', real(min(size(m%o%s), room), dp))
    call enter_faults(m, names, numbers)
    call enter_spectrum
    if (allocated(m%fit%curve)) call enter_fit(m%fit)
    call names%check(error)
  contains
    subroutine enter(name, x)
      character(len=*), intent(in) :: name
      real(dp), intent(in) :: x
      call names%put(numbers, name, x)
    end subroutine enter

    subroutine enter_fit(f)
      type(fit_t), intent(in) :: f
      integer :: i
      call enter('d', f%d)
      call enter('ln_g', f%ln_g)
      call enter('noise_variance', f%noise_variance)
      do i = 1, 9
        call enter('cov_'//achar(iachar('0') + i), f%cov(modulo(i - 1, 3) + 1, (i - 1)/3 + 1))
      end do
      call enter('rms', f%rms)
      call enter('rms_expected', f%rms_expected)
      call enter('misfit', f%misfit)
      call enter('chi2', f%chi2)
      call enter('freedom', real(f%freedom, dp))
      call enter('d_error', error_of(f%interval(:, 1)))
      call enter('ln_g_error', error_of(f%interval(:, 2)))
      call enter_interval('', f%interval)
      call enter_interval('_sampling', f%interval_sampling)
    end subroutine enter_fit

    subroutine enter_interval(kind, interval)
      character(len=*), intent(in) :: kind
      real(dp), intent(in) :: interval(2, 2)
      call enter('d_low'//kind, interval(1, 1))
      call enter('d_high'//kind, interval(2, 1))
      call enter('ln_g_low'//kind, interval(1, 2))
      call enter('ln_g_high'//kind, interval(2, 2))
    end subroutine enter_interval

    subroutine enter_spectrum
      integer :: i
      associate (b => m%blind, f => m%blind%fit)
        if (.not. allocated(b%rings%f)) return
        call enter('holes', real(b%holes, dp))
        call enter('axis_x', b%rings%axis(1))
        call enter('axis_y', b%rings%axis(2))
        if (f%last <= 0 .or. m%of_lines) return
        call enter('of_spectrum', 1._dp)
        call enter('probe', f%probe)
        call enter('fold', f%fold)
        call enter('f_lo', f%f_lo)
        call enter('f_hi', f%f_hi)
        do i = 1, merge(2, 1, m%verdict%name == 'crossover')
          call enter('range_d_'//achar(iachar('0') + i), b%ranges(1, i))
          call enter('range_low_'//achar(iachar('0') + i), b%ranges(2, i))
          call enter('range_high_'//achar(iachar('0') + i), b%ranges(3, i))
        end do
      end associate
    end subroutine enter_spectrum
  end subroutine fit_numbers

  !> Faults of the maps.
  subroutine enter_faults(m, names, numbers)
    type(measurement_t), intent(in) :: m               !< what was found
    type(named_list_t), intent(inout) :: names         !< 'fit'
    real(dp), intent(inout) :: numbers(:)              !< in its order
    call names%put(numbers, 'spikes', real(m%spikes, dp))
    call names%put(numbers, 'wrong_from', m%seen(1))
    call names%put(numbers, 'clumps_from', m%seen(2))
    call names%put(numbers, 'seams_x', real(m%seams%count(1), dp))
    call names%put(numbers, 'seams_y', real(m%seams%count(2), dp))
    call names%put(numbers, 'seam_step', m%seams%largest)
    call names%put(numbers, 'jitter_x', m%seams%jitter(1))
    call names%put(numbers, 'jitter_y', m%seams%jitter(2))
  end subroutine enter_faults

  !> Curves over the lag.
  subroutine fit_curves(m, curves, error)
    type(measurement_t), intent(in) :: m               !< what was found
    real(dp), intent(inout) :: curves(:, :)            !< columns in the order of 'fit_curves'
    type(error_t), allocatable, intent(out) :: error   !< unknown name
    type(named_list_t) :: names
    integer :: n
    names%list = 'fit_curves'
    n = min(size(m%o%s), size(curves, 1))
    call enter_column(names, 'tau', m%o%tau(:n), curves)
    call enter_column(names, 's', m%o%s(:n), curves)
    if (allocated(m%fit%curve)) then
      call enter_column(names, 'model', m%fit%curve(:n), curves)
      call enter_column(names, 'model_error', m%fit%sd_curve(:n), curves)
      call enter_column(names, 'sample_error', m%fit%sd_sample(:n), curves)
    end if
    call names%check(error)
  end subroutine fit_curves

  !> Curves over the rings of frequency.
  subroutine fit_rings(m, rings, error)
    type(measurement_t), intent(in) :: m               !< what was found
    real(dp), intent(inout) :: rings(:, :)             !< columns in the order of 'fit_rings'
    type(error_t), allocatable, intent(out) :: error   !< unknown name
    type(named_list_t) :: names
    integer :: k
    names%list = 'fit_rings'
    associate (b => m%blind, f => m%blind%fit)
      if (.not. allocated(b%rings%f)) return
      k = min(size(rings, 1), size(b%rings%f))
      call enter_column(names, 'frequency', b%rings%f(:k), rings)
      call enter_column(names, 'power', b%rings%p(:k), rings)
      call enter_column(names, 'modes', b%rings%m(:k), rings)
      if (f%last > 0 .and. .not. m%of_lines) call enter_column(names, 'model', f%model(:min(k, f%last) - f%first + 1), &
        rings(f%first:, :))
    end associate
    call names%check(error)
  end subroutine fit_rings

  !> The first rows of a column.
  subroutine enter_column(names, name, x, columns)
    type(named_list_t), intent(inout) :: names         !< of the columns
    character(len=*), intent(in) :: name               !< of this one
    real(dp), intent(in) :: x(:)                       !< its values
    real(dp), intent(inout) :: columns(:, :)           !< gets them
    integer :: j
    j = names%place(name)
    if (j > 0 .and. j <= size(columns, 2)) columns(:size(x), j) = x
  end subroutine enter_column
end module hd_fit_entry
