! SPDX-License-Identifier: GPL-3.0-or-later
!> Mean pressures of patches that are the same on every mesh: the band in equal parts round the axis and along it. So the pressure
!> fields of two meshes are compared though their facets do not match. A mean is finite where the pressure itself is not.
module hd_pressure_patches
  use hd_kinds, only: dp, pi
  use hd_drive, only: drive_t
  use hd_facets, only: facets_t
  implicit none
  private
  public :: patches, patch_pressures

  integer, parameter :: around = 16, along = 4    !< parts of the band
  integer, parameter :: patches = around*along

contains

  !> Mean pressures over the area, axially first, then round the axis from angle 0; even over a facet [Pa].
  pure function patch_pressures(drive, facets) result(p)
    type(drive_t), intent(in) :: drive    !< drive
    type(facets_t), intent(in) :: facets  !< of a step
    real(dp) :: p(patches)
    real(dp) :: force(along, around), area(along, around), ends(2), z(2), turn(2), part(along, around)
    integer :: f
    force = 0
    area = 0
    associate (chart => drive%face%chart)
      ends = [minval(chart(2, :, :)), maxval(chart(2, :, :))]
      do f = 1, size(facets%area)
        z = ([minval(chart(2, :, f)), maxval(chart(2, :, f))] - ends(1))/(ends(2) - ends(1))
        turn = [minval(chart(1, :, f)), maxval(chart(1, :, f))]/(2*pi*drive%radius)
        turn = turn - floor(turn(1))
        part = spread(share(z, along), 2, around)*spread(share(turn, around) + share(turn - 1, around), 1, along)
        area = area + part*facets%area(f)
        force = force + part*facets%area(f)*facets%traction(1, f)
      end do
    end associate
    p = reshape(force/area, [patches])
  end function patch_pressures

  !> Shares of an interval that lie in the equal parts of 0 to 1.
  pure function share(x, parts) result(s)
    real(dp), intent(in) :: x(2)   !< its ends
    integer, intent(in) :: parts   !< how many
    real(dp) :: s(parts)
    integer :: i
    do i = 1, parts
      s(i) = max(0._dp, min(x(2), real(i, dp)/parts) - max(x(1), real(i - 1, dp)/parts))/(x(2) - x(1))
    end do
  end function share
end module hd_pressure_patches
