! SPDX-License-Identifier: GPL-3.0-or-later
!> The circular spline as an elastic ring under the forces of its teeth, in closed form by harmonics: a curved beam of rectangular
!> section with stretch, shear (Timoshenko) and bending. Amplitudes w (radial), v (tangential) and f (turn of the section) of
!> harmonic n give
!>   stretch e = (w + n v)/R,   shear g = f - (n w + v)/R,   curvature h = n f/R
!> and obey  (E A e e^T + k G A g g^T + E I h h^T) (w, v, f) = load / (pi R).
!> The housing holds the ring's turn and its translation as a whole, by forces spread evenly: harmonic 1 and the tangential part of
!> harmonic 0 give nothing. Loads act amid the teeth, inside of the ring, which begins at their roots.
module hd_spline_ring
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t
  use hd_lapack, only: solve_dense
  use hd_scene, only: scene_t
  use hd_tooth_flanks, only: flank_directions, flanks_of, tooth_angles
  implicit none
  private
  public :: spline_ring_t, new_spline_ring, ring_compliance, flank_compliance

  integer, parameter :: last = 400                    !< harmonic; what is left falls with its inverse
  real(dp), parameter :: shear_factor = 5._dp/6._dp   !< k of a rectangle

  type :: spline_ring_t
    real(dp) :: uniform = 0                     !< radial way of harmonic 0 under a radial force [m/N]
    real(dp) :: hat(2, 2, 2:last) = 0           !< ways (radial, tangential) of the teeth by force there [m/N]
  end type spline_ring_t

contains

  !> Harmonics of a ring.
  function new_spline_ring(radii, teeth, width, young, poisson) result(ring)
    real(dp), intent(in) :: radii(2)    !< inside, outside [m]
    real(dp), intent(in) :: teeth       !< from the inside inwards to where forces act [m]
    real(dp), intent(in) :: width       !< axial [m]
    real(dp), intent(in) :: young       !< E [Pa]
    real(dp), intent(in) :: poisson     !< nu
    type(spline_ring_t) :: ring
    real(dp) :: k(3, 3), centre, thickness, rigid(3)
    integer :: n
    centre = sum(radii)/2
    thickness = radii(2) - radii(1)
    rigid = young*width*thickness*[1._dp, shear_factor/(2*(1 + poisson)), thickness**2/12]
    ring%uniform = centre/(2*pi*rigid(1))
    do n = 2, last
      k = rigid(1)*outer([1._dp, real(n, dp), 0._dp]/centre) + rigid(2)*outer([-n/centre, -1/centre, 1._dp]) + &
        rigid(3)*outer([0._dp, 0._dp, n/centre])
      ring%hat(:, :, n) = at_teeth(k, thickness/2 + teeth)/(pi*centre)
    end do
  end function new_spline_ring

  !> a a^T.
  pure function outer(a) result(product)
    real(dp), intent(in) :: a(3)
    real(dp) :: product(3, 3)
    product = spread(a, 2, 3)*spread(a, 1, 3)
  end function outer

  !> L^T K^-1 L: a tangential force at a depth d inside of the centre line turns the section by -d.
  function at_teeth(k, d) result(hat)
    real(dp), intent(in) :: k(3, 3), d
    real(dp) :: hat(2, 2), a(3, 3), l(3, 2), x(3, 2)
    type(error_t), allocatable :: error   ! never: the matrix is positive definite
    a = k
    l(:, 1) = [1, 0, 0]
    l(:, 2) = [0._dp, 1._dp, -d]
    x = l
    call solve_dense(a, x, error)
    hat = matmul(transpose(l), x)
  end function at_teeth

  !> Ways (radial, tangential) of a point under unit forces (radial, tangential) at another [m/N].
  pure function ring_compliance(ring, angle) result(c)
    type(spline_ring_t), intent(in) :: ring  !< ring
    real(dp), intent(in) :: angle            !< of the point, less that of the force [rad]
    real(dp) :: c(2, 2)
    integer :: n
    c = 0
    c(1, 1) = ring%uniform
    do n = 2, last
      c(1, 1) = c(1, 1) + ring%hat(1, 1, n)*cos(n*angle)
      c(2, 2) = c(2, 2) + ring%hat(2, 2, n)*cos(n*angle)
      c(2, 1) = c(2, 1) + ring%hat(2, 1, n)*sin(n*angle)
      c(1, 2) = c(1, 2) - ring%hat(1, 2, n)*sin(n*angle)
    end do
  end function ring_compliance

  !> Ways of all flanks, and of their companions, under unit forces, in the order of hd_tooth_flanks [m/N].
  function flank_compliance(scene) result(c)
    type(scene_t), intent(in) :: scene  !< scene with an elastic circular spline
    real(dp) :: c(flanks_of(scene), flanks_of(scene)), radii(2), teeth, width
    type(spline_ring_t) :: ring
    real(dp) :: theta(scene%tooth_pairs), along(2, 4), way(2, 2), ways(2, 2, scene%tooth_pairs)
    real(dp), allocatable :: given(:)
    real(dp), allocatable, save :: last_given(:), last_found(:, :)  ! drives that differ in other keys ask for the same
    integer :: i, j, k, l, n, apart, half
    radii = scene%spline_radii()
    teeth = radii(1) - scene%w - scene%tooth_circle()
    width = scene%spline_breadth()
    theta = tooth_angles(scene)
    along = flank_directions(scene)
    n = 2*scene%tooth_pairs
    given = [radii, teeth, width, scene%flexspline_e, scene%flexspline_nu, theta, along]
    if (allocated(last_given)) then
      if (size(given) == size(last_given) .and. size(c) == size(last_found)) then
        if (.not. any(abs(given - last_given) > 0)) then
          c = last_found
          return
        end if
      end if
    end if
    ring = new_spline_ring(radii, teeth, width, scene%flexspline_e, scene%flexspline_nu)
    half = scene%tooth_pairs/2
    ways = reshape([(ring_compliance(ring, theta(i) - theta(1)), i=1, scene%tooth_pairs)], shape(ways))
    do j = 1, scene%tooth_pairs
      do i = 1, scene%tooth_pairs
        apart = modulo(i - 1, half) - modulo(j - 1, half)  ! in pitches: pairs stand alike at both ends
        way = ways(:, :, 1 + abs(apart) + merge(half, 0, (i > half) .neqv. (j > half)))
        if (apart < 0) way = way*reshape([1, -1, -1, 1], [2, 2])
        do l = 0, size(c, 2)/n - 1
          do k = 0, size(c, 1)/n - 1
            c(k*n + 2*i - 1:k*n + 2*i, l*n + 2*j - 1:l*n + 2*j) = matmul(transpose(along(:, 2*k + 1:2*k + 2)), &
              matmul(way, along(:, 2*l + 1:2*l + 2)))
          end do
        end do
      end do
    end do
    last_given = given
    last_found = c
  end function flank_compliance
end module hd_spline_ring
