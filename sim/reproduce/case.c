#include "reproduce/case.h"

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/data_files.h"
#include "rig/runner.h"
#include "support/diag.h"

// A dynamometer turns the rotor while the drive calibrates and catches it; then the drive brings it to speed
// and takes up the load, both with an encoder. From RELEASE_s on the estimator works alone.
#define HOLD_s 0.25
#define HOLD_rpm 300.0
#define APPROACH_s 1.0
#define LOADING_s 0.75
#define RELEASE_s (HOLD_s + APPROACH_s + LOADING_s)
#define SETTLE_s 1.2
#define AFTER_s 1.0 // time after the load is removed, and time of a step of the staircase
#define KNOB_STEP 0.05
#define KNOB_s 0.05
#define LEVEL_s 0.8
#define START_s 2.0
#define START_RUN_s 1.0
#define START_rpm 900.0
#define START_HANDOVER_rpm 100.0
#define LOST_deg 90.0
#define STALL 0.05

const char *case_chain_name(case_chain_t chain) {
    static const char *const names[CHAINS] = {
        [CHAIN_PRINTED] = "as printed",
        [CHAIN_CONTINUOUS] = "continuous",
        [CHAIN_SAMPLED] = "exact, lag as in the paper",
        [CHAIN_EXACT] = "exact",
        [CHAIN_CORRECTED] = "exact, active flux",
        [CHAIN_LIBRARY] = "library's own gains",
        [CHAIN_EQ14] = "as printed, speed of eq. 14",
    };
    return names[chain];
}

bool case_same(const case_t *a, const case_t *b) {
    return a->kind == b->kind && a->method == b->method && a->chain == b->chain &&
           a->inverter == b->inverter && a->seed == b->seed &&
           !(fabs(a->speed_rpm - b->speed_rpm) > 0.0) && !(fabs(a->Ld_factor - b->Ld_factor) > 0.0);
}

// ---- Set-up -------------------------------------------------------------------------------------

bool case_load(case_bases_t *bases) {
    rig_config_t *library = &bases->library;
    rig_config_init(library);
    const bool good = data_files_load_part(library, "motors", CASE_PAPER) &&
                      data_files_load_part(library, "drives", CASE_PAPER) &&
                      data_files_load_part(library, "plants", CASE_PAPER);
    bases->paper = *library;
    return good && data_files_load_part(&bases->paper, "reproduce", CASE_PAPER);
}

static rig_phase_t *add(rig_scenario_t *scenario, const char *name, double duration_s) {
    rig_phase_t *phase = &scenario->phase[scenario->phases++];
    (void)snprintf(phase->name, sizeof phase->name, "%s", name);
    phase->duration_s = duration_s;
    return phase;
}

static bool is_staircase(const case_t *what) {
    return what->kind == CASE_STAIRCASE || what->kind == CASE_STAIRCASE_RATED;
}

static bool is_loaded(const case_t *what) {
    return what->kind != CASE_NO_LOAD && what->kind != CASE_STAIRCASE;
}

static bool is_Rs(case_kind_t kind) {
    return kind == CASE_RS_DOWN || kind == CASE_RS_UP;
}

int case_levels(case_kind_t kind, double factor[CASE_LEVELS_MAX]) {
    static const double down[] = {1.0, 0.75, 0.5};
    static const double up[] = {1.0, 1.25, 1.5, 2.0};
    const bool is_down = kind == CASE_LQ_DOWN || kind == CASE_RS_DOWN;
    const bool is_up = kind == CASE_LQ_UP || kind == CASE_RS_UP;
    const int levels = is_down ? 3 : (is_up ? 4 : 0);
    for (int k = 0; k < levels; ++k) {
        factor[k] = is_down ? down[k] : up[k];
    }
    return levels;
}

