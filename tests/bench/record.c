/// usage: record > recording.c
/// Runs every drive of the budget in closed loop with a motor and prints, as constant tables, what its
/// ADC delivers in each period and what came of it. Fails where a drive does not do what its
/// case is named for.
#include "record.h"

#include <math.h>
#include <stdio.h>

#define V_FAULT_V 65.0 // above the guard's 1.25 times nominal
#define V_LOW_V 17.0   // too little for the highest current at this speed
#define FAULT_ROW 200  // after the warm-up of a count, and before its end
#define SAG_ROW 150
#define SAG_ROWS 150
#define LD_FALL_PER_A 0.01 // of a case that is to tell north from south

static double bus_V(bench_scene_t scene, int32_t row) {
    if (scene == BENCH_FAULT && row >= FAULT_ROW) {
        return V_FAULT_V;
    }
    const double sag = (double)(row - SAG_ROW) / (double)SAG_ROWS;
    return scene == BENCH_SATURATED && sag > 0.0
               ? (double)BENCH_V_BUS_V + fmin(sag, 1.0) * (V_LOW_V - (double)BENCH_V_BUS_V)
               : (double)BENCH_V_BUS_V;
}

static bool from_standstill(bench_scene_t scene) {
    return scene == BENCH_RISE || scene == BENCH_START || scene == BENCH_INJECTING;
}

static shaft_t shaft_of(bench_scene_t scene, lode_mode_t mode) {
    const bool braked = mode == LODE_MODE_RUN && scene != BENCH_RISE && scene != BENCH_START;
    if (braked) {
        return SHAFT_BRAKED;
    }
    return from_standstill(scene) ? SHAFT_FREE : SHAFT_DRAGGED;
}

// Between -1 and 1: what an ADC adds in counts.
static double noise(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (double)*state / 2147483648.0 - 1.0;
}

lode_counts_t record_counts(const motor_t *motor, int set, uint32_t *dice, double v_bus_V,
                            int32_t period) {
    lode_counts_t counts = {.v_bus = (uint16_t)lrint(v_bus_V / (double)BENCH_V_GAIN_V_count),
                            .temperature = 2000,
                            .stamp = (uint32_t)period * BENCH_STAMP_PER_PERIOD};
    double i[3];
    motor_phases(motor, set, i);
    for (int k = 0; k < 3; k++) {
        counts.i[k] = (uint16_t)lrint((double)BENCH_I_OFFSET_count +
                                      i[k] / (double)BENCH_I_GAIN_A_count + noise(dice));
    }
    return counts;
}

// How many of the counted periods were what.
typedef struct {
    int32_t mode[LODE_MODE_FAULT + 1];
    int32_t bad; // estimate
    int32_t current_limit;
    int32_t voltage_limit;
} seen_t;

typedef struct {
    int32_t number;
    motor_t motor;
    uint32_t dice; // state of the noise
    lode_drive_out_t applied;
    lode_telemetry_t telemetry;
    seen_t seen;
    lode_counts_t counts[BENCH_SETTLE_INJECTING + BENCH_ROWS];
    bench_truth_t truth[BENCH_ROWS + 1];
    bench_inputs_t inputs[BENCH_SETTLE_INJECTING + BENCH_ROWS];
} run_t;

static void look(run_t *run) {
    const lode_telemetry_t *t = &run->telemetry;
    seen_t *seen = &run->seen;
    seen->mode[t->mode]++;
    seen->bad += t->mode == LODE_MODE_RUN &&
                 !bench_estimate_is_good(run->number, t, (float)run->motor.theta_rad);
    seen->current_limit += fabs((double)t->ref_A.q) >= 1.99 * (double)BENCH_IQ_A;
    const double share = hypot((double)t->u_V.d, (double)t->u_V.q) * sqrt(3.0) / (double)t->v_bus_V;
    seen->voltage_limit += share >= 0.94;
}

// One period: sample, step, and what the motor makes of the output before the next sample.
static void one_period(run_t *run, int32_t period, int32_t row) {
    const bench_scene_t scene = bench_scene(run->number);
    const double v_bus_V = bus_V(scene, row);
    lode_counts_t *counts = &run->counts[period];
    lode_drive_t *drive = &bench_drive[run->number];
    *counts = record_counts(&run->motor, 0, &run->dice, v_bus_V, period);
    const lode_drive_out_t out = lode_drive_step(drive, counts);
    (void)lode_drive_telemetry(drive, &run->telemetry);
    double i[3];
    motor_phases(&run->motor, 0, i);
    const float theta = (float)run->motor.theta_rad;
    run->inputs[period] = (bench_inputs_t){
        {(float)run->motor.u_alpha_V, (float)run->motor.u_beta_V},
        {(float)i[0], (float)((i[1] - i[2]) / sqrt(3.0))},
        theta,
    };
    if (row >= -1) {
        run->truth[row + 1] = (bench_truth_t){bench_digest(out), theta, run->telemetry.mode};
    }
    if (row >= 0) {
        look(run);
    }
    run->applied.gates = out.gates; // at once; the duties only from the next period on
    motor_period(&run->motor, &run->applied, v_bus_V, shaft_of(scene, run->telemetry.mode));
    run->applied.duty = out.duty;
}

