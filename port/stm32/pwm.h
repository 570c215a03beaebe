/// TIM1 as a three-phase PWM, the same in STM32F4, G4 and H7.
///
/// It counts up and down. In PWM mode 2 the high sides are on around the upper turning point, so all low
/// sides are on around the lower one: there the shunts carry the phase currents. The update event comes
/// there once per period (repetition counter 1), or with double update at both turning points (0). It loads the
/// compare values and triggers the ADCs: that instant is t_k.
#ifndef LODESTAR_PORT_STM32_PWM_H
#define LODESTAR_PORT_STM32_PWM_H

#include "lodestar/lodestar.h"
#include "reg.h"

typedef struct {
    uint32_t f_timer_Hz;
    uint32_t f_pwm_Hz;
    uint32_t dead_time_ns; ///< rounded up to the timer's next step
    bool low_sides;        ///< complementary outputs drive the low sides
    bool double_update;    ///< at both turning points
    uint32_t break_bits;   ///< of BDTR: enable, polarity and filter of the break inputs
} stm32_pwm_t;

/// BDTR.DTG for at least this dead time; false if it is too long for the timer.
bool stm32_dead_time(uint32_t f_timer_Hz, uint32_t dead_time_ns, uint32_t *dtg);

/// Sets the whole timer to its state after a chip reset: outputs off, and BDTR not yet written. Its clock must
/// be on.
void stm32_pwm_reset(void);

/// Configures everything but the counter's start and the outputs. Call directly after stm32_pwm_reset(),
/// because only the first write to BDTR counts. The pins must not yet be outputs of the timer. False: period or
/// dead time do not fit.
bool stm32_pwm_init(const stm32_pwm_t *config);

/// The counter starts at the lower turning point.
void stm32_pwm_start(void);

/// What stm32_pwm_write() wrote last.
extern uint32_t stm32_pwm_written[3];

/// Writes the preload of the compare registers; duties in [0, 1].
static inline void stm32_pwm_write(lode_abc_t duty) {
    const float steps = (float)REG_READ(TIM1->ARR);
    stm32_pwm_written[0] = (uint32_t)(int32_t)((1.0f - duty.a) * steps + 0.5f);
    stm32_pwm_written[1] = (uint32_t)(int32_t)((1.0f - duty.b) * steps + 0.5f);
    stm32_pwm_written[2] = (uint32_t)(int32_t)((1.0f - duty.c) * steps + 0.5f);
    REG_WRITE(TIM1->CCR1, stm32_pwm_written[0]);
    REG_WRITE(TIM1->CCR2, stm32_pwm_written[1]);
    REG_WRITE(TIM1->CCR3, stm32_pwm_written[2]);
}

/// True if the compare registers hold these values; read, they show their preload.
static inline bool stm32_pwm_holds(const uint32_t compare[3]) {
    return REG_READ(TIM1->CCR1) == compare[0] && REG_READ(TIM1->CCR2) == compare[1] &&
           REG_READ(TIM1->CCR3) == compare[2];
}

/// True if a break is latched.
static inline bool stm32_pwm_tripped(void) {
    return (REG_READ(TIM1->SR) & STM32_BREAK_FLAGS) != 0u;
}

/// True if the counter runs down, which it does from the upper turning point on.
static inline bool stm32_pwm_counts_down(void) {
    return (REG_READ(TIM1->CR1) & TIM_CR1_DIR) != 0u;
}

/// Sets all outputs to their inactive level at once.
static inline void stm32_pwm_off(void) {
    REG_CLEAR(TIM1->BDTR, TIM_BDTR_MOE);
}

/// Switches the outputs on, unless a break is latched. Writes nothing if they are already on: a break in
/// between must not be undone.
static inline bool stm32_pwm_on(void) {
    const uint32_t bdtr = REG_READ(TIM1->BDTR);
    if ((bdtr & TIM_BDTR_MOE) != 0u) {
        return true;
    }
    if (stm32_pwm_tripped()) {
        return false;
    }
    REG_WRITE(TIM1->BDTR, bdtr | TIM_BDTR_MOE);
    return true;
}

/// True: from now on only the low sides' outputs switch, in the same share of the period; false: all six again.
/// The change switches them off first. For bridges with six inputs. Without the high sides there is no dead
/// time, and none is needed.
void stm32_pwm_low_sides_alone(bool alone);

/// False: the break input is still active.
bool stm32_pwm_clear_trip(void);

#endif
