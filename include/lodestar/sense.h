/// From ADC counts to amperes, volts and degrees, with the calibration of the current offsets.
#ifndef LODESTAR_SENSE_H
#define LODESTAR_SENSE_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Where the currents are measured. LODE_WITHOUT_SHUNT_WINDOW leaves out of a build what computes a phase from
/// the other two: two shunts, and a duty_max below 1. Init then refuses them (LODE_ERROR_SENSE_WINDOW).
typedef enum {
    LODE_SHUNTS_THREE, ///< all three phases, by any sensor; also with single_shunt.h
    LODE_SHUNTS_TWO    ///< phases a and b; c follows from the isolated star point
} lode_shunts_t;

/// What a board's ADC delivers. Gains may be negative where an amplifier inverts.
typedef struct {
    lode_shunts_t shunts;
    float i_gain_A_count; ///< current into the motor, A per count; low-side shunts: negative
    float i_offset_count; ///< nominal count at zero current, 0 .. count_max
    /// largest plausible deviation of a calibrated offset; 0: 5 % of full scale
    float i_offset_tol_count;
    float count_max;                   ///< highest count of the ADC; 0: 4095
    float v_bus_gain_V_count;          ///< bus voltage per count, from count 0
    float temperature_gain_degC_count; ///< 0: no sensor
    float temperature_offset_degC;     ///< temperature at count 0
    float duty_max; ///< low-side shunts: above this duty a phase cannot be sampled in time and is
                    ///< computed from the other two; 1: always sampled. 0: 1
    float calibrate_s; ///< time over which offsets are averaged; 0: 0.1
    /// smallest rms noise of a healthy current sensor: with less than half of it the calibration fails; 0: not
    /// checked
    float i_noise_count;
} lode_sense_config_t;

/// The raw results of one period, all sampled at t_k, the start of PWM period k.
typedef struct {
    uint16_t i[3];        ///< phase currents a, b, c
    uint16_t v_bus;       ///< bus voltage
    uint16_t temperature; ///< power stage
    bool trip;            ///< the hardware has switched the gates off
    uint32_t stamp;       ///< free-running counter, any rate; watched by the guard if configured
} lode_counts_t;

/// Currents in counts are kept in 1/256 count: offsets are averages.
#define LODE_COUNT_FRACTION 256

typedef struct {
    float i_gain;           ///< A per 1/256 count
    float alpha_gain;       ///< i_gain/3: of 2a - b - c (Clarke)
    float beta_gain;        ///< i_gain/sqrt(3): of b - c
    int32_t offset_nominal; ///< 1/256 count
    int32_t offset_tol;
    uint32_t
        alert; ///< 1/256 count from the offset, up to which no sample sits at a rail; the drive
               ///< lowers it to the trip
    float v_bus_gain;
    float temperature_gain;
    float temperature_offset;
    float duty_max; ///< beyond it a phase is missing
    uint32_t calibrate_periods;
    uint32_t noise_least; ///< of lode_sense_sums_t.steps2
    uint_least16_t count_max;
    uint_least16_t two_shunts; ///< 0 or 1
} lode_sense_tuning_t;

typedef struct {
    int32_t offset[3]; ///< in use, 1/256 count
} lode_sense_t;

/// A calibration under way.
typedef struct {
    uint32_t count[3];
    uint32_t steps2[3]; ///< of the squares of the counts' steps, each at most 255
    uint16_t before[3];
    uint32_t samples; ///< how many are in the sums
} lode_sense_sums_t;

/// Inputs of a period, valid at t_k.
typedef struct {
    lode_ab_t i_A;         ///< stator current
    lode_ab_t u_V;         ///< mean stator voltage over [t_k-1, t_k)
    float v_bus_V;         ///< bus
    int32_t i[3];          ///< phase currents from their offsets, 1/256 count
    uint32_t stamp;        ///< as in lode_counts_t
    uint16_t temperature;  ///< count
    uint_least8_t omitted; ///< phase taken from the other two; LODE_PHASES: none
    bool trip;             ///< the hardware has switched the gates off
    bool alert;            ///< a phase current is beyond the alert
} lode_sample_t;

typedef enum {
    LODE_CALIBRATION_RUNNING,     ///< wants more samples
    LODE_CALIBRATION_DONE,        ///< the offsets are in use
    LODE_CALIBRATION_IMPLAUSIBLE, ///< an offset is beyond i_offset_tol_count
    LODE_CALIBRATION_STUCK        ///< a sensor lacks the noise that i_noise_count specifies
} lode_calibration_t;

/// Fills every zero field that has a default.
void lode_sense_design(lode_sense_config_t *config);

/// Checks `config` for currents up to `i_max_A` and a bus of `v_bus_V`, and derives the tuning; `ts_s`: period of the
/// step. On any error `tuning` is unchanged.
lode_status_t lode_sense_tune(lode_sense_tuning_t *tuning, const lode_sense_config_t *config,
                              float i_max_A, float v_bus_V, float ts_s);

/// Nominal offsets.
void lode_sense_reset(lode_sense_t *self, const lode_sense_tuning_t *tuning);

#define LODE_PHASES 3

/// Starts a calibration.
void lode_sense_begin(lode_sense_sums_t *sums);

/// Takes one more sample at zero current (gates off). At the end either all three offsets change or,
/// where one is implausible or has no noise, none; `worst_count` is the largest deviation from nominal, or the first
/// phase without noise, 1 .. 3.
lode_calibration_t lode_sense_calibrate(lode_sense_t *self, lode_sense_sums_t *sums,
                                        const lode_sense_tuning_t *tuning,
                                        const lode_sample_t *sample, float *worst_count);

#ifdef __cplusplus
}
#endif

#endif
