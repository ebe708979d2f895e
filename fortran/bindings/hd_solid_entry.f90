! SPDX-License-Identifier: GPL-3.0-or-later
!> Solid problems that Python holds by an integer handle: fields enter by name, the problem is solved, results are asked for. The
!> names are known to `field` alone; any other is an internal error.
!> Node numbers start at 1; body b owns nodes node_end(b-1)+1 to node_end(b) and cells cell_end(b-1)+1 to cell_end(b).
module hd_solid_entry
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input, code_internal
  use hd_face, only: face_t
  use hd_problem, only: problem_t
  use hd_solid, only: new_solid, new_interface, solid_steps
  use hd_static, only: solve_static
  use hd_text, only: to_text
  implicit none
  private
  public :: field_t, solid_t, put_solid, find_solid, drop_solid

  integer, parameter :: capacity = 64       !< problems at the same time
  integer, parameter :: history_columns = 7 !< step, iteration, residual, changes, open, stick, slip

  !> Numbers, first index fastest; none before they are entered.
  type :: field_t
    real(dp), allocatable :: values(:)
  contains
    procedure :: count
  end type field_t

  !> Fields per node, cell, body, facet and step as in hd_solid: of both kinds of problem, of contact alone, results.
  type :: solid_t
    character(len=:), allocatable :: element, mode
    type(field_t) :: node_end, cell_end, cells, fixed, material, x, angle, displacement, force
    type(field_t) :: slave, slave_chart, master, master_chart, gap, period, friction, scale, tolerance, max_iterations
    type(field_t) :: u, reaction, traction, slip, opening, contact, area, history
  contains
    procedure :: field
    procedure :: solve => solve_solid
  end type solid_t

  type :: solid_slot_t
    integer :: handle = 0
    type(solid_t), allocatable :: solid
  end type solid_slot_t
  type(solid_slot_t), save, target :: slots(capacity)
  integer, save :: latest = 0               !< handle given last; none is used again

