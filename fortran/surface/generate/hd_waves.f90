! SPDX-License-Identifier: GPL-3.0-or-later
!> The plane waves of the Weierstrass-Mandelbrot surface (Eq. 1) and profile (Eq. 2).
!>
!> z(x, y) = sum over m = 1..M, n = 0..n_max of B_n [cos(phi_mn) - cos(2 pi g^n (x cos a_m + y sin a_m) / L + phi_mn)],
!> B_n = sqrt(ln g / M) G^(D-2) (L / g^n)^(3-D), a_m = pi m / M, n_max = floor(ln(L / L_s) / ln g). The printed
!> arctan(y / x) in place of the projection on a_m tears the surface at x < 0. Eq. 2 is M = 1.
module hd_waves
  use hd_kinds, only: dp, qp, i8
  use hd_error, only: error_t, raise, code_input, code_memory
  use hd_random, only: uniforms
  use hd_wave_kernels, only: exact_products, turns_at_point, cosines
  use hd_text, only: to_text
  implicit none
  private
  public :: spectrum_t, waves_t, grid_t, new_waves, free_waves, count_waves, turns_on_grid, split_turns, checked_grid

  !> Parameters of Eq. 1.
  type :: spectrum_t
    real(dp) :: fractal_dimension = 2.5_dp  !< D in (2, 3)
    real(dp) :: roughness = 1e-9_dp         !< G [m]
    real(dp) :: gamma = 1.5_dp              !< frequency ratio > 1
    real(dp) :: length = 1e-3_dp            !< L, longest wavelength [m]
    real(dp) :: shortest = 1e-6_dp          !< L_s, shortest wavelength [m]
    integer :: ridges = 10                  !< M
    integer(i8) :: seed = 0                 !< seed of the phases
  end type spectrum_t

  !> Waves: height = offset - sum of amplitude cos(2 pi (fx x + fy y + phase)).
  type :: waves_t
    real(dp), allocatable :: fx(:), fy(:)      !< wave numbers [1/m] ...
    real(dp), allocatable :: fx_2(:), fy_2(:)  !< ... and their next 53 bits: x fx may be many turns
    real(dp), allocatable :: amplitude(:)      !< amplitudes [m]
    real(dp), allocatable :: phase(:)          !< phases [turns]
    integer, allocatable :: group(:)           !< waves of one group have the same |fx|
    integer :: groups = 0                      !< number of groups
    real(dp) :: offset = 0                     !< constant height [m]
  end type waves_t

  !> Points x = x_0 + (i - 1) dx, i = 1..nx; y likewise.
  type :: grid_t
    integer :: nx = 1, ny = 1                  !< number of points
    real(dp) :: dx = 1, dy = 1                 !< spacings [m]
    real(dp) :: x_0 = 0, y_0 = 0               !< first point [m]
  end type grid_t

  integer, parameter :: most_points = 8388608   !< each way, 2^23: up to there multiples of split turns are exact
  integer(i8), parameter :: most_waves = 100000000_i8

