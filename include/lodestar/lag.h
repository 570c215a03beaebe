/// Phase lag of an EMF observer over speed, as an odd polynomial that init fits to the exact lag.
#ifndef LODESTAR_LAG_H
#define LODESTAR_LAG_H

#include "lodestar/emf.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LODE_LAG_TERMS 6
/// Largest deviation of the polynomial from the exact lag that init accepts: 0.01 degree.
#define LODE_LAG_TOLERANCE_rad 1.7e-4f

/// Lag that is compensated in the angle of the PLL.
typedef enum {
    LODE_LAG_EXACT, ///< the exact lag of the discrete observer
    LODE_LAG_NONE,  ///< none: the angle lags as in paper 1, Fig. 13
    LODE_LAG_EQ30   ///< 2 atan(w/w0), paper 1, eq. (30): C-LESO in continuous time, for comparison
} lode_lag_kind_t;

/// The polynomial.
typedef struct {
    float inv_range2;                  ///< 1/omega^2 at the end of the fitted range
    float coefficient[LODE_LAG_TERMS]; ///< lag/omega in powers of (omega/range)^2, s
} lode_lag_t;

/// Fits the lag of the observer of `config` over +-omega_max_rad_s. Error: LAG, if the deviation is more than
/// LODE_LAG_TOLERANCE_rad or `kind` is unknown; `lag` is then left alone.
lode_status_t lode_lag_tune(lode_lag_t *lag, lode_lag_kind_t kind, const lode_emf_config_t *config,
                            const lode_motor_t *motor, float ts_s, float omega_max_rad_s);

/// The lag as a straight line near one speed. Speed changes slowly, so the line is good for a few periods.
typedef struct {
    lode_sincos_t at; ///< sine and cosine of the lag at `omega_rad_s`
    float omega_rad_s;
    float slope_s; ///< d lag/d omega
} lode_lag_line_t;

#ifdef __cplusplus
}
#endif

#endif
