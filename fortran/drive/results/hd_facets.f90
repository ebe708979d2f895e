! SPDX-License-Identifier: GPL-3.0-or-later
!> Results of a converged step: fields on the contact facets and the sums over them.
module hd_facets
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp, pi
  use hd_body, only: frame
  use hd_contact_edge, only: softening
  use hd_contact_law, only: open_state, stick_state, slip_state
  use hd_drive, only: drive_t
  use hd_joint, only: joint_t, response_t, evaluate_joint, pressure_power
  use hd_mortar, only: facet_mean, add_nodal_forces, radial_force
  use hd_problem, only: state_t, load_t, internal_residual
  use hd_scene, only: scene_t
  use hd_torsion, only: facet_weights, printed_weights
  use hd_persson_error, only: theory_error_t
  use hd_balance, only: support_torques_t, support_torques, body_resultant
  use hd_twist_shares, only: part_names
  use hd_vector, only: cross, dot, many, thread_share
  implicit none
  private
  public :: facets_t, sums_t, sum_names, sum_values, facet_names, facet_rows, evaluate_facets, sum_up, sum_stiffness, &
    stiffness_slopes, edge_loads

  !> Facets are numbered axially first, then round the axis.
  type :: facets_t
    real(dp), allocatable :: theta(:)         !< reference angle of the centre [rad]
    real(dp), allocatable :: x(:, :)          !< deformed centre (3, facets) [m]
    real(dp), allocatable :: normal(:, :)     !< unit normal, outward, along which the pressure acts (3, facets)
    real(dp), allocatable :: area(:)          !< area that it acts on, at rest [m^2]
    real(dp), allocatable :: bent(:, :)       !< unit normal of the deformed face, outward, for Eq. 45 (3, facets)
    real(dp), allocatable :: gap(:)           !< [m]
    real(dp), allocatable :: traction(:, :)   !< pressure and shear along theta and z, on the flexspline (3, facets) [Pa]
    real(dp), allocatable :: slip(:, :)       !< displacement of the flexspline against the ring along theta, z (2, facets) [m]
    integer, allocatable :: state(:)          !< 0 open, 1 stick, 2 slip
    real(dp), allocatable :: corner(:, :, :)  !< pressure and shear of the corners, as the joint takes them (2, 4, facets) [Pa]
    real(dp), allocatable :: k_n(:), k_t(:)   !< joint stiffness, the mean of the corners' [N/m]
    real(dp), allocatable :: slipping(:, :)   !< of that what lies on corners that slip, K_N and K_T (2, facets) [N/m]
  end type facets_t

  !> Sums over the contact and the supports.
  type :: sums_t
    real(dp) :: rotation = 0           !< mean rotation of the rim, work-conjugate to an even torque [rad]
    real(dp) :: normal_force = 0       !< int p dA [N]
    real(dp) :: reaction_force = 0     !< the same from its nodal forces, less what is radial of shear and tilt [N]
    real(dp) :: facet_force = 0        !< the same from the table of facets [N]
    real(dp) :: lobe_force_x = 0       !< int p |cos theta| dA within 45 degrees of the long axis [N]
    real(dp) :: contact_area = 0       !< [m^2]
    real(dp) :: pressure_max = 0       !< at a node [Pa]
    real(dp) :: pressure_middle = 0    !< mean over the middle fifth of the band [Pa]
    real(dp) :: pressure_middle_max = 0   !< largest mean over the middle fifth at one angle [Pa]
    real(dp) :: friction_torque = 0    !< of the ring on the flexspline, pressure on a formed bore included [N m]
    real(dp) :: friction_capacity = 0  !< mu int p r dA [N m]
    type(support_torques_t) :: torque  !< what each support takes, and what is out of balance
    real(dp) :: axial_balance = 0      !< sum of all axial forces [N]
    real(dp) :: friction = 0           !< Coulomb coefficient of the step
    real(dp) :: k_ts = 0               !< Eq. 45 put right [N m/rad]
    real(dp) :: k_ts_paper = 0         !< Eq. 45 as printed [N]
    real(dp) :: k_tangent = 0, k_secant = 0   !< of what the contact adds to bonded faces (hd_coupled_tangent); NaN: none [N m/rad]
    real(dp) :: k_contact = 0          !< of the contact alone, the same [N m/rad]
    real(dp) :: shares(size(part_names)) = 0  !< of a loop's further twist by part; NaN where there are none
    real(dp) :: over_rotation = 0      !< torque over rotation; NaN without torque [N m/rad]
    real(dp) :: slip_area = 0          !< share of the contact area that slips
    real(dp) :: slip_force = 0         !< share of the normal force on points that slip
    real(dp) :: slip_k_ts = 0          !< share of K_TS (Eq. 45) on points that slip
    real(dp) :: edge_line_load = 0     !< largest force per length round the axis that an end of the band carries [N/m]
    real(dp) :: cam_force = 0          !< int p dA of the wave generator on a ring that may lift off [N]
    real(dp) :: cam_force_x = 0        !< its resultant along the long axis [N]
    real(dp) :: cam_area = 0           !< where it presses [m^2]
    real(dp) :: cam_pressure_min = 0   !< never negative [Pa]
    real(dp) :: cam_gap_max = 0        !< largest distance of the ring from it [m]
    type(theory_error_t) :: theory     !< of a joint by theory
  end type sums_t

  !> Names of what `facet_rows` returns, as in contact.csv and Python.
  character(len=*), parameter :: facet_names = 'theta_rad,x_m,y_m,z_m,n_x,n_y,n_z,area_m2,bent_n_x,bent_n_y,'// &
    'bent_n_z,gap_m,pressure_pa,'// &
    'traction_theta_pa,traction_z_pa,slip_theta_m,slip_z_m,state,k_n_n_per_m,k_t_n_per_m,pressure_1_pa,shear_1_pa,'// &
    'pressure_2_pa,shear_2_pa,pressure_3_pa,shear_3_pa,pressure_4_pa,shear_4_pa'
  !> Names of what `sum_values` returns, as in steps.csv, summary.json and Python.
  character(len=*), parameter :: sum_names = 'rotation_rad,normal_force_n,reaction_force_n,facet_force_n,lobe_force_x_n,'// &
    'contact_area_m2,pressure_max_pa,pressure_mid_mean_pa,pressure_mid_max_pa,friction_torque_nm,friction_capacity_nm,'// &
    'torque_balance_nm,axial_balance_n,lateral_balance_x_n,lateral_balance_y_n,hub_force_x_n,hub_force_y_n,'// &
    'friction,k_ts_nm_per_rad,k_ts_paper_n,k_ts_bonded_nm_per_rad,'// &
    'k_ts_contact_nm_per_rad,k_ts_secant_nm_per_rad,'// &
    'k_fe_secant_nm_per_rad,slip_share_area,slip_share_force,slip_share_k_ts,edge_line_load_n_per_m,'// &
    'hub_torque_nm,wave_generator_torque_nm,ring_spring_torque_nm'
  real(dp), parameter :: just_below = 1e-6_dp !< share by which shear stays below slip, where K_T has no slope
  real(dp), parameter :: smallest = 1e-7_dp   !< share by which a traction or the radius is changed for slopes
  integer, parameter :: long_loop = 1500      !< facets from which two threads are worth waking
  integer, parameter :: block = 8000          !< nodes summed one behind the other
  real(dp), parameter :: edge_part = 0.1_dp   !< of the band at either end that edge_line_load counts

