/// Conversion of ADC counts to amperes, volts and degrees, and calibration of the current offsets.
#ifndef LODESTAR_SENSE_H
#define LODESTAR_SENSE_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Which phase currents are measured. LODE_WITHOUT_SHUNT_WINDOW leaves out of a build what computes a phase from
/// the other two (two shunts, or duty_max below 1). A configuration that needs it is then refused
/// (LODE_ERROR_SENSE_WINDOW).
typedef enum {
    LODE_SHUNTS_THREE, ///< all three phases, by any sensor or by single_shunt.h
    LODE_SHUNTS_TWO    ///< phases a and b; c follows from the isolated star point
} lode_shunts_t;

/// Properties of the board's measurements. A gain may be negative (inverting amplifier).
typedef struct {
    lode_shunts_t shunts;
    float i_gain_A_count; ///< current into the motor, A per count; low-side shunts: negative
    float i_offset_count; ///< nominal ADC count at zero current, 0 .. count_max
    /// largest plausible deviation of a calibrated offset from nominal; 0: 5 % of full scale
    float i_offset_tol_count;
    float count_max;                   ///< highest ADC count; 0: 4095
    float v_bus_gain_V_count;          ///< bus voltage per count; count 0 is 0 V
    float temperature_gain_degC_count; ///< 0: no sensor
    float temperature_offset_degC;     ///< temperature at count 0
    /// low-side shunts: above this duty, 0.5 .. 1, there is no time to sample a phase, and it is computed from the
    /// other two; 1: always sampled; 0: 1
    float duty_max;
    float calibrate_s; ///< averaging time of the offset calibration; 0: 0.1
    /// smallest rms noise of a healthy current sensor: calibration fails if a sensor has less than half of it; 0:
    /// not checked
    float i_noise_count;
} lode_sense_config_t;

/// ADC results of one control period, all sampled at t_k, the start of PWM period k.
typedef struct {
    uint16_t i[3];        ///< phase currents a, b, c
    uint16_t v_bus;       ///< bus voltage
    uint16_t temperature; ///< power stage
    bool trip;            ///< true: the hardware has switched the gates off; not looked at in OFF
    uint32_t stamp; ///< free-running counter of any rate; monitored by the guard if configured
} lode_counts_t;

/// Resolution of phase currents in counts: 1/256 count, because offsets are averages.
#define LODE_COUNT_FRACTION 256

/// All that is derived from the configuration.
typedef struct {
    float i_gain;           ///< A per 1/256 count
    float alpha_gain;       ///< i_gain/3: for 2a - b - c (Clarke)
    float beta_gain;        ///< i_gain/sqrt(3): for b - c
    int32_t offset_nominal; ///< nominal offset, 1/256 count
    int32_t offset_tol;     ///< 1/256 count
    /// distance from the offset, 1/256 count, up to which no sample is at a rail; the drive lowers it to the trip
    /// current
    uint32_t alert;
    float v_bus_gain;
    float temperature_gain;
    float temperature_offset;
    float duty_max;             ///< above it a phase is not sampled
    uint32_t calibrate_periods; ///< samples of a calibration
    uint32_t noise_least; ///< least value of lode_sense_sums_t.steps2 at the end of a calibration
    uint_least16_t count_max;
    uint_least16_t two_shunts; ///< 0 or 1
} lode_sense_tuning_t;

typedef struct {
    int32_t offset[3]; ///< in use, 1/256 count
} lode_sense_t;

/// State of a calibration.
typedef struct {
    uint32_t count[3];  ///< sums of the counts
    uint32_t steps2[3]; ///< sums of squared differences of successive counts, taken as at most 255
    uint16_t before[3]; ///< counts of the last sample
    uint32_t samples;   ///< number of samples in the sums
} lode_sense_sums_t;

/// Everything that a control period starts from, valid at t_k.
typedef struct {
    lode_ab_t i_A;         ///< stator current
    lode_ab_t u_V;         ///< mean stator voltage over [t_k-1, t_k)
    float v_bus_V;         ///< bus voltage
    int32_t i[3];          ///< phase currents relative to their offsets, 1/256 count
    uint32_t stamp;        ///< as in lode_counts_t
    uint16_t temperature;  ///< ADC count
    uint_least8_t omitted; ///< phase computed from the other two; LODE_PHASES: none
    bool trip;             ///< true: the hardware has switched the gates off
    bool alert;            ///< a phase current is beyond lode_sense_tuning_t.alert
} lode_sample_t;

/// Result of a call of lode_sense_calibrate().
typedef enum {
    LODE_CALIBRATION_RUNNING,     ///< more samples are needed
    LODE_CALIBRATION_DONE,        ///< the new offsets are in use
    LODE_CALIBRATION_IMPLAUSIBLE, ///< an offset deviates by more than i_offset_tol_count
    LODE_CALIBRATION_STUCK        ///< a sensor has less than half of i_noise_count
} lode_calibration_t;

/// Fills every zero field that has a default.
void lode_sense_design(lode_sense_config_t *config);

/// Checks `config` for currents up to `i_max_A` and a bus voltage of `v_bus_V`, and derives the tuning. `ts_s`:
/// control period. On any error `tuning` is left alone.
lode_status_t lode_sense_tune(lode_sense_tuning_t *tuning, const lode_sense_config_t *config,
                              float i_max_A, float v_bus_V, float ts_s);

/// Sets the nominal offsets.
void lode_sense_reset(lode_sense_t *self, const lode_sense_tuning_t *tuning);

#define LODE_PHASES 3

/// Starts a calibration.
void lode_sense_begin(lode_sense_sums_t *sums);

/// Takes one sample at zero current (gates off). After the last one all three offsets are replaced, or none if an
/// offset is implausible or a sensor has no noise. `worst_count` is then the largest deviation from nominal,
/// counts, or with LODE_CALIBRATION_STUCK the first phase without noise, 1 .. 3.
lode_calibration_t lode_sense_calibrate(lode_sense_t *self, lode_sense_sums_t *sums,
                                        const lode_sense_tuning_t *tuning,
                                        const lode_sample_t *sample, float *worst_count);

#ifdef __cplusplus
}
#endif

#endif
