! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: the joint model. `p` holds the parameters in the order of the list 'joint' (hd_named_values).
module f2py_joint
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_joint, only: joint_t, new_joint, response_t, evaluate_joint, spots_at, joint_load, normal_stiffness, &
    tangential_stiffness, real_area
  use hd_status, only: tell, lines_of, hand_over
  use hd_input, only: read_scene
  use hd_named_values, only: named_list_t
  use hd_scene, only: scene_t
  use hd_scene_joint, only: scene_joint
  use hd_asperity, only: asperity_t, new_asperity, asperity_by_depth, asperity_by_area
  use hd_joint_range, only: range_warnings
  use hd_text, only: string_t, join
  use hd_torsion, only: facet_weights, printed_weights
  use hd_joint_law, only: interface_law_t, new_interface_law, closure_at, pressure_at, shear_at
  implicit none
  private
  public :: joint_facets, joint_of_scene, joint_parts, asperity, joint_warnings, joint_normal_law, joint_tangential_law, &
    torsion_weights, torsion_weights_printed

contains

  !> Stiffness of facets; `derivatives` holds dK_N/dP, dK_T/dP, dK_T/dtau.
  subroutine joint_facets(p, np, n, pressure, shear, area, k_n, k_t, s_l, derivatives, iterations, status)
    integer(c_int), intent(in) :: np
    real(c_double), intent(in) :: p(np)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: pressure(n), shear(n), area(n)
    real(c_double), intent(out) :: k_n(n), k_t(n), s_l(n), derivatives(3, n)
    integer(c_int), intent(out) :: iterations(n)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(p) :: np = len(p)
    !f2py integer(c_int), intent(hide), depend(pressure) :: n = len(pressure)
    !f2py threadsafe
    type(joint_t) :: joint
    type(response_t) :: r
    type(error_t), allocatable :: error
    integer :: i
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
    call tell(error, status)
  end subroutine joint_facets

  !> The joint of a scene as the engine makes it. `assignments` holds lines 'group.key=value'.
  subroutine joint_of_scene(path, assignments, np, p, status)
    character(len=*), intent(in) :: path, assignments
    integer(c_int), intent(in) :: np
    real(c_double), intent(out) :: p(np)
    integer(c_int), intent(out) :: status
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(scene_t), allocatable :: s
    type(joint_t) :: joint
    type(named_list_t) :: names
    p = 0
    names%list = 'joint'
    allocate (s)
    call read_scene(path, lines_of(assignments), s, error)
    if (.not. allocated(error)) call scene_joint(s, joint, error)
    if (.not. allocated(error)) then
      call enter('e1', s%flexspline_e)
      call enter('nu1', s%flexspline_nu)
      call enter('e2', s%ring_e)
      call enter('nu2', s%ring_nu)
      call enter('nu_soft', s%flexspline_nu)
      call enter('hardness', joint%asperity%hardness)
      call enter('fractal_dimension', joint%d)
      call enter('roughness', s%roughness)
      call enter('gamma', s%gamma)
      call enter('asperity_radius', joint%r_m)
      call enter('friction', joint%mu)
      call enter('s_min', joint%s_min)
      call enter('reference_area', joint%reference_area)
      call enter('paper', merge(1._c_double, 0._c_double, joint%paper))
      call enter('plastic', merge(1._c_double, 0._c_double, joint%plastic))
      call names%check(error)
    end if
    call tell(error, status)
  contains
    subroutine enter(name, x)
      character(len=*), intent(in) :: name
      real(c_double), intent(in) :: x
      call names%put(p, name, x)
    end subroutine enter
  end subroutine joint_of_scene

  !> Integrals of one surface at a given largest spot, by regime: load, normal and tangential stiffness; then psi, S_r.
  subroutine joint_parts(p, np, s_l, tau, load, k_n, k_t, psi, s_r, status)
    integer(c_int), intent(in) :: np
    real(c_double), intent(in) :: p(np), s_l, tau
    real(c_double), intent(out) :: load(4), k_n(4), k_t(4), psi, s_r
    real(c_double) :: by_tau, by_spot
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(p) :: np = len(p)
    type(joint_t) :: joint
    type(error_t), allocatable :: error
    call flat_joint(p, joint, error)
    if (.not. allocated(error)) then
      load = joint_load(joint, s_l)
      k_n = normal_stiffness(joint, s_l)
      call tangential_stiffness(joint, spots_at(joint, (s_l - joint%s_min)/joint%s_min), tau, k_t, by_tau, by_spot)
      psi = joint%psi
      s_r = real_area(joint, s_l)
    end if
    call tell(error, status)
  end subroutine joint_parts

  !> One asperity: properties in the order of the list 'asperity', by depth (s, f, k) and by area (f, k, k_t).
  subroutine asperity(p, np, eps, s, tau, n, properties, by_depth, by_area, status)
    integer(c_int), intent(in) :: np
    real(c_double), intent(in) :: p(np), eps, s, tau
    integer(c_int), intent(in) :: n
    real(c_double), intent(out) :: properties(n), by_depth(3), by_area(3)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(p) :: np = len(p)
    type(asperity_t) :: a
    type(named_list_t) :: given, names
    type(error_t), allocatable :: error
    properties = 0
    given%list = 'joint'
    names%list = 'asperity'
    call flat_asperity(p, a, error)
    if (.not. allocated(error)) then
      call names%put(properties, 'e_star_pa', a%e_star)
      call names%put(properties, 'g_prime_pa', a%g_prime)
      call names%put(properties, 'hardness_pa', a%hardness)
      call names%put(properties, 'hardness_factor', a%hardness_factor)
      call names%put(properties, 'amplitude_m', a%amplitude)
      call names%put(properties, 'radius_m', a%radius)
      call names%put(properties, 'eps_ec_m', a%eps_ec)
      call names%put(properties, 's_ec_m2', a%s_ec)
      call names%put(properties, 'f_ec_n', a%f_ec)
      call asperity_by_depth(a, eps, by_depth(1), by_depth(2), by_depth(3))
      call asperity_by_area(a, s, tau, given%take(p, 'friction'), by_area(1), by_area(2), by_area(3))
    end if
    call names%check(error)
    call given%check(error)
    call tell(error, status)
  end subroutine asperity

  !> Warnings of the joint model under the largest pressure, one per line.
  subroutine joint_warnings(p, np, pressure, status)
    integer(c_int), intent(in) :: np
    real(c_double), intent(in) :: p(np), pressure
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(p) :: np = len(p)
    type(joint_t) :: joint
    type(string_t), allocatable :: list(:)
    type(error_t), allocatable :: error
    call flat_joint(p, joint, error)
    if (.not. allocated(error)) then
      call range_warnings(joint, pressure, list)
      call hand_over(join(list, new_line('a')))
    end if
    call tell(error, status)
  end subroutine joint_warnings

  !> Interface law: closure and k_N over pressure (inverse = 0), pressure and k_N over closure (inverse = 1).
  subroutine joint_normal_law(p, np, zero_pressure, inverse, n, x, y, k, status)
    integer(c_int), intent(in) :: np
    real(c_double), intent(in) :: p(np), zero_pressure
    integer(c_int), intent(in) :: inverse, n
    real(c_double), intent(in) :: x(n)
    real(c_double), intent(out) :: y(n), k(n)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(p) :: np = len(p)
    !f2py integer(c_int), intent(hide), depend(x) :: n = len(x)
    !f2py threadsafe
    type(joint_t) :: joint
    type(interface_law_t) :: law
    type(error_t), allocatable :: error
    call flat_joint(p, joint, error)
    if (.not. allocated(error)) call new_interface_law(joint, zero_pressure, law, error)
    if (.not. allocated(error)) then
      if (inverse == 0) call closure_at(law, x, y, k)
      if (inverse == 1) call pressure_at(law, x, y, k)
    end if
    call tell(error, status)
  end subroutine joint_normal_law

  !> Interface law: shear, k_T and slip (1 or 0) over pressure and tangential displacement.
  subroutine joint_tangential_law(p, np, n, pressure, displacement, shear, k, slipping, status)
    integer(c_int), intent(in) :: np
    real(c_double), intent(in) :: p(np)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: pressure(n), displacement(n)
    real(c_double), intent(out) :: shear(n), k(n)
    integer(c_int), intent(out) :: slipping(n)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(p) :: np = len(p)
    !f2py integer(c_int), intent(hide), depend(pressure) :: n = len(pressure)
    !f2py threadsafe
    type(joint_t) :: joint
    type(interface_law_t) :: law
    type(error_t), allocatable :: error
    logical :: slips
    integer :: i
    slipping = 0
    call flat_joint(p, joint, error)
    if (.not. allocated(error)) call new_interface_law(joint, 1._c_double, law, error)
    if (.not. allocated(error)) then
      do i = 1, n
        call shear_at(law, pressure(i), displacement(i), shear(i), k(i), slips)
        if (slips) slipping(i) = 1
      end do
    end if
    call tell(error, status)
  end subroutine joint_tangential_law

  !> Weights of K_N and K_T in Eq. 45 put right.
  subroutine torsion_weights(x, normal, n, w_n, w_t)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: x(3, n), normal(3, n)
    real(c_double), intent(out) :: w_n(n), w_t(n)
    !f2py integer(c_int), intent(hide), depend(x) :: n = shape(x, 1)
    call facet_weights(x, normal, w_n, w_t)
  end subroutine torsion_weights

  !> The same as printed.
  subroutine torsion_weights_printed(theta, r, w, slope, n, w_n, w_t)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: theta(n), r, w, slope
    real(c_double), intent(out) :: w_n(n), w_t(n)
    !f2py integer(c_int), intent(hide), depend(theta) :: n = len(theta)
    call printed_weights(theta, r, w, slope, w_n, w_t)
  end subroutine torsion_weights_printed

  !> Joint from its parameters.
  subroutine flat_joint(p, joint, error)
    real(c_double), intent(in) :: p(:)                !< in the order of 'joint'
    type(joint_t), intent(out) :: joint               !< joint
    type(error_t), allocatable, intent(out) :: error  !< parameter out of range
    type(named_list_t) :: names
    type(asperity_t) :: a
    call flat_asperity(p, a, error)
    if (allocated(error)) return
    names%list = 'joint'
    call new_joint(a, names%take(p, 'fractal_dimension'), names%take(p, 'friction'), names%take(p, 's_min'), &
      names%take(p, 'reference_area'), names%take(p, 'asperity_radius'), names%take(p, 'paper') > 0, &
      names%take(p, 'plastic') > 0, joint, error)
    call names%check(error)
  end subroutine flat_joint

  !> One asperity of it.
  subroutine flat_asperity(p, a, error)
    real(c_double), intent(in) :: p(:)                !< in the order of 'joint'
    type(asperity_t), intent(out) :: a                !< asperity
    type(error_t), allocatable, intent(out) :: error  !< unknown name
    type(named_list_t) :: names
    names%list = 'joint'
    a = new_asperity(names%take(p, 'e1'), names%take(p, 'nu1'), names%take(p, 'e2'), names%take(p, 'nu2'), &
      names%take(p, 'nu_soft'), names%take(p, 'hardness'), names%take(p, 'fractal_dimension'), names%take(p, 'roughness'), &
      names%take(p, 'gamma'), names%take(p, 'asperity_radius'))
    call names%check(error)
  end subroutine flat_asperity
end module f2py_joint
