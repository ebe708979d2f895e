! SPDX-License-Identifier: GPL-3.0-or-later
!> Segments: the overlaps of the facets of two faces on their chart, with integration points.
module hd_segment
  use hd_gauss, only: gauss_3, gauss_8, weight_3, weight_8
  use hd_kinds, only: dp, hair
  use hd_face, only: face_t, shape_facet
  implicit none
  private
  public :: point_t, bins_t, new_bins, integrate_overlaps

  !> One integration point: shape functions of the slave facet (all nodes, corners) and of the master facet, weight.
  type :: point_t
    real(dp) :: slave(8), corner(4), master(8)
    real(dp) :: weight   !< [m^2]
    integer :: facet     !< master facet
  end type point_t

  !> Facets of a face sorted into strips of the first chart coordinate.
  type :: bins_t
    real(dp) :: start = 0, width = 1
    integer :: n = 1
    logical :: periodic = .false.
    integer, allocatable :: ptr(:), facet(:)
    real(dp), allocatable :: low(:, :), high(:, :)  !< limits of each facet (2, facets) [m]
    real(dp), allocatable :: sum(:)                 !< of the first coordinates of its corners [m]
  end type bins_t

  integer, parameter :: corners = 16          !< of an overlap at most, by far,
  integer, parameter :: most = 64*corners     !< and integration points on it
  real(dp), parameter :: sliver = 1e-14_dp    !< area over the square of a facet's diagonal that rounding alone makes
  real(dp), parameter :: settled = 1e-14_dp   !< change of natural coordinates that is rounding,
  real(dp), parameter :: nearly = 1e-8_dp     !< and one after which the next is rounding
  !> Degree-5 rule of seven points on the unit triangle, weights sum to 1.
  real(dp), parameter :: ra = 0.10128650732345633_dp, rb = 0.47014206410511509_dp
  real(dp), parameter :: rule(2, 7) = reshape([1/3._dp, 1/3._dp, ra, ra, 1 - 2*ra, ra, ra, 1 - 2*ra, &
    rb, rb, 1 - 2*rb, rb, rb, 1 - 2*rb], [2, 7])
  real(dp), parameter :: wa = 0.12593918054482715_dp, wb = 0.13239415278850618_dp
  real(dp), parameter :: weight(7) = [0.225_dp, wa, wa, wa, wb, wb, wb]

