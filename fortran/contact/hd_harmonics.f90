! SPDX-License-Identifier: GPL-3.0-or-later
!> Direct solution of a revolved body by Fourier transform over its sectors.
!>
!> The stiffness of equal sectors is a block circulant: for u_s = sum_k c_k exp(2 pi i k s / n) it splits into one Hermitian
!> band matrix of a meridian section per harmonic k = 0..n/2, each factorised by Cholesky. Exact to rounding. Fields that
!> repeat after half a turn need the even harmonics only: n is then half the number of sectors.
module hd_harmonics
  use hd_kinds, only: dp, pi
  use hd_body, only: body_t, sector_stiffness
  use hd_error, only: error_t
  use hd_lapack, only: factorise_band, multiply_dense, solve_band
  implicit none
  private
  public :: harmonics_t, new_harmonics, solve_body, face_compliance

  type :: harmonics_t
    integer :: sectors = 0                        !< n: all sectors, or half of them
    integer :: dofs = 0                           !< free dofs of a sector
    integer, allocatable :: equation(:, :)        !< number of each dof of a sector, 0 where fixed (3, nodes per sector)
    complex(dp), allocatable :: band(:, :, :)     !< factors (kd + 1, dofs, 0:n/2)
    real(dp), allocatable :: forward(:, :)        !< n x (n/2 + 1) cosines, then as many sines
  end type harmonics_t

