/// Single blocks of a step at the operating point. Unlike the drives of drives.c they are called as
/// the core calls them, with its tunings.
#include "current_inline.h"
#include "emf_inline.h"
#include "estimator_inline.h"
#include "guard_inline.h"
#include "image.h"
#include "modulator6_inline.h"
#include "open_phase_inline.h"
#include "pi_inline.h"
#include "references_inline.h"
#include "sense_inline.h"
#include "speed_inline.h"
#include "start_inline.h"
#include "xy_inline.h"

enum { C_LESO_QPLL, FA_LESO_LESO_QPLL, ENHANCED, ESTIMATORS };

static const int32_t drive_of[ESTIMATORS] = {BENCH_c_leso_qpll, BENCH_fa_leso_leso_qpll,
                                             BENCH_enhanced};

static lode_estimator_t estimator[ESTIMATORS];
static lode_drive_tuning_t tuning[ESTIMATORS];
static lode_estimate_t estimate[ESTIMATORS];
static uint32_t row[ESTIMATORS]; // of the last estimate

// What the other blocks work on.
static lode_sense_t sense;
static lode_current_t current;
static lode_speed_t speed;
static lode_references_t references;
static lode_references_t weak[3];
static lode_references_tuning_t weak_tuning[3]; // MTPA; id = 0 and MTPA with field weakening
static lode_guard_t guard;
static lode_start_t start;
static lode_pi_t pi;
static lode_sogi_t sogi;
static lode_sogi_tuning_t sogi_tuning;
static lode_pll_t pll;
static lode_emf_t emf;
static lode_sample_t sample;
static lode_sincos_t rotor;
static lode_drive6_tuning_t tuning6;
static lode_xy_t xy;
static lode_open_phase_watch_t phases;

// Where results go, so that the compiler keeps them.
float bench_sink[8];

static const bench_inputs_t *input(uint32_t call) {
    return &bench_inputs[BENCH_SETTLE_ESTIMATOR + call % BENCH_ROWS];
}

static void estimate_row(int32_t n, uint32_t k) {
    estimate[n] = lode_estimator_step(&estimator[n], &tuning[n].estimator, bench_inputs[k].u_V,
                                      bench_inputs[k].i_A);
    row[n] = k;
}

// A salient rotor at its voltage limit.
static bool tune_references(void) {
    bool good = true;
    for (int32_t n = 0; n < 3; n++) {
        lode_drive_config_t config = bench_config(BENCH_enhanced);
        config.motor.Lq_H *= 2.0f;
        config.references.kind = n == 1 ? LODE_REFERENCES_ID0 : LODE_REFERENCES_MTPA;
        config.references.field_weakening = n == 0 ? LODE_OFF : LODE_ON;
        lode_drive_tuning_t drive;
        good = lode_drive_tune(&drive, &config) == LODE_OK && good;
        weak_tuning[n] = drive.references;
        lode_references_reset(&weak[n], 0.0f);
    }
    return good;
}

bool bench_blocks_setup(void) {
    bool good = tune_references();
    for (int32_t n = 0; n < ESTIMATORS; n++) {
        const lode_drive_config_t config = bench_config(drive_of[n]);
        good = lode_drive_tune(&tuning[n], &config) == LODE_OK && good;
        lode_estimator_reset(&estimator[n], &tuning[n].estimator);
        for (uint32_t k = 0; k < BENCH_SETTLE_ESTIMATOR; k++) {
            estimate_row(n, k);
        }
    }
    const lode_drive_tuning_t *t = &tuning[ENHANCED];
    const lode_dq_t i_A = {0.0f, BENCH_IQ_A};
    lode_sense_reset(&sense, &t->sense);
    rotor = lode_sincos(1.0f);
    lode_current_take(&current, &t->current, t->references.Lq_H);
    lode_current_reset(
        &current, (lode_dq_t){-0.5f, 9.9f},
        lode_references_induced_V(&t->references, current.Lq_H, i_A, BENCH_OMEGA_rad_s));
    lode_speed_reset(&speed, &t->speed, BENCH_OMEGA_rad_s / BENCH_POLE_PAIRS,
                     lode_references_torque_Nm(&t->references, i_A), 0.0f,
                     lode_references_most_Nm(&t->references));
    lode_guard_reset(&guard);
    lode_start_reset(&start, lode_sincos(0.0f), BENCH_OMEGA_rad_s, BENCH_IQ_A);
    pll = estimator[ENHANCED].pll;
    emf = estimator[ENHANCED].emf;
    sample = lode_sense_step(&sense, &t->sense, &bench_counted[BENCH_enhanced][0], LODE_PHASES);
    sogi_tuning = lode_sogi_tune(0.7f, 6.0f * BENCH_OMEGA_rad_s / BENCH_F_PWM_Hz);
    const lode_drive6_config_t config6 = bench6_config(BENCH6_enhanced);
    good = lode_drive6_tune(&tuning6, &config6) == LODE_OK && good;
    lode_xy_reset(&xy);
    lode_xy_adapt(&xy, &tuning6.xy, BENCH_OMEGA_rad_s);
    lode_open_phase_reset(&phases);
    return good;
}

