! SPDX-License-Identifier: GPL-3.0-or-later
!> MUMPS's own structure and entry, double precision.
module hd_mumps_struc
  implicit none
  private
  public :: dmumps_struc, dmumps

  include 'dmumps_struc.h'

  interface
    !> Do the job that the structure names, in double precision.
    subroutine dmumps(id)
      import :: dmumps_struc
      type(dmumps_struc), intent(inout) :: id  !< job, matrix and factors
    end subroutine dmumps
  end interface
end module hd_mumps_struc
