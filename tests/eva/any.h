// Whatever may come from outside: commands and ADC counts, for abstract interpretation.
#ifndef EVA_ANY_H
#define EVA_ANY_H

#include "lodestar/drive.h"

#include "__fc_builtin.h"

static bool any_bool(void) {
    return Frama_C_interval(0, 1) != 0;
}

static float any_float(void) {
    return Frama_C_float_interval(-FLT_MAX, FLT_MAX); // post_command refuses the others
}

static uint16_t any_count(void) {
    return (uint16_t)Frama_C_unsigned_int_interval(0, UINT16_MAX);
}

static lode_command_t any_command(void) {
    return (lode_command_t){.mode = (lode_mode_t)Frama_C_interval(0, 7),
                            .speed_rad_s = any_float(),
                            .vector = {any_float(), any_float()},
                            .theta_rad = any_float(),
                            .omega_rad_s = any_float(),
                            .clear_fault = any_bool(),
                            .control = any_bool() ? LODE_CONTROL_TORQUE : LODE_CONTROL_SPEED,
                            .torque_Nm = any_float(),
                            .active_short = any_bool()};
}

static lode_counts_t any_counts(void) {
    return (lode_counts_t){.i = {any_count(), any_count(), any_count()},
                           .v_bus = any_count(),
                           .temperature = any_count(),
                           .trip = any_bool(),
                           .stamp = Frama_C_unsigned_int_interval(0, UINT32_MAX)};
}

#endif
