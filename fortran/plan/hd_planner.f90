! SPDX-License-Identifier: GPL-3.0-or-later
!> A scene that states a tolerance: element, kinematics, load steps, cells at the band's edges, layers and mesh are chosen from
!> error estimates; what is chosen is then run like any other scene, from the command line and from Python.
!>
!> Everything but the mesh is chosen on a coarse one: what is made finer there until that changes little. Then meshes of a series
!> are solved until the limits that they point to are known to the tolerance. Those limits are promised.
module hd_planner
  use hd_kinds, only: dp
  use hd_coarse_start, only: has_coarser
  use hd_cost, only: estimate_memory_mb, allowed_memory_mb
  use hd_error, only: error_t, code_not_converged
  use hd_job, only: resume_run, is_complete
  use hd_log, only: say
  use hd_mesh_series, only: levels, rough, first_level, least_error, meshed, extrapolate
  use hd_output, only: check_folder
  use hd_trial_runs, only: trial_runs_t, new_trial_runs, solve, growth
  use hd_run, only: run_t, new_run, close_run
  use hd_scene, only: scene_t
  use hd_section, only: band_rows
  use hd_text, only: string_t, push, to_text, percent
  implicit none
  private
  public :: new_planned_run, run_planned, plan_text

  real(dp), parameter :: small = 0.3_dp         !< of the tolerance: a choice that changes less is good enough
  real(dp), parameter :: accuracy = 1e-3_dp     !< of the tolerance: residual that moves K_TS by 0.003 of it at most (ten scenes)
  real(dp), parameter :: layer_uncertainty = 0.125_dp       !< share of what layers carry to finer meshes that may be wrong

  type :: plan_t
    type(scene_t) :: scene                      !< what is to be run
    type(string_t), allocatable :: reasons(:)   !< what was chosen, and why
    real(dp) :: change(3) = 0                   !< of K_TS, normal force, mid-band pressure by what was not made finer
    real(dp) :: carried(3) = 1                  !< change of the same by ever more layers, seen on a coarse mesh
    real(dp) :: estimate(3) = 0                 !< estimated relative errors of their limits
    real(dp) :: to_limit(3) = 1                 !< limit over what the mesh gives
    integer :: level = 0                        !< of the series of meshes; 0: nothing could be estimated
    logical :: met = .false.                    !< the estimate is within the tolerance
  end type plan_t

