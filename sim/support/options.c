#include "support/options.h"

#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/diag.h"
#include "support/workers.h"

enum {
    MAIN_JOB = 1,
    RUN = 2,
    REPLAY = 4,
    DESIGN = 8,
    ANALYSE = 16,
    REPRODUCE = 32,
    DECODE = 64,
    MONTE_CARLO = 128,
    FAULTS = 256,
    COMMISSION = 512
};
enum { CONFIGURED = 63 | MONTE_CARLO | FAULTS | COMMISSION, ALL = 1023 };

enum { CASES_MAX = 10000000 }; // per motor

typedef struct {
    const char *name;
    int argument; ///< argument type of getopt_long
    int letter;   ///< what getopt_long returns
    int commands; ///< the commands that accept it
    const char *example;
    const char *help;
} option_t;

static const option_t table[] = {
    {"motor", required_argument, 'm', RUN | REPLAY | DESIGN | ANALYSE | COMMISSION, "F.ini",
     "motor, and anything else it sets; a file, or a name from `lodestar list`"},
    {"drive", required_argument, 'd', RUN | REPLAY | DESIGN | ANALYSE | COMMISSION, "F.ini",
     "drive, overrides the motor's file; a file, or a name from `lodestar list`"},
    {"recording", required_argument, 'r', REPLAY, "F.csv", "recorded signals (columns: see above)"},
    {"column", required_argument, 'l', REPLAY, "NAME=COLUMN",
     "the column that holds NAME: i_alpha=Ialpha, i_alpha=Ialpha:mA, t=#1; repeatable"},
    {"separator", required_argument, 'b', REPLAY, "NAME",
     "auto, comma, semicolon, tab or blank; with all but comma, decimal commas are read"},
    {"header", required_argument, 'H', REPLAY, "LINE", "line with the column names, or none"},
    {"data", required_argument, 'D', REPLAY, "LINE", "line of the first row"},
    {"resample", no_argument, 'q', REPLAY, "",
     "continues after gaps; resamples uneven or faster rows to one per PWM period"},
    {"emf", required_argument, 'e', REPLAY, "NAME", "EMF observer, as in `lodestar list`"},
    {"pll", required_argument, 'p', REPLAY, "NAME", "position PLL, as in `lodestar list`"},
    {"set", required_argument, 's', CONFIGURED, "SECTION.KEY=VALUE",
     "overrides the files; repeatable"},
    {"motors", required_argument, 'M', MONTE_CARLO, "A,B,...",
     "names of motors that have a drive of the same name, or files with [motor] and\n"
     "                             [drive]; default: the catalogue"},
    {"errors", required_argument, 'X', MONTE_CARLO, "KIND",
     "errors of the drive's parameters: narrow, wide (twice narrow), start, or\n"
     "                             commissioned (narrow, then measured by the drive);\n"
     "                             default: start for the test `start`, else narrow"},
    {"n", required_argument, 'a', MONTE_CARLO, "N", "seeds per motor; default: 200"},
    {"seed", required_argument, 'n', MONTE_CARLO, "S", "first seed; default: 1"},
    {"shard", required_argument, 'P', MONTE_CARLO, "K/N",
     "every N-th case from the K-th on, for K = 1 .. N; `merge` joins the JSON of all N"},
    {"kinds", required_argument, 'K', FAULTS, "A,B,...", "kinds of fault; default: all"},
    {"bits", required_argument, 'B', FAULTS, "WHICH",
     "bits that the kinds flip-... flip: random (16 of them), every, or A-B, numbers of\n"
     "                             bits; lists the silent ones; default: random"},
    {"in", required_argument, 'I', FAULTS, "PLACE",
     "where: a1, b1, c1, a2, b2, c2: the phase of a fault of one phase; default: a1;\n"
     "                             set-1, set-2: sensor faults of all phases are in one set of\n"
     "                             six, those of one phase in its phase a"},
    {"motors", required_argument, 'M', FAULTS, "A,B,...",
     "names of motors that have a drive of the same name, or files with [motor] and\n"
     "                             [drive]; default: jiang2022,eldeeb2017"},
    {"load", required_argument, 'L', FAULTS, "SHARE",
     "load while the motor runs, 0 .. 0.9 of the torque of i_max; in field weakening at\n"
     "                             the same power as at the base speed; default: 0.3, and 0.1\n"
     "                             at 10 % and in field weakening"},
    {"seed", required_argument, 'n', MAIN_JOB | RUN | FAULTS | COMMISSION, "S",
     "seed of the noise and of every other random value"},
    {"seeds", required_argument, 'N', RUN, "A-B", "a campaign: one line per seed, success rate"},
    {"seeds", required_argument, 'N', REPRODUCE, "A-B",
     "seeds of noise and angle over which claims are judged; default: 1-5"},
    {"jobs", required_argument, 'w', RUN | MONTE_CARLO | FAULTS | REPRODUCE, "N",
     "number of parallel processes; default: one per processor"},
    {"out", required_argument, 'o', FAULTS, "F.md", "the tables as a Markdown page"},
    {"out", required_argument, 'o', COMMISSION, "F.ini",
     "motor and drive with the measured values, for `design --motor F.ini`"},
    {"out", required_argument, 'o', REPLAY, "F.csv", "one row of estimates per recorded row"},
    {"csv", required_argument, 'c', MAIN_JOB | RUN, "F.csv", "signals over time"},
    {"ring", required_argument, 'R', RUN, "F.bin", "octets that the telemetry ring would send"},
    {"scope", required_argument, 'S', RUN, "F.bin", "dump of a scope's buffer"},
    {"channels", required_argument, 'C', RUN, "A,B,...", "channels of ring and scope"},
    {"every", required_argument, 'E', RUN, "N", "periods per row of ring and scope; default: 1"},
    {"trigger", required_argument, 'T', RUN, "WHEN",
     "trigger of the scope: fault, immediate, 'CHANNEL>LEVEL' or 'CHANNEL<LEVEL'"},
    {"kind", required_argument, 'k', DECODE, "KIND", "auto, ring or scope"},
    {"csv", required_argument, 'c', DECODE, "F.csv", "one line per row"},
    {"csv", required_argument, 'c', ANALYSE, "F.csv", "the curves of all figures"},
    {"csv", required_argument, 'c', REPRODUCE, "F.csv", "the table"},
    {"json", required_argument, 'j', MAIN_JOB | RUN | REPLAY | ANALYSE | REPRODUCE | FAULTS,
     "F.json", "results and all values used"},
    {"json", required_argument, 'j', MONTE_CARLO, "F.json",
     "{motor, seed, result, cause, max_error_deg} of each case"},
    {"json", required_argument, 'j', DECODE, "F.json", "the summary"},
    {"json", required_argument, 'j', COMMISSION, "F.json", "{name: {value, confidence}}"},
    {"json", optional_argument, 'J', DESIGN, "[=F.json]", "JSON in place of the table"},
    {"c", required_argument, 'x', DESIGN, "F.c",
     "the tuning as a constant in C, named like the file, for the firmware's flash, and\n"
     "                             NAME_config; needs a drive with i_range_A and v_range_V"},
    {"c", required_argument, 'x', COMMISSION, "F.c",
     "tuning and configuration with the measured values in C, as with `design --c`"},
    {"plot", required_argument, 'g', MAIN_JOB | RUN | REPLAY | DECODE, "F.svg",
     "a picture (needs gnuplot); F.png, or F.html: a page with the table"},
    {"plots", required_argument, 'G', ANALYSE | REPRODUCE, "FOLDER",
     "one picture per figure (needs gnuplot)"},
    {"format", required_argument, 'f', ANALYSE | REPRODUCE, "KIND",
     "format of the pictures: svg, png or html (a page with the table)"},
    {"help", no_argument, 'h', ALL, "", "this text"},
};
enum { TABLE_ROWS = sizeof table / sizeof table[0] };

