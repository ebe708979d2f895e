! SPDX-License-Identifier: GPL-3.0-or-later
!> Periodic surface with the continuum spectrum of Eq. 1, for half-space contact codes: FFT synthesis, random phases.
!>
!> The waves of Eq. 1 lie d(ln f) = ln(gamma) apart on each ridge, so many ridges carry the height variance
!> G^(2(D-2)) f^(-a-1) / 2 per unit frequency, a = 2 (3 - D), spread evenly over all directions: G^(2(D-2)) f^(-a-2) / (4 pi) per
!> unit area of the frequency plane. Each mode of the period within 1/length <= |q| <= 1/shortest gets that density at q.
module hd_periodic
  use hd_kinds, only: dp, i8, pi, hair
  use hd_error, only: error_t, raise, code_input, code_memory
  use hd_fft, only: backward_real_2d
  use hd_memory, only: need_memory
  use hd_random, only: uniforms
  use hd_text, only: to_text
  implicit none
  private
  public :: periodic_surface, check_periodic

contains

  !> Refuse what cannot be synthesised.
  subroutine check_periodic(n, length, fractal_dimension, roughness, shortest, error)
    integer, intent(in) :: n                          !< points per side
    real(dp), intent(in) :: length                    !< period [m]
    real(dp), intent(in) :: fractal_dimension         !< D in (2, 3)
    real(dp), intent(in) :: roughness                 !< G [m]
    real(dp), intent(in) :: shortest                  !< shortest wavelength [m]
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    real(dp) :: mb
    if (n < 2) then
      call raise(error, code_input, 'n = '//to_text(n)//': a periodic surface needs at least 2 points per side')
    else if (.not. (length > 0 .and. length <= huge(length))) then
      call raise(error, code_input, 'length = '//to_text(length)//' m: must be positive and finite')
    else if (.not. (fractal_dimension > 2 .and. fractal_dimension < 3)) then
      call raise(error, code_input, 'fractal_dimension = '//to_text(fractal_dimension)//': must lie between 2 and 3')
    else if (.not. (roughness > 0 .and. roughness <= huge(roughness))) then
      call raise(error, code_input, 'roughness = '//to_text(roughness)//' m: must be positive and finite')
    else if (.not. shortest <= length) then
      call raise(error, code_input, 'shortest_wavelength = '//to_text(shortest)//' m: must not exceed the length '// &
        to_text(length)//' m')
    else if (.not. shortest * n >= 2 * length * (1 - hair)) then
      call raise(error, code_input, 'shortest_wavelength = '//to_text(shortest)//' m: must be at least two spacings, '// &
        to_text(2 * length / n)//' m; take a longer one or more points')
    end if
    if (allocated(error)) return
    mb = 16 * real(n, dp)**2 / 1048576
    call need_memory('a periodic surface of '//to_text(n)//' x '//to_text(n)//' points', mb, error)
  end subroutine check_periodic

  !> Heights [m] with mean zero at the points (i - 1) length / n. A seed gives the same surface at every n.
  subroutine periodic_surface(length, fractal_dimension, roughness, shortest, seed, heights, error)
    real(dp), intent(in) :: length                        !< period [m]
    real(dp), intent(in) :: fractal_dimension             !< D in (2, 3)
    real(dp), intent(in) :: roughness                     !< G [m]
    real(dp), intent(in) :: shortest                      !< shortest wavelength [m], at least two spacings
    integer(i8), intent(in) :: seed                       !< seed of the phases
    real(dp), intent(inout), contiguous :: heights(:, :)  !< heights (n, n) [m]
    type(error_t), allocatable, intent(out) :: error      !< bad input or no memory
    complex(dp), allocatable :: s(:, :)
    integer(i8), allocatable :: ki(:), kj(:)
    real(dp), allocatable :: u(:)
    real(dp) :: amplitude, phase
    integer :: n, i, j, status
    n = size(heights, 1)
    call check_periodic(n, length, fractal_dimension, roughness, shortest, error)
    if (allocated(error)) return
    allocate (s(0:n / 2, 0:n - 1), stat=status)
    if (status /= 0) then
      call raise(error, code_memory, 'not enough memory for the spectrum of '//to_text(n)//' x '//to_text(n)//' points')
      return
    end if
    allocate (ki(0:n / 2), kj(0:n / 2), u(0:n / 2))
    !$omp parallel do private(i, amplitude, phase) firstprivate(ki, kj, u) schedule(static)
    do j = 0, n - 1
      ki = [(i, i=0, n / 2)]
      kj = signed(j, n)
      if (2 * j > n) kj(0) = n - j                       ! (0, -j) is the conjugate of (0, j)
      call uniforms(seed, ki, kj, u)
      do i = 0, n / 2
        s(i, j) = 0
        if (2 * i >= n .or. 2 * j == n) cycle            ! the frequency of Nyquist has no phase
        amplitude = mode_amplitude(i, signed(j, n), length, fractal_dimension, roughness, shortest)
        phase = 2 * pi * u(i)
        if (i == 0 .and. 2 * j > n) phase = -phase
        s(i, j) = amplitude * cmplx(cos(phase), sin(phase), dp)
      end do
    end do
    call backward_real_2d(s, heights, error)
  end subroutine periodic_surface

  !> Modulus of the Fourier coefficient of mode (i, j) [m]; 0 outside the band.
  pure real(dp) function mode_amplitude(i, j, length, fractal_dimension, roughness, shortest) result(c)
    integer, intent(in) :: i, j                                                    !< waves per period along x and y
    real(dp), intent(in) :: length, fractal_dimension, roughness, shortest         !< as above
    real(dp) :: f
    f = sqrt(real(i, dp)**2 + real(j, dp)**2) / length
    c = 0
    if (i == 0 .and. j == 0) return
    if (f * shortest > 1 + hair) return
    c = roughness**(fractal_dimension - 2) * f**(fractal_dimension - 4) / (length * sqrt(4 * pi))
  end function mode_amplitude

  !> Wave number of a row of the spectrum: 0, 1, ..., -1.
  pure integer function signed(j, n)
    integer, intent(in) :: j, n    !< row from 0, number of rows
    signed = merge(j, j - n, 2 * j < n)
  end function signed
end module hd_periodic
