! SPDX-License-Identifier: GPL-3.0-or-later
!> Solid problems that Python holds by an integer handle: fields enter by name, the problem is solved, results are asked for.
!> Node numbers start at 1; body b owns nodes node_end(b-1)+1 to node_end(b) and cells cell_end(b-1)+1 to cell_end(b).
module hd_solid_fields
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_face, only: face_t
  use hd_problem, only: problem_t
  use hd_solid, only: new_solid, new_interface, solid_steps
  use hd_static, only: solve_static
  use hd_text, only: string_t, split, to_text
  implicit none
  private
  public :: solid_t, put_solid, find_solid, drop_solid

  !> Of both kinds of problem, then those of contact alone; numbers per node, cell, body, facet, step as in hd_solid.
  character(len=*), parameter :: common_names = 'node_end,cell_end,cells,fixed,material,x,angle,displacement,force'
  character(len=*), parameter :: contact_names = 'slave,slave_chart,master,master_chart,gap,period,friction,scale,tolerance,'// &
    'max_iterations'
  character(len=*), parameter :: result_names = 'u,reaction,traction,slip,opening,contact,area,history'
  integer, parameter :: capacity = 64       !< problems at the same time
  integer, parameter :: history_columns = 7 !< step, iteration, residual, changes, open, stick, slip

  type :: field_t
    character(len=:), allocatable :: name
    real(dp), allocatable :: values(:)
  end type field_t

  type :: solid_t
    character(len=:), allocatable :: element, mode
    type(field_t), allocatable :: fields(:)
  contains
    procedure :: put
    procedure :: field
    procedure :: solve => solve_solid
  end type solid_t

  type :: solid_slot_t
    type(solid_t), allocatable :: solid
  end type solid_slot_t
  type(solid_slot_t), save, target :: slots(capacity)

