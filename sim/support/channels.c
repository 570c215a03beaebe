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

bool channels_is_named(uint32_t number) {
    return number == (uint32_t)LODE_CHANNEL_MODE || number == (uint32_t)LODE_CHANNEL_CHECK;
}

const char *channels_value_name(uint32_t number, double value) {
    const int whole = value >= 0.0 && value < 256.0 ? (int)value : -1;
    if (!channels_is_named(number) || whole < 0 || value > (double)whole) {
        return NULL;
    }
    const bool is_mode = number == (uint32_t)LODE_CHANNEL_MODE;
    const int count = is_mode ? (int)LODE_MODE_PRECHARGE + 1 : (int)LODE_CHECK_COUNT;
    if (whole >= count) {
        return NULL;
    }
    return is_mode ? lode_mode_name((lode_mode_t)whole) + strlen("LODE_MODE_")
                   : lode_check_name((lode_check_t)whole) + strlen("LODE_CHECK_");
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
    return &all[2]; // behind the first separator
#undef NAME
}
