! SPDX-License-Identifier: GPL-3.0-or-later
!> Kaiser-Bessel window of the non-uniform FFT: psi(t) = I0(b sqrt(1 - (2t/w)^2)) / I0(b), |t| <= w/2 in fine points.
!>
!> Its transform w sinh(r) / (r I0(b)), r^2 = b^2 - (pi w x)^2, is closed. With b = pi w (1 - 1/(2s)), s the ratio of fine to
!> wanted points, the first alias starts where the transform of the window has just become small: Error ~ exp(-pi w sqrt(1 - 1/s)).
module hd_window
  use hd_kinds, only: dp, sp, pi
  implicit none
  private
  public :: window_t, new_window, window_gain, window_width, widest

  real(dp), parameter :: small = 0.02_dp      !< share of the tolerance that the window's polynomial may be off by
  real(dp), parameter :: near_zero = 1e-4_dp  !< r whose r^4/120 is below rounding
  integer, parameter :: widest = 28    !< largest width
  integer, parameter :: nodes = 24     !< Chebyshev nodes of the fit
  real(dp), parameter :: rounding(2) = [1e-15_dp, 6e-8_dp]   !< error of a weight in double, in single precision

  !> Window for n wanted of `fine` points.
  type :: window_t
    integer :: n = 0, fine = 0                       !< wanted points, fine points
    integer :: width = 0                             !< w
    real(dp) :: tolerance = 0                        !< error of a height
    integer :: padded = 0                            !< w filled up with zero weights to a multiple of four
    integer :: degree = 0                            !< degree of the pieces
    real(dp), allocatable :: piece(:, :)             !< coefficients (padded, 0:degree) of s in [-1, 1] across each unit interval
    real(sp), allocatable :: piece_single(:, :)      !< the same
    real(dp), allocatable :: correction(:)           !< 1 / transform at 0 .. (n + 1)/2 points from the middle
  end type window_t

  type(window_t), save :: kept(4)      !< the last windows: making one costs as much as a small NUFFT
  integer, save :: latest = 0

