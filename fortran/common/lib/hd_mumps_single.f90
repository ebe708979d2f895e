! SPDX-License-Identifier: GPL-3.0-or-later
!> MUMPS in single precision: factors of half the size, good for six digits, for a caller that refines in double.
module hd_mumps_single
  use hd_kinds, only: dp, sp, i8
  use hd_system, only: check_stop
  use hd_error, only: error_t
  use hd_mumps, only: check_mumps, count_entries, ordering_name
  use hd_mumps_struc, only: struc_t => smumps_struc, run_mumps => smumps
  implicit none
  private
  public :: mumps_single_t

  type :: mumps_single_t
    private
    type(struc_t), pointer :: id => null()
    character(len=:), allocatable, public :: ordering_used   !< MUMPS's own answer
    integer(i8), public :: factor_entries = 0  !< entries of the factors
    real(dp), public :: flops = 0              !< operations of a factorisation
    character(len=16), public :: version = ''  !< of the library
  contains
    procedure :: analyse
    procedure :: factorise
    procedure :: solve
    procedure :: release
  end type mumps_single_t

contains

  !> Analyse a pattern; keep `row` and `col` alive.
  subroutine analyse(self, symmetry, n, row, col, position, error)
    class(mumps_single_t), intent(inout) :: self      !< solver
    integer, intent(in) :: symmetry                   !< as in hd_mumps
    integer, intent(in) :: n                          !< unknowns
    integer, intent(in), target :: row(:), col(:)     !< coordinates from 1
    integer, intent(in) :: position(:)                !< place of each unknown in the elimination order
    type(error_t), allocatable, intent(out) :: error  !< out of memory, wrong pattern
    call self%release()
    allocate (self%id)
    call open_mumps(self%id, symmetry, n, row, col, position)
    self%version = self%id%version_number(:16)
    self%id%job = 1
    call run_mumps(self%id)
    call check_mumps(self%id%infog(:16), self%id%n, error)
    if (.not. allocated(error)) self%ordering_used = ordering_name(self%id%infog(7), self%id%infog(32))
  end subroutine analyse

  !> Factorise values, rounded.
  subroutine factorise(self, value, error)
    class(mumps_single_t), intent(inout) :: self      !< analysed solver
    real(dp), intent(in) :: value(:)                  !< entries in the order of the pattern
    type(error_t), allocatable, intent(out) :: error  !< singular (a body is not held), out of memory
    real(sp), allocatable, target :: rounded(:)
    rounded = real(value, sp)
    self%id%a => rounded
    call factorise_mumps(self%id, error)
    nullify (self%id%a)
    if (allocated(error)) return
    self%factor_entries = count_entries(self%id%infog(29))
    self%flops = real(self%id%rinfog(3), dp)
  end subroutine factorise

  !> Solve in place; scaled so that no size under- or overflows.
  subroutine solve(self, b, error)
    class(mumps_single_t), intent(inout) :: self      !< factorised solver
    real(dp), intent(inout) :: b(:)                   !< right-hand side, then solution
    type(error_t), allocatable, intent(out) :: error  !< MUMPS failure
    real(sp), target :: x(size(b))
    real(dp) :: size_of_b
    size_of_b = maxval(abs(b))
    if (.not. size_of_b > 0) return
    x = real(b/size_of_b, sp)
    self%id%nrhs = 1
    self%id%lrhs = size(x)
    self%id%rhs => x
    self%id%job = 3
    call run_mumps(self%id)
    nullify (self%id%rhs)
    call check_mumps(self%id%infog(:16), self%id%n, error)
    b = size_of_b*x
  end subroutine solve

  !> Give back all memory.
  subroutine release(self)
    class(mumps_single_t), intent(inout) :: self  !< solver
    call close_mumps(self%id)
  end subroutine release

  include 'hd_mumps.inc'
end module hd_mumps_single
