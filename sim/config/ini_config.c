#include "config/ini_config.h"

#include <errno.h>
#include <ini.h>
#include <stdio.h>
#include <string.h>

#include "config/schema.h"
#include "support/diag.h"
#include "support/inputs.h"
#include "support/units.h"

/// Which keys of a file are applied.
typedef enum {
    PASS_PARTS,   ///< a scenario: only the names of its files
    PASS_PART,    ///< such a file: all keys, but no scenario
    PASS_SCENARIO ///< a scenario: all keys
} pass_t;

typedef struct {
    rig_config_t *config;
    FILE *stream;
    const char *path;
    pass_t pass;
    int file;       ///< index into config->file
    int order;      ///< of rig_origin_t
    int line;       ///< current line
    bool line_done; ///< the last piece read ended its line
    /// the current section has a key: a line that begins with a blank continues its value
    bool has_key;
    bool failed; ///< a message was printed
} source_t;

static const char *const part_sections[] = {"motor", "drive", "plant"};

static void complain(source_t *source, const char *section, const char *key, const char *text) {
    if (!source->failed) {
        const bool named = section[0] != '\0';
        rig_error_at(source->path, source->line, "%s%s%s%s: %s", named ? "[" : "", section,
                     named ? "] " : "", key, text);
    }
    source->failed = true;
}

// ---- One value, from a file or the command line -------------------------------------------------

static void complain_of_value(source_t *source, const char *section, const char *key,
                              const char *value, const char *expected) {
    char text[768];
    (void)snprintf(text, sizeof text, "%s, not '%.60s'%s", expected, value,
                   strchr(value, '#') != NULL ? "; comments begin with ;" : "");
    complain(source, section, key, text);
}

static rig_phase_t *find_phase(rig_scenario_t *scenario, const char *name) {
    for (int k = 0; k < scenario->phases; ++k) {
        if (strcmp(scenario->phase[k].name, name) == 0) {
            return &scenario->phase[k];
        }
    }
    return NULL;
}

static rig_phase_t *add_phase(rig_scenario_t *scenario, const char *name) {
    if (scenario->phases == RIG_PHASES_MAX || strlen(name) >= RIG_NAME_LENGTH || name[0] == '\0') {
        return NULL;
    }
    rig_phase_t *phase = &scenario->phase[scenario->phases++];
    (void)snprintf(phase->name, sizeof phase->name, "%s", name);
    return phase;
}

static void unknown_key(source_t *source, rig_schema_t schema, const char *table,
                        const char *section, const char *key) {
    char list[1024];
    char guess[128] = "";
    char text[1280];
    const int meant = rig_schema_guess(schema, table, key);
    if (meant >= 0) {
        (void)snprintf(guess, sizeof guess, "did you mean [%s] %s? Otherwise ",
                       schema.row[meant].section, schema.row[meant].key);
    }
    rig_schema_expected(schema, table, list, sizeof list);
    (void)snprintf(text, sizeof text, "%s; %sexpected one of %s",
                   section[0] == '\0' ? "stands before the first [section]" : "unknown", guess,
                   list);
    complain(source, section, key, text);
}

/// True if this same source has already given the key.
static bool is_duplicate(source_t *source, const char *section, const char *key, int earlier_line) {
    if (source->line == 0 || earlier_line == 0) {
        return false;
    }
    char text[80];
    (void)snprintf(text, sizeof text, "given twice, first in line %d; expected it once",
                   earlier_line);
    complain(source, section, key, text);
    return true;
}

/// Reports a phase that cannot be added, or that does not exist on the command line.
static void complain_of_phase(source_t *source, const char *section, const char *key) {
    const rig_scenario_t *scenario = &source->config->scenario;
    char text[RIG_PHASES_MAX * (RIG_NAME_LENGTH + 2) + 80];
    if (source->line > 0) {
        complain(source, section, key,
                 "expected at most 48 phases, with names of 1 to 31 characters");
        return;
    }
    (void)snprintf(text, sizeof text, "%s",
                   scenario->phases > 0 ? "expected the name of a phase of the scenario: "
                                        : "expected no phase, there is no scenario here");
    for (int k = 0; k < scenario->phases; ++k) {
        const size_t used = strlen(text);
        (void)snprintf(text + used, sizeof text - used, "%s%s", k > 0 ? ", " : "",
                       scenario->phase[k].name);
    }
    complain(source, section, key, text);
}