contains

  !> Fields of the facets, one column each, in the order of `facet_names`.
  pure function facet_rows(facets) result(rows)
    type(facets_t), intent(in) :: facets  !< fields
    real(dp), allocatable :: rows(:, :)
    integer :: f, i
    integer, parameter :: columns = 1 + count([(facet_names(i:i) == ',', i=1, len(facet_names))])
    allocate (rows(columns, size(facets%area)))
    do f = 1, size(rows, 2)
      rows(:, f) = [facets%theta(f), facets%x(:, f), facets%normal(:, f), facets%area(f), facets%bent(:, f), facets%gap(f), &
        facets%traction(:, f), facets%slip(:, f), real(facets%state(f), dp), facets%k_n(f), facets%k_t(f), facets%corner(:, :, f)]
    end do
  end function facet_rows

  !> Sums in the order of `sum_names`.
  pure function sum_values(s) result(values)
    type(sums_t), intent(in) :: s  !< sums
    real(dp), allocatable :: values(:)
    values = [s%rotation, s%normal_force, s%reaction_force, s%facet_force, s%lobe_force_x, s%contact_area, s%pressure_max, &
      s%pressure_middle, s%pressure_middle_max, s%friction_torque, s%friction_capacity, s%torque%balance, s%axial_balance, &
      s%torque%lateral, s%torque%hub_force, &
      s%friction, s%k_ts, s%k_ts_paper, s%k_tangent, s%k_contact, s%k_secant, s%over_rotation, s%slip_area, s%slip_force, &
      s%slip_k_ts, s%edge_line_load, s%torque%hub, s%torque%wave_generator, s%torque%ring_springs]
  end function sum_values

  !> Fields on the facets. The joint answers to the pressure and shear of a point: a facet's means would lie between slip here
  !> and slip there, or contact and none, where no point is; K_TS then converges as the length of the facets and slower.
  subroutine evaluate_facets(drive, joint, state, facets)
    type(drive_t), intent(in) :: drive      !< drive
    type(joint_t), intent(in) :: joint      !< joint, its shear capped by the friction of the step
    type(state_t), intent(in) :: state      !< converged state
    type(facets_t), intent(out) :: facets   !< fields
    real(dp), allocatable :: point(:, :)
    type(response_t), allocatable :: response(:)
    real(dp) :: c(3, 4), along(3), turn(3, 3), unit
    integer :: f, i, k, n, at(4)
    n = size(drive%face%nodes, 2)
    allocate (facets%theta(n), facets%area(n), facets%gap(n), facets%x(3, n), facets%normal(3, n), facets%bent(3, n))
    allocate (facets%traction(3, n), facets%slip(2, n), facets%state(n))
    allocate (facets%corner(2, 4, n), facets%k_n(n), facets%k_t(n), facets%slipping(2, n), point(2, size(state%traction, 2)))
    allocate (response(size(point, 2)))
    call answer(drive, joint, state%traction, point, response)
    associate (mortar => drive%problem%mortar, slave => drive%problem%bodies(1))
      !$omp parallel do schedule(static) private(c, along, turn, unit, i, k, at) if(n > long_loop)
      do f = 1, n
        at = mortar%facet(:, f)
        facets%theta(f) = sum(drive%face%chart(1, :, f))/(4*drive%radius)
        facets%area(f) = sum(mortar%share(:, f))
        facets%normal(:, f) = 0  ! of the equilibrium: at rest, with large displacements of the faces as they are paired
        do k = 1, 4
          i = drive%face%nodes(k, f)
          turn = frame(slave%angle(i))
          c(:, k) = slave%x(:, i) + matmul(turn, state%u(:, i))
          along = [1, 0, 0]
          if (allocated(mortar%turn)) along = mortar%turn(1, :, at(k))
          facets%normal(:, f) = facets%normal(:, f) + matmul(turn, along)
        end do
        facets%normal(:, f) = facets%normal(:, f)/norm2(facets%normal(:, f))
        facets%x(:, f) = sum(c, 2)/4
        facets%bent(:, f) = cross(c(:, 3) - c(:, 1), c(:, 4) - c(:, 2))
        facets%bent(:, f) = facets%bent(:, f)/norm2(facets%bent(:, f))
        facets%gap(f) = facet_mean(mortar, f, state%gap(at))
        facets%traction(:, f) = [(facet_mean(mortar, f, state%traction(i, at)), i=1, 3)]
        facets%slip(:, f) = [(facet_mean(mortar, f, state%slip(i, at)), i=1, 2)]
        facets%state(f) = open_state
        if (any(state%contact(at) == slip_state)) facets%state(f) = slip_state
        if (any(state%contact(at) == stick_state)) facets%state(f) = stick_state
        unit = merge(1._dp, facets%area(f), joint%paper)
        facets%corner(:, :, f) = point(:, at)
        facets%k_n(f) = unit*sum(response(at)%k_n)/4
        facets%k_t(f) = unit*sum(response(at)%k_t)/4
        facets%slipping(1, f) = unit*sum(response(at)%k_n, mask=state%contact(at) == slip_state)/4
        facets%slipping(2, f) = unit*sum(response(at)%k_t, mask=state%contact(at) == slip_state)/4
      end do
      !$omp end parallel do
    end associate
  end subroutine evaluate_facets

  !> Pressure and shear of the points as the joint takes them, power means where contact ends along the axis and round it, and its
  !> answers per area.
  subroutine answer(drive, joint, traction, point, response)
    type(drive_t), intent(in) :: drive               !< drive
    type(joint_t), intent(in) :: joint               !< joint, its shear capped by the friction of the step
    real(dp), intent(in) :: traction(:, :)           !< of the points (3, points) [Pa]
    real(dp), intent(out) :: point(:, :)             !< pressure and shear (2, points) [Pa]
    type(response_t), intent(out) :: response(:)     !< of the points
    integer, allocatable :: grid(:, :), round(:)
    real(dp), allocatable :: z(:), even(:), f(:)
    real(dp) :: softer(2, size(traction, 2)), power(size(traction, 2))
    integer :: i, j, k, n, m
    n = drive%axial_facets
    m = size(drive%face%nodes, 2)/n
    allocate (grid(n + 1, m))
    grid(:n, :) = reshape(drive%problem%mortar%facet(1, :), [n, m])
    grid(n + 1, :) = drive%problem%mortar%facet(4, n::n)
    z = [drive%face%chart(2, 1, :n), drive%face%chart(2, 4, n)]
    even = [(real(k, dp), k=1, m + 6)]  ! the angles are equal; three more points at either end close the ring
    round = [m - 2, m - 1, m, (k, k=1, m), 1, 2, 3]
    !$omp parallel private(f) if(m*n > long_loop)
    !$omp do schedule(static, thread_share)
    do j = 1, size(response)
      softer(:, j) = 1
      point(:, j) = [traction(1, j), below_slip(joint%mu*traction(1, j), hypot(traction(2, j), traction(3, j)))]
      call evaluate_joint(joint, point(1, j), point(2, j), 1._dp, response(j))
      power(j) = pressure_power(response(j), point(1, j), point(2, j))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 1, m
      softer(1, grid(:, i)) = softening(z, traction(1, grid(:, i)), power(grid(:, i)))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 1, n + 1
      f = softening(even, traction(1, grid(i, round)), power(grid(i, round)))
      softer(2, grid(i, :)) = f(4:m + 3)
    end do
    !$omp end do
    !$omp do schedule(static, thread_share)
    do j = 1, size(response)
      if (.not. any(abs(softer(:, j) - 1) > 0)) cycle
      point(:, j) = point(:, j)*softer(1, j)*softer(2, j)
      call evaluate_joint(joint, point(1, j), point(2, j), 1._dp, response(j))
    end do
    !$omp end do
    !$omp end parallel
  end subroutine answer

  !> Shear of a point for its joint. It slips where that equals mu p but for the residual, and K_T jumps to 0 there, so that
  !> the residual would decide; every point that slips counts with the limit from below.
  elemental real(dp) function below_slip(limit, shear) result(q)
    real(dp), intent(in) :: limit  !< mu p [Pa]
    real(dp), intent(in) :: shear  !< of the point [Pa]
    q = min(shear, (1 - just_below)*limit)
  end function below_slip

  !> Mean pressure of the middle fifth of the band, a region that does not change with the mesh, and the largest at one angle:
  !> linear along a facet.
  pure subroutine middle_pressure(drive, state, facets, p, peak)
    type(drive_t), intent(in) :: drive    !< drive
    type(state_t), intent(in) :: state    !< converged state
    type(facets_t), intent(in) :: facets  !< its facets
    real(dp), intent(out) :: p, peak      !< [Pa]
    real(dp), dimension(size(facets%area)) :: low, high, part, slope
    real(dp) :: corner(4, size(facets%area))
    real(dp) :: z(2, size(facets%area)), middle, half
    real(dp), parameter :: a_fifth = 0.2_dp
    integer :: grid(2)
    z = drive%face%chart(2, [1, 3], :)
    middle = 0.5_dp*(minval(z) + maxval(z))
    half = 0.5_dp*a_fifth*(maxval(z) - minval(z))
    low = max(z(1, :), middle - half)
    high = min(z(2, :), middle + half)
    part = max(0._dp, high - low)/(z(2, :) - z(1, :))*facets%area
    corner = reshape(state%traction(1, [drive%problem%mortar%facet]), shape(corner))
    slope = 0.5_dp*sum(corner(3:4, :) - corner(1:2, :), 1)/(z(2, :) - z(1, :))
    slope = part*(facets%traction(1, :) + slope*0.5_dp*(low + high - z(1, :) - z(2, :)))
    p = sum(slope)/sum(part)
    grid = [drive%axial_facets, size(part)/drive%axial_facets]
    peak = maxval(sum(reshape(slope, grid), 1)/sum(reshape(part, grid), 1))
  end subroutine middle_pressure

  !> Force per length round the axis that the ring's first and last tenth carry, at every column of facets' first angle. The peak
  !> pressure at the ring's edge grows with a finer mesh, as that of a punch; its integral converges.
  pure function edge_loads(drive, p) result(line)
    type(drive_t), intent(in) :: drive   !< drive
    real(dp), intent(in) :: p(:)         !< pressures of the multipliers [Pa]
    real(dp) :: line(2, size(drive%face%nodes, 2)/drive%axial_facets)  !< (ends, columns) [N/m]
    real(dp) :: z(4), from(2), to(2), ends(2), low, high, slope
    integer :: f, e, i, n
    n = drive%axial_facets
    ends = [minval(drive%face%chart(2, :, :)), maxval(drive%face%chart(2, :, :))]
    from = [ends(1), ends(2) - edge_part*(ends(2) - ends(1))]
    to = [ends(1) + edge_part*(ends(2) - ends(1)), ends(2)]
    line = 0
    do f = 1, size(drive%face%nodes, 2)
      i = (f - 1)/n + 1
      z = drive%face%chart(2, :, f)
      associate (q => p(drive%problem%mortar%facet(:, f)))
        slope = (q(4) - q(1))/(z(4) - z(1))
        do e = 1, 2
          low = max(z(1), from(e))
          high = min(z(4), to(e))
          if (high > low) line(e, i) = line(e, i) + (high - low)*(q(1) + slope*(0.5_dp*(low + high) - z(1)))
        end do
      end associate
    end do
  end function edge_loads

  !> int p |cos theta| dA within 45 degrees of the long axis, the pressure linear round the axis along every facet [N].
  pure real(dp) function lobe_force(drive, p) result(force)
    type(drive_t), intent(in) :: drive   !< drive
    real(dp), intent(in) :: p(:)         !< pressures of the multipliers [Pa]
    real(dp) :: theta(2), ends(2), q(2), slope
    integer :: f
    force = 0
    do f = 1, size(drive%face%nodes, 2)
      associate (a => drive%problem%mortar%share(:, f), c => p(drive%problem%mortar%facet(:, f)))
        if (.not. (a(1) + a(4) > 0 .and. a(2) + a(3) > 0)) cycle
        theta = drive%face%chart(1, 1:2, f)/drive%radius
        q = [a(1)*c(1) + a(4)*c(4), a(2)*c(2) + a(3)*c(3)]/[a(1) + a(4), a(2) + a(3)]
        slope = (q(2) - q(1))/(theta(2) - theta(1))
        theta = theta - pi*nint(sum(theta)/(2*pi))
        ends = [max(theta(1), -pi/4), min(theta(2), pi/4)]
        if (ends(2) > ends(1)) force = force + sum(a)/(theta(2) - theta(1))*(primitive(ends(2)) - primitive(ends(1)))
      end associate
    end do
  contains
    !> Of (q_1 + slope (t - theta_1)) cos t.
    pure real(dp) function primitive(t)
      real(dp), intent(in) :: t  !< angle from the end of the long axis [rad]
      primitive = (q(1) + slope*(t - theta(1)))*sin(t) + slope*cos(t)
    end function primitive
  end function lobe_force

  !> K_TS by Eq. 45 in both readings, torque over rotation, and what of area, force and K_TS slips.
  subroutine sum_stiffness(scene, drive, torque, state, facets, sums)
    type(scene_t), intent(in) :: scene      !< scene
    type(drive_t), intent(in) :: drive      !< drive
    real(dp), intent(in) :: torque          !< of the step [N m]
    type(state_t), intent(in) :: state      !< converged state
    type(facets_t), intent(in) :: facets    !< its facets
    type(sums_t), intent(inout) :: sums     !< gets them; its rotation counts
    real(dp), dimension(size(facets%area)) :: w_n, w_t
    integer :: m
    sums%over_rotation = ieee_value(1._dp, ieee_quiet_nan)
    if (abs(torque) > 0 .and. abs(sums%rotation) > 0) sums%over_rotation = torque/sums%rotation
    if (.not. scene%support%contact) then  ! bonded there: no K_TS of the contact
      sums%k_ts = ieee_value(1._dp, ieee_quiet_nan)
      sums%k_ts_paper = sums%k_ts
      return
    end if
    call facet_weights(facets%x, facets%bent, w_n, w_t)
    sums%k_ts = sum(facets%k_n*w_n + facets%k_t*w_t)
    if (sums%k_ts > 0) sums%slip_k_ts = sum(facets%slipping(1, :)*w_n + facets%slipping(2, :)*w_t)/sums%k_ts
    call printed_weights(facets%theta, scene%bore_radius, scene%w, tan(scene%cone_angle_deg*pi/180), w_n, w_t)
    sums%k_ts_paper = sum(facets%k_n*w_n + facets%k_t*w_t)
    associate (mortar => drive%problem%mortar)
      m = mortar%n - mortar%rigid
      associate (slips => state%contact(:m) == slip_state, a => mortar%area(:m), p => state%traction(1, :m))
        if (sums%contact_area > 0) sums%slip_area = sum(a, mask=slips)/sums%contact_area
        if (abs(sums%normal_force) > 0) sums%slip_force = sum(a*p, mask=slips)/sums%normal_force
      end associate
    end associate
  end subroutine sum_stiffness

  !> Derivatives of K_TS by Eq. 45 by displacements and tractions, by differences. A traction counts at its own point and at the
  !> neighbours along the axis and round it: every third point either way is changed at once.
  subroutine stiffness_slopes(drive, joint, state, by_u, by_t)
    type(drive_t), intent(in) :: drive      !< drive
    type(joint_t), intent(in) :: joint      !< joint, its shear capped by the friction of the step
    type(state_t), intent(in) :: state      !< converged state
    real(dp), intent(out) :: by_u(:, :)     !< (3, n) [N/rad]
    real(dp), intent(out) :: by_t(:, :)     !< (3, points) [m^3/rad]
    real(dp) :: weight(2, size(state%traction, 2))
    real(dp), allocatable :: t(:, :), part(:), was(:), step(:)
    integer, allocatable :: grid(:, :), group(:), near(:)
    integer :: a, b, c, i, j, k, m, n
    call slopes_by_place(drive, joint, state, weight, by_u)
    n = drive%axial_facets
    m = size(drive%face%nodes, 2)/n
    allocate (grid(n + 1, m))
    grid(:n, :) = reshape(drive%problem%mortar%facet(1, :), [n, m])
    grid(n + 1, :) = drive%problem%mortar%facet(4, n::n)
    group = [(merge(modulo(i, 3), i - m - 1, i <= m/3*3), i=1, m)]  ! those left over on the ring stand alone
    was = parts(state%traction)
    by_t = 0
    do c = 1, 3
      step = smallest*abs(state%traction(1, :))
      if (c > 1) step = smallest*norm2(state%traction(2:, :), 1)  ! far less than `just_below`
      do a = 1, 3
        do b = minval(group), 2
          t = state%traction
          near = pack([(j, j=1, m)], group == b)
          do i = a, n + 1, 3
            t(c, grid(i, near)) = t(c, grid(i, near)) + step(grid(i, near))
          end do
          part = parts(t) - was
          do k = 1, size(near)
            do i = a, n + 1, 3
              j = grid(i, near(k))
              associate (around => grid(max(1, i - 1):min(n + 1, i + 1), 1 + modulo(near(k) - 1 + [-1, 0, 1], m)))
                if (step(j) > 0) by_t(c, j) = sum(part([around]))/step(j)
              end associate
            end do
          end do
        end do
      end do
    end do
  contains
    !> Parts of the points.
    function parts(traction) result(part)
      real(dp), intent(in) :: traction(:, :)  !< (3, points) [Pa]
      real(dp), allocatable :: part(:)
      type(response_t) :: response(size(traction, 2))
      real(dp) :: point(2, size(traction, 2))
      call answer(drive, joint, traction, point, response)
      part = weight(1, :)*response%k_n + weight(2, :)*response%k_t
    end function parts
  end subroutine stiffness_slopes

  !> Those by displacements, and the weights of the stiffness per area of the points.
  subroutine slopes_by_place(drive, joint, state, weight, by_u)
    type(drive_t), intent(in) :: drive      !< as of stiffness_slopes
    type(joint_t), intent(in) :: joint      !< likewise
    type(state_t), intent(in) :: state      !< likewise
    real(dp), intent(out) :: weight(:, :)   !< normal and tangential (2, points) [m^4]
    real(dp), intent(out) :: by_u(:, :)     !< (3, n) [N/rad]
    type(facets_t) :: facets
    real(dp), dimension(size(drive%face%nodes, 2)) :: w_n, w_t
    real(dp) :: moved, turn(3, 3), w(2), x(3, 4), y(3, 4)
    integer :: c, f, i, k
    call evaluate_facets(drive, joint, state, facets)
    call facet_weights(facets%x, facets%bent, w_n, w_t)
    moved = smallest*drive%radius
    weight = 0
    by_u = 0
    associate (mortar => drive%problem%mortar, slave => drive%problem%bodies(1))
      do f = 1, size(w_n)
        weight(:, mortar%facet(:, f)) = weight(:, mortar%facet(:, f)) + &
          spread(merge(1._dp, facets%area(f), joint%paper)/4*[w_n(f), w_t(f)], 2, 4)
        do k = 1, 4
          i = drive%face%nodes(k, f)
          x(:, k) = slave%x(:, i) + matmul(frame(slave%angle(i)), state%u(:, i))
        end do
        do k = 1, 4
          i = drive%face%nodes(k, f)
          turn = frame(slave%angle(i))
          do c = 1, 3
            y = x
            y(:, k) = y(:, k) + moved*turn(:, c)
            w = weights(y) - weights(x)
            by_u(c, i) = by_u(c, i) + (facets%k_n(f)*w(1) + facets%k_t(f)*w(2))/moved
          end do
        end do
      end do
    end associate
  contains
    !> Weights of a facet.
    pure function weights(corner) result(both)
      real(dp), intent(in) :: corner(3, 4)  !< its corners [m]
      real(dp) :: both(2), normal(3, 1)
      normal(:, 1) = cross(corner(:, 3) - corner(:, 1), corner(:, 4) - corner(:, 2))
      normal = normal/norm2(normal)
      call facet_weights(reshape(sum(corner, 2)/4, [3, 1]), normal, both(1:1), both(2:2))
    end function weights
  end subroutine slopes_by_place

  !> Sums over the contact, and the balance of the whole.
  subroutine sum_up(drive, load, state, facets, sums)
    type(drive_t), intent(in) :: drive      !< drive
    type(load_t), intent(in) :: load        !< load of the step
    type(state_t), intent(in) :: state      !< converged state
    type(facets_t), intent(in) :: facets    !< its facets
    type(sums_t), intent(out) :: sums       !< sums
    real(dp), allocatable :: forces(:, :), r(:, :), p(:)
    real(dp) :: total(3)
    associate (problem => drive%problem, m => drive%problem%mortar%n - drive%problem%mortar%rigid, a => drive%problem%mortar%area)
      p = state%traction(1, :)
      if (m < size(p)) call sum_cam(drive, state, m, sums)
      p(m + 1:) = 0
      sums%rotation = dot(size(state%u), drive%gauge, state%u)
      sums%normal_force = sum(a*p)
      sums%facet_force = sum(facets%area*facets%traction(1, :))
      sums%lobe_force_x = lobe_force(drive, p)
      sums%edge_line_load = max(0._dp, maxval(edge_loads(drive, p)))
      sums%friction = load%friction
      sums%contact_area = sum(a(:m), mask=state%contact(:m) /= open_state)
      sums%pressure_max = maxval(p)
      call middle_pressure(drive, state, facets, sums%pressure_middle, sums%pressure_middle_max)
      allocate (forces(3, problem%n), source=0._dp)
      call add_nodal_forces(problem%mortar, state%traction, forces)
      total = body_resultant(drive, state, forces, drive%b_cup)
      sums%friction_torque = total(3)
      sums%friction_capacity = load%friction*sums%normal_force*drive%radius
      sums%reaction_force = -radial_force(problem%mortar, state%traction, drive%b_cup == 2, m)
      allocate (r, mold=forces)
      call internal_residual(problem, load, state, r)
      call balance_forces(drive, load, state, forces, r, sums)
    end associate
  end subroutine sum_up

  !> What the supports take, the sum of the axial reactions, and that of what contact and all else leave of radial forces on the
  !> free dofs of the cup.
  subroutine balance_forces(drive, load, state, contact, r, sums)
    type(drive_t), intent(in) :: drive       !< drive
    type(load_t), intent(in) :: load         !< load of the step
    type(state_t), intent(in) :: state       !< converged state
    real(dp), intent(in) :: contact(:, :)    !< nodal forces of the contact (3, n) [N]
    real(dp), intent(in) :: r(:, :)          !< forces that are out of balance, at fixed dofs reactions (3, n) [N]
    type(sums_t), intent(inout) :: sums      !< gets them
    real(dp) :: part(2, size(r, 2)/block + 1)
    integer :: first, last, i, k
    sums%torque = support_torques(drive, load, state, r)
    first = drive%problem%first(drive%b_cup) + 1
    last = first - 1 + drive%problem%bodies(drive%b_cup)%nodes()
    !$omp parallel do schedule(static) private(i) if(size(r) > many)
    do k = 1, size(part, 2)
      part(:, k) = 0
      do i = block*(k - 1) + 1, min(size(r, 2), block*k)
        associate (fixed => drive%problem%fixed(:, i))
          part(1, k) = part(1, k) + merge(r(3, i), 0._dp, fixed(3))
          if (i >= first .and. i <= last .and. .not. fixed(1)) part(2, k) = part(2, k) + (contact(1, i) + r(1, i))
        end associate
      end do
    end do
    !$omp end parallel do
    sums%axial_balance = sum(part(1, :)) + sums%torque%axial_struts
    sums%reaction_force = sums%normal_force + (sum(part(2, :)) + sums%reaction_force)
  end subroutine balance_forces

  !> Sums over the contact of ring and wave generator.
  subroutine sum_cam(drive, state, m, sums)
    type(drive_t), intent(in) :: drive    !< drive
    type(state_t), intent(in) :: state    !< converged state
    integer, intent(in) :: m              !< multipliers before those of the wave generator
    type(sums_t), intent(inout) :: sums   !< gets its sums
    associate (a => drive%problem%mortar%area(m + 1:), p => state%traction(1, m + 1:), node => drive%problem%mortar%node(m + 1:))
      sums%cam_force = sum(a*p)
      sums%cam_force_x = sum(a*p*cos(drive%reference(2, node)))
      sums%cam_area = sum(a, mask=state%contact(m + 1:) /= open_state)
      sums%cam_pressure_min = minval(p)
      sums%cam_gap_max = maxval(state%gap(m + 1:))
    end associate
  end subroutine sum_cam
end module hd_facets
