! SPDX-License-Identifier: GPL-3.0-or-later
!> Neighbours of a run: its drive with one key changed a little, and what that leaves in the run's equations.
module hd_neighbour
  use hd_kinds, only: dp
  use hd_conditions, only: check_scene
  use hd_contact_law, only: contact_law_t
  use hd_cup_sections, only: adopt_sections, has_sections
  use hd_drive, only: drive_t, new_drive, renew_drive, step_friction, strut_load
  use hd_error, only: error_t
  use hd_idle_keys, only: is_idle
  use hd_joint, only: joint_t
  use hd_load_path, only: place_t, assembly_at, torque_at, under_torque
  use hd_mortar, only: mortar_t, add_nodal_forces, relative_displacement
  use hd_newton, only: linear_equations, prescribe
  use hd_parameter_row, only: parameter_t, parameter_table_t, stage_model, stage_load
  use hd_parameters, only: new_table, value_count
  use hd_problem, only: problem_t, state_t, load_t, body_forces, elastic_forces, forces_at, linear_forces, strut_closings
  use hd_scene, only: scene_t
  use hd_scene_joint, only: scene_joint, tabulate_joint
  use hd_strut, only: push
  use hd_strut_step, only: straight
  use hd_text, only: string_t
  implicit none
  private
  public :: neighbour_t, find_neighbours, change_residuals, change_law, forces_of, share_of_state

  !> Shares of its value by which a key is changed. What bends the bodies is changed more: their forces are small sums of large
  !> terms, whose rounding must stay small beside the change (2e-6 of a result over its key; by 1e-7 4e-5).
  real(dp), parameter :: share = 1e-7_dp, share_of_shape = 5e-7_dp, share_of_material = 3e-6_dp
  real(dp), parameter :: share_of_state = 1e-7_dp  !< by which a traction or a stress is changed
  real(dp), parameter :: rounding = 1e-12_dp       !< of weights and areas of a coupling, relative
  !> In the place of a value that is 0.
  real(dp), parameter :: typical_m = 1e-3_dp, typical_deg = 60, typical_other = 1

  !> Units that hold one of force: with all keys in these f times as large a drive turns as before under f times the torque.
  character(len=7), parameter :: of_force(5) = ['N      ', 'N/m    ', 'N/m^1.5', 'N m    ', 'Pa     ']

  !> The run's drive with one key changed.
  type :: neighbour_t
    type(string_t) :: key                            !< group.key
    real(dp) :: change = 0                           !< of it
    real(dp) :: force = 0                            !< its value, if its unit holds one of force
    logical :: idle = .false.                        !< the key has no part in the equilibrium
    logical :: whole = .false.                       !< bodies, supports, nodal loads or places of struts are others: else
    logical :: struts = .false., law = .false.       !< it has struts and contact law only, which may be others
    logical :: bodies = .false., moves = .false.     !< of those the bodies, or displacements that are given
    integer, allocatable :: stiff(:)                 !< bodies of another stiffness, where faces and all displacements given are
                                                     !< the run's; else unallocated
    integer, allocatable :: loaded(:)                !< nodes with springs or nodal loads, of a whole one
    logical :: rough = .false.                       !< the joint or its friction may be another
    type(scene_t) :: scene
    type(drive_t), allocatable :: drive              !< unless it is idle
    type(joint_t) :: joint
  end type neighbour_t

