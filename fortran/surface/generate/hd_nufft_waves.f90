! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves by a non-uniform FFT: spread each wave over the fine points around its wave number, transform, divide by the
!> transform of the window. Here are the waves: where each lies among the fine points, its phase, the order of spreading.
!>
!> Heights are real, so half the plane of wave numbers is enough. Rows are done in tiles (hd_nufft_tiles), each a transform of its
!> own about its middle row: memory stays small, tiles are independent, and the result does not depend on the number of threads. Of
!> the columns of wave numbers only those a wave has touched are transformed.
module hd_nufft_waves
  use hd_kinds, only: dp
  use hd_nufft_plan, only: nufft_plan_t
  use hd_waves, only: waves_t, grid_t, turns_on_grid
  use hd_window, only: window_t, new_window, widest
  implicit none
  private
  public :: nufft_t, new_nufft, panel

  integer, parameter :: panel = 16    !< columns transformed together
  integer, parameter :: strands = 8   !< parts of the list taken in turn: neighbours share fine points and would wait for each other

  !> Waves on the fine points.
  type :: nufft_t
    type(window_t) :: x, y                               !< windows
    integer :: precision = 1                             !< of the sum: 1 double, 2 single
    integer :: ny = 0                                    !< rows of the grid
    integer :: rows = 0                                  !< rows of a tile
    integer :: middle = 0                                !< row of the phases, from 0
    integer, allocatable :: kx(:), ky(:)                 !< first fine point of each wave, x from -widest
    real(dp), allocatable :: sx(:), sy(:)                !< places that give the weights of each wave
    real(dp), allocatable :: high(:), low(:), phase(:)   !< turns per row, phase [turns]
    real(dp), allocatable :: amplitude(:)                !< half the amplitude, negative [m]
    logical, allocatable :: touched(:)                   !< panels of columns that waves touch
    real(dp) :: offset = 0                               !< constant height [m]
  end type nufft_t

contains

  !> Windows and places for a grid.
  subroutine new_nufft(w, g, plan, p)
    type(waves_t), intent(in) :: w             !< waves
    type(grid_t), intent(in) :: g              !< grid
    type(nufft_plan_t), intent(in) :: plan     !< fine points, widths, rows of a tile
    type(nufft_t), intent(out) :: p            !< waves on the fine points
    real(dp), allocatable, dimension(:) :: ux, ux_2, uy, uy_2, phase
    integer :: n, j, length, strand
    n = size(w%amplitude)
    call new_window(g%nx, plan%fine_x, plan%width_x, plan%tolerance, p%x)
    call new_window(plan%rows, plan%fine_y, plan%width_y, plan%tolerance, p%y)
    p%precision = plan%precision
    p%rows = plan%rows
    p%ny = g%ny
    p%middle = g%ny / 2
    p%offset = w%offset
    allocate (ux(n), ux_2(n), uy(n), uy_2(n), phase(n))
    allocate (p%phase(n), p%high(n), p%low(n), p%kx(n), p%ky(n), p%sx(n), p%sy(n), p%amplitude(n))
    call turns_on_grid(w, g, real(g%nx / 2, dp), real(p%middle, dp), ux, ux_2, uy, uy_2, phase)
    length = n / strands
    !$omp parallel do schedule(static) if (n > 20000)
    do strand = 0, strands - 1
      call place_waves(p, ux, ux_2, uy, uy_2, phase, w%amplitude, strand * length, strand + 1, strands, length)
    end do
    j = strands * length
    call place_waves(p, ux, ux_2, uy, uy_2, phase, w%amplitude, j, j + 1, 1, n - j)
    j = (plan%fine_x / 2 + 2 * widest) / panel + 1
    allocate (p%touched(0:j + mod(j, 2)), source=.false.)  ! odd: rows 4096 bytes apart would share few places in the cache
    do j = 1, n
      p%touched(p%kx(j) / panel) = .true.
      p%touched((p%kx(j) + p%x%padded - 1) / panel) = .true.
    end do
    if (p%x%padded > panel) p%touched(1:) = p%touched(1:) .or. p%touched(:ubound(p%touched, 1) - 1)
  end subroutine new_nufft

  !> Waves from + 1 .. from + count to the places to, to + step, ...
  pure subroutine place_waves(p, ux, ux_2, uy, uy_2, phase, amplitude, from, to, step, count)
    type(nufft_t), intent(inout) :: p                                       !< waves on the fine points
    real(dp), intent(in), contiguous, dimension(:) :: ux, ux_2, uy, uy_2    !< turns per point and their rest
    real(dp), intent(in), contiguous :: phase(:), amplitude(:)              !< turns, [m]
    integer, intent(in) :: from, to, step, count                            !< which, where
    real(dp) :: u, v, v_2, sign, first
    integer :: i, j, k
    do i = 1, count
      j = from + i
      k = to + (i - 1) * step
      u = nearest_turn(ux(j)) + ux_2(j)
      sign = merge(-1, 1, u < 0)                             ! cos is even
      u = sign * u
      v = sign * nearest_turn(uy(j))
      v_2 = sign * uy_2(j)
      p%phase(k) = sign * phase(j)
      p%amplitude(k) = -0.5_dp * amplitude(j)
      p%high(k) = rounded(v * 536870912._dp) / 536870912._dp   ! a multiple of 2^-29: whole multiples up to 2^23 are exact
      p%low(k) = (v - p%high(k)) + v_2
      u = u * p%x%fine - 0.5_dp * p%x%width
      first = rounded(u + 0.5_dp)
      p%sx(k) = 2 * (first - u) - 1
      p%kx(k) = int(first) + widest
      u = v * p%y%fine - 0.5_dp * p%y%width
      first = rounded(u + 0.5_dp)
      p%sy(k) = 2 * (first - u) - 1
      p%ky(k) = int(first) + merge(p%y%fine, 0, first < 0)
    end do
  end subroutine place_waves

  !> Turns in [-1, 1] to [-1/2, 1/2].
  elemental real(dp) function nearest_turn(u)
    real(dp), intent(in) :: u    !< turns
    nearest_turn = u
    if (u > 0.5_dp) nearest_turn = u - 1
    if (u < -0.5_dp) nearest_turn = u + 1
  end function nearest_turn

  !> Nearest whole number, for sizes below 2^51: unlike anint a few operations that compilers
  !> vectorise; here again because they do not across files.
  elemental real(dp) function rounded(x)
    real(dp), intent(in) :: x    !< number
    rounded = (x + 6755399441055744._dp) - 6755399441055744._dp
  end function rounded
end module hd_nufft_waves
