! SPDX-License-Identifier: GPL-3.0-or-later
module test_cup_sections
  use hd_body, only: body_t
  use hd_check, only: check, check_close
  use hd_error, only: error_t
  use hd_harmonics, only: harmonics_t, new_harmonics, factorise_harmonics, solve_body
  use hd_hexahedron, only: hex8i
  use hd_input, only: read_scene
  use hd_kinds, only: dp, pi
  use hd_meridian, only: meridian_t
  use hd_cup_sections, only: meridian_of
  use hd_revolution, only: strip_t, revolve, strip_node
  use hd_scene, only: scene_t
  use hd_section, only: cup_strip
  use hd_text, only: string_t, to_text
  implicit none
  private
  public :: run_cup_sections

contains

  !> Cups by sections.
  subroutine run_cup_sections()
    call same_as_simple()
    call fillets_are_round()
    call torsion_of_tube_and_flange()
    call faults_are_told()
  end subroutine run_cup_sections

  !> Scene from assignments.
  subroutine scene_of(words, scene, error)
    character(len=*), intent(in) :: words(:)           !< 'group.key=value'
    type(scene_t), intent(out) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(string_t) :: list(size(words))
    integer :: i
    do i = 1, size(words)
      list(i)%s = trim(words(i))
    end do
    call read_scene('', list, scene, error)
  end subroutine scene_of

  !> Sections that describe the simple cup give its mesh to the last bit but rounding, with and without cells at the edges.
  subroutine same_as_simple()
    character(len=120) :: words(5)
    type(scene_t) :: simple, other
    type(strip_t) :: a, b
    type(error_t), allocatable :: error
    integer :: first(2), last(2), i
    words(1) = 'cup.sections_r=17.5e-3,17.5e-3,17.5e-3,17.5e-3,17.5e-3,8e-3'
    words(2) = 'cup.sections_z=0,9e-3,10e-3,19.5e-3,19.5e-3,19.5e-3'
    words(3) = 'cup.sections_thickness=0.427e-3,0.427e-3,0.36e-3,0.36e-3,0.5e-3,0.5e-3'
    words(5) = 'mesh.band_facets=14'
    do i = 0, 1
      words(4) = merge('mesh.edge_length=0     ', 'mesh.edge_length=0.1e-3', i == 0)
      call scene_of(words(4:), simple, error)
      call scene_of(words, other, error)
      call check(.not. allocated(error), 'sections of the simple cup are taken')
      if (allocated(error)) return
      call cup_strip(simple, a, first(1), last(1))
      call cup_strip(other, b, first(2), last(2))
      call check(first(1) == first(2) .and. last(1) == last(2) .and. all(shape(a%inner) == shape(b%inner)), &
        'the same stations: '//to_text(size(a%inner, 2))//', '// &
        to_text(size(b%inner, 2)))
      if (any(shape(a%inner) /= shape(b%inner))) return
      call check(maxval(abs(a%inner - b%inner)) < 1e-12_dp .and. maxval(abs(a%outer - b%outer)) < 1e-12_dp, &
        'sections of the simple cup give its meridian')
      call check_close(other%cup_length, 20e-3_dp, 1e-15_dp, 'the length of a cup by sections')
    end do
  end subroutine same_as_simple

  !> The inside of a fillet has its radius, the outside that and the thickness; of a flange that less the thickness.
  subroutine fillets_are_round()
    type(scene_t) :: scene
    type(meridian_t) :: meridian
    type(error_t), allocatable :: error
    character(len=:), allocatable :: fault
    real(dp) :: inner(2), outer(2), centre(2), t
    character(len=80) :: words(4)
    integer :: i, j, outwards
    words(2) = 'cup.sections_z=0,20e-3,20e-3'
    words(3) = 'cup.sections_thickness=0.4e-3,0.4e-3,0.4e-3'
    words(4) = 'cup.sections_fillet=0,2e-3,0'
    do outwards = -1, 1, 2
      words(1) = 'cup.sections_r=17.5e-3,17.5e-3,'//merge('30e-3', ' 8e-3', outwards > 0)
      call scene_of(words, scene, error)
      call check(.not. allocated(error), 'a fillet is taken')
      if (allocated(error)) return
      call meridian_of(scene, meridian, fault)
      call check(size(meridian%piece) == 3, 'wall, fillet, bottom')
      centre = [17.5e-3_dp + outwards*2e-3_dp, 18e-3_dp]
      t = -outwards*0.4e-3_dp
      do i = 1, 3, 2
        do j = 0, 4
          call meridian%at(2, j/4._dp, inner, outer)
          call check_close(norm2(inner - centre), 2e-3_dp, 1e-15_dp, 'radius of the inside')
          call check_close(norm2(outer - centre), 2e-3_dp + t, 1e-15_dp, 'radius of the outside')
        end do
      end do
      call check_close(meridian%length(2), pi*1e-3_dp, 1e-15_dp, 'length of a quarter turn')
    end do
  end subroutine fillets_are_round

  !> A hat under torsion: the turn between two stations of its tapered wall is the integral of T/(G J), that between two radii of
  !> its flange T (1/a^2 - 1/b^2)/(4 pi G t), both to 0.2 %.
  subroutine torsion_of_tube_and_flange()
    real(dp), parameter :: nu = 0.295_dp, e = 209e9_dp, g = e/(2*(1 + nu)), torque = 5
    type(scene_t) :: scene
    type(strip_t) :: cup
    type(body_t) :: body
    type(harmonics_t) :: harmonics
    type(error_t), allocatable :: error
    real(dp), allocatable :: f(:, :, :), u(:, :, :), spring(:, :), turn(:)
    logical, allocatable :: fixed(:, :)
    integer, parameter :: sectors = 128
    integer :: first, last, n, i, a(2), b(2)
    real(dp) :: exact, z, t, h
    character(len=80) :: words(6)
    words(1) = 'cup.sections_r=17.5e-3,17.5e-3,17.5e-3,30e-3'
    words(2) = 'cup.sections_z=0,15e-3,25e-3,25e-3'
    words(3) = 'cup.sections_thickness=0.6e-3,0.6e-3,0.3e-3,0.3e-3'
    words(4) = 'cup.sections_fillet=0,0,1e-3,0'
    words(5) = 'mesh.through_wall=2'
    words(6) = 'mesh.band_facets=24'
    call scene_of(words, scene, error)
    call check(.not. allocated(error), 'a hat is taken')
    if (allocated(error)) return
    call cup_strip(scene, cup, first, last)
    call revolve(cup, sectors, hex8i, body)
    body%young = e
    body%poisson = nu
    n = size(cup%inner, 2)
    allocate (fixed(3, body%nodes_per_sector), source=.false.)
    allocate (spring(3, body%nodes_per_sector), source=0._dp)
    fixed(:, strip_node(cup, n, 1):strip_node(cup, n, 3)) = .true.
    call new_harmonics(body, fixed, spring, harmonics, error)
    call factorise_harmonics(harmonics, 1, error)
    allocate (f(3, body%nodes(), 1), u(3, body%nodes(), 1), source=0._dp)
    f(2, 1::body%nodes_per_sector, 1) = torque/(sectors*17.5e-3_dp)
    call solve_body(harmonics, 1, f, u, error)
    turn = [(u(2, strip_node(cup, i, 1), 1)/cup%inner(1, i), i=1, n)]
    a = [minloc(abs(cup%inner(2, :) - 15e-3_dp), 1), minloc(abs(cup%inner(2, :) - 20e-3_dp), 1)]
    h = (cup%inner(2, a(2)) - cup%inner(2, a(1)))/1000
    exact = 0
    do i = 1, 1000
      z = cup%inner(2, a(1)) + (i - 0.5_dp)*h
      t = 0.6e-3_dp - 0.3e-3_dp*(z - 15e-3_dp)/(24e-3_dp - 15e-3_dp)
      exact = exact + torque*h/(g*pi/2*((17.5e-3_dp + t)**4 - 17.5e-3_dp**4))
    end do
    call check_close((turn(a(1)) - turn(a(2)))/exact, 1._dp, 2e-3_dp, 'turn along a tapered tube')
    b = [minloc(abs(cup%inner(1, :) - 21e-3_dp), 1), minloc(abs(cup%inner(1, :) - 28e-3_dp), 1)]
    exact = torque*(1/cup%inner(1, b(1))**2 - 1/cup%inner(1, b(2))**2)/(4*pi*g*0.3e-3_dp)
    call check_close((turn(b(1)) - turn(b(2)))/exact, 1._dp, 2e-3_dp, 'turn across a flat flange')
  end subroutine torsion_of_tube_and_flange

  !> Every kind of wrong section is refused with one sentence that names it.
  subroutine faults_are_told()
    call refused('17.5e-3,17.5e-3,8e-3', '0,20e-3,20e-3', '0.4e-3,0.4e-3', '0', 'sections_thickness: 2')
    call refused('17.5e-3,17.5e-3,8e-3', '0,20e-3,20e-3', '0.4e-3,0,0.4e-3', '0', 'above 0')
    call refused('17.5e-3,17.5e-3,8e-3', '1e-3,20e-3,20e-3', '0.4e-3,0.4e-3,0.4e-3', '0', 'beginning with 0')
    call refused('17.5e-3,17.5e-3,8e-3', '0,20e-3,21e-3', '0.4e-3,0.4e-3,0.4e-3', '0', 'square to the axis')
    call refused('17.5e-3,17.5e-3,17.5e-3,8e-3', '0,20e-3,12e-3,12e-3', '0.4e-3,0.4e-3,0.4e-3,0.4e-3', '0', 'turns back')
    call refused('17.5e-3,17.5e-3,8e-3,8e-3,19e-3', '0,20e-3,20e-3,9e-3,9e-3', '4e-4,4e-4,4e-4,4e-4,4e-4', '0', 'meets itself')
    call refused('17.5e-3,17.5e-3,17.5e-3,17.5e-3,8e-3', '0,15e-3,15e-3,20e-3,20e-3', '6e-4,6e-4,4e-4,4e-4,4e-4', '0', 'jumps')
    call refused('17.5e-3,17.5e-3,30e-3', '0,20e-3,20e-3', '1e-3,1e-3,1e-3', '0,0.5e-3,0', 'no radius left')
    call refused('17.5e-3,17.5e-3,8e-3', '0,20e-3,20e-3', '1e-3,1e-3,1e-3', '0,12e-3,0', 'do not fit')
    call refused('17.5e-3,17.5e-3,8e-3', '0,12e-3,12e-3', '0.4e-3,0.4e-3,0.4e-3', '0', 'band ends on the straight bore')
    call refused('16.5e-3,17.5e-3,8e-3', '0,20e-3,20e-3', '0.4e-3,0.4e-3,0.4e-3', '0', 'band ends on the straight bore')
    call refused('17.5e-3,17.5e-3,17.5e-3,8e-3', '0,20e-3,20e-3,20e-3', '4e-4,4e-4,1e-3,1e-3', '0,30e-3,0,0', 'do not fit')
    call refused('17.5e-3', '0', '0.4e-3', '0', 'three points or more')
  contains
    subroutine refused(r, z, t, fillet, what)
      character(len=*), intent(in) :: r, z, t, fillet, what
      type(scene_t) :: scene
      type(error_t), allocatable :: error
      character(len=100) :: words(4)
      words(1) = 'cup.sections_r='//r
      words(2) = 'cup.sections_z='//z
      words(3) = 'cup.sections_thickness='//t
      words(4) = 'cup.sections_fillet='//fillet
      call scene_of(words, scene, error)
      call check(allocated(error), 'refused: '//what)
      if (allocated(error)) call check(index(error%message, what) > 0, 'told: '//what//', not: '//error%message)
    end subroutine refused
  end subroutine faults_are_told
end module test_cup_sections