contains

  !> The drives of all real keys, or of some.
  subroutine find_neighbours(scene, drive, joint, of, keys, error, only)
    type(scene_t), intent(in) :: scene                !< of the run
    type(drive_t), intent(in) :: drive                !< its drive
    type(joint_t), intent(in) :: joint                !< its joint
    type(neighbour_t), allocatable, intent(out) :: of(:)  !< of the keys, and room
    integer, intent(out) :: keys                      !< how many
    type(error_t), allocatable, intent(out) :: error  !< mesh, joint
    type(string_t), intent(in), optional :: only(:)   !< keys that are wanted; those that hold forces come with them
    type(scene_t), target :: copy
    type(drive_t), allocatable :: spare
    type(parameter_table_t) :: table
    integer, allocatable :: rows(:)
    logical :: felt, fits, wanted
    integer :: i, j
    copy = scene
    call new_table(copy, table)
    rows = pack([(i, i=1, size(table%rows))], [(is_real(table%rows(i), scene), i=1, size(table%rows))])
    allocate (of(size(rows)))
    felt = .not. (present(only) .and. scene%hard())
    keys = 0
    do i = 1, size(rows)
      associate (p => table%rows(rows(i)))
        wanted = .true.
        if (present(only)) wanted = any(p%unit == of_force) .or. any([(p%group//'.'//p%key == only(j)%s, j=1, size(only))])
      end associate
      if (.not. wanted) cycle
      call change_key(scene, copy, table, rows(i), felt, drive, joint, spare, of(keys + 1), fits, error)
      if (allocated(error)) return
      if (fits) keys = keys + 1
    end do
  end subroutine find_neighbours

  !> A key counts: a number of the drive, in use. Where 0 is a word for something else, the number is not in use.
  pure logical function is_real(p, scene)
    type(parameter_t), intent(in) :: p   !< row
    type(scene_t), intent(in) :: scene   !< scene
    logical :: zero
    is_real = .false.
    if (.not. (associated(p%real) .or. associated(p%count)) .or. p%stage(.true., .true.) > stage_load) return
    if (any(p%group == [character(len=8) :: 'run', 'mesh', 'solver', 'surface', 'fit']) .or. is_idle(scene, p%group, p%key)) return
    if (associated(p%real)) then
      zero = .not. abs(p%real) > 0
    else
      zero = .not. any(abs(p%reals(:value_count(p))) > 0)
    end if
    is_real = .not. (zero .and. (index(p%meaning, '0: ') > 0 .or. associated(p%count)))
    if (p%key == 'clearance' .and. p%group == 'wave_generator') is_real = is_real .and. (.not. zero .or. &
      .not. scene%interference > 0)  ! it would take the place of an interference
    if (p%key == 'interference') is_real = is_real .and. .not. scene%clearance > 0
  end function is_real

  !> A key of balls, flanks and circular spline, which are set anew on bodies as they are.
  pure logical function is_of_struts(p, scene) result(is)
    type(parameter_t), intent(in) :: p   !< row
    type(scene_t), intent(in) :: scene   !< scene
    is = scene%support%struts .and. (p%key == 'tooth_stiffness' .or. index(p%key, 'spline') == 1 .or. &
      (p%group == 'bearing' .and. p%key /= 'groove_depth'))
  end function is_of_struts

  !> The drive with a key changed, upwards if that is valid and can be meshed. What is read at the torque of a step is read on the
  !> side that a larger torque of the steps leaves it on: downwards.
  subroutine change_key(scene, moved, table, row, felt, drive, joint, spare, other, fits, error)
    type(scene_t), intent(in) :: scene                !< of the run
    type(scene_t), intent(inout), target :: moved     !< the table's, gets the change
    type(parameter_table_t), intent(inout) :: table   !< its keys
    integer, intent(in) :: row                        !< of the table
    logical, intent(in) :: felt                       !< the joint counts
    type(drive_t), intent(in) :: drive                !< of the run
    type(joint_t), intent(in) :: joint                !< of the run
    type(drive_t), allocatable, intent(inout) :: spare  !< a copy of the drive, but for what renew_drive sets, if there is one
    type(neighbour_t), intent(out) :: other           !< neighbour
    logical, intent(out) :: fits                      !< it is valid, on the same mesh
    type(error_t), allocatable, intent(out) :: error  !< joint
    type(string_t), allocatable :: faults(:)
    type(error_t), allocatable :: refused
    type(drive_t), allocatable :: light
    real(dp) :: value
    logical :: law, renewed
    integer :: try
    do try = 1, -1, -2
      moved = scene
      associate (p => table%rows(row))
        call move_key(scene, p, try, other, fits)
        if (.not. fits) cycle
        allocate (faults(0))
        if (has_sections(moved)) then
          if (associated(p%real)) value = p%real
          call adopt_sections(moved, table, faults)
          if (associated(p%real)) fits = .not. abs(p%real - value) > 0  ! else the sections settle it
        end if
        if (fits) call check_scene(moved, faults)
        fits = fits .and. size(faults) == 0
        deallocate (faults)
        if (.not. fits) cycle
        other%scene = moved
        other%joint = joint
        other%rough = any(p%group == [character(len=8) :: 'material', 'joint', 'contact'])
        law = felt .and. other%rough
        if (law) call scene_joint(moved, other%joint, error, scene, joint)
        if (allocated(error) .or. other%idle) return
        renewed = p%stage(scene%formed(), .not. scene%hard()) > stage_model .or. is_of_struts(p, scene)
        if (renewed) then
          if (.not. allocated(spare)) spare = drive
          call move_alloc(spare, other%drive)
          call renew_drive(moved, other%drive, refused)
        else
          if (allocated(other%drive)) deallocate (other%drive)
          allocate (other%drive)
          call new_drive(moved, other%drive, refused, alike=.true.)
        end if
        fits = .not. allocated(refused)
        if (.not. fits) cycle
        if (.not. scene%hard()) then
          if (.not. allocated(other%drive%problem%law%joint)) allocate (other%drive%problem%law%joint)
          call tabulate_joint(moved, other%joint, other%drive%problem%law%joint, error)
        end if
        if (allocated(error)) return
        fits = same_mesh(other%drive, drive)
        if (.not. fits) cycle
        if (.not. renewed) other%bodies = .not. same_bodies(other%drive, drive)
        call compare_drives(scene, drive, other, law, light)
        if (.not. allocated(light)) return
        if (renewed) call move_alloc(other%drive, spare)
        call move_alloc(light, other%drive)
        return
      end associate
    end do
  end subroutine change_key

  !> Change a key of the neighbour's scene, upwards or downwards.
  subroutine move_key(scene, p, way, other, fits)
    type(scene_t), intent(in) :: scene           !< of the run
    type(parameter_t), intent(inout) :: p        !< the key
    integer, intent(in) :: way                   !< 1 or -1
    type(neighbour_t), intent(inout) :: other    !< gets what is known of the key, and its change
    logical, intent(out) :: fits                 !< the value is valid
    integer :: side
    other%key%s = p%group//'.'//p%key
    side = way
    if (any(other%key%s == [character(len=17) :: 'loop.torque_1', 'loop.torque_2', 'loop.rated_torque'])) side = -way
    other%idle = (any(p%group == [character(len=7) :: 'loop', 'fatigue', 'turning']) .and. .not. any(p%key == [ &
      character(len=12) :: 'torques', 'torque_1', 'torque_2', 'rated_torque'])) .or. &
      (scene%hard() .and. (p%group == 'joint' .or. index(p%key, 'yield') > 0))
    if (associated(p%real)) then
      if (any(p%unit == of_force)) other%force = p%real
      other%change = side*change_of(p, abs(p%real))
      p%real = p%real + other%change
      fits = p%real > p%low .and. p%real < p%high
    else
      associate (x => p%reals(:value_count(p)))
        other%change = side*change_of(p, maxval(abs(x)))
        x = x + other%change
        fits = all(x > p%low .and. x < p%high)
      end associate
    end if
  end subroutine move_key

  !> Find what of a drive is another's; of one with the run's bodies nothing else need be kept.
  subroutine compare_drives(scene, drive, other, law, light)
    type(scene_t), intent(in) :: scene           !< of the run
    type(drive_t), intent(in) :: drive           !< of the run
    type(neighbour_t), intent(inout) :: other    !< neighbour
    logical, intent(in) :: law                   !< its joint may be another
    type(drive_t), allocatable, intent(out) :: light  !< that, unless it is whole
    logical :: felt(3, size(drive%assembly, 2))
    integer :: i
    felt = drive%problem%fixed .or. drive%problem%spring > 0
    associate (mortar => drive%problem%mortar)
      felt(1, mortar%node(mortar%n - mortar%rigid + 1:)) = .true.
    end associate
    other%moves = any(felt .and. abs(other%drive%assembly - drive%assembly) > 0)
    if (other%bodies .and. .not. other%moves .and. allocated(drive%problem%sector)) then
      if (same_faces(other%drive%problem%mortar, drive%problem%mortar)) other%stiff = stiff_bodies(other%drive, drive)
    end if
    other%bodies = other%bodies .or. other%moves
    other%whole = other%bodies .or. &
      abs(other%scene%torque - scene%torque) > 0 .or. any(abs(other%scene%torques - scene%torques) > 0) .or. &
      (scene%support%loop .and. any(abs([other%scene%rated_torque - scene%rated_torque, other%scene%torque_1 - scene%torque_1, &
      other%scene%torque_2 - scene%torque_2]) > 0))
    other%law = abs(other%drive%interference - drive%interference) > 0 .or. abs(other%scene%friction - scene%friction) > 0 .or. &
      abs(other%scene%torque_friction - scene%torque_friction) > 0 .or. (law .and. .not. scene%hard()) .or. &
      abs(other%drive%problem%law%scale - drive%problem%law%scale) > 0
    if (allocated(drive%problem%struts)) then
      associate (a => drive%problem%struts, b => other%drive%problem%struts)
        do i = 1, size(a)
          other%whole = other%whole .or. size(a(i)%node) /= size(b(i)%node)
          if (other%whole) exit
          other%whole = any(a(i)%node /= b(i)%node) .or. any(abs(a(i)%weight - b(i)%weight) > 0)
          other%struts = other%struts .or. abs(a(i)%rate - b(i)%rate) > 0
        end do
      end associate
      if (allocated(drive%problem%strut_give)) other%struts = other%struts .or. any(abs(other%drive%problem%strut_give - &
        drive%problem%strut_give) > 0)
      if (allocated(drive%problem%groove)) other%struts = other%struts .or. abs(other%drive%problem%groove%reach - &
        drive%problem%groove%reach) > 0
      other%struts = other%struts .or. any(abs(other%drive%way - drive%way) > 0)
    end if
    if (other%whole) then
      other%loaded = pack([(i, i=1, other%drive%problem%n)], other%drive%problem%spring(1, :) > 0 .or. &
        any(abs(other%drive%torque) + abs(other%drive%squeeze) > 0, 1))
      return
    end if
    allocate (light)
    light%balls = drive%balls
    light%flanks = drive%flanks
    light%stays = drive%stays
    light%brake = drive%brake
    light%interference = other%drive%interference
    light%problem%law = other%drive%problem%law
    if (allocated(drive%problem%struts)) then
      light%way = other%drive%way
      light%problem%struts = other%drive%problem%struts
      light%problem%strut_rate = other%drive%problem%strut_rate
      if (allocated(drive%problem%strut_give)) light%problem%strut_give = other%drive%problem%strut_give
      if (allocated(drive%problem%groove)) light%problem%groove = other%drive%problem%groove
    end if
  end subroutine compare_drives

  !> Two drives have the same mesh but for small shifts of its nodes.
  pure logical function same_mesh(a, b) result(same)
    type(drive_t), intent(in) :: a, b  !< drives
    real(dp), parameter :: small = 1e-5_dp  !< over the radius
    same = a%problem%n == b%problem%n .and. a%problem%mortar%n == b%problem%mortar%n
    if (same) same = maxval(abs(a%reference([1, 3], :) - b%reference([1, 3], :))) < small*b%radius
  end function same_mesh

  !> Two drives of one mesh have the same bodies, springs and nodal loads: they may differ in struts, cam and law.
  pure logical function same_bodies(a, b) result(same)
    type(drive_t), intent(in) :: a, b  !< drives
    same = size(stiff_bodies(a, b)) == 0 .and. .not. any(abs(a%torque - b%torque) > 0 .or. abs(a%squeeze - b%squeeze) > 0 .or. &
      abs(a%gauge - b%gauge) > 0)
  end function same_bodies

  !> Bodies whose stiffness, springs included, is not the same in two drives of one mesh.
  pure function stiff_bodies(a, b) result(list)
    type(drive_t), intent(in) :: a, b  !< drives
    integer, allocatable :: list(:)
    integer :: i
    allocate (list(0))
    do i = 1, size(a%problem%bodies)
      associate (p => a%problem%bodies(i), q => b%problem%bodies(i), low => a%problem%first(i) + 1, &
        high => a%problem%first(i) + a%problem%bodies(i)%nodes())
        if (any(abs(p%x - q%x) > 0) .or. abs(p%young - q%young) > 0 .or. abs(p%poisson - q%poisson) > 0 .or. &
          any(abs(a%problem%spring(:, low:high) - b%problem%spring(:, low:high)) > 0)) list = [list, i]
      end associate
    end do
  end function stiff_bodies

  !> Two drives of one mesh have the same faces, but for rounding.
  pure logical function same_faces(a, b) result(same)
    type(mortar_t), intent(in) :: a, b  !< of the drives
    same = size(a%val) == size(b%val)
    if (same) same = .not. (any(abs(a%val - b%val) > rounding*maxval(abs(b%val))) .or. &
      any(abs(a%area - b%area) > rounding*maxval(b%area)))
  end function same_faces

  !> Change of a key of a size.
  pure real(dp) function change_of(p, size) result(change)
    type(parameter_t), intent(in) :: p   !< row
    real(dp), intent(in) :: size         !< amount of its value
    change = share
    if (p%group == 'geometry') change = share_of_shape
    if (p%group == 'material') change = share_of_material
    if (size > 0) then
      change = change*size
      return
    end if
    change = change*merge(typical_m, merge(typical_deg, typical_other, p%unit == 'deg'), p%unit == 'm')
  end function change_of

  !> Residuals of a drive in a state of the run: all of its forces, and the change of the law's by its displacements. The way of a
  !> step is taken as linear: a change may be larger than the slip in it. Struts meet no displacements that are given.
  subroutine change_residuals(c, drive, place, load, before, state, pressed, bare, dw, r_u, r_c)
    type(neighbour_t), intent(inout) :: c           !< its drive gets whether the wheel turns
    type(drive_t), intent(in) :: drive              !< of the run
    type(place_t), intent(in) :: place              !< here
    type(load_t), intent(in) :: load                !< of the run
    type(state_t), intent(in) :: before, state      !< of the run: at the beginning of the step, and here
    real(dp), intent(in) :: pressed(:, :), bare(:, :)  !< forces of the run's contact, and with those of its bodies (3, n) [N]
    real(dp), intent(in) :: dw(:, :, :)             !< derivatives of its law (3, 3, points) [Pa/m]
    real(dp), intent(out) :: r_u(:, :), r_c(:, :)   !< residuals (3, n) [N], change (3, points) [Pa]
    real(dp), allocatable :: force(:), u(:, :)
    type(load_t) :: other
    real(dp) :: w(3, size(r_c, 2)), part, torque
    integer :: j, m
    associate (problem => c%drive%problem)
      problem%wheel_turns = drive%problem%wheel_turns
      part = assembly_at(c%scene, place)
      torque = torque_at(c%scene, place)
      if (allocated(c%stiff)) then
        r_u = bare
        do j = 1, size(c%stiff)
          associate (low => problem%first(c%stiff(j)) + 1, high => problem%first(c%stiff(j)) + &
            problem%bodies(c%stiff(j))%nodes())
            call body_forces(problem, c%stiff(j), state%u, r_u)
            r_u(:, low:high) = r_u(:, low:high) + pressed(:, low:high)
          end associate
        end do
        r_c = 0
      else if (c%bodies) then
        if (c%moves) then
          u = state%u
          other%displacement = part*c%drive%assembly
          call prescribe(problem, other, u)
          call elastic_forces(problem, u, r_u)
          w = relative_displacement(problem%mortar, u)
        else
          call elastic_forces(problem, state%u, r_u)
          w = relative_displacement(problem%mortar, state%u)
        end if
        call add_nodal_forces(problem%mortar, state%traction, r_u, factor=-1._dp)
        w(1, :) = w(1, :) - (state%gap - load%gap)
        w(2:, :) = w(2:, :) - state%slip
        m = problem%mortar%n - problem%mortar%rigid
        if (c%moves) w(1, m + 1:) = w(1, m + 1:) - other%displacement(1, problem%mortar%node(m + 1:)) - load%gap(m + 1:)
        r_c = relative_displacement(problem%mortar, before%u)
        w(2:, :) = w(2:, :) - (r_c(2:, :) - before%slip)
        do j = 1, size(r_c, 2)
          r_c(:, j) = matmul(dw(:, :, j), w(:, j))
        end do
      else
        r_u = bare
        r_c = 0
      end if
      do j = 1, size(c%loaded)
        associate (r => r_u(:, c%loaded(j)))
          r = r - torque*c%drive%torque(:, c%loaded(j)) - abs(torque)*c%drive%squeeze(:, c%loaded(j))
          r(1) = r(1) - problem%spring(1, c%loaded(j))*part*c%drive%assembly(1, c%loaded(j))
        end associate
      end do
      if (.not. allocated(problem%struts)) return
      call strut_load(c%drive, part, other, before)
      force = forces_of(problem, drive%problem%strut_rate, other, state%u)
      do j = 1, size(force)
        if (abs(force(j)) > 0) call push(problem%struts(j), force(j), r_u)
      end do
    end associate
  end subroutine change_residuals

  !> Residuals of another law, less those of the run.
  subroutine change_law(c, problem, place, load, before, state, left_c, r_c)
    type(neighbour_t), intent(in) :: c              !< neighbour
    type(problem_t), intent(inout) :: problem       !< of the run, has the law for a while
    type(place_t), intent(in) :: place              !< here
    type(load_t), intent(in) :: load                !< of the run
    type(state_t), intent(in) :: before, state      !< of the run: at the beginning of the step, and here
    real(dp), intent(in) :: left_c(:, :)            !< residuals of the run (3, points) [Pa]
    real(dp), intent(inout) :: r_c(:, :)            !< gets the change (3, points) [Pa]
    real(dp), allocatable :: left(:, :), dw(:, :, :), dt(:, :, :)
    type(contact_law_t) :: law
    type(load_t) :: other
    type(state_t) :: next
    law = problem%law
    problem%law = c%drive%problem%law
    other%friction = step_friction(c%scene, under_torque(c%scene, place))
    other%gap = load%gap
    other%gap(:problem%mortar%n - problem%mortar%rigid) = -assembly_at(c%scene, place)*c%drive%interference
    next = state
    call linear_equations(problem, other, before, next, left, dw, dt)
    problem%law = law
    r_c = r_c + (left - left_c)
  end subroutine change_law

  !> Forces of a neighbour's struts in a state of the run [N]. Where a wheel turns, flanks that push on the run but that a change
  !> has taken off pull: in the run their way is that of the wheel, also where the torque is 0 and they only just touch.
  function forces_of(problem, rate, load, u) result(force)
    type(problem_t), intent(inout) :: problem   !< of the neighbour; gets the tangents of the struts
    real(dp), intent(in) :: rate(:)             !< of the run [N/m]
    type(load_t), intent(in) :: load            !< of the neighbour
    real(dp), intent(in) :: u(:, :)             !< displacements (3, n) [m]
    real(dp), dimension(size(rate)) :: closing, force, pull
    closing = strut_closings(problem, load, u)
    force = forces_at(problem, load, closing)
    if (.not. problem%wheel_turns) return
    pull = merge(closing, 0._dp, problem%struts%power < straight .and. .not. problem%struts%pulls .and. rate > 0 .and. &
      closing < 0 .and. closing > -1)
    if (.not. any(abs(pull) > 0)) return
    problem%strut_rate = rate
    force = force + linear_forces(problem, pull)
  end function forces_of
end module hd_neighbour
