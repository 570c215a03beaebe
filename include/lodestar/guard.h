/// Protection: decides in every control period whether the gates may stay on. The first cause is latched.
#ifndef LODESTAR_GUARD_H
#define LODESTAR_GUARD_H

#include "lodestar/estimator.h"
#include "lodestar/sense.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What has tripped. The comments say what lode_fault_t.measured is, and its unit; `limit` has the same unit unless
/// they say otherwise.
typedef enum {
    LODE_CHECK_NONE = 0,
    LODE_CHECK_HARDWARE_TRIP,    ///< trip reported by the power stage; measured 1, limit 0
    LODE_CHECK_OVER_CURRENT,     ///< phase current of either sign, A
    LODE_CHECK_CURRENT_RAIL,     ///< phase current, A: its ADC sample is at an end of the range
    LODE_CHECK_OVER_VOLTAGE,     ///< bus voltage, V
    LODE_CHECK_UNDER_VOLTAGE,    ///< bus voltage, V
    LODE_CHECK_OVER_TEMPERATURE, ///< power stage, degC
    LODE_CHECK_TIMING,           ///< change of the stamp between two calls, counts
    LODE_CHECK_NON_FINITE, ///< a duty outside [0, 1], or an external estimate that no motor can have
    LODE_CHECK_OVER_SPEED, ///< electrical speed, rad/s; negative: against the commanded direction
    LODE_CHECK_LOST_LOCK, ///< lock quality in RUN; with an angle sensor: the EMF contradicts the sensor
    /// electrical speed, rad/s; negative: against the commanded direction. In START the speed to which a load has
    /// turned the rotor; where that is known by the size of its EMF alone, positive
    LODE_CHECK_WRONG_WAY,
    LODE_CHECK_START, ///< no hand-over: measured value and limit of the criterion that was not met (start.h)
    /// deviation of a calibrated current offset from nominal, counts; before a start: current with the gates off, A
    LODE_CHECK_OFFSET,
    LODE_CHECK_OPEN_PHASE, ///< 1 .. 3: phase of set 1; 4 .. 6: phase of set 2; 7, 8: all of set 1, of set 2
    /// ADC channel that is stuck: 1 .. 3: phase of set 1; 4 .. 6: phase of set 2; 7, 8: all of set 1, of set 2; 0: all
    LODE_CHECK_CURRENT_STUCK,
    LODE_CHECK_CURRENT_SUM,       ///< sum of the three phase currents, A
    LODE_CHECK_UNDER_TEMPERATURE, ///< power stage, degC: the sensor is open or shorted
    LODE_CHECK_MEMORY,            ///< what was corrupted: lode_memory_t
    /// power stage, degC: its ADC count has not changed for the time `limit`, s
    LODE_CHECK_TEMPERATURE_STUCK,
    /// bus voltage, V: its ADC count has not changed for the time `limit`, s, although the EMF shows that the bus
    /// has
    LODE_CHECK_BUS_STUCK,
    /// flux linkage from the EMF, Wb, with a correct angle; limit: the motor's at this current, in START twice that
    LODE_CHECK_FLUX,
    LODE_CHECK_RESISTANCE, ///< resistance that the start has measured beyond the configured one, Ohm
    /// replaces a check of lode_guard_suspects() if a current flows on with the gates off: current of that phase, A.
    /// Negative: its low-side switch is shorted, positive: its high-side switch
    LODE_CHECK_SWITCH_SHORTED,
    /// before a start: current response along the applied voltage at the worst rotor angle, A; negative: it appears
    /// in another phase or with the wrong sign, or a current flows before the pulse
    LODE_CHECK_SIGNALS,
    /// before a start: inductance that voltage and current show, mean over all angles, H
    LODE_CHECK_INDUCTANCE,
    /// electrical speed that a load has reached against all the torque, or to which it has stopped the rotor, rad/s; limit: the
    /// speed reference
    LODE_CHECK_OVERLOAD,
    /// factor by which all currents changed at once without a voltage that explains it; limit: 1
    LODE_CHECK_CURRENT_GAIN,
    /// current across, against, or beyond i_max along its reference, A: current control has lost it
    LODE_CHECK_CURRENT_CONTROL,
    LODE_CHECK_COUNT
} lode_check_t;

/// What LODE_CHECK_MEMORY has found corrupted, as `measured`.
typedef enum {
    LODE_MEMORY_MODE = 1,      ///< the mode, or a flag or the direction that goes with it
    LODE_MEMORY_COMMAND,       ///< or its mailbox flag
    LODE_MEMORY_TUNING,        ///< a word of its structure
    LODE_MEMORY_ESTIMATE,      ///< its speed or load
    LODE_MEMORY_SPEED_CONTROL, ///< its integral or its ramped reference
    LODE_MEMORY_TORQUE_LIMIT,  ///< that of lode_drive_limit_torque(); it has to be set again
    LODE_MEMORY_START          ///< resistance or dead time that a start has measured
} lode_memory_t;

