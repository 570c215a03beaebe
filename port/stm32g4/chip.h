/// The parts of the STM32G4 that board.c puts together.
#ifndef LODESTAR_PORT_STM32G4_CHIP_H
#define LODESTAR_PORT_STM32G4_CHIP_H

#include "gpio.h"
#include "reg.h"

#ifndef STM32_BOARD_H
#define STM32_BOARD_H "boards/b_g431b_esc1.h"
#endif
#include STM32_BOARD_H

#define CHIP_F_CPU_Hz 170000000u
#define CHIP_F_STAMP_Hz CHIP_F_CPU_Hz  ///< TIM2
#define CHIP_F_SERIAL_Hz CHIP_F_CPU_Hz ///< USART2
#define CHIP_F_RC_Hz 16000000u         ///< everything, where the clocks have not come up

/// Core, buses and timers at 170 MHz. False: an oscillator or the PLL does not come.
bool chip_clock_init(void);

/// Amplifiers, comparators and their threshold, where the variant uses the chip's own. Before the PWM's
/// break input is armed.
void chip_protection_init(void);

/// ADC1 and ADC2, injected and simultaneous, three ranks each, on TIM1's TRGO. False: no answer.
bool chip_converters_init(void);

/// From now on a trigger starts them.
void chip_converters_arm(void);

/// USART2's transmitter, 115200 baud from its clock.
void chip_serial_init(uint32_t f_clock_Hz);
uint32_t chip_serial_send(const uint16_t *octets, uint32_t count);

/// ADC clock 42.5 MHz; 6.5 cycles of sampling, 12.5 of conversion. Until the end of the sampling of rank
/// 2, with three cycles from the trigger to the first sampling.
#define CHIP_SAMPLE_ns ((3.0f + 6.5f + 12.5f + 6.5f) / 42.5f * 1000.0f)

#endif