static void take_phase_value(source_t *source, const char *section, const char *key,
                             const char *value) {
    const rig_schema_t schema = rig_phase_schema();
    rig_scenario_t *scenario = &source->config->scenario;
    const char *name = section + strlen("phase.");
    rig_phase_t *phase = find_phase(scenario, name);
    if (phase == NULL && source->line > 0) {
        phase = add_phase(scenario, name);
    }
    if (phase == NULL) {
        complain_of_phase(source, section, key);
        return;
    }
    const int row = rig_schema_find(schema, "phase", key);
    if (row < 0) {
        unknown_key(source, schema, "phase", section, key);
        return;
    }
    char expected[256];
    if (is_duplicate(source, section, key, phase->line[row])) {
        return;
    }
    if (!rig_key_assign(&schema.row[row], phase, value, expected, sizeof expected)) {
        complain_of_value(source, section, key, value, expected);
        return;
    }
    phase->line[row] = source->line;
}

static void take_value(source_t *source, const char *section, const char *key, const char *value) {
    const rig_schema_t schema = rig_schema();
    const int row = rig_schema_find(schema, section, key);
    if (row < 0) {
        unknown_key(source, schema, section, section, key);
        return;
    }
    rig_origin_t *origin = &source->config->origin[row];
    if (origin->file == source->file && is_duplicate(source, section, key, origin->line)) {
        return;
    }
    char expected[640];
    if (!rig_key_assign(&schema.row[row], source->config, value, expected, sizeof expected)) {
        complain_of_value(source, section, key, value, expected);
        return;
    }
    *origin = (rig_origin_t){.file = source->file, .line = source->line, .order = source->order};
}

// ---- Files --------------------------------------------------------------------------------------

static bool is_part_key(const char *section, const char *key) {
    bool found = false;
    for (size_t k = 0; k < sizeof part_sections / sizeof part_sections[0]; ++k) {
        found = found || strcmp(key, part_sections[k]) == 0;
    }
    return found && strcmp(section, "scenario") == 0;
}

static int on_value(void *user, const char *section, const char *key, const char *value) {
    source_t *source = user;
    source->has_key = true;
    const bool is_phase = strncmp(section, "phase.", strlen("phase.")) == 0;
    if (source->pass == PASS_PARTS) {
        if (is_part_key(section, key)) {
            take_value(source, section, key, value);
        }
        return 1;
    }
    if (source->pass == PASS_PART && (is_phase || strcmp(section, "scenario") == 0)) {
        complain(source, section, key, "expected in a scenario file only");
        return 1;
    }
    if (source->pass == PASS_SCENARIO && is_part_key(section, key)) {
        return 1; // already applied
    }
    if (is_phase) {
        take_phase_value(source, section, key, value);
    } else {
        take_value(source, section, key, value);
    }
    return 1;
}

/// inih accepts a [section without its ] and then reports only the keys in it.
static void check_section(source_t *source, const char *line) {
    static const char mark[] = "\xEF\xBB\xBF"; // UTF-8
    const size_t marked = source->line == 1 && strncmp(line, mark, strlen(mark)) == 0 ? 3u : 0u;
    const char *start = line + marked + strspn(line + marked, " \t");
    if (start[0] != '[' || (start != line + marked && source->has_key)) {
        return;
    }
    const size_t length = strcspn(start, "]\r\n");
    const char *comment = strstr(start, " ;");
    source->has_key = false;
    if (start[length] != ']' || (comment != NULL && comment < start + length)) {
        rig_error_at(source->path, source->line,
                     "expected a ] after the name of the section, not '%.*s'",
                     (int)(length < 60u ? length : 60u), start);
        source->failed = true;
    }
}

/// A carriage return with text after it: the end of a line on old systems.
static bool has_lone_return(const char *line) {
    const char *end = strchr(line, '\r');
    return end != NULL && end[strspn(end, "\r\n")] != '\0';
}

/// Feeds inih line by line and counts the lines, because inih does not give a handler the line number.
static char *next_line(char *text, int size, void *user) {
    source_t *source = user;
    if (!source->line_done && !source->failed) {
        rig_error_at(source->path, source->line, "expected lines of at most %d characters",
                     size - 3);
        source->failed = true;
    }
    if (source->failed) {
        return NULL;
    }
    char *line = fgets(text, size, source->stream);
    if (line != NULL) {
        source->line += 1;
        source->line_done = strchr(line, '\n') != NULL || feof(source->stream) != 0;
    }
    if (line != NULL && !source->line_done && strlen(line) + 1u < (size_t)size) {
        rig_error_at(source->path, source->line,
                     "a zero octet; expected text in UTF-8 or ASCII (not UTF-16)");
        source->failed = true;
    }
    if (line != NULL && !source->failed && has_lone_return(line)) {
        rig_error_at(source->path, source->line,
                     "a carriage return within the line; expected lines that end with a line feed "
                     "(LF, or CR and LF), not with a carriage return alone");
        source->failed = true;
    }
    if (line != NULL && !source->failed) {
        check_section(source, line);
    }
    return source->failed ? NULL : line;
}

