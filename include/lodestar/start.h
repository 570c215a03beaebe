/// I-f start (open-loop current-vector start): a current vector rises and turns open loop until the estimator has
/// locked on and takes over (paper 1, Section 5, after its reference 33). docs/theory/start.md.
#ifndef LODESTAR_START_H
#define LODESTAR_START_H

#include "lodestar/estimator.h"
#include "lodestar/inverter.h"
#include "lodestar/plausibility.h"
#include "lodestar/references.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Configuration of the start. A field that is 0 is computed by lode_start_design().
typedef struct {
    /// amplitude of the vector; 0: 0.7 i_max, at most psi/(2 (Lq - Ld))
    float current_A;
    /// amplitude in the last attempt, current_A .. i_max; 0: current_A if that is given, otherwise twice its
    /// default, within 0.7 .. 1 i_max. If it is more than 1.5 current_A, the attempt after a slip has it too (S42)
    float current_last_A;
    /// ELECTRICAL speed of the hand-over; 0: 0.1 of rated (150 of 1500 rpm). The default is higher, up to 0.5 of
    /// rated or base speed, if 1 us of dead time and 30 % of R could amount to more than half of the EMF (S12), or
    /// if a load step would stop a light salient rotor (S18), or if Lq i_max is more than 1.25 psi (S52). It is at
    /// least the speed at which the EMF is a quarter of the drop across R
    float omega_handover_rad_s;
    /// ELECTRICAL acceleration in the first attempt; 0: that of a tenth of the start torque on the inertia, with a
    /// sixteenth of it at rest (S35). A configured ramp applies in full from rest on
    float ramp_rad_s2;
    /// time in which the current rises to current_A; 0: 0.2, up to 0.4 for a heavy rotor without saliency (S29)
    float current_rise_s;
    float damping; ///< damping ratio of the rotor's swing about the vector; 0: 0.5; LODE_NONE: none
    /// time for which the lock must hold before the hand-over; 0: 0.1, for a salient rotor from 0.05 on (S26)
    float lock_s;
    /// additional time for which the vector stands at its axis with all of its current before it turns, in the
    /// first attempt of a start from rest (S47); 0: none
    float align_s;
    /// time at zero current in which the estimator looks for a turning rotor; 0: 0.05; LODE_NONE: none
    float catch_s;
    float timeout_s; ///< from the start to the hand-over, over all attempts; 0: three attempts (S9)
    /// measure resistance and dead time beyond the configured ones at standstill, from the voltages at half and at
    /// all of the start current (S13); auto: on
    lode_choice_t measure;
    /// flying start: short zero vectors find a rotor that is already turning (fly.h); auto: on. Off for a board
    /// that measures no current with the low sides alone (one shunt in the DC link) or cannot switch them alone
    lode_choice_t pulses;
    /// check of bridge and sensors by short voltage pulses before the first attempt (signal_check.h); auto: on
    /// where possible, but off if `pulses` or `catch_s` is off
    lode_choice_t signal_check;
    /// fade from the start current to the references after the hand-over; 0: 0.1, for a salient rotor 0.05
    float fade_s;
} lode_start_config_t;

