// The estimator's part of the step.
#ifndef LODESTAR_ESTIMATOR_INLINE_H
#define LODESTAR_ESTIMATOR_INLINE_H

#include "emf_inline.h"
#include "lag_inline.h"
#include "lodestar/estimator.h"

/// The currents change their meaning, as when one set of a winding goes on alone: `i_A` is the present
/// one in the new sense. Angle, speed and EMF stay.
static inline void lode_estimator_rewire(lode_estimator_t *self, lode_ab_t i_A) {
    self->emf.i_A = i_A;
    self->id_A = lode_park(i_A, self->rotor).d;
}

/// Parts of lode_estimator_follow(), which alone calls them: what is not due in every period.
void lode_estimator_restart(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                            lode_ab_t i_A);
void lode_estimator_note_rotation(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
lode_sincos_t lode_estimator_filtered_turn(lode_estimator_t *self,
                                           const lode_estimator_tuning_t *tuning,
                                           float omega_rad_s);

/// Amplitude, squared, beyond any motor's EMF: NaN and Inf fall outside.
#define LODE_EMF2_LIMIT_V2 1.0e12f

/// What follows the speed, and the lock quality.
typedef enum {
    LODE_ADAPT_NOTCHES,
    LODE_ADAPT_LOCK, ///< and supervision
    LODE_ADAPT_SEED, ///< where there has been no lock for long enough: speed and angle anew
    LODE_ADAPT_LAG,  ///< after SEED, like the gains
    LODE_ADAPT_GAINS,
    LODE_ADAPT_PARTS
} lode_adapt_t;

/// The angle of a period at twice the highest omega_max, and some more.
#define LODE_ADVANCE_MAX_rad 1.125f

/// One each.
void lode_estimator_adapt_gains(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
void lode_estimator_adapt_lag(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
void lode_estimator_adapt_notches(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
void lode_estimator_adapt_lock(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
bool lode_estimator_adapt_seed(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);

/// The slow part of a period, after lode_estimator_follow(): each of lode_adapt_t once in
/// LODE_SLOW_PERIODS, in periods of their own. True: angle and speed were taken up anew.
static inline bool lode_estimator_adapt(lode_estimator_t *self,
                                        const lode_estimator_tuning_t *tuning, lode_adapt_t part) {
    switch (part) {
    case LODE_ADAPT_GAINS:
        lode_estimator_adapt_gains(self, tuning);
        return false;
    case LODE_ADAPT_LAG:
        lode_estimator_adapt_lag(self, tuning);
        return false;
    case LODE_ADAPT_NOTCHES:
        lode_estimator_adapt_notches(self, tuning);
        return false;
    case LODE_ADAPT_SEED:
        return lode_estimator_adapt_seed(self, tuning);
    case LODE_ADAPT_LOCK:
    case LODE_ADAPT_PARTS:
    default:
        lode_estimator_adapt_lock(self, tuning);
        return false;
    }
}

LODE_INLINE float lode_estimator_load_torque_Nm(const lode_estimator_t *self,
                                                const lode_estimator_tuning_t *tuning) {
    return tuning->load_per_f_Nm * self->pll.f_rad_s2;
}

/// The EMF at t_k. `half_turn`: angle of half a period, of which `advance_rad` is the whole;
/// `omega_rad_s`: speed as predicted.
LODE_INLINE lode_ab_t lode_estimator_emf(lode_estimator_t *self,
                                         const lode_estimator_tuning_t *tuning, lode_ab_t u_V,
                                         lode_ab_t i_A, lode_sincos_t half_turn, float advance_rad,
                                         float omega_rad_s) {
    const lode_sincos_t turn = lode_angle_double(half_turn);
    lode_ab_t m_V = lode_emf_dead_beat(&self->emf, &tuning->emf, u_V, i_A);
    if (LODE_RARELY(!self->locked)) {
        lode_estimator_note_rotation(self, tuning);
    } else if (tuning->emf.salient) {
        // In the frame of id_A, moved on and not corrected.
        m_V = lode_emf_less_salient(&tuning->emf, m_V, i_A, lode_angle_add(self->rotor, turn),
                                    half_turn, self->id_A);
    }
    lode_sincos_t tuned = turn;
    if (LODE_RARELY(lode_observer_rotates(&tuning->emf.observer))) {
        // (G1): at the speed predicted, not at the mean of the period.
        const float more = tuning->pll.ts_s * omega_rad_s - advance_rad;
        tuned = (lode_sincos_t){turn.sin + more * turn.cos, turn.cos - more * turn.sin};
        if (LODE_RARELY(tuning->w_filtered)) {
            tuned = lode_estimator_filtered_turn(self, tuning, omega_rad_s);
            omega_rad_s = self->omega_tune;
        }
    }
    return lode_observer_step(&self->emf.observer, &tuning->emf.observer, m_V, tuned, omega_rad_s);
}

/// The position error without the harmonics of the EMF, which show in it at 6 w and 12 w.
LODE_INLINE float lode_estimator_notched(lode_estimator_t *self,
                                         const lode_estimator_tuning_t *tuning, float error) {
#ifdef LODE_WITHOUT_NOTCH
    (void)self;
    (void)tuning;
#else
    if (tuning->notched) {
        error = lode_notch_step(&self->notch, &tuning->notch, error);
        if (tuning->notched12) {
            error = lode_notch_step(&self->notch12, &tuning->notch12, error);
        }
    }
#endif
    return error;
}

/// Known acceleration over the period to come (P3), rad/s^2: torque of the measured current, seen from
/// where the rotor is by the position error (P19), and friction.
LODE_INLINE float lode_estimator_acceleration(const lode_estimator_tuning_t *tuning, lode_dq_t i_A,
                                              float error, float omega_rad_s) {
    const float flux_Wb = tuning->psi_Wb + tuning->salient_H * i_A.d;
    const float swing = lode_max(tuning->salient_H * i_A.q * i_A.q - flux_Wb * i_A.d, 0.0f);
    return tuning->acc_per_torque * (flux_Wb * i_A.q + swing * error) -
           tuning->acc_per_omega * omega_rad_s;
}

/// The fast part of a period: `u_V` is the mean voltage over [t_k-1, t_k), `i_A` the current at t_k.
/// Total: whatever goes in, finite and in range comes out, and `reseeded` tells.
LODE_INLINE lode_estimate_t lode_estimator_follow(lode_estimator_t *self,
                                                  const lode_estimator_tuning_t *tuning,
                                                  lode_ab_t u_V, lode_ab_t i_A) {
    float omega;
    const float advance = lode_pll_advance_rad(&self->pll, &tuning->pll, &omega);
    const lode_sincos_t half_turn = lode_sincos_small(0.5f * advance);
    const lode_sincos_t frame = lode_angle_add(self->pll.frame, lode_angle_double(half_turn));
    const lode_ab_t e_V = lode_estimator_emf(self, tuning, u_V, i_A, half_turn, advance, omega);

    // Phase detector (paper 1, eq. 13; P1) with the sign of speed: else it locks half a turn off.
    const float e2 = e_V.alpha * e_V.alpha + e_V.beta * e_V.beta;
    const float e_abs = lode_max(sqrtf(e2), tuning->emin_V);
    const float across_V = lode_park(e_V, frame).d;
    const float seen = (omega < 0.0f ? across_V : -across_V) / e_abs;
    const float error = lode_estimator_notched(self, tuning, seen);
    lode_pll_move(&self->pll, self->gains, frame, omega, error);
    if (LODE_RARELY(!(lode_abs(advance) <= LODE_ADVANCE_MAX_rad)) ||
        LODE_RARELY(!(e2 <= LODE_EMF2_LIMIT_V2)) ||
        LODE_RARELY(!(lode_abs(self->pll.omega_rad_s) <= tuning->omega_limit))) { // NaN included
        lode_estimator_restart(self, tuning, (lode_ab_t){i_A.alpha, i_A.beta});
        const lode_sincos_t rotor = self->rotor;
        return (lode_estimate_t){
            .omega_rad_s = 0.0f,
            .rotor = rotor,
            .half_turn = {0.0f, 1.0f},
            .i_A = lode_park(self->emf.i_A, rotor),
            .e_V = {0.0f, 0.0f},
            .load_torque_Nm = 0.0f,
            .lock = 0.0f,
            .reseeded = true,
        };
    }
    if (LODE_RARELY(lode_lag_is_far(&self->lag, self->pll.omega_rad_s))) {
        lode_estimator_adapt_lag(self, tuning);
    }
    const lode_sincos_t rotor =
        lode_angle_add(self->pll.frame, lode_lag_near(&self->lag, self->pll.omega_rad_s));
    const lode_dq_t i_dq = lode_park(i_A, rotor);
    self->rotor = rotor;
    self->id_A = i_dq.d;
    if (LODE_USUALLY(tuning->pll.third_order)) {
        lode_pll_disturb(&self->pll, self->gains, error);
        self->pll.acc_rad_s2 =
            lode_estimator_acceleration(tuning, i_dq, error, self->pll.omega_rad_s);
    }
    return (lode_estimate_t){
        .omega_rad_s = self->pll.omega_rad_s,
        .rotor = rotor,
        .half_turn = half_turn,
        .i_A = i_dq,
        .e_V = e_V,
        .load_torque_Nm = lode_estimator_load_torque_Nm(self, tuning),
        .lock = self->lock,
        .reseeded = false,
    };
}

#endif
