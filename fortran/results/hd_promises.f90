! SPDX-License-Identifier: GPL-3.0-or-later
!> What a planned run promises: results that users read and that have a limit on ever finer meshes.
!>
!> K_TS by Eq. 45 is none of them. With the joint of a spectrum it grows without limit as cells at the edges of the band get
!> shorter, since its stiffness grows faster than the pressure there (docs/explain/planner.md).
module hd_promises
  use hd_kinds, only: dp
  use hd_facets, only: sums_t
  use hd_loop, only: loop_t, readings_t, read_loop
  use hd_scene, only: scene_t
  implicit none
  private
  public :: promises, promise_t, promises_of, promised_values

  integer, parameter :: promises = 4   !< how many

  type :: promise_t
    character(len=23) :: column   !< of steps.csv and summary.json
    character(len=17) :: name     !< behind estimated_error_ and mesh_over_limit_
    character(len=17) :: words    !< for the log
    character(len=7) :: unit      !< of it
  end type promise_t

  type(promise_t), parameter :: of_contact(promises) = [ &
    promise_t('k_ts_tangent_nm_per_rad', 'k_ts_tangent', 'tangent K_TS', 'N m/rad'), &
    promise_t('rotation_rad', 'rotation', 'rotation', 'rad'), &
    promise_t('normal_force_n', 'normal_force', 'normal force', 'N'), &
    promise_t('pressure_mid_mean_pa', 'mid_band_pressure', 'mid-band pressure', 'Pa')]
  type(promise_t), parameter :: of_drive(promises) = [ &
    promise_t('k1_nm_per_rad', 'k1', 'K1', 'N m/rad'), promise_t('k2_nm_per_rad', 'k2', 'K2', 'N m/rad'), &
    promise_t('k3_nm_per_rad', 'k3', 'K3', 'N m/rad'), promise_t('hysteresis_rad', 'hysteresis', 'hysteresis', 'rad')]

contains

  !> What is promised of a scene: of its last step, or of the loop of a whole drive.
  pure function promises_of(scene) result(list)
    type(scene_t), intent(in) :: scene  !< scene
    type(promise_t) :: list(promises)
    list = of_contact
    if (scene%support == 'drive') list = of_drive
  end function promises_of

  !> Their values; 0 where a scene has none: no tangent with bonded faces, no rotation without a torque, no pressure where the
  !> middle of the band is open, no K3 of a loop that ends at T2, no hysteresis of one that does not come back. Nothing is promised
  !> of these.
  pure function promised_values(scene, sums, loop) result(q)
    type(scene_t), intent(in) :: scene  !< scene
    type(sums_t), intent(in) :: sums    !< of its last step
    type(loop_t), intent(in) :: loop    !< of a whole drive
    real(dp) :: q(promises)             !< in their units
    type(readings_t) :: readings
    if (scene%support == 'drive') then
      readings = read_loop(loop, scene)
      q = [readings%k, readings%hysteresis]
      return
    end if
    q = [sums%k_tangent, sums%rotation, sums%normal_force, sums%pressure_middle]
    if (.not. (scene%torque_steps > 0 .and. abs(scene%torque) > 0)) q(2) = 0
    where (.not. abs(q) > 0) q = 0  ! not a number
  end function promised_values
end module hd_promises
