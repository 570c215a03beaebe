/// Bring-up of a new board in seven steps, each with a criterion: from "the PWM counts" to "it runs".
///
/// A step posts commands to the drive and evaluates only telemetry, raw counts and cycle counts.
/// It ends in PASS or FAIL with a reason, a measured value and the limit that it was compared with.
/// docs/porting.md explains each failure.
#ifndef LODESTAR_PORT_BRINGUP_H
#define LODESTAR_PORT_BRINGUP_H

#include "edge.h"
#include "lodestar/lodestar.h"

typedef enum {
    BRINGUP_NONE = 0,
    BRINGUP_PWM = 1, ///< gates off: periods against the cycle counter, load of the processor
    BRINGUP_OFFSETS, ///< gates off: current offsets, noise, bus voltage
    /// small voltage at 0, 120, 240 degrees: which phase carries which current, and when duties act
    BRINGUP_SIGNS,
    BRINGUP_VOLTAGE, ///< voltage at a given angle: resistance
    BRINGUP_CURRENT, ///< current at a given angle: current control
    BRINGUP_START,   ///< I-f start up to the hand-over
    BRINGUP_RUN,     ///< sensorless at the commanded speed; keeps turning
    BRINGUP_COUNT
} bringup_mode_t;

typedef enum { BRINGUP_RUNNING, BRINGUP_PASS, BRINGUP_FAIL } bringup_state_t;

typedef enum {
    BRINGUP_OK = 0,
    BRINGUP_NO_TIME_BASE, ///< guard.stamp_per_period is 0: nothing to compare the period with
    BRINGUP_PERIOD,       ///< mean period, cycles; limit: the configured one
    BRINGUP_JITTER,       ///< longest less shortest period, cycles
    BRINGUP_TOO_SLOW,     ///< longest app_period() as a share of the shortest period
    BRINGUP_TRIP,         ///< the hardware trip is set while the gates are off: periods with it
    BRINGUP_OFFSET,       ///< offset of a phase from the nominal one, counts
    BRINGUP_NOISE,        ///< peak to peak of a phase at zero current, counts
    BRINGUP_BUS,          ///< bus voltage, V; limit: the nearer limit of the guard
    BRINGUP_NO_CURRENT,   ///< vector length, A: the voltage reached its end without a current
    BRINGUP_NO_SIGNAL, ///< a phase shows no current although current flows: its share of the largest
    BRINGUP_SIGN,      ///< a phase reads backwards: its share of the largest
    BRINGUP_ORDER, ///< the current of the driven phase shows up in another: share of the largest
    BRINGUP_RATIO, ///< phases have unequal gains: share of the return current
    BRINGUP_LATENCY, ///< duties act early or late, by how many calls (one leg of three: by half a call)
    BRINGUP_BALANCE, ///< the three currents do not add up to zero, A: an amplifier shows too little
    BRINGUP_ANGLE,   ///< current across the voltage, as a share of its length
    BRINGUP_RESISTANCE, ///< more voltage over more current, Ohm; limit: motor.Rs_Ohm + inverter.r_on_Ohm
    BRINGUP_CURRENT_OFF, ///< mean deviation from the commanded current, A
    BRINGUP_RIPPLE,      ///< peak to peak of the controlled current, A
    BRINGUP_LOCK,        ///< least lock quality
    BRINGUP_SPEED,       ///< mean deviation from the commanded speed, mechanical rad/s
    BRINGUP_TIMEOUT,     ///< s
    BRINGUP_UNSURE,      ///< confidence of a measured quantity
    BRINGUP_UNSETTLED,   ///< the rotor does not come to rest under a current
    BRINGUP_NO_START, ///< speed reached, of a run to measure, mechanical rad/s; limit 0: no start at all
    BRINGUP_REFUSED, ///< the drive refuses what was given or measured: lode_status_t
    BRINGUP_FAULT    ///< the guard tripped: `check`, measured and limit are the fault's
} bringup_reason_t;

typedef struct {
    uint_least8_t mode;   ///< bringup_mode_t
    uint_least8_t state;  ///< bringup_state_t
    uint_least8_t reason; ///< bringup_reason_t
    uint_least8_t phase;  ///< 0 .. 2, if the reason concerns one phase
    uint_least8_t check;  ///< lode_check_t, with BRINGUP_FAULT
    float measured;
    float limit;
} bringup_result_t;

/// Enumerators' names without prefix, for logs.
const char *bringup_reason_name(uint_least8_t reason);
const char *bringup_state_name(uint_least8_t state);

/// Spans in cycles of board_cycles(). Kept by the interrupt.
typedef struct {
    uint32_t work_min; ///< of app_period(), from entry to the last line
    uint32_t work_max;
    uint32_t interval_min; ///< from one entry to the next
    uint32_t interval_max;
    uint32_t first;   ///< stamp of the first entry counted
    uint32_t last;    ///< of the last one
    uint32_t periods; ///< entries counted
} bringup_cycles_t;

/// Raw counts over several periods. The thread requests them with bringup_window_ask(), the interrupt fills them in.
typedef struct {
    uint32_t wanted; ///< 0: no request; at most 4096
    uint32_t taken;
    uint32_t trips;
    uint32_t sum_count[3];
    uint16_t min_count[3];
    uint16_t max_count[3];
    edge_t edge;
} bringup_window_t;

/// The inputs of a step, collected by the thread.
typedef struct {
    lode_telemetry_t now;
    bringup_cycles_t cycles;
} bringup_view_t;

typedef struct {
    lode_drive_t *drive;
    const lode_drive_config_t *config; ///< completed by lode_drive_design()
    volatile bringup_window_t *window;
    bringup_result_t result;
    float speed_rad_s; ///< mechanical, for BRINGUP_RUN
    float angle_rad;
    float turn_rad_s;
    uint32_t stage;
    uint32_t since;   ///< steps at the start of the stage
    uint32_t settled; ///< steps at the start of the averaging
    uint32_t seen;    ///< steps of the last telemetry used
    float offset_count[3];
    float u_V;       ///< voltage being raised
    float sum_A;     ///< of the three phases, over the last window
    float first_u_V; ///< first point of the resistance
    float first_i_A;
    float sum_d, sum_q, sum_error;
    float least, greatest;
    float count;
} bringup_t;

/// Begins `mode` in any state of the drive, which is switched off first. Thread.
void bringup_begin(bringup_t *self, bringup_mode_t mode);

/// Evaluates once. Thread, at any rate. RUNNING until the end, then permanently PASS or FAIL.
bringup_state_t bringup_step(bringup_t *self, const bringup_view_t *view);

/// Requests `periods` more from the interrupt. Thread, when the last window is complete or no longer wanted.
void bringup_window_ask(volatile bringup_window_t *self, uint32_t periods);
/// Interrupt: the samples, and the duties computed from them.
void bringup_window_take(volatile bringup_window_t *self, const lode_counts_t *counts,
                         lode_abc_t duty);

#endif
