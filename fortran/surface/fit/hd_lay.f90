! SPDX-License-Identifier: GPL-3.0-or-later
!> A lay along an axis: grooves of machining, beside offsets of single rows or columns (jitter of an instrument). Offsets are white
!> from one row to the next and constant along it. A lay has waves across it that depend on their length, or grooves that end, vary
!> or run at an angle.
module hd_lay
  use hd_kinds, only: dp, pi
  use hd_ring_table, only: ring_table_t, taper, falls
  use hd_seams, only: seams_t
  implicit none
  private
  public :: is_lay

  integer, parameter :: fewest = 8            !< modes that a colour is told by
  integer, parameter :: low_modes = 4         !< that the taper's main lobe reaches
  real(dp), parameter :: step = 0.25_dp       !< of the exponent, 0 to 5, and of ln of the amplitude
  real(dp), parameter :: doubt = 10.83_dp     !< of chi^2, one degree of freedom: once in a thousand
  integer, parameter :: sure = 5              !< standard errors of it, beyond doubt
  real(dp), parameter :: ample = 0.5_dp       !< excess of the modes beside an axis that is more than an anisotropy of offsets

contains

  !> Whether the means of columns (way = 1) or rows (way = 2) are a lay.
  function is_lay(z, way, seams, raw, bare) result(lay)
    real(dp), intent(in) :: z(:, :)           !< heights with the offsets (nx, ny) [m]
    integer, intent(in) :: way                !< 1: columns; 2: rows
    type(seams_t), intent(in) :: seams        !< of this map
    type(ring_table_t), intent(in) :: raw     !< its rings
    type(ring_table_t), intent(in) :: bare    !< those of the map without the offsets
    logical :: lay
    lay = bare%beside(way) > 1 + max(ample, sure * bare%beside_error(way))
    if (.not. lay .and. way == 1) lay = colour(sum(z, 2) / size(z, 2), seams%x, size(z, 2), way, raw) > doubt
    if (.not. lay .and. way == 2) lay = colour(sum(z, 1) / size(z, 1), seams%y, size(z, 1), way, raw) > doubt
  end function is_lay

  !> Deviance by which a power law beside the isotropic surface explains the power of means better than white noise does.
  real(dp) function colour(mean, at, n, way, t)
    real(dp), intent(in) :: mean(:)           !< means of columns or rows [m]
    integer, intent(in) :: at(:)              !< last points before the seams
    integer, intent(in) :: n                  !< points of a mean
    integer, intent(in) :: way                !< 1: columns; 2: rows
    type(ring_table_t), intent(in) :: t       !< rings of the map
    real(dp), allocatable :: p(:), base(:), f(:), w(:), m(:)
    integer, allocatable :: ends(:)
    real(dp) :: at_f, kappa, flat, best
    integer :: i, k, a, count_of
    m = mean
    ends = [0, at, size(mean)]
    do a = 1, size(ends) - 1                  ! what stitching added is no lay
      associate (part => m(ends(a) + 1:ends(a + 1)))
        if (size(part) > 0) part = part - sum(part) / size(part)
      end associate
    end do
    w = taper(size(m))
    kappa = size(m) * sum(w**4) / sum(w**2)**2
    count_of = (size(m) - 1) / 2
    allocate (p(count_of), base(count_of), f(count_of))
    k = 0
    do i = 1 + low_modes, count_of
      at_f = i / t%side(way)
      if (at_f < t%f(1) .or. at_f > t%f(size(t%f))) cycle
      k = k + 1
      f(k) = at_f
      p(k) = (sum(w * m * cos(2 * pi * i / size(m) * [(a, a=1, size(m))]))**2 + &
        sum(w * m * sin(2 * pi * i / size(m) * [(a, a=1, size(m))]))**2) * n * t%step(1) * t%step(2) / sum(w**2)
      base(k) = max(t%p(minloc(abs(log(t%f / at_f)), 1)), t%p(1) * (t%f(1) / at_f)**falls)
    end do
    colour = 0
    if (k < fewest) return
    flat = excess(0._dp)
    best = flat
    do i = 1, 20
      best = min(best, excess(step * i))
    end do
    colour = (flat - best) / kappa
  contains
    !> Least deviance of a power law of one exponent over its amplitude.
    real(dp) function excess(slope)
      real(dp), intent(in) :: slope             !< power falls as f^-slope
      real(dp) :: e(k), more(k)
      integer :: j
      more = (f(:k) / f(1))**(-slope)
      more = more * sum(p(:k)) / sum(more)
      excess = huge(slope)
      do j = -40, 8
        e = base(:k) + exp(step * j) * more
        excess = min(excess, 2 * sum(log(e) + p(:k) / e))
      end do
    end function excess
  end function colour
end module hd_lay
