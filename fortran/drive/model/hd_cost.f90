! SPDX-License-Identifier: GPL-3.0-or-later
!> The matrix solver of a scene, and the time and memory that it and the others will take, predicted from the mesh. Condensed
!> bodies are faster and smaller than GMRES around them, and this than exact factors, on every mesh: the first that applies is
!> taken.
!>
!> Factors of the sparse matrix have E entries and take F operations, both powers of the number of dof (MUMPS in a METIS order,
!> meshes one cell thick; solid ones grow faster). Coefficients: one core, measured on scenes of 20 000 to 80 000 dof.
module hd_cost
  use hd_error, only: error_t, raise, code_memory
  use hd_kinds, only: dp, i8
  use hd_memory, only: address_limit_mb, free_memory_mb
  use hd_revolution, only: strip_t
  use hd_scene, only: scene_t
  use hd_section, only: band_rows, cup_strip, ring_strip
  use hd_text, only: to_text
  implicit none
  private
  public :: cost_t, forecast_t, forecast, cost_text, estimate_memory_mb, allowed_memory_mb, check_memory

  !> One solver.
  type :: cost_t
    character(len=9) :: name = ''     !< solver.method, or solver.factors with method 'newton'
    logical :: applies = .false.      !< to the scene, and allowed by it
    real(dp) :: seconds = 0           !< CPU time of a run with `iterations` Newton iterations
    real(dp) :: memory_mb = 0         !< peak
  end type cost_t

  !> All solvers at the time of the choice, and the choice.
  type :: forecast_t
    type(cost_t) :: costs(3)
    real(dp) :: memory_allowed_mb = 0 !< then; not above 0: unknown
    integer :: chosen = 0             !< one of `costs`
  end type forecast_t

  real(dp), parameter :: iterations = 20        !< Newton iterations
  real(dp), parameter :: entries_1 = 7.1e6_dp, flops_1 = 2.0e9_dp, dof_1 = 19680   !< E and F of LU at this size
  real(dp), parameter :: harmonic_time = 0.011_dp, harmonic_growth = 1.2_dp  !< of one iteration by harmonics at dof_1 [s]
  real(dp), parameter :: pressed_mb = 2.1e-3_dp, formed_mb = 2.9e-3_dp, pair_mb = 4e-6_dp  !< of both sides: per node, per pair
  real(dp), parameter :: usable = 0.8_dp        !< share of the free memory that a run may take
  real(dp), parameter :: entry_time = 22e-9_dp  !< per entry of the factors, handling
  real(dp), parameter :: flop_time = 3e-11_dp   !< per operation of a factorisation
  real(dp), parameter :: apply_time = 2e-7_dp   !< per dof and product with Newton's matrix
  real(dp), parameter :: pairs_time = 1.7_dp    !< times as long where pairs follow: more iterations, more steps of GMRES
  real(dp), parameter :: tangent_time = 3e-7_dp !< per dof and iteration, large displacements

