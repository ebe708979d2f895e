! SPDX-License-Identifier: GPL-3.0-or-later
!> The one place where a scene becomes a joint: its model, its parameters with their defaults resolved, and its interface law,
!> closure and tangential stiffness per area sampled over the pressure and, for the law 'joint', over the shear.
module hd_scene_joint
  use hd_kinds, only: dp, pi
  use hd_asperity, only: asperity_t, new_asperity
  use hd_columns, only: columns_t, read_columns
  use hd_tabulated_law, only: closure_table_t, new_closure_table
  use hd_elastic_law, only: new_elastic_law, elastic_closure, stick_ratio
  use hd_error, only: error_t, raise, code_input
  use hd_joint_law, only: interface_law_t, new_interface_law, closure_at
  use hd_joint, only: joint_t, response_t, new_joint, evaluate_joint, at_friction
  use hd_micro_slip, only: sampled_shares
  use hd_persson, only: contact_at
  use hd_scene, only: scene_t
  use hd_roughness_spectrum, only: power_spectrum_t, fractal_spectrum, sampled_spectrum
  use hd_text, only: to_text
  use hd_persson_error, only: new_theory_surface
  implicit none
  private
  public :: scene_joint, tabulate_joint

  real(dp), parameter :: tabor = 2.8_dp     !< hardness over yield strength (Tabor 1951)
  real(dp), parameter :: step = 0.2_dp      !< of ln p between samples
  real(dp), parameter :: fine_step = 0.1_dp !< of ln p in the elastic law
  real(dp), parameter :: lowest = 1e-3_dp   !< first sample, share of zero_pressure

