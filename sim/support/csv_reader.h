/// Tables in text files: lines and their cells. Separator comma, semicolon, tab or blanks; with any but the
/// comma a number may have a decimal comma. Cells may be in double quotes. Empty lines and lines that begin
/// with # or % are skipped.
#ifndef RIG_CSV_READER_H
#define RIG_CSV_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct {
    const char *path;
    FILE *file;
    char *text; ///< the line, cut into cells as they are read
    char *rest; ///< rest of the line; NULL: none
    size_t size;
    size_t line;    ///< its number, from 1
    char separator; ///< ' ': any number of blanks and tabs
    bool failed;    ///< a message was printed: the file cannot be read, or is not text
} csv_reader_t;

/// NULL or "auto" leaves the separator to csv_reader_guess(). False after a message.
bool csv_reader_open(csv_reader_t *self, const char *path, const char *separator);

void csv_reader_close(csv_reader_t *self);

/// Reads the next line, from number `from` on. False at the end of the file, or with `failed`.
bool csv_reader_line(csv_reader_t *self, size_t from);

/// Takes the separator from the line that has just been read, unless it is known.
void csv_reader_guess(csv_reader_t *self);

/// The next cell of the line, without surrounding blanks; NULL after the last one.
char *csv_reader_cell(csv_reader_t *self);

/// False if `cell` is not a finite number.
bool csv_reader_number(const csv_reader_t *self, const char *cell, double *value);

#endif
