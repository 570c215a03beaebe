/// Switches the gates off by hardware if the interrupt does not come: TIM2, which gives the stamp and keeps
/// running while a debugger halts the core, reaches its compare value half a period after the interrupt was
/// due, and has the DMA
/// write TIM1's BDTR. MOE then stays off until the drive requests it again; by then the drive has tripped on
/// timing.
#include "chip.h"

#define REQUEST_TIM2_CH1 56u // RM0440, DMAMUX: assignment of multiplexer inputs

// Only MOE of BDTR can still be written: all else is locked.
static const uint32_t outputs_off = 0u;

void chip_deadline_init(void) {
    REG_SET(RCC->AHB1ENR, RCC_AHB1ENR_DMA1EN | RCC_AHB1ENR_DMAMUX1EN);
    REG_WRITE(DMAMUX1_Channel0->CCR, REQUEST_TIM2_CH1);
    REG_WRITE(DMA1_Channel1->CPAR, (uint32_t)(uintptr_t)&TIM1->BDTR);
    REG_WRITE(DMA1_Channel1->CMAR, (uint32_t)(uintptr_t)&outputs_off);
    REG_WRITE(DMA1_Channel1->CNDTR, 1u);
    // Memory to peripheral, words, always the same one, with the highest priority.
    REG_WRITE(DMA1_Channel1->CCR, DMA_CCR_DIR | DMA_CCR_CIRC | DMA_CCR_PSIZE_1 | DMA_CCR_MSIZE_1 |
                                      DMA_CCR_PL | DMA_CCR_EN);
    REG_SET(TIM2->DIER, TIM_DIER_CC1DE);
}