/// From one factor to the next in steps of 0.05, then constant for a while.
static void describe_mismatch(case_kind_t kind, rig_scenario_t *scenario) {
    double factor[CASE_LEVELS_MAX];
    const int levels = case_levels(kind, factor);
    for (int k = 1; k < levels; ++k) {
        const double change = factor[k] - factor[k - 1];
        const int steps = (int)lround(fabs(change) / KNOB_STEP);
        for (int n = 1; n <= steps; ++n) {
            const double now = factor[k - 1] + change * n / steps;
            rig_phase_t *phase = add(scenario, "knob", n < steps ? KNOB_s : LEVEL_s);
            *(is_Rs(kind) ? &phase->Rs_factor : &phase->Lq_factor) = now;
        }
    }
}

static bool is_start(const case_t *what) {
    return what->kind == CASE_START || what->kind == CASE_START_SPREAD;
}

/// As in the scenario of that name. Start and control are those of the library, because the paper describes
/// little of its own.
static void describe_start(const case_t *what, const rig_config_t *paper, rig_config_t *config) {
    rig_phase_t *first = add(&config->scenario, "start", START_s);
    first->speed_rpm = HOLD_rpm;
    first->load_Nm = 0.0;
    add(&config->scenario, "run", START_RUN_s)->speed_rpm = START_rpm;
    config->source = RIG_SOURCE_OWN;
    config->people.handover_rpm = START_HANDOVER_rpm;
    if (what->chain != CHAIN_LIBRARY) {
        config->drive.estimator.emf.w0_rad_s = paper->drive.estimator.emf.w0_rad_s;
        config->drive.estimator.pll.sigma_rad_s = paper->drive.estimator.pll.sigma_rad_s;
    }
    if (what->kind == CASE_START_SPREAD) {
        config->plant.load_kind = 0; // passive
        config->plant.load_spread_Nm = 2.0;
        config->plant.Rs_spread = 0.2;
        config->plant.Lq_spread = 0.15;
        config->plant.i_offset_spread_A = 0.1;
        config->plant.i_noise_A = 0.05;
    }
}

static void describe_phases(const case_t *what, rig_scenario_t *scenario) {
    const double speed_rpm = is_staircase(what) ? CASE_STEP_rpm : what->speed_rpm;
    rig_phase_t *hold = add(scenario, "hold", HOLD_s);
    hold->speed_rpm = HOLD_rpm;
    hold->dyno_rpm = HOLD_rpm;
    hold->load_Nm = 0.0;
    rig_phase_t *approach = add(scenario, "approach", APPROACH_s);
    approach->dyno_rpm = RIG_RANDOM;
    approach->speed_rpm = speed_rpm;
    add(scenario, "loading", LOADING_s)->load_Nm = is_loaded(what) ? CASE_RATED_Nm : 0.0;
    add(scenario, "steady", SETTLE_s);
    for (int k = 1; is_staircase(what) && k < CASE_STEPS; ++k) {
        rig_phase_t *step = add(scenario, "step", AFTER_s);
        step->speed_rpm = CASE_STEP_rpm * (k + 1);
        step->ramp_rpm_s = CASE_RAMP_rpm_s;
    }
    if (what->kind == CASE_RATED) {
        add(scenario, "load off", AFTER_s)->load_Nm = 0.0;
    }
    describe_mismatch(what->kind, scenario);
}

static void choose_chain(const case_t *what, rig_config_t *config) {
    const case_chain_t chain = what->chain;
    const bool printed = chain == CHAIN_PRINTED || chain == CHAIN_CONTINUOUS || chain == CHAIN_EQ14;
    const bool whole = chain == CHAIN_CORRECTED || chain == CHAIN_LIBRARY;
    const bool qpll = what->method == METHOD_QPLL;
    lode_drive_config_t *drive = &config->drive;
    config->emf = printed ? (int)RIG_EMF_C_EULER : (int)LODE_EMF_C_LESO;
    if (printed) {
        config->pll = qpll ? RIG_PLL_QPLL_EULER : RIG_PLL_ENHANCED_EULER;
    } else {
        config->pll = qpll ? RIG_PLL_QPLL : RIG_PLL_ENHANCED;
    }
    if (chain == CHAIN_SAMPLED && qpll) { // the paper compensates in the enhanced PLL only
        config->compensation = RIG_COMPENSATION_NONE;
    }
    config->speed_of_eq14 = chain == CHAIN_EQ14;
    config->continuous = chain == CHAIN_CONTINUOUS;
    drive->estimator.active_flux = whole ? LODE_ON : LODE_OFF;
}

