! SPDX-License-Identifier: GPL-3.0-or-later
!> What a planned tolerance covers, and what the model leaves out whatever the mesh, with sizes where they are known.
module hd_model_error
  use hd_kinds, only: dp
  use hd_facets, only: sums_t
  use hd_promises, only: promise_t, promises, promises_of
  use hd_scene, only: scene_t
  use hd_strength, only: strength_t, strength_text
  use hd_text, only: string_t, percent, push, to_text
  use hd_persson_error, only: theory_error_t, in_words, steep
  implicit none
  private
  public :: covered, left_out

contains

  !> Quantities that the planned tolerance covers, by their names in the summary; none without a plan.
  pure function covered(scene, planned, limit) result(list)
    type(scene_t), intent(in) :: scene  !< scene
    logical, intent(in) :: planned      !< the mesh was planned, and something is known of its error
    real(dp), intent(in) :: limit(:)    !< limits that are promised (values), 0: nothing is
    type(string_t), allocatable :: list(:)
    type(promise_t) :: promised(promises)
    integer :: i
    allocate (list(0))
    promised = promises_of(scene)
    do i = 1, promises
      if (planned .and. any(abs(limit(promised(i)%first:promised(i)%last)) > 0)) call push(list, trim(promised(i)%column))
    end do
  end function covered

  !> What no mesh mends.
  function left_out(scene, sums, strength) result(list)
    type(scene_t), intent(in) :: scene  !< scene
    type(sums_t), intent(in) :: sums    !< of the step that the results are of
    type(strength_t), intent(in) :: strength  !< of all steps
    type(string_t), allocatable :: list(:)
    allocate (list(0))
    if (scene%support%contact) call add_contact(scene, sums, list)
    if (.not. scene%large() .and. scene%w > 0) call push(list, 'second order of the cam: w^2/r = '// &
      to_text(scene%w**2/(scene%bore_radius - scene%ring_thickness))//' m beside '// &
      trim(merge('a clearance of    ', 'an interference of', scene%clearance > 0))//' '// &
      to_text(merge(scene%clearance, scene%interference, scene%clearance > 0))//" m; solver.kinematics = 'nonlinear' has it")
    if (scene%support%struts) then
      call push(list, 'gear: no friction of '//trim(merge('balls and cage        ', 'flanks, balls and cage', &
        scene%tooth_friction > 0))//', no tooth tips, the toothed rim as a smooth one; K1 to K3 are 0.76 to 1.1 times the '// &
        'catalogue''s from size 17 to 40 at ratio 100, 0.5 to 1.65 times in other shipped drives (docs/evidence/drive.md)')
    else
      if (.not. scene%ball_stiffness > 0) call push(list, 'wave generator rigid: balls of 6 N/um each add 42 % to the '// &
        'flexibility of a size 14 cup against its teeth (wave_generator.ball_stiffness has them)')
      call push(list, 'gear: no play, no friction between teeth, the toothed rim as a smooth one')
    end if
    call push(list, 'bodies elastic: '//strength_text(strength, scene)//'; peak pressure '// &
      trim(merge('above', 'below', sums%pressure_max > scene%yield_strength))//' that of the flexspline. At edges stresses '// &
      'grow with a finer mesh; bodies_*.vtu has them all')
  end function left_out

  !> What concerns the contact and its joint.
  subroutine add_contact(scene, sums, list)
    type(scene_t), intent(in) :: scene                       !< scene
    type(sums_t), intent(in) :: sums                         !< of the last step
    type(string_t), allocatable, intent(inout) :: list(:)    !< grows
    if (sums%k_tangent > 0) call push(list, 'reading of K_TS: Eq. 45 gives '//to_text(sums%k_ts/sums%k_tangent)// &
      ' times the tangent that a test would measure, and '//percent(sums%slip_k_ts)//' of it lies on points that slip')
    if (sums%theory%area > 0) call push(list, theory_text(scene, sums%theory))
    if (scene%hard() .and. scene%support%struts) then
      call push(list, 'contact law hard: the joint evens out no pressure, and K_TS alone has its compliance; of size 14 '// &
        'contact.law = ''joint'' has K1, K2 and K3 5, 2 and 1 % lower, K_TS 7 % higher, 17 % at 3 N m')
    else if (scene%hard()) then
      call push(list, 'contact law hard: the joint evens out no pressure; CD-14-100: tangent '// &
        'and secant K_TS within 5 % of those with contact.law = ''joint''')
    end if
    call push(list, 'joint inputs, over seven joints of Hu et al. on CD-14-100: K_TS by Eq. 45 from 0.8 to 15 MN m/rad, its '// &
      'tangent from 0.38 to 0.47 (docs/evidence/inputs.md)')
    if (abs(scene%torque) > 0 .and. abs(sums%friction_torque) > 0 .and. .not. scene%support%struts) call push(list, &
      'load path: the contact passes '//percent(abs(sums%friction_torque/scene%torque))//' of the torque on to the ring; '// &
      'that of a real drive, which turns on balls, takes about the torque over the ratio')
    if (scene%ring_divisions > 0 .or. scene%ring_facets > 0) call push(list, 'meshes that do not match: contact.slave ring '// &
      'or cup moves K_TS by Eq. 45 by 8 % at 48 divisions, 3 % at 96, 2 % at 144')
  end subroutine add_contact

  !> The error of a joint by theory, on what carries the readings of K_TS.
  function theory_text(scene, theory) result(text)
    type(scene_t), intent(in) :: scene            !< scene
    type(theory_error_t), intent(in) :: theory    !< its error
    character(len=:), allocatable :: text
    text = 'joint: '//in_words(theory)
    if (abs(theory%tangent) > 0) text = text//'; '//trim(merge('half of it  ', 'so much less', theory%steepness > steep))// &
      ' lowers K_TS by Eq. 45 as much, and changes its tangent by '//trim(merge('-', '+', theory%tangent < 0))// &
      percent(abs(theory%tangent))
    if (len_trim(scene%joint_spectrum) > 0) text = text//'; a lay, skewed heights and the sampling of the spectrum are not in '// &
      'it: joint.json of hdengine joint has them'
  end function theory_text
end module hd_model_error
