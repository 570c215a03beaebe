// One period of the estimator, and its slow jobs.
#ifndef LODE_ESTIMATOR_INLINE_H
#define LODE_ESTIMATOR_INLINE_H

#include "emf_inline.h"
#include "hfi_inline.h"
#include "lag_inline.h"
#include "lodestar/estimator.h"
#include "notch_inline.h"
#include "pll_inline.h"
#include "scalar_inline.h"
#include "schedule.h"

// Larger than any motor's EMF; NaN and Inf are outside too.
#define EMF_LIMIT_V 1.0e6f
// Lock quality from which on the EMF of a changing active flux is removed: the angle is then within some 65 degrees. When this
// ended only with the lock, an angle on its way back was replaced by an EMF that the rise of the current had turned, at a speed
// 60 % off. Simulated: 0.3 to 0.4 lose none of 220 starts, 0.25 one; of starts that hand over at 100 of 1500 rpm 193 to 194 of
// 200 succeed.
#define LOCK_ALIGNED 0.4f
// Beyond this the position error is not the sine of any angle.
#define SINE_MAX 1.1f
// The quality falls from 1 to LODE_LOCK_LOST where the EMF is 40 % off the one that the speed induces.
#define LEVEL_SLOPE 1.25f
// A speed above this multiple of omega_max is an alias (P15).
#define LODE_ALIAS_SHARE 2.0f
// Wrong parameters make the EMF this much smaller than the speed induces, and no more; the rest is slip (P24), (P35).
#define SLIP_MIN 0.2f

// (P30): errors of a round. Each period has at most SINE_MAX, (P24) adds at most 0.5 for each; the rest is for rounding.
#define ROUND_ERROR (1.65f * (float)LODE_SLOW_PERIODS)

LODE_INLINE bool lode_estimator_asks(uint32_t options, int option) {
    return (options & (uint32_t)option) != 0u;
}

