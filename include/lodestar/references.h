/// From torque to current references: id* = 0 or maximum torque per ampere (MTPA), field weakening up to maximum
/// torque per volt (MTPV), and torque limits that follow the bus voltage. docs/theory/references.md.
#ifndef LODESTAR_REFERENCES_H
#define LODESTAR_REFERENCES_H

#include "lodestar/inverter.h"
#include "lodestar/ramp.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Kind of references. LODE_WITHOUT_FIELD_WEAKENING leaves field weakening out of a build.
/// LODE_WITHOUT_OPTIMAL_REFERENCES leaves out everything except id* = 0 with its bias: MTPA, field weakening,
/// saturation, limits that follow the bus. A configuration that requests them is then refused
/// (LODE_ERROR_REFERENCES); a tuning made by another build runs without them.
typedef enum {
    /// ID0; MTPA if the angle error that an error of Lq causes would otherwise grow without limit (R15)
    LODE_REFERENCES_AUTO,
    LODE_REFERENCES_ID0, ///< id* = 0
    LODE_REFERENCES_MTPA ///< least current for the torque (R3)
} lode_references_kind_t;

/// Configuration of the references. Speeds are electrical. A field that is 0 gets its default from
/// lode_references_design().
typedef struct {
    lode_references_kind_t kind;
    lode_choice_t field_weakening; ///< auto: off
    /// magnitude of the negative id at low speed, which keeps the phase currents out of the dead band of the
    /// inverter; 0: 0.25 i_max, or none by (K31); LODE_NONE: none
    float id_bias_A;
    float omega_low_rad_s;  ///< speed up to which the bias is full; 0: 0.2 of rated
    float omega_high_rad_s; ///< speed from which there is no bias; 0: 0.4 of rated
    /// share of current control's voltage circle at which field weakening begins, 0.1 .. 1; 0: 0.95. The rest is
    /// left to current control
    float voltage_use;
    /// bandwidth with which the trim brings the voltage in use to that share, 0.1 .. 1e3; 0: 20; LODE_NONE:
    /// feed-forward only (R9)
    float trim_rad_s;
    float release_s;   ///< time in which id may rise by i_max, 1e-3 .. 10; 0: 0.1
    float id_max_A;    ///< magnitude of the most negative id, against demagnetisation; 0: i_max
    float Lq_fall;     ///< saturation: Lq is Lq_H/(1 + Lq_fall |iq|), 1/A (R2); 0: none
    float v_regen_V;   ///< bus voltage above which braking torque fades (R14); 0: never
    float v_motor_V;   ///< bus voltage below which motoring torque fades; 0: never
    float v_bus_max_V; ///< bus voltage with no braking torque left; 0: halfway to the guard's limit
    float
        v_bus_min_V; ///< bus voltage with no motoring torque left; 0: halfway to the guard's limit
} lode_references_config_t;

/// Bits of lode_references_tuning_t.options: what a tuning needs in a call.
enum {
    LODE_REFERENCES_LEAST_CURRENT = 1, ///< MTPA
    LODE_REFERENCES_WEAKEN = 2,        ///< field weakening
    LODE_REFERENCES_REACH_MTPV = 4,    ///< MTPV can be reached
    LODE_REFERENCES_FADE = 8,          ///< braking or motoring torque fades with the bus voltage
    LODE_REFERENCES_SATURATE = 16,     ///< Lq depends on iq
};

/// All that is derived from the configuration. "Per call" means per call of the references.
typedef struct {
    lode_fade_t fade; ///< of the bias over speed
    float id_bias_A;
    float i_max_A;
    float psi_Wb;
    float torque_factor; ///< torque per Wb and A: 1.5 np per winding set
    uint32_t options;    ///< 0: id* = 0 with its bias and nothing else
    float inv_torque_factor;
    float tau_max; ///< largest torque within i_max, over torque_factor
    float inv_psi2;
    float Ld_H;
    float inv_Ld;
    float Lq_H; ///< at zero current
    float Lq_fall;
    float circle;      ///< usable voltage per bus volt
    float trim_gain;   ///< of the trim, per V^2 and call
    float trim_decay;  ///< decay of the trim per call
    float drop;        ///< Rs over the nominal usable voltage
    float id_min_A;    ///< lowest id
    float fall_A;      ///< largest fall of id per call, towards a weaker field
    float rise_A;      ///< largest rise of id per call
    lode_fade_t regen; ///< fade of braking torque over the bus voltage
    lode_fade_t motor; ///< fade of motoring torque over the negative bus voltage
} lode_references_tuning_t;

/// State. Anything beyond id* = 0 is computed in parts, in several periods, and keeps its results here.
typedef struct {
    float id_A;
    float iq_A;
    float tau;        ///< torque of both currents, over the torque factor
    float trim;       ///< relative correction of the usable voltage (R9)
    float flux;       ///< flux for which the voltage suffices, Wb (R8)
    float tau_most;   ///< largest torque at that flux, over the torque factor
    float id_least_A; ///< id at that torque, or the lowest permitted id
    float id_free_A;  ///< id for the torque alone, without a voltage limit
    float moved_A;    ///< last change of id
} lode_references_t;

/// External limits of the references.
typedef struct {
    float v_bus_V; ///< bus voltage
    lode_dq_t u_V; ///< last voltage requested by current control
} lode_references_voltage_t;

typedef struct {
    lode_dq_t i_A;
    lode_range_t torque_Nm; ///< range that is available at this speed and voltage
} lode_references_out_t;

/// Fills every zero field that has a default.
void lode_references_design(lode_references_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor);

/// Checks a completed configuration and derives the tuning. `voltage_use`: that of current control. `ts_s`: time
/// between two calls of the references.
lode_status_t lode_references_tune(lode_references_tuning_t *tuning,
                                   const lode_references_config_t *config,
                                   const lode_inverter_config_t *inverter,
                                   const lode_motor_t *motor, float voltage_use, float ts_s);

/// Starts from the d current `id_A` without a jump.
void lode_references_reset(lode_references_t *self, float id_A);

/// The d current for a torque and an electrical speed, without a voltage limit.
float lode_references_id_A(const lode_references_tuning_t *tuning, float torque_Nm,
                           float omega_rad_s);

/// Largest torque, Nm, that current and voltage allow at the last call's `id_A`; limits by the bus voltage are not
/// included. Too costly for every control period.
float lode_references_allowed_Nm(const lode_references_t *self,
                                 const lode_references_tuning_t *tuning, float id_A);

/// Torque of i_max at id = 0, Nm.
static inline float lode_references_most_Nm(const lode_references_tuning_t *tuning) {
    return tuning->i_max_A * (tuning->torque_factor * tuning->psi_Wb);
}

/// Torque of the current `i_A`, Nm: the inverse of the references without limits and saturation.
float lode_references_torque_Nm(const lode_references_tuning_t *tuning, lode_dq_t i_A);

#ifdef __cplusplus
}
#endif

#endif
