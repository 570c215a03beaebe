#include "design/config_source.h"

#include <stddef.h>
#include <string.h>

#include "config/schema.h"
#include "design/tuning_fields.h"

typedef struct {
    const char *type, *name;
    int value;
} choice_t;

static const char *name_of(const char *type, int value) {
#define CHOICE_ROW(type, enumerator) {#type, #enumerator, (int)(enumerator)},
    static const choice_t choices[] = {CONFIG_CHOICES(CHOICE_ROW)};
    for (size_t k = 0u; k < sizeof choices / sizeof choices[0]; ++k) {
        if (choices[k].value == value && strcmp(choices[k].type, type) == 0) {
            return choices[k].name;
        }
    }
    return "0"; // not reached: the library has accepted the value
}

/// `offset`: of the field in rig_config_t, where a key may have put it.
static bool is_measured(const rig_config_t *config, size_t offset) {
    const rig_schema_t schema = rig_schema();
    bool measured = false;
    for (int k = 0; k < schema.rows; ++k) {
        measured = measured || (schema.row[k].offset == offset && config->origin[k].measured);
    }
    return measured;
}

static bool has_measured(const rig_config_t *config) {
    bool measured = false;
    for (int k = 0; k < rig_schema().rows; ++k) {
        measured = measured || config->origin[k].measured;
    }
    return measured;
}

/// `path`: what the designator has before the field. A measured value is written even if it is 0.
static void print_float(FILE *file, const char *path, const char *field, float value,
                        bool measured) {
    if (value != 0.0f || measured) {
        (void)fprintf(file, "    .%s%s = %af, // %.9g%s\n", path, field, (double)value,
                      (double)value, measured ? ", measured" : "");
    }
}

static void print_choice(FILE *file, const char *path, const char *field, const char *type,
                         int value) {
    if (value != 0) {
        (void)fprintf(file, "    .%s%s = %s,\n", path, field, name_of(type, value));
    }
}

#define PRINT_FLOAT(type, object, place, field)                                                    \
    print_float(file, path, #field, (object).field,                                                \
                is_measured(config, offsetof(rig_config_t, place.field)));
#define PRINT_CHOICE(type, object, place, field)                                                   \
    print_choice(file, path, #field, #type, (int)(object).field);
#define PRINT_DRIVE(kind, type, field) PRINT_##kind(type, config->given, drive, field)
#define PRINT_SIX(kind, type, field) PRINT_##kind(type, config->given_six, six, field)

static void print_drive(FILE *file, const char *path, const rig_config_t *config) {
    CONFIG_FIELDS(PRINT_DRIVE)
}

static void print_six(FILE *file, const char *path, const rig_config_t *config) {
    CONFIG6_FIELDS(PRINT_SIX)
}

void config_source_print(FILE *file, const char *name, const rig_config_t *config) {
    const bool six = rig_config_is_six(config);
    const char *type = six ? "lode_drive6_config_t" : "lode_drive_config_t";
    if (has_measured(config)) {
        (void)fprintf(file,
                      "// Measured by the drive itself: what is marked. As told: everything else, "
                      "also pole pairs, bus voltage, i_max and the gains of the %ssensors.\n",
                      six ? "two sets' " : "");
    }
    (void)fprintf(file, "extern const %s %s_config;\nconst %s %s_config = {\n", type, name, type,
                  name);
    print_drive(file, six ? "drive." : "", config);
    if (six) {
        print_six(file, "", config);
    }
    (void)fputs("};\n", file);
}
