// The RP2350 port on recorded registers: which one, with which value, in which order; and the ways by which
// the gates go off, from the driver's latch, the deadline or the clock to its enable. Built once per number
// of sensors.
#include "app.h"
#include "board.h"
#include "chip.h"
#include "rp2350_fake.h"
#include "support/check.h"

#define TRIP_A 1.0e3f

#define STEPS (CHIP_F_SYS_Hz / VARIANT_F_PWM_Hz / 2u)
#define PERIOD (2u * STEPS)
#define NO_CURRENT 2048u

void adc_fifo_handler(void);

static const uint32_t pwm[] = VARIANT_PWM_GPIOS;
static const lode_drive_out_t on = {.duty = {0.5f, 0.5f, 0.5f}, .gates = LODE_GATES_ON};

void setUp(void) {
    fake_reset();
}

void tearDown(void) {}

static int first(uint32_t address, uint32_t mask, uint32_t bits) {
    const int at = fake_first(address, mask, bits, 0);
    TEST_ASSERT_TRUE(at >= 0);
    return at;
}

static void put_counts(float i_A) {
    for (uint32_t n = 0u; n < CHIP_CURRENTS; n++) {
        const float i = n == 0u ? i_A : -0.5f * i_A;
        fake_set_input(n, (uint32_t)(VARIANT_I_OFFSET_count + i / VARIANT_I_GAIN_A_count));
    }
    fake_set_input(CHIP_CURRENTS, (uint32_t)(VARIANT_V_BUS_V / VARIANT_V_BUS_GAIN_V_count));
}

static void one_period(void) {
    fake_put(TIMER0_RAWL, fake_get(TIMER0_RAWL) + PERIOD);
    TEST_ASSERT_TRUE(fake_trigger());
    adc_fifo_handler();
}

static void up(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    put_counts(0.0f);
    one_period();
}

static lode_counts_t counts_now(void) {
    lode_counts_t counts;
    board_read(&counts);
    return counts;
}

// --- figures ---

static void test_configuration_is_accepted(void) {
    TEST_ASSERT_TRUE(app_start());
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(app_status()));
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    CHECK_CLOSE(1e-6, STEPS, config.inverter.pwm_ticks);
    CHECK_CLOSE(1e-6, PERIOD, config.guard.stamp_per_period);
    TEST_ASSERT_TRUE(config.sense.i_gain_A_count < 0.0f);
    // The first current is sampled before t_k: the amplifiers have settled by then.
    const double half_low_ns =
        0.5 * (1.0 - (double)config.sense.duty_max) * 1.0e9 / VARIANT_F_PWM_Hz;
    CHECK_AT_LEAST(0.9999 * (double)(VARIANT_SETTLE_ns + CHIP_SPREAD_ns), half_low_ns);
    TEST_ASSERT_TRUE(config.sense.duty_max > 0.8f);
}

// --- order of the initialisation ---

