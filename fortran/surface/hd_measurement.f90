! SPDX-License-Identifier: GPL-3.0-or-later
!> From one height map, or two that are pressed together, to D, G and a verdict.
module hd_measurement
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_observation, only: observation_t, observe, level_plane, add_observation
  use hd_structure_function, only: check_map
  use hd_expectation, only: spectrum_t, model_isotropic, model_ridges
  use hd_ridge_search, only: find_ridges
  use hd_surface_fit, only: fit_options_t, fit_t, fit_surface
  use hd_verdict, only: verdict_t, judge_map, judge_fit, fractal
  use hd_wave_sum, only: ridges_t
  implicit none
  private
  public :: measurement_t, measure

  !> All that is found. `fit%curve` is not allocated for a constant and a plane.
  type :: measurement_t
    type(observation_t) :: o        !< S over the window; of two maps: their sum
    type(fit_t) :: fit              !< D, G, errors
    type(verdict_t) :: verdict      !< fractal or not, and why
    real(dp) :: tilt(2) = 0         !< height per point of the plane of the first map [m]
    logical :: recognised = .false. !< `ridges` was found in the map and fitted
    type(ridges_t) :: ridges        !< the sum of Eq. 1
  end type measurement_t

contains

  !> Measure; if wanted, look first whether the map is a sum of Eq. 1. `other` with one point stands for none; else S of both is
  !> added up. L is known up to a power of gamma: the likeliest that S agrees with is taken, none if it agrees with none.
  subroutine measure(z, other, dx, dy, first, last, level, p, options, m, error)
    real(dp), intent(in), contiguous :: z(:, :), other(:, :)  !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                            !< spacing of both [m]
    integer, intent(in) :: first, last                        !< window of lags in points
    logical, intent(in) :: level                              !< take the planes off
    type(spectrum_t), intent(in) :: p                         !< model
    type(fit_options_t), intent(in) :: options                !< how to fit
    type(measurement_t), intent(out) :: m                     !< what was found
    type(error_t), allocatable, intent(out) :: error          !< bad map, bad model
    integer, parameter :: powers(5) = [0, 1, -1, 2, -2], most = 1000
    type(fit_options_t) :: told
    type(ridges_t) :: r
    logical :: found
    integer :: i
    if (options%search) then
      call look_for_ridges(z, other, dx, dy, r, found)
      told = options
      told%weighted = .true.
      told%known = .true.
      do i = 1, size(powers)
        if (.not. found) exit
        m%ridges = ridges_t(r%gamma, r%count, r%n_max + powers(i), r%length * r%gamma**powers(i))
        if (m%ridges%count * (m%ridges%n_max + 1) > most) cycle
        call attempt(spectrum_t(model_ridges, p%f_lo, p%f_hi, m%ridges), told)
        if (allocated(error)) return
        m%recognised = m%verdict%kind == fractal .and. m%fit%chi2 < limit(m%fit%freedom)
        if (m%recognised) return
      end do
    end if
    call attempt(p, options)
  contains
    !> Level, observe, judge and fit one model.
    subroutine attempt(model, how)
      type(spectrum_t), intent(in) :: model      !< model
      type(fit_options_t), intent(in) :: how     !< how to fit
      type(observation_t) :: o
      type(verdict_t) :: v
      real(dp) :: tilt(2)
      logical :: diagonals
      diagonals = model%model == model_isotropic
      call look(z, dx, dy, first, last, level, diagonals, m%o, m%verdict, m%tilt, error)
      if (allocated(error)) return
      if (size(other) > 1) then
        call look(other, dx, dy, first, last, level, diagonals, o, v, tilt, error)
        if (allocated(error)) return
        call add_observation(m%o, o, error)
        if (allocated(error)) return
        call join(m%verdict, v)
      end if
      if (.not. all(m%o%s > 0)) return
      call fit_surface(m%o, model, how, m%fit, error)
      if (allocated(error)) return
      call judge_fit(m%o, model, how, m%fit, m%verdict)
    end subroutine attempt

    !> What chi2 exceeds once in 10 000 (Wilson and Hilferty).
    pure real(dp) function limit(freedom)
      integer, intent(in) :: freedom    !< degrees of freedom
      limit = freedom * (1 - 2 / (9._dp * freedom) + 3.719_dp * sqrt(2 / (9._dp * freedom)))**3
    end function limit
  end subroutine measure

  !> Ridges of one map, or those that two maps share.
  subroutine look_for_ridges(z, other, dx, dy, r, found)
    real(dp), intent(in), contiguous :: z(:, :), other(:, :)  !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                            !< spacing of both [m]
    type(ridges_t), intent(out) :: r                          !< the sum
    logical, intent(out) :: found                             !< there is one
    type(ridges_t) :: q
    call find(z, r, found)
    if (.not. found .or. size(other) == 1) return
    call find(other, q, found)
    found = found .and. q%count == r%count .and. q%n_max == r%n_max .and. abs(q%gamma - r%gamma) < 1e-3_dp * r%gamma &
      .and. abs(q%length - r%length) < 1e-3_dp * r%length
  contains
    subroutine find(map, ridges, there)
      real(dp), intent(in), contiguous :: map(:, :)   !< heights [m]
      type(ridges_t), intent(out) :: ridges           !< the sum
      logical, intent(out) :: there                   !< there is one
      real(dp), allocatable :: flat(:, :)
      real(dp) :: tilt(2)
      flat = map
      call level_plane(flat, tilt)
      call find_ridges(flat, dx, dy, ridges, there)
    end subroutine find
  end subroutine look_for_ridges

  !> One map: plane, structure function, first judgement.
  subroutine look(z, dx, dy, first, last, level, diagonals, o, v, tilt, error)
    real(dp), intent(in), contiguous :: z(:, :)         !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                      !< spacing [m]
    integer, intent(in) :: first, last                  !< window of lags in points
    logical, intent(in) :: level                        !< take the plane off
    logical, intent(in) :: diagonals                    !< observe the diagonals too
    type(observation_t), intent(out) :: o               !< S
    type(verdict_t), intent(out) :: v                   !< what the map is
    real(dp), intent(out) :: tilt(2)                    !< of the plane [m per point]
    type(error_t), allocatable, intent(out) :: error    !< bad map
    real(dp), allocatable :: flat(:, :)
    tilt = 0
    call check_map(z, dx, dy, error)
    if (allocated(error)) return
    flat = z
    call level_plane(flat, tilt)
    if (level) then
      call observe(flat, dx, dy, first, last, .true., diagonals, o, error)
    else
      call observe(z, dx, dy, first, last, .false., diagonals, o, error)
    end if
    if (allocated(error)) return
    call judge_map(z, flat, first, v, error)
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
