// What the steps for three and for six phases share: estimation, current control, the slow jobs and the
// last check. Sensing and modulation are the windings' own (drive.c, drive6.c).
#ifndef LODE_DRIVE_INLINE_H
#define LODE_DRIVE_INLINE_H

#include "current_inline.h"
#include "estimator_inline.h"
#include "guard_inline.h"
#include "inverter_inline.h"
#include "mode.h"
#include "modulator_inline.h"
#include "plausibility_inline.h"
#include "references_inline.h"
#include "sense_inline.h"
#include "speed_inline.h"

#include <stddef.h>

// Sensorless running goes over to the way down from this much above the least speed.
#define HAND_BACK_SHARE 1.15f
#define SOUND_LOCK 0.9f // an EMF that is off by less than 8 %
#define PER_SHARE (1.0f / (float)LODE_TORQUE_SHARE_ONE)

// The frame in which the currents are controlled.
typedef struct {
    lode_sincos_t at;      // its angle at t_k
    lode_dq_t i_A;         // current in it at t_k
    lode_sincos_t applied; // its angle in the middle of the period in which the duties act
    float omega_rotor;     // electrical speed where it is the rotor's, else 0
} lode_frame_t;

// In drive_config.c. Checks of a configuration that design divides by.
lode_status_t lode_drive_check_given(const lode_drive_config_t *config);
// Default of current control's voltage_use, with `sense` designed.
float lode_drive_voltage_use(const lode_drive_config_t *config);
// The signal check, with the inductances of `motor`.
lode_status_t lode_drive_tune_signal_check(lode_drive_tuning_t *t, const lode_drive_config_t *c,
                                           const lode_motor_t *motor, const lode_fly_tuning_t *fly);

// In drive.c. Tells the interrupt that there is mail.
void lode_drive_call(lode_drive_t *self);
// Duties that lode_sense_tuning_t.duty_max does not allow: `omitted` of their set follows. False: they are none, and the
// drive is in FAULT.
bool lode_drive_accept(lode_drive_t *self, uint_least8_t *omitted, const lode_abc_t *duty);
// Speed control where it comes more often than once in a round: before current control.
void lode_drive_fast_speed(lode_drive_t *self);
// The rest of the start current, of what it was at hand-over, a round on.
float lode_drive_faded(const lode_drive_t *self);
// Target of speed control with a sensor, or for torque control.
float lode_drive_other_target(lode_drive_t *self, float omega_rad_s, float load_Nm);
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
// References of more than plain id* = 0.
void lode_drive_optimal_references(lode_drive_t *self);
// Where the q axis saturates: takes the EMF of the flux that it lacks out of the period to t_k (E31), and the lag with
// what the lack turns the observed angle by (R17), as long as (E31) waits for a lock.
void lode_drive_lessen_saturated(lode_drive_t *self, lode_ab_t i_A);
void lode_drive_adapt_saturated_lag(lode_drive_t *self);
#endif

// In drive_watch.c: what is rare. Something is wrong with a sample: a trip switches off at once.
void lode_drive_diagnose(lode_drive_t *self, const lode_sense_t *sense,
                         const lode_sample_t *sample);
// The guard's slow checks have something to count.
void lode_drive_check_slow(lode_drive_t *self);
// Temperature or bus must move.
void lode_drive_count_still(lode_drive_t *self, uint16_t count, float v_bus_V);
// One of a set's currents has kept its count, or their sum is large.
void lode_drive_suspect(lode_drive_t *self, lode_plausibility_t *watch,
                        const int32_t i[LODE_PHASES], float looks);
// In START, with three phases: whether each has both its half-waves. False, as of all below: the drive is in FAULT.
bool lode_drive_note_waves(lode_drive_t *self, const int32_t i[LODE_PHASES]);
// The current has hardly moved since a look before.
bool lode_drive_doubt_frozen(lode_drive_t *self);
// The current has changed by much at once: `jump_V` would have to act on it beside voltage and EMF. True: the sample is left out
// of the EMF.
bool lode_drive_note_jump(lode_drive_t *self, lode_ab_t i_A, lode_ab_t jump_V);
// In each period after it.
bool lode_drive_wait_jump(lode_drive_t *self);
// In RUN: a load beyond all the torque, another flux than the magnets', three phases without a half-wave.
bool lode_drive_watch_load(lode_drive_t *self);
bool lode_drive_judge_flux(lode_drive_t *self);
bool lode_drive_watch_half_waves(lode_drive_t *self);

