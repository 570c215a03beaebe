// The STM32 ports on recorded registers: what is written, with which value, and in which order. Built
// once per board.
#include "app.h"
#include "board.h"
#include "chip.h"
#include "fake.h"
#include "figures.h"
#include "pwm.h"
#include "support/check.h"

#ifndef VARIANT_SENSING
#define VARIANT_SENSING PORT_LOW_SIDE_THREE
#endif

#ifndef VARIANT_PRECHARGE_s
#define VARIANT_PRECHARGE_s 0.0f
#endif

#ifdef BOARD_FIGURES_H // of the board's documents, not of its header
#include BOARD_FIGURES_H
#endif

#define TRIP_A 1.0e3f // more than any board bears

#define STEPS (CHIP_F_PWM_Hz / VARIANT_F_PWM_Hz / 2u)
#define PERIOD (CHIP_F_STAMP_Hz / PORT_F_CALL_Hz)
#define HALF (CHIP_F_STAMP_Hz / VARIANT_F_PWM_Hz / 2u)
#define BDTR_DTG 0xFFu
#define BDTR_LOCK (3u << 8)
#define DUTY_MAX port_duty_max((float)VARIANT_F_PWM_Hz, VARIANT_SETTLE_ns, CHIP_SAMPLE_ns)

#if defined(FAKE_G4) || defined(FAKE_H7)
#define HAS_SYSTEM_BREAK // and polarities of the break's sources, and one ADC after another
#endif
#ifdef FAKE_G4
#define SERIAL_PORT USART2
#define SWITCH_PLL 3u
#define WAIT_STATES 4u
#elif defined(FAKE_H7)
#define SERIAL_PORT USART3
#define SWITCH_PLL 3u
#define WAIT_STATES 2u
#else
#define SERIAL_PORT USART3
#define SWITCH_PLL 2u
#define WAIT_STATES 5u
#endif
#ifdef FAKE_H7
#define WATCHDOG_FLAG 26u // of RCC_RSR
#define F_RC_Hz 64000000u
#else
#define WATCHDOG_FLAG 29u // of RCC_CSR
#define F_RC_Hz 16000000u
#endif
#ifdef HAS_SYSTEM_BREAK
#define BREAK_ACTIVE_HIGH TIM_BDTR_BKP // behind the polarity of each source
#define ADC_ARMED(from) fake_first(&ADC1->CR, ADC_CR_JADSTART, ADC_CR_JADSTART, (from))
#else
#define BREAK_ACTIVE_HIGH 0u
#define ADC_ARMED(from) fake_first(&ADC1->CR1, ADC_CR1_JEOCIE, ADC_CR1_JEOCIE, (from))
#endif
#define PWM_CLOCK fake_first(&RCC->APB2ENR, RCC_APB2ENR_TIM1EN, RCC_APB2ENR_TIM1EN, 0)

void STM32_PERIOD_HANDLER(void);

static const stm32_pin_t pwm_pins[] = {VARIANT_PWM_PINS};

void setUp(void) {
    fake_reset();
}

void tearDown(void) {}

static int first(const volatile uint32_t *reg, uint32_t mask, uint32_t bits) {
    const int at = fake_first(reg, mask, bits, 0);
    TEST_ASSERT_TRUE(at >= 0);
    return at;
}

static bool gates_on(void) {
    return (fake_read(&TIM1->BDTR) & TIM_BDTR_MOE) != 0u;
}

// --- turning points ---

// The timer comes to its next turning point. True: with an update event, which takes compare values over (they are
// preloaded) and triggers the ADCs. Repetition counter 1, written before the start: the lower one only.
static uint32_t acting[3];

static bool next_turn(void) {
    fake_run(HALF);
    TIM1->CR1 ^= TIM_CR1_DIR;
    const bool updates = TIM1->RCR == 0u || (TIM1->CR1 & TIM_CR1_DIR) == 0u;
    if (updates) {
        acting[0] = TIM1->CCR1;
        acting[1] = TIM1->CCR2;
        acting[2] = TIM1->CCR3;
    }
    return updates;
}

static void next_call(void) {
    while (!next_turn()) {
    }
}

static void change_compare(int x) {
    volatile uint32_t *const compare[3] = {&TIM1->CCR1, &TIM1->CCR2, &TIM1->CCR3};
    *compare[x] ^= 1u;
}

#include "calls_cases.h"

// --- figures ---

// RM0440 and RM0090, bits DTG: the dead time that a code makes, in timer periods.
static uint32_t dead_ticks(uint32_t dtg) {
    if (dtg < 0x80u) {
        return dtg;
    }
    if (dtg < 0xC0u) {
        return (64u + (dtg & 63u)) * 2u;
    }
    return (32u + (dtg & 31u)) * (dtg < 0xE0u ? 8u : 16u);
}

static void test_dead_time_code(void) {
    static const uint32_t clocks[] = {84000000u, 168000000u, 170000000u};
    for (int c = 0; c < COUNT_OF(clocks); c++) {
        const double tick_ns = 1.0e9 / (double)clocks[c];
        for (uint32_t ns = 0; ns < 12500u; ns++) {
            uint32_t dtg = 0xFFFFu;
            if (!stm32_dead_time(clocks[c], ns, &dtg)) {
                TEST_ASSERT_TRUE((double)ns > 1000.0 * tick_ns); // beyond the last code but one
                continue;
            }
            TEST_ASSERT_TRUE(dtg <= 0xFFu);
            const double made = (double)dead_ticks(dtg) * tick_ns;
            const double step = made > 504.0 * tick_ns ? 16.0 : made > 254.0 * tick_ns ? 8.0 : 2.0;
            CHECK_AT_LEAST((double)ns - 1.0e-3, made); // never shorter than asked for
            CHECK_AT_MOST((double)ns + step * tick_ns, made);
        }
    }
    uint32_t dtg = 0u;
    TEST_ASSERT_TRUE(stm32_dead_time(170000000u, 500u, &dtg)); // 85 periods, first range
    TEST_ASSERT_EQUAL_HEX32(85u, dtg);
    TEST_ASSERT_TRUE(stm32_dead_time(170000000u, 800u, &dtg)); // 136, second range
    TEST_ASSERT_EQUAL_HEX32(0x80u | (136u / 2u - 64u), dtg);
    TEST_ASSERT_TRUE(stm32_dead_time(170000000u, 2000u, &dtg)); // 340, third range
    TEST_ASSERT_EQUAL_HEX32(0xC0u | (344u / 8u - 32u), dtg);
    TEST_ASSERT_TRUE(stm32_dead_time(170000000u, 4000u, &dtg)); // 680, fourth range
    TEST_ASSERT_EQUAL_HEX32(0xE0u | (688u / 16u - 32u), dtg);
    TEST_ASSERT_FALSE(stm32_dead_time(170000000u, 6000u, &dtg));
    TEST_ASSERT_FALSE(stm32_dead_time(170000000u, UINT32_MAX, &dtg));
}