static bool is_as_named(const run_t *run) {
    const seen_t *s = &run->seen;
    const int32_t running = s->mode[LODE_MODE_RUN];
    switch (bench_scene(run->number)) {
    case BENCH_STEADY:
    case BENCH_INJECTING: // without injection it would not run so slowly
        return running == BENCH_ROWS && s->bad == 0 &&
               fabs(run->motor.iq_A / (double)BENCH_IQ_A - 1.0) < 0.1;
    case BENCH_RISE:
        return s->mode[LODE_MODE_START] == BENCH_ROWS;
    case BENCH_START: // most of it in START, and the hand-over well inside
        return s->mode[LODE_MODE_START] > 250 && running > 80 && s->bad == 0;
    case BENCH_SATURATED:
        return running == BENCH_ROWS && s->bad == 0 && s->current_limit > 200 &&
               s->voltage_limit > 200;
    case BENCH_FAULT:
        return running >= FAULT_ROW && s->mode[LODE_MODE_FAULT] > 200 && s->bad == 0;
    case BENCH_OFF:
    default:
        return s->mode[LODE_MODE_OFF] == BENCH_ROWS;
    }
}

static bool record(run_t *run) {
    const bool dragged = // behind a vector that starts at 0
        !from_standstill(bench_scene(run->number));
    const bool injecting = bench_scene(run->number) == BENCH_INJECTING;
    run->motor = (motor_t){.sets = 1,
                           .Ld_H = (double)bench_config(run->number).motor.Ld_H,
                           .Ld_fall_per_A = injecting ? LD_FALL_PER_A : 0.0,
                           .braked_rad_s = (double)bench_omega_rad_s(run->number),
                           .theta_rad = dragged ? -1.5 : 1.0};
    if (!bench_begin(run->number)) {
        fprintf(stderr, "case %d: the configuration was refused\n", (int)run->number);
        return false;
    }
    const int32_t settle = bench_settle(run->number);
    for (int32_t period = 0; period < settle + BENCH_ROWS; period++) {
        if (period == settle) {
            bench_settled(run->number);
        }
        one_period(run, period, period - settle);
    }
    if (!is_as_named(run)) {
        const seen_t *s = &run->seen;
        fprintf(stderr,
                "case %d is not what it is named for: %d periods in START, %d in RUN (%d of them "
                "badly estimated), %d in FAULT, %d at the limit of current, %d of voltage; "
                "iq %.2f A, speed %.1f rad/s, estimated %.1f, lock %.2f\n",
                (int)run->number, (int)s->mode[LODE_MODE_START], (int)s->mode[LODE_MODE_RUN],
                (int)s->bad, (int)s->mode[LODE_MODE_FAULT], (int)s->current_limit,
                (int)s->voltage_limit, run->motor.iq_A, run->motor.omega_rad_s,
                (double)run->telemetry.omega_rad_s, (double)run->telemetry.lock);
        return false;
    }
    return true;
}

void record_print_counts(const lode_counts_t *counts, int32_t rows) {
    for (int32_t k = 0; k < rows; k++) {
        const lode_counts_t *c = &counts[k];
        printf("{.i = {%u, %u, %u}, .v_bus = %u, .temperature = %u, .stamp = %u},\n", c->i[0],
               c->i[1], c->i[2], c->v_bus, c->temperature, (unsigned)c->stamp);
    }
}

void record_print_truth(const bench_truth_t *truth, int32_t rows) {
    for (int32_t k = 0; k < rows; k++) {
        printf("{%uu, %.9ef, %s},\n", (unsigned)truth[k].digest, (double)truth[k].theta_rad,
               lode_mode_name(truth[k].mode));
    }
}

static void print_inputs(const bench_inputs_t *inputs, int32_t rows) {
    for (int32_t k = 0; k < rows; k++) {
        const bench_inputs_t *in = &inputs[k];
        printf("{{%.9ef, %.9ef}, {%.9ef, %.9ef}, %.9ef},\n", (double)in->u_V.alpha,
               (double)in->u_V.beta, (double)in->i_A.alpha, (double)in->i_A.beta,
               (double)in->theta_rad);
    }
}

static void print_all(const run_t *runs) {
    printf("#include \"image.h\"\n"
           "const lode_counts_t bench_settling[BENCH_CASE_COUNT][BENCH_SETTLE_INJECTING] = {\n");
    for (int32_t n = 0; n < BENCH_CASE_COUNT; n++) {
        printf("{\n");
        record_print_counts(runs[n].counts, bench_settle(n));
        printf("},\n");
    }
    printf("};\nconst lode_counts_t bench_counted[BENCH_CASE_COUNT][BENCH_ROWS] = {\n");
    for (int32_t n = 0; n < BENCH_CASE_COUNT; n++) {
        printf("{\n");
        record_print_counts(runs[n].counts + bench_settle(n), BENCH_ROWS);
        printf("},\n");
    }
    printf("};\nconst bench_truth_t bench_truth[BENCH_CASE_COUNT][BENCH_ROWS + 1] = {\n");
    for (int32_t n = 0; n < BENCH_CASE_COUNT; n++) {
        printf("{\n");
        record_print_truth(runs[n].truth, BENCH_ROWS + 1);
        printf("},\n");
    }
    printf("};\nconst bench_inputs_t bench_inputs[BENCH_SETTLE_ESTIMATOR + BENCH_ROWS] = {\n");
    print_inputs(runs[BENCH_enhanced].inputs + BENCH_SETTLE - BENCH_SETTLE_ESTIMATOR,
                 BENCH_SETTLE_ESTIMATOR + BENCH_ROWS);
    printf("};\n");
}

int main(void) {
    static run_t runs[BENCH_CASE_COUNT];
    bool good = true;
    for (int32_t number = 0; number < BENCH_CASE_COUNT; number++) {
        runs[number].number = number;
        good = record(&runs[number]) && good;
    }
    good = record6_all() && good;
    if (good) {
        print_all(runs);
        record6_print();
    }
    return good ? 0 : 1;
}
