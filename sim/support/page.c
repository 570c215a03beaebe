#include "support/page.h"

#include <stdbool.h>
#include <string.h>

#include "support/utf8.h"

/// Writes text as HTML: markup characters are escaped, control characters other than line ends become blanks,
/// and bytes that are not UTF-8 become `?`.
static void write_text(FILE *page, const char *text) {
    const unsigned char *at = (const unsigned char *)text;
    while (*at != '\0') {
        const int length = utf8_length(at);
        if (length > 1) {
            (void)fwrite(at, 1, (size_t)length, page);
        } else if (*at == '&') {
            (void)fputs("&amp;", page);
        } else if (*at == '<') {
            (void)fputs("&lt;", page);
        } else if (*at == '>') {
            (void)fputs("&gt;", page);
        } else if (length == 0) {
            (void)fputc('?', page);
        } else {
            const bool control = (*at < ' ' && *at != '\n') || *at == 0x7f;
            (void)fputc(control ? ' ' : *at, page);
        }
        at += length > 1 ? length : 1;
    }
}

/// Copies from the element <svg> on; the lines before it belong only in a separate SVG file.
static void copy_svg(FILE *page, FILE *svg) {
    char line[4096];
    bool inside = false;
    rewind(svg);
    while (fgets(line, sizeof line, svg) != NULL) {
        const char *from = inside ? line : strstr(line, "<svg");
        inside = inside || from != NULL;
        if (from != NULL) {
            (void)fputs(from, page);
        }
    }
}

void page_write(FILE *page, const char *title, FILE *svg, const char *text) {
    (void)fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                "<meta name=\"viewport\" content=\"width=device-width\">\n<title>",
                page);
    write_text(page, title);
    (void)fputs("</title>\n<style>body { margin: 2em; color: #202020; font-family: sans-serif }\n"
                "svg { max-width: 100%; height: auto } pre { overflow-x: auto }</style>\n"
                "</head>\n<body>\n",
                page);
    copy_svg(page, svg);
    if (text != NULL) {
        (void)fputs("<pre>", page);
        write_text(page, text);
        (void)fputs("</pre>\n", page);
    }
    (void)fputs("</body>\n</html>\n", page);
}
