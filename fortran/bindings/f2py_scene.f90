! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: a scene read and checked without running it; the text of the last call.
module f2py_scene
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t, raise, code_input
  use hd_input, only: read_scene
  use hd_json, only: json_t
  use hd_open_run, only: check_run
  use hd_input_tolerances, only: mean_clearance, mean_play
  use hd_joint_choice, only: choose_joint
  use hd_planner, only: plan_text
  use hd_scene, only: scene_t
  use hd_status, only: tell, hand_over, lines_of, part_of_text
  use hd_summary, only: add_scene
  use hd_mesh_series, only: finest, meshed
  use hd_text, only: to_text, string_t, join
  use hd_cam, only: cam_t, new_cam, curve_t, new_curve
  use hd_explain, only: explain
  use hd_plausible, only: implausible
  implicit none
  private
  public :: scene_text, series_mesh, handed_text, scene_cam, fit_clearance, ball_clearance, explain_text, scene_doubts

contains

  !> All keys of a scene as a JSON text, or the planner's text for it. `assignments` holds lines 'group.key=value'.
  subroutine scene_text(path, assignments, plan, status)
    character(len=*), intent(in) :: path, assignments
    integer(c_int), intent(in) :: plan
    integer(c_int), intent(out) :: status
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(scene_t), allocatable :: scene
    type(json_t) :: json
    character(len=:), allocatable :: answer
    allocate (scene)
    call read_scene(path, lines_of(assignments), scene, error)
    if (.not. allocated(error) .and. .not. scene%surface_only) call check_run(scene, error)
    if (.not. allocated(error)) then
      if (plan /= 0) then
        call choose_joint(scene, error)
        if (.not. allocated(error)) call plan_text(scene, answer, error)
      else
        call json%begin()
        call add_scene(json, scene)
        call json%finish()
        answer = json%content()
      end if
    end if
    if (.not. allocated(error)) call hand_over(answer)
    call tell(error, status)
  end subroutine scene_text

  !> Mesh of a level of the planner's series for a scene: cells round the circumference, facets along the band.
  subroutine series_mesh(path, assignments, level, divisions, facets, status)
    character(len=*), intent(in) :: path, assignments
    integer(c_int), intent(in) :: level
    integer(c_int), intent(out) :: divisions, facets, status
    type(error_t), allocatable :: error
    type(scene_t), allocatable :: scene
    allocate (scene)
    call read_scene(path, lines_of(assignments), scene, error)
    if (.not. allocated(error) .and. (level < 1 .or. level > finest)) call raise(error, code_input, 'level '//to_text(level)// &
      ' of the mesh series: valid are 1 to '//to_text(finest))
    if (.not. allocated(error)) then
      scene = meshed(scene, level)
      divisions = scene%divisions
      facets = scene%band_facets
    end if
    call tell(error, status)
  end subroutine series_mesh

  !> A part of the text that the last call handed over, from character `first`.
  subroutine handed_text(first, text)
    integer(c_int), intent(in) :: first
    character(len=8192), intent(out) :: text
    call part_of_text(first, text)
  end subroutine handed_text

  !> Points of the circle that goes on the wave generator of a scene, in the middle of the band: `field` holds radial and tangential
  !> displacement to first order, `curve` x, y, normal and curvature on the exact curve, `length` the circle's and the curve's.
  subroutine scene_cam(path, assignments, n, theta, field, curve, length, status)
    character(len=*), intent(in) :: path, assignments
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: theta(n)
    real(c_double), intent(out) :: field(2, n), curve(5, n), length(2)
    integer(c_int), intent(out) :: status
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(scene_t), allocatable :: scene
    type(cam_t) :: cam
    type(curve_t) :: line
    integer :: i
    allocate (scene)
    call read_scene(path, lines_of(assignments), scene, error)
    if (.not. allocated(error)) then
      call new_cam(scene, scene%bore_radius - merge(scene%ring_thickness, 0._c_double, .not. scene%formed()), cam, error)
    end if
    if (.not. allocated(error)) then
      call cam%displace(cam%w, theta, field(1, :), field(2, :))
      call new_curve(cam, cam%w, 1._c_double, line)
      do i = 1, n
        call line%put(theta(i), curve(1:2, i), curve(3:4, i), curve(5, i))
      end do
      length = [2*acos(-1._c_double)*cam%radius, line%length]
    end if
    call tell(error, status)
  end subroutine scene_cam

  !> Mean radial clearance of a bearing of normal class in a bore to H7, both in m.
  subroutine fit_clearance(radius, clearance, status)
    real(c_double), intent(in) :: radius
    real(c_double), intent(out) :: clearance
    integer(c_int), intent(out) :: status
    clearance = mean_clearance(2*radius)
    status = 0
  end subroutine fit_clearance

  !> Mean radial clearance of the balls of a bearing of normal class, by its outer radius, the thickness of a ring and the diameter
  !> of a ball, all in m.
  subroutine ball_clearance(radius, ring, ball, clearance, status)
    real(c_double), intent(in) :: radius, ring, ball
    real(c_double), intent(out) :: clearance
    integer(c_int), intent(out) :: status
    clearance = mean_play(radius, ring, ball)
    status = 0
  end subroutine ball_clearance

  !> Meaning, unit and default of a key, of a group, or of all, as hdengine.x --explain tells them.
  subroutine explain_text(name, status)
    character(len=*), intent(in) :: name
    integer(c_int), intent(out) :: status
    type(error_t), allocatable :: error
    character(len=:), allocatable :: answer
    call explain(name, answer, error)
    if (.not. allocated(error)) call hand_over(answer)
    call tell(error, status)
  end subroutine explain_text

  !> Values of a scene that are valid and hardly meant, one a line.
  subroutine scene_doubts(path, assignments, status)
    character(len=*), intent(in) :: path, assignments
    integer(c_int), intent(out) :: status
    type(error_t), allocatable :: error
    type(scene_t), allocatable :: scene
    type(string_t), allocatable :: lines(:)
    allocate (scene)
    call read_scene(path, lines_of(assignments), scene, error)
    if (.not. allocated(error)) then
      call implausible(scene, lines)
      call hand_over(join(lines, new_line('a')))
    end if
    call tell(error, status)
  end subroutine scene_doubts
end module f2py_scene
