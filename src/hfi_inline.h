// Signal injection, one period. docs/theory/injection.md.
#ifndef LODE_HFI_INLINE_H
#define LODE_HFI_INLINE_H

#include "lodestar/hfi.h"
#include "scalar_inline.h"

// Of H0 (H4).
#define LODE_HFI_LEAST_SHARE 0.3f
// Beyond it neither source's error is the angle itself.
#define LODE_HFI_ERROR_MAX_rad 0.5f

// Position error (H4) of the period whose dead-beat EMF is `m_V`. `middle`: predicted angle in the middle of
// it; `half_step`: motion of half a period; `i_A`: current at its end.
LODE_INLINE void lode_hfi_demodulate(lode_hfi_t *self, const lode_hfi_tuning_t *tuning,
                                     float salient_Ohm, lode_ab_t m_V, lode_ab_t i_A,
                                     lode_sincos_t middle, lode_sincos_t half_step) {
    const lode_sincos_t across = lode_angle_add(middle, self->axis);
    const lode_sincos_t end = lode_angle_add(across, half_step);
    const float h_V = salient_Ohm * (lode_park(i_A, end).d - self->ih_A);
    const float q_V = lode_park(m_V, across).q;
    const float swing_V = h_V - self->h_V;
    const float moved_V = q_V - self->q_V;
    const float least_V = LODE_HFI_LEAST_SHARE * tuning->full_V;
    // A corrupted state may inject without a tuning for it: the divisor is never zero.
    const float least_V2 = least_V * least_V + FLT_MIN;
    const float ratio = moved_V * swing_V / lode_max(swing_V * swing_V, least_V2);
    self->error = lode_clamp(ratio, -LODE_HFI_ERROR_MAX_rad, LODE_HFI_ERROR_MAX_rad);
    self->h_V = h_V;
    self->q_V = q_V;
    self->swing_V = swing_V;
    self->sum_V += lode_abs(swing_V);
}

// From the current `i_A` along its axis.
void lode_hfi_begin(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, lode_dq_t i_A);

// Once in LODE_SLOW_PERIODS of a start at rest: the d current that is asked for. `step` says how far it is.
float lode_hfi_find(lode_hfi_t *self, const lode_hfi_tuning_t *tuning);

// The angle is half a turn on.
void lode_hfi_turn_round(lode_hfi_t *self);

// Once in LODE_SLOW_PERIODS: begins and ends by the speed; weight (H11) and axis (H6). `i_A`: in the rotor's
// frame.
void lode_hfi_follow(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, lode_dq_t i_A,
                     float omega_rad_s);

// Lock quality by injection (H13). `weight`: of the present error in the mean one.
float lode_hfi_quality(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, float weight);

// (H11). `error_rad`: of the EMF.
LODE_INLINE float lode_hfi_blend(const lode_hfi_t *self, float error_rad) {
    const float emf = lode_clamp(error_rad, -LODE_HFI_ERROR_MAX_rad, LODE_HFI_ERROR_MAX_rad);
    return emf + self->weight * (self->error - emf);
}

// Takes in the current at t_k. Returns the mean of the last two, in which the ripple cancels (H12).
LODE_INLINE lode_dq_t lode_hfi_less_ripple(lode_hfi_t *self, lode_dq_t i_A) {
    const lode_dq_t mean = {0.5f * (i_A.d + self->i_A.d), 0.5f * (i_A.q + self->i_A.q)};
    self->ih_A = i_A.d * self->axis.cos + i_A.q * self->axis.sin;
    self->i_A = i_A;
    return mean;
}

// `u_V` of current control with the wave, whose sign turns.
LODE_INLINE lode_dq_t lode_hfi_add_wave(lode_hfi_t *self, lode_dq_t u_V) {
    const float wave_V = -self->wave_V;
    self->wave_V = wave_V;
    return (lode_dq_t){u_V.d + wave_V * self->axis.cos, u_V.q + wave_V * self->axis.sin};
}

#endif
