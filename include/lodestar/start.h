/// I-f start: a current vector is raised and rotated open loop until the estimator has locked
/// (paper 1, Section 5, after its reference 33).
#ifndef LODESTAR_START_H
#define LODESTAR_START_H

#include "lodestar/estimator.h"
#include "lodestar/inverter.h"
#include "lodestar/plausibility.h"
#include "lodestar/references.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    /// amplitude of the vector; 0: 0.7 i_max, at most psi/(2 (Lq - Ld))
    float current_A;
    /// the same in the last attempt, current_A .. i_max; 0: current_A where that is given, else twice the default, 0.7
    /// to 1 i_max. If above 1.5 current_A, also after an attempt whose rotor slipped (S42)
    float current_last_A;
    /// ELECTRICAL speed of the hand-over; 0: 0.1 of rated (150 of 1500 rpm), or up to 0.5 where 1 us of dead
    /// time and 30 % of R leave less than half of the EMF certain, or a load step would stop a light salient rotor;
    /// at least an EMF of a quarter of the drop across R
    float omega_handover_rad_s;
    /// electrical, of the first attempt; 0: what a tenth of the start torque gives the inertia, beginning at
    /// a sixteenth of that (S35)
    float ramp_rad_s2;
    float current_rise_s; ///< 0: 0.2; up to 0.4 for a heavy rotor without saliency
    float damping;        ///< ratio of the rotor's swing about the vector; 0: 0.5; LODE_NONE: none
    float lock_s;         ///< lock quality must have held for this long; 0: 0.1, salient from 0.05
    /// in the first attempt of a start from rest the vector stands at its axis with full current for this additional
    /// time before it rotates; 0: not at all
    float align_s;
    float catch_s;   ///< zero current, to see whether the rotor is turning; 0: 0.05; LODE_NONE
    float timeout_s; ///< from start to hand-over, of all attempts together; 0: three attempts
    /// measures resistance and dead time beyond the configured ones, from the voltage that half and all of the
    /// start current take at standstill; auto: on
    lode_choice_t measure;
    /// flying start: a rotor that is already turning is found by short zero vectors (fly.h); auto: on. Off for a
    /// board that sees no current with only the low sides on (one shunt in the DC link), or cannot switch them alone
    lode_choice_t pulses;
    /// bridge and sensors are checked by short voltage pulses before the first attempt (signal_check.h); auto: on where
    /// possible, but off where `pulses` or `catch_s` is off
    lode_choice_t signal_check;
    float
        fade_s; ///< from the start current to the references after hand-over; 0: 0.1, salient 0.05
} lode_start_config_t;

typedef struct {
    float current_A;
    float current_step; ///< A per period
    float omega_handover;
    float omega_ready; ///< from which the estimator may take over, up to omega_handover
    float
        sweep_step_rad; ///< per period while the current rises; from half the current on where a measurement is made there
    float omega_step;    ///< electrical rad/s per period, at most
    float steepens;      ///< share of that: times the speed and a 64th of omega_handover, s/rad
    float damping;       ///< largest angle by which the vector yields per V of swinging EMF, rad
    float damping_A;     ///< bound of it, times the current
    float damping_rad_s; ///< bound of it, times the speed
    float lost_per_A;    ///< share of the flux that the start's current takes, per A
    float mean_weight;   ///< of a new sample in the mean EMF
    float swing_weight;  ///< of a new sample in its swing
    float fade_step;     ///< per call of the references
    uint_least16_t catch_rounds; ///< times, in LODE_SLOW_PERIODS
    uint_least16_t lock_rounds;
    float current_last_A; ///< in the last attempt
    float still_rounds;   ///< of current rise and lock
    float align_rounds;   ///< for which the vector stands with full current, in the first attempt
    uint32_t timeout_rounds;
    uint_least16_t patience_rounds; ///< at least, after the profile
    uint_least16_t
        dwell_rounds; ///< at most, for one mean while the vector stands; 0: nothing is measured
#ifndef LODE_WITHOUT_PLAUSIBILITY
    float
        omega_per_noise; ///< speed up to which a vector without lock turns, per V of lode_jump_t's noise (S49)
    float omega_most; ///< limit of it
#endif
#ifndef LODE_WITHOUT_START_MEASUREMENT
    float calm_V; ///< EMF across the vector below which the rotor stands still
#endif
} lode_start_tuning_t;

