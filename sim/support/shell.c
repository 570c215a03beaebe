#include "support/shell.h"

#include <string.h>

#include "support/utf8.h"

#define PLAIN "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./,-"

bool shell_word(char *word, size_t size, const char *text) {
    enum { AT_MOST = 4 + 2 }; // a character, the last quote and the end
    const bool plain = text[0] != '\0' && text[strspn(text, PLAIN)] == '\0';
    size_t to = 0;
    if (!plain && size > 0) {
        word[to++] = '\'';
    }
    while (*text != '\0' && to + AT_MOST <= size) {
        if (*text == '\'') {
            (void)memcpy(word + to, "'\\''", 4);
            to += 4;
            ++text;
        } else {
            const size_t length = utf8_shown(&text, word + to);
            if (length == 1 && word[to] == ' ' && text[-1] != ' ') {
                word[to] = '?'; // a blank in the place of a control character would be another name
            }
            to += length;
        }
    }
    const bool good = *text == '\0' && to + 2 <= size;
    if (good && !plain) {
        word[to++] = '\'';
    }
    if (size > 0) {
        word[good ? to : 0] = '\0';
    }
    return good;
}

bool shell_is_words(const char *text) {
    bool quoted = false;
    for (const char *at = text; *at != '\0'; ++at) {
        const bool escaped = !quoted && at[0] == '\\' && at[1] == '\'';
        const bool control = (unsigned char)*at < ' ' || *at == 0x7f;
        if (control || (!quoted && !escaped && strchr(PLAIN " '", *at) == NULL)) {
            return false;
        }
        quoted = *at == '\'' ? !quoted : quoted;
        at += escaped ? 1 : 0;
    }
    return !quoted;
}
