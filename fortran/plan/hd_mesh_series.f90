! SPDX-License-Identifier: GPL-3.0-or-later
!> A series of meshes, each about 2^(1/2) finer than the one before in all directions, and the limits of fine facets it points to.
module hd_mesh_series
  use hd_kinds, only: dp, pi
  use hd_fft, only: smooth_size
  use hd_promises, only: promises
  use hd_scene, only: scene_t
  implicit none
  private
  public :: levels, finest, coarse, first_judged, least_tolerance, first_level, least_error, meshed, extrapolate

  !> Facets along the band, by level; finer ones than a plan's are for references.
  integer, parameter :: band(13) = [4, 6, 8, 12, 16, 22, 32, 46, 64, 90, 128, 181, 256]
  integer, parameter :: levels = 10             !< of a plan
  integer, parameter :: finest = size(band)     !< of the series
  integer, parameter :: coarse = 3              !< level on which kinematics and load steps are chosen
  integer, parameter :: first_judged = 5        !< coarser meshes agree by chance
  real(dp), parameter :: aspect = 1.6_dp        !< facets are so much longer round the axis than along it
  real(dp), parameter :: edge_cells = 8         !< cells at the band's edges are so much shorter than its rows
  real(dp), parameter :: fine = 0.02_dp         !< tolerance below which four layers are needed, not two
  !> Errors of the limits of the tangent K_TS, rotation, normal force and mid-band pressure that a plan leaves however well its
  !> meshes agree.
  real(dp), parameter :: jumps(promises) = [1.3_dp, 0.8_dp, 0.5_dp, 4.0_dp], left(promises) = [5e-3_dp, 1.5e-3_dp, 1e-3_dp, 3e-3_dp]
  real(dp), parameter :: least_tolerance = 2.6e-3_dp  !< least error of the finest level, rounded up

contains

  !> Level on which the tolerance may be met.
  pure integer function first_level(tolerance) result(level)
    real(dp), intent(in) :: tolerance  !< relative
    do level = first_judged, levels - 1
      if (maxval(least_error(level, tolerance)) <= tolerance) return
    end do
  end function first_level

  !> Errors of the limits that a level leaves however well its meshes agree: three of them may agree by chance.
  pure function least_error(level, tolerance) result(e)
    integer, intent(in) :: level       !< of the series
    real(dp), intent(in) :: tolerance  !< relative
    real(dp) :: e(promises)
    e = hypot(jumps/band(level)**2, merge(left/2, left, tolerance < fine))
  end function least_error

  !> Scene on a mesh of the series; the user's sections stay. Ring and cup match.
  pure type(scene_t) function meshed(scene, level) result(s)
    type(scene_t), intent(in) :: scene  !< scene with its load steps
    integer, intent(in) :: level        !< of the series
    s = scene
    s%band_facets = band(level)
    s%edge_length = scene%band_length/(edge_cells*band(level))
    s%divisions = max(16, 4*smooth_size(nint(pi*scene%bore_radius*band(level)/(2*aspect*scene%band_length)), .false.))
    s%through_wall = merge(4, 2, scene%planned_tolerance > 0 .and. scene%planned_tolerance < fine)
    s%through_ring = s%through_wall
    s%ring_divisions = 0
    s%ring_facets = 0
    s%wall_elements = 0
    s%bottom_elements = 0
  end function meshed

  !> Limits from the levels that are known, and their estimated relative errors: what the last level changed of the limit, or the way
  !> that is left to it if that is more.
  pure subroutine extrapolate(q, limit, estimate)
    real(dp), intent(in) :: q(:, :)              !< quantities by level (promises, levels that are known: 4 at least)
    real(dp), intent(out) :: limit(promises)     !< in the units of q
    real(dp), intent(out) :: estimate(promises)  !< relative
    real(dp) :: before
    integer :: i, n
    n = size(q, 2)
    do i = 1, promises
      before = on_line(q(i, n - 3:n - 1), n - 1)
      limit(i) = on_line(q(i, n - 2:n), n)
      estimate(i) = max(abs(limit(i) - before), abs(limit(i) - q(i, n)))/(abs(limit(i)) + tiny(1._dp))
    end do
  end subroutine extrapolate

  !> The line through three levels over h^2 at h = 0, least squares with weights of 1 / h^4: what a mesh lies off it goes as h^2, too.
  pure real(dp) function on_line(q, level) result(limit)
    real(dp), intent(in) :: q(3)         !< a quantity on these levels
    integer, intent(in) :: level         !< the finest of the three
    real(dp) :: x(3), w(3), mean
    x = 1._dp/band(level - 2:level)**2
    w = 1/x**2
    w = w/sum(w)
    mean = sum(w*x)
    limit = sum(w*q) - mean*sum(w*(x - mean)*q)/sum(w*(x - mean)**2)
  end function on_line
end module hd_mesh_series