/// What the measurement at standstill has found.
typedef struct {
    float r_Ohm;  ///< resistance beyond the one already accounted for
    float dead_V; ///< voltage along the current that does not depend on its length
} lode_start_found_t;

/// What lode_start_t.stage may be.
typedef enum {
    LODE_START_NONE,  ///< no start
    LODE_START_CATCH, ///< looks for a rotor that is already turning
    LODE_START_HALF,  ///< measures at rest: with half the current,
    LODE_START_FULL,  ///< with all of it,
    LODE_START_ALONE, ///< or only with all of it, as half of it gave no result,
    LODE_START_FOUND, ///< and computes the result
    LODE_START_ALIGN, ///< stands for align_s
    LODE_START_TURN   ///< the vector rotates once its current is reached
} lode_start_stage_t;

/// The enumerator's name, for logs.
const char *lode_start_stage_name(lode_start_stage_t stage);

/// What an attempt has to meet before the estimator may take over, in the order in which it is checked. A failed
/// attempt reports the first criterion that it did not meet: what was measured, and the limit.
typedef enum {
    LODE_CRITERION_NONE,    ///< no attempt has failed
    LODE_CRITERION_CURRENT, ///< the vector has all of its current, A
    LODE_CRITERION_REST,    ///< the rotor has been at rest while the vector waited: for how long, s
    LODE_CRITERION_RAMP,    ///< the vector has reached its speed: electrical, rad/s
    /// the EMF is that of a rotor that follows the vector, allowing for all the flux that the current may take, V
    LODE_CRITERION_EMF,
    LODE_CRITERION_SPEED,    ///< the estimated speed is the vector's: electrical, rad/s
    LODE_CRITERION_FLUX,     ///< the d current takes no more than this share of the flux
    LODE_CRITERION_LOCK,     ///< lock quality
    LODE_CRITERION_HOLD,     ///< for how long speed, flux and lock have been right, s
    LODE_CRITERION_PROOF,    ///< lock quality within 0.4 s after the hand-over (S28)
    LODE_CRITERION_POLARITY, ///< injection has found where north is; measured: lock quality
    LODE_CRITERION_COUNT
} lode_criterion_t;

/// The enumerator's name, for logs.
const char *lode_criterion_name(lode_criterion_t criterion);

/// A criterion that is not met.
typedef struct {
    lode_criterion_t criterion;
    float measured; ///< in the unit of the criterion
    float limit;
} lode_start_unmet_t;

/// What is seen while the vector stands.
typedef struct {
    float sum_V;   ///< of the voltages along the axis at which the vector waits
    float summed;  ///< how many
    float along_V; ///< mean of these at half the current
    uint_least16_t
        dwelt; ///< rounds at the present current of the measurement, or with all of it for align_s
    uint_least16_t calm; ///< of those in the sum, how many have no EMF across the vector
} lode_start_rest_t;

/// What is seen while it turns.
typedef struct {
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_waves_t waves; ///< of three phases
#endif
    float shift_rad; ///< how far ahead the vector was at the last query
} lode_start_turn_t;

typedef struct {
    lode_sincos_t at;  ///< angle of the current vector before damping
    float omega_rad_s; ///< its electrical speed
    float current_A;   ///< its length
    float omega_target;
    float omega_step; ///< by which it goes there, per period
    float current_target;
    float mean_V;  ///< mean EMF across the vector
    float swing_V; ///< its deviation from the mean: due to the rotor's swing, which is to be damped
    uint32_t attempt; ///< rounds since the present attempt began; LODE_START_CATCH: rounds left
    union {
        lode_start_rest_t rest; ///< before LODE_START_TURN
        lode_start_turn_t turn; ///< LODE_START_TURN
    } seen;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_drop_t drop; ///< in the present stage
#endif
    float by_size;         ///< share of the EMF's size in the swing, with the sign of the speed
    float give;            ///< angle by which the vector yields per V of swinging EMF, rad
    uint_least16_t locked; ///< rounds of LODE_SLOW_PERIODS for which the lock has held
    uint_least16_t
        slips; ///< rounds at speed without the EMF of a rotor that follows, less those with it (S42)
    uint_least8_t stage;  ///< LODE_START_...
    uint_least8_t failed; ///< attempts, up to three
    uint_least8_t stands; ///< 1: the vector leads the rotor's axis, and does not sweep (S40)
    uint_least8_t more;   ///< 1: this attempt already has the current of the last one (S42)
} lode_start_t;

