/// Signal injection in a design: text and JSON.
#ifndef RIG_REPORT_INJECTION_H
#define RIG_REPORT_INJECTION_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "design/injection.h"

void report_injection_text(FILE *file, const lode_drive_config_t *config,
                           const injection_t *injection);
void report_injection_json(cJSON *root, const injection_t *injection);

#endif
