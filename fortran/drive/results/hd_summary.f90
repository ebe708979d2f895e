! SPDX-License-Identifier: GPL-3.0-or-later
!> summary.json: the last file of a run, and the proof that it ended as it says.
module hd_summary
  use, intrinsic :: iso_fortran_env, only: compiler_version, int64
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_checksum, only: file_checksum, hexadecimal, whole
  use hd_clock, only: timestamp
  use hd_cost, only: forecast_t
  use hd_drive, only: drive_t
  use hd_error, only: error_t, code_done, code_stopped
  use hd_facets, only: sums_t, sum_names, sum_values
  use hd_joint, only: joint_t
  use hd_json, only: json_t
  use hd_lapack, only: blas_kernels
  use hd_linear_solver, only: linear_solver_t
  use hd_model_error, only: covered, left_out
  use hd_loop, only: loop_t
  use hd_loop_results, only: loop_names, loop_values
  use hd_memory, only: peak_memory_mb
  use hd_model_comparison, only: add_models
  use hd_output, only: step_t, result_files
  use hd_parameters, only: parameter_table_t, new_table, value_count
  use hd_promises, only: promise_t, promises, values, promises_of, is_field
  use hd_scene, only: scene_t
  use hd_strength, only: strength_t
  use hd_system, only: stop_requested
  use hd_tolerance_band, only: tolerance_band_t
  use hd_timers, only: timers_t, add_timers
  use hd_twist_shares, only: part_names
  use hd_text, only: string_t, split
  use hd_persson_error, only: theory_error_t, steep
  use hd_version, only: version, lapack_version, fftw_version, metis_version, build_type
  implicit none
  private
  public :: tally_t, derivatives_t, record_t, write_summary, add_scene

  !> What a run counts from its first load step on, also where it was stopped in between.
  type :: tally_t
    integer :: iterations = 0, cuts = 0
    integer :: cycles = 0                !< attempts in which the contact states ran in a cycle and friction was softened
    character(len=8) :: symmetry(2) = '' !< part that was solved in assembly and torque: full, half, quarter
    character(len=32) :: start = ''      !< mesh that gave the first guesses
  end type tally_t

  !> Derivatives of results by keys.
  type :: derivatives_t
    type(string_t), allocatable :: results(:), keys(:)
    real(dp), allocatable :: value(:, :)   !< (keys, results); by a list of numbers where all change alike
  end type derivatives_t

  !> What a run has to say of itself.
  type :: record_t
    character(len=25) :: started = ''
    character(len=:), allocatable :: input
    logical :: interrupted = .false.   !< by a signal
    logical :: resumed = .false.       !< went on from a checkpoint; times are those since then
    logical :: kept = .false.          !< mesh and factors are those of an earlier run of the process
    type(forecast_t) :: choice         !< of the matrix solver, with what was predicted then
    type(timers_t) :: timers
    type(string_t), allocatable :: warnings(:)
    real(dp) :: planned_tolerance = 0            !< tolerance that was planned for, 0: none
    real(dp) :: to_limit(values) = 1   !< limits of fine meshes over what the mesh gives
    real(dp) :: shift(values) = 0      !< of a field: limits less what the mesh gives
    real(dp) :: limit(values) = 0      !< those limits at the last step; 0: none
    real(dp) :: estimate(promises) = 0 !< their estimated relative errors
    integer :: level = 0               !< of the series of meshes
    type(string_t), allocatable :: reasons(:) !< what the plan chose, and why
    real(dp), allocatable :: k_ts_by_model(:)  !< Eq. 45 of the last step by every model of the joint [N m/rad]
    integer :: steps = 0               !< load steps of the run
    type(tolerance_band_t) :: band     !< of a loop, if it was asked for
    type(derivatives_t) :: gradient    !< the same
    real(dp) :: slip_torque = 0        !< torque at which the contact slips as a whole, 0: not met [N m]
  end type record_t

