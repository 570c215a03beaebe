#include "adaptation_machine.h"
#include "estimator_inline.h"
#include "inverter_inline.h"
#include "lag_inline.h"
#include "speed_inline.h"

#include <stddef.h>

#define J_MIN 0.2f
#define J_MAX 5.0f
#define PSI_MAX 0.2f // beyond, only a fault explains the flux
#define RS_MAX 0.5f  // copper: 125 K
#define CONFIDENT 0.5f

// Both poles of the washout (O1). Slower than the PLL, whose speed lags an acceleration that it did not expect ...
#define WASHOUT_SIGMA 0.125f
// ... as quick as the run-up, against loads that change with speed ...
#define WASHOUT_RUN_UP 2.0f
// ... and slow enough for calls of some 500 Hz.
#define WASHOUT_MAX_rad_s 100.0f
// After a longer time between two calls the filters begin anew.
#define GAP_MAX_s 0.1f

// Weights of the correlations (O3), in edges of a ramp with all of the torque: the configured inertia weighs like a ramp with
// 7 % of the torque, the past like four ramps with half of it.
#define J_PRIOR 0.005f
#define J_MEMORY 1.0f
#define FORGET_MAX 0.5f // the past keeps at least half of its weight

// An edge lasts while the washed acceleration of the ramp is at least this share of that with all of the torque.
#define EDGE_MIN 0.02f
// Least square of the correlation of torque and acceleration: below it the load has moved during the edge.
#define COHERENCE_MIN 0.8f
// Largest difference of an edge from the mean. Beyond it two edges must agree, as a load step on one shows another inertia.
#define AGREE_MAX 0.3f
#define SPREAD_BEGIN 0.3f
#define SPREAD_WEIGHT 0.5f
#define SPREAD_DOUBT 2.0f

// Standard deviations of the configured values: magnets 10 %; a winding of unknown temperature 30 %, 20 % where the start has
// just measured it.
#define PSI_SIGMA 0.1f
#define RS_SIGMA 0.3f
#define RS_SIGMA_MEASURED 0.2f
// Standard deviations of the EMF's size (O5): a share of it, what an error of the inductances makes in a salient rotor, and a
// quarter of a microsecond of dead time.
#define EMF_SIGMA 0.02f
#define INDUCTANCE_SIGMA 0.1f
#define DEAD_TIME_SIGMA_s 0.25e-6f
#define DEAD_TIME_CURRENTS 2.0f // of i_dead: below, all of the dead time is uncertain
// Time for which an error stays the same from call to call ...
#define NOISE_s 5.0f
// ... and time in which a parameter may take any other value: magnets and winding by their heat.
#define PSI_MEMORY_s 60.0f
#define RS_MEMORY_s 20.0f
#define PSI_SPEED_MIN 0.2f // of rated

// Time between posted tunings, and the largest step of each: to the PLL a step of J is a load step of a tenth of the torque.
#define QUIET_s 0.05f
#define J_STEP 0.1f
#define PSI_STEP 0.01f
#define RS_STEP 0.05f
// Smaller changes are not worth a new tuning.
#define J_DEAD 0.03f
#define PSI_DEAD 0.005f
#define RS_DEAD 0.02f

static float square(float x) {
    return x * x;
}

// Mechanical acceleration with all of the torque.
static float acc_max_rad_s2(const lode_adaptation_machine_t *self) {
    return lode_references_most_Nm(&self->base->references) / self->motor.J_kgm2;
}

static float J_share(const lode_adaptation_machine_t *self) {
    return lode_clamp((J_PRIOR + self->ramp_torque) / (J_PRIOR + lode_max(self->ramp_acc, 0.0f)),
                      J_MIN, J_MAX);
}

static lode_adapted_t adapted(float value, float confidence) {
    return (lode_adapted_t){value, lode_max(confidence, 0.0f)};
}

static lode_adapted_t J_found(const lode_adaptation_machine_t *self) {
    const float seen = lode_max(self->ramp_acc, 0.0f);
    const float agreed = lode_max(1.0f - SPREAD_DOUBT * self->spread, 0.0f);
    return adapted(self->motor.J_kgm2 * J_share(self), agreed * seen / (J_PRIOR + seen));
}

