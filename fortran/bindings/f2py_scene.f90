! SPDX-License-Identifier: GPL-3.0-or-later
! Flat entry for Python: a scene read and checked without running it.

!> All keys of a scene as a JSON text, or the planner's text for it. `assignments` holds lines 'group.key=value'.
subroutine scene_text(path, assignments, plan, text, status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t
  use hd_input, only: read_scene
  use hd_json, only: json_t
  use hd_planner, only: plan_text
  use hd_scene, only: scene_t
  use hd_status, only: tell, lines_of
  use hd_summary, only: add_scene
  implicit none
  character(len=*), intent(in) :: path, assignments
  integer(c_int), intent(in) :: plan
  character(len=16384), intent(out) :: text
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py threadsafe
  type(error_t), allocatable :: error
  type(scene_t), allocatable :: scene
  type(json_t) :: json
  character(len=:), allocatable :: answer
  text = ''
  allocate (scene)
  call read_scene(path, lines_of(assignments), scene, error)
  if (.not. allocated(error)) then
    if (plan /= 0) then
      call plan_text(scene, answer, error)
    else
      call json%begin()
      call add_scene(json, scene)
      call json%finish()
      answer = json%content()
    end if
  end if
  if (.not. allocated(error)) text = answer
  call tell(error, status, message)
end subroutine scene_text
