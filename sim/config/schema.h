/// The table of all INI keys, the values they accept, and the fields that hold them.
#ifndef RIG_SCHEMA_H
#define RIG_SCHEMA_H

#include <stdbool.h>
#include <stddef.h>

#include "config/rig_config.h"

typedef enum {
    RIG_KEY_GIVEN,         ///< float of the library: a number
    RIG_KEY_FLOAT,         ///< the same, or `auto`: the library computes it; so does 0
    RIG_KEY_FLOAT_OR_NONE, ///< a number, `auto`, or `none`; 0 means none
    RIG_KEY_DOUBLE,        ///< double of the host, within lo .. hi
    RIG_KEY_DOUBLE_OR,     ///< the same, or the word in `names`, stored as RIG_RANDOM
    RIG_KEY_CHOICE,        ///< int or enum: index into `names`, which are separated by '|'
    RIG_KEY_TEXT           ///< path of at most RIG_PATH_LENGTH - 1 characters
} rig_key_kind_t;

typedef struct {
    const char *section;
    const char *key;
    rig_key_kind_t kind;
    size_t offset; ///< in rig_config_t, for phases in rig_phase_t
    double lo, hi;
    const char *names;
    const char *later; ///< choices that are reserved, NULL: none
} rig_key_t;

typedef struct {
    const rig_key_t *row;
    int rows;
} rig_schema_t;

/// Keys of the fixed sections.
rig_schema_t rig_schema(void);

/// Keys of every [phase.NAME]; their `section` is "phase".
rig_schema_t rig_phase_schema(void);

/// Row of the key, -1: there is none.
int rig_schema_find(rig_schema_t schema, const char *section, const char *key);

/// Writes the valid choices for an unknown `[section] key`.
void rig_schema_expected(rig_schema_t schema, const char *section, char *text, size_t size);

/// Row of the key that an unknown one may mean: the same key in another section, or in this section the key
/// with its unit or the most similar one. -1: none.
int rig_schema_guess(rig_schema_t schema, const char *section, const char *key);

/// Reads `value` into the field of `object`. False: `expected` names the valid values.
bool rig_key_assign(const rig_key_t *key, void *object, const char *value, char *expected,
                    size_t size);

/// The value as written in a file. Empty if unset.
void rig_key_print(const rig_key_t *key, const void *object, char *text, size_t size);

/// The same with enough digits for rig_key_assign() to read back exactly the same value.
void rig_key_print_exactly(const rig_key_t *key, const void *object, char *text, size_t size);

/// The value as a number, for JSON; false if it is a word or unset.
bool rig_key_number(const rig_key_t *key, const void *object, double *value);

#endif
