/// The files that this process reads. None of them may become an output.
#ifndef RIG_INPUTS_H
#define RIG_INPUTS_H

#include <stdbool.h>
#include <stdio.h>
#include <sys/stat.h>

/// Opens a file for reading and remembers it. NULL with errno set.
FILE *inputs_open(const char *path);

/// True if inputs_open() has opened this file, under any name.
bool inputs_include(const struct stat *about);

#endif
