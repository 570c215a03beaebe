/// Three phase currents from one shunt in the DC link: shifts the PWM edges so that two phases can be sampled in
/// every period, and converts the two samples into the counts that a drive with three shunts expects.
///
/// It runs outside of the drive's step, whose cost does not change. In the interrupt:
///
///     lode_single_shunt_read(&shunt, &tuning, link, drive.sense.offset[0], drive.inverter.v_bus_V, counts.i);
///     out = lode_drive_step(&drive, &counts);
///     plan = lode_single_shunt_write(&shunt, &tuning, out.duty, out.gates);
///     plan.rise and plan.fall into the compare registers of the two halves of the next period,
///     plan.sample into the ADC's triggers
///
/// The two samples lie in the second half of the period, as close to t_k as its edges allow. While two legs are
/// high, the link carries minus the current of the third phase; while one leg is high, the current of its phase.
/// Required: LODE_SHUNTS_THREE, duty_max 1, current.voltage_use at or below lode_single_shunt_voltage_use(), and
/// start.pulses off, because a current through the low sides alone cannot be seen. With start.signal_check on,
/// bridge and sensor are checked before a start.
#ifndef LODESTAR_SINGLE_SHUNT_H
#define LODESTAR_SINGLE_SHUNT_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Configuration.
typedef struct {
    float f_pwm_Hz;       ///< as in the drive
    float i_gain_A_count; ///< as in the drive: current from the link into the bridge, A per count
    float window_s;       ///< from an edge to the end of a sample: dead time, settling and sampling
    float sample_s;       ///< from a trigger to the end of sampling; part of window_s
    float L_H;            ///< mean of Ld and Lq: to correct both samples to t_k; 0: no correction
} lode_single_shunt_config_t;

/// All that is derived from the configuration.
typedef struct {
    float window;       ///< least distance between the edges of two duties, as a duty
    float sample;       ///< sample_s as a share of the period
    float rise_count_V; ///< change of a phase current by one volt over a period, counts
} lode_single_shunt_tuning_t;

/// PWM and samples of one period. A leg is high from (1 - rise)/2 to (1 + fall)/2 of the period.
typedef struct {
    lode_abc_t rise; ///< [0, 1]; the mean of `rise` and `fall` is the duty
    lode_abc_t fall;
    float sample[2]; ///< triggers, as shares of the period: with two legs high, with one leg high
    float correction_V[2]; ///< correction from the samples to t_k: volts per bus volt over a period
    uint_least8_t least;   ///< phase whose reversed current the first sample shows
    uint_least8_t most;    ///< phase whose current the second sample shows
    bool driven;           ///< false: the link carries no current
    bool blind;            ///< the edges cannot be shifted far enough; both samples are unusable
} lode_single_shunt_plan_t;

/// State.
typedef struct {
    lode_single_shunt_plan_t plan[2]; ///< of the period that ends, and of the one that begins
    uint16_t count[3];                ///< counts returned last
} lode_single_shunt_t;

/// Checks `config` and derives the tuning. Errors: SENSE_WINDOW: window_s outside 0 .. a quarter of the period, or
/// sample_s outside 0 .. window_s; SENSE_CURRENT: gain 0 or out of range, or L_H outside 0 .. 10.
lode_status_t lode_single_shunt_tune(lode_single_shunt_tuning_t *tuning,
                                     const lode_single_shunt_config_t *config);

/// Largest current.voltage_use with which both phases can always be sampled; at most the drive's default of 0.95.
float lode_single_shunt_voltage_use(const lode_single_shunt_tuning_t *tuning);

/// Clears the state: gates off, no current.
void lode_single_shunt_reset(lode_single_shunt_t *self);

/// Converts the samples `link` of the period that ends at t_k into the counts at t_k. `offset`: calibrated offset
/// of the link's ADC channel, 1/256 count. `v_bus_V`: at t_k-1. After a blind period the last counts are returned.
/// For the interrupt, before the step.
void lode_single_shunt_read(lode_single_shunt_t *self, const lode_single_shunt_tuning_t *tuning,
                            const uint16_t link[2], int32_t offset, float v_bus_V,
                            uint16_t count[3]);

/// Edges and triggers of the next period for the drive's `duty` and `gates`. For the interrupt, after the step.
lode_single_shunt_plan_t lode_single_shunt_write(lode_single_shunt_t *self,
                                                 const lode_single_shunt_tuning_t *tuning,
                                                 lode_abc_t duty, lode_gates_t gates);

#ifdef __cplusplus
}
#endif

#endif
