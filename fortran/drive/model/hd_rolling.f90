! SPDX-License-Identifier: GPL-3.0-or-later
!> Flexspline and ring that turn under the wave generator by a facet: every material point takes displacement, traction and slip
!> along to where it stands then. Seen from the wave generator, the bodies turn backwards and its support stays.
module hd_rolling
  use hd_drive, only: drive_t
  use hd_problem, only: state_t
  implicit none
  private
  public :: roll_on

contains

  !> The state of all points, one facet on; it is no equilibrium yet.
  pure subroutine roll_on(drive, state)
    type(drive_t), intent(in) :: drive      !< drive, as many facets round the ring as round the flexspline
    type(state_t), intent(inout) :: state   !< converged, then turned
    integer :: from(drive%problem%n), at(drive%problem%n), b, i, m
    associate (problem => drive%problem)
      do b = 1, size(problem%bodies)
        associate (first => problem%first(b), body => problem%bodies(b))
          from(first + 1:first + body%nodes()) = first + modulo([(i, i=1, body%nodes())] + body%nodes_per_sector - 1, &
            body%nodes()) + 1
        end associate
      end do
      m = problem%mortar%n
      at = 0
      at(problem%mortar%node) = [(i, i=1, m)]
      state%u = state%u(:, from)
      associate (point => at(from(problem%mortar%node)))
        state%traction = state%traction(:, point)
        state%slip = state%slip(:, point)
        state%gap = state%gap(point)
        state%contact = state%contact(point)
      end associate
    end associate
  end subroutine roll_on
end module hd_rolling
