/// Loads a recording from a file.
#ifndef RIG_RECORDING_LOAD_H
#define RIG_RECORDING_LOAD_H

#include "rig/recording.h"

/// False after a message "FILE:LINE: ...": not such a file, a value that is not a finite number, or times that
/// do not match PWM periods.
bool recording_load(recording_t *self, const char *path, const recording_format_t *format);

#endif
