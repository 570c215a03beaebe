#include "board.h"

#include "chip.h"
#include "sequential.h"

#define BAUD 115200u
#define FRACTIONS 64u // fractions of the divisor
// The ring oscillator that the reference clock runs on: 11 MHz nominal, 4.6 .. 24 MHz (data sheet, ring
// oscillator). After a clock failure the serial port is only as accurate.
#define F_RING_Hz 11000000u
#define TICK_CYCLES 11u
#define WATCHDOG_us 20000u

void adc_fifo_handler(void);

static port_sequential_t sequential;
static bool complete; // the samples of this period
static uint16_t sample[4];

bool board_reset_by_watchdog(void) {
    return (reg_read(WATCHDOG_REASON) & WATCHDOG_REASON_TIMER) != 0u;
}

static void serial_init(uint32_t f_clock_Hz) {
    const uint32_t divisor = (f_clock_Hz * 4u + BAUD / 2u) / BAUD; // 1/64 of f/(16 baud)
    reg_write(UART0_IBRD, divisor / FRACTIONS);
    reg_write(UART0_FBRD, divisor % FRACTIONS);
    reg_write(UART0_LCR, UART_LCR_8N1_FIFO); // loads the divisor
    reg_write(UART0_CR, UART_CR_TX);
    reg_write(PIN_CTRL(VARIANT_TX_GPIO), PIN_UART);
    reg_write(PAD(VARIANT_TX_GPIO), PAD_OUTPUT);
}

// Cycles of the system clock; keeps running while a debugger halts the core.
static void stamp_start(void) {
    reg_write(TIMER0_DBGPAUSE, 0u);
    reg_write(TIMER0_SOURCE, TIMER_SOURCE_SYSTEM);
}

// Delays of currents sampled one after the other, evenly around t_k.
static void sequential_start(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    const lode_motor_t motor = app_motor();
    port_sequential_config_t wanted = {.f_pwm_Hz = config.f_pwm_Hz,
                                       .i_gain_A_count = config.sense.i_gain_A_count,
                                       .duty_max = config.sense.duty_max,
                                       .L_H = 0.5f * (motor.Ld_H + motor.Lq_H)};
    for (uint32_t n = 0u; n < CHIP_CURRENTS; n++) {
        wanted.delay_s[n] = ((float)n * CHIP_CONVERSION_ns - CHIP_SPREAD_ns) * 1.0e-9f;
    }
    port_sequential_init(&sequential, &wanted);
}

bool board_init(float i_trip_A) {
    (void)i_trip_A; // the driver has its own threshold
    chip_gates_off();
    if (!chip_release(RESET_PWM | RESET_ADC | RESET_DMA | RESET_TIMER0 | RESET_UART0,
                      RESET_IO_BANK0 | RESET_PADS_BANK0)) {
        return false;
    }
    chip_driver_init();
    const bool clocked = chip_clock_init();
    serial_init(clocked ? CHIP_F_SYS_Hz : F_RING_Hz); // needed to report a failure
    if (!clocked) {
        return false;
    }
    stamp_start();
    sequential_start();
    if (!chip_pwm_init() || !chip_adc_init()) {
        return false;
    }
    chip_driver_reset();
    return !chip_tripped();
}

// Its reset removes the functions of the pads, and the pull-downs switch off. It keeps running while a debugger
// halts the core: after the deadline a halt ends in a reset.
static void watchdog_start(void) {
    reg_write(TICKS_WATCHDOG_CYCLES, TICK_CYCLES);
    reg_write(TICKS_WATCHDOG_CTRL, TICKS_ENABLE);
    reg_write(PSM_WDSEL, PSM_WDSEL_ALL_BUT_OSCILLATORS);
    board_feed_watchdog();
    reg_write(WATCHDOG_CTRL, WATCHDOG_CTRL_ENABLE);
}

void board_start(void) {
    watchdog_start();
    chip_adc_arm();
    reg_write(NVIC_PRIORITY(IRQ_ADC_FIFO), 0u); // above all else
    reg_write(NVIC_ENABLE_1, 1u << (IRQ_ADC_FIFO - 32u));
    chip_pwm_start();
}

LODE_RAMFUNC void adc_fifo_handler(void) {
    complete = chip_adc_take(sample);
    chip_deadline_move();
    app_period();
    chip_adc_rest();
}

LODE_RAMFUNC void board_read(lode_counts_t *counts) {
    const uint16_t v_bus = sample[CHIP_CURRENTS];
    *counts = (lode_counts_t){
        .i = {sample[0], sample[1], CHIP_IS_TWO ? 0u : sample[2]},
        .v_bus = v_bus,
        .trip = !complete || chip_tripped() || !chip_pwm_holds(),
        .stamp = board_cycles(),
    };
    port_sequential_read(&sequential, (float)v_bus * VARIANT_V_BUS_GAIN_V_count, counts->i);
}

LODE_RAMFUNC void board_gates_off(void) {
    chip_gates_off();
}

LODE_RAMFUNC void board_write(const lode_drive_out_t *out) {
    const bool on = out->gates == LODE_GATES_ON; // the low sides alone are not possible, so off
    if (!on) {
        chip_gates_off();
    }
    chip_pwm_write(out->duty);
    port_sequential_write(&sequential, out->duty, on);
    if (on) {
        chip_gates_on();
    }
}

bool board_clear_trip(void) {
    if (chip_tripped()) {
        chip_driver_reset();
    }
    return !chip_tripped(); // an active source has latched it again
}

bool board_test_trip(void) { // the trip is in the driver and cannot be tested
    board_gates_off();
    return true;
}

void board_feed_watchdog(void) {
    reg_write(WATCHDOG_LOAD, WATCHDOG_us);
}

LODE_RAMFUNC uint32_t board_cycles(void) {
    return reg_read(TIMER0_RAWL);
}

uint32_t board_send(const uint16_t *octets, uint32_t count) {
    uint32_t taken = 0u;
    while (taken < count && (reg_read(UART0_FR) & UART_FR_TX_FULL) == 0u) {
        reg_write(UART0_DR, octets[taken]);
        taken++;
    }
    return taken;
}
