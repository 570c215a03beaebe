/// Output files that appear complete or not at all.
///
/// Each is written under a temporary name in the folder of its target and renamed at the end, all
/// of them together. Ctrl-C and other ends of the process remove the temporary files.
#ifndef RIG_ATOMIC_FILE_H
#define RIG_ATOMIC_FILE_H

#include <stdbool.h>
#include <stdio.h>

/// Ctrl-C, a hang-up, a closed pipe and a termination request remove what is unfinished and end the process with
/// 128 plus the signal's number. Call it once, first.
void atomic_file_catch_signals(void);

/// Opens the file that will become `path`; NULL after a message to the user, where it cannot be
/// written, is one of the inputs (inputs.h) or another output. What is not a regular file (a pipe, a
/// device) is written to directly.
FILE *atomic_file_open(const char *path);

/// Closes all open files and gives them their names. False after a message; none is kept then.
bool atomic_file_commit_all(void);

/// Closes and removes all that is not committed.
void atomic_file_discard_all(void);

#endif
