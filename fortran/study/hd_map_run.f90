! SPDX-License-Identifier: GPL-3.0-or-later
!> A run that generates a surface: heights.npy, structure.csv, summary.json. No contact.
module hd_map_run
  use hd_kinds, only: dp, sp, i8, pi
  use hd_clock, only: wall_seconds, timestamp, peak_memory_mb
  use hd_error, only: error_t, raise, code_file, code_memory, code_done
  use hd_heights, only: method_t, choose_method, heights, heights_single
  use hd_input, only: write_echo
  use hd_json, only: json_t
  use hd_log, only: say
  use hd_npy, only: write_npy
  use hd_scene, only: scene_t, map_t
  use hd_structure_function, only: structure_line
  use hd_system, only: make_directory, remove_file, path_kind, path_absent, path_directory
  use hd_table, only: table_t
  use hd_text, only: to_text
  use hd_version, only: version
  use hd_waves, only: spectrum_t, waves_t, grid_t, count_waves, checked_grid, new_waves
  implicit none
  private
  public :: check_map_run, run_map

  character(len=7), parameter :: methods(0:3) = [character(len=7) :: 'auto', 'direct', 'product', 'nufft']

contains

  !> Refuse what cannot be generated.
  subroutine check_map_run(scene, error)
    type(scene_t), intent(in) :: scene                !< scene with a map
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    type(method_t) :: method
    call prepare(scene%map, method, error)
  end subroutine check_map_run

  !> Generate and write.
  subroutine run_map(scene, input, folder, force, error)
    type(scene_t), intent(in) :: scene                !< scene with a map
    character(len=*), intent(in) :: input             !< name of the input, for the record
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    type(error_t), allocatable, intent(out) :: error  !< files, memory
    type(method_t) :: method
    type(waves_t) :: w
    real(dp), allocatable :: z(:, :)
    real(sp), allocatable :: z_4(:, :)
    character(len=25) :: started
    real(dp) :: clock
    integer :: status
    started = timestamp()
    call prepare(scene%map, method, error)
    if (.not. allocated(error)) call open_folder(folder, scene, force, error)
    if (.not. allocated(error)) call new_waves(spectrum_of(scene%map), w, error)
    if (allocated(error)) return
    call say('surface   '//to_text(scene%map%nx)//' x '//to_text(scene%map%ny)//' points, '//to_text(size(w%fx))//' waves, '// &
      trim(methods(method%evaluator)))
    allocate (z(merge(scene%map%nx, 0, scene%map%precision == 'double'), scene%map%ny), stat=status)
    if (status == 0) allocate (z_4(merge(scene%map%nx, 0, scene%map%precision == 'single'), scene%map%ny), stat=status)
    if (status /= 0) then
      call raise(error, code_memory, 'not enough memory for the heights')
      return
    end if
    clock = wall_seconds()
    if (scene%map%precision == 'double') then
      call heights(w, grid_of(scene%map), method, z, error)
    else
      call heights_single(w, grid_of(scene%map), method, z_4, error)
    end if
    clock = wall_seconds() - clock
    if (allocated(error)) return
    if (scene%map%precision == 'double') then
      call write_npy(folder//'/heights.npy', z, error)
    else
      call write_npy(folder//'/heights.npy', z_4, error)
      if (.not. allocated(error)) z = real(z_4, dp)
    end if
    if (.not. allocated(error)) call write_structure(folder//'/structure.csv', scene%map, w, z, error)
    if (.not. allocated(error)) call write_map_summary(folder//'/summary.json', scene, input, started, w, method, clock, z, error)
    if (.not. allocated(error)) call say('results   '//folder)
  end subroutine run_map

  !> Check everything and choose the evaluator.
  subroutine prepare(m, method, error)
    type(map_t), intent(in) :: m                      !< map
    type(method_t), intent(out) :: method             !< evaluator
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    integer(i8) :: count
    integer :: n_max
    call count_waves(spectrum_of(m), n_max, count, error)
    if (.not. allocated(error)) call checked_grid(grid_of(m), error)
    if (.not. allocated(error)) call choose_method(m%nx, m%ny, count, (n_max + 1_i8) * (m%ridges / 2 + 1), m%tolerance, &
      merge(8, 4, m%precision == 'double'), findloc(methods == m%method, .true., 1) - 1, method, error)
  end subroutine prepare

  !> Spectrum of a map.
  pure type(spectrum_t) function spectrum_of(m)
    type(map_t), intent(in) :: m    !< map
    spectrum_of = spectrum_t(m%fractal_dimension, m%roughness, m%gamma, m%length, m%shortest_wavelength, m%ridges, int(m%seed, i8))
  end function spectrum_of

  !> Grid of a map.
  pure type(grid_t) function grid_of(m)
    type(map_t), intent(in) :: m    !< map
    grid_of = grid_t(m%nx, m%ny, m%dx, m%dy, m%x_0, m%y_0)
  end function grid_of

  !> Prepare the folder; earlier results are only replaced with `force`.
  subroutine open_folder(folder, scene, force, error)
    character(len=*), intent(in) :: folder            !< folder
    type(scene_t), intent(in) :: scene                !< scene
    logical, intent(in) :: force                      !< replace earlier results
    type(error_t), allocatable, intent(out) :: error  !< exists already, cannot be written
    if (path_kind(folder) /= path_absent .and. path_kind(folder) /= path_directory) then
      call raise(error, code_file, "'"//folder//"' is a file, not a folder: choose another with --out DIR")
    else if (path_kind(folder//'/echo.nml') /= path_absent .and. .not. force) then
      call raise(error, code_file, "'"//folder//"' holds an earlier run: add --force to replace it, or choose another "// &
        'folder with --out DIR')
    end if
    if (.not. allocated(error)) call make_directory(folder, error)
    if (allocated(error)) return
    call remove_file(folder//'/summary.json')
    call write_echo(folder//'/echo.nml', scene, error)
  end subroutine open_folder

  !> S along rows and columns, and what random phases give on average; lags double, from one point to half the map.
  subroutine write_structure(path, m, w, z, error)
    character(len=*), intent(in) :: path                !< file
    type(map_t), intent(in) :: m                        !< map
    type(waves_t), intent(in) :: w                      !< its waves
    real(dp), intent(in), contiguous :: z(:, :)         !< heights [m]
    type(error_t), allocatable, intent(out) :: error    !< cannot be written
    type(table_t) :: table
    real(dp) :: s(1), count(1)
    integer :: lag, axis, step(2)
    call table%open(path, 'direction,lag_points,lag_m,s_m2,s_expected_m2', error)
    if (allocated(error)) return
    do axis = 1, 2
      step = merge(1, 0, [1, 2] == axis)
      lag = 1
      do while (2 * lag <= size(z, axis))
        call structure_line(z, step, [lag], s, count, error)
        if (allocated(error)) return
        call table%add(merge('rows   ', 'columns', axis == 1))
        call table%add(lag)
        call table%add(lag * merge(m%dx, m%dy, axis == 1))
        call table%add(s(1))
        call table%add(sum(w%amplitude**2 * (1 - cos(2 * pi * lag * (w%fx * m%dx * step(1) + w%fy * m%dy * step(2))))))
        call table%end_row(error)
        if (allocated(error)) return
        lag = 2 * lag
      end do
    end do
    call table%close()
  end subroutine write_structure

  !> summary.json, written last.
  subroutine write_map_summary(path, scene, input, started, w, method, seconds, z, error)
    character(len=*), intent(in) :: path, input, started    !< file, name of the input, time
    type(scene_t), intent(in) :: scene                      !< scene
    type(waves_t), intent(in) :: w                          !< waves
    type(method_t), intent(in) :: method                    !< evaluator
    real(dp), intent(in) :: seconds                         !< wall clock of the sum [s]
    real(dp), intent(in), contiguous :: z(:, :)             !< heights [m]
    type(error_t), allocatable, intent(out) :: error        !< cannot be written
    type(json_t) :: json
    real(dp) :: mean
    mean = sum(z) / size(z, kind=i8)
    call json%begin()
    call json%add('status', 'complete')
    call json%add('code', code_done)
    call json%add('message', '')
    call json%begin('results')
    call json%add('height_rms_m', sqrt(sum((z - mean)**2) / size(z, kind=i8)))
    call json%add('height_rms_expected_m', sqrt(sum(w%amplitude**2) / 2))
    call json%add('slope_rms_expected', 2 * pi * sqrt(sum((w%amplitude * w%fx)**2 + (w%amplitude * w%fy)**2) / 2))
    call json%add('height_min_m', minval(z))
    call json%add('height_max_m', maxval(z))
    call json%finish()
    call json%begin('generator')
    call json%add('waves', size(w%fx))
    call json%add('method', trim(methods(method%evaluator)))
    call json%add('sum_s', seconds)
    call json%add('peak_memory_mb', peak_memory_mb())
    call json%finish()
    call json%begin('provenance')
    call json%add('title', trim(scene%title))
    call json%add('input', input)
    call json%add('started', trim(started))
    call json%add('version', version)
    call json%finish()
    call json%finish()
    call json%write_atomic(path, error)
  end subroutine write_map_summary
end module hd_map_run
