! SPDX-License-Identifier: GPL-3.0-or-later
!> Expected power of rings against sums over their modes.
module test_spectral_model
  use hd_kinds, only: dp, pi
  use hd_check, only: check
  use hd_error, only: error_t
  use hd_ring_table, only: ring_table_t, new_ring_table, taper, edges
  use hd_spectral_model, only: spectral_model_t, slope_t, new_spectral_model, at_slope, power_of
  implicit none
  private
  public :: run_spectral_model

  integer, parameter :: n = 512
  real(dp), parameter :: slope = 3                !< of the law

contains

  !> Each claim with its figure.
  subroutine run_spectral_model()
    call check_rings(1._dp, 0.5_dp)
    call check_rings(2._dp, 0.3_dp)
    call check_taper()
  end subroutine run_spectral_model

  !> A probe takes from each ring what it takes from the ring's modes, within 1 %. What folds back into a ring is the mean over its
  !> modes of all that the grid does not tell from them, of detail down to half and to a fifth of the spacing, within 1 %.
  subroutine check_rings(probe, highest)
    real(dp), intent(in) :: probe     !< [spacing]
    real(dp), intent(in) :: highest   !< frequency that is looked at [1/spacing]
    type(ring_table_t) :: t
    type(spectral_model_t) :: m
    type(slope_t) :: s
    real(dp), allocatable :: blurred(:), sharp(:), folded(:, :), rest(:, :), sums(:, :), edge(:)
    integer :: kx, ky, r
    real(dp) :: f
    call rings_of(n, t, m, s)
    allocate (blurred(size(t%f)), sharp(size(t%f)), folded(size(t%f), 2), rest(size(t%f), 2))
    call power_of(m, s, probe, 1, size(t%f), blurred, rest)
    call power_of(m, s, 0._dp, 1, size(t%f), sharp, folded)
    edge = edges(t)
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
    associate (asked => t%f > 0.1_dp .and. t%f < highest)
      call check(all(abs(blurred / sharp * sums(1, :) / sums(2, :) - 1) < 0.01_dp .or. .not. asked), &
        'a probe takes from a ring what it takes from its modes')
      call check(all(abs(folded(:, 1) / sharp * sums(1, :) / sums(3, :) - 1) < 0.01_dp .or. .not. asked), &
        'what folds back of detail down to half the spacing is the mean over modes')
      call check(all(abs(folded(:, 2) / sharp * sums(1, :) / sums(4, :) - 1) < 0.01_dp .or. .not. asked), &
        'what folds back of detail down to a fifth of the spacing is the mean over modes')
    end associate
  end subroutine check_rings

  !> The taper lifts the steep spectrum of a blunt probe: the model has what the sum over all waves of the map has, within 0.3 %,
  !> up to where long waves leak through it.
  subroutine check_taper()
    integer, parameter :: k = 128
    real(dp), parameter :: blunt = 2
    type(ring_table_t) :: t
    type(spectral_model_t) :: m
    type(slope_t) :: s
    real(dp) :: w(k), power(0:k - 1), law(0:k - 1, 0:k - 1), seen(0:k - 1, 0:k - 1), f
    real(dp), allocatable :: model(:), rest(:, :), sums(:), count_of(:), edge(:)
    integer :: i, j, r, at(2)
    call rings_of(k, t, m, s)
    allocate (model(size(t%f)), rest(size(t%f), 2), sums(size(t%f)), count_of(size(t%f)))
    call power_of(m, s, blunt, 1, size(t%f), model, rest)
    w = taper(k)
    do i = 0, k - 1
      power(i) = sum(w * cos(2 * pi * i / k * [(j, j=1, k)]))**2 + sum(w * sin(2 * pi * i / k * [(j, j=1, k)]))**2
    end do
    power = power / sum(power)
    law = 0
    do j = 0, k - 1
      do i = 0, k - 1
        at = [i, j] - merge(k, 0, [i, j] > k / 2)
        f = norm2(real(at, dp)) / k
        if (f > 0) law(i, j) = f**(-slope) * exp(-(2 * pi * blunt * f)**2)
      end do
    end do
    do i = 0, k - 1
      seen(i, :) = matmul(cshift(power(k - 1:0:-1), k - 1 - i), law)
    end do
    law = seen
    do j = 0, k - 1
      seen(:, j) = matmul(law, cshift(power(k - 1:0:-1), k - 1 - j))
    end do
    edge = edges(t)
    sums = 0
    count_of = 0
    do j = 0, k - 1
      do i = 0, k / 2
        at = [i, j] - merge(k, 0, [i, j] > k / 2)
        f = norm2(real(at, dp)) / k
        if (any(abs(at) < 2)) cycle
        r = count(edge <= f)
        if (r < 1 .or. r > size(t%f)) cycle
        sums(r) = sums(r) + seen(i, j)
        count_of(r) = count_of(r) + 1
      end do
    end do
    call check(all(abs(model / sums * count_of - 1) < 0.003_dp .or. t%f < 0.1_dp .or. t%f > 0.18_dp), &
      'the taper lifts a steep spectrum')
  end subroutine check_taper

  !> Rings of a map of k x k points with spacing 1, tables, and those at the slope.
  subroutine rings_of(k, t, m, s)
    integer, intent(in) :: k
    type(ring_table_t), intent(out) :: t
    type(spectral_model_t), intent(out) :: m
    type(slope_t), intent(out) :: s
    type(error_t), allocatable :: error
    integer :: i
    call new_ring_table(reshape([(sin(real(i, dp)**2), i=1, k * k)], [k, k]), 1._dp, 1._dp, t, error)
    call check(.not. allocated(error), 'a map has rings')
    m = new_spectral_model(t)
    s = at_slope(m, slope)
  end subroutine rings_of

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
