/// Commands and counts for the drives out of the input's bytes, and what must hold of their answers.
#ifndef SUPPORT_FUZZ_DRIVE_H
#define SUPPORT_FUZZ_DRIVE_H

#include "support/fuzz.h"

#include "lodestar/drive.h"

/// A drive of paper 1's motor; bits of `choice` take options.
static inline lode_drive_config_t fuzz_drive_config(uint16_t choice) {
    return (lode_drive_config_t){
        .f_pwm_Hz = 5000.0f,
        .motor = fuzz_motor(),
        .inverter = {.v_bus_V = 200.0f,
                     .i_max_A = 12.0f,
                     .dead_time_s = (choice & 1u) != 0u ? 4.0e-6f : 0.0f,
                     .pwm_ticks = (choice & 2u) != 0u ? 8400.0f : 0.0f},
        .sense = {.shunts = (choice & 4u) != 0u ? LODE_SHUNTS_TWO : LODE_SHUNTS_THREE,
                  .i_gain_A_count = 0.0125f,
                  .i_offset_count = 2048.0f,
                  .v_bus_gain_V_count = 0.1f,
                  .duty_max = (choice & 8u) != 0u ? 0.9f : 0.0f,
                  .calibrate_s = 4.0e-4f},
        // Field weakening refuses the QPLL.
        .estimator = {.pll = {.kind =
                                  (choice & (16u | 512u)) == 16u ? LODE_PLL_QPLL : LODE_PLL_LESO}},
        .references = {.kind = (choice & 256u) != 0u ? LODE_REFERENCES_MTPA : LODE_REFERENCES_ID0,
                       .field_weakening = (choice & 512u) != 0u ? LODE_ON : LODE_OFF,
                       .Lq_fall = (choice & 1024u) != 0u ? 0.02f : 0.0f,
                       .v_regen_V = (choice & 2048u) != 0u ? 210.0f : 0.0f},
        .guard = {.i_trip_A = 25.0f}};
}

static inline lode_command_t fuzz_command(fuzz_t *in) {
    return (lode_command_t){.mode = (lode_mode_t)(fuzz_byte(in) % 8u),
                            .speed_rad_s = fuzz_number(in, 300.0f),
                            .vector = {fuzz_number(in, 100.0f), fuzz_number(in, 100.0f)},
                            .theta_rad = fuzz_number(in, 4.0f),
                            .omega_rad_s = fuzz_number(in, 2000.0f),
                            .clear_fault = (fuzz_byte(in) & 1u) != 0u};
}

static inline lode_counts_t fuzz_counts(fuzz_t *in) {
    const uint8_t kind = fuzz_byte(in);
    lode_counts_t c = {.v_bus = 2000, .trip = kind == 255u};
    for (int n = 0; n < 3; n++) {
        c.i[n] = kind < 128u ? (uint16_t)(2048u - 128u + fuzz_byte(in)) : fuzz_word(in);
    }
    if (kind < 16u) {
        c.v_bus = fuzz_word(in);
        c.temperature = fuzz_word(in);
    }
    return c;
}

static inline void fuzz_check_out(lode_drive_out_t out, const lode_telemetry_t *t) {
    FUZZ_CHECK(lode_in_range(out.duty.a, 0.0f, 1.0f));
    FUZZ_CHECK(lode_in_range(out.duty.b, 0.0f, 1.0f));
    FUZZ_CHECK(lode_in_range(out.duty.c, 0.0f, 1.0f));
    FUZZ_CHECK(!(out.gates && t->fault.check != (uint_least8_t)LODE_CHECK_NONE));
}

static inline void fuzz_check_telemetry(const lode_telemetry_t *t) {
    FUZZ_CHECK(lode_is_finite(t->i_A.d) && lode_is_finite(t->i_A.q));
    FUZZ_CHECK(lode_is_finite(t->ref_A.d) && lode_is_finite(t->ref_A.q));
    FUZZ_CHECK(lode_is_finite(t->u_V.d) && lode_is_finite(t->u_V.q));
    FUZZ_CHECK(lode_is_finite(t->theta_rad) && lode_is_finite(t->omega_rad_s));
    FUZZ_CHECK(lode_is_finite(t->speed_ref_rad_s) && lode_is_finite(t->load_torque_Nm));
    FUZZ_CHECK(lode_in_range(t->lock, 0.0f, 1.0f));
}

#endif
