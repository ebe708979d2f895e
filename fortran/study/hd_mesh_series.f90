! SPDX-License-Identifier: GPL-3.0-or-later
!> A series of meshes, each about 2^(1/2) finer than the one before in all directions, and the limits of fine facets it points to.
!>
!> K_TS converges in proportion to the facets' length h, slowly but evenly: the facets on the edge of the contact and of the
!> region that sticks decide. So the line through the last three levels is taken to h = 0. Normal force and mid-band pressure
!> converge so in some scenes only; in others they are already near their limit and jump: there the finest mesh stands for it.
module hd_mesh_series
  use hd_kinds, only: dp, pi
  use hd_fft, only: smooth_size
  use hd_scene, only: scene_t
  implicit none
  private
  public :: levels, rough, first_level, expected_error, least_error, meshed, extrapolate

  integer, parameter :: band(10) = [4, 6, 8, 12, 16, 22, 32, 46, 64, 90]  !< facets along the band, by level
  integer, parameter :: levels = size(band)
  real(dp), parameter :: first_error = 16       !< estimate with one facet; falls as 1 / facets^2 (reference scenes)
  real(dp), parameter :: margin = 1.3_dp        !< on estimates
  real(dp), parameter :: share = 1/3._dp        !< of the way from a mesh to the limit that counts as its error at least
  real(dp), parameter :: rough = 0.05_dp        !< tolerance from which on edge cells refined twice and one layer may do
  !> Error of the limits of K_TS and mid-band pressure times facets along the band: twice the rms of judged promises.
  real(dp), parameter :: jumps = 0.40_dp, rough_jumps = 0.87_dp
  real(dp), parameter :: differ = 2.5e-3_dp     !< what more layers change of K_TS on one mesh and on another: twice the rms
  real(dp), parameter :: aspect = 1.6_dp        !< facets are so much longer round the axis than along it

contains

  !> Level on which the tolerance may be met: estimates scatter by a factor of two.
  pure integer function first_level(tolerance) result(level)
    real(dp), intent(in) :: tolerance  !< relative
    do level = 5, levels - 1
      if (expected_error(level, tolerance) <= 2*tolerance) return
    end do
  end function first_level

  !> Estimate that is expected on a level.
  pure real(dp) function expected_error(level, tolerance)
    integer, intent(in) :: level       !< of the series
    real(dp), intent(in) :: tolerance  !< relative
    expected_error = max(first_error/band(level)**2, least_error(level, tolerance))
  end function expected_error

  !> Error of K_TS and mid-band pressure that a level leaves however well its meshes agree: three of them may agree by chance.
  pure real(dp) function least_error(level, tolerance)
    integer, intent(in) :: level       !< of the series
    real(dp), intent(in) :: tolerance  !< relative
    least_error = hypot(merge(rough_jumps, jumps, tolerance >= rough)/band(level), differ)
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
  !> changed of a line's limit, at least a share of the way to it; of a mesh, the way that its distance from the coarser ones
  !> leaves to go if it is the first order's.
  pure subroutine extrapolate(q, level, limit, estimate)
    real(dp), intent(in) :: q(:, :)      !< quantities by level (3, levels)
    integer, intent(in) :: level         !< the finest that is known, 4 at least
    real(dp), intent(out) :: limit(3)    !< in the units of q
    real(dp), intent(out) :: estimate(3) !< relative
    integer :: i, k
    do i = 1, 3
      if (i == 1 .or. in_proportion(q(i, :), level)) then
        limit(i) = line_end(q(i, :), level)
        estimate(i) = max(abs(limit(i) - line_end(q(i, :), level - 1)), share*abs(limit(i) - q(i, level)))
      else
        limit(i) = q(i, level)
        estimate(i) = maxval([(abs(q(i, level) - q(i, level - k))*band(level - k)/real(band(level) - band(level - k), dp), k=1, 3)])
      end if
    end do
    estimate = margin*estimate/(abs(limit) + tiny(1._dp))
  end subroutine extrapolate

  !> Slopes over h of the last three pairs of levels agree within a factor of two.
  pure logical function in_proportion(q, level)
    real(dp), intent(in) :: q(:)     !< a quantity by level
    integer, intent(in) :: level     !< the finest that is known
    real(dp) :: h(4), slope(3)
    h = 1._dp/band(level - 3:level)
    slope = (q(level - 2:level) - q(level - 3:level - 1))/(h(2:) - h(:3))
    in_proportion = all(slope(2:)*slope(:2) > 0) .and. all(abs(slope(2:)) < 2*abs(slope(:2))) .and. &
      all(abs(slope(:2)) < 2*abs(slope(2:)))
  end function in_proportion

  !> The line through the last three levels at h = 0, least squares.
  pure real(dp) function line_end(q, level)
    real(dp), intent(in) :: q(:)     !< a quantity by level
    integer, intent(in) :: level     !< the finest of the three
    real(dp) :: h(3), mean
    h = 1._dp/band(level - 2:level)
    mean = sum(h)/3
    line_end = sum(q(level - 2:level))/3 - mean*sum((h - mean)*q(level - 2:level))/sum((h - mean)**2)
  end function line_end
end module hd_mesh_series
