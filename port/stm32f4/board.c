#include "board.h"

#include "chip.h"
#include "pwm.h"
#include "supervise.h"

void STM32_PERIOD_HANDLER(void);

void board_describe(lode_drive_config_t *config) {
    const float f_pwm = (float)VARIANT_F_PWM_Hz;
    const float duty_max = stm32_duty_max(f_pwm, VARIANT_SETTLE_ns, CHIP_SAMPLE_ns);
    config->f_pwm_Hz = f_pwm;
    config->inverter = (lode_inverter_config_t){
        .v_bus_V = VARIANT_V_BUS_V,
        .i_max_A = VARIANT_I_MAX_A,
        .dead_time_s = (float)VARIANT_DEAD_TIME_ns * 1.0e-9f,
        .v_drop_V = VARIANT_V_DROP_V,
        .r_on_Ohm = VARIANT_R_ON_Ohm,
        .pwm_ticks = (float)stm32_pwm_steps(CHIP_F_CPU_Hz, VARIANT_F_PWM_Hz),
    };
    config->sense = (lode_sense_config_t){
        .shunts = LODE_SHUNTS_THREE,
        .i_gain_A_count = VARIANT_I_GAIN_A_count,
        .i_offset_count = VARIANT_I_OFFSET_count,
        .i_offset_tol_count = VARIANT_I_OFFSET_TOL_count,
        .v_bus_gain_V_count = VARIANT_V_BUS_GAIN_V_count,
        .temperature_gain_degC_count = VARIANT_T_GAIN_degC_count,
        .temperature_offset_degC = VARIANT_T_OFFSET_degC,
        .duty_max = duty_max,
    };
    config->current.voltage_use = stm32_voltage_use(duty_max);
    config->guard.stamp_per_period = (float)CHIP_F_STAMP_Hz / f_pwm;
}

LODE_RAMFUNC void board_gates_off(void) {
    stm32_pwm_off();
}

static void pins_init(void) {
    static const stm32_pin_t analog[] = {VARIANT_ANALOG_PINS};
    static const stm32_pin_t fault = VARIANT_BREAK_PIN;
    for (uint32_t n = 0u; n < sizeof analog / sizeof analog[0]; n++) {
        gpio_analog(analog[n]);
    }
    gpio_pull_up(fault); // open drain, active low
    gpio_alternate(fault);
}

static void pwm_pins_init(void) {
    static const stm32_pin_t pwm[] = {VARIANT_PWM_PINS};
    for (uint32_t n = 0u; n < sizeof pwm / sizeof pwm[0]; n++) {
        gpio_alternate(pwm[n]);
    }
}

bool board_reset_by_watchdog(void) {
    return stm32_reset_by_watchdog();
}

bool board_init(void) {
    REG_SET(RCC->AHB1ENR, RCC_AHB1ENR_GPIOAEN | RCC_AHB1ENR_GPIOBEN | RCC_AHB1ENR_GPIOCEN);
    REG_SET(RCC->APB2ENR, RCC_APB2ENR_TIM1EN);
    stm32_pwm_reset();
    const bool clocked = chip_clock_init();
    chip_serial_init(clocked ? CHIP_F_SERIAL_Hz : CHIP_F_RC_Hz); // a failure is reported over it
    if (!clocked) {
        return false;
    }
    REG_SET(RCC->APB1ENR, RCC_APB1ENR_TIM2EN);
    stm32_stamp_start();
    pins_init();
    // BKP = 0: the fault input is active low. This timer has no filter on it.
    if (!stm32_pwm_init(&(stm32_pwm_t){.f_timer_Hz = CHIP_F_CPU_Hz,
                                       .f_pwm_Hz = VARIANT_F_PWM_Hz,
                                       .dead_time_ns = VARIANT_DEAD_TIME_ns,
                                       .low_sides = VARIANT_LOW_SIDES,
                                       .break_bits = TIM_BDTR_BKE})) {
        return false;
    }
    chip_converters_init();
    pwm_pins_init(); // only now: the timer holds its outputs inactive
    // A halted core must leave neither a switched bridge nor a biting watchdog; the stamp shows the gap.
    REG_SET(DBGMCU->APB2FZ, DBGMCU_APB2_FZ_DBG_TIM1_STOP);
    REG_SET(DBGMCU->APB1FZ, DBGMCU_APB1_FZ_DBG_IWDG_STOP);
    REG_CLEAR(DBGMCU->APB1FZ, DBGMCU_APB1_FZ_DBG_TIM2_STOP);
    return stm32_watchdog_init() && stm32_pwm_clear_trip();
}

void board_start(void) {
    stm32_watchdog_start();
    REG_WRITE(ADC1->SR, ~(uint32_t)(ADC_SR_JEOC | ADC_SR_JSTRT));
    REG_SET(ADC1->CR1, ADC_CR1_JEOCIE);
    NVIC_SetPriority(ADC_IRQn, 0u); // above all else
    NVIC_EnableIRQ(ADC_IRQn);
    stm32_pwm_start();
}

LODE_RAMFUNC void STM32_PERIOD_HANDLER(void) {
    REG_WRITE(ADC1->SR, ~(uint32_t)(ADC_SR_JEOC | ADC_SR_JSTRT));
    app_period();
}

LODE_RAMFUNC void board_read(lode_counts_t *counts) {
    *counts = (lode_counts_t){
        .i = {(uint16_t)REG_READ(VARIANT_COUNT_A), (uint16_t)REG_READ(VARIANT_COUNT_B),
              (uint16_t)REG_READ(VARIANT_COUNT_C)},
        .v_bus = (uint16_t)REG_READ(VARIANT_COUNT_BUS),
        .temperature = (uint16_t)REG_READ(VARIANT_COUNT_T),
        .trip = stm32_pwm_tripped() || stm32_pwm_counts_down(),
        .stamp = stm32_stamp(),
    };
}

LODE_RAMFUNC void board_write(const lode_drive_out_t *out) {
    if (!out->gates) {
        board_gates_off();
    }
    stm32_pwm_write(out->duty);
    if (out->gates) {
        (void)stm32_pwm_on();
    }
}

bool board_clear_trip(void) {
    return stm32_pwm_clear_trip();
}

void board_feed_watchdog(void) {
    stm32_watchdog_feed();
}

LODE_RAMFUNC uint32_t board_cycles(void) {
    return stm32_stamp();
}

uint32_t board_send(const uint16_t *octets, uint32_t count) {
    return chip_serial_send(octets, count);
}
