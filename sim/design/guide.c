#include "design/guide.h"

#include <math.h>
#include <stdlib.h>

#include "support/units.h"

// The disturbances of the guideline, unless the configuration gives them.
#define LOAD_SHARE 0.5 // of the torque at i_max: about rated torque
#define DAMPING_MIN 0.45
#define SIGMAS_OF_STEP 16.0 // time constants 1/sigma until a step's peak has passed
#define NOISE_SIGMAS 3.0
#define CANDIDATE_RATIO 1.02
#define FLAT 1.1 // the sum's minimum is flat: the smallest k2 within this factor of it is as good
// F_PWM_MAX_Hz in steps of CANDIDATE_RATIO: less than this many
enum { BISECTIONS = 50, CANDIDATES_MAX = 640 };

typedef struct {
    const guide_t *guide;
    const lode_drive_config_t *drive;
    const lode_estimator_tuning_t *tuning;
} task_t;

static bool unstable(const lode_estimator_tuning_t *tuning, const lode_emf_config_t *emf,
                     double omega_rad_s, double k2_rad_s) {
    const lode_estimator_tuning_t t = joint_with_k2(tuning, emf, k2_rad_s);
    const joint_t joint = joint_make(&t, omega_rad_s);
    return !(joint_radius(&joint) < 1.0);
}

double guide_k2_limit(const lode_estimator_tuning_t *tuning, const lode_emf_config_t *emf,
                      double omega_rad_s, double sigma_rad_s) {
    const lode_estimator_tuning_t t = joint_with_sigma(tuning, sigma_rad_s);
    double low = fmax(1.0, 0.01 * sigma_rad_s); // what lode_observer_tune() accepts
    double high = fmin(3.0 * sigma_rad_s, 1.0 / (double)tuning->pll.ts_s);
    if (!unstable(&t, emf, omega_rad_s, low)) {
        return 0.0;
    }
    for (int k = 0; k < BISECTIONS; ++k) {
        const double middle = 0.5 * (low + high);
        *(unstable(&t, emf, omega_rad_s, middle) ? &low : &high) = middle;
    }
    return high / sigma_rad_s;
}

// ---- Effects of one k2 -----------------------------------------------------------------------------

/// Largest angle error after an acceleration of 1 rad/s^2 sets in, rad.
static double step_peak(const joint_t *joint) {
    double x[2][JOINT_STATES_MAX] = {{0.0}};
    const joint_input_t input = {1.0, 0.0};
    const int count = (int)(SIGMAS_OF_STEP / (joint->sigma_rad_s * joint->ts_s));
    double peak = 0.0;
    for (int k = 0; k < count; ++k) {
        joint_step(joint, &input, x[k % 2], x[1 - k % 2]);
        peak = fmax(peak, fabs(x[1 - k % 2][joint->pll]));
    }
    return peak;
}

/// Angle error by harmonics of amplitude 1: a vector that turns at +-6 w in the rotor's frame.
static double ripple_of(const joint_t *joint, double omega_rad_s, double fifth, double seventh) {
    const double complex z = cexp(6.0 * I * fabs(omega_rad_s) * joint->ts_s);
    // exp(j x): along it cos x, ahead of it sin x = Re(-j exp(j x)); exp(-j x) the other way.
    return seventh * cabs(joint_angle_response(joint, z, 1.0, -I)) +
           fifth * cabs(joint_angle_response(joint, z, 1.0, I));
}

/// rms of the angle for white noise of variance 1 in both components of nu, m = nu[k] - decay nu[k-1].
static double noise_of(const joint_t *joint, double omega_rad_s, double decay) {
    const double complex back = -decay * cexp(-I * omega_rad_s * joint->ts_s);
    const int count = (int)(SIGMAS_OF_STEP / (joint->sigma_rad_s * joint->ts_s));
    double sum = 0.0;
    for (int part = 0; part < 2; ++part) {
        const double complex pulse = part == 0 ? 1.0 : I;
        double x[2][JOINT_STATES_MAX] = {{0.0}};
        for (int k = 0; k < count; ++k) {
            const joint_input_t input = {0.0, k == 0 ? pulse : k == 1 ? pulse * back : 0.0};
            joint_step(joint, &input, x[k % 2], x[1 - k % 2]);
            sum += x[1 - k % 2][joint->pll] * x[1 - k % 2][joint->pll];
        }
    }
    return sqrt(sum);
}

