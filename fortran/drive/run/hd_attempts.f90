! SPDX-License-Identifier: GPL-3.0-or-later
!> Attempts at load steps, as a trial of a plan made them: the run that takes over its mesh takes over what they came to, instead of
!> solving it a second time. Every bit, count and row of its history is then that of a run that solves them.
module hd_attempts
  use hd_kinds, only: dp
  use hd_checkpoint, only: flexibility_t
  use hd_load_path, only: place_t
  use hd_newton, only: iteration_t
  use hd_problem, only: state_t, move_state
  implicit none
  private
  public :: attempt_t, attempts_t

  !> An attempt to reach a place from another one.
  type :: attempt_t
    type(place_t) :: from, to
    logical :: solved = .false.                    !< reached
    logical :: sliding = .false.                   !< the contact slips as a whole,
    real(dp) :: slip_torque = 0                    !< and carries so much [N m]
    logical :: far = .false.                       !< bodies have moved far away
    type(state_t) :: state                         !< where it was reached: from which the run goes on
    type(iteration_t), allocatable :: history(:)   !< iterates
    integer :: inner = 0                           !< steps of inner iterations
    character(len=8) :: symmetry = ''              !< part that was solved
  end type attempt_t

  !> Tangent of a load step that was booked.
  type :: tangent_t
    integer :: step = 0                            !< its number
    type(flexibility_t) :: flexibility             !< with those of the steps before
    logical :: certain = .true.                    !< it is
  end type tangent_t

  !> Attempts one after the other.
  type :: attempts_t
    logical :: keeps = .false.                     !< further ones are to be added
    character(len=32) :: start = ''                !< mesh that gave the first guesses
    integer :: taken = 0                           !< so many have been taken over
    type(attempt_t), allocatable :: list(:)
    type(tangent_t), allocatable :: tangents(:)    !< of the steps that got one
  contains
    procedure :: add
    procedure :: take
    procedure :: add_tangent
    procedure :: take_tangent
    procedure :: left
    procedure :: hand_on
  end type attempts_t

contains

  !> Keep an attempt, where attempts are kept.
  subroutine add(self, attempt)
    class(attempts_t), intent(inout) :: self    !< grows
    type(attempt_t), intent(in) :: attempt      !< attempt
    type(attempt_t), allocatable :: longer(:)
    integer :: i, n
    if (.not. self%keeps) return
    n = 0
    if (allocated(self%list)) n = size(self%list)
    allocate (longer(n + 1))
    do i = 1, n
      call move(self%list(i), longer(i))
    end do
    longer(n + 1) = attempt
    call move_alloc(longer, self%list)
  end subroutine add

  !> Take over the next attempt, if it is that between two places; else none is taken over any more.
  subroutine take(self, from, to, attempt, found)
    class(attempts_t), intent(inout) :: self    !< attempts
    type(place_t), intent(in) :: from, to       !< places
    type(attempt_t), intent(inout) :: attempt   !< gets it
    logical, intent(out) :: found               !< there is one
    found = self%left()
    if (.not. found) return
    associate (next => self%list(self%taken + 1))
      found = same(next%from, from) .and. same(next%to, to)
      if (found) call move(next, attempt)
    end associate
    self%taken = self%taken + 1
    if (found) return
    deallocate (self%list)
    if (allocated(self%tangents)) deallocate (self%tangents)
  end subroutine take

  !> Keep the tangent of a load step, where attempts are kept.
  subroutine add_tangent(self, step, flexibility, certain)
    class(attempts_t), intent(inout) :: self         !< grows
    integer, intent(in) :: step                      !< its number
    type(flexibility_t), intent(in) :: flexibility   !< of the run after it
    logical, intent(in) :: certain                   !< it is
    if (.not. self%keeps) return
    if (.not. allocated(self%tangents)) allocate (self%tangents(0))
    self%tangents = [self%tangents, tangent_t(step, flexibility, certain)]
  end subroutine add_tangent

  !> Take over the tangent of a load step, if there is one.
  subroutine take_tangent(self, step, flexibility, certain, found)
    class(attempts_t), intent(in) :: self               !< attempts
    integer, intent(in) :: step                         !< its number
    type(flexibility_t), intent(inout) :: flexibility   !< gets it
    logical, intent(inout) :: certain                   !< the same
    logical, intent(out) :: found                       !< there is one
    integer :: i
    found = .false.
    if (.not. allocated(self%tangents) .or. self%keeps) return
    i = findloc(self%tangents%step, step, 1)
    found = i > 0
    if (.not. found) return
    flexibility = self%tangents(i)%flexibility
    certain = self%tangents(i)%certain
  end subroutine take_tangent

  !> There are attempts to be taken over.
  pure logical function left(self)
    class(attempts_t), intent(in) :: self  !< attempts
    left = .false.
    if (allocated(self%list) .and. .not. self%keeps) left = self%taken < size(self%list)
  end function left

  !> Give all of them to the next holder.
  subroutine hand_on(self, to)
    class(attempts_t), intent(inout) :: self   !< empty afterwards
    type(attempts_t), intent(inout) :: to      !< gets them
    to%keeps = self%keeps
    to%start = self%start
    to%taken = self%taken
    call move_alloc(self%list, to%list)
    call move_alloc(self%tangents, to%tangents)
  end subroutine hand_on

  !> Let an attempt become another's without a copy of its state.
  subroutine move(from, to)
    type(attempt_t), intent(inout) :: from   !< empty afterwards
    type(attempt_t), intent(inout) :: to     !< gets it
    type(state_t) :: state
    call move_state(from%state, state)
    to = from
    call move_state(state, to%state)
  end subroutine move

  !> Two places are one.
  pure logical function same(a, b)
    type(place_t), intent(in) :: a, b  !< places
    same = a%step == b%step .and. abs(a%share - b%share) <= 0
  end function same
end module hd_attempts
