! SPDX-License-Identifier: GPL-3.0-or-later
!> Meridian of a cup by sections: a line of points from the opening to the hub on the cup's inside, with the thickness of the wall
!> at each, straight between them, rounded where a point has a fillet.
!>
!> The outside lies on the right of the way from the opening to the hub. At a sharp corner it is mitred. A point that stands twice
!> has one thickness before it and one behind it.
module hd_meridian
  use hd_kinds, only: dp, pi, hair
  use hd_text, only: to_text
  implicit none
  private
  public :: meridian_t, new_meridian

  real(dp), parameter :: jump = 1e-6_dp        !< of the thickness, relative, that is none: keys have fewer digits
  real(dp), parameter :: same = 1e-9_dp        !< points closer than this are one, over the length of the meridian
  real(dp), parameter :: straight = 15*pi/180  !< corners below are none: the thickness must not jump there [rad]
  real(dp), parameter :: sharpest = 150*pi/180 !< corner [rad]
  integer, parameter :: chords = 6             !< of a fillet, where the outline is checked

  !> One straight piece or one fillet of the inner line.
  type :: piece_t
    real(dp) :: from(2) = 0, to(2) = 0      !< r, z of its ends [m]
    real(dp) :: thickness(2) = 0            !< there [m]
    real(dp) :: normal(2) = 0               !< outwards, at its beginning
    real(dp) :: shift(2) = 0                !< of the outer line at the ends, along the piece: mitres [m]
    real(dp) :: radius = 0                  !< of a fillet [m]
    real(dp) :: turn = 0                    !< of a fillet, to the left positive [rad]
  end type piece_t

  type :: meridian_t
    type(piece_t), allocatable :: piece(:)  !< from the opening to the hub
  contains
    procedure :: length
    procedure :: at
    procedure :: axial
  end type meridian_t

