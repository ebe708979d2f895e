! SPDX-License-Identifier: GPL-3.0-or-later
!> Balls on the deformed face of a ring.
module test_ball_patch
  use hd_ball_patch, only: ball_patch_t
  use hd_check, only: check_close
  use hd_kinds, only: dp, pi
  use hd_strut, only: closing_of, strut_t
  implicit none
  private
  public :: run_ball_patch

  integer, parameter :: sectors = 60
  real(dp), parameter :: radius = 16e-3_dp, oval = 0.2e-3_dp   !< [m]
  real(dp), parameter :: lever = 1.66e-3_dp                    !< [m]

contains

  subroutine run_ball_patch()
    type(ball_patch_t) :: patch
    real(dp) :: u(3, 2*sectors), v(3, 2*sectors), closing(3), angle, d
    type(strut_t) :: ball
    integer :: i
    patch = new_patch()
    call along_the_axis(patch)
    do i = 1, size(patch%theta)
      u = moved(0.3_dp, 0._dp, 0._dp)
      call set(u, closing(1))
      call check_close(closing(1), 0._dp, 1e-17_dp, 'a ring turned by 0.3 rad under a ball neither presses on it')
      call check_close(moment(u), 0._dp, 1e-16_dp, 'nor is turned by it')
      call check_close(patch%foot(i, u), patch%theta(i) - 0.3_dp, 1e-14_dp, 'the ball lies where the ring has come to')
      d = 1e-4_dp
      u = moved(0._dp, d, 0._dp)
      angle = patch%theta(i)
      call set(u, closing(1))
      call check_close(closing(1), radius - d*cos(angle) - sqrt(radius**2 - (d*sin(angle))**2), 2e-3_dp*d, 'a ring moved aside')
      v = moved(0._dp, 0._dp, 1e-3_dp)
      u = moved(0.02_dp, d, oval)
      call set(u + 1e-4_dp*v, closing(3))
      call set(u - 1e-4_dp*v, closing(2))
      call set(u, closing(1))
      call check_close((closing(3) - closing(2))/2e-4_dp, closing_of(ball, v), 1e-6_dp*norm2(v), 'weights are the derivative')
    end do
  contains
    !> Place the ball; its closing, and its strut in `ball`.
    subroutine set(u, closing)
      real(dp), intent(in) :: u(:, :)
      real(dp), intent(out) :: closing
      call patch%place(i, ball, closing, u)
      closing = closing + closing_of(ball, u)
    end subroutine set

    !> Of a unit force of the ball about the axis.
    real(dp) function moment(u)
      real(dp), intent(in) :: u(:, :)
      integer :: k
      moment = 0
      do k = 1, size(ball%node)
        moment = moment + (radius + u(1, ball%node(k)))*ball%weight(2, k) - u(2, ball%node(k))*ball%weight(1, k)
      end do
    end function moment
  end subroutine run_ball_patch

  !> A ring whose section turns, or that moves along the axis, moves the grooves' centres along it as a rigid body does; one that
  !> turns about the axis or grows does not, and the weights are the derivative.
  subroutine along_the_axis(patch)
    type(ball_patch_t), intent(in) :: patch
    real(dp), parameter :: phi = 1e-3_dp, far = 0.3e-3_dp
    type(strut_t) :: way
    real(dp) :: u(3, 2*sectors), v(3, 2*sectors), shift, low, high
    integer :: i, k
    do i = 4, 6
      u = moved(0._dp, 0._dp, 0._dp)
      do k = 1, 2
        u(1, k::2) = -phi*(2e-3_dp*(k - 1) - far)
        u(3, k::2) = phi*radius + 2e-6_dp
      end do
      call patch%place(i, way, shift)
      call check_close(shift + closing_of(way, u), phi*(radius - lever) + 2e-6_dp, 1e-15_dp, 'a ring whose section turns')
      call patch%place(i, way, shift, u)
      call check_close(shift + closing_of(way, u), phi*(radius - lever) + 2e-6_dp, 1e-15_dp, 'the same under large displacements')
      u = moved(0.3_dp, 0._dp, 0._dp)
      call patch%place(i, way, shift, u)
      call check_close(shift + closing_of(way, u), 0._dp, 1e-17_dp, 'a ring that turns about the axis')
      call check_close(patch%foot(i, u), patch%theta(i - 3) - 0.3_dp, 1e-14_dp, 'comes to lie under its ball')
      u = moved(0.02_dp, 1e-4_dp, oval)
      v = 0
      v(1, 2::2) = 1
      v(3, 1::2) = 0.5_dp
      call patch%place(i, way, shift, u + 1e-7_dp*v)
      high = shift + closing_of(way, u + 1e-7_dp*v)
      call patch%place(i, way, shift, u - 1e-7_dp*v)
      low = shift + closing_of(way, u - 1e-7_dp*v)
      call patch%place(i, way, shift, u)
      call check_close((high - low)/2e-7_dp, closing_of(way, v), 1e-4_dp, 'weights of an axial way are its derivative')
    end do
  end subroutine along_the_axis

  !> Three balls on a face of one row.
  function new_patch() result(patch)
    type(ball_patch_t) :: patch
    integer :: s
    patch%sectors = sectors
    patch%radius = radius
    patch%z = 1e-3_dp
    patch%angle = 0.07_dp
    patch%width = 1e-3_dp
    patch%theta = [0.013_dp, 1.9_dp, 5.1_dp]
    patch%lever = lever
    allocate (patch%face%nodes(4, sectors), patch%face%chart(2, 4, sectors))
    do s = 1, sectors
      patch%face%nodes(:, s) = [2*s - 1, 2*modulo(s, sectors) + 1, 2*modulo(s, sectors) + 2, 2*s]
      patch%face%chart(1, :, s) = 2*pi*radius/sectors*[s - 1, s, s, s - 1]
      patch%face%chart(2, :, s) = [0._dp, 0._dp, 2e-3_dp, 2e-3_dp]
    end do
  end function new_patch

  !> Displacements of a ring that is made oval, turned, and moved along x.
  pure function moved(turn, aside, oval) result(u)
    real(dp), intent(in) :: turn, aside, oval   !< [rad], [m], [m]
    real(dp) :: u(3, 2*sectors), theta, r
    integer :: i
    do i = 1, 2*sectors
      theta = 2*pi*((i - 1)/2)/sectors
      r = radius + oval*cos(2*theta)
      u(:, i) = [r*cos(turn) - radius + aside*cos(theta), r*sin(turn) - aside*sin(theta), 0._dp]
    end do
  end function moved
end module test_ball_patch
