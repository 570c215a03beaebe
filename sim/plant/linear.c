#include "plant/linear.h"

#include <math.h>

#if defined(__GNUC__)
#define HOT static inline __attribute__((always_inline))
#else
#define HOT static inline
#endif

/// Largest turn of the rotor in one run, rad: the short series are exact for half of it each way.
static const double longest_turn = 0.3;
/// Largest effect of a change of acceleration in one run, as the phase of a swing, rad: the loop assumes
/// constant acceleration.
static const double longest_swing = 0.025;
/// Phase of the fastest motion between two points, rad.
static const double longest_piece = 0.1;
/// Accuracy of the zero of a reversing current, A: half of the limit for zero.
static const double zero_A = 1e-5;

/// A vector's two components, alpha and beta or d and q, which the processor takes together.
typedef double pair_t __attribute__((vector_size(2 * sizeof(double))));

/// One instant. Vectors in the coordinates of the run: those of the rotor in its middle.
typedef struct {
    /// flux linkage without the resistance: its initial value plus all volt-seconds since
    pair_t psi_u;
    pair_t i, i_As;
    pair_t dq; ///< the current in rotor coordinates
    double t_s;
    double torque; ///< psi x i
} point_t;

/// State of a leg in the run.
typedef struct {
    pair_t axis;
    double next_s; ///< its next edge
    double guard;  ///< sign of its current whose loss must be detected; 0 if it has no effect
    double i_A;
    double step_V;    ///< of the source vector along the axis when the terminal next moves
    plant_gate_t key; ///< with drops: only this gate moves the terminal, on or off
    int next;         ///< with drops: the edge at next_s
} way_t;

typedef struct {
    plant_inverter_t *inverter;
    // Constant in a run.
    pair_t L, inv_L, psi_m; ///< d and q
    pair_t pull;            ///< share of the other current in the slope, times speed
    double R;
    /// difference between a leg's two levels; difference between the two signs at one level
    double rails_V, drops_V;
    double middle_s, w, half_a; ///< the angle from the middle: w t + half_a t^2
    double longest_s, slope_A_s;
    pair_t drift_A_s; ///< slope of the current without voltage
    point_t at;
    pair_t u, half_slope, psi_start;
    pair_t axis_alpha, axis_beta; ///< of phases a and b
    way_t leg[PLANT_PHASES];
    bool may_pass;   ///< pass_over() has not just failed
    int passed_sign; ///< of a leg before it
    plant_gate_t passed_gate;
    // Sums of h^3, of that times u, of h^2 times the change of the current, of the torque over time and over that
    // to the middle.
    double h3, torque_s, torque_s2, h_dd_dq;
    pair_t h3_u, h2_di;
} run_t;

HOT double smaller(double a, double b) {
    return a < b ? a : b;
}

/// Cosine and sine of an angle up to 0.2 rad; the series end below 1e-7 and 1e-8 of a current.
HOT void turned_little(double angle, double *c, double *s) {
    const double x2 = angle * angle;
    *c = 1.0 - x2 * (0.5 - x2 * (1.0 / 24));
    *s = angle * (1.0 - x2 * (1.0 / 6 - x2 * (1.0 / 120)));
}

/// The same for final results, below 1e-13.
static void turned(double angle, double *c, double *s) {
    const double x2 = angle * angle;
    *c = 1.0 - x2 * (0.5 - x2 * (1.0 / 24 - x2 * (1.0 / 720 - x2 * (1.0 / 40320))));
    *s = angle * (1.0 - x2 * (1.0 / 6 - x2 * (1.0 / 120 - x2 * (1.0 / 5040))));
}

HOT pair_t swapped(pair_t v) {
    return (pair_t){v[1], v[0]};
}

/// In coordinates that lie this angle ahead ...
HOT pair_t turned_back(pair_t v, double c, double s) {
    return v * c + swapped(v) * (pair_t){s, -s};
}

/// ... and from there.
HOT pair_t turned_forth(pair_t v, double c, double s) {
    return v * c - swapped(v) * (pair_t){s, -s};
}

