! SPDX-License-Identifier: GPL-3.0-or-later
!> The circular spline as supports of single teeth (Sec. 3.1): each pair in mesh is a spring along the tooth's normal that
!> only pushes; the torque turns the cup's bottom. Between the teeth and the bottom everything is linear (bonded contact), so
!> the structure is reduced to its responses: one unit force per tooth, one unit rotation of the hub.
!>
!>   closing_i = c_i phi - sum_j F_ij f_j - g_i,   f_i = k max(0, closing_i),   K_0 phi + sum_i c_i f_i = T
!> phi rotation of the hub, c closing of the free teeth per rotation, F compliance, K_0 stiffness of the hub without teeth.
module hd_teeth
  use hd_kinds, only: dp, pi
  use hd_drive, only: drive_t, drive_load
  use hd_error, only: error_t, raise, code_not_converged
  use hd_lapack, only: solve_dense
  use hd_linear_solver, only: linear_solver_t
  use hd_newton, only: respond
  use hd_problem, only: state_t, load_t, gap_and_slip, internal_residual
  use hd_rim_load, only: force_tooth, rim_nodes
  use hd_scene, only: scene_t
  use hd_tooth_flanks, only: tooth_angles, tooth_gaps
  implicit none
  private
  public :: teeth_t, new_teeth, turn_hub, add_tooth_forces

  type :: teeth_t
    integer :: n = 0                              !< pairs in mesh
    integer :: flank = 1                          !< side of theirs that the torque presses, 1 if it is positive, else -1
    real(dp), allocatable :: theta(:)             !< their places [rad]
    real(dp), allocatable :: gap(:)               !< clearance at the end of the assembly [m]
    real(dp), allocatable :: force(:)             !< along the normal [N]
    real(dp), allocatable :: closing(:)           !< approach of the flanks beyond the clearance [m]
    real(dp) :: rotation = 0                      !< of the hub since the assembly [rad]
    integer :: iterations = 0                     !< of the last load step
    real(dp), private :: rate = 0                 !< stiffness of a pair [N/m]
    real(dp), private :: hub_rate = 0             !< K_0 [N m/rad]
    real(dp), allocatable, private :: pattern(:, :, :)     !< unit forces along the normals (3, nodes, n)
    real(dp), allocatable, private :: compliance(:, :)     !< F [m/N]
    real(dp), allocatable, private :: free(:)              !< c [m]
    type(state_t), allocatable, private :: response(:)     !< to each unit force, last to the unit rotation
    type(state_t), private :: assembled                    !< state at the end of the assembly
  end type teeth_t

