/// What signal injection would be on a motor, whether it is switched on or not.
#ifndef RIG_DESIGN_INJECTION_H
#define RIG_DESIGN_INJECTION_H

#include <stdbool.h>

#include "lodestar/drive.h"

typedef struct {
    bool on;              ///< as configured
    lode_status_t status; ///< LODE_OK, or why the library would refuse it
    double saliency;      ///< Lq'/Ld at i_max, differential
    double V_h_V;
    double circle_share; ///< of it in the voltage circle
    double ripple_A;     ///< of the current along d, peak to peak
    double ripple_Nm;    ///< of the torque at i_max, peak to peak
    double tone_Hz;
    double noise_deg;     ///< of the angle, rms
    double dead_time_rad; ///< position error as a phase current passes through zero
    double id_A;          ///< 0: none
    double w1_rad_s, w2_rad_s, sigma_rad_s;
    double torque_Nm;    ///< the largest; NAN where it is refused
    double step_deg;     ///< angle error by a load of that size that turns round, while injecting
    double step_emf_deg; ///< the same by the EMF, from w2 on
    bool loses_steps;    ///< a QPLL that does not follow a rotor so light (P7)
} injection_t;

/// Of a configuration that is designed.
injection_t injection_of(const lode_drive_config_t *config);

#endif
