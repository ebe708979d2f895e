! SPDX-License-Identifier: GPL-3.0-or-later
!> Power of a map over rings of frequency, as a likelihood takes it: periodogram under a taper, modes of equal frequency together.
!> Modes on both axes of the frequency plane are left out: there lies what leaks from long waves, and what offsets of single rows
!> (jitter of an instrument) and straight steps (stitching) add. A single row has no second axis and loses nothing.
module hd_ring_table
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t
  use hd_fft, only: forward_real_2d, forward_real
  use hd_sorted, only: count_up_to
  implicit none
  private
  public :: ring_table_t, new_ring_table, taper, edges, reach, per_bin, far, falls

  real(dp), parameter :: lowest = 3.5_dp      !< waves per side where rings begin: the taper blurs longer ones into each other
  real(dp), parameter :: highest = 0.985_dp   !< of Nyquist's frequency, where a mode is its own mirror image: rings end below
  real(dp), parameter :: narrowest = 1.5_dp, narrowest_of_line = 4   !< width of a ring [modes]: enough of them to take a mean
  integer, parameter :: fewest = 4            !< modes of a ring
  integer, parameter :: low_modes = 4         !< along an axis that the taper's main lobe reaches
  integer, parameter :: well_above = 10       !< times what the taper leaks of the longest waves, that is power of the surface
  integer, parameter :: falls = 6             !< power of 1/f that what the taper leaks falls with
  integer, parameter :: steep = 4             !< number of a mode along an axis over that beside it, at least, beside the axis
  integer, parameter :: axis_width = 2        !< modes below this number along x or y are left out
  integer, parameter :: reach = 3             !< of the taper's kernel [modes]
  integer, parameter :: per_bin = 4           !< its points per mode
  integer, parameter :: far = 6               !< modes that a steep spectrum is seen over
  real(dp), parameter :: growth = 1.06_dp     !< of the rings
  real(dp), parameter :: low_end = 14         !< below this number of waves per side modes are kept one by one
  integer, parameter :: sectors = 8           !< of half a turn: in one the power of a stretched surface hardly changes

  !> Rings of a map or of a line.
  type :: ring_table_t
    integer :: dim = 2                        !< 1: a single row
    real(dp) :: step(2) = 0, side(2) = 0      !< spacing, and number of points times spacing [m]
    real(dp) :: nyquist = 0                   !< highest frequency of all directions [1/m]
    real(dp) :: df = 0                        !< one wave along the shorter side [1/m]
    real(dp) :: kappa = 1                     !< modes per independent mode under the taper
    real(dp), allocatable :: f(:)             !< frequency, geometric mean of the modes [1/m]
    real(dp), allocatable :: p(:)             !< mean power per area (line: length) of the frequency plane [m^4] ([m^3])
    real(dp), allocatable :: m(:)             !< number of modes
    real(dp), allocatable :: width2(:)        !< mean square of ln f about the ring's
    real(dp), allocatable :: scatter(:)       !< mean square of the modes' power over square of its mean; 2 of a Gaussian field
    real(dp), allocatable :: aside(:)         !< the same among modes of nearly one direction: 2 of a stretched one too
    real(dp) :: axis(2) = 1                   !< power of waves along x and y alone, over that of their rings or of the taper's leak
    real(dp) :: leak(2) = 1                   !< the same over that of their rings alone
    real(dp) :: beside(2) = 1                 !< power of the modes next to those, over that of their rings
    real(dp) :: beside_error(2) = 0           !< its standard error
    integer, allocatable :: kx(:), ky(:), ring(:) !< modes of low frequency and their rings
    real(dp), allocatable :: kernel(:, :)     !< power of the taper at 1/per_bin modes about 0, along x and y; sums are 1
    real(dp) :: whole(0:far, 2) = 0           !< the same at whole modes, from 0 on, along x and y; sums over all modes are 1
  end type ring_table_t

