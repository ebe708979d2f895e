! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves, term by term: the oracle of the faster evaluators. Also the one place where turns are counted exactly.
module hd_direct
  use hd_kinds, only: dp, qp, pi
  use hd_waves, only: waves_t, grid_t, turns_on_grid
  implicit none
  private
  public :: direct_sum, split_turns, turns_at

contains

  !> Heights [m] of rows j_1 .. j_1 + size(z, 2) - 1 of the grid.
  subroutine direct_sum(w, g, j_1, z)
    type(waves_t), intent(in) :: w                    !< waves
    type(grid_t), intent(in) :: g                     !< grid
    integer, intent(in) :: j_1                        !< first row
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, rows) [m]
    real(qp), allocatable :: ux(:), uy(:)
    real(dp), allocatable :: phase(:), xh(:), xl(:), yh(:), yl(:)
    real(dp) :: row
    integer :: i, j, k, n
    n = size(w%amplitude)
    allocate (ux(n), uy(n), phase(n), xh(n), xl(n), yh(n), yl(n))
    call turns_on_grid(w, g, 0._dp, 0._dp, ux, uy, phase)
    call split_turns(ux, xh, xl)
    call split_turns(uy, yh, yl)
    !$omp parallel do private(i, k, row) schedule(dynamic)
    do j = 1, size(z, 2)
      z(:, j) = w%offset
      do k = 1, n
        row = phase(k) + turns_at(yh(k), yl(k), j_1 + j - 2)
        do i = 1, size(z, 1)
          z(i, j) = z(i, j) - w%amplitude(k) * cos(2 * pi * (row + turns_at(xh(k), xl(k), i - 1)))
        end do
      end do
    end do
  end subroutine direct_sum

  !> Turns as a multiple of 2^-29 and the rest, so that whole multiples up to 2^23 of the first part are exact.
  elemental subroutine split_turns(u, high, low)
    real(qp), intent(in) :: u              !< turns, at most 1
    real(dp), intent(out) :: high, low     !< u = high + low
    high = anint(real(u, dp) * 536870912._dp) / 536870912._dp
    low = real(u - high, dp)
  end subroutine split_turns

  !> i times the turns, reduced to [-1/2, 1/2] but for the rest.
  elemental real(dp) function turns_at(high, low, i) result(t)
    real(dp), intent(in) :: high, low      !< turns per step
    integer, intent(in) :: i               !< steps
    t = high * i
    t = (t - anint(t)) + low * i
  end function turns_at
end module hd_direct