/// Volts of m per ampere of error of a sample, relative to the length of m.
static double noise_scale(const task_t *task, double omega_rad_s) {
    const double ts = 1.0 / (double)task->drive->f_pwm_Hz;
    const double emf = omega_rad_s * (double)task->drive->motor.psi_Wb;
    const double gamma = cabs(observer_circuit(&task->drive->motor, ts, omega_rad_s));
    // Equal noise in three phases gives sqrt(2/3) of it in alpha and in beta.
    return sqrt(2.0 / 3.0) * (double)task->tuning->emf.inv_b / (emf * gamma);
}

static double gain_of(const observer_t *o, double ts, double omega_rad_s, double order) {
    return cabs(observer_response(o, cexp(I * order * omega_rad_s * ts)) /
                observer_response(o, cexp(I * omega_rad_s * ts)));
}

static void note_gains(guide_row_t *row, const guide_t *guide,
                       const lode_estimator_tuning_t *tuning) {
    const double ts = (double)tuning->pll.ts_s;
    const observer_t low = observer_make(&tuning->emf.observer, ts, guide->low_rad_s);
    const observer_t high = observer_make(&tuning->emf.observer, ts, guide->high_rad_s);
    row->fifth_low = gain_of(&low, ts, guide->low_rad_s, -5.0);
    row->seventh_low = gain_of(&low, ts, guide->low_rad_s, 7.0);
    row->offset = gain_of(&low, ts, guide->low_rad_s, 0.0);
    row->negative = gain_of(&low, ts, guide->low_rad_s, -1.0);
    row->fifth_high = gain_of(&high, ts, guide->high_rad_s, -5.0);
    row->seventh_high = gain_of(&high, ts, guide->high_rad_s, 7.0);
}

static void note_speed(guide_row_t *row, const task_t *task, const joint_t *joint,
                       double omega_rad_s) {
    const guide_t *guide = task->guide;
    const double decay = (double)task->tuning->emf.a_over_b / (double)task->tuning->emf.inv_b;
    const double step = rig_deg_from_rad(step_peak(joint) * guide->acceleration_rad_s2);
    const double ripple =
        rig_deg_from_rad(ripple_of(joint, omega_rad_s, guide->fifth, guide->seventh));
    const double noise = rig_deg_from_rad(guide->noise_A * noise_scale(task, omega_rad_s) *
                                          noise_of(joint, omega_rad_s, decay));
    row->radius = fmax(row->radius, joint_radius(joint));
    row->step_deg = fmax(row->step_deg, step);
    row->ripple_deg = fmax(row->ripple_deg, ripple);
    row->noise_deg = fmax(row->noise_deg, noise);
    row->total_deg = fmax(row->total_deg, step + ripple + NOISE_SIGMAS * noise);
}

/// The common poles of observer and PLL, without notches and further modes, because the damping of these is
/// only their width.
static void note_poles(guide_row_t *row, const lode_estimator_tuning_t *tuning,
                       double omega_rad_s) {
    double complex poles[JOINT_STATES_MAX];
    const joint_t joint = joint_make(tuning, omega_rad_s);
    const int count = joint_poles(&joint, poles);
    for (int k = 0; k < count; ++k) {
        row->damping = fmin(row->damping, joint_damping(poles[k]));
        row->slowest_rad_s = fmin(row->slowest_rad_s, -creal(poles[k]));
    }
}

static lode_estimator_tuning_t with_k2(const task_t *task, const lode_emf_config_t *emf,
                                       double k2_rad_s) {
    return joint_with_k2(task->tuning, emf, k2_rad_s);
}

static guide_row_t evaluate(const task_t *task, double k2_rad_s) {
    const guide_t *guide = task->guide;
    const lode_estimator_tuning_t t = with_k2(task, &task->drive->estimator.emf, k2_rad_s);
    lode_emf_config_t first_order = task->drive->estimator.emf;
    first_order.kind = LODE_EMF_FA_LESO;
    first_order.k1_rad2_s2 = 0.0f;
    lode_estimator_tuning_t plain = with_k2(task, &first_order, k2_rad_s);
    plain.notch.k = 0.0f;
    plain.notch12_k = 0.0f;
    guide_row_t row = {.k2_rad_s = k2_rad_s,
                       .per_sigma = k2_rad_s / guide->sigma_rad_s,
                       .damping = 1.0,
                       .slowest_rad_s = HUGE_VAL};
    for (int k = 0; k < GUIDE_SPEEDS; ++k) {
        const double share = (double)k / (GUIDE_SPEEDS - 1);
        const double omega = guide->low_rad_s * pow(guide->high_rad_s / guide->low_rad_s, share);
        const joint_t joint = joint_make(&t, omega);
        note_speed(&row, task, &joint, omega);
        note_poles(&row, &plain, omega);
    }
    note_gains(&row, guide, &t);
    return row;
}

bool guide_fits(const guide_row_t *row) {
    return row->radius < 1.0 && row->damping >= DAMPING_MIN;
}

