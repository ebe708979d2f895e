! SPDX-License-Identifier: GPL-3.0-or-later
!> Coulomb friction of struts. Beside a strut of power 1 that pushes along its normal stands a companion along its tangent: a
!> spring of stiffness k_t that carries T between -mu F and mu F while the strut pushes with F, and nothing else. Within a load
!> step closing and way are taken to move evenly. So where a strut closes its companion has its spring from the part of the step on
!> in which it touches, and where it opens it forgets.
!>
!> Linearised, a companion that sticks has  dT = rate dx + lean dF,  one that slides  dT = lean dF.
module hd_flank_friction
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_lapack, only: solve_dense
  use hd_strut, only: strut_t, strut_force, strut_tangent
  implicit none
  private
  public :: rub_t, rub, remembered, strut_laws, rubbed_answers, lean_rows, give_way_rubbing, memories

  integer, parameter :: memories = 4  !< of a companion: closing of its partner [m], way [m], friction T [N], work so far [J]

  !> The last struts are companions.
  type :: rub_t
    real(dp) :: friction = 0                !< mu
    integer, allocatable :: partner(:)      !< number of the strut that each companion goes with
    real(dp), allocatable :: lean(:)        !< dT/dF of each companion at the present iterate
    logical, allocatable :: slides(:)       !< it slides there
  end type rub_t