contains

  !> A window of those kept, or a new one.
  subroutine new_window(n, fine, width, tolerance, win)
    integer, intent(in) :: n, fine, width     !< wanted points, fine points, width
    real(dp), intent(in) :: tolerance         !< error of a height
    type(window_t), intent(out) :: win        !< window
    integer :: i
    !$omp critical (windows)
    do i = 1, size(kept)
      if (kept(i)%n == n .and. kept(i)%fine == fine .and. kept(i)%width == width .and. kept(i)%tolerance == tolerance) win = kept(i)
    end do
    if (win%n == 0) then
      call make_window(n, fine, width, tolerance, win)
      latest = modulo(latest, size(kept)) + 1
      kept(latest) = win
    end if
    !$omp end critical (windows)
  end subroutine new_window

  !> Pieces and correction of a window.
  subroutine make_window(n, fine, width, tolerance, win)
    integer, intent(in) :: n, fine, width     !< wanted points, fine points, width
    real(dp), intent(in) :: tolerance         !< error of a height
    type(window_t), intent(out) :: win        !< window
    real(dp) :: b, value(nodes), c(0:nodes - 1), t(0:nodes - 1), older(0:nodes - 1), newer(0:nodes - 1), s, q
    real(dp) :: all_c(width, 0:nodes - 1)
    integer :: i, k, l
    win%n = n
    win%fine = fine
    win%width = width
    win%tolerance = tolerance
    win%padded = 4 * ((width + 3) / 4)
    b = shape_of(n, fine, width)
    do i = 1, width
      do k = 1, nodes
        s = cos(pi * (k - 0.5_dp) / nodes)
        s = (i - 1 + (s + 1) / 2) * 2 / width - 1
        q = sqrt(max(0._dp, (1 - s) * (1 + s)))
        value(k) = exp(-b * s**2 / (1 + q)) * scaled_i0(b * q) / scaled_i0(b)    ! no large exponents: exact where psi is large
      end do
      do l = 0, nodes - 1
        c(l) = merge(1, 2, l == 0) * sum(value * cos(l * pi * ([(k, k=1, nodes)] - 0.5_dp) / nodes)) / nodes
      end do
      all_c(i, :) = c
    end do
    allocate (win%correction(0:(n + 1) / 2))
    do i = 0, (n + 1) / 2
      win%correction(i) = scaled_i0(b) * exp(b) / (width * sinhc2(b**2 - (pi * width * real(i, dp) / fine)**2))
    end do
    s = max(rounding(1), small * tolerance * win%correction(0) / win%correction(n / 2))
    do l = 1, nodes - 1                                   ! the first two coefficients in a row that are small
      win%degree = l - 1
      if (maxval(abs(all_c(:, l:min(l + 1, nodes - 1)))) < s) exit
      win%degree = l
    end do
    allocate (win%piece(win%padded, 0:win%degree), source=0._dp)
    older = 0                                             ! T_-1 is not used: T_0 = 1, T_1 = s
    t = 0
    t(0) = 1
    do l = 0, win%degree
      do k = 0, l
        win%piece(:width, k) = win%piece(:width, k) + all_c(:, l) * t(k)
      end do
      newer = merge(1, 2, l == 0) * eoshift(t, -1) - older
      older = t
      t = newer
    end do
    win%piece_single = real(win%piece, sp)
  end subroutine make_window

  !> Smallest width whose error stays below the tolerance; 0 if there is none.
  pure integer function window_width(n, fine, tolerance, precision) result(width)
    integer, intent(in) :: n, fine            !< wanted points, fine points
    real(dp), intent(in) :: tolerance         !< error wanted
    integer, intent(in) :: precision          !< 1 double, 2 single
    integer :: guess
    guess = floor(-log(tolerance) / (pi * sqrt(1 - real(n, dp) / fine))) - 1
    do width = max(2, guess), widest
      if (window_error(n, fine, width, precision) <= tolerance) return
    end do
    width = 0
  end function window_width

  !> Root mean square over the wanted points of the relative error: aliases and rounding. The error grows steeply towards the
  !> ends, so the points are x = end (1 - t^2), and the end itself counts as the one point it is.
  pure real(dp) function window_error(n, fine, width, precision) result(error)
    integer, intent(in) :: n, fine, width     !< wanted points, fine points, width
    integer, intent(in) :: precision          !< 1 double, 2 single
    integer, parameter :: samples = 8
    real(dp) :: t, total
    integer :: i
    total = point_error(n, fine, width, 1._dp, precision) / n
    do i = 1, samples
      t = (i - 0.5_dp) / samples
      total = total + 2 * t / samples * point_error(n, fine, width, 1 - t**2, precision)
    end do
    error = sqrt(total)
  end function window_error

  !> Root mean square over the wanted points of what the division by the transform makes of rounding errors.
  pure real(dp) function window_gain(n, fine, width) result(gain)
    integer, intent(in) :: n, fine, width     !< wanted points, fine points, width
    integer, parameter :: samples = 8
    real(dp) :: t, total, b2
    integer :: i
    b2 = shape_of(n, fine, width)**2
    total = 0
    do i = 1, samples
      t = (i - 0.5_dp) / samples
      total = total + 2 * t / samples * (sinhc2(b2) / sinhc2(b2 - (pi * width * (1 - t**2) * 0.5_dp * n / fine)**2))**2
    end do
    gain = sqrt(total)
  end function window_gain

  !> Squared relative error at a part x of the way from the middle to the end. The further aliases add a fifth of the near ones.
  pure real(dp) function point_error(n, fine, width, part, precision) result(square)
    integer, intent(in) :: n, fine, width     !< wanted points, fine points, width
    real(dp), intent(in) :: part              !< 0 middle .. 1 end
    integer, intent(in) :: precision          !< 1 double, 2 single
    real(dp) :: b2, x
    b2 = shape_of(n, fine, width)**2
    x = part * 0.5_dp * n / fine
    square = (1.2_dp * (sinhc2(b2 - (pi * width * (1 - x))**2)**2 + sinhc2(b2 - (pi * width * (1 + x))**2)**2) + &
      (rounding(precision) * sinhc2(b2))**2) / sinhc2(b2 - (pi * width * x)**2)**2
  end function point_error

  !> b of the window.
  pure real(dp) function shape_of(n, fine, width) result(b)
    integer, intent(in) :: n, fine, width     !< wanted points, fine points, width
    b = pi * width * (1 - 0.5_dp * n / fine)
  end function shape_of

  !> sinh(r) / r for r^2 given, also negative.
  pure real(dp) function sinhc2(r2) result(y)
    real(dp), intent(in) :: r2    !< r^2
    real(dp) :: r
    r = sqrt(abs(r2))
    if (r < near_zero) then
      y = 1 + r2 / 6
    else if (r2 > 0) then
      y = sinh(r) / r
    else
      y = sin(r) / r
    end if
  end function sinhc2

  !> exp(-x) I0(x), the mean of exp(-x (1 - cos a)) over the circle: the trapezoidal rule converges faster than any power.
  pure real(dp) function scaled_i0(x) result(y)
    real(dp), intent(in) :: x    !< argument
    integer :: k, n
    n = ceiling(sqrt(20 * x)) + 8                      ! points on half the circle
    y = 0.5_dp * (1 + exp(-2 * x))
    do k = 1, n - 1
      y = y + exp(-2 * x * sin(0.5_dp * pi * k / n)**2)
    end do
    y = y / n
  end function scaled_i0
end module hd_window
