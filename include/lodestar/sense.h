/// From converter counts to amperes, volts and degrees, with the calibration of the current offsets.
#ifndef LODESTAR_SENSE_H
#define LODESTAR_SENSE_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Where the currents are measured.
typedef enum {
    LODE_SHUNTS_THREE, ///< all three phases
    LODE_SHUNTS_TWO    ///< phases a and b; c follows from the isolated star point
} lode_shunts_t;

/// What a board's converters deliver. Gains may be negative where an amplifier inverts.
typedef struct {
    lode_shunts_t shunts;
    float i_gain_A_count; ///< current out of the inverter per count
    float i_offset_count; ///< nominal count at zero current
    /// largest plausible deviation of a calibrated offset; 0: 5 % of full scale
    float i_offset_tol_count;
    float count_max;                   ///< highest count of the converters; 0: 4095
    float v_bus_gain_V_count;          ///< bus voltage per count, from count 0
    float temperature_gain_degC_count; ///< 0: no sensor
    float temperature_offset_degC;     ///< temperature at count 0
    float duty_max; ///< low-side shunts: above this duty a phase has no time to be sampled and is
                    ///< taken from the other two; 1: sampled always. 0: 1
    float calibrate_s; ///< time over which offsets are averaged; 0: 0.1
} lode_sense_config_t;

/// The raw results of one period, all sampled at t_k, the start of PWM period k.
typedef struct {
    uint16_t i[3];        ///< phase currents a, b, c
    uint16_t v_bus;       ///< bus voltage
    uint16_t temperature; ///< power stage
    bool trip;            ///< the hardware has switched the gates off
    uint32_t stamp;       ///< free-running counter, any rate; watched by the guard if configured
} lode_counts_t;

typedef struct {
    float i_gain;
    float alpha_gain; ///< i_gain/3: of 2a - b - c (Clarke)
    float beta_gain;  ///< i_gain/sqrt(3): of b - c
    float i_offset_nominal;
    float i_offset_tol;
    float alert_count; ///< from the offset, up to which no sample sits at a rail; the drive lowers
                       ///< it to the trip
    float v_bus_gain;
    float temperature_gain;
    float temperature_offset;
    float duty_max;
    uint32_t calibrate_periods;
    uint16_t count_max;
    lode_shunts_t shunts;
    bool windowed; ///< not every phase is sampled in every period
} lode_sense_tuning_t;

typedef struct {
    lode_abc_t offset_count; ///< offsets in use
} lode_sense_t;

/// A calibration under way.
typedef struct {
    uint32_t count[3];
    uint32_t samples; ///< how many are in the sums
} lode_sense_sums_t;

/// Quantities valid at t_k.
typedef struct {
    lode_abc_t i_abc_A;
    lode_ab_t i_A;
    float v_bus_V;
    uint16_t temperature_count;
    uint32_t stamp;
    bool trip;   ///< the hardware has switched the gates off
    bool alert;  ///< a current is beyond alert_count
    bool railed; ///< a current sample in use sits at the end of the converter's range
} lode_sample_t;

typedef enum {
    LODE_CALIBRATION_RUNNING,
    LODE_CALIBRATION_DONE,
    LODE_CALIBRATION_IMPLAUSIBLE
} lode_calibration_t;

/// Fills every zero field that has a default.
void lode_sense_design(lode_sense_config_t *config);

/// Checks `config` for currents up to `i_max_A` and a bus of `v_bus_V`, and derives the tuning.
lode_status_t lode_sense_tune(lode_sense_tuning_t *tuning, const lode_sense_config_t *config,
                              float i_max_A, float v_bus_V, float ts_s);

/// Nominal offsets.
void lode_sense_reset(lode_sense_t *self, const lode_sense_tuning_t *tuning);

/// Which phase cannot be sampled while the duties are `duty`; LODE_PHASES: all can.
#define LODE_PHASES 3
int32_t lode_sense_unused(const lode_sense_tuning_t *tuning, lode_abc_t duty);

/// Parts of lode_sense_step(), which alone calls them: the currents with one phase taken from the other
/// two, and whether one in use sits at a rail.
lode_abc_t lode_sense_completed(lode_abc_t i, int32_t unused);

bool lode_sense_railed(const lode_sense_tuning_t *tuning, const lode_counts_t *counts,
                       int32_t unused);

/// The currents in counts from their offsets; `unused`: lode_sense_unused() of the duties that acted when
/// the sample was taken.
LODE_INLINE lode_abc_t lode_sense_currents(const lode_sense_t *self, const lode_counts_t *counts,
                                           int32_t unused) {
    const lode_abc_t i = {(float)counts->i[0] - self->offset_count.a,
                          (float)counts->i[1] - self->offset_count.b,
                          (float)counts->i[2] - self->offset_count.c};
    if (LODE_RARELY(unused != LODE_PHASES)) {
        return lode_sense_completed(i, unused);
    }
    return i;
}

/// All of a sample with the currents `i`, in counts from their offsets, but `railed`, which is false: it
/// needs a look only where there is an alert.
LODE_INLINE lode_sample_t lode_sense_sample(const lode_sense_tuning_t *tuning,
                                            const lode_counts_t *counts, lode_abc_t i) {
    const float most = lode_max(lode_max(lode_abs(i.a), lode_abs(i.b)), lode_abs(i.c));
    return (lode_sample_t){
        .i_abc_A = {tuning->i_gain * i.a, tuning->i_gain * i.b, tuning->i_gain * i.c},
        .i_A = {(2.0f * i.a - i.b - i.c) * tuning->alpha_gain, (i.b - i.c) * tuning->beta_gain},
        .v_bus_V = (float)counts->v_bus * tuning->v_bus_gain,
        .temperature_count = counts->temperature,
        .stamp = counts->stamp,
        .trip = counts->trip,
        .alert = !(most <= tuning->alert_count),
        .railed = false,
    };
}

/// The same from a period's counts.
LODE_INLINE lode_sample_t lode_sense_glance(const lode_sense_t *self,
                                            const lode_sense_tuning_t *tuning,
                                            const lode_counts_t *counts, int32_t unused) {
    return lode_sense_sample(tuning, counts, lode_sense_currents(self, counts, unused));
}

/// The whole sample.
static inline lode_sample_t lode_sense_step(const lode_sense_t *self,
                                            const lode_sense_tuning_t *tuning,
                                            const lode_counts_t *counts, int32_t unused) {
    lode_sample_t sample = lode_sense_glance(self, tuning, counts, unused);
    sample.railed = sample.alert && lode_sense_railed(tuning, counts, unused);
    return sample;
}

LODE_INLINE float lode_sense_temperature_degC(const lode_sense_tuning_t *tuning, uint16_t count) {
    return tuning->temperature_offset + (float)count * tuning->temperature_gain;
}

/// Starts a calibration.
void lode_sense_begin(lode_sense_sums_t *sums);

/// Takes one more sample at zero current (gates off). At the end either all three offsets change or,
/// where one is implausible, none; `worst_count` is the largest deviation from nominal.
lode_calibration_t lode_sense_calibrate(lode_sense_t *self, lode_sense_sums_t *sums,
                                        const lode_sense_tuning_t *tuning,
                                        const lode_counts_t *counts, float *worst_count);

#ifdef __cplusplus
}
#endif

#endif
