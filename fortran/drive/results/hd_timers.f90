! SPDX-License-Identifier: GPL-3.0-or-later
!> Where the time of a run goes: every part gets what has passed since the last mark, so that the parts add up to the whole.
module hd_timers
  use hd_kinds, only: dp
  use hd_clock, only: wall_seconds
  use hd_json, only: json_t
  implicit none
  private
  public :: timers_t, add_timers
  public :: in_plan, in_setup, in_coarser, in_newton, in_turn, in_stiffness, in_fields, in_stress, in_output, in_checkpoint, &
    in_turning, in_band, in_gradient, outside

  enum, bind(c)
    enumerator :: in_plan = 1, in_setup, in_coarser, in_newton, in_turn, in_stiffness, in_fields, in_stress, in_output, &
      in_checkpoint, in_turning, in_band, in_gradient, outside
  end enum
  character(len=10), parameter :: names(14) = [character(len=10) :: 'plan', 'setup', 'coarser', 'newton', 'turn', 'stiffness', &
    'fields', 'stress', 'output', 'checkpoint', 'turning', 'band', 'gradient', 'outside']

  type :: timers_t
    real(dp) :: seconds(size(names)) = 0     !< wall clock by part [s]
    real(dp), private :: mark = 0            !< clock up to which time is booked [s]
  contains
    procedure :: begin
    procedure :: book
  end type timers_t

contains

  !> Begin at a clock.
  subroutine begin(self, clock)
    class(timers_t), intent(out) :: self  !< nothing booked
    real(dp), intent(in) :: clock         !< [s]
    self%mark = clock
  end subroutine begin

  !> The time since the last mark went into a part.
  subroutine book(self, part)
    class(timers_t), intent(inout) :: self  !< timers
    integer, intent(in) :: part             !< one of the list
    real(dp) :: now
    now = wall_seconds()
    self%seconds(part) = self%seconds(part) + now - self%mark
    self%mark = now
  end subroutine book

  !> The block of the summary: all parts that every run has, others that took time, and their sum.
  subroutine add_timers(json, timers)
    type(json_t), intent(inout) :: json     !< document
    type(timers_t), intent(in) :: timers    !< times
    integer :: i
    call json%begin('timers_s')
    do i = 1, size(names)
      if (.not. (timers%seconds(i) > 0 .or. any(i == [in_setup, in_newton, in_stiffness, in_output]))) cycle
      call json%add(trim(names(i)), timers%seconds(i))
    end do
    call json%add('total', sum(timers%seconds))
    call json%finish()
  end subroutine add_timers
end module hd_timers
