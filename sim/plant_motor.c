#include "plant_motor.h"

#include <math.h>

/// The few functions that every step runs three times: a call costs as much as their arithmetic.
#if defined(__GNUC__)
#define HOT static inline __attribute__((always_inline))
#else
#define HOT static inline
#endif

#define PI 3.14159265358979323846
#define SQRT3_2 0.86602540378443864676

const double plant_axis_cos[PLANT_PHASES] = {1.0, -0.5, -0.5};
const double plant_axis_sin[PLANT_PHASES] = {0.0, SQRT3_2, -SQRT3_2};

/// One evaluation point of the integration. On the q axis the flux is what is integrated: the
/// voltage acts on it alike whether or not the iron saturates.
typedef struct {
    double id, iq, psi_q, omega, cos, sin;
} point_t;

typedef struct {
    double did, dpsi_q, torque, u_float;
} slope_t;

/// What the shaft feels besides the motor's torque and viscous friction; constant in one step.
typedef struct {
    double load_Nm;
    double inv_J; ///< 0 where the speed is held, by a dynamometer or by the load at standstill
} shaft_t;

void plant_motor_init(plant_motor_t *self, const plant_config_t *config) {
    const double h5 = config->psi_Wb * config->emf5_ratio;
    const double h7 = config->psi_Wb * config->emf7_ratio;
    const double re5 = h5 * cos(config->emf5_phase_rad);
    const double im5 = h5 * sin(config->emf5_phase_rad);
    const double re7 = h7 * cos(config->emf7_phase_rad);
    const double im7 = h7 * sin(config->emf7_phase_rad);
    const bool saturates = config->i_sat_A > 0.0;
    *self = (plant_motor_t){
        .x = {.omega_m_rad_s = config->omega_m_rad_s, .theta_e_rad = config->theta_e_rad},
        .speed_is_prescribed = config->speed_is_prescribed,
        .load_is_passive = config->load_is_passive,
        .load_Nm = config->load_Nm,
        .np = (double)config->pole_pairs,
        .Rs_Ohm = config->Rs_Ohm,
        .Ld_H = config->Ld_H,
        .Lq_H = config->Lq_H,
        .Lq_sat_H = saturates ? config->Lq_sat_H : config->Lq_H,
        .psi_Wb = config->psi_Wb,
        .i_sat_A = config->i_sat_A,
        .inv_Ld = 1.0 / config->Ld_H,
        .inv_Lq = 1.0 / config->Lq_H,
        .inv_i_sat = saturates ? 1.0 / config->i_sat_A : 0.0,
        .inv_J = 1.0 / config->J_kgm2,
        .J_kgm2 = config->J_kgm2,
        .B_Nms = config->B_Nms,
        .saturates = saturates,
        .has_harmonics = h5 > 0.0 || h7 > 0.0,
        .h_d_sin = -(re5 + re7),
        .h_d_cos = -(im5 + im7),
        .h_q_sin = im5 - im7,
        .h_q_cos = re7 - re5,
        .harmonic5_re = re5,
        .harmonic5_im = im5,
        .harmonic7_re = re7,
        .harmonic7_im = im7,
    };
    plant_motor_refresh_angle(self);
}

void plant_motor_refresh_angle(plant_motor_t *self) {
    plant_motor_state_t *x = &self->x;
    if (!(x->theta_e_rad > -PI && x->theta_e_rad <= PI)) {
        x->theta_e_rad -= 2.0 * PI * ceil(x->theta_e_rad / (2.0 * PI) - 0.5);
    }
    x->cos_theta = cos(x->theta_e_rad);
    x->sin_theta = sin(x->theta_e_rad);
}

static inline double flux_q(const plant_motor_t *m, double iq) {
    if (!m->saturates) {
        return m->Lq_H * iq;
    }
    return iq * (m->Lq_sat_H + (m->Lq_H - m->Lq_sat_H) / (1.0 + fabs(iq) * m->inv_i_sat));
}

