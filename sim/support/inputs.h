/// Files that this process reads, so that none of them becomes an output.
#ifndef RIG_INPUTS_H
#define RIG_INPUTS_H

#include <stdbool.h>
#include <stdio.h>
#include <sys/stat.h>

/// Opens a file for reading and remembers it. NULL with errno set.
FILE *inputs_open(const char *path);

/// Whether inputs_open() has opened this file, under whatever name.
bool inputs_include(const struct stat *about);

#endif
