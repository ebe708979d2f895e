! SPDX-License-Identifier: GPL-3.0-or-later
!> Mortar coupling of two faces on a common chart: where facets overlap, the product of the dual basis of the slave side
!> and the shape functions of both sides is integrated exactly, segment by segment (Wohlmuth 2000; Popp et al. 2010).
!>
!> The relative displacement at multiplier j is  w_j = (1/a_j) int phi_j (u_master - u_slave) dA,  taken component by
!> component in the dofs of the nodes; a_j = int phi_j dA. Its transpose times a_j sends tractions to nodal forces.
!> On a cylinder the components are u_r, u_theta, u_z, so the gap is that of the smooth cylinder, not of its facets.
!> Between bodies that have moved far (hd_pairing) both sums are turned into a frame of the multiplier's own first.
module hd_mortar
  use hd_kinds, only: dp
  use hd_face, only: face_t
  use hd_vector, only: many
  use hd_segment, only: point_t, bins_t, new_bins, integrate_overlaps
  implicit none
  private
  public :: mortar_t, new_mortar, add_rigid, moved_share, relative_displacement, side_sums, add_nodal_forces, coupling_block, &
    radial_force, facet_mean

  !> Multiplier j couples nodes col(ptr(j):ptr(j+1)-1) with weights val: positive on the master, negative on the slave.
  type :: mortar_t
    integer :: n = 0                           !< multipliers
    integer :: rigid = 0                       !< the last of them: nodes that meet a rigid surface, without friction
    integer, allocatable :: node(:)            !< slave node of each multiplier
    real(dp), allocatable :: area(:)           !< a_j, 0 where no master facet lies opposite [m^2]
    integer, allocatable :: ptr(:), col(:)     !< rows by multiplier, columns are nodes
    real(dp), allocatable :: val(:)            !< weights
    integer, allocatable :: met(:), first(:)   !< nodes with a weight, and where each begins in
    integer, allocatable :: by(:), entry(:)    !< multipliers and entries in the order of the nodes
    integer, allocatable :: facet(:, :)        !< multipliers at the corners of each slave facet (4, facets)
    real(dp), allocatable :: share(:, :)       !< int phi_j dA over the facet (4, facets) [m^2]
    integer :: slave_nodes = 0                 !< nodes above this number are the master's; matters for turned frames only
    integer :: serial = 0                      !< counts how often the faces were paired anew
    integer :: pattern = 0                     !< serial of the first of couplings with the same ptr and col
    real(dp), allocatable :: turn(:, :, :)     !< from the dofs of the slave to the frame of the multiplier; unallocated: the same
    real(dp), allocatable :: carry(:, :, :)    !< from those of the master (3, 3, multipliers)
    real(dp), allocatable :: offset(:, :)      !< part of the relative position that is not of displacements (3, multipliers) [m]
    real(dp), allocatable :: shift(:, :)       !< way on the chart to the opposite (2, multipliers but for the rigid) [m]
  end type mortar_t

  integer, parameter :: batch = 1024   !< facets whose overlaps are found together

  !> Overlaps of a facet.
  type :: overlaps_t
    type(point_t), allocatable :: points(:)  !< room for them
    integer :: n = 0                         !< how many
  end type overlaps_t

