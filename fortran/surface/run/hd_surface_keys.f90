! SPDX-License-Identifier: GPL-3.0-or-later
!> Rows of the table of parameters for a surface run: the surface that is generated, and the fit of D and G.
module hd_surface_keys
  use hd_kinds, only: dp
  use hd_parameter_row, only: parameter_table_t, add_integer, add_real, add_choice
  use hd_surface_scene, only: surface_t, surface_fit_t
  implicit none
  private
  public :: add_surface_keys, add_fit_keys

contains

  !> A generated surface.
  subroutine add_surface_keys(s, t)
    type(surface_t), intent(inout), target :: s          !< surface
    type(parameter_table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call add_integer(t, 'surface', 'nx', 'output', s%nx, 1, 8388608, 'points along x')
    call add_integer(t, 'surface', 'ny', 'output', s%ny, 1, 8388608, 'points along y')
    call add_real(t, 'surface', 'dx', 'output', s%dx, 'm', 0._dp, big, 'spacing along x')
    call add_real(t, 'surface', 'dy', 'output', s%dy, 'm', 0._dp, big, 'spacing along y')
    call add_real(t, 'surface', 'fractal_dimension', 'output', s%fractal_dimension, '', 2._dp, 3._dp, 'D of Eq. 1')
    call add_real(t, 'surface', 'roughness', 'output', s%roughness, 'm', 0._dp, big, 'G of Eq. 1')
    call add_real(t, 'surface', 'gamma', 'output', s%gamma, '', 1._dp, big, 'frequency ratio')
    call add_real(t, 'surface', 'sample_length', 'output', s%sample_length, 'm', 0._dp, big, 'L, the longest wavelength')
    call add_real(t, 'surface', 'shortest_wavelength', 'output', s%shortest_wavelength, 'm', 0._dp, big, 'L_s, not above L')
    call add_integer(t, 'surface', 'ridges', 'output', s%ridges, 1, 100000000, 'M, directions of waves; 1: Eq. 2')
    call add_integer(t, 'surface', 'seed', 'output', s%seed, 0, huge(1), &
      'seed of the random phases')
    call add_real(t, 'surface', 'tolerance', 'output', s%tolerance, '', 0._dp, 0.1_dp, &
      'rms error that the heights may have, relative to the waves, 1e-13 or more; 0: none but rounding', &
      closed=.true.)
    call add_choice(t, 'surface', 'method', 'output', s%method, 'auto direct product nufft', &
      'evaluator of the sum of waves; auto: the fastest that keeps the tolerance (without one: nufft to 1e-12)')
    call add_choice(t, 'surface', 'precision', 'output', s%precision, 'double single', &
      'precision of the heights in the file')
  end subroutine add_surface_keys

  !> Fit of D and G.
  subroutine add_fit_keys(s, t)
    type(surface_fit_t), intent(inout), target :: s  !< fit
    type(parameter_table_t), intent(inout) :: t            !< table
    real(dp), parameter :: big = huge(1._dp)
    call add_choice(t, 'fit', 'first_file', 'output', s%first_file, '', &
      'surface to fit in place of a generated one: .sdf (ISO 25178-71) or .npy (heights in m); looked for from here, then '// &
      'beside the input')
    call add_choice(t, 'fit', 'second_file', 'output', s%second_file, '', &
      'second surface: the structure functions of both add up to that of the equivalent surface')
    call add_real(t, 'fit', 'dx', 'output', s%dx, 'm', 0._dp, big, 'spacing along x of .npy files, which state none', closed=.true.)
    call add_real(t, 'fit', 'dy', 'output', s%dy, 'm', 0._dp, big, 'spacing along y of .npy files; 0: dx', closed=.true.)
    call add_integer(t, 'fit', 'first_lag', 'output', s%first_lag, 1, 8388608, 'first lag of the window [points]')
    call add_integer(t, 'fit', 'last_lag', 'output', s%last_lag, 0, 8388608, &
      'last lag [points]; 0: 20, or half a row if that is less')
    call add_choice(t, 'fit', 'model', 'output', s%model, 'auto spectrum ridges paper none', &
      'law that is fitted. ridges: the sum of Eq. 1 by the keys of &surface; spectrum: a power law, all else unknown; '// &
      'paper: Eq. 23 as printed; none: no fit; auto: ridges of a generated surface, spectrum of files')
    call add_real(t, 'fit', 'shortest_wavelength', 'output', s%shortest_wavelength, 'm', 0._dp, big, &
      'with longest_wavelength: the window that spectrum fits; 0: it looks for one', closed=.true.)
    call add_real(t, 'fit', 'longest_wavelength', 'output', s%longest_wavelength, 'm', 0._dp, big, &
      'the other end of that window', closed=.true.)
  end subroutine add_fit_keys
end module hd_surface_keys
