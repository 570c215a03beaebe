#include "config/schema.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

int rig_schema_find(rig_schema_t schema, const char *section, const char *key) {
    for (int k = 0; k < schema.rows; ++k) {
        if (strcmp(schema.row[k].section, section) == 0 && strcmp(schema.row[k].key, key) == 0) {
            return k;
        }
    }
    return -1;
}

static void append(char *text, size_t size, const char *more) {
    const size_t used = strlen(text);
    (void)snprintf(text + used, size - used, "%s%s", used > 0 ? ", " : "", more);
}

static bool first_of_section(rig_schema_t schema, int row) {
    return row == 0 || strcmp(schema.row[row].section, schema.row[row - 1].section) != 0;
}

void rig_schema_expected(rig_schema_t schema, const char *section, char *text, size_t size) {
    text[0] = '\0';
    for (int k = 0; k < schema.rows; ++k) {
        if (strcmp(schema.row[k].section, section) == 0) {
            append(text, size, schema.row[k].key);
        }
    }
    if (text[0] != '\0') {
        return;
    }
    for (int k = 0; k < schema.rows; ++k) {
        if (first_of_section(schema, k)) {
            append(text, size, schema.row[k].section);
        }
    }
    append(text, size, "phase.NAME");
}

// Digits that survive the conversion to a float, and digits that any double needs.
enum { DIGITS_LEAST = FLT_DIG, DIGITS_MOST = DBL_DIG + 2 };

#define GUESS_LENGTH 64
// Likeness of two names, 0 .. 1, above which one may be a misspelling of the other.
#define LIKENESS 0.6

/// Likeness of two names: the share of their letters in the longest common subsequence.
static double likeness(const char *a, const char *b) {
    const size_t m = strlen(a), n = strlen(b);
    size_t common[GUESS_LENGTH + 1] = {
        0}; // length for the letters of a so far, by the letters of b
    if (m + n == 0 || n > GUESS_LENGTH) {
        return 0.0;
    }
    for (size_t j = 0; j < m; ++j) {
        size_t before = 0;
        for (size_t k = 1; k <= n; ++k) {
            const size_t without = common[k];
            const size_t longer = common[k] > common[k - 1] ? common[k] : common[k - 1];
            common[k] = a[j] == b[k - 1] ? before + 1 : longer;
            before = without;
        }
    }
    return 2.0 * (double)common[n] / (double)(m + n);
}

/// True if it is the name without its unit, in letters of either case.
static bool lacks_unit(const char *key, const char *name) {
    const size_t length = strlen(key);
    return length > 0 && strncasecmp(key, name, length) == 0 && name[length] == '_';
}

int rig_schema_guess(rig_schema_t schema, const char *section, const char *key) {
    int best = -1;
    double most = LIKENESS;
    for (int k = 0; k < schema.rows; ++k) {
        const rig_key_t *row = &schema.row[k];
        const bool here = strcmp(row->section, section) == 0;
        if (strcmp(row->key, key) == 0 || (here && lacks_unit(key, row->key))) {
            return k;
        }
        const double like = likeness(key, row->key);
        if (here && like >= most) {
            best = k;
            most = like;
        }
    }
    return best;
}

/// A finite number and nothing else.
static bool read_number(const char *text, double *value) {
    char *end = NULL;
    errno = 0;
    *value = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*value);
}

static void store(void *object, size_t offset, const void *value, size_t size) {
    memcpy((char *)object + offset, value, size);
}

/// The value of a word for this kind of key; false if the key does not accept the word.
static bool read_word(rig_key_kind_t kind, const char *value, float *result) {
    if (kind == RIG_KEY_FLOAT_OR_NONE && strcmp(value, "none") == 0) {
        *result = LODE_NONE;
        return true;
    }
    *result = 0.0f;
    return kind != RIG_KEY_GIVEN && strcmp(value, "auto") == 0;
}

static bool assign_float(const rig_key_t *key, void *object, const char *value, char *expected,
                         size_t size) {
    const char *words = key->kind == RIG_KEY_FLOAT ? " or auto" : ", auto or none";
    float result = 0.0f;
    if (!read_word(key->kind, value, &result)) {
        double number = 0.0;
        const bool read = read_number(value, &number);
        result = (float)number;
        // A magnitude that a float cannot hold would turn into infinity or into `auto`.
        if (!read || !isfinite(result) || (result == 0.0f && number != 0.0)) {
            (void)snprintf(expected, size, "expected a finite number%s",
                           key->kind == RIG_KEY_GIVEN ? "" : words);
            return false;
        }
        if (key->kind == RIG_KEY_FLOAT_OR_NONE && result == 0.0f) {
            result = LODE_NONE;
        }
    }
    store(object, key->offset, &result, sizeof result);
    return true;
}

static bool assign_double(const rig_key_t *key, void *object, const char *value, char *expected,
                          size_t size) {
    double number = 0.0;
    if (key->kind == RIG_KEY_DOUBLE_OR && strcmp(value, key->names) == 0) {
        number = RIG_RANDOM;
    } else if (!read_number(value, &number) || number < key->lo || number > key->hi) {
        const bool has_word = key->kind == RIG_KEY_DOUBLE_OR;
        (void)snprintf(expected, size, "expected a number in %g .. %g%s%s", key->lo, key->hi,
                       has_word ? " or " : "", has_word ? key->names : "");
        return false;
    }
    store(object, key->offset, &number, sizeof number);
    return true;
}

