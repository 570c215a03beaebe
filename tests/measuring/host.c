// The page's code against stand-ins of the registers: a reading takes 5 cycles, a step 1000 in OFF and
// 2000 .. 2900 in RUN, and the counter wraps around while that is measured.
#include <stdio.h>

#include "board.h"

#define READING_CYCLES 5u

static uint32_t now, step_cycles;
static lode_mode_t mode_now;

#ifdef CORTEX_M
static core_debug_t core_debug;
static dwt_t dwt;

static bool counting(void) {
    return dwt.CTRL == DWT_CTRL_CYCCNTENA_Msk && core_debug.DEMCR == CoreDebug_DEMCR_TRCENA_Msk;
}

static dwt_t *dwt_now(void) {
    if (counting()) {
        now += READING_CYCLES;
        dwt.CYCCNT = now;
    }
    return &dwt;
}
#undef DWT
#define DWT dwt_now()
#undef CoreDebug
#define CoreDebug (&core_debug)
#define __CORTEX_M 4
#endif

#ifdef C28X
static uint32_t period, running, loaded;
static uint16_t prescaler = 1;

static bool counting(void) {
    return running == CPUTIMER1_BASE && loaded == running && period == UINT32_MAX && prescaler == 0;
}

void CPUTimer_stopTimer(uint32_t base) {
    running = running == base ? 0u : running;
}

void CPUTimer_setPeriod(uint32_t base, uint32_t count) {
    period = base == CPUTIMER1_BASE ? count : 0u;
}

void CPUTimer_setPreScaler(uint32_t base, uint16_t scale) {
    prescaler = base == CPUTIMER1_BASE ? scale : 1;
}

void CPUTimer_reloadTimerCounter(uint32_t base) {
    loaded = base;
}

void CPUTimer_startTimer(uint32_t base) {
    running = base;
}

uint32_t CPUTimer_getTimerCount(uint32_t base) {
    now += base == running ? READING_CYCLES : 0u;
    return period - now;
}
#endif

lode_counts_t board_read_adc(void) {
    now += 300u;
    return (lode_counts_t){0};
}

void board_write_pwm(lode_abc_t duty, lode_gates_t gates) {
    now += gates && duty.a > 0.0f ? 200u : 100u;
}

static lode_drive_out_t step(void) {
    now += step_cycles;
    return (lode_drive_out_t){{0.5f, 0.5f, 0.5f}, true};
}
#define lode_drive_step(self, counts) ((void)(self), (void)(counts), step())
#define lode_channel_read(self, channel) ((channel) == LODE_CHANNEL_MODE ? (float)mode_now : -1.0f)

#include COUNTER
#include "collect.h"

static bool holds(lode_mode_t mode, uint32_t least, uint32_t sum, uint32_t most) {
    const cycles_t *is = &cycles[mode];
    printf("mode %d: %u calls, %u, sum %u, %u\n", (int)mode, (unsigned)is->calls,
           (unsigned)is->least, (unsigned)is->sum, (unsigned)is->most);
    return is->calls == 10u && is->least == least && is->sum == sum && is->most == most;
}

int main(void) {
    if (!cycles_init() || !counting() || overhead != READING_CYCLES) {
        printf("overhead %u\n", (unsigned)overhead);
        return 1;
    }
    now = 0xFFFFF000u;
    for (uint32_t i = 0; i < 20u; i++) {
        mode_now = i < 10u ? LODE_MODE_OFF : LODE_MODE_RUN;
        step_cycles = i < 10u ? 1000u : 2000u + 100u * (i * 7u % 10u);
        pwm_interrupt();
    }
    bool good = holds(LODE_MODE_OFF, 1000u, 10000u, 1000u);
    good = holds(LODE_MODE_RUN, 2000u, 24500u, 2900u) && good;
#ifdef CORTEX_M
    dwt.CTRL = DWT_CTRL_NOCYCCNT_Msk;
    good = !cycles_init() && good;
#endif
    return good ? 0 : 1;
}
