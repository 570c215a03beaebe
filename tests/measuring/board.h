// What docs/measuring.md takes for granted: a drive, a board, and the registers of a chip.
#ifndef MEASURING_BOARD_H
#define MEASURING_BOARD_H

#include "lodestar/lodestar.h"

lode_counts_t board_read_adc(void);
void board_write_pwm(lode_abc_t duty, lode_gates_t gates);
void pwm_interrupt(void);
bool counter_start(void);
bool cycles_init(void);
static lode_drive_t drive;

#ifdef CORTEX_M
typedef struct {
    volatile uint32_t CTRL, CYCCNT;
} dwt_t;
typedef struct {
    volatile uint32_t DEMCR;
} core_debug_t;
#define CoreDebug_DEMCR_TRCENA_Msk (1u << 24)
#define DWT_CTRL_NOCYCCNT_Msk (1u << 25)
#define DWT_CTRL_CYCCNTENA_Msk 1u
#define DWT ((dwt_t *)0xE0001000u)
#define CoreDebug ((core_debug_t *)0xE000EDFCu)
#endif

#ifdef C28X
#define CPUTIMER1_BASE 0x0C08u
void CPUTimer_stopTimer(uint32_t base);
void CPUTimer_setPeriod(uint32_t base, uint32_t count);
void CPUTimer_setPreScaler(uint32_t base, uint16_t scale);
void CPUTimer_reloadTimerCounter(uint32_t base);
void CPUTimer_startTimer(uint32_t base);
uint32_t CPUTimer_getTimerCount(uint32_t base);
#endif

#endif
