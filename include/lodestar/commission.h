/// Self-commissioning: the parameters of motor and inverter, measured by the drive itself in under 10 s, if the motor's
/// start takes less than half of them (docs/commissioning.md).
///
/// First the sensors, by voltage pulses too short to turn a rotor. Then, with the rotor held by a current, resistance,
/// dead-time voltage and inductances. Then flux, inertia and friction, from running up and down with a free shaft. Only
/// commands of the drive are used, so all limits and the guard apply.
/// For three phases; six phases: commission6.h. LODE_WITHOUT_COMMISSIONING leaves both out of a build.
///
/// Interrupt: lode_commission_step() instead of lode_drive_step().
/// Main loop: lode_commission_work() repeatedly, as long as it returns RUNNING.
#ifndef LODESTAR_COMMISSION_H
#define LODESTAR_COMMISSION_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifndef LODE_WITHOUT_COMMISSIONING

/// The measured quantities: index of lode_commission_t.found.
typedef enum {
    LODE_COMMISSION_OFFSET_A, ///< ADC count at zero current; next two: phases b and c
    LODE_COMMISSION_OFFSET_B,
    LODE_COMMISSION_OFFSET_C,
    LODE_COMMISSION_OFFSET_A2, ///< the same for set 2, if there are six phases
    LODE_COMMISSION_OFFSET_B2,
    LODE_COMMISSION_OFFSET_C2,
    LODE_COMMISSION_SIGNALS, ///< number of phases whose sensor has the right sign and place: 3, or 6
    LODE_COMMISSION_RS_Ohm,  ///< winding and switches
    LODE_COMMISSION_DEAD_V, ///< voltage that a phase loses to dead time and drops at the present bus voltage
    /// at zero current if it falls with the current, otherwise at some 0.6 of the current that holds the rotor
    LODE_COMMISSION_LD_H,
    LODE_COMMISSION_LQ_H, ///< as Ld, along the q axis
    /// 1/Ld' is (1 + fall id)/Ld (N2); 0: the fall is below 5 % at the current that holds the rotor
    LODE_COMMISSION_LD_FALL_1_A,
    LODE_COMMISSION_LQ_FALL_1_A, ///< Lq is Lq_H/(1 + fall |iq|) (N4); 0: the fall is below 5 % at i_max
    LODE_COMMISSION_LXY_H,       ///< of the xy plane, if there are six phases
    LODE_COMMISSION_PSI_Wb,
    LODE_COMMISSION_J_kgm2, ///< of everything that rotates
    LODE_COMMISSION_B_Nms,  ///< friction torque over speed, at the mean speed of the run
    LODE_COMMISSION_QUANTITIES
} lode_commission_quantity_t;

/// Name of a quantity; that of the field of lode_drive_config_t if there is one.
const char *lode_commission_name(lode_commission_quantity_t quantity);

/// Result of a measurement and its consistency, 1/(1 + (d/l)^2): d is the deviation within the measurement, l the
/// permitted deviation. 0: not measured.
typedef struct {
    float value;
    float confidence;
} lode_commission_value_t;

/// A quantity with less confidence is refused.
#define LODE_COMMISSION_SURE 0.5f

/// State of the commissioning, and how it has ended.
typedef enum {
    LODE_COMMISSION_RUNNING,
    LODE_COMMISSION_DONE,
    LODE_COMMISSION_FAULT,      ///< the guard has tripped: drive.guard.fault
    LODE_COMMISSION_UNSURE,     ///< the confidence in `quantity` is too low
    LODE_COMMISSION_NO_CURRENT, ///< the voltage has reached its limit without the current
    LODE_COMMISSION_UNSETTLED,  ///< the rotor did not come to rest under a current
    LODE_COMMISSION_REFUSED,    ///< the drive refuses the measured values, or a command: `status`
    LODE_COMMISSION_NO_START    ///< the motor did not reach the speed of the run
} lode_commission_result_t;

/// The enumerator's name, for logs.
const char *lode_commission_result_name(lode_commission_result_t result);

/// ADC counts at zero current.
typedef struct {
    float least[LODE_PHASES];
    float most[LODE_PHASES];
    float sum[LODE_PHASES];
} lode_commission_counts_t;

/// Response to a pulse, at the instant of the largest current.
typedef struct {
    float length_A; ///< length of the current vector
    float xy_A;     ///< its length in the xy plane
    float phase_A[LODE_PHASES];
} lode_commission_peak_t;

/// State of a voltage vector that is raised and lowered.
typedef struct {
    float now_V;
    float most_V;
    float quick_V; ///< change per period until a current flows
    float slow_V;  ///< change per period afterwards
    float first_A; ///< current that was left when it began
    bool flows;    ///< a current has flowed
    bool rises;    ///< it is rising to the next level
} lode_commission_vector_t;

/// Sums over the halves of a time window in which the rotor should be at rest.
typedef struct {
    uint32_t count;
    float u_V;        ///< voltage along the vector
    lode_dq_t i_A[2]; ///< current, by half
} lode_commission_window_t;

/// Sums over small current steps: x is the voltage that causes y, the change of the current's slope (N1).
typedef struct {
    uint32_t count;
    float xx;
    float xy;
    float yy;
    float ixx; ///< of |i| x^2: mean current of the steps
} lode_commission_steps_t;

