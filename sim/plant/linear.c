#include "plant/linear.h"

#include <math.h>

#if defined(__GNUC__)
#define HOT static inline __attribute__((always_inline))
#else
#define HOT static inline
#endif

/// The rotor turns no further in one run, rad: half of it each way is what the short series are made for.
static const double longest_turn = 0.3;
/// The torque may change the acceleration no more in one run than by this share of a swing, rad: the loop takes it
/// for constant.
static const double longest_swing = 0.025;
/// Of the fastest motion between two points, rad.
static const double longest_piece = 0.1;
/// A current that reverses is found to this, A: half of what counts as zero.
static const double zero_A = 1e-5;

/// One instant. Vectors in the coordinates of the run: the rotor's when half of it is over.
typedef struct {
    double t_s;
    plant_vector_t
        psi_u; ///< flux linkage without the resistance: at the start, and all volt-seconds since
    plant_vector_t i, i_As;
    double d, q;   ///< the current as the rotor sees it
    double torque; ///< psi x i
} point_t;

/// A leg on its way.
typedef struct {
    plant_vector_t axis;
    double next_s; ///< its next edge
    double
        guard; ///< sign that its current must not lose without notice; 0 where that changes nothing
    double i_A;
} way_t;

typedef struct {
    plant_inverter_t *inverter;
    // Constant in a run.
    double R, inv_Ld, inv_Lq, psi_m;
    double middle_s, w, half_a; ///< the angle from the middle: w t + half_a t^2
    double longest_s, slope_A_s;
    plant_vector_t drift_A_s; ///< slope of the current without voltage
    point_t at;
    plant_vector_t u, half_slope, psi_start;
    way_t leg[PLANT_PHASES];
    bool may_pass;   ///< pass_over has not just been in vain
    int passed_sign; ///< of a leg before it
    plant_gate_t passed_gate;
    // Sums of h^3, of that times u, of h^2 times the change of the current, of the torque over time and over that
    // to the middle.
    double h3, torque_s, torque_s2, h_dd_dq;
    plant_vector_t h3_u, h2_di;
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

/// The same for good, below 1e-13.
static void turned(double angle, double *c, double *s) {
    const double x2 = angle * angle;
    *c = 1.0 - x2 * (0.5 - x2 * (1.0 / 24 - x2 * (1.0 / 720 - x2 * (1.0 / 40320))));
    *s = angle * (1.0 - x2 * (1.0 / 6 - x2 * (1.0 / 120 - x2 * (1.0 / 5040))));
}

/// The next point, h further.
HOT point_t advance(const run_t *run, double h) {
    const point_t *from = &run->at;
    point_t to;
    double c, s;
    to.t_s = from->t_s + h;
    const double t = to.t_s - run->middle_s;
    turned_little(t * (run->w + t * run->half_a), &c, &s);
    to.psi_u.alpha = from->psi_u.alpha + h * run->u.alpha;
    to.psi_u.beta = from->psi_u.beta + h * run->u.beta;
    // The drop by an estimate of the current on the way, so that nothing has to wait for its end.
    const double a_As = from->i_As.alpha + h * (from->i.alpha + h * run->half_slope.alpha);
    const double b_As = from->i_As.beta + h * (from->i.beta + h * run->half_slope.beta);
    const double a = to.psi_u.alpha - run->R * a_As, b = to.psi_u.beta - run->R * b_As;
    to.d = (a * c + b * s - run->psi_m) * run->inv_Ld;
    to.q = (b * c - a * s) * run->inv_Lq;
    to.i.alpha = to.d * c - to.q * s;
    to.i.beta = to.d * s + to.q * c;
    to.i_As.alpha = from->i_As.alpha + 0.5 * h * (from->i.alpha + to.i.alpha);
    to.i_As.beta = from->i_As.beta + 0.5 * h * (from->i.beta + to.i.beta);
    to.torque = a * to.i.beta - b * to.i.alpha;
    return to;
}

HOT void phase_currents(const run_t *run, const point_t *at, double i_A[PLANT_PHASES]) {
    i_A[0] = run->leg[0].axis.alpha * at->i.alpha + run->leg[0].axis.beta * at->i.beta;
    i_A[1] = run->leg[1].axis.alpha * at->i.alpha + run->leg[1].axis.beta * at->i.beta;
    i_A[2] = -i_A[0] - i_A[1];
}

HOT bool keeps_signs(const run_t *run, const double i_A[PLANT_PHASES]) {
    const way_t *leg = run->leg;
    const double least =
        smaller(leg[0].guard * i_A[0], smaller(leg[1].guard * i_A[1], leg[2].guard * i_A[2]));
    return least >= -PLANT_NOISE_A;
}

/// Goes to a point that has been found good.
HOT void accept(run_t *run, const point_t *to, const double i_A[PLANT_PHASES], double h) {
    const point_t *from = &run->at;
    const double h2 = h * h, h3 = h2 * h, torque_s = 0.5 * h * (from->torque + to->torque);
    run->h3 += h3;
    run->h3_u.alpha += h3 * run->u.alpha;
    run->h3_u.beta += h3 * run->u.beta;
    run->h2_di.alpha += h2 * (to->i.alpha - from->i.alpha);
    run->h2_di.beta += h2 * (to->i.beta - from->i.beta);
    run->h_dd_dq += h * (to->d - from->d) * (to->q - from->q);
    run->torque_s += torque_s;
    run->torque_s2 += torque_s * (to->t_s - 0.5 * h - run->middle_s);
    run->at = *to;
    run->leg[0].i_A = i_A[0];
    run->leg[1].i_A = i_A[1];
    run->leg[2].i_A = i_A[2];
}

HOT void set_slope(run_t *run) {
    run->half_slope.alpha = 0.5 * (run->u.alpha * run->inv_Ld + run->drift_A_s.alpha);
    run->half_slope.beta = 0.5 * (run->u.beta * run->inv_Lq + run->drift_A_s.beta);
}

/// What the leg's terminal does next. With drops a current is guarded all the time, and only edges that move the
/// terminal count; without, only while both gates are off, and unless it is too large to pass zero until the other
/// turns on.
HOT void find_next(run_t *run, int n, bool drops) {
    plant_leg_t *leg = &run->inverter->leg[n];
    plant_pwm_t *pwm = &leg->pwm;
    way_t *way = &run->leg[n];
    int k = pwm->next;
    if (drops) {
        const bool high = plant_inverter_on_high_rail(pwm->gate, leg->sign);
        while (k < pwm->edges &&
               plant_inverter_on_high_rail(pwm->edge[k].gate, leg->sign) == high) {
            k++;
        }
    } else if (pwm->gate == PLANT_GATE_OFF && k < pwm->edges &&
               plant_inverter_on_high_rail(pwm->edge[k].gate, leg->sign) == (leg->sign < 0) &&
               fabs(way->i_A) > run->slope_A_s * (pwm->edge[k].at_s - run->at.t_s)) {
        pwm->gate = pwm->edge[k++].gate;
        pwm->next = k;
    }
    way->guard = drops || pwm->gate == PLANT_GATE_OFF ? leg->sign : 0.0;
    way->next_s = k < pwm->edges ? pwm->edge[k].at_s : HUGE_VAL;
}

/// The leg's terminal as gate and sign have it now.
HOT void move_terminal(run_t *run, int n) {
    plant_leg_t *leg = &run->inverter->leg[n];
    const plant_vector_t *axis = &run->leg[n].axis;
    const double source_V = plant_inverter_source_V(run->inverter, leg->pwm.gate, leg->sign);
    const double step_V = (2.0 / 3.0) * (source_V - leg->source_V);
    leg->source_V = source_V;
    run->u.alpha += step_V * axis->alpha;
    run->u.beta += step_V * axis->beta;
    set_slope(run);
}

/// The current may have passed through zero where that changes nothing.
HOT void follow_sign(run_t *run, int n) {
    plant_leg_t *leg = &run->inverter->leg[n];
    if (leg->sign * run->leg[n].i_A < -PLANT_NOISE_A) {
        leg->sign = -leg->sign;
    }
}

/// The leg's next edge is now.
HOT void take_edge(run_t *run, int n, bool drops) {
    if (!drops) {
        follow_sign(run, n);
    }
    (void)plant_pwm_apply(&run->inverter->leg[n].pwm, run->at.t_s);
    move_terminal(run, n);
    find_next(run, n, drops);
}

/// Rate of a leg's current now, A/s: (M1), (M2).
static double slope_of(const run_t *run, int n) {
    const point_t *at = &run->at;
    const double t = at->t_s - run->middle_s, w = run->w + 2.0 * run->half_a * t;
    double c, s;
    turned_little(t * (run->w + t * run->half_a), &c, &s);
    const double ua = run->u.alpha - run->R * at->i.alpha, ub = run->u.beta - run->R * at->i.beta;
    const double d =
        (ua * c + ub * s) * run->inv_Ld + w * at->q * (run->inv_Ld / run->inv_Lq - 1.0);
    const double q = (ub * c - ua * s) * run->inv_Lq +
                     w * at->d * (1.0 - run->inv_Lq / run->inv_Ld) - w * run->psi_m * run->inv_Lq;
    const plant_vector_t *axis = &run->leg[n].axis;
    return axis->alpha * (d * c - q * s) + axis->beta * (d * s + q * c);
}

/// The leg whose current is first through zero on the way to i_A, by straight lines.
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

/// Goes to where the leg's current is zero, within h. False if that is not found soon, or another leg is
/// earlier. A current that starts at zero has its other zero, the one to find, further on than a straight line
/// tells.
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

/// A current that passes zero while a gate is on reverses, unless the drops hold it. False where the run has to end:
/// the current of leg `stopped` is zero and stays so for now, or, if that is PLANT_NONE_FLOATS, the search failed.
static bool reverse(run_t *run, const double i_A[PLANT_PHASES], double h, int *stopped) {
    const int n = first_through_zero(run, i_A);
    plant_leg_t *leg = &run->inverter->leg[n];
    if (!go_to_zero(run, n, i_A[n], h)) {
        return false;
    }
    (void)plant_pwm_apply(&leg->pwm, run->at.t_s);
    const int sign = leg->sign;
    if (leg->pwm.gate != PLANT_GATE_OFF) {
        leg->sign = -sign;
        move_terminal(run, n);
        find_next(run, n, true);
        if (slope_of(run, n) * leg->sign > 0.0) {
            return true;
        }
        leg->sign = sign;
    }
    *stopped = n;
    return false;
}

/// Coordinates, and the motor at the start in them.
static void place(run_t *run, const plant_motor_t *motor, double a, double T_s) {
    const plant_motor_state_t *x = &motor->x;
    const double w = motor->np * x->omega_m_rad_s;
    double c, s;
    turned(0.5 * T_s * (w + 0.25 * T_s * a), &c, &s);
    point_t *at = &run->at;
    const double psi_d = motor->psi_Wb + motor->Ld_H * x->id_A, psi_q = motor->Lq_H * x->iq_A;
    at->d = x->id_A;
    at->q = x->iq_A;
    at->i = (plant_vector_t){at->d * c + at->q * s, at->q * c - at->d * s};
    at->psi_u = (plant_vector_t){psi_d * c + psi_q * s, psi_q * c - psi_d * s};
    at->i_As = (plant_vector_t){0.0, 0.0};
    run->psi_start = at->psi_u;
    const double cos_theta = x->cos_theta * c - x->sin_theta * s;
    const double sin_theta = x->sin_theta * c + x->cos_theta * s;
    const plant_drive_t *u = &run->inverter->drive;
    run->u = (plant_vector_t){u->u_alpha_V * cos_theta + u->u_beta_V * sin_theta,
                              u->u_beta_V * cos_theta - u->u_alpha_V * sin_theta};
    for (int n = 0; n < PLANT_PHASES; n++) {
        const double ac = plant_axis_cos[n], as = plant_axis_sin[n];
        run->leg[n].axis =
            (plant_vector_t){ac * cos_theta + as * sin_theta, as * cos_theta - ac * sin_theta};
    }
}

/// Torque that acts against psi x i on the shaft, without friction, Nm; the speed is not zero where the load is passive.
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
    const double psi_d = motor->psi_Wb + motor->Ld_H * x->id_A, psi_q = motor->Lq_H * x->iq_A;
    run->inverter = inverter;
    run->R = inverter->drive.R_Ohm;
    run->inv_Ld = motor->inv_Ld;
    run->inv_Lq = motor->inv_Lq;
    run->psi_m = motor->psi_Wb;
    run->at.t_s = now_s;
    run->at.torque = psi_d * x->iq_A - psi_q * x->id_A;
    const double a =
        inv_J * (K * run->at.torque - load_of(motor) - motor->B_Nms * x->omega_m_rad_s);
    run->middle_s = now_s + 0.5 * T_s;
    run->half_a = 0.5 * a;
    run->w = w + 0.5 * a * T_s;
    place(run, motor, a, T_s);
    run->drift_A_s = (plant_vector_t){w * run->at.q * (motor->Lq_H * motor->inv_Ld - 1.0) -
                                          run->R * run->at.i.alpha * motor->inv_Ld,
                                      w * run->at.d * (1.0 - motor->Ld_H * motor->inv_Lq) -
                                          w * motor->psi_Wb * motor->inv_Lq -
                                          run->R * run->at.i.beta * motor->inv_Lq};
    set_slope(run);
    const double inv_L = motor->inv_Ld > motor->inv_Lq ? motor->inv_Ld : motor->inv_Lq;
    const double rate = smaller(-fabs(w), -run->R * inv_L);
    run->longest_s = -longest_piece / (rate - 1.0);
    // No current changes faster, whatever conducts.
    run->slope_A_s = inv_L * (inverter->v_bus_V + 2.0 * fabs(w) * (fabs(psi_d) + fabs(psi_q)) +
                              run->R * (fabs(x->id_A) + fabs(x->iq_A)));
    run->h3 = run->torque_s = run->torque_s2 = run->h_dd_dq = 0.0;
    run->h3_u = run->h2_di = (plant_vector_t){0.0, 0.0};
    double i_A[PLANT_PHASES];
    phase_currents(run, &run->at, i_A);
    for (int n = 0; n < PLANT_PHASES; n++) {
        run->leg[n].i_A = i_A[n];
        find_next(run, n, inverter->has_drops);
    }
}

