/// Flux linkages of a real machine on a grid of currents, from measurements or finite elements.
///
/// The map interpolates one co-energy (M15), a bicubic Hermite surface whose slopes at the nodes are the
/// given fluxes: reciprocity and energy are exact everywhere, as in iron.h.
#ifndef PLANT_MAP_H
#define PLANT_MAP_H

#include <stdbool.h>

enum {
    PLANT_MAP_LEAST = 4,  ///< nodes of an axis
    PLANT_MAP_MOST = 301, ///< the same
};

/// One node: co-energy, its slopes (the fluxes without the magnet's), and its mixed slope.
typedef struct {
    double W, d, q, dq;
} plant_map_node_t;

typedef struct {
    int rows, columns;
    double id_A[PLANT_MAP_MOST]; ///< of the rows, rising
    double iq_A[PLANT_MAP_MOST]; ///< of the columns, rising
    double psi_Wb;               ///< the magnet's: psi_d without current
    double psi_q_Wb;             ///< without current
    double W_J;                  ///< the same
    double Ld_H, Lq_H;           ///< without current
    double smallest_L_H;         ///< over the whole map
    plant_map_node_t *node;      ///< row by row
} plant_map_t;

/// Co-energy, its slopes and its second derivatives.
typedef struct {
    double W, d, q, dd, dq, qq;
} plant_map_value_t;

/// The error of a map, and its place.
typedef struct {
    const char *why; ///< NULL: nothing
    int row, column; ///< of the cell's first node
    double found;    ///< inductance, H
} plant_map_fault_t;

/// Takes the fluxes of every node, row by row, and computes the surface. `self` has rows, columns, currents,
/// which include zero, and room for its nodes.
plant_map_fault_t plant_map_init(plant_map_t *self, const double *psi_d_Wb, const double *psi_q_Wb);

/// Beyond the edges the inductances stay those of the edge. There neither machine nor energy are those of the
/// map: see plant_map_holds().
plant_map_value_t plant_map_at(const plant_map_t *self, double id_A, double iq_A);

bool plant_map_holds(const plant_map_t *self, double id_A, double iq_A);

#endif
