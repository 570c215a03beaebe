/// Sampling times of a sequence of conversions, one code for all of its channels.
#ifndef LODESTAR_PORT_STM32_SAMPLING_H
#define LODESTAR_PORT_STM32_SAMPLING_H

#include <stdint.h>

typedef struct {
    uint32_t low;  ///< register of channels 0 .. 9
    uint32_t high; ///< of channels 10 .. 19
} stm32_sampling_t;

static inline stm32_sampling_t stm32_sampling(const uint32_t *channels, uint32_t count,
                                              uint32_t code) {
    stm32_sampling_t times = {0u, 0u};
    for (uint32_t n = 0u; n < count; n++) {
        if (channels[n] < 10u) {
            times.low |= code << (3u * channels[n]);
        } else {
            times.high |= code << (3u * (channels[n] - 10u));
        }
    }
    return times;
}

#endif
