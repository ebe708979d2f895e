! SPDX-License-Identifier: GPL-3.0-or-later
module test_mesh_series
  use hd_check, only: check, check_close
  use hd_kinds, only: dp
  use hd_mesh_series, only: extrapolate, first_judged, expected_error, first_level, least_error, least_tolerance, levels, meshed
  use hd_promises, only: promises, promise_t, promises_of, promise_text, relative, every_second, values
  use hd_scene, only: scene_t
  use hd_support, only: support_of
  implicit none
  private
  public :: run_mesh_series

contains

  subroutine run_mesh_series()
    real(dp), parameter :: rows(6) = [4._dp, 6._dp, 8._dp, 12._dp, 16._dp, 22._dp]
    real(dp), parameter :: x(3) = [0.1_dp, 0.03_dp, 0.01_dp]
    type(scene_t) :: scene, one, two
    real(dp) :: q(values, 6), limit(values), estimate(values)
    integer :: i
    q = 0
    q(1, :) = 2 + 5/rows**1.5_dp
    q(2, :) = 7 - 3/rows**1.5_dp
    q(3, :) = 3 + [0._dp, 0._dp, 0.3_dp, 0._dp, 0._dp, 0._dp]
    q(4, :) = 2 + 5/rows
    call extrapolate(.false., q, limit, estimate)
    call check_close(limit(1), 2._dp, 1e-12_dp, 'what moves in proportion to h^(3/2) has its limit at h = 0')
    call check_close(limit(2), 7._dp, 1e-12_dp, 'upwards, too')
    call check(estimate(1) >= 5/22._dp**1.5_dp/2*(1 - 1e-9_dp), 'the way to the limit is its error')
    call check_close(limit(3), 3._dp, 1e-12_dp, 'a coarse mesh counts no more')
    call check(estimate(3) > 0.01_dp, 'what it changed of the limit is its error')
    call check(abs(limit(4) - 2) < 2*estimate(4), &
      'the estimate covers half of a first order taken for one of three halves')
    call extrapolate(.true., q(:, :3), limit, estimate)
    call check_close(limit(1), 2._dp, 1e-12_dp, 'three meshes give the line as well')
    call check(estimate(1) > norm2([0.015_dp*2, 0.4_dp*5/8._dp**1.5_dp])*(1 - 1e-9_dp), &
      'but agree by chance: that is added to two fifths of the way')
    call extrapolate(.true., q(:, :4), limit, estimate)
    call check(estimate(1) < norm2([0.008_dp*2, 0.41_dp*5/12._dp**1.5_dp]), 'four meshes less so')
    call check(first_judged(scene) == 5, 'pressures are judged from 16 rows on')
    do i = 1, 6
      if (i == 4) scene%support = support_of('drive')
      scene%planned_tolerance = x(modulo(i - 1, 3) + 1)
      call check(first_level(scene) >= first_judged(scene) .and. &
        expected_error(first_level(scene), scene) <= scene%planned_tolerance, 'the first level may keep the promise')
    end do
    call check(first_judged(scene) == 3, 'readings of a loop are judged from 8 rows on')
    scene%support = support_of('hub')
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
    scene%support = support_of('drive')
    one = meshed(scene, 5)
    call check(.not. one%edge_length > 0, 'loops have none')
    call check_relative()
  end subroutine run_mesh_series

  !> Promises of several numbers.
  subroutine check_relative()
    type(scene_t) :: scene
    type(promise_t) :: list(promises)
    real(dp) :: value(values), error(values), r(promises)
    scene%support = support_of('hub')
    list = promises_of(scene)
    value = 0
    error = 0
    associate (k => list(promises - 1), p => list(promises))
      value(k%first:k%first + 1) = [2._dp, 4._dp]
      error(k%first:k%first + 2) = [0.2_dp, 0.1_dp, 9._dp]
      value(p%first:p%first + 1) = [3._dp, 4._dp]
      error(p%first + 1:p%first + 2) = [0.3_dp, 0.4_dp]
      r = relative(scene, error, value)
      call check_close(r(promises - 1), 0.1_dp, 1e-12_dp, 'the error of several numbers is the largest of those that are there')
      call check_close(r(promises), 0.1_dp, 1e-12_dp, 'the error of a field is that of its norm, where it is 0 too')
      call check_close(maxval(r(:promises - 2)), 0._dp, 1e-12_dp, 'what has no value has no error')
      call check(promise_text(k, value) == 'K_TS of all steps 2.0 to 4.0 N m/rad', 'several numbers are told by their range')
      call check(len(promise_text(list(1), value)) == 0, 'what has no value is not told')
    end associate
    value(list(promises - 1)%first + [0, 1, 2]) = [2._dp, 3._dp, 4._dp]
    value = every_second(scene, value)
    call check_close(value(list(promises - 1)%first + 1), 4._dp, 1e-12_dp, &
      'steps of a doubled run stand beside those of one with half as many')
  end subroutine check_relative
end module test_mesh_series
