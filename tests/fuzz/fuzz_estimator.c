// Estimator: any configuration that is accepted, any voltages and currents, any state.
#include "hfi_inline.h"
#include "lodestar/estimator.h"
#include "pll_inline.h"
#include "support/fuzz.h"

// Until it is normalised, once in a round, a small correction stretches the rotation by half its square, while it injects any
// that the wave makes, and a large one by what lode_angle_shorten() leaves; the line through the lag adds its own.
static float longest_rotor(const lode_estimator_tuning_t *tuning, bool injects) {
    const double theta = (double)lode_pll_gains(&tuning->pll, tuning->omega_limit).theta;
    const double by_wave = injects ? (double)LODE_HFI_ERROR_MAX_rad * theta : 0.0;
    const double small = fmax(0.05, by_wave); // CORRECTION_SMALL_rad
    const double lag = 0.125;                 // LAG_MOVE_MAX_rad
    const double largest = 1.1 * theta;       // SINE_MAX
    const double square = largest * largest;
    const double left = sqrt(1.0 + square) * (1.0 - 0.5 * square * (1.0 - 0.75 * square));
    const double period = fmax(1.0 + 0.5 * small * small, left);
    return (float)(pow(period, LODE_SLOW_PERIODS) * (1.0 + 0.5 * lag * lag));
}

static void check(const lode_estimate_t *e, const lode_estimator_tuning_t *tuning, bool injects) {
    FUZZ_CHECK(lode_in_range(lode_estimate_theta_rad(e), -LODE_PI, LODE_PI));
    FUZZ_CHECK(lode_in_range(e->omega_rad_s, -tuning->omega_limit, tuning->omega_limit));
    FUZZ_CHECK(hypotf(e->rotor.sin, e->rotor.cos) <= longest_rotor(tuning, injects));
    FUZZ_CHECK(lode_is_finite(e->i_A.d) && lode_is_finite(e->i_A.q));
    FUZZ_CHECK(lode_is_finite(e->e_V.alpha) && lode_is_finite(e->e_V.beta));
    FUZZ_CHECK(lode_is_finite(e->load_torque_Nm));
    FUZZ_CHECK(lode_in_range(e->lock, 0.0f, 1.0f));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    const lode_motor_t motor = fuzz_motor();
    const uint8_t choice = fuzz_byte(&in);
    lode_estimator_config_t config = {
        .pll = {.kind = (choice & 1u) != 0u ? LODE_PLL_QPLL : LODE_PLL_LESO},
        .compensation = (choice & 2u) != 0u ? LODE_LAG_NONE : LODE_LAG_EXACT,
    };
    if ((choice & 4u) != 0u) {
        config.emf.w0_rad_s = fuzz_number(&in, 4000.0f);
        config.pll.sigma_rad_s = fuzz_number(&in, 400.0f);
        config.omega_max_rad_s = fuzz_number(&in, 2000.0f);
    }
    lode_estimator_tuning_t tuning;
    lode_estimator_design(&config, &motor, 2.0e-4f);
    if (lode_estimator_tune(&tuning, &config, &motor, 2.0e-4f) != LODE_OK) {
        return 0;
    }
    lode_estimator_t estimator;
    lode_estimator_reset(&estimator, &tuning);
    uint32_t settle = 0u;
    uint32_t injected = 0u; // periods for which its corrections count
    if ((choice & 8u) != 0u) {
        fuzz_take(&in, &estimator, sizeof estimator);
        const uint8_t bools = fuzz_byte(&in); // no other bits make one
        estimator.locked = (bools & 1u) != 0u;
        estimator.aligned = (bools & 2u) != 0u;
        estimator.by.hfi.active = (bools & 4u) != 0u;
        // Until all that is derived has been renewed: gains, a round later where an angle is acquired in their
        // slot, and in the next round the length of the rotation that wrong ones have stretched.
        settle = 3u * LODE_SLOW_PERIODS;
    }
    while (fuzz_more(&in)) {
        const lode_ab_t u = {fuzz_number(&in, 300.0f), fuzz_number(&in, 300.0f)};
        const lode_ab_t i = {fuzz_number(&in, 50.0f), fuzz_number(&in, 50.0f)};
        injected =
            estimator.by.hfi.active ? LODE_SLOW_PERIODS : injected - (injected > 0u ? 1u : 0u);
        const lode_estimate_t e = lode_estimator_step(&estimator, &tuning, u, i);
        if (settle > 0u) {
            settle--;
        } else {
            check(&e, &tuning, injected > 0u);
        }
    }
    return 0;
}
