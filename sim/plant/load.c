#include "plant/load.h"

#include <math.h>

#define TWO_PI 6.28318530717958647693

void plant_load_init(plant_motor_t *motor, const plant_config_t *config) {
    motor->load = (plant_load_t){
        .fan_Nms2 = config->fan_Nms2,
        .stiction_Nm = config->stiction_Nm,
        .load_ripple = config->load_ripple,
        .cogging_Nm = config->cogging_Nm,
        .cogging_per_turn = config->cogging_per_turn,
        .J_kgm2 = config->load_J_kgm2,
        .shaft_Nm_rad = config->shaft_Nm_rad,
        .shaft_Nms_rad = config->shaft_Nms_rad,
        .half_gap_rad = 0.5 * config->backlash_rad,
    };
    const plant_load_t *load = &motor->load;
    motor->has_load = load->fan_Nms2 > 0.0 || load->stiction_Nm > 0.0 || load->load_ripple > 0.0 ||
                      load->cogging_Nm > 0.0 || load->J_kgm2 > 0.0;
    motor->x.load_omega_rad_s = motor->x.omega_m_rad_s;
    motor->x.twist_rad = 0.0;
}

static double mechanical_rad(const plant_motor_t *m, const plant_motor_state_t *x) {
    return (x->theta_e_rad + TWO_PI * (double)m->turns) / m->np;
}

/// (M10), on the second mass.
static double shaft_torque(const plant_load_t *load, const plant_motor_state_t *x) {
    const double beyond = fabs(x->twist_rad) - load->half_gap_rad;
    if (!(beyond > 0.0)) {
        return 0.0;
    }
    return load->shaft_Nm_rad * copysign(beyond, x->twist_rad) +
           load->shaft_Nms_rad * (x->omega_m_rad_s - x->load_omega_rad_s);
}

/// (M8) against the speed `omega` of a mass driven by `push_Nm`; the fan torque uses the speed half a step later.
static plant_shaft_t opposed(const plant_motor_t *m, double push_Nm, double angle_rad, double omega,
                             double inv_J, double half_s) {
    const plant_load_t *load = &m->load;
    const double constant = m->load_Nm * (1.0 + load->load_ripple * cos(angle_rad));
    const double rest = push_Nm - (m->load_is_passive ? copysign(constant, omega) : constant);
    const double now = load->fan_Nms2 * omega * fabs(omega);
    const double middle = omega + half_s * inv_J * (rest - now);
    const double fan = load->fan_Nms2 * middle * fabs(middle);
    if (!m->load_is_passive) {
        return (plant_shaft_t){constant + fan, inv_J};
    }
    const double strength = fabs(constant);
    const bool at_rest = !(omega > 0.0) && !(omega < 0.0);
    if (at_rest && fabs(push_Nm) <= strength + load->stiction_Nm) {
        return (plant_shaft_t){0.0, 0.0};
    }
    return (plant_shaft_t){copysign(strength, at_rest ? push_Nm : omega) + fan, inv_J};
}

plant_shaft_t plant_load_shaft(const plant_motor_t *motor, double torque_Nm, double h_s) {
    const plant_load_t *load = &motor->load;
    const plant_motor_state_t *x = &motor->x;
    if (motor->speed_is_prescribed) {
        return (plant_shaft_t){0.0, 0.0};
    }
    const double half_s = 0.5 * h_s;
    const double angle_rad = mechanical_rad(motor, x) + half_s * x->omega_m_rad_s;
    const double cogging = load->cogging_Nm * sin(load->cogging_per_turn * angle_rad);
    if (load->J_kgm2 > 0.0) {
        return (plant_shaft_t){cogging + shaft_torque(load, x), motor->inv_J};
    }
    plant_shaft_t shaft =
        opposed(motor, torque_Nm - cogging, angle_rad, x->omega_m_rad_s, motor->inv_J, half_s);
    shaft.load_Nm += shaft.inv_J > 0.0 ? cogging : 0.0;
    return shaft;
}

void plant_load_follow(plant_motor_t *motor, const plant_motor_state_t *before, double h_s) {
    const plant_load_t *load = &motor->load;
    plant_motor_state_t *x = &motor->x;
    // Speeds from the torque at the start, then the twist from the new speeds: this adds no damping and no
    // energy to an oscillation.
    const double push = shaft_torque(load, before);
    const double omega = before->load_omega_rad_s;
    const plant_shaft_t shaft =
        opposed(motor, push, mechanical_rad(motor, before) - before->twist_rad, omega,
                1.0 / load->J_kgm2, 0.5 * h_s);
    const double next = omega + h_s * shaft.inv_J * (push - shaft.load_Nm);
    x->load_omega_rad_s = motor->load_is_passive && omega * next < 0.0 ? 0.0 : next;
    x->twist_rad += h_s * (x->omega_m_rad_s - x->load_omega_rad_s);
}

bool plant_load_stops(const plant_motor_t *motor) {
    return motor->load_is_passive && !motor->speed_is_prescribed && !(motor->load.J_kgm2 > 0.0);
}

double plant_load_swing2(const plant_motor_t *motor) {
    const plant_load_t *load = &motor->load;
    const double cogging = load->cogging_Nm * load->cogging_per_turn * motor->inv_J;
    return load->J_kgm2 > 0.0 ? cogging + load->shaft_Nm_rad * (motor->inv_J + 1.0 / load->J_kgm2)
                              : cogging;
}
