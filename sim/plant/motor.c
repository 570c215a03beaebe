#include "plant/motor.h"

#include "plant/flux.h"
#include "plant/load.h"
#include "plant/turn.h"

#include <math.h>

/// The few functions that every step runs three times: a call costs as much as their arithmetic.
#if defined(__GNUC__)
#define HOT static inline __attribute__((always_inline))
#else
#define HOT static inline
#endif

#define PI 3.14159265358979323846

/// Below this current the chord of a flux is its slope, A.
static const double chord_floor_A = 1e-9;

/// One evaluation point of the integration.
typedef struct {
    double id, iq, psi_q, omega, cos, sin;
    double psi_d;  // without the magnet's; iron that saturates only
    double ix, iy; // two sets only
} point_t;

/// Conditions that are constant in each copy of the code that every step runs three times.
typedef struct {
    bool dual;  ///< two sets
    bool plain; ///< plant_motor_t.is_plain, and nothing floats
    bool
        iron; ///< plant_motor_t.saturates: both fluxes are integrated, the currents follow from them
} kind_t;

typedef struct {
    double did, dpsi_q, torque;
    double dpsi_d;  // instead of did if the iron saturates
    double u_float; // one set only
    double dix, diy;
    plant_vector_t push[PLANT_SETS]; // voltage of floating phases, two sets only
} slope_t;

void plant_motor_init(plant_motor_t *self, const plant_config_t *config) {
    const bool saturates = plant_iron_saturates(config);
    const bool dual = config->sets == PLANT_SETS;
    *self = (plant_motor_t){
        .x = {.omega_m_rad_s = config->omega_m_rad_s, .theta_e_rad = config->theta_e_rad},
        .speed_is_prescribed = config->speed_is_prescribed,
        .load_is_passive = config->load_is_passive,
        .load_Nm = config->load_Nm,
        .sets = dual ? PLANT_SETS : 1,
        .power = dual ? 3.0 : 1.5,
        .np = (double)config->pole_pairs,
        .Rs_Ohm = config->Rs_Ohm,
        .Ld_H = config->Ld_H,
        .Lq_H = config->Lq_H,
        .Lxy_H = dual ? config->Lxy_H : 0.0,
        .psi_Wb = config->psi_Wb,
        .inv_Ld = 1.0 / config->Ld_H,
        .inv_Lq = 1.0 / config->Lq_H,
        .inv_Lxy = dual ? 1.0 / config->Lxy_H : 0.0,
        .inv_J = 1.0 / config->J_kgm2,
        .J_kgm2 = config->J_kgm2,
        .B_Nms = config->B_Nms,
        .saturates = saturates,
        .keeps_accounts = config->keeps_accounts,
    };
    plant_iron_init(&self->iron, config);
    plant_flux_init(self, config);
    plant_load_init(self, config);
    self->is_plain = !dual && !saturates && !self->has_dq_harmonics && !config->keeps_accounts;
    plant_motor_refresh_angle(self);
}

void plant_motor_refresh_angle(plant_motor_t *self) {
    plant_motor_state_t *x = &self->x;
    if (!(x->theta_e_rad > -PI && x->theta_e_rad <= PI)) {
        const double turns = ceil(x->theta_e_rad / (2.0 * PI) - 0.5);
        x->theta_e_rad -= 2.0 * PI * turns;
        self->turns = (int)fmod((double)self->turns + turns, self->np);
    }
    plant_turn(x->theta_e_rad * (0.5 / PI), &x->cos_theta, &x->sin_theta);
}

HOT point_t point_of(const plant_motor_t *m, const plant_motor_state_t *x, kind_t kind) {
    point_t at = {
        .id = x->id_A,
        .iq = x->iq_A,
        .psi_q = m->Lq_H * x->iq_A,
        .omega = x->omega_m_rad_s,
        .cos = x->cos_theta,
        .sin = x->sin_theta,
        .ix = x->ix_A,
        .iy = x->iy_A,
    };
    if (kind.iron) {
        const plant_iron_point_t iron = plant_iron_at(&m->iron, at.id, at.iq);
        at.psi_d = iron.psi_d_Wb;
        at.psi_q = iron.psi_q_Wb;
    }
    return at;
}

