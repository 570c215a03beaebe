/// The drive: one call per PWM period, from ADC counts to duties.
///
/// Set-up:    lode_drive_init() with a configuration of which only motor, inverter, sense and f_pwm
///            are required.
/// Interrupt: lode_drive_step() in every PWM period, with everything that was sampled at its start t_k.
///            The duties that it returns take effect at t_k+1 (shadow registers), the gate state at once.
/// Elsewhere: lode_drive_post_command(), lode_drive_post_tuning(), lode_drive_telemetry(), from ONE
///            thread that the interrupt may preempt, but which never preempts the interrupt.
#ifndef LODESTAR_DRIVE_H
#define LODESTAR_DRIVE_H

#include "lodestar/current.h"
#include "lodestar/estimator.h"
#include "lodestar/fly.h"
#include "lodestar/guard.h"
#include "lodestar/hfi.h"
#include "lodestar/inverter.h"
#include "lodestar/modulator.h"
#include "lodestar/motor.h"
#include "lodestar/plausibility.h"
#include "lodestar/references.h"
#include "lodestar/sense.h"
#include "lodestar/signal_check.h"
#include "lodestar/speed.h"
#include "lodestar/start.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A field that may be 0 is then computed from the others by lode_drive_design().
typedef struct {
    float f_pwm_Hz;                  ///< rate of the step, 1e3 .. 2e5
    lode_motor_t motor;              ///< required
    lode_inverter_config_t inverter; ///< required: v_bus_V and i_max_A
    lode_sense_config_t sense;       ///< required: gains and offset
    lode_estimator_config_t estimator;
    lode_hfi_config_t hfi;
    lode_references_config_t references;
    lode_current_config_t current;
    lode_speed_config_t speed;
    lode_start_config_t start;
    lode_guard_config_t guard;
} lode_drive_config_t;

/// Everything derived from a configuration. Never written by the step: it may serve several drives,
/// and lie in flash. It must not change while a drive uses it. Consists of floats, 32-bit integers and pairs of
/// 16-bit ones, so that it has no padding.
typedef struct {
    uint32_t speed_periods; ///< between two runs of speed control and references: 8, 4, 2 or 1
    float omega_min;        ///< least electrical speed in RUN
    lode_sense_tuning_t sense;
    lode_inverter_tuning_t inverter;
    lode_estimator_tuning_t estimator;
    lode_references_tuning_t references;
    lode_current_tuning_t current;
    lode_speed_tuning_t speed;
    lode_start_tuning_t start;
#ifndef LODE_WITHOUT_FLYING_START
    lode_fly_tuning_t fly;
#endif
#ifndef LODE_WITHOUT_SIGNAL_CHECK
    lode_signal_check_tuning_t signal_check;
#endif
    lode_guard_tuning_t guard;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_plausibility_tuning_t plausibility;
#endif
} lode_drive_tuning_t;

/// LODE_WITHOUT_COMMISSIONING leaves VOLTAGE and CURRENT out of a build; they are then refused
/// (LODE_ERROR_COMMAND).
typedef enum {
    LODE_MODE_OFF,       ///< gates off
    LODE_MODE_CALIBRATE, ///< gates off, current offsets are measured
    LODE_MODE_VOLTAGE,   ///< voltage vector at a given angle
    LODE_MODE_CURRENT,   ///< current vector at a given angle
    LODE_MODE_START,     ///< I-f: rotating current vector, to start or to stop
    LODE_MODE_RUN,       ///< speed or torque control, without a sensor or with one
    LODE_MODE_FAULT,     ///< gates off, or active short, until the fault is cleared
    /// before a mode with all gates on: low sides only, to find a rotor that is already turning and to charge the
    /// bootstrap capacitors; then pulses of all gates, with pauses, to check bridge and sensors
    LODE_MODE_PRECHARGE
} lode_mode_t;

/// The enumerator's name, for logs.
const char *lode_mode_name(lode_mode_t mode);