HOT double cross(pair_t a, pair_t b) {
    const pair_t both = a * swapped(b);
    return both[0] - both[1];
}

/// The next point, h further.
HOT point_t advance(const run_t *run, double h) {
    const point_t *from = &run->at;
    point_t to;
    double c, s;
    to.t_s = from->t_s + h;
    const double t = to.t_s - run->middle_s;
    turned_little(t * (run->w + t * run->half_a), &c, &s);
    to.psi_u = from->psi_u + h * run->u;
    // The resistive drop from an estimate of the mean current, so that it does not wait for the result.
    const pair_t i_As = from->i_As + h * (from->i + h * run->half_slope);
    const pair_t psi = to.psi_u - run->R * i_As;
    to.dq = (turned_back(psi, c, s) - run->psi_m) * run->inv_L;
    to.i = turned_forth(to.dq, c, s);
    to.i_As = from->i_As + 0.5 * h * (from->i + to.i);
    to.torque = cross(psi, to.i);
    return to;
}

HOT void phase_currents(const run_t *run, const point_t *at, double i_A[PLANT_PHASES]) {
    const pair_t a_b = run->axis_alpha * at->i[0] + run->axis_beta * at->i[1];
    i_A[0] = a_b[0];
    i_A[1] = a_b[1];
    i_A[2] = -a_b[0] - a_b[1];
}

HOT bool keeps_signs(const run_t *run, const double i_A[PLANT_PHASES]) {
    const way_t *leg = run->leg;
    const double least =
        smaller(leg[0].guard * i_A[0], smaller(leg[1].guard * i_A[1], leg[2].guard * i_A[2]));
    return least >= -PLANT_NOISE_A;
}

/// Accepts a point.
HOT void accept(run_t *run, const point_t *to, const double i_A[PLANT_PHASES], double h) {
    const point_t *from = &run->at;
    const double h2 = h * h, h3 = h2 * h, torque_s = 0.5 * h * (from->torque + to->torque);
    const pair_t d_dq = to->dq - from->dq;
    run->h3 += h3;
    run->h3_u += h3 * run->u;
    run->h2_di += h2 * (to->i - from->i);
    run->h_dd_dq += h * d_dq[0] * d_dq[1];
    run->torque_s += torque_s;
    run->torque_s2 += torque_s * (to->t_s - 0.5 * h - run->middle_s);
    run->at = *to;
    run->leg[0].i_A = i_A[0];
    run->leg[1].i_A = i_A[1];
    run->leg[2].i_A = i_A[2];
}

HOT void set_slope(run_t *run) {
    run->half_slope = 0.5 * (run->u * run->inv_L + run->drift_A_s);
}

/// With drops: a current is always guarded, and only edges that move the terminal count.
HOT void find_move(run_t *run, int n, int from) {
    const plant_pwm_t *pwm = &run->inverter->leg[n].pwm;
    way_t *way = &run->leg[n];
    const bool is_at_key = (way->key == PLANT_GATE_HIGH) == (way->step_V < 0.0);
    int k = from;
    while (k < pwm->edges && (pwm->edge[k].gate == way->key) == is_at_key) {
        k++;
    }
    way->next = k;
    way->next_s = k < pwm->edges ? pwm->edge[k].at_s : HUGE_VAL;
}

/// The level of the leg's terminal for this gate and sign, and the edge that changes it.
HOT void look_at_leg(run_t *run, int n, plant_gate_t gate) {
    const int sign = run->inverter->leg[n].sign;
    way_t *way = &run->leg[n];
    way->step_V = plant_inverter_on_high_rail(gate, sign) ? -run->rails_V : run->rails_V;
    way->guard = sign;
    way->key = sign > 0 ? PLANT_GATE_HIGH : PLANT_GATE_LOW;
}

HOT void move_terminal(run_t *run, int n) {
    way_t *way = &run->leg[n];
    run->u += way->step_V * way->axis;
    way->step_V = -way->step_V;
    set_slope(run);
}

