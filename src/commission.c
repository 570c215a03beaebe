#include "commission_parts.h"

#ifndef LODE_WITHOUT_COMMISSIONING

#include <stddef.h>

#define BEFORE_FIRST 0xFFFFFFFFu // the next count is 0

// Axis along which the rotor is held: with three phases that of a, where all phases carry current; with six halfway from a1
// to a2 (N5).
#define AXIS_SIX_rad (LODE_PI / 12.0f)
#define DEAD_THREE (4.0f / 3.0f) // 2/3 of the sum of the phases' cosines, without signs
#define DEAD_SIX 1.2879f

#define NAME(enumerator, name)                                                                     \
    case LODE_COMMISSION_##enumerator:                                                             \
        return name

const char *lode_commission_name(lode_commission_quantity_t quantity) {
    switch (quantity) {
        NAME(OFFSET_A, "offset_a_count");
        NAME(OFFSET_B, "offset_b_count");
        NAME(OFFSET_C, "offset_c_count");
        NAME(OFFSET_A2, "offset_a2_count");
        NAME(OFFSET_B2, "offset_b2_count");
        NAME(OFFSET_C2, "offset_c2_count");
        NAME(SIGNALS, "signals");
        NAME(RS_Ohm, "Rs_Ohm");
        NAME(DEAD_V, "dead_V");
        NAME(LD_H, "Ld_H");
        NAME(LQ_H, "Lq_H");
        NAME(LD_FALL_1_A, "Ld_fall");
        NAME(LQ_FALL_1_A, "Lq_fall");
        NAME(LXY_H, "Lxy_H");
        NAME(PSI_Wb, "psi_Wb");
        NAME(J_kgm2, "J_kgm2");
        NAME(B_Nms, "B_Nms");
    case LODE_COMMISSION_QUANTITIES:
    default:
        return "unknown";
    }
}

const char *lode_commission_result_name(lode_commission_result_t result) {
    switch (result) {
        NAME(RUNNING, "RUNNING");
        NAME(DONE, "DONE");
        NAME(FAULT, "FAULT");
        NAME(UNSURE, "UNSURE");
        NAME(NO_CURRENT, "NO_CURRENT");
        NAME(UNSETTLED, "UNSETTLED");
        NAME(REFUSED, "REFUSED");
        NAME(NO_START, "NO_START");
    default:
        return "UNKNOWN";
    }
}

void lode_commission_post(lode_commission_t *self, lode_command_t command) {
    const lode_status_t status = lode_drive_post_command(self->drive, &command);
    if (status != LODE_OK) {
        self->status = status;
    }
}

void lode_commission_post_vector(lode_commission_t *self, lode_mode_t mode, float d, float q) {
    lode_commission_post(
        self, (lode_command_t){.mode = mode, .vector = {d, q}, .theta_rad = self->axis_rad});
}

void lode_commission_restart(lode_commission_t *self) {
    self->since = BEFORE_FIRST;
}

void lode_commission_enter(lode_commission_t *self, lode_commission_stage_t stage) {
    self->stage = (uint32_t)stage;
    lode_commission_restart(self);
    self->calm = 0u;
    self->sums = (lode_commission_sums_t){.window = {.count = 0u}};
}

void lode_commission_finish(lode_commission_t *self, lode_commission_result_t result) {
    lode_commission_enter(self, STAGE_OVER);
    self->result = result;
    lode_commission_post(self, (lode_command_t){.mode = LODE_MODE_OFF});
}

lode_commission_value_t lode_commission_judged(float value, float deviation, float allowed) {
    const float share = deviation / lode_max(allowed, FLT_MIN);
    const float confidence = 1.0f / (1.0f + share * share);
    return (lode_commission_value_t){value, lode_is_finite(value + confidence) ? confidence : 0.0f};
}

bool lode_commission_keep(lode_commission_t *self, lode_commission_quantity_t quantity, float value,
                          float deviation, float allowed) {
    self->found[quantity] = lode_commission_judged(value, deviation, allowed);
    self->quantity = quantity;
    if (self->found[quantity].confidence < LODE_COMMISSION_SURE) {
        lode_commission_finish(self, LODE_COMMISSION_UNSURE);
        return false;
    }
    return true;
}

float lode_commission_dead_along(const lode_commission_t *self) {
    return self->sets > 1u ? DEAD_SIX : DEAD_THREE;
}

float lode_commission_dead_known_V(const lode_drive_config_t *config) {
    const lode_inverter_config_t *inverter = &config->inverter;
    return inverter->v_drop_V + inverter->v_bus_V * inverter->dead_time_s *
                                    lode_inverter_carrier_Hz(inverter, config->f_pwm_Hz);
}