/// The inverse of flux_q: the positive root of
///     (Lq_sat/i_sat) i^2 + (Lq - psi/i_sat) i - psi = 0
HOT double current_q(const plant_motor_t *m, double psi_q) {
    if (!m->saturates) {
        return m->inv_Lq * psi_q;
    }
    const double size = fabs(psi_q);
    const double b = m->Lq_H - size * m->inv_i_sat;
    return 2.0 * psi_q / (b + sqrt(b * b + 4.0 * m->Lq_sat_H * m->inv_i_sat * size));
}

/// diq/dpsi_q.
HOT double inverse_Lq(const plant_motor_t *m, double iq) {
    if (!m->saturates) {
        return m->inv_Lq;
    }
    const double fade = 1.0 / (1.0 + fabs(iq) * m->inv_i_sat);
    return 1.0 / (m->Lq_sat_H + (m->Lq_H - m->Lq_sat_H) * fade * fade);
}

/// h_d, h_q of the file header, Wb.
static inline void harmonics(const plant_motor_t *m, double c, double s, double *h_d, double *h_q) {
    const double c2 = c * c - s * s, s2 = 2.0 * c * s;
    const double c6 = c2 * (4.0 * c2 * c2 - 3.0), s6 = s2 * (3.0 - 4.0 * s2 * s2);
    *h_d = m->h_d_sin * s6 + m->h_d_cos * c6;
    *h_q = m->h_q_sin * s6 + m->h_q_cos * c6;
}

static point_t point_of(const plant_motor_t *m, const plant_motor_state_t *x) {
    return (point_t){
        .id = x->id_A,
        .iq = x->iq_A,
        .psi_q = flux_q(m, x->iq_A),
        .omega = x->omega_m_rad_s,
        .cos = x->cos_theta,
        .sin = x->sin_theta,
    };
}

/// Holds the current of the floating phase: its terminal takes the voltage that stops di/dt.
static void hold_floating(const plant_motor_t *m, const plant_drive_t *drive, const point_t *at,
                          slope_t *slope) {
    const double w = m->np * at->omega, inv_Lq = inverse_Lq(m, at->iq);
    const double ac = plant_axis_cos[drive->floating], as = plant_axis_sin[drive->floating];
    const double ad = ac * at->cos + as * at->sin;
    const double aq = as * at->cos - ac * at->sin;
    // The phase's current changes by the dq slope and by the rotation of the frame.
    const double rate = ad * (slope->did - w * at->iq) + aq * (slope->dpsi_q * inv_Lq + w * at->id);
    const double push = -rate / (ad * ad * m->inv_Ld + aq * aq * inv_Lq);
    slope->did += push * ad * m->inv_Ld;
    slope->dpsi_q += push * aq;
    slope->u_float = 1.5 * push;
}

/// (M1)..(M3).
HOT slope_t slope_at(const plant_motor_t *m, const plant_drive_t *drive, const point_t *at) {
    const double ud = drive->u_alpha_V * at->cos + drive->u_beta_V * at->sin;
    const double uq = drive->u_beta_V * at->cos - drive->u_alpha_V * at->sin;
    const double w = m->np * at->omega;
    double flux_1 = m->psi_Wb + m->Ld_H * at->id, flux_2 = at->psi_q;
    if (m->has_harmonics) {
        double h_d, h_q;
        harmonics(m, at->cos, at->sin, &h_d, &h_q);
        flux_1 += h_q;
        flux_2 -= h_d;
    }
    slope_t slope = {
        .did = (ud - drive->R_Ohm * at->id + w * flux_2) * m->inv_Ld,
        .dpsi_q = uq - drive->R_Ohm * at->iq - w * flux_1,
        .torque = 1.5 * m->np * (flux_1 * at->iq - flux_2 * at->id),
        .u_float = 0.0,
    };
    if (drive->floating >= 0) {
        hold_floating(m, drive, at, &slope);
    }
    return slope;
}

