! SPDX-License-Identifier: GPL-3.0-or-later
!> What a planned run promises: results that users read and that have a limit on ever finer meshes.
!>
!> K_TS by Eq. 45 is none of them. With the joint of a spectrum it grows without limit as cells at the edges of the band get
!> shorter, since its stiffness grows faster than the pressure there (docs/explain/planner.md).
!>
!> A promise is one number or several: K_TS of all load steps, the pressures of all patches (hd_pressure_patches). Their values
!> stand one after the other in a list of `values` numbers.
module hd_promises
  use hd_kinds, only: dp
  use hd_facets, only: sums_t
  use hd_loop, only: loop_t, readings_t, read_loop
  use hd_pressure_patches, only: patches
  use hd_scene, only: scene_t
  use hd_text, only: rounded
  implicit none
  private
  public :: promises, values, most_steps, k_of_steps, promise_t, promises_of, wanted_of, promised_values, is_field, relative
  public :: promise_text, every_second, promise_names

  integer, parameter :: promises = 8                           !< how many
  integer, parameter :: k_of_steps = promises - 1              !< the one of all steps
  integer, parameter :: most_steps = 16                        !< torque steps of which K_TS is promised; if there are more: of none
  integer, parameter :: values = 6 + most_steps + 1 + patches  !< numbers in all promises

  type :: promise_t
    character(len=29) :: column = ''  !< of steps.csv and summary.json
    character(len=18) :: name = ''    !< behind estimated_error_ and mesh_over_limit_
    character(len=18) :: words = ''   !< for the log
    character(len=7) :: unit = ''     !< of it
    integer :: first = 1, last = 0    !< its numbers among `values`
    real(dp) :: left = 0              !< relative error of its limit that two layers of cells through wall and ring leave
    logical :: usual = .true.         !< it is wanted where run.wanted does not say what is
  end type promise_t

  !> What is not usually wanted is promised where it is within the tolerance, too: peaks settle slowly where contact ends round the
  !> axis, K_TS while the torque is small, where few points stick, and the hysteresis is the small difference of large rotations.
  !> Errors left are root mean squares of 22 scenes, of ten from K_FTS on, of seven whole drives.
  type(promise_t), parameter :: of_contact(promises) = [ &
    promise_t('k_ts_bonded_nm_per_rad', 'k_ts_tangent', 'tangent K_TS', 'N m/rad', 1, 1, 0.014_dp), &
    promise_t('rotation_rad', 'rotation', 'rotation', 'rad', 2, 2, 0.005_dp), &
    promise_t('normal_force_n', 'normal_force', 'normal force', 'N', 3, 3, 0.002_dp), &
    promise_t('pressure_mid_mean_pa', 'mid_band_pressure', 'mid-band pressure', 'Pa', 4, 4, 0.005_dp), &
    promise_t('k_fe_secant_nm_per_rad', 'k_fts', 'K_FTS', 'N m/rad', 5, 5, 0.002_dp), &
    promise_t('pressure_mid_max_pa', 'mid_band_peak', 'mid-band peak', 'Pa', 6, 6, 0.005_dp, .false.), &
    promise_t('k_ts_tangent_steps_nm_per_rad', 'k_ts_tangent_steps', 'K_TS of all steps', 'N m/rad', 7, 7 + most_steps, &
      0.014_dp, .false.), &
    promise_t('pressure_field_pa', 'pressure_field', 'pressure field', 'Pa', 8 + most_steps, values, 0.003_dp)]
  type(promise_t), parameter :: of_drive(promises) = [ &
    promise_t('k1_nm_per_rad', 'k1', 'K1', 'N m/rad', 1, 1, 0.004_dp), &
    promise_t('k2_nm_per_rad', 'k2', 'K2', 'N m/rad', 2, 2, 0.004_dp), &
    promise_t('k3_nm_per_rad', 'k3', 'K3', 'N m/rad', 3, 3, 0.002_dp), &
    promise_t('hysteresis_rad', 'hysteresis', 'hysteresis', 'rad', 4, 4, 0.016_dp, .false.), &
    promise_t(), promise_t(), promise_t(), promise_t()]

