/// Conversion from the keys of data sheets to those of the library.
#ifndef RIG_CONVERSIONS_H
#define RIG_CONVERSIONS_H

#include <stddef.h>

#include "config/rig_config.h"

/// Converts every such key that is given, and notes in the origin of its target which key it was. False
/// after a message: two keys give one quantity, or a winding's value is given without its connection.
bool conversions_apply(rig_config_t *config);

/// True for such a key, given or not.
bool conversions_has(const char *section, const char *key);

/// The keys that may replace `[section] key`, separated by commas; empty: none.
void conversions_instead_of(const char *section, const char *key, char *text, size_t size);

#endif