// ---- The table ------------------------------------------------------------------------------------

/// The smallest stable and well damped k2 whose sum of errors is near the minimum.
static double recommend(const task_t *task, double most_rad_s) {
    double k2[CANDIDATES_MAX];
    double total_deg[CANDIDATES_MAX]; // infinite where it does not fit
    double least = HUGE_VAL;
    int count = 0;
    for (double next = fmax(1.0, task->guide->sigma_rad_s);
         next <= most_rad_s && count < CANDIDATES_MAX; next *= CANDIDATE_RATIO) {
        const guide_row_t row = evaluate(task, next);
        k2[count] = next;
        total_deg[count] = guide_fits(&row) ? row.total_deg : HUGE_VAL;
        least = fmin(least, total_deg[count++]);
    }
    for (int k = 0; k < count; ++k) {
        if (total_deg[k] < HUGE_VAL && total_deg[k] <= FLAT * least) {
            return k2[k];
        }
    }
    return NAN;
}

static int by_k2(const void *a, const void *b) {
    const double difference =
        ((const guide_row_t *)a)->k2_rad_s - ((const guide_row_t *)b)->k2_rad_s;
    return difference < 0.0 ? -1 : difference > 0.0 ? 1 : 0;
}

static void fill_rows(guide_t *guide, const task_t *task, double most_rad_s) {
    static const double ratios[] = {0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0, 40.0};
    guide->rows = 0;
    guide->row[guide->rows++] = evaluate(task, guide->used_rad_s);
    if (!isnan(guide->recommended_rad_s)) {
        guide->row[guide->rows++] = evaluate(task, guide->recommended_rad_s);
    }
    for (size_t k = 0; k < sizeof ratios / sizeof ratios[0]; ++k) {
        const double k2 = ratios[k] * guide->sigma_rad_s;
        const bool same = fabs(k2 - guide->used_rad_s) < 0.01 * k2 ||
                          fabs(k2 - guide->recommended_rad_s) < 0.01 * k2;
        if (k2 >= 1.0 && k2 <= most_rad_s && !same) {
            guide->row[guide->rows++] = evaluate(task, k2);
        }
    }
    qsort(guide->row, (size_t)guide->rows, sizeof guide->row[0], by_k2);
}

/// The disturbances, and the range of speeds.
static void set_task(guide_t *guide, const rig_config_t *config) {
    const lode_drive_config_t *drive = &config->drive;
    const rig_plant_t *plant = &config->plant;
    const lode_motor_t *motor = &drive->motor;
    guide->low_rad_s =
        fmin((double)drive->estimator.pll.omega_high_rad_s, (double)motor->omega_rated_rad_s);
    guide->high_rad_s = (double)motor->omega_rated_rad_s;
    guide->sigma_rad_s = (double)drive->estimator.pll.sigma_rad_s;
    guide->load_Nm =
        LOAD_SHARE * (double)lode_motor_kt_Nm_A(motor) * (double)drive->inverter.i_max_A;
    guide->acceleration_rad_s2 = guide->load_Nm * (double)motor->pole_pairs / (double)motor->J_kgm2;
    guide->fifth = plant->emf5_ratio;
    guide->seventh = plant->emf7_ratio;
    guide->noise_A = plant->i_noise_A;
}

void guide_compute(guide_t *guide, const rig_config_t *config) {
    lode_drive_config_t drive = config->drive;
    lode_estimator_config_t *estimator = &drive.estimator;
    const float ts = 1.0f / drive.f_pwm_Hz;
    *guide = (guide_t){.adaptive = estimator->emf.kind == LODE_EMF_FA_LESO ||
                                   estimator->emf.kind == LODE_EMF_FA_MULTI};
    if (!guide->adaptive) {
        estimator->emf.kind = LODE_EMF_FA_LESO;
        estimator->emf.k1_rad2_s2 = 0.0f;
    }
    lode_estimator_tuning_t tuning;
    if (lode_estimator_tune(&tuning, estimator, &drive.motor, ts) != LODE_OK) {
        return; // no FA-LESO is configured
    }
    set_task(guide, config);
    const task_t task = {guide, &drive, &tuning};
    const double most = 1.0 / (double)ts;
    guide->limit_theory = estimator->pll.kind == LODE_PLL_LESO ? 0.75 * (sqrt(3.0) - 1.0) : 0.0;
    guide->limit_sampled =
        guide_k2_limit(&tuning, &estimator->emf, guide->high_rad_s, guide->sigma_rad_s);
    guide->used_rad_s = (double)estimator->emf.k2_rad_s;
    guide->recommended_rad_s = recommend(&task, most);
    fill_rows(guide, &task, most);
}