static void choose_inverter(const case_t *what, rig_config_t *config) {
    if (what->inverter == CASE_IDEAL) {
        config->plant.inverter = PLANT_AVERAGED;
    }
    lode_inverter_config_t *inverter = &config->drive.inverter;
    // An ideal inverter needs no correction, and has no dead time that the drive could leave room for.
    const bool ideal = config->plant.inverter == (int)PLANT_AVERAGED;
    const bool corrected = what->inverter == CASE_COMPENSATED && !ideal;
    inverter->dead_time_correction = corrected ? LODE_ON : LODE_OFF;
    if (ideal) {
        inverter->dead_time_s = inverter->v_drop_V = inverter->r_on_Ohm = 0.0f;
    }
}

static bool describe(const case_t *what, const case_bases_t *bases, rig_config_t *config) {
    const bool own = what->chain == CHAIN_LIBRARY || is_start(what);
    *config = own ? bases->library : bases->paper;
    lode_drive_config_t *drive = &config->drive;
    drive->guard.plausibility =
        LODE_OFF; // the paper's drives had none, and the estimate must be recorded to the end
    choose_chain(what, config);
    choose_inverter(what, config);
    config->scenario.seed = (double)what->seed;
    config->scenario.log_s = 1.0 / (double)drive->f_pwm_Hz;
    if (is_start(what)) {
        describe_start(what, &bases->paper, config);
    } else {
        config->source = RIG_SOURCE_SEEDED;
        config->seeded_s = RELEASE_s;
        describe_phases(what, &config->scenario);
    }
    if (what->Ld_factor > 0.0) {
        drive->motor.Ld_H *= (float)what->Ld_factor;
    }
    if (!rig_config_complete(config, RIG_NEED_DRIVE)) {
        return false;
    }
    lode_drive_design(drive);
    return true;
}

double case_released_s(void) {
    return RELEASE_s;
}

double case_last_phase_s(const case_t *what) {
    return RELEASE_s + SETTLE_s + (is_staircase(what) ? (CASE_STEPS - 2) * AFTER_s : 0.0);
}

// ---- Measurement --------------------------------------------------------------------------------

typedef struct {
    rig_stats_t angle_deg, speed_rpm, speed_error_rpm;
} figures_t;

/// From `from_s` up to, but not including, `to_s`.
static figures_t figures(const runlog_t *log, double from_s, double to_s) {
    const double half_s = 0.5 * (log->row[1].t_s - log->row[0].t_s);
    figures_t out = {{0}, {0}, {0}};
    for (size_t k = 0; k < log->rows; ++k) {
        const runlog_row_t *row = &log->row[k];
        if (row->t_s > from_s - half_s && row->t_s < to_s - half_s) {
            rig_stats_add(&out.angle_deg, row->angle_error_deg);
            rig_stats_add(&out.speed_rpm, row->speed_rpm);
            rig_stats_add(&out.speed_error_rpm, row->speed_est_rpm - row->speed_rpm);
        }
    }
    return out;
}

/// The last moment before a phase that begins at `end_s`. Nothing if the rotor had been lost by then, or
/// does not turn as it should: there the largest current no longer carries the load.
static figures_t steady(const runlog_t *log, const case_result_t *result, double end_s) {
    const figures_t none = {{0}, {0}, {0}};
    if (result->lost_s < end_s) {
        return none;
    }
    const figures_t out = figures(log, end_s - CASE_WINDOW_s, end_s);
    const size_t last = (size_t)llround(end_s / (log->row[1].t_s - log->row[0].t_s)) - 1;
    const double wanted_rpm = log->row[last].speed_command_rpm;
    const bool turns = fabs(rig_stats_mean(&out.speed_rpm) - wanted_rpm) < STALL * wanted_rpm;
    return turns ? out : none;
}