typedef struct {
    const char *name;
    options_command_t command;
    int mask;
    const char *usage;
    const char *what;
} command_t;

static const command_t commands[] = {
    {"list", COMMAND_LIST, 0, "lodestar list",
     "Lists what comes with the tool: motors, drives, plants, scenarios, estimators."},
    {"run", COMMAND_RUN, RUN, "lodestar run SCENARIO.ini | --motor F.ini [OPTION...]",
     "Runs the drive against the simulated motor through the phases of a scenario.\n"
     "SCENARIO.ini is a file, or the name of a scenario that `lodestar list` shows. With --motor "
     "the\n"
     "tool makes a scenario that suits the motor: start, half and full speed, a load and a stop."},
    {"replay", COMMAND_REPLAY, REPLAY,
     "lodestar replay --motor F.ini --recording F.csv [OPTION...]",
     "Runs the firmware's estimator over recorded voltages and currents.\n"
     "Columns, by name: t_s u_alpha_V u_beta_V i_alpha_A i_beta_A, optional theta_e_rad\n"
     "omega_e_rad_s (electrical) or speed_rpm (mechanical). Phases u_a_V u_b_V u_c_V, i_a_A i_b_A\n"
     "i_c_A may replace alpha and beta. Units: s ms us ns, V mV kV, A mA kA, rad deg "
     "turn,\n"
     "rad_s rpm Hz, in the name as in i_alpha_mA, or in --column i_alpha=Ialpha:mA; a number in "
     "place of\n"
     "the unit is a factor. Row k holds the currents AT t_k and the mean voltage over [t_k, "
     "t_k+1).\n"
     "Files from `run --csv` and `decode --csv` need no change if they have one row per period."},
    {"design", COMMAND_DESIGN, DESIGN, "lodestar design --motor F.ini [OPTION...]",
     "Prints every value that follows from a motor and a drive.\n"
     "Gains, bandwidths and limits, the stability of the PLL, the lag of the observer, and the "
     "limit\n"
     "at low speed. Values that are not given are assumed and marked so. The lines at the end say "
     "what\n"
     "to change, and which values are implausible, most often because of a wrong unit."},
    {"analyse", COMMAND_ANALYSE, ANALYSE, "lodestar analyse [OPTION...]",
     "Compares the papers' Bode diagrams, poles and margins with those of the firmware.\n"
     "Then the loops of your drive: observer, PLL, current, speed. Without a motor and a drive,\n"
     "those of paper 1; a motor alone uses its own drive, or one that is assumed."},
    {"reproduce", COMMAND_REPRODUCE, REPRODUCE, "lodestar reproduce PAPER [OPTION...]",
     "Repeats every experiment of a paper and compares its claims with the results.\n"
     "Once with the estimators as printed, once with those of the library and its gains. PAPER is\n"
     "jiang2022 (paper 1) or li-fa-leso (paper 2, six phases). Each takes at most about a minute."},
    {"decode", COMMAND_DECODE, DECODE, "lodestar decode FILE [OPTION...]",
     "Reads what the library's telemetry ring or scope has recorded, sent or dumped.\n"
     "FILE holds the octets of lode_ring_drain() or lode_scope_drain(), or a debugger's dump of a\n"
     "ring's or scope's buffer. Kind and byte order are recognised from the first words."},
    {"faults", COMMAND_FAULTS, FAULTS, "lodestar faults [OPTION...]",
     "Breaks sensors, switches, interrupts, motor and memory, and shows how the drive responds.\n"
     "Tries each kind of fault at standstill, during the start, at 10, 50 and 100 % speed and with "
     "a\n"
     "weakened field. Prints which check finds it and when, the largest current, and how far the "
     "rotor\n"
     "turns back. Exit code 0: no case is silent (something is wrong, but no fault is reported)."},
    {"commission", COMMAND_COMMISSION, COMMISSION,
     "lodestar commission [SCENARIO.ini | --motor F.ini] [OPTION...]",
     "Lets the drive measure the simulated motor and inverter by itself, as it does on a board.\n"
     "Sensors, resistance, dead-time voltage, inductances, flux, inertia and friction, each with "
     "a\n"
     "confidence. [motor] and [drive] are known to the drive before, [plant] is the truth. The "
     "shaft\n"
     "must be free. Exit code 0: everything was measured. Without a scenario or a motor: those of "
     "the\n"
     "main job."},
    {"monte-carlo", COMMAND_MONTE_CARLO, MONTE_CARLO,
     "lodestar monte-carlo start|run|fly|quiet|open-phase [OPTION...]\n"
     "       lodestar monte-carlo merge F.json... [--json F.json]",
     "Runs many motors with wrong parameters in their drives, and counts failures by cause.\n"
     "start: starts from rest at any angle under a load. run: a start, then load steps, changes of "
     "speed\n"
     "and reversals. fly: starts of a rotor that already turns, at 21 speeds. quiet: steady "
     "operation\n"
     "without false trips. open-phase: dead switches and broken wires under load, found within 50 "
     "ms or\n"
     "1.2 electrical turns. merge: joins the parts of one campaign.\n"
     "A case depends only on motor, seed and errors; every failure is printed with the command "
     "that\n"
     "repeats it.\n"
     "Exit code 0 for start, run, fly and open-phase: 97 % of the cases of each motor passed, and "
     "of "
     "all\n"
     "cases 99 %, or 99.9 % with commissioned errors. With wide errors: 95 % of all cases, and "
     "every\n"
     "failure ended in a fault. For quiet: no false trip."},
};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

