/// Plausibility checks of currents, switches and load (docs/theory/control.md): an ADC channel whose count does not change
/// although the current vector turns; three currents whose sum is not zero; a frozen current vector (K36); a current vector
/// that changes at once by a factor (K38); a phase without a half-wave (K24); a load beyond all the torque (K19); a flux
/// that is not that of the magnets (P25); a current that is not that of its reference (K49).
///
/// They run while the gates are on: counts and sums every LODE_GUARD_PERIODS, the others once in LODE_SLOW_PERIODS or when
/// there is a reason. In the following, the "reference" is the current reference.
#ifndef LODESTAR_PLAUSIBILITY_H
#define LODESTAR_PLAUSIBILITY_H

#include "lodestar/guard.h"
#include "lodestar/open_phase.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Limits of the checks.
typedef struct {
    float i_min_A2; ///< least reference, squared, at which an unchanged phase is judged
    int32_t
        i_still; ///< least current of a judged phase, 1/256 count; six phases: below it the phase may be open
    int32_t
        i_sum; ///< largest sum of the three currents, 1/256 count; below 0: no checks of the currents
    float per_wave_A; ///< least half-wave per ampere of reference, 1/256 count; 0: not checked
    /// largest movement of a frozen vector by noise, squared (K36); below 0: neither it nor the counts are checked
    float frozen_A2;
    float moves_A2;                 ///< least change of the reference for that check, squared
    lode_open_phase_tuning_t waves; ///< half-waves in RUN (K24)
    float away_rad_s; ///< electrical speed change that a load may cause; 0: not checked (K19)
    float
        away_step; ///< part of it that is allowed per LODE_SLOW_PERIODS while the rotor slows down
    float stall_rad_s; ///< a rotor slower than this under all the torque is stalled (K42)
    float taken_V;     ///< voltage that dead time and drops may take from a phase
    /// least jump of the current that is judged, as the voltage that would cause it in one period, squared (K38)
    float jump_V2;
    uint32_t stall_rounds; ///< looks after which that is a fault; 0: not checked
    float flux_share;      ///< of the magnets' flux, by which the observed one may be off (P25)
    float off_A2;          ///< largest distance of the current from its reference, squared (K49)
} lode_plausibility_tuning_t;

/// Half-wave check in START, where the vector is steady. In 1.1 turns of a vector of at least 2 sqrt(i_min_A2),
/// each of the three currents must have both half-waves. A phase that lacks the same half-wave in two such turns
/// running has a dead switch or is open. (In one turn alone a rotor that falls out of step may shift the currents.)
typedef struct {
    float turn_rad;        ///< electrical turn of the vector since the check began
    uint_least8_t seen;    ///< half-waves seen, one bit each: three positive, then three negative
    uint_least8_t lacking; ///< half-waves missing in the turn before
} lode_waves_t;

/// The measured current of a start's vector: a gain error makes it fall at once and come back at another voltage
/// (S43).
typedef struct {
    lode_dq_t e_V; ///< EMF along and across the vector before the fall
    float i_A2;    ///< current before the fall, squared
    uint_least8_t
        held; ///< rounds in which the current was at its reference, limited to what is needed
    uint_least8_t
        rounds; ///< rounds since the fall, from 2; 1: it fell at the last check; 0: no fall
} lode_drop_t;

/// State of the checks of counts and sum.
typedef struct {
    int32_t i[LODE_PHASES]; ///< phase currents at the last check, 1/256 count
    uint_least8_t kept;     ///< phases with the same count as at the check before, one bit each
    /// those that have kept it for the whole of turn_rad; one more bit: the current has changed meanwhile
    uint_least8_t still;
    uint_least16_t sum; ///< debounce counter of the sum: up while out of range, down while in range
    float turn_rad;     ///< electrical turn of the vector while they have kept their counts
    float i_A2;         ///< reference at the last check with an unchanged count, squared
    float moved_A2;     ///< total change of that square since any of the counts changed
} lode_plausibility_t;

/// Check for a current vector that moves by no more than noise although its reference changes (K36). Stator axes.
typedef struct {
    lode_ab_t i_A;   ///< where the current has stopped
    float moved_A2;  ///< square of its last move, to there
    lode_ab_t ref_A; ///< reference at the first check since then
    lode_ab_t way_A; ///< of the reference from there, at the last check; 0: it had hardly moved
    uint_least16_t
        checks; ///< checks since then, up to LODE_FROZEN_CHECKS; 0: it moves, `ref_A` is not valid
} lode_frozen_t;

