! SPDX-License-Identifier: GPL-3.0-or-later
!> Waves and their direct sum in C, the same bits on every processor.
module hd_wave_kernels
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  implicit none
  private
  public :: exact_products, turns_at_point, direct_row, cosines

  interface
    !> p + p_2 = (a + a_2) (b + b_2) to about 100 bits.
    subroutine exact_products(n, a, a_2, b, b_2, p, p_2) bind(c, name='hd_products')
      import :: c_int, c_double
      integer(c_int), value, intent(in) :: n                                !< products
      real(c_double), value, intent(in) :: a, a_2                           !< first factor
      real(c_double), intent(in) :: b(*), b_2(*)                            !< second factors
      real(c_double), intent(inout) :: p(*), p_2(*)                         !< products, rounded, and the rest
    end subroutine exact_products
    !> Turns per step, reduced to [-1, 1], in two parts, and phases at a point, reduced to [-1/2, 1/2].
    subroutine turns_at_point(n, fx, fx_2, fy, fy_2, phase, dx, dy, x, x_2, y, y_2, ux, ux_2, uy, uy_2, at) &
      bind(c, name='hd_turns')
      import :: c_int, c_double
      integer(c_int), value, intent(in) :: n                                !< waves
      real(c_double), intent(in) :: fx(*), fx_2(*), fy(*), fy_2(*)          !< wave numbers [1/m]
      real(c_double), intent(in) :: phase(*)                                !< phases at the origin [turns]
      real(c_double), value, intent(in) :: dx, dy, x, x_2, y, y_2           !< steps, point [m]
      real(c_double), intent(inout) :: ux(*), ux_2(*), uy(*), uy_2(*)       !< turns per step
      real(c_double), intent(inout) :: at(*)                                !< phases at the point [turns]
    end subroutine turns_at_point
    !> z - a cos of 2 pi (phase + i (high + low)) at the steps i = 0, 1, ...
    subroutine direct_row(n, phase, high, low, a, z) bind(c, name='hd_direct_row')
      import :: c_int, c_double
      integer(c_int), value, intent(in) :: n                                !< points
      real(c_double), value, intent(in) :: phase, high, low, a              !< turns, amplitude [m]
      real(c_double), intent(inout) :: z(*)                                 !< heights [m] (n)
    end subroutine direct_row
    !> Cosines of phases from -1/2 to 1.
    subroutine cosines(n, phase, cosine) bind(c, name='hd_cosines')
      import :: c_int, c_double
      integer(c_int), value, intent(in) :: n                                !< phases
      real(c_double), intent(in) :: phase(*)                                !< [turns]
      real(c_double), intent(inout) :: cosine(*)                            !< (n)
    end subroutine cosines
  end interface
end module hd_wave_kernels
