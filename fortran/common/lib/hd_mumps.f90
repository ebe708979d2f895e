! SPDX-License-Identifier: GPL-3.0-or-later
!> Sparse direct solution of A x = b (Amestoy, Duff, L'Excellent and Koster 2001) by the sequential library MUMPS.
!>
!> The pattern is analysed once, with an ordering of the caller's; values are factorised as often as they change.
module hd_mumps
  use hd_kinds, only: dp, i8
  use hd_lapack, only: blas_threads
  use hd_mumps_struc, only: dmumps_struc, dmumps
  use hd_system, only: check_stop
  use hd_error, only: error_t, raise, code_linear_solver, code_memory, code_internal
  use hd_text, only: to_text
  implicit none
  private
  public :: mumps_t, unsymmetric, positive_definite, check_mumps, ordering_given

  integer, parameter :: too_little(2) = [-8, -9]  !< INFOG(1): integer and main working space do not suffice
  real(dp), parameter :: worth_threads = 2e10_dp  !< operations below which two threads of BLAS wait for each other longer than
                                                  !< they compute, by measured factorisations of 5e7 to 2.5e10
  integer, parameter :: unsymmetric = 0        !< MUMPS SYM
  integer, parameter :: positive_definite = 1  !< MUMPS SYM

  character(len=15), parameter :: ordering_given = 'METIS (PERM_IN)'  !< what callers hand in

  type :: mumps_t
    private
    type(dmumps_struc), pointer :: id => null()
    character(len=:), allocatable, public :: ordering_used   !< MUMPS's own answer
    integer(i8), public :: factor_entries = 0  !< entries of the factors
    real(dp), public :: flops = 0              !< operations of a factorisation
    character(len=16), public :: version = ''  !< of the library
  contains
    procedure :: analyse
    procedure :: factorise
    procedure :: solve
    procedure :: release
  end type mumps_t

contains

  !> Analyse a pattern; keep `row`, `col` and `value` alive: MUMPS reads the values at every factorisation.
  subroutine analyse(self, symmetry, n, row, col, value, position, error)
    class(mumps_t), intent(inout) :: self             !< solver
    integer, intent(in) :: symmetry                   !< unsymmetric, or positive_definite (one triangle given)
    integer, intent(in) :: n                          !< unknowns
    integer, intent(in), target :: row(:), col(:)     !< coordinates from 1
    real(dp), intent(in), target :: value(:)          !< values
    integer, intent(in) :: position(:)                !< place of each unknown in the elimination order
    type(error_t), allocatable, intent(out) :: error  !< out of memory, wrong pattern
    call self%release()
    allocate (self%id)
    call open_mumps(self%id, symmetry, n, row, col, position)
    associate (id => self%id)
      self%version = id%version_number(:16)
      id%a => value
      id%job = 1
      call dmumps(id)
      call check_mumps(id%infog(:16), id%n, error)
      if (allocated(error)) return
      self%ordering_used = ordering_name(id%infog(7), id%infog(32))
    end associate
  end subroutine analyse

  !> Factorise the present values; the working space grows and the step is repeated where MUMPS asks for it.
  subroutine factorise(self, error)
    class(mumps_t), intent(inout) :: self             !< analysed solver
    type(error_t), allocatable, intent(out) :: error  !< singular (a body is not held), out of memory
    integer :: attempt
    call check_stop(error)
    if (allocated(error)) return
    do attempt = 1, 5
      self%id%job = 2
      call compute(self%id, self%id%rinfog(1))
      if (all(self%id%infog(1) /= too_little)) exit
      self%id%icntl(14) = 2*self%id%icntl(14)
    end do
    call check_mumps(self%id%infog(:16), self%id%n, error)
    if (allocated(error)) return
    self%factor_entries = count_entries(self%id%infog(29))
    self%flops = self%id%rinfog(3)
  end subroutine factorise

  !> The job of MUMPS, on one thread of BLAS where it is small.
  subroutine compute(id, operations)
    type(dmumps_struc), intent(inout) :: id  !< with its job
    real(dp), intent(in) :: operations       !< of that job
    integer :: threads
    if (operations < worth_threads) threads = blas_threads(1)
    call dmumps(id)
    if (operations < worth_threads) threads = blas_threads(threads)
  end subroutine compute

  !> The ordering that MUMPS says it used.
  pure function ordering_name(ordering, analysis) result(name)
    integer, intent(in) :: ordering   !< INFOG(7)
    integer, intent(in) :: analysis   !< INFOG(32): 2 is a parallel analysis, which takes orderings of its own
    character(len=:), allocatable :: name
    character(len=*), parameter :: names(0:6) = [character(len=15) :: 'AMD', ordering_given, 'AMF', 'SCOTCH', 'PORD', 'METIS', &
      'QAMD']
    if (analysis == 2) then
      name = merge('ParMETIS ', 'PT-SCOTCH', ordering == 2)
    else if (ordering >= 0 .and. ordering <= ubound(names, 1)) then
      name = names(ordering)
    else
      name = 'INFOG(7) = '//to_text(ordering)
    end if
    name = trim(name)
  end function ordering_name

  !> MUMPS gives large counts as negative millions.
  pure integer(i8) function count_entries(info)
    integer, intent(in) :: info  !< INFOG(29)
    count_entries = merge(int(info, i8), -1000000_i8*info, info >= 0)
  end function count_entries

  !> Solve for one or more right-hand sides in place.
  subroutine solve(self, b, error)
    class(mumps_t), intent(inout) :: self                     !< factorised solver
    real(dp), intent(inout), target, contiguous :: b(:, :)    !< right-hand sides (n, count), then solutions
    type(error_t), allocatable, intent(out) :: error          !< MUMPS failure
    self%id%nrhs = size(b, 2)
    self%id%lrhs = size(b, 1)
    self%id%rhs(1:size(b)) => b
    self%id%job = 3
    call compute(self%id, 4*real(self%factor_entries, dp)*size(b, 2))
    nullify (self%id%rhs)
    call check_mumps(self%id%infog(:16), self%id%n, error)
  end subroutine solve

  !> Give back all memory but the caller's.
  subroutine release(self)
    class(mumps_t), intent(inout) :: self  !< solver
    if (.not. associated(self%id)) return
    associate (id => self%id)
      nullify (id%irn, id%jcn, id%a)
      if (associated(id%perm_in)) deallocate (id%perm_in)
      nullify (id%perm_in)
      id%job = -2
      call dmumps(id)
    end associate
    deallocate (self%id)
  end subroutine release

  !> Sentence for a MUMPS status.
  subroutine check_mumps(infog, n, error)
    integer, intent(in) :: infog(16)                  !< INFOG(1:16) after a call; 16: memory it had estimated [MB]
    integer, intent(in) :: n                          !< unknowns
    type(error_t), allocatable, intent(out) :: error  !< set if the call failed
    character(len=:), allocatable :: codes
    if (infog(1) >= 0) return
    codes = ' (MUMPS INFOG(1:2) = '//to_text(infog(1))//', '//to_text(infog(2))//')'
    select case (infog(1))
    case (-10, -6)
      call raise(error, code_linear_solver, &
        'the stiffness matrix is singular: a body is not held; check supports, contact and units of lengths'//codes)
    case (-8, -9, -13, -19, -22)
      call raise(error, code_memory, 'out of memory in the factorisation of '//to_text(n)// &
        ' unknowns, which needs some '//to_text(infog(16))//' MB: take a coarser mesh, or '// &
        'leave the choice of the solver to the program'//codes)
    case default
      call raise(error, code_internal, 'the sparse solver failed'//codes)
    end select
  end subroutine check_mumps

  !> Begin, and enter the pattern; jobs follow by dmumps.
  subroutine open_mumps(id, symmetry, n, row, col, position)
    type(dmumps_struc), intent(inout) :: id        !< new structure
    integer, intent(in) :: symmetry                !< MUMPS SYM
    integer, intent(in) :: n                       !< unknowns
    integer, intent(in), target :: row(:), col(:)  !< coordinates from 1; kept
    integer, intent(in) :: position(:)             !< place of each unknown in the elimination order
    id%comm = 0
    id%sym = symmetry
    id%par = 1
    id%job = -1
    call dmumps(id)
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
  end subroutine open_mumps
end module hd_mumps
