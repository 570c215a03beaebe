#include "rig/fault_case.h"

#include <math.h>

#include "config/refusal.h"
#include "config/speed_limits.h"
#include "support/diag.h"
#include "support/units.h"

#define HOLD_s 0.01
#define RECUR_s 0.05 // window in which a phase current may be beyond its limit for HOLD_s
#define LONG_s 0.1   // beyond the limit in a start attempt that was given up
#define SPEED_HOLD_s 0.1
#define LOST_rad (60.0 * RIG_PI / 180.0)
#define CURRENT_SHARE 1.2
#define CONTROL_SHARE 0.3
#define SPEED_SHARE 0.1
#define HEAT_K 10.0
#define AFTER_s 0.02 // observation time after a fault was found
#define RUN_s 1.0    // observation time of a fault while the drive runs
#define START_s 3.0  // observation time of a fault before or in the start, plus its time-out
#define REACH_s 30.0 // time limit for reaching a state without a fault
#define SETTLE_s 0.6
#define LOAD_RAMP_s 1.0
#define SETTLED_SHARE 0.06 // allows for the speed ripple by EMF harmonics
#define LOAD_SHARE 0.3     // of the torque of i_max
#define LITTLE_SHARE 0.1
#define FULL_SHARE 0.85  // largest share of the base speed: leaves voltage for control
#define WEAK_SHARE 0.5   // of the way from the base speed to the weakened limit
#define WEAK_MOST 1.5    // times the base speed
#define LEAST_SHARE 1.25 // of the least speed

const char *const fault_point_name[FAULT_POINTS] = {"standstill", "start", "10 %",
                                                    "50 %",       "100 %", "weakening"};

// ---- The states that faults begin from ----------------------------------------------------------

typedef struct {
    rig_t *rig;
    inject_t nothing;
    plant_truth_t truth;
} reach_t;

static void command(rig_t *rig, double speed_rad_s) {
    const lode_command_t go = {.mode = LODE_MODE_RUN, .speed_rad_s = (float)speed_rad_s};
    (void)lode_drive_post_command(rig->drive, &go);
}

static bool runs(const rig_t *rig) {
    return rig->drive->mode == (uint_least8_t)LODE_MODE_RUN;
}

/// Runs until the speed has settled at `speed_rad_s`.
static bool reach_speed(reach_t *self, double speed_rad_s) {
    double settled_s = 0.0;
    command(self->rig, speed_rad_s);
    for (double t_s = 0.0; t_s < REACH_s && settled_s < SETTLE_s; t_s += self->nothing.ts_s) {
        inject_step(&self->nothing, self->rig, &self->truth);
        const double off = fabs(self->truth.omega_m_rad_s - speed_rad_s);
        const bool settled = runs(self->rig) && off < SETTLED_SHARE * speed_rad_s;
        settled_s = settled ? settled_s + self->nothing.ts_s : 0.0;
    }
    return settled_s >= SETTLE_s;
}

/// Slowly, because a step would be another test.
static void load_with(reach_t *self, double load_Nm) {
    const double from_Nm = self->rig->plant.motor.load_Nm;
    for (double t_s = 0.0; t_s < LOAD_RAMP_s; t_s += self->nothing.ts_s) {
        plant_set_load(&self->rig->plant, from_Nm + (load_Nm - from_Nm) * t_s / LOAD_RAMP_s);
        inject_step(&self->nothing, self->rig, &self->truth);
    }
}

/// Runs to the middle of the start: of its ramp, or with injection from the search for the axis to that for the polarity.
static bool reach_start(reach_t *self, double handover_rad_s) {
    const lode_drive_t *drive = self->rig->drive;
    for (double t_s = 0.0; t_s < REACH_s; t_s += self->nothing.ts_s) {
        inject_step(&self->nothing, self->rig, &self->truth);
        const bool searched = drive->estimator.by.hfi.active &&
                              drive->estimator.by.hfi.step != (uint_least8_t)LODE_HFI_FIND;
        if (searched || self->truth.omega_e_rad_s > 0.4 * handover_rad_s) {
            return drive->mode == (uint_least8_t)LODE_MODE_START;
        }
    }
    return false;
}

static bool refuse(const fault_bench_t *self, fault_point_t point) {
    rig_error_at(self->config.file[0], 0,
                 "faults: expected a drive that reaches the state '%s' without a fault",
                 fault_point_name[point]);
    return false;
}