contains

  !> Cosine taper over half of the points (Tukey).
  pure function taper(n) result(w)
    integer, intent(in) :: n    !< points
    real(dp) :: w(n)
    integer :: i
    w = [(min(i - 0.5_dp, n - i + 0.5_dp) / n, i=1, n)]
    w = 0.5_dp - 0.5_dp * cos(4 * pi * min(w, 0.25_dp))
  end function taper

  !> Rings of a levelled map without holes.
  subroutine new_ring_table(z, dx, dy, t, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                    !< spacing [m]
    type(ring_table_t), intent(out) :: t              !< rings
    type(error_t), allocatable, intent(out) :: error  !< no memory
    real(dp), allocatable :: flat(:, :), edge(:), power(:, :), wx(:), wy(:)
    complex(dp), allocatable :: s(:, :)
    integer :: nx, ny
    nx = size(z, 1)
    ny = size(z, 2)
    t%dim = merge(1, 2, ny == 1)
    t%step = [dx, dy]
    t%side = [nx * dx, ny * dy]
    t%nyquist = 0.5_dp / dx
    t%df = 1 / t%side(1)
    wx = taper(nx)
    wy = [1._dp]
    if (t%dim == 2) then
      wy = taper(ny)
      t%nyquist = max(t%nyquist, 0.5_dp / dy)
      t%df = 1 / minval(t%side)
    end if
    allocate (t%kernel(-reach * per_bin:reach * per_bin, 2), source=1._dp)
    t%kernel(:, 1) = kernel_of(wx)
    t%whole(:, 1) = whole_of(wx)
    if (t%dim == 2) t%kernel(:, 2) = kernel_of(wy)
    if (t%dim == 2) t%whole(:, 2) = whole_of(wy)
    t%kappa = nx * sum(wx**4) / sum(wx**2)**2 * ny * sum(wy**4) / sum(wy**2)**2
    flat = z * spread(wx, 2, ny) * spread(wy, 1, nx)
    allocate (s(nx / 2 + 1, ny))
    if (t%dim == 2) then
      call forward_real_2d(flat, s, error)
    else
      call forward_real(flat, s, error)
    end if
    if (allocated(error)) return
    power = (real(s)**2 + aimag(s)**2) * (dx * merge(dy, 1._dp, t%dim == 2) / (sum(wx**2) * sum(wy**2)))
    edge = edges(t)
    call collect(t, power, edge)
  end subroutine new_ring_table

  !> Power of a taper's transform about frequency 0.
  pure function kernel_of(w) result(k)
    real(dp), intent(in) :: w(:)      !< taper
    real(dp) :: k(2 * reach * per_bin + 1), turn
    integer :: i, j
    do i = 1, size(k)
      turn = 2 * pi * (i - 1 - reach * per_bin) / (real(per_bin, dp) * size(w))
      k(i) = sum(w * cos(turn * [(j, j=1, size(w))]))**2 + sum(w * sin(turn * [(j, j=1, size(w))]))**2
    end do
    k = k / sum(k)
  end function kernel_of

  !> Power of a taper's transform at whole modes.
  pure function whole_of(w) result(k)
    real(dp), intent(in) :: w(:)      !< taper
    real(dp) :: k(0:far), turn
    integer :: i, j
    do i = 0, far
      turn = 2 * pi * i / size(w)
      k(i) = sum(w * cos(turn * [(j, j=1, size(w))]))**2 + sum(w * sin(turn * [(j, j=1, size(w))]))**2
    end do
    k = k / (size(w) * sum(w**2))
  end function whole_of

  !> Edges of the rings [1/m]: from three and a half waves, at least one and a half modes wide (line: four), growing by 6 %.
  pure function edges(t) result(e)
    type(ring_table_t), intent(in) :: t   !< sizes
    real(dp), allocatable :: e(:)
    real(dp) :: at
    e = [lowest * t%df]
    at = e(1)
    do while (at < highest * t%nyquist)
      at = min(max(at * growth, at + merge(narrowest_of_line, narrowest, t%dim == 1) * t%df), highest * t%nyquist)
      e = [e, at]
    end do
  end function edges

  !> Sum modes into rings; those of less than four modes are dropped.
  subroutine collect(t, power, edge)
    type(ring_table_t), intent(inout) :: t    !< rings
    real(dp), intent(in) :: power(:, :)       !< of the half plane (nx/2 + 1, ny)
    real(dp), intent(in) :: edge(:)           !< of the rings [1/m]
    real(dp), dimension(size(edge) - 1) :: m, p, p2, l, l2
    real(dp) :: apart(sectors, size(edge) - 1, 0:2)  ! sums of the modes' power to the powers 0, 1, 2
    integer :: place(size(edge) - 1), i, j, k, kx, ky, r, pass, low
    real(dp) :: f
    m = 0; p = 0; p2 = 0; l = 0; l2 = 0
    apart = 0
    do pass = 1, 2
      low = 0
      do j = 1, size(power, 2)
        ky = merge(j - 1, j - 1 - size(power, 2), j - 1 <= size(power, 2) / 2)
        do i = 1, size(power, 1)
          kx = i - 1
          if (kx < axis_width .or. (t%dim == 2 .and. abs(ky) < axis_width)) cycle
          if (2 * kx == nint(t%side(1) / t%step(1)) .and. ky < 0) cycle       ! the mirror image of ky > 0
          f = hypot(kx / t%side(1), merge(ky / t%side(2), 0._dp, t%dim == 2))
          if (f >= edge(size(edge)) .or. f < edge(1)) cycle
          r = count_up_to(edge, f)
          if (pass == 1) then
            m(r) = m(r) + 1
            p(r) = p(r) + power(i, j)
            p2(r) = p2(r) + power(i, j)**2
            l(r) = l(r) + log(f)
            l2(r) = l2(r) + log(f)**2
            k = 1
            if (t%dim == 2) k = 1 + int(sectors * (0.5_dp + atan2(ky / t%side(2), kx / t%side(1)) / pi))
            apart(k, r, :) = apart(k, r, :) + [1._dp, power(i, j), power(i, j)**2]
          else if (m(r) >= fewest .and. t%f(place(r)) < low_end * t%df) then
            low = low + 1
            t%kx(low) = kx
            t%ky(low) = ky
            t%ring(low) = place(r)
          end if
        end do
      end do
      if (pass == 2) exit
      r = 0
      place = 0
      do i = 1, size(m)
        if (m(i) < fewest) cycle
        r = r + 1
        place(i) = r
      end do
      t%m = pack(m, m >= fewest)
      t%p = pack(p / max(m, 1._dp), m >= fewest)
      p2 = p2 * max(m, 1._dp) / max(p, tiny(1._dp))**2
      t%scatter = pack(p2, m >= fewest)
      t%aside = pack(among(apart(:, :, 0), apart(:, :, 1), apart(:, :, 2), p2), m >= fewest)
      t%f = pack(exp(l / max(m, 1._dp)), m >= fewest)
      t%width2 = max(pack(l2 / max(m, 1._dp) - (l / max(m, 1._dp))**2, m >= fewest), 0._dp)
      low = nint(sum(t%m, t%f < low_end * t%df))
      allocate (t%kx(low), t%ky(low), t%ring(low))
    end do
    if (t%dim == 2) call weigh_axes(t, power, edge, place)
  end subroutine collect

  !> Scatter of modes within their sectors, less what the mean of few takes; that of the ring where its sectors hold too few.
  pure function among(m, p, p2, whole) result(scatter)
    real(dp), intent(in) :: m(:, :), p(:, :), p2(:, :)  !< number, sums of power and of its square (sectors, rings)
    real(dp), intent(in) :: whole(:)                    !< scatter of the rings
    real(dp) :: scatter(size(whole)), each(size(m, 1), size(whole))
    each = p2 * (m + 1) / max(p, tiny(1._dp))**2
    scatter = merge(sum(m * each, 1, m >= fewest) / max(sum(m, 1, m >= fewest), 1._dp), whole, any(m >= fewest, 1))
  end function among

  !> Mean of the modes on either axis, each over the power of its ring, or over what the taper leaks of the longest waves where a
  !> blurred map holds less: that falls with the sixth power of the frequency.
  subroutine weigh_axes(t, power, edge, place)
    type(ring_table_t), intent(inout) :: t    !< rings; axis is set
    real(dp), intent(in) :: power(:, :)       !< of the half plane (nx/2 + 1, ny)
    real(dp), intent(in) :: edge(:)           !< of the rings [1/m]
    integer, intent(in) :: place(:)           !< of the rings in t, 0 where one was dropped
    integer :: i, j, l, n, on_axis(2), next(2)
    t%axis = 0
    t%leak = 0
    t%beside = 0
    on_axis = 0
    next = 0
    n = size(power, 2)
    do i = 1 + low_modes, size(power, 1)
      call add(1, (i - 1) / t%side(1), power(i, 1))
      do l = axis_width, min(axis_width + 2, (i - 1) / steep)
        call add_beside(1, hypot((i - 1) / t%side(1), l / t%side(2)), power(i, [1 + l, n + 1 - l]))
      end do
    end do
    do j = 1 + low_modes, n / 2
      call add(2, (j - 1) / t%side(2), power(1, j))
      do l = axis_width, min(axis_width + 2, (j - 1) / steep)
        call add_beside(2, hypot(l / t%side(1), (j - 1) / t%side(2)), power(1 + l, [j, n + 2 - j]))
      end do
    end do
    t%axis = t%axis / max(on_axis, 1)
    t%leak = t%leak / max(on_axis, 1)
    t%beside = merge(t%beside / max(next, 1), 1._dp, next > 0)
    t%beside_error = sqrt(t%kappa / max(next, 1))
  contains
    !> Two modes next to an axis beside their ring.
    subroutine add_beside(k, f, value)
      integer, intent(in) :: k                !< axis
      real(dp), intent(in) :: f, value(2)     !< frequency, power
      integer :: q
      if (f < edge(1) .or. f >= edge(size(edge))) return
      q = place(count_up_to(edge, f))
      if (q == 0) return
      if (.not. t%p(q) > well_above * t%p(1) * (t%f(1) / f)**falls) return     ! what leaks lies beside the axes
      t%beside(k) = t%beside(k) + sum(value) / t%p(q)
      next(k) = next(k) + 2
    end subroutine add_beside

    !> One mode beside its ring.
    subroutine add(k, f, value)
      integer, intent(in) :: k            !< axis
      real(dp), intent(in) :: f, value    !< frequency, power
      integer :: q
      if (f < edge(1) .or. f >= edge(size(edge))) return
      q = place(count_up_to(edge, f))
      if (q == 0) return
      if (.not. t%p(q) > 0) return
      t%axis(k) = t%axis(k) + value / max(t%p(q), t%p(1) * (t%f(1) / f)**falls)
      t%leak(k) = t%leak(k) + value / t%p(q)
      on_axis(k) = on_axis(k) + 1
    end subroutine add
  end subroutine weigh_axes
end module hd_ring_table
