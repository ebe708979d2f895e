! SPDX-License-Identifier: GPL-3.0-or-later
!> A measured cam: radii over angles from a CSV file, joined by a periodic cubic spline.
module hd_cam_table
  use hd_columns, only: columns_t, read_columns
  use hd_gauss, only: gauss_3, weight_3
  use hd_kinds, only: dp, pi, hair
  use hd_error, only: error_t, raise, code_input
  use hd_sorted, only: count_up_to
  use hd_text, only: to_text, join, printable, rounded
  implicit none
  private
  public :: cam_table_t, read_cam_table, radius_deviation

  integer, parameter :: fewest = 8  !< points of a table
  real(dp), parameter :: widest = 2*pi/fewest*(1 + hair)  !< way between two of them [rad]

  !> Deviation of the radius from its mean over the angle, periodic, with continuous curvature.
  type :: cam_table_t
    real(dp) :: mean = 0                        !< radius, mean over the angle [m]
    real(dp) :: amplitude = 0                   !< half the range of the measured radii [m]
    real(dp), allocatable :: theta(:)           !< knots and the first again after one turn (n + 1) [rad]
    real(dp), allocatable, private :: y(:)      !< deviations there [m]
    real(dp), allocatable, private :: m(:)      !< second derivatives there [m/rad^2]
    real(dp), allocatable, private :: total(:)  !< integral from the first knot [m rad]
    real(dp), private :: offset = 0             !< makes the mean of that integral vanish [m rad]
  end type cam_table_t

