/// Characters of text that may not be UTF-8.
#ifndef RIG_UTF8_H
#define RIG_UTF8_H

/// Bytes of the character at `text`, 1 .. 4; 0 if it is none.
int utf8_length(const unsigned char *text);

#endif
