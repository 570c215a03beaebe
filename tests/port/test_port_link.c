// One shunt in the DC link on the STM32G4: what its registers make of a period, edge by edge and trigger by
// trigger; what the link carries at those instants; and the three currents that the port hands out.
#include "app.h"
#include "board.h"
#include "chip.h"
#include "fake.h"
#include "figures.h"
#include "link.h"
#include "support/check.h"

#define TRIP_A 1.0e3f
#define STEPS (CHIP_F_PWM_Hz / VARIANT_F_PWM_Hz / 2u)
#define PERIOD (CHIP_F_STAMP_Hz / VARIANT_F_PWM_Hz)
#define F_PWM ((double)VARIANT_F_PWM_Hz)
#define ZERO 2048.0

void STM32_PERIOD_HANDLER(void);

// In place of the application: a drive that asks for what the test says.
static lode_drive_t drive;
static lode_drive_out_t wanted;
static lode_counts_t seen;
static lode_motor_t motor;

lode_motor_t app_motor(void) {
    return motor;
}

const lode_drive_t *app_drive(void) {
    return &drive;
}

void app_period(void) {
    board_read(&seen);
    board_write(&wanted);
}

// --- what the hardware makes of its registers ---

typedef struct {
    double rise[3], fall[3]; // as in lode_single_shunt_plan_t
    double sample[2];
} period_t;

static uint32_t halves[2][3]; // compare values that act up, and down
static bool trigger_dead;

static uint32_t compare_value(int x) {
    return x == 0 ? TIM1->CCR1 : x == 1 ? TIM1->CCR2 : TIM1->CCR3;
}

// TIM1_CH4's request comes while the counter runs down past CCR4: the DMA writes three compare values.
static void rising_edges_come_in(void) {
    const uint32_t on =
        DMA_CCR_EN | DMA_CCR_DIR | DMA_CCR_CIRC | DMA_CCR_MINC | DMA_CCR_PSIZE_1 | DMA_CCR_MSIZE_1;
    const bool ready = (TIM1->DIER & TIM_DIER_CC4DE) != 0u && DMAMUX1_Channel1->CCR == 45u &&
                       (DMA1_Channel2->CCR & on) == on && DMA1_Channel2->CNDTR == 3u &&
                       DMA1_Channel2->CPAR == (uint32_t)(uintptr_t)&TIM1->DMAR &&
                       DMA1_Channel2->CMAR == (uint32_t)(uintptr_t)chip_link_rise &&
                       TIM1->DCR == (13u | 2u << 8); // CCR1 is at 0x34
    TEST_ASSERT_TRUE(ready);
    // In time for the next period, and after the interrupt of this one.
    TEST_ASSERT_TRUE(TIM1->CCR4 > 50u && TIM1->CCR4 < STEPS / 10u);
    TIM1->CCR1 = chip_link_rise[0];
    TIM1->CCR2 = chip_link_rise[1];
    TIM1->CCR3 = chip_link_rise[2];
}

static bool is_high(const period_t *period, int x, double share) {
    return share > 0.5 * (1.0 - period->rise[x]) && share < 0.5 * (1.0 + period->fall[x]);
}

// Of the link at a share of the period: all legs that are high.
static uint32_t link_count(const period_t *period, const double i_A[3], double share) {
    double link_A = 0.0;
    for (int x = 0; x < 3; x++) {
        link_A += is_high(period, x, share) ? i_A[x] : 0.0;
    }
    return (uint32_t)floor(ZERO + link_A / (double)VARIANT_I_GAIN_A_count + 0.5);
}

