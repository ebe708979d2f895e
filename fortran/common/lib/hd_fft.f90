! SPDX-License-Identifier: GPL-3.0-or-later
!> Real and complex transforms by FFTW, 1-D batched and 2-D, unscaled, in double precision.
!>
!> Plans are estimated, never measured: the same sizes give the same algorithm and so the same bits in every run. The planner is
!> behind a process-wide lock; executing a plan needs none. The sign is -1 forward (exp(-i...)), +1 backward.
module hd_fft
  use, intrinsic :: iso_c_binding, only: c_associated, c_null_ptr
  use hd_kinds, only: dp, rk => dp
  use hd_error, only: error_t, raise, code_memory
  use hd_fftw, only: fft_plan_t, rows_plan_t, kept_t, long_rows, rows_of_part, lock_planner, unlock_planner
  use hd_fftw, only: FFTW_BACKWARD, FFTW_ESTIMATE, FFTW_PRESERVE_INPUT, &
    fftw_plan_dft_r2c_2d, fftw_plan_dft_c2r_2d, plan_many => fftw_plan_many_dft, &
    plan_many_r2c => fftw_plan_many_dft_r2c, plan_many_c2r => fftw_plan_many_dft_c2r, run_dft => fftw_execute_dft, &
    run_r2c => fftw_execute_dft_r2c, run_c2r => fftw_execute_dft_c2r, destroy_plan => fftw_destroy_plan
  use hd_text, only: to_text
  implicit none
  private
  public :: forward_real, backward_real, forward_real_2d, backward_real_2d, smooth_size
  public :: fft_plan_t, plan_complex, plan_forward_real, plan_backward_real, execute_complex, execute_forward_real, &
    execute_backward_real, free_plan
  public :: rows_plan_t, plan_rows, execute_rows, free_rows

  type(kept_t), save :: kept(64)
  integer, save :: kept_plans = 0

contains

  include 'hd_fft.inc'

  !> Plan `count` transforms of contiguous real columns (n) to contiguous half spectra (n/2 + 1).
  subroutine plan_forward_real(n, count, a, s, p, error)
    integer, intent(in) :: n, count                     !< size, number
    real(dp), intent(inout) :: a(*)                     !< columns; kept
    complex(dp), intent(inout) :: s(*)                  !< half spectra; kept
    type(fft_plan_t), intent(out) :: p                  !< plan
    type(error_t), allocatable, intent(out) :: error    !< no plan
    call lock_planner()
    p = kept_plan([3, n, count, 0])
    if (.not. c_associated(p%plan)) then
      p%plan = plan_many_r2c(1, [n], count, a, [n], 1, n, s, [n / 2 + 1], 1, n / 2 + 1, FFTW_ESTIMATE)
      call keep_plan([3, n, count, 0], p)
    end if
    call unlock_planner()
    call check_plan(p, n, error)
  end subroutine plan_forward_real

  !> Run a plan of `plan_forward_real`.
  subroutine execute_forward_real(p, a, s)
    type(fft_plan_t), intent(in) :: p       !< plan
    real(dp), intent(inout) :: a(*)         !< real columns; kept
    complex(dp), intent(inout) :: s(*)      !< half spectra
    call run_r2c(p%plan, a, s)
  end subroutine execute_forward_real

  !> Each column of real numbers to its half spectrum.
  subroutine forward_real(a, s, error)
    real(dp), intent(inout), contiguous :: a(:, :)      !< columns (n, count); kept
    complex(dp), intent(inout), contiguous :: s(:, :)   !< half spectra (n/2 + 1, count)
    type(error_t), allocatable, intent(out) :: error    !< no plan
    type(fft_plan_t) :: p
    call lock_planner()
    p%plan = plan_many_r2c(1, [size(a, 1)], size(a, 2), a, [size(a, 1)], 1, size(a, 1), &
      s, [size(s, 1)], 1, size(s, 1), ior(FFTW_ESTIMATE, FFTW_PRESERVE_INPUT))
    call unlock_planner()
    call check_plan(p, size(a), error)
    if (allocated(error)) return
    call run_r2c(p%plan, a, s)
    call free_plan(p)
  end subroutine forward_real

  !> Each half spectrum to its column of real numbers.
  subroutine backward_real(s, a, error)
    complex(dp), intent(inout), contiguous :: s(:, :)   !< half spectra (n/2 + 1, count); destroyed
    real(dp), intent(inout), contiguous :: a(:, :)      !< columns (n, count)
    type(error_t), allocatable, intent(out) :: error    !< no plan
    type(fft_plan_t) :: p
    call plan_backward_real(size(a, 1), size(a, 2), s, a, p, error)
    if (allocated(error)) return
    call run_c2r(p%plan, s, a)
    call free_plan(p)
  end subroutine backward_real

  !> Real array to its half spectrum in both directions.
  subroutine forward_real_2d(a, s, error)
    real(dp), intent(inout), contiguous :: a(:, :)      !< array (nx, ny); kept
    complex(dp), intent(inout), contiguous :: s(:, :)   !< half spectrum (nx/2 + 1, ny)
    type(error_t), allocatable, intent(out) :: error    !< no plan
    type(fft_plan_t) :: p
    call lock_planner()
    p%plan = fftw_plan_dft_r2c_2d(size(a, 2), size(a, 1), a, s, FFTW_ESTIMATE)
    call unlock_planner()
    call check_plan(p, size(a), error)
    if (allocated(error)) return
    call run_r2c(p%plan, a, s)
    call free_plan(p)
  end subroutine forward_real_2d

  !> Half spectrum to the real array.
  subroutine backward_real_2d(s, a, error)
    complex(dp), intent(inout), contiguous :: s(:, :)   !< half spectrum (nx/2 + 1, ny); destroyed
    real(dp), intent(inout), contiguous :: a(:, :)      !< array (nx, ny)
    type(error_t), allocatable, intent(out) :: error    !< no plan
    type(fft_plan_t) :: p
    call lock_planner()
    p%plan = fftw_plan_dft_c2r_2d(size(a, 2), size(a, 1), s, a, FFTW_ESTIMATE)
    call unlock_planner()
    call check_plan(p, size(a), error)
    if (allocated(error)) return
    call run_c2r(p%plan, s, a)
    call free_plan(p)
  end subroutine backward_real_2d

  !> Smallest size >= n of the form 2^a 3^b 5^c, even if asked: FFTW is fast there.
  pure integer function smooth_size(n, even) result(size_)
    integer, intent(in) :: n        !< lower bound
    logical, intent(in) :: even     !< only even sizes
    integer :: rest
    size_ = max(n, 1)
    do
      rest = size_
      do while (mod(rest, 2) == 0)
        rest = rest / 2
      end do
      do while (mod(rest, 3) == 0)
        rest = rest / 3
      end do
      do while (mod(rest, 5) == 0)
        rest = rest / 5
      end do
      if (rest == 1 .and. (.not. even .or. mod(size_, 2) == 0)) return
      size_ = size_ + 1
    end do
  end function smooth_size
end module hd_fft