/// A passive load opposes motion; at standstill it holds as long as it is the stronger.
static shaft_t shaft_at(const plant_motor_t *m, double torque) {
    if (m->speed_is_prescribed) {
        return (shaft_t){.load_Nm = 0.0, .inv_J = 0.0};
    }
    if (!m->load_is_passive) {
        return (shaft_t){.load_Nm = m->load_Nm, .inv_J = m->inv_J};
    }
    const double strength = fabs(m->load_Nm);
    const bool at_rest = !(m->x.omega_m_rad_s > 0.0) && !(m->x.omega_m_rad_s < 0.0);
    if (at_rest && fabs(torque) <= strength) {
        return (shaft_t){.load_Nm = 0.0, .inv_J = 0.0};
    }
    const double direction = at_rest ? torque : m->x.omega_m_rad_s;
    return (shaft_t){.load_Nm = copysign(strength, direction), .inv_J = m->inv_J};
}

HOT double acceleration(const plant_motor_t *m, const shaft_t *shaft, double torque, double omega) {
    return (torque - shaft->load_Nm - m->B_Nms * omega) * shaft->inv_J;
}

/// Cosine and sine of an angle up to 0.1 rad; the series ends below 1e-15.
HOT void small_angle(double angle, double *c, double *s) {
    const double x2 = angle * angle;
    *c = 1.0 - x2 * (0.5 - x2 * (1.0 / 24 - x2 * (1.0 / 720)));
    *s = angle * (1.0 - x2 * (1.0 / 6 - x2 * (1.0 / 120 - x2 * (1.0 / 5040))));
}

static inline void rotate(double angle, double *c, double *s) {
    double ca, sa;
    small_angle(angle, &ca, &sa);
    const double turned = *c * ca - *s * sa;
    *s = *s * ca + *c * sa;
    *c = turned;
}

/// A passive load stops the shaft, it never turns it back. The rest of the speed becomes its heat.
static void stop_at_reversal(plant_motor_t *m, double omega_before, plant_stretch_t *sum) {
    if (m->load_is_passive && !m->speed_is_prescribed && omega_before * m->x.omega_m_rad_s < 0.0) {
        sum->load_J += plant_motor_kinetic_energy(m);
        m->x.omega_m_rad_s = 0.0;
    }
}

/// The quadratures that belong to the states: the same weights at the same three points.
HOT void integrate(const plant_motor_t *m, const shaft_t *shaft, const point_t *p, const slope_t *k,
                   double h, plant_stretch_t *sum) {
    const double g = h / 6.0, g1 = 4.0 * g;
    sum->i_alpha_As = g * (p[0].id * p[0].cos - p[0].iq * p[0].sin) +
                      g1 * (p[1].id * p[1].cos - p[1].iq * p[1].sin) +
                      g * (p[2].id * p[2].cos - p[2].iq * p[2].sin);
    sum->i_beta_As = g * (p[0].id * p[0].sin + p[0].iq * p[0].cos) +
                     g1 * (p[1].id * p[1].sin + p[1].iq * p[1].cos) +
                     g * (p[2].id * p[2].sin + p[2].iq * p[2].cos);
    sum->i_squared_A2s = g * (p[0].id * p[0].id + p[0].iq * p[0].iq) +
                         g1 * (p[1].id * p[1].id + p[1].iq * p[1].iq) +
                         g * (p[2].id * p[2].id + p[2].iq * p[2].iq);
    sum->shaft_work_J =
        g * k[0].torque * p[0].omega + g1 * k[1].torque * p[1].omega + g * k[2].torque * p[2].omega;
    sum->friction_J = m->B_Nms * (g * p[0].omega * p[0].omega + g1 * p[1].omega * p[1].omega +
                                  g * p[2].omega * p[2].omega);
    sum->load_J = m->speed_is_prescribed
                      ? sum->shaft_work_J - sum->friction_J
                      : shaft->load_Nm * (g * p[0].omega + g1 * p[1].omega + g * p[2].omega);
    sum->u_float_Vs = g * k[0].u_float + g1 * k[1].u_float + g * k[2].u_float;
    sum->u_open_alpha_Vs = 0.0;
    sum->u_open_beta_Vs = 0.0;
    sum->did_start_A_s = k[0].did;
    sum->dpsi_q_start_V = k[0].dpsi_q;
    sum->u_float_start_V = k[0].u_float;
    sum->u_float_end_V = k[2].u_float;
}