// A period, in the order of its work.

// A vector of the last period that turns with the rotor, to the first order.
LODE_INLINE lode_ab_t lode_drive_turned(const lode_estimator_t *estimator,
                                        const lode_drive_tuning_t *tuning, lode_ab_t x) {
    const float turn_rad = tuning->estimator.pll.ts_s * estimator->pll.omega_rad_s;
    return lode_ab_add_scaled(x, turn_rad, (lode_ab_t){-x.beta, x.alpha});
}

// (K38). After what else moves the observer's last current. The innovation of the last period turns with the rotor: without that
// two machines of the catalogue would look at every sample where they are fast.
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

// False: a jump has stayed, and the drive is in FAULT.
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
    if (lode_references_asks(&tuning->references, LODE_REFERENCES_SATURATE)) {
        lode_drive_lessen_saturated(self, (lode_ab_t){i_A.alpha, i_A.beta});
    }
#endif
    lode_drive_watch_jump(self, tuning, u_V, i_A);
    return lode_estimator_fast(&self->estimator, &tuning->estimator, u_V, i_A);
}

// The rotor's frame, and the duties' in it.
LODE_INLINE lode_frame_t lode_drive_rotor_frame(const lode_drive_t *self,
                                                const lode_estimate_t *estimate) {
    return (lode_frame_t){estimate->rotor, estimate->i_A,
                          lode_angle_add(estimate->rotor, self->lead), estimate->omega_rad_s};
}

// The frame of a mode that has its own.
LODE_INLINE lode_frame_t lode_drive_control_frame(lode_drive_t *self, const lode_sample_t *sample) {
    const lode_control_frame_t own = lode_mode_control_frame(self);
    self->i_A = lode_park(sample->i_A, own.at);
    return (lode_frame_t){own.at, self->i_A, lode_angle_add(own.at, own.lead), 0.0f};
}

// Speed control and references have a slot of their own.
LODE_INLINE bool lode_drive_speed_once(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_FAST_SPEED
    (void)self;
    return true;
#else
    return self->tuning->speed_periods == LODE_SLOW_PERIODS;
#endif
}

LODE_INLINE bool lode_drive_is_steady(const lode_drive_t *self) {
    return LODE_USUALLY(self->steady); // 5 cycles of c_leso_qpll
}

// What an unsteady mode has of its own: the frame of control, and speed control in every period. True: it gives the
// voltage itself.
LODE_INLINE bool lode_drive_by_mode(lode_drive_t *self, const lode_sample_t *sample,
                                    lode_frame_t *frame) {
    const bool runs = lode_mode(self) == LODE_MODE_RUN;
    if (!runs && !lode_estimator_injects(&self->estimator)) { // with injection it is the rotor's
        *frame = lode_drive_control_frame(self, sample);
    }
    if (runs && !lode_drive_speed_once(self)) {
        lode_drive_fast_speed(self);
    }
    return lode_mode_is_voltage(self);
}

// The bus voltage whose circle current control may use.
LODE_INLINE float lode_drive_left_V(const lode_drive_t *self, float v_bus_V) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return v_bus_V;
#else
    return v_bus_V - self->estimator.by.hfi.reserve_V;
#endif
}

// Current control of a period with the gates on: the voltage in the frame. `given`: it is the command's.
// True: no duty can reach a rail.
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

// What the modulator goes by, in the frame of control.
typedef struct {
    lode_dq_t u_V;
    lode_dq_t i_A; // tells the dead time's voltage
} lode_asked_t;

// Of the way to its reference, what the current goes in the one and a half periods from its sample to the middle of
// the duties' period: 1 - exp(-1.5 * 0.2) with the default bandwidth of current control (I11).
#define MOVED_SHARE 0.26f

// The voltage of current control, with the wave of injection.
LODE_INLINE lode_asked_t lode_drive_ask(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                        const lode_frame_t *frame) {
#ifndef LODE_WITHOUT_HFI
    if (lode_estimator_injects(&self->estimator)) {
        // The measured current is two periods old: near its zero, where the correction moves it along the d axis,
        // that left 0.25 V of EMF across the rotor (H19).
        return (lode_asked_t){
            lode_hfi_add_wave(&self->estimator.by.hfi, &tuning->estimator.hfi, self->u_V),
            self->ref_A};
    }
#else
    (void)tuning;
#endif
    const lode_dq_t i_A = frame->i_A;
    const lode_dq_t missed_A = {self->ref_A.d - i_A.d, self->ref_A.q - i_A.q};
    return (lode_asked_t){self->u_V,
                          {i_A.d + MOVED_SHARE * missed_A.d, i_A.q + MOVED_SHARE * missed_A.q}};
}

