! SPDX-License-Identifier: GPL-3.0-or-later
! Flat entries for Python: surfaces. Arrays come from Python in Fortran order and are filled in place. Messages of entries that may
! take microseconds are short: Python asks for the rest.

!> Refuse a periodic surface before its memory is asked for.
subroutine surface_check_periodic(n, length, fractal_dimension, roughness, shortest, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_periodic, only: check_periodic
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: n
  real(c_double), intent(in) :: length, fractal_dimension, roughness, shortest
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  type(error_t), allocatable :: error
  call check_periodic(n, length, fractal_dimension, roughness, shortest, error)
  call tell(error, status, message)
end subroutine surface_check_periodic

!> Fill heights with a periodic surface.
subroutine surface_periodic(n, length, fractal_dimension, roughness, shortest, seed, heights, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_int64_t
  use hd_error, only: error_t
  use hd_periodic, only: periodic_surface
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: n
  real(c_double), intent(in) :: length, fractal_dimension, roughness, shortest
  integer(c_int64_t), intent(in) :: seed
  real(c_double), intent(inout) :: heights(n, n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(heights) :: n = shape(heights, 0)
  !f2py threadsafe
  type(error_t), allocatable :: error
  call periodic_surface(length, fractal_dimension, roughness, shortest, seed, heights, error)
  call tell(error, status, message)
end subroutine surface_periodic

!> Choose the evaluator, after everything is checked: (n_max, waves, evaluator, predicted seconds, memory).
subroutine surface_method(p, ridges, seed, grid, nx, ny, tolerance, bytes, wanted, n_max, waves, evaluator, seconds, memory_mb, &
  status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_int64_t
  use hd_error, only: error_t
  use hd_heights, only: method_t
  use hd_status, only: tell
  use hd_surface_entry, only: read_entry
  use hd_waves, only: spectrum_t, grid_t
  implicit none
  real(c_double), intent(in) :: p(5), grid(4), tolerance
  integer(c_int), intent(in) :: ridges, nx, ny, bytes, wanted
  integer(c_int64_t), intent(in) :: seed
  integer(c_int), intent(out) :: n_max, evaluator, status
  integer(c_int64_t), intent(out) :: waves
  real(c_double), intent(out) :: seconds(3), memory_mb
  character(len=8192), intent(out) :: message
  type(spectrum_t) :: s
  type(grid_t) :: g
  type(method_t) :: method
  type(error_t), allocatable :: error
  call read_entry(p, ridges, seed, grid, nx, ny, tolerance, bytes, wanted, s, g, n_max, waves, method, error)
  evaluator = method%evaluator
  seconds = method%seconds
  memory_mb = method%memory_mb
  call tell(error, status, message)
end subroutine surface_method

!> Fill heights of Eq. 1 in double precision. p: D, G, gamma, L, L_s; grid: dx, dy, x_0, y_0.
subroutine surface_heights(p, ridges, seed, grid, tolerance, wanted, nx, ny, heights_out, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_int64_t
  use hd_error, only: error_t
  use hd_heights, only: method_t, heights
  use hd_status, only: tell
  use hd_surface_entry, only: read_entry
  use hd_waves, only: spectrum_t, grid_t, waves_t, new_waves
  implicit none
  integer(c_int), intent(in) :: nx, ny
  real(c_double), intent(in) :: p(5), grid(4), tolerance
  integer(c_int), intent(in) :: ridges, wanted
  integer(c_int64_t), intent(in) :: seed
  real(c_double), intent(inout) :: heights_out(nx, ny)
  integer(c_int), intent(out) :: status
  character(len=120), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(heights_out) :: nx = shape(heights_out, 0)
  !f2py integer(c_int), intent(hide), depend(heights_out) :: ny = shape(heights_out, 1)
  !f2py threadsafe
  type(spectrum_t) :: s
  type(grid_t) :: g
  type(method_t) :: method
  type(waves_t) :: w
  type(error_t), allocatable :: error
  integer :: n_max
  integer(c_int64_t) :: waves
  call read_entry(p, ridges, seed, grid, nx, ny, tolerance, 8, wanted, s, g, n_max, waves, method, error)
  if (.not. allocated(error)) call new_waves(s, w, error)
  if (.not. allocated(error)) call heights(w, g, method, heights_out, error)
  call tell(error, status, message)
end subroutine surface_heights

!> The same in single precision.
subroutine surface_heights_single(p, ridges, seed, grid, tolerance, wanted, nx, ny, heights_out, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_int64_t, c_float
  use hd_error, only: error_t
  use hd_heights, only: method_t, heights_single
  use hd_status, only: tell
  use hd_surface_entry, only: read_entry
  use hd_waves, only: spectrum_t, grid_t, waves_t, new_waves
  implicit none
  integer(c_int), intent(in) :: nx, ny
  real(c_double), intent(in) :: p(5), grid(4), tolerance
  integer(c_int), intent(in) :: ridges, wanted
  integer(c_int64_t), intent(in) :: seed
  real(c_float), intent(inout) :: heights_out(nx, ny)
  integer(c_int), intent(out) :: status
  character(len=120), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(heights_out) :: nx = shape(heights_out, 0)
  !f2py integer(c_int), intent(hide), depend(heights_out) :: ny = shape(heights_out, 1)
  !f2py threadsafe
  type(spectrum_t) :: s
  type(grid_t) :: g
  type(method_t) :: method
  type(waves_t) :: w
  type(error_t), allocatable :: error
  integer :: n_max
  integer(c_int64_t) :: waves
  call read_entry(p, ridges, seed, grid, nx, ny, tolerance, 4, wanted, s, g, n_max, waves, method, error)
  if (.not. allocated(error)) call new_waves(s, w, error)
  if (.not. allocated(error)) call heights_single(w, g, method, heights_out, error)
  call tell(error, status, message)
end subroutine surface_heights_single

!> Count of waves, then the waves of Eq. 1: wave numbers [1/m], amplitudes [m], phases [turns].
subroutine surface_waves(p, ridges, seed, count, fx, fy, amplitude, phase, offset, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_int64_t
  use hd_error, only: error_t
  use hd_status, only: tell
  use hd_waves, only: spectrum_t, waves_t, new_waves
  implicit none
  integer(c_int), intent(in) :: count
  real(c_double), intent(in) :: p(5)
  integer(c_int), intent(in) :: ridges
  integer(c_int64_t), intent(in) :: seed
  real(c_double), intent(out) :: fx(count), fy(count), amplitude(count), phase(count), offset
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  type(waves_t) :: w
  type(error_t), allocatable :: error
  fx = 0
  fy = 0
  amplitude = 0
  phase = 0
  offset = 0
  call new_waves(spectrum_t(p(1), p(2), p(3), p(4), p(5), ridges, seed), w, error)
  if (.not. allocated(error)) then
    fx = real(w%fx, c_double)
    fy = real(w%fy, c_double)
    amplitude = w%amplitude
    phase = w%phase
    offset = w%offset
  end if
  call tell(error, status, message)
end subroutine surface_waves

!> Choose the evaluator of free waves, after everything is checked.
subroutine surface_free_method(count, grid, nx, ny, tolerance, bytes, wanted, evaluator, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_heights, only: method_t
  use hd_surface_entry, only: read_free
  use hd_status, only: tell
  use hd_waves, only: grid_t
  implicit none
  real(c_double), intent(in) :: grid(4), tolerance
  integer(c_int), intent(in) :: count, nx, ny, bytes, wanted
  integer(c_int), intent(out) :: evaluator, status
  character(len=8192), intent(out) :: message
  type(grid_t) :: g
  type(method_t) :: method
  type(error_t), allocatable :: error
  call read_free(count, grid, nx, ny, tolerance, bytes, wanted, g, method, error)
  evaluator = method%evaluator
  call tell(error, status, message)
end subroutine surface_free_method

!> Fill heights of free waves.
subroutine surface_free_heights(count, fx, fy, amplitude, phase, grid, tolerance, wanted, nx, ny, heights_out, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_heights, only: method_t, heights
  use hd_surface_entry, only: read_free
  use hd_status, only: tell
  use hd_waves, only: grid_t, waves_t, free_waves
  implicit none
  integer(c_int), intent(in) :: count, nx, ny
  real(c_double), intent(in) :: fx(count), fy(count), amplitude(count), phase(count), grid(4), tolerance
  integer(c_int), intent(in) :: wanted
  real(c_double), intent(inout) :: heights_out(nx, ny)
  integer(c_int), intent(out) :: status
  character(len=120), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(fx) :: count = len(fx)
  !f2py integer(c_int), intent(hide), depend(heights_out) :: nx = shape(heights_out, 0)
  !f2py integer(c_int), intent(hide), depend(heights_out) :: ny = shape(heights_out, 1)
  !f2py threadsafe
  type(grid_t) :: g
  type(method_t) :: method
  type(waves_t) :: w
  type(error_t), allocatable :: error
  call read_free(count, grid, nx, ny, tolerance, 8, wanted, g, method, error)
  if (.not. allocated(error)) then
    call free_waves(fx, fy, amplitude, phase, w)
    call heights(w, g, method, heights_out, error)
  end if
  call tell(error, status, message)
end subroutine surface_free_heights

!> The same in single precision.
subroutine surface_free_heights_single(count, fx, fy, amplitude, phase, grid, tolerance, wanted, nx, ny, heights_out, status, &
  message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_float
  use hd_error, only: error_t
  use hd_heights, only: method_t, heights_single
  use hd_surface_entry, only: read_free
  use hd_status, only: tell
  use hd_waves, only: grid_t, waves_t, free_waves
  implicit none
  integer(c_int), intent(in) :: count, nx, ny
  real(c_double), intent(in) :: fx(count), fy(count), amplitude(count), phase(count), grid(4), tolerance
  integer(c_int), intent(in) :: wanted
  real(c_float), intent(inout) :: heights_out(nx, ny)
  integer(c_int), intent(out) :: status
  character(len=120), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(fx) :: count = len(fx)
  !f2py integer(c_int), intent(hide), depend(heights_out) :: nx = shape(heights_out, 0)
  !f2py integer(c_int), intent(hide), depend(heights_out) :: ny = shape(heights_out, 1)
  !f2py threadsafe
  type(grid_t) :: g
  type(method_t) :: method
  type(waves_t) :: w
  type(error_t), allocatable :: error
  call read_free(count, grid, nx, ny, tolerance, 4, wanted, g, method, error)
  if (.not. allocated(error)) then
    call free_waves(fx, fy, amplitude, phase, w)
    call heights_single(w, g, method, heights_out, error)
  end if
  call tell(error, status, message)
end subroutine surface_free_heights_single

!> Run an input that holds only a surface; ran = 0 and nothing is done if it holds more.
subroutine surface_run(path, assignments, folder, force, ran, status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t
  use hd_input, only: read_scene, surface_scene_of
  use hd_output, only: result_files
  use hd_surface_run, only: run_surface
  use hd_scene, only: scene_t
  use hd_status, only: tell, lines_of
  use hd_text, only: string_t
  implicit none
  character(len=*), intent(in) :: path, assignments, folder
  integer(c_int), intent(in) :: force
  integer(c_int), intent(out) :: ran, status
  character(len=8192), intent(out) :: message
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
  call tell(error, status, message)
end subroutine surface_run