/// Without drops: a current is guarded only while both gates are off, unless it is too large to pass zero
/// before the other gate turns on.
HOT void find_next(run_t *run, int n) {
    plant_leg_t *leg = &run->inverter->leg[n];
    plant_pwm_t *pwm = &leg->pwm;
    way_t *way = &run->leg[n];
    int k = pwm->next;
    if (pwm->gate == PLANT_GATE_OFF && k < pwm->edges &&
        plant_inverter_on_high_rail(pwm->edge[k].gate, leg->sign) == (leg->sign < 0) &&
        fabs(way->i_A) > run->slope_A_s * (pwm->edge[k].at_s - run->at.t_s)) {
        pwm->gate = pwm->edge[k++].gate;
        pwm->next = k;
    }
    way->guard = pwm->gate == PLANT_GATE_OFF ? leg->sign : 0.0;
    way->next_s = k < pwm->edges ? pwm->edge[k].at_s : HUGE_VAL;
}

/// The current may have passed through zero without any effect.
HOT void follow_sign(run_t *run, int n) {
    plant_leg_t *leg = &run->inverter->leg[n];
    if (leg->sign * run->leg[n].i_A < -PLANT_NOISE_A) {
        leg->sign = -leg->sign;
    }
}

/// The leg's next edge is now.
HOT void take_edge(run_t *run, int n, bool drops) {
    way_t *way = &run->leg[n];
    plant_leg_t *leg = &run->inverter->leg[n];
    if (drops) {
        move_terminal(run, n);
        find_move(run, n, way->next + 1);
        return;
    }
    follow_sign(run, n);
    leg->pwm.gate = leg->pwm.edge[leg->pwm.next++].gate;
    if (plant_inverter_on_high_rail(leg->pwm.gate, leg->sign) != (way->step_V < 0.0)) {
        move_terminal(run, n);
    }
    find_next(run, n);
}

/// Contribution of the rotor's motion and the EMF to the slope of the current in rotor coordinates: (M1), (M2).
HOT pair_t rotation_A_s(const run_t *run, double w, pair_t dq) {
    const pair_t emf_A_s = {0.0, w * run->psi_m[0] * run->inv_L[1]};
    return w * swapped(dq) * run->pull - emf_A_s;
}

/// Rate of a leg's current now, A/s: (M1), (M2).
static double slope_of(const run_t *run, int n) {
    const point_t *at = &run->at;
    const double t = at->t_s - run->middle_s, w = run->w + 2.0 * run->half_a * t;
    double c, s;
    turned_little(t * (run->w + t * run->half_a), &c, &s);
    const pair_t v = turned_back(run->u - run->R * at->i, c, s);
    const pair_t rate = v * run->inv_L + rotation_A_s(run, w, at->dq);
    const pair_t slope = run->leg[n].axis * turned_forth(rate, c, s);
    return slope[0] + slope[1];
}

/// The leg whose current crosses zero first on the way to i_A, by linear interpolation.
static int first_through_zero(const run_t *run, const double i_A[PLANT_PHASES]) {
    int first = 0;
    double soonest = HUGE_VAL;
    for (int n = 0; n < PLANT_PHASES; n++) {
        const double was_A = run->leg[n].i_A;
        const double share = was_A / (was_A - i_A[n]);
        if (run->leg[n].guard * i_A[n] < -PLANT_NOISE_A && share < soonest) {
            soonest = share;
            first = n;
        }
    }
    return first;
}

/// Goes to the zero of the leg's current within h. False if it is not found quickly, or another leg is earlier.
/// For a current that starts at zero, the zero to find is later than linear interpolation gives.
static bool go_to_zero(run_t *run, int n, double i_end_A, double h) {
    double i_A[PLANT_PHASES];
    double early_s = 0.0, late_s = h, early_A = run->leg[n].i_A, late_A = i_end_A;
    if (fabs(early_A) < PLANT_NOISE_A) {
        return false;
    }
    for (int pass = 0; pass < 5 && early_A * late_A < 0.0; pass++) {
        const double at_s = early_s + (late_s - early_s) * (early_A / (early_A - late_A));
        const point_t to = advance(run, at_s);
        phase_currents(run, &to, i_A);
        if (fabs(i_A[n]) < zero_A) {
            const bool good = keeps_signs(run, i_A);
            if (good) {
                accept(run, &to, i_A, at_s);
            }
            return good;
        }
        if (i_A[n] * early_A > 0.0) {
            early_s = at_s;
            early_A = i_A[n];
        } else {
            late_s = at_s;
            late_A = i_A[n];
        }
    }
    return false;
}

