! SPDX-License-Identifier: GPL-3.0-or-later
!> Texts of hdengine.x: help, version, licences, citation.
module hd_help
  use, intrinsic :: iso_fortran_env, only: compiler_version
  use hd_version, only: version, lapack_version, fftw_version, metis_version, build_type
  implicit none
  private
  public :: help_text, version_text, license_text, citation_text

  character(len=1), parameter :: nl = new_line('a')

contains

  function help_text() result(s)
    character(len=:), allocatable :: s
    s = 'usage: hdengine.x [options] input.nml [group.key=value ...]'//nl//nl// &
      'Torsional stiffness of the contact between flexspline and flexible bearing'//nl// &
      'of a harmonic drive. Results land in <stem>.out/, the summary last.'//nl// &
      'A study of many scenes is given to the command hdengine study.'//nl//nl// &
      '  --out DIR       folder for the results'//nl// &
      '  --force         replace earlier results'//nl// &
      '  --resume        go on with a stopped run of the same input'//nl// &
      '  --check         read and check the input, then stop'//nl// &
      '  --plan          print what run.tolerance needs, with time and memory, then stop'//nl// &
      '  --explain KEY   meaning, unit and default of a key (group.key, group, all); warnings'//nl// &
      '  --allow-implausible  solve also where a value is some thousand times off'//nl// &
      '  -q, -v          no log, log with Newton iterations'//nl// &
      '  --version  --license  --citation  --help'//nl//nl// &
      'exit codes: 0 done, 1 internal error, 2 usage or input, 3 file,'//nl// &
      '            4 not converged (gross slip), 5 linear solver, 6 memory,'//nl// &
      '            7 stopped at a limit with its results kept'//nl//nl// &
      'example: hdengine.x data/cd14.nml load.torque=3 --out t3.out'
  end function help_text

  function version_text() result(s)
    character(len=:), allocatable :: s
    s = 'hdengine '//version//' ('//build_type//', '//compiler_version()//')'//nl// &
      'METIS '//metis_version//', '//lapack_version//', FFTW '//fftw_version
  end function version_text

  function license_text() result(s)
    character(len=:), allocatable :: s
    s = 'hdengine: GPL-3.0-or-later, with permission to link libraries under CeCILL-C'//nl// &
      'MUMPS: CeCILL-C   METIS: Apache-2.0   FFTW: GPL-2.0-or-later   OpenBLAS: BSD-3-Clause'
  end function license_text

  function citation_text() result(s)
    character(len=:), allocatable :: s
    s = 'hdengine '//version//nl// &
      'Model: Hu, Li, Wang, Li (2023), Front. Mater. 10:1211019, doi:10.3389/fmats.2023.1211019'//nl// &
      'MUMPS: Amestoy, Duff, L''Excellent, Koster (2001), SIAM J. Matrix Anal. Appl. 23:15'//nl// &
      'METIS: Karypis, Kumar (1998), SIAM J. Sci. Comput. 20:359'
  end function citation_text
end module hd_help
