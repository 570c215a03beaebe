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

// Amplitude beyond any motor's EMF: NaN and Inf fall outside.
#define EMF_LIMIT_V 1.0e6f
// The EMF of a changing active flux is taken out from this lock quality on: the angle is within some 65
// degrees. Where that ended with the lock, an angle on its way back was found by an EMF that the rise of the
// current had turned, at a speed 60 % off. Simulated: 0.3 to 0.4 lose none of 220 starts, 0.25 one; of
// starts that hand over at 100 of 1500 rpm 193 to 194 of 200 succeed.
#define LOCK_ALIGNED 0.4f
// Beyond this the position error is not the sine of any angle.
#define SINE_MAX 1.1f
// Falls from 1 to LODE_LOCK_LOST where the EMF is 40 % off what the speed induces.
#define LEVEL_SLOPE 1.25f
// Beyond so many times omega_max a speed is taken for an alias.
#define LODE_ALIAS_SHARE 2.0f
// By so much an EMF may be less than the speed induces for want of the true parameters, and no more (P24).
#define SLIP_MIN 0.2f

LODE_INLINE bool lode_estimator_asks(uint32_t options, int option) {
    return (options & (uint32_t)option) != 0u;
}

// Rare parts, in estimator.c. What they take and give by value is copied where they are called: such copies share
// one place on the step's stack, while a variable that lives on has 8 bytes of its own in every period. With
// those of observers and current control, 48 bytes and 8 cycles less.
void lode_estimator_restart(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
void lode_estimator_note_rotation(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
lode_sincos_t lode_estimator_filtered_step(lode_estimator_t *self,
                                           const lode_estimator_tuning_t *tuning,
                                           float omega_rad_s);
float lode_estimator_look_again(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                                lode_sincos_t frame);
// A large position error of a period that injects.
float lode_estimator_limit(const lode_estimator_t *self, float error);
// A PLL that is faster by `slip` than the EMF says.
void lode_estimator_brake_slip(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                               float slip);
void lode_estimator_move_lag(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                             float omega_rad_s);
// With angle and speed at t_k found by other means than the EMF.
void lode_estimator_begin_at(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                             lode_sincos_t rotor, float omega_rad_s);
// Another tuning takes the place of `before`: another observer begins with the rotor's present EMF, and injection that `now` has
// not ends.
void lode_estimator_retune(lode_estimator_t *self, const lode_estimator_tuning_t *before,
                           const lode_estimator_tuning_t *now);
void lode_estimator_wait(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
// The EMF alone from now on.
void lode_estimator_end_injection(lode_estimator_t *self, const lode_estimator_tuning_t *tuning);
// `held`: whatever the torque, the rotor keeps the speed that it has.
bool lode_estimator_seed(lode_estimator_t *self, const lode_estimator_tuning_t *tuning, bool held);

#ifndef LODE_WITHOUT_PLAUSIBILITY
// Active flux linkage of the motor as configured, and as the EMF's size tells it.
typedef struct {
    float expected_Wb;
    float seen_Wb;
    bool aligned; // the EMF is within 25 degrees of where the PLL has it
} lode_flux_t;

lode_flux_t lode_estimator_flux(const lode_estimator_t *self,
                                const lode_estimator_tuning_t *tuning);

// The observer's EMF less that of the active flux where the PLL has it.
lode_ab_t lode_estimator_beyond_V(const lode_estimator_t *self,
                                  const lode_estimator_tuning_t *tuning);
#endif

// How many times larger the EMF is than the observer's estimate of it, in steady rotation.
LODE_INLINE float lode_estimator_droop(const lode_estimator_tuning_t *tuning, float omega_rad_s) {
    return 1.0f + omega_rad_s * omega_rad_s * tuning->droop_s2;
}

LODE_INLINE float lode_estimator_load_torque_Nm(const lode_estimator_t *self,
                                                const lode_estimator_tuning_t *tuning) {
    return tuning->load_per_f_Nm * self->pll.f_rad_s2;
}

// Position by signal injection, wholly or in part.
LODE_INLINE bool lode_estimator_injects(const lode_estimator_t *self) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return false;
#else
    return self->by.hfi.active;
#endif
}

// It has an angle, or had one until the lock went. It begins anew without one where its state is not that of a motor: an estimate
// that runs away, or memory that has changed.
LODE_INLINE bool lode_estimator_has_rotor(const lode_estimator_t *self) {
    return self->found > 0u || lode_estimator_injects(self);
}

// Sine and cosine of the rotor's angle at t_k.
LODE_SHARED lode_sincos_t lode_estimator_rotor(const lode_estimator_t *self) {
    return lode_angle_add(self->pll.frame, lode_lag_near(&self->lag, self->pll.omega_rad_s));
}

// The EMF at t_k from the dead-beat one. `step`: rotation by the motion's angle.
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
        // (G1): at the speed predicted, not at the mean of the period.
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

// From no ripple at all.
LODE_INLINE void lode_estimator_clear_notches(lode_estimator_t *self) {
#ifdef LODE_WITHOUT_NOTCH
    (void)self;
#else
    self->by.alone.notch.sogi = self->by.alone.notch12.sogi = (lode_sogi_t){0.0f, 0.0f};
#endif
}

// The position error without the harmonics of the EMF, which show in it at 6 w and 12 w.
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

// Known acceleration over the period to come (P3), rad/s^2: torque of the measured current, seen from
// where the rotor is by the position error (P19), and friction.
LODE_INLINE float lode_estimator_acceleration(const lode_estimator_tuning_t *tuning, lode_dq_t i_A,
                                              float error, float omega_rad_s) {
    const float flux_Wb = tuning->psi_Wb + tuning->salient_H * i_A.d;
    const float swing = lode_max(tuning->salient_H * i_A.q * i_A.q - flux_Wb * i_A.d, 0.0f);
    return tuning->acc_per_torque * (flux_Wb * i_A.q + swing * error) -
           tuning->acc_per_omega * omega_rad_s;
}

// What is known after lode_estimator_restart(): the current, by an angle of 0.
LODE_INLINE lode_estimate_t lode_estimator_nothing(const lode_estimator_t *self) {
    return (lode_estimate_t){.rotor = self->pll.frame,
                             .i_A = {self->emf.i_A.alpha, self->emf.i_A.beta},
                             .reseeded = true,
                             .source = LODE_ESTIMATE_OWN};
}

// Of a period that went well.
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

// The dead-beat EMF without that of a changing active flux. `frame`: of the PLL as predicted for t_k; `half`:
// rotation by half of the motion's angle. `by_wave`: the position error by injection too, in its state.
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
    // By the lag that id_A was seen with: a difference would pass for a rise of the current.
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

// The position error of a period that injects, `error` by the EMF.
LODE_INLINE float lode_estimator_blend(const lode_estimator_t *self, float error) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return error;
#else
    return lode_hfi_blend(&self->by.hfi, error);
#endif
}

// The current of control at t_k.
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

// Of a period that injects: the torque of its current is known, with its sign.
LODE_INLINE bool lode_estimator_knows_torque(const lode_estimator_t *self) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return true;
#else
    return self->by.hfi.step != (uint_least8_t)LODE_HFI_PUSH;
#endif
}

