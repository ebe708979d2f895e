! SPDX-License-Identifier: GPL-3.0-or-later
!> What the models say of S over a window of lags: ln S per G^(2(D-2)) as a function of D, tabulated and interpolated.
module hd_expectation
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  use hd_band_integral, only: band_integral, paper_constant, kind_isotropic, kind_profile
  use hd_observation, only: observation_t
  use hd_wave_sum, only: ridges_t, wave_numbers, levels_of, wave_expectation
  implicit none
  private
  public :: band_spectrum_t, expectation_t, new_expectation, expected_log, check_spectrum, d_lowest, d_highest
  public :: model_isotropic, model_profile, model_ridges, model_paper, model_spectrum

  integer, parameter :: model_isotropic = kind_isotropic  !< continuous band of a map whose spectrum has lines
  integer, parameter :: model_profile = kind_profile      !< the same of a line (Eq. 2)
  integer, parameter :: model_ridges = 3                  !< the exact sum of Eq. 1
  integer, parameter :: model_paper = 4                   !< power law with the literature's constant
  integer, parameter :: model_spectrum = 5                !< nothing is known: the spectrum is fitted, not S
  real(dp), parameter :: d_lowest = 2.002_dp, d_highest = 2.998_dp   !< range searched
  integer, parameter :: nodes = 126

  !> The model and what it knows of the surface.
  type :: band_spectrum_t
    integer :: model = model_isotropic      !< one of model_*
    real(dp) :: f_lo = 0, f_hi = 0          !< band [1/m], for isotropic and profile
    type(ridges_t) :: ridges = ridges_t()   !< the sum, for ridges (gamma also for paper)
  end type band_spectrum_t

  !> ln S per G^(2(D-2)) over D.
  type :: expectation_t
    real(dp), allocatable :: v(:, :)        !< (lags, nodes)
  end type expectation_t

