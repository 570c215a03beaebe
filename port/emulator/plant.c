#include "plant.h"

#include "motor.h"

#define PARTS 8 // of a period; the shortest time constant, Ld/R, has 190 of them
#define PART_s (1.0f / (PLANT_F_PWM_Hz * (float)PARTS))
#define V_BUS_V 200.0f
#define I_GAIN_A 0.0125f // per count: +-25.6 A
#define V_GAIN_V 0.1f    // per count
#define MID_COUNT 2048.0f
#define COUNT_MAX 4095.0f
#define SLOW_rad_s 3.0f // electrical; below it the load's torque falls to 0 at rest

void plant_init(plant_t *self) {
    *self = (plant_t){.rotor = {.sin = 0.29237f, .cos = 0.95630f}, .applied = {0.5f, 0.5f, 0.5f}};
}

void plant_describe(lode_drive_config_t *config) {
    config->f_pwm_Hz = PLANT_F_PWM_Hz;
    config->inverter = (lode_inverter_config_t){.v_bus_V = V_BUS_V, .i_max_A = MOTOR_I_MAX_A};
    config->sense = (lode_sense_config_t){
        .i_gain_A_count = I_GAIN_A, .i_offset_count = MID_COUNT, .v_bus_gain_V_count = V_GAIN_V};
    config->guard.stamp_per_period = (float)PLANT_STAMP_PER_PERIOD;
}

static uint16_t converted(float count) {
    return (uint16_t)(lode_clamp(count, 0.0f, COUNT_MAX) + 0.5f);
}

lode_counts_t plant_counts(const plant_t *self) {
    const lode_dq_t i = {self->id_A, self->iq_A};
    const lode_abc_t phase = lode_clarke_inverse(lode_park_inverse(i, self->rotor));
    return (lode_counts_t){.i = {converted(MID_COUNT + phase.a / I_GAIN_A),
                                 converted(MID_COUNT + phase.b / I_GAIN_A),
                                 converted(MID_COUNT + phase.c / I_GAIN_A)},
                           .v_bus = converted(V_BUS_V / V_GAIN_V)};
}

// Rise of the current per second under the voltage `u`.
static lode_dq_t current_rise(const lode_motor_t *m, float omega, lode_dq_t u, lode_dq_t i) {
    return (lode_dq_t){(u.d - m->Rs_Ohm * i.d + omega * m->Lq_H * i.q) / m->Ld_H,
                       (u.q - m->Rs_Ohm * i.q - omega * (m->Ld_H * i.d + m->psi_Wb)) / m->Lq_H};
}

// Rotated by a small angle and normalised to length 1, because rounding would accumulate.
static lode_sincos_t advanced(lode_sincos_t a, float x) {
    const float c = 1.0f - 0.5f * x * x;
    const float s = x - x * x * x * (1.0f / 6.0f);
    const lode_sincos_t b = {a.sin * c + a.cos * s, a.cos * c - a.sin * s};
    const float to_one = 1.5f - 0.5f * (b.sin * b.sin + b.cos * b.cos);
    return (lode_sincos_t){to_one * b.sin, to_one * b.cos};
}

static void carry(plant_t *self, const lode_motor_t *m, lode_ab_t u_V) {
    const lode_sincos_t middle = advanced(self->rotor, 0.5f * PART_s * self->omega_rad_s);
    const lode_dq_t u = lode_park(u_V, middle);
    const lode_dq_t i = {self->id_A, self->iq_A};
    const lode_dq_t first = current_rise(m, self->omega_rad_s, u, i);
    const lode_dq_t half = {i.d + 0.5f * PART_s * first.d, i.q + 0.5f * PART_s * first.q};
    const lode_dq_t rise = current_rise(m, self->omega_rad_s, u, half);
    self->id_A = i.d + PART_s * rise.d;
    self->iq_A = i.q + PART_s * rise.q;
}

static void turn_rotor(plant_t *self, const lode_motor_t *m) {
    const float saliency_Wb = (m->Ld_H - m->Lq_H) * self->id_A;
    const float torque_Nm = 1.5f * m->pole_pairs * (m->psi_Wb + saliency_Wb) * self->iq_A;
    const float slow = lode_clamp(self->omega_rad_s / SLOW_rad_s, -1.0f, 1.0f);
    const float drag_Nm = self->load_Nm * slow + m->B_Nms * self->omega_rad_s / m->pole_pairs;
    self->rotor = advanced(self->rotor, PART_s * self->omega_rad_s);
    self->omega_rad_s += PART_s * m->pole_pairs * (torque_Nm - drag_Nm) / m->J_kgm2;
}

void plant_period(plant_t *self, const lode_drive_out_t *out) {
    const lode_motor_t m = motor_data();
    const lode_ab_t share = lode_clarke(self->applied);
    const lode_ab_t u_V = {V_BUS_V * share.alpha, V_BUS_V * share.beta};
    for (int32_t part = 0; part < PARTS; part++) {
        if (out->gates) {
            carry(self, &m, u_V);
        } else { // the bus is above the EMF: the diodes let the current die at once
            self->id_A = 0.0f;
            self->iq_A = 0.0f;
        }
        turn_rotor(self, &m);
    }
    self->applied = out->duty;
}
