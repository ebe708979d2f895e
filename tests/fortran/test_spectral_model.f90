! SPDX-License-Identifier: GPL-3.0-or-later
!> Expected power of rings against sums over their modes.
module test_spectral_model
  use hd_kinds, only: dp, pi
  use hd_check, only: check
  use hd_error, only: error_t
  use hd_ring_table, only: ring_table_t, new_ring_table
  use hd_spectral_model, only: spectral_model_t, slope_t, new_spectral_model, at_slope, power_of
  implicit none
  private
  public :: run_spectral_model

  integer, parameter :: n = 512
  real(dp), parameter :: slope = 3, probe = 1     !< of the law; [spacing]

contains

  !> A probe of one spacing takes from each ring what it takes from the ring's modes, within 2 %. What folds back into a ring is
  !> the mean over its modes of all that the grid does not tell from them, of detail down to half and to a fifth of the spacing,
  !> within 1 %.
  subroutine run_spectral_model()
    type(ring_table_t) :: t
    type(spectral_model_t) :: m
    type(slope_t) :: s
    type(error_t), allocatable :: error
    real(dp), allocatable :: blurred(:), sharp(:), folded(:, :), rest(:, :), sums(:, :), edge(:)
    integer :: kx, ky, r, i
    real(dp) :: f
    call new_ring_table(reshape([(sin(real(i, dp)**2), i=1, n * n)], [n, n]), 1._dp, 1._dp, t, error)
    call check(.not. allocated(error), 'a map has rings')
    m = new_spectral_model(t)
    s = at_slope(m, slope)
    allocate (blurred(size(t%f)), sharp(size(t%f)), folded(size(t%f), 2), rest(size(t%f), 2))
    call power_of(m, s, probe, 1, size(t%f), blurred, rest)
    call power_of(m, s, 0._dp, 1, size(t%f), sharp, folded)
    edge = [t%f(1), 0.5_dp * (t%f(2:) + t%f(:size(t%f) - 1)), 0.5_dp * 0.985_dp]
    allocate (sums(4, size(t%f)), source=0._dp)
    do ky = -n / 2, n / 2 - 1
      do kx = 2, n / 2
        if (abs(ky) < 2) cycle
        f = hypot(real(kx, dp), real(ky, dp)) / n
        r = count(edge <= f)
        if (r < 1 .or. r > size(t%f)) cycle
        sums(:, r) = sums(:, r) + [f**(-slope), f**(-slope) * exp(-(2 * pi * probe * f)**2), beyond(kx, ky, 1), beyond(kx, ky, 2)]
      end do
    end do
    associate (high => t%f > 0.1_dp)
      call check(all(abs(blurred / sharp * sums(1, :) / sums(2, :) - 1) < 0.02_dp .or. .not. high), &
        'a probe takes from a ring what it takes from its modes')
      call check(all(abs(folded(:, 1) / sharp * sums(1, :) / sums(3, :) - 1) < 0.01_dp .or. .not. high), &
        'what folds back of detail down to half the spacing is the mean over modes')
      call check(all(abs(folded(:, 2) / sharp * sums(1, :) / sums(4, :) - 1) < 0.01_dp .or. .not. high), &
        'what folds back of detail down to a fifth of the spacing is the mean over modes')
    end associate
  end subroutine run_spectral_model

  !> Power of the waves that the grid does not tell from a mode.
  pure real(dp) function beyond(kx, ky, finest)
    integer, intent(in) :: kx, ky     !< mode
    integer, intent(in) :: finest     !< 1: frequencies up to 1 along x and y; 2: two cells each way
    real(dp) :: f(2)
    integer :: p, q
    beyond = 0
    do q = -2, 2
      do p = -2, 2
        f = [real(kx, dp) / n + p, real(ky, dp) / n + q]
        if ((p == 0 .and. q == 0) .or. (finest == 1 .and. any(abs(f) > 1))) cycle
        beyond = beyond + sum(f**2)**(-0.5_dp * slope)
      end do
    end do
  end function beyond
end module test_spectral_model