// One period from t_k to the next interrupt; the duties in `wanted` act in the one after.
static period_t one_period(const double i_A[3]) {
    period_t period;
    for (int x = 0; x < 3; x++) { // taken over at t_k
        halves[0][x] = compare_value(x);
    }
    TIM1->CR1 &= ~TIM_CR1_DIR;
    TIM2->CNT += PERIOD;
    STM32_PERIOD_HANDLER();
    for (int x = 0; x < 3; x++) { // and at the upper turning point
        halves[1][x] = compare_value(x);
        period.rise[x] = 1.0 - (double)halves[0][x] / STEPS;
        period.fall[x] = 1.0 - (double)halves[1][x] / STEPS;
    }
    period.sample[0] = 1.0 - 0.5 * (double)TIM1->CCR5 / STEPS;
    period.sample[1] = 1.0 - 0.5 * (double)TIM1->CCR6 / STEPS;
    rising_edges_come_in();
    TEST_ASSERT_TRUE(period.sample[0] >= 0.4999 && period.sample[0] < period.sample[1]);
    TEST_ASSERT_TRUE((ADC1->CR & ADC_CR_JADSTART) != 0u);
    ADC1->JDR1 = link_count(&period, i_A, period.sample[0]);
    ADC1->JDR2 = link_count(&period, i_A, period.sample[1]);
    // An output that stays active has no edge, so there would be one trigger of two.
    TEST_ASSERT_TRUE(TIM1->CCR5 < TIM1->ARR && TIM1->CCR6 < TIM1->ARR && TIM1->CCR6 > 0u);
    ADC1->ISR |= trigger_dead ? 0u : ADC_ISR_JEOC | ADC_ISR_JEOS;
    return period;
}

void setUp(void) {
    fake_reset();
    drive = (lode_drive_t){.sense = {.offset = {(int32_t)ZERO * LODE_COUNT_FRACTION}}};
    motor = (lode_motor_t){.Ld_H = 0.0f}; // currents stand still: nothing to bring to t_k
    wanted = (lode_drive_out_t){.duty = {0.5f, 0.5f, 0.5f}};
    trigger_dead = false;
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
}

void tearDown(void) {}

static void expect_currents(const double i_A[3]) {
    for (int x = 0; x < 3; x++) {
        CHECK_NEAR(1.6, ZERO + i_A[x] / (double)VARIANT_I_GAIN_A_count, seen.i[x]);
    }
}

// --- tests ---

static void test_configuration(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    TEST_ASSERT_EQUAL_INT(LODE_SHUNTS_THREE, config.sense.shunts);
    CHECK_CLOSE(1e-6, 1.0, config.sense.duty_max);
    const double window_s = (double)(VARIANT_SETTLE_ns + CHIP_SAMPLE_ns) * 1.0e-9;
    CHECK_CLOSE(1e-5, fmin(0.95, (0.5 - window_s * F_PWM) / (sqrt(3.0) / 4.0)),
                config.current.voltage_use);
    config.motor = (lode_motor_t){.pole_pairs = 4.0f,
                                  .Rs_Ohm = 0.6f,
                                  .Ld_H = 0.6e-3f,
                                  .Lq_H = 0.6e-3f,
                                  .psi_Wb = 6.5e-3f,
                                  .J_kgm2 = 3.0e-5f};
    static lode_drive_t accepted;
    static lode_drive_tuning_t tuning;
    TEST_ASSERT_EQUAL_STRING("LODE_OK",
                             lode_status_name(lode_drive_init(&accepted, &tuning, &config)));
}

static void test_registers(void) {
    TEST_ASSERT_EQUAL_UINT32(0u, TIM1->RCR); // two updates per period
    TEST_ASSERT_EQUAL_HEX32(7u << 4 | 14u << 20, TIM1->CR2);
    TEST_ASSERT_EQUAL_HEX32(0x7878u, TIM1->CCMR1);
    TEST_ASSERT_EQUAL_HEX32(0x6878u, TIM1->CCMR2); // the fourth rises in the second half, preloaded
    TEST_ASSERT_EQUAL_HEX32(0x6868u, TIM1->CCMR3);
    // The link on TRGO2, one conversion per trigger; the bus on TRGO, and its end is the interrupt.
    TEST_ASSERT_EQUAL_HEX32(ADC_CFGR_JDISCEN, ADC1->CFGR);
    TEST_ASSERT_EQUAL_HEX32(1u | 8u << 2 | 1u << 7 | 2u << 9 | 2u << 15, ADC1->JSQR);
    TEST_ASSERT_EQUAL_HEX32(1u | 0u << 2 | 1u << 7 | 1u << 9 | 5u << 15, ADC2->JSQR);
    TEST_ASSERT_EQUAL_HEX32(ADC_IER_JEOSIE, ADC2->IER);
    TEST_ASSERT_EQUAL_HEX32(0u, ADC1->IER);
    TEST_ASSERT_EQUAL_UINT32(0u, ADC12_COMMON->CCR & 31u); // not a pair
    // All of it before the pins are the timer's.
    const int pins = fake_first(&GPIOA->MODER, 3u << 16, 2u << 16, 0);
    TEST_ASSERT_TRUE(fake_first(&TIM1->DCR, 0u, 0u, 0) < pins);
}

