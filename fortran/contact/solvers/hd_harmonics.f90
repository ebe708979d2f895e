! SPDX-License-Identifier: GPL-3.0-or-later
!> Direct solution of a revolved body by Fourier transform over its sectors.
!>
!> The stiffness of equal sectors is a block circulant: it splits into one band matrix of a meridian section per harmonic
!> k = 0..n/2, each factorised by Cholesky when it is first needed. A sector is its own mirror image, so the amplitudes
!> (c_r, i c_theta, c_z) exp(i k theta) make these matrices real. Exact to rounding. Fields that repeat after half a turn
!> (stride 2) need the even harmonics only.
module hd_harmonics
  use hd_kinds, only: dp, pi
  use hd_band_matrix, only: factorise_band, solve_band, part_of_inverse
  use hd_system, only: stop_requested, check_stop
  use hd_body, only: body_t, sector_stiffness
  use hd_error, only: error_t
  use hd_fft, only: execute_backward_real, execute_forward_real, execute_rows, fft_plan_t, free_plan, free_rows, &
    plan_backward_real, plan_forward_real, plan_rows, rows_plan_t
  implicit none
  private
  public :: harmonics_t, new_harmonics, hold_loose, factorise_harmonics, solve_body, face_compliance, harmonic_entries, amplitude

  integer, parameter :: long_loop = 20000   !< dofs from which two threads are worth waking

  type :: band_t
    real(dp), allocatable :: a(:, :)              !< factor (kd + 1, dofs)
  end type band_t

  type :: harmonics_t
    integer :: sectors = 0                        !< n
    integer :: dofs = 0                           !< free dofs of a sector
    integer :: width = 0                          !< half band width
    integer, allocatable :: equation(:, :)        !< number of each dof of a sector, 0 where fixed (3, nodes per sector)
    real(dp), allocatable :: angle(:)             !< of the nodes of the first sector (nodes per sector) [rad]
    integer, allocatable :: cells(:, :)           !< cells of the first sector
    real(dp), allocatable :: ke(:, :, :)          !< their stiffness [N/m]
    real(dp), allocatable :: spring(:, :)         !< springs to the ground of a sector (3, nodes per sector) [N/m]
    type(band_t), allocatable :: factor(:)        !< by harmonic, 0:n/2
    integer :: anchor(2, 0:1) = 0                 !< dofs that are held in this harmonic alone, 0: none (see hold_loose)
  end type harmonics_t