static void proceed(lode_commission_t *self, const lode_commission_period_t *period, lode_dq_t u_V,
                    lode_dq_t i_A) {
    switch ((lode_commission_stage_t)self->stage) {
    case STAGE_CALIBRATE:
        lode_commission_calibrate(self, period);
        break;
    case STAGE_PULSES:
        lode_commission_pulse(self, period, i_A);
        break;
    case STAGE_ACROSS:
        lode_commission_across(self, i_A);
        break;
    case STAGE_ALONG:
        lode_commission_along(self, u_V, i_A);
        break;
    case STAGE_LEVEL:
        lode_commission_move_level(self, i_A);
        break;
    case STAGE_LD:
        lode_commission_Ld(self, u_V, i_A);
        break;
    case STAGE_LQ:
        lode_commission_Lq(self, u_V, i_A);
        break;
    case STAGE_LQ_FALL:
        lode_commission_Lq_fall(self, u_V, i_A);
        break;
    case STAGE_LXY:
        lode_commission_Lxy(self, u_V, i_A);
        break;
    case STAGE_RETUNE:
        lode_commission_retune(self);
        break;
    case STAGE_START:
        lode_commission_start(self);
        break;
    case STAGE_UP:
        lode_commission_run(self, 0u);
        break;
    case STAGE_DOWN:
        lode_commission_run(self, 1u);
        break;
    case STAGE_OVER:
    default:
        break;
    }
}

lode_drive_config_t lode_commission_blind(const lode_drive_config_t *given) {
    lode_drive_config_t blind = *given;
    blind.inverter.dead_time_correction = LODE_OFF;
    blind.inverter.dead_time_model = LODE_OFF;
    return blind;
}

void lode_commission_begin(lode_commission_t *self, lode_drive_t *drive,
                           const lode_drive_config_t *given, const lode_drive_config_t *designed) {
    const bool six = designed->motor.sets > 1.0f;
    const float axis_rad = six ? AXIS_SIX_rad : 0.0f;
    *self = (lode_commission_t){
        .drive = drive,
        .config = *given,
        .designed = *designed,
        .sets = six ? (uint32_t)LODE_SETS : 1u,
        .axis_rad = axis_rad,
        .axis = lode_sincos(axis_rad),
    };
    lode_commission_choose_vector(self);
}

lode_status_t lode_commission_init(lode_commission_t *self, lode_drive_t *drive,
                                   lode_drive_tuning_t tuning[2],
                                   const lode_drive_config_t *config) {
    if (self == NULL || drive == NULL || tuning == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    if (config->motor.sets > 1.0f) {
        return LODE_ERROR_MOTOR_SETS;
    }
    lode_drive_config_t designed = lode_commission_blind(config);
    lode_drive_design(&designed);
    const lode_status_t status = lode_drive_init(drive, &tuning[0], &designed);
    if (status == LODE_OK) {
        lode_commission_begin(self, drive, config, &designed);
        self->tuning = tuning;
    }
    return status;
}

void lode_commission_follow(lode_commission_t *self, const lode_commission_period_t *period) {
    const uint32_t stage = self->stage;
    // In these two stages a fault has been handled already.
    const bool dealt = stage == (uint32_t)STAGE_RETUNE || stage == (uint32_t)STAGE_OVER;
    self->push_V = 0.0f;
    if (!dealt && !lode_guard_is_good(&self->drive->guard)) {
        lode_commission_end_by_fault(self);
    } else {
        const bool xy = stage == (uint32_t)STAGE_LXY;
        const lode_ab_t turned_V = lode_ab_rotate(period->u_xy_V, self->axis);
        const lode_ab_t turned_A = lode_ab_rotate(period->i_xy_A, self->axis);
        const lode_dq_t u_V =
            xy ? (lode_dq_t){turned_V.alpha, turned_V.beta} : lode_park(period->u_V, self->axis);
        const lode_dq_t i_A = xy ? (lode_dq_t){turned_A.alpha, turned_A.beta} : self->drive->i_A;
        proceed(self, period, u_V, i_A);
        if (self->status != LODE_OK && self->result == LODE_COMMISSION_RUNNING) {
            lode_commission_finish(self, LODE_COMMISSION_REFUSED);
        }
        self->before_i_A[1] = self->before_i_A[0];
        self->before_i_A[0] = i_A;
        self->before_u_V = u_V;
    }
    self->since++;
}

lode_commission_result_t lode_commission_work(lode_commission_t *self) {
    if (self->wants_tuning) {
        lode_commission_take_standstill(self);
        self->designed = self->config;
        lode_drive_design(&self->designed);
        const lode_drive_config_t config = lode_commission_for_run(self);
        lode_drive_tuning_t *next = &self->tuning[self->drive->tuning == &self->tuning[0] ? 1 : 0];
        const lode_status_t status = lode_drive_tune(next, &config);
        if (status == LODE_OK) {
            (void)lode_drive_post_tuning(self->drive, next);
        }
        lode_commission_go_on(self, status);
    }
    return self->result;
}

lode_drive_out_t lode_commission_step(lode_commission_t *self, const lode_counts_t *counts) {
    lode_drive_t *drive = self->drive;
    const lode_ab_t none = {0.0f, 0.0f};
    const lode_ab_t u_V = lode_inverter_realised(&drive->inverter, drive->steps);
    const lode_drive_out_t out = lode_drive_step(drive, counts);
    const lode_commission_period_t period = {{counts, NULL}, u_V, none, none};
    lode_commission_follow(self, &period);
    return out;
}

const lode_drive_config_t *lode_commission_config(const lode_commission_t *self) {
    return &self->config;
}

#endif
