/// Stability margins of the PLL, in double, from the gains of the firmware.
///
/// Open loop in the z-plane: O(z) = C A (zI - A)^-1 L, with A the motion over one period, L the
/// gains. The EMF observer H before it responds to a small oscillation of the EMF's angle with the mean of both
/// side bands of the carrier rho = exp(j w Ts):
///     G(z) = (H(rho z)/H(rho) + conj(H(rho/z)/H(rho)))/2.
/// An observer that rotates with the speed closes a second loop: O - F W, with F the angle that a deviation
/// of that speed makes and W the speed per error, both of analyse/joint.h. C-LESO does not rotate; its loop is
/// O G, as if the angle acted on the current and so on the EMF. Notches are included with their blending.
#ifndef RIG_MARGINS_H
#define RIG_MARGINS_H

#include <complex.h>
#include <stdbool.h>

#include "lodestar/drive.h"

typedef struct {
    double sigma_rad_s;
    double crossover_rad_s; ///< of the PLL alone
    double phase_alone_deg; ///< its phase margin alone
    double phase_deg;       ///< with the observer in the loop
    double gain_up_dB;   ///< allowed increase of gain with the observer in the loop; NaN: no limit
    double gain_down_dB; ///< allowed decrease of gain; NaN: no limit
    /// sigma at which the phase margin with the observer is zero; NaN: none
    double sigma_limit_rad_s;
} margins_t;

/// Margins at the electrical speed `omega_rad_s`, with sigma as it is scheduled there.
margins_t margins_at(const lode_drive_config_t *config, double omega_rad_s);

/// Its phase_deg alone, a tenth of the work.
double margins_phase_deg(const lode_drive_config_t *config, double omega_rad_s);

/// The open loop of the PLL at this electrical speed, at the frequencies given, in the rotor's frame: alone, or
/// with observer and notches.
void margins_open_loop(const lode_drive_config_t *config, bool alone, double omega_rad_s, int count,
                       const double *Omega_rad_s, double complex *value);

/// Estimated over true speed for an oscillation of the rotor about this speed.
void margins_speed_response(const lode_drive_config_t *config, double omega_rad_s, int count,
                            const double *Omega_rad_s, double complex *value);

/// sigma at the electrical speed given.
double margins_sigma(const lode_pll_config_t *pll, double omega_rad_s, double ts_s);

/// The largest sigma that the library accepts with the rest as it is, both ends of the schedule.
double margins_sigma_accepted(const lode_drive_config_t *config);

#endif
