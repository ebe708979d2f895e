! SPDX-License-Identifier: GPL-3.0-or-later
!> The turning wave generator of the whole drive: the drive is pressed on and loaded anew at places of a turn, balls and teeth
!> standing where rolling and mesh have brought them; stiffness and angle over the turn follow.
!>
!> Everything is seen from the wave generator, whose long axis stays. If it turns by phi against the circular spline, the
!> flexspline, with z teeth against z + 2, and the ring that it carries turn by -phi (z + 2)/z. Balls that roll without slip between
!> an inner race that stands and an outer one of radius R take the cage along by R/(2 R - d) of that, d their diameter.
!> The bodies are round: only their points of support move, and the compliance by harmonics stays.
module hd_turning
  use hd_kinds, only: dp, pi
  use hd_drive, only: touch_teeth
  use hd_error, only: error_t, raise
  use hd_load_step, only: solve_step
  use hd_log, only: say, set_log_level, quiet
  use hd_model_cache, only: keep_model, take_model
  use hd_clock, only: wall_seconds
  use hd_race, only: race_radius
  use hd_run, only: run_t, new_run
  use hd_scene, only: scene_t
  use hd_table, only: table_t
  use hd_text, only: to_text
  implicit none
  private
  public :: advance

contains

  !> Solve the next load step of a run; after the last one the wave generator turns, where the scene asks for it.
  subroutine advance(run, done, error)
    type(run_t), intent(inout) :: run                 !< run
    logical, intent(out) :: done                      !< nothing is left
    type(error_t), allocatable, intent(out) :: error  !< of a load step, at one of the places, files
    call solve_step(run, done, error)
    if (allocated(error) .or. .not. done .or. run%scene%support /= 'drive' .or. run%scene%turning_positions == 0) return
    call turn_wave_generator(run, error)
    if (allocated(error)) run%failure = error
  end subroutine advance

  !> Solve all places: first the assemblies, for teeth fit the mean of them, then the torque.
  subroutine turn_wave_generator(run, error)
    type(run_t), intent(inout) :: run                 !< loop that is over; gets the record of its turn
    type(error_t), allocatable, intent(out) :: error  !< not converged, stopped, files
    type(run_t), allocatable :: places(:)
    type(error_t), allocatable :: trouble
    type(table_t) :: rows
    real(dp), allocatable :: mean(:, :)
    real(dp) :: start
    integer :: i, level, inner
    logical :: kept
    start = wall_seconds()
    inner = run%solver%inner
    allocate (places(run%scene%turning_positions))
    if (run%writes) call rows%open(run%output%folder//'/turning.csv', 'position,wave_generator_deg,cage_angle_deg,tooth_phase,'// &
      'turn_rad,stiffness_nm_per_rad,wave_generator_torque_nm,ball_force_max_n,tooth_force_max_n,balls_loaded,pairs_loaded', error)
    if (allocated(error)) return
    call keep_model(run%scene, run%drive, run%solver, run%assembly, run%record%choice)
    allocate (mean(3, size(run%state%u, 2)), source=0._dp)
    do i = 1, size(places)
      call set_log_level(quiet, level)
      call new_run(turned_scene(run%scene, angle_of(run%scene, i)), '', '', .false., places(i), error)
      places(i)%clock = run%clock
      places(i)%tangent_from = huge(1._dp)
      if (.not. allocated(error)) call solve_to(places(i), 1._dp, error)
      call set_log_level(level)
      if (allocated(error)) exit
      mean = mean + places(i)%state%u/size(places)
      call put_away(places(i))
    end do
    do i = 1, size(places)
      if (allocated(error)) exit
      call load_place(places(i), mean, error)
      if (.not. allocated(error)) call book_place(run, places(i), i, rows, error)
      call put_away(places(i))
    end do
    call rows%close()
    call take_model(run%scene, run%drive, run%solver, run%assembly, kept, run%record%choice, trouble)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
    run%solver%inner = inner
    run%record%timers%turning = wall_seconds() - start
    if (allocated(error)) error%message = 'where the wave generator has turned by '//to_text(angle_of(run%scene, min(i, &
      size(places)))*180/pi)//' degrees: '//error%message
  end subroutine turn_wave_generator

  !> Turn of the wave generator at a place [rad].
  pure real(dp) function angle_of(scene, place) result(angle)
    type(scene_t), intent(in) :: scene  !< scene
    integer, intent(in) :: place        !< from 1
    angle = scene%turning_range_deg*pi/180
    if (.not. angle > 0) angle = merge(2*pi/max(1, scene%balls)/cage_share(scene), 2*pi/scene%teeth, scene%balls > 0)/ &
      flexspline_share(scene)
    angle = angle*(place - 1)/scene%turning_positions
  end function angle_of

  !> Turn of the flexspline over that of the wave generator against the circular spline, seen from the wave generator, backwards.
  pure real(dp) function flexspline_share(scene)
    type(scene_t), intent(in) :: scene  !< scene
    flexspline_share = real(scene%teeth + 2, dp)/scene%teeth
  end function flexspline_share

  !> Turn of the cage over that of the outer race, where balls roll and the inner race stands.
  pure real(dp) function cage_share(scene)
    type(scene_t), intent(in) :: scene  !< scene
    associate (outer => race_radius(scene))
      cage_share = outer/(2*outer - scene%ball_diameter)
    end associate
  end function cage_share

  !> The drive where the wave generator has turned; the torque comes in two steps.
  pure type(scene_t) function turned_scene(scene, angle) result(s)
    type(scene_t), intent(in) :: scene   !< scene
    real(dp), intent(in) :: angle        !< [rad]
    real(dp) :: turned
    s = scene
    turned = -angle*flexspline_share(scene)
    s%cage_angle_deg = modulo(s%cage_angle_deg + turned*cage_share(scene)*180/pi, 360._dp)
    s%tooth_phase = s%tooth_phase + turned*scene%teeth/(2*pi)
    s%tooth_phase = s%tooth_phase - anint(s%tooth_phase)
    s%torque_count = 1
    s%torques(1) = merge(scene%turning_torque, scene%rated_torque, abs(scene%turning_torque) > 0)
    s%torque = s%torques(1)
    s%torque_steps = 2
    s%start = 'rest'
  end function turned_scene

  !> Solve load steps up to a position.
  subroutine solve_to(place, position, error)
    type(run_t), intent(inout) :: place               !< run of a place
    real(dp), intent(in) :: position                  !< 1 assembled, 2 loaded
    type(error_t), allocatable, intent(out) :: error  !< not converged, stopped
    logical :: done
    do while (place%position < position - 1e-12_dp .and. .not. allocated(error))
      call solve_step(place, done, error)
    end do
  end subroutine solve_to

  !> Leave the model to the next place.
  subroutine put_away(place)
    type(run_t), intent(inout) :: place  !< loses drive, solver
    if (allocated(place%drive)) call keep_model(place%scene, place%drive, place%solver, place%assembly, place%record%choice)
    if (allocated(place%assembly%state)) deallocate (place%assembly%place, place%assembly%state)
    if (allocated(place%drive)) deallocate (place%drive)
  end subroutine put_away

  !> Torque on an assembled place. Its teeth have the gaps of the mean assembly: the circular spline knows no balls.
  subroutine load_place(place, mean, error)
    type(run_t), intent(inout) :: place               !< assembled run
    real(dp), intent(in) :: mean(:, :)                !< displacements (3, n) [m]
    type(error_t), allocatable, intent(out) :: error  !< not converged, stopped
    logical :: kept
    integer :: level
    call take_model(place%scene, place%drive, place%solver, place%assembly, kept, place%record%choice, error)
    if (allocated(error)) return
    call touch_teeth(place%scene, place%drive, mean, place%state)
    call set_log_level(quiet, level)
    call solve_to(place, 2._dp, error)
    call set_log_level(level)
  end subroutine load_place

  !> Row of a place, and what the record keeps of it.
  subroutine book_place(run, place, i, rows, error)
    type(run_t), intent(inout) :: run                 !< gets angle and stiffness in its loop
    type(run_t), intent(in) :: place                  !< loaded place
    integer, intent(in) :: i                          !< its number
    type(table_t), intent(inout) :: rows              !< turning.csv
    type(error_t), allocatable, intent(out) :: error  !< disk full
    real(dp) :: stiffness
    associate (loop => place%loop, scene => place%scene)
      stiffness = (loop%torque(3) - loop%torque(2))/(loop%angle(3) - loop%angle(2))
      if (i == 1) allocate (run%loop%turned_angle(0), run%loop%turned_stiffness(0))
      run%loop%turned_angle = [run%loop%turned_angle, loop%angle(3)]
      run%loop%turned_stiffness = [run%loop%turned_stiffness, stiffness]
      call say('turned    '//to_text(angle_of(run%scene, i)*180/pi)//' degrees: '//to_text(loop%angle(3))//' rad, '// &
        to_text(stiffness)//' N m/rad at '//to_text(scene%torque)//' N m')
      if (.not. run%writes) return
      call rows%add(i)
      call rows%add(angle_of(run%scene, i)*180/pi)
      call rows%add(scene%cage_angle_deg)
      call rows%add(scene%tooth_phase)
      call rows%add(loop%angle(3))
      call rows%add(stiffness)
      call rows%add(loop%wave_generator_torque)
      call rows%add(maxval([0._dp, loop%force(:scene%balls)]))
      call rows%add(maxval(loop%force(scene%balls + 1:scene%balls + 2*scene%tooth_pairs)))
      call rows%add(count(loop%force(:scene%balls) > 0))
      call rows%add(count(loop%force(scene%balls + 1:scene%balls + 2*scene%tooth_pairs) > 0))
      call rows%end_row(error)
    end associate
  end subroutine book_place
end module hd_turning