/// The enumerator's name, for logs.
const char *lode_check_name(lode_check_t check);

/// Limits of the guard. A field that is 0 gets the default from lode_guard_design().
typedef struct {
    float i_trip_A;             ///< phase current of either sign; trips at once; 0: 1.5 i_max
    float v_bus_max_V;          ///< 0: 1.25 times nominal
    float v_bus_min_V;          ///< 0: 0.6 times nominal
    float temperature_max_degC; ///< power stage; 0: 100
    /// ELECTRICAL speed; 0: 1.3 times estimator.omega_max_rad_s. Without injection at least the hand-over speed and
    /// speed.omega_min_rad_s
    float omega_max_rad_s;
    /// debounce time of bus, temperature and rail; 0: 1 ms. Bus and temperature are checked every 4 periods, and
    /// must be bad at least twice
    float bus_s;
    float lock_s; ///< debounce time of lost lock, wrong way and over-speed; 0: 15 ms
    /// counts of the free-running stamp per control period, 1 .. 1e9; 0: not monitored
    float stamp_per_period;
    /// power stage; 0: -40. Without a sensor sense.temperature_offset_degC must lie between both
    float temperature_min_degC;
    /// largest sum of the three phase currents, for the time lock_s; 0: 0.15 i_max; LODE_NONE: no limit
    float i_sum_A;
    /// plausibility checks of the currents, OVERLOAD and FLUX (plausibility.h); auto: on. A build with
    /// LODE_WITHOUT_PLAUSIBILITY has none; auto is then off
    lode_choice_t plausibility;
    /// with the gates on, noise alone must change the temperature's ADC count within this time; 0: not checked, as
    /// without a sensor
    float temperature_still_s;
    /// in RUN, while the EMF differs by more than a tenth from what the speed induces, the bus's ADC count must
    /// change within this time; 0: not checked
    float bus_still_s;
    /// in RUN with speed control: a load may move the speed against all the torque of i_max by as much as that
    /// torque would move it in this time, and by a twentieth of the reference (K19). It may hold the rotor below 3 %
    /// of rated speed for three times as long, or for the run-up time to rated speed if that is longer (K42). 0: 0.03;
    /// LODE_NONE: not checked
    float overload_s;
    /// FLUX: in RUN the observed flux may differ by this share of the magnets' flux, and by what wrong parameters
    /// explain (P25), 0.1 .. 1. 0: 0.2; LODE_NONE: not checked
    float flux_share;
    /// single checks of `plausibility`; auto: as that
    lode_choice_t check_stuck; ///< CURRENT_STUCK: counts that keep still, and a frozen vector (K36)
    lode_choice_t
        check_gain; ///< CURRENT_GAIN, CURRENT_STUCK: a current that changes at once by a factor (K38)
    lode_choice_t
        check_half_waves; ///< OPEN_PHASE with three phases: a phase without a half-wave (K24)
} lode_guard_config_t;

/// Limits and debounce counts derived from the configuration.
typedef struct {
    float i_trip;
    float v_bus_max;
    float v_bus_min;
    float temperature_max;
    float temperature_min;
    float omega_max;
    uint_least16_t bus_periods; ///< debounce of bus, temperature and rail, control periods
    /// debounce of lock and speed, calls of lode_guard_check_slow()
    uint_least16_t lock_checks;
    uint_least16_t
        still_rounds; ///< slow rounds in which the temperature's count must change; 0: not checked
    uint_least16_t bus_still_rounds; ///< the same for the bus
    uint32_t stamp_min;              ///< smallest change of the stamp between two calls
    /// largest minus smallest change of the stamp; 2^32 - 1 accepts any change: not monitored
    uint32_t stamp_span;
} lode_guard_tuning_t;

/// Cause of a fault.
typedef struct {
    uint_least8_t state; ///< lode_mode_t in which it occurred
    uint_least8_t check; ///< lode_check_t
    uint_least8_t stage; ///< START: lode_start_stage_t in which it occurred
    /// lode_criterion_t that a start has not met. With LODE_CHECK_NONE it is that of the last failed attempt: the
    /// start continues, or a later attempt was handed over
    uint_least8_t criterion;
    /// unit of the check; for LODE_CHECK_START and for a failed attempt, unit of the criterion
    float measured;
    float limit;
} lode_fault_t;

