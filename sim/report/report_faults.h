/// The results of a fault campaign: table, page, JSON.
#ifndef RIG_REPORT_FAULTS_H
#define RIG_REPORT_FAULTS_H

#include "config/config_json.h"
#include "rig/fault_case.h"

/// A bit whose flip was silent.
typedef struct {
    uint64_t number; ///< of the case: [motor][kind][point]
    uint64_t bit;
} report_faults_bit_t;

typedef struct {
    const char *motor;
    const char *place; ///< of the faults, as --in names it; NULL: the default
    const fault_bench_t *bench;
    const inject_kind_t *const *kind;
    int kinds;
    const fault_result_t *result; ///< [kind][point]
    bool by_bit;                  ///< each bit of a range was tried
    uint64_t first;               ///< number of the motor's first case
    const report_faults_bit_t *bit;
    int bits; ///< of all motors
} report_faults_t;

/// A table in Markdown. Returns how many cases were silent.
int report_faults_table(FILE *file, const report_faults_t *report);

/// Writes docs/faults.md with all tables.
void report_faults_page(FILE *file, const char *tables);

cJSON *report_faults_json_root(void);

/// Nothing for NULL.
void report_faults_json(cJSON *root, const report_faults_t *report);

#endif
