! SPDX-License-Identifier: GPL-3.0-or-later
!> Wall clock and date.
module hd_clock
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  implicit none
  private
  public :: wall_seconds, timestamp

contains

  !> Seconds since an arbitrary start.
  real(dp) function wall_seconds()
    integer(int64) :: now, rate
    call system_clock(now, rate)
    wall_seconds = real(now, dp)/rate
  end function wall_seconds

  !> Local date and time, ISO 8601.
  function timestamp() result(s)
    character(len=25) :: s
    character(len=8) :: d
    character(len=10) :: t
    character(len=5) :: z
    call date_and_time(d, t, z)
    s = d(1:4)//'-'//d(5:6)//'-'//d(7:8)//'T'//t(1:2)//':'//t(3:4)//':'//t(5:6)//z(1:3)//':'//z(4:5)
  end function timestamp
end module hd_clock
