/// One line of text over board_send() whenever a bring-up step ends:
///     3 FAIL SIGN phase 1 measured -1.000 limit 0.750
/// with the number of the step and lode_check_t where the reason is FAULT; and a line for other events. Octets
/// that the transmitter does not take now are sent in the next pass.
#ifndef LODESTAR_PORT_REPORT_H
#define LODESTAR_PORT_REPORT_H

#include "bringup.h"

/// A line "what name number" before the next output of report_poll(). Dropped if too much is waiting. Thread.
void report_event(const char *what, const char *name, uint32_t number);

/// True if the next line can be given. Thread.
bool report_is_sent(void);

/// A line "text". Thread, if report_is_sent().
void report_line(const char *text);

#define REPORT_GIVEN (-1.0f) ///< in place of a confidence

/// A line "key = value ; confidence 0.990", or "key = value ; given". Thread, if report_is_sent().
void report_setting(const char *key, float value, float confidence);

/// Thread, once per pass.
void report_poll(const bringup_result_t *result);

#endif