static double deviation(const rig_stats_t *now, const rig_stats_t *before) {
    const double mean = rig_stats_mean(before);
    return fmax(fabs(rig_stats_max(now) - mean), fabs(rig_stats_min(now) - mean));
}

/// With an error of a quarter turn the current no longer makes the intended torque: the rotor is lost.
static double find_loss(const runlog_t *log) {
    for (size_t k = 0; k < log->rows; ++k) {
        const runlog_row_t *row = &log->row[k];
        const bool sound =
            row->mode == (double)LODE_MODE_RUN && fabs(row->angle_error_deg) < LOST_deg;
        if (row->t_s >= RELEASE_s && !sound) {
            return row->t_s;
        }
    }
    return NAN;
}

static unsigned count_reseeds(const runner_result_t *result) {
    unsigned reseeds = 0;
    for (int k = 0; k < result->phases; ++k) {
        const runner_phase_t *phase = &result->phase[k];
        reseeds += phase->start_s > RELEASE_s - 1e-9 ? phase->reseeds : 0u;
    }
    return reseeds;
}

static void measure_step(const runlog_t *log, double off_s, double end_s, case_result_t *out) {
    const figures_t before = steady(log, out, off_s);
    const figures_t after = figures(log, off_s, end_s);
    if (out->lost_s < end_s) {
        return;
    }
    const figures_t first = figures(log, off_s, off_s + CASE_SWING_s);
    out->swing_deg = deviation(&first.angle_deg, &before.angle_deg);
    out->step_deg = deviation(&after.angle_deg, &before.angle_deg);
    out->step_speed_rpm = deviation(&after.speed_rpm, &before.speed_rpm);
    out->step_estimate_rpm = deviation(&after.speed_error_rpm, &before.speed_error_rpm);
}

static void measure_stairs(const runlog_t *log, double first_s, case_result_t *out) {
    const double ramp_s = CASE_STEP_rpm / CASE_RAMP_rpm_s;
    for (int k = 0; k < CASE_STEPS; ++k) {
        const double end_s = first_s + k * AFTER_s;
        const figures_t level = steady(log, out, end_s);
        out->stair_dc_deg[k] = rig_stats_mean(&level.angle_deg);
        out->stair_pp_deg[k] = rig_stats_peak_to_peak(&level.angle_deg);
        if (k == CASE_STEPS - 1 || out->lost_s < end_s + AFTER_s) {
            continue;
        }
        const figures_t ramp = figures(log, end_s + 0.5 * ramp_s, end_s + ramp_s);
        const figures_t whole = figures(log, end_s, end_s + AFTER_s);
        const double mean = rig_stats_mean(&ramp.angle_deg);
        if (!(fabs(mean) <= fabs(out->ramp_dc_deg))) {
            out->ramp_dc_deg = mean;
        }
        // fmax() ignores the initial NaN.
        out->ramp_max_deg = fmax(out->ramp_max_deg, deviation(&whole.angle_deg, &level.angle_deg));
    }
}

static void measure_levels(case_kind_t kind, const runlog_t *log, case_result_t *out) {
    double factor[CASE_LEVELS_MAX];
    const int levels = case_levels(kind, factor);
    double end_s = RELEASE_s + SETTLE_s;
    for (int k = 0; k < levels; ++k) {
        if (k > 0) {
            const double steps = round(fabs(factor[k] - factor[k - 1]) / KNOB_STEP);
            end_s += (steps - 1.0) * KNOB_s + LEVEL_s;
        }
        const figures_t level = steady(log, out, end_s);
        out->level_dc_deg[k] = rig_stats_mean(&level.angle_deg);
        out->level_pp_deg[k] = rig_stats_peak_to_peak(&level.angle_deg);
        out->level_speed_rpm[k] = rig_stats_mean(&level.speed_error_rpm);
    }
}

