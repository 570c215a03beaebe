/// One shunt in the DC link (VARIANT_LINK): separate compare values for the two halves of a period, and two
/// triggers in its second half.
///
/// TIM1 loads its compare values at both turning points. The rising edges act in the first half, the falling
/// ones in the second. Right after t_k the interrupt writes the falling ones and the two triggers. The DMA
/// writes the rising ones of the next period shortly before it begins; by then the falling ones act, and the
/// interrupt has computed the rising ones.
#ifndef LODESTAR_PORT_STM32G4_LINK_H
#define LODESTAR_PORT_STM32G4_LINK_H

#include "lodestar/lodestar.h"

/// Compare values of the next period's rising edges; the DMA reads them.
extern uint32_t chip_link_rise[3];

/// Call after stm32_pwm_init(). False: window or gain are refused.
bool chip_link_init(void);

/// The phase currents at t_k as counts, from the two samples of the period that ends there. False: a sample is
/// missing, or the DMA has not written the rising edges of the plan.
bool chip_link_read(uint16_t count[3]);

/// Edges and triggers of the next period.
void chip_link_write(const lode_drive_out_t *out);

#endif
