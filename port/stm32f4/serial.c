#include "chip.h"

#define BAUD 115200u

void chip_serial_init(uint32_t f_clock_Hz) {
    static const stm32_pin_t tx = VARIANT_TX_PIN;
    REG_SET(RCC->APB1ENR, RCC_APB1ENR_USART3EN);
    REG_WRITE(USART3->BRR, (f_clock_Hz + BAUD / 2u) / BAUD);
    REG_WRITE(USART3->CR1, USART_CR1_TE | USART_CR1_UE);
    gpio_alternate(tx);
}

uint32_t chip_serial_send(const uint16_t *octets, uint32_t count) {
    uint32_t taken = 0u;
    while (taken < count && (REG_READ(USART3->SR) & USART_SR_TXE) != 0u) {
        REG_WRITE(USART3->DR, octets[taken]);
        taken++;
    }
    return taken;
}
