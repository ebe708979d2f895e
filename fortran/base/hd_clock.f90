! SPDX-License-Identifier: GPL-3.0-or-later
!> Wall clock, date, and the memory the process has used.
module hd_clock
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  implicit none
  private
  public :: wall_seconds, timestamp, peak_memory_mb, machine_memory_mb

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

  !> Largest resident memory of this process so far, -1 where the system does not tell [MB].
  real(dp) function peak_memory_mb()
    peak_memory_mb = proc_entry('/proc/self/status', 'VmHWM:')
  end function peak_memory_mb

  !> Memory of the machine, -1 where the system does not tell [MB].
  real(dp) function machine_memory_mb()
    machine_memory_mb = proc_entry('/proc/meminfo', 'MemTotal:')
  end function machine_memory_mb

  !> An entry in kB of a /proc file, in MB; -1 if absent.
  real(dp) function proc_entry(file, key)
    character(len=*), intent(in) :: file  !< /proc file
    character(len=*), intent(in) :: key   !< first word of the line
    character(len=200) :: line
    integer :: unit, status
    proc_entry = -1
    open (newunit=unit, file=file, action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (index(line, key) /= 1) cycle
      read (line(len(key) + 1:), *, iostat=status) proc_entry
      if (status == 0) proc_entry = proc_entry/1024
      exit
    end do
    close (unit)
  end function proc_entry
end module hd_clock
