/// One line of text over board_send() whenever a bring-up step ends:
///     3 FAIL SIGN phase 1 measured -1.000 limit 0.750
/// with the number of the step, lode_check_t where the reason is FAULT, and no end of patience: what the
/// transmitter does not take now goes out in the next pass.
#ifndef LODESTAR_PORT_REPORT_H
#define LODESTAR_PORT_REPORT_H

#include "bringup.h"

/// Thread, once per pass.
void report_poll(const bringup_result_t *result);

#endif
