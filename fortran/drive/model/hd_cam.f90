! SPDX-License-Identifier: GPL-3.0-or-later
!> The wave generator's curve and a circle that goes on it: to first order for small displacements, exactly for large ones.
!>
!> A profile is a polar curve R + dr(theta) whose deviation grows with the deformation w. To first order a circle of radius r
!> that keeps its length has u_r = dr less its mean, u_theta = -integral of u_r, and nothing of the order w^2/r. Exactly, points
!> that are even on the circle are even by arc length on a curve parallel to the profile. The distance h of that curve sets its
!> length, which grows by 2 pi h.
module hd_cam
  use hd_gauss, only: gauss_8, weight_8
  use hd_kinds, only: dp, pi, hair
  use hd_cam_table, only: cam_table_t, read_cam_table, radius_deviation
  use hd_error, only: error_t, raise, code_input
  use hd_scene, only: scene_t
  use hd_sorted, only: count_up_to
  use hd_text, only: to_text
  implicit none
  private
  public :: cam_t, new_cam, curve_t, new_curve

  real(dp), parameter :: settled = 1e-15_dp         !< change of an angle that is below its rounding [rad]
  integer, parameter :: panels = 128              !< of a smooth profile
  real(dp), parameter :: largest_misfit = 0.02_dp  !< of the radius of a measured curve and the ring's, relative

  !> A profile and the circle that goes on it.
  type :: cam_t
    character(len=:), allocatable :: profile   !< ellipse, cosine, arcs or table
    real(dp) :: radius = 0                     !< of the circle [m]
    real(dp) :: w = 0                          !< deformation in the middle of the band [m]
    integer :: lobes = 2                       !< of a cosine
    real(dp) :: arc = pi/4                     !< half angle of the arcs at the long axis [rad]
    character(len=:), allocatable :: perimeter !< kept, curve or given
    real(dp) :: length = 0                     !< given length of the circle on the cam [m]
    real(dp) :: slope = 0                      !< fall of w along the axis
    real(dp) :: middle = 0                     !< of the band [m]
    type(cam_table_t) :: table                 !< of a measured cam
  contains
    procedure :: deformation
    procedure :: displace
    procedure, private :: polar
    procedure, private :: base
  end type cam_t

  !> The circle on the profile, at one height and share of the assembly.
  type :: curve_t
    type(cam_t) :: cam
    real(dp) :: w = 0                          !< deformation [m]
    real(dp) :: parallel = 0                   !< distance from the profile [m]
    real(dp) :: length = 0                     !< [m]
    real(dp) :: offset = 0                     !< place of theta = 0, so that points are not turned in the mean [rad]
    real(dp), allocatable, private :: phi(:)   !< ends of panels [rad]
    real(dp), allocatable, private :: arc(:)   !< arc length up to them [m]
  contains
    procedure :: put
    procedure :: radius
    procedure, private :: step
  end type curve_t

