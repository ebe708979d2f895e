! SPDX-License-Identifier: GPL-3.0-or-later
!> Faults of a map as it came: steps of stitching levelled, wrong points taken for holes, holes filled.
module hd_cleaning
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_outliers, only: mask_spikes, fill_holes
  use hd_observation, only: level_plane
  use hd_seams, only: seams_t, remove_seams
  implicit none
  private
  public :: cleaned_t, clean_map, crop

  !> A map without its faults.
  type :: cleaned_t
    real(dp), allocatable :: z(:, :)    !< heights (nx, ny), steps levelled; NaN where points are wrong or missing [m]
    integer :: spikes = 0               !< wrong points
    real(dp) :: seen(2) = 0             !< height over its surroundings from which on a single point, a clump is taken for wrong [m]
    type(seams_t) :: seams              !< steps of stitching
  end type cleaned_t

contains

  !> Clean a map in place; its plane stays.
  subroutine clean_map(z, spacing, mend, mask, fill, seams, spikes, seen)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, ny) [m]
    real(dp), intent(in) :: spacing(2)                !< dx, dy [m]
    logical, intent(in) :: mend                       !< level the tiles between steps of stitching
    logical, intent(in) :: mask                       !< take wrong points for holes
    logical, intent(in) :: fill                       !< fill holes, with what bends least
    type(seams_t), intent(inout) :: seams             !< steps
    integer, intent(out) :: spikes                    !< wrong points
    real(dp), intent(out), optional :: seen(2)        !< height from which on a single point, a clump is taken for wrong [m]
    real(dp), allocatable :: flat(:, :)
    logical, allocatable :: hole(:, :)
    real(dp) :: tilt(2), offset, least(2)
    integer :: at(2), i, j
    spikes = 0
    least = 0
    if (mend) call remove_seams(z, seams)
    flat = z
    call level_plane(flat, tilt)
    if (.not. allocated(seams%x)) seams%x = [integer ::]
    if (mask) call mask_spikes(flat, spacing, spikes, seams%x, least)
    if (present(seen)) seen = least
    hole = .not. abs(flat) <= huge(tilt)
    where (hole) z = ieee_value(tilt(1), ieee_quiet_nan)
    if (.not. fill .or. .not. any(hole)) return
    at = findloc(hole, .false.)
    offset = z(at(1), at(2)) - flat(at(1), at(2))
    call fill_holes(flat, spacing, hole)
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        if (hole(i, j)) z(i, j) = flat(i, j) + offset + tilt(1) * (i - at(1)) + tilt(2) * (j - at(2))
      end do
    end do
  end subroutine clean_map

  !> Keep the middle of a map.
  subroutine crop(c, n)
    type(cleaned_t), intent(inout) :: c   !< map and its seams
    integer, intent(in) :: n(2)           !< points kept
    integer :: off(2)
    if (all(shape(c%z) == n)) return
    off = (shape(c%z) - n) / 2
    c%z = c%z(off(1) + 1:off(1) + n(1), off(2) + 1:off(2) + n(2))
    c%seams%x = pack(c%seams%x - off(1), c%seams%x > off(1) .and. c%seams%x < off(1) + n(1))
    c%seams%y = pack(c%seams%y - off(2), c%seams%y > off(2) .and. c%seams%y < off(2) + n(2))
  end subroutine crop
end module hd_cleaning
