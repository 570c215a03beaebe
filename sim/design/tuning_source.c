#include "design/tuning_source.h"

#include <ctype.h>
#include <string.h>

#include "config/assumptions.h"
#include "design/config_source.h"
#include "design/tuning_fields.h"
#include "lodestar/version.h"
#include "support/diag.h"

// Keywords of C99, C11 and C23, and main.
static const char *const words[] = {
    "auto",    "break",  "case",          "char",   "const",    "continue",      "default",
    "do",      "double", "else",          "enum",   "extern",   "float",         "for",
    "goto",    "if",     "inline",        "int",    "long",     "register",      "restrict",
    "return",  "short",  "signed",        "sizeof", "static",   "struct",        "switch",
    "typedef", "union",  "unsigned",      "void",   "volatile", "while",         "alignas",
    "alignof", "bool",   "constexpr",     "false",  "nullptr",  "static_assert", "thread_local",
    "true",    "typeof", "typeof_unqual", "asm",    "main",
};

// Functions of <math.h>, which the library's headers include; also with the suffixes f and l.
static const char *const functions[] = {
    "acos",        "asin",        "atan",
    "atan2",       "cos",         "sin",
    "tan",         "acosh",       "asinh",
    "atanh",       "cosh",        "sinh",
    "tanh",        "exp",         "exp2",
    "expm1",       "frexp",       "ilogb",
    "ldexp",       "log",         "log10",
    "log1p",       "log2",        "logb",
    "modf",        "scalbn",      "scalbln",
    "cbrt",        "fabs",        "hypot",
    "pow",         "sqrt",        "erf",
    "erfc",        "lgamma",      "tgamma",
    "ceil",        "floor",       "nearbyint",
    "rint",        "lrint",       "llrint",
    "round",       "lround",      "llround",
    "trunc",       "fmod",        "remainder",
    "remquo",      "copysign",    "nan",
    "nextafter",   "nexttoward",  "fdim",
    "fmax",        "fmin",        "fma",
    "gamma",       "j0",          "j1",
    "jn",          "y0",          "y1",
    "yn",          "fpclassify",  "isfinite",
    "isinf",       "isnan",       "isnormal",
    "signbit",     "isgreater",   "isgreaterequal",
    "isless",      "islessequal", "islessgreater",
    "isunordered",
};

static bool begins_with(const char *name, const char *with) {
    return strncmp(name, with, strlen(with)) == 0;
}

static bool is_of_math(const char *name) {
    const size_t length = strlen(name);
    const bool suffixed = length > 1u && (name[length - 1u] == 'f' || name[length - 1u] == 'l');
    bool found = false;
    for (size_t k = 0u; k < sizeof functions / sizeof functions[0]; ++k) {
        const bool same = strlen(functions[k]) == length - 1u && begins_with(name, functions[k]);
        found = found || strcmp(name, functions[k]) == 0 || (suffixed && same);
    }
    return found;
}

/// True for a name that C, its standard library or this library already uses.
static bool is_taken(const char *name) {
    const size_t length = strlen(name);
    const bool type = length > 2u && strcmp(name + length - 2u, "_t") == 0;
    bool taken = name[0] == '_' || begins_with(name, "lode_") || begins_with(name, "LODE_") ||
                 is_of_math(name);
    taken = taken || (type && (begins_with(name, "int") || begins_with(name, "uint") ||
                               strcmp(name, "float_t") == 0 || strcmp(name, "double_t") == 0));
    for (size_t k = 0u; k < sizeof words / sizeof words[0]; ++k) {
        taken = taken || strcmp(name, words[k]) == 0;
    }
    return taken;
}

bool tuning_source_name(char *name, size_t size, const char *path) {
    const char *slash = strrchr(path, '/');
    const char *first = slash != NULL ? slash + 1 : path;
    const size_t length = strcspn(first, ".");
    bool good = length > 0u && length < size && isdigit((unsigned char)first[0]) == 0;
    for (size_t k = 0u; good && k < length; ++k) {
        good = isalnum((unsigned char)first[k]) != 0 || first[k] == '_';
    }
    if (!good) {
        rig_error("--c %s: expected a file whose name without extension is a C identifier", path);
        return false;
    }
    (void)snprintf(name, size, "%.*s", (int)length, first);
    if (is_taken(name)) {
        rig_error(
            "--c %s: the constant would be called %s; expected a file whose name without extension "
            "is free in C: no keyword, not main, nothing of <math.h> or <stdint.h>, nothing that "
            "begins with an "
            "underscore, lode_ or LODE_",
            path, name);
        return false;
    }
    return true;
}

// Hexadecimal: every compiler reads exactly the same float.
#define PRINT_FLOAT(type, member)                                                                  \
    (void)fprintf(file, "    .%s" #member " = %af, // %.9g\n", path, (double)tuning->member,       \
                  (double)tuning->member);
