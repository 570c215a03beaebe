/// One shunt in the DC link (VARIANT_LINK): another compare value for either half of a period, and two
/// triggers in its second half.
///
/// TIM1 takes its compare values over at both turning points. In the first half the rising edges act, in the
/// second the falling ones. The interrupt, right after t_k, writes the falling ones and the two triggers;
/// the rising ones of the next period are brought in by the DMA shortly before it begins, when the falling
/// ones act and the interrupt has long computed them.
#ifndef LODESTAR_PORT_STM32G4_LINK_H
#define LODESTAR_PORT_STM32G4_LINK_H

#include "lodestar/lodestar.h"

/// Compare values of the next period's rising edges: what the DMA reads.
extern uint32_t chip_link_rise[3];

/// After stm32_pwm_init(). False: window or gain are refused.
bool chip_link_init(void);

/// The phase currents at t_k as counts, from the two samples of the period that ends there. False: a sample is
/// missing.
bool chip_link_read(uint16_t count[3]);

/// Edges and triggers of the next period.
void chip_link_write(const lode_drive_out_t *out);

#endif
