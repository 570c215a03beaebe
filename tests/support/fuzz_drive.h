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
        .hfi = {.mode = (choice & 4096u) != 0u ? LODE_HFI_AUTO : LODE_HFI_DEFAULT,
                .silent = (choice & 8192u) != 0u ? LODE_ON : LODE_OFF},
        .guard = {.i_trip_A = 25.0f}};
}

/// Any command: known or not, of numbers or not.
static inline lode_command_t fuzz_command(fuzz_t *in) {
    lode_command_t x = {.mode = (lode_mode_t)(fuzz_byte(in) % 8u),
                        .speed_rad_s = fuzz_number(in, 300.0f),
                        .vector = {fuzz_number(in, 100.0f), fuzz_number(in, 100.0f)},
                        .theta_rad = fuzz_number(in, 4.0f),
                        .omega_rad_s = fuzz_number(in, 2000.0f)};
    const uint8_t flags = fuzz_byte(in);
    x.clear_fault = (flags & 1u) != 0u;
    x.active_short = (flags & 2u) != 0u;
    x.control = (lode_control_t)(flags / 4u % 4u);
    if (x.control != LODE_CONTROL_SPEED) {
        x.torque_Nm = fuzz_number(in, 20.0f);
    }
    return x;
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

/// What may switch after a period that tells `t`: only a drive without a fault drives, and the low sides alone are on before
/// it does or in an active short.
static inline void fuzz_check_gates(lode_drive_out_t out, const lode_telemetry_t *t) {
    const bool failed = t->mode == LODE_MODE_FAULT;
    const bool tripped = t->fault.check != (uint_least8_t)LODE_CHECK_NONE;
    FUZZ_CHECK(out.gates == LODE_GATES_OFF || out.gates == LODE_GATES_ON ||
               out.gates == LODE_GATES_LOW);
    FUZZ_CHECK(failed == tripped);
    FUZZ_CHECK(!(out.gates == LODE_GATES_ON && failed));
    FUZZ_CHECK(!(out.gates == LODE_GATES_LOW && !t->shorted && t->mode != LODE_MODE_PRECHARGE));
    FUZZ_CHECK(!(out.gates != LODE_GATES_OFF && t->mode == LODE_MODE_OFF));
    if (t->shorted) {
        FUZZ_CHECK(failed && out.gates == LODE_GATES_LOW);
        FUZZ_CHECK(!(out.duty.a > 0.0f || out.duty.b > 0.0f || out.duty.c > 0.0f));
        // With a shorted high side the low sides would short the bus.
        FUZZ_CHECK(!(t->fault.check == (uint_least8_t)LODE_CHECK_SWITCH_SHORTED &&
                     !(t->fault.measured < 0.0f)));
    }
}

static inline void fuzz_check_out(lode_drive_out_t out, const lode_telemetry_t *t) {
    FUZZ_CHECK(lode_in_range(out.duty.a, 0.0f, 1.0f));
    FUZZ_CHECK(lode_in_range(out.duty.b, 0.0f, 1.0f));
    FUZZ_CHECK(lode_in_range(out.duty.c, 0.0f, 1.0f));
    fuzz_check_gates(out, t);
}

static inline void fuzz_check_telemetry(const lode_telemetry_t *t) {
    FUZZ_CHECK(lode_is_finite(t->i_A.d) && lode_is_finite(t->i_A.q));
    FUZZ_CHECK(lode_is_finite(t->ref_A.d) && lode_is_finite(t->ref_A.q));
    FUZZ_CHECK(lode_is_finite(t->u_V.d) && lode_is_finite(t->u_V.q));
    FUZZ_CHECK(lode_is_finite(t->v_bus_V) && lode_is_finite(t->temperature_degC));
    FUZZ_CHECK(lode_in_range(t->theta_rad, -LODE_PI, LODE_PI) && lode_is_finite(t->omega_rad_s));
    FUZZ_CHECK(lode_is_finite(t->speed_ref_rad_s) && lode_is_finite(t->load_torque_Nm));
    FUZZ_CHECK(lode_is_finite(t->torque_ref_Nm) && lode_is_finite(t->torque_most_Nm));
    FUZZ_CHECK(lode_is_finite(t->e_V.alpha) && lode_is_finite(t->e_V.beta));
    FUZZ_CHECK(lode_in_range(t->lock, 0.0f, 1.0f) && lode_in_range(t->injected, 0.0f, 1.0f));
    FUZZ_CHECK(lode_is_finite(t->injection_error_rad) && lode_is_finite(t->emf_error_rad));
}

#endif