/// Flux linkage of the magnet with its harmonics; its change is the integral of the open EMF.
static void magnet_flux(const plant_motor_t *m, const plant_motor_state_t *x, double *alpha,
                        double *beta) {
    *alpha = m->psi_Wb * x->cos_theta;
    *beta = m->psi_Wb * x->sin_theta;
    if (m->has_harmonics) {
        const double c5 = cos(5.0 * x->theta_e_rad), s5 = sin(5.0 * x->theta_e_rad);
        const double c7 = cos(7.0 * x->theta_e_rad), s7 = sin(7.0 * x->theta_e_rad);
        *alpha += (m->harmonic5_re * c5 - m->harmonic5_im * s5) / 5.0 +
                  (m->harmonic7_re * c7 - m->harmonic7_im * s7) / 7.0;
        *beta += -(m->harmonic5_re * s5 + m->harmonic5_im * c5) / 5.0 +
                 (m->harmonic7_re * s7 + m->harmonic7_im * c7) / 7.0;
    }
}

/// All phases float: no current, no torque, only (M4) is left.
static void coast(plant_motor_t *m, double h, plant_stretch_t *sum) {
    const double omega_0 = m->x.omega_m_rad_s;
    const shaft_t shaft = shaft_at(m, 0.0);
    double alpha_0, beta_0, alpha_1, beta_1;
    magnet_flux(m, &m->x, &alpha_0, &beta_0);
    // The linear equation needs two corrections to be as good as the rest.
    const double a_0 = acceleration(m, &shaft, 0.0, omega_0);
    const double pole = m->B_Nms * shaft.inv_J * h;
    const double gain = 1.0 - pole * (0.5 - pole / 6.0);
    const double turn = h * (omega_0 + a_0 * h * (0.5 - pole / 6.0));
    m->x.omega_m_rad_s += a_0 * h * gain;
    m->x.theta_e_rad += m->np * turn;
    rotate(m->np * turn, &m->x.cos_theta, &m->x.sin_theta);
    magnet_flux(m, &m->x, &alpha_1, &beta_1);
    const double omega_1 = m->x.omega_m_rad_s;
    *sum = (plant_stretch_t){
        .friction_J =
            m->B_Nms * h * (omega_0 * omega_0 + omega_0 * omega_1 + omega_1 * omega_1) / 3.0,
        .load_J = shaft.load_Nm * turn,
        .u_open_alpha_Vs = alpha_1 - alpha_0,
        .u_open_beta_Vs = beta_1 - beta_0,
    };
    if (m->speed_is_prescribed) {
        sum->load_J = -sum->friction_J;
    }
    stop_at_reversal(m, omega_0, sum);
}

