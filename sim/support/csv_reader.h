/// Tables in text files: lines and their cells. Separator comma, semicolon, tab or blanks; with any but the
/// comma a number may have a decimal comma. Cells may stand in double quotes. Lines that are empty or begin
/// with # or % are passed over.
#ifndef RIG_CSV_READER_H
#define RIG_CSV_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct {
    const char *path;
    FILE *file;
    char *text; ///< the line, cut into cells as they are read
    char *rest; ///< what is left of it; NULL: nothing
    size_t size;
    size_t line;    ///< its number, from 1
    char separator; ///< ' ': any number of blanks and tabs
    bool failed;    ///< the file cannot be read, or holds what is no text: a message has said so
} csv_reader_t;

/// NULL or "auto" leaves the separator to csv_reader_guess(). False after a message.
bool csv_reader_open(csv_reader_t *self, const char *path, const char *separator);

void csv_reader_close(csv_reader_t *self);

/// The next line, from number `from` on. False at the end of the file, or with `failed`.
bool csv_reader_line(csv_reader_t *self, size_t from);

/// Takes the separator from the line that has just been read, unless it is known.
void csv_reader_guess(csv_reader_t *self);

/// The next cell of the line, without the blanks around it; NULL behind the last one.
char *csv_reader_cell(csv_reader_t *self);

/// False where `cell` is no finite number.
bool csv_reader_number(const csv_reader_t *self, const char *cell, double *value);

#endif
