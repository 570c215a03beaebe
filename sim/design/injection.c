#include "design/injection.h"

#include <math.h>

#include "support/units.h"

/// Share of the speed: a larger error loses the lock, which checks the EMF's amplitude (P17).
#define SPEED_ERROR_MAX 0.4
/// Largest angle error after a step of the acceleration, times sigma^2 (P7): that of s/(s + sigma)^3 at t = 2/sigma.
#define PEAK_THIRD_ORDER (2.0 * exp(-2.0))

/// It is on by default (S54).
static bool is_default(const lode_drive_config_t *config) {
    lode_drive_config_t asked = *config;
    asked.hfi.mode = LODE_HFI_DEFAULT;
    lode_drive_design(&asked);
    return asked.hfi.mode == LODE_HFI_ON;
}

static bool is_third_order(const lode_drive_config_t *config) {
    return config->estimator.pll.kind == LODE_PLL_LESO;
}

/// Bandwidth with the EMF at a speed (P11).
static double sigma_at(const lode_pll_config_t *pll, double ts, double omega) {
    const double low = -expm1(-(double)pll->sigma_low_rad_s * ts);
    const double high = -expm1(-(double)pll->sigma_rad_s * ts);
    const double span = (double)pll->omega_high_rad_s - (double)pll->omega_low_rad_s;
    const double up = fmax(0.0, fmin((omega - (double)pll->omega_low_rad_s) / span, 1.0));
    return -log1p(-(low + (high - low) * up)) / ts;
}

static void add_step(injection_t *self, const lode_drive_config_t *config, double torque_Nm,
                     double ts) {
    const lode_motor_t *motor = &config->motor;
    const double acc = 2.0 * (double)motor->pole_pairs * torque_Nm / (double)motor->J_kgm2;
    const double peak = is_third_order(config) ? PEAK_THIRD_ORDER : 1.0;
    const double by_emf = sigma_at(&config->estimator.pll, ts, self->w2_rad_s);
    const double emf_rad = peak * acc / (by_emf * by_emf);
    self->torque_Nm = torque_Nm;
    self->step_deg = rig_deg_from_rad(peak * acc / (self->sigma_rad_s * self->sigma_rad_s));
    self->step_emf_deg = rig_deg_from_rad(emf_rad);
    self->loses_steps =
        !is_third_order(config) && 2.0 * acc / by_emf > SPEED_ERROR_MAX * self->w2_rad_s;
}

injection_t injection_of(const lode_drive_config_t *config) {
    lode_drive_config_t asked = *config;
    lode_drive_tuning_t tuning;
    asked.hfi.mode = LODE_HFI_ON;
    lode_drive_design(&asked);
    const lode_hfi_config_t *hfi = &asked.hfi;
    const lode_motor_t *motor = &asked.motor;
    const lode_inverter_config_t *inverter = &asked.inverter;
    const double ts = 1.0 / (double)asked.f_pwm_Hz;
    const double V = (double)hfi->V_h_V;
    const double Ld = (double)motor->Ld_H;
    const double Lq = (double)hfi->Lq_i_max_H;
    const double more = Lq / Ld - 1.0;
    const double calls = inverter->double_update == LODE_ON ? 2.0 : 1.0; // in a carrier period
    const double dead_V = (double)inverter->v_bus_V * (double)inverter->dead_time_s / (calls * ts) +
                          (double)inverter->v_drop_V;
    const double ripple_A = V * ts / Ld;
    const double noise_bandwidth = is_third_order(&asked) ? 33.0 / 16.0 : 5.0 / 4.0;
    // (H7), (H8), for random signs (H22)
    const double density = hfi->silent == LODE_ON ? 2.0 : 8.0 / 3.0;
    const double sample_rad =
        sqrt(6.0) / 2.0 * (double)hfi->noise_A / V * Ld / ts * (more + 1.0) / more;
    injection_t self = {
        .on = config->hfi.mode == LODE_HFI_ON,
        .status = lode_drive_tune(&tuning, &asked),
        .saliency = Lq / Ld,
        .V_h_V = V,
        .circle_share =
            V / ((double)asked.current.voltage_use * (double)inverter->v_bus_V / sqrt(3.0)),
        .ripple_A = ripple_A,
        .ripple_Nm = 1.5 * fmax((double)motor->sets, 1.0) * (double)motor->pole_pairs *
                     fabs(Ld - (double)motor->Lq_H) * (double)inverter->i_max_A * ripple_A,
        .tone_Hz = 0.5 / ts,
        .noise_deg = rig_deg_from_rad(
            sample_rad * sqrt(density * noise_bandwidth * (double)hfi->sigma_rad_s * ts)),
        .dead_time_rad = dead_V / (V * more),
        .id_A = fmax((double)hfi->id_A, 0.0),
        .w1_rad_s = (double)hfi->w1_rad_s,
        .w2_rad_s = (double)hfi->w2_rad_s,
        .sigma_rad_s = (double)hfi->sigma_rad_s,
        .torque_Nm = NAN,
        .step_deg = NAN,
        .step_emf_deg = NAN,
    };
    self.recommended = self.status == LODE_OK && is_default(config);
    if (self.status == LODE_OK) {
        add_step(&self, &asked, (double)lode_references_most_Nm(&tuning.references), ts);
    }
    return self;
}
