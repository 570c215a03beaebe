// Shared by the steps for three and six phases: estimation, current control, the slow jobs and the last check of the duties.
// Sensing and modulation differ (drive.c, drive6.c).
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

// Below this multiple of the lowest speed, a sensorless drive that stops or reverses leaves RUN.
#define HAND_BACK_SHARE 1.15f
#define SOUND_LOCK 0.9f // the EMF is off by less than 8 %
#define PER_SHARE (1.0f / (float)LODE_TORQUE_SHARE_ONE)

// The frame in which the currents are controlled.
typedef struct {
    lode_sincos_t at;      // its angle at t_k
    lode_dq_t i_A;         // current in it at t_k
    lode_sincos_t applied; // its angle in the middle of the period in which the duties act
    float omega_rotor;     // electrical speed of the rotor's frame; 0 in any other
} lode_frame_t;

// In drive_config.c. Checks the values that the design functions divide by.
lode_status_t lode_drive_check_given(const lode_drive_config_t *config);
// Default of current.voltage_use; `sense` must be designed already.
float lode_drive_voltage_use(const lode_drive_config_t *config);
// Tunes the signal check for the inductances of `motor`.
lode_status_t lode_drive_tune_signal_check(lode_drive_tuning_t *t, const lode_drive_config_t *c,
                                           const lode_motor_t *motor, const lode_fly_tuning_t *fly);

// In drive.c. Tells the interrupt that something is posted.
void lode_drive_notify(lode_drive_t *self);
// For duties beyond lode_sense_tuning_t.duty_max: updates `omitted` of their set. False: the duties are invalid, and the
// drive is in FAULT.
bool lode_drive_accept(lode_drive_t *self, uint_least8_t *omitted, const lode_abc_t *duty);
// Speed control where it runs more than once per round. Comes before current control.
void lode_drive_fast_speed(lode_drive_t *self);
// Share of the start current of the hand-over that remains at the next call of speed control.
float lode_drive_faded(const lode_drive_t *self);
// Target of speed control with a sensor, or for torque control.
float lode_drive_other_target(lode_drive_t *self, float omega_rad_s, float load_Nm);
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
// References with MTPA, field weakening, a bus fade or a saturating q axis.
void lode_drive_optimal_references(lode_drive_t *self);
// With a saturating q axis. The first removes the EMF of the lacking flux from the period up to t_k (E31). The second renews
// the lag; as long as (E31) waits for a lock, it adds the angle by which that flux turns the observed EMF (R17).
void lode_drive_lessen_saturated(lode_drive_t *self, lode_ab_t i_A);
void lode_drive_adapt_saturated_lag(lode_drive_t *self);
#endif

// In drive_watch.c: rare cases. A sample failed the guard's fast checks; a trip switches off at once.
void lode_drive_diagnose(lode_drive_t *self, const lode_sense_t *sense,
                         const lode_sample_t *sample);
// The guard's slow checks have found something to count.
void lode_drive_check_slow(lode_drive_t *self);
// Counts the rounds in which the readings of temperature and bus do not change.
void lode_drive_count_still(lode_drive_t *self, uint16_t count, float v_bus_V);
// A current of a set has kept its count, or their sum is too large.
void lode_drive_suspect(lode_drive_t *self, lode_plausibility_t *watch,
                        const int32_t i[LODE_PHASES], float checks);
// In START with three phases: checks that each phase carries both half-waves. False, as below (except
// lode_drive_note_jump()): the drive is in FAULT.
bool lode_drive_note_waves(lode_drive_t *self, const int32_t i[LODE_PHASES]);
// The current vector has hardly moved since an earlier check.
bool lode_drive_doubt_frozen(lode_drive_t *self);
// The current has jumped: `jump_V` would have had to act in addition to voltage and EMF. True: the sample is kept out of the
// EMF.
bool lode_drive_note_jump(lode_drive_t *self, lode_ab_t i_A, lode_ab_t jump_V);
// In each period after a jump, until it is decided.
bool lode_drive_wait_jump(lode_drive_t *self);
// In RUN: a load beyond all torque, an EMF that the magnets' flux does not explain, a phase without a half-wave.
bool lode_drive_watch_load(lode_drive_t *self);
bool lode_drive_judge_flux(lode_drive_t *self);
bool lode_drive_watch_half_waves(lode_drive_t *self);

// One period, in the order of its work.

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