// Without current the counts are the link's own, so that the drive calibrates its offset.
static void test_offset_with_the_gates_off(void) {
    const double none[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++) {
        (void)one_period(none);
    }
    ADC1->JDR2 = 2100u;
    TIM2->CNT += PERIOD;
    ADC1->ISR |= ADC_ISR_JEOS;
    STM32_PERIOD_HANDLER();
    for (int x = 0; x < 3; x++) {
        TEST_ASSERT_EQUAL_UINT16(2100u, seen.i[x]);
    }
    TEST_ASSERT_FALSE(seen.trip);
}

// The mean of both halves is the duty, and the three currents come back, at every angle up to the limit.
static void test_currents_at_every_angle(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    const double limit = (double)config.current.voltage_use;
    const double i_A[3] = {5.0, -3.2, -1.8};
    wanted.gates = LODE_GATES_ON;
    int checked = 0;
    for (double use = 0.0; use <= limit; use += limit / 4.001) {
        for (int n = 0; n < 360; n += 3) {
            double v[3], low = 2.0, high = -2.0;
            for (int x = 0; x < 3; x++) {
                v[x] = use / sqrt(3.0) * cos((n + 0.7) * CHECK_DEG - x * 2.0 * CHECK_PI / 3.0);
                low = fmin(low, v[x]);
                high = fmax(high, v[x]);
            }
            const double common = 0.5 - 0.5 * (low + high);
            wanted.duty = (lode_abc_t){(float)(v[0] + common), (float)(v[1] + common),
                                       (float)(v[2] + common)};
            (void)one_period(i_A);                   // the duties are computed
            const period_t period = one_period(i_A); // they act
            for (int x = 0; x < 3; x++) {
                CHECK_NEAR(1.1 / STEPS, v[x] + common, 0.5 * (period.rise[x] + period.fall[x]));
            }
            (void)one_period(i_A); // they have been sampled
            expect_currents(i_A);
            TEST_ASSERT_FALSE(seen.trip);
            checked++;
        }
    }
    TEST_ASSERT_TRUE(checked >= 480);
}

// Legs at full or no duty leave no room, and no second current can be seen: the last counts stay.
static void test_blind_sector(void) {
    const double i_A[3] = {5.0, -3.2, -1.8}, other_A[3] = {-4.0, 1.0, 3.0};
    wanted = (lode_drive_out_t){.duty = {0.7f, 0.5f, 0.3f}, .gates = LODE_GATES_ON};
    for (int k = 0; k < 3; k++) {
        (void)one_period(i_A);
    }
    expect_currents(i_A);
    static const lode_abc_t blind[] = {
        {1.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 1.0f}, {1.0f, 0.0f, 0.0f}};
    wanted.duty = blind[0];
    (void)one_period(i_A); // the last one with its edges apart
    for (int k = 0; k < 2 * COUNT_OF(blind); k++) {
        wanted.duty = blind[k / 2];
        (void)one_period(other_A);
        expect_currents(i_A);
        TEST_ASSERT_FALSE(seen.trip);
    }
    wanted.duty = (lode_abc_t){0.7f, 0.5f, 0.3f};
    for (int k = 0; k < 3; k++) {
        (void)one_period(other_A);
    }
    expect_currents(other_A);
}

