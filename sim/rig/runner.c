#include "rig/runner.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "config/refusal.h"
#include "config/speed_limits.h"
#include "config/trial_scenario.h"
#include "rig/capture.h"
#include "rig/euler_estimate.h"
#include "support/diag.h"
#include "support/fault_text.h"
#include "support/progress.h"
#include "support/units.h"

// A speed counts as reached within this share of it. The mean of a settled speed is much closer.
#define SPEED_REACHED 0.02
#define TORQUE_REACHED 0.02

enum { LOG_ROWS = 6000, PERIODS_PER_PROGRESS = 4096 };

typedef struct {
    const rig_config_t *config;
    runner_estimator_t estimate;
    runner_memory_t memory;
    runner_result_t *result;
    runlog_t *log;
    rig_t rig;
    reactions_t reactions;
    double Lq_factor, Rs_factor;
    double ts_s;
    double extra_load_Nm;
    double load_Nm;
    double total_s;
    uint64_t log_every;
    uint64_t k;
    lode_command_t command;
    double speed_rpm;      ///< present command
    double speed_goal_rpm; ///< end of the ramp of the command
    double speed_step_rpm; ///< per period
    double rotor_rpm;
    lode_mode_t mode;
    bool driven; ///< the gates were on in the period of which the estimate uses the voltage
    bool faulted;
    bool commanded; ///< a phase has commanded RUN with a speed
    bool excused;   ///< such a phase has an end_mode other than RUN
    bool held;      ///< speed held by a dynamometer
    double v_bus_V;
    double drawn_J;  ///< energy drawn from the supply before this period
    double supply_A; ///< filtered
    bool looks_at_supply;
    speed_limits_t limits;
    int found_open;
    bool open[PLANT_LEGS]; ///< broken phases that the log already has
    progress_t progress;
} run_t;

/// One period, seen from outside.
typedef struct {
    rig_moment_t at;
    double error_deg;
} moment_t;

// ---- Estimates ----------------------------------------------------------------------------------

static lode_estimate_t own_estimate(lode_drive_t *drive, const lode_sample_t *sample,
                                    const plant_truth_t *truth, runner_memory_t *memory) {
    (void)truth;
    (void)memory;
    return lode_drive_estimate(drive, sample);
}

/// As with a perfect encoder on the motor. It gives no load torque.
static lode_estimate_t true_estimate(lode_drive_t *drive, const lode_sample_t *sample,
                                     const plant_truth_t *truth, runner_memory_t *memory) {
    (void)memory;
    lode_estimate_t estimate = lode_drive_estimate(drive, sample);
    estimate.omega_rad_s = (float)truth->omega_e_rad_s;
    estimate.rotor = lode_sincos((float)truth->theta_e_rad);
    estimate.i_A = lode_park(sample->i_A, estimate.rotor);
    estimate.lock = 1.0f;
    estimate.load_torque_Nm = 0.0f;
    estimate.source = LODE_ESTIMATE_EXTERNAL;
    return estimate;
}

/// An angle sensor on the shaft that counts from the start of the run.
static lode_estimate_t encoder_estimate(lode_drive_t *drive, const lode_sample_t *sample,
                                        const plant_truth_t *truth, runner_memory_t *memory) {
    const double np = 1.0 / (double)drive->tuning->speed.inv_pole_pairs;
    memory->turns += remainder(truth->theta_e_rad - memory->theta_e_rad, 2.0 * RIG_PI) / np;
    memory->theta_e_rad = truth->theta_e_rad;
    const double turn = memory->turns / (2.0 * RIG_PI);
    const double count = floor((turn - floor(turn)) * memory->counts_per_turn);
    const lode_estimate_t own = lode_drive_estimate(drive, sample);
    return lode_encoder_estimate(&memory->encoder, &memory->encoder_tuning, &own, sample->i_A,
                                 (uint32_t)count);
}

static bool on_its_own(const lode_drive_t *drive, const plant_truth_t *truth,
                       const runner_memory_t *memory) {
    return drive->mode == (uint_least8_t)LODE_MODE_RUN && truth->t_s >= memory->seeded_s;
}

/// The drive's own estimator, started from the true values; before that the drive uses a perfect encoder.
static lode_estimate_t seeded_estimate(lode_drive_t *drive, const lode_sample_t *sample,
                                       const plant_truth_t *truth, runner_memory_t *memory) {
    if (on_its_own(drive, truth, memory)) {
        return lode_drive_estimate(drive, sample);
    }
    const lode_estimate_t estimate = true_estimate(drive, sample, truth, memory);
    lode_estimator_hold(&drive->estimator, &drive->tuning->estimator,
                        lode_sincos((float)truth->theta_e_rad), estimate.omega_rad_s);
    return estimate;
}

/// One of the papers' forms instead. Until `own` it is set to `leader`, which makes the start, because the
/// papers' forms have no start.
static lode_estimate_t euler_after(const lode_estimate_t *leader, bool own,
                                   const lode_drive_t *drive, const lode_sample_t *sample,
                                   runner_memory_t *memory) {
    const lode_ab_t i_A = sample->i_A;
    if (!drive->gates) { // the voltage at open terminals is not known
        euler_reset(&memory->euler, (double)i_A.alpha + I * (double)i_A.beta);
        return *leader;
    }
    const lode_estimate_t estimate =
        euler_estimate_step(&memory->euler, &memory->euler_config, sample->u_V, i_A);
    if (own) {
        return estimate;
    }
    euler_hold(&memory->euler, &memory->euler_config, (double)lode_estimate_theta_rad(leader),
               (double)leader->omega_rad_s);
    return *leader;
}

static lode_estimate_t euler_own(lode_drive_t *drive, const lode_sample_t *sample,
                                 const plant_truth_t *truth, runner_memory_t *memory) {
    const lode_estimate_t leader = own_estimate(drive, sample, truth, memory);
    const bool own = drive->mode == (uint_least8_t)LODE_MODE_RUN;
    return euler_after(&leader, own, drive, sample, memory);
}

