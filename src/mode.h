// The drive's state machine, and the modes that are controlled in a frame of their own.
#ifndef LODE_MODE_H
#define LODE_MODE_H

#include "tuning_check.h"

#include "lodestar/drive.h"

// Frame in which VOLTAGE, CURRENT and START are controlled. Four floats are returned in registers.
typedef struct {
    lode_sincos_t at;   // angle of the frame at t_k
    lode_sincos_t lead; // from there to the middle of the period in which the duties act
} lode_control_frame_t;

#define MODE_BITS 0xffu
#define HALF_BITS 16u
#define HALF_MASK 0xffffu
#define MODE_SHIFT 3u // beyond the flags

static inline lode_mode_t lode_mode(const lode_drive_t *self) {
    return (lode_mode_t)self->mode;
}

// VOLTAGE and CURRENT: a commanded vector in a commanded frame.
static inline bool lode_mode_is_commissioning(lode_mode_t mode) {
#ifdef LODE_WITHOUT_COMMISSIONING
    (void)mode;
    return false;
#else
    return mode == LODE_MODE_VOLTAGE || mode == LODE_MODE_CURRENT;
#endif
}

// VOLTAGE: no current is controlled.
static inline bool lode_mode_is_voltage(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_COMMISSIONING
    (void)self;
    return false;
#else
    return lode_mode(self) == LODE_MODE_VOLTAGE;
#endif
}

// Checksum of an order: a single flipped bit of the order flips one bit of it.
static inline uint_least16_t lode_mode_order_check(const lode_order_t *order) {
#ifdef LODE_WITHOUT_COMMISSIONING
    const union {
        float value[2];
        uint32_t bits[2];
    } all = {{order->speed_rad_s, order->value.torque_Nm}};
    uint32_t sum = all.bits[0] ^ all.bits[1];
#else
    const union {
        float value[4];
        uint32_t bits[4];
    } all = {{order->speed_rad_s, order->theta_rad, order->value.vector.d, order->value.vector.q}};
    uint32_t sum = all.bits[0] ^ all.bits[1] ^ all.bits[2] ^ all.bits[3];
#endif
    sum ^= (uint32_t)order->mode << MODE_SHIFT ^ order->flags;
    return (uint_least16_t)(~(sum ^ sum >> HALF_BITS) & HALF_MASK);
}

// RUN controls the torque.
static inline bool lode_mode_is_torque(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_TORQUE_CONTROL
    (void)self;
    return false;
#else
    return ((uint32_t)self->command.flags & (uint32_t)LODE_ORDER_TORQUE) != 0u;
#endif
}

// Angle and speed come from a sensor.
static inline bool lode_mode_is_sensored(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_ANGLE_SENSOR
    (void)self;
    return false;
#else
    return self->sensored > 0u;
#endif
}

// Counts down to the end of the sensor's estimate; the next estimate restarts the count.
static inline void lode_mode_count_sensor(lode_drive_t *self) {
    if (lode_mode_is_sensored(self)) {
        self->sensored--;
    }
}

static inline bool lode_mode_clears(const lode_order_t *order) {
    return ((uint32_t)order->flags & (uint32_t)LODE_ORDER_CLEAR_FAULT) != 0u;
}

static inline bool lode_mode_clears_fault(const lode_drive_t *self) {
    return self->command.mode == (uint_least8_t)LODE_MODE_OFF && lode_mode_clears(&self->command);
}

// Mode and command match their complement and checksum.
static inline bool lode_mode_is_sound(const lode_drive_t *self) {
    return ((uint32_t)self->mode ^ (uint32_t)self->mode_not) == MODE_BITS &&
           self->command.check == lode_mode_order_check(&self->command);
}

// The flags fit the mode: a wrong flag alone could keep gates on that are to be off. The direction scales the commanded speed
// and must be 1 or -1.
static inline bool lode_mode_fits(const lode_drive_t *self) {
    const uint32_t mode = self->mode;
    const bool driven =
        mode - (uint32_t)LODE_MODE_VOLTAGE <= (uint32_t)LODE_MODE_RUN - (uint32_t)LODE_MODE_VOLTAGE;
    const bool may_be_steady =
        mode == (uint32_t)LODE_MODE_RUN && self->tuning->speed_periods == LODE_SLOW_PERIODS;
    return self->gates == driven && (!self->steady || may_be_steady) &&
           lode_in_range(lode_abs(self->direction), 1.0f, 1.0f);
}

// Goes to FAULT if the estimate has moved further than its PLL can move it (P30). False: a fault.
bool lode_mode_motion_ok(lode_drive_t *self);

// In RUN. Goes to FAULT if speed control or the limits of its torque have changed by themselves. False: a fault.
bool lode_mode_speed_ok(lode_drive_t *self);

