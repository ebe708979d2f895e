! SPDX-License-Identifier: GPL-3.0-or-later
program main
  implicit none
  print '(a)', 'hdengine'
end program main
