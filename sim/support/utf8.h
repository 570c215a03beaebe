/// Characters of text that may not be UTF-8.
#ifndef RIG_UTF8_H
#define RIG_UTF8_H

/// Length of the character at `text` in bytes, 1 .. 4; 0 if it is not valid UTF-8.
int utf8_length(const unsigned char *text);

#endif