// Rare parts, in estimator.c. What they take and return by value is copied at the call: such copies share one place on the
// step's stack, while a variable whose address is passed has its own 8 bytes in every period. With the copies in observers and
// current control that saves 48 bytes and 8 cycles.
void lode_estimator_restart(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
void lode_estimator_note_rotation(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
lode_sincos_t lode_estimator_filtered_step(lode_estimator_t *self,
                                           const lode_estimator_tuning_t *tuning,
                                           float omega_rad_s);
float lode_estimator_recompute(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                               lode_sincos_t frame);
// A large position error in a period with injection.
float lode_estimator_limit(const lode_estimator_t *self, float error);
// The PLL is faster than the EMF says, by the share `slip`.
void lode_estimator_brake_slip(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                               float slip);
void lode_estimator_limit_slip(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                               float slip);
void lode_estimator_move_lag(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                             float omega_rad_s);
// Starts with angle and speed at t_k that were not found by the EMF.
void lode_estimator_begin_at(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                             lode_sincos_t rotor, float omega_rad_s);
// `now` replaces the tuning `before`: a new observer starts with the rotor's present EMF, and injection ends if `now` has none.
void lode_estimator_retune(lode_estimator_t *self, const lode_estimator_tuning_t *before,
                           const lode_estimator_tuning_t *now);
// A large motion of a locked PLL in a round is one that it can make (P30), or was not noted.
bool lode_estimator_may_move(const lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
void lode_estimator_wait(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
// From now on the EMF alone gives the position.
void lode_estimator_end_injection(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
// `held`: the rotor is known to keep its present speed, whatever the torque.
bool lode_estimator_seed(lode_estimator_t *self, const lode_estimator_tuning_t *tuning, bool held);

#ifndef LODE_WITHOUT_PLAUSIBILITY
// Active flux linkage: as configured, and as the EMF's size shows it.
typedef struct {
    float expected_Wb;
    float seen_Wb;
    bool aligned; // the EMF is within 25 degrees of the PLL's angle
} lode_flux_t;

lode_flux_t lode_estimator_flux(const lode_estimator_t *self,
                                const lode_estimator_tuning_t *tuning);

// Observed EMF minus the EMF of the active flux at the PLL's angle.
lode_ab_t lode_estimator_beyond_V(const lode_estimator_t *self,
                                  const lode_estimator_tuning_t *tuning);
#endif

// The motion is not checked (P30) until it is noted again: it is set from outside.
LODE_INLINE void lode_estimator_forget_motion(lode_estimator_t *self) {
    self->omega_noted = 0.0f;
}

// Ratio of the EMF to the observer's estimate, in steady rotation.
LODE_INLINE float lode_estimator_droop(const lode_estimator_tuning_t *tuning, float omega_rad_s) {
    return 1.0f + omega_rad_s * omega_rad_s * tuning->droop_s2;
}

LODE_INLINE float lode_estimator_load_torque_Nm(const lode_estimator_t *self,
                                                const lode_estimator_tuning_t *tuning) {
    return tuning->load_per_f_Nm * self->pll.f_rad_s2;
}

// Signal injection gives the position, or a part of it.
LODE_INLINE bool lode_estimator_injects(const lode_estimator_t *self) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return false;
#else
    return self->by.hfi.active;
#endif
}

// There is an angle, or was one until the lock was lost. There is none after a restart, which a runaway estimate or corrupted
// memory causes.
LODE_INLINE bool lode_estimator_has_rotor(const lode_estimator_t *self) {
    return self->found > 0u || lode_estimator_injects(self);
}

// Sine and cosine of the rotor's angle at t_k.
LODE_SHARED lode_sincos_t lode_estimator_rotor(const lode_estimator_t *self) {
    return lode_angle_add(self->pll.frame, lode_lag_near(&self->lag, self->pll.omega_rad_s));
}

// Observer step: the EMF at t_k from the dead-beat EMF. `step`: rotation by the angle moved.
LODE_INLINE lode_ab_t lode_estimator_emf(lode_estimator_t *self,
                                         const lode_estimator_tuning_t *tuning, uint32_t options,
                                         lode_ab_t m_V, lode_pll_motion_t motion,
                                         lode_sincos_t step, bool by_wave) {
    if (!by_wave && !self->locked) {
        lode_estimator_note_rotation(self, tuning);
    }
    lode_sincos_t tuned = step;
    float omega_rad_s = motion.omega_rad_s;
    if (lode_observer_rotates(&tuning->emf.observer)) {
        // (G1): at the speed predicted for t_k, not at the mean speed of the period.
        const float more = tuning->pll.ts_s * motion.omega_rad_s - motion.angle_rad;
        tuned = lode_angle_rotate_small(step, more);
        if (lode_estimator_asks(options, LODE_ESTIMATOR_FILTERED)) {
            const lode_sincos_t slow = lode_estimator_filtered_step(self, tuning, omega_rad_s);
            tuned = (lode_sincos_t){slow.sin, slow.cos};
            omega_rad_s = self->omega_tune;
        }
    }
    return lode_observer_step(&self->emf.observer, &tuning->emf.observer, m_V, tuned, omega_rad_s);
}

// Clears the notches' states.
LODE_INLINE void lode_estimator_clear_notches(lode_estimator_t *self) {
#ifdef LODE_WITHOUT_NOTCH
    (void)self;
#else
    self->by.alone.notch.sogi = self->by.alone.notch12.sogi = (lode_sogi_t){0.0f, 0.0f};
#endif
}

// The position error without the EMF's harmonics, which appear in it at 6 w and 12 w.
LODE_INLINE float lode_estimator_notched(lode_estimator_t *self,
                                         const lode_estimator_tuning_t *tuning, uint32_t options,
                                         float error) {
#ifdef LODE_WITHOUT_NOTCH
    (void)self;
    (void)tuning;
    (void)options;
#else
    if (lode_estimator_asks(options, LODE_ESTIMATOR_NOTCH)) {
        error = lode_notch_step(&self->by.alone.notch, tuning->notch.k, error);
        if (lode_estimator_asks(options, LODE_ESTIMATOR_NOTCH12)) {
            error = lode_notch_step(&self->by.alone.notch12, tuning->notch12_k, error);
        }
    }
#endif
    return error;
}

// Known acceleration over the next period (P3), rad/s^2: friction, and the torque of the measured current, seen from the
// rotor's angle by the position error (P19).
LODE_INLINE float lode_estimator_acceleration(const lode_estimator_tuning_t *tuning, lode_dq_t i_A,
                                              float error, float omega_rad_s) {
    const float flux_Wb = tuning->psi_Wb + tuning->salient_H * i_A.d;
    const float swing = lode_max(tuning->salient_H * i_A.q * i_A.q - flux_Wb * i_A.d, 0.0f);
    return tuning->acc_per_torque * (flux_Wb * i_A.q + swing * error) -
           tuning->acc_per_omega * omega_rad_s;
}

// Estimate after lode_estimator_restart(): the current, in a frame at angle 0.
LODE_INLINE lode_estimate_t lode_estimator_nothing(const lode_estimator_t *self) {
    return (lode_estimate_t){.rotor = self->pll.frame,
                             .i_A = {self->emf.i_A.alpha, self->emf.i_A.beta},
                             .reseeded = true,
                             .source = LODE_ESTIMATE_OWN};
}

// Estimate of a normal period.
LODE_INLINE lode_estimate_t lode_estimator_estimate(const lode_estimator_t *self,
                                                    const lode_estimator_tuning_t *tuning,
                                                    lode_sincos_t rotor, lode_dq_t i_A) {
    return (lode_estimate_t){
        .omega_rad_s = self->pll.omega_rad_s,
        .rotor = rotor,
        .i_A = i_A,
        .e_V = self->emf.observer.e_V,
        .load_torque_Nm = lode_estimator_load_torque_Nm(self, tuning),
        .lock = self->lock,
        .reseeded = false,
        .source = LODE_ESTIMATE_OWN,
    };
}

// Dead-beat EMF without the EMF of a changing active flux. `frame`: of the PLL, predicted for t_k; `half`: rotation by half of
// the angle moved. `by_wave`: also demodulates the injection's position error.
LODE_INLINE lode_ab_t lode_estimator_dead_beat(lode_estimator_t *self,
                                               const lode_estimator_tuning_t *tuning,
                                               uint32_t options, lode_ab_t u_V, lode_ab_t i_A,
                                               lode_sincos_t frame, lode_sincos_t half,
                                               bool by_wave) {
    const lode_ab_t m_V = lode_emf_dead_beat(&self->emf, &tuning->emf, u_V, i_A);
    const bool seen = lode_estimator_asks(options, LODE_ESTIMATOR_SALIENT) && self->aligned;
    if (!by_wave && !seen) {
        return m_V;
    }
    // With the lag that id_A was computed with: a difference would look like a rise of the current.
    const lode_sincos_t lag = lode_lag_near(&self->lag, self->pll.omega_rad_s);
    const lode_sincos_t end = lode_angle_add(frame, lag);
    const lode_sincos_t middle = lode_angle_subtract(end, half);
    const lode_dq_t i_end_A = lode_park(i_A, end);
#ifndef LODE_WITHOUT_HFI
    if (by_wave) {
        lode_hfi_demodulate(&self->by.hfi, &tuning->hfi, tuning->emf.salient_Ohm,
                            lode_park(m_V, middle), i_end_A);
    }
#endif
    return lode_emf_less_salient(&tuning->emf, m_V, i_end_A.d - self->id_A, middle);
}

// Position error of a period with injection; `error` is the one by the EMF.
LODE_INLINE float lode_estimator_blend(const lode_estimator_t *self, float error) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return error;
#else
    return lode_hfi_blend(&self->by.hfi, error);
#endif
}

// Current for current control at t_k.
LODE_INLINE lode_dq_t lode_estimator_less_ripple(lode_estimator_t *self, lode_dq_t i_A,
                                                 bool by_wave) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    (void)by_wave;
    return i_A;
#else
    return by_wave ? lode_hfi_less_ripple(&self->by.hfi, i_A) : i_A;
#endif
}

// In a period with injection: the torque of its current is known, with its sign.
LODE_INLINE bool lode_estimator_knows_torque(const lode_estimator_t *self) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return true;
#else
    return self->by.hfi.step != (uint_least8_t)LODE_HFI_PUSH;
#endif
}

// The fast part of a period. `by_wave`: with injection.
LODE_INLINE lode_estimate_t lode_estimator_period(lode_estimator_t *self,
                                                  const lode_estimator_tuning_t *tuning,
                                                  lode_ab_t u_V, lode_ab_t i_A, bool by_wave) {
    const uint32_t options = tuning->options;
    const lode_pll_motion_t motion = lode_pll_predict(&self->pll, &tuning->pll);
    const lode_sincos_t half = lode_sincos_small(0.5f * motion.angle_rad);
    const lode_sincos_t step = lode_angle_double(half);
    lode_sincos_t frame = lode_angle_add(self->pll.frame, step);
    const lode_ab_t m_V =
        lode_estimator_dead_beat(self, tuning, options, u_V, i_A, frame, half, by_wave);
    const lode_ab_t e_V = lode_estimator_emf(self, tuning, options, m_V, motion, step, by_wave);

    // Phase detector (paper 1, eq. 13; P1), with the sign of the speed: without it the loop would lock half a turn off. It uses
    // the amplitude computed last; where the error is large or not finite, the amplitude is computed anew.
    const float across_V = lode_park(e_V, frame).d;
    const float by_emf = across_V * self->per_V;
    float error = by_wave ? lode_estimator_blend(self, by_emf)
                          : lode_estimator_notched(self, tuning, options, by_emf);
    const float small = by_wave ? LODE_HFI_ERROR_MAX_rad : tuning->error_small;
    if (!(lode_abs(error) <= small)) {
        const lode_sincos_t copy = {frame.sin, frame.cos};
        error = by_wave ? lode_estimator_limit(self, error)
                        : lode_estimator_recompute(self, tuning, copy);
        if (!(lode_abs(error) <= SINE_MAX)) {
            lode_estimator_restart(self, tuning);
            return lode_estimator_nothing(self);
        }
        frame = lode_angle_shorten(frame, self->gains.theta * error);
    }
    lode_pll_correct(&self->pll, self->gains, frame, motion.omega_rad_s, error);
    // In every period: after large errors only (6 cycles less), field weakening took 17.7 A instead of 17.3, with 16 A
    // requested.
    if (lode_lag_is_far(&self->lag, self->pll.omega_rad_s)) {
        lode_estimator_move_lag(self, tuning, self->pll.omega_rad_s);
    }
    const lode_sincos_t rotor = lode_estimator_rotor(self);
    lode_dq_t i_dq = lode_park(i_A, rotor);
    self->id_A = i_dq.d;
    i_dq = lode_estimator_less_ripple(self, i_dq, by_wave);
    if (lode_estimator_asks(options, LODE_ESTIMATOR_THIRD_ORDER)) {
        float acc = lode_estimator_acceleration(tuning, i_dq, error, self->pll.omega_rad_s);
        if (by_wave && !lode_estimator_knows_torque(self)) {
            acc = 0.0f;
        }
        lode_pll_correct_disturbance(&self->pll, &tuning->pll, self->gains, error, acc);
    }
    return lode_estimator_estimate(self, tuning, rotor, i_dq);
}

// The fast part of a period, compiled twice, each without a test for injection; as a separate call the version with injection
// took 68 cycles more.
LODE_INLINE lode_estimate_t lode_estimator_fast(lode_estimator_t *self,
                                                const lode_estimator_tuning_t *tuning,
                                                lode_ab_t u_V, lode_ab_t i_A) {
#if defined(LODE_WITHOUT_HFI) || defined(LODE_SMALL)
    return lode_estimator_period(self, tuning, u_V, i_A, lode_estimator_injects(self));
#else
    return lode_estimator_injects(self) ? lode_estimator_period(self, tuning, u_V, i_A, true)
                                        : lode_estimator_period(self, tuning, u_V, i_A, false);
#endif
}

// The state is plausible: a rotation of length 1 (about) and a speed within limits. NaN is not.
LODE_INLINE bool lode_estimator_is_sound(const lode_estimator_t *self,
                                         const lode_estimator_tuning_t *tuning, float length2) {
    return lode_abs(self->pll.omega_rad_s) <= tuning->omega_limit &&
           lode_abs(length2 - 1.0f) <= 0.25f;
}

// Lock quality of the source with the larger weight.
LODE_INLINE float lode_estimator_quality(lode_estimator_t *self,
                                         const lode_estimator_tuning_t *tuning, float by_emf) {
#ifndef LODE_WITHOUT_HFI
    if (lode_estimator_injects(self)) {
        const float own = lode_hfi_quality(&self->by.hfi, &tuning->hfi, tuning->lock_weight);
        return self->by.hfi.weight < 0.5f ? by_emf : own;
    }
#else
    (void)self;
    (void)tuning;
#endif
    return by_emf;
}

// SLOT_LOCK. Two independent criteria (P17): the EMF's amplitude against the one that the speed induces, and the cosine of the
// EMF's angle against the PLL's. The worse one counts.
LODE_INLINE void lode_estimator_note_lock(lode_estimator_t *self,
                                          const lode_estimator_tuning_t *tuning) {
    const float length2 = lode_angle_length2(self->pll.frame);
    if (!lode_estimator_is_sound(self, tuning, length2)) {
        lode_estimator_restart(self, tuning);
        return;
    }
    const lode_ab_t e_V = self->emf.observer.e_V;
    const float omega = self->pll.omega_rad_s;
    const lode_sincos_t frame = lode_angle_normalise(self->pll.frame);
    // The observer reduces the amplitude; C-LESO by 1 + (w/w0)^2.
    const float taken = lode_estimator_droop(tuning, omega);
    const float inv_e0 = 1.0f / (lode_max(lode_ab_length(e_V), tuning->emin_V) * taken);
    const float size = inv_e0 * taken;
    const float per_V = omega < 0.0f ? size : -size;
    const float cosine = lode_park(e_V, frame).q * -per_V;
    const float induced_V = lode_abs(omega) * (tuning->psi_Wb + tuning->salient_H * self->id_A);
    const float slip = induced_V * inv_e0 - 1.0f;
    const float level = 1.0f - LEVEL_SLOPE * lode_abs(slip);
    const float by_emf = lode_clamp(lode_min(level, cosine), 0.0f, 1.0f);
    const float quality = lode_estimator_quality(self, tuning, by_emf);
    const float lock =
        lode_clamp(self->lock + tuning->lock_weight * (quality - self->lock), 0.0f, 1.0f);
    self->pll.frame = frame;
    self->per_V = per_V;
    self->lock = lock;
    // A loop that starts at zero speed may seem locked while it passes a turning rotor; so an angle must have been found
    // before.
    self->locked = lock >= LODE_LOCK_LOST && (self->found > 0u || lode_estimator_injects(self));
    self->aligned = lock >= LOCK_ALIGNED;
    if (lode_estimator_injects(self)) {
        return;
    }
#ifndef LODE_WITHOUT_BRAKE_SLIP
    if (slip > SLIP_MIN) {
        // By the slip that was seen: what the first one changes, the second one sees in the frame.
        lode_estimator_brake_slip(self, tuning, slip);
        lode_estimator_limit_slip(self, tuning, slip);
    }
#endif
    if (self->locked) {
        self->by.alone.wait = tuning->patience_rounds;
        self->by.alone.rotation = (lode_ab_t){0.0f, 0.0f};
        self->by.alone.before_V = (lode_ab_t){0.0f, 0.0f};
    } else {
        lode_estimator_wait(self, tuning);
    }
}

// SLOT_GAINS. Without lock the notches stay: with a centre far above sigma the loop is stable at any speed, and the worst-case
// period of a start takes 110 cycles less.
LODE_INLINE void lode_estimator_adapt_notches(lode_estimator_t *self,
                                              const lode_estimator_tuning_t *tuning) {
#ifdef LODE_WITHOUT_NOTCH
    (void)self;
    (void)tuning;
#else
    if (lode_estimator_asks(tuning->options, LODE_ESTIMATOR_NOTCH) && self->locked &&
        !lode_estimator_injects(self)) {
        const float omega = self->pll.omega_rad_s;
        lode_notch_adapt(&self->by.alone.notch, &tuning->notch, tuning->notch.k, omega);
        if (lode_estimator_asks(tuning->options, LODE_ESTIMATOR_NOTCH12)) {
            lode_notch_adapt(&self->by.alone.notch12, &tuning->notch, tuning->notch12_k,
                             2.0f * omega);
        }
    }
#endif
}

// End of SLOT_GAINS: the next check counts from here. Without lock, the motion may be acquired anew.
LODE_INLINE void lode_estimator_note_motion(lode_estimator_t *self) {
    const bool checked = self->locked && !lode_estimator_injects(self);
    self->omega_noted = checked ? self->pll.omega_rad_s : 0.0f;
    self->f_noted = self->pll.f_rad_s2;
}

// SLOT_GAINS, before the gains change: speed and disturbance have moved no more than the PLL can move them in a round (P30).
// Otherwise memory was corrupted. The known acceleration counts only where errors alone do not explain the motion.
LODE_INLINE bool lode_estimator_motion_ok(const lode_estimator_t *self,
                                          const lode_estimator_tuning_t *tuning) {
    const bool small =
        lode_abs(self->pll.f_rad_s2 - self->f_noted) <= ROUND_ERROR * self->gains.f_s2 &&
        lode_abs(self->pll.omega_rad_s - self->omega_noted) <= ROUND_ERROR * self->gains.omega_s;
    return !self->locked || small || lode_estimator_may_move(self, tuning);
}

// Clears the disturbance states for a QPLL, which does not have them.
LODE_INLINE void lode_estimator_drop_disturbance(lode_estimator_t *self,
                                                 const lode_estimator_tuning_t *tuning) {
    if (tuning->pll.third_order == 0u) {
        self->pll.f_rad_s2 = 0.0f;
        self->pll.rise_rad_s = 0.0f;
    }
}

// SLOT_GAINS, without injection.
LODE_INLINE void lode_estimator_adapt_gains(lode_estimator_t *self,
                                            const lode_estimator_tuning_t *tuning) {
    self->gains = lode_pll_gains(&tuning->pll, self->pll.omega_rad_s);
    lode_estimator_drop_disturbance(self, tuning);
}

// SLOT_LAG
LODE_INLINE void lode_estimator_adapt_lag(lode_estimator_t *self,
                                          const lode_estimator_tuning_t *tuning) {
    self->lag = lode_lag_line(&tuning->lag, self->pll.omega_rad_s);
}

#endif