static void test_period_in_steps(void) {
    TEST_ASSERT_EQUAL_UINT32(4250u, port_pwm_steps(170000000u, 20000u));
    TEST_ASSERT_EQUAL_UINT32(4200u, port_pwm_steps(168000000u, 20000u));
    TEST_ASSERT_EQUAL_UINT32(0u, port_pwm_steps(170000000u, 1000u)); // beyond 16 bits
    TEST_ASSERT_EQUAL_UINT32(0u, port_pwm_steps(170000000u, 0u));
}

// A low side that is on for `low_s` around t_k has settled before t_k and is sampled before its end.
static void test_least_low_side_window(void) {
    const double period_s = 1.0 / (double)VARIANT_F_PWM_Hz;
    const double half_low_s = 0.5 * (1.0 - (double)DUTY_MAX) * period_s;
    CHECK_AT_LEAST((double)VARIANT_SETTLE_ns * 0.999999e-9, half_low_s);
    CHECK_AT_LEAST((double)CHIP_SAMPLE_ns * 0.999999e-9, half_low_s);
    CHECK_AT_LEAST((double)VARIANT_DEAD_TIME_ns * 1.0e-9, half_low_s);
    TEST_ASSERT_TRUE(DUTY_MAX > 0.8f && DUTY_MAX < 1.0f);
    const bool low_side =
        VARIANT_SENSING == PORT_LOW_SIDE_THREE || VARIANT_SENSING == PORT_LOW_SIDE_TWO;
    const bool two = VARIANT_SENSING == PORT_LOW_SIDE_TWO || VARIANT_SENSING == PORT_IN_LINE_TWO;
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    CHECK_CLOSE(1e-6, low_side ? DUTY_MAX : 1.0f, config.sense.duty_max);
    TEST_ASSERT_EQUAL_INT(two ? LODE_SHUNTS_TWO : LODE_SHUNTS_THREE, config.sense.shunts);
    config.motor = (lode_motor_t){.pole_pairs = 4.0f,
                                  .Rs_Ohm = 0.6f,
                                  .Ld_H = 0.6e-3f,
                                  .Lq_H = 0.6e-3f,
                                  .psi_Wb = 6.5e-3f,
                                  .J_kgm2 = 3.0e-5f};
    lode_drive_design(&config);
    // No phase that is used goes beyond the window, the dead-time correction included; with two shunts also 50 ns
    // that a start may measure too much.
    const double lost_s = VARIANT_DEAD_TIME_ns * 1.0e-9 + (two ? 50.0e-9 : 0.0);
    const double most = (low_side ? (double)DUTY_MAX : 1.0) - lost_s / period_s;
    const double reach = two ? 0.5 : sqrt(3.0) / 4.0;
    CHECK_CLOSE(1e-4, fmin(0.95, low_side ? (most - 0.5) / reach : 0.95),
                config.current.voltage_use);
}

// With that share of the circle the second largest duty leaves its phase sampled, at every angle.
static void test_two_phases_can_always_be_sampled(void) {
    const float use = port_voltage_use(DUTY_MAX);
    const double u = (double)use / sqrt(3.0); // of the bus
    for (int n = 0; n < 3600; n++) {
        const double angle = n * 0.1 * CHECK_DEG;
        double v[3], low = 2.0, high = -2.0, second = -2.0;
        for (int x = 0; x < 3; x++) {
            v[x] = u * cos(angle - x * 2.0 * CHECK_PI / 3.0);
            low = fmin(low, v[x]);
            high = fmax(high, v[x]);
        }
        const double common = 0.5 - 0.5 * (low + high);
        for (int x = 0; x < 3; x++) {
            second = v[x] < high ? fmax(second, v[x]) : second;
        }
        CHECK_AT_MOST((double)DUTY_MAX + 1e-6, second + common);
    }
    CHECK_CLOSE(1e-6, 0.95, port_voltage_use(1.0f));
    CHECK_NEAR(1e-9, 0.0, port_voltage_use(0.4f));
}

#ifdef BOARD_FIGURES_H
static void test_figures_are_those_of_the_board(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    CHECK_CLOSE(1e-5, BOARD_DEAD_TIME_s, config.inverter.dead_time_s);
    CHECK_NEAR(1e-6, BOARD_R_ON_Ohm, config.inverter.r_on_Ohm);
    CHECK_CLOSE(1e-6, BOARD_I_MAX_A, config.inverter.i_max_A);
    CHECK_CLOSE(1e-3, BOARD_I_GAIN_A_count, config.sense.i_gain_A_count);
    CHECK_NEAR(1.0, BOARD_I_OFFSET_count, config.sense.i_offset_count);
    CHECK_CLOSE(1e-3, BOARD_BUS_V_count, config.sense.v_bus_gain_V_count);
    CHECK_CLOSE(1e-3, BOARD_T_GAIN_degC_count, config.sense.temperature_gain_degC_count);
    CHECK_NEAR(0.05, BOARD_T_OFFSET_degC, config.sense.temperature_offset_degC);
    CHECK_CLOSE(1e-6, BOARD_T_MAX_degC, config.guard.temperature_max_degC);
    // A low side's least time on, half of it before t_k.
    CHECK_CLOSE(1e-4, 2.0 * BOARD_SETTLE_s,
                (1.0 - (double)config.sense.duty_max) / (double)VARIANT_F_PWM_Hz);
}
#endif

static void test_configuration_is_accepted(void) {
    TEST_ASSERT_TRUE(app_start());
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(app_status()));
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    CHECK_CLOSE(1e-6, STEPS, config.inverter.pwm_ticks);
    CHECK_CLOSE(1e-6, PERIOD, config.guard.stamp_per_period);
    CHECK_CLOSE(1e-6, (VARIANT_DOUBLE_UPDATE ? 2.0 : 1.0) * VARIANT_F_PWM_Hz, config.f_pwm_Hz);
    TEST_ASSERT_EQUAL_INT(VARIANT_DOUBLE_UPDATE ? LODE_ON : LODE_OFF,
                          config.inverter.double_update);
    // Low-side shunts: current into the motor lowers the count.
    TEST_ASSERT_TRUE(config.sense.i_gain_A_count < 0.0f);
}

// --- order of the initialisation ---

