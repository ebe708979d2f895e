! SPDX-License-Identifier: GPL-3.0-or-later
!> Is a map a sum of Eq. 1? Its spectrum is then no continuum but lines at gamma^n/L in the directions pi m/M, which stand orders of
!> magnitude above everything between them. M, gamma and the frequencies are read off; L is known up to a power of gamma, for
!> the longest waves cannot be told apart on a map no longer than they are.
module hd_ridge_search
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t
  use hd_fft, only: forward_real_2d
  use hd_wave_sum, only: ridges_t
  implicit none
  private
  public :: find_ridges

  integer, parameter :: fewest = 3                !< rings of frequency that must be seen
  real(dp), parameter :: lowest = 8               !< waves per map from which lines are looked for
  real(dp), parameter :: near = 0.1_dp            !< a line is within this many waves per map of its place
  real(dp), parameter :: apart = 6                !< lines so far apart do not shift each other's peaks

  !> Power spectrum of the map under a window, and its peaks off the middle.
  type :: lines_t
    integer :: n(2) = 0                           !< points along x and y
    real(dp), allocatable :: p(:, :)              !< power at whole waves per map (0:n_x/2, 0:n_y-1)
    real(dp), allocatable :: x(:), y(:)           !< peaks [waves per map], x >= 0
    real(dp), allocatable :: height(:)            !< their power
    real(dp) :: strongest = 0                     !< their greatest power
  end type lines_t

