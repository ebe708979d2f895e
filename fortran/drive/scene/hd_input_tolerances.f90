! SPDX-License-Identifier: GPL-3.0-or-later
!> Tolerances of the inputs of a band: the mean fit of a bearing in its bore and the mean clearance of its balls, and what a scene
!> states itself by run.tolerances.
module hd_input_tolerances
  use hd_kinds, only: dp
  use hd_parameter_row, only: parameter_t, parameter_table_t, stage_load
  use hd_text, only: lower, push, split, string_t, to_number
  use hd_unit, only: in_unit
  implicit none
  private
  public :: mean_clearance, mean_play, take_tolerances

  character(len=*), parameter :: nl = new_line('a')

  !> Diameters up to [m], widths of the tolerances of a bore to H7 (ISO 286) and of a bearing of normal class (ISO 492) [m].
  real(dp), parameter :: widths(3, 7) = reshape([30e-3_dp, 21e-6_dp, 9e-6_dp, 50e-3_dp, 25e-6_dp, 11e-6_dp, 80e-3_dp, 30e-6_dp, &
    13e-6_dp, 120e-3_dp, 35e-6_dp, 15e-6_dp, 150e-3_dp, 40e-6_dp, 18e-6_dp, 180e-3_dp, 40e-6_dp, 25e-6_dp, 250e-3_dp, 46e-6_dp, &
    30e-6_dp], [3, 7])
  !> Bores of bearings up to [m], mean internal clearance of the normal class across the diameter (ISO 5753-1) [m].
  real(dp), parameter :: plays(2, 10) = reshape([18e-3_dp, 10.5e-6_dp, 30e-3_dp, 12.5e-6_dp, 40e-3_dp, 13e-6_dp, 50e-3_dp, &
    14.5e-6_dp, 65e-3_dp, 18e-6_dp, 80e-3_dp, 20e-6_dp, 100e-3_dp, 24e-6_dp, 120e-3_dp, 28e-6_dp, 140e-3_dp, 33e-6_dp, &
    160e-3_dp, 35.5e-6_dp], [2, 10])

contains

  !> Mean radial clearance of a bearing of normal class in a bore to H7 [m]; the largest of the table's beyond it.
  pure real(dp) function mean_clearance(diameter) result(clearance)
    real(dp), intent(in) :: diameter  !< of the bore [m]
    integer :: i
    i = min(count(widths(1, :) < diameter) + 1, size(widths, 2))
    clearance = sum(widths(2:, i))/4
  end function mean_clearance

  !> Mean radial clearance of the balls of a bearing [m]: its fit on the cam leaves none to all of the normal class. Both rings are
  !> as thick.
  pure real(dp) function mean_play(radius, ring, ball) result(play)
    real(dp), intent(in) :: radius, ring, ball  !< of the outside, thickness of a ring, diameter of a ball [m]
    play = plays(2, min(count(plays(1, :) < 2*(radius - 2*ring - ball)) + 1, size(plays, 2)))/4
  end function mean_play

  !> Enter the tolerances of a text, 'group.key=half width, group.key=half width', in the place of those that the table states.
  pure subroutine take_tolerances(text, table, faults)
    character(len=*), intent(in) :: text                             !< as in run.tolerances
    type(parameter_table_t), intent(inout) :: table                  !< keys
    type(string_t), allocatable, intent(inout), optional :: faults(:)  !< gets mistakes
    type(string_t), allocatable :: parts(:)
    character(len=:), allocatable :: key, word
    real(dp) :: width
    logical :: ok
    integer :: at, i, row
    if (len_trim(text) == 0) return
    parts = split(text)
    do i = 1, size(parts)
      associate (part => parts(i)%s)
        at = index(part, '=')
        key = lower(trim(adjustl(part(:at - 1))))
        row = 0
        if (index(key, '.') > 0) row = table%find(key(:index(key, '.') - 1), key(index(key, '.') + 1:))
        ok = row > 0
        if (ok) ok = may_vary(table%rows(row))
        if (ok) then
          word = in_unit(trim(adjustl(part(at + 1:))), table%rows(row)%unit)
          call to_number(word, width, ok)
          ok = ok .and. width >= 0
        end if
        if (ok) then
          table%rows(row)%tolerance = width
          table%rows(row)%tolerance_of = ''
          table%rows(row)%tolerance_source = 'run.tolerances'
        else if (present(faults)) then
          call push(faults, "error: run.tolerances: '"//trim(adjustl(part))//"'"//nl//"      valid: 'group.key=half width', "// &
            'parted by commas: a number of geometry, cup, material, wave_generator, bearing, contact or load and half the '// &
            'width, >= 0, in its unit or as 2 um; load.spline=0')
        end if
      end associate
    end do
  end subroutine take_tolerances

  !> A key that a band can move: a number of the drive, or a choice of two.
  pure logical function may_vary(p)
    type(parameter_t), intent(in) :: p  !< row
    may_vary = p%stage(.true., .true.) <= stage_load .and. .not. any(p%group == [character(len=8) :: 'run', 'mesh', 'solver', &
      'surface', 'fit']) .and. (associated(p%real) .or. associated(p%reals) .or. size(p%choices) == 2)
  end function may_vary
end module hd_input_tolerances