static void test_outputs_are_safe_before_the_pins_are_theirs(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    const int clock = PWM_CLOCK;
    const int off = first(&RCC->APB2RSTR, RCC_APB2RSTR_TIM1RST, RCC_APB2RSTR_TIM1RST);
    const int locked = first(&TIM1->BDTR, BDTR_LOCK, TIM_BDTR_LOCK_1);
    TEST_ASSERT_TRUE(clock >= 0 && off > clock);
    TEST_ASSERT_TRUE(locked > off);
    for (int n = 0; n < COUNT_OF(pwm_pins); n++) {
        const uint32_t shift = 2u * pwm_pins[n].pin;
        const int mode = fake_first(&pwm_pins[n].port->MODER, 3u << shift, 2u << shift, 0);
        TEST_ASSERT_TRUE(mode >
                         locked); // alternate function only when the timer holds them inactive
        const uint32_t at = 4u * (pwm_pins[n].pin % 8u);
        const int chosen = fake_first(&pwm_pins[n].port->AFR[pwm_pins[n].pin / 8u], 15u << at,
                                      pwm_pins[n].alternate << at, 0);
        TEST_ASSERT_TRUE(chosen >= 0 && chosen < mode);
    }
    TEST_ASSERT_EQUAL_INT(-1, fake_first(&TIM1->BDTR, TIM_BDTR_MOE, TIM_BDTR_MOE, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(&TIM1->CR1, TIM_CR1_CEN, TIM_CR1_CEN, 0));
}

// LOCK can be written once after a reset, and gates off before the initialisation may have been that.
static void test_lock_holds_whatever_was_written_before(void) {
    board_gates_off();
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    const uint32_t locked = TIM1->BDTR;
    TEST_ASSERT_EQUAL_HEX32(TIM_BDTR_LOCK_1, locked & BDTR_LOCK);
    fake_write(&TIM1->BDTR, "BDTR", 0u); // a program that has lost its way
    TEST_ASSERT_EQUAL_HEX32(locked, TIM1->BDTR);
}

static void test_start_arms_then_counts_and_leaves_the_gates_off(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_INT(-1, fake_irq_enabled(18)); // masked until board_start()
    const int from = fake_count();
    board_start();
    const int armed = ADC_ARMED(from);
    const int counting = fake_first(&TIM1->CR1, TIM_CR1_CEN, TIM_CR1_CEN, from);
    TEST_ASSERT_TRUE(armed >= from && counting > armed);
    TEST_ASSERT_TRUE(fake_irq_enabled(18) > armed && fake_irq_enabled(18) <= counting);
    TEST_ASSERT_EQUAL_UINT32(0u, fake_irq_priority(18));
    TEST_ASSERT_FALSE(gates_on());
}

static void test_timer_settings(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_HEX32(TIM_CR1_ARPE | TIM_CR1_CMS_0, TIM1->CR1);
    TEST_ASSERT_EQUAL_UINT32(STEPS, TIM1->ARR);
    TEST_ASSERT_EQUAL_UINT32(VARIANT_DOUBLE_UPDATE ? 0u : 1u, TIM1->RCR); // two updates, or one
    // Three compare registers in PWM mode 2, preloaded.
    TEST_ASSERT_EQUAL_HEX32(0x7878u, TIM1->CCMR1);
    TEST_ASSERT_EQUAL_HEX32(0x78u, TIM1->CCMR2);
    TEST_ASSERT_EQUAL_HEX32(VARIANT_LOW_SIDES ? 0x555u : 0x111u, TIM1->CCER);
    const int rcr = first(&TIM1->RCR, 0u, 0u);
    const int update = first(&TIM1->EGR, TIM_EGR_UG, TIM_EGR_UG);
    TEST_ASSERT_TRUE(rcr < update);
    TEST_ASSERT_TRUE(update > first(&TIM1->CCR3, 0u, 0u));
    TEST_ASSERT_TRUE(fake_first(&TIM1->SR, ~0u, 0u, update) > update);
}

static void test_trigger_is_the_update_and_nothing_hears_it_before_the_start(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_HEX32(2u << 4, TIM1->CR2 & (7u << 4)); // MMS: update
#ifdef HAS_SYSTEM_BREAK
    TEST_ASSERT_EQUAL_HEX32(0u, (ADC1->JSQR >> 2) & 31u); // JEXTSEL: TIM1_TRGO
    TEST_ASSERT_EQUAL_HEX32(1u, (ADC1->JSQR >> 7) & 3u);  // JEXTEN: rising
    TEST_ASSERT_EQUAL_HEX32(0u, (ADC2->JSQR >> 7) & 3u);  // follows
    TEST_ASSERT_EQUAL_HEX32(ADC1->JSQR & 3u, ADC2->JSQR & 3u);
    TEST_ASSERT_EQUAL_HEX32(5u, ADC12_COMMON->CCR & 31u); // injected simultaneous
    const uint32_t ranks[] = VARIANT_ADC1_RANKS;
    TEST_ASSERT_EQUAL_UINT32(ranks[0], (ADC1->JSQR >> 9) & 31u);
    TEST_ASSERT_EQUAL_UINT32(ranks[1], (ADC1->JSQR >> 15) & 31u);
    TEST_ASSERT_EQUAL_UINT32(ranks[2], (ADC1->JSQR >> 21) & 31u);
    // Calibrated before enabled.
    const int calibrated = first(&ADC1->CR, ADC_CR_ADCAL, ADC_CR_ADCAL);
    TEST_ASSERT_TRUE(first(&ADC1->CR, ADC_CR_ADEN, ADC_CR_ADEN) > calibrated);
#ifdef FAKE_G4
    for (int n = 0; n < COUNT_OF(ranks); n++) { // 6.5 cycles each
        const uint32_t times = ranks[n] < 10u ? ADC1->SMPR1 : ADC1->SMPR2;
        TEST_ASSERT_EQUAL_UINT32(1u, times >> (3u * (ranks[n] % 10u)) & 7u);
    }
#endif
#ifdef FAKE_H7
    TEST_ASSERT_EQUAL_HEX32(1u << 10 | 1u << 4 | 1u << 5, ADC1->PCSEL);
    TEST_ASSERT_EQUAL_HEX32(1u << 11 | 1u << 8, ADC2->PCSEL);
    TEST_ASSERT_EQUAL_HEX32(2u << 2, ADC2->CFGR);         // 12 bits
    TEST_ASSERT_EQUAL_HEX32(2u << 8, ADC1->CR & 3u << 8); // BOOST, kept
    TEST_ASSERT_EQUAL_HEX32(2u << 30 | 2u << 12 | 2u << 15, (ADC1->SMPR2 << 30) | ADC1->SMPR1);
#endif
#else
    TEST_ASSERT_EQUAL_HEX32(1u, (ADC1->CR2 >> 16) & 15u); // JEXTSEL: TIM1_TRGO
    TEST_ASSERT_EQUAL_HEX32(1u, (ADC1->CR2 >> 20) & 3u);  // JEXTEN: rising
    TEST_ASSERT_EQUAL_HEX32(0u, (ADC2->CR2 >> 20) & 3u);  // follow
    TEST_ASSERT_EQUAL_HEX32(0u, (ADC3->CR2 >> 20) & 3u);
    TEST_ASSERT_EQUAL_HEX32(21u, ADC123_COMMON->CCR & 31u); // triple injected simultaneous
    const uint32_t ranks[] = VARIANT_ADC1_RANKS;
    TEST_ASSERT_EQUAL_UINT32(1u, (ADC1->JSQR >> 20) & 3u);
    TEST_ASSERT_EQUAL_UINT32(ranks[0], (ADC1->JSQR >> 10) & 31u);
    TEST_ASSERT_EQUAL_UINT32(ranks[1], (ADC1->JSQR >> 15) & 31u);
#endif
    TEST_ASSERT_EQUAL_INT(-1, ADC_ARMED(0));
}

static void test_clock_that_does_not_come_keeps_everything_off(void) {
    fake_kill_clock();
    TEST_ASSERT_FALSE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(&TIM1->CR1, TIM_CR1_CEN, TIM_CR1_CEN, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(&TIM1->BDTR, TIM_BDTR_MOE, TIM_BDTR_MOE, 0));
    fake_reset();
    fake_kill_clock();
    TEST_ASSERT_FALSE(app_start());
    TEST_ASSERT_EQUAL_INT(-1, fake_irq_enabled(18));
}

static void test_wait_states_before_the_faster_clock(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    const int wait_states = first(&FLASH->ACR, 7u, WAIT_STATES);
    TEST_ASSERT_TRUE(first(&RCC->CFGR, RCC_CFGR_SW, SWITCH_PLL) > wait_states);
    // VCO: source / M * N.
#ifdef FAKE_G4
    TEST_ASSERT_EQUAL_HEX32(PWR_CR3_UCPD_DBDIS, PWR->CR3);
    const uint32_t m = ((RCC->PLLCFGR >> 4) & 15u) + 1u;
    const uint32_t n = (RCC->PLLCFGR >> 8) & 127u;
#elif defined(FAKE_H7)
    TEST_ASSERT_EQUAL_HEX32(3u << 14, PWR->D3CR & PWR_D3CR_VOS);
    TEST_ASSERT_TRUE(first(&PWR->D3CR, PWR_D3CR_VOS, 3u << 14) > first(&PWR->CR3, 6u, 2u));
    TEST_ASSERT_TRUE(first(&RCC->D1CFGR, ~0u, 0x48u) < first(&RCC->CFGR, RCC_CFGR_SW, 3u));
    TEST_ASSERT_EQUAL_HEX32(0x440u, RCC->D2CFGR);
    TEST_ASSERT_EQUAL_HEX32(0x10004u, RCC->PLLCFGR);         // input 2 .. 4 MHz, output P
    TEST_ASSERT_EQUAL_UINT32(1u, RCC->PLL1DIVR >> 9 & 127u); // P = 2
    const uint32_t m = (RCC->PLLCKSELR >> 4) & 63u;
    const uint32_t n = (RCC->PLL1DIVR & 511u) + 1u;
#else
    const uint32_t m = RCC->PLLCFGR & 63u;
    const uint32_t n = (RCC->PLLCFGR >> 6) & 511u;
#endif
    TEST_ASSERT_EQUAL_UINT32(2u * CHIP_F_CPU_Hz, VARIANT_HSE_Hz / m * n);
}

// --- trip ---

#ifdef VARIANT_BREAK2_PIN
static void expect_break_pin(stm32_pin_t pin) {
    TEST_ASSERT_EQUAL_HEX32(2u, pin.port->MODER >> (2u * pin.pin) & 3u);
    TEST_ASSERT_EQUAL_HEX32(1u, pin.port->PUPDR >> (2u * pin.pin) & 3u); // up
    TEST_ASSERT_EQUAL_HEX32(pin.alternate,
                            pin.port->AFR[pin.pin / 8u] >> (4u * (pin.pin % 8u)) & 15u);
}
#endif

static void test_break_input(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    uint32_t dtg = 0u;
    TEST_ASSERT_TRUE(stm32_dead_time(CHIP_F_PWM_Hz, VARIANT_DEAD_TIME_ns, &dtg));
    TEST_ASSERT_EQUAL_HEX32(dtg, TIM1->BDTR & BDTR_DTG);
    // The register and the correction are one dead time.
    const double made_s = (double)dead_ticks(TIM1->BDTR & BDTR_DTG) / (double)CHIP_F_PWM_Hz;
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    CHECK_NEAR(16.0 / (double)CHIP_F_PWM_Hz, config.inverter.dead_time_s, made_s);
    CHECK_AT_LEAST((double)config.inverter.dead_time_s - 1.0e-12, made_s);
    const uint32_t wanted = TIM_BDTR_BKE | TIM_BDTR_OSSI | TIM_BDTR_OSSR | BREAK_ACTIVE_HIGH;
    TEST_ASSERT_EQUAL_HEX32(wanted, TIM1->BDTR & (wanted | TIM_BDTR_BKP));
    TEST_ASSERT_EQUAL_HEX32(0u, TIM1->BDTR & (1u << 14)); // no automatic return of the outputs
    TEST_ASSERT_EQUAL_HEX32(TIM_BDTR_LOCK_1, TIM1->BDTR & BDTR_LOCK);
#ifdef HAS_SYSTEM_BREAK
    TEST_ASSERT_EQUAL_HEX32(4u, (TIM1->BDTR >> 16) & 15u); // filter
    const int sources = first(&TIM1->AF1, 0u, 0u);
    TEST_ASSERT_TRUE(sources < first(&TIM1->BDTR, BDTR_LOCK, TIM_BDTR_LOCK_1)); // locked with it
#ifdef VARIANT_INTERNAL_ANALOG
    TEST_ASSERT_EQUAL_HEX32(TIM1_AF1_BKCMP1E | TIM1_AF1_BKCMP2E | TIM1_AF1_BKCMP4E, TIM1->AF1);
#else
    TEST_ASSERT_EQUAL_HEX32(TIM1_AF1_BKINE | TIM1_AF1_BKINP, TIM1->AF1); // the pin is active low
#endif
#ifdef VARIANT_BREAK2_PIN
    TEST_ASSERT_EQUAL_HEX32(TIM1_AF2_BK2INE | TIM1_AF2_BK2INP, TIM1->AF2);
    const uint32_t second = TIM_BDTR_BK2E | TIM_BDTR_BK2P | 4u << TIM_BDTR_BK2F_Pos;
    TEST_ASSERT_EQUAL_HEX32(second, TIM1->BDTR & (second | 15u << TIM_BDTR_BK2F_Pos));
    expect_break_pin((stm32_pin_t)VARIANT_BREAK_PIN);
    expect_break_pin((stm32_pin_t)VARIANT_BREAK2_PIN);
#endif
#endif
}

#ifdef VARIANT_INTERNAL_ANALOG
static void expect_threshold(float wanted_A, float amperes) {
    fake_reset();
    TEST_ASSERT_TRUE(board_init(wanted_A));
    const double volts = (double)DAC3->DHR12R1 / 4095.0 * (double)VARIANT_V_REF_V;
    CHECK_NEAR(0.3, amperes, // one count is 0.47 A
               (volts - (double)VARIANT_BIAS_V) /
                   ((double)VARIANT_SHUNT_Ohm * (double)VARIANT_DIVIDER));
    TEST_ASSERT_EQUAL_UINT32(DAC3->DHR12R1, DAC3->DHR12R2);
}

static void test_comparators_and_their_threshold(void) {
    expect_threshold(0.1f, VARIANT_TRIP_MIN_A);
    expect_threshold(18.0f, 18.0f);
    expect_threshold(TRIP_A, VARIANT_TRIP_MAX_A);
    const int threshold = first(&DAC3->DHR12R2, 0xFFFu, DAC3->DHR12R2);
    const COMP_TypeDef *const comparators[] = {COMP1, COMP2, COMP4};
    for (int n = 0; n < 3; n++) {
        TEST_ASSERT_EQUAL_HEX32(COMP_CSR_EN | 4u << 4, comparators[n]->CSR);
        const int on = first(&comparators[n]->CSR, COMP_CSR_EN, COMP_CSR_EN);
        TEST_ASSERT_TRUE(on > threshold);
        TEST_ASSERT_TRUE(on < first(&TIM1->BDTR, TIM_BDTR_BKE, TIM_BDTR_BKE));
    }
    // Amplifiers: set up first, then on.
    TEST_ASSERT_TRUE(first(&OPAMP1->CSR, OPAMP_CSR_OPAMPxEN, 0u) <
                     first(&OPAMP1->CSR, OPAMP_CSR_OPAMPxEN, OPAMP_CSR_OPAMPxEN));
}
#endif

#ifdef VARIANT_INTERNAL_ANALOG
// Each comparator alone: the other two would hide a dead one.
static void test_trip_path_is_tested(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    const uint32_t threshold = DAC3->DHR12R1;
    board_write(&(lode_drive_out_t){.gates = true});
    TEST_ASSERT_TRUE(gates_on());
    const int from = fake_count();
    TEST_ASSERT_TRUE(board_test_trip());
    TEST_ASSERT_FALSE(gates_on());
    const int off = fake_first(&TIM1->BDTR, TIM_BDTR_MOE, 0u, from); // by itself, before that
    TEST_ASSERT_TRUE(off >= from && fake_first(&DAC3->DHR12R1, ~0u, 0u, from) > off);
    TEST_ASSERT_EQUAL_UINT32(threshold, DAC3->DHR12R1);
    TEST_ASSERT_EQUAL_UINT32(threshold, DAC3->DHR12R2);
    lode_counts_t counts;
    board_read(&counts);
    TEST_ASSERT_FALSE(counts.trip); // leaves no trip behind
    for (int n = 0; n < 3; n++) {
        fake_reset();
        TEST_ASSERT_TRUE(board_init(TRIP_A));
        fake_kill_comparator(n);
        TEST_ASSERT_FALSE(board_test_trip());
    }
}
#else
static void test_trip_path_is_tested(void) { // the driver's: nothing in reach
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_TRUE(board_test_trip());
}
#endif

static void test_latched_trip_keeps_the_gates_off(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    const lode_drive_out_t on = {.duty = {0.5f, 0.5f, 0.5f}, .gates = true};
    board_write(&on);
    TEST_ASSERT_TRUE(gates_on());
    fake_set_break(true);
    TEST_ASSERT_FALSE(gates_on());
    TEST_ASSERT_TRUE(trip_in_next_call());
    TEST_ASSERT_FALSE(board_clear_trip()); // still active
    fake_set_break(false);
    board_write(&on); // gone, but latched
    TEST_ASSERT_FALSE(gates_on());
    TEST_ASSERT_TRUE(trip_in_next_call());
    TEST_ASSERT_TRUE(board_clear_trip());
    TEST_ASSERT_FALSE(trip_in_next_call());
    board_write(&on);
    TEST_ASSERT_TRUE(gates_on());
}

static void expect_system_break(void (*event)(void)) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    board_write(&(lode_drive_out_t){.gates = true});
    TEST_ASSERT_TRUE(gates_on());
    event();
    TEST_ASSERT_FALSE(gates_on());
    lode_counts_t counts;
    board_read(&counts);
    TEST_ASSERT_TRUE(counts.trip);
}

