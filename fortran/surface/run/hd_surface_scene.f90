! SPDX-License-Identifier: GPL-3.0-or-later
!> What a surface run is asked for, in SI units. Bounds, units and meanings stand in hd_surface_keys.
module hd_surface_scene
  use hd_kinds, only: dp
  implicit none
  private
  public :: surface_t, surface_fit_t, surface_scene_t

  integer, parameter :: name_length = 32   !< longest choice
  integer, parameter :: path_length = 240  !< longest file name

  !> A generated surface.
  type :: surface_t
    integer :: nx = 512, ny = 512, ridges = 10, seed = 1
    real(dp) :: dx = 1e-6_dp, dy = 1e-6_dp
    real(dp) :: fractal_dimension = 2.5304_dp, roughness = 2.4248e-7_dp, gamma = 1.5_dp, sample_length = 0.5e-3_dp
    real(dp) :: shortest_wavelength = 1e-6_dp, tolerance = 0
    character(len=name_length) :: method = 'auto', precision = 'double'
  end type surface_t

  !> Fit of D and G to a generated surface, or to one or two specimens from files.
  type :: surface_fit_t
    character(len=path_length) :: first_file = '', second_file = ''
    integer :: first_lag = 1, last_lag = 0
    real(dp) :: dx = 0, dy = 0, shortest_wavelength = 0, longest_wavelength = 0
    character(len=name_length) :: model = 'auto'
  end type surface_fit_t

  type :: surface_scene_t
    type(surface_t) :: surface
    type(surface_fit_t) :: fit
    character(len=:), allocatable :: title  !< one line that names the run
    character(len=:), allocatable :: echo   !< every key with its value, as an input file
  end type surface_scene_t
end module hd_surface_scene
