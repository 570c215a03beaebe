#include "commands/command_source.h"

#include "config/schema.h"
#include "design/tuning_source.h"
#include "support/diag.h"
#include "support/outputs.h"

/// Refuses two winding sets, which the C constant does not support, with the place of the key.
static void refuse_six(const rig_config_t *config, const char *source) {
    const int row = rig_schema_find(rig_schema(), "motor", "sets");
    const rig_origin_t *origin = &config->origin[row];
    rig_error_at(origin->file >= 0 ? config->file[origin->file] : "--set",
                 origin->file >= 0 ? origin->line : 0,
                 "[motor] sets: --c %s: expected a drive for three phases; one for six is designed "
                 "on the target, by lode_drive6_init()",
                 source);
}

bool command_source_open(command_source_t *self, const options_t *options,
                         const rig_config_t *config) {
    self->file = NULL;
    if (options->source != NULL && rig_config_is_six(config)) {
        refuse_six(config, options->source);
        return false;
    }
    return options->source == NULL ||
           (tuning_source_name(self->name, sizeof self->name, options->source) &&
            outputs_open(&self->file, options->source));
}

void command_source_print(const command_source_t *self, const char *command, const char *motor,
                          const options_t *options, const rig_config_t *config,
                          const lode_drive_tuning_t *tuning) {
    if (self->file == NULL) {
        return;
    }
    char from[RIG_PATH_LENGTH * 2];
    (void)snprintf(from, sizeof from, "`lodestar %s --c` from %s%s%s%s", command, motor,
                   options->drive != NULL ? " and " : "",
                   options->drive != NULL ? options->drive : "",
                   options->sets > 0 ? ", --set" : "");
    tuning_source_print(self->file, self->name, tuning, config, from);
}
