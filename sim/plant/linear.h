/// The motor with one set of windings, linear iron and a sinusoidal EMF, over all gate edges of a period in one
/// loop.
///
/// In coordinates that stand still, those of the rotor at the start, the stator's flux linkage is
///     psi' = u - R i                                                                          (M16)
/// for any motion of the rotor, so a voltage that is constant between two edges is integrated exactly. The
/// currents follow
/// from it and from the angle delta turned since, with S, D = (1/Ld +- 1/Lq)/2:
///     i = S psi + D exp(2j delta) conj(psi) - psi_m/Ld exp(j delta)                           (M17)
/// so that only R i and the torque need quadrature: the trapezoidal rule between edges, and at the end a
/// correction of its error for the whole run by the second derivatives, -h^3/12 of them for each piece:
///     i'' = 4j w D exp(2j delta) conj(u) - 4 w^2 D exp(2j delta) conj(psi)
///           + w^2 psi_m/Ld exp(j delta) - R Y i',  Y v = S v + D exp(2j delta) conj(v)        (M18)
#ifndef PLANT_LINEAR_H
#define PLANT_LINEAR_H

#include "plant/inverter.h"

/// True if plant_linear_run() can continue from here: such a motor, with all phases conducting.
bool plant_linear_can_run(const plant_inverter_t *inverter, const plant_motor_t *motor);

/// Advances motor and inverter from now_s to until_s, to the instant at which a current stops, or to a stretch
/// that must be searched for such a change. Returns the time reached. `events_left` bounds the currents that
/// reverse.
double plant_linear_run(plant_inverter_t *inverter, plant_motor_t *motor, double now_s,
                        double until_s, int *events_left);

#endif