/// Slopes of the currents per volt at a point.
HOT plant_iron_answer_t answer_at(const plant_motor_t *m, const point_t *at, kind_t kind) {
    if (!kind.iron) {
        return (plant_iron_answer_t){m->inv_Ld, 0.0, m->inv_Lq};
    }
    const plant_iron_point_t iron = plant_iron_at(&m->iron, at->id, at->iq);
    return plant_iron_answer(&iron);
}

/// Slopes of the currents, A/s.
HOT plant_vector_dq_t current_slopes(const plant_motor_t *m, const point_t *at, const slope_t *k,
                                     kind_t kind) {
    if (!kind.iron) {
        return (plant_vector_dq_t){k->did, k->dpsi_q * m->inv_Lq};
    }
    const plant_iron_answer_t y = answer_at(m, at, kind);
    return (plant_vector_dq_t){y.dd * k->dpsi_d + y.dq * k->dpsi_q,
                               y.dq * k->dpsi_d + y.qq * k->dpsi_q};
}

/// Adds a voltage in dq to the slopes.
HOT void add_voltage(const plant_motor_t *m, double d_V, double q_V, slope_t *slope, kind_t kind) {
    if (kind.iron) {
        slope->dpsi_d += d_V;
    } else {
        slope->did += d_V * m->inv_Ld;
    }
    slope->dpsi_q += q_V;
}

/// Holds the current of the floating phase: its terminal takes the voltage that stops di/dt.
static void hold_floating(const plant_motor_t *m, const plant_drive_t *drive, const point_t *at,
                          slope_t *slope, kind_t kind) {
    const double w = m->np * at->omega;
    const plant_iron_answer_t y = answer_at(m, at, kind);
    const plant_vector_dq_t di = current_slopes(m, at, slope, kind);
    const int leg = drive->floating[0];
    const double ac = plant_axis_cos[leg], as = plant_axis_sin[leg];
    const double ad = ac * at->cos + as * at->sin;
    const double aq = as * at->cos - ac * at->sin;
    // The phase's current changes by the dq slope and by the rotation of the frame.
    const double rate = ad * (di.d - w * at->iq) + aq * (di.q + w * at->id);
    const double push = -rate / (ad * ad * y.dd + 2.0 * ad * aq * y.dq + aq * aq * y.qq);
    add_voltage(m, push * ad, push * aq, slope, kind);
    slope->u_float = 1.5 * push;
}

/// The same for two sets, which saturation couples.
static void hold_sets(const plant_motor_t *m, const plant_drive_t *drive, const point_t *at,
                      slope_t *slope, kind_t kind) {
    const double w = m->np * at->omega;
    const plant_iron_answer_t y = answer_at(m, at, kind);
    const plant_vector_dq_t di = current_slopes(m, at, slope, kind);
    const double c = at->cos, s = at->sin;
    const plant_compliance_t compliance = {
        .alpha_alpha = c * c * y.dd + s * s * y.qq - 2.0 * c * s * y.dq,
        .alpha_beta = c * s * (y.dd - y.qq) + (c * c - s * s) * y.dq,
        .beta_beta = s * s * y.dd + c * c * y.qq + 2.0 * c * s * y.dq,
        .xy = m->inv_Lxy,
    };
    const double d = di.d - w * at->iq, q = di.q + w * at->id;
    const plant_planes_t rates = {{d * c - q * s, d * s + q * c}, {slope->dix, slope->diy}};
    const plant_vector_t rate[PLANT_SETS] = {plant_sets_vector(&rates, 0),
                                             plant_sets_vector(&rates, 1)};
    plant_planes_t u = {{0.0, 0.0}, {0.0, 0.0}};
    plant_sets_hold(&compliance, drive->floating, rate, slope->push);
    plant_sets_add(&u, 0, slope->push[0]);
    plant_sets_add(&u, 1, slope->push[1]);
    add_voltage(m, u.ab.alpha * c + u.ab.beta * s, u.ab.beta * c - u.ab.alpha * s, slope, kind);
    slope->dix += u.xy.alpha * m->inv_Lxy;
    slope->diy += u.xy.beta * m->inv_Lxy;
}

