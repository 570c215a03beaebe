/// Recorded signals of a drive: a table in a text file, one row per PWM period. Row k: currents, angle
/// and speed AT t_k, the mean voltage over [t_k, t_k+1). Columns, units and separators: sim/README.md.
#ifndef RIG_RECORDING_H
#define RIG_RECORDING_H

#include <stdbool.h>
#include <stddef.h>

typedef struct {
    size_t line; ///< in the file; resampled: of the last row up to this time
    double t_s;
    double u_alpha_V, u_beta_V;
    double i_alpha_A, i_beta_A;
    double theta_e_rad, omega_e_rad_s; ///< 0 where the file has none
    bool after_gap; ///< rows are missing before this one: the voltage before it is not known
} recording_row_t;

/// How to read a file; all 0: no change.
typedef struct {
    const char *const *map; ///< --column NAME=COLUMN[:UNIT]
    int maps;
    const char *separator; ///< NULL: detected from the header
    const char *header;    ///< line of the header, or "none"; NULL: the first line with content
    const char *data;      ///< line of the first row; NULL: after the header
    bool resample;         ///< resample uneven or faster rows to even PWM periods; gaps stay
    double f_pwm_Hz;       ///< of the drive, 0: not known
    double pole_pairs;     ///< for a mechanical speed
} recording_format_t;

typedef struct {
    recording_row_t *row;
    size_t rows;
    bool has_theta, has_omega;
    double ts_s; ///< time step, except at gaps
    size_t gaps;
    double gaps_s;    ///< total time of the gaps
    size_t resampled; ///< rows of the file before resampling; 0: not resampled
} recording_t;

/// Adds a row. False after a message if out of memory.
bool recording_add(recording_t *self, size_t *capacity, const recording_row_t *row);

void recording_free(recording_t *self);

#endif