contains

  !> The numbers of a spectrum make sense.
  subroutine check_spectrum(p, error)
    type(band_spectrum_t), intent(in) :: p                 !< model
    type(error_t), allocatable, intent(out) :: error  !< which number is wrong
    if ((p%model == model_ridges .or. p%model == model_paper) .and. .not. p%ridges%gamma > 1) then
      call raise(error, code_input, 'gamma = '//to_text(p%ridges%gamma)//': the frequency ratio must be > 1')
    else if (p%model == model_ridges .and. .not. (p%ridges%count >= 1 .and. p%ridges%n_max >= 0 .and. p%ridges%length > 0)) then
      call raise(error, code_input, 'ridges: M >= 1, n_max >= 0 (L_s <= L) and L > 0 are needed, got M = '// &
        to_text(p%ridges%count)//', n_max = '//to_text(p%ridges%n_max)//', L = '//to_text(p%ridges%length)//' m')
    else if (.not. (p%f_lo > 0 .and. p%f_hi > p%f_lo)) then
      call raise(error, code_input, 'band '//to_text(p%f_lo)//' to '//to_text(p%f_hi)// &
        ' 1/m: both must be positive, the second larger')
    end if
  end subroutine check_spectrum

  !> Tabulate a model for an observation.
  function new_expectation(o, p) result(e)
    type(observation_t), intent(in) :: o    !< geometry and lags
    type(band_spectrum_t), intent(in) :: p       !< model
    type(expectation_t) :: e
    real(dp), allocatable :: waves(:, :), f(:), w(:)
    real(dp) :: d, s(size(o%lag))
    integer :: i
    allocate (e%v(size(o%lag), nodes))
    if (p%model == model_ridges) then
      call ridge_table(o, p%ridges, waves)
    else if (p%model /= model_paper .and. o%levelled) then
      call levelling_table(o, p, waves, f, w)
    end if
    !$omp parallel do private(d, s)
    do i = 1, nodes
      d = d_lowest + (i - 1) * (d_highest - d_lowest) / (nodes - 1)
      select case (p%model)
      case (model_ridges)
        s = matmul(waves, levels_of(p%ridges, d))
      case (model_paper)
        s = paper_constant(d, p%ridges%gamma) * o%tau**(6 - 2 * d)
      case default
        s = band_integral(p%model, d, o%tau, p%f_lo, p%f_hi)
        if (allocated(waves)) s = s + matmul(waves, w * f**(2 * d - 6))
      end select
      e%v(:, i) = log(s)
    end do
  end function new_expectation

  !> ln S per G^(2(D-2)) at the lags.
  pure function expected_log(e, d) result(v)
    type(expectation_t), intent(in) :: e    !< table
    real(dp), intent(in) :: d               !< fractal dimension D
    real(dp) :: v(size(e%v, 1)), x
    integer :: i
    x = (d - d_lowest) / (d_highest - d_lowest) * (nodes - 1)
    i = min(max(int(x), 1), nodes - 3)
    x = x - i
    v = e%v(:, i) * (-x * (x - 1) * (x - 2) / 6) + e%v(:, i + 1) * ((x + 1) * (x - 1) * (x - 2) / 2) &
      + e%v(:, i + 2) * (-(x + 1) * x * (x - 2) / 2) + e%v(:, i + 3) * ((x + 1) * x * (x - 1) / 6)
  end function expected_log

  !> What unit waves of each frequency add, summed over the ridges (lags, n_max + 1).
  subroutine ridge_table(o, r, table)
    type(observation_t), intent(in) :: o                !< geometry and lags
    type(ridges_t), intent(in) :: r                     !< the sum
    real(dp), allocatable, intent(out) :: table(:, :)   !< (lags, frequencies)
    real(dp), allocatable :: qx(:), qy(:)
    real(dp) :: s(size(o%lag))
    integer :: j, n
    call wave_numbers(r, qx, qy)
    allocate (table(size(o%lag), r%n_max + 1), source=0._dp)
    do j = 1, size(qx)
      n = mod(j - 1, r%n_max + 1) + 1
      call wave_expectation(o, qx(j), qy(j), s)
      table(:, n) = table(:, n) + s
    end do
  end subroutine ridge_table

  !> What levelling takes from unit waves, mean over directions, on a grid of frequencies with its weights in ln f.
  subroutine levelling_table(o, p, table, f, w)
    type(observation_t), intent(in) :: o                !< geometry and lags
    type(band_spectrum_t), intent(in) :: p                   !< band
    real(dp), allocatable, intent(out) :: table(:, :)   !< (lags, frequencies)
    real(dp), allocatable, intent(out) :: f(:), w(:)    !< frequencies [1/m], weights
    integer, parameter :: n = 80, angles = 16
    real(dp), parameter :: most_waves = 30, least_band = 3  !< of a plane: more waves a side, it takes nothing; of f_lo
    type(observation_t) :: raw
    real(dp) :: extent, top, a, with(size(o%lag)), without(size(o%lag))
    integer :: i, j, m
    extent = (o%nx - 1) * o%dx
    if (o%ny > 1) extent = min(extent, (o%ny - 1) * o%dy)
    top = min(p%f_hi, max(most_waves / extent, least_band * p%f_lo))
    f = [(p%f_lo * (top / p%f_lo)**(real(i - 1, dp) / (n - 1)), i=1, n)]
    allocate (w(n), source=log(top / p%f_lo) / (n - 1))
    w([1, n]) = w(1) / 2
    allocate (table(size(o%lag), n), source=0._dp)
    raw = o
    raw%levelled = .false.
    m = merge(1, angles, p%model == model_profile)
    !$omp parallel do private(j, a, with, without)
    do i = 1, n
      do j = 1, m
        a = merge(0._dp, (j - 0.5_dp) * pi / (2 * m), m == 1)
        call wave_expectation(o, 2 * pi * f(i) * cos(a), 2 * pi * f(i) * sin(a), with)
        call wave_expectation(raw, 2 * pi * f(i) * cos(a), 2 * pi * f(i) * sin(a), without)
        table(:, i) = table(:, i) + (with - without) / m
      end do
    end do
  end subroutine levelling_table
end module hd_expectation
