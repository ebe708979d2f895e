! SPDX-License-Identifier: GPL-3.0-or-later
!> Stresses at the Gauss points, and at the nodes by trilinear extrapolation from the points of every cell and the mean over the
!> cells of a body that meet there. Large displacements: the second of Piola and Kirchhoff. Components are cylindrical, in the
!> directions at rest: rr, tt, zz, rt, tz, zr.
module hd_stress
  use hd_kinds, only: dp, pi
  use hd_body, only: body_t, cell_nodes, frame
  use hd_error, only: error_t
  use hd_hexahedron, only: element_points, elasticity_matrix, natural_coordinates, nodes_per_element, points, strain_matrix
  use hd_lapack, only: blas_threads, dgemm
  use hd_problem, only: problem_t
  use hd_total_lagrangian, only: cell_stress, total_lagrangian_t
  implicit none
  private
  public :: stress_matrices_t, body_stress, nodal_stress, worst_node, node_stress
  public :: many_nodes, von_mises, square_of, largest_of, principal_stresses, signed_equivalent

  integer, parameter :: many_nodes = 20000  !< of a body, from which two threads are worth waking
  integer, parameter :: chunk = 15          !< sectors that a thread evaluates at once, beside the one before them
  real(dp), parameter :: at_rest(3, 3) = reshape([1._dp, 0._dp, 0._dp, 0._dp, 1._dp, 0._dp, 0._dp, 0._dp, 1._dp], [3, 3])

  !> Stresses of the cells of a sector per displacement of their nodes, under small displacements; kept between load steps.
  type :: stress_matrices_t
    real(dp), allocatable :: at_points(:, :, :)  !< Cartesian, at the Gauss points (6 points, 3 nodes, cells) [Pa/m]
    real(dp), allocatable :: at_nodes(:, :, :)   !< cylindrical, at the nodes (6 nodes, 3 nodes, cells) [Pa/m]
  end type stress_matrices_t

