#include "analyse/own_loops.h"

#include <math.h>
#include <stdio.h>

#include "analyse/loop.h"
#include "analyse/margins.h"
#include "schedule.h"
#include "support/units.h"

enum { POINTS = 4000, OWN_SPEEDS = 3 };
// Shares of the rated speed: the hand-over, the speed of full sigma, and rated speed.
static const double shares[OWN_SPEEDS] = {0.1, 0.2, 1.0};
#define CURRENT_D "current, d axis"
#define CURRENT_Q "current, q axis"
#define PLL_WHOLE "PLL with observer"
#define SPEED_ALONE "speed, PI alone"
#define FIRST_SHARE 1.0e-4  // of the sampling frequency, where a sweep begins
#define LOWEST_SHARE 1.0e-9 // or lower, down to this, where the gain is below 1 there already

typedef struct {
    const lode_drive_config_t *drive;
    const lode_drive_tuning_t *tuning;
    double ts_s;
    double omega_rad_s;
} task_t;

/// The open loop of one kind, at `count` frequencies.
typedef void (*response_t)(const task_t *task, int count, const double *Omega_rad_s,
                           double complex *value);

// ---- Current --------------------------------------------------------------------------------------

static double complex current_at(const task_t *task, double Omega_rad_s, bool q_axis) {
    const lode_current_config_t *c = &task->drive->current;
    const lode_motor_t *motor = &task->drive->motor;
    const double ts = task->ts_s;
    const double R = (double)motor->Rs_Ohm + (double)task->drive->inverter.r_on_Ohm;
    const double L = (double)(q_axis ? motor->Lq_H : motor->Ld_H);
    const double kp = (double)(q_axis ? c->kp_q_V_A : c->kp_d_V_A);
    const double ki = (double)(q_axis ? c->ki_q_V_As : c->ki_d_V_As);
    const double a = exp(-R / L * ts);
    const double b = R > 0.0 ? -expm1(-R / L * ts) / R : ts / L;
    const double complex z = cexp(I * Omega_rad_s * ts);
    return b * (kp * (z - 1.0) + ki * ts) / ((z - 1.0) * z * (z - a));
}

static void current_d(const task_t *task, int count, const double *Omega, double complex *value) {
    for (int k = 0; k < count; ++k) {
        value[k] = current_at(task, Omega[k], false);
    }
}

static void current_q(const task_t *task, int count, const double *Omega, double complex *value) {
    for (int k = 0; k < count; ++k) {
        value[k] = current_at(task, Omega[k], true);
    }
}

// ---- Estimator ------------------------------------------------------------------------------------

static void pll_alone(const task_t *task, int count, const double *Omega, double complex *value) {
    margins_open_loop(task->drive, true, task->omega_rad_s, count, Omega, value);
}

static void pll_whole(const task_t *task, int count, const double *Omega, double complex *value) {
    margins_open_loop(task->drive, false, task->omega_rad_s, count, Omega, value);
}

// ---- Injection ------------------------------------------------------------------------------------

/// (H3) compares two periods, so its error is the mean of both. That of a pair (H22) holds for two periods.
static void injection(const task_t *task, int count, const double *Omega, double complex *value) {
    const lode_drive_config_t *drive = task->drive;
    const loop_ratio_t pll = loop_pll_sampled(
        (double)drive->hfi.sigma_rad_s, drive->estimator.pll.kind == LODE_PLL_LESO, task->ts_s);
    for (int k = 0; k < count; ++k) {
        const double complex mean = 0.5 * (1.0 + cexp(-I * Omega[k] * task->ts_s));
        value[k] = (drive->hfi.silent == LODE_ON ? mean : 1.0) * mean * loop_at(&pll, Omega[k]);
    }
}

// ---- Speed ----------------------------------------------------------------------------------------

/// The factor by which the gains rise with the speed (K8).
static double gain_at(const lode_speed_tuning_t *tuning, double omega_rad_s) {
    const double up = omega_rad_s * (double)tuning->inv_span - 1.0;
    return 1.0 + (double)tuning->rise * fmin(fmax(up, 0.0), 1.0);
}

