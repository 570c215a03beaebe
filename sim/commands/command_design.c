#include "commands/command_design.h"

#include <stdio.h>

#include "commands/command_load.h"
#include "commands/command_source.h"
#include "config/assumptions.h"
#include "config/refusal.h"
#include "design/advice.h"
#include "design/design.h"
#include "report/report_design.h"
#include "support/atomic_file.h"
#include "support/outputs.h"

/// Writes the C constants if --c is given. The library has accepted the configuration.
static bool print_source(const options_t *options, const rig_config_t *config,
                         const lode_drive6_tuning_t *tuning) {
    if (options->source == NULL) {
        return true;
    }
    command_source_t source;
    if (!command_source_open(&source, options)) {
        return false;
    }
    command_source_print(&source, "design", options->motor, options, config, tuning);
    return true;
}

rig_exit_t command_design(const options_t *options) {
    rig_config_t config;
    design_t design;
    FILE *json = NULL;
    if (!command_load_drive(&config, options->motor, options->drive, options) ||
        !outputs_open(&json, options->json)) {
        return RIG_BAD_INPUT;
    }
    const rig_config_t read = config;
    if (!rig_config_complete(&config, options->source == NULL ? RIG_NEED_MOTOR : RIG_NEED_BOARD)) {
        return RIG_BAD_INPUT;
    }
    rig_config_design(&config);
    lode_drive6_tuning_t tuning;
    const lode_status_t status = rig_config_tune(&config, &tuning);
    if (status != LODE_OK) {
        refusal_report(&config, status);
        return RIG_BAD_INPUT;
    }
    if (!print_source(options, &config, &tuning)) {
        return RIG_BAD_INPUT;
    }
    assumptions_disturbances(&config);
    design_compute(&design, &config, &tuning.drive);
    advice_find(&design.verdict, &read, &config);
    if (options->json_on_stdout) {
        report_design_json(stdout, &config, &design);
    } else {
        report_design_text(stdout, &config, &design);
    }
    if (json != NULL) {
        report_design_json(json, &config, &design);
    }
    if (!atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    if (!options->json_on_stdout) {
        outputs_say(options->json);
        outputs_say(options->source);
    }
    return RIG_DONE;
}