#ifdef VARIANT_BREAK2_PIN
static void pull_second_break(void) {
    if ((TIM1->BDTR & TIM_BDTR_BK2E) != 0u) {
        TIM1->SR |= TIM_SR_B2IF;
        TIM1->BDTR &= ~TIM_BDTR_MOE;
    }
}

static void test_second_break_input_switches_off(void) {
    expect_system_break(pull_second_break);
    board_write(&(lode_drive_out_t){.gates = true});
    TEST_ASSERT_FALSE(gates_on());
}
#endif

static void test_lost_clock_switches_off(void) {
    expect_system_break(fake_lose_clock);
    // Watched once it is in use, not before.
    TEST_ASSERT_TRUE(first(&RCC->CR, STM32_CLOCK_WATCH, STM32_CLOCK_WATCH) >
                     first(&RCC->CFGR, RCC_CFGR_SW, SWITCH_PLL));
}

#ifdef HAS_SYSTEM_BREAK
static void test_locked_up_core_switches_off(void) {
    expect_system_break(fake_lock_up);
    fake_reset();
    expect_system_break(fake_flash_error);
}
#endif

static void test_active_trip_at_power_up_is_a_failed_init(void) {
    fake_set_break(true);
    TEST_ASSERT_FALSE(board_init(TRIP_A));
}