// Speed control and references: in their slots, or more often.

// What is left of the range that the references allow.
LODE_INLINE lode_range_t lode_drive_torque_limits(const lode_drive_t *self, lode_range_t most) {
#ifdef LODE_WITHOUT_TORQUE_LIMITS
    (void)self;
    return most;
#else
    const uint32_t backwards = self->estimator.pll.omega_rad_s < 0.0f ? 1u : 0u;
    const float up = PER_SHARE * (float)self->torque_share[backwards];
    const float down = PER_SHARE * (float)self->torque_share[backwards ^ 1u];
    return (lode_range_t){down * most.min, up * most.max};
#endif
}

// First part of the references: what limits the flux.
LODE_INLINE void lode_drive_limit_flux(lode_drive_t *self) {
    const lode_references_voltage_t voltage = {self->inverter.v_bus_V, self->u_V};
    lode_references_limit(&self->state.run.references, &self->tuning->references,
                          self->estimator.pll.omega_rad_s, voltage);
}

// By the electrical speed `omega_rad_s`.
LODE_SHARED void lode_drive_speed(lode_drive_t *self, float omega_rad_s) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_running_t *run = &self->state.run;
    const float load_Nm = lode_estimator_load_torque_Nm(&self->estimator, &tuning->estimator);
    const float least = tuning->omega_min * tuning->speed.inv_pole_pairs;
    float target = lode_max(self->command.speed_rad_s * self->direction, least) * self->direction;
    if (run->fade > 0.0f) { // while the start current fades, its speed is held
        target = run->speed.reference_rad_s;
        run->fade = lode_drive_faded(self);
    } else if (lode_mode_is_sensored(self) || lode_mode_is_torque(self)) {
        target = lode_drive_other_target(self, omega_rad_s, load_Nm);
    } else {
        // along the ramp
    }
    (void)lode_speed_step(&run->speed, &tuning->speed, target, omega_rad_s, load_Nm);
}

#define NO_BIAS_rad_s 1.0e9f // beyond any fade

// The speed by which the bias of id fades (K10). With the edges of a coarse sensor it is gone: no EMF needs it, and with such an angle
// a negative id pushes the rotor away from where it stands.
LODE_INLINE float lode_drive_bias_omega(const lode_drive_t *self) {
    const float omega = self->estimator.pll.omega_rad_s;
    return lode_mode_is_sensored(self) && self->edges ? lode_sign(omega) * NO_BIAS_rad_s : omega;
}

// With the torque: second part.
LODE_INLINE void lode_drive_free_id(lode_drive_t *self) {
    lode_running_t *run = &self->state.run;
    lode_references_free(&run->references, &self->tuning->references, run->speed.torque_Nm,
                         lode_drive_bias_omega(self), run->fade * run->id_A,
                         self->inverter.v_bus_V);
}

// Last part.
LODE_SHARED void lode_drive_references(lode_drive_t *self) {
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (self->tuning->references.options != 0u) {
        lode_drive_optimal_references(self);
        return;
    }
#endif
    lode_running_t *run = &self->state.run;
    const lode_references_out_t out = lode_references_finish(
        &run->references, &self->tuning->references, run->speed.torque_Nm,
        lode_drive_bias_omega(self), run->fade * run->id_A, self->inverter.v_bus_V);
    self->ref_A = out.i_A;
    run->speed.limit_Nm = lode_drive_torque_limits(self, out.torque_Nm);
}

// What follows speed and load slowly, slot by slot (schedule.h). False: the gates are off.

// RUN proves its start for one round less.
LODE_INLINE void lode_drive_count_proof(lode_drive_t *self) {
#ifdef LODE_WITHOUT_HANDOVER_RETRY
    (void)self;
#else
    if (self->state.run.proving > 0u) {
        self->state.run.proving--;
    }
#endif
}

LODE_INLINE void lode_drive_adapt_lag(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (lode_references_asks(&tuning->references, LODE_REFERENCES_SATURATE)) {
        lode_drive_adapt_saturated_lag(self);
        return;
    }
#endif
    // Anew, as the saturated ones are: one that changes by itself does not last.
    lode_current_renew(&self->current, &tuning->current, tuning->references.Lq_H);
    lode_estimator_adapt_lag(&self->estimator, &tuning->estimator);
}

