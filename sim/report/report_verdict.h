/// The verdict of a design: text and JSON.
#ifndef RIG_REPORT_VERDICT_H
#define RIG_REPORT_VERDICT_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "design/design.h"

void report_verdict_text(FILE *file, const lode_drive_config_t *drive, const design_t *design);
void report_verdict_json(cJSON *root, const lode_drive_config_t *drive, const design_t *design);

#endif