contains

  !> Look for the ridges of Eq. 1.
  subroutine find_ridges(z, dx, dy, r, found)
    real(dp), intent(in) :: z(:, :)               !< heights (nx, ny), levelled [m]
    real(dp), intent(in) :: dx, dy                !< spacing [m]
    type(ridges_t), intent(out) :: r              !< the sum; L is the one nearest the longer side
    logical, intent(out) :: found                 !< there are some
    type(lines_t) :: l
    type(error_t), allocatable :: error
    real(dp) :: top, side(2)
    integer :: n, k
    found = .false.
    if (minval(shape(z)) < 4 * lowest) return
    if (.not. all(abs(z) <= huge(z))) return
    call new_lines(z, l, error)
    if (allocated(error)) return
    side = shape(z) * [dx, dy]
    call find_ladder(l, top, r%gamma)
    if (top <= 0) return
    do k = 0, fewest - 1                          ! a folded line may hide one on a ring
      r%count = ridges_on(l, side, top / r%gamma**k)
      if (r%count > 0) exit
    end do
    if (r%count == 0) return
    call refine(l, side, r%count, top, r%gamma)
    n = nint(log(top * maxval(side) / side(1)) / log(r%gamma))
    r%length = side(1) / top * r%gamma**n
    r%n_max = n
    do while (seen(l, side, r, r%n_max + 1))
      r%n_max = r%n_max + 1
    end do
    found = .true.
  end subroutine find_ridges

  !> Spectrum under a Gaussian window (side lobes at -100 dB), where ln p of a line is a parabola, and its peaks.
  subroutine new_lines(z, l, error)
    real(dp), intent(in) :: z(:, :)                   !< heights [m]
    type(lines_t), intent(out) :: l                   !< lines
    type(error_t), allocatable, intent(out) :: error  !< no transform
    real(dp), allocatable :: a(:, :)
    complex(dp), allocatable :: s(:, :)
    real(dp) :: q(3, 3)
    integer :: i, j, pass, n
    l%n = shape(z)
    allocate (s(0:l%n(1) / 2, 0:l%n(2) - 1), l%p(0:l%n(1) / 2, 0:l%n(2) - 1))
    a = z * spread(window(l%n(1)), 2, l%n(2)) * spread(window(l%n(2)), 1, l%n(1))
    call forward_real_2d(a, s, error)
    if (allocated(error)) return
    l%p(:, :) = abs(s)**2
    do pass = 1, 2
      n = 0
      do j = -(l%n(2) - 1) / 2, l%n(2) / 2
        do i = 0, l%n(1) / 2
          if (hypot(real(i, dp), real(j, dp)) < lowest .or. (i == 0 .and. j < 0)) cycle
          if (power(l, i, j) < 1e-5_dp * l%strongest .or. .not. is_peak(l, i, j)) cycle
          n = n + 1
          if (pass == 1) then
            l%strongest = max(l%strongest, power(l, i, j))
          else
            q = reshape(log([power(l, i - 1, j - 1), power(l, i, j - 1), power(l, i + 1, j - 1), power(l, i - 1, j), &
              power(l, i, j), power(l, i + 1, j), power(l, i - 1, j + 1), power(l, i, j + 1), power(l, i + 1, j + 1)]), [3, 3])
            l%x(n) = i + 0.5_dp * (q(1, 2) - q(3, 2)) / (q(1, 2) - 2 * q(2, 2) + q(3, 2))
            l%height(n) = power(l, i, j)
            l%y(n) = j + 0.5_dp * (q(2, 1) - q(2, 3)) / (q(2, 1) - 2 * q(2, 2) + q(2, 3))
          end if
        end do
      end do
      if (pass == 1) allocate (l%x(n), l%y(n), l%height(n), source=0._dp)
    end do
    l%x = l%x(:n)
    l%y = l%y(:n)
    l%height = l%height(:n)
  end subroutine new_lines

  !> Window of n points.
  pure function window(n) result(w)
    integer, intent(in) :: n    !< points
    real(dp) :: w(n)
    integer :: i
    w = [(exp(-0.5_dp * (8.5_dp * (i - 0.5_dp * (n + 1)) / n)**2), i=1, n)]
  end function window

  !> Power at any whole waves per map.
  pure real(dp) function power(l, i, j)
    type(lines_t), intent(in) :: l    !< spectrum
    integer, intent(in) :: i, j       !< waves per map along x and y
    integer :: k
    k = modulo(i, l%n(1))
    if (k <= l%n(1) / 2) then
      power = l%p(k, modulo(j, l%n(2)))
    else
      power = l%p(l%n(1) - k, modulo(-j, l%n(2)))
    end if
  end function power

  !> Greater than all within two waves per map.
  pure logical function is_peak(l, i, j)
    type(lines_t), intent(in) :: l    !< spectrum
    integer, intent(in) :: i, j       !< waves per map along x and y
    integer :: a, b
    is_peak = .false.
    do b = -2, 2
      do a = -2, 2
        if ((a /= 0 .or. b /= 0) .and. power(l, i + a, j + b) >= power(l, i, j)) return
      end do
    end do
    is_peak = .true.
  end function is_peak

  !> Frequencies along x, where the ridge m = M lies: the most lines, down from one without a gap, that are a geometric sequence.
  subroutine find_ladder(l, top, gamma)
    type(lines_t), intent(in) :: l            !< lines
    real(dp), intent(out) :: top              !< highest frequency below Nyquist's [waves per map], 0 if there is no sequence
    real(dp), intent(out) :: gamma            !< ratio
    real(dp), allocatable :: f(:), rung(:)
    integer :: i, j, k, most
    f = pack(l%x, abs(l%y) < near)
    most = fewest - 1
    top = 0
    gamma = 0
    do i = 1, size(f)
      do j = 1, size(f)
        if (f(j) * 1.05_dp > f(i)) cycle
        rung = f([i])
        do
          k = minloc(abs(f - f(i) * (f(j) / f(i))**size(rung)), 1)
          if (.not. abs(f(k) - f(i) * (f(j) / f(i))**size(rung)) <= near) exit
          rung = [rung, f(k)]
        end do
        if (size(rung) <= most) cycle
        most = size(rung)
        call straighten([(k, k=0, size(rung) - 1)], rung, top, gamma)
      end do
    end do
  end subroutine find_ladder

  !> Least squares of ln f over the rungs; a line is out by the same waves per map wherever it is, so ln f weighs f^2.
  pure subroutine straighten(rung, f, top, gamma)
    integer, intent(in) :: rung(:)        !< rungs down from the top, 0 first
    real(dp), intent(in) :: f(:)          !< their frequencies
    real(dp), intent(out) :: top, gamma   !< first frequency and ratio of the sequence
    real(dp) :: w(size(f)), y(size(f)), mean_x, mean_y
    w = f**2 / sum(f**2)
    y = log(f)
    mean_x = sum(w * rung)
    mean_y = sum(w * y)
    gamma = exp(-sum(w * (rung - mean_x) * (y - mean_y)) / sum(w * (rung - mean_x)**2))
    top = exp(mean_y + mean_x * log(gamma))
  end subroutine straighten

  !> The same over all lines on rings where they are well apart.
  pure subroutine refine(l, side, count_m, top, gamma)
    type(lines_t), intent(in) :: l            !< lines
    real(dp), intent(in) :: side(2)           !< sides of the map [m]
    integer, intent(in) :: count_m            !< M
    real(dp), intent(inout) :: top, gamma     !< first frequency [waves per map along x] and ratio
    real(dp) :: f(size(l%x))
    integer :: rung(size(l%x))
    logical :: good(size(l%x))
    f = hypot(l%x, l%y * side(1) / side(2))
    rung = nint(log(top / f) / log(gamma))
    good = abs(f - top / gamma**rung) < 2 * near .and. rung >= 0 .and. f * pi / count_m > apart
    if (any(good .and. rung > 0)) call straighten(pack(rung, good), pack(f, good), top, gamma)
  end subroutine refine

  !> M: lines on the top ring, all as strong, each in its place; 0 if they are not.
  pure integer function ridges_on(l, side, top) result(count_m)
    type(lines_t), intent(in) :: l        !< lines
    real(dp), intent(in) :: side(2), top  !< sides of the map [m], radius of the ring [waves per map along x]
    real(dp) :: f(2)
    logical :: on(size(l%x))
    integer :: m
    on = abs(hypot(l%x, l%y * side(1) / side(2)) - top) < 2 * near
    on = on .and. l%height > 0.1_dp * maxval(l%height, on)
    count_m = count(on)
    do m = 1, count_m
      f = top * [cos(pi * m / count_m), sin(pi * m / count_m) * side(2) / side(1)]
      if (.not. any(on .and. min(hypot(l%x - f(1), l%y - f(2)), hypot(l%x + f(1), l%y + f(2))) < 3 * near)) exit
    end do
    if (m <= count_m) count_m = 0
  end function ridges_on

  !> Waves of index n are there, folded at Nyquist's frequency: half of their places have power no noise has.
  pure logical function seen(l, side, r, n)
    type(lines_t), intent(in) :: l      !< lines
    real(dp), intent(in) :: side(2)     !< sides of the map [m]
    type(ridges_t), intent(in) :: r     !< the sum
    integer, intent(in) :: n            !< index
    real(dp) :: f(2)
    integer :: m, hits
    seen = .false.
    if (n > 200) return
    hits = 0
    do m = 1, r%count
      f = r%gamma**n / r%length * side * [cos(pi * m / r%count), sin(pi * m / r%count)]
      if (power(l, nint(modulo(f(1), real(l%n(1), dp))), nint(modulo(f(2), real(l%n(2), dp)))) > 1e-3_dp * weakest(n - 1)) &
        hits = hits + 1
    end do
    seen = 2 * hits > r%count
  contains
    !> Power of the line along x, of an index that was seen.
    pure real(dp) function weakest(k)
      integer, intent(in) :: k    !< index
      real(dp) :: x
      x = modulo(r%gamma**k / r%length * side(1), real(l%n(1), dp))
      weakest = power(l, nint(x), 0)
    end function weakest
  end function seen
end module hd_ridge_search