contains

  !> The cam of a scene.
  subroutine new_cam(scene, radius, cam, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    real(dp), intent(in) :: radius                    !< of the circle that goes on it [m]
    type(cam_t), intent(out) :: cam                   !< cam
    type(error_t), allocatable, intent(out) :: error  !< table
    cam%profile = trim(scene%cam)
    cam%radius = radius
    cam%w = scene%w
    cam%lobes = scene%lobes
    cam%arc = scene%arc_angle_deg*pi/180
    cam%perimeter = trim(scene%perimeter)
    cam%length = scene%perimeter_length
    cam%slope = tan(scene%cone_angle_deg*pi/180)
    cam%middle = scene%band_start + scene%band_length/2
    if (cam%profile /= 'table') return
    call read_cam_table(trim(scene%cam_file), cam%table, error)
    if (allocated(error)) return
    cam%w = cam%table%amplitude
    if (.not. cam%w > hair*radius) then
      call raise(error, code_input, trim(scene%cam_file)//': the radii are all alike; a round wave generator is w = 0')
    else if (cam%perimeter == 'curve' .and. abs(cam%table%mean - radius) > largest_misfit*radius) then
      call raise(error, code_input, "wave_generator.perimeter = 'curve': the mean radius of "//trim(scene%cam_file)//' is '// &
        to_text(cam%table%mean)//' m, the ring''s inside '//to_text(radius)//" m; valid: 'kept', or a table of the curve "// &
        'on which the ring''s inside lies')
    end if
  end subroutine new_cam

  !> Deformation at a height: w in the middle of the band; a cone's falls towards the bottom [m].
  elemental real(dp) function deformation(self, z) result(w)
    class(cam_t), intent(in) :: self  !< cam
    real(dp), intent(in) :: z         !< distance from the opening [m]
    w = self%w - self%slope*(z - self%middle)
  end function deformation

  !> Displacement of the circle to first order in the deformation.
  elemental subroutine displace(self, w, theta, u, v)
    class(cam_t), intent(in) :: self  !< cam
    real(dp), intent(in) :: w         !< deformation [m]
    real(dp), intent(in) :: theta     !< angle from the long axis [rad]
    real(dp), intent(out) :: u, v     !< radial and tangential displacement [m]
    real(dp) :: lobe, side, centre, psi
    select case (self%profile)
    case ('arcs')
      call arcs(self, w, lobe, side, centre)
      psi = abs(modulo(theta + pi/2, pi) - pi/2)  ! from the nearer end of the long axis, 0 to pi/2
      if (psi <= self%arc) then
        u = lobe + centre*cos(psi)
        v = -(lobe*psi + centre*sin(psi))
      else
        u = side - centre*tan(self%arc)*sin(psi)
        v = side*(pi/2 - psi) - centre*tan(self%arc)*cos(psi)
      end if
      if (modulo(theta + pi/2, pi) < pi/2) v = -v
    case ('table')
      call radius_deviation(self%table, theta, u, total=v)
      u = u*(w/self%w)
      v = -v*(w/self%w)
    case default
      u = w*cos(self%lobes*theta)
      v = -w/self%lobes*sin(self%lobes*theta)
    end select
    if (self%perimeter == 'curve') u = u + base(self) - self%radius
    if (self%perimeter == 'given') u = u + self%length/(2*pi) - self%radius
  end subroutine displace

  !> Mean radius of the profile [m].
  elemental real(dp) function base(self)
    class(cam_t), intent(in) :: self  !< cam
    base = self%radius
    if (self%profile == 'table') base = self%table%mean
  end function base

  !> Four arcs that meet in a tangent, of the circle's length: radii over the base radius at the long and at the short axis, and
  !> distance of the centre of the former from the axis.
  pure subroutine arcs(cam, w, lobe, side, centre)
    class(cam_t), intent(in) :: cam                !< cam
    real(dp), intent(in) :: w                      !< deformation [m]
    real(dp), intent(out) :: lobe, side, centre    !< [m]
    real(dp) :: part
    part = (1 - 2*cam%arc/pi)/cos(cam%arc)
    centre = w/(1 - part)
    lobe = -centre*part
    side = lobe + centre/cos(cam%arc)
  end subroutine arcs

  !> Radius of the profile over the polar angle and its derivatives.
  elemental subroutine polar(self, w, phi, r, dr, ddr)
    class(cam_t), intent(in) :: self     !< cam
    real(dp), intent(in) :: w            !< deformation [m]
    real(dp), intent(in) :: phi          !< polar angle [rad]
    real(dp), intent(out) :: r, dr, ddr  !< [m], by rad
    real(dp) :: a, b, s, lobe, side, centre, chi
    select case (self%profile)
    case ('ellipse')
      a = self%radius + w
      b = self%radius - w
      s = sqrt((b*cos(phi))**2 + (a*sin(phi))**2)
      r = a*b/s
      dr = -a*b*(a*a - b*b)*sin(phi)*cos(phi)/s**3
      ddr = -a*b*(a*a - b*b)*(cos(2*phi)/s**3 - 3*(a*a - b*b)*(sin(phi)*cos(phi))**2/s**5)
    case ('arcs')
      call arcs(self, w, lobe, side, centre)
      chi = modulo(phi + pi/2, pi) - pi/2
      if (abs(chi) <= junction(self, w)) then
        s = self%radius + lobe
      else
        chi = chi - sign(pi/2, chi)
        s = self%radius + side
        centre = -centre*tan(self%arc)
      end if
      a = sqrt(s**2 - (centre*sin(chi))**2)
      r = centre*cos(chi) + a
      dr = -centre*sin(chi)*(1 + centre*cos(chi)/a)
      ddr = -centre*cos(chi) - centre**2*(cos(2*chi)/a + (centre*sin(chi)*cos(chi))**2/a**3)
    case ('table')
      call radius_deviation(self%table, phi, r, dr, ddr)
      r = self%table%mean + w/self%w*r
      dr = w/self%w*dr
      ddr = w/self%w*ddr
    case default
      r = self%radius + w*cos(self%lobes*phi)
      dr = -self%lobes*w*sin(self%lobes*phi)
      ddr = -self%lobes**2*w*cos(self%lobes*phi)
    end select
  end subroutine polar

  !> Polar angle at which the arcs meet [rad].
  pure real(dp) function junction(cam, w)
    class(cam_t), intent(in) :: cam  !< cam
    real(dp), intent(in) :: w        !< deformation [m]
    real(dp) :: lobe, side, centre
    call arcs(cam, w, lobe, side, centre)
    junction = atan2((cam%radius + lobe)*sin(cam%arc), centre + (cam%radius + lobe)*cos(cam%arc))
  end function junction

  !> The curve of a share of the assembly; its length runs evenly from the circle's to that of the whole.
  subroutine new_curve(cam, w, part, curve)
    class(cam_t), intent(in) :: cam        !< cam
    real(dp), intent(in) :: w              !< deformation of the whole assembly at this height [m]
    real(dp), intent(in) :: part           !< of the assembly, 0 to 1
    type(curve_t), intent(out) :: curve    !< curve
    real(dp) :: moment, s
    integer :: i, n
    curve%cam = cam
    curve%w = part*w
    curve%phi = panel_ends(cam, curve%w)
    n = size(curve%phi) - 1
    allocate (curve%arc(n + 1), source=0._dp)
    select case (cam%perimeter)
    case ('curve')
      curve%parallel = (1 - part)*(cam%radius - base(cam))
    case default
      s = 0
      do i = 1, n
        s = s + curve%step(curve%phi(i), curve%phi(i + 1))
      end do
      curve%parallel = cam%radius - s/(2*pi)
      if (cam%perimeter == 'given') curve%parallel = curve%parallel + part*(cam%length/(2*pi) - cam%radius)
    end select
    moment = 0
    do i = 1, n
      curve%arc(i + 1) = curve%arc(i) + curve%step(curve%phi(i), curve%phi(i + 1), moment)
    end do
    curve%length = curve%arc(n + 1)
    curve%offset = moment/curve%length - (curve%phi(1) + curve%phi(n + 1))/2
  end subroutine new_curve

  !> Angles between which the profile is smooth, over one turn.
  pure function panel_ends(cam, w) result(phi)
    class(cam_t), intent(in) :: cam  !< cam
    real(dp), intent(in) :: w        !< deformation [m]
    real(dp), allocatable :: phi(:)
    integer :: i, n
    select case (cam%profile)
    case ('table')
      phi = cam%table%theta
    case ('arcs')
      n = panels/8
      allocate (phi(4*n + 1))
      associate (j => junction(cam, w))
        phi(:n) = [((2*i - n)*j/n, i=0, n - 1)]
        phi(n + 1:2*n) = [(j + i*(pi - 2*j)/n, i=0, n - 1)]
      end associate
      phi(2*n + 1:4*n) = phi(:2*n) + pi
      phi(4*n + 1) = phi(1) + 2*pi
    case default
      n = panels*max(1, cam%lobes/4)
      phi = [(i*(2*pi/n), i=0, n)]
    end select
  end function panel_ends

  !> Arc length between two angles of one panel; adds its moment about the angle 0.
  real(dp) function step(self, low, high, moment) result(s)
    class(curve_t), intent(in) :: self             !< curve
    real(dp), intent(in) :: low, high              !< [rad]
    real(dp), intent(inout), optional :: moment    !< int phi ds [m rad]
    real(dp), dimension(8) :: phi, r, dr, ddr, speed
    phi = (low + high)/2 + (high - low)/2*gauss_8
    call self%cam%polar(self%w, phi, r, dr, ddr)
    speed = hypot(r, dr)
    speed = speed + self%parallel*(r**2 + 2*dr**2 - r*ddr)/speed**2  ! parallel curves: the turn of the normal times the distance
    s = (high - low)*sum(weight_8/2*speed)
    if (present(moment)) moment = moment + (high - low)*sum(weight_8/2*speed*phi)
  end function step

  !> Distance of the curve from the axis at a polar angle; what it leaves out is of the order w**4/r**3 [m].
  elemental real(dp) function radius(self, phi)
    class(curve_t), intent(in) :: self  !< curve
    real(dp), intent(in) :: phi         !< polar angle [rad]
    real(dp) :: r, dr, ddr
    call self%cam%polar(self%w, phi, r, dr, ddr)
    radius = r + self%parallel*hypot(r, dr)/r
  end function radius

  !> Put a point of the circle on the curve.
  subroutine put(self, theta, x, normal, bend)
    class(curve_t), intent(in) :: self             !< curve
    real(dp), intent(in) :: theta                  !< angle on the circle [rad]
    real(dp), intent(out) :: x(2)                  !< place [m]
    real(dp), intent(out), optional :: normal(2)   !< outward
    real(dp), intent(out), optional :: bend        !< curvature [1/m]
    real(dp) :: s, phi, r, dr, ddr, speed, change, n(2)
    integer :: low, i
    s = modulo((theta - self%offset - self%phi(1))/(2*pi), 1._dp)*self%length
    low = min(max(count_up_to(self%arc, s), 1), size(self%arc) - 1)
    phi = self%phi(low) + (s - self%arc(low))/(self%arc(low + 1) - self%arc(low))*(self%phi(low + 1) - self%phi(low))
    do i = 1, 6
      call self%cam%polar(self%w, phi, r, dr, ddr)
      speed = hypot(r, dr)
      speed = speed + self%parallel*(r**2 + 2*dr**2 - r*ddr)/speed**2
      change = (s - self%arc(low) - self%step(self%phi(low), phi))/speed
      phi = phi + change
      if (abs(change) < settled) exit
    end do
    call self%cam%polar(self%w, phi, r, dr, ddr)
    n = [r*cos(phi) + dr*sin(phi), r*sin(phi) - dr*cos(phi)]/hypot(r, dr)
    x = r*[cos(phi), sin(phi)] + self%parallel*n
    if (present(normal)) normal = n
    if (present(bend)) then
      bend = (r**2 + 2*dr**2 - r*ddr)/hypot(r, dr)**3
      bend = bend/(1 + self%parallel*bend)
    end if
  end subroutine put
end module hd_cam
