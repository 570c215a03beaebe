/// Start-up code and main program of the image on QEMU's mps2 boards: counts the instructions of some
/// cases by SysTick, which under `-icount shift=6` advances by 64 ns per instruction, and prints the sums.
#include "image.h"

#define SYST_CSR (*(volatile uint32_t *)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u)
#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define SYST_ENABLE 5u // counts the processor's clock
#define SYST_MASK 0x00FFFFFFu
#define FPU_ON (0xFu << 20)
#define WARM 100u
#define CALLS 300u
#define SYS_WRITE0 0x04
#define SYS_EXIT 0x18
#define APPLICATION_EXIT 0x20026

extern uint32_t bench_stack_top;
void bench_reset(void);
void bench_step_enhanced(uint32_t call);
void bench_step_start(uint32_t call);
void bench_step_fa_leso_leso_qpll(uint32_t call);

typedef struct {
    const uint32_t *stack;
    void (*reset)(void);
} vectors_t;

__attribute__((used, section(".vectors"))) static const vectors_t vectors = {&bench_stack_top,
                                                                             bench_reset};

static void semihost(int operation, const void *argument) {
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

static void print(const char *name, uint32_t value) {
    char digits[12];
    char *p = digits + sizeof digits;
    *--p = '\0';
    *--p = '\n';
    do {
        *--p = (char)('0' + value % 10u);
        value /= 10u;
    } while (value != 0u);
    semihost(SYS_WRITE0, name);
    semihost(SYS_WRITE0, p);
}

__attribute__((noinline)) static void no_step(uint32_t call) {
    __asm__ volatile("" ::"r"(call));
}

static uint32_t ticks(void (*step)(uint32_t), uint32_t call) {
    const uint32_t before = SYST_CVR;
    step(call);
    return (before - SYST_CVR) & SYST_MASK;
}

static void count(const char *name, void (*step)(uint32_t)) {
    for (uint32_t k = 0; k < WARM; k++) {
        step(k);
    }
    uint32_t sum = 0;
    for (uint32_t k = 0; k < CALLS; k++) {
        sum += ticks(step, WARM + k) - ticks(no_step, 0u);
    }
    print(name, sum);
}

__attribute__((used)) static void bench_main(void) {
    SYST_RVR = SYST_MASK;
    SYST_CVR = 0u;
    SYST_CSR = SYST_ENABLE;
    setup();
    count("step_enhanced ", bench_step_enhanced);
    count("step_start ", bench_step_start);
    count("step_fa_leso_leso_qpll ", bench_step_fa_leso_leso_qpll);
    print("check ", bench_check());
    // SYS_EXIT takes its reason in the register of the argument.
    semihost(SYS_EXIT, (const void *)APPLICATION_EXIT);
}

void bench_reset(void) {
    CPACR |= FPU_ON;
    __asm__ volatile("dsb\n isb");
    bench_main();
    for (;;) {
    }
}
