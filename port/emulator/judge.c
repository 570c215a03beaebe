#include "judge.h"

#include "machine.h"
#include "motor.h"
#include "semihost.h"

// Written in the period; read after the last period that counts.
static volatile uint32_t periods;
static uint32_t faults;
static uint32_t settled_not_run;
static float speed_rad_s;   // mechanical, last
static float worst_slip;    // share of the command
static float worst_settled; // sine of the angle's error
static float worst_run;
static lode_fault_t fault;
static lode_mode_t mode;

static bool settled(void) {
    return periods > JUDGE_PERIODS - JUDGE_SETTLED_PERIODS;
}

void judge_note(const plant_t *plant, const lode_telemetry_t *now) {
    if (judge_done()) {
        return;
    }
    periods++;
    mode = now->mode;
    speed_rad_s = plant->omega_rad_s / motor_data().pole_pairs;
    if (mode == LODE_MODE_FAULT) {
        faults++;
        fault = now->fault;
    }
    // An error above a quarter turn counts as a quarter turn.
    const lode_sincos_t error = lode_angle_subtract(lode_sincos(now->theta_rad), plant->rotor);
    const float off = error.cos > 0.0f ? lode_abs(error.sin) : 1.0f;
    if (mode == LODE_MODE_RUN) {
        worst_run = lode_max(worst_run, off);
    }
    if (settled()) {
        settled_not_run += mode == LODE_MODE_RUN ? 0u : 1u;
        worst_settled = lode_max(worst_settled, off);
        worst_slip = lode_max(worst_slip, lode_abs(speed_rad_s / MOTOR_SPEED_rad_s - 1.0f));
    }
}

bool judge_done(void) {
    return periods >= JUDGE_PERIODS;
}

// One line: name, value, limit.
static bool at_most(const char *what, float figure, float limit, const char *unit) {
    const bool good = figure <= limit;
    semihost_print(good ? "ok   " : "FAIL ");
    semihost_print(what);
    semihost_print_float(figure);
    semihost_print(unit);
    semihost_print(", at most ");
    semihost_print_float(limit);
    semihost_print("\n");
    return good;
}

static bool no_tick_lost(void) {
    const uint32_t entries = machine_entries();
    const uint32_t elapsed = machine_elapsed();
    const bool good = entries == elapsed && entries > 0u;
    semihost_print(good ? "ok   " : "FAIL ");
    semihost_print("ticks: ");
    semihost_print_unsigned(entries);
    semihost_print(" interrupts in ");
    semihost_print_unsigned(elapsed);
    semihost_print(" periods of the second timer\n");
    return good;
}

static bool no_fault(void) {
    semihost_print(faults == 0u ? "ok   " : "FAIL ");
    semihost_print("fault: ");
    semihost_print(lode_check_name((lode_check_t)fault.check));
    semihost_print("\n");
    return faults == 0u;
}

static bool in_run(void) {
    const bool good = mode == LODE_MODE_RUN && settled_not_run == 0u;
    semihost_print(good ? "ok   " : "FAIL ");
    semihost_print("mode at the end: ");
    semihost_print(lode_mode_name(mode));
    semihost_print("\n");
    return good;
}

bool judge_verdict(void) {
    const float rpm = 30.0f / LODE_PI;
    const float deg = 180.0f / LODE_PI; // of a sine: 0.1 % too small at 5 degrees
    bool good = no_fault();
    good = in_run() && good;
    good = at_most("speed off by ", worst_slip * MOTOR_SPEED_rad_s * rpm,
                   JUDGE_SPEED_BAND * MOTOR_SPEED_rad_s * rpm, " rpm") &&
           good;
    good = at_most("angle off, settled ", worst_settled * deg, JUDGE_ANGLE_SETTLED_rad * deg,
                   " deg") &&
           good;
    good = at_most("angle off, ever in RUN ", worst_run * deg, JUDGE_ANGLE_RUN_rad * deg, " deg") &&
           good;
    if (machine_has_timer()) {
        good = no_tick_lost() && good;
    }
    semihost_print("last true speed ");
    semihost_print_float(speed_rad_s * rpm);
    semihost_print(" rpm\n");
    return good;
}
