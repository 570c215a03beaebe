#include "commands/command_load.h"

#include "config/data_files.h"
#include "config/ini_config.h"

bool command_load_sets(rig_config_t *config, const options_t *options) {
    bool good = true;
    for (int k = 0; good && k < options->sets; ++k) {
        good = ini_config_set(config, "--set", options->set[k]);
    }
    return good;
}

bool command_load_drive(rig_config_t *config, const char *motor, const char *drive,
                        const options_t *options) {
    rig_config_init(config);
    return data_files_load_part(config, "motors", motor) &&
           data_files_load_part(config, "drives", drive) && command_load_sets(config, options);
}
