! SPDX-License-Identifier: GPL-3.0-or-later
!> Where the joint model leaves the range it is meant for.
module hd_joint_range
  use hd_kinds, only: dp, pi
  use hd_joint, only: joint_t, spots_t, find_largest_spot, real_area
  use hd_text, only: string_t, push, to_text
  implicit none
  private
  public :: range_warnings

contains

  !> One line for each assumption that does not hold under the largest pressure.
  subroutine range_warnings(joint, pressure, lines)
    type(joint_t), intent(in) :: joint                        !< joint
    real(dp), intent(in) :: pressure                          !< largest pressure [Pa]
    type(string_t), allocatable, intent(out) :: lines(:)      !< warnings, none if all holds
    type(spots_t) :: s
    real(dp) :: s_l, base
    integer :: iterations
    allocate (lines(0))
    if (.not. pressure > 0) return
    call find_largest_spot(joint, pressure, s, iterations)
    s_l = s%sigma*joint%asperity%s_ec
    base = pi*joint%r_m**2
    if (.not. s%excess > 0) then
      call push(lines, 'no largest spot carries '//to_text(pressure)//' Pa: the pressure is not below 0.99 H')
      return
    end if
    if (s_l > base) call push(lines, 'the largest spot, '//to_text(s_l)//' m^2, exceeds the base of an asperity, pi r_m^2 = '// &
      to_text(base)//' m^2')
    if (real_area(joint, s_l) > joint%reference_area) call push(lines, 'the real contact area, '// &
      to_text(real_area(joint, s_l))//' m^2, exceeds the nominal one, '//to_text(joint%reference_area)//' m^2')
    if (joint%first == 4) call push(lines, 's_min is plastic already: no spot has stiffness, K_N = K_T = 0')
    if (s%excess < 1e-6_dp) call push(lines, 's_min is not below the largest spot by more than 1e-6: the stiffness rests on s_min')
  end subroutine range_warnings
end module hd_joint_range