/// State of the guard. Debounce counters count up while a value is bad and down while it is good.
typedef struct {
    lode_fault_t fault;         ///< check == LODE_CHECK_NONE: no fault
    uint32_t stamp;             ///< stamp of the last call
    uint_least16_t bus;         ///< debounce counter of the bus voltage, calls
    uint_least16_t temperature; ///< debounce counter, calls
    uint_least16_t bus_still;   ///< rounds for which still_V has not changed
    uint_least16_t still_count; ///< ADC count of the temperature one round ago
    uint_least16_t still;       ///< rounds for which that count has not changed
    uint_least16_t rail;        ///< debounce counter of a sample at a rail, control periods
    uint_least16_t
        lock; ///< debounce counter of the lock; START: rounds with too large a flux (S34)
    uint_least16_t speed;       ///< debounce counter of speed and direction
    uint_least16_t flux_rounds; ///< RUN: rounds with a wrong flux although the lock holds
    uint_least16_t stopped; ///< checks of a lock being lost at which the rotor hardly turned (K45)
    uint_least16_t trips;   ///< faults since begin, modulo 65536
    float still_V;          ///< bus voltage one round ago
    bool railed;            ///< a sample was at a rail since the last lode_guard_check_slow()
    bool pending;           ///< a counter is not 0
    bool flux;              ///< while the lock counted as lost, only the size of the EMF was wrong
    bool fresh;             ///< the fault has been latched in this period
} lode_guard_t;

/// Search for a shorted switch, of one bridge, with the gates off.
typedef struct {
    uint_least16_t periods; ///< with too large a current of the same sign
    bool low;               ///< that sign: a low side
} lode_shorted_t;

/// What lode_guard_check_slow() needs to know about the drive.
typedef struct {
    uint_least8_t state; ///< lode_mode_t
    bool runs;           ///< RUN, by whatever angle
} lode_situation_t;

/// Quantities that change slowly.
typedef struct {
    float v_bus_V;
    float temperature_degC;
    float omega_rad_s; ///< estimated electrical speed, positive in the commanded direction
    float lock;
} lode_condition_t;

/// Clears fault and counters.
void lode_guard_reset(lode_guard_t *self);

/// Latches a fault, unless one is latched already.
void lode_guard_trip(lode_guard_t *self, uint_least8_t state, lode_check_t check, float measured,
                     float limit);

/// Control periods from one call of lode_guard_check_slow() to the next.
#define LODE_GUARD_PERIODS (LODE_SLOW_PERIODS / 2u)

/// Finds out what is wrong with a sample, and trips: trip input, stamp, phase current, rail. NaN counts as bad.
void lode_guard_diagnose(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                         const lode_sense_t *sense, const lode_sense_tuning_t *sense_tuning,
                         const lode_sample_t *sample, uint_least8_t state);

/// With the gates off after a trip: finds out whether a current flows on, which a healthy bridge would stop
/// (SWITCH_SHORTED). `half_turn`: of lode_guard_half_turn() where the line-to-line EMF is above the bus voltage, else 0:
/// the diodes of a healthy bridge then carry current too, but no phase carries it alone for longer than a sixth of a
/// turn. Not in a build with LODE_WITHOUT_PLAUSIBILITY.
void lode_guard_suspect(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                        const lode_sense_tuning_t *sense_tuning, const lode_sample_t *sample,
                        lode_shorted_t *shorted, uint32_t half_turn);

/// Control periods after a trip in which a current may still flow: it decays as fast as it rose in the two periods
/// that a command takes, and this is doubled.
#define LODE_GUARD_DECAY_PERIODS 4u

/// Half an electrical turn, in control periods; at most 32768. `step_rad`: rotation per period.
uint32_t lode_guard_half_turn(float step_rad);

/// Checks with a debounce time: bus, temperature, lock, speed and direction. Every LODE_GUARD_PERIODS.
void lode_guard_check_slow(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                           lode_condition_t condition, lode_situation_t now);

/// True if no fault is latched.
static inline bool lode_guard_is_good(const lode_guard_t *self) {
    return self->fault.check == (uint_least8_t)LODE_CHECK_NONE;
}

/// A shorted switch may be what made this check trip: more current than the drive has asked for.
static inline bool lode_guard_suspects(uint32_t check) {
    return check == (uint32_t)LODE_CHECK_HARDWARE_TRIP ||
           check == (uint32_t)LODE_CHECK_OVER_CURRENT ||
           check == (uint32_t)LODE_CHECK_CURRENT_RAIL || check == (uint32_t)LODE_CHECK_CURRENT_GAIN;
}

/// Fills every zero field that has a default.
void lode_guard_design(lode_guard_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_estimator_config_t *estimator);

/// Checks a completed configuration and derives the tuning. On any error `tuning` is left alone.
lode_status_t lode_guard_tune(lode_guard_tuning_t *tuning, const lode_guard_config_t *config,
                              const lode_inverter_config_t *inverter,
                              const lode_sense_config_t *sense, float ts_s);

#ifdef __cplusplus
}
#endif

#endif