static lode_estimate_t euler_seeded(lode_drive_t *drive, const lode_sample_t *sample,
                                    const plant_truth_t *truth, runner_memory_t *memory) {
    const lode_estimate_t leader = seeded_estimate(drive, sample, truth, memory);
    return euler_after(&leader, on_its_own(drive, truth, memory), drive, sample, memory);
}

runner_estimator_t runner_estimator(const rig_config_t *config) {
    const bool euler = euler_estimate_wanted(config);
    switch (config->source) {
    case RIG_SOURCE_TRUTH:
        return true_estimate;
    case RIG_SOURCE_SEEDED:
        return euler ? euler_seeded : seeded_estimate;
    case RIG_SOURCE_ENCODER:
        return encoder_estimate;
    case RIG_SOURCE_OWN:
    default:
        return euler ? euler_own : own_estimate;
    }
}

// ---- Log ----------------------------------------------------------------------------------------

static const char *phase_name(int leg) {
    static const char *const names[] = {"a1", "b1", "c1",           "a2",
                                        "b2", "c2", "all of set 1", "all of set 2"};
    return names[leg];
}

static void note_open_phases(run_t *run, const rig_moment_t *now) {
    const double t_s = (double)run->k * run->ts_s;
    const int found = rig_found_open(&run->rig);
    char text[80];
    for (int n = 0; n < PLANT_LEGS; ++n) {
        if (now->truth.open[n] && !run->open[n]) {
            (void)snprintf(text, sizeof text, "phase %s is open", phase_name(n));
            runlog_note(run->log, t_s, text);
        }
        run->open[n] = now->truth.open[n];
    }
    if (found > 0 && found != run->found_open) {
        (void)snprintf(text, sizeof text, "found open by the drive: %s", phase_name(found - 1));
        runlog_note(run->log, t_s, text);
    }
    run->found_open = found;
}

/// A failed start attempt that another one follows.
static void note_attempt(run_t *run, double t_s) {
    const int retries = (int)lode_drive_retries(run->rig.drive);
    const lode_fault_t *why = &run->rig.drive->guard.fault;
    if (retries > run->result->retries && why->check == (uint_least8_t)LODE_CHECK_NONE &&
        why->criterion != (uint_least8_t)LODE_CRITERION_NONE) {
        char what[120];
        char text[160];
        fault_text(why, what, sizeof what);
        (void)snprintf(text, sizeof text, "attempt %d failed: %s", retries, what);
        runlog_note(run->log, t_s, text);
    }
    run->result->retries = retries;
}

static void note_changes(run_t *run, const rig_moment_t *now) {
    const double t_s = (double)run->k * run->ts_s;
    const lode_mode_t mode = (lode_mode_t)run->rig.drive->mode;
    char text[160];
    if (mode != run->mode) {
        const size_t prefix = strlen("LODE_MODE_");
        (void)snprintf(text, sizeof text, "%s -> %s", lode_mode_name(run->mode) + prefix,
                       lode_mode_name(mode) + prefix);
        runlog_note(run->log, t_s, text);
        if (mode == LODE_MODE_RUN && isnan(run->result->handover_s)) {
            run->result->handover_s = t_s;
        }
        run->mode = mode;
    }
    note_attempt(run, t_s);
    if (now->estimate.reseeded && mode == LODE_MODE_RUN) {
        runlog_note(run->log, t_s, "estimator reacquired");
    }
    const lode_fault_t *fault = &run->rig.drive->guard.fault;
    if (mode == LODE_MODE_FAULT && !run->faulted) {
        char what[120];
        fault_text(fault, what, sizeof what);
        (void)snprintf(text, sizeof text, "fault in %s: %s",
                       lode_mode_name((lode_mode_t)fault->state) + strlen("LODE_MODE_"), what);
        runlog_note(run->log, t_s, text);
        run->result->fault = *fault;
        run->result->fault_expected = false;
        run->result->fault_s = t_s;
    }
    run->faulted = mode == LODE_MODE_FAULT;
    note_open_phases(run, now);
}

/// The first broken phase, 1 .. 6; 0: none.
static int open_phase(const plant_truth_t *truth) {
    int leg = 0;
    while (leg < PLANT_LEGS && !truth->open[leg]) {
        ++leg;
    }
    return leg < PLANT_LEGS ? leg + 1 : 0;
}

static void log_inputs(const rig_t *rig, runlog_row_t *row) {
    const lode_ab_t i_A = rig_seen_i_A(rig);
    const lode_ab_t u_V = rig_next_u_V(rig);
    row->i_alpha_A = (double)i_A.alpha;
    row->i_beta_A = (double)i_A.beta;
    row->u_alpha_V = (double)u_V.alpha;
    row->u_beta_V = (double)u_V.beta;
}

static void log_injection(const rig_t *rig, const lode_telemetry_t *seen, runlog_row_t *row) {
    row->w_h = (double)seen->injected;
    row->er_h_deg = rig_deg_from_rad((double)seen->injection_error_rad);
    row->er_e_deg = rig_deg_from_rad((double)seen->emf_error_rad);
    row->Lq_H = rig_true_Lq_H(rig);
    row->Lq_est_H = (double)(rig->learns ? rig->learn.now.Lq_H : rig->learning.motor.Lq_H);
    row->psi_est_Wb = (double)(rig->learns ? rig->learn.now.psi_Wb : rig->learning.motor.psi_Wb);
    row->Lq_confidence = (double)seen->motor.Lq_H.confidence;
}

static void log_adaptation(const lode_telemetry_t *seen, runlog_row_t *row) {
    row->adapted_J_kgm2 = (double)seen->motor.J_kgm2.value;
    row->adapted_J_confidence = (double)seen->motor.J_kgm2.confidence;
    row->adapted_psi_Wb = (double)seen->motor.psi_Wb.value;
    row->adapted_psi_confidence = (double)seen->motor.psi_Wb.confidence;
    row->adapted_Rs_Ohm = (double)seen->motor.Rs_Ohm.value;
    row->adapted_Rs_confidence = (double)seen->motor.Rs_Ohm.confidence;
}

