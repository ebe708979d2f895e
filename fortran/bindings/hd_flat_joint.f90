! SPDX-License-Identifier: GPL-3.0-or-later
!> A joint and an asperity from the named list of their parameters, as Python hands it over, and back.
module hd_flat_joint
  use, intrinsic :: iso_c_binding, only: c_double
  use hd_asperity, only: asperity_t, new_asperity
  use hd_error, only: error_t
  use hd_joint, only: joint_t, new_joint
  use hd_named_values, only: joint_names, value_of
  implicit none
  private
  public :: flat_joint, flat_asperity, joint_value

contains

  !> Joint from its parameters.
  subroutine flat_joint(p, joint, error)
    real(c_double), intent(in) :: p(:)                !< in the order of joint_names
    type(joint_t), intent(out) :: joint               !< joint
    type(error_t), allocatable, intent(out) :: error  !< parameter out of range
    call new_joint(flat_asperity(p), joint_value(p, 'fractal_dimension'), joint_value(p, 'friction'), joint_value(p, 's_min'), &
      joint_value(p, 'reference_area'), joint_value(p, 'asperity_radius'), joint_value(p, 'paper') > 0, &
      joint_value(p, 'plastic') > 0, joint, error)
  end subroutine flat_joint

  !> One asperity of it.
  pure type(asperity_t) function flat_asperity(p) result(a)
    real(c_double), intent(in) :: p(:)                !< in the order of joint_names
    a = new_asperity(joint_value(p, 'e1'), joint_value(p, 'nu1'), joint_value(p, 'e2'), joint_value(p, 'nu2'), &
      joint_value(p, 'nu_soft'), joint_value(p, 'hardness'), joint_value(p, 'fractal_dimension'), joint_value(p, 'roughness'), &
      joint_value(p, 'gamma'), joint_value(p, 'asperity_radius'))
  end function flat_asperity

  !> One parameter.
  pure real(c_double) function joint_value(p, name)
    real(c_double), intent(in) :: p(:)                !< in the order of joint_names
    character(len=*), intent(in) :: name              !< wanted
    joint_value = value_of(joint_names, p, name)
  end function joint_value
end module hd_flat_joint