static const command_t main_job = {NULL, COMMAND_MAIN_JOB, MAIN_JOB, "lodestar [OPTION...]", NULL};

// ---- Help ---------------------------------------------------------------------------------------

static void print_options(int mask) {
    for (int k = 0; k < TABLE_ROWS; ++k) {
        if ((table[k].commands & mask) != 0) {
            const char *gap = table[k].argument == required_argument ? " " : "";
            char left[64];
            (void)snprintf(left, sizeof left, "--%s%s%s", table[k].name, gap, table[k].example);
            (void)printf("  %-26s %s\n", left, table[k].help);
        }
    }
}

static void print_tool_help(void) {
    (void)puts(
        "lodestar: sensorless permanent-magnet motor drives, simulated\n\n"
        "usage: lodestar [OPTION...]             the main job: scenario `main`, with its\n"
        "                                        table, CSV, JSON and plot in lodestar-out/\n"
        "       lodestar COMMAND [OPTION...]\n");
    for (int k = 0; k < COMMANDS; ++k) {
        (void)printf("  %-11s %.*s\n", commands[k].name, (int)strcspn(commands[k].what, "\n"),
                     commands[k].what);
    }
    (void)puts("\noptions of the main job:");
    print_options(MAIN_JOB);
    (void)puts("  --version                  version of library and tool\n\n"
               "More: `lodestar COMMAND --help`. Exit code: 0 done, 1 the drive faulted,\n"
               "missed a bar or never ran, or the decoded file is damaged, 2 bad input.");
}