// What a call writes acts from the next one on, in each half by itself: the high side is on at and above the value.
static void test_each_call_has_its_own_pulse(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    next_call();
    const uint32_t from = board_cycles();
    int upper = 0;
    for (int k = 0; k < COUNT_OF(duty_of_call); k++) {
        board_write(&(lode_drive_out_t){.duty = duty_of_call[k], .gates = LODE_GATES_ON});
        next_call();
        upper += stm32_pwm_counts_down() ? 1 : 0;
        TEST_ASSERT_EQUAL_UINT32(from + (uint32_t)(k + 1) * PERIOD, board_cycles());
        const float wanted[3] = {duty_of_call[k].a, duty_of_call[k].b, duty_of_call[k].c};
        for (int x = 0; x < 3; x++) {
            CHECK_NEAR(0.5 / STEPS, wanted[x], (double)(STEPS - acting[x]) / STEPS);
        }
    }
    TEST_ASSERT_EQUAL_INT(VARIANT_DOUBLE_UPDATE ? COUNT_OF(duty_of_call) / 2 : 0, upper);
}

// --- periods ---

#ifdef VARIANT_NTC_POINTS
#define COUNT_WARM 2048u // 25 degC
#else
#define COUNT_WARM 1000u
#endif

static void put_counts(float i_A) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    const float offset = config.sense.i_offset_count;
    const float gain = config.sense.i_gain_A_count;
    VARIANT_COUNT_A = (uint32_t)(offset + i_A / gain);
    VARIANT_COUNT_B = (uint32_t)(offset - 0.5f * i_A / gain);
    VARIANT_COUNT_C = (uint32_t)(offset - 0.5f * i_A / gain);
    VARIANT_COUNT_BUS = (uint32_t)(VARIANT_V_BUS_V / config.sense.v_bus_gain_V_count);
    VARIANT_COUNT_T = COUNT_WARM;
}

static void one_period(void) {
    next_call();
    STM32_PERIOD_HANDLER();
}

static void test_counts_come_from_the_right_registers(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    VARIANT_COUNT_A = 11u;
    VARIANT_COUNT_B = 22u;
    VARIANT_COUNT_C = 33u;
    VARIANT_COUNT_BUS = 44u;
    VARIANT_COUNT_T = COUNT_WARM;
    TIM2->CNT = 66u;
    lode_counts_t counts;
    board_read(&counts);
    TEST_ASSERT_EQUAL_UINT16(11u, counts.i[0]);
    TEST_ASSERT_EQUAL_UINT16(22u, counts.i[1]);
    TEST_ASSERT_EQUAL_UINT16(33u, counts.i[2]);
    TEST_ASSERT_EQUAL_UINT16(44u, counts.v_bus);
#ifdef VARIANT_NTC_POINTS
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    CHECK_NEAR(0.3, 25.0,
               (double)counts.temperature * (double)config.sense.temperature_gain_degC_count +
                   (double)config.sense.temperature_offset_degC);
#else
    TEST_ASSERT_EQUAL_UINT16(COUNT_WARM, counts.temperature);
#endif
    TEST_ASSERT_EQUAL_UINT32(66u, counts.stamp);
    TEST_ASSERT_EQUAL_UINT32(66u, board_cycles());
}

