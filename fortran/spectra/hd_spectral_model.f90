! SPDX-License-Identifier: GPL-3.0-or-later
!> Expected power of rings: a power law f^-n of waves beyond the map and finer than the spacing, seen through a Gaussian probe,
!> a taper and a grid. What is finer than the spacing folds back: with a share alpha, for an instrument may have averaged it away.
!>
!> E p = A [ (f^-n * kernel) B(f) + alpha sum_(k /= 0) |f + k / step|^-n B(|f + k / step|) ] + v, B(f) = exp(-(2 pi sigma f)^2):
!> the expectation of the periodogram itself, not the spectrum (Sykulski et al. 2019, Biometrika 106; Guillaumin et al. 2022,
!> J. R. Stat. Soc. B 84).
module hd_spectral_model
  use hd_kinds, only: dp, pi
  use hd_ring_table, only: ring_table_t, reach, per_bin
  implicit none
  private
  public :: spectral_model_t, slope_t, new_spectral_model, at_slope, power_of

  integer, parameter :: nodes = 41            !< over n
  integer, parameter :: blurs = 13            !< over sigma^2
  real(dp), parameter :: most_blur = 1        !< sigma of the last of them [spacing]: nothing folds back from there on

  !> Tables over the slope n.
  type :: spectral_model_t
    real(dp) :: n_low = 0, n_high = 0         !< slopes of D = 3 and D = 2, nearly
    real(dp) :: spacing = 0                   !< geometric mean of both [m]
    real(dp), allocatable :: f(:)             !< frequencies [1/m]
    real(dp), allocatable :: main(:, :)       !< ln of f^-n under the taper (rings, nodes)
    real(dp), allocatable :: folded(:, :, :)  !< ln of what folds back (rings, nodes, blurs)
  end type spectral_model_t

  !> The tables at one slope.
  type :: slope_t
    real(dp) :: n = 0                         !< slope
    real(dp), allocatable :: main(:)          !< (rings)
    real(dp), allocatable :: folded(:, :)     !< ln (rings, blurs)
  end type slope_t

