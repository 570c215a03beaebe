#include "lodestar/drive6.h"

#include "drive_inline.h"
#include "drive_slots_inline.h"
#include "modulator6_inline.h"
#include "open_phase_inline.h"
#include "xy_inline.h"

#include <stddef.h>

#define TELEMETRY_TRIES 3
// Set 2 is checked once per round, set 1 twice.
#define CHECKS_OF_SET_2 2.0f
#define STILL_MOST 255u
// Checks for which the currents of both sets have not moved (K36), when the first of them is found frozen. By chance a current
// does not move from one check to the next.
#define BOTH_REST 2u

static lode_active_t active_of(const lode_drive6_t *self) {
    return (lode_active_t)self->active;
}

// State of set 2 and of the xy plane with the gates off.
static LODE_NOINLINE void idle_set2(lode_drive6_t *self) {
    self->duty_2 = self->drive.duty;
    self->omitted_2 = self->drive.omitted;
    self->u_xy_V = (lode_ab_t){0.0f, 0.0f};
    lode_inverter_reset(&self->inverter_2);
    lode_xy_reset(&self->xy);
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_plausibility_reset(&self->plausibility_2);
    self->frozen_2.checks = 0u;
    self->still = 0u;
#endif
    lode_open_phase_reset(&self->watch);
}

// Drives both sets, or only the one that is left.
static void select_sets(lode_drive6_t *self, lode_active_t active) {
    self->active = (uint_least8_t)active;
    const lode_drive_tuning_t *tuning =
        active == LODE_SETS_BOTH ? &self->tuning->drive : &self->tuning->alone;
    self->drive.tuning = tuning;
    lode_current_take(&self->drive.current, &tuning->current, tuning->references.Lq_H);
}

static lode_words_t words_of(const lode_drive6_tuning_t *tuning) {
    return (lode_words_t){(const unsigned char *)tuning,
                          (uint32_t)(sizeof *tuning / sizeof(uint32_t))};
}

// All floats of the tuning are finite.
static bool is_finite(const lode_drive6_tuning_t *tuning) {
#ifdef LODE_WITHOUT_TUNING_CHECK
    (void)tuning;
    return true;
#else
    const size_t from = offsetof(lode_drive6_tuning_t, xy); // floats from here to `source`
    const size_t end = offsetof(lode_drive6_tuning_t, source);
    const lode_words_t own = {&((const unsigned char *)tuning)[from],
                              (uint32_t)((end - from) / sizeof(uint32_t))};
    return lode_tuning_is_finite(&tuning->drive) && lode_tuning_is_finite(&tuning->alone) &&
           lode_words_are_finite(own);
#endif
}

