#include "board.h"

#include "chip.h"

#define BAUD 115200u
#define FIFO_DEPTH 16u

typedef struct {
    uint32_t function; // function code of TI's pin map
    uint32_t gpio;
} pin_t;

__interrupt void period_handler(void);
__interrupt void stop_handler(void);

static void driver_init(void) {
    chip_driver_set(false);
    GPIO_setPadConfig(VARIANT_ENABLE_GPIO, GPIO_PIN_TYPE_STD);
    GPIO_setDirectionMode(VARIANT_ENABLE_GPIO, GPIO_DIR_MODE_OUT);
    GPIO_setPinConfig(VARIANT_ENABLE_PIN);
}

void chip_driver_set(bool on) {
    GPIO_writePin(VARIANT_ENABLE_GPIO, on ? 1u : 0u);
}

static void pwm_pins_init(void) {
    static const pin_t pins[] = {VARIANT_PWM_PINS};
    for (uint32_t n = 0u; n < sizeof pins / sizeof pins[0]; n++) {
        GPIO_setPadConfig(pins[n].gpio, GPIO_PIN_TYPE_STD); // no pull-up
        GPIO_setPinConfig(pins[n].function);
    }
}

static void serial_init(void) {
    SysCtl_enablePeripheral(SYSCTL_PERIPH_CLK_SCIA);
    SCI_performSoftwareReset(SCIA_BASE);
    SCI_setConfig(SCIA_BASE, SysCtl_getLowSpeedClock(DEVICE_OSCSRC_FREQ), BAUD,
                  SCI_CONFIG_WLEN_8 | SCI_CONFIG_STOP_ONE); // no parity
    SCI_enableFIFO(SCIA_BASE);
    SCI_resetTxFIFO(SCIA_BASE);
    SCI_enableModule(SCIA_BASE);
    GPIO_setPadConfig(VARIANT_TX_GPIO, GPIO_PIN_TYPE_STD);
    GPIO_setPinConfig(VARIANT_TX_PIN);
}

static void cycles_start(void) {
    SysCtl_enablePeripheral(SYSCTL_PERIPH_CLK_TIMER1);
    CPUTimer_stopTimer(CPUTIMER1_BASE);
    CPUTimer_setPreScaler(CPUTIMER1_BASE, 0u);
    CPUTimer_setPeriod(CPUTIMER1_BASE, UINT32_MAX);
    CPUTimer_setEmulationMode(CPUTIMER1_BASE, CPUTIMER_EMULATIONMODE_RUNFREE);
    CPUTimer_reloadTimerCounter(CPUTIMER1_BASE);
    CPUTimer_startTimer(CPUTIMER1_BASE);
}

// 256 counts of 10 MHz/512: 13.1 ms. Its reset lets the pins float, so that the driver's pull-downs switch off.
static void watchdog_start(void) {
    SysCtl_setWatchdogMode(SYSCTL_WD_MODE_RESET);
    SysCtl_setWatchdogPrescaler(SYSCTL_WD_PRESCALE_1);
    SysCtl_serviceWatchdog();
    SysCtl_enableWatchdog();
}

bool board_reset_by_watchdog(void) {
    const uint32_t cause = SysCtl_getResetCause();
    SysCtl_clearResetCause(cause);
    return (cause & (SYSCTL_CAUSE_WDRS | SYSCTL_CAUSE_NMIWDRS)) != 0u;
}

bool board_init(float i_trip_A) {
    Device_init(); // clocks and flash; stops the watchdog, which runs after a reset
    Device_initGPIO();
    driver_init();
    serial_init(); // needed to report a failure
    if (SysCtl_getClock(DEVICE_OSCSRC_FREQ) != CHIP_F_CPU_Hz) {
        return false;
    }
    Interrupt_initModule();
    Interrupt_initVectorTable();
    Interrupt_register(INT_NMI, &stop_handler);
    Interrupt_register(INT_ILLEGAL, &stop_handler);
    Interrupt_register(VARIANT_PERIOD_INT, &period_handler);
    cycles_start();
    chip_protection_init(i_trip_A);
    if (!chip_pwm_init()) {
        return false;
    }
    chip_adc_init();
    ti_init();
    pwm_pins_init(); // only now, when the trip zones hold the outputs low
    ti_driver_enable();
    return board_clear_trip();
}

void board_start(void) {
    watchdog_start();
    (void)chip_adc_acknowledge();
    Interrupt_clearACKGroup(VARIANT_PERIOD_GROUP);
    Interrupt_enable(VARIANT_PERIOD_INT);
    EINT;
    chip_pwm_start();
}

LODE_RAMFUNC __interrupt void period_handler(void) {
    ti_period();
    Interrupt_clearACKGroup(VARIANT_PERIOD_GROUP);
}

/// Unexpected interrupts: gates off, then the watchdog resets.
__interrupt void stop_handler(void) {
    board_gates_off();
    for (;;) {
    }
}

void board_feed_watchdog(void) {
    SysCtl_serviceWatchdog();
}

LODE_RAMFUNC uint32_t board_cycles(void) {
    return UINT32_MAX - CPUTimer_getTimerCount(CPUTIMER1_BASE); // it counts down
}

uint32_t board_send(const uint16_t *octets, uint32_t count) {
    uint32_t taken = 0u;
    while (taken < count && (uint32_t)SCI_getTxFIFOStatus(SCIA_BASE) < FIFO_DEPTH) {
        SCI_writeCharNonBlocking(SCIA_BASE, octets[taken]);
        taken++;
    }
    return taken;
}
