! SPDX-License-Identifier: GPL-3.0-or-later
!> A series of meshes, each about 2^(1/2) finer than the one before in all directions, and the limits of fine facets it points to.
!>
!> With power means where contact ends (hd_contact_edge) K_TS, normal force and mid-band pressure converge about as the square of
!> the facets' length h: the line through the last three levels over h^2 is taken to h = 0.
module hd_mesh_series
  use hd_kinds, only: dp, pi
  use hd_fft, only: smooth_size
  use hd_scene, only: scene_t
  implicit none
  private
  public :: levels, finest, rough, least_tolerance, first_level, least_error, meshed, extrapolate

  !> Facets along the band, by level; finer ones than a plan's are for references.
  integer, parameter :: band(13) = [4, 6, 8, 12, 16, 22, 32, 46, 64, 90, 128, 181, 256]
  integer, parameter :: levels = 10             !< of a plan
  integer, parameter :: finest = size(band)     !< of the series
  real(dp), parameter :: margin = 1.3_dp        !< on estimates
  real(dp), parameter :: rough = 0.05_dp        !< tolerance from which on one layer may do
  !> Errors of the limits of K_TS, normal force, mid-band pressure: twice the rms of judged promises, times the square of the facets
  !> along the band; rough, where the layer decides, as they are.
  real(dp), parameter :: jumps(3) = [3.2_dp, 1.0_dp, 5.3_dp], rough_least(3) = [0.035_dp, 0.008_dp, 0.045_dp]
  real(dp), parameter :: differ = 2.5e-3_dp     !< what more layers change of K_TS on one mesh and on another: twice the rms
  real(dp), parameter :: least_tolerance = 2.6e-3_dp  !< least error of the finest level, rounded up
  real(dp), parameter :: aspect = 1.6_dp        !< facets are so much longer round the axis than along it

contains

  !> Level on which the tolerance may be met; estimates need three coarser ones.
  pure integer function first_level(tolerance) result(level)
    real(dp), intent(in) :: tolerance  !< relative
    do level = 4, levels - 1
      if (maxval(least_error(level, tolerance)) <= tolerance) return
    end do
  end function first_level

  !> Errors of the limits that a level leaves however well its meshes agree: three of them may agree by chance.
  pure function least_error(level, tolerance) result(e)
    integer, intent(in) :: level       !< of the series
    real(dp), intent(in) :: tolerance  !< relative
    real(dp) :: e(3)
    e = jumps/band(level)**2
    e([1, 3]) = hypot(e([1, 3]), differ)
    if (tolerance >= rough) e = max(e, rough_least)
  end function least_error

  !> Scene on a mesh of the series; the user's sections stay.
  pure type(scene_t) function meshed(scene, level) result(s)
    type(scene_t), intent(in) :: scene  !< scene with its load steps, edge cells and layers
    integer, intent(in) :: level        !< of the series
    s = scene
    s%band_facets = band(level)
    s%divisions = max(16, 4*smooth_size(nint(pi*scene%bore_radius*band(level)/(2*aspect*scene%band_length)), .false.))
    s%ring_divisions = 0
    s%ring_facets = 0
    s%wall_elements = 0
    s%bottom_elements = 0
  end function meshed

  !> Limits from four levels: K_TS, normal force, mid-band pressure, and their estimated relative errors: what the last level
  !> changed of the line's limit, or the way that is left to it if that is more, and the limit's standard deviation.
  pure subroutine extrapolate(q, level, limit, estimate)
    real(dp), intent(in) :: q(:, :)      !< quantities by level (3, levels)
    integer, intent(in) :: level         !< the finest that is known, 4 at least
    real(dp), intent(out) :: limit(3)    !< in the units of q
    real(dp), intent(out) :: estimate(3) !< relative
    real(dp) :: before, deviation
    integer :: i
    do i = 1, 3
      call fit_line(q(i, level - 3:level - 1), level - 1, before, deviation)
      call fit_line(q(i, level - 2:level), level, limit(i), deviation)
      estimate(i) = margin*max(abs(limit(i) - before), abs(limit(i) - q(i, level))) + deviation
    end do
    estimate = estimate/(abs(limit) + tiny(1._dp))
  end subroutine extrapolate

  !> The line through three levels over h^2 at h = 0, least squares, and its standard deviation from what they lie off it. That goes
  !> as h^2, too: weights are 1 / h^4.
  pure subroutine fit_line(q, level, limit, deviation)
    real(dp), intent(in) :: q(3)         !< a quantity on these levels
    integer, intent(in) :: level         !< the finest of the three
    real(dp), intent(out) :: limit       !< of the line
    real(dp), intent(out) :: deviation   !< standard, of one degree of freedom
    real(dp) :: x(3), w(3), mean, slope, spread
    x = 1._dp/band(level - 2:level)**2
    w = 1/x**2
    w = w/sum(w)
    mean = sum(w*x)
    x = x - mean
    spread = sum(w*x**2)
    slope = sum(w*x*q)/spread
    limit = sum(w*q) - slope*mean
    deviation = sqrt(sum(w*(q - limit - slope*(x + mean))**2)*(1 + mean**2/spread))
  end subroutine fit_line
end module hd_mesh_series
