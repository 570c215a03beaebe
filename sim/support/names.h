/// Lists of names on the command line: A,B,...
#ifndef RIG_NAMES_H
#define RIG_NAMES_H

#include <stdbool.h>

enum { NAMES_LENGTH = 256 }; ///< of the buffer that holds a name

/// Calls `take` with each name of `list`, in order. False if `take` returns false. Also false, before any call
/// and after a message that begins with `option`, if the list is empty, or a name is empty or occurs twice.
bool names_take(const char *option, const char *list, bool (*take)(void *user, const char *name),
                void *user);

#endif
