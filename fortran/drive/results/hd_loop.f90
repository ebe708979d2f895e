! SPDX-License-Identifier: GPL-3.0-or-later
!> The torsion loop of the whole drive: angle over torque, work, energy and friction, loads of balls and teeth, and what a catalogue
!> reads from it.
module hd_loop
  use hd_kinds, only: dp, pi
  use hd_ball_bearing, only: ball_angles
  use hd_contact_law, only: slip_state
  use hd_drive, only: drive_t
  use hd_error, only: error_t
  use hd_fatigue, only: fatigue_t
  use hd_output, only: output_t, step_t, add_place
  use hd_energy, only: stored_energy
  use hd_problem, only: state_t, load_t, forces_at, strut_closings
  use hd_scene, only: scene_t
  use hd_tabulated_law, only: closure_table_t, stiffness_at_pressure
  use hd_balance, only: moment_on_cam, strut_moment
  use hd_text, only: rounded, to_text
  use hd_tooth_flanks, only: tooth_angles, tooth_gaps, turn_to_flank
  implicit none
  private
  public :: loop_t, readings_t, book, engaged, no_force, read_loop, first_sense, lost_at, loop_text, write_loop, bottom_turn, &
    store_loop, recall_loop

  !> A ball that comes or goes between two steps.
  type :: jump_t
    real(dp) :: force = 0                  !< what it carries on one side of the jump [N]
    integer :: ball = 0                    !< its number
    real(dp) :: before = 0, after = 0      !< torques of both steps [N m]
  end type jump_t

  !> Every booked step.
  type :: loop_t
    real(dp), allocatable :: torque(:), angle(:)          !< [N m], [rad]
    real(dp) :: work = 0                                  !< of the torque since the assembly [J]
    real(dp) :: dissipated = 0                            !< by friction since the assembly [J],
    real(dp) :: dissipated_contact = 0, dissipated_teeth = 0  !< of which by contact and flanks [J]
    real(dp) :: stored = 0, stored_assembled = 0          !< energy of bodies, balls, teeth and joint [J]
    real(dp) :: joint = 0                                 !< of that what a rough joint took since the assembly [J]
    real(dp) :: wave_generator_torque = 0                 !< that it takes, at the last step [N m]
    real(dp) :: wave_generator_torque_max = 0             !< largest amount of all steps [N m]
    real(dp) :: ball_force_max = 0, tooth_force_max = 0   !< of all steps [N]
    real(dp) :: lift = 0                                  !< way of a loaded pair of teeth out of mesh since the assembly [m]
    logical :: unloaded = .false.                         !< at some step no ball carried anything
    real(dp) :: play = 0                                  !< free turn of the bottom where no pair of teeth pushes [rad]
    type(jump_t) :: jump                                  !< the largest
    real(dp), allocatable :: turned_angle(:)              !< of the bottom at places of the turning wave generator [rad]
    real(dp), allocatable :: turned_stiffness(:)          !< there, from half to all of the torque [N m/rad]
    type(fatigue_t) :: fatigue                            !< of the flexspline
    real(dp), allocatable :: force(:), closing(:)         !< of all struts at the last step [N], [m]
    real(dp), allocatable :: flank_moment(:)              !< of the flanks on the rim, friction included, at the last step [N m]
    real(dp), allocatable, private :: traction(:, :), slip(:, :), gap(:)   !< at the last step
    integer, allocatable, private :: contact(:)                    !< state of the points there
  end type loop_t

  !> What a catalogue states; 0 where the torques do not reach it.
  type :: readings_t
    real(dp) :: k(3) = 0             !< K1, K2, K3 [N m/rad]
    real(dp) :: hysteresis = 0       !< width of the loop at no torque [rad]
    real(dp) :: lost_motion = 0      !< turn of the loop's middle between -4 and 4 % of the rated torque [rad]
    real(dp) :: top = 0              !< amount of the torque at which the rise ends [N m]
    logical :: has_hysteresis = .false., has_lost_motion = .false.
  end type readings_t

  real(dp), parameter :: no_torque = 1e-9_dp !< share of the largest torque that is none
  real(dp), parameter :: no_force = 1e-6_dp  !< share of the largest force of a flank so far that is none
  real(dp), parameter :: lost_at = 0.04_dp   !< share of the rated torque, either way, at which catalogues read lost motion

