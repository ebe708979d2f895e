! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs that a band rests on (hd_tolerance_band): the drive on a coarse mesh, as it is and with one input at an end of its
!> tolerance. Relative changes hold for the run itself. Nothing is written.
!>
!> Where `run.band` is 'auto', runs end at the opposite torque, and an input whose tolerance is small beside its value has none of
!> its own: the derivatives along the drive as it is say what it changes. They hold for the readings of the loop, not for K_TS,
!> which jumps with the contact states.
module hd_tolerance_runs
  use hd_kinds, only: dp
  use hd_clock, only: wall_seconds
  use hd_conditions, only: check_scene
  use hd_cup_sections, only: adopt_sections
  use hd_error, only: error_t, raise, code_stopped
  use hd_idle_keys, only: is_idle
  use hd_load_path, only: path_end
  use hd_log, only: say, set_log_level, quiet
  use hd_loop, only: read_loop, readings_t
  use hd_march, only: march
  use hd_mesh_series, only: small_displacements
  use hd_model, only: model_t, give_back
  use hd_input_tolerances, only: mean_clearance, mean_play
  use hd_parameter_row, only: stage_model
  use hd_parameters, only: parameter_t, parameter_table_t, new_table, value_count, value_text
  use hd_run, only: run_t, new_run, close_run, differentiate_run, leave_model
  use hd_scene, only: scene_t, most_gaps
  use hd_section, only: band_rows
  use hd_summary, only: derivatives_t
  use hd_system, only: stop_requested
  use hd_text, only: string_t, push, to_text
  use hd_tolerance_band, only: tolerance_band_t, banded, banded_values, banded_words, readings
  use hd_tooth_flanks, only: tooth_gaps
  implicit none
  private
  public :: find_band

  integer, parameter :: divisions = 36, facets = 6, steps = 3  !< of the mesh, and of each leg of the loop, at most
  real(dp), parameter :: enough = 1e-6_dp  !< of the residuals; at 1e-4 fewer iterations a step, but more cut steps
  !> Change over value up to which derivatives do. Friction, by half of it, changes K1 of drive14 by 5 %; runs say -6 and 4 %. For
  !> its clearance, by 0.8 of it, they say 8 %; runs 9 and -17 %.
  real(dp), parameter :: small = 0.6_dp

  character(len=27), parameter :: fit(2) = [character(len=27) :: 'wave_generator.clearance', 'wave_generator.interference']

  !> A key that has a tolerance, and a part in the drive.
  type :: input_t
    integer :: row = 0                     !< of the table
    type(string_t) :: key                  !< group.key
    integer :: ends = 0                    !< runs: one or two ends, none where derivatives do
    real(dp), allocatable :: change(:)     !< to its ends, in its unit, if they are small beside its value, else none
  end type input_t

