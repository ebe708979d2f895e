! SPDX-License-Identifier: GPL-3.0-or-later
!> How far k_N by theory lies from k_N of a rough contact, and where the theory may be taken in the place of boundary elements.
!>
!> Few long waves may hold most of the height. Until a few of their crests touch, and when but few of their valleys are left open,
!> their phases decide k_N, which no spectrum tells. So the error follows from the waves that count: the smaller of the share that
!> touches and a third of the share that is open, times the independent waves N = (sum h)^2/sum(h^2/m), h the height variance of a
!> band of the spectrum and m its waves (docs/evidence/joint.md). The waves of an area grow with it, so those of the parts of a
!> contact add up.
module hd_persson_error
  use hd_kinds, only: dp
  use hd_roughness_spectrum, only: power_spectrum_t
  use hd_text, only: percent, rounded
  implicit none
  private
  public :: theory_surface_t, theory_error_t, new_theory_surface, theory_scatter, theory_error_of, may_be_taken, in_words
  public :: trust, steep, touching_waves, scatter_of_maps, counted_share

  real(dp), parameter :: trust = 0.25_dp  !< ln k_N within which the theory must hold 95 of 100 single maps to be taken
  real(dp), parameter :: steep = 5        !< E* slope over hardness beyond which nearly all contact yields
  real(dp), parameter :: in_95 = 1.96_dp  !< standard deviations
  real(dp), parameter :: valley = 3       !< open valleys that tell as much as a crest that touches
  !> rms error of ln k_N of single maps over their waves that count (bench/joint_law.py train).
  real(dp), parameter :: touching_waves(8) = [0.059_dp, 0.2_dp, 0.57_dp, 1.8_dp, 5.8_dp, 18._dp, 54._dp, 110._dp]
  real(dp), parameter :: scatter_of_maps(8) = [0.39_dp, 0.29_dp, 0.22_dp, 0.18_dp, 0.13_dp, 0.051_dp, 0.033_dp, 0.03_dp]

  !> What the theory knows of a surface.
  type :: theory_surface_t
    real(dp), allocatable :: pressure(:)  !< rising [Pa]
    real(dp), allocatable :: area(:)      !< true contact there, as a share
    real(dp) :: waves_per_area = 0        !< independent waves [1/m^2]
    real(dp) :: steepness = 0             !< E* slope over hardness
  end type theory_surface_t

  !> Error of the theory on a contact.
  type :: theory_error_t
    real(dp) :: area = 0           !< nominal, that the readings rest on; 0: nothing is known [m^2]
    logical :: sticks = .false.    !< it is what sticks, else all that is pressed
    real(dp) :: pressure = 0       !< mean over it [Pa]
    real(dp) :: share = 0          !< of it that touches
    real(dp) :: waves = 0          !< independent waves on it
    real(dp) :: counted = 0        !< of those, that touch or are left open so that they count
    real(dp) :: half_width = 0     !< of ln k_N, 95 of 100 contacts
    real(dp) :: steepness = 0      !< E* slope over hardness
    real(dp) :: tangent = 0        !< change of the tangent K_TS by k_N so much softer, relative; 0: not known
  end type theory_error_t