static void test_duties_become_compare_values(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    const lode_drive_out_t out = {.duty = {0.0f, 0.25f, 1.0f}, .gates = true};
    board_write(&out);
    TEST_ASSERT_EQUAL_UINT32(STEPS, TIM1->CCR1); // never on
    TEST_ASSERT_EQUAL_UINT32(STEPS - STEPS / 4u, TIM1->CCR2);
    TEST_ASSERT_EQUAL_UINT32(0u, TIM1->CCR3); // always on
    for (uint32_t k = 0; k <= STEPS; k++) {   // every step of the grid hits its own value
        const float duty = (float)k / (float)STEPS;
        board_write(&(lode_drive_out_t){.duty = {duty, duty, duty}});
        TEST_ASSERT_EQUAL_UINT32(STEPS - k, TIM1->CCR1);
    }
}

// A channel's two pins with the outputs enabled, by the manuals' table of output control bits for
// complementary channels (RM0440, RM0090), polarities 0, OSSR 1. `active`: the compare signal.
typedef struct {
    bool high, low;
} pins_t;

static pins_t pins_of(int channel, bool active) {
    const uint32_t enables = TIM1->CCER >> (4 * channel);
    const bool high_on = (enables & 1u) != 0u, low_on = (enables & 4u) != 0u;
    return (pins_t){.high = high_on && active, .low = low_on && (high_on ? !active : active)};
}

// At the counter's value. PWM mode 1 (6): active below the compare value; 2 (7): from it on.
static pins_t pins_at(int channel, uint32_t counter) {
    const uint32_t mode = channel == 0   ? TIM1->CCMR1 >> 4 & 7u
                          : channel == 1 ? TIM1->CCMR1 >> 12 & 7u
                                         : TIM1->CCMR2 >> 4 & 7u;
    const uint32_t compare = channel == 0 ? TIM1->CCR1 : channel == 1 ? TIM1->CCR2 : TIM1->CCR3;
    TEST_ASSERT_TRUE(mode == 6u || mode == 7u);
    return pins_of(channel, (counter < compare) == (mode == 6u));
}

static void expect_pins(uint32_t counter, bool high, bool low) {
    for (int channel = 0; channel < 3; channel++) {
        const pins_t pins = pins_at(channel, counter);
        TEST_ASSERT_EQUAL_INT(high, pins.high);
        TEST_ASSERT_EQUAL_INT(low && VARIANT_LOW_SIDES, pins.low);
    }
}

static void test_low_sides_alone(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    const lode_abc_t duty = {0.8f, 0.8f, 0.8f};
    const uint32_t compare = (uint32_t)(0.2f * (float)STEPS + 0.5f);
    board_write(&(lode_drive_out_t){.duty = duty, .gates = LODE_GATES_ON});
    expect_pins(compare - 1u, false, true);
    expect_pins(compare, true, false);
    const int from = fake_count();
    board_write(&(lode_drive_out_t){.duty = duty, .gates = LODE_GATES_LOW});
    TEST_ASSERT_EQUAL_INT(VARIANT_LOW_SIDES, gates_on());
#ifdef VARIANT_ENABLE_PINS
    // The driver makes the low sides itself: all off is all it can do.
    static const stm32_pin_t enables[] = {VARIANT_ENABLE_PINS};
    TEST_ASSERT_EQUAL_HEX32(0u, enables[0].port->ODR & (1u << enables[0].pin));
    (void)from;
#else
    expect_pins(0u, false, true);
    expect_pins(compare - 1u, false, true);
    expect_pins(compare, false, false);
    expect_pins(STEPS, false, false);
    // All off while the outputs change, on again last.
    const int off = fake_first(&TIM1->BDTR, TIM_BDTR_MOE, 0u, from);
    const int fewer = fake_first(&TIM1->CCER, TIM_CCER_CC1E, 0u, from);
    const int mode = fake_first(&TIM1->CCMR2, TIM_CCMR2_OC3M_0, 0u, from);
    const int on = fake_first(&TIM1->BDTR, TIM_BDTR_MOE, TIM_BDTR_MOE, from);
    TEST_ASSERT_TRUE(off >= from && fewer > off && mode > off && on > fewer && on > mode);
    TEST_ASSERT_EQUAL_HEX32(0x68u, TIM1->CCMR2); // still preloaded
    TEST_ASSERT_EQUAL_HEX32(0x6868u, TIM1->CCMR1);
    fake_set_break(true); // a trip counts here too
    fake_set_break(false);
    board_write(&(lode_drive_out_t){.duty = duty, .gates = LODE_GATES_LOW});
    TEST_ASSERT_FALSE(gates_on());
    TEST_ASSERT_TRUE(board_clear_trip());
#endif
    board_write(&(lode_drive_out_t){.duty = duty, .gates = LODE_GATES_OFF});
    TEST_ASSERT_FALSE(gates_on());
    board_write(&(lode_drive_out_t){.duty = duty, .gates = LODE_GATES_ON});
    TEST_ASSERT_TRUE(gates_on());
    expect_pins(compare - 1u, false, true);
    expect_pins(compare, true, false);
}

static void run_until_gates_on(void) {
    for (int n = 0; n < 60000 && !gates_on(); n++) {
        one_period();
        app_poll();
    }
    TEST_ASSERT_TRUE(gates_on());
}

// Into a commissioning mode with the gates on.
static void gates_on_by_the_drive(void) {
    TEST_ASSERT_TRUE(app_start());
    put_counts(0.0f);
    app_mode = BRINGUP_SIGNS;
    app_armed = 1u;
    run_until_gates_on();
    // Past the low sides alone, and without a fault they stay on.
    for (uint32_t n = 0; n < (uint32_t)(VARIANT_PRECHARGE_s * (float)PORT_F_CALL_Hz) + 4u; n++) {
        one_period();
    }
    TEST_ASSERT_TRUE(gates_on());
}

static void test_bootstrap_capacitors_are_charged_first(void) {
    TEST_ASSERT_TRUE(app_start());
    put_counts(0.0f);
    app_mode = BRINGUP_SIGNS;
    app_armed = 1u;
    run_until_gates_on();
    const uint32_t high_sides = TIM_CCER_CC1E | TIM_CCER_CC2E | TIM_CCER_CC3E;
    int periods = 0;
    while ((TIM1->CCER & high_sides) == 0u && periods < 30000) {
        TEST_ASSERT_TRUE(gates_on());
        one_period();
        periods++;
    }
    CHECK_NEAR(1.5, (double)VARIANT_PRECHARGE_s * PORT_F_CALL_Hz, periods);
    TEST_ASSERT_EQUAL_HEX32(high_sides, TIM1->CCER & high_sides);
}

