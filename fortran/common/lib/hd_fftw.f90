! SPDX-License-Identifier: GPL-3.0-or-later
!> FFTW's own interface, the lock of its planner, and plans as hd_fft and hd_fft_single hold them.
module hd_fftw
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_double_complex, c_float, c_float_complex, c_size_t, c_intptr_t, &
    c_char, c_funptr, c_int32_t, c_null_ptr
  implicit none
  public

  include 'fftw3.f03'

  interface
    subroutine lock_planner() bind(c, name='hd_lock_planner')
    end subroutine lock_planner
    subroutine unlock_planner() bind(c, name='hd_unlock_planner')
    end subroutine unlock_planner
  end interface

  !> A plan for repeated use, also from several threads at once, on arrays aligned to 16 bytes. Free it with `free_plan`.
  type :: fft_plan_t
    type(c_ptr) :: plan = c_null_ptr
    logical :: kept = .false.      !< for the next that asks: not to be freed
  end type fft_plan_t

  !> Plans of `plan_rows`.
  type :: rows_plan_t
    type(fft_plan_t) :: part(2)    !< of a part, and of the last one if it is shorter
    integer :: rows = 0            !< of all parts
  end type rows_plan_t

  integer, parameter :: rows_of_part = 8      !< parts begin at multiples of 16 bytes, as FFTW asks
  integer, parameter :: long_rows = 10000     !< numbers from which two threads are worth waking

  !> Plans of the NUFFT and of single rows stay for the next call: making them costs more than a small transform.
  type :: kept_t
    integer :: key(4) = 0          !< what was asked for
    type(fft_plan_t) :: plan
  end type kept_t
end module hd_fftw
