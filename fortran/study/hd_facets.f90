! SPDX-License-Identifier: GPL-3.0-or-later
!> Results of a converged step: fields on the contact facets and the sums over them.
module hd_facets
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t
  use hd_asperity, only: asperity_t, new_asperity
  use hd_body, only: cartesian, axial_moment
  use hd_contact_edge, only: softening
  use hd_contact_law, only: open_state, stick_state, slip_state
  use hd_drive, only: drive_t
  use hd_joint, only: joint_t, response_t, new_joint, evaluate_joint
  use hd_mortar, only: facet_mean, add_nodal_forces, radial_force
  use hd_problem, only: state_t, load_t, internal_residual
  use hd_scene, only: scene_t
  use hd_vector, only: cross
  implicit none
  private
  public :: facets_t, sums_t, scene_joint, evaluate_facets, sum_up, contact_torque

  !> Facets are numbered axially first, then round the axis.
  type :: facets_t
    real(dp), allocatable :: theta(:)         !< reference angle of the centre [rad]
    real(dp), allocatable :: x(:, :)          !< deformed centre (3, facets) [m]
    real(dp), allocatable :: normal(:, :)     !< deformed unit normal, outward (3, facets)
    real(dp), allocatable :: area(:)          !< reference area [m^2]
    real(dp), allocatable :: gap(:)           !< [m]
    real(dp), allocatable :: traction(:, :)   !< pressure and shear along theta and z, on the flexspline (3, facets) [Pa]
    real(dp), allocatable :: slip(:, :)       !< displacement of the flexspline against the ring along theta, z (2, facets) [m]
    integer, allocatable :: state(:)          !< 0 open, 1 stick, 2 slip
    real(dp), allocatable :: corner(:, :, :)  !< pressure and shear of the corners, as the joint takes them (2, 4, facets) [Pa]
    real(dp), allocatable :: k_n(:), k_t(:)   !< joint stiffness, the mean of the corners' [N/m]
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
    real(dp) :: friction_torque = 0    !< of the ring on the flexspline, pressure on a formed bore included [N m]
    real(dp) :: friction_capacity = 0  !< mu int p r dA [N m]
    real(dp) :: torque_balance = 0     !< sum of all moments about the axis [N m]
    real(dp) :: axial_balance = 0      !< sum of all axial forces [N]
    integer :: sticking = 0            !< multipliers that stick
    real(dp) :: cam_force = 0          !< int p dA of the wave generator on a ring that may lift off [N]
    real(dp) :: cam_force_x = 0        !< its resultant along the long axis [N]
    real(dp) :: cam_area = 0           !< where it presses [m^2]
    real(dp) :: cam_pressure_min = 0   !< never negative [Pa]
    real(dp) :: cam_gap_max = 0        !< largest distance of the ring from it [m]
  end type sums_t

