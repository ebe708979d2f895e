! SPDX-License-Identifier: GPL-3.0-or-later
!> Height maps in the surface data format of ISO 25178-71 (.sdf), binary and text: spacing and heights are in metres.
module hd_sdf
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use, intrinsic :: iso_fortran_env, only: int8, int16, int32, int64
  use hd_kinds, only: dp, sp
  use hd_error, only: error_t, raise, code_file
  use hd_text, only: to_text, lower
  implicit none
  private
  public :: read_sdf

  !> What the header says.
  type :: header_t
    integer :: nx = 0, ny = 0, kind = 0           !< points along a row, rows, code of the numbers
    real(dp) :: dx = 0, dy = 0, dz = 0            !< spacing, height of a step [m]
  end type header_t

  real(dp), parameter :: infinite = 1e30_dp     !< scale that is none [m]
  integer, parameter :: binary_header = 81        !< bytes

contains

  !> Read a map; points that were not measured are NaN.
  subroutine read_sdf(path, z, dx, dy, error)
    character(len=*), intent(in) :: path                !< file
    real(dp), allocatable, intent(out) :: z(:, :)       !< heights (nx, ny) [m]
    real(dp), intent(out) :: dx, dy                     !< spacing [m]
    type(error_t), allocatable, intent(out) :: error    !< missing, not this format
    character(len=:), allocatable :: text, why
    type(header_t) :: h
    integer :: unit, status, bytes
    dx = 0
    dy = 0
    open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status /= 0) then
      call raise(error, code_file, "cannot read '"//path//"'")
      return
    end if
    inquire (unit=unit, size=bytes)
    allocate (character(len=max(bytes, 8)) :: text)
    read (unit, iostat=status) text(:bytes)
    close (unit)
    why = ''
    if (status /= 0 .or. bytes < 8) then
      why = 'it is too short'
    else if (text(:8) == 'bISO-1.0') then
      call read_binary(text, h, z, why)
    else if (text(:8) == 'aISO-1.0') then
      call read_lines(text, h, z, why)
    else
      why = "it starts with neither 'bISO-1.0' nor 'aISO-1.0'"
    end if
    if (len(why) > 0) then
      call raise(error, code_file, "'"//path//"' is no surface data file (ISO 25178-71): "//why)
      return
    end if
    dx = h%dx
    dy = h%dy
  end subroutine read_sdf

  !> Sizes and scales that make sense.
  pure function fault_of(h) result(why)
    type(header_t), intent(in) :: h       !< header
    character(len=:), allocatable :: why  !< '' if there is none
    why = ''
    if (h%nx < 1 .or. h%ny < 1) then
      why = 'it has '//to_text(h%nx)//' x '//to_text(h%ny)//' points'
    else if (.not. (h%dx > 0 .and. h%dz > 0 .and. (h%dy > 0 .or. h%ny == 1) .and. max(h%dx, h%dy, h%dz) < infinite)) then
      why = 'its scales are '//to_text(h%dx)//', '//to_text(h%dy)//', '//to_text(h%dz)//' m'
    end if
  end function fault_of

  !> Binary form, little-endian.
  subroutine read_binary(text, h, z, why)
    character(len=*), intent(in) :: text              !< whole file
    type(header_t), intent(out) :: h                  !< header
    real(dp), allocatable, intent(out) :: z(:, :)     !< heights [m]
    character(len=:), allocatable, intent(out) :: why !< what is wrong, '' if nothing
    integer, parameter :: bytes(0:7) = [1, 2, 4, 4, 1, 2, 4, 8]
    real(dp), parameter :: invalid(0:7) = [255._dp, 65535._dp, 4294967295._dp, 0._dp, 0._dp, -32768._dp, -2147483648._dp, 0._dp]
    integer(int16) :: extent(2)
    real(dp) :: scale(4), hole
    integer(int8) :: code(3)
    integer(int64) :: n
    why = 'its header is cut off'
    if (len(text) < binary_header) return
    extent = transfer(text(43:46), extent)
    scale = transfer(text(47:78), scale)
    code = transfer(text(79:81), code)
    h = header_t(iand(int(extent(1)), 65535), iand(int(extent(2)), 65535), code(2), scale(1), scale(2), scale(3))
    why = fault_of(h)
    if (len(why) > 0) return
    n = int(h%nx, int64) * h%ny
    if (code(1) /= 0 .or. h%kind < 0 .or. h%kind > 7) then
      why = 'compressed heights or numbers of kind '//to_text(h%kind)//'; 0 to 7 are read'
    else if (len(text) < binary_header + n * bytes(h%kind)) then
      why = 'heights of '//to_text(h%nx)//' x '//to_text(h%ny)//' points are cut off'
    end if
    if (len(why) > 0) return
    hole = ieee_value(hole, ieee_quiet_nan)
    associate (body => text(binary_header + 1:binary_header + n * bytes(h%kind)))
      select case (h%kind)
      case (0, 4)
        z = reshape(real(transfer(body, [0_int8]), dp), [h%nx, h%ny])
      case (1)
        z = reshape(real(transfer(body, [0_int16]), dp), [h%nx, h%ny])
      case (2)
        z = reshape(real(transfer(body, [0_int32]), dp), [h%nx, h%ny])
      case (3)
        z = reshape(real(transfer(body, [0._sp]), dp), [h%nx, h%ny])
      case (5)
        z = reshape(real(transfer(body, [0_int16]), dp), [h%nx, h%ny])
      case (6)
        z = reshape(real(transfer(body, [0_int32]), dp), [h%nx, h%ny])
      case (7)
        z = reshape(transfer(body, [0._dp]), [h%nx, h%ny])
      end select
    end associate
    if (h%kind < 3) then                                ! unsigned: what reads as negative is above half the range
      where (z < 0) z = z + (invalid(h%kind) + 1)
    end if
    if (any(h%kind == [1, 2, 5, 6])) then               ! whole numbers of 16 and 32 bits mark holes, those of 8 do not
      where (z == invalid(h%kind)) z = hole
    end if
    z = z * h%dz
  end subroutine read_binary

  !> Text form: lines 'key = value' up to a star, then numbers or BAD up to a star.
  subroutine read_lines(text, h, z, why)
    character(len=*), intent(in) :: text              !< whole file
    type(header_t), intent(out) :: h                  !< header
    real(dp), allocatable, intent(out) :: z(:, :)     !< heights [m]
    character(len=:), allocatable, intent(out) :: why !< what is wrong, '' if nothing
    character(len=:), allocatable :: word
    integer :: at, next, equal, status, i, j
    at = 1
    status = 0
    do while (at <= len(text) .and. status == 0)
      next = at + index(text(at:)//new_line('a'), new_line('a')) - 1
      associate (line => text(at:next - 1))
        at = next + 1
        if (index(adjustl(line), '*') == 1) exit
        equal = index(line, '=')
        if (equal == 0) cycle
        select case (lower(trim(adjustl(line(:equal - 1)))))
        case ('numpoints'); read (line(equal + 1:), *, iostat=status) h%nx
        case ('numprofiles'); read (line(equal + 1:), *, iostat=status) h%ny
        case ('xscale'); read (line(equal + 1:), *, iostat=status) h%dx
        case ('yscale'); read (line(equal + 1:), *, iostat=status) h%dy
        case ('zscale'); read (line(equal + 1:), *, iostat=status) h%dz
        end select
      end associate
    end do
    why = fault_of(h)
    if (status /= 0) why = 'a number of its header cannot be read'
    if (len(why) > 0) return
    allocate (z(h%nx, h%ny))
    do j = 1, h%ny
      do i = 1, h%nx
        call next_word(text, at, word)
        if (lower(word) == 'bad') then
          z(i, j) = ieee_value(z(i, j), ieee_quiet_nan)
        else
          read (word, *, iostat=status) z(i, j)
          if (status /= 0 .or. len(word) == 0 .or. word == '*') then
            why = 'height '//to_text(i)//' of row '//to_text(j)//" is '"//word//"'"
            return
          end if
        end if
      end do
    end do
    z = z * h%dz
  end subroutine read_lines

  !> Next word of a text.
  pure subroutine next_word(text, at, word)
    character(len=*), intent(in) :: text                  !< text
    integer, intent(inout) :: at                          !< where to look, then behind the word
    character(len=:), allocatable, intent(out) :: word    !< '' at the end
    integer :: first
    do while (at <= len(text))
      if (iachar(text(at:at)) > 32) exit
      at = at + 1
    end do
    first = at
    do while (at <= len(text))
      if (iachar(text(at:at)) <= 32) exit
      at = at + 1
    end do
    word = text(first:at - 1)
  end subroutine next_word
end module hd_sdf
