! SPDX-License-Identifier: GPL-3.0-or-later
!> Energy that bodies, springs and struts store: what a loop's work less its friction must equal.
module hd_energy
  use hd_kinds, only: dp
  use hd_groove, only: groove_energy
  use hd_problem, only: problem_t, load_t, elastic_forces, forces_at, strain_energy, strut_closings
  use hd_strut, only: strut_energy
  implicit none
  private
  public :: stored_energy

contains

  !> Energy that bodies, springs, whose far ends a load may move radially, and struts store [J].
  real(dp) function stored_energy(problem, load, u) result(e)
    type(problem_t), intent(in) :: problem  !< problem with struts
    type(load_t), intent(in) :: load        !< load
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    real(dp), allocatable :: closing(:), force(:), f(:, :)
    integer :: n
    closing = strut_closings(problem, load, u)
    if (allocated(problem%lagrangian)) then
      e = strain_energy(problem, u) + sum(problem%spring*u**2)/2
    else
      allocate (f, mold=u)
      call elastic_forces(problem, u, f)
      e = sum(u*f)/2
    end if
    e = e + sum(problem%spring(1, :)*load%displacement(1, :)*(load%displacement(1, :)/2 - u(1, :)))
    force = forces_at(problem, load, closing)
    n = size(closing)
    if (allocated(problem%rub)) n = n - size(problem%rub%partner)
    e = e + sum(strut_energy(problem%struts(:n), closing(:n))) + sum(force(n + 1:)**2/(2*problem%struts(n + 1:)%rate))
    if (allocated(problem%groove)) e = e + groove_energy(problem%groove, problem%struts, closing)
    if (.not. allocated(problem%strut_give)) return
    e = e + dot_product(force, matmul(problem%strut_give, force))/2
  end function stored_energy
end module hd_energy
