! SPDX-License-Identifier: GPL-3.0-or-later
!> What a key means, its unit, default and valid values: for the terminal, and all keys as a page.
module hd_explain
  use hd_error, only: error_t, raise, code_input
  use hd_parameters, only: parameter_table_t, parameter_t, new_table, groups_of, range_text
  use hd_scene, only: scene_t
  use hd_text, only: string_t, push, join, lower, nearest_name, percent, rounded
  implicit none
  private
  public :: explain

  character(len=1), parameter :: nl = new_line('a')

  !> Keys that choose a method or a fineness, and the measurement that chose their default: headings of
  !> docs/evidence/speed_accuracy.md.
  character(len=*), parameter :: charts(2, 11) = reshape([character(len=80) :: &
    'mesh.element', 'Ring of 0.3 mm under cos 2θ, one cell through the wall', &
    'mesh.divisions', 'Mesh of the band: worst of force and K_TS (Eq. 45)', &
    'mesh.band_facets', 'Mesh of the band: worst of force and K_TS (Eq. 45)', &
    'mesh.edge_length', 'Mesh of the band: worst of force and K_TS (Eq. 45)', &
    'run.tolerance', 'Planned runs: error of the promised limits', &
    'solver.method', 'Linear solvers, 64 x 10 facets of CD-14-100, same residual', &
    'solver.factors', 'Linear solvers, 64 x 10 facets of CD-14-100, same residual', &
    'joint.model', 'Normal stiffness of a rough joint, 3 % of contact', &
    'surface.method', 'Heights of Eq. 1, 512 x 512 points, 160 waves', &
    'surface.tolerance', 'Heights of Eq. 1, 512 x 512 points, 160 waves', &
    'fit.model', 'Fit of D, optics of half a spacing, generator not ours'], [2, 11])

contains

  !> Text about a key, a group, or `all` keys as a Markdown page.
  subroutine explain(name, answer, error)
    character(len=*), intent(in) :: name                    !< key, group.key, group or 'all'
    character(len=:), allocatable, intent(out) :: answer    !< text
    type(error_t), allocatable, intent(out) :: error        !< no such name
    type(scene_t), target :: scene
    type(parameter_table_t) :: table
    type(string_t), allocatable :: names(:)
    character(len=:), allocatable :: best
    integer :: i
    call new_table(scene, table)
    if (name == 'all') then
      answer = page(table)
      return
    end if
    answer = ''
    do i = 1, size(table%rows)
      associate (p => table%rows(i))
        call push(names, p%key)
        call push(names, p%group//'.'//p%key)
        if (lower(name) == p%key .or. lower(name) == p%group//'.'//p%key .or. lower(name) == p%group) answer = answer//entry_of(p)
      end associate
    end do
    if (len(answer) > 0) return
    best = nearest_name(name, names)
    if (len(best) > 0) best = "did you mean '"//best//"'?  "
    call raise(error, code_input, "error: no key '"//name//"'"//nl//'      '//best//'valid: a key, group.key, all, or a group: '// &
      join(groups_of(table), ', '))
  end subroutine explain

  !> A key on the terminal.
  function entry_of(p) result(s)
    type(parameter_t), intent(in) :: p  !< row
    character(len=:), allocatable :: s
    s = '&'//p%group//' '//p%key//' = '//p%default
    if (len(p%unit) > 0) s = s//' ['//p%unit//']'
    s = s//nl//'    '//p%meaning//nl//'    valid: '//valid(p)//nl
    if (p%tolerance > 0) s = s//'    '//tolerance_text(p)//nl
    if (len(chart_of(p%group, p%key)) > 0) s = s//'    the default was chosen by the chart "'// &
      chart_of(p%group, p%key)//'" of docs/evidence/speed_accuracy.md'//nl
  end function entry_of

  !> All keys as a page of the site, an entry each that can be searched and linked by its name.
  function page(table) result(s)
    type(parameter_table_t), intent(in) :: table  !< all keys
    character(len=:), allocatable :: s, group
    integer :: i
    s = '# Input keys'//nl//nl//'Every key of an input file, by its group. `hdengine.x --explain all` writes this page, '// &
      '`hdengine.x --explain KEY` shows one key.'//nl//'All values are in SI units.'//nl
    group = ''
    do i = 1, size(table%rows)
      associate (p => table%rows(i))
        if (p%group /= group) then
          if (i > 1) s = s//'```'//nl
          s = s//nl//'## &'//p%group//nl//nl//'```{glossary}'//nl
        else
          s = s//nl
        end if
        group = p%group
        s = s//group//'.'//p%key//nl//'  '//p%meaning//nl//nl//'  Default `'//p%default//'`'
        if (len(p%unit) > 0) s = s//' '//p%unit
        if (len(chart_of(group, p%key)) > 0) s = s//', chosen by the [chart](../evidence/speed_accuracy.md) "'// &
          chart_of(group, p%key)//'"'
        s = s//'; valid: '//valid(p)
        if (p%tolerance > 0) s = s//'; '//tolerance_text(p)
        s = s//nl
      end associate
    end do
    s = s//'```'
  end function page

  !> Tolerance in words.
  function tolerance_text(p) result(s)
    type(parameter_t), intent(in) :: p  !< row
    character(len=:), allocatable :: s
    s = 'tolerance (95 %): '
    if (associated(p%text)) then
      s = s//'the other choice is the other bound'
    else if (p%tolerance_of == 'value') then
      s = s//'+-'//percent(p%tolerance)
    else if (p%tolerance_of == 'bore') then
      s = s//'all +-'//rounded(p%tolerance)//' times geometry.bore_radius'
    else if (p%tolerance_of == 'fit') then
      s = s//'+-'//rounded(p%tolerance)//' times the mean clearance of the bore, 9 um from 30 to 50 mm; '// &
        'below 0 it is an interference'
    else if (p%tolerance_of == 'play') then
      s = s//'+-'//rounded(p%tolerance)//' times the mean clearance of a bearing of this bore, 3.125 um from 18 to 30 mm'
    else
      s = s//'+-'//trim(rounded(p%tolerance)//' '//p%unit)
    end if
    s = s//' ('//p%tolerance_source//')'
  end function tolerance_text

  !> Valid values in words.
  function valid(p) result(s)
    type(parameter_t), intent(in) :: p  !< row
    character(len=:), allocatable :: s
    if (size(p%choices) > 0) then
      s = join(p%choices, ', ')
    else if (associated(p%text)) then
      s = 'any text'
    else if (.not. p%high > p%low) then
      s = p%default
    else
      s = range_text(p)
      if (associated(p%reals)) s = 'numbers'//s(len('number') + 1:)
    end if
  end function valid

  !> Heading of the chart that chose a default, empty for a key that describes the scene.
  pure function chart_of(group, key) result(heading)
    character(len=*), intent(in) :: group, key  !< as group.key
    character(len=:), allocatable :: heading
    integer :: i
    heading = ''
    do i = 1, size(charts, 2)
      if (charts(1, i) == group//'.'//key) heading = trim(charts(2, i))
    end do
  end function chart_of
end module hd_explain
