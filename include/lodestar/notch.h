/// A notch at a harmonic of the speed, inside the position PLL, where the loop is stable with it.
#ifndef LODESTAR_NOTCH_H
#define LODESTAR_NOTCH_H

#include "lodestar/ramp.h"
#include "lodestar/sogi.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Inside the loop the notch costs phase below its centre: the loop is unstable where the harmonic
/// is under about 2 sigma. It fades in over these multiples of sigma (docs/theory/pll.md).
#define LODE_NOTCH_LOW_SIGMA 6.0f
#define LODE_NOTCH_HIGH_SIGMA 8.0f

/// LODE_WITHOUT_NOTCH leaves the notches out of a build; init then refuses them (LODE_ERROR_NOTCH), and a
/// tuning from elsewhere that asks for them runs without.
typedef struct {
    float k;        ///< relative width; 0: no notch
    float order_Ts; ///< harmonic order times Ts
    float
        inv_span; ///< 1/(rad per sample from which it is in full, less that up to which it stays out)
} lode_notch_tuning_t;

/// `order`: harmonic of the electrical speed; `k`: 0 (none) or 0.01 .. 2.
lode_status_t lode_notch_tune(lode_notch_tuning_t *tuning, float order, float k, float sigma_rad_s,
                              float ts_s);

typedef struct {
    lode_sogi_t sogi;
    float g; ///< as in lode_sogi_tuning_t, tuned to the harmonic of the present speed
    float inv_sum;
    float weight; ///< 0: the notch is out, 1: in full
} lode_notch_t;

/// Moves the centre to the harmonic of `omega_rad_s`, with the relative width `k`: the tuning's, or that of a
/// notch at another harmonic that is given its share of the speed. Speed moves slowly: every few periods is
/// enough.
void lode_notch_adapt(lode_notch_t *self, const lode_notch_tuning_t *tuning, float k,
                      float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
