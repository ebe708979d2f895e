! SPDX-License-Identifier: GPL-3.0-or-later
!> Unstructured grids for ParaView: VTU with appended raw data, and the PVD list that ties steps together.
module hd_vtu
  use, intrinsic :: iso_fortran_env, only: int8, int64
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: rename_file
  use hd_text, only: to_text, exact
  implicit none
  private
  public :: field_t, write_vtu, write_pvd, read_pvd

  !> A named field on points or cells; `value` is (components, points or cells).
  type :: field_t
    character(len=:), allocatable :: name
    real(dp), allocatable :: value(:, :)
    logical :: on_cells = .false.
  end type field_t

contains

  !> Write one grid of cells of one type.
  subroutine write_vtu(path, points, cells, cell_type, fields, of_grid, error)
    character(len=*), intent(in) :: path              !< file
    real(dp), intent(in) :: points(:, :)              !< (3, points) [m]
    integer, intent(in) :: cells(:, :)                !< nodes from 1 (nodes, cells)
    integer, intent(in) :: cell_type                  !< VTK number: 9 quad, 12 hexahedron, 25 quadratic hexahedron
    type(field_t), intent(in) :: fields(:)            !< fields
    type(field_t), intent(in) :: of_grid(:)           !< numbers of the whole grid: value (1, 1)
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    integer(int64) :: offset
    integer :: unit, status, i
    character(len=1), parameter :: nl = new_line('a')
    open (newunit=unit, file=path//'.part', access='stream', form='unformatted', status='replace', action='write', iostat=status)
    if (status /= 0) then
      call raise(error, code_file, "cannot write '"//path//"'")
      return
    end if
    offset = 0
    call put('<?xml version="1.0"?>'//nl//'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '// &
      'header_type="UInt64">'//nl//'<UnstructuredGrid>'//nl//'<FieldData>'//nl)
    do i = 1, size(of_grid)
      call put('<DataArray type="Float64" Name="'//of_grid(i)%name//'" NumberOfTuples="1" format="ascii">'// &
        exact(of_grid(i)%value(1, 1))//'</DataArray>'//nl)
    end do
    call put('</FieldData>'//nl//'<Piece NumberOfPoints="'//to_text(size(points, 2))//'" NumberOfCells="'// &
      to_text(size(cells, 2))//'">'//nl//'<Points>'//nl)
    call declare('Points', 'Float64', 3, 8*size(points, kind=int64))
    call put('</Points>'//nl//'<Cells>'//nl)
    call declare('connectivity', 'Int64', 1, 8*size(cells, kind=int64))
    call declare('offsets', 'Int64', 1, 8*size(cells, 2, kind=int64))
    call declare('types', 'UInt8', 1, size(cells, 2, kind=int64))
    call put('</Cells>'//nl//'<PointData>'//nl)
    call declare_fields(.false.)
    call put('</PointData>'//nl//'<CellData>'//nl)
    call declare_fields(.true.)
    call put('</CellData>'//nl//'</Piece>'//nl//'</UnstructuredGrid>'//nl//'<AppendedData encoding="raw">'//nl//'_')
    if (status == 0) write (unit, iostat=status) 8*size(points, kind=int64), points
    if (status == 0) write (unit, iostat=status) 8*size(cells, kind=int64), int(cells - 1, int64)
    if (status == 0) write (unit, iostat=status) 8*size(cells, 2, kind=int64), &
      [(int(i, int64)*size(cells, 1), i=1, size(cells, 2))]
    if (status == 0) write (unit, iostat=status) size(cells, 2, kind=int64), &
      spread(int(cell_type, int8), 1, size(cells, 2))
    call append_fields(.false.)
    call append_fields(.true.)
    call put(nl//'</AppendedData>'//nl//'</VTKFile>'//nl)
    close (unit, iostat=i)
    if (status /= 0 .or. i /= 0) then
      call raise(error, code_file, "cannot write '"//path//"': is the disk full?")
      return
    end if
    call rename_file(path//'.part', path, error)
  contains
    subroutine put(text)
      character(len=*), intent(in) :: text
      if (status == 0) write (unit, iostat=status) text
    end subroutine put

    subroutine declare(name, kind, components, bytes)
      character(len=*), intent(in) :: name, kind
      integer, intent(in) :: components
      integer(int64), intent(in) :: bytes
      call put('<DataArray type="'//kind//'" Name="'//name//'" NumberOfComponents="'//to_text(components)// &
        '" format="appended" offset="'//to_text(offset)//'"/>'//nl)
      offset = offset + bytes + 8
    end subroutine declare

    subroutine declare_fields(on_cells)
      logical, intent(in) :: on_cells
      integer :: f
      do f = 1, size(fields)
        if (fields(f)%on_cells .neqv. on_cells) cycle
        call declare(fields(f)%name, 'Float64', size(fields(f)%value, 1), 8*size(fields(f)%value, kind=int64))
      end do
    end subroutine declare_fields

    subroutine append_fields(on_cells)
      logical, intent(in) :: on_cells
      integer :: f
      do f = 1, size(fields)
        if (fields(f)%on_cells .neqv. on_cells) cycle
        if (status == 0) write (unit, iostat=status) 8*size(fields(f)%value, kind=int64), fields(f)%value
      end do
    end subroutine append_fields
  end subroutine write_vtu

  !> List of time steps for ParaView.
  subroutine write_pvd(path, files, times, error)
    character(len=*), intent(in) :: path              !< file
    character(len=*), intent(in) :: files(:)          !< VTU files, relative to the list
    real(dp), intent(in) :: times(:)                  !< their times
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    integer :: unit, status, i
    open (newunit=unit, file=path//'.part', action='write', status='replace', iostat=status)
    if (status /= 0) then
      call raise(error, code_file, "cannot write '"//path//"'")
      return
    end if
    write (unit, '(a)') '<?xml version="1.0"?>', '<VTKFile type="Collection" version="1.0">', '<Collection>'
    do i = 1, size(files)
      write (unit, '(a)') '<DataSet timestep="'//exact(times(i))//'" part="0" file="'//trim(files(i))//'"/>'
    end do
    write (unit, '(a)') '</Collection>', '</VTKFile>'
    close (unit)
    call rename_file(path//'.part', path, error)
  end subroutine write_pvd

  !> Files and times of a list that was written here; none where there is no such list.
  subroutine read_pvd(path, files, times)
    character(len=*), intent(in) :: path                         !< file
    character(len=*), allocatable, intent(out) :: files(:)       !< VTU files, relative to the list
    real(dp), allocatable, intent(out) :: times(:)               !< their times
    character(len=200) :: line
    character(len=len(files)) :: name
    real(dp) :: time
    integer :: unit, status
    allocate (files(0), times(0))
    open (newunit=unit, file=path, action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (line(:9) /= '<DataSet ') cycle
      read (line(index(line, 'timestep="') + 10:), *, iostat=status) time
      if (status /= 0) exit
      name = line(index(line, 'file="') + 6:)
      files = [files, name(:index(name, '"') - 1)//repeat(' ', len(name) - index(name, '"') + 1)]
      times = [times, time]
    end do
    close (unit)
  end subroutine read_pvd
end module hd_vtu
