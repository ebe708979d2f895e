! SPDX-License-Identifier: GPL-3.0-or-later
!> Derivatives of the tangent K_TS of a run (hd_coupled_tangent) by the real keys of its scene and by the state it is taken in.
!>
!> K_TS is one over what a drive turns by more on its joint than glued. Either answer to a further torque solves linear equations;
!> the transposed of these are solved once, and a key costs what it leaves in the equations of the run's answer.
module hd_tangent_slopes
  use hd_kinds, only: dp
  use hd_adjoint, only: adjoint_t, begin_adjoint
  use hd_neighbour, only: neighbour_t, share_of_state
  use hd_coupled_tangent, only: answer_t, coupled_response, glued_response, joint_points
  use hd_drive, only: drive_t, drive_load, step_friction, strut_load
  use hd_error, only: error_t
  use hd_groove, only: groove_curvature
  use hd_joint, only: joint_t, at_friction
  use hd_linear_solver, only: linear_solver_t
  use hd_load_path, only: place_t, torque_at
  use hd_mortar, only: add_nodal_forces, relative_displacement
  use hd_newton, only: idle_components
  use hd_problem, only: state_t, load_t, apply_stiffness, linear_forces, strut_closings, update_struts
  use hd_rate, only: rate_matrices
  use hd_rate_law, only: rate_point_t
  use hd_scene, only: scene_t
  use hd_strut, only: closing_of, push
  use hd_strut_step, only: straight
  implicit none
  private
  public :: find_tangent_slopes