#define LODE_FROZEN_CHECKS 0xffffu

/// Stage of the check for a current vector that changes at once by a factor (K38).
typedef enum {
    LODE_JUMP_NONE,
    LODE_JUMP_NEW,    ///< in the present sample
    LODE_JUMP_SECOND, ///< in the last sample; the present one decides whether it stays
    LODE_JUMP_GONE, ///< it stays and hardly any current is left: waits whether an open phase conducts again
    LODE_JUMP_RESTS ///< it did not stay; no checks for a while
} lode_jump_stage_t;

/// State of that check.
typedef struct {
    lode_ab_t innovation_V; ///< innovation of the EMF observer in the last period without a jump
    float change_V2;        ///< its change since then, turned with the rotor, squared
    float noise_V2;         ///< mean of change_V2: the noise of the currents (K39)
    uint_least8_t stage;    ///< lode_jump_stage_t
    uint_least8_t periods;  ///< periods in GONE and RESTS
    uint_least8_t factor;   ///< factor of the jump, in 1/LODE_JUMP_ONE
    uint_least8_t size;     ///< square of the jump over the square of the least one that is judged
} lode_jump_t;

#define LODE_JUMP_ONE 64u

/// State of the check for a load beyond all the torque (K19), (K42).
typedef struct {
    float held_rad_s;       ///< electrical speed from which the load has moved the rotor
    uint_least16_t faster;  ///< looks for which a braked rotor has become faster
    uint_least16_t stalled; ///< looks for which the rotor has not turned
} lode_load_t;

/// Result of a check. check == LODE_CHECK_NONE: nothing was found.
typedef struct {
    lode_check_t check;
    float measured;
    float limit;
} lode_finding_t;

/// Clears the checks of counts and sum.
void lode_plausibility_reset(lode_plausibility_t *self);

/// What may keep a phase current at zero.
typedef struct {
    float taken_V; ///< voltage taken by dead time and drops
    float x_Ohm;   ///< reactance at the speed of the vector
} lode_hold_t;

#define LODE_NONE_FOLLOWS 8u ///< bit above those of the three phases

/// Second part of a check of the counts. The first part (lode_plausibility_check() in plausibility_inline.h) has
/// found the phases `again`, a bit each, that have kept their count twice in a row. `turn_rad`: signed turn of the
/// vector since the last check. `i_A2`: reference squared, or the measured current squared if the voltage does not
/// suffice for the reference. `A_per_count`: amperes per 1/256 count. Returns a bit for each phase that has kept
/// its count over a turn that should have changed it, and LODE_NONE_FOLLOWS if all have kept theirs while the
/// reference changed.
uint32_t lode_plausibility_doubt(lode_plausibility_t *self,
                                 const lode_plausibility_tuning_t *tuning, uint32_t again,
                                 float i_A2, float turn_rad, float A_per_count);

/// Adds the `share` of what is needed for LODE_NONE_FOLLOWS, where another sign shows that all three counts should
/// have changed (S44). A count that changes clears it.
void lode_plausibility_add(lode_plausibility_t *self, const lode_plausibility_tuning_t *tuning,
                           float share);

/// Six phases, if no count of both sets has changed while the vector turned by `turn_rad` with the reference `i_A2`
/// (squared): true if some should have. Open phases cannot explain that.
bool lode_plausibility_none_flows(const lode_plausibility_tuning_t *tuning, float i_A2,
                                  float turn_rad, float A_per_count);

/// Third part of a check, if there is `doubt` or the sum is out of range: reports what only a fault explains.
/// `sum_checks`: debounce of the sum.
lode_finding_t lode_plausibility_find(lode_plausibility_t *self,
                                      const lode_plausibility_tuning_t *tuning, uint32_t doubt,
                                      uint32_t sum_checks, lode_hold_t hold, float A_per_count);

/// For a phase 1 .. 3 that was found stuck while all three are measured: true if it has no current and the other
/// two add up to zero. Then the phase is open, and the ADC channel healthy.
bool lode_plausibility_is_open(const lode_plausibility_t *self, uint32_t phase, float A_per_count);

