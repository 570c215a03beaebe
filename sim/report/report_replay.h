/// The results of a replay: table, CSV, JSON.
#ifndef RIG_REPORT_REPLAY_H
#define RIG_REPORT_REPLAY_H

#include <stdio.h>

#include "config/rig_config.h"
#include "rig/replay.h"

/// The values that the estimator used, and the source of each.
void report_replay_values(FILE *file, const rig_config_t *config);

void report_replay_table(FILE *file, const rig_config_t *config, const recording_t *recording,
                         const replay_t *replay);

/// One row per recorded row: t_s,theta_e_rad,omega_e_rad_s,e_alpha_V,e_beta_V,lock
void report_replay_csv(FILE *file, const recording_t *recording, const replay_t *replay);

void report_replay_json(FILE *file, const rig_config_t *config, const char *recording_path,
                        const recording_t *recording, const replay_t *replay);

#endif