contains

  !> Meridian through sections; `fault` says what is wrong with them (empty: nothing).
  pure subroutine new_meridian(r, z, thickness, fillet, meridian, fault)
    real(dp), intent(in) :: r(:), z(:)        !< points on the inside [m]
    real(dp), intent(in) :: thickness(:)      !< of the wall there [m]
    real(dp), intent(in) :: fillet(:)         !< radius of the inside there, 0: sharp [m]
    type(meridian_t), intent(out) :: meridian !< pieces
    character(len=:), allocatable, intent(out) :: fault
    real(dp) :: point(2, size(r)), t(2, size(r)), rho(size(r)), d(2, size(r)), reach(size(r)), turn(size(r)), length
    integer :: i, n, twice
    type(piece_t) :: p
    fault = ''
    length = sum(hypot(r(2:) - r(:size(r) - 1), z(2:) - z(:size(r) - 1)))
    n = 0
    twice = 0
    do i = 1, size(r)
      if (n > 0) then
        if (hypot(r(i) - point(1, n), z(i) - point(2, n)) <= same*length) then
          twice = twice + 1
          if (twice > 1) fault = at_point(point(:, n))//' stands three times'
          t(2, n) = thickness(i)
          rho(n) = max(rho(n), fillet(i))
          cycle
        end if
      end if
      n = n + 1
      twice = 0
      point(:, n) = [r(i), z(i)]
      t(:, n) = thickness(i)
      rho(n) = fillet(i)
    end do
    if (n < 2 .and. len(fault) == 0) fault = 'they are one point'
    if (len(fault) > 0) return
    do i = 1, n - 1
      d(:, i) = (point(:, i + 1) - point(:, i))/norm2(point(:, i + 1) - point(:, i))
    end do
    turn = 0
    reach = 0
    do i = 2, n - 1
      turn(i) = atan2(d(1, i - 1)*d(2, i) - d(2, i - 1)*d(1, i), dot_product(d(:, i - 1), d(:, i)))
      if (abs(turn(i)) > hair) reach(i) = rho(i)*tan(abs(turn(i))/2)
      call check_corner(point(:, i), t(:, i), rho(i), turn(i), fault)
      if (len(fault) > 0) return
    end do
    allocate (meridian%piece(0))
    do i = 1, n - 1
      length = norm2(point(:, i + 1) - point(:, i))
      if (reach(i) + reach(i + 1) > length*(1 + same)) then
        fault = 'the fillets at '//at_point(point(:, i))//' and '//at_point(point(:, i + 1))//' do not fit between them'
        return
      end if
      p = piece_t(from=point(:, i) + reach(i)*d(:, i), to=point(:, i + 1) - reach(i + 1)*d(:, i), &
        thickness=[t(2, i), t(1, i + 1)], normal=right(d(:, i)))
      if (i > 1 .and. .not. reach(i) > 0) p%shift(1) = dot_product(mitre(d(:, i - 1), d(:, i), t(:, i), turn(i)), d(:, i))
      if (i < n - 1 .and. .not. reach(i + 1) > 0) p%shift(2) = &
        dot_product(mitre(d(:, i), d(:, i + 1), t(:, i + 1), turn(i + 1)), d(:, i))
      if (reach(i) + reach(i + 1) < length*(1 - same)) meridian%piece = [meridian%piece, p]
      if (reach(i + 1) > 0) meridian%piece = [meridian%piece, piece_t(from=p%to, to=point(:, i + 1) + reach(i + 1)*d(:, i + 1), &
        thickness=t(:, i + 1), normal=p%normal, radius=rho(i + 1), turn=turn(i + 1))]
    end do
    call check_outline(meridian, fault)
  end subroutine new_meridian

  !> What a corner may be.
  pure subroutine check_corner(point, t, rho, turn, fault)
    real(dp), intent(in) :: point(2)   !< r, z [m]
    real(dp), intent(in) :: t(2)       !< thickness before and behind [m]
    real(dp), intent(in) :: rho        !< fillet [m]
    real(dp), intent(in) :: turn       !< [rad]
    character(len=:), allocatable, intent(inout) :: fault  !< gets it
    if (abs(turn) > sharpest) then
      fault = 'the wall turns back at '//at_point(point)
    else if (abs(turn) < straight .and. abs(t(1) - t(2)) > jump*maxval(t)) then
      fault = 'the thickness jumps from '//to_text(t(1))//' to '//to_text(t(2))//' m at '//at_point(point)// &
        ', where the wall runs straight on: give it in two points apart'
    else if (turn < 0 .and. rho > 0 .and. rho <= maxval(t)*(1 + hair)) then
      fault = 'the fillet of '//to_text(rho)//' m at '//at_point(point)//' is not above the thickness '//to_text(maxval(t))// &
        ' m, where the wall bends outwards: its outside would have no radius left'
    end if
  end subroutine check_corner

  !> Outer corner from the inner one: at the distances t of both outer lines.
  pure function mitre(before, behind, t, turn) result(x)
    real(dp), intent(in) :: before(2), behind(2)  !< directions
    real(dp), intent(in) :: t(2)                  !< thickness before and behind [m]
    real(dp), intent(in) :: turn                  !< [rad]
    real(dp) :: x(2)
    associate (a => right(before), b => right(behind))
      if (abs(turn) < straight) then
        x = t(1)*(a + b)/(1 + dot_product(a, b))
      else
        x = [t(1)*b(2) - t(2)*a(2), t(2)*a(1) - t(1)*b(1)]/(a(1)*b(2) - a(2)*b(1))
      end if
    end associate
  end function mitre

  !> Unit vector on the right of a direction.
  pure function right(d)
    real(dp), intent(in) :: d(2)  !< r, z
    real(dp) :: right(2)
    right = [d(2), -d(1)]
  end function right

  !> Length of the inner line of a piece [m].
  pure real(dp) function length(self, k)
    class(meridian_t), intent(in) :: self  !< meridian
    integer, intent(in) :: k               !< piece
    associate (p => self%piece(k))
      length = norm2(p%to - p%from)
      if (p%radius > 0) length = p%radius*abs(p%turn)
    end associate
  end function length

  !> Does a piece run along the axis rather than across it?
  pure logical function axial(self, k)
    class(meridian_t), intent(in) :: self  !< meridian
    integer, intent(in) :: k               !< piece
    associate (p => self%piece(k))
      axial = .not. p%radius > 0 .and. abs(p%to(2) - p%from(2)) >= abs(p%to(1) - p%from(1))
    end associate
  end function axial

  !> Points of both lines at a part of a piece. Where a corner takes away from the outer line, its neighbourhood makes room.
  pure subroutine at(self, k, part, inner, outer)
    class(meridian_t), intent(in) :: self         !< meridian
    integer, intent(in) :: k                      !< piece
    real(dp), intent(in) :: part                  !< 0 to 1, of the inner line
    real(dp), intent(out) :: inner(2), outer(2)   !< r, z [m]
    real(dp) :: normal(2), angle, t, whole, shift
    associate (p => self%piece(k))
      t = (1 - part)*p%thickness(1) + part*p%thickness(2)
      if (p%radius > 0) then
        angle = part*p%turn
        normal = [p%normal(1)*cos(angle) - p%normal(2)*sin(angle), p%normal(1)*sin(angle) + p%normal(2)*cos(angle)]
        inner = p%from + sign(p%radius, p%turn)*(normal - p%normal)
        outer = inner + t*normal
      else
        inner = (1 - part)*p%from + part*p%to
        whole = norm2(p%to - p%from)
        shift = near_end(p%shift(1), part*whole, whole) - near_end(-p%shift(2), (1 - part)*whole, whole)
        outer = inner + t*p%normal + shift*(p%to - p%from)/whole
      end if
    end associate
  end subroutine at

  !> Shift of the outer line at a distance from an end: at the end itself, and where it goes into the piece also beside it.
  pure real(dp) function near_end(shift, distance, whole)
    real(dp), intent(in) :: shift     !< at the end, positive into the piece [m]
    real(dp), intent(in) :: distance  !< from the end [m]
    real(dp), intent(in) :: whole     !< length of the piece [m]
    near_end = 0
    if (distance <= same*whole) then
      near_end = shift
    else if (shift > 0) then
      near_end = shift*max(0._dp, 1 - distance/min(3*shift, whole/2))
    end if
  end function near_end

  !> The outline must not meet itself, nor the wall turn inside out.
  pure subroutine check_outline(meridian, fault)
    type(meridian_t), intent(in) :: meridian               !< meridian
    character(len=:), allocatable, intent(inout) :: fault  !< gets it
    real(dp) :: inner(2, 1 + chords*size(meridian%piece)), outer(2, 1 + chords*size(meridian%piece))
    real(dp), allocatable :: line(:, :)
    integer :: i, j, k, n
    n = 0
    do k = 1, size(meridian%piece)
      j = merge(chords, 1, meridian%piece(k)%radius > 0)
      do i = merge(0, 1, k == 1), j
        n = n + 1
        call meridian%at(k, real(i, dp)/j, inner(:, n), outer(:, n))
        if (outer(1, n) <= 0) fault = 'the outside reaches the axis at '//at_point(inner(:, n))
        if (n == 1) cycle
        if (cross(inner(:, n - 1), outer(:, n - 1), outer(:, n)) <= 0 .or. &
          cross(inner(:, n - 1), outer(:, n), inner(:, n)) <= 0) fault = 'the wall turns inside out at '//at_point(inner(:, n))// &
          ': it is too thick for its corners or fillets'
        if (len(fault) > 0) return
      end do
    end do
    allocate (line(2, 2*n + 1))
    line(:, :n) = inner(:, :n)
    line(:, n + 1:2*n) = outer(:, n:1:-1)
    line(:, 2*n + 1) = inner(:, 1)
    do i = 1, 2*n - 2
      do j = i + 2, 2*n - merge(1, 0, i == 1)
        if (.not. meets(line(:, i), line(:, i + 1), line(:, j), line(:, j + 1))) cycle
        fault = 'the outline meets itself between '//at_point(line(:, i))//' and '//at_point(line(:, j))
        return
      end do
    end do
  end subroutine check_outline

  !> Do two stretches cross or touch?
  pure logical function meets(a, b, c, d)
    real(dp), dimension(2), intent(in) :: a, b, c, d  !< their ends
    meets = cross(a, b, c)*cross(a, b, d) <= 0 .and. cross(c, d, a)*cross(c, d, b) <= 0 .and. &
      all(max(a, b) >= min(c, d)) .and. all(max(c, d) >= min(a, b))
  end function meets

  !> Twice the area of a triangle, positive where it turns to the left.
  pure real(dp) function cross(a, b, c)
    real(dp), dimension(2), intent(in) :: a, b, c  !< corners
    cross = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
  end function cross

  !> Place for a message.
  pure function at_point(x) result(s)
    real(dp), intent(in) :: x(2)  !< r, z [m]
    character(len=:), allocatable :: s
    s = 'r, z = '//to_text(x(1))//', '//to_text(x(2))//' m'
  end function at_point
end module hd_meridian
