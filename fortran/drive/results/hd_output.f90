! SPDX-License-Identifier: GPL-3.0-or-later
!> The folder of a run: tables, grids for ParaView, echo of the input, and last of all the summary.
module hd_output
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_body, only: cartesian, cell_nodes
  use hd_drive, only: drive_t
  use hd_error, only: error_t, raise, code_file
  use hd_facets, only: facets_t, sums_t, sum_names, sum_values, facet_names, facet_rows
  use hd_hexahedron, only: hex20r
  use hd_input, only: write_echo
  use hd_newton, only: iteration_t
  use hd_problem, only: state_t
  use hd_results_folder, only: check_folder, clear_folder
  use hd_scene, only: scene_t
  use hd_stress, only: body_stress, stress_matrices_t, principal_stresses, von_mises
  use hd_surface_run, only: surface_files
  use hd_system, only: path_file, path_kind, remove_file
  use hd_table, only: table_t
  use hd_teeth, only: teeth_t
  use hd_twist_shares, only: part_names
  use hd_vtu, only: vtu_field_t, write_vtu, write_pvd
  implicit none
  private
  public :: result_files, fatigue_file, turning_file, output_t, step_t, open_output, reopen_output, find_table_sizes, table_sums, &
    write_step, write_facets, write_teeth, write_history, write_grids, close_output, add_place

  character(len=*), parameter :: fatigue_file = 'fatigue.csv', turning_file = 'turning.csv'  !< of other writers
  !> Names of the files that runs leave, one of surfaces too, besides echo and summary.
  character(len=*), parameter :: result_files = 'steps.csv,history.csv,contact.csv,loop.csv,balls.csv,teeth.csv,'// &
    'bodies.pvd,contact.pvd,bodies_*[0-9].vtu,contact_*[0-9].vtu,'//fatigue_file//','//turning_file//','//surface_files

  !> Where a step stands in the run.
  type :: step_t
    integer :: number = 0
    logical :: loaded = .false.      !< in the torque, else in the assembly
    real(dp) :: load_factor = 0      !< share of the phase, 0 to 1
    real(dp) :: torque = 0           !< [N m]
    integer :: iterations = 0
    real(dp) :: seconds = 0          !< wall clock it took
  end type step_t

  type :: output_t
    character(len=:), allocatable :: folder
    type(table_t) :: contact, history, steps, teeth, loop, balls
    integer, allocatable :: grids(:)       !< load steps that have grids
    real(dp), allocatable :: times(:)      !< ParaView's times of them
  end type output_t

