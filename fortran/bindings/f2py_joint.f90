! SPDX-License-Identifier: GPL-3.0-or-later
! Flat entries for Python: the joint model. `p` holds e1, nu1, e2, nu2, nu_soft, hardness, D, G, gamma, r_m, mu, s_min, A_0
! 1 for the closure of the paper, and 1 for plastic spots that unload elastically.

!> Stiffness of facets; `derivatives` holds dK_N/dP, dK_T/dP, dK_T/dtau.
subroutine joint_facets(p, n, pressure, shear, area, k_n, k_t, s_l, derivatives, iterations, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_flat_joint, only: flat_joint
  use hd_joint, only: joint_t, response_t, evaluate_joint
  use hd_status, only: tell
  implicit none
  real(c_double), intent(in) :: p(15)
  integer(c_int), intent(in) :: n
  real(c_double), intent(in) :: pressure(n), shear(n), area(n)
  real(c_double), intent(out) :: k_n(n), k_t(n), s_l(n), derivatives(3, n)
  integer(c_int), intent(out) :: iterations(n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(pressure) :: n = len(pressure)
  !f2py threadsafe
  type(joint_t) :: joint
  type(response_t) :: r
  type(error_t), allocatable :: error
  integer :: i
  k_n = 0
  k_t = 0
  s_l = 0
  derivatives = 0
  iterations = 0
  call flat_joint(p, joint, error)
  if (.not. allocated(error)) then
    do i = 1, n
      call evaluate_joint(joint, pressure(i), shear(i), area(i), r)
      k_n(i) = r%k_n
      k_t(i) = r%k_t
      s_l(i) = r%s_l
      derivatives(:, i) = [r%dk_n_dp, r%dk_t_dp, r%dk_t_dtau]
      iterations(i) = r%iterations
    end do
  end if
  call tell(error, status, message)
end subroutine joint_facets

!> The joint of a scene as the engine makes it, in the order of `p`. `assignments` holds lines 'group.key=value'.
subroutine joint_of_scene(path, assignments, p, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_input, only: read_scene
  use hd_joint, only: joint_t
  use hd_scene, only: scene_t
  use hd_scene_joint, only: scene_joint
  use hd_status, only: tell, lines_of
  implicit none
  character(len=*), intent(in) :: path, assignments
  real(c_double), intent(out) :: p(15)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py threadsafe
  type(error_t), allocatable :: error
  type(scene_t), allocatable :: s
  type(joint_t) :: joint
  p = 0
  allocate (s)
  call read_scene(path, lines_of(assignments), s, error)
  if (.not. allocated(error)) call scene_joint(s, joint, error)
  if (.not. allocated(error)) p = [s%flexspline_e, s%flexspline_nu, s%ring_e, s%ring_nu, s%flexspline_nu, &
    joint%asperity%hardness, joint%d, s%roughness, s%gamma, joint%r_m, joint%mu, joint%s_min, joint%reference_area, &
    merge(1._c_double, 0._c_double, [joint%paper, joint%plastic])]
  call tell(error, status, message)
end subroutine joint_of_scene

!> Integrals of one surface at a given largest spot, by regime: load, normal and tangential stiffness; then psi, S_r.
subroutine joint_parts(p, s_l, tau, load, k_n, k_t, psi, s_r, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_flat_joint, only: flat_joint
  use hd_joint, only: joint_t, spots_at, joint_load, normal_stiffness, tangential_stiffness, real_area
  use hd_status, only: tell
  implicit none
  real(c_double), intent(in) :: p(15), s_l, tau
  real(c_double), intent(out) :: load(4), k_n(4), k_t(4), psi, s_r
  real(c_double) :: by_tau, by_spot
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  type(joint_t) :: joint
  type(error_t), allocatable :: error
  load = 0
  k_n = 0
  k_t = 0
  psi = 0
  s_r = 0
  call flat_joint(p, joint, error)
  if (.not. allocated(error)) then
    load = joint_load(joint, s_l)
    k_n = normal_stiffness(joint, s_l)
    call tangential_stiffness(joint, spots_at(joint, (s_l - joint%s_min)/joint%s_min), tau, k_t, by_tau, by_spot)
    psi = joint%psi
    s_r = real_area(joint, s_l)
  end if
  call tell(error, status, message)
end subroutine joint_parts

!> One asperity: properties (E, G', H, k, eta, R, eps_ec, s_ec, f_ec), by depth (s, f, k; smooth /= 0: blended) and by area
!> (f, k, k_t).
subroutine asperity(p, eps, s, tau, smooth, properties, by_depth, by_area)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_asperity, only: asperity_t, new_asperity, asperity_by_depth, asperity_by_area
  implicit none
  real(c_double), intent(in) :: p(15), eps, s, tau
  integer(c_int), intent(in) :: smooth
  real(c_double), intent(out) :: properties(9), by_depth(3), by_area(3)
  type(asperity_t) :: a
  a = new_asperity(p(1), p(2), p(3), p(4), p(5), p(6), p(7), p(8), p(9), p(10))
  properties = [a%e_star, a%g_prime, a%hardness, a%hardness_factor, a%amplitude, a%radius, a%eps_ec, a%s_ec, a%f_ec]
  call asperity_by_depth(a, eps, smooth /= 0, by_depth(1), by_depth(2), by_depth(3))
  call asperity_by_area(a, s, tau, p(11), by_area(1), by_area(2), by_area(3))
end subroutine asperity

!> Warnings of the joint model under the largest pressure, one per line.
subroutine joint_warnings(p, pressure, lines, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_flat_joint, only: flat_joint
  use hd_joint, only: joint_t
  use hd_joint_range, only: range_warnings
  use hd_status, only: tell, hand_over
  use hd_text, only: string_t, join
  implicit none
  real(c_double), intent(in) :: p(15), pressure
  character(len=8192), intent(out) :: lines
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  type(joint_t) :: joint
  type(string_t), allocatable :: list(:)
  type(error_t), allocatable :: error
  lines = ''
  call flat_joint(p, joint, error)
  if (.not. allocated(error)) then
    call range_warnings(joint, pressure, list)
    call hand_over(join(list, new_line('a')), lines)
  end if
  call tell(error, status, message)
end subroutine joint_warnings

!> Interface law: closure and k_N over pressure (inverse = 0), pressure and k_N over closure (inverse = 1).
subroutine joint_normal_law(p, zero_pressure, inverse, n, x, y, k, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_flat_joint, only: flat_joint
  use hd_interface_law, only: interface_law_t, new_interface_law, closure_at, pressure_at
  use hd_joint, only: joint_t
  use hd_status, only: tell
  implicit none
  real(c_double), intent(in) :: p(15), zero_pressure
  integer(c_int), intent(in) :: inverse, n
  real(c_double), intent(in) :: x(n)
  real(c_double), intent(out) :: y(n), k(n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(x) :: n = len(x)
  !f2py threadsafe
  type(joint_t) :: joint
  type(interface_law_t) :: law
  type(error_t), allocatable :: error
  y = 0
  k = 0
  call flat_joint(p, joint, error)
  if (.not. allocated(error)) call new_interface_law(joint, zero_pressure, law, error)
  if (.not. allocated(error)) then
    if (inverse == 0) call closure_at(law, x, y, k)
    if (inverse == 1) call pressure_at(law, x, y, k)
  end if
  call tell(error, status, message)
end subroutine joint_normal_law

!> Interface law: shear, k_T and slip (1 or 0) over pressure and tangential displacement.
subroutine joint_tangential_law(p, n, pressure, displacement, shear, k, slipping, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_flat_joint, only: flat_joint
  use hd_interface_law, only: interface_law_t, new_interface_law, shear_at
  use hd_joint, only: joint_t
  use hd_status, only: tell
  implicit none
  real(c_double), intent(in) :: p(15)
  integer(c_int), intent(in) :: n
  real(c_double), intent(in) :: pressure(n), displacement(n)
  real(c_double), intent(out) :: shear(n), k(n)
  integer(c_int), intent(out) :: slipping(n)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py integer(c_int), intent(hide), depend(pressure) :: n = len(pressure)
  !f2py threadsafe
  type(joint_t) :: joint
  type(interface_law_t) :: law
  type(error_t), allocatable :: error
  logical :: slips
  integer :: i
  shear = 0
  k = 0
  slipping = 0
  call flat_joint(p, joint, error)
  if (.not. allocated(error)) call new_interface_law(joint, 1._c_double, law, error)
  if (.not. allocated(error)) then
    do i = 1, n
      call shear_at(law, pressure(i), displacement(i), shear(i), k(i), slips)
      if (slips) slipping(i) = 1
    end do
  end if
  call tell(error, status, message)
end subroutine joint_tangential_law
