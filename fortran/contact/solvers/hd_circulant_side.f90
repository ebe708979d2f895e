! SPDX-License-Identifier: GPL-3.0-or-later
!> Face of one revolved body (or of two, merged) as a block circulant: W C W^T, with C the compliance of its nodes by harmonics
!> and W the mortar weights of the multipliers.
module hd_circulant_side
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_fft, only: backward_real, execute_rows, free_rows, plan_rows, rows_plan_t
  use hd_harmonic_matrix, only: harmonic_matrix_t
  use hd_problem, only: problem_t
  use hd_vector, only: many
  implicit none
  private
  public :: circulant_side_t, collect_side, plan_side, fill_kernel, add_response, add_side_column, release_side, &
    line_up, fade_out

  !> What the layers of open points around the closed ones take of their neighbours' values before F^-1 of the whole face is
  !> applied. A field that breaks off where contact ends answers as stiffly as a plate that is bent along that edge.
  real(dp), parameter :: fade(2) = [0.7_dp, 0.5_dp]

  type :: circulant_side_t
    integer :: sectors = 0                          !< of the body
    integer, allocatable :: nodes(:)                !< face nodes of the first sector
    integer, allocatable :: ptr(:), row(:), sector(:)  !< weights by multiplier: face node, sector from 0
    real(dp), allocatable :: val(:)
    integer, allocatable :: fill(:), from(:), into(:)  !< the same by sector of one repetition: multiplier, face node
    real(dp), allocatable :: share(:)
    real(dp), allocatable :: angle(:)               !< their angles [rad]
    type(harmonic_matrix_t) :: hat                  !< compliance by harmonic 0:n/2 [m/N]
    real(dp), allocatable :: kernel(:, :, :)        !< the same by difference of sectors (3 nodes, 3 nodes, n/stride)
    real(dp), allocatable :: own(:, :, :)           !< block of each multiplier by itself (3, 3, multipliers) [m/N]
    real(dp), allocatable :: field(:, :)            !< workspace of apply (3 nodes, n/stride)
    complex(dp), allocatable :: wave(:, :)          !< (3 nodes, n/stride/2 + 1)
    type(rows_plan_t) :: forward, backward
  end type circulant_side_t

