! SPDX-License-Identifier: GPL-3.0-or-later
!> Unstructured grids for ParaView: VTU with appended raw data, and the PVD list that ties steps together.
module hd_vtu
  use, intrinsic :: iso_fortran_env, only: int8, int64
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_new_file, only: new_file_t, write_text
  use hd_text, only: to_text, exact
  implicit none
  private
  public :: vtu_field_t, write_vtu, write_pvd

  !> A named field on points or cells; `value` is (components, points or cells).
  type :: vtu_field_t
    character(len=:), allocatable :: name
    real(dp), allocatable :: value(:, :)
    logical :: on_cells = .false.
  end type vtu_field_t

  !> A file being written: what was declared so far follows in the appended data.
  type, extends(new_file_t) :: open_file_t
    integer(int64) :: offset = 0
  end type open_file_t

  character(len=1), parameter :: nl = new_line('a')

contains

  !> Write one grid of cells of one type.
  subroutine write_vtu(path, points, cells, cell_type, fields, of_grid, error)
    character(len=*), intent(in) :: path              !< file
    real(dp), intent(in) :: points(:, :)              !< (3, points) [m]
    integer, intent(in) :: cells(:, :)                !< nodes from 1 (nodes, cells)
    integer, intent(in) :: cell_type                  !< VTK number: 9 quad, 12 hexahedron, 25 quadratic hexahedron
    type(vtu_field_t), intent(in) :: fields(:)            !< fields
    type(vtu_field_t), intent(in) :: of_grid(:)           !< numbers of the whole grid: value (1, 1)
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(open_file_t) :: file
    integer :: i
    call file%open(path, error)
    if (allocated(error)) return
    call file%put('<?xml version="1.0"?>'//nl//'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '// &
      'header_type="UInt64">'//nl//'<UnstructuredGrid>'//nl//'<FieldData>'//nl)
    do i = 1, size(of_grid)
      call file%put('<DataArray type="Float64" Name="'//of_grid(i)%name//'" NumberOfTuples="1" format="ascii">'// &
        exact(of_grid(i)%value(1, 1))//'</DataArray>'//nl)
    end do
    call file%put('</FieldData>'//nl//'<Piece NumberOfPoints="'//to_text(size(points, 2))//'" NumberOfCells="'// &
      to_text(size(cells, 2))//'">'//nl//'<Points>'//nl)
    call declare(file, 'Points', 'Float64', 3, 8*size(points, kind=int64))
    call file%put('</Points>'//nl//'<Cells>'//nl)
    call declare(file, 'connectivity', 'Int64', 1, 8*size(cells, kind=int64))
    call declare(file, 'offsets', 'Int64', 1, 8*size(cells, 2, kind=int64))
    call declare(file, 'types', 'UInt8', 1, size(cells, 2, kind=int64))
    call file%put('</Cells>'//nl//'<PointData>'//nl)
    call declare_fields(file, fields, .false.)
    call file%put('</PointData>'//nl//'<CellData>'//nl)
    call declare_fields(file, fields, .true.)
    call file%put('</CellData>'//nl//'</Piece>'//nl//'</UnstructuredGrid>'//nl//'<AppendedData encoding="raw">'//nl//'_')
    associate (unit => file%unit, status => file%status)
      if (status == 0) write (unit, iostat=status) 8*size(points, kind=int64), points
      if (status == 0) write (unit, iostat=status) 8*size(cells, kind=int64), int(cells - 1, int64)
      if (status == 0) write (unit, iostat=status) 8*size(cells, 2, kind=int64), &
        [(int(i, int64)*size(cells, 1), i=1, size(cells, 2))]
      if (status == 0) write (unit, iostat=status) size(cells, 2, kind=int64), &
        spread(int(cell_type, int8), 1, size(cells, 2))
    end associate
    call append_fields(file, fields, .false.)
    call append_fields(file, fields, .true.)
    call file%put(nl//'</AppendedData>'//nl//'</VTKFile>'//nl)
    call file%close(error)
  end subroutine write_vtu

  !> An array whose numbers follow.
  subroutine declare(file, name, kind, components, bytes)
    type(open_file_t), intent(inout) :: file    !< file
    character(len=*), intent(in) :: name, kind  !< of the array
    integer, intent(in) :: components           !< of a tuple
    integer(int64), intent(in) :: bytes         !< of the numbers
    call file%put('<DataArray type="'//kind//'" Name="'//name//'" NumberOfComponents="'//to_text(components)// &
      '" format="appended" offset="'//to_text(file%offset)//'"/>'//nl)
    file%offset = file%offset + bytes + 8
  end subroutine declare

  !> All fields on points or on cells.
  subroutine declare_fields(file, fields, on_cells)
    type(open_file_t), intent(inout) :: file    !< file
    type(vtu_field_t), intent(in) :: fields(:)      !< fields
    logical, intent(in) :: on_cells             !< which of them
    integer :: f
    do f = 1, size(fields)
      if (fields(f)%on_cells .neqv. on_cells) cycle
      call declare(file, fields(f)%name, 'Float64', size(fields(f)%value, 1), 8*size(fields(f)%value, kind=int64))
    end do
  end subroutine declare_fields

  !> Their numbers.
  subroutine append_fields(file, fields, on_cells)
    type(open_file_t), intent(inout) :: file    !< file
    type(vtu_field_t), intent(in) :: fields(:)      !< fields
    logical, intent(in) :: on_cells             !< which of them
    integer :: f
    do f = 1, size(fields)
      if (fields(f)%on_cells .neqv. on_cells) cycle
      if (file%status == 0) write (file%unit, iostat=file%status) 8*size(fields(f)%value, kind=int64), fields(f)%value
    end do
  end subroutine append_fields

  !> List of time steps for ParaView.
  subroutine write_pvd(path, files, times, error)
    character(len=*), intent(in) :: path              !< file
    character(len=*), intent(in) :: files(:)          !< VTU files, relative to the list
    real(dp), intent(in) :: times(:)                  !< their times
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    character(len=:), allocatable :: text
    integer :: i
    text = '<?xml version="1.0"?>'//nl//'<VTKFile type="Collection" version="1.0">'//nl//'<Collection>'//nl
    do i = 1, size(files)
      text = text//'<DataSet timestep="'//exact(times(i))//'" part="0" file="'//trim(files(i))//'"/>'//nl
    end do
    call write_text(path, text//'</Collection>'//nl//'</VTKFile>'//nl, error)
  end subroutine write_pvd
end module hd_vtu