void plant_motor_step(plant_motor_t *self, const plant_drive_t *drive, double h_s,
                      plant_stretch_t *sum) {
    if (drive->floating == PLANT_ALL_FLOAT) {
        coast(self, h_s, sum);
        return;
    }
    // Kutta's third-order rule: slopes at the start, the middle and the end, weights 1, 4, 1.
    plant_motor_state_t *x = &self->x;
    const double h = h_s, half = 0.5 * h_s;
    point_t p[3];
    slope_t k[3];
    p[0] = point_of(self, x);
    k[0] = slope_at(self, drive, &p[0]);
    const shaft_t shaft = shaft_at(self, k[0].torque);
    const double a_0 = acceleration(self, &shaft, k[0].torque, p[0].omega);

    double c, s; // of half the angle turned, taken twice; then what acceleration adds to that
    small_angle(self->np * half * (p[0].omega + 0.5 * half * a_0), &c, &s);
    const double more = self->np * half * half * a_0;
    p[1].cos = p[0].cos * c - p[0].sin * s;
    p[1].sin = p[0].sin * c + p[0].cos * s;
    c -= s * more;
    s += c * more;
    p[2].cos = p[1].cos * c - p[1].sin * s;
    p[2].sin = p[1].sin * c + p[1].cos * s;

    p[1].id = p[0].id + half * k[0].did;
    p[1].psi_q = p[0].psi_q + half * k[0].dpsi_q;
    p[1].iq = current_q(self, p[1].psi_q);
    p[1].omega = p[0].omega + half * a_0;
    k[1] = slope_at(self, drive, &p[1]);
    const double a_1 = acceleration(self, &shaft, k[1].torque, p[1].omega);

    p[2].id = p[0].id + h * (2.0 * k[1].did - k[0].did);
    p[2].psi_q = p[0].psi_q + h * (2.0 * k[1].dpsi_q - k[0].dpsi_q);
    p[2].iq = current_q(self, p[2].psi_q);
    p[2].omega = p[0].omega + h * (2.0 * a_1 - a_0);
    k[2] = slope_at(self, drive, &p[2]);
    const double a_2 = acceleration(self, &shaft, k[2].torque, p[2].omega);

    integrate(self, &shaft, p, k, h, sum);
    const double jerk_turn = self->np * h * h / 3.0 * (a_1 - a_0);
    x->theta_e_rad += self->np * h * (p[0].omega + half * a_0) + jerk_turn;
    x->cos_theta = p[2].cos - p[2].sin * jerk_turn;
    x->sin_theta = p[2].sin + p[2].cos * jerk_turn;
    x->id_A += h / 6.0 * (k[0].did + 4.0 * k[1].did + k[2].did);
    x->iq_A =
        current_q(self, p[0].psi_q + h / 6.0 * (k[0].dpsi_q + 4.0 * k[1].dpsi_q + k[2].dpsi_q));
    x->omega_m_rad_s += h / 6.0 * (a_0 + 4.0 * a_1 + a_2);
    stop_at_reversal(self, p[0].omega, sum);
}

double plant_motor_longest_step(const plant_motor_t *self, double R_Ohm) {
    const double w = self->np * self->x.omega_m_rad_s;
    const double L = fmin(self->Ld_H, self->Lq_sat_H), decay = R_Ohm / L;
    double fastest2 = fmax(w * w, decay * decay);
    if (!self->speed_is_prescribed) {
        // The rotor swings in the field of the currents like a mass on a spring; light ones fast.
        const double psi_d = self->psi_Wb + self->Ld_H * self->x.id_A;
        const double psi_q = self->Lq_H * self->x.iq_A;
        const double stiffness = 1.5 * self->np * self->np * (psi_d * psi_d + psi_q * psi_q) / L;
        fastest2 = fmax(fastest2, stiffness * self->inv_J);
    }
    // 0.05 rad of the fastest motion: 5e-6 of relative error per radian.
    return 0.05 / sqrt(fmax(fastest2, 2500.0));
}

double plant_motor_torque(const plant_motor_t *self) {
    const plant_drive_t none = {.floating = PLANT_NONE_FLOATS};
    const point_t at = point_of(self, &self->x);
    return slope_at(self, &none, &at).torque;
}

double plant_motor_slopes(const plant_motor_t *self, const plant_drive_t *drive, double *did_A_s,
                          double *dpsi_q_V) {
    const point_t at = point_of(self, &self->x);
    const slope_t slope = slope_at(self, drive, &at);
    *did_A_s = slope.did;
    *dpsi_q_V = slope.dpsi_q;
    return slope.u_float;
}

