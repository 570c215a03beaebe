#include "reproduce/li_case.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>

#include "config/data_files.h"
#include "config/refusal.h"
#include "rig/euler_estimate.h"
#include "support/diag.h"
#include "support/stats.h"
#include "support/units.h"

// A dynamometer turns the rotor while the drive calibrates and catches it; then the drive brings it to
// speed and takes up the load, both with an encoder. From RELEASE_s on the estimator works alone.
#define HOLD_s 0.3
#define HOLD_rpm 300.0
#define LOADING_s 1.0
#define RELEASE_s 1.5
#define LOST_deg 90.0
#define STALL 0.05
#define KNOB_STEP 0.02
enum { KNOB_PERIODS = 200 }; // 0.5 s from 1 to 1.5

static const double orders[LI_ORDERS] = {1.0, 5.0, 7.0, 11.0, 13.0};

typedef struct {
    rig_stats_t error_deg, speed_rpm, id_A, iq_A, xy_A;
    double complex emf[LI_ORDERS];
} window_t;

typedef struct {
    const li_case_t *what;
    li_result_t *result;
    li_log_t *log;
    lode_drive6_config_t config;
    lode_drive6_tuning_t tuning[2]; ///< in use, and the next one
    lode_drive6_t drive;
    plant_t plant;
    euler_config_t euler_config;
    euler_t euler;
    bool printed;
    double ts_s;
    uint64_t k;
    lode_command_t command;
    double Rs_factor, Lq_factor;
    double load_Nm, load_goal_Nm, load_step_Nm;
    rig_stats_t stage_error_deg, stage_speed_error_rpm;
    window_t window;
} run_t;

typedef struct {
    plant_truth_t truth;
    lode_estimate_t estimate;
    double error_deg, speed_error_rpm;
} moment_t;

// ---- Set-up -------------------------------------------------------------------------------------

bool li_case_load(rig_config_t *base) {
    rig_config_init(base);
    return data_files_load_part(base, "motors", LI_MACHINE) &&
           data_files_load_part(base, "drives", LI_MACHINE) &&
           data_files_load_part(base, "plants", LI_MACHINE) &&
           data_files_load_part(base, "reproduce", LI_PAPER);
}

li_case_t li_case_in(li_case_t what, li_column_t column) {
    const bool sampled = column == LI_UNCOMPENSATED || column == LI_EXACT || column == LI_CORRECTED;
    what.form = sampled ? LI_SAMPLED : LI_EULER;
    what.compensated = sampled && column != LI_UNCOMPENSATED;
    what.qpll = column == LI_PRINTED_QPLL;
    what.inverter = CASE_IDEAL;
    if (column == LI_PRINTED_DEAD) {
        what.inverter = CASE_BARE;
    } else if (column == LI_CORRECTED) {
        what.inverter = CASE_COMPENSATED;
    }
    return what;
}

static bool differ(double a, double b) {
    return fabs(a - b) > 0.0;
}

static bool same_stage(const li_stage_t *a, const li_stage_t *b) {
    return !differ(a->duration_s, b->duration_s) && !differ(a->speed_rpm, b->speed_rpm) &&
           !differ(a->load_Nm, b->load_Nm) && !differ(a->Rs_factor, b->Rs_factor) &&
           !differ(a->Lq_factor, b->Lq_factor) && !differ(a->load_rise_s, b->load_rise_s);
}

bool li_case_same(const li_case_t *a, const li_case_t *b) {
    bool same = a->seed == b->seed && a->observer == b->observer && a->form == b->form &&
                a->inverter == b->inverter && a->compensated == b->compensated &&
                a->qpll == b->qpll && a->source == b->source && a->plain_xy == b->plain_xy &&
                a->stages == b->stages && !differ(a->k2_rad_s, b->k2_rad_s) &&
                !differ(a->sigma_rad_s, b->sigma_rad_s) && !differ(a->id_A, b->id_A) &&
                !differ(a->harmonics, b->harmonics);
    for (int k = 0; k < a->stages && same; ++k) {
        same = same_stage(&a->stage[k], &b->stage[k]);
    }
    return same;
}

/// No dead time and no drops, in plant and firmware.
static void idealise(rig_config_t *config) {
    lode_inverter_config_t *inverter = &config->drive.inverter;
    inverter->dead_time_s = inverter->v_drop_V = inverter->r_on_Ohm = 0.0f;
    config->plant.inverter = PLANT_AVERAGED;
    config->plant.dead_time_s = config->plant.v_drop_V = config->plant.r_on_Ohm = 0.0;
}

