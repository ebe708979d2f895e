! SPDX-License-Identifier: GPL-3.0-or-later
!> Torsional flexibility of the drive with the rough joint between its bodies, from any converged state, and that of the same
!> drive with the faces glued, open ones too. Their difference is what the contact adds: its inverse is K_TS with the bonded drive
!> as reference, that of Eq. 46. Most of it may be gaps, and where the contact carries no torque a softer body makes it grow: no
!> share of a chain of springs then. `contact_alone` is of the contact only.
!>
!> The joint's stiffness is taken at the pressure and shear of the state, also where the contact law of the run is hard: the bodies
!> are in equilibrium there, and the joint answers to what is added.
module hd_coupled_tangent
  use hd_kinds, only: dp
  use hd_contact_law, only: frictional, open_state, slip_state
  use hd_drive, only: drive_t
  use hd_error, only: error_t
  use hd_joint, only: joint_t, response_t, evaluate_joint
  use hd_linear_solver, only: linear_solver_t
  use hd_problem, only: load_t, state_t
  use hd_rate, only: respond_by_rates
  use hd_rate_law, only: rate_point_t, rate_open, rate_stick, rate_slip, rate_glued, rate_rigid
  use hd_vector, only: dot, many, thread_share
  implicit none
  private
  public :: answer_t, coupled_response, glued_response, contact_alone, joint_points

  !> Answer to a further unit of torque.
  type :: answer_t
    real(dp) :: flexibility = 0                          !< rotation of the rim, or of the bottom [rad/(N m)]
    logical :: settled = .false.                         !< the states of the points are certain, the linear solver is accurate
    real(dp), allocatable :: du(:, :), traction(:, :)    !< displacements (3, n) [m] and tractions (3, points) [Pa], per N m
    type(rate_point_t), allocatable :: points(:)         !< in the states found
  end type answer_t

  !> share by which shear lies below slip, and of the unsheared stiffness that a point keeps there
  real(dp), parameter :: just = 1e-6_dp
  integer, parameter :: long_loop = 1500   !< points from which two threads are worth waking