contains

  !> Tables for the rings of a map.
  function new_spectral_model(t) result(m)
    type(ring_table_t), intent(in) :: t       !< rings
    type(spectral_model_t) :: m
    real(dp) :: n
    integer :: i, j
    m%n_low = t%dim + 0.004_dp                ! n = 8 - 2D (line: 7 - 2D), D from 2.002 to 2.998
    m%n_high = t%dim + 1.996_dp
    m%spacing = t%step(1)
    if (t%dim == 2) m%spacing = sqrt(product(t%step))
    m%f = t%f
    allocate (m%main(size(t%f), nodes), m%folded(size(t%f), nodes, blurs))
    !$omp parallel do private(n, j)
    do i = 1, nodes
      n = m%n_low + (i - 1) * (m%n_high - m%n_low) / (nodes - 1)
      m%main(:, i) = main_of(t, n)
      do j = 1, blurs
        m%folded(:, i, j) = log(folded_of(t, n, (j - 1) * most_blur * m%spacing / (blurs - 1)))
      end do
    end do
  end function new_spectral_model

  !> ln of f^-n as the taper sees it: its power summed over the kernel for single low modes, to second order elsewhere.
  pure function main_of(t, n) result(v)
    type(ring_table_t), intent(in) :: t       !< rings
    real(dp), intent(in) :: n                 !< slope
    real(dp) :: v(size(t%f)), part(size(t%f)), square, total, fx, fy
    integer :: i, kx, ky
    square = 0
    do i = -reach * per_bin, reach * per_bin
      if (t%dim == 2) then
        square = square + 0.25_dp * n**2 * (real(i, dp) / per_bin)**2 * sum(t%kernel(i, :) / t%side**2)
      else
        square = square + 0.5_dp * n * (n + 1) * (real(i, dp) / per_bin)**2 * t%kernel(i, 1) / t%side(1)**2
      end if
    end do
    v = -n * log(t%f) + log(1 + square / t%f**2) + 0.5_dp * n**2 * t%width2
    if (size(t%ring) == 0) return
    part = 0
    do i = 1, size(t%ring)
      total = 0
      do kx = -reach * per_bin, reach * per_bin
        fx = ((t%kx(i) + real(kx, dp) / per_bin) / t%side(1))**2
        if (t%dim == 1) then
          total = total + t%kernel(kx, 1) * max(fx, t%df**2)**(-0.5_dp * n)
          cycle
        end if
        do ky = -reach * per_bin, reach * per_bin
          fy = ((t%ky(i) + real(ky, dp) / per_bin) / t%side(2))**2
          total = total + t%kernel(kx, 1) * t%kernel(ky, 2) * max(fx + fy, t%df**2)**(-0.5_dp * n)
        end do
      end do
      part(t%ring(i)) = part(t%ring(i)) + total
    end do
    where (part > 0) v = log(part / t%m)
  end function main_of

  !> What folds back from above the grid: two cells each way (line: eight), that is detail down to a fifth (a seventeenth) of the
  !> spacing. Near D = 3 detail of any fineness would hold most of the power; no surface and no instrument has it.
  pure function folded_of(t, n, sigma) result(v)
    type(ring_table_t), intent(in) :: t       !< rings
    real(dp), intent(in) :: n, sigma          !< slope, probe [m]
    real(dp) :: v(size(t%f)), f2, a, low, high
    integer, parameter :: angles = 6
    integer :: r, p, q, k
    v = tiny(v)
    if (t%dim == 1) then
      do p = -8, 8
        if (p /= 0) v = v + abs(t%f + p / t%step(1))**(-n) * exp(-(2 * pi * sigma * (t%f + p / t%step(1)))**2)
      end do
      return
    end if
    do r = 1, size(t%f)
      low = acos(min(1._dp, 0.5_dp / (t%step(1) * t%f(r))))       ! directions whose waves the grid holds
      high = asin(min(1._dp, 0.5_dp / (t%step(2) * t%f(r))))
      do k = 1, angles
        a = low + (k - 0.5_dp) * (high - low) / angles
        do q = -2, 2
          do p = -2, 2
            if (p == 0 .and. q == 0) cycle
            f2 = (t%f(r) * cos(a) + p / t%step(1))**2 + (t%f(r) * sin(a) + q / t%step(2))**2
            v(r) = v(r) + f2**(-0.5_dp * n) * exp(-(2 * pi * sigma)**2 * f2) / angles
          end do
        end do
      end do
    end do
  end function folded_of

  !> The tables at one slope, between nodes.
  pure function at_slope(m, n) result(s)
    type(spectral_model_t), intent(in) :: m   !< tables
    real(dp), intent(in) :: n                 !< slope
    type(slope_t) :: s
    real(dp) :: x
    integer :: i
    x = (n - m%n_low) / (m%n_high - m%n_low) * (nodes - 1)
    i = min(max(int(x), 0), nodes - 2)
    x = x - i
    s%n = n
    s%main = exp(m%main(:, i + 1) * (1 - x) + m%main(:, i + 2) * x)
    s%folded = m%folded(:, i + 1, :) * (1 - x) + m%folded(:, i + 2, :) * x
  end function at_slope

  !> What A multiplies: power law through the probe, and what folds back.
  pure subroutine power_of(m, s, sigma, first, last, straight, folded)
    type(spectral_model_t), intent(in) :: m   !< tables
    type(slope_t), intent(in) :: s            !< at the slope
    real(dp), intent(in) :: sigma             !< probe [m]
    integer, intent(in) :: first, last        !< rings
    real(dp), intent(out) :: straight(:), folded(:) !< (last - first + 1)
    real(dp) :: x
    integer :: i
    straight = s%main(first:last) * exp(-(2 * pi * sigma * m%f(first:last))**2)
    x = sigma / (most_blur * m%spacing) * (blurs - 1)
    i = min(int(x), blurs - 2)
    if (x >= blurs - 1) then
      folded = 0
    else
      x = (x**2 - i**2) / (2 * i + 1)                   ! between nodes linear in sigma^2
      folded = exp(s%folded(first:last, i + 1) * (1 - x) + s%folded(first:last, i + 2) * x)
    end if
  end subroutine power_of
end module hd_spectral_model