contains

  !> The answers to a further torque, glued and on the joint, and what every key leaves in their equations.
  subroutine find_tangent_slopes(solver, scene, joint, drive, place, before, top, of, change, by_u, by_t, error)
    class(linear_solver_t), intent(inout) :: solver   !< of the run
    type(scene_t), intent(in) :: scene                !< of the run
    type(joint_t), intent(in) :: joint                !< its joint
    type(drive_t), intent(inout) :: drive             !< its drive
    type(place_t), intent(in) :: place                !< of the reference step
    type(state_t), intent(in) :: before, top          !< the state before it, and its own
    type(neighbour_t), intent(inout) :: of(:)         !< of the keys; get the tangents of their struts
    real(dp), intent(out) :: change(:)                !< of K_TS by the changes of the keys [N m/rad]
    real(dp), intent(out) :: by_u(:, :), by_t(:, :)   !< derivatives by displacements (3, n) and tractions (3, points) there
    type(error_t), allocatable, intent(out) :: error  !< linear solver
    type(answer_t) :: answer
    type(adjoint_t) :: adjoint
    type(load_t) :: load
    real(dp), allocatable, dimension(:, :) :: left_u, left_c
    real(dp), dimension(3, drive%problem%n, 1) :: lambda, by_turn
    real(dp) :: rho(3, drive%problem%mortar%n, 1), later(2, drive%problem%mortar%n, 1)
    type(rate_point_t), allocatable :: points(:)
    real(dp), dimension(3, 3, drive%problem%mortar%n) :: dw, dt
    real(dp) :: flexibility, part, sense
    integer :: i, k
    associate (problem => drive%problem)
      change = 0
      by_u = 0
      sense = sign(1._dp, torque_at(scene, place))
      flexibility = 0
      do k = 1, -1, -2  ! what they turn by more than glued
        call load_at(scene, place, before, top, drive, load)
        if (k < 0) call glued_response(drive, solver, load, sense, top, answer, error)
        if (k > 0) call coupled_response(drive, solver, at_friction(joint, step_friction(scene, .true.)), load, sense, top, &
          answer, error)
        if (allocated(error)) return
        flexibility = flexibility + k*answer%flexibility
        call rate_matrices(problem, idle_components(problem), merge(step_friction(scene, .true.), 0._dp, k > 0), answer%points, &
          dw, dt)
        call adjoint%take(problem%law%scale, dw, dt)
        load%force = load%force + sense*drive%torque + drive%squeeze  ! in whose symmetry the answer lies
        call begin_adjoint(solver, 1, problem, load, top, error)
        if (.not. allocated(error)) call solver%update(problem, adjoint%w, adjoint%t, error)
        later = 0
        rho = 0
        by_turn(:, :, 1) = sense*drive%gauge
        if (.not. allocated(error)) call adjoint%solve(problem, solver, by_turn, (rho), later, [.true.], lambda, rho, error)
        if (allocated(error)) return
        left_u = remaining_forces(drive, sense, answer)
        points = answer%points
        if (k > 0) points = points_on(scene, joint, drive, load, top, answer)
        left_c = remaining_law(drive, merge(step_friction(scene, .true.), 0._dp, k > 0), points, answer)
        do i = 1, size(of)
          associate (c => of(i))
            part = 0
            if (c%whole) then
              call load_at(c%scene, place, before, top, c%drive, load)
              part = sense*sum((c%drive%gauge - drive%gauge)*answer%du) - &
                sum(lambda(:, :, 1)*(remaining_forces(c%drive, sense, answer) - left_u)) - &
                sum(rho(:, :, 1)*(law_of(c, c%drive, load, top, points, answer, k > 0) - left_c))
            else if (c%rough) then
              part = -sum(rho(:, :, 1)*(law_of(c, drive, load, top, points, answer, k > 0) - left_c))
            end if
            if (c%struts .and. .not. c%whole) part = part - work_of_struts(c, drive, top, lambda(:, :, 1), answer%du)
            change(i) = change(i) + k*part
          end associate
        end do
        if (k > 0) by_t = by_tractions(scene, joint, drive, load, top, answer, rho(:, :, 1), left_c)
        call add_curvature(drive, top, lambda(:, :, 1), answer%du, k, by_u)
      end do
      change = -change/flexibility**2
      by_u = -by_u/flexibility**2
      by_t = -by_t/flexibility**2
    end associate
  end subroutine find_tangent_slopes

  !> What the run's answer leaves in the law of a neighbour's joint (3, points).
  function law_of(c, own, load, top, points, answer, loose) result(left)
    type(neighbour_t), intent(in) :: c             !< neighbour
    type(drive_t), intent(in) :: own               !< its bodies
    type(load_t), intent(in) :: load               !< of the reference step
    type(state_t), intent(in) :: top               !< its state
    type(rate_point_t), intent(in) :: points(:)    !< of the run
    type(answer_t), intent(in) :: answer           !< of the run
    logical, intent(in) :: loose                   !< not glued
    real(dp) :: left(3, size(points)), friction
    friction = merge(step_friction(c%scene, .true.), 0._dp, loose)
    if (c%rough .and. loose) then
      left = remaining_law(own, friction, points_on(c%scene, c%joint, own, load, top, answer), answer)
    else
      left = remaining_law(own, friction, points, answer)
    end if
  end function law_of

  !> What the answer on the joint turns by the tractions at the points, through the stiffness that they give it there.
  function by_tractions(scene, joint, drive, load, top, answer, rho, left_c) result(by_t)
    type(scene_t), intent(in) :: scene      !< of the run
    type(joint_t), intent(in) :: joint      !< its joint
    type(drive_t), intent(in) :: drive      !< its bodies
    type(load_t), intent(in) :: load        !< of the reference step
    type(state_t), intent(in) :: top        !< its state
    type(answer_t), intent(in) :: answer    !< of the run
    real(dp), intent(in) :: rho(:, :), left_c(:, :)  !< by residuals of the law, and what is left in it (3, points)
    real(dp) :: by_t(3, size(rho, 2)), step(size(rho, 2))
    type(state_t) :: moved
    integer :: c
    moved%contact = top%contact
    do c = 1, 3
      moved%traction = top%traction
      step = share_of_state*abs(top%traction(1, :))
      if (c > 1) step = share_of_state*norm2(top%traction(2:, :), 1)
      moved%traction(c, :) = moved%traction(c, :) + step
      by_t(c, :) = -sum(rho*(remaining_law(drive, step_friction(scene, .true.), &
        points_on(scene, joint, drive, load, moved, answer), answer) - left_c), 1)/max(step, tiny(1._dp))
    end do
  end function by_tractions

  !> Load and struts of a drive at the reference step of the run.
  subroutine load_at(scene, place, before, top, drive, load)
    type(scene_t), intent(in) :: scene           !< of the drive
    type(place_t), intent(in) :: place           !< of the step
    type(state_t), intent(in) :: before, top     !< the run's states before it and there
    type(drive_t), intent(inout) :: drive        !< gets the tangents of its struts
    type(load_t), intent(out) :: load            !< load there
    call drive_load(drive, 1._dp, torque_at(scene, place), step_friction(scene, .true.), load, top, before)
    if (scene%support%struts) load%displacement(2, drive%hub) = top%u(2, drive%hub)
    drive%problem%wheel_turns = scene%support%turns_bottom
    call update_struts(drive%problem, load, top%u)
  end subroutine load_at

  !> What the run's answer to a further torque leaves in the balance of a drive (3, n).
  function remaining_forces(drive, sense, answer) result(left)
    type(drive_t), intent(in) :: drive      !< at its reference step
    real(dp), intent(in) :: sense           !< of the torque
    type(answer_t), intent(in) :: answer    !< of the run
    real(dp), allocatable :: left(:, :)
    allocate (left, mold=answer%du)
    call apply_stiffness(drive%problem, answer%du, left)
    call add_nodal_forces(drive%problem%mortar, answer%traction, left, factor=-1._dp)
    left = left - (sense*drive%torque + drive%squeeze)
  end function remaining_forces

  !> Points of the run's answer on another joint.
  function points_on(scene, joint, drive, load, top, answer) result(points)
    type(scene_t), intent(in) :: scene      !< friction
    type(joint_t), intent(in) :: joint      !< joint
    type(drive_t), intent(in) :: drive      !< bodies
    type(load_t), intent(in) :: load        !< of the reference step
    type(state_t), intent(in) :: top        !< its state
    type(answer_t), intent(in) :: answer    !< of the run
    type(rate_point_t), allocatable :: points(:)
    points = joint_points(drive, at_friction(joint, step_friction(scene, .true.)), load, top)
    points%state = answer%points%state
    points%grows = answer%points%grows
    points%at_bound = answer%points%at_bound
  end function points_on

  !> What it leaves in the law of the points (3, points).
  function remaining_law(drive, friction, points, answer) result(left)
    type(drive_t), intent(in) :: drive             !< bodies
    real(dp), intent(in) :: friction               !< mu of the points, 0: glued
    type(rate_point_t), intent(in) :: points(:)    !< points
    type(answer_t), intent(in) :: answer           !< of the run
    real(dp) :: left(3, size(points)), w(3, size(points))
    real(dp), dimension(3, 3, size(points)) :: dw, dt
    integer :: j
    call rate_matrices(drive%problem, idle_components(drive%problem), friction, points, dw, dt)
    w = relative_displacement(drive%problem%mortar, answer%du)
    do j = 1, size(points)
      left(:, j) = matmul(dw(:, :, j), w(:, j)) + matmul(dt(:, :, j), answer%traction(:, j))
    end do
  end function remaining_law

  !> Work on lambda of what a drive's own struts do more than the run's under a displacement.
  real(dp) function work_of_struts(c, drive, top, lambda, du) result(work)
    type(neighbour_t), intent(inout) :: c       !< gets the tangents of its struts
    type(drive_t), intent(in) :: drive          !< of the run, at its reference step
    type(state_t), intent(in) :: top            !< its state
    real(dp), intent(in) :: lambda(:, :), du(:, :)  !< (3, n)
    real(dp), dimension(size(drive%problem%struts)) :: a, b
    type(load_t) :: load
    integer :: i
    do i = 1, size(a)
      a(i) = closing_of(drive%problem%struts(i), lambda)
      b(i) = closing_of(drive%problem%struts(i), du)
    end do
    call strut_load(c%drive, 1._dp, load, top)
    call update_struts(c%drive%problem, load, top%u)
    work = dot_product(a, linear_forces(c%drive%problem, b) - linear_forces(drive%problem, b))
  end function work_of_struts

  !> The same by the closings of the run's own struts, whose tangents change with them: derivatives of -k times it.
  subroutine add_curvature(drive, top, lambda, du, k, by_u)
    type(drive_t), intent(in) :: drive          !< of the run, at its reference step
    type(state_t), intent(in) :: top            !< its state
    real(dp), intent(in) :: lambda(:, :), du(:, :)  !< (3, n)
    integer, intent(in) :: k                    !< sign
    real(dp), intent(inout) :: by_u(:, :)       !< gets them (3, n)
    real(dp), allocatable :: closing(:)
    real(dp) :: g(2)
    type(load_t) :: load
    integer :: i
    if (.not. allocated(drive%problem%struts)) return
    call strut_load(drive, 1._dp, load, top)
    closing = strut_closings(drive%problem, load, top%u)
    do i = 1, size(closing)
      associate (s => drive%problem%struts(i))
        if (allocated(drive%problem%groove) .and. i <= drive%balls) then
          associate (axial => drive%problem%struts(drive%problem%groove%before + i))
            g = groove_curvature(drive%problem%groove, s, closing(i), closing(drive%problem%groove%before + i), &
              [closing_of(s, lambda), closing_of(axial, lambda)], [closing_of(s, du), closing_of(axial, du)])
            call push(s, -k*g(1), by_u)
            call push(axial, -k*g(2), by_u)
          end associate
        else if (closing(i) > 0 .and. s%power > straight) then
          call push(s, -k*s%power*(s%power - 1)*s%rate*closing(i)**(s%power - 2)*closing_of(s, lambda)*closing_of(s, du), by_u)
        end if
      end associate
    end do
  end subroutine add_curvature
end module hd_tangent_slopes