contains

  !> Rotation of the rim per torque, for a torque that grows, with the faces on their joint.
  subroutine coupled_response(drive, solver, joint, load, sense, state, answer, error)
    type(drive_t), intent(in) :: drive                   !< drive, its tangent that of the state
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    type(joint_t), intent(in) :: joint                   !< joint, its shear capped by the friction of the step
    type(load_t), intent(inout) :: load                  !< of the state; left as it is
    real(dp), intent(in) :: sense                        !< of the torque, +1 or -1
    type(state_t), intent(in) :: state                   !< converged state
    type(answer_t), intent(out) :: answer                !< to a further unit of torque
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    answer%points = joint_points(drive, joint, load, state)
    call turn(drive, solver, load, sense, state, joint%mu, answer, error)
  end subroutine coupled_response

  !> Points on their joint in their first states.
  function joint_points(drive, joint, load, state) result(points)
    type(drive_t), intent(in) :: drive     !< drive
    type(joint_t), intent(in) :: joint     !< joint, its shear capped by the friction of the step
    type(load_t), intent(in) :: load       !< of the state
    type(state_t), intent(in) :: state     !< converged state
    type(rate_point_t) :: points(size(state%contact))
    type(response_t) :: sheared, free
    real(dp) :: shear
    integer :: j, m
    m = drive%problem%mortar%n - drive%problem%mortar%rigid
    !$omp parallel do schedule(static, thread_share) private(sheared, free, shear) if(m > long_loop)
    do j = 1, size(state%contact)
      if (state%contact(j) == open_state) cycle
      points(j)%state = rate_rigid
      if (j > m) cycle
      points(j)%state = rate_open
      associate (p => state%traction(1, j), q => state%traction(2:, j))
        shear = norm2(q)
        call evaluate_joint(joint, p, 0._dp, 1._dp, free)
        if (.not. free%k_n > 0) cycle
        points(j)%k_n = free%k_n
        if (.not. (joint%mu > 0 .and. free%k_t > 0 .and. drive%problem%law%mode == frictional)) then  ! pressed, free to slide
          points(j)%state = rate_rigid
          cycle
        end if
        call evaluate_joint(joint, p, min(shear, (1 - just)*joint%mu*p), 1._dp, sheared)
        points(j)%k_0 = free%k_t
        points(j)%k_t = sheared%k_t
        points(j)%at_bound = state%contact(j) == slip_state .and. load%friction > (1 - just)*joint%mu  ! mu may grow
        points(j)%state = merge(rate_slip, rate_stick, points(j)%at_bound)
        points(j)%grows = .not. points(j)%at_bound
        if (shear > 0) points(j)%direction = q/shear
        if (.not. points(j)%k_t > 0) points(j)%k_t = just*points(j)%k_0
      end associate
    end do
    !$omp end parallel do
  end function joint_points

  !> The same with the faces glued all over.
  subroutine glued_response(drive, solver, load, sense, state, answer, error)
    type(drive_t), intent(in) :: drive                   !< drive, its tangent that of the state
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    type(load_t), intent(inout) :: load                  !< of the state; left as it is
    real(dp), intent(in) :: sense                        !< of the torque, +1 or -1
    type(state_t), intent(in) :: state                   !< converged state
    type(answer_t), intent(out) :: answer                !< to a further unit of torque
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    integer :: m
    allocate (answer%points(size(state%contact)))
    m = drive%problem%mortar%n - drive%problem%mortar%rigid
    answer%points(:m)%state = rate_glued
    answer%points(m + 1:)%state = merge(rate_open, rate_rigid, state%contact(m + 1:) == open_state)
    call turn(drive, solver, load, sense, state, 0._dp, answer, error)
  end subroutine glued_response

  !> Stiffness of the contact alone: the torque by which the faces, held rigid, turn against each other by a further unit angle,
  !> over that angle. A point that sticks answers with the joint's stiffness along and across its shear, one that slips across it
  !> alone, an open one not at all. The oval's lever of the pressure, w/r squared, is left out.
  pure real(dp) function contact_alone(drive, answer) result(k)
    type(drive_t), intent(in) :: drive     !< drive
    type(answer_t), intent(in) :: answer   !< has its points in the states of a further torque
    real(dp) :: along, across
    integer :: j
    k = 0
    do j = 1, drive%problem%mortar%n - drive%problem%mortar%rigid
      associate (point => answer%points(j))
        if (point%state /= rate_stick .and. point%state /= rate_slip) cycle
        across = point%k_0
        along = merge(merge(point%k_t, point%k_0, point%grows), 0._dp, point%state == rate_stick)
        k = k + drive%problem%mortar%area(j)*drive%radius**2*(point%direction(1)**2*along + (1 - point%direction(1)**2)*across)
      end associate
    end do
  end function contact_alone

  !> Rotation of the rim under a further unit of torque.
  subroutine turn(drive, solver, load, sense, state, friction, answer, error)
    type(drive_t), intent(in) :: drive                   !< drive
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    type(load_t), intent(inout) :: load                  !< of the state; left as it is
    real(dp), intent(in) :: sense                        !< of the torque
    type(state_t), intent(in) :: state                   !< converged state
    real(dp), intent(in) :: friction                     !< mu
    type(answer_t), intent(inout) :: answer              !< has its points in their first states
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    real(dp), allocatable :: force(:, :), without(:, :)
    integer :: i
    allocate (answer%du(3, drive%problem%n), answer%traction(3, size(answer%points)))
    call move_alloc(load%force, without)
    allocate (load%force, force, mold=without)
    !$omp parallel do schedule(static) if(size(force) > many)
    do i = 1, size(force, 2)
      force(:, i) = sense*drive%torque(:, i) + drive%squeeze(:, i)
      load%force(:, i) = without(:, i) + force(:, i)
    end do
    !$omp end parallel do
    call solver%begin(drive%problem, load, state, error)
    call move_alloc(without, load%force)
    if (.not. allocated(error)) call respond_by_rates(drive%problem, solver, force, friction, answer%points, answer%du, &
      answer%traction, answer%settled, error)
    if (.not. allocated(error)) answer%flexibility = sense*dot(size(answer%du), drive%gauge, &
      answer%du)
  end subroutine turn
end module hd_coupled_tangent
