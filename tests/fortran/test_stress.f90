! SPDX-License-Identifier: GPL-3.0-or-later
!> Stresses at Gauss points and nodes.
module test_stress
  use hd_body, only: body_t
  use hd_check, only: check, check_close
  use hd_error, only: error_t
  use hd_hexahedron, only: hex8, hex8i, hex20r
  use hd_kinds, only: dp
  use hd_revolution, only: revolve, strip_t
  use hd_stress, only: largest_of, nodal_stress, stress_matrices_t, principal_stresses, signed_equivalent, von_mises
  implicit none
  private
  public :: run_stress

contains

  subroutine run_stress()
    real(dp) :: s(6, 2), p(3, 2), many(6, 200), principal(3, 200)
    integer :: i, j
    call even_field(hex8)
    call even_field(hex8i)
    call even_field(hex20r)
    s(:, 1) = [3._dp, -1._dp, 2._dp, 0._dp, 0._dp, 0._dp]
    s(:, 2) = [0._dp, 0._dp, 0._dp, 5._dp, 0._dp, 0._dp]
    p = principal_stresses(s)
    call check_close(maxval(abs(p - reshape([3._dp, 2._dp, -1._dp, 5._dp, 0._dp, -5._dp], [3, 2]))), 0._dp, 1e-12_dp, &
      'principal stresses of a diagonal tensor and of pure shear')
    call check_close(maxval(abs(von_mises(s) - [sqrt(13._dp), 5*sqrt(3._dp)])), 0._dp, 1e-12_dp, 'von Mises stresses')
    many = reshape([((sin(1.7_dp*i*j) - 0.3_dp*sin(0.9_dp*j), i=1, 6), j=1, 200)], [6, 200])
    principal = principal_stresses(many)
    call check(all((signed_equivalent(many) > 0) .eqv. (maxval(principal, 1) + minval(principal, 1) > 0)), &
      'the principal stress of the largest amount gives the equivalent one its sign')
  end subroutine run_stress

  !> A linear displacement field u_x = a x, u_z = b z of a cylinder has the same Cartesian stress everywhere.
  subroutine even_field(kind)
    integer, intent(in) :: kind
    real(dp), parameter :: a = 2e-4_dp, b = -1e-4_dp
    type(strip_t) :: strip
    type(body_t) :: body
    type(stress_matrices_t) :: matrices
    type(error_t), allocatable :: error
    real(dp), allocatable :: u(:, :), stress(:, :), peak(:, :), expected(:, :)
    real(dp) :: xx, yy, zz, factor
    strip%inner = reshape([10._dp, 0._dp, 10._dp, 2._dp, 10.5_dp, 5._dp], [2, 3])
    strip%outer = reshape([12._dp, 0.2_dp, 11.5_dp, 2.2_dp, 12._dp, 5._dp], [2, 3])
    strip%layers = 2
    call revolve(strip, 24, kind, body)
    body%young = 200
    body%poisson = 0.3_dp
    allocate (u(3, body%nodes()), stress(6, body%nodes()), expected(6, body%nodes()), &
      peak(6, body%sectors*size(body%cells, 2)))
    u(1, :) = a*body%x(1, :)*cos(body%angle)
    u(2, :) = -a*body%x(1, :)*sin(body%angle)
    u(3, :) = b*body%x(3, :)
    call nodal_stress(body, u, matrices, error, stress, peak)
    factor = body%young/((1 + body%poisson)*(1 - 2*body%poisson))
    xx = factor*((1 - body%poisson)*a + body%poisson*b)
    yy = factor*body%poisson*(a + b)
    zz = factor*((1 - body%poisson)*b + body%poisson*a)
    associate (c => cos(body%angle), s => sin(body%angle))
      expected = 0
      expected(1, :) = xx*c**2 + yy*s**2
      expected(2, :) = xx*s**2 + yy*c**2
      expected(3, :) = zz
      expected(4, :) = (yy - xx)*s*c
    end associate
    call check_close(maxval(abs(stress - expected))/abs(zz), 0._dp, 1e-11_dp, 'an even field has one stress at all nodes')
    call check_close(maxval(abs(von_mises(peak)/sqrt(((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2)/2) - 1)), 0._dp, 1e-11_dp, &
      'and at all Gauss points')
    call check_close(largest_of(stress)/maxval(von_mises(stress)), 1._dp, 1e-15_dp, 'the largest is that of all nodes')
  end subroutine even_field
end module test_stress
