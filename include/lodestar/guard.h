/// Protection: decides in every period whether the gates may stay on. The first fault is latched.
#ifndef LODESTAR_GUARD_H
#define LODESTAR_GUARD_H

#include "lodestar/estimator.h"
#include "lodestar/sense.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LODE_CHECK_NONE = 0,
    LODE_CHECK_HARDWARE_TRIP,    ///< the power stage reported a trip (1, limit 0)
    LODE_CHECK_OVER_CURRENT,     ///< a phase current, A, of either sign
    LODE_CHECK_CURRENT_RAIL,     ///< a current sample at an end of the ADC's range, A
    LODE_CHECK_OVER_VOLTAGE,     ///< bus, V
    LODE_CHECK_UNDER_VOLTAGE,    ///< bus, V
    LODE_CHECK_OVER_TEMPERATURE, ///< power stage, degC
    LODE_CHECK_TIMING,           ///< stamp between two calls, counts
    LODE_CHECK_NON_FINITE, ///< a duty outside [0, 1], or an external estimate that is not finite
    LODE_CHECK_OVER_SPEED, ///< electrical, rad/s
    LODE_CHECK_LOST_LOCK,  ///< lock quality in RUN; with a sensor: the EMF contradicts it
    LODE_CHECK_WRONG_WAY,  ///< electrical speed against the commanded direction, rad/s
    LODE_CHECK_START,      ///< no hand-over before the time-out: value of the criterion (start.h)
    LODE_CHECK_OFFSET,     ///< deviation of a calibrated current offset, counts
    LODE_CHECK_OPEN_PHASE, ///< 1 .. 3: phase of set 1, 4 .. 6: of set 2, 7, 8: a whole set
    LODE_CHECK_CURRENT_STUCK, ///< 1 .. 3, 4 .. 6: phase of set 1, 2 whose ADC channel is stuck; 0: all three
    LODE_CHECK_CURRENT_SUM,       ///< sum of the three phase currents, A
    LODE_CHECK_UNDER_TEMPERATURE, ///< power stage, degC: sensor open or shorted
    LODE_CHECK_MEMORY,            ///< what was corrupted: 1 the mode, 2 the command, 3 the tuning
    LODE_CHECK_TEMPERATURE_STUCK, ///< power stage, degC: the count has not moved; the limit is the time, s
    LODE_CHECK_BUS_STUCK, ///< bus, V: the count has not moved though the EMF says the bus has; the limit is the time, s
    LODE_CHECK_FLUX, ///< flux linkage by the EMF, Wb, with a sound angle; the limit is the motor's, in START twice that
    LODE_CHECK_RESISTANCE, ///< what the start has measured above the configured one, Ohm
    /// after HARDWARE_TRIP or OVER_CURRENT, in its place: the current that keeps flowing in one phase with the gates
    /// off, A; negative: its low side is shorted, positive: its high side
    LODE_CHECK_SWITCH_SHORTED,
    /// before a start: current that follows its voltage at the worst rotor angle, A; negative: another phase, or the wrong way
    LODE_CHECK_SIGNALS,
    LODE_CHECK_INDUCTANCE, ///< before a start: inductance from voltage and current, mean over all angles, H
    LODE_CHECK_OVERLOAD, ///< electrical speed, moved by the load against all the torque, rad/s; the limit is the one asked for
    LODE_CHECK_CURRENT_GAIN, ///< factor by which all currents changed at once, without a voltage to explain it; the limit is 1
    LODE_CHECK_COUNT
} lode_check_t;

/// The enumerator's name, for logs.
const char *lode_check_name(lode_check_t check);

typedef struct {
    float i_trip_A;             ///< phase current, either sign, at once; 0: 1.5 i_max
    float v_bus_max_V;          ///< 0: 1.25 times nominal
    float v_bus_min_V;          ///< 0: 0.6 times nominal
    float temperature_max_degC; ///< 0: 100
    float omega_max_rad_s;      ///< electrical; 0: 1.3 times the estimator's
    /// debounce of bus, temperature and rail; 0: 1 ms. Checked every 4 periods, at least twice
    float bus_s;
    float lock_s;               ///< the same for lost lock, wrong way and over-speed; 0: 15 ms
    float stamp_per_period;     ///< counts of the free-running stamp per period; 0: not watched
    float temperature_min_degC; ///< 0: -40
    float
        i_sum_A; ///< sum of the three phase currents, for lock_s; 0: 0.15 i_max; LODE_NONE: not checked
    /// checks of the currents (plausibility.h); auto: on, but off in a build with LODE_WITHOUT_PLAUSIBILITY, which
    /// does not have them
    lode_choice_t plausibility;
    /// with the gates on, the temperature count must change within this time, if only by noise; 0: it need not
    float temperature_still_s;
    /// in RUN, while the EMF differs by more than a tenth from what the speed induces, the bus count must change within
    /// this time; 0: it need not
    float bus_still_s;
    /// in RUN, with speed control, while all the torque of i_max is asked for: a load may move the speed against it by as
    /// much as that torque would in this time, and by a twentieth; 0: 0.03; LODE_NONE: by any amount
    float overload_s;
} lode_guard_config_t;