/// Reverses the sign, and updates the leg's edges from this one on.
static void change_sign(run_t *run, int n, plant_gate_t gate, int next) {
    run->inverter->leg[n].sign *= -1;
    look_at_leg(run, n, gate);
    find_move(run, n, next);
}

/// Time of the zero of the leg's current, by the parabola through its value and slope now and its value at h;
/// negative if the parabola is far from a straight line.
static double zero_on_the_way(const run_t *run, int n, double i_end_A, double h) {
    const double i_A = run->leg[n].i_A, mean = (i_end_A - i_A) / h;
    const double bend = mean - slope_of(run, n), straight = -i_A / (i_end_A - i_A);
    if (!(fabs(bend) < 0.1 * fabs(mean))) {
        return -1.0;
    }
    // Deviation of the parabola from the line there, over its slope.
    const double off = bend * straight * (1.0 - straight);
    return h * (straight + off / (mean + bend * (2.0 * straight - 1.0)));
}

/// Goes past the zero at zero_s to the end of the piece, or to the next edge of the leg with the other sign.
/// Until then the mean source is used; (M19) corrects the integrals for the bend of the flux linkage at zero_s.
/// False if the current does not continue with the other sign, or another current crosses zero.
static bool go_past_zero(run_t *run, int n, double zero_s, double h) {
    const way_t *way = &run->leg[n];
    const pair_t step_V = -way->guard * run->drops_V * way->axis, u = run->u;
    const double h_s = smaller(h, way->next_s - run->at.t_s), rest_s = h_s - zero_s;
    double i_A[PLANT_PHASES];
    if (!(rest_s > 0.0)) {
        return false;
    }
    run->u = u + rest_s / h_s * step_V;
    set_slope(run);
    const point_t to = advance(run, h_s);
    phase_currents(run, &to, i_A);
    const bool good = keeps_signs(run, i_A) && way->guard * i_A[n] > PLANT_NOISE_A;
    if (good) {
        const pair_t psi_Vs2 = -0.5 * zero_s * rest_s * step_V, i_As = psi_Vs2 * run->inv_L;
        accept(run, &to, i_A, h_s);
        run->at.i_As += i_As;
        run->torque_s += cross(to.psi_u, i_As) + cross(psi_Vs2, to.i);
        run->u = u + step_V;
    } else {
        run->u = u;
    }
    set_slope(run);
    return good;
}

/// The usual reversal: while a gate is on, with a steep current. False if nothing was done.
static bool pass_zero(run_t *run, int n, double i_end_A, double h) {
    plant_leg_t *leg = &run->inverter->leg[n];
    plant_pwm_t *pwm = &leg->pwm;
    const double zero_s = zero_on_the_way(run, n, i_end_A, h);
    const int next = plant_pwm_first_after(pwm, run->at.t_s + zero_s);
    const plant_gate_t gate = next > pwm->next ? pwm->edge[next - 1].gate : pwm->gate;
    if (!(zero_s > 0.0) || gate == PLANT_GATE_OFF || fabs(run->leg[n].i_A) < PLANT_NOISE_A) {
        return false;
    }
    const way_t before = run->leg[n];
    change_sign(run, n, gate, next);
    if (go_past_zero(run, n, zero_s, h)) {
        pwm->gate = gate;
        pwm->next = next;
        return true;
    }
    leg->sign = -leg->sign;
    run->leg[n] = before;
    return false;
}

