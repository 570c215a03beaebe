/// Pins. The clock of their port must be on.
#ifndef LODESTAR_PORT_STM32_GPIO_H
#define LODESTAR_PORT_STM32_GPIO_H

#include "reg.h"

typedef struct {
    GPIO_TypeDef *port;
    uint32_t pin;       ///< 0 .. 15
    uint32_t alternate; ///< 0 .. 15; unused for analog pins and outputs
} stm32_pin_t;

#define GPIO_MODE_OUTPUT 1u
#define GPIO_MODE_ALTERNATE 2u
#define GPIO_MODE_ANALOG 3u
#define GPIO_PULL_UP 1u

static inline void gpio_mode(stm32_pin_t pin, uint32_t mode) {
    REG_CHANGE(pin.port->MODER, 3u << (2u * pin.pin), mode << (2u * pin.pin));
}

static inline void gpio_analog(stm32_pin_t pin) {
    gpio_mode(pin, GPIO_MODE_ANALOG);
}

/// Sets the function before the mode, so that no other function reaches the pin in between.
static inline void gpio_alternate(stm32_pin_t pin) {
    const uint32_t shift = 4u * (pin.pin % 8u);
    REG_CHANGE(pin.port->AFR[pin.pin / 8u], 15u << shift, pin.alternate << shift);
    gpio_mode(pin, GPIO_MODE_ALTERNATE);
}

static inline void gpio_pull_up(stm32_pin_t pin) {
    REG_CHANGE(pin.port->PUPDR, 3u << (2u * pin.pin), GPIO_PULL_UP << (2u * pin.pin));
}

static inline void gpio_low(stm32_pin_t pin) {
    REG_WRITE(pin.port->BSRR, 1u << (pin.pin + 16u));
}

static inline void gpio_high(stm32_pin_t pin) {
    REG_WRITE(pin.port->BSRR, 1u << pin.pin);
}

/// An output that starts low.
static inline void gpio_output_low(stm32_pin_t pin) {
    gpio_low(pin);
    gpio_mode(pin, GPIO_MODE_OUTPUT);
}

#endif