contains

  !> n_max and the number of waves J = M (n_max + 1), after every parameter is checked.
  subroutine count_waves(s, n_max, count, error)
    type(spectrum_t), intent(in) :: s                 !< parameters
    integer, intent(out) :: n_max                     !< largest exponent
    integer(i8), intent(out) :: count                 !< number of waves
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    real(dp), parameter :: rounding = 1e-9_dp  !< of a band of whole octaves of gamma
    real(dp) :: exponent
    n_max = 0
    count = 0
    if (.not. (s%fractal_dimension > 2 .and. s%fractal_dimension < 3)) then
      call raise(error, code_input, 'fractal_dimension = '//to_text(s%fractal_dimension)//': must lie between 2 and 3')
    else if (.not. (s%roughness > 0 .and. s%roughness <= huge(1._dp))) then
      call raise(error, code_input, 'roughness = '//to_text(s%roughness)//' m: must be positive and finite')
    else if (.not. (s%gamma > 1 .and. s%gamma <= huge(1._dp))) then
      call raise(error, code_input, 'gamma = '//to_text(s%gamma)//': must be above 1 and finite')
    else if (.not. (s%length > 0 .and. s%length <= huge(1._dp))) then
      call raise(error, code_input, 'length = '//to_text(s%length)//' m: must be positive and finite')
    else if (.not. s%shortest > 0) then
      call raise(error, code_input, 'shortest_wavelength = '//to_text(s%shortest)//' m: must be positive')
    else if (s%shortest > s%length) then
      call raise(error, code_input, 'shortest_wavelength = '//to_text(s%shortest)//' m: must not exceed the length '// &
        to_text(s%length)//' m')
    else if (s%ridges < 1) then
      call raise(error, code_input, 'ridges = '//to_text(s%ridges)//': must be at least 1')
    end if
    if (allocated(error)) return
    exponent = (log(s%length) - log(s%shortest)) / log(s%gamma) + rounding
    if (exponent >= real(most_waves, dp) / s%ridges) then
      call raise(error, code_input, 'n_max = ln(length / shortest_wavelength) / ln(gamma) = '//to_text(exponent)// &
        ' makes more than '//to_text(most_waves)//' waves: take a larger gamma or shortest_wavelength')
      return
    end if
    n_max = floor(exponent)
    count = s%ridges * (n_max + 1_i8)
  end subroutine count_waves

  !> The waves of a surface [Eq. 1, 2]; counter of a phase: (n, m), so that a shorter L_s adds waves and keeps the others.
  !> Amplitudes are made in quadruple precision: what logarithms of other systems differ by is rounded away.
  subroutine new_waves(s, w, error)
    type(spectrum_t), intent(in) :: s                 !< parameters
    type(waves_t), intent(out) :: w                   !< waves
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    real(qp), allocatable :: cosine(:), sine(:)
    real(dp), allocatable :: c(:), c_2(:), s_1(:), s_2(:), cosine_phase(:)
    real(qp) :: f, b_0, ratio
    real(dp) :: f_1, f_2
    integer(i8) :: count
    integer :: n_max, n, m, j, status
    call count_waves(s, n_max, count, error)
    if (allocated(error)) return
    allocate (w%fx(count), w%fy(count), w%fx_2(count), w%fy_2(count), w%amplitude(count), w%phase(count), w%group(count), &
      stat=status)
    if (status /= 0) then
      call raise(error, code_memory, 'not enough memory for '//to_text(count)//' waves')
      return
    end if
    call directions(s%ridges, cosine, sine)
    c = real(cosine, dp)
    c_2 = real(cosine - c, dp)
    s_1 = real(sine, dp)
    s_2 = real(sine - s_1, dp)
    ratio = exp(log(real(s%gamma, qp)) * (real(s%fractal_dimension, qp) - 3))
    b_0 = sqrt(log(real(s%gamma, qp)) / s%ridges) * s%length * exp(log(s%roughness / real(s%length, qp)) &
      * (real(s%fractal_dimension, qp) - 2))
    !$omp parallel do private(f, f_1, f_2, m, j) schedule(static) if (count > 5000)
    do n = 0, n_max
      f = real(s%gamma, qp)**n / real(s%length, qp)
      f_1 = real(f, dp)
      f_2 = real(f - f_1, dp)
      j = n * s%ridges
      call uniforms(s%seed, spread(int(n, i8), 1, s%ridges), [(int(m, i8), m=1, s%ridges)], w%phase(j + 1:j + s%ridges))
      call exact_products(s%ridges, f_1, f_2, c, c_2, w%fx(j + 1), w%fx_2(j + 1))
      call exact_products(s%ridges, f_1, f_2, s_1, s_2, w%fy(j + 1), w%fy_2(j + 1))
      w%amplitude(j + 1:j + s%ridges) = real(b_0 * ratio**n, dp)
      do m = 1, s%ridges
        j = n * s%ridges + m
        w%group(j) = n * (s%ridges / 2 + 1) + min(m, s%ridges - m) + 1
        if (2 * m == s%ridges) w%group(j) = s%ridges / 2 + 1       ! fx = 0 for every n
      end do
    end do
    call number_groups(w)
    allocate (cosine_phase(count))
    call cosines(int(count), w%phase, cosine_phase)
    w%offset = sum(w%amplitude * cosine_phase)
  end subroutine new_waves

  !> cos and sin of pi m / M, m = 1..M, exactly symmetric about pi / 2 (even M: about pi / 4). Those of one angle turn into the rest
  !> by sums and products, some 2 sqrt(M) for each.
  subroutine directions(ridges, cosine, sine)
    integer, intent(in) :: ridges                                 !< M
    real(qp), allocatable, intent(out) :: cosine(:), sine(:)      !< (M)
    real(qp), parameter :: pi_q = 3.14159265358979323846264338327950288419716939937510_qp
    complex(qp), allocatable :: near(:)
    complex(qp) :: far
    integer :: m, last
    allocate (cosine(ridges), sine(ridges))
    last = merge(ridges / 4, (ridges - 1) / 2, mod(ridges, 2) == 0)
    allocate (near(0:max(1, nint(sqrt(real(last))))))
    near(0) = 1
    near(1) = small_turn(pi_q / ridges)
    do m = 2, ubound(near, 1)
      near(m) = near(m - 1) * near(1)
    end do
    far = 1
    do m = 1, last
      if (mod(m, ubound(near, 1)) == 0) far = far * near(ubound(near, 1))
      cosine(m) = real(far * near(mod(m, ubound(near, 1))), qp)
      sine(m) = aimag(far * near(mod(m, ubound(near, 1))))
    end do
    do m = last + 1, (ridges - 1) / 2
      cosine(m) = sine(ridges / 2 - m)
      sine(m) = cosine(ridges / 2 - m)
    end do
    do m = 1, (ridges - 1) / 2
      cosine(ridges - m) = -cosine(m)
      sine(ridges - m) = sine(m)
    end do
    if (mod(ridges, 2) == 0) cosine(ridges / 2) = 0
    if (mod(ridges, 2) == 0) sine(ridges / 2) = 1
    cosine(ridges) = -1
    sine(ridges) = 0
  end subroutine directions

  !> exp(i angle), angle up to pi / 3, by its series.
  pure complex(qp) function small_turn(angle)
    real(qp), intent(in) :: angle    !< angle [rad]
    real(qp) :: c, s
    integer :: k
    c = 1
    s = 1
    do k = 32, 2, -2
      c = 1 - angle**2 / (k * (k - 1)) * c
      s = 1 - angle**2 / (k * (k + 1)) * s
    end do
    small_turn = cmplx(c, angle * s, qp)
  end function small_turn

  !> Number the groups without gaps.
  subroutine number_groups(w)
    type(waves_t), intent(inout) :: w    !< waves
    integer, allocatable :: number(:)
    integer :: j
    allocate (number(maxval(w%group)), source=0)
    w%groups = 0
    do j = 1, size(w%group)
      if (number(w%group(j)) == 0) then
        w%groups = w%groups + 1
        number(w%group(j)) = w%groups
      end if
      w%group(j) = number(w%group(j))
    end do
  end subroutine number_groups

  !> Any waves, given one by one.
  subroutine free_waves(fx, fy, amplitude, phase, w)
    real(dp), intent(in) :: fx(:), fy(:)    !< wave numbers [1/m]
    real(dp), intent(in) :: amplitude(:)    !< amplitudes [m]
    real(dp), intent(in) :: phase(:)        !< phases [turns]
    type(waves_t), intent(out) :: w         !< waves; no offset
    integer :: j
    w%fx = fx
    w%fy = fy
    w%fx_2 = 0 * fx
    w%fy_2 = 0 * fy
    w%amplitude = amplitude
    w%phase = phase
    w%group = [(j, j=1, size(fx))]
    w%groups = size(fx)
  end subroutine free_waves

  !> Refuse a grid without extent.
  subroutine checked_grid(g, error)
    type(grid_t), intent(in) :: g                     !< grid
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    if (g%nx < 1 .or. g%ny < 1) then
      call raise(error, code_input, 'grid of '//to_text(g%nx)//' x '//to_text(g%ny)//' points: needs at least one point each way')
    else if (.not. (g%dx > 0 .and. g%dx <= huge(1._dp) .and. g%dy > 0 .and. g%dy <= huge(1._dp))) then
      call raise(error, code_input, 'spacing = '//to_text(g%dx)//', '//to_text(g%dy)//' m: must be positive and finite')
    else if (.not. (abs(g%x_0) <= huge(1._dp) .and. abs(g%y_0) <= huge(1._dp))) then
      call raise(error, code_input, 'origin = '//to_text(g%x_0)//', '//to_text(g%y_0)//' m: must be finite')
    else if (max(g%nx, g%ny) > most_points) then
      call raise(error, code_input, 'grid of '//to_text(g%nx)//' x '//to_text(g%ny)//' points: at most '// &
        to_text(most_points)//' each way')
    end if
  end subroutine checked_grid

  !> Turns per point, reduced to [-1, 1] so that half of them is still right, in two parts; and the phase at a point (ix, iy)
  !> (from 0, may lie between points), reduced to [-1/2, 1/2].
  subroutine turns_on_grid(w, g, ix, iy, ux, ux_2, uy, uy_2, phase)
    type(waves_t), intent(in) :: w                            !< waves
    type(grid_t), intent(in) :: g                             !< grid
    real(dp), intent(in) :: ix, iy                            !< point of reference
    real(dp), intent(out), dimension(size(w%fx)) :: ux, ux_2, uy, uy_2    !< turns per point and their rest (J)
    real(dp), intent(out) :: phase(size(w%fx))                            !< phase there [turns] (J)
    integer, parameter :: share = 5000
    real(dp) :: x, x_2, y, y_2
    integer :: j
    x = real(g%x_0 + ix * real(g%dx, qp), dp)
    x_2 = real(g%x_0 + ix * real(g%dx, qp) - x, dp)
    y = real(g%y_0 + iy * real(g%dy, qp), dp)
    y_2 = real(g%y_0 + iy * real(g%dy, qp) - y, dp)
    !$omp parallel do schedule(static) if (size(phase) > 4 * share)
    do j = 1, size(phase), share
      call turns_at_point(min(share, size(phase) - j + 1), w%fx(j), w%fx_2(j), w%fy(j), w%fy_2(j), w%phase(j), g%dx, g%dy, &
        x, x_2, y, y_2, ux(j), ux_2(j), uy(j), uy_2(j), phase(j))
    end do
  end subroutine turns_on_grid

  !> Nearest whole number, for sizes below 2^51: unlike anint a few operations that compilers vectorise.
  elemental real(dp) function rounded(x)
    real(dp), intent(in) :: x    !< number
    rounded = (x + 6755399441055744._dp) - 6755399441055744._dp
  end function rounded

  !> Turns as a multiple of 2^-29 and the rest, so that whole multiples up to 2^23 of the first part are exact.
  elemental subroutine split_turns(u, u_2, high, low)
    real(dp), intent(in) :: u, u_2         !< turns, at most 1, in two parts
    real(dp), intent(out) :: high, low     !< u = high + low
    high = rounded(u * 536870912._dp) / 536870912._dp
    low = (u - high) + u_2
  end subroutine split_turns
end module hd_waves
