! SPDX-License-Identifier: GPL-3.0-or-later
!> Real and complex transforms by FFTW, 1-D batched and 2-D, unscaled, in double precision; plans in single precision too.
!>
!> Plans are estimated, never measured: the same sizes give the same algorithm and so the same bits in every run. The planner is
!> behind a process-wide lock; executing a plan needs none. The sign is -1 forward (exp(-i...)), +1 backward.
module hd_fft
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_associated, c_int, c_double, c_double_complex, c_float, &
    c_float_complex, c_size_t, c_intptr_t, c_char, c_funptr, c_int32_t
  use hd_kinds, only: dp, sp
  use hd_error, only: error_t, raise, code_memory
  use hd_text, only: to_text
  implicit none
  private
  public :: forward_real, backward_real, forward_real_2d, backward_real_2d
  public :: fft_plan_t, plan_complex, plan_forward_real, plan_backward_real, plan_rows, execute_complex, execute_forward_real, &
    execute_backward_real, free_plan, smooth_size
  public :: plan_complex_single, plan_backward_real_single, execute_complex_single, execute_backward_real_single
  public :: rows_plan_t, plan_rows_single, execute_rows, execute_rows_single, free_rows

  include 'fftw3.f03'

  !> A plan for repeated use, also from several threads at once, on arrays aligned to 16 bytes. Free it with `free_plan`.
  type :: fft_plan_t
    private
    type(c_ptr) :: plan = c_null_ptr
    logical :: single = .false.    !< of FFTW in single precision
    logical :: kept = .false.      !< for the next that asks: not to be freed
  end type fft_plan_t

  !> Plans of `plan_rows`.
  type :: rows_plan_t
    private
    type(fft_plan_t) :: part(2)    !< of a part, and of the last one if it is shorter
    integer :: rows = 0            !< of all parts
  end type rows_plan_t

  integer, parameter :: rows_of_part = 8      !< parts begin at multiples of 16 bytes, as FFTW asks
  integer, parameter :: long_rows = 30000     !< numbers from which two threads are worth waking

  !> Plans of the NUFFT and of single rows stay for the next call: making them costs more than a small transform.
  type :: kept_t
    integer :: key(6) = 0          !< what was asked for
    type(fft_plan_t) :: plan
  end type kept_t
  type(kept_t), save :: kept(64)
  integer, save :: kept_plans = 0

  interface
    subroutine lock_planner() bind(c, name='hd_lock_planner')
    end subroutine lock_planner
    subroutine unlock_planner() bind(c, name='hd_unlock_planner')
    end subroutine unlock_planner
  end interface

