! SPDX-License-Identifier: GPL-3.0-or-later
!> Derivatives of a run's results by the real keys of its scene, by adjoint differentiation back along its path.
!>
!> The run leaves its converged states. From the last to the first the transposed of Newton's equations there is solved for every
!> result (hd_adjoint): what the result changes by per residual, and with the history of friction what it asks of the state before.
!> A key then costs its residuals alone: those of the same drive with the key changed a little, in the run's states. Contact states
!> are those of the run; where a change would turn one, the derivative is that of one side.
module hd_gradient
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_adjoint, only: adjoint_t, begin_adjoint
  use hd_neighbour, only: neighbour_t, find_neighbours, change_residuals, change_law, forces_of, share_of_state
  use hd_contact_law, only: stick_state
  use hd_drive, only: drive_t, drive_load, step_friction, strut_load, touch_teeth
  use hd_error, only: error_t
  use hd_facets, only: facets_t, sums_t, evaluate_facets, sum_stiffness, stiffness_slopes, edge_loads
  use hd_fatigue, only: cycle_weights, fatigue_t, safety_of
  use hd_joint, only: joint_t, at_friction
  use hd_lapack, only: dgemm
  use hd_linear_solver, only: linear_solver_t
  use hd_load_path, only: place_t, assembly_at, torque_at, under_torque
  use hd_loop, only: loop_t, readings_t, read_loop
  use hd_mortar, only: add_nodal_forces
  use hd_newton, only: linear_equations, prescribe
  use hd_problem, only: problem_t, state_t, load_t, elastic_forces, linear_forces, move_state, strut_forces, update_struts
  use hd_scene, only: scene_t
  use hd_stress, only: worst_node, node_stress
  use hd_strut, only: closing_of, push
  use hd_strut_step, only: ahead_t, count_ahead
  use hd_summary, only: derivatives_t
  use hd_symmetry, only: sharing_t, share_law
  use hd_tangent_slopes, only: find_tangent_slopes
  use hd_text, only: string_t, split
  use hd_tolerance_band, only: readings
  implicit none
  private
  public :: gradient_t

  real(dp), parameter :: largest_misfit = 5e-3_dp  !< of a result to all forces, over the parts that they have in it

  !> Results of a loop: readings, largest forces, and safety; and of all runs, the last one of those without a loop.
  character(len=*), parameter :: of_loop = 'k1_nm_per_rad,k2_nm_per_rad,k3_nm_per_rad,hysteresis_rad,lost_motion_rad,'// &
    'ball_force_max_n,tooth_force_max_n,goodman_safety_min,'
  character(len=*), parameter :: of_all = 'k_ts_nm_per_rad,k_ts_bonded_nm_per_rad,normal_force_n,von_mises_max_pa,'// &
    'edge_line_load_n_per_m'
  integer, parameter :: forces = 2, looped = readings + forces + 1
  integer, parameter :: few = 16                   !< stations that have room at first

  !> A converged state of the run.
  type :: station_t
    type(place_t) :: place
    type(state_t) :: state
    logical :: booked = .false.                      !< the end of a load step
  end type station_t

  !> A result on its way back.
  type :: result_t
    logical :: begun = .false.                       !< a station from here on counts
    integer :: station = 0                           !< where the result itself is read, 0: at several
    real(dp), allocatable :: by_u(:, :), by_t(:, :), by_touch(:)  !< its derivatives there
    real(dp), allocatable :: later(:, :), held(:, :) !< what the next step asks: of slip (2, points), of tractions (3, points)
    real(dp), allocatable :: touch(:)                !< by the offsets of flanks, of all steps so far
  end type result_t

  type :: gradient_t
    integer :: n = 0
    type(station_t), allocatable :: station(:)       !< rest, n, and room
    integer :: top = 0, worst = 0, assembled = 0     !< stations: of the reference step, of the largest stress, before the torque
    integer :: ball_at = 0, tooth_at = 0             !< of the largest forces
    integer :: ball = 0, tooth = 0                   !< their struts
    integer :: tired_at = 0, tired(2) = 0            !< of the least safety, and the nodes of the cup it is of
    real(dp) :: safety = huge(1._dp)                 !< least so far
    integer :: spot(2) = 0                           !< body and its node where the stress is largest
    integer :: edge(2) = 0                           !< where an end of the band carries most: end, column of facets
    integer :: keys = 0
    type(neighbour_t), allocatable :: of(:)          !< of the keys, and room
    type(result_t), allocatable :: result(:)
    real(dp), allocatable :: by_turn(:, :)           !< of the results by the turn of rim or bottom (stations, results)
    real(dp), allocatable :: value(:, :)             !< changes of the results by those of the keys (keys, results)
  contains
    procedure :: follow
    procedure :: book
    procedure :: differentiate
  end type gradient_t

