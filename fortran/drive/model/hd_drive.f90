! SPDX-License-Identifier: GPL-3.0-or-later
!> The harmonic drive scene as a contact problem: flexspline cup, bearing ring, wave generator, supports and torque.
!>
!> The z axis is the drive's axis, z = 0 the opening of the cup. Body 1 carries the multipliers (slave): the ring, or the cup
!> with contact.slave = 'cup'. Tractions and relative displacements are those of the cup against the ring in either case.
module hd_drive
  use hd_kinds, only: dp, pi, hair
  use hd_ball_bearing, only: axial_struts, ball_angles, ball_grooves, ball_patches, ball_struts, ring_holds
  use hd_ball_patch, only: ball_patch_t
  use hd_cam, only: cam_t, new_cam, curve_t, new_curve
  use hd_error, only: error_t
  use hd_scene, only: scene_t
  use hd_body, only: body_t
  use hd_face, only: face_t
  use hd_formed_body, only: form_body, formed_curve, put_on_curve
  use hd_revolution, only: strip_t, revolve, strip_face
  use hd_section, only: ring_strip, cup_strip, rim_end
  use hd_hexahedron, only: element_kind
  use hd_mortar, only: add_rigid, new_mortar
  use hd_problem, only: problem_t, load_t, state_t, new_problem, add_springs, loosen
  use hd_rim_load, only: even_shear, tooth_forces
  use hd_contact_law, only: contact_mode
  use hd_flank_friction, only: memories, rub_t
  use hd_strut, only: absent, closing_of, strut_t
  use hd_strut_step, only: remember
  use hd_spline_ring, only: flank_compliance
  use hd_tooth_flanks, only: flank_struts, tooth_gaps
  use hd_vector, only: many
  implicit none
  private
  public :: drive_t, new_drive, renew_drive, drive_load, strut_load, step_friction, touch_teeth

  type :: drive_t
    type(problem_t) :: problem               !< bodies, supports, interface
    type(strip_t) :: ring, cup               !< meridian sections
    integer :: b_ring = 1, b_cup = 2         !< their bodies
    type(face_t) :: face                     !< contact face of the slave
    type(face_t) :: rim                      !< outside of the rim, nodes numbered in the cup
    integer :: axial_facets = 0              !< facets of that face along the axis
    real(dp) :: radius = 0                   !< contact radius [m]
    type(cam_t) :: cam                       !< the wave generator: of the ring's inner face, with formed bodies of the contact face
    integer, allocatable :: inner(:)         !< nodes of the ring's inner face
    real(dp), allocatable :: assembly(:, :)  !< displacements of the fixed dofs by the whole assembly (3, n) [m]
    logical :: exact = .false.               !< they follow the curve through the assembly, and not to first order only
    real(dp), allocatable :: reference(:, :) !< r, theta, z of the nodes before any forming (3, n) [m, rad, m]
    real(dp), allocatable :: torque(:, :)    !< nodal forces of a unit torque (3, n) [1/m]
    real(dp), allocatable :: squeeze(:, :)   !< radial forces that come with a unit torque of either sense (3, n) [1/m]
    real(dp), allocatable :: gauge(:, :)     !< even shear of a unit torque: weights of the rotation of the rim (3, n) [1/m]
    logical :: formed = .false.              !< the bodies have the cam's shape at rest
    real(dp) :: eccentricity(2) = 0          !< of the wave generator, along and across the long axis [m]
    real(dp) :: interference = 0             !< radial interference, negative: clearance [m]
    integer, allocatable :: sprung(:)        !< nodes held by the soft springs of a bearing support
    real(dp) :: hub_radius = 0               !< [m]
    integer, allocatable :: hub(:)           !< nodes at the inner edge of the bottom
    integer :: balls = 0                     !< of the struts the first are balls,
    integer :: flanks = 0                    !< the next flanks, two for each pair,
    integer :: stays = 0                     !< then what keeps a ring from turning and the axial ways of balls in grooves; last
                                             !< come companions of flanks that rub
    integer :: brake = 0                     !< of the stays the one that is there in Newton's matrix alone, 0: none
    real(dp), allocatable :: way(:)          !< radial way of the cam at the balls, less clearance, after the assembly [m]
    real(dp), allocatable :: slope(:)        !< its derivative round the axis; without balls at the nodes of `inner` [m/rad]
  end type drive_t