contains

  !> Node where von Mises' stress of all bodies is largest under small displacements.
  subroutine worst_node(problem, u, b, node, error)
    type(problem_t), intent(in) :: problem            !< bodies
    real(dp), intent(in) :: u(:, :)                   !< displacements (3, n) [m]
    integer, intent(out) :: b, node                   !< body, and which of its nodes
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    type(stress_matrices_t), allocatable :: matrices
    real(dp), allocatable :: stress(:, :)
    real(dp) :: most
    integer :: i
    most = -1
    do i = 1, size(problem%bodies)
      allocate (matrices, stress(6, problem%bodies(i)%nodes()))
      call body_stress(problem, i, u, matrices, error, stress)
      if (allocated(error)) return
      if (largest_of(stress) > most) then
        most = largest_of(stress)
        b = i
        node = maxloc(von_mises(stress), 1)
      end if
      deallocate (matrices, stress)
    end do
  end subroutine worst_node

  !> Signed von Mises stress of a weighted sum of the stresses of nodes of one place of the meridian under small displacements, and
  !> its derivatives.
  subroutine node_stress(problem, b, nodes, weights, u, value, error, slope)
    type(problem_t), intent(in) :: problem             !< bodies
    integer, intent(in) :: b, nodes(:)                 !< body, and which of its nodes
    real(dp), intent(in) :: weights(:)                 !< of their stresses
    real(dp), intent(in) :: u(:, :)                    !< displacements (3, n) [m]
    real(dp), intent(out) :: value                     !< [Pa]
    type(error_t), allocatable, intent(out) :: error   !< inverted element
    real(dp), intent(inout), optional :: slope(:, :)   !< gets them added (3, n) [Pa/m]
    real(dp), allocatable :: at_points(:, :), at_nodes(:, :), by_u(:, :, :)
    integer, allocatable :: list(:, :, :), meets(:)
    real(dp) :: s(6, 1)
    integer :: cell, i, j, k, n
    associate (body => problem%bodies(b), m => problem%bodies(b)%nodes_per_sector)
      n = size(body%cells, 1)
      meets = pack([(i, i=1, size(body%cells))], modulo([body%cells] - nodes(1), m) == 0)
      allocate (at_points(6*points, 3*n), at_nodes(6*n, 3*n), by_u(6, 3*n, size(meets)), list(n, size(meets), size(nodes)))
      do i = 1, size(meets)
        cell = (meets(i) - 1)/n + 1
        k = meets(i) - n*(cell - 1)  ! the node is this one of the cell, in the sector that brings it there
        do j = 1, size(nodes)
          list(:, i, j) = cell_nodes(body, cell, (nodes(j) - 1)/m - (body%cells(k, cell) - 1)/m) + problem%first(b)
        end do
        call cell_matrices(body, cell, at_points, at_nodes, error)
        if (allocated(error)) return
        by_u(:, :, i) = at_nodes(6*k - 5:6*k, :)/size(meets)
      end do
    end associate
    s = 0
    do j = 1, size(nodes)
      s(:, 1) = s(:, 1) + weights(j)*matmul(reshape(by_u, [6, 3*n*size(meets)]), reshape(u(:, [list(:, :, j)]), [3*n*size(meets)]))
    end do
    value = sum(signed_equivalent(s))
    if (.not. present(slope)) return
    do j = 1, size(nodes)
      do i = 1, size(meets)
        slope(:, list(:, i, j)) = slope(:, list(:, i, j)) + weights(j)* &
          reshape(matmul([3*s(:3, 1) - sum(s(:3, 1)), 6*s(4:, 1)]/(2*value), by_u(:, :, i)), [3, n])
      end do
    end do
  end subroutine node_stress

  !> Stresses of a body of a problem. Of explicit shape: an absent array has no descriptor to be read.
  subroutine body_stress(problem, b, u, matrices, error, stress, peak)
    type(problem_t), intent(in) :: problem            !< bodies
    integer, intent(in) :: b                          !< which
    real(dp), intent(in) :: u(:, :)                   !< displacements of all (3, n) [m]
    type(stress_matrices_t), intent(inout) :: matrices   !< of the body, made if there are none
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp), intent(out) :: stress(6, problem%bodies(b)%nodes())  !< at the nodes [Pa]
    real(dp), intent(out), optional :: peak(6, size(problem%bodies(b)%cells, 2)*problem%bodies(b)%sectors)  !< at the Gauss point
                                                      !< of every cell of all sectors where von Mises' stress is largest [Pa]
    associate (body => problem%bodies(b), low => problem%first(b) + 1, high => problem%first(b) + problem%bodies(b)%nodes())
      if (allocated(problem%lagrangian)) then
        call nodal_stress(body, u(:, low:high), matrices, error, stress, peak, problem%lagrangian(b))
      else
        call nodal_stress(body, u(:, low:high), matrices, error, stress, peak)
      end if
    end associate
  end subroutine body_stress

  !> Stresses of a revolved body. A thread takes some sectors with all their cells. The sector before has part in stresses at their
  !> first nodes: it is evaluated again, and added last where it is the body's last one, whoever makes the others.
  subroutine nodal_stress(body, u, matrices, error, stress, peak, lagrangian)
    type(body_t), intent(in) :: body                  !< body
    real(dp), intent(in) :: u(:, :)                   !< its displacements (3, nodes) [m]
    type(stress_matrices_t), intent(inout) :: matrices   !< made if there are none
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp), intent(out) :: stress(:, :)             !< at the nodes (6, nodes) [Pa]
    real(dp), intent(out), optional :: peak(:, :)     !< at the Gauss point of every cell where von Mises' stress is largest
                                                      !< (6, cells of all sectors) [Pa]
    type(total_lagrangian_t), intent(in), optional :: lagrangian  !< its cells, if displacements may be large
    real(dp), allocatable :: s(:, :, :), t(:, :, :)
    integer :: list(nodes_per_element(body%kind)), meets(body%nodes_per_sector), a, cell, first, i, k, last
    integer :: threads
    if (.not. (present(lagrangian) .or. allocated(matrices%at_points))) call find_matrices(body, matrices, error)
    if (allocated(error)) return
    meets = 0
    do i = 1, size(body%cells)
      a = modulo(body%cells(modulo(i - 1, size(list)) + 1, (i - 1)/size(list) + 1) - 1, size(meets)) + 1
      meets(a) = meets(a) + 1
    end do
    threads = blas_threads(1)  ! in each of ours
    associate (m => body%nodes_per_sector, cells => size(body%cells, 2))
      !$omp parallel do schedule(static, 1) private(s, t, list, a, cell, i, k, last) &
      !$omp if(body%nodes() > many_nodes)
      do first = 1, body%sectors, chunk
        last = min(body%sectors, first + chunk - 1)
        allocate (s(6, points, last - first + 2), t(6, size(list), last - first + 2))
        stress(:, (first - 1)*m + 1:last*m) = 0
        do cell = 1, cells
          call cell_stresses(body, cell, first - 1, u, matrices, present(peak), s, t, lagrangian)
          do k = 2, merge(size(s, 3), 1, present(peak))
            peak(:, (first + k - 3)*cells + cell) = s(:, maxloc(von_mises(s(:, :, k)), 1), k)
          end do
          do i = 1, size(s, 3)
            k = i
            if (first == 1) k = modulo(i, size(s, 3)) + 1
            list = body%cells(:, cell) + (first + k - 3)*m
            do a = 1, size(list)
              if (list(a) > (first - 1)*m .and. list(a) <= last*m) stress(:, list(a)) = stress(:, list(a)) + t(:, a, k)
            end do
          end do
        end do
        do i = (first - 1)*m + 1, last*m
          stress(:, i) = stress(:, i)/max(1, meets(modulo(i - 1, m) + 1))
        end do
        deallocate (s, t)
      end do
      !$omp end parallel do
    end associate
    threads = blas_threads(threads)
  end subroutine nodal_stress

  !> Stresses of a cell of a sector and of those like it in the next ones at once: they have the same matrices.
  subroutine cell_stresses(body, cell, first, u, matrices, pointwise, s, t, lagrangian)
    type(body_t), intent(in) :: body                  !< body
    integer, intent(in) :: cell                       !< cell
    integer, intent(in) :: first                      !< sector, from 1; 0: the last one
    real(dp), intent(in) :: u(:, :)                   !< displacements of the body (3, nodes) [m]
    type(stress_matrices_t), intent(in) :: matrices   !< of all cells
    logical, intent(in) :: pointwise                  !< s is wanted
    real(dp), intent(out), contiguous :: s(:, :, :)   !< at the Gauss points (6, points, sectors) [Pa]
    real(dp), intent(out), contiguous :: t(:, :, :)   !< at the nodes (6, nodes, sectors) [Pa]
    type(total_lagrangian_t), intent(in), optional :: lagrangian  !< as of nodal_stress
    integer :: list(nodes_per_element(body%kind)), sector, a, n
    real(dp) :: to_nodes(size(list), points)
    real(dp) :: v(3, size(list), size(s, 3))
    n = size(s, 3)
    list = cell_nodes(body, cell, first - 1)
    do sector = 1, n
      v(:, :, sector) = u(:, list)
      list = list + body%nodes_per_sector
      where (list > body%nodes()) list = list - body%nodes()
    end do
    if (present(lagrangian)) then
      to_nodes = extrapolation(size(list))
      list = cell_nodes(body, cell, 0)
      call cell_stress(lagrangian%cells(cell), v, s)
      do sector = 1, n
        do a = 1, size(list)
          t(:, a, sector) = turned(matmul(s(:, :, sector), to_nodes(a, :)), frame(body%angle(list(a))))
        end do
      end do
      return
    end if
    if (pointwise) call dgemm('N', 'N', 6*points, n, 3*size(list), 1._dp, matrices%at_points(:, :, cell), 6*points, v, &
      3*size(list), 0._dp, s, 6*points)
    call dgemm('N', 'N', 6*size(list), n, 3*size(list), 1._dp, matrices%at_nodes(:, :, cell), 6*size(list), v, 3*size(list), &
      0._dp, t, 6*size(list))
  end subroutine cell_stresses

  !> Those of all cells.
  subroutine find_matrices(body, matrices, error)
    type(body_t), intent(in) :: body                  !< body
    type(stress_matrices_t), intent(inout) :: matrices   !< gets them
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    type(error_t), allocatable :: failed
    integer :: cell
    associate (n => nodes_per_element(body%kind), cells => size(body%cells, 2))
      allocate (matrices%at_points(6*points, 3*n, cells), matrices%at_nodes(6*n, 3*n, cells))
    end associate
    !$omp parallel do schedule(static) private(failed) if(body%nodes() > many_nodes)
    do cell = 1, size(body%cells, 2)
      call cell_matrices(body, cell, matrices%at_points(:, :, cell), matrices%at_nodes(:, :, cell), failed)
      if (.not. allocated(failed)) cycle
      !$omp critical (failed_cell)
      error = failed
      !$omp end critical (failed_cell)
    end do
    !$omp end parallel do
  end subroutine find_matrices

  !> Stresses of a cell per displacement of its nodes.
  subroutine cell_matrices(body, cell, at_points, at_nodes, error)
    type(body_t), intent(in) :: body                  !< body
    integer, intent(in) :: cell                       !< cell of the first sector
    real(dp), intent(out) :: at_points(:, :)          !< Cartesian, at the Gauss points (6 points, 3 nodes) [Pa/m]
    real(dp), intent(out) :: at_nodes(:, :)           !< cylindrical, at the nodes (6 nodes, 3 nodes) [Pa/m]
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    integer :: list(nodes_per_element(body%kind)), a, i, p
    real(dp) :: c(6, 6), g(size(list), 3, points), weight(points), b(3*size(list), 6), to_nodes(size(list), points)
    real(dp) :: strain(6*points, 3*size(list))
    real(dp), allocatable :: modes(:, :)
    real(dp) :: turn(6, 6), q(3, 3)
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
      do i = 1, 6
        turn(:, i) = turned([(merge(1._dp, 0._dp, p == i), p=1, 6)], q)
      end do
      at_nodes(6*a - 5:6*a, :) = 0
      do p = 1, points
        at_nodes(6*a - 5:6*a, :) = at_nodes(6*a - 5:6*a, :) + to_nodes(a, p)*at_points(6*p - 5:6*p, :)
      end do
      at_nodes(6*a - 5:6*a, :) = matmul(turn, at_nodes(6*a - 5:6*a, :))
    end do
  end subroutine cell_matrices

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
    integer :: i
    do i = 1, size(v)
      v(i) = sqrt(square_of(s(:, i)))
    end do
  end function von_mises

  !> The largest of columns [Pa].
  pure real(dp) function largest_of(s) result(most)
    real(dp), intent(in) :: s(:, :)  !< (6, n) [Pa]
    integer :: i
    most = 0
    do i = 1, size(s, 2)
      most = max(most, square_of(s(:, i)))
    end do
    most = sqrt(most)
  end function largest_of

  !> Square of von Mises' stress [Pa^2].
  pure real(dp) function square_of(s) result(square)
    real(dp), intent(in) :: s(6)  !< [Pa]
    square = ((s(1) - s(2))**2 + (s(2) - s(3))**2 + (s(3) - s(1))**2)/2 + 3*(s(4)**2 + s(5)**2 + s(6)**2)
  end function square_of

  !> Mean stress, and second and third invariant of the deviator.
  pure subroutine find_invariants(s, mean, j2, j3)
    real(dp), intent(in) :: s(6)           !< [Pa]
    real(dp), intent(out) :: mean, j2, j3  !< [Pa], [Pa^2], [Pa^3]
    real(dp) :: d(6)
    mean = sum(s(:3))/3
    d = [s(:3) - mean, s(4:)]
    j2 = sum(d(:3)**2)/2 + sum(d(4:)**2)
    j3 = d(1)*(d(2)*d(3) - d(5)**2) - d(4)*(d(4)*d(3) - d(5)*d(6)) + d(6)*(d(4)*d(5) - d(2)*d(6))
  end subroutine find_invariants

  !> Principal stresses, largest first, by the angle of the deviator [Pa].
  function principal_stresses(s) result(p)
    real(dp), intent(in) :: s(:, :)  !< (6, n) [Pa]
    real(dp) :: p(3, size(s, 2)), mean, j2, j3, angle
    integer :: i
    !$omp parallel do schedule(static) private(mean, j2, j3, angle) if(size(s, 2) > many_nodes)
    do i = 1, size(s, 2)
      call find_invariants(s(:, i), mean, j2, j3)
      p(:, i) = mean
      if (.not. j2 > 0) cycle
      angle = acos(max(-1._dp, min(1._dp, 1.5_dp*sqrt(3._dp)*j3/j2**1.5_dp)))/3
      p(:, i) = mean + 2*sqrt(j2/3)*[cos(angle), cos(angle - 2*pi/3), cos(angle + 2*pi/3)]
    end do
    !$omp end parallel do
  end function principal_stresses

  !> Von Mises stress with the sign of the principal stress of the largest amount, which is that of the largest and the smallest
  !> together: of twice the mean less the deviator's middle root [Pa].
  function signed_equivalent(s) result(v)
    real(dp), intent(in) :: s(:, :)  !< (6, n) [Pa]
    real(dp) :: v(size(s, 2)), mean, j2, j3, twice
    integer :: i
    !$omp parallel do schedule(static) private(mean, j2, j3, twice) if(size(s, 2) > many_nodes)
    do i = 1, size(v)
      v(i) = sqrt(square_of(s(:, i)))
      call find_invariants(s(:, i), mean, j2, j3)
      twice = 2*mean
      if (3*twice**2 > j2) then  ! beyond that root in any case
        if (twice < 0) v(i) = -v(i)
      else if (twice*(twice**2 - j2) - j3 > 0) then  ! between the outer roots the cubic falls
        v(i) = -v(i)
      end if
    end do
    !$omp end parallel do
  end function signed_equivalent
end module hd_stress
