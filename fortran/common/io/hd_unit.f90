! SPDX-License-Identifier: GPL-3.0-or-later
!> Values that are written with a unit, as '0.36 mm' for a key in m.
module hd_unit
  use hd_text, only: unquoted
  implicit none
  private
  public :: in_unit

  !> A unit that a value may be written in: times a power of ten the key's own.
  type :: unit_t
    character(len=3) :: written, of
    character(len=3) :: exponent
  end type unit_t
  type(unit_t), parameter :: units(*) = [ &
    unit_t('mm', 'm', 'e-3'), unit_t('um', 'm', 'e-6'), unit_t('µm', 'm', 'e-6'), unit_t('nm', 'm', 'e-9'), &
    unit_t('kPa', 'Pa', 'e3'), unit_t('MPa', 'Pa', 'e6'), unit_t('GPa', 'Pa', 'e9')]

contains

  !> A word as a number in the key's unit: '0.36 mm' becomes 0.36e-3, the same bits; one without a unit that is known stays.
  pure function in_unit(word, unit) result(plain)
    character(len=*), intent(in) :: word    !< as in the file
    character(len=*), intent(in) :: unit    !< of the key
    character(len=:), allocatable :: plain
    character(len=:), allocatable :: number, written
    integer :: blank, i
    plain = word
    number = trim(adjustl(unquoted(word)))
    blank = index(number, ' ')
    if (blank == 0 .or. len(unit) == 0) return
    written = trim(adjustl(number(blank:)))
    number = number(:blank - 1)
    if (written == unit) plain = number
    if (scan(number, 'eEdD*') > 0) return   ! it has an exponent of its own
    do i = 1, size(units)
      if (units(i)%of == unit .and. units(i)%written == written) plain = number//trim(units(i)%exponent)
    end do
  end function in_unit
end module hd_unit
