! SPDX-License-Identifier: GPL-3.0-or-later
!> Arrays in numpy's format .npy, version 1.
module hd_npy
  use hd_kinds, only: dp, sp
  use hd_error, only: error_t, raise, code_file
  use hd_text, only: to_text
  implicit none
  private
  public :: write_npy

  interface write_npy
    procedure :: write_double, write_single
  end interface write_npy

contains

  !> Array a(nx, ny) as shape (ny, nx) in C order.
  subroutine write_double(path, a, error)
    character(len=*), intent(in) :: path              !< file
    real(dp), intent(in), contiguous :: a(:, :)       !< array
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    integer :: unit, status
    open (newunit=unit, file=path, access='stream', form='unformatted', action='write', status='replace', iostat=status)
    if (status == 0) write (unit, iostat=status) header('<f8', shape(a)), a
    if (status == 0) close (unit, iostat=status)
    if (status /= 0) call raise(error, code_file, "cannot write '"//path//"'")
  end subroutine write_double

  !> The same in single precision.
  subroutine write_single(path, a, error)
    character(len=*), intent(in) :: path              !< file
    real(sp), intent(in), contiguous :: a(:, :)       !< array
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    integer :: unit, status
    open (newunit=unit, file=path, access='stream', form='unformatted', action='write', status='replace', iostat=status)
    if (status == 0) write (unit, iostat=status) header('<f4', shape(a)), a
    if (status == 0) close (unit, iostat=status)
    if (status /= 0) call raise(error, code_file, "cannot write '"//path//"'")
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
end module hd_npy