/// The files' drive with the case's observer.
static bool describe(const li_case_t *what, const rig_config_t *base, rig_config_t *config) {
    static const int emf[LI_OBSERVERS] = {LODE_EMF_C_LESO, LODE_EMF_GI_LESO, LODE_EMF_FA_LESO};
    *config = *base;
    config->emf = emf[what->observer];
    config->pll = what->qpll ? RIG_PLL_QPLL : RIG_PLL_LESO;
    config->scenario.seed = (double)what->seed;
    // With the paper's own forms it makes the start.
    const bool lags = what->form == LI_SAMPLED && !what->compensated;
    config->compensation = lags ? RIG_COMPENSATION_NONE : RIG_COMPENSATION_EXACT;
    config->six.source = what->source;
    config->six.xy.resonance_rad_s = what->plain_xy ? LODE_NONE : config->six.xy.resonance_rad_s;
    lode_drive_config_t *drive = &config->drive;
    drive->guard.plausibility = LODE_OFF; // as in case.c
    drive->inverter.dead_time_correction = what->inverter == CASE_COMPENSATED ? LODE_ON : LODE_OFF;
    if (what->k2_rad_s > 0.0) {
        drive->estimator.emf.k2_rad_s = (float)what->k2_rad_s;
    }
    if (what->sigma_rad_s > 0.0) {
        drive->estimator.pll.sigma_rad_s = (float)what->sigma_rad_s;
    }
    if (what->id_A > 0.0) { // at every speed
        drive->references.id_bias_A = (float)what->id_A;
        drive->references.omega_low_rad_s = 1.0e4f;
        drive->references.omega_high_rad_s = 2.0e4f;
    }
    if (what->inverter == CASE_IDEAL) {
        idealise(config);
    }
    if (what->harmonics > 0.0) {
        config->plant.emf5_ratio = config->plant.emf7_ratio = what->harmonics;
    }
    return rig_config_complete(config, RIG_NEED_DRIVE);
}

/// The paper's own form, together with the library's, which makes the start.
static euler_config_t printed_form(const li_case_t *what, const rig_config_t *config) {
    static const int emf[LI_OBSERVERS] = {RIG_EMF_C_EULER, RIG_EMF_GI_EULER, RIG_EMF_FA_EULER};
    static rig_config_t own;
    own = *config;
    own.emf = emf[what->observer];
    own.pll = what->qpll ? RIG_PLL_QPLL_EULER : RIG_PLL_LESO_EULER;
    own.continuous = what->form == LI_CONTINUOUS;
    own.compensation = RIG_COMPENSATION_NONE;
    rig_config_design(&own);
    return euler_estimate_config(&own);
}

static bool start(run_t *run, const rig_config_t *base) {
    static rig_config_t config;
    plant_config_t plant;
    double extra_load_Nm;
    if (!describe(run->what, base, &config) || !rig_config_plant(&config, &plant, &extra_load_Nm)) {
        return false;
    }
    run->config = rig_config_six(&config);
    run->printed = run->what->form != LI_SAMPLED;
    if (run->printed) {
        run->euler_config = printed_form(run->what, &config);
    }
    run->ts_s = plant.period_s;
    const lode_status_t status = lode_drive6_init(&run->drive, &run->tuning[0], &run->config);
    if (status != LODE_OK) {
        refusal_report(&config, status);
        return false;
    }
    (void)plant_init(&run->plant, &plant); // rig_config_plant() has checked it
    return true;
}

// ---- One period ---------------------------------------------------------------------------------

static double time_s(const run_t *run) {
    return (double)run->k * run->ts_s;
}

static bool released(const run_t *run) {
    return time_s(run) > RELEASE_s - 0.5 * run->ts_s;
}

static lode_counts6_t counts_of(const plant_counts_t plant[PLANT_SETS]) {
    lode_counts6_t counts;
    for (int set = 0; set < PLANT_SETS; ++set) {
        counts.set[set] = (lode_counts_t){
            .i = {plant[set].i[0], plant[set].i[1], plant[set].i[2]},
            .v_bus = plant[set].v_bus,
            .temperature = plant[set].temperature,
            .trip = plant[set].trip,
            .stamp = plant[set].stamp,
        };
    }
    return counts;
}

