/// Looks at the running drive from outside: what the plant really does against what the drive believes.
#ifndef EMULATOR_JUDGE_H
#define EMULATOR_JUDGE_H

#include "plant.h"

/// Length of a run, 3 s: start, hand-over, ramp, and more than half a second of settled speed.
#define JUDGE_PERIODS 15000u
/// The last ones, for which the bands hold.
#define JUDGE_SETTLED_PERIODS 2500u
/// True speed against the commanded one, in every period.
#define JUDGE_SPEED_BAND 0.002f // 3 rpm
/// Estimated angle against the true one, at the end and at any time in RUN, hand-over included.
#define JUDGE_ANGLE_SETTLED_rad 0.00873f // half a degree
#define JUDGE_ANGLE_RUN_rad                                                                        \
    0.111f // 6.36 degrees: nine of ten hand-overs (docs/observer-choice.md, starts)

/// One period: `plant` at its start, `now` what the drive made of it. From where the period runs.
void judge_note(const plant_t *plant, const lode_telemetry_t *now);

/// The run is over. From anywhere.
bool judge_done(void);

/// Prints every figure with its limit. True: all are met.
bool judge_verdict(void);

#endif
