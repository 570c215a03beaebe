#include "pwm.h"

#include "figures.h"

// BDTR.DTG: four ranges, each with a wider step than the one before it.
#define DTG_RANGES 4u
static const struct {
    uint32_t code;  // leading bits
    uint32_t step;  // timer periods
    uint32_t base;  // steps at the range's begin
    uint32_t count; // steps that its bits hold
} dtg_ranges[DTG_RANGES] = {
    {0x00u, 1u, 0u, 128u}, {0x80u, 2u, 64u, 64u}, {0xC0u, 8u, 32u, 32u}, {0xE0u, 16u, 32u, 32u}};

bool stm32_dead_time(uint32_t f_timer_Hz, uint32_t dead_time_ns, uint32_t *dtg) {
    // In thousandths of a timer period, so that 32 bits hold up to 25 us at 170 MHz.
    const uint32_t f_kHz = f_timer_Hz / 1000u;
    if (f_kHz == 0u || dead_time_ns > UINT32_MAX / f_kHz - 1000u) {
        return false;
    }
    const uint32_t ticks = (dead_time_ns * f_kHz + 999999u) / 1000000u;
    for (uint32_t n = 0u; n < DTG_RANGES; n++) {
        const uint32_t step = dtg_ranges[n].step;
        const uint32_t steps = (ticks + step - 1u) / step;
        if (steps < dtg_ranges[n].base + dtg_ranges[n].count) {
            const uint32_t beyond = steps > dtg_ranges[n].base ? steps - dtg_ranges[n].base : 0u;
            *dtg = dtg_ranges[n].code | beyond;
            return true;
        }
    }
    return false;
}

uint32_t stm32_pwm_written[3];

#define HIGH_SIDES (TIM_CCER_CC1E | TIM_CCER_CC2E | TIM_CCER_CC3E)
#define LOW_SIDES (TIM_CCER_CC1NE | TIM_CCER_CC2NE | TIM_CCER_CC3NE)

void stm32_pwm_reset(void) {
    REG_SET(RCC->APB2RSTR, RCC_APB2RSTR_TIM1RST);
    REG_CLEAR(RCC->APB2RSTR, RCC_APB2RSTR_TIM1RST);
}

bool stm32_pwm_init(const stm32_pwm_t *config) {
    const uint32_t steps = port_pwm_steps(config->f_timer_Hz, config->f_pwm_Hz);
    uint32_t dtg = 0u;
    if (steps == 0u || !stm32_dead_time(config->f_timer_Hz, config->dead_time_ns, &dtg)) {
        return false;
    }
    REG_WRITE(TIM1->CR1, TIM_CR1_ARPE | TIM_CR1_CMS_0);
    REG_WRITE(TIM1->CR2, TIM_CR2_MMS_1); // TRGO = update; idle levels low
    REG_WRITE(TIM1->PSC, 0u);
    REG_WRITE(TIM1->ARR, steps);
    // 1, before the counter starts: update at the lower turning point only.
    REG_WRITE(TIM1->RCR, config->double_update ? 0u : 1u);
    // PWM mode 2 (7), preloaded.
    REG_WRITE(TIM1->CCMR1, TIM_CCMR1_OC1M_0 | TIM_CCMR1_OC1M_1 | TIM_CCMR1_OC1M_2 |
                               TIM_CCMR1_OC1PE | TIM_CCMR1_OC2M_0 | TIM_CCMR1_OC2M_1 |
                               TIM_CCMR1_OC2M_2 | TIM_CCMR1_OC2PE);
    REG_WRITE(TIM1->CCMR2,
              TIM_CCMR2_OC3M_0 | TIM_CCMR2_OC3M_1 | TIM_CCMR2_OC3M_2 | TIM_CCMR2_OC3PE);
    stm32_pwm_write((lode_abc_t){0.5f, 0.5f, 0.5f}); // no voltage between the phases
    REG_WRITE(TIM1->CCER, HIGH_SIDES | (config->low_sides ? LOW_SIDES : 0u));
    // Off means driven inactive (OSSI, OSSR), not floating. Lock level 2: dead time, break inputs, polarities
    // and idle levels cannot change until the next reset. No automatic restart. All in one write, because the
    // first write after the reset freezes LOCK (RM0440 and RM0090, TIMx_BDTR).
    REG_WRITE(TIM1->BDTR,
              dtg | TIM_BDTR_OSSI | TIM_BDTR_OSSR | TIM_BDTR_LOCK_1 | config->break_bits);
    REG_WRITE(TIM1->EGR, TIM_EGR_UG); // loads all preloaded registers; nothing uses the trigger yet
    REG_WRITE(TIM1->SR, 0u);
    return true;
}

// If the output of the high side is disabled, that of the low side follows the compare signal itself, not its
// complement
// (RM0440, RM0090: output control bits for complementary channels): so mode 1, which is high where mode 2
// is low. Lock level 2 leaves both registers free.
void stm32_pwm_low_sides_alone(bool alone) {
    const uint32_t mode_2 =
        TIM_CCMR1_OC1M_0 | TIM_CCMR1_OC2M_0; // the bit in which the two modes differ
    stm32_pwm_off();
    REG_CHANGE(TIM1->CCER, HIGH_SIDES, alone ? 0u : HIGH_SIDES);
    REG_CHANGE(TIM1->CCMR1, mode_2, alone ? 0u : mode_2);
    REG_CHANGE(TIM1->CCMR2, TIM_CCMR2_OC3M_0, alone ? 0u : TIM_CCMR2_OC3M_0);
}

void stm32_pwm_start(void) {
    REG_SET(TIM1->CR1, TIM_CR1_CEN);
}

bool stm32_pwm_clear_trip(void) {
    REG_WRITE(TIM1->SR, ~(uint32_t)STM32_BREAK_FLAGS);
    return !stm32_pwm_tripped(); // an active input has set it again
}
