! SPDX-License-Identifier: GPL-3.0-or-later
!> The one table of parameters: it reads, checks, echoes and explains every key of the input file.
module hd_parameters
  use hd_kinds, only: dp, i8
  use hd_text, only: string_t, push, to_text, exact, join, suggestion, lower, unquoted, to_number
  use hd_parameter_row, only: parameter_t, parameter_table_t, add_integer, add_real, add_reals, add_choice, &
    tolerate, close_table
  use hd_unit, only: in_unit, other_units
  use hd_cup_sections, only: add_cup_keys
  use hd_drive_keys, only: add_drive_keys
  use hd_input_tolerances, only: take_tolerances
  use hd_scene, only: scene_t
  use hd_support, only: support_names, support_words
  use hd_surface_keys, only: add_surface_keys, add_fit_keys
  implicit none
  private
  public :: parameter_t, parameter_table_t, new_table, groups_of, keys_of, assign_words, value_text, &
    value_count, range_text

  !> Over the mean clearance: of two even zones, 25 and 11 um wide to 50 mm, 95 % of the sums lie within it of the mean.
  real(dp), parameter :: fit_width = 0.79_dp

contains

  !> Table of all keys, tied to a scene; the scene must live as long as the table.
  subroutine new_table(scene, table)
    type(scene_t), intent(inout), target :: scene  !< holds the values
    type(parameter_table_t), intent(out) :: table            !< keys
    integer :: i
    call add_shape_keys(scene, table)
    call add_wave_generator_keys(scene, table)
    call add_load_keys(scene, table)
    call add_solver_keys(scene, table)
    call add_surface_keys(scene%surface, table)
    call add_fit_keys(scene%fit, table)
    call close_table(table)
    do i = 1, size(table%rows)
      table%rows(i)%default = value_text(table%rows(i))
    end do
    call take_tolerances(scene%tolerances, table)
  end subroutine new_table

  !> Geometry, material and mesh.
  subroutine add_shape_keys(s, t)
    type(scene_t), intent(inout), target :: s  !< scene
    type(parameter_table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call add_integer(t, 'hd_input', 'version', 'output', s%version, 1, 1, 'format of this file')
    call add_choice(t, 'run', 'title', 'output', s%title, '', 'one line that names the run in its results')
    call add_real(t, 'run', 'tolerance', 'control', s%planned_tolerance, '', 0._dp, 0.5_dp, &
      'relative error that tangent K_TS, rotation, normal force and mid-band pressure may have, or K1 to K3 of a whole '// &
      'drive; element, kinematics, load steps and mesh are chosen for it; 0: all as given', closed=.true.)
    call add_choice(t, 'run', 'wanted', 'control', s%wanted, '', &
      "results that run.tolerance is for, parted by blanks, such as 'k2 k3'; empty: those that it names, and the pressure field")
    call add_choice(t, 'run', 'band', 'output', s%with_band, 'auto .false. .true.', &
      "95 % band of what a loop says, by the tolerances of its inputs, with support 'drive'; auto: small tolerances by "// &
      'derivatives, others by runs on a coarse mesh, no band of K_TS, none where run.gradient has none; .true.: all by runs')
    call add_choice(t, 'run', 'tolerances', 'output', s%tolerances, '', &
      "tolerances of your own for the band, half widths in the place of those stated here: 'wave_generator.clearance=2 um, "// &
      "load.spline=0'; 0 leaves an input out")
    call add_choice(t, 'run', 'gradient', 'control', s%with_gradient, '.false. .true.', &
      'derivatives of the results by every number of the drive that is in use, by adjoint differentiation along the load '// &
      'steps, under small displacements')
    call add_real(t, 'geometry', 'bore_radius', 'model', s%bore_radius, 'm', 0._dp, big, &
      'contact radius: bore of the flexspline, outside of the ring')
    call add_real(t, 'geometry', 'wall_thickness', 'model', s%wall_thickness, 'm', 0._dp, big, &
      'wall of the cup behind the toothed rim')
    call tolerate(t, 0.1_dp, 'value', 'estimate')
    call add_real(t, 'geometry', 'rim_thickness', 'model', s%rim_thickness, 'm', 0._dp, big, &
      'smooth rim as stiff as the toothed one, 1.67^(1/3) times the wall')
    call tolerate(t, 0.1_dp, 'value', 'estimate')
    call add_real(t, 'geometry', 'rim_length', 'model', s%rim_length, 'm', 0._dp, big, 'rim, measured from the opening')
    call add_real(t, 'geometry', 'rim_taper', 'model', s%rim_taper, 'm', 0._dp, big, 'length over which the rim thins to the wall')
    call add_real(t, 'geometry', 'cup_length', 'model', s%cup_length, 'm', 0._dp, big, &
      'from the opening to the outside of the bottom')
    call tolerate(t, 0.1_dp, 'value', 'estimate')
    call add_real(t, 'geometry', 'bottom_thickness', 'model', s%bottom_thickness, 'm', 0._dp, big, 'bottom of the cup')
    call tolerate(t, 0.3_dp, 'value', "a maker's diaphragms")
    call add_real(t, 'geometry', 'hub_radius', 'model', s%hub_radius, 'm', 0._dp, big, 'radius at which the bottom is held')
    call tolerate(t, 0.05_dp, 'value', 'bolt circle, half a head')
    call add_real(t, 'geometry', 'ring_thickness', 'model', s%ring_thickness, 'm', 0._dp, big, 'outer ring of the flexible bearing')
    call tolerate(t, 0.1_dp, 'value', 'estimate')
    call add_real(t, 'geometry', 'band_start', 'model', s%band_start, 'm', 0._dp, big, &
      'contact band: distance behind the opening', closed=.true.)
    call add_real(t, 'geometry', 'band_length', 'model', s%band_length, 'm', 0._dp, big, &
      'contact band: length, equal to the width of the ring')
    call tolerate(t, 0.1_dp, 'value', 'widths of thin bearings')
    call add_cup_keys(s, t)
    call add_real(t, 'material', 'flexspline_e', 'model', s%flexspline_e, 'Pa', 0._dp, big, "Young's modulus of the flexspline")
    call add_real(t, 'material', 'flexspline_nu', 'model', s%flexspline_nu, '', -0.5_dp, 0.5_dp, &
      "Poisson's ratio of the flexspline")
    call add_real(t, 'material', 'ring_e', 'model', s%ring_e, 'Pa', 0._dp, big, "Young's modulus of the ring")
    call add_real(t, 'material', 'ring_nu', 'model', s%ring_nu, '', -0.5_dp, 0.5_dp, "Poisson's ratio of the ring")
    call add_real(t, 'material', 'yield_strength', 'joint', s%yield_strength, 'Pa', 0._dp, big, &
      'yield strength of the flexspline, the softer body; its hardness is 2.8 times that')
    call add_real(t, 'material', 'ring_yield_strength', 'load', s%ring_yield_strength, 'Pa', 0._dp, big, &
      'yield strength of the ring (hardened bearing steel: 1.7e9 to 2.2e9)')
    call add_integer(t, 'mesh', 'divisions', 'model', s%divisions, 8, 100000, 'cells round the circumference')
    call add_integer(t, 'mesh', 'band_facets', 'model', s%band_facets, 1, 10000, 'contact facets along the band')
    call add_integer(t, 'mesh', 'ring_divisions', 'model', s%ring_divisions, 0, 100000, 'cells round the ring; 0: as divisions')
    call add_integer(t, 'mesh', 'ring_facets', 'model', s%ring_facets, 0, 10000, 'cells along the ring; 0: as band_facets')
    call add_integer(t, 'mesh', 'wall_elements', 'model', s%wall_elements, 0, 10000, &
      'cells along the wall behind band and rim; 0: as long as the facets')
    call add_integer(t, 'mesh', 'bottom_elements', 'model', s%bottom_elements, 0, 10000, &
      'cells along the bottom, all alike; 0: as long as the facets, shorter at the clamped edge')
    call add_integer(t, 'mesh', 'through_wall', 'model', s%through_wall, 1, 100, 'cells through wall, rim and bottom')
    call add_integer(t, 'mesh', 'through_ring', 'model', s%through_ring, 1, 100, 'cells through the ring')
    call add_real(t, 'mesh', 'edge_length', 'model', s%edge_length, 'm', 0._dp, big, &
      'length of the shortest cells, on either side of both edges of the band; from there each cell is longer by half, up to '// &
      'the others; 0: all equal', closed=.true.)
    call add_choice(t, 'mesh', 'element', 'model', s%element, 'hex8 hex8i hex20r', &
      'hexahedron. hex8: plain; hex8i: with incompatible modes; hex20r: quadratic, reduced integration')
    call add_real(t, 'mesh', 'memory_limit_mb', 'model limit', s%memory_limit_mb, 'MB', 0._dp, big, &
      'larger meshes are refused before they are tried; 0: 80 % of what machine, batch job and ulimit leave', closed=.true.)
  end subroutine add_shape_keys

  !> Wave generator.
  subroutine add_wave_generator_keys(s, t)
    type(scene_t), intent(inout), target :: s  !< scene
    type(parameter_table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call add_real(t, 'wave_generator', 'w', 'cam', s%w, 'm', 0._dp, big, &
      'radial deformation (deformation coefficient)', closed=.true.)
    call tolerate(t, 0.03_dp, 'value', 'estimate')
    call add_choice(t, 'wave_generator', 'cam', 'cam', s%cam, 'ellipse cosine arcs table', &
      'profile. ellipse: semi-axes r + w, r - w; cosine: radius r + w cos(lobes theta); arcs: four arcs of circles; table: '// &
      'measured, from cam_file. Ellipse and cosine differ by the order w^2/r, which small displacements leave out')
    call add_integer(t, 'wave_generator', 'lobes', 'cam', s%lobes, 2, 100, "waves of the cam 'cosine'")
    call add_real(t, 'wave_generator', 'arc_angle_deg', 'cam', s%arc_angle_deg, 'deg', 0._dp, 90._dp, &
      "cam 'arcs': half angle of the arcs at the ends of the long axis (45: semi-axes r + w, r - w)")
    call add_choice(t, 'wave_generator', 'cam_file', 'cam', s%cam_file, '', &
      "cam 'table': CSV file of one turn with the columns theta_deg,radius_m; w is then half the range of its radii")
    call add_choice(t, 'wave_generator', 'perimeter', 'cam', s%perimeter, 'kept curve given', &
      "length of the circle that is bent to the cam, the ring's inner face. kept: as it is, on a curve parallel to the "// &
      'profile; curve: that of the profile; given: perimeter_length')
    call add_real(t, 'wave_generator', 'perimeter_length', 'cam', s%perimeter_length, 'm', 0._dp, big, &
      "length of the ring's inner face on the cam with perimeter 'given'", closed=.true.)
    call add_choice(t, 'wave_generator', 'ring_tangent', 'model', s%ring_tangent, 'auto free follow', &
      'inner face of the ring, round the axis. free: it slides, as on balls; follow: it is held where the cam puts it, so '// &
      'that torque goes through friction into the wave generator, as in the paper and in no drive; auto: free, but held '// &
      "where nothing else holds the ring (support 'bearing', or no friction and large displacements)")
    call add_choice(t, 'wave_generator', 'ring_contact', 'model', s%ring_contact, 'tied unilateral', &
      'ring on the wave generator. tied: held; unilateral: pressed against it, without tension and friction (hex8, hex8i)')
    call add_real(t, 'wave_generator', 'ball_stiffness', 'model', s%ball_stiffness, 'N/m', 0._dp, big, &
      'radial stiffness of all balls together, linear, spread evenly over the inner face of a tied ring; 0: rigid', closed=.true.)
    call add_choice(t, 'wave_generator', 'shape', 'model', s%shape, 'pressed as_formed', &
      'pressed: a round flexspline is pressed onto the wave generator; as_formed: flexspline and ring have its shape without '// &
      'stress')
    call add_real(t, 'wave_generator', 'cone_angle_deg', 'cam', s%cone_angle_deg, 'deg', -10._dp, 10._dp, &
      'slope of the cam along the axis: the deformation is w in the middle of the band and falls towards the bottom', closed=.true.)
    call add_real(t, 'wave_generator', 'eccentricity', 'assembly', s%eccentricity, 'm', 0._dp, big, &
      'shift of the wave generator off the axis, an error of installation', closed=.true.)
    call add_real(t, 'wave_generator', 'eccentricity_angle_deg', 'assembly', s%eccentricity_angle_deg, 'deg', -360._dp, 360._dp, &
      'direction of the shift, from the long axis', closed=.true.)
    call add_real(t, 'wave_generator', 'interference', 'assembly', s%interference, 'm', 0._dp, big, &
      'radial interference of ring and flexspline; where it is given without clearance, the clearance is 0', closed=.true.)
    call tolerate(t, fit_width, 'fit', 'ISO 286 H7, ISO 492')
    call add_real(t, 'wave_generator', 'clearance', 'assembly', s%clearance, 'm', 0._dp, big, &
      'radial clearance of the bearing in the flexspline before it is bent. It and interference are one fit: where a file, or '// &
      'the keys given beside it, hold one of them alone, the other is 0. H7 bore and normal bearing: 0 to 15 um to 30 mm, '// &
      '0 to 18 um to 50 mm, 0 to 21.5 um to 80 mm, 0 to 25 um to 120 mm', closed=.true.)
    call tolerate(t, fit_width, 'fit', 'ISO 286 H7, ISO 492')
  end subroutine add_wave_generator_keys

  !> Contact and load.
  subroutine add_load_keys(s, t)
    type(scene_t), intent(inout), target :: s  !< scene
    type(parameter_table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call add_choice(t, 'contact', 'mode', 'assembly', s%contact_mode, 'frictional frictionless bonded', &
      'contact of ring and flexspline')
    call add_real(t, 'contact', 'friction', 'assembly', s%friction, '', 0._dp, 10._dp, 'Coulomb coefficient mu', closed=.true.)
    call tolerate(t, 0.05_dp, '', 'steel, greased to dry')
    call add_real(t, 'contact', 'torque_friction', 'load', s%torque_friction, '', 0._dp, 10._dp, &
      'coefficient while the torque acts; a large one lets nothing slip, which tells slip from elasticity; 0: as friction', &
      closed=.true.)
    call add_choice(t, 'contact', 'law', 'model', s%contact_law, 'hard joint joint_elastic', &
      'hard: faces do not penetrate; joint: the rough joint gives way, in normal and tangential direction; joint_elastic: '// &
      'the same, but k_t does not fall under shear')
    call add_real(t, 'contact', 'zero_pressure', 'model', s%zero_pressure, 'Pa', 0._dp, 1e9_dp, &
      "pressure at which the gap counts as 0 with the law 'joint'")
    call add_choice(t, 'contact', 'slave', 'model', s%slave, 'ring cup', &
      'side that carries the multipliers and the facets of the results')
    call add_choice(t, 'load', 'support', 'model', s%support%name, support_names, support_words)
    call add_choice(t, 'load', 'torque_load', 'model', s%torque_load, 'uniform teeth', &
      'where the torque enters. uniform: as even shear on the outside of the rim; teeth: by forces of the tooth pairs around '// &
      'the long axis')
    call add_integer(t, 'load', 'teeth', 'model', s%teeth, 8, 100000, 'teeth of the flexspline')
    call add_integer(t, 'load', 'tooth_pairs', 'model', s%tooth_pairs, 2, 100000, &
      'pairs in mesh at both ends of the long axis together')
    call add_real(t, 'load', 'pressure_angle_deg', 'model', s%pressure_angle_deg, 'deg', 0._dp, 60._dp, &
      'pressure angle of the teeth: the radial force, inward, is the tangential one times its tangent', closed=.true.)
    call tolerate(t, 3._dp, '', 'estimate')
    call add_real(t, 'load', 'tooth_stiffness', 'model', s%tooth_stiffness, 'N/m', 0._dp, big, &
      'stiffness of a pair of teeth along its normal; the default is 14 N/(mm um) times a width of 9 mm')
    call tolerate(t, 0.3_dp, 'value', 'spread of ISO 6336 figures')
    call add_reals(t, 'load', 'tooth_gaps', 'load', s%gaps, 'm', 0._dp, big, &
      'clearance of every pair at one end of the long axis, or at both, in the order of teeth.csv at tooth_phase 0, on a '// &
      'cubic between them at others; in the place of tooth_clearance; 0: none is given', s%gap_count)
    call tolerate(t, 1e-6_dp/17.5e-3_dp, 'bore', 'estimate')
    call add_reals(t, 'load', 'tooth_gaps_back', 'load', s%gaps_back, 'm', 0._dp, big, &
      'clearance of the other flank of every pair, that a negative torque presses, where it differs from tooth_gaps; as many '// &
      'values; 0: none is given', s%gap_back_count)
    call add_real(t, 'load', 'tooth_clearance', 'load', s%tooth_clearance, 'm', 0._dp, big, &
      'clearance of the outermost pairs; it falls to 0 at the long axis, with the square of the distance', closed=.true.)
    call add_real(t, 'load', 'tooth_friction', 'load', s%tooth_friction, '', 0._dp, 1._dp, &
      "Coulomb coefficient of the flanks, with support 'drive'; 0: without friction", closed=.true.)
    call add_choice(t, 'load', 'spline', 'model', s%spline, 'free rigid', &
      "circular spline, with support 'drive'. free: an elastic ring of the flexspline's material under the forces of the "// &
      'teeth, which no housing holds round its outside; rigid: as a housing without play would hold it. A real one lies between')
    call tolerate(t, 1._dp, '', 'housing without play')
    call add_real(t, 'load', 'spline_diameter', 'model', s%spline_diameter, 'm', 0._dp, big, &
      'outer diameter of the circular spline; 0: 1.4 times that of the bore, as catalogues have it (1.35 to 1.43)', closed=.true.)
    call add_real(t, 'load', 'spline_root_diameter', 'model', s%spline_root_diameter, 'm', 0._dp, big, &
      "diameter of the roots of the circular spline's teeth, where its ring begins; 0: a quarter of a module beyond the tips "// &
      'of teeth of 2.25 modules on the long axis', closed=.true.)
    call tolerate(t, 5e-3_dp, 'value', 'half a module of ratio 100')
    call add_real(t, 'load', 'spline_width', 'model', s%spline_width, 'm', 0._dp, big, &
      'width of the circular spline, amid the rim, over which teeth touch; 0: the length of the rim', closed=.true.)
    call tolerate(t, 0.33_dp, 'value', 'rings of flat gears, length of the rim')
    call add_real(t, 'load', 'tooth_phase', 'assembly', s%tooth_phase, '', -0.5_dp, 0.5_dp, &
      'shift of the tooth pairs round the axis, in pitches; at 0 they lie symmetric about the long axis', closed=.true.)
    call add_real(t, 'load', 'torque', 'load', s%torque, 'N m', -big, big, 'torque at the end of the torque step', closed=.true.)
    call add_real(t, 'load', 'support_stiffness', 'model', s%support_stiffness, 'N/m', 0._dp, big, &
      'soft springs that hold the hub of a bearing support in its plane, and a free ring tangentially')
    call add_integer(t, 'load', 'assembly_steps', 'assembly', s%assembly_steps, 1, 100000, 'load steps of the assembly')
    call add_integer(t, 'load', 'torque_steps', 'load', s%torque_steps, 0, 100000, &
      'load steps of the torque, of each ramp of a loop, which also stops where it is read: at T1, T2, no torque and 4 % of '// &
      'the rated one')
    call add_choice(t, 'load', 'tangent_steps', 'load', s%tangent_steps, 'needed all last none', &
      'load steps that get a tangent K_TS. needed: those that a result needs, in a loop the one that its results are of, else '// &
      'all from the end of the assembly on; all: these all; last: the last one alone, without a secant, in a loop as needed')
    call add_drive_keys(s, t)
  end subroutine add_load_keys

  !> Solver, joint and output.
  subroutine add_solver_keys(s, t)
    type(scene_t), intent(inout), target :: s  !< scene
    type(parameter_table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call add_choice(t, 'solver', 'method', 'model', s%method, 'auto condensed newton', &
      'how the equations are solved. condensed: on the contact face, bodies by harmonics; newton: all unknowns, '// &
      'with solver.factors; auto: the cheapest by prediction')
    call add_choice(t, 'solver', 'factors', 'model', s%factors, 'auto exact harmonic', &
      'what is factored for Newton. exact: the matrix itself (LU); harmonic: the round undeformed bodies, which '// &
      'precondition GMRES; auto: the cheapest by prediction')
    call add_choice(t, 'solver', 'kinematics', 'model', s%kinematics, 'linear nonlinear auto', &
      'linear: small displacements; nonlinear: large ones (total Lagrangian, method newton); auto: what run.tolerance needs, '// &
      'linear without it')
    call add_choice(t, 'solver', 'start', 'assembly', s%start, 'auto rest coarser', &
      'first guess of a load step. rest: from the steps before; coarser: from a mesh of half as many facets either way that '// &
      'is solved before (hex8, hex8i); auto: coarser where it saves time')
    call add_choice(t, 'solver', 'symmetry', 'assembly', s%symmetry, 'auto full half quarter', &
      'part of the contact face that is solved. auto: what the scene allows in each load step; full: all; half, quarter: so '// &
      'much in the assembly (not with exact)')
    call add_real(t, 'solver', 'tolerance', 'assembly', s%tolerance, '', 1e-14_dp, 0.01_dp, &
      'relative residual of forces and contact law; with run.tolerance a thousandth of that, if it is more', closed=.true.)
    call add_integer(t, 'solver', 'max_iterations', 'assembly limit', s%max_iterations, 1, 10000, &
      'Newton iterations of one attempt at a load step')
    call add_integer(t, 'solver', 'max_cuts', 'assembly limit', s%max_cuts, 0, 40, 'halvings of a load step that does not converge')
    call add_real(t, 'solver', 'time_limit_s', 'control', s%time_limit_s, 's', 0._dp, big, &
      'clock time after which the run stops in order, to be resumed; 0: none', closed=.true.)
    call add_choice(t, 'joint', 'model', 'joint', s%joint_model, 'hu2023 spectrum boundary_elements table auto', &
      'where the stiffness of the joint comes from. hu2023: statistical model of Hu et al., rests on r_m and s_min; '// &
      'spectrum: theory from the power spectrum; boundary_elements: table_file, solved on a map by hdengine joint; table: '// &
      'table_file, measured; auto: spectrum where it holds at the pressures of a coarse trial, else table_file as '// &
      'boundary_elements, or spectrum with a warning')
    call add_choice(t, 'joint', 'table_file', 'joint', s%joint_table, '', &
      'CSV of the models boundary_elements and table: columns pressure_pa, k_n_pa_per_m and, if known, k_t_pa_per_m')
    call add_choice(t, 'joint', 'spectrum_file', 'joint', s%joint_spectrum, '', &
      'CSV of the model spectrum, written by hdengine joint: columns q_per_m, height_variance_m2 and, if known, '// &
      'waves_per_m2; empty: from D, G, sample_length, shortest_wavelength')
    call add_choice(t, 'joint', 'from_fit', 'joint', s%joint_from_fit, '', &
      "folder that 'hdengine surface' wrote: its scene.nml gives D, G, L, L_s and the model, but for keys that are given here")
    call add_real(t, 'joint', 'fractal_dimension', 'joint', s%fractal_dimension, '', 2._dp, 3._dp, 'surface fractal dimension D')
    call add_real(t, 'joint', 'roughness', 'joint', s%roughness, 'm', 0._dp, 1e-4_dp, 'fractal roughness G')
    call add_real(t, 'joint', 'gamma', 'joint', s%gamma, '', 1._dp, big, 'frequency ratio of the Weierstrass-Mandelbrot function')
    call add_real(t, 'joint', 'sample_length', 'joint', s%sample_length, 'm', 0._dp, big, &
      'L, the longest wavelength; the reference area is L^2')
    call add_real(t, 'joint', 'shortest_wavelength', 'joint', s%shortest_wavelength, 'm', 0._dp, big, &
      'L_s, the shortest wavelength')
    call add_real(t, 'joint', 'asperity_radius', 'joint', s%asperity_radius, 'm', 0._dp, big, 'r_m, half the base of an asperity')
    call add_real(t, 'joint', 's_min', 'joint', s%s_min, 'm^2', 0._dp, big, 'smallest contact spot; 0: pi (L_s/2)^2', closed=.true.)
    call add_real(t, 'joint', 'hardness', 'joint', s%hardness, 'Pa', 0._dp, big, &
      'hardness of the softer body; 0: 2.8 yield_strength', closed=.true.)
    call add_choice(t, 'joint', 'closure', 'joint', s%closure, 'nominal paper', &
      'what the pressure is. nominal: force on the reference area; paper: mean pressure of the real contact, Eq. 28 as '// &
      'printed')
    call add_choice(t, 'joint', 'plastic_spots', 'joint', s%plastic_spots, 'none elastic', &
      'stiffness of spots that are fully plastic. none: 0, as in the paper; elastic: that of their elastic unloading, 2 E a')
    call add_choice(t, 'output', 'vtu', 'output', s%vtu, 'none last all', 'steps written for ParaView')
    call add_choice(t, 'output', 'contact', 'output', s%contact_table, 'all last', &
      'steps of contact.csv; last: the one that the results are of')
    call add_reals(t, 'output', 'positions', 'output', s%positions, 'm', 0._dp, big, &
      'Positions I, II, III: distances from the front edge of the contact band')
  end subroutine add_solver_keys

  !> Names of the groups, in order.
  function groups_of(table) result(names)
    type(parameter_table_t), intent(in) :: table  !< table
    type(string_t), allocatable :: names(:)
    integer :: i
    allocate (names(0))
    do i = 1, size(table%rows)
      if (i > 1) then
        if (table%rows(i)%group == table%rows(i - 1)%group) cycle
      end if
      call push(names, table%rows(i)%group)
    end do
  end function groups_of

  !> Names of the keys of a group.
  function keys_of(table, group) result(names)
    type(parameter_table_t), intent(in) :: table      !< table
    character(len=*), intent(in) :: group   !< group
    type(string_t), allocatable :: names(:)
    integer :: i
    allocate (names(0))
    do i = 1, size(table%rows)
      if (table%rows(i)%group == group) call push(names, table%rows(i)%key)
    end do
  end function keys_of

  !> Present value as text that reads back exactly.
  function value_text(p) result(s)
    type(parameter_t), intent(in) :: p  !< row
    character(len=:), allocatable :: s
    integer :: i
    if (associated(p%integer)) then
      s = to_text(p%integer)
    else if (associated(p%real)) then
      s = exact(p%real)
    else if (associated(p%reals)) then
      s = exact(p%reals(1))
      do i = 2, value_count(p)
        s = s//', '//exact(p%reals(i))
      end do
    else
      s = "'"//doubled(trim(p%text))//"'"
    end if
  end function value_text

  !> How many of the numbers of a key count.
  pure integer function value_count(p)
    type(parameter_t), intent(in) :: p  !< row with numbers
    value_count = size(p%reals)
    if (associated(p%count)) value_count = p%count
  end function value_count

  !> Quotes doubled.
  pure function doubled(s) result(t)
    character(len=*), intent(in) :: s  !< text
    character(len=:), allocatable :: t
    integer :: i
    t = ''
    do i = 1, len(s)
      t = t//s(i:i)
      if (s(i:i) == "'") t = t//"'"
    end do
  end function doubled

  !> Set a value from words; `what` says what is wrong with them (empty: nothing), `hint` what would be right.
  subroutine assign_words(p, words, what, hint)
    type(parameter_t), intent(inout) :: p                !< row, its value is set
    type(string_t), intent(in) :: words(:)               !< words as in the file
    character(len=:), allocatable, intent(out) :: what   !< mistake
    character(len=:), allocatable, intent(out) :: hint   !< valid values
    type(string_t), allocatable :: plain(:)
    real(dp), allocatable :: x(:)
    integer(i8) :: n, wanted
    integer :: i
    what = ''
    hint = ''
    p%given = .true.
    wanted = 1
    if (associated(p%reals)) wanted = size(p%reals)
    if (associated(p%count)) wanted = min(max(1, size(words)), size(p%reals))
    if (associated(p%text)) then
      call assign_text(p, words, what, hint)
      return
    end if
    allocate (x(1))
    if (associated(p%reals)) x = p%reals
    plain = words
    do i = 1, size(words)
      plain(i)%s = in_unit(words(i)%s, p%unit)
    end do
    call read_numbers(plain, x, n)
    if (associated(p%count)) then
      if (n > 0 .and. n <= size(p%reals)) wanted = n
    end if
    hint = 'valid: '//range_text(p)
    if (len(p%unit) > 0) hint = hint//' ['//p%unit//']'
    if (n < 0) then
      what = "'"//p%key//"' is not "//trim(merge('an integer', 'a number  ', associated(p%integer)))//": '"//words(-n)%s//"'"
      if (scan(words(1)%s, '0123456789') > 0 .and. len(other_units(p%unit)) > 0) hint = hint// &
        ', or between quotes with one of '//other_units(p%unit)
    else if (n /= wanted) then
      what = "'"//p%key//"' takes "//to_text(wanted)//' value(s), '//to_text(n)//' found'
    else if (associated(p%integer) .and. any(abs(x(:n) - nint(x(:n))) > 0)) then
      what = "'"//p%key//"' is not an integer: '"//words(1)%s//"'"
    else if (any(x(:n) < p%low .or. x(:n) > p%high) .or. (p%open_low .and. any(x(:n) <= p%low)) &
        .or. (p%open_high .and. any(x(:n) >= p%high))) then
      what = "'"//p%key//"' is out of range: "//join(words, ', ')
    else
      if (associated(p%integer)) p%integer = nint(x(1))
      if (associated(p%real)) p%real = x(1)
      if (associated(p%reals)) p%reals(:n) = x(:n)
      if (associated(p%count)) p%count = int(n)
    end if
  end subroutine assign_words

  !> Set a text value; quotes may be left out for a single word.
  subroutine assign_text(p, words, what, hint)
    type(parameter_t), intent(inout) :: p
    type(string_t), intent(in) :: words(:)
    character(len=:), allocatable, intent(inout) :: what, hint
    character(len=:), allocatable :: s
    integer :: i
    s = words(1)%s
    s = unquoted(s)
    if (size(p%choices) > 0) s = lower(s)
    if (scan(s, char(10)//char(13)) > 0) then
      what = "'"//p%key//"' has a line end: '"//s//"'"
      hint = 'valid: one line'
    else if (size(words) > 1) then
      what = "'"//p%key//"' takes 1 value(s), "//to_text(size(words))//' found'
      hint = 'put a text with blanks between quotes'
    else if (len(s) > len(p%text)) then
      what = "'"//p%key//"' is too long: "//to_text(len(s))//' characters'
      hint = 'valid: up to '//to_text(len(p%text))//' characters'
    else if (size(p%choices) > 0 .and. .not. any([(p%choices(i)%s == s, i=1, size(p%choices))])) then
      what = "'"//p%key//"' has no choice '"//s//"'"
      hint = suggestion(s, p%choices)
    else
      p%text = s
    end if
  end subroutine assign_text

  !> Numbers from words, `3*1.5` repeats; n < 0 names the first bad word. Numbers that find no room in x are counted alone.
  pure subroutine read_numbers(words, x, n)
    type(string_t), intent(in) :: words(:)  !< words
    real(dp), intent(out) :: x(:)           !< numbers
    integer(i8), intent(out) :: n           !< count, or minus the place of a bad word
    integer, parameter :: most_figures = 10   !< of a repeat count: their sum is an i8
    real(dp) :: number
    integer(i8) :: times
    integer :: i, star
    logical :: ok
    x = 0
    n = 0
    do i = 1, size(words)
      associate (s => words(i)%s)
        star = index(s, '*')
        times = 1
        ok = star <= 1 + most_figures .and. scan(s(:max(0, star - 1)), '+-') == 0
        if (star > 0 .and. ok) call to_number(s(:star - 1), times, ok)
        if (ok) call to_number(s(star + 1:), number, ok)
        if (.not. ok .or. times < 1) then
          n = -i
          return
        end if
        if (n < size(x)) x(n + 1:min(n + times, size(x, kind=i8))) = number
        n = n + times
      end associate
    end do
  end subroutine read_numbers

  !> Valid range in words.
  pure function range_text(p) result(s)
    type(parameter_t), intent(in) :: p  !< row
    character(len=:), allocatable :: s
    s = trim(merge('integer', 'number ', associated(p%integer)))
    if (p%low > -huge(1._dp)) s = s//trim(merge(' > ', ' >=', p%open_low))//' '//bound(p%low)
    if (p%low > -huge(1._dp) .and. p%high < huge(1._dp)) s = s//' and'
    if (p%high < huge(1._dp)) s = s//trim(merge(' < ', ' <=', p%open_high))//' '//bound(p%high)
  contains
    pure function bound(x) result(t)
      real(dp), intent(in) :: x
      character(len=:), allocatable :: t
      if (associated(p%integer)) then
        t = to_text(nint(x))
      else
        t = exact(x)
      end if
    end function bound
  end function range_text
end module hd_parameters
