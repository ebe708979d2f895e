! SPDX-License-Identifier: GPL-3.0-or-later
!> Products of vectors. Long ones are summed in blocks of one length, so that any number of threads gives the same bits.
module hd_vector
  use hd_kinds, only: dp
  implicit none
  private
  public :: cross, dot, length, many

  integer, parameter :: many = 100000    !< numbers from which two threads are worth waking
  integer, parameter :: block = 20000    !< summed one behind the other

contains

  !> Vector product.
  pure function cross(a, b) result(c)
    real(dp), intent(in) :: a(3), b(3)  !< factors
    real(dp) :: c(3)
    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Scalar product.
  real(dp) function dot(n, a, b)
    integer, intent(in) :: n            !< length
    real(dp), intent(in) :: a(n), b(n)  !< factors
    real(dp) :: part((n + block - 1)/block)
    integer :: i
    !$omp parallel do schedule(static) if(n > many)
    do i = 1, size(part)
      associate (low => block*(i - 1) + 1, high => min(n, block*i))
        part(i) = dot_product(a(low:high), b(low:high))
      end associate
    end do
    !$omp end parallel do
    dot = sum(part)
  end function dot

  !> Euclidean norm of numbers whose squares are none too large or small.
  real(dp) function length(n, a)
    integer, intent(in) :: n        !< length
    real(dp), intent(in) :: a(n)    !< vector
    real(dp) :: part((n + block - 1)/block), s
    integer :: i, j
    !$omp parallel do schedule(static) private(s, j) if(n > many)
    do i = 1, size(part)
      s = 0
      !$omp simd reduction(+: s)
      do j = block*(i - 1) + 1, min(n, block*i)
        s = s + a(j)**2
      end do
      part(i) = s
    end do
    !$omp end parallel do
    length = sqrt(sum(part))
  end function length
end module hd_vector
