/// In place of the accesses in port/ti_am263x/access.h: registers that the tests see (am263x.c).
#ifndef FAKES_TI_AM263X_REG_H
#define FAKES_TI_AM263X_REG_H

uint16_t reg_read16(uint32_t address);
void reg_write16(uint32_t address, uint32_t value);
uint32_t reg_read32(uint32_t address);
void reg_write32(uint32_t address, uint32_t value);
uint32_t reg_cycles(void);
void reg_interrupts_on(void);

#endif