static void log_derating(const limits_t *limits, runlog_row_t *row) {
    row->winding_heat = (double)limits->derate.heat;
    row->derated_share = (double)limits->cool;
}

static bool log_row(run_t *run, int phase, const moment_t *now) {
    lode_telemetry_t seen;
    rig_tell(&run->rig, &seen);
    const plant_truth_t *truth = &now->at.truth;
    const lode_estimate_t *estimate = &now->at.estimate;
    const lode_abc_t duty_2 = rig_duty_2(&run->rig);
    const double np = (double)run->config->drive.motor.pole_pairs;
    const double est_rpm = rig_rpm_from_rad_s((double)estimate->omega_rad_s) / np;
    runlog_row_t row = {
        .t_s = (double)run->k * run->ts_s,
        .phase = phase,
        .mode = (double)seen.mode,
        .speed_command_rpm = run->speed_rpm,
        .speed_ref_rpm =
            seen.mode == LODE_MODE_RUN ? rig_rpm_from_rad_s((double)seen.speed_ref_rad_s) : NAN,
        .speed_rpm = rig_rpm_from_rad_s(truth->omega_m_rad_s),
        .speed_est_rpm = est_rpm,
        .theta_e_rad = truth->theta_e_rad,
        .theta_est_rad = (double)lode_estimate_theta_rad(estimate),
        .angle_error_deg = now->error_deg,
        .id_A = truth->id_A,
        .iq_A = truth->iq_A,
        .i1_A = (double)seen.i_A.d,
        .i2_A = (double)seen.i_A.q,
        .i1_ref_A = (double)seen.ref_A.d,
        .i2_ref_A = (double)seen.ref_A.q,
        .u1_V = (double)seen.u_V.d,
        .u2_V = (double)seen.u_V.q,
        .e_alpha_V = (double)estimate->e_V.alpha,
        .e_beta_V = (double)estimate->e_V.beta,
        .e_true_alpha_V = truth->e_alpha_V,
        .e_true_beta_V = truth->e_beta_V,
        .ia_A = truth->i_abc_A[0],
        .ib_A = truth->i_abc_A[1],
        .ic_A = truth->i_abc_A[2],
        .duty_a = (double)seen.duty.a,
        .duty_b = (double)seen.duty.b,
        .duty_c = (double)seen.duty.c,
        .ia2_A = truth->i_abc_A[3],
        .ib2_A = truth->i_abc_A[4],
        .ic2_A = truth->i_abc_A[5],
        .ix_A = truth->i_x_A,
        .iy_A = truth->i_y_A,
        .e_true_x_V = truth->e_x_V,
        .e_true_y_V = truth->e_y_V,
        .duty_a2 = (double)duty_2.a,
        .duty_b2 = (double)duty_2.b,
        .duty_c2 = (double)duty_2.c,
        .open_phase = (double)open_phase(truth),
        .found_open = (double)rig_found_open(&run->rig),
        .v_bus_V = (double)seen.v_bus_V,
        .lock = (double)estimate->lock,
        .torque_Nm = truth->torque_Nm,
        .load_Nm = run->load_Nm,
        .load_est_Nm = (double)estimate->load_torque_Nm,
    };
    log_inputs(&run->rig, &row);
    log_injection(&run->rig, &seen, &row);
    log_adaptation(&seen, &row);
    log_derating(&run->rig.limits, &row);
    return runlog_add(run->log, &row);
}

// ---- One period ---------------------------------------------------------------------------------

/// If there is a supervisor, it posts the command.
static void post_command(run_t *run) {
    if (!run->reactions.on) {
        (void)lode_drive_post_command(run->rig.drive, &run->command);
    }
}

static void move_command(run_t *run) {
    const double left_rpm = run->speed_goal_rpm - run->speed_rpm;
    if (fabs(left_rpm) <= 0.0) {
        return;
    }
    const bool there = fabs(left_rpm) <= run->speed_step_rpm;
    run->speed_rpm =
        there ? run->speed_goal_rpm : run->speed_rpm + copysign(run->speed_step_rpm, left_rpm);
    run->command.speed_rad_s = (float)rig_rad_s_from_rpm(run->speed_rpm);
    post_command(run);
}

static void step_rig(run_t *run, moment_t *now) {
    rig_step(&run->rig, run->estimate, &run->memory, &now->at);
    now->error_deg = rig_angle_error_deg((double)lode_estimate_theta_rad(&now->at.estimate),
                                         now->at.truth.theta_e_rad);
}

// ---- Phases -------------------------------------------------------------------------------------

static void apply_to_plant(run_t *run, const rig_phase_t *phase) {
    plant_t *plant = &run->rig.plant;
    if (!isnan(phase->load_Nm)) {
        run->load_Nm = phase->load_Nm + run->extra_load_Nm;
        plant_set_load(plant, run->load_Nm);
    }
    if (!isnan(phase->v_bus_V)) {
        run->v_bus_V = phase->v_bus_V;
        plant_set_bus(plant, phase->v_bus_V);
    }
    if (!isnan(phase->temperature_degC)) {
        plant_set_temperature(plant, phase->temperature_degC);
    }
    run->held = isnan(phase->dyno_rpm) ? run->held : !isinf(phase->dyno_rpm);
    if (isinf(phase->dyno_rpm)) {
        plant_release_speed(plant);
    } else if (!isnan(phase->dyno_rpm)) {
        plant_set_speed(plant, rig_rad_s_from_rpm(phase->dyno_rpm));
    }
    if (phase->trip >= 0) {
        plant_set_trip(plant, phase->trip == RIG_TRIP_ON);
        if (phase->trip >= RIG_TRIP_SET_1) {
            plant_set_trip_of(plant, phase->trip - RIG_TRIP_SET_1, true);
        }
    }
    if (phase->open_phase >= 0) {
        plant_open_phase(plant, phase->open_phase);
    }
    if (phase->shorted >= 0) {
        plant_fail_switch(plant, 0, phase->shorted == 1, true);
    }
}

