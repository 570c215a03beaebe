/// What removes a complaint of the verdict: each way is applied to a copy of the configuration and judged again.
#ifndef RIG_DESIGN_ADVICE_H
#define RIG_DESIGN_ADVICE_H

#include "config/rig_config.h"
#include "design/verdict.h"

/// Replaces the help of each change by the ways that remove it without a new complaint, with their values; where none
/// does, the help stays. `read`: the configuration as the files and --set give it, before rig_config_complete();
/// `config`: the designed one that was judged.
void advice_find(verdict_t *verdict, const rig_config_t *read, const rig_config_t *config);

#endif
