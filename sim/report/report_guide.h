/// The gain guideline and the limits of a design: text and JSON.
#ifndef RIG_REPORT_GUIDE_H
#define RIG_REPORT_GUIDE_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "design/design.h"

void report_guide_text(FILE *file, const rig_config_t *config, const design_t *design);
void report_guide_json(cJSON *root, const design_t *design);

#endif
