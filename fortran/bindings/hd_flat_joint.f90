! SPDX-License-Identifier: GPL-3.0-or-later
!> A joint from the flat list of its parameters, as Python hands it over.
module hd_flat_joint
  use, intrinsic :: iso_c_binding, only: c_double
  use hd_asperity, only: new_asperity
  use hd_error, only: error_t
  use hd_joint, only: joint_t, new_joint
  implicit none
  private
  public :: flat_joint

contains

  !> Joint from e1, nu1, e2, nu2, nu_soft, hardness, D, G, gamma, r_m, mu, s_min, A_0, 1 for the closure of the paper,
  !> 1 for plastic spots that unload elastically.
  subroutine flat_joint(p, joint, error)
    real(c_double), intent(in) :: p(15)               !< parameters
    type(joint_t), intent(out) :: joint               !< joint
    type(error_t), allocatable, intent(out) :: error  !< parameter out of range
    call new_joint(new_asperity(p(1), p(2), p(3), p(4), p(5), p(6), p(7), p(8), p(9), p(10)), p(7), p(11), p(12), p(13), &
      p(10), p(14) > 0, p(15) > 0, joint, error)
  end subroutine flat_joint
end module hd_flat_joint
