/// Running figures of a signal: mean, root mean square, extremes.
#ifndef RIG_STATS_H
#define RIG_STATS_H

#include <stddef.h>

typedef struct {
    size_t count;
    double sum;
    double sum_squares;
    double min;
    double max;
} rig_stats_t;

void rig_stats_reset(rig_stats_t *self);
void rig_stats_add(rig_stats_t *self, double value);

/// All of these are NaN while nothing has been added.
double rig_stats_mean(const rig_stats_t *self);
double rig_stats_rms(const rig_stats_t *self);
double rig_stats_min(const rig_stats_t *self);
double rig_stats_max(const rig_stats_t *self);
double rig_stats_peak_to_peak(const rig_stats_t *self);

/// Largest magnitude.
double rig_stats_peak(const rig_stats_t *self);

#endif
