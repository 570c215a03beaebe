/// Rotor angle and speed from voltages and currents alone.
///
/// EMF observer, phase-locked loop, exact compensation of the observer's lag, and the supervision
/// around them: an acquisition that finds angle, speed and direction without any start value, and a
/// lock quality that says how far to trust the result.
#ifndef LODESTAR_ESTIMATOR_H
#define LODESTAR_ESTIMATOR_H

#include "lodestar/emf.h"
#include "lodestar/hfi.h"
#include "lodestar/inverter.h"
#include "lodestar/lag.h"
#include "lodestar/notch.h"
#include "lodestar/pll.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lode_emf_config_t emf;
    lode_pll_config_t pll;
    lode_lag_kind_t compensation;
    lode_choice_t active_flux; ///< EMF of a changing active flux, which both papers omit; auto: on
    float
        w_filter_rad_s; ///< low-pass on the speed that tunes all but the C-LESO, 0 .. 1/Ts; 0: none
    float notch_k;   ///< width of the notch at 6 w on the position error (paper 1, eq. 34); 0: none
    float notch12_k; ///< the same at 12 w; 0: none
    float emin_V; ///< smallest EMF used as a divisor, 1e-4 .. 1e3; 0: 0.03 of that at rated speed
    /// Highest electrical speed of the application, 1 .. 0.5/Ts; 0: 2.5 times rated, at most 0.5/Ts; with
    /// field weakening more.
    float omega_max_rad_s;
    float lock_s; ///< time constant of the lock quality, Ts .. 1; 0: 5 ms
} lode_estimator_config_t;

/// What a tuning asks of a period, in one word that is read once.
enum {
    LODE_ESTIMATOR_SALIENT = 1,      ///< the EMF of a changing active flux is taken out
    LODE_ESTIMATOR_FILTERED = 2,     ///< the speed that tunes the EMF observer is filtered
    LODE_ESTIMATOR_NOTCH = 4,        ///< at 6 w or 12 w
    LODE_ESTIMATOR_NOTCH12 = 8,      ///< at 12 w
    LODE_ESTIMATOR_THIRD_ORDER = 16, ///< LESO-QPLL
};

typedef struct {
    uint32_t options;
    lode_emf_tuning_t emf;
    lode_pll_tuning_t pll;
    lode_lag_t lag;
#ifndef LODE_WITHOUT_HFI
    lode_hfi_tuning_t hfi;
#endif
#ifndef LODE_WITHOUT_NOTCH
    lode_notch_tuning_t notch;
    float notch12_k; ///< relative width of the one at 12 w; 0: no notch
#endif
    float w_weight; ///< of a new sample in the speed that tunes the observer; 1: no filter
    float emin_V;
    float omega_limit; ///< twice omega_max: beyond it the speed is taken for an alias
    float error_small; ///< position error up to which the amplitude of a few periods ago will do
    float droop_s2;    ///< by which the observer's amplitude falls with speed
    float psi_Wb;
    float salient_H;              ///< Ld - Lq
    float acc_per_torque;         ///< 1.5 np^2/J; 0 without feed-forward
    float acc_per_omega;          ///< B/J
    float load_per_f_Nm;          ///< -J/np; 0 without disturbance state
    float lock_weight;            ///< of a new sample in the lock quality
    float rotation_weight;        ///< in the mean rotation
    uint_least16_t settle_rounds; ///< from reset until the first acquisition, in LODE_SLOW_PERIODS
    uint_least16_t patience_rounds; ///< without lock until the next one
} lode_estimator_tuning_t;

/// What the EMF alone has use for. Where injection gives the position, wholly or in part, its state takes the
/// place of all of this: the notches rest, and nothing is acquired.
typedef struct {
#ifndef LODE_WITHOUT_HFI
    bool active;         ///< as in lode_hfi_t: false
    uint_least8_t step;  ///< as in lode_hfi_t
    uint_least16_t wait; ///< rounds until the next acquisition, while there is no lock
    float reserve_V;     ///< 0
#else
    uint_least16_t wait; ///< rounds until the next acquisition, while there is no lock
#endif
#ifndef LODE_WITHOUT_NOTCH
    lode_notch_t notch;
    lode_notch_t notch12;
#endif
    lode_ab_t rotation; ///< without lock: mean of e[k] conj(e[k-1]), V^2: its angle is w Ts
    lode_ab_t before_V; ///< without lock: e[k-1]
} lode_estimator_alone_t;

