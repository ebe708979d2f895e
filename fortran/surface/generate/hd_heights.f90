! SPDX-License-Identifier: GPL-3.0-or-later
!> Heights of a sum of waves on a grid: takes the evaluator that is predicted to be the fastest: products in double
!> precision, with a tolerance also the NUFFT, and products in single precision where they keep it. The direct sum is their oracle;
!> its bits are the same on every processor.
module hd_heights
  use hd_kinds, only: dp, sp, i8
  use hd_direct_sum, only: direct_sum
  use hd_error, only: error_t, raise, code_input
  use hd_memory, only: need_memory
  use hd_nufft_plan, only: nufft_plan_t, plan_nufft
  use hd_nufft_tiles, only: sum_tiles
  use hd_nufft_tiles_single, only: sum_tiles_single => sum_tiles
  use hd_nufft_waves, only: nufft_t, new_nufft
  use hd_plain_product, only: plain_t, new_plain, plain_sum
  use hd_plain_product_single, only: plain_single_t => plain_t, new_plain_single => new_plain, plain_sum_single => plain_sum
  use hd_system, only: addresses_limited, check_stop
  use hd_text, only: to_text
  use hd_waves, only: waves_t, grid_t, checked_grid
  implicit none
  private
  public :: method_t, choose_method, heights, heights_single
  public :: method_auto, method_direct, method_product, method_nufft

  !> tolerances: rounding of a long sum leaves more than less; above, nothing is saved
  real(dp), parameter :: finest = 1e-13_dp, roughest = 0.1_dp
  integer, parameter :: in_double = 1, in_single = 2
  integer, parameter :: method_auto = 0, method_direct = 1, method_product = 2, method_nufft = 3

  !> How a sum will be done.
  type :: method_t
    integer :: evaluator = method_auto               !< method_direct, method_product or method_nufft
    integer :: precision = in_double                 !< of a product
    type(nufft_plan_t) :: nufft                      !< fine points, widths, tiles
    real(dp) :: seconds(3) = huge(1._dp)             !< predicted time of direct, product, nufft [s]; huge: not asked
    real(dp) :: memory_mb = 0                        !< memory beside the heights [MB]
  end type method_t

  real(dp), parameter :: second_per_cosine = 3e-9_dp      !< one term of the direct sum
  real(dp), parameter :: second_per_flop(2) = [0.023e-9_dp, 0.012e-9_dp]          !< product: double, single
  real(dp), parameter :: second_per_point(2) = [0.5e-9_dp, 0.4e-9_dp]             !< height stored
  real(dp), parameter :: single_from = 1e-6_dp             !< tolerance from which a product in single precision is tried
  real(dp), parameter :: single_error = 4e-8_dp            !< its error over the square root of the number of terms
  real(dp), parameter :: small_seconds = 0.2e-3_dp         !< time of a product below which a NUFFT is not planned
  real(dp), parameter :: small_mb = 16                     !< what is not worth a look at the free memory
  real(dp), parameter :: nufft_tolerance = 1e-12_dp        !< of the NUFFT where none is asked for
  real(dp), parameter :: second_per_factor(2) = [1e-9_dp, 0.8e-9_dp]              !< entry of a factor
  real(dp), parameter :: mean_share = 0.75_dp              !< of the time on one thread: mean of that on one and on two threads
  integer, parameter :: slab_points = 4194304              !< of the direct sum held in double precision for single ones