contains

  !> What is promised of a scene: of its last step, or of the loop of a whole drive.
  pure function promises_of(scene) result(list)
    type(scene_t), intent(in) :: scene  !< scene
    type(promise_t) :: list(promises)
    list = of_contact
    if (scene%support%loop) list = of_drive
  end function promises_of

  !> Which promises a scene wants: the refinement goes on until these are within the tolerance.
  function wanted_of(scene) result(wanted)
    type(scene_t), intent(in) :: scene  !< scene
    logical :: wanted(promises)
    type(promise_t) :: list(promises)
    integer :: i
    list = promises_of(scene)
    wanted = list%usual
    if (len_trim(scene%wanted) == 0) return
    do i = 1, promises
      wanted(i) = list(i)%last > 0 .and. index(' '//trim(scene%wanted)//' ', ' '//trim(list(i)%name)//' ') > 0
    end do
  end function wanted_of

  !> Columns of all promises, their names, words or units, parted by commas.
  pure function promise_names(part) result(text)
    character(len=*), intent(in) :: part  !< columns, names, words or units
    character(len=:), allocatable :: text
    type(promise_t) :: list(2*promises)
    integer :: i
    list = [of_contact, of_drive]
    text = ''
    do i = 1, size(list)
      if (list(i)%last == 0) cycle
      select case (part)
      case ('columns'); text = text//','//trim(list(i)%column)
      case ('names'); text = text//','//trim(list(i)%name)
      case ('words'); text = text//','//trim(list(i)%words)
      case ('units'); text = text//','//trim(list(i)%unit)
      end select
    end do
    text = text(2:)
  end function promise_names

  !> These of the `values` are a field, whose error is that of its norm, and which may be 0 here and there.
  elemental logical function is_field(i)
    integer, intent(in) :: i  !< number among the values
    is_field = i >= of_contact(promises)%first
  end function is_field

  !> Values of a run with twice the load steps, K_TS of every second one, beside those of a run with half as many.
  pure function every_second(scene, value) result(q)
    type(scene_t), intent(in) :: scene         !< scene
    real(dp), intent(in) :: value(values)      !< with twice the load steps
    real(dp) :: q(values)
    integer, parameter :: first = of_contact(k_of_steps)%first, last = of_contact(k_of_steps)%last
    q = value
    if (scene%support%loop) return
    q(first:last) = 0
    q(first:first + most_steps/2) = value(first:last:2)
  end function every_second

  !> Their values; 0 where a scene has none: no tangent with bonded faces, no rotation without a torque, no pressure where the
  !> middle of the band is open, no K3 of a loop that ends at T2, no hysteresis of one that does not come back. Nothing is promised
  !> of these.
  pure function promised_values(scene, sums, tangents, pressures, loop) result(q)
    type(scene_t), intent(in) :: scene             !< scene
    type(sums_t), intent(in) :: sums               !< of its last step
    real(dp), intent(in) :: tangents(0:)           !< K_TS after the assembly and in the torque steps (0:most_steps) [N m/rad]
    real(dp), intent(in) :: pressures(:)           !< of the patches in the last step (patches) [Pa]
    type(loop_t), intent(in) :: loop               !< of a whole drive
    real(dp) :: q(values)                          !< in their units
    type(readings_t) :: readings
    q = 0
    if (scene%support%loop) then
      readings = read_loop(loop, scene)
      q(:4) = [readings%k, readings%hysteresis]
    else if (.not. scene%support%contact) then  ! bonded: no contact
      q(2) = sums%rotation
      q(5) = sums%over_rotation
    else
      q = [sums%k_tangent, sums%rotation, sums%normal_force, sums%pressure_middle, 0._dp, sums%pressure_middle_max, tangents, &
        pressures]
      if (.not. (scene%torque_steps > 0 .and. abs(scene%torque) > 0)) q(2) = 0
      if (scene%bonded()) q([4, 6]) = 0
    end if
    where (.not. abs(q) > 0) q = 0  ! not a number
  end function promised_values

  !> Errors of promises over their values: of several numbers the largest, of a field the norm. What has no value counts as exact.
  pure function relative(scene, error, value) result(r)
    type(scene_t), intent(in) :: scene         !< scene
    real(dp), intent(in) :: error(values)      !< in the units of the values
    real(dp), intent(in) :: value(values)      !< 0: none
    real(dp) :: r(promises)
    type(promise_t) :: list(promises)
    integer :: i
    list = promises_of(scene)
    r = 0
    do i = 1, promises
      associate (e => error(list(i)%first:list(i)%last), v => value(list(i)%first:list(i)%last))
        if (.not. any(abs(v) > 0)) cycle
        if (is_field(list(i)%first)) then
          r(i) = norm2(e)/norm2(v)
        else
          r(i) = maxval(abs(e)/max(abs(v), tiny(1._dp)), mask=abs(v) > 0)
        end if
      end associate
    end do
  end function relative

  !> A promise with its value, or the smallest and the largest; empty if it has none.
  pure function promise_text(promise, value) result(text)
    type(promise_t), intent(in) :: promise   !< one of them
    real(dp), intent(in) :: value(values)    !< of all, 0: none
    character(len=:), allocatable :: text
    text = ''
    associate (v => value(promise%first:promise%last))
      if (.not. any(abs(v) > 0)) return
      text = trim(promise%words)//' '//rounded(minval(v, mask=abs(v) > 0))
      if (size(v) > 1) text = text//' to '//rounded(maxval(v))
      text = text//' '//trim(promise%unit)
    end associate
  end function promise_text
end module hd_promises
