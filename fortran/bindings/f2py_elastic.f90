! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: elastic joints. A law is a table of rising pressures with k_N and k_T per area.
module f2py_elastic
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t, raise, code_input
  use hd_persson, only: contact_at, mean_gap_at
  use hd_roughness_spectrum, only: power_spectrum_t, sampled_spectrum, fractal_spectrum
  use hd_status, only: tell, lines_of
  use hd_elastic_law, only: elastic_law_t, new_elastic_law, elastic_stiffness, elastic_closure, elastic_pressure, &
    elastic_shear, stick_ratio
  use hd_input, only: read_scene
  use hd_joint, only: joint_t
  use hd_scene, only: scene_t
  use hd_scene_joint, only: scene_joint
  use hd_text, only: to_text
  use hd_persson_error, only: trust, steep, touching_waves, scatter_of_maps, counted_share, theory_scatter
  implicit none
  private
  public :: spectrum_joint, fractal_joint, elastic_facets, elastic_normal_law, elastic_tangential_law, elastic_of_scene, &
    theory_rule, theory_scatters, joint_moduli

contains

  !> Stiffness per area, true contact and variance of the pressures from a spectrum: variance of the heights in bands about q;
  !> with_gap = 1: mean gap too.
  subroutine spectrum_joint(q, height, e_star, hardness, pressure, with_gap, k, area, variance, gap, n, m, status)
    integer(c_int), intent(in) :: n, m, with_gap
    real(c_double), intent(in) :: q(n), height(n), e_star, hardness, pressure(m)
    real(c_double), intent(out) :: k(m), area(m), variance(m), gap(m)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(q) :: n = len(q)
    !f2py integer(c_int), intent(hide), depend(pressure) :: m = len(pressure)
    !f2py threadsafe
    type(power_spectrum_t) :: spectrum
    type(error_t), allocatable :: error
    gap = 0
    call sampled_spectrum(q, height, spectrum, error)
    if (.not. allocated(error)) call contact_at(spectrum, e_star, hardness, pressure, k, area, variance)
    if (with_gap == 1 .and. .not. allocated(error)) call mean_gap_at(spectrum, e_star, pressure, gap, error)
    call tell(error, status)
  end subroutine spectrum_joint

  !> The same without the gap from the continuum of Eq. 1, for test_prediction: surface holds D, G, L, L_s.
  subroutine fractal_joint(surface, e_star, hardness, pressure, k, area, m, status)
    integer(c_int), intent(in) :: m
    real(c_double), intent(in) :: surface(4), e_star, hardness, pressure(m)
    real(c_double), intent(out) :: k(m), area(m)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(pressure) :: m = len(pressure)
    !f2py threadsafe
    type(power_spectrum_t) :: spectrum
    type(error_t), allocatable :: error
    real(c_double) :: variance(m)
    call fractal_spectrum(surface(1), surface(2), surface(3), surface(4), spectrum, error)
    if (.not. allocated(error)) call contact_at(spectrum, e_star, hardness, pressure, k, area, variance)
    call tell(error, status)
  end subroutine fractal_joint

  !> Stiffness per area of a law; `derivatives` holds dK_N/dP, dK_T/dP, dK_T/dq.
  subroutine elastic_facets(table_p, table_n, table_t, mu, pressure, shear, k_n, k_t, derivatives, n, m, status)
    integer(c_int), intent(in) :: n, m
    real(c_double), intent(in) :: table_p(n), table_n(n), table_t(n), mu, pressure(m), shear(m)
    real(c_double), intent(out) :: k_n(m), k_t(m), derivatives(3, m)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(table_p) :: n = len(table_p)
    !f2py integer(c_int), intent(hide), depend(pressure) :: m = len(pressure)
    !f2py threadsafe
    type(elastic_law_t) :: law
    type(error_t), allocatable :: error
    call new_elastic_law(table_p, table_n, table_t, law, error)
    if (.not. allocated(error)) call elastic_stiffness(law, mu, pressure, shear, k_n, k_t, derivatives(1, :), derivatives(2, :), &
      derivatives(3, :))
    call tell(error, status)
  end subroutine elastic_facets

  !> Closure over pressure (inverse = 0) or pressure over closure (inverse = 1).
  subroutine elastic_normal_law(table_p, table_n, zero_pressure, inverse, x, y, n, m, status)
    integer(c_int), intent(in) :: n, m, inverse
    real(c_double), intent(in) :: table_p(n), table_n(n), zero_pressure, x(m)
    real(c_double), intent(out) :: y(m)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(table_p) :: n = len(table_p)
    !f2py integer(c_int), intent(hide), depend(x) :: m = len(x)
    !f2py threadsafe
    type(elastic_law_t) :: law
    type(error_t), allocatable :: error
    call new_elastic_law(table_p, table_n, table_n, law, error)
    if (.not. allocated(error)) then
      if (inverse == 0) y = elastic_closure(law, zero_pressure, x)
      if (inverse == 1) y = elastic_pressure(law, zero_pressure, x)
    end if
    call tell(error, status)
  end subroutine elastic_normal_law

  !> Shear, k_T and slip (1 or 0) over pressure and tangential displacement.
  subroutine elastic_tangential_law(table_p, table_t, mu, pressure, displacement, shear, k, slipping, n, m, status)
    integer(c_int), intent(in) :: n, m
    real(c_double), intent(in) :: table_p(n), table_t(n), mu, pressure(m), displacement(m)
    real(c_double), intent(out) :: shear(m), k(m)
    integer(c_int), intent(out) :: slipping(m)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(table_p) :: n = len(table_p)
    !f2py integer(c_int), intent(hide), depend(pressure) :: m = len(pressure)
    !f2py threadsafe
    type(elastic_law_t) :: law
    type(error_t), allocatable :: error
    logical :: slips(m)
    slips = .false.
    call new_elastic_law(table_p, table_t, table_t, law, error)
    if (.not. allocated(error)) call elastic_shear(law, mu, pressure, displacement, shear, k, slips)
    slipping = merge(1, 0, slips)
    call tell(error, status)
  end subroutine elastic_tangential_law

  !> The elastic law of a scene as the engine makes it, `rows` entries; none for joint.model = 'hu2023'.
  subroutine elastic_of_scene(path, assignments, most, pressure, k_n, k_t, rows, mu, status)
    character(len=*), intent(in) :: path, assignments
    integer(c_int), intent(in) :: most
    real(c_double), intent(out) :: pressure(most), k_n(most), k_t(most), mu
    integer(c_int), intent(out) :: rows
    integer(c_int), intent(out) :: status
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(scene_t), allocatable :: s
    type(joint_t) :: joint
    rows = 0
    allocate (s)
    call read_scene(path, lines_of(assignments), s, error)
    if (.not. allocated(error)) call scene_joint(s, joint, error)
    if (.not. allocated(error)) mu = joint%mu
    if (.not. allocated(error) .and. allocated(joint%elastic)) then
      associate (t => joint%elastic)
        rows = size(t%normal%log_p)
        if (rows > most) then
          call raise(error, code_input, 'the table of the joint has '//to_text(rows)//' rows; Python takes up to '//to_text(most))
        else
          pressure(:rows) = exp(t%normal%log_p)
          k_n(:rows) = exp(t%normal%log_k)
          k_t(:rows) = exp(t%tangential%log_k)
        end if
      end associate
    end if
    call tell(error, status)
  end subroutine elastic_of_scene

  !> The rule for the theory: ln k_N that it must keep, E* slope over hardness that is too steep, and errors over touching waves.
  subroutine theory_rule(limits, touching, scatter)
    real(c_double), intent(out) :: limits(2), touching(8), scatter(8)
    limits = [trust, steep]
    touching = touching_waves
    scatter = scatter_of_maps
  end subroutine theory_rule

  !> rms error of ln k_N by theory at shares of contact of so many independent waves.
  subroutine theory_scatters(area, waves, scatter, n)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: area(n), waves
    real(c_double), intent(out) :: scatter(n)
    !f2py integer(c_int), intent(hide), depend(area) :: n = len(area)
    scatter = theory_scatter(waves*counted_share(area))
  end subroutine theory_scatters

  !> E* [Pa] of two bodies and k_T/k_N of full stick.
  subroutine joint_moduli(e1, nu1, e2, nu2, e_star, ratio)
    real(c_double), intent(in) :: e1, nu1, e2, nu2
    real(c_double), intent(out) :: e_star, ratio
    e_star = 1/((1 - nu1**2)/e1 + (1 - nu2**2)/e2)
    ratio = stick_ratio(e1, nu1, e2, nu2)
  end subroutine joint_moduli
end module f2py_elastic
