! SPDX-License-Identifier: GPL-3.0-or-later
!> A scene that states a tolerance: kinematics, mesh and load steps are chosen from error estimates; what is chosen is then
!> run like any other scene, from the command line and from Python.
!>
!> Meshes of a series grow by 2^(1/2) per level in all directions. Load steps are halved on a coarse mesh until that changes
!> little; there, too, small displacements are compared with large ones. The promise is against a mesh three refinements finer:
!> the last change d_l = q_l - q_(l-1) goes on falling by the ratio r that three levels show, so the estimate is
!> |d_l| (r + r^2 + r^3) relative to q_l, with r at least 0.85 and |d_l| at least half of |q_l - q_(l-2)|, plus the change by
!> halved steps.
module hd_planner
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t
  use hd_input, only: estimate_memory_mb, allowed_memory_mb
  use hd_log, only: say
  use hd_load_step, only: advance
  use hd_output, only: check_folder
  use hd_run, only: run_t, new_run, finish
  use hd_scene, only: scene_t
  use hd_text, only: push, to_text
  implicit none
  private
  public :: new_planned_run, run_planned, plan_text

  integer, parameter :: band(10) = [4, 6, 8, 11, 16, 23, 32, 45, 64, 90]  !< facets along the band, by level
  real(dp), parameter :: first_error = 1.5_dp   !< error expected with one facet; it falls as 1 / facets (reference scenes)
  real(dp), parameter :: slowest = 0.85_dp      !< ratio of successive changes that K_TS shows at worst (edge pressure)
  real(dp), parameter :: shape = 1.6_dp         !< facets are so much longer round the axis than along it
  integer, parameter :: pilot = 2               !< level on which kinematics and load steps are chosen

  type :: plan_t
    type(scene_t) :: scene            !< what is to be run
    real(dp) :: estimate(3) = 0       !< estimated relative errors of K_TS, normal force, mid-band pressure
    integer :: level = 0              !< of the series of meshes; 0: nothing could be estimated
    logical :: met = .false.          !< the estimate is within the tolerance
  end type plan_t

