/// The papers' figures and tables from theory, and from the firmware's coefficients.
///
/// "Theory" is the continuous formula, "sampled" the firmware's recursion at the drive's period,
/// with the coefficients that the library's own tuning functions produce.
#ifndef RIG_ANALYSE_H
#define RIG_ANALYSE_H

#include "analyse/result.h"
#include "config/rig_config.h"

/// Computes everything for a designed configuration. LODE_OK, or why the library refuses it.
lode_status_t analyse_compute(analyse_t *self, const rig_config_t *config);

#endif
