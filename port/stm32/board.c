/// The functions of board.h for any STM32 with TIM1 as its PWM. chip.h has the parts of the chip,
/// stm32_device.h its register names, and the board's header its values and pins.
#include "board.h"

#include "chip.h"

#include "calls.h"
#include "pwm.h"
#include "supervise.h"
#include "temperature.h"

#if defined(VARIANT_PRECHARGE_s) && !VARIANT_LOW_SIDES
#error "A driver that makes its low sides itself: no low sides alone, so no VARIANT_PRECHARGE_s"
#endif

void STM32_PERIOD_HANDLER(void);

#ifdef VARIANT_ENABLE_PINS

// Switching off has the reverse order: first the driver's enables, which let the phases float, then its inputs.
static const stm32_pin_t enables[3] = {VARIANT_ENABLE_PINS};

static void enables_init(void) {
    for (uint32_t n = 0u; n < 3u; n++) {
        gpio_output_low(enables[n]);
    }
}

static void enables_set(bool on) {
    for (uint32_t n = 0u; n < 3u; n++) {
        if (on) {
            gpio_high(enables[n]);
        } else {
            gpio_low(enables[n]);
        }
    }
}

#else

static void enables_init(void) {}

static void enables_set(bool on) {
    (void)on;
}

#endif

#ifdef VARIANT_LINK

#include "link.h"

static inline bool currents_read(uint16_t count[3]) {
    return chip_link_read(count);
}

static inline bool duties_hold(void) {
    return true; // chip_link_read() tells it
}

static inline void duties_write(const lode_drive_out_t *out) {
    chip_link_write(out);
}

#else

static inline bool currents_read(uint16_t count[3]) {
    count[0] = (uint16_t)REG_READ(VARIANT_COUNT_A);
    count[1] = (uint16_t)REG_READ(VARIANT_COUNT_B);
    count[2] = (uint16_t)REG_READ(VARIANT_COUNT_C);
    return true;
}

static inline bool duties_hold(void) {
    return stm32_pwm_holds(stm32_pwm_written);
}

static inline void duties_write(const lode_drive_out_t *out) {
    stm32_pwm_write(out->duty);
}

#endif

LODE_RAMFUNC void board_gates_off(void) {
    enables_set(false);
    stm32_pwm_off();
}

static void analog_pins_init(void) {
    static const stm32_pin_t analog[] = {VARIANT_ANALOG_PINS};
    for (uint32_t n = 0u; n < sizeof analog / sizeof analog[0]; n++) {
        gpio_analog(analog[n]);
    }
}

static void pwm_pins_init(void) {
    static const stm32_pin_t pwm[] = {VARIANT_PWM_PINS};
    for (uint32_t n = 0u; n < sizeof pwm / sizeof pwm[0]; n++) {
        gpio_alternate(pwm[n]);
    }
}

static bool pwm_init(void) {
    const bool fits = stm32_pwm_init(&(stm32_pwm_t){
        .f_timer_Hz = CHIP_F_PWM_Hz,
        .f_pwm_Hz = VARIANT_F_PWM_Hz,
        .dead_time_ns = VARIANT_DEAD_TIME_ns,
        .low_sides = VARIANT_LOW_SIDES,
        .double_update = VARIANT_DOUBLE_UPDATE,
        .break_bits = CHIP_BREAK_BITS,
    });
#ifdef VARIANT_LINK
    return fits && chip_link_init();
#else
    return fits;
#endif
}

// While the core is halted the bridge must not switch and the watchdog must not reset; the stamp shows the gap.
static void halt_init(void) {
    REG_SET(STM32_DBG_APB2, STM32_DBG_TIM1_STOP);
    REG_SET(STM32_DBG_WATCHDOG, STM32_DBG_IWDG_STOP);
    REG_CLEAR(STM32_DBG_APB1, STM32_DBG_TIM2_STOP);
}

static bool low_sides_alone; // present setting of the timer
static port_ran_t ran;       // direction of its counter in the previous call

bool board_reset_by_watchdog(void) {
    return stm32_reset_by_watchdog();
}

bool board_init(float i_trip_A) {
    REG_SET(STM32_GPIO_CLOCKS, STM32_GPIO_ABC);
    enables_init();
    REG_SET(RCC->APB2ENR, RCC_APB2ENR_TIM1EN);
    stm32_pwm_reset();
    low_sides_alone = false;
    ran = PORT_RAN_UNKNOWN;
    const bool clocked = chip_clock_init();
    stm32_serial_init(clocked ? CHIP_F_SERIAL_Hz : CHIP_F_RC_Hz); // needed to report a failure
    if (!clocked) {
        return false;
    }
    stm32_stamp_start();
    port_temperature_init();
    analog_pins_init();
    chip_protection_init(i_trip_A);
    if (!pwm_init() || !chip_adc_init()) {
        return false;
    }
    chip_deadline_init();
    pwm_pins_init(); // only now, when the timer holds its outputs inactive
    halt_init();
    return stm32_watchdog_init() && stm32_pwm_clear_trip();
}

void board_start(void) {
    stm32_watchdog_start();
    chip_adc_arm();
    NVIC_SetPriority(STM32_PERIOD_IRQ, 0u); // above all else
    NVIC_EnableIRQ(STM32_PERIOD_IRQ);
    stm32_pwm_start();
}

LODE_RAMFUNC void STM32_PERIOD_HANDLER(void) {
    chip_adc_acknowledge();
    chip_deadline_move();
    app_period();
}

LODE_RAMFUNC void board_read(lode_counts_t *counts) {
    *counts = (lode_counts_t){
        .v_bus = (uint16_t)REG_READ(VARIANT_COUNT_BUS),
        .temperature = port_temperature(REG_READ(VARIANT_COUNT_T)),
        .trip = port_is_wrong_half(&ran, stm32_pwm_counts_down()) || stm32_pwm_tripped() ||
                !duties_hold(),
        .stamp = stm32_stamp(),
    };
    counts->trip = !currents_read(counts->i) || counts->trip;
}

LODE_RAMFUNC void board_write(const lode_drive_out_t *out) {
    const bool low = out->gates == LODE_GATES_LOW;
    const bool on = out->gates == LODE_GATES_ON || (low && VARIANT_LOW_SIDES);
    if (!on) {
        board_gates_off();
    }
    if (low != low_sides_alone && VARIANT_LOW_SIDES) {
        stm32_pwm_low_sides_alone(low);
        low_sides_alone = low;
    }
    duties_write(out);
    if (on && stm32_pwm_on()) {
        enables_set(true);
    }
}

bool board_clear_trip(void) {
    return stm32_pwm_clear_trip();
}

bool board_test_trip(void) {
    board_gates_off();
    return chip_protection_test();
}

void board_feed_watchdog(void) {
    stm32_watchdog_feed();
}

LODE_RAMFUNC uint32_t board_cycles(void) {
    return stm32_stamp();
}

uint32_t board_send(const uint16_t *octets, uint32_t count) {
    return stm32_serial_send(octets, count);
}