contains

  !> Level that is expected to meet the tolerance.
  pure integer function first_level(tolerance) result(level)
    real(dp), intent(in) :: tolerance  !< relative
    do level = 3, size(band) - 1
      if (first_error/band(level) <= tolerance) return
    end do
  end function first_level

  !> Scene on a mesh of the series; the user's sections, element and cells through the thickness stay.
  pure type(scene_t) function meshed(scene, level, steps) result(s)
    type(scene_t), intent(in) :: scene  !< scene
    integer, intent(in) :: level        !< of the series
    integer, intent(in) :: steps        !< load steps of the assembly, and of the torque
    s = scene
    s%band_facets = band(level)
    s%divisions = max(16, 2*nint(pi*scene%bore_radius*band(level)/(shape*scene%band_length)))
    s%ring_divisions = 0
    s%ring_facets = 0
    s%wall_elements = 0
    s%bottom_elements = 0
    s%assembly_steps = steps
    s%torque_steps = merge(steps, 0, scene%torque_steps > 0)
  end function meshed

  !> K_TS (Eq. 45), normal force and mid-band pressure of the last step.
  pure function quantities(run) result(q)
    type(run_t), intent(in) :: run  !< finished run
    real(dp) :: q(3)
    real(dp), allocatable :: lever(:)
    associate (f => run%facets)
      lever = f%x(1, :)*f%normal(2, :) - f%x(2, :)*f%normal(1, :)
      q = [sum(f%k_n*lever**2 + f%k_t*(f%x(1, :)**2 + f%x(2, :)**2 - lever**2)), run%sums%normal_force, &
        run%sums%pressure_middle]
    end associate
  end function quantities

  !> Solve the load steps of a new run; it stays open.
  subroutine solve(run, error)
    type(run_t), intent(inout) :: run                 !< new run, then at its end
    type(error_t), allocatable, intent(out) :: error  !< whatever ended it early
    logical :: done
    done = .false.
    do while (.not. (done .or. allocated(error)))
      call advance(run, done, error)
    end do
  end subroutine solve

  !> Results of a scene, nothing written.
  subroutine probe(scene, q, error)
    type(scene_t), intent(in) :: scene                !< scene
    real(dp), intent(out) :: q(3)                     !< quantities
    type(error_t), allocatable, intent(out) :: error  !< whatever ended it early
    type(run_t), allocatable :: run
    type(error_t), allocatable :: trouble
    allocate (run)
    q = 0
    call new_run(scene, '', '', .false., run, error)
    if (.not. allocated(error)) call solve(run, error)
    if (.not. allocated(error)) q = quantities(run)
    if (allocated(run%drive)) call finish(run, trouble)
  end subroutine probe

  !> Load steps whose halving changes little, and that change.
  subroutine choose_steps(scene, steps, change, error)
    type(scene_t), intent(in) :: scene                !< scene
    integer, intent(out) :: steps                     !< of the assembly, and of the torque
    real(dp), intent(out) :: change(3)                !< relative change of the quantities by halved steps
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a pilot early
    real(dp) :: coarse(3), fine(3)
    steps = 1
    call probe(meshed(scene, pilot, 1), coarse, error)
    do while (.not. allocated(error))
      call probe(meshed(scene, pilot, 2*steps), fine, error)
      change = abs(fine - coarse)/(abs(fine) + tiny(1._dp))
      if (maxval(change) <= 0.2_dp*scene%promise .or. steps >= 16) exit
      steps = 2*steps
      coarse = fine
    end do
  end subroutine choose_steps

  !> Large displacements where they change a coarse solution by more than half the tolerance; only for kinematics = 'auto'.
  subroutine choose_kinematics(scene, error)
    type(scene_t), intent(inout) :: scene             !< gets its kinematics
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a pilot early
    type(scene_t) :: large
    real(dp) :: small_q(3), large_q(3), change
    if (scene%kinematics /= 'auto') return
    scene%kinematics = 'linear'
    large = scene
    large%kinematics = 'nonlinear'
    if (scene%support == 'teeth' .or. .not. (scene%method == 'auto' .or. scene%method == 'newton')) return
    call probe(meshed(scene, pilot, 2), small_q, error)
    if (.not. allocated(error)) call probe(meshed(large, pilot, 2), large_q, error)
    if (allocated(error)) return
    change = maxval(abs(large_q - small_q)/(abs(large_q) + tiny(1._dp)))
    if (change > 0.5_dp*scene%promise) scene%kinematics = 'nonlinear'
    call say('plan      kinematics '//trim(scene%kinematics)//': large displacements change '//to_text(change))
  end subroutine choose_kinematics

  !> Estimated relative errors from three levels, against a mesh three refinements finer.
  pure function estimated(q) result(e)
    real(dp), intent(in) :: q(:, :)  !< quantities of three levels, the finest last (3, 3)
    real(dp) :: e(3), last(3), before(3), r(3)
    last = abs(q(:, 3) - q(:, 2))
    before = abs(q(:, 2) - q(:, 1))
    r = min(max(last/(before + tiny(1._dp)), slowest), 0.95_dp)
    e = max(last, 0.5_dp*abs(q(:, 3) - q(:, 1)))*(r + r**2 + r**3)/(abs(q(:, 3)) + tiny(1._dp))
  end function estimated

  !> Choose kinematics, load steps and mesh; refine until the estimate is within the tolerance.
  subroutine plan_scene(scene, plan, error)
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    type(plan_t), intent(out) :: plan                 !< what to run
    type(error_t), allocatable, intent(out) :: error  !< whatever ended a probe early
    type(error_t), allocatable :: trouble
    type(scene_t) :: s
    real(dp) :: q(3, size(band)), change(3)
    integer :: level, start, steps
    plan%scene = scene
    s = scene
    call choose_kinematics(s, trouble)
    if (.not. allocated(trouble)) call choose_steps(s, steps, change, trouble)
    if (allocated(trouble)) then
      call say('plan      a pilot ended early; the scene is run as it stands')
      return
    end if
    call say('plan      load steps '//to_text(steps)//' + '//to_text(steps)//': halving them changes '// &
      to_text(maxval(change)))
    start = first_level(scene%promise)
    do while (start > 3 .and. .not. fits(meshed(s, start, steps)))
      start = start - 1
    end do
    do level = start - 2, size(band)
      plan%scene = meshed(s, level, steps)
      call probe(plan%scene, q(:, level), error)
      if (allocated(error)) return
      if (level < start) cycle
      plan%level = level
      plan%estimate = estimated(q(:, level - 2:level)) + change
      plan%met = maxval(plan%estimate) <= scene%promise
      call say('plan      level '//to_text(level)//', '//to_text(plan%scene%divisions)//' x '// &
        to_text(plan%scene%band_facets)//' facets: estimated error '//to_text(maxval(plan%estimate))//', tolerance '// &
        to_text(scene%promise))
      if (plan%met .or. level == size(band)) exit
      if (.not. fits(meshed(s, level + 1, steps))) exit
    end do
  end subroutine plan_scene

  !> Plan a scene and set up its run.
  subroutine new_planned_run(scene, input, folder, force, run, error)
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    character(len=*), intent(in) :: input             !< name of the input, for the record
    character(len=*), intent(in) :: folder            !< output folder or ''
    logical, intent(in) :: force                      !< replace earlier results
    type(run_t), intent(inout) :: run                 !< run at rest
    type(error_t), allocatable, intent(out) :: error  !< folder, mesh, files, memory, whatever ended a probe early
    type(plan_t) :: plan
    if (len(folder) > 0) call check_folder(folder, force, error)  ! before the long work
    if (.not. allocated(error)) call plan_scene(scene, plan, error)
    if (.not. allocated(error)) call new_run(plan%scene, input, folder, force, run, error)
    if (allocated(error) .or. plan%level == 0) return
    run%record%promise = scene%promise
    run%record%estimate = plan%estimate
    run%record%level = plan%level
    if (.not. plan%met) &
      call push(run%record%warnings, 'the tolerance is not met: estimated error '//to_text(maxval(plan%estimate)))
  end subroutine new_planned_run

  !> Plan a scene and run it.
  subroutine run_planned(scene, input, folder, force, error)
    type(scene_t), intent(in) :: scene                !< scene with a tolerance
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    type(error_t), allocatable, intent(out) :: error  !< whatever ended the run early
    type(error_t), allocatable :: trouble
    type(run_t), allocatable :: run
    allocate (run)
    call new_planned_run(scene, input, folder, force, run, error)
    if (allocated(error)) return
    call solve(run, error)
    call finish(run, trouble)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
  end subroutine run_planned

  !> A mesh is within the memory allowed.
  logical function fits(scene)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp) :: limit
    limit = allowed_memory_mb(scene)
    fits = estimate_memory_mb(scene) < limit .or. limit <= 0
  end function fits

  !> The plan, with predicted time and memory, before anything is solved.
  function plan_text(scene) result(text)
    type(scene_t), intent(in) :: scene  !< scene
    character(len=:), allocatable :: text
    type(scene_t) :: s
    character(len=100) :: line
    character(len=1), parameter :: nl = new_line('a')
    real(dp) :: dof, seconds
    integer :: level
    text = 'series of meshes; a run starts at the level marked and refines until its estimated error is below '// &
      to_text(scene%promise)//nl//'level divisions band      dof  error/% expected  seconds       MB'
    do level = 1, size(band)
      s = meshed(scene, level, 4)
      dof = 3*s%divisions*((s%through_wall + 1)*(s%cup_length + s%bore_radius - s%hub_radius)/s%band_length*band(level) + &
        (s%through_ring + 1)*(band(level) + 1))
      seconds = 1.3_dp*(dof/52890)**1.4_dp
      write (line, '(i5,i10,i5,i9,f18.2,f9.1,f9.0,a)') level, s%divisions, band(level), nint(dof), 100*first_error/band(level), &
        seconds, estimate_memory_mb(s), trim(merge(' <- start', '         ', level == first_level(scene%promise)))
      text = text//nl//trim(line)
    end do
    text = text//nl//'element '//trim(s%element)//', solver '//trim(s%method)//', symmetry '//trim(s%symmetry)// &
      ', kinematics '//trim(s%kinematics)// &
      '; load steps: 1 + 1, doubled while that changes more than a fifth of the tolerance'
  end function plan_text
end module hd_planner