/// As with a perfect encoder on the motor.
static lode_estimate_t encoder(const lode_sample6_t *x, lode_estimate_t own,
                               const plant_truth_t *truth) {
    own.omega_rad_s = (float)truth->omega_e_rad_s;
    own.rotor = lode_sincos((float)truth->theta_e_rad);
    own.i_A = lode_park(x->machine.i_A, own.rotor);
    own.lock = 1.0f;
    own.load_torque_Nm = 0.0f; // an encoder gives none
    own.source = LODE_ESTIMATE_EXTERNAL;
    return own;
}

/// Estimate of the observer under test; until the release it is set to the true values.
static lode_estimate_t seen_by(run_t *run, const lode_sample6_t *x, const plant_truth_t *truth) {
    lode_drive_t *drive = &run->drive.drive;
    const lode_estimate_t own = lode_drive6_estimate(&run->drive, x);
    const lode_estimate_t leader = encoder(x, own, truth);
    if (!drive->gates) { // the voltage at open terminals is not known
        euler_reset(&run->euler, (double)x->i_seen_A.alpha + I * (double)x->i_seen_A.beta);
        return leader;
    }
    lode_estimate_t seen = own;
    if (run->printed) {
        seen = euler_estimate_step(&run->euler, &run->euler_config, x->u_seen_V, x->i_seen_A);
        seen.i_A = lode_park(x->machine.i_A, seen.rotor);
    }
    if (released(run)) {
        return seen;
    }
    lode_estimator_hold(&drive->estimator, &drive->tuning->estimator,
                        lode_sincos((float)truth->theta_e_rad), (float)truth->omega_e_rad_s);
    euler_hold(&run->euler, &run->euler_config, truth->theta_e_rad, truth->omega_e_rad_s);
    return leader;
}

static void move_load(run_t *run) {
    const double left_Nm = run->load_goal_Nm - run->load_Nm;
    if (fabs(left_Nm) > 0.0) {
        const bool there = fabs(left_Nm) <= run->load_step_Nm;
        run->load_Nm =
            there ? run->load_goal_Nm : run->load_Nm + copysign(run->load_step_Nm, left_Nm);
        plant_set_load(&run->plant, run->load_Nm);
    }
}

static void set_load(run_t *run, const li_stage_t *stage) {
    const double rise_s = stage->load_rise_s > 0.0 ? stage->load_rise_s : LI_LOAD_RISE_s;
    run->load_goal_Nm = stage->load_Nm;
    run->load_step_Nm = fabs(stage->load_Nm - run->load_Nm) * run->ts_s / rise_s;
}

static void one_period(run_t *run, moment_t *now) {
    plant_counts_t sampled[PLANT_SETS];
    move_load(run);
    plant_sample(&run->plant, sampled, &now->truth);
    const lode_counts6_t counts = counts_of(sampled);
    const lode_sample6_t x = lode_drive6_sense(&run->drive, &counts);
    now->estimate = seen_by(run, &x, &now->truth);
    const lode_drive6_out_t out = lode_drive6_act(&run->drive, &x, &now->estimate);
    for (int set = 0; set < PLANT_SETS; ++set) {
        const lode_abc_t *d = &out.set[set].duty;
        const double duty[PLANT_PHASES] = {(double)d->a, (double)d->b, (double)d->c};
        plant_write_set(&run->plant, set, duty, (plant_gates_t)out.set[set].gates);
    }
    plant_advance(&run->plant);
    run->k++;
    const double np = (double)run->config.drive.motor.pole_pairs;
    now->error_deg = rig_angle_error_deg((double)lode_estimate_theta_rad(&now->estimate),
                                         now->truth.theta_e_rad);
    now->speed_error_rpm = rig_rpm_from_rad_s((double)now->estimate.omega_rad_s) / np -
                           rig_rpm_from_rad_s(now->truth.omega_m_rad_s);
}

// ---- Measurement --------------------------------------------------------------------------------

void li_log_free(li_log_t *self) {
    free(self->row);
    *self = (li_log_t){0, 0, NULL};
}