/// All that is derived from the configuration. "Rounds" are units of LODE_SLOW_PERIODS control periods, speeds are
/// electrical.
typedef struct {
    float current_A;      ///< amplitude of the vector
    float current_step;   ///< slope of the current, A per period
    float omega_handover; ///< speed up to which the vector turns, rad/s
    float omega_ready;    ///< speed from which the estimator may take over, at most omega_handover
    /// sweep per period while the current rises; with a measurement from half of the current on
    float sweep_step_rad;
    float omega_step; ///< largest change of the vector's speed, rad/s per period
    /// share of omega_step in use = steepens times (speed + omega_handover/64), s/rad (S35)
    float steepens;
    float damping;   ///< angle by which the vector gives way, rad per V of swinging EMF, at most
    float damping_A; ///< upper limit of `damping` times the current (S15)
    float damping_rad_s;         ///< upper limit of `damping` times the speed (S16)
    float lost_per_A;            ///< share of the flux that the start current takes away, per A
    float mean_weight;           ///< weight of a new sample in the mean EMF (S5)
    float swing_weight;          ///< weight of a new sample in the swing (S5)
    float fade_step;             ///< change of lode_running_t.fade per call of the references
    uint_least16_t catch_rounds; ///< times in rounds, as all below
    uint_least16_t lock_rounds;
    float current_last_A; ///< amplitude in the last attempt
    float still_rounds;   ///< current rise, measurement, gentle part of the ramp, and lock
    float align_rounds; ///< alignment: vector standing with all of its current, first attempt only
    uint32_t timeout_rounds;
    uint_least16_t patience_rounds; ///< least wait for the lock after the profile
    /// longest wait of the vector for one mean voltage; 0: no measurement
    uint_least16_t dwell_rounds;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    /// speed to which the vector turns without a lock, rad/s per V of lode_jump_t's noise (S49)
    float omega_per_noise;
    float omega_most; ///< upper limit of that speed, rad/s
#endif
#ifndef LODE_WITHOUT_START_MEASUREMENT
    float R_Ohm;  ///< configured resistance of winding and switch, which adaptation leaves alone
    float calm_V; ///< EMF across the vector below which the rotor counts as at rest
    /// how well resistance and dead time are known without a measurement (S33): calm_V over the standard deviation of
    /// their voltages at the start current, squared
    float r_known;
    float dead_known;
#endif
} lode_start_tuning_t;

/// Result of the measurement at standstill (S13), (S33).
typedef struct {
    float r_Ohm;  ///< resistance beyond the one that is accounted for
    float dead_V; ///< voltage along the current that does not depend on its amplitude
} lode_start_found_t;

/// Values of lode_start_t.stage.
typedef enum {
    LODE_START_NONE,  ///< no start is under way
    LODE_START_CATCH, ///< zero current: the estimator looks for a rotor that is already turning
    LODE_START_HALF,  ///< measurement at rest with half of the current
    LODE_START_FULL,  ///< the same with all of it
    LODE_START_ALONE, ///< the same with all of it, after half of it gave no result
    LODE_START_FOUND, ///< the result of the measurement is computed
    LODE_START_ALIGN, ///< the vector stands for align_s (S47)
    LODE_START_TURN   ///< the vector turns once it has its current
} lode_start_stage_t;

/// The enumerator's name, for logs.
const char *lode_start_stage_name(lode_start_stage_t stage);

/// Criteria of the hand-over, in the order in which they are checked up to HOLD. A failed attempt reports the first one
/// that was not met, with the measured value and the limit.
typedef enum {
    LODE_CRITERION_NONE,    ///< no attempt has failed
    LODE_CRITERION_CURRENT, ///< the vector has all of its current, A
    LODE_CRITERION_REST, ///< the rotor has been at rest for long enough while the vector waited, s
    LODE_CRITERION_RAMP, ///< the vector has reached speed: electrical, rad/s
    /// the EMF is as large as that of a rotor that follows the vector; the current may take its share of the flux
    /// (S39), V
    LODE_CRITERION_EMF,
    LODE_CRITERION_SPEED, ///< the estimated speed agrees with that of the vector: electrical, rad/s
    LODE_CRITERION_FLUX, ///< share of the flux that the d current takes away is at most LODE_START_LOST_MAX
    LODE_CRITERION_LOCK,  ///< lock quality
    LODE_CRITERION_HOLD,  ///< speed, flux and lock have been right for long enough, s
    LODE_CRITERION_PROOF, ///< lock quality within 0.4 s after the hand-over (S28)
    LODE_CRITERION_POLARITY, ///< injection has found the polarity of the magnets; measured: lock quality
    /// no phase seemed open within 0.4 s after the hand-over (S28); measured: the number of the one that did
    LODE_CRITERION_OPEN_PHASE,
    LODE_CRITERION_COUNT
} lode_criterion_t;

