/// Second-order generalised integrator, prewarped: a notch, and the in-phase and quadrature signals at its centre.
///
/// Notch: paper 1, eq. (34), (s^2 + wn^2)/(s^2 + k wn s + wn^2), discretised by the trapezoidal rule and prewarped
/// at wn: the gain is exactly 0 at wn and 1 at DC, at any sample rate. The notch removes the in-phase signal. The
/// states are those of the two integrators, so the centre may change from call to call without a jump (B6-B8).
#ifndef LODESTAR_SOGI_H
#define LODESTAR_SOGI_H

#include "lodestar/frames.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LODE_SOGI_CENTRE_MIN_rad 1.0e-4f ///< lowest centre, rad per sample
#define LODE_SOGI_CENTRE_MAX_rad 2.5f    ///< highest centre: 0.8 pi, short of Nyquist

/// State: two integrators.
typedef struct {
    float band; ///< integrator of the band-pass
    float low;  ///< integrator of the low-pass
} lode_sogi_t;

/// Outputs of one sample.
typedef struct {
    float notch;      ///< the input without its component at wn
    float in_phase;   ///< the component at wn
    float quadrature; ///< the same a quarter period later
} lode_sogi_out_t;

/// Coefficients for a width and a centre (B7).
typedef struct {
    float width;
    float g;       ///< tan(wn Ts/2): the gain of the prewarped integrator
    float inv_sum; ///< 1/(1 + g (k + g))
} lode_sogi_tuning_t;

/// Clears the state.
void lode_sogi_reset(lode_sogi_t *self);

/// Coefficients. k: relative width of the band, clamped to 0.001 .. 2. wn_Ts: centre in rad per sample, clamped to
/// LODE_SOGI_CENTRE_*. May be called again at any time; the states remain.
lode_sogi_tuning_t lode_sogi_tune(float k, float wn_Ts);

#ifdef __cplusplus
}
#endif

#endif
