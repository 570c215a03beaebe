// One period of a drive, in the order of its work: estimation and current control, shared by the steps for three and six
// phases. Sensing and modulation differ (drive.c, drive6.c); the slow jobs are in drive_slots_inline.h.
#ifndef LODE_DRIVE_INLINE_H
#define LODE_DRIVE_INLINE_H

#include "current_inline.h"
#include "drive_parts.h"
#include "drive_speed_inline.h"
#include "estimator_inline.h"
#include "guard_inline.h"
#include "inverter_inline.h"
#include "mode.h"
#include "modulator_inline.h"
#include "plausibility_inline.h"
#include "references_inline.h"
#include "sense_inline.h"

#include <stddef.h>

// The frame in which the currents are controlled.
typedef struct {
    lode_sincos_t at;      // its angle at t_k
    lode_dq_t i_A;         // current in it at t_k
    lode_sincos_t applied; // its angle in the middle of the period in which the duties act
    float omega_rotor;     // electrical speed of the rotor's frame; 0 in any other
} lode_frame_t;

// A vector of the last period, turned with the rotor to t_k (first order).
LODE_INLINE lode_ab_t lode_drive_turned(const lode_estimator_t *estimator,
                                        const lode_drive_tuning_t *tuning, lode_ab_t x) {
    const float turn_rad = tuning->estimator.pll.ts_s * estimator->pll.omega_rad_s;
    return lode_ab_add_scaled(x, turn_rad, (lode_ab_t){-x.beta, x.alpha});
}

// (K38). Call after everything else that moves the observer's last current. The last innovation is turned with the rotor;
// without that, two machines of the catalogue would exceed the limit in every period at high speed.
LODE_INLINE void lode_drive_watch_jump(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                       lode_ab_t u_V, lode_ab_t i_A) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)tuning;
    (void)u_V;
    (void)i_A;
#else
    const lode_ab_t innovation_V =
        lode_emf_innovation(&self->estimator.emf, &tuning->estimator.emf, u_V, i_A);
    const lode_ab_t jump_V = lode_ab_subtract(
        innovation_V, lode_drive_turned(&self->estimator, tuning, self->jump.innovation_V));
    const float jump_V2 = lode_ab_length2(jump_V);
    self->jump.change_V2 = jump_V2;
    if (jump_V2 > tuning->plausibility.jump_V2 &&
        lode_drive_note_jump(self, (lode_ab_t){i_A.alpha, i_A.beta}, jump_V)) {
        return;
    }
    self->jump.innovation_V = innovation_V;
#endif
}

// False: a jump is confirmed, and the drive is in FAULT.
LODE_INLINE bool lode_drive_jump_ok(lode_drive_t *self) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    return true;
#else
    return self->jump.stage == (uint_least8_t)LODE_JUMP_NONE || lode_drive_wait_jump(self);
#endif
}

// Angle and speed at t_k. `u_V`: mean voltage over [t_k-1, t_k); `i_A`: current at t_k.
LODE_INLINE lode_estimate_t lode_drive_find(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                            lode_ab_t u_V, lode_ab_t i_A) {
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (lode_references_has(&tuning->references, LODE_REFERENCES_SATURATE)) {
        lode_drive_lessen_saturated(self, (lode_ab_t){i_A.alpha, i_A.beta});
    }
#endif
    lode_drive_watch_jump(self, tuning, u_V, i_A);
    return lode_estimator_fast(&self->estimator, &tuning->estimator, u_V, i_A);
}

// The rotor's frame, at t_k and while the duties act.
LODE_INLINE lode_frame_t lode_drive_rotor_frame(const lode_drive_t *self,
                                                const lode_estimate_t *estimate) {
    return (lode_frame_t){estimate->rotor, estimate->i_A,
                          lode_angle_add(estimate->rotor, self->lead), estimate->omega_rad_s};
}

// The frame of a mode that has its own, e.g. the start's vector.
LODE_INLINE lode_frame_t lode_drive_control_frame(lode_drive_t *self, const lode_sample_t *sample) {
    const lode_control_frame_t own = lode_mode_control_frame(self);
    self->i_A = lode_park(sample->i_A, own.at);
    return (lode_frame_t){own.at, self->i_A, lode_angle_add(own.at, own.lead), 0.0f};
}

LODE_INLINE bool lode_drive_is_steady(const lode_drive_t *self) {
    return LODE_USUALLY(self->steady); // the hint saves 5 cycles of c_leso_qpll
}

// For modes that are not steady: their frame of control, and speed control that runs more than once per round. True: the mode
// gives the voltage itself.
LODE_INLINE bool lode_drive_by_mode(lode_drive_t *self, const lode_sample_t *sample,
                                    lode_frame_t *frame) {
    const bool runs = lode_mode(self) == LODE_MODE_RUN;
    if (!runs && !lode_estimator_injects(&self->estimator)) { // with injection: the rotor's frame
        *frame = lode_drive_control_frame(self, sample);
    }
    if (runs && !lode_drive_speed_once(self)) {
        lode_drive_fast_speed(self);
    }
    return lode_mode_is_voltage(self);
}

// Bus voltage left for current control, after the reserve for injection.
LODE_INLINE float lode_drive_left_V(const lode_drive_t *self, float v_bus_V) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return v_bus_V;
#else
    return v_bus_V - self->estimator.by.hfi.reserve_V;
#endif
}

// Current control of a period with the gates on. `given`: the command gives the voltage. True: no duty can reach a rail.
LODE_INLINE bool lode_drive_control(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                    const lode_frame_t *frame, float v_bus_V, bool given) {
    if (given) {
        return lode_current_is_free(&tuning->current, self->u_V, v_bus_V);
    }
    const lode_dq_t induced_V = lode_references_induced_V(&tuning->references, self->current.Lq_H,
                                                          frame->i_A, frame->omega_rotor);
    const lode_current_out_t out = lode_current_step(&self->current, &tuning->current, self->ref_A,
                                                     frame->i_A, induced_V, v_bus_V);
    self->u_V = out.u_V;
    return out.free;
}

// What the modulator has to make, in the frame of control.
typedef struct {
    lode_dq_t u_V;
    lode_dq_t i_A; // expected while the duties act: for the dead-time correction
} lode_demand_t;

// Share of its way to the reference that the current covers in the 1.5 periods from its sample to the middle of the duties'
// period (I11): 1 - exp(-1.5 * 0.2) with the default bandwidth of current control.
#define MOVED_SHARE 0.26f

// Voltage of current control, plus the wave of injection.
LODE_INLINE lode_demand_t lode_drive_demand(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                            const lode_frame_t *frame) {
#ifndef LODE_WITHOUT_HFI
    if (lode_estimator_injects(&self->estimator)) {
        // The reference stands for the mean current: the measured mean is two periods old. Dead-time correction by it
        // switched late near zero and left 0.25 V of EMF error across the rotor (H19).
        return (lode_demand_t){
            lode_hfi_add_wave(&self->estimator.by.hfi, &tuning->estimator.hfi, self->u_V),
            self->ref_A};
    }
#else
    (void)tuning;
#endif
    const lode_dq_t i_A = frame->i_A;
    const lode_dq_t error_A = {self->ref_A.d - i_A.d, self->ref_A.q - i_A.q};
    return (lode_demand_t){self->u_V,
                           {i_A.d + MOVED_SHARE * error_A.d, i_A.q + MOVED_SHARE * error_A.q}};
}

#endif