static const command_t *find_command(const char *name) {
    for (int k = 0; k < COMMANDS; ++k) {
        if (strcmp(commands[k].name, name) == 0) {
            return &commands[k];
        }
    }
    return NULL;
}

void options_print_help(const char *command) {
    const command_t *found = command != NULL ? find_command(command) : NULL;
    if (found == NULL) {
        print_tool_help();
        return;
    }
    (void)printf("usage: %s\n\n%s\n", found->usage, found->what);
    if (found->mask != 0) {
        (void)puts("");
        print_options(found->mask);
    }
}

// ---- Parsing ------------------------------------------------------------------------------------

static bool read_integer(const char *text, char **end, uint64_t *value) {
    errno = 0;
    *value = strtoull(text, end, 10);
    return *end != text && text[0] >= '0' && text[0] <= '9' && errno == 0 &&
           *value <= OPTIONS_SEED_MAX;
}

static bool take_seed(options_t *options, const char *text) {
    char *end = NULL;
    options->has_seed = true;
    if (read_integer(text, &end, &options->seed) && *end == '\0') {
        return true;
    }
    rig_error("--seed %s: expected a whole number, 0 .. 2^53", text);
    return false;
}

static bool take_seeds(options_t *options, const char *text) {
    char *end = NULL;
    options->has_campaign = true;
    const bool first = read_integer(text, &end, &options->seed) && *end == '-';
    if (first && read_integer(end + 1, &end, &options->seed_last) && *end == '\0' &&
        options->seed_last >= options->seed) {
        return true;
    }
    rig_error("--seeds %s: expected two whole numbers up to 2^53, as in 1-20", text);
    return false;
}

static bool take_jobs(options_t *options, const char *text) {
    char *end = NULL;
    uint64_t jobs = 0;
    if (read_integer(text, &end, &jobs) && *end == '\0' && jobs >= 1u && jobs <= WORKERS_MAX) {
        options->jobs = (unsigned)jobs;
        return true;
    }
    rig_error("--jobs %s: expected a whole number, 1 .. %d", text, WORKERS_MAX);
    return false;
}

