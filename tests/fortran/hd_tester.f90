! SPDX-License-Identifier: GPL-3.0-or-later
program hd_tester
  use hd_check, only: report_checks
  use test_ball_patch, only: run_ball_patch
  use test_band_matrix, only: run_band_matrix
  use test_circulant, only: run_circulant
  use test_contact, only: run_contact
  use test_contact_edge, only: run_contact_edge
  use test_cup_sections, only: run_cup_sections
  use test_element, only: run_element
  use test_fft, only: run_fft
  use test_gauss, only: run_gauss
  use test_groove, only: run_groove
  use test_hertz, only: run_hertz
  use test_heights, only: run_heights
  use test_parameters, only: run_parameters
  use test_random, only: run_random
  use test_random_field, only: run_random_field
  use test_interface, only: run_interface
  use test_mesh_series, only: run_mesh_series
  use test_named_values, only: run_named_values
  use test_pairing, only: run_pairing
  use test_registers, only: run_registers
  use test_rotation, only: run_rotation
  use test_flank_friction, only: run_flank_friction
  use test_section, only: run_section
  use test_spectral_model, only: run_spectral_model
  use test_spline_ring, only: run_spline_ring
  use test_stress, only: run_stress
  use test_table, only: run_table
  use test_text, only: run_text
  use test_persson_error, only: run_persson_error
  use test_tolerance_band, only: run_tolerance_band
  implicit none
  call run_text()
  call run_persson_error()
  call run_tolerance_band()
  call run_stress()
  call run_table()
  call run_parameters()
  call run_ball_patch()
  call run_band_matrix()
  call run_fft()
  call run_gauss()
  call run_groove()
  call run_hertz()
  call run_spectral_model()
  call run_spline_ring()
  call run_heights()
  call run_random()
  call run_random_field()
  call run_element()
  call run_circulant()
  call run_contact()
  call run_contact_edge()
  call run_interface()
  call run_pairing()
  call run_registers()
  call run_rotation()
  call run_mesh_series()
  call run_named_values()
  call run_flank_friction()
  call run_section()
  call run_cup_sections()
  if (.not. report_checks()) stop 1
end program hd_tester
