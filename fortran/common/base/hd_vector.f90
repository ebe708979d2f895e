! SPDX-License-Identifier: GPL-3.0-or-later
!> Products and sums of vectors on threads. Long ones are summed in blocks of one length, so that any number of threads gives the
!> same bits.
module hd_vector
  use hd_kinds, only: dp
  implicit none
  private
  public :: cross, dot, largest, length, part_lengths, weighted_length, set, add, add_columns, product_of, &
    orthogonalise, many, thread_share

  integer, parameter :: many = 40000     !< numbers from which two threads are worth waking
  integer, parameter :: block = 1024     !< summed one behind the other: threads share what a face has, and a cache holds many
  integer, parameter :: thread_share = 128  !< points of a thread's turn, where those that press lie together

contains

  !> Vector product.
  pure function cross(a, b) result(c)
    real(dp), intent(in) :: a(3), b(3)  !< factors
    real(dp) :: c(3)
    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Scalar product, or the sum of the products' amounts.
  real(dp) function dot(n, a, b, amounts)
    integer, intent(in) :: n                  !< length
    real(dp), intent(in) :: a(n), b(n)        !< factors
    logical, intent(in), optional :: amounts  !< their sum
    real(dp) :: part((n + block - 1)/block)
    logical :: positive
    integer :: i
    positive = .false.
    if (present(amounts)) positive = amounts
    !$omp parallel do schedule(static) if(n > many)
    do i = 1, size(part)
      associate (low => block*(i - 1) + 1, high => min(n, block*i))
        if (positive) then
          part(i) = sum(abs(a(low:high)*b(low:high)))
        else
          part(i) = dot_product(a(low:high), b(low:high))
        end if
      end associate
    end do
    !$omp end parallel do
    dot = sum(part)
  end function dot

  !> Largest amount.
  real(dp) function largest(n, a)
    integer, intent(in) :: n            !< length
    real(dp), intent(in) :: a(n)        !< vector
    integer :: i
    largest = 0
    !$omp parallel do simd schedule(static) reduction(max: largest) if(n > many)
    do i = 1, n
      largest = max(largest, abs(a(i)))
    end do
    !$omp end parallel do simd
  end function largest

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

  !> Euclidean norms of the parts where a mask is true and where it is not.
  subroutine part_lengths(a, mask, inside, outside)
    real(dp), intent(in) :: a(:, :)            !< vectors (3, n)
    logical, intent(in) :: mask(:, :)          !< (3, n)
    real(dp), intent(out) :: inside, outside
    real(dp) :: part(2, (size(a, 2) + block - 1)/block)
    integer :: i, j
    !$omp parallel do schedule(static) private(j) if(size(a) > many)
    do i = 1, size(part, 2)
      part(:, i) = 0
      do j = block*(i - 1) + 1, min(block*i, size(a, 2))
        part(1, i) = part(1, i) + sum(merge(a(:, j)**2, 0._dp, mask(:, j)))
        part(2, i) = part(2, i) + sum(merge(0._dp, a(:, j)**2, mask(:, j)))
      end do
    end do
    !$omp end parallel do
    inside = sqrt(sum(part(1, :)))
    outside = sqrt(sum(part(2, :)))
  end subroutine part_lengths

  !> Euclidean norm of vectors times their weights.
  real(dp) function weighted_length(weight, a)
    real(dp), intent(in) :: weight(:)   !< (n)
    real(dp), intent(in) :: a(:, :)     !< vectors (3, n)
    real(dp) :: part((size(weight) + block - 1)/block)
    integer :: i, j
    !$omp parallel do schedule(static) private(j) if(size(a) > many/4)
    do i = 1, size(part)
      part(i) = 0
      do j = block*(i - 1) + 1, min(size(weight), block*i)
        part(i) = part(i) + weight(j)**2*(a(1, j)**2 + a(2, j)**2 + a(3, j)**2)
      end do
    end do
    !$omp end parallel do
    weighted_length = sqrt(sum(part))
  end function weighted_length

  !> y = a x.
  subroutine set(n, a, x, y)
    integer, intent(in) :: n            !< length
    real(dp), intent(in) :: a, x(n)     !< factor, vector
    real(dp), intent(out) :: y(n)       !< product
    integer :: i
    !$omp parallel do simd schedule(static) if(n > many)
    do i = 1, n
      y(i) = a*x(i)
    end do
    !$omp end parallel do simd
  end subroutine set

  !> y = y + a x.
  subroutine add(n, a, x, y)
    integer, intent(in) :: n            !< length
    real(dp), intent(in) :: a, x(n)     !< factor, vector
    real(dp), intent(inout) :: y(n)     !< sum
    integer :: i
    !$omp parallel do simd schedule(static) if(n > many)
    do i = 1, n
      y(i) = y(i) + a*x(i)
    end do
    !$omp end parallel do simd
  end subroutine add

  !> y = y + V a.
  subroutine add_columns(v, a, y)
    real(dp), intent(in), contiguous :: v(:, :)     !< V (n, m)
    real(dp), intent(in) :: a(:)                    !< factors (m)
    real(dp), intent(inout), contiguous :: y(:)     !< sum (n)
    integer :: i, k
    !$omp parallel do schedule(static) private(k) if(size(v) > many)
    do i = 1, size(y), block
      associate (high => min(size(y), i + block - 1))
        do k = 1, size(v, 2)
          y(i:high) = y(i:high) + a(k)*v(i:high, k)
        end do
      end associate
    end do
    !$omp end parallel do
  end subroutine add_columns

  !> A x of a matrix with few rows.
  function product_of(a, x) result(y)
    real(dp), intent(in), contiguous :: a(:, :)  !< matrix (m, n)
    real(dp), intent(in), contiguous :: x(:)     !< vector (n)
    real(dp) :: y(size(a, 1)), part(size(a, 1), (size(x) + block - 1)/block)
    integer :: i, k
    !$omp parallel do schedule(static) private(k) if(size(a) > many)
    do i = 1, size(part, 2)
      part(:, i) = 0
      do k = block*(i - 1) + 1, min(size(x), block*i)
        part(:, i) = part(:, i) + x(k)*a(:, k)
      end do
    end do
    !$omp end parallel do
    y = sum(part, 2)
  end function product_of

  !> Take out of w what it has along orthonormal vectors, and make it one of them: by classical Gram-Schmidt done twice, which is as
  !> good as the modified one and reads w once for all of them.
  subroutine orthogonalise(v, w, h, left)
    real(dp), intent(in), contiguous :: v(:, :)     !< orthonormal columns (n, m)
    real(dp), intent(inout), contiguous :: w(:)     !< vector (n)
    real(dp), intent(out) :: h(:)                   !< what it had along them (m)
    real(dp), intent(out) :: left                   !< length of what was left
    real(dp) :: first(size(v, 2), (size(w) + block - 1)/block), second(size(v, 2), (size(w) + block - 1)/block)
    real(dp) :: square((size(w) + block - 1)/block), along(size(v, 2)), scale
    integer :: i
    !$omp parallel private(along, scale) if(size(v) > many)
    !$omp do schedule(static)
    do i = 1, size(square)
      call project(i, first(:, i))
    end do
    !$omp end do
    along = sum(first, 2)
    !$omp do schedule(static)
    do i = 1, size(square)
      call subtract(i, along)
      call project(i, second(:, i))
    end do
    !$omp end do
    along = sum(second, 2)
    !$omp do schedule(static)
    do i = 1, size(square)
      call subtract(i, along)
      square(i) = sum(w(block*(i - 1) + 1:min(size(w), block*i))**2)
    end do
    !$omp end do
    scale = 1/max(sqrt(sum(square)), tiny(1._dp))
    !$omp do schedule(static)
    do i = 1, size(w)
      w(i) = scale*w(i)
    end do
    !$omp end do
    !$omp end parallel
    h = sum(first, 2) + sum(second, 2)
    left = sqrt(sum(square))
  contains
    !> Products of a part of w with the same part of the columns.
    subroutine project(part, products)
      integer, intent(in) :: part
      real(dp), intent(out) :: products(:)
      integer :: k
      associate (low => block*(part - 1) + 1, high => min(size(w), block*part))
        do k = 1, size(v, 2)
          products(k) = dot_product(v(low:high, k), w(low:high))
        end do
      end associate
    end subroutine project

    !> Take the columns out of a part of w.
    subroutine subtract(part, factors)
      integer, intent(in) :: part
      real(dp), intent(in) :: factors(:)
      integer :: k
      associate (low => block*(part - 1) + 1, high => min(size(w), block*part))
        do k = 1, size(v, 2)
          w(low:high) = w(low:high) - factors(k)*v(low:high, k)
        end do
      end associate
    end subroutine subtract
  end subroutine orthogonalise
end module hd_vector
