! SPDX-License-Identifier: GPL-3.0-or-later
!> Derivatives of a run's results by the real keys of its scene, by direct differentiation along its path.
!>
!> Companions march beside the run, each the same drive with one key changed a little. Where the run has converged, a companion
!> takes one step of Newton's method from the run's state, with the run's matrix and from its own state before: what comes of it is
!> linear in the change, with the history of friction in it. Contact states are those of the run; where a change would turn one,
!> the derivative is that of one side. The first companion has no change: what the run leaves in its equations is taken off.
module hd_gradient
  use hd_kinds, only: dp
  use hd_conditions, only: check_scene
  use hd_contact_law, only: stick_state
  use hd_coupled_tangent, only: answer_t, coupled_response, glued_response, joint_points
  use hd_drive, only: drive_t, drive_load, new_drive, renew_drive, step_friction, touch_teeth
  use hd_error, only: error_t, raise, code_linear_solver
  use hd_facets, only: facets_t, sums_t, evaluate_facets, sum_up, sum_stiffness
  use hd_fatigue, only: fatigue_t
  use hd_joint, only: joint_t, at_friction
  use hd_linear_solver, only: linear_solver_t
  use hd_load_path, only: place_t, operator(<), assembled, assembly_at, torque_at
  use hd_loop, only: loop_t, readings_t, read_loop, bottom_turn
  use hd_mortar, only: add_nodal_forces, relative_displacement
  use hd_newton, only: linear_equations
  use hd_parameter_row, only: parameter_t, parameter_table_t, stage_model, stage_load
  use hd_parameters, only: new_table, value_count
  use hd_problem, only: problem_t, state_t, load_t, apply_stiffness, gap_and_slip, linear_forces, new_state, strut_closings, &
    strut_forces, update_struts
  use hd_rate, only: rate_matrices
  use hd_rate_law, only: rate_point_t, rate_glued
  use hd_scene, only: scene_t
  use hd_scene_joint, only: scene_joint, tabulate_joint
  use hd_stress, only: stress_matrices_t
  use hd_strength, only: strength_t, book_stress
  use hd_strut, only: push
  use hd_strut_step, only: ahead_t, count_ahead, remember, straight
  use hd_summary, only: derivatives_t
  use hd_text, only: string_t, split
  implicit none
  private
  public :: gradient_t, new_gradient

  !> Shares of its value by which a key is changed. What bends the bodies is changed more: their forces are small sums of large
  !> terms, whose rounding must stay small beside the change (2e-6 of a result over its key; by 1e-7 4e-5).
  real(dp), parameter :: share = 1e-7_dp, share_of_shape = 5e-7_dp, share_of_material = 3e-6_dp
  !> In the place of a value that is 0.
  real(dp), parameter :: typical_m = 1e-3_dp, typical_deg = 60, typical_other = 1

  !> Units that hold one of force: with all keys in these f times as large a drive turns as before under f times the torque.
  character(len=7), parameter :: of_force(5) = ['N      ', 'N/m    ', 'N/m^1.5', 'N m    ', 'Pa     ']
  real(dp), parameter :: largest_misfit = 0.02_dp  !< of K1 to K3 under such a scale, by their derivatives

  !> Results of a loop, and of other runs.
  character(len=*), parameter :: of_loop = 'k1_nm_per_rad,k2_nm_per_rad,k3_nm_per_rad,hysteresis_rad,lost_motion_rad,'// &
    'ball_force_max_n,tooth_force_max_n,'
  character(len=*), parameter :: of_all = 'k_ts_nm_per_rad,k_ts_bonded_nm_per_rad,normal_force_n,von_mises_max_pa'

  type :: companion_t
    type(string_t) :: key                            !< group.key
    real(dp) :: change = 0                           !< of it
    real(dp) :: force = 0                            !< its value, if its unit holds one of force
    logical :: idle = .false.                        !< the key has no part in the equilibrium
    logical :: late = .false.                        !< or may have one under the torque only
    type(scene_t) :: scene
    type(drive_t) :: drive                           !< unless it is idle
    type(joint_t) :: joint
    type(state_t) :: before, state                   !< last two
    type(state_t) :: top_before, top                 !< those of the reference step
    type(state_t) :: strained                        !< where the run's von Mises stress was largest so far
    type(loop_t) :: loop                             !< torque, angle and forces alone
    real(dp) :: ball_force = 0, tooth_force = 0      !< largest at the last place [N]
    real(dp) :: rotation_assembled = 0               !< [rad]
  end type companion_t

  type :: gradient_t
    integer :: n = 0
    type(companion_t), allocatable :: of(:)          !< the run itself, then one for each key: n, and room
  contains
    procedure :: follow
    procedure :: book
    procedure :: differentiate
  end type gradient_t

