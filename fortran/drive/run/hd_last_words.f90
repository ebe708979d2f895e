! SPDX-License-Identifier: GPL-3.0-or-later
!> What a run says at its end: its stress, what each support carries, K_TS or the readings of a drive, and warnings where one of
!> them, or what it rests on, leaves its range.
module hd_last_words
  use hd_kinds, only: dp
  use hd_ball_bearing, only: race_pressure
  use hd_checkpoint, only: mark_t
  use hd_facets, only: facets_t, sums_t
  use hd_joint, only: joint_t
  use hd_joint_range, only: range_warnings
  use hd_load_path, only: path_end, operator(<)
  use hd_log, only: say, detail
  use hd_loop, only: loop_text, loop_t, read_loop, readings_t
  use hd_loop_warnings, only: drive_warnings
  use hd_scene, only: scene_t
  use hd_strength, only: strength_text, strength_warnings
  use hd_summary, only: record_t
  use hd_text, only: string_t, percent, push, rounded, to_text
  use hd_tolerance_band, only: tolerance_band_t, banded_values
  use hd_twist_shares, only: part_names, in_contact
  use hd_warning_list, only: numbered
  implicit none
  private
  public :: judge_results

  real(dp), parameter :: much_slip = 0.5_dp  !< share of K_TS by Eq. 45 on slipping points above which it is warned of

