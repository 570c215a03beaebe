/// Checks the running drive from outside: compares the plant with the estimates of the drive.
#ifndef EMULATOR_JUDGE_H
#define EMULATOR_JUDGE_H

#include "plant.h"

/// Length of a run, 3 s: start, hand-over, ramp, and more than half a second of settled speed.
#define JUDGE_PERIODS 15000u
/// The last periods, for which the bands apply.
#define JUDGE_SETTLED_PERIODS 2500u
/// Band of the true speed around the command, in every period.
#define JUDGE_SPEED_BAND 0.002f // 3 rpm
/// Limits of the angle error, at the end and at any time in RUN, hand-over included.
#define JUDGE_ANGLE_SETTLED_rad 0.00873f // half a degree
#define JUDGE_ANGLE_RUN_rad                                                                        \
    0.217f // 12.4 degrees: the largest of 60 (docs/observer-choice.md, starts)

/// Takes one period: `plant` at its start, `now` the telemetry of the drive. Call in the period.
void judge_note(const plant_t *plant, const lode_telemetry_t *now);

/// The run is over. From anywhere.
bool judge_done(void);

/// Prints every value with its limit. True: all limits are met.
bool judge_verdict(void);

#endif
