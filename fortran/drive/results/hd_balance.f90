! SPDX-License-Identifier: GPL-3.0-or-later
!> Where the torque leaves the scene: moments about the axis of the forces of each support, and the balance of all forces.
module hd_balance
  use hd_kinds, only: dp
  use hd_body, only: frame
  use hd_drive, only: drive_t
  use hd_mortar, only: add_nodal_forces
  use hd_problem, only: state_t, load_t, internal_residual, strut_forces
  use hd_strut, only: push
  implicit none
  private
  public :: support_torques_t, moment_on_cam, strut_moment, support_torques, body_resultant, contact_torque

  integer, parameter :: block = 4000   !< nodes whose forces are summed one behind the other

  !> What each support takes of the torque, positive in the sense of a torque on the rim; their sum is that torque.
  type :: support_torques_t
    real(dp) :: hub = 0             !< bottom of the cup, its soft springs included [N m]
    real(dp) :: wave_generator = 0  !< inner face of the ring: prescribed displacements, balls, the cam's pressure [N m]
    real(dp) :: ring_springs = 0    !< soft springs that hold a ring which is free on the cam [N m]
    real(dp) :: balance = 0         !< all moments, the load's, balls' and teeth's included: what is out of balance [N m]
    real(dp) :: lateral(2) = 0      !< all forces along x and y: the same [N]
    real(dp) :: hub_force(2) = 0    !< along x and y, that the bottom of the cup takes [N]
    real(dp) :: axial_struts = 0    !< of balls in grooves along the axis [N]
  end type support_torques_t

