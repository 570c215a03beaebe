#include "support/fault_text.h"

#include <stdio.h>
#include <string.h>

/// Unit of a criterion; empty for a ratio.
static const char *unit_of(lode_criterion_t criterion) {
    switch (criterion) {
    case LODE_CRITERION_CURRENT:
        return " in A";
    case LODE_CRITERION_REST:
    case LODE_CRITERION_HOLD:
        return " in s";
    case LODE_CRITERION_RAMP:
    case LODE_CRITERION_SPEED:
        return " in electrical rad/s";
    case LODE_CRITERION_EMF:
        return " in V";
    case LODE_CRITERION_NONE:
    case LODE_CRITERION_FLUX:
    case LODE_CRITERION_LOCK:
    case LODE_CRITERION_PROOF:
    case LODE_CRITERION_OPEN_PHASE:
    case LODE_CRITERION_POLARITY:
    case LODE_CRITERION_COUNT:
    default:
        return "";
    }
}

/// Unit of a check; empty for numbers, ratios, and checks whose unit depends on the mode or the criterion.
static const char *unit_of_check(lode_check_t check) {
    static const struct {
        lode_check_t check;
        const char *unit;
    } units[] = {
        {LODE_CHECK_OVER_CURRENT, " in A"},
        {LODE_CHECK_CURRENT_RAIL, " in A"},
        {LODE_CHECK_CURRENT_SUM, " in A"},
        {LODE_CHECK_CURRENT_CONTROL, " in A"},
        {LODE_CHECK_SWITCH_SHORTED, " in A"},
        {LODE_CHECK_SIGNALS, " in A"},
        {LODE_CHECK_OVER_VOLTAGE, " in V"},
        {LODE_CHECK_UNDER_VOLTAGE, " in V"},
        {LODE_CHECK_OVER_TEMPERATURE, " in degC"},
        {LODE_CHECK_UNDER_TEMPERATURE, " in degC"},
        {LODE_CHECK_OVER_SPEED, " in electrical rad/s"},
        {LODE_CHECK_WRONG_WAY, " in electrical rad/s"},
        {LODE_CHECK_OVERLOAD, " in electrical rad/s"},
        {LODE_CHECK_FLUX, " in Wb"},
        {LODE_CHECK_RESISTANCE, " in Ohm"},
        {LODE_CHECK_INDUCTANCE, " in H"},
        {LODE_CHECK_TIMING, " in counts"},
    };
    for (size_t k = 0; k < sizeof units / sizeof units[0]; ++k) {
        if (units[k].check == check) {
            return units[k].unit;
        }
    }
    return "";
}

const char *fault_text_criterion(const lode_fault_t *fault) {
    return lode_criterion_name((lode_criterion_t)fault->criterion) + strlen("LODE_CRITERION_");
}

const char *fault_text_stage(const lode_fault_t *fault) {
    return lode_start_stage_name((lode_start_stage_t)fault->stage) + strlen("LODE_START_");
}

/// "EMF in V, stage TURN", or one of the two, or nothing.
static void describe_start(const lode_fault_t *fault, char *text, size_t size) {
    const bool has_stage = fault->stage != (uint_least8_t)LODE_START_NONE;
    const bool has_criterion = fault->criterion != (uint_least8_t)LODE_CRITERION_NONE;
    (void)snprintf(text, size, "%s%s%s%s%s", has_criterion ? fault_text_criterion(fault) : "",
                   unit_of((lode_criterion_t)fault->criterion),
                   has_criterion && has_stage ? ", " : "", has_stage ? "stage " : "",
                   has_stage ? fault_text_stage(fault) : "");
}

void fault_text(const lode_fault_t *fault, char *text, size_t size) {
    char start[64];
    describe_start(fault, start, sizeof start);
    if (fault->check == (uint_least8_t)LODE_CHECK_NONE) {
        (void)snprintf(text, size, "%s, measured %.4g, limit %.4g", start, (double)fault->measured,
                       (double)fault->limit);
        return;
    }
    (void)snprintf(text, size, "%s%s, measured %.4g, limit %.4g%s%s%s",
                   lode_check_name((lode_check_t)fault->check),
                   unit_of_check((lode_check_t)fault->check), (double)fault->measured,
                   (double)fault->limit, start[0] != '\0' ? " (" : "", start,
                   start[0] != '\0' ? ")" : "");
}

static const char *start_hint(lode_criterion_t criterion) {
    switch (criterion) {
    case LODE_CRITERION_REST:
        return "the rotor has not followed: start.current_A and the load, start.ramp_rad_s2 and "
               "the inertia";
    case LODE_CRITERION_EMF:
        return "the rotor has not followed: start.current_A and the load, start.ramp_rad_s2 and "
               "the inertia; or psi_Wb is too large (peak for RMS, line-to-line for phase)";
    case LODE_CRITERION_SPEED:
    case LODE_CRITERION_FLUX:
    case LODE_CRITERION_LOCK:
    case LODE_CRITERION_HOLD:
        return "the EMF does not fit the motor: psi_Wb, L, dead time and drops, a swinging load";
    case LODE_CRITERION_OPEN_PHASE:
        return "motor leads and drivers; a rotor far lighter than J_kgm2";
    case LODE_CRITERION_POLARITY:
        return "injection has not found the rotor: saliency (Ld_H, Lq_H), hfi.V_h_V";
    case LODE_CRITERION_PROOF:
        return "lost right after the hand-over: J_kgm2, L and psi_Wb, or a load step";
    case LODE_CRITERION_NONE:
    case LODE_CRITERION_CURRENT:
    case LODE_CRITERION_RAMP:
    case LODE_CRITERION_COUNT:
    default:
        return "time: start.timeout_s and start.ramp_rad_s2";
    }
}

const char *fault_text_hint(const lode_fault_t *fault) {
    static const struct {
        lode_check_t check;
        const char *hint;
    } hints[] = {
        {LODE_CHECK_OVER_CURRENT,
         "L and R (phase values, of the star?), guard.i_trip_A and the ripple"},
        {LODE_CHECK_OVER_VOLTAGE,
         "braking raises the bus: references.v_regen_V, speed.ramp_down_rad_s2, a brake chopper"},
        {LODE_CHECK_UNDER_VOLTAGE, "the supply sags: references.v_motor_V"},
        {LODE_CHECK_OVER_SPEED, "guard.omega_max_rad_s; an overshoot: J_kgm2"},
        {LODE_CHECK_LOST_LOCK,
         "psi_Wb, L and J_kgm2; a load step beyond the largest one that `design` prints"},
        {LODE_CHECK_OVERLOAD,
         "more load than torque: i_max_A, and the largest load step that `design` prints"},
        {LODE_CHECK_WRONG_WAY, "the load turns the rotor against the command"},
        {LODE_CHECK_OPEN_PHASE, "motor leads and drivers; a rotor far lighter than J_kgm2"},
        {LODE_CHECK_FLUX, "psi_Wb; hot or demagnetised magnets"},
        {LODE_CHECK_RESISTANCE, "Rs_Ohm, of one phase of the star; r_on_Ohm"},
        {LODE_CHECK_INDUCTANCE, "Ld_H and Lq_H, of one phase of the star"},
    };
    if (fault->check == (uint_least8_t)LODE_CHECK_START) {
        return start_hint((lode_criterion_t)fault->criterion);
    }
    for (size_t k = 0; k < sizeof hints / sizeof hints[0]; ++k) {
        if ((uint_least8_t)hints[k].check == fault->check) {
            return hints[k].hint;
        }
    }
    return NULL;
}
