/// Three phase currents from one shunt in the DC link: edges are shifted so that two phases can be sampled in every
/// period, and the two samples are converted into the counts that a drive with three shunts expects.
///
/// Nothing of it runs inside the drive's step, which costs the same as without it. In the interrupt:
///
///     lode_single_shunt_read(&shunt, &tuning, link, drive.sense.offset[0], drive.inverter.v_bus_V, counts.i);
///     out = lode_drive_step(&drive, &counts);
///     plan = lode_single_shunt_write(&shunt, &tuning, out.duty, out.gates);
///     plan.rise and plan.fall into the compare registers of the two halves of the next period,
///     plan.sample into the ADC's triggers
///
/// The two samples lie in the second half of the period, as close to t_k as its edges allow: while two legs
/// are high the link carries minus the current of the third, while one is high that leg's. Needs
/// LODE_SHUNTS_THREE, duty_max 1, current.voltage_use at or below lode_single_shunt_voltage_use(), and
/// start.pulses off: a current in the low sides alone is not seen. With start.signal_check on, bridge and sensor are checked before
/// a start.
#ifndef LODESTAR_SINGLE_SHUNT_H
#define LODESTAR_SINGLE_SHUNT_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float f_pwm_Hz;       ///< as the drive's
    float i_gain_A_count; ///< as the drive's: current from the link into the bridge per count
    float window_s;       ///< from an edge to the end of a sample: dead time, settling, sampling
    float sample_s;       ///< from a trigger to the end of the sampling; part of window_s
    float L_H; ///< mean of Ld and Lq: extrapolates both samples to t_k; 0: used as they are
} lode_single_shunt_config_t;

typedef struct {
    float window;       ///< least distance of two duties' edges, in duties
    float sample;       ///< share of the period
    float rise_count_V; ///< that a volt over a period makes of a phase current, counts
} lode_single_shunt_tuning_t;

/// One period of PWM. A leg is high from (1 - rise)/2 of the period to (1 + fall)/2.
typedef struct {
    lode_abc_t rise; ///< [0, 1]; with `fall` the mean of both is the duty
    lode_abc_t fall;
    float sample[2];       ///< triggers, shares of the period: two legs high, one leg high
    float correction_V[2]; ///< per bus volt, over a period: from the samples to t_k
    uint_least8_t least;   ///< phase whose current, reversed, the first shows
    uint_least8_t most;    ///< that of the second
    bool driven;           ///< else the link shows no current
    bool blind;            ///< the edges cannot be moved far enough: both samples are of no use
} lode_single_shunt_plan_t;

typedef struct {
    lode_single_shunt_plan_t plan[2]; ///< of the period that ends, and of the one that begins
    uint16_t count[3];                ///< handed out last
} lode_single_shunt_t;

/// SENSE_WINDOW: window_s outside 0 .. a quarter of the period, or sample_s outside 0 .. window_s.
/// SENSE_CURRENT: the gain is 0 or no number, or L_H negative.
lode_status_t lode_single_shunt_tune(lode_single_shunt_tuning_t *tuning,
                                     const lode_single_shunt_config_t *config);

/// Largest current.voltage_use without blind sectors; at most the core's default of 0.95.
float lode_single_shunt_voltage_use(const lode_single_shunt_tuning_t *tuning);

/// Gates off, no current.
void lode_single_shunt_reset(lode_single_shunt_t *self);

/// The counts at t_k from the samples of the period that ends there. `offset`: of the link's ADC channel, 1/256
/// count, as calibrated; `v_bus_V`: at t_k-1. Where that period was blind the last counts stay. Interrupt.
void lode_single_shunt_read(lode_single_shunt_t *self, const lode_single_shunt_tuning_t *tuning,
                            const uint16_t link[2], int32_t offset, float v_bus_V,
                            uint16_t count[3]);

/// Turns the drive's duties into the edges of the next period. Interrupt, after the step.
lode_single_shunt_plan_t lode_single_shunt_write(lode_single_shunt_t *self,
                                                 const lode_single_shunt_tuning_t *tuning,
                                                 lode_abc_t duty, lode_gates_t gates);

#ifdef __cplusplus
}
#endif

#endif