/// (M6), then the floating phases.
static void add_second_set(const plant_motor_t *m, const plant_drive_t *drive, const point_t *at,
                           slope_t *slope, kind_t kind) {
    const double w = m->np * at->omega;
    plant_vector_t h = {0.0, 0.0};
    if (m->has_xy_harmonics) {
        h = plant_flux_ripple_xy(m, at->cos, at->sin);
        slope->torque += m->power * m->np * (h.alpha * at->ix + h.beta * at->iy);
    }
    slope->dix = (drive->u_x_V - drive->R_Ohm * at->ix - w * h.alpha) * m->inv_Lxy;
    slope->diy = (drive->u_y_V - drive->R_Ohm * at->iy - w * h.beta) * m->inv_Lxy;
    if (drive->floating[0] != PLANT_NONE_FLOATS || drive->floating[1] != PLANT_NONE_FLOATS) {
        hold_sets(m, drive, at, slope, kind);
    } else {
        slope->push[0] = slope->push[1] = (plant_vector_t){0.0, 0.0};
    }
}

/// (M1)..(M3), (M6).
HOT slope_t slope_at(const plant_motor_t *m, const plant_drive_t *drive, const point_t *at,
                     kind_t kind) {
    const double ud = drive->u_alpha_V * at->cos + drive->u_beta_V * at->sin;
    const double uq = drive->u_beta_V * at->cos - drive->u_alpha_V * at->sin;
    const double w = m->np * at->omega;
    double flux_1 = m->psi_Wb + (kind.iron ? at->psi_d : m->Ld_H * at->id), flux_2 = at->psi_q;
    if (!kind.plain && m->has_dq_harmonics) {
        double h_d, h_q;
        plant_flux_ripple(m, at->cos, at->sin, &h_d, &h_q);
        flux_1 += h_q;
        flux_2 -= h_d;
    }
    const double dpsi_d = ud - drive->R_Ohm * at->id + w * flux_2;
    slope_t slope = {
        .did = kind.iron ? 0.0 : dpsi_d * m->inv_Ld,
        .dpsi_d = kind.iron ? dpsi_d : 0.0,
        .dpsi_q = uq - drive->R_Ohm * at->iq - w * flux_1,
        .torque = m->power * m->np * (flux_1 * at->iq - flux_2 * at->id),
        .u_float = 0.0,
    };
    if (kind.dual) {
        add_second_set(m, drive, at, &slope, kind);
    } else if (!kind.plain && drive->floating[0] >= 0) {
        hold_floating(m, drive, at, &slope, kind);
    }
    return slope;
}

/// A passive load opposes motion; at standstill it holds as long as it is larger than the torque.
static plant_shaft_t shaft_at(const plant_motor_t *m, double torque, double h_s) {
    if (m->has_load) {
        return plant_load_shaft(m, torque, h_s);
    }
    if (m->speed_is_prescribed) {
        return (plant_shaft_t){.load_Nm = 0.0, .inv_J = 0.0};
    }
    if (!m->load_is_passive) {
        return (plant_shaft_t){.load_Nm = m->load_Nm, .inv_J = m->inv_J};
    }
    const double strength = fabs(m->load_Nm);
    const bool at_rest = !(m->x.omega_m_rad_s > 0.0) && !(m->x.omega_m_rad_s < 0.0);
    if (at_rest && fabs(torque) <= strength) {
        return (plant_shaft_t){.load_Nm = 0.0, .inv_J = 0.0};
    }
    const double direction = at_rest ? torque : m->x.omega_m_rad_s;
    return (plant_shaft_t){.load_Nm = copysign(strength, direction), .inv_J = m->inv_J};
}

