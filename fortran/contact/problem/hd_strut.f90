! SPDX-License-Identifier: GPL-3.0-or-later
!> Struts are unilateral springs between points of the bodies and rigid surroundings, F = K max(0, closing)^power: Hertzian contacts
!> of small bodies (power 3/2), elastic stops (power 1). What they stand on may give way under all their forces together (`give`, a
!> symmetric compliance between struts of power 1).
module hd_strut
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_lapack, only: solve_dense
  implicit none
  private
  public :: strut_t, placing_t, absent, closing_of, strut_force, strut_tangent, strut_energy, push, answers, give_way

  real(dp), parameter :: absent = -huge(1._dp)  !< offset of a strut that is not there yet

  !> One strut. Its closing is sum weight u + offset, with the offset of the load; it pushes its nodes by -F weight.
  type :: strut_t
    integer, allocatable :: node(:)          !< nodes, in the numbering of the problem
    real(dp), allocatable :: weight(:, :)    !< in their dofs (3, nodes)
    real(dp) :: rate = 0                     !< K [N/m^power]
    real(dp) :: power = 1                    !< exponent
    logical :: pulls = .false.               !< a stay, which pulls too, F = K closing; whoever makes struts sets it too, for
                                             !< gfortran 12 leaves arrays that a function returns without what stands here
  end type strut_t

  !> How some struts of a problem are placed anew as the bodies move under them.
  type, abstract :: placing_t
    integer, allocatable :: struts(:)        !< their numbers
  contains
    procedure(place_strut), deferred :: place
    procedure(foot_of_strut), deferred :: foot
  end type placing_t

  abstract interface
    !> Nodes and weights of a strut, and what its closing has beside the displacements so weighted.
    pure subroutine place_strut(self, i, strut, shift, u)
      import :: dp, placing_t, strut_t
      class(placing_t), intent(in) :: self           !< placing
      integer, intent(in) :: i                       !< place in the list of numbers
      type(strut_t), intent(inout) :: strut          !< gets node, weight
      real(dp), intent(out) :: shift                 !< [m]
      real(dp), intent(in), optional :: u(:, :)      !< displacements (3, n), if they may be large [m]
    end subroutine place_strut

    !> Angle at rest of the point that a strut has come to press on [rad].
    pure real(dp) function foot_of_strut(self, i, u)
      import :: dp, placing_t
      class(placing_t), intent(in) :: self           !< placing
      integer, intent(in) :: i                       !< place in the list of numbers
      real(dp), intent(in) :: u(:, :)                !< displacements (3, n) [m]
    end function foot_of_strut
  end interface

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
    if (strut%pulls) f = strut%rate*closing
  end function strut_force

  !> Its derivative [N/m].
  elemental real(dp) function strut_tangent(strut, closing) result(k)
    type(strut_t), intent(in) :: strut    !< strut
    real(dp), intent(in) :: closing       !< [m]
    k = 0
    if (closing > 0) k = strut%power*strut%rate*closing**(strut%power - 1)
    if (strut%pulls) k = strut%rate
  end function strut_tangent

  !> Energy stored at a closing [J].
  elemental real(dp) function strut_energy(strut, closing) result(e)
    type(strut_t), intent(in) :: strut    !< strut
    real(dp), intent(in) :: closing       !< [m]
    e = 0
    if (closing > 0) e = strut%rate*closing**(strut%power + 1)/(strut%power + 1)
    if (strut%pulls) e = strut%rate*closing**2/2
  end function strut_energy

  !> Forces of struts with given tangents under closings, all of them linear; what they stand on gives way [N].
  function answers(rate, give, closing) result(force)
    real(dp), intent(in) :: rate(:)       !< tangents, 0: does not push (struts) [N/m]
    real(dp), intent(in) :: give(:, :)    !< (struts, struts) [m/N]
    real(dp), intent(in) :: closing(:)    !< (struts) [m]
    real(dp) :: force(size(rate))
    type(error_t), allocatable :: error   ! never: the matrix is positive definite
    real(dp), allocatable :: a(:, :), b(:, :)
    integer, allocatable :: list(:)
    integer :: i
    list = pack([(i, i=1, size(rate))], rate > 0)
    a = give(list, list)
    do i = 1, size(list)
      a(i, i) = a(i, i) + 1/rate(list(i))
    end do
    b = reshape(closing(list), [size(list), 1])
    call solve_dense(a, b, error)
    force = 0
    force(list) = b(:, 1)
  end function answers

  !> Closings left where what the struts stand on has given way: Newton's method on the set of struts that push.
  subroutine give_way(rate, give, closing)
    real(dp), intent(in) :: rate(:)           !< K (struts) [N/m]
    real(dp), intent(in) :: give(:, :)        !< (struts, struts), 0 for struts of another power [m/N]
    real(dp), intent(inout) :: closing(:)     !< (struts) [m]
    integer, parameter :: most = 100
    real(dp) :: left(size(rate))
    logical, dimension(size(rate)) :: yields, pushes, before
    integer :: i
    yields = [(give(i, i) > 0, i=1, size(rate))]
    pushes = yields .and. closing > 0
    do i = 1, most
      left = closing - matmul(give, answers(merge(rate, 0._dp, pushes), give, closing))
      before = pushes
      pushes = yields .and. left > 0
      if (all(pushes .eqv. before)) exit
    end do
    where (yields .and. closing > absent) closing = left
  end subroutine give_way

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
