/// The board's USART, transmitter only, 115200 baud.
#ifndef LODESTAR_PORT_STM32_SERIAL_H
#define LODESTAR_PORT_STM32_SERIAL_H

#include <stdint.h>

/// `f_clock_Hz`: clock of the USART.
void stm32_serial_init(uint32_t f_clock_Hz);
/// Puts as many octets as there is room for, without waiting; returns their number.
uint32_t stm32_serial_send(const uint16_t *octets, uint32_t count);

#endif