static bool take_cases(options_t *options, const char *text) {
    char *end = NULL;
    if (read_integer(text, &end, &options->cases) && *end == '\0' && options->cases >= 1u &&
        options->cases <= CASES_MAX) {
        return true;
    }
    rig_error("--n %s: expected a whole number, 1 .. %d", text, CASES_MAX);
    return false;
}

static bool take_load(options_t *options, const char *text) {
    const double most = 0.9; // leaves current for control
    char *end = NULL;
    options->has_load = true;
    options->load = strtod(text, &end);
    if (end != text && *end == '\0' && options->load >= 0.0 && options->load <= most) {
        return true;
    }
    rig_error("--load %s: expected a share of the torque of i_max, 0 .. %g", text, most);
    return false;
}

static bool take_shard(options_t *options, const char *text) {
    char *end = NULL;
    if (read_integer(text, &end, &options->shard) && *end == '/' &&
        read_integer(end + 1, &end, &options->shards) && *end == '\0' && options->shard >= 1u &&
        options->shard <= options->shards) {
        return true;
    }
    rig_error("--shard %s: expected K/N with K from 1 to N, as in 3/8", text);
    return false;
}

static bool take_set(options_t *options, const char *text) {
    if (options->sets == OPTIONS_SETS_MAX) {
        rig_error("--set %s: expected at most %d of them", text, OPTIONS_SETS_MAX);
        return false;
    }
    options->set[options->sets++] = text;
    return true;
}

static bool take_column(options_t *options, const char *text) {
    if (options->columns == OPTIONS_COLUMNS_MAX) {
        rig_error("--column %s: expected at most %d of them", text, OPTIONS_COLUMNS_MAX);
        return false;
    }
    options->column[options->columns++] = text;
    return true;
}

static const char **text_option(options_t *options, int letter) {
    switch (letter) {
    case 'm':
        return &options->motor;
    case 'd':
        return &options->drive;
    case 'r':
        return &options->recording;
    case 'e':
        return &options->emf;
    case 'p':
        return &options->pll;
    case 'o':
        return &options->out;
    case 'c':
        return &options->csv;
    case 'x':
        return &options->source;
    case 'g':
        return &options->plot;
    case 'G':
        return &options->plots;
    case 'f':
        return &options->format;
    case 'k':
        return &options->kind;
    case 'K':
        return &options->kinds;
    case 'I':
        return &options->place;
    case 'B':
        return &options->bits;
    case 'b':
        return &options->separator;
    case 'H':
        return &options->header;
    case 'D':
        return &options->data;
    case 'R':
        return &options->ring;
    case 'S':
        return &options->scope;
    case 'C':
        return &options->channels;
    case 'E':
        return &options->every;
    case 'T':
        return &options->trigger;
    case 'M':
        return &options->motors;
    case 'X':
        return &options->errors;
    case 'j':
    case 'J':
    default:
        return &options->json;
    }
}

static bool take(options_t *options, int letter, const char *argument) {
    switch (letter) {
    case 's':
        return take_set(options, argument);
    case 'l':
        return take_column(options, argument);
    case 'q':
        options->resample = true;
        return true;
    case 'n':
        return take_seed(options, argument);
    case 'N':
        return take_seeds(options, argument);
    case 'w':
        return take_jobs(options, argument);
    case 'L':
        return take_load(options, argument);
    case 'a':
        return take_cases(options, argument);
    case 'P':
        return take_shard(options, argument);
    case 'J':
        options->json_on_stdout = argument == NULL;
        break;
    default:
        break;
    }
    *text_option(options, letter) = argument;
    return true;
}

static void list_options(int mask, char *text, size_t size) {
    text[0] = '\0';
    for (int k = 0; k < TABLE_ROWS; ++k) {
        if ((table[k].commands & mask) != 0) {
            const size_t used = strlen(text);
            (void)snprintf(text + used, size - used, "%s--%s", used > 0 ? ", " : "", table[k].name);
        }
    }
}

static bool refuse_option(const command_t *command, int answer, const char *given) {
    char known[400];
    list_options(command->mask, known, sizeof known);
    if (answer == ':') {
        rig_error("%s: missing value; expected one after the option", given);
    } else if (known[0] == '\0') {
        rig_error("%s: unknown here; %s takes no options", given, command->name);
    } else {
        rig_error("%s: unknown here; expected one of %s", given, known);
    }
    return false;
}

