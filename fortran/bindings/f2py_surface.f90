! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: surfaces. Arrays come from Python in Fortran order, or as their address, and are filled in place.
module f2py_surface
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_int64_t, c_float, c_f_pointer, c_null_ptr
  use hd_error, only: error_t
  use hd_periodic, only: check_periodic, periodic_surface
  use hd_status, only: tell, lines_of
  use hd_heights, only: method_t, choose_method, heights, heights_single
  use hd_waves, only: spectrum_t, grid_t, waves_t, count_waves, checked_grid, new_waves, free_waves
  use hd_input, only: read_scene, surface_scene_of
  use hd_output, only: result_files
  use hd_surface_run, only: run_surface
  use hd_scene, only: scene_t
  use hd_text, only: string_t
  implicit none
  private
  public :: surface_check_periodic, surface_periodic, surface_method, surface_heights, surface_waves, surface_free_method, &
    surface_free_heights, surface_run

contains

  !> Refuse a periodic surface before its memory is asked for.
  subroutine surface_check_periodic(n, length, fractal_dimension, roughness, shortest, status)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: length, fractal_dimension, roughness, shortest
    integer(c_int), intent(out) :: status
    type(error_t), allocatable :: error
    call check_periodic(n, length, fractal_dimension, roughness, shortest, error)
    call tell(error, status)
  end subroutine surface_check_periodic

  !> Fill heights with a periodic surface.
  subroutine surface_periodic(n, length, fractal_dimension, roughness, shortest, seed, heights, status)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: length, fractal_dimension, roughness, shortest
    integer(c_int64_t), intent(in) :: seed
    real(c_double), intent(inout) :: heights(n, n)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(heights) :: n = shape(heights, 0)
    !f2py threadsafe
    type(error_t), allocatable :: error
    call periodic_surface(length, fractal_dimension, roughness, shortest, seed, heights, error)
    call tell(error, status)
  end subroutine surface_periodic

  !> Choose the evaluator, after everything is checked: (n_max, waves, evaluator, predicted seconds, memory).
  subroutine surface_method(p, ridges, seed, grid, nx, ny, tolerance, bytes, wanted, n_max, waves, evaluator, seconds, memory_mb, &
    status)
    real(c_double), intent(in) :: p(5), grid(4), tolerance
    integer(c_int), intent(in) :: ridges, nx, ny, bytes, wanted
    integer(c_int64_t), intent(in) :: seed
    integer(c_int), intent(out) :: n_max, evaluator, status
    integer(c_int64_t), intent(out) :: waves
    real(c_double), intent(out) :: seconds(3), memory_mb
    type(spectrum_t) :: s
    type(grid_t) :: g
    type(method_t) :: method
    type(error_t), allocatable :: error
    call read_entry(p, ridges, seed, grid, nx, ny, tolerance, bytes, wanted, s, g, n_max, waves, method, error)
    evaluator = method%evaluator
    seconds = method%seconds
    memory_mb = method%memory_mb
    call tell(error, status)
  end subroutine surface_method

  !> Fill heights of Eq. 1 at an address (`fill`). p: D, G, gamma, L, L_s; grid: dx, dy, x_0, y_0.
  subroutine surface_heights(p, ridges, seed, grid, nx, ny, tolerance, bytes, wanted, address, status)
    real(c_double), intent(in) :: p(5), grid(4), tolerance
    integer(c_int), intent(in) :: ridges, nx, ny, bytes, wanted
    integer(c_int64_t), intent(in) :: seed, address
    integer(c_int), intent(out) :: status
    !f2py threadsafe
    type(spectrum_t) :: s
    type(grid_t) :: g
    type(method_t) :: method
    type(waves_t) :: w
    type(error_t), allocatable :: error
    integer :: n_max
    integer(c_int64_t) :: waves
    call read_entry(p, ridges, seed, grid, nx, ny, tolerance, bytes, wanted, s, g, n_max, waves, method, error)
    if (.not. allocated(error)) call new_waves(s, w, error)
    if (.not. allocated(error)) call fill(w, g, method, bytes, address, error)
    call tell(error, status)
  end subroutine surface_heights

  !> Count of waves, then the waves of Eq. 1: wave numbers [1/m], amplitudes [m], phases [turns].
  subroutine surface_waves(p, ridges, seed, count, fx, fy, amplitude, phase, offset, status)
    integer(c_int), intent(in) :: count
    real(c_double), intent(in) :: p(5)
    integer(c_int), intent(in) :: ridges
    integer(c_int64_t), intent(in) :: seed
    real(c_double), intent(out) :: fx(count), fy(count), amplitude(count), phase(count), offset
    integer(c_int), intent(out) :: status
    type(waves_t) :: w
    type(error_t), allocatable :: error
    call new_waves(spectrum_t(p(1), p(2), p(3), p(4), p(5), ridges, seed), w, error)
    if (.not. allocated(error)) then
      fx = real(w%fx, c_double)
      fy = real(w%fy, c_double)
      amplitude = w%amplitude
      phase = w%phase
      offset = w%offset
    end if
    call tell(error, status)
  end subroutine surface_waves

  !> Choose the evaluator of free waves, after everything is checked.
  subroutine surface_free_method(count, grid, nx, ny, tolerance, bytes, wanted, evaluator, status)
    real(c_double), intent(in) :: grid(4), tolerance
    integer(c_int), intent(in) :: count, nx, ny, bytes, wanted
    integer(c_int), intent(out) :: evaluator, status
    type(grid_t) :: g
    type(method_t) :: method
    type(error_t), allocatable :: error
    call read_free(count, grid, nx, ny, tolerance, bytes, wanted, g, method, error)
    evaluator = method%evaluator
    call tell(error, status)
  end subroutine surface_free_method

  !> Fill heights of free waves at an address (`fill`).
  subroutine surface_free_heights(count, fx, fy, amplitude, phase, grid, nx, ny, tolerance, bytes, wanted, address, status)
    integer(c_int), intent(in) :: count, nx, ny, bytes, wanted
    real(c_double), intent(in) :: fx(count), fy(count), amplitude(count), phase(count), grid(4), tolerance
    integer(c_int64_t), intent(in) :: address
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(fx) :: count = len(fx)
    !f2py threadsafe
    type(grid_t) :: g
    type(method_t) :: method
    type(waves_t) :: w
    type(error_t), allocatable :: error
    call read_free(count, grid, nx, ny, tolerance, bytes, wanted, g, method, error)
    if (.not. allocated(error)) then
      call free_waves(fx, fy, amplitude, phase, w)
      call fill(w, g, method, bytes, address, error)
    end if
    call tell(error, status)
  end subroutine surface_free_heights

  !> Run an input that holds only a surface; ran = 0 and nothing is done if it holds more.
  subroutine surface_run(path, assignments, folder, force, ran, status)
    character(len=*), intent(in) :: path, assignments, folder
    integer(c_int), intent(in) :: force
    integer(c_int), intent(out) :: ran, status
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(string_t), allocatable :: lines(:)
    type(scene_t), allocatable :: scene
    ran = 0
    allocate (scene)
    lines = lines_of(assignments)
    call read_scene(path, lines, scene, error)
    if (.not. allocated(error) .and. scene%surface_only) then
      ran = 1
      call run_surface(surface_scene_of(scene, trim(path)), trim(path), trim(folder), force /= 0, result_files, error)
    end if
    call tell(error, status)
  end subroutine surface_run

  !> Fill the heights of Python's array at an address, of 8 or 4 bytes each, first index along x.
  subroutine fill(w, g, method, bytes, address, error)
    type(waves_t), intent(in) :: w
    type(grid_t), intent(in) :: g
    type(method_t), intent(in) :: method
    integer(c_int), intent(in) :: bytes
    integer(c_int64_t), intent(in) :: address
    type(error_t), allocatable, intent(out) :: error
    real(c_double), pointer, contiguous :: z(:, :)
    real(c_float), pointer, contiguous :: z_single(:, :)
    if (bytes == 8) then
      call c_f_pointer(transfer(address, c_null_ptr), z, [g%nx, g%ny])
      call heights(w, g, method, z, error)
    else
      call c_f_pointer(transfer(address, c_null_ptr), z_single, [g%nx, g%ny])
      call heights_single(w, g, method, z_single, error)
    end if
  end subroutine fill

  !> Spectrum, grid and method.
  subroutine read_entry(p, ridges, seed, grid, nx, ny, tolerance, bytes, wanted, s, g, n_max, waves, method, error)
    real(c_double), intent(in) :: p(5)                !< D, G, gamma, L, L_s
    integer, intent(in) :: ridges                     !< M
    integer(c_int64_t), intent(in) :: seed            !< seed
    real(c_double), intent(in) :: grid(4)             !< dx, dy, x_0, y_0
    integer, intent(in) :: nx, ny                     !< points
    real(c_double), intent(in) :: tolerance           !< error allowed; 0: none
    integer, intent(in) :: bytes                      !< of a height
    integer, intent(in) :: wanted                     !< method_*
    type(spectrum_t), intent(out) :: s                !< spectrum
    type(grid_t), intent(out) :: g                    !< grid
    integer, intent(out) :: n_max                     !< largest exponent
    integer(c_int64_t), intent(out) :: waves          !< number of waves
    type(method_t), intent(out) :: method             !< evaluator
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    s = spectrum_t(p(1), p(2), p(3), p(4), p(5), ridges, seed)
    g = grid_t(nx, ny, grid(1), grid(2), grid(3), grid(4))
    call count_waves(s, n_max, waves, error)
    if (.not. allocated(error)) call checked_grid(g, error)
    if (.not. allocated(error)) then
      call choose_method(nx, ny, waves, (n_max + 1_c_int64_t) * (ridges / 2 + 1), tolerance, bytes, wanted, method, error)
    end if
  end subroutine read_entry

  !> Grid and method of free waves.
  subroutine read_free(count, grid, nx, ny, tolerance, bytes, wanted, g, method, error)
    integer, intent(in) :: count                      !< number of waves
    real(c_double), intent(in) :: grid(4)             !< dx, dy, x_0, y_0
    integer, intent(in) :: nx, ny                     !< points
    real(c_double), intent(in) :: tolerance           !< error allowed; 0: none
    integer, intent(in) :: bytes                      !< of a height
    integer, intent(in) :: wanted                     !< method_*
    type(grid_t), intent(out) :: g                    !< grid
    type(method_t), intent(out) :: method             !< evaluator
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    g = grid_t(nx, ny, grid(1), grid(2), grid(3), grid(4))
    call checked_grid(g, error)
    if (.not. allocated(error)) then
      call choose_method(nx, ny, int(count, c_int64_t), int(count, c_int64_t), tolerance, bytes, wanted, method, error)
    end if
  end subroutine read_free
end module f2py_surface
