! SPDX-License-Identifier: GPL-3.0-or-later
!> Expected power of rings: a power law f^-n of waves beyond the map and finer than the spacing, seen through a Gaussian probe,
!> a taper and a grid. What is finer than the spacing folds back, as far as alpha says: an instrument may have averaged it away.
!>
!> E p = A [ (f^-n B(f)) * kernel + sum_(k /= 0) h_k |f + k / step|^-n B(|f + k / step|) ] + v, B(f) = exp(-(2 pi sigma f)^2);
!> h_k rises with alpha: 0 at 0; 1 at 0.5 for detail down to half the spacing, at 1 for all down to a fifth (a line: a seventeenth):
!> the expectation of the periodogram itself, not the spectrum (Sykulski et al. 2019, Biometrika 106; Guillaumin et al. 2022,
!> J. R. Stat. Soc. B 84).
module hd_spectral_model
  use hd_gauss, only: gauss_3, weight_3
  use hd_kinds, only: dp, pi
  use hd_ring_table, only: ring_table_t, reach, per_bin, far
  implicit none
  private
  public :: spectral_model_t, slope_t, new_spectral_model, at_slope, power_of, mixed, shares

  !> distance of slopes from those of D = 3 and D = 2, where power and G lose their meaning
  real(dp), parameter :: from_ends = 0.004_dp
  integer, parameter :: nodes = 41            !< over n
  integer, parameter :: blurs = 13            !< over sigma^2
  integer, parameter :: steeps = 64           !< over the square of the slope of ln power
  real(dp), parameter :: steepest = 6         !< the last of them [1/mode^2]
  real(dp), parameter :: most_blur = 1        !< sigma of the last of them [spacing]: nothing folds back from there on

  !> Tables over the slope n. They depend on the grid of a map alone, which the key names: the next map of it takes them over.
  type :: spectral_model_t
    real(dp) :: key(5) = 0                    !< dimension, spacing, sides
    real(dp) :: n_low = 0, n_high = 0         !< slopes of D = 3 and D = 2, nearly
    real(dp) :: spacing = 0                   !< geometric mean of both [m]
    real(dp), allocatable :: f(:)             !< frequencies [1/m]
    real(dp), allocatable :: wide(:)          !< half the mean square of ln f about a ring's
    real(dp) :: square = 0                    !< what the taper adds of a second derivative [1/m^2]
    real(dp) :: mode2 = 0                     !< area of a mode of the frequency plane (line: square of its length) [1/m^2]
    real(dp) :: lift(0:steeps) = 0            !< ln of what the taper makes of an exponential decay, over the square of its slope
    integer :: dim = 2                        !< 1: a single row
    real(dp), allocatable :: main(:, :)       !< ln of f^-n under the taper (rings, nodes)
    real(dp), allocatable :: folded(:, :, :, :) !< ln of what folds back (rings, blurs, nearer and all detail, nodes)
  end type spectral_model_t

  !> The tables at one slope.
  type :: slope_t
    real(dp) :: n = 0                         !< slope
    real(dp), allocatable :: main(:)          !< (rings)
    real(dp), allocatable :: folded(:, :, :)  !< ln (rings, blurs, nearer and all detail)
  end type slope_t

  type(spectral_model_t), save :: latest      !< tables of the latest grid

