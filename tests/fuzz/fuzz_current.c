// Current control: any accepted gains, any inputs: inside the voltage circle, states in numbers.
#include "current_inline.h"
#include "references_inline.h"
#include "support/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    const lode_motor_t motor = fuzz_motor();
    lode_current_config_t config = {.bandwidth_rad_s = fuzz_number(&in, 2000.0f),
                                    .voltage_use = fuzz_number(&in, 1.0f)};
    lode_current_tuning_t tuning;
    lode_current_design(&config, &motor, 2.0e-4f);
    if (lode_current_tune(&tuning, &config, &motor, 2.0e-4f) != LODE_OK) {
        return 0;
    }
    const lode_references_tuning_t machine = {
        .Ld_H = motor.Ld_H, .Lq_H = motor.Lq_H, .psi_Wb = motor.psi_Wb};
    lode_current_t current = {.d = {0.0f}, .q = {0.0f}};
    lode_current_take(&current, &tuning, motor.Lq_H);
    while (fuzz_more(&in)) {
        const lode_dq_t ref = {fuzz_number(&in, 20.0f), fuzz_number(&in, 20.0f)};
        const lode_dq_t i = {fuzz_number(&in, 20.0f), fuzz_number(&in, 20.0f)};
        const float omega = fuzz_number(&in, 2000.0f);
        const float bus = 400.0f * (float)fuzz_byte(&in) / 255.0f;
        lode_current_saturate(&current, &tuning, motor.Lq_H, (float)fuzz_byte(&in) / 255.0f, i.q,
                              ref.q);
        const lode_dq_t induced_V = lode_references_induced_V(&machine, current.Lq_H, i, omega);
        const lode_dq_t u = lode_current_step(&current, &tuning, ref, i, induced_V, bus).u_V;
        const double radius = (double)(tuning.circle * bus);
        // Compared by its square, which is 0 below 1e-22 V.
        FUZZ_CHECK(hypot((double)u.d, (double)u.q) <= radius * 1.000001 + 1.0e-20);
        FUZZ_CHECK(lode_is_finite(current.d.integral) && lode_is_finite(current.q.integral));
    }
    return 0;
}