/// A current that passes zero while a gate is on reverses, unless the drops hold it. False if the run has to
/// end: the current of leg `stopped` is zero and stays zero for now, or, if that is PLANT_NONE_FLOATS, the
/// search failed.
static bool reverse(run_t *run, const double i_A[PLANT_PHASES], double h, int *stopped) {
    const int n = first_through_zero(run, i_A);
    plant_leg_t *leg = &run->inverter->leg[n];
    if (pass_zero(run, n, i_A[n], h)) {
        return true;
    }
    if (!go_to_zero(run, n, i_A[n], h)) {
        return false;
    }
    (void)plant_pwm_apply(&leg->pwm, run->at.t_s);
    if (leg->pwm.gate != PLANT_GATE_OFF) {
        run->u += leg->sign * run->drops_V * run->leg[n].axis;
        set_slope(run);
        change_sign(run, n, leg->pwm.gate, leg->pwm.next);
        if (slope_of(run, n) * leg->sign > 0.0) {
            return true;
        }
        leg->sign = -leg->sign;
    }
    *stopped = n;
    return false;
}

/// Sets the coordinates, and the initial state of the motor in them.
static void place(run_t *run, const plant_motor_t *motor, double a, double T_s) {
    const plant_motor_state_t *x = &motor->x;
    const double w = motor->np * x->omega_m_rad_s;
    double c, s;
    turned(0.5 * T_s * (w + 0.25 * T_s * a), &c, &s);
    point_t *at = &run->at;
    const pair_t psi = {motor->psi_Wb + motor->Ld_H * x->id_A, motor->Lq_H * x->iq_A};
    at->dq = (pair_t){x->id_A, x->iq_A};
    at->i = turned_back(at->dq, c, s);
    at->psi_u = turned_back(psi, c, s);
    at->i_As = (pair_t){0.0, 0.0};
    run->psi_start = at->psi_u;
    const pair_t rotor = turned_forth((pair_t){x->cos_theta, x->sin_theta}, c, s);
    const plant_drive_t *u = &run->inverter->drive;
    run->u = turned_back((pair_t){u->u_alpha_V, u->u_beta_V}, rotor[0], rotor[1]);
    for (int n = 0; n < PLANT_PHASES; n++) {
        run->leg[n].axis =
            turned_back((pair_t){plant_axis_cos[n], plant_axis_sin[n]}, rotor[0], rotor[1]);
    }
    run->axis_alpha = (pair_t){run->leg[0].axis[0], run->leg[1].axis[0]};
    run->axis_beta = (pair_t){run->leg[0].axis[1], run->leg[1].axis[1]};
}

/// Torque against psi x i on the shaft, without friction, Nm; with a passive load the speed is not zero.
static double load_of(const plant_motor_t *motor) {
    return motor->load_is_passive ? copysign(fabs(motor->load_Nm), motor->x.omega_m_rad_s)
                                  : motor->load_Nm;
}

/// The rotor swings in the field of the currents like a mass on a spring: the square of its natural frequency, 1/s2.
static double swing_rate2(const plant_motor_t *motor) {
    const double psi_d = motor->psi_Wb + motor->Ld_H * motor->x.id_A;
    const double psi_q = motor->Lq_H * motor->x.iq_A;
    const double inv_L = motor->inv_Ld > motor->inv_Lq ? motor->inv_Ld : motor->inv_Lq;
    return motor->speed_is_prescribed ? 0.0
                                      : motor->power * motor->np * motor->np * motor->inv_J *
                                            inv_L * (psi_d * psi_d + psi_q * psi_q);
}

static double electrical_inv_J(const plant_motor_t *motor) {
    return motor->speed_is_prescribed ? 0.0 : motor->np * motor->inv_J;
}