contains

  !> Say what K_TS is, and warn where it or what it rests on leaves its range.
  subroutine judge_results(scene, joint, mark, facets, sums, loop, record)
    type(scene_t), intent(in) :: scene        !< of the run
    type(joint_t), intent(in) :: joint        !< its joint
    type(mark_t), intent(in) :: mark          !< where it ended
    type(facets_t), intent(in) :: facets      !< of the step that its results are of
    type(sums_t), intent(in) :: sums          !< of that step
    type(loop_t), intent(in) :: loop          !< of a whole drive
    type(record_t), intent(inout) :: record   !< gets warnings
    type(string_t), allocatable :: lines(:)
    character(len=:), allocatable :: pressed
    integer :: i
    if (mark%step%number == 0) return
    if (mark%strength%flexspline > 0) then
      call strength_warnings(mark%strength, scene, lines)
      call warn(record, lines)
      pressed = ''
      if (race_pressure(scene, loop%ball_force_max) > 0) pressed = '; a ball presses '// &
        rounded(race_pressure(scene, loop%ball_force_max))//' Pa on its race, ISO 76 allows 4.2e9'
      call say('stress    '//strength_text(mark%strength, scene)//pressed)
    end if
    if (scene%support%contact) call judge_contact(scene, joint, mark, facets, sums, loop, record)  ! else bonded: no joint
    do i = 1, size(record%warnings)
      call say('warning: '//numbered(record%warnings(i)%s))
    end do
  end subroutine judge_results

  !> The same of the contact.
  subroutine judge_contact(scene, joint, mark, facets, sums, loop, record)
    type(scene_t), intent(in) :: scene        !< as of judge_results
    type(joint_t), intent(in) :: joint        !< likewise
    type(mark_t), intent(in) :: mark          !< likewise
    type(facets_t), intent(in) :: facets      !< likewise
    type(sums_t), intent(in) :: sums          !< likewise
    type(loop_t), intent(in) :: loop          !< likewise
    type(record_t), intent(inout) :: record   !< gets warnings
    type(string_t), allocatable :: lines(:)
    character(len=:), allocatable :: line
    call range_warnings(joint, maxval(facets%corner(1, :, :)), lines)
    call warn(record, lines)
    if (scene%support%loop) then
      call drive_warnings(loop, scene, lines)
      call warn(record, lines)
    end if
    call push_stiffness_warnings(scene, joint, mark%certain, sums, record)
    call judge_load_path(scene, mark%step%torque, sums, record)
    if (scene%support%loop) then
      call tell_drive(scene, mark, sums, loop, record%band)
    else
      line = ' N m/rad, the tangent beside bonded faces'
      if (.not. sums%k_tangent > 0) line = ': these faces have no tangent'
      call say('K_TS      '//stiffness_text(sums%k_tangent)//line)
      call detail('          secant '//stiffness_text(sums%k_secant)//', contact alone '//stiffness_text(sums%k_contact)// &
        ' N m/rad')
    end if
    call detail('          Eq. 45 '//rounded(sums%k_ts)//' N m/rad, as printed '//rounded(sums%k_ts_paper)//' N; slipping: '// &
      percent(sums%slip_area)//' of the area, '//percent(sums%slip_force)//' of the force, '//percent(sums%slip_k_ts)// &
      ' of Eq. 45')
  end subroutine judge_contact

  !> Keep warnings for the summary.
  subroutine warn(record, lines)
    type(record_t), intent(inout) :: record  !< grows
    type(string_t), intent(in) :: lines(:)   !< one each
    integer :: i
    do i = 1, size(lines)
      call push(record%warnings, lines(i)%s)
    end do
  end subroutine warn

  !> The answer of a whole drive: its readings with their band, what takes its twist at the reference step, what to quote.
  subroutine tell_drive(scene, mark, sums, loop, band)
    type(scene_t), intent(in) :: scene   !< of the run
    type(mark_t), intent(in) :: mark     !< where it ended; its step is the reference one
    type(sums_t), intent(in) :: sums     !< there
    type(loop_t), intent(in) :: loop     !< of the run
    type(tolerance_band_t), intent(in) :: band  !< of its readings, if they have one
    character(len=:), allocatable :: line, quote
    type(string_t), allocatable :: keys(:)
    real(dp), allocatable :: part(:)
    character(len=9), parameter :: all_of(3) = ['K1       ', 'K1 and K2', 'K1 to K3 ']
    type(readings_t) :: found
    integer :: i, last
    line = loop_text(loop, scene)
    if (len(line) == 0) then
      call say('drive     no K1 to K3, for the torque does not rise')
      return
    end if
    found = read_loop(loop, scene)
    last = findloc(found%k > 0, .true., 1, back=.true.)
    quote = trim(all_of(max(1, last)))
    if (mark%place < path_end(scene)) then
      call say('drive     so far '//line)
      quote = 'nothing of a loop that is not whole: --resume goes on'
    else if (allocated(band%input)) then
      call say('drive     '//loop_text(loop, scene, band%bounds()))
      if (scene%planned_tolerance > 0) then
        quote = quote//' by their limits below, with these 95 % bands in proportion'
      else
        quote = quote//' with these 95 % bands'
      end if
      if (last > 1) then
        call band%ranked(keys, part)
        quote = quote//', that of K2 made most by '//keys(1)%s//' ('//percent(part(1))//')'
      end if
    else
      call say('drive     '//line)
      quote = 'variants beside each other; '//quote//' with their band, which run.band finds'
    end if
    if (sums%shares(1) == sums%shares(1)) then  ! else no joint: none
      line = 'twist     the contact takes '//percent(sum(sums%shares(in_contact:)))//' at '//rounded(mark%step%torque)//' N m:'
      do i = in_contact, size(part_names)
        line = line//' '//trim(part_names(i))//' '//percent(sums%shares(i))//merge(',', ';', i < size(part_names))
      end do
      do i = 1, in_contact - 1
        line = line//' '//trim(part_names(i))//' '//percent(sums%shares(i))//merge(',', ' ', i < in_contact - 1)
      end do
      call say(trim(line))
      call detail('          K_TS '//rounded(sums%k_tangent)//' N m/rad beside the bonded drive (Eq. 46), '// &
        stiffness_text(sums%k_contact)//' of the contact alone')
    end if
    call say('quote     '//quote//'; no K_TS without its fit')
    if (allocated(band%input)) call detail('band      '//band%text(banded_values(found, sums)))
  end subroutine tell_drive

  !> A stiffness, or that there is none.
  function stiffness_text(k) result(text)
    real(dp), intent(in) :: k  !< stiffness; NaN: none
    character(len=:), allocatable :: text
    text = 'none'
    if (k > 0) text = rounded(k)
  end function stiffness_text

  !> Warnings of K_TS and of pressures.
  subroutine push_stiffness_warnings(scene, joint, certain, s, record)
    type(scene_t), intent(in) :: scene        !< of the run
    type(joint_t), intent(in) :: joint        !< its joint
    logical, intent(in) :: certain            !< its tangent is
    type(sums_t), intent(in) :: s             !< of the step that its results are of
    type(record_t), intent(inout) :: record   !< gets warnings
    logical :: hard                           !< the hardness is exceeded
    if (.not. s%normal_force > 0 .and. .not. scene%bonded()) call push(record%warnings, &
      'nothing is in contact: K_TS is that of the supports alone. Raise '// &
      'wave_generator.interference (or lower clearance) or wave_generator.w')
    if (s%slip_k_ts > much_slip .and. .not. scene%support%loop) call push(record%warnings, percent(s%slip_k_ts)// &
      ' of K_TS by Eq. 45 comes from points that slip, which Eq. 45 counts as if they held. Quote k_ts_bonded_nm_per_rad')
    if (.not. certain) call push(record%warnings, 'the tangent K_TS is not certain: which points stick under a '// &
      'further torque did not settle, or the linear solver did not reach its accuracy. Compare it with load.torque 1 % off')
    hard = s%pressure_max > joint%asperity%hardness
    if (hard .or. s%pressure_max > scene%yield_strength) call push(record%warnings, 'the peak pressure at a node, '// &
      rounded(s%pressure_max)//' Pa, is above the '//trim(merge('hardness      ', 'yield strength', hard))//' '// &
      to_text(merge(joint%asperity%hardness, scene%yield_strength, hard))//' Pa: '// &
      'bodies are elastic here, and at the edge of the ring it grows without limit as cells shrink. Judge strength by '// &
      'edge_line_load_n_per_m, '//rounded(s%edge_line_load)//' N/m on the last tenth of the band, which converges')
    if (record%planned_tolerance > 0 .and. .not. scene%support%loop .and. .not. s%pressure_middle > 0) call push( &
      record%warnings, 'the middle of the band is open: nothing is promised of its pressure. Read the normal force')
  end subroutine push_stiffness_warnings

  !> Say what each support carries, and warn of a wave generator that takes more of the torque than balls let it.
  subroutine judge_load_path(scene, torque, sums, record)
    type(scene_t), intent(in) :: scene        !< of the run
    real(dp), intent(in) :: torque            !< of the step that its results are of [N m]
    type(sums_t), intent(in) :: sums          !< of that step
    type(record_t), intent(inout) :: record   !< gets warnings
    real(dp), parameter :: allowed = 2  !< times the torque over the ratio: losses of a real drive
    real(dp), parameter :: unbalanced = 1e-3_dp  !< of the torque: what a reader of four digits sees
    character(len=:), allocatable :: line
    real(dp) :: real_one
    if (.not. abs(torque) > 0) return
    associate (t => sums%torque)
      line = 'the hub '//rounded(t%hub, torque)
      if (scene%support%loop) line = 'the teeth '//rounded(torque - t%hub - t%wave_generator - t%ring_springs, torque)
      call say('torque    carried by '//line//', the wave generator '//rounded(t%wave_generator, torque)// &
        ', springs of the ring '//rounded(t%ring_springs, torque)//' N m')
      if (abs(t%balance) > unbalanced*abs(torque)) call push(record%warnings, rounded(abs(t%balance))//' of '// &
        to_text(torque)//' N m are out of balance: facets of formed faces do not meet. Raise mesh.divisions, or '// &
        'leave mesh.ring_divisions at 0')
      if (scene%support%loop) return  ! drive_warnings judges the whole loop
      real_one = abs(torque)*2/scene%teeth
      if (.not. abs(t%wave_generator) > allowed*real_one) return
      line = 'the wave generator carries '//rounded(t%wave_generator)//' of '//to_text(torque)// &
        ' N m; one that turns on balls carries about the torque over the ratio, '//rounded(real_one)//" N m. With support "// &
        "'hub' and wave_generator.ring_tangent = 'free' the ring slides on the cam"
    end associate
    call push(record%warnings, line)
  end subroutine judge_load_path
end module hd_last_words