bool bench_blocks_good(void) {
    for (int32_t n = 0; n < ESTIMATORS; n++) {
        const lode_telemetry_t telemetry = {.theta_rad = lode_estimate_theta_rad(&estimate[n]),
                                            .omega_rad_s = estimate[n].omega_rad_s,
                                            .lock = estimate[n].lock};
        if (!bench_estimate_is_good(drive_of[n], &telemetry, bench_inputs[row[n]].theta_rad)) {
            return false;
        }
    }
    return true;
}

#define BLOCK(name)                                                                                \
    void bench_##name(uint32_t call);                                                              \
    void bench_##name(uint32_t call)

// What every one of them costs before it does anything: to be subtracted where it matters.
BLOCK(nothing) {
    bench_sink[0] = input(call)->theta_rad;
}

BLOCK(estimator_c_leso_qpll) {
    estimate_row(C_LESO_QPLL, BENCH_SETTLE_ESTIMATOR + call % BENCH_ROWS);
}

BLOCK(estimator_fa_leso_leso_qpll) {
    estimate_row(FA_LESO_LESO_QPLL, BENCH_SETTLE_ESTIMATOR + call % BENCH_ROWS);
}

BLOCK(estimator_enhanced) {
    estimate_row(ENHANCED, BENCH_SETTLE_ESTIMATOR + call % BENCH_ROWS);
}

BLOCK(sense) {
    sample = lode_sense_step(&sense, &tuning[ENHANCED].sense,
                             &bench_counted[BENCH_enhanced][call % BENCH_ROWS], LODE_PHASES);
}

BLOCK(emf_c_leso) {
    const bench_inputs_t *in = input(call);
    const lode_emf_tuning_t *t = &tuning[ENHANCED].estimator.emf;
    const lode_ab_t m_V = lode_emf_dead_beat(&emf, t, in->u_V, in->i_A);
    const lode_ab_t e_V =
        lode_observer_step(&emf.observer, &t->observer, m_V, rotor, BENCH_OMEGA_rad_s);
    bench_sink[0] = e_V.alpha;
    bench_sink[1] = e_V.beta;
}

BLOCK(pll) {
    const lode_pll_tuning_t *t = &tuning[ENHANCED].estimator.pll;
    const float error = 1.0e-3f * input(call)->i_A.alpha;
    const lode_pll_motion_t motion = lode_pll_predict(&pll, t);
    const lode_sincos_t frame = lode_angle_add(pll.frame, lode_sincos_small(motion.angle_rad));
    lode_pll_correct(&pll, estimator[ENHANCED].gains, frame, motion.omega_rad_s, error);
    lode_pll_correct_disturbance(&pll, t, estimator[ENHANCED].gains, error, 0.0f);
}

BLOCK(lag) {
    const lode_lag_line_t line =
        lode_lag_line(&tuning[ENHANCED].estimator.lag, BENCH_OMEGA_rad_s + input(call)->theta_rad);
    const lode_sincos_t lag = lode_lag_near(&line, BENCH_OMEGA_rad_s);
    bench_sink[0] = lag.sin;
    bench_sink[1] = lag.cos;
}

BLOCK(current) {
    const bench_inputs_t *in = input(call);
    const lode_dq_t i_A = {0.01f * in->i_A.alpha, BENCH_IQ_A};
    const lode_dq_t induced_V = lode_references_induced_V(&tuning[ENHANCED].references,
                                                          current.Lq_H, i_A, BENCH_OMEGA_rad_s);
    const lode_current_out_t out =
        lode_current_step(&current, &tuning[ENHANCED].current, (lode_dq_t){0.0f, BENCH_IQ_A}, i_A,
                          induced_V, BENCH_V_BUS_V);
    bench_sink[0] = out.u_V.d;
    bench_sink[1] = out.u_V.q;
}

BLOCK(speed) {
    bench_sink[0] =
        lode_speed_step(&speed, &tuning[ENHANCED].speed, BENCH_OMEGA_rad_s / BENCH_POLE_PAIRS,
                        BENCH_OMEGA_rad_s + 0.01f * input(call)->theta_rad, 1.2f);
}

BLOCK(references) {
    const lode_references_voltage_t voltage = {BENCH_V_BUS_V, {0.0f, 10.0f}};
    const lode_references_out_t ref = lode_references_step(
        &references, &tuning[ENHANCED].references, 1.2f + 0.01f * input(call)->theta_rad,
        BENCH_OMEGA_rad_s, 0.0f, voltage);
    bench_sink[0] = ref.i_A.d;
    bench_sink[1] = ref.i_A.q;
    bench_sink[2] = ref.torque_Nm.min;
    bench_sink[3] = ref.torque_Nm.max;
}

