/// The gain guideline for the FA-LESO: the effect of k2 on stability, transients, harmonics and noise, and the
/// recommended k2 (docs/theory/fa_guideline.md).
#ifndef RIG_DESIGN_GUIDE_H
#define RIG_DESIGN_GUIDE_H

#include "analyse/joint.h"
#include "config/rig_config.h"

enum { GUIDE_ROWS = 14, GUIDE_SPEEDS = 4 };

/// Results for one k2. Angles in electrical degrees; values that depend on speed are the worst of the range.
typedef struct {
    double k2_rad_s, per_sigma;
    double damping;       ///< of the least damped common pole of observer and PLL
    double radius;        ///< largest |z|, with notches and further modes; below 1: stable
    double slowest_rad_s; ///< least -Re of the poles
    double step_deg;      ///< peak after the load step
    double ripple_deg;    ///< amplitude from 5th and 7th harmonic
    double noise_deg;     ///< rms from the noise of the currents
    double total_deg;     ///< step + ripple + 3 noise, at the worst speed
    // Gains of the observer, relative to the gain at the speed.
    double fifth_low, seventh_low, fifth_high, seventh_high;
    double offset, negative;
} guide_row_t;

typedef struct {
    bool adaptive; ///< the configuration has an FA observer; else one with k1 = 0 is evaluated
    double low_rad_s, high_rad_s; ///< range of speeds: full sigma .. rated
    double sigma_rad_s;
    double load_Nm, acceleration_rad_s2;
    double fifth, seventh; ///< shares of the EMF
    double noise_A;        ///< rms per phase
    double limit_theory;   ///< least k2 per sigma, continuous; 0: none
    double limit_sampled;  ///< at this period and sigma
    double used_rad_s, recommended_rad_s;
    int rows;
    guide_row_t row[GUIDE_ROWS]; ///< by rising k2; used and recommended ones are among them
} guide_t;

/// The guideline for a designed configuration that the library accepts, with the harmonics and the noise of
/// [plant]. No rows if the library refuses an FA-LESO instead of its observer.
void guide_compute(guide_t *guide, const rig_config_t *config);

/// Stable and well damped.
bool guide_fits(const guide_row_t *row);

/// The least stable k2 over sigma of FA-LESO and PLL together; 0 if every k2 is stable. `tuning` has
/// the FA observer.
double guide_k2_limit(const lode_estimator_tuning_t *tuning, const lode_emf_config_t *emf,
                      double omega_rad_s, double sigma_rad_s);

#endif
