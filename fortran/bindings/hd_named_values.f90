! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists of numbers whose places have names: the names stand here alone, parted by commas, and Python asks for them. A name that
!> its list does not hold is an internal error.
module hd_named_values
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_promises, only: promise_names
  use hd_error, only: error_t, raise, code_internal
  use hd_facets, only: sum_names, facet_names
  use hd_loop_results, only: loop_names
  use hd_support, only: supports_where
  implicit none
  private
  public :: names_of, named_list_t

  !> Material and surface of a joint; flags are 0 or 1. `paper`: closure of Eq. 28; `plastic`: plastic spots unload elastically.
  character(len=*), parameter :: joint_names = 'e1,nu1,e2,nu2,nu_soft,hardness,fractal_dimension,roughness,gamma,'// &
    'asperity_radius,friction,s_min,reference_area,paper,plastic'
  !> One asperity.
  character(len=*), parameter :: asperity_names = 'e_star_pa,g_prime_pa,hardness_pa,hardness_factor,amplitude_m,'// &
    'radius_m,eps_ec_m,s_ec_m2,f_ec_n'
  !> A load step.
  character(len=*), parameter :: step_names = 'step,in_torque,load_factor,torque_nm,'//sum_names//',iterations,seconds'
  !> How to fit a surface: window [points], flags, what is known of Eq. 1, band [1/m], noise [m].
  character(len=*), parameter :: fit_option_names = 'first_lag,last_lag,level,model,fit_noise,ridges,'// &
    'n_max,told,mask,f_lo,f_hi,gamma,length,noise'
  !> What a fit gives: numbers; curves over the lag; curves over the frequency.
  character(len=*), parameter :: fit_names = 'd,ln_g,noise_variance,cov_1,cov_2,cov_3,cov_4,cov_5,cov_6,cov_7,cov_8,'// &
    'cov_9,rms,rms_expected,misfit,chi2,freedom,tilt_x,tilt_y,verdict,size,d_error,ln_g_error,d_low,d_high,ln_g_low,ln_g_high,'// &
    'd_low_sampling,d_high_sampling,ln_g_low_sampling,ln_g_high_sampling,of_spectrum,spikes,holes,probe,fold,f_lo,f_hi,'// &
    'axis_x,axis_y,range_d_1,range_low_1,range_high_1,range_d_2,range_low_2,range_high_2,seams_x,seams_y,seam_step,'// &
    'jitter_x,jitter_y,wrong_from,clumps_from,anisotropy'
  character(len=*), parameter :: fit_curve_names = 'tau,s,model,model_error,sample_error'
  character(len=*), parameter :: fit_ring_names = 'frequency,power,modes,model'

  !> The names of a list, and the first one asked for that it does not hold.
  type :: named_list_t
    character(len=:), allocatable :: list, unknown
  contains
    procedure :: place
    procedure :: take
    procedure :: put
    procedure :: check
  end type named_list_t

contains

  !> The names of a list; empty where there is no such list.
  pure function names_of(list) result(names)
    character(len=*), intent(in) :: list   !< which
    character(len=:), allocatable :: names
    select case (list)
    case ('joint'); names = joint_names
    case ('asperity'); names = asperity_names
    case ('step'); names = step_names
    case ('facet'); names = facet_names
    case ('loop'); names = loop_names()
    case ('fit_options'); names = fit_option_names
    case ('fit'); names = fit_names
    case ('fit_curves'); names = fit_curve_names
    case ('fit_rings'); names = fit_ring_names
    case ('promise_columns', 'promise_names', 'promise_words', 'promise_units'); names = promise_names(list(len('promise_') + 1:))
    case default
      names = ''
      if (index(list, 'support_') == 1) names = supports_where(list(len('support_') + 1:))
    end select
  end function names_of

  !> Place of a name; 0, and kept for `check`, where the list does not hold it.
  integer function place(self, name) result(i)
    class(named_list_t), intent(inout) :: self   !< list
    character(len=*), intent(in) :: name         !< wanted
    character(len=:), allocatable :: names
    names = ','//names_of(self%list)//','
    i = count_commas(names(:index(names, ','//name//',')))
    if (i == 0 .and. .not. allocated(self%unknown)) self%unknown = name
  end function place

  !> Value of a name; NaN where the list does not hold it.
  real(dp) function take(self, values, name)
    class(named_list_t), intent(inout) :: self   !< list
    real(dp), intent(in) :: values(:)            !< in its order
    character(len=*), intent(in) :: name         !< wanted
    integer :: i
    take = ieee_value(1._dp, ieee_quiet_nan)
    i = self%place(name)
    if (i > 0 .and. i <= size(values)) take = values(i)
  end function take

  !> Set the value of a name.
  subroutine put(self, values, name, x)
    class(named_list_t), intent(inout) :: self   !< list
    real(dp), intent(inout) :: values(:)         !< in its order
    character(len=*), intent(in) :: name         !< where
    real(dp), intent(in) :: x                    !< value
    integer :: i
    i = self%place(name)
    if (i > 0 .and. i <= size(values)) values(i) = x
  end subroutine put

  !> Raise the error of a name that the list does not hold.
  subroutine check(self, error)
    class(named_list_t), intent(in) :: self             !< list
    type(error_t), allocatable, intent(inout) :: error  !< unknown name; an earlier error stays
    if (allocated(self%unknown) .and. .not. allocated(error)) call raise(error, code_internal, &
      "the list '"//self%list//"' holds no '"//self%unknown//"'")
  end subroutine check

  !> Commas in a text.
  pure integer function count_commas(text) result(n)
    character(len=*), intent(in) :: text   !< text
    integer :: i
    n = count([(text(i:i) == ',', i=1, len(text))])
  end function count_commas
end module hd_named_values
