! SPDX-License-Identifier: GPL-3.0-or-later
!> The rule by which the theory of the joint is taken.
module test_persson_error
  use hd_kinds, only: dp, pi
  use hd_check, only: check, check_close
  use hd_error, only: error_t
  use hd_roughness_spectrum, only: power_spectrum_t, fractal_spectrum, sampled_spectrum
  use hd_persson_error, only: theory_surface_t, theory_error_t, new_theory_surface, theory_scatter, theory_error_of, may_be_taken, &
    in_words, counted_share, touching_waves, scatter_of_maps, trust, steep
  implicit none
  private
  public :: run_persson_error

contains

  subroutine run_persson_error()
    call test_scatter()
    call test_waves()
    call test_contact()
  end subroutine run_persson_error

  !> The error is that of the table at its places, falls between, and stays outside.
  subroutine test_scatter()
    real(dp) :: x
    integer :: i
    call check_close(maxval(abs(theory_scatter(touching_waves) - scatter_of_maps)), 0._dp, 1e-14_dp, 'table of errors')
    x = theory_scatter(sqrt(touching_waves(4)*touching_waves(5)))
    call check_close(x, (scatter_of_maps(4) + scatter_of_maps(5))/2, 1e-14_dp, 'between two places')
    call check_close(theory_scatter(0._dp), scatter_of_maps(1), 1e-14_dp, 'no touching wave')
    i = size(touching_waves)
    call check_close(theory_scatter(1e9_dp), scatter_of_maps(i), 1e-14_dp, 'many touching waves')
  end subroutine test_scatter

  !> Independent waves of one band are its waves, pi (f_2^2 - f_1^2) on a unit of area, and a strong band outweighs weak ones.
  subroutine test_waves()
    type(power_spectrum_t) :: spectrum
    type(theory_surface_t) :: surface
    type(error_t), allocatable :: error
    call fractal_spectrum(2.3_dp, 1e-9_dp, 1e-3_dp, 1e-5_dp, spectrum, error)
    call check_close(sum(spectrum%waves), pi*(1e10_dp - 1e6_dp), 1e-3_dp, 'waves of all bands')
    call sampled_spectrum([1e4_dp, 2e4_dp, 4e4_dp], [1e-30_dp, 1e-12_dp, 1e-30_dp], spectrum, error)
    surface = new_theory_surface(spectrum, 1e11_dp, 2e9_dp, [1e6_dp, 1e8_dp], [1e-3_dp, 1e-1_dp])
    call check_close(surface%waves_per_area, (8e8_dp - 2e8_dp)/(4*pi), 1e-3_dp, 'one band holds the height')
    call check_close(surface%steepness, 50*2e-2_dp, 1e-9_dp, 'E* slope over hardness')
    call check(index(in_words(theory_error_of(surface, [1e7_dp], [1e-6_dp], [.true.])), 'open waves') == 0, 'few crests touch')
    surface%area = [0.9_dp, 0.97_dp]
    call check_close(theory_scatter(1e4_dp*counted_share(0.97_dp)), theory_scatter(100._dp), 1e-12_dp, 'three open count as one')
    call check(index(in_words(theory_error_of(surface, [1e8_dp], [1e-6_dp], [.true.])), 'open waves') > 0, 'few valleys are open')
  end subroutine test_waves

  !> Touching waves of parts of a contact add up; what sticks decides; the rule flips where 1.96 times the error is the bound, and
  !> where the slope is too steep.
  subroutine test_contact()
    type(theory_surface_t) :: surface
    type(theory_error_t) :: found
    real(dp) :: edge
    integer :: i
    surface%pressure = [1e6_dp, 1e8_dp]
    surface%area = [1e-3_dp, 1e-1_dp]
    surface%waves_per_area = 1e8_dp
    found = theory_error_of(surface, [1e7_dp, 2e7_dp, 5e7_dp, 0._dp], [1e-6_dp, 1e-6_dp, 1e-6_dp, 1e-6_dp], &
      [.true., .true., .false., .true.])
    call check(found%sticks, 'points stick')
    call check_close(found%area, 2e-6_dp, 1e-18_dp, 'area that sticks and is pressed')
    call check_close(found%pressure, 1.5e7_dp, 1e-3_dp, 'its mean pressure')
    call check_close(found%share*found%waves, 1e8_dp*1e-6_dp*(1e-2_dp + 2e-2_dp), 1e-9_dp, 'touching waves add up')
    found = theory_error_of(surface, [5e5_dp], [1e-6_dp], [.false.])
    call check(.not. found%sticks, 'nothing sticks: what is pressed decides')
    call check_close(found%share, 5e-4_dp, 1e-15_dp, 'contact in proportion below the first pressure')
    found = theory_error_of(surface, [0._dp, -1e6_dp], [1e-6_dp, 1e-6_dp], [.true., .true.])
    call check(.not. may_be_taken(found), 'nothing is pressed')
    i = count(scatter_of_maps > trust/1.96_dp)
    edge = touching_waves(i)*(touching_waves(i + 1)/touching_waves(i))**((scatter_of_maps(i) - trust/1.96_dp)/ &
      (scatter_of_maps(i) - scatter_of_maps(i + 1)))  ! waves at which 1.96 e = trust
    surface%waves_per_area = 1.001_dp*edge/(1e-2_dp*1e-6_dp)
    found = theory_error_of(surface, [1e7_dp], [1e-6_dp], [.true.])
    call check(may_be_taken(found), 'just enough waves touch')
    found%steepness = 1.001_dp*steep
    call check(.not. may_be_taken(found), 'too steep')
    surface%waves_per_area = 0.999_dp*edge/(1e-2_dp*1e-6_dp)
    call check(.not. may_be_taken(theory_error_of(surface, [1e7_dp], [1e-6_dp], [.true.])), 'just too few waves touch')
  end subroutine test_contact
end module test_persson_error