contains

  !> Describe a body. `fixed` and `spring` must be the same in every sector.
  subroutine new_harmonics(body, fixed, spring, harmonics, error)
    type(body_t), intent(in) :: body                  !< revolved body
    logical, intent(in) :: fixed(:, :)                !< prescribed dofs of the first sector (3, nodes per sector)
    real(dp), intent(in) :: spring(:, :)              !< springs to the ground there (3, nodes per sector) [N/m]
    type(harmonics_t), intent(out) :: harmonics       !< nothing factorised yet
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    integer :: a, c, d, i, m
    m = body%nodes_per_sector
    harmonics%sectors = body%sectors
    harmonics%cells = body%cells
    harmonics%spring = spring
    harmonics%angle = body%angle(:m)
    allocate (harmonics%equation(3, m), source=0)
    do c = 1, size(body%cells, 2)
      do i = 1, size(body%cells, 1)
        a = modulo(body%cells(i, c) - 1, m) + 1
        do d = 1, 3
          if (fixed(d, a) .or. harmonics%equation(d, a) > 0) cycle
          harmonics%dofs = harmonics%dofs + 1
          harmonics%equation(d, a) = harmonics%dofs
        end do
      end do
    end do
    harmonics%width = band_width(body, harmonics%equation)
    allocate (harmonics%factor(0:body%sectors/2))
    call sector_stiffness(body, harmonics%ke, error)
  end subroutine new_harmonics

  !> Hold a body that may move as a whole by springs as stiff as the body itself at one node of the meridian: on the amplitudes
  !> round and along the axis in harmonic 0, on the radial one and the one along the axis in harmonic 1. As many springs as motions
  !> carry nothing under forces in balance, so that displacements are exact up to the rigid motion, which whoever uses them adds
  !> (hd_border).
  subroutine hold_loose(harmonics, ways)
    type(harmonics_t), intent(inout) :: harmonics  !< body, not factorised yet
    logical, intent(in) :: ways(6)                 !< that it may move: x, y, turn about the axis, z, turns about x and y
    integer :: a
    do a = 1, size(harmonics%equation, 2)
      if (all(harmonics%equation(:, a) > 0)) exit
    end do
    if (a > size(harmonics%equation, 2)) return  ! no node is free
    associate (dof => harmonics%equation(:, a))
      harmonics%anchor(:, 0) = merge(dof([2, 3]), 0, ways([3, 4]))
      harmonics%anchor(:, 1) = merge(dof([1, 3]), 0, ways([1, 5]))
    end associate
  end subroutine hold_loose

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

  !> Factorise harmonics 0, stride, 2 stride, ... that are not yet.
  subroutine factorise_harmonics(harmonics, stride, error)
    type(harmonics_t), intent(inout) :: harmonics     !< body
    integer, intent(in) :: stride                     !< 1: all, 2: fields that repeat after half a turn
    type(error_t), allocatable, intent(out) :: error  !< body not held
    type(error_t), allocatable :: trouble
    integer :: k
    !$omp parallel do schedule(dynamic) private(trouble)
    do k = 0, harmonics%sectors/2, stride
      if (allocated(harmonics%factor(k)%a) .or. stop_requested()) cycle
      call assemble_harmonic(harmonics, k, harmonics%factor(k)%a)
      call factorise_band(harmonics%factor(k)%a, trouble)
      if (.not. allocated(trouble)) cycle
      !$omp critical (harmonic_failed)
      call move_alloc(trouble, error)
      !$omp end critical (harmonic_failed)
    end do
    if (.not. allocated(error)) call check_stop(error)
  end subroutine factorise_harmonics

  !> Factor between a dof of the first sector and its real amplitude in a harmonic.
  elemental complex(dp) function amplitude(k, angle, component) result(d)
    integer, intent(in) :: k          !< harmonic
    real(dp), intent(in) :: angle     !< of the node [rad]
    integer, intent(in) :: component  !< 1 to 3
    d = exp(cmplx(0, k*angle, dp))
    if (component == 2) d = d*(0._dp, 1._dp)
  end function amplitude

  !> Band matrix of one harmonic.
  subroutine assemble_harmonic(harmonics, k, band)
    type(harmonics_t), intent(in) :: harmonics        !< body
    integer, intent(in) :: k                          !< harmonic
    real(dp), allocatable, intent(out) :: band(:, :)  !< upper band storage (width + 1, dofs)
    real(dp) :: alpha(size(harmonics%cells, 1)), delta
    integer :: list(size(harmonics%cells, 1)), a, b, c, i, m
    m = size(harmonics%equation, 2)
    allocate (band(harmonics%width + 1, harmonics%dofs), source=0._dp)
    do c = 1, size(harmonics%cells, 2)
      list = modulo(harmonics%cells(:, c) - 1, m) + 1
      alpha = harmonics%angle(list) + merge(2*pi/harmonics%sectors, 0._dp, harmonics%cells(:, c) > m)
      do b = 1, size(list)
        do a = 1, size(list)
          delta = k*(alpha(b) - alpha(a))
          call add_block(a, b, cos(delta), sin(delta))
        end do
      end do
    end do
    do a = 1, m
      do c = 1, 3
        i = harmonics%equation(c, a)
        if (i > 0) band(harmonics%width + 1, i) = band(harmonics%width + 1, i) + harmonics%spring(c, a)
      end do
    end do
    if (k > 1) return
    do a = 1, 2
      i = harmonics%anchor(a, k)
      if (i > 0) band(harmonics%width + 1, i) = 2*band(harmonics%width + 1, i)
    end do
  contains
    !> Add the 3 x 3 block between two nodes of cell c, folded into the first sector.
    subroutine add_block(row, column, even, odd)
      integer, intent(in) :: row, column
      real(dp), intent(in) :: even, odd
      real(dp) :: factor
      integer :: p, q, r, s
      do s = 1, 3
        q = harmonics%equation(s, list(column))
        do r = 1, 3
          p = harmonics%equation(r, list(row))
          if (p == 0 .or. q < p) cycle
          factor = even
          if (r == 2 .and. s /= 2) factor = odd
          if (r /= 2 .and. s == 2) factor = -odd
          band(harmonics%width + 1 + p - q, q) = band(harmonics%width + 1 + p - q, q) + &
            factor*harmonics%ke(3*row - 3 + r, 3*column - 3 + s, c)
        end do
      end do
    end subroutine add_block
  end subroutine assemble_harmonic

  !> Entries of the factors that harmonics 0, stride, ... have or will have.
  pure real(dp) function harmonic_entries(harmonics, stride) result(entries)
    type(harmonics_t), intent(in) :: harmonics  !< body
    integer, intent(in) :: stride               !< 1 or 2
    entries = real(harmonics%width + 1, dp)*harmonics%dofs*(harmonics%sectors/2/stride + 1)
  end function harmonic_entries

  !> Displacements under some nodal forces; fixed dofs get 0. One side is transformed row by row, which keeps its bits: several rows
  !> at once are summed in another order.
  subroutine solve_body(harmonics, stride, f, u, error)
    type(harmonics_t), intent(in) :: harmonics        !< factorised for this stride
    integer, intent(in) :: stride                     !< 2: the forces repeat after half a turn
    real(dp), intent(in) :: f(:, :, :)                !< nodal forces of the body (3, nodes, sides) [N]
    real(dp), intent(out) :: u(:, :, :)               !< displacements (3, nodes, sides) [m]
    type(error_t), allocatable, intent(out) :: error  !< memory
    type(rows_plan_t) :: forward, backward
    type(fft_plan_t) :: one, other
    real(dp), allocatable :: field(:, :), line(:)
    complex(dp), allocatable :: wave(:, :, :), spectrum(:)
    integer :: a, d, m, n, s, single, many
    n = harmonics%sectors/stride
    m = size(harmonics%equation, 2)
    single = merge(m, 0, size(f, 3) == 1)  ! nodes that are transformed one by one,
    many = merge(0, size(f, 3), size(f, 3) == 1)  ! sides that are transformed whole
    allocate (wave(3*m, 0:n/2, size(f, 3)), line(n), spectrum(0:n/2))
    if (many == 0) then
      call plan_forward_real(n, 1, line, spectrum, one, error)
      if (.not. allocated(error)) call plan_backward_real(n, 1, spectrum, line, other, error)
    else
      allocate (field(3*m, n))
      call plan_rows(n, 3*m, field, wave, forward, backward, error)
    end if
    if (allocated(error)) return
    deallocate (line, spectrum)
    do s = 1, many
      field = reshape(f(:, :n*m, s), shape(field))
      call execute_rows(forward, n, field, wave(:, :, s), .true.)
    end do
    !$omp parallel private(line, spectrum, a, d) if(harmonics%dofs*n*size(f, 3) > long_loop)
    allocate (line(n), spectrum(0:n/2))
    !$omp do schedule(static)
    do a = 1, single
      do d = 1, 3
        if (harmonics%equation(d, a) == 0) cycle
        line = f(d, a:(n - 1)*m + a:m, 1)
        call execute_forward_real(one, line, spectrum)
        wave(3*a - 3 + d, :, 1) = spectrum
      end do
    end do
    !$omp end do
    call solve_harmonics(harmonics, stride, n, wave)
    !$omp do schedule(static)
    do a = 1, single
      do d = 1, 3
        if (harmonics%equation(d, a) == 0) then
          u(d, a::m, 1) = 0
          cycle
        end if
        spectrum = wave(3*a - 3 + d, :, 1)
        call execute_backward_real(other, spectrum, line)
        u(d, a:n*m:m, 1) = line
        if (stride == 2) u(d, n*m + a::m, 1) = line
      end do
    end do
    !$omp end do
    !$omp end parallel
    do s = 1, many
      call execute_rows(backward, n, field, wave(:, :, s), .false.)
      u(:, :n*m, s) = reshape(field, [3, n*m])
      if (stride == 2) u(:, n*m + 1:, s) = u(:, :n*m, s)
    end do
    call free_rows(forward)
    call free_rows(backward)
    call free_plan(one)
    call free_plan(other)
  end subroutine solve_body

  !> Amplitudes of displacements from those of forces, by harmonic; threads of one team share the harmonics.
  subroutine solve_harmonics(harmonics, stride, n, wave)
    type(harmonics_t), intent(in) :: harmonics        !< factorised for this stride
    integer, intent(in) :: stride, n                  !< as of solve_body, sectors that are solved
    complex(dp), intent(inout) :: wave(:, 0:, :)      !< spectra, then those of the displacements (3 nodes, n/2 + 1, sides)
    complex(dp) :: factor, phase(size(harmonics%equation, 2))
    real(dp) :: c(harmonics%dofs, 2*size(wave, 3))
    integer :: a, d, e, k, m, s
    m = size(phase)
    !$omp do schedule(static)
    do k = 0, n/2
      do a = 1, m  ! the nodes of a sector share their angle
        phase(a) = phase(max(1, a - 1))
        if (a > 1) then
          if (.not. abs(harmonics%angle(a) - harmonics%angle(a - 1)) > 0) cycle
        end if
        phase(a) = amplitude(k*stride, harmonics%angle(a), 1)
      end do
      do s = 1, size(wave, 3)
        do a = 1, m
          do d = 1, 3
            e = harmonics%equation(d, a)
            if (e == 0) cycle
            factor = conjg(phase(a))*wave(3*a - 3 + d, k, s)
            if (d == 2) factor = (0._dp, -1._dp)*factor
            c(e, 2*s - 1) = real(factor)
            c(e, 2*s) = aimag(factor)
          end do
        end do
      end do
      call solve_band(harmonics%factor(k*stride)%a, c)
      do s = 1, size(wave, 3)
        do a = 1, m
          do d = 1, 3
            e = harmonics%equation(d, a)
            wave(3*a - 3 + d, k, s) = 0
            if (e == 0) cycle
            factor = phase(a)*cmplx(c(e, 2*s - 1), c(e, 2*s), dp)/n
            if (d == 2) factor = (0._dp, 1._dp)*factor
            wave(3*a - 3 + d, k, s) = factor
          end do
        end do
      end do
    end do
    !$omp end do
  end subroutine solve_harmonics

  !> Compliance of face nodes for one harmonic, between real amplitudes.
  subroutine face_compliance(harmonics, nodes, k, hat)
    type(harmonics_t), intent(in) :: harmonics  !< factorised for this harmonic
    integer, intent(in) :: nodes(:)             !< face nodes of the first sector
    integer, intent(in) :: k                    !< harmonic
    real(dp), intent(out) :: hat(:, :)          !< (3 nodes, 3 nodes) [m/N]
    real(dp), allocatable :: part(:, :)
    integer, allocatable :: at(:)
    integer :: eq(3*size(nodes)), dof(0:harmonics%dofs), i
    eq = reshape(harmonics%equation(:, nodes), [3*size(nodes)])
    dof = 0
    dof(eq) = [(i, i=1, size(eq))]
    at = pack(dof(1:), dof(1:) > 0)
    allocate (part(size(at), size(at)))
    call part_of_inverse(harmonics%factor(k)%a, eq(at), part)
    hat = 0
    hat(at, at) = part
  end subroutine face_compliance
end module hd_harmonics
