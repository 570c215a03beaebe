#include "support/diag.h"

#include <stdarg.h>
#include <stdio.h>

void rig_error(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    (void)fputs("lodestar: ", stderr);
    (void)vfprintf(stderr, format, arguments);
    (void)fputc('\n', stderr);
    va_end(arguments);
}

void rig_error_at(const char *file, int line, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    if (line > 0) {
        (void)fprintf(stderr, "%s:%d: ", file, line);
    } else {
        (void)fprintf(stderr, "%s: ", file);
    }
    (void)vfprintf(stderr, format, arguments);
    (void)fputc('\n', stderr);
    va_end(arguments);
}
