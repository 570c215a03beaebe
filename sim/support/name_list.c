#include "support/name_list.h"

#include <stdio.h>
#include <string.h>

bool name_list_is_whole(const char *list) {
    size_t length = strcspn(list, ",");
    while (length > 0u && list[length] != '\0') {
        list += length + 1u;
        length = strcspn(list, ",");
    }
    return length > 0u;
}

bool name_list_next(const char **list, char *name, size_t size) {
    const size_t length = strcspn(*list, ",");
    if (**list == '\0') {
        return false;
    }
    (void)snprintf(name, size, "%.*s", (int)length, *list);
    *list += length + ((*list)[length] == ',' ? 1u : 0u);
    return true;
}