static lode_adapted_t psi_found(const lode_adaptation_machine_t *self) {
    return adapted(self->motor.psi_Wb * (1.0f + self->psi_share),
                   1.0f - self->variance_psi / square(PSI_SIGMA));
}

static lode_adapted_t Rs_found(const lode_adaptation_machine_t *self) {
    return adapted(self->motor.Rs_Ohm * (1.0f + self->Rs_share),
                   1.0f - self->variance_Rs / square(RS_SIGMA));
}

lode_adaptation_found_t lode_adaptation_machine_found(const lode_adaptation_machine_t *self) {
    return (lode_adaptation_found_t){J_found(self), psi_found(self), Rs_found(self)};
}

void lode_adaptation_machine_telemetry(const lode_adaptation_machine_t *self,
                                       lode_telemetry_t *telemetry) {
    const lode_adaptation_found_t found = lode_adaptation_machine_found(self);
    telemetry->motor.J_kgm2 = found.J_kgm2;
    telemetry->motor.psi_Wb = found.psi_Wb;
    telemetry->motor.Rs_Ohm = found.Rs_Ohm;
}

// Confidence of a stored value: 0 where it is out of its bounds.
static float stored_confidence(lode_adapted_t stored, float configured, float least, float most) {
    const bool good = lode_in_range(stored.value, least * configured, most * configured) &&
                      lode_in_range(stored.confidence, 0.0f, 1.0f);
    return good ? stored.confidence : 0.0f;
}

static void recall(lode_adaptation_machine_t *self, const lode_adaptation_found_t *stored) {
    const lode_motor_t *motor = &self->motor;
    const float J = stored_confidence(stored->J_kgm2, motor->J_kgm2, J_MIN, J_MAX);
    if (self->adapts_J && J > 0.0f) {
        self->ramp_acc = lode_min(J_PRIOR * J / lode_max(1.0f - J, FLT_EPSILON), J_MEMORY);
        self->spread = 0.0f;
        self->ramp_torque =
            stored->J_kgm2.value / motor->J_kgm2 * (J_PRIOR + self->ramp_acc) - J_PRIOR;
    }
    const float psi =
        stored_confidence(stored->psi_Wb, motor->psi_Wb, 1.0f - PSI_MAX, 1.0f + PSI_MAX);
    if (self->adapts_psi && psi > 0.0f) {
        self->variance_psi *= 1.0f - psi;
        self->psi_share = stored->psi_Wb.value / motor->psi_Wb - 1.0f;
    }
    const float Rs = stored_confidence(stored->Rs_Ohm, motor->Rs_Ohm, 1.0f - RS_MAX, 1.0f + RS_MAX);
    if (self->adapts_Rs && Rs > 0.0f) {
        self->variance_Rs *= 1.0f - Rs;
        self->Rs_share = stored->Rs_Ohm.value / motor->Rs_Ohm - 1.0f;
    }
}

lode_status_t lode_adaptation_machine_init(lode_adaptation_machine_t *self,
                                           const lode_adaptation_config_t *config,
                                           const lode_drive_tuning_t *tuning,
                                           const lode_motor_t *motor,
                                           const lode_adaptation_found_t *stored) {
    const lode_status_t status = lode_motor_check(motor);
    if (status != LODE_OK) {
        return status;
    }
    if (!(motor->omega_rated_rad_s > 0.0f)) {
        return LODE_ERROR_MOTOR_OMEGA;
    }
    if (!(motor->Rs_Ohm > 0.0f)) {
        return LODE_ERROR_MOTOR_RS;
    }
    if (!lode_is_choice(config->J) || !lode_is_choice(config->psi) || !lode_is_choice(config->Rs)) {
        return LODE_ERROR_CHOICE;
    }
    *self = (lode_adaptation_machine_t){
        .base = tuning,
        .posted = tuning,
        .motor = *motor,
        .adapts_J = config->J != LODE_OFF,
        .adapts_psi = config->psi != LODE_OFF,
        .adapts_Rs = config->Rs != LODE_OFF,
        .variance_psi = square(PSI_SIGMA),
        .variance_Rs = square(RS_SIGMA),
        .spread = SPREAD_BEGIN,
        .J_used = 1.0f,
    };
    const float run_up_s =
        motor->omega_rated_rad_s / (motor->pole_pairs * lode_max(acc_max_rad_s2(self), FLT_MIN));
    const float sigma = tuning->estimator.pll.x_low * tuning->estimator.pll.inv_ts;
    self->lambda_rad_s =
        lode_min(lode_min(WASHOUT_RUN_UP / run_up_s, WASHOUT_SIGMA * sigma), WASHOUT_MAX_rad_s);
    if (stored != NULL) {
        recall(self, stored);
    }
    return LODE_OK;
}

