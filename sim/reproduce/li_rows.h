/// The claims of paper 2, experiment by experiment, with the measured values.
#ifndef RIG_REPRODUCE_LI_ROWS_H
#define RIG_REPRODUCE_LI_ROWS_H

#include "reproduce/li_case.h"
#include "reproduce/rows.h"
#include "reproduce/table.h"

/// Runs every experiment. False after a message.
bool li_reproduction_run(table_t *table, const rig_config_t *base,
                         const reproduce_extent_t *extent);

/// Experiments that are drawn, too.
li_case_t li_steady_case(li_observer_t observer, double load_Nm);
li_case_t li_set_1_case(li_observer_t observer);
li_case_t li_ramp_case(li_observer_t observer);
li_case_t li_step_case(li_observer_t observer, double k2_rad_s);

/// Bandwidths of the sweep, rad/s, and one of its experiments: the harmonics of set 1 at 300 rpm.
enum { LI_SWEEP = 8 };
extern const double li_sweep_k2[LI_SWEEP];
li_case_t li_sweep_case(double k2_rad_s, bool load_step);

#endif
