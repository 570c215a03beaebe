#include "serial.h"

#include "chip.h"

#define BAUD 115200u

void stm32_serial_init(uint32_t f_clock_Hz) {
    static const stm32_pin_t tx = VARIANT_TX_PIN;
    REG_SET(STM32_APB1_CLOCKS, STM32_SERIAL_CLOCK);
    REG_WRITE(STM32_SERIAL->BRR, (f_clock_Hz + BAUD / 2u) / BAUD);
    REG_WRITE(STM32_SERIAL->CR1, STM32_SERIAL_FIFO | USART_CR1_TE | USART_CR1_UE);
    gpio_alternate(tx);
}

uint32_t stm32_serial_send(const uint16_t *octets, uint32_t count) {
    uint32_t taken = 0u;
    while (taken < count &&
           (REG_READ(STM32_SERIAL->STM32_SERIAL_STATUS) & STM32_SERIAL_ROOM) != 0u) {
        REG_WRITE(STM32_SERIAL->STM32_SERIAL_DATA, octets[taken]);
        taken++;
    }
    return taken;
}
