#include "support/stats.h"

#include <math.h>

void rig_stats_reset(rig_stats_t *self) {
    *self = (rig_stats_t){0};
}

void rig_stats_add(rig_stats_t *self, double value) {
    if (self->count == 0) {
        self->min = value;
        self->max = value;
    }
    self->count++;
    self->sum += value;
    self->sum_squares += value * value;
    self->min = value < self->min ? value : self->min;
    self->max = value > self->max ? value : self->max;
}

double rig_stats_mean(const rig_stats_t *self) {
    return self->count > 0 ? self->sum / (double)self->count : NAN;
}

double rig_stats_rms(const rig_stats_t *self) {
    return self->count > 0 ? sqrt(self->sum_squares / (double)self->count) : NAN;
}

double rig_stats_min(const rig_stats_t *self) {
    return self->count > 0 ? self->min : NAN;
}

double rig_stats_max(const rig_stats_t *self) {
    return self->count > 0 ? self->max : NAN;
}

double rig_stats_peak_to_peak(const rig_stats_t *self) {
    return self->count > 0 ? self->max - self->min : NAN;
}

double rig_stats_peak(const rig_stats_t *self) {
    return self->count > 0 ? fmax(fabs(self->min), fabs(self->max)) : NAN;
}