static void start(run_t *run, plant_inverter_t *inverter, const plant_motor_t *motor, double now_s,
                  double until_s) {
    const plant_motor_state_t *x = &motor->x;
    const double T_s = until_s - now_s, K = motor->power * motor->np;
    const double w = motor->np * x->omega_m_rad_s, inv_J = electrical_inv_J(motor);
    const pair_t dq = {x->id_A, x->iq_A};
    run->inverter = inverter;
    run->R = inverter->drive.R_Ohm;
    run->drops_V = (2.0 / 3.0) * (inverter->v_transistor_V + inverter->v_diode_V);
    run->rails_V =
        (2.0 / 3.0) * (inverter->v_bus_V - inverter->v_transistor_V + inverter->v_diode_V);
    run->L = (pair_t){motor->Ld_H, motor->Lq_H};
    run->inv_L = (pair_t){motor->inv_Ld, motor->inv_Lq};
    run->pull = (pair_t){motor->Lq_H * motor->inv_Ld - 1.0, 1.0 - motor->Ld_H * motor->inv_Lq};
    run->psi_m = (pair_t){motor->psi_Wb, 0.0};
    const pair_t psi = run->psi_m + run->L * dq;
    run->at.t_s = now_s;
    run->at.torque = cross(psi, dq);
    const double a =
        inv_J * (K * run->at.torque - load_of(motor) - motor->B_Nms * x->omega_m_rad_s);
    run->middle_s = now_s + 0.5 * T_s;
    run->half_a = 0.5 * a;
    run->w = w + 0.5 * a * T_s;
    place(run, motor, a, T_s);
    run->drift_A_s = rotation_A_s(run, w, run->at.dq) - run->R * run->at.i * run->inv_L;
    set_slope(run);
    const double inv_L = motor->inv_Ld > motor->inv_Lq ? motor->inv_Ld : motor->inv_Lq;
    const double rate = smaller(-fabs(w), -run->R * inv_L);
    run->longest_s = -longest_piece / (rate - 1.0);
    // Upper bound of the slope of any current, whatever conducts.
    run->slope_A_s = inv_L * (inverter->v_bus_V + 2.0 * fabs(w) * (fabs(psi[0]) + fabs(psi[1])) +
                              run->R * (fabs(dq[0]) + fabs(dq[1])));
    run->h3 = run->torque_s = run->torque_s2 = run->h_dd_dq = 0.0;
    run->h3_u = run->h2_di = (pair_t){0.0, 0.0};
    double i_A[PLANT_PHASES];
    phase_currents(run, &run->at, i_A);
    for (int n = 0; n < PLANT_PHASES; n++) {
        run->leg[n].i_A = i_A[n];
        look_at_leg(run, n, inverter->leg[n].pwm.gate);
        if (inverter->has_drops) {
            find_move(run, n, inverter->leg[n].pwm.next);
        } else {
            find_next(run, n);
        }
    }
}

/// Corrects the integrals of current and torque for the error of the trapezoidal rule by (M18), with the rotor
/// angle of the middle.
static void correct(run_t *run, pair_t psi) {
    static const pair_t conjugate = {1.0, -1.0};
    const double w = run->w, R = run->R, h3 = run->h3;
    const double Ld = run->L[0], Lq = run->L[1], psi_m = run->psi_m[0];
    const double turn = 2.0 * w * (run->inv_L[0] - run->inv_L[1]);
    const pair_t dq = (psi - run->psi_m) * run->inv_L;
    // The change of the flux linkage: voltage minus drop.
    const pair_t v = run->h3_u - R * h3 * dq, r = R * run->h2_di;
    const pair_t pull = {w * w * psi_m * run->inv_L[0] * h3, 0.0};
    const pair_t i2 = turn * (swapped(v) - conjugate * (w * h3 * psi)) + pull - run->inv_L * r;
    const pair_t dq2 = (conjugate * (2.0 * w * swapped(v)) - w * w * h3 * psi - r) * run->inv_L;
    run->at.i_As -= i2 * (1.0 / 12);
    run->torque_s -=
        ((psi_m + (Ld - Lq) * dq[0]) * dq2[1] + (Ld - Lq) * (dq[1] * dq2[0] + 2.0 * run->h_dd_dq)) *
        (1.0 / 12);
}

