#include "commission_parts.h"
#include "start_parts.h"

#ifndef LODE_WITHOUT_COMMISSIONING

#define LOW_SHARE 0.3f // of rated speed
#define HIGH_SHARE 0.7f
#define HANDOVER_SHARE 0.2f // of rated speed
#define HANDOVER_MORE 2.0f  // of the default, at most
#define ABOVE_HANDOVER 1.3f
#define SPAN_WANTED 2.0f // of the lower speed
#define SPAN_LEAST 1.3f
#define SPAN_NARROW 1.1f  // with less, where no more speed may be commanded, there is no run
#define HIGH_MOST 0.9f    // of rated speed
#define HIGH_OF_MOST 0.8f // of the largest speed that may be commanded: leaves SPEED_ROOM
#define RUN_TIME_s 0.4f   // between the two speeds, with the configured J
#define TORQUE_MOST 0.6f  // of the torque at i_max
#define TORQUE_LEAST (1.0f / 30.0f) // of that
#define PLL_SETTLES 10.0f           // time constants of the PLL
#define BIAS_GONE 2.0f              // of the upper speed, where the d current has faded
#define REACHED 0.03f
#define STEADY_s 0.2f
#define MEAN_s 0.025f      // time constant of the mean speed before the run
#define START_WAIT_s 10.0f // after the start: a heavy rotor settles slowly
#define RUN_WAIT_s 3.0f
// Longest time of one way of a run: that of an inertia RUN_SLOWEST times the configured one, or of as much less torque.
#define RUN_SLOWEST 10.0f
#define RUN_LONGEST_s 30.0f
// The torque is raised if after SLOW_TIMES its time a run would need SLOW_MOST times that time or more.
#define SLOW_TIMES 2.0f
#define SLOW_MOST 4.0f
#define GONE_SHARE 0.5f
#define RAISE_MOST 10.0f // per raise
#define RAISES_MOST 2u
#define SPEED_ROOM 1.2f        // commanded over upper speed: the torque is limited near the former
#define EDGE_SHARE 0.15f       // of the span, not used at either end
#define TORQUE_DEVIATION 0.02f // of the torque by the currents
#define B_DEVIATION 0.2f
#define PSI_DEVIATION 0.06f // between up and down
#define POINTS_LEAST 20u
#define PSI_ROUGH 0.03f // of the assumed value: beyond, the run is made again
#define J_ROUGH 0.2f
#define RUNS_MOST 4u      // the last must agree with the one before
#define AGREED_TIMES 2.0f // times J_ROUGH: a last run that is off by this is half sure
#define LOST_MOST 2u      // times that the run is repeated after a lost rotor
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

// Largest electrical speed that may be commanded.
static float speed_most_rad_s(const lode_drive_config_t *config) {
    return lode_min(config->estimator.omega_max_rad_s, config->guard.omega_max_rad_s);
}

// Electrical speeds between which the run goes.
static lode_range_t run_speeds(const lode_drive_config_t *config) {
    const float rated = config->motor.omega_rated_rad_s;
    const float low =
        lode_max(LOW_SHARE * rated, ABOVE_HANDOVER * config->start.omega_handover_rad_s);
    const float wanted = lode_max(
        lode_clamp(SPAN_WANTED * low, HIGH_SHARE * rated, HIGH_MOST * rated), SPAN_LEAST * low);
    return (lode_range_t){low, lode_min(wanted, HIGH_OF_MOST * speed_most_rad_s(config))};
}

static float span_rad_s(const lode_drive_config_t *config) {
    const lode_range_t speeds = run_speeds(config);
    return (speeds.max - speeds.min) / config->motor.pole_pairs;
}

// Torque of a current that is clear of the dead band.
static float torque_clear_Nm(const lode_drive_config_t *config) {
    return lode_motor_kt_Nm_A(&config->motor) * config->inverter.i_dead_A;
}

// (N7): with that torque the run would be over before the PLL has settled.
static bool is_light(const lode_drive_config_t *config) {
    return config->motor.J_kgm2 * span_rad_s(config) * config->estimator.pll.sigma_rad_s <
           PLL_SETTLES * torque_clear_Nm(config);
}

// A configured hand-over speed is the least. The default also makes room for a resistance and a dead time that nobody knows,
// which are measured by now, and for the load steps of a machine with much reluctance (S52), but this shaft is free.
static float least_handover_rad_s(const lode_commission_t *self) {
    const lode_start_config_t *start = &self->designed.start;
    return self->config.start.omega_handover_rad_s > 0.0f
               ? start->omega_handover_rad_s
               : lode_min(
                     lode_start_least_rad_s(start, &self->designed.inverter, &self->designed.motor),
                     start->omega_handover_rad_s);
}