// ---- Inertia ------------------------------------------------------------------------------------

typedef struct {
    float value;
    float rate; ///< of the value
} washed_t;

// (O1) by backward differences. Value and rate come from one filter, so that their ratio is exactly J.
static washed_t wash(lode_adaptation_filter_t *self, float x, float a, float dt_s) {
    self->one += a * (x - self->one);
    const float before = self->two;
    self->two += a * ((x - self->one) - self->two);
    return (washed_t){self->two, (self->two - before) / dt_s};
}

static float torque_of(const lode_adaptation_machine_t *self, const lode_telemetry_t *now) {
    const float psi_Wb = psi_found(self).value;
    const float salient_H = self->base->estimator.salient_H;
    return self->base->references.torque_factor * (psi_Wb + salient_H * now->i_A.d) * now->i_A.q;
}

// Relative difference of two inertias, at most 1.
static float difference(float J, float other) {
    return lode_min(lode_abs(J / lode_max(other, FLT_MIN) - 1.0f), 1.0f);
}

// (O3): an edge on which the load has moved is not used.
static bool is_useful(const lode_adaptation_edge_t *edge) {
    return edge->ramp_acc > J_PRIOR && edge->ramp_torque > 0.0f &&
           square(edge->torque_acc) >= COHERENCE_MIN * edge->torque2 * edge->acc2;
}

// (O3): an edge that agrees goes into the mean. Two in a row that do not, but agree with each other, show another inertia.
static void judge_edge(lode_adaptation_machine_t *self) {
    const lode_adaptation_edge_t edge = self->edge;
    self->edge = (lode_adaptation_edge_t){.energy = 0.0f};
    if (!is_useful(&edge)) {
        return;
    }
    const float J = edge.ramp_torque / edge.ramp_acc;
    const bool first = !(self->ramp_acc > 0.0f);
    float off = first ? self->spread : difference(J, J_share(self));
    float keep = 1.0f - lode_min(edge.energy / J_MEMORY, FORGET_MAX);
    bool taken = true;
    if (!first && off > AGREE_MAX) {
        const float again = difference(J, self->other);
        self->other = J;
        taken = again <= AGREE_MAX;
        if (taken) {
            keep = 0.0f;
            off = again;
        }
    }
    self->spread += SPREAD_WEIGHT * (off - self->spread);
    if (taken) {
        self->ramp_acc = keep * self->ramp_acc + edge.ramp_acc;
        self->ramp_torque = keep * self->ramp_torque + edge.ramp_torque;
        self->other = 0.0f;
    }
}