/// One check of the half-waves in START. `turn_rad`: turn of the vector since the last check. `i_A2`: reference
/// squared. Returns the phase without a half-wave, 1 .. 3; 0: none found.
uint_least8_t lode_waves_step(lode_waves_t *self, const lode_plausibility_tuning_t *tuning,
                              const int32_t i[LODE_PHASES], float i_A2, float turn_rad);

/// Between two calls of lode_drop_step(): notes whether the current has fallen. `i_A2`: current squared.
void lode_drop_check(lode_drop_t *self, float i_A2);

/// Once in LODE_SLOW_PERIODS. `i_A2`, `ref_A2`: current and reference, squared; ref_A2 = 0: too small to judge.
/// `e_V`: EMF along and across the vector. True: the current fell some rounds ago and is back; `change_V` is then
/// the change of the EMF since before the fall.
bool lode_drop_step(lode_drop_t *self, float i_A2, float ref_A2, lode_dq_t e_V, float *change_V);

/// Once in LODE_SLOW_PERIODS, if the current has hardly moved (lode_frozen_moves() in plausibility_inline.h).
/// `ref_A`: present reference. True: the current has not followed its reference, so it is frozen if there is
/// voltage for the reference.
bool lode_frozen_check(lode_frozen_t *self, const lode_plausibility_tuning_t *tuning,
                       lode_ab_t ref_A);

/// After lode_frozen_check(): true if the reference has made a whole turn since the first check. `turn_rad`: its turn
/// per LODE_SLOW_PERIODS.
bool lode_frozen_turned(const lode_frozen_t *self, float turn_rad);

/// To be called if the current `i_A` is far from `expected_A`, which follows from the last current, voltage and
/// EMF. `size`: square of the distance over the square of the least one that is judged. `starts`: START, where an
/// increase does not count. True: this sample must not be used for the EMF.
bool lode_jump_check(lode_jump_t *self, lode_ab_t i_A, lode_ab_t expected_A, float size,
                     bool starts);

/// Once per control period in any stage but NONE, after lode_jump_check() if that was called. Returns the factor
/// once it is confirmed; below 0: none. `turn_rad`: turn of the vector per period. `gone`: hardly any current is
/// left.
float lode_jump_wait(lode_jump_t *self, float turn_rad, bool gone);

/// Checks `config`, completed by lode_guard_design(), and derives the tuning except for what the next two functions
/// set.
lode_status_t lode_plausibility_tune(lode_plausibility_tuning_t *tuning,
                                     const lode_guard_config_t *config, float i_max_A,
                                     const lode_sense_tuning_t *sense);

/// Sets the limits of a load in RUN (K19). `rise_rad_s2`: electrical acceleration of a free rotor by all the torque
/// of i_max; `omega_rated_rad_s`: rated electrical speed. Call lode_plausibility_tune() first; it overwrites the whole tuning.
lode_status_t lode_plausibility_tune_load(lode_plausibility_tuning_t *tuning,
                                          const lode_guard_config_t *config, float rise_rad_s2,
                                          float omega_rated_rad_s, float ts_s);

/// Sets the limits that depend on voltages. `i_max_V`: voltage that would change the current by `i_max_A` in one period
/// (K38), (K49). `taken_V`: what dead time and drops may take from a phase.
void lode_plausibility_tune_voltages(lode_plausibility_tuning_t *tuning,
                                     const lode_guard_config_t *config, float i_max_A,
                                     float i_max_V, float taken_V);

/// Once in LODE_SLOW_PERIODS, while all the torque is requested in the direction `sense` (1 or -1): true if a load
/// has moved the electrical speed `omega_rad_s` against it by more than is allowed (K19), (K29). While less is
/// requested, the caller keeps `self` at the present speed.
bool lode_load_is_too_large(lode_load_t *self, const lode_plausibility_tuning_t *tuning,
                            float sense, float omega_rad_s);

/// Once in LODE_SLOW_PERIODS, while all the torque is requested: true if the rotor has hardly turned for too long
/// although it should, `missing_rad_s` faster in the direction of the torque (K42). While less is requested, the
/// caller resets `self`.
bool lode_load_stalls(lode_load_t *self, const lode_plausibility_tuning_t *tuning,
                      float omega_rad_s, float missing_rad_s);

#ifdef __cplusplus
}
#endif

#endif
