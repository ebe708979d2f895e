! SPDX-License-Identifier: GPL-3.0-or-later
!> From an input file and assignments to a checked scene, with every mistake in one message; echo.
module hd_input
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_checksum, only: checksum, file_checksum, hexadecimal, whole
  use hd_error, only: error_t, raise, code_file, code_input
  use hd_input_file, only: most_bytes
  use hd_namelist, only: namelist_t, read_namelist, report, faults_text
  use hd_new_file, only: write_text
  use hd_cam_table, only: cam_table_t, read_cam_table
  use hd_conditions, only: check_scene
  use hd_cup_sections, only: adopt_sections
  use hd_input_tolerances, only: take_tolerances
  use hd_parameters, only: parameter_table_t, new_table, groups_of, keys_of, assign_words, value_text
  use hd_plausible, only: slips_of
  use hd_scene, only: scene_t
  use hd_fit_report, only: place_files
  use hd_surface_scene, only: surface_scene_t
  use hd_support, only: support_of
  use hd_system, only: path_kind, path_file
  use hd_text, only: string_t, push, to_text, lower, suggestion, split, next_word, printable
  use hd_unit, only: in_unit
  implicit none
  private
  public :: read_scene, holds_study, write_echo, surface_scene_of

  character(len=1), parameter :: nl = new_line('a')