/// The order of the largest ripple in the angle over the window that ends at `end_s`.
static double ripple_order(const runlog_t *log, double end_s, double mean_deg) {
    const double ts_s = log->row[1].t_s - log->row[0].t_s;
    const size_t end = (size_t)llround(end_s / ts_s);
    const size_t from = end - (size_t)llround(CASE_WINDOW_s / ts_s);
    double largest = 0.0;
    double order = NAN;
    for (int n = 1; n <= CASE_ORDERS; ++n) {
        double complex sum = 0.0;
        for (size_t k = from; k < end && k < log->rows; ++k) {
            sum += (log->row[k].angle_error_deg - mean_deg) *
                   cexp(-I * (double)n * log->row[k].theta_e_rad);
        }
        if (cabs(sum) > largest) {
            largest = cabs(sum);
            order = n;
        }
    }
    return order;
}

static double has_started(const runner_result_t *run) {
    const runner_phase_t *last = &run->phase[run->phases - 1];
    const bool runs = last->mode == LODE_MODE_RUN && last->error_deg.count > 0 &&
                      fabs(rig_stats_mean(&last->speed_rpm) - START_rpm) < STALL * START_rpm;
    return runs ? 1.0 : 0.0;
}

static void measure(const case_t *what, const runner_result_t *run, const runlog_t *log,
                    case_result_t *out) {
    out->simulated_s = run->simulated_s;
    if (is_start(what)) {
        out->started = has_started(run);
        return;
    }
    out->lost_s = find_loss(log);
    out->reseeds = count_reseeds(run);
    const double end_s = run->simulated_s;
    if (is_staircase(what)) {
        measure_stairs(log, RELEASE_s + SETTLE_s, out);
        return;
    }
    if (case_levels(what->kind, (double[CASE_LEVELS_MAX]){0}) > 0) {
        measure_levels(what->kind, log, out);
        return;
    }
    const double settled_s = what->kind == CASE_RATED ? case_last_phase_s(what) : end_s;
    const figures_t level = steady(log, out, settled_s);
    out->dc_deg = rig_stats_mean(&level.angle_deg);
    out->pp_deg = rig_stats_peak_to_peak(&level.angle_deg);
    out->ripple_order = level.angle_deg.count > 0 ? ripple_order(log, settled_s, out->dc_deg) : NAN;
    out->speed_error_rpm = rig_stats_mean(&level.speed_error_rpm);
    out->speed_error_pp_rpm = rig_stats_peak_to_peak(&level.speed_error_rpm);
    if (what->kind == CASE_RATED) {
        measure_step(log, settled_s, end_s, out);
    }
}

static case_result_t nothing(void) {
    case_result_t out = {
        .dc_deg = NAN,
        .pp_deg = NAN,
        .speed_error_rpm = NAN,
        .speed_error_pp_rpm = NAN,
        .swing_deg = NAN,
        .step_deg = NAN,
        .step_speed_rpm = NAN,
        .step_estimate_rpm = NAN,
        .ripple_order = NAN,
        .ramp_dc_deg = NAN,
        .ramp_max_deg = NAN,
        .lost_s = NAN,
    };
    for (int k = 0; k < CASE_STEPS; ++k) {
        out.stair_dc_deg[k] = NAN;
        out.stair_pp_deg[k] = NAN;
    }
    for (int k = 0; k < CASE_LEVELS_MAX; ++k) {
        out.level_dc_deg[k] = NAN;
        out.level_pp_deg[k] = NAN;
        out.level_speed_rpm[k] = NAN;
    }
    return out;
}

bool case_run(const case_t *what, const case_bases_t *bases, case_result_t *result, runlog_t *log) {
    static rig_config_t config;
    static runner_result_t run;
    runlog_t own = {0};
    runlog_t *rows = log != NULL ? log : &own;
    runlog_init(rows);
    *result = nothing();
    bool good = describe(what, bases, &config) &&
                runner_run(&config, runner_estimator(&config), &run, rows);
    if (good && !is_start(what) && run.simulated_s < RELEASE_s) {
        rig_error("%s at %g rpm: the drive tripped before the experiment began",
                  case_chain_name(what->chain), what->speed_rpm);
        good = false;
    }
    if (good) {
        measure(what, &run, rows, result);
    }
    if (log == NULL || !good) {
        runlog_free(rows);
    }
    return good;
}