contains

  !> Face nodes of a body and the weights of the multipliers on them; without `hat`.
  subroutine collect_side(problem, b, side)
    type(problem_t), intent(in) :: problem  !< problem
    integer, intent(in) :: b                !< body
    type(circulant_side_t), intent(out) :: side       !< its face
    integer :: number(problem%bodies(b)%nodes_per_sector), first, i, j, k, m, n
    first = problem%first(b)
    m = problem%bodies(b)%nodes_per_sector
    side%sectors = problem%bodies(b)%sectors
    associate (mortar => problem%mortar)
      number = 0
      do k = 1, size(mortar%col)
        i = mortar%col(k) - first
        if (i > 0 .and. i <= m*side%sectors) number(modulo(i - 1, m) + 1) = 1
      end do
      side%nodes = pack([(i, i=1, m)], number > 0)
      side%angle = problem%bodies(b)%angle(side%nodes)
      number(side%nodes) = [(i, i=1, size(side%nodes))]
      allocate (side%ptr(mortar%n + 1), side%row(size(mortar%col)), side%sector(size(mortar%col)), side%val(size(mortar%col)))
      n = 0
      do j = 1, mortar%n
        side%ptr(j) = n + 1
        do k = mortar%ptr(j), mortar%ptr(j + 1) - 1
          i = mortar%col(k) - first
          if (i <= 0 .or. i > m*side%sectors) cycle
          n = n + 1
          side%row(n) = number(modulo(i - 1, m) + 1)
          side%sector(n) = (i - 1)/m
          side%val(n) = mortar%val(k)
        end do
      end do
      side%ptr(mortar%n + 1) = n + 1
    end associate
  end subroutine collect_side

  !> Workspace and plans, and the compliance of each multiplier by itself.
  subroutine plan_side(side, stride, first, error)
    type(circulant_side_t), intent(inout) :: side     !< face
    integer, intent(in) :: stride                     !< 1 or 2
    logical, intent(in) :: first(:)                   !< multipliers of the first repetition (multipliers)
    type(error_t), allocatable, intent(out) :: error  !< memory
    real(dp), allocatable :: near(:, :, :)            ! between sectors of one multiplier (3 nodes, 3 nodes, -reach:reach)
    integer :: d, j, m, n, reach
    n = side%sectors/stride
    m = side%hat%n
    reach = 0
    do j = 1, size(side%ptr) - 1
      associate (sector => side%sector(side%ptr(j):side%ptr(j + 1) - 1))
        if (size(sector) > 0) reach = max(reach, maxval(abs(short_way(sector - sector(1), side%sectors))))
      end associate
    end do
    reach = 2*reach
    allocate (side%field(m, n), side%wave(m, n/2 + 1), near(m, m, -reach:reach), side%own(3, 3, size(side%ptr) - 1))
    do d = 0, reach
      near(:, :, d) = side%hat%kernel(stride, n, d)
      near(:, :, -d) = transpose(near(:, :, d))
    end do
    do j = 1, size(side%ptr) - 1
      side%own(:, :, j) = side_block(side, near, reach, j)
    end do
    call sort_weights(side, n, first)
    call plan_rows(n, m, side%field, side%wave, side%forward, side%backward, error)
  end subroutine plan_side

  !> Weights by the sector of their node, those of one node in the order of the multipliers.
  pure subroutine sort_weights(side, n, first)
    type(circulant_side_t), intent(inout) :: side  !< gets fill, from, into, share
    integer, intent(in) :: n                       !< sectors of one repetition
    logical, intent(in) :: first(:)                !< multipliers of the first repetition (multipliers)
    integer :: last(0:n), j, k, s
    last = 0
    do j = 1, size(first)
      if (.not. first(j)) cycle
      do k = side%ptr(j), side%ptr(j + 1) - 1
        s = modulo(side%sector(k), n) + 1
        last(s) = last(s) + 1
      end do
    end do
    side%fill = [1, (1 + sum(last(:s)), s=1, n)]
    last(1:) = side%fill(:n)
    if (allocated(side%from)) deallocate (side%from, side%into, side%share)
    allocate (side%from(side%fill(n + 1) - 1), side%into(side%fill(n + 1) - 1), side%share(side%fill(n + 1) - 1))
    do j = 1, size(first)
      if (.not. first(j)) cycle
      do k = side%ptr(j), side%ptr(j + 1) - 1
        s = modulo(side%sector(k), n) + 1
        side%from(last(s)) = j
        side%into(last(s)) = side%row(k)
        side%share(last(s)) = side%val(k)
        last(s) = last(s) + 1
      end do
    end do
  end subroutine sort_weights

  !> Difference of sectors the short way round.
  elemental integer function short_way(difference, sectors)
    integer, intent(in) :: difference, sectors
    short_way = modulo(difference + sectors/2, sectors) - sectors/2
  end function short_way

  !> Compliance between all sectors.
  subroutine fill_kernel(side, stride, error)
    type(circulant_side_t), intent(inout) :: side               !< planned
    integer, intent(in) :: stride                     !< 1 or 2
    type(error_t), allocatable, intent(out) :: error  !< memory
    complex(dp), allocatable :: wave(:, :)
    real(dp), allocatable :: column(:, :)
    integer :: j, k, m, n
    if (allocated(side%kernel)) return
    n = size(side%field, 2)
    m = side%hat%n
    allocate (side%kernel(m, m, n), wave(n/2 + 1, m), column(n, m))
    do k = 0, n/2
      side%kernel(:, :, k + 1) = side%hat%full(k*stride)/n
    end do
    do j = 1, m
      do k = 0, n/2
        associate (factor => side%hat%factor(:, k*stride))
          wave(k + 1, :) = side%kernel(:, j, k + 1)*factor*conjg(factor(j))
        end associate
      end do
      call backward_real(wave, column, error)
      if (allocated(error)) return
      side%kernel(:, j, :) = transpose(column)
    end do
  end subroutine fill_kernel

  !> W C W^T f, or add it.
  subroutine add_response(side, stride, single, adds, f, w)
    type(circulant_side_t), intent(inout) :: side    !< planned
    integer, intent(in) :: stride          !< 1 or 2
    logical, intent(in) :: single          !< single precision is enough
    logical, intent(in) :: adds            !< w has something already
    real(dp), intent(in) :: f(:, :)        !< forces (3, multipliers) [N]
    real(dp), intent(inout) :: w(:, :)     !< relative displacements (3, multipliers) [m]
    real(dp) :: sums(3)
    integer :: c, j, k, n, s
    n = size(side%field, 2)
    !$omp parallel do schedule(static) private(c, k) if(size(side%field) > many/4)
    do s = 1, n
      side%field(:, s) = 0
      do k = side%fill(s), side%fill(s + 1) - 1
        do c = 1, 3
          associate (at => 3*side%into(k) - 3 + c)
            side%field(at, s) = side%field(at, s) + side%share(k)*f(c, side%from(k))
          end associate
        end do
      end do
    end do
    !$omp end parallel do
    call execute_rows(side%forward, n, side%field, side%wave, .true.)
    call side%hat%multiply(stride, side%wave, single)
    call execute_rows(side%backward, n, side%field, side%wave, .false.)
    !$omp parallel do schedule(static) private(sums, c, k, s) if(size(side%field) > many/4)
    do j = 1, size(f, 2)
      sums = 0
      do k = side%ptr(j), side%ptr(j + 1) - 1
        s = modulo(side%sector(k), n) + 1
        do c = 1, 3
          sums(c) = sums(c) + side%val(k)*side%field(3*side%row(k) - 3 + c, s)
        end do
      end do
      if (adds) then
        w(:, j) = w(:, j) + sums/n
      else
        w(:, j) = sums/n
      end if
    end do
    !$omp end parallel do
  end subroutine add_response

  !> Add the blocks F(list, j) diag(sign) to a column of blocks.
  subroutine add_side_column(side, j, sign, list, column)
    type(circulant_side_t), intent(in) :: side               !< with its kernel
    integer, intent(in) :: j                       !< multiplier that is loaded
    real(dp), intent(in) :: sign(3)                !< signs of its components
    integer, intent(in) :: list(:)                 !< multipliers that are looked at
    real(dp), intent(inout) :: column(:, :, :)     !< (3, 3, list) [m/N]
    integer :: c, d, i, k, l
    real(dp) :: v(3)
    do l = side%ptr(j), side%ptr(j + 1) - 1
      do i = 1, size(list)
        do k = side%ptr(list(i)), side%ptr(list(i) + 1) - 1
          d = modulo(side%sector(k) - side%sector(l), size(side%kernel, 3)) + 1
          do c = 1, 3
            v = side%kernel(3*side%row(k) - 2:3*side%row(k), 3*side%row(l) - 3 + c, d)
            column(:, c, i) = column(:, c, i) + side%val(k)*side%val(l)*sign(c)*v
          end do
        end do
      end do
    end do
  end subroutine add_side_column

  !> Block F(j, j).
  pure function side_block(side, near, reach, j) result(block)
    type(circulant_side_t), intent(in) :: side  !< face
    integer, intent(in) :: reach      !< farthest sectors of a multiplier
    real(dp), intent(in) :: near(:, :, -reach:)  !< compliance by difference of sectors [m/N]
    integer, intent(in) :: j          !< multiplier
    real(dp) :: block(3, 3)           !< [m/N]
    integer :: d, k, l
    block = 0
    do l = side%ptr(j), side%ptr(j + 1) - 1
      do k = side%ptr(j), side%ptr(j + 1) - 1
        d = short_way(side%sector(k) - side%sector(l), side%sectors)
        block = block + side%val(k)*side%val(l)*near(3*side%row(k) - 2:3*side%row(k), 3*side%row(l) - 2:3*side%row(l), d)
      end do
    end do
  end function side_block

  !> Give back plans and what they work on.
  subroutine release_side(side)
    type(circulant_side_t), intent(inout) :: side  !< planned
    call free_rows(side%forward)
    call free_rows(side%backward)
    if (allocated(side%field)) deallocate (side%field, side%wave, side%own)
    if (allocated(side%kernel)) deallocate (side%kernel)
  end subroutine release_side

  !> Enter which rows of a face follow each other along the axis.
  pure subroutine line_up(row, beside)
    integer, intent(in) :: row(:)             !< of the multipliers of a face
    integer, intent(inout) :: beside(:, :)    !< gets their rows (2, rows)
    integer :: i, before
    before = 0
    do i = 1, size(beside, 2)
      if (.not. any(row == i)) cycle
      beside(1, i) = before
      if (before > 0) beside(2, before) = i
      before = i
    end do
  end subroutine line_up

  !> Two layers of open points around the closed ones; each takes the mean of its neighbours in the layer before: entry e adds
  !> weight(e) times the value at from(e) to point at(e).
  subroutine fade_out(row, sector, beside, sectors, closed, at, from, weight)
    integer, intent(in) :: row(:), sector(:)      !< places of the points, sectors from 0
    integer, intent(in) :: beside(:, :)           !< of line_up (2, rows)
    integer, intent(in) :: sectors                !< after which fields repeat; points beyond them are left out
    logical, intent(in) :: closed(:)              !< (points)
    integer, allocatable, intent(out) :: at(:), from(:)
    real(dp), allocatable, intent(out) :: weight(:)
    integer :: place(0:size(beside, 2), 0:sectors - 1), layer(0:size(closed)), near(4)
    integer :: j, k, l, m
    place = 0
    do j = 1, size(closed)
      if (sector(j) < sectors) place(row(j), sector(j)) = j
    end do
    layer = -1
    where (closed) layer(1:) = 0
    allocate (at(4*size(closed)), from(4*size(closed)), weight(4*size(closed)))
    m = 0
    do l = 1, size(fade)
      do j = 1, size(closed)
        if (layer(j) >= 0 .or. sector(j) >= sectors) cycle
        near = [place(beside(:, row(j)), sector(j)), place(row(j), modulo(sector(j) - 1, sectors)), &
          place(row(j), modulo(sector(j) + 1, sectors))]
        near = pack(near, layer(near) == l - 1, [0, 0, 0, 0])
        k = count(near > 0)
        if (k == 0) cycle
        layer(j) = l
        at(m + 1:m + k) = j
        from(m + 1:m + k) = near(:k)
        weight(m + 1:m + k) = fade(l)/k
        m = m + k
      end do
    end do
    at = at(:m)
    from = from(:m)
    weight = weight(:m)
  end subroutine fade_out
end module hd_circulant_side