/// Changes the motor parameters of the firmware during the run. False after a message.
static bool retune(run_t *run, const rig_phase_t *phase) {
    if (isnan(phase->Lq_factor) && isnan(phase->Rs_factor)) {
        return true;
    }
    run->Lq_factor = isnan(phase->Lq_factor) ? run->Lq_factor : phase->Lq_factor;
    run->Rs_factor = isnan(phase->Rs_factor) ? run->Rs_factor : phase->Rs_factor;
    lode_motor_t motor = run->config->drive.motor;
    motor.Lq_H *= (float)run->Lq_factor;
    motor.Rs_Ohm *= (float)run->Rs_factor;
    const lode_status_t status = rig_retune(&run->rig, run->config, &motor);
    if (status != LODE_OK) {
        rig_error("[phase.%s] Lq_factor = %g, Rs_factor = %g: expected factors with which the "
                  "library accepts the motor:",
                  phase->name, run->Lq_factor, run->Rs_factor);
        refusal_report(run->config, status);
        return false;
    }
    run->memory.euler_config.Lq_H = (double)motor.Lq_H;
    run->memory.euler_config.Rs_Ohm = (double)motor.Rs_Ohm;
    return true;
}

/// With RUN but without a speed, the drive stays OFF as intended.
static bool asks_for_speed(const run_t *run) {
    return run->command.mode == LODE_MODE_RUN && fabs(run->speed_goal_rpm) > 0.0;
}

static void note_command(run_t *run, const rig_phase_t *phase) {
    if (asks_for_speed(run)) {
        run->commanded = true;
        run->excused =
            run->excused || (phase->end_mode >= 0 && phase->end_mode != (int)LODE_MODE_RUN);
    }
}

/// At the end of the last phase that commands a speed.
static void note_attempts(run_t *run) {
    runner_result_t *result = run->result;
    const bool starts = run->mode == LODE_MODE_PRECHARGE || run->mode == LODE_MODE_START;
    if (asks_for_speed(run)) {
        result->starts_yet =
            starts && !run->excused && !isnan(result->handover_s) && result->retries > 0;
    }
}

static void set_if_given(float *field, double value) {
    *field = isnan(value) ? *field : (float)value;
}

static void apply_to_command(run_t *run, const rig_phase_t *phase) {
    static const lode_mode_t modes[] = {LODE_MODE_OFF, LODE_MODE_CALIBRATE, LODE_MODE_VOLTAGE,
                                        LODE_MODE_CURRENT, LODE_MODE_RUN};
    lode_command_t *command = &run->command;
    command->mode = phase->mode >= 0 ? modes[phase->mode] : command->mode;
    command->control = phase->control >= 0 ? (lode_control_t)phase->control : command->control;
    set_if_given(&command->torque_Nm, phase->torque_Nm);
    set_if_given(&command->vector.d, phase->d);
    set_if_given(&command->vector.q, phase->q);
    set_if_given(&command->theta_rad, rig_rad_from_deg(phase->theta_deg));
    set_if_given(&command->omega_rad_s, phase->omega_rad_s);
    run->speed_goal_rpm = isnan(phase->speed_rpm) ? run->speed_goal_rpm : phase->speed_rpm;
    const bool at_once = isnan(phase->ramp_rpm_s);
    run->speed_step_rpm = at_once ? HUGE_VAL : phase->ramp_rpm_s * run->ts_s;
    run->speed_rpm = at_once ? run->speed_goal_rpm : run->speed_rpm;
    command->speed_rad_s = (float)rig_rad_s_from_rpm(run->speed_rpm);
    post_command(run);
}

/// NaN counts as less than any number.
static double larger(double a, double b) {
    return a >= b || isnan(b) ? a : b;
}

static void measure_supply(run_t *run, runner_phase_t *out, const plant_truth_t *truth) {
    const double v_bus_V = plant_bus_V(&run->rig.plant);
    const double i_A = (truth->energy.bus_J - run->drawn_J) / (run->ts_s * v_bus_V);
    run->drawn_J = truth->energy.bus_J;
    if (run->looks_at_supply) {
        run->supply_A += (i_A - run->supply_A) * (1.0 - exp(-run->ts_s / RUNNER_SUPPLY_s));
        out->battery_A = larger(out->battery_A, run->supply_A);
        out->regen_A = larger(out->regen_A, -run->supply_A);
        out->v_bus_V = larger(out->v_bus_V, v_bus_V);
    }
}

static void measure_derating(const limits_t *limits, runner_phase_t *out) {
    if (limits->by_heat) {
        out->heat = larger(out->heat, (double)limits->derate.heat);
        out->derated_share = fmin(out->derated_share, (double)limits->cool);
    }
}

static void measure(const run_t *run, runner_phase_t *out, const moment_t *now, bool in_window) {
    const plant_truth_t *truth = &now->at.truth;
    const lode_estimate_t *estimate = &now->at.estimate;
    const double np = (double)run->config->drive.motor.pole_pairs;
    const double rpm = rig_rpm_from_rad_s(truth->omega_m_rad_s);
    const bool running = run->mode == LODE_MODE_RUN;
    if (running && run->driven) {
        rig_stats_add(&out->run_error_deg, now->error_deg);
        rig_stats_add(&out->run_lock, (double)estimate->lock);
        out->reseeds += estimate->reseeded ? 1u : 0u;
    }
    if (!in_window) {
        return;
    }
    rig_stats_add(&out->speed_rpm, rpm);
    rig_stats_add(&out->id_A, truth->id_A);
    rig_stats_add(&out->iq_A, truth->iq_A);
    rig_stats_add(&out->torque_Nm, truth->torque_Nm);
    rig_stats_add(&out->i_xy_A, hypot(truth->i_x_A, truth->i_y_A));
    if (running) {
        rig_stats_add(&out->error_deg, now->error_deg);
        rig_stats_add(&out->speed_error_rpm,
                      rig_rpm_from_rad_s((double)estimate->omega_rad_s) / np - rpm);
        rig_stats_add(&out->load_est_Nm, (double)estimate->load_torque_Nm);
    }
}

