! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs that a plan rests on: what is promised (hd_promises) as a mesh gives it, and the time it took. What has been solved is
!> remembered, and kept in plan.csv of the run's folder, so that a stopped plan goes on where it was.
module hd_trial_runs
  use hd_kinds, only: dp
  use hd_attempts, only: attempts_t
  use hd_checkpoint, only: check_same_scene
  use hd_checksum, only: checksum, hexadecimal
  use hd_clock, only: wall_seconds
  use hd_cost, only: allowed_memory_mb, estimate_memory_mb
  use hd_error, only: error_t, raise, code_file, code_input, code_stopped
  use hd_input, only: write_echo
  use hd_input_file, only: read_text, next_line
  use hd_load_path, only: place_t, path_end
  use hd_log, only: set_log_level, say, quiet, verbose
  use hd_march, only: march
  use hd_model, only: model_t, forget_states
  use hd_new_file, only: new_file_t
  use hd_output, only: result_files
  use hd_pressure_patches, only: patch_pressures
  use hd_promises, only: promise_t, promises, values, promises_of, promised_values, promise_text
  use hd_results_folder, only: clear_folder
  use hd_run, only: run_t, new_run, close_run, leave_model
  use hd_scene, only: scene_t
  use hd_section, only: band_rows
  use hd_strut, only: strut_tangent
  use hd_system, only: path_kind, path_absent, path_file, remove_file, stop_requested
  use hd_text, only: string_t, push, rounded, split, to_number, to_text
  implicit none
  private
  public :: trial_runs_t, new_trial_runs, growth

  real(dp), parameter :: a_moment = 1e-3_dp  !< where the limit has passed [s]; 0 would be none
  real(dp), parameter :: worth_saying = 3    !< of a mesh to come [s]
  real(dp), parameter :: growth = 1.4_dp  !< time of a mesh goes as this power of its facets, small displacements

  !> Results of a mesh.
  type :: probe_t
    real(dp) :: q(values) = 0     !< as promised_values
    real(dp) :: seconds = 0       !< wall clock
    real(dp) :: balls = 0         !< tangent stiffness of all loaded balls at the end [N/m]
  end type probe_t

  type :: trial_runs_t
    character(len=:), allocatable :: folder  !< '' for none
    real(dp) :: begun = 0                    !< wall clock [s]
    integer :: before = 0                    !< runs that were known when it began
    type(promise_t) :: promised(promises)    !< what is promised
    type(model_t), allocatable :: model      !< of the last run, for the next one
    type(string_t), allocatable :: name(:)   !< meshes that are solved,
    type(probe_t), allocatable :: known(:)   !< their results,
    type(attempts_t), allocatable :: attempts(:)  !< and how they were reached, if that is kept
  contains
    procedure :: try
    procedure :: seconds_of
    procedure :: balls_of
    procedure :: foretell
    procedure :: hand_over
  end type trial_runs_t

