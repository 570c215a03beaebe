#include "config/config_json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "config/schema.h"
#include "lodestar/version.h"

cJSON *config_json_root(void) {
    cJSON *root = cJSON_CreateObject();
    char version[32];
    (void)snprintf(version, sizeof version, "%d.%d.%d", LODE_VERSION_MAJOR, LODE_VERSION_MINOR,
                   LODE_VERSION_PATCH);
    (void)cJSON_AddStringToObject(root, "lodestar", version);
    return root;
}

cJSON *config_json_item(cJSON *array) {
    cJSON *item = cJSON_CreateObject();
    (void)cJSON_AddItemToArray(array, item);
    return item;
}

/// Whole numbers that cJSON, with its 15 digits, would round: seeds, up to 2^53.
static bool is_long(double value) {
    return value >= 1.0e15 && value <= 9007199254740992.0 && !(floor(value) < value);
}

void config_json_number(cJSON *object, const char *name, double value) {
    if (is_long(value)) {
        char digits[32];
        (void)snprintf(digits, sizeof digits, "%.0f", value);
        (void)cJSON_AddRawToObject(object, name, digits);
    } else if (isfinite(value)) {
        (void)cJSON_AddNumberToObject(object, name, value);
    } else {
        (void)cJSON_AddNullToObject(object, name);
    }
}

/// A float's own digits, not those of the double nearest to it: 0.0035, not 0.00350000011.
static double plain(double value) {
    char digits[32];
    (void)snprintf(digits, sizeof digits, "%.7g", value);
    return strtod(digits, NULL);
}

static void add_key(cJSON *section, const rig_config_t *config, const rig_key_t *key) {
    double number = 0.0;
    char text[RIG_PATH_LENGTH];
    if (rig_key_number(key, config, &number)) {
        const bool whole = key->kind == RIG_KEY_DOUBLE && !(floor(number) < number);
        config_json_number(section, key->key, whole ? number : plain(number));
        return;
    }
    rig_key_print(key, config, text, sizeof text);
    if (text[0] != '\0') {
        (void)cJSON_AddStringToObject(section, key->key, text);
    }
}

cJSON *config_json(const rig_config_t *config) {
    const rig_schema_t schema = rig_schema();
    cJSON *root = cJSON_CreateObject();
    cJSON *section = NULL;
    for (int k = 0; k < schema.rows; ++k) {
        const rig_key_t *key = &schema.row[k];
        if (k == 0 || strcmp(key->section, schema.row[k - 1].section) != 0) {
            section = cJSON_AddObjectToObject(root, key->section);
        }
        add_key(section, config, key);
    }
    return root;
}

cJSON *config_json_assumed(const rig_config_t *config) {
    const rig_schema_t schema = rig_schema();
    cJSON *object = cJSON_CreateObject();
    for (int k = 0; k < schema.rows; ++k) {
        if (config->origin[k].assumed != NULL) {
            char name[64];
            (void)snprintf(name, sizeof name, "%s.%s", schema.row[k].section, schema.row[k].key);
            (void)cJSON_AddStringToObject(object, name, config->origin[k].assumed);
        }
    }
    return object;
}

bool config_json_write(FILE *file, cJSON *root) {
    char *text = cJSON_Print(root);
    cJSON_Delete(root);
    if (text == NULL) {
        return false;
    }
    (void)fprintf(file, "%s\n", text);
    cJSON_free(text);
    return true;
}
