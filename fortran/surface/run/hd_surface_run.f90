! SPDX-License-Identifier: GPL-3.0-or-later
!> A run that generates a surface or reads specimens, and fits D and G: heights, structure.csv, fit.csv, summary.json. No contact.
module hd_surface_run
  use hd_kinds, only: dp, sp, i8, pi
  use hd_clock, only: wall_seconds, timestamp
  use hd_error, only: error_t, raise, code_memory, code_done
  use hd_folder_lock, only: folder_lock_t
  use hd_heights, only: method_t, choose_method, heights, heights_single
  use hd_json, only: json_t
  use hd_log, only: say
  use hd_fit_report, only: specimen_t, found_t, read_specimens, fit_specimens, write_fits, add_fits
  use hd_memory, only: peak_memory_mb
  use hd_new_file, only: write_text
  use hd_npy, only: write_npy
  use hd_results_folder, only: check_input, check_folder, clear_folder
  use hd_surface_scene, only: surface_t, surface_scene_t
  use hd_structure_function, only: structure_line
  use hd_table, only: table_t
  use hd_text, only: to_text
  use hd_version, only: version
  use hd_waves, only: spectrum_t, waves_t, grid_t, count_waves, checked_grid, new_waves
  implicit none
  private
  public :: check_surface_run, run_surface, surface_files

  character(len=*), parameter :: structure_file = 'structure.csv', fit_file = 'fit.csv'
  character(len=*), parameter :: surface_files = structure_file//','//fit_file  !< besides heights, echo and summary

  character(len=7), parameter :: methods(0:3) = [character(len=7) :: 'auto', 'direct', 'product', 'nufft']