#define PRINT_WHOLE(type, member)                                                                  \
    (void)fprintf(file, "    .%s" #member " = %luu,\n", path, (unsigned long)tuning->member);
#define PRINT_INTEGER(type, member)                                                                \
    (void)fprintf(file, "    .%s" #member " = %ld,\n", path, (long)tuning->member);
// Only as many numbers as the observer has: a firmware with fewer observers has no room for more.
#define PRINT_OBSERVER(place, member)                                                              \
    if ((place) < numbers_of[tuning->estimator.emf.observer.kind]) {                               \
        PRINT_FLOAT(float, member)                                                                 \
    }
#define PRINT(kind, type, member)                                                                  \
    print_option(file, #member, true);                                                             \
    PRINT_##kind(type, member) print_option(file, #member, false);

typedef struct {
    const char *place, *option;
} option_t;

// True for a member, or for a member of it.
static bool is_within(const char *member, const char *place) {
    const size_t length = strlen(place);
    return begins_with(member, place) && (member[length] == '\0' || member[length] == '.');
}

// Members that are missing in a build without their option.
static void print_option(FILE *file, const char *member, bool begins) {
#define OPTION_ROW(place, option) {place, option},
    static const option_t options[] = {TUNING_OPTIONS(OPTION_ROW)};
    for (size_t k = 0u; k < sizeof options / sizeof options[0]; ++k) {
        if (!is_within(member, options[k].place)) {
            continue;
        }
        if (begins) {
            (void)fprintf(file, "#ifndef LODE_WITHOUT_%s\n", options[k].option);
        } else {
            (void)fputs("#endif\n", file);
        }
    }
}

// For a file that is compiled with the options of the library.
#define UNLESS(feature)                                                                            \
    "#ifdef LODE_WITHOUT_" feature "\n"                                                            \
    "#error \"needs what LODE_WITHOUT_" feature " leaves out\"\n"                                  \
    "#endif\n"

static const int numbers_of[] = {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) numbers,
#include "lodestar/observers.def"
#undef LODE_OBSERVER
};

static const char *const option_of[] = {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) UNLESS(#ID),
#include "lodestar/observers.def"
#undef LODE_OBSERVER
};

/// What a tuning needs that a build may have left out.
typedef struct {
    bool used;
    const char *text;
} need_t;

enum { NEEDS = 8 };

static void add_needs(need_t needs[NEEDS], const lode_drive_tuning_t *tuning) {
    const need_t own[NEEDS] = {
        {tuning->sense.two_shunts != 0u || tuning->sense.duty_max < 1.0f, UNLESS("SHUNT_WINDOW")},
        {(tuning->references.options & (uint32_t)LODE_REFERENCES_WEAKEN) != 0u,
         UNLESS("FIELD_WEAKENING")},
        {tuning->references.options != 0u, UNLESS("OPTIMAL_REFERENCES")},
        {(tuning->estimator.options & (uint32_t)LODE_ESTIMATOR_NOTCH) != 0u, UNLESS("NOTCH")},
        {tuning->estimator.hfi.find_rounds > 0u, UNLESS("HFI")},
        {tuning->speed_periods != LODE_SLOW_PERIODS, UNLESS("FAST_SPEED")},
        {tuning->speed.jerk_step > 0.0f, UNLESS("SHAPED_RAMP")},
        {tuning->inverter.precharge_periods > 0u, UNLESS("PRECHARGE")},
    };
    for (int k = 0; k < NEEDS; ++k) {
        needs[k].used = needs[k].used || own[k].used;
        needs[k].text = own[k].text;
    }
}

static void print_guards(FILE *file, const lode_drive6_tuning_t *tuning, bool six) {
    need_t needs[NEEDS] = {{false, NULL}};
    add_needs(needs, &tuning->drive);
    if (six) {
        add_needs(needs, &tuning->alone); // other inductances may have other references
    }
    (void)fprintf(file,
                  "#if LODE_VERSION_MAJOR != %d || LODE_VERSION_MINOR != %d || "
                  "LODE_VERSION_PATCH != %d\n"
                  "#error \"written for another version of Lodestar; write this file again\"\n"
                  "#endif\n",
                  LODE_VERSION_MAJOR, LODE_VERSION_MINOR, LODE_VERSION_PATCH);
    (void)fputs(option_of[tuning->drive.estimator.emf.observer.kind], file);
    for (int k = 0; k < NEEDS; ++k) {
        if (needs[k].used) {
            (void)fputs(needs[k].text, file);
        }
    }
}

/// `path`: what the designators have before the member.
static void print_members(FILE *file, const char *path, const lode_drive_tuning_t *tuning) {
    TUNING_FIELDS(PRINT)
}

static void print_members_of_six(FILE *file, const lode_drive6_tuning_t *tuning) {
    const char *path = "";
    print_members(file, "drive.", &tuning->drive);
    print_members(file, "alone.", &tuning->alone);
    TUNING6_FIELDS(PRINT)
}

void tuning_source_print(FILE *file, const char *name, const lode_drive6_tuning_t *tuning,
                         const rig_config_t *config, const char *from) {
    const bool six = rig_config_is_six(config);
    const char *drive = six ? "drive6" : "drive";
    (void)fputs("// Written by ", file);
    for (const char *at = from; *at != '\0'; ++at) {
        (void)fputc((unsigned char)*at < ' ' ? ' ' : *at,
                    file); // a line break in the text would end the comment
    }
    (void)fprintf(file,
                  ". C, not C++.\n"
                  "// lode_%s_begin(&drive, &%s) takes the place of lode_%s_init(&drive, &tuning, "
                  "&%s_config).\n",
                  drive, name, drive, name);
    assumptions_print(file, config, "// ");
    (void)fputs("// assumed: currents that read positive, and a temperature sensor with -50 degC "
                "at count 0 and a span "
                "of 200 degC.\n"
                "// A board with others, or without a sensor: lode_drive_init() with `sense` "
                "changed in a copy of the "
                "configuration.\n",
                file);
    (void)fprintf(file,
                  "#include \"lodestar/%s.h\"\n"
                  "#include \"lodestar/version.h\"\n\n",
                  drive);
    print_guards(file, tuning, six);
    (void)fprintf(file,
                  "\nextern const lode_%s_tuning_t %s;\n"
                  "const lode_%s_tuning_t %s = {\n",
                  drive, name, drive, name);
    if (six) {
        print_members_of_six(file, tuning);
    } else {
        print_members(file, "", &tuning->drive);
    }
    (void)fputs("};\n\n", file);
    config_source_print(file, name, config);
}
