! SPDX-License-Identifier: GPL-3.0-or-later
!> Warnings by number: what the log adds to each, and `--explain warnings` lists.
module hd_warning_list
  use hd_text, only: to_text
  implicit none
  private
  public :: numbered, warnings_text

  !> A warning that a run may give.
  type :: warning_t
    character(len=56) :: mark     !< words that it alone has
    character(len=150) :: advice  !< when it comes, and what to do
  end type warning_t

  ! Numbers are places in this list: new ones come at its end.
  type(warning_t), parameter :: list(*) = [ &
    warning_t(' is unusual: usual are ', 'a value outside of what drives have. Check its unit'), &
    warning_t(' times the wall: usual are ', 'w does not go with the wall. Check wave_generator.w and geometry.wall_thickness'), &
    warning_t(' is thinner than the wall ', 'the toothed rim. Set geometry.rim_thickness to 1.67^(1/3) times the wall'), &
    warning_t(' times the bore radius: usual are ', 'the cup. Check geometry.cup_length and geometry.bore_radius'), &
    warning_t(' N m: drives of this bore hold some ', 'more torque than catalogues allow for a moment. Check load.torque'), &
    warning_t('joint.model: ', 'the joint outside of its rule. Give a map to hdengine joint and its table to joint.table_file'), &
    warning_t('nothing is in contact: ', 'ring and cup never touch. Raise wave_generator.w, lower its clearance'), &
    warning_t('no ball carries the ring', 'the bearing is loose. Lower bearing.clearance or the torque'), &
    warning_t('no pair of teeth pushes', 'the drive has play. Lower load.tooth_gaps, or raise load.tooth_pairs'), &
    warning_t(' comes or goes with ', 'a ball takes or leaves its load in one step. Raise load.torque_steps'), &
    warning_t(' m out of mesh, more than w', 'a real drive would ratchet. Lower the torque'), &
    warning_t(' N m on the cam; without losses', 'the cam takes torque that balls cannot. Check eccentricity, w and teeth'), &
    warning_t('this scene does not use ', 'a key of a part that is not there. Take it out, or see --explain KEY'), &
    warning_t('least safety by Goodman', 'the cup breaks in time. Lower w or the torque, or round steps of the wall'), &
    warning_t('the flexspline yields: ', 'stress beyond material.yield_strength. Lower torque, w or the wall'), &
    warning_t('the ring yields: ', 'stress beyond material.ring_yield_strength. Lower torque, w or the ring'), &
    warning_t('the peak pressure at a node', 'it grows with a finer mesh. Judge by edge_line_load_n_per_m'), &
    warning_t('the middle of the band is open', 'no pressure is promised there. Read the normal force'), &
    warning_t(' comes from points that slip', 'Eq. 45 counts them as if they held. Quote k_ts_bonded_nm_per_rad'), &
    warning_t('the tangent K_TS is not certain', 'which points stick did not settle. Solve 1 % beside the torque'), &
    warning_t('the wave generator carries ', "the ring is held on the cam. Take support 'drive', or ring_tangent = 'free'"), &
    warning_t(' are out of balance: facets', 'the torque is carried to three digits. Raise mesh.divisions'), &
    warning_t('K_T about to slip falls', 'more pressure looks softer in Eq. 45. Read the tangent'), &
    warning_t('no largest spot carries', 'pressure near the hardness. Raise joint.hardness if it is higher'), &
    warning_t('s_min is not below the largest spot', 'the stiffness rests on s_min. Lower joint.s_min'), &
    warning_t('s_min is plastic already', "no spot has stiffness. Lower joint.s_min, or plastic_spots = 'elastic'"), &
    warning_t(' exceeds the last of the joint', 'its table ends. Extend joint.table_file'), &
    warning_t('the real contact area', "the model has ended. Take joint.model = 'spectrum'"), &
    warning_t('the joint is extrapolated', "spots beyond an asperity. Take joint.model = 'spectrum', or calibrate"), &
    warning_t('there is no band', 'the coarse drive ended early. Raise mesh.divisions'), &
    warning_t('the band leaves out an end', 'an input could not be moved. Take the other end for both'), &
    warning_t('the band of ', 'a result has no value at an end. Take the other end for both'), &
    warning_t('nothing is known of the error', 'no finer mesh was run. The log says why'), &
    warning_t('the tolerance is not met: the estimated', 'raise mesh.memory_limit_mb or run.tolerance'), &
    warning_t('what large displacements would change', 'they do not converge. Results are of small displacements'), &
    warning_t('the cup stays round', 'w is 0. Check wave_generator.w'), &
    warning_t(' is odd: with two lobes', 'the ends of the long axis differ. Check load.teeth'), &
    warning_t('no gradient: ', 'the run was resumed, or a change of state spoilt it. Compare two runs'), &
    warning_t('the rise ends at ', 'K1 or K2 is a shorter chord than a catalogue''s. Raise the torque')]

contains

  !> The warning with its number behind it.
  function numbered(text) result(line)
    character(len=*), intent(in) :: text  !< warning
    character(len=:), allocatable :: line
    integer :: i
    line = text
    do i = 1, size(list)
      if (index(text, trim(list(i)%mark)) == 0) cycle
      line = text//' (W'//to_text(i)//')'
      return
    end do
  end function numbered

  !> All warnings, one a line.
  function warnings_text() result(text)
    character(len=:), allocatable :: text
    integer :: i
    text = 'Warnings by number, as the log ends them: words, when each comes and what to do.'
    do i = 1, size(list)
      text = text//new_line('a')//'W'//to_text(i)//repeat(' ', 4 - len(to_text(i)))//trim(adjustl(list(i)%mark))//' - '// &
        trim(list(i)%advice)
    end do
  end function warnings_text
end module hd_warning_list
