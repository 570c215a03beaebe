/// Lists of names on the command line: A,B,...
#ifndef RIG_NAMES_H
#define RIG_NAMES_H

#include <stdbool.h>

enum { NAMES_LENGTH = 256 }; ///< of the buffer that holds a name

/// Calls `take` with each name of `list`, in order. False where `take` says so; and, before any is taken, after a
/// message that begins with `option`, where there is no name, an empty one, or one that comes twice.
bool names_take(const char *option, const char *list, bool (*take)(void *user, const char *name),
                void *user);

#endif
