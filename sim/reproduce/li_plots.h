/// The figures of paper 2 for the simulated stand-in.
#ifndef RIG_REPRODUCE_LI_PLOTS_H
#define RIG_REPRODUCE_LI_PLOTS_H

#include <stdio.h>

#include "reproduce/li_rows.h"
#include "support/plot.h"

enum { LI_PLOTS = 10 };

/// Name of the k-th file.
const char *li_plot_file(int k);

/// Draws it into `svg`. False after a message.
bool li_plot(const plot_output_t *output, int k, const table_t *table, const rig_config_t *base);

#endif