/// What the trapezoid missed, by (M18), with the rotor as it is in the middle: takes it from the integrals of the
/// current and the torque.
static void correct(run_t *run, plant_vector_t psi) {
    const double w = run->w, inv_Ld = run->inv_Ld, inv_Lq = run->inv_Lq, h3 = run->h3;
    const double Ld = 1.0 / inv_Ld, Lq = 1.0 / inv_Lq;
    const double turn = 2.0 * w * (inv_Ld - inv_Lq);
    // What changes the flux linkage: voltage less drop.
    const double d = (psi.alpha - run->psi_m) * inv_Ld, q = psi.beta * inv_Lq;
    const double va = run->h3_u.alpha - run->R * h3 * d, vb = run->h3_u.beta - run->R * h3 * q;
    const double ra = run->R * run->h2_di.alpha, rb = run->R * run->h2_di.beta;
    const double a2 =
        turn * (vb - w * h3 * psi.alpha) + w * w * run->psi_m * inv_Ld * h3 - inv_Ld * ra;
    const double b2 = turn * (va + w * h3 * psi.beta) - inv_Lq * rb;
    const double d2 = (2.0 * w * vb - w * w * h3 * psi.alpha - ra) * inv_Ld;
    const double q2 = -(2.0 * w * va + w * w * h3 * psi.beta + rb) * inv_Lq;
    run->at.i_As.alpha -= a2 * (1.0 / 12);
    run->at.i_As.beta -= b2 * (1.0 / 12);
    run->torque_s -=
        ((run->psi_m + (Ld - Lq) * d) * q2 + (Ld - Lq) * (q * d2 + 2.0 * run->h_dd_dq)) *
        (1.0 / 12);
}

