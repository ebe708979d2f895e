! SPDX-License-Identifier: GPL-3.0-or-later
!> A joint and an asperity from the named list of their parameters, as Python hands it over.
module hd_joint_entry
  use, intrinsic :: iso_c_binding, only: c_double
  use hd_asperity, only: asperity_t, new_asperity
  use hd_error, only: error_t
  use hd_joint, only: joint_t, new_joint
  use hd_named_values, only: named_list_t
  implicit none
  private
  public :: flat_joint, flat_asperity

contains

  !> Joint from its parameters.
  subroutine flat_joint(p, joint, error)
    real(c_double), intent(in) :: p(:)                !< in the order of 'joint'
    type(joint_t), intent(out) :: joint               !< joint
    type(error_t), allocatable, intent(out) :: error  !< parameter out of range
    type(named_list_t) :: names
    type(asperity_t) :: a
    call flat_asperity(p, a, error)
    if (allocated(error)) return
    names%list = 'joint'
    call new_joint(a, names%take(p, 'fractal_dimension'), names%take(p, 'friction'), names%take(p, 's_min'), &
      names%take(p, 'reference_area'), names%take(p, 'asperity_radius'), names%take(p, 'paper') > 0, &
      names%take(p, 'plastic') > 0, joint, error)
    call names%check(error)
  end subroutine flat_joint

  !> One asperity of it.
  subroutine flat_asperity(p, a, error)
    real(c_double), intent(in) :: p(:)                !< in the order of 'joint'
    type(asperity_t), intent(out) :: a                !< asperity
    type(error_t), allocatable, intent(out) :: error  !< unknown name
    type(named_list_t) :: names
    names%list = 'joint'
    a = new_asperity(names%take(p, 'e1'), names%take(p, 'nu1'), names%take(p, 'e2'), names%take(p, 'nu2'), &
      names%take(p, 'nu_soft'), names%take(p, 'hardness'), names%take(p, 'fractal_dimension'), names%take(p, 'roughness'), &
      names%take(p, 'gamma'), names%take(p, 'asperity_radius'))
    call names%check(error)
  end subroutine flat_asperity
end module hd_joint_entry
