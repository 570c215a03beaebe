// Watching for open phases and dead switches: whether there is anything to look at.
#ifndef LODE_OPEN_PHASE_INLINE_H
#define LODE_OPEN_PHASE_INLINE_H

#include "lodestar/open_phase.h"

#define LODE_WATCH_PERIODS                                                                         \
    4u // from one look at a set's phases to the next: there are two in a round

// A half-wave is asked of a phase within 70 degrees of its axis, where its share of the alpha-beta current is a third of
// the vector's length at least. It lacks it with less than a quarter of that, and has it with half (V9).
#define LODE_WAVE_ASKED (1.0f / 3.0f)
#define LODE_WAVE_LACKS 0.25f
#define LODE_WAVE_HAS 0.5f
// What it lacks then flows in the xy plane: as share of the alpha-beta current (V10).
#define LODE_WAVE_XY (LODE_WAVE_ASKED * (1.0f - LODE_WAVE_LACKS))

// Currents of the alpha-beta and of the xy plane. False, as of nearly all sound machines: lode_open_phase_look() would
// find nothing.
LODE_INLINE bool lode_open_phase_doubts(const lode_open_phase_watch_t *self,
                                        const lode_open_phase_tuning_t *tuning, lode_ab_t i_A,
                                        lode_ab_t i_xy_A) {
    const float i_A2 = i_A.alpha * i_A.alpha + i_A.beta * i_A.beta;
    const float xy_A2 = i_xy_A.alpha * i_xy_A.alpha + i_xy_A.beta * i_xy_A.beta;
    return self->doubts || (xy_A2 >= LODE_WAVE_XY * LODE_WAVE_XY * i_A2 &&
                            i_A2 >= tuning->least_A * tuning->least_A);
}

// The currents of set `set`, 0 or 1, in stator axes, and that of the alpha-beta plane; the vector turns by `turn_rad` from
// one look at a set to the next. Returns what is open.
lode_open_phase_t lode_open_phase_look(lode_open_phase_watch_t *self,
                                       const lode_open_phase_tuning_t *tuning, int32_t set,
                                       lode_ab_t i_set_A, lode_ab_t i_A, float turn_rad);

// Three phases: the current that is asked for, and what is missed of it, in any axes. False, as nearly always:
// lode_half_waves_look() would find nothing (K25).
LODE_INLINE bool lode_half_waves_doubt(const lode_half_waves_t *self,
                                       const lode_open_phase_tuning_t *tuning, lode_dq_t asked_A,
                                       lode_dq_t missed_A) {
    const float asked_A2 = asked_A.d * asked_A.d + asked_A.q * asked_A.q;
    const float missed_A2 = missed_A.d * missed_A.d + missed_A.q * missed_A.q;
    return self->doubts != 0u || (missed_A2 >= LODE_WAVE_XY * LODE_WAVE_XY * asked_A2 &&
                                  asked_A2 >= tuning->least_A * tuning->least_A);
}

// What a look at three phases sees, in stator axes.
typedef struct {
    lode_ab_t asked_A;
    lode_ab_t before_A; // asked for a round ago, turned with the rotor
    lode_ab_t i_A;
    lode_ab_t beyond_V; // EMF that the magnets do not have
    float kp_V_A;       // of current control, in its weaker axis
    float turn_rad;     // of the vector, from one look to the next
} lode_half_waves_seen_t;

// The phase, 1 .. 3, that lacks a half-wave or both of what is asked for; 0: none.
lode_open_phase_t lode_half_waves_look(lode_half_waves_t *self,
                                       const lode_open_phase_tuning_t *tuning,
                                       const lode_half_waves_seen_t *seen);

#endif
