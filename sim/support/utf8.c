#include "support/utf8.h"

#include <stdbool.h>
#include <string.h>

int utf8_length(const unsigned char *text) {
    static const struct {
        unsigned char first, last; // leading bytes
        unsigned char low, high;   // range of the next byte: excludes overlong forms and surrogates
        int length;
    } forms[] = {
        {0x00, 0x7f, 0x00, 0xff, 1}, {0xc2, 0xdf, 0x80, 0xbf, 2}, {0xe0, 0xe0, 0xa0, 0xbf, 3},
        {0xe1, 0xec, 0x80, 0xbf, 3}, {0xed, 0xed, 0x80, 0x9f, 3}, {0xee, 0xef, 0x80, 0xbf, 3},
        {0xf0, 0xf0, 0x90, 0xbf, 4}, {0xf1, 0xf3, 0x80, 0xbf, 4}, {0xf4, 0xf4, 0x80, 0x8f, 4}};
    for (size_t k = 0; k < sizeof forms / sizeof forms[0]; ++k) {
        if (text[0] >= forms[k].first && text[0] <= forms[k].last) {
            bool good = text[0] < 0x80 || (text[1] >= forms[k].low && text[1] <= forms[k].high);
            for (int n = 2; good && n < forms[k].length; ++n) {
                good = (text[n] & 0xc0) == 0x80;
            }
            return good ? forms[k].length : 0;
        }
    }
    return 0;
}

size_t utf8_shown(const char **text, char *shown) {
    const unsigned char *at = (const unsigned char *)*text;
    const int length = utf8_length(at);
    const bool control = *at < ' ' || *at == 0x7f || (length == 2 && at[0] == 0xc2 && at[1] < 0xa0);
    *text += length > 1 ? length : 1;
    if (length == 0 || control) {
        *shown = control ? ' ' : '?';
        return 1;
    }
    (void)memcpy(shown, at, (size_t)length);
    return (size_t)length;
}

const char *utf8_copy_shown(char *shown, size_t size, const char *text) {
    enum { AT_MOST = 4 + 1 }; // a character and the end
    size_t to = 0;
    while (*text != '\0' && to + AT_MOST <= size) {
        to += utf8_shown(&text, shown + to);
    }
    shown[to] = '\0';
    return shown;
}
