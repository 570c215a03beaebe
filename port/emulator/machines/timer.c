/// MPS2 boards: CMSDK timer 0 interrupts once per period, timer 1 runs freely.
#include "machine.h"
#include "plant.h"
#include "start.h"

typedef struct {
    volatile uint32_t ctrl;
    volatile uint32_t value; ///< counts down, then starts again from `reload`
    volatile uint32_t reload;
    volatile uint32_t intclear; ///< read: status
} cmsdk_timer_t;

#define TIMER0 ((cmsdk_timer_t *)MACHINE_TIMER_BASE)
#define TIMER1 ((cmsdk_timer_t *)(MACHINE_TIMER_BASE + 0x1000u))
#define CTRL_ENABLE 1u
#define CTRL_INTERRUPT 8u
#define NVIC_ISER0 (*(volatile uint32_t *)0xE000E100u)

#define TICKS_PER_PERIOD (MACHINE_CLOCK_Hz / (uint32_t)PLANT_F_PWM_Hz)
#define TICKS_PER_STAMP (TICKS_PER_PERIOD / PLANT_STAMP_PER_PERIOD)

static volatile uint32_t entries;
static volatile uint32_t entered_ticks; // of timer 1, when the interrupt was entered last

// Since machine_start(); wraps after minutes.
static uint32_t ticks(void) {
    return UINT32_MAX - TIMER1->value;
}

void machine_start(void) {
    TIMER1->reload = UINT32_MAX;
    TIMER1->value = UINT32_MAX;
    TIMER0->reload = TICKS_PER_PERIOD - 1u;
    TIMER0->value = TICKS_PER_PERIOD - 1u;
    NVIC_ISER0 = 1u << MACHINE_IRQ;
    TIMER1->ctrl = CTRL_ENABLE;
    TIMER0->ctrl = CTRL_ENABLE | CTRL_INTERRUPT;
}

void timer_handler(void) {
    entered_ticks = ticks();
    TIMER0->intclear = 1u;
    entries++;
    emulator_period();
}

// Not with WFI: qemu 7.2 skips idle time under -icount, and skips every second tick with it.
void machine_wait(void) {
    static uint32_t seen;
    while (entries == seen) {
    }
    seen = entries;
}

uint32_t machine_stamp(void) {
    return ticks() / TICKS_PER_STAMP;
}

bool machine_has_timer(void) {
    return true;
}

uint32_t machine_entries(void) {
    return entries;
}

// The nearest whole number: an entry comes within microseconds of its tick.
uint32_t machine_elapsed(void) {
    return (entered_ticks + TICKS_PER_PERIOD / 2u) / TICKS_PER_PERIOD;
}
