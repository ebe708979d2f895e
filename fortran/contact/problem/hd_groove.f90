! SPDX-License-Identifier: GPL-3.0-or-later
!> Balls in grooves. A ball between two grooves of circular section pushes along the line of their centres, which lie apart by
!> `reach` where all just touch. With c the radial closing and v the way of one centre along the axis against the other
!>
!>   s = sqrt((reach + c)^2 + v^2),   F = Q (n_c, n_v),  n = (reach + c, v)/s,   Q Hertz's force at the closing s - reach,
!>   dF/d(c, v) = k n n^T + Q/s t t^T,   t = (-n_v, n_c),  k = dQ/ds:
!> two struts (hd_strut), one of c and one of v, that share one energy. Harris, Rolling Bearing Analysis, 7.
module hd_groove
  use hd_kinds, only: dp
  use hd_strut, only: strut_t, strut_energy, strut_force, strut_tangent
  implicit none
  private
  public :: groove_t, groove_forces, groove_tangents, groove_answers, groove_energy, groove_curvature, stiffen_way

  !> The first struts of a problem are balls; as many behind `before` take their ways along the axis.
  type :: groove_t
    integer :: balls = 0                    !< so many
    integer :: before = 0                   !< struts before those of the axial ways
    real(dp) :: reach = 0                   !< of the centres of the grooves' sections: both radii less the ball's diameter [m]
    real(dp), allocatable :: cross(:)       !< entry of the inverse tangent between c and v, at the present iterate (balls) [m/N]
  end type groove_t

