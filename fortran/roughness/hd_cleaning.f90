! SPDX-License-Identifier: GPL-3.0-or-later
!> Faults of a map as it came: steps of stitching levelled, wrong points taken for holes, holes filled.
module hd_cleaning
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_holes, only: mask_spikes, fill_holes
  use hd_observation, only: level_plane
  use hd_seams, only: seams_t, remove_seams
  implicit none
  private
  public :: clean_map

contains

  !> Clean a map in place; its plane stays.
  subroutine clean_map(z, mend, mask, fill, seams, spikes)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, ny) [m]
    logical, intent(in) :: mend                       !< level the tiles between steps of stitching
    logical, intent(in) :: mask                       !< take wrong points for holes
    logical, intent(in) :: fill                       !< fill holes, with what bends least
    type(seams_t), intent(inout) :: seams             !< steps
    integer, intent(out) :: spikes                    !< wrong points
    real(dp), allocatable :: flat(:, :)
    logical, allocatable :: hole(:, :)
    real(dp) :: tilt(2), offset
    integer :: at(2), i, j
    spikes = 0
    if (mend) call remove_seams(z, seams)
    flat = z
    call level_plane(flat, tilt)
    if (.not. allocated(seams%x)) seams%x = [integer ::]
    if (mask) call mask_spikes(flat, spikes, seams%x)
    hole = .not. abs(flat) <= huge(tilt)
    where (hole) z = ieee_value(tilt(1), ieee_quiet_nan)
    if (.not. fill .or. .not. any(hole)) return
    at = findloc(hole, .false.)
    offset = z(at(1), at(2)) - flat(at(1), at(2))
    call fill_holes(flat, hole)
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        if (hole(i, j)) z(i, j) = flat(i, j) + offset + tilt(1) * (i - at(1)) + tilt(2) * (j - at(2))
      end do
    end do
  end subroutine clean_map
end module hd_cleaning
