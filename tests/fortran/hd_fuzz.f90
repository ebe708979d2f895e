! SPDX-License-Identifier: GPL-3.0-or-later
!> Damaged input for one reader, many times in one process: hd_fuzz READER GOOD_FILE COUNT SEED SCRATCH_FILE, by tools/fuzz.py.
!>
!> A copy of the good file with one to four changes is written to the scratch file and read. A fault ends the process, and that
!> file holds what made it; a reader that takes longer than `patience` stops the program with the number of the copy.
program hd_fuzz
  use, intrinsic :: iso_fortran_env, only: error_unit
  use hd_cam_table, only: cam_table_t, read_cam_table
  use hd_clock, only: wall_seconds
  use hd_columns, only: columns_t, read_columns
  use hd_error, only: error_t, code_input, code_file, code_memory
  use hd_input, only: read_scene
  use hd_kinds, only: dp, i8
  use hd_npy, only: read_npy
  use hd_random, only: uniforms
  use hd_scene, only: scene_t
  use hd_sdf, only: read_sdf
  use hd_text, only: string_t, to_text
  implicit none
  real(dp), parameter :: patience = 20  ! [s]
  character(len=*), parameter :: odd(*) = [character(len=20) :: 'nan', '-1', '1e999', '2*5', '/', ',', ';', '''', &
    '99999999999999999999', char(0), char(255)//char(254), '&', '=', new_line('a'), '1+13', 'inf', '0', '1 2', '#', '!']
  character(len=1000) :: words(5)
  character(len=:), allocatable :: good, copy
  real(dp) :: start, u(16)
  integer :: k, count, seed, unit, refused, i
  logical :: fails
  do i = 1, size(words)
    call get_command_argument(i, words(i))
  end do
  read (words(3:4), *) count, seed
  call load(trim(words(2)), good)
  refused = 0
  do k = 1, count
    call uniforms(int(seed, i8), [(int(k, i8), i=1, size(u))], [(int(i, i8), i=1, size(u))], u)
    copy = good
    do i = 0, int(4*u(1))
      call change(copy, u(4*i + 1:4*i + 4))
    end do
    open (newunit=unit, file=trim(words(5)), access='stream', form='unformatted', status='replace')
    write (unit) copy
    close (unit)
    start = wall_seconds()
    call try(trim(words(1)), trim(words(5)), copy, fails)
    if (fails) refused = refused + 1
    if (wall_seconds() - start > patience) call quit('copy '//to_text(k)//' takes longer than 20 s')
  end do
  print '(a)', trim(words(1))//': '//to_text(count)//' copies, '//to_text(refused)//' refused'

contains

  subroutine load(path, text)
    character(len=*), intent(in) :: path
    character(len=:), allocatable, intent(out) :: text
    integer :: bytes
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read')
    inquire (unit=unit, size=bytes)
    allocate (character(len=bytes) :: text)
    read (unit) text
    close (unit)
  end subroutine load

  !> Turn a bit, cut, put in something odd, or double a piece.
  pure subroutine change(text, u)
    character(len=:), allocatable, intent(inout) :: text
    real(dp), intent(in) :: u(4)                          !< in [0, 1)
    integer, parameter :: pieces(*) = [1, 2, 9, 100]
    integer :: at, n
    at = 1 + int(u(1)*(len(text) + 1))
    n = min(pieces(1 + int(u(3)*size(pieces))), len(text) - at + 1)
    select case (int(4*u(2)))
    case (0)
      if (n > 0) text(at:at) = char(ieor(ichar(text(at:at)), 2**int(8*u(4))))
    case (1)
      text = text(:at - 1)//text(at + n:)
    case (2)
      text = text(:at - 1)//trim(odd(1 + int(u(4)*size(odd))))//text(at:)
    case default
      text = text(:at + n - 1)//text(at:)
    end select
  end subroutine change

  !> Read by one reader: it must answer, or refuse with a message and the code of an input.
  subroutine try(reader, path, text, fails)
    character(len=*), intent(in) :: reader, path, text
    logical, intent(out) :: fails
    type(error_t), allocatable :: error
    type(scene_t), target :: scene
    type(columns_t) :: columns
    type(cam_table_t) :: cam
    real(dp), allocatable :: heights(:, :)
    real(dp) :: dx, dy
    select case (reader)
    case ('namelist')
      call read_scene(path, [string_t ::], scene, error)
    case ('command line')
      call read_scene('', [string_t(text)], scene, error)
    case ('SDF')
      call read_sdf(path, heights, dx, dy, error)
    case ('npy')
      call read_npy(path, heights, error)
    case ('columns')
      call read_columns(path, columns, error)
    case ('cam')
      call read_cam_table(path, cam, error)
    case default
      call quit('no reader '//reader)
    end select
    fails = allocated(error)
    if (.not. fails) return
    if (all(error%code /= [code_input, code_file, code_memory])) call quit('code '//to_text(error%code)//': '//error%message)
    if (len_trim(error%message) == 0) call quit('code '//to_text(error%code)//' without a word')
  end subroutine try

  subroutine quit(why)
    character(len=*), intent(in) :: why
    write (error_unit, '(a)') 'hd_fuzz: '//why
    stop 1
  end subroutine quit
end program hd_fuzz
