! SPDX-License-Identifier: GPL-3.0-or-later
!> The command line of hdengine.x: what is asked, and doing it.
module hd_command_line
  use hd_error, only: error_t, raise, code_input
  use hd_help, only: help_text, license_text, citation_text, version_text
  use hd_explain, only: explain
  use hd_input, only: read_scene, holds_study, surface_scene_of
  use hd_log, only: set_log_level, quiet, normal, verbose, say, print_text
  use hd_output, only: result_files
  use hd_surface_run, only: check_surface_run, run_surface
  use hd_joint_choice, only: choose_joint
  use hd_plausible, only: implausible, refuse_slips
  use hd_planner, only: plan_text
  use hd_open_run, only: check_run, run_to_end
  use hd_scene, only: scene_t
  use hd_system, only: become_program
  use hd_text, only: string_t, push, suggestion
  use hd_warning_list, only: numbered, warnings_text
  implicit none
  private
  public :: command_t, read_command_line, obey

  type :: command_t
    character(len=:), allocatable :: action       !< run, check, explain, or a text to print
    character(len=:), allocatable :: input        !< input file
    character(len=:), allocatable :: folder       !< output folder, '' for the default
    character(len=:), allocatable :: key          !< key to explain
    type(string_t), allocatable :: assignments(:) !< group.key=value
    logical :: force = .false.
    logical :: resume = .false.
    logical :: implausible = .false.              !< values a thousand times off are meant
    integer :: level = normal
  end type command_t