contains

  !> Keep a state that the run has reached.
  subroutine follow(self, place, before, state)
    class(gradient_t), intent(inout) :: self          !< stations
    type(place_t), intent(in) :: place                !< where
    type(state_t), intent(in) :: before               !< where it came from
    type(state_t), intent(in) :: state                !< converged
    type(station_t), allocatable :: more(:)
    integer :: i
    if (.not. allocated(self%station)) then
      allocate (self%station(0:few))
      self%station(0)%state = before
    end if
    if (self%n == ubound(self%station, 1)) then
      allocate (more(0:2*self%n))
      do i = 0, self%n
        more(i)%place = self%station(i)%place
        more(i)%booked = self%station(i)%booked
        call move_state(self%station(i)%state, more(i)%state)
      end do
      call move_alloc(more, self%station)
    end if
    self%n = self%n + 1
    self%station(self%n) = station_t(place, state)
  end subroutine follow

  !> Book a finished load step.
  pure subroutine book(self, loaded, reference, worst, fatigue)
    class(gradient_t), intent(inout) :: self   !< stations
    logical, intent(in) :: loaded              !< by the torque
    logical, intent(in) :: reference           !< the run's results are those of this step, so far
    logical, intent(in) :: worst               !< its von Mises stress is the largest so far
    type(fatigue_t), intent(in) :: fatigue     !< of the cup so far
    self%station(self%n)%booked = .true.
    if (reference) self%top = self%n
    if (worst) self%worst = self%n
    if (.not. loaded) self%assembled = self%n
    if (.not. allocated(fatigue%safety)) return
    if (.not. minval(fatigue%safety) < self%safety) return
    self%safety = minval(fatigue%safety)
    self%tired_at = self%n
    self%tired = fatigue%least
  end subroutine book

  !> Derivatives of the results, or of the readings of a loop alone.
  subroutine differentiate(self, solver, scene, joint, drive, tangent, found, lost, error, only)
    class(gradient_t), intent(inout) :: self          !< stations of the whole run
    class(linear_solver_t), intent(inout) :: solver   !< of the run
    type(scene_t), intent(in) :: scene                !< of the run
    type(joint_t), intent(in) :: joint                !< its joint
    type(drive_t), intent(inout) :: drive             !< its drive
    real(dp), intent(in) :: tangent                   !< K_TS of the reference step, NaN: none [N m/rad]
    type(derivatives_t), intent(out) :: found         !< derivatives; NaN: no such result, or lost
    character(len=:), allocatable, intent(out) :: lost  !< results whose derivatives do not hold
    type(error_t), allocatable, intent(out) :: error  !< mesh, joint, linear solver
    type(string_t), intent(in), optional :: only(:)   !< keys that the readings are wanted by; all that hold forces come with them
    real(dp), allocatable :: value(:)
    integer :: i, j, images
    call find_neighbours(scene, drive, joint, self%of, self%keys, error, only)
    if (allocated(error)) return
    found%results = split(of_all)
    if (scene%support%loop) found%results = split(of_loop//of_all)
    if (.not. scene%support%loop) found%results = [found%results, split('rotation_rad')]
    if (present(only)) found%results = found%results(:readings)
    allocate (self%result(size(found%results)))
    allocate (self%value(self%keys, size(found%results)), self%by_turn(self%n, size(found%results)), source=0._dp)
    images = solver%most_images
    if (scene%formed() .or. scene%eccentricity > 0) solver%most_images = 1  ! GMRES around round bodies does not say which it uses,
                                                                            ! and an eccentric cam's angle breaks any symmetry
    do i = 1, size(self%result)
      associate (r => self%result(i), points => drive%problem%mortar%n)
        allocate (r%later(2, points), r%by_t(3, points), r%held(3, points), r%by_u(3, drive%problem%n), r%touch(drive%flanks), &
          source=0._dp)
      end associate
    end do
    if (scene%support%loop) call by_readings(self, scene, drive)
    if (present(only)) then
      value = readings_of(self, scene, drive)
      do i = 1, self%keys
        associate (c => self%of(i))
          if (c%whole) self%value(i, :) = readings_of(self, c%scene, c%drive) - value
          if (.not. c%whole) self%value(i, :) = readings_of(self, c%scene, drive) - value
        end associate
      end do
    else
      call begin_results(self, scene, joint, drive, value, error)
      i = merge(looped, 0, scene%support%loop) + 2
      if (tangent == tangent .and. .not. allocated(error)) call find_tangent_slopes(solver, scene, joint, drive, &
        self%station(self%top)%place, self%station(self%top - 1)%state, self%station(self%top)%state, self%of(:self%keys), &
        self%value(:, i), self%result(i)%by_u, self%result(i)%by_t, error)
      if (.not. allocated(error)) value(i) = tangent
    end if
    do i = self%n, 1, -1
      if (.not. allocated(error)) call go_back(self, solver, scene, drive, i, error)
    end do
    solver%most_images = images
    solver%sides = 1
    if (allocated(error)) return
    found%keys = self%of(:self%keys)%key
    found%value = self%value/spread(self%of(:self%keys)%change, 2, size(found%results))
    do i = 1, self%keys  ! round a centred cam the largest of several that are equal grows whatever the sense: no derivative
      if (scene%support%loop .or. scene%eccentricity > 0 .or. found%keys(i)%s /= 'wave_generator.eccentricity') cycle
      where ([(found%results(j)%s == 'von_mises_max_pa' .or. found%results(j)%s == 'edge_line_load_n_per_m', &
        j=1, size(found%results))]) found%value(i, :) = ieee_value(1._dp, ieee_quiet_nan)
    end do
    call check_scale(self, scene, value, found, lost)
  end subroutine differentiate

  !> Stiffnesses, forces and stresses are in proportion to all forces and stiffnesses of a scene together, angles and safety do not
  !> change with them (Euler): derivatives that do not say so were lost where a change of state nearly turns a matrix singular. Not
  !> all forces are keys of a joint by a table and of given torques, which count as one.
  subroutine check_scale(self, scene, value, found, lost)
    class(gradient_t), intent(in) :: self             !< neighbours
    type(scene_t), intent(in) :: scene                !< of the run
    real(dp), intent(in) :: value(:)                  !< the results
    type(derivatives_t), intent(inout) :: found       !< NaN where they do not hold
    character(len=:), allocatable, intent(out) :: lost  !< names of these
    character(len=*), parameter :: constant(4) = [character(len=18) :: 'hysteresis_rad', 'lost_motion_rad', 'rotation_rad', &
      'goodman_safety_min']
    real(dp), parameter :: no_angle = 1e-9_dp  !< one that rounding may be of the size of [rad]
    real(dp) :: part(self%keys), degree
    integer :: j
    lost = ''
    if (scene%joint_model == 'table' .or. any(abs(scene%torques) > 0)) return
    do j = 1, size(value)
      part = self%of(:self%keys)%force*found%value(:, j)
      degree = merge(0._dp, 1._dp, any(found%results(j)%s == constant))
      if (.not. abs(sum(part) - degree*value(j)) > largest_misfit*max(sum(abs(part)), abs(value(j)), no_angle)) cycle
      if (len(lost) > 0) lost = lost//', '
      lost = lost//found%results(j)%s
      found%value(:, j) = ieee_value(1._dp, ieee_quiet_nan)
    end do
  end subroutine check_scale

  !> Where balls and teeth carry most, of all load steps.
  subroutine find_forces(self, scene, drive)
    type(gradient_t), intent(inout) :: self  !< gets the places
    type(scene_t), intent(in) :: scene       !< of the run
    type(drive_t), intent(in) :: drive       !< its drive
    real(dp) :: most(2)
    real(dp), allocatable :: force(:)
    integer :: i
    most = 0
    do i = 1, self%n
      if (.not. self%station(i)%booked) cycle
      force = forces_in(self, scene, drive, i)
      associate (balls => force(:drive%balls), flanks => force(drive%balls + 1:drive%balls + drive%flanks))
        if (maxval([0._dp, balls]) > most(1)) then
          self%ball_at = i
          self%ball = maxloc(balls, 1)
        end if
        if (maxval([0._dp, flanks]) > most(2)) then
          self%tooth_at = i
          self%tooth = drive%balls + maxloc(flanks, 1)
        end if
        most = max(most, [maxval([0._dp, balls]), maxval([0._dp, flanks])])
      end associate
    end do
  end subroutine find_forces

  !> Forces of the struts at a station [N].
  function forces_in(self, scene, drive, i) result(force)
    type(gradient_t), intent(in) :: self     !< stations
    type(scene_t), intent(in) :: scene       !< scene of a drive
    type(drive_t), intent(in) :: drive       !< with these struts
    integer, intent(in) :: i                 !< station
    real(dp), allocatable :: force(:)
    type(load_t) :: load
    call strut_load(drive, assembly_at(scene, self%station(i)%place), load, self%station(i - 1)%state)
    force = strut_forces(drive%problem, load, self%station(i)%state%u)
  end function forces_in

  !> Results that a drive would have in the states of the run, in the order of their names; no tangent.
  function results_of(self, scene, joint, own, drive, k_ts) result(value)
    type(gradient_t), intent(in) :: self        !< stations
    type(scene_t), intent(in) :: scene          !< of the drive
    type(joint_t), intent(in) :: joint          !< its joint
    type(drive_t), intent(in) :: own            !< its struts
    type(drive_t), intent(in) :: drive          !< all else of it
    real(dp), intent(in), optional :: k_ts      !< K_TS by Eq. 45, if it is known [N m/rad]
    real(dp), allocatable :: value(:)
    type(facets_t) :: facets
    type(sums_t) :: sums
    type(load_t) :: load
    type(error_t), allocatable :: error  ! none: the mesh is checked
    real(dp), allocatable :: u(:, :), force(:), line(:, :)
    real(dp) :: stress, most(2), cycle(2)
    integer :: i
    associate (top => self%station(self%top), worst => self%station(self%worst))
      if (present(k_ts)) then
        sums%k_ts = k_ts
      else
        call evaluate_facets(drive, at_friction(joint, step_friction(scene, .true.)), top%state, facets)
        call sum_stiffness(scene, drive, torque_at(scene, top%place), top%state, facets, sums)
      end if
      call drive_load(drive, assembly_at(scene, worst%place), 0._dp, 0._dp, load)
      u = worst%state%u
      call prescribe(drive%problem, load, u)
      call node_stress(drive%problem, self%spot(1), self%spot(2:), [1._dp], u, stress, error)
      allocate (value(0))
      if (scene%support%loop) then
        most = 0
        if (self%ball_at > 0) then
          force = forces_in(self, scene, own, self%ball_at)
          most(1) = force(self%ball)
        end if
        if (self%tooth_at > 0) then
          force = forces_in(self, scene, own, self%tooth_at)
          most(2) = force(self%tooth)
        end if
        call drive_load(drive, assembly_at(scene, self%station(self%tired_at)%place), 0._dp, 0._dp, load)
        u = self%station(self%tired_at)%state%u
        call prescribe(drive%problem, load, u)
        do i = 1, 2
          call node_stress(drive%problem, drive%b_cup, self%tired, cycle_weights(:, i), u, cycle(i), error)
        end do
        value = [readings_of(self, scene, drive), most, safety_of(scene, cycle(1), cycle(2))]
      end if
      line = edge_loads(drive, top%state%traction(1, :))
      associate (m => drive%problem%mortar%n - drive%problem%mortar%rigid)
        value = [value, sums%k_ts, 0._dp, sum(drive%problem%mortar%area(:m)*top%state%traction(1, :m)), abs(stress), &
          line(self%edge(1), self%edge(2))]
      end associate
      if (.not. scene%support%loop) value = [value, sum(drive%gauge*(top%state%u - self%station(self%assembled)%state%u))]
    end associate
  end function results_of

  !> Readings of that loop.
  function readings_of(self, scene, drive) result(value)
    type(gradient_t), intent(in) :: self     !< stations
    type(scene_t), intent(in) :: scene       !< of the drive
    type(drive_t), intent(in) :: drive       !< the drive
    real(dp) :: value(readings)
    type(readings_t) :: says
    says = read_loop(loop_of(self, scene, drive), scene)
    value = [says%k, says%hysteresis, says%lost_motion]
  end function readings_of

  !> The loop that a drive would have in the states of the run.
  function loop_of(self, scene, drive) result(loop)
    type(gradient_t), intent(in) :: self     !< stations
    type(scene_t), intent(in) :: scene       !< of the drive
    type(drive_t), intent(in) :: drive       !< the drive
    type(loop_t) :: loop
    integer, allocatable :: at(:)
    integer :: i
    at = pack([(i, i=1, drive%problem%n)], any(abs(drive%gauge) > 0, 1))
    loop%torque = [0._dp]
    loop%angle = [0._dp]
    do i = self%assembled + 1, self%n
      if (.not. self%station(i)%booked) cycle
      loop%torque = [loop%torque, torque_at(scene, self%station(i)%place)]
      loop%angle = [loop%angle, sum(drive%gauge(:, at)*self%station(i)%state%u(:, at))]
    end do
  end function loop_of

  !> The results, what a key changes of them in the states of the run, and their derivatives by the states that they are read from.
  subroutine begin_results(self, scene, joint, drive, value, error)
    type(gradient_t), intent(inout) :: self           !< gets them
    type(scene_t), intent(in) :: scene                !< of the run
    type(joint_t), intent(in) :: joint                !< its joint
    type(drive_t), intent(inout) :: drive             !< its drive
    real(dp), allocatable, intent(out) :: value(:)    !< results; of the tangent 0
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp), allocatable :: k_ts, line(:, :), by_u(:, :, :)
    real(dp) :: stress, cycle(2)
    integer :: f, i, m, n
    call worst_node(drive%problem, self%station(self%worst)%state%u, self%spot(1), self%spot(2), error)
    if (allocated(error)) return
    if (scene%support%loop) call find_forces(self, scene, drive)
    self%edge = maxloc(edge_loads(drive, self%station(self%top)%state%traction(1, :)))
    value = results_of(self, scene, joint, drive, drive)
    do i = 1, self%keys
      associate (c => self%of(i))
        if (allocated(k_ts)) deallocate (k_ts)
        if (.not. (c%whole .or. c%rough)) k_ts = value(merge(looped, 0, scene%support%loop) + 1)
        if (c%idle) self%value(i, :) = results_of(self, c%scene, c%joint, drive, drive, k_ts) - value
        if (c%whole) self%value(i, :) = results_of(self, c%scene, c%joint, c%drive, c%drive) - value
        if (.not. (c%idle .or. c%whole)) self%value(i, :) = results_of(self, c%scene, c%joint, c%drive, drive, k_ts) - value
      end associate
    end do
    if (scene%support%loop) then
      call by_force(self, scene, drive, self%ball_at, self%ball, self%result(readings + 1))
      call by_force(self, scene, drive, self%tooth_at, self%tooth, self%result(readings + forces))
      self%result(looped)%station = self%tired_at
      allocate (by_u(3, drive%problem%n, 2), source=0._dp)
      do i = 1, 2
        call node_stress(drive%problem, drive%b_cup, self%tired, cycle_weights(:, i), self%station(self%tired_at)%state%u, &
          cycle(i), error, by_u(:, :, i))
      end do
      self%result(looped)%by_u = -safety_of(scene, cycle(1), cycle(2))**2*(merge(by_u(:, :, 1), 0._dp, cycle(1) > 0)/ &
        scene%tensile_strength + sign(scene%notch_factor/scene%fatigue_limit, cycle(2))*by_u(:, :, 2))
      n = looped
    else
      n = size(self%result)
      self%by_turn(self%top, n) = 1
      if (self%assembled > 0) self%by_turn(self%assembled, n) = self%by_turn(self%assembled, n) - 1
      n = 0
    end if
    self%result(n + 1:n + 3)%station = self%top
    call stiffness_slopes(drive, at_friction(joint, step_friction(scene, .true.)), self%station(self%top)%state, &
      self%result(n + 1)%by_u, self%result(n + 1)%by_t)
    m = drive%problem%mortar%n - drive%problem%mortar%rigid
    self%result(n + 3)%by_t(1, :m) = drive%problem%mortar%area(:m)
    self%result(n + 4)%station = self%worst
    call node_stress(drive%problem, self%spot(1), self%spot(2:), [1._dp], self%station(self%worst)%state%u, stress, error, &
      self%result(n + 4)%by_u)
    self%result(n + 4)%by_u = sign(1._dp, stress)*self%result(n + 4)%by_u
    self%result(n + 5)%station = self%top
    associate (at => drive%problem%mortar%facet, columns => drive%axial_facets)
      do f = columns*(self%edge(2) - 1) + 1, columns*self%edge(2)
        do i = 1, 4, 3  ! the load is linear in the pressures
          line = edge_loads(drive, [(merge(1._dp, 0._dp, m == at(i, f)), m=1, drive%problem%mortar%n)])
          self%result(n + 5)%by_t(1, at(i, f)) = line(self%edge(1), self%edge(2))
        end do
      end do
    end associate
  end subroutine begin_results

  !> Derivatives of the readings of a loop by its angles.
  subroutine by_readings(self, scene, drive)
    type(gradient_t), intent(inout) :: self  !< gets by_turn
    type(scene_t), intent(in) :: scene       !< of the run
    type(drive_t), intent(in) :: drive       !< its drive
    real(dp), parameter :: small = 1e-5_dp   !< of the largest angle
    type(loop_t) :: loop, moved
    type(readings_t) :: low, high
    integer, allocatable :: at(:)
    real(dp) :: step
    integer :: i
    loop = loop_of(self, scene, drive)
    at = pack([(i, i=1, self%n)], self%station(1:self%n)%booked .and. [(i > self%assembled, i=1, self%n)])
    step = small*maxval(abs(loop%angle))
    do i = 1, size(at)
      moved = loop
      moved%angle(i + 1) = loop%angle(i + 1) - step
      low = read_loop(moved, scene)
      moved%angle(i + 1) = loop%angle(i + 1) + step
      high = read_loop(moved, scene)
      self%by_turn(at(i), :readings) = [high%k - low%k, high%hysteresis - low%hysteresis, high%lost_motion - low%lost_motion]/ &
        (2*step)
    end do
  end subroutine by_readings

  !> Derivatives of the force of a strut.
  subroutine by_force(self, scene, drive, station, strut, result)
    type(gradient_t), intent(in) :: self      !< stations
    type(scene_t), intent(in) :: scene        !< of the run
    type(drive_t), intent(inout) :: drive     !< its drive
    integer, intent(in) :: station, strut     !< which; 0: none pushes
    type(result_t), intent(inout) :: result   !< gets them
    type(load_t) :: load
    real(dp), allocatable :: force(:)
    integer :: i
    result%station = station
    if (station == 0) return
    call strut_load(drive, assembly_at(scene, self%station(station)%place), load, self%station(station - 1)%state)
    call update_struts(drive%problem, load, self%station(station)%state%u)
    force = linear_forces(drive%problem, [(merge(1._dp, 0._dp, i == strut), i=1, size(drive%problem%struts))])
    do i = 1, size(force)
      if (abs(force(i)) > 0) call push(drive%problem%struts(i), force(i), result%by_u)
    end do
    result%by_touch = force(drive%balls + 1:drive%balls + drive%flanks)
  end subroutine by_force

  !> From the end of a part of a load step to its beginning.
  subroutine go_back(self, solver, scene, drive, i, error)
    type(gradient_t), intent(inout) :: self           !< stations
    class(linear_solver_t), intent(inout) :: solver   !< of the run
    type(scene_t), intent(in) :: scene                !< of the run
    type(drive_t), intent(inout) :: drive             !< its drive
    integer, intent(in) :: i                          !< station
    type(error_t), allocatable, intent(out) :: error  !< linear solver
    type(adjoint_t) :: adjoint
    type(ahead_t) :: ahead
    type(load_t) :: load
    type(state_t) :: next
    type(sharing_t) :: sharing
    integer, allocatable :: list(:)
    real(dp), allocatable :: force(:)
    real(dp), allocatable, dimension(:, :) :: pressed, bare, left_u, left_c, near
    real(dp), allocatable, dimension(:, :, :) :: by_u, by_t, dw, dt, lambda, later, rho, slope
    integer :: j, k, struts
    associate (s => self%station(i)%state, before => self%station(i - 1)%state, place => self%station(i)%place, &
      problem => drive%problem)
      self%result%begun = self%result%begun .or. self%result%station == i .or. any(abs(self%by_turn(i:i, :)) > 0, 1)
      list = pack([(k, k=1, size(self%result))], self%result%begun)
      if (size(list) == 0) return
      call drive_load(drive, assembly_at(scene, place), torque_at(scene, place), step_friction(scene, under_torque(scene, place)), &
        load, before)
      problem%wheel_turns = scene%support%turns_bottom .and. under_torque(scene, place) .and. &
        any([(abs(torque_at(scene, self%station(j)%place)) > 0, j=1, i)])  ! in the play of the teeth it is left where it is
      call begin_adjoint(solver, size(list), problem, load, before, error)
      if (allocated(error)) return
      next = s
      call linear_equations(problem, load, before, next, left_c, dw, dt)
      call share_law(problem, solver%symmetry, sharing)
      call sharing%take_law(dw, dt)
      call sum_forces(problem, load, s, pressed, bare, left_u)
      call update_struts(problem, load, s%u)
      ahead%at_rest = .true.
      call count_ahead(problem, load, s%u, any(s%contact == stick_state), ahead, left_u)  ! flanks that just touch hold
      call adjoint%take(problem%law%scale, dw, dt)
      call solver%update(problem, adjoint%w, adjoint%t, error)
      struts = 0
      if (allocated(problem%struts)) struts = size(problem%struts)
      allocate (lambda(3, problem%n, size(list)), rho(3, problem%mortar%n, size(list)), near(struts, size(list)))
      call by_history(problem, load, before, next, left_c, slope)
      allocate (by_u(3, problem%n, size(list)), by_t(3, problem%mortar%n, size(list)), later(2, problem%mortar%n, size(list)))
      do k = 1, size(list)
        associate (r => self%result(list(k)))
          by_u(:, :, k) = 0
          if (abs(self%by_turn(i, list(k))) > 0) by_u(:, :, k) = self%by_turn(i, list(k))*drive%gauge
          by_t(:, :, k) = r%held
          if (r%station == i) then
            by_u(:, :, k) = by_u(:, :, k) + r%by_u
            by_t(:, :, k) = by_t(:, :, k) + r%by_t
            if (allocated(r%by_touch) .and. size(before%touch) > 0) r%touch = r%touch + r%by_touch
          end if
          if (size(s%touch) > size(before%touch)) then
            do j = 1, drive%flanks
              call push(problem%struts(drive%balls + j), -r%touch(j), by_u(:, :, k))
            end do
          end if
          later(:, :, k) = r%later
        end associate
      end do
      if (.not. allocated(error)) call adjoint%solve(problem, solver, by_u, by_t, later, self%result(list)%station == i, lambda, &
        rho, error)
      if (allocated(error)) return
      do k = 1, size(list)
        associate (r => self%result(list(k)))
          r%later = later(:, :, k)
          do j = 1, 3
            r%held(j, :) = -sum(rho(:, :, k)*slope(:, :, j), 1)
          end do
          near(:, k) = [(closing_of(problem%struts(j), lambda(:, :, k)), j=1, struts)]
          if (size(before%touch) > 0) then
            force = linear_forces(problem, near(:, k))
            r%touch = r%touch - force(drive%balls + 1:drive%balls + drive%flanks)
          end if
        end associate
      end do
      call add_keys(self, drive, i, list, load, pressed, bare, left_u, left_c, dw, lambda, rho, near)
    end associate
  end subroutine go_back

  !> Out-of-balance forces, and those of contact and bodies among them.
  subroutine sum_forces(problem, load, state, pressed, bare, left)
    type(problem_t), intent(in) :: problem         !< problem
    type(load_t), intent(in) :: load               !< of the step
    type(state_t), intent(in) :: state             !< at its end
    real(dp), allocatable, intent(out) :: pressed(:, :)           !< of the contact (3, n) [N]
    real(dp), allocatable, intent(out) :: bare(:, :), left(:, :)  !< without loads and struts, and all (3, n) [N]
    real(dp), allocatable :: force(:)
    integer :: i
    allocate (bare, mold=state%u)
    call elastic_forces(problem, state%u, bare)
    allocate (pressed, source=0*bare)
    call add_nodal_forces(problem%mortar, state%traction, pressed, factor=-1._dp)
    bare = bare + pressed
    left = bare - load%force
    if (.not. allocated(problem%struts)) return
    force = strut_forces(problem, load, state%u)
    do i = 1, size(force)
      if (abs(force(i)) > 0) call push(problem%struts(i), force(i), left)
    end do
  end subroutine sum_forces

  !> Derivatives of the law's residuals by the tractions before: shear leads, and a joint's grows from there, by what was left to
  !> the bound of the pressure before.
  subroutine by_history(problem, load, before, state, r_c, slope)
    type(problem_t), intent(in) :: problem         !< problem
    type(load_t), intent(in) :: load               !< of the step
    type(state_t), intent(in) :: before            !< at its beginning
    type(state_t), intent(inout) :: state          !< at its end
    real(dp), intent(in) :: r_c(:, :)              !< residuals there (3, points) [Pa]
    real(dp), allocatable, intent(out) :: slope(:, :, :)  !< (3, points, components of the traction)
    type(state_t) :: moved
    real(dp), allocatable :: r(:, :), dw(:, :, :), dt(:, :, :), step(:)
    integer :: c
    allocate (slope(3, size(r_c, 2), 3), source=0._dp)
    moved%slip = before%slip
    moved%contact = before%contact
    do c = 1, 3
      if (c == 1 .and. .not. allocated(problem%law%joint)) cycle
      step = share_of_state*merge(abs(before%traction(1, :)), norm2(before%traction(2:, :), 1), c == 1)
      if (.not. any(step > 0)) cycle
      moved%traction = before%traction
      moved%traction(c, :) = moved%traction(c, :) + step
      call linear_equations(problem, load, moved, state, r, dw, dt)
      slope(:, :, c) = (r - r_c)/spread(max(step, tiny(1._dp)), 1, 3)
    end do
  end subroutine by_history

  !> What the residuals of all keys at a station change of the results.
  subroutine add_keys(self, drive, i, list, load, pressed, bare, left_u, left_c, dw, lambda, rho, near)
    type(gradient_t), intent(inout) :: self           !< gets value
    type(drive_t), intent(inout) :: drive             !< of the run
    integer, intent(in) :: i                          !< station
    integer, intent(in) :: list(:)                    !< results
    type(load_t), intent(in) :: load                  !< there
    real(dp), intent(in) :: pressed(:, :), bare(:, :)          !< forces of the contact, and with those of its bodies (3, n) [N]
    real(dp), intent(in) :: left_u(:, :), left_c(:, :)         !< residuals of the run (3, n), (3, points)
    real(dp), intent(in) :: dw(:, :, :)               !< derivatives of its law (3, 3, points) [Pa/m]
    real(dp), intent(in) :: lambda(:, :, :), rho(:, :, :)      !< by residuals (3, n, list), (3, points, list)
    real(dp), intent(in) :: near(:, :)                !< closings of the struts by lambda (struts, list)
    real(dp), allocatable :: r_u(:, :, :), r_c(:, :, :), force(:), pushed(:, :)
    integer, allocatable :: whole(:)
    type(load_t) :: other
    type(state_t) :: met
    integer :: j, k
    associate (s => self%station(i)%state, before => self%station(i - 1)%state, place => self%station(i)%place, &
      problem => drive%problem)
      whole = pack([(k, k=1, self%keys)], self%of(:self%keys)%whole)
      allocate (r_u(3, problem%n, size(whole)), r_c(3, problem%mortar%n, self%keys), pushed(size(near, 1), self%keys))
      r_c = 0
      pushed = 0
      if (allocated(problem%struts)) force = forces_of(problem, [problem%strut_rate], load, s%u)
      !$omp parallel do schedule(dynamic)
      do j = 1, size(whole)
        call change_residuals(self%of(whole(j)), drive, place, load, before, s, pressed, bare, dw, r_u(:, :, j), &
          r_c(:, :, whole(j)))
      end do
      !$omp end parallel do
      do k = 1, self%keys
        associate (c => self%of(k))
          if (c%idle) cycle
          if (c%struts .and. .not. c%whole) then
            call strut_load(c%drive, assembly_at(c%scene, place), other, before)
            c%drive%problem%wheel_turns = problem%wheel_turns
            pushed(:, k) = forces_of(c%drive%problem, problem%strut_rate, other, s%u) - force
          end if
          if (c%law) call change_law(c, problem, place, load, before, s, left_c, r_c(:, :, k))
        end associate
      end do
      call subtract(size(left_u), whole, r_u, lambda)
      do j = 1, size(list)
        self%value(whole, list(j)) = self%value(whole, list(j)) + sum(left_u*lambda(:, :, j))
      end do
      call subtract(size(left_c), [(k, k=1, self%keys)], r_c, rho)
      call subtract(size(near, 1), [(k, k=1, self%keys)], pushed, near)
      if (.not. size(s%touch) > size(before%touch)) return
      do k = 1, self%keys
        if (self%of(k)%idle) cycle
        met = s
        call touch_teeth(self%of(k)%scene, self%of(k)%drive, s%u, met)
        do j = 1, size(list)
          self%value(k, list(j)) = self%value(k, list(j)) + dot_product(self%result(list(j))%touch, met%touch - s%touch)
        end do
      end do
    end associate
  contains
    !> Products of residuals and what results change by them.
    subroutine subtract(n, keys, r, by)
      integer, intent(in) :: n                     !< residuals
      integer, intent(in) :: keys(:)               !< numbers of the keys
      real(dp), intent(in) :: r(n, size(keys)), by(n, size(list))
      real(dp) :: product(size(keys), size(list))
      if (size(r) == 0) return
      call dgemm('T', 'N', size(keys), size(list), n, 1._dp, r, n, by, n, 0._dp, product, size(keys))
      self%value(keys, list) = self%value(keys, list) - product
    end subroutine subtract
  end subroutine add_keys
end module hd_gradient