// (O2): correlates torque and acceleration with the ramp, which knows nothing of the load.
static void follow_inertia(lode_adaptation_machine_t *self, const lode_telemetry_t *now,
                           float dt_s) {
    const float torque_Nm = torque_of(self, now);
    // The mean over the interval of the speed's difference.
    const float mean_Nm = 0.5f * (torque_Nm + self->torque_Nm);
    self->torque_Nm = torque_Nm;
    const float x = self->lambda_rad_s * dt_s;
    const float a = x / (1.0f + x);
    const float per_acc = 1.0f / lode_max(acc_max_rad_s2(self), FLT_MIN);
    const float per_torque =
        1.0f / lode_max(lode_references_most_Nm(&self->base->references), FLT_MIN);
    const float torque = wash(&self->by_torque, mean_Nm, a, dt_s).value * per_torque;
    const float speed_rad_s = now->omega_rad_s / self->motor.pole_pairs;
    const float acc = wash(&self->by_speed, speed_rad_s, a, dt_s).rate * per_acc;
    const float z = wash(&self->by_ramp, now->speed_ref_rad_s, a, dt_s).rate * per_acc;
    lode_adaptation_edge_t *edge = &self->edge;
    if (lode_abs(z) >= EDGE_MIN) {
        const float weight = 4.0f * x;
        edge->energy += weight * z * z;
        edge->ramp_acc += weight * z * acc;
        edge->ramp_torque += weight * z * torque;
        edge->torque2 += weight * torque * torque;
        edge->acc2 += weight * acc * acc;
        edge->torque_acc += weight * torque * acc;
    }
    if (lode_abs(z) < EDGE_MIN || edge->energy > J_MEMORY) {
        judge_edge(self);
    }
}

// The filters begin at rest at the present values: what came before RUN is no ramp.
static void begin_inertia(lode_adaptation_machine_t *self, const lode_telemetry_t *now) {
    self->edge = (lode_adaptation_edge_t){.energy = 0.0f};
    self->torque_Nm = torque_of(self, now);
    self->by_torque = (lode_adaptation_filter_t){self->torque_Nm, 0.0f};
    self->by_speed = (lode_adaptation_filter_t){now->omega_rad_s / self->motor.pole_pairs, 0.0f};
    self->by_ramp = (lode_adaptation_filter_t){now->speed_ref_rad_s, 0.0f};
}

// ---- Flux and resistance --------------------------------------------------------------------------

// Resistance that the start has measured beyond the tuning's, over the configured one.
static float measured_share(const lode_adaptation_machine_t *self, const lode_drive_t *drive) {
#ifdef LODE_WITHOUT_START_MEASUREMENT
    (void)self;
    (void)drive;
    return 0.0f;
#else
    return drive->inverter.r_more_Ohm / self->motor.Rs_Ohm;
#endif
}

static bool is_measured(const lode_adaptation_machine_t *self, const lode_drive_t *drive) {
    return lode_abs(measured_share(self, drive)) > 0.0f;
}

// (O8): the observed EMF along q, in the direction of the speed. The PLL alone leaves nothing across, so that this is the
// EMF's size. While injection gives the angle something is left across, and near standstill the size has no sign.
static float emf_along(const lode_adaptation_machine_t *self, const lode_telemetry_t *now) {
    if (!(now->injected > 0.0f)) {
        return lode_ab_length(now->e_V);
    }
    const float lag_rad = lode_lag_rad(&self->base->estimator.lag, now->omega_rad_s);
    const float along_V = lode_park(now->e_V, lode_sincos(now->theta_rad - lag_rad)).q;
    return lode_sign(now->omega_rad_s) * along_V;
}

// (O4): the EMF's size less that expected with the configured resistance and flux, over the rated EMF.
static float emf_beyond(const lode_adaptation_machine_t *self, const lode_drive_t *drive,
                        const lode_telemetry_t *now, float ampere_share) {
    const lode_estimator_tuning_t *tuning = &self->base->estimator;
    const float omega = lode_abs(now->omega_rad_s);
    const float taken = lode_estimator_droop(tuning, omega);
    const float expected_V = omega * (tuning->psi_Wb + tuning->salient_H * now->i_A.d);
    const float rated_V = self->motor.omega_rated_rad_s * self->motor.psi_Wb;
    const float reckoned = self->Rs_used + measured_share(self, drive);
    return (emf_along(self, now) * taken - expected_V) / rated_V + reckoned * ampere_share;
}

