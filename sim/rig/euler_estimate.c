#include "rig/euler_estimate.h"

#include <math.h>

#include "support/units.h"

// A value that has diverged beyond this becomes NaN, because a float may not hold it.
#define DIVERGED 1.0e9

bool euler_estimate_wanted(const rig_config_t *config) {
    return config->emf >= RIG_EMF_C_EULER;
}

euler_config_t euler_estimate_gains(const rig_config_t *config) {
    const lode_motor_t *motor = &config->drive.motor;
    const lode_estimator_config_t *estimator = &config->drive.estimator;
    const double w0 = (double)estimator->emf.w0_rad_s;
    return (euler_config_t){
        .ts_s = 1.0 / (double)config->drive.f_pwm_Hz,
        .sets = (double)motor->sets,
        .pole_pairs = (double)motor->pole_pairs,
        .Rs_Ohm = (double)motor->Rs_Ohm,
        .Ld_H = (double)motor->Ld_H,
        .Lq_H = (double)motor->Lq_H,
        .psi_Wb = (double)motor->psi_Wb,
        .J_kgm2 = (double)motor->J_kgm2,
        .B_Nms = (double)motor->B_Nms,
        .w0_rad_s = w0,
        .gi_Kr = (double)estimator->emf.gi_kappa * w0 * w0,
        .gi_wc_rad_s = (double)estimator->emf.gi_wc_rad_s,
        .k1_rad2_s2 = (double)estimator->emf.k1_rad2_s2,
        .k2_rad_s = (double)estimator->emf.k2_rad_s,
        .sigma_rad_s = (double)estimator->pll.sigma_rad_s,
        .notch_k = (double)estimator->notch_k,
    };
}

euler_config_t euler_estimate_config(const rig_config_t *config) {
    static const euler_emf_t emf[] = {EULER_C_LESO, EULER_GI_LESO, EULER_FA_LESO};
    static const euler_pll_t pll[] = {EULER_LESO_QPLL, EULER_QPLL, EULER_ENHANCED};
    static const euler_lag_t lag[] = {EULER_LAG_EXACT, EULER_LAG_NONE, EULER_LAG_EQ30};
    euler_config_t out = euler_estimate_gains(config);
    out.emf = emf[config->emf - RIG_EMF_C_EULER];
    out.pll = pll[config->pll - RIG_PLL_LESO_EULER];
    out.compensation = lag[config->compensation - RIG_COMPENSATION_EXACT];
    out.speed_of_eq14 = config->speed_of_eq14;
    out.continuous = config->continuous;
    return out;
}

static float narrow(double value) {
    return fabs(value) < DIVERGED ? (float)value : NAN;
}

static double complex vector(lode_ab_t x) {
    return (double)x.alpha + I * (double)x.beta;
}

lode_estimate_t euler_estimate_step(euler_t *self, const euler_config_t *config, lode_ab_t u_V,
                                    lode_ab_t i_A) {
    const euler_out_t out = euler_step(self, config, vector(u_V), vector(i_A));
    const lode_sincos_t rotor = {narrow(sin(out.theta_rad)), narrow(cos(out.theta_rad))};
    return (lode_estimate_t){
        .omega_rad_s = narrow(out.omega_rad_s),
        .rotor = rotor,
        .i_A = lode_park(i_A, rotor),
        .e_V = {narrow(creal(out.e_V)), narrow(cimag(out.e_V))},
        .load_torque_Nm = narrow(-config->J_kgm2 / config->pole_pairs * out.f_rad_s2),
        .lock = 1.0f,
        .source = LODE_ESTIMATE_EXTERNAL,
    };
}
