/// A reproduction as a text table, JSON and CSV.
#ifndef RIG_REPRODUCE_REPORT_H
#define RIG_REPRODUCE_REPORT_H

#include <stdio.h>

#include "config/rig_config.h"
#include "reproduce/table.h"

void reproduce_report_table(FILE *file, const table_t *self);
/// `config`: the configuration of the paper's own forms.
void reproduce_report_json(FILE *file, const table_t *self, const rig_config_t *config);
void reproduce_report_csv(FILE *file, const table_t *self);

#endif