double plant_motor_phase_slope(const plant_motor_t *self, const plant_motor_state_t *state,
                               double did_A_s, double dpsi_q_V, int phase) {
    const double w = self->np * state->omega_m_rad_s;
    const double ac = plant_axis_cos[phase], as = plant_axis_sin[phase];
    const double ad = ac * state->cos_theta + as * state->sin_theta;
    const double aq = as * state->cos_theta - ac * state->sin_theta;
    const double diq_A_s = dpsi_q_V * inverse_Lq(self, state->iq_A);
    return ad * (did_A_s - w * state->iq_A) + aq * (diq_A_s + w * state->id_A);
}

void plant_motor_open_emf(const plant_motor_t *self, const plant_motor_state_t *state,
                          double emf_V[PLANT_PHASES]) {
    const double w = self->np * state->omega_m_rad_s;
    double h_d = 0.0, h_q = 0.0;
    if (self->has_harmonics) {
        harmonics(self, state->cos_theta, state->sin_theta, &h_d, &h_q);
    }
    const double e_d = w * h_d, e_q = w * (self->psi_Wb + h_q);
    const double e_alpha = e_d * state->cos_theta - e_q * state->sin_theta;
    const double e_beta = e_d * state->sin_theta + e_q * state->cos_theta;
    for (int n = 0; n < PLANT_PHASES; n++) {
        emf_V[n] = plant_axis_cos[n] * e_alpha + plant_axis_sin[n] * e_beta;
    }
}

void plant_motor_active_emf(const plant_motor_t *self, double *e_alpha_V, double *e_beta_V) {
    const plant_motor_state_t *x = &self->x;
    const double w = self->np * x->omega_m_rad_s;
    const double fade = 1.0 / (1.0 + fabs(x->iq_A) * self->inv_i_sat);
    const double Lq = self->Lq_sat_H + (self->Lq_H - self->Lq_sat_H) * fade;
    double h_d = 0.0, h_q = 0.0;
    if (self->has_harmonics) {
        harmonics(self, x->cos_theta, x->sin_theta, &h_d, &h_q);
    }
    const double e_d = w * h_d;
    const double e_q = w * (self->psi_Wb + (self->Ld_H - Lq) * x->id_A + h_q);
    *e_alpha_V = e_d * x->cos_theta - e_q * x->sin_theta;
    *e_beta_V = e_d * x->sin_theta + e_q * x->cos_theta;
}

void plant_motor_phase_currents(const plant_motor_state_t *state, double i_A[PLANT_PHASES]) {
    const double alpha = state->id_A * state->cos_theta - state->iq_A * state->sin_theta;
    const double beta = state->id_A * state->sin_theta + state->iq_A * state->cos_theta;
    i_A[0] = alpha;
    i_A[1] = SQRT3_2 * beta - 0.5 * alpha;
    i_A[2] = -SQRT3_2 * beta - 0.5 * alpha;
}

void plant_motor_clear_phase(plant_motor_state_t *state, int phase) {
    const double ac = plant_axis_cos[phase], as = plant_axis_sin[phase];
    const double ad = ac * state->cos_theta + as * state->sin_theta;
    const double aq = as * state->cos_theta - ac * state->sin_theta;
    const double rest = ad * state->id_A + aq * state->iq_A;
    state->id_A -= rest * ad;
    state->iq_A -= rest * aq;
}

double plant_motor_field_energy(const plant_motor_t *self) {
    const double id = self->x.id_A, iq = self->x.iq_A;
    double energy = 0.5 * self->Ld_H * id * id + 0.5 * self->Lq_sat_H * iq * iq;
    if (self->saturates) {
        // The integral of iq dpsi_q of the fading part.
        const double r = fabs(iq) * self->inv_i_sat;
        energy += (self->Lq_H - self->Lq_sat_H) * self->i_sat_A * self->i_sat_A *
                  (log1p(r) - r / (1.0 + r));
    }
    return 1.5 * energy;
}

double plant_motor_kinetic_energy(const plant_motor_t *self) {
    return 0.5 * self->J_kgm2 * self->x.omega_m_rad_s * self->x.omega_m_rad_s;
}
