#include "commission_parts.h"

#ifndef LODE_WITHOUT_COMMISSIONING

#define LOW_SHARE 0.3f // of rated speed
#define HIGH_SHARE 0.7f
#define HANDOVER_SHARE 0.2f // of rated speed
#define HANDOVER_MORE 2.0f  // of the default
#define ABOVE_HANDOVER 1.3f
#define SPAN_WANTED 2.0f // of the lower speed
#define SPAN_LEAST 1.3f
#define HIGH_MOST 0.9f     // of rated speed
#define HIGH_OF_MOST 0.8f  // of the largest that may be commanded: SPEED_ROOM is left
#define RUN_TIME_s 0.4f    // from the one speed to the other, by the configured J
#define TORQUE_LEAST 0.02f // of the torque at i_max
#define TORQUE_MOST 0.6f
#define REACHED 0.03f
#define STEADY_s 0.2f
#define RUN_WAIT_s 3.0f
#define SPEED_ROOM 1.2f        // below the commanded speed torque does not give way
#define EDGE_SHARE 0.15f       // of the span at either end that is not looked at
#define TORQUE_DEVIATION 0.02f // of what the currents say of the torque
#define B_DEVIATION 0.2f
#define PSI_DEVIATION 0.06f // between up and down
#define POINTS_LEAST 20u
#define PSI_ROUGH 0.03f // of what was reckoned with: more, and the run is made again
#define J_ROUGH 0.2f
#define LOST_MOST 2u // times that a lost rotor is looked for again
#define LOST_INERTIA 2.0f

void lode_commission_take_standstill(lode_commission_t *self) {
    lode_motor_t *motor = &self->config.motor;
    lode_inverter_config_t *inverter = &self->config.inverter;
    const float lost_V = lode_commission_found(self, LODE_COMMISSION_DEAD_V) - inverter->v_drop_V;
    motor->Rs_Ohm =
        lode_max(lode_commission_found(self, LODE_COMMISSION_RS_Ohm) - inverter->r_on_Ohm, 0.0f);
    motor->Ld_H = lode_commission_found(self, LODE_COMMISSION_LD_H);
    motor->Lq_H = lode_commission_found(self, LODE_COMMISSION_LQ_H);
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (lode_commission_is_sure(self, LODE_COMMISSION_LQ_FALL_1_A)) {
        self->config.references.Lq_fall = lode_commission_found(self, LODE_COMMISSION_LQ_FALL_1_A);
    }
#endif
    inverter->dead_time_s =
        lode_max(lost_V, 0.0f) /
        (self->drive->inverter.v_bus_V * lode_inverter_carrier_Hz(inverter, self->config.f_pwm_Hz));
}

// Flux and inertia are not known yet: the EMF at hand-over has more room than usual.
lode_drive_config_t lode_commission_for_run(lode_commission_t *self) {
    const float handover = self->designed.start.omega_handover_rad_s;
    const float wanted = HANDOVER_SHARE * self->designed.motor.omega_rated_rad_s;
    lode_drive_config_t config = self->config;
    config.start.omega_handover_rad_s = lode_clamp(wanted, handover, HANDOVER_MORE * handover);
    self->designed.start.omega_handover_rad_s = config.start.omega_handover_rad_s;
    return config;
}

void lode_commission_go_on(lode_commission_t *self, lode_status_t status) {
    self->status = status;
    LODE_SIGNAL_FENCE();
    self->wants_tuning = false;
}

void lode_commission_retune(lode_commission_t *self) {
    const lode_drive_config_t *config = &self->designed;
    if (self->since == 0u) {
        lode_commission_post(self, (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true});
        self->wants_tuning = true;
    } else if (self->wants_tuning) {
        // the thread is at it
    } else if (self->status != LODE_OK) {
        lode_commission_finish(self, LODE_COMMISSION_REFUSED);
    } else {
        const float inv_np = 1.0f / config->motor.pole_pairs;
        const float rated = config->motor.omega_rated_rad_s;
        const float low =
            lode_max(LOW_SHARE * rated, ABOVE_HANDOVER * config->start.omega_handover_rad_s);
        const float wanted = lode_max(
            lode_clamp(SPAN_WANTED * low, HIGH_SHARE * rated, HIGH_MOST * rated), SPAN_LEAST * low);
        const float high = lode_min(wanted, HIGH_OF_MOST * config->estimator.omega_max_rad_s);
        const float kt_Nm_A = lode_motor_kt_Nm_A(&config->motor);
        const float most_Nm = kt_Nm_A * config->inverter.i_max_A;
        // Within the dead band of the currents the dead time's loss changes with speed, and stands in the slope.
        const float least_Nm =
            lode_max(TORQUE_LEAST * most_Nm, kt_Nm_A * config->inverter.i_dead_A);
        self->low_rad_s = low * inv_np;
        self->high_rad_s = high * inv_np;
        self->torque_Nm =
            lode_clamp(config->motor.J_kgm2 * (self->high_rad_s - self->low_rad_s) / RUN_TIME_s,
                       least_Nm, TORQUE_MOST * most_Nm);
        self->quantity = LODE_COMMISSION_PSI_Wb;
        lode_commission_enter(self, STAGE_START);
    }
}