contains

  !> Factorise a body. `fixed` and `spring` must be the same in every sector.
  subroutine new_harmonics(body, n, fixed, spring, harmonics, error)
    type(body_t), intent(in) :: body                  !< revolved body
    integer, intent(in) :: n                          !< sectors after which all fields repeat
    logical, intent(in) :: fixed(:, :)                !< prescribed dofs of the first sector (3, nodes per sector)
    real(dp), intent(in) :: spring(:, :)              !< springs to the ground there (3, nodes per sector) [N/m]
    type(harmonics_t), intent(out) :: harmonics       !< factors
    type(error_t), allocatable, intent(out) :: error  !< inverted element, body not held
    real(dp), allocatable :: ke(:, :, :)
    complex(dp) :: phase
    integer :: a, b, c, i, j, k, m, width
    m = body%nodes_per_sector
    harmonics%sectors = n
    allocate (harmonics%equation(3, m), source=0)
    do a = 1, m
      do c = 1, 3
        if (fixed(c, a)) cycle
        harmonics%dofs = harmonics%dofs + 1
        harmonics%equation(c, a) = harmonics%dofs
      end do
    end do
    call sector_stiffness(body, ke, error)
    if (allocated(error)) return
    width = band_width(body, harmonics%equation)
    allocate (harmonics%band(width + 1, harmonics%dofs, 0:n/2), source=(0._dp, 0._dp))
    do k = 0, n/2
      phase = exp(cmplx(0, 2*pi*k/n, dp))
      do c = 1, size(body%cells, 2)
        do b = 1, size(body%cells, 1)
          do a = 1, size(body%cells, 1)
            call add_block(body%cells(a, c), body%cells(b, c), ke(3*a - 2:3*a, 3*b - 2:3*b, c))
          end do
        end do
      end do
      do a = 1, m
        do c = 1, 3
          i = harmonics%equation(c, a)
          if (i > 0) harmonics%band(width + 1, i, k) = harmonics%band(width + 1, i, k) + spring(c, a)
        end do
      end do
      call factorise_band(harmonics%band(:, :, k), error)
      if (allocated(error)) return
    end do
    allocate (harmonics%forward(n, 2*(n/2 + 1)))
    do k = 0, n/2
      do i = 1, n
        j = modulo(k*(i - 1), n)
        harmonics%forward(i, k + 1) = cos(2*pi*j/n)
        harmonics%forward(i, n/2 + 2 + k) = sin(2*pi*j/n)
      end do
    end do
  contains
    !> Add a 3 x 3 block of a cell, folded into the first sector.
    subroutine add_block(row, column, block)
      integer, intent(in) :: row, column
      real(dp), intent(in) :: block(3, 3)
      complex(dp) :: factor
      integer :: p, q, r, s
      factor = 1
      if (row > m) factor = factor*conjg(phase)
      if (column > m) factor = factor*phase
      do s = 1, 3
        q = harmonics%equation(s, modulo(column - 1, m) + 1)
        do r = 1, 3
          p = harmonics%equation(r, modulo(row - 1, m) + 1)
          if (p == 0 .or. q < p) cycle
          harmonics%band(width + 1 + p - q, q, k) = harmonics%band(width + 1 + p - q, q, k) + factor*block(r, s)
        end do
      end do
    end subroutine add_block
  end subroutine new_harmonics

  !> Half band width of the folded sector matrix.
  pure integer function band_width(body, equation) result(width)
    type(body_t), intent(in) :: body          !< body
    integer, intent(in) :: equation(:, :)     !< dof numbers of a sector
    integer :: c, list(size(body%cells, 1))
    width = 0
    do c = 1, size(body%cells, 2)
      list = modulo(body%cells(:, c) - 1, body%nodes_per_sector) + 1
      if (all(equation(:, list) == 0)) cycle
      width = max(width, maxval(equation(:, list)) - minval(equation(:, list), mask=equation(:, list) > 0))
    end do
  end function band_width

  !> Displacements under nodal forces; fixed dofs get 0.
  subroutine solve_body(harmonics, f, u)
    type(harmonics_t), intent(in) :: harmonics        !< factors
    real(dp), intent(in) :: f(:, :)                   !< nodal forces of the body (3, nodes) [N]
    real(dp), intent(out) :: u(:, :)                  !< displacements (3, nodes) [m]
    real(dp), allocatable :: field(:, :), wave(:, :)
    complex(dp), allocatable :: c(:, :)
    integer :: a, d, k, m, n, half, s
    n = harmonics%sectors
    m = size(harmonics%equation, 2)
    half = n/2 + 1
    allocate (field(harmonics%dofs, n), wave(harmonics%dofs, 2*half), c(harmonics%dofs, 1))
    do s = 1, n
      do a = 1, m
        do d = 1, 3
          if (harmonics%equation(d, a) > 0) field(harmonics%equation(d, a), s) = f(d, (s - 1)*m + a)
        end do
      end do
    end do
    call multiply_dense(field, harmonics%forward, wave)
    do k = 1, half
      c(:, 1) = cmplx(wave(:, k), -wave(:, half + k), dp)
      call solve_band(harmonics%band(:, :, k - 1), c)
      wave(:, k) = real(c(:, 1))*weight(n, k - 1)
      wave(:, half + k) = -aimag(c(:, 1))*weight(n, k - 1)
    end do
    call multiply_dense(wave, transpose(harmonics%forward), field)
    u = 0
    do s = 1, size(u, 2)/m
      do a = 1, m
        do d = 1, 3
          if (harmonics%equation(d, a) > 0) u(d, (s - 1)*m + a) = field(harmonics%equation(d, a), modulo(s - 1, n) + 1)
        end do
      end do
    end do
  end subroutine solve_body

  !> Weight of harmonic k in the inverse transform: pairs k, n - k count twice.
  elemental real(dp) function weight(n, k)
    integer, intent(in) :: n, k  !< sectors, harmonic
    weight = 2._dp/n
    if (k == 0 .or. 2*k == n) weight = 1._dp/n
  end function weight

  !> Displacement of face node a in sector s under a unit force on face node b in sector 0.
  subroutine face_compliance(harmonics, nodes, kernel)
    type(harmonics_t), intent(in) :: harmonics            !< factors
    integer, intent(in) :: nodes(:)                       !< face nodes of the first sector
    real(dp), allocatable, intent(out) :: kernel(:, :, :) !< (3 nodes, 3 nodes, sectors) [m/N]
    complex(dp), allocatable :: c(:, :)
    real(dp), allocatable :: wave(:, :), flat(:, :)
    integer, allocatable :: eq(:)
    integer :: i, j, k, half, n
    n = harmonics%sectors
    half = n/2 + 1
    eq = reshape(harmonics%equation(:, nodes), [3*size(nodes)])
    allocate (c(harmonics%dofs, size(eq)), wave(size(eq)**2, 2*half), flat(size(eq)**2, n))
    do k = 1, half
      c = 0
      do i = 1, size(eq)
        if (eq(i) > 0) c(eq(i), i) = 1
      end do
      call solve_band(harmonics%band(:, :, k - 1), c)
      do j = 1, size(eq)
        do i = 1, size(eq)
          wave((j - 1)*size(eq) + i, [k, half + k]) = 0
          if (eq(i) > 0) wave((j - 1)*size(eq) + i, [k, half + k]) = &
            weight(n, k - 1)*[real(c(eq(i), j)), -aimag(c(eq(i), j))]
        end do
      end do
    end do
    call multiply_dense(wave, transpose(harmonics%forward), flat)
    kernel = reshape(flat, [size(eq), size(eq), n])
  end subroutine face_compliance
end module hd_harmonics
