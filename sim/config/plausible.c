#include "config/plausible.h"

#include <math.h>

// A wrong unit prefix is a factor of 1000, of an inertia in kg cm2 for g cm2 too. The limits are a fifth and five times the
// catalogue's range. With less than a third of the voltage few motors reach rated speed; the verdict reports a voltage that
// is only slightly too low.
static const plausible_t catalogue = {
    .ratio = {
        {.key = "time_constant",
         .name = "time constant Lq/Rs",
         .unit = "ms",
         .usual_low = 0.3,
         .usual_high = 130.0,
         .least = 0.06,
         .most = 650.0,
         .made_of = "Rs in Ohm, Lq in H, of one phase"},
        {.key = "short_circuit_current",
         .name = "short-circuit current psi/Ld",
         .unit = "i_max",
         .usual_low = 1.0,
         .usual_high = 10.0,
         .least = 0.2,
         .most = 50.0,
         .made_of = "psi in Wb, Ld in H, i_max in A"},
        {.key = "resistive_drop",
         .name = "i_max across Rs",
         .unit = "% of v_bus/sqrt(3)",
         .usual_low = 1.0,
         .usual_high = 72.0,
         .least = 0.2,
         .most = 100.0,
         .made_of = "Rs and r_on in Ohm, i_max in A, v_bus in V"},
        {.key = "run_up",
         .name = "run-up to rated speed with i_max",
         .unit = "ms",
         .usual_low = 6.0,
         .usual_high = 360.0,
         .least = 1.2,
         .most = 1.8e3,
         .made_of = "J in kg m2, psi in Wb, i_max in A, rated speed in mechanical rpm"},
        {.key = "no_load_speed",
         .name = "no-load speed",
         .unit = "times rated speed",
         .usual_low = 1.0,
         .usual_high = 2.4,
         .least = 0.0,
         .most = 3.0,
         .made_of = "psi or KV, rated speed in mechanical rpm, v_bus in V"},
    }};

plausible_t plausible_of(const lode_drive_config_t *drive) {
    const lode_motor_t *motor = &drive->motor;
    const double i_max_A = (double)drive->inverter.i_max_A;
    const double circle_V = (double)drive->inverter.v_bus_V / sqrt(3.0);
    const double Rs_Ohm = motor->Rs_Ohm > 0.0f ? (double)motor->Rs_Ohm : (double)NAN;
    const double values[PLAUSIBLE_RATIOS] = {
        1.0e3 * (double)motor->Lq_H / Rs_Ohm,
        (double)motor->psi_Wb / ((double)motor->Ld_H * i_max_A),
        100.0 * (Rs_Ohm + (double)drive->inverter.r_on_Ohm) * i_max_A / circle_V,
        1.0e3 * (double)lode_motor_run_up_s(motor, drive->inverter.i_max_A),
        (double)drive->current.voltage_use * circle_V /
            ((double)motor->psi_Wb * (double)motor->omega_rated_rad_s),
    };
    plausible_t self = catalogue;
    for (int k = 0; k < PLAUSIBLE_RATIOS; ++k) {
        self.ratio[k].value = values[k];
    }
    return self;
}

bool plausible_is_doubtful(const plausible_ratio_t *ratio) {
    return isfinite(ratio->value) && ratio->value > 0.0 &&
           (ratio->value < ratio->least || ratio->value > ratio->most);
}

int plausible_print_doubts(FILE *file, const plausible_t *self) {
    int doubts = 0;
    for (int k = 0; k < PLAUSIBLE_RATIOS; ++k) {
        const plausible_ratio_t *ratio = &self->ratio[k];
        if (plausible_is_doubtful(ratio)) {
            doubts++;
            (void)fprintf(file, "check: %s: %.4g %s; catalogue: %g .. %g. Are these right: %s?\n",
                          ratio->name, ratio->value, ratio->unit, ratio->usual_low,
                          ratio->usual_high, ratio->made_of);
        }
    }
    return doubts;
}
