! SPDX-License-Identifier: GPL-3.0-or-later
!> Fit of clean maps that nothing else is known of: holes filled, power over rings of frequency fitted, and the same verdict, D, G
!> and S over the lags as the fits of the structure function have.
module hd_map_fit
  use hd_kinds, only: dp, i8, pi
  use hd_error, only: error_t
  use hd_text, only: to_text, percent, rounded
  use hd_observation, only: observation_t, level_plane
  use hd_band_integral, only: kind_isotropic, kind_profile
  use hd_random_field, only: radial_t, new_radial, field_covariance, noise_covariance
  use hd_cleaning, only: cleaned_t, crop
  use hd_outliers, only: fill_holes, synthetic
  use hd_lay, only: is_lay
  use hd_seams, only: remove_offsets, seams_t
  use hd_ring_table, only: ring_table_t, new_ring_table
  use hd_spectral_fit, only: spectral_fit_t, fit_spectrum, quantile
  use hd_spectral_model, only: shares
  use hd_structure_fit, only: fit_t
  use hd_verdict, only: verdict_t, fractal, not_fractal, noise_dominated, noisy, noisy_estimate, smooth_end, smooth_estimate, &
    determined, bent
  implicit none
  private
  public :: blind_t, fit_blind, judge_blind, name_lay

  integer, parameter :: more_rings = 8        !< above a window, and a factor of frequency,
  real(dp), parameter :: more_band = 1.8_dp   !< that a second power law is looked for in
  real(dp), parameter :: wide = 4             !< highest over lowest frequency of a window from which on the interval says it all
  real(dp), parameter :: least_reach = 2      !< factor of frequency over which a power law must stand out of the noise
  real(dp), parameter :: inside = 0.1_dp      !< distance of a slope from those of D = 2 and D = 3, where filling has no like
  integer, parameter :: patches = 8           !< of the longest step, that a kurtosis is taken over
  integer, parameter :: sure = 5              !< standard errors of a kurtosis that no Gaussian map of this many steps reaches
  real(dp), parameter :: lines = 3            !< scatter of modes of one direction from which on the spectrum is one of lines
  real(dp), parameter :: many_spikes = 0.02_dp !< share of masked points of a map that is called spikes
  real(dp), parameter :: offsets = 3          !< power of an axis over that of its rings from which on rows or columns are offset

  !> What was found besides D and G.
  type :: blind_t
    type(ring_table_t) :: rings               !< power over frequency
    type(spectral_fit_t) :: fit               !< its fit
    type(spectral_fit_t) :: above             !< fit of what lies above the window, if its last ring is not 0
    integer :: holes = 0                      !< points filled, wrong ones among them
    real(dp) :: spike_share = 0               !< wrong points over all
    real(dp), allocatable :: ranges(:, :)     !< D, shortest and longest wavelength [m] of one range, of a crossover two (3, ranges)
    real(dp) :: tail = 0                      !< largest excess kurtosis of second differences, in 5 of its standard errors
    real(dp) :: excess = 0                    !< that kurtosis
    integer :: tail_lag = 0                   !< its step [points]
    integer :: lay = 0                        !< direction of the waves of a lay, 1: x, 2: y; 0: none
    logical :: of_lines = .false.             !< single waves stand out: no continuous spectrum
  end type blind_t

