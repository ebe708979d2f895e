! SPDX-License-Identifier: GPL-3.0-or-later
! Flat entries for Python: surfaces. Arrays come from Python in Fortran order and are filled in place.

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