// Speed control and references run once per round, in their slots.
LODE_INLINE bool lode_drive_speed_once(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_FAST_SPEED
    (void)self;
    return true;
#else
    return self->tuning->speed_periods == LODE_SLOW_PERIODS;
#endif
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

// Speed control and references: in their slots, or more often.

// The references' torque range, reduced by the application's limits.
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

// First part of the references: the flux limit.
LODE_INLINE void lode_drive_limit_flux(lode_drive_t *self) {
    const lode_references_voltage_t voltage = {self->inverter.v_bus_V, self->u_V};
    lode_references_limit(&self->state.run.references, &self->tuning->references,
                          self->estimator.pll.omega_rad_s, voltage);
}

// One call of speed control, at the electrical speed `omega_rad_s`.
LODE_SHARED void lode_drive_speed(lode_drive_t *self, float omega_rad_s) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_running_t *run = &self->state.run;
    const float load_Nm = lode_estimator_load_torque_Nm(&self->estimator, &tuning->estimator);
    const float least = tuning->omega_min * tuning->speed.inv_pole_pairs;
    float target = lode_max(self->command.speed_rad_s * self->direction, least) * self->direction;
    if (run->fade > 0.0f) { // hold the speed while the start current fades
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

// Speed for the fade of the id bias (K10). A coarse sensor with edges removes the bias: no EMF needs it, and with such an
// angle a negative id pushes the rotor away from its position.
LODE_INLINE float lode_drive_bias_omega(const lode_drive_t *self) {
    const float omega = self->estimator.pll.omega_rad_s;
    return lode_mode_is_sensored(self) && self->edges ? lode_sign(omega) * NO_BIAS_rad_s : omega;
}

// Second part: id for the torque.
LODE_INLINE void lode_drive_free_id(lode_drive_t *self) {
    lode_running_t *run = &self->state.run;
    lode_references_free(&run->references, &self->tuning->references, run->speed.torque_Nm,
                         lode_drive_bias_omega(self), run->fade * run->id_A,
                         self->inverter.v_bus_V);
}

// Last part: currents and torque range.
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

// The slow jobs, slot by slot (schedule.h). False: the gates are off.

// One round less until the start counts as proven.
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
    if (lode_references_has(&tuning->references, LODE_REFERENCES_SATURATE)) {
        lode_drive_adapt_saturated_lag(self);
        return;
    }
#endif
    // Renewed in each round, as with saturation: a corrupted value does not last.
    lode_current_renew(&self->current, &tuning->current, tuning->references.Lq_H);
    lode_estimator_adapt_lag(&self->estimator, &tuning->estimator);
}

LODE_INLINE void lode_drive_lead(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    // Half a period's angle times three: from the sample to the middle of its duties' period.
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
        return; // the rest a round later: together 1459 cycles, the worst-case call of a start
    }
    lode_drive_adapt_gains(self, tuning);
    lode_mode_count_sensor(self);
    lode_estimator_adapt_notches(&self->estimator, &tuning->estimator);
}

// Too slow to stay in RUN, and no speed in this direction is commanded.
LODE_INLINE bool lode_drive_is_too_slow(const lode_drive_t *self) {
    return !lode_mode_is_sensored(self) && !(self->command.speed_rad_s * self->direction > 0.0f) &&
           lode_abs(self->estimator.pll.omega_rad_s) <= HAND_BACK_SHARE * self->tuning->omega_min;
}

LODE_INLINE void lode_drive_run(lode_drive_t *self) {
    if (lode_drive_is_too_slow(self)) {
        lode_mode_hand_back(self);
    } else if (lode_drive_speed_once(self)) {
        // Mean of two speeds half a round apart (the first is that of the lag): less ripple and noise of the position error
        // aliases.
        const lode_estimator_t *estimator = &self->estimator;
        lode_drive_speed(self, 0.5f * (estimator->lag.omega_rad_s + estimator->pll.omega_rad_s));
        lode_drive_free_id(self);
    } else {
        // more than once per round: in lode_drive_fast_speed()
    }
}

// Otherwise they follow speed control in lode_drive_fast_speed().
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
    const int32_t copy[LODE_PHASES] = {i[0], i[1], i[2]}; // a copy, as in lode_drive_watch()
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

// Checks that the readings of temperature and bus change, as noise alone makes healthy ones do.
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

// Plausibility of a set's currents (1/256 count). The last check was `checks` times LODE_GUARD_PERIODS ago.
LODE_INLINE void lode_drive_watch(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                  lode_plausibility_t *watch, const int32_t i[LODE_PHASES],
                                  float checks) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)tuning;
    (void)watch;
    (void)i;
    (void)checks;
#else
    if (!lode_plausibility_is_on(&tuning->plausibility)) {
        return;
    }
    if (lode_plausibility_all_move(watch, &tuning->plausibility, i)) {
        lode_plausibility_note(watch, i, 0u);
    } else {
        // A copy: a sample passed by address would be kept in memory in every period.
        const int32_t copy[LODE_PHASES] = {i[0], i[1], i[2]};
        lode_drive_suspect(self, watch, copy, checks);
    }
#endif
}

// Checks for a frozen current vector (K36).
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

// Input of the guard's slow checks.
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

// One slot; runs after the duties are made. `words`: the complete tuning, for the memory check; `tuning` is all of it or a
// part.
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
