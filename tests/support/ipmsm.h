/// A salient motor in double at a given speed, fed with voltages held over each period.
///
/// In the rotor's frame, w = dtheta/dt:
///     Ld did/dt = ud - R id + w Lq iq,   Lq diq/dt = uq - R iq - w (Ld id + psi)
/// by Runge-Kutta of order 4 in steps far below every time constant (error below 1e-9 A).
#ifndef SUPPORT_IPMSM_H
#define SUPPORT_IPMSM_H

#include "support/check.h"

#include "lodestar/frames.h"

typedef struct {
    double R, Ld, Lq, psi;
    double id, iq, theta, omega; ///< now
    double acc;                  ///< of the rotor, electrical
    double Ld_per_A; ///< by which the differential Ld moves with id: the iron of the magnets
} ipmsm_t;

/// Table 3's motor at rest in the air, turning.
static inline ipmsm_t ipmsm_paper(double omega) {
    return (ipmsm_t){
        .R = 0.75, .Ld = 3.5e-3, .Lq = 9.8e-3, .psi = 0.142, .theta = 0.3, .omega = omega};
}

static inline void ipmsm_slope(const ipmsm_t *m, double ua, double ub, double t, const double x[2],
                               double out[2]) {
    const double theta = m->theta + t * (m->omega + 0.5 * t * m->acc);
    const double w = m->omega + t * m->acc;
    const double ud = ua * cos(theta) + ub * sin(theta);
    const double uq = ub * cos(theta) - ua * sin(theta);
    const double more = 0.5 * m->Ld_per_A * x[0]; // of psi_d over id
    out[0] = (ud - m->R * x[0] + w * m->Lq * x[1]) / (m->Ld + 2.0 * more);
    out[1] = (uq - m->R * x[1] - w * ((m->Ld + more) * x[0] + m->psi)) / m->Lq;
}

static inline void ipmsm_move(ipmsm_t *m, double ua, double ub, double h) {
    const double x[2] = {m->id, m->iq};
    double k[4][2];
    const double at[4] = {0.0, 0.5 * h, 0.5 * h, h};
    for (int s = 0; s < 4; s++) {
        const double y[2] = {x[0] + (s > 0 ? at[s] * k[s - 1][0] : 0.0),
                             x[1] + (s > 0 ? at[s] * k[s - 1][1] : 0.0)};
        ipmsm_slope(m, ua, ub, at[s], y, k[s]);
    }
    m->id += h / 6.0 * (k[0][0] + 2.0 * k[1][0] + 2.0 * k[2][0] + k[3][0]);
    m->iq += h / 6.0 * (k[0][1] + 2.0 * k[1][1] + 2.0 * k[2][1] + k[3][1]);
    m->theta = remainder(m->theta + h * (m->omega + 0.5 * h * m->acc), 2.0 * CHECK_PI);
    m->omega += h * m->acc;
}

/// One period with the voltage (ua, ub) held in the stationary frame.
static inline void ipmsm_step(ipmsm_t *m, double ua, double ub, double ts) {
    for (int n = 0; n < 8; n++) {
        ipmsm_move(m, ua, ub, ts / 8.0);
    }
}

/// The voltage that, held over the next period, keeps (id, iq) about where they are asked to be.
static inline lode_ab_t ipmsm_voltage(const ipmsm_t *m, double id, double iq, double ts) {
    const double ud = m->R * id - m->omega * m->Lq * iq;
    const double uq = m->R * iq + m->omega * (m->Ld * id + m->psi);
    const double middle = m->theta + 0.5 * ts * m->omega;
    return (lode_ab_t){(float)(ud * cos(middle) - uq * sin(middle)),
                       (float)(ud * sin(middle) + uq * cos(middle))};
}

static inline lode_ab_t ipmsm_current(const ipmsm_t *m) {
    return (lode_ab_t){(float)(m->id * cos(m->theta) - m->iq * sin(m->theta)),
                       (float)(m->id * sin(m->theta) + m->iq * cos(m->theta))};
}

/// Eq. (17).
static inline double ipmsm_torque(const ipmsm_t *m) {
    return 4.5 * (m->psi + (m->Ld - m->Lq) * m->id) * m->iq;
}

#endif
