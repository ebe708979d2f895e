! SPDX-License-Identifier: GPL-3.0-or-later
!> What gives way where a drive's bottom turns under a further torque: bodies, balls, teeth, circular spline, and in the contact
!> gaps, slip and joint.
!>
!> Let u*, t* be displacements and tractions of the drive with its faces glued, u those of the drive as it stands, w the relative
!> displacements of its faces, all per unit of torque. The work of the one's forces on the way of the other, and its inverse, give
!>   turn = u* K u*  -  sum over points of  area t* w :
!> the first term, the glued drive's turn, is a sum over bodies, balls, teeth and spline, the second one what the contact adds.
!> No part is counted twice, and none is left. Friction of the flanks breaks the reciprocity of the second term: what the contact
!> adds is known all the same, and its parts share it out.
module hd_twist_shares
  use hd_kinds, only: dp
  use hd_coupled_tangent, only: answer_t
  use hd_drive, only: drive_t
  use hd_mortar, only: relative_displacement
  use hd_problem, only: elastic_forces, linear_forces
  use hd_rate_law, only: rate_open, rate_rigid, rate_slip
  use hd_strut, only: closing_of
  implicit none
  private
  public :: part_names, in_contact, twist_shares

  character(len=6), parameter :: part_names(8) = [character(len=6) :: 'cup', 'ring', 'balls', 'teeth', 'spline', &
    'gaps', 'slip', 'joint']
  integer, parameter :: in_contact = 6   !< first of the parts that lie in the contact

contains

  !> Shares of the parts, in the order of their names; their sum is 1.
  function twist_shares(drive, as_it_is, bonded) result(shares)
    type(drive_t), intent(in) :: drive            !< drive at the state of both answers
    type(answer_t), intent(in) :: as_it_is        !< with its joint
    type(answer_t), intent(in) :: bonded          !< with all faces glued
    real(dp) :: shares(size(part_names))
    real(dp) :: force(3, drive%problem%n), w(3, size(bonded%points)), work(3)
    real(dp), allocatable :: closing(:), push(:)
    integer :: b, j
    logical :: of_balls
    associate (problem => drive%problem, n => drive%balls)
      call elastic_forces(problem, bonded%du, force)
      do b = 1, 2
        associate (low => problem%first(b) + 1, high => problem%first(b) + problem%bodies(b)%nodes())
          shares(merge(1, 2, b == drive%b_cup)) = sum(force(:, low:high)*bonded%du(:, low:high))
        end associate
      end do
      closing = [(closing_of(problem%struts(j), bonded%du), j=1, size(problem%struts))]
      push = linear_forces(problem, closing)
      shares(3) = sum(problem%spring(1, drive%inner)*bonded%du(1, drive%inner)**2)  ! of springs that stand for them
      shares(2) = shares(2) - shares(3)
      shares(4:5) = 0
      do j = 1, size(push)
        of_balls = j <= n
        if (allocated(problem%groove)) of_balls = of_balls .or. (j > problem%groove%before .and. j <= problem%groove%before + n)
        shares(merge(3, 4, of_balls)) = shares(merge(3, 4, of_balls)) + push(j)*closing(j)
      end do
      if (allocated(problem%strut_give)) shares(5) = dot_product(push, matmul(problem%strut_give, push))
      shares(4) = shares(4) - shares(5)
      shares(6:) = 0
      w = relative_displacement(problem%mortar, as_it_is%du)
      do j = 1, size(bonded%points)
        work = -problem%mortar%area(j)*bonded%traction(:, j)*w(:, j)
        select case (as_it_is%points(j)%state)
        case (rate_open)
          shares(6) = shares(6) + sum(work)
        case (rate_rigid, rate_slip)
          shares(7) = shares(7) + sum(work(2:))
          shares(8) = shares(8) + work(1)
        case default
          shares(8) = shares(8) + sum(work)
        end select
      end do
      if (allocated(problem%rub) .and. abs(sum(shares(in_contact:))) > 0) shares(in_contact:) = shares(in_contact:)* &
        (as_it_is%flexibility - bonded%flexibility)/sum(shares(in_contact:))
    end associate
    shares = shares/sum(shares)
  end function twist_shares
end module hd_twist_shares