contains

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

  !> Each column of real numbers to its half spectrum.
  subroutine forward_real(a, s, error)
    real(dp), intent(inout), contiguous :: a(:, :)      !< columns (n, count); kept
    complex(dp), intent(inout), contiguous :: s(:, :)   !< half spectra (n/2 + 1, count)
    type(error_t), allocatable, intent(out) :: error    !< no plan
    type(fft_plan_t) :: p
    call lock_planner()
    p%plan = fftw_plan_many_dft_r2c(1, [size(a, 1)], size(a, 2), a, [size(a, 1)], 1, size(a, 1), &
      s, [size(s, 1)], 1, size(s, 1), ior(FFTW_ESTIMATE, FFTW_PRESERVE_INPUT))
    call unlock_planner()
    call check_plan(p, size(a), error)
    if (allocated(error)) return
    call fftw_execute_dft_r2c(p%plan, a, s)
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
    call fftw_execute_dft_c2r(p%plan, s, a)
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
    call fftw_execute_dft_r2c(p%plan, a, s)
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
    call fftw_execute_dft_c2r(p%plan, s, a)
    call free_plan(p)
  end subroutine backward_real_2d

  !> Plan `count` complex transforms of n numbers, `stride` apart, starting `distance` apart, in place.
  subroutine plan_complex(n, count, stride, distance, sign, a, p, error)
    integer, intent(in) :: n, count, stride, distance   !< size, number, strides
    integer, intent(in) :: sign                         !< -1 or +1
    complex(dp), intent(inout) :: a(*)                  !< array of the kind to be transformed; kept
    type(fft_plan_t), intent(out) :: p                  !< plan
    type(error_t), allocatable, intent(out) :: error    !< no plan
    call lock_planner()
    p = kept_plan([1, n, count, stride, distance, sign])
    if (.not. c_associated(p%plan)) then
      p%plan = fftw_plan_many_dft(1, [n], count, a, [n], stride, distance, a, [n], stride, distance, int(sign, c_int), &
        FFTW_ESTIMATE)
      call keep_plan([1, n, count, stride, distance, sign], p)
    end if
    call unlock_planner()
    call check_plan(p, n, error)
  end subroutine plan_complex

  !> The same in single precision.
  subroutine plan_complex_single(n, count, stride, distance, sign, a, p, error)
    integer, intent(in) :: n, count, stride, distance   !< size, number, strides
    integer, intent(in) :: sign                         !< -1 or +1
    complex(sp), intent(inout) :: a(*)                  !< array of the kind to be transformed; kept
    type(fft_plan_t), intent(out) :: p                  !< plan
    type(error_t), allocatable, intent(out) :: error    !< no plan
    call lock_planner()
    p = kept_plan([2, n, count, stride, distance, sign])
    if (.not. c_associated(p%plan)) then
      p%plan = fftwf_plan_many_dft(1, [n], count, a, [n], stride, distance, a, [n], stride, distance, int(sign, c_int), &
        FFTW_ESTIMATE)
      p%single = .true.
      call keep_plan([2, n, count, stride, distance, sign], p)
    end if
    call unlock_planner()
    call check_plan(p, n, error)
  end subroutine plan_complex_single

  !> Plan `count` transforms of contiguous real columns (n) to contiguous half spectra (n/2 + 1).
  subroutine plan_forward_real(n, count, a, s, p, error)
    integer, intent(in) :: n, count                     !< size, number
    real(dp), intent(inout) :: a(*)                     !< columns; kept
    complex(dp), intent(inout) :: s(*)                  !< half spectra; kept
    type(fft_plan_t), intent(out) :: p                  !< plan
    type(error_t), allocatable, intent(out) :: error    !< no plan
    call lock_planner()
    p = kept_plan([5, n, count, 0, 0, 0])
    if (.not. c_associated(p%plan)) then
      p%plan = fftw_plan_many_dft_r2c(1, [n], count, a, [n], 1, n, s, [n / 2 + 1], 1, n / 2 + 1, FFTW_ESTIMATE)
      call keep_plan([5, n, count, 0, 0, 0], p)
    end if
    call unlock_planner()
    call check_plan(p, n, error)
  end subroutine plan_forward_real

  !> Plan `count` transforms of contiguous half spectra (n/2 + 1) to contiguous real columns (n).
  subroutine plan_backward_real(n, count, s, a, p, error)
    integer, intent(in) :: n, count                     !< size, number
    complex(dp), intent(inout) :: s(*)                  !< half spectra; kept
    real(dp), intent(inout) :: a(*)                     !< columns; kept
    type(fft_plan_t), intent(out) :: p                  !< plan
    type(error_t), allocatable, intent(out) :: error    !< no plan
    call lock_planner()
    p = kept_plan([3, n, count, 0, 0, 0])
    if (.not. c_associated(p%plan)) then
      p%plan = fftw_plan_many_dft_c2r(1, [n], count, s, [n / 2 + 1], 1, n / 2 + 1, a, [n], 1, n, FFTW_ESTIMATE)
      call keep_plan([3, n, count, 0, 0, 0], p)
    end if
    call unlock_planner()
    call check_plan(p, n, error)
  end subroutine plan_backward_real

  !> The same in single precision.
  subroutine plan_backward_real_single(n, count, s, a, p, error)
    integer, intent(in) :: n, count                     !< size, number
    complex(sp), intent(inout) :: s(*)                  !< half spectra; kept
    real(sp), intent(inout) :: a(*)                     !< columns; kept
    type(fft_plan_t), intent(out) :: p                  !< plan
    type(error_t), allocatable, intent(out) :: error    !< no plan
    call lock_planner()
    p = kept_plan([4, n, count, 0, 0, 0])
    if (.not. c_associated(p%plan)) then
      p%plan = fftwf_plan_many_dft_c2r(1, [n], count, s, [n / 2 + 1], 1, n / 2 + 1, a, [n], 1, n, FFTW_ESTIMATE)
      p%single = .true.
      call keep_plan([4, n, count, 0, 0, 0], p)
    end if
    call unlock_planner()
    call check_plan(p, n, error)
  end subroutine plan_backward_real_single

  !> Plan transforms of rows of real numbers (count, n) to rows of half spectra (count, n/2 + 1), and back. Many are done in
  !> parts of `rows_of_part` rows, which threads share: the same parts for any number of them.
  subroutine plan_rows(n, count, a, s, forward, backward, error)
    integer, intent(in) :: n, count                     !< size, number
    real(dp), intent(inout) :: a(*)                     !< rows; kept
    complex(dp), intent(inout) :: s(*)                  !< half spectra; kept
    type(rows_plan_t), intent(out) :: forward, backward !< plans
    type(error_t), allocatable, intent(out) :: error    !< no plan
    integer :: i, m(2)
    m = parts_of(n, count)
    call lock_planner()
    do i = 1, 2
      if (m(i) == 0) cycle
      forward%part(i)%plan = fftw_plan_many_dft_r2c(1, [n], m(i), a, [n], count, 1, s, [n / 2 + 1], count, 1, FFTW_ESTIMATE)
      backward%part(i)%plan = fftw_plan_many_dft_c2r(1, [n], m(i), s, [n / 2 + 1], count, 1, a, [n], count, 1, FFTW_ESTIMATE)
    end do
    call unlock_planner()
    forward%rows = count
    backward%rows = count
    do i = 1, 2
      if (m(i) > 0 .and. .not. allocated(error)) call check_plan(forward%part(i), n, error)
      if (m(i) > 0 .and. .not. allocated(error)) call check_plan(backward%part(i), n, error)
    end do
  end subroutine plan_rows

  !> The same in single precision.
  subroutine plan_rows_single(n, count, a, s, forward, backward, error)
    integer, intent(in) :: n, count                     !< size, number
    real(sp), intent(inout) :: a(*)                     !< rows; kept
    complex(sp), intent(inout) :: s(*)                  !< half spectra; kept
    type(rows_plan_t), intent(out) :: forward, backward !< plans
    type(error_t), allocatable, intent(out) :: error    !< no plan
    integer :: i, m(2)
    m = parts_of(n, count)
    call lock_planner()
    do i = 1, 2
      if (m(i) == 0) cycle
      forward%part(i)%plan = fftwf_plan_many_dft_r2c(1, [n], m(i), a, [n], count, 1, s, [n / 2 + 1], count, 1, FFTW_ESTIMATE)
      backward%part(i)%plan = fftwf_plan_many_dft_c2r(1, [n], m(i), s, [n / 2 + 1], count, 1, a, [n], count, 1, FFTW_ESTIMATE)
    end do
    call unlock_planner()
    forward%part%single = .true.
    backward%part%single = .true.
    forward%rows = count
    backward%rows = count
    do i = 1, 2
      if (m(i) > 0 .and. .not. allocated(error)) call check_plan(forward%part(i), n, error)
      if (m(i) > 0 .and. .not. allocated(error)) call check_plan(backward%part(i), n, error)
    end do
  end subroutine plan_rows_single

  !> Rows of a part, and of the last one if it is shorter.
  pure function parts_of(n, count) result(rows)
    integer, intent(in) :: n, count  !< size, number
    integer :: rows(2)
    rows = [count, 0]
    if (n*count > long_rows .and. count > rows_of_part) rows = [rows_of_part, modulo(count, rows_of_part)]
  end function parts_of

  !> Run a plan of `plan_complex`.
  subroutine execute_complex(p, a)
    type(fft_plan_t), intent(in) :: p       !< plan
    complex(dp), intent(inout) :: a(*)      !< transformed in place
    call fftw_execute_dft(p%plan, a, a)
  end subroutine execute_complex

  !> The same in single precision.
  subroutine execute_complex_single(p, a)
    type(fft_plan_t), intent(in) :: p       !< plan
    complex(sp), intent(inout) :: a(*)      !< transformed in place
    call fftwf_execute_dft(p%plan, a, a)
  end subroutine execute_complex_single

  !> Run a plan of `plan_forward_real`.
  subroutine execute_forward_real(p, a, s)
    type(fft_plan_t), intent(in) :: p       !< plan
    real(dp), intent(inout) :: a(*)         !< real columns; kept
    complex(dp), intent(inout) :: s(*)      !< half spectra
    call fftw_execute_dft_r2c(p%plan, a, s)
  end subroutine execute_forward_real

  !> Run a plan of `plan_backward_real`.
  subroutine execute_backward_real(p, s, a)
    type(fft_plan_t), intent(in) :: p       !< plan
    complex(dp), intent(inout) :: s(*)      !< half spectra; destroyed
    real(dp), intent(inout) :: a(*)         !< real columns
    call fftw_execute_dft_c2r(p%plan, s, a)
  end subroutine execute_backward_real

  !> The same in single precision.
  subroutine execute_backward_real_single(p, s, a)
    type(fft_plan_t), intent(in) :: p       !< plan
    complex(sp), intent(inout) :: s(*)      !< half spectra; destroyed
    real(sp), intent(inout) :: a(*)         !< real columns
    call fftwf_execute_dft_c2r(p%plan, s, a)
  end subroutine execute_backward_real_single

  !> Run a plan of `plan_rows`; s or a is destroyed backward.
  subroutine execute_rows(p, n, a, s, forward)
    type(rows_plan_t), intent(in) :: p            !< plan
    integer, intent(in) :: n                      !< size
    real(dp), intent(inout) :: a(p%rows, n)       !< rows
    complex(dp), intent(inout) :: s(p%rows, n/2 + 1)  !< half spectra
    logical, intent(in) :: forward                !< from rows to half spectra
    integer :: i, m(2)
    m = parts_of(n, p%rows)
    !$omp parallel do schedule(static) if(m(1) < p%rows)
    do i = 1, p%rows, m(1)
      associate (plan => p%part(merge(1, 2, i + m(1) <= p%rows + 1))%plan)
        if (forward) call fftw_execute_dft_r2c(plan, a(i, 1), s(i, 1))
        if (.not. forward) call fftw_execute_dft_c2r(plan, s(i, 1), a(i, 1))
      end associate
    end do
    !$omp end parallel do
  end subroutine execute_rows

  !> The same in single precision.
  subroutine execute_rows_single(p, n, a, s, forward)
    type(rows_plan_t), intent(in) :: p            !< plan
    integer, intent(in) :: n                      !< size
    real(sp), intent(inout) :: a(p%rows, n)       !< rows
    complex(sp), intent(inout) :: s(p%rows, n/2 + 1)  !< half spectra
    logical, intent(in) :: forward                !< from rows to half spectra
    integer :: i, m(2)
    m = parts_of(n, p%rows)
    !$omp parallel do schedule(static) if(m(1) < p%rows)
    do i = 1, p%rows, m(1)
      associate (plan => p%part(merge(1, 2, i + m(1) <= p%rows + 1))%plan)
        if (forward) call fftwf_execute_dft_r2c(plan, a(i, 1), s(i, 1))
        if (.not. forward) call fftwf_execute_dft_c2r(plan, s(i, 1), a(i, 1))
      end associate
    end do
    !$omp end parallel do
  end subroutine execute_rows_single

  !> Give plans of rows back.
  subroutine free_rows(p)
    type(rows_plan_t), intent(inout) :: p   !< plans
    call free_plan(p%part(1))
    call free_plan(p%part(2))
  end subroutine free_rows

  !> Give a plan back.
  subroutine free_plan(p)
    type(fft_plan_t), intent(inout) :: p    !< plan
    if (.not. c_associated(p%plan) .or. p%kept) return
    call lock_planner()
    if (p%single) then
      call fftwf_destroy_plan(p%plan)
    else
      call fftw_destroy_plan(p%plan)
    end if
    call unlock_planner()
    p%plan = c_null_ptr
  end subroutine free_plan

  !> The plan that was kept, or none. Only behind the lock.
  type(fft_plan_t) function kept_plan(key) result(p)
    integer, intent(in) :: key(:)           !< what is asked for
    integer :: i
    do i = 1, kept_plans
      if (all(kept(i)%key == key)) p = kept(i)%plan
    end do
  end function kept_plan

  !> Keep a plan while there is room. Only behind the lock.
  subroutine keep_plan(key, p)
    integer, intent(in) :: key(:)           !< what was asked for
    type(fft_plan_t), intent(inout) :: p    !< plan
    if (.not. c_associated(p%plan) .or. kept_plans == size(kept)) return
    p%kept = .true.
    kept_plans = kept_plans + 1
    kept(kept_plans) = kept_t(key, p)
  end subroutine keep_plan

  !> FFTW returns no plan if memory runs out.
  subroutine check_plan(p, n, error)
    type(fft_plan_t), intent(in) :: p                   !< plan
    integer, intent(in) :: n                            !< size
    type(error_t), allocatable, intent(out) :: error    !< no plan
    if (c_associated(p%plan)) return
    call raise(error, code_memory, 'FFTW finds no plan for a transform of '//to_text(n)//' numbers: not enough memory')
  end subroutine check_plan
end module hd_fft