contains

  !> Make room for a problem. An empty mode: linear statics, no contact.
  subroutine put_solid(element, mode, handle, error)
    character(len=*), intent(in) :: element, mode     !< element; bonded, frictionless, frictional or nothing
    integer, intent(out) :: handle                    !< its handle
    type(error_t), allocatable, intent(out) :: error  !< too many
    integer :: i
    do i = 1, capacity
      if (allocated(slots(i)%solid)) cycle
      latest = latest + 1
      handle = latest
      slots(i)%handle = handle
      allocate (slots(i)%solid)
      slots(i)%solid%element = element
      slots(i)%solid%mode = mode
      return
    end do
    handle = 0
    call raise(error, code_input, to_text(capacity)//' solid problems are open')
  end subroutine put_solid

  !> Problem of a handle.
  subroutine find_solid(handle, solid, error)
    integer, intent(in) :: handle                     !< handle
    type(solid_t), pointer, intent(out) :: solid      !< its problem
    type(error_t), allocatable, intent(out) :: error  !< no such problem
    integer :: i
    nullify (solid)
    i = findloc(slots%handle, handle, 1)
    if (i > 0) then
      if (allocated(slots(i)%solid)) solid => slots(i)%solid
    end if
    if (.not. associated(solid)) call raise(error, code_input, 'this solid problem is closed (handle '//to_text(handle)//')')
  end subroutine find_solid

  !> Forget a problem.
  subroutine drop_solid(handle)
    integer, intent(in) :: handle  !< handle
    integer :: i
    i = findloc(slots%handle, handle, 1)
    if (i == 0) return
    if (allocated(slots(i)%solid)) deallocate (slots(i)%solid)
  end subroutine drop_solid

  !> Field of a name.
  subroutine field(self, name, f, error)
    class(solid_t), intent(inout), target :: self     !< problem
    character(len=*), intent(in) :: name              !< wanted
    type(field_t), pointer, intent(out) :: f          !< its field
    type(error_t), allocatable, intent(out) :: error  !< no such field
    nullify (f)
    select case (name)
    case ('node_end'); f => self%node_end
    case ('cell_end'); f => self%cell_end
    case ('cells'); f => self%cells
    case ('fixed'); f => self%fixed
    case ('material'); f => self%material
    case ('x'); f => self%x
    case ('angle'); f => self%angle
    case ('displacement'); f => self%displacement
    case ('force'); f => self%force
    case ('slave'); f => self%slave
    case ('slave_chart'); f => self%slave_chart
    case ('master'); f => self%master
    case ('master_chart'); f => self%master_chart
    case ('gap'); f => self%gap
    case ('period'); f => self%period
    case ('friction'); f => self%friction
    case ('scale'); f => self%scale
    case ('tolerance'); f => self%tolerance
    case ('max_iterations'); f => self%max_iterations
    case ('u'); f => self%u
    case ('reaction'); f => self%reaction
    case ('traction'); f => self%traction
    case ('slip'); f => self%slip
    case ('opening'); f => self%opening
    case ('contact'); f => self%contact
    case ('area'); f => self%area
    case ('history'); f => self%history
    case default
      call raise(error, code_internal, "a solid problem has no field '"//name//"'")
    end select
  end subroutine field

  !> Numbers of a field.
  pure integer function count(self)
    class(field_t), intent(in) :: self  !< field
    count = 0
    if (allocated(self%values)) count = size(self%values)
  end function count

  !> Solve; results become fields.
  subroutine solve_solid(self, error)
    class(solid_t), intent(inout) :: self             !< problem
    type(error_t), allocatable, intent(out) :: error  !< fields that do not fit, no convergence, body not held, memory
    type(problem_t) :: problem
    real(dp), allocatable :: u(:, :)
    integer :: n
    n = self%angle%count()
    call check_sizes(self, n, error)
    if (allocated(error)) return
    associate (node_end => nint(self%node_end%values), cell_end => nint(self%cell_end%values), &
        cells => nint(self%cells%values))
      call new_solid(self%element, node_end, cell_end, reshape(self%material%values, [2, size(node_end)]), &
        reshape(self%x%values, [3, n]), self%angle%values, &
        reshape(cells, [size(cells)/cell_end(size(cell_end)), cell_end(size(cell_end))]), problem, error)
    end associate
    if (allocated(error)) return
    problem%fixed = nint(reshape(self%fixed%values, [3, n])) /= 0
    if (len(self%mode) > 0) then
      call solve_contact(self, problem, n, error)
    else
      allocate (u(3, n))
      call solve_static(problem, reshape(self%displacement%values, [3, n]), reshape(self%force%values, [3, n]), u, error)
      if (.not. allocated(error)) self%u%values = [u]
    end if
  end subroutine solve_solid

  !> Every field is there and fits the nodes, cells, bodies and load steps.
  subroutine check_sizes(self, n, error)
    class(solid_t), intent(in) :: self                !< problem
    integer, intent(in) :: n                          !< nodes
    type(error_t), allocatable, intent(out) :: error  !< the first that does not
    integer :: bodies, cells, steps
    bodies = self%node_end%count()
    steps = merge(self%gap%count()/max(1, n), 1, len(self%mode) > 0)
    cells = 0
    if (self%cell_end%count() == bodies .and. bodies > 0) cells = nint(maxval(self%cell_end%values))
    call need('cell_end', self%cell_end, [bodies])
    call need('cells', self%cells, [8*cells, 20*cells])
    call need('fixed', self%fixed, [3*n])
    call need('material', self%material, [2*bodies])
    call need('x', self%x, [3*n])
    call need('displacement', self%displacement, [3*n*steps])
    call need('force', self%force, [3*n*steps])
    if (len(self%mode) == 0) return
    call need('slave_chart', self%slave_chart, [2*self%slave%count(), self%slave%count()])
    call need('master_chart', self%master_chart, [2*self%master%count(), self%master%count()])
    call need('period', self%period, [1])
    call need('friction', self%friction, [1])
    call need('scale', self%scale, [1])
    call need('tolerance', self%tolerance, [1])
    call need('max_iterations', self%max_iterations, [1])
  contains
    subroutine need(name, f, sizes)
      character(len=*), intent(in) :: name
      type(field_t), intent(in) :: f
      integer, intent(in) :: sizes(:)
      if (allocated(error)) return
      if (f%count() == 0 .or. all(f%count() /= sizes)) call raise(error, code_input, &
        "field '"//name//"' of a solid problem has "//to_text(f%count())//' numbers, needs '//to_text(sizes(1)))
    end subroutine need
  end subroutine check_sizes

  !> Contact through the load steps; fields of multipliers stand at their slave nodes, zero elsewhere.
  subroutine solve_contact(self, problem, n, error)
    class(solid_t), intent(inout) :: self             !< gets the results
    type(problem_t), intent(inout) :: problem         !< bodies and supports
    integer, intent(in) :: n                          !< nodes
    type(error_t), allocatable, intent(out) :: error  !< unknown mode, no convergence, memory
    real(dp), allocatable :: u(:, :, :), reaction(:, :, :), traction(:, :, :), slip(:, :, :), opening(:, :), area(:), history(:, :)
    integer, allocatable :: contact(:, :)
    integer :: steps, limit, used, shape3(3)
    steps = self%gap%count()/n
    limit = nint(sum(self%max_iterations%values))
    shape3 = [3, n, steps]
    call new_interface(problem, face_of(self%slave, self%slave_chart), face_of(self%master, self%master_chart), self%mode, &
      [self%friction%values, self%scale%values], error)
    if (allocated(error)) return
    allocate (u(3, n, steps), reaction(3, n, steps), traction(3, n, steps), slip(2, n, steps), opening(n, steps), area(n), &
      history(history_columns, (limit + 1)*steps), source=0._dp)
    allocate (contact(n, steps), source=0)
    area(problem%mortar%node) = problem%mortar%area
    call solid_steps(problem, reshape(self%displacement%values, shape3), reshape(self%force%values, shape3), &
      reshape(self%gap%values, [n, steps]), sum(self%tolerance%values), limit, u, reaction, traction, slip, opening, contact, &
      history, used, error)
    self%u%values = [u]
    self%reaction%values = [reaction]
    self%traction%values = [traction]
    self%slip%values = [slip]
    self%opening%values = [opening]
    self%contact%values = real([contact], dp)
    self%area%values = area
    self%history%values = [history(:, :used)]
  contains
    !> Facets have 4 corners in the chart and 4 or 8 nodes.
    type(face_t) function face_of(nodes, chart)
      type(field_t), intent(in) :: nodes, chart
      integer :: facets
      facets = chart%count()/8
      face_of = face_t(reshape(nint(nodes%values), [nodes%count()/facets, facets]), reshape(chart%values, [2, 4, facets]), &
        sum(self%period%values))
    end function face_of
  end subroutine solve_contact
end module hd_solid_entry
