/// Runs one scenario with many seeds: prints a line for each, and how many passed.
#ifndef RIG_CAMPAIGN_H
#define RIG_CAMPAIGN_H

#include "support/diag.h"
#include "support/options.h"

/// RIG_FAILED if any seed failed.
rig_exit_t campaign(const options_t *options);

#endif
