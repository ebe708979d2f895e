! SPDX-License-Identifier: GPL-3.0-or-later
!> The march of a run along its load steps, with what hangs on it: first guesses from a march on a coarser mesh, and the marches
!> at the places of a turning wave generator.
module hd_march
  use hd_kinds, only: dp, pi
  use hd_coarse_start, only: has_coarser, coarser_scene
  use hd_drive, only: touch_teeth
  use hd_error, only: error_t, code_linear_solver, code_stopped
  use hd_load_step, only: solve_step
  use hd_load_path, only: place_t, operator(<), assembled, begins, path_end, step_end
  use hd_log, only: say, set_log_level, quiet
  use hd_model, only: hand_on
  use hd_run, only: run_t, new_run, fit_run, leave_model
  use hd_section, only: band_rows
  use hd_table, only: table_t
  use hd_system, only: stop_requested
  use hd_text, only: to_text
  use hd_timers, only: in_coarser, in_turning, outside
  use hd_turning, only: angle_of, turned_scene, open_places, book_place
  implicit none
  private
  public :: march

contains

  !> Solve load steps up to a place; at the end of the last one the wave generator turns, where the scene asks for it.
  recursive subroutine march(run, to, error)
    type(run_t), intent(inout) :: run                 !< run
    type(place_t), intent(in) :: to                   !< end of a load step; beyond the last one: that one
    type(error_t), allocatable, intent(out) :: error  !< not converged, gross slip, stopped, solver, files
    call run%record%timers%book(outside)
    do while (run%place < to .and. run%place < path_end(run%scene) .and. .not. allocated(error))
      if (run%attempts%left()) then
        run%tally%start = run%attempts%start
      else if (begins(run%scene, run%place) .and. has_coarser(run%scene) .and. .not. allocated(run%coarser)) then
        call solve_coarser(run)
      end if
      call solve_step(run, error)
    end do
    if (.not. (allocated(error) .or. allocated(run%loop%turned_angle) .or. run%scene%turning_positions == 0 .or. &
      run%place < path_end(run%scene))) call turn_wave_generator(run, error)
    if (.not. allocated(error)) return
    if (error%code == code_linear_solver .and. run%scene%support%struts .and. run%scene%balls > 0) error%message = error%message// &
      '. Where no ball carries the ring, lower bearing.clearance or raise wave_generator.w'
    run%failure = error
  end subroutine march

  !> Solve the same run as far as the first torque on a mesh of half as many facets either way; what ends that early ends only that.
  recursive subroutine solve_coarser(run)
    type(run_t), intent(inout) :: run                 !< gets the coarser states
    type(run_t), allocatable :: coarse
    type(error_t), allocatable :: error
    integer :: level
    call set_log_level(quiet, level)
    allocate (coarse)
    allocate (coarse%model)
    coarse%model%scene = run%scene
    coarse%model%joint = run%joint
    call new_run(coarser_scene(run%scene), '', '', .false., coarse, error)
    coarse%clock = run%clock
    coarse%keeps_all = .true.
    coarse%asks_tangent = .false.
    if (.not. allocated(error)) call march(coarse, step_end(assembled(coarse%scene)), error)
    call set_log_level(level)
    run%tally%start = to_text(coarse%scene%divisions)//' x '//to_text(band_rows(coarse%scene))//' facets'
    call say('start     first guess from a mesh of '//trim(run%tally%start)//', '//to_text(coarse%tally%iterations)//' iterations')
    if (allocated(coarse%model)) call coarse%model%solver%release()
    call move_alloc(coarse%model, run%coarser)
    call run%record%timers%book(in_coarser)
  end subroutine solve_coarser

  !> The drive at all places of the turn: first the assemblies, for teeth fit the mean of them, then the torque.
  recursive subroutine turn_wave_generator(run, error)
    type(run_t), intent(inout) :: run                 !< loop that is over; gets the record of its turn, lends its model
    type(error_t), allocatable, intent(out) :: error  !< not converged, stopped, files
    type(run_t), allocatable :: places(:)
    type(error_t), allocatable :: trouble
    type(table_t) :: rows
    real(dp), allocatable :: mean(:, :)
    integer :: i, level, inner
    inner = run%model%solver%inner
    allocate (places(run%scene%turning_positions))
    call open_places(run, rows, error)
    if (allocated(error)) return
    allocate (mean(3, size(run%state%u, 2)), source=0._dp)
    call say('turned    the drive is assembled at '//to_text(size(places))//' places, then loaded at each')
    call set_log_level(quiet, level)
    do i = 1, size(places)
      call hand_on(run%model, places(i)%model)
      call new_run(turned_scene(run%scene, i), '', '', .false., places(i), error)
      places(i)%clock = run%clock
      places(i)%asks_tangent = .false.
      if (.not. allocated(error)) call march(places(i), assembled(run%scene), error)
      call leave_model(places(i), run%model)
      if (allocated(error)) exit
      mean = mean + places(i)%state%u/size(places)
    end do
    if (.not. allocated(error)) then
      do i = 1, size(places)
        call hand_on(run%model, places(i)%model)
        call load_place(places(i), mean, error)
        call leave_model(places(i), run%model)
        call set_log_level(level)
        if (.not. allocated(error)) call book_place(run, places(i), i, rows, error)
        if (allocated(error)) exit
        call set_log_level(quiet)
      end do
    end if
    call set_log_level(level)
    call rows%close(error)
    call fit_run(run, trouble)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
    if (allocated(run%model)) run%model%solver%inner = inner
    call run%record%timers%book(in_turning)
    if (.not. allocated(error)) return
    if (error%code == code_stopped) then
      error%message = trim(merge('interrupted       ', 'stopped at a limit', stop_requested()))// &
        ' while the wave generator turned; all load steps are kept, --resume goes on'
    else
      error%message = 'where the wave generator has turned by '//to_text(angle_of(run%scene, min(i, size(places)))*180/pi)// &
        ' degrees: '//error%message
    end if
  end subroutine turn_wave_generator

  !> Torque on an assembled place. Its teeth have the gaps of the mean assembly: the circular spline knows no balls.
  recursive subroutine load_place(place, mean, error)
    type(run_t), intent(inout) :: place               !< assembled run
    real(dp), intent(in) :: mean(:, :)                !< displacements (3, n) [m]
    type(error_t), allocatable, intent(out) :: error  !< not converged, stopped
    call fit_run(place, error)
    if (allocated(error)) return
    call touch_teeth(place%scene, place%model%drive, mean, place%state)
    call march(place, path_end(place%scene), error)
  end subroutine load_place
end module hd_march
