/// Rotor angle and speed from voltages and currents alone.
///
/// EMF observer, phase-locked loop, exact compensation of the observer's lag, and their supervision: an acquisition that
/// finds angle, speed and direction without a start value, and a lock quality that says how reliable the estimate is.
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

/// Configuration of the estimator. Speeds are electrical. A field that is 0 gets its default from
/// lode_estimator_design().
typedef struct {
    lode_emf_config_t emf;
    lode_pll_config_t pll;
    lode_lag_kind_t compensation;
    /// compensate the EMF of a changing active flux, which both papers neglect (E5); auto: on
    lode_choice_t active_flux;
    /// low-pass filter on the speed that tunes the observers other than the C-LESO, 0 .. 1/Ts; 0: none
    float w_filter_rad_s;
    float
        notch_k; ///< relative width of the notch at 6 w on the position error (paper 1, eq. 34); 0: none
    float notch12_k; ///< the same at 12 w; 0: none
    /// smallest EMF that is used as a divisor, 1e-4 .. 1e3; 0: 0.03 of the EMF at rated speed
    float emin_V;
    /// highest electrical speed of the application, 1 .. 0.5/Ts; 0: 2.5 times rated, more in a drive with field
    /// weakening, at most 0.5/Ts
    float omega_max_rad_s;
    float lock_s; ///< time constant of the lock quality, Ts .. 1; 0: 5 ms
} lode_estimator_config_t;

/// Bits of lode_estimator_tuning_t.options: what a tuning needs in a control period.
enum {
    LODE_ESTIMATOR_SALIENT = 1,      ///< the EMF of a changing active flux is compensated
    LODE_ESTIMATOR_FILTERED = 2,     ///< the speed that tunes the EMF observer is filtered
    LODE_ESTIMATOR_NOTCH = 4,        ///< there is a notch at 6 w or 12 w
    LODE_ESTIMATOR_NOTCH12 = 8,      ///< there is a notch at 12 w
    LODE_ESTIMATOR_THIRD_ORDER = 16, ///< LESO-QPLL
};

/// All that is derived from the configuration.
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
    float notch12_k; ///< relative width of the notch at 12 w; 0: none
#endif
    float w_weight; ///< weight of a new sample in the filtered speed; 1: no filter
    float emin_V;
    /// twice omega_max_rad_s: a higher speed counts as an alias
    float omega_limit;
    /// position error up to which an EMF amplitude that is a few periods old is accurate enough
    float error_small;
    float droop_s2; ///< fall of the observer's amplitude with speed, as 1/(1 + droop w^2)
    float psi_Wb;
    float salient_H;      ///< Ld - Lq
    float acc_per_torque; ///< 1.5 np^2/J; 0 with the QPLL
    float acc_per_omega;  ///< B/J; 0 with the QPLL
    /// largest acceleration by current below the trip limit, and by friction (P30); the drive sets it
    float acc_most;
    float load_per_f_Nm;   ///< load torque per disturbance, -J/np; 0 with the QPLL
    float lock_weight;     ///< weight of a new sample in the lock quality
    float rotation_weight; ///< weight of a new sample in the mean rotation
    uint_least16_t
        settle_rounds; ///< rounds of LODE_SLOW_PERIODS from a reset to the first acquisition
    uint_least16_t patience_rounds; ///< rounds without a lock until the next acquisition
} lode_estimator_tuning_t;

/// State that is needed by the EMF alone. While injection provides the position, wholly or in part, its state
/// (lode_hfi_t) occupies the same memory: there are then no notches and no acquisition.
typedef struct {
#ifndef LODE_WITHOUT_HFI
    bool active;         ///< false; at the same place as in lode_hfi_t
    uint_least8_t step;  ///< at the same place as in lode_hfi_t
    uint_least16_t wait; ///< without lock: rounds until the next acquisition
    float reserve_V;     ///< 0; at the same place as in lode_hfi_t
#else
    uint_least16_t wait; ///< without lock: rounds until the next acquisition
#endif
#ifndef LODE_WITHOUT_NOTCH
    lode_notch_t notch;
    lode_notch_t notch12;
#endif
    lode_ab_t rotation; ///< without lock: mean of e[k] conj(e[k-1]), V^2; its angle is w Ts
    lode_ab_t before_V; ///< without lock: e[k-1]
} lode_estimator_alone_t;