contains

  !> Read a scene. `path` may be empty: defaults and assignments only.
  subroutine read_scene(path, assignments, scene, error)
    character(len=*), intent(in) :: path              !< input file or ''
    type(string_t), intent(in) :: assignments(:)      !< 'group.key=value'
    type(scene_t), intent(inout), target :: scene     !< scene
    type(error_t), allocatable, intent(out) :: error  !< all mistakes in one message
    type(namelist_t) :: list
    type(parameter_table_t) :: table
    type(cam_table_t) :: cam
    type(string_t), allocatable :: slips(:)
    logical, allocatable :: given(:)
    integer :: i
    allocate (list%faults(0))
    call new_table(scene, table)
    if (holds_study(trim(path))) then
      call raise(error, code_input, "'"//trim(path)//"' is a study of many scenes, not a scene: run it by 'hdengine study', of "// &
        'the Python package')
      return
    end if
    if (len_trim(path) > 0) then
      call read_namelist(trim(path), list, error)
      if (allocated(error)) return
      call apply_file(list, table)
    end if
    given = table%rows%given
    call settle_pairs(scene, table)
    table%rows%given = .false.
    call apply_assignments(assignments, list%faults, table)
    call settle_pairs(scene, table)
    table%rows%given = table%rows%given .or. given
    if (size(list%faults) == 0 .and. len_trim(scene%joint_from_fit) > 0) then
      call apply_fit(path(:index(path, '/', back=.true.)), scene, table, error)
      if (allocated(error)) return
    end if
    call take_tolerances(scene%tolerances, table, list%faults)
    if (size(list%faults) == 0) scene%support = support_of(scene%support%name)
    if (size(list%faults) == 0) scene%surface_only = surface_alone(table)
    if (size(list%faults) == 0 .and. .not. scene%surface_only .and. scene%cam == 'table' .and. len_trim(scene%cam_file) > 0) then
      call read_cam_table(trim(scene%cam_file), cam, error)
      if (allocated(error)) return
      scene%w = cam%amplitude
    end if
    if (size(list%faults) == 0 .and. .not. scene%surface_only) then
      call adopt_sections(scene, table, list%faults)
      if (size(list%faults) == 0) call check_scene(scene, list%faults)
      call slips_of(scene, slips)
      if (size(list%faults) > 0) list%faults = [list%faults, [(string_t('hint: '//slips(i)%s), i=1, size(slips))]]
    end if
    if (size(list%faults) > 0) then
      call raise(error, code_input, faults_text(list))
      return
    end if
    if (.not. scene%planned_tolerance > 0 .and. scene%kinematics_open()) scene%kinematics = 'linear'
    scene%files = sum_of_files([scene%cam_file, scene%joint_table, scene%joint_spectrum])
  end subroutine read_scene

  !> Checksum of what files hold; a name without a file counts for nothing.
  integer(int64) function sum_of_files(names) result(sum)
    character(len=*), intent(in) :: names(:)  !< files, '' for none
    integer(int64) :: bytes, one
    integer :: i, status
    sum = 0
    do i = 1, size(names)
      if (len_trim(names(i)) == 0) cycle
      inquire (file=trim(names(i)), size=bytes)
      if (bytes > most_bytes) cycle  ! its reader refuses it
      call file_checksum(trim(names(i)), whole, one, status)
      if (status == 0) sum = checksum(hexadecimal(one), sum)
    end do
  end function sum_of_files

  !> Two keys may say one thing: where a source, a file or what is given beside it, has one alone, the other says nothing. Where it
  !> has both, a clearance counts more than an interference, and a list more than the one number that makes it. Gaps of the teeth
  !> that come alone are those of both flanks.
  pure subroutine settle_pairs(scene, table)
    type(scene_t), intent(inout) :: scene          !< scene
    type(parameter_table_t), intent(in) :: table   !< its table: what the source gave
    if (table%given('wave_generator', 'interference') .and. .not. table%given('wave_generator', 'clearance')) scene%clearance = 0
    if (scene%clearance > 0 .or. (table%given('wave_generator', 'clearance') .and. &
      .not. table%given('wave_generator', 'interference'))) scene%interference = 0
    if (table%given('load', 'tooth_clearance') .and. .not. table%given('load', 'tooth_gaps')) then
      scene%gap_count = 1
      scene%gaps(1) = 0
    end if
    if ((table%given('load', 'tooth_gaps') .or. table%given('load', 'tooth_clearance')) .and. &
      .not. table%given('load', 'tooth_gaps_back')) then
      scene%gap_back_count = 1
      scene%gaps_back(1) = 0
    end if
    if (table%given('load', 'torque') .and. .not. table%given('loop', 'torques')) then
      scene%torque_count = 1
      scene%torques(1) = 0
    end if
  end subroutine settle_pairs

  !> A file describes a study, many scenes, if it ends in .toml.
  pure logical function holds_study(path)
    character(len=*), intent(in) :: path  !< input file
    holds_study = .false.
    if (len(path) > 5) holds_study = lower(path(len(path) - 4:)) == '.toml'
  end function holds_study

  !> Is only a surface asked for?
  pure logical function surface_alone(table)
    type(parameter_table_t), intent(in) :: table    !< table after reading
    integer :: i
    surface_alone = any([(table%rows(i)%given .and. of_surface(table%rows(i)%group), i=1, size(table%rows))]) .and. &
      .not. any([(table%rows(i)%given .and. .not. with_surface(table%rows(i)%group), i=1, size(table%rows))])
  end function surface_alone

  !> Groups of a surface run only.
  pure logical function of_surface(group)
    character(len=*), intent(in) :: group    !< name
    of_surface = group == 'surface' .or. group == 'fit'
  end function of_surface

  !> Groups that a surface run may have.
  pure logical function with_surface(group)
    character(len=*), intent(in) :: group    !< name
    with_surface = of_surface(group) .or. group == 'run' .or. group == 'hd_input'
  end function with_surface

  !> Enter the assignments of a file into the table.
  subroutine apply_file(list, table)
    type(namelist_t), intent(inout) :: list  !< scanned file; gets faults
    type(parameter_table_t), intent(inout) :: table    !< table
    character(len=:), allocatable :: what, hint
    type(string_t), allocatable :: names(:)
    logical, allocatable :: seen(:)
    integer :: i, row
    names = groups_of(table)
    allocate (seen(size(names)), source=.false.)
    do i = 1, size(list%groups)
      associate (g => list%groups(i))
        row = place_of(names, g%group)
        if (row == 0) then
          call report(list, g%line, g%column, len(g%group) + 1, 'unknown group &'//g%group, suggestion(g%group, names))
        else
          if (seen(row)) call report(list, g%line, g%column, len(g%group) + 1, 'group &'//g%group//' stands twice', 'keep one')
          seen(row) = .true.
        end if
      end associate
    end do
    do i = 1, size(list%assignments)
      associate (a => list%assignments(i))
        if (place_of(names, a%group) == 0) cycle
        row = table%find(a%group, a%key)
        if (row == 0) then
          call report(list, a%line, a%column, len(a%key), "unknown key '"//a%key//"' in &"//a%group, &
            suggestion(a%key, keys_of(table, a%group)))
          cycle
        end if
        if (table%rows(row)%given) then
          call report(list, a%line, a%column, len(a%key), "key '"//a%key//"' stands twice in &"//a%group, 'keep one')
          cycle
        end if
        call assign_words(table%rows(row), a%values, what, hint)
        if (len(what) > 0) call report(list, a%value_line, a%value_column, len(a%values(1)%s), what, hint)
      end associate
    end do
  end subroutine apply_file

  !> Enter assignments from the command line or from Python.
  subroutine apply_assignments(assignments, faults, table)
    type(string_t), intent(in) :: assignments(:)                !< 'group.key=value'
    type(string_t), allocatable, intent(inout) :: faults(:)     !< gets mistakes
    type(parameter_table_t), intent(inout) :: table                       !< table
    character(len=:), allocatable :: what, hint, group, key
    type(string_t), allocatable :: words(:)
    integer :: i, dot, equal, row
    do i = 1, size(assignments)
      associate (s => assignments(i)%s)
        equal = index(s, '=')
        dot = index(s(:max(0, equal - 1)), '.')
        what = ''
        if (equal == 0 .or. dot == 0) then
          what = "'"//s//"' is no assignment"
          hint = 'write group.key=value'
        else
          group = lower(s(:dot - 1))
          key = lower(s(dot + 1:equal - 1))
          row = table%find(group, key)
          if (place_of(groups_of(table), group) == 0) then
            what = 'unknown group &'//group
            hint = suggestion(group, groups_of(table))
          else if (row == 0) then
            what = "unknown key '"//key//"' in &"//group
            hint = suggestion(key, keys_of(table, group))
          else
            words = words_of(s(equal + 1:), associated(table%rows(row)%reals), table%rows(row)%unit)
            call assign_words(table%rows(row), words, what, hint)
          end if
        end if
        if (len(what) > 0) call push(faults, 'error: '//printable(what)//nl//'  --> '//printable(s)//nl//'      '//hint)
      end associate
    end do
  end subroutine apply_assignments

  !> Take the joint's keys from the scene.nml of a fit, here or beside the input; those that are given stay. Where all it can say is
  !> given, as in an echo, the folder is not needed.
  subroutine apply_fit(beside, scene, table, error)
    character(len=*), intent(in) :: beside                !< folder of the input, with its slash
    type(scene_t), intent(inout) :: scene                 !< names the fit
    type(parameter_table_t), intent(inout) :: table       !< table of the scene
    type(error_t), allocatable, intent(out) :: error      !< no such folder, not one joint in it
    character(len=*), parameter :: keys = 'model fractal_dimension roughness sample_length shortest_wavelength '
    type(namelist_t) :: list
    character(len=:), allocatable :: folder, what, hint
    integer :: i, row
    logical :: needed
    needed = .false.
    do i = 1, size(table%rows)
      associate (p => table%rows(i))
        if (p%group == 'joint') needed = needed .or. (index(' '//keys, ' '//p%key//' ') > 0 .and. .not. p%given)
      end associate
    end do
    if (.not. needed) return
    folder = trim(scene%joint_from_fit)
    if (path_kind(folder//'/scene.nml') /= path_file .and. path_kind(beside//folder//'/scene.nml') == path_file) then
      folder = beside//folder
    end if
    if (path_kind(folder//'/surface.json') /= path_file .or. path_kind(folder//'/scene.nml') /= path_file) then
      call raise(error, code_file, "error: joint.from_fit = '"//folder//"': no folder with a whole fit (surface.json, "// &
        'scene.nml)'//nl//"      valid: what 'hdengine surface MAP [MAP --pair] --out DIR' wrote, named from here or the input")
      return
    end if
    allocate (list%faults(0))
    call read_namelist(folder//'/scene.nml', list, error)
    if (allocated(error)) return
    if (size(list%groups) /= 1) then
      call raise(error, code_input, "error: joint.from_fit = '"//folder//"': its scene.nml has "//to_text(size(list%groups))// &
        ' joints'//nl//"      valid: one, of a surface that is fractal, or of two by 'hdengine surface MAP MAP --pair'; "// &
        'the file says why there is none')
      return
    end if
    do i = 1, size(list%assignments)
      associate (a => list%assignments(i))
        row = table%find('joint', a%key)
        if (row == 0) cycle
        if (table%rows(row)%given) cycle
        call assign_words(table%rows(row), a%values, what, hint)
        if (len(what) > 0) call report(list, a%value_line, a%value_column, len(a%values(1)%s), what, hint)
      end associate
    end do
    if (size(list%faults) > 0) call raise(error, code_input, faults_text(list))
  end subroutine apply_fit

  !> Words of a value; only lists of numbers are cut, a number and its unit are not.
  pure function words_of(s, cut, unit) result(words)
    character(len=*), intent(in) :: s     !< text behind '='
    logical, intent(in) :: cut            !< cut at commas and blanks
    character(len=*), intent(in) :: unit  !< of the key
    type(string_t), allocatable :: words(:)
    type(string_t), allocatable :: places(:)
    character(len=:), allocatable :: word
    integer :: i, at
    allocate (words(0))
    if (.not. cut) then
      call push(words, trim(adjustl(s)))
      return
    end if
    places = split(s)
    do i = 1, size(places)
      if (in_unit(places(i)%s, unit) /= places(i)%s) then
        call push(words, places(i)%s)
        cycle
      end if
      at = 1
      call next_word(places(i)%s, at, word)
      call push(words, word)   ! an empty place is no number
      do
        call next_word(places(i)%s, at, word)
        if (len(word) == 0) exit
        call push(words, word)
      end do
    end do
  end function words_of

  !> Number of a name in a list, 0 if it is not there.
  pure integer function place_of(names, name) result(i)
    type(string_t), intent(in) :: names(:)  !< list
    character(len=*), intent(in) :: name    !< name
    do i = size(names), 1, -1
      if (names(i)%s == name) return
    end do
  end function place_of

  !> Write every key; reading the file back gives the same run.
  subroutine write_echo(path, scene, error)
    character(len=*), intent(in) :: path              !< file
    type(scene_t), intent(in) :: scene                !< scene
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    call write_text(path, echo_of(scene), error)
  end subroutine write_echo

  !> Every key with its value, as an input file.
  function echo_of(scene) result(text)
    type(scene_t), intent(in) :: scene  !< scene
    character(len=:), allocatable :: text
    type(scene_t), target :: standard, copy
    type(parameter_table_t) :: default, table
    type(string_t), allocatable :: groups(:)
    integer :: g, i
    copy = scene
    call new_table(standard, default)
    call new_table(copy, table)
    groups = groups_of(table)
    text = ''
    do g = 1, size(groups)
      if (merge(.not. with_surface(groups(g)%s), of_surface(groups(g)%s), scene%surface_only)) cycle
      text = text//'&'//groups(g)%s//nl
      do i = 1, size(table%rows)
        if (table%rows(i)%group /= groups(g)%s) cycle
        text = text//'  '//table%rows(i)%key//' = '//value_text(table%rows(i))
        if (value_text(table%rows(i)) == value_text(default%rows(i))) text = text//'  ! default'
        text = text//nl
      end do
      text = text//'/'//nl
    end do
  end function echo_of

  !> The surface run that an input asks for; files that stand beside the input are found there.
  function surface_scene_of(scene, input) result(surface)
    type(scene_t), intent(inout) :: scene       !< scene with a map; its files get their folder
    character(len=*), intent(in) :: input       !< name of the input
    type(surface_scene_t) :: surface
    call place_files(scene%fit, input)
    surface%surface = scene%surface
    surface%fit = scene%fit
    surface%title = trim(scene%title)
    surface%echo = echo_of(scene)
  end function surface_scene_of
end module hd_input
