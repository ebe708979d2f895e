! SPDX-License-Identifier: GPL-3.0-or-later
!> What a planned run promises: results that users read and that have a limit on ever finer meshes.
!>
!> K_TS by Eq. 45 is none of them. With the joint of a spectrum it grows without limit as cells at the edges of the band get
!> shorter, since its stiffness grows faster than the pressure there (docs/explain/planner.md).
module hd_promises
  use hd_kinds, only: dp
  use hd_facets, only: sums_t
  use hd_scene, only: scene_t
  implicit none
  private
  public :: promises, promise_t, promised, promised_values

  integer, parameter :: promises = 4   !< how many

  type :: promise_t
    character(len=23) :: column   !< of steps.csv and summary.json
    character(len=17) :: name     !< behind estimated_error_ and mesh_over_limit_
    character(len=17) :: words    !< for the log
    character(len=7) :: unit      !< of it
  end type promise_t

  type(promise_t), parameter :: promised(promises) = [ &
    promise_t('k_ts_tangent_nm_per_rad', 'k_ts_tangent', 'tangent K_TS', 'N m/rad'), &
    promise_t('rotation_rad', 'rotation', 'rotation', 'rad'), &
    promise_t('normal_force_n', 'normal_force', 'normal force', 'N'), &
    promise_t('pressure_mid_mean_pa', 'mid_band_pressure', 'mid-band pressure', 'Pa')]

contains

  !> Their values; 0 where a scene has none: no tangent with bonded faces, no rotation without a torque, no pressure where the
  !> middle of the band is open. Nothing is promised of these.
  pure function promised_values(scene, sums) result(q)
    type(scene_t), intent(in) :: scene  !< scene
    type(sums_t), intent(in) :: sums    !< of its last step
    real(dp) :: q(promises)             !< in their units
    q = [sums%k_tangent, sums%rotation, sums%normal_force, sums%pressure_middle]
    if (.not. (scene%torque_steps > 0 .and. abs(scene%torque) > 0)) q(2) = 0
    where (.not. abs(q) > 0) q = 0  ! not a number
  end function promised_values
end module hd_promises