contains

  !> Level on which everything but the mesh is chosen: the coarsest that the estimates need.
  pure integer function coarse(scene)
    type(scene_t), intent(in) :: scene  !< scene with a tolerance
    coarse = (first_level(scene%planned_tolerance) + 1)/2
  end function coarse

  !> The same scene with small displacements: errors of the mesh are estimated with them, large ones have much the same.
  pure type(scene_t) function small_displacements(scene) result(s)
    type(scene_t), intent(in) :: scene  !< scene
    s = scene
    s%kinematics = 'linear'
  end function small_displacements

  !> Say and keep what was chosen, and why.
  subroutine note(plan, text)
    type(plan_t), intent(inout) :: plan   !< gets a reason
    character(len=*), intent(in) :: text  !< reason
    call push(plan%reasons, text)
    call say('plan      '//text)
  end subroutine note

  !> Large displacements where they change a coarse solution by more than half the tolerance.
  subroutine choose_kinematics(trials, plan, error)
    type(trial_runs_t), intent(inout) :: trials             !< runs
    type(plan_t), intent(inout) :: plan               !< gets its kinematics
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(scene_t) :: s
    real(dp) :: small_q(3), large_q(3), change
    if (plan%scene%kinematics /= 'auto') then
      call note(plan, 'kinematics '//trim(plan%scene%kinematics)//': as the scene says')
      return
    end if
    plan%scene%kinematics = 'linear'
    if (plan%scene%support == 'teeth' .or. .not. (plan%scene%method == 'auto' .or. plan%scene%method == 'newton')) then
      call note(plan, 'kinematics linear: support and method allow no other')
      return
    end if
    s = meshed(plan%scene, coarse(plan%scene))
    call trials%try(s, small_q, error)
    s%kinematics = 'nonlinear'
    if (.not. allocated(error)) call trials%try(s, large_q, error)
    if (allocated(error)) return
    change = maxval(abs(large_q - small_q)/(abs(large_q) + tiny(1._dp)))
    if (change > 0.5_dp*plan%scene%planned_tolerance) plan%scene%kinematics = 'nonlinear'
    call note(plan, 'kinematics '//trim(plan%scene%kinematics)//': large displacements change '//percent(change)// &
      ', half the tolerance is '//percent(0.5_dp*plan%scene%planned_tolerance))
  end subroutine choose_kinematics

  !> A scene with one of its choices finer.
  pure type(scene_t) function finer(scene, choice) result(s)
    type(scene_t), intent(in) :: scene       !< scene
    character(len=*), intent(in) :: choice   !< load steps, edge cells, layers
    s = scene
    select case (choice)
    case ('load steps')
      s%assembly_steps = 2*s%assembly_steps
      s%torque_steps = 2*s%torque_steps
    case ('edge cells')
      s%edge_length = merge(s%edge_length, s%band_length/s%band_facets, s%edge_length > 0)/4
    case ('layers')
      s%through_wall = 2*s%through_wall
      s%through_ring = 2*s%through_ring
    end select
  end function finer

  !> The coarsest choice whose refinement changes a coarse mesh by less than three tenths of the tolerance; where the last change
  !> there is more than half the tolerance, a finer mesh decides.
  subroutine choose(trials, choice, least, most, plan, error)
    type(trial_runs_t), intent(inout) :: trials             !< runs
    character(len=*), intent(in) :: choice            !< load steps, edge cells
    integer, intent(in) :: least, most                !< refinements: chosen at least, tried at most
    type(plan_t), intent(inout) :: plan               !< gets it
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(error_t), allocatable :: trouble
    type(scene_t) :: chosen, other
    character(len=:), allocatable :: doubtful
    real(dp) :: change(3), new(3)
    doubtful = ''
    call compare(trials, choice, coarse(plan%scene), least, most, plan%scene, chosen, change, error)
    if (allocated(error)) return
    if (maxval(change) > 0.5_dp*plan%scene%planned_tolerance) then
      call compare(trials, choice, coarse(plan%scene) + 2, least, most, plan%scene, other, new, trouble)
      if (.not. allocated(trouble)) then
        doubtful = ' on '//to_text(other%band_facets)//' rows ('//percent(maxval(change))//' on '// &
          to_text(chosen%band_facets)//')'
        chosen = other
        change = new
      end if
    end if
    plan%change = hypot(plan%change, change)
    plan%scene%assembly_steps = chosen%assembly_steps
    plan%scene%torque_steps = chosen%torque_steps
    plan%scene%edge_length = chosen%edge_length
    call note(plan, choice//' '//choice_text(chosen, choice)//': finer ones change '//percent(maxval(change))//doubtful)
  end subroutine choose

  !> A choice made finer on a mesh of the series until that changes less than three tenths of the tolerance; small displacements. A
  !> refinement that does not converge is passed over. Edge cells are compared on many layers: with few of them thin cells change
  !> K_TS by up to four times as much, and what layers change of the chosen cells is carried to finer meshes (choose_layers).
  subroutine compare(trials, choice, level, least, most, scene, chosen, change, error)
    type(trial_runs_t), intent(inout) :: trials             !< runs
    character(len=*), intent(in) :: choice            !< load steps, edge cells
    integer, intent(in) :: level                      !< of the series
    integer, intent(in) :: least, most                !< refinements: chosen at least, tried at most
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    type(scene_t), intent(out) :: chosen              !< the mesh with the coarsest that will do
    real(dp), intent(out) :: change(3)                !< of K_TS, normal force, mid-band pressure by the next finer one, relative
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(error_t), allocatable :: trouble
    type(scene_t) :: next
    real(dp) :: q(3), new(3)
    logical :: compared
    integer :: i
    chosen = small_displacements(meshed(scene, level))
    if (choice == 'edge cells') chosen = finer(finer(chosen, 'layers'), 'layers')
    next = chosen
    change = 0
    compared = .false.
    call trials%try(chosen, q, error)
    if (allocated(error)) return
    do i = 1, most
      next = finer(next, choice)
      call trials%try(next, new, trouble)
      if (allocated(trouble)) then
        if (trouble%code == code_not_converged) cycle
        exit
      end if
      change = abs(new - q)/(abs(new) + tiny(1._dp))
      compared = .true.
      if (i > least .and. maxval(change) <= small*scene%planned_tolerance) exit
      chosen = next
      q = new
    end do
    if (allocated(trouble)) then
      if (.not. compared .or. trouble%code /= code_not_converged) call move_alloc(trouble, error)
    end if
  end subroutine compare

  !> Layers, doubled on a coarse mesh until that changes little, twice at least: one and two may agree and both be wrong. The change
  !> goes on as the thickness of a layer, and from two layers on is much the same on all meshes: it is carried to finer ones, which
  !> take so few layers that what it may be wrong by is within three tenths of the tolerance; one only where the tolerance is rough.
  subroutine choose_layers(trials, plan, error)
    type(trial_runs_t), intent(inout) :: trials             !< runs
    type(plan_t), intent(inout) :: plan               !< gets layers and what is carried
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    integer, parameter :: most = 3
    type(scene_t) :: s(0:most)
    type(error_t), allocatable :: trouble
    real(dp) :: q(3, 0:most), last(3), finest(3), rest(3)
    integer :: i, n
    s(0) = small_displacements(meshed(plan%scene, max(3, coarse(plan%scene))))
    call trials%try(s(0), q(:, 0), error)
    if (allocated(error)) return
    n = 0
    do i = 1, most
      s(i) = finer(s(i - 1), 'layers')
      call trials%try(s(i), q(:, i), trouble)
      if (allocated(trouble)) exit
      n = i
      last = q(:, i) - q(:, i - 1)
      if (i > 1 .and. all(abs(last) <= small*plan%scene%planned_tolerance*abs(q(:, i)))) exit
    end do
    if (allocated(trouble)) then
      if (n == 0 .or. trouble%code /= code_not_converged) call move_alloc(trouble, error)
    end if
    if (allocated(error)) return
    finest = q(:, n) + last
    do i = 0, n
      rest = abs(finest - q(:, i))/(abs(finest) + tiny(1._dp))
      if (layer_uncertainty*maxval(rest) <= small*plan%scene%planned_tolerance .or. i == n) exit
    end do
    plan%scene%through_wall = s(i)%through_wall
    plan%scene%through_ring = s(i)%through_ring
    where (abs(q(:, i)) > 0) plan%carried = finest/q(:, i)
    plan%change = hypot(plan%change, layer_uncertainty*rest + 0.5_dp*abs(last)/(abs(finest) + tiny(1._dp)))
    call note(plan, 'layers '//choice_text(s(i), 'layers')//': finer ones change K_TS by '//percent(plan%carried(1) - 1)// &
      ': carried to finer meshes')
  end subroutine choose_layers

  !> A choice in words.
  pure function choice_text(s, choice) result(text)
    type(scene_t), intent(in) :: s           !< scene
    character(len=*), intent(in) :: choice   !< load steps, edge cells, layers
    character(len=:), allocatable :: text
    select case (choice)
    case ('load steps'); text = to_text(s%assembly_steps)//' + '//to_text(s%torque_steps)
    case ('edge cells'); text = 'of '//to_text(s%edge_length)//' m'
    case default; text = to_text(s%through_wall)//' in the wall, '//to_text(s%through_ring)//' in the ring'
    end select
  end function choice_text

  !> Everything but the mesh.
  subroutine choose_all(trials, plan, error)
    type(trial_runs_t), intent(inout) :: trials             !< runs
    type(plan_t), intent(inout) :: plan               !< gets its choices
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    plan%scene%element = 'hex8i'
    call note(plan, 'element hex8i: hex8 locks, hex20r takes more than ten times the time for the same error')
    plan%scene%assembly_steps = 1
    plan%scene%torque_steps = min(1, plan%scene%torque_steps)
    plan%scene%edge_length = 0
    ! With one layer, thin edge cells change K_TS by what is not there.
    plan%scene%through_wall = merge(1, 2, plan%scene%planned_tolerance >= rough)
    plan%scene%through_ring = plan%scene%through_wall
    plan%scene%tolerance = max(plan%scene%tolerance, accuracy*plan%scene%planned_tolerance)
    call note(plan, 'Newton iterations to a residual of '//to_text(plan%scene%tolerance)//': a thousandth of the tolerance')
    call choose_kinematics(trials, plan, error)
    if (.not. allocated(error)) call choose(trials, 'load steps', 0, 4, plan, error)
    ! shorter than the rows of the meshes to come, so that those next to them stay the same on all: K_TS jumps by 1 % otherwise
    if (.not. allocated(error)) call choose(trials, 'edge cells', merge(2, 3, plan%scene%planned_tolerance >= rough), &
      4, plan, error)
    if (.not. allocated(error)) call choose_layers(trials, plan, error)
  end subroutine choose_all

  !> Limits and their estimated errors from four levels.
  pure subroutine judge(q, level, plan)
    real(dp), intent(in) :: q(:, :)       !< quantities by level (3, levels)
    integer, intent(in) :: level          !< the finest that is known
    type(plan_t), intent(inout) :: plan   !< gets both
    real(dp) :: limit(3)
    call extrapolate(q, level, limit, plan%estimate)
    limit = limit*plan%carried
    plan%level = level
    plan%to_limit = 1
    where (abs(q(:, level)) > 0) plan%to_limit = limit/q(:, level)
    plan%estimate = hypot(plan%estimate, plan%change)
    plan%estimate = max(plan%estimate, least_error(level, plan%scene%planned_tolerance))
    plan%met = maxval(plan%estimate) <= plan%scene%planned_tolerance
  end subroutine judge

  !> Choose everything; refine until the estimate is within the tolerance.
  subroutine plan_scene(trials, scene, plan, error)
    type(trial_runs_t), intent(inout) :: trials             !< runs
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    type(plan_t), intent(out) :: plan                 !< what to run
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(scene_t) :: now, next
    real(dp) :: q(3, levels)
    integer :: level, start
    plan%scene = scene
    allocate (plan%reasons(0))
    call choose_all(trials, plan, error)
    if (allocated(error)) then
      if (error%code /= code_not_converged) return
      deallocate (error)
      plan%scene = scene
      if (scene%kinematics == 'auto') plan%scene%kinematics = 'linear'
      call note(plan, 'a coarse run ended early: the scene is run as it stands')
      return
    end if
    do start = first_level(scene%planned_tolerance), 5, -1
      if (fits(meshed(plan%scene, start))) exit
    end do
    now = meshed(plan%scene, coarse(plan%scene))
    do level = start - 3, levels
      next = meshed(plan%scene, level)
      call trials%foretell(small_displacements(now), next)
      call trials%try(small_displacements(next), q(:, level), error)
      if (allocated(error)) then
        if (error%code /= code_not_converged) return
        deallocate (error)
        call note(plan, 'the next mesh does not converge: this one is run'// &
          trim(merge(', nothing is known of its error', '                               ', level <= start)))
        exit
      end if
      now = next
      if (level < start) cycle
      call judge(q, level, plan)
      call note(plan, 'mesh '//to_text(now%divisions)//' x '//to_text(band_rows(now))//' facets, level '//to_text(level)// &
        ': K_TS '//percent(1/plan%to_limit(1) - 1)//' off its limit; that is known to '//percent(maxval(plan%estimate))// &
        ', tolerance '//percent(scene%planned_tolerance))
      if (plan%met .or. level == levels) exit
      if (.not. fits(meshed(plan%scene, level + 1))) exit
    end do
    plan%scene = now
  end subroutine plan_scene

  !> Plan a scene and set up its run, or take up both.
  subroutine new_planned_run(scene, input, folder, force, resume, run, error)
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    character(len=*), intent(in) :: input             !< name of the input, for the record
    character(len=*), intent(in) :: folder            !< output folder or ''
    logical, intent(in) :: force                      !< replace earlier results
    logical, intent(in) :: resume                     !< go on where plan or run were stopped
    type(run_t), intent(inout) :: run                 !< run at rest, or where it stopped
    type(error_t), allocatable, intent(out) :: error  !< folder, mesh, files, memory, whatever ended a run early
    type(trial_runs_t) :: trials
    type(plan_t) :: plan
    if (len(folder) > 0 .and. .not. resume) call check_folder(folder, force, error)  ! before the long work
    if (.not. allocated(error)) call new_trial_runs(scene, folder, resume, trials, error)
    if (.not. allocated(error)) call plan_scene(trials, scene, plan, error)
    if (allocated(error)) return
    if (resume) then
      call resume_run(plan%scene, input, folder, run, error)
    else
      call new_run(plan%scene, input, folder, force, run, error)
    end if
    if (allocated(error)) return
    run%clock = trials%begun
    call note(plan, 'solver '//trim(run%solver%name)//': least predicted time; symmetry '//trim(scene%symmetry)// &
      ': found from load and state, step by step')
    run%record%planned_tolerance = scene%planned_tolerance
    run%record%estimate = plan%estimate
    run%record%to_limit = plan%to_limit
    run%record%level = plan%level
    run%record%reasons = plan%reasons
    if (plan%level == 0) then
      call push(run%record%warnings, 'the tolerance is not met: nothing is known of the error')
    else if (.not. plan%met) then
      call push(run%record%warnings, 'the tolerance is not met: estimated error '//percent(maxval(plan%estimate)))
    end if
  end subroutine new_planned_run

  !> Plan a scene and run it.
  subroutine run_planned(scene, input, folder, force, resume, error)
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    logical, intent(in) :: resume                     !< go on where plan or run were stopped
    type(error_t), allocatable, intent(out) :: error  !< whatever ended the run early
    type(error_t), allocatable :: trouble
    type(run_t), allocatable :: run
    type(trial_runs_t) :: trials
    logical :: complete
    allocate (run)
    complete = is_complete(folder)
    if (resume .and. complete) then
      call new_trial_runs(scene, folder, resume, trials, error)  ! the same scene, and planned
      if (.not. allocated(error)) call say("the run in '"//folder//"' is complete: nothing to do")
      return
    end if
    call new_planned_run(scene, input, folder, force, resume, run, error)
    if (allocated(error)) return
    call solve(run, error)
    call close_run(run, trouble)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
    if (allocated(error) .or. run%record%level == 0) return
    call say('limit     K_TS '//to_text(run%record%limit(1))//' N m/rad, normal force '//to_text(run%record%limit(2))// &
      ' N'//middle_text(run%record%limit(3))//', known to '//percent(maxval(run%record%estimate)))
  end subroutine run_planned

  !> The mid-band pressure of a promise; nothing where the band's middle lies open: a pressure of 0 promises nothing.
  pure function middle_text(pressure) result(text)
    real(dp), intent(in) :: pressure  !< its limit [Pa]
    character(len=:), allocatable :: text
    text = trim(merge(', mid-band pressure '//to_text(pressure)//' Pa', repeat(' ', 23 + len(to_text(pressure))), pressure > 0))
  end function middle_text

  !> A mesh is within the memory allowed.
  logical function fits(scene)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp) :: limit
    limit = allowed_memory_mb(scene)
    fits = estimate_memory_mb(scene) < limit .or. limit <= 0
  end function fits

  !> The plan, with predicted time and memory; only coarse meshes are solved for it, which tell the speed of the machine.
  !> Time grows as facets^1.4 (condensed) and ^1.1 (large displacements, up to level 6); a linear run repeats its estimate from
  !> known states, first guesses save large displacements three fifths of the iterations.
  subroutine plan_text(scene, text, error)
    type(scene_t), intent(in) :: scene                       !< scene with a tolerance
    character(len=:), allocatable, intent(out) :: text       !< plan
    type(error_t), allocatable, intent(out) :: error         !< whatever ended a run early
    type(trial_runs_t) :: trials
    type(plan_t) :: plan
    type(scene_t) :: s, linear
    real(dp) :: q(3), base(2), facets(2), seconds(2), before
    character(len=100) :: line
    character(len=1), parameter :: nl = new_line('a')
    integer :: level, start, i
    plan%scene = scene
    text = ''
    allocate (plan%reasons(0))
    call new_trial_runs(scene, '', .false., trials, error)
    if (.not. allocated(error)) call choose_all(trials, plan, error)
    s = meshed(plan%scene, coarse(plan%scene))
    linear = small_displacements(s)
    if (s%kinematics == 'nonlinear') s%edge_length = 0
    if (.not. allocated(error)) call trials%try(linear, q, error)
    if (.not. allocated(error)) call trials%try(s, q, error)
    if (allocated(error)) return
    base = [trials%seconds_of(linear), trials%seconds_of(s)]
    facets = [linear%divisions*band_rows(linear), s%divisions*band_rows(s)]
    do i = 1, size(plan%reasons)
      text = text//plan%reasons(i)%s//nl
    end do
    text = text//'solver '//trim(s%method)//': the least predicted time; symmetry '//trim(s%symmetry)// &
      ': as load and state allow'//nl// &
      'series of meshes: estimates begin three levels before the one marked; from there the mesh is refined until the'//nl// &
      'limit is known to '//percent(scene%planned_tolerance)//'; that mesh is run ('//trim(plan%scene%kinematics)// &
      ' kinematics)'//nl// &
      'level divisions rows  error/% expected  estimate/s    run/s  in all/s       MB'
    start = first_level(scene%planned_tolerance)
    before = sum(trials%known%seconds)
    do level = 1, levels
      s = meshed(plan%scene, level)
      seconds = base*(s%divisions*band_rows(s)/facets)**[growth, 1.1_dp]
      if (s%kinematics == 'linear') seconds(2) = 0.1_dp*seconds(1)
      if (s%kinematics == 'nonlinear' .and. has_coarser(s)) seconds(2) = 0.4_dp*seconds(2)
      if (level >= start - 3 .and. level /= coarse(scene)) before = before + seconds(1)
      write (line, '(i5,i10,i5,f18.2,f12.1,f9.1,f10.1,f9.0,a)') level, s%divisions, band_rows(s), &
        100*maxval(hypot(least_error(level, scene%planned_tolerance), plan%change)), seconds, before + seconds(2), &
        estimate_memory_mb(s), &
        trim(merge(' <- start', '         ', level == start))
      text = text//nl//trim(line)
    end do
  end subroutine plan_text
end module hd_planner