/// Delay from the speed estimate to the period that uses the references computed from it; `z` for one PWM
/// period. With one execution per round the slots of the slow jobs come after current control, and the speed is
/// the mean of two; with more executions the jobs come before it.
static double complex slots(uint32_t periods, double complex z) {
    if (periods == LODE_SLOW_PERIODS) {
        return 0.5 * (1.0 + cpow(z, SLOT_LAG - SLOT_SPEED)) / (z * z);
    }
    return periods > 1u ? 1.0 / z : 1.0;
}

static void speed(const task_t *task, int count, const double *Omega, double complex *value) {
    const lode_drive_config_t *drive = task->drive;
    const double gain = gain_at(&task->tuning->speed, task->omega_rad_s);
    const double kp = gain * (double)drive->speed.kp_Nms;
    const double period = (double)task->tuning->speed_periods * task->ts_s;
    margins_speed_response(drive, task->omega_rad_s, count, Omega, value);
    for (int k = 0; k < count; ++k) {
        const double complex s = I * Omega[k];
        const double complex z = cexp(s * period);
        const double complex open = current_at(task, Omega[k], true);
        const double complex held = (1.0 - 1.0 / z) / (s * period);
        const double complex pi = kp + gain * (double)drive->speed.ki_Nm * period / (z - 1.0);
        const double complex shaft =
            1.0 / (s * (double)drive->motor.J_kgm2 + (double)drive->motor.B_Nms);
        value[k] *= pi * slots(task->tuning->speed_periods, cexp(s * task->ts_s)) * held * open /
                    (1.0 + open) * shaft;
    }
}

// ---- Margins and curves -----------------------------------------------------------------------------

/// The crossover of a slow loop lies far below the sampling frequency.
static double first_frequency(const task_t *task, response_t response) {
    double share = FIRST_SHARE;
    double complex value = 0.0;
    for (; share > LOWEST_SHARE; share *= 0.1) {
        const double Omega = share * 2.0 * RIG_PI / task->ts_s;
        response(task, 1, &Omega, &value);
        if (!(cabs(value) < 1.0)) {
            break;
        }
    }
    return share * 2.0 * RIG_PI / task->ts_s;
}

/// Up to half the rate of the loop.
static void frequencies(const task_t *task, response_t response, int count, double *Omega_rad_s) {
    const double periods = response == speed ? (double)task->tuning->speed_periods : 1.0;
    const double last = 0.999 * RIG_PI / (periods * task->ts_s);
    const double first = first_frequency(task, response);
    for (int k = 0; k < count; ++k) {
        Omega_rad_s[k] = first * pow(last / first, (double)k / (count - 1));
    }
}

/// Phase margin at the last fall of the gain through 1; gain margin at the first fall of the phase through -180
/// degrees above that.
static void note_margins(analyse_loop_t *row, const double *Omega, const double complex *value) {
    double phase = carg(value[0]);
    for (int k = 1; k < POINTS; ++k) {
        const double before = phase;
        phase += carg(value[k] * conj(value[k - 1]));
        if (cabs(value[k - 1]) >= 1.0 && cabs(value[k]) < 1.0) {
            row->crossover_rad_s = Omega[k];
            row->phase_deg = rig_deg_from_rad(carg(-value[k]));
            row->gain_dB = NAN;
        }
        const double down = remainder(before + RIG_PI, 2.0 * RIG_PI);
        const double up = remainder(phase + RIG_PI, 2.0 * RIG_PI);
        if (!isnan(row->crossover_rad_s) && isnan(row->gain_dB) && down >= 0.0 && up < 0.0 &&
            down < 1.0) {
            row->gain_dB = -20.0 * log10(cabs(value[k]));
        }
    }
}

