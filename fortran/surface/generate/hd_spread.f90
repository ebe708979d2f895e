! SPDX-License-Identifier: GPL-3.0-or-later
!> Inner loops of the NUFFT in C, in double and in single precision, compiled for several widths of vector register.
module hd_spread
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_double_complex, c_float, c_float_complex
  implicit none
  private
  public :: wave_phases, window_rows, spread_rows
  public :: wave_phases_single, window_rows_single, spread_rows_single

  interface
    !> out = a exp(2 pi i (phase + step (high + low))) for each wave.
    subroutine wave_phases(n, phase, high, low, step, a, out) bind(c, name='hd_phases')
      import :: c_int, c_double, c_double_complex
      integer(c_int), value, intent(in) :: n                                !< waves
      real(c_double), intent(in) :: phase(*), high(*), low(*), a(*)         !< turns, amplitude
      integer(c_int), value, intent(in) :: step                             !< steps
      complex(c_double_complex), intent(inout) :: out(*)                    !< result
    end subroutine wave_phases
    !> out = a exp(2 pi i (phase + step (high + low))) for each wave.
    subroutine wave_phases_single(n, phase, high, low, step, a, out) bind(c, name='hd_phases_single')
      import :: c_int, c_double, c_float_complex
      integer(c_int), value, intent(in) :: n                                !< waves
      real(c_double), intent(in) :: phase(*), high(*), low(*), a(*)         !< turns, amplitude
      integer(c_int), value, intent(in) :: step                             !< steps
      complex(c_float_complex), intent(inout) :: out(*)                     !< result
    end subroutine wave_phases_single
    !> Weights of a window at s in [-1, 1] of the fine interval.
    subroutine window_rows(most, n, padded, degree, piece, s, weight) bind(c, name='hd_weights')
      import :: c_int, c_double
      integer(c_int), value, intent(in) :: most                             !< bytes of a vector register, 0: any
      integer(c_int), value, intent(in) :: n, padded, degree                !< waves, padded width, degree
      real(c_double), intent(in) :: piece(*), s(*)                          !< coefficients (padded, 0:degree), places (n)
      real(c_double), intent(inout) :: weight(*)                            !< weights (padded, n)
    end subroutine window_rows
    !> Weights of a window at s in [-1, 1] of the fine interval.
    subroutine window_rows_single(most, n, padded, degree, piece, s, weight) bind(c, name='hd_weights_single')
      import :: c_int, c_double, c_float
      integer(c_int), value, intent(in) :: most                             !< bytes of a vector register, 0: any
      integer(c_int), value, intent(in) :: n, padded, degree                !< waves, padded width, degree
      real(c_float), intent(in) :: piece(*)                                 !< coefficients (padded, 0:degree)
      real(c_double), intent(in) :: s(*)                                    !< places (n)
      real(c_float), intent(inout) :: weight(*)                             !< weights (padded, n)
    end subroutine window_rows_single
    !> Add waves to the fine points.
    subroutine spread_rows(most, n, padded_x, padded_y, width_y, fine_y, height, kx, ky, c, wx, wy, f) &
      bind(c, name='hd_spread_rows')
      import :: c_int, c_double, c_double_complex
      integer(c_int), value, intent(in) :: most                             !< bytes of a vector register, 0: any
      integer(c_int), value, intent(in) :: n, padded_x, padded_y, width_y   !< waves, padded and true widths
      integer(c_int), value, intent(in) :: fine_y, height                   !< fine points in y, fine columns
      integer(c_int), intent(in) :: kx(*), ky(*)                            !< first column and row of each wave, from 0
      complex(c_double_complex), intent(in) :: c(*)                         !< waves
      real(c_double), intent(in) :: wx(*), wy(*)                            !< weights (padded, n)
      complex(c_double_complex), intent(inout) :: f(*)                      !< fine points (height, fine_y)
    end subroutine spread_rows
    !> Add waves to the fine points.
    subroutine spread_rows_single(most, n, padded_x, padded_y, width_y, fine_y, height, kx, ky, c, wx, wy, f) &
      bind(c, name='hd_spread_rows_single')
      import :: c_int, c_float, c_float_complex
      integer(c_int), value, intent(in) :: most                             !< bytes of a vector register, 0: any
      integer(c_int), value, intent(in) :: n, padded_x, padded_y, width_y   !< waves, padded and true widths
      integer(c_int), value, intent(in) :: fine_y, height                   !< fine points in y, fine columns
      integer(c_int), intent(in) :: kx(*), ky(*)                            !< first column and row of each wave, from 0
      complex(c_float_complex), intent(in) :: c(*)                          !< waves
      real(c_float), intent(in) :: wx(*), wy(*)                             !< weights (padded, n)
      complex(c_float_complex), intent(inout) :: f(*)                       !< fine points (height, fine_y)
    end subroutine spread_rows_single
  end interface
end module hd_spread
