// Shared by the parts of self-commissioning, in the order in which they run: commission_sensors.c with the rotor free,
// commission_resistance.c and commission_inductances.c with the rotor held, commission_run.c with the rotor turning.
// commission.c runs them.
#ifndef LODE_COMMISSION_PARTS_H
#define LODE_COMMISSION_PARTS_H

#include "commission_machine.h"

#ifndef LODE_WITHOUT_COMMISSIONING

#include "inverter_inline.h"
#include "scalar_inline.h"

// Periods from writing a voltage to the current that it makes.
#define SEEN_PERIODS 3u

typedef enum {
    STAGE_CALIBRATE,
    STAGE_PULSES, // a, b, c
    STAGE_ACROSS,
    STAGE_ALONG,
    STAGE_LEVEL,
    STAGE_LD, // three currents
    STAGE_LQ,
    STAGE_LQ_FALL, // three amplitudes
    STAGE_LXY,     // six phases only
    STAGE_RETUNE,
    STAGE_START,
    STAGE_UP,
    STAGE_DOWN,
    STAGE_OVER
} lode_commission_stage_t;

static inline float lode_commission_float(uint32_t count) {
    return (float)(int32_t)count;
}

static inline uint32_t lode_commission_periods(const lode_commission_t *self, float time_s) {
    const float periods = time_s * self->config.f_pwm_Hz + 0.5f;
    return (uint32_t)(int32_t)periods;
}

static inline float lode_commission_length(lode_dq_t x) {
    return lode_ab_length((lode_ab_t){x.d, x.q});
}

static inline lode_commission_quantity_t lode_commission_offset_of(uint32_t phase) {
    const uint32_t quantity = (uint32_t)LODE_COMMISSION_OFFSET_A + phase;
    return (lode_commission_quantity_t)quantity;
}

static inline float lode_commission_found(const lode_commission_t *self,
                                          lode_commission_quantity_t quantity) {
    return self->found[quantity].value;
}

static inline bool lode_commission_is_sure(const lode_commission_t *self,
                                           lode_commission_quantity_t quantity) {
    return self->found[quantity].confidence >= LODE_COMMISSION_SURE;
}

// In commission.c.

// If the drive refuses it, the commissioning ends with REFUSED in this period.
void lode_commission_post(lode_commission_t *self, lode_command_t command);

// A voltage or a current, in the axes of the held rotor.
void lode_commission_post_vector(lode_commission_t *self, lode_mode_t mode, float d, float q);

// Makes the next period the first of the stage again.
void lode_commission_restart(lode_commission_t *self);

void lode_commission_enter(lode_commission_t *self, lode_commission_stage_t stage);

void lode_commission_finish(lode_commission_t *self, lode_commission_result_t result);

// A value with the confidence that its deviation leaves, compared to the allowed one.
lode_commission_value_t lode_commission_judged(float value, float deviation, float allowed);

// Stores a value. False: its confidence is too low, and commissioning has ended.
bool lode_commission_keep(lode_commission_t *self, lode_commission_quantity_t quantity, float value,
                          float deviation, float allowed);

// Voltage along the holding axis per volt that each phase loses (N5).
float lode_commission_dead_along(const lode_commission_t *self);

// Voltage that a phase loses by the configuration.
float lode_commission_dead_known_V(const lode_drive_config_t *config);

// The following are one period of a stage each. Currents and voltages are in the axes of the held rotor, in STAGE_LXY in
// those of the xy plane.

// In commission_sensors.c.

void lode_commission_calibrate(lode_commission_t *self, const lode_commission_period_t *period);

void lode_commission_pulse(lode_commission_t *self, const lode_commission_period_t *period,
                           lode_dq_t i_A);

// In commission_resistance.c.

// Chooses the current that holds the rotor, and the rates of the voltage on the way to it.
void lode_commission_choose_vector(lode_commission_t *self);

void lode_commission_across(lode_commission_t *self, lode_dq_t i_A);

void lode_commission_along(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A);

void lode_commission_move_level(lode_commission_t *self, lode_dq_t i_A);

// In commission_inductances.c.

void lode_commission_Ld(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A);

void lode_commission_Lq(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A);

void lode_commission_Lq_fall(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A);

void lode_commission_Lxy(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A);

// In commission_run.c.

void lode_commission_retune(lode_commission_t *self);

void lode_commission_start(lode_commission_t *self);

// `way`: 0 up, 1 down.
void lode_commission_run(lode_commission_t *self, uint32_t way);

// Repeats the run after a lost rotor. All other faults end the commissioning.
void lode_commission_end_by_fault(lode_commission_t *self);

#endif

#endif
