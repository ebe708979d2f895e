! SPDX-License-Identifier: GPL-3.0-or-later
!> Stresses at Gauss points and nodes, and the cycle that they make in a turn.
module test_stress
  use hd_body, only: body_t
  use hd_check, only: check, check_close
  use hd_error, only: error_t
  use hd_fatigue, only: fatigue_t, judge_fatigue
  use hd_hexahedron, only: hex8, hex8i, hex20r
  use hd_kinds, only: dp, pi
  use hd_revolution, only: revolve, strip_t
  use hd_scene, only: scene_t
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
    call cycles(many)
  end subroutine run_stress

  !> Bending that alternates beside a steady shear: its amplitude, and the shear as mean. Of any stresses the two furthest apart.
  subroutine cycles(many)
    real(dp), intent(in) :: many(:, :)
    real(dp), parameter :: bending = 200e6_dp, shear = 30e6_dp
    type(scene_t) :: scene
    type(body_t) :: body
    type(fatigue_t) :: fatigue, other
    real(dp) :: s(6, 2, 100), most
    integer :: i, j
    body%nodes_per_sector = 2
    body%sectors = size(s, 3)
    allocate (body%x(3, 2*size(s, 3)))
    scene%notch_factor = 1.4_dp
    s = 0
    do i = 1, size(s, 3)
      s(2, 1, i) = bending*cos(4*pi*i/size(s, 3))
      s(5, 1, i) = shear
      s(5, 2, i) = shear
    end do
    call judge_fatigue(scene, body, reshape(s, [6, 2*size(s, 3)]), 1._dp, fatigue)
    call check_close(maxval(abs(fatigue%amplitude - [bending, 0._dp])/bending), 0._dp, 1e-12_dp, &
      'the amplitude is that of the bending, whatever shear stands beside it')
    call check_close(maxval(abs(fatigue%mean - sqrt(3._dp)*shear)/shear), 0._dp, 1e-12_dp, 'and the shear is the mean')
    call check_close(1/fatigue%safety(1), 1.4_dp*bending/scene%fatigue_limit + sqrt(3._dp)*shear/scene%tensile_strength, 1e-12_dp, &
      "and safety is by Goodman's line")
    call check(all(modulo(fatigue%least - 1, 2) == 0), 'the first node of the meridian has the least safety')
    call judge_fatigue(scene, body, many, 1._dp, other)
    do j = 1, 2
      most = 0
      do i = 1, size(s, 3)
        most = max(most, maxval(von_mises(many(:, j::2) - spread(many(:, j + 2*(i - 1)), 2, size(s, 3)))))
      end do
      call check_close(other%amplitude(j), most/2, 1e-12_dp*most, 'no two stresses of a turn are further apart')
    end do
  end subroutine cycles

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