contains

  !> Prepare the folder; earlier results are only replaced with `force`.
  subroutine open_output(folder, scene, force, output, error)
    character(len=*), intent(in) :: folder            !< folder
    type(scene_t), intent(in) :: scene                !< scene
    logical, intent(in) :: force                      !< replace earlier results
    type(output_t), intent(out) :: output             !< open tables
    type(error_t), allocatable, intent(out) :: error  !< exists already, cannot be written
    character(len=*), parameter :: place = 'step,phase,load_factor,torque_nm'
    call check_folder(folder, result_files, force, error)
    if (allocated(error)) return
    output%folder = folder
    allocate (output%grids(0), output%times(0))
    call clear_folder(folder, result_files, error)
    if (allocated(error)) return
    if (.not. scene%planned_tolerance > 0) then
      call remove_file(folder//'/plan.csv')
      call remove_file(folder//'/plan.nml')
    end if
    call write_echo(folder//'/echo.nml', scene, error)
    if (allocated(error)) return
    call output%contact%open(folder//'/contact.csv', place//',facet,i_theta,i_z,'//facet_names, error)
    if (.not. allocated(error)) call output%history%open(folder//'/history.csv', place//',attempt,iteration,'// &
      'residual,change,open,stick,slip,damping,'// &
      'linear_error,seconds', error)
    if (.not. allocated(error)) call output%steps%open(folder//'/steps.csv', place//','//sum_names//',iterations,seconds', error)
    if (scene%support%against_teeth .and. .not. allocated(error)) call output%teeth%open(folder//'/teeth.csv', &
      place//',tooth,theta_rad,flank,force_n,share,closing_m', error)
    if (scene%support%loop .and. .not. allocated(error)) call open_loop_tables(folder, place, scene, output, error)
    if (allocated(error)) call close_output(output, error)
  end subroutine open_output

  !> Tables of the whole drive.
  subroutine open_loop_tables(folder, place, scene, output, error)
    character(len=*), intent(in) :: folder            !< folder
    character(len=*), intent(in) :: place             !< first columns
    type(scene_t), intent(in) :: scene                !< scene
    type(output_t), intent(inout) :: output           !< tables
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    character(len=:), allocatable :: shares
    integer :: i
    shares = ''
    do i = 1, size(part_names)
      shares = shares//',share_'//trim(part_names(i))
    end do
    call output%teeth%open(folder//'/teeth.csv', place//',tooth,theta_rad,flank,force_n,share,closing_m,friction_n,'// &
      'moment_nm', error)
    if (.not. allocated(error)) call output%loop%open(folder//'/loop.csv', place//',angle_rad,work_j,stored_j,dissipated_j,'// &
      'dissipated_teeth_j,wave_generator_torque_nm,ball_force_max_n,tooth_force_max_n,k_ts_nm_per_rad,'// &
      'balls_loaded,pairs_loaded'//shares, error)
    if (scene%balls > 0 .and. .not. allocated(error)) call output%balls%open(folder//'/balls.csv', &
      place//',ball,theta_rad,force_n,share,closing_m,axial_force_n', error)
  end subroutine open_loop_tables

  !> Take up the folder of a stopped run. Grids that its checkpoint does not know, as of the step that it ended early with, go.
  subroutine reopen_output(folder, scene, sizes, sums, steps, output, error)
    character(len=*), intent(in) :: folder            !< folder
    type(scene_t), intent(in) :: scene                !< scene
    integer(int64), intent(in) :: sizes(6)            !< of the tables at the checkpoint [bytes]
    integer(int64), intent(in) :: sums(6)             !< their checksums
    integer, intent(in) :: steps                      !< load steps at the checkpoint
    type(output_t), intent(inout) :: output           !< its grids; gets open tables
    type(error_t), allocatable, intent(out) :: error  !< files lost, cannot be written
    integer :: i
    output%folder = folder
    do i = 1, steps + 1
      if (any(output%grids == i)) cycle
      call remove_file(folder//'/'//grid_name('bodies', i))
      call remove_file(folder//'/'//grid_name('contact', i))
    end do
    do i = 1, size(output%grids)
      call demand_file(grid_name('bodies', output%grids(i)))
      call demand_file(grid_name('contact', output%grids(i)))
    end do
    if (.not. allocated(error)) call write_lists(output, error)
    if (allocated(error)) return
    call remove_file(folder//'/summary.json')
    call write_echo(folder//'/echo.nml', scene, error)
    if (.not. allocated(error)) call output%contact%reopen(folder//'/contact.csv', sizes(1), sums(1), error)
    if (.not. allocated(error)) call output%history%reopen(folder//'/history.csv', sizes(2), sums(2), error)
    if (.not. allocated(error)) call output%steps%reopen(folder//'/steps.csv', sizes(3), sums(3), error)
    if (sizes(4) > 0 .and. .not. allocated(error)) call output%teeth%reopen(folder//'/teeth.csv', sizes(4), sums(4), error)
    if (sizes(5) > 0 .and. .not. allocated(error)) call output%loop%reopen(folder//'/loop.csv', sizes(5), sums(5), error)
    if (sizes(6) > 0 .and. .not. allocated(error)) call output%balls%reopen(folder//'/balls.csv', sizes(6), sums(6), error)
    if (allocated(error)) call close_output(output, error)
  contains
    !> A grid that the lists name is there.
    subroutine demand_file(name)
      character(len=*), intent(in) :: name  !< in the folder
      if (path_kind(folder//'/'//name) /= path_file .and. .not. allocated(error)) call raise(error, code_file, "'"//folder//'/'// &
        name//"' of an earlier load step is gone, or no file: begin anew with --force")
    end subroutine demand_file
  end subroutine reopen_output

  !> Lengths of the tables so far.
  subroutine find_table_sizes(output, sizes, error)
    type(output_t), intent(inout) :: output           !< tables
    integer(int64), intent(out) :: sizes(6)           !< [bytes]
    type(error_t), allocatable, intent(out) :: error  !< disk full
    sizes = 0
    call output%contact%find_bytes(sizes(1), error)
    if (.not. allocated(error)) call output%history%find_bytes(sizes(2), error)
    if (.not. allocated(error)) call output%steps%find_bytes(sizes(3), error)
    if (.not. allocated(error)) call output%teeth%find_bytes(sizes(4), error)
    if (.not. allocated(error)) call output%loop%find_bytes(sizes(5), error)
    if (.not. allocated(error)) call output%balls%find_bytes(sizes(6), error)
  end subroutine find_table_sizes

  !> Checksums of the tables so far.
  pure function table_sums(output) result(sums)
    type(output_t), intent(in) :: output  !< tables
    integer(int64) :: sums(6)
    sums = [output%contact%sum, output%history%sum, output%steps%sum, output%teeth%sum, output%loop%sum, output%balls%sum]
  end function table_sums

  !> First four columns of every table.
  subroutine add_place(table, step)
    type(table_t), intent(inout) :: table  !< table
    type(step_t), intent(in) :: step       !< step
    call table%add(step%number)
    call table%add(trim(merge('torque  ', 'assembly', step%loaded)))
    call table%add(step%load_factor)
    call table%add(step%torque)
  end subroutine add_place

  !> Rows of a step in contact.csv, one per facet.
  subroutine write_facets(output, step, drive, facets, error)
    type(output_t), intent(inout) :: output           !< tables
    type(step_t), intent(in) :: step                  !< step
    type(drive_t), intent(in) :: drive                !< drive
    type(facets_t), intent(in) :: facets              !< its facets
    type(error_t), allocatable, intent(out) :: error  !< disk full
    real(dp), allocatable :: fields(:, :), rows(:, :)
    integer :: f
    fields = facet_rows(facets)
    allocate (rows(3 + size(fields, 1), size(fields, 2)))
    do f = 1, size(rows, 2)
      rows(:3, f) = [f, (f - 1)/drive%axial_facets + 1, modulo(f - 1, drive%axial_facets) + 1]
      rows(4:, f) = fields(:, f)
    end do
    call add_place(output%contact, step)
    call output%contact%end_rows(rows, error)
  end subroutine write_facets

  !> Row of a converged step in steps.csv.
  subroutine write_step(output, step, sums, error)
    type(output_t), intent(inout) :: output           !< tables
    type(step_t), intent(in) :: step                  !< step
    type(sums_t), intent(in) :: sums                  !< its sums
    type(error_t), allocatable, intent(out) :: error  !< disk full
    real(dp), allocatable :: values(:)
    integer :: i
    call add_place(output%steps, step)
    values = sum_values(sums)
    do i = 1, size(values)
      call output%steps%add(values(i))
    end do
    call output%steps%add(step%iterations)
    call output%steps%add(step%seconds)
    call output%steps%end_row(error)
  end subroutine write_step

  !> Rows of a converged step in teeth.csv, one per pair of teeth: the flank that the torque presses.
  subroutine write_teeth(output, step, teeth, error)
    type(output_t), intent(inout) :: output           !< tables
    type(step_t), intent(in) :: step                  !< step
    type(teeth_t), intent(in) :: teeth                !< forces of the pairs
    type(error_t), allocatable, intent(out) :: error  !< disk full
    integer :: i
    do i = 1, teeth%n
      call add_place(output%teeth, step)
      call output%teeth%add(i)
      call output%teeth%add(teeth%theta(i))
      call output%teeth%add(teeth%flank)
      call output%teeth%add(teeth%force(i))
      call output%teeth%add(teeth%force(i)/max(sum(teeth%force), tiny(1._dp)))
      call output%teeth%add(teeth%closing(i))
      call output%teeth%end_row(error)
      if (allocated(error)) return
    end do
  end subroutine write_teeth

  !> Rows of the convergence history of one attempt.
  subroutine write_history(output, step, attempt, history, error)
    type(output_t), intent(inout) :: output           !< tables
    type(step_t), intent(in) :: step                  !< step
    integer, intent(in) :: attempt                    !< attempts before this one
    type(iteration_t), intent(in) :: history(:)       !< iterates
    type(error_t), allocatable, intent(out) :: error  !< disk full
    integer :: i
    do i = 1, size(history)
      associate (h => history(i))
        call add_place(output%history, step)
        call output%history%add(attempt)
        call output%history%add(h%iteration)
        call output%history%add(h%residual)
        call output%history%add(h%changes)
        call output%history%add(h%open)
        call output%history%add(h%stick)
        call output%history%add(h%slip)
        call output%history%add(h%damping)
        call output%history%add(h%linear)
        call output%history%add(h%seconds)
      end associate
      call output%history%end_row(error)
      if (allocated(error)) return
    end do
  end subroutine write_history

  !> Grids of a step: the bodies with their displacements and the contact face with its fields.
  subroutine write_grids(output, step, drive, facets, state, error)
    type(output_t), intent(inout) :: output           !< folder
    type(step_t), intent(in) :: step                  !< step
    type(drive_t), intent(in) :: drive                !< drive
    type(facets_t), intent(in) :: facets              !< its facets
    type(state_t), intent(in) :: state                !< its state
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(vtu_field_t) :: fields(8), of_grid(3)
    type(stress_matrices_t) :: matrices(2)
    real(dp), allocatable :: x(:, :), u(:, :), tag(:, :), stress(:, :), peak(:, :)
    real(dp) :: time
    integer, allocatable :: cells(:, :), place(:), used(:)   ! used: nodes of the contact face; place: their numbers among them
    integer :: b, c, s, m
    associate (problem => drive%problem)
      m = sum(problem%bodies%sectors*[(size(problem%bodies(b)%cells, 2), b=1, 2)])
      allocate (x(3, problem%n), u(3, problem%n), cells(size(problem%bodies(1)%cells, 1), m), tag(1, m))
      allocate (stress(6, problem%n), peak(6, m))
      m = 0
      do b = 1, 2
        associate (body => problem%bodies(b), range => problem%first(b))
          x(:, range + 1:range + body%nodes()) = body%x
          u(:, range + 1:range + body%nodes()) = cartesian(body, state%u(:, range + 1:range + body%nodes()))
          call body_stress(problem, b, state%u, matrices(b), error, stress(:, range + 1:range + body%nodes()), &
            peak(:, m + 1:m + body%sectors*size(body%cells, 2)))
          if (allocated(error)) return
          do s = 0, body%sectors - 1
            do c = 1, size(body%cells, 2)
              m = m + 1
              cells(:, m) = range + cell_nodes(body, c, s)
              tag(1, m) = merge(1, 2, b == drive%b_ring)
            end do
          end do
        end associate
      end do
      fields(1) = vtu_field_t('displacement_m', u, .false.)
      fields(2) = vtu_field_t('body', tag, .true.)
      fields(3) = vtu_field_t('von_mises_pa', reshape(von_mises(stress), [1, problem%n]), .false.)
      fields(4) = vtu_field_t('principal_stresses_pa', principal_stresses(stress), .false.)
      fields(5) = vtu_field_t('von_mises_max_of_gauss_points_pa', reshape(von_mises(peak), [1, m]), .true.)
      fields(6) = vtu_field_t('principal_stresses_of_that_point_pa', principal_stresses(peak), .true.)
      ! ParaView's time: the share of the assembly less one, then the share of the torque steps
      time = step%load_factor - merge(0, 1, step%loaded)
      of_grid(1) = vtu_field_t('TimeValue', reshape([time], [1, 1]))
      of_grid(2) = vtu_field_t('torque_nm', reshape([step%torque], [1, 1]))
      of_grid(3) = vtu_field_t('step', reshape([real(step%number, dp)], [1, 1]))
      call write_vtu(output%folder//'/'//grid_name('bodies', step%number), x, cells, &
        merge(25, 12, problem%bodies(1)%kind == hex20r), fields(:6), of_grid, error)
      if (allocated(error)) return
      if (.not. any(output%grids == step%number)) then  ! a run that ends early writes those of its last step once more
        output%grids = [output%grids, step%number]
        output%times = [output%times, time]
      end if
      allocate (place(problem%n), source=0)
      place(pack(drive%face%nodes(:4, :), .true.)) = 1
      used = pack([(b, b=1, problem%n)], place > 0)
      place(used) = [(b, b=1, size(used))]
      fields(1) = vtu_field_t('displacement_m', u(:, used), .false.)
      fields(2) = vtu_field_t('pressure_pa', facets%traction([1], :), .true.)
      fields(3) = vtu_field_t('shear_pa', facets%traction([2, 3], :), .true.)  ! a section would be read beyond its end: gfortran 12
      fields(4) = vtu_field_t('gap_m', reshape(facets%gap, [1, size(facets%gap)]), .true.)
      fields(5) = vtu_field_t('slip_m', facets%slip, .true.)
      fields(6) = vtu_field_t('state_0_open_1_stick_2_slip', reshape(real(facets%state, dp), [1, size(facets%gap)]), .true.)
      fields(7) = vtu_field_t('k_n_n_per_m', reshape(facets%k_n, [1, size(facets%gap)]), .true.)
      fields(8) = vtu_field_t('k_t_n_per_m', reshape(facets%k_t, [1, size(facets%gap)]), .true.)
      call write_vtu(output%folder//'/'//grid_name('contact', step%number), x(:, used), &
        reshape(place(pack(drive%face%nodes(:4, :), .true.)), [4, size(facets%gap)]), 9, fields, of_grid, error)
      if (allocated(error)) return
    end associate
    call write_lists(output, error)
  end subroutine write_grids

  !> ParaView's lists of the grids; none where there are no grids.
  subroutine write_lists(output, error)
    type(output_t), intent(in) :: output              !< folder, steps, times
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    character(len=*), parameter :: names(2) = [character(len=7) :: 'bodies', 'contact']
    character(len=40) :: files(size(output%grids))
    integer :: i, k
    do k = 1, size(names)
      do i = 1, size(files)  ! a constructor would ask for the length of a name of no grid: gfortran 12
        files(i) = grid_name(trim(names(k)), output%grids(i))
      end do
      if (size(files) > 0) then
        call write_pvd(output%folder//'/'//trim(names(k))//'.pvd', files, output%times, error)
      else
        call remove_file(output%folder//'/'//trim(names(k))//'.pvd')
      end if
      if (allocated(error)) return
    end do
  end subroutine write_lists

  !> File of the grid of the bodies or of the contact face at a step.
  pure function grid_name(what, step) result(name)
    character(len=*), intent(in) :: what  !< 'bodies' or 'contact'
    integer, intent(in) :: step           !< number
    character(len=:), allocatable :: name
    character(len=10) :: number
    write (number, '(I0.4)') step
    name = what//'_'//trim(number)//'.vtu'
  end function grid_name

  !> Close the tables; an error that is there already stays.
  subroutine close_output(output, error)
    type(output_t), intent(inout) :: output             !< tables
    type(error_t), allocatable, intent(inout) :: error  !< disk full
    call output%contact%close(error)
    call output%history%close(error)
    call output%steps%close(error)
    call output%teeth%close(error)
    call output%loop%close(error)
    call output%balls%close(error)
  end subroutine close_output
end module hd_output