// Flux and inertia are not known yet. So the EMF at hand-over has HANDOVER_SHARE of what it has at rated speed, and speed
// control, whose torque goes with the inertia, no more acceleration than the run. The start need not measure again. Within the
// dead band of the currents the loss by dead time changes with speed and enters the slope: a light rotor, whose torque takes
// less current, gets a d current that is clear of it.
lode_drive_config_t lode_commission_for_run(lode_commission_t *self) {
    const float handover = self->designed.start.omega_handover_rad_s;
    const float wanted = HANDOVER_SHARE * self->designed.motor.omega_rated_rad_s;
    lode_drive_config_t config = self->config;
    config.start.omega_handover_rad_s =
        lode_clamp(wanted, least_handover_rad_s(self), HANDOVER_MORE * handover);
    self->designed.start.omega_handover_rad_s = config.start.omega_handover_rad_s;
    config.start.measure = config.start.measure == LODE_AUTO ? LODE_OFF : config.start.measure;
    config.speed.ramp_rad_s2 =
        lode_min(self->designed.speed.ramp_rad_s2, span_rad_s(&self->designed) / RUN_TIME_s);
    if (is_light(&self->designed)) {
        const float high_rad_s = run_speeds(&self->designed).max;
        config.references.id_bias_A =
            lode_max(self->designed.references.id_bias_A, self->designed.inverter.i_dead_A);
        config.references.omega_low_rad_s = SPEED_ROOM * high_rad_s;
        config.references.omega_high_rad_s = BIAS_GONE * high_rad_s;
    }
    return config;
}

// The speed that may be commanded leaves no span for a run.
static bool is_narrow(const lode_drive_config_t *config) {
    const lode_range_t speeds = run_speeds(config);
    return speeds.max < SPAN_NARROW * speeds.min;
}

void lode_commission_go_on(lode_commission_t *self, lode_status_t status) {
    const lode_drive_config_t *config = &self->designed;
    const bool by_guard = config->guard.omega_max_rad_s < config->estimator.omega_max_rad_s;
    const lode_status_t too_slow = by_guard ? LODE_ERROR_GUARD_SPEED : LODE_ERROR_OMEGA_MAX;
    self->status = is_narrow(config) ? too_slow : status;
    LODE_SIGNAL_FENCE();
    self->wants_tuning = false;
}

static float torque_most_Nm(const lode_commission_t *self) {
    const lode_drive_config_t *config = &self->designed;
    return TORQUE_MOST * lode_motor_kt_Nm_A(&config->motor) * config->inverter.i_max_A;
}

static void plan_run(lode_commission_t *self) {
    const lode_drive_config_t *config = &self->designed;
    const lode_range_t speeds = run_speeds(config);
    const float inv_np = 1.0f / config->motor.pole_pairs;
    const float most_Nm = torque_most_Nm(self);
    self->low_rad_s = speeds.min * inv_np;
    self->high_rad_s = speeds.max * inv_np;
    const float least_Nm =
        lode_max(TORQUE_LEAST * most_Nm, is_light(config) ? 0.0f : torque_clear_Nm(config));
    self->torque_Nm =
        lode_clamp(config->motor.J_kgm2 * span_rad_s(config) / RUN_TIME_s, least_Nm, most_Nm);
}

void lode_commission_retune(lode_commission_t *self) {
    if (self->since == 0u) {
        lode_commission_post(self, (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true});
        self->wants_tuning = true;
    } else if (!self->wants_tuning && self->status == LODE_OK) {
        plan_run(self);
        self->quantity = LODE_COMMISSION_PSI_Wb;
        lode_commission_enter(self, STAGE_START);
    } else {
        // the thread makes the tuning, or the drive has refused one, which ends it
    }
}

static float speed_of(const lode_commission_t *self) {
    return self->drive->estimator.pll.omega_rad_s / self->config.motor.pole_pairs;
}

// Time between the two speeds with the assumed inertia.
static float run_time_s(const lode_commission_t *self) {
    return self->config.motor.J_kgm2 * (self->high_rad_s - self->low_rad_s) / self->torque_Nm;
}

// Ends the run. A motor that turns reports the speed reached and the one wanted; otherwise the start has reported.
static void give_up(lode_commission_t *self, float wanted_rad_s) {
    if (self->drive->mode == (uint_least8_t)LODE_MODE_RUN) {
        self->reached_rad_s = speed_of(self);
        self->wanted_rad_s = wanted_rad_s;
    }
    lode_commission_finish(self, LODE_COMMISSION_NO_START);
}

