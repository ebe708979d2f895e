! SPDX-License-Identifier: GPL-3.0-or-later
!> First guesses from a coarser mesh (nested iteration). The set of closed points moves by few facets per Newton iteration, so
!> from rest the iterations grow as the mesh is refined; a coarser solution has found that set already.
module hd_coarse_start
  use hd_kinds, only: dp
  use hd_drive, only: drive_t
  use hd_model, only: model_t
  use hd_problem, only: state_t, new_state
  use hd_revolution, only: strip_t, strip_node
  use hd_scene, only: scene_t
  use hd_section, only: band_rows
  use hd_vector, only: many
  implicit none
  private
  public :: has_coarser, coarser_scene, guess_from

  real(dp), parameter :: rounding = 1e-9_dp !< of a share of the way between two load steps
  integer, parameter :: least_divisions = 48, least_rows = 8  !< half as many, 24 x 4, guide; 16 x 3 facets mislead
  integer, parameter :: worthwhile = 1000  !< facets from which a coarser mesh saves time

  !> Linear interpolation: (1 - part) of entry `low`, part of the next.
  type :: between_t
    integer :: low = 1
    real(dp) :: part = 0
  end type between_t

contains

  !> A coarser mesh helps: the contact has states to find, the elements are trilinear. Faces formed alike touch everywhere and
  !> slip almost everywhere: there the coarser solution is no better a guess than rest (two to ten times the iterations).
  pure logical function has_coarser(scene)
    type(scene_t), intent(in) :: scene  !< scene
    has_coarser = scene%start /= 'rest' .and. .not. scene%bonded() .and. .not. scene%quadratic() .and. &
      scene%divisions >= least_divisions .and. band_rows(scene) >= least_rows
    if (scene%start == 'auto') has_coarser = has_coarser .and. .not. scene%formed() .and. &
      scene%divisions*band_rows(scene) >= worthwhile
  end function has_coarser

  !> The same scene with cells of twice the length and small displacements, solved as is cheapest.
  pure type(scene_t) function coarser_scene(scene) result(s)
    type(scene_t), intent(in) :: scene  !< scene
    s = scene
    s%divisions = 2*((scene%divisions + 3)/4)
    s%ring_divisions = 2*((scene%ring_divisions + 3)/4)
    s%band_facets = (scene%band_facets + 1)/2
    s%ring_facets = (scene%ring_facets + 1)/2
    s%wall_elements = (scene%wall_elements + 1)/2
    s%bottom_elements = (scene%bottom_elements + 1)/2
    s%edge_length = 2*scene%edge_length
    s%kinematics = 'linear'
    s%method = 'auto'
    s%factors = 'auto'
    s%symmetry = 'auto'
    s%turning_positions = 0
  end function coarser_scene

  !> Guess of a load step: the state before it and the change that the coarser mesh saw, if that was solved.
  subroutine guess_from(coarse, drive, before, assembly, torque, state)
    type(model_t), intent(in) :: coarse        !< of the coarser run, with its states
    type(drive_t), intent(in) :: drive         !< model of the finer mesh
    type(state_t), intent(in) :: before        !< its state at the beginning of the step
    real(dp), intent(in) :: assembly(2)        !< fractions of the assembly at beginning and end
    real(dp), intent(in) :: torque(2)          !< torques there [N m]
    type(state_t), intent(inout) :: state      !< guess, its displacements those of `before`; left as it is where the coarser run
                                               !< knows nothing
    type(state_t) :: pair(2)
    real(dp), allocatable :: nodal(:, :), fine(:, :)
    logical :: found
    integer :: i
    do i = 1, 2
      call new_state(coarse%drive%problem, pair(i))
      if (.not. assembly(i) > 0) cycle
      call coarse%assembly%recall(assembly(i), torque(i), pair(i), found)
      if (.not. found) return
    end do
    call prolong(coarse%drive, drive, pair(2)%u - pair(1)%u, state%u)
    allocate (nodal(3, coarse%drive%problem%n), source=0._dp)
    nodal(:, coarse%drive%problem%mortar%node) = pair(2)%traction - pair(1)%traction
    allocate (fine(3, drive%problem%n), source=0._dp)
    call prolong(coarse%drive, drive, nodal, fine)
    state%traction = before%traction + fine(:, drive%problem%mortar%node)
  end subroutine guess_from

  !> Add a nodal field in cylindrical components, interpolated linearly along the section, through its layers and round the axis.
  subroutine prolong(coarse, fine, u, v)
    type(drive_t), intent(in) :: coarse, fine  !< models
    real(dp), intent(in) :: u(:, :)            !< on the coarse nodes (3, coarse nodes)
    real(dp), intent(inout) :: v(:, :)         !< on the fine nodes (3, fine nodes)
    type(strip_t) :: from, to
    type(between_t), allocatable :: station(:), line(:), turn(:)
    real(dp), allocatable :: w(:, :, :)
    integer :: b, i, l, s, m, next
    do b = 1, 2
      from = section(coarse, b)
      to = section(fine, b)
      station = places(arc(from), arc(to))
      line = places(even(from%layers), even(to%layers))
      associate (few => coarse%problem%bodies(b), more => fine%problem%bodies(b))
        turn = places(even(few%sectors), even(more%sectors))
        m = few%nodes_per_sector
        allocate (w(3, more%nodes_per_sector, 0:few%sectors - 1))
        !$omp parallel private(i, l, next) if(size(v) > many)
        !$omp do schedule(static)
        do s = 0, few%sectors - 1
          do i = 1, size(station)
            do l = 1, size(line)
              w(:, strip_node(to, i, l), s) = (1 - station(i)%part)*across(s, station(i)%low, line(l)) + &
                station(i)%part*across(s, station(i)%low + 1, line(l))
            end do
          end do
        end do
        !$omp end do
        !$omp do schedule(static)
        do s = 0, more%sectors - 1
          next = modulo(turn(s + 1)%low, few%sectors)
          associate (t => turn(s + 1), first => fine%problem%first(b) + s*more%nodes_per_sector)
            do i = 1, more%nodes_per_sector
              v(:, first + i) = v(:, first + i) + ((1 - t%part)*w(:, i, t%low - 1) + t%part*w(:, i, next))
            end do
          end associate
        end do
        !$omp end do
        !$omp end parallel
        deallocate (w)
      end associate
    end do
  contains
    pure function across(sector, i, line) result(x)
      integer, intent(in) :: sector, i
      type(between_t), intent(in) :: line
      real(dp) :: x(3)
      integer :: first
      first = coarse%problem%first(b) + sector*m
      x = (1 - line%part)*u(:, first + strip_node(from, i, line%low)) + &
        line%part*u(:, first + strip_node(from, i, line%low + 1))
    end function across
  end subroutine prolong

  !> Meridian section of a body.
  pure type(strip_t) function section(drive, b) result(strip)
    type(drive_t), intent(in) :: drive  !< model
    integer, intent(in) :: b            !< body
    strip = drive%cup
    if (b == drive%b_ring) strip = drive%ring
  end function section

  !> Length along the inner line of a section, from its first station [m].
  pure function arc(strip) result(x)
    type(strip_t), intent(in) :: strip  !< section
    real(dp) :: x(size(strip%inner, 2))
    integer :: i
    x(1) = 0
    do i = 2, size(x)
      x(i) = x(i - 1) + norm2(strip%inner(:, i) - strip%inner(:, i - 1))
    end do
  end function arc

  !> Ends of n equal parts of 1.
  pure function even(n) result(x)
    integer, intent(in) :: n  !< parts
    real(dp) :: x(n + 1)
    integer :: i
    x = [(real(i, dp)/n, i=0, n)]
  end function even

  !> Places of points among others; both rise. Rounding counts as the point itself: beyond the band's ends there is no traction.
  pure function places(among, x) result(at)
    real(dp), intent(in) :: among(:), x(:)  !< known points, wanted ones
    type(between_t) :: at(size(x))
    integer :: i, k
    k = 1
    do i = 1, size(x)
      do while (k < size(among) - 1 .and. x(i) >= among(k + 1))
        k = k + 1
      end do
      at(i) = between_t(k, min(1._dp, max(0._dp, (x(i) - among(k))/(among(k + 1) - among(k)))))
      if (abs(at(i)%part - nint(at(i)%part)) < rounding) at(i)%part = nint(at(i)%part)
    end do
  end function places
end module hd_coarse_start