static void check_bar(runner_phase_t *out, const char *what, double measured, double bar) {
    // A value that does not exist (NaN) also misses its bar.
    if (isnan(bar) || measured <= bar) {
        return;
    }
    const size_t used = strlen(out->missed);
    (void)snprintf(out->missed + used, sizeof out->missed - used, "%s%s %.3g, bar %.3g",
                   used > 0 ? "; " : "", what, measured, bar);
}

static void check_bars(run_t *run, const rig_phase_t *phase, runner_phase_t *out) {
    check_bar(out, "angle error mean", fabs(rig_stats_mean(&out->error_deg)), phase->bar_dc_deg);
    check_bar(out, "angle error pp", rig_stats_peak_to_peak(&out->error_deg), phase->bar_pp_deg);
    check_bar(out, "angle error max", rig_stats_peak(&out->run_error_deg), phase->bar_error_deg);
    check_bar(out, "speed off by", fabs(rig_stats_mean(&out->speed_rpm) - out->speed_command_rpm),
              phase->bar_speed_rpm);
    check_bar(out, "torque off by",
              fabs(rig_stats_mean(&out->torque_Nm) - (double)run->command.torque_Nm),
              phase->bar_torque_Nm);
    check_bar(out, "Lq off by percent", fabs(out->Lq_off_percent), phase->bar_Lq_percent);
    check_bar(out, "current out of the supply", out->battery_A, phase->bar_battery_A);
    check_bar(out, "current into the supply", out->regen_A, phase->bar_regen_A);
    check_bar(out, "bus voltage", out->v_bus_V, phase->bar_v_bus_V);
    check_bar(out, "heat of the winding", out->heat, phase->bar_heat);
    if (phase->end_mode >= 0 && (int)out->mode != phase->end_mode) {
        const size_t used = strlen(out->missed);
        (void)snprintf(out->missed + used, sizeof out->missed - used, "%sended in %s, bar %s",
                       used > 0 ? "; " : "", lode_mode_name(out->mode),
                       lode_mode_name((lode_mode_t)phase->end_mode));
    }
    if (run->faulted && phase->end_mode == (int)LODE_MODE_FAULT) {
        run->result->fault_expected = true;
    }
    run->result->missed = run->result->missed || out->missed[0] != '\0';
}

static bool is_barred(const rig_phase_t *phase) {
    return !isnan(phase->bar_dc_deg) || !isnan(phase->bar_pp_deg) || !isnan(phase->bar_error_deg) ||
           !isnan(phase->bar_speed_rpm) || !isnan(phase->bar_torque_Nm) ||
           !isnan(phase->bar_Lq_percent) || !isnan(phase->bar_battery_A) ||
           !isnan(phase->bar_regen_A) || !isnan(phase->bar_v_bus_V) || !isnan(phase->bar_heat) ||
           phase->end_mode >= 0;
}

static void warn(runner_phase_t *out, const char *format, ...) RIG_PRINTF(2, 3);
static void warn(runner_phase_t *out, const char *format, ...) {
    const size_t used = strlen(out->warning);
    va_list arguments;
    (void)snprintf(out->warning + used, sizeof out->warning - used, "%s", used > 0 ? "; " : "");
    const size_t now = strlen(out->warning);
    va_start(arguments, format);
    (void)vsnprintf(out->warning + now, sizeof out->warning - now, format, arguments);
    va_end(arguments);
    out->warnings++;
}

/// Reason why the drive is not in RUN yet.
static void tell_start(const run_t *run, lode_mode_t mode, char *text, size_t size) {
    const int failed = (int)lode_drive_retries(run->rig.drive);
    const char *name = lode_mode_name(mode) + strlen("LODE_MODE_");
    const uint32_t criterion = run->rig.drive->guard.fault.criterion; // none: a search by injection
    if (failed > 0 && criterion != (uint32_t)LODE_CRITERION_NONE) {
        (void)snprintf(text, size, ", in %s, attempt %d; the last one failed by %s", name,
                       failed + 1, fault_text_criterion(&run->rig.drive->guard.fault));
    } else {
        (void)snprintf(text, size, ", in %s", name);
    }
}

/// Decimals of a speed in a warning.
static int decimals(double rpm) {
    return fabs(rpm) < 10.0 ? 2 : (fabs(rpm) < 100.0 ? 1 : 0);
}

/// Reason why RUN has not reached a speed, if the run or the configuration shows it.
static const char *why_not(const run_t *run, double omega_rad_s) {
    const speed_limits_t *limits = &run->limits;
    const double share = run->v_bus_V / (double)run->config->drive.inverter.v_bus_V;
    const double voltage_rad_s =
        share * (isnan(limits->weakened_rad_s) ? limits->no_load_rad_s : limits->weakened_rad_s);
    if (omega_rad_s > voltage_rad_s) {
        return ", above what the bus voltage allows without load";
    }
    if (fabs(run->rotor_rpm - run->speed_goal_rpm) <= SPEED_REACHED * fabs(run->speed_goal_rpm)) {
        return ", as the mean of the last part of the phase; by now the speed is reached";
    }
    if ((lode_drive_limited(run->rig.drive) & (uint32_t)LODE_LIMITED_TORQUE) == 0u) {
        return "";
    }
    return omega_rad_s > share * limits->base_rad_s
               ? ", above the base speed: the voltage limits the torque"
               : ", with all the torque that the drive may make";
}

