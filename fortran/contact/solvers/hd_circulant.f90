! SPDX-License-Identifier: GPL-3.0-or-later
!> Compliance of two revolved bodies at their contact, by harmonics: F = sum_b W_b C_b W_b^T, with C_b the block-circulant
!> compliance of the face nodes of body b and W_b its mortar weights. Numbers of sectors may differ; where all weights are
!> one (matching meshes of linear elements), both bodies merge into one circulant.
module hd_circulant
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp, pi, sp
  use hd_circulant_side, only: circulant_side_t, collect_side, plan_side, fill_kernel, add_response, add_side_column, &
    release_side, line_up, fade_out
  use hd_error, only: error_t, raise, code_input
  use hd_fft_single, only: execute_rows, free_rows, plan_rows, rows_plan_t
  use hd_harmonic_matrix, only: harmonic_matrix_t, new_harmonic_matrix
  use hd_system, only: stop_requested, check_stop
  use hd_harmonics, only: harmonics_t, new_harmonics, hold_loose, factorise_harmonics, solve_body, face_compliance, harmonic_entries
  use hd_lapack, only: invert_symmetric
  use hd_problem, only: problem_t
  use hd_symmetry, only: symmetry_t
  use hd_vector, only: many, thread_share
  implicit none
  private
  public :: circulant_t, new_circulant, has_circulant

  !> Part of the local compliance, F's diagonal for the shortest wave round the axis, that is added to F before it is inverted:
  !> where contact or slip ends, F^-1 of the whole face answers too stiffly. On meshes with edge cells GMRES takes 40 steps for 66
  !> under torque (six scenes; 0.03 to 0.3: 38 to 42), on others as many as without it.
  real(dp), parameter :: softer = 0.1_dp
  real(dp), parameter :: rounding = 1e-10_dp    !< of a weight of 1
  real(dp), parameter :: negligible = 1e-12_dp  !< entries of F that are left out, relative (hd_harmonic_matrix)
  real(dp), parameter :: small = 1e-8_dp        !< the same where single precision is enough
  real(dp), parameter :: rough = 1e-4_dp        !< the same of its inverse

  !> F^-1 by harmonic and workspace to apply it, in single precision: it steers GMRES, whose residuals are those of F.
  type :: inverse_t
    type(harmonic_matrix_t) :: hat                  !< [N/m]
    real(sp), allocatable :: field(:, :)            !< (3 rows, n/stride)
    complex(sp), allocatable :: wave(:, :)          !< (3 rows, n/stride/2 + 1)
    type(rows_plan_t) :: forward, backward
  end type inverse_t

  type :: circulant_t
    real(dp) :: apply_flops = 0                     !< operations of one apply
    real(dp) :: products = 1                        !< of weights behind a block of F, where add_column forms it
    integer(int64) :: factor_entries = 0            !< entries of the factors
    type(harmonics_t), allocatable :: bodies(:)     !< factors of both bodies
    type(circulant_side_t), allocatable :: sides(:)           !< one for each body; the third: both merged
    integer :: part(2) = [1, 0]                     !< first and last side that are applied: both bodies', or the merged one
    integer, allocatable :: meets(:)                !< dof of the second face by dof of the first, where they are merged
    integer :: stride = 0                           !< 2: fields repeat after half a turn
    integer :: known = 0                            !< stride for which hat is complete, 0: none
    integer :: serial = 0                           !< of the coupling whose weights the sides have
    integer :: rows = 0                             !< multipliers along the axis
    integer, allocatable :: row(:), sector(:)       !< place of each multiplier, sector from 0
    integer, allocatable :: beside(:, :)            !< rows before and behind each row on the same face, 0: none (2, rows)
    logical :: inverted = .false.                   !< the inverse is there
    type(inverse_t) :: ring                         !< of the mean over the sectors
  contains
    procedure :: prepare => prepare_circulant
    procedure :: solve => solve_circulant
    procedure :: apply => apply_circulant
    procedure :: precondition => precondition_circulant
    procedure :: prepare_columns => prepare_circulant_columns
    procedure :: add_column => add_circulant_column
    procedure :: own => own_block
    procedure :: surround => surround_closed
    procedure :: release => release_circulant
  end type circulant_t

