/// The command line.
#ifndef RIG_OPTIONS_H
#define RIG_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    COMMAND_MAIN_JOB,
    COMMAND_LIST,
    COMMAND_RUN,
    COMMAND_REPLAY,
    COMMAND_DESIGN,
    COMMAND_ANALYSE,
    COMMAND_REPRODUCE,
    COMMAND_DECODE,
    COMMAND_FAULTS,
    COMMAND_MONTE_CARLO,
    COMMAND_COMMISSION,
    COMMAND_HELP,
    COMMAND_VERSION
} options_command_t;

/// Seeds pass through a double, which is exact up to this value.
#define OPTIONS_SEED_MAX (UINT64_C(1) << 53)

enum { OPTIONS_SETS_MAX = 64, OPTIONS_COLUMNS_MAX = 32, OPTIONS_FILES_MAX = 1024 };

/// Strings point into argv; NULL: not given.
typedef struct {
    options_command_t command;
    const char *help_for; ///< name of a command
    const char *scenario;
    const char *paper; ///< to be reproduced
    const char *motor;
    const char *drive;
    const char *recording; ///< of replay and decode
    const char *separator; ///< between its columns
    const char *header;    ///< line of their names
    const char *data;      ///< line of the first row
    bool resample;         ///< to even PWM periods
    int columns;
    const char *column[OPTIONS_COLUMNS_MAX]; ///< NAME=COLUMN[:UNIT]
    const char *emf;
    const char *pll;
    const char *out;
    const char *csv;
    const char *json;
    const char *source; ///< C constant of the tuning
    const char *plot;
    const char *plots;  ///< folder
    const char *format; ///< of the pictures in it
    const char *kind;   ///< of what is decoded
    const char *kinds;  ///< of faults
    const char *bits;   ///< of faults: random, every, or a range
    const char *place;  ///< of faults: a1 .. c2, set-1 or set-2
    const char *ring;   ///< recorder files of a run
    const char *scope;
    const char *channels;
    const char *every;
    const char *trigger;
    bool json_on_stdout; ///< design --json without a file
    bool has_seed;
    uint64_t seed;
    bool has_load;
    double load;       ///< of faults, share of the torque of i_max
    bool has_campaign; ///< seeds `seed` .. `seed_last`, one line each
    uint64_t seed_last;
    unsigned jobs; ///< processes of a campaign; 0: as many as there are processors
    int sets;
    const char *set[OPTIONS_SETS_MAX];
    const char *test;   ///< of monte-carlo: start, run, fly, quiet, open-phase or merge
    const char *motors; ///< names, separated by commas
    const char *errors; ///< narrow, wide, start or commissioned
    uint64_t cases;     ///< per motor; 0: not given
    uint64_t shard;     ///< 1 .. shards; 0: all
    uint64_t shards;
    int files; ///< to be merged
    const char *file[OPTIONS_FILES_MAX];
} options_t;

/// False after a message.
bool options_parse(options_t *options, int argc, char **argv);

/// The text of --help, for a command or (NULL) for the tool.
void options_print_help(const char *command);

#endif
