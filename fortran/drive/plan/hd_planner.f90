! SPDX-License-Identifier: GPL-3.0-or-later
!> A scene that states a tolerance: kinematics, load steps and mesh are chosen from error estimates; what is chosen is then run like
!> any other scene, from the command line and from Python.
!>
!> Kinematics and load steps are chosen on a coarse mesh. Then meshes of a series are solved until the limits that they point to
!> are known to the tolerance. Those limits are promised (hd_promises). What large displacements and more layers change on coarse
!> meshes corrects them, where two meshes agree on it: the fine ones are then solved without.
module hd_planner
  use hd_kinds, only: dp
  use hd_attempts, only: attempts_t
  use hd_coarse_start, only: has_coarser
  use hd_cost, only: estimate_memory_mb, allowed_memory_mb, check_memory
  use hd_error, only: error_t, code_not_converged
  use hd_load_path, only: place_t, path_end
  use hd_log, only: say
  use hd_mesh_series, only: levels, coarse, first_solved, first_judged, first_level, expected_error, fine, share, &
    share_of_four, meshed, extrapolate, small_displacements
  use hd_model, only: model_t, forget_states, give_back
  use hd_promises, only: promise_t, promises, values, promises_of, wanted_of, k_of_steps, every_second, &
    is_field, relative
  use hd_trial_runs, only: trial_runs_t, new_trial_runs, growth
  use hd_run, only: run_t
  use hd_scene, only: scene_t
  use hd_section, only: band_rows
  use hd_text, only: string_t, push, to_text, percent
  use hd_timers, only: in_plan
  implicit none
  private
  public :: plan_t, make_plan, enter_plan, plan_text

  real(dp), parameter :: small = 0.3_dp         !< of the tolerance: load steps whose doubling changes less are good enough
  real(dp), parameter :: half = 0.5_dp          !< of it: what a simpler model may change
  real(dp), parameter :: unsure = 0.1_dp        !< of a correction: what it is off by at least
  real(dp), parameter :: of_slopes = 5e-3_dp    !< and of K1 to K3 besides: root mean square beside 12 rows, 28 drives
  real(dp), parameter :: accuracy = 1e-3_dp     !< of the tolerance: residual of Newton's method,
  real(dp), parameter :: of_loops = 1e-4_dp     !< and of loops, whose ring hangs in its grooves without a torque
  real(dp), parameter :: few_more = 1.1_dp      !< growth of a run's time from the trial's with the facets,
  real(dp), parameter :: taken = 0.2_dp         !< run over trial, whose attempts it takes over,
  real(dp), parameter :: started = 0.4_dp       !< and from a coarser mesh under large displacements; all three by judgement
  integer, parameter :: few_steps = 3           !< of each leg of a loop, to begin with: it stops where it is read besides
  integer, parameter :: doublings = 4           !< of load steps, at most

  type :: plan_t
    type(scene_t) :: scene                      !< what is to be run
    real(dp) :: begun = 0                       !< wall clock when planning began [s]
    logical :: short = .false.                  !< of a loop trials take the first rise alone
    type(string_t), allocatable :: reasons(:)   !< what was chosen, and why
    type(string_t), allocatable :: warnings(:)  !< what a tolerance cannot mend
    real(dp) :: change(promises) = 0            !< by load steps that were not doubled once more
    real(dp) :: simpler(promises) = 0           !< what a simpler wave generator and small displacements leave out
    real(dp) :: layers(promises) = 0            !< what two layers of cells leave, corrected or not
    real(dp) :: ratio(values) = 1, moved(values) = 0  !< corrections of limits: factors, and of fields what is added
    real(dp) :: estimate(promises) = 0          !< estimated relative errors of the limits
    real(dp) :: limit(values) = 0               !< what fine meshes would give
    real(dp) :: to_limit(values) = 1            !< that over what the mesh gives
    real(dp) :: shift(values) = 0               !< of a field: limit less what the mesh gives
    real(dp) :: doubt(values) = 0               !< estimated errors of the limits by the meshes, relative
    integer :: level = 0                        !< of the mesh that is run; 0: nothing could be estimated
    logical :: met = .false.                    !< the estimate is within the tolerance
    type(attempts_t) :: attempts                !< of the trial of its mesh
  end type plan_t

