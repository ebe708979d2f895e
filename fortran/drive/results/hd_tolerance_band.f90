! SPDX-License-Identifier: GPL-3.0-or-later
!> The 95 % band of what a loop says, by the tolerances of its inputs.
!>
!> Each input is moved to the ends of its tolerance. Changes are those of the logarithm of a result; they add up by the root of
!> their squares, upwards and downwards apart. An input that moves a result to one side only widens that side alone.
module hd_tolerance_band
  use hd_kinds, only: dp, pi
  use hd_facets, only: sums_t
  use hd_loop, only: readings_t
  use hd_text, only: string_t, percent, push, rounded
  implicit none
  private
  public :: tolerance_band_t, banded, readings, banded_keys, banded_words, banded_values

  integer, parameter :: banded = 7  !< results that have a band,
  integer, parameter :: readings = 5  !< of which the first are readings of the loop
  character(len=23), parameter :: banded_keys(banded) = [character(len=23) :: 'k1_nm_per_rad', 'k2_nm_per_rad', 'k3_nm_per_rad', &
    'hysteresis_rad', 'lost_motion_rad', 'k_ts_bonded_nm_per_rad', 'k_ts_contact_nm_per_rad']
  character(len=12), parameter :: banded_words(banded) = [character(len=12) :: 'K1', 'K2', 'K3', 'hysteresis', 'lost motion', &
    'K_TS bonded', 'K_TS contact']
  integer, parameter :: shared = 2          !< K2: the result whose variance is shared out
  real(dp), parameter :: told = 0.03_dp     !< share below which the log does not name an input

  type :: tolerance_band_t
    type(string_t), allocatable :: input(:)          !< keys; not allocated: no band was asked for
    real(dp), allocatable :: up(:, :), down(:, :)    !< largest change of the logarithm upwards and downwards (banded, inputs)
    logical :: known(banded) = .true.                !< the drive as it is has such a result
  contains
    procedure :: add => add_input
    procedure :: bounds
    procedure :: ranked
    procedure :: text => band_text
  end type tolerance_band_t

contains

  !> The results that have a band; 0 where there is none or it is not positive.
  pure function banded_values(readings, sums) result(value)
    type(readings_t), intent(in) :: readings  !< of the loop
    type(sums_t), intent(in) :: sums          !< of its reference step
    real(dp) :: value(banded)
    value = [readings%k, merge(readings%hysteresis, 0._dp, readings%has_hysteresis), &
      merge(readings%lost_motion, 0._dp, readings%has_lost_motion), sums%k_tangent, sums%k_contact]
    where (.not. value > 0) value = 0
  end function banded_values

  !> Enter an input with what it changes at the ends of its tolerance. An end where a result is 0 does not count for it.
  pure subroutine add_input(self, key, base, moved)
    class(tolerance_band_t), intent(inout) :: self     !< grows
    character(len=*), intent(in) :: key      !< of the input
    real(dp), intent(in) :: base(banded)     !< as banded_values
    real(dp), intent(in) :: moved(:, :)      !< likewise, at each end (banded, ends)
    real(dp) :: change(banded)
    integer :: i, n
    if (.not. allocated(self%input)) allocate (self%input(0), self%up(banded, 0), self%down(banded, 0))
    self%known = self%known .and. base > 0
    n = size(self%input) + 1
    call push(self%input, key)
    self%up = reshape([self%up, [(0._dp, i=1, banded)]], [banded, n])
    self%down = reshape([self%down, [(0._dp, i=1, banded)]], [banded, n])
    do i = 1, size(moved, 2)
      change = 0
      where (base > 0 .and. moved(:, i) > 0) change = log(moved(:, i)/base)
      self%up(:, n) = max(self%up(:, n), change)
      self%down(:, n) = max(self%down(:, n), -change)
    end do
  end subroutine add_input

  !> Lower and upper end over the value.
  pure function bounds(self) result(factor)
    class(tolerance_band_t), intent(in) :: self  !< with one input or more
    real(dp) :: factor(2, banded)
    factor(1, :) = exp(-norm2(self%down, 2))
    factor(2, :) = exp(norm2(self%up, 2))
  end function bounds

  !> Inputs with their shares of the variance of ln K2, the largest first.
  pure subroutine ranked(self, key, share)
    class(tolerance_band_t), intent(in) :: self              !< with one input or more
    type(string_t), allocatable, intent(out) :: key(:)       !< inputs
    real(dp), allocatable, intent(out) :: share(:)           !< add up to 1, or all 0 where none changes it
    real(dp) :: left(size(self%input))
    integer :: i, k
    left = self%up(shared, :)**2 + self%down(shared, :)**2
    allocate (key(0), share(size(left)))
    share = 0
    do i = 1, size(left)
      k = maxloc(left, 1)
      share(i) = left(k)
      left(k) = -1
      call push(key, self%input(k)%s)
    end do
    if (any(share > 0)) share = share/sum(share)
  end subroutine ranked

  !> The band in a line of the log, and which inputs make it.
  pure function band_text(self, value) result(text)
    class(tolerance_band_t), intent(in) :: self         !< with one input or more
    real(dp), intent(in) :: value(banded)     !< as banded_values
    character(len=:), allocatable :: text
    type(string_t), allocatable :: key(:)
    real(dp), allocatable :: share(:)
    real(dp) :: factor(2, banded), scale  !< angles in minutes of arc
    integer :: i
    factor = self%bounds()
    text = '95 %: '
    do i = 1, banded
      if (.not. (value(i) > 0 .and. self%known(i))) cycle
      scale = merge(60*180/pi, 1._dp, index(banded_keys(i), '_rad ') > 0 .and. index(banded_keys(i), '_per_') == 0)
      text = text//trim(banded_words(i))//' '//rounded(scale*value(i)*factor(1, i))//' to '// &
        rounded(scale*value(i)*factor(2, i))//trim(merge("'", ' ', scale > 1))//', '
    end do
    call self%ranked(key, share)
    text = text//'made by '
    do i = 1, size(key)
      if (i > 1 .and. share(i) < told) exit
      if (i > 1) text = text//', '
      text = text//key(i)%s//' '//percent(share(i))
    end do
  end function band_text
end module hd_tolerance_band