contains

  !> Write the summary; `failure` is what ended the run early, if anything did.
  subroutine write_summary(folder, scene, drive, joint, solver, step, sums, strength, tally, record, loop, failure, error)
    character(len=*), intent(in) :: folder                    !< folder of the run
    type(scene_t), intent(in) :: scene                        !< scene
    type(drive_t), intent(in) :: drive                        !< drive
    type(joint_t), intent(in) :: joint                        !< joint
    class(linear_solver_t), intent(in) :: solver              !< linear solver
    type(step_t), intent(in) :: step                          !< of the results: the last one, or a loop's reference step
    type(sums_t), intent(in) :: sums                          !< its sums
    type(strength_t), intent(in) :: strength                  !< stresses of all steps
    type(tally_t), intent(in) :: tally                        !< counts
    type(record_t), intent(in) :: record                      !< times, plan, warnings
    type(loop_t), intent(in) :: loop                          !< of the whole drive
    type(error_t), allocatable, intent(in) :: failure         !< why the run ended early
    type(error_t), allocatable, intent(out) :: error          !< cannot be written
    type(json_t) :: json
    call json%begin()
    call add_outcome(json, record, failure)
    call json%add('kind', 'drive')
    call json%add('title', scene%title)
    call json%begin('results')
    call json%add('steps', record%steps)
    call json%add('iterations', tally%iterations)
    call json%add('cut_backs', tally%cuts)
    call json%add('cycles', tally%cycles)
    call add_results(json, sums, record)
    if (strength%flexspline > 0) call add_strength(json, scene, strength)
    if (scene%support%loop) call add_loop(json, scene, loop, step, sums, record%band)
    call json%finish()
    if (allocated(record%gradient%value)) call add_gradient(json, record%gradient)
    call add_joint(json, scene, joint, sums%theory)
    if (allocated(record%k_ts_by_model)) call add_models(json, scene, record%k_ts_by_model)
    call add_model(json, scene, drive, solver, tally, record)
    call add_predictions(json, record%choice)
    call add_timers(json, record%timers)
    call json%add('peak_memory_mb', peak_memory_mb())
    if (record%planned_tolerance > 0) call add_plan(json, scene, record)
    call json%begin('model_error')
    call add_lines(json, 'tolerance_covers', covered(scene, record%level > 0, record%limit))
    call add_lines(json, 'left_out', left_out(scene, sums, strength))
    call json%finish()
    call add_lines(json, 'warnings', record%warnings)
    call add_provenance(json, solver, record)
    call add_scene(json, scene)
    call add_input_files(json, scene)
    call json%seal(folder, result_files)
    call json%write_atomic(folder//'/summary.json', error)
  end subroutine write_summary

  !> How the run ended.
  subroutine add_outcome(json, record, failure)
    type(json_t), intent(inout) :: json                       !< document
    type(record_t), intent(in) :: record                      !< stopped by a signal
    type(error_t), allocatable, intent(in) :: failure         !< why it ended early
    if (allocated(failure)) then
      if (record%interrupted .or. (failure%code == code_stopped .and. stop_requested())) then  ! between load steps, or within one
        call json%add('status', 'interrupted')
      else
        call json%add('status', trim(merge('stopped_at_limit', 'failed          ', failure%code == code_stopped)))
      end if
      call json%add('code', failure%code)
      call json%add('message', failure%message)
    else
      call json%add('status', 'complete')
      call json%add('code', code_done)
      call json%add('message', '')
    end if
  end subroutine add_outcome

  !> Sizes, solver, symmetry.
  subroutine add_model(json, scene, drive, solver, tally, record)
    type(json_t), intent(inout) :: json                       !< document
    type(scene_t), intent(in) :: scene                        !< scene
    type(drive_t), intent(in) :: drive                        !< drive
    class(linear_solver_t), intent(in) :: solver              !< linear solver
    type(tally_t), intent(in) :: tally                        !< symmetry, first guesses
    type(record_t), intent(in) :: record                      !< what was kept
    call json%begin('model')
    call json%add('dof', 3*drive%problem%n)
    call json%add('unknowns', solver%unknowns)
    call json%add('facets', size(drive%face%nodes, 2))
    call json%add('multipliers', drive%problem%mortar%n)
    call json%add('factor_entries', solver%factor_entries)
    call json%add('factor_flops', solver%flops)
    call json%add('solver', trim(solver%name))
    call json%add('resumed', record%resumed)
    call json%add('mesh_and_factors', trim(merge('kept', 'new ', record%kept)))
    if (len_trim(tally%start) > 0) call json%add('first_guesses', trim(tally%start))
    call json%add('symmetry_assembly', trim(tally%symmetry(1)))
    call json%add('symmetry_torque', trim(tally%symmetry(2)))
    call json%add('inner_iterations', solver%inner)
    if (scene%support%struts .or. scene%support%against_teeth) call json%add('tooth_circle_m', scene%tooth_circle())
    call json%add('ordering_asked', trim(solver%ordering_asked))
    call json%add('ordering_used', trim(solver%ordering_used))
    call json%finish()
  end subroutine add_model

  !> What was promised, and whether it is kept.
  subroutine add_plan(json, scene, record)
    type(json_t), intent(inout) :: json                       !< document
    type(scene_t), intent(in) :: scene                        !< scene
    type(record_t), intent(in) :: record                      !< plan
    type(promise_t) :: promised(promises)
    real(dp) :: over(values), none
    integer :: i, a, b
    promised = promises_of(scene)
    none = ieee_value(1._dp, ieee_quiet_nan)
    over = 1
    where (abs(record%limit) > 0) over = (record%limit - record%shift)/(record%limit*record%to_limit)
    call json%begin('plan')
    call json%add('tolerance', record%planned_tolerance)
    do i = 1, promises
      a = promised(i)%first
      b = promised(i)%last
      if (.not. is_field(a)) b = a - 1 + findloc(abs(record%limit(a:b)) > 0, .true., 1, back=.true.)
      if (record%level == 0 .or. .not. any(abs(record%limit(a:b)) > 0)) cycle
      if (a == b) then
        call json%add(trim(promised(i)%column), record%limit(a))
        call json%add('mesh_over_limit_'//trim(promised(i)%name), over(a))
      else
        call json%add(trim(promised(i)%column), merge(record%limit(a:b), none, is_field(a) .or. abs(record%limit(a:b)) > 0))
        call json%add('mesh_over_limit_'//trim(promised(i)%name), over(a:b))
      end if
      call json%add('estimated_error_'//trim(promised(i)%name), record%estimate(i))
    end do
    call json%add('level', record%level)
    call add_lines(json, 'reasons', record%reasons)
    call json%add('met', trim(merge('yes', 'no ', record%level > 0 .and. maxval(record%estimate) <= record%planned_tolerance)))
    call json%finish()
  end subroutine add_plan

  !> Time and memory that the choice of the matrix solver rests on.
  subroutine add_predictions(json, choice)
    type(json_t), intent(inout) :: json        !< document
    type(forecast_t), intent(in) :: choice     !< as it was made
    integer :: i
    call json%begin('predicted')
    call json%add('solver', trim(choice%costs(choice%chosen)%name))
    call json%add('memory_allowed_mb', choice%memory_allowed_mb)
    do i = 1, size(choice%costs)
      associate (c => choice%costs(i))
        if (.not. c%applies) cycle
        call json%add(trim(c%name)//'_s', c%seconds)
        call json%add(trim(c%name)//'_mb', c%memory_mb)
      end associate
    end do
    call json%finish()
  end subroutine add_predictions

  !> Results of a converged step.
  subroutine add_results(json, sums, record)
    type(json_t), intent(inout) :: json      !< document
    type(sums_t), intent(in) :: sums         !< sums
    type(record_t), intent(in) :: record     !< slip torque
    type(string_t), allocatable :: names(:)
    real(dp), allocatable :: values(:)
    integer :: i
    names = split(sum_names)
    values = sum_values(sums)
    do i = 1, size(values)
      call json%add(names(i)%s, values(i))
    end do
    if (sums%cam_force > 0) then
      call json%add('cam_force_n', sums%cam_force)
      call json%add('cam_force_x_n', sums%cam_force_x)
      call json%add('cam_contact_area_m2', sums%cam_area)
      call json%add('cam_pressure_min_pa', sums%cam_pressure_min)
      call json%add('cam_gap_max_m', sums%cam_gap_max)
    end if
    if (record%slip_torque > 0) call json%add('gross_slip_torque_nm', record%slip_torque)
  end subroutine add_results

  !> Stresses and safeties of both bodies.
  subroutine add_strength(json, scene, strength)
    type(json_t), intent(inout) :: json          !< document
    type(scene_t), intent(in) :: scene           !< yield strengths
    type(strength_t), intent(in) :: strength     !< stresses of all steps
    call json%add('von_mises_max_pa', max(strength%flexspline, strength%ring))
    call json%add('flexspline_von_mises_max_pa', strength%flexspline)
    call json%add('flexspline_yield_safety', strength%flexspline_safety(scene))
    call json%add('ring_yield_safety', strength%ring_safety(scene))
  end subroutine add_strength

  !> What the loop of the whole drive says; a result that it has not is absent.
  subroutine add_loop(json, scene, loop, step, sums, band)
    type(json_t), intent(inout) :: json    !< document
    type(scene_t), intent(in) :: scene     !< T1, T2, rated torque
    type(loop_t), intent(in) :: loop       !< booked steps
    type(step_t), intent(in) :: step       !< reference step
    type(sums_t), intent(in) :: sums       !< its sums
    type(tolerance_band_t), intent(in) :: band       !< of the readings
    type(string_t), allocatable :: names(:)
    real(dp), allocatable :: found(:)
    integer :: i
    call json%add('reference_torque_nm', step%torque)
    call json%begin('twist_shares')
    do i = 1, size(part_names)
      call json%add(trim(part_names(i)), sums%shares(i))
    end do
    call json%finish()
    names = split(loop_names())
    found = loop_values(loop, scene, sums, band)
    do i = 1, size(found)
      if (found(i) == found(i)) call json%add(names(i)%s, found(i))
    end do
    if (allocated(band%input)) call add_shares(json, band)
    call json%add('wave_generator_torque_max_nm', loop%wave_generator_torque_max)
  end subroutine add_loop

  !> The inputs that make the band.
  subroutine add_shares(json, band)
    type(json_t), intent(inout) :: json     !< document
    type(tolerance_band_t), intent(in) :: band        !< with one input or more
    type(string_t), allocatable :: keys(:)
    real(dp), allocatable :: shares(:)
    integer :: i
    call band%ranked(keys, shares)
    call json%begin('band_shares')
    do i = 1, size(keys)
      call json%add(keys(i)%s, shares(i))
    end do
    call json%finish()
  end subroutine add_shares

  !> Derivatives by result and key.
  subroutine add_gradient(json, gradient)
    type(json_t), intent(inout) :: json           !< document
    type(derivatives_t), intent(in) :: gradient   !< derivatives
    integer :: i, j
    call json%begin('gradient')
    do j = 1, size(gradient%results)
      call json%begin(gradient%results(j)%s)
      do i = 1, size(gradient%keys)
        call json%add(gradient%keys(i)%s, gradient%value(i, j))
      end do
      call json%finish()
    end do
    call json%finish()
  end subroutine add_gradient

  !> Parameters that the joint results rest on.
  subroutine add_joint(json, scene, joint, theory)
    type(json_t), intent(inout) :: json  !< document
    type(scene_t), intent(in) :: scene   !< scene
    type(joint_t), intent(in) :: joint   !< joint
    type(theory_error_t), intent(in) :: theory  !< of a joint by theory
    call json%begin('joint')
    call json%add('model', trim(scene%joint_model))
    if (len_trim(scene%joint_reason) > 0) call json%add('chosen_because', trim(scene%joint_reason))
    call json%add('closure', trim(merge('paper  ', 'nominal', joint%paper)))
    call json%add('asperity_radius_m', joint%r_m)
    call json%add('s_min_m2', joint%s_min)
    call json%add('reference_area_m2', joint%reference_area)
    call json%add('hardness_pa', joint%asperity%hardness)
    call json%add('reduced_modulus_pa', joint%asperity%e_star)
    call json%add('s_ec_m2', joint%asperity%s_ec)
    call json%add('psi', joint%psi)
    if (theory%area > 0) then
      call json%begin('theory_error')
      call json%add('area_m2', theory%area)
      call json%add('mean_pressure_pa', theory%pressure)
      call json%add('contact_area_fraction', theory%share)
      call json%add('independent_waves', theory%waves)
      call json%add('e_star_slope_over_hardness', theory%steepness)
      if (theory%steepness <= steep) call json%add('ln_k_n_half_width', theory%half_width)
      if (abs(theory%tangent) > 0) call json%add('k_ts_tangent_change', theory%tangent)
      call json%finish()
    end if
    call json%finish()
  end subroutine add_joint

  !> A list of lines.
  subroutine add_lines(json, key, list)
    type(json_t), intent(inout) :: json      !< document
    character(len=*), intent(in) :: key      !< name
    type(string_t), intent(in) :: list(:)    !< lines
    character(len=:), allocatable :: lines(:)
    integer :: i
    allocate (character(len=maxval([(len(list(i)%s), i=1, size(list)), 1])) :: lines(size(list)))
    do i = 1, size(lines)
      lines(i) = list(i)%s
    end do
    call json%add(key, lines)
  end subroutine add_lines

  !> Versions, input, dates.
  subroutine add_provenance(json, solver, record)
    type(json_t), intent(inout) :: json            !< document
    class(linear_solver_t), intent(in) :: solver   !< knows the version of MUMPS
    type(record_t), intent(in) :: record           !< dates
    call json%begin('provenance')
    call json%add('hdengine', version)
    call json%add('input', record%input)
    call json%add('started', record%started)
    call json%add('finished', timestamp())
    call json%add('compiler', compiler_version())
    call json%add('build', build_type)
    call json%add('mumps', solver%library)
    call json%add('metis', metis_version)
    call json%add('lapack', lapack_version)
    call json%add('blas_kernels', blas_kernels())
    call json%add('fftw', fftw_version)
    call json%finish()
  end subroutine add_provenance

  !> Every key of the scene.
  subroutine add_scene(json, scene)
    type(json_t), intent(inout) :: json   !< document
    type(scene_t), intent(in) :: scene    !< scene
    type(scene_t), target :: copy
    type(parameter_table_t) :: table
    integer :: i
    copy = scene
    call new_table(copy, table)
    call json%begin('scene')
    do i = 1, size(table%rows)
      associate (p => table%rows(i))
        if (associated(p%integer)) call json%add(p%group//'.'//p%key, p%integer)
        if (associated(p%real)) call json%add(p%group//'.'//p%key, p%real)
        if (associated(p%reals)) call json%add(p%group//'.'//p%key, p%reals(:value_count(p)))
        if (associated(p%text)) call json%add(p%group//'.'//p%key, trim(p%text))
      end associate
    end do
    call json%finish()
  end subroutine add_scene

  !> Checksums of the tables that keys name.
  subroutine add_input_files(json, scene)
    type(json_t), intent(inout) :: json   !< document
    type(scene_t), intent(in) :: scene    !< scene
    if (scene%files == 0) return
    call json%begin('input_files')
    call add_file('wave_generator.cam_file', scene%cam_file)
    call add_file('joint.table_file', scene%joint_table)
    call add_file('joint.spectrum_file', scene%joint_spectrum)
    call json%finish()
  contains
    !> One of them.
    subroutine add_file(key, path)
      character(len=*), intent(in) :: key, path  !< key, file or ''
      integer(int64) :: sum
      integer :: status
      if (len_trim(path) == 0) return
      call file_checksum(trim(path), whole, sum, status)
      if (status == 0) call json%add(key, hexadecimal(sum))
    end subroutine add_file
  end subroutine add_input_files
end module hd_summary