typedef struct {
    float i_trip;
    float v_bus_max;
    float v_bus_min;
    float temperature_max;
    float temperature_min;
    float omega_max;
    uint_least16_t bus_periods; ///< of bus, temperature and rail
    uint_least16_t
        lock_looks; ///< of lode_guard_check_slow(), which is called every LODE_GUARD_PERIODS
    uint_least16_t
        still_rounds; ///< of slow jobs within which the temperature count must move; 0: not checked
    uint_least16_t bus_still_rounds; ///< the same for the bus
    uint32_t stamp_min;
    /// largest minus smallest count between two calls; 2^32 - 1, which every count meets: not watched
    uint32_t stamp_span;
} lode_guard_tuning_t;

typedef struct {
    uint_least8_t state; ///< lode_mode_t in which it occurred
    uint_least8_t check; ///< lode_check_t
    uint_least8_t stage; ///< in START: lode_start_stage_t in which it occurred
    /// lode_criterion_t that a start did not meet; with LODE_CHECK_NONE that of its last failed attempt: the start continues, or
    /// another attempt succeeded
    uint_least8_t criterion;
    float
        measured; ///< in the unit of the check; for LODE_CHECK_START and for an attempt in that of the criterion
    float limit;
} lode_fault_t;

typedef struct {
    lode_fault_t fault; ///< check == LODE_CHECK_NONE: none
    uint32_t stamp;     ///< of the last call
    uint_least16_t bus; ///< debounce counters: up while out of range, down while in range
    uint_least16_t temperature;
    uint_least16_t bus_still;   ///< rounds for which still_V has been the same
    uint_least16_t still_count; ///< of the temperature, one round before
    uint_least16_t still;       ///< rounds for which it has been the same
    uint_least16_t rail;
    uint_least16_t lock;       ///< in START: rounds with an EMF of too large a flux
    uint_least16_t speed;      ///< and its direction
    float still_V;             ///< bus, one round before
    bool railed;               ///< a sample was at a rail since the last lode_guard_check_slow()
    bool pending;              ///< some counter is not 0
    uint_least8_t flux_rounds; ///< in RUN: rounds with a wrong flux but without a lost lock
    bool flux; ///< while the lock counted as lost, only the EMF's magnitude was wrong
} lode_guard_t;

/// What the guard needs to know of the drive.
typedef struct {
    uint_least8_t state; ///< lode_mode_t
    bool sensorless;     ///< the estimator drives the motor
} lode_situation_t;

/// What changes slowly.
typedef struct {
    float v_bus_V;
    float temperature_degC;
    float omega_rad_s; ///< estimated electrical speed, counted in the commanded sense of rotation
    float lock;
} lode_condition_t;

/// No fault, all counters 0.
void lode_guard_reset(lode_guard_t *self);

/// Latches a fault unless one is already latched.
void lode_guard_trip(lode_guard_t *self, uint_least8_t state, lode_check_t check, float measured,
                     float limit);

#define LODE_GUARD_PERIODS (LODE_SLOW_PERIODS / 2u)

/// Finds out what is wrong with a sample, and trips. NaN fails every comparison.
void lode_guard_diagnose(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                         const lode_sense_t *sense, const lode_sense_tuning_t *sense_tuning,
                         const lode_sample_t *sample, uint_least8_t state);

/// With the gates off after a trip: finds out whether the current keeps flowing, as it does not in a sound bridge. Not
/// in a build with LODE_WITHOUT_PLAUSIBILITY.
void lode_guard_suspect(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                        const lode_sense_tuning_t *sense_tuning, const lode_sample_t *sample);

/// Periods after a trip for which the current may keep flowing: it falls as fast as it rose, in the two periods that
/// a command takes, and as long again.
#define LODE_GUARD_DECAY_PERIODS 4u

/// Debounced checks, every LODE_GUARD_PERIODS: bus, temperature, lock, speed,
/// direction.
void lode_guard_check_slow(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                           lode_condition_t condition, lode_situation_t now);

static inline bool lode_guard_is_good(const lode_guard_t *self) {
    return self->fault.check == (uint_least8_t)LODE_CHECK_NONE;
}

void lode_guard_design(lode_guard_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_estimator_config_t *estimator);

lode_status_t lode_guard_tune(lode_guard_tuning_t *tuning, const lode_guard_config_t *config,
                              const lode_inverter_config_t *inverter,
                              const lode_sense_config_t *sense, float ts_s);

#ifdef __cplusplus
}
#endif

#endif
