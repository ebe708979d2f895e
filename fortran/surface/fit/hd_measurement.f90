! SPDX-License-Identifier: GPL-3.0-or-later
!> From one height map, or two that are pressed together, to D, G and a verdict.
module hd_measurement
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_memory, only: need_memory
  use hd_observation, only: observation_t, observe, level_plane, add_observation
  use hd_cleaning, only: cleaned_t, clean_map
  use hd_seams, only: seams_t, add_seams
  use hd_structure_function, only: check_map
  use hd_map_fit, only: blind_t, fit_blind, judge_blind, name_lay
  use hd_expectation, only: band_spectrum_t, check_spectrum, model_isotropic, model_profile, model_spectrum
  use hd_structure_fit, only: fit_options_t, fit_t, fit_surface
  use hd_system, only: addresses_limited, check_stop
  use hd_verdict, only: verdict_t, judge_map, judge_fit, fractal
  implicit none
  private
  public :: measurement_t, measure

  real(dp), parameter :: least_mb = 16  !< of a fit; where it is not to be had, BLAS asks for it for ever

  !> All that is found. `fit%curve` is not allocated for a constant and a plane.
  type :: measurement_t
    type(observation_t) :: o        !< S over the window; of two maps: their sum
    type(fit_t) :: fit              !< D, G, errors
    type(verdict_t) :: verdict      !< fractal or not, and why
    real(dp) :: tilt(2) = 0         !< height per point of the plane of the first map [m]
    type(blind_t) :: blind          !< of a map that nothing was known of: spectrum, probe, wrong points
    integer :: spikes = 0           !< wrong points, taken for holes
    real(dp) :: seen(2) = 0         !< height over its surroundings from which on a single point, a clump is taken for wrong [m]
    type(seams_t) :: seams          !< steps of stitching, levelled
    logical :: of_lines = .false.   !< single waves stand out, so S was fitted and not the spectrum
  end type measurement_t

contains

  !> Measure. `other` with one point stands for none; else S (or the spectrum) of both is added up. The spectrum of a map of few
  !> waves has lines, which no continuous spectrum describes: there S is fitted.
  subroutine measure(z, other, dx, dy, first, last, level, p, options, m, error)
    real(dp), intent(in), contiguous :: z(:, :), other(:, :)  !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                            !< spacing of both [m]
    integer, intent(in) :: first, last                        !< window of lags in points
    logical, intent(in) :: level                              !< take the planes off
    type(band_spectrum_t), intent(in) :: p                    !< model
    type(fit_options_t), intent(in) :: options                !< how to fit
    type(measurement_t), intent(out) :: m                     !< what was found
    type(error_t), allocatable, intent(out) :: error          !< bad map, bad model
    type(band_spectrum_t) :: model
    type(observation_t) :: o
    type(verdict_t) :: v
    type(cleaned_t) :: first_map, second_map
    real(dp) :: tilt(2), band(2)
    logical :: diagonals
    if (addresses_limited()) call need_memory('a fit', least_mb, error)
    if (.not. allocated(error)) call check_spectrum(p, error)
    if (allocated(error)) return
    model = p
    diagonals = model%model == model_spectrum
    call look(z, dx, dy, first, last, level, diagonals, options%mask, m%o, m%verdict, m%tilt, first_map, error)
    if (allocated(error)) return
    if (size(other) > 1) then
      call look(other, dx, dy, first, last, level, diagonals, options%mask, o, v, tilt, second_map, error)
      if (allocated(error)) return
      call add_observation(m%o, o, error)
      if (allocated(error)) return
      call join(m%verdict, v)
    end if
    m%spikes = first_map%spikes + second_map%spikes
    m%seen = max(first_map%seen, second_map%seen)
    m%seams = first_map%seams
    call add_seams(m%seams, second_map%seams)
    if (.not. all(m%o%s > 0)) return
    if (model%model == model_spectrum) then
      band = merge([p%f_lo, p%f_hi], 0._dp, options%told_band)
      call fit_blind(first_map, second_map, dx, dy, level, merge(options%noise, -1._dp, options%noise > 0), band, m%blind, error)
      if (allocated(error)) return
      m%seams = first_map%seams
      call add_seams(m%seams, second_map%seams)
      m%of_lines = m%blind%of_lines .or. m%blind%fit%last == 0
      if (.not. m%of_lines) then
        call judge_blind(m%o, m%blind, m%fit, m%verdict)
        return
      end if
      model%model = merge(model_profile, model_isotropic, size(z, 2) == 1)
    end if
    call fit_surface(m%o, model, options, m%fit, error)
    if (allocated(error)) return
    if (m%blind%lay > 0 .and. m%verdict%kind == fractal) call name_lay(m%blind, m%verdict)
    call judge_fit(m%o, model, options, m%fit, m%verdict)
  end subroutine measure

  !> One map: plane, structure function, first judgement.
  subroutine look(z, dx, dy, first, last, level, diagonals, mask, o, v, tilt, clean, error)
    real(dp), intent(in), contiguous :: z(:, :)         !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                      !< spacing [m]
    integer, intent(in) :: first, last                  !< window of lags in points
    logical, intent(in) :: level                        !< take the plane off
    logical, intent(in) :: diagonals                    !< observe the diagonals too
    logical, intent(in) :: mask                         !< S without wrong points; the judgement sees them, and steps of stitching
    type(observation_t), intent(out) :: o               !< S
    type(verdict_t), intent(out) :: v                   !< what the map is
    real(dp), intent(out) :: tilt(2)                    !< of the plane [m per point]
    type(cleaned_t), intent(out) :: clean               !< the map without wrong points and steps
    type(error_t), allocatable, intent(out) :: error    !< bad map
    real(dp), allocatable :: flat(:, :)
    real(dp) :: rest(2)
    tilt = 0
    call check_map(z, dx, dy, error)
    if (.not. allocated(error)) call check_stop(error)
    if (allocated(error)) return
    flat = z
    call level_plane(flat, tilt)
    clean%z = z
    if (level) clean%z = flat
    call clean_map(clean%z, [dx, dy], .true., mask, .false., clean%seams, clean%spikes, clean%seen)
    if (level .and. clean%spikes + sum(clean%seams%count) > 0) call level_plane(clean%z, rest)
    call check_stop(error)
    if (allocated(error)) return
    call observe(clean%z, dx, dy, first, last, level, diagonals, o, error)
    if (allocated(error)) return
    call check_stop(error)
    if (allocated(error)) return
    call judge_map(z, flat, first, v, error)
    if (.not. allocated(error)) call check_stop(error)
    if (allocated(error)) return
    if (v%name == 'constant' .or. (level .and. v%name == 'plane')) o%s = 0   ! what is left is rounding
  end subroutine look

  !> Two maps are fractal if both are; else the reason of the one that is not.
  subroutine join(v, other)
    type(verdict_t), intent(inout) :: v     !< of the first map, then of both
    type(verdict_t), intent(in) :: other    !< of the second
    if (v%kind /= fractal) then
      v%reason = 'first map: '//v%reason
    else if (other%kind /= fractal) then
      v = other
      v%reason = 'second map: '//v%reason
    end if
  end subroutine join
end module hd_measurement
