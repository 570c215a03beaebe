/// Optional output files of a command.
#ifndef RIG_OUTPUTS_H
#define RIG_OUTPUTS_H

#include <stdbool.h>
#include <stdio.h>

/// Opens the file for `path` unless that is NULL. False after a message.
bool outputs_open(FILE **file, const char *path);

/// Makes the folder for outputs unless it is there. False after a message.
bool outputs_folder(const char *path);

/// Says on stdout that `path` was written, unless that is NULL.
void outputs_say(const char *path);

#endif
