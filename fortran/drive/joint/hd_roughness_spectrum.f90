! SPDX-License-Identifier: GPL-3.0-or-later
!> Roughness power over wavenumber, isotropic, in narrow bands: of the continuum behind Eq. 1, or of a measured spectrum.
!>
!> With C(q) the two-dimensional spectrum, h_rms^2 = 2 pi int q C dq. Eq. 1 in the continuum has
!> C(q) = G^(2(D-2)) f^(-a-2) / (16 pi^3), q = 2 pi f, a = 2(3-D), 1/L <= f <= 1/L_s.
module hd_roughness_spectrum
  use hd_kinds, only: dp, pi, hair
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  implicit none
  private
  public :: power_spectrum_t, fractal_spectrum, sampled_spectrum

  integer, parameter :: per_octave = 64  !< bands

  type :: power_spectrum_t
    real(dp), allocatable :: q(:)        !< wavenumber in the middle of each band, rising [1/m]
    real(dp), allocatable :: height(:)   !< variance of the heights in it [m^2]
    real(dp), allocatable :: mean(:)     !< sum of |q| times variance: twice the elastic energy of full contact is E*/2 of it [m]
    real(dp), allocatable :: slope(:)    !< variance of the gradient
    real(dp), allocatable :: waves(:)    !< waves of it on an area [1/m^2]
  end type power_spectrum_t

contains

  !> Spectrum of Eq. 1 in the continuum.
  subroutine fractal_spectrum(d, g, longest, shortest, spectrum, error)
    real(dp), intent(in) :: d                         !< fractal dimension, 2 < D < 3
    real(dp), intent(in) :: g                         !< roughness G [m]
    real(dp), intent(in) :: longest, shortest         !< wavelengths L and L_s [m]
    type(power_spectrum_t), intent(out) :: spectrum         !< spectrum
    type(error_t), allocatable, intent(out) :: error  !< out of range
    real(dp), allocatable :: f(:)
    real(dp) :: a
    integer :: i, n
    if (.not. (d > 2 .and. d < 3 .and. g > 0)) then
      call raise(error, code_input, 'fractal_dimension is '//to_text(d)//' and roughness '//to_text(g)//' m; valid: '// &
        '2 < D < 3, G > 0')
    else if (.not. (shortest > 0 .and. longest > shortest)) then
      call raise(error, code_input, 'shortest_wavelength is '//to_text(shortest)//' m; valid: above 0 and below sample_length, '// &
        to_text(longest)//' m')
    end if
    if (allocated(error)) return
    n = max(2, ceiling(per_octave*log(longest/shortest)/log(2._dp)))
    f = [(exp(log(longest/shortest)*i/n)/longest, i=0, n)]
    a = 2*(3 - d)
    spectrum%q = pi*(f(:n) + f(2:))
    spectrum%height = moment(-a)
    spectrum%mean = 2*pi*moment(1 - a)
    spectrum%slope = (2*pi)**2*moment(2 - a)
    spectrum%waves = pi*(f(2:)**2 - f(:n)**2)
  contains
    !> G^(2(D-2))/2 int f^(e-1) df over the bands.
    pure function moment(e) result(m)
      real(dp), intent(in) :: e  !< exponent
      real(dp) :: m(n)
      if (abs(e) < hair) then
        m = log(f(2:)/f(:n))
      else
        m = (f(2:)**e - f(:n)**e)/e
      end if
      m = 0.5_dp*g**(2*(d - 2))*m
    end function moment
  end subroutine fractal_spectrum

  !> Spectrum from the variance of the heights in bands about given wavenumbers.
  subroutine sampled_spectrum(q, height, spectrum, error)
    real(dp), intent(in) :: q(:)                      !< rising, > 0 [1/m]
    real(dp), intent(in) :: height(:)                 !< >= 0, not all 0 [m^2]
    type(power_spectrum_t), intent(out) :: spectrum         !< spectrum
    type(error_t), allocatable, intent(out) :: error  !< not rising, negative, empty
    real(dp), allocatable :: edge(:)
    integer :: n
    n = size(q)
    if (n < 2) then
      call raise(error, code_input, 'the spectrum has '//to_text(n)//' bands; valid: 2 or more')
    else if (.not. (q(1) > 0 .and. all(q(2:) > q(:n - 1)))) then
      call raise(error, code_input, 'wavenumbers of the spectrum from '//to_text(q(1))//' to '//to_text(q(n))// &
        ' 1/m; valid: above 0, each larger than the one before')
    else if (.not. (all(height >= 0) .and. sum(height) > 0 .and. sum(height) < huge(1._dp))) then
      call raise(error, code_input, 'variances of the spectrum from '//to_text(minval(height))//' to '// &
        to_text(maxval(height))//' m^2; valid: 0 or more, finite, not all 0')
    end if
    if (allocated(error)) return
    spectrum%q = q
    spectrum%height = height
    spectrum%mean = q*height
    spectrum%slope = q**2*height
    edge = sqrt(q(2:)*q(:n - 1))
    edge = [q(1)**2/edge(1), edge, q(n)**2/edge(n - 1)]
    spectrum%waves = (edge(2:)**2 - edge(:n)**2)/(4*pi)
  end subroutine sampled_spectrum
end module hd_roughness_spectrum