contains

  !> Read a table: a header line `theta_deg,radius_m` or `theta_rad,radius_m`, then one point a line, angles rising within one turn.
  subroutine read_cam_table(path, table, error)
    character(len=*), intent(in) :: path              !< file
    type(cam_table_t), intent(out) :: table           !< table
    type(error_t), allocatable, intent(out) :: error  !< no such file, faults with their line
    type(columns_t) :: columns
    character(len=:), allocatable :: fault, names
    real(dp), allocatable :: way(:)
    real(dp) :: unit
    integer :: i
    call read_columns(path, columns, error)
    if (allocated(error)) then
      error%message = 'wave_generator.cam_file: '//error%message
      return
    end if
    names = join(columns%names, ',')
    if (names /= 'theta_deg,radius_m' .and. names /= 'theta_rad,radius_m') then
      call raise(error, code_input, columns%place(columns%header_line)//"the header is '"//printable(names)// &
        "'; valid: theta_deg,radius_m or theta_rad,radius_m")
      return
    end if
    unit = merge(pi/180, 1._dp, names == 'theta_deg,radius_m')
    fault = ''
    associate (theta => columns%values(1, :)*unit, radius => columns%values(2, :))
      do i = 1, size(theta)
        if (.not. radius(i) > 0) fault = 'radius '//to_text(radius(i))//' m; valid: above 0'
        if (i > 1) then
          if (theta(i) <= theta(i - 1)) fault = 'the angle does not rise'
          if (theta(i) >= theta(1) + 2*pi*(1 - hair)) fault = 'the angle leaves the first turn'// &
            ' (the first point does not stand again at the end)'
        end if
        if (len(fault) == 0) cycle
        call raise(error, code_input, columns%place(columns%lines(i))//fault)
        return
      end do
      if (size(theta) < fewest) then
        call raise(error, code_input, "'"//path//"': "//to_text(size(theta))//' points; valid: '//to_text(fewest)//' or more')
        return
      end if
      way = [theta(2:), theta(1) + 2*pi] - theta
      i = maxloc(way, 1)
      if (way(i) > widest) then
        call raise(error, code_input, columns%place(columns%lines(i))//'no point within '//rounded(way(i)*180/pi)// &
          ' deg after this one; valid: points all round the cam, none further apart than '//to_text(360/fewest)//' deg')
        return
      end if
      call new_cam_table(theta, radius, table)
    end associate
  end subroutine read_cam_table

  !> Spline through measured radii.
  pure subroutine new_cam_table(theta, radius, table)
    real(dp), intent(in) :: theta(:)           !< rising, within one turn [rad]
    real(dp), intent(in) :: radius(:)          !< [m]
    type(cam_table_t), intent(out) :: table    !< spline
    real(dp) :: h, moment, t, u
    integer :: i, k, n
    n = size(theta)
    table%theta = [theta, theta(1) + 2*pi]
    table%y = [radius, radius(1)]
    table%m = second_derivatives(table%theta, table%y)
    table%amplitude = 0.5_dp*(maxval(radius) - minval(radius))
    allocate (table%total(n + 1), source=0._dp)
    do i = 1, n
      h = table%theta(i + 1) - table%theta(i)
      table%total(i + 1) = table%total(i) + h/2*(table%y(i) + table%y(i + 1)) - h**3/24*(table%m(i) + table%m(i + 1))
    end do
    table%mean = table%total(n + 1)/(2*pi)
    table%total = table%total - table%mean*(table%theta - table%theta(1))
    table%total(n + 1) = 0
    table%y = table%y - table%mean
    moment = 0
    do i = 1, n
      h = table%theta(i + 1) - table%theta(i)
      do k = 1, 3
        t = table%theta(i) + h*(1 + gauss_3(k))/2
        call radius_deviation(table, t, u)
        moment = moment + weight_3(k)/2*h*(t - table%theta(1))*u
      end do
    end do
    table%offset = moment/(2*pi)
  end subroutine new_cam_table

  !> Second derivatives of the periodic cubic spline at its knots: a cyclic tridiagonal system, by two Thomas sweeps.
  pure function second_derivatives(t, y) result(m)
    real(dp), intent(in) :: t(:), y(:)  !< knots and values, the first again at the end
    real(dp) :: m(size(t))
    real(dp), dimension(size(t) - 1) :: h, a, b, c, d, e, z
    real(dp) :: f
    integer :: i, n
    n = size(t) - 1
    h = t(2:) - t(:n)
    d = (y(2:) - y(:n))/h
    d = 6*(d - cshift(d, -1))
    a = cshift(h, -1)
    c = h
    b = 2*(a + c)
    e = 0                ! Sherman and Morrison: the corners a(1) and c(n) apart
    e(1) = -b(1)
    e(n) = c(n)
    f = a(1)/e(1)
    b(n) = b(n) - c(n)*f
    b(1) = b(1) - e(1)
    do i = 2, n
      b(i) = b(i) - a(i)/b(i - 1)*c(i - 1)
      d(i) = d(i) - a(i)/b(i - 1)*d(i - 1)
      e(i) = e(i) - a(i)/b(i - 1)*e(i - 1)
    end do
    m(n) = d(n)/b(n)
    z(n) = e(n)/b(n)
    do i = n - 1, 1, -1
      m(i) = (d(i) - c(i)*m(i + 1))/b(i)
      z(i) = (e(i) - c(i)*z(i + 1))/b(i)
    end do
    m(:n) = m(:n) - (m(1) + f*m(n))/(1 + z(1) + f*z(n))*z
    m(n + 1) = m(1)
  end function second_derivatives

  !> Deviation of the radius from its mean, with derivatives and the integral whose mean over a turn is 0.
  elemental subroutine radius_deviation(table, theta, u, du, ddu, total)
    type(cam_table_t), intent(in) :: table         !< table
    real(dp), intent(in) :: theta                  !< any angle [rad]
    real(dp), intent(out) :: u                     !< [m]
    real(dp), intent(out), optional :: du, ddu     !< by the angle [m]
    real(dp), intent(out), optional :: total       !< integral [m rad]
    real(dp) :: t, h, p, q
    integer :: low
    t = table%theta(1) + modulo(theta - table%theta(1), 2*pi)
    low = min(max(count_up_to(table%theta, t), 1), size(table%theta) - 1)
    h = table%theta(low + 1) - table%theta(low)
    q = (t - table%theta(low))/h
    p = 1 - q
    associate (y => table%y(low:low + 1), m => table%m(low:low + 1))
      u = p*y(1) + q*y(2) + h**2/6*((p**3 - p)*m(1) + (q**3 - q)*m(2))
      if (present(du)) du = (y(2) - y(1))/h + h/6*((1 - 3*p**2)*m(1) + (3*q**2 - 1)*m(2))
      if (present(ddu)) ddu = p*m(1) + q*m(2)
      if (present(total)) total = table%total(low) + table%offset + h/2*((1 - p**2)*y(1) + q**2*y(2)) + &
        h**3/24*((-p**4 + 2*p**2 - 1)*m(1) + (q**4 - 2*q**2)*m(2))
    end associate
  end subroutine radius_deviation
end module hd_cam_table
