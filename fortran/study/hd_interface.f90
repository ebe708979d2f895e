! SPDX-License-Identifier: GPL-3.0-or-later
!> The rough joint as the interface law of a scene: closure and tangential stiffness per area, sampled over the pressure
!> and, for the law 'joint', over the shear.
module hd_interface
  use hd_kinds, only: dp
  use hd_closure_table, only: closure_table_t, new_closure_table
  use hd_error, only: error_t
  use hd_interface_law, only: interface_law_t, new_interface_law, closure_at
  use hd_joint, only: joint_t, response_t, evaluate_joint
  use hd_micro_slip, only: sampled_shares
  use hd_scene, only: scene_t
  implicit none
  private
  public :: scene_interface

  real(dp), parameter :: step = 0.2_dp      !< of ln p between samples
  real(dp), parameter :: lowest = 1e-3_dp   !< first sample, share of zero_pressure

contains

  !> Table of the joint of a scene, from a thousandth of `contact.zero_pressure` to the hardness.
  subroutine scene_interface(scene, joint, table, error)
    type(scene_t), intent(in) :: scene                !< scene
    type(joint_t), intent(in) :: joint                !< its joint
    type(closure_table_t), intent(out) :: table       !< table
    type(error_t), allocatable, intent(out) :: error  !< the joint gives no law
    type(interface_law_t) :: law
    type(response_t), allocatable :: response(:)
    real(dp), allocatable :: p(:), closure(:), k(:), share(:), tangential(:, :)
    real(dp) :: low
    integer :: i, n
    call new_interface_law(joint, scene%zero_pressure, law, error)
    if (allocated(error)) return
    low = lowest*scene%zero_pressure
    n = 1 + ceiling(log(joint%asperity%hardness/low)/step)
    p = [(low*exp(step*i), i=0, n - 1)]
    share = [0._dp]
    if (scene%contact_law == 'joint' .and. joint%mu > 0) share = sampled_shares()
    allocate (closure(n), k(n), response(n), tangential(size(share), n))
    call closure_at(law, p, closure, k)
    do i = 1, size(share)
      call evaluate_joint(joint, p, share(i)*joint%mu*p, 1._dp, response)
      tangential(i, :) = response%k_t
    end do
    where (.not. tangential(1, :) > 0) tangential(1, :) = k
    call new_closure_table(closure, p, k, tangential, table, error)
  end subroutine scene_interface
end module hd_interface