// Standard deviation of the voltage along the current, V. Below the current at which the dead time has its full effect, its
// share is unknown.
static float dead_V(const lode_adaptation_machine_t *self, const lode_drive_t *drive,
                    const lode_telemetry_t *now) {
    const lode_dead_time_t *dead = &drive->inverter.dead_time;
    const float i2 = square(now->i_A.d) + square(now->i_A.q);
    const float all = i2 < square(DEAD_TIME_CURRENTS * dead->i_dead_A)
                          ? 2.0f * dead->slope_A * dead->i_dead_A
                          : 0.0f;
    const float some = DEAD_TIME_SIGMA_s * self->base->estimator.pll.inv_ts;
    return FOUR_PER_PI * now->v_bus_V * lode_max(some, all);
}

// Variance of the EMF's size over the rated EMF, at rated speed. An error of Lq turns the angle: iq counts as id.
static float flux_variance(const lode_adaptation_machine_t *self, lode_dq_t i_A) {
    const lode_motor_t *motor = &self->motor;
    const float per_Wb = 1.0f / motor->psi_Wb;
    const float turned = motor->Lq_H * i_A.q * per_Wb;
    const float salient = (motor->Ld_H - motor->Lq_H) * per_Wb;
    const float lost = INDUCTANCE_SIGMA * salient * (lode_abs(i_A.d) + lode_abs(turned * i_A.q));
    return square(EMF_SIGMA) + square(lost);
}

// Growth of a variance after a share of the time in which everything is forgotten.
static float grown(float variance, float sigma, float share) {
    return lode_min(variance + share * square(sigma), square(sigma));
}

// Below 0 only by rounding, where an observation leaves hardly any variance.
static float variance_after(float variance, float k, float v, float s) {
    return lode_max(variance + k * (k * s - 2.0f * v), 0.0f);
}

// (O5): a Kalman filter of two states. One that is not adapted, or a flux at low speed, keeps its value and its variance.
static void follow_emf(lode_adaptation_machine_t *self, const lode_drive_t *drive,
                       const lode_telemetry_t *now, float dt_s) {
    const lode_motor_t *motor = &self->motor;
    const float rated_V = motor->omega_rated_rad_s * motor->psi_Wb;
    const float h_psi = lode_abs(now->omega_rad_s) / motor->omega_rated_rad_s;
    const float h_Rs = lode_sign(now->omega_rad_s) * now->i_A.q * motor->Rs_Ohm / rated_V;
    const float off =
        emf_beyond(self, drive, now, h_Rs) - h_psi * self->psi_share - h_Rs * self->Rs_share;
    const float dead = dead_V(self, drive, now) / rated_V;
    const float noise =
        (square(h_psi) * flux_variance(self, now->i_A) + square(dead)) * NOISE_s / dt_s;
    self->variance_psi = grown(self->variance_psi, PSI_SIGMA, dt_s / PSI_MEMORY_s);
    self->variance_Rs = grown(self->variance_Rs, RS_SIGMA, dt_s / RS_MEMORY_s);
    const float v_psi = self->variance_psi * h_psi + self->covariance * h_Rs;
    const float v_Rs = self->covariance * h_psi + self->variance_Rs * h_Rs;
    const float s = lode_max(lode_max(v_psi * h_psi + v_Rs * h_Rs, 0.0f) + noise, FLT_MIN);
    const float k_psi = self->adapts_psi && h_psi >= PSI_SPEED_MIN ? v_psi / s : 0.0f;
    const float k_Rs = self->adapts_Rs ? v_Rs / s : 0.0f;
    self->psi_share = lode_clamp(self->psi_share + k_psi * off, -PSI_MAX, PSI_MAX);
    self->Rs_share = lode_clamp(self->Rs_share + k_Rs * off, -RS_MAX, RS_MAX);
    self->variance_psi = variance_after(self->variance_psi, k_psi, v_psi, s);
    self->variance_Rs = variance_after(self->variance_Rs, k_Rs, v_Rs, s);
    const float covariance = self->covariance + k_psi * k_Rs * s - k_psi * v_Rs - k_Rs * v_psi;
    const float most =
        lode_sqrt(self->variance_psi * self->variance_Rs); // beyond it only by rounding
    self->covariance = lode_clamp(covariance, -most, most);
}