/// What RUN controls.
typedef enum {
    LODE_CONTROL_SPEED, ///< the speed, along its ramp
    /// the air-gap torque in Nm: friction is not added. The speed always stays between the least that can be held
    /// without a sensor and the commanded one
    LODE_CONTROL_TORQUE
} lode_control_t;

/// What the drive shall do. RUN calibrates and starts by itself where needed, and with speed 0
/// stops and switches off; with signal injection or an angle sensor, 0 is a speed like any other, and OFF switches off.
typedef struct {
    lode_mode_t mode; ///< OFF, CALIBRATE, VOLTAGE, CURRENT or RUN
    /// RUN: MECHANICAL speed, either sign; with torque control the direction in which to run, and the speed
    /// limit. At most estimator.omega_max_rad_s and guard.omega_max_rad_s divided by the pole pairs
    float speed_rad_s;
    lode_dq_t vector;       ///< VOLTAGE: V, CURRENT: A, in the frame at theta_rad
    float theta_rad;        ///< VOLTAGE, CURRENT: angle of that frame when the mode is entered
    float omega_rad_s;      ///< VOLTAGE, CURRENT: electrical speed of that frame
    bool clear_fault;       ///< only with OFF: leave FAULT
    lode_control_t control; ///< RUN
    float
        torque_Nm; ///< torque control: positive drives towards positive speeds, in whichever direction the motor runs
#ifndef LODE_WITHOUT_ACTIVE_SHORT
    /// in FAULT the low sides are on, all the time (docs/reactions.md); with any mode except OFF not after
    /// HARDWARE_TRIP or OVER_CURRENT. Not in a build with LODE_WITHOUT_ACTIVE_SHORT
    bool active_short;
#endif
} lode_command_t;

/// Which of a bridge's six switches may be on.
typedef enum {
    LODE_GATES_OFF, ///< none, at once
    LODE_GATES_ON,  ///< all
    LODE_GATES_LOW  ///< low sides only, in their share of the period; a board that cannot: none
} lode_gates_t;

typedef struct {
    /// High-side on-time as a share of the period, [0, 1], on the timer's grid. The low side has the rest,
    /// around t_k.
    lode_abc_t duty;
    lode_gates_t gates;
} lode_drive_out_t;

enum {
    LODE_ORDER_CLEAR_FAULT = 1,
    LODE_ORDER_TORQUE = 2, ///< torque control
    LODE_ORDER_SHORT = 4,  ///< active short in FAULT
};

/// A command as the drive keeps it.
typedef struct {
#ifndef LODE_WITHOUT_COMMISSIONING
    float theta_rad;
#endif
    float speed_rad_s; ///< RUN: mechanical; VOLTAGE, CURRENT: electrical, of their frame
    union {
#ifndef LODE_WITHOUT_COMMISSIONING
        lode_dq_t vector; ///< VOLTAGE, CURRENT
#endif
        float torque_Nm; ///< RUN, torque control: in the place of vector.d
    } value;
    uint_least8_t
        mode; ///< lode_mode_t: as an enumeration it has more bits on some targets than `check` tells apart
    uint_least8_t flags;
    uint_least16_t check; ///< of all of the above, bit by bit
} lode_order_t;

// What the flag of the command's mailbox may hold; a flipped bit gives neither.
#define LODE_POST_NONE 0u
#define LODE_POST_FULL 0xa5u

typedef struct {
    lode_speed_t speed;
    lode_references_t references;
    float fade; ///< 1 at hand-over, 0 when the references have taken over
    float id_A; ///< d-axis current at hand-over, which is faded out
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    /// while above 0, in LODE_SLOW_PERIODS: a lost lock counts as a failed start
    uint_least16_t proving;
#endif
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_half_waves_t waves; ///< of three phases
    lode_load_t load;        ///< beyond all torque
#endif
} lode_running_t;

/// What lode_precharge_t.part may be, in this order.
enum {
    LODE_PRECHARGE_PULSES, ///< of the low sides, to find a rotor that is already turning
    LODE_PRECHARGE_CHARGE, ///< low sides on for a fifth of each period: bootstrap capacitors
    LODE_PRECHARGE_CHECK   ///< of bridge and sensors
};