contains

  !> Parse the arguments.
  subroutine read_command_line(command, error)
    type(command_t), intent(out) :: command           !< what is asked
    type(error_t), allocatable, intent(out) :: error  !< usage
    character(len=:), allocatable :: word
    integer :: i
    command%action = 'run'
    command%input = ''
    command%folder = ''
    command%key = ''
    allocate (command%assignments(0))
    i = 1
    do while (i <= command_argument_count() .and. .not. allocated(error))
      word = argument(i)
      select case (word)
      case ('--check', '--plan', '--help', '--version', '--license', '--citation')
        command%action = word(3:)
      case ('-h')
        command%action = 'help'
      case ('--explain')
        command%action = 'explain'
        call take_value(command%key)
      case ('--out')
        call take_value(command%folder)
      case ('--force'); command%force = .true.
      case ('--resume'); command%resume = .true.
      case ('--allow-implausible'); command%implausible = .true.
      case ('-q'); command%level = quiet
      case ('-v'); command%level = verbose
      case default
        if (index(word, '-') == 1) then
          call unknown_option(word, error)
        else if (index(word, '=') > 0) then
          call push(command%assignments, word)
        else if (len(command%input) > 0) then
          call raise(error, code_input, "two input files: '"//command%input//"' and '"//word//"'; valid: one")
        else
          command%input = word
        end if
      end select
      i = i + 1
    end do
    if (allocated(error)) return
    call refuse_blank(command%input)
    if (.not. allocated(error)) call refuse_blank(command%folder)
    if (allocated(error)) return
    if (command%force .and. command%resume) then
      call raise(error, code_input, '--force begins anew, --resume goes on: give one of them')
      return
    end if
    if ((command%action == 'run' .or. command%action == 'check' .or. &
      command%action == 'plan') .and. len(command%input) == 0) then
      call raise(error, code_input, 'no input file; usage: hdengine.x [options] input.nml (see hdengine.x --help)')
    end if
  contains
    !> A path that ends with a blank would be taken for the one without.
    subroutine refuse_blank(path)
      character(len=*), intent(in) :: path
      if (len(path) > len_trim(path)) call raise(error, code_input, "the path '"//path//"' ends with a blank; "// &
        'valid: one that does not')
    end subroutine refuse_blank

    subroutine take_value(value)
      character(len=:), allocatable, intent(inout) :: value
      if (len(value) > 0) call raise(error, code_input, word//" is given twice: '"//value//"' and again; valid: once")
      i = i + 1
      value = ''
      if (i <= command_argument_count()) value = argument(i)
      if (len(value) == 0 .or. index(value, '--') == 1) call raise(error, code_input, word//' needs a value; see hdengine.x --help')
    end subroutine take_value
  end subroutine read_command_line

  !> One argument of the command line.
  function argument(i) result(word)
    integer, intent(in) :: i  !< number
    character(len=:), allocatable :: word
    integer :: n
    call get_command_argument(i, length=n)
    allocate (character(len=n) :: word)
    if (n > 0) call get_command_argument(i, word)
  end function argument

  !> Error for an option that does not exist.
  subroutine unknown_option(word, error)
    character(len=*), intent(in) :: word              !< as typed
    type(error_t), allocatable, intent(out) :: error  !< usage
    character(len=*), parameter :: names(11) = [character(len=19) :: '--check', '--plan', '--explain', '--force', &
      '--resume', '--help', '--out', '--version', '--license', '--citation', '--allow-implausible']
    type(string_t), allocatable :: options(:)
    integer :: i
    do i = 1, size(names)
      call push(options, trim(names(i)))
    end do
    call raise(error, code_input, "unknown option '"//word//"'"//new_line('a')//'      '//suggestion(word, options)//', -q, -v')
  end subroutine unknown_option

  !> Do what is asked.
  subroutine obey(command, error)
    type(command_t), intent(in) :: command            !< what is asked
    type(error_t), allocatable, intent(out) :: error  !< what went wrong
    type(scene_t), allocatable :: scene
    type(string_t), allocatable :: doubts(:)
    character(len=:), allocatable :: answer, folder
    integer :: i
    call set_log_level(command%level)
    select case (command%action)
    case ('help'); call print_text(help_text())
    case ('version'); call print_text(version_text())
    case ('license'); call print_text(license_text())
    case ('citation'); call print_text(citation_text())
    case ('explain')
      if (command%key == 'warnings') then
        call print_text(warnings_text())
        return
      end if
      call explain(command%key, answer, error)
      if (.not. allocated(error)) call print_text(answer)
    case default
      if (holds_study(trim(command%input))) call hand_over(command, error)
      if (allocated(error)) return
      allocate (scene)
      call read_scene(command%input, command%assignments, scene, error)
      if (allocated(error)) return
      if (.not. command%implausible) call refuse_slips(scene, error)
      if (allocated(error)) return
      if (scene%surface_only) then
        call check_surface_run(surface_scene_of(scene, command%input), error)
      else
        call check_run(scene, error)
      end if
      if (allocated(error)) return
      call implausible(scene, doubts)
      do i = 1, size(doubts)   ! a run says them at its end, with the others
        if (command%action /= 'run' .or. scene%surface_only) call say('warning: '//numbered(doubts(i)%s))
      end do
      if (command%action == 'check') then
        call say(command%input//' is valid')
        return
      end if
      if (command%action == 'plan') then
        if (.not. scene%planned_tolerance > 0) then
          call raise(error, code_input, '--plan needs a tolerance: run.tolerance=0.02, or &run tolerance = 0.02 / in the input')
          return
        end if
        call set_log_level(quiet)
        call choose_joint(scene, error)
        if (.not. allocated(error)) call plan_text(scene, answer, error)
        if (.not. allocated(error)) call print_text(answer)
        return
      end if
      folder = command%folder
      if (len(folder) == 0) folder = stem(command%input)//'.out'
      if (scene%surface_only) then
        call run_surface(surface_scene_of(scene, command%input), command%input, folder, command%force, &
          result_files, error)
      else
        call run_to_end(scene, command%input, folder, command%force, command%resume, error)
      end if
    end select
  end subroutine obey

  !> Give a study to the command of the Python package; returns only if that is not installed, or with an error.
  subroutine hand_over(command, error)
    type(command_t), intent(in) :: command            !< what is asked; a study always goes on where it stopped
    type(error_t), allocatable, intent(out) :: error  !< assignments to a study
    type(string_t), allocatable :: words(:)
    integer :: i
    if (size(command%assignments) > 0 .and. command%action /= 'plan') then
      call raise(error, code_input, "'"//command%assignments(1)%s//"' has no place in a study: write it under [fixed] of '"// &
        command%input//"'")
      return
    end if
    call push(words, 'hdengine')
    call push(words, trim(merge('plan ', 'study', command%action == 'plan')))
    call push(words, command%input)
    if (command%action == 'check') call push(words, '--check')
    if (command%action == 'plan') then
      do i = 1, size(command%assignments)
        call push(words, command%assignments(i)%s)
      end do
    else
      if (command%level == quiet) call push(words, '-q')
      if (command%force) call push(words, '--force')
      if (len(command%folder) > 0) then
        call push(words, '--out')
        call push(words, command%folder)
      end if
    end if
    call become_program(words)
  end subroutine hand_over

  !> File name without folder and extension: results land where the run starts.
  pure function stem(path) result(s)
    character(len=*), intent(in) :: path  !< input file
    character(len=:), allocatable :: s
    integer :: dot
    s = path(index(path, '/', back=.true.) + 1:)
    dot = index(s, '.', back=.true.)
    if (dot > 1) s = s(:dot - 1)
  end function stem
end module hd_command_line
