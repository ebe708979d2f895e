module hd_text
  use hd_kinds, only: dp
  implicit none
  private
  public :: to_text
  interface to_text
    module procedure :: ti, tr
  end interface
contains
  pure function ti(i) result(s)
    integer, intent(in) :: i
    character(len=:), allocatable :: s
    character(len=20) :: b
    write (b, '(i0)') i
    s = trim(b)
  end function
  pure function tr(i) result(s)
    real(dp), intent(in) :: i
    character(len=:), allocatable :: s
    character(len=30) :: b
    write (b, '(g0.6)') i
    s = trim(b)
  end function
end module
