#include "commands/command_source.h"

#include "design/tuning_source.h"
#include "support/outputs.h"

bool command_source_open(command_source_t *self, const options_t *options) {
    self->file = NULL;
    return options->source == NULL ||
           (tuning_source_name(self->name, sizeof self->name, options->source) &&
            outputs_open(&self->file, options->source));
}

void command_source_print(const command_source_t *self, const char *command, const char *motor,
                          const options_t *options, const rig_config_t *config,
                          const lode_drive6_tuning_t *tuning) {
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
