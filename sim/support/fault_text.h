/// A fault of the drive in words.
#ifndef RIG_FAULT_TEXT_H
#define RIG_FAULT_TEXT_H

#include <stddef.h>

#include "lodestar/drive.h"

/// The enumerator without its prefix, as EMF.
const char *fault_text_criterion(const lode_fault_t *fault);

/// As TURN; NONE for a fault outside START.
const char *fault_text_stage(const lode_fault_t *fault);

/// "LODE_CHECK_INDUCTANCE in H, measured 0.017, limit 0.01", or "LODE_CHECK_START, measured 0.7, limit 3.2 (EMF in V,
/// stage TURN)"; for a failed attempt, which is not a fault, "EMF in V, stage TURN, measured 0.7, limit 3.2".
void fault_text(const lode_fault_t *fault, char *text, size_t size);

/// What a user may have to look at or to change; NULL: the check says it.
const char *fault_text_hint(const lode_fault_t *fault);

#endif