contains

  !> Two revolved bodies, multipliers on the first, every row of them complete round the axis.
  pure logical function has_circulant(problem) result(yes)
    type(problem_t), intent(in) :: problem  !< problem
    yes = size(problem%bodies) == 2
    if (yes) yes = all(problem%bodies%revolved) .and. modulo(problem%mortar%n, problem%bodies(1)%sectors) == 0 .and. &
      all(problem%mortar%node <= problem%bodies(1)%nodes())
  end function has_circulant

  !> Number the faces; factors are made by prepare.
  subroutine new_circulant(problem, circulant, error)
    type(problem_t), intent(in) :: problem            !< problem
    type(circulant_t), intent(out) :: circulant       !< compliance
    type(error_t), allocatable, intent(out) :: error  !< not revolved, inverted element
    integer :: b, first, m
    if (.not. has_circulant(problem)) then
      call raise(error, code_input, "solver.method = 'condensed' and solver.factors = "// &
        "'harmonic' need two bodies of revolution; valid: auto")
      return
    end if
    allocate (circulant%bodies(2), circulant%sides(3))
    do b = 1, 2
      m = problem%bodies(b)%nodes_per_sector
      first = problem%first(b)
      call new_harmonics(problem%bodies(b), problem%fixed(:, first + 1:first + m), &
        problem%spring(:, first + 1:first + m), circulant%bodies(b), error)
      if (allocated(error)) return
      if (allocated(problem%loose)) then
        if (any(problem%loose == b)) call hold_loose(circulant%bodies(b), problem%loose_ways(:, findloc(problem%loose, b, 1)))
      end if
    end do
    call place_multipliers(problem, circulant)
    call couple(problem, circulant)
  end subroutine new_circulant

  !> Take over the weights of faces that are paired, or paired anew.
  subroutine couple(problem, circulant)
    type(problem_t), intent(in) :: problem           !< problem
    type(circulant_t), intent(inout) :: circulant    !< gets sides and parts
    type(circulant_side_t), allocatable :: before(:)
    integer :: p, part(2)
    call release_parts(circulant)
    part = circulant%part
    call move_alloc(circulant%sides, before)
    allocate (circulant%sides(3))
    do p = 1, 2
      call collect_side(problem, p, circulant%sides(p))
    end do
    call merge_sides(circulant)
    if (any(part /= circulant%part)) circulant%known = 0
    do p = circulant%part(1), circulant%part(2)
      if (circulant%known > 0) then
        if (.not. same_numbers(circulant%sides(p)%nodes, before(p)%nodes)) circulant%known = 0
      end if
    end do
    do p = circulant%part(1), circulant%part(2)
      associate (side => circulant%sides(p))
        if (circulant%known > 0) then
          call move_alloc(before(p)%hat%part, side%hat%part)
          call move_alloc(before(p)%hat%factor, side%hat%factor)
          side%hat%n = before(p)%hat%n
        else
          call new_harmonic_matrix(side%angle, side%sectors/2, side%hat, drop=negligible, short_drop=small)
        end if
      end associate
    end do
    circulant%stride = 0
    circulant%serial = problem%mortar%serial
  end subroutine couple

  !> Two lists are equal.
  pure logical function same_numbers(a, b)
    integer, intent(in) :: a(:), b(:)  !< lists
    same_numbers = size(a) == size(b)
    if (same_numbers) same_numbers = all(a == b)
  end function same_numbers

  !> Sector and axial row of every multiplier.
  subroutine place_multipliers(problem, circulant)
    type(problem_t), intent(in) :: problem           !< problem
    type(circulant_t), intent(inout) :: circulant    !< gets rows, row, sector
    integer :: number(problem%bodies(1)%nodes_per_sector), i, m
    m = problem%bodies(1)%nodes_per_sector
    number = 0
    number(modulo(problem%mortar%node - 1, m) + 1) = 1
    circulant%rows = count(number > 0)
    number = [(count(number(:i) > 0), i=1, m)]
    circulant%sector = (problem%mortar%node - 1)/m
    circulant%row = number(modulo(problem%mortar%node - 1, m) + 1)
    allocate (circulant%beside(2, circulant%rows), source=0)
    call line_up(circulant%row(:problem%mortar%n - problem%mortar%rigid), circulant%beside)
    call line_up(circulant%row(problem%mortar%n - problem%mortar%rigid + 1:), circulant%beside)
  end subroutine place_multipliers

  !> Factorise and transform what a stride needs.
  subroutine prepare_circulant(self, problem, symmetry, error)
    class(circulant_t), intent(inout) :: self         !< compliance
    type(problem_t), intent(in) :: problem            !< problem
    type(symmetry_t), intent(in) :: symmetry          !< of the load step
    type(error_t), allocatable, intent(out) :: error  !< body not held, memory
    integer :: b, stride
    stride = merge(2, 1, symmetry%half_turn)
    if (problem%mortar%serial /= self%serial) call couple(problem, self)
    if (stride == self%stride .or. problem%n == 0) return
    self%factor_entries = 0
    do b = 1, 2
      call factorise_harmonics(self%bodies(b), stride, error)
      if (allocated(error)) return
      self%factor_entries = self%factor_entries + int(harmonic_entries(self%bodies(b), stride), int64)
    end do
    do b = self%part(1), self%part(2)
      call fill_hat(self, b, stride)
    end do
    call check_stop(error)
    if (allocated(error)) return
    self%known = merge(stride, min(stride, self%known), self%known == 0)
    self%stride = stride
    call release_parts(self)
    self%products = sum([((real(self%sides(b)%ptr(size(self%row) + 1) - 1, dp)/size(self%row))**2, b=self%part(1), self%part(2))])
    self%apply_flops = 0
    do b = self%part(1), self%part(2)
      call plan_side(self%sides(b), stride, self%sector < self%sides(1)%sectors/stride, error)
      if (allocated(error)) return
      self%apply_flops = self%apply_flops + 8*real(self%sides(b)%hat%n, dp)**2*size(self%sides(b)%wave, 2) + &
        10*size(self%sides(b)%field)*log(real(size(self%sides(b)%field, 2), dp))
    end do
  end subroutine prepare_circulant

  !> Compliance of a side, by harmonic; what is known stays.
  subroutine fill_hat(self, p, stride)
    type(circulant_t), intent(inout) :: self  !< gets sides(p)%hat
    integer, intent(in) :: p                  !< side; 3 is both
    integer, intent(in) :: stride             !< 1 or 2
    real(dp), allocatable :: hat(:, :), other(:, :)
    integer :: b, k
    b = merge(1, p, p == 3)
    !$omp parallel private(hat, other)
    allocate (hat(self%sides(p)%hat%n, self%sides(p)%hat%n), other(self%sides(p)%hat%n, self%sides(p)%hat%n))
    !$omp do schedule(dynamic)
    do k = 0, self%sides(p)%sectors/2, stride
      if (self%known == 1 .or. (self%known == 2 .and. modulo(k, 2) == 0) .or. stop_requested()) cycle
      call face_compliance(self%bodies(b), self%sides(b)%nodes, k, hat)
      if (p == 3) then
        call face_compliance(self%bodies(2), self%sides(2)%nodes, k, other)
        hat = hat + other(self%meets, self%meets)
      end if
      call self%sides(p)%hat%set(k, hat)
    end do
    !$omp end do
    deallocate (hat, other)
    !$omp end parallel
  end subroutine fill_hat

  !> Both sides, or one where every multiplier meets exactly one node of either.
  subroutine merge_sides(self)
    type(circulant_t), intent(inout) :: self  !< gets parts
    integer :: at(self%rows), j
    logical :: merged
    merged = self%sides(1)%sectors == self%sides(2)%sectors .and. size(self%sides(1)%nodes) == self%rows .and. &
      size(self%sides(2)%nodes) == self%rows .and. size(self%row) == size(self%sides(1)%ptr) - 1
    if (merged) merged = all(self%sides(1)%ptr(2:) - self%sides(1)%ptr(:size(self%row)) == 1) .and. &
      all(self%sides(2)%ptr(2:) - self%sides(2)%ptr(:size(self%row)) == 1)
    if (merged) then
      at = 0
      do j = 1, size(self%row)
        if (at(self%sides(1)%row(j)) == 0) at(self%sides(1)%row(j)) = self%sides(2)%row(j)
        merged = merged .and. at(self%sides(1)%row(j)) == self%sides(2)%row(j) .and. &
          self%sides(1)%sector(j) == self%sides(2)%sector(j) .and. &
          abs(abs(self%sides(1)%val(j)) - 1) < rounding .and. abs(abs(self%sides(2)%val(j)) - 1) < rounding
      end do
    end if
    self%part = merge(3, [1, 2], merged)
    if (.not. merged) return
    self%sides(3) = self%sides(1)
    self%sides(3)%val = 1
    self%meets = [(3*at(j) - 2, 3*at(j) - 1, 3*at(j), j=1, self%rows)]
  end subroutine merge_sides

  !> Compliance between all sectors.
  subroutine prepare_circulant_columns(self, error)
    class(circulant_t), intent(inout) :: self         !< prepared
    type(error_t), allocatable, intent(out) :: error  !< memory
    integer :: p
    do p = self%part(1), self%part(2)
      call fill_kernel(self%sides(p), self%stride, error)
      if (allocated(error)) return
    end do
  end subroutine prepare_circulant_columns

  !> u = K^-1 f for some f.
  subroutine solve_circulant(self, problem, sides, f, u, error)
    class(circulant_t), intent(inout) :: self         !< prepared
    type(problem_t), intent(in) :: problem            !< problem
    integer, intent(in) :: sides                      !< how many
    real(dp), intent(in) :: f(3, problem%n, sides)    !< nodal forces [N]
    real(dp), intent(out) :: u(3, problem%n, sides)   !< displacements [m]
    type(error_t), allocatable, intent(out) :: error  !< memory
    integer :: b
    do b = 1, 2
      associate (low => problem%first(b) + 1, high => problem%first(b) + problem%bodies(b)%nodes())
        if (.not. any(abs(f(:, low:high, :)) > 0)) then
          u(:, low:high, :) = 0
          cycle
        end if
        call solve_body(self%bodies(b), self%stride, f(:, low:high, :), u(:, low:high, :), error)
      end associate
      if (allocated(error)) return
    end do
  end subroutine solve_circulant

  !> w = F f, most of it in single precision where that is enough.
  subroutine apply_circulant(self, single, f, w)
    class(circulant_t), intent(inout) :: self    !< prepared
    logical, intent(in) :: single                !< single precision is enough
    real(dp), intent(in) :: f(:, :)              !< forces (3, multipliers) [N]
    real(dp), intent(out) :: w(:, :)             !< relative displacements (3, multipliers) [m]
    integer :: p
    do p = self%part(1), self%part(2)
      call add_response(self%sides(p), self%stride, single, p > self%part(1), f, w)
    end do
  end subroutine apply_circulant

  !> Inverse of F where it is circulant, else of its mean over the sectors of the ring, a little softer.
  subroutine precondition_circulant(self, w, f, error)
    class(circulant_t), intent(inout) :: self         !< prepared
    real(dp), intent(in) :: w(:, :)                   !< relative displacements (3, multipliers) [m]
    real(dp), intent(out) :: f(:, :)                  !< forces (3, multipliers) [N]
    type(error_t), allocatable, intent(out) :: error  !< memory
    integer :: j, n
    if (.not. self%inverted) call invert_mean(self, error)
    if (allocated(error)) return
    associate (ring => self%ring)
      n = size(ring%field, 2)
      !$omp parallel do schedule(static, thread_share) if(size(w) > many/4)
      do j = 1, size(w, 2)
        if (self%sector(j) < n) ring%field(3*self%row(j) - 2:3*self%row(j), self%sector(j) + 1) = real(w(:, j), sp)
      end do
      !$omp end parallel do
      call execute_rows(ring%forward, n, ring%field, ring%wave, .true.)
      call ring%hat%multiply_single(self%stride, ring%wave)
      call execute_rows(ring%backward, n, ring%field, ring%wave, .false.)
      !$omp parallel do schedule(static) if(size(w) > many/4)
      do j = 1, size(w, 2)
        f(:, j) = ring%field(3*self%row(j) - 2:3*self%row(j), modulo(self%sector(j), n) + 1)/real(n, sp)
      end do
      !$omp end parallel do
    end associate
  end subroutine precondition_circulant

  !> Open points around the closed ones, layer by layer: entry e adds weight(e) times the value at from(e) to point at(e).
  subroutine surround_closed(self, closed, at, from, weight)
    class(circulant_t), intent(in) :: self            !< prepared
    logical, intent(in) :: closed(:)                  !< (multipliers)
    integer, allocatable, intent(out) :: at(:), from(:)
    real(dp), allocatable, intent(out) :: weight(:)
    call fade_out(self%row, self%sector, self%beside, self%sides(1)%sectors/self%stride, closed, at, from, weight)
  end subroutine surround_closed

  !> Mean of F over rotations by one sector of the ring, a little softer, inverted harmonic by harmonic.
  subroutine invert_mean(self, error)
    type(circulant_t), intent(inout) :: self          !< gets inverse and its workspace
    type(error_t), allocatable, intent(out) :: error  !< memory
    type(error_t), allocatable :: trouble
    real(dp), allocatable :: mean(:, :), more(:)
    integer :: j, k, n, last
    n = self%sides(1)%sectors
    call new_harmonic_matrix([(0._dp, j=1, self%rows)], n/2, self%ring%hat, short_drop=rough)
    last = n/2 - modulo(n/2, self%stride)
    mean = mean_of(self, last)  ! of the shortest wave
    more = [(softer*mean(j, j), j=1, size(mean, 1))]
    !$omp parallel do schedule(dynamic) private(mean, j, trouble)
    do k = 0, last, self%stride
      mean = mean_of(self, k)
      do j = 1, size(mean, 1)
        mean(j, j) = mean(j, j) + more(j)
        if (.not. mean(j, j) > 0) mean(j, j) = 1       ! prescribed dofs of points that meet the wave generator: never asked for
      end do
      call invert_symmetric(mean, trouble)
      if (.not. allocated(trouble)) then
        call self%ring%hat%set(k, mean)
      else
        !$omp critical (mean_failed)
        call move_alloc(trouble, error)
        !$omp end critical (mean_failed)
      end if
    end do
    !$omp end parallel do
    if (allocated(error)) return
    allocate (self%ring%field(3*self%rows, n/self%stride), self%ring%wave(3*self%rows, n/self%stride/2 + 1))
    call plan_rows(n/self%stride, 3*self%rows, self%ring%field, self%ring%wave, self%ring%forward, self%ring%backward, error)
    self%inverted = .not. allocated(error)
  end subroutine invert_mean

  !> One harmonic of that mean.
  pure function mean_of(self, k) result(mean)
    type(circulant_t), intent(in) :: self  !< prepared
    integer, intent(in) :: k               !< harmonic
    real(dp), allocatable :: mean(:, :), m(:, :)
    real(dp) :: weight
    integer :: d, j, l, p, n, alias
    logical :: turned
    n = self%sides(1)%sectors
    allocate (mean(3*self%rows, 3*self%rows), source=0._dp)
    do p = self%part(1), self%part(2)
      associate (part => self%sides(p))
        alias = modulo(k, part%sectors)
        turned = 2*alias > part%sectors
        if (turned) alias = part%sectors - alias
        allocate (m(part%hat%n, 3*self%rows), source=0._dp)
        do j = 1, size(self%row)
          do l = part%ptr(j), part%ptr(j + 1) - 1
            weight = part%val(l)*cos(k*(2*pi*self%sector(j)/n - 2*pi*part%sector(l)/part%sectors - part%angle(part%row(l))))
            do d = 1, 3
              if (turned .and. d == 2) weight = -weight
              m(3*part%row(l) - 3 + d, 3*self%row(j) - 3 + d) = m(3*part%row(l) - 3 + d, 3*self%row(j) - 3 + d) + weight
              if (turned .and. d == 2) weight = -weight
            end do
          end do
        end do
        call add_congruent(part%hat%full(alias), m, 1/(real(n, dp)*part%sectors), mean)
        deallocate (m)
      end associate
    end do
  end function mean_of

  !> Add N^T F N times a factor; N has few entries in a column: a full product takes 6 % of a fine run.
  pure subroutine add_congruent(f, n, factor, a)
    real(dp), intent(in) :: f(:, :)              !< symmetric (rows, rows)
    real(dp), intent(in) :: n(:, :)              !< (rows, columns)
    real(dp), intent(in) :: factor               !< of the product
    real(dp), intent(inout) :: a(:, :)           !< gets it (columns, columns)
    real(dp), allocatable :: product(:, :)
    integer :: c, r
    allocate (product(size(n, 1), size(n, 2)), source=0._dp)
    do c = 1, size(n, 2)
      do r = 1, size(n, 1)
        if (abs(n(r, c)) > 0) product(:, c) = product(:, c) + n(r, c)*f(:, r)
      end do
    end do
    product = transpose(product)
    do c = 1, size(n, 2)
      do r = 1, size(n, 1)
        if (abs(n(r, c)) > 0) a(:, c) = a(:, c) + factor*n(r, c)*product(:, r)
      end do
    end do
  end subroutine add_congruent

  !> Add the blocks F(list, j) diag(sign) to a column of blocks.
  subroutine add_circulant_column(self, j, sign, list, column)
    class(circulant_t), intent(in) :: self         !< prepared
    integer, intent(in) :: j                       !< multiplier that is loaded
    real(dp), intent(in) :: sign(3)                !< signs of its components
    integer, intent(in) :: list(:)                 !< multipliers that are looked at
    real(dp), intent(inout) :: column(:, :, :)     !< (3, 3, list) [m/N]
    integer :: p
    do p = self%part(1), self%part(2)
      call add_side_column(self%sides(p), j, sign, list, column)
    end do
  end subroutine add_circulant_column

  !> Block F(j, j).
  function own_block(self, j) result(block)
    class(circulant_t), intent(in) :: self  !< prepared
    integer, intent(in) :: j                !< multiplier
    real(dp) :: block(3, 3)                 !< [m/N]
    integer :: p
    block = 0
    do p = self%part(1), self%part(2)
      block = block + self%sides(p)%own(:, :, j)
    end do
  end function own_block

  !> Give back plans and workspace.
  subroutine release_parts(self)
    class(circulant_t), intent(inout) :: self  !< compliance
    integer :: p
    call free_rows(self%ring%forward)
    call free_rows(self%ring%backward)
    if (allocated(self%ring%field)) deallocate (self%ring%field, self%ring%wave)
    self%inverted = .false.
    do p = self%part(1), self%part(2)
      call release_side(self%sides(p))
    end do
  end subroutine release_parts

  !> Give back all memory.
  subroutine release_circulant(self)
    class(circulant_t), intent(inout) :: self  !< compliance
    call release_parts(self)
    if (allocated(self%bodies)) deallocate (self%bodies, self%sides)
    self%stride = 0
    self%known = 0
  end subroutine release_circulant
end module hd_circulant
