/// Characters of text that may not be UTF-8.
#ifndef RIG_UTF8_H
#define RIG_UTF8_H

#include <stddef.h>

/// Length of the character at `text` in bytes, 1 .. 4; 0 if it is not valid UTF-8.
int utf8_length(const unsigned char *text);

/// Copies the character at `*text` to `shown`, 1 to 4 bytes without an end, and steps over it. For a screen: a blank
/// replaces a control character, `?` a byte that is not UTF-8. Returns the number of bytes copied.
size_t utf8_shown(const char **text, char *shown);

/// The same for a whole text, cut to the size of `shown`, which is returned.
const char *utf8_copy_shown(char *shown, size_t size, const char *text);

#endif