HOT double acceleration(const plant_motor_t *m, const plant_shaft_t *shaft, double torque,
                        double omega) {
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

/// A passive load stops the shaft but never reverses it. The remaining kinetic energy becomes heat in the load.
static void stop_at_reversal(plant_motor_t *m, double omega_before, plant_stretch_t *sum) {
    if (omega_before * m->x.omega_m_rad_s < 0.0 && plant_load_stops(m)) {
        sum->load_J += plant_motor_kinetic_energy(m);
        m->x.omega_m_rad_s = 0.0;
    }
}

/// Voltage of the single floating phase that adds `push` to its set's vector.
static double terminal_of(const plant_vector_t *push, int leg) {
    return 1.5 * (plant_axis_cos[leg] * push->alpha + plant_axis_sin[leg] * push->beta);
}

/// Values for the search for a change of conduction.
HOT void note_ends(const plant_motor_t *m, const point_t *p, const slope_t *k, plant_stretch_t *sum,
                   kind_t kind) {
    const plant_vector_dq_t di = current_slopes(m, &p[0], &k[0], kind);
    sum->set[0].u_start_V = k[0].u_float;
    sum->set[0].u_end_V = k[2].u_float;
    sum->did_start_A_s = di.d;
    sum->diq_start_A_s = di.q;
}

/// Additional states of two sets.
static void note_ends_of_sets(const plant_drive_t *drive, const slope_t *k, plant_stretch_t *sum) {
    sum->dix_start_A_s = k[0].dix;
    sum->diy_start_A_s = k[0].diy;
    for (int set = 0; set < PLANT_SETS; set++) {
        const plant_vector_t *start = &k[0].push[set], *end = &k[2].push[set];
        const int leg = drive->floating[set];
        plant_float_t *at = &sum->set[set];
        at->all_start_V = *start;
        at->all_end_V = *end;
        if (leg != PLANT_NONE_FLOATS && leg != PLANT_ALL_FLOAT) {
            at->u_start_V = terminal_of(start, leg);
            at->u_end_V = terminal_of(end, leg);
        }
    }
}

/// The quadratures of the states: the same weights at the same three points.
static void integrate(const plant_motor_t *m, const plant_shaft_t *shaft, const point_t *p,
                      const slope_t *k, double h, plant_stretch_t *sum) {
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
    sum->set[0].u_Vs = g * k[0].u_float + g1 * k[1].u_float + g * k[2].u_float;
}

/// Additional states of two sets.
static void integrate_second_set(const plant_drive_t *drive, const point_t *p, const slope_t *k,
                                 double h, plant_stretch_t *sum) {
    const double g = h / 6.0, g1 = 4.0 * g;
    sum->i_x_As = g * p[0].ix + g1 * p[1].ix + g * p[2].ix;
    sum->i_y_As = g * p[0].iy + g1 * p[1].iy + g * p[2].iy;
    sum->i_squared_A2s += g * (p[0].ix * p[0].ix + p[0].iy * p[0].iy) +
                          g1 * (p[1].ix * p[1].ix + p[1].iy * p[1].iy) +
                          g * (p[2].ix * p[2].ix + p[2].iy * p[2].iy);
    for (int set = 0; set < PLANT_SETS; set++) {
        const plant_vector_t *a = &k[0].push[set], *b = &k[1].push[set], *c = &k[2].push[set];
        plant_float_t *at = &sum->set[set];
        at->all_Vs = (plant_vector_t){g * a->alpha + g1 * b->alpha + g * c->alpha,
                                      g * a->beta + g1 * b->beta + g * c->beta};
        if (drive->floating[set] != PLANT_NONE_FLOATS && drive->floating[set] != PLANT_ALL_FLOAT) {
            at->u_Vs = terminal_of(&at->all_Vs, drive->floating[set]);
        }
    }
}

/// All phases float: no current and no torque, only (M4) remains.
static void coast(plant_motor_t *m, double h, plant_stretch_t *sum) {
    const double omega_0 = m->x.omega_m_rad_s;
    const plant_shaft_t shaft = shaft_at(m, 0.0, h);
    const plant_planes_t flux_0 = plant_flux_magnet(m, &m->x),
                         emf_0 = plant_flux_open_emf(m, &m->x);
    // The linear equation needs two corrections to be as exact as the rest.
    const double a_0 = acceleration(m, &shaft, 0.0, omega_0);
    const double pole = m->B_Nms * shaft.inv_J * h;
    const double gain = 1.0 - pole * (0.5 - pole / 6.0);
    const double turn = h * (omega_0 + a_0 * h * (0.5 - pole / 6.0));
    m->x.omega_m_rad_s += a_0 * h * gain;
    m->x.theta_e_rad += m->np * turn;
    rotate(m->np * turn, &m->x.cos_theta, &m->x.sin_theta);
    const plant_planes_t flux_1 = plant_flux_magnet(m, &m->x),
                         emf_1 = plant_flux_open_emf(m, &m->x);
    const double omega_1 = m->x.omega_m_rad_s;
    *sum = (plant_stretch_t){
        .friction_J =
            m->B_Nms * h * (omega_0 * omega_0 + omega_0 * omega_1 + omega_1 * omega_1) / 3.0,
        .load_J = shaft.load_Nm * turn,
    };
    const plant_planes_t change = {
        {flux_1.ab.alpha - flux_0.ab.alpha, flux_1.ab.beta - flux_0.ab.beta},
        {flux_1.xy.alpha - flux_0.xy.alpha, flux_1.xy.beta - flux_0.xy.beta},
    };
    for (int set = 0; set < m->sets; set++) {
        sum->set[set].all_Vs = plant_sets_vector(&change, set);
        sum->set[set].all_start_V = plant_sets_vector(&emf_0, set);
        sum->set[set].all_end_V = plant_sets_vector(&emf_1, set);
    }
    if (m->speed_is_prescribed) {
        sum->load_J = -sum->friction_J;
    }
    stop_at_reversal(m, omega_0, sum);
}

/// The point reached from p[0] with the trial slopes.
HOT void move(const plant_motor_t *m, const point_t *from, double h, const slope_t *k, point_t *to,
              kind_t kind) {
    to->psi_q = from->psi_q + h * k->dpsi_q;
    if (kind.iron) {
        to->psi_d = from->psi_d + h * k->dpsi_d;
        to->id = from->id;
        to->iq = from->iq;
        plant_iron_currents(&m->iron, to->psi_d, to->psi_q, &to->id, &to->iq);
    } else {
        to->id = from->id + h * k->did;
        to->iq = m->inv_Lq * to->psi_q;
    }
    if (kind.dual) {
        to->ix = from->ix + h * k->dix;
        to->iy = from->iy + h * k->diy;
    }
}

HOT void step(plant_motor_t *self, const plant_drive_t *drive, double h_s, plant_stretch_t *sum,
              kind_t kind) {
    // Kutta's third-order rule: slopes at the start, the middle and the end, weights 1, 4, 1.
    plant_motor_state_t *x = &self->x;
    const double h = h_s, half = 0.5 * h_s;
    point_t p[3];
    slope_t k[3];
    p[0] = point_of(self, x, kind);
    k[0] = slope_at(self, drive, &p[0], kind);
    const plant_shaft_t shaft = shaft_at(self, k[0].torque, h_s);
    const double a_0 = acceleration(self, &shaft, k[0].torque, p[0].omega);

    // For half the angle turned, applied twice; then the contribution of the acceleration.
    double c, s;
    small_angle(self->np * half * (p[0].omega + 0.5 * half * a_0), &c, &s);
    const double more = self->np * half * half * a_0;
    p[1].cos = p[0].cos * c - p[0].sin * s;
    p[1].sin = p[0].sin * c + p[0].cos * s;
    c -= s * more;
    s += c * more;
    p[2].cos = p[1].cos * c - p[1].sin * s;
    p[2].sin = p[1].sin * c + p[1].cos * s;

    move(self, &p[0], half, &k[0], &p[1], kind);
    p[1].omega = p[0].omega + half * a_0;
    k[1] = slope_at(self, drive, &p[1], kind);
    const double a_1 = acceleration(self, &shaft, k[1].torque, p[1].omega);

    const slope_t onward = {.did = 2.0 * k[1].did - k[0].did,
                            .dpsi_q = 2.0 * k[1].dpsi_q - k[0].dpsi_q,
                            .dpsi_d = 2.0 * k[1].dpsi_d - k[0].dpsi_d,
                            .dix = kind.dual ? 2.0 * k[1].dix - k[0].dix : 0.0,
                            .diy = kind.dual ? 2.0 * k[1].diy - k[0].diy : 0.0};
    move(self, &p[0], h, &onward, &p[2], kind);
    p[2].omega = p[0].omega + h * (2.0 * a_1 - a_0);
    k[2] = slope_at(self, drive, &p[2], kind);
    const double a_2 = acceleration(self, &shaft, k[2].torque, p[2].omega);

    note_ends(self, p, k, sum, kind);
    if (!kind.plain && self->keeps_accounts) {
        integrate(self, &shaft, p, k, h, sum);
    }
    const double jerk_turn = self->np * h * h / 3.0 * (a_1 - a_0);
    x->theta_e_rad += self->np * h * (p[0].omega + half * a_0) + jerk_turn;
    x->cos_theta = p[2].cos - p[2].sin * jerk_turn;
    x->sin_theta = p[2].sin + p[2].cos * jerk_turn;
    const double psi_q = p[0].psi_q + h / 6.0 * (k[0].dpsi_q + 4.0 * k[1].dpsi_q + k[2].dpsi_q);
    if (kind.iron) {
        const double psi_d = p[0].psi_d + h / 6.0 * (k[0].dpsi_d + 4.0 * k[1].dpsi_d + k[2].dpsi_d);
        plant_iron_currents(&self->iron, psi_d, psi_q, &x->id_A, &x->iq_A);
    } else {
        x->id_A += h / 6.0 * (k[0].did + 4.0 * k[1].did + k[2].did);
        x->iq_A = self->inv_Lq * psi_q;
    }
    x->omega_m_rad_s += h / 6.0 * (a_0 + 4.0 * a_1 + a_2);
    if (kind.dual) {
        x->ix_A += h / 6.0 * (k[0].dix + 4.0 * k[1].dix + k[2].dix);
        x->iy_A += h / 6.0 * (k[0].diy + 4.0 * k[1].diy + k[2].diy);
        note_ends_of_sets(drive, k, sum);
        if (self->keeps_accounts) {
            integrate_second_set(drive, p, k, h, sum);
        }
    }
    stop_at_reversal(self, p[0].omega, sum);
}

/// A copy of the code for each kind: most runs need the shortest.
static void step_rotor(plant_motor_t *self, const plant_drive_t *drive, double h_s,
                       plant_stretch_t *sum) {
    const bool dual = self->sets == PLANT_SETS;
    if (drive->floating[0] == PLANT_ALL_FLOAT && (!dual || drive->floating[1] == PLANT_ALL_FLOAT)) {
        coast(self, h_s, sum);
    } else if (dual && self->saturates) {
        step(self, drive, h_s, sum, (kind_t){.dual = true, .iron = true});
    } else if (dual) {
        step(self, drive, h_s, sum, (kind_t){.dual = true});
    } else if (self->saturates) {
        step(self, drive, h_s, sum, (kind_t){.iron = true});
    } else if (self->is_plain && drive->floating[0] == PLANT_NONE_FLOATS) {
        step(self, drive, h_s, sum, (kind_t){.plain = true});
    } else {
        step(self, drive, h_s, sum, (kind_t){.dual = false});
    }
}

void plant_motor_step(plant_motor_t *self, const plant_drive_t *drive, double h_s,
                      plant_stretch_t *sum) {
    if (!(self->load.J_kgm2 > 0.0)) {
        step_rotor(self, drive, h_s, sum);
        return;
    }
    const plant_motor_state_t before = self->x;
    step_rotor(self, drive, h_s, sum);
    plant_load_follow(self, &before, h_s);
}

double plant_motor_longest_step(const plant_motor_t *self, double R_Ohm) {
    const double w = self->np * self->x.omega_m_rad_s;
    const double L = self->iron.smallest_L_H;
    const double decay = R_Ohm / (self->sets == 1 ? L : fmin(L, self->Lxy_H));
    double fastest2 = fmax(w * w, decay * decay);
    if (self->has_xy_harmonics) {
        // Harmonics of a few per cent of the current turn up to seven times as fast: steps of a third of 1/(7 w).
        fastest2 = fmax(fastest2, 5.4 * w * w);
    }
    if (!self->speed_is_prescribed) {
        // The rotor swings in the field of the currents like a mass on a spring, a light one fast.
        // Saturation leaves less flux.
        const double psi_d = self->psi_Wb + self->Ld_H * self->x.id_A;
        const double psi_q = self->Lq_H * self->x.iq_A;
        const double stiffness =
            self->power * self->np * self->np * (psi_d * psi_d + psi_q * psi_q) / L;
        fastest2 = fmax(fastest2, stiffness * self->inv_J);
    }
    if (self->has_load) {
        fastest2 = fmax(fastest2, plant_load_swing2(self));
    }
    // 0.05 rad of the fastest motion: 5e-6 of relative error per radian.
    return 0.05 / sqrt(fmax(fastest2, 2500.0));
}

static kind_t kind_of(const plant_motor_t *self) {
    return (kind_t){.dual = self->sets == PLANT_SETS, .iron = self->saturates};
}

double plant_motor_torque(const plant_motor_t *self) {
    const plant_drive_t none = {.floating = {PLANT_NONE_FLOATS, PLANT_NONE_FLOATS}};
    if (self->is_plain) { // computed in every period
        const kind_t plain = {.plain = true};
        const point_t at = point_of(self, &self->x, plain);
        return slope_at(self, &none, &at, plain).torque;
    }
    const kind_t kind = kind_of(self);
    const point_t at = point_of(self, &self->x, kind);
    return slope_at(self, &none, &at, kind).torque;
}

void plant_motor_slopes(const plant_motor_t *self, const plant_drive_t *drive,
                        plant_stretch_t *now) {
    const kind_t kind = kind_of(self);
    if (!kind.dual && drive->floating[0] == PLANT_ALL_FLOAT) {
        const plant_planes_t emf = plant_flux_open_emf(self, &self->x);
        *now = (plant_stretch_t){.set = {{.all_start_V = emf.ab}}};
        return;
    }
    const point_t at = point_of(self, &self->x, kind);
    const slope_t slope = slope_at(self, drive, &at, kind);
    const plant_vector_dq_t di = current_slopes(self, &at, &slope, kind);
    now->did_start_A_s = di.d;
    now->diq_start_A_s = di.q;
    now->dix_start_A_s = slope.dix;
    now->diy_start_A_s = slope.diy;
    now->set[0].u_start_V = slope.u_float;
    for (int set = 0; kind.dual && set < PLANT_SETS; set++) {
        const int leg = drive->floating[set];
        now->set[set].all_start_V = slope.push[set];
        if (leg != PLANT_NONE_FLOATS && leg != PLANT_ALL_FLOAT) {
            now->set[set].u_start_V = terminal_of(&slope.push[set], leg);
        }
    }
}

double plant_motor_phase_slope(const plant_motor_t *self, const plant_motor_state_t *state,
                               const plant_stretch_t *stretch, int leg) {
    const double w = self->np * state->omega_m_rad_s;
    const double ac = plant_axis_cos[leg], as = plant_axis_sin[leg];
    const double ad = ac * state->cos_theta + as * state->sin_theta;
    const double aq = as * state->cos_theta - ac * state->sin_theta;
    const double slope = ad * (stretch->did_start_A_s - w * state->iq_A) +
                         aq * (stretch->diq_start_A_s + w * state->id_A);
    if (self->sets == 1) {
        return slope;
    }
    const double xy = ac * stretch->dix_start_A_s - as * stretch->diy_start_A_s;
    return leg < PLANT_PHASES ? slope + xy : slope - xy;
}

plant_planes_t plant_motor_active_emf(const plant_motor_t *self) {
    const plant_motor_state_t *x = &self->x;
    const double w = self->np * x->omega_m_rad_s;
    double flux_Wb = (self->Ld_H - self->Lq_H) * x->id_A; // on top of the magnet's
    if (self->saturates) {
        // psi_d - Lq id with the chord Lq = psi_q/iq, in its limit at no current
        const plant_iron_point_t at = plant_iron_at(&self->iron, x->id_A, x->iq_A);
        const bool chord = fabs(x->iq_A) > chord_floor_A;
        flux_Wb = at.psi_d_Wb - (chord ? at.psi_q_Wb / x->iq_A : at.Lqq_H) * x->id_A;
    }
    const double e = w * flux_Wb;
    plant_planes_t emf = plant_flux_open_emf(self, x);
    emf.ab.alpha -= e * x->sin_theta;
    emf.ab.beta += e * x->cos_theta;
    return emf;
}

static plant_planes_t planes_of(const plant_motor_state_t *x) {
    return (plant_planes_t){
        .ab = {x->id_A * x->cos_theta - x->iq_A * x->sin_theta,
               x->id_A * x->sin_theta + x->iq_A * x->cos_theta},
        .xy = {x->ix_A, x->iy_A},
    };
}

void plant_motor_leg_currents(const plant_motor_state_t *state, double i_A[PLANT_LEGS]) {
    const plant_planes_t i = planes_of(state);
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        const plant_vector_t set = plant_sets_vector(&i, leg / PLANT_PHASES);
        i_A[leg] = plant_axis_cos[leg] * set.alpha + plant_axis_sin[leg] * set.beta;
    }
}

