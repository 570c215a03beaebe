/// The recorders of the example: a ring for the serial port and a scope around a fault. Their channels are at
/// the head of record.c; docs/telemetry.md describes the octets.
#ifndef LODESTAR_PORT_RECORD_H
#define LODESTAR_PORT_RECORD_H

#include "lodestar/lodestar.h"

/// Data sent with board_send().
typedef enum {
    LINK_REPORT, ///< a line of text per bring-up step
    LINK_RING,   ///< the telemetry ring, all the time
    LINK_SCOPE   ///< the scope's buffer, once, whenever a capture is done
} link_t;

/// Empties both. Thread, before the periods start.
lode_status_t record_init(float f_pwm_Hz);

/// Interrupt, after the duties are written.
void record_period(const lode_drive_t *drive);

/// Begins a capture with `trigger`: LODE_TRIGGER_FAULT, or LODE_TRIGGER_IMMEDIATE for what happens now.
/// Thread.
void record_arm(lode_trigger_t trigger);

/// Sends as much as the transmitter takes. False: the link is used by the report. Thread, once per pass.
bool record_poll(link_t link);

#endif
