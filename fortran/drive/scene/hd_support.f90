! SPDX-License-Identifier: GPL-3.0-or-later
!> Supports: where the torque comes in and what takes it, and what follows from that for everybody who asks.
module hd_support
  implicit none
  private
  public :: support_t, support_of, supports_where, support_names, support_words

  type :: support_t
    character(len=32) :: name = 'hub'
    logical :: contact = .true.          !< cup and ring touch and slip: there are pressures and a K_TS; else they are bonded
    logical :: friction_alone = .false.  !< nothing but friction carries the torque: beyond it the contact slips as a whole
    logical :: against_teeth = .false.   !< the bottom is turned until teeth carry the torque, by the compliance at the rim
    logical :: turns_bottom = .false.    !< the torque stands at the bottom, which turns; else on the rim, the bottom held or free
    logical :: struts = .false.          !< balls and flanks of teeth push on the bodies, each while it closes
    logical :: loop = .false.            !< one torque follows the other: results are chords and width of a loop
  end type support_t

  type(support_t), parameter :: supports(4) = [support_t('hub'), support_t('bearing', friction_alone=.true.), &
    support_t('teeth', contact=.false., against_teeth=.true.), support_t('drive', turns_bottom=.true., struts=.true., loop=.true.)]

  character(len=*), parameter :: support_names = 'hub bearing teeth drive'
  character(len=*), parameter :: support_words = 'hub: the bottom of the cup is held, the torque leaves there; bearing: the '// &
    'bottom turns freely, all torque goes through the contact; teeth: the cup is turned against the teeth of the circular '// &
    'spline (bonded ring); drive: the whole drive of balls, ring, friction and teeth, the torque at the bottom'

contains

  !> Support of a name.
  elemental type(support_t) function support_of(name) result(support)
    character(len=*), intent(in) :: name  !< one of `support_names`
    support = supports(findloc(supports%name == name, .true., 1))
  end function support_of

  !> Names of the supports of which an answer holds, parted by commas; empty where nobody answers that.
  pure function supports_where(answer) result(names)
    character(len=*), intent(in) :: answer  !< a component of support_t, or 'teeth': pairs of teeth carry load
    character(len=:), allocatable :: names
    logical :: holds(size(supports))
    integer :: i
    holds = .false.
    select case (answer)
    case ('contact'); holds = supports%contact
    case ('friction_alone'); holds = supports%friction_alone
    case ('against_teeth'); holds = supports%against_teeth
    case ('struts'); holds = supports%struts
    case ('loop'); holds = supports%loop
    case ('teeth'); holds = supports%against_teeth .or. supports%struts
    end select
    names = ''
    do i = 1, size(supports)
      if (holds(i)) names = names//','//trim(supports(i)%name)
    end do
    names = names(min(2, len(names) + 1):)
  end function supports_where
end module hd_support
