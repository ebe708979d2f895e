! SPDX-License-Identifier: GPL-3.0-or-later
!> The way of a run: position 0 to 1 is the assembly, 1 to 2 the torque, a ramp or one torque after the other.
module hd_load_path
  use hd_kinds, only: dp
  use hd_scene, only: scene_t
  implicit none
  private
  public :: torque_at, torque_load_steps, turns_back, largest_torque

contains

  !> Torques at which the ramps end; the first begins at 0 [N m].
  pure function ends_of(scene) result(ends)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), allocatable :: ends(:)
    ends = [scene%torque]
    if (scene%support /= 'drive') return
    ends = scene%torques(:scene%torque_count)
    if (size(ends) == 1 .and. .not. abs(ends(1)) > 0) ends = [scene%torque, 0._dp, -scene%torque, 0._dp]
  end function ends_of

  !> Load steps of the torque.
  pure integer function torque_load_steps(scene) result(n)
    type(scene_t), intent(in) :: scene  !< scene
    n = scene%torque_steps*size(ends_of(scene))
  end function torque_load_steps

  !> Torque at a position [N m].
  pure real(dp) function torque_at(scene, position) result(torque)
    type(scene_t), intent(in) :: scene      !< scene
    real(dp), intent(in) :: position        !< 0 to 2
    real(dp), allocatable :: ends(:)
    real(dp) :: place
    integer :: leg
    torque = 0
    if (.not. position > 1) return
    ends = [0._dp, ends_of(scene)]
    place = (position - 1)*(size(ends) - 1)
    leg = min(floor(place + 1e-9_dp), size(ends) - 2)
    place = place - leg
    torque = (1 - place)*ends(leg + 1) + place*ends(leg + 2)
    if (abs(place) < 1e-9_dp) torque = ends(leg + 1)
    if (abs(place - 1) < 1e-9_dp) torque = ends(leg + 2)
  end function torque_at

  !> Between two positions the torque does not go on as it came: the steps before are no guide.
  pure logical function turns_back(scene, before, now, next)
    type(scene_t), intent(in) :: scene               !< scene
    real(dp), intent(in) :: before, now, next        !< positions
    turns_back = .not. (torque_at(scene, now) - torque_at(scene, before))*(torque_at(scene, next) - torque_at(scene, now)) > 0
  end function turns_back

  !> Largest amount of the torque [N m].
  pure real(dp) function largest_torque(scene) result(torque)
    type(scene_t), intent(in) :: scene  !< scene
    torque = maxval(abs(ends_of(scene)))
  end function largest_torque
end module hd_load_path