static void expect_gates_off_in_one_period(void) {
    const int from = fake_count();
    one_period();
    TEST_ASSERT_FALSE(gates_on());
    const int off = fake_first(&TIM1->BDTR, TIM_BDTR_MOE, 0u, from);
    const int compare = fake_first(&TIM1->CCR1, 0u, 0u, from);
    TEST_ASSERT_TRUE(off >= from);
    TEST_ASSERT_TRUE(compare > off); // before anything else is written
#ifdef VARIANT_ENABLE_PINS
    static const stm32_pin_t enables[] = {VARIANT_ENABLE_PINS};
    for (int n = 0; n < COUNT_OF(enables); n++) {
        const uint32_t low = 1u << (enables[n].pin + 16u);
        const int lowered = fake_first(&enables[n].port->BSRR, low, low, from);
        TEST_ASSERT_TRUE(lowered >= from && lowered < off); // the phase floats at once
        TEST_ASSERT_EQUAL_HEX32(0u, enables[n].port->ODR & (1u << enables[n].pin));
    }
#endif
}

static void test_over_current_reaches_the_gates_in_the_same_period(void) {
    gates_on_by_the_drive();
    put_counts(1.45f * lode_min(VARIANT_I_MAX_A, 5.0f)); // inside, then outside of 1.5 i_max
    one_period();
    TEST_ASSERT_TRUE(gates_on());
    put_counts(1.6f * lode_min(VARIANT_I_MAX_A, 5.0f));
    expect_gates_off_in_one_period();
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OVER_CURRENT",
                             lode_check_name((lode_check_t)app_telemetry().fault.check));
}

#ifdef VARIANT_NTC_POINTS
// Of an NTC to ground, by the points themselves.
static void put_temperature(float degC) {
    static const float points[][2] = {VARIANT_NTC_POINTS};
    for (int n = 1; n < COUNT_OF(points); n++) {
        if (points[n][0] >= degC) {
            const float part = (degC - points[n - 1][0]) / (points[n][0] - points[n - 1][0]);
            const float R_Ohm = points[n - 1][1] * powf(points[n][1] / points[n - 1][1], part);
            VARIANT_COUNT_T =
                (uint32_t)(R_Ohm / (R_Ohm + VARIANT_NTC_FIXED_Ohm) * VARIANT_COUNTS + 0.5f);
            return;
        }
    }
    TEST_FAIL_MESSAGE("beyond the table");
}

static void test_missing_sensor_is_too_hot(void) {
    gates_on_by_the_drive();
    VARIANT_COUNT_T = 4095u; // pulled up
    for (uint32_t n = 0; n < PORT_F_CALL_Hz / 100u; n++) {
        one_period();
    }
    TEST_ASSERT_FALSE(gates_on());
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OVER_TEMPERATURE",
                             lode_check_name((lode_check_t)app_telemetry().fault.check));
}
#else
static void put_temperature(float degC) {
    const float volts = VARIANT_T_V + (degC - VARIANT_T_degC) * VARIANT_T_V_degC;
    VARIANT_COUNT_T = (uint32_t)(volts / VARIANT_V_REF_V * VARIANT_COUNTS + 0.5f);
}
#endif

static void test_over_temperature_switches_off(void) {
    gates_on_by_the_drive();
    put_temperature(VARIANT_T_MAX_degC - 2.0f);
    for (uint32_t n = 0; n < PORT_F_CALL_Hz / 100u; n++) {
        one_period();
    }
    TEST_ASSERT_TRUE(gates_on());
    put_temperature(VARIANT_T_MAX_degC + 2.0f);
    for (uint32_t n = 0; n < PORT_F_CALL_Hz / 100u; n++) {
        one_period();
    }
    TEST_ASSERT_FALSE(gates_on());
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OVER_TEMPERATURE",
                             lode_check_name((lode_check_t)app_telemetry().fault.check));
}

static void test_hardware_trip_is_a_fault_in_the_same_period(void) {
    gates_on_by_the_drive();
    fake_set_break(true);
    fake_set_break(false);
    expect_gates_off_in_one_period();
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_HARDWARE_TRIP",
                             lode_check_name((lode_check_t)app_telemetry().fault.check));
}

static void test_missed_interrupt_is_a_fault(void) {
    gates_on_by_the_drive();
    TIM2->CNT += PERIOD; // one period without a call
    expect_gates_off_in_one_period();
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_TIMING",
                             lode_check_name((lode_check_t)app_telemetry().fault.check));
}

// RM0440 and RM0090, TIM1, "Debug mode": a stopped counter drives the outputs inactive, and they come back
// with it. The angle is that of before the halt.
static void test_gates_stay_off_after_a_halted_core(void) {
    gates_on_by_the_drive();
    TEST_ASSERT_TRUE(fake_halt(100u * PERIOD));
    TEST_ASSERT_FALSE(gates_on()); // before the core goes on
    TEST_ASSERT_TRUE(fake_watchdog_waits());
    expect_gates_off_in_one_period();
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_TIMING",
                             lode_check_name((lode_check_t)app_telemetry().fault.check));
}

static void test_missing_interrupt_switches_off_by_hardware(void) {
    gates_on_by_the_drive();
    for (int n = 0; n < 10; n++) {
        next_call();
        TEST_ASSERT_TRUE(gates_on()); // each interrupt moves the deadline on
        STM32_PERIOD_HANDLER();
    }
    (void)fake_halt(PERIOD); // it may be late
    TEST_ASSERT_TRUE(gates_on());
    (void)fake_halt(PERIOD);
    TEST_ASSERT_FALSE(gates_on());
}

// The trip is gone after one period, and time goes by: without a person the gates stay off.
static void test_fault_is_not_restarted(void) {
    TEST_ASSERT_TRUE(app_start());
    put_counts(0.0f);
    app_mode = APP_MODE_APPLICATION;
    app_armed = 1u;
    run_until_gates_on();
    fake_set_break(true);
    fake_set_break(false);
    for (uint32_t n = 0; n < 3u * PORT_F_CALL_Hz; n++) {
        one_period();
        app_poll();
        TEST_ASSERT_FALSE(gates_on());
    }
    TEST_ASSERT_EQUAL_UINT32(0u, app_armed);
    app_armed = 1u;
    run_until_gates_on();
}

static void test_flag_is_cleared_before_the_period(void) {
    TEST_ASSERT_TRUE(app_start());
    const int from = fake_count();
    one_period();
#ifdef HAS_SYSTEM_BREAK
    TEST_ASSERT_EQUAL_INT(from, fake_first(&ADC1->ISR, ADC_ISR_JEOS, ADC_ISR_JEOS, from));
#else
    TEST_ASSERT_EQUAL_INT(from, fake_first(&ADC1->SR, ADC_SR_JEOC, 0u, from));
#endif
}

static void test_gates_off_from_anywhere(void) {
    board_gates_off(); // before board_init()
    TEST_ASSERT_FALSE(gates_on());
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_write(&(lode_drive_out_t){.gates = true});
    TEST_ASSERT_TRUE(gates_on());
    board_gates_off();
    TEST_ASSERT_FALSE(gates_on());
}

// --- supervision and serial port ---