contains

  !> Couple two faces; their node numbers belong to one common numbering.
  subroutine new_mortar(slave, master, mortar, shift, sectors)
    type(face_t), intent(in) :: slave      !< face that carries the multipliers
    type(face_t), intent(in) :: master     !< the other face
    type(mortar_t), intent(out) :: mortar  !< coupling
    real(dp), intent(in), optional :: shift(:, :)  !< way on the chart from each multiplier to its opposite (2, multipliers) [m]
    integer, intent(in), optional :: sectors       !< of both faces: the overlaps of the first are those of all, to rounding
    type(point_t), allocatable :: points(:)
    type(overlaps_t) :: found(batch)
    type(face_t) :: moved
    type(bins_t) :: bins
    integer, allocatable :: row(:), col(:)
    real(dp), allocatable :: val(:)
    real(dp) :: dual(4, 4), phi(4), near(8, 4), far(8, 4)
    integer :: at, away, f, k, n, p, period, nnz
    call number_multipliers(slave, mortar)
    moved = slave
    if (present(shift)) moved%chart = slave%chart + reshape(shift(:, [mortar%facet]), shape(slave%chart))
    call new_bins(master, bins)
    allocate (mortar%share(4, size(slave%nodes, 2)), source=0._dp)
    n = 48*size(slave%nodes, 2)  ! where facets meet two others
    allocate (row(n), col(n), val(n))
    nnz = 0
    period = size(slave%nodes, 2)
    if (present(sectors)) then
      if (period <= batch*sectors) period = period/sectors
    end if
    do f = 1, size(slave%nodes, 2)
      at = modulo(modulo(f - 1, period), batch) + 1
      away = (f - 1)/period*(size(master%nodes, 2)/(size(slave%nodes, 2)/period))
      if (at == 1 .and. f <= period) call find_overlaps(moved, f, period, master, bins, present(shift), found)
      n = found(at)%n
      if (n == 0) cycle
      call move_alloc(found(at)%points, points)
      if (present(shift)) points(:n)%weight = points(:n)%weight*(quad_area(slave%chart(:, :, f))/quad_area(moved%chart(:, :, f)))
      dual = dual_basis(points(:n))
      near = 0
      far = 0
      do p = 1, n
        phi = matmul(dual, points(p)%corner)*points(p)%weight
        mortar%share(:, f) = mortar%share(:, f) + phi
        do k = 1, 4
          near(:4, k) = near(:4, k) - phi(k)*points(p)%slave(:4)  ! lengths that are known make vectors
          far(:4, k) = far(:4, k) + phi(k)*points(p)%master(:4)
          if (size(slave%nodes, 1) > 4) near(5:, k) = near(5:, k) - phi(k)*points(p)%slave(5:)
          if (size(master%nodes, 1) > 4) far(5:, k) = far(5:, k) + phi(k)*points(p)%master(5:)
        end do
        if (p < n) then
          if (points(p + 1)%facet == points(p)%facet) cycle
        end if
        do k = 1, 4
          call append(mortar%facet(k, f), master%nodes(:, modulo(points(p)%facet + away - 1, size(master%nodes, 2)) + 1), far(:, k))
        end do
        far = 0
      end do
      do k = 1, 4
        call append(mortar%facet(k, f), slave%nodes(:, f), near(:, k))
      end do
      call move_alloc(points, found(at)%points)  ! room for the next batch
    end do
    call compress(mortar, row(:nnz), col(:nnz), val(:nnz))
  contains
    !> Append entries of one row to the growing coordinate list.
    subroutine append(multiplier, nodes, values)
      integer, intent(in) :: multiplier       !< row
      integer, intent(in) :: nodes(:)         !< columns
      real(dp), intent(in) :: values(:)       !< entries, at least size(nodes)
      integer :: n, room
      n = size(nodes)
      if (nnz + n > size(row)) then
        room = nnz + n + 1000
        row = [row, spread(0, 1, room)]
        col = [col, spread(0, 1, room)]
        val = [val, spread(0._dp, 1, room)]
      end if
      row(nnz + 1:nnz + n) = multiplier
      col(nnz + 1:nnz + n) = nodes
      val(nnz + 1:nnz + n) = values(:n)
      nnz = nnz + n
    end subroutine append
  end subroutine new_mortar

  !> Overlaps of a batch of facets.
  subroutine find_overlaps(slave, first, last, master, bins, moved, found)
    type(face_t), intent(in) :: slave              !< slave face
    integer, intent(in) :: first, last             !< facet, and the last of all batches
    type(face_t), intent(in) :: master             !< master face
    type(bins_t), intent(in) :: bins               !< of it
    logical, intent(in) :: moved                   !< as integrate_overlaps takes it
    type(overlaps_t), intent(inout) :: found(batch)  !< of the facets from the first one on
    integer :: k
    !$omp parallel do schedule(dynamic, 16) if(size(slave%nodes, 2) > batch)
    do k = 1, min(batch, last - first + 1)
      if (.not. allocated(found(k)%points)) allocate (found(k)%points(0))
      call integrate_overlaps(slave, first + k - 1, master, bins, moved, found(k)%points, found(k)%n)
    end do
    !$omp end parallel do
  end subroutine find_overlaps

  !> Area of a quadrilateral.
  pure real(dp) function quad_area(c) result(a)
    real(dp), intent(in) :: c(2, 4)  !< corners [m]
    a = 0.5_dp*((c(1, 3) - c(1, 1))*(c(2, 4) - c(2, 2)) - (c(2, 3) - c(2, 1))*(c(1, 4) - c(1, 2)))
  end function quad_area

  !> Let the nodes of a face of trilinear cells meet a rigid surface behind it: w is their displacement against it.
  subroutine add_rigid(mortar, face)
    type(mortar_t), intent(inout) :: mortar  !< complete coupling of the deformable faces
    type(face_t), intent(in) :: face         !< face whose outward normal is the opposite of the first dof
    integer, allocatable :: number(:)
    real(dp), allocatable :: area(:)
    integer :: f, k, a
    allocate (number(maxval(face%nodes)), source=0)
    allocate (area(0))
    do f = 1, size(face%nodes, 2)
      do k = 1, 4
        a = face%nodes(k, f)
        if (number(a) == 0) then
          area = [area, 0._dp]
          number(a) = size(area)
          mortar%node = [mortar%node, a]
        end if
        area(number(a)) = area(number(a)) + product(face%chart(:, 3, f) - face%chart(:, 1, f))/4
      end do
    end do
    mortar%rigid = size(area)
    mortar%ptr = [mortar%ptr, (mortar%ptr(mortar%n + 1) + k, k=1, mortar%rigid)]
    mortar%col = [mortar%col, mortar%node(mortar%n + 1:)]
    mortar%val = [mortar%val, spread(1._dp, 1, mortar%rigid)]
    mortar%area = [mortar%area, area]
    mortar%n = mortar%n + mortar%rigid
    call sort_entries(mortar)
  end subroutine add_rigid

  !> Part of the weights that couplings of the same faces have at different nodes: 0 equal, 1 no node in common.
  pure real(dp) function moved_share(a, b) result(share)
    type(mortar_t), intent(in) :: a, b   !< couplings
    real(dp) :: whole, alike
    integer :: i, j, k
    whole = 0
    alike = 0
    do j = 1, b%n
      do k = b%ptr(j), b%ptr(j + 1) - 1
        i = findloc(a%col(a%ptr(j):a%ptr(j + 1) - 1), b%col(k), 1)
        whole = whole + abs(b%val(k))
        if (i > 0) alike = alike + min(abs(b%val(k)), abs(a%val(a%ptr(j) + i - 1)))
      end do
    end do
    share = 1 - alike/max(whole, tiny(1._dp))
  end function moved_share

  !> Number the corner nodes of the slave face as multipliers, in the order in which the facets meet them.
  subroutine number_multipliers(slave, mortar)
    type(face_t), intent(in) :: slave        !< slave face
    type(mortar_t), intent(inout) :: mortar  !< its multipliers
    integer, allocatable :: number(:)
    integer :: f, k, a
    allocate (number(maxval(slave%nodes)), source=0)
    allocate (mortar%facet(4, size(slave%nodes, 2)), mortar%node(4*size(slave%nodes, 2)))
    do f = 1, size(slave%nodes, 2)
      do k = 1, 4
        a = slave%nodes(k, f)
        if (number(a) == 0) then
          mortar%n = mortar%n + 1
          number(a) = mortar%n
          mortar%node(mortar%n) = a
        end if
        mortar%facet(k, f) = number(a)
      end do
    end do
    mortar%node = mortar%node(:mortar%n)
  end subroutine number_multipliers

  !> Dual shape functions as combinations of the bilinear ones: rows of diag(int N) (int N N^T)^-1 over the covered part.
  pure function dual_basis(points) result(dual)
    type(point_t), intent(in) :: points(:)  !< integration points of the facet
    real(dp) :: dual(4, 4), mass(4, 4), a(4, 8), row(8)
    integer :: p, i, j
    mass = 0
    do p = 1, size(points)
      do j = 1, 4
        mass(:, j) = mass(:, j) + points(p)%weight*points(p)%corner*points(p)%corner(j)
      end do
    end do
    a = 0
    a(:, :4) = mass
    do i = 1, 4
      a(i, 4 + i) = 1
    end do
    do i = 1, 4
      j = i - 1 + maxloc(abs(a(i:, i)), 1)
      row = a(j, :)
      a(j, :) = a(i, :)
      a(i, :) = row/row(i)
      do j = 1, 4
        if (j /= i) a(j, :) = a(j, :) - a(j, i)*a(i, :)
      end do
    end do
    do i = 1, 4
      dual(i, :) = a(i, 5:)*sum(mass(i, :))
    end do
  end function dual_basis

  !> Sum equal entries and scale each row by 1 / a_j.
  subroutine compress(mortar, row, col, val)
    type(mortar_t), intent(inout) :: mortar  !< gets area, ptr, col, val
    integer, intent(in) :: row(:), col(:)    !< coordinate list
    real(dp), intent(in) :: val(:)
    integer, allocatable :: first(:), list(:), place(:), entry(:), last(:)  ! of each column: its entry in the row where it was last
    integer :: i, j, k, n
    allocate (mortar%area(mortar%n), mortar%ptr(mortar%n + 1), mortar%col(size(row)), mortar%val(size(row)))
    mortar%area = 0
    do i = 1, size(mortar%facet, 2)
      do k = 1, 4
        j = mortar%facet(k, i)
        mortar%area(j) = mortar%area(j) + mortar%share(k, i)
      end do
    end do
    allocate (first(mortar%n + 1), source=0)
    do i = 1, size(row)
      first(row(i) + 1) = first(row(i) + 1) + 1
    end do
    do j = 1, mortar%n
      first(j + 1) = first(j + 1) + first(j)
    end do
    list = first
    place = [(0, i=1, size(row))]
    do i = 1, size(row)
      list(row(i)) = list(row(i)) + 1
      place(list(row(i))) = i
    end do
    allocate (entry(maxval(col)), last(maxval(col)), source=0)
    n = 0
    do j = 1, mortar%n
      mortar%ptr(j) = n + 1
      do k = first(j) + 1, first(j + 1)
        i = col(place(k))
        if (last(i) /= j) then
          n = n + 1
          mortar%col(n) = i
          mortar%val(n) = 0
          entry(i) = n
          last(i) = j
        end if
        mortar%val(entry(i)) = mortar%val(entry(i)) + val(place(k))/mortar%area(j)
      end do
      call drop_rounding(mortar, j, n)
    end do
    mortar%ptr(mortar%n + 1) = n + 1
    mortar%col = mortar%col(:n)
    mortar%val = mortar%val(:n)
    call sort_entries(mortar)
  end subroutine compress

  !> Remove the entries of a row that are zero but for rounding (matching meshes couple node to node).
  subroutine drop_rounding(mortar, j, n)
    type(mortar_t), intent(inout) :: mortar  !< coupling
    integer, intent(in) :: j                 !< row
    integer, intent(inout) :: n              !< last entry of the row
    real(dp), parameter :: rounding = 1e-12_dp   !< of entries of the order 1, after cutting and integrating
    integer :: i, keep
    keep = mortar%ptr(j) - 1
    do i = mortar%ptr(j), n
      if (abs(mortar%val(i)) < rounding) cycle
      keep = keep + 1
      mortar%col(keep) = mortar%col(i)
      mortar%val(keep) = mortar%val(i)
    end do
    n = keep
  end subroutine drop_rounding

  !> Relative displacement w of the master against the slave at the multipliers.
  function relative_displacement(mortar, u) result(w)
    type(mortar_t), intent(in) :: mortar  !< coupling
    real(dp), intent(in) :: u(:, :)       !< displacements (3, nodes) [m]
    real(dp) :: w(3, mortar%n), sides(3, 2)
    integer :: j, k
    !$omp parallel do schedule(static) private(sides, k) if(size(mortar%val) > many/4)
    do j = 1, mortar%n
      w(:, j) = 0
      if (allocated(mortar%turn)) then
        sides = side_sums(mortar, mortar%slave_nodes, u, j)
        w(:, j) = matmul(mortar%turn(:, :, j), sides(:, 1)) + matmul(mortar%carry(:, :, j), sides(:, 2))
      else
        do k = mortar%ptr(j), mortar%ptr(j + 1) - 1
          w(:, j) = w(:, j) + mortar%val(k)*u(:, mortar%col(k))
        end do
      end if
    end do
    !$omp end parallel do
  end function relative_displacement

  !> Weighted sums over the nodes of a multiplier, those of the slave and of the master, each in the dofs of its nodes.
  pure function side_sums(mortar, slave_nodes, u, j) result(sides)
    type(mortar_t), intent(in) :: mortar  !< coupling
    integer, intent(in) :: slave_nodes    !< nodes above this number are the master's
    real(dp), intent(in) :: u(:, :)       !< nodal vectors (3, nodes)
    integer, intent(in) :: j              !< multiplier
    real(dp) :: sides(3, 2)
    integer :: b, k
    sides = 0
    do k = mortar%ptr(j), mortar%ptr(j + 1) - 1
      b = merge(2, 1, mortar%col(k) > slave_nodes)
      sides(:, b) = sides(:, b) + mortar%val(k)*u(:, mortar%col(k))
    end do
  end function side_sums

  !> Add the nodal forces of tractions given on the master [Pa], times a factor; the slave gets the opposite.
  subroutine add_nodal_forces(mortar, traction, f, factor)
    type(mortar_t), intent(in) :: mortar     !< coupling
    real(dp), intent(in) :: traction(:, :)   !< (3, multipliers) [Pa]
    real(dp), intent(inout) :: f(:, :)       !< nodal forces (3, nodes) [N]
    real(dp), intent(in), optional :: factor !< 1 if absent
    real(dp) :: force(3, mortar%n, 2), times, total(3)
    integer :: i, j, k, side
    if (mortar%n == 0) return
    times = 1
    if (present(factor)) times = factor
    !$omp parallel private(j, k, side, total) if(size(mortar%val) > many/4)
    !$omp do schedule(static)
    do j = 1, mortar%n
      force(:, j, 1) = times*mortar%area(j)*traction(:, j)
      if (.not. allocated(mortar%turn)) cycle
      force(:, j, 2) = matmul(force(:, j, 1), mortar%carry(:, :, j))
      force(:, j, 1) = matmul(force(:, j, 1), mortar%turn(:, :, j))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 1, size(mortar%met)
      side = merge(2, 1, allocated(mortar%turn) .and. mortar%met(i) > mortar%slave_nodes)
      total = 0
      do k = mortar%first(i), mortar%first(i + 1) - 1
        total = total + mortar%val(mortar%entry(k))*force(:, mortar%by(k), side)
      end do
      f(:, mortar%met(i)) = f(:, mortar%met(i)) + total
    end do
    !$omp end do
    !$omp end parallel
  end subroutine add_nodal_forces

  !> List the entries by their node, those of one node in the order of the multipliers.
  subroutine sort_entries(mortar)
    type(mortar_t), intent(inout) :: mortar  !< gets met, first, by, entry
    integer, allocatable :: last(:)
    integer :: i, j, k, n
    allocate (last(maxval(mortar%col)), source=0)
    do k = 1, size(mortar%col)
      last(mortar%col(k)) = last(mortar%col(k)) + 1
    end do
    mortar%met = pack([(i, i=1, size(last))], last > 0)
    mortar%first = [(1, i=1, size(mortar%met) + 1)]
    do i = 1, size(mortar%met)
      n = last(mortar%met(i))
      mortar%first(i + 1) = mortar%first(i) + n
      last(mortar%met(i)) = mortar%first(i)
    end do
    mortar%by = 0*mortar%col
    mortar%entry = 0*mortar%col
    do j = 1, mortar%n
      do k = mortar%ptr(j), mortar%ptr(j + 1) - 1
        i = mortar%col(k)
        mortar%by(last(i)) = j
        mortar%entry(last(i)) = k
        last(i) = last(i) + 1
      end do
    end do
  end subroutine sort_entries

  !> Block of the coupling between a multiplier and the node of its entry k: w_j = sum of blocks times displacements.
  pure function coupling_block(mortar, j, k) result(block)
    type(mortar_t), intent(in) :: mortar  !< coupling
    integer, intent(in) :: j, k           !< multiplier, entry
    real(dp) :: block(3, 3)
    integer :: i
    if (.not. allocated(mortar%turn)) then
      block = 0
      do i = 1, 3
        block(i, i) = mortar%val(k)
      end do
    else if (mortar%col(k) > mortar%slave_nodes) then
      block = mortar%val(k)*mortar%carry(:, :, j)
    else
      block = mortar%val(k)*mortar%turn(:, :, j)
    end if
  end function coupling_block

  !> Part of the tractions of the first multipliers along the first dof of one side, summed over their areas [N]. That of the nodal
  !> forces is the same if the weights of every multiplier add up to one.
  pure real(dp) function radial_force(mortar, traction, on_master, n) result(f)
    type(mortar_t), intent(in) :: mortar     !< coupling
    real(dp), intent(in) :: traction(:, :)   !< (3, multipliers) [Pa]
    logical, intent(in) :: on_master         !< side
    integer, intent(in) :: n                 !< multipliers that count
    integer :: j
    if (.not. allocated(mortar%turn)) then
      f = sum(mortar%area(:n)*traction(1, :n))
      return
    end if
    f = 0
    do j = 1, n
      f = f + mortar%area(j)*dot_product(traction(:, j), merge(mortar%carry(:, 1, j), mortar%turn(:, 1, j), on_master))
    end do
  end function radial_force

  !> Mean over a slave facet of a field known at the multipliers.
  pure real(dp) function facet_mean(mortar, f, corner) result(mean)
    type(mortar_t), intent(in) :: mortar   !< coupling
    integer, intent(in) :: f               !< facet
    real(dp), intent(in) :: corner(4)      !< the field at its multipliers
    real(dp) :: area
    area = sum(mortar%share(:, f))
    mean = 0
    if (area > 0) mean = dot_product(mortar%share(:, f), corner)/area
  end function facet_mean
end module hd_mortar
