/// A list of names with commas between them, as options take it.
#ifndef RIG_NAME_LIST_H
#define RIG_NAME_LIST_H

#include <stdbool.h>
#include <stddef.h>

/// At least one name, and none of them empty.
bool name_list_is_whole(const char *list);

/// Takes the next name out of the list, as far as there is room for it. False at its end.
bool name_list_next(const char **list, char *name, size_t size);

#endif