static void test_watchdog_is_started_last_and_fed_by_steps(void) {
    TEST_ASSERT_TRUE(app_start());
    const int started = first(&IWDG->KR, ~0u, 0xCCCCu);
    const int unlocked = first(&IWDG->KR, ~0u, 0x5555u);
    TEST_ASSERT_TRUE(started < unlocked && unlocked < first(&IWDG->RLR, 0u, 0u));
    TEST_ASSERT_TRUE(started > first(&TIM1->BDTR, BDTR_LOCK, TIM_BDTR_LOCK_1));
    put_counts(0.0f);
    app_mode = APP_MODE_OFF;
    one_period();
    int from = fake_count();
    app_poll();
    TEST_ASSERT_TRUE(fake_first(&IWDG->KR, ~0u, 0xAAAAu, from) >= from);
    from = fake_count();
    app_poll(); // no period since
    TEST_ASSERT_EQUAL_INT(-1, fake_first(&IWDG->KR, ~0u, 0xAAAAu, from));
}

static void expect_report_of_a_failed_init(uint32_t f_serial_Hz) {
    TEST_ASSERT_FALSE(app_start());
    for (int n = 0; n < 10; n++) {
        app_poll();
    }
    TEST_ASSERT_NOT_NULL(strstr(fake_serial_text(), "START FAIL BOARD 0\r\n"));
    TEST_ASSERT_EQUAL_UINT32((f_serial_Hz + 57600u) / 115200u, SERIAL_PORT->BRR);
    TEST_ASSERT_EQUAL_INT(-1, fake_first(&IWDG->KR, ~0u, 0xCCCCu, 0)); // nor reset for ever
}

static void test_failed_init_is_reported_and_stops(void) {
    fake_set_break(true);
    expect_report_of_a_failed_init(CHIP_F_SERIAL_Hz);
    fake_reset();
    fake_kill_clock();
    expect_report_of_a_failed_init(F_RC_Hz); // by the oscillator that is there after a reset
}

#ifdef FAKE_H7
// Its ADC clock is not halved, and would be too fast.
static void test_revision_y_is_refused(void) {
    DBGMCU->IDCODE = 0x10036450u;
    TEST_ASSERT_FALSE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(&ADC1->CR, ADC_CR_ADEN, ADC_CR_ADEN, 0));
}
#endif

static void test_cause_of_a_reset(void) {
    TEST_ASSERT_FALSE(board_reset_by_watchdog());
    STM32_RESET_CAUSE = 1u << (WATCHDOG_FLAG);
    TEST_ASSERT_TRUE(board_reset_by_watchdog());
    TEST_ASSERT_FALSE(board_reset_by_watchdog()); // cleared: the next reset speaks for itself
}

static void test_serial_port_takes_what_it_has_room_for(void) {
    static const uint16_t octets[] = {'a', 'b', 'c', 'd'};
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    fake_serial_room(3u);
    TEST_ASSERT_EQUAL_UINT32(3u, board_send(octets, 4u));
    TEST_ASSERT_EQUAL_UINT32(0u, board_send(&octets[3], 1u));
    TEST_ASSERT_EQUAL_STRING("abc", fake_serial_text());
}

// At the upper turning point no low side is on.
static void test_double_update_with_low_side_shunts_is_refused(void) {
    TEST_ASSERT_FALSE(app_start());
    TEST_ASSERT_EQUAL_STRING("LODE_ERROR_DOUBLE_UPDATE", lode_status_name(app_status()));
    for (int n = 0; n < 10; n++) {
        app_poll();
    }
    TEST_ASSERT_NOT_NULL(strstr(fake_serial_text(), "START FAIL LODE_ERROR_DOUBLE_UPDATE 0\r\n"));
    TEST_ASSERT_EQUAL_INT(-1, fake_irq_enabled(18));
    TEST_ASSERT_FALSE(gates_on());
}

int main(void) {
    UNITY_BEGIN();
    if (VARIANT_DOUBLE_UPDATE &&
        (VARIANT_SENSING == PORT_LOW_SIDE_THREE || VARIANT_SENSING == PORT_LOW_SIDE_TWO)) {
        RUN_TEST(test_double_update_with_low_side_shunts_is_refused);
        return UNITY_END();
    }
    RUN_TEST(test_dead_time_code);
    RUN_TEST(test_period_in_steps);
    RUN_TEST(test_least_low_side_window);
    RUN_TEST(test_two_phases_can_always_be_sampled);
#ifdef BOARD_FIGURES_H
    RUN_TEST(test_figures_are_those_of_the_board);
#endif
    RUN_TEST(test_configuration_is_accepted);
    RUN_TEST(test_outputs_are_safe_before_the_pins_are_theirs);
    RUN_TEST(test_lock_holds_whatever_was_written_before);
    RUN_TEST(test_start_arms_then_counts_and_leaves_the_gates_off);
    RUN_TEST(test_timer_settings);
    RUN_TEST(test_trigger_is_the_update_and_nothing_hears_it_before_the_start);
    RUN_TEST(test_clock_that_does_not_come_keeps_everything_off);
    RUN_TEST(test_wait_states_before_the_faster_clock);
    RUN_TEST(test_break_input);
#ifdef VARIANT_INTERNAL_ANALOG
    RUN_TEST(test_comparators_and_their_threshold);
#endif
    RUN_TEST(test_trip_path_is_tested);
    RUN_TEST(test_latched_trip_keeps_the_gates_off);
#ifdef VARIANT_BREAK2_PIN
    RUN_TEST(test_second_break_input_switches_off);
#endif
    RUN_TEST(test_lost_clock_switches_off);
#ifdef HAS_SYSTEM_BREAK
    RUN_TEST(test_locked_up_core_switches_off);
#endif
    RUN_TEST(test_active_trip_at_power_up_is_a_failed_init);
    RUN_TEST(test_sample_at_the_wrong_end_is_a_trip);
    RUN_TEST(test_compare_value_that_does_not_stay_is_a_trip);
    RUN_TEST(test_each_call_has_its_own_pulse);
    RUN_TEST(test_counts_come_from_the_right_registers);
    RUN_TEST(test_duties_become_compare_values);
    RUN_TEST(test_over_current_reaches_the_gates_in_the_same_period);
    RUN_TEST(test_over_temperature_switches_off);
#ifdef VARIANT_NTC_POINTS
    RUN_TEST(test_missing_sensor_is_too_hot);
#endif
    RUN_TEST(test_hardware_trip_is_a_fault_in_the_same_period);
    RUN_TEST(test_missed_interrupt_is_a_fault);
    RUN_TEST(test_gates_stay_off_after_a_halted_core);
    RUN_TEST(test_missing_interrupt_switches_off_by_hardware);
    RUN_TEST(test_fault_is_not_restarted);
    RUN_TEST(test_flag_is_cleared_before_the_period);
    RUN_TEST(test_low_sides_alone);
    RUN_TEST(test_bootstrap_capacitors_are_charged_first);
    RUN_TEST(test_gates_off_from_anywhere);
    RUN_TEST(test_watchdog_is_started_last_and_fed_by_steps);
    RUN_TEST(test_failed_init_is_reported_and_stops);
#ifdef FAKE_H7
    RUN_TEST(test_revision_y_is_refused);
#endif
    RUN_TEST(test_cause_of_a_reset);
    RUN_TEST(test_serial_port_takes_what_it_has_room_for);
    return UNITY_END();
}
