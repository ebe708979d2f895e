! SPDX-License-Identifier: GPL-3.0-or-later
!> Height maps in the surface data format of ISO 25178-71 (.sdf), binary and text: spacing and heights are in metres.
module hd_sdf
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use, intrinsic :: iso_fortran_env, only: int8, int16, int32, int64
  use hd_kinds, only: dp, sp
  use hd_error, only: error_t, raise, code_file
  use hd_input_file, only: open_input, read_text, next_line, line_count
  use hd_text, only: to_text, to_number, lower, next_word, printable
  implicit none
  private
  public :: read_sdf

  !> What the header says.
  type :: header_t
    integer(int64) :: nx = 0, ny = 0              !< points along a row, rows
    integer :: kind = 0                           !< code of the numbers
    real(dp) :: dx = 0, dy = 0, dz = 0            !< spacing, height of a step [m]
  end type header_t

  real(dp), parameter :: infinite = 1e30_dp     !< scale that is none [m]
  integer, parameter :: binary_header = 81        !< bytes

contains

  !> Read a map; points that were not measured are NaN. Files of EUNA 15178 (BCR) have the same form under another first word.
  subroutine read_sdf(path, z, dx, dy, error)
    character(len=*), intent(in) :: path                !< file
    real(dp), allocatable, intent(out) :: z(:, :)       !< heights (nx, ny) [m]
    real(dp), intent(out) :: dx, dy                     !< spacing [m]
    type(error_t), allocatable, intent(out) :: error    !< missing, not this format
    character(len=:), allocatable :: text, why
    character(len=8) :: version
    type(header_t) :: h
    integer :: unit, status
    integer(int64) :: bytes
    logical :: binary
    dx = 0
    dy = 0
    call open_input(path, unit, bytes, error)
    if (allocated(error)) return
    version = ''
    why = ''
    read (unit, iostat=status) version
    binary = version == 'bISO-1.0' .or. version == 'bBCR-1.0'
    if (binary) call read_binary(unit, bytes, h, z, why)
    close (unit)
    if (version == 'aISO-1.0' .or. version == 'aBCR-1.0') then
      call read_text(path, text, error)
      if (.not. allocated(error)) call read_lines(text, h, z, why)
    else if (status /= 0) then
      why = 'it is too short'
    else if (.not. binary) then
      why = "its version is '"//printable(version)//"'; valid: bISO-1.0, aISO-1.0, bBCR-1.0, aBCR-1.0"
    end if
    if (allocated(error)) return
    if (len(why) > 0) then
      call raise(error, code_file, "'"//path//"' is no surface data file (ISO 25178-71): "//why)
      return
    end if
    dx = h%dx
    dy = h%dy
  end subroutine read_sdf

  !> Sizes and scales that make sense, and points for which the file has room.
  pure function fault_of(h, room) result(why)
    type(header_t), intent(in) :: h       !< header
    integer(int64), intent(in) :: room    !< points that the file holds at most
    character(len=:), allocatable :: why  !< '' if there is none
    why = ''
    if (h%nx < 1 .or. h%ny < 1) then
      why = 'it has '//to_text(h%nx)//' x '//to_text(h%ny)//' points'
    else if (.not. (h%dx > 0 .and. h%dz > 0 .and. (h%dy > 0 .or. h%ny == 1) .and. max(h%dx, h%dy, h%dz) < infinite)) then
      why = 'its scales are '//to_text(h%dx)//', '//to_text(h%dy)//', '//to_text(h%dz)//' m'
    else if (max(h%nx, h%ny) > huge(1) .or. h%ny > room/h%nx) then
      why = 'heights of '//to_text(h%nx)//' x '//to_text(h%ny)//' points are cut off: the file holds '//to_text(room)//' at most'
    end if
  end function fault_of

  !> Binary form, little-endian.
  subroutine read_binary(unit, size_of_file, h, z, why)
    integer, intent(in) :: unit                       !< stream behind the version
    integer(int64), intent(in) :: size_of_file        !< bytes
    type(header_t), intent(out) :: h                  !< header
    real(dp), allocatable, intent(out) :: z(:, :)     !< heights [m]
    character(len=:), allocatable, intent(out) :: why !< what is wrong, '' if nothing
    integer, parameter :: bytes(0:7) = [1, 2, 4, 4, 1, 2, 4, 8]
    real(dp), parameter :: invalid(0:7) = [255._dp, 65535._dp, 4294967295._dp, 0._dp, 0._dp, -32768._dp, -2147483648._dp, 0._dp]
    character(len=34) :: maker
    integer(int16) :: extent(2)
    real(dp) :: scale(4)
    integer(int8) :: code(3)
    integer(int8), allocatable :: z_1(:, :)
    integer(int16), allocatable :: z_2(:, :)
    integer(int32), allocatable :: z_4(:, :)
    real(sp), allocatable :: z_sp(:, :)
    integer :: status
    why = 'its header is cut off'
    read (unit, iostat=status) maker, extent, scale, code
    if (status /= 0) return
    h = header_t(iand(int(extent(1), int64), 65535_int64), iand(int(extent(2), int64), 65535_int64), int(code(2)), &
      scale(1), scale(2), scale(3))
    if (code(1) /= 0 .or. h%kind < 0 .or. h%kind > 7) then
      why = 'compressed heights or numbers of kind '//to_text(h%kind)//'; 0 to 7 are read'
    else
      why = fault_of(h, (size_of_file - binary_header)/bytes(h%kind))
    end if
    if (len(why) > 0) return
    allocate (z(h%nx, h%ny), stat=status)
    if (status == 0) then
      select case (h%kind)
      case (0, 4)
        allocate (z_1(h%nx, h%ny), stat=status)
        if (status == 0) read (unit, iostat=status) z_1
        if (status == 0) z = z_1
      case (1, 5)
        allocate (z_2(h%nx, h%ny), stat=status)
        if (status == 0) read (unit, iostat=status) z_2
        if (status == 0) z = z_2
      case (2, 6)
        allocate (z_4(h%nx, h%ny), stat=status)
        if (status == 0) read (unit, iostat=status) z_4
        if (status == 0) z = z_4
      case (3)
        allocate (z_sp(h%nx, h%ny), stat=status)
        if (status == 0) read (unit, iostat=status) z_sp
        if (status == 0) z = z_sp
      case (7)
        read (unit, iostat=status) z
      end select
    end if
    if (status /= 0) then
      why = 'its '//to_text(h%nx)//' x '//to_text(h%ny)//' heights cannot be read, or find no memory'
      return
    end if
    if (h%kind < 3) then                                ! unsigned: what reads as negative is above half the range
      where (z < 0) z = z + (invalid(h%kind) + 1)
    end if
    if (any(h%kind == [1, 2, 5, 6])) then               ! whole numbers of 16 and 32 bits mark holes, those of 8 do not
      where (z == invalid(h%kind)) z = ieee_value(1._dp, ieee_quiet_nan)
    end if
    z = z * h%dz
  end subroutine read_binary

  !> Text form: lines 'key = value' up to a star, then numbers, or BAD or NaN for holes, up to a star.
  subroutine read_lines(text, h, z, why)
    character(len=*), intent(in) :: text              !< whole file
    type(header_t), intent(out) :: h                  !< header
    real(dp), allocatable, intent(out) :: z(:, :)     !< heights [m]
    character(len=:), allocatable, intent(out) :: why !< what is wrong, '' if nothing
    character(len=:), allocatable :: line, word, key, known
    integer :: at, equal, i, j, number
    logical :: ok
    at = 1
    number = 0
    known = ' '
    do while (at <= len(text))
      call next_line(text, at, line)
      number = number + 1
      if (index(adjustl(line), '*') == 1) exit
      equal = index(line, '=')
      if (equal == 0) cycle
      word = trim(adjustl(line(equal + 1:)))
      key = lower(trim(adjustl(line(:equal - 1))))
      select case (key)
      case ('numpoints'); call to_number(word, h%nx, ok)
      case ('numprofiles'); call to_number(word, h%ny, ok)
      case ('xscale'); call to_number(word, h%dx, ok)
      case ('yscale'); call to_number(word, h%dy, ok)
      case ('zscale'); call to_number(word, h%dz, ok)
      case default; cycle
      end select
      why = ''
      if (.not. ok) why = " is '"//printable(word)//"'; valid: a number"
      if (index(known, ' '//key//' ') > 0) why = ' stands twice; keep one'
      if (len(why) > 0) then
        why = 'line '//to_text(number)//': '//trim(adjustl(line(:equal - 1)))//why
        return
      end if
      known = known//key//' '
    end do
    why = fault_of(h, (len(text, int64) - at + 2)/2)     ! a digit and a blank each
    if (len(why) > 0) return
    allocate (z(h%nx, h%ny))
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        call next_word(text, at, word)
        call to_number(word, z(i, j), ok)
        if (ok) cycle
        z(i, j) = ieee_value(z(i, j), ieee_quiet_nan)
        if (lower(word) == 'bad' .or. lower(word) == 'nan') cycle
        why = 'height '//to_text(i)//' of row '//to_text(j)//" is '"//printable(word)//"'"//line_of(text, at)// &
          '; valid: a number, BAD'
        return
      end do
    end do
    call next_word(text, at, word)
    if (len(word) > 0 .and. index(word, '*') /= 1) then
      why = "'"//printable(word)//"' stands behind its "//to_text(h%nx)//' x '//to_text(h%ny)//' heights'// &
        line_of(text, at)//'; valid: *'
      return
    end if
    z = z * h%dz
  end subroutine read_lines

  !> Number of the line in which a place lies, in words.
  pure function line_of(text, at) result(words)
    character(len=*), intent(in) :: text  !< text
    integer, intent(in) :: at             !< place
    character(len=:), allocatable :: words
    words = ' in line '//to_text(line_count(text(:min(at - 1, len(text)))))
  end function line_of
end module hd_sdf