// With one trigger missed each sample would be taken for the other one from then on.
static void test_missed_trigger_is_a_trip_and_begins_anew(void) {
    const double i_A[3] = {5.0, -3.2, -1.8};
    wanted = (lode_drive_out_t){.duty = {0.7f, 0.5f, 0.3f}, .gates = LODE_GATES_ON};
    for (int k = 0; k < 3; k++) {
        (void)one_period(i_A);
    }
    TEST_ASSERT_FALSE(seen.trip);
    trigger_dead = true;
    (void)one_period(i_A);
    trigger_dead = false;
    const int from = fake_count();
    (void)one_period(i_A);
    TEST_ASSERT_TRUE(seen.trip);
    const int stopped = fake_first(&ADC1->CR, ADC_CR_JADSTP, ADC_CR_JADSTP, from);
    TEST_ASSERT_TRUE(stopped >= from);
    TEST_ASSERT_TRUE(fake_first(&ADC1->CR, ADC_CR_JADSTART, ADC_CR_JADSTART, stopped) > stopped);
    (void)one_period(i_A);
    TEST_ASSERT_FALSE(seen.trip);
}

// The rising edges that the DMA has written are not those of the plan.
static void test_edges_that_do_not_come_in_are_a_trip(void) {
    const double i_A[3] = {5.0, -3.2, -1.8};
    wanted = (lode_drive_out_t){.duty = {0.7f, 0.5f, 0.3f}, .gates = LODE_GATES_ON};
    volatile uint32_t *const compare[3] = {&TIM1->CCR1, &TIM1->CCR2, &TIM1->CCR3};
    ADC1->ISR |= ADC_ISR_JEOS; // the samples of the period before the first call
    for (int x = 0; x < 3; x++) {
        (void)one_period(i_A);
        TEST_ASSERT_FALSE(seen.trip);
        (void)one_period(i_A);
        TEST_ASSERT_FALSE(seen.trip);
        *compare[x] ^= 1u;
        (void)one_period(i_A);
        TEST_ASSERT_TRUE(seen.trip);
    }
}

static void test_low_sides_alone_and_off(void) {
    const double none[3] = {0.0, 0.0, 0.0};
    wanted = (lode_drive_out_t){.duty = {0.8f, 0.8f, 0.8f}, .gates = LODE_GATES_LOW};
    for (int k = 0; k < 3; k++) {
        (void)one_period(none);
    }
    TEST_ASSERT_TRUE((TIM1->BDTR & TIM_BDTR_MOE) != 0u);
    TEST_ASSERT_EQUAL_HEX32(0x444u, TIM1->CCER);
    TEST_ASSERT_EQUAL_HEX32(0x6868u, TIM1->CCMR1);
    TEST_ASSERT_EQUAL_HEX32(0x6868u, TIM1->CCMR2); // the trigger's channel is as it was
    TEST_ASSERT_EQUAL_UINT32(STEPS / 5u, TIM1->CCR1);
    wanted.gates = LODE_GATES_OFF;
    (void)one_period(none);
    TEST_ASSERT_TRUE((TIM1->BDTR & TIM_BDTR_MOE) == 0u);
}

static void test_window_that_does_not_fit_is_a_failed_init(void) {
    const lode_drive_config_t config = {.f_pwm_Hz = 100.0e3f,
                                        .sense = {.i_gain_A_count = VARIANT_I_GAIN_A_count}};
    lode_drive_config_t other = config;
    port_sensing(&other, PORT_LINK_ONE, VARIANT_SETTLE_ns, CHIP_SAMPLE_ns);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, other.start.pulses);
    TEST_ASSERT_TRUE(other.current.voltage_use <= 0.0f);
    motor.Ld_H = -1.0f; // no inductance
    motor.Lq_H = -1.0f;
    TEST_ASSERT_FALSE(board_init(TRIP_A));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_configuration);
    RUN_TEST(test_registers);
    RUN_TEST(test_offset_with_the_gates_off);
    RUN_TEST(test_currents_at_every_angle);
    RUN_TEST(test_blind_sector);
    RUN_TEST(test_missed_trigger_is_a_trip_and_begins_anew);
    RUN_TEST(test_edges_that_do_not_come_in_are_a_trip);
    RUN_TEST(test_low_sides_alone_and_off);
    RUN_TEST(test_window_that_does_not_fit_is_a_failed_init);
    return UNITY_END();
}
