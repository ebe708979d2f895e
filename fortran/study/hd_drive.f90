! SPDX-License-Identifier: GPL-3.0-or-later
!> The harmonic drive scene as a contact problem: flexspline cup, bearing ring, wave generator, supports and torque.
!>
!> The z axis is the drive's axis, z = 0 the opening of the cup. Body 1 carries the multipliers (slave): the ring, or the cup
!> with contact.slave = 'cup'. Tractions and relative displacements are those of the cup against the ring in either case.
module hd_drive
  use hd_kinds, only: dp, pi
  use hd_cam, only: cam_deformation, cam_displacement, form_body, formed_curve
  use hd_error, only: error_t
  use hd_scene, only: scene_t
  use hd_body, only: body_t
  use hd_face, only: face_t
  use hd_revolution, only: strip_t, revolve, strip_face
  use hd_section, only: ring_strip, cup_strip, rim_end
  use hd_hexahedron, only: element_kind
  use hd_mortar, only: add_rigid, new_mortar
  use hd_problem, only: problem_t, load_t, new_problem, add_springs
  use hd_rim_load, only: even_shear, tooth_forces
  use hd_contact_law, only: contact_mode
  implicit none
  private
  public :: drive_t, new_drive, renew_drive, drive_load

  type :: drive_t
    type(problem_t) :: problem               !< bodies, supports, interface
    type(strip_t) :: ring, cup               !< meridian sections
    integer :: b_ring = 1, b_cup = 2         !< their bodies
    type(face_t) :: face                     !< contact face of the slave
    type(face_t) :: rim                      !< outside of the rim, nodes numbered in the cup
    integer :: axial_facets = 0              !< facets of that face along the axis
    real(dp) :: radius = 0                   !< contact radius [m]
    real(dp), allocatable :: assembly(:, :)  !< displacements of the fixed dofs by the whole assembly (3, n) [m]
    real(dp), allocatable :: reference(:, :) !< r, theta, z of the nodes before any forming (3, n) [m, rad, m]
    real(dp), allocatable :: torque(:, :)    !< nodal forces of a unit torque (3, n) [1/m]
    real(dp), allocatable :: squeeze(:, :)   !< radial forces that come with a unit torque of either sense (3, n) [1/m]
    real(dp), allocatable :: gauge(:, :)     !< even shear of a unit torque: weights of the rotation of the rim (3, n) [1/m]
    real(dp) :: interference = 0             !< radial interference [m]
    integer, allocatable :: sprung(:)        !< nodes held by the soft springs of a bearing support
    real(dp) :: spring_rate = 0              !< stiffness at each of them, radial and tangential [N/m]
    real(dp) :: hub_radius = 0               !< [m]
    integer, allocatable :: hub(:)           !< nodes at the inner edge of the bottom
  end type drive_t

