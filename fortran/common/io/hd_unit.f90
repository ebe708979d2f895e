! SPDX-License-Identifier: GPL-3.0-or-later
!> Values that are written with a unit, as '0.36 mm' for a key in m.
module hd_unit
  use hd_kinds, only: dp, i8, pi
  use hd_text, only: exact, to_number, to_text, unquoted
  implicit none
  private
  public :: in_unit, other_units

  !> A unit that a value may be written in, spelt as by `spelt`: times a number and a power of ten the key's own.
  type :: unit_t
    character(len=6) :: written, of
    integer :: ten
    real(dp) :: times = 1
  end type unit_t
  type(unit_t), parameter :: units(*) = [ &
    unit_t('mm', 'm', -3), unit_t('cm', 'm', -2), unit_t('um', 'm', -6), unit_t('nm', 'm', -9), unit_t('in', 'm', -2, 2.54_dp), &
    unit_t('kPa', 'Pa', 3), unit_t('MPa', 'Pa', 6), unit_t('GPa', 'Pa', 9), unit_t('N/mm2', 'Pa', 6), unit_t('Nmm', 'Nm', -3), &
    unit_t('kNm', 'Nm', 3), unit_t('N/mm', 'N/m', 3), unit_t('N/um', 'N/m', 6), unit_t('kN/mm', 'N/m', 6), &
    unit_t('mm2', 'm2', -6), unit_t('um2', 'm2', -12), unit_t('rad', 'deg', 0, 180/pi), unit_t('arcmin', 'deg', 0, 1/60._dp), &
    unit_t('min', 's', 0, 60._dp), unit_t('h', 's', 0, 3600._dp), unit_t('GB', 'MB', 3)]
  character(len=*), parameter :: figures = '0123456789'
  ! Signs of two bytes, and how they are spelt: micro and the Greek letter, degree, square, point.
  character(len=2), parameter :: signs(*) = ['µ', 'μ', '°', '²', '·']
  character(len=3), parameter :: letters(*) = ['u  ', 'u  ', 'deg', '2  ', '   ']

contains

  !> A word as a number in the key's unit: '0.36 mm' becomes 0.36e-3, the same bits; one without a unit that is known stays.
  pure function in_unit(word, unit) result(plain)
    character(len=*), intent(in) :: word    !< as in the file
    character(len=*), intent(in) :: unit    !< of the key
    character(len=:), allocatable :: plain
    character(len=:), allocatable :: text, written
    real(dp) :: x
    logical :: ok
    integer :: i, last
    plain = word
    text = trim(adjustl(unquoted(word)))
    last = end_of_number(text)
    written = spelt(text(last + 1:))
    call to_number(text(:last), x, ok)
    if (.not. ok .or. len(written) == 0) return
    if (written == spelt(unit)) plain = text(:last)
    do i = 1, size(units)
      if (units(i)%of /= spelt(unit) .or. units(i)%written /= written) cycle
      if (abs(units(i)%times - 1) > 0) then
        plain = shifted(exact(x*units(i)%times), units(i)%ten)
      else
        plain = shifted(text(:last), units(i)%ten)
      end if
    end do
  end function in_unit

  !> What a value in this unit may be written in besides, empty if in nothing.
  pure function other_units(unit) result(list)
    character(len=*), intent(in) :: unit    !< of a key
    character(len=:), allocatable :: list
    integer :: i
    list = ''
    do i = 1, size(units)
      if (units(i)%of == spelt(unit) .and. len(unit) > 0) list = list//', '//trim(units(i)%written)
    end do
    if (len(list) > 0) list = list(3:)
  end function other_units

  !> Last character of the number that a text begins with, 0 if there is none.
  pure integer function end_of_number(text) result(last)
    character(len=*), intent(in) :: text    !< number and unit
    integer :: more
    last = verify(text//'|', figures//'+-.') - 1
    if (last == 0 .or. last >= len(text)) return
    if (scan(text(last + 1:last + 1), 'eEdD') == 0) return
    more = verify(text(last + 2:)//'|', figures//'+-') - 1
    if (more > 0) last = last + 1 + more
  end function end_of_number

  !> The number times a power of ten, by its exponent.
  pure function shifted(number, ten) result(plain)
    character(len=*), intent(in) :: number  !< with or without an exponent
    integer, intent(in) :: ten              !< power
    character(len=:), allocatable :: plain
    integer(i8) :: power
    integer :: at
    logical :: ok
    plain = number
    at = scan(number//'e', 'eEdD')
    power = 0
    ok = .true.
    if (at < len(number)) call to_number(number(at + 1:), power, ok)
    if (ok) plain = number(:at - 1)//'e'//to_text(power + ten)
  end function shifted

  !> A unit in letters and figures alone: 'N·mm' and 'N mm' as Nmm, 'µm' as um, 'm^2' as m2.
  pure function spelt(unit) result(plain)
    character(len=*), intent(in) :: unit    !< as written
    character(len=:), allocatable :: plain
    integer :: at, i
    plain = ''
    at = 1
    do while (at <= len(unit))
      i = size(signs)
      do while (i > 0)
        if (unit(at:min(at + 1, len(unit))) == signs(i)) exit
        i = i - 1
      end do
      if (i > 0) then
        plain = plain//trim(letters(i))
        at = at + 2
        cycle
      end if
      if (scan(unit(at:at), ' ^') == 0) plain = plain//unit(at:at)
      at = at + 1
    end do
  end function spelt
end module hd_unit