contains

  !> Fit one map, or two that are pressed together (`other` may be empty): both are cropped to the common size.
  subroutine fit_blind(map, other, dx, dy, level, noise, band, b, error)
    type(cleaned_t), intent(inout) :: map, other              !< maps without wrong points; offsets and seams found here are added
    real(dp), intent(in) :: dx, dy                            !< spacing [m]
    logical, intent(in) :: level                              !< take the planes off
    real(dp), intent(in) :: noise                             !< known noise, rms [m]; negative: fitted
    real(dp), intent(in) :: band(2)                           !< window wanted [1/m]; 0: looked for
    type(blind_t), intent(out) :: b                           !< result
    type(error_t), allocatable, intent(out) :: error          !< too small
    type(ring_table_t) :: first, second
    integer :: n(2), last
    n = shape(map%z)
    if (allocated(other%z)) n = min(n, shape(other%z))
    call take_spectrum(map, n, dx, dy, level, b, first, error)
    if (allocated(error)) return
    b%rings = first
    if (allocated(other%z)) then
      call take_spectrum(other, n, dx, dy, level, b, second, error)
      if (allocated(error)) return
      associate (t => b%rings)
        t%m = (t%p + second%p)**2 / (t%p**2 / t%m + second%p**2 / second%m)
        t%scatter = max(t%scatter, second%scatter)
        t%aside = max(t%aside, second%aside)
        t%axis = max(t%axis, second%axis)
        t%p = t%p + second%p
      end associate
    end if
    if (any(b%rings%p <= 0)) return
    if (all(band > 0)) then
      call fit_spectrum(b%rings, noise, b%fit, error, band(1), band(2))
    else
      call fit_spectrum(b%rings, noise, b%fit, error)
      if (allocated(error)) return
      b%of_lines = b%fit%aside > lines
      last = size(b%rings%f)
      if (b%fit%accepted .and. last - b%fit%last > more_rings .and. b%rings%f(last) > more_band * b%fit%f_hi) then
        call fit_spectrum(b%rings, noise, b%above, error, b%fit%f_hi, b%rings%f(last))
        if (allocated(error)) deallocate (error)
      end if
    end if
    if (.not. allocated(error)) call find_ranges(b)
  end subroutine fit_blind

  !> Spectrum of one map.
  subroutine take_spectrum(map, n, dx, dy, level, b, t, error)
    type(cleaned_t), intent(inout) :: map             !< heights without wrong points, cropped; offsets and seams are added
    integer, intent(in) :: n(2)                       !< points of the middle that is kept
    real(dp), intent(in) :: dx, dy                    !< spacing [m]
    logical, intent(in) :: level                      !< take the plane off
    type(blind_t), intent(inout) :: b                 !< holes and tails are added
    type(ring_table_t), intent(out) :: t              !< rings
    type(error_t), allocatable, intent(out) :: error  !< too small
    type(ring_table_t) :: full, filled, raw
    type(seams_t) :: seams
    real(dp), allocatable :: flat(:, :), mock(:, :), kept(:, :)
    logical, allocatable :: hole(:, :)
    real(dp) :: tilt(2), slope, axis(2)
    integer :: k
    b%spike_share = max(b%spike_share, map%spikes / real(size(map%z, kind=i8), dp))
    call crop(map, n)
    flat = map%z
    if (level) call level_plane(flat, tilt)
    hole = .not. abs(flat) <= huge(tilt)
    call fill_holes(flat, [dx, dy], hole)
    b%holes = b%holes + int(count(hole, kind=i8))
    if (level) call level_plane(flat, tilt)
    call new_ring_table(flat, dx, dy, t, error)
    if (allocated(error)) return
    if (any(t%leak > offsets)) then                 ! offsets of rows or columns leak from the axes: take them off
      kept = flat
      raw = t
      seams = map%seams
      axis = t%axis
      do k = 1, 2
        if (t%leak(k) > offsets) call remove_offsets(flat, k, map%seams)
        if (axis(k) <= offsets) map%seams%jitter(k) = 0   ! of a smooth map, whose long waves leak along the axes: no jitter
      end do
      call fill_holes(flat, [dx, dy], hole)
      call new_ring_table(flat, dx, dy, t, error)
      if (allocated(error)) return
      do k = 1, 2
        if (axis(k) > offsets) then
          if (is_lay(kept, k, map%seams, raw, t)) b%lay = k
        end if
      end do
      if (b%lay > 0) then                           ! a lay is part of the surface: it stays
        flat = kept
        t = raw
        map%seams = seams
      else
        t%axis = axis
      end if
    end if
    call heavy_tails(flat, b)
    if (.not. any(hole)) return
    k = max(2, 2 * size(t%f) / 3)                   ! what filling takes from a spectrum like this one
    if (size(t%f) < k .or. any(t%p <= 0)) return
    slope = -log(t%p(k) / t%p(1)) / log(t%f(k) / t%f(1))
    allocate (mock, mold=flat)
    call synthetic(mock, dx, dy, min(max(slope, t%dim + inside), t%dim + 2 - inside), error)
    if (allocated(error)) return
    call new_ring_table(mock, dx, dy, full, error)
    if (allocated(error)) return
    call fill_holes(mock, [dx, dy], hole)
    call new_ring_table(mock, dx, dy, filled, error)
    if (allocated(error)) return
    t%p = t%p * full%p / filled%p
  end subroutine take_spectrum

  !> Largest excess kurtosis of second differences over steps of 1 to 16 points, along rows and columns: 0 of a Gaussian field, and
  !> large where few steps, scratches or plateaus make the height. Measured against five standard errors of independent patches.
  subroutine heavy_tails(z, b)
    real(dp), intent(in) :: z(:, :)       !< heights [m]
    type(blind_t), intent(inout) :: b     !< tail, excess and tail_lag are raised
    real(dp), allocatable :: d(:, :)
    real(dp) :: two, excess, error
    integer :: k, way, m
    do k = 0, 4
      m = 2**k
      do way = 1, 2
        if (size(z, way) < patches * m) cycle
        if (way == 1) d = z(1 + 2 * m:, :) - 2 * z(1 + m:size(z, 1) - m, :) + z(:size(z, 1) - 2 * m, :)
        if (way == 2) d = z(:, 1 + 2 * m:) - 2 * z(:, 1 + m:size(z, 2) - m) + z(:, :size(z, 2) - 2 * m)
        if (size(z, 2) > 1) d = d - spread(sum(d, 3 - way) / size(d, 3 - way), 3 - way, size(d, 3 - way))   ! straight steps
        two = sum(d**2) / size(d, kind=i8)
        if (.not. two > 0) cycle
        excess = sum(d**4) / size(d, kind=i8) / two**2 - 3
        error = sqrt(24 * real(2 * m, dp) * merge(1, 2 * m, size(z, 2) == 1) / size(d, kind=i8))
        if (excess / (sure * error) <= b%tail) cycle
        b%tail = excess / (sure * error)
        b%excess = excess
        b%tail_lag = m
      end do
    end do
  end subroutine heavy_tails

  !> The result as the other fits have it, and the verdict.
  subroutine judge_blind(o, b, r, v)
    type(observation_t), intent(in) :: o      !< S over the lags
    type(blind_t), intent(in) :: b            !< fit of the spectrum
    type(fit_t), intent(out) :: r             !< the same for S
    type(verdict_t), intent(inout) :: v       !< as it came from judge_map
    real(dp) :: reach, clear
    associate (f => b%fit)
      r%d = f%d
      r%ln_g = f%ln_g
      r%noise_variance = f%noise_variance
      r%interval = f%interval
      r%interval_sampling = f%sampling
      r%cov(:2, :2) = f%cov
      r%misfit = f%misfit
      r%chi2 = f%deviance
      r%freedom = f%freedom
      call curves(o, b, r)
      if (b%spike_share > many_spikes .and. v%name == 'steps') v%kind = fractal     ! the jumps were spikes
      if (v%kind /= fractal) return
      v%kind = not_fractal
      clear = f%f_hi                                        ! where noise and probe leave the power law
      if (f%noise_variance > 0) clear = min(clear, noise_meets(b))
      if (f%probe > 0) clear = min(clear, 1 / (2 * pi * f%probe))
      reach = clear / f%f_lo
      if (b%spike_share > many_spikes) then
        v%name = 'spikes'
        v%reason = percent(b%spike_share)//' of the points stand more than six standard deviations off their neighbours'
      else if (b%lay > 0) then
        call name_lay(b, v)
      else if (r%interval(1, 1) > noisy .or. (r%d > noisy_estimate .and. f%f_hi < wide * f%f_lo) &
        .or. (reach < least_reach .and. clear < f%f_hi .and. f%noise_variance > 0)) then
        v%kind = noise_dominated
        v%name = 'noise'
        v%reason = 'the spectrum is flat: white noise of '//rounded(1e6_dp * sqrt(f%noise_variance))// &
          ' um rms leaves a power law over a factor '//to_text(reach)//' of frequency'
      else if (r%interval(2, 1) < smooth_end .or. (r%d < smooth_estimate .and. f%misfit > bent)) then
        v%name = 'smooth'
        v%reason = 'the spectrum falls faster than that of a fractal surface: G is not determined'
      else if (b%tail > 1 .and. b%excess > 1) then
        v%name = 'steps'
        v%reason = 'second differences over '//to_text(b%tail_lag)//' points have an excess kurtosis of '//to_text(b%excess)// &
          ' (0: Gaussian, standard error '//to_text(b%excess / (sure * b%tail))//'): few steps, scratches or plateaus '// &
          'make the height'
      else if (.not. f%accepted .and. f%misfit > bent) then
        v%name = 'bent'
        v%reason = 'no window of frequencies follows one power law: the model is off by '//percent(f%misfit)
      else if (size(b%ranges, 2) == 2) then
        v%name = 'crossover'
        v%reason = 'D = '//hundredths(b%ranges(1, 1))//' for wavelengths of '//rounded(1e6_dp * b%ranges(2, 1))//' to '// &
          rounded(1e6_dp * b%ranges(3, 1))//' um and '//hundredths(b%ranges(1, 2))//' for '// &
          rounded(1e6_dp * b%ranges(2, 2))//' to '//rounded(1e6_dp * b%ranges(3, 2))//' um'
        if (f%crossed .and. f%one - f%two%deviance < quantile) v%reason = v%reason//'. One law with probe or noise, D = '// &
          hundredths(f%d)//', is as likely (deviance '//to_text(f%one)//', two laws '//to_text(f%two%deviance)// &
          '): this map cannot tell them apart'
      else
        v%kind = fractal
        v%reason = 'the spectrum follows the model for wavelengths of '// &
          rounded(1e6_dp / f%f_hi)//' to '//rounded(1e6_dp / f%f_lo)//' um'
        if (r%interval(1, 1) < determined) v%reason = v%reason//'; the 95 % interval of D reaches 2, so G is not determined'
      end if
    end associate
  end subroutine judge_blind

  !> A dimension of a map that is not fractal, to two decimals.
  pure function hundredths(d) result(text)
    real(dp), intent(in) :: d  !< D
    character(len=:), allocatable :: text
    text = to_text(nint(100 * d) / 100._dp)
  end function hundredths

  !> Verdict of a lay.
  subroutine name_lay(b, v)
    type(blind_t), intent(in) :: b            !< lay > 0
    type(verdict_t), intent(inout) :: v       !< set
    character(len=1) :: across
    across = merge('x', 'y', b%lay == 1)
    v%kind = not_fractal
    v%name = 'lay'
    v%reason = 'waves along '//across//' hold '//rounded(b%rings%axis(b%lay))//' times the power of other directions '// &
      'and are no white offsets of '//trim(merge('columns', 'rows   ', b%lay == 1))//': grooves along '// &
      merge('y', 'x', b%lay == 1)//'. Nothing was taken off, D is a mean over directions. Fit profiles along '//across// &
      ', or give the joint the map'
  end subroutine name_lay

  !> The ranges of a crossover: two laws that meet, or two windows of unlike D. Else one range, the window.
  pure subroutine find_ranges(b)
    type(blind_t), intent(inout) :: b         !< fits; ranges are set
    real(dp) :: d(2)
    associate (f => b%fit, g => b%above, t => b%rings)
      b%ranges = reshape([f%d, 1 / f%f_hi, 1 / f%f_lo], [3, 1])
      if (f%crossed) then
        d = 0.5_dp * (6 + t%dim - f%two%n)
        b%ranges = reshape([d(1), 1 / f%two%f, 1 / t%f(1), d(2), 1 / t%f(size(t%f)), 1 / f%two%f], [3, 2])
      else if (g%last > 0 .and. g%accepted .and. (g%interval(1, 1) > f%interval(2, 1) .or. &
        g%interval(2, 1) < f%interval(1, 1))) then
        b%ranges = reshape([b%ranges(:, 1), g%d, 1 / g%f_hi, 1 / g%f_lo], [3, 2])
      end if
    end associate
  end subroutine find_ranges

  !> Frequency where the power law and the noise are equal [1/m].
  pure real(dp) function noise_meets(b) result(f)
    type(blind_t), intent(in) :: b    !< fit
    real(dp) :: n, ln_a, power
    n = 6 + b%rings%dim - 2 * b%fit%d
    ln_a = 2 * (b%fit%d - 2) * b%fit%ln_g - log(merge(4 * pi, 4._dp, b%rings%dim == 2))
    power = b%fit%noise_variance * b%rings%step(1) * merge(b%rings%step(2), 1._dp, b%rings%dim == 2)
    f = exp((ln_a - log(power)) / n)
  end function noise_meets

  !> S of the model over the lags, and standard deviations of ln S.
  subroutine curves(o, b, r)
    type(observation_t), intent(in) :: o      !< S over the lags
    type(blind_t), intent(in) :: b            !< fit of the spectrum
    type(fit_t), intent(inout) :: r           !< curves are set
    integer, parameter :: n = 600
    real(dp), parameter :: beyond = 5  !< Nyquist's frequency, to which detail finer than the spacing counts
    real(dp) :: f, low, high, a, scale, cov(size(o%lag), size(o%lag)), g(2), finer(2)
    type(radial_t) :: t
    integer :: i, k, kind
    kind = merge(kind_profile, kind_isotropic, b%rings%dim == 1)
    scale = exp(2 * (r%d - 2) * r%ln_g)
    a = 6 - 2 * r%d
    low = 1 / max(o%nx * o%dx, o%ny * o%dy)
    high = merge(beyond, 1._dp, b%fit%fold > 0) * b%rings%nyquist
    finer = shares(b%fit%fold)
    allocate (r%curve(size(o%lag)), r%sd_sample(size(o%lag)), r%sd_curve(size(o%lag)))
    r%curve = 2 * r%noise_variance
    do i = 1, n
      f = low * (high / low)**((i - 0.5_dp) / n)
      do k = 1, size(o%lag)
        r%curve(k) = r%curve(k) + scale * log(high / low) / n * f**(-a) * exp(-(2 * pi * b%fit%probe * f)**2) &
          * (1 - merge(cos(2 * pi * f * o%tau(k)), bessel_j0(2 * pi * f * o%tau(k)), kind == kind_profile)) &
          * merge(1._dp, merge(sum(finer), finer(2), f < 2 * b%rings%nyquist), f <= b%rings%nyquist)
      end do
    end do
    t = new_radial(kind, r%d, scale, low, 2 * b%rings%nyquist, min(o%dx, o%dy), 2 * hypot(o%nx * o%dx, o%ny * o%dy))
    call field_covariance(o, t, cov, diagonal=.true.)
    call noise_covariance(o, t, r%noise_variance, cov)
    do k = 1, size(o%lag)
      r%sd_sample(k) = sqrt(cov(k, k) * o%parts / o%filled) / r%curve(k)
      g = [2 * (r%ln_g - log(2 * pi * o%tau(k))), 2 * (r%d - 2)]
      r%sd_curve(k) = sqrt(max(0._dp, dot_product(g, matmul(b%fit%cov, g))))
    end do
    r%rms = sqrt(sum(log(o%s / r%curve)**2) / size(o%s))
    r%rms_expected = sqrt(sum(r%sd_sample**2) / size(o%s))
  end subroutine curves
end module hd_map_fit
