// Signal injection, one period. docs/theory/injection.md.
#ifndef LODE_HFI_INLINE_H
#define LODE_HFI_INLINE_H

#include "lodestar/hfi.h"
#include "scalar_inline.h"

// Above this the error signal is no longer the angle error.
#define LODE_HFI_ERROR_MAX_rad 0.5f

// The tuning without injection. The divisor is not zero, because a corrupted state may still use it.
LODE_INLINE lode_hfi_tuning_t lode_hfi_none(void) {
    return (lode_hfi_tuning_t){.find_rounds = 0u, .least_V2 = FLT_MIN};
}

LODE_INLINE bool lode_hfi_is_on(const lode_hfi_tuning_t *tuning) {
    return tuning->find_rounds > 0u;
}

// Position error (H4) of the period with the dead-beat EMF `m_V`, seen from the predicted angle in its middle; `i_A`: current
// at its end, seen from the predicted angle there.
LODE_INLINE void lode_hfi_demodulate(lode_hfi_t *self, const lode_hfi_tuning_t *tuning,
                                     float salient_Ohm, lode_dq_t m_V, lode_dq_t i_A) {
    const float axis = self->axis;
    const lode_dq_t rise_A = {i_A.d - self->i_A.d, i_A.q - self->i_A.q};
    // Both are longer by 1/cos(eps), which cancels in their ratio.
    const float h_V = salient_Ohm * (rise_A.d + axis * rise_A.q);
    const float q_V = m_V.q - axis * m_V.d;
    const float swing_V = h_V - self->h_V;
    const float moved_V = q_V - self->q_V;
    const bool alternates = (self->signs & LODE_HFI_RANDOM) == 0u;
    // Between two pairs the sign may stay, and there is no excitation (H22).
    if (alternates || (self->signs & LODE_HFI_FIRST) != 0u) {
        self->error = moved_V * swing_V / lode_max(swing_V * swing_V, tuning->least_V2);
        self->sum_V += (alternates ? 1.0f : 2.0f) * lode_abs(swing_V);
    }
    self->h_V = h_V;
    self->q_V = q_V;
}

// `i_A`: current in the frame of its angle. The drive sets the reserve.
void lode_hfi_begin(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, lode_dq_t i_A);

// Once in LODE_SLOW_PERIODS of a start at rest: reference of the d current, by the largest one. `step` shows the progress.
float lode_hfi_find(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, float i_max_A);

// Once in LODE_SLOW_PERIODS of LODE_HFI_PUSH: returns the share of the largest current across the axis. `rotor`: its
// estimated angle; `step_rad`: its rotation per period, in the direction of the current, which has the sign `direction`.
float lode_hfi_push(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, lode_sincos_t rotor,
                    float step_rad, float direction);

// Swing of the current by the wave, of the expected one (H29).
LODE_INLINE float lode_hfi_swing(const lode_hfi_t *self, const lode_hfi_tuning_t *tuning) {
    return self->swing_V * tuning->inv_full;
}

// Once in LODE_SLOW_PERIODS: false if the currents have not shown the wave for several rounds (H29). `searches`: the axis is
// not known, `least`: Ld/Lq.
bool lode_hfi_shows_wave(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, bool searches,
                         float least);

// Turns the angle by half a turn.
void lode_hfi_turn_round(lode_hfi_t *self);

// Once in LODE_SLOW_PERIODS, with `i_A` in the rotor's frame: begins if the speed is low enough, sets weight (H11) and axis
// (H6). False: injection ends at this speed.
bool lode_hfi_follow(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, lode_dq_t i_A,
                     float omega_rad_s);

// Lock quality by injection (H13), once in LODE_SLOW_PERIODS. `weight`: of the present error in the mean one.
float lode_hfi_quality(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, float weight);

// (H11), not limited yet. `error_rad`: of the EMF.
LODE_INLINE float lode_hfi_blend(const lode_hfi_t *self, float error_rad) {
    return error_rad + self->weight * (self->error - error_rad);
}

// Takes in the current at t_k. Returns the mean of the last two, in which the ripple cancels (H12); with pairs of waves the
// current at the end of a pair, which has no ripple (H22).
LODE_INLINE lode_dq_t lode_hfi_less_ripple(lode_hfi_t *self, lode_dq_t i_A) {
    const lode_dq_t last_A = self->i_A;
    self->i_A = i_A;
    if ((self->signs & LODE_HFI_RANDOM) != 0u) {
        return (self->signs & LODE_HFI_FIRST) != 0u ? i_A : last_A;
    }
    return (lode_dq_t){0.5f * (i_A.d + last_A.d), 0.5f * (i_A.q + last_A.q)};
}

// Signs of the next wave. The first of a pair has a random sign, by a maximal sequence of 16383 (x^14 + x^13 + x^12 + x^2 +
// 1), the second the opposite one.
LODE_INLINE uint32_t lode_hfi_next_signs(uint32_t signs) {
    const uint32_t turned = signs ^ LODE_HFI_NEGATIVE;
    const uint32_t random = signs & LODE_HFI_RANDOM;
    if (random == 0u) {
        return turned;
    }
    if ((signs & LODE_HFI_FIRST) != 0u) {
        return turned ^ LODE_HFI_FIRST;
    }
    const bool turns = (random & 1u) != 0u;
    const uint32_t sign = (turns ? turned : signs) & LODE_HFI_NEGATIVE;
    return sign | LODE_HFI_FIRST | ((random >> 1) ^ (turns ? 0x3802u : 0u));
}

// Adds the wave, whose sign changes, to `u_V` of current control.
LODE_INLINE lode_dq_t lode_hfi_add_wave(lode_hfi_t *self, const lode_hfi_tuning_t *tuning,
                                        lode_dq_t u_V) {
    self->signs = (uint_least16_t)lode_hfi_next_signs(self->signs);
    const bool negative = (self->signs & LODE_HFI_NEGATIVE) != 0u;
    const float wave_V = negative ? -tuning->V_h_V : tuning->V_h_V;
    return (lode_dq_t){u_V.d + wave_V, u_V.q + wave_V * self->axis};
}

#endif