contains

  !> Facts of a surface from its spectrum and its contact.
  pure function new_theory_surface(spectrum, modulus, hardness, pressure, area) result(surface)
    type(power_spectrum_t), intent(in) :: spectrum  !< of the equivalent surface
    real(dp), intent(in) :: modulus, hardness       !< E*, H [Pa]
    real(dp), intent(in) :: pressure(:), area(:)    !< rising [Pa], share that touches
    type(theory_surface_t) :: surface
    surface%pressure = pressure
    surface%area = area
    surface%waves_per_area = sum(spectrum%height)**2/sum(spectrum%height**2/spectrum%waves)
    surface%steepness = modulus*sqrt(sum(spectrum%slope))/hardness
  end function new_theory_surface

  !> Share of the waves that count where a share of the area touches.
  elemental real(dp) function counted_share(area)
    real(dp), intent(in) :: area  !< that touches, as a share
    counted_share = min(area, (1 - area)/valley)
  end function counted_share

  !> rms error of ln k_N at waves that count.
  elemental real(dp) function theory_scatter(waves) result(e)
    real(dp), intent(in) :: waves  !< independent waves times `counted_share`
    real(dp) :: x
    integer :: i, n
    n = size(touching_waves)
    x = min(max(waves, touching_waves(1)), touching_waves(n))
    i = min(count(touching_waves <= x), n - 1)
    x = log(x/touching_waves(i))/log(touching_waves(i + 1)/touching_waves(i))
    e = scatter_of_maps(i) + x*(scatter_of_maps(i + 1) - scatter_of_maps(i))
  end function theory_scatter

  !> Error on a contact of many points. Those that stick decide: they carry both readings of K_TS. Where none sticks, all that are
  !> pressed do.
  pure function theory_error_of(surface, pressure, area, sticks) result(found)
    type(theory_surface_t), intent(in) :: surface  !< surface
    real(dp), intent(in) :: pressure(:), area(:)   !< of the points [Pa], [m^2]
    logical, intent(in) :: sticks(:)               !< they stick
    type(theory_error_t) :: found
    logical :: counts(size(pressure))
    real(dp) :: touching, share
    integer :: i
    found%steepness = surface%steepness
    counts = sticks .and. pressure > 0
    found%sticks = any(counts)
    if (.not. found%sticks) counts = pressure > 0
    found%area = sum(area, mask=counts)
    if (.not. found%area > 0) return
    found%pressure = sum(area*pressure, mask=counts)/found%area
    touching = 0
    do i = 1, size(pressure)
      if (.not. counts(i)) cycle
      share = share_at(surface, pressure(i))
      touching = touching + area(i)*share
      found%counted = found%counted + area(i)*surface%waves_per_area*counted_share(share)
    end do
    found%share = touching/found%area
    found%waves = found%area*surface%waves_per_area
    found%half_width = in_95*theory_scatter(found%counted)
  end function theory_error_of

  !> The rule of the choice holds.
  pure logical function may_be_taken(found)
    type(theory_error_t), intent(in) :: found  !< error on a contact
    may_be_taken = found%area > 0 .and. found%half_width <= trust .and. found%steepness <= steep
  end function may_be_taken

  !> The error and what it follows from, in words.
  pure function in_words(found) result(text)
    type(theory_error_t), intent(in) :: found  !< error on a contact
    character(len=:), allocatable :: text
    if (found%steepness > steep) then
      text = 'E* times slope is '//rounded(found%steepness)//' hardnesses, where nearly all contact yields and the error of '// &
        'k_N by theory is not known'
    else
      text = 'k_N by theory lies within '//percent(found%half_width)//' of boundary elements (95 of 100 contacts), since '// &
        rounded(found%counted)//' waves touch: '//rounded(100*found%share)//' % of the '//rounded(1e6_dp*found%area)// &
        ' mm^2 that '//trim(merge('stick      ', 'are pressed', found%sticks))//' under '//rounded(1e-6_dp*found%pressure)// &
        ' MPa in the mean, times '//rounded(found%waves)//' independent waves'
      if (found%share > 1/(1 + valley)) text = text//'; where so much touches, three open waves count as one that touches'
    end if
  end function in_words

  !> True contact at a pressure; in proportion below the first.
  pure real(dp) function share_at(surface, pressure) result(a)
    type(theory_surface_t), intent(in) :: surface  !< surface
    real(dp), intent(in) :: pressure               !< > 0 [Pa]
    real(dp) :: x
    integer :: i, n
    n = size(surface%pressure)
    i = min(max(count(surface%pressure <= pressure), 1), n - 1)
    associate (p => surface%pressure(i:i + 1), s => surface%area(i:i + 1))
      x = log(min(pressure, p(2))/p(1))/log(p(2)/p(1))
      a = s(1)*exp(x*log(s(2)/s(1)))
      if (x < 0) a = s(1)*pressure/p(1)
    end associate
  end function share_at
end module hd_persson_error
