! SPDX-License-Identifier: GPL-3.0-or-later
!> What the factors of a sum of waves as a matrix product are made of: turns per half step, phases at the middle of the grid.
!>
!> cos(kx x + ky y + p) is cos(kx x) cos(ky y + p) - sin(kx x) sin(ky y + p): rank two. Two symmetries cut the work of the plain
!> product (N x 2J x N) to a quarter. Waves of one |kx| (ridges m and M - m) share their factors in x. And with x counted from the
!> middle of the grid cos is even, sin odd: each half of a row is the sum or the difference of two products of half the width.
module hd_factors
  use hd_kinds, only: dp
  use hd_waves, only: waves_t, grid_t, turns_on_grid, split_turns
  implicit none
  private
  public :: factors_t, new_factors

  !> Waves, those of a group behind one another.
  type :: factors_t
    real(dp), allocatable :: x_high(:), x_low(:)      !< turns per half step in x, not negative (groups)
    real(dp), allocatable :: high(:), low(:)          !< turns per half step in y (waves)
    real(dp), allocatable :: phase(:)                 !< phase at the middle of the grid [turns] (waves)
    real(dp), allocatable :: amplitude(:)             !< amplitude [unit], negative (waves)
    real(dp), allocatable :: mirror(:)                !< amplitude times the sign of kx (waves)
    integer, allocatable :: first(:)                  !< waves of group k: first(k) .. first(k + 1) - 1
    integer :: nx = 0, ny = 0                         !< points of the whole grid
    real(dp) :: unit = 1                              !< power of two [m]
    real(dp) :: offset = 0                            !< constant height [m]
  end type factors_t

contains

  !> Waves on a grid.
  subroutine new_factors(w, g, f)
    type(waves_t), intent(in) :: w       !< waves
    type(grid_t), intent(in) :: g        !< grid
    type(factors_t), intent(out) :: f    !< factors
    real(dp), allocatable :: ux(:), ux_2(:), uy(:), uy_2(:), phase(:)
    integer, allocatable :: next(:)
    integer :: n, j, k, l
    n = size(w%amplitude)
    allocate (ux(n), ux_2(n), uy(n), uy_2(n), phase(n), f%high(n), f%low(n), f%phase(n), f%amplitude(n), f%mirror(n), &
      f%x_high(w%groups), f%x_low(w%groups))
    call turns_on_grid(w, g, 0.5_dp * (g%nx - 1), 0.5_dp * (g%ny - 1), ux, ux_2, uy, uy_2, phase)
    f%nx = g%nx
    f%ny = g%ny
    f%offset = w%offset
    f%unit = scale(1._dp, max(-1000, min(1000, exponent(maxval(abs(w%amplitude))))))
    allocate (f%first(w%groups + 1), source=0)
    do j = 1, n
      f%first(w%group(j) + 1) = f%first(w%group(j) + 1) + 1
    end do
    f%first(1) = 1
    do k = 1, w%groups
      f%first(k + 1) = f%first(k) + f%first(k + 1)
    end do
    next = f%first
    do j = 1, n
      k = w%group(j)
      l = next(k)
      next(k) = l + 1
      call split_turns(abs(ux(j)) / 2, sign(0.5_dp, ux(j)) * ux_2(j), f%x_high(k), f%x_low(k))
      call split_turns(uy(j) / 2, uy_2(j) / 2, f%high(l), f%low(l))
      f%phase(l) = phase(j)
      f%amplitude(l) = -w%amplitude(j) / f%unit
      f%mirror(l) = merge(f%amplitude(l), -f%amplitude(l), ux(j) < 0)
    end do
  end subroutine new_factors
end module hd_factors
