#include "support/names.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "support/diag.h"

/// The next name, or NULL after the last one.
static const char *next_of(const char *name) {
    const char *end = name + strcspn(name, ",");
    return *end == ',' ? end + 1 : NULL;
}

/// True if there is a name that does not occur again later.
static bool is_good(const char *name) {
    const size_t length = strcspn(name, ",");
    bool good = length > 0u && length < NAMES_LENGTH;
    for (const char *other = next_of(name); good && other != NULL; other = next_of(other)) {
        good = strcspn(other, ",") != length || strncmp(other, name, length) != 0;
    }
    return good;
}

bool names_take(const char *option, const char *list, bool (*take)(void *user, const char *name),
                void *user) {
    bool good = true;
    for (const char *at = list; good && at != NULL; at = next_of(at)) {
        good = is_good(at);
    }
    if (!good) {
        rig_error("%s: expected names separated by commas, each name once", option);
    }
    for (const char *at = list; good && at != NULL; at = next_of(at)) {
        char name[NAMES_LENGTH];
        (void)snprintf(name, sizeof name, "%.*s", (int)strcspn(at, ","), at);
        good = take(user, name);
    }
    return good;
}
