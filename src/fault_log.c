#include "lodestar/fault_log.h"

#include <stddef.h>

#define COUNT_MAX 1000u // a product of two is far from an overflow

// In a block the newest row comes first. A row that was never written has 0 steps.
static lode_telemetry_t *row_at(const lode_fault_log_t *self, uint32_t block, uint32_t row) {
    return &self->buffer[block * self->rows + row];
}

static void begin_block(lode_fault_log_t *self, uint32_t block) {
    self->block = block;
    for (uint32_t row = 0u; row < self->rows; row++) {
        *row_at(self, block, row) = (lode_telemetry_t){.steps = 0u};
    }
}

void lode_fault_log_erase(lode_fault_log_t *self) {
    self->total = 0u;
    self->held = 0u;
    begin_block(self, 0u);
}

lode_status_t lode_fault_log_init(lode_fault_log_t *self, lode_telemetry_t *buffer, uint32_t faults,
                                  uint32_t rows) {
    if (self == NULL || buffer == NULL) {
        return LODE_ERROR_NULL;
    }
    if (faults < 1u || faults > COUNT_MAX || rows < 1u || rows > COUNT_MAX) {
        return LODE_ERROR_BUFFER;
    }
    *self = (lode_fault_log_t){.buffer = buffer, .faults = faults, .rows = rows};
    lode_fault_log_erase(self);
    return LODE_OK;
}

// The row of the trip, for the fault `back` before the last one.
static lode_telemetry_t *tripped_row(const lode_fault_log_t *self, uint32_t back) {
    const uint32_t blocks = self->faults + 1u;
    return row_at(self, (self->block + blocks - 1u - back) % blocks, 0u);
}

bool lode_fault_log_step(lode_fault_log_t *self, const lode_telemetry_t *telemetry) {
    const bool fault = telemetry->mode == LODE_MODE_FAULT;
    const bool noted = fault && self->faulted && self->trips == telemetry->trips;
    self->faulted = fault;
    self->trips = telemetry->trips;
    if (noted) { // the same fault, perhaps named more precisely
        tripped_row(self, 0u)->fault = telemetry->fault; // if erased meanwhile, an unused row
        return false;
    }
    // Shifts the rows one by one: compilers would turn the shift of an array into a call of memmove.
    lode_telemetry_t moved = *telemetry;
    for (uint32_t row = 0u; row < self->rows; row++) {
        const lode_telemetry_t older = *row_at(self, self->block, row);
        *row_at(self, self->block, row) = moved;
        moved = older;
    }
    if (fault) {
        self->total++;
        self->held = self->held < self->faults ? self->held + 1u : self->held;
        begin_block(self, self->block < self->faults ? self->block + 1u : 0u);
    }
    return fault;
}

uint32_t lode_fault_log_count(const lode_fault_log_t *self) {
    return self->held;
}

const lode_telemetry_t *lode_fault_log_row(const lode_fault_log_t *self, uint32_t back,
                                           uint32_t row) {
    if (back >= self->held || row >= self->rows) {
        return NULL;
    }
    const lode_telemetry_t *found = &tripped_row(self, back)[row];
    return found->steps > 0u ? found : NULL;
}