contains

  !> Say and keep what was chosen, and why.
  subroutine note(plan, text)
    type(plan_t), intent(inout) :: plan   !< gets a reason
    character(len=*), intent(in) :: text  !< reason
    call push(plan%reasons, text)
    call say('plan      '//text)
  end subroutine note

  !> The largest of the wanted promises, and which it is.
  function worst(plan, errors, word) result(text)
    type(plan_t), intent(in) :: plan          !< of the errors
    real(dp), intent(in) :: errors(promises)  !< relative
    character(len=*), intent(in) :: word      !< between what and how much
    character(len=:), allocatable :: text
    type(promise_t) :: promised(promises)
    logical :: wanted(promises)
    promised = promises_of(plan%scene)
    wanted = wanted_of(plan%scene)
    text = trim(promised(maxloc(errors, 1, wanted))%words)//' '//word//' '//percent(maxval(errors, mask=wanted))
    if (text(:1) /= 'K') text = 'the '//text
  end function worst

  !> Large displacements where they change a coarse solution by more than half the tolerance, unless that change is known: then it
  !> corrects the limits of small displacements. Of the slopes of a loop it is known, else a coarser mesh must confirm it. The whole
  !> loop tells, for friction remembers: at ratio 50 the first rise may change the other way.
  subroutine choose_kinematics(trials, plan, error)
    type(trial_runs_t), intent(inout) :: trials       !< runs
    type(plan_t), intent(inout) :: plan               !< gets its kinematics
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    real(dp), dimension(values) :: small_q, large_q, moved, small_2, large_2
    real(dp) :: change(promises), doubt(promises)
    type(promise_t) :: promised(promises), at
    character(len=:), allocatable :: text
    logical :: corrects
    if (.not. plan%scene%kinematics_open()) then
      call note(plan, 'kinematics '//trim(plan%scene%kinematics)//': as the scene says')
      return
    end if
    plan%scene%kinematics = 'linear'
    if (plan%scene%support%against_teeth .or. plan%scene%slides_on_cam() .or. .not. plan%scene%may_newton()) then
      call note(plan, 'kinematics linear: support, wave generator or method allow no other')
      return
    end if
    call try_both(coarse(plan%scene), small_q, large_q)
    if (allocated(error)) then
      if (error%code /= code_not_converged) return
      deallocate (error)
      call note(plan, 'kinematics linear: with large displacements a coarse mesh does not converge')
      call push(plan%warnings, 'what large displacements would change is not known: with them a coarse mesh does not converge. '// &
        'Take the results as those of small displacements')
      return
    end if
    promised = promises_of(plan%scene)
    moved = large_q - small_q
    change = relative(plan%scene, moved, large_q)
    doubt = change
    corrects = plan%scene%support%loop
    text = ': large displacements change '//worst(plan, change, 'by')
    if (corrects) then
      where (promised%name /= 'hysteresis' .and. change > 0) doubt = hypot(unsure*change, of_slopes)
    else if (beyond(change)) then
      call try_both(coarse(plan%scene) - 1, small_2, large_2)
      corrects = .not. allocated(error)
      if (corrects) then
        at = promised(k_of_steps)
        large_q(at%first:at%last) = small_q(at%first:at%last)  ! the steps of the plan are others: they keep their change
        doubt = relative(plan%scene, abs(moved - (large_2 - small_2)) + unsure*abs(moved), large_q)
        if (at%last >= at%first) doubt(k_of_steps) = change(k_of_steps)
      else
        if (error%code /= code_not_converged) return
        deallocate (error)
      end if
    end if
    if (corrects) text = text//', a correction known to '//percent(maxval(doubt, mask=wanted_of(plan%scene)))
    if (beyond(doubt)) then
      plan%scene%kinematics = 'nonlinear'
    else
      if (corrects) call correct(plan, small_q, large_q)
      plan%simpler = hypot(plan%simpler, doubt)
    end if
    call note(plan, 'kinematics '//trim(plan%scene%kinematics)//text//'; half the tolerance is '// &
      percent(half*plan%scene%planned_tolerance))
  contains
    !> More than half the tolerance, of a result that is wanted.
    logical function beyond(e)
      real(dp), intent(in) :: e(promises)  !< relative
      beyond = maxval(e, mask=wanted_of(plan%scene)) > half*plan%scene%planned_tolerance
    end function beyond

    !> A level with small and with large displacements; the error is that of choose_kinematics.
    subroutine try_both(level, small_q, large_q)
      integer, intent(in) :: level                         !< of the series of meshes
      real(dp), intent(out) :: small_q(values), large_q(values)  !< what they give
      type(scene_t) :: s
      s = meshed(plan%scene, level)
      s%straight = plan%short
      call trials%try(s, small_q, error)
      s%kinematics = 'nonlinear'
      if (.not. allocated(error)) call trials%try(s, large_q, error)
    end subroutine try_both
  end subroutine choose_kinematics

  !> What a better model changes on a coarse mesh corrects the limits: numbers by a factor, fields by what they move.
  pure subroutine correct(plan, simple, better)
    type(plan_t), intent(inout) :: plan      !< gets the correction
    real(dp), intent(in) :: simple(values)   !< results of a coarse mesh
    real(dp), intent(in) :: better(values)   !< of the better model
    integer :: i
    where (is_field([(i, i=1, values)]))
      plan%moved = plan%moved + better - simple
    else where (abs(simple) > 0)
      plan%ratio = plan%ratio*better/simple
    end where
  end subroutine correct

  !> The simplest wave generator that keeps half the tolerance: rigid, or one even spring as stiff as all balls, or the balls. What
  !> the spring cannot stand for, a rigid one cannot: it is not tried.
  subroutine choose_wave_generator(trials, plan, error)
    type(trial_runs_t), intent(inout) :: trials       !< runs
    type(plan_t), intent(inout) :: plan               !< gets its wave generator
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(scene_t) :: s
    real(dp) :: balls_q(values), q(values), change(promises), simpler(promises), stiffness
    character(len=:), allocatable :: text
    integer :: i
    if (plan%scene%balls == 0 .or. plan%scene%bearing_model == 'given' .or. plan%scene%large()) then
      call note(plan, 'wave generator as the scene says')
      return
    end if
    s = trial(plan, coarse(plan%scene))
    call trials%try(s, balls_q, error)
    if (allocated(error)) return
    stiffness = trials%balls_of(s)
    s%balls = 0
    s%groove_depth = 0
    text = ''
    simpler = 0
    do i = 1, 2
      s%ball_stiffness = merge(stiffness, 0._dp, i == 1)
      call trials%try(s, q, error)
      if (allocated(error)) then
        if (error%code /= code_not_converged) return
        deallocate (error)
        exit
      end if
      change = relative(s, q - balls_q, q)
      if (len(text) > 0) text = text//', '
      text = text//trim(merge('an even spring changes ', 'a rigid one changes    ', i == 1))//' '//worst(plan, change, 'by')
      if (maxval(change, mask=wanted_of(s)) > half*plan%scene%planned_tolerance) exit
      plan%scene%balls = 0
      plan%scene%groove_depth = 0
      plan%scene%ball_stiffness = s%ball_stiffness
      simpler = change
    end do
    plan%simpler = hypot(plan%simpler, simpler)
    if (len(text) == 0) text = 'an even spring does not converge'
    call note(plan, 'wave generator '//trim(merge('on its balls', merge('even spring ', 'rigid       ', &
      plan%scene%ball_stiffness > 0), plan%scene%balls > 0))//': '//text//'; half the tolerance is '// &
      percent(half*plan%scene%planned_tolerance))
  end subroutine choose_wave_generator

  !> Load steps, doubled on a coarse mesh until that changes less than three tenths of the tolerance. Steps that do not converge
  !> are passed over.
  subroutine choose_steps(trials, plan, error)
    type(trial_runs_t), intent(inout) :: trials       !< runs
    type(plan_t), intent(inout) :: plan               !< gets its load steps
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(scene_t) :: s
    real(dp) :: q(values), before(values)
    logical :: known
    integer :: i
    known = .false.
    s = trial(plan, coarse(plan%scene))
    do i = 0, doublings
      if (i > 0) s%assembly_steps = 2*s%assembly_steps
      if (i > 0) s%torque_steps = 2*s%torque_steps
      call trials%try(s, q, error)
      if (allocated(error)) then
        if (error%code /= code_not_converged) return
        if (i < doublings .or. known) deallocate (error)
        cycle
      end if
      if (known) then
        plan%change = relative(s, every_second(s, q) - before, before)
        if (maxval(plan%change, mask=wanted_of(s)) <= small*plan%scene%planned_tolerance) exit
      end if
      known = .true.
      before = q
      plan%scene%assembly_steps = s%assembly_steps
      plan%scene%torque_steps = s%torque_steps
    end do
    if (allocated(error)) return
    call note(plan, 'load steps '//to_text(plan%scene%assembly_steps)//' + '//to_text(plan%scene%torque_steps)// &
      ': twice as many change '//worst(plan, plan%change, 'by'))
  end subroutine choose_steps

  !> Below the tolerance that two layers of cells keep: what four change on a coarse mesh, and as a rule more than four, corrects
  !> the limits.
  subroutine choose_layers(trials, plan, error)
    type(trial_runs_t), intent(inout) :: trials       !< runs
    type(plan_t), intent(inout) :: plan               !< gets the correction
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(scene_t) :: s
    real(dp) :: two(values), four(values)
    if (.not. plan%scene%planned_tolerance < fine) return
    s = trial(plan, coarse(plan%scene))
    call trials%try(s, two, error)
    s%through_wall = 2*s%through_wall
    s%through_ring = s%through_wall
    if (.not. allocated(error)) call trials%try(s, four, error)
    if (allocated(error)) then  ! their error stays, and the tolerance is not met
      if (error%code == code_not_converged) deallocate (error)
      return
    end if
    plan%layers = share*plan%layers
    call note(plan, 'layers 2: four change '//worst(plan, relative(s, four - two, four), 'by')//', which corrects the limits')
    call correct(plan, two, two + (four - two)/(1 - share_of_four))
  end subroutine choose_layers

  !> A level as trials solve it: with small displacements, and of a loop the first rise alone where that will do.
  type(scene_t) function trial(plan, level) result(s)
    type(plan_t), intent(in) :: plan  !< plan
    integer, intent(in) :: level      !< of the series of meshes
    s = small_displacements(meshed(plan%scene, level))
    if (plan%short) s = first_rise(s)
  end function trial

  !> Meshes, load steps and wave generators change the slopes of a loop's first rise nearly as they change those that are read:
  !> limits by 4, 6 and 8 rows of 28 drives are off by 1.0 %, by whole loops 1.0 % too (root mean square). So trials end there, but
  !> where a hysteresis is wanted, the scene lists its torques, or the tolerance is fine.
  logical function rise_will_do(scene)
    type(scene_t), intent(in) :: scene  !< loop with a tolerance
    type(promise_t) :: promised(promises)
    promised = promises_of(scene)
    rise_will_do = .not. (any(abs(scene%torques) > 0) .or. scene%planned_tolerance < fine .or. &
      any(wanted_of(scene) .and. promised%name == 'hysteresis'))
  end function rise_will_do

  !> A loop with its first rise alone.
  pure type(scene_t) function first_rise(scene) result(s)
    type(scene_t), intent(in) :: scene  !< loop
    s = scene
    s%torques(1) = s%torque
    s%torque_count = 1
  end function first_rise

  !> Everything but the mesh.
  subroutine choose_all(trials, plan, error)
    type(trial_runs_t), intent(inout) :: trials       !< runs
    type(plan_t), intent(inout) :: plan               !< gets its choices
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(promise_t) :: promised(promises)
    promised = promises_of(plan%scene)
    plan%layers = promised%left
    plan%scene%element = 'hex8i'
    call note(plan, 'element hex8i: hex8 locks, hex20r takes more than ten times the time for the same error')
    if (len_trim(plan%scene%joint_reason) > 0) call note(plan, 'joint '//trim(plan%scene%joint_model)//': '// &
      trim(plan%scene%joint_reason))
    if (plan%scene%support%loop) then
      plan%scene%torque_steps = min(few_steps, plan%scene%torque_steps)
      plan%short = rise_will_do(plan%scene)
      if (plan%short) call note(plan, 'trials, but of the kinematics, end with the first rise of the torque; a hysteresis is '// &
        'promised where run.wanted names it')
    else
      plan%scene%assembly_steps = 1
      plan%scene%torque_steps = min(1, plan%scene%torque_steps)
    end if
    plan%scene%tolerance = max(plan%scene%tolerance, &
      merge(of_loops, accuracy, plan%scene%support%loop)*plan%scene%planned_tolerance)
    call note(plan, 'Newton iterations to a residual of '//to_text(plan%scene%tolerance)//': a small part of the tolerance')
    call choose_kinematics(trials, plan, error)
    if (.not. allocated(error) .and. plan%scene%support%struts) call choose_wave_generator(trials, plan, error)
    if (.not. allocated(error)) call choose_steps(trials, plan, error)
    if (.not. allocated(error)) call choose_layers(trials, plan, error)
  end subroutine choose_all

  !> Limits and their estimated errors from the meshes that are known.
  subroutine judge(q, plan)
    real(dp), intent(in) :: q(:, :)       !< quantities by level (values, levels that are known)
    type(plan_t), intent(inout) :: plan   !< gets both
    integer :: n, i
    n = size(q, 2)
    associate (limit => plan%limit)
      call extrapolate(plan%scene%support%loop, q, limit, plan%doubt)
      where (.not. abs(q(:, n)) > 0) limit = 0
      limit = limit*plan%ratio + plan%moved
      where (abs(plan%moved) > 0) limit = max(limit, 0._dp)  ! pressures
      plan%doubt = plan%doubt*plan%ratio
      plan%estimate = relative(plan%scene, plan%doubt, limit)
      where (abs(limit) > 0) plan%doubt = plan%doubt/abs(limit)
      where (plan%estimate > 0) plan%estimate = sqrt(plan%estimate**2 + plan%change**2 + plan%simpler**2 + &
        plan%layers**2)
    end associate
    call take_mesh(q(:, n), n, plan)
    plan%met = maxval(plan%estimate, mask=wanted_of(plan%scene)) <= plan%scene%planned_tolerance
  end subroutine judge

  !> Run a mesh: from its results the limits are so far.
  subroutine take_mesh(q, level, plan)
    real(dp), intent(in) :: q(:)          !< quantities that it gives
    integer, intent(in) :: level          !< of the series
    type(plan_t), intent(inout) :: plan   !< gets the mesh
    integer :: i
    plan%level = level
    plan%to_limit = 0  ! nothing is promised of what trials had no value of
    plan%shift = 0
    where (is_field([(i, i=1, values)]))
      plan%to_limit = 1
      plan%shift = plan%limit - q
    else where (abs(plan%limit) > 0)
      plan%to_limit = plan%limit/q
    end where
  end subroutine take_mesh

  !> Of the meshes that led to the limits the coarsest whose own results are as good as was asked is run, where more than the last
  !> trial is left to be solved; but pressures agree by chance on those that are not judged.
  subroutine choose_mesh(q, plan, scene)
    real(dp), intent(in) :: q(:, :)           !< quantities by level (values, levels that are known)
    type(plan_t), intent(inout) :: plan       !< met; gets the mesh
    type(scene_t), intent(inout) :: scene     !< its scene
    real(dp) :: off(promises)
    integer :: level
    do level = merge(first_solved(scene), first_judged(scene), scene%support%loop), size(q, 2) - 1
      off = relative(plan%scene, q(:, level) - plan%limit, plan%limit) + plan%estimate
      if (maxval(off, mask=wanted_of(plan%scene)) > plan%scene%planned_tolerance) cycle
      call take_mesh(q(:, level), level, plan)
      scene = meshed(plan%scene, level)
      call note(plan, 'mesh '//to_text(scene%divisions)//' x '//to_text(band_rows(scene))//' facets is run: '// &
        worst(plan, off, 'is off by')//', the largest')
      exit
    end do
  end subroutine choose_mesh

  !> Choose everything; refine until the estimate is within the tolerance.
  subroutine plan_scene(trials, scene, plan, error)
    type(trial_runs_t), intent(inout) :: trials       !< runs
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    type(plan_t), intent(out) :: plan                 !< what to run
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a run early
    type(scene_t) :: now, next
    real(dp) :: q(values, levels)
    integer :: level
    plan%scene = scene
    allocate (plan%reasons(0), plan%warnings(0))
    call choose_all(trials, plan, error)
    if (allocated(error)) then
      if (error%code /= code_not_converged) return
      deallocate (error)
      plan%scene = scene
      if (scene%kinematics_open()) plan%scene%kinematics = 'linear'
      call note(plan, 'a coarse run ended early: the scene is run as it stands')
      call check_memory(plan%scene, .false., error)
      return
    end if
    now = meshed(plan%scene, coarse(plan%scene))
    q = 0
    do level = first_solved(scene), levels
      next = meshed(plan%scene, level)
      if (level > coarse(scene) .and. .not. fits(next)) then
        call note(plan, 'no finer mesh: '//to_text(next%divisions)//' x '//to_text(band_rows(next))//' facets need about '// &
          to_text(nint(estimate_memory_mb(next)))//' MB, the limit is '//to_text(nint(allowed_memory_mb(next)))// &
          ' MB (mesh.memory_limit_mb)')
        exit
      end if
      if (level > first_solved(scene)) call trials%foretell(trial(plan, level - 1), trial(plan, level))
      call trials%try(trial(plan, level), q(:, level), error)
      if (allocated(error)) then
        if (error%code /= code_not_converged) return
        deallocate (error)
        call note(plan, 'the next mesh does not converge: this one is run'// &
          trim(merge(', nothing is known of its error', repeat(' ', 31), plan%level == 0)))
        exit
      end if
      now = next
      if (level < first_judged(scene)) cycle
      call judge(q(:, :level), plan)
      call note(plan, 'mesh '//to_text(now%divisions)//' x '//to_text(band_rows(now))//' facets: the estimated error of '// &
        worst(plan, plan%estimate, 'is')//', the largest; tolerance '//percent(scene%planned_tolerance))
      if (plan%met) exit
    end do
    if (plan%met .and. (plan%short .or. plan%scene%large())) call choose_mesh(q(:, :level), plan, now)
    plan%scene = now
    call leave_out(plan)
  end subroutine plan_scene

  !> What has not settled when the refinement ends is not promised.
  subroutine leave_out(plan)
    type(plan_t), intent(inout) :: plan   !< gets a reason for each
    type(promise_t) :: promised(promises)
    real(dp) :: left(promises)
    logical :: wanted(promises)
    integer :: i
    promised = promises_of(plan%scene)
    wanted = wanted_of(plan%scene)
    left = plan%change**2 + plan%simpler**2 + plan%layers**2
    do i = 1, promises
      if (wanted(i) .or. plan%estimate(i) <= plan%scene%planned_tolerance) cycle
      call note(plan, 'not promised: '//trim(promised(i)%words)//' where its estimated error is up to '//percent(plan%estimate(i)))
      associate (d => plan%doubt(promised(i)%first:promised(i)%last), ratio => plan%to_limit(promised(i)%first:promised(i)%last))
        where (d**2 + left(i) > plan%scene%planned_tolerance**2) ratio = 0
        plan%estimate(i) = sqrt(max(0._dp, maxval(d**2 + left(i), mask=abs(ratio) > 0 .and. d > 0)))
      end associate
    end do
  end subroutine leave_out

  !> Plan a scene, or take up a plan that was stopped.
  subroutine make_plan(scene, folder, resume, over, model, plan, error)
    type(scene_t), intent(in) :: scene                          !< scene with a tolerance
    character(len=*), intent(in) :: folder                      !< output folder or ''
    logical, intent(in) :: resume                               !< go on with the plan in the folder
    logical, intent(in) :: over                                 !< its run is complete: only see that it is that of this scene
    type(model_t), allocatable, intent(inout) :: model          !< of the run before, then of the last trial
    type(plan_t), intent(out) :: plan                           !< what to run
    type(error_t), allocatable, intent(out) :: error            !< another scene, files, whatever ended a trial early
    type(trial_runs_t) :: trials
    type(scene_t) :: last
    call new_trial_runs(scene, folder, resume, trials, error)
    if (over .or. allocated(error)) return
    call move_alloc(model, trials%model)
    call plan_scene(trials, scene, plan, error)
    call move_alloc(trials%model, model)
    last = plan%scene
    if (plan%short) last = first_rise(last)
    if (.not. allocated(error)) call trials%hand_over(last, plan%attempts)
    if (.not. plan%attempts%left()) call forget_states(model)  ! as where the plan goes on with its last run
    plan%begun = trials%begun
  end subroutine make_plan

  !> Enter a plan into the record of its run.
  subroutine enter_plan(plan, run)
    type(plan_t), intent(inout) :: plan     !< what was chosen; gets the solver
    type(run_t), intent(inout) :: run       !< run of its scene
    run%record%timers%seconds(in_plan) = run%clock - plan%begun
    run%clock = plan%begun
    if (.not. run%record%resumed) call plan%attempts%hand_on(run%attempts)
    call note(plan, 'solver '//trim(run%model%solver%name)//': least predicted time; symmetry '//trim(run%scene%symmetry)// &
      ': found from load and state, step by step')
    run%record%planned_tolerance = run%scene%planned_tolerance
    run%record%estimate = plan%estimate
    run%record%to_limit = plan%to_limit
    run%record%shift = plan%shift
    run%record%level = plan%level
    run%record%reasons = plan%reasons
    run%record%warnings = [run%record%warnings, plan%warnings]
    if (plan%level == 0) then
      call push(run%record%warnings, 'the tolerance is not met: nothing is known of the error. The '// &
        'log says why no finer mesh was run')
    else if (.not. plan%met) then
      call push(run%record%warnings, 'the tolerance is not met: the estimated error of '// &
        worst(plan, plan%estimate, 'is')// &
        '. Use it as it stands, or raise mesh.memory_limit_mb or run.tolerance')
    end if
  end subroutine enter_plan

  !> A mesh is within the memory allowed.
  logical function fits(scene)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp) :: limit
    limit = allowed_memory_mb(scene)
    fits = estimate_memory_mb(scene) < limit .or. limit <= 0
  end function fits

  !> The plan, with predicted time and memory; only coarse meshes are solved for it, which tell the speed of the machine.
  !> Time grows as facets^1.4 (condensed) and ^1.1 (large displacements, up to level 6); a linear run takes over the trial of its
  !> mesh and adds stresses, a drive also tangents; first guesses save large displacements three fifths of the iterations.
  subroutine plan_text(scene, text, error)
    type(scene_t), intent(in) :: scene                       !< scene with a tolerance
    character(len=:), allocatable, intent(out) :: text       !< plan
    type(error_t), allocatable, intent(out) :: error         !< whatever ended a run early
    type(trial_runs_t) :: trials
    type(plan_t) :: plan
    type(scene_t) :: s, linear
    real(dp) :: q(values), base(2), facets(2), seconds(2), before
    character(len=100) :: line
    character(len=1), parameter :: nl = new_line('a')
    integer :: level, start, i
    plan%scene = scene
    text = ''
    allocate (plan%reasons(0), plan%warnings(0))
    call new_trial_runs(scene, '', .false., trials, error)
    if (.not. allocated(error)) call choose_all(trials, plan, error)
    s = meshed(plan%scene, coarse(plan%scene))
    linear = trial(plan, coarse(plan%scene))
    if (.not. allocated(error)) call trials%try(linear, q, error)
    if (s%large() .and. .not. allocated(error)) call trials%try(s, q, error)
    call give_back(trials%model)
    if (allocated(error)) return
    base = [trials%seconds_of(linear), trials%seconds_of(s)]
    facets = [linear%divisions*band_rows(linear), s%divisions*band_rows(s)]
    do i = 1, size(plan%reasons)
      text = text//plan%reasons(i)%s//nl
    end do
    text = text//'solver '//trim(s%method)//': the least predicted time; symmetry '//trim(s%symmetry)// &
      ': as load and state allow'//nl// &
      'series of meshes: they are solved from the first on, with small displacements; from the one marked on, as soon as'//nl// &
      'the limits are known to '//percent(scene%planned_tolerance)//', the mesh is run ('//trim(plan%scene%kinematics)// &
      ' kinematics)'//nl// &
      'level divisions rows  error/% expected  estimate/s    run/s  in all/s       MB'
    start = first_level(scene)
    before = sum(trials%known%seconds)
    do level = first_solved(scene), levels
      s = meshed(plan%scene, level)
      seconds = base*(s%divisions*band_rows(s)/facets)**[growth, few_more]
      if (.not. s%large()) seconds(2) = (taken + merge(beyond_rise(s), 0._dp, plan%short))*seconds(1)
      if (s%large() .and. has_coarser(s)) seconds(2) = started*seconds(2)
      if (level /= coarse(scene)) before = before + seconds(1)
      if (level < first_judged(scene)) cycle
      write (line, '(I5,I10,I5,f18.2,f12.1,f9.1,f10.1,f9.0,a)') level, s%divisions, band_rows(s), &
        100*norm2([expected_error(level, scene), maxval(plan%change, mask=wanted_of(scene)), &
        maxval(plan%simpler, mask=wanted_of(scene))]), seconds, before + seconds(2), &
        estimate_memory_mb(s), &
        trim(merge(' <- start', '         ', level == start))
      text = text//nl//trim(line)
    end do
  end subroutine plan_text

  !> Load steps of a loop after its first rise, over those up to there.
  pure real(dp) function beyond_rise(scene) result(ratio)
    type(scene_t), intent(in) :: scene  !< loop
    type(place_t) :: rise, whole
    rise = path_end(first_rise(scene))
    whole = path_end(scene)
    ratio = (whole%step - rise%step)/real(rise%step, dp)
  end function beyond_rise
end module hd_planner