contains

  !> Make room for a problem. An empty mode: linear statics, no contact.
  subroutine put_solid(element, mode, handle, error)
    character(len=*), intent(in) :: element, mode     !< element; bonded, frictionless, frictional or nothing
    integer, intent(out) :: handle                    !< its handle
    type(error_t), allocatable, intent(out) :: error  !< too many
    type(string_t), allocatable :: names(:)
    integer :: i
    do handle = 1, capacity
      if (allocated(slots(handle)%solid)) cycle
      allocate (slots(handle)%solid)
      associate (s => slots(handle)%solid)
        s%element = element
        s%mode = mode
        names = split(common_names//','//contact_names//','//result_names)
        allocate (s%fields(size(names)))
        do i = 1, size(names)
          s%fields(i)%name = names(i)%s
        end do
      end associate
      return
    end do
    call raise(error, code_input, to_text(capacity)//' solid problems are open')
  end subroutine put_solid

  !> Problem of a handle.
  subroutine find_solid(handle, solid, error)
    integer, intent(in) :: handle                     !< handle
    type(solid_t), pointer, intent(out) :: solid      !< its problem
    type(error_t), allocatable, intent(out) :: error  !< no such problem
    nullify (solid)
    if (handle >= 1 .and. handle <= capacity) then
      if (allocated(slots(handle)%solid)) solid => slots(handle)%solid
    end if
    if (.not. associated(solid)) call raise(error, code_input, 'this solid problem is closed (handle '//to_text(handle)//')')
  end subroutine find_solid

  !> Forget a problem.
  subroutine drop_solid(handle)
    integer, intent(in) :: handle  !< handle
    if (handle < 1 .or. handle > capacity) return
    if (allocated(slots(handle)%solid)) deallocate (slots(handle)%solid)
  end subroutine drop_solid

  !> Enter a field.
  subroutine put(self, name, values, error)
    class(solid_t), intent(inout) :: self             !< gets it
    character(len=*), intent(in) :: name              !< one of those above
    real(dp), intent(in) :: values(:)                 !< numbers, first index fastest
    type(error_t), allocatable, intent(out) :: error  !< no such field
    integer :: i
    i = index_of(self, name)
    if (i == 0) then
      call raise(error, code_input, "a solid problem has no field '"//name//"'; valid: "//common_names//','//contact_names)
    else
      self%fields(i)%values = values
    end if
  end subroutine put

  !> Numbers of a field; none where it was not entered or does not exist.
  pure function field(self, name) result(values)
    class(solid_t), intent(in) :: self      !< problem
    character(len=*), intent(in) :: name    !< field
    real(dp), allocatable :: values(:)
    integer :: i
    i = index_of(self, name)
    if (i > 0) then
      if (allocated(self%fields(i)%values)) values = self%fields(i)%values
    end if
    if (.not. allocated(values)) allocate (values(0))
  end function field

  !> Number of a field, 0 if there is none of that name.
  pure integer function index_of(self, name) result(i)
    class(solid_t), intent(in) :: self      !< problem
    character(len=*), intent(in) :: name    !< field
    do i = size(self%fields), 1, -1
      if (self%fields(i)%name == name) return
    end do
  end function index_of

  !> Solve; results become fields.
  subroutine solve_solid(self, error)
    class(solid_t), intent(inout) :: self             !< problem
    type(error_t), allocatable, intent(out) :: error  !< fields that do not fit, no convergence, body not held, memory
    type(problem_t) :: problem
    real(dp), allocatable :: u(:, :)
    integer :: n
    n = size(self%field('angle'))
    call check_sizes(self, n, error)
    if (allocated(error)) return
    associate (node_end => nint(self%field('node_end')), cell_end => nint(self%field('cell_end')), &
        cells => nint(self%field('cells')))
      call new_solid(self%element, node_end, cell_end, reshape(self%field('material'), [2, size(node_end)]), &
        reshape(self%field('x'), [3, n]), self%field('angle'), &
        reshape(cells, [size(cells)/cell_end(size(cell_end)), cell_end(size(cell_end))]), problem, error)
    end associate
    if (allocated(error)) return
    problem%fixed = nint(reshape(self%field('fixed'), [3, n])) /= 0
    if (len(self%mode) > 0) then
      call solve_contact(self, problem, n, error)
    else
      allocate (u(3, n))
      call solve_static(problem, reshape(self%field('displacement'), [3, n]), reshape(self%field('force'), [3, n]), u, error)
      if (.not. allocated(error)) call self%put('u', [u], error)
    end if
  end subroutine solve_solid

  !> Every field is there and fits the nodes, cells, bodies and load steps.
  subroutine check_sizes(self, n, error)
    class(solid_t), intent(in) :: self                !< problem
    integer, intent(in) :: n                          !< nodes
    type(error_t), allocatable, intent(out) :: error  !< the first that does not
    integer :: bodies, cells, steps
    bodies = size(self%field('node_end'))
    steps = merge(size(self%field('gap'))/max(1, n), 1, len(self%mode) > 0)
    cells = 0
    if (size(self%field('cell_end')) == bodies .and. bodies > 0) cells = nint(maxval(self%field('cell_end')))
    call need('cell_end', [bodies])
    call need('cells', [8*cells, 20*cells])
    call need('fixed', [3*n])
    call need('material', [2*bodies])
    call need('x', [3*n])
    call need('displacement', [3*n*steps])
    call need('force', [3*n*steps])
    if (len(self%mode) == 0) return
    call need('slave_chart', [2*size(self%field('slave')), size(self%field('slave'))])
    call need('master_chart', [2*size(self%field('master')), size(self%field('master'))])
    call need('period', [1])
    call need('friction', [1])
    call need('scale', [1])
    call need('tolerance', [1])
    call need('max_iterations', [1])
  contains
    subroutine need(name, sizes)
      character(len=*), intent(in) :: name
      integer, intent(in) :: sizes(:)
      if (allocated(error)) return
      if (size(self%field(name)) == 0 .or. all(size(self%field(name)) /= sizes)) call raise(error, code_input, &
        "field '"//name//"' of a solid problem has "//to_text(size(self%field(name)))//' numbers, needs '//to_text(sizes(1)))
    end subroutine need
  end subroutine check_sizes

  !> Contact through the load steps; fields of multipliers stand at their slave nodes, zero elsewhere.
  subroutine solve_contact(self, problem, n, error)
    class(solid_t), intent(inout) :: self             !< gets the results
    type(problem_t), intent(inout) :: problem         !< bodies and supports
    integer, intent(in) :: n                          !< nodes
    type(error_t), allocatable, intent(out) :: error  !< unknown mode, no convergence, memory
    type(error_t), allocatable :: none
    real(dp), allocatable :: u(:, :, :), reaction(:, :, :), traction(:, :, :), slip(:, :, :), opening(:, :), area(:), history(:, :)
    integer, allocatable :: contact(:, :)
    integer :: steps, limit, used, shape3(3)
    steps = size(self%field('gap'))/n
    limit = nint(sum(self%field('max_iterations')))
    shape3 = [3, n, steps]
    call new_interface(problem, face_of('slave'), face_of('master'), self%mode, [self%field('friction'), self%field('scale')], &
      error)
    if (allocated(error)) return
    allocate (u(3, n, steps), reaction(3, n, steps), traction(3, n, steps), slip(2, n, steps), opening(n, steps), area(n), &
      history(history_columns, (limit + 1)*steps), source=0._dp)
    allocate (contact(n, steps), source=0)
    area(problem%mortar%node) = problem%mortar%area
    call solid_steps(problem, reshape(self%field('displacement'), shape3), reshape(self%field('force'), shape3), &
      reshape(self%field('gap'), [n, steps]), sum(self%field('tolerance')), limit, u, reaction, traction, slip, opening, contact, &
      history, used, error)
    call self%put('u', [u], none)
    call self%put('reaction', [reaction], none)
    call self%put('traction', [traction], none)
    call self%put('slip', [slip], none)
    call self%put('opening', [opening], none)
    call self%put('contact', real([contact], dp), none)
    call self%put('area', area, none)
    call self%put('history', [history(:, :used)], none)
  contains
    !> Facets have 4 corners in the chart and 4 or 8 nodes.
    type(face_t) function face_of(name)
      character(len=*), intent(in) :: name
      integer :: facets
      facets = size(self%field(name//'_chart'))/8
      face_of = face_t(reshape(nint(self%field(name)), [size(self%field(name))/facets, facets]), &
        reshape(self%field(name//'_chart'), [2, 4, facets]), sum(self%field('period')))
    end function face_of
  end subroutine solve_contact
end module hd_solid_fields