/// Warns of a stop that is not over.
static void check_stop(const run_t *run, runner_phase_t *out) {
    const bool stops = run->command.mode == LODE_MODE_RUN && run->speed_goal_rpm == 0.0 &&
                       out->mode == LODE_MODE_START;
    if (stops && !run->held) {
        warn(out, "0 rpm not reached: %.*f rpm at the end, in START", decimals(run->rotor_rpm),
             run->rotor_rpm);
    }
}

/// Warns of a commanded speed that the drive changed or did not reach. No speed is expected of a shaft held by
/// a dynamometer, at a stop, with torque control, or after a fault.
static void check_speed(const run_t *run, const rig_phase_t *phase, runner_phase_t *out) {
    const double goal_rpm = run->speed_goal_rpm;
    const double np = (double)run->config->drive.motor.pole_pairs;
    const double omega = fabs(rig_rad_s_from_rpm(goal_rpm)) * np;
    const bool commanded = run->command.mode == LODE_MODE_RUN &&
                           run->command.control == LODE_CONTROL_SPEED && omega > 0.0;
    check_stop(run, out);
    if (run->held || run->faulted || !commanded) {
        return;
    }
    const double most_rpm = rig_rpm_from_rad_s(run->limits.estimator_rad_s) / np;
    if (phase->commanded_rpm > 0.0) {
        warn(out, "%.*f rpm is above %g of the estimator's limit of %.*f rpm, lowered to %.*f rpm",
             decimals(phase->commanded_rpm), phase->commanded_rpm, TRIAL_ESTIMATOR_SHARE,
             decimals(most_rpm), most_rpm, decimals(phase->speed_rpm), phase->speed_rpm);
    }
    const double trip_rad_s = (double)run->config->drive.guard.omega_max_rad_s;
    if (omega > fmin(trip_rad_s, run->limits.estimator_rad_s)) {
        const bool by_guard = trip_rad_s < run->limits.estimator_rad_s;
        out->refused = true;
        const double limit_rpm = by_guard ? rig_rpm_from_rad_s(trip_rad_s) / np : most_rpm;
        warn(out, "the drive refuses %g rpm and keeps the previous command: %s %.*f rpm", goal_rpm,
             by_guard ? "OVER_SPEED trips at" : "the estimator's limit is", decimals(limit_rpm),
             limit_rpm);
        return;
    }
    const double least_rpm = rig_rpm_from_rad_s(run->limits.least_rad_s) / np;
    const double found_rpm = rig_stats_mean(&out->speed_rpm);
    if (fabs(goal_rpm) < least_rpm && run->config->source != RIG_SOURCE_ENCODER) {
        warn(out, "%g rpm is below the least speed and was raised to %.*f rpm", goal_rpm,
             decimals(least_rpm), copysign(least_rpm, goal_rpm));
    } else if (!(fabs(found_rpm - goal_rpm) <= SPEED_REACHED * fabs(goal_rpm))) {
        char why[100] = "";
        if (out->mode == LODE_MODE_RUN) {
            (void)snprintf(why, sizeof why, "%s", why_not(run, omega));
        } else {
            tell_start(run, out->mode, why, sizeof why);
        }
        warn(out, "%g rpm not reached: %.*f rpm at the end%s", goal_rpm, decimals(found_rpm),
             found_rpm, why);
    }
}

/// Warns of a commanded torque that is beyond a limit; where a speed is held, another one is right.
static void check_torque(const run_t *run, runner_phase_t *out) {
    const double wanted_Nm = (double)run->command.torque_Nm;
    const double found_Nm = rig_stats_mean(&out->torque_Nm);
    const bool commanded =
        run->command.mode == LODE_MODE_RUN && run->command.control == LODE_CONTROL_TORQUE;
    const uint32_t limited = lode_drive_limited(run->rig.drive) &
                             ((uint32_t)LODE_LIMITED_TORQUE | (uint32_t)LODE_LIMITED_HELD);
    lode_telemetry_t now;
    if (!commanded || limited != (uint32_t)LODE_LIMITED_TORQUE ||
        fabs(wanted_Nm - found_Nm) <= TORQUE_REACHED * fabs(wanted_Nm)) {
        return;
    }
    rig_tell(&run->rig, &now);
    const double most_Nm = (double)now.torque_most_Nm;
    if (fabs(wanted_Nm) > most_Nm) {
        warn(out, "%g Nm not reached: %.4g Nm at the end; i_max allows %.4g Nm", wanted_Nm,
             found_Nm, most_Nm);
    } else if (run->rig.limits.by_heat && run->rig.limits.cool < 1.0f) {
        warn(out, "%g Nm not reached: %.4g Nm at the end; derating permits %.0f %% of the torque",
             wanted_Nm, found_Nm, 100.0 * (double)run->rig.limits.cool);
    } else {
        warn(out, "%g Nm not reached: %.4g Nm at the end; voltage or bus limit it", wanted_Nm,
             found_Nm);
    }
}

/// Beyond its flux map the machine is not known, so the run ends without a result.
static bool is_in_map(const run_t *run, const plant_truth_t *truth) {
    const plant_map_t *map = run->rig.plant.motor.iron.map;
    if (map == NULL || plant_map_holds(map, truth->id_A, truth->iq_A)) {
        return true;
    }
    rig_error("[plant] flux_map: at %.4g s the currents were i_d = %.4g, i_q = %.4g A; expected a "
              "map that covers them; this one covers i_d from %g to %g, i_q from %g to %g A",
              truth->t_s, truth->id_A, truth->iq_A, map->id_A[0], map->id_A[map->rows - 1],
              map->iq_A[0], map->iq_A[map->columns - 1]);
    return false;
}

