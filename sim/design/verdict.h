/// The verdict on a design: speed range, largest load steps, margins, and what to change.
#ifndef RIG_DESIGN_VERDICT_H
#define RIG_DESIGN_VERDICT_H

#include <stdbool.h>

#include "analyse/own_loops.h"
#include "config/speed_limits.h"

enum { VERDICT_LOW, VERDICT_HIGH, VERDICT_SPEEDS };
enum {
    VERDICT_CHANGES_MAX = 12,
    VERDICT_TEXT = 160,
    VERDICT_HELP = 640,
    VERDICT_WAYS_MAX = 3,
    VERDICT_KEYS_MAX = 4,
    VERDICT_ASSIGNMENT = 64
};

/// The largest load step (K18).
typedef struct {
    double omega_rad_s; ///< electrical speed at which it occurs
    double torque_Nm;
    double share;    ///< of the torque of i_max/1.5 at id = 0
    bool by_current; ///< limited by i_max, not by the speed dip
} verdict_step_t;

/// Values that remove a complaint together, as --set takes them.
typedef struct {
    int assignments;
    char assignment[VERDICT_KEYS_MAX][VERDICT_ASSIGNMENT];
} verdict_way_t;

typedef struct {
    const char *key;         ///< for programs
    char text[VERDICT_TEXT]; ///< what is wrong
    char help[VERDICT_HELP]; ///< what to do about it
    int ways;                ///< found by trial (advice.h); 0: none
    verdict_way_t way[VERDICT_WAYS_MAX];
} verdict_change_t;

typedef struct {
    double lowest_rad_s;  ///< electrical; 0 with injection
    double highest_rad_s; ///< allowed by both voltage and estimator
    double rated_torque_Nm;
    /// at the higher of hand-over speed and least speed; at base speed
    verdict_step_t step[VERDICT_SPEEDS];
    /// the same lowest speed, with the EMF; rated speed or the estimator's limit
    double loop_rad_s[VERDICT_SPEEDS];
    own_margins_t loop[VERDICT_SPEEDS];
    int changes;
    verdict_change_t change[VERDICT_CHANGES_MAX];
} verdict_t;

/// For a designed configuration, its tuning and its speeds.
void verdict_compute(verdict_t *verdict, const lode_drive_config_t *drive,
                     const lode_drive_tuning_t *tuning, const speed_limits_t *speeds);

#endif
