/// The library's channels by name.
#ifndef RIG_CHANNELS_H
#define RIG_CHANNELS_H

#include <stdbool.h>
#include <stdint.h>

#include "lodestar/channel.h"

/// "channel" and its number for one that this version does not know; valid until the next call.
const char *channels_name(uint32_t number);

/// Empty for a ratio or an enumerator.
const char *channels_unit(uint32_t number);

/// True for mode, check, a start's stage and its criterion, whose values have names.
bool channels_is_named(uint32_t number);

/// The enumerator of a value, as RUN or OVER_CURRENT; NULL where the channel has none of that value.
const char *channels_value_name(uint32_t number, double value);

/// LODE_CHANNEL_COUNT for an unknown name.
lode_channel_t channels_find(const char *name);

/// All names, separated by ", ".
const char *channels_list(void);

#endif