contains

  !> Begin a plan, or take up one that was stopped.
  subroutine new_trial_runs(scene, folder, resume, self, error)
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    character(len=*), intent(in) :: folder            !< of the run, '' for none
    logical, intent(in) :: resume                     !< go on with the plan in the folder, if there is one
    type(trial_runs_t), intent(out) :: self                !< what is known
    type(error_t), allocatable, intent(out) :: error  !< another scene, files
    self%folder = folder
    self%begun = wall_seconds()
    self%promised = promises_of(scene)
    allocate (self%name(0), self%known(0), self%attempts(0))
    if (len(folder) == 0) return
    if (resume .and. path_kind(folder//'/plan.nml') /= path_absent) then
      call check_same_scene(folder, 'plan.nml', scene, error)
      if (.not. allocated(error)) call read_known(self, error)
      if (.not. allocated(error)) self%before = size(self%known)
    else if (resume .and. path_kind(folder//'/echo.nml') /= path_absent) then
      call raise(error, code_input, "the run in '"//folder//"' was not planned: resume it without run.tolerance, or "// &
        'begin anew with --force')
    else
      call clear_folder(folder, result_files, error)
      call remove_file(folder//'/plan.csv')
      if (.not. allocated(error)) call write_echo(folder//'/plan.nml', scene, error)
    end if
  end subroutine new_trial_runs

  !> Results of a scene; nothing else is written.
  subroutine try(self, scene, q, error)
    class(trial_runs_t), intent(inout) :: self             !< remembers them
    type(scene_t), intent(in) :: scene                !< scene on its mesh
    real(dp), intent(out) :: q(values)                !< as promised_values
    type(error_t), allocatable, intent(out) :: error  !< whatever ended it early
    type(error_t), allocatable :: trouble
    type(run_t), allocatable :: run
    type(scene_t) :: s
    type(probe_t) :: new
    integer :: i, level
    i = place_of(self, scene)
    q = 0
    if (i > 0) q = self%known(i)%q
    if (i > 0) return
    s = scene
    if (s%time_limit_s > 0) s%time_limit_s = max(a_moment, s%time_limit_s - (wall_seconds() - self%begun))
    s%turning_positions = 0
    new%seconds = wall_seconds()
    call set_log_level(quiet, level)  ! one line instead of a run's own
    if (level == verbose) call set_log_level(verbose)
    allocate (run)
    call move_alloc(self%model, run%model)
    call forget_states(run%model)
    call new_run(s, '', '', .false., run, error)
    if (.not. allocated(error)) run%attempts%keeps = .not. (s%large() .or. s%support%against_teeth) .and. has_room(run)
    run%asks_tangent = .not. scene%support%loop  ! not promised there
    if (.not. allocated(error)) call march(run, path_end(run%scene), error)
    if (.not. allocated(error)) then
      q = promised_values(run%scene, run%sums, run%flexibility%tangent, patch_pressures(run%model%drive, run%facets), run%loop)
      if (scene%balls > 0 .and. scene%support%struts) new%balls = stiffness_of_balls(run)
    end if
    call close_run(run, trouble)
    call leave_model(run, self%model)
    call set_log_level(level)
    if (allocated(error)) then
      if (error%code == code_stopped) then
        call raise(error, code_stopped, stopped(self))
      else
        call say(trim(mesh_text(scene))//': '//error%message)
      end if
      return
    end if
    new%q = q
    new%seconds = wall_seconds() - new%seconds
    run%attempts%start = run%tally%start
    run%attempts%keeps = .false.
    call remember(self, name_of(scene), new, run%attempts)
    call say(log_line(scene, new))
    call keep(self, error)
  end subroutine try

  !> Add a run to those that are known.
  subroutine remember(self, name, probe, attempts)
    type(trial_runs_t), intent(inout) :: self      !< grows
    character(len=*), intent(in) :: name           !< of its mesh
    type(probe_t), intent(in) :: probe             !< its results
    type(attempts_t), intent(inout) :: attempts    !< handed on
    type(attempts_t), allocatable :: longer(:)
    integer :: i
    call push(self%name, name)
    self%known = [self%known, probe]
    allocate (longer(size(self%name)))
    do i = 1, size(self%attempts)
      call self%attempts(i)%hand_on(longer(i))
    end do
    call attempts%hand_on(longer(size(longer)))
    call move_alloc(longer, self%attempts)
  end subroutine remember

  !> There is room for the states of all load steps beside the model.
  logical function has_room(run)
    type(run_t), intent(in) :: run  !< run at rest
    real(dp), parameter :: mb = 1e-6_dp*storage_size(1._dp)/8
    real(dp) :: limit
    type(place_t) :: last
    limit = allowed_memory_mb(run%scene)
    last = path_end(run%scene)
    has_room = limit <= 0 .or. estimate_memory_mb(run%scene) + mb*last%step*(size(run%state%u) + 2*size(run%state%traction)) < limit
  end function has_room

  !> Attempts of the run of a scene; none where they were not kept.
  subroutine hand_over(self, scene, attempts)
    class(trial_runs_t), intent(inout) :: self     !< results
    type(scene_t), intent(in) :: scene             !< scene on its mesh
    type(attempts_t), intent(inout) :: attempts    !< gets them
    integer :: i
    i = place_of(self, scene)
    if (i > 0) call self%attempts(i)%hand_on(attempts)
  end subroutine hand_over

  !> What a stop while planning leaves.
  function stopped(self) result(text)
    class(trial_runs_t), intent(in) :: self  !< results
    character(len=:), allocatable :: text
    text = trim(merge('interrupted       ', 'stopped at a limit', stop_requested()))//' while planning'
    if (len(self%folder) == 0) return
    if (size(self%known) > self%before .or. stop_requested()) then
      text = text//'; '//to_text(size(self%known))//' runs of it are kept, --resume goes on'
    else
      text = text//' before a run of the plan was done ('//to_text(self%before)// &
        ' before): --resume gets on only with a longer solver.time_limit_s'
    end if
  end function stopped

  !> Time that a mesh took; 0 if it was not solved [s].
  real(dp) function seconds_of(self, scene) result(seconds)
    class(trial_runs_t), intent(in) :: self  !< results
    type(scene_t), intent(in) :: scene  !< scene on its mesh
    integer :: i
    i = place_of(self, scene)
    seconds = 0
    if (i > 0) seconds = self%known(i)%seconds
  end function seconds_of

  !> Stiffness that its balls had together; 0 if it was not solved or has none [N/m].
  pure real(dp) function balls_of(self, scene) result(stiffness)
    class(trial_runs_t), intent(in) :: self  !< results
    type(scene_t), intent(in) :: scene       !< scene on its mesh
    integer :: i
    i = place_of(self, scene)
    stiffness = 0
    if (i > 0) stiffness = self%known(i)%balls
  end function balls_of

  !> Radial tangent stiffness of all loaded balls [N/m].
  pure real(dp) function stiffness_of_balls(run) result(stiffness)
    type(run_t), intent(in) :: run  !< solved drive with balls
    associate (balls => run%model%drive%problem%struts(:run%model%drive%balls))
      stiffness = sum(strut_tangent(balls, run%loop%closing(:run%model%drive%balls)))
    end associate
  end function stiffness_of_balls

  !> Say how long the next mesh will take, if that is long.
  subroutine foretell(self, now, next)
    class(trial_runs_t), intent(in) :: self        !< times
    type(scene_t), intent(in) :: now, next    !< mesh that is solved, a finer one
    real(dp) :: seconds
    seconds = seconds_of(self, now)*(real(next%divisions*band_rows(next), dp)/(now%divisions*band_rows(now)))**growth
    if (seconds > worth_saying) call say('plan      next mesh '//to_text(next%divisions)//' x '//to_text(band_rows(next))// &
      ' facets: about '//to_text(nint(seconds))//' s')
  end subroutine foretell

  !> Everything a plan may choose, in one word, and what the tables hold that keys name.
  pure function name_of(s) result(name)
    type(scene_t), intent(in) :: s  !< scene on its mesh
    character(len=:), allocatable :: name
    type(place_t) :: last
    name = to_text(s%divisions)//'x'//to_text(s%band_facets)//'_edge_'//to_text(s%edge_length)//'_layers_'// &
      to_text(s%through_wall)//'_'//to_text(s%through_ring)//'_steps_'//to_text(s%assembly_steps)//'_'// &
      to_text(s%torque_steps)//'_'//trim(s%element)//'_'//trim(s%kinematics)
    if (s%support%struts) name = name//'_balls_'//to_text(s%balls)//'_'//to_text(s%ball_stiffness)
    if (s%support%loop) then
      last = path_end(s)
      name = name//'_end_'//to_text(last%step)
      if (s%straight) name = name//'_straight'
    end if
    name = name//'_'//trim(s%support%name)//'_files_'//hexadecimal(s%files)
  end function name_of

  !> A mesh for the log.
  function mesh_text(s) result(text)
    type(scene_t), intent(in) :: s  !< scene on its mesh
    character(len=24) :: text
    write (text, '(a,I5,a,I3,a)') '  trial', s%divisions, ' x', band_rows(s), ' facets'
  end function mesh_text

  !> A mesh and its results for the log.
  function log_line(s, found) result(line)
    type(scene_t), intent(in) :: s         !< scene on its mesh
    type(probe_t), intent(in) :: found     !< results
    type(promise_t) :: promised(promises)
    integer :: i
    character(len=:), allocatable :: line
    promised = promises_of(s)
    line = mesh_text(s)//', steps '//to_text(s%assembly_steps)//' + '//to_text(s%torque_steps)// &
      merge(', large', ', small', s%large())//' displacements: '
    do i = 1, promises
      if (promised(i)%first == promised(i)%last .and. abs(found%q(promised(i)%first)) > 0) line = line// &
        promise_text(promised(i), found%q)//', '
    end do
    line = line//rounded(found%seconds)//' s'
  end function log_line

  !> Number of a mesh in the list, 0 if it is new.
  pure integer function place_of(self, scene) result(i)
    class(trial_runs_t), intent(in) :: self  !< results
    type(scene_t), intent(in) :: scene  !< scene on its mesh
    character(len=:), allocatable :: name
    name = name_of(scene)
    do i = size(self%name), 1, -1
      if (self%name(i)%s == name) return
    end do
  end function place_of

  !> Write plan.csv; the one before is replaced only when this one is whole.
  subroutine keep(self, error)
    type(trial_runs_t), intent(in) :: self                 !< results
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(new_file_t) :: file
    character(len=25*(values + 8)) :: line
    integer :: i, k
    if (len(self%folder) == 0) return
    call file%open(self%folder//'/plan.csv', error)
    if (allocated(error)) return
    line = 'mesh,'
    do i = 1, promises
      do k = 0, self%promised(i)%last - self%promised(i)%first
        line = trim(line)//trim(self%promised(i)%column)
        if (self%promised(i)%last > self%promised(i)%first) line = trim(line)//'_'//to_text(k)
        line = trim(line)//','
      end do
    end do
    call file%put(trim(line)//'seconds,ball_stiffness_n_per_m,checksum'//new_line('a'))
    do i = 1, size(self%known)
      write (line, '(a,99(:,",",es24.16))') self%name(i)%s, self%known(i)%q(:maxval(self%promised%last)), &
        self%known(i)%seconds, self%known(i)%balls
      call file%put(trim(line)//','//hexadecimal(checksum(trim(line)))//new_line('a'))
    end do
    call file%close(error)
  end subroutine keep

  !> Results of a plan that was stopped.
  subroutine read_known(self, error)
    type(trial_runs_t), intent(inout) :: self         !< gets them
    type(error_t), allocatable, intent(out) :: error  !< a row is not as it was written
    type(probe_t) :: one
    type(attempts_t) :: none
    type(string_t), allocatable :: cells(:)
    character(len=:), allocatable :: text, line
    real(dp) :: row(values + 2)
    integer :: at, i, n, last
    logical :: ok
    if (path_kind(self%folder//'/plan.csv') /= path_file) return
    call read_text(self%folder//'/plan.csv', text, error)
    if (allocated(error)) return
    n = maxval(self%promised%last)
    at = 1
    call next_line(text, at, line)
    do while (at <= len(text))
      call next_line(text, at, line)
      cells = split(line)
      last = index(line, ',', back=.true.)
      ok = size(cells) == n + 4
      if (ok) ok = cells(n + 4)%s == hexadecimal(checksum(line(:last - 1)))
      do i = 1, n + 2
        if (ok) call to_number(trim(adjustl(cells(1 + i)%s)), row(i), ok)
      end do
      if (.not. ok) then
        call raise(error, code_file, "'"//self%folder//"/plan.csv' is not as the plan left it (row "// &
          to_text(size(self%name) + 1)//"): begin anew with --force")
        return
      end if
      one%q(:n) = row(:n)
      one%seconds = row(n + 1)
      one%balls = row(n + 2)
      call remember(self, cells(1)%s, one, none)
    end do
  end subroutine read_known
end module hd_trial_runs
