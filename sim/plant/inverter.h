/// Two-level inverter: which device conducts in each leg, and when that changes.
///
/// A transistor conducts only away from its rail, the diode across it only the other way. A leg
/// with its current out of the inverter (i > 0) therefore sits at `low`, with i < 0 at `high`:
///     gate    low                high                 (drops; r_on acts as part of the winding)
///     HIGH    v_bus - v_tr       v_bus + v_diode
///     LOW     -v_diode           v_tr
///     OFF     -v_diode           v_bus + v_diode
/// A leg whose current reaches zero carries none as long as its terminal, moved by the motor alone,
/// stays between the two. This one rule gives ordinary conduction, the zero-current clamping of the
/// dead time, floating phases and rectification with all gates off. A leg that has lost its phase
/// (plant_inverter_open) never carries current again.
///
/// Without drops low and high are the same while a gate is on: the current then passes through zero
/// and nothing changes but the sign.
///
/// With two winding sets six legs share one bus; the gates of each set are switched separately.
#ifndef PLANT_INVERTER_H
#define PLANT_INVERTER_H

#include "plant/motor.h"
#include "plant/pwm.h"

/// A current this small with the wrong sign is a residue of the zero search, not a crossing.
#define PLANT_NOISE_A 2e-5

typedef struct {
    plant_pwm_t pwm;
    int sign;        ///< of the current: +1 out of the inverter, -1 into it, 0 none
    double source_V; ///< behind r_on; 0 while it carries no current
    double rail;     ///< share of the leg's current that comes from the positive rail, 0..1
    bool dead[2];    ///< the low, the high side's transistor no longer turns on; its diode conducts
    bool shorted[2]; ///< the low, the high side conducts whatever the gates say
    /// its next gate edge that moves the terminal; infinite if there is none; valid once searched
    double next_s;
    bool opening; ///< the phase opens at the next zero of its current ...
    bool open;    ///< ... and stays so
} plant_leg_t;

typedef struct {
    plant_leg_t leg[PLANT_LEGS];
    int sets;
    plant_drive_t drive;        ///< the voltages at the motor
    bool averaging[PLANT_SETS]; ///< legs are now ideal sources of duty * v_bus
    bool has_next;              ///< next_s is valid in this period
    double v_bus_V;
    double period_s, dead_time_s, v_transistor_V, v_diode_V, r_on_Ohm, Rs_Ohm;
    uint32_t pwm_ticks;
    plant_level_t level;
    bool has_drops;
} plant_inverter_t;

/// The table above: the lower and upper limit of a leg's terminal ...
static inline double plant_inverter_low_V(const plant_inverter_t *self, plant_gate_t gate) {
    return gate == PLANT_GATE_HIGH ? self->v_bus_V - self->v_transistor_V : -self->v_diode_V;
}

static inline double plant_inverter_high_V(const plant_inverter_t *self, plant_gate_t gate) {
    return gate == PLANT_GATE_LOW ? self->v_transistor_V : self->v_bus_V + self->v_diode_V;
}

/// ... and where it is while the leg conducts; whether the current then comes from the positive rail.
static inline double plant_inverter_source_V(const plant_inverter_t *self, plant_gate_t gate,
                                             int sign) {
    return sign > 0 ? plant_inverter_low_V(self, gate) : plant_inverter_high_V(self, gate);
}

static inline bool plant_inverter_on_high_rail(plant_gate_t gate, int sign) {
    return sign > 0 ? gate == PLANT_GATE_HIGH : gate != PLANT_GATE_LOW;
}

/// A change of conduction inside a stretch.
typedef struct {
    double after_s; ///< from the start of the stretch
    int leg;        ///< PLANT_ALL_FLOAT: some of the three floating ones of a set will start
    int sign;       ///< of the current from then on; 0: it stopped
} plant_event_t;

void plant_inverter_init(plant_inverter_t *self, const plant_config_t *config);

/// Starts a PWM period. Duties outside 0..1 count as the nearer end.
void plant_inverter_begin(plant_inverter_t *self, plant_motor_t *motor,
                          const plant_duty_t duty[PLANT_LEGS],
                          const plant_gates_t gates[PLANT_SETS]);

/// Current from the positive rail into the legs of a set now, which is that of a shunt in its return.
double plant_inverter_link_A(const plant_inverter_t *self, const double i_A[PLANT_LEGS], int set);

/// The phase of a leg breaks: at the next zero of its current, or at once without current.
void plant_inverter_open(plant_inverter_t *self, const plant_motor_t *motor, int leg);

/// From the next period on one switch of a leg, the high one or the low one, no longer turns on, or is
/// shorted. At the switching level only. A short wins over the other switch, which would have to carry the
/// short circuit of the bus: its own trip is not simulated.
void plant_inverter_fail(plant_inverter_t *self, int leg, bool high, bool shorted);

/// Time of the next gate edge that changes a terminal voltage; `limit_s` if there is none before.
/// An edge that moves the current from a diode to the transistor of the other direction does not count.
double plant_inverter_next_edge(plant_inverter_t *self, double limit_s);

/// Makes the gate edges up to now and finds which devices conduct.
void plant_inverter_settle(plant_inverter_t *self, plant_motor_t *motor, double now_s);

/// The same if no current has started or stopped since: checks only the legs that switch.
void plant_inverter_switch(plant_inverter_t *self, plant_motor_t *motor, double now_s);

/// Removes the integration error of currents that stay zero for a long time.
void plant_inverter_clear(const plant_inverter_t *self, plant_motor_t *motor);

/// True if conduction changed in the stretch from `before`, at now_s, to the motor's present state,
/// h_s later.
bool plant_inverter_find_event(const plant_inverter_t *self, const plant_motor_t *motor,
                               const plant_motor_state_t *before, const plant_stretch_t *stretch,
                               double now_s, double h_s, plant_event_t *event);

/// Reverses the signs of currents that passed through zero without an event.
void plant_inverter_follow_signs(plant_inverter_t *self, const plant_motor_t *motor, double now_s);

/// Applies the event; the motor is at its instant.
void plant_inverter_take_event(plant_inverter_t *self, plant_motor_t *motor,
                               const plant_event_t *event);

/// Takes the signs from the currents.
void plant_inverter_adopt_signs(plant_inverter_t *self, const plant_motor_t *motor);

#endif
