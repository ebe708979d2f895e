! SPDX-License-Identifier: GPL-3.0-or-later
!> Stresses at the Gauss points, and at the nodes by trilinear extrapolation from the points of every cell and the mean over the
!> cells of a body that meet there. Large displacements: the second of Piola and Kirchhoff. Components are cylindrical, in the
!> directions at rest: rr, tt, zz, rt, tz, zr.
module hd_stress
  use hd_kinds, only: dp, pi
  use hd_body, only: body_t, cell_nodes, frame
  use hd_error, only: error_t
  use hd_hexahedron, only: element_points, elasticity_matrix, natural_coordinates, nodes_per_element, points, strain_matrix
  use hd_lapack, only: dgemm
  use hd_problem, only: problem_t
  use hd_total_lagrangian, only: cell_stress, total_lagrangian_t
  implicit none
  private
  public :: body_stress, nodal_stress, von_mises, principal_stresses, signed_equivalent

  real(dp), parameter :: at_rest(3, 3) = reshape([1._dp, 0._dp, 0._dp, 0._dp, 1._dp, 0._dp, 0._dp, 0._dp, 1._dp], [3, 3])

contains

  !> Stresses at the nodes of a body of a problem, and at that Gauss point of every cell where von Mises' stress is largest.
  subroutine body_stress(problem, b, u, stress, peak, error)
    type(problem_t), intent(in) :: problem            !< bodies
    integer, intent(in) :: b                          !< which
    real(dp), intent(in) :: u(:, :)                   !< displacements of all (3, n) [m]
    real(dp), intent(out) :: stress(:, :)             !< (6, nodes) [Pa]
    real(dp), intent(out) :: peak(:, :)               !< (6, cells of all sectors) [Pa]
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    associate (body => problem%bodies(b), low => problem%first(b) + 1, high => problem%first(b) + problem%bodies(b)%nodes())
      if (allocated(problem%lagrangian)) then
        call nodal_stress(body, u(:, low:high), stress, peak, error, problem%lagrangian(b))
      else
        call nodal_stress(body, u(:, low:high), stress, peak, error)
      end if
    end associate
  end subroutine body_stress

  !> Stresses at the nodes of a revolved body, and at that Gauss point of every cell where von Mises' stress is largest.
  subroutine nodal_stress(body, u, stress, peak, error, lagrangian)
    type(body_t), intent(in) :: body                  !< body
    real(dp), intent(in) :: u(:, :)                   !< its displacements (3, nodes) [m]
    real(dp), intent(out) :: stress(:, :)             !< (6, nodes) [Pa]
    real(dp), intent(out) :: peak(:, :)               !< (6, cells of all sectors) [Pa]
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    type(total_lagrangian_t), intent(in), optional :: lagrangian  !< its cells, if displacements may be large
    integer :: list(nodes_per_element(body%kind))
    real(dp), dimension(6*points, 3*size(list)) :: at_points
    real(dp), dimension(6*size(list), 3*size(list)) :: at_nodes
    real(dp), allocatable :: v(:, :, :), s(:, :, :), t(:, :, :)
    integer, allocatable :: meets(:)
    real(dp) :: to_nodes(size(list), points), energy
    integer :: cell, sector, a, n
    n = body%sectors
    to_nodes = extrapolation(size(list))
    allocate (v(3, size(list), n), s(6, points, n), t(6, size(list), n))
    allocate (meets(body%nodes()), source=0)
    stress = 0
    do cell = 1, size(body%cells, 2)  ! that of all sectors at once: they have the same matrices
      do sector = 1, n
        v(:, :, sector) = u(:, cell_nodes(body, cell, sector - 1))
      end do
      if (present(lagrangian)) then
        list = cell_nodes(body, cell, 0)
        do sector = 1, n
          call cell_stress(lagrangian%cells(cell), v(:, :, sector), s(:, :, sector), energy)
          do a = 1, size(list)
            t(:, a, sector) = turned(matmul(s(:, :, sector), to_nodes(a, :)), frame(body%angle(list(a))))
          end do
        end do
      else
        call stress_matrices(body, cell, at_points, at_nodes, error)
        if (allocated(error)) return
        call dgemm('N', 'N', 6*points, n, 3*size(list), 1._dp, at_points, 6*points, v, 3*size(list), 0._dp, s, 6*points)
        call dgemm('N', 'N', 6*size(list), n, 3*size(list), 1._dp, at_nodes, 6*size(list), v, 3*size(list), 0._dp, t, &
          6*size(list))
      end if
      do sector = 1, n
        peak(:, (sector - 1)*size(body%cells, 2) + cell) = s(:, maxloc(von_mises(s(:, :, sector)), 1), sector)
        list = cell_nodes(body, cell, sector - 1)
        do a = 1, size(list)
          stress(:, list(a)) = stress(:, list(a)) + t(:, a, sector)
          meets(list(a)) = meets(list(a)) + 1
        end do
      end do
    end do
    stress = stress/spread(max(1, meets), 1, 6)
  end subroutine nodal_stress

  !> Stresses of a cell per displacement of its nodes.
  subroutine stress_matrices(body, cell, at_points, at_nodes, error)
    type(body_t), intent(in) :: body                  !< body
    integer, intent(in) :: cell                       !< cell of the first sector
    real(dp), intent(out) :: at_points(:, :)          !< Cartesian, at the Gauss points (6 points, 3 nodes) [Pa/m]
    real(dp), intent(out) :: at_nodes(:, :)           !< cylindrical, at the nodes (6 nodes, 3 nodes) [Pa/m]
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    integer :: list(nodes_per_element(body%kind)), a, i, p
    real(dp) :: c(6, 6), g(size(list), 3, points), weight(points), b(3*size(list), 6), to_nodes(size(list), points)
    real(dp) :: strain(6*points, 3*size(list))
    real(dp), allocatable :: modes(:, :)
    real(dp) :: q(3, 3)
    list = cell_nodes(body, cell, 0)
    c = elasticity_matrix(body%young, body%poisson)
    call element_points(body%kind, body%x(:, list), c, g, weight, modes, error)
    if (allocated(error)) return
    do p = 1, points
      call strain_matrix(g(:, :, p), at_rest, b)
      do a = 1, size(list)
        strain(6*p - 5:6*p, 3*a - 2:3*a) = matmul(transpose(b(3*a - 2:3*a, :)), frame(body%angle(list(a))))
      end do
      at_points(6*p - 5:6*p, :) = matmul(c, strain(6*p - 5:6*p, :))
    end do
    do i = 1, size(modes, 2)
      at_points = at_points - spread(modes(:, i)/[(spread(weight(p), 1, 6), p=1, points)], 2, size(strain, 2))* &
        spread(matmul(modes(:, i), strain), 1, 6*points)
    end do
    to_nodes = extrapolation(size(list))
    do a = 1, size(list)
      q = frame(body%angle(list(a)))
      do i = 1, 3*size(list)
        at_nodes(6*a - 5:6*a, i) = turned(matmul(reshape(at_points(:, i), [6, points]), to_nodes(a, :)), q)
      end do
    end do
  end subroutine stress_matrices

  !> Values at the nodes of a cell from those at its Gauss points.
  pure function extrapolation(nodes) result(n)
    integer, intent(in) :: nodes  !< 8 or 20
    real(dp) :: n(nodes, points), xi(3)
    integer :: a, i, p
    do a = 1, nodes
      xi = sqrt(3._dp)*natural_coordinates(a)
      do p = 1, points
        n(a, p) = product([((1 + merge(1, -1, btest(p - 1, i))*xi(i + 1))/2, i=0, 2)])
      end do
    end do
  end function extrapolation

  !> Cylindrical components at an angle of a stress given in Cartesian ones.
  pure function turned(s, q) result(t)
    real(dp), intent(in) :: s(6)      !< xx, yy, zz, xy, yz, zx
    real(dp), intent(in) :: q(3, 3)   !< frame there
    real(dp) :: t(6), m(3, 3)
    m = reshape([s(1), s(4), s(6), s(4), s(2), s(5), s(6), s(5), s(3)], [3, 3])
    m = matmul(transpose(q), matmul(m, q))
    t = [m(1, 1), m(2, 2), m(3, 3), m(1, 2), m(2, 3), m(3, 1)]
  end function turned

  !> Von Mises stress of columns [Pa].
  pure function von_mises(s) result(v)
    real(dp), intent(in) :: s(:, :)  !< (6, n) [Pa]
    real(dp) :: v(size(s, 2))
    v = sqrt(max(0._dp, ((s(1, :) - s(2, :))**2 + (s(2, :) - s(3, :))**2 + (s(3, :) - s(1, :))**2)/2 + &
      3*(s(4, :)**2 + s(5, :)**2 + s(6, :)**2)))
  end function von_mises

  !> Principal stresses, largest first, by the angle of the deviator [Pa].
  pure function principal_stresses(s) result(p)
    real(dp), intent(in) :: s(:, :)  !< (6, n) [Pa]
    real(dp) :: p(3, size(s, 2)), mean, d(6), j2, j3, angle
    integer :: i
    do i = 1, size(s, 2)
      mean = sum(s(:3, i))/3
      d = [s(:3, i) - mean, s(4:, i)]
      j2 = sum(d(:3)**2)/2 + sum(d(4:)**2)
      j3 = d(1)*(d(2)*d(3) - d(5)**2) - d(4)*(d(4)*d(3) - d(5)*d(6)) + d(6)*(d(4)*d(5) - d(2)*d(6))
      p(:, i) = mean
      if (.not. j2 > 0) cycle
      angle = acos(max(-1._dp, min(1._dp, 1.5_dp*sqrt(3._dp)*j3/j2**1.5_dp)))/3
      p(:, i) = mean + 2*sqrt(j2/3)*[cos(angle), cos(angle - 2*pi/3), cos(angle + 2*pi/3)]
    end do
  end function principal_stresses

  !> Von Mises stress with the sign of the principal stress of the largest amount [Pa].
  pure function signed_equivalent(s) result(v)
    real(dp), intent(in) :: s(:, :)  !< (6, n) [Pa]
    real(dp) :: v(size(s, 2)), p(3, size(s, 2))
    p = principal_stresses(s)
    v = sign(von_mises(s), maxval(p, 1) + minval(p, 1))
  end function signed_equivalent
end module hd_stress