// RUN, after the estimator has restarted and has no angle: counts the lock as missing for two thirds of the guard's time, as
// a lock at a wrong angle may come before all of that time is over.
void lode_mode_lose_rotor(lode_drive_t *self);

// Trips with LODE_CHECK_MEMORY.
void lode_mode_trip_memory(lode_drive_t *self, lode_memory_t corrupted);

// Trips because mode, command, mailbox or tuning are corrupt.
void lode_mode_distrust(lode_drive_t *self);

// With a command in the mailbox: flags it again, in case the flag was lost. False: `command_posted` has no valid value.
bool lode_mode_mail_ok(lode_drive_t *self);

// Checks mode, flags, mailbox and command, and the next word of the tuning.
static inline bool lode_mode_memory_ok(lode_drive_t *self, lode_words_t tuning) {
    return lode_mode_is_sound(self) && lode_mode_fits(self) &&
           (self->command_posted == LODE_POST_NONE || lode_mode_mail_ok(self)) &&
           lode_tuning_watch_word(self, tuning);
}

#ifndef LODE_WITHOUT_TORQUE_LIMITS

// An even number of ones in the 16 bits of a share of the torque.
static inline bool lode_mode_share_is_sound(uint32_t share) {
    const uint32_t octet = share ^ (share >> 8);
    const uint32_t nibble = (octet ^ (octet >> 4)) & 0xFu;
    return ((0x6996u >> nibble) & 1u) == 0u; // parity of 0 .. 15
}

#endif

#define LODE_PER_SHARE (1.0f / (float)LODE_TORQUE_SHARE_ONE)

// The references' torque range, reduced by the application's limits.
LODE_INLINE lode_range_t lode_mode_torque_limits(const lode_drive_t *self, lode_range_t most) {
#ifdef LODE_WITHOUT_TORQUE_LIMITS
    (void)self;
    return most;
#else
    const uint32_t backwards = self->estimator.pll.omega_rad_s < 0.0f ? 1u : 0u;
    const uint32_t up = self->torque_share[backwards] & ~LODE_TORQUE_SHARE_PARITY;
    const uint32_t down = self->torque_share[backwards ^ 1u] & ~LODE_TORQUE_SHARE_PARITY;
    return (lode_range_t){LODE_PER_SHARE * (float)down * most.min,
                          LODE_PER_SHARE * (float)up * most.max};
#endif
}

// Largest mechanical speed that may be commanded: the estimator's omega_max or the guard's trip limit, whichever is lower.
float lode_mode_most_rad_s(const lode_drive_tuning_t *tuning);

// After a change of the tuning: adapts the states that would not fit it. `before`: the previous tuning.
void lode_mode_retune(lode_drive_t *self, const lode_drive_tuning_t *before);

// In RUN: a ramp whose jerk is limited goes on at its slope, if speed control has another rate now.
void lode_mode_retune_ramp(lode_drive_t *self, const lode_drive_tuning_t *before);

// Takes over what was posted, at the start of a period. True: a fault was cleared, by an OFF that the command has replaced.
bool lode_mode_take_mail(lode_drive_t *self);

// To OFF: gates off, no voltage pending; estimate, currents and references are reset.
void lode_mode_switch_off(lode_drive_t *self);

// To FAULT: gates off, the first cause latched. The values of the tripping period stay readable.
void lode_mode_fault(lode_drive_t *self, lode_check_t check, float measured, float limit);

// To FAULT if the guard has tripped.
void lode_mode_obey_guard(lode_drive_t *self);

#ifndef LODE_WITHOUT_HANDOVER_RETRY
// In RUN: a phase seems to be open (0: none). Ends an attempt that is not proven yet, if bridge and sensors are checked before
// the next one (S28). False: it does not.
bool lode_mode_doubts_phase(lode_drive_t *self, uint_least8_t phase);

// Once in LODE_SLOW_PERIODS: a start whose lock is lost right after the hand-over has failed.
void lode_mode_prove_start(lode_drive_t *self);
#endif

// Stores the current `i_A` of a period that has tripped and is not computed further.
void lode_mode_note_trip(lode_drive_t *self, lode_ab_t i_A);

// PRECHARGE: only the low sides switch; the guard runs, nothing is estimated.
static inline bool lode_mode_precharges(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_PRECHARGE
    (void)self;
    return false;
#else
    return lode_mode(self) == LODE_MODE_PRECHARGE;
#endif
}

// PRECHARGE, while bridge and sensors are checked.
static inline bool lode_mode_checks_signals(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_SIGNAL_CHECK
    (void)self;
    return false;
#else
    return lode_mode_precharges(self) &&
           self->state.precharge.part == (uint_least8_t)LODE_PRECHARGE_CHECK &&
           lode_signal_check_goes_on(&self->state.precharge.by.check, &self->tuning->signal_check);
#endif
}

