/// Flux maps from CSV files: columns i_d, i_q (A), psi_d, psi_q (Wb), amplitude invariant, one row for each
/// node of a grid, in any order.
#ifndef RIG_FLUX_MAP_H
#define RIG_FLUX_MAP_H

#include "plant/map.h"

/// The map of a file, read once per process. NULL after a message.
const plant_map_t *flux_map_find(const char *path);

#endif