/// The same with two other causes of y in the q axis: z by the motion of the rotor, v by the saturation of the iron
/// (N6).
typedef struct {
    float xz;
    float yz;
    float zz;
    float xv;
    float yv;
    float vv;
    float zv;
} lode_commission_beside_t;

/// Current and flux that the half-waves have moved (N3).
typedef struct {
    float i_A;
    float flux_Vs;
} lode_commission_waves_t;

/// Sums over a run: time t, electrical speed w and flux voltage u, all relative to the first point, and their
/// products.
typedef struct {
    uint32_t count;
    uint32_t first; ///< control period of the first point
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

/// Sums of the present measurement; every stage starts with all of them 0.
typedef struct {
    lode_commission_window_t window;
    lode_commission_steps_t steps;
    lode_commission_beside_t beside;
    lode_commission_waves_t waves;
    lode_commission_line_t run;
    float mean_rad_s; ///< before a run: mean of the MECHANICAL speed
} lode_commission_sums_t;

/// Currents along an axis, and 1/L at them.
typedef struct {
    float i_A[3];
    float inverse_1_H[3];
} lode_commission_fall_t;

/// Result of a run in one direction.
typedef struct {
    float psi_Wb;
    float acc_rad_s2; ///< MECHANICAL, as omega_rad_s
    float torque_Nm;
    float omega_rad_s;
} lode_commission_run_t;

/// The commissioning. The members are visible for static allocation; only the functions below write them. The first
/// ones are the result.
typedef struct {
    lode_drive_t *drive;
    lode_commission_value_t found[LODE_COMMISSION_QUANTITIES];
    lode_commission_quantity_t quantity; ///< present quantity, or the refused one
    lode_status_t status;                ///< after REFUSED: why
    lode_commission_result_t result;
    float reached_rad_s; ///< MECHANICAL; after NO_START, if the motor turns: its speed
    float wanted_rad_s;  ///< MECHANICAL; the speed that it did not reach; 0: it did not start
    float reached_A;     ///< after NO_CURRENT: the current that flowed instead of current_A
    // Internal from here on.
    lode_drive_config_t config;   ///< the given configuration with what has been measured
    lode_drive_config_t designed; ///< the same, completed
    lode_drive_tuning_t *tuning;  ///< two tunings; NULL with six phases
    uint32_t sets;
    float axis_rad; ///< axis along which the rotor is held
    lode_sincos_t axis;
    float current_A; ///< current that holds it
    uint32_t stage;
    uint32_t since;       ///< control periods of the present stage
    uint32_t level;       ///< step within the stage: phase, current or amplitude
    uint32_t tries;       ///< pulses of a phase with too little current
    uint32_t calm;        ///< windows in a row without a change; before a run: periods at its speed
    bool wants_tuning;    ///< the main loop has to make the next tuning
    lode_dq_t before_u_V; ///< voltage of the last period
    lode_dq_t before_i_A[2]; ///< currents of the last two periods
    lode_commission_sums_t sums;
    lode_commission_counts_t counts;
    lode_commission_peak_t peak;
    lode_commission_vector_t vector;
    float level_u_V[3];
    float level_i_A[3];
    float near_A; ///< mean current of the small steps in q
    lode_commission_fall_t fall_d;
    lode_commission_fall_t fall_q;
    float xy_V;      ///< amplitude of the disturbance of the xy current control
    float pushed_V;  ///< its present value
    float push_V;    ///< its change in this period
    uint32_t runs;   ///< runs so far, up and down
    uint32_t lost;   ///< number of times that the rotor was lost in a run
    float low_rad_s; ///< MECHANICAL speeds between which the run goes
    float high_rad_s;
    float torque_Nm; ///< torque of the run
    uint32_t raises; ///< number of times that it was raised on the way up
    float load_Nm;   ///< additional torque on the way up, for friction that the last run has shown
    lode_commission_run_t way[2]; ///< results: up, down
} lode_commission_t;

// Its name tells what is left out of the build (options.h).
#define lode_commission_init LODE_SYMBOL(lode_commission_init)

/// Begins. `config` gives what is known: f_pwm, inverter and sense as for lode_drive_init(), and the motor values
/// of the data sheet: R within 30 %, inductances within 20 %, flux within 10 %, dead time within 1.5 us, J within a
/// factor of three. The commissioning runs its own drive in `drive`, on the two `tuning` in turn: one is in use while
/// the next one is made. All of them are free afterwards. Errors: NULL; MOTOR_SETS with six phases; those of
/// lode_drive_init().
lode_status_t lode_commission_init(lode_commission_t *self, lode_drive_t *drive,
                                   lode_drive_tuning_t tuning[2],
                                   const lode_drive_config_t *config);

/// One control period, for the PWM interrupt.
lode_drive_out_t lode_commission_step(lode_commission_t *self, const lode_counts_t *counts);

/// Does what takes too long for the interrupt; for the main loop. Returns the state.
lode_commission_result_t lode_commission_work(lode_commission_t *self);

/// The given configuration with the measured values. Only after LODE_COMMISSION_DONE.
const lode_drive_config_t *lode_commission_config(const lode_commission_t *self);

#endif

#ifdef __cplusplus
}
#endif

#endif