contains

  !> Find the band of a loop that is over.
  subroutine find_band(run, error)
    type(run_t), intent(inout) :: run                 !< at its end; its record gets the band
    type(error_t), allocatable, intent(out) :: error  !< a signal, the time limit
    type(model_t), allocatable :: model
    type(derivatives_t) :: by
    type(scene_t) :: coarse
    type(input_t), allocatable :: inputs(:)
    type(readings_t) :: found
    character(len=:), allocatable :: reason
    real(dp) :: base(banded), seconds
    logical :: quick
    integer :: i
    quick = run%scene%with_band == 'auto'
    reason = ''
    found = read_loop(run%loop, run%scene)
    if (any(found%k > 0)) then
      coarse = coarsened(run%scene)
      call find_inputs(coarse, inputs)
      call try(coarse, run%clock, model, base, seconds, error, inputs, by)
    else
      reason = 'the torque does not rise'
    end if
    if (allocated(error)) then
      reason = 'the drive on a coarse mesh ended early: '//error%message
    else if (len(reason) == 0) then
      do i = 1, size(inputs)
        call enter_slopes(inputs(i), base, by, run%record%band)
      end do
      call run_ends(inputs, coarse, base, seconds, model, run, error)
      if (allocated(error)) reason = 'the time limit has passed'
    end if
    call give_back(model)
    if (len(reason) == 0) return
    if (allocated(run%record%band%input)) run%record%band = tolerance_band_t()
    if (allocated(error)) then
      if (stop_requested() .or. (error%code == code_stopped .and. .not. quick)) then
        call raise(error, code_stopped, trim(merge('interrupted       ', 'stopped at a limit', stop_requested()))// &
          ' before the band was found; all load steps are kept, --resume finds it')
        run%record%interrupted = stop_requested()
        run%failure = error
        return
      end if
      deallocate (error)
    end if
    if (quick) then
      call say('band      none, for '//reason)
    else
      call push(run%record%warnings, 'there is no band, for '//reason//'. Raise mesh.divisions or mend that')
    end if
  end subroutine find_band

  !> Solve the drive with every input that needs it at its ends.
  subroutine run_ends(inputs, coarse, base, seconds, model, run, error)
    type(input_t), intent(in) :: inputs(:)                 !< inputs
    type(scene_t), intent(in) :: coarse                    !< without a change
    real(dp), intent(in) :: base(banded)                   !< its results
    real(dp), intent(in) :: seconds                        !< that it took [s]
    type(model_t), allocatable, intent(inout) :: model     !< of the run before
    type(run_t), intent(inout) :: run                      !< gets the band, and warnings
    type(error_t), allocatable, intent(out) :: error       !< stopped
    real(dp) :: begun
    integer :: i
    begun = wall_seconds()
    associate (ends => inputs%ends)
      call say('band      '//to_text(count(ends == 0))//' inputs by derivatives, '//to_text(sum(ends))//' runs with one at an '// &
        'end of its tolerance, on '//to_text(coarse%divisions)//' x '//to_text(band_rows(coarse))//' facets: about '// &
        to_text(ceiling(sum(ends)*seconds))//' s')
      do i = 1, size(inputs)
        if (ends(i) == 0) cycle
        call move_input(inputs(i)%row, coarse, base, model, run, error)
        if (allocated(error)) return
        if (sum(ends(i + 1:)) > 0) call say('          '//to_text(sum(ends(:i)))//' of '//to_text(sum(ends))//' runs, about '// &
          to_text(ceiling((wall_seconds() - begun)/sum(ends(:i))*sum(ends(i + 1:))))//' s left')
      end do
    end associate
  end subroutine run_ends

  !> Enter an input by derivatives, where they hold; it then has no runs. One that they move by a factor of e they do not hold for.
  subroutine enter_slopes(input, base, by, band)
    type(input_t), intent(inout) :: input          !< an input
    real(dp), intent(in) :: base(banded)           !< results of the drive as it is
    type(derivatives_t), intent(in) :: by          !< of the readings, by some keys or none
    type(tolerance_band_t), intent(inout) :: band  !< gets the input
    real(dp) :: moved(banded, 2)
    integer :: i, k
    k = 0
    if (allocated(by%keys)) k = findloc([(by%keys(i)%s == input%key%s, i=1, size(by%keys))], .true., 1)
    if (k == 0) return
    associate (slope => by%value(k, :readings), value => base(:readings), change => input%change)
      if (size(change) == 0 .or. any(value > 0 .and. .not. slope == slope)) return
      if (any(value > 0 .and. abs(slope)*maxval(abs(change)) > value)) return
      moved = 0
      do i = 1, size(change)
        where (value > 0) moved(:readings, i) = value*exp(slope*change(i)/value)
      end do
      call band%add(input%key%s, base, moved(:, :size(change)))
    end associate
    input%ends = 0
  end subroutine enter_slopes

  !> Solve the drive with an input at its ends; a run that does not converge is left out.
  subroutine move_input(row, scene, base, model, run, error)
    integer, intent(in) :: row                             !< of the table
    type(scene_t), intent(in) :: scene                     !< without a change
    real(dp), intent(in) :: base(banded)                   !< its results
    type(model_t), allocatable, intent(inout) :: model     !< of the run before
    type(run_t), intent(inout) :: run                      !< gets its part of the band, and warnings
    type(error_t), allocatable, intent(out) :: error       !< stopped
    type(scene_t), target :: at(2)
    type(parameter_table_t) :: table
    type(string_t), allocatable :: faults(:)
    type(input_t) :: input
    character(len=:), allocatable :: left_out
    real(dp) :: value(banded), found(banded, 2), seconds
    integer :: i, k, n
    call move_to_ends(row, scene, input, at)
    n = 0
    do i = 1, input%ends
      allocate (faults(0))
      call new_table(at(i), table)
      call adopt_sections(at(i), table, faults)
      if (size(faults) == 0) call check_scene(at(i), faults)
      left_out = ''
      if (size(faults) > 0) left_out = faults(1)%s
      deallocate (faults)
      if (len(left_out) == 0) then
        call try(at(i), run%clock, model, value, seconds, error)
        if (allocated(error)) then
          if (error%code == code_stopped) return
          left_out = error%message
          deallocate (error)
        end if
      end if
      if (len(left_out) > 0) then
        call push(run%record%warnings, 'the band leaves out an end of '//input%key%s//': '//left_out// &
          '. Take the other end for both, or move the input yourself')
        cycle
      end if
      n = n + 1
      found(:, n) = value
      do k = 1, banded
        if (base(k) > 0 .and. .not. value(k) > 0) call push(run%record%warnings, 'the band of '//trim(banded_words(k))// &
          ' leaves out an end of '//input%key%s//', where it has no value: take the other end for both')
      end do
    end do
    if (n > 0) call run%record%band%add(input%key%s, base, found(:, :n))
  end subroutine move_input

  !> Results of a scene; no K_TS with run.band = 'auto'.
  subroutine try(scene, clock, model, value, seconds, error, inputs, by)
    type(scene_t), intent(in) :: scene                     !< scene
    real(dp), intent(in) :: clock                          !< when the run began that its time limit is for [s]
    type(model_t), allocatable, intent(inout) :: model     !< of the run before, then of this one
    real(dp), intent(out) :: value(banded)                 !< as banded_values
    real(dp), intent(out) :: seconds                       !< that the run took, wall clock, without derivatives
    type(error_t), allocatable, intent(out) :: error       !< whatever ended it early
    type(input_t), intent(in), optional :: inputs(:)       !< inputs
    type(derivatives_t), intent(out), optional :: by       !< by those that change little, with run.band = 'auto'
    type(error_t), allocatable :: trouble
    type(run_t), allocatable :: run
    type(string_t), allocatable :: keys(:)
    character(len=:), allocatable :: lost
    integer :: i, level
    value = 0
    seconds = wall_seconds()
    call set_log_level(quiet, level)
    allocate (run)
    call move_alloc(model, run%model)
    call new_run(scene, '', '', .false., run, error)
    run%clock = clock
    run%asks_tangent = scene%with_band /= 'auto'
    if (present(by) .and. .not. run%asks_tangent) allocate (run%gradient)
    if (.not. allocated(error)) call march(run, path_end(run%scene), error)
    seconds = wall_seconds() - seconds
    if (.not. allocated(error)) then
      value = banded_values(read_loop(run%loop, run%scene), run%reference%sums)
      if (.not. run%asks_tangent) value(readings + 1:) = 0
      if (allocated(run%gradient)) then
        allocate (keys(0))
        do i = 1, size(inputs)
          if (size(inputs(i)%change) > 0) call push(keys, inputs(i)%key%s)
        end do
        call differentiate_run(run, by, lost, trouble, keys)
        if (allocated(trouble)) by = derivatives_t()
      end if
    end if
    if (allocated(run%gradient)) deallocate (run%gradient)
    call close_run(run, trouble)
    call leave_model(run, model)
    call set_log_level(level)
  end subroutine try

  !> The scene on a coarse mesh, with few load steps and small displacements.
  pure type(scene_t) function coarsened(scene) result(s)
    type(scene_t), intent(in) :: scene  !< scene of the run
    s = small_displacements(scene)
    s%planned_tolerance = 0
    s%turning_positions = 0
    s%divisions = min(s%divisions, divisions)
    if (.not. s%groove_depth > 0) s%band_facets = min(s%band_facets, facets)  ! a groove is wider than a cell of the ring
    s%torque_steps = min(s%torque_steps, steps)
    s%half_loop = s%with_band == 'auto' .and. s%torque_count == 1 .and. .not. abs(s%torques(1)) > 0
    if (s%half_loop) then
      s%torque_count = 3
      s%torques(:3) = [s%torque, 0._dp, -s%torque]
    end if
    if (s%with_band == 'auto') s%tolerance = max(s%tolerance, enough)
    s%edge_length = 0
    s%ring_divisions = 0
    s%ring_facets = 0
    s%through_wall = 1
    s%through_ring = 1
  end function coarsened

  !> Inputs that have a tolerance and a part in the drive; those that leave mesh and factors as they are come first.
  subroutine find_inputs(scene, inputs)
    type(scene_t), intent(in) :: scene                       !< scene on its mesh
    type(input_t), allocatable, intent(out) :: inputs(:)     !< inputs
    type(scene_t), target :: copy
    type(scene_t) :: at(2)
    type(parameter_table_t) :: table
    type(input_t) :: input
    integer :: pass, i
    copy = scene
    call new_table(copy, table)
    allocate (inputs(0))
    do pass = 1, 2
      do i = 1, size(table%rows)
        if ((table%rows(i)%stage(.false., .false.) == stage_model) .neqv. pass == 2) cycle
        if (.not. takes_part(table%rows(i), scene)) cycle
        call move_to_ends(i, scene, input, at)
        if (input%ends > 0) inputs = [inputs, input]
      end do
    end do
  end subroutine find_inputs

  !> A key has a tolerance, and the drive depends on it.
  pure logical function takes_part(p, scene)
    type(parameter_t), intent(in) :: p   !< row
    type(scene_t), intent(in) :: scene   !< scene
    takes_part = p%tolerance > 0 .and. .not. is_idle(scene, p%group, p%key)
    if (p%key == 'interference') takes_part = takes_part .and. scene%interference > 0
    if (p%group == 'wave_generator' .and. p%key == 'clearance') takes_part = takes_part .and. .not. scene%interference > 0
    if (p%key == 'tooth_gaps') takes_part = takes_part .and. scene%tooth_pairs <= most_gaps
  end function takes_part

  !> The scene with a key at either end of its tolerance; an end that changes nothing is left out.
  subroutine move_to_ends(row, scene, input, at)
    integer, intent(in) :: row                !< of the table
    type(scene_t), intent(in) :: scene        !< scene
    type(input_t), intent(out) :: input       !< its key, how many ends there are, changes to them
    type(scene_t), intent(out) :: at(2)       !< the key at its ends
    type(scene_t), target :: moved
    type(parameter_table_t) :: table
    character(len=:), allocatable :: before
    real(dp) :: x
    integer :: side
    input%row = row
    x = 0
    allocate (input%change(0))
    do side = -1, 1, 2
      moved = scene
      call new_table(moved, table)
      associate (p => table%rows(row))
        input%key%s = p%group//'.'//p%key
        if (input%key%s == 'load.tooth_gaps') call list_gaps(moved)
        before = value_text(p)
        if (input%key%s == 'load.tooth_gaps') moved%gaps_back = moved_value(p, moved%gaps_back, side, scene)
        if (associated(p%real)) x = p%real
        if (any(input%key%s == fit)) then
          call move_fit(p, side, moved)
        else
          call move(p, side, scene)
        end if
        if (value_text(p) /= before .or. any(input%key%s == fit)) then
          input%ends = input%ends + 1
          at(input%ends) = moved
          if (associated(p%real)) input%change = [input%change, p%real - x]
        end if
        if (associated(p%text)) exit  ! there is one other bound
      end associate
    end do
    if (any(abs(input%change) > small*abs(x))) input%change = [real(dp) ::]
  end subroutine move_to_ends

  !> Move the fit to an end of its tolerance: clearance and interference are one number, either side of 0.
  pure subroutine move_fit(p, side, scene)
    type(parameter_t), intent(in) :: p       !< row of either
    integer, intent(in) :: side              !< -1 lower end, 1 upper end
    type(scene_t), intent(inout) :: scene    !< gets both
    real(dp) :: gap, width
    width = p%tolerance
    if (p%tolerance_of == 'fit') width = width*mean_clearance(2*scene%bore_radius)
    gap = scene%clearance - scene%interference + merge(-side, side, p%key == 'interference')*width
    scene%clearance = max(gap, 0._dp)
    scene%interference = max(-gap, 0._dp)
  end subroutine move_fit

  !> Clearances of all pairs as lists of both flanks.
  pure subroutine list_gaps(scene)
    type(scene_t), intent(inout) :: scene  !< gets them
    scene%gaps(:scene%tooth_pairs) = tooth_gaps(unturned(scene), 1)
    scene%gaps_back(:scene%tooth_pairs) = tooth_gaps(unturned(scene), 2)
    scene%gap_count = scene%tooth_pairs
    scene%gap_back_count = scene%tooth_pairs
  end subroutine list_gaps

  !> The scene with a pair on, or beside, the long axis, as lists of clearances have it.
  pure type(scene_t) function unturned(scene) result(s)
    type(scene_t), intent(in) :: scene  !< scene
    s = scene
    s%tooth_phase = 0
  end function unturned

  !> Move a value to an end of its tolerance, within its valid range.
  subroutine move(p, side, scene)
    type(parameter_t), intent(in) :: p   !< row; its value is moved
    integer, intent(in) :: side          !< -1 lower end, 1 upper end
    type(scene_t), intent(in) :: scene   !< before
    integer :: i
    if (associated(p%text)) then
      i = findloc([(p%choices(i)%s == p%text, i=1, size(p%choices))], .false., 1)
      p%text = p%choices(i)%s
    else if (associated(p%reals)) then
      p%reals(:value_count(p)) = moved_value(p, p%reals(:value_count(p)), side, scene)
    else
      p%real = moved_value(p, p%real, side, scene)
    end if
  end subroutine move

  !> A number at an end of its tolerance; where that leaves the valid range its bound, or half the way to it if that is not valid.
  elemental real(dp) function moved_value(p, x, side, scene) result(y)
    type(parameter_t), intent(in) :: p   !< row
    real(dp), intent(in) :: x            !< value
    integer, intent(in) :: side          !< -1 lower end, 1 upper end
    type(scene_t), intent(in) :: scene   !< before
    real(dp) :: width
    width = p%tolerance
    if (p%tolerance_of == 'value') width = width*abs(x)
    if (p%tolerance_of == 'bore') width = width*scene%bore_radius
    if (p%tolerance_of == 'play') width = width*mean_play(scene%bore_radius, scene%ring_thickness, scene%ball_diameter)
    y = x + side*width
    if (y <= p%low) y = merge((x + p%low)/2, p%low, p%open_low)
    if (y >= p%high) y = merge((x + p%high)/2, p%high, p%open_high)
  end function moved_value
end module hd_tolerance_runs
