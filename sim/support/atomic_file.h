/// Output files that appear complete or not at all.
///
/// Each is written under a temporary name in the folder of its target; at the end all are renamed together.
/// Ctrl-C and other ends of the process remove the temporary files.
#ifndef RIG_ATOMIC_FILE_H
#define RIG_ATOMIC_FILE_H

#include <stdbool.h>
#include <stdio.h>

/// After this call Ctrl-C, a hang-up, a closed pipe and a termination request remove unfinished files and end
/// the process with 128 plus the signal's number. Call it once, first.
void atomic_file_catch_signals(void);

/// Opens the file that will become `path`; NULL after a message if it cannot be written, is one of the inputs
/// (inputs.h) or another output. A pipe or a device is written directly.
FILE *atomic_file_open(const char *path);

/// Closes all open files and gives them their names. False after a message; then none is kept.
bool atomic_file_commit_all(void);

/// Closes and removes all files that are not committed.
void atomic_file_discard_all(void);

#endif
