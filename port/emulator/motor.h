/// The motor in the image: paper 1's interior-magnet machine of 1 kW (its Table 3). Both the drive and plant.c
/// use these values.
#ifndef EMULATOR_MOTOR_H
#define EMULATOR_MOTOR_H

#include "lodestar/lodestar.h"

static inline lode_motor_t motor_data(void) {
    return (lode_motor_t){.pole_pairs = 3.0f,
                          .Rs_Ohm = 0.75f,
                          .Ld_H = 3.5e-3f,
                          .Lq_H = 9.8e-3f,
                          .psi_Wb = 0.142f,
                          .J_kgm2 = 0.0174f,
                          .B_Nms = 7.5e-4f};
}

#define MOTOR_I_MAX_A 12.0f
#define MOTOR_SPEED_rad_s 157.0796f // 1500 rpm

#endif
