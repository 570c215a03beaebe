#include "support/shell.h"

#include <string.h>

#include "support/utf8.h"

#define PLAIN "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./,-"

/// Appends the next character of `*text` to a word in quotes, and steps over it; returns how many bytes.
static size_t add_character(char *word, const char **text) {
    const char *from = *text;
    if (*from == '\'') {
        ++*text;
        (void)memcpy(word, "'\\''", 4);
        return 4;
    }
    const size_t length = utf8_shown(text, word);
    const bool replaced = length == 1 && *word == ' ' && *from != ' ';
    *word = replaced ? '?' : *word; // a blank would be another name that may exist
    return length;
}

bool shell_word(char *word, size_t size, const char *text) {
    enum { AT_MOST = 4 + 2 }; // a character, the last quote and the end
    const bool plain = text[0] != '\0' && text[strspn(text, PLAIN)] == '\0';
    size_t to = 0;
    if (size < AT_MOST) {
        return false;
    }
    if (!plain) {
        word[to++] = '\'';
    }
    while (*text != '\0' && to + AT_MOST <= size) {
        to += add_character(word + to, &text);
    }
    if (!plain) {
        word[to++] = '\'';
    }
    word[to] = '\0';
    return *text == '\0';
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
