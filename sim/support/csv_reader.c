#include "support/csv_reader.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

#include "support/diag.h"
#include "support/inputs.h"

enum { NUMBER_LENGTH = 64 };

static bool take_separator(csv_reader_t *self, const char *name) {
    static const struct {
        const char *name;
        char separator;
    } known[] = {{"auto", '\0'}, {"comma", ','}, {"semicolon", ';'}, {"tab", '\t'}, {"blank", ' '}};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; ++k) {
        if (name == NULL || strcmp(name, known[k].name) == 0) {
            self->separator = known[k].separator;
            return true;
        }
    }
    rig_error("--separator %s: expected auto, comma, semicolon, tab or blank", name);
    return false;
}

bool csv_reader_open(csv_reader_t *self, const char *path, const char *separator) {
    *self = (csv_reader_t){.path = path};
    if (!take_separator(self, separator)) {
        return false;
    }
    self->file = inputs_open(path);
    if (self->file == NULL) {
        rig_error_at(path, 0, "%s; expected a CSV file", strerror(errno));
    }
    return self->file != NULL;
}

void csv_reader_close(csv_reader_t *self) {
    if (self->file != NULL) {
        (void)fclose(self->file);
    }
    free(self->text);
    *self = (csv_reader_t){0};
}

static bool is_passed_over(const char *text) {
    const char first = text[strspn(text, " \t")];
    return first == '\0' || first == '#' || first == '%';
}

bool csv_reader_line(csv_reader_t *self, size_t from) {
    do {
        const ssize_t length = getline(&self->text, &self->size, self->file);
        if (length < 0 && ferror(self->file) != 0) {
            rig_error_at(self->path, 0, "%s; expected a CSV file", strerror(errno));
            self->failed = true;
        }
        if (length < 0) {
            return false;
        }
        self->line++;
        if (strlen(self->text) != (size_t)length) {
            rig_error_at(self->path, (int)self->line,
                         "a zero octet; expected text in UTF-8 or ASCII (not UTF-16)");
            self->failed = true;
            return false;
        }
        self->text[strcspn(self->text, "\r\n")] = '\0';
    } while (self->line < from || is_passed_over(self->text));
    const char *const mark = "\xEF\xBB\xBF"; // UTF-8 mark, which some systems write
    self->rest = self->text + (self->line == 1 && strncmp(self->text, mark, 3) == 0 ? 3 : 0);
    return true;
}

/// The first of `wanted` outside quotes, or the end of the text.
static char *find(char *text, const char *wanted) {
    bool quoted = false;
    while (*text != '\0' && (quoted || strchr(wanted, *text) == NULL)) {
        quoted = *text == '"' ? !quoted : quoted;
        ++text;
    }
    return text;
}

void csv_reader_guess(csv_reader_t *self) {
    static const char in_this_order[] = "\t;,";
    for (const char *at = in_this_order; self->separator == '\0' && *at != '\0'; ++at) {
        const char wanted[] = {*at, '\0'};
        self->separator = *find(self->rest, wanted) != '\0' ? *at : '\0';
    }
    if (self->separator == '\0') {
        self->separator = ',';
    }
}

/// Removes the quotes of a cell; a doubled quote becomes one.
static void unquote(char *cell) {
    char *to = cell;
    for (const char *from = cell; *from != '\0'; ++from) {
        if (*from == '"' && from[1] == '"' && from > cell) {
            ++from;
        } else if (*from == '"') {
            continue;
        }
        *to++ = *from;
    }
    *to = '\0';
}

char *csv_reader_cell(csv_reader_t *self) {
    const char *blanks = self->separator == '\t' ? " " : " \t";
    const char separators[] = {self->separator, self->separator == ' ' ? '\t' : '\0', '\0'};
    if (self->rest == NULL) {
        return NULL;
    }
    char *cell = self->rest + strspn(self->rest, blanks);
    if (self->separator == ' ' && *cell == '\0') {
        return NULL; // blanks at the end of a line do not begin a cell
    }
    char *end = find(cell, separators);
    self->rest = *end != '\0' ? end + 1 : NULL;
    while (end > cell && strchr(blanks, end[-1]) != NULL) {
        --end;
    }
    *end = '\0';
    if (*cell == '"') {
        unquote(cell);
    }
    return cell;
}

bool csv_reader_number(const csv_reader_t *self, const char *cell, double *value) {
    char text[NUMBER_LENGTH];
    char *end = NULL;
    if (strlen(cell) >= sizeof text) {
        return false;
    }
    (void)snprintf(text, sizeof text, "%s", cell);
    char *comma = self->separator != ',' ? strchr(text, ',') : NULL;
    if (comma != NULL && strchr(text, '.') != NULL) {
        return false; // which of them separates thousands?
    }
    if (comma != NULL) {
        *comma = '.';
    }
    *value = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*value);
}