contains

  !> Book a converged step. A point that slips works with its shear: the mean of both ends of the step, or where it stuck at the
  !> beginning, or slips back, that of the end, for before that it does not move.
  subroutine book(loop, scene, drive, load, state, step)
    type(loop_t), intent(inout) :: loop     !< grows
    type(scene_t), intent(in) :: scene      !< scene
    type(drive_t), intent(in) :: drive      !< its model
    type(load_t), intent(in) :: load        !< load of the step
    type(state_t), intent(in) :: state      !< converged state
    type(step_t), intent(in) :: step        !< where it stands
    real(dp) :: angle, shear(2), given(2)
    real(dp), allocatable :: force(:), closing(:)
    integer :: i, n
    associate (problem => drive%problem, flanks => [(drive%balls + i, i=1, drive%flanks)])
      closing = strut_closings(problem, load, state%u)
      force = forces_at(problem, load, closing)
      if (step%loaded) then
        loop%jump = larger_jump(loop, force(:drive%balls), step%torque)
        i = size(loop%torque)
        angle = bottom_turn(drive, state)
        loop%work = loop%work + (loop%torque(i) + step%torque)/2*loaded_turn(scene, angle - loop%angle(i), &
          abs([loop%torque(i), step%torque]) <= no_torque*maxval(abs([loop%torque, step%torque])), loop%closing(flanks), &
          closing(flanks))
      end if
      loop%closing = closing
      loop%force = force
      n = drive%balls
      loop%wave_generator_torque = moment_on_cam(drive, load, state, force)
      loop%flank_moment = [(strut_moment(drive, state, i, force(i), drive%b_cup), i=n + 1, n + drive%flanks)]
      if (allocated(problem%rub)) loop%flank_moment = loop%flank_moment + &
        [(strut_moment(drive, state, i, force(i), drive%b_cup), i=n + drive%flanks + drive%stays + 1, size(force))]
      if (.not. step%loaded) then
        loop%torque = [0._dp]
        loop%angle = [0._dp]
      else
        do i = 1, problem%mortar%n - problem%mortar%rigid
          shear = state%traction(2:, i)
          if (loop%contact(i) == slip_state .and. dot_product(loop%traction(2:, i), state%slip(:, i) - loop%slip(:, i)) < 0) then
            shear = (shear + loop%traction(2:, i))/2
          end if
          given = 0
          if (allocated(problem%law%joint)) call give_way(problem%law%joint, problem%mortar%area(i), loop%traction(:, i), &
            state%traction(:, i), [loop%gap(i), state%gap(i)], given, loop%joint)
          loop%dissipated_contact = loop%dissipated_contact - &
            problem%mortar%area(i)*dot_product(shear, state%slip(:, i) - loop%slip(:, i) + given)
        end do
        loop%dissipated_teeth = sum(state%past(4, :))
        loop%dissipated = loop%dissipated_contact + loop%dissipated_teeth
        loop%torque = [loop%torque, step%torque]
        loop%angle = [loop%angle, angle]
      end if
      loop%stored = stored_energy(problem, load, state%u) + loop%joint
      if (.not. step%loaded) loop%stored_assembled = loop%stored
      loop%traction = state%traction
      loop%slip = state%slip
      loop%gap = state%gap
      loop%contact = state%contact
      loop%wave_generator_torque_max = max(loop%wave_generator_torque_max, abs(loop%wave_generator_torque))
      if (n > 0) loop%ball_force_max = max(loop%ball_force_max, maxval(loop%force(:n)))
      loop%tooth_force_max = max(loop%tooth_force_max, maxval(loop%force(flanks)))
      if (n > 0 .and. step%load_factor > 0) loop%unloaded = loop%unloaded .or. .not. any(loop%force(:n) > 0)
      if (.not. step%loaded) return
      loop%lift = max(loop%lift, lifted(scene, loop%force(flanks), loop%closing(flanks)))
      loop%play = max(loop%play, free_turn(scene, loop%force(flanks), loop%closing(flanks), loop%tooth_force_max))
    end associate
  end subroutine book

  !> Way that a point of a rough joint gives way along its shear in a step, without slip, and the energy that it takes. It is as
  !> stiff as at the larger pressure: where the pressure falls to nothing, the shear gives back what it took, not more.
  pure subroutine give_way(joint, area, before, traction, gap, way, energy)
    type(closure_table_t), intent(in) :: joint     !< law
    real(dp), intent(in) :: area                   !< of the point [m^2]
    real(dp), intent(in) :: before(3), traction(3) !< at both ends of the step [Pa]
    real(dp), intent(in) :: gap(2)                 !< likewise [m]
    real(dp), intent(out) :: way(2)                !< [m]
    real(dp), intent(inout) :: energy              !< grows [J]
    real(dp) :: stiffness, slope, touching(2)
    way = 0
    if (.not. max(before(1), traction(1)) > 0) return
    call stiffness_at_pressure(joint, max(before(1), traction(1)), stiffness, slope)
    way = (traction(2:) - before(2:))/stiffness
    touching = min(gap, -joint%start)
    energy = energy + area*(dot_product(before(2:) + traction(2:), way) - (before(1) + traction(1))*(touching(2) - touching(1)))/2
  end subroutine give_way

  !> Write what a resumed run goes on from.
  subroutine store_loop(loop, unit, status)
    type(loop_t), intent(in) :: loop   !< booked steps
    integer, intent(in) :: unit        !< unformatted file
    integer, intent(out) :: status     !< 0: written
    real(dp), allocatable :: life(:, :)
    allocate (life(0, 3))
    if (allocated(loop%fatigue%safety)) life = reshape([loop%fatigue%mean, loop%fatigue%amplitude, loop%fatigue%safety], &
      [size(loop%fatigue%safety), 3])
    write (unit, iostat=status) size(loop%torque), size(loop%force), size(life, 1)
    if (status == 0) write (unit, iostat=status) loop%torque, loop%angle, loop%force, loop%closing, loop%work, loop%dissipated, &
      loop%dissipated_contact, loop%dissipated_teeth, &
      loop%stored, loop%stored_assembled, loop%wave_generator_torque, loop%wave_generator_torque_max, loop%ball_force_max, &
      loop%tooth_force_max, loop%joint, loop%lift, loop%play, loop%jump, loop%unloaded, loop%fatigue%torque, life
  end subroutine store_loop

  !> Read it back; the last booked step is that of a state.
  subroutine recall_loop(loop, unit, state, status)
    type(loop_t), intent(inout) :: loop  !< booked steps
    integer, intent(in) :: unit          !< unformatted file
    type(state_t), intent(in) :: state   !< last converged state
    integer, intent(out) :: status       !< 0: read
    real(dp), allocatable :: life(:, :)
    integer :: steps, struts, nodes
    read (unit, iostat=status) steps, struts, nodes
    if (status /= 0) return
    allocate (loop%torque(steps), loop%angle(steps), loop%force(struts), loop%closing(struts), life(nodes, 3))
    read (unit, iostat=status) loop%torque, loop%angle, loop%force, loop%closing, loop%work, loop%dissipated, &
      loop%dissipated_contact, loop%dissipated_teeth, &
      loop%stored, loop%stored_assembled, loop%wave_generator_torque, loop%wave_generator_torque_max, loop%ball_force_max, &
      loop%tooth_force_max, loop%joint, loop%lift, loop%play, loop%jump, loop%unloaded, loop%fatigue%torque, life
    if (status /= 0) return
    if (nodes > 0) then
      loop%fatigue%mean = life(:, 1)
      loop%fatigue%amplitude = life(:, 2)
      loop%fatigue%safety = life(:, 3)
    end if
    loop%traction = state%traction
    loop%slip = state%slip
    loop%gap = state%gap
    loop%contact = state%contact
  end subroutine recall_loop

  !> Largest way out of mesh, towards the axis, of a pair that pushes: the mean of its flanks' closings sees the radial way
  !> alone [m].
  pure real(dp) function lifted(scene, force, closing) result(lift)
    type(scene_t), intent(in) :: scene               !< scene
    real(dp), intent(in) :: force(:), closing(:)     !< of the flanks [N], [m]
    real(dp) :: way(scene%tooth_pairs)
    way = (closing(1::2) + closing(2::2))/2 + tooth_gaps(scene)
    lift = 0
    if (scene%pressure_angle_deg > 1) lift = max(0._dp, maxval(-way, mask=force(1::2) + force(2::2) > 0))/ &
      sin(scene%pressure_angle_deg*pi/180)
  end function lifted

  !> A pair of teeth pushes at the last step: else the bottom turns freely, and a stiffness there is one of rounding.
  pure logical function engaged(loop, drive)
    type(loop_t), intent(in) :: loop    !< booked steps
    type(drive_t), intent(in) :: drive  !< its model
    engaged = any(loop%force(drive%balls + 1:drive%balls + drive%flanks) > no_force*loop%tooth_force_max)
  end function engaged

  !> Turn by which the bottom is free where no pair of teeth pushes, 0 where one does: the ways to the nearest flanks of both
  !> sides [rad].
  pure real(dp) function free_turn(scene, force, closing, most) result(play)
    type(scene_t), intent(in) :: scene               !< scene
    real(dp), intent(in) :: force(:), closing(:)     !< of the flanks [N], [m]
    real(dp), intent(in) :: most                     !< largest force of a flank so far [N]
    play = 0
    if (.not. maxval(force) > no_force*most) play = turn_to_flank(scene, closing(1::2)) + turn_to_flank(scene, closing(2::2))
  end function free_turn

  !> Part of a step's turn under torque: all but the way to the flanks that it nears from a step without torque, or from those that
  !> it leaves to one [rad].
  pure real(dp) function loaded_turn(scene, turn, free, before, after) result(loaded)
    type(scene_t), intent(in) :: scene              !< scene
    real(dp), intent(in) :: turn                    !< of the bottom [rad]
    logical, intent(in) :: free(2)                  !< there is no torque before, after
    real(dp), intent(in) :: before(:), after(:)     !< closings of the flanks [m]
    integer :: nears
    nears = merge(1, 2, turn > 0)
    loaded = abs(turn)
    if (free(1)) loaded = loaded - max(0._dp, turn_to_flank(scene, before(nears::2)))
    if (free(2)) loaded = loaded - max(0._dp, turn_to_flank(scene, after(3 - nears::2)))
    loaded = sign(max(0._dp, loaded), turn)
  end function loaded_turn

  !> The ball that comes or goes with the largest force, in this step or in one before.
  pure function larger_jump(loop, force, torque) result(jump)
    type(loop_t), intent(in) :: loop      !< booked steps
    real(dp), intent(in) :: force(:)      !< of the balls now [N]
    real(dp), intent(in) :: torque        !< now [N m]
    type(jump_t) :: jump
    integer :: i
    jump = loop%jump
    do i = 1, size(force)
      if (force(i) > 0 .and. loop%force(i) > 0) cycle
      if (force(i) + loop%force(i) > jump%force) jump = jump_t(force(i) + loop%force(i), i, loop%torque(size(loop%torque)), torque)
    end do
  end function larger_jump

  !> Turn of the cup's bottom since the assembly [rad].
  pure real(dp) function bottom_turn(drive, state) result(angle)
    type(drive_t), intent(in) :: drive  !< model
    type(state_t), intent(in) :: state  !< state
    angle = sum(state%u(2, drive%hub))/size(drive%hub)/drive%hub_radius
  end function bottom_turn

  !> What a catalogue reads: chords of a rise, the last one through no torque or the first one, width at no torque and lost motion,
  !> both of the last branches after the first rise where the loop closes.
  pure type(readings_t) function read_loop(loop, scene) result(r)
    type(loop_t), intent(in) :: loop    !< booked steps
    type(scene_t), intent(in) :: scene  !< T1, T2, rated torque
    real(dp), allocatable :: torque(:), angle(:)
    logical, allocatable :: last_of_equals(:)
    real(dp) :: place(4), turn(4), sense
    integer :: i, first, last, top
    if (.not. allocated(loop%torque)) return
    last_of_equals = [abs(loop%torque(2:) - loop%torque(:size(loop%torque) - 1)) > 0, .true.]
    torque = pack(loop%torque, last_of_equals)
    angle = pack(loop%angle, last_of_equals)
    if (size(torque) < 2) return
    if (scene%half_loop) call mirror(torque, angle)
    sense = first_sense(torque)
    call find_rise(sense*torque, .false., first, last)
    top = last
    if (scene%history == 'loop') call find_rise(sense*torque, .true., first, last)
    r%top = sense*torque(last)
    place = [0._dp, scene%torque_1, scene%torque_2, r%top]
    do i = 1, 4
      turn(i) = sense*between(sense*torque(first:last), angle(first:last), min(place(i), place(4)))
    end do
    do i = 1, 3
      if (place(i + 1) > place(i) .and. place(4) > place(i) .and. turn(i + 1) > turn(i)) then
        r%k(i) = (min(place(i + 1), place(4)) - place(i))/(turn(i + 1) - turn(i))
      end if
    end do
    r%has_hysteresis = passes(torque, top, 0._dp)
    if (r%has_hysteresis) r%hysteresis = abs(branch(torque, angle, top, 0._dp, -1) - branch(torque, angle, top, 0._dp, 1))
    associate (small => lost_at*scene%rated_torque)
      if (.not. (passes(torque, top, small) .and. passes(torque, top, -small))) top = 1  ! the loop does not close
      r%has_lost_motion = passes(torque, top, small) .and. passes(torque, top, -small)
      if (r%has_lost_motion) r%lost_motion = sum([(branch(torque, angle, top, small, i) - branch(torque, angle, top, -small, i), &
        i=-1, 1, 2)])/2
    end associate
  end function read_loop

  !> A loop that ends at the opposite torque goes on as the fall to there, mirrored.
  pure subroutine mirror(torque, angle)
    real(dp), allocatable, intent(inout) :: torque(:), angle(:)  !< of the steps, no two neighbours alike [N m], [rad]
    integer :: top
    top = maxloc(first_sense(torque)*torque, 1)
    if (.not. torque(size(torque))*torque(top) < 0) return
    angle = [angle, angle(top) + angle(size(angle)) - angle(top + 1:)]
    torque = [torque, -torque(top + 1:)]
  end subroutine mirror

  !> Sense of the first torque that is not 0.
  pure real(dp) function first_sense(torque) result(sense)
    real(dp), intent(in) :: torque(:)  !< [N m]
    sense = sign(1._dp, torque(max(1, findloc(abs(torque) > 0, .true., 1))))
  end function first_sense

  !> The first rise of the torque from 0, or the last one that passes it from below; where there is none the first.
  pure subroutine find_rise(torque, again, first, last)
    real(dp), intent(in) :: torque(:)       !< booked steps, rising first [N m]
    logical, intent(in) :: again            !< the last
    integer, intent(out) :: first, last     !< steps between which it rises
    integer :: low, high
    first = 1
    last = 1
    high = 1
    do while (high < size(torque))
      low = high
      do while (high < size(torque))
        if (.not. torque(high + 1) > torque(high)) exit
        high = high + 1
      end do
      if (low == 1) last = high
      if (again .and. high > low .and. torque(low) < 0 .and. torque(high) > 0) then
        first = low
        last = high
      end if
      if (low == 1 .and. .not. again) return
      high = max(high, low + merge(1, 0, high == low))
    end do
  end subroutine find_rise

  !> The torque passes a value falling and rising.
  pure logical function passes(torque, from, at)
    real(dp), intent(in) :: torque(:)  !< of the steps, no two neighbours alike [N m]
    integer, intent(in) :: from        !< first step that counts
    real(dp), intent(in) :: at         !< [N m]
    passes = min(last_pass(torque, from, at, -1), last_pass(torque, from, at, 1)) > 0
  end function passes

  !> Part of the way in which the torque passes a value in one sense for the last time, or ends there; 0 where it turns back before.
  pure integer function last_pass(torque, from, at, sense) result(i)
    real(dp), intent(in) :: torque(:)      !< of the steps, no two neighbours alike [N m]
    integer, intent(in) :: from            !< first step that counts
    real(dp), intent(in) :: at             !< [N m]
    integer, intent(in) :: sense           !< 1 rising, -1 falling
    do i = size(torque) - 1, from, -1
      if (sense*(torque(i + 1) - at) < 0 .or. sense*(at - torque(i)) < 0 .or. sense*(torque(i + 1) - torque(i)) <= 0) cycle
      if (i > from .and. .not. abs(torque(i) - at) > 0) cycle  ! counted with the part before
      if (abs(torque(i + 1) - at) > 0 .or. i + 2 > size(torque)) return
      if (sense*(torque(i + 2) - at) > 0) return
    end do
    i = 0
  end function last_pass

  !> The readings in a line of the log: those that the torques reach, with their bands where those are known.
  function loop_text(loop, scene, band) result(text)
    type(loop_t), intent(in) :: loop    !< booked steps
    type(scene_t), intent(in) :: scene  !< T1, T2, rated torque
    real(dp), intent(in), optional :: band(:, :)  !< lower and upper end over K1, K2, K3, hysteresis, lost motion
    character(len=:), allocatable :: text
    real(dp), parameter :: minutes = 180*60/pi  !< arc minutes per radian
    type(readings_t) :: r
    integer :: i
    r = read_loop(loop, scene)
    text = ''
    do i = 1, 3
      if (.not. r%k(i) > 0) cycle
      text = text//'K'//to_text(i)//' '//rounded(r%k(i))//ends(r%k(i), i)//', '
    end do
    if (len(text) > 0) text = text(:len(text) - 2)//' N m/rad'
    if (r%has_hysteresis) text = text//'; hysteresis '//rounded(r%hysteresis*minutes)//"'"//ends(r%hysteresis*minutes, 4)
    if (r%has_lost_motion) text = text//'; lost motion '//rounded(r%lost_motion*minutes)//"'"//ends(r%lost_motion*minutes, 5)
  contains
    !> The band of a reading.
    function ends(value, i)
      real(dp), intent(in) :: value  !< reading
      integer, intent(in) :: i       !< its place in the band
      character(len=:), allocatable :: ends
      ends = ''
      if (present(band) .and. value > 0) ends = ' ('//rounded(value*band(1, i))//' to '//rounded(value*band(2, i))//')'
    end function ends
  end function loop_text

  !> Linear interpolation in rising x.
  pure real(dp) function between(x, y, at) result(v)
    real(dp), intent(in) :: x(:), y(:), at  !< points, place
    integer :: i
    i = min(max(1, count(x <= at)), size(x) - 1)
    v = y(i) + (y(i + 1) - y(i))*(at - x(i))/(x(i + 1) - x(i))
  end function between

  !> Angle at which the torque passes a value in one sense for the last time [rad].
  pure real(dp) function branch(torque, angle, from, at, sense)
    real(dp), intent(in) :: torque(:), angle(:)  !< of the steps [N m], [rad]
    integer, intent(in) :: from                  !< first step that counts
    real(dp), intent(in) :: at                   !< that it passes [N m]
    integer, intent(in) :: sense                 !< 1 rising, -1 falling
    real(dp) :: share
    integer :: i
    i = last_pass(torque, from, at, sense)
    share = (at - torque(i))/(torque(i + 1) - torque(i))
    branch = (1 - share)*angle(i) + share*angle(i + 1)
  end function branch

  !> Rows of a booked step in loop.csv, balls.csv and teeth.csv.
  subroutine write_loop(output, step, scene, drive, loop, k_ts, shares, error)
    type(output_t), intent(inout) :: output           !< tables
    type(step_t), intent(in) :: step                  !< step
    type(scene_t), intent(in) :: scene                !< scene
    type(drive_t), intent(in) :: drive                !< its model
    type(loop_t), intent(in) :: loop                  !< booked
    real(dp), intent(in) :: k_ts                      !< of Eq. 45 [N m/rad]
    real(dp), intent(in) :: shares(:)                 !< of a further twist by part
    type(error_t), allocatable, intent(out) :: error  !< disk full
    real(dp) :: theta(scene%balls), axial(scene%balls), place(scene%tooth_pairs), row(9), rub(drive%flanks)
    integer :: i, n
    n = drive%balls
    axial = 0
    if (allocated(drive%problem%groove)) axial = loop%force(drive%problem%groove%before + 1:drive%problem%groove%before + n)
    rub = 0
    if (size(loop%force) > n + drive%flanks + drive%stays) rub = loop%force(n + drive%flanks + drive%stays + 1:)
    associate (teeth => merge(loop%force(n + 1:n + drive%flanks), 0._dp, &
        loop%force(n + 1:n + drive%flanks) > no_force*loop%tooth_force_max))
      call add_place(output%loop, step)
      row = [loop%angle(size(loop%angle)), loop%work, loop%stored - loop%stored_assembled, loop%dissipated, &
        loop%dissipated_teeth, loop%wave_generator_torque, largest(loop%force(:n)), largest(teeth), k_ts]
      do i = 1, size(row)
        call output%loop%add(row(i))
      end do
      call output%loop%add(count(loop%force(:n) > 0))
      call output%loop%add(count(teeth(1::2) + teeth(2::2) > 0))
      do i = 1, size(shares)
        call output%loop%add(shares(i))
      end do
      call output%loop%end_row(error)
      theta = ball_angles(scene)
      do i = 1, n
        if (allocated(error)) return
        call add_place(output%balls, step)
        call output%balls%add(i)
        call output%balls%add(theta(i))
        call output%balls%add(loop%force(i))
        call output%balls%add(loop%force(i)/max(sum(loop%force(:n)), tiny(1._dp)))
        call output%balls%add(loop%closing(i))
        call output%balls%add(axial(i))
        call output%balls%end_row(error)
      end do
      place = tooth_angles(scene)
      if (.not. step%loaded) return
      do i = 1, drive%flanks
        if (allocated(error)) return
        call add_place(output%teeth, step)
        call output%teeth%add((i + 1)/2)
        call output%teeth%add(modulo(place((i + 1)/2) + pi, 2*pi) - pi)
        call output%teeth%add(merge(1, -1, modulo(i, 2) == 1))
        call output%teeth%add(loop%force(n + i))
        call output%teeth%add(teeth(i)/max(sum(teeth), tiny(1._dp)))
        call output%teeth%add(loop%closing(n + i))
        call output%teeth%add(rub(i))
        call output%teeth%add(loop%flank_moment(i))
        call output%teeth%end_row(error)
      end do
    end associate
  end subroutine write_loop

  !> Largest of some forces, 0 of none.
  pure real(dp) function largest(force)
    real(dp), intent(in) :: force(:)  !< [N]
    largest = 0
    if (size(force) > 0) largest = maxval(force)
  end function largest
end module hd_loop
