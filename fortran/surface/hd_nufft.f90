! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves by a non-uniform FFT: spread each wave over the fine points around its wave number, transform, divide by the
!> transform of the window.
!>
!> Heights are real, so half the plane of wave numbers is enough. Rows are done in tiles, each a transform of its own about its
!> middle row: memory stays small, tiles are independent, and the result does not depend on the number of threads. Of the columns
!> of wave numbers only those a wave has touched are transformed.
module hd_nufft
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_fft, only: fft_plan_t, plan_complex, plan_backward_real, execute_complex, execute_backward_real, free_plan
  use hd_nufft_plan, only: nufft_plan_t
  use hd_spread, only: wave_phases, window_rows, spread_rows
  use hd_waves, only: waves_t, grid_t, turns_on_grid, split_turns
  use hd_window, only: window_t, new_window, place_in_window, widest
  implicit none
  private
  public :: nufft_t, new_nufft, nufft_sum

  integer, parameter :: panel = 16    !< columns transformed together
  integer, parameter :: share = 256   !< waves spread together: their weights stay in the cache

  !> Waves on the fine points.
  type :: nufft_t
    type(window_t) :: x, y                               !< windows
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

  !> Windows and weights for a grid.
  subroutine new_nufft(w, g, plan, p)
    type(waves_t), intent(in) :: w             !< waves
    type(grid_t), intent(in) :: g              !< grid
    type(nufft_plan_t), intent(in) :: plan     !< fine points, widths, rows of a tile
    type(nufft_t), intent(out) :: p            !< waves on the fine points
    real(dp), allocatable :: ux(:), ux_2(:), uy(:), uy_2(:)
    integer :: n, j, low, high
    n = size(w%amplitude)
    call new_window(g%nx, plan%fine_x, plan%width_x, plan%tolerance, p%x)
    call new_window(plan%rows, plan%fine_y, plan%width_y, plan%tolerance, p%y)
    p%rows = plan%rows
    p%middle = g%ny / 2
    p%offset = w%offset
    p%amplitude = -0.5_dp * w%amplitude
    allocate (ux(n), ux_2(n), uy(n), uy_2(n))
    allocate (p%phase(n), p%high(n), p%low(n), p%kx(n), p%ky(n), p%sx(n), p%sy(n))
    call turns_on_grid(w, g, real(g%nx / 2, dp), real(p%middle, dp), ux, ux_2, uy, uy_2, p%phase)
    !$omp parallel do schedule(static) if (n > 10000)
    do j = 1, n
      ux(j) = nearest_turn(ux(j)) + ux_2(j)
      uy(j) = nearest_turn(uy(j))
      if (ux(j) < 0) then                                  ! cos is even
        ux(j) = -ux(j)
        uy(j) = -uy(j)
        uy_2(j) = -uy_2(j)
        p%phase(j) = -p%phase(j)
      end if
      call split_turns(uy(j), uy_2(j), p%high(j), p%low(j))
      call place_in_window(p%x, ux(j) * plan%fine_x, p%kx(j), p%sx(j))
      call place_in_window(p%y, uy(j) * plan%fine_y, p%ky(j), p%sy(j))
      p%kx(j) = p%kx(j) + widest
      if (p%ky(j) < 0) p%ky(j) = p%ky(j) + plan%fine_y
    end do
    allocate (p%touched(0:(plan%fine_x / 2 + 2 * widest) / panel + 1), source=.false.)
    do j = 1, n
      low = p%kx(j)
      high = low + p%x%padded - 1
      p%touched(low / panel:high / panel) = .true.
    end do
  end subroutine new_nufft

  !> Heights [m] of rows j_1 .. j_1 + size(z, 2) - 1.
  subroutine nufft_sum(p, j_1, z, error)
    type(nufft_t), intent(in) :: p                      !< waves on the fine points
    integer, intent(in) :: j_1                          !< first row
    real(dp), intent(inout), contiguous :: z(:, :)      !< heights (nx, rows) [m]
    type(error_t), allocatable, intent(out) :: error    !< FFTW finds no plan
    complex(dp), allocatable :: f(:, :), s(:)
    real(dp), allocatable :: r(:)
    type(fft_plan_t) :: columns, row
    integer :: half, fine_y, first, last, tile
    half = p%x%fine / 2
    fine_y = p%y%fine
    last = size(p%touched) * panel - widest - 1
    allocate (f(-widest:last, 0:fine_y - 1), s(0:half), r(0:p%x%fine - 1))
    call plan_complex(fine_y, panel, size(f, 1), 1, +1, f, columns, error)
    if (allocated(error)) return
    call plan_backward_real(p%x%fine, 1, s, r, row, error)
    if (allocated(error)) return
    !$omp parallel private(first, tile) firstprivate(f, s, r)
    f = 0
    !$omp do schedule(dynamic)
    do tile = 1, (size(z, 2) + p%rows - 1) / p%rows
      first = (tile - 1) * p%rows + 1
      call spread_waves(p, j_1 - 1 + first - 1 + p%rows / 2 - p%middle, f)
      call transform_columns(p, columns, size(f, 1), f)
      call finish_rows(p, row, f, s, r, z(:, first:min(first + p%rows - 1, size(z, 2))))
    end do
    !$omp end parallel
    call free_plan(columns)
    call free_plan(row)
  end subroutine nufft_sum

  !> Add the waves, their phases taken `shift` rows from the middle row, to the fine points.
  subroutine spread_waves(p, shift, f)
    type(nufft_t), intent(in) :: p                             !< waves
    integer, intent(in) :: shift                               !< middle row of the tile from that of the phases
    complex(dp), intent(inout), contiguous :: f(:, :)          !< fine points
    complex(dp) :: c(share)
    real(dp) :: wx(p%x%padded, share), wy(p%y%padded, share)
    integer :: k, n
    do k = 1, size(p%phase), share
      n = min(share, size(p%phase) - k + 1)
      call wave_phases(n, p%phase(k), p%high(k), p%low(k), shift, p%amplitude(k), c)
      call window_rows(n, p%x%padded, p%x%degree, p%x%piece, p%sx(k), wx)
      call window_rows(n, p%y%padded, p%y%degree, p%y%piece, p%sy(k), wy)
      call spread_rows(n, p%x%padded, p%y%padded, p%y%width, p%y%fine, size(f, 1), p%kx(k), p%ky(k), c, wx, wy, f)
    end do
  end subroutine spread_waves

  !> Turns in [-1, 1] to [-1/2, 1/2].
  elemental real(dp) function nearest_turn(u)
    real(dp), intent(in) :: u    !< turns
    nearest_turn = u
    if (u > 0.5_dp) nearest_turn = u - 1
    if (u < -0.5_dp) nearest_turn = u + 1
  end function nearest_turn

  !> Wave numbers in y to rows.
  subroutine transform_columns(p, columns, height, f)
    type(nufft_t), intent(in) :: p                             !< waves
    type(fft_plan_t), intent(in) :: columns                    !< plan of a panel
    integer, intent(in) :: height                              !< number of columns
    complex(dp), intent(inout) :: f(height, *)                 !< fine points
    integer :: i
    do i = 0, size(p%touched) - 1
      if (p%touched(i)) call execute_complex(columns, f(i * panel + 1, 1))
    end do
  end subroutine transform_columns

  !> Wave numbers in x to heights, row by row; clears the fine points.
  subroutine finish_rows(p, plan, f, s, r, z)
    type(nufft_t), intent(in) :: p                             !< waves
    type(fft_plan_t), intent(in) :: plan                       !< plan of a row
    complex(dp), intent(inout), contiguous :: f(-widest:, 0:)  !< fine points
    complex(dp), intent(inout), contiguous :: s(0:)            !< half spectrum of a row
    real(dp), intent(inout), contiguous :: r(0:)               !< fine row
    real(dp), intent(inout) :: z(:, :)                         !< heights (nx, rows) [m]
    integer :: half, fine, i, j, k, l, nx
    real(dp) :: c
    half = size(s) - 1
    fine = size(r)
    nx = size(z, 1)
    do j = 1, size(z, 2)
      l = j - 1 - p%rows / 2
      k = modulo(l, p%y%fine)
      s = f(0:half, k)
      do i = 1, widest
        s(i) = s(i) + conjg(f(-i, k))
        s(half - i) = s(half - i) + conjg(f(half + i, k))
      end do
      s(0) = 2 * real(s(0), dp)
      s(half) = 2 * real(s(half), dp)
      call execute_backward_real(plan, s, r)
      c = p%y%correction(abs(l))
      do i = 1, nx / 2
        z(i, j) = p%offset + r(fine - nx / 2 + i - 1) * (c * p%x%correction(nx / 2 - i + 1))
      end do
      do i = nx / 2 + 1, nx
        z(i, j) = p%offset + r(i - 1 - nx / 2) * (c * p%x%correction(i - 1 - nx / 2))
      end do
    end do
    do k = 0, size(f, 2) - 1
      do i = 0, size(p%touched) - 1
        if (p%touched(i)) f(i * panel - widest:i * panel - widest + panel - 1, k) = 0
      end do
    end do
  end subroutine finish_rows
end module hd_nufft
