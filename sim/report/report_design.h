/// The results of a design: text and JSON.
#ifndef RIG_REPORT_DESIGN_H
#define RIG_REPORT_DESIGN_H

#include <stdio.h>

#include "design/design.h"

void report_design_text(FILE *file, const rig_config_t *config, const design_t *design);
void report_design_json(FILE *file, const rig_config_t *config, const design_t *design);

#endif