static void test_driver_is_held_off_before_its_inputs_switch(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    const uint32_t enable = 1u << VARIANT_ENABLE_GPIO;
    const int low = first(GPIO_OUT_CLR, enable, enable);
    TEST_ASSERT_EQUAL_INT(0, low); // before anything else
    const int driven = first(PAD(VARIANT_ENABLE_GPIO), ~0u, PAD_OUTPUT);
    TEST_ASSERT_TRUE(driven > first(PIN_CTRL(VARIANT_ENABLE_GPIO), ~0u, PIN_SIO));
    for (int n = 0; n < COUNT_OF(pwm); n++) {
        const int input = first(PAD(pwm[n]), ~0u, PAD_OUTPUT);
        TEST_ASSERT_TRUE(input > driven && input > first(PIN_CTRL(pwm[n]), ~0u, PIN_PWM));
        TEST_ASSERT_TRUE(fake_is_pwm(pwm[n]));
    }
    TEST_ASSERT_EQUAL_INT(-1, fake_first(GPIO_OUT_SET, enable, enable, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(PWM_EN, 0u, 0u, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(NVIC_ENABLE_1, 0u, 0u, 0));
    TEST_ASSERT_FALSE(fake_gates_on());
}

static void test_start_arms_then_counts_and_leaves_the_gates_off(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    const int counting = first(PWM_EN, ~0u, 0x307u); // three phases, trigger, deadline: one write
    TEST_ASSERT_TRUE(first(DMA_CTRL(0), 1u, 1u) < counting);
    TEST_ASSERT_TRUE(first(DMA_CTRL(1), 1u, 1u) < counting);
    TEST_ASSERT_TRUE(first(NVIC_ENABLE_1, ~0u, 1u << 3) < counting);  // 35
    TEST_ASSERT_TRUE(first(WATCHDOG_CTRL, ~0u, 1u << 30) < counting); // runs on in a halt too
    TEST_ASSERT_TRUE(first(WATCHDOG_LOAD, 0u, 0u) < first(WATCHDOG_CTRL, 0u, 0u));
    TEST_ASSERT_FALSE(fake_gates_on());
}

static void test_clock(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_UINT32(125u, fake_get(PLL_SYS + PLL_FBDIV)); // 12 MHz x 125 / 10
    TEST_ASSERT_EQUAL_HEX32(5u << 16 | 2u << 12, fake_get(PLL_SYS + PLL_PRIM));
    TEST_ASSERT_EQUAL_UINT32(100u, fake_get(PLL_USB + PLL_FBDIV)); // 12 MHz x 100 / 25
    TEST_ASSERT_EQUAL_HEX32(5u << 16 | 5u << 12, fake_get(PLL_USB + PLL_PRIM));
    TEST_ASSERT_EQUAL_UINT32(
        0u, fake_get(CLK_REF_CTRL)); // ring oscillator: the watchdog needs no crystal
    const int off_pll = first(CLK_SYS_CTRL, ~0u, 0x40u); // the auxiliary source as it was
    const int changed = first(CLK_SYS_CTRL, ~0u, 0u);
    const int on_pll = first(CLK_SYS_CTRL, ~0u, 1u);
    TEST_ASSERT_TRUE(off_pll < changed && changed < on_pll);
    TEST_ASSERT_TRUE(off_pll < first(PLL_SYS + PLL_PWR, 0u, 0u));
    TEST_ASSERT_TRUE(on_pll > first(PLL_SYS + PLL_PWR, ~0u, PLL_PWR_UP));
    TEST_ASSERT_EQUAL_UINT32(81u, fake_get(UART0_IBRD)); // 150 MHz/16/115200 = 81.38
    TEST_ASSERT_EQUAL_UINT32(24u, fake_get(UART0_FBRD));
}

static void test_crystal_that_does_not_come_is_reported_and_stops(void) {
    fake_kill_crystal();
    TEST_ASSERT_FALSE(app_start());
    for (int n = 0; n < 10; n++) {
        app_poll();
    }
    TEST_ASSERT_NOT_NULL(strstr(fake_serial_text(), "START FAIL BOARD 0\r\n"));
    TEST_ASSERT_EQUAL_UINT32(5u, fake_get(UART0_IBRD)); // by the ring oscillator, 11 MHz or so
    TEST_ASSERT_EQUAL_INT(-1, fake_first(PWM_EN, 0u, 0u, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(WATCHDOG_CTRL, 0u, 0u, 0)); // nor reset for ever
}

static void test_fault_at_power_up_is_a_failed_init(void) {
    fake_set_fault(true);
    TEST_ASSERT_FALSE(board_init(TRIP_A));
    TEST_ASSERT_FALSE(board_clear_trip());
    fake_set_fault(false);
    TEST_ASSERT_TRUE(board_clear_trip());
}

// --- PWM and samples ---

static void test_slices(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    for (uint32_t n = 0u; n < 3u; n++) {
        TEST_ASSERT_EQUAL_HEX32(6u, fake_get(PWM_CSR(n))); // up and down, output A inverted
        TEST_ASSERT_EQUAL_UINT32(STEPS - 1u, fake_get(PWM_TOP(n)));
        TEST_ASSERT_EQUAL_UINT32(0u, fake_get(PWM_CTR(n)));
        TEST_ASSERT_EQUAL_HEX32(16u, fake_get(PWM_DIV(n)));
    }
    // Sawtooths of one period, ahead, and of one and a half.
    TEST_ASSERT_EQUAL_UINT32(PERIOD - 1u, fake_get(PWM_TOP(8)));
    TEST_ASSERT_EQUAL_UINT32(CHIP_IS_TWO ? 225u : 375u, fake_get(PWM_CTR(8))); // 1.5 or 2.5 us
    TEST_ASSERT_EQUAL_UINT32(3u * STEPS - 1u, fake_get(PWM_TOP(9)));
    TEST_ASSERT_EQUAL_HEX32(0u, fake_get(PWM_CSR(8)) | fake_get(PWM_CSR(9)));
}

// Data sheet: the output is high while the compare value is above the counter, here inverted.
static void test_duties_become_compare_values(void) {
    up();
    board_write(&(lode_drive_out_t){.duty = {0.0f, 0.25f, 1.0f}, .gates = LODE_GATES_ON});
    TEST_ASSERT_EQUAL_UINT32(STEPS, fake_get(PWM_CC(0))); // above top: never on
    TEST_ASSERT_EQUAL_UINT32(STEPS - STEPS / 4u, fake_get(PWM_CC(1)));
    TEST_ASSERT_EQUAL_UINT32(0u, fake_get(PWM_CC(2))); // always on
    for (uint32_t k = 0; k <= STEPS; k++) {
        const float duty = (float)k / (float)STEPS;
        board_write(&(lode_drive_out_t){.duty = {duty, duty, duty}});
        TEST_ASSERT_EQUAL_UINT32(STEPS - k, fake_get(PWM_CC(0)));
    }
}

static void test_compare_value_that_does_not_stay_is_a_trip(void) {
    up();
    for (uint32_t n = 0u; n < 3u; n++) {
        board_write(&(lode_drive_out_t){.duty = {0.9f, 0.1f, 0.3f}, .gates = LODE_GATES_ON});
        TEST_ASSERT_FALSE(counts_now().trip);
        fake_put(PWM_CC(n), fake_get(PWM_CC(n)) ^ 1u);
        TEST_ASSERT_TRUE(counts_now().trip);
        board_write(&(lode_drive_out_t){.duty = {0.2f, 0.8f, 0.7f}, .gates = LODE_GATES_OFF});
        TEST_ASSERT_FALSE(counts_now().trip);
    }
}

static void test_samples_come_in_their_order(void) {
    up();
    for (uint32_t period = 0u; period < 3u;
         period++) { // the one too many does not shift the next round
        for (uint32_t n = 0u; n < 4u; n++) {
            fake_set_input(n, 1000u + 100u * n + period);
        }
        one_period();
        const lode_counts_t counts = counts_now();
        TEST_ASSERT_EQUAL_UINT16(1000u + period, counts.i[0]);
        TEST_ASSERT_EQUAL_UINT16(1100u + period, counts.i[1]);
        TEST_ASSERT_EQUAL_UINT16(CHIP_IS_TWO ? 0u : 1200u + period, counts.i[2]);
        TEST_ASSERT_EQUAL_UINT16(1000u + 100u * CHIP_CURRENTS + period, counts.v_bus);
        TEST_ASSERT_FALSE(counts.trip);
    }
    TEST_ASSERT_EQUAL_UINT32(fake_get(TIMER0_RAWL), counts_now().stamp);
    TEST_ASSERT_EQUAL_HEX32(ADC_CS_EN, fake_get(ADC_CS) & (ADC_CS_EN | ADC_CS_START_MANY));
    // Each input is the ADC's alone.
    for (uint32_t n = 0u; n < CHIP_SAMPLES; n++) {
        TEST_ASSERT_EQUAL_HEX32(PAD_ANALOG, fake_get(PAD(26u + n)));
    }
}

// The ripple in the zero vector, phase a ahead of t_k by half the spread, the last as much behind it.
static void test_samples_are_brought_to_tk(void) {
    TEST_ASSERT_TRUE(app_start()); // with the motor's inductance
    put_counts(0.0f);
    one_period();
    const lode_drive_out_t out = {.duty = {0.7f, 0.4f, 0.4f}, .gates = LODE_GATES_ON};
    board_write(&out);
    board_write(&out);
    TEST_ASSERT_TRUE(fake_trigger());
    uint16_t sample[CHIP_SAMPLES];
    TEST_ASSERT_TRUE(chip_adc_take(sample));
    const lode_counts_t counts = counts_now();
    const double winding_H = 0.6e-3, delay_s = (double)CHIP_SPREAD_ns * 1.0e-9;
    const double a_A =
        0.2 * VARIANT_V_BUS_V * delay_s / winding_H; // since then a has fallen by this
    const double last_A = 0.1 * VARIANT_V_BUS_V * delay_s / winding_H;
    const uint32_t last = CHIP_CURRENTS - 1u;
    CHECK_NEAR(0.7, NO_CURRENT - a_A / (double)VARIANT_I_GAIN_A_count, counts.i[0]);
    CHECK_NEAR(0.7, NO_CURRENT - last_A / (double)VARIANT_I_GAIN_A_count, counts.i[last]);
    TEST_ASSERT_TRUE(counts.i[0] != NO_CURRENT && counts.i[last] != NO_CURRENT);
}

static void test_missing_or_stale_samples_are_a_trip(void) {
    up();
    TEST_ASSERT_TRUE(fake_trigger());
    fake_put(ADC_CS, fake_get(ADC_CS) | ADC_CS_START_MANY);
    fake_halt(PERIOD); // nobody has stopped the ADC: it goes on until the FIFO runs over
    adc_fifo_handler();
    TEST_ASSERT_TRUE(counts_now().trip);
    one_period(); // nothing stale is left
    TEST_ASSERT_FALSE(counts_now().trip);
    adc_fifo_handler(); // without samples
    TEST_ASSERT_TRUE(counts_now().trip);
    one_period();
    TEST_ASSERT_FALSE(counts_now().trip);
}

// --- trip ---

static void test_fault_line_is_latched_until_it_is_cleared(void) {
    up();
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
    fake_set_fault(true);
    TEST_ASSERT_FALSE(fake_gates_on()); // by the driver, without code
    TEST_ASSERT_TRUE(counts_now().trip);
    TEST_ASSERT_FALSE(board_clear_trip()); // still there
    fake_set_fault(false);
    board_write(&on);
    TEST_ASSERT_FALSE(fake_gates_on());
    TEST_ASSERT_TRUE(counts_now().trip);
    TEST_ASSERT_TRUE(board_clear_trip()); // resets the driver's latch
    TEST_ASSERT_FALSE(counts_now().trip);
    TEST_ASSERT_FALSE(fake_gates_on());
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
}

// A driver that lets go of the line by itself has still been seen.
static void test_short_pulse_of_the_fault_line_is_kept(void) {
    up();
    board_write(&on);
    const uint32_t fell = PIN_EVENT_FELL(VARIANT_FAULT_GPIO);
    fake_put(PIN_EVENTS(VARIANT_FAULT_GPIO), fell);
    TEST_ASSERT_TRUE(counts_now().trip);
    board_write(&(lode_drive_out_t){.gates = LODE_GATES_OFF});
    board_write(&on);
    TEST_ASSERT_FALSE(fake_gates_on());
}

static void test_lost_clock_is_a_trip(void) {
    up();
    fake_put(PLL_SYS + PLL_INTR, PLL_INTR_LOCK_LOST);
    TEST_ASSERT_TRUE(counts_now().trip);
    TEST_ASSERT_TRUE(board_clear_trip());
    TEST_ASSERT_FALSE(counts_now().trip);
}

// The PWM runs on while a debugger holds the core; the deadline runs too, and takes the enable away.
static void test_missing_interrupt_switches_off_by_hardware(void) {
    up();
    board_write(&on);
    fake_halt(PERIOD); // it may be late
    TEST_ASSERT_TRUE(fake_gates_on());
    one_period();
    TEST_ASSERT_EQUAL_UINT32(0u, fake_get(PWM_CTR(CHIP_DEADLINE_SLICE)));
    board_write(&on);
    const uint32_t before = fake_get(TIMER0_RAWL);
    fake_halt(2u * PERIOD);
    TEST_ASSERT_FALSE(fake_gates_on()); // before the core goes on
    TEST_ASSERT_EQUAL_UINT32(2u * PERIOD, fake_get(TIMER0_RAWL) - before); // the stamp runs on
    TEST_ASSERT_TRUE(counts_now().trip);
    board_write(&on);
    TEST_ASSERT_FALSE(fake_gates_on());
    TEST_ASSERT_TRUE(board_clear_trip());
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
}

static void test_low_sides_alone_are_not_made(void) {
    up();
    board_write(&on);
    board_write(&(lode_drive_out_t){.duty = {0.8f, 0.8f, 0.8f}, .gates = LODE_GATES_LOW});
    TEST_ASSERT_FALSE(fake_gates_on());
    TEST_ASSERT_TRUE(board_test_trip());
}

// --- the drive on top ---

static void gates_on_by_the_drive(void) {
    TEST_ASSERT_TRUE(app_start());
    put_counts(0.0f);
    app_mode = BRINGUP_SIGNS;
    app_armed = 1u;
    for (int n = 0; n < 30000 && !fake_gates_on(); n++) {
        one_period();
        app_poll();
    }
    TEST_ASSERT_TRUE(fake_gates_on());
}

static void expect_gates_off_in_one_call(const char *check) {
    const uint32_t enable = 1u << VARIANT_ENABLE_GPIO;
    const int from = fake_count();
    one_period();
    TEST_ASSERT_FALSE(fake_gates_on());
    const int off = fake_first(GPIO_OUT_CLR, enable, enable, from);
    TEST_ASSERT_TRUE(off >= from && fake_first(PWM_CC(0), 0u, 0u, from) > off);
    TEST_ASSERT_EQUAL_STRING(check, lode_check_name((lode_check_t)app_telemetry().fault.check));
}

static void test_over_current_reaches_the_gates_in_the_same_call(void) {
    const float i_trip = 1.5f * VARIANT_I_MAX_A;
    gates_on_by_the_drive();
    put_counts(0.9f * i_trip); // a slope from nothing to there looks a little larger
    one_period();
    TEST_ASSERT_TRUE(fake_gates_on());
    put_counts(1.07f * i_trip);
    expect_gates_off_in_one_call("LODE_CHECK_OVER_CURRENT");
}

static void test_hardware_trip_is_a_fault_in_the_same_call(void) {
    gates_on_by_the_drive();
    one_period();
    fake_set_fault(true);
    fake_set_fault(false);
    expect_gates_off_in_one_call("LODE_CHECK_HARDWARE_TRIP");
}

static void test_missed_interrupt_is_a_fault(void) {
    gates_on_by_the_drive();
    fake_put(TIMER0_RAWL, fake_get(TIMER0_RAWL) + PERIOD);
    expect_gates_off_in_one_call("LODE_CHECK_TIMING");
}

static void test_gates_off_from_anywhere(void) {
    board_gates_off(); // before board_init()
    TEST_ASSERT_FALSE(fake_gates_on());
    up();
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
    board_gates_off();
    TEST_ASSERT_FALSE(fake_gates_on());
}

// --- supervision and serial port ---

static void test_watchdog(void) {
    TEST_ASSERT_TRUE(app_start());
    TEST_ASSERT_EQUAL_HEX32(0x01FFFFF3u, fake_get(PSM_WDSEL)); // the pads' block is among them
    put_counts(0.0f);
    app_mode = APP_MODE_OFF;
    one_period();
    int from = fake_count();
    app_poll();
    TEST_ASSERT_TRUE(fake_first(WATCHDOG_LOAD, ~0u, 20000u, from) >= from);
    from = fake_count();
    app_poll(); // no period since
    TEST_ASSERT_EQUAL_INT(-1, fake_first(WATCHDOG_LOAD, 0u, 0u, from));
    TEST_ASSERT_FALSE(board_reset_by_watchdog());
    fake_put(WATCHDOG_REASON, WATCHDOG_REASON_TIMER);
    TEST_ASSERT_TRUE(board_reset_by_watchdog());
}

static void test_serial_port(void) {
    static const uint16_t octets[] = {'a', 'b'};
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_UINT32(2u, board_send(octets, 2u));
    TEST_ASSERT_EQUAL_STRING("ab", fake_serial_text());
    fake_put(UART0_FR, UART_FR_TX_FULL);
    TEST_ASSERT_EQUAL_UINT32(0u, board_send(octets, 2u));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_configuration_is_accepted);
    RUN_TEST(test_driver_is_held_off_before_its_inputs_switch);
    RUN_TEST(test_start_arms_then_counts_and_leaves_the_gates_off);
    RUN_TEST(test_clock);
    RUN_TEST(test_crystal_that_does_not_come_is_reported_and_stops);
    RUN_TEST(test_fault_at_power_up_is_a_failed_init);
    RUN_TEST(test_slices);
    RUN_TEST(test_duties_become_compare_values);
    RUN_TEST(test_compare_value_that_does_not_stay_is_a_trip);
    RUN_TEST(test_samples_come_in_their_order);
    RUN_TEST(test_samples_are_brought_to_tk);
    RUN_TEST(test_missing_or_stale_samples_are_a_trip);
    RUN_TEST(test_fault_line_is_latched_until_it_is_cleared);
    RUN_TEST(test_short_pulse_of_the_fault_line_is_kept);
    RUN_TEST(test_lost_clock_is_a_trip);
    RUN_TEST(test_missing_interrupt_switches_off_by_hardware);
    RUN_TEST(test_low_sides_alone_are_not_made);
    RUN_TEST(test_over_current_reaches_the_gates_in_the_same_call);
    RUN_TEST(test_hardware_trip_is_a_fault_in_the_same_call);
    RUN_TEST(test_missed_interrupt_is_a_fault);
    RUN_TEST(test_gates_off_from_anywhere);
    RUN_TEST(test_watchdog);
    RUN_TEST(test_serial_port);
    return UNITY_END();
}