static bool parse(source_t *source) {
    source->stream = inputs_open(source->path);
    if (source->stream == NULL) {
        rig_error_at(source->path, 0,
                     "%s; expected an INI file, or a name that `lodestar list` shows",
                     strerror(errno));
        return false;
    }
    const int wrong_line = ini_parse_stream(next_line, source, on_value, source);
    const bool unreadable = ferror(source->stream) != 0;
    (void)fclose(source->stream);
    if (unreadable && !source->failed) {
        rig_error_at(source->path, 0, "cannot be read; expected an INI file");
    } else if (wrong_line != 0 && !source->failed) {
        rig_error_at(source->path, wrong_line, "expected `[section]`, `key = value` or a comment");
    }
    return !source->failed && !unreadable && wrong_line == 0;
}

static bool open_source(source_t *source, rig_config_t *config, const char *path, pass_t pass) {
    *source =
        (source_t){.config = config, .pass = pass, .line_done = true, .order = ++config->readings};
    for (int k = 0; k < config->files; ++k) {
        if (strcmp(config->file[k], path) == 0) {
            source->file = k;
            source->path = config->file[k];
            return true;
        }
    }
    if (config->files == RIG_FILES_MAX || strlen(path) >= RIG_PATH_LENGTH) {
        rig_error_at(path, 0, "expected at most %d files with paths of at most %d characters",
                     RIG_FILES_MAX, RIG_PATH_LENGTH - 1);
        return false;
    }
    source->file = config->files++;
    source->path = config->file[source->file];
    (void)snprintf(config->file[source->file], RIG_PATH_LENGTH, "%s", path);
    return true;
}

static bool load(rig_config_t *config, const char *path, pass_t pass) {
    source_t source;
    return open_source(&source, config, path, pass) && parse(&source);
}

bool ini_config_load_part(rig_config_t *config, const char *path) {
    for (int k = 0; k < config->files; ++k) {
        if (strcmp(config->file[k], path) == 0) {
            return true;
        }
    }
    return load(config, path, PASS_PART);
}

bool ini_config_relative(const char *from, const char *name, char *path, size_t size) {
    const char *slash = strrchr(from, '/');
    const int folder = slash == NULL || name[0] == '/' ? 0 : (int)(slash - from) + 1;
    const int length = snprintf(path, size, "%.*s%s", folder, from, name);
    return length >= 0 && (size_t)length < size;
}

static bool load_named_part(rig_config_t *config, const char *scenario, const char *section) {
    const rig_schema_t schema = rig_schema();
    const int row = rig_schema_find(schema, "scenario", section);
    if (config->origin[row].file < 0) {
        return true;
    }
    char name[RIG_PATH_LENGTH];
    char path[RIG_PATH_LENGTH];
    rig_key_print(&schema.row[row], config, name, sizeof name);
    FILE *found = ini_config_relative(scenario, name, path, sizeof path) ? inputs_open(path) : NULL;
    if (found == NULL) {
        rig_error_at(
            scenario, config->origin[row].line,
            "[scenario] %s: expected the path of an INI file, relative to this one; %s: %s",
            section, name, strerror(errno));
        return false;
    }
    (void)fclose(found);
    return ini_config_load_part(config, path);
}

bool ini_config_load_scenario(rig_config_t *config, const char *path) {
    bool good = load(config, path, PASS_PARTS);
    for (size_t k = 0; good && k < sizeof part_sections / sizeof part_sections[0]; ++k) {
        good = load_named_part(config, path, part_sections[k]);
    }
    return good && load(config, path, PASS_SCENARIO);
}

// ---- Command line -------------------------------------------------------------------------------

