#include "support/channels.h"

#include <stdio.h>
#include <string.h>

#define ROW(channel, number, name, unit) {name, unit},
static const struct { const char *name, *unit; } table[] = {LODE_CHANNELS(ROW)};
#undef ROW

const char *channels_name(uint32_t number) {
    static char other[24];
    if (number < (uint32_t)LODE_CHANNEL_COUNT) {
        return table[number].name;
    }
    (void)snprintf(other, sizeof other, "channel%lu", (unsigned long)number);
    return other;
}

const char *channels_unit(uint32_t number) {
    return number < (uint32_t)LODE_CHANNEL_COUNT ? table[number].unit : "?";
}

static const char *mode_of(int value) {
    return lode_mode_name((lode_mode_t)value) + strlen("LODE_MODE_");
}

static const char *check_of(int value) {
    return lode_check_name((lode_check_t)value) + strlen("LODE_CHECK_");
}

static const char *stage_of(int value) {
    return lode_start_stage_name((lode_start_stage_t)value) + strlen("LODE_START_");
}

static const char *criterion_of(int value) {
    return lode_criterion_name((lode_criterion_t)value) + strlen("LODE_CRITERION_");
}

/// Channels whose values have names, from 0 on.
typedef struct {
    uint32_t channel;
    int values;
    const char *(*name_of)(int value);
} named_t;

static const named_t named[] = {
    {(uint32_t)LODE_CHANNEL_MODE, (int)LODE_MODE_PRECHARGE + 1, mode_of},
    {(uint32_t)LODE_CHANNEL_CHECK, (int)LODE_CHECK_COUNT, check_of},
    {(uint32_t)LODE_CHANNEL_START_STAGE, (int)LODE_START_TURN + 1, stage_of},
    {(uint32_t)LODE_CHANNEL_CRITERION, (int)LODE_CRITERION_COUNT, criterion_of},
};

static const named_t *find_named(uint32_t number) {
    for (size_t k = 0; k < sizeof named / sizeof named[0]; ++k) {
        if (named[k].channel == number) {
            return &named[k];
        }
    }
    return NULL;
}

bool channels_is_named(uint32_t number) {
    return find_named(number) != NULL;
}

const char *channels_value_name(uint32_t number, double value) {
    const named_t *row = find_named(number);
    const int whole = value >= 0.0 && value < 256.0 ? (int)value : -1;
    if (row == NULL || whole < 0 || whole >= row->values || value > (double)whole) {
        return NULL;
    }
    return row->name_of(whole);
}

lode_channel_t channels_find(const char *name) {
    uint32_t number = 0;
    while (number < (uint32_t)LODE_CHANNEL_COUNT && strcmp(name, table[number].name) != 0) {
        ++number;
    }
    return (lode_channel_t)number;
}

const char *channels_list(void) {
#define NAME(channel, number, name, unit) ", " name
    static const char all[] = LODE_CHANNELS(NAME);
    return &all[2]; // after the first separator
#undef NAME
}
