/// Self-commissioning: parameters of motor and inverter, measured by the drive itself in under 10 s.
///
/// Sensors first, by voltage pulses too short to turn a rotor; then resistance, dead-time voltage and
/// inductances with the rotor held by a current; then flux, inertia and friction from running up and down
/// with a free shaft. It uses only the drive's own commands, so all limits and the guard stay active.
/// Three phases; six: commission6.h. LODE_WITHOUT_COMMISSIONING leaves both out of a build.
///
/// Interrupt: lode_commission_step() in place of lode_drive_step().
/// Thread:    lode_commission_work() again and again until it no longer returns RUNNING.
#ifndef LODESTAR_COMMISSION_H
#define LODESTAR_COMMISSION_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifndef LODE_WITHOUT_COMMISSIONING

typedef enum {
    LODE_COMMISSION_OFFSET_A, ///< count at zero current; the next two: phases b and c
    LODE_COMMISSION_OFFSET_B,
    LODE_COMMISSION_OFFSET_C,
    LODE_COMMISSION_OFFSET_A2, ///< of set 2, with six phases
    LODE_COMMISSION_OFFSET_B2,
    LODE_COMMISSION_OFFSET_C2,
    LODE_COMMISSION_SIGNALS, ///< phases whose sensor has the right sign and position: 3, or 6
    LODE_COMMISSION_RS_Ohm,  ///< winding and switches
    LODE_COMMISSION_DEAD_V, ///< what a phase loses to dead time and drops at the present bus voltage
    LODE_COMMISSION_LD_H, ///< at zero current where it falls, else at some 0.6 of the holding current
    LODE_COMMISSION_LQ_H, ///< the same
    LODE_COMMISSION_LD_FALL_1_A, ///< 1/Ld' is (1 + fall id)/Ld (N2); 0: less than 5 % at the holding current
    LODE_COMMISSION_LQ_FALL_1_A, ///< Lq is Lq_H/(1 + fall |iq|) (N4); 0: less than 5 % at i_max
    LODE_COMMISSION_LXY_H,       ///< of the xy plane, with six phases
    LODE_COMMISSION_PSI_Wb,
    LODE_COMMISSION_J_kgm2, ///< of everything that rotates
    LODE_COMMISSION_B_Nms,  ///< friction over speed, at the mean speed of the run
    LODE_COMMISSION_QUANTITIES
} lode_commission_quantity_t;

/// Name of a quantity, as in lode_drive_config_t where it is a field of that.
const char *lode_commission_name(lode_commission_quantity_t quantity);

/// Result of a measurement, and how far it agrees with itself: 1/(1 + (d/l)^2), where d is the deviation that
/// it shows and l the allowed one. 0: not measured.
typedef struct {
    float value;
    float confidence;
} lode_commission_value_t;

/// Below this confidence a quantity is refused.
#define LODE_COMMISSION_SURE 0.5f

typedef enum {
    LODE_COMMISSION_RUNNING,
    LODE_COMMISSION_DONE,
    LODE_COMMISSION_FAULT,      ///< the guard tripped: drive.guard.fault
    LODE_COMMISSION_UNSURE,     ///< `quantity` was measured with too little confidence
    LODE_COMMISSION_NO_CURRENT, ///< the voltage reached its limit before the current was reached
    LODE_COMMISSION_UNSETTLED,  ///< the rotor did not come to rest with a holding current
    LODE_COMMISSION_REFUSED,    ///< the drive refuses what was measured: `status`
    LODE_COMMISSION_NO_START    ///< the motor did not reach the speed
} lode_commission_result_t;

/// The enumerator's name, for logs.
const char *lode_commission_result_name(lode_commission_result_t result);

/// Counts at zero current.
typedef struct {
    float least[LODE_PHASES];
    float most[LODE_PHASES];
    float sum[LODE_PHASES];
} lode_commission_counts_t;

/// A pulse, at the instant of the largest current.
typedef struct {
    float length_A; ///< of the vector
    float xy_A;     ///< length in the xy plane
    float phase_A[LODE_PHASES];
} lode_commission_peak_t;

/// A voltage vector that is raised and lowered.
typedef struct {
    float now_V;
    float most_V;
    float quick_V; ///< change per period until there is some current
    float slow_V;  ///< and afterwards
    bool flows;    ///< some current has flowed
    bool rises;    ///< to the next level
} lode_commission_vector_t;

/// Sums over half-windows of a rotor at rest.
typedef struct {
    uint32_t count;
    float u_V; ///< along the vector
    lode_dq_t i_A[2];
} lode_commission_window_t;