contains

  !> Tables for the rings of a map.
  function new_spectral_model(t) result(m)
    type(ring_table_t), intent(in) :: t       !< rings
    type(spectral_model_t) :: m
    !$omp critical (spectral_model)
    if (any(abs(latest%key - [real(t%dim, dp), t%step, t%side]) > 0)) latest = tables(t)
    m = latest
    !$omp end critical (spectral_model)
  end function new_spectral_model

  !> The tables anew.
  function tables(t) result(m)
    type(ring_table_t), intent(in) :: t       !< rings
    type(spectral_model_t) :: m
    real(dp) :: slopes(nodes)
    integer :: i
    m%key = [real(t%dim, dp), t%step, t%side]
    m%n_low = t%dim + from_ends                 ! n = 8 - 2D (line: 7 - 2D)
    m%n_high = t%dim + (2 - from_ends)
    m%spacing = t%step(1)
    if (t%dim == 2) m%spacing = sqrt(product(t%step))
    m%f = t%f
    m%dim = t%dim
    m%wide = 0.5_dp * t%width2
    do i = -reach * per_bin, reach * per_bin
      m%square = m%square + (real(i, dp) / per_bin)**2 * merge(0.25_dp * sum(t%kernel(i, :) / t%side**2), &
        0.5_dp * t%kernel(i, 1) / t%side(1)**2, t%dim == 2)
    end do
    m%mode2 = 1 / merge(product(t%side), t%side(1)**2, t%dim == 2)
    m%lift = [(log(lifted(t, sqrt(i * steepest / steeps))), i=0, steeps)]
    slopes = m%n_low + [(i, i=0, nodes - 1)] * (m%n_high - m%n_low) / (nodes - 1)
    allocate (m%folded(size(t%f), blurs, 2, nodes))
    m%main = main_of(t, m, slopes)
    !$omp parallel do schedule(dynamic)
    do i = 1, size(t%f)
      m%folded(i, :, :, :) = log(folded_of(t, i, slopes, m%spacing))
    end do
  end function tables

  !> Mean of an exponential decay under the kernel of the taper within its reach, over that at its middle: mean of two directions.
  pure real(dp) function lifted(t, slope)
    type(ring_table_t), intent(in) :: t       !< taper
    real(dp), intent(in) :: slope             !< of ln power, of a mode of the mean side [1/mode]
    real(dp) :: a(2), m(2)
    integer :: i, j
    lifted = 0
    do i = 1, 2
      a = slope * [cos((2 * i - 1) * pi / 8), sin((2 * i - 1) * pi / 8)] * sqrt(product(t%side)) / t%side
      if (t%dim == 1) a = [slope, 0._dp]
      m = t%whole(0, :)
      do j = 1, far
        m = m + 2 * t%whole(j, :) * cosh(j * a)
      end do
      lifted = lifted + 0.5_dp * m(1) * merge(m(2), 1._dp, t%dim == 2)
    end do
  end function lifted

  !> ln of f^-n as the taper sees it: its power summed over the kernel for single low modes, to second order elsewhere.
  function main_of(t, m, slopes) result(v)
    type(ring_table_t), intent(in) :: t       !< rings
    type(spectral_model_t), intent(in) :: m   !< widths
    real(dp), intent(in) :: slopes(:)         !< n, evenly spaced
    real(dp) :: v(size(t%f), size(slopes)), part(size(slopes), size(t%f)), power(size(slopes), size(t%ring))
    integer :: i, modes
    do i = 1, size(slopes)
      associate (n => slopes(i))
        v(:, i) = -n * log(t%f) + log(1 + m%square * merge(n**2, n * (n + 1), t%dim == 2) / t%f**2) + m%wide * n**2
      end associate
    end do
    !$omp parallel do
    do i = 1, size(t%ring)
      power(:, i) = low_power(t, i, slopes)
    end do
    part = 0
    do i = 1, size(t%ring)
      part(:, t%ring(i)) = part(:, t%ring(i)) + power(:, i)
    end do
    do i = 1, size(t%f)
      modes = count(t%ring == i)  ! not t%m, which of two maps is that of their sum: the tables are of the grid alone
      if (modes > 0) v(i, :) = log(part(:, i) / modes)
    end do
  end function main_of

  !> f^-n about a low mode, summed over the kernel of the taper.
  pure function low_power(t, mode, slopes) result(total)
    type(ring_table_t), intent(in) :: t       !< modes
    integer, intent(in) :: mode               !< which
    real(dp), intent(in) :: slopes(:)         !< n, evenly spaced
    real(dp) :: total(size(slopes)), power, next, fx, fy, ln_f2
    integer :: i, kx, ky, across
    across = merge(reach * per_bin, 0, t%dim == 2)
    total = 0
    do kx = -reach * per_bin, reach * per_bin
      fx = (t%kx(mode) + real(kx, dp) / per_bin) / t%side(1)
      do ky = -across, across
        power = t%kernel(kx, 1)
        fy = 0
        if (t%dim == 2) then
          power = power * t%kernel(ky, 2)
          fy = (t%ky(mode) + real(ky, dp) / per_bin) / t%side(2)
        end if
        ln_f2 = log(max(fx**2 + fy**2, t%df**2))
        power = power * exp(-0.5_dp * slopes(1) * ln_f2)
        next = exp(-0.5_dp * (slopes(2) - slopes(1)) * ln_f2)
        do i = 1, size(slopes)
          total(i) = total(i) + power
          power = power * next
        end do
      end do
    end do
  end function low_power

  !> What folds back into a ring from above the grid: of detail down to half the finer spacing, and down to a fifth (two cells along
  !> it, more along the coarser one; a line: a seventeenth, eight). Near D = 3 detail of any fineness would hold most of the power:
  !> no surface and no instrument has it.
  function folded_of(t, ring, slopes, spacing) result(v)
    type(ring_table_t), intent(in) :: t       !< rings
    integer, intent(in) :: ring               !< which
    real(dp), intent(in) :: slopes(:)         !< n
    real(dp), intent(in) :: spacing           !< unit of the probe [m]
    real(dp) :: v(blurs, 2, size(slopes))
    integer, parameter :: angles = 6, most_cells = 40
    real(dp), parameter :: weight(3) = weight_3 / 2
    real(dp), allocatable :: f2(:), share(:), power(:, :), through(:, :)
    logical, allocatable :: near(:)
    real(dp) :: finer, f, a, low, high, fx, fy
    integer :: cells(2), i, j, k, p, q, n
    finer = merge(t%step(1), minval(t%step), t%dim == 1)
    cells = merge([8, 0], min(nint(2 * t%step / finer), most_cells), t%dim == 1)
    n = 3 * merge(1, angles, t%dim == 1) * (product(2 * cells + 1) - 1)
    allocate (f2(n), share(n), near(n), power(n, size(slopes)), through(n, blurs))
    n = 0
    do i = 1, 3
      f = t%f(ring) * exp(gauss_3(i) * sqrt(3 * t%width2(ring)))
      low = acos(min(1._dp, 0.5_dp / (t%step(1) * f)))       ! directions whose waves the grid holds
      high = asin(min(1._dp, 0.5_dp / (t%step(2) * f)))
      if (t%dim == 1) then
        do p = -cells(1), cells(1)
          if (p /= 0) call add(f + p / t%step(1), 0._dp, weight(i))
        end do
        cycle
      end if
      do k = 1, angles
        a = low + (k - 0.5_dp) * (high - low) / angles
        do q = -cells(2), cells(2)
          do p = -cells(1), cells(1)
            fx = f * cos(a) + p / t%step(1)
            fy = f * sin(a) + q / t%step(2)
            if (p /= 0 .or. q /= 0) call add(fx, fy, weight(i) / angles)
          end do
        end do
      end do
    end do
    do j = 1, size(slopes)
      power(:, j) = share * exp(-0.5_dp * slopes(j) * log(f2))
    end do
    do j = 1, blurs
      through(:, j) = exp(-(2 * pi * (j - 1) * most_blur * spacing / (blurs - 1))**2 * f2)
    end do
    v(:, 2, :) = matmul(transpose(through), power) + tiny(f)
    v(:, 1, :) = matmul(transpose(through * spread(merge(1._dp, 0._dp, near), 2, blurs)), power) + tiny(f)
  contains
    !> One wave finer than the grid.
    subroutine add(fx, fy, weight)
      real(dp), intent(in) :: fx, fy, weight    !< frequency [1/m]
      n = n + 1
      f2(n) = fx**2 + fy**2
      share(n) = weight
      near(n) = max(abs(fx), abs(fy)) * finer <= 1
    end subroutine add
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
    s%folded = m%folded(:, :, :, i + 1) * (1 - x) + m%folded(:, :, :, i + 2) * x
  end function at_slope

  !> What A multiplies: power law through the probe, and what folds back of nearer and of all detail. A probe bends the law within a
  !> ring and within the reach of the taper. There the power falls exponentially, with the slope of its middle over ln f and over f;
  !> what the slope changes counts to first order.
  pure subroutine power_of(m, s, sigma, first, last, straight, folded)
    type(spectral_model_t), intent(in) :: m   !< tables
    type(slope_t), intent(in) :: s            !< at the slope
    real(dp), intent(in) :: sigma             !< probe [m]
    integer, intent(in) :: first, last        !< rings
    real(dp), intent(out) :: straight(:)      !< (last - first + 1)
    real(dp), intent(out) :: folded(:, :)     !< (last - first + 1, 2)
    real(dp) :: x, blur(last - first + 1), steep(last - first + 1), mode(last - first + 1)
    integer :: i
    associate (wide => m%wide(first:last))
      blur = (2 * pi * sigma * m%f(first:last))**2
      steep = (s%n + 2 * blur)**2
      mode = m%mode2 / m%f(first:last)**2
      straight = s%main(first:last) * exp(-blur + lift_of(m, steep * mode) - lift_of(m, s%n**2 * mode)) &
        * evened(wide * steep) / evened(wide * s%n**2) &
        * (1 - 4 * blur * wide) * (1 - merge(4, 2, m%dim == 2) * blur * m%square / m%f(first:last)**2)
    end associate
    x = sigma / (most_blur * m%spacing) * (blurs - 1)
    i = min(int(x), blurs - 2)
    if (x >= blurs - 1) then
      folded = 0
    else
      x = (x**2 - i**2) / (2 * i + 1)                   ! between nodes linear in sigma^2
      folded = exp(s%folded(first:last, i + 1, :) * (1 - x) + s%folded(first:last, i + 2, :) * x)
    end if
  end subroutine power_of

  !> ln of what the taper makes of an exponential decay, between nodes.
  elemental real(dp) function lift_of(m, steep)
    type(spectral_model_t), intent(in) :: m   !< table
    real(dp), intent(in) :: steep             !< square of the slope of ln power [1/mode^2]
    real(dp) :: x
    integer :: i
    x = steep / steepest * steeps
    i = min(int(min(x, real(steeps, dp))), steeps - 1)
    lift_of = m%lift(i) + min(x - i, 1._dp) * (m%lift(i + 1) - m%lift(i))
  end function lift_of

  !> Mean of exp(x y) over y from -1 to 1, sinh x / x, of x^2 / 6.
  elemental real(dp) function evened(z)
    real(dp), intent(in) :: z   !< x^2 / 6
    evened = 1 + z * (1 + 0.3_dp * z * (1 + z / 7 * (1 + z / 12)))
  end function evened

  !> Power law and what folds back of it.
  pure function mixed(straight, folded, alpha) result(p)
    real(dp), intent(in) :: straight(:), folded(:, :)   !< of power_of
    real(dp), intent(in) :: alpha                       !< detail finer than the spacing
    real(dp) :: p(size(straight)), h(2)
    h = shares(alpha)
    p = straight + h(1) * folded(:, 1) + h(2) * folded(:, 2)
  end function mixed

  !> Shares of the nearer detail and of all that fold back.
  pure function shares(alpha) result(h)
    real(dp), intent(in) :: alpha   !< 0: none, 0.5: down to half the spacing, 1: all
    real(dp) :: h(2)
    h(2) = max(0._dp, 2 * alpha - 1)
    h(1) = min(1._dp, 2 * alpha) - h(2)
  end function shares
end module hd_spectral_model
