! SPDX-License-Identifier: GPL-3.0-or-later
!> Large rotations: every element keeps its linear stiffness in a frame that turns with it (corotational description).
!>
!> F = sum x_a (x) g_a is the deformation gradient at the centre of the element, F = R U its polar decomposition. With
!> x^_a = R^T x_a the element is strained by d_a = x^_a - X_a and stores W = d.K d / 2. Forces and tangent are the exact first
!> and second derivatives of W: with R's turn  dw = A^-1 sum g_a x dx^_a,  A = tr(U) 1 - U  (all in the element's frame),
!>   h_a = n_a - y x g_a,   n = K d,   A y = sum x^_a x n_a,   f_a = R h_a.
!> So the tangent is symmetric, rigid turns are free of force, and small displacements give back the linear element whatever
!> its kind. Strains are small by assumption (steel: below 0.5 %), rotations are not.
module hd_corotation
  use hd_kinds, only: dp
  use hd_body, only: body_t, cell_nodes, frame
  use hd_error, only: error_t
  use hd_hexahedron, only: element_stiffness, elasticity_matrix, nodes_per_element, centre_gradient
  implicit none
  private
  public :: corotation_t, new_corotation, cell_response, element_response

  !> Cells of the first sector of a body, in Cartesian dofs.
  type :: corotation_t
    real(dp), allocatable :: ke(:, :, :)  !< stiffness (3 nodes, 3 nodes, cells) [N/m]
    real(dp), allocatable :: g(:, :, :)   !< gradients at the centre (3, nodes, cells) [1/m]
  end type corotation_t

