#include "design/injection.h"

#include <math.h>

#include "support/units.h"

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
    const double dead_V =
        (double)inverter->v_bus_V * (double)inverter->dead_time_s / ts + (double)inverter->v_drop_V;
    const double ripple_A = V * ts / Ld;
    const double noise_bandwidth =
        asked.estimator.pll.kind == LODE_PLL_LESO ? 33.0 / 16.0 : 5.0 / 4.0;
    // (H7), (H8)
    const double sample_rad =
        sqrt(6.0) / 2.0 * (double)hfi->noise_A / V * Ld / ts * (more + 1.0) / more;
    return (injection_t){
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
            sample_rad * sqrt(8.0 / 3.0 * noise_bandwidth * (double)hfi->sigma_rad_s * ts)),
        .dead_time_rad = dead_V / (V * more),
        .id_A = fmax((double)hfi->id_A, 0.0),
        .w1_rad_s = (double)hfi->w1_rad_s,
        .w2_rad_s = (double)hfi->w2_rad_s,
        .sigma_rad_s = (double)hfi->sigma_rad_s,
    };
}
