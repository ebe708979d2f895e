! SPDX-License-Identifier: GPL-3.0-or-later
!> Von Mises stress of both bodies against their yield strengths: the largest at a node in any booked load step, for a drive must
!> stand its whole path, and a wall that is bent has its largest stress on its faces. What a formed flexspline keeps of being bent
!> to its shape is not among it.
module hd_strength
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use hd_kinds, only: dp
  use hd_drive, only: drive_t
  use hd_error, only: error_t
  use hd_fatigue, only: fatigue_t, judge_fatigue
  use hd_problem, only: state_t
  use hd_scene, only: scene_t
  use hd_stress, only: body_stress, largest_of, stress_matrices_t
  use hd_text, only: string_t, push, rounded, to_text
  implicit none
  private
  public :: strength_t, book_stress, strength_text, strength_warnings

  type :: strength_t
    real(dp) :: flexspline = 0   !< largest von Mises stress so far [Pa]
    real(dp) :: ring = 0         !< the same [Pa]
  contains
    procedure :: flexspline_safety
    procedure :: ring_safety
  end type strength_t

contains

  !> Stresses of a converged step; with them, of a whole drive, the flexspline's life.
  subroutine book_stress(strength, fatigue, matrices, scene, drive, state, torque, error)
    type(strength_t), intent(inout) :: strength       !< gets them
    type(fatigue_t), intent(inout) :: fatigue         !< of a whole drive
    type(stress_matrices_t), intent(inout) :: matrices(2)   !< of the bodies, made if there are none
    type(scene_t), intent(in) :: scene                !< limits
    type(drive_t), intent(in) :: drive                !< model
    type(state_t), intent(in) :: state                !< converged state
    real(dp), intent(in) :: torque                    !< of the step [N m]
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp), allocatable :: stress(:, :)
    integer :: b
    do b = 1, 2
      associate (body => drive%problem%bodies(b))
        allocate (stress(6, body%nodes()))
        call body_stress(drive%problem, b, state%u, matrices(b), error, stress)
        if (allocated(error)) return
        if (b == drive%b_ring) strength%ring = max(strength%ring, largest_of(stress))
        if (b == drive%b_cup) strength%flexspline = max(strength%flexspline, largest_of(stress))
        if (b == drive%b_cup .and. scene%support%loop) call judge_fatigue(scene, body, stress, torque, fatigue)
        deallocate (stress)
      end associate
    end do
  end subroutine book_stress

  !> Yield strength of the flexspline over its largest stress.
  pure real(dp) function flexspline_safety(self, scene) result(safety)
    class(strength_t), intent(in) :: self  !< stresses
    type(scene_t), intent(in) :: scene     !< yield strengths
    safety = strength_over(scene%yield_strength, self%flexspline)
  end function flexspline_safety

  !> Yield strength of the ring over its largest stress.
  pure real(dp) function ring_safety(self, scene) result(safety)
    class(strength_t), intent(in) :: self  !< stresses
    type(scene_t), intent(in) :: scene     !< yield strengths
    safety = strength_over(scene%ring_yield_strength, self%ring)
  end function ring_safety

  !> A strength over a stress; infinite where there is none.
  pure real(dp) function strength_over(limit, stress) result(safety)
    real(dp), intent(in) :: limit, stress  !< [Pa]
    safety = ieee_value(1._dp, ieee_positive_inf)
    if (stress > limit/huge(1._dp)) safety = limit/stress
  end function strength_over

  !> Stresses and safeties in a line.
  function strength_text(strength, scene) result(text)
    type(strength_t), intent(in) :: strength  !< stresses
    type(scene_t), intent(in) :: scene        !< yield strengths
    character(len=:), allocatable :: text
    text = 'largest von Mises stress '//rounded(strength%flexspline)//' Pa in the flexspline, safety against yield '// &
      rounded(strength%flexspline_safety(scene))//'; '//rounded(strength%ring)//' Pa in the ring, safety '// &
      rounded(strength%ring_safety(scene))
  end function strength_text

  !> Bodies that pass their yield strength.
  subroutine strength_warnings(strength, scene, lines)
    type(strength_t), intent(in) :: strength              !< stresses
    type(scene_t), intent(in) :: scene                    !< yield strengths
    type(string_t), allocatable, intent(out) :: lines(:)  !< one each
    allocate (lines(0))
    if (strength%flexspline > scene%yield_strength) call push(lines, 'the flexspline yields: its largest von Mises stress, '// &
      rounded(strength%flexspline)//' Pa, is above material.yield_strength = '//to_text(scene%yield_strength)//' Pa, and '// &
      'bodies are elastic here. Lower load.torque, wave_generator.w or the thickness of wall and rim, which are bent to the '// &
      'cam. At a sharp step of the wall it grows with a finer mesh; cup.sections_fillet rounds it')
    if (strength%ring > scene%ring_yield_strength) call push(lines, 'the ring yields: its largest von Mises stress, '// &
      rounded(strength%ring)//' Pa, is above material.ring_yield_strength = '//to_text(scene%ring_yield_strength)//' Pa, and '// &
      'bodies are elastic here. Lower load.torque, wave_generator.w or geometry.ring_thickness, which is bent to the cam')
  end subroutine strength_warnings
end module hd_strength
