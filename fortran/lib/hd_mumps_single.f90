! SPDX-License-Identifier: GPL-3.0-or-later
!> MUMPS in single precision: factors of half the size, good for six digits, for a caller that refines in double.
module hd_mumps_single
  use hd_kinds, only: dp, sp, i8
  use hd_error, only: error_t
  use hd_mumps, only: check_mumps, count_entries
  implicit none
  private
  public :: mumps_single_t

  include 'smumps_struc.h'

  type :: mumps_single_t
    private
    type(smumps_struc), pointer :: id => null()
    integer, public :: ordering_used = -1      !< INFOG(7): 1 is the ordering handed in
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
    associate (id => self%id)
      id%comm = 0
      id%sym = symmetry
      id%par = 1
      id%job = -1
      call smumps(id)
      self%version = id%version_number(:16)
      id%icntl(1:3) = -1
      id%icntl(4) = 0
      id%icntl(6) = 0
      id%icntl(7) = 1
      id%icntl(14) = 30
      id%n = n
      id%nnz = size(row, kind=i8)
      id%irn => row
      id%jcn => col
      allocate (id%perm_in(n))
      id%perm_in = position
      id%job = 1
      call smumps(id)
      call check_mumps(id%infog(:16), id%n, error)
      if (allocated(error)) return
      self%ordering_used = id%infog(7)
    end associate
  end subroutine analyse

  !> Factorise values, rounded; the working space grows and the step is repeated where MUMPS asks for it.
  subroutine factorise(self, value, error)
    class(mumps_single_t), intent(inout) :: self      !< analysed solver
    real(dp), intent(in) :: value(:)                  !< entries in the order of the pattern
    type(error_t), allocatable, intent(out) :: error  !< singular (a body is not held), out of memory
    real(sp), allocatable, target :: rounded(:)
    integer :: attempt
    rounded = real(value, sp)
    self%id%a => rounded
    do attempt = 1, 5
      self%id%job = 2
      call smumps(self%id)
      if (self%id%infog(1) /= -8 .and. self%id%infog(1) /= -9) exit
      self%id%icntl(14) = 2*self%id%icntl(14)
    end do
    nullify (self%id%a)
    call check_mumps(self%id%infog(:16), self%id%n, error)
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
    call smumps(self%id)
    nullify (self%id%rhs)
    call check_mumps(self%id%infog(:16), self%id%n, error)
    b = size_of_b*x
  end subroutine solve

  !> Give back all memory.
  subroutine release(self)
    class(mumps_single_t), intent(inout) :: self  !< solver
    if (.not. associated(self%id)) return
    nullify (self%id%irn, self%id%jcn)
    if (associated(self%id%perm_in)) deallocate (self%id%perm_in)
    nullify (self%id%perm_in)
    self%id%job = -2
    call smumps(self%id)
    deallocate (self%id)
  end subroutine release
end module hd_mumps_single
