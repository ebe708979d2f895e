! SPDX-License-Identifier: GPL-3.0-or-later
!> Fit of D and G in a surface run: specimens from files or generated, two of them as one equivalent surface; table and summary.
module hd_fit_report
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_expectation, only: band_spectrum_t, model_ridges, model_paper, model_spectrum
  use hd_json, only: json_t
  use hd_log, only: say
  use hd_measurement, only: measurement_t, measure
  use hd_npy, only: read_npy
  use hd_observation, only: fewest_lags, anisotropy
  use hd_roughness, only: roughness_t, new_roughness
  use hd_surface_scene, only: surface_t, surface_fit_t
  use hd_sdf, only: read_sdf
  use hd_structure_fit, only: fit_options_t
  use hd_system, only: check_stop, path_kind, path_file
  use hd_table, only: table_t
  use hd_text, only: to_text
  use hd_uncertainty, only: error_of, in_95
  use hd_verdict, only: fractal, not_fractal
  use hd_wave_sum, only: ridges_t
  implicit none
  private
  public :: specimen_t, found_t, read_specimens, fit_specimens, write_fits, add_fits, place_files

  !> A height map with its spacing.
  type :: specimen_t
    character(len=10) :: name = ''              !< generated, first or second
    character(len=:), allocatable :: file       !< that it comes from; none: generated
    real(dp), allocatable :: z(:, :)            !< heights (nx, ny) [m]
    real(dp) :: dx = 0, dy = 0                  !< spacing [m]
  end type specimen_t

  !> What was found of a specimen, or of both together.
  type :: found_t
    character(len=10) :: name = ''              !< of the specimen, or equivalent
    character(len=:), allocatable :: file       !< that the specimen comes from
    character(len=9) :: model = ''              !< spectrum, ridges or paper; isotropic or profile where the spectrum has lines
    logical :: weighted = .false.               !< by the inverse covariance, of random phases
    integer :: lags(2) = 0                      !< window [points]
    real(dp) :: band(2) = 0                     !< shortest and longest wavelength of the model [m]
    real(dp) :: tilt(2) = 0                     !< slope of the plane along x and y
    type(measurement_t) :: m
    type(ridges_t) :: ridges                    !< what is known of Eq. 1
    type(roughness_t) :: rough                  !< roughness numbers of a specimen
  end type found_t

  real(dp), parameter :: largest = 600          !< ln G that is a number after exp
  real(dp), parameter :: longest = 10           !< of a map and of a height: more is a wrong unit, or a mark for holes [m]
  integer, parameter :: most_lags = 20          !< of the window, where the key does not say
  integer, parameter :: most_waves = 4000       !< for the covariance of random phases