// In PRECHARGE: the low sides have begun to switch.
static inline bool lode_mode_pulses(const lode_drive_t *self) {
    const lode_precharge_t *precharge = &self->state.precharge;
#ifndef LODE_WITHOUT_FLYING_START
    if (precharge->part == (uint_least8_t)LODE_PRECHARGE_PULSES) {
        return precharge->by.fly.stage != (uint_least8_t)LODE_FLY_BEGIN;
    }
#endif
    return precharge->periods > 0u;
}

// FAULT, and the motor is short-circuited by all low sides.
static inline bool lode_mode_shorts(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_ACTIVE_SHORT
    (void)self;
    return false;
#else
    if (((uint32_t)self->command.flags & (uint32_t)LODE_ORDER_SHORT) == 0u) {
        return false;
    }
    const uint32_t cause = self->guard.fault.check;
    const bool shorted = cause == (uint32_t)LODE_CHECK_SWITCH_SHORTED;
    if (shorted && !(self->guard.fault.measured < 0.0f)) {
        return false; // a high side: the low sides would short the bus
    }
    // It takes an OFF command, from someone who has checked, to switch the low sides on.
    return lode_mode(self) == LODE_MODE_FAULT &&
           (!(shorted || lode_guard_suspects(cause)) ||
            self->command.mode == (uint_least8_t)LODE_MODE_OFF);
#endif
}

// What switches in the period after lode_mode_idle(), with the duties `duty`, or in a short circuit with none.
static inline lode_drive_out_t lode_mode_idle_out(const lode_drive_t *self,
                                                  const lode_abc_t *duty) {
    if (lode_mode_shorts(self)) {
        return (lode_drive_out_t){{0.0f, 0.0f, 0.0f}, LODE_GATES_LOW};
    }
#ifndef LODE_WITHOUT_SIGNAL_CHECK
    if (lode_mode_checks_signals(self)) {
        const bool driven = lode_signal_check_drives(&self->state.precharge.by.check);
        return (lode_drive_out_t){*duty, driven ? LODE_GATES_ON : LODE_GATES_OFF};
    }
#endif
    const bool pulses = lode_mode_precharges(self) && lode_mode_pulses(self);
    return (lode_drive_out_t){*duty, pulses ? LODE_GATES_LOW : LODE_GATES_OFF};
}

// Rounds left to prove a start that are not counted down until the rotor turns as commanded (S28).
#define LODE_PROVING_ENDLESS 0xffffu

// With every leg at half duty there is no voltage between the phases.
#define LODE_DUTY_IDLE 0.5f

// Duties that put the terminals at the voltages `e`, per bus volt.
static inline lode_abc_t lode_mode_duties_at(lode_abc_t e) {
    return (lode_abc_t){lode_clamp(LODE_DUTY_IDLE + e.a, 0.0f, 1.0f),
                        lode_clamp(LODE_DUTY_IDLE + e.b, 0.0f, 1.0f),
                        lode_clamp(LODE_DUTY_IDLE + e.c, 0.0f, 1.0f)};
}

// A period with the gates off, or only the low sides on. All gates may be on after it. Uses the phase currents of `sample`.
void lode_mode_idle(lode_drive_t *self, lode_words_t tuning, const lode_sample_t *sample,
                    lode_calibration_t calibration, float offset_count);

// A driven period in which the mode may change. Uses the estimator's angle, speed and lock, and the current i_A in the
// rotor's frame. The gates may be off after it.
void lode_mode_follow(lode_drive_t *self);

// The frame of VOLTAGE, CURRENT or START. Sets the references in it.
lode_control_frame_t lode_mode_control_frame(lode_drive_t *self);

// From RUN back to START, below the speed that the EMF requires (S11).
void lode_mode_hand_back(lode_drive_t *self);

#ifndef LODE_WITHOUT_HFI
// After the guard's checks: with injection, a rotor that is about to be lost is looked for.
void lode_mode_find_lost(lode_drive_t *self);
#endif

// SLOT_GAINS with injection configured: begins it, follows the speed, ends it. True: it injects, and the PLL has its gains.
bool lode_mode_inject(lode_drive_t *self);

// SLOT_GAINS without lock. True: angle and speed were acquired from the EMF.
bool lode_mode_seed(lode_drive_t *self);

// Takes over an external estimate, with the gates on; one that is not finite is a fault.
void lode_mode_adopt(lode_drive_t *self, const lode_estimate_t *estimate);

// The estimate with the gates off: none, or after a fault the one at which it tripped.
lode_estimate_t lode_mode_estimate(const lode_drive_t *self);

// Electrical speed of the control frame.
static inline float lode_mode_frame_omega(const lode_drive_t *self) {
    if (lode_mode(self) == LODE_MODE_RUN) {
        return self->estimator.pll.omega_rad_s;
    }
    return lode_mode(self) == LODE_MODE_START ? self->state.start.omega_rad_s
                                              : self->command.speed_rad_s;
}

#endif
