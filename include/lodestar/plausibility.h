/// Checks currents, switches and load for consistency, docs/theory/control.md: an ADC channel that keeps its count
/// although the current vector turns, three currents whose sum is not zero, a current vector that is frozen (K36) or changes
/// at once by a factor (K38), a phase without a half-wave (K24), a load beyond all the torque (K19), a flux that is not the
/// magnets' (P26).
///
/// While the gates are on: counts and sums every LODE_GUARD_PERIODS, the rest once in LODE_SLOW_PERIODS or on an event.
#ifndef LODESTAR_PLAUSIBILITY_H
#define LODESTAR_PLAUSIBILITY_H

#include "lodestar/guard.h"
#include "lodestar/open_phase.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float i_min_A2;   ///< least current, squared, at which a phase with a constant count is judged
    int32_t i_still;  ///< 1/256 count: a phase with less is not judged; six phases: it may be open
    int32_t i_sum;    ///< largest sum of the three, 1/256 count; below 0: nothing is checked
    float per_wave_A; ///< least half-wave per ampere asked for, 1/256 count; 0: not checked
    float
        frozen_A2; ///< by how much noise may move a frozen current vector, squared; below 0: not checked
    float moves_A2; ///< by how much its reference has to move to tell that it is frozen, squared
    lode_open_phase_tuning_t waves; ///< of RUN
    float away_rad_s; ///< electrical, by which a load may move the speed; 0: not checked
    float away_step;  ///< share of that in each LODE_SLOW_PERIODS while the rotor slows down
    float taken_V; ///< voltage that dead time and drops take of a phase at the zero of its current
    float
        jump_V2; ///< voltage that a change of current in a period must correspond to before it is checked, squared (K38)
} lode_plausibility_tuning_t;

/// Both half-waves of each of three currents, over a turn and a tenth of a vector that is twice as large: a phase
/// that lacks the same one twice in a row has a dead switch, or is open. (Once is not enough: a rotor that falls out
/// of step may shift the currents for a turn.) In START, where the vector is steady.
typedef struct {
    float turn_rad;        ///< electrical, of the vector, since it began
    uint_least8_t seen;    ///< half-waves, a bit each: three positive ones, three negative ones
    uint_least8_t lacking; ///< those that the turn before did not have
} lode_waves_t;

/// The measured current of a start's vector: whether it falls at once, and comes back at another voltage (S43).
typedef struct {
    lode_dq_t e_V;        ///< EMF along and across the vector before it fell
    float i_A2;           ///< the current then, squared
    uint_least8_t held;   ///< rounds in which it was as asked for, until they are enough
    uint_least8_t rounds; ///< since it fell, from 2; 1: it fell at the last look; 0: it has not
} lode_drop_t;

typedef struct {
    int32_t i[LODE_PHASES]; ///< at the last look, 1/256 count
    uint_least8_t kept;     ///< phases that had the same count at the look before, a bit each
    uint_least8_t
        still; ///< of these, those that have kept it for the whole of turn_rad; a bit for a changing current
    uint_least16_t sum; ///< debounce: up while out of range, down while in range
    float turn_rad;     ///< electrical
    float i_A2;         ///< current asked for at the last look at which a count was kept, squared
    float moved_A2;     ///< by how much that has moved since any of the counts changed
} lode_plausibility_t;

/// A current vector that stands still, except for noise, while another one is asked for (K36). In stator axes.
typedef struct {
    lode_ab_t i_A;        ///< from which it has not moved
    lode_ab_t asked_A;    ///< asked for at the first look since
    uint_least16_t looks; ///< since, up to LODE_FROZEN_LOOKS; 0: it moves, `asked_A` is not known
    bool moved;           ///< at the last look what is asked for had moved by enough
} lode_frozen_t;

#define LODE_FROZEN_LOOKS 0xffffu

/// A current vector that changes at once by a factor (K38).
typedef enum {
    LODE_JUMP_NONE,
    LODE_JUMP_NEW,    ///< in the present sample
    LODE_JUMP_SECOND, ///< in the previous one: the present one decides whether it persists
    LODE_JUMP_GONE,   ///< it persists, and no current is left: waits for an open phase to come back
    LODE_JUMP_RESTS   ///< it did not persist: nothing is checked for a while
} lode_jump_stage_t;

typedef struct {
    lode_ab_t innovation_V; ///< of the EMF observer in the last period without a jump
    float change_V2;        ///< by which it has changed since, turned with the rotor, squared
    float noise_V2;         ///< mean of that: effect of the current noise (K39)
    uint_least8_t stage;    ///< lode_jump_stage_t
    uint_least8_t periods;  ///< spent in GONE and RESTS
    uint_least8_t factor;   ///< in 1/LODE_JUMP_ONE
    uint_least8_t size;     ///< squared, relative to the least that is checked
} lode_jump_t;

#define LODE_JUMP_ONE 64u

/// How a load moves the rotor against all the torque (K19).
typedef struct {
    float held_rad_s;      ///< electrical speed from which it moves the rotor
    uint_least16_t faster; ///< looks since it began to accelerate a rotor that is being braked
} lode_load_t;

/// What was found; check == LODE_CHECK_NONE: nothing.
typedef struct {
    lode_check_t check;
    float measured;
    float limit;
} lode_finding_t;

/// Nothing seen yet.
void lode_plausibility_reset(lode_plausibility_t *self);

/// What may hold a phase current at zero.
typedef struct {
    float taken_V; ///< by dead time and drops
    float x_Ohm;   ///< reactance at the speed at which the vector turns
} lode_hold_t;