// The fast part of a period. `by_wave`: it injects.
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

    // Phase detector (paper 1, eq. 13; P1) with the sign of speed, or it locks half a turn off. The
    // amplitude is the one last computed; where the error is large, or not finite, it is computed now.
    const float across_V = lode_park(e_V, frame).d;
    const float by_emf = across_V * self->per_V;
    float error = by_wave ? lode_estimator_blend(self, by_emf)
                          : lode_estimator_notched(self, tuning, options, by_emf);
    const float small = by_wave ? LODE_HFI_ERROR_MAX_rad : tuning->error_small;
    if (!(lode_abs(error) <= small)) {
        const lode_sincos_t copy = {frame.sin, frame.cos};
        error = by_wave ? lode_estimator_limit(self, error)
                        : lode_estimator_look_again(self, tuning, copy);
        if (!(lode_abs(error) <= SINE_MAX)) {
            lode_estimator_restart(self, tuning);
            return lode_estimator_nothing(self);
        }
        frame = lode_angle_shorten(frame, self->gains.theta * error);
    }
    lode_pll_correct(&self->pll, self->gains, frame, motion.omega_rad_s, error);
    // In every period: looked at after large errors only (-6 cycles), field weakening took 17.7 A where it takes
    // 17.3 and was asked for 16.
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

// The fast part of a period. Twice, and without a test in either; as a call of its own what injects took 68 cycles
// more.
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

// The state is that of a motor: a rotation of about length 1 and a speed within limits. NaN is not.
LODE_INLINE bool lode_estimator_is_sound(const lode_estimator_t *self,
                                         const lode_estimator_tuning_t *tuning, float length2) {
    return lode_abs(self->pll.omega_rad_s) <= tuning->omega_limit &&
           lode_abs(length2 - 1.0f) <= 0.25f;
}

// That of the source with the larger weight.
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

// SLOT_LOCK. Two independent signs: the EMF's amplitude against what the speed induces, and the cosine
// of the angle between the EMF and where the PLL has it. The worse one counts.
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
    // The observer takes its part of the amplitude; C-LESO 1 + (w/w0)^2.
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
    // A loop that begins at no speed may seem to lock on its way past a rotor that turns.
    self->locked = lock >= LODE_LOCK_LOST && (self->found > 0u || lode_estimator_injects(self));
    self->aligned = lock >= LOCK_ALIGNED;
    if (lode_estimator_injects(self)) {
        return;
    }
#ifndef LODE_WITHOUT_BRAKE_SLIP
    if (slip > SLIP_MIN) {
        lode_estimator_brake_slip(self, tuning, slip);
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

// SLOT_GAINS. Without lock they stay: a centre far above sigma leaves the loop stable at any speed, and the
// worst-case period of a start takes 110 cycles less.
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

// The QPLL has no such states.
LODE_INLINE void lode_estimator_drop_disturbance(lode_estimator_t *self,
                                                 const lode_estimator_tuning_t *tuning) {
    if (tuning->pll.third_order == 0u) {
        self->pll.f_rad_s2 = 0.0f;
        self->pll.rise_rad_s = 0.0f;
    }
}

// SLOT_GAINS, by the EMF.
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