static bool run_period(run_t *run, int index, runner_phase_t *out, bool in_window) {
    moment_t now;
    run->driven = run->rig.drive->gates;
    move_command(run);
    step_rig(run, &now);
    rig_main_loop(&run->rig);
    reactions_step(&run->reactions, run->rig.drive, run->command);
    if (run->log->capture != NULL) {
        capture_step(run->log->capture, run->rig.drive);
    }
    note_changes(run, &now.at);
    run->rotor_rpm = rig_rpm_from_rad_s(now.at.truth.omega_m_rad_s);
    if (!is_in_map(run, &now.at.truth)) {
        return false;
    }
    measure(run, out, &now, in_window);
    measure_supply(run, out, &now.at.truth);
    measure_derating(&run->rig.limits, out);
    const bool good = run->k % run->log_every != 0 || log_row(run, index, &now);
    run->k++;
    if (run->k % PERIODS_PER_PROGRESS == 0) {
        progress_show(&run->progress, fmin((double)run->k * run->ts_s / run->total_s, 1.0),
                      out->name);
    }
    return good;
}

/// The periods of a phase: how many, from which on steady values count, and how many in a row the speed has been
/// reached.
typedef struct {
    uint64_t end, from, reached;
} span_t;

static span_t span_of(const run_t *run, const rig_phase_t *phase) {
    const uint64_t periods = (uint64_t)llround(phase->duration_s / run->ts_s);
    const uint64_t window = (uint64_t)llround(RUNNER_WINDOW_s / run->ts_s);
    return (span_t){.end = periods, .from = periods > window ? periods - window : 0};
}

/// Ends a phase that lasts until its speed has settled, after one more window. `k`: the present period.
static void shorten(const run_t *run, const rig_phase_t *phase, uint64_t k, span_t *span) {
    const uint64_t window = (uint64_t)llround(RUNNER_WINDOW_s / run->ts_s);
    const double off_rpm = fabs(run->rotor_rpm - run->speed_goal_rpm);
    const bool reached = run->mode == LODE_MODE_RUN && run->rig.drive->gates &&
                         off_rpm <= SPEED_REACHED * fabs(run->speed_goal_rpm);
    span->reached = reached ? span->reached + 1u : 0u;
    if (phase->settled_s > 0.0 && k < span->from &&
        (double)(span->reached + window) * run->ts_s >= phase->settled_s) {
        span->from = k + 1u;
        span->end = span->from + window;
    }
}

static bool run_phase(run_t *run, int index) {
    const rig_phase_t *phase = &run->config->scenario.phase[index];
    runner_phase_t *out = &run->result->phase[index];
    span_t span = span_of(run, phase);
    bool good = retune(run, phase);
    (void)snprintf(out->name, sizeof out->name, "%s", phase->name);
    out->start_s = (double)run->k * run->ts_s;
    out->battery_A = out->regen_A = out->v_bus_V = NAN;
    out->heat = out->derated_share = NAN;
    apply_to_plant(run, phase);
    uint64_t k = 0;
    if (good && phase->clear_fault == 1) {
        const lode_command_t clear = {.mode = LODE_MODE_OFF, .clear_fault = true};
        (void)lode_drive_post_command(run->rig.drive, &clear);
        good = run_period(run, index, out, false);
        k++;
    }
    apply_to_command(run, phase);
    note_command(run, phase);
    for (; good && k < span.end; ++k) {
        good = run_period(run, index, out, k >= span.from);
        shorten(run, phase, k, &span);
    }
    if (out->error_deg.count < span.end - span.from) {
        rig_stats_reset(&out->error_deg);
    }
    out->end_s = (double)run->k * run->ts_s;
    out->speed_command_rpm = run->speed_goal_rpm;
    out->load_Nm = run->load_Nm;
    out->mode = run->mode;
    note_attempts(run);
    out->Lq_off_percent =
        run->rig.learns ? 100.0 * ((double)run->rig.learn.now.Lq_H / rig_true_Lq_H(&run->rig) - 1.0)
                        : NAN;
    out->Lq_confidence = run->rig.learns ? (double)run->rig.learn.now.confidence : NAN;
    check_bars(run, phase, out);
    check_speed(run, phase, out);
    check_torque(run, out);
    run->result->phases = index + 1;
    return good;
}

static bool check_phases(const rig_config_t *config) {
    const rig_scenario_t *scenario = &config->scenario;
    const char *file = config->file[0];
    if (scenario->phases == 0) {
        rig_error_at(file, 0,
                     "no [phase.NAME]; expected at least one, with its duration_s. For a file with "
                     "only a motor use --motor");
        return false;
    }
    for (int k = 0; k < scenario->phases; ++k) {
        if (isnan(scenario->phase[k].duration_s)) {
            rig_error_at(file, 0, "[phase.%s] duration_s: missing; expected the phase's length",
                         scenario->phase[k].name);
            return false;
        }
    }
    return true;
}

/// The library is asked before the plant, because its refusal names the keys of the motor.
static bool check_drive(const rig_config_t *config) {
    const lode_status_t status = rig_config_judge(config);
    if (status != LODE_OK) {
        refusal_report(config, status);
    }
    return status == LODE_OK;
}

static bool check_adaptation(const rig_config_t *config) {
    const rig_adaptation_t *wanted = &config->adaptation;
    const bool any = wanted->J == 1 || wanted->psi == 1 || wanted->Rs == 1;
    for (int k = 0; any && k < config->scenario.phases; ++k) {
        const rig_phase_t *phase = &config->scenario.phase[k];
        if (!isnan(phase->Rs_factor)) {
            rig_error("[phase.%s] Rs_factor: expected none with [adaptation], which starts from "
                      "the configured Rs; for an error that it can find set plant.Rs_Ohm",
                      phase->name);
            return false;
        }
    }
    return true;
}

static bool start_reactions(run_t *run) {
    const lode_status_t status = reactions_init(&run->reactions, run->config, run->rig.drive);
    const lode_motor_t *motor = &run->config->drive.motor;
    if (status == LODE_ERROR_ACTIVE_SHORT) {
        rig_error(
            "[supervisor] active_short = on: %s: expected a motor whose psi/Ld, %.4g A, is at "
            "most i_max, %.4g A",
            lode_status_name(status), (double)(motor->psi_Wb / motor->Ld_H),
            (double)run->config->drive.inverter.i_max_A);
    }
    return status == LODE_OK;
}

