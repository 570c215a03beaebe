#include "motor.h"

#include <math.h>

#define PARTS 16         // of a period, for the equations
#define FREE_SHARE 0.1   // of the load that stays on a free shaft
#define FREE_rad_s 40.0  // below which it falls
#define BRAKE_Nms 0.02   // rise of the brake's torque with speed
#define GRIP_A 8.0       // below which the machine hardly sees the vector
#define DRAG_rad_s 300.0 // natural frequency with which the machine follows the current vector

#define TORQUE_PER_A (1.5 * (double)BENCH_POLE_PAIRS * (double)BENCH_PSI_Wb)

static const double pi = 3.14159265358979324;

static double clamped(double x, double limit) {
    return fmax(fmin(x, limit), -limit);
}

// What a phase loses of its duty to the dead time while it carries a current.
static double lost_duty(double i_A) {
    return (double)(BENCH_DEAD_TIME_s * BENCH_F_PWM_Hz) *
           clamped(i_A / (double)BENCH_I_DEAD_A, 1.0);
}

static double axis_rad(int set, int phase) {
    return pi / 6.0 * set + 2.0 * pi / 3.0 * phase;
}

void motor_phases(const motor_t *motor, int set, double i_A[3]) {
    for (int k = 0; k < 3; k++) {
        const double axis = axis_rad(set, k);
        const double angle = motor->theta_rad - axis;
        i_A[k] = motor->id_A * cos(angle) - motor->iq_A * sin(angle) +
                 motor->x_A * cos(5.0 * axis) + motor->y_A * sin(5.0 * axis);
    }
}

static double load_Nm(const motor_t *m, shaft_t shaft) {
    const double rated_Nm = TORQUE_PER_A * (double)BENCH_IQ_A;
    if (shaft == SHAFT_FREE) {
        return FREE_SHARE * rated_Nm * clamped(m->omega_rad_s / FREE_rad_s, 1.0);
    }
    const double above = m->omega_rad_s - m->braked_rad_s;
    return rated_Nm + BRAKE_Nms * above / (double)BENCH_POLE_PAIRS;
}

static void turn(motor_t *m, double h, shaft_t shaft) {
    double slide = 0.0;
    if (shaft == SHAFT_DRAGGED) { // a second-order loop on the angle between current and q axis
        const double grip = clamped(hypot(m->id_A, m->iq_A) / GRIP_A, 1.0);
        const double ahead = grip * atan2(-m->id_A, m->iq_A);
        m->omega_rad_s += h * DRAG_rad_s * DRAG_rad_s * ahead;
        slide = 2.0 * DRAG_rad_s * ahead;
    } else {
        const double reluctance = (m->Ld_H - (double)BENCH_L_H) / (double)BENCH_PSI_Wb * m->id_A;
        const double torque_Nm = TORQUE_PER_A * (1.0 + reluctance) * m->iq_A - load_Nm(m, shaft);
        m->omega_rad_s += h * (double)BENCH_POLE_PAIRS * torque_Nm / (double)BENCH_J_kgm2;
    }
    m->theta_rad = remainder(m->theta_rad + h * (m->omega_rad_s + slide), 2.0 * pi);
}

static void carry(motor_t *m, double h, double alpha_V, double beta_V) {
    const double R = (double)BENCH_RS_Ohm;
    const double Ld = m->Ld_H * (1.0 - m->Ld_fall_per_A * m->id_A);
    const double Lq = (double)BENCH_L_H;
    const double w = m->omega_rad_s;
    const double middle = m->theta_rad + 0.5 * h * w;
    const double ud = alpha_V * cos(middle) + beta_V * sin(middle);
    const double uq = beta_V * cos(middle) - alpha_V * sin(middle);
    const double rise_d = (ud - R * m->id_A + w * Lq * m->iq_A) / Ld;
    const double rise_q = (uq - R * m->iq_A - w * (Ld * m->id_A + (double)BENCH_PSI_Wb)) / Lq;
    m->id_A += h * rise_d;
    m->iq_A += h * rise_q;
}

// Voltage vector of a set behind its inverter.
static void apply(const motor_t *m, int set, lode_abc_t duty, double v_bus_V, double u_V[2]) {
    const double on[3] = {(double)duty.a, (double)duty.b, (double)duty.c};
    double i[3];
    motor_phases(m, set, i);
    u_V[0] = u_V[1] = 0.0;
    for (int k = 0; k < 3; k++) {
        const double leg = 2.0 / 3.0 * v_bus_V * (on[k] - lost_duty(i[k]));
        u_V[0] += leg * cos(axis_rad(set, k));
        u_V[1] += leg * sin(axis_rad(set, k));
    }
}

static void carry_xy(motor_t *m, double h, double x_V, double y_V) {
    m->x_A += h * (x_V - (double)BENCH_RS_Ohm * m->x_A) / (double)BENCH_LXY_H;
    m->y_A += h * (y_V - (double)BENCH_RS_Ohm * m->y_A) / (double)BENCH_LXY_H;
}

void motor_period(motor_t *motor, const lode_drive_out_t *applied, double v_bus_V, shaft_t shaft) {
    const double h = 1.0 / (double)BENCH_F_PWM_Hz / PARTS;
    const int other = motor->sets - 1;
    motor->u_alpha_V = motor->u_beta_V = 0.0;
    for (int part = 0; part < PARTS; part++) {
        double u[2];
        double v[2];
        apply(motor, 0, applied[0].duty, v_bus_V, u);
        apply(motor, other, applied[other].duty, v_bus_V, v);
        const double alpha = 0.5 * (u[0] + v[0]);
        const double beta = 0.5 * (u[1] + v[1]);
        if (applied[0].gates) {
            carry(motor, h, alpha, beta);
            carry_xy(motor, h, 0.5 * (u[0] - v[0]), 0.5 * (v[1] - u[1]));
        } else { // the bus is well above the EMF: nothing flows
            motor->id_A = motor->iq_A = motor->x_A = motor->y_A = 0.0;
        }
        motor->u_alpha_V += alpha / PARTS;
        motor->u_beta_V += beta / PARTS;
        turn(motor, h, shaft);
    }
}
