! SPDX-License-Identifier: GPL-3.0-or-later
!> Keys of the whole drive, for the one table of hd_parameters.
module hd_drive_keys
  use hd_kinds, only: dp
  use hd_parameter_row, only: parameter_table_t, add_choice, add_integer, add_real, add_reals, tolerate
  use hd_scene, only: scene_t
  implicit none
  private
  public :: add_drive_keys

contains

  !> The whole drive: balls and loop.
  subroutine add_drive_keys(s, t)
    type(scene_t), intent(inout), target :: s  !< scene
    type(parameter_table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call add_integer(t, 'bearing', 'balls', 'model', s%balls, 0, 200, &
      "balls of the flexible bearing, with support 'drive'; 0: none, the wave generator is rigid or stands on "// &
      'wave_generator.ball_stiffness')
    call add_choice(t, 'bearing', 'model', 'model', s%bearing_model, 'auto given', &
      'with run.tolerance; auto: the simplest of a rigid wave generator, an even spring and the balls that keeps it; '// &
      'given: as the other keys say')
    call add_real(t, 'bearing', 'ball_diameter', 'model', s%ball_diameter, 'm', 0._dp, big, &
      'diameter of a ball')
    call tolerate(t, 0.1_dp, 'value', 'estimate')
    call add_real(t, 'bearing', 'inner_conformity', 'model', s%inner_conformity, '', 0.5_dp, big, &
      'radius of the inner groove over the diameter of the ball')
    call tolerate(t, 0.005_dp, '', '0.515 to 0.53 usual')
    call add_real(t, 'bearing', 'outer_conformity', 'model', s%outer_conformity, '', 0.5_dp, big, &
      'radius of the outer groove over the diameter of the ball')
    call tolerate(t, 0.005_dp, '', '0.515 to 0.53 usual')
    call add_real(t, 'bearing', 'groove_depth', 'model', s%groove_depth, 'm', 0._dp, big, &
      "depth of the balls' groove in the outer ring, below its inner face; the groove has the radius outer_conformity times "// &
      'ball_diameter; 0: no groove', closed=.true.)
    call add_real(t, 'bearing', 'clearance', 'assembly', s%ball_clearance, 'm', -big, big, &
      'radial clearance between ball and grooves before the bearing is bent; negative: preload. The fit on the cam leaves '// &
      'between none and half of the internal clearance across the diameter', closed=.true.)
    call tolerate(t, 1._dp, 'play', 'ISO 5753-1, normal class')
    call add_real(t, 'bearing', 'cage_angle_deg', 'assembly', s%cage_angle_deg, 'deg', -360._dp, 360._dp, &
      'place of the first ball, from the long axis', closed=.true.)
    call add_real(t, 'bearing', 'ball_e', 'model', s%ball_e, 'Pa', 0._dp, big, "Young's modulus of the balls")
    call add_real(t, 'bearing', 'ball_nu', 'model', s%ball_nu, '', -1._dp, 0.5_dp, "Poisson's ratio of the balls")
    call add_real(t, 'bearing', 'ball_rate', 'model', s%ball_rate, 'N/m^1.5', 0._dp, big, &
      'force of a ball over its approach to the power 3/2; 0: by Hertz from diameter, grooves and materials', closed=.true.)
    call add_choice(t, 'bearing', 'axial_hold', 'model', s%axial_hold, 'grooves fast', &
      'what keeps the ring in place along the axis. grooves: the balls, each by its force and the sections of its grooves; '// &
      'fast: the middle of its inner face does not move along the axis')
    call add_real(t, 'bearing', 'patch_length', 'model', s%patch_length, 'm', 0._dp, big, &
      "length of the part of the ring that carries a ball, along the ball's way; 0: the ring's thickness, or a facet if "// &
      'that is longer', closed=.true.)
    call add_real(t, 'bearing', 'patch_width', 'model', s%patch_width, 'm', 0._dp, big, &
      'width of this part, along the axis; 0: likewise', closed=.true.)
    call add_reals(t, 'loop', 'torques', 'load', s%torques, 'N m', -big, big, &
      "torques at the cup's bottom, one after the other, each reached in load.torque_steps, with support 'drive'; 0: "// &
      'load.torque, 0, -load.torque, 0, load.torque', s%torque_count)
    call add_choice(t, 'loop', 'history', 'load', s%history, 'loop assembled turned', &
      'what the drive has been through where K1 to K3 are read. loop: the torque has gone up and down once, as on a bench; '// &
      'assembled: the wave generator was pushed in; turned: it has then made one turn')
    call add_real(t, 'loop', 'torque_1', 'load', s%torque_1, 'N m', 0._dp, big, 'T1 of the catalogue: K1 is the chord up to it')
    call add_real(t, 'loop', 'torque_2', 'load', s%torque_2, 'N m', 0._dp, big, 'T2 of the catalogue: K2 from T1 to T2, K3 beyond')
    call add_real(t, 'loop', 'rated_torque', 'load', s%rated_torque, 'N m', 0._dp, big, &
      'rated torque of the drive: lost motion is read at 4 % of it')
    call add_integer(t, 'turning', 'positions', 'load', s%turning_positions, 0, 10000, &
      "places of the turning wave generator at which the drive is solved again after the loop, with support 'drive'; 0: none")
    call add_real(t, 'turning', 'range_deg', 'load', s%turning_range_deg, 'deg', 0._dp, 3600._dp, &
      'turn of the wave generator against the circular spline that the positions divide; 0: until the next ball stands where '// &
      'one stood, without balls the next tooth', closed=.true.)
    call add_real(t, 'turning', 'torque', 'load', s%turning_torque, 'N m', -big, big, &
      'torque held there; 0: loop.rated_torque', closed=.true.)
    call add_real(t, 'fatigue', 'tensile_strength', 'load', s%tensile_strength, 'Pa', 0._dp, big, &
      "tensile strength of the flexspline, end of Goodman's line; the default is that of 40CrNiMoA by GB/T 3077, 980 MPa and "// &
      'more')
    call add_real(t, 'fatigue', 'fatigue_limit', 'load', s%fatigue_limit, 'Pa', 0._dp, big, &
      "fatigue limit of the flexspline in alternating stress, beginning of Goodman's line; half the tensile strength is an "// &
      'estimate')
    call add_real(t, 'fatigue', 'notch_factor', 'load', s%notch_factor, '', 0._dp, big, &
      "factor on the stress amplitude: the smooth rim has no tooth roots, so their notch factor is the user's to give")
  end subroutine add_drive_keys
end module hd_drive_keys