static void weaken(uint32_t call, int32_t n) {
    const float use_V = 0.9f * BENCH_V_BUS_V / LODE_SQRT3;
    const lode_references_voltage_t voltage = {BENCH_V_BUS_V, {-0.3f * use_V, 0.95f * use_V}};
    const lode_references_out_t ref =
        lode_references_step(&weak[n], &weak_tuning[n], 0.6f + 0.01f * input(call)->theta_rad,
                             1.1f * use_V / weak_tuning[n].psi_Wb, 0.0f, voltage);
    bench_sink[0] = ref.i_A.d;
    bench_sink[1] = ref.i_A.q;
    bench_sink[2] = ref.torque_Nm.min;
    bench_sink[3] = ref.torque_Nm.max;
}

BLOCK(references_mtpa) {
    weaken(call, 0);
}

BLOCK(references_weak_id0) {
    weaken(call, 1);
}

BLOCK(references_weak_mtpa) {
    weaken(call, 2);
}

BLOCK(modulator) {
    const bench_inputs_t *in = input(call);
    const lode_inverter_tuning_t *t = &tuning[ENHANCED].inverter;
    const lode_dead_time_t dead_time = {0.005f, 1.0f};
    const lode_ab_t v = lode_ab_scale(1.0f / BENCH_V_BUS_V, in->u_V);
    const lode_modulator_out_t m = lode_modulator_step(t, &dead_time, v, in->i_A, true);
    bench_sink[0] = m.duty.a;
    bench_sink[1] = m.duty.b;
    bench_sink[2] = m.duty.c;
    bench_sink[3] = m.realised.alpha;
    bench_sink[4] = m.realised.beta;
}

BLOCK(modulator6) {
    const bench_inputs_t *in = input(call);
    const lode_inverter_tuning_t *t = &tuning6.drive.inverter;
    const lode_dead_time_t dead_time = {0.005f, 1.0f};
    const lode_ab_t v = lode_ab_scale(1.0f / BENCH_V_BUS_V, in->u_V);
    const lode_modulator6_out_t m =
        lode_modulator6_step(t, &dead_time, (lode_sets_t){{v, v}}, in->i_A, true);
    bench_sink[0] = m.duty.set[0].a + m.duty.set[0].b + m.duty.set[0].c;
    bench_sink[1] = m.duty.set[1].a + m.duty.set[1].b + m.duty.set[1].c;
    bench_sink[2] = m.realised.set[0].alpha + m.realised.set[0].beta;
    bench_sink[3] = m.realised.set[1].alpha + m.realised.set[1].beta;
}

BLOCK(xy) {
    const bench_inputs_t *in = input(call);
    const lode_ab_t i_A = lode_ab_scale(0.001f, in->i_A);
    const lode_ab_t u_V = lode_xy_step(&xy, &tuning6.xy, i_A, BENCH_V_BUS_V);
    bench_sink[0] = u_V.alpha;
    bench_sink[1] = u_V.beta;
}

BLOCK(open_phase) {
    const lode_ab_t none = {0.0f, 0.0f};
    bench_sink[0] =
        lode_open_phase_doubts(&phases, &tuning6.watch, input(call)->i_A, none) ? 1.0f : 0.0f;
}

BLOCK(guard) {
    const lode_guard_tuning_t *t = &tuning[ENHANCED].guard;
    const lode_condition_t condition = {BENCH_V_BUS_V, 25.0f, BENCH_OMEGA_rad_s,
                                        estimate[ENHANCED].lock};
    sample.stamp = call * BENCH_STAMP_PER_PERIOD;
    const bool good =
        lode_guard_all_ok(&guard, t, &sample) && lode_guard_slow_ok(&guard, t, &condition, true);
    guard.stamp = sample.stamp;
    bench_sink[0] = good ? 1.0f : 0.0f;
}

BLOCK(start) {
    const bench_inputs_t *in = input(call);
    bench_sink[0] = lode_start_step(&start, &tuning[ENHANCED].start, in->u_V,
                                    tuning[ENHANCED].estimator.pll.ts_s);
}

BLOCK(sincos) {
    const lode_sincos_t s = lode_sincos(input(call)->theta_rad);
    bench_sink[0] = s.sin;
    bench_sink[1] = s.cos;
}

BLOCK(atan2) {
    const bench_inputs_t *in = input(call);
    bench_sink[0] = lode_atan2(in->u_V.beta, in->u_V.alpha);
}

BLOCK(pi) {
    const lode_pi_tuning_t *t = &tuning[ENHANCED].current.q;
    const float error = 0.01f * input(call)->theta_rad;
    const float unlimited = lode_pi_output(&pi, t, error, 9.0f);
    if (lode_abs(unlimited) <= 12.0f) {
        lode_pi_integrate(&pi, t, error);
    }
    bench_sink[0] = unlimited;
}

BLOCK(sogi) {
    const lode_sogi_out_t s = lode_sogi_step(&sogi, &sogi_tuning, input(call)->theta_rad);
    bench_sink[0] = s.notch;
    bench_sink[1] = s.in_phase;
    bench_sink[2] = s.quadrature;
}

BLOCK(clarke_park) {
    const bench_inputs_t *in = input(call);
    const lode_dq_t x =
        lode_park(lode_clarke((lode_abc_t){in->u_V.alpha, in->u_V.beta, in->i_A.alpha}), rotor);
    bench_sink[0] = x.d;
    bench_sink[1] = x.q;
}
