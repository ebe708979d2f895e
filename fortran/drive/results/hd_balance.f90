! SPDX-License-Identifier: GPL-3.0-or-later
!> Where the torque leaves the scene: moments about the axis of the forces of each support, and the balance of all forces.
module hd_balance
  use hd_kinds, only: dp
  use hd_body, only: axial_moment, cartesian
  use hd_drive, only: drive_t
  use hd_mortar, only: add_nodal_forces
  use hd_problem, only: state_t, load_t, internal_residual, strut_forces
  use hd_strut, only: push
  implicit none
  private
  public :: support_torques_t, moment_on_cam, support_torques, moment, contact_torque

  !> What each support takes of the torque, positive in the sense of a torque on the rim; their sum is that torque.
  type :: support_torques_t
    real(dp) :: hub = 0             !< bottom of the cup, its soft springs included [N m]
    real(dp) :: wave_generator = 0  !< inner face of the ring: prescribed displacements, balls, the cam's pressure [N m]
    real(dp) :: ring_springs = 0    !< soft springs that hold a ring which is free on the cam [N m]
    real(dp) :: balance = 0         !< all moments, the load's, balls' and teeth's included: what is out of balance [N m]
    real(dp) :: lateral(2) = 0      !< all forces along x and y: the same [N]
    real(dp) :: hub_force(2) = 0    !< along x and y, that the bottom of the cup takes [N]
  end type support_torques_t

contains

  !> Moments of the supports.
  function support_torques(drive, load, state, r) result(torque)
    type(drive_t), intent(in) :: drive  !< drive
    type(load_t), intent(in) :: load    !< load of the step
    type(state_t), intent(in) :: state  !< converged state
    real(dp), intent(in) :: r(:, :)     !< reactions at fixed dofs, else 0 (3, n) [N]
    type(support_torques_t) :: torque
    real(dp), dimension(3, drive%problem%n) :: part, all
    real(dp), allocatable :: force(:)
    integer :: i
    associate (problem => drive%problem)
      part = 0
      part(:, drive%hub) = r(:, drive%hub)
      part(:, drive%sprung) = part(:, drive%sprung) - problem%spring(:, drive%sprung)*state%u(:, drive%sprung)
      torque%hub = -moment(drive, state, part, drive%b_cup)
      torque%hub_force = -lateral_force(drive, part)
      all = part + load%force
      part = forces_of_cam(drive, load, state, r)
      torque%wave_generator = -moment(drive, state, part, drive%b_ring)
      all = all + part
      part = 0
      part(2, drive%inner) = -problem%spring(2, drive%inner)*state%u(2, drive%inner)
      torque%ring_springs = -moment(drive, state, part, drive%b_ring)
      all = all + part
      all(1, drive%inner) = all(1, drive%inner) - problem%spring(1, drive%inner)*load%displacement(1, drive%inner)
      if (allocated(problem%struts)) then
        force = strut_forces(problem, load, state%u)
        do i = 1, size(force)
          call push(problem%struts(i), -force(i), all)
        end do
      end if
      torque%balance = moment(drive, state, all, 1) + moment(drive, state, all, 2)
      torque%lateral = lateral_force(drive, all)
    end associate
  end function support_torques

  !> Forces of the wave generator on the ring where no balls lie between them (3, n) [N].
  function forces_of_cam(drive, load, state, reactions) result(force)
    type(drive_t), intent(in) :: drive         !< drive
    type(load_t), intent(in) :: load           !< load of the step
    type(state_t), intent(in) :: state         !< converged state
    real(dp), intent(in) :: reactions(:, :)    !< at fixed dofs (3, n) [N]
    real(dp) :: force(3, drive%problem%n), traction(3, drive%problem%mortar%n)
    force = 0
    associate (problem => drive%problem, m => drive%problem%mortar%n - drive%problem%mortar%rigid, inner => drive%inner)
      if (m < problem%mortar%n) then
        traction = state%traction
        traction(:, :m) = 0
        call add_nodal_forces(problem%mortar, traction, force)
      end if
      force(:, inner) = force(:, inner) + reactions(:, inner)
      force(1, inner) = force(1, inner) + problem%spring(1, inner)*(load%displacement(1, inner) - state%u(1, inner))
    end associate
  end function forces_of_cam

  !> Moment of the ring on a cam without balls: of what it takes tangentially, and to first order of what presses on its slopes
  !> [N m].
  function moment_on_cam(drive, load, state) result(m)
    type(drive_t), intent(in) :: drive   !< whole drive
    type(load_t), intent(in) :: load     !< load of the step
    type(state_t), intent(in) :: state   !< converged state
    real(dp) :: m, force(3, drive%problem%n)
    force = internal_residual(drive%problem, load, state)
    where (.not. drive%problem%fixed) force = 0
    force = forces_of_cam(drive, load, state, force)
    m = sum(force(1, drive%inner)*drive%slope) - moment(drive, state, force, drive%b_ring)
  end function moment_on_cam

  !> Moment about the axis of the nodal forces on one body [N m].
  pure real(dp) function moment(drive, state, force, b) result(m)
    type(drive_t), intent(in) :: drive     !< drive
    type(state_t), intent(in) :: state     !< with large displacements the deformed bodies count
    real(dp), intent(in) :: force(:, :)    !< (3, n) [N]
    integer, intent(in) :: b               !< body
    associate (body => drive%problem%bodies(b), first => drive%problem%first(b))
      if (allocated(drive%problem%lagrangian)) then
        m = axial_moment(body, force(:, first + 1:first + body%nodes()), state%u(:, first + 1:first + body%nodes()))
      else
        m = axial_moment(body, force(:, first + 1:first + body%nodes()))
      end if
    end associate
  end function moment

  !> Sum along x and y of nodal forces on both bodies [N].
  pure function lateral_force(drive, force) result(f)
    type(drive_t), intent(in) :: drive     !< drive
    real(dp), intent(in) :: force(:, :)    !< (3, n) [N]
    real(dp) :: f(2), v(3)
    integer :: b
    f = 0
    do b = 1, 2
      associate (body => drive%problem%bodies(b), first => drive%problem%first(b))
        v = sum(cartesian(body, force(:, first + 1:first + body%nodes())), 2)
      end associate
      f = f + v(:2)
    end do
  end function lateral_force

  !> Torque that contact passes on, from the forces on the ring, which stays where it is even while the flexspline slides [N m].
  real(dp) function contact_torque(drive, state) result(m)
    type(drive_t), intent(in) :: drive  !< drive
    type(state_t), intent(in) :: state  !< state or iterate
    real(dp) :: force(3, drive%problem%n)
    force = 0
    call add_nodal_forces(drive%problem%mortar, -state%traction, force)
    m = moment(drive, state, force, drive%b_ring)
  end function contact_torque
end module hd_balance
