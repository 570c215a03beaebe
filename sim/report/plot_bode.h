/// Bode diagrams of an analysis, as SVG.
#ifndef RIG_PLOT_BODE_H
#define RIG_PLOT_BODE_H

#include <stdbool.h>
#include <stdio.h>

#include "analyse/analyse.h"
#include "support/plot.h"

/// One picture: one or two figures side by side, and a pole map if `poles` is set.
typedef struct {
    const char *file; ///< name without folder
    const char *title;
    const char *figure[2]; ///< the second may be NULL
    const char *heading[2];
    const char *poles;   ///< figure whose poles are in the second column; NULL: none
    bool two_sided;      ///< negative frequencies in the first column, positive in the second
    double gain_dB[2];   ///< range of the gain
    bool falls_from_270; ///< phases that begin above 60 degrees are drawn one turn lower
} plot_bode_t;

enum { PLOT_BODE_COUNT = 11 };

/// The pictures of the papers' figures.
extern const plot_bode_t plot_bode_all[PLOT_BODE_COUNT];

/// False after a message.
bool plot_bode(const plot_output_t *output, const plot_bode_t *picture, const analyse_t *analysis);

#endif