/// Share of the torque of i_max. In field weakening the power is that of the base speed, if a share is given;
/// otherwise it is small there, and where the EMF is low.
static double load_of(const fault_bench_t *self, fault_point_t point) {
    const bool weak = point == FAULT_AT_WEAKENING;
    if (isnan(self->load_share)) {
        return weak || point == FAULT_AT_10 ? LITTLE_SHARE : LOAD_SHARE;
    }
    return weak ? self->load_share * self->base_rad_s / self->speed_rad_s[point] : self->load_share;
}

static bool reach_all(fault_bench_t *self) {
    const double *speed_rad_s = self->speed_rad_s;
    rig_t *rig = &self->at[FAULT_AT_STANDSTILL];
    if (rig_init(rig, &self->config, &self->plant) != LODE_OK) {
        return false;
    }
    reach_t reach = {.rig = &self->at[FAULT_AT_START]};
    const inject_place_t nowhere = {.leg = 0};
    inject_init(&reach.nothing, &inject_kinds[0], nowhere, &self->config, &self->plant, 0);
    rig_copy(reach.rig, rig);
    command(reach.rig, speed_rad_s[FAULT_AT_10]);
    if (!reach_start(&reach, (double)self->config.drive.start.omega_handover_rad_s)) {
        return refuse(self, FAULT_AT_START);
    }
    const double torque_Nm = reach.nothing.torque_Nm;
    for (int point = FAULT_AT_10; point < FAULT_POINTS; ++point) {
        rig_copy(&self->at[point], reach.rig);
        reach.rig = &self->at[point];
        const double share = load_of(self, (fault_point_t)point);
        const bool there =
            reach_speed(&reach, speed_rad_s[point == FAULT_AT_WEAKENING ? FAULT_AT_100 : point]);
        load_with(&reach, share * torque_Nm);
        self->left_out[point] = !there || !reach_speed(&reach, speed_rad_s[point]);
        if (self->left_out[point] && !runs(reach.rig)) {
            return refuse(self, (fault_point_t)point);
        }
    }
    return true;
}

bool fault_bench_init(fault_bench_t *self, const rig_config_t *config, double load_share) {
    double unused_Nm = 0.0;
    self->config = *config;
    self->load_share = load_share;
    if (!rig_config_plant(config, &self->plant, &unused_Nm)) {
        return false;
    }
    const speed_limits_t limits = speed_limits_of(&config->drive);
    const double np = (double)config->drive.motor.pole_pairs;
    const double full =
        fmin((double)config->drive.motor.omega_rated_rad_s, FULL_SHARE * limits.base_rad_s);
    const double most = fmin(fmin(WEAK_MOST * limits.base_rad_s, limits.estimator_rad_s),
                             isnan(limits.weakened_rad_s) ? HUGE_VAL : limits.weakened_rad_s);
    const double weak = limits.base_rad_s + WEAK_SHARE * (most - limits.base_rad_s);
    self->full_rad_s = full / np;
    self->base_rad_s = limits.base_rad_s / np;
    self->speed_rad_s[FAULT_AT_10] = fmax(0.1 * full, LEAST_SHARE * limits.least_rad_s) / np;
    self->speed_rad_s[FAULT_AT_50] = fmax(0.5 * full / np, self->speed_rad_s[FAULT_AT_10]);
    self->speed_rad_s[FAULT_AT_100] = full / np;
    self->speed_rad_s[FAULT_AT_WEAKENING] = weak / np;
    return reach_all(self);
}

// ---- One case -----------------------------------------------------------------------------------

enum { WINDOW = 8192 }; // periods

/// The last RECUR_s: in which periods a phase current was beyond 1.2 i_max.
typedef struct {
    bool beyond[WINDOW];
    int at, periods; ///< oldest; how many there are
    int count;       ///< of those beyond
} window_t;

/// How long each harm has lasted, in this attempt of the start.
typedef struct {
    double rotor_s, current_s, control_s, speed_s, heat_s;
    double over_s; ///< beyond 1.2 i_max, not in one piece
    window_t phase;
    uint_least8_t losses; ///< of the drive, before this period
} lasting_t;

static double held(double since_s, bool bad, double ts_s) {
    return bad ? since_s + ts_s : 0.0;
}

/// Time beyond within the window that ends now.
static double recurred(window_t *window, bool beyond, double ts_s) {
    window->count += (beyond ? 1 : 0) - (window->beyond[window->at] ? 1 : 0);
    window->beyond[window->at] = beyond;
    window->at = (window->at + 1) % window->periods;
    return window->count * ts_s;
}

static lasting_t nothing_yet(const lode_drive_t *drive, double ts_s) {
    return (lasting_t){.losses = drive->losses,
                       .phase = {.periods = (int)fmin(WINDOW, ceil(RECUR_s / ts_s))}};
}

