/// Properties of signal injection on a motor, whether it is switched on or not.
#ifndef RIG_DESIGN_INJECTION_H
#define RIG_DESIGN_INJECTION_H

#include <stdbool.h>

#include "lodestar/drive.h"

typedef struct {
    bool on;              ///< as configured
    lode_status_t status; ///< LODE_OK, or why the library would refuse it
    double saliency;      ///< Lq'/Ld at i_max, differential
    double V_h_V;
    double circle_share; ///< share of the voltage circle
    double ripple_A;     ///< of the current along d, peak to peak
    double ripple_Nm;    ///< of the torque at i_max, peak to peak
    double tone_Hz;
    double noise_deg;     ///< of the angle, rms
    double dead_time_rad; ///< position error when a phase current passes through zero
    double id_A;          ///< 0: none
    double w1_rad_s, w2_rad_s, sigma_rad_s;
    double torque_Nm;    ///< the largest; NAN if refused
    double step_deg;     ///< angle error after a reversal of a load of that size, with injection
    double step_emf_deg; ///< the same with the EMF, from w2 on
    bool loses_steps;    ///< a QPLL that does not follow so light a rotor (P7)
    bool recommended; ///< possible, and the current vector of a start has too little torque (S54)
} injection_t;

/// For a designed configuration.
injection_t injection_of(const lode_drive_config_t *config);

#endif
