/// Notch at a harmonic of the speed inside the position PLL, active only where the loop is stable with it.
#ifndef LODESTAR_NOTCH_H
#define LODESTAR_NOTCH_H

#include "lodestar/ramp.h"
#include "lodestar/sogi.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Below its centre the notch reduces the phase of the loop, which is unstable if the harmonic is below about 2
/// sigma. The notch fades in between these multiples of sigma (docs/theory/pll.md).
#define LODE_NOTCH_LOW_SIGMA 6.0f
#define LODE_NOTCH_HIGH_SIGMA 8.0f

/// All that is derived from the configuration. LODE_WITHOUT_NOTCH leaves the notches out of a build: a
/// configuration that requests them is then refused (LODE_ERROR_NOTCH), and a tuning made by another build runs
/// without them.
typedef struct {
    float k;        ///< relative width; 0: no notch
    float order_Ts; ///< order of the harmonic times Ts
    /// 1/(difference of the centres at which the notch is fully in and fully out, rad per sample)
    float inv_span;
} lode_notch_tuning_t;

/// `order`: harmonic of the electrical speed. `k`: relative width, 0.01 .. 2; 0: no notch.
lode_status_t lode_notch_tune(lode_notch_tuning_t *tuning, float order, float k, float sigma_rad_s,
                              float ts_s);

/// State of the notch.
typedef struct {
    lode_sogi_t sogi;
    float g; ///< as in lode_sogi_tuning_t, for the harmonic at the present speed
    float inv_sum;
    float weight; ///< 0: the notch is out, 1: fully in
} lode_notch_t;

/// Moves the centre to the harmonic of `omega_rad_s` and sets the relative width `k`: that of the tuning, or that
/// of a notch at another harmonic, with `omega_rad_s` scaled accordingly. Once in LODE_SLOW_PERIODS is enough.
void lode_notch_adapt(lode_notch_t *self, const lode_notch_tuning_t *tuning, float k,
                      float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