/// Brings the motor to where the run ended.
static void finish(run_t *run, plant_motor_t *motor, double start_s) {
    plant_motor_state_t *x = &motor->x;
    const double inv_J = electrical_inv_J(motor), K = motor->power * motor->np;
    const double T_s = run->at.t_s - start_s, w = motor->np * x->omega_m_rad_s;
    const plant_vector_t *psi_u = &run->at.psi_u;
    correct(run, (plant_vector_t){
                     0.5 * (run->psi_start.alpha + psi_u->alpha - run->R * run->at.i_As.alpha),
                     0.5 * (run->psi_start.beta + psi_u->beta - run->R * run->at.i_As.beta)});
    // Each torque turns the rotor from its own time to the end.
    const double steady = load_of(motor) + motor->B_Nms * x->omega_m_rad_s;
    const double dw = inv_J * (K * run->torque_s - steady * T_s);
    const double moment = run->torque_s * (run->at.t_s - run->middle_s) - run->torque_s2;
    const double turn = T_s * w + inv_J * (K * moment - 0.5 * steady * T_s * T_s);
    // Where the coordinates lie from the start, then how far the rotor is beyond.
    const double half_s = run->middle_s - start_s;
    const double beyond = turn - half_s * (run->w - run->half_a * half_s);
    double c, s;
    turned(beyond, &c, &s);
    const double a = psi_u->alpha - run->R * run->at.i_As.alpha;
    const double b = psi_u->beta - run->R * run->at.i_As.beta;
    x->id_A = (a * c + b * s - motor->psi_Wb) * motor->inv_Ld;
    x->iq_A = (b * c - a * s) * motor->inv_Lq;
    x->theta_e_rad += turn;
    x->omega_m_rad_s += dw / motor->np;
    turned(turn, &c, &s);
    const double cos_theta = x->cos_theta * c - x->sin_theta * s;
    x->sin_theta = x->sin_theta * c + x->cos_theta * s;
    x->cos_theta = cos_theta;
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

/// The leg that turns off a gate next keeps its terminal there if its current then has this sign, which is as certain
/// as a straight line can make it: passes over the edge.
HOT bool pass_over(run_t *run, int n, double limit_s) {
    plant_leg_t *leg = &run->inverter->leg[n];
    plant_pwm_t *pwm = &leg->pwm;
    way_t *way = &run->leg[n];
    const int k = pwm->next;
    if (!(way->next_s < limit_s) || pwm->gate == PLANT_GATE_OFF || k + 1 >= pwm->edges ||
        pwm->edge[k].gate != PLANT_GATE_OFF || pwm->edge[k + 1].gate == PLANT_GATE_OFF) {
        return false;
    }
    const double change_A =
        2.0 * (way->next_s - run->at.t_s) *
        (way->axis.alpha * run->half_slope.alpha + way->axis.beta * run->half_slope.beta);
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

/// Another current did not come that far.
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

/// A current would lose its sign within h. False where the run ends at this, as reverse() has it.
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

/// Up to until_s; returns the leg whose current stopped, or PLANT_NONE_FLOATS.
HOT int go(run_t *run, double until_s, int *events_left, bool drops) {
    int stopped = PLANT_NONE_FLOATS;
    bool goes_on = true;
    run->may_pass = !drops;
    while (goes_on) {
        const double limit_s = smaller(until_s, run->at.t_s + run->longest_s);
        int n = soonest_of(run->leg), passed = PLANT_NONE_FLOATS;
        if (run->may_pass && pass_over(run, n, limit_s)) {
            passed = n;
            n = soonest_of(run->leg);
        }
        const double edge_s = run->leg[n].next_s, end_s = smaller(edge_s, limit_s);
        const double h = end_s - run->at.t_s;
        double i_A[PLANT_PHASES];
        point_t to = advance(run, h);
        to.t_s = end_s;
        phase_currents(run, &to, i_A);
        if (!keeps_signs(run, i_A)) {
            goes_on = meet_zero(run, passed, i_A, h, events_left, &stopped);
            continue;
        }
        accept(run, &to, i_A, h);
        run->may_pass = !drops;
        if (end_s >= edge_s) {
            take_edge(run, n, drops);
        } else {
            goes_on = end_s < until_s;
        }
    }
    return stopped;
}

/// A copy for either kind of inverter.
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
    if (run.at.t_s < inverter->period_s) { // the next period begins with that
        plant_inverter_settle(inverter, motor, run.at.t_s);
    }
    return run.at.t_s;
}
