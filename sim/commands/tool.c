#include "commands/tool.h"

#include <stdio.h>
#include <string.h>

#include "commands/command_analyse.h"
#include "commands/command_commission.h"
#include "commands/command_decode.h"
#include "commands/command_design.h"
#include "commands/command_faults.h"
#include "commands/command_monte_carlo.h"
#include "commands/command_replay.h"
#include "commands/command_reproduce.h"
#include "commands/command_run.h"
#include "config/data_files.h"
#include "config/schema.h"
#include "rig/inject.h"
#include "support/atomic_file.h"
#include "support/options.h"

#include "lodestar/version.h"

static void list_choice(const char *title, const char *key) {
    const rig_schema_t schema = rig_schema();
    const rig_key_t *row = &schema.row[rig_schema_find(schema, "estimator", key)];
    (void)printf("%s\n  built in   ", title);
    for (const char *at = row->names; *at != '\0'; ++at) {
        (void)putchar(*at == '|' ? ' ' : *at);
    }
    if (row->later != NULL) {
        (void)printf("\n  reserved   ");
    }
    for (const char *at = row->later; at != NULL && *at != '\0'; ++at) {
        (void)putchar(*at == '|' ? ' ' : *at);
    }
    (void)putchar('\n');
}

static rig_exit_t list(void) {
    static const char *const kinds[] = {"motors", "drives", "plants", "scenarios"};
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; ++k) {
        if (!data_files_list(stdout, kinds[k])) {
            return RIG_BAD_INPUT;
        }
    }
    list_choice("EMF observers (--emf, [estimator] emf)", "emf");
    list_choice("position PLLs (--pll, [estimator] pll)", "pll");
    return RIG_DONE;
}

static void help(const char *command) {
    options_print_help(command);
    if (command != NULL && strcmp(command, "faults") == 0) {
        (void)puts("\nkinds:");
        for (int k = 0; k < inject_kind_count; ++k) {
            (void)printf("  %-20s %s\n", inject_kinds[k].name, inject_kinds[k].what);
        }
    }
}

static rig_exit_t dispatch(const options_t *options) {
    switch (options->command) {
    case COMMAND_LIST:
        return list();
    case COMMAND_RUN:
        return command_run(options);
    case COMMAND_REPLAY:
        return command_replay(options);
    case COMMAND_DESIGN:
        return command_design(options);
    case COMMAND_ANALYSE:
        return command_analyse(options);
    case COMMAND_REPRODUCE:
        return command_reproduce(options);
    case COMMAND_FAULTS:
        return command_faults(options);
    case COMMAND_COMMISSION:
        return command_commission(options);
    case COMMAND_DECODE:
        return command_decode(options);
    case COMMAND_MONTE_CARLO:
        return command_monte_carlo(options);
    case COMMAND_HELP:
        help(options->help_for);
        return RIG_DONE;
    case COMMAND_VERSION:
        (void)printf("lodestar %d.%d.%d\n", LODE_VERSION_MAJOR, LODE_VERSION_MINOR,
                     LODE_VERSION_PATCH);
        return RIG_DONE;
    case COMMAND_MAIN_JOB:
    default:
        return command_main_job(options);
    }
}

int tool_main(int argc, char **argv) {
    options_t options;
    atomic_file_catch_signals();
    if (!options_parse(&options, argc, argv)) {
        return RIG_BAD_INPUT;
    }
    const rig_exit_t code = dispatch(&options);
    atomic_file_discard_all();
    if (fflush(stdout) != 0 || ferror(stdout) != 0) {
        rig_error("cannot write to standard output");
        return RIG_BAD_INPUT;
    }
    return (int)code;
}
