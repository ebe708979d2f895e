! SPDX-License-Identifier: GPL-3.0-or-later
!> Roughness numbers named as in ISO 25178-2, of heights less their least-squares plane.
module hd_roughness
  use hd_kinds, only: dp, i8
  use hd_error, only: error_t
  use hd_observation, only: level_plane
  use hd_structure_function, only: check_map, structure_line, structure_second
  implicit none
  private
  public :: roughness_t, new_roughness

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
end module hd_roughness
