#include "design/verdict.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "config/load_step.h"
#include "support/units.h"

#define STEP_SHARE_LEAST 0.35 // simulated drives withstand 1.1 to 2.1 times as much: about half
#define MARGIN_LEAST_deg 30.0
#define TOLERANCE 1.01 // of a rated speed, whose catalogue value is rounded

// ---- Load steps ------------------------------------------------------------------------------------

static verdict_step_t step_at(const lode_drive_config_t *drive, const lode_drive_tuning_t *tuning,
                              double omega_rad_s, double rated_Nm) {
    const load_step_t step = load_step_largest(drive, &tuning->speed, omega_rad_s);
    return (verdict_step_t){.omega_rad_s = omega_rad_s,
                            .torque_Nm = step.torque_Nm,
                            .share = step.torque_Nm / rated_Nm,
                            .by_current = step.by_current};
}

// ---- What to change ----------------------------------------------------------------------------------

#if defined(__GNUC__)
__attribute__((format(printf, 4, 5)))
#endif
static void
add_change(verdict_t *verdict, const char *key, const char *help, const char *format, ...) {
    if (verdict->changes == VERDICT_CHANGES_MAX) {
        return;
    }
    verdict_change_t *change = &verdict->change[verdict->changes++];
    *change = (verdict_change_t){.key = key};
    (void)snprintf(change->help, sizeof change->help, "%s", help);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(change->text, sizeof change->text, format, arguments);
    va_end(arguments);
}

static double rpm_of(const lode_drive_config_t *drive, double omega_rad_s) {
    return rig_rpm_from_rad_s(omega_rad_s) / (double)drive->motor.pole_pairs;
}

static void judge_speeds(verdict_t *verdict, const lode_drive_config_t *drive,
                         const speed_limits_t *speeds) {
    const double rated = (double)drive->motor.omega_rated_rad_s;
    const bool weakens = !isnan(speeds->weakened_rad_s);
    const double voltage = weakens ? speeds->weakened_rad_s : speeds->no_load_rad_s;
    const double rpm = rpm_of(drive, rated);
    if (rated > speeds->estimator_rad_s) {
        add_change(verdict, "rated_above_estimator",
                   "raise f_pwm_Hz (or omega_max_rad_s if given), or lower speed_rated_rpm",
                   "rated speed %.0f rpm is above the estimator's limit of %.0f rpm", rpm,
                   rpm_of(drive, speeds->estimator_rad_s));
    }
    if (rated > voltage) {
        add_change(verdict, "rated_above_voltage",
                   weakens ? "raise v_bus_V or id_max_A, or lower speed_rated_rpm"
                           : "raise v_bus_V or weaken the field (field_weakening = on), or lower "
                             "speed_rated_rpm",
                   "rated speed %.0f rpm is above the %.0f rpm that the voltage allows", rpm,
                   rpm_of(drive, voltage));
    } else if (rated > TOLERANCE * speeds->rated_torque_rad_s && !weakens) {
        add_change(verdict, "rated_torque_above_voltage",
                   "raise v_bus_V, weaken the field (field_weakening = on), or lower "
                   "speed_rated_rpm",
                   "rated torque is possible up to %.0f rpm, not to the rated %.0f rpm",
                   rpm_of(drive, speeds->rated_torque_rad_s), rpm);
    }
    if (speeds->base_rad_s < verdict->step[VERDICT_LOW].omega_rad_s) {
        add_change(verdict, "base_below_handover", "raise v_bus_V or lower i_max_A",
                   "i_max uses up the voltage at %.0f rpm, below the lowest speed of %.0f rpm",
                   rpm_of(drive, speeds->base_rad_s),
                   rpm_of(drive, verdict->step[VERDICT_LOW].omega_rad_s));
    }
}

static bool is_short(const verdict_t *verdict, int k) {
    const verdict_step_t *step = &verdict->step[k];
    const bool below = step->omega_rad_s < verdict->step[VERDICT_LOW].omega_rad_s; // reported
    return step->share < STEP_SHARE_LEAST && !below;
}

/// By the tenths that are printed.
static bool is_tight(const analyse_loop_t *loop) {
    return !(round(10.0 * loop->phase_deg) >= 10.0 * MARGIN_LEAST_deg) &&
           !isnan(loop->crossover_rad_s);
}

/// A larger load step needs a higher sigma, a larger margin of the PLL a lower one: a higher w0 helps both.
static bool needs_w0(const verdict_t *verdict, int k) {
    return is_short(verdict, k) && !verdict->step[k].by_current && is_tight(&verdict->loop[k].pll);
}

