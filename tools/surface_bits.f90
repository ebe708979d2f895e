! SPDX-License-Identifier: GPL-3.0-or-later
!> Waves and heights of five surfaces by the direct sum and by products, as bytes to the file named;
!> tools/prove_bits.sh compares them.
program surface_bits
  use hd_kinds, only: dp, i8
  use hd_error, only: error_t
  use hd_direct, only: direct_sum
  use hd_product, only: product_t, new_product, product_sum
  use hd_waves, only: spectrum_t, waves_t, grid_t, new_waves
  implicit none
  type(waves_t) :: w
  type(error_t), allocatable :: error
  character(len=256) :: path
  integer :: unit
  call get_command_argument(1, path)
  open (newunit=unit, file=trim(path), access='stream', form='unformatted', status='replace', action='write')
  call put(spectrum_t(2.5304_dp, 2.4248e-7_dp, 1.5_dp, 0.5e-3_dp, 1e-6_dp, 10, 1_i8), grid_t(96, 80, 1e-6_dp, 1e-6_dp))
  call put(spectrum_t(2.1_dp, 1e-9_dp, 1.3_dp, 1e-3_dp, 1e-6_dp, 7, 2_i8), grid_t(61, 33, 7e-6_dp, 9e-6_dp, -2e-2_dp, 5e-2_dp))
  call put(spectrum_t(2.9_dp, 3.3e-11_dp, 1.1_dp, 1e-3_dp, 1e-6_dp, 40, 3_i8), grid_t(50, 20, 1e-6_dp, 1e-6_dp))
  call put(spectrum_t(2.37_dp, 1e-8_dp, 2.7_dp, 3e-4_dp, 2e-6_dp, 1001, 4_i8), grid_t(40, 20, 1e-6_dp, 1e-6_dp))
  call put(spectrum_t(2.7_dp, 1e-8_dp, 1.5_dp, 3e-4_dp, 1e-7_dp, 1, 5_i8), grid_t(5000, 1, 1e-7_dp, 1._dp))
contains
  subroutine put(s, g)
    type(spectrum_t), intent(in) :: s   !< surface
    type(grid_t), intent(in) :: g       !< grid
    type(product_t) :: product
    real(dp) :: z(g%nx, g%ny)
    call new_waves(s, w, error)
    if (allocated(error)) error stop 'bad surface'
    call direct_sum(w, g, 1, z)
    write (unit) w%fx, w%fy, w%amplitude, w%phase, w%offset, z
    call new_product(w, g, product)
    call product_sum(product, 1, z)
    write (unit) z
  end subroutine put
end program surface_bits
