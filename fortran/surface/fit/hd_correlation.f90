! SPDX-License-Identifier: GPL-3.0-or-later
!> Sums of squared differences at all lags at once, by FFTW: sum (b - a)^2 = sum a^2 + sum b^2 - 2 sum a b. The last step
!> cancels at short lags, so each sum comes with the error it may carry and the caller does over what is not good enough.
module hd_correlation
  use hd_kinds, only: dp, i8
  use hd_error, only: error_t, raise, code_memory
  use hd_text, only: to_text
  use hd_fft, only: forward_real, backward_real, forward_real_2d, backward_real_2d, smooth_size
  implicit none
  private
  public :: correlate_lines, correlate_map

contains

  !> Sums over pairs along the first index, each line taken about its own mean (which no difference sees).
  subroutine correlate_lines(z, holes, total, count, rounding, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    logical, intent(in) :: holes                      !< look for holes
    real(dp), intent(out) :: total(:), count(:)       !< sums [m^2] and numbers of pairs at lags 1, 2, ... (last < nx)
    real(dp), intent(out) :: rounding                    !< rounding error of a sum [m^2], estimate from above
    type(error_t), allocatable, intent(out) :: error  !< memory
    integer, parameter :: block = 16
    real(dp), allocatable :: power(:, :), pairs(:, :), squares(:, :), out(:, :), q(:)
    complex(dp), allocatable :: spectrum(:, :)
    integer :: b, k, blocks, n, nx, last
    logical :: bad
    nx = size(z, 1)
    last = size(total)
    n = smooth_size(nx + last, .true.)
    blocks = (size(z, 2) + block - 1) / block
    allocate (power(n / 2 + 1, blocks), pairs(n / 2 + 1, blocks), squares(nx, blocks))
    bad = .false.
    !$omp parallel do schedule(dynamic) reduction(.or.: bad) if (size(z, kind=i8) > 20000)
    do b = 1, blocks
      call block_spectrum(z(:, 1 + (b - 1) * block:min(b * block, size(z, 2))), n, holes, power(:, b), pairs(:, b), &
        squares(:, b), bad)
    end do
    if (bad) then
      call raise(error, code_memory, 'FFTW finds no plan for lines of '//to_text(n)//' numbers: not enough memory')
      return
    end if
    allocate (spectrum(n / 2 + 1, 2), out(n, 2))
    spectrum(:, 1) = cmplx(sum(power, 2), 0._dp, dp)
    spectrum(:, 2) = cmplx(sum(pairs, 2), 0._dp, dp)
    call backward_real(spectrum, out, error)
    if (allocated(error)) return
    q = sum(squares, 2)
    rounding = 4 * epsilon(1._dp) * sum(q)
    total = out(2:last + 1, 1) / n
    if (holes) then
      count = anint(out(2:last + 1, 2) / n)
    else
      do k = 1, last
        total(k) = total(k) + sum(q(:nx - k)) + sum(q(1 + k:))
        count(k) = real(nx - k, dp) * size(z, 2)
      end do
    end if
  end subroutine correlate_lines

  !> Spectra of a block of lines: of the sum of squared differences (without holes: of its product term only), and of the
  !> number of pairs.
  subroutine block_spectrum(z, n, holes, power, pairs, squares, bad)
    real(dp), intent(in), contiguous :: z(:, :)   !< lines (nx, lines) [m]
    integer, intent(in) :: n                      !< padded length
    logical, intent(in) :: holes                  !< look for holes
    real(dp), intent(out) :: power(:), pairs(:)   !< spectra (n / 2 + 1)
    real(dp), intent(out) :: squares(:)           !< sums of squares over the lines (nx) [m^2]
    logical, intent(inout) :: bad                 !< set if FFTW gave up
    real(dp), allocatable :: a(:, :)
    complex(dp), allocatable :: s(:, :)
    type(error_t), allocatable :: error
    integer :: j, m, kinds, nx
    nx = size(z, 1)
    m = size(z, 2)
    kinds = merge(3, 1, holes)
    allocate (a(n, kinds * m), source=0._dp)
    allocate (s(n / 2 + 1, kinds * m))
    squares = 0
    do j = 1, m
      call centre(z(:, j:j), holes, a(:nx, j:j))
      squares = squares + a(:nx, j)**2
      if (.not. holes) cycle
      a(:nx, m + j) = a(:nx, j)**2
      a(:nx, 2 * m + j) = merge(1._dp, 0._dp, abs(z(:, j)) <= huge(1._dp))
    end do
    call forward_real(a, s, error)
    bad = bad .or. allocated(error)
    power = 0
    pairs = 0
    do j = 1, m
      power = power - 2 * (real(s(:, j), dp)**2 + aimag(s(:, j))**2)
      if (.not. holes) cycle
      power = power + 2 * real(s(:, m + j) * conjg(s(:, 2 * m + j)), dp)
      pairs = pairs + real(s(:, 2 * m + j), dp)**2 + aimag(s(:, 2 * m + j))**2
    end do
  end subroutine block_spectrum

  !> Heights about their mean, 0 in holes. A good point is subtracted first, so a large offset leaves without rounding.
  pure subroutine centre(z, holes, r)
    real(dp), intent(in) :: z(:, :)     !< heights [m]
    logical, intent(in) :: holes        !< look for holes
    real(dp), intent(out) :: r(:, :)    !< heights about the mean, same shape [m]
    integer :: at(2), j
    real(dp) :: n
    at = 1
    if (holes) at = findloc(abs(z) <= huge(1._dp), .true.)
    r = 0
    if (any(at == 0)) return
    n = real(size(z, kind=i8), dp)
    r = z - z(at(1), at(2))
    if (holes) then
      n = 0
      do j = 1, size(z, 2)
        where (.not. abs(z(:, j)) <= huge(1._dp)) r(:, j) = 0
        n = n + real(count(abs(z(:, j)) <= huge(1._dp)), dp)
      end do
    end if
    r = r - sum(sum(r, 1)) / n
    if (holes) then
      do j = 1, size(z, 2)
        where (.not. abs(z(:, j)) <= huge(1._dp)) r(:, j) = 0
      end do
    end if
  end subroutine centre

  !> Sums over pairs at all lag vectors kx = -nx+1..nx-1, ky = 0..ny-1, the map taken about its mean.
  subroutine correlate_map(z, holes, total, count, rounding, error)
    real(dp), intent(in), contiguous :: z(:, :)               !< heights (nx, ny) [m]
    logical, intent(in) :: holes                              !< look for holes
    real(dp), allocatable, intent(out) :: total(:, :)         !< sums (1-nx:nx-1, 0:ny-1) [m^2]
    real(dp), allocatable, intent(out) :: count(:, :)         !< numbers of pairs, same shape
    real(dp), intent(out) :: rounding                            !< rounding error of a sum [m^2], estimate from above
    type(error_t), allocatable, intent(out) :: error          !< memory
    real(dp), allocatable :: r(:, :), q(:, :), m(:, :)
    complex(dp), allocatable :: sr(:, :), sq(:, :), sm(:, :)
    integer :: nx, ny, px, py, j
    nx = size(z, 1)
    ny = size(z, 2)
    px = smooth_size(2 * nx, .true.)
    py = smooth_size(2 * ny, .true.)
    allocate (r(px, py), q(px, py), m(px, py), source=0._dp)
    allocate (sr(px / 2 + 1, py), sq(px / 2 + 1, py), sm(px / 2 + 1, py))
    call centre(z, holes, r(:nx, :ny))
    m(:nx, :ny) = 1
    if (holes) m(:nx, :ny) = merge(1._dp, 0._dp, abs(z) <= huge(1._dp))
    q(:nx, :ny) = r(:nx, :ny)**2
    rounding = 8 * epsilon(1._dp) * sum(sum(q, 1))
    call forward_real_2d(r, sr, error)
    if (.not. allocated(error)) call forward_real_2d(q, sq, error)
    if (.not. allocated(error)) call forward_real_2d(m, sm, error)
    if (allocated(error)) return
    sr = 2 * real(sq * conjg(sm), dp) - 2 * (real(sr, dp)**2 + aimag(sr)**2)
    sm = real(sm, dp)**2 + aimag(sm)**2
    call backward_real_2d(sr, r, error)
    if (.not. allocated(error)) call backward_real_2d(sm, m, error)
    if (allocated(error)) return
    allocate (total(1 - nx:nx - 1, 0:ny - 1), count(1 - nx:nx - 1, 0:ny - 1))
    do j = 0, ny - 1
      total(0:, j) = r(:nx, j + 1) / (real(px, dp) * py)
      total(:-1, j) = r(px - nx + 2:, j + 1) / (real(px, dp) * py)
      count(0:, j) = anint(m(:nx, j + 1) / (real(px, dp) * py))
      count(:-1, j) = anint(m(px - nx + 2:, j + 1) / (real(px, dp) * py))
    end do
  end subroutine correlate_map
end module hd_correlation