contains

  !> Choose by predicted time, or check what was asked for.
  subroutine choose_method(nx, ny, waves, groups, tolerance, bytes, wanted, method, error)
    integer, intent(in) :: nx, ny                     !< points
    integer(i8), intent(in) :: waves, groups          !< number of waves, of groups with one |kx|
    real(dp), intent(in) :: tolerance                 !< error allowed, relative to the rms height; 0: none, only rounding
    integer, intent(in) :: bytes                      !< of a height: 8 or 4
    integer, intent(in) :: wanted                     !< method_*
    type(method_t), intent(out) :: method             !< choice
    type(error_t), allocatable, intent(out) :: error  !< bad input or not enough memory
    real(dp) :: points, extra(3), mb
    if (tolerance /= 0 .and. .not. (tolerance >= finest .and. tolerance <= roughest)) then
      call raise(error, code_input, 'tolerance = '//to_text(tolerance)//': must lie between 1e-13 and 0.1 (0: none)')
      return
    end if
    points = real(nx, dp) * ny
    if (tolerance >= single_from .and. single_error * sqrt(real(groups, dp)) <= tolerance) method%precision = in_single
    method%seconds(1) = mean_share * points * waves * second_per_cosine
    associate (k => method%precision)
      method%seconds(2) = mean_share * (points * (2 * groups * second_per_flop(k) + second_per_point(k)) &
        + (real(nx, dp) * groups + 2._dp * ny * waves) * second_per_factor(k))
    end associate
    if (wanted == method_nufft .or. (wanted == method_auto .and. tolerance > 0 .and. method%seconds(2) > small_seconds)) then
      method%nufft = plan_nufft(nx, ny, int(waves), merge(tolerance, nufft_tolerance, tolerance > 0))
    end if
    method%seconds(3) = method%nufft%seconds
    extra(1) = 64._dp * waves
    extra(2) = 100._dp * waves + 16._dp * nx * groups + 32._dp * (64 * nx + 32768)
    extra(3) = (200 + 8._dp * (method%nufft%width_x + method%nufft%width_y)) * waves + &
      16._dp * method%nufft%fine_y * (0.5_dp * method%nufft%fine_x + 100) * 3
    if (bytes == 4) extra(1) = extra(1) + 8 * min(real(slab_points, dp), points)
    method%evaluator = wanted
    if (wanted == method_auto) method%evaluator = minloc(method%seconds, 1)
    if (wanted == method_nufft .and. method%nufft%width_x == 0) then
      call raise(error, code_input, 'tolerance = '//to_text(tolerance)//': out of reach of the method nufft')
      return
    end if
    method%memory_mb = extra(method%evaluator) / 1048576
    mb = points * bytes / 1048576 + method%memory_mb
    if (mb > small_mb .or. addresses_limited()) call need_memory('heights of '//to_text(nx)//' x '//to_text(ny)// &
      ' points from '//to_text(waves)//' waves', mb, error)
  end subroutine choose_method

  !> Heights in double precision [Eq. 1, 2].
  subroutine heights(w, g, method, z, error)
    type(waves_t), intent(in) :: w                     !< waves
    type(grid_t), intent(in) :: g                      !< grid
    type(method_t), intent(in) :: method               !< choice
    real(dp), intent(inout), contiguous :: z(:, :)     !< heights (nx, ny) [m]
    type(error_t), allocatable, intent(out) :: error   !< bad grid, no plan, a signal
    call checked_grid(g, error)
    if (allocated(error)) return
    if (method%evaluator == method_direct) then
      call direct_sum(w, g, 1, z)
    else
      call fast_sum(w, g, method, error, z)
    end if
    if (.not. allocated(error)) call check_stop(error)
  end subroutine heights

  !> Heights in single precision; those of the direct sum are computed in double precision by slabs of rows.
  subroutine heights_single(w, g, method, z, error)
    type(waves_t), intent(in) :: w                     !< waves
    type(grid_t), intent(in) :: g                      !< grid
    type(method_t), intent(in) :: method               !< choice
    real(sp), intent(inout), contiguous :: z(:, :)     !< heights (nx, ny) [m]
    type(error_t), allocatable, intent(out) :: error   !< bad grid, no plan
    real(dp), allocatable :: slab(:, :)
    integer :: rows, j, last
    call checked_grid(g, error)
    if (allocated(error)) return
    if (method%evaluator /= method_direct) then
      call fast_sum(w, g, method, error, z_single=z)
      if (.not. allocated(error)) call check_stop(error)
      return
    end if
    rows = max(1, slab_points / g%nx)
    allocate (slab(g%nx, min(rows, g%ny)))
    do j = 1, g%ny, rows
      last = min(j + rows - 1, g%ny)
      associate (part => slab(:, :last - j + 1))
        call direct_sum(w, g, j, part)
        !$omp parallel workshare
        z(:, j:last) = real(part, sp)
        !$omp end parallel workshare
      end associate
    end do
    call check_stop(error)
  end subroutine heights_single

  !> Heights by the NUFFT or by a product, in double or in single precision.
  subroutine fast_sum(w, g, method, error, z, z_single)
    type(waves_t), intent(in) :: w                                      !< waves
    type(grid_t), intent(in) :: g                                       !< grid
    type(method_t), intent(in) :: method                                !< choice
    type(error_t), allocatable, intent(out) :: error                    !< no plan
    real(dp), intent(inout), contiguous, optional :: z(:, :)            !< heights (nx, ny) [m]
    real(sp), intent(inout), contiguous, optional :: z_single(:, :)     !< the same
    type(nufft_t) :: nufft
    type(plain_t) :: plain
    type(plain_single_t) :: single
    if (method%evaluator == method_nufft) then
      call new_nufft(w, g, method%nufft, nufft)
      if (nufft%precision == in_double) call sum_tiles(nufft, nufft%x%piece, nufft%y%piece, error, z, z_single)
      if (nufft%precision == in_single) call sum_tiles_single(nufft, nufft%x%piece_single, nufft%y%piece_single, error, z, z_single)
    else if (method%precision == in_single) then
      call new_plain_single(w, g, single)
      call plain_sum_single(single, z, z_single)
    else
      call new_plain(w, g, plain)
      call plain_sum(plain, z, z_single)
    end if
  end subroutine fast_sum
end module hd_heights
