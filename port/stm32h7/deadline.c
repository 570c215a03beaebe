/// Switches the gates off by hardware if the interrupt does not come, as on the STM32G4: TIM2, which gives the
/// stamp and keeps running while a debugger halts the core, reaches its compare value half a period after the
/// interrupt was due,
/// and has the DMA write TIM1's BDTR.
#include "chip.h"

#define REQUEST_TIM2_CH1 18u // RM0433, DMAMUX1: assignment of requests

// Only MOE of BDTR can still be written: all else is locked. In flash: this DMA reaches no TCM.
static const uint32_t outputs_off = 0u;

void chip_deadline_init(void) {
    REG_SET(RCC->AHB1ENR, RCC_AHB1ENR_DMA1EN);
    REG_WRITE(DMAMUX1_Channel0->CCR, REQUEST_TIM2_CH1);
    REG_WRITE(DMA1_Stream0->PAR, (uint32_t)(uintptr_t)&TIM1->BDTR);
    REG_WRITE(DMA1_Stream0->M0AR, (uint32_t)(uintptr_t)&outputs_off);
    REG_WRITE(DMA1_Stream0->NDTR, 1u);
    // Memory to peripheral, words, always the same one, with the highest priority.
    REG_WRITE(DMA1_Stream0->CR, DMA_SxCR_DIR_0 | DMA_SxCR_CIRC | DMA_SxCR_PSIZE_1 |
                                    DMA_SxCR_MSIZE_1 | DMA_SxCR_PL | DMA_SxCR_EN);
    REG_SET(TIM2->DIER, TIM_DIER_CC1DE);
}