/// State of the estimator.
typedef struct {
    lode_emf_t emf;
    lode_pll_t pll;
    lode_pll_gains_t gains; ///< PLL gains at the present speed
    lode_lag_line_t lag;    ///< lag of the observer near the present speed
    /// one over the EMF's amplitude when that was last computed; negative for positive speed
    float per_V;
    float id_A;          ///< current along the estimated d axis at t_k
    float lock;          ///< lock quality, 0 .. 1
    bool locked;         ///< lock >= LODE_LOCK_LOST, and a rotor has been found
    bool aligned;        ///< the direction of the d axis is known well enough
    uint_least8_t found; ///< not 0: angle and speed have been acquired or set since the reset
    uint_least8_t slot;  ///< job of the next lode_estimator_step()
    union {
        lode_estimator_alone_t alone;
#ifndef LODE_WITHOUT_HFI
        lode_hfi_t hfi;
#endif
    } by;
    float omega_tune; ///< speed that tunes the observer, if it is filtered
    /// speed and disturbance of the PLL from where the next check of its motion counts (P30); a speed of 0: no check
    float omega_noted;
    float f_noted;
} lode_estimator_t;

/// Source of an estimate.
typedef enum {
    LODE_ESTIMATE_OWN,      ///< the drive's estimator
    LODE_ESTIMATE_EXTERNAL, ///< external: the drive checks it and takes it over
    LODE_ESTIMATE_SENSOR, ///< the same from an angle sensor, valid at any speed: no start, no lowest speed
    LODE_ESTIMATE_EDGES, ///< the same from a coarse sensor that is exact only at its edges: no id bias
    LODE_ESTIMATE_NONE ///< the gates of the drive are off: there is no estimate
} lode_estimate_source_t;

/// An estimate. All values are those at t_k, the instant of the current sample.
typedef struct {
    float omega_rad_s;    ///< electrical speed
    lode_sincos_t rotor;  ///< sine and cosine of the electrical rotor angle
    lode_dq_t i_A;        ///< current in the rotor's frame
    lode_ab_t e_V;        ///< raw output of the EMF observer, stator axes
    float load_torque_Nm; ///< estimated load; 0 with the QPLL
    float
        lock; ///< quality, 0: no information .. 1: reliable; below LODE_LOCK_LOST the lock is lost
    bool reseeded; ///< the state was lost or out of range and was acquired again in this call
    lode_estimate_source_t source;
} lode_estimate_t;

/// Electrical rotor angle of an estimate, [-pi, pi].
static inline float lode_estimate_theta_rad(const lode_estimate_t *estimate) {
    return lode_atan2(estimate->rotor.sin, estimate->rotor.cos);
}

/// Lock quality below which the angle must not be used: the EMF's amplitude is 40 % off what the speed would induce
/// (lost in all of 100 simulated slips, in no healthy run), or the angle is on average 60 degrees off that of the
/// EMF.
#define LODE_LOCK_LOST 0.5f

/// Fills every zero field that has a default. `motor->omega_rated_rad_s` must be set.
void lode_estimator_design(lode_estimator_config_t *config, const lode_motor_t *motor, float ts_s);

/// Checks a completed configuration and derives the tuning. `ts_s`: control period. On any error `tuning` is left
/// alone.
lode_status_t lode_estimator_tune(lode_estimator_tuning_t *tuning,
                                  const lode_estimator_config_t *config, const lode_motor_t *motor,
                                  float ts_s);

/// Clears the state. Angle and speed are then acquired from the EMF within a few milliseconds of motion.
void lode_estimator_reset(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);

/// Sets angle and electrical speed to known values, as in a start by the vector. The EMF continues.
void lode_estimator_hold(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                         lode_sincos_t rotor, float omega_rad_s);

/// Replaces the present current by `i_A` after the current has changed its meaning, as when one set of a winding
/// continues alone. Angle, speed and EMF remain.
void lode_estimator_set_current(lode_estimator_t *self, lode_ab_t i_A);

/// One control period. `u_V`: mean voltage over [t_k-1, t_k); `i_A`: current at t_k. Accepts any input: the output
/// is finite and in range. `reseeded`: the state had to be acquired again.
lode_estimate_t lode_estimator_step(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                                    lode_ab_t u_V, lode_ab_t i_A);

/// Electrical rotor angle at t_k, [-pi, pi].
float lode_estimator_theta_rad(const lode_estimator_t *self);

#ifdef __cplusplus
}
#endif

#endif