bool ini_config_set(rig_config_t *config, const char *option, const char *assignment) {
    source_t source = {.config = config,
                       .path = option,
                       .pass = PASS_SCENARIO,
                       .file = -1,
                       .order = RIG_ORDER_SET};
    char copy[RIG_PATH_LENGTH];
    const int length = snprintf(copy, sizeof copy, "%s", assignment);
    char *equals = strchr(copy, '=');
    if (length < 0 || (size_t)length >= sizeof copy || equals == NULL) {
        rig_error("%s %s: expected section.key=value", option, assignment);
        return false;
    }
    *equals = '\0';
    char *dot = strrchr(copy, '.');
    if (dot == NULL) {
        rig_error("%s %s: expected section.key=value", option, assignment);
        return false;
    }
    *dot = '\0';
    if (is_part_key(copy, dot + 1)) {
        complain(&source, copy, dot + 1, "expected in a scenario file only");
    } else if (strncmp(copy, "phase.", strlen("phase.")) == 0) {
        take_phase_value(&source, copy, dot + 1, equals + 1);
    } else {
        take_value(&source, copy, dot + 1, equals + 1);
    }
    return !source.failed;
}

void ini_config_override(rig_config_t *config, const char *section, const char *key,
                         const char *value) {
    char unused[640];
    const rig_schema_t schema = rig_schema();
    const int row = rig_schema_find(schema, section, key);
    (void)rig_key_assign(&schema.row[row], config, value, unused, sizeof unused);
    config->origin[row] = (rig_origin_t){.file = -1, .line = 0, .order = RIG_ORDER_SET + 1};
}

// ---- Display ------------------------------------------------------------------------------------

void ini_config_value(const rig_config_t *config, int row, char *text, size_t size) {
    const rig_schema_t schema = rig_schema();
    const rig_key_t *key = &schema.row[row];
    double number = 0.0;
    const bool known = rig_key_number(key, config, &number);
    if (!known && key->offset == offsetof(rig_config_t, people.speed_rated_rpm)) {
        const lode_motor_t *motor = &config->drive.motor;
        number = rig_rpm_from_rad_s((double)motor->omega_rated_rad_s / (double)motor->pole_pairs);
        (void)snprintf(text, size, "%.6g", number);
    } else {
        rig_key_print(key, config, text, size);
    }
}

/// What a field that the design leaves open stands for; empty for all others.
static const char *open_field(const rig_config_t *config, size_t offset) {
    const lode_drive_config_t *drive = &config->drive;
    lode_drive_tuning_t tuning;
    if (offset == offsetof(rig_config_t, drive.inverter.double_update)) {
        return drive->inverter.double_update == LODE_AUTO ? ": off" : "";
    }
    if (offset == offsetof(rig_config_t, drive.speed.ramp_down_rad_s2)) {
        return drive->speed.ramp_down_rad_s2 > 0.0f ? "" : ": as ramp_rad_s2";
    }
    const bool pulses = offset == offsetof(rig_config_t, drive.start.pulses);
    const bool check = offset == offsetof(rig_config_t, drive.start.signal_check);
    if (!(pulses && drive->start.pulses == LODE_AUTO) &&
        !(check && drive->start.signal_check == LODE_AUTO)) {
        return "";
    }
    if (lode_drive_tune(&tuning, drive) != LODE_OK) {
        return "";
    }
    return (pulses ? tuning.fly.share_first > 0.0f : tuning.signal_check.pulses > 0u) ? ": on"
                                                                                      : ": off";
}

void ini_config_where(const rig_config_t *config, int row, char *text, size_t size) {
    const rig_origin_t *origin = &config->origin[row];
    const char *gap = origin->instead != NULL ? ": " : "";
    const char *key = origin->instead != NULL ? origin->instead : "";
    if (origin->measured) {
        (void)snprintf(text, size, "measured");
    } else if (origin->file >= 0 && origin->line == 0) {
        (void)snprintf(text, size, "from %s", config->file[origin->file]);
    } else if (origin->file >= 0) {
        (void)snprintf(text, size, "%s:%d%s%s", config->file[origin->file], origin->line, gap, key);
    } else if (origin->line == 0) {
        (void)snprintf(text, size, "command line%s%s", gap, key);
    } else if (origin->assumed != NULL) {
        (void)snprintf(text, size, "assumed: %s", origin->assumed);
    } else {
        (void)snprintf(text, size, "default or computed%s",
                       open_field(config, rig_schema().row[row].offset));
    }
}

void ini_config_title(const char *path, char *text, size_t size) {
    text[0] = '\0';
    FILE *file = inputs_open(path);
    if (file == NULL) {
        return;
    }
    char line[512];
    if (fgets(line, sizeof line, file) != NULL && (line[0] == ';' || line[0] == '#')) {
        const size_t skip = strspn(line, ";# \t");
        (void)snprintf(text, size, "%.*s", (int)strcspn(line + skip, "\r\n"), line + skip);
    }
    (void)fclose(file);
}
