/// Motor, load, ideal inverter and 12-bit ADCs in single precision, small enough for an image. Uses only sums,
/// products and quotients, so that its results are bit-identical everywhere.
#ifndef EMULATOR_PLANT_H
#define EMULATOR_PLANT_H

#include "lodestar/lodestar.h"

#define PLANT_F_PWM_Hz 5000.0f
/// Counts of lode_counts_t.stamp per period.
#define PLANT_STAMP_PER_PERIOD 1000u

typedef struct {
    float id_A;
    float iq_A;
    float omega_rad_s;   ///< electrical
    lode_sincos_t rotor; ///< true angle at the start of the period
    lode_abc_t applied;  ///< duties of the previous call, which act in the present period
    float load_Nm;       ///< against the rotation
} plant_t;

/// At rest, unloaded, the magnet 17 degrees from phase a.
void plant_init(plant_t *self);

/// The values of inverter and ADCs for the drive.
void plant_describe(lode_drive_config_t *config);

/// The samples of the ADCs at the start of the period. Leaves `stamp` 0.
lode_counts_t plant_counts(const plant_t *self);

/// One period. `out` is the result of the step for the counts of its start: its gate state acts at once, its
/// duties in the next period.
void plant_period(plant_t *self, const lode_drive_out_t *out);

#endif
