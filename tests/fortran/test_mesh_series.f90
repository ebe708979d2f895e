! SPDX-License-Identifier: GPL-3.0-or-later
module test_mesh_series
  use hd_check, only: check, check_close
  use hd_kinds, only: dp
  use hd_mesh_series, only: extrapolate, first_judged, expected_error, first_level, least_error, least_tolerance, levels, meshed
  use hd_promises, only: promises
  use hd_scene, only: scene_t
  implicit none
  private
  public :: run_mesh_series

contains

  subroutine run_mesh_series()
    real(dp), parameter :: rows(6) = [4._dp, 6._dp, 8._dp, 12._dp, 16._dp, 22._dp]
    real(dp), parameter :: x(3) = [0.1_dp, 0.03_dp, 0.01_dp]
    type(scene_t) :: scene, one, two
    real(dp) :: q(promises, 6), limit(promises), estimate(promises)
    integer :: i
    q(1, :) = 2 + 5/rows**1.5_dp
    q(2, :) = 7 - 3/rows**1.5_dp
    q(3, :) = 3 + [0._dp, 0._dp, 0.3_dp, 0._dp, 0._dp, 0._dp]
    q(4, :) = 2 + 5/rows
    call extrapolate(q, limit, estimate)
    call check_close(limit(1), 2._dp, 1e-12_dp, 'what moves in proportion to h^(3/2) has its limit at h = 0')
    call check_close(limit(2), 7._dp, 1e-12_dp, 'upwards, too')
    call check(estimate(1) >= 5/22._dp**1.5_dp/2*(1 - 1e-9_dp), 'the way to the limit is its error')
    call check_close(limit(3), 3._dp, 1e-12_dp, 'a coarse mesh counts no more')
    call check(estimate(3) > 0.01_dp, 'what it changed of the limit is its error')
    call check(abs(limit(4) - 2) < 2*estimate(4)*limit(4), &
      'the estimate covers half of a first order taken for one of three halves')
    do i = 1, 3
      scene%planned_tolerance = x(i)
      call check(first_level(scene) >= first_judged .and. expected_error(first_level(scene), scene) <= x(i), &
        'the first level may keep the promise')
    end do
    scene%planned_tolerance = least_tolerance
    call check(maxval(least_error(scene)) < least_tolerance .and. expected_error(levels, scene) < least_tolerance, &
      'the finest level may keep the least promise')
    scene%planned_tolerance = 0
    scene%ring_divisions = 40
    scene%ring_facets = 7
    one = meshed(scene, 5)
    two = meshed(scene, 7)
    call check(one%ring_divisions == 0 .and. one%ring_facets == 0, 'meshes of a plan match: slave and master are the same')
    call check_close(one%edge_length/two%edge_length, real(two%band_facets, dp)/one%band_facets, 1e-12_dp, &
      'edge cells keep their share of a row')
  end subroutine run_mesh_series
end module test_mesh_series
