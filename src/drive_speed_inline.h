// Speed control and references of RUN, in their slots (drive_slots_inline.h) or more often (lode_drive_fast_speed()).
#ifndef LODE_DRIVE_SPEED_INLINE_H
#define LODE_DRIVE_SPEED_INLINE_H

#include "drive_parts.h"
#include "estimator_inline.h"
#include "mode.h"
#include "references_inline.h"
#include "speed_inline.h"

// They run once per round, in their slots.
LODE_INLINE bool lode_drive_speed_once(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_FAST_SPEED
    (void)self;
    return true;
#else
    return self->tuning->speed_periods == LODE_SLOW_PERIODS;
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
    if (!lode_speed_is_whole(&run->speed)) {
        return; // MEMORY, in SLOT_DEAD_TIME
    }
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
    run->speed.limit_Nm = lode_mode_torque_limits(self, out.torque_Nm);
}

#endif