/// Sets the motor to the end of the run.
static void finish(run_t *run, plant_motor_t *motor, double start_s) {
    plant_motor_state_t *x = &motor->x;
    const double inv_J = electrical_inv_J(motor), K = motor->power * motor->np;
    const double T_s = run->at.t_s - start_s, w = motor->np * x->omega_m_rad_s;
    correct(run, 0.5 * (run->psi_start + run->at.psi_u - run->R * run->at.i_As));
    // Each torque accelerates the rotor from its own time to the end.
    const double steady = load_of(motor) + motor->B_Nms * x->omega_m_rad_s;
    const double dw = inv_J * (K * run->torque_s - steady * T_s);
    const double moment = run->torque_s * (run->at.t_s - run->middle_s) - run->torque_s2;
    const double turn = T_s * w + inv_J * (K * moment - 0.5 * steady * T_s * T_s);
    // Angle of the coordinates from the start, then that of the rotor from the coordinates.
    const double half_s = run->middle_s - start_s;
    const double beyond = turn - half_s * (run->w - run->half_a * half_s);
    double c, s;
    turned(beyond, &c, &s);
    const pair_t psi = turned_back(run->at.psi_u - run->R * run->at.i_As, c, s);
    const pair_t dq = (psi - run->psi_m) * run->inv_L;
    x->id_A = dq[0];
    x->iq_A = dq[1];
    x->theta_e_rad += turn;
    x->omega_m_rad_s += dw / motor->np;
    turned(turn, &c, &s);
    const pair_t rotor = turned_forth((pair_t){x->cos_theta, x->sin_theta}, c, s);
    x->cos_theta = rotor[0];
    x->sin_theta = rotor[1];
}

/// A passive load could stop the rotor within a period, even if the bus drove the current against it all the time.
static bool may_stop(const plant_inverter_t *inverter, const plant_motor_t *motor) {
    const plant_motor_state_t *x = &motor->x;
    if (!motor->load_is_passive || motor->speed_is_prescribed) {
        return false;
    }
    const double psi_d = motor->psi_Wb + motor->Ld_H * x->id_A, psi_q = motor->Lq_H * x->iq_A;
    const double i_A = fabs(x->id_A) + fabs(x->iq_A) +
                       inverter->v_bus_V * inverter->period_s * (motor->inv_Ld + motor->inv_Lq);
    const double torque_Nm = motor->power * motor->np * (fabs(psi_d) + fabs(psi_q)) * i_A;
    return fabs(x->omega_m_rad_s) <
           inverter->period_s * motor->inv_J * (torque_Nm + fabs(motor->load_Nm));
}

bool plant_linear_can_run(const plant_inverter_t *inverter, const plant_motor_t *motor) {
    const plant_leg_t *leg = inverter->leg;
    return motor->is_plain && !motor->has_load && !inverter->averaging[0] &&
           inverter->drive.floating[0] == PLANT_NONE_FLOATS && !leg[0].opening && !leg[1].opening &&
           !leg[2].opening && !may_stop(inverter, motor);
}

/// A leg that turns off a gate next keeps its terminal level if its current then has this sign. If linear
/// extrapolation makes that certain, the edge is skipped.
HOT bool pass_over(run_t *run, int n, double limit_s) {
    plant_leg_t *leg = &run->inverter->leg[n];
    plant_pwm_t *pwm = &leg->pwm;
    way_t *way = &run->leg[n];
    const int k = pwm->next;
    if (!(way->next_s < limit_s) || pwm->gate == PLANT_GATE_OFF || k + 1 >= pwm->edges ||
        pwm->edge[k].gate != PLANT_GATE_OFF || pwm->edge[k + 1].gate == PLANT_GATE_OFF) {
        return false;
    }
    const pair_t along = way->axis * run->half_slope;
    const double change_A = 2.0 * (way->next_s - run->at.t_s) * (along[0] + along[1]);
    const double i_A = way->i_A + change_A;
    const int sign = pwm->gate == PLANT_GATE_LOW ? 1 : -1;
    if (!(sign * i_A > 0.1 * fabs(change_A))) {
        return false;
    }
    run->passed_sign = leg->sign;
    leg->sign = sign;
    run->passed_gate = pwm->gate;
    pwm->gate = PLANT_GATE_OFF;
    pwm->next = k + 1;
    way->guard = sign;
    way->next_s = pwm->edge[k + 1].at_s;
    return true;
}