contains

  !> Sort the facets of a face into bins by their lowest first coordinate.
  subroutine new_bins(face, bins)
    type(face_t), intent(in) :: face   !< face
    type(bins_t), intent(out) :: bins  !< its bins
    real(dp) :: length
    integer :: slot(size(face%chart, 3)), f, place(size(face%chart, 3))
    bins%low = minval(face%chart, 2)
    bins%high = maxval(face%chart, 2)
    bins%sum = sum(face%chart(1, :, :), 1)
    bins%periodic = face%period > 0
    bins%start = minval(bins%low(1, :))
    length = merge(face%period, maxval(bins%high(1, :)) - bins%start, bins%periodic)
    bins%n = max(1, int(length/maxval(bins%high(1, :) - bins%low(1, :))))
    bins%width = length/bins%n
    slot = bin_of(bins, bins%low(1, :))
    allocate (bins%ptr(0:bins%n), source=0)
    do f = 1, size(slot)
      bins%ptr(slot(f) + 1) = bins%ptr(slot(f) + 1) + 1
      place(f) = bins%ptr(slot(f) + 1)
    end do
    do f = 1, bins%n
      bins%ptr(f) = bins%ptr(f) + bins%ptr(f - 1)
    end do
    allocate (bins%facet(size(slot)))
    do f = 1, size(slot)
      bins%facet(bins%ptr(slot(f)) + place(f)) = f
    end do
  end subroutine new_bins

  !> Bin of a first coordinate, from 0.
  elemental integer function bin_of(bins, s) result(b)
    type(bins_t), intent(in) :: bins  !< bins
    real(dp), intent(in) :: s         !< first chart coordinate [m]
    b = floor((s - bins%start)/bins%width + hair)
    if (bins%periodic) then
      b = modulo(b, bins%n)
    else
      b = min(max(b, 0), bins%n - 1)
    end if
  end function bin_of

  !> Integration points of all overlaps of one slave facet with the master face.
  subroutine integrate_overlaps(slave, f, master, bins, moved, points, found)
    type(face_t), intent(in) :: slave                     !< slave face
    integer, intent(in) :: f                              !< slave facet
    type(face_t), intent(in) :: master                    !< master face
    type(bins_t), intent(in) :: bins                      !< bins of the master face
    logical, intent(in) :: moved                          !< faces are paired anew, which is done often: few points suffice
    type(point_t), allocatable, intent(inout) :: points(:)  !< room for integration points, may grow
    integer, intent(out) :: found                         !< integration points
    real(dp) :: a(2, 4), b(2, 4), low(2), high(2), middle, polygon(2, corners), shift
    integer :: g, i, k, n, lowest, highest, m
    a = slave%chart(:, :, f)
    low = minval(a, 2)
    high = maxval(a, 2)
    middle = sum(a(1, :))
    found = 0
    lowest = floor((low(1) - bins%start)/bins%width) - 1
    highest = floor((high(1) - bins%start)/bins%width)
    if (.not. bins%periodic) then
      lowest = max(lowest, 0)
      highest = min(highest, bins%n - 1)
    else if (highest - lowest >= bins%n) then
      highest = lowest + bins%n - 1
    end if
    do i = lowest, highest
      k = merge(modulo(i, bins%n), i, bins%periodic)
      do m = bins%ptr(k) + 1, bins%ptr(k + 1)
        g = bins%facet(m)
        if (low(2) >= bins%high(2, g) .or. high(2) <= bins%low(2, g)) cycle
        shift = 0
        if (bins%periodic) shift = master%period*nint((middle - bins%sum(g))/(4*master%period))
        if (low(1) >= bins%high(1, g) + shift .or. high(1) <= bins%low(1, g) + shift) cycle
        b = master%chart(:, :, g)
        b(1, :) = b(1, :) + shift
        call clip(a, b, polygon, n)
        call add_points(polygon(:, :n), a, b, size(slave%nodes, 1), size(master%nodes, 1), g, moved, points, found)
      end do
    end do
  end subroutine integrate_overlaps

  !> Intersection of two convex polygons given counter-clockwise (Sutherland and Hodgman 1974).
  pure subroutine clip(subject, window, polygon, n)
    real(dp), intent(in) :: subject(2, 4)      !< polygon to cut
    real(dp), intent(in) :: window(2, 4)       !< cutting polygon
    real(dp), intent(out) :: polygon(2, corners)    !< intersection
    integer, intent(out) :: n                  !< its corners
    real(dp) :: old(2, corners), p(2), q(2), normal(2), dp1, dp2
    integer :: e, i, m
    polygon = 0
    polygon(:, :4) = subject
    n = 4
    do e = 1, 4
      p = window(:, e)
      q = window(:, modulo(e, 4) + 1)
      normal = [p(2) - q(2), q(1) - p(1)]
      old = polygon
      m = n
      n = 0
      do i = 1, m
        dp1 = dot_product(normal, old(:, i) - p)
        dp2 = dot_product(normal, old(:, modulo(i, m) + 1) - p)
        if (dp1 >= 0) then
          n = n + 1
          polygon(:, n) = old(:, i)
        end if
        if (dp1*dp2 < 0) then
          n = n + 1
          polygon(:, n) = old(:, i) + dp1/(dp1 - dp2)*(old(:, modulo(i, m) + 1) - old(:, i))
        end if
      end do
      if (n < 3) return  ! no area
    end do
  end subroutine clip

  !> Integration points of a polygon, whose mirror image gets the mirrored points.
  subroutine add_points(polygon, a, b, nodes_a, nodes_b, facet, moved, points, found)
    real(dp), intent(in) :: polygon(:, :)     !< corners (2, n) [m]
    real(dp), intent(in) :: a(2, 4), b(2, 4)  !< corners of the slave and master facet [m]
    integer, intent(in) :: nodes_a, nodes_b   !< their numbers of nodes
    integer, intent(in) :: facet              !< master facet
    logical, intent(in) :: moved              !< few points suffice
    type(point_t), allocatable, intent(inout) :: points(:)  !< may grow
    integer, intent(inout) :: found           !< points so far
    real(dp) :: x(most, 2), w(most)
    type(point_t), allocatable :: more(:)
    integer :: n
    logical :: even
    if (size(polygon, 2) < 3) return  ! no area
    even = is_parallelogram(a) .and. is_parallelogram(b)
    if (moved .and. even .and. size(polygon, 2) == 4) then
      call quadrilateral_points(polygon, x, w)
      n = 9
    else
      call triangle_points(polygon, even, sliver*maxval(abs(a(:, 3) - a(:, 1)))**2, x, w, n)
    end if
    if (found + n > size(points)) then
      allocate (more(2*(found + n)))
      more(:found) = points(:found)
      call move_alloc(more, points)
    end if
    call enter(n, x, w, a, b, nodes_a, nodes_b, facet, merge(nearly, settled, moved), points(found + 1:found + n))
    found = found + n
  end subroutine add_points

  !> Points of Gauss, exact like the triangles for polynomials of degree 4, by a third of their points.
  pure subroutine quadrilateral_points(c, x, w)
    real(dp), intent(in) :: c(2, 4)              !< corners [m]
    real(dp), intent(inout) :: x(:, :), w(:)     !< gets places (9, 2) [m] and weights [m^2]
    real(dp) :: u(2), v(2)
    integer :: n, p, q
    n = 0
    do p = 1, 3
      do q = 1, 3
        n = n + 1
        u = ((1 - gauss_3(q))*(c(:, 2) - c(:, 1)) + (1 + gauss_3(q))*(c(:, 3) - c(:, 4)))/4
        v = ((1 - gauss_3(p))*(c(:, 4) - c(:, 1)) + (1 + gauss_3(p))*(c(:, 3) - c(:, 2)))/4
        x(n, :) = sum(c, 2)/4 + gauss_3(p)*(c(:, 2) - c(:, 1) + c(:, 3) - c(:, 4))/4 + gauss_3(q)*v
        w(n) = weight_3(p)*weight_3(q)*abs(u(1)*v(2) - u(2)*v(1))
      end do
    end do
  end subroutine quadrilateral_points

  !> Points on the triangles between the middle of a polygon and its sides.
  pure subroutine triangle_points(polygon, even, least, x, w, n)
    real(dp), intent(in) :: polygon(:, :)        !< corners (2, n) [m]
    logical, intent(in) :: even                  !< shape functions of the facets are polynomials of x
    real(dp), intent(in) :: least                !< area that counts [m^2]
    real(dp), intent(inout) :: x(:, :), w(:)     !< gets places [m] and weights [m^2]
    integer, intent(out) :: n                    !< points
    real(dp) :: middle(2), u(2), v(2), area
    integer :: p, q, t
    n = 0
    middle = sum(polygon, 2)/size(polygon, 2)
    do t = 1, size(polygon, 2)
      u = polygon(:, t) - middle
      v = polygon(:, modulo(t, size(polygon, 2)) + 1) - middle
      area = 0.5_dp*abs(u(1)*v(2) - u(2)*v(1))
      if (area <= least) cycle
      if (even) then
        do p = 1, 7
          n = n + 1
          x(n, :) = middle + rule(1, p)*u + rule(2, p)*v
          w(n) = weight(p)*area
        end do
      else
        do p = 1, 8
          do q = 1, 8
            n = n + 1
            x(n, :) = middle + (1 + gauss_8(p))/4*((1 - gauss_8(q))*u + (1 + gauss_8(q))*v)
            w(n) = (1 + gauss_8(p))/4*weight_8(p)*weight_8(q)*area
          end do
        end do
      end if
    end do
  end subroutine triangle_points

  !> Shape functions of points in both facets.
  pure subroutine enter(n, x, w, a, b, nodes_a, nodes_b, facet, last, points)
    integer, intent(in) :: n                  !< points
    real(dp), intent(in) :: x(most, 2), w(n)  !< their places [m], weights [m^2]
    real(dp), intent(in) :: a(2, 4), b(2, 4)  !< corners of the slave and master facet [m]
    integer, intent(in) :: nodes_a, nodes_b   !< their numbers of nodes
    integer, intent(in) :: facet              !< master facet
    real(dp), intent(in) :: last              !< change of natural coordinates after which they stay
    type(point_t), intent(inout) :: points(n) !< filled
    real(dp) :: xi(most, 2), corner(most, 4)
    integer :: p
    call locate(a, n, x, last, xi, corner)
    do p = 1, n
      points(p)%weight = w(p)
      points(p)%facet = facet
      points(p)%corner = corner(p, :)
      points(p)%slave(:4) = corner(p, :)
      if (nodes_a > 4) call shape_facet(8, xi(p, :), points(p)%slave)
    end do
    call locate(b, n, x, last, xi, corner)
    do p = 1, n
      points(p)%master(:4) = corner(p, :)
      if (nodes_b > 4) call shape_facet(8, xi(p, :), points(p)%master)
    end do
  end subroutine enter

  !> Are opposite sides of a quadrilateral so nearly equal that the rule for polynomials errs by less than 1e-10?
  pure logical function is_parallelogram(c)
    real(dp), intent(in) :: c(2, 4)  !< corners [m]
    real(dp), parameter :: hardly = 0.02_dp  !< difference of the sides over the diagonal
    is_parallelogram = maxval(abs(c(:, 1) - c(:, 2) + c(:, 3) - c(:, 4))) <= hardly*maxval(abs(c(:, 3) - c(:, 1)))
  end function is_parallelogram

  !> Natural coordinates of points in a bilinear quadrilateral, by Newton's method (one step for a rectangle), and shape functions
  !> of its corners there. All points go on until the last has settled, those that have stand still: its loops are vectors.
  pure subroutine locate(c, n, x, last, xi, shape)
    real(dp), intent(in) :: c(2, 4)        !< corners [m]
    integer, intent(in) :: n               !< points
    real(dp), intent(in) :: x(most, 2)     !< points [m]
    real(dp), intent(in) :: last           !< change of natural coordinates after which they stay
    real(dp), intent(inout) :: xi(most, 2)      !< gets natural coordinates
    real(dp), intent(inout) :: shape(most, 4)   !< and those of shape_corner
    real(dp), dimension(2) :: along, back, up, down   !< sides
    real(dp), dimension(most) :: s, t, move
    real(dp) :: r1, r2, u1, u2, v1, v2, det, step1, step2
    integer :: i, p
    along = c(:, 2) - c(:, 1)
    back = c(:, 3) - c(:, 4)
    up = c(:, 4) - c(:, 1)
    down = c(:, 3) - c(:, 2)
    s(:n) = 0
    t(:n) = 0
    move(:n) = 1
    do i = 1, 25
      shape(:n, 1) = (1 - s(:n))*(1 - t(:n))/4
      shape(:n, 2) = (1 + s(:n))*(1 - t(:n))/4
      shape(:n, 3) = (1 + s(:n))*(1 + t(:n))/4
      shape(:n, 4) = (1 - s(:n))*(1 + t(:n))/4
      do p = 1, n
        r1 = x(p, 1) - (((c(1, 1)*shape(p, 1) + c(1, 2)*shape(p, 2)) + c(1, 3)*shape(p, 3)) + c(1, 4)*shape(p, 4))
        r2 = x(p, 2) - (((c(2, 1)*shape(p, 1) + c(2, 2)*shape(p, 2)) + c(2, 3)*shape(p, 3)) + c(2, 4)*shape(p, 4))
        u1 = (along(1)*(1 - t(p)) + back(1)*(1 + t(p)))/4
        u2 = (along(2)*(1 - t(p)) + back(2)*(1 + t(p)))/4
        v1 = (up(1)*(1 - s(p)) + down(1)*(1 + s(p)))/4
        v2 = (up(2)*(1 - s(p)) + down(2)*(1 + s(p)))/4
        det = u1*v2 - u2*v1
        step1 = (r1*v2 - r2*v1)/det
        step2 = (u1*r2 - u2*r1)/det
        s(p) = s(p) + move(p)*step1
        t(p) = t(p) + move(p)*step2
        move(p) = merge(0._dp, move(p), max(abs(step1), abs(step2)) < last)
      end do
      if (.not. any(move(:n) > 0)) exit
    end do
    xi(:n, 1) = s(:n)
    xi(:n, 2) = t(:n)
    shape(:n, 1) = (1 - s(:n))*(1 - t(:n))/4
    shape(:n, 2) = (1 + s(:n))*(1 - t(:n))/4
    shape(:n, 3) = (1 + s(:n))*(1 + t(:n))/4
    shape(:n, 4) = (1 - s(:n))*(1 + t(:n))/4
  end subroutine locate
end module hd_segment