static bool takes_motor(const command_t *command) {
    for (int k = 0; k < TABLE_ROWS; ++k) {
        if (strcmp(table[k].name, "motor") == 0) {
            return (table[k].commands & command->mask) != 0;
        }
    }
    return false;
}

static bool is_repeatable(int letter) {
    return letter == 's' || letter == 'l';
}

static bool parse_options(options_t *options, const command_t *command, int argc, char **argv) {
    bool given[128] = {false}; // by letter
    struct option known[TABLE_ROWS + 1];
    int rows = 0;
    for (int k = 0; k < TABLE_ROWS; ++k) {
        if ((table[k].commands & command->mask) != 0 || table[k].letter == 'h') {
            known[rows++] =
                (struct option){table[k].name, table[k].argument, NULL, table[k].letter};
        }
    }
    known[rows] = (struct option){NULL, 0, NULL, 0};
    opterr = 0;
    optind = 1;
    for (;;) {
        int row = 0;
        const int letter = getopt_long(argc, argv, ":h", known, &row);
        if (letter == -1) {
            return true;
        }
        if (letter == 'h') {
            options->command = COMMAND_HELP;
            options->help_for = command->name;
            return true;
        }
        if (letter == '?' || letter == ':') {
            return refuse_option(command, letter, argv[optind - 1]);
        }
        if (given[letter] && !is_repeatable(letter)) {
            rig_error("--%s: given twice; expected it once", known[row].name);
            return false;
        }
        given[letter] = true;
        if (!take(options, letter, optarg)) {
            return false;
        }
    }
}

static bool needs(const char *command, const char *what, const char *value) {
    if (value == NULL) {
        rig_error("%s: expected %s; see `lodestar %s --help`", command, what, command);
    }
    return value != NULL;
}

/// An option that only modifies another one is refused without that one.
static bool check_beside(const char *option, const char *value, const char *beside, bool there) {
    const bool good = value == NULL || there;
    if (!good) {
        rig_error("--%s: expected only with %s", option, beside);
    }
    return good;
}

static bool check_format(const options_t *options) {
    const char *format = options->format;
    const bool good = format == NULL || strcmp(format, "svg") == 0 || strcmp(format, "png") == 0 ||
                      strcmp(format, "html") == 0;
    if (!good) {
        rig_error("--format %s: expected svg, png or html", format);
    }
    return good && check_beside("format", format, "--plots", options->plots != NULL);
}

static bool check_either(const char *command, const options_t *options) {
    if (options->scenario != NULL && (options->motor != NULL || options->drive != NULL)) {
        rig_error("%s: expected a scenario or --%s, not both: a scenario names its motor and drive",
                  command, options->motor != NULL ? "motor" : "drive");
        return false;
    }
    return true;
}

static bool check_recorders(const options_t *options) {
    const bool any = options->ring != NULL || options->scope != NULL;
    return check_beside("channels", options->channels, "--ring or --scope", any) &&
           check_beside("every", options->every, "--ring or --scope", any) &&
           check_beside("trigger", options->trigger, "--scope", options->scope != NULL);
}

static bool check_run(const options_t *options) {
    return check_recorders(options) &&
           (options->scenario != NULL ||
            needs("run", "a scenario file, or --motor F.ini", options->motor)) &&
           check_either("run", options);
}

static bool check_commission(const options_t *options) {
    return (options->drive == NULL || needs("commission", "--motor F.ini", options->motor)) &&
           check_either("commission", options);
}