/// State before all gates are on.
typedef struct {
    uint32_t periods; ///< CHARGE
    uint_least8_t part;
    uint_least8_t rests; ///< after PULSES, as in lode_fly_t; without PULSES not known otherwise
#ifndef LODE_WITHOUT_FLYING_START
    union {
        lode_fly_t fly; ///< PULSES
#ifndef LODE_WITHOUT_SIGNAL_CHECK
        lode_signal_check_t check; ///< CHECK
#endif
    } by;
#endif
} lode_precharge_t;

/// Whether the tuning in use is still what it was when it was taken: its CRC-32, a word at a time. That finds any three
/// flipped bits, any odd number of them, and any burst of up to 32. Not in a build with
/// LODE_WITHOUT_TUNING_CHECK.
typedef struct {
    uint32_t check; ///< of all words, when it was taken
    uint32_t crc;   ///< of the words before `word`
    uint32_t word;
} lode_tuning_watch_t;

/// What lode_drive_t.known may hold.
enum {
    LODE_KNOWN_OFFSETS = 1, ///< calibrated
    LODE_KNOWN_SIGNALS = 2, ///< of the present start, or the last one: the signal check has passed
};

#define LODE_TORQUE_SHARE_ONE 0x8000u // a share of 1; two shares fit in one word

/// A drive. Visible for static allocation; written by its functions only.
typedef struct {
    const lode_drive_tuning_t *tuning;
    uint32_t steps;               ///< periods since init
    uint32_t start_rounds;        ///< of the present start, all its attempts, in LODE_SLOW_PERIODS
    bool steady;                  ///< RUN as commanded, speed control in its slot, nothing posted
    bool gates;                   ///< on
    bool mail;                    ///< something is posted
    uint_least8_t known;          ///< LODE_KNOWN_...
    uint_least8_t command_posted; ///< mailbox: LODE_POST_...
    bool edges;                   ///< the last estimate from a sensor was LODE_ESTIMATE_EDGES
    uint_least8_t sensored; ///< slow rounds for which the last LODE_ESTIMATE_SENSOR still counts
    uint_least8_t mode;     ///< lode_mode_t
    uint_least8_t mode_not; ///< the same, inverted
    uint_least8_t omitted;  ///< phases whose next two samples cannot be used, two bits each
    uint_least8_t losses;   ///< times the rotor was lost: as lode_telemetry_t.retries
    uint_least16_t temperature; ///< count, of the hotter power stage
    lode_sense_t sense;
    lode_guard_t guard;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_plausibility_t plausibility; ///< of the currents, of set 1
    lode_frozen_t frozen;
    lode_jump_t jump;
#endif
    lode_inverter_t inverter;
    lode_estimator_t estimator;
    lode_sincos_t lead; ///< angle from a sample to the middle of its duties, at the present speed
    lode_current_t current;
    lode_dq_t ref_A;
    lode_dq_t i_A; ///< in the control frame
    lode_dq_t u_V;
    lode_abc_t duty; ///< written by the last call
#ifndef LODE_WITHOUT_TORQUE_LIMITS
    /// share of the torque that the references allow, with the speed and against it: 0 .. LODE_TORQUE_SHARE_ONE
    uint_least16_t torque_share[2];
#endif
    float direction; ///< sense of rotation, -1 or +1
    union {
        lode_sense_sums_t sums;     ///< CALIBRATE
        lode_precharge_t precharge; ///< PRECHARGE
        float theta_rad;            ///< VOLTAGE, CURRENT: angle of their frame
        lode_start_t start;         ///< START
        lode_running_t run;         ///< RUN
    } state;                        ///< of the present mode, set up when it is entered
    lode_order_t command;           ///< being followed
    lode_order_t posted;            ///< mailbox
#ifndef LODE_WITHOUT_TUNING_CHECK
    lode_tuning_watch_t watch;
    uint32_t posted_check; ///< mailbox: of the posted tuning
#endif
    const lode_drive_tuning_t *posted_tuning; ///< mailbox: NULL when taken
} lode_drive_t;