#define LODE_NONE_FOLLOWS 8u ///< in addition to a bit for each phase

/// The second part of a look, where the first (lode_plausibility_look() in plausibility_inline.h) found the phases
/// `again` that kept their count twice in a row, a bit each; the vector has turned by `turn_rad` since the last look,
/// with its sign. `i_A2`: the square of the current that is asked for, or of the measured one where the voltage does not
/// suffice. `A_per_count`: per 1/256 count. Returns a bit for each phase that has kept its count over a
/// turn that should have moved it, and LODE_NONE_FOLLOWS where all kept theirs while the current asked for changed.
uint32_t lode_plausibility_doubt(lode_plausibility_t *self,
                                 const lode_plausibility_tuning_t *tuning, uint32_t again,
                                 float i_A2, float turn_rad, float A_per_count);

/// Where something else shows that all three should have moved: counts `share` of what is enough for LODE_NONE_FOLLOWS,
/// until one of them moves.
void lode_plausibility_add(lode_plausibility_t *self, const lode_plausibility_tuning_t *tuning,
                           float share);

/// No count of two sets has moved while the vector turned by `turn_rad`, though the current asked for, `i_A2` squared,
/// would have moved some: no open phase explains that.
bool lode_plausibility_none_flows(const lode_plausibility_tuning_t *tuning, float i_A2,
                                  float turn_rad, float A_per_count);

/// The third part, where there is `doubt` or the sum is not good: what only a fault explains. `sum_looks`: debounce
/// of the sum.
lode_finding_t lode_plausibility_find(lode_plausibility_t *self,
                                      const lode_plausibility_tuning_t *tuning, uint32_t doubt,
                                      uint32_t sum_looks, lode_hold_t hold, float A_per_count);

/// For a `phase`, 1 .. 3, that was found to be stuck, all three being measured: whether it has no current and the other two sum
/// to zero, so that it is open.
bool lode_plausibility_is_open(const lode_plausibility_t *self, uint32_t phase, float A_per_count);

/// One look at the currents, the vector having turned by `turn_rad` since the last one. `i_A2`: the
/// square of the current that is asked for. Returns the phase without a half-wave, 1 .. 3; 0: none found.
uint_least8_t lode_waves_step(lode_waves_t *self, const lode_plausibility_tuning_t *tuning,
                              const int32_t i[LODE_PHASES], float i_A2, float turn_rad);

/// Between two steps: whether the current, squared, has fallen.
void lode_drop_look(lode_drop_t *self, float i_A2);

/// Once in LODE_SLOW_PERIODS, `asked_A2` being the current asked for, squared (0: too little to tell), and `e_V` the EMF
/// along and across the vector. True: some rounds ago the current fell, and it is back; `change_V` is then the change of the
/// EMF.
bool lode_drop_step(lode_drop_t *self, float i_A2, float asked_A2, lode_dq_t e_V, float *change_V);

/// Once in LODE_SLOW_PERIODS, for a current that has hardly moved (lode_frozen_moves() in plausibility_inline.h), with the
/// current asked for now. True: it is not where it was asked to be; if there is voltage for it, it is frozen.
bool lode_frozen_look(lode_frozen_t *self, const lode_plausibility_tuning_t *tuning,
                      lode_ab_t asked_A);

/// After a look: whether the current asked for has made a whole turn since the first one, at `turn_rad` in LODE_SLOW_PERIODS.
bool lode_frozen_turned(const lode_frozen_t *self, float turn_rad);

/// A current `i_A` that is far from `expected_A`, which follows from the last one by voltage and EMF; `size`: how far, squared,
/// relative to the least that is checked. `starts`: an increase does not count. True: this sample says nothing about the EMF.
bool lode_jump_look(lode_jump_t *self, lode_ab_t i_A, lode_ab_t expected_A, float size,
                    bool starts);

/// In each period with a stage other than NONE, after lode_jump_look() if that was called. Returns the factor that has
/// persisted; below 0: none. `turn_rad`: by how much the vector turns in a period; `gone`: nothing is left of the current.
float lode_jump_wait(lode_jump_t *self, float turn_rad, bool gone);

/// `config` is completed by lode_guard_design().
lode_status_t lode_plausibility_tune(lode_plausibility_tuning_t *tuning,
                                     const lode_guard_config_t *config, float i_max_A,
                                     const lode_sense_tuning_t *sense);

/// What a load may do in RUN (K19). `rise_rad_s2`: acceleration of a free rotor by all the torque of i_max, electrical. Call
/// lode_plausibility_tune() first, which sets the rest.
lode_status_t lode_plausibility_tune_load(lode_plausibility_tuning_t *tuning,
                                          const lode_guard_config_t *config, float rise_rad_s2,
                                          float ts_s);

/// What depends on voltages. `i_max_V`: what would change the current by i_max in a period (K38); `taken_V`: what dead time
/// and drops may take of a phase.
void lode_plausibility_tune_voltages(lode_plausibility_tuning_t *tuning,
                                     const lode_guard_config_t *config, float i_max_V,
                                     float taken_V);

/// Once in LODE_SLOW_PERIODS, while all of the torque is asked for, `sense` (1 or -1) its direction: whether a load has
/// moved the electrical speed `omega_rad_s` against it by more than it may (K19), (K29). While less is asked for, `self`
/// is held at the present speed.
bool lode_load_is_too_large(lode_load_t *self, const lode_plausibility_tuning_t *tuning,
                            float sense, float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