void lode_commission_start(lode_commission_t *self) {
    // The speed of a light rotor ripples by more than REACHED, its mean does not.
    const float weight = 1.0f / (MEAN_s * self->config.f_pwm_Hz);
    self->sums.mean_rad_s += weight * (speed_of(self) - self->sums.mean_rad_s);
    const float off = lode_abs(self->sums.mean_rad_s - self->low_rad_s);
    const bool steady =
        self->drive->mode == (uint_least8_t)LODE_MODE_RUN && off <= REACHED * self->low_rad_s;
    lode_commission_post(self,
                         (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = self->low_rad_s});
    // Counts up and down: with little EMF the speed ripples by as much as REACHED.
    self->calm = steady ? self->calm + 1u : self->calm - (self->calm > 0u ? 1u : 0u);
    if (self->calm >= lode_commission_periods(self, STEADY_s)) {
        lode_commission_enter(self, STAGE_UP);
    } else if (self->since >
               lode_commission_periods(self, self->designed.start.timeout_s + START_WAIT_s)) {
        give_up(self, self->low_rad_s);
    } else {
        // on its way
    }
}

// Sums for the lines of speed over time and voltage over speed, relative to the first point.
static void note_run(lode_commission_t *self) {
    const lode_drive_t *drive = self->drive;
    const float omega = drive->estimator.pll.omega_rad_s;
    // Less the part of the d current, which fades with speed where the references bias it.
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

// The run was made with a flux, an inertia or a torque so far off that it is made again. A rotor that is heavier than assumed
// takes longer, so that the PLL has more time to settle; one that is too slow gets more torque. `unequal`: as for the confidence
// of the inertia; a run that does not agree with itself is repeated only once.
static bool is_rough(const lode_commission_t *self, float psi_Wb, float J, float unequal) {
    const lode_motor_t *motor = &self->config.motor;
    const bool may = self->runs == 0u || (self->runs + 1u < RUNS_MOST && unequal <= 1.0f);
    return may && psi_Wb > 0.0f && J > 0.0f &&
           (self->raises > 0u || lode_abs(psi_Wb - motor->psi_Wb) > PSI_ROUGH * motor->psi_Wb ||
            J < (1.0f - J_ROUGH) * motor->J_kgm2);
}

// Friction is the same up and down through the same speeds, so that it cancels from the inertia.
static void judge_run(lode_commission_t *self) {
    const lode_commission_run_t *up = &self->way[0];
    const lode_commission_run_t *down = &self->way[1];
    const float mean_Wb = 0.5f * (up->psi_Wb + down->psi_Wb);
    const float sum_Nm = up->torque_Nm + down->torque_Nm;
    const float between_Nm = up->torque_Nm - down->torque_Nm;
    const float J = between_Nm / (up->acc_rad_s2 - down->acc_rad_s2);
    const float friction_Nm = 0.5f * (sum_Nm - J * (up->acc_rad_s2 + down->acc_rad_s2));
    const float omega = 0.5f * (up->omega_rad_s + down->omega_rad_s);
    lode_motor_t *motor = &self->config.motor;
    const float apart = lode_abs(sum_Nm) / lode_abs(between_Nm);
    const bool rough = is_rough(self, mean_Wb, J, apart);
    // The last run must agree with the one before.
    const float last = self->runs + 1u == RUNS_MOST ? 1.0f : 0.0f;
    const float apart_Wb =
        lode_max(lode_abs(up->psi_Wb - down->psi_Wb), last * lode_abs(mean_Wb - motor->psi_Wb));
    const float unequal =
        lode_max(apart, last * lode_abs(J / motor->J_kgm2 - 1.0f) / (AGREED_TIMES * J_ROUGH));
    self->found[LODE_COMMISSION_B_Nms] =
        lode_commission_judged(friction_Nm / omega, TORQUE_DEVIATION * lode_abs(up->torque_Nm),
                               B_DEVIATION * lode_max(friction_Nm, 0.0f));
    if (!rough && (!lode_commission_keep(self, LODE_COMMISSION_PSI_Wb, mean_Wb, apart_Wb,
                                         PSI_DEVIATION * mean_Wb) ||
                   !lode_commission_keep(self, LODE_COMMISSION_J_kgm2, J, unequal, 1.0f))) {
        return;
    }
    // A run too short for the PLL to settle makes the flux too small: only the inertia is taken from it.
    const bool agree = apart_Wb <= PSI_DEVIATION * mean_Wb;
    const float psi_Wb = agree ? mean_Wb : motor->psi_Wb;
    motor->J_kgm2 = J * psi_Wb / mean_Wb;
    motor->psi_Wb = psi_Wb;
    self->runs++;
    const bool loaded = lode_commission_is_sure(self, LODE_COMMISSION_B_Nms);
    if (rough) {
        const float more = self->high_rad_s / omega;
        // Where the torque had to be raised, even an unsure friction is better than none.
        const bool taken = loaded || self->raises > 0u;
        self->load_Nm = taken ? lode_max(friction_Nm, 0.0f) * more * more : 0.0f;
        self->raises = 0u;
        lode_commission_enter(self, STAGE_RETUNE);
        return;
    }
    if (loaded) {
        motor->B_Nms = friction_Nm / omega;
    }
    lode_commission_finish(self, LODE_COMMISSION_DONE);
}

static float share_of_span(const lode_commission_t *self, float now_rad_s) {
    return (now_rad_s - self->low_rad_s) / (self->high_rad_s - self->low_rad_s);
}

// The torque is too small: the inertia is many times the assumed one, or there is a load.
static bool is_slow(const lode_commission_t *self, float now_rad_s) {
    const float meant_s = lode_max(run_time_s(self), RUN_TIME_s);
    const float time_s = lode_commission_float(self->since) / self->config.f_pwm_Hz;
    return self->raises < RAISES_MOST && time_s >= SLOW_TIMES * meant_s &&
           SLOW_MOST * meant_s * share_of_span(self, now_rad_s) < time_s;
}

// Raises the torque to what covers the span in its time. The run goes on, or begins again if half of the span is covered.
static void raise_torque(lode_commission_t *self, float now_rad_s) {
    const float time_s = lode_commission_float(self->since) / self->config.f_pwm_Hz;
    const float share = share_of_span(self, now_rad_s);
    const float times = time_s / (RUN_TIME_s * lode_max(share, FLT_MIN));
    self->torque_Nm =
        lode_min(self->torque_Nm * lode_clamp(times, 1.0f, RAISE_MOST), torque_most_Nm(self));
    self->raises++;
    lode_commission_enter(self, share < GONE_SHARE ? STAGE_UP : STAGE_START);
}

// Time limit of one way of the run.
static float run_limit_s(const lode_commission_t *self) {
    return lode_min(RUN_WAIT_s + RUN_SLOWEST * run_time_s(self), RUN_LONGEST_s);
}

void lode_commission_run(lode_commission_t *self, uint32_t way) {
    const float wanted_Nm = way == 0u
                                ? lode_min(self->torque_Nm + self->load_Nm, torque_most_Nm(self))
                                : -self->torque_Nm;
    const float edge = EDGE_SHARE * (self->high_rad_s - self->low_rad_s);
    const float from = self->low_rad_s + edge;
    const float to = self->high_rad_s - edge;
    const float now = speed_of(self);
    lode_commission_post(self, (lode_command_t){.mode = LODE_MODE_RUN,
                                                .speed_rad_s = SPEED_ROOM * self->high_rad_s,
                                                .control = LODE_CONTROL_TORQUE,
                                                .torque_Nm = wanted_Nm});
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
    } else if (way == 0u && is_slow(self, now)) {
        raise_torque(self, now);
    } else if (self->since > lode_commission_periods(self, run_limit_s(self))) {
        give_up(self, way == 0u ? self->high_rad_s : from);
    } else {
        // under way
    }
}

// A rotor that was lost is started again with twice the inertia: a slower start, and less acceleration expected. A rotor that
// follows in no attempt of a start is not, because the attempts get slower by themselves. All other faults end it.
void lode_commission_end_by_fault(lode_commission_t *self) {
    const uint_least8_t check = self->drive->guard.fault.check;
    const bool lost = check == (uint_least8_t)LODE_CHECK_LOST_LOCK ||
                      check == (uint_least8_t)LODE_CHECK_WRONG_WAY;
    if (check == (uint_least8_t)LODE_CHECK_START) {
        lode_commission_finish(self, LODE_COMMISSION_NO_START);
    } else if (lost && self->lost < LOST_MOST) { // these checks exist in START and RUN only
        self->lost++;
        self->config.motor.J_kgm2 *= LOST_INERTIA;
        lode_commission_enter(self, STAGE_RETUNE);
    } else {
        lode_commission_finish(self, LODE_COMMISSION_FAULT);
    }
}

#endif