// The resistance that the start has measured is the present one.
static void begin_emf(lode_adaptation_machine_t *self, const lode_drive_t *drive) {
    if (self->adapts_Rs && is_measured(self, drive)) {
        self->Rs_share = lode_clamp(self->Rs_used + measured_share(self, drive), -RS_MAX, RS_MAX);
        self->variance_Rs = square(RS_SIGMA_MEASURED);
        self->covariance = 0.0f;
    }
}

// ---- Use ------------------------------------------------------------------------------------------

// (O6): the next value in use, one step towards the one found, if that is sure.
static float next_of(float used, float wanted, lode_adapted_t found, float step) {
    return found.confidence >= CONFIDENT ? used + lode_clamp(wanted - used, -step, step) : used;
}

static bool is_worth(float used, float next, float dead) {
    return lode_abs(next - used) > dead;
}

// Step of the ramp for which `half` of the torque is enough with `J` times the inertia.
static float ramp_of_inertia(float step, float half, float J) {
    return lode_min(step, lode_max(step, half) / J);
}

// (O7): gains in proportion to J, but no more torque from the noise of the speed than a rotor as configured may have, and a
// ramp for which half of the torque is enough.
static void use_inertia(const lode_adaptation_machine_t *self, lode_drive_tuning_t *t) {
    const float J = self->J_used;
    const lode_motor_t *motor = &self->motor;
    const float kp = t->speed.pi.kp;
    const float most_Nm = lode_references_most_Nm(&t->references);
    const float most = LODE_SPEED_RUN_UP_MAX * most_Nm * motor->pole_pairs /
                       (motor->omega_rated_rad_s * (1.0f + t->speed.rise));
    t->speed.pi.kp = lode_min(kp * J, lode_max(kp, most));
    t->speed.pi.ki_Ts = t->speed.pi.ki_Ts * square(t->speed.pi.kp / kp) / J;
    t->speed.inertia_Nm *= J;
    const float period_s = t->estimator.pll.ts_s * (float)t->speed_periods;
    const float half = LODE_SPEED_RAMP_SHARE * most_Nm * period_s / motor->J_kgm2;
    t->speed.ramp_step = ramp_of_inertia(t->speed.ramp_step, half, J);
#ifndef LODE_WITHOUT_SHAPED_RAMP
    t->speed.ramp_down_step = ramp_of_inertia(t->speed.ramp_down_step, half, J);
#endif
    t->estimator.acc_per_torque /= J;
    t->estimator.acc_per_omega /= J;
    t->estimator.acc_most /= J;
    t->estimator.load_per_f_Nm *= J;
}

// Only the references use this flux: lock and FLUX are judged by the commissioned one.
static void use_flux(const lode_adaptation_machine_t *self, lode_drive_tuning_t *t) {
    const float share = self->psi_used;
    lode_references_tuning_t *references = &t->references;
    references->tau_max += lode_min(share, 0.0f) * references->psi_Wb * references->i_max_A;
    references->psi_Wb *= 1.0f + share;
    references->inv_psi2 /= square(1.0f + share);
}

void lode_adaptation_machine_use(const lode_adaptation_machine_t *self, lode_drive_tuning_t *t) {
    use_inertia(self, t);
    use_flux(self, t);
    // As lode_inverter_less_drop().
    t->estimator.emf.a_over_b -= self->Rs_used * self->motor.Rs_Ohm;
}

void lode_adaptation_machine_posts(lode_adaptation_machine_t *self,
                                   const lode_drive_tuning_t *tuning) {
    self->posted = tuning;
    self->quiet_s = 0.0f;
}

