/// Sine and cosine by the CORDIC unit (option LODE_CORDIC): lode_sincos() calls it.
#include "chip.h"
#include "lodestar/scalar.h"

#define FUNCTION_COSINE 0u // results: cosine, then sine
#define CYCLES 6u          // 24 iterations; RM0440: residual error 2^-19
#define ONE 0x7FFFFFFFu    // modulus, q1.31
#define TURNS_PER_RAD 0.159154943f
// 2 pi in two parts; the first is 201/32, and n times it is exact.
#define TWO_PI_HIGH 6.28125f
#define TWO_PI_LOW 1.93530717958648e-3f
#define Q31_PER_RAD 683565275.6f     // 2^31/pi
#define Q31_MAX 2147483520.0f        // the largest float below 2^31
#define PER_Q31 4.6566128730774e-10f // 2^-31

static bool ready;

static LODE_NOINLINE void cordic_init(void) {
    const uint32_t control = FUNCTION_COSINE << CORDIC_CSR_FUNC_Pos |
                             CYCLES << CORDIC_CSR_PRECISION_Pos | CORDIC_CSR_NRES;
    REG_SET(RCC->AHB1ENR, RCC_AHB1ENR_CORDICEN);
    (void)REG_READ(RCC->AHB1ENR); // the clock is ready two cycles later
    REG_WRITE(CORDIC->CSR, control | CORDIC_CSR_NARGS);
    REG_WRITE(CORDIC->WDATA, 0u);
    REG_WRITE(CORDIC->WDATA, ONE); // kept from now on
    (void)REG_READ(CORDIC->RDATA);
    (void)REG_READ(CORDIC->RDATA);
    REG_WRITE(CORDIC->CSR, control);
    ready = true;
}

LODE_RAMFUNC lode_sincos_t lode_sincos_board(float x_rad) {
    const float turns = x_rad * TURNS_PER_RAD;
    const float n = (float)(int32_t)(turns + (turns < 0.0f ? -0.5f : 0.5f));
    const float r = (x_rad - n * TWO_PI_HIGH) - n * TWO_PI_LOW;
    const int32_t angle = (int32_t)lode_clamp(r * Q31_PER_RAD, -Q31_MAX, Q31_MAX);
    // Blocks the interrupt between the argument of the thread and its results.
    const uint32_t masked = __get_PRIMASK();
    __disable_irq();
    if (!ready) {
        cordic_init();
    }
    REG_WRITE(CORDIC->WDATA, (uint32_t)angle);
    const int32_t cos_q31 = (int32_t)REG_READ(CORDIC->RDATA); // the bus waits for the result
    const int32_t sin_q31 = (int32_t)REG_READ(CORDIC->RDATA);
    __set_PRIMASK(masked);
    return (lode_sincos_t){(float)sin_q31 * PER_Q31, (float)cos_q31 * PER_Q31};
}
