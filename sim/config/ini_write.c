#include "config/ini_write.h"

#include <string.h>

#include "config/conversions.h"

/// Keys that only a drive with six phases reads.
static bool is_of_six(const rig_key_t *key) {
    return strcmp(key->section, "xy") == 0 || strcmp(key->key, "Lxy_H") == 0 ||
           strcmp(key->key, "winding") == 0 || strcmp(key->key, "open_phase") == 0;
}

bool ini_write_is_of_drive(const rig_config_t *config, const rig_key_t *key) {
    return (!is_of_six(key) || rig_config_is_six(config)) && strcmp(key->section, "plant") != 0 &&
           strcmp(key->section, "scenario") != 0 && strcmp(key->key, "source") != 0;
}

/// A key in other units is not written, because the key it replaces has the value.
static bool is_written(const rig_config_t *config, int row) {
    const rig_schema_t schema = rig_schema();
    const rig_key_t *key = &schema.row[row];
    const rig_origin_t *origin = &config->origin[row];
    const bool given = origin->file >= 0 || origin->line == 0;
    return (given || origin->assumed != NULL || origin->measured) &&
           ini_write_is_of_drive(config, key) && !conversions_has(key->section, key->key);
}

/// A value that is assumed for any motor is assumed again when the file is read, and so keeps its mark, which
/// the refusal for firmware needs.
static bool is_assumed_again(const rig_config_t *config, int row) {
    static const char *const by_motor[] = {"f_pwm_Hz", "v_bus_V", "i_max_A"};
    bool again = config->origin[row].assumed != NULL;
    for (size_t k = 0; k < sizeof by_motor / sizeof by_motor[0]; ++k) {
        again = again && strcmp(rig_schema().row[row].key, by_motor[k]) != 0;
    }
    return again;
}

void ini_write(FILE *file, const rig_config_t *config) {
    const rig_schema_t schema = rig_schema();
    const char *section = "";
    for (int k = 0; k < schema.rows; ++k) {
        const rig_key_t *key = &schema.row[k];
        const rig_origin_t *origin = &config->origin[k];
        char value[RIG_PATH_LENGTH];
        rig_key_print_exactly(key, config, value, sizeof value);
        if (value[0] == '\0' || !is_written(config, k)) {
            continue;
        }
        if (origin->measured && strcmp(value, "auto") == 0) { // every value was given
            (void)snprintf(value, sizeof value, "0");
        }
        if (strcmp(section, key->section) != 0) {
            section = key->section;
            (void)fprintf(file, "[%s]\n", section);
        }
        (void)fprintf(file, "%s%s = %s", is_assumed_again(config, k) ? "; " : "", key->key, value);
        if (origin->measured) {
            (void)fputs(" ; measured", file);
        } else if (origin->assumed != NULL) {
            (void)fprintf(file, " ; assumed: %s", origin->assumed);
        }
        (void)fputc('\n', file);
    }
}
