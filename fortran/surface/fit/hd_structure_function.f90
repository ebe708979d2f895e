! SPDX-License-Identifier: GPL-3.0-or-later
!> Structure function S(tau) = mean (z(x + tau) - z(x))^2 of a height map along a direction or over all of them, and its
!> second-difference form. Few lags are summed directly; many come from FFTW, and those it cannot give to 2e-13 are summed again.
module hd_structure_function
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  use hd_pair_sum, only: pair_sum, pair_sum_lines, second_sum, has_holes
  use hd_correlation, only: correlate_lines, correlate_map
  implicit none
  private
  public :: structure_line, structure_radial, structure_second, check_map

  integer, parameter :: few_turned = 4      !< lags along columns that are summed where they stand; of more the map is turned, once
  real(dp), parameter :: trust = 2e-13_dp   !< relative error up to which a sum from FFTW is kept
  integer, parameter :: few = 64            !< up to so many lags are summed directly

contains

  !> A map must have numbers, two points in a direction, and a positive spacing.
  subroutine check_map(z, dx, dy, error)
    real(dp), intent(in) :: z(:, :)                   !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                    !< spacing [m]
    type(error_t), allocatable, intent(out) :: error  !< what is wrong with it
    if (size(z, 1) < 2) then
      call raise(error, code_input, 'the map has '//to_text(size(z, 1))//' x '//to_text(size(z, 2))// &
        ' points (along a row x rows): a row needs at least 2; give a single line as one row')
    else if (.not. (dx > 0 .and. dy > 0 .and. max(dx, dy) <= huge(dx))) then
      call raise(error, code_input, 'spacing '//to_text(dx)//' x '//to_text(dy)//' m: both must be positive and finite')
    else if (.not. any(abs(z) <= huge(dx))) then
      call raise(error, code_input, 'the map of '//to_text(size(z, 1))//' x '//to_text(size(z, 2))// &
        ' points holds no height: every point is NaN or infinite')
    end if
  end subroutine check_map

  !> Refuse lags below 1 and a step that leads nowhere.
  subroutine check_lags(step, lags, error)
    integer, intent(in) :: step(2)                    !< step in points (x, y)
    integer, intent(in) :: lags(:)                    !< multiples of the step
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    if (any(lags < 1) .or. step(2) < 0 .or. all(step == 0)) call raise(error, code_input, 'least lag '//to_text(minval(lags))// &
      ' along the step ('//to_text(step(1))//', '//to_text(step(2))//'); valid: lags >= 1, a step with y >= 0 that is not (0, 0)')
  end subroutine check_lags

  !> S at multiples of a step: (1, 0) along the rows, (0, 1) along the columns, any other whole numbers for an oblique line.
  subroutine structure_line(z, step, lags, s, count, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    integer, intent(in) :: step(2)                    !< step in points (x, y), y >= 0
    integer, intent(in) :: lags(:)                    !< multiples of the step, >= 1
    real(dp), intent(out) :: s(:)                     !< S [m^2], NaN where no pair is left
    real(dp), intent(out) :: count(:)                 !< numbers of pairs
    type(error_t), allocatable, intent(out) :: error  !< memory, lags
    logical :: holes
    integer :: i
    call check_lags(step, lags, error)
    if (allocated(error)) return
    holes = has_holes(z)
    if (all(step == [1, 0])) then
      call along_rows(z, lags, holes, s, count, error)
    else if (all(step == [0, 1]) .and. size(lags) > few_turned) then
      call along_rows(transpose(z), lags, holes, s, count, error)
    else
      do i = 1, size(lags)
        call sum_vector(z, lags(i), step, holes, s(i), count(i))
      end do
    end if
    if (allocated(error)) return
    s = mean_of(s, count)
  end subroutine structure_line

  !> Direct sum at a multiple of a step, none outside the map.
  subroutine sum_vector(z, lag, step, holes, total, count)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights [m]
    integer, intent(in) :: lag, step(2)               !< lag vector = lag x step
    logical, intent(in) :: holes                      !< look for holes
    real(dp), intent(out) :: total, count             !< sum [m^2], number of pairs
    total = 0
    count = 0
    if (real(lag, dp) * abs(step(1)) >= size(z, 1) .or. real(lag, dp) * step(2) >= size(z, 2)) return
    call pair_sum(z, lag * step(1), lag * step(2), holes, total, count)
  end subroutine sum_vector

  !> Sums along the first index: direct, or from FFTW with what it cannot give done directly.
  subroutine along_rows(z, lags, holes, total, count, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    integer, intent(in) :: lags(:)                    !< lags
    logical, intent(in) :: holes                      !< look for holes
    real(dp), intent(out) :: total(:), count(:)       !< sums [m^2], numbers of pairs
    type(error_t), allocatable, intent(out) :: error  !< memory
    real(dp), allocatable :: all_total(:), all_count(:)
    integer, allocatable :: again(:)
    integer :: i, last
    real(dp) :: rounding
    last = min(maxval(lags), size(z, 1) - 1)
    if (size(lags) <= few .or. last < 1) then
      call pair_sum_lines(z, lags, holes, total, count)
      return
    end if
    allocate (all_total(last), all_count(last))
    call correlate_lines(z, holes, all_total, all_count, rounding, error)
    if (allocated(error)) return
    total = 0
    count = 0
    do i = 1, size(lags)
      if (lags(i) > last) cycle
      total(i) = all_total(lags(i))
      count(i) = all_count(lags(i))
    end do
    again = pack([(i, i=1, size(lags))], lags <= last .and. count > 0 .and. .not. total * trust > rounding)
    if (size(again) == 0) return
    call redo(z, lags, again, holes, total, count)
  end subroutine along_rows

  !> Direct sums for some of the lags.
  subroutine redo(z, lags, again, holes, total, count)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    integer, intent(in) :: lags(:), again(:)          !< lags, and which of them
    logical, intent(in) :: holes                      !< look for holes
    real(dp), intent(inout) :: total(:), count(:)     !< sums [m^2], numbers of pairs
    real(dp) :: t(size(again)), c(size(again))
    call pair_sum_lines(z, lags(again), holes, t, c)
    total(again) = t
    count(again) = c
  end subroutine redo

  !> S over rings of lag vectors, one point spacing wide: ring b holds lengths from (b - 1/2) to (b + 1/2) spacings.
  subroutine structure_radial(z, dx, dy, tau, s, count, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                    !< spacing [m]
    real(dp), intent(out) :: tau(:)                   !< mean length of the lags of a ring, weighted by pairs [m]
    real(dp), intent(out) :: s(:)                     !< S [m^2], NaN in an empty ring
    real(dp), intent(out) :: count(:)                 !< numbers of pairs
    type(error_t), allocatable, intent(out) :: error  !< memory
    real(dp), allocatable :: total(:, :), pairs(:, :)
    real(dp) :: rounding, length, h
    integer :: kx, ky, b
    logical :: holes
    holes = has_holes(z)
    h = min(dx, dy)
    call correlate_map(z, holes, total, pairs, rounding, error)
    if (allocated(error)) return
    tau = 0
    s = 0
    count = 0
    do ky = 0, size(z, 2) - 1
      if (ky * dy > (size(s) + 0.5_dp) * h) exit
      do kx = 1 - size(z, 1), size(z, 1) - 1
        if (ky == 0 .and. kx <= 0) cycle
        length = hypot(kx * dx, ky * dy)
        b = nint(length / h)
        if (b > size(s) .or. pairs(kx, ky) < 0.5_dp) cycle
        if (.not. total(kx, ky) * trust > rounding) call pair_sum(z, kx, ky, holes, total(kx, ky), pairs(kx, ky))
        tau(b) = tau(b) + pairs(kx, ky) * length
        s(b) = s(b) + total(kx, ky)
        count(b) = count(b) + pairs(kx, ky)
      end do
    end do
    tau = mean_of(tau, count)
    s = mean_of(s, count)
  end subroutine structure_radial

  !> Second-difference form, mean (z(x + tau) - 2 z(x) + z(x - tau))^2 = 4 S(tau) - S(2 tau): blind to tilt.
  subroutine structure_second(z, step, lags, s, count, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    integer, intent(in) :: step(2)                    !< step in points (x, y), y >= 0
    integer, intent(in) :: lags(:)                    !< multiples of the step, >= 1
    real(dp), intent(out) :: s(:)                     !< mean square [m^2], NaN where no triple is left
    real(dp), intent(out) :: count(:)                 !< numbers of triples
    type(error_t), allocatable, intent(out) :: error  !< lags
    integer :: i
    call check_lags(step, lags, error)
    if (allocated(error)) return
    s = 0
    count = 0
    do i = 1, size(lags)
      if (2._dp * lags(i) * abs(step(1)) >= size(z, 1) .or. 2._dp * lags(i) * step(2) >= size(z, 2)) cycle
      call second_sum(z, lags(i) * step(1), lags(i) * step(2), s(i), count(i))
    end do
    s = mean_of(s, count)
  end subroutine structure_second

  !> total / count, NaN without a count.
  elemental real(dp) function mean_of(total, count) result(mean)
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    real(dp), intent(in) :: total, count    !< sum and number
    mean = ieee_value(mean, ieee_quiet_nan)
    if (count > 0) mean = total / count
  end function mean_of
end module hd_structure_function
