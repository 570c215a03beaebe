/// The results of an analysis: text, CSV, JSON.
#ifndef RIG_REPORT_ANALYSE_H
#define RIG_REPORT_ANALYSE_H

#include <stdio.h>

#include "analyse/analyse.h"

void report_analyse_text(FILE *file, const rig_config_t *config, const analyse_t *analysis);
void report_analyse_csv(FILE *file, const analyse_t *analysis);
void report_analyse_json(FILE *file, const rig_config_t *config, const analyse_t *analysis);

#endif
