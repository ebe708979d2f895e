! SPDX-License-Identifier: GPL-3.0-or-later
!> FFTW's own interface, and the lock of its planner.
module hd_fftw
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_double_complex, c_float, c_float_complex, c_size_t, c_intptr_t, &
    c_char, c_funptr, c_int32_t
  implicit none
  public

  include 'fftw3.f03'

  interface
    subroutine lock_planner() bind(c, name='hd_lock_planner')
    end subroutine lock_planner
    subroutine unlock_planner() bind(c, name='hd_unlock_planner')
    end subroutine unlock_planner
  end interface
end module hd_fftw