contains

  !> Find files that are not here beside the input, so that the echo names them as they were found.
  subroutine place_files(f, input)
    type(surface_fit_t), intent(inout) :: f          !< fit
    character(len=*), intent(in) :: input        !< name of the input
    call find_beside(f%first_file)
    call find_beside(f%second_file)
  contains
    subroutine find_beside(path)
      character(len=*), intent(inout) :: path    !< file
      character(len=:), allocatable :: beside
      if (len_trim(path) == 0) return
      beside = input(:index(input, '/', back=.true.))//trim(path)
      if (path_kind(trim(path)) /= path_file .and. path_kind(beside) == path_file .and. len(beside) <= len(path)) path = beside
    end subroutine find_beside
  end subroutine place_files

  !> Read the specimens of a fit.
  subroutine read_specimens(f, s, error)
    type(surface_fit_t), intent(in) :: f                            !< fit
    type(specimen_t), allocatable, intent(out) :: s(:)          !< one or two
    type(error_t), allocatable, intent(out) :: error            !< files, spacing
    if (len_trim(f%first_file) == 0) then
      call raise(error, code_input, "fit.second_file = '"//trim(f%second_file)//"' without fit.first_file: name the first too")
      return
    end if
    allocate (s(merge(2, 1, len_trim(f%second_file) > 0)))
    s(1)%name = 'first'
    call read_specimen(trim(f%first_file), f, s(1), error)
    if (allocated(error) .or. size(s) == 1) return
    s(2)%name = 'second'
    call read_specimen(trim(f%second_file), f, s(2), error)
  end subroutine read_specimens

  !> Read one.
  subroutine read_specimen(path, f, s, error)
    character(len=*), intent(in) :: path                        !< file
    type(surface_fit_t), intent(in) :: f                            !< fit
    type(specimen_t), intent(inout) :: s                        !< specimen
    type(error_t), allocatable, intent(out) :: error            !< file, spacing missing
    character(len=:), allocatable :: ending
    real(dp) :: widest
    s%file = path
    ending = path(index(path, '.', back=.true.) + 1:)
    select case (ending)
    case ('sdf')
      if (f%dx > 0 .or. f%dy > 0) then
        call raise(error, code_input, "'"//path//"' states its spacing: leave out fit.dx and fit.dy")
      else
        call read_sdf(path, s%z, s%dx, s%dy, error)
      end if
    case ('npy')
      s%dx = f%dx
      s%dy = f%dy
      if (.not. s%dx > 0) then
        call raise(error, code_input, "'"//path//"' states no spacing: give fit.dx in m")
      else
        call read_npy(path, s%z, error)
      end if
    case default
      call raise(error, code_input, "'"//path//"': .sdf (ISO 25178-71) or .npy is read here; Python reads more formats and "// &
        'writes .sdf')
    end select
    if (allocated(error)) return
    if (s%dy <= 0) s%dy = s%dx
    widest = max((size(s%z, 1, kind=int64) - 1)*s%dx, (size(s%z, 2, kind=int64) - 1)*s%dy)
    if (widest > longest) then
      call raise(error, code_input, "'"//path//"' is "//to_text(widest)//' m wide; valid: up to '//to_text(longest)//' m')
    else if (any(abs(s%z) > longest)) then
      call raise(error, code_input, "'"//path//"' has heights up to "//to_text(maxval(abs(s%z), mask=abs(s%z) > longest))// &
        ' m; valid: up to '//to_text(longest)//' m, NaN for a hole')
    end if
    if (allocated(error)) return
    call say('specimen  '//path//', '//to_text(size(s%z, 1))//' x '//to_text(size(s%z, 2))//' points')
  end subroutine read_specimen

  !> Fit each specimen and, of two, the equivalent surface.
  subroutine fit_specimens(map, fit, s, n_max, found, error)
    type(surface_t), intent(in) :: map                          !< what is known of Eq. 1
    type(surface_fit_t), intent(in) :: fit                      !< how to fit
    type(specimen_t), intent(in) :: s(:)                        !< specimens
    integer, intent(in) :: n_max                                !< highest exponent of Eq. 1 by the keys of &surface
    type(found_t), allocatable, intent(out) :: found(:)         !< results, none if no fit is wanted or the map is too small
    type(error_t), allocatable, intent(out) :: error            !< bad map, bad model
    integer :: i
    if (fit%model == 'none' .or. (.not. allocated(s(1)%file) .and. fit%last_lag == 0 &
      .and. (size(s(1)%z, 1) - 1) / 2 < fit%first_lag + fewest_lags - 1)) then
      allocate (found(0))
      return
    end if
    allocate (found(merge(3, 1, size(s) == 2)))
    do i = 1, size(found)
      call check_stop(error)
      if (allocated(error)) return
      if (i == 3) then
        found(i)%name = 'equivalent'
        call fit_one(map, fit, n_max, s(1), s(2)%z, found(i), error)
      else
        found(i)%name = s(i)%name
        if (allocated(s(i)%file)) found(i)%file = s(i)%file
        call fit_one(map, fit, n_max, s(i), reshape([0._dp], [1, 1]), found(i), error)
        if (.not. allocated(error)) call new_roughness(s(i)%z, s(i)%dx, s(i)%dy, found(i)%rough, error)
      end if
      if (allocated(error)) return
      call tell(found(i))
    end do
  end subroutine fit_specimens

  !> One fit.
  subroutine fit_one(map, f, n_max, s, other, r, error)
    type(surface_t), intent(in) :: map                        !< what is known of Eq. 1
    type(surface_fit_t), intent(in) :: f                      !< how to fit
    integer, intent(in) :: n_max                          !< highest exponent
    type(specimen_t), intent(in) :: s                     !< specimen
    real(dp), intent(in), contiguous :: other(:, :)       !< second one, or a single point
    type(found_t), intent(inout) :: r                     !< result
    type(error_t), allocatable, intent(out) :: error      !< bad map, bad model
    type(ridges_t) :: ridges
    integer :: model
    logical :: small, told
    ridges = ridges_t(map%gamma, map%ridges, n_max, map%sample_length)
    small = (n_max + 1._dp) * map%ridges <= most_waves
    r%model = f%model(:9)
    if (f%model == 'auto') then
      r%model = 'spectrum'
      if (small .and. .not. allocated(s%file)) r%model = 'ridges'
    end if
    if (r%model == 'ridges' .and. .not. small) then
      call raise(error, code_input, "fit.model = 'ridges' takes up to "//to_text(most_waves)//' waves, &surface makes '// &
        to_text((n_max + 1._dp) * map%ridges)//": take 'spectrum'")
      return
    end if
    select case (r%model)
    case ('ridges'); model = model_ridges
    case ('spectrum'); model = model_spectrum
    case default; model = model_paper
    end select
    r%weighted = r%model == 'ridges'
    r%lags = [f%first_lag, f%last_lag]
    if (f%last_lag == 0) r%lags(2) = min(most_lags, (size(s%z, 1) - 1) / 2)
    r%band = [s%dx, max((size(s%z, 1) - 1) * s%dx, (size(s%z, 2) - 1) * s%dy)]
    if (size(s%z, 2) > 1) r%band(1) = min(s%dx, s%dy)
    if (r%weighted .or. .not. allocated(s%file)) r%band = map%sample_length * map%gamma**[-(n_max + 0.5_dp), 0.5_dp]
    if (f%shortest_wavelength > 0) r%band(1) = f%shortest_wavelength
    if (f%longest_wavelength > 0) r%band(2) = f%longest_wavelength
    told = f%shortest_wavelength > 0 .and. f%longest_wavelength > 0
    call measure(s%z, other, s%dx, s%dy, r%lags(1), r%lags(2), .true., &
      band_spectrum_t(model, 1 / r%band(2), 1 / r%band(1), ridges), &
      fit_options_t(told_band=told), r%m, error)
    if (allocated(error)) return
    r%ridges = ridges
    if (r%m%of_lines) r%model = merge('profile  ', 'isotropic', size(s%z, 2) == 1)
    if (r%model == 'spectrum') r%band = 1 / [r%m%blind%fit%f_hi, r%m%blind%fit%f_lo]
    r%tilt = r%m%tilt / [s%dx, s%dy]
  end subroutine fit_one

  !> One line of the log.
  subroutine tell(r)
    type(found_t), intent(in) :: r    !< result
    character(len=60) :: line
    line = ''
    if (allocated(r%m%fit%curve) .and. r%m%verdict%kind == fractal) then
      write (line, '(a,f7.4,a,f6.4,a,f6.4,a,g0.4,a)') 'D =', r%m%fit%d, ' (', r%m%fit%interval(1, 1), ' to ', &
        r%m%fit%interval(2, 1), '), G = ', 1e6_dp*exp(r%m%fit%ln_g), ' um, '
    end if
    call say('fit       '//r%name//' '//trim(line)//' '//verdict_of(r)//' ('//r%m%verdict%name//')')
  end subroutine tell

  !> The verdict in words.
  function verdict_of(r) result(text)
    type(found_t), intent(in) :: r                !< result
    character(len=:), allocatable :: text
    select case (r%m%verdict%kind)
    case (fractal); text = 'fractal'
    case (not_fractal); text = 'not fractal'
    case default; text = 'noise-dominated'
    end select
  end function verdict_of

  !> fit.csv: S over the lags of the window, the model, and the 95 % bands of a sample and of the model.
  subroutine write_fits(path, found, error)
    character(len=*), intent(in) :: path                  !< file
    type(found_t), intent(in) :: found(:)                 !< results
    type(error_t), allocatable, intent(out) :: error      !< cannot be written
    type(table_t) :: table
    integer :: i, k
    call table%open(path, 'surface,lag_m,s_m2,model_m2,model_error_ln,sample_error_ln,band_low_m2,band_high_m2', error)
    do i = 1, size(found)
      if (.not. allocated(found(i)%m%fit%curve)) cycle
      associate (o => found(i)%m%o, r => found(i)%m%fit)
        do k = 1, size(o%s)
          if (allocated(error)) exit
          call table%add(found(i)%name)
          call table%add(o%tau(k))
          call table%add(o%s(k))
          call table%add(r%curve(k))
          call table%add(r%sd_curve(k))
          call table%add(r%sd_sample(k))
          call table%add(r%curve(k) * exp(-in_95 * r%sd_sample(k)))
          call table%add(r%curve(k) * exp(in_95 * r%sd_sample(k)))
          call table%end_row(error)
        end do
      end associate
    end do
    call table%close(error)
  end subroutine write_fits

  !> The part `fits` of the summary: one object per surface.
  subroutine add_fits(json, found)
    type(json_t), intent(inout) :: json           !< summary
    type(found_t), intent(in) :: found(:)         !< results
    integer :: i
    call json%begin('fits')
    do i = 1, size(found)
      associate (f => found(i), r => found(i)%m%fit, o => found(i)%m%o)
        call json%begin(trim(f%name))
        if (allocated(f%file)) call json%add('file', f%file)
        call json%add('verdict', verdict_of(f))
        call json%add('kind', f%m%verdict%name)
        call json%add('reason', f%m%verdict%reason)
        if (allocated(r%curve)) then
          call json%add('fractal_dimension', r%d)
          call json%add('fractal_dimension_error', error_of(r%interval(:, 1)))
          call json%add('fractal_dimension_95', r%interval(:, 1))
          call json%add('fractal_dimension_95_sampling', r%interval_sampling(:, 1))
          call json%add('roughness_m', exp(r%ln_g))
          call json%add('ln_roughness_error', error_of(r%interval(:, 2)))
          call json%add('roughness_95_m', exp(max(-largest, min(largest, r%interval(:, 2)))))
          call json%add('roughness_95_sampling_m', exp(max(-largest, min(largest, r%interval_sampling(:, 2)))))
          call json%add('covariance', reshape(r%cov, [9]))
          call json%add('noise_m', sqrt(max(0._dp, r%noise_variance)))
          call json%add('residual_rms', r%rms)
          call json%add('residual_rms_expected', r%rms_expected)
          call json%add('misfit', r%misfit)
          call json%add('chi2', r%chi2)
          call json%add('freedom', r%freedom)
        end if
        if (f%model == 'spectrum') call add_spectrum(json, f%m)
        if (f%rough%sq > 0) call add_roughness(json, f%rough)
        call json%add('model', trim(f%model))
        call json%add('weighted', f%weighted)
        if (f%weighted) call add_ridges(json, f%ridges)
        call json%add('lags', real(f%lags, dp))
        call json%add('band_m', f%band)
        call json%add('tilt', f%tilt)
        call json%add('levelled', o%levelled)
        if (anisotropy(o) >= 0) call json%add('anisotropy', anisotropy(o))
        call json%finish()
      end associate
    end do
    call json%finish()
  end subroutine add_fits

  !> What the fit of a spectrum found besides D and G.
  subroutine add_spectrum(json, m)
    type(json_t), intent(inout) :: json           !< summary
    type(measurement_t), intent(in) :: m          !< fit
    call json%begin('spectrum')
    call json%add('probe_m', m%blind%fit%probe)
    call json%add('finer_detail', m%blind%fit%fold)
    call json%add('spikes', m%spikes)
    call json%add('wrong_from_m', m%seen)
    call json%add('holes', m%blind%holes)
    call json%add('seams', real(m%seams%count, dp))
    call json%add('seam_step_m', m%seams%largest)
    call json%add('jitter_m', m%seams%jitter)
    call json%add('scatter', m%blind%fit%scatter)
    call json%add('axis_excess', m%blind%rings%axis)
    call json%finish()
  end subroutine add_spectrum

  !> The sum of Eq. 1, told.
  subroutine add_ridges(json, r)
    type(json_t), intent(inout) :: json           !< summary
    type(ridges_t), intent(in) :: r               !< the sum
    call json%begin('ridges')
    call json%add('length_m', r%length)
    call json%add('shortest_wavelength_m', r%length / r%gamma**r%n_max)
    call json%add('ridges', r%count)
    call json%add('gamma', r%gamma)
    call json%finish()
  end subroutine add_ridges

  !> Roughness numbers of a specimen.
  subroutine add_roughness(json, r)
    type(json_t), intent(inout) :: json           !< summary
    type(roughness_t), intent(in) :: r            !< numbers
    call json%begin('roughness')
    call json%add('sa_m', r%sa)
    call json%add('sq_m', r%sq)
    call json%add('sz_m', r%sz)
    call json%add('ssk', r%ssk)
    call json%add('sku', r%sku)
    call json%add('sdq', r%sdq)
    call json%add('bandwidth_m', r%bandwidth)
    call json%add('nayak', r%nayak)
    call json%finish()
  end subroutine add_roughness
end module hd_fit_report
