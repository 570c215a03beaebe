/// Words of a command line that is printed for a shell.
#ifndef RIG_SHELL_H
#define RIG_SHELL_H

#include <stdbool.h>
#include <stddef.h>

enum {
    SHELL_GROWTH = 4
}; ///< a word is at most this many times as long as its text, and two quotes

/// A text as one word: as it is where no character of it means anything to a shell, else in single quotes. `?`
/// replaces what a terminal might obey (control characters) or cannot show. False if it does not fit; it is cut then.
bool shell_word(char *word, size_t size, const char *text);

/// True if a text is made of such words and blanks between them: nothing in it is run.
bool shell_is_words(const char *text);

#endif
