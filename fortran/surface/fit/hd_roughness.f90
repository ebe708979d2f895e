! SPDX-License-Identifier: GPL-3.0-or-later
!> Roughness numbers named as in ISO 25178-2, and the power spectral density, of heights less their least-squares plane.
module hd_roughness
  use hd_kinds, only: dp, i8, pi
  use hd_error, only: error_t, raise, code_input
  use hd_fft, only: forward_real, forward_real_2d
  use hd_observation, only: level_plane
  use hd_structure_function, only: check_map, structure_line, structure_second
  implicit none
  private
  public :: roughness_t, new_roughness, line_spectrum, ring_spectrum

  !> Roughness numbers.
  type :: roughness_t
    real(dp) :: sa = 0, sq = 0, sz = 0    !< mean and root mean square height, range [m]
    real(dp) :: ssk = 0, sku = 0          !< skewness, kurtosis
    real(dp) :: sdq = 0                   !< root mean square gradient over one spacing
    real(dp) :: bandwidth(2) = 0          !< shortest and longest wavelength that the map holds: two spacings, its shorter side [m]
    real(dp) :: nayak = 0                 !< Nayak's bandwidth parameter m0 m4 / m2^2 along rows
  end type roughness_t

contains

  !> Roughness numbers of a map or, ny = 1, of a profile; points that are not finite are holes.
  subroutine new_roughness(z, dx, dy, r, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                    !< spacing [m]
    type(roughness_t), intent(out) :: r               !< numbers
    type(error_t), allocatable, intent(out) :: error  !< bad map
    real(dp), allocatable :: flat(:, :)
    logical, allocatable :: good(:, :)
    real(dp) :: tilt(2), n, s_x(1), s_y(1), curved(1), pairs(1)
    call check_map(z, dx, dy, error)
    if (allocated(error)) return
    flat = z
    call level_plane(flat, tilt)
    good = abs(flat) <= huge(n)
    n = real(count(good, kind=i8), dp)
    r%sa = sum(abs(flat), good) / n
    r%sq = sqrt(sum(flat**2, good) / n)
    r%sz = maxval(flat, good) - minval(flat, good)
    r%ssk = sum(flat**3, good) / n / r%sq**3
    r%sku = sum(flat**4, good) / n / r%sq**4
    call structure_line(flat, [1, 0], [1], s_x, pairs, error)
    if (.not. allocated(error)) call structure_second(flat, [1, 0], [1], curved, pairs, error)
    if (allocated(error)) return
    r%sdq = sqrt(s_x(1)) / dx
    r%bandwidth = [2 * dx, (size(z, 1) - 1) * dx]
    if (size(z, 2) > 1) then
      call structure_line(flat, [0, 1], [1], s_y, pairs, error)
      if (allocated(error)) return
      r%sdq = sqrt(s_x(1) / dx**2 + s_y(1) / dy**2)
      r%bandwidth = [2 * max(dx, dy), min(r%bandwidth(2), (size(z, 2) - 1) * dy)]
    end if
    r%nayak = r%sq**2 * curved(1) / s_x(1)**2
  end subroutine new_roughness

  !> One-sided spectrum of the rows under a Hann window, mean over all [m^3]; its integral over the frequency is Sq^2.
  subroutine line_spectrum(z, dx, frequency, density, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx                        !< spacing along rows [m]
    real(dp), intent(out) :: frequency(:)             !< 1, 2, .. over the length [1/m] (nx / 2)
    real(dp), intent(out) :: density(:)               !< [m^3] (nx / 2)
    type(error_t), allocatable, intent(out) :: error  !< holes
    real(dp), allocatable :: flat(:, :), window(:)
    complex(dp), allocatable :: s(:, :)
    integer :: i
    call flatten(z, flat, error)
    if (allocated(error)) return
    window = hann(size(z, 1))
    flat = flat * spread(window, 2, size(z, 2))
    allocate (s(size(z, 1) / 2 + 1, size(z, 2)))
    call forward_real(flat, s, error)
    if (allocated(error)) return
    do i = 1, size(density)
      frequency(i) = i / (size(z, 1) * dx)
      density(i) = merge(1, 2, 2 * i == size(z, 1)) * sum(real(s(i + 1, :))**2 + aimag(s(i + 1, :))**2) / size(z, 2) &
        * dx / sum(window**2)                           ! Nyquist's frequency of an even row is its own mirror image
    end do
  end subroutine line_spectrum

  !> Two-dimensional spectrum under a Hann window, mean over rings of frequency [m^4]; NaN where a ring is empty.
  subroutine ring_spectrum(z, dx, dy, frequency, density, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    real(dp), intent(in) :: dx, dy                    !< spacing [m]
    real(dp), intent(out) :: frequency(:)             !< means over the rings [1/m]; one ring for each multiple of 1 / longer side
    real(dp), intent(out) :: density(:)               !< [m^4]
    type(error_t), allocatable, intent(out) :: error  !< holes
    real(dp), allocatable :: flat(:, :), window(:, :)
    complex(dp), allocatable :: s(:, :)
    real(dp) :: f, step, weight, number(size(density))
    integer :: i, j, k
    call flatten(z, flat, error)
    if (allocated(error)) return
    window = spread(hann(size(z, 1)), 2, size(z, 2)) * spread(hann(size(z, 2)), 1, size(z, 1))
    flat = flat * window
    allocate (s(size(z, 1) / 2 + 1, size(z, 2)))
    call forward_real_2d(flat, s, error)
    if (allocated(error)) return
    step = 1 / max(size(z, 1) * dx, size(z, 2) * dy)
    frequency = 0
    density = 0
    number = 0
    do j = 1, size(s, 2)
      do i = 1, size(s, 1)
        f = hypot((i - 1) / (size(z, 1) * dx), min(j - 1, size(z, 2) - j + 1) / (size(z, 2) * dy))
        k = nint(f / step)
        if (k < 1 .or. k > size(density)) cycle
        weight = merge(1, 2, i == 1 .or. 2 * (i - 1) == size(z, 1))     ! the other half plane
        number(k) = number(k) + weight
        frequency(k) = frequency(k) + weight * f
        density(k) = density(k) + weight * (real(s(i, j))**2 + aimag(s(i, j))**2)
      end do
    end do
    frequency = frequency / number
    density = density / number * dx * dy / sum(window**2)
  end subroutine ring_spectrum

  !> Heights less their plane, without holes.
  subroutine flatten(z, flat, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights [m]
    real(dp), allocatable, intent(out) :: flat(:, :)  !< the same less the plane [m]
    type(error_t), allocatable, intent(out) :: error  !< holes
    real(dp) :: tilt(2)
    if (.not. all(abs(z) <= huge(tilt))) then
      call raise(error, code_input, &
        'the map has holes: a spectrum needs every point; use structure_function, which takes holes')
      return
    end if
    flat = z
    call level_plane(flat, tilt)
  end subroutine flatten

  !> Hann window over n points, above 0 at the first and the last.
  pure function hann(n) result(w)
    integer, intent(in) :: n    !< points
    real(dp) :: w(n)
    integer :: i
    w = [(0.5_dp - 0.5_dp * cos(2 * pi * i / (n + 1)), i=1, n)]
  end function hann
end module hd_roughness
