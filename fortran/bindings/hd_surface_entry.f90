! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat arguments of the surface entries to types, checked.
module hd_surface_entry
  use hd_kinds, only: dp, i8
  use hd_error, only: error_t
  use hd_heights, only: method_t, choose_method
  use hd_waves, only: spectrum_t, grid_t, count_waves, checked_grid
  implicit none
  private
  public :: read_entry, read_free

contains

  !> Spectrum, grid and method.
  subroutine read_entry(p, ridges, seed, grid, nx, ny, tolerance, bytes, wanted, s, g, n_max, waves, method, error)
    real(dp), intent(in) :: p(5)                      !< D, G, gamma, L, L_s
    integer, intent(in) :: ridges                     !< M
    integer(i8), intent(in) :: seed                   !< seed
    real(dp), intent(in) :: grid(4)                   !< dx, dy, x_0, y_0
    integer, intent(in) :: nx, ny                     !< points
    real(dp), intent(in) :: tolerance                 !< error allowed; 0: none
    integer, intent(in) :: bytes                      !< of a height
    integer, intent(in) :: wanted                     !< method_*
    type(spectrum_t), intent(out) :: s                !< spectrum
    type(grid_t), intent(out) :: g                    !< grid
    integer, intent(out) :: n_max                     !< largest exponent
    integer(i8), intent(out) :: waves                 !< number of waves
    type(method_t), intent(out) :: method             !< evaluator
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    s = spectrum_t(p(1), p(2), p(3), p(4), p(5), ridges, seed)
    g = grid_t(nx, ny, grid(1), grid(2), grid(3), grid(4))
    call count_waves(s, n_max, waves, error)
    if (.not. allocated(error)) call checked_grid(g, error)
    if (.not. allocated(error)) then
      call choose_method(nx, ny, waves, (n_max + 1_i8) * (ridges / 2 + 1), tolerance, bytes, wanted, method, error)
    end if
  end subroutine read_entry

  !> Grid and method of free waves.
  subroutine read_free(count, grid, nx, ny, tolerance, bytes, wanted, g, method, error)
    integer, intent(in) :: count                      !< number of waves
    real(dp), intent(in) :: grid(4)                   !< dx, dy, x_0, y_0
    integer, intent(in) :: nx, ny                     !< points
    real(dp), intent(in) :: tolerance                 !< error allowed; 0: none
    integer, intent(in) :: bytes                      !< of a height
    integer, intent(in) :: wanted                     !< method_*
    type(grid_t), intent(out) :: g                    !< grid
    type(method_t), intent(out) :: method             !< evaluator
    type(error_t), allocatable, intent(out) :: error  !< what is wrong
    g = grid_t(nx, ny, grid(1), grid(2), grid(3), grid(4))
    call checked_grid(g, error)
    if (.not. allocated(error)) then
      call choose_method(nx, ny, int(count, i8), int(count, i8), tolerance, bytes, wanted, method, error)
    end if
  end subroutine read_free
end module hd_surface_entry