typedef struct {
    lode_emf_t emf;
    lode_pll_t pll;
    lode_pll_gains_t gains; ///< at the present speed
    lode_lag_line_t lag;    ///< of the observer, about the present speed
    float
        per_V; ///< one over the EMF's amplitude when it was last looked at, negative for positive speed
    float id_A; ///< current in the rotor's direction at t_k
    float lock;
    bool locked;         ///< lock >= LODE_LOCK_LOST, of a rotor that has been found
    bool aligned;        ///< good enough to know the direction of the d axis
    uint_least8_t found; ///< above 0: angle and speed were acquired, held or given since the reset
    uint_least8_t slot;  ///< of lode_estimator_step()
    union {
        lode_estimator_alone_t alone;
#ifndef LODE_WITHOUT_HFI
        lode_hfi_t hfi;
#endif
    } by;
    float omega_tune; ///< the speed that tunes the observer, where it is filtered
} lode_estimator_t;

/// Source of an estimate.
typedef enum {
    LODE_ESTIMATE_OWN,      ///< the drive's estimator
    LODE_ESTIMATE_EXTERNAL, ///< from outside: the drive checks it and uses it
    LODE_ESTIMATE_SENSOR,   ///< the same, good at any speed: no start, no least speed
    LODE_ESTIMATE_EDGES,    ///< the same, from a coarse sensor, known at its edges: no id bias
    LODE_ESTIMATE_NONE      ///< none, as the gates are off
} lode_estimate_source_t;

/// All at t_k, the instant of the current sample.
typedef struct {
    float omega_rad_s;    ///< electrical speed
    lode_sincos_t rotor;  ///< sine and cosine of the electrical rotor angle
    lode_dq_t i_A;        ///< current in the rotor's frame
    lode_ab_t e_V;        ///< raw output of the EMF observer
    float load_torque_Nm; ///< 0 with the QPLL
    float lock;           ///< 0: no information .. 1: trustworthy; below LODE_LOCK_LOST it is lost
    bool reseeded; ///< the state was out of range or lost, and was acquired again in this call
    lode_estimate_source_t source;
} lode_estimate_t;

/// Electrical rotor angle of an estimate, [-pi, pi].
static inline float lode_estimate_theta_rad(const lode_estimate_t *estimate) {
    return lode_atan2(estimate->rotor.sin, estimate->rotor.cos);
}

/// Below this quality the angle must not be used: the EMF's amplitude is 40 % off what the speed
/// would induce (lost in all of 100 simulated slips, in none of the sound runs), or the angle is on
/// average 60 degrees off the EMF's.
#define LODE_LOCK_LOST 0.5f

/// Fills every zero field that has a default; `motor->omega_rated_rad_s` must be set.
void lode_estimator_design(lode_estimator_config_t *config, const lode_motor_t *motor, float ts_s);

lode_status_t lode_estimator_tune(lode_estimator_tuning_t *tuning,
                                  const lode_estimator_config_t *config, const lode_motor_t *motor,
                                  float ts_s);

/// Resets everything: angle and speed are acquired from the EMF within a few milliseconds of motion.
void lode_estimator_reset(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);

/// Sets angle and speed to what the caller knows, as in a forced start. The EMF is kept.
void lode_estimator_hold(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                         lode_sincos_t rotor, float omega_rad_s);

/// The currents change their meaning, as when one set of a winding continues alone: `i_A` is the present
/// one in the new sense. Angle, speed and EMF are kept.
void lode_estimator_set_current(lode_estimator_t *self, lode_ab_t i_A);

/// One period: `u_V` is the mean voltage over [t_k-1, t_k), `i_A` the current at t_k. Any input
/// is allowed: the output is finite and in range. `reseeded` means that the state had to be acquired again.
lode_estimate_t lode_estimator_step(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                                    lode_ab_t u_V, lode_ab_t i_A);

/// The rotor's angle at t_k, in [-pi, pi].
float lode_estimator_theta_rad(const lode_estimator_t *self);

#ifdef __cplusplus
}
#endif

#endif
