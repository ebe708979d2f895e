! SPDX-License-Identifier: GPL-3.0-or-later
!> Balls in grooves.
module test_groove
  use hd_kinds, only: dp
  use hd_check, only: check, check_close
  use hd_groove, only: groove_t, groove_answers, groove_curvature, groove_energy, groove_forces, &
    groove_tangents
  use hd_hold, only: hold_t, hold_less, hold_more
  use hd_strut, only: strut_t
  implicit none
  private
  public :: run_groove

  real(dp), parameter :: rate = 1e10_dp, reach = 128e-6_dp   !< Hertz's [N/m^1.5]; [m]
  real(dp), parameter :: h = 1e-10_dp                        !< [m]

contains

  !> Ball 1 is struts 1 and 4, ball 2 struts 2 and 5; strut 3 is another.
  subroutine run_groove()
    type(groove_t) :: groove
    type(strut_t) :: struts(5)
    real(dp), dimension(5) :: at, force, low, high, tangent, none
    real(dp) :: slope(2, 2), e(2), g(2), was(2)
    type(hold_t), allocatable :: holds(:)
    integer :: i, k
    logical :: more
    groove = groove_t(2, 3, reach, [0._dp, 0._dp])
    struts%rate = rate
    struts%power = [1.5_dp, 1.5_dp, 1._dp, 1._dp, 1._dp]
    struts%pulls = [.false., .false., .false., .true., .true.]
    none = 7
    force = forces([3e-6_dp, 5e-6_dp, 0._dp, 0._dp, -40e-6_dp])
    call check_close(force(1), rate*3e-6_dp**1.5_dp, 1e-12_dp, 'a ball amid its grooves is that of Hertz')
    call check(.not. abs(force(4)) > 0, 'and does not push along the axis')
    call check_close(force(3), 7._dp, 1e-15_dp, 'other struts stay')
    call check_close(norm2(force([2, 5])), rate*(hypot(reach + 5e-6_dp, 40e-6_dp) - reach)**1.5_dp, 1e-11_dp, &
      'along the line of centres')
    call check_close(force(5)/force(2), -40/133._dp, 1e-14_dp, 'which is its direction')
    force = forces([-3e-6_dp, -3e-6_dp, 0._dp, 20e-6_dp, 30e-6_dp])
    call check(.not. any(abs(force([1, 4])) > 0) .and. force(2) > 0, 'a way along the axis closes a ball that was free')
    force = forces([-300e-6_dp, -500e-6_dp, 0._dp, 0._dp, 30e-6_dp])
    call check(.not. any(abs(force([1, 2, 4, 5])) > 0), 'a ring that stands off further than the centres lie apart is free')
    at = [3e-6_dp, -2e-6_dp, 0._dp, -15e-6_dp, 40e-6_dp]
    call groove_tangents(groove, struts, at, tangent)
    do i = 1, 2
      do k = 1, 2
        low = at
        high = at
        low(i + 3*(k - 1)) = low(i + 3*(k - 1)) - h
        high(i + 3*(k - 1)) = high(i + 3*(k - 1)) + h
        force = (forces(high) - forces(low))/(2*h)
        slope(:, k) = force([i, i + 3])
        none = 0
        none(i + 3*(k - 1)) = 1
        force = 0
        call groove_answers(groove, tangent, none, force)
        call check(all(abs(force([i, i + 3]) - slope(:, k)) < 1e-6_dp*maxval(abs(slope))), 'tangents are derivatives of the forces')
        e = [energy(low), energy(high)]
        none = forces(at)
        call check_close((e(2) - e(1))/(2*h), none(i + 3*(k - 1)), 1e-5_dp, 'forces are derivatives of the energy')
        g = groove_curvature(groove, struts(i), at(i), at(i + 3), [1._dp, 2._dp], [-1._dp, 0.5_dp])
        call check_close(work(high, i) - work(low, i), 2*h*g(k), 1e-5_dp*abs(work(at, i)), 'and the curvature that of the tangents')
      end do
    end do
    call groove_tangents(groove, struts, [-1e-6_dp, 1e-6_dp, 0._dp, 1e-6_dp, 0._dp], tangent)
    call check(.not. any(abs(tangent([1, 4])) > 0) .and. all(tangent([2, 5]) > 0), 'a free ball holds nothing')
    do i = 4, 5
      struts(i)%node = [1]
      struts(i)%weight = reshape([0._dp, 0._dp, 1._dp], [3, 1])
    end do
    at = [3e-6_dp, -5e-6_dp, 0._dp, 20e-6_dp, 0._dp]
    call groove_tangents(groove, struts, at, tangent)
    was = stiffness(tangent)
    holds = [hold_t([4, 5], reach/4, 1e5_dp)]
    call hold_more(holds, groove, struts, tangent, reshape([0._dp, 0._dp, 0.1_dp*reach], [3, 1]), more)
    call check(.not. more, 'a short correction is left as it is')
    call hold_more(holds, groove, struts, tangent, reshape([0._dp, 0._dp, -reach], [3, 1]), more)
    call check(more .and. holds(1)%rate > 0, 'a long one is made again with all balls holding the ring')
    call check(all(abs(stiffness(tangent) - was - [0._dp, holds(1)%rate]) < 1e-9_dp*maxval(abs(was))), 'along the axis alone')
    call check_close(tangent(5), holds(1)%rate, 1e-12_dp, 'a free one too')
    call groove_tangents(groove, struts, at, tangent)
    call hold_less(holds, groove, struts, tangent, reshape([0._dp, 0._dp, 1e-3_dp*reach], [3, 1]))
    call check(.not. holds(1)%rate > 0 .and. all(abs(stiffness(tangent) - was) < 1e-9_dp*maxval(abs(was))), &
      'until corrections are short')
    struts(3)%node = [1]
    struts(3)%weight = reshape([0._dp, 1._dp, 0._dp], [3, 1])
    holds = [hold_t([3], reach/4, 1e5_dp)]
    do i = 1, 6
      call hold_more(holds, struts=struts, rate=tangent, u=reshape([0._dp, reach, 0._dp], [3, 1]), more=more)
      if (.not. more) exit
    end do
    call check(i == 5, 'four corrections of a ring that turns far are made again, each with a stiffer hold')
    call check_close(tangent(3), 30**3*1e5_dp, 1e-12_dp*tangent(3), 'the last of all')
  contains
    !> Forces of the first ball by its tangents, for a way along the axis.
    function stiffness(tangent) result(f)
      real(dp), intent(in) :: tangent(5)
      real(dp) :: f(2), all_of(5)
      all_of = 0
      call groove_answers(groove, tangent, [0._dp, 0._dp, 0._dp, 1._dp, 0._dp], all_of)
      f = all_of([1, 4])
    end function stiffness

    function forces(at) result(f)
      real(dp), intent(in) :: at(5)
      real(dp) :: f(5)
      f = 7
      call groove_forces(groove, struts, at, f)
    end function forces

    !> What the balls store: what is left where their struts one by one have nothing.
    real(dp) function energy(at)
      real(dp), intent(in) :: at(5)
      type(strut_t) :: alone(5)
      alone = struts
      alone(4:)%rate = 0
      energy = groove_energy(groove, alone, at) + sum(0.4_dp*rate*max(0._dp, at(:2))**2.5_dp)
    end function energy

    !> a . dF . b
    real(dp) function work(at, i)
      real(dp), intent(in) :: at(5)
      integer, intent(in) :: i
      type(groove_t) :: now
      real(dp) :: t(5), f(5), b(5)
      now = groove
      call groove_tangents(now, struts, at, t)
      b = 0
      b([i, i + 3]) = [-1._dp, 0.5_dp]
      f = 0
      call groove_answers(now, t, b, f)
      work = f(i) + 2*f(i + 3)
    end function work
  end subroutine run_groove
end module test_groove