/// Another current does not reach zero by then.
static void step_back(run_t *run, int n) {
    plant_leg_t *leg = &run->inverter->leg[n];
    leg->sign = run->passed_sign;
    leg->pwm.gate = run->passed_gate;
    leg->pwm.next--;
    run->leg[n].guard = 0.0;
    run->leg[n].next_s = leg->pwm.edge[leg->pwm.next].at_s;
}

HOT int soonest_of(const way_t leg[PLANT_PHASES]) {
    const int n = leg[1].next_s < leg[0].next_s ? 1 : 0;
    return leg[2].next_s < leg[n].next_s ? 2 : n;
}

/// A current would lose its sign within h. False if the run ends here, as in reverse().
HOT bool meet_zero(run_t *run, int passed, const double i_A[PLANT_PHASES], double h,
                   int *events_left, int *stopped) {
    if (passed != PLANT_NONE_FLOATS) {
        step_back(run, passed);
        run->may_pass = false;
        return true;
    }
    *events_left -= 1;
    return *events_left > 0 && reverse(run, i_A, h, stopped);
}

/// Runs up to until_s; returns the leg whose current stopped, or PLANT_NONE_FLOATS.
HOT int go(run_t *run, double until_s, int *events_left, bool drops) {
    int stopped = PLANT_NONE_FLOATS;
    run->may_pass = !drops;
    while (run->at.t_s < until_s) {
        const double limit_s = smaller(until_s, run->at.t_s + run->longest_s);
        int n = soonest_of(run->leg), passed = PLANT_NONE_FLOATS;
        if (run->may_pass && pass_over(run, n, limit_s)) {
            passed = n;
            n = soonest_of(run->leg);
        }
        const double end_s = smaller(run->leg[n].next_s, limit_s);
        const double h = end_s - run->at.t_s;
        double i_A[PLANT_PHASES];
        point_t to = advance(run, h);
        to.t_s = end_s;
        phase_currents(run, &to, i_A);
        if (keeps_signs(run, i_A)) {
            accept(run, &to, i_A, h);
            run->may_pass = !drops;
        } else if (meet_zero(run, passed, i_A, h, events_left, &stopped)) {
            n = soonest_of(run->leg);
        } else {
            break;
        }
        if (run->at.t_s >= run->leg[n].next_s) {
            take_edge(run, n, drops);
        }
    }
    return stopped;
}

/// One copy of the code for each kind of inverter.
static int go_with_drops(run_t *run, double until_s, int *events_left) {
    return go(run, until_s, events_left, true);
}

static int go_without_drops(run_t *run, double until_s, int *events_left) {
    return go(run, until_s, events_left, false);
}

double plant_linear_run(plant_inverter_t *inverter, plant_motor_t *motor, double now_s,
                        double until_s, int *events_left) {
    run_t run;
    const double w = motor->np * motor->x.omega_m_rad_s;
    const double turn2 = w * w * (1.0 / (longest_turn * longest_turn));
    const double swing2 = swing_rate2(motor) * (1.0 / (longest_swing * longest_swing));
    const double rate2 = turn2 > swing2 ? turn2 : swing2, T_s = until_s - now_s;
    const double end_s = rate2 * T_s * T_s > 1.0 ? now_s + T_s / ceil(T_s * sqrt(rate2)) : until_s;
    start(&run, inverter, motor, now_s, end_s);
    const int stopped = inverter->has_drops ? go_with_drops(&run, end_s, events_left)
                                            : go_without_drops(&run, end_s, events_left);
    finish(&run, motor, now_s);
    for (int n = 0; n < PLANT_PHASES; n++) {
        follow_sign(&run, n);
    }
    if (stopped != PLANT_NONE_FLOATS) {
        plant_inverter_take_event(inverter, motor, &(plant_event_t){.leg = stopped, .sign = 0});
    }
    if (run.at.t_s < inverter->period_s) { // the next period begins with this edge
        plant_inverter_settle(inverter, motor, run.at.t_s);
    }
    return run.at.t_s;
}