/// The ramped mechanical reference of RUN; 0 in the other modes.
static inline float lode_drive_speed_ref_rad_s(const lode_drive_t *self) {
    return self->mode == (uint_least8_t)LODE_MODE_RUN ? self->state.run.speed.reference_rad_s
                                                      : 0.0f;
}

/// A motor parameter that is estimated while the motor runs.
typedef struct {
    float value;      ///< as configured until it is estimated
    float confidence; ///< 0: nothing seen yet, 1: certain; used from 0.5 on
} lode_adapted_t;

typedef struct {
    lode_adapted_t J_kgm2;
    lode_adapted_t psi_Wb;
    lode_adapted_t Rs_Ohm;
    lode_adapted_t Lq_H;
} lode_adapted_motor_t;

/// Stage of the start; LODE_START_NONE in the other modes. With injection the rotor is looked for in a stage in which
/// the vector waits.
static inline lode_start_stage_t lode_drive_start_stage(const lode_drive_t *self) {
    return self->mode == (uint_least8_t)LODE_MODE_START
               ? (lode_start_stage_t)self->state.start.stage
               : LODE_START_NONE;
}

static inline bool lode_drive_knows(const lode_drive_t *self, uint32_t what) {
    return ((uint32_t)self->known & what) != 0u;
}

/// lode_telemetry_t.retries
static inline uint_least8_t lode_drive_retries(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_HANDOVER_RETRY
    (void)self;
    return 0u;
#else
    return self->mode == (uint_least8_t)LODE_MODE_START ? self->state.start.failed : self->losses;
#endif
}

/// A consistent snapshot of one period, for logs and displays.
typedef struct {
    uint32_t steps;
    lode_mode_t mode;
    lode_start_stage_t start_stage; ///< START: its stage
    /// with LODE_CHECK_NONE not a fault: why the last failed attempt of this start, or of the previous start, failed
    lode_fault_t fault;
    /// RUN: the torque reference is at a limit of current, voltage or bus
    bool torque_limited;
    bool speed_raised; ///< RUN: the commanded speed is below the least one, which is held instead
    /// failed attempts of the present start, or the last one, up to 2, and 3 while the last one is
    /// repeated; with injection also how often the rotor was looked for again, up to 3. 0 with LODE_WITHOUT_HANDOVER_RETRY
    uint_least8_t retries;
    /// the present start, or the last one, began with a signal check that passed; false where there is none, or where it was
    /// skipped because the rotor was turning
    bool signals_checked;
    bool shorted;    ///< FAULT: all low sides are on
    lode_abc_t duty; ///< returned by the last call
    lode_dq_t i_A;   ///< in the control frame: the rotor's in RUN, the vector's in START
    lode_dq_t ref_A; ///< its reference
    lode_dq_t u_V;   ///< voltage that current control asks for
    float v_bus_V;
    float temperature_degC; ///< power stage, the hotter one
    /// estimated electrical rotor angle at t_k, [-pi, pi]; START: that of the vector until there is a lock
    float theta_rad;
    float omega_rad_s;     ///< estimated electrical speed
    float speed_ref_rad_s; ///< ramped mechanical reference of RUN, else 0
    float torque_ref_Nm;   ///< reference of RUN, else 0
    /// RUN: largest torque that current and voltage allow, regardless of lode_drive_limit_torque(); 0 in the
    /// other modes, and in a build with LODE_WITHOUT_TORQUE_LIMITS
    float torque_most_Nm;
    float load_torque_Nm; ///< estimated; positive against positive speeds, 0 with the QPLL
    float lock;           ///< quality of the estimate, 0 .. 1
    lode_ab_t e_V;        ///< raw output of the EMF observer, stator axes
    float injected; ///< share of injection in the position error, 0 .. 1; the rest is the EMF's
    float injection_error_rad; ///< position error by injection, not limited; 0: nothing is injected
    float emf_error_rad;       ///< by the EMF
    /// motor parameters estimated by the main loop. The drive leaves value and confidence 0;
    /// lode_adaptation_tell() (adaptation.h) and lode_learn_tell() (learn.h) fill them in
    lode_adapted_motor_t motor;
} lode_telemetry_t;