contains

  !> Joint model of a scene.
  subroutine scene_joint(scene, joint, error)
    type(scene_t), intent(in) :: scene                !< scene
    type(joint_t), intent(out) :: joint               !< joint
    type(error_t), allocatable, intent(out) :: error  !< parameters out of range
    type(asperity_t) :: asperity
    real(dp) :: hardness, s_min
    hardness = merge(scene%hardness, 2.8_dp*scene%yield_strength, scene%hardness > 0)
    s_min = merge(scene%s_min, pi*(scene%shortest_wavelength/2)**2, scene%s_min > 0)
    asperity = new_asperity(scene%flexspline_e, scene%flexspline_nu, scene%ring_e, scene%ring_nu, scene%flexspline_nu, &
      hardness, scene%fractal_dimension, scene%roughness, scene%gamma, scene%asperity_radius)
    call new_joint(asperity, scene%fractal_dimension, scene%friction, s_min, scene%sample_length**2, &
      scene%asperity_radius, scene%closure == 'paper', joint, error)
  end subroutine scene_joint

  !> Fields on the facets. The joint answers to the pressure and shear of a point: a facet's means would lie between slip here
  !> and slip there, or contact and none, where no point is; K_TS then converges as the length of the facets and slower.
  subroutine evaluate_facets(drive, joint, state, facets)
    type(drive_t), intent(in) :: drive      !< drive
    type(joint_t), intent(in) :: joint      !< joint
    type(state_t), intent(in) :: state      !< converged state
    type(facets_t), intent(out) :: facets   !< fields
    real(dp), allocatable :: x(:, :), point(:, :)
    type(response_t), allocatable :: response(:)
    real(dp) :: c(3, 4), d(3), e(3), unit
    integer :: f, i, n
    n = size(drive%face%nodes, 2)
    allocate (facets%x(3, n), facets%normal(3, n), facets%traction(3, n), facets%slip(2, n), facets%state(n))
    allocate (facets%corner(2, 4, n), facets%k_n(n), facets%k_t(n), point(2, size(state%traction, 2)))
    allocate (response(size(point, 2)))
    point = effective(drive, joint%mu, state%traction)
    call evaluate_joint(joint, point(1, :), point(2, :), 1._dp, response)
    associate (mortar => drive%problem%mortar, slave => drive%problem%bodies(1))
      x = slave%x + cartesian(slave, state%u(:, :slave%nodes()))
      facets%theta = sum(drive%face%chart(1, :, :), 1)/(4*drive%radius)
      facets%area = sum(mortar%share, 1)
      facets%gap = facet_mean(mortar, state%gap)
      do i = 1, 3
        facets%traction(i, :) = facet_mean(mortar, state%traction(i, :))
      end do
      do i = 1, 2
        facets%slip(i, :) = facet_mean(mortar, state%slip(i, :))
      end do
      do f = 1, n
        c = x(:, drive%face%nodes(:4, f))
        facets%x(:, f) = sum(c, 2)/4
        d = c(:, 3) - c(:, 1)
        e = c(:, 4) - c(:, 2)
        facets%normal(:, f) = cross(d, e)
        facets%normal(:, f) = facets%normal(:, f)/norm2(facets%normal(:, f))
        associate (s => state%contact(mortar%facet(:, f)))
          facets%state(f) = open_state
          if (any(s == slip_state)) facets%state(f) = slip_state
          if (any(s == stick_state)) facets%state(f) = stick_state
        end associate
        unit = merge(1._dp, facets%area(f), joint%paper)
        facets%corner(:, :, f) = point(:, mortar%facet(:, f))
        facets%k_n(f) = unit*sum(response(mortar%facet(:, f))%k_n)/4
        facets%k_t(f) = unit*sum(response(mortar%facet(:, f))%k_t)/4
      end do
    end associate
  end subroutine evaluate_facets

  !> Pressure and shear of the points (2, points) as the joint takes them: power means where contact ends along the axis and
  !> round it [Pa].
  function effective(drive, mu, traction) result(point)
    type(drive_t), intent(in) :: drive        !< drive
    real(dp), intent(in) :: mu                !< coefficient of friction
    real(dp), intent(in) :: traction(:, :)    !< of the points (3, points) [Pa]
    real(dp) :: point(2, size(traction, 2))
    integer, allocatable :: grid(:, :)
    real(dp), allocatable :: z(:), softer(:)
    integer :: i, k, n, m
    n = drive%axial_facets
    m = size(drive%face%nodes, 2)/n
    allocate (grid(n + 1, m))
    grid(:n, :) = reshape(drive%problem%mortar%facet(1, :), [n, m])
    grid(n + 1, :) = drive%problem%mortar%facet(4, n::n)
    z = [drive%face%chart(2, 1, :n), drive%face%chart(2, 4, n)]
    point(1, :) = traction(1, :)
    point(2, :) = below_slip(mu*point(1, :), hypot(traction(2, :), traction(3, :)))
    do i = 1, m
      point(:, grid(:, i)) = point(:, grid(:, i))*spread(softening(z, traction(1, grid(:, i))), 1, 2)
    end do
    do i = 1, n + 1  ! the angles are equal; three more points at either end close the ring
      softer = softening([(real(k, dp), k=1, m + 6)], traction(1, grid(i, [m - 2, m - 1, m, (k, k=1, m), 1, 2, 3])))
      point(:, grid(i, :)) = point(:, grid(i, :))*spread(softer(4:m + 3), 1, 2)
    end do
  end function effective

  !> Shear of a point for its joint. It slips where that equals mu p but for the residual, and K_T jumps to 0 there, so that
  !> the residual would decide; every point that slips counts with the limit from below.
  elemental real(dp) function below_slip(limit, shear) result(q)
    real(dp), intent(in) :: limit  !< mu p [Pa]
    real(dp), intent(in) :: shear  !< of the point [Pa]
    q = min(shear, (1 - 1e-6_dp)*limit)
  end function below_slip

  !> Mean pressure of the middle fifth of the band, a region that does not change with the mesh: linear along a facet.
  pure real(dp) function middle_pressure(drive, state, facets) result(p)
    type(drive_t), intent(in) :: drive    !< drive
    type(state_t), intent(in) :: state    !< converged state
    type(facets_t), intent(in) :: facets  !< its facets
    real(dp), dimension(size(facets%area)) :: low, high, part, slope
    real(dp) :: corner(4, size(facets%area))
    real(dp) :: z(2, size(facets%area)), middle, half
    z = drive%face%chart(2, [1, 3], :)
    middle = 0.5_dp*(minval(z) + maxval(z))
    half = 0.1_dp*(maxval(z) - minval(z))
    low = max(z(1, :), middle - half)
    high = min(z(2, :), middle + half)
    part = max(0._dp, high - low)/(z(2, :) - z(1, :))*facets%area
    corner = reshape(state%traction(1, [drive%problem%mortar%facet]), shape(corner))
    slope = 0.5_dp*sum(corner(3:4, :) - corner(1:2, :), 1)/(z(2, :) - z(1, :))
    p = sum(part*(facets%traction(1, :) + slope*0.5_dp*(low + high - z(1, :) - z(2, :))))/sum(part)
  end function middle_pressure

  !> Sums over the contact, and the balance of the whole.
  subroutine sum_up(drive, load, state, facets, sums)
    type(drive_t), intent(in) :: drive      !< drive
    type(load_t), intent(in) :: load        !< load of the step
    type(state_t), intent(in) :: state      !< converged state
    type(facets_t), intent(in) :: facets    !< its facets
    type(sums_t), intent(out) :: sums       !< sums
    real(dp), allocatable :: r(:, :), theta(:), p(:)
    type(state_t) :: free
    integer :: first, last
    associate (problem => drive%problem, m => drive%problem%mortar%n - drive%problem%mortar%rigid, a => drive%problem%mortar%area)
      p = state%traction(1, :)
      theta = drive%reference(2, problem%mortar%node)
      if (m < size(p)) call sum_cam(drive, state, m, sums)
      p(m + 1:) = 0
      sums%rotation = sum(drive%gauge*state%u)
      sums%normal_force = sum(a*p)
      sums%facet_force = sum(facets%area*facets%traction(1, :))
      sums%lobe_force_x = sum(a*p*abs(cos(theta)), mask=abs(cos(theta)) > sqrt(0.5_dp))
      sums%contact_area = sum(a(:m), mask=state%contact(:m) /= open_state)
      sums%pressure_max = maxval(p)
      sums%pressure_middle = middle_pressure(drive, state, facets)
      allocate (r(3, problem%n), source=0._dp)
      call add_nodal_forces(problem%mortar, state%traction, r)
      sums%friction_torque = moment(drive, state, r, drive%b_cup)
      sums%friction_capacity = problem%law%friction*sums%normal_force*drive%radius
      sums%sticking = count(state%contact(:m) == stick_state)
      r = internal_residual(problem, load, state)
      where (.not. problem%fixed) r = 0
      sums%torque_balance = moment(drive, state, r + load%force, 1) + moment(drive, state, r + load%force, 2) - &
        spring_torque(drive, state)
      sums%axial_balance = sum(r(3, :))
      free = state
      free%traction = 0
      r = internal_residual(problem, load, free)
      where (problem%fixed) r = 0
      first = problem%first(drive%b_cup)
      last = first + problem%bodies(drive%b_cup)%nodes()
      sums%reaction_force = sums%normal_force + (sum(r(1, first + 1:last)) - &
        radial_force(problem%mortar, state%traction, drive%b_cup == 2, m))
    end associate
  end subroutine sum_up

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

  !> Moment about the axis of the nodal forces on one body [N m].
  pure real(dp) function moment(drive, state, force, b) result(m)
    type(drive_t), intent(in) :: drive     !< drive
    type(state_t), intent(in) :: state     !< with large displacements the deformed bodies count
    real(dp), intent(in) :: force(:, :)    !< (3, n) [N]
    integer, intent(in) :: b               !< body
    associate (body => drive%problem%bodies(b), first => drive%problem%first(b))
      if (allocated(drive%problem%lagrangian)) then
        m = axial_moment(body, force(:, first + 1:first + body%nodes()), state%u(:, first + 1:first + body%nodes()))
      else
        m = axial_moment(body, force(:, first + 1:first + body%nodes()))
      end if
    end associate
  end function moment

  !> Torque that contact passes on, from the forces on the ring, which stays where it is even while the flexspline slides [N m].
  pure real(dp) function contact_torque(drive, state) result(m)
    type(drive_t), intent(in) :: drive  !< drive
    type(state_t), intent(in) :: state  !< state or iterate
    real(dp) :: force(3, drive%problem%n)
    force = 0
    call add_nodal_forces(drive%problem%mortar, -state%traction, force)
    m = moment(drive, state, force, drive%b_ring)
  end function contact_torque

  !> Moment of the support springs about the axis [N m].
  pure real(dp) function spring_torque(drive, state) result(m)
    type(drive_t), intent(in) :: drive  !< drive
    type(state_t), intent(in) :: state  !< state
    m = drive%spring_rate*drive%hub_radius*sum(state%u(2, drive%sprung))
  end function spring_torque
end module hd_facets
