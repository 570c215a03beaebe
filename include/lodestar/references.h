/// From torque to current references: id* = 0 or maximum torque per ampere (MTPA), field weakening up to
/// maximum torque per volt (MTPV), and limits that follow the bus. docs/theory/references.md.
#ifndef LODESTAR_REFERENCES_H
#define LODESTAR_REFERENCES_H

#include "lodestar/inverter.h"
#include "lodestar/ramp.h"

#ifdef __cplusplus
extern "C" {
#endif

/// LODE_WITHOUT_FIELD_WEAKENING leaves that out of a build; LODE_WITHOUT_OPTIMAL_REFERENCES all but id* = 0
/// with its bias: MTPA, field weakening, saturation, limits that follow the bus. Init then refuses them
/// (LODE_ERROR_REFERENCES). A tuning from elsewhere that asks for them runs without.
typedef enum {
    LODE_REFERENCES_AUTO, ///< ID0; MTPA where an error of Lq would otherwise make the angle error grow without limit (R15)
    LODE_REFERENCES_ID0, ///< id* = 0
    LODE_REFERENCES_MTPA ///< least current for the torque
} lode_references_kind_t;

typedef struct {
    lode_references_kind_t kind;
    lode_choice_t field_weakening; ///< auto: off
    float id_bias_A; ///< magnitude of the negative id at low speed, which keeps the phase currents
                     ///< away from the dead band of the inverter; 0: 0.25 i_max, but by (K31) none;
                     ///< LODE_NONE: none
    float omega_low_rad_s;  ///< electrical speed up to which the bias is full; 0: 0.2 of rated
    float omega_high_rad_s; ///< from which the bias is zero; 0: 0.4 of rated
    /// share of the current control's voltage circle at which the field is weakened, 0.1 .. 1;
    /// 0: 0.95. The rest is for control
    float voltage_use;
    /// bandwidth at which the voltage that is really used is brought to that share, 0.1 .. 1e3;
    /// 0: 20; LODE_NONE: feed-forward only
    float trim_rad_s;
    float release_s;   ///< time in which id may rise by i_max, 1e-3 .. 10; 0: 0.1
    float id_max_A;    ///< magnitude of the most negative id: demagnetisation; 0: i_max
    float Lq_fall;     ///< saturation: Lq is Lq_H/(1 + Lq_fall |iq|), 1/A; 0: no saturation
    float v_regen_V;   ///< bus voltage from which braking torque fades; 0: does not fade
    float v_motor_V;   ///< bus voltage below which motoring torque fades; 0: does not fade
    float v_bus_max_V; ///< where no braking torque is left; 0: halfway to where the guard trips
    float v_bus_min_V; ///< where no motoring torque is left; 0: halfway to where the guard trips
} lode_references_config_t;

/// What a tuning asks of a call, in one word.
enum {
    LODE_REFERENCES_LEAST_CURRENT = 1, ///< MTPA
    LODE_REFERENCES_WEAKEN = 2,
    LODE_REFERENCES_REACH_MTPV = 4, ///< the speed of maximum torque per volt can be reached
    LODE_REFERENCES_FADE = 8,       ///< braking or motoring torque follows the bus
    LODE_REFERENCES_SATURATE = 16,  ///< Lq falls
};

typedef struct {
    lode_fade_t fade;
    float id_bias_A;
    float i_max_A;
    float psi_Wb;
    float torque_factor; ///< 1.5 np per winding set
    uint32_t options;    ///< 0: id* = 0 and nothing else
    float inv_torque_factor;
    float tau_max; ///< most torque inside the circle, over torque_factor
    float inv_psi2;
    float Ld_H;
    float inv_Ld;
    float Lq_H; ///< at zero current
    float Lq_fall;
    float circle;     ///< voltage to be used per bus volt
    float trim_gain;  ///< per V^2 and call
    float trim_decay; ///< per call
    float drop;       ///< Rs over the nominal voltage to be used
    float id_min_A;
    float fall_A; ///< largest move of id per call, towards weaker fields
    float rise_A; ///< and back
    lode_fade_t regen;
    lode_fade_t motor; ///< of the negative bus voltage
} lode_references_tuning_t;

/// More than id* = 0 takes several periods, and remembers what it found in them.
typedef struct {
    float id_A;
    float iq_A;
    float tau;        ///< torque of both over the torque factor
    float trim;       ///< share by which the voltage to be used is corrected
    float flux;       ///< that the voltage leaves room for, Wb
    float tau_most;   ///< most torque at that flux, over the torque factor
    float id_least_A; ///< id there, or the least allowed one
    float id_free_A;  ///< id for the torque alone
    float moved_A;    ///< last move of id
} lode_references_t;

/// What limits the references from outside.
typedef struct {
    float v_bus_V;
    lode_dq_t u_V; ///< what current control asked for last
} lode_references_voltage_t;

typedef struct {
    lode_dq_t i_A;
    lode_range_t torque_Nm; ///< what can be had at this speed and voltage
} lode_references_out_t;

void lode_references_design(lode_references_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor);

/// `voltage_use`: of current control; `ts_s`: time between two calls of the step.
lode_status_t lode_references_tune(lode_references_tuning_t *tuning,
                                   const lode_references_config_t *config,
                                   const lode_inverter_config_t *inverter,
                                   const lode_motor_t *motor, float voltage_use, float ts_s);

/// Starts from `id_A`, without a step.
void lode_references_reset(lode_references_t *self, float id_A);

/// The id for a torque and speed while the voltage does not limit it.
float lode_references_id_A(const lode_references_tuning_t *tuning, float torque_Nm,
                           float omega_rad_s);

/// Most torque that current and voltage allow with the last call's `id_A`, Nm, without the fade by the bus. Not for
/// each period.
float lode_references_allowed_Nm(const lode_references_t *self,
                                 const lode_references_tuning_t *tuning, float id_A);

/// Torque of i_max at id = 0, Nm.
static inline float lode_references_most_Nm(const lode_references_tuning_t *tuning) {
    return tuning->i_max_A * (tuning->torque_factor * tuning->psi_Wb);
}

/// Torque that `i_A` makes, Nm: the inverse of the step without its limits and without saturation.
float lode_references_torque_Nm(const lode_references_tuning_t *tuning, lode_dq_t i_A);

#ifdef __cplusplus
}
#endif

#endif
