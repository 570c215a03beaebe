/// The drive: one call per PWM period, from ADC counts to duties.
///
/// Set-up:    lode_drive_init(). The configuration must give motor, inverter, sense and f_pwm_Hz; all else has defaults.
/// Interrupt: lode_drive_step() in every PWM period, with everything that was sampled at its start t_k. The duties that
///            it returns act from t_k+1 on (shadow registers), its gate state acts at once.
/// Main loop: lode_drive_post_command(), lode_drive_post_tuning(), lode_drive_telemetry(), from ONE thread. The interrupt
///            may interrupt that thread, the thread never interrupts the interrupt.
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
#include "lodestar/options.h"
#include "lodestar/plausibility.h"
#include "lodestar/references.h"
#include "lodestar/sense.h"
#include "lodestar/signal_check.h"
#include "lodestar/speed.h"
#include "lodestar/start.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Configuration of a drive. lode_drive_design() computes each field that may be 0, and is, from the others.
typedef struct {
    float f_pwm_Hz;                  ///< rate of the step, Hz, 1e3 .. 2e5
    lode_motor_t motor;              ///< required
    lode_inverter_config_t inverter; ///< required: v_bus_V and i_max_A
    lode_sense_config_t sense;       ///< required: gains and current offset
    lode_estimator_config_t estimator;
    lode_hfi_config_t hfi;
    lode_references_config_t references;
    lode_current_config_t current;
    lode_speed_config_t speed;
    lode_start_config_t start;
    lode_guard_config_t guard;
} lode_drive_config_t;

