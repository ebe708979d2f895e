! SPDX-License-Identifier: GPL-3.0-or-later
!> The evaluators of Eq. 1 against the sum in quadruple precision.
module test_heights
  use hd_check, only: check
  use hd_error, only: error_t
  use hd_heights, only: method_t, choose_method, heights, method_direct, method_product, method_nufft
  use hd_kinds, only: dp, qp, i8
  use hd_text, only: to_text
  use hd_waves, only: spectrum_t, waves_t, grid_t, new_waves, free_waves
  implicit none
  private
  public :: run_heights

contains

  subroutine run_heights()
    type(waves_t) :: w
    type(error_t), allocatable :: error
    integer :: j
    call new_waves(spectrum_t(2.5304_dp, 2.4248e-7_dp, 1.5_dp, 5e-4_dp, 1e-5_dp, 10, 1_i8), w, error)
    call compare(w, grid_t(48, 40, 1e-5_dp, 1.2e-5_dp), 'ten ridges')
    call new_waves(spectrum_t(2.2_dp, 1e-8_dp, 1.3_dp, 5e-4_dp, 3e-6_dp, 7, 2_i8), w, error)
    call compare(w, grid_t(37, 51, 1e-5_dp, 0.7e-5_dp, -2e-3_dp, 1e-2_dp), 'seven ridges, aliased, far origin')
    call new_waves(spectrum_t(2.8_dp, 1e-8_dp, 2._dp, 5e-4_dp, 1e-5_dp, 1, 3_i8), w, error)
    call compare(w, grid_t(301, 1, 2e-6_dp, 1._dp), 'a profile (Eq. 2)')
    call new_waves(spectrum_t(2.5_dp, 1e-8_dp, 1.5_dp, 5e-4_dp, 1e-5_dp, 4, 4_i8), w, error)
    call compare(w, grid_t(1, 200, 1._dp, 2e-6_dp), 'one column')
    call compare(w, grid_t(1, 1, 1._dp, 1._dp, 1e-4_dp, 1e-4_dp), 'one point')
    call new_waves(spectrum_t(2.5_dp, 1e-8_dp, 1.5_dp, 5e-4_dp, 2e-6_dp, 100, 5_i8), w, error)
    call compare(w, grid_t(24, 15, 2e-5_dp, 3e-5_dp), 'many groups')
    call free_waves([(0.37_dp * j, j=-5, 5)], [(0.11_dp * j * j, j=-5, 5)], [(1._dp + j * 0.1_dp, j=-5, 5)], &
      [(0.05_dp * j, j=-5, 5)], w)
    call compare(w, grid_t(33, 65, 0.9_dp, 1.1_dp, 0.3_dp, -0.2_dp), 'free waves')
  end subroutine run_heights

  !> Direct sum and products to 1e-12 of the rms; both products and the NUFFT to the tolerance asked for.
  subroutine compare(w, g, name)
    type(waves_t), intent(in) :: w           !< waves
    type(grid_t), intent(in) :: g            !< grid
    character(len=*), intent(in) :: name     !< case
    real(dp) :: z(g%nx, g%ny), rms, tolerance
    real(qp) :: exact(g%nx, g%ny)
    type(method_t) :: method
    type(error_t), allocatable :: error
    integer :: k, l
    call quadruple_sum(w, g, exact)
    rms = sqrt(sum(w%amplitude**2) / 2)
    do k = method_direct, method_product
      call choose_method(g%nx, g%ny, size(w%fx, kind=i8), int(w%groups, i8), 0._dp, 8, k, method, error)
      call heights(w, g, method, z, error)
      call check(maxval(abs(real(z - exact, dp))) < 1e-12_dp * rms, trim(merge('direct ', 'product', k == method_direct))// &
        ' is the quadruple sum to 1e-12 of the rms: '//name)
    end do
    do k = 3, 12
      tolerance = 10._dp**(-k)
      do l = method_product, method_nufft
        call choose_method(g%nx, g%ny, size(w%fx, kind=i8), int(w%groups, i8), tolerance, 8, l, method, error)
        call heights(w, g, method, z, error)
        call check(sqrt(sum(real(z - exact, dp)**2) / size(z)) < tolerance * rms, &
          trim(merge('the product', 'the NUFFT  ', l == method_product))//' keeps the tolerance '//to_text(tolerance)//': '//name)
      end do
    end do
  end subroutine compare

  !> Eq. 1 in quadruple precision, term by term.
  subroutine quadruple_sum(w, g, z)
    type(waves_t), intent(in) :: w       !< waves
    type(grid_t), intent(in) :: g        !< grid
    real(qp), intent(out) :: z(:, :)     !< heights (nx, ny) [m]
    real(qp), parameter :: two_pi = 6.28318530717958647692528676655900576839433879875021_qp
    real(qp) :: row(size(w%fx)), fx(size(w%fx)), fy(size(w%fx))
    integer :: i, j
    fx = real(w%fx, qp) + w%fx_2
    fy = real(w%fy, qp) + w%fy_2
    do j = 1, size(z, 2)
      row = fy * (real(g%y_0, qp) + (j - 1) * real(g%dy, qp)) + w%phase
      do i = 1, size(z, 1)
        z(i, j) = w%offset - sum(w%amplitude * cos(two_pi * (fx * (real(g%x_0, qp) + (i - 1) * real(g%dx, qp)) + row)))
      end do
    end do
  end subroutine quadruple_sum
end module test_heights