contains

  !> Place the teeth and find the responses of the structure; `assembled` is the state in which they touch.
  subroutine new_teeth(scene, drive, solver, assembled, teeth, error)
    type(scene_t), intent(in) :: scene                    !< scene
    type(drive_t), intent(inout) :: drive                 !< its problem, bonded, hub held
    class(linear_solver_t), intent(inout) :: solver       !< of the whole face
    type(state_t), intent(in) :: assembled                !< end of the assembly
    type(teeth_t), intent(out) :: teeth                   !< ready for torques
    type(error_t), allocatable, intent(out) :: error      !< linear solver
    type(load_t) :: load, rest
    real(dp), allocatable :: r(:, :)
    integer :: i, n
    n = scene%tooth_pairs
    teeth%n = n
    teeth%flank = merge(1, -1, scene%torque >= 0)
    teeth%theta = tooth_angles(scene)
    teeth%gap = tooth_gaps(scene, merge(1, 2, teeth%flank > 0))
    teeth%rate = scene%tooth_stiffness
    teeth%assembled = assembled
    allocate (teeth%force(n), teeth%closing(n), source=0._dp)
    allocate (teeth%pattern(3, drive%problem%n, n), teeth%compliance(n, n), teeth%response(n + 1))
    call place_teeth(scene, drive, teeth)
    call drive_load(drive, 0._dp, 0._dp, 0._dp, rest)
    do i = 1, n + 1
      load = rest
      if (i <= n) load%force = teeth%pattern(:, :, i)
      if (i > n) load%displacement(2, drive%hub) = scene%hub_radius
      call respond(drive%problem, solver, load, i == 1, teeth%response(i), error)
      if (allocated(error)) return
      if (i <= n) teeth%compliance(:, i) = closings(teeth, teeth%response(i)%u)
    end do
    teeth%free = closings(teeth, teeth%response(n + 1)%u)
    allocate (r, mold=load%force)
    call internal_residual(drive%problem, load, teeth%response(n + 1), r)
    teeth%hub_rate = sum(r(2, drive%hub)*load%displacement(2, drive%hub))
  end subroutine new_teeth

  !> Unit forces along the teeth's normals.
  subroutine place_teeth(scene, drive, teeth)
    type(scene_t), intent(in) :: scene       !< scene
    type(drive_t), intent(in) :: drive       !< its cup
    type(teeth_t), intent(inout) :: teeth    !< gets pattern
    real(dp), dimension(3, drive%problem%bodies(drive%b_cup)%nodes()) :: radial, tangential
    real(dp) :: angle
    integer, allocatable :: outside(:)
    integer :: i
    angle = scene%pressure_angle_deg*pi/180
    teeth%pattern = 0
    associate (cup => drive%problem%bodies(drive%b_cup), first => drive%problem%first(drive%b_cup))
      outside = rim_nodes(cup, drive%rim)
      radial = 0
      tangential = 0
      do i = 1, teeth%n
        call force_tooth(scene, cup, drive%rim, outside, teeth%theta(i)/(2*pi), radial, tangential)
        teeth%pattern(:, first + 1:first + cup%nodes(), i) = sin(angle)*radial + teeth%flank*cos(angle)*tangential
      end do
    end associate
  end subroutine place_teeth

  !> Approach of the flanks by a displacement field [m].
  pure function closings(teeth, u) result(c)
    type(teeth_t), intent(in) :: teeth  !< teeth
    real(dp), intent(in) :: u(:, :)     !< displacements (3, nodes) [m]
    real(dp) :: c(teeth%n)
    integer :: i
    c = [(sum(teeth%pattern(:, :, i)*u), i=1, teeth%n)]
  end function closings

  !> Turn the hub until it carries a torque; the set of teeth in contact is found by a semi-smooth Newton iteration.
  subroutine turn_hub(teeth, drive, torque, state, error)
    type(teeth_t), intent(inout) :: teeth             !< gets forces and rotation
    type(drive_t), intent(in) :: drive                !< drive
    real(dp), intent(in) :: torque                    !< [N m]
    type(state_t), intent(inout) :: state             !< solution
    type(error_t), allocatable, intent(out) :: error  !< no tooth takes the torque
    real(dp) :: a(teeth%n + 1, teeth%n + 1), b(teeth%n + 1, 1)
    logical :: closed(teeth%n), now(teeth%n)
    type(load_t) :: load
    integer :: i, n
    n = teeth%n
    closed = teeth%force > 0 .or. .not. any(teeth%force > 0)
    do i = 1, 4*n
      teeth%iterations = i
      call reduced_system(teeth, closed, torque, a, b)
      call solve_dense(a, b, error)
      if (allocated(error)) return
      teeth%force = merge(b(:n, 1), 0._dp, closed)
      teeth%rotation = b(n + 1, 1)
      teeth%closing = teeth%free*teeth%rotation - matmul(teeth%compliance, teeth%force) - teeth%gap
      now = merge(teeth%force > 0, teeth%closing > 0, closed)
      if (all(now .eqv. closed)) exit
      closed = now
    end do
    if (any(now .neqv. closed)) then
      call raise(error, code_not_converged, &
        'the set of teeth in contact does not settle: change load.tooth_clearance or load.torque a little')
      return
    end if
    state = teeth%assembled
    do i = 1, n
      state%u = state%u - teeth%force(i)*teeth%response(i)%u
      state%traction = state%traction - teeth%force(i)*teeth%response(i)%traction
    end do
    state%u = state%u + teeth%rotation*teeth%response(n + 1)%u
    state%traction = state%traction + teeth%rotation*teeth%response(n + 1)%traction
    call drive_load(drive, 1._dp, 0._dp, 0._dp, load)
    call gap_and_slip(drive%problem, load, teeth%assembled, state)
  end subroutine turn_hub

  !> Equations of the closed teeth and of the hub.
  pure subroutine reduced_system(teeth, closed, torque, a, b)
    type(teeth_t), intent(in) :: teeth   !< teeth
    logical, intent(in) :: closed(:)     !< those in contact
    real(dp), intent(in) :: torque       !< [N m]
    real(dp), intent(out) :: a(:, :)     !< matrix of forces and rotation
    real(dp), intent(out) :: b(:, :)     !< right-hand side
    integer :: i, n
    n = teeth%n
    a = 0
    b = 0
    do i = 1, n
      a(i, i) = 1
      if (.not. closed(i)) cycle
      a(i, :n) = merge(teeth%compliance(i, :), 0._dp, closed)
      a(i, i) = a(i, i) + 1/teeth%rate
      a(i, n + 1) = -teeth%free(i)
      b(i, 1) = -teeth%gap(i)
      a(n + 1, i) = teeth%free(i)
    end do
    a(n + 1, n + 1) = teeth%hub_rate
    b(n + 1, 1) = torque
  end subroutine reduced_system

  !> Forces of the teeth on the cup, for balances and reactions.
  pure subroutine add_tooth_forces(teeth, force)
    type(teeth_t), intent(in) :: teeth          !< teeth
    real(dp), intent(inout) :: force(:, :)      !< nodal forces (3, nodes) [N]
    integer :: i
    do i = 1, teeth%n
      force = force - teeth%force(i)*teeth%pattern(:, :, i)
    end do
  end subroutine add_tooth_forces
end module hd_teeth
