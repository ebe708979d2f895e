! SPDX-License-Identifier: GPL-3.0-or-later
!> What condensation needs of the bodies: their compliance at the contact, however it is represented.
module hd_compliance
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_problem, only: problem_t
  use hd_symmetry, only: symmetry_t
  implicit none
  private
  public :: compliance_t

  !> F maps forces at multipliers to relative displacements there; both in the dofs of the interface.
  type, abstract :: compliance_t
    character(len=40) :: name = ''             !< for log and summary
    logical :: fast = .false.                  !< apply and precondition are cheap and worth a Krylov method
    real(dp) :: apply_flops = 0                !< operations of one apply
    real(dp) :: products = 1                   !< of weights behind a block of F, where add_column forms it
    integer(int64) :: factor_entries = 0       !< entries of the factors
    character(len=40) :: ordering_asked = 'none', ordering_used = 'none'
    character(len=16) :: library = ''          !< version of the library behind it
  contains
    procedure(prepare_compliance), deferred :: prepare
    procedure(solve_bodies), deferred :: solve
    procedure(apply_compliance), deferred :: apply
    procedure :: apply_single
    procedure(precondition_compliance), deferred :: precondition
    procedure :: prepare_columns
    procedure(add_column), deferred :: add_column
    procedure :: own
    procedure :: surround
    procedure(release_compliance), deferred :: release
  end type compliance_t

  abstract interface
    !> Factorise what scenes of a symmetry need.
    subroutine prepare_compliance(self, problem, symmetry, error)
      import :: compliance_t, problem_t, symmetry_t, error_t
      class(compliance_t), intent(inout) :: self        !< compliance
      type(problem_t), intent(in) :: problem            !< problem
      type(symmetry_t), intent(in) :: symmetry          !< of the load step
      type(error_t), allocatable, intent(out) :: error  !< body not held, memory
    end subroutine prepare_compliance

    !> u = K^-1 f.
    subroutine solve_bodies(self, problem, f, u, error)
      import :: compliance_t, problem_t, dp, error_t
      class(compliance_t), intent(inout) :: self        !< prepared
      type(problem_t), intent(in) :: problem            !< problem
      real(dp), intent(in) :: f(:, :)                   !< nodal forces (3, n) [N]
      real(dp), intent(out) :: u(:, :)                  !< displacements, 0 where prescribed (3, n) [m]
      type(error_t), allocatable, intent(out) :: error  !< solver
    end subroutine solve_bodies

    !> w = F f for all multipliers.
    subroutine apply_compliance(self, f, w)
      import :: compliance_t, dp
      class(compliance_t), intent(inout) :: self   !< prepared
      real(dp), intent(in) :: f(:, :)              !< forces at the multipliers (3, multipliers) [N]
      real(dp), intent(out) :: w(:, :)             !< relative displacements (3, multipliers) [m]
    end subroutine apply_compliance

    !> f close to F^-1 w.
    subroutine precondition_compliance(self, w, f, error)
      import :: compliance_t, dp, error_t
      class(compliance_t), intent(inout) :: self        !< prepared
      real(dp), intent(in) :: w(:, :)                   !< relative displacements (3, multipliers) [m]
      real(dp), intent(out) :: f(:, :)                  !< forces (3, multipliers) [N]
      type(error_t), allocatable, intent(out) :: error  !< memory
    end subroutine precondition_compliance

    !> Add the blocks F(list, j) diag(sign) to a column of blocks.
    subroutine add_column(self, j, sign, list, column)
      import :: compliance_t, dp
      class(compliance_t), intent(in) :: self        !< prepared
      integer, intent(in) :: j                       !< multiplier that is loaded
      real(dp), intent(in) :: sign(3)                !< signs of its components
      integer, intent(in) :: list(:)                 !< multipliers that are looked at
      real(dp), intent(inout) :: column(:, :, :)     !< (3, 3, list) [m/N]
    end subroutine add_column

    !> Give back all memory.
    subroutine release_compliance(self)
      import :: compliance_t
      class(compliance_t), intent(inout) :: self  !< compliance
    end subroutine release_compliance
  end interface

contains

  !> w = F f to single precision, where that is faster.
  subroutine apply_single(self, f, w)
    class(compliance_t), intent(inout) :: self   !< prepared
    real(dp), intent(in) :: f(:, :)              !< forces at the multipliers (3, multipliers) [N]
    real(dp), intent(out) :: w(:, :)             !< relative displacements (3, multipliers) [m]
    call self%apply(f, w)
  end subroutine apply_single

  !> Make what add_column needs, where prepare has not.
  subroutine prepare_columns(self, error)
    class(compliance_t), intent(inout) :: self        !< prepared
    type(error_t), allocatable, intent(out) :: error  !< memory
  end subroutine prepare_columns

  !> Open points around the closed ones, layer by layer: entry e adds weight(e) times the value at from(e) to point at(e). None
  !> where neighbours are not known.
  subroutine surround(self, closed, at, from, weight)
    class(compliance_t), intent(in) :: self           !< prepared
    logical, intent(in) :: closed(:)                  !< (multipliers)
    integer, allocatable, intent(out) :: at(:), from(:)
    real(dp), allocatable, intent(out) :: weight(:)
    allocate (at(0), from(0), weight(0))
  end subroutine surround

  !> Block F(j, j).
  function own(self, j) result(block)
    class(compliance_t), intent(in) :: self  !< prepared
    integer, intent(in) :: j                 !< multiplier
    real(dp) :: block(3, 3)                  !< [m/N]
    real(dp) :: column(3, 3, 1)
    column = 0
    call self%add_column(j, [1._dp, 1._dp, 1._dp], [j], column)
    block = column(:, :, 1)
  end function own
end module hd_compliance
