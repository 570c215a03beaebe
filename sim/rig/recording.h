/// Recorded signals of a drive: a CSV file with named columns.
///
/// Needed: t_s, u_alpha_V, u_beta_V, i_alpha_A, i_beta_A; optional: theta_e_rad, omega_e_rad_s; any
/// others are ignored. Row k: currents, angle and speed AT t_k, the mean voltage over [t_k, t_k+1).
#ifndef RIG_RECORDING_H
#define RIG_RECORDING_H

#include <stdbool.h>
#include <stddef.h>

typedef struct {
    size_t line; ///< in the file
    double t_s;
    double u_alpha_V, u_beta_V;
    double i_alpha_A, i_beta_A;
    double theta_e_rad, omega_e_rad_s; ///< 0 where the file has none
} recording_row_t;

typedef struct {
    recording_row_t *row;
    size_t rows;
    bool has_theta, has_omega;
    double ts_s; ///< mean time step
} recording_t;

/// False after a message "FILE:LINE: ...": not such a file, a value that is not a finite number, or
/// a time step more than 1 % off the median.
bool recording_load(recording_t *self, const char *path);

void recording_free(recording_t *self);

#endif