static float speed_of(const lode_commission_t *self) {
    return self->drive->estimator.pll.omega_rad_s / self->config.motor.pole_pairs;
}

void lode_commission_start(lode_commission_t *self) {
    const float off = lode_abs(speed_of(self) - self->low_rad_s);
    const bool steady =
        self->drive->mode == (uint_least8_t)LODE_MODE_RUN && off <= REACHED * self->low_rad_s;
    lode_commission_post(self,
                         (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = self->low_rad_s});
    // More often than not: with little EMF the speed ripples by as much.
    self->calm = steady ? self->calm + 1u : self->calm - (self->calm > 0u ? 1u : 0u);
    if (self->calm >= lode_commission_periods(self, STEADY_s)) {
        lode_commission_enter(self, STAGE_UP);
    } else if (self->since >
               lode_commission_periods(self, self->designed.start.timeout_s + RUN_WAIT_s)) {
        lode_commission_finish(self, LODE_COMMISSION_NO_START);
    } else {
        // on its way
    }
}

// Lines through speed over time and voltage over speed, from the first point on.
static void note_run(lode_commission_t *self) {
    const lode_drive_t *drive = self->drive;
    const float omega = drive->estimator.pll.omega_rad_s;
    // The d current fades with speed where the references bias it.
    const float u_V = drive->u_V.q -
                      lode_commission_found(self, LODE_COMMISSION_RS_Ohm) * drive->i_A.q -
                      omega * self->config.motor.Ld_H * drive->i_A.d;
    lode_commission_line_t *s = &self->sums.run;
    if (s->count == 0u) {
        s->first = self->since;
        s->first_rad_s = omega;
        s->first_V = u_V;
    }
    const float t = lode_commission_float(self->since - s->first) / self->config.f_pwm_Hz;
    const float w = omega - s->first_rad_s;
    const float u = u_V - s->first_V;
    s->count++;
    s->t += t;
    s->w += w;
    s->u += u;
    s->tt += t * t;
    s->tw += t * w;
    s->ww += w * w;
    s->wu += w * u;
    s->i_A.d += drive->i_A.d;
    s->i_A.q += drive->i_A.q;
}

static void take_run(lode_commission_t *self, uint32_t way) {
    const lode_commission_line_t *s = &self->sums.run;
    const lode_motor_t *motor = &self->config.motor;
    const float n = lode_commission_float(s->count);
    const lode_dq_t i_A = {s->i_A.d / n, s->i_A.q / n};
    const float psi_Wb = (n * s->wu - s->w * s->u) / (n * s->ww - s->w * s->w);
    const float acc_rad_s2 = (n * s->tw - s->t * s->w) / (n * s->tt - s->t * s->t);
    self->way[way] = (lode_commission_run_t){
        .psi_Wb = psi_Wb,
        .acc_rad_s2 = acc_rad_s2 / motor->pole_pairs,
        .torque_Nm = lode_motor_torque_factor(motor) *
                     (psi_Wb + (motor->Ld_H - motor->Lq_H) * i_A.d) * i_A.q,
        .omega_rad_s = (s->first_rad_s + s->w / n) / motor->pole_pairs,
    };
}

// The run was made with a flux or an inertia so far off that it is made again.
static bool is_rough(const lode_commission_t *self, float psi_Wb, float J) {
    const lode_motor_t *motor = &self->config.motor;
    return self->runs == 0u && psi_Wb > 0.0f && J > 0.0f &&
           (lode_abs(psi_Wb - motor->psi_Wb) > PSI_ROUGH * motor->psi_Wb ||
            lode_abs(J - motor->J_kgm2) > J_ROUGH * motor->J_kgm2);
}

