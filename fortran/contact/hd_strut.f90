! SPDX-License-Identifier: GPL-3.0-or-later
!> Struts are unilateral springs between points of the bodies and rigid surroundings, F = K max(0, closing)^power. A ball between
!> cam and ring (power 3/2) and a flank of a tooth against the rigid circular spline (power 1) are struts.
module hd_strut
  use hd_kinds, only: dp
  implicit none
  private
  public :: strut_t, absent, closing_of, strut_force, strut_tangent, strut_energy, push

  real(dp), parameter :: absent = -huge(1._dp)  !< offset of a strut that is not there yet

  !> One strut. Its closing is sum weight u + offset, with the offset of the load; it pushes its nodes by -F weight.
  type :: strut_t
    integer, allocatable :: node(:)          !< nodes, in the numbering of the problem
    real(dp), allocatable :: weight(:, :)    !< in their dofs (3, nodes)
    real(dp) :: rate = 0                     !< K [N/m^power]
    real(dp) :: power = 1                    !< exponent
  end type strut_t

contains

  !> Part of the closing that displacements make [m].
  pure real(dp) function closing_of(strut, u) result(c)
    type(strut_t), intent(in) :: strut  !< strut
    real(dp), intent(in) :: u(:, :)     !< displacements (3, n) [m]
    integer :: i
    c = 0
    do i = 1, size(strut%node)
      c = c + dot_product(strut%weight(:, i), u(:, strut%node(i)))
    end do
  end function closing_of

  !> Force at a closing [N].
  elemental real(dp) function strut_force(strut, closing) result(f)
    type(strut_t), intent(in) :: strut    !< strut
    real(dp), intent(in) :: closing       !< [m]
    f = 0
    if (closing > 0) f = strut%rate*closing**strut%power
  end function strut_force

  !> Its derivative [N/m].
  elemental real(dp) function strut_tangent(strut, closing) result(k)
    type(strut_t), intent(in) :: strut    !< strut
    real(dp), intent(in) :: closing       !< [m]
    k = 0
    if (closing > 0) k = strut%power*strut%rate*closing**(strut%power - 1)
  end function strut_tangent

  !> Energy stored at a closing [J].
  elemental real(dp) function strut_energy(strut, closing) result(e)
    type(strut_t), intent(in) :: strut    !< strut
    real(dp), intent(in) :: closing       !< [m]
    e = 0
    if (closing > 0) e = strut%rate*closing**(strut%power + 1)/(strut%power + 1)
  end function strut_energy

  !> Add an amount of the strut's weights to a nodal field.
  pure subroutine push(strut, amount, f)
    type(strut_t), intent(in) :: strut     !< strut
    real(dp), intent(in) :: amount         !< [N]
    real(dp), intent(inout) :: f(:, :)     !< nodal forces (3, n) [N]
    integer :: i
    do i = 1, size(strut%node)
      f(:, strut%node(i)) = f(:, strut%node(i)) + amount*strut%weight(:, i)
    end do
  end subroutine push
end module hd_strut
