! SPDX-License-Identifier: GPL-3.0-or-later
!> Where the joint model leaves the range it is meant for.
module hd_joint_range
  use hd_kinds, only: dp, pi, hair
  use hd_asperity, only: edge, fully_plastic
  use hd_error, only: error_t, raise, code_input
  use hd_joint, only: joint_t, response_t, spots_t, evaluate_joint, find_largest_spot, pressure_power, real_area
  use hd_text, only: string_t, push, rounded, to_text
  implicit none
  private
  public :: check_stiffness, range_warnings

  real(dp), parameter :: beyond = 1.001_dp   !< a base so much wider than the spot holds it in the four digits that are written
  !> share by which the shear lies below slip, and by which the largest spot must exceed s_min
  real(dp), parameter :: just = 1e-6_dp

contains

  !> Refuse a joint whose spots are all plastic and without stiffness: K_N = K_T = 0 under every load.
  subroutine check_stiffness(joint, error)
    type(joint_t), intent(in) :: joint                !< joint
    type(error_t), allocatable, intent(out) :: error  !< no stiffness
    real(dp) :: plastic
    if (joint%first < fully_plastic .or. joint%plastic .or. allocated(joint%elastic)) return
    plastic = edge(3)*joint%asperity%s_ec
    call raise(error, code_input, 'the joint has no stiffness under any load, K_N = K_T = 0: the smallest spot, joint.s_min = '// &
      to_text(joint%s_min)//' m^2, is fully plastic (spots are from '//to_text(plastic)//' m^2 on), and plastic spots have none'// &
      new_line('a')//'      valid: joint.s_min below '//to_text(plastic)//" m^2, a larger joint.asperity_radius, or "// &
      "joint.plastic_spots = 'elastic' (they unload elastically)")
  end subroutine check_stiffness

  !> One line for each assumption that does not hold under the largest pressure.
  subroutine range_warnings(joint, pressure, lines)
    type(joint_t), intent(in) :: joint                        !< joint
    real(dp), intent(in) :: pressure                          !< largest pressure [Pa]
    type(string_t), allocatable, intent(out) :: lines(:)      !< warnings, none if all holds
    type(spots_t) :: s
    type(response_t) :: r
    real(dp) :: s_l, base, power
    integer :: iterations
    allocate (lines(0))
    if (.not. pressure > 0) return
    if (allocated(joint%elastic)) then
      associate (last => exp(joint%elastic%normal%log_p(size(joint%elastic%normal%log_p))))
        if (pressure > last*(1 + hair)) call push(lines, 'the largest pressure, '//to_text(pressure)// &
          ' Pa, exceeds the last of the joint, '//to_text(last)//' Pa: k_N counts as constant above that. '// &
          'Read the tangent, or extend the table of the joint (joint.table_file) to it')
      end associate
      return
    end if
    call find_largest_spot(joint, pressure, s, iterations)
    s_l = s%sigma*joint%asperity%s_ec
    base = pi*joint%r_m**2
    if (.not. s%excess > 0) then
      call push(lines, 'no largest spot carries '//rounded(pressure)//' Pa: the pressure is not below 0.99 H. '// &
        'Raise joint.hardness if it is higher, or lower the load')
      return
    end if
    if (s_l > base) call push(lines, 'the stiffness of the joint is extrapolated, for spots grow beyond the base of an '// &
      'asperity, '//rounded(s_l)//' against '//rounded(base)//' m^2. Take joint.model = ''spectrum'', calibrate '// &
      '(docs/howto/calibrate.md), or raise joint.asperity_radius to '//rounded(beyond*sqrt(s_l/pi))//' m')
    if (real_area(joint, s_l) > joint%reference_area) call push(lines, 'the real contact area, '// &
      to_text(real_area(joint, s_l))//' m^2, exceeds the nominal one, '// &
      to_text(joint%reference_area)//' m^2: the model has ended; take joint.model = ''spectrum''')
    if (joint%first == fully_plastic .and. .not. joint%plastic) then
      call push(lines, 's_min is plastic already: no spot has stiffness, K_N = K_T = 0. '// &
        "Lower s_min, or count plastic spots as elastic (joint.plastic_spots = 'elastic', plastic=True in Python)")
    end if
    call evaluate_joint(joint, pressure, (1 - just)*joint%mu*pressure, 1._dp, r)
    power = pressure_power(r, pressure, (1 - just)*joint%mu*pressure)
    if (power < 0) call push(lines, 'K_T about to slip falls as the pressure grows, d ln K_T / d ln p = '//to_text(power)// &
      ': more pressure looks softer in Eq. 45. Read the tangent')
    if (s%excess < just) then
      call push(lines, 's_min is not below the largest spot by more than 1e-6: the stiffness rests on s_min. Lower joint.s_min')
    end if
  end subroutine range_warnings
end module hd_joint_range
