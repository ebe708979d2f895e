! SPDX-License-Identifier: GPL-3.0-or-later
!> Bodies of revolution: a strip of stations and layers in the meridian plane, turned round the z axis.
module hd_revolution
  use hd_kinds, only: dp, pi
  use hd_body, only: body_t
  use hd_face, only: face_t
  use hd_hexahedron, only: hex20r
  implicit none
  private
  public :: strip_t, growth, revolve, strip_node, strip_face, append_intervals

  real(dp), parameter :: growth = 1.5_dp  !< of intervals away from an edge

  !> Meridian strip: station i joins inner(:, i) to outer(:, i); `layers` cells lie between them.
  type :: strip_t
    real(dp), allocatable :: inner(:, :)  !< r, z of the inner line (2, stations) [m]
    real(dp), allocatable :: outer(:, :)  !< r, z of the outer line (2, stations) [m]
    integer :: layers = 1                 !< cells through the thickness
  end type strip_t

contains

  !> Node of the first sector at a station and layer line.
  pure integer function strip_node(strip, station, line) result(node)
    type(strip_t), intent(in) :: strip  !< strip
    integer, intent(in) :: station      !< station, from 1
    integer, intent(in) :: line         !< layer line, 1 (inner) to layers + 1 (outer)
    node = (station - 1)*(strip%layers + 1) + line
  end function strip_node

  !> Turn a strip into a body. Mid-side nodes of quadratic cells lie on the circle.
  subroutine revolve(strip, sectors, kind, body)
    type(strip_t), intent(in) :: strip  !< meridian strip
    integer, intent(in) :: sectors      !< cells round the circumference
    integer, intent(in) :: kind         !< element kind
    type(body_t), intent(out) :: body   !< body without material
    real(dp), allocatable :: section(:, :)
    integer :: s, first, half
    call mesh_sector(strip, kind, section, body%cells)
    body%kind = kind
    body%sectors = sectors
    body%revolved = .true.
    body%nodes_per_sector = size(section, 2)
    half = merge(body%nodes_per_sector - strip_node(strip, size(strip%inner, 2), strip%layers + 1), &
      body%nodes_per_sector, kind == hex20r)
    allocate (body%x(3, body%nodes()), body%angle(body%nodes()))
    do s = 0, sectors - 1
      first = s*body%nodes_per_sector
      body%angle(first + 1:first + half) = 2*pi*s/sectors
      body%angle(first + half + 1:first + body%nodes_per_sector) = 2*pi*(s + 0.5_dp)/sectors
      associate (a => body%angle(first + 1:first + body%nodes_per_sector), &
          x => body%x(:, first + 1:first + body%nodes_per_sector))
        x(1, :) = section(1, :)*cos(a)
        x(2, :) = section(1, :)*sin(a)
        x(3, :) = section(2, :)
      end associate
    end do
  end subroutine revolve

  !> Nodes (r, z) and cells of one sector. Order of nodes: corners, then for quadratic cells mid-sides across the layers,
  !> mid-sides along the stations, and the corners of the half-sector plane.
  subroutine mesh_sector(strip, kind, section, cells)
    type(strip_t), intent(in) :: strip                  !< meridian strip
    integer, intent(in) :: kind                         !< element kind
    real(dp), allocatable, intent(out) :: section(:, :) !< r, z (2, nodes per sector) [m]
    integer, allocatable, intent(out) :: cells(:, :)    !< cells (nodes, cells)
    integer :: stations, layers, corners, across, along, per, i, l, c
    real(dp) :: f
    stations = size(strip%inner, 2)
    layers = strip%layers
    corners = stations*(layers + 1)
    across = corners
    along = across + stations*layers
    per = along + (stations - 1)*(layers + 1)
    allocate (section(2, merge(per + corners, corners, kind == hex20r)))
    do i = 1, stations
      do l = 1, layers + 1
        f = real(l - 1, dp)/layers
        section(:, strip_node(strip, i, l)) = (1 - f)*strip%inner(:, i) + f*strip%outer(:, i)
      end do
    end do
    allocate (cells(merge(20, 8, kind == hex20r), (stations - 1)*layers))
    c = 0
    do i = 1, stations - 1
      do l = 1, layers
        c = c + 1
        associate (n => size(section, 2), a => strip_node(strip, i, l), b => strip_node(strip, i + 1, l))
          cells(:8, c) = [a, a + 1, a + 1 + n, a + n, b, b + 1, b + 1 + n, b + n]
          if (kind == hex20r) cells(9:, c) = [ &
            across + (i - 1)*layers + l, per + a + 1, across + (i - 1)*layers + l + n, per + a, &
            across + i*layers + l, per + b + 1, across + i*layers + l + n, per + b, &
            along + a, along + a + 1, along + a + 1 + n, along + a + n]
        end associate
        if (kind == hex20r) call place_middles(cells(:, c), section)
      end do
    end do
  end subroutine mesh_sector

  !> Mid-side nodes of one quadratic cell halfway between its corners in the meridian plane.
  pure subroutine place_middles(cell, section)
    integer, intent(in) :: cell(20)             !< cell
    real(dp), intent(inout) :: section(:, :)    !< r, z (2, nodes per sector) [m]
    integer, parameter :: ends(2, 12) = reshape([1, 2, 2, 3, 3, 4, 4, 1, 5, 6, 6, 7, 7, 8, 8, 5, 1, 5, 2, 6, 3, 7, 4, 8], [2, 12])
    integer :: k, n, m(3)
    n = size(section, 2)
    do k = 1, 12
      m = modulo([cell(8 + k), cell(ends(:, k))] - 1, n) + 1
      section(:, m(1)) = 0.5_dp*(section(:, m(2)) + section(:, m(3)))
    end do
  end subroutine place_middles

  !> Facets of a layer line between two stations as a cylindrical face; numbered station fastest, then round the axis.
  subroutine strip_face(strip, body, line, first, last, radius, face)
    type(strip_t), intent(in) :: strip  !< strip
    type(body_t), intent(in) :: body    !< body made from it
    integer, intent(in) :: line         !< layer line
    integer, intent(in) :: first        !< first station
    integer, intent(in) :: last         !< last station
    real(dp), intent(in) :: radius      !< radius of the cylindrical chart [m]
    type(face_t), intent(out) :: face   !< face
    integer :: s, i, f, a, b, n, across, along, per
    real(dp) :: t(2), z(2)
    n = body%nodes_per_sector
    across = strip_node(strip, size(strip%inner, 2), strip%layers + 1)
    along = across + size(strip%inner, 2)*strip%layers
    per = along + (size(strip%inner, 2) - 1)*(strip%layers + 1)
    allocate (face%nodes(merge(8, 4, body%kind == hex20r), body%sectors*(last - first)), &
      face%chart(2, 4, body%sectors*(last - first)))
    face%period = 2*pi*radius
    f = 0
    do s = 0, body%sectors - 1
      t = radius*2*pi*[s, s + 1]/body%sectors
      do i = first, last - 1
        f = f + 1
        a = strip_node(strip, i, line)
        b = strip_node(strip, i + 1, line)
        face%nodes(:4, f) = [a, a + n, b + n, b]
        if (body%kind == hex20r) face%nodes(5:, f) = [per + a, along + a + n, per + b, along + a]
        face%nodes(:, f) = modulo(face%nodes(:, f) - 1 + s*n, body%nodes()) + 1
        z = [body%x(3, a), body%x(3, b)]
        face%chart(:, :, f) = reshape([t(1), z(1), t(2), z(1), t(2), z(2), t(1), z(2)], [2, 4])
      end do
    end do
  end subroutine strip_face

  !> Append intervals after the last entry of a list of coordinates.
  pure subroutine append_intervals(list, last, n, first_end, last_end)
    real(dp), allocatable, intent(inout) :: list(:)  !< coordinates [m]
    real(dp), intent(in) :: last                     !< new last coordinate [m]
    integer, intent(in) :: n                         !< as of `graded`; nothing is added for 0
    real(dp), intent(in) :: first_end, last_end      !< as of `graded` [m]
    real(dp), allocatable :: part(:)
    real(dp) :: start
    integer :: i
    if (n == 0) return
    start = list(size(list))
    part = graded(last - start, n, first_end, last_end)
    do i = 2, size(part)
      part(i) = part(i - 1) + part(i)
    end do
    list = [list, start + part(:size(part) - 1), last]
  end subroutine append_intervals

  !> Lengths of n equal intervals. An end may begin with a given length instead, from which the lengths grow until they are about
  !> equal to the others; the last of them are stretched so that the equal ones stay in their places. So the same lengths stand at
  !> an end and in the middle whatever the other is: results do not jump as either is refined.
  pure function graded(whole, n, first_end, last_end) result(part)
    real(dp), intent(in) :: whole                !< their sum [m]
    integer, intent(in) :: n                     !< >= 1
    real(dp), intent(in) :: first_end, last_end  !< shortest interval at either end; none if 0 or beyond the equal ones [m]
    real(dp), allocatable :: part(:), front(:), back(:)
    real(dp) :: equal, room
    equal = whole/n
    room = n  ! of one end, in equal intervals
    if (all([first_end, last_end] > 0 .and. [first_end, last_end] < equal)) room = merge(real(n/2, dp), 0.5_dp, n > 1)
    front = growing(equal, room, first_end)
    back = growing(equal, room, last_end)
    part = [front, spread(equal, 1, nint((whole - sum(front) - sum(back))/equal)), back(size(back):1:-1)]
  end function graded

  !> Lengths from the shortest on that fill a whole number of equal ones, or all the room if that is less than one.
  pure function growing(equal, room, shortest) result(x)
    real(dp), intent(in) :: equal     !< length of the others [m]
    real(dp), intent(in) :: room      !< most that may be filled, in equal lengths
    real(dp), intent(in) :: shortest  !< 0: none [m]
    real(dp), allocatable :: x(:)
    integer, parameter :: stretched = 3
    real(dp), parameter :: whole = 1e-6_dp   !< what rounding adds to a number of cells makes no further one
    real(dp), parameter :: fits = 1.2_dp     !< lengths over the room that stretching them still makes fit
    real(dp) :: filled
    integer :: i, k
    x = [real(dp) ::]
    if (.not. (shortest > 0 .and. shortest < equal*(1 - whole))) return
    do k = max(1, ceiling(log(equal/shortest)/log(growth) - whole)), 1, -1
      x = [(shortest*growth**i, i=0, k - 1)]
      if (sum(x) <= fits*room*equal) exit
    end do
    if (k == 1) x = [shortest, growth*shortest]
    filled = equal*min(room, real(max(1, nint(sum(x)/equal)), dp))
    i = max(2, k - stretched + 1)  ! the shortest stays
    if (sum(x(:i - 1)) + 0.5_dp*x(i - 1) < filled) then
      x(i:) = x(i:)*(filled - sum(x(:i - 1)))/sum(x(i:))
    else
      x = [filled]
    end if
  end function growing
end module hd_revolution