contains

  !> Build the problem of a scene.
  subroutine new_drive(scene, drive, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    type(drive_t), intent(out) :: drive               !< problem and loads
    type(error_t), allocatable, intent(out) :: error  !< inverted element, out of memory
    type(body_t) :: bodies(2)
    type(face_t) :: slave, master, inside, bore
    integer :: kind, sectors, first, last
    call element_kind(scene%element, kind, error)
    if (allocated(error)) return
    drive%radius = scene%bore_radius
    call ring_strip(scene, drive%ring)
    call cup_strip(scene, drive%cup, first, last)
    sectors = merge(scene%ring_divisions, scene%divisions, scene%ring_divisions > 0)
    if (scene%slave == 'cup') then
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
      call strip_face(drive%cup, cup, 1, 1, count(drive%cup%inner(1, :) >= drive%radius), drive%radius, bore)
      call strip_face(drive%cup, cup, drive%cup%layers + 1, 1, rim_end(scene, drive%cup), drive%radius, drive%rim)
    end associate
    drive%axial_facets = size(drive%ring%inner, 2) - 1
    if (scene%slave == 'cup') then
      drive%axial_facets = last - first
      slave = master
      master = drive%face
      drive%face = slave
      bore = master
    end if
    master%nodes = master%nodes + bodies(1)%nodes()
    bore%nodes = bore%nodes + bodies(1)%nodes()
    drive%reference = reshape([cylindrical(bodies(1)), cylindrical(bodies(2))], [3, sum(bodies%sectors*bodies%nodes_per_sector)])
    if (scene%shape == 'as_formed') then
      call form_body(scene, bodies(1))
      call form_body(scene, bodies(2))
    end if
    call new_problem(bodies, drive%problem, error)
    if (allocated(error)) return
    call new_mortar(drive%face, master, drive%problem%mortar)
    inside%nodes = inside%nodes + drive%problem%first(drive%b_ring)
    if (scene%kinematics == 'nonlinear' .and. scene%contact_mode /= 'bonded' .and. (scene%shape == 'pressed' .or. &
      .not. abs(scene%cone_angle_deg) > 0)) call follow_faces(scene, drive, bore, inside)
    if (scene%slave == 'cup') drive%problem%mortar%val = -drive%problem%mortar%val
    if (scene%ring_contact == 'unilateral') call add_rigid(drive%problem%mortar, inside)
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
      if (scene%ring_contact == 'unilateral') pairing%inside = inside
      pairing%radius = drive%radius
      if (scene%slave == 'cup') pairing%sign = -1
      pairing%slave_nodes = drive%problem%bodies(1)%nodes()
      allocate (pairing%stretch(n), source=1._dp)
      allocate (pairing%bend(n), source=1/drive%radius)
      if (scene%shape == 'as_formed') call formed_curve(scene, drive%reference(2, pairing%rest%node), pairing%stretch, pairing%bend)
    end associate
  end subroutine follow_faces

  !> Enter what leaves mesh, supports and stiffness as they are: contact law, wave generator.
  subroutine renew_drive(scene, drive, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    type(drive_t), intent(inout) :: drive             !< drive of a scene that differs in nothing else
    type(error_t), allocatable, intent(out) :: error  !< unknown contact mode
    drive%interference = scene%interference
    call contact_mode(scene%contact_mode, drive%problem%law%mode, error)
    if (allocated(error)) return
    drive%problem%law%friction = scene%friction
    call turn_cam(scene, drive)
  end subroutine renew_drive

  !> r, theta, z of the nodes of a revolved body.
  pure function cylindrical(body) result(c)
    type(body_t), intent(in) :: body  !< body
    real(dp) :: c(3, size(body%x, 2))
    c(1, :) = hypot(body%x(1, :), body%x(2, :))
    c(2, :) = body%angle
    c(3, :) = body%x(3, :)
  end function cylindrical

  !> Supports. The wave generator prescribes the ring's inner face, or the ends of the balls' springs that pull it. The ring is held
  !> axially along the middle of that face.
  subroutine hold(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets its fixed dofs and springs
    integer, allocatable :: hub(:), inner(:)
    real(dp) :: z, corner
    associate (problem => drive%problem)
      inner = nodes_at(drive, drive%b_ring, scene%bore_radius - scene%ring_thickness)
      problem%fixed(1, inner) = scene%ring_contact == 'tied' .and. .not. scene%ball_stiffness > 0
      if (scene%ball_stiffness > 0) call set_on_balls(scene, drive)
      if (scene%ring_tangent == 'follow') then
        problem%fixed(2, inner) = .true.
      else if (scene%contact_mode /= 'bonded') then
        call add_springs(problem, inner, 2, scene%support_stiffness/size(inner))
      end if
      z = drive%ring%inner(2, (size(drive%ring%inner, 2) + 1)/2)
      problem%fixed(3, nodes_at(drive, drive%b_ring, scene%bore_radius - scene%ring_thickness, z, z)) = .true.
      corner = scene%cup_length - scene%bottom_thickness
      drive%hub_radius = scene%hub_radius
      allocate (drive%sprung(0))
      hub = nodes_at(drive, drive%b_cup, scene%hub_radius, corner, scene%cup_length)
      problem%fixed(3, hub) = .true.
      drive%hub = hub
      if (scene%support /= 'bearing') then
        problem%fixed(:, hub) = .true.
      else
        drive%sprung = hub
        drive%spring_rate = scene%support_stiffness/size(hub)
        call add_springs(problem, hub, 1, drive%spring_rate)
        call add_springs(problem, hub, 2, drive%spring_rate)
      end if
    end associate
  end subroutine hold

  !> Springs of the balls between wave generator and ring, even over the ring's inner face.
  subroutine set_on_balls(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets springs
    integer, allocatable :: row(:)
    integer :: i, n
    n = size(drive%ring%inner, 2)
    associate (r => scene%bore_radius - scene%ring_thickness, z => drive%ring%inner(2, :))
      do i = 1, n
        row = nodes_at(drive, drive%b_ring, r, z(i), z(i))
        call add_springs(drive%problem, row, 1, scene%ball_stiffness*(z(min(i + 1, n)) - z(max(i - 1, 1)))/ &
          (2*(z(n) - z(1)))/size(row))
      end do
    end associate
  end subroutine set_on_balls

  !> Nodes of a body on a cylinder, between two heights.
  function nodes_at(drive, b, r, z_low, z_high) result(list)
    type(drive_t), intent(in) :: drive              !< drive
    integer, intent(in) :: b                        !< body
    real(dp), intent(in) :: r                       !< radius [m]
    real(dp), intent(in), optional :: z_low, z_high !< heights, default all [m]
    integer, allocatable :: list(:)
    real(dp) :: range(2), tol
    integer :: i
    tol = 1e-7_dp*drive%radius
    range = [-1, 1]*huge(tol)
    if (present(z_low)) range = [z_low - tol, z_high + tol]
    associate (first => drive%problem%first(b), n => drive%problem%bodies(b)%nodes())
      list = pack([(i, i=first + 1, first + n)], abs(drive%reference(1, first + 1:first + n) - r) < tol .and. &
        drive%reference(3, first + 1:first + n) > range(1) .and. drive%reference(3, first + 1:first + n) < range(2))
    end associate
  end function nodes_at

  !> Displacements of the ring's inner face by the wave generator and its eccentricity.
  subroutine turn_cam(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets assembly
    real(dp), allocatable :: t(:), u(:), v(:), du(:), dv(:)
    real(dp) :: r, angle
    integer, allocatable :: inner(:)
    integer :: i
    angle = scene%eccentricity_angle_deg*pi/180
    r = scene%bore_radius - scene%ring_thickness
    drive%assembly = reshape([(0._dp, i=1, 3*drive%problem%n)], [3, drive%problem%n])
    inner = nodes_at(drive, drive%b_ring, r)
    t = drive%reference(2, inner)
    drive%assembly(1, inner) = scene%eccentricity*cos(t - angle)
    drive%assembly(2, inner) = -scene%eccentricity*sin(t - angle)
    if (scene%shape == 'as_formed') return
    allocate (u, v, du, dv, mold=t)
    call cam_displacement(scene%cam, r, cam_deformation(scene, drive%reference(3, inner)), t, u, v, du, dv)
    drive%assembly(1, inner) = drive%assembly(1, inner) + u
    drive%assembly(2, inner) = drive%assembly(2, inner) + v
  end subroutine turn_cam

  !> Unit torque on the rim's outer face.
  subroutine load_rim(scene, drive)
    type(scene_t), intent(in) :: scene     !< scene
    type(drive_t), intent(inout) :: drive  !< gets torque, squeeze, gauge
    integer :: first
    first = drive%problem%first(drive%b_cup)
    allocate (drive%gauge(3, drive%problem%n), source=0._dp)
    drive%squeeze = drive%gauge
    associate (body => drive%problem%bodies(drive%b_cup), last => first + drive%problem%bodies(drive%b_cup)%nodes())
      drive%gauge(:, first + 1:last) = even_shear(scene, body, drive%rim)
      drive%torque = drive%gauge
      if (scene%torque_load == 'teeth') &
        call tooth_forces(scene, body, drive%rim, drive%torque(:, first + 1:last), drive%squeeze(:, first + 1:last))
    end associate
  end subroutine load_rim

  !> Load at a fraction of the assembly and a torque.
  pure subroutine drive_load(drive, assembly, torque, load)
    type(drive_t), intent(in) :: drive    !< drive
    real(dp), intent(in) :: assembly      !< fraction of the assembly, 0 to 1
    real(dp), intent(in) :: torque        !< torque on the rim [N m]
    type(load_t), intent(out) :: load     !< load
    integer :: m
    load%displacement = assembly*drive%assembly
    load%force = torque*drive%torque + abs(torque)*drive%squeeze
    load%force(1, :) = load%force(1, :) + drive%problem%spring(1, :)*load%displacement(1, :)
    associate (mortar => drive%problem%mortar)
      m = mortar%n - mortar%rigid
      load%gap = [spread(-assembly*drive%interference, 1, m), -load%displacement(1, mortar%node(m + 1:))]
    end associate
  end subroutine drive_load
end module hd_drive