contains

  !> Refuse what cannot be generated or read.
  subroutine check_surface_run(scene, error)
    type(surface_scene_t), intent(in) :: scene        !< what is asked for
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    type(method_t) :: method
    integer :: n_max
    call prepare(scene%surface, method, n_max, error)
  end subroutine check_surface_run

  !> Generate or read, fit and write, alone in the folder.
  subroutine run_surface(scene, input, folder, force, stale, error)
    type(surface_scene_t), intent(in) :: scene        !< what is asked for
    character(len=*), intent(in) :: input             !< name of the input, for the record
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    character(len=*), intent(in) :: stale             !< names of files that earlier runs, also others, may have left
    type(error_t), allocatable, intent(out) :: error  !< files, memory
    type(folder_lock_t) :: lock
    call lock%take(folder, error)
    if (allocated(error)) return
    call fill_folder(scene, input, folder, force, stale, error)
    call lock%give()
  end subroutine run_surface

  !> Generate or read, fit and write.
  subroutine fill_folder(scene, input, folder, force, stale, error)
    type(surface_scene_t), intent(in) :: scene        !< what is asked for
    character(len=*), intent(in) :: input             !< name of the input, for the record
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    character(len=*), intent(in) :: stale             !< names of files that earlier runs, also others, may have left
    type(error_t), allocatable, intent(out) :: error  !< files, memory
    type(method_t) :: method
    type(waves_t) :: w
    type(specimen_t), allocatable :: s(:)
    type(found_t), allocatable :: found(:)
    type(json_t) :: json
    integer :: n_max, i
    logical :: files
    call json%begin()
    call json%add('status', 'complete')
    call json%add('code', code_done)
    call json%add('message', '')
    call json%add('kind', 'surface')
    call json%add('title', scene%title)
    call json%begin('provenance')
    call json%add('hdengine', version)
    call json%add('input', input)
    call json%add('started', timestamp())
    call json%finish()
    call prepare(scene%surface, method, n_max, error)
    if (allocated(error)) return
    files = len_trim(scene%fit%first_file) + len_trim(scene%fit%second_file) > 0
    if (files) call read_specimens(scene%fit, s, error)
    if (.not. allocated(error)) call check_input(input, stale, error)
    if (.not. allocated(error)) call check_folder(folder, stale, force, error)
    if (.not. allocated(error)) call clear_folder(folder, stale, error)
    if (.not. allocated(error)) call write_text(folder//'/echo.nml', scene%echo, error)
    if (allocated(error)) return
    if (files) then
      do i = 1, size(s)
        if (.not. allocated(error)) call write_npy(folder//'/'//trim(s(i)%name)//'.npy', s(i)%z, error)
      end do
    else
      call generate(scene%surface, method, folder, w, s, json, error)
      if (.not. allocated(error)) call write_structure(folder//'/'//structure_file, scene%surface, w, s(1)%z, error)
    end if
    if (.not. allocated(error)) call fit_specimens(scene%surface, scene%fit, s, n_max, found, error)
    if (.not. allocated(error)) call write_fits(folder//'/'//fit_file, found, error)
    if (allocated(error)) return
    call json%add('spacing_m', [s(1)%dy, s(1)%dx])
    call add_fits(json, found)
    call json%add('peak_memory_mb', peak_memory_mb())
    call json%seal(folder, stale//',heights.npy,first.npy,second.npy')
    call json%write_atomic(folder//'/summary.json', error)
    if (.not. allocated(error)) call say('results   '//folder)
  end subroutine fill_folder

  !> Generate a surface, write heights.npy and tell of it.
  subroutine generate(m, method, folder, w, s, json, error)
    type(surface_t), intent(in) :: m                            !< map
    type(method_t), intent(in) :: method                    !< evaluator
    character(len=*), intent(in) :: folder                  !< output folder
    type(waves_t), intent(out) :: w                         !< waves
    type(specimen_t), allocatable, intent(out) :: s(:)      !< the surface
    type(json_t), intent(inout) :: json                     !< summary
    type(error_t), allocatable, intent(out) :: error        !< files, memory
    real(sp), allocatable :: z_4(:, :)
    real(dp) :: clock, mean
    integer :: status
    call new_waves(spectrum_of(m), w, error)
    if (allocated(error)) return
    call say('surface   '//to_text(m%nx)//' x '//to_text(m%ny)//' points, '//to_text(size(w%fx))//' waves, '// &
      trim(methods(method%evaluator)))
    allocate (s(1))
    s(1)%name = 'generated'
    s(1)%dx = m%dx
    s(1)%dy = m%dy
    allocate (s(1)%z(m%nx, m%ny), stat=status)
    if (status == 0 .and. m%precision == 'single') allocate (z_4(m%nx, m%ny), stat=status)
    if (status /= 0) then
      call raise(error, code_memory, 'not enough memory for heights of '//to_text(m%nx)//' x '//to_text(m%ny)// &
        ' points: lower surface.nx and surface.ny')
      return
    end if
    clock = wall_seconds()
    if (m%precision == 'double') then
      call heights(w, grid_of(m), method, s(1)%z, error)
      if (.not. allocated(error)) call write_npy(folder//'/heights.npy', s(1)%z, error)
    else
      call heights_single(w, grid_of(m), method, z_4, error)
      if (.not. allocated(error)) call write_npy(folder//'/heights.npy', z_4, error)
      s(1)%z = z_4
    end if
    if (allocated(error)) return
    clock = wall_seconds() - clock
    associate (z => s(1)%z)
      mean = sum(z) / size(z, kind=i8)
      call json%begin('results')
      call json%add('height_rms_m', sqrt(sum((z - mean)**2) / size(z, kind=i8)))
      call json%add('height_rms_expected_m', sqrt(sum(w%amplitude**2) / 2))
      call json%add('slope_rms_expected', 2 * pi * sqrt(sum((w%amplitude * w%fx)**2 + (w%amplitude * w%fy)**2) / 2))
      call json%add('height_min_m', minval(z))
      call json%add('height_max_m', maxval(z))
      call json%finish()
    end associate
    call json%begin('generator')
    call json%add('waves', size(w%fx))
    call json%add('method', trim(methods(method%evaluator)))
    call json%add('sum_s', clock)
    call json%finish()
  end subroutine generate

  !> Check everything and choose the evaluator.
  subroutine prepare(m, method, n_max, error)
    type(surface_t), intent(in) :: m                      !< map
    type(method_t), intent(out) :: method             !< evaluator
    integer, intent(out) :: n_max                     !< highest exponent of Eq. 1
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    integer(i8) :: count
    call count_waves(spectrum_of(m), n_max, count, error)
    if (.not. allocated(error)) call checked_grid(grid_of(m), error)
    if (.not. allocated(error)) call choose_method(m%nx, m%ny, count, (n_max + 1_i8) * (m%ridges / 2 + 1), m%tolerance, &
      merge(8, 4, m%precision == 'double'), findloc(methods == m%method, .true., 1) - 1, method, error)
  end subroutine prepare

  !> Spectrum of a map.
  pure type(spectrum_t) function spectrum_of(m)
    type(surface_t), intent(in) :: m    !< map
    spectrum_of = spectrum_t(m%fractal_dimension, m%roughness, m%gamma, m%sample_length, m%shortest_wavelength, m%ridges, &
      int(m%seed, i8))
  end function spectrum_of

  !> Grid of a map.
  pure type(grid_t) function grid_of(m)
    type(surface_t), intent(in) :: m    !< map
    grid_of = grid_t(m%nx, m%ny, m%dx, m%dy)
  end function grid_of

  !> S along rows and columns, and what random phases give on average; lags double, from one point to half the map.
  subroutine write_structure(path, m, w, z, error)
    character(len=*), intent(in) :: path                !< file
    type(surface_t), intent(in) :: m                        !< map
    type(waves_t), intent(in) :: w                      !< its waves
    real(dp), intent(in), contiguous :: z(:, :)         !< heights [m]
    type(error_t), allocatable, intent(out) :: error    !< cannot be written
    type(table_t) :: table
    real(dp) :: s(1), count(1)
    integer :: lag, axis, step(2)
    call table%open(path, 'direction,lag_points,lag_m,s_m2,s_expected_m2', error)
    do axis = 1, 2
      step = merge(1, 0, [1, 2] == axis)
      lag = 1
      do while (2 * lag <= size(z, axis) .and. .not. allocated(error))
        call structure_line(z, step, [lag], s, count, error)
        if (allocated(error)) exit
        call table%add(merge('rows   ', 'columns', axis == 1))
        call table%add(lag)
        call table%add(lag * merge(m%dx, m%dy, axis == 1))
        call table%add(s(1))
        call table%add(sum(w%amplitude**2 * (1 - cos(2 * pi * lag * (w%fx * m%dx * step(1) + w%fy * m%dy * step(2))))))
        call table%end_row(error)
        lag = 2 * lag
      end do
    end do
    call table%close(error)
  end subroutine write_structure
end module hd_surface_run
