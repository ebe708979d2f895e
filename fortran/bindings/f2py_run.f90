! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: runs. Explicit shapes alone; the last argument of what can fail is its status, beside an error of which
!> the other results mean nothing.
module f2py_run
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t, raise, code_input
  use hd_input, only: read_scene
  use hd_open_run, only: open_run, advance_run
  use hd_plausible, only: refuse_slips
  use hd_registry, only: put_run, drop_run, find_run, forget_model
  use hd_run, only: run_t, close_run
  use hd_scene, only: scene_t
  use hd_status, only: tell, lines_of
  use hd_text, only: string_t, split
  use hd_load_path, only: path_end, place_t, operator(<), step_end
  use hd_facets, only: sum_names, sum_values, facet_rows
  use hd_named_values, only: named_list_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_loop_results, only: loop_values
  use hd_version, only: version
  implicit none
  private
  public :: run_open, run_sizes, run_advance, run_sums, run_loop, run_facets, run_close, model_forget, engine_version

contains

  !> Open a run. `assignments` holds lines 'group.key=value'; an empty folder writes nothing; `resume`: go on with a stopped run.
  subroutine run_open(path, assignments, folder, force, resume, implausible, handle, status)
    character(len=*), intent(in) :: path, assignments, folder
    integer(c_int), intent(in) :: force, resume, implausible
    integer(c_int), intent(out) :: handle, status
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(string_t), allocatable :: lines(:)
    type(scene_t), allocatable :: scene
    type(run_t), pointer :: run
    logical :: complete
    allocate (scene)
    lines = lines_of(assignments)
    call read_scene(path, lines, scene, error)
    if (.not. allocated(error) .and. implausible == 0) call refuse_slips(scene, error)
    if (.not. allocated(error)) call put_run(handle, run, error)
    if (.not. allocated(error)) then
      call open_run(scene, trim(path), trim(folder), force /= 0, resume /= 0, run, complete, error)
      if (complete) call raise(error, code_input, "the run in '"//trim(folder)//"' is complete: nothing to resume")
      if (allocated(error)) call drop_run(handle)
    end if
    call tell(error, status)
  end subroutine run_open

  !> Counts of a run: facets, facets along the axis, displacement dofs, load steps.
  subroutine run_sizes(handle, facets, axial, dof, steps, status)
    integer(c_int), intent(in) :: handle
    integer(c_int), intent(out) :: facets, axial, dof, steps, status
    type(error_t), allocatable :: error
    type(run_t), pointer :: run
    type(place_t) :: last
    call find_run(handle, run, error)
    if (.not. allocated(error)) then
      facets = size(run%model%drive%face%nodes, 2)
      axial = run%model%drive%axial_facets
      dof = 3*run%model%drive%problem%n
      last = path_end(run%scene)
      steps = last%step
    end if
    call tell(error, status)
  end subroutine run_sizes

  !> Solve the next load step.
  subroutine run_advance(handle, done, status)
    integer(c_int), intent(in) :: handle
    integer(c_int), intent(out) :: done, status
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(run_t), pointer :: run
    logical :: last
    last = .true.
    call find_run(handle, run, error)
    if (.not. allocated(error)) then
      call advance_run(run, step_end(run%place), error)
      last = .not. run%place < path_end(run%scene)
    end if
    done = merge(1, 0, last)
    call tell(error, status)
  end subroutine run_advance

  !> Sums of the last converged step, in the order of the list 'step' (hd_named_values).
  subroutine run_sums(handle, n, sums, status)
    integer(c_int), intent(in) :: handle, n
    real(c_double), intent(out) :: sums(n)
    integer(c_int), intent(out) :: status
    type(error_t), allocatable :: error
    type(run_t), pointer :: run
    type(named_list_t) :: names
    type(string_t), allocatable :: of_facets(:)
    real(c_double), allocatable :: values(:)
    integer :: i
    sums = 0
    names%list = 'step'
    call find_run(handle, run, error)
    if (.not. allocated(error)) then
      call names%put(sums, 'step', real(run%step%number, c_double))
      call names%put(sums, 'in_torque', merge(1._c_double, 0._c_double, run%step%loaded))
      call names%put(sums, 'load_factor', run%step%load_factor)
      call names%put(sums, 'torque_nm', run%step%torque)
      call names%put(sums, 'iterations', real(run%step%iterations, c_double))
      call names%put(sums, 'seconds', run%step%seconds)
      of_facets = split(sum_names)
      values = sum_values(run%sums)
      do i = 1, size(values)
        call names%put(sums, of_facets(i)%s, values(i))
      end do
      call names%check(error)
    end if
    call tell(error, status)
  end subroutine run_sums

  !> What the loop of a whole drive says so far, in the order of the list 'loop' (hd_named_values); NaN for what it has not.
  subroutine run_loop(handle, n, values, status)
    integer(c_int), intent(in) :: handle, n
    real(c_double), intent(out) :: values(n)
    integer(c_int), intent(out) :: status
    type(error_t), allocatable :: error
    type(run_t), pointer :: run
    values = ieee_value(1._c_double, ieee_quiet_nan)
    call find_run(handle, run, error)
    if (.not. allocated(error)) then
      if (run%reference%known) values = loop_values(run%loop, run%scene, run%reference%sums, run%record%band)
    end if
    call tell(error, status)
  end subroutine run_loop

  !> Facet fields of the last converged step, one column for each of facet_names.
  subroutine run_facets(handle, n, columns, fields, status)
    integer(c_int), intent(in) :: handle, n, columns
    real(c_double), intent(out) :: fields(n, columns)
    integer(c_int), intent(out) :: status
    type(error_t), allocatable :: error
    type(run_t), pointer :: run
    fields = 0
    call find_run(handle, run, error)
    if (.not. allocated(error)) then
      if (run%step%number > 0) fields = transpose(facet_rows(run%facets))
    end if
    call tell(error, status)
  end subroutine run_facets

  !> Write what remains to be written and forget the run; `interrupted`: a signal came between two load steps.
  subroutine run_close(handle, interrupted, status)
    integer(c_int), intent(in) :: handle, interrupted
    integer(c_int), intent(out) :: status
    !f2py threadsafe
    type(error_t), allocatable :: error
    type(run_t), pointer :: run
    call find_run(handle, run, error)
    if (.not. allocated(error)) then
      call close_run(run, error, interrupted /= 0)
      call drop_run(handle)
    end if
    call tell(error, status)
  end subroutine run_close

  !> Give back the mesh and the factors that the last run left.
  subroutine model_forget()
    call forget_model()
  end subroutine model_forget

  !> Version of the engine.
  subroutine engine_version(text)
    character(len=32), intent(out) :: text
    text = version
  end subroutine engine_version
end module f2py_run