contains

  !> Stiffness and centre gradients of the cells of a body.
  subroutine new_corotation(body, corotation, error)
    type(body_t), intent(in) :: body                  !< body
    type(corotation_t), intent(out) :: corotation     !< its cells
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp) :: c(6, 6)
    integer :: cell, n, list(nodes_per_element(body%kind))
    n = size(list)
    allocate (corotation%ke(3*n, 3*n, size(body%cells, 2)), corotation%g(3, n, size(body%cells, 2)))
    c = elasticity_matrix(body%young, body%poisson)
    do cell = 1, size(body%cells, 2)
      list = cell_nodes(body, cell, 0)
      call element_stiffness(body%kind, body%x(:, list), c, corotation%ke(:, :, cell), error)
      if (allocated(error)) return
      corotation%g(:, :, cell) = centre_gradient(body%kind, body%x(:, list))
    end do
  end subroutine new_corotation

  !> Forces and tangent of a cell of any sector, in the dofs of its nodes.
  pure subroutine cell_response(body, corotation, cell, u, f, tangent)
    type(body_t), intent(in) :: body                !< body
    type(corotation_t), intent(in) :: corotation    !< its cells
    integer, intent(in) :: cell                     !< cell of the first sector; the others see the same in their frame
    real(dp), intent(in) :: u(:, :)                 !< displacements of its nodes (3, nodes) [m]
    real(dp), intent(out) :: f(:, :)                !< forces (3, nodes) [N]
    real(dp), intent(out), optional :: tangent(:, :) !< (3 nodes, 3 nodes) [N/m]
    real(dp) :: q(3, 3, size(u, 2)), v(3, size(u, 2))
    integer :: list(size(u, 2)), a, i
    list = cell_nodes(body, cell, 0)
    do a = 1, size(list)
      q(:, :, a) = frame(body%angle(list(a)))
      v(:, a) = matmul(q(:, :, a), u(:, a))
    end do
    call element_response(body%x(:, list), corotation%g(:, :, cell), corotation%ke(:, :, cell), v, f, tangent)
    do a = 1, size(list)
      f(:, a) = matmul(f(:, a), q(:, :, a))
      if (.not. present(tangent)) cycle
      i = 3*(a - 1)
      tangent(:, i + 1:i + 3) = matmul(tangent(:, i + 1:i + 3), q(:, :, a))
      tangent(i + 1:i + 3, :) = matmul(transpose(q(:, :, a)), tangent(i + 1:i + 3, :))
    end do
  end subroutine cell_response

  !> Forces and tangent of one element in Cartesian components.
  pure subroutine element_response(x0, g, ke, u, f, tangent)
    real(dp), intent(in) :: x0(:, :)                 !< node coordinates (3, nodes) [m]
    real(dp), intent(in) :: g(:, :)                  !< gradients at the centre (3, nodes) [1/m]
    real(dp), intent(in) :: ke(:, :)                 !< linear stiffness [N/m]
    real(dp), intent(in) :: u(:, :)                  !< displacements (3, nodes) [m]
    real(dp), intent(out) :: f(:, :)                 !< forces (3, nodes) [N]
    real(dp), intent(out), optional :: tangent(:, :) !< (3 nodes, 3 nodes) [N/m]
    real(dp) :: rest(3, size(u, 2)), x(3, size(u, 2)), d(3, size(u, 2)), n(3, size(u, 2)), h(3, size(u, 2))
    real(dp) :: r(3, 3), stretch(3, 3), a_inv(3, 3), y(3), gradient(3, 3)
    integer :: a
    rest = x0 - spread(sum(x0, 2)/size(x0, 2), 2, size(x0, 2))
    x = rest + u - spread(sum(u, 2)/size(u, 2), 2, size(u, 2))
    gradient = matmul(x, transpose(g))
    call polar(gradient, r)
    stretch = matmul(transpose(r), gradient)
    x = matmul(transpose(r), x)
    d = x - rest
    n = reshape(matmul(ke, reshape(d, [size(d)])), shape(n))
    a_inv = -stretch
    do a = 1, 3
      a_inv(a, a) = a_inv(a, a) + stretch(1, 1) + stretch(2, 2) + stretch(3, 3)
    end do
    a_inv = inverse(a_inv)
    y = 0
    do a = 1, size(u, 2)
      y = y + cross(x(:, a), n(:, a))
    end do
    y = matmul(a_inv, y)
    do a = 1, size(u, 2)
      h(:, a) = n(:, a) - cross(y, g(:, a))
    end do
    f = matmul(r, h)
    if (present(tangent)) call turn_tangent(ke, g, x, n, h, y, r, stretch, a_inv, tangent)
  end subroutine element_response

  !> Second derivative of the stored energy; all vectors in the element's frame, the result in the global one.
  pure subroutine turn_tangent(ke, g, x, n, h, y, r, stretch, a_inv, tangent)
    real(dp), intent(in) :: ke(:, :), g(:, :), x(:, :), n(:, :), h(:, :), y(3), r(3, 3), stretch(3, 3), a_inv(3, 3)
    real(dp), intent(out) :: tangent(:, :)
    real(dp) :: spin(3, size(ke, 1)), dy(3, size(ke, 1)), dd(size(ke, 1), size(ke, 1))
    integer :: a, b, i, j
    do a = 1, size(g, 2)
      spin(:, 3*a - 2:3*a) = matmul(a_inv, skew(g(:, a)))
    end do
    dd = 0
    do a = 1, size(g, 2)
      i = 3*(a - 1)
      dd(i + 1:i + 3, :) = matmul(skew(x(:, a)), spin)
      do j = 1, 3
        dd(i + j, i + j) = dd(i + j, i + j) + 1
      end do
    end do
    tangent = matmul(ke, dd)
    dy = matmul(skew(matmul(stretch, y)), spin)
    do a = 1, size(g, 2)
      i = 3*(a - 1)
      dy = dy - matmul(skew(n(:, a)), dd(i + 1:i + 3, :)) + matmul(skew(x(:, a)), tangent(i + 1:i + 3, :))
      do j = 1, 3
        dy(:, i + j) = dy(:, i + j) - y*g(j, a)
        dy(j, i + j) = dy(j, i + j) + dot_product(g(:, a), y)
      end do
    end do
    dy = matmul(a_inv, dy)
    do a = 1, size(g, 2)
      i = 3*(a - 1)
      tangent(i + 1:i + 3, :) = tangent(i + 1:i + 3, :) + matmul(skew(g(:, a)), dy) - matmul(skew(h(:, a)), spin)
    end do
    do b = 1, size(g, 2)
      j = 3*(b - 1)
      tangent(:, j + 1:j + 3) = matmul(tangent(:, j + 1:j + 3), transpose(r))
      tangent(j + 1:j + 3, :) = matmul(r, tangent(j + 1:j + 3, :))
    end do
  end subroutine turn_tangent

  !> Rotation of the polar decomposition, by Newton's iteration (Higham 1986).
  pure subroutine polar(f, r)
    real(dp), intent(in) :: f(3, 3)   !< deformation gradient
    real(dp), intent(out) :: r(3, 3)  !< rotation
    real(dp) :: next(3, 3)
    integer :: k
    r = f
    do k = 1, 30
      next = 0.5_dp*(r + transpose(inverse(r)))
      r = next - r
      if (maxval(abs(r)) < 1e-14_dp) exit
      r = next
    end do
    r = next
  end subroutine polar

  !> Inverse of a 3 x 3 matrix.
  pure function inverse(a) result(b)
    real(dp), intent(in) :: a(3, 3)  !< matrix
    real(dp) :: b(3, 3)
    b(1, :) = cross(a(:, 2), a(:, 3))
    b(2, :) = cross(a(:, 3), a(:, 1))
    b(3, :) = cross(a(:, 1), a(:, 2))
    b = b/dot_product(a(:, 1), b(1, :))
  end function inverse

  !> Matrix of the cross product with a vector.
  pure function skew(v) result(s)
    real(dp), intent(in) :: v(3)  !< vector
    real(dp) :: s(3, 3)
    s = reshape([0._dp, v(3), -v(2), -v(3), 0._dp, v(1), v(2), -v(1), 0._dp], [3, 3])
  end function skew

  !> Cross product.
  pure function cross(a, b) result(c)
    real(dp), intent(in) :: a(3), b(3)  !< vectors
    real(dp) :: c(3)
    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross
end module hd_corotation