contains

  !> Build the problem of a scene.
  subroutine new_drive(scene, drive, error, alike)
    type(scene_t), intent(in) :: scene                !< checked scene
    type(drive_t), intent(out) :: drive               !< problem and loads
    type(error_t), allocatable, intent(out) :: error  !< inverted element, out of memory
    logical, intent(in), optional :: alike            !< faces of equal sectors are coupled by those of the first, to rounding
    type(body_t) :: bodies(2)
    type(face_t) :: slave, master, inside, bore
    integer, allocatable :: repeated
    integer :: kind, sectors, first, last
    call element_kind(scene%element, kind, error)
    if (allocated(error)) return
    drive%radius = scene%bore_radius
    call ring_strip(scene, drive%ring)
    call cup_strip(scene, drive%cup, first, last)
    sectors = merge(scene%ring_divisions, scene%divisions, scene%ring_divisions > 0)
    if (scene%cup_is_slave()) then
      drive%b_ring = 2
      drive%b_cup = 1
    end if
    associate (ring => bodies(drive%b_ring), cup => bodies(drive%b_cup))
      call revolve(drive%ring, sectors, kind, ring)
      call revolve(drive%cup, scene%divisions, kind, cup)
      ring%young = scene%ring_e
      ring%poisson = scene%ring_nu
      cup%young = scene%flexspline_e
      cup%poisson = scene%flexspline_nu
      call strip_face(drive%ring, ring, drive%ring%layers + 1, 1, size(drive%ring%inner, 2), drive%radius, drive%face)
      call strip_face(drive%ring, ring, 1, 1, size(drive%ring%inner, 2), drive%radius - scene%ring_thickness, inside)
      call strip_face(drive%cup, cup, 1, first, last, drive%radius, master)
      call strip_face(drive%cup, cup, 1, 1, count(abs(drive%cup%inner(1, :) - drive%radius) <= hair*drive%radius), &
        drive%radius, bore)
      call strip_face(drive%cup, cup, drive%cup%layers + 1, 1, rim_end(scene, drive%cup), drive%radius, drive%rim)
    end associate
    drive%axial_facets = size(drive%ring%inner, 2) - 1
    if (scene%cup_is_slave()) then
      drive%axial_facets = last - first
      slave = master
      master = drive%face
      drive%face = slave
      bore = master
    end if
    master%nodes = master%nodes + bodies(1)%nodes()
    bore%nodes = bore%nodes + bodies(1)%nodes()
    allocate (drive%reference(3, sum(bodies%sectors*bodies%nodes_per_sector)))
    drive%reference(:, :bodies(1)%nodes()) = cylindrical(bodies(1))
    drive%reference(:, bodies(1)%nodes() + 1:) = cylindrical(bodies(2))
    if (scene%formed()) then
      call new_cam(scene, scene%bore_radius, drive%cam, error)
      if (allocated(error)) return
      call form_body(scene, drive%cam, bodies(1))
      call form_body(scene, drive%cam, bodies(2))
    end if
    call new_problem(bodies, drive%problem, error)
    if (allocated(error)) return
    if (present(alike) .and. sectors == scene%divisions) repeated = sectors
    call new_mortar(drive%face, master, drive%problem%mortar, sectors=repeated)
    inside%nodes = inside%nodes + drive%problem%first(drive%b_ring)
    if (scene%large() .and. .not. scene%bonded() .and. (.not. scene%formed() .or. &
      .not. abs(scene%cone_angle_deg) > 0)) call follow_faces(scene, drive, bore, inside)
    if (scene%cup_is_slave()) drive%problem%mortar%val = -drive%problem%mortar%val
    if (scene%ring_lifts()) call add_rigid(drive%problem%mortar, inside)
    drive%problem%law%scale = sqrt(scene%ring_e*scene%flexspline_e)/drive%radius
    call hold(scene, drive)
    call load_rim(scene, drive)
    call renew_drive(scene, drive, error)
  end subroutine new_drive

  !> Pair the faces anew as they move.
  subroutine follow_faces(scene, drive, master, inside)
    type(scene_t), intent(in) :: scene            !< scene
    type(drive_t), intent(inout) :: drive         !< gets its pairing, from the coupling at rest
    type(face_t), intent(in) :: master            !< face of the second body: of the cup the whole bore, on which the ring slips
    type(face_t), intent(in) :: inside            !< inside of the ring
    allocate (drive%problem%pairing)
    associate (pairing => drive%problem%pairing, n => drive%problem%mortar%n)
      pairing%slave = drive%face
      pairing%master = master
      pairing%rest = drive%problem%mortar
      if (scene%ring_lifts()) pairing%inside = inside
      pairing%radius = drive%radius
      if (scene%cup_is_slave()) pairing%sign = -1
      pairing%slave_nodes = drive%problem%bodies(1)%nodes()
      allocate (pairing%stretch(n), source=1._dp)
      allocate (pairing%bend(n), source=1/drive%radius)
      if (scene%formed()) call formed_curve(drive%cam, drive%reference(2, pairing%rest%node), &
        pairing%stretch, pairing%bend)
    end associate
  end subroutine follow_faces

  !> Enter what leaves mesh, supports and stiffness as they are: contact law, places of balls and teeth, wave generator.
  subroutine renew_drive(scene, drive, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    type(drive_t), intent(inout) :: drive             !< drive of a scene that differs in nothing else
    type(error_t), allocatable, intent(out) :: error  !< unknown contact mode
    drive%interference = merge(-scene%clearance, scene%interference, scene%clearance > 0)
    call contact_mode(scene%contact_mode, drive%problem%law%mode, error)
    if (allocated(error)) return
    if (scene%support%struts) call set_struts(scene, drive)
    call turn_cam(scene, drive, error)
  end subroutine renew_drive

  !> r, theta, z of the nodes of a revolved body.
  pure function cylindrical(body) result(c)
    type(body_t), intent(in) :: body  !< body
    real(dp) :: c(3, size(body%x, 2))
    c(1, :) = hypot(body%x(1, :), body%x(2, :))
    c(2, :) = body%angle
    c(3, :) = body%x(3, :)
  end function cylindrical

  !> Supports. The wave generator prescribes the ring's inner face, or the ends of the balls' springs that pull it. Where no grooves
  !> do, the middle of that face holds the ring along the axis.
  subroutine hold(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets its fixed dofs and springs
    logical, parameter :: in_plane(6) = [.true., .true., .true., .false., .false., .false.]
    logical, parameter :: turn(6) = [.false., .false., .true., .false., .false., .false.]
    integer, allocatable :: hub(:), inner(:), middle(:)
    real(dp) :: edge(2)
    associate (problem => drive%problem)
      inner = nodes_on(drive, drive%b_ring, drive%ring%inner)
      problem%fixed(1, inner) = .not. scene%ring_lifts() .and. .not. scene%ball_stiffness > 0
      if (scene%ball_stiffness > 0) call set_on_balls(scene, drive)
      if (scene%support%struts .and. scene%balls > 0) then
        problem%fixed(1, inner) = .false.
        call loosen(problem, drive%b_ring, in_plane .or. scene%in_grooves())
      else if (scene%ring_follows()) then
        problem%fixed(2, inner) = .true.
      else if (scene%support%struts) then
        call loosen(problem, drive%b_ring, turn)
      else
        if (.not. scene%bonded()) call add_springs(problem, inner, 2, scene%support_stiffness/size(inner))
        if (.not. scene%ring_lifts()) call loosen(problem, drive%b_ring, turn)
      end if
      if (scene%support%struts .and. allocated(problem%loose) .and. scene%frictionless()) then  ! nothing else resists its turn
        call add_springs(problem, inner, 2, scene%support_stiffness/size(inner))
      end if
      associate (row => (size(drive%ring%inner, 2) + 1)/2)
        middle = nodes_on(drive, drive%b_ring, drive%ring%inner(:, row:row))
      end associate
      problem%fixed(3, middle) = .not. scene%in_grooves()
      allocate (drive%sprung(0))
      drive%hub_radius = scene%hub_radius
      edge = [drive%cup%inner(2, size(drive%cup%inner, 2)), drive%cup%outer(2, size(drive%cup%inner, 2))]
      hub = nodes_on(drive, drive%b_cup, reshape([scene%hub_radius, minval(edge), scene%hub_radius, maxval(edge)], [2, 2]))
      problem%fixed(3, hub) = .true.
      drive%hub = hub
      if (.not. scene%support%friction_alone) then
        problem%fixed(:, hub) = .true.
      else
        drive%sprung = hub
        call add_springs(problem, hub, 1, scene%support_stiffness/size(hub))
        call add_springs(problem, hub, 2, scene%support_stiffness/size(hub))
        call loosen(problem, drive%b_cup, in_plane)
      end if
    end associate
  end subroutine hold

  !> Balls and flanks of the whole drive, and the bottom that turns.
  subroutine set_struts(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets its problem's struts and wheel
    type(face_t) :: inside
    type(ball_patch_t) :: patch
    integer, allocatable :: rim(:)
    integer :: i
    drive%balls = scene%balls
    drive%flanks = 2*scene%tooth_pairs
    associate (problem => drive%problem, ring => drive%problem%bodies(drive%b_ring))
      problem%struts = flank_struts(scene, problem%bodies(drive%b_cup), drive%rim, problem%first(drive%b_cup))
      drive%stays = 0
      drive%brake = 0
      if (scene%balls > 0 .and. (scene%large() .or. .not. scene%frictionless())) then
        call add_stays(drive, [turn_stay(drive, scene%frictionless())])
        if (.not. scene%frictionless()) drive%brake = drive%balls + drive%flanks + 1
      end if
      call strip_face(drive%ring, ring, 1, 1, size(drive%ring%inner, 2), drive%radius - scene%ring_thickness, inside)
      if (scene%balls > 0) then
        patch = ball_patches(scene, inside, ring%sectors, problem%first(drive%b_ring))
        patch%struts = [(i, i=1, drive%balls)]
        if (scene%in_grooves()) then
          problem%groove = ball_grooves(scene, drive%balls + drive%flanks + drive%stays)
          patch%struts = [patch%struts, problem%groove%before + patch%struts]
          call add_stays(drive, axial_struts(scene, patch))
        end if
        problem%struts = [ball_struts(scene, patch), problem%struts]
        problem%holds = ring_holds(scene, drive%brake, problem%groove)
        if (allocated(problem%pairing)) problem%placing = patch
      end if
      problem%strut_rate = [0._dp*problem%struts%rate]
      if (allocated(problem%rub)) deallocate (problem%rub)
      if (scene%tooth_friction > 0) problem%rub = rub_t(scene%tooth_friction, [(drive%balls + i, i=1, drive%flanks)], &
        spread(0._dp, 1, drive%flanks), spread(.false., 1, drive%flanks))
      if (scene%spline == 'free') then
        problem%strut_give = spread(problem%struts%rate*0, 2, size(problem%struts))
        rim = drive%balls + [(i, i=1, drive%flanks), (i, i=drive%flanks + drive%stays + 1, size(problem%struts) - drive%balls)]
        problem%strut_give(rim, rim) = flank_compliance(scene)
      end if
      problem%wheel = drive%hub
    end associate
  end subroutine set_struts

  !> Without friction nothing resists the turn of a ring on balls, and large displacements let it drift. It is a body of revolution
  !> and may stand anywhere: a stay holds the mean of what its inner face has come round the axis, and nothing else. With
  !> friction it is a brake.
  type(strut_t) function turn_stay(drive, pulls) result(stay)
    type(drive_t), intent(in) :: drive   !< drive
    logical, intent(in) :: pulls         !< else a brake
    stay%pulls = pulls
    stay%power = 1
    stay%rate = drive%problem%law%scale*drive%radius**2
    stay%node = nodes_on(drive, drive%b_ring, drive%ring%inner)
    allocate (stay%weight(3, size(stay%node)), source=0._dp)
    stay%weight(2, :) = 1._dp/size(stay%node)
  end function turn_stay

  !> Put struts behind flanks and stays, before the companions of flanks; the balls are not there yet.
  subroutine add_stays(drive, more)
    type(drive_t), intent(inout) :: drive   !< gets them
    type(strut_t), intent(in) :: more(:)    !< struts
    type(strut_t), allocatable :: struts(:)
    integer :: n
    n = drive%flanks + drive%stays
    associate (now => drive%problem%struts)
      allocate (struts(size(now) + size(more)))
      struts(:n) = now(:n)
      struts(n + 1:n + size(more)) = more
      struts(n + size(more) + 1:) = now(n + 1:)
    end associate
    call move_alloc(struts, drive%problem%struts)
    drive%stays = drive%stays + size(more)
  end subroutine add_stays

  !> The teeth touch, or lie apart by their clearances: offsets of the flanks at the end of the assembly, without friction yet.
  subroutine touch_teeth(scene, drive, u, state)
    type(scene_t), intent(in) :: scene                   !< scene
    type(drive_t), intent(in) :: drive                   !< its model
    real(dp), intent(in) :: u(:, :)                      !< displacements at the end of the assembly (3, n) [m]
    type(state_t), intent(inout) :: state                !< state at that end; gets touch, past
    type(load_t) :: load
    integer :: i
    associate (flank => drive%problem%struts(drive%balls + 1:drive%balls + drive%flanks))
      state%touch = [(-closing_of(flank(i), u), i=1, size(flank))]
      state%touch(1::2) = state%touch(1::2) - tooth_gaps(scene, 1)
      state%touch(2::2) = state%touch(2::2) - tooth_gaps(scene, 2)
    end associate
    if (.not. allocated(drive%problem%rub)) return
    call drive_load(drive, 1._dp, 0._dp, 0._dp, load, state)
    load%past = 0
    call remember(drive%problem, load, state)
    state%past(3:, :) = 0
  end subroutine touch_teeth

  !> Springs of the balls between wave generator and ring, even over the ring's inner face.
  subroutine set_on_balls(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets springs
    integer, allocatable :: row(:)
    integer :: i, n
    n = size(drive%ring%inner, 2)
    associate (z => drive%ring%inner(2, :))
      do i = 1, n
        row = nodes_on(drive, drive%b_ring, drive%ring%inner(:, i:i))
        call add_springs(drive%problem, row, 1, scene%ball_stiffness*(z(min(i + 1, n)) - z(max(i - 1, 1)))/ &
          (2*(z(n) - z(1)))/size(row))
      end do
    end associate
  end subroutine set_on_balls

  !> Nodes of a body on a line of its meridian section, turned round the axis.
  function nodes_on(drive, b, line) result(list)
    type(drive_t), intent(in) :: drive       !< drive
    integer, intent(in) :: b                 !< body
    real(dp), intent(in) :: line(:, :)       !< r, z of its points by rising z, one: a circle (2, n) [m]
    integer, allocatable :: list(:)
    logical :: on(size(drive%reference, 2))
    real(dp) :: r, tol
    integer :: i, k
    tol = 1e-7_dp*drive%radius
    on = .false.
    associate (first => drive%problem%first(b), n => size(line, 2), z => drive%reference(3, :))
      do i = first + 1, first + drive%problem%bodies(b)%nodes()
        if (z(i) <= line(2, 1) - tol .or. z(i) >= line(2, n) + tol) cycle
        k = min(max(1, count(line(2, :) <= z(i))), max(1, n - 1))
        r = line(1, k)
        if (n > 1) r = r + (line(1, k + 1) - r)*(z(i) - line(2, k))/(line(2, k + 1) - line(2, k))
        on(i) = abs(drive%reference(1, i) - r) < tol
      end do
    end associate
    list = pack([(i, i=1, size(on))], on)
  end function nodes_on

  !> The wave generator and the displacements of the ring's inner face by it.
  subroutine turn_cam(scene, drive, error)
    type(scene_t), intent(in) :: scene                !< scene
    type(drive_t), intent(inout) :: drive             !< gets cam, inner, eccentricity, assembly
    type(error_t), allocatable, intent(out) :: error  !< measured cam
    real(dp) :: angle
    angle = scene%eccentricity_angle_deg*pi/180
    drive%eccentricity = scene%eccentricity*[cos(angle), sin(angle)]
    drive%inner = nodes_on(drive, drive%b_ring, drive%ring%inner)
    drive%exact = scene%large() .and. .not. scene%formed()
    drive%formed = scene%formed()
    if (.not. drive%formed) call new_cam(scene, scene%bore_radius - scene%ring_thickness, drive%cam, error)
    if (allocated(error)) return
    drive%assembly = assembled(drive, 1._dp)
    if (scene%support%struts) call turn_cam_under_balls(scene, drive)
  end subroutine turn_cam

  !> The cam at the balls: the inner race follows the cam, and an offset of the curve has its radial way. Without balls the slope of
  !> the cam at the nodes that it moves. Large displacements take the way on the cam's curve, whose mean radius is smaller by
  !> w**2/r than to first order, for the ring keeps its length.
  subroutine turn_cam_under_balls(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets way, slope
    real(dp), dimension(merge(scene%balls, size(drive%inner), scene%balls > 0)) :: theta, w, way, before, after, v
    type(curve_t) :: curve
    real(dp), parameter :: h = 1e-4_dp
    if (scene%balls > 0) then
      theta = ball_angles(scene)
      w = drive%cam%w
    else
      theta = drive%reference(2, drive%inner)
      w = drive%cam%deformation(drive%reference(3, drive%inner))
    end if
    call drive%cam%displace(w, theta - h, before, v)
    call drive%cam%displace(w, theta + h, after, v)
    if (drive%exact) then
      call new_curve(drive%cam, drive%cam%w, 1._dp, curve)
      way = curve%radius(theta) - drive%cam%radius
    else
      call drive%cam%displace(w, theta, way, v)
    end if
    associate (e => drive%eccentricity)
      drive%slope = (after - before)/(2*h) - e(1)*sin(theta) + e(2)*cos(theta)
      drive%way = way(:scene%balls) + e(1)*cos(theta(:scene%balls)) + e(2)*sin(theta(:scene%balls)) - scene%ball_clearance
    end associate
  end subroutine turn_cam_under_balls

  !> Displacements of the fixed dofs by a part of the assembly: to first order in w, or exactly on the cam's curve; the
  !> eccentricity is a displacement of the whole.
  function assembled(drive, part) result(x)
    type(drive_t), intent(in) :: drive  !< drive
    real(dp), intent(in) :: part        !< 0 to 1
    real(dp) :: x(3, drive%problem%n)
    real(dp), dimension(size(drive%inner)) :: theta, w, u, v
    x = 0
    u = 0
    v = 0
    theta = drive%reference(2, drive%inner)
    w = drive%cam%deformation(drive%reference(3, drive%inner))
    if (drive%exact) then
      call put_on_curve(drive%cam, w, theta, part, u, v)
    else if (.not. drive%formed) then
      call drive%cam%displace(w, theta, u, v)
      u = part*u
      v = part*v
    else  ! the first dof of formed bodies follows their normals
      associate (ring => drive%problem%bodies(drive%b_ring))
        theta = ring%angle(drive%inner - drive%problem%first(drive%b_ring))
      end associate
    end if
    associate (e => part*drive%eccentricity)
      x(1, drive%inner) = u + e(1)*cos(theta) + e(2)*sin(theta)
      x(2, drive%inner) = v + e(2)*cos(theta) - e(1)*sin(theta)
    end associate
  end function assembled

  !> Unit torque on the rim's outer face, or at the bottom of the whole drive.
  subroutine load_rim(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets torque, squeeze, gauge
    integer :: first
    first = drive%problem%first(drive%b_cup)
    allocate (drive%gauge(3, drive%problem%n), source=0._dp)
    drive%squeeze = drive%gauge
    if (scene%support%turns_bottom) then
      drive%gauge(2, drive%hub) = 1/(size(drive%hub)*drive%hub_radius)
      drive%torque = drive%gauge
      return
    end if
    associate (body => drive%problem%bodies(drive%b_cup), last => first + drive%problem%bodies(drive%b_cup)%nodes())
      drive%gauge(:, first + 1:last) = even_shear(scene, body, drive%rim)
      drive%torque = drive%gauge
      if (scene%torque_load == 'teeth') then
        call tooth_forces(scene, body, drive%rim, drive%torque(:, first + 1:last), drive%squeeze(:, first + 1:last))
      end if
    end associate
  end subroutine load_rim

  !> Coulomb coefficient of a load step; 0 where the contact takes no shear.
  pure real(dp) function step_friction(scene, loaded) result(friction)
    type(scene_t), intent(in) :: scene    !< scene
    logical, intent(in) :: loaded         !< by the torque, else in the assembly
    friction = merge(scene%torque_friction, scene%friction, loaded .and. scene%torque_friction > 0)
    if (scene%frictionless()) friction = 0
  end function step_friction

  !> Load at a fraction of the assembly and a torque, which the whole drive has at its bottom, others on the rim.
  subroutine drive_load(drive, assembly, torque, friction, load, state, before)
    type(drive_t), intent(in) :: drive    !< drive
    real(dp), intent(in) :: assembly      !< fraction of the assembly, 0 to 1
    real(dp), intent(in) :: torque        !< torque [N m]
    real(dp), intent(in) :: friction      !< Coulomb coefficient of the step
    type(load_t), intent(out) :: load     !< load
    type(state_t), intent(in), optional :: state   !< its flanks are there, once the assembly has ended;
    type(state_t), intent(in), optional :: before  !< at the beginning of the step they remember this state, else `state`
    integer :: i, m
    load%friction = friction
    if (drive%exact .and. assembly < 1) then
      load%displacement = assembled(drive, assembly)
    else
      allocate (load%displacement, mold=drive%assembly)
    end if
    allocate (load%force, mold=drive%torque)
    !$omp parallel do schedule(static) if(size(load%force) > many)
    do i = 1, size(load%force, 2)
      if (.not. drive%exact .or. assembly >= 1) load%displacement(:, i) = assembly*drive%assembly(:, i)
      load%force(:, i) = torque*drive%torque(:, i) + abs(torque)*drive%squeeze(:, i)
      load%force(1, i) = load%force(1, i) + drive%problem%spring(1, i)*load%displacement(1, i)
    end do
    !$omp end parallel do
    if (allocated(drive%problem%struts)) call strut_load(drive, assembly, load, state, before)
    associate (mortar => drive%problem%mortar)
      m = mortar%n - mortar%rigid
      load%gap = [spread(-assembly*drive%interference, 1, m), -load%displacement(1, mortar%node(m + 1:))]
    end associate
  end subroutine drive_load

  !> The same of struts alone.
  subroutine strut_load(drive, assembly, load, state, before)
    type(drive_t), intent(in) :: drive    !< drive with struts
    real(dp), intent(in) :: assembly      !< as of drive_load
    type(load_t), intent(inout) :: load   !< gets closing, past
    type(state_t), intent(in), optional :: state, before  !< as of drive_load
    load%closing = [real(dp) :: assembly*drive%way, spread(absent, 1, drive%flanks), &
      spread(0._dp, 1, size(drive%problem%struts) - drive%balls - drive%flanks)]
    if (drive%brake > 0) load%closing(drive%brake) = absent
    load%past = reshape([real(dp) ::], [memories, size(load%closing) - drive%balls - drive%flanks - drive%stays], pad=[0._dp])
    if (present(state)) then
      if (size(state%touch) > 0) load%closing(drive%balls + 1:drive%balls + drive%flanks) = state%touch
      if (size(state%past) > 0) load%past = state%past
    end if
    if (present(before)) then
      if (size(before%past) > 0) load%past = before%past
    end if
  end subroutine strut_load
end module hd_drive