/// All that is derived from a configuration. The step never writes it, so it may serve several drives and lie in
/// flash. It must not change while a drive uses it. It consists of floats, 32-bit integers and pairs of 16-bit
/// integers, so no byte is padding.
typedef struct {
    uint32_t
        speed_periods; ///< control periods per call of speed control and references: 8, 4, 2 or 1
    float omega_min;   ///< lowest electrical speed in RUN, rad/s; below 0: any speed (injection)
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

/// What the drive is doing. With LODE_WITHOUT_COMMISSIONING, VOLTAGE and CURRENT are left out of the build, and a
/// command for them is refused (LODE_ERROR_COMMAND).
typedef enum {
    LODE_MODE_OFF,       ///< gates off
    LODE_MODE_CALIBRATE, ///< gates off, the current offsets are measured
    LODE_MODE_VOLTAGE,   ///< voltage vector at a commanded angle
    LODE_MODE_CURRENT,   ///< current vector at a commanded angle
    LODE_MODE_START,     ///< I-f start: a current vector turns open loop, to start or to stop
    LODE_MODE_RUN,       ///< speed or torque control, sensorless or with an angle sensor
    LODE_MODE_FAULT,     ///< gates off, or active short, until the fault is cleared
    /// before a mode with all gates on. First the low sides alone: to find a rotor that is already turning, and to
    /// charge bootstrap capacitors. Then pulses of all gates, with pauses, to check bridge and sensors
    LODE_MODE_PRECHARGE
} lode_mode_t;

/// The enumerator's name, for logs.
const char *lode_mode_name(lode_mode_t mode);

/// What RUN controls.
typedef enum {
    LODE_CONTROL_SPEED, ///< the speed, which follows its ramp
    /// the air-gap torque, Nm; friction is not added. The speed stays between the lowest one that can be held
    /// without a sensor and the commanded one, whatever the torque
    LODE_CONTROL_TORQUE
} lode_control_t;

/// Largest magnitude of VOLTAGE's and CURRENT's vector, per axis, and of the speed of its frame: beyond any motor, and
/// squares are finite.
#define LODE_COMMAND_MAX 1.0e6f

/// A command. RUN calibrates and starts first where necessary. RUN with speed 0 stops and switches the gates off;
/// with signal injection or an angle sensor the drive holds speed 0 like any other speed, and OFF stops it.
typedef struct {
    lode_mode_t mode; ///< OFF, CALIBRATE, VOLTAGE, CURRENT or RUN
    /// RUN: MECHANICAL speed, rad/s, of either sign; with torque control the direction, and the speed that is not
    /// exceeded. At most the smaller of estimator.omega_max_rad_s and guard.omega_max_rad_s, divided by the pole
    /// pairs. Not looked at in the other modes, as long as it is finite
    float speed_rad_s;
    /// VOLTAGE: V, shortened to the circle of current.voltage_use; CURRENT: A, shortened to i_max_A; in the frame at
    /// theta_rad; each axis up to LODE_COMMAND_MAX
    lode_dq_t vector;
    /// VOLTAGE, CURRENT: electrical angle of that frame at entry into the mode, rad, up to +-LODE_ANGLE_LIMIT_rad; at 0
    /// its d axis lies on phase a
    float theta_rad;
    float omega_rad_s;      ///< electrical speed of that frame, rad/s, up to LODE_COMMAND_MAX
    bool clear_fault;       ///< only with OFF: leave FAULT
    lode_control_t control; ///< RUN: what is controlled
    /// RUN with torque control: positive accelerates towards positive speeds, whatever the present direction. Limited
    /// to what current, voltage and bus allow (lode_telemetry_t.torque_limited)
    float torque_Nm;
#ifndef LODE_WITHOUT_ACTIVE_SHORT
    /// in FAULT all low sides stay on (docs/reactions.md). Where a shorted switch may be what has tripped
    /// (lode_guard_suspects()), only if the commanded mode is OFF; with a shorted high side never.
    /// LODE_WITHOUT_ACTIVE_SHORT leaves this field out of the build
    bool active_short;
#endif
} lode_command_t;

/// Which of the bridge's six switches may be on.
typedef enum {
    LODE_GATES_OFF, ///< none; acts at once
    LODE_GATES_ON,  ///< all
    /// only the low sides, for their share of the period; a board that cannot do this: none, and start.pulses off in
    /// its configuration, as otherwise a rotor that still turns ends a start with SIGNALS
    LODE_GATES_LOW
} lode_gates_t;

/// What the board has to output.
typedef struct {
    /// High-side on-time as a share of the PWM period, [0, 1], quantised to the timer's grid. The low side is on
    /// for the rest, which is centred on t_k.
    lode_abc_t duty;
    lode_gates_t gates;
} lode_drive_out_t;

/// Bits of lode_order_t.flags.
enum {
    LODE_ORDER_CLEAR_FAULT = 1,
    LODE_ORDER_TORQUE = 2, ///< torque control
    LODE_ORDER_SHORT = 4,  ///< active short in FAULT
};

/// A command in the form in which the drive stores it.
typedef struct {
#ifndef LODE_WITHOUT_COMMISSIONING
    float theta_rad;
#endif
    float speed_rad_s; ///< RUN: mechanical; VOLTAGE, CURRENT: electrical speed of the frame
    union {
#ifndef LODE_WITHOUT_COMMISSIONING
        lode_dq_t vector; ///< VOLTAGE, CURRENT
#endif
        float torque_Nm; ///< RUN with torque control: shares the place of vector.d
    } value;
    /// lode_mode_t. Not stored as an enumeration: on some targets that has more bits than `check` protects
    uint_least8_t mode;
    uint_least8_t flags;  ///< LODE_ORDER_...
    uint_least16_t check; ///< check word over all bits of the members above
} lode_order_t;

// Values of lode_drive_t.command_posted. A flipped bit makes a value that is neither of them.
#define LODE_POST_NONE 0u
#define LODE_POST_FULL 0xa5u

/// State of RUN.
typedef struct {
    lode_speed_t speed;
    lode_references_t references;
    float fade; ///< share of the hand-over current that is left: 1 at hand-over, falls to 0
    float id_A; ///< d-axis current at hand-over, A; multiplied by `fade`
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    /// rounds of LODE_SLOW_PERIODS for which a lost lock, or a phase that seems open, still counts as a failed start (S28);
    /// 0: the start is over
    uint_least16_t proving;
#endif
#ifndef LODE_WITHOUT_PLAUSIBILITY
    uint_least16_t off; ///< rounds in which current control has lost the current (K49), OFF_UP each
    lode_half_waves_t waves; ///< missing half-waves (K24)
    lode_load_t load;        ///< load beyond all torque (K19)
#endif
} lode_running_t;

/// Values of lode_precharge_t.part, in this order.
enum {
    LODE_PRECHARGE_PULSES, ///< low-side pulses that look for a turning rotor (fly.h)
    LODE_PRECHARGE_CHARGE, ///< low sides on for a fifth of each period: charges bootstrap capacitors
    LODE_PRECHARGE_CHECK   ///< check of bridge and sensors (signal_check.h)
};

/// State of PRECHARGE.
typedef struct {
    uint32_t periods;     ///< CHARGE: periods so far
    uint_least8_t driven; ///< lode_mode_t for which it began
    uint_least8_t part;   ///< LODE_PRECHARGE_...
    uint_least8_t
        rests; ///< from PULSES: not 0: the rotor is at rest, as lode_fly_t.rests; 1 if there are no PULSES but a CHECK
#ifndef LODE_WITHOUT_FLYING_START
    union {
        lode_fly_t fly; ///< PULSES
#ifndef LODE_WITHOUT_SIGNAL_CHECK
        lode_signal_check_t check; ///< CHECK
#endif
    } by;
#endif
} lode_precharge_t;

/// Watches the tuning in use for changes: a CRC-32 over all its words, one word per control period. Detects any
/// three flipped bits, any odd number of them, and any burst of up to 32 bits. LODE_WITHOUT_TUNING_CHECK leaves it
/// out of the build.
typedef struct {
    uint32_t check; ///< CRC over all words when the tuning was taken
    uint32_t crc;   ///< CRC over the words before `word`
    uint32_t word;  ///< index of the next word
} lode_tuning_watch_t;

/// Bits of lode_drive_t.known.
enum {
    LODE_KNOWN_OFFSETS = 1, ///< the current offsets are calibrated
    /// the signal check of the present start, or of the last one, was completed
    LODE_KNOWN_SIGNALS = 2,
};

#define LODE_TORQUE_SHARE_ONE 0x8000u // full share; two shares fit into one 32-bit word
#define LODE_TORQUE_SHARE_PARITY                                                                   \
    1u // bit that makes the number of ones even, so that a flipped bit is found

/// A drive. The members are visible for static allocation; only the functions below write them.
typedef struct {
    const lode_drive_tuning_t *tuning;
    uint32_t steps; ///< control periods since lode_drive_begin()
    /// rounds of LODE_SLOW_PERIODS since the present start began, over all attempts
    uint32_t start_rounds;
    bool steady;         ///< RUN as commanded, speed control once in LODE_SLOW_PERIODS, no mail
    bool gates;          ///< all gates are on
    bool mail;           ///< a command or tuning is posted
    uint_least8_t known; ///< LODE_KNOWN_...
    uint_least8_t command_posted; ///< mailbox flag: LODE_POST_...
    bool edges;                   ///< the last external estimate was LODE_ESTIMATE_EDGES
    uint_least8_t sensored; ///< slow rounds for which the last LODE_ESTIMATE_SENSOR remains valid
    uint_least8_t mode;     ///< lode_mode_t
    uint_least8_t mode_not; ///< complement of `mode`, to detect a changed bit
    uint_least8_t omitted;  ///< phases whose next two samples are unusable, two bits per sample
    /// failed attempts of the start that goes on (START itself counts in state.start.failed), or lost rotors that injection has
    /// looked for; both are lode_telemetry_t.retries
    uint_least8_t losses;
    uint_least8_t calm;         ///< how often the next RUN has its gains halved (K48), (K51)
    uint_least16_t temperature; ///< ADC count of the hotter power stage
    lode_sense_t sense;
    lode_guard_t guard;
    lode_shorted_t shorted; ///< of set 1
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_plausibility_t plausibility; ///< of the phase currents of set 1
    lode_frozen_t frozen;
    lode_jump_t jump;
#endif
    lode_inverter_t inverter;
    lode_estimator_t estimator;
    lode_sincos_t lead; ///< angle from t_k to the middle of the period in which the duties act
    lode_current_t current;
    lode_dq_t ref_A; ///< current reference, A
    lode_dq_t i_A;   ///< current at t_k in the frame of control, A
    lode_dq_t u_V;   ///< voltage requested by current control, V
    lode_abc_t duty; ///< returned by the last call
#ifndef LODE_WITHOUT_TORQUE_LIMITS
    /// permitted share of the torque range, for motoring and for braking: 0 .. LODE_TORQUE_SHARE_ONE, with
    /// LODE_TORQUE_SHARE_PARITY
    uint_least16_t torque_share[2];
#endif
    float direction; ///< direction of rotation, -1 or +1
    union {
        lode_sense_sums_t sums;     ///< CALIBRATE
        lode_precharge_t precharge; ///< PRECHARGE
        float theta_rad;            ///< VOLTAGE, CURRENT: angle of the frame
        lode_start_t start;         ///< START
        lode_running_t run;         ///< RUN
    } state;                        ///< of the present mode; initialised at entry
    lode_order_t command;           ///< command in force
    lode_order_t posted;            ///< mailbox: posted command
#ifndef LODE_WITHOUT_TUNING_CHECK
    lode_tuning_watch_t watch;
    uint32_t posted_check; ///< mailbox: CRC of the posted tuning
#endif
    const lode_drive_tuning_t
        *posted_tuning; ///< mailbox: posted tuning; NULL: none, or already taken
} lode_drive_t;

/// Ramped reference of RUN, MECHANICAL rad/s; 0 in the other modes.
static inline float lode_drive_speed_ref_rad_s(const lode_drive_t *self) {
    return self->mode == (uint_least8_t)LODE_MODE_RUN ? self->state.run.speed.reference_rad_s
                                                      : 0.0f;
}

/// A motor parameter that is estimated while the motor runs.
typedef struct {
    float value;      ///< estimate; the configured value until there is one
    float confidence; ///< 0: no information, 1: certain; used from 0.5 on
} lode_adapted_t;

/// The motor parameters that can be estimated in operation (adaptation.h, learn.h).
typedef struct {
    lode_adapted_t J_kgm2;
    lode_adapted_t psi_Wb;
    lode_adapted_t Rs_Ohm;
    lode_adapted_t Lq_H;
} lode_adapted_motor_t;

/// Stage of the start; LODE_START_NONE outside START. While injection looks for the rotor, the stage is one in
/// which the vector waits.
static inline lode_start_stage_t lode_drive_start_stage(const lode_drive_t *self) {
    return self->mode == (uint_least8_t)LODE_MODE_START
               ? (lode_start_stage_t)self->state.start.stage
               : LODE_START_NONE;
}

/// True if the bit `what` (LODE_KNOWN_...) is set.
static inline bool lode_drive_knows(const lode_drive_t *self, uint32_t what) {
    return ((uint32_t)self->known & what) != 0u;
}

/// See lode_telemetry_t.retries.
static inline uint_least8_t lode_drive_retries(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_HANDOVER_RETRY
    (void)self;
    return 0u;
#else
    return self->mode == (uint_least8_t)LODE_MODE_START ? self->state.start.failed : self->losses;
#endif
}

/// Bits of lode_drive_limited(): why torque or speed are not the commanded ones, or reach them late.
enum {
    LODE_LIMITED_TORQUE = 1, ///< lode_telemetry_t.torque_limited
    LODE_LIMITED_RAISED = 2, ///< lode_telemetry_t.speed_raised
    LODE_LIMITED_HELD = 4,   ///< lode_telemetry_t.speed_held
    LODE_LIMITED_GAINS = 8   ///< lode_telemetry_t.gains_halved
};

/// 0: RUN does what is commanded, or the mode is another one. From the interrupt after lode_drive_step().
uint32_t lode_drive_limited(const lode_drive_t *self);

/// A consistent snapshot of one control period, for logs and displays. The period is the last one, k; its samples
/// are from t_k. With the gates off nothing is estimated or controlled: from `i_A` on all but `v_bus_V` and
/// `temperature_degC` are 0, in FAULT those of the trip.
typedef struct {
    uint32_t steps; ///< control periods since lode_drive_begin()
    lode_mode_t mode;
    lode_start_stage_t start_stage; ///< START: stage; otherwise LODE_START_NONE
    /// with LODE_CHECK_NONE there is no fault; the other fields then say why the last failed attempt of a start has
    /// failed
    lode_fault_t fault;
    /// RUN: the torque reference is at a limit set by current, voltage, bus or lode_drive_limit_torque()
    bool torque_limited;
    /// RUN with speed control: the commanded speed is below the lowest possible one, which is held instead
    bool speed_raised;
    /// RUN with torque control: a speed is held, the least one or the commanded limit, and not the commanded torque
    bool speed_held;
    /// RUN: speed control has a half or a quarter of its gains until OFF, because it oscillated (K48) or the rotor was lost
    /// right after a hand-over (K51). The inertia may be less than configured
    bool gains_halved;
    /// failed attempts of the present start, or of the one that has led to RUN: up to 2, and 3 while the last attempt
    /// is repeated; 0 in OFF and FAULT. With injection also the number of times the rotor was searched for again, up to
    /// 3. Always 0 with LODE_WITHOUT_HANDOVER_RETRY
    uint_least8_t retries;
    /// faults since lode_drive_begin(), modulo 65536: tells a new fault from the last one
    uint_least16_t trips;
    /// the signal check of the present start, or of the last one, was completed. False if there is none, or if it
    /// was skipped because the rotor turned
    bool signals_checked;
    bool shorted;    ///< FAULT: active short, all low sides are on
    lode_abc_t duty; ///< high-side duties returned by the last call
    /// current at t_k, in the frame of control: rotor (RUN), vector (START) or command (VOLTAGE, CURRENT)
    lode_dq_t i_A;
    lode_dq_t ref_A;        ///< current reference in the same frame
    lode_dq_t u_V;          ///< voltage requested by current control, in the same frame
    float v_bus_V;          ///< bus voltage at t_k
    float temperature_degC; ///< power stage, the hotter one
    /// estimated electrical rotor angle at t_k, [-pi, pi]; START without a lock: angle of the vector
    float theta_rad;
    float omega_rad_s;     ///< estimated electrical speed at t_k
    float speed_ref_rad_s; ///< ramped reference of RUN, MECHANICAL; otherwise 0
    float torque_ref_Nm;   ///< torque reference of RUN; otherwise 0
    /// RUN: largest torque that the current allows with the id of field weakening, before lode_drive_limit_torque();
    /// otherwise 0, and always with LODE_WITHOUT_TORQUE_LIMITS. Without field weakening the voltage may allow less
    float torque_most_Nm;
    float load_torque_Nm; ///< estimated load; positive opposes positive speeds; 0 with the QPLL
    float lock;           ///< lock quality, 0 .. 1
    lode_ab_t e_V;        ///< raw output of the EMF observer at t_k, stator axes
    /// weight of injection in the position error of the PLL, 0 .. 1; the EMF has the rest
    float injected;
    float injection_error_rad; ///< position error from injection, not limited; 0: no injection
    float emf_error_rad;       ///< position error from the EMF
    /// estimates made by the main loop. lode_drive_telemetry() leaves value and confidence 0;
    /// lode_adaptation_telemetry() (adaptation.h) and lode_learn_telemetry() (learn.h) fill them in
    lode_adapted_motor_t motor;
} lode_telemetry_t;

/// Computes every field of `config` that is left open (0 or LODE_AUTO). lode_drive_init() and the host tool call it
/// too. It checks nothing: wrong inputs give values that lode_drive_init() refuses.
void lode_drive_design(lode_drive_config_t *config);

/// Completes a copy of `config`, checks every field and derives the tuning. Returns LODE_OK or the first field out
/// of range (status.h); on any error `tuning` is left alone. Not for the interrupt: some 46 000 instructions and
/// 1.7 KB of stack (Cortex-M4F, gcc 12.2).
lode_status_t lode_drive_tune(lode_drive_tuning_t *tuning, const lode_drive_config_t *config);

// Their names tell what is left out of the build (options.h).
#define lode_drive_begin LODE_SYMBOL(lode_drive_begin)
#define lode_drive_init LODE_SYMBOL(lode_drive_init)

/// Initialises a drive in OFF on a tuning from lode_drive_tune(), which other drives may share. Errors: NULL;
/// TUNING, a value is not finite. On any error the drive is left alone.
lode_status_t lode_drive_begin(lode_drive_t *self, const lode_drive_tuning_t *tuning);

/// lode_drive_tune(), then lode_drive_begin(). On any error `self` and `tuning` are left alone.
lode_status_t lode_drive_init(lode_drive_t *self, lode_drive_tuning_t *tuning,
                              const lode_drive_config_t *config);

/// Warnings about a configuration, a bit each.
enum {
    LODE_WARNING_EMF = 1, ///< no usable EMF: starts and low speeds may fail (lode_start_has_emf())
    /// the current vector of a start makes too little torque (S54), but neither voltage nor saliency allow injection
    LODE_WARNING_INJECTION = 2
};

/// What to know of a configuration that lode_drive_init() accepts. `design` of the host tool says more. As slow as
/// lode_drive_design().
uint32_t lode_drive_warnings(const lode_drive_config_t *config);

/// One control period: sense, estimate, act. Call it from the PWM interrupt, and only after lode_drive_begin() or
/// lode_drive_init(). Accepts any input: the run time is bounded and the duties are in [0, 1]. No allocation.
/// Cycles, stack and RAM: docs/budget.md.
lode_drive_out_t lode_drive_step(lode_drive_t *self, const lode_counts_t *counts);

/// The three parts of the step, to be called in this order instead of it: counts to amperes and volts at t_k, with
/// the guard's check of them; angle and speed at t_k; duties and gates. A host may replace the second part by an
/// estimate of its own. With LODE_ESTIMATE_EXTERNAL as its source the drive checks it and takes over all its fields
/// except `reseeded`.
lode_sample_t lode_drive_sense(lode_drive_t *self, const lode_counts_t *counts);
lode_estimate_t lode_drive_estimate(lode_drive_t *self, const lode_sample_t *sample);
lode_drive_out_t lode_drive_act(lode_drive_t *self, const lode_sample_t *sample,
                                const lode_estimate_t *estimate);

/// Posts a command for the next control period. It replaces a posted command that has not been taken yet; if that
/// one had clear_fault set, the fault is still cleared. Errors, with which nothing is posted: NULL, also for a
/// drive that has not begun; COMMAND: mode or control is unknown or not built in, a value is not finite or beyond its
/// range, or `clear_fault` is set with a mode other than OFF; COMMAND_SPEED.
lode_status_t lode_drive_post_command(lode_drive_t *self, const lode_command_t *command);

/// Posts a tuning from lode_drive_tune() for the next control period. All states continue. An EMF observer of
/// another kind or bandwidth starts from the present EMF; injection ends if the new tuning has none. What a start has
/// measured beyond resistance and dead time is taken as beyond the new ones; a commanded speed beyond the new limits
/// becomes the largest allowed one. With six phases use only
/// lode_drive6_post_tuning(). The old tuning is free once lode_drive_tuning_taken() returns true. Cost: two passes
/// over some 190 words. Errors, with which nothing is posted: NULL; TUNING, a value is not finite.
lode_status_t lode_drive_post_tuning(lode_drive_t *self, const lode_drive_tuning_t *tuning);
/// True once the interrupt has taken the posted tuning, or if none is posted.
bool lode_drive_tuning_taken(const lode_drive_t *self);

#ifndef LODE_WITHOUT_TORQUE_LIMITS

/// Limits the torque of RUN, in both directions, to `share` (0 .. 1) of what current, voltage and bus allow: for
/// derating (derate.h) or for limits of the application. Acts from the next round of the slow jobs on and holds
/// until the next call. Values below 0 and NaN count as 0, values above 1 as 1. The field-weakening current is not
/// limited. Called from the main loop.
void lode_drive_limit_torque(lode_drive_t *self, float share);

/// The same with one share for motoring and one for braking (supply.h).
void lode_drive_limit_torques(lode_drive_t *self, float motoring, float braking);

#endif

/// Takes a snapshot of the last control period, for the main loop; it computes an arc tangent. False if the drive
/// has not begun, or if the interrupt came in between three times in a row: the snapshot then mixes fields of
/// different periods, each of them valid.
bool lode_drive_telemetry(const lode_drive_t *self, lode_telemetry_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