LODE_INLINE void lode_drive_lead(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    // A third of the time from a sample to the middle of its duties' period, three times.
    const float half_rad = 0.5f * tuning->estimator.pll.ts_s * self->estimator.pll.omega_rad_s;
    self->lead = lode_angle_triple(lode_sincos_small(half_rad));
}

LODE_INLINE bool lode_drive_watch_flux(lode_drive_t *self) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    return true;
#else
    const bool sound = self->estimator.lock >= SOUND_LOCK && self->guard.flux_rounds == 0u;
    return sound || lode_drive_judge_flux(self);
#endif
}

LODE_INLINE bool lode_drive_slot_lag(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    lode_drive_adapt_lag(self, tuning);
    lode_drive_lead(self, tuning);
    if (lode_mode(self) != LODE_MODE_RUN) {
        return true;
    }
    if (lode_references_weakens(&tuning->references) && lode_drive_speed_once(self)) {
        lode_drive_limit_flux(self);
    }
    return lode_drive_watch_flux(self);
}

LODE_INLINE bool lode_drive_slot_dead_time(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                           lode_words_t words) {
    lode_inverter_adapt(&self->inverter, &tuning->inverter, self->u_V);
    if (!lode_mode_memory_ok(self, words)) {
        lode_mode_distrust(self);
        return false;
    }
    if (lode_mode(self) != LODE_MODE_RUN) {
        return true;
    }
    if (!lode_estimator_has_rotor(&self->estimator)) {
        lode_mode_lose_rotor(self);
    }
    return lode_drive_watch_half_waves(self);
}

LODE_INLINE void lode_drive_adapt_gains(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
#ifndef LODE_WITHOUT_HFI
    if (lode_hfi_is_on(&tuning->estimator.hfi) && lode_mode_inject(self)) {
        return;
    }
#endif
    lode_estimator_adapt_gains(&self->estimator, &tuning->estimator);
}

LODE_INLINE void lode_drive_slot_gains(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    if (!self->estimator.locked && lode_mode_seed(self)) {
        return; // an angle is acquired, the rest a round later: together 1459 cycles, the worst-case call of a start
    }
    lode_drive_adapt_gains(self, tuning);
    lode_mode_count_sensor(self);
    lode_estimator_adapt_notches(&self->estimator, &tuning->estimator);
}

// Too slow to run on, and not about to speed up.
LODE_INLINE bool lode_drive_is_too_slow(const lode_drive_t *self) {
    return !lode_mode_is_sensored(self) && !(self->command.speed_rad_s * self->direction > 0.0f) &&
           lode_abs(self->estimator.pll.omega_rad_s) <= HAND_BACK_SHARE * self->tuning->omega_min;
}

LODE_INLINE void lode_drive_run(lode_drive_t *self) {
    if (lode_drive_is_too_slow(self)) {
        lode_mode_hand_back(self);
    } else if (lode_drive_speed_once(self)) {
        // The mean of two samples half a round apart, the first that of the lag: the position error's ripple
        // and noise fold down less.
        const lode_estimator_t *estimator = &self->estimator;
        lode_drive_speed(self, 0.5f * (estimator->lag.omega_rad_s + estimator->pll.omega_rad_s));
        lode_drive_free_id(self);
    } else {
        // more than once in a round: lode_drive_fast_speed() does it
    }
}

// With speed control in every period they are its part.
LODE_INLINE void lode_drive_renew_references(lode_drive_t *self) {
    if (lode_drive_speed_once(self)) {
        lode_drive_references(self);
    }
}

LODE_INLINE bool lode_drive_watch_waves(lode_drive_t *self, const int32_t i[LODE_PHASES]) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)i;
    return true;
#else
    if (lode_mode(self) != LODE_MODE_START ||
        self->state.start.stage != (uint_least8_t)LODE_START_TURN) {
        return true;
    }
    const int32_t copy[LODE_PHASES] = {i[0], i[1], i[2]}; // as lode_drive_watch()
    return lode_drive_note_waves(self, copy);
#endif
}

LODE_INLINE bool lode_drive_slot_references(lode_drive_t *self, const lode_sample_t *sample) {
    if (lode_mode(self) == LODE_MODE_RUN) {
        lode_drive_renew_references(self);
        return true;
    }
    return lode_drive_watch_waves(self, sample->i);
}

