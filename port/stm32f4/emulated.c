/// The board for qemu's netduinoplus2, which has this chip's core, TIM2, TIM5 and USART3 but no working
/// TIM1 and no injected conversions: TIM2 paces the periods, the counts are those of a motor at rest.
/// Start-up code, linker script, application and serial port are the real ones.
#include "board.h"

#include "chip.h"

#if VARIANT_DOUBLE_UPDATE
#error "No TIM1 here, so no turning points: no VARIANT_DOUBLE_UPDATE"
#endif

// The model runs every timer at 1 GHz, whatever the clock tree says.
#define F_TIMER_Hz 1.0e9f
#define PRESCALER 1000u // 1 MHz
#define PERIOD_us 200u
#define MID_COUNT 2048u
#define BUS_COUNT 1608u // 24 V

void STM32_PERIOD_HANDLER(void);

static volatile bool gates;

void board_describe(lode_drive_config_t *config) {
    config->f_pwm_Hz = F_TIMER_Hz / ((float)PRESCALER * (float)PERIOD_us);
    config->inverter =
        (lode_inverter_config_t){.v_bus_V = VARIANT_V_BUS_V, .i_max_A = VARIANT_I_MAX_A};
    config->sense = (lode_sense_config_t){.i_gain_A_count = VARIANT_I_GAIN_A_count,
                                          .i_offset_count = VARIANT_I_OFFSET_count,
                                          .v_bus_gain_V_count = VARIANT_V_BUS_GAIN_V_count};
    config->guard.stamp_per_period = (float)PERIOD_us;
}

bool board_reset_by_watchdog(void) {
    return false;
}

bool board_init(float i_trip_A) {
    (void)i_trip_A;
    stm32_serial_init(CHIP_F_SERIAL_Hz);
    REG_WRITE(TIM5->PSC, PRESCALER - 1u);
    REG_WRITE(TIM5->ARR, UINT32_MAX);
    REG_WRITE(TIM5->EGR, TIM_EGR_UG);
    REG_WRITE(TIM5->CR1, TIM_CR1_CEN);
    REG_WRITE(TIM2->PSC, PRESCALER - 1u);
    REG_WRITE(TIM2->ARR, PERIOD_us);
    // The model adds the time of arming to every period, unless the timer counts from its own zero. TIM3, which
    // is never written, shows the time since then in ns.
    REG_WRITE(TIM2->CNT, REG_READ(TIM3->CNT) / PRESCALER);
    REG_WRITE(TIM2->SR, 0u);
    return true;
}

void board_start(void) {
    REG_WRITE(TIM2->DIER, TIM_DIER_UIE);
    NVIC_SetPriority(TIM2_IRQn, 0u);
    NVIC_EnableIRQ(TIM2_IRQn);
    REG_WRITE(TIM2->CR1, TIM_CR1_CEN);
}

void STM32_PERIOD_HANDLER(void) {
    REG_WRITE(TIM2->SR, 0u);
    app_period();
}

void board_read(lode_counts_t *counts) {
    *counts = (lode_counts_t){
        .i = {MID_COUNT, MID_COUNT, MID_COUNT}, .v_bus = BUS_COUNT, .stamp = board_cycles()};
}

void board_write(const lode_drive_out_t *out) {
    gates = out->gates;
}

void board_gates_off(void) {
    gates = false;
}

bool board_clear_trip(void) {
    return true;
}

bool board_test_trip(void) {
    return true;
}

void board_feed_watchdog(void) {}

uint32_t board_cycles(void) {
    return REG_READ(TIM5->CNT);
}

uint32_t board_send(const uint16_t *octets, uint32_t count) {
    return stm32_serial_send(octets, count);
}
