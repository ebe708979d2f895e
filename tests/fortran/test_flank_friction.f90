! SPDX-License-Identifier: GPL-3.0-or-later
!> Friction of flanks.
module test_flank_friction
  use hd_kinds, only: dp, pi
  use hd_check, only: check, check_close
  use hd_flank_friction, only: rub_t, rub, remembered, strut_laws, give_way_rubbing, memories
  use hd_strut, only: strut_t, absent
  implicit none
  private
  public :: run_flank_friction

  real(dp), parameter :: mu = 0.12_dp, k_n = 1.25e8_dp, k_t = 1e8_dp, f = 100, x = 4e-7_dp

contains

  subroutine run_flank_friction()
    call cycle_under_load()
    call closing_and_opening()
    call derivatives()
    call energy()
    call elastic_ground()
  end subroutine run_flank_friction

  !> Move a companion and its flank evenly in so many steps, and let them remember.
  subroutine go(closing, way, steps, memory)
    real(dp), intent(in) :: closing, way             !< where to [m]
    integer, intent(in) :: steps                     !< number
    real(dp), intent(inout) :: memory(memories)      !< of the companion
    real(dp) :: begun(memories), c, w, force, rate, lean
    logical :: slides
    integer :: i
    begun = memory
    do i = 1, steps
      c = begun(1) + i*(closing - begun(1))/steps
      w = begun(2) + i*(way - begun(2))/steps
      call rub(mu, k_n, k_t, c, w, memory(1), memory(2), memory(3), force, rate, lean, slides)
      memory = remembered(mu, k_n, k_t, c, w, force, memory)
    end do
  end subroutine go

  !> Under a constant normal force F a way between X and -X drives T round a parallelogram of area 4 mu F (X - mu F/k_t), in one
  !> step per leg or in many; while the way stays below mu F/k_t nothing is lost and T is that of the spring.
  subroutine cycle_under_load()
    real(dp) :: memory(memories), before
    integer :: legs
    memory = [f/k_n, 0._dp, 0._dp, 0._dp]
    call go(f/k_n, 0.9_dp*mu*f/k_t, 3, memory)
    call check_close(memory(3), 0.9_dp*mu*f, 1e-12_dp*f, 'a flank that sticks is a spring')
    call check(.not. abs(memory(4)) > 0, 'a flank that sticks loses nothing')
    do legs = 1, 20, 19
      call go(f/k_n, x, legs, memory)
      before = memory(4)
      call go(f/k_n, -x, legs, memory)
      call check_close(memory(3), -mu*f, 1e-12_dp*f, 'a flank that slides bears mu F against its way')
      call go(f/k_n, x, legs, memory)
      call check_close(memory(4) - before, 4*mu*f*(x - mu*f/k_t), 1e-10_dp*f*x, 'work of a cycle')
    end do
  end subroutine cycle_under_load

  !> A flank that closes while it moves evenly has the spring from where it touches: in one step as in many, sticking or sliding. It
  !> gives all of it up where it opens, and closes again without a memory.
  subroutine closing_and_opening()
    real(dp) :: one(memories), many(memories), way(2)
    integer :: i
    way = [0.5_dp, 3._dp]*mu*f/k_t
    do i = 1, 2
      one = [-f/k_n, 0._dp, 0._dp, 0._dp]
      many = one
      call go(f/k_n, 2*way(i), 1, one)
      call go(f/k_n, 2*way(i), 40, many)
      call check_close(one(3), min(mu*f, k_t*way(i)), 1e-12_dp*f, 'friction of a flank that closes')
      call check(maxval(abs(one - many)) < 1e-9_dp*f, 'one step or many')
      call check_close(one(4), merge(0._dp, (1 - 1/3._dp)*mu*f*way(i)/2, i == 1), 1e-10_dp*f*x, 'its work')
      call go(-f/k_n, way(i), 1, one)
      call check(.not. abs(one(3)) > 0, 'an open flank does not rub')
      call go(f/k_n, way(i), 1, one)
      call check(.not. abs(one(3)) > 0, 'and forgets')
    end do
  end subroutine closing_and_opening

  !> The derivatives are those of differences, where a flank sticks, slides either way, closes or stays open.
  subroutine derivatives()
    real(dp), parameter :: h = 1e-12_dp
    real(dp) :: past(3, 5), at(2, 5), force, rate, lean, plus, minus, skip, leave
    logical :: slides, expected(5)
    integer :: i
    past = reshape([f/k_n, 0._dp, 0.5_dp*mu*f, f/k_n, 0._dp, 0._dp, f/k_n, 0._dp, 0._dp, -f/k_n, 0._dp, 0._dp, &
      f/k_n, 0._dp, 3._dp], [3, 5])
    at = reshape([1.1_dp*f/k_n, 1e-8_dp, 0.9_dp*f/k_n, x, 1.2_dp*f/k_n, -x, 0.7_dp*f/k_n, 3e-8_dp, -f/k_n, x], [2, 5])
    expected = [.false., .true., .true., .false., .false.]
    do i = 1, 5
      call rub(mu, k_n, k_t, at(1, i), at(2, i), past(1, i), past(2, i), past(3, i), force, rate, lean, slides)
      call check(slides .eqv. expected(i), 'whether a flank slides')
      call rub(mu, k_n, k_t, at(1, i), at(2, i) + h, past(1, i), past(2, i), past(3, i), plus, skip, leave, slides)
      call rub(mu, k_n, k_t, at(1, i), at(2, i) - h, past(1, i), past(2, i), past(3, i), minus, skip, leave, slides)
      call check_close((plus - minus)/(2*h), merge(0._dp, rate, slides), 1e-4_dp*k_t, 'derivative by the way')
      call rub(mu, k_n, k_t, at(1, i) + h, at(2, i), past(1, i), past(2, i), past(3, i), plus, skip, leave, slides)
      call rub(mu, k_n, k_t, at(1, i) - h, at(2, i), past(1, i), past(2, i), past(3, i), minus, skip, leave, slides)
      call check_close((plus - minus)/(2*h*k_n), lean, 1e-4_dp, 'derivative by the normal force')
    end do
  end subroutine derivatives

  !> Over a long path that closes, opens, sticks and slides the work of T is what the spring holds and what is lost.
  subroutine energy()
    integer, parameter :: steps = 20000
    real(dp) :: memory(memories), before(memories), work, t
    integer :: i
    memory = [-0.2_dp*f/k_n, 0._dp, 0._dp, 0._dp]
    work = 0
    do i = 1, steps
      t = 40*pi*i/steps
      before = memory
      call go(f/k_n*(0.8_dp*sin(1.7_dp*t) + 0.3_dp), x*(sin(t) + 0.3_dp*sin(3.1_dp*t)), 1, memory)
      work = work + (memory(3) + before(3))/2*(memory(2) - before(2))
    end do
    call check_close(work, memory(3)**2/(2*k_t) + memory(4), 1e-4_dp*work, 'work of friction')
    call check(memory(4) > 10*mu*f*x, 'it is lost')
  end subroutine energy

  !> On a ground that gives way under all forces together, what is left of the closings makes the forces that take the rest, whether
  !> companions stick or slide and flanks touch, close or are not there.
  subroutine elastic_ground()
    type(strut_t) :: struts(7)
    type(rub_t) :: law
    real(dp) :: give(7, 7), closing(7), left(7), past(memories, 3), force(7), rate(7), lean(3)
    logical :: slides(3)
    integer :: i, j
    struts%rate = [1e9_dp, k_n, k_n, k_n, k_t, k_t, k_t]
    struts%power = [1.5_dp, (1._dp, i=1, 6)]
    law = rub_t(mu, [2, 3, 4], [0._dp, 0._dp, 0._dp], [.false., .false., .false.])
    give = 0
    do i = 2, 7
      give(2:, i) = 1e-9_dp*exp(-abs([(real(i - j, dp), j=2, 7)])/3)
    end do
    past = 0
    past(:3, 1) = [8e-7_dp, 1e-8_dp, 2._dp]
    past(1, 2) = -1e-7_dp
    past(1, 3) = absent
    closing = [1e-6_dp, 1e-6_dp, 9e-7_dp, absent, 6e-8_dp, 3e-7_dp, 1e-7_dp]
    left = closing
    call give_way_rubbing(struts, law, past, give, left)
    call strut_laws(struts, law, past, left, force, rate, lean, slides)
    call check(slides(2) .and. .not. slides(1) .and. abs(force(5)) > 0, 'one companion sticks, one slides')
    call check(maxval(abs(left + matmul(give, force) - closing), mask=closing > -1) < 1e-17_dp, 'the ground gives way')
    call check(.not. abs(force(7)) > 0 .and. .not. abs(left(1) - closing(1)) > 0, 'an absent flank does not rub, balls stay')
  end subroutine elastic_ground
end module test_flank_friction
