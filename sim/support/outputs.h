/// Optional output files of a command.
#ifndef RIG_OUTPUTS_H
#define RIG_OUTPUTS_H

#include <stdbool.h>
#include <stdio.h>

/// Opens the file for `path` unless that is NULL. False after a message.
bool outputs_open(FILE **file, const char *path);

/// Creates the folder for outputs unless it exists. False after a message.
bool outputs_folder(const char *path);

/// Prints to stdout that `path` was written, unless it is NULL.
void outputs_say(const char *path);

#endif
