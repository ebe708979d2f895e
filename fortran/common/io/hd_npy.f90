! SPDX-License-Identifier: GPL-3.0-or-later
!> Arrays in numpy's format .npy, version 1.
module hd_npy
  use hd_kinds, only: dp, sp
  use hd_error, only: error_t, raise, code_file
  use hd_new_file, only: new_file_t
  use hd_text, only: to_text
  implicit none
  private
  public :: write_npy, read_npy

  interface write_npy
    procedure :: write_double, write_single
  end interface write_npy

contains

  !> Array a(nx, ny) as shape (ny, nx) in C order.
  subroutine write_double(path, a, error)
    character(len=*), intent(in) :: path              !< file
    real(dp), intent(in), contiguous :: a(:, :)       !< array
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(new_file_t) :: file
    call file%open(path, error)
    if (allocated(error)) return
    write (file%unit, iostat=file%status) header('<f8', shape(a)), a
    call file%close(error)
  end subroutine write_double

  !> The same in single precision.
  subroutine write_single(path, a, error)
    character(len=*), intent(in) :: path              !< file
    real(sp), intent(in), contiguous :: a(:, :)       !< array
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(new_file_t) :: file
    call file%open(path, error)
    if (allocated(error)) return
    write (file%unit, iostat=file%status) header('<f4', shape(a)), a
    call file%close(error)
  end subroutine write_single

  !> Magic string, version, length and a dictionary, filled up to a multiple of 64 bytes.
  pure function header(kind_name, extent) result(text)
    character(len=*), intent(in) :: kind_name         !< '<f8' or '<f4'
    integer, intent(in) :: extent(2)                  !< nx, ny
    character(len=:), allocatable :: text, words
    integer :: n
    words = "{'descr': '"//kind_name//"', 'fortran_order': False, 'shape': ("//to_text(extent(2))//', '//to_text(extent(1))//'), }'
    n = 64 * ((10 + len(words) + 1 + 63) / 64) - 10
    text = char(147)//'NUMPY'//char(1)//char(0)//char(mod(n, 256))//char(n / 256)//words// &
      repeat(' ', n - len(words) - 1)//new_line('a')
  end function header

  !> Map of 4 or 8 byte reals, shape (rows, points) or (points).
  subroutine read_npy(path, a, error)
    character(len=*), intent(in) :: path                !< file
    real(dp), allocatable, intent(out) :: a(:, :)       !< array (points, rows)
    type(error_t), allocatable, intent(out) :: error    !< missing, not this format
    character(len=10) :: head
    character(len=:), allocatable :: words, list
    real(sp), allocatable :: a_4(:, :)
    integer :: unit, status, n, extent(2), at, i
    logical :: double, single, swapped
    open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status /= 0) then
      call raise(error, code_file, "cannot read '"//path//"'")
      return
    end if
    head = ''
    read (unit, iostat=status) head
    n = ichar(head(9:9)) + 256 * ichar(head(10:10))
    if (status == 0 .and. head(2:7) /= 'NUMPY'//char(1)) status = 1
    allocate (character(len=merge(n, 0, status == 0)) :: words)
    if (status == 0) read (unit, iostat=status) words
    double = index(words, '<f8') > 0
    single = index(words, '<f4') > 0
    swapped = index(words, "'fortran_order': True") > 0
    at = index(words, 'shape')
    extent = 1
    if (status == 0) then
      list = words(at + index(words(at:), '('):at + index(words(at:), ')') - 2)
      if (count([(list(i:i) == ',', i=1, len_trim(list) - 1)]) > 1) then
        call raise(error, code_file, "'"//path//"' has shape ("//list//'): heights are rows x points, or one row of points')
        close (unit)
        return
      end if
      if (index(list, ',') == len_trim(list)) then
        read (list, *, iostat=status) extent(2)
      else
        read (list, *, iostat=status) extent
      end if
    end if
    if (status == 0 .and. (.not. (double .or. single) .or. any(extent < 1))) status = 1
    if (status == 0) then
      if (swapped .and. minval(extent) > 1) extent = extent([2, 1])
      allocate (a(extent(2), extent(1)))
      if (double) then
        read (unit, iostat=status) a
      else
        allocate (a_4(extent(2), extent(1)))
        read (unit, iostat=status) a_4
        a = a_4
      end if
      if (swapped .and. minval(extent) > 1) a = transpose(a)
    end if
    close (unit)
    if (status /= 0) call raise(error, code_file, "'"//path//"' is no array of heights: .npy with 4 or 8 byte reals, rows x points")
  end subroutine read_npy
end module hd_npy
