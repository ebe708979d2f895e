! SPDX-License-Identifier: GPL-3.0-or-later
!> A series of meshes, each about 2^(1/2) finer than the one before in all directions, and the limits of fine facets it points to.
!> Edge cells, which loops go without, keep their share of a row. Singular pressures at the band's edges then leave what goes about
!> as h^(3/2), h the length of the facets: the line through the last three levels over h^(3/2) is taken to h = 0.
module hd_mesh_series
  use hd_kinds, only: dp, pi
  use hd_fft, only: smooth_size
  use hd_promises, only: promise_t, promises, values, promises_of, wanted_of
  use hd_scene, only: scene_t
  implicit none
  private
  public :: levels, finest, coarse, first_solved, first_judged, least_tolerance, first_level, expected_error, fine, &
    share, least_error, share_of_four, meshed, extrapolate, small_displacements

  !> Facets along the band, by level; finer ones than a plan's are for references.
  integer, parameter :: band(13) = [4, 6, 8, 12, 16, 22, 32, 46, 64, 90, 128, 181, 256]
  integer, parameter :: levels = 10             !< of a plan
  integer, parameter :: finest = size(band)  !< of the series
  integer, parameter :: fewest_sectors = 16, sectors_of = 4  !< round the axis, and what their number is a multiple of: quarters
  real(dp), parameter :: aspect = 1.6_dp        !< facets are so much longer round the axis than along it
  real(dp), parameter :: edge_cells = 8         !< cells at the band's edges are so much shorter than its rows
  real(dp), parameter :: power = 1.5_dp         !< of h
  !> Of loops: relative error of limits by three meshes however well they agree, less with more, and the part of the way to the
  !> limit that may be missed. Of 11 random drives, three meshes miss K1 to K3 by 0.6 % (root mean square), and no estimate of 33.
  real(dp), parameter :: chance = 0.015_dp, part = 0.4_dp
  real(dp), parameter :: fine = 0.03_dp         !< tolerance below which the error of two layers is corrected
  real(dp), parameter :: share_of_four = 0.35_dp  !< of the error that two layers leave, left by four
  real(dp), parameter :: share = 0.45_dp        !< of it, left by a correction from a coarse mesh (31 random scenes: 0.1 to 0.45)
  real(dp), parameter :: least_tolerance = 6.6e-3_dp  !< what a correction leaves, rounded up
  !> Estimated error of limits, times rows^power, of drives beside `chance`: the median of these scenes, and of 44 plans of drives.
  real(dp), parameter :: typical = 1.4_dp, typical_drive = 0.4_dp

contains

  !> Level on which kinematics, wave generator and load steps are chosen.
  pure integer function coarse(scene)
    type(scene_t), intent(in) :: scene  !< scene
    coarse = merge(1, 3, scene%support%loop)
  end function coarse

  !> Level that the refinement begins with.
  pure integer function first_solved(scene)
    type(scene_t), intent(in) :: scene  !< scene
    first_solved = max(1, coarse(scene) - 1)
  end function first_solved

  !> First level that is judged: pressures agree by chance on coarser ones. Readings of a loop are judged by three meshes.
  pure integer function first_judged(scene)
    type(scene_t), intent(in) :: scene  !< scene
    first_judged = merge(3, 5, scene%support%loop)
  end function first_judged

  !> Level on which the tolerance is met as a rule.
  integer function first_level(scene) result(level)
    type(scene_t), intent(in) :: scene  !< scene with a tolerance
    do level = first_judged(scene), levels - 1
      if (expected_error(level, scene) <= scene%planned_tolerance) return
    end do
  end function first_level

  !> Estimated error of a level as a rule.
  real(dp) function expected_error(level, scene) result(e)
    integer, intent(in) :: level        !< of the series
    type(scene_t), intent(in) :: scene  !< scene with a tolerance
    e = merge(typical_drive, typical, scene%support%loop)/band(level)**power
    e = norm2([maxval(least_error(scene), mask=wanted_of(scene)), e, merge(chance, 0._dp, scene%support%loop)/(level - 2)])
  end function expected_error

  !> Errors of the limits that the layers leave however well the meshes agree.
  pure function least_error(scene) result(e)
    type(scene_t), intent(in) :: scene  !< scene with a tolerance
    type(promise_t) :: promised(promises)
    real(dp) :: e(promises)
    promised = promises_of(scene)
    e = promised%left
    if (scene%planned_tolerance < fine) e = share*e
  end function least_error

  !> Scene on a mesh of the series; the user's sections stay. Ring and cup match.
  pure type(scene_t) function meshed(scene, level) result(s)
    type(scene_t), intent(in) :: scene  !< scene with its load steps
    integer, intent(in) :: level        !< of the series
    s = scene
    s%band_facets = band(level)
    s%edge_length = 0  ! pressures at the band's edges are nothing to a loop
    if (.not. scene%support%loop) s%edge_length = scene%band_length/(edge_cells*band(level))
    s%divisions = max(fewest_sectors, sectors_of*smooth_size(nint(2*pi*scene%bore_radius*band(level)/ &
      (sectors_of*aspect*scene%band_length)), .false.))
    s%through_wall = 2
    s%through_ring = s%through_wall
    s%ring_divisions = 0
    s%ring_facets = 0
    s%wall_elements = 0
    s%bottom_elements = 0
  end function meshed

  !> The same scene with small displacements: errors of the mesh are estimated with them, large ones have much the same.
  pure type(scene_t) function small_displacements(scene) result(s)
    type(scene_t), intent(in) :: scene  !< scene
    s = scene
    s%kinematics = 'linear'
  end function small_displacements

  !> Limits from the levels that are known, and their estimated errors: what the last level changed of the limit, or the way that
  !> is left to it, of loops `part` of it, if that is more, and the standard error of the line's end, which outliers raise.
  !> The first limit is that of a line through two levels, which says little.
  pure subroutine extrapolate(loop, q, limit, estimate)
    logical, intent(in) :: loop                !< readings of a loop
    real(dp), intent(in) :: q(:, :)            !< quantities by level (values, levels that are known: 3 at least)
    real(dp), intent(out) :: limit(values)     !< in the units of q
    real(dp), intent(out) :: estimate(values)  !< in the units of q
    real(dp) :: before, scatter
    integer :: i, n
    n = size(q, 2)
    do i = 1, values
      call fit_line(q(i, max(1, n - 3):n - 1), n - 1, before, scatter)
      call fit_line(q(i, n - 2:n), n, limit(i), scatter)
      estimate(i) = max(abs(limit(i) - before), merge(part, 1._dp, loop)*abs(limit(i) - q(i, n))) + scatter
    end do
    if (loop) estimate = hypot(estimate, chance/(n - 2)*limit)
  end subroutine extrapolate

  !> The line through the last levels over h^(3/2) at h = 0, least squares, and its standard error there.
  pure subroutine fit_line(q, level, limit, scatter)
    real(dp), intent(in) :: q(:)         !< a quantity on these levels: three, or two
    integer, intent(in) :: level         !< the finest of them
    real(dp), intent(out) :: limit       !< at h = 0
    real(dp), intent(out) :: scatter     !< its standard error
    real(dp) :: x(size(q)), middle, slope
    x = 1/real(band(level - size(q) + 1:level), dp)**power
    middle = sum(x)/size(x)
    x = x - middle
    slope = sum(x*q)/sum(x**2)
    limit = sum(q)/size(x) - middle*slope
    scatter = norm2(q - sum(q)/size(x) - slope*x)*sqrt(1/real(size(x), dp) + middle**2/sum(x**2))
  end subroutine fit_line
end module hd_mesh_series