static double largest_A(const plant_truth_t *truth) {
    double most = 0.0;
    for (int n = 0; n < PLANT_LEGS; ++n) {
        most = fmax(most, fabs(truth->i_abc_A[n]));
    }
    return most;
}

/// The longest current vector of a winding set: an amplitude that does not depend on the momentary phase currents.
static double longest_A(const plant_truth_t *truth) {
    double most_A2 = 0.0;
    for (int leg = 0; leg < PLANT_LEGS; leg += 3) {
        const double *i = truth->i_abc_A + leg;
        most_A2 = fmax(most_A2, 2.0 / 3.0 * (i[0] * i[0] + i[1] * i[1] + i[2] * i[2]));
    }
    return sqrt(most_A2);
}

/// Distance of a current from the direction of its reference, or beyond i_max in it. A current below its
/// reference makes less torque, as any limit does. One above it, but within i_max, makes more torque, as a load
/// that drops does: speed control corrects it, or the speed shows it.
static double beyond_A(lode_dq_t ref_A, double i_max_A, double id_A, double iq_A) {
    const double d_A = (double)ref_A.d;
    const double q_A = (double)ref_A.q;
    const double length_A = fmax(hypot(d_A, q_A), 1e-6);
    const double along_A = fmax(0.0, fmin(i_max_A, (id_A * d_A + iq_A * q_A) / length_A));
    return hypot(id_A - along_A * d_A / length_A, iq_A - along_A * q_A / length_A);
}

static int harm_now(const fault_bench_t *self, const rig_t *rig, fault_point_t point,
                    const plant_truth_t *truth, lasting_t *last) {
    const lode_drive_t *drive = rig->drive;
    const double ts_s = self->plant.period_s;
    const double i_max = (double)self->config.drive.inverter.i_max_A;
    const bool driven = runs(rig) && drive->gates;
    const double off_rad = remainder(
        (double)lode_estimator_theta_rad(&drive->estimator) - truth->theta_e_rad, 2.0 * RIG_PI);
    const double off_A = beyond_A(drive->ref_A, i_max, truth->id_A, truth->iq_A);
    const bool running = point >= FAULT_AT_10 && point < FAULT_POINTS;
    const double wanted_rad_s =
        running ? self->speed_rad_s[point] : (double)lode_drive_speed_ref_rad_s(drive);
    const double off_rad_s = fabs(truth->omega_m_rad_s - wanted_rad_s);
    const double limit_degC = (double)self->config.drive.guard.temperature_max_degC;
    const bool is_long = longest_A(truth) > CURRENT_SHARE * i_max;
    const bool is_large = largest_A(truth) > CURRENT_SHARE * i_max;
    const bool recurs = recurred(&last->phase, is_large, ts_s) >= HOLD_s;
    last->over_s += is_long || is_large ? ts_s : 0.0;
    last->rotor_s = held(last->rotor_s, driven && fabs(off_rad) > LOST_rad, ts_s);
    last->current_s = held(last->current_s, is_long, ts_s);
    last->control_s = held(last->control_s, driven && off_A > CONTROL_SHARE * i_max, ts_s);
    last->speed_s = held(last->speed_s, driven && off_rad_s > SPEED_SHARE * self->full_rad_s, ts_s);
    last->heat_s = held(last->heat_s, rig->plant.temperature_degC > limit_degC + HEAT_K, ts_s);
    return (last->rotor_s >= HOLD_s ? FAULT_HARM_ROTOR : 0) |
           (last->current_s >= HOLD_s || recurs ? FAULT_HARM_CURRENT : 0) |
           (last->control_s >= HOLD_s ? FAULT_HARM_CONTROL : 0) |
           (last->speed_s >= SPEED_HOLD_s ? FAULT_HARM_DIP : 0) |
           (last->heat_s >= HOLD_s ? FAULT_HARM_HEAT : 0);
}

/// One period before a fault was found.
static void watch(const fault_bench_t *self, const rig_t *rig, fault_point_t point,
                  const plant_truth_t *truth, lasting_t *last, fault_result_t *result) {
    const double before_s = last->over_s;
    result->harm |= harm_now(self, rig, point, truth, last);
    result->over_s += last->over_s - before_s;
    if (rig->drive->losses >
        last->losses) { // a start attempt was given up, which telemetry reports
        result->harm &= FAULT_HARM_DIP | (last->over_s > LONG_s ? FAULT_HARM_CURRENT : 0);
        result->given_up++;
        *last = nothing_yet(rig->drive, self->plant.period_s);
    }
    last->losses = rig->drive->losses;
}

static void note_fault(const rig_t *rig, double t_s, fault_result_t *result) {
    if (rig->drive->guard.fault.check != (uint_least8_t)LODE_CHECK_NONE) {
        result->found = (lode_check_t)rig->drive->guard.fault.check;
        result->found_s = t_s;
    }
}