contains

  !> Line of a ball, and how far it closes along it. Where a ring stands off further than `reach` its balls lie free.
  pure subroutine line_of(reach, c, v, n, s, closing)
    real(dp), intent(in) :: reach          !< [m]
    real(dp), intent(in) :: c, v           !< [m]
    real(dp), intent(out) :: n(2), s       !< direction; distance of the centres [m]
    real(dp), intent(out) :: closing       !< [m]
    s = hypot(max(reach + c, 0._dp), v)
    if (s > 0) then
      n = [max(reach + c, 0._dp), v]/s
    else
      n = [1._dp, 0._dp]
    end if
    closing = max(c, -reach)
    if (v /= 0) closing = closing + v**2/(s + reach + closing)  ! s - reach without its rounding
  end subroutine line_of

  !> Forces of the balls along both of their ways.
  pure subroutine groove_forces(groove, struts, closing, force)
    type(groove_t), intent(in) :: groove     !< grooves
    type(strut_t), intent(in) :: struts(:)   !< all struts
    real(dp), intent(in) :: closing(:)       !< (struts) [m]
    real(dp), intent(inout) :: force(:)      !< gets those of balls (struts) [N]
    real(dp) :: n(2), s, along
    integer :: i
    do i = 1, groove%balls
      call line_of(groove%reach, closing(i), closing(groove%before + i), n, s, along)
      force([i, groove%before + i]) = strut_force(struts(i), along)*n
    end do
  end subroutine groove_forces

  !> Tangents of the balls: one over the diagonal of the inverse, 0 where a ball does not push, and what stands beside it.
  pure subroutine groove_tangents(groove, struts, closing, rate)
    type(groove_t), intent(inout) :: groove  !< gets cross
    type(strut_t), intent(in) :: struts(:)   !< all struts
    real(dp), intent(in) :: closing(:)       !< (struts) [m]
    real(dp), intent(inout) :: rate(:)       !< gets those of balls (struts) [N/m]
    real(dp) :: n(2), s, along, give(2)
    integer :: i
    groove%cross = spread(0._dp, 1, groove%balls)
    do i = 1, groove%balls
      call line_of(groove%reach, closing(i), closing(groove%before + i), n, s, along)
      rate([i, groove%before + i]) = 0
      if (.not. strut_force(struts(i), along) > tiny(s)) cycle
      give = [1/strut_tangent(struts(i), along), s/strut_force(struts(i), along)]
      rate([i, groove%before + i]) = 1/[n(1)**2*give(1) + n(2)**2*give(2), n(2)**2*give(1) + n(1)**2*give(2)]
      groove%cross(i) = n(1)*n(2)*(give(1) - give(2))
    end do
  end subroutine groove_tangents

  !> Tangents of a ball whose way along the axis becomes stiffer, but for that of this way.
  pure subroutine stiffen_way(groove, strut, more, rate)
    type(groove_t), intent(inout) :: groove  !< gets cross
    integer, intent(in) :: strut             !< one of any kind; those of axial ways have a ball
    real(dp), intent(in) :: more             !< [N/m]
    real(dp), intent(inout) :: rate(:)       !< tangents, this one as it was (struts) [N/m]
    integer :: i
    i = strut - groove%before
    if (i < 1 .or. i > groove%balls) return
    if (.not. rate(i) > 0) return  ! the ball is free: no cross
    rate(i) = 1/(1/rate(i) - more/(1 + more/rate(strut))*groove%cross(i)**2)
    groove%cross(i) = groove%cross(i)/(1 + more/rate(strut))
  end subroutine stiffen_way

  !> Forces of the balls by their present tangents.
  pure subroutine groove_answers(groove, rate, closing, force)
    type(groove_t), intent(in) :: groove     !< with cross
    real(dp), intent(in) :: rate(:)          !< of groove_tangents (struts) [N/m]
    real(dp), intent(in) :: closing(:)       !< (struts) [m]
    real(dp), intent(inout) :: force(:)      !< gets those of balls (struts) [N]
    real(dp) :: own, other
    integer :: i
    do i = 1, groove%balls
      force(groove%before + i) = rate(groove%before + i)*closing(groove%before + i)
      if (.not. rate(i) > 0) cycle
      associate (c => closing(i), v => closing(groove%before + i), b => groove%cross(i))
        own = 1/rate(i)
        other = 1/rate(groove%before + i)
        force([i, groove%before + i]) = [other*c - b*v, own*v - b*c]/(own*other - b**2)
      end associate
    end do
  end subroutine groove_answers

  !> Energy of the balls less that of their struts one by one [J].
  pure real(dp) function groove_energy(groove, struts, closing) result(e)
    type(groove_t), intent(in) :: groove     !< grooves
    type(strut_t), intent(in) :: struts(:)   !< all struts
    real(dp), intent(in) :: closing(:)       !< (struts) [m]
    real(dp) :: n(2), s, along
    integer :: i
    e = 0
    do i = 1, groove%balls
      call line_of(groove%reach, closing(i), closing(groove%before + i), n, s, along)
      e = e + strut_energy(struts(i), along) - strut_energy(struts(i), closing(i)) - &
        strut_energy(struts(groove%before + i), closing(groove%before + i))
    end do
  end function groove_energy

  !> Derivative by c and v of the work a . dF/d(c, v) . b of a ball.
  pure function groove_curvature(groove, strut, c, v, a, b) result(g)
    type(groove_t), intent(in) :: groove   !< grooves
    type(strut_t), intent(in) :: strut     !< the ball's
    real(dp), intent(in) :: c, v           !< [m]
    real(dp), intent(in) :: a(2), b(2)     !< along c and v
    real(dp) :: g(2), n(2), t(2), s, along, turn
    g = 0
    call line_of(groove%reach, c, v, n, s, along)
    if (.not. along > 0) return
    t = [-n(2), n(1)]
    turn = strut_tangent(strut, along)/s - strut_force(strut, along)/s**2
    associate (an => dot_product(a, n), at => dot_product(a, t), bn => dot_product(b, n), bt => dot_product(b, t))
      g = strut_tangent(strut, along)*(strut%power - 1)/along*an*bn*n + turn*(at*bt*n + (an*bt + at*bn)*t)
    end associate
  end function groove_curvature
end module hd_groove