#define COUNTS_PER_TURN 4096.0

/// LODE_OK, or why the library refuses the angle sensor.
static bool start_encoder(run_t *run) {
    const rig_encoder_t *given = &run->config->encoder;
    runner_memory_t *memory = &run->memory;
    const double counts = isnan(given->counts_per_turn) ? COUNTS_PER_TURN : given->counts_per_turn;
    const double np = (double)run->config->drive.motor.pole_pairs;
    const double offset_deg = isnan(given->offset_deg) ? 0.0 : given->offset_deg;
    memory->counts_per_turn = floor(counts);
    const lode_encoder_config_t config = {
        .counts_per_turn = (uint32_t)counts,
        // The sensor counts from angle 0; the middle of count 0 is half a count further.
        .offset_rad = (float)remainder(
            rig_rad_from_deg(offset_deg) + RIG_PI * np / memory->counts_per_turn, 2.0 * RIG_PI),
        .bandwidth_rad_s = isnan(given->bandwidth_rad_s) ? 0.0f : (float)given->bandwidth_rad_s,
        .falls_back = given->falls_back == 1,
    };
    const lode_status_t status =
        lode_encoder_tune(&memory->encoder_tuning, &config, run->rig.drive->tuning);
    lode_encoder_reset(&memory->encoder);
    if (status != LODE_OK) {
        rig_error("[encoder] bandwidth_rad_s = %g: %s: expected 1 .. %g, the rate of the step",
                  given->bandwidth_rad_s, lode_status_name(status),
                  (double)run->config->drive.f_pwm_Hz);
    }
    return status == LODE_OK;
}

static bool start(run_t *run) {
    const rig_scenario_t *scenario = &run->config->scenario;
    plant_config_t plant;
    if (!check_phases(run->config) || !check_drive(run->config) || !check_adaptation(run->config) ||
        !rig_config_plant(run->config, &plant, &run->extra_load_Nm)) {
        return false;
    }
    (void)rig_init(&run->rig, run->config, &plant);
    if (!start_reactions(run) || !limits_init(&run->rig.limits, run->config) ||
        !bus_init(&run->rig.bus, run->config)) {
        return false;
    }
    run->looks_at_supply = plant.keeps_accounts;
    run->limits = speed_limits_of(&run->config->drive);
    run->v_bus_V = plant.v_bus_V;
    run->log->sets = run->rig.sets;
    run->log->by_wave = run->config->drive.hfi.mode == LODE_HFI_ON;
    run->log->adapts = run->rig.adapts;
    run->log->derates = run->rig.limits.by_heat;
    run->memory.seeded_s = isnan(run->config->seeded_s) ? 0.0 : run->config->seeded_s;
    if (euler_estimate_wanted(run->config)) {
        run->memory.euler_config = euler_estimate_config(run->config);
    }
    if (run->config->source == RIG_SOURCE_ENCODER && !start_encoder(run)) {
        return false;
    }
    run->ts_s = 1.0 / (double)run->config->drive.f_pwm_Hz;
    run->command = (lode_command_t){.mode = LODE_MODE_RUN};
    run->mode = LODE_MODE_OFF;
    for (int k = 0; k < scenario->phases; ++k) {
        const rig_phase_t *phase = &scenario->phase[k];
        run->total_s +=
            phase->settled_s > 0.0 ? fmin(phase->about_s, phase->duration_s) : phase->duration_s;
        run->result->barred = run->result->barred || is_barred(&scenario->phase[k]);
    }
    const double log_s = isnan(scenario->log_s) ? run->total_s / (double)LOG_ROWS : scenario->log_s;
    run->log_every = (uint64_t)fmax(1.0, round(log_s / run->ts_s));
    if (run->extra_load_Nm > 0.0 || run->extra_load_Nm < 0.0) {
        run->load_Nm = run->extra_load_Nm;
        plant_set_load(&run->rig.plant, run->load_Nm);
    }
    return true;
}

/// Copies the drive's fault log. A fault that was followed by another start and by no other fault is over.
static void take_log(run_t *run) {
    runner_result_t *result = run->result;
    const lode_fault_log_t *log = &run->reactions.log;
    result->supervised = run->reactions.on;
    result->faults = (int)lode_fault_log_count(log);
    for (int k = 0; k < result->faults; ++k) {
        const lode_telemetry_t *row =
            lode_fault_log_row(log, (uint32_t)(result->faults - 1 - k), 0u);
        result->logged[k] = (runner_fault_t){(double)row->steps * run->ts_s, row->fault};
    }
    result->fault_expected = result->fault_expected || (result->supervised && !run->faulted);
}

bool runner_run(const rig_config_t *config, runner_estimator_t estimate, runner_result_t *result,
                runlog_t *log) {
    run_t run = {.config = config,
                 .estimate = estimate,
                 .result = result,
                 .log = log,
                 .Lq_factor = 1.0,
                 .Rs_factor = 1.0};
    *result = (runner_result_t){.handover_s = NAN, .fault_s = NAN};
    if (!start(&run)) {
        return false;
    }
    progress_start(&run.progress);
    bool good = true;
    for (int k = 0; good && k < config->scenario.phases; ++k) {
        // After a fault that no phase clears, the run can end.
        if (!run.faulted || run.reactions.on || config->scenario.phase[k].clear_fault == 1) {
            good = run_phase(&run, k);
        }
    }
    take_log(&run);
    result->never_ran = run.commanded && !run.excused && isnan(result->handover_s) &&
                        (result->supervised || result->fault.check == LODE_CHECK_NONE);
    result->adapts = run.rig.adapts;
    result->learns = run.rig.learns;
    rig_tell(&run.rig, &result->last);
    result->simulated_s = (double)run.k * run.ts_s;
    result->processor_s = progress_end(&run.progress);
    return good;
}
