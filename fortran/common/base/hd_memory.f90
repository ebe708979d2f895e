! SPDX-License-Identifier: GPL-3.0-or-later
!> Memory that this process has taken, and may take; -1 where the system does not tell [MB].
module hd_memory
  use hd_kinds, only: dp, i8
  use hd_error, only: error_t, raise, code_memory
  use hd_text, only: to_text, to_number, next_word
  !$ use omp_lib, only: omp_get_max_threads
  implicit none
  private
  public :: peak_memory_mb, free_memory_mb, address_limit_mb, need_memory

  real(dp), parameter :: bytes_per_mb = 1048576
  !> Addresses that libraries and threads map without using them, least and per thread [MB]: with less OpenBLAS waits for ever.
  real(dp), parameter :: mapped = 100, mapped_per_thread = 200

contains

  !> Largest resident memory of this process so far [MB].
  real(dp) function peak_memory_mb()
    peak_memory_mb = number_behind('/proc/self/status', 'VmHWM:')/1024
  end function peak_memory_mb

  !> Memory for this process, with what it has already: what others leave of the machine, or less where a limit is set, as by a
  !> batch system, a container, ulimit -v or ulimit -d [MB].
  real(dp) function free_memory_mb() result(free)
    real(dp) :: limits(3)
    limits(1) = number_behind('/proc/meminfo', 'MemAvailable:')*1024
    if (limits(1) > 0) limits(1) = limits(1) + number_behind('/proc/self/status', 'VmRSS:')*1024
    limits(2) = group_limit()
    limits(3) = address_limit_mb()*bytes_per_mb
    free = -1
    if (any(limits > 0)) free = minval(limits, limits > 0)/bytes_per_mb
  end function free_memory_mb

  !> What ulimit -v or ulimit -d leaves of addresses, 1 at least [MB].
  real(dp) function address_limit_mb() result(left)
    real(dp) :: limits(2)
    integer :: threads
    limits(1) = number_behind('/proc/self/limits', 'Max address space')
    limits(2) = number_behind('/proc/self/limits', 'Max data size')
    threads = 1
    !$ threads = omp_get_max_threads()
    left = -1
    if (any(limits > 0)) left = max(1._dp, minval(limits, limits > 0)/bytes_per_mb - mapped - threads*mapped_per_thread)
  end function address_limit_mb

  !> Refuse what does not fit.
  subroutine need_memory(what, mb, error)
    character(len=*), intent(in) :: what              !< who needs it
    real(dp), intent(in) :: mb                        !< need [MB]
    type(error_t), allocatable, intent(out) :: error  !< more than is free
    real(dp) :: free
    free = free_memory_mb()
    if (free > 0 .and. mb > free) call raise(error, code_memory, what//': '//to_text(nint(mb, i8))//' MB are needed, '// &
      to_text(nint(free, i8))//' MB are free; make it smaller, or free memory')
  end subroutine need_memory

  !> Least limit of the control group of this process and of those around it, version 2 or 1; -1: none [bytes].
  real(dp) function group_limit() result(least)
    character(len=*), parameter :: mount = '/sys/fs/cgroup'
    character(len=1000) :: line
    integer :: unit, status, i
    least = -1
    open (newunit=unit, file='/proc/self/cgroup', action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      i = index(line, ':/')
      if (index(line, ':memory:') > 0) then
        call climb(mount//'/memory', trim(line(i + 1:)), '/memory.limit_in_bytes')
      else if (line(:3) == '0::') then
        call climb(mount, trim(line(i + 1:)), '/memory.max')
      end if
    end do
    close (unit)
  contains
    subroutine climb(root, path, file)
      character(len=*), intent(in) :: root, path, file
      real(dp) :: limit
      integer :: last
      last = len(path)
      do while (last > 0)
        limit = number_behind(root//path(:last)//file, '')
        if (limit > 0 .and. (least < 0 .or. limit < least)) least = limit
        last = index(path(:last), '/', back=.true.) - 1
      end do
      limit = number_behind(root//file, '')
      if (limit > 0 .and. (least < 0 .or. limit < least)) least = limit
    end subroutine climb
  end function group_limit

  !> The number behind the first words of a line; -1 if there is none.
  real(dp) function number_behind(file, words) result(number)
    character(len=*), intent(in) :: file   !< of the system
    character(len=*), intent(in) :: words  !< first words of the line
    character(len=200) :: line
    character(len=:), allocatable :: word
    integer :: unit, status, at
    logical :: ok
    number = -1
    open (newunit=unit, file=file, action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (index(line, words) /= 1) cycle
      at = len(words) + 1
      call next_word(line, at, word)
      call to_number(word, number, ok)
      if (.not. ok) number = -1
      exit
    end do
    close (unit)
  end function number_behind
end module hd_memory