static void judge_steps(verdict_t *verdict, const lode_drive_config_t *drive) {
    static const char *const keys[VERDICT_SPEEDS] = {"step_at_handover", "step_at_base"};
    static const char *const helps[VERDICT_SPEEDS][2] = {
        {"raise omega_min_rad_s or omega_handover_rad_s (and the commanded speeds), kp_Nms with "
         "sigma_low_rad_s, or the inertia",
         "raise w0_rad_s first, then kp_Nms with sigma_low_rad_s; or omega_min_rad_s or "
         "omega_handover_rad_s (and the commanded speeds), or the inertia"},
        {"raise kp_Nms or gain_rise with sigma_rad_s, or the inertia",
         "raise w0_rad_s first, then kp_Nms or gain_rise with sigma_rad_s; or the inertia"}};
    for (int k = 0; k < VERDICT_SPEEDS; ++k) {
        const verdict_step_t *step = &verdict->step[k];
        if (is_short(verdict, k)) {
            add_change(verdict, keys[k],
                       step->by_current ? "raise i_max_A" : helps[k][needs_w0(verdict, k) ? 1 : 0],
                       "the largest load step at %.0f rpm is %.0f %% of rated torque",
                       rpm_of(drive, step->omega_rad_s), 100.0 * step->share);
        }
    }
}

static void judge_margin(verdict_t *verdict, const analyse_loop_t *loop, const char *key,
                         const char *help) {
    if (is_tight(loop)) {
        add_change(verdict, key, help, "phase margin of %s at %.0f rpm is %.1f degrees", loop->name,
                   loop->speed_rpm, loop->phase_deg);
    }
}

static void judge_margins(verdict_t *verdict) {
    static const char *const helps[VERDICT_SPEEDS][2] = {
        {"lower sigma_low_rad_s, or raise w0_rad_s",
         "raise w0_rad_s first; a lower sigma_low_rad_s would make the load step smaller still"},
        {"lower [estimator] sigma_rad_s, or raise w0_rad_s",
         "raise w0_rad_s first; a lower [estimator] sigma_rad_s would make the load step smaller "
         "still"}};
    judge_margin(verdict, &verdict->loop[VERDICT_LOW].current, "margin_current",
                 "lower [current] bandwidth_rad_s, or raise f_pwm_Hz");
    for (int k = 0; k < VERDICT_SPEEDS; ++k) {
        const own_margins_t *at = &verdict->loop[k];
        judge_margin(verdict, &at->pll, "margin_pll", helps[k][needs_w0(verdict, k) ? 1 : 0]);
        judge_margin(verdict, &at->speed, "margin_speed",
                     k == VERDICT_LOW ? "lower [speed] bandwidth_rad_s or kp_Nms"
                                      : "lower [speed] gain_rise or kp_Nms");
    }
}

void verdict_compute(verdict_t *verdict, const lode_drive_config_t *drive,
                     const lode_drive_tuning_t *tuning, const speed_limits_t *speeds) {
    const double rated = (double)drive->motor.omega_rated_rad_s;
    const double low =
        fmax((double)drive->start.omega_handover_rad_s, (double)drive->speed.omega_min_rad_s);
    const double base = fmin(speeds->base_rad_s, speeds->estimator_rad_s);
    const double rated_Nm = (double)lode_motor_kt_Nm_A(&drive->motor) *
                            (double)drive->inverter.i_max_A / SPEED_LIMITS_CONTROL;
    *verdict = (verdict_t){
        .lowest_rad_s = speeds->least_rad_s,
        .highest_rad_s = speed_limits_highest_rad_s(speeds),
        .rated_torque_Nm = rated_Nm,
        .loop_rad_s = {low, fmin(rated, speeds->estimator_rad_s)},
    };
    verdict->step[VERDICT_LOW] = step_at(drive, tuning, low, rated_Nm);
    verdict->step[VERDICT_HIGH] = step_at(drive, tuning, base, rated_Nm);
    for (int k = 0; k < VERDICT_SPEEDS; ++k) {
        verdict->loop[k] = own_loops_at(drive, tuning, verdict->loop_rad_s[k]);
    }
    judge_speeds(verdict, drive, speeds);
    judge_steps(verdict, drive);
    judge_margins(verdict);
    const uint32_t warnings = lode_drive_warnings(drive);
    if ((warnings & (uint32_t)LODE_WARNING_EMF) != 0u) {
        add_change(verdict, "no_usable_emf",
                   "use a motor with less resistance or more flux, a higher v_bus_V, or an angle "
                   "sensor",
                   "no usable EMF (see limits)");
    }
    if ((warnings & (uint32_t)LODE_WARNING_INJECTION) != 0u) {
        add_change(
            verdict, "no_injection",
            "a higher v_bus_V, or less noise in the currents; hfi.mode = on tells what is missing",
            "the current vector of a start has too little torque, and injection is not possible");
    }
}
