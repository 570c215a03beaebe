/// In place of the accesses in port/rp2350/access.h: registers that the tests see (rp2350.c).
#ifndef FAKES_RP2350_REG_H
#define FAKES_RP2350_REG_H

#include <stdint.h>

uint32_t reg_read(uint32_t address);
void reg_write(uint32_t address, uint32_t value);
uint32_t reg_address_of(const uint32_t *word);

#endif
