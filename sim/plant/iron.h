/// Iron that saturates: both fluxes and the differential inductances from one co-energy, and back.
///
/// The flux linkages, less the magnet's, are the gradient (M12) of a co-energy
///     W(id, iq) = D(id) + Q(iq) + X(id, iq)                                              (M11) (M13)
/// so dpsi_d/diq = dpsi_q/did at every current, and the field energy is a function of state. W is
/// convex (plant_iron_check), so every pair of fluxes belongs to exactly one pair of currents.
#ifndef PLANT_IRON_H
#define PLANT_IRON_H

#include "plant/config.h"

typedef struct {
    const plant_map_t *map; ///< replaces all following fields but smallest_L_H; NULL: none
    double Ld_H, Lq_H, Lq_sat_H;
    double Ld_fall;    ///< share of Ld_H lost at large positive id, and added at large negative id
    double inv_id_sat; ///< 0: D is linear
    double inv_i_sat;  ///< 0: Q is linear
    double i_cross_A;  ///< scale of X, sqrt(3) times the current of the largest Ldq_H
    double cross_H;    ///< size of X, 0: none
    double smallest_L_H; ///< no differential inductance in any direction is less
} plant_iron_t;

/// Flux linkages without the magnet's and differential inductances at a pair of currents.
typedef struct {
    double psi_d_Wb, psi_q_Wb;
    double Ldd_H, Ldq_H, Lqq_H;
} plant_iron_point_t;

/// Slope of the currents per volt, 1/H: the inverse of the differential inductances.
typedef struct {
    double dd, dq, qq;
} plant_iron_answer_t;

/// NULL, or the error of the inductances.
const char *plant_iron_check(const plant_config_t *config);

/// True if anything saturates.
bool plant_iron_saturates(const plant_config_t *config);

void plant_iron_init(plant_iron_t *self, const plant_config_t *config);

plant_iron_point_t plant_iron_at(const plant_iron_t *self, double id_A, double iq_A);

plant_iron_answer_t plant_iron_answer(const plant_iron_point_t *at);

/// The currents for two fluxes, to rounding, from an initial guess.
void plant_iron_currents(const plant_iron_t *self, double psi_d_Wb, double psi_q_Wb, double *id_A,
                         double *iq_A);

/// Energy of the magnetic field at these currents relative to no current, J/1.5: id psi_d + iq psi_q - W (M14).
double plant_iron_energy(const plant_iron_t *self, double id_A, double iq_A);

#endif
