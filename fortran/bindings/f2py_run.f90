! SPDX-License-Identifier: GPL-3.0-or-later
! Flat entries for Python: runs. Only external procedures with explicit shapes; the last two arguments are status and message.

!> Open a run. `assignments` holds lines 'group.key=value'; an empty folder writes nothing; `resume`: go on with a stopped run.
subroutine run_open(path, assignments, folder, force, resume, handle, status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t
  use hd_input, only: read_scene
  use hd_job, only: resume_run
  use hd_planner, only: new_planned_run
  use hd_registry, only: put_run, drop_run
  use hd_run, only: run_t, new_run
  use hd_scene, only: scene_t
  use hd_status, only: tell, lines_of
  use hd_text, only: string_t
  implicit none
  character(len=*), intent(in) :: path, assignments, folder
  integer(c_int), intent(in) :: force, resume
  integer(c_int), intent(out) :: handle, status
  character(len=8192), intent(out) :: message
  !f2py threadsafe
  type(error_t), allocatable :: error
  type(string_t), allocatable :: lines(:)
  type(scene_t), allocatable :: scene
  type(run_t), pointer :: run
  handle = 0
  allocate (scene)
  lines = lines_of(assignments)
  call read_scene(path, lines, scene, error)
  if (.not. allocated(error)) call put_run(handle, run, error)
  if (.not. allocated(error)) then
    if (scene%promise > 0) then
      call new_planned_run(scene, trim(path), trim(folder), force /= 0, resume /= 0, run, error)
    else if (resume /= 0) then
      call resume_run(scene, trim(path), trim(folder), run, error)
    else
      call new_run(scene, trim(path), trim(folder), force /= 0, run, error)
    end if
    if (allocated(error)) call drop_run(handle)
  end if
  call tell(error, status, message)
end subroutine run_open

!> Counts of a run: facets, facets along the axis, displacement dofs.
subroutine run_sizes(handle, facets, axial, dof, status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t
  use hd_registry, only: find_run
  use hd_run, only: run_t
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: handle
  integer(c_int), intent(out) :: facets, axial, dof, status
  character(len=8192), intent(out) :: message
  type(error_t), allocatable :: error
  type(run_t), pointer :: run
  facets = 0
  axial = 0
  dof = 0
  call find_run(handle, run, error)
  if (.not. allocated(error)) then
    facets = size(run%drive%face%nodes, 2)
    axial = run%drive%axial_facets
    dof = 3*run%drive%problem%n
  end if
  call tell(error, status, message)
end subroutine run_sizes

!> Solve the next load step.
subroutine run_advance(handle, done, status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t
  use hd_registry, only: find_run
  use hd_load_step, only: advance
  use hd_run, only: run_t
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: handle
  integer(c_int), intent(out) :: done, status
  character(len=8192), intent(out) :: message
  !f2py threadsafe
  type(error_t), allocatable :: error
  type(run_t), pointer :: run
  logical :: last
  last = .true.
  call find_run(handle, run, error)
  if (.not. allocated(error)) call advance(run, last, error)
  done = merge(1, 0, last)
  call tell(error, status, message)
end subroutine run_advance

!> Sums of the last converged step, in the order of python/hdengine/contact.py.
subroutine run_sums(handle, sums, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_registry, only: find_run
  use hd_run, only: run_t
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: handle
  real(c_double), intent(out) :: sums(15)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  type(error_t), allocatable :: error
  type(run_t), pointer :: run
  sums = 0
  call find_run(handle, run, error)
  if (.not. allocated(error)) then
    associate (s => run%sums)
      sums = [real(run%step%number, c_double), merge(1._c_double, 0._c_double, run%step%phase == 'torque'), &
        run%step%load_factor, run%step%torque, s%rotation, s%normal_force, s%lobe_force_x, s%contact_area, s%pressure_max, &
        s%pressure_middle, s%friction_torque, s%friction_capacity, s%torque_balance, real(run%step%iterations, c_double), &
        run%step%seconds]
    end associate
  end if
  call tell(error, status, message)
end subroutine run_sums

!> Facet fields of the last converged step, one column each, in the order of python/hdengine/contact.py.
subroutine run_facets(handle, n, fields, status, message)
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_registry, only: find_run
  use hd_run, only: run_t
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: handle, n
  real(c_double), intent(out) :: fields(n, 25)
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  type(error_t), allocatable :: error
  type(run_t), pointer :: run
  fields = 0
  call find_run(handle, run, error)
  if (.not. allocated(error)) then
    if (run%record%steps > 0) then
      associate (f => run%facets)
        fields(:, 1) = f%theta
        fields(:, 2:4) = transpose(f%x)
        fields(:, 5:7) = transpose(f%normal)
        fields(:, 8) = f%area
        fields(:, 9) = f%gap
        fields(:, 10:12) = transpose(f%traction)
        fields(:, 13:14) = transpose(f%slip)
        fields(:, 15) = f%state
        fields(:, 16) = f%k_n
        fields(:, 17) = f%k_t
        fields(:, 18:) = transpose(reshape(f%corner, [8, n]))
      end associate
    end if
  end if
  call tell(error, status, message)
end subroutine run_facets

!> Write what remains to be written and forget the run.
subroutine run_close(handle, status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t
  use hd_registry, only: find_run, drop_run
  use hd_run, only: run_t, finish
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(in) :: handle
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  !f2py threadsafe
  type(error_t), allocatable :: error
  type(run_t), pointer :: run
  call find_run(handle, run, error)
  if (.not. allocated(error)) then
    call finish(run, error)
    call drop_run(handle)
  end if
  call tell(error, status, message)
end subroutine run_close

!> Give back the mesh and the factors that the last run left.
subroutine model_forget(status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t
  use hd_kept, only: forget_model
  use hd_status, only: tell
  implicit none
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  type(error_t), allocatable :: error
  call forget_model()
  call tell(error, status, message)
end subroutine model_forget

!> Version of the engine.
subroutine engine_version(text)
  use hd_version, only: version
  implicit none
  character(len=32), intent(out) :: text
  text = version
end subroutine engine_version