contains

  !> Companions of a run at rest.
  subroutine new_gradient(scene, drive, joint, gradient, error)
    type(scene_t), intent(in) :: scene                !< of the run
    type(drive_t), intent(in) :: drive                !< its drive
    type(joint_t), intent(in) :: joint                !< its joint
    type(gradient_t), intent(out) :: gradient         !< companions
    type(error_t), allocatable, intent(out) :: error  !< mesh, joint
    type(scene_t), target :: copy
    type(parameter_table_t) :: table
    integer, allocatable :: rows(:)
    logical :: fits
    integer :: i
    copy = scene
    call new_table(copy, table)
    rows = pack([(i, i=1, size(table%rows))], [(is_real(table%rows(i), scene), i=1, size(table%rows))])
    allocate (gradient%of(size(rows) + 1))
    gradient%of(1)%scene = scene
    gradient%of(1)%drive = drive
    gradient%of(1)%joint = joint
    gradient%n = 1
    do i = 1, size(rows)
      call change_key(scene, rows(i), drive, joint, gradient%of(gradient%n + 1), fits, error)
      if (allocated(error)) return
      if (fits) gradient%n = gradient%n + 1
    end do
    do i = 1, gradient%n
      call new_state(drive%problem, gradient%of(i)%state)
      gradient%of(i)%before = gradient%of(i)%state
    end do
  end subroutine new_gradient

  !> A key counts: a number of the drive, in use. Where 0 is a word for something else, the number is not in use.
  pure logical function is_real(p, scene)
    type(parameter_t), intent(in) :: p   !< row
    type(scene_t), intent(in) :: scene   !< scene
    logical :: zero
    is_real = .false.
    if (.not. (associated(p%real) .or. associated(p%count)) .or. p%stage(.true., .true.) > stage_load) return
    if (any(p%group == [character(len=8) :: 'run', 'mesh', 'solver', 'surface', 'fit'])) return
    if (associated(p%real)) then
      zero = .not. abs(p%real) > 0
    else
      zero = .not. any(abs(p%reals(:value_count(p))) > 0)
    end if
    is_real = .not. (zero .and. (index(p%meaning, '0: ') > 0 .or. associated(p%count)))
    if (p%key == 'clearance' .and. p%group == 'wave_generator') is_real = is_real .and. (.not. zero .or. &
      .not. scene%interference > 0)  ! it would take the place of an interference
  end function is_real

  !> The drive with a key changed, upwards if that is valid.
  subroutine change_key(scene, row, drive, joint, other, fits, error)
    type(scene_t), intent(in) :: scene                !< of the run
    integer, intent(in) :: row                        !< of the table
    type(drive_t), intent(in) :: drive                !< of the run
    type(joint_t), intent(in) :: joint                !< of the run
    type(companion_t), intent(out) :: other           !< companion
    logical, intent(out) :: fits                      !< it is valid, on the same mesh
    type(error_t), allocatable, intent(out) :: error  !< mesh, joint
    type(scene_t), target :: moved
    type(parameter_table_t) :: table
    type(string_t), allocatable :: faults(:)
    integer :: side
    do side = 1, -1, -2
      moved = scene
      call new_table(moved, table)
      associate (p => table%rows(row))
        other%key%s = p%group//'.'//p%key
        other%idle = any(p%group == [character(len=7) :: 'loop', 'fatigue', 'turning']) .or. index(p%key, 'yield') > 0 .or. &
          (p%group == 'joint' .and. scene%hard())
        other%late = p%stage(scene%formed(), .not. scene%hard()) >= stage_load .or. &
          any(p%group == [character(len=7) :: 'load', 'contact'])
        if (associated(p%real)) then
          if (any(p%unit == of_force)) other%force = p%real
          other%change = side*change_of(p, abs(p%real))
          p%real = p%real + other%change
          fits = p%real > p%low .and. p%real < p%high
        else
          associate (x => p%reals(:value_count(p)))
            other%change = side*change_of(p, maxval(abs(x)))
            x = x + other%change
            fits = all(x > p%low .and. x < p%high)
          end associate
        end if
        if (.not. fits) cycle
        allocate (faults(0))
        call check_scene(moved, faults)
        fits = size(faults) == 0
        deallocate (faults)
        if (.not. fits) cycle
        other%scene = moved
        other%joint = joint
        if (any(p%group == [character(len=8) :: 'material', 'joint', 'contact'])) call scene_joint(moved, other%joint, error)
        if (allocated(error) .or. other%idle) return
        if (p%stage(scene%formed(), .not. scene%hard()) == stage_model) then
          call new_drive(moved, other%drive, error)
        else
          other%drive = drive
          call renew_drive(moved, other%drive, error)
        end if
        if (.not. (allocated(error) .or. scene%hard())) then
          if (.not. allocated(other%drive%problem%law%joint)) allocate (other%drive%problem%law%joint)
          call tabulate_joint(moved, other%joint, other%drive%problem%law%joint, error)
        end if
        if (allocated(error)) return
        fits = same_mesh(other%drive, drive)
        if (fits) return
      end associate
    end do
  end subroutine change_key

  !> Two drives have the same mesh but for small shifts of its nodes.
  pure logical function same_mesh(a, b) result(same)
    type(drive_t), intent(in) :: a, b  !< drives
    real(dp), parameter :: small = 1e-5_dp  !< over the radius
    same = a%problem%n == b%problem%n .and. a%problem%mortar%n == b%problem%mortar%n
    if (same) same = maxval(abs(a%reference([1, 3], :) - b%reference([1, 3], :))) < small*b%radius
  end function same_mesh

  !> Change of a key of a size.
  pure real(dp) function change_of(p, size) result(change)
    type(parameter_t), intent(in) :: p   !< row
    real(dp), intent(in) :: size         !< amount of its value
    change = share
    if (p%group == 'geometry') change = share_of_shape
    if (p%group == 'material') change = share_of_material
    if (size > 0) then
      change = change*size
      return
    end if
    change = change*merge(typical_m, merge(typical_deg, typical_other, p%unit == 'deg'), p%unit == 'm')
  end function change_of

  !> Take all companions to a place that the run has reached.
  subroutine follow(self, solver, drive, load, before, state, place, loaded, error)
    class(gradient_t), intent(inout) :: self          !< companions
    class(linear_solver_t), intent(inout) :: solver   !< of the run
    type(drive_t), intent(inout) :: drive             !< of the run
    type(load_t), intent(in) :: load                  !< of the run's step
    type(state_t), intent(in) :: before, state        !< of the run: at the beginning of the step, and here
    type(place_t), intent(in) :: place                !< here
    logical, intent(in) :: loaded                     !< by the torque
    type(error_t), allocatable, intent(out) :: error  !< linear solver
    type(state_t) :: next, was
    type(load_t) :: other_load
    type(ahead_t) :: ahead
    real(dp) :: slip(2, size(state%contact))
    real(dp), allocatable, dimension(:, :) :: r_u, r_c, left_u, left_c, du, dt
    real(dp), allocatable, dimension(:, :, :) :: by_w, by_t, unused_w, unused_t
    integer :: i, j
    next = state
    call begin_many(solver, self%n, drive, load, before, error)
    if (allocated(error)) return
    call update_struts(drive%problem, load, state%u)
    call linear_equations(drive%problem, load, before, next, left_u, left_c, by_w, by_t)
    du = left_u  ! flanks that just touch hold
    call count_ahead(drive%problem, load, state%u, any(state%contact == stick_state), ahead, du)
    call solver%update(drive%problem, by_w, by_t, error)
    if (allocated(error)) return
    self%of(1)%before = before
    self%of(1)%state = state
    if (self%of(1)%scene%support%loop) call note_forces(self%of(1), load, state)
    allocate (dt, mold=state%traction)
    do i = 2, self%n
      if (self%of(i)%idle) cycle
      associate (c => self%of(i))
        call drive_load(c%drive, assembly_at(c%scene, place), torque_at(c%scene, place), step_friction(c%scene, loaded), &
          other_load, c%state)
        c%drive%problem%wheel_turns = drive%problem%wheel_turns
        next = state
        next%touch = c%state%touch
        next%past = c%state%past
        was = c%state  ! but for its slip, which is taken as linear: a change may be larger than the slip of the step
        call gap_and_slip(c%drive%problem, other_load, was, next)
        was%slip = next%slip - (state%slip - before%slip)
        slip = was%slip - c%state%slip
        call linear_equations(c%drive%problem, other_load, was, next, r_u, r_c, unused_w, unused_t)
        if (drive%problem%wheel_turns .and. c%scene%support%struts) call hold_flanks(c%drive%problem, drive%problem%strut_rate, &
          other_load, next%u, r_u)
        r_u = r_u - left_u
        r_c = r_c - left_c
        do j = 1, size(slip, 2)
          r_c(:, j) = r_c(:, j) + matmul(by_w(:, 2:, j), slip(:, j))
        end do
        if (any(abs(r_u) > 0) .or. any(abs(r_c) > 0)) then
          call solver%solve(drive%problem, r_u, r_c, du, dt, error)
          if (allocated(error)) exit
          next%u = next%u + du
          next%traction = next%traction + dt
        end if
        call gap_and_slip(c%drive%problem, other_load, c%state, next)
        if (c%scene%support%struts .and. .not. (loaded .or. place < assembled(c%scene))) then
          call touch_teeth(c%scene, c%drive, next%u, next)
        else
          call remember(c%drive%problem, other_load, next)
        end if
        if (c%scene%support%loop) call note_forces(c, other_load, next)
        c%before = c%state
        c%state = next
        if (.not. (loaded .or. c%late .or. place < assembled(c%scene))) c%idle = .not. (any(abs(c%state%u - state%u) > 0) &
          .or. any(abs(c%state%touch - state%touch) > 0))
      end associate
    end do
    solver%sides = 1
  end subroutine follow

  !> Flanks that push on the run pull on a companion that a change has taken off them: in the run their way is that of the wheel,
  !> also where the torque is 0 and they only just touch.
  subroutine hold_flanks(problem, rate, load, u, r)
    type(problem_t), intent(inout) :: problem   !< of the companion; gets the tangents of the struts
    real(dp), intent(in) :: rate(:)             !< of the run [N/m]
    type(load_t), intent(in) :: load            !< of the companion
    real(dp), intent(in) :: u(:, :)             !< displacements (3, n) [m]
    real(dp), intent(inout) :: r(:, :)          !< out-of-balance forces (3, n), get the pull [N]
    real(dp) :: closing(size(rate)), pull(size(rate))
    integer :: i
    closing = strut_closings(problem, load, u)
    pull = merge(closing, 0._dp, problem%struts%power < straight .and. rate > 0 .and. closing < 0 .and. closing > -1)
    if (.not. any(abs(pull) > 0)) return
    problem%strut_rate = rate
    pull = linear_forces(problem, pull)
    do i = 1, size(pull)
      if (abs(pull(i)) > 0) call push(problem%struts(i), pull(i), r)
    end do
  end subroutine hold_flanks

  !> Note the forces of balls and teeth.
  subroutine note_forces(c, load, state)
    type(companion_t), intent(inout) :: c   !< gets the largest
    type(load_t), intent(in) :: load        !< of the step
    type(state_t), intent(in) :: state      !< at its end
    real(dp) :: force(size(c%drive%problem%struts))
    force = strut_forces(c%drive%problem, load, state%u)
    associate (n => c%drive%balls)
      c%ball_force = maxval([0._dp, force(:n)])
      c%tooth_force = maxval(force(n + 1:n + c%drive%flanks))
    end associate
  end subroutine note_forces

  !> Begin with a state whose matrix meets many right-hand sides, of no symmetry.
  subroutine begin_many(solver, sides, drive, load, state, error)
    class(linear_solver_t), intent(inout) :: solver   !< of the run
    integer, intent(in) :: sides                      !< how many
    type(drive_t), intent(in) :: drive                !< of the run
    type(load_t), intent(in) :: load                  !< load
    type(state_t), intent(in) :: state                !< state
    type(error_t), allocatable, intent(out) :: error  !< linear solver
    real(dp), parameter :: accuracy = 1e-9_dp
    integer :: images
    images = solver%most_images
    solver%most_images = 1
    call solver%begin(drive%problem, load, state, error)
    solver%most_images = images
    solver%sides = sides
    solver%accuracy = accuracy
  end subroutine begin_many

  !> Book a finished load step.
  subroutine book(self, place, loaded, reference, worst)
    class(gradient_t), intent(inout) :: self   !< companions
    type(place_t), intent(in) :: place         !< its end
    logical, intent(in) :: loaded              !< by the torque
    logical, intent(in) :: reference           !< the run's results are those of this step, so far
    logical, intent(in) :: worst               !< its von Mises stress is the largest so far
    integer :: i
    do i = 1, self%n
      associate (c => self%of(i))
        if (c%idle) cycle
        if (reference) c%top = c%state
        if (reference) c%top_before = c%before
        if (worst) c%strained = c%state
        if (.not. loaded) c%rotation_assembled = sum(c%drive%gauge*c%state%u)
        if (.not. c%scene%support%loop) cycle
        if (.not. loaded) then
          c%loop%torque = [0._dp]
          c%loop%angle = [0._dp]
        else
          c%loop%torque = [c%loop%torque, torque_at(c%scene, place)]
          c%loop%angle = [c%loop%angle, bottom_turn(c%drive, c%state)]
        end if
        c%loop%ball_force_max = max(c%loop%ball_force_max, c%ball_force)
        c%loop%tooth_force_max = max(c%loop%tooth_force_max, c%tooth_force)
      end associate
    end do
  end subroutine book

  !> Derivatives of the results.
  subroutine differentiate(self, solver, drive, place, certain, found, error)
    class(gradient_t), intent(inout) :: self          !< companions at the end of the run
    class(linear_solver_t), intent(inout) :: solver   !< of the run
    type(drive_t), intent(inout) :: drive             !< of the run
    type(place_t), intent(in) :: place                !< of the reference step
    logical, intent(in) :: certain                    !< that step has a tangent K_TS
    type(derivatives_t), intent(out) :: found         !< derivatives
    type(error_t), allocatable, intent(out) :: error  !< linear solver
    real(dp), allocatable :: value(:, :), tangent(:)
    integer :: i, j
    associate (scene => self%of(1)%scene)
      found%results = split(of_all)
      if (scene%support%loop) found%results = split(of_loop//of_all)
      if (.not. scene%support%loop) found%results = [found%results, split('rotation_rad')]
    end associate
    allocate (value(size(found%results), self%n), tangent(self%n))
    call find_tangents(self, solver, drive, place, certain, tangent, error)
    if (allocated(error)) return
    do i = 1, self%n
      if (self%of(i)%idle) then
        self%of(i)%top = self%of(1)%top
        self%of(i)%loop = self%of(1)%loop
        self%of(i)%rotation_assembled = self%of(1)%rotation_assembled
        value(:, i) = results_of(self%of(i), self%of(1)%drive, self%of(1)%strained, place, tangent(i))
      else
        value(:, i) = results_of(self%of(i), self%of(i)%drive, self%of(i)%strained, place, tangent(i))
      end if
    end do
    found%keys = self%of(2:self%n)%key
    allocate (found%value(size(found%keys), size(found%results)))
    do i = 1, size(found%keys)
      do j = 1, size(found%results)
        found%value(i, j) = (value(j, i + 1) - value(j, 1))/self%of(i + 1)%change
      end do
    end do
    associate (scene => self%of(1)%scene)
      if (scene%support%loop .and. .not. any(abs(scene%torques) > 0)) call check_scale(self, value(:3, 1), found, error)
    end associate
  end subroutine differentiate

  !> K1 to K3 of a drive are in proportion to all its forces and stiffnesses together (Euler): derivatives that do not say so were
  !> lost where a change of state nearly turns a matrix singular.
  subroutine check_scale(self, slope, found, error)
    class(gradient_t), intent(in) :: self             !< companions
    real(dp), intent(in) :: slope(3)                  !< K1 to K3 [N m/rad]
    type(derivatives_t), intent(inout) :: found       !< derivatives, deallocated if they do not hold
    type(error_t), allocatable, intent(out) :: error  !< they do not
    real(dp) :: misfit(3)
    misfit = abs(matmul(self%of(2:self%n)%force, found%value(:, :3))/max(slope, tiny(1._dp)) - 1)
    if (.not. any(slope > 0 .and. .not. misfit < largest_misfit)) return
    deallocate (found%value)
    call raise(error, code_linear_solver, 'K1 to K3 would not be in proportion to all forces and stiffnesses by their '// &
      'derivatives, which were lost at a change of state; more load steps or another mesh may keep them')
  end subroutine check_scale

  !> Results of a companion, in the order of their names.
  function results_of(c, drive, strained, place, tangent) result(value)
    type(companion_t), intent(in) :: c          !< at the end
    type(drive_t), intent(in) :: drive          !< its drive
    type(state_t), intent(in) :: strained       !< where the stress is largest
    type(place_t), intent(in) :: place          !< of the reference step
    real(dp), intent(in) :: tangent             !< K_TS [N m/rad]
    real(dp), allocatable :: value(:)
    type(facets_t) :: facets
    type(sums_t) :: sums
    type(load_t) :: load
    type(readings_t) :: readings
    type(strength_t) :: strength
    type(fatigue_t) :: fatigue
    type(stress_matrices_t) :: matrices(2)
    type(scene_t) :: plain
    type(error_t), allocatable :: error
    associate (scene => c%scene, torque => torque_at(c%scene, place), friction => step_friction(c%scene, .true.))
      call drive_load(drive, 1._dp, torque, friction, load, c%top)
      call evaluate_facets(drive, at_friction(c%joint, friction), c%top, facets)
      call sum_up(drive, load, c%top, facets, sums)
      call sum_stiffness(scene, drive, torque, c%top, facets, sums)
      plain = scene
      plain%support%loop = .false.  ! no fatigue
      call book_stress(strength, fatigue, matrices, plain, drive, strained, torque, error)
      allocate (value(0))
      if (scene%support%loop) then
        readings = read_loop(c%loop, scene)
        value = [readings%k, readings%hysteresis, readings%lost_motion, c%loop%ball_force_max, c%loop%tooth_force_max]
      end if
      value = [value, sums%k_ts, tangent, sums%normal_force, max(strength%flexspline, strength%ring)]
      if (.not. scene%support%loop) value = [value, sums%rotation - c%rotation_assembled]
    end associate
  end function results_of

  !> Tangent K_TS of every companion: the answers to a further torque change by what the run's answers leave in the companion's
  !> equations, solved with the run's matrices.
  subroutine find_tangents(self, solver, drive, place, certain, tangent, error)
    type(gradient_t), intent(inout) :: self           !< companions at the end of the run
    class(linear_solver_t), intent(inout) :: solver   !< of the run
    type(drive_t), intent(inout) :: drive             !< of the run
    type(place_t), intent(in) :: place                !< of the reference step
    logical, intent(in) :: certain                    !< there is a tangent
    real(dp), intent(out) :: tangent(:)               !< [N m/rad]
    type(error_t), allocatable, intent(out) :: error  !< linear solver
    type(load_t) :: load
    type(answer_t) :: answer(2)
    real(dp), allocatable, dimension(:, :) :: left_u, left_c, base_u, base_c, du, dt
    real(dp) :: sense, turn
    integer :: i, k, images
    tangent = 0
    if (.not. certain) return
    associate (run => self%of(1))
      sense = sign(1._dp, torque_at(run%scene, place))
      images = solver%most_images
      solver%most_images = 1
      solver%sides = self%n
      call at_top(run, drive, place, load)
      allocate (du, mold=run%state%u)
      allocate (dt, mold=run%state%traction)
      do k = 1, 2
        if (k == 1) call glued_response(drive, solver, load, sense, run%top, answer(k), error)
        if (k == 2) call coupled_response(drive, solver, at_friction(run%joint, step_friction(run%scene, .true.)), load, sense, &
          run%top, answer(k), error)
        if (allocated(error)) exit
        do i = 1, self%n
          if (self%of(i)%idle) then
            call leave(self%of(i), drive, run%top, answer(k), k == 1, sense, place, left_u, left_c)
          else
            call leave(self%of(i), self%of(i)%drive, self%of(i)%top, answer(k), k == 1, sense, place, left_u, left_c)
          end if
          if (i == 1) base_u = left_u
          if (i == 1) base_c = left_c
          du = 0
          if (i > 1) call solver%solve(drive%problem, left_u - base_u, left_c - base_c, du, dt, error)
          if (allocated(error)) exit
          du = du + answer(k)%du
          if (self%of(i)%idle) then
            turn = sense*sum(drive%gauge*du)
          else
            turn = sense*sum(self%of(i)%drive%gauge*du)
          end if
          tangent(i) = turn - tangent(i)  ! the glued one first
        end do
      end do
      solver%most_images = images
      solver%sides = 1
    end associate
    if (.not. allocated(error)) tangent = 1/tangent
  end subroutine find_tangents

  !> Load and struts of a drive at its reference step.
  subroutine at_top(c, drive, place, load)
    type(companion_t), intent(in) :: c        !< companion, or the run
    type(drive_t), intent(inout) :: drive     !< its drive, gets the tangents of its struts
    type(place_t), intent(in) :: place        !< of the reference step
    type(load_t), intent(out) :: load         !< load there
    call drive_load(drive, 1._dp, torque_at(c%scene, place), step_friction(c%scene, .true.), load, c%top, c%top_before)
    if (c%scene%support%struts) load%displacement(2, drive%hub) = c%top%u(2, drive%hub)
    call update_struts(drive%problem, load, c%top%u)
  end subroutine at_top

  !> What the run's answer to a further torque leaves in the equations of a companion.
  subroutine leave(c, drive, top, answer, glued, sense, place, left_u, left_c)
    type(companion_t), intent(inout) :: c            !< companion
    type(drive_t), intent(inout) :: drive            !< its drive
    type(state_t), intent(in) :: top                 !< its reference state
    type(answer_t), intent(in) :: answer             !< of the run
    logical, intent(in) :: glued                     !< with the faces glued
    real(dp), intent(in) :: sense                    !< of the torque
    type(place_t), intent(in) :: place               !< of the reference step
    real(dp), allocatable, intent(out) :: left_u(:, :), left_c(:, :)  !< remainders
    type(rate_point_t) :: points(size(answer%points))
    real(dp), dimension(3, 3, size(answer%points)) :: dw, dt
    type(joint_t) :: joint
    type(load_t) :: load
    real(dp) :: w(3, size(answer%points))
    integer :: j
    c%top = top
    if (c%idle) c%top_before = top
    call at_top(c, drive, place, load)
    points = answer%points
    joint = at_friction(c%joint, step_friction(c%scene, .true.))
    if (.not. glued) then
      points = joint_points(drive, joint, load, top)
      points%state = answer%points%state
      points%grows = answer%points%grows
      points%at_bound = answer%points%at_bound
    end if
    call rate_matrices(drive%problem, merge(0._dp, joint%mu, glued), points, dw, dt)
    left_u = 0*answer%du
    call add_nodal_forces(drive%problem%mortar, answer%traction, left_u)
    left_u = apply_stiffness(drive%problem, answer%du) - left_u - (sense*drive%torque + drive%squeeze)
    w = relative_displacement(drive%problem%mortar, answer%du)
    allocate (left_c, mold=w)
    do j = 1, size(points)
      left_c(:, j) = matmul(dw(:, :, j), w(:, j)) + matmul(dt(:, :, j), answer%traction(:, j))
    end do
  end subroutine leave
end module hd_gradient
