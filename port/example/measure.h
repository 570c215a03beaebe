/// The mode "commission": the drive measures motor and inverter by itself (lodestar/commission.h), and the values go over the
/// serial port as the lines of a motor file, for `lodestar design --motor F.ini`:
///     Rs_Ohm = 7.4934e-01 ; confidence 1.000
/// A value with a confidence below LODE_COMMISSION_SURE is the given one; pole pairs cannot be measured: "; given".
#ifndef LODESTAR_PORT_MEASURE_H
#define LODESTAR_PORT_MEASURE_H

#include "bringup.h"

/// Begins on `drive` and two tunings, which it uses until measure_end(). `given` is not designed: the values that are open
/// follow from what is measured. Thread; the interrupt already calls measure_step(). False: the result says why not.
bool measure_begin(lode_drive_t *drive, lode_drive_tuning_t tuning[2],
                   const lode_drive_config_t *given);

/// In place of lode_drive_step(). Gates off before measure_begin() and after measure_end(). Interrupt.
lode_drive_out_t measure_step(const lode_counts_t *counts);

/// One pass without waiting, except for the design of a tuning. Thread. RUNNING until the end.
bringup_result_t measure_poll(void);

/// Ends it in any state. Thread.
void measure_end(void);

/// The given configuration with the measured values; NULL if it has not passed.
const lode_drive_config_t *measure_config(void);

#endif
