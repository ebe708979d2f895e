! SPDX-License-Identifier: GPL-3.0-or-later
!> The way of a run: the load steps of the assembly, then those of the torque, a ramp or one torque after the other. Where a run
!> stands on it is a count of steps and a share of the next one.
module hd_load_path
  use hd_kinds, only: dp
  use hd_loop, only: first_sense, lost_at
  use hd_scene, only: scene_t
  implicit none
  private
  public :: place_t, operator(<), assembled, path_end, step_end, ahead, place_at, begins, under_torque, assembly_at, torque_at, &
    at_peak, load_factor_at, stretch, largest_torque

  real(dp), parameter :: close_by = 1e-4_dp    !< share of a ramp within which a step that is there will do
  real(dp), parameter :: whole = 1 - 1e-12_dp  !< share of a load step that is taken for all of it: shares are cut to 2^-max_cuts

  !> A place on the way.
  type :: place_t
    integer :: step = 0       !< load steps behind it, the assembly's first
    real(dp) :: share = 0     !< of the next one, 0 to below 1
  end type place_t

  interface operator(<)
    module procedure before
  end interface operator(<)

contains

  !> A place lies before another one.
  elemental logical function before(a, b)
    type(place_t), intent(in) :: a, b  !< places
    before = a%step < b%step .or. (a%step == b%step .and. a%share < b%share)
  end function before

  !> End of the assembly.
  pure type(place_t) function assembled(scene)
    type(scene_t), intent(in) :: scene  !< scene
    assembled = place_t(scene%assembly_steps, 0)
  end function assembled

  !> End of the way.
  pure type(place_t) function path_end(scene)
    type(scene_t), intent(in) :: scene  !< scene
    path_end = place_t(scene%assembly_steps + size(torques_of(scene)) - 1, 0)
  end function path_end

  !> End of the load step that is begun at a place.
  pure type(place_t) function step_end(place)
    type(place_t), intent(in) :: place  !< place
    step_end = place_t(place%step + 1, 0)
  end function step_end

  !> A place further on in the same load step, at its end at most.
  pure type(place_t) function ahead(place, part)
    type(place_t), intent(in) :: place  !< place
    real(dp), intent(in) :: part        !< of the load step
    ahead = place_t(place%step, place%share + part)
    if (ahead%share > whole) ahead = step_end(place)
  end function ahead

  !> Place of a torque on its one ramp.
  pure type(place_t) function place_at(scene, torque) result(place)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), intent(in) :: torque      !< amount [N m]
    real(dp) :: steps
    steps = scene%torque_steps*torque/abs(scene%torque)
    place = ahead(place_t(scene%assembly_steps + floor(steps), 0), steps - floor(steps))
  end function place_at

  !> The assembly or the torque begins here: there are no steps to extrapolate.
  pure logical function begins(scene, place)
    type(scene_t), intent(in) :: scene  !< scene
    type(place_t), intent(in) :: place  !< place
    begins = (place%step == 0 .or. place%step == scene%assembly_steps) .and. .not. place%share > 0
  end function begins

  !> A place lies beyond the assembly.
  pure logical function under_torque(scene, place)
    type(scene_t), intent(in) :: scene  !< scene
    type(place_t), intent(in) :: place  !< place
    under_torque = assembled(scene) < place
  end function under_torque

  !> Fraction of the assembly at a place, 0 to 1.
  pure real(dp) function assembly_at(scene, place) result(fraction)
    type(scene_t), intent(in) :: scene  !< scene
    type(place_t), intent(in) :: place  !< place
    fraction = 1
    if (place%step < scene%assembly_steps) fraction = (place%step + place%share)/scene%assembly_steps
  end function assembly_at

  !> Share of the assembly or of the torque's load steps at a place, 0 to 1.
  pure real(dp) function load_factor_at(scene, place) result(factor)
    type(scene_t), intent(in) :: scene  !< scene
    type(place_t), intent(in) :: place  !< place
    factor = assembly_at(scene, place)
    if (under_torque(scene, place)) factor = (place%step - scene%assembly_steps + place%share)/(size(torques_of(scene)) - 1)
  end function load_factor_at

  !> Torques at which the ramps end; the first begins at 0 [N m].
  pure function ends_of(scene) result(ends)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), allocatable :: ends(:)
    ends = [scene%torque]
    if (.not. scene%support%loop) return
    ends = scene%torques(:scene%torque_count)
    if (size(ends) == 1 .and. .not. abs(ends(1)) > 0) ends = [scene%torque, 0._dp, -scene%torque, &
      0._dp, scene%torque]
  end function ends_of

  !> Torques at the ends of the load steps, after 0: every ramp in as many equal ones. A loop also stops where it is read: at T1
  !> and T2 either way, in place of the steps next to them; for hysteresis and lost motion at no torque and at a share of the rated
  !> one either way, on its first ramp where no later ones pass that both ways [N m].
  pure function torques_of(scene) result(torque)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), allocatable :: torque(:), ends(:), ramp(:)
    real(dp) :: near, sense, stop_at
    integer :: i, j, k, first
    logical :: straight
    torque = [0._dp]
    if (scene%torque_steps == 0) return
    ends = [0._dp, ends_of(scene)]
    first = merge(1, 2, pass_both_ways(ends, lost_at*scene%rated_torque) .and. &
      .not. pass_both_ways(ends(2:), lost_at*scene%rated_torque))
    do i = 1, size(ends) - 1
      straight = scene%straight .and. i < size(ends) - 1
      associate (from => ends(i), to => ends(i + 1), n => merge(1, scene%torque_steps, straight))
        ramp = [(from + (to - from)*(real(k, dp)/n), k=0, n - 1), to]
        near = close_by*abs(to - from)
        sense = sign(1._dp, to - from)
        if (scene%support%loop .and. .not. straight) then
          do j = -1, 1, 2
            call stop_there(j*scene%torque_1, near, j*scene%torque_2, ramp)
            call stop_there(j*scene%torque_2, near, j*scene%torque_1, ramp)
          end do
        end if
        do j = -1, merge(1, -2, i >= first .and. near > 0 .and. .not. straight)
          stop_at = j*lost_at*scene%rated_torque
          k = count(sense*(ramp - stop_at) < 0)  ! ends of steps before it
          if (k > 0 .and. k < size(ramp) .and. minval(abs(ramp - stop_at)) > near) ramp = [ramp(:k), stop_at, ramp(k + 1:)]
        end do
        torque = [torque, ramp(2:)]
      end associate
    end do
  end function torques_of

  !> Move the end of the load step that is nearest to a torque inside of a ramp there, or put one there.
  pure subroutine stop_there(torque, near, other, ramp)
    real(dp), intent(in) :: torque, near               !< and what is as good [N m]
    real(dp), intent(in) :: other                      !< torque from which no end is moved [N m]
    real(dp), allocatable, intent(inout) :: ramp(:)    !< ends of steps, with the ramp's own [N m]
    integer :: k, n
    n = size(ramp)
    k = count(sign(1._dp, ramp(n) - ramp(1))*(ramp - torque) < 0)  ! ends before it
    if (k == 0 .or. k == n .or. minval(abs(ramp - torque)) <= near) return
    ramp = [ramp(:k), torque, ramp(k + 1:)]
    k = k + merge(-1, 1, abs(ramp(k) - torque) < abs(ramp(k + 2) - torque)) + 1
    if (k > 1 .and. k <= n .and. abs(ramp(k) - other) > near) ramp = [ramp(:k - 1), ramp(k + 1:)]
  end subroutine stop_there

  !> Ramps pass an amount of torque, of either sign, rising and falling.
  pure logical function pass_both_ways(ends, amount) result(pass)
    real(dp), intent(in) :: ends(:)  !< of the ramps, the first one's beginning before them [N m]
    real(dp), intent(in) :: amount   !< [N m]
    integer :: i, j, n
    n = size(ends)
    pass = all([((any(j*ends(:n - 1) < i*amount .and. i*amount <= j*ends(2:)), i=-1, 1, 2), j=-1, 1, 2)])
  end function pass_both_ways

  !> Torque at a place [N m].
  pure real(dp) function torque_at(scene, place) result(torque)
    type(scene_t), intent(in) :: scene      !< scene
    type(place_t), intent(in) :: place      !< place
    real(dp), allocatable :: ends(:)
    integer :: k
    torque = 0
    if (.not. under_torque(scene, place)) return
    ends = torques_of(scene)
    k = place%step - scene%assembly_steps + 1
    torque = ends(k)
    if (place%share > 0) torque = (1 - place%share)*ends(k) + place%share*ends(k + 1)
  end function torque_at

  !> The torque at the end of a load step is the largest of the way, in the sense of its first rise, and does not come again.
  pure logical function at_peak(scene, place) result(peak)
    type(scene_t), intent(in) :: scene  !< scene
    type(place_t), intent(in) :: place  !< end of a load step
    real(dp), parameter :: less = 1 - 1e-9_dp
    real(dp), allocatable :: torque(:)
    integer :: n
    n = place%step - scene%assembly_steps
    peak = n > 0
    if (.not. peak) return
    torque = torques_of(scene)
    torque = first_sense(torque)*torque(2:)
    peak = torque(n) > 0 .and. torque(n) >= less*maxval(torque) .and. .not. any(torque(n + 1:) >= less*maxval(torque))
  end function at_peak

  !> Length of the next part of the way over that of the last one, by which the last change of a state goes on; 0 where that is no
  !> guide: at the beginning, where the torque begins, and where it does not go on as it came.
  pure real(dp) function stretch(scene, last, now, next) result(ratio)
    type(scene_t), intent(in) :: scene            !< scene
    type(place_t), intent(in) :: last, now, next  !< ends of both parts
    ratio = 0
    if (.not. last < now) return
    if (last < assembled(scene)) then
      if (under_torque(scene, next)) return
      ratio = (assembly_at(scene, next) - assembly_at(scene, now))/(assembly_at(scene, now) - assembly_at(scene, last))
    else if (abs(torque_at(scene, now) - torque_at(scene, last)) > 0) then
      ratio = max(0._dp, (torque_at(scene, next) - torque_at(scene, now))/(torque_at(scene, now) - torque_at(scene, last)))
    end if
  end function stretch

  !> Largest amount of the torque [N m].
  pure real(dp) function largest_torque(scene) result(torque)
    type(scene_t), intent(in) :: scene  !< scene
    torque = maxval(abs(ends_of(scene)))
  end function largest_torque
end module hd_load_path
