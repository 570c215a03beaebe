/// A reproduction as a table for people, JSON and CSV.
#ifndef RIG_REPRODUCE_REPORT_H
#define RIG_REPRODUCE_REPORT_H

#include <stdio.h>

#include "reproduce_rows.h"

void reproduce_report_table(FILE *file, const reproduction_t *reproduction);
void reproduce_report_json(FILE *file, const reproduction_t *reproduction,
                           const case_bases_t *bases);
void reproduce_report_csv(FILE *file, const reproduction_t *reproduction);

#endif