/// Crossover and margins of one loop.
static analyse_loop_t measured(const task_t *task, const char *name, response_t response) {
    static double Omega[POINTS]; // large, and filled anew by every call
    static double complex value[POINTS];
    analyse_loop_t row = {.speed_rpm = rig_rpm_from_rad_s(task->omega_rad_s) /
                                       (double)task->drive->motor.pole_pairs,
                          .crossover_rad_s = NAN,
                          .phase_deg = NAN,
                          .gain_dB = NAN};
    (void)snprintf(row.name, sizeof row.name, "%s", name);
    frequencies(task, response, POINTS, Omega);
    response(task, POINTS, Omega, value);
    note_margins(&row, Omega, value);
    return row;
}

static void add_loop(analyse_t *self, const task_t *task, const char *figure, const char *name,
                     int family, response_t response) {
    if (self->loops == ANALYSE_LOOPS_MAX) {
        return;
    }
    const analyse_loop_t row = measured(task, name, response);
    self->loop[self->loops++] = row;
    const double rpm = row.speed_rpm;
    char label[ANALYSE_TEXT];
    if (isnan(rpm)) {
        (void)snprintf(label, sizeof label, "%s", name);
    } else {
        (void)snprintf(label, sizeof label, "%.4g rpm", rpm);
    }
    analyse_curve_t *curve = analyse_curve(self, figure, label, family, ANALYSE_SAMPLED);
    frequencies(task, response, ANALYSE_POINTS, curve->omega_rad_s);
    response(task, ANALYSE_POINTS, curve->omega_rad_s, curve->value);
}

/// Estimated over true EMF in alpha-beta, tuned to this speed.
static void add_observer(analyse_t *self, const task_t *task, int family) {
    const observer_t observer =
        observer_make(&task->tuning->estimator.emf.observer, task->ts_s, task->omega_rad_s);
    char label[ANALYSE_TEXT];
    (void)snprintf(label, sizeof label, "%.4g rpm",
                   rig_rpm_from_rad_s(task->omega_rad_s) / (double)task->drive->motor.pole_pairs);
    analyse_curve_t *curve = analyse_curve(self, "own-observer", label, family, ANALYSE_SAMPLED);
    analyse_curve_two_sided(curve, 0.01 * (double)task->drive->motor.omega_rated_rad_s,
                            0.999 * RIG_PI / task->ts_s);
    for (int k = 0; k < ANALYSE_POINTS; ++k) {
        curve->value[k] =
            observer_response(&observer, cexp(I * curve->omega_rad_s[k] * task->ts_s));
    }
}

void own_loops(analyse_t *self, const lode_drive_config_t *drive,
               const lode_drive_tuning_t *tuning) {
    task_t task = {drive, tuning, 1.0 / (double)drive->f_pwm_Hz, NAN};
    add_loop(self, &task, "own-current", CURRENT_D, 0, current_d);
    add_loop(self, &task, "own-current", CURRENT_Q, 1, current_q);
    if (drive->hfi.mode == LODE_HFI_ON) {
        add_loop(self, &task, "own-injection", "PLL by injection", 0, injection);
    }
    for (int k = 0; k < OWN_SPEEDS; ++k) {
        task.omega_rad_s = shares[k] * (double)drive->motor.omega_rated_rad_s;
        add_observer(self, &task, k);
        add_loop(self, &task, "own-pll", PLL_WHOLE, k, pll_whole);
        add_loop(self, &task, "own-pll-alone", "PLL alone", k, pll_alone);
        add_loop(self, &task, "own-speed", SPEED_ALONE, k, speed);
    }
}

own_margins_t own_loops_at(const lode_drive_config_t *drive, const lode_drive_tuning_t *tuning,
                           double omega_rad_s) {
    const task_t task = {drive, tuning, 1.0 / (double)drive->f_pwm_Hz, omega_rad_s};
    const analyse_loop_t d = measured(&task, CURRENT_D, current_d);
    const analyse_loop_t q = measured(&task, CURRENT_Q, current_q);
    return (own_margins_t){
        .current = d.phase_deg < q.phase_deg ? d : q,
        .pll = measured(&task, PLL_WHOLE, pll_whole),
        .speed = measured(&task, SPEED_ALONE, speed),
    };
}
