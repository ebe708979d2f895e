! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves, term by term: the oracle of the faster evaluators, the same bits on every processor.
module hd_direct_sum
  use hd_kinds, only: dp
  use hd_system, only: stop_requested
  use hd_wave_kernels, only: direct_row
  use hd_waves, only: waves_t, grid_t, turns_on_grid, split_turns
  implicit none
  private
  public :: direct_sum

contains

  !> Heights [m] of rows j_1 .. j_1 + size(z, 2) - 1 of the grid.
  subroutine direct_sum(w, g, j_1, z)
    type(waves_t), intent(in) :: w                    !< waves
    type(grid_t), intent(in) :: g                     !< grid
    integer, intent(in) :: j_1                        !< first row
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, rows) [m]
    real(dp), allocatable :: ux(:), ux_2(:), uy(:), uy_2(:), phase(:), xh(:), xl(:), yh(:), yl(:)
    integer :: j, k, n
    n = size(w%amplitude)
    allocate (ux(n), ux_2(n), uy(n), uy_2(n), phase(n), xh(n), xl(n), yh(n), yl(n))
    call turns_on_grid(w, g, 0._dp, 0._dp, ux, ux_2, uy, uy_2, phase)
    call split_turns(ux, ux_2, xh, xl)
    call split_turns(uy, uy_2, yh, yl)
    !$omp parallel do private(k) schedule(dynamic)
    do j = 1, size(z, 2)
      if (stop_requested()) cycle
      z(:, j) = w%offset
      do k = 1, n
        call direct_row(size(z, 1), phase(k) + turns_at(yh(k), yl(k), j_1 + j - 2), xh(k), xl(k), w%amplitude(k), z(:, j))
      end do
    end do
  end subroutine direct_sum

  !> i times the turns, reduced to [-1/2, 1/2] but for the rest.
  elemental real(dp) function turns_at(high, low, i) result(t)
    real(dp), intent(in) :: high, low      !< turns per step
    integer, intent(in) :: i               !< steps
    t = high * i
    t = (t - anint(t)) + low * i
  end function turns_at
end module hd_direct_sum
