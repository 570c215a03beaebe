/// The times of a recording: one row per PWM period, if needed by resampling.
#ifndef RIG_RECORDING_TIME_H
#define RIG_RECORDING_TIME_H

#include "rig/recording.h"

/// Checks the times of the rows, sets ts_s, finds gaps, and resamples if requested. False after
/// a message.
bool recording_time(recording_t *self, const char *path, const recording_format_t *format);

#endif