/// Index of `name` among names separated by '|', -1: not among them.
static int index_of(const char *names, const char *name) {
    const size_t length = strlen(name);
    int index = 0;
    for (const char *at = names; at != NULL; ++index) {
        const size_t span = strcspn(at, "|");
        if (length > 0 && span == length && strncmp(at, name, length) == 0) {
            return index;
        }
        at = at[span] == '|' ? at + span + 1 : NULL;
    }
    return -1;
}

/// The list for messages: commas, and an `or` before the last name.
static void list_names(const char *names, char *text, size_t size) {
    text[0] = '\0';
    for (const char *at = names; at != NULL;) {
        const size_t span = strcspn(at, "|");
        const size_t used = strlen(text);
        const bool last = at[span] == '\0';
        const char *gap = used == 0 ? "" : (last ? " or " : ", ");
        if (span > 0) { // otherwise the number has no name
            (void)snprintf(text + used, size - used, "%s%.*s", gap, (int)span, at);
        }
        at = last ? NULL : at + span + 1;
    }
}

static bool assign_choice(const rig_key_t *key, void *object, const char *value, char *expected,
                          size_t size) {
    const int index = index_of(key->names, value);
    if (index >= 0) {
        store(object, key->offset, &index, sizeof index);
        return true;
    }
    char known[256];
    list_names(key->names, known, sizeof known);
    const bool reserved = key->later != NULL && index_of(key->later, value) >= 0;
    if (key->later == NULL) {
        (void)snprintf(expected, size, "expected %s", known);
    } else {
        char later[256];
        list_names(key->later, later, sizeof later);
        (void)snprintf(expected, size, "expected %s (%s: %s)", known,
                       reserved ? "not built in yet, like the others of"
                                : "reserved, not built in yet",
                       later);
    }
    return false;
}

static bool assign_text(const rig_key_t *key, void *object, const char *value, char *expected,
                        size_t size) {
    const size_t length = strlen(value);
    if (length == 0 || length >= RIG_PATH_LENGTH) {
        (void)snprintf(expected, size, "expected a path of at most %d characters",
                       RIG_PATH_LENGTH - 1);
        return false;
    }
    store(object, key->offset, value, length + 1);
    return true;
}

bool rig_key_assign(const rig_key_t *key, void *object, const char *value, char *expected,
                    size_t size) {
    switch (key->kind) {
    case RIG_KEY_GIVEN:
    case RIG_KEY_FLOAT:
    case RIG_KEY_FLOAT_OR_NONE:
        return assign_float(key, object, value, expected, size);
    case RIG_KEY_DOUBLE:
    case RIG_KEY_DOUBLE_OR:
        return assign_double(key, object, value, expected, size);
    case RIG_KEY_CHOICE:
        return assign_choice(key, object, value, expected, size);
    case RIG_KEY_TEXT:
    default:
        return assign_text(key, object, value, expected, size);
    }
}

bool rig_key_number(const rig_key_t *key, const void *object, double *value) {
    const char *field = (const char *)object + key->offset;
    if (key->kind == RIG_KEY_GIVEN || key->kind == RIG_KEY_FLOAT ||
        key->kind == RIG_KEY_FLOAT_OR_NONE) {
        float number = 0.0f;
        memcpy(&number, field, sizeof number);
        *value = (double)number;
        // Other negative numbers are not words: they are shown as numbers when they are refused.
        return !(key->kind == RIG_KEY_FLOAT_OR_NONE && number == LODE_NONE);
    }
    if (key->kind == RIG_KEY_DOUBLE || key->kind == RIG_KEY_DOUBLE_OR) {
        memcpy(value, field, sizeof *value);
        return isfinite(*value);
    }
    return false;
}

static void print_choice(const rig_key_t *key, const void *object, char *text, size_t size) {
    int index = -1;
    memcpy(&index, (const char *)object + key->offset, sizeof index);
    const char *at = key->names;
    for (int k = 0; k < index && at != NULL; ++k) {
        at = strchr(at, '|');
        at = at != NULL ? at + 1 : NULL;
    }
    if (index >= 0 && at != NULL) {
        (void)snprintf(text, size, "%.*s", (int)strcspn(at, "|"), at);
    }
}

void rig_key_print_exactly(const rig_key_t *key, const void *object, char *text, size_t size) {
    const bool word = key->kind == RIG_KEY_FLOAT || key->kind == RIG_KEY_FLOAT_OR_NONE;
    const bool single = word || key->kind == RIG_KEY_GIVEN;
    double number = NAN;
    if (!rig_key_number(key, object, &number)) {
        rig_key_print(key, object, text, size);
    } else if (word && number == 0.0) {
        (void)snprintf(text, size, "auto"); // a 0 of FLOAT_OR_NONE would be read as none
    } else {
        bool same = false;
        for (int digits = DIGITS_LEAST; !same && digits <= DIGITS_MOST; ++digits) {
            (void)snprintf(text, size, "%.*g", digits, number);
            const double read = strtod(text, NULL);
            same = single ? (float)read == (float)number : read == number;
        }
    }
}

void rig_key_print(const rig_key_t *key, const void *object, char *text, size_t size) {
    double number = NAN;
    text[0] = '\0';
    if (rig_key_number(key, object, &number)) {
        (void)snprintf(text, size, "%.7g", number);
    } else if (key->kind == RIG_KEY_FLOAT_OR_NONE) {
        (void)snprintf(text, size, "none");
    } else if (key->kind == RIG_KEY_DOUBLE_OR && isinf(number)) {
        (void)snprintf(text, size, "%s", key->names);
    } else if (key->kind == RIG_KEY_CHOICE) {
        print_choice(key, object, text, size);
    } else if (key->kind == RIG_KEY_TEXT) {
        (void)snprintf(text, size, "%s", (const char *)object + key->offset);
    }
}