/// Sums over small steps: x is the voltage that makes y, the change of the current's slope (N1).
typedef struct {
    uint32_t count;
    float xx;
    float xy;
    float yy;
    float ixx; ///< weighs the current
} lode_commission_steps_t;

/// The same with what else changes the q current: z by the rotor, v by the iron (N6).
typedef struct {
    float xz;
    float yz;
    float zz;
    float xv;
    float yv;
    float vv;
    float zv;
} lode_commission_beside_t;

/// What half-waves have moved: current and flux.
typedef struct {
    float i_A;
    float flux_Vs;
} lode_commission_waves_t;

/// Sums over a run: time, electrical speed, voltage induced by the flux, from the first point on, and their products.
typedef struct {
    uint32_t count;
    uint32_t first; ///< period of that point
    float first_rad_s;
    float first_V;
    float t;
    float w;
    float u;
    float tt;
    float tw;
    float ww;
    float wu;
    lode_dq_t i_A;
} lode_commission_line_t;

/// Sums of the present measurement: each stage begins with all of them at 0.
typedef struct {
    lode_commission_window_t window;
    lode_commission_steps_t steps;
    lode_commission_beside_t beside;
    lode_commission_waves_t waves;
    lode_commission_line_t run;
} lode_commission_sums_t;

/// Currents along an axis, and 1/L there.
typedef struct {
    float i_A[3];
    float inverse_1_H[3];
} lode_commission_fall_t;

/// Result of a run in one direction, up or down.
typedef struct {
    float psi_Wb;
    float acc_rad_s2; ///< of the shaft, like the speed
    float torque_Nm;
    float omega_rad_s;
} lode_commission_run_t;

typedef struct {
    lode_drive_t *drive;
    lode_commission_value_t found[LODE_COMMISSION_QUANTITIES];
    lode_commission_quantity_t quantity; ///< being measured, or refused
    lode_status_t status;
    lode_commission_result_t result;
    float reached_rad_s; ///< after NO_START, if the motor turns: its speed
    float wanted_rad_s;  ///< and the one that it did not reach; 0: it did not start
    // Internal from here on.
    lode_drive_config_t config;   ///< as given, then with what was found
    lode_drive_config_t designed; ///< the same, complete
    lode_drive_tuning_t *tuning;  ///< two; NULL with six phases
    uint32_t sets;
    float axis_rad; ///< axis along which the rotor is held
    lode_sincos_t axis;
    float current_A; ///< holding current
    uint32_t stage;
    uint32_t since; ///< periods in that stage
    uint32_t level; ///< within a stage: phase, current, amplitude
    uint32_t tries; ///< pulses of a phase with too little current
    uint32_t calm;  ///< windows in a row without a change; before a run, periods at its speed
    bool wants_tuning;
    lode_dq_t before_u_V; ///< of the last period
    lode_dq_t before_i_A[2];
    lode_commission_sums_t sums;
    lode_commission_counts_t counts;
    lode_commission_peak_t peak;
    lode_commission_vector_t vector;
    float level_u_V[3];
    float level_i_A[3];
    float near_A; ///< mean current of the small steps in q
    lode_commission_fall_t fall_d;
    lode_commission_fall_t fall_q;
    float xy_V;      ///< voltage added to the control of the xy plane, of either sign
    float pushed_V;  ///< as added now
    float push_V;    ///< its change in this period
    uint32_t runs;   ///< up and down
    uint32_t lost;   ///< times that the rotor was lost in a run
    float low_rad_s; ///< of the run
    float high_rad_s;
    float torque_Nm;
    uint32_t raises;              ///< times that the torque was raised on the way up
    float load_Nm;                ///< added to it on the way up, as far as there is a load
    lode_commission_run_t way[2]; ///< up, down
} lode_commission_t;

/// `config` is what is known: f_pwm, inverter and sense as for lode_drive_init(), and the motor by its data
/// sheet: R within 30 %, inductances and flux within 20 %, J within a factor of three. It runs its
/// own drive in `drive` and the two tunings, which are free again afterwards: one is in use while the next is made.
lode_status_t lode_commission_init(lode_commission_t *self, lode_drive_t *drive,
                                   lode_drive_tuning_t tuning[2],
                                   const lode_drive_config_t *config);

/// One PWM period.
lode_drive_out_t lode_commission_step(lode_commission_t *self, const lode_counts_t *counts);

/// Does what takes too long for the interrupt. Returns the present state or result.
lode_commission_result_t lode_commission_work(lode_commission_t *self);

/// The configuration with what was found in it. Only after LODE_COMMISSION_DONE.
const lode_drive_config_t *lode_commission_config(const lode_commission_t *self);

#endif

#ifdef __cplusplus
}
#endif

#endif
