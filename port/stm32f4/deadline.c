/// Switches the gates off by hardware if the interrupt does not come, as on the STM32G4. The DMA unit that TIM2
/// can trigger does not reach TIM1 in this family (RM0090, bus matrix); that of TIM8 does. TIM8 keeps running
/// while a debugger halts the core, wraps half a period after the interrupt was due, and makes the DMA write
/// TIM1's BDTR.
#include "chip.h"

#define PRESCALER 4u       // 16 bits then hold one and a half periods of 1 kHz
#define REQUEST_TIM8_UP 7u // channel of DMA2's stream 1 (RM0090, DMA2 request mapping)
#define CHANNEL_Pos 25u    // DMA_SxCR.CHSEL
#define TICKS (3u * (CHIP_F_PWM_Hz / PRESCALER / PORT_F_CALL_Hz) / 2u)

// Only MOE of BDTR can still be written: all else is locked.
static const uint32_t outputs_off = 0u;

void chip_deadline_init(void) {
    REG_SET(RCC->AHB1ENR, RCC_AHB1ENR_DMA2EN);
    REG_SET(RCC->APB2ENR, RCC_APB2ENR_TIM8EN);
    REG_CLEAR(DBGMCU->APB2FZ, DBGMCU_APB2_FZ_DBG_TIM8_STOP);
    REG_WRITE(DMA2_Stream1->PAR, (uint32_t)(uintptr_t)&TIM1->BDTR);
    REG_WRITE(DMA2_Stream1->M0AR, (uint32_t)(uintptr_t)&outputs_off);
    REG_WRITE(DMA2_Stream1->NDTR, 1u);
    // Memory to peripheral, words, always the same one, with the highest priority.
    REG_WRITE(DMA2_Stream1->CR, REQUEST_TIM8_UP << CHANNEL_Pos | DMA_SxCR_DIR_0 | DMA_SxCR_CIRC |
                                    DMA_SxCR_PSIZE_1 | DMA_SxCR_MSIZE_1 | DMA_SxCR_PL |
                                    DMA_SxCR_EN);
    REG_WRITE(TIM8->CR1, 0u);
    REG_WRITE(TIM8->PSC, PRESCALER - 1u);
    REG_WRITE(TIM8->ARR, TICKS - 1u);
    REG_WRITE(TIM8->EGR, TIM_EGR_UG); // loads the prescaler; no DMA request is enabled yet
    REG_WRITE(TIM8->DIER, TIM_DIER_UDE);
    REG_WRITE(TIM8->CR1, TIM_CR1_CEN);
}