/// The observation time. A drive that is not in RUN at its end is being started again.
static bool is_over(const fault_result_t *result, fault_point_t point, double t_s, double start_s,
                    bool runs_now, double ran_s) {
    const bool watched = point >= FAULT_AT_10 ? t_s > RUN_s && runs_now : ran_s > RUN_s;
    return watched || t_s >= start_s || t_s > result->found_s + AFTER_s;
}

static fault_result_t run_one(const fault_bench_t *self, const inject_t *fault,
                              fault_point_t point) {
    static rig_t rig;      // large
    static lasting_t last; // large
    const double ts_s = self->plant.period_s;
    fault_result_t result = {.found = LODE_CHECK_NONE, .found_s = NAN, .tried = 1};
    inject_t inject = *fault;
    double turned_rad = 0.0;
    double ran_s = 0.0;
    rig_copy(&rig, &self->at[point]);
    last = nothing_yet(rig.drive, ts_s);
    if (point <= FAULT_AT_START) {
        command(&rig, self->speed_rad_s[FAULT_AT_50]);
    }
    const double start_s = START_s + 2.0 * (double)self->config.drive.start.timeout_s;
    for (double t_s = 0.0; !is_over(&result, point, t_s, start_s, runs(&rig), ran_s); t_s += ts_s) {
        plant_truth_t truth;
        inject_step(&inject, &rig, &truth);
        result.peak_A = fmax(result.peak_A, largest_A(&truth));
        turned_rad += ts_s * truth.omega_m_rad_s;
        result.back_deg = fmax(result.back_deg, -rig_deg_from_rad(turned_rad));
        if (isnan(result.found_s)) {
            watch(self, &rig, point, &truth, &last, &result);
            note_fault(&rig, t_s + ts_s, &result);
        }
        ran_s = runs(&rig) ? ran_s + ts_s : 0.0;
    }
    result.named = (lode_check_t)rig.drive->guard.fault.check;
    if (isnan(result.found_s) && !runs(&rig)) {
        result.harm |= FAULT_HARM_STUCK;
    }
    if (isnan(result.found_s) && last.speed_s >= SPEED_HOLD_s) {
        result.harm |= FAULT_HARM_SPEED;
    }
    result.silent = fault_is_silent(&result) ? 1 : 0;
    return result;
}

bool fault_is_silent(const fault_result_t *result) {
    return result->silent > 0 ||
           (result->found == LODE_CHECK_NONE && (result->harm & ~FAULT_HARM_DIP) != 0);
}

/// The worse of two results: silent, then found later, then harmless.
static bool is_worse(const fault_result_t *a, const fault_result_t *b) {
    if ((a->silent > 0) != (b->silent > 0)) {
        return a->silent > 0;
    }
    return isnan(b->found_s) ? !isnan(a->found_s) : a->found_s > b->found_s;
}

fault_result_t fault_case_both(const fault_result_t *a, const fault_result_t *b) {
    fault_result_t worst = is_worse(b, a) ? *b : *a;
    worst.tried = a->tried + b->tried;
    worst.silent = a->silent + b->silent;
    return worst;
}

#define FLIPS 16

fault_result_t fault_case_run(const fault_bench_t *self, const inject_kind_t *kind,
                              inject_place_t place, fault_point_t point, uint64_t seed) {
    inject_t fault;
    inject_init(&fault, kind, place, &self->config, &self->plant, seed * FLIPS);
    fault_result_t worst = run_one(self, &fault, point);
    const uint64_t tries = inject_is_random(kind) ? FLIPS : 1u;
    for (uint64_t k = 1u; k < tries; ++k) {
        fault.seed = seed * FLIPS + k;
        const fault_result_t one = run_one(self, &fault, point);
        worst = fault_case_both(&worst, &one);
    }
    return worst;
}

fault_result_t fault_case_bits(const fault_bench_t *self, const inject_kind_t *kind,
                               fault_point_t point, uint64_t first, uint64_t last,
                               uint64_t *silent) {
    const inject_place_t nowhere = {.leg = 0};
    fault_result_t worst = {.tried = 0};
    inject_t fault;
    inject_init(&fault, kind, nowhere, &self->config, &self->plant, 0u);
    *silent = 0u;
    for (uint64_t n = 0u; n < FAULT_BITS_MAX && first + n <= last; ++n) {
        fault.bit = first + n;
        const fault_result_t one = run_one(self, &fault, point);
        worst = n == 0u ? one : fault_case_both(&worst, &one);
        *silent |= (uint64_t)one.silent << n;
    }
    return worst;
}
