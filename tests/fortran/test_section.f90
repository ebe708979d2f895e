! SPDX-License-Identifier: GPL-3.0-or-later
module test_section
  use hd_check, only: check
  use hd_kinds, only: dp
  use hd_revolution, only: strip_t
  use hd_scene, only: scene_t
  use hd_section, only: ring_strip, cup_strip
  use hd_text, only: to_text
  implicit none
  private
  public :: run_section

contains

  !> Bands that end anywhere beside the rim's end and its taper's (9 and 10 mm), with cells of any length at their edges.
  subroutine run_section()
    integer, parameter :: facets(3) = [12, 16, 46]
    type(scene_t) :: scene
    type(strip_t) :: ring, cup
    real(dp) :: ratio(2), longest(2), place
    integer :: first, last, i, j, k
    longest = 0
    place = 0
    do i = 0, 50
      do j = 1, size(facets)
        do k = 1, 4
          scene%band_length = 9e-3_dp + i*0.1e-3_dp
          scene%band_facets = facets(j)
          scene%edge_length = scene%band_length/(6*4**k)
          call ring_strip(scene, ring)
          call cup_strip(scene, cup, first, last)
          ratio = [worst(ring%inner(2, :)), worst(pack(cup%inner(2, :), cup%inner(1, :) > scene%bore_radius*(1 - 1e-9_dp)))]
          if (ratio(1) > longest(1)) place = scene%band_length
          longest = max(longest, ratio)
        end do
      end do
    end do
    call check(longest(1) < 2.5_dp, 'neighbouring rows of the band: '//to_text(longest(1))//' : 1, band of '//to_text(place)//' m')
    call check(longest(2) < 3, 'neighbouring rows of the cup: '//to_text(longest(2))//' : 1')
  end subroutine run_section

  !> Largest ratio of the lengths of neighbours.
  pure real(dp) function worst(z)
    real(dp), intent(in) :: z(:)  !< stations [m]
    real(dp) :: x(size(z) - 1)
    integer :: n
    n = size(x)
    x = z(2:) - z(:n)
    worst = maxval(max(x(2:)/x(:n - 1), x(:n - 1)/x(2:)))
  end function worst
end module test_section