contains

  !> Joint model of a scene, its shear capped by contact.friction. The law of another scene's joint is taken over where it is the
  !> same.
  subroutine scene_joint(scene, joint, error, other, known)
    type(scene_t), intent(in) :: scene                !< scene
    type(joint_t), intent(out) :: joint               !< joint
    type(error_t), allocatable, intent(out) :: error  !< parameters out of range
    type(scene_t), intent(in), optional :: other      !< scene whose joint is known
    type(joint_t), intent(in), optional :: known      !< its joint
    type(asperity_t) :: asperity
    real(dp) :: hardness, s_min
    hardness = merge(scene%hardness, tabor*scene%yield_strength, scene%hardness > 0)
    s_min = merge(scene%s_min, pi*(scene%shortest_wavelength/2)**2, scene%s_min > 0)
    asperity = new_asperity(scene%flexspline_e, scene%flexspline_nu, scene%ring_e, scene%ring_nu, scene%flexspline_nu, &
      hardness, scene%fractal_dimension, scene%roughness, scene%gamma, scene%asperity_radius)
    call new_joint(asperity, scene%fractal_dimension, scene%friction, s_min, scene%sample_length**2, &
      scene%asperity_radius, scene%closure == 'paper' .and. scene%joint_model == 'hu2023', scene%plastic_spots == 'elastic', &
      joint, error)
    if (allocated(error)) return
    select case (scene%joint_model)
    case ('spectrum')
      if (present(other)) then
        if (same_spectrum(scene, other)) then
          if (allocated(known%elastic)) joint%elastic = known%elastic
          if (allocated(known%theory)) joint%theory = known%theory
        end if
      end if
      if (.not. allocated(joint%elastic)) call from_spectrum(scene, joint, error)
    case ('boundary_elements', 'table')
      call from_table(scene, joint, error)
    case ('auto')
      call raise(error, code_input, "joint.model = 'auto' is chosen when the scene is run or planned; name a model here: "// &
        'spectrum, boundary_elements')
    end select
  end subroutine scene_joint

  !> Two scenes have the same law by their spectrum; none that a file gives, which may have changed.
  pure logical function same_spectrum(a, b) result(same)
    type(scene_t), intent(in) :: a, b  !< scenes
    same = a%joint_model == b%joint_model .and. len_trim(a%joint_spectrum) == 0 .and. len_trim(b%joint_spectrum) == 0 .and. &
      .not. any(abs(numbers(a) - numbers(b)) > 0)
  contains
    !> What the law is made of.
    pure function numbers(s)
      type(scene_t), intent(in) :: s  !< scene
      real(dp) :: numbers(11)
      numbers = [s%fractal_dimension, s%roughness, s%sample_length, s%shortest_wavelength, s%zero_pressure, s%flexspline_e, &
        s%flexspline_nu, s%ring_e, s%ring_nu, s%hardness, s%yield_strength]
    end function numbers
  end function same_spectrum

  !> Elastic law from the spectrum of the equivalent surface, between pressures that no scene leaves.
  subroutine from_spectrum(scene, joint, error)
    type(scene_t), intent(in) :: scene                !< scene
    type(joint_t), intent(inout) :: joint             !< gets its law
    type(error_t), allocatable, intent(out) :: error  !< spectrum out of range
    type(power_spectrum_t) :: spectrum
    type(columns_t) :: columns
    real(dp), allocatable :: q(:), height(:), waves(:), p(:), k(:), area(:), variance(:)
    real(dp) :: low, high
    integer :: i, n
    if (len_trim(scene%joint_spectrum) > 0) then
      call read_columns(trim(scene%joint_spectrum), columns, error)
      if (allocated(error)) error%message = 'joint.spectrum_file: '//error%message
      if (.not. allocated(error)) call columns%take('q_per_m', q, error)
      if (.not. allocated(error)) call columns%take('height_variance_m2', height, error)
      if (.not. allocated(error)) call sampled_spectrum(q, height, spectrum, error)
      if (.not. allocated(error) .and. columns%has('waves_per_m2')) call columns%take('waves_per_m2', waves, error)
      if (allocated(waves) .and. .not. allocated(error)) call count_waves(trim(scene%joint_spectrum), waves, spectrum, error)
    else
      call fractal_spectrum(scene%fractal_dimension, scene%roughness, scene%sample_length, scene%shortest_wavelength, spectrum, &
        error)
    end if
    if (allocated(error)) return
    low = lowest*scene%zero_pressure
    high = 0.5_dp*joint%asperity%hardness
    n = max(2, ceiling(log(high/low)/fine_step))
    p = [(low*exp(log(high/low)*i/n), i=0, n)]
    allocate (k(n + 1), area(n + 1), variance(n + 1))
    call contact_at(spectrum, joint%asperity%e_star, joint%asperity%hardness, p, k, area, variance)
    joint%theory = new_theory_surface(spectrum, joint%asperity%e_star, joint%asperity%hardness, p, area)
    allocate (joint%elastic)
    call new_elastic_law(p, k, stick_ratio(scene%flexspline_e, scene%flexspline_nu, scene%ring_e, scene%ring_nu)*k, &
      joint%elastic, error)
  end subroutine from_spectrum

  !> Waves of a measured spectrum as they were counted on its map.
  subroutine count_waves(path, waves, spectrum, error)
    character(len=*), intent(in) :: path               !< file
    real(dp), intent(in) :: waves(:)                   !< of each band on an area [1/m^2]
    type(power_spectrum_t), intent(inout) :: spectrum  !< gets them
    type(error_t), allocatable, intent(out) :: error   !< not above 0
    if (all(waves > 0) .and. all(waves <= huge(1._dp))) then
      spectrum%waves = waves
    else
      call raise(error, code_input, "'"//path//"': waves_per_m2 from "//to_text(minval(waves))//' to '//to_text(maxval(waves))// &
        '; valid: above 0, finite')
    end if
  end subroutine count_waves

  !> Elastic law from a file.
  subroutine from_table(scene, joint, error)
    type(scene_t), intent(in) :: scene                !< scene
    type(joint_t), intent(inout) :: joint             !< gets its law
    type(error_t), allocatable, intent(out) :: error  !< no file, its rows
    type(columns_t) :: columns
    real(dp), allocatable :: p(:), k_n(:), k_t(:)
    if (len_trim(scene%joint_table) == 0) then
      call raise(error, code_input, "joint.model = '"//trim(scene%joint_model)//"' needs joint.table_file, a CSV with the "// &
        "columns pressure_pa and k_n_pa_per_m; 'hdengine joint MAP MAP --out DIR' writes DIR/joint.csv")
      return
    end if
    call read_columns(trim(scene%joint_table), columns, error)
    if (allocated(error)) error%message = 'joint.table_file: '//error%message
    if (.not. allocated(error)) call columns%take('pressure_pa', p, error)
    if (.not. allocated(error)) call columns%take('k_n_pa_per_m', k_n, error)
    if (allocated(error)) return
    k_t = stick_ratio(scene%flexspline_e, scene%flexspline_nu, scene%ring_e, scene%ring_nu)*k_n
    if (columns%has('k_t_pa_per_m')) call columns%take('k_t_pa_per_m', k_t, error)
    allocate (joint%elastic)
    call new_elastic_law(p, k_n, k_t, joint%elastic, error)
    if (allocated(error)) error%message = "'"//trim(scene%joint_table)//"': "//error%message
  end subroutine from_table

  !> Table of the joint of a scene, from a thousandth of `contact.zero_pressure` to the hardness. It knows the shear as a share of
  !> mu p, so that it holds for the coefficient of every load step.
  subroutine tabulate_joint(scene, joint, table, error)
    type(scene_t), intent(in) :: scene                !< scene
    type(joint_t), intent(in) :: joint                !< its joint
    type(closure_table_t), intent(out) :: table       !< table
    type(error_t), allocatable, intent(out) :: error  !< the joint gives no law
    type(interface_law_t) :: law
    type(response_t), allocatable :: response(:)
    type(joint_t) :: capped
    real(dp), allocatable :: p(:), closure(:), k(:), share(:), tangential(:, :)
    real(dp) :: low
    integer :: i, n
    if (.not. allocated(joint%elastic)) call new_interface_law(joint, scene%zero_pressure, law, error)
    if (allocated(error)) return
    low = lowest*scene%zero_pressure
    n = 1 + ceiling(log(joint%asperity%hardness/low)/step)
    p = [(low*exp(step*i), i=0, n - 1)]
    share = [0._dp]
    if (scene%contact_law == 'joint') share = sampled_shares()
    capped = joint
    if (.not. joint%mu > 0) capped = at_friction(joint, 1._dp)
    allocate (closure(n), k(n), response(n), tangential(size(share), n))
    if (allocated(joint%elastic)) then
      closure = elastic_closure(joint%elastic, scene%zero_pressure, p)
      call evaluate_joint(joint, p, 0._dp, 1._dp, response)
      k = response%k_n
    else
      call closure_at(law, p, closure, k)
    end if
    do i = 1, size(share)
      call evaluate_joint(capped, p, share(i)*capped%mu*p, 1._dp, response)
      tangential(i, :) = response%k_t
    end do
    where (.not. tangential(1, :) > 0) tangential(1, :) = k
    call new_closure_table(closure, p, k, tangential, table, error)
  end subroutine tabulate_joint
end module hd_scene_joint