contains

  !> Moments of the supports.
  function support_torques(drive, load, state, r) result(torque)
    type(drive_t), intent(in) :: drive  !< drive
    type(load_t), intent(in) :: load    !< load of the step
    type(state_t), intent(in) :: state  !< converged state
    real(dp), intent(in) :: r(:, :)     !< forces that are out of balance, at fixed dofs reactions (3, n) [N]
    type(support_torques_t) :: torque
    real(dp), allocatable :: strut(:, :), force(:)
    real(dp) :: part(3), all(3)
    integer :: i
    associate (problem => drive%problem, u => state%u, inner => drive%inner, hub => drive%hub, sprung => drive%sprung)
      part = nodes_resultant(drive, state, hub, merge(r(:, hub), 0._dp, problem%fixed(:, hub)), drive%b_cup) + &
        nodes_resultant(drive, state, sprung, -problem%spring(:, sprung)*u(:, sprung), drive%b_cup)
      all = part
      torque%hub = -part(3)
      torque%hub_force = -part(:2)
      part = nodes_resultant(drive, state, inner, forces_of_cam(drive, load, state, r), drive%b_ring)
      all = all + part
      torque%wave_generator = -part(3)
      part = nodes_resultant(drive, state, inner, spread([0, -1, 0], 2, size(inner))*problem%spring(:, inner)*u(:, inner), &
        drive%b_ring)
      all = all + part - nodes_resultant(drive, state, inner, spread([1, 0, 0], 2, size(inner))*problem%spring(:, inner)* &
        load%displacement(:, inner), drive%b_ring)
      torque%ring_springs = -part(3)
      all = all + body_resultant(drive, state, load%force, 1) + body_resultant(drive, state, load%force, 2)
      if (allocated(problem%struts)) then
        allocate (strut(3, problem%n), source=0._dp)
        force = strut_forces(problem, load, u)
        do i = 1, size(force)
          call push(problem%struts(i), -force(i), strut)
        end do
        all = all + body_resultant(drive, state, strut, 1) + body_resultant(drive, state, strut, 2)
        torque%axial_struts = sum(strut(3, :))
        do i = drive%balls + drive%flanks + 1, drive%balls + drive%flanks + drive%stays
          torque%ring_springs = torque%ring_springs - strut_moment(drive, state, i, force(i), drive%b_ring)
        end do
      end if
      torque%balance = all(3)
      torque%lateral = all(:2)
    end associate
  end function support_torques

  !> Forces of the wave generator on the nodes of the ring's inner face where no balls lie between them (3, inner) [N].
  function forces_of_cam(drive, load, state, r) result(force)
    type(drive_t), intent(in) :: drive         !< drive
    type(load_t), intent(in) :: load           !< load of the step
    type(state_t), intent(in) :: state         !< converged state
    real(dp), intent(in) :: r(:, :)            !< as of support_torques
    real(dp) :: force(3, size(drive%inner))
    real(dp), allocatable :: contact(:, :), traction(:, :)
    associate (problem => drive%problem, m => drive%problem%mortar%n - drive%problem%mortar%rigid, inner => drive%inner)
      force = merge(r(:, inner), 0._dp, problem%fixed(:, inner))
      if (m < problem%mortar%n) then
        traction = state%traction
        traction(:, :m) = 0
        allocate (contact(3, problem%n), source=0._dp)
        call add_nodal_forces(problem%mortar, traction, contact)
        force = force + contact(:, inner)
      end if
      force(1, :) = force(1, :) + problem%spring(1, inner)*(load%displacement(1, inner) - state%u(1, inner))
    end associate
  end function forces_of_cam

  !> Moment of the ring on the wave generator: cam, balls and cage as one body. With large displacements of the forces on the ring's
  !> inner face as they act, balls along the normals of the deformed face. Small ones leave faces round, and balls no lever: to
  !> first order of what presses on the cam's slopes, besides what a cam without balls takes tangentially [N m].
  function moment_on_cam(drive, load, state, force) result(m)
    type(drive_t), intent(in) :: drive   !< whole drive
    type(load_t), intent(in) :: load     !< load of the step
    type(state_t), intent(in) :: state   !< converged state
    real(dp), intent(in) :: force(:)     !< of the struts [N]
    real(dp) :: m, of_cam(3, size(drive%inner)), total(3), r(3, drive%problem%n)
    integer :: i
    if (drive%balls > 0 .and. allocated(drive%problem%lagrangian)) then
      m = -sum([(strut_moment(drive, state, i, force(i), drive%b_ring), i=1, drive%balls)])
    else if (drive%balls > 0) then
      m = sum(force(:drive%balls)*drive%slope)
    else
      call internal_residual(drive%problem, load, state, r)
      of_cam = forces_of_cam(drive, load, state, r)
      total = nodes_resultant(drive, state, drive%inner, of_cam, drive%b_ring)
      m = -total(3)
      if (.not. allocated(drive%problem%lagrangian)) m = m + sum(of_cam(1, :)*drive%slope)
    end if
  end function moment_on_cam

  !> Moment about the axis of a strut on the nodes of a body [N m].
  real(dp) function strut_moment(drive, state, i, force, b) result(m)
    type(drive_t), intent(in) :: drive   !< whole drive
    type(state_t), intent(in) :: state   !< converged state
    integer, intent(in) :: i             !< strut
    real(dp), intent(in) :: force        !< its force [N]
    integer, intent(in) :: b             !< body
    real(dp) :: total(3)
    total = nodes_resultant(drive, state, drive%problem%struts(i)%node, -force*drive%problem%struts(i)%weight, b)
    m = total(3)
  end function strut_moment

  !> Sums along x and y [N] and moment about the axis [N m] of forces on nodes of one body, added up in blocks of one length
  !> whatever the number of threads.
  function nodes_resultant(drive, state, nodes, force, b) result(r)
    type(drive_t), intent(in) :: drive     !< drive
    type(state_t), intent(in) :: state     !< with large displacements the deformed bodies count
    integer, intent(in) :: nodes(:)        !< nodes
    real(dp), intent(in) :: force(:, :)    !< (3, nodes) [N]
    integer, intent(in) :: b               !< body
    real(dp) :: r(3), part(3, size(nodes)/block + 1), f(3), x(3), turn(3, 3)
    integer :: i, k, n
    !$omp parallel do schedule(static) private(i, n, f, x, turn) if(size(nodes) > block)
    do k = 1, size(part, 2)
      part(:, k) = 0
      do i = block*(k - 1) + 1, min(size(nodes), block*k)
        if (.not. any(abs(force(:, i)) > 0)) cycle
        n = nodes(i) - drive%problem%first(b)
        turn = frame(drive%problem%bodies(b)%angle(n))
        f = matmul(turn, force(:, i))
        x = drive%problem%bodies(b)%x(:, n)
        if (allocated(drive%problem%lagrangian)) x = x + matmul(turn, state%u(:, nodes(i)))
        part(:, k) = part(:, k) + [f(:2), x(1)*f(2) - x(2)*f(1)]
      end do
    end do
    !$omp end parallel do
    r = sum(part, 2)
  end function nodes_resultant

  !> The same of the forces on all nodes (3, n).
  function body_resultant(drive, state, force, b) result(r)
    type(drive_t), intent(in) :: drive     !< drive
    type(state_t), intent(in) :: state     !< state
    real(dp), intent(in) :: force(:, :)    !< (3, n) [N]
    integer, intent(in) :: b               !< body
    real(dp) :: r(3)
    integer :: i
    associate (from => drive%problem%first(b) + 1, to => drive%problem%first(b) + drive%problem%bodies(b)%nodes())
      r = nodes_resultant(drive, state, [(i, i=from, to)], force(:, from:to), b)
    end associate
  end function body_resultant

  !> Torque that contact passes on, from the forces on the ring, which stays where it is even while the flexspline slides [N m].
  real(dp) function contact_torque(drive, state) result(m)
    type(drive_t), intent(in) :: drive  !< drive
    type(state_t), intent(in) :: state  !< state or iterate
    real(dp) :: force(3, drive%problem%n), total(3)
    force = 0
    call add_nodal_forces(drive%problem%mortar, -state%traction, force)
    total = body_resultant(drive, state, force, drive%b_ring)
    m = total(3)
  end function contact_torque
end module hd_balance
