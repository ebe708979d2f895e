! SPDX-License-Identifier: GPL-3.0-or-later
!> Torsional flexibility of the drive with the rough joint between its bodies, from any converged state, and that of the same
!> drive with the faces glued. Their difference is what the contact adds: its inverse is the tangent K_TS.
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
  implicit none
  private
  public :: coupled_flexibility, glued_flexibility

  !> share by which shear lies below slip, and of the unsheared stiffness that a point keeps there
  real(dp), parameter :: just = 1e-6_dp

contains

  !> Rotation of the rim per torque, for a torque that grows, with the faces on their joint.
  subroutine coupled_flexibility(drive, solver, joint, load, sense, state, flexibility, settled, error)
    type(drive_t), intent(in) :: drive                   !< drive, its tangent that of the state
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    type(joint_t), intent(in) :: joint                   !< joint, its shear capped by the friction of the step
    type(load_t), intent(in) :: load                     !< of the state
    real(dp), intent(in) :: sense                        !< of the torque, +1 or -1
    type(state_t), intent(in) :: state                   !< converged state
    real(dp), intent(out) :: flexibility                 !< [rad/(N m)]
    logical, intent(out) :: settled                      !< the states of the points are certain, the linear solver is accurate
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    type(rate_point_t) :: points(size(state%contact))
    type(response_t) :: sheared, free
    real(dp) :: shear
    integer :: j, m
    m = drive%problem%mortar%n - drive%problem%mortar%rigid
    do j = 1, size(points)
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
    call turn(drive, solver, load, sense, state, joint%mu, points, flexibility, settled, error)
  end subroutine coupled_flexibility

  !> The same with the faces glued all over.
  subroutine glued_flexibility(drive, solver, load, sense, state, flexibility, settled, error)
    type(drive_t), intent(in) :: drive                   !< drive, its tangent that of the state
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    type(load_t), intent(in) :: load                     !< of the state
    real(dp), intent(in) :: sense                        !< of the torque, +1 or -1
    type(state_t), intent(in) :: state                   !< converged state
    real(dp), intent(out) :: flexibility                 !< [rad/(N m)]
    logical, intent(out) :: settled                      !< the linear solver is accurate
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    type(rate_point_t) :: points(size(state%contact))
    integer :: m
    m = drive%problem%mortar%n - drive%problem%mortar%rigid
    points(:m)%state = rate_glued
    points(m + 1:)%state = merge(rate_open, rate_rigid, state%contact(m + 1:) == open_state)
    call turn(drive, solver, load, sense, state, 0._dp, points, flexibility, settled, error)
  end subroutine glued_flexibility

  !> Rotation of the rim under a further unit of torque.
  subroutine turn(drive, solver, load, sense, state, friction, points, flexibility, settled, error)
    type(drive_t), intent(in) :: drive                   !< drive
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    type(load_t), intent(in) :: load                     !< of the state
    real(dp), intent(in) :: sense                        !< of the torque
    type(state_t), intent(in) :: state                   !< converged state
    real(dp), intent(in) :: friction                     !< mu
    type(rate_point_t), intent(inout) :: points(:)       !< in their first states
    real(dp), intent(out) :: flexibility                 !< [rad/(N m)]
    logical, intent(out) :: settled                      !< the states of the points are certain, the linear solver is accurate
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    type(load_t) :: further
    real(dp) :: force(3, drive%problem%n), du(3, drive%problem%n)
    flexibility = 0
    settled = .false.
    force = sense*drive%torque + drive%squeeze
    further = load
    further%force = load%force + force
    call solver%begin(drive%problem, further, state, error)
    if (.not. allocated(error)) call respond_by_rates(drive%problem, solver, force, friction, points, du, settled, error)
    if (.not. allocated(error)) flexibility = sense*sum(drive%gauge*du)
  end subroutine turn
end module hd_coupled_tangent
