// Watching for open phases and dead switches: the fast test for a suspicion.
#ifndef LODE_OPEN_PHASE_INLINE_H
#define LODE_OPEN_PHASE_INLINE_H

#include "lodestar/open_phase.h"

// From one check of a set's phases to the next: two per round.
#define LODE_WATCH_PERIODS 4u

// A half-wave is requested from a phase within 70 degrees of its axis, where the phase's share of the alpha-beta current is at
// least a third of the vector's length. It is missing with less than a quarter of that, and flows with half (V9).
#define LODE_WAVE_REF (1.0f / 3.0f)
#define LODE_WAVE_LACKS 0.25f
#define LODE_WAVE_HAS 0.5f
// The missing part then flows in the xy plane: as a share of the alpha-beta current (V10).
#define LODE_WAVE_XY (LODE_WAVE_REF * (1.0f - LODE_WAVE_LACKS))

// Takes the currents of the alpha-beta and xy planes. False, as for nearly all healthy machines: lode_open_phase_check() would
// find nothing.
LODE_INLINE bool lode_open_phase_doubts(const lode_open_phase_watch_t *self,
                                        const lode_open_phase_tuning_t *tuning, lode_ab_t i_A,
                                        lode_ab_t i_xy_A) {
    const float i_A2 = i_A.alpha * i_A.alpha + i_A.beta * i_A.beta;
    const float xy_A2 = i_xy_A.alpha * i_xy_A.alpha + i_xy_A.beta * i_xy_A.beta;
    return self->doubts || (xy_A2 >= LODE_WAVE_XY * LODE_WAVE_XY * i_A2 &&
                            i_A2 >= tuning->least_A * tuning->least_A);
}

// Checks the currents of set `set`, 0 or 1, and of the alpha-beta plane, in stator axes; the vector turns by `turn_rad`
// between two checks of a set. Returns what is open.
lode_open_phase_t lode_open_phase_check(lode_open_phase_watch_t *self,
                                        const lode_open_phase_tuning_t *tuning, int32_t set,
                                        lode_ab_t i_set_A, lode_ab_t i_A, float turn_rad);

// Three phases: takes reference and control error, in any axes. False, as nearly always: lode_half_waves_check() would find
// nothing (K25).
LODE_INLINE bool lode_half_waves_doubt(const lode_half_waves_t *self,
                                       const lode_open_phase_tuning_t *tuning, lode_dq_t ref_A,
                                       lode_dq_t error_A) {
    const float ref_A2 = ref_A.d * ref_A.d + ref_A.q * ref_A.q;
    const float error_A2 = error_A.d * error_A.d + error_A.q * error_A.q;
    return self->doubts != 0u || (error_A2 >= LODE_WAVE_XY * LODE_WAVE_XY * ref_A2 &&
                                  ref_A2 >= tuning->least_A * tuning->least_A);
}

// Input of a check of three phases, in stator axes.
typedef struct {
    lode_ab_t ref_A;
    lode_ab_t before_A; // reference of a round ago, turned with the rotor
    lode_ab_t i_A;
    lode_ab_t beyond_V; // observed EMF beyond the active flux's
    float kp_V_A;       // gain of current control, weaker axis
    float turn_rad;     // turn of the vector between two checks
} lode_half_waves_seen_t;

// The phase, 1 .. 3, with a half-wave or both missing; 0: none.
lode_open_phase_t lode_half_waves_check(lode_half_waves_t *self,
                                        const lode_open_phase_tuning_t *tuning,
                                        const lode_half_waves_seen_t *seen);

// The phase that has lacked a half-wave for a quarter as long: enough where the lock is lost as well (K41).
lode_open_phase_t lode_half_waves_suspect(const lode_half_waves_t *self);

#endif