/// Computes every value that `config` leaves at 0 or LODE_AUTO. lode_drive_init() and the host tool both
/// use it. It checks nothing: wrong inputs give values that init refuses.
void lode_drive_design(lode_drive_config_t *config);

/// Completes a copy of `config`, checks every field and derives the tuning. LODE_OK, or which field is out of range
/// (status.h); `tuning` is then unchanged. Not for the interrupt; about 1.7 KB of stack (Cortex-M4F, gcc 12.2).
lode_status_t lode_drive_tune(lode_drive_tuning_t *tuning, const lode_drive_config_t *config);

/// Sets up a drive at rest in OFF on a tuning from lode_drive_tune(), which other drives may share. Errors: NULL;
/// TUNING, and the drive is unchanged.
lode_status_t lode_drive_begin(lode_drive_t *self, const lode_drive_tuning_t *tuning);

/// lode_drive_tune(), then lode_drive_begin(). On any error both are unchanged.
lode_status_t lode_drive_init(lode_drive_t *self, lode_drive_tuning_t *tuning,
                              const lode_drive_config_t *config);

/// One PWM period: sense, estimate, act. Do not call it before lode_drive_begin() or lode_drive_init() has set up the
/// drive. Any input is allowed: it returns in bounded time, and the duties are in [0, 1].
/// No allocation. Cycles, stack and RAM of a call: docs/budget.md.
lode_drive_out_t lode_drive_step(lode_drive_t *self, const lode_counts_t *counts);

/// The step is these three calls in a row: counts to amperes and volts at t_k, with the guard's check of
/// them; angle and speed at t_k; duties and gates. A host may use an estimate of its own in place of the
/// second: with LODE_ESTIMATE_EXTERNAL as its source it is checked and used (all fields except
/// reseeded).
lode_sample_t lode_drive_sense(lode_drive_t *self, const lode_counts_t *counts);
lode_estimate_t lode_drive_estimate(lode_drive_t *self, const lode_sample_t *sample);
lode_drive_out_t lode_drive_act(lode_drive_t *self, const lode_sample_t *sample,
                                const lode_estimate_t *estimate);

/// Posts a command for the next period; a later one replaces one not yet taken, but a `clear_fault` of the replaced one still
/// counts. Errors, which post nothing: NULL, also for a drive that is not set up; COMMAND, where a mode or kind of control
/// is unknown or not built in, a value is not finite, or `clear_fault` comes with another mode than OFF; COMMAND_SPEED.
lode_status_t lode_drive_post_command(lode_drive_t *self, const lode_command_t *command);

/// Posts a tuning, checked and derived by lode_drive_tune(), for the next period. All states continue; another EMF observer begins
/// with the present EMF, and injection ends if the new tuning has none. With six phases use lode_drive6_post_tuning() only.
/// The old one may be reused once lode_drive_tuning_taken() is true. Goes twice through the tuning, some 150 words.
/// Errors, which post nothing: NULL; TUNING.
lode_status_t lode_drive_post_tuning(lode_drive_t *self, const lode_drive_tuning_t *tuning);
bool lode_drive_tuning_taken(const lode_drive_t *self);

#ifndef LODE_WITHOUT_TORQUE_LIMITS

/// From the next round of the slow jobs on, RUN asks for at most this share, 0 .. 1, of the torque that current,
/// voltage and bus allow, in either direction: for derating (derate.h), or an application's own limit. Below 0, above 1
/// and NaN become 0, 1 and 0. Stays in force until changed. The field-weakening current is not limited.
void lode_drive_limit_torque(lode_drive_t *self, float share);

/// The same with a share for each direction: with the speed, and against it (supply.h).
void lode_drive_limit_torques(lode_drive_t *self, float motoring, float braking);

#endif

/// A snapshot of the last period, for the thread: it computes an arc tangent. False if the interrupt came in between
/// three times in a row; the snapshot then mixes fields of different periods, each of them valid.
bool lode_drive_telemetry(const lode_drive_t *self, lode_telemetry_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