contains

  !> Friction of a strut at the end of a step, and its derivatives.
  elemental subroutine rub(mu, k_n, k_t, closing, way, closing_0, way_0, force_0, force, rate, lean, slides)
    real(dp), intent(in) :: mu                          !< Coulomb's coefficient
    real(dp), intent(in) :: k_n, k_t                    !< stiffness along normal and tangent [N/m]
    real(dp), intent(in) :: closing, way                !< of strut and companion [m]
    real(dp), intent(in) :: closing_0, way_0, force_0   !< at the beginning of the step, with the friction there [m], [m], [N]
    real(dp), intent(out) :: force                      !< T [N]
    real(dp), intent(out) :: rate                       !< dT/dx; of one that slides k_t, of one that is open 0 [N/m]
    real(dp), intent(out) :: lean                       !< dT/dF
    logical, intent(out) :: slides                      !< T is at its bound, and its end slips
    real(dp), parameter :: rounding = 1e-9_dp           !< at the bound itself it sticks: a torque that turns back begins so
    real(dp) :: share, bound
    force = 0
    rate = 0
    lean = 0
    slides = .false.
    if (.not. closing > 0) return
    share = 1
    if (closing_0 < 0) share = closing/(closing - closing_0)
    force = force_0 + k_t*share*(way - way_0)
    rate = k_t*share
    if (closing_0 < 0) lean = -k_t*(way - way_0)*closing_0/(closing - closing_0)**2/k_n
    bound = mu*k_n*closing
    slides = abs(force) > (1 + rounding)*bound
    if (slides) then
      rate = k_t
      lean = sign(mu, force)
    end if
    if (abs(force) > bound) force = sign(bound, force)
  end subroutine rub

  !> What a companion remembers when the step is over. Its end slips from where T first reaches its bound, until the step ends or
  !> the strut opens; T and way change evenly.
  pure function remembered(mu, k_n, k_t, closing, way, force, past) result(memory)
    real(dp), intent(in) :: mu                          !< Coulomb's coefficient
    real(dp), intent(in) :: k_n, k_t                    !< stiffness along normal and tangent [N/m]
    real(dp), intent(in) :: closing, way, force         !< at the end [m], [m], [N]
    real(dp), intent(in) :: past(memories)              !< at the beginning
    real(dp) :: memory(memories)
    real(dp) :: moved, bound(2), trial, sense, faster, begun, slipped
    memory = [closing, way, force, past(4)]
    if (.not. max(closing, past(1)) > 0) return
    moved = way - past(2)
    if (min(closing, past(1)) < 0) moved = moved*max(closing, past(1))/abs(closing - past(1))
    bound = mu*k_n*max(0._dp, [past(1), closing])
    trial = past(3) + k_t*moved
    sense = sign(1._dp, trial)
    if (.not. abs(trial) > bound(2)) return
    faster = sense*k_t*moved - (bound(2) - bound(1))
    begun = 0
    if (faster > 0) begun = min(1._dp, max(0._dp, (bound(1) - sense*past(3))/faster))
    slipped = moved - (force - past(3))/k_t
    memory(4) = past(4) + sense*(bound(1) + begun*(bound(2) - bound(1)) + bound(2))/2*slipped
  end function remembered

  !> Forces of all struts at their closings, and their tangents.
  pure subroutine strut_laws(struts, law, past, closing, force, rate, lean, slides)
    type(strut_t), intent(in) :: struts(:)             !< struts
    type(rub_t), intent(in) :: law                     !< their friction
    real(dp), intent(in) :: past(:, :)                 !< when the step begins (memories, companions)
    real(dp), intent(in) :: closing(:)                 !< (struts) [m]
    real(dp), intent(out) :: force(:), rate(:)         !< (struts) [N], [N/m]
    real(dp), intent(out) :: lean(:)                   !< (companions)
    logical, intent(out) :: slides(:)                  !< (companions)
    integer :: n
    n = size(struts) - size(law%partner)
    force(:n) = strut_force(struts(:n), closing(:n))
    rate(:n) = strut_tangent(struts(:n), closing(:n))
    call rub(law%friction, struts(law%partner)%rate, struts(n + 1:)%rate, closing(law%partner), closing(n + 1:), past(1, :), &
      past(2, :), past(3, :), force(n + 1:), rate(n + 1:), lean, slides)
  end subroutine strut_laws

  !> Forces by the tangents; what the struts stand on gives way [N].
  function rubbed_answers(rate, law, closing, give) result(force)
    real(dp), intent(in) :: rate(:)                 !< tangents, 0: does not push (struts) [N/m]
    type(rub_t), intent(in) :: law                  !< with lean, slides
    real(dp), intent(in) :: closing(:)              !< (struts) [m]
    real(dp), intent(in), optional :: give(:, :)    !< (struts, struts) [m/N]
    real(dp) :: force(size(rate))
    type(error_t), allocatable :: error   ! never: a positive definite matrix, and rows of 1 for what slides
    real(dp), allocatable :: a(:, :), b(:, :)
    integer, allocatable :: list(:)
    integer :: i, n
    n = size(rate) - size(law%partner)
    if (.not. present(give)) then
      force = rate*closing
      do i = 1, size(law%partner)
        if (law%slides(i)) force(n + i) = 0
        if (rate(n + i) > 0) force(n + i) = force(n + i) + law%lean(i)*force(law%partner(i))
      end do
      return
    end if
    list = pack([(i, i=1, size(rate))], rate > 0)
    a = give(list, list)
    b = reshape(closing(list), [size(list), 1])
    do i = 1, size(list)
      a(i, i) = a(i, i) + 1/rate(list(i))
    end do
    call lean_rows(law, list, size(rate), rate, a, b(:, 1))
    call solve_dense(a, b, error)
    force = 0
    force(list) = b(:, 1)
  end function rubbed_answers

  !> Rows of companions in equations for the forces of those struts that push: they hang on their partner, and one that slides on
  !> nothing else.
  pure subroutine lean_rows(law, list, struts, rate, a, b)
    type(rub_t), intent(in) :: law          !< with lean, slides
    integer, intent(in) :: list(:)          !< struts that push
    integer, intent(in) :: struts           !< all of them
    real(dp), intent(in) :: rate(:)         !< tangents (struts) [N/m]
    real(dp), intent(inout) :: a(:, :)      !< equations of the list come first [m/N]
    real(dp), intent(inout), optional :: b(:)  !< right-hand sides [m]
    integer :: i, k, n
    n = struts - size(law%partner)
    do i = 1, size(list)
      if (list(i) <= n) cycle
      associate (companion => list(i) - n)
        if (law%slides(companion)) then
          a(i, :) = 0
          a(i, i) = 1/rate(list(i))
          if (present(b)) b(i) = 0
        end if
        k = findloc(list, law%partner(companion), 1)
        if (k > 0) a(i, k) = a(i, k) - law%lean(companion)/rate(list(i))  ! else its partner's force does not change
      end associate
    end do
  end subroutine lean_rows

  !> Closings left where what struts and companions stand on has given way, by Newton's method. Whole steps may run in a cycle where
  !> flanks that slide stick again and others slide for it: steps are halved until they lower what the closings miss.
  subroutine give_way_rubbing(struts, law, past, give, closing)
    type(strut_t), intent(in) :: struts(:)     !< struts
    type(rub_t), intent(in) :: law             !< their friction
    real(dp), intent(in) :: past(:, :)         !< when the step begins (memories, companions)
    real(dp), intent(in) :: give(:, :)         !< (struts, struts), 0 for struts of another power [m/N]
    real(dp), intent(inout) :: closing(:)      !< (struts) [m]
    integer, parameter :: most = 100, halvings = 10
    real(dp), parameter :: rounding = 1e-13_dp
    real(dp), dimension(size(closing)) :: left, force, rate, aim, way, begun
    logical :: yields(size(closing))
    type(rub_t) :: now
    real(dp) :: before, missed
    integer :: i, j, k, n
    n = size(struts) - size(law%partner)
    yields = [(give(i, i) > 0 .and. closing(i) > -1, i=1, size(closing))]
    now = law
    left = closing
    call look(missed)
    do k = 1, most
      if (.not. missed > rounding*maxval(abs(left), mask=yields)) exit
      where (.not. yields) rate = 0
      aim = closing
      do i = 1, size(law%partner)
        if (rate(n + i) > 0 .and. .not. now%slides(i)) aim(n + i) = closing(n + i) - left(n + i) + &
          (force(n + i) - now%lean(i)*force(law%partner(i)))/rate(n + i)
      end do
      way = closing - matmul(give, rubbed_answers(rate, now, aim, give)) - left
      begun = left
      before = missed
      do j = 0, halvings
        left = begun + way/2**modulo(j, halvings)  ! where none lowers it, the whole step
        call look(missed)
        if (missed < before) exit
      end do
    end do
    where (yields) closing = left
  contains
    !> Forces and tangents at the present closings, and the largest amount by which these miss their equation.
    subroutine look(missed)
      real(dp), intent(out) :: missed
      call strut_laws(struts, law, past, left, force, rate, now%lean, now%slides)
      missed = maxval(abs(left - closing + matmul(give, force)), mask=yields)
    end subroutine look
  end subroutine give_way_rubbing
end module hd_flank_friction
