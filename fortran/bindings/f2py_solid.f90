! SPDX-License-Identifier: GPL-3.0-or-later
! Flat entries for Python: elastic bodies of the caller's own meshes, alone or in contact. Node numbers start at 1; body b
! owns nodes node_end(b-1)+1 to node_end(b) and cells cell_end(b-1)+1 to cell_end(b).

!> Linear statics.
subroutine solid_static(element, nb, nn, m, n, node_end, cell_end, material, x, angle, cells, fixed, displacement, force, &
  u, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_problem, only: problem_t
  use hd_solid, only: new_solid
  use hd_static, only: solve_static
  use hd_status, only: tell
  implicit none
  character(len=*), intent(in) :: element
  integer(c_int), intent(in) :: nb, nn, m, n
  integer(c_int), intent(in) :: node_end(nb), cell_end(nb), cells(nn, m), fixed(3, n)
  real(c_double), intent(in) :: material(2, nb), x(3, n), angle(n), displacement(3, n), force(3, n)
  real(c_double), intent(out) :: u(3, n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py threadsafe
  type(problem_t) :: problem
  type(error_t), allocatable :: error
  u = 0
  call new_solid(element, node_end, cell_end, material, x, angle, cells, problem, error)
  if (.not. allocated(error)) then
    problem%fixed = fixed /= 0
    call solve_static(problem, displacement, force, u, error)
  end if
  call tell(error, status, message)
end subroutine solid_static

!> Contact of two faces through a sequence of load steps. Fields of multipliers stand at their slave nodes, zero elsewhere.
!> `interface_data` holds friction, scale c [Pa/m], tolerance; history rows are step, iteration, residual, changes, open,
!> stick, slip.
subroutine solid_contact(element, nb, nn, m, n, node_end, cell_end, material, x, angle, cells, fixed, ns, nf, slave, &
  slave_chart, nm, master, master_chart, period, mode, interface_data, limit, steps, displacement, force, gap, rows, u, reaction, &
  traction, slip, opening, contact, area, history, used, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_face, only: face_t
  use hd_problem, only: problem_t
  use hd_solid, only: new_solid, new_interface, solid_steps
  use hd_status, only: tell
  implicit none
  character(len=*), intent(in) :: element, mode
  integer(c_int), intent(in) :: nb, nn, m, n, ns, nf, nm, limit, steps, rows
  integer(c_int), intent(in) :: node_end(nb), cell_end(nb), cells(nn, m), fixed(3, n), slave(ns, nf), master(ns, nm)
  real(c_double), intent(in) :: material(2, nb), x(3, n), angle(n), slave_chart(2, 4, nf), master_chart(2, 4, nm), period
  real(c_double), intent(in) :: interface_data(3), displacement(3, n, steps), force(3, n, steps), gap(n, steps)
  real(c_double), intent(out) :: u(3, n, steps), reaction(3, n, steps), traction(3, n, steps), slip(2, n, steps)
  real(c_double), intent(out) :: opening(n, steps), area(n), history(7, rows)
  integer(c_int), intent(out) :: contact(n, steps), used, status
  character(len=8192), intent(out) :: message
  !f2py threadsafe
  type(problem_t) :: problem
  type(error_t), allocatable :: error
  u = 0
  reaction = 0
  traction = 0
  slip = 0
  opening = 0
  contact = 0
  area = 0
  history = 0
  used = 0
  call new_solid(element, node_end, cell_end, material, x, angle, cells, problem, error)
  if (.not. allocated(error)) call new_interface(problem, face_t(slave, slave_chart, period), &
    face_t(master, master_chart, period), mode, interface_data(:2), error)
  if (.not. allocated(error)) then
    problem%fixed = fixed /= 0
    area(problem%mortar%node) = problem%mortar%area
    call solid_steps(problem, displacement, force, gap, interface_data(3), limit, u, reaction, traction, slip, opening, contact, &
      history, used, error)
  end if
  call tell(error, status, message)
end subroutine solid_contact