// Friction acts alike up and down through the same speeds.
static void judge_run(lode_commission_t *self) {
    const lode_commission_run_t *up = &self->way[0];
    const lode_commission_run_t *down = &self->way[1];
    const float mean_Wb = 0.5f * (up->psi_Wb + down->psi_Wb);
    const float apart_Wb = lode_abs(up->psi_Wb - down->psi_Wb);
    const float sum_Nm = up->torque_Nm + down->torque_Nm;
    const float between_Nm = up->torque_Nm - down->torque_Nm;
    const float J = between_Nm / (up->acc_rad_s2 - down->acc_rad_s2);
    const float friction_Nm = 0.5f * (sum_Nm - J * (up->acc_rad_s2 + down->acc_rad_s2));
    const float omega = 0.5f * (up->omega_rad_s + down->omega_rad_s);
    const float unequal = lode_abs(sum_Nm) / lode_abs(between_Nm);
    lode_motor_t *motor = &self->config.motor;
    const bool rough = is_rough(self, mean_Wb, J);
    self->found[LODE_COMMISSION_B_Nms] =
        lode_commission_judged(friction_Nm / omega, TORQUE_DEVIATION * lode_abs(up->torque_Nm),
                               B_DEVIATION * lode_max(friction_Nm, 0.0f));
    if (!rough && (!lode_commission_keep(self, LODE_COMMISSION_PSI_Wb, mean_Wb, apart_Wb,
                                         PSI_DEVIATION * mean_Wb) ||
                   !lode_commission_keep(self, LODE_COMMISSION_J_kgm2, J, unequal, 1.0f))) {
        return;
    }
    // Of a run too short for the PLL to settle, which makes the flux too small, the inertia alone is taken.
    const bool agree = apart_Wb <= PSI_DEVIATION * mean_Wb;
    const float psi_Wb = agree ? mean_Wb : motor->psi_Wb;
    motor->J_kgm2 = J * psi_Wb / mean_Wb;
    motor->psi_Wb = psi_Wb;
    self->runs++;
    if (rough) {
        lode_commission_enter(self, STAGE_RETUNE);
        return;
    }
    if (lode_commission_is_sure(self, LODE_COMMISSION_B_Nms)) {
        motor->B_Nms = friction_Nm / omega;
    }
    lode_commission_finish(self, LODE_COMMISSION_DONE);
}

void lode_commission_run(lode_commission_t *self, uint32_t way) {
    const float sign = way == 0u ? 1.0f : -1.0f;
    const float edge = EDGE_SHARE * (self->high_rad_s - self->low_rad_s);
    const float from = self->low_rad_s + edge;
    const float to = self->high_rad_s - edge;
    const float now = speed_of(self);
    lode_commission_post(self, (lode_command_t){.mode = LODE_MODE_RUN,
                                                .speed_rad_s = SPEED_ROOM * self->high_rad_s,
                                                .control = LODE_CONTROL_TORQUE,
                                                .torque_Nm = sign * self->torque_Nm});
    const bool past = way == 0u ? now > self->high_rad_s : now < from;
    const bool inside = lode_in_range(now, from, to);
    if (inside) {
        note_run(self);
    }
    if (past && self->sums.run.count >= POINTS_LEAST) {
        take_run(self, way);
        if (way == 0u) {
            lode_commission_enter(self, STAGE_DOWN);
        } else {
            judge_run(self);
        }
    } else if (self->since > lode_commission_periods(self, RUN_WAIT_s)) {
        lode_commission_finish(self, LODE_COMMISSION_NO_START);
    } else {
        // under way
    }
}

// A rotor that was lost is looked for once more, with twice the inertia: a slower start, and less of an
// acceleration that does not come. One that does not follow in any attempt of a start, which get slower by themselves, is not,
// and all other faults end it.
void lode_commission_end_by_fault(lode_commission_t *self) {
    const uint_least8_t check = self->drive->guard.fault.check;
    const bool lost = check == (uint_least8_t)LODE_CHECK_LOST_LOCK ||
                      check == (uint_least8_t)LODE_CHECK_WRONG_WAY;
    if (check == (uint_least8_t)LODE_CHECK_START) {
        lode_commission_finish(self, LODE_COMMISSION_NO_START);
    } else if (lost && self->lost < LOST_MOST) { // these checks are of START and RUN alone
        self->lost++;
        self->config.motor.J_kgm2 *= LOST_INERTIA;
        lode_commission_enter(self, STAGE_RETUNE);
    } else {
        lode_commission_finish(self, LODE_COMMISSION_FAULT);
    }
}

#endif