lode_status_t lode_drive6_begin(lode_drive6_t *self, const lode_drive6_tuning_t *tuning) {
    if (self == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    if (!is_finite(tuning)) {
        return LODE_ERROR_TUNING;
    }
    *self = (lode_drive6_t){.tuning = tuning};
    (void)lode_drive_begin(&self->drive, &tuning->drive);
    lode_tuning_post_check(&self->drive, words_of(tuning));
    lode_tuning_take_check(&self->drive);
    lode_sense_reset(&self->sense_2, &tuning->drive.sense);
    idle_set2(self);
    return LODE_OK;
}

lode_status_t lode_drive6_init(lode_drive6_t *self, lode_drive6_tuning_t *tuning,
                               const lode_drive6_config_t *config) {
    if (self == NULL) {
        return LODE_ERROR_NULL;
    }
    const lode_status_t status = lode_drive6_tune(tuning, config);
    return status == LODE_OK ? lode_drive6_begin(self, tuning) : status;
}

lode_status_t lode_drive6_post_tuning(lode_drive6_t *self, const lode_drive6_tuning_t *tuning) {
    if (self == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    if (!is_finite(tuning)) {
        return LODE_ERROR_TUNING;
    }
    LODE_SHARED_STORE(self->posted_tuning, NULL); // as lode_drive_post_tuning()
    LODE_SIGNAL_FENCE();
    lode_tuning_post_check(&self->drive, words_of(tuning));
    LODE_SIGNAL_FENCE();
    LODE_SHARED_STORE(self->posted_tuning, tuning);
    lode_drive_notify(&self->drive);
    return LODE_OK;
}

bool lode_drive6_tuning_taken(const lode_drive6_t *self) {
    LODE_SIGNAL_FENCE();
    return LODE_SHARED_LOAD(self->posted_tuning) == NULL;
}

bool lode_drive6_telemetry(const lode_drive6_t *self, lode_telemetry6_t *telemetry) {
    for (int32_t i = 0; i < TELEMETRY_TRIES; i++) {
        const bool whole = lode_drive_telemetry(&self->drive, &telemetry->drive);
        telemetry->duty_2 = self->duty_2;
        telemetry->i_xy_A = self->i_xy_A;
        telemetry->u_xy_V = self->u_xy_V;
        telemetry->active = active_of(self);
        telemetry->open = self->open;
        LODE_SIGNAL_FENCE();
        if (whole && telemetry->drive.steps == LODE_SHARED_LOAD(self->drive.steps)) {
            return true;
        }
    }
    return false;
}

static LODE_NOINLINE void take_mail(lode_drive6_t *self) {
    if (self->posted_tuning != NULL) {
        self->tuning = self->posted_tuning;
        lode_tuning_take_check(&self->drive);
        self->posted_tuning = NULL;
        const lode_drive_tuning_t *before = self->drive.tuning;
        select_sets(self, active_of(self));
        lode_mode_retune(&self->drive, before);
        const lode_sense_tuning_t *tuning = &self->tuning->drive.sense;
        self->omitted_2 = lode_sense_omit_both(lode_sense_omitted(tuning, self->duty_2));
        self->drive.omitted = lode_sense_omit_both(lode_sense_omitted(tuning, self->drive.duty));
    }
    const bool cleared = lode_mode_take_mail(&self->drive);
    // An open phase is forgotten (it may be repaired) when faults are cleared with the gates off.
    if ((cleared || lode_mode_clears_fault(&self->drive)) && !self->drive.gates) {
        self->open = 0u;
        select_sets(self, LODE_SETS_BOTH);
    }
}

// Calibrates both sets until both are done.
static lode_calibration_t calibrate(lode_drive6_t *self, const lode_sample6_t *sample,
                                    float *worst_count) {
    lode_drive_t *drive = &self->drive;
    const lode_sense_tuning_t *tuning = &drive->tuning->sense;
    if (drive->state.sums.samples == 0u) {
        lode_sense_begin(&self->sums_2);
    }
    float worst_1;
    float worst_2;
    const lode_calibration_t first =
        lode_sense_calibrate(&drive->sense, &drive->state.sums, tuning, &sample->machine, &worst_1);
    const lode_calibration_t second =
        lode_sense_calibrate(&self->sense_2, &self->sums_2, tuning, &sample->set_2, &worst_2);
    const bool of_2 = second > first || (second == first && second != LODE_CALIBRATION_STUCK &&
                                         lode_abs(worst_2) > lode_abs(worst_1));
    const float before = second == LODE_CALIBRATION_STUCK ? (float)LODE_PHASES : 0.0f;
    *worst_count = of_2 ? before + worst_2 : worst_1;
    return of_2 ? second : first;
}

// True: the estimator uses one set. Not in a start, which has little EMF and fails with 6 % of harmonics in one set, nor with
// injection, which acts in the alpha-beta plane of both.
LODE_INLINE bool sees_one_set(const lode_drive6_t *self) {
    return self->tuning->source != (uint_least16_t)LODE_SOURCE_VSD &&
           self->active == (uint_least8_t)LODE_SETS_BOTH &&
           lode_mode(&self->drive) == LODE_MODE_RUN &&
           !lode_estimator_injects(&self->drive.estimator);
}

// Without an array index, which would put both into memory.
LODE_INLINE lode_ab_t of_set(const lode_sets_t *sets, bool first) {
    return first ? (lode_ab_t){sets->set[0].alpha, sets->set[0].beta}
                 : (lode_ab_t){sets->set[1].alpha, sets->set[1].beta};
}

// Currents of both sets. Set 2's phases are 30 degrees ahead: its phase c lies along -beta, so alpha and beta exchange their
// gains.
LODE_INLINE lode_sets_t currents(const lode_sense_tuning_t *tuning, lode_ab_t i_1,
                                 const lode_sample_t *set_2) {
    const int32_t *i = set_2->i;
    const int32_t alpha = i[0] - i[1];
    const int32_t beta = i[0] + i[1] - 2 * i[2];
    return (lode_sets_t){
        {i_1, {(float)alpha * tuning->beta_gain, (float)beta * tuning->alpha_gain}}};
}

// The controlled current.
LODE_INLINE lode_ab_t controlled(const lode_drive6_t *self, const lode_sets_t *x) {
    if (self->active == (uint_least8_t)LODE_SETS_BOTH) {
        return lode_vsd_ab(*x);
    }
    return of_set(x, self->active == (uint_least8_t)LODE_SETS_ONLY_1);
}

// The guard's diagnosis of both sets, each with its own offsets. `i_1`: current of set 1.
static LODE_NOINLINE void diagnose(lode_drive6_t *self, const lode_counts6_t *counts,
                                   uint_least8_t omitted_1, uint_least8_t omitted_2,
                                   lode_ab_t i_1) {
    lode_drive_t *drive = &self->drive;
    const bool driven = drive->gates;
    lode_sample_t set_1;
    lode_sample_t set_2;
    lode_sense_again(&drive->sense, &counts->set[0], omitted_1, &set_1);
    lode_sense_again(&self->sense_2, &counts->set[1], omitted_2, &set_2);
    set_2.stamp = set_1.stamp;
    lode_drive_diagnose(drive, &drive->sense, &set_1, &drive->shorted);
    lode_drive_diagnose(drive, &self->sense_2, &set_2, &self->shorted_2);
    if (driven && !drive->gates) {
        const lode_sets_t i_A = currents(&drive->tuning->sense, i_1, &set_2);
        lode_mode_note_trip(drive, controlled(self, &i_A));
    }
}

// Converts the counts of both sets to current and voltage of the machine, and makes the guard's fast checks.
LODE_INLINE lode_sample6_t sense(lode_drive6_t *self, const lode_counts6_t *counts) {
    lode_drive_t *drive = &self->drive;
    const lode_sense_tuning_t *tuning = &drive->tuning->sense;
    lode_sample6_t x;
    x.machine = lode_sense_next(&drive->sense, tuning, &counts->set[0], &drive->omitted);
    x.set_2 = lode_sense_next(&self->sense_2, tuning, &counts->set[1], &self->omitted_2);
    if (!lode_guard_all_ok(&drive->guard, &drive->tuning->guard, &x.machine) || x.set_2.alert ||
        x.set_2.trip) {
        const lode_ab_t i_1 = {x.machine.i_A.alpha, x.machine.i_A.beta}; // as in drive.c
        diagnose(self, counts, x.machine.omitted, x.set_2.omitted, i_1);
    }
    lode_guard_note(&drive->guard, x.machine.stamp);
    x.i_A = currents(tuning, x.machine.i_A, &x.set_2);
    const lode_ab_t u_1 = lode_inverter_realised(&drive->inverter, drive->steps);
    const lode_ab_t u_2 =
        lode_ab_scale(drive->inverter.v_bus_V, self->inverter_2.written[drive->steps % 2u]);
    const lode_sets_t u_V = {{u_1, u_2}};
    lode_inverter_follow_bus(&drive->inverter, &drive->tuning->inverter, x.machine.v_bus_V);
    self->i_xy_A = lode_vsd_xy(x.i_A);
    const bool both = self->active == (uint_least8_t)LODE_SETS_BOTH;
    if (both) {
        x.machine.i_A = lode_vsd_ab(x.i_A);
        x.machine.u_V = lode_vsd_ab(u_V);
    } else {
        const bool first_alone = self->active == (uint_least8_t)LODE_SETS_ONLY_1;
        x.machine.i_A = of_set(&x.i_A, first_alone);
        x.machine.u_V = of_set(&u_V, first_alone);
        // Phase currents of the driven set. With the gates off those of set 1, for calibration.
        const bool of_1 = first_alone || !drive->gates;
        x.machine.i[0] = of_1 ? x.machine.i[0] : x.set_2.i[0];
        x.machine.i[1] = of_1 ? x.machine.i[1] : x.set_2.i[1];
        x.machine.i[2] = of_1 ? x.machine.i[2] : x.set_2.i[2];
    }
    x.u_seen_V = x.machine.u_V;
    x.i_seen_A = x.machine.i_A;
    if (sees_one_set(self)) {
        x.u_seen_V = of_set(&u_V, self->tuning->source == (uint_least16_t)LODE_SOURCE_SET_1);
        x.i_seen_A = of_set(&x.i_A, self->tuning->source == (uint_least16_t)LODE_SOURCE_SET_1);
    }
    x.u_seen_V = lode_inverter_less_drop(&drive->inverter, x.u_seen_V, drive->estimator.emf.i_A);
    return x;
}

// Angle and speed at t_k, and the controlled current in the rotor's frame.
LODE_INLINE lode_estimate_t estimate(lode_drive6_t *self, const lode_sample6_t *x) {
    lode_drive_t *drive = &self->drive;
    lode_estimate_t seen = lode_drive_find(drive, drive->tuning, x->u_seen_V, x->i_seen_A);
    if (!lode_estimator_injects(
            &drive->estimator)) { // with injection it is the machine's already, less the ripple
        seen.i_A = lode_park(x->machine.i_A, seen.rotor);
    }
    return seen;
}

// One set continues alone, with twice the current it had.
static LODE_NOINLINE void go_on_alone(lode_drive6_t *self, lode_active_t active, lode_ab_t i_A) {
    lode_drive_t *drive = &self->drive;
    const lode_drive_tuning_t *before = drive->tuning;
    const lode_sincos_t rotor = lode_estimator_rotor(&drive->estimator);
    select_sets(self, active);
    drive->steady = false; // the set's speed control may have another rate
    lode_mode_retune_ramp(drive, before);
    lode_estimator_retune(&drive->estimator, &before->estimator, &drive->tuning->estimator);
    lode_estimator_set_current(&drive->estimator, i_A);
    drive->i_A = lode_park(i_A, rotor);
    const float omega = drive->estimator.pll.omega_rad_s;
    lode_current_reset(&drive->current, drive->u_V,
                       lode_references_induced_V(&drive->tuning->references, drive->current.Lq_H,
                                                 drive->i_A, omega));
    lode_references_reset(&drive->state.run.references, drive->i_A.d);
    drive->ref_A = drive->i_A; // until SLOT_REFERENCES
    lode_xy_reset(&self->xy);
    self->u_xy_V = (lode_ab_t){0.0f, 0.0f};
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_plausibility_reset(&drive->plausibility);
    drive->frozen.checks = 0u; // they were set 1's
#endif
}

// `i_A`: current of the other set.
static LODE_NOINLINE void on_open_phase(lode_drive6_t *self, lode_open_phase_t open,
                                        lode_ab_t i_A) {
    self->open = open;
    // One set alone has too little saliency for injection, and cannot take over a start on its way.
    if (self->tuning->open_phase == (uint_least16_t)LODE_OPEN_PHASE_TRIP ||
        lode_mode(&self->drive) != LODE_MODE_RUN ||
        lode_estimator_injects(&self->drive.estimator)) {
        lode_mode_fault(&self->drive, LODE_CHECK_OPEN_PHASE, (float)open, 0.0f);
    } else {
        const bool in_1 = lode_open_phase_set(open) == 0;
        go_on_alone(self, in_1 ? LODE_SETS_ONLY_2 : LODE_SETS_ONLY_1, i_A);
    }
}

// Currents of the set, of the other set and of the alpha-beta plane. Passed by value: a sample passed by address would be kept
// in memory in every period.
static LODE_NOINLINE void check_phases(lode_drive6_t *self, int32_t set, lode_ab_t i_set_A,
                                       lode_ab_t i_other_A, lode_ab_t i_ab_A) {
    const float interval_s = (float)LODE_WATCH_PERIODS * self->drive.tuning->estimator.pll.ts_s;
    const lode_open_phase_t open =
        lode_open_phase_check(&self->watch, &self->tuning->watch, set, i_set_A, i_ab_A,
                              interval_s * lode_mode_frame_omega(&self->drive));
    if (open > 0u) {
        on_open_phase(self, open, i_other_A);
    }
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// The current vector of a set is frozen (K36). Without current it may be open, but not both sets at once.
static LODE_NOINLINE void on_frozen_set(lode_drive6_t *self, lode_open_phase_t set, lode_ab_t i_A,
                                        lode_ab_t i_other_A) {
    const lode_drive_tuning_t *tuning = &self->tuning->drive;
    const float none_A = (float)tuning->plausibility.i_still * tuning->sense.i_gain;
    const uint32_t checks_1 = self->drive.frozen.checks;
    const uint32_t checks_2 = self->frozen_2.checks;
    if (checks_1 >= BOTH_REST && checks_2 >= BOTH_REST) {
        lode_mode_fault(&self->drive, LODE_CHECK_CURRENT_STUCK, 0.0f, 0.0f);
    } else if (lode_ab_length2(i_A) > none_A * none_A) {
        lode_mode_fault(&self->drive, LODE_CHECK_CURRENT_STUCK, (float)set, 0.0f);
    } else if (self->tuning->open_phase != (uint_least16_t)LODE_OPEN_PHASE_IGNORE) {
        on_open_phase(self, set, i_other_A);
    } else {
        // to be ignored
    }
}

// Once per round and set. True: it is frozen.
LODE_INLINE bool finds_frozen(lode_drive6_t *self, const lode_sample6_t *x, bool second) {
    lode_frozen_t *frozen = second ? &self->frozen_2 : &self->drive.frozen;
    const lode_ab_t i_A = of_set(&x->i_A, !second);
    if (!lode_drive_is_frozen(&self->drive, self->drive.tuning, frozen, i_A)) {
        return false;
    }
    on_frozen_set(self, second ? LODE_OPEN_SET_2 : LODE_OPEN_SET_1, i_A, of_set(&x->i_A, second));
    return true;
}

#else

LODE_INLINE bool finds_frozen(lode_drive6_t *self, const lode_sample6_t *x, bool second) {
    (void)self;
    (void)x;
    (void)second;
    return false;
}

#endif

LODE_INLINE void watch_phases(lode_drive6_t *self, const lode_sample6_t *x, bool second) {
    if (self->tuning->open_phase != (uint_least16_t)LODE_OPEN_PHASE_IGNORE &&
        lode_open_phase_doubts(&self->watch, &self->tuning->watch, x->machine.i_A, self->i_xy_A)) {
        const lode_ab_t i_ab_A = {x->machine.i_A.alpha, x->machine.i_A.beta};
        check_phases(self, second ? 1 : 0, of_set(&x->i_A, !second), of_set(&x->i_A, second),
                     i_ab_A);
    }
}

// While both are driven: set 1 in SLOT_LOCK and SLOT_GAINS, set 2 in SLOT_DEAD_TIME and SLOT_REFERENCES, and for (K36) once per
// round each.
LODE_INLINE void watch_sets(lode_drive6_t *self, const lode_sample6_t *x, lode_slot_t slot) {
    const uint32_t turn = (uint32_t)slot % LODE_WATCH_PERIODS;
    const bool second = turn == 3u;
    if ((turn != 0u && !second) || self->active != (uint_least8_t)LODE_SETS_BOTH) {
        return;
    }
    const bool once = slot == SLOT_LOCK || slot == SLOT_REFERENCES;
    if (!once || !finds_frozen(self, x, second)) {
        watch_phases(self, x, second);
    }
}

// Voltages of both sets per bus volt while the duties act. `u_V`: voltage of the machine, in the frame of control.
LODE_INLINE lode_sets_t voltages(lode_drive6_t *self, const lode_frame_t *frame, lode_dq_t u_V,
                                 float v_bus_V) {
    lode_ab_t xy = {0.0f, 0.0f};
    if (self->active == (uint_least8_t)LODE_SETS_BOTH) {
        self->u_xy_V = lode_xy_step(&self->xy, &self->tuning->xy,
                                    lode_ab_rotate(self->i_xy_A, frame->at), v_bus_V);
        const lode_dq_t rotated = lode_park(self->u_xy_V, frame->applied);
        xy = (lode_ab_t){rotated.d, rotated.q};
    }
    const float per_V = self->drive.inverter.per_V;
    const lode_ab_t ab = lode_park_inverse(u_V, frame->applied);
    return lode_vsd_sets(lode_ab_scale(per_V, ab), lode_ab_scale(per_V, xy));
}

LODE_INLINE lode_abc6_t modulate(lode_drive6_t *self, const lode_frame_t *frame, float v_bus_V,
                                 bool free) {
    lode_drive_t *drive = &self->drive;
    const lode_drive_tuning_t *tuning = drive->tuning;
    const lode_demand_t demand = lode_drive_demand(drive, tuning, frame);
    const lode_sets_t v = voltages(self, frame, demand.u_V, v_bus_V);
    const lode_ab_t i_A = lode_park_inverse(demand.i_A, frame->applied);
    const lode_modulator6_out_t out =
        lode_modulator6_step(&tuning->inverter, &drive->inverter.dead_time, v, i_A, free);
    lode_inverter_write(&drive->inverter, drive->steps, out.realised.set[0]);
    lode_inverter_write(&self->inverter_2, drive->steps, out.realised.set[1]);
    drive->duty = out.duty.set[0];
    self->duty_2 = out.duty.set[1];
    return out.duty;
}

// Both sets begin at the rotor's EMF if a turning rotor was found, else at zero.
static LODE_NOINLINE void begin_set2(lode_drive6_t *self) {
    const lode_ab_t *emf = self->drive.inverter.written;
    self->inverter_2.written[0] = emf[0];
    self->inverter_2.written[1] = emf[1];
    self->duty_2 = lode_mode_duties_at(lode_set2_clarke_inverse(emf[self->drive.steps % 2u]));
}

// The signal check has reached set 2.
static bool checks_set2(const lode_drive6_t *self) {
#ifdef LODE_WITHOUT_SIGNAL_CHECK
    (void)self;
    return false;
#else
    return lode_mode_checks_signals(&self->drive) &&
           (uint32_t)self->drive.state.precharge.by.check.pulse >= LODE_SIGNAL_PULSES;
#endif
}

// The signal check drives one set at a time; the other one has no voltage.
static void check_set2(lode_drive6_t *self) {
    lode_drive_t *drive = &self->drive;
    const lode_abc_t none = {LODE_DUTY_IDLE, LODE_DUTY_IDLE, LODE_DUTY_IDLE};
    if (checks_set2(self)) {
        drive->duty = none; // the pulses are set 2's
    } else if (lode_mode_checks_signals(drive)) {
        self->duty_2 = none;
    } else {
        // no check: both sets have the same duties
    }
}

// End of a period with all gates off, or with only the low sides on.
static LODE_NOINLINE lode_drive6_out_t end_idle(lode_drive6_t *self) {
    lode_drive_t *drive = &self->drive;
    idle_set2(self);
    check_set2(self);
    if (drive->gates) { // from the next period on
        begin_set2(self);
    }
    drive->steps++;
    return (lode_drive6_out_t){
        {lode_mode_idle_out(drive, &drive->duty), lode_mode_idle_out(drive, &self->duty_2)}};
}

// A whole period with the gates off. The voltage at open terminals is unknown, so nothing is estimated.
static LODE_NOINLINE lode_drive6_out_t idle(lode_drive6_t *self, const lode_sample6_t *sample) {
    lode_drive_t *drive = &self->drive;
    lode_calibration_t calibration = LODE_CALIBRATION_RUNNING;
    float worst_count = 0.0f;
    if (lode_mode(drive) == LODE_MODE_CALIBRATE) {
        calibration = calibrate(self, sample, &worst_count);
    }
    const lode_sense_tuning_t *tuning = &drive->tuning->sense;
    drive->temperature =
        lode_sense_hotter(tuning, sample->machine.temperature, sample->set_2.temperature);
    if (drive->mail && !drive->guard.fresh) { // a fault is told for a period at least
        take_mail(self);
    }
    if (drive->guard.fresh) {
        drive->shorted = (lode_shorted_t){.periods = 0u};
        self->shorted_2 = (lode_shorted_t){.periods = 0u};
        drive->guard.fresh = false;
    }
    const lode_sample_t *idle = checks_set2(self) ? &sample->set_2 : &sample->machine;
    lode_mode_idle(drive, words_of(self->tuning), idle, calibration, worst_count);
    return end_idle(self);
}

static LODE_NOINLINE lode_drive6_out_t idle_period(lode_drive6_t *self,
                                                   const lode_counts6_t *counts,
                                                   uint_least8_t omitted_1, uint_least8_t omitted_2,
                                                   lode_ab_t i_A) {
    lode_sample6_t sample;
    lode_sense_again(&self->drive.sense, &counts->set[0], omitted_1, &sample.machine);
    lode_sense_again(&self->sense_2, &counts->set[1], omitted_2, &sample.set_2);
    sample.machine.i_A = i_A; // of both sets: harmonics of the EMF drive current in the xy plane
    sample.set_2.i_A = i_A;
    return idle(self, &sample);
}

LODE_INLINE lode_gates_t gates_if(bool driven) {
    return driven ? LODE_GATES_ON : LODE_GATES_OFF;
}

// Last check of the duties, whichever mode made them.
LODE_INLINE bool accept(lode_drive6_t *self, lode_abc6_t duty) {
    lode_drive_t *drive = &self->drive;
    const float most = drive->tuning->sense.duty_max;
    if (!lode_modulator_is_within(duty.set[0], most) &&
        !lode_drive_accept(drive, &drive->omitted, &drive->duty)) {
        return false;
    }
    return lode_modulator_is_within(duty.set[1], most) ||
           lode_drive_accept(drive, &self->omitted_2, &self->duty_2);
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// No count of both sets has changed at the last check.
static bool all_rest(const lode_drive6_t *self) {
    return (self->drive.plausibility.kept & self->plausibility_2.kept) == LODE_ALL_PHASES;
}

// Both sets have kept all their counts at two checks. In one set alone that may be open phases, whose counts stay near zero.
static LODE_NOINLINE void count_still(lode_drive6_t *self) {
    lode_drive_t *drive = &self->drive;
    const lode_drive_tuning_t *tuning = drive->tuning;
    const float round_s = (float)LODE_SLOW_PERIODS * tuning->estimator.pll.ts_s;
    const lode_dq_t ref_A = drive->ref_A;
    const float turn_rad = (float)self->still * round_s * lode_mode_frame_omega(drive);
    if (lode_mode(drive) == LODE_MODE_RUN && lode_plausibility_has_stuck(&tuning->plausibility) &&
        lode_plausibility_none_flows(&tuning->plausibility, ref_A.d * ref_A.d + ref_A.q * ref_A.q,
                                     turn_rad, lode_abs(tuning->sense.i_gain))) {
        lode_mode_fault(drive, LODE_CHECK_CURRENT_STUCK, 0.0f, 0.0f);
    }
    self->still = (uint_least8_t)(self->still < STILL_MOST ? self->still + 1u : STILL_MOST);
}

// Set 2 has the counts of its last check, some periods ago.
LODE_INLINE bool set2_rests(const lode_drive6_t *self, const lode_sample_t *set_2) {
    const int32_t *last = self->plausibility_2.i;
    const int32_t *now = set_2->i;
    return lode_plausibility_phases(now[0] == last[0], now[1] == last[1], now[2] == last[2]) ==
           LODE_ALL_PHASES;
}

// Numbers what is stuck. Where set 2 runs alone its currents are in the place of set 1's.
static LODE_NOINLINE void name_stuck(lode_drive6_t *self, bool rests_2, lode_slot_t slot) {
    lode_fault_t *fault = &self->drive.guard.fault;
    if (fault->check != (uint_least8_t)LODE_CHECK_CURRENT_STUCK) {
        return;
    }
    const bool phase = lode_in_range(fault->measured, 1.0f, (float)LODE_SETS * (float)LODE_PHASES);
    if (self->active == (uint_least8_t)LODE_SETS_ONLY_2) {
        fault->measured += phase ? (float)LODE_PHASES : 0.0f;
    } else if (self->active == (uint_least8_t)LODE_SETS_BOTH) {
        const bool of_1 = slot == SLOT_GUARD || slot == SLOT_GUARD_2; // the checks of its counts
        const float number = of_1 && !phase ? (float)LODE_OPEN_SET_1 : fault->measured;
        const bool rests_1 = self->drive.plausibility.kept == LODE_ALL_PHASES;
        fault->measured = rests_1 && rests_2 ? 0.0f : number;
    } else {
        // set 1 alone
    }
}

#else

LODE_INLINE bool set2_rests(const lode_drive6_t *self, const lode_sample_t *set_2) {
    (void)self;
    (void)set_2;
    return false;
}

static void name_stuck(const lode_drive6_t *self, bool rests_2, lode_slot_t slot) {
    (void)self;
    (void)rests_2;
    (void)slot;
}

#endif

// In SLOT_REFERENCES. Set 1 is checked with the guard.
LODE_INLINE void watch_set2(lode_drive6_t *self, const lode_sample_t *set_2) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)set_2;
#else
    if (self->active != (uint_least8_t)LODE_SETS_BOTH) {
        return;
    }
    lode_drive_watch(&self->drive, self->drive.tuning, &self->plausibility_2, set_2->i,
                     CHECKS_OF_SET_2);
    if (all_rest(self)) {
        count_still(self);
    } else {
        self->still = 0u;
    }
#endif
}

// From angle and speed to duties.
LODE_INLINE lode_drive6_out_t act(lode_drive6_t *self, const lode_sample6_t *sample,
                                  const lode_estimate_t *estimate) {
    lode_drive_t *drive = &self->drive;
    lode_frame_t frame = lode_drive_rotor_frame(drive, estimate);
    drive->i_A = frame.i_A;
    bool given = false;
    if (!lode_drive_is_steady(drive)) {
        if (drive->mail) {
            take_mail(self);
        }
        lode_mode_follow(drive);
        if (!drive->gates || !lode_drive_jump_ok(drive)) {
            return end_idle(self);
        }
        given = lode_drive_by_mode(drive, &sample->machine, &frame);
    }
    const float left_V = lode_drive_left_V(drive, sample->machine.v_bus_V);
    const bool free = lode_drive_control(drive, drive->tuning, &frame, left_V, given);
    const lode_abc6_t duty = modulate(self, &frame, sample->machine.v_bus_V, free);
    if (!accept(self, duty)) {
        return end_idle(self);
    }
    const lode_slot_t slot = lode_slot_of(drive->steps);
    const bool both = self->active == (uint_least8_t)LODE_SETS_BOTH;
    if (slot == SLOT_LAG) {
        lode_xy_adapt(&self->xy, &self->tuning->xy, lode_mode_frame_omega(drive));
    }
    watch_sets(self, sample, slot);
    if (slot == SLOT_REFERENCES) {
        watch_set2(self, &sample->set_2);
    }
    (void)lode_drive_slow_job(drive, drive->tuning, words_of(self->tuning), &sample->machine,
                              sample->set_2.temperature, !both, slot);
    if (!LODE_USUALLY(drive->gates)) {
        name_stuck(self, set2_rests(self, &sample->set_2), slot);
        return end_idle(self);
    }
    drive->steps++;
    return (lode_drive6_out_t){
        {{duty.set[0], gates_if(self->active != (uint_least8_t)LODE_SETS_ONLY_2)},
         {duty.set[1], gates_if(self->active != (uint_least8_t)LODE_SETS_ONLY_1)}}};
}

lode_sample6_t lode_drive6_sense(lode_drive6_t *self, const lode_counts6_t *counts) {
    return sense(self, counts);
}

lode_estimate_t lode_drive6_estimate(lode_drive6_t *self, const lode_sample6_t *sample) {
    return self->drive.gates ? estimate(self, sample) : lode_mode_estimate(&self->drive);
}

lode_drive6_out_t lode_drive6_act(lode_drive6_t *self, const lode_sample6_t *sample,
                                  const lode_estimate_t *estimate) {
    lode_mode_adopt(&self->drive, estimate);
    return self->drive.gates ? act(self, sample, estimate) : idle(self, sample);
}

LODE_RAMFUNC lode_drive6_out_t lode_drive6_step(lode_drive6_t *self, const lode_counts6_t *counts) {
    const lode_sample6_t sample = sense(self, counts);
    if (!lode_drive_is_steady(&self->drive) && !self->drive.gates) {
        return idle_period(self, counts, sample.machine.omitted, sample.set_2.omitted,
                           sample.machine.i_A);
    }
    const lode_estimate_t rotor = estimate(self, &sample);
    return act(self, &sample, &rotor);
}