/// Share of omega_ready below which the EMF drowns in the inverter's errors, and the estimator is held to the vector.
#define LODE_START_HOLD 0.5f
/// Lock quality from which the estimator may take over: well above LODE_LOCK_LOST.
#define LODE_LOCK_HANDOVER 0.7f
/// Share of psi that the d current may take of a salient rotor's flux at hand-over. With little flux left, speed control
/// and the PLL excite each other before the current has been faded out.
#define LODE_START_LOST_MAX 0.4f
/// The vector yields, but does not run away: at 30 degrees from the phase axis at which it waits, a phase current
/// changes its sign, and with it the unknown part of the dead-time voltage (S31).
#define LODE_START_SHIFT_MAX_rad 0.42f

/// Whether the EMF exceeds the resistive drop at any possible hand-over speed, up to half of rated and base
/// speed (S27). False: starts and low speeds are only as good as the knowledge of current sensors and resistance. `config` is
/// that of lode_start_design().
bool lode_start_has_emf(const lode_start_config_t *config, const lode_inverter_config_t *inverter,
                        const lode_motor_t *motor);

void lode_start_design(lode_start_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_motor_t *motor, float ts_s);

lode_status_t lode_start_tune(lode_start_tuning_t *tuning, const lode_start_config_t *config,
                              const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                              float omega_max_rad_s, float ts_s);

/// A vector at the angle `at`, rotating at `omega_rad_s`, of length `current_A`: 0 for a start from
/// standstill, or the motor's present current when returning from sensorless running.
void lode_start_reset(lode_start_t *self, lode_sincos_t at, float omega_rad_s, float current_A);

/// From rest, but first with zero current for a while: the voltage that this takes reveals a rotor that
/// is already turning.
void lode_start_begin(lode_start_t *self, const lode_start_tuning_t *tuning);

/// After that, for a rotor whose d axis is near `axis` or opposite: the vector stands ahead of it, in the commanded
/// `direction`, while the first attempt's current rises (S40).
void lode_start_lead(lode_start_t *self, lode_sincos_t axis, float direction);

/// Elapsed share of the time for which an attempt waits for its lock, after the profile: 0 .. 1.
float lode_start_waited(const lode_start_t *self, const lode_start_tuning_t *tuning);

/// Sets the vector's target: electrical speed and amplitude. Once in LODE_SLOW_PERIODS, even if unchanged,
/// because it counts the time of the attempt. True: the attempt's time is over, and it has failed.
bool lode_start_aim(lode_start_t *self, const lode_start_tuning_t *tuning, float omega_target_rad_s,
                    float current_A);

/// The criterion that the attempt does not meet now, while the vector rotates or waits.
lode_start_unmet_t lode_start_unmet(const lode_start_t *self, const lode_start_tuning_t *tuning,
                                    const lode_estimator_t *estimator,
                                    const lode_estimator_tuning_t *estimator_tuning);

/// Once in LODE_SLOW_PERIODS: whether the EMF is that of a rotor that follows the vector. If it is not for long
/// enough, the attempt has failed too (S42).
void lode_start_note_slip(lode_start_t *self, const lode_start_tuning_t *tuning,
                          const lode_estimator_t *estimator,
                          const lode_estimator_tuning_t *estimator_tuning);

/// The failed attempt was the last one, and the rotor has not followed: repeating it is of no use.
bool lode_start_is_lost(const lode_start_t *self, const lode_start_tuning_t *tuning);

/// The next attempt, from rest.
void lode_start_again(lode_start_t *self, const lode_start_tuning_t *tuning);

/// Once in LODE_SLOW_PERIODS: measures the part of the voltage along the current that is not EMF. True once, when
/// `found` is known.
bool lode_start_measure(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V,
                        lode_start_found_t *found);

/// Once in LODE_SLOW_PERIODS: whether the estimate is good enough to run on. While looking for a rotor
/// that is already turning, in either direction; later at hand-over speed, in the direction of the
/// vector. The last attempt requires less (S32).
void lode_start_judge(lode_start_t *self, const lode_start_tuning_t *tuning, float omega_rad_s,
                      float lock);

/// The estimate has been good for long enough.
bool lode_start_is_ready(const lode_start_t *self, const lode_start_tuning_t *tuning);

#ifdef __cplusplus
}
#endif

#endif
