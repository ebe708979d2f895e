! SPDX-License-Identifier: GPL-3.0-or-later
!> Which measurement chose the default of a key: headings of docs/evidence/speed_accuracy.md.
module hd_default_charts
  implicit none
  private
  public :: chart_of

  !> Keys that choose a method or a fineness, and their charts.
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
end module hd_default_charts