static bool check_monte_carlo(const options_t *options) {
    static const char what[] = "start, run, fly, quiet, open-phase, or merge with files";
    if (!needs("monte-carlo", what, options->test)) {
        return false;
    }
    const bool merge = strcmp(options->test, "merge") == 0;
    if (!merge && strcmp(options->test, "start") != 0 && strcmp(options->test, "run") != 0 &&
        strcmp(options->test, "fly") != 0 && strcmp(options->test, "quiet") != 0 &&
        strcmp(options->test, "open-phase") != 0) {
        rig_error("monte-carlo %s: expected %s", options->test, what);
        return false;
    }
    if (merge != (options->files > 0)) {
        rig_error("monte-carlo: expected %s", what);
        return false;
    }
    if (merge && (options->motors != NULL || options->errors != NULL || options->cases > 0u ||
                  options->has_seed || options->shard > 0u || options->sets > 0)) {
        rig_error(
            "monte-carlo merge: expected no option but --json; the rest comes from the files");
        return false;
    }
    const char *errors = options->errors;
    if (errors != NULL && strcmp(errors, "narrow") != 0 && strcmp(errors, "wide") != 0 &&
        strcmp(errors, "start") != 0 && strcmp(errors, "commissioned") != 0) {
        rig_error("--errors %s: expected narrow, wide, start or commissioned", errors);
        return false;
    }
    return true;
}

static bool check(const options_t *options) {
    if (!check_format(options)) {
        return false;
    }
    switch (options->command) {
    case COMMAND_RUN:
        if (options->has_campaign && options->has_seed) {
            rig_error("run: expected --seed or --seeds, not both");
            return false;
        }
        if (options->jobs > 0u && !options->has_campaign) {
            rig_error("--jobs: expected only with --seeds");
            return false;
        }
        return check_run(options);
    case COMMAND_REPLAY:
        return needs("replay", "--motor F.ini", options->motor) &&
               needs("replay", "--recording F.csv", options->recording);
    case COMMAND_DESIGN:
        return needs("design", "--motor F.ini", options->motor);
    case COMMAND_DECODE:
        return needs("decode", "a file", options->recording);
    case COMMAND_MONTE_CARLO:
        return check_monte_carlo(options);
    case COMMAND_COMMISSION:
        return check_commission(options);
    case COMMAND_REPRODUCE:
        return needs("reproduce", "the name of a paper: jiang2022 or li-fa-leso", options->paper);
    case COMMAND_MAIN_JOB:
    case COMMAND_ANALYSE:
    case COMMAND_FAULTS:
    case COMMAND_LIST:
    case COMMAND_HELP:
    case COMMAND_VERSION:
    default:
        return true;
    }
}

static bool take_operands(options_t *options, const command_t *command, int argc, char **argv) {
    int next = optind;
    const bool may_have_scenario =
        command->command == COMMAND_RUN || command->command == COMMAND_COMMISSION;
    if (may_have_scenario && next < argc) {
        options->scenario = argv[next++];
    }
    if (command->command == COMMAND_DECODE && next < argc) {
        options->recording = argv[next++];
    }
    if (command->command == COMMAND_REPRODUCE && next < argc) {
        options->paper = argv[next++];
    }
    if (command->command == COMMAND_MONTE_CARLO && next < argc) {
        options->test = argv[next++];
        while (strcmp(options->test, "merge") == 0 && next < argc &&
               options->files < OPTIONS_FILES_MAX) {
            options->file[options->files++] = argv[next++];
        }
    }
    if (next < argc) {
        const bool is_json = options->json_on_stdout;
        const char *option = is_json ? ", or --json=" : takes_motor(command) ? ", or --motor " : "";
        rig_error("%s: expected no argument here%s%s", argv[next], option,
                  option[0] != '\0' ? argv[next] : "");
        return false;
    }
    return true;
}

bool options_parse(options_t *options, int argc, char **argv) {
    *options = (options_t){.command = COMMAND_MAIN_JOB};
    const bool named = argc > 1 && argv[1][0] != '-';
    if (argc > 1 && strcmp(argv[1], "--version") == 0) {
        options->command = COMMAND_VERSION;
        return true;
    }
    const command_t *command = named ? find_command(argv[1]) : &main_job;
    if (named && strcmp(argv[1], "help") == 0) {
        options->command = COMMAND_HELP;
        options->help_for = argc > 2 ? argv[2] : NULL;
        return true;
    }
    if (command == NULL) {
        rig_error("%s: unknown command; expected list, run, replay, design, analyse, "
                  "reproduce, decode, faults, commission or monte-carlo",
                  argv[1]);
        return false;
    }
    options->command = command->command;
    const int skip = named ? 1 : 0;
    if (!parse_options(options, command, argc - skip, argv + skip)) {
        return false;
    }
    return options->command == COMMAND_HELP ||
           (take_operands(options, command, argc - skip, argv + skip) && check(options));
}