static bool is_due(lode_adaptation_machine_t *self, const lode_drive_t *drive) {
    const float J = next_of(self->J_used, J_share(self), J_found(self), J_STEP * self->J_used);
    const float psi = next_of(self->psi_used, self->psi_share, psi_found(self), PSI_STEP);
    const float Rs = next_of(self->Rs_used, self->Rs_share - measured_share(self, drive),
                             Rs_found(self), RS_STEP);
    const bool worth = is_worth(self->J_used, J, J_DEAD * self->J_used) ||
                       is_worth(self->psi_used, psi, PSI_DEAD) ||
                       is_worth(self->Rs_used, Rs, RS_DEAD);
    if (!worth || self->quiet_s < QUIET_s) {
        return false;
    }
    self->J_used = J;
    self->psi_used = psi;
    self->Rs_used = Rs;
    return true;
}

// The base, or the tuning posted last; with six phases not that of one set alone.
static bool is_own(const lode_adaptation_machine_t *self, const lode_drive_tuning_t *tuning) {
    return tuning == self->base || tuning == self->posted;
}

// In torque control the speed reference follows the speed itself, and is no ramp.
static bool follows_ramp(const lode_drive_t *drive) {
    return (drive->command.flags & (uint32_t)LODE_ORDER_TORQUE) == 0u;
}

bool lode_adaptation_machine_step(lode_adaptation_machine_t *self, const lode_drive_t *drive,
                                  bool taken) {
    lode_telemetry_t now;
    (void)lode_drive_telemetry(drive, &now);
    const uint32_t steps = now.steps - self->steps;
    const float dt_s = (float)steps * self->base->estimator.pll.ts_s;
    const bool usable = now.mode == LODE_MODE_RUN && is_own(self, drive->tuning);
    const bool goes_on = self->runs && usable && dt_s <= GAP_MAX_s;
    self->runs = usable;
    if (goes_on && (steps == 0u || !taken)) {
        return false; // nothing new, or the drive has not taken the posted tuning
    }
    self->steps = now.steps;
    if (!goes_on) {
        if (usable) {
            begin_inertia(self, &now);
            begin_emf(self, drive);
        }
        return false;
    }
    if (self->adapts_J && follows_ramp(drive)) {
        follow_inertia(self, &now, dt_s);
    } else {
        begin_inertia(self, &now);
    }
    follow_emf(self, drive, &now, dt_s);
    self->quiet_s = lode_min(self->quiet_s + dt_s, QUIET_s);
    return is_due(self, drive);
}

// ---- With three phases ------------------------------------------------------------------------------

lode_status_t lode_adaptation_init(lode_adaptation_t *self, const lode_adaptation_config_t *config,
                                   const lode_drive_tuning_t *tuning, const lode_motor_t *motor,
                                   const lode_adaptation_found_t *stored) {
    if (self == NULL || config == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    return lode_adaptation_machine_init(&self->machine, config, tuning, motor, stored);
}

// Copies the base, with all values in use, to the one of the two tunings that was not posted last.
static void post(lode_adaptation_t *self, lode_drive_t *drive) {
    lode_drive_tuning_t *next = &self->tuning[self->machine.posted == &self->tuning[0] ? 1 : 0];
    *next = *self->machine.base;
    lode_adaptation_machine_use(&self->machine, next);
    lode_adaptation_machine_posts(&self->machine, next);
    (void)lode_drive_post_tuning(drive, next);
}

bool lode_adaptation_step(lode_adaptation_t *self, lode_drive_t *drive) {
    const bool due =
        lode_adaptation_machine_step(&self->machine, drive, lode_drive_tuning_taken(drive));
    if (due) {
        post(self, drive);
    }
    return due;
}

bool lode_adaptation_post(lode_adaptation_t *self, lode_drive_t *drive,
                          const lode_drive_tuning_t *tuning) {
    if (!lode_drive_tuning_taken(drive)) {
        return false; // the drive may still run on the one that would be written
    }
    self->machine.base = tuning;
    post(self, drive);
    return true;
}

lode_adaptation_found_t lode_adaptation_found(const lode_adaptation_t *self) {
    return lode_adaptation_machine_found(&self->machine);
}

void lode_adaptation_telemetry(const lode_adaptation_t *self, lode_telemetry_t *telemetry) {
    lode_adaptation_machine_telemetry(&self->machine, telemetry);
}
