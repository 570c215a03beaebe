/// The figures of paper 1 for the simulated machine.
#ifndef RIG_REPRODUCE_PLOTS_H
#define RIG_REPRODUCE_PLOTS_H

#include <stdio.h>

#include "reproduce/rows.h"
#include "support/plot.h"
#include "support/stats.h"

enum { REPRODUCE_PLOTS = 8 };

/// Name of the k-th file.
const char *reproduce_plot_file(int k);

/// Draws it into `svg`. False after a message.
bool reproduce_plot(const plot_output_t *output, int k, const reproduction_t *reproduction,
                    const case_bases_t *bases);

#endif