contains

  !> What every solver will cost, and the one to take.
  type(forecast_t) function forecast(s, round)
    type(scene_t), intent(in) :: s    !< scene
    logical, intent(in) :: round      !< its bodies have harmonics; where not, only a scene that asks for them gets them
    forecast%costs = predict_costs(s)
    if (.not. round .and. s%may_condense() .and. s%may_newton() .and. free(s)) forecast%costs(:2)%applies = .false.
    forecast%memory_allowed_mb = allowed_memory_mb(s)
    forecast%chosen = findloc(forecast%costs%applies, .true., 1)
  end function forecast

  !> The scene leaves open how Newton's matrix is solved.
  pure logical function free(s)
    type(scene_t), intent(in) :: s    !< scene
    free = s%may_factorise() .and. s%may_harmonics()
  end function free

  !> All solvers, those that do not apply too.
  function predict_costs(s) result(list)
    type(scene_t), intent(in) :: s  !< scene
    type(cost_t) :: list(3)
    real(dp) :: nodes, section, rows, thick, dof, images, extra, tangent, harmonic
    logical :: round, small
    call count_nodes(s, nodes, section, rows, thick)
    dof = 3*nodes
    images = merge(2, 1, modulo(s%divisions, 2) == 0 .and. modulo(s%ring_divisions, 2) == 0 .and. s%most_images() > 1 .and. &
      .not. abs(s%eccentricity) > 0 .and. .not. s%formed())
    extra = min(thick - 1, 2._dp)
    small = .not. s%large()
    tangent = merge(0._dp, tangent_time*dof, small)
    harmonic = harmonic_time*(dof/dof_1)**harmonic_growth
    list(1) = cost_t('condensed', seconds=iterations*harmonic, memory_mb=harmonic_mb(s, nodes, section, rows, thick, images))
    list(2) = cost_t('harmonic', seconds=iterations*(8*(harmonic/3 + apply_time*dof) + tangent), &
      memory_mb=list(1)%memory_mb + merge(pressed_mb, formed_mb, .not. s%formed())*nodes + pair_mb*s%divisions*rows**2)
    list(3) = cost_t('exact', seconds=iterations*(factor_time(dof) + tangent), &
      memory_mb=30 + 2.5e-3_dp*nodes + 10.4e-6_dp*entries(dof))
    if (.not. small) list%seconds = pairs_time*list%seconds
    round = .not. s%support%against_teeth .and. .not. (s%cup_is_slave() .and. s%ring_lifts())
    list(1)%applies = s%may_condense() .and. (.not. s%may_newton() .or. (free(s) .and. round .and. small .and. .not. s%formed()))
    list(2)%applies = s%may_newton() .and. s%may_harmonics() .and. (round .or. .not. free(s))
    list(3)%applies = s%may_newton() .and. s%may_factorise()
    if (s%support%struts) then
      list(1)%applies = s%may_condense() .and. free(s) .and. small
      list(2)%applies = free(s) .and. .not. small
      list(3)%applies = .not. any(list(:2)%applies)
    end if
  contains
    !> Entries of LU of so many dof.
    pure real(dp) function entries(n)
      real(dp), intent(in) :: n
      entries = entries_1*(n/dof_1)**(1.18_dp + 0.1_dp*extra)*1.5_dp**extra
    end function entries

    !> Seconds of a factorisation.
    pure real(dp) function factor_time(n)
      real(dp), intent(in) :: n
      factor_time = entry_time*entries(n) + flop_time*flops_1*(n/dof_1)**(1.53_dp + 0.2_dp*extra)*2**extra
    end function factor_time
  end function predict_costs

  !> Nodes of both bodies and of a sector, dofs of the contact face along the band, cells through the thickness.
  pure subroutine count_nodes(s, nodes, section, rows, thick)
    type(scene_t), intent(in) :: s                            !< scene
    real(dp), intent(out) :: nodes, section, rows, thick      !< counts
    type(strip_t) :: cup, ring
    integer :: first, last
    call cup_strip(s, cup, first, last)
    call ring_strip(s, ring)
    section = size(cup%inner, 2)*(s%through_wall + 1) + size(ring%inner, 2)*(s%through_ring + 1)
    rows = 3*(band_rows(s) + 1)
    thick = max(s%through_wall, s%through_ring)
    if (s%quadratic()) then
      section = 3.5_dp*section
      rows = 3*rows
      thick = thick + 1
    end if
    nodes = real(s%divisions, dp)*section
  end subroutine count_nodes

  !> Memory of condensation by harmonics: nodes, facets, compliance of the face and one band per harmonic [MB];
  !> fitted to 41 runs of 18 to 538 MB, a tenth above their mean.
  pure real(dp) function harmonic_mb(s, nodes, section, rows, thick, images) result(mb)
    type(scene_t), intent(in) :: s                          !< scene
    real(dp), intent(in) :: nodes, section, rows, thick     !< counts
    real(dp), intent(in) :: images                          !< 2: half of the harmonics
    real(dp) :: layers, band
    layers = max(s%through_wall, s%through_ring)
    if (thick > layers) layers = 3*(layers + 2) - 2  ! hex20r
    band = section*(layers + 2)
    mb = 1.1_dp*(14 + 530e-6_dp*nodes + 90e-6_dp*rows**2 + &
      s%divisions*(1.1e-3_dp*rows + 8e-6_dp*band + (2.8e-6_dp*rows**2 + 59e-6_dp*band)/images))
  end function harmonic_mb

  !> What was predicted, for the log.
  function cost_text(list) result(text)
    type(cost_t), intent(in) :: list(:)   !< predictions
    character(len=:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(list)
      if (.not. list(i)%applies) cycle
      if (len(text) > 0) text = text//', '
      text = text//trim(list(i)%name)//' '//to_text(real(nint(10*list(i)%seconds), dp)/10)//' s '// &
        to_text(nint(list(i)%memory_mb))//' MB'
    end do
  end function cost_text

  !> Memory that a run of the scene will need with the solver that is chosen [MB].
  real(dp) function estimate_memory_mb(s) result(mb)
    type(scene_t), intent(in) :: s  !< scene
    type(forecast_t) :: f
    f = forecast(s, .true.)
    mb = f%costs(f%chosen)%memory_mb
  end function estimate_memory_mb

  !> Memory that a run may take: as the scene says, but no more than ulimit does, else four fifths of what is free [MB]; not above 0
  !> where nobody knows.
  real(dp) function allowed_memory_mb(s) result(mb)
    type(scene_t), intent(in) :: s  !< scene
    mb = s%memory_limit_mb
    if (mb <= 0) mb = usable*free_memory_mb()
    if (address_limit_mb() > 0) mb = min(mb, address_limit_mb())
  end function allowed_memory_mb

  !> Refuse a mesh that does not fit before it is tried.
  subroutine check_memory(s, coarsest, error)
    type(scene_t), intent(in) :: s                    !< scene
    logical, intent(in) :: coarsest                   !< no plan has a coarser mesh; else it is that of the input
    type(error_t), allocatable, intent(out) :: error  !< too large
    real(dp) :: need, limit
    character(len=:), allocatable :: mesh, whose, advice
    need = estimate_memory_mb(s)
    limit = allowed_memory_mb(s)
    if (need <= limit .or. limit <= 0) return
    mesh = 'this mesh'
    advice = 'reduce mesh.divisions ('//to_text(s%divisions)//') or mesh.band_facets ('//to_text(s%band_facets)// &
      '), or raise mesh.memory_limit_mb'
    if (coarsest) then
      mesh = 'the coarsest mesh of a plan'
      advice = 'raise mesh.memory_limit_mb'
    end if
    whose = ''
    if (address_limit_mb() > 0 .and. .not. limit < usable*address_limit_mb()) then
      whose = ', by ulimit -v'
      advice = advice(:index(advice, 'raise') - 1)//'raise that'
    else if (.not. s%memory_limit_mb > 0) then
      whose = ', 80 % of what is free now'
    end if
    call raise(error, code_memory, 'error: '//mesh//' needs about '//to_text(nint(need, i8))//' MB, the limit is '// &
      to_text(nint(limit, i8))//' MB'//whose//new_line('a')//'      '//advice)
  end subroutine check_memory
end module hd_cost
