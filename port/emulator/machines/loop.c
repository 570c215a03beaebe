/// Machines without a timer: the main loop calls the period, one call per period.
#include "machine.h"
#include "plant.h"

static uint32_t entries;

void machine_start(void) {
    entries = 0u;
}

void machine_wait(void) {
    entries++;
    emulator_period();
}

uint32_t machine_stamp(void) {
    return entries * PLANT_STAMP_PER_PERIOD;
}

bool machine_has_timer(void) {
    return false;
}

uint32_t machine_entries(void) {
    return entries;
}

uint32_t machine_elapsed(void) {
    return entries;
}
