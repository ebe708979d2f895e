! SPDX-License-Identifier: GPL-3.0-or-later
!> MUMPS's own structures and entries, both precisions.
module hd_mumps_struc
  implicit none
  private
  public :: dmumps_struc, smumps_struc, dmumps, smumps

  include 'dmumps_struc.h'
  include 'smumps_struc.h'

  interface
    !> Do the job that the structure names, in double precision.
    subroutine dmumps(id)
      import :: dmumps_struc
      type(dmumps_struc), intent(inout) :: id  !< job, matrix and factors
    end subroutine dmumps

    !> The same in single precision.
    subroutine smumps(id)
      import :: smumps_struc
      type(smumps_struc), intent(inout) :: id  !< job, matrix and factors
    end subroutine smumps
  end interface
end module hd_mumps_struc
