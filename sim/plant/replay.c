#include "plant/replay.h"

#include "plant/plant.h"

#include <math.h>
#include <stddef.h>

static plant_config_t averaged_config(const double p[PLANT_REPLAY_PARAMETERS]) {
    plant_config_t config = plant_config_jiang2022();
    config.level = PLANT_AVERAGED;
    config.pwm_ticks = 0;
    config.load_is_passive = false;
    config.speed_is_prescribed = true;
    config.pole_pairs = (int)p[PLANT_REPLAY_POLE_PAIRS];
    config.Rs_Ohm = p[PLANT_REPLAY_RS_OHM];
    config.Ld_H = p[PLANT_REPLAY_LD_H];
    config.Lq_H = p[PLANT_REPLAY_LQ_H];
    config.psi_Wb = p[PLANT_REPLAY_PSI_WB];
    config.J_kgm2 = p[PLANT_REPLAY_J_KGM2];
    config.B_Nms = p[PLANT_REPLAY_B_NMS];
    config.v_bus_V = p[PLANT_REPLAY_V_BUS_V];
    config.period_s = p[PLANT_REPLAY_PERIOD_S];
    config.omega_m_rad_s = p[PLANT_REPLAY_OMEGA_M_RAD_S];
    // One period with gates off comes first, because a duty takes a period to act.
    config.theta_e_rad =
        p[PLANT_REPLAY_THETA_E_RAD] - config.pole_pairs * config.omega_m_rad_s * config.period_s;
    return config;
}

/// Duties of the three legs around half of the bus voltage, limited to its range.
static void write_voltage(plant_t *plant, double u_alpha_V, double u_beta_V, double v_bus_V) {
    double phase_V[PLANT_PHASES], duty[PLANT_PHASES];
    for (int n = 0; n < PLANT_PHASES; n++) {
        phase_V[n] = plant_axis_cos[n] * u_alpha_V + plant_axis_sin[n] * u_beta_V;
    }
    const double top = fmax(phase_V[0], fmax(phase_V[1], phase_V[2]));
    const double bottom = fmin(phase_V[0], fmin(phase_V[1], phase_V[2]));
    for (int n = 0; n < PLANT_PHASES; n++) {
        duty[n] = 0.5 + (phase_V[n] - 0.5 * (top + bottom)) / v_bus_V;
    }
    plant_write(plant, duty, true);
}

int plant_replay(const double parameter[PLANT_REPLAY_PARAMETERS], int rows, const double *u_alpha_V,
                 const double *u_beta_V, const double *omega_m_rad_s, const double *load_Nm,
                 double *out) {
    plant_t plant;
    const plant_config_t config = averaged_config(parameter);
    if (plant_init(&plant, &config) != NULL) {
        return 1;
    }
    for (int k = 0; k <= rows; k++) {
        // Now at t_k-1: u[k] acts from t_k on.
        if (k < rows) {
            write_voltage(&plant, u_alpha_V[k], u_beta_V[k], config.v_bus_V);
        }
        if (k > 0) {
            plant_truth_t truth;
            double *row = out + (size_t)(k - 1) * PLANT_REPLAY_COLUMNS;
            plant_sample(&plant, NULL, &truth);
            row[PLANT_REPLAY_I_ALPHA_A] = truth.i_alpha_A;
            row[PLANT_REPLAY_I_BETA_A] = truth.i_beta_A;
            row[PLANT_REPLAY_THETA_OUT_RAD] = truth.theta_e_rad;
            row[PLANT_REPLAY_OMEGA_OUT_RAD_S] = truth.omega_m_rad_s;
            row[PLANT_REPLAY_TORQUE_NM] = truth.torque_Nm;
            if (omega_m_rad_s != NULL) {
                plant_set_speed(&plant, omega_m_rad_s[k - 1]);
            } else {
                plant_release_speed(&plant);
                plant_set_load(&plant, load_Nm != NULL ? load_Nm[k - 1] : 0.0);
            }
        }
        plant_advance(&plant);
    }
    return 0;
}
