! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves by a non-uniform FFT: spread each wave over the fine points around its wave number, transform, divide by the
!> transform of the window. In single precision where the tolerance allows it.
!>
!> Heights are real, so half the plane of wave numbers is enough. Rows are done in tiles, each a transform of its own about its
!> middle row: memory stays small, tiles are independent, and the result does not depend on the number of threads. Of the columns
!> of wave numbers only those a wave has touched are transformed.
module hd_nufft
  use hd_kinds, only: dp, sp
  use hd_error, only: error_t
  use hd_nufft_tiles, only: sum_tiles
  use hd_nufft_tiles_single, only: sum_tiles_single => sum_tiles
  use hd_nufft_waves, only: nufft_t, new_nufft
  implicit none
  private
  public :: nufft_t, new_nufft, nufft_sum

contains

  !> Heights [m], in double or in single precision.
  subroutine nufft_sum(p, error, z, z_single)
    type(nufft_t), intent(in) :: p                                      !< waves on the fine points
    type(error_t), allocatable, intent(out) :: error                    !< FFTW finds no plan
    real(dp), intent(inout), contiguous, optional :: z(:, :)            !< heights (nx, ny) [m]
    real(sp), intent(inout), contiguous, optional :: z_single(:, :)     !< the same
    if (p%precision == 2) then
      call sum_tiles_single(p, p%x%piece_single, p%y%piece_single, error, z, z_single)
    else
      call sum_tiles(p, p%x%piece, p%y%piece, error, z, z_single)
    end if
  end subroutine nufft_sum
end module hd_nufft