/// The enumerator's name, for logs.
const char *lode_criterion_name(lode_criterion_t criterion);

/// A criterion that was not met.
typedef struct {
    lode_criterion_t criterion;
    float measured; ///< in the unit of the criterion
    float limit;    ///< in the same unit
} lode_start_unmet_t;

/// State while the vector stands.
typedef struct {
    float sum_V;  ///< sum of the voltages along the axis at which the vector waits
    float summed; ///< number of values in the sum
    float weight; ///< weight of their mean (S33)
    float half_V; ///< mean at half of the current
    float half_weight;
    /// rounds at the present current; in ALIGN with all of the current
    uint_least16_t dwelt;
    uint_least16_t calm; ///< number of those values without voltage across the vector
} lode_start_rest_t;

/// State while the vector turns.
typedef struct {
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_waves_t waves; ///< half-waves of the three phases
#endif
    /// angle by which the vector was shifted ahead when the counts of a set were last in doubt; three phases: the first
    float shift_rad[2];
} lode_start_turn_t;

/// State of a start. Angles and speeds are electrical.
typedef struct {
    lode_sincos_t at;     ///< angle of the current vector without the shift by the damping
    float omega_rad_s;    ///< its speed
    float left_rad_s;     ///< what rounding has left out of it (K35)
    float current_A;      ///< its amplitude
    float omega_target;   ///< speed that it approaches
    float omega_step;     ///< change of speed per period
    float current_target; ///< amplitude that it approaches
    float mean_V;         ///< mean EMF across the vector (S5)
    float swing_V;        ///< deviation from that mean: the rotor's swing, which is damped (S5)
    uint32_t attempt; ///< rounds of the present attempt; in LODE_START_CATCH: rounds that are left
    union {
        lode_start_rest_t rest; ///< stages before LODE_START_TURN
        lode_start_turn_t turn; ///< LODE_START_TURN
    } seen;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_drop_t drop; ///< fall of the current in the present stage (S43)
#endif
    float by_size; ///< weight of the EMF's size in the swing, with the sign of the speed (S19)
    float give;    ///< angle by which the vector gives way, rad per V of swinging EMF
    uint_least16_t locked; ///< rounds for which the lock has held
    /// rounds at speed without the EMF of a rotor that follows, minus rounds with it (S42)
    uint_least16_t slips;
    uint_least8_t stage;  ///< LODE_START_...
    uint_least8_t failed; ///< failed attempts, up to three
    uint_least8_t
        stands;         ///< 1: the vector stands ahead of the rotor's axis and does not sweep (S40)
    uint_least8_t more; ///< 1: this attempt already has the current of the last one (S42)
} lode_start_t;

/// Share of omega_ready below which the inverter's errors hide the EMF; the estimator is held to the vector there.
#define LODE_START_HOLD 0.5f
/// Lock quality from which the estimator may take over. Well above LODE_LOCK_LOST.
#define LODE_LOCK_HANDOVER 0.7f
/// Share of psi that the d current may take away at hand-over (S8). With less flux left, speed control and PLL excite
/// each other before the start current has faded.
#define LODE_START_LOST_MAX 0.4f
/// Largest shift of the vector by the damping (S31). At 30 degrees from the phase axis at which the vector waits, a
/// phase current changes its sign, and with it the unknown part of the dead-time voltage.
#define LODE_START_SHIFT_MAX_rad 0.42f

/// True if the EMF exceeds the errors of the drop across the resistance at a speed at which a hand-over is
/// possible, up to half of rated and base speed (S27). False: how well starts and low speeds work depends on how exactly
/// current sensors and resistance are known. `config` has been completed by lode_start_design().
bool lode_start_has_emf(const lode_start_config_t *config, const lode_inverter_config_t *inverter,
                        const lode_motor_t *motor);

