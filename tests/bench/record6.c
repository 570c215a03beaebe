#include "record.h"

#include <math.h>
#include <stdio.h>

#define XY_MAX_A 0.5 // beyond it the xy plane is not under control

typedef struct {
    int32_t number;
    motor_t motor;
    uint32_t dice;
    lode_drive_out_t applied[LODE_SETS];
    int32_t bad; // of the counted periods
    lode_counts6_t counts[BENCH_SETTLE + BENCH_ROWS];
    bench_truth_t truth[BENCH_ROWS + 1];
} run6_t;

static run6_t runs[BENCH6_CASE_COUNT];

static void one_period(run6_t *run, int32_t period) {
    lode_drive6_t *drive = &bench6_drive[run->number];
    lode_counts6_t *counts = &run->counts[period];
    for (int set = 0; set < LODE_SETS; set++) {
        counts->set[set] =
            record_counts(&run->motor, set, &run->dice, (double)BENCH_V_BUS_V, period);
    }
    const lode_drive6_out_t out = lode_drive6_step(drive, counts);
    lode_telemetry_t telemetry;
    (void)lode_drive_telemetry(&drive->drive, &telemetry);
    const bool running = telemetry.mode == LODE_MODE_RUN;
    const float theta = (float)run->motor.theta_rad;
    const int32_t row = period - BENCH_SETTLE;
    if (row >= -1) {
        run->truth[row + 1] = (bench_truth_t){bench6_digest(out), theta, telemetry.mode};
    }
    if (row >= 0) {
        run->bad += !running ||
                    !bench_estimate_is_good(bench6_like(run->number), &telemetry, theta) ||
                    hypot(run->motor.x_A, run->motor.y_A) > XY_MAX_A;
    }
    for (int set = 0; set < LODE_SETS; set++) {
        run->applied[set].gates = out.set[set].gates;
    }
    motor_period(&run->motor, run->applied, (double)BENCH_V_BUS_V,
                 running ? SHAFT_BRAKED : SHAFT_DRAGGED);
    for (int set = 0; set < LODE_SETS; set++) {
        run->applied[set].duty = out.set[set].duty;
    }
}

static bool record(run6_t *run) {
    run->motor = (motor_t){.sets = LODE_SETS,
                           .braked_rad_s = (double)BENCH_OMEGA_rad_s,
                           .Ld_H = (double)BENCH_L_H,
                           .theta_rad = -1.5}; // behind a vector that starts at 0
    if (!bench6_begin(run->number)) {
        fprintf(stderr, "six phases, case %d: the configuration was refused\n", (int)run->number);
        return false;
    }
    for (int32_t period = 0; period < BENCH_SETTLE + BENCH_ROWS; period++) {
        one_period(run, period);
    }
    const motor_t *m = &run->motor;
    const bool good = run->bad == 0 && fabs(m->iq_A / (double)BENCH_IQ_A - 1.0) < 0.1;
    if (!good) {
        fprintf(stderr,
                "six phases, case %d is not at its operating point: %d bad periods; iq %.2f A, xy "
                "%.2f %.2f A, speed %.1f rad/s\n",
                (int)run->number, (int)run->bad, m->iq_A, m->x_A, m->y_A, m->omega_rad_s);
    }
    return good;
}

bool record6_all(void) {
    bool good = true;
    for (int32_t number = 0; number < BENCH6_CASE_COUNT; number++) {
        runs[number].number = number;
        good = record(&runs[number]) && good;
    }
    return good;
}

static void print_counts(const char *name, int32_t from, int32_t rows) {
    printf("const lode_counts6_t %s[BENCH6_CASE_COUNT][%d] = {\n", name, (int)rows);
    for (int32_t n = 0; n < BENCH6_CASE_COUNT; n++) {
        printf("{\n");
        for (int32_t k = from; k < from + rows; k++) {
            printf("{.set = {\n");
            record_print_counts(runs[n].counts[k].set, LODE_SETS);
            printf("}},\n");
        }
        printf("},\n");
    }
    printf("};\n");
}

void record6_print(void) {
    print_counts("bench6_settling", 0, BENCH_SETTLE);
    print_counts("bench6_counted", BENCH_SETTLE, BENCH_ROWS);
    printf("const bench_truth_t bench6_truth[BENCH6_CASE_COUNT][BENCH_ROWS + 1] = {\n");
    for (int32_t n = 0; n < BENCH6_CASE_COUNT; n++) {
        printf("{\n");
        record_print_truth(runs[n].truth, BENCH_ROWS + 1);
        printf("},\n");
    }
    printf("};\n");
}
