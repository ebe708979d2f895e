! SPDX-License-Identifier: GPL-3.0-or-later
!> C = A B^T summed from the last term to the first: stands in for BLAS in tools/prove_bits.sh.
subroutine dgemm(ta, tb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
  use hd_kinds, only: dp
  implicit none
  character(len=1), intent(in) :: ta, tb               !< 'N', 'T'
  integer, intent(in) :: m, n, k, lda, ldb, ldc        !< shapes
  real(dp), intent(in) :: alpha, beta                  !< 1, 0
  real(dp), intent(in) :: a(lda, *), b(ldb, *)         !< factors
  real(dp), intent(inout) :: c(ldc, *)                 !< product
  integer :: i, j, l
  if (ta /= 'N' .or. tb /= 'T' .or. .not. (alpha >= 1 .and. alpha <= 1) .or. abs(beta) > 0) error stop 'not this dgemm'
  do j = 1, n
    c(:m, j) = 0
    do l = k, 1, -1
      do i = 1, m
        c(i, j) = c(i, j) + a(i, l) * b(j, l)
      end do
    end do
  end do
end subroutine dgemm