static bool write_down(li_log_t *log, double t_s, const moment_t *now) {
    if (log->rows == log->capacity) {
        const size_t capacity = log->capacity > 0 ? 2u * log->capacity : 65536u;
        li_row_t *row = realloc(log->row, capacity * sizeof *row);
        if (row == NULL) {
            rig_error("out of memory for the signals of a run");
            return false;
        }
        log->row = row;
        log->capacity = capacity;
    }
    log->row[log->rows++] = (li_row_t){
        .t_s = t_s,
        .error_deg = now->error_deg,
        .speed_rpm = rig_rpm_from_rad_s(now->truth.omega_m_rad_s),
        .speed_error_rpm = now->speed_error_rpm,
        .theta_rad = now->truth.theta_e_rad,
        .theta_est_rad = (double)lode_estimate_theta_rad(&now->estimate),
        .e_alpha_V = (double)now->estimate.e_V.alpha,
        .e_beta_V = (double)now->estimate.e_V.beta,
        .i_xy_A = hypot(now->truth.i_x_A, now->truth.i_y_A),
    };
    return true;
}

static void measure(run_t *run, const moment_t *now, bool in_window) {
    rig_stats_add(&run->stage_error_deg, now->error_deg);
    rig_stats_add(&run->stage_speed_error_rpm, now->speed_error_rpm);
    if (!in_window) {
        return;
    }
    window_t *window = &run->window;
    rig_stats_add(&window->error_deg, now->error_deg);
    rig_stats_add(&window->speed_rpm, rig_rpm_from_rad_s(now->truth.omega_m_rad_s));
    rig_stats_add(&window->id_A, (double)now->estimate.i_A.d);
    rig_stats_add(&window->iq_A, (double)now->estimate.i_A.q);
    rig_stats_add(&window->xy_A, hypot(now->truth.i_x_A, now->truth.i_y_A));
    for (int n = 0; n < LI_ORDERS; ++n) {
        window->emf[n] +=
            2.0 * (double)now->estimate.e_V.alpha * cexp(-I * orders[n] * now->truth.theta_e_rad);
    }
}

static double farthest(const rig_stats_t *of, double from) {
    return fmax(fabs(rig_stats_max(of) - from), fabs(rig_stats_min(of) - from));
}

static li_stage_result_t nothing(void) {
    li_stage_result_t out = {NAN, NAN, NAN, NAN, NAN, NAN, {NAN}, NAN, NAN, NAN, NAN};
    for (int n = 0; n < LI_ORDERS; ++n) {
        out.harmonic_pct[n] = NAN;
    }
    return out;
}

static void conclude(const run_t *run, int index) {
    const window_t *window = &run->window;
    const double wanted_rpm = run->what->stage[index].speed_rpm;
    const double mean_rpm = rig_stats_mean(&window->speed_rpm);
    if (!(fabs(mean_rpm - wanted_rpm) < STALL * wanted_rpm)) {
        return;
    }
    const li_stage_result_t *before = &run->result->stage[index > 0 ? index - 1 : 0];
    li_stage_result_t *out = &run->result->stage[index];
    const double count = (double)window->error_deg.count;
    *out = (li_stage_result_t){
        .mean_deg = rig_stats_mean(&window->error_deg),
        .pp_deg = rig_stats_peak_to_peak(&window->error_deg),
        .speed_rpm = mean_rpm,
        .e_V = cabs(window->emf[0]) / count,
        .id_A = rig_stats_mean(&window->id_A),
        .iq_A = rig_stats_mean(&window->iq_A),
        .xy_A = rig_stats_max(&window->xy_A),
        .peak_deg = rig_stats_peak(&run->stage_error_deg),
        .swing_deg = index > 0 ? farthest(&run->stage_error_deg, before->mean_deg) : NAN,
        .swing_rpm = rig_stats_peak(&run->stage_speed_error_rpm),
    };
    for (int n = 0; n < LI_ORDERS; ++n) {
        out->harmonic_pct[n] = 100.0 * cabs(window->emf[n]) / cabs(window->emf[0]);
    }
}

// ---- Stages -------------------------------------------------------------------------------------

/// Changes the motor parameters of the firmware during the run, and the values derived from them.
static bool retune(run_t *run) {
    lode_drive6_config_t config = run->config;
    config.drive.motor.Rs_Ohm *= (float)run->Rs_factor;
    config.drive.motor.Lq_H *= (float)run->Lq_factor;
    run->euler_config.Rs_Ohm = (double)config.drive.motor.Rs_Ohm;
    run->euler_config.Lq_H = (double)config.drive.motor.Lq_H;
    lode_drive6_tuning_t *next = &run->tuning[run->drive.tuning == &run->tuning[0] ? 1 : 0];
    const lode_status_t status = lode_drive6_tune(next, &config);
    if (status != LODE_OK) {
        rig_error("%s: Rs x%g, Lq x%g: %s", LI_PAPER, run->Rs_factor, run->Lq_factor,
                  lode_status_name(status));
        return false;
    }
    return lode_drive6_post_tuning(&run->drive, next) == LODE_OK;
}

