/// The motor of a design in data-sheet quantities, and the plausibility of its values.
#ifndef RIG_REPORT_MOTOR_H
#define RIG_REPORT_MOTOR_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "design/design.h"

void report_motor_text(FILE *file, const lode_drive_config_t *drive, const design_t *design);
void report_motor_json(cJSON *root, const lode_drive_config_t *drive, const design_t *design);

#endif
