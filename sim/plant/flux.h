/// The magnet's flux and its EMF, with harmonics.
#ifndef PLANT_FLUX_H
#define PLANT_FLUX_H

#include "plant/motor.h"

/// Fills the harmonics of a motor whose other constants are set.
void plant_flux_init(plant_motor_t *self, const plant_config_t *config);

/// h_d, h_q of (M1), (M2) at an angle, Wb.
void plant_flux_ripple(const plant_motor_t *self, double cos_theta, double sin_theta, double *h_d,
                       double *h_q);

/// h_x, h_y of (M6): the slope of psi r5/5 exp(j(5 theta + p5)) + psi r7/7 exp(-j(7 theta + p7)).
plant_vector_t plant_flux_ripple_xy(const plant_motor_t *self, double cos_theta, double sin_theta);

/// Flux linkage in both planes; its change is the integral of the open EMF.
plant_planes_t plant_flux_magnet(const plant_motor_t *self, const plant_motor_state_t *state);

/// EMF in both planes with no current at all.
plant_planes_t plant_flux_open_emf(const plant_motor_t *self, const plant_motor_state_t *state);

#endif