static double toward(double from, double goal, double most) {
    return fabs(goal - from) <= most ? goal : from + copysign(most, goal - from);
}

/// Changes the factors gradually. False after a message.
static bool turn_knobs(run_t *run, const li_stage_t *stage) {
    const double Rs = stage->Rs_factor > 0.0 ? stage->Rs_factor : 1.0;
    const double Lq = stage->Lq_factor > 0.0 ? stage->Lq_factor : 1.0;
    const bool moving = fabs(Rs - run->Rs_factor) > 0.0 || fabs(Lq - run->Lq_factor) > 0.0;
    if (!moving || run->k % KNOB_PERIODS != 0) {
        return true;
    }
    run->Rs_factor = toward(run->Rs_factor, Rs, KNOB_STEP);
    run->Lq_factor = toward(run->Lq_factor, Lq, KNOB_STEP);
    return retune(run);
}

static void command(run_t *run, double speed_rpm) {
    run->command.mode = LODE_MODE_RUN;
    run->command.speed_rad_s = (float)rig_rad_s_from_rpm(speed_rpm);
    (void)lode_drive_post_command(&run->drive.drive, &run->command);
}

static bool is_lost(const run_t *run, const moment_t *now) {
    return run->drive.drive.mode != (uint_least8_t)LODE_MODE_RUN ||
           !(fabs(now->error_deg) < LOST_deg);
}

/// False after a message. A lost rotor ends the run.
static bool run_stage(run_t *run, int index) {
    const li_stage_t *stage = &run->what->stage[index];
    const uint64_t periods = (uint64_t)llround(stage->duration_s / run->ts_s);
    const uint64_t window = (uint64_t)llround(LI_WINDOW_s / run->ts_s);
    rig_stats_reset(&run->stage_error_deg);
    rig_stats_reset(&run->stage_speed_error_rpm);
    run->window = (window_t){.emf = {0.0}};
    command(run, stage->speed_rpm);
    set_load(run, stage);
    for (uint64_t k = 0; k < periods; ++k) {
        moment_t now;
        if (!turn_knobs(run, stage)) {
            return false;
        }
        one_period(run, &now);
        const double t_s = time_s(run) - RELEASE_s;
        if (run->log != NULL && !write_down(run->log, t_s, &now)) {
            return false;
        }
        if (is_lost(run, &now)) {
            run->result->lost_s = t_s;
            return true;
        }
        measure(run, &now, k + window >= periods);
    }
    conclude(run, index);
    return true;
}

/// False after a message.
static bool prepare(run_t *run) {
    moment_t now;
    bool loaded = false;
    plant_set_speed(&run->plant, rig_rad_s_from_rpm(HOLD_rpm));
    command(run, HOLD_rpm);
    while (time_s(run) < HOLD_s) {
        one_period(run, &now);
    }
    plant_release_speed(&run->plant);
    command(run, run->what->stage[0].speed_rpm);
    while (!released(run)) {
        if (!loaded && time_s(run) >= LOADING_s) {
            set_load(run, &run->what->stage[0]);
            loaded = true;
        }
        one_period(run, &now);
    }
    if (run->drive.drive.mode != (uint_least8_t)LODE_MODE_RUN) {
        const lode_fault_t *fault = &run->drive.drive.guard.fault;
        rig_error("%s: the drive did not get to run before the experiment: %s, %s", LI_PAPER,
                  lode_mode_name((lode_mode_t)run->drive.drive.mode),
                  lode_check_name((lode_check_t)fault->check));
        return false;
    }
    return true;
}

bool li_case_run(const li_case_t *what, const rig_config_t *base, li_result_t *result,
                 li_log_t *log) {
    static run_t run;
    run = (run_t){.what = what, .result = result, .log = log, .Rs_factor = 1.0, .Lq_factor = 1.0};
    *result = (li_result_t){.lost_s = NAN};
    for (int k = 0; k < LI_STAGES_MAX; ++k) {
        result->stage[k] = nothing();
    }
    bool good = start(&run, base) && prepare(&run);
    for (int k = 0; good && k < what->stages && isnan(result->lost_s); ++k) {
        good = run_stage(&run, k);
    }
    result->simulated_s = time_s(&run);
    return good;
}
