/// The values in use as JSON, key by key.
#ifndef RIG_CONFIG_JSON_H
#define RIG_CONFIG_JSON_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "config/rig_config.h"

/// A new object with the tool's version, for the results of a command.
cJSON *config_json_root(void);

/// A new object at the end of an array.
cJSON *config_json_item(cJSON *array);

/// {section: {key: value}} of everything that is set or computed.
cJSON *config_json(const rig_config_t *config);

/// The assumed values: "section.key" and the reason for the value.
cJSON *config_json_assumed(const rig_config_t *config);

/// A number as JSON that reads back to the same value; null for NaN and infinity.
void config_json_number(cJSON *object, const char *name, double value);

/// Writes `root` with a line end and deletes it. False if out of memory.
bool config_json_write(FILE *file, cJSON *root);

#endif