/// Fills every zero field that has a default.
void lode_start_design(lode_start_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_motor_t *motor, float ts_s);

/// Checks a completed configuration and derives the tuning. On any error `tuning` is left alone.
lode_status_t lode_start_tune(lode_start_tuning_t *tuning, const lode_start_config_t *config,
                              const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                              float omega_max_rad_s, float ts_s);

/// Sets the vector to the angle `at`, the electrical speed `omega_rad_s` and the amplitude `current_A`: zero
/// current for a start from standstill, the motor's own current for the way back from sensorless RUN.
void lode_start_reset(lode_start_t *self, lode_sincos_t at, float omega_rad_s, float current_A);

/// After lode_start_reset() to a speed: the damping begins with the rotor's EMF `e_V`, in stator axes, as the mean that it
/// removes (S56). With none, all of the EMF would count as a swing.
void lode_start_settle(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V);

/// Begins a start from rest, with zero current for catch_s first: the voltage that this takes is the EMF of a rotor
/// that is already turning.
void lode_start_begin(lode_start_t *self, const lode_start_tuning_t *tuning);

/// After lode_start_begin(), if a phase `axis` next to the rotor's d axis, or to its opposite, is known: the vector
/// stands ahead of it in the commanded `direction` while the current of the first attempt rises (S40).
void lode_start_lead(lode_start_t *self, lode_sincos_t axis, float direction);

/// The part of the waiting time that has passed, 0 .. 1. The waiting time of an attempt for its lock begins after
/// its profile.
float lode_start_waited(const lode_start_t *self, const lode_start_tuning_t *tuning);

/// Sets the electrical speed and the amplitude that the vector approaches. To be called once in LODE_SLOW_PERIODS
/// even if they do not change, because it counts the time of the attempt. True: the attempt has failed, as its time
/// is over (S9) or the rotor has slipped for too long (S42).
bool lode_start_aim(lode_start_t *self, const lode_start_tuning_t *tuning, float omega_target_rad_s,
                    float current_A);

/// The first criterion that the attempt does not meet at present.
lode_start_unmet_t lode_start_unmet(const lode_start_t *self, const lode_start_tuning_t *tuning,
                                    const lode_estimator_t *estimator,
                                    const lode_estimator_tuning_t *estimator_tuning);

/// Notes whether the EMF is that of a rotor that follows the vector; if it is not for too long, the attempt fails
/// (S42). Once in LODE_SLOW_PERIODS.
void lode_start_note_slip(lode_start_t *self, const lode_start_tuning_t *tuning,
                          const lode_estimator_t *estimator,
                          const lode_estimator_tuning_t *estimator_tuning);

/// True if the attempt that has failed was the last one and the rotor slipped: a further attempt like it would not
/// help.
bool lode_start_is_lost(const lode_start_t *self, const lode_start_tuning_t *tuning);

/// Begins the next attempt, from rest.
void lode_start_again(lode_start_t *self, const lode_start_tuning_t *tuning);

/// Measures the voltage along the current that is not EMF. Once in LODE_SLOW_PERIODS. True once, when `found` holds
/// the result.
bool lode_start_measure(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V,
                        lode_start_found_t *found);

/// Counts the rounds in which the estimate is good enough for RUN. Once in LODE_SLOW_PERIODS. In LODE_START_CATCH
/// either direction counts, later only a speed close to that of the vector. The last attempt accepts less (S32).
void lode_start_judge(lode_start_t *self, const lode_start_tuning_t *tuning, float omega_rad_s,
                      float lock);

/// True if the estimate has been good enough for long enough.
bool lode_start_is_ready(const lode_start_t *self, const lode_start_tuning_t *tuning);

#ifdef __cplusplus
}
#endif

#endif