/// Adds a vector to a set's current.
static void add_to_set(plant_motor_t *m, int set, plant_vector_t vector) {
    plant_motor_state_t *x = &m->x;
    plant_planes_t more = {vector, {0.0, 0.0}};
    if (m->sets == PLANT_SETS) {
        more.ab = (plant_vector_t){0.0, 0.0};
        plant_sets_add(&more, set, vector);
    }
    x->id_A += more.ab.alpha * x->cos_theta + more.ab.beta * x->sin_theta;
    x->iq_A += more.ab.beta * x->cos_theta - more.ab.alpha * x->sin_theta;
    x->ix_A += more.xy.alpha;
    x->iy_A += more.xy.beta;
}

void plant_motor_clear_phase(plant_motor_t *self, int leg) {
    const plant_planes_t i = planes_of(&self->x);
    const plant_vector_t set = plant_sets_vector(&i, leg / PLANT_PHASES);
    const double ac = plant_axis_cos[leg], as = plant_axis_sin[leg];
    const double rest = ac * set.alpha + as * set.beta;
    add_to_set(self, leg / PLANT_PHASES, (plant_vector_t){-rest * ac, -rest * as});
}

void plant_motor_clear_set(plant_motor_t *self, int set) {
    if (self->sets == 1) {
        self->x.id_A = 0.0;
        self->x.iq_A = 0.0;
        return;
    }
    const plant_planes_t i = planes_of(&self->x);
    const plant_vector_t own = plant_sets_vector(&i, set);
    add_to_set(self, set, (plant_vector_t){-own.alpha, -own.beta});
}

double plant_motor_field_energy(const plant_motor_t *self) {
    const double id = self->x.id_A, iq = self->x.iq_A, ix = self->x.ix_A, iy = self->x.iy_A;
    double energy = 0.5 * self->Lxy_H * (ix * ix + iy * iy);
    if (self->saturates) {
        energy += plant_iron_energy(&self->iron, id, iq);
    } else {
        energy += 0.5 * self->Ld_H * id * id + 0.5 * self->Lq_H * iq * iq;
    }
    return self->power * energy;
}

double plant_motor_kinetic_energy(const plant_motor_t *self) {
    return 0.5 * self->J_kgm2 * self->x.omega_m_rad_s * self->x.omega_m_rad_s;
}
