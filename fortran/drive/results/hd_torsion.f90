! SPDX-License-Identifier: GPL-3.0-or-later
!> Torsional stiffness of the contact by Eq. 45, put right and as printed; and how much of it lies on points that slip.
module hd_torsion
  use hd_kinds, only: dp
  implicit none
  private
  public :: facet_weights, printed_weights

contains

  !> K_TS = sum_i w_n K_N + w_t K_T  ([Eq. 45] put right): w_n = lever^2, w_t = rho^2 - lever^2, lever = e_z . (r x n) [m^2].
  pure subroutine facet_weights(x, normal, w_n, w_t)
    real(dp), intent(in) :: x(:, :)               !< centres (3, facets) [m]
    real(dp), intent(in) :: normal(:, :)          !< outward unit normals (3, facets)
    real(dp), intent(out) :: w_n(:), w_t(:)       !< (facets) [m^2]
    w_n = (x(1, :)*normal(2, :) - x(2, :)*normal(1, :))**2
    w_t = x(1, :)**2 + x(2, :)**2 - w_n
  end subroutine facet_weights

  !> [Eq. 45] as printed: sum_i w_n K_N + w_t K_T in newtons, with w_n = sin(alpha) cos(beta) R_a, w_t = cos(alpha) cos(beta) R_a,
  !> the diameter R_a = 2 rho and beta = arctan(cot theta + a/b).
  pure subroutine printed_weights(theta, r, w, slope, w_n, w_t)
    real(dp), intent(in) :: theta(:)              !< eccentric angles (facets) [rad]
    real(dp), intent(in) :: r, w                  !< semi-axes are r + w and r - w [m]
    real(dp), intent(in) :: slope                 !< tan(alpha) of the cone
    real(dp), intent(out) :: w_n(:), w_t(:)       !< (facets) [m]
    real(dp), dimension(size(theta)) :: s, c, part
    real(dp) :: a, b
    a = r + w
    b = r - w
    s = sin(theta)
    c = cos(theta)
    part = abs(s)*b/hypot(b*s, b*c + a*s)*2*hypot(a*c, b*s)
    w_n = slope/hypot(1._dp, slope)*part
    w_t = part/hypot(1._dp, slope)
  end subroutine printed_weights
end module hd_torsion
