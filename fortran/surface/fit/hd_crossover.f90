! SPDX-License-Identifier: GPL-3.0-or-later
!> Two power laws that meet: E p = A f^-n1 (1 + (f / f_c)^2)^((n1 - n2) / 2) and what folds back of the second, over all rings.
!> A single law with probe, noise and finer detail bends too. Such a map wants two slopes as close, or a place as near to an end of
!> the band, as the search allows: two laws are `inside` where the likelihood has its top within those bounds.
module hd_crossover
  use hd_kinds, only: dp
  use hd_ring_table, only: ring_table_t
  use hd_spectral_model, only: spectral_model_t, slope_t, at_slope, mixed
  implicit none
  private
  public :: crossover_t, find_crossover

  real(dp), parameter :: apart = 0.8_dp         !< least difference of the slopes: 0.4 of D
  real(dp), parameter :: span = 2               !< least factor of frequency that either law holds over
  real(dp), parameter :: clear = 0.1_dp         !< of that difference from its bound
  real(dp), parameter :: off = 1.03_dp          !< of the place from its bounds

  !> What was found.
  type :: crossover_t
    real(dp) :: n(2) = 0                        !< slopes below and above
    real(dp) :: f = 0                           !< where they meet [1/m]
    real(dp) :: alpha = 0                       !< share of detail finer than the spacing
    logical :: inside = .false.                 !< within the bounds of the search
    real(dp) :: deviance = huge(0._dp)          !< twice the ln likelihood below that of the data themselves
  end type crossover_t

contains

  !> The most likely two laws: slopes, place and share on grids that close in, the amplitude solved for.
  function find_crossover(t, m, first, last) result(best)
    type(ring_table_t), intent(in) :: t         !< rings
    type(spectral_model_t), intent(in) :: m     !< its tables
    integer, intent(in) :: first, last          !< rings to look at
    type(crossover_t) :: best, around
    type(slope_t) :: s(11)
    integer :: pass, i
    real(dp) :: low, high, wide
    do i = 1, size(s)
      s(i) = at_slope(m, m%n_low + (i - 1) * (m%n_high - m%n_low) / (size(s) - 1))
    end do
    low = log(span * t%f(first))
    high = log(t%f(last) / span)
    if (high <= low) return
    call search(s, low, high, 13)
    do pass = 1, 3
      around = best
      wide = (m%n_high - m%n_low) / 10 / 2**pass
      s(:5) = [(at_slope(m, min(max(around%n(1) + (i - 3) * wide, m%n_low), m%n_high)), i=1, 5)]
      s(6:10) = [(at_slope(m, min(max(around%n(2) + (i - 3) * wide, m%n_low), m%n_high)), i=1, 5)]
      wide = (high - low) / 6 / 2**pass
      call search(s(:10), max(low, log(around%f) - wide), min(high, log(around%f) + wide), 7)
    end do
    best%inside = abs(best%n(1) - best%n(2)) > apart + clear .and. log(best%f) > low + log(off) .and. log(best%f) < high - log(off)
  contains
    !> Best of a grid.
    subroutine search(s, low, high, places)
      type(slope_t), intent(in) :: s(:)         !< slopes to pair
      real(dp), intent(in) :: low, high         !< ln of the place
      integer, intent(in) :: places             !< points between
      real(dp), dimension(last - first + 1) :: e, ratio, w
      real(dp) :: fold(last - first + 1, 2)
      type(crossover_t) :: x
      integer :: i, j, k, l
      w = t%m(first:last) / t%kappa
      do k = 1, places
        x%f = exp(low + (k - 1) * (high - low) / (places - 1))
        do j = 1, size(s)
          do i = 1, size(s)
            if (abs(s(i)%n - s(j)%n) < apart) cycle
            x%n = [s(i)%n, s(j)%n]
            ratio = s(i)%main(first:last) * (1 + (t%f(first:last) / x%f)**2)**(0.5_dp * (x%n(1) - x%n(2)))
            fold = exp(s(j)%folded(first:last, 1, :)) * x%f**(x%n(2) - x%n(1))
            do l = 0, 2
              x%alpha = 0.5_dp * l
              e = mixed(ratio, fold, x%alpha)
              e = e * (sum(w * t%p(first:last) / e) / sum(w))
              x%deviance = 2 * sum(w * (t%p(first:last) / e - 1 - log(t%p(first:last) / e)))
              if (x%deviance < best%deviance) best = x
            end do
          end do
        end do
      end do
    end subroutine search
  end function find_crossover
end module hd_crossover
