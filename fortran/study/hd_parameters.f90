! SPDX-License-Identifier: GPL-3.0-or-later
!> The one table of parameters: it reads, checks, echoes and explains every key of the input file.
module hd_parameters
  use hd_kinds, only: dp
  use hd_text, only: string_t, push, to_text, exact, join, nearest_name, lower
  use hd_parameter_row, only: parameter_t, table_t, whole, number, numbers, text
  use hd_scene, only: scene_t, map_t, map_fit_t
  implicit none
  private
  public :: parameter_t, table_t, new_table, groups_of, keys_of, find_parameter, assign_words, value_text

contains

  !> Table of all keys, tied to a scene; the scene must live as long as the table.
  subroutine new_table(scene, table)
    type(scene_t), intent(inout), target :: scene  !< holds the values
    type(table_t), intent(out) :: table            !< keys
    integer :: i
    allocate (table%rows(0))
    call add_shape_keys(scene, table)
    call add_model_keys(scene, table)
    call add_map_keys(scene%map, table)
    call add_fit_keys(scene%map_fit, table)
    do i = 1, size(table%rows)
      table%rows(i)%default = value_text(table%rows(i))
    end do
  end subroutine new_table

  !> Geometry, material, mesh and wave generator.
  subroutine add_shape_keys(s, t)
    type(scene_t), intent(inout), target :: s  !< scene
    type(table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call whole(t, 'hd_input', 'version', s%version, 1, 1, 'format of this file')
    call text(t, 'run', 'title', s%title, '', 'one line that names the run in its results')
    call number(t, 'run', 'tolerance', s%promise, '', 0._dp, 0.5_dp, 'error promised of the limits of K_TS, normal '// &
      'force and mid-band pressure (relative): element, kinematics, load steps and mesh are chosen for it; 0: as given', &
      closed=.true.)
    call number(t, 'geometry', 'bore_radius', s%bore_radius, 'm', 0._dp, big, &
      'contact radius: bore of the flexspline, outside of the ring')
    call number(t, 'geometry', 'wall_thickness', s%wall_thickness, 'm', 0._dp, big, 'wall of the cup behind the toothed rim')
    call number(t, 'geometry', 'rim_thickness', s%rim_thickness, 'm', 0._dp, big, &
      'smooth rim as stiff as the toothed one, 1.67^(1/3) times the wall')
    call number(t, 'geometry', 'rim_length', s%rim_length, 'm', 0._dp, big, 'rim, measured from the opening')
    call number(t, 'geometry', 'rim_taper', s%rim_taper, 'm', 0._dp, big, 'length over which the rim thins to the wall')
    call number(t, 'geometry', 'cup_length', s%cup_length, 'm', 0._dp, big, 'from the opening to the outside of the bottom')
    call number(t, 'geometry', 'bottom_thickness', s%bottom_thickness, 'm', 0._dp, big, 'bottom of the cup')
    call number(t, 'geometry', 'hub_radius', s%hub_radius, 'm', 0._dp, big, 'radius at which the bottom is held')
    call number(t, 'geometry', 'ring_thickness', s%ring_thickness, 'm', 0._dp, big, 'outer ring of the flexible bearing')
    call number(t, 'geometry', 'band_start', s%band_start, 'm', 0._dp, big, &
      'contact band: distance behind the opening', closed=.true.)
    call number(t, 'geometry', 'band_length', s%band_length, 'm', 0._dp, big, &
      'contact band: length, equal to the width of the ring')
    call number(t, 'material', 'flexspline_e', s%flexspline_e, 'Pa', 0._dp, big, "Young's modulus of the flexspline")
    call number(t, 'material', 'flexspline_nu', s%flexspline_nu, '', -1._dp, 0.5_dp, "Poisson's ratio of the flexspline")
    call number(t, 'material', 'ring_e', s%ring_e, 'Pa', 0._dp, big, "Young's modulus of the ring")
    call number(t, 'material', 'ring_nu', s%ring_nu, '', -1._dp, 0.5_dp, "Poisson's ratio of the ring")
    call number(t, 'material', 'yield_strength', s%yield_strength, 'Pa', 0._dp, big, &
      'of the softer body, gives the hardness 2.8 sigma_s')
    call whole(t, 'mesh', 'divisions', s%divisions, 8, 100000, 'cells round the circumference')
    call whole(t, 'mesh', 'band_facets', s%band_facets, 1, 10000, 'contact facets along the band')
    call whole(t, 'mesh', 'ring_divisions', s%ring_divisions, 0, 100000, 'cells round the ring; 0: as divisions')
    call whole(t, 'mesh', 'ring_facets', s%ring_facets, 0, 10000, 'cells along the ring; 0: as band_facets')
    call whole(t, 'mesh', 'wall_elements', s%wall_elements, 0, 10000, &
      'cells along the wall behind band and rim; 0: as long as the facets')
    call whole(t, 'mesh', 'bottom_elements', s%bottom_elements, 0, 10000, 'cells along the bottom; 0: as long as the facets')
    call whole(t, 'mesh', 'through_wall', s%through_wall, 1, 100, 'cells through wall, rim and bottom')
    call whole(t, 'mesh', 'through_ring', s%through_ring, 1, 100, 'cells through the ring')
    call number(t, 'mesh', 'edge_length', s%edge_length, 'm', 0._dp, big, &
      'shortest cells, on either side of both edges of the band; from there they grow by half, up to the others; 0: all equal', &
      closed=.true.)
    call text(t, 'mesh', 'element', s%element, 'hex8 hex8i hex20r', &
      'hexahedron: plain, with incompatible modes, quadratic reduced')
    call number(t, 'mesh', 'memory_limit_mb', s%memory_limit_mb, 'MB', 0._dp, big, &
      'larger meshes are refused before they are tried; 0: 80 % of what machine, batch job and ulimit leave', closed=.true.)
    call number(t, 'wave_generator', 'w', s%w, 'm', 0._dp, big, 'radial deformation (deformation coefficient)', closed=.true.)
    call text(t, 'wave_generator', 'cam', s%cam, 'ellipse cosine', 'ellipse with semi-axes r + w, r - w, or w cos 2 theta')
    call text(t, 'wave_generator', 'ring_tangent', s%ring_tangent, 'follow free', &
      'inner face of the ring: inextensible displacement -(w/2) sin 2 theta, or free to slide')
    call text(t, 'wave_generator', 'ring_contact', s%ring_contact, 'tied unilateral', &
      'ring held on the wave generator, or pressed against it without tension and friction (hex8, hex8i)')
    call number(t, 'wave_generator', 'ball_stiffness', s%ball_stiffness, 'N/m', 0._dp, big, &
      'radial stiffness of all balls together, even over the inner face of a tied ring, linear; 0: rigid', closed=.true.)
    call text(t, 'wave_generator', 'shape', s%shape, 'pressed as_formed', &
      'round flexspline pressed onto the wave generator, or flexspline and ring stress-free in its shape')
    call number(t, 'wave_generator', 'cone_angle_deg', s%cone_angle_deg, 'deg', -10._dp, 10._dp, &
      "slope of the cam's generator: w falls towards the bottom, and is w in the middle of the band", closed=.true.)
    call number(t, 'wave_generator', 'eccentricity', s%eccentricity, 'm', 0._dp, big, 'installation eccentricity', closed=.true.)
    call number(t, 'wave_generator', 'eccentricity_angle_deg', s%eccentricity_angle_deg, 'deg', -360._dp, 360._dp, &
      'its direction from the long axis', closed=.true.)
    call number(t, 'wave_generator', 'interference', s%interference, 'm', -big, big, &
      'radial interference of ring and flexspline; negative: clearance', closed=.true.)
  end subroutine add_shape_keys

  !> Contact, load, solver, joint and output.
  subroutine add_model_keys(s, t)
    type(scene_t), intent(inout), target :: s  !< scene
    type(table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call text(t, 'contact', 'mode', s%contact_mode, 'frictional frictionless bonded', 'contact of ring and flexspline')
    call number(t, 'contact', 'friction', s%friction, '', 0._dp, 10._dp, 'Coulomb coefficient mu', closed=.true.)
    call number(t, 'contact', 'torque_friction', s%torque_friction, '', 0._dp, 10._dp, &
      'mu while the torque acts (large: no slip, to part slip from elasticity); 0: as friction', closed=.true.)
    call text(t, 'contact', 'law', s%contact_law, 'hard joint joint_elastic', &
      'faces that cannot penetrate, or the compliance of the rough joint (normal and tangential); joint_elastic: k_t without ' // &
      'its fall under shear')
    call number(t, 'contact', 'zero_pressure', s%zero_pressure, 'Pa', 0._dp, 1e9_dp, &
      "pressure at which the gap counts as 0 with the law 'joint'")
    call text(t, 'contact', 'slave', s%slave, 'ring cup', 'side that carries the multipliers and the facets of the results')
    call text(t, 'load', 'support', s%support, 'hub bearing teeth', 'cup bottom held (the torque leaves at the output), '// &
      'free to turn (all torque through the contact), or turned against the teeth of the circular spline')
    call text(t, 'load', 'torque_load', s%torque_load, 'uniform teeth', &
      'even shear on the outside of the rim, or forces of the tooth pairs around the long axis')
    call whole(t, 'load', 'teeth', s%teeth, 8, 100000, 'teeth of the flexspline')
    call whole(t, 'load', 'tooth_pairs', s%tooth_pairs, 2, 100000, 'pairs in mesh at both ends of the long axis together')
    call number(t, 'load', 'pressure_angle_deg', s%pressure_angle_deg, 'deg', 0._dp, 60._dp, &
      'of the teeth: inward radial force = tangential force times its tangent', closed=.true.)
    call number(t, 'load', 'tooth_stiffness', s%tooth_stiffness, 'N/m', 0._dp, big, &
      "of a pair of teeth along its normal, with support 'teeth'; 14 N/(mm um) times the rim")
    call number(t, 'load', 'tooth_clearance', s%tooth_clearance, 'm', 0._dp, big, &
      'of the outermost pairs, falling to 0 with the square of the distance from the long axis', closed=.true.)
    call number(t, 'load', 'torque', s%torque, 'N m', -big, big, 'torque at the end of the torque step', closed=.true.)
    call number(t, 'load', 'support_stiffness', s%support_stiffness, 'N/m', 0._dp, big, &
      'soft springs that hold the hub of a bearing support in its plane, and a free ring tangentially')
    call whole(t, 'load', 'assembly_steps', s%assembly_steps, 1, 100000, 'load steps of the assembly')
    call whole(t, 'load', 'torque_steps', s%torque_steps, 0, 100000, 'load steps of the torque')
    call text(t, 'solver', 'method', s%method, 'auto condensed schur newton', 'condensation to the contact face by '// &
      'harmonics, or by Schur complement (any mesh), Newton matrix with solver.factors, or the cheapest by prediction')
    call text(t, 'solver', 'factors', s%factors, 'auto exact symmetric single harmonic', 'of the Newton matrix: the matrix '// &
      'itself (LU), its symmetric part in double or single precision (half, a quarter of the memory), the round undeformed '// &
      'bodies by harmonics, these under GMRES; or the cheapest by prediction')
    call text(t, 'solver', 'kinematics', s%kinematics, 'linear nonlinear auto', &
      'small displacements, large ones (total Lagrangian; method newton), or whichever '// &
      'run.tolerance needs (linear without one)')
    call text(t, 'solver', 'start', s%start, 'auto rest coarser', 'first guesses: from a mesh of half as many facets either '// &
      'way that is solved before (hex8, hex8i), from the steps before alone, or the former where it saves time')
    call text(t, 'solver', 'symmetry', s%symmetry, 'auto full half quarter', 'part of the face that is solved: '// &
      'what the scene allows in each load step, the whole, or as much as is named in the assembly (not by schur or exact)')
    call number(t, 'solver', 'tolerance', s%tolerance, '', 1e-14_dp, 0.1_dp, &
      'relative residual of forces and contact law; with run.tolerance a thousandth of that if it is more', closed=.true.)
    call whole(t, 'solver', 'max_iterations', s%max_iterations, 1, 10000, 'Newton iterations per load step')
    call whole(t, 'solver', 'max_cuts', s%max_cuts, 0, 40, 'halvings of a load step that does not converge')
    call number(t, 'solver', 'time_limit_s', s%time_limit_s, 's', 0._dp, big, &
      'wall clock after which the run stops in order; 0: none', closed=.true.)
    call number(t, 'joint', 'fractal_dimension', s%fractal_dimension, '', 2._dp, 3._dp, 'surface fractal dimension D')
    call number(t, 'joint', 'roughness', s%roughness, 'm', 0._dp, 1e-4_dp, 'fractal roughness G')
    call number(t, 'joint', 'gamma', s%gamma, '', 1._dp, big, 'frequency ratio of the Weierstrass-Mandelbrot function')
    call number(t, 'joint', 'sample_length', s%sample_length, 'm', 0._dp, big, 'L; the nominal reference area is L^2')
    call number(t, 'joint', 'shortest_wavelength', s%shortest_wavelength, 'm', 0._dp, big, 'L_s')
    call number(t, 'joint', 'asperity_radius', s%asperity_radius, 'm', 0._dp, big, 'r_m, half the base of an asperity')
    call number(t, 'joint', 's_min', s%s_min, 'm^2', 0._dp, big, 'smallest contact spot; 0: pi (L_s/2)^2', closed=.true.)
    call number(t, 'joint', 'hardness', s%hardness, 'Pa', 0._dp, big, 'of the softer body; 0: 2.8 yield_strength', closed=.true.)
    call text(t, 'joint', 'closure', s%closure, 'nominal paper', &
      'pressure is force on the reference area, or (Eq. 28 as printed) mean pressure of the real contact')
    call text(t, 'output', 'vtu', s%vtu, 'none last all', 'steps written for ParaView')
    call numbers(t, 'output', 'positions', s%positions, 'm', 0._dp, big, &
      'Positions I, II, III: distances from the front edge of the contact band')
  end subroutine add_model_keys

  !> A generated surface.
  subroutine add_map_keys(s, t)
    type(map_t), intent(inout), target :: s    !< surface
    type(table_t), intent(inout) :: t          !< table
    real(dp), parameter :: big = huge(1._dp)
    call whole(t, 'surface', 'nx', s%nx, 1, 8388608, 'points along x')
    call whole(t, 'surface', 'ny', s%ny, 1, 8388608, 'points along y')
    call number(t, 'surface', 'dx', s%dx, 'm', 0._dp, big, 'spacing along x')
    call number(t, 'surface', 'dy', s%dy, 'm', 0._dp, big, 'spacing along y')
    call number(t, 'surface', 'x_0', s%x_0, 'm', -big, big, 'first point')
    call number(t, 'surface', 'y_0', s%y_0, 'm', -big, big, 'first point')
    call number(t, 'surface', 'fractal_dimension', s%fractal_dimension, '', 2._dp, 3._dp, 'D of Eq. 1')
    call number(t, 'surface', 'roughness', s%roughness, 'm', 0._dp, big, 'G of Eq. 1')
    call number(t, 'surface', 'gamma', s%gamma, '', 1._dp, big, 'frequency ratio')
    call number(t, 'surface', 'length', s%length, 'm', 0._dp, big, 'L, the longest wavelength')
    call number(t, 'surface', 'shortest_wavelength', s%shortest_wavelength, 'm', 0._dp, big, 'L_s, not above L')
    call whole(t, 'surface', 'ridges', s%ridges, 1, 100000000, 'M, directions of waves; 1: Eq. 2')
    call whole(t, 'surface', 'seed', s%seed, 0, huge(1), 'of the phases')
    call number(t, 'surface', 'tolerance', s%tolerance, '', 0._dp, 0.1_dp, 'rms error that the heights may have, relative to '// &
      'the waves, 1e-13 or more; 0: none, the same bits on every processor', closed=.true.)
    call text(t, 'surface', 'method', s%method, 'auto direct product nufft', &
      'evaluator of the sum; auto: the fastest that keeps the tolerance (nufft without one: 1e-12)')
    call text(t, 'surface', 'precision', s%precision, 'double single', 'of the heights in the file')
  end subroutine add_map_keys

  !> Fit of D and G.
  subroutine add_fit_keys(s, t)
    type(map_fit_t), intent(inout), target :: s  !< fit
    type(table_t), intent(inout) :: t            !< table
    real(dp), parameter :: big = huge(1._dp)
    call text(t, 'fit', 'first_file', s%first_file, '', 'specimen to fit in place of a generated surface: .sdf '// &
      '(ISO 25178-71) or .npy (heights in m); looked for from here, then beside the input')
    call text(t, 'fit', 'second_file', s%second_file, '', 'second specimen: S of both add up to the equivalent surface')
    call number(t, 'fit', 'dx', s%dx, 'm', 0._dp, big, 'spacing along x of .npy files, which state none', closed=.true.)
    call number(t, 'fit', 'dy', s%dy, 'm', 0._dp, big, 'spacing along y of .npy files; 0: dx', closed=.true.)
    call whole(t, 'fit', 'first_lag', s%first_lag, 1, 8388608, 'first lag of the window [points]')
    call whole(t, 'fit', 'last_lag', s%last_lag, 0, 8388608, 'last lag [points]; 0: 20, or half a row if that is less')
    call text(t, 'fit', 'model', s%model, 'auto isotropic profile ridges paper none', 'auto: ridges (the sum of Eq. 1 by the '// &
      'keys of &surface) of a generated surface, ridges found or else isotropic or profile of files; none: no fit')
    call text(t, 'fit', 'level', s%level, 'yes no', 'take the least-squares plane off')
    call number(t, 'fit', 'shortest', s%shortest, 'm', 0._dp, big, 'shortest wavelength of isotropic and profile; 0: L_s of a '// &
      'generated surface, one spacing of files', closed=.true.)
    call number(t, 'fit', 'longest', s%longest, 'm', 0._dp, big, 'longest wavelength; 0: L of a generated surface, the longer '// &
      'side of files', closed=.true.)
    call number(t, 'fit', 'noise', s%noise, 'm', 0._dp, big, 'known rms of white instrument noise', closed=.true.)
    call text(t, 'fit', 'fit_noise', s%fit_noise, 'no yes', 'fit the noise too')
  end subroutine add_fit_keys

  !> Names of the groups, in order.
  function groups_of(table) result(names)
    type(table_t), intent(in) :: table  !< table
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
    type(table_t), intent(in) :: table      !< table
    character(len=*), intent(in) :: group   !< group
    type(string_t), allocatable :: names(:)
    integer :: i
    allocate (names(0))
    do i = 1, size(table%rows)
      if (table%rows(i)%group == group) call push(names, table%rows(i)%key)
    end do
  end function keys_of

  !> Row of a key, 0 if there is none.
  pure integer function find_parameter(table, group, key) result(row)
    type(table_t), intent(in) :: table           !< table
    character(len=*), intent(in) :: group, key   !< names
    do row = 1, size(table%rows)
      if (table%rows(row)%group == group .and. table%rows(row)%key == key) return
    end do
    row = 0
  end function find_parameter

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
      do i = 2, size(p%reals)
        s = s//', '//exact(p%reals(i))
      end do
    else
      s = "'"//doubled(trim(p%text))//"'"
    end if
  end function value_text

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
    real(dp) :: x(100)
    integer :: n, wanted
    what = ''
    hint = ''
    p%given = .true.
    wanted = 1
    if (associated(p%reals)) wanted = size(p%reals)
    if (associated(p%text)) then
      call assign_text(p, words, what, hint)
      return
    end if
    call read_numbers(words, x, n)
    hint = 'valid: '//range_text(p)
    if (n < 0) then
      what = "'"//p%key//"' is not "//trim(merge('an integer', 'a number  ', associated(p%integer)))//": '"//words(-n)%s//"'"
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
      if (associated(p%reals)) p%reals = x(:n)
    end if
  end subroutine assign_words

  !> Set a text value; quotes may be left out for a single word.
  subroutine assign_text(p, words, what, hint)
    type(parameter_t), intent(inout) :: p
    type(string_t), intent(in) :: words(:)
    character(len=:), allocatable, intent(inout) :: what, hint
    character(len=:), allocatable :: s, best
    integer :: i
    s = words(1)%s
    if (scan(s(1:1), '''"') == 1) s = s(2:max(1, len(s) - 1))
    if (size(p%choices) > 0) s = lower(s)
    if (size(words) > 1) then
      what = "'"//p%key//"' takes 1 value(s), "//to_text(size(words))//' found'
      hint = 'put a text with blanks between quotes'
    else if (len(s) > len(p%text)) then
      what = "'"//p%key//"' is too long: "//to_text(len(s))//' characters'
      hint = 'valid: up to '//to_text(len(p%text))//' characters'
    else if (size(p%choices) > 0 .and. .not. any([(p%choices(i)%s == s, i=1, size(p%choices))])) then
      what = "'"//p%key//"' has no choice '"//s//"'"
      best = nearest_name(s, p%choices)
      if (len(best) > 0) hint = "did you mean '"//best//"'?  "
      hint = hint//'valid: '//join(p%choices, ', ')
    else
      p%text = s
    end if
  end subroutine assign_text

  !> Numbers from words, `3*1.5` repeats; n < 0 names the first bad word.
  pure subroutine read_numbers(words, x, n)
    type(string_t), intent(in) :: words(:)  !< words
    real(dp), intent(out) :: x(:)           !< numbers
    integer, intent(out) :: n               !< count, or minus the place of a bad word
    integer :: i, k, star, times, status
    x = 0
    n = 0
    do i = 1, size(words)
      associate (s => words(i)%s)
        star = index(s, '*')
        times = 1
        status = 0
        if (star > 1) read (s(:star - 1), '(i10)', iostat=status) times
        if (status == 0 .and. star == len(s)) status = 1
        if (status == 0 .and. verify(s(star + 1:), '0123456789.+-eEdD') > 0) status = 1
        if (status == 0 .and. scan(s(star + 1:), '0123456789') == 0) status = 1
        if (status == 0) read (s(star + 1:), *, iostat=status) x(min(n + 1, size(x)))
        if (status /= 0 .or. times < 1) then
          n = -i
          return
        end if
        do k = 2, times
          x(min(n + k, size(x))) = x(min(n + 1, size(x)))
        end do
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
    if (len(p%unit) > 0) s = s//' ['//p%unit//']'
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
