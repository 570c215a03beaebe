/// What the recordings for three and for six phases share. For the host only.
#ifndef BENCH_RECORD_H
#define BENCH_RECORD_H

#include "image.h"
#include "motor.h"

/// What the ADC of a set delivers at the start of a period. `dice`: state of their noise.
lode_counts_t record_counts(const motor_t *motor, int set, uint32_t *dice, double v_bus_V,
                            int32_t period);

void record_print_counts(const lode_counts_t *counts, int32_t rows);
void record_print_truth(const bench_truth_t *truth, int32_t rows);

/// Runs all cases of drives6.h. False, with the reason on stderr: one is not what it is named for.
bool record6_all(void);
void record6_print(void);

#endif