// Counts of temperature and bus. Live ones move, by noise alone.
LODE_INLINE void lode_drive_note_still(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                       uint16_t count, float v_bus_V) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)tuning;
    (void)count;
    (void)v_bus_V;
#else
    const uint32_t watched =
        (uint32_t)tuning->guard.still_rounds | (uint32_t)tuning->guard.bus_still_rounds;
    if (watched > 0u) {
        lode_drive_count_still(self, count, v_bus_V);
    }
#endif
}

// The plausibility of a set's currents (1/256 count), `looks` times LODE_GUARD_PERIODS after the last time.
LODE_INLINE void lode_drive_watch(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                  lode_plausibility_t *watch, const int32_t i[LODE_PHASES],
                                  float looks) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)tuning;
    (void)watch;
    (void)i;
    (void)looks;
#else
    if (!lode_plausibility_is_on(&tuning->plausibility)) {
        return;
    }
    if (lode_plausibility_all_move(watch, &tuning->plausibility, i)) {
        lode_plausibility_note(watch, i, 0u);
    } else {
        // A copy: a sample handed over by its address would lie in memory in all periods.
        const int32_t copy[LODE_PHASES] = {i[0], i[1], i[2]};
        lode_drive_suspect(self, watch, copy, looks);
    }
#endif
}

// (K36)
LODE_INLINE bool lode_drive_watch_frozen(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)tuning;
    return true;
#else
    return lode_frozen_moves(&self->frozen, &tuning->plausibility, self->estimator.emf.i_A) ||
           lode_drive_doubt_frozen(self);
#endif
}

// What the guard's slow checks ask for.
LODE_INLINE lode_condition_t lode_drive_condition(const lode_drive_t *self) {
    return (lode_condition_t){self->inverter.v_bus_V,
                              lode_sense_temperature_degC(&self->tuning->sense, self->temperature),
                              self->direction * self->estimator.pll.omega_rad_s,
                              self->estimator.lock};
}

// `other`: temperature count of a second power stage, or of the same one.
LODE_SHARED bool lode_drive_guard(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                  const lode_sample_t *sample, uint16_t other) {
    const uint16_t count = lode_sense_hotter(&tuning->sense, sample->temperature, other);
    self->temperature = count;
    const lode_condition_t condition = lode_drive_condition(self);
    const bool sensorless = lode_mode(self) == LODE_MODE_RUN;
    if (!lode_guard_slow_ok(&self->guard, &tuning->guard, &condition, sensorless)) {
        lode_drive_check_slow(self);
    }
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_drive_watch(self, tuning, &self->plausibility, sample->i, 1.0f);
#endif
    return self->gates;
}

// One slot, after the duties, which do not wait for it. `words`: of the tuning that is watched, of which `tuning` is
// all or a part.
LODE_INLINE bool lode_drive_slow_job(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                     lode_words_t words, const lode_sample_t *sample,
                                     uint16_t other, lode_slot_t slot) {
    switch (slot) {
    case SLOT_LOCK:
        lode_estimator_note_lock(&self->estimator, &tuning->estimator);
#ifndef LODE_WITHOUT_PLAUSIBILITY
        lode_jump_note_noise(&self->jump);
#endif
        if (!lode_drive_watch_frozen(self, tuning)) {
            return false;
        }
        if (lode_mode(self) == LODE_MODE_RUN) {
            lode_drive_count_proof(self);
            return lode_drive_watch_load(self);
        }
        break;
    case SLOT_GUARD:
        lode_drive_note_still(self, tuning,
                              lode_sense_hotter(&tuning->sense, sample->temperature, other),
                              sample->v_bus_V);
        return lode_drive_guard(self, tuning, sample, other);
    case SLOT_LAG:
        return lode_drive_slot_lag(self, tuning);
    case SLOT_DEAD_TIME:
        return lode_drive_slot_dead_time(self, tuning, words);
    case SLOT_GAINS:
        lode_drive_slot_gains(self, tuning);
        break;
    case SLOT_GUARD_2:
        return lode_drive_guard(self, tuning, sample, other);
    case SLOT_SPEED:
        if (lode_mode(self) == LODE_MODE_RUN) {
            lode_drive_run(self);
        }
        break;
    case SLOT_REFERENCES:
        return lode_drive_slot_references(self, sample);
    case SLOT_COUNT:
    default:
        break;
    }
    return true;
}

#endif
