// The AM263x port on recorded registers: what is written, with which value, and in which order; and the
// ways of a trip, which the fake follows from the comparator or the pin to the six outputs.
#include "am263x_fake.h"
#include "app.h"
#include "board.h"
#include "chip.h"
#include "support/check.h"

#define STEPS (CHIP_F_PWM_Hz / VARIANT_F_PWM_Hz / 2u)
#define PERIOD (CHIP_F_CPU_Hz / PORT_F_CALL_Hz)
#define HALF (CHIP_F_CPU_Hz / VARIANT_F_PWM_Hz / 2u)
#define SERIAL_TEXT (&fake_serial_text()[1]) // behind the divisor at its address
#define COUNT_A ADC_RESULT(0, 0)
#define COUNT_B ADC_RESULT(1, 0)
#define COUNT_C ADC_RESULT(2, 0)
#define COUNT_BUS ADC_RESULT(0, 1)

#define SOURCES 6 // three comparators, the fault line, a halted core, a lost clock
#define PUT_T(count) fake_put(ADC_RESULT(1, 1), (count))
#include "ti_cases.h"

void irq_handler(void);

static const uint32_t pads[] = VARIANT_PWM_PADS;
static const lode_drive_out_t on = {.duty = {0.5f, 0.5f, 0.5f}, .gates = true};
static uint32_t now_cycles;

void setUp(void) {
    fake_reset();
    now_cycles = 0u;
    counts_down = false;
}

void tearDown(void) {}

static int first(uint32_t address, uint32_t mask, uint32_t bits) {
    const int at = fake_first(address, mask, bits, 0);
    TEST_ASSERT_TRUE(at >= 0);
    return at;
}

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
    TEST_ASSERT_TRUE(config.sense.i_gain_A_count < 0.0f); // low-side shunts
    const double half_low_ns =
        0.5 * (1.0 - (double)config.sense.duty_max) * 1.0e9 / (double)VARIANT_F_PWM_Hz;
    CHECK_AT_LEAST(IN_LINE ? 0.0f : 0.9999f * lode_max(VARIANT_SETTLE_ns, CHIP_SAMPLE_ns),
                   half_low_ns);
}

// --- order of the initialisation ---

static void test_outputs_are_held_low_before_the_pins_are_theirs(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    const int stopped = first(CONTROLSS_CLKSYNC, 7u, 0u);
    for (int p = 0; p < 3; p++) {
        const int held = first(EPWM(p) + EPWM_TZFRC, TZFRC_OST, TZFRC_OST);
        const int locked = first(EPWM(p) + EPWM_LOCK, ~0u, 0xA5A50014u);
        TEST_ASSERT_TRUE(stopped < held && held < first(EPWM(p) + EPWM_TBPRD, ~0u, STEPS));
        TEST_ASSERT_TRUE(first(EPWM(p) + EPWM_TZCTL, 15u, 10u) < locked); // both low
        TEST_ASSERT_TRUE(first(EPWM(p) + EPWM_TZSEL, ~0u, 0xF000u) < locked);
        TEST_ASSERT_TRUE(first(EPWM(p) + EPWM_DBCTL, ~0u, 0x0Bu) < locked);
        for (int n = 0; n < COUNT_OF(pads); n++) {
            TEST_ASSERT_TRUE(first(IOMUX_PAD(pads[n]), ~0u, PAD_OUTPUT) > locked);
        }
    }
    TEST_ASSERT_TRUE(first(IOMUX_KICK1, ~0u, IOMUX_KICK1_UNLOCK) < first(IOMUX_PAD(49), 0u, 0u));
    TEST_ASSERT_FALSE(fake_gates_on());
    TEST_ASSERT_TRUE(fake_all_tripped());
}

static void test_trip_path_is_armed_before_the_pins_and_before_the_driver(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    const int pins = first(IOMUX_PAD(43), ~0u, PAD_OUTPUT);
    const int driver = first(GPIO_SET(VARIANT_ENABLE_GPIO), ~0u, 1u << (49 % 32));
    for (uint32_t n = 0u; n <= 4u; n += 2u) {
        const int threshold = first(CMPSSB(n) + CMPSS_DACHVALS, 0u, 0u);
        const int compares = first(CMPSSB(n) + CMPSS_COMPCTL, COMPCTL_ON, COMPCTL_ON);
        TEST_ASSERT_TRUE(threshold < compares && compares < first(PWMXBAR0_G1, 0u, 0u));
    }
    TEST_ASSERT_TRUE(first(PWMXBAR0_G1, ~0u, 0x333u) < pins); // CMPSSB 0, 2, 4: low and high
    TEST_ASSERT_TRUE(first(PWMXBAR1_G4, ~0u, 1u) < pins);
    TEST_ASSERT_EQUAL_HEX32(0x207u, fake_get(IOMUX_PAD(VARIANT_FAULT_GPIO))); // GPIO, pulled up
    TEST_ASSERT_TRUE(first(GPIO_CLEAR(49), ~0u, 1u << (49 % 32)) < pins && pins < driver);
    for (int p = 0; p < 3; p++) {
        TEST_ASSERT_EQUAL_INT(-1, fake_first(EPWM(p) + EPWM_TZCLR, 0u, 0u, 0));
        // TRIPIN1 as DCAH, TRIPIN2 as DCBH; event A1 while high, B1 while low; neither waits for a clock.
        TEST_ASSERT_EQUAL_HEX32(0x0100u, fake_get(EPWM(p) + EPWM_DCTRIPSEL));
        TEST_ASSERT_EQUAL_HEX32(0x0042u, fake_get(EPWM(p) + EPWM_TZDCSEL));
        TEST_ASSERT_EQUAL_HEX32(0x0002u, fake_get(EPWM(p) + EPWM_DCACTL));
        TEST_ASSERT_EQUAL_HEX32(0x0002u, fake_get(EPWM(p) + EPWM_DCBCTL));
    }
}

static void test_start_enables_the_interrupt_then_counts_and_leaves_the_gates_off(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_INT(-1, fake_interrupts_on());
    TEST_ASSERT_EQUAL_INT(-1, fake_first(VIM_ENABLE(146), 0u, 0u, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(CONTROLSS_CLKSYNC, 7u, 7u, 0));
    board_start();
    const int counting = first(CONTROLSS_CLKSYNC, 7u, 7u);              // all three with one write
    const int enabled = first(0x50F00488u, ~0u, 1u << 18);              // 146 is bit 18 of group 4
    TEST_ASSERT_TRUE(first(0x50F0049Cu, 1u << 18, 1u << 18) < enabled); // a pulse
    TEST_ASSERT_TRUE(enabled < counting);
    TEST_ASSERT_TRUE(fake_interrupts_on() > enabled && fake_interrupts_on() < counting);
    TEST_ASSERT_FALSE(fake_gates_on());
}

static void test_pwm_that_does_not_answer_keeps_everything_off(void) {
    fake_gate_clock();
    TEST_ASSERT_FALSE(app_start());
    TEST_ASSERT_EQUAL_INT(-1, fake_first(IOMUX_PAD(43), 0u, 0u, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(GPIO_SET(49), 0u, 0u, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_interrupts_on());
}

// --- timer, dead-band, trigger ---

static void test_counters_and_dead_band(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    for (int p = 0; p < 3; p++) {
        const uint32_t base = EPWM(p);
        TEST_ASSERT_EQUAL_HEX32(0x800Au, fake_get(base + EPWM_TBCTL)); // up-down, 200 MHz
        TEST_ASSERT_EQUAL_UINT32(5000u, fake_get(base + EPWM_TBPRD));
        // Shadow, at zero; or at period, too.
        TEST_ASSERT_EQUAL_UINT32(VARIANT_DOUBLE_UPDATE ? 2u : 0u, fake_get(base + EPWM_CMPCTL));
        TEST_ASSERT_EQUAL_HEX32(0x60u, fake_get(base + EPWM_AQCTLA)); // on around the top
        TEST_ASSERT_EQUAL_UINT32(60u, fake_get(base + EPWM_DBRED));   // 300 ns of 5 ns
        TEST_ASSERT_EQUAL_UINT32(60u, fake_get(base + EPWM_DBFED));
        TEST_ASSERT_EQUAL_UINT32(2500u, fake_get(base + EPWM_CMPA)); // no voltage
    }
}

// At zero all low sides are on: the middle of the zero vector, where the shunts carry the currents.
static void test_adcs_are_triggered_at_zero_of_every_period(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_HEX32(VARIANT_DOUBLE_UPDATE ? 0x0B00u : 0x0900u,
                            fake_get(EPWM(0) + EPWM_ETSEL));
    TEST_ASSERT_EQUAL_HEX32(0x0100u, fake_get(EPWM(0) + EPWM_ETPS));
    for (int n = 0; n < 3; n++) { // the same trigger, first in each: one instant
        const uint32_t soc = fake_get(ADC(n) + ADC_SOC(0));
        TEST_ASSERT_EQUAL_UINT32(8u, soc >> 20);       // EPWM0_SOCA
        TEST_ASSERT_EQUAL_UINT32(4u, soc >> 15 & 31u); // AIN4
        TEST_ASSERT_EQUAL_UINT32(CHIP_WINDOW_cycles - 1u, soc & 511u);
        TEST_ASSERT_EQUAL_HEX32(0x84u, fake_get(ADC(n) + ADC_CTL1));
    }
    TEST_ASSERT_EQUAL_UINT32(8u, fake_get(ADC(0) + ADC_SOC(1)) >> 20);
    TEST_ASSERT_EQUAL_UINT32(8u, fake_get(ADC(1) + ADC_SOC(1)) >> 20); // temperature
    TEST_ASSERT_EQUAL_UINT32(0u, fake_get(ADC(1) + ADC_SOC(1)) >> 15 & 31u);
    // The interrupt comes with the last of all results.
    TEST_ASSERT_EQUAL_HEX32(0x21u, fake_get(ADC(0) + ADC_INTSEL1N2));
    TEST_ASSERT_EQUAL_HEX32(1u, fake_get(INTXBAR0_G2));
}

static void test_duties_become_compare_values(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_write(&(lode_drive_out_t){.duty = {0.0f, 0.25f, 1.0f}});
    TEST_ASSERT_EQUAL_UINT32(VARIANT_DOUBLE_UPDATE ? STEPS - 1u : STEPS,
                             fake_get(EPWM(0) + EPWM_CMPA));
    TEST_ASSERT_EQUAL_UINT32(STEPS - STEPS / 4u, fake_get(EPWM(1) + EPWM_CMPA));
    TEST_ASSERT_EQUAL_UINT32(1u, fake_get(EPWM(2) + EPWM_CMPA));
}

// --- trip ---

static void test_thresholds_on_both_sides(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    for (uint32_t n = 0u; n <= 4u; n += 2u) {
        const float volt = VARIANT_V_DAC_V / 4096.0f, ohm = VARIANT_SHUNT_Ohm * VARIANT_AMPLIFIER;
        const float high = (float)fake_get(CMPSSB(n) + CMPSS_DACHVALS) * volt;
        const float low = (float)fake_get(CMPSSB(n) + CMPSS_DACLVALS) * volt;
        CHECK_NEAR(0.02, VARIANT_TRIP_MAX_A, (high - VARIANT_BIAS_V) / ohm);
        CHECK_NEAR(0.02, -VARIANT_TRIP_MAX_A, (low - VARIANT_BIAS_V) / ohm);
        TEST_ASSERT_EQUAL_HEX32(0xAA28u, fake_get(CMPSSB(n) + CMPSS_COMPCTL));
        TEST_ASSERT_EQUAL_HEX32(0x8000u | 7u << 9 | 9u << 4, fake_get(CMPSSB(n) + CMPSS_LFILCTL));
    }
}

static void set_source(int n, bool active) {
    if (n < 3) {
        fake_set_comparator(2u * (uint32_t)n, active);
    } else if (n == 3) {
        fake_set_fault(active);
    } else if (n == 4) {
        fake_set_halted(active);
    } else {
        fake_set_clock_lost(active);
    }
}

static void test_every_source_switches_all_six_off_and_latches(void) {
    for (int n = 0; n < SOURCES; n++) {
        fake_reset();
        TEST_ASSERT_TRUE(board_init(TRIP_A));
        board_start();
        board_write(&on);
        TEST_ASSERT_TRUE(fake_gates_on()); // without a source nothing trips
        TEST_ASSERT_FALSE(trip_in_next_call());
        set_source(n, true);
        TEST_ASSERT_TRUE(fake_all_tripped());
        TEST_ASSERT_TRUE(trip_in_next_call());
        TEST_ASSERT_FALSE(board_clear_trip()); // still active
        set_source(n, false);
        const int from = fake_count();
        board_write(&on); // gone, but latched: not even tried
        TEST_ASSERT_TRUE(fake_all_tripped());
        TEST_ASSERT_EQUAL_INT(-1, fake_first(EPWM(0) + EPWM_TZCLR, 0u, 0u, from));
        TEST_ASSERT_TRUE(board_clear_trip());
        TEST_ASSERT_TRUE(fake_all_tripped()); // cleared is not on
        board_write(&on);
        TEST_ASSERT_TRUE(fake_gates_on());
    }
}

// An ePWM's two outputs while no trip holds them: by the dead-band, which makes B the complement of A, or
// past it, where A is forced and B has actions of its own.
static void expect_outputs(uint32_t base, bool below, bool a, bool b) {
    const uint32_t band = fake_get(base + EPWM_DBCTL);
    TEST_ASSERT_TRUE(band == 0x0Bu || band == 0u);
    TEST_ASSERT_EQUAL_HEX32(0x90u, fake_get(base + EPWM_AQCTLB)); // on around zero
    TEST_ASSERT_EQUAL_HEX32(0xC0u, fake_get(base + EPWM_AQSFRC)); // forced at once
    const bool input_a = !below && fake_get(base + EPWM_AQCSFRC) == 0u;
    TEST_ASSERT_EQUAL_INT(a, input_a);
    TEST_ASSERT_EQUAL_INT(b, band != 0u ? !input_a : below);
}

static void test_low_sides_alone(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    board_write(&on);
    for (int p = 0; p < 3; p++) {
        expect_outputs(EPWM(p), true, false, true);
        expect_outputs(EPWM(p), false, true, false);
    }
    const int from = fake_count();
    const lode_drive_out_t low = {.duty = {0.8f, 0.8f, 0.8f}, .gates = LODE_GATES_LOW};
    board_write(&low);
    TEST_ASSERT_TRUE(fake_gates_on());
    for (int p = 0; p < 3; p++) {
        const uint32_t base = EPWM(p);
        expect_outputs(base, true, false, true);
        expect_outputs(base, false, false, false);
        // All off while the outputs change, A low before the dead-band lets it through.
        const int off = fake_first(base + EPWM_TZFRC, TZFRC_OST, TZFRC_OST, from);
        const int forced = fake_first(base + EPWM_AQCSFRC, ~0u, 1u, from);
        const int past = fake_first(base + EPWM_DBCTL, ~0u, 0u, from);
        const int cleared = fake_first(base + EPWM_TZCLR, TZFLG_OST, TZFLG_OST, from);
        TEST_ASSERT_TRUE(off >= from && forced > off && past > forced && cleared > past);
    }
    const int again = fake_count();
    board_write(&low); // steady: nothing goes off in between
    TEST_ASSERT_EQUAL_INT(-1, fake_first(EPWM(0) + EPWM_TZFRC, 0u, 0u, again));
    set_source(0, true); // a trip counts here too
    set_source(0, false);
    board_write(&low);
    TEST_ASSERT_TRUE(fake_all_tripped());
    TEST_ASSERT_TRUE(board_clear_trip());
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
    expect_outputs(EPWM(0), false, true, false);
}

static void test_trip_path_is_tested(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
    const int from = fake_count();
    TEST_ASSERT_TRUE(board_test_trip());
    TEST_ASSERT_TRUE(fake_all_tripped()); // off, by itself before the first threshold moves
    const int off = fake_first(EPWM(2) + EPWM_TZFRC, TZFRC_OST, TZFRC_OST, from);
    const int moved = fake_first(CMPSSB(0) + CMPSS_DACHVALS, ~0u, 0u, from);
    TEST_ASSERT_TRUE(off >= from && moved > off);
    lode_counts_t counts;
    board_read(&counts);
    TEST_ASSERT_FALSE(counts.trip);     // leaves no trip behind
    for (uint32_t n = 0; n < 6u; n++) { // each sign of each phase
        fake_reset();
        TEST_ASSERT_TRUE(board_init(TRIP_A));
        fake_kill_comparator(2u * (n / 2u), n % 2u == 0u);
        TEST_ASSERT_FALSE(board_test_trip());
    }
}

static void test_threshold_follows_the_motor(void) {
    TEST_ASSERT_TRUE(board_init(5.0f));
    const float ohm = VARIANT_SHUNT_Ohm * VARIANT_AMPLIFIER;
    const float high = (float)fake_get(CMPSSB(0) + CMPSS_DACHVALS) * VARIANT_V_DAC_V / 4096.0f;
    CHECK_NEAR(0.02, 5.0, (high - VARIANT_BIAS_V) / ohm);
}

static void test_gates_off_by_software_is_no_trip(void) {
    board_gates_off(); // before board_init()
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_write(&on);
    board_gates_off();
    TEST_ASSERT_TRUE(fake_all_tripped());
    lode_counts_t counts;
    board_read(&counts);
    TEST_ASSERT_FALSE(counts.trip);
}

// --- periods ---

static void put_counts(float i_A) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    const float offset = config.sense.i_offset_count, gain = config.sense.i_gain_A_count;
    fake_put(COUNT_A, (uint32_t)(offset + i_A / gain));
    fake_put(COUNT_B, (uint32_t)(offset - 0.5f * i_A / gain));
    fake_put(COUNT_C, (uint32_t)(offset - 0.5f * i_A / gain));
    fake_put(COUNT_BUS, (uint32_t)(VARIANT_V_BUS_V / config.sense.v_bus_gain_V_count));
    fake_put(ADC_RESULT(1, 1), 2048u); // 25 degC
}

static void next_turn(void) {
    now_cycles += HALF;
    fake_set_cycles(now_cycles, 400u);
    counts_down = !counts_down;
    fake_put(EPWM(0) + EPWM_TBSTS, counts_down ? 0u : TBSTS_UP);
}

static bool is_triggered(void) {
    const uint32_t at = fake_get(EPWM(0) + EPWM_ETSEL) >> 8 & 7u;
    return at == 3u || (at == 1u && !counts_down);
}

static bool is_taken_over(int x) {
    const uint32_t at = fake_get(EPWM(x) + EPWM_CMPCTL) & 3u;
    return at == 2u || (at == 0u && !counts_down);
}

static uint32_t compare_shadow(int x) {
    return fake_get(EPWM(x) + EPWM_CMPA);
}

static void change_compare(int x) {
    fake_put(EPWM(x) + EPWM_CMPA, compare_shadow(x) ^ 1u);
}

static void one_period(void) {
    next_turn();
    if (!VARIANT_DOUBLE_UPDATE) {
        next_turn();
    }
    fake_set_cycles(now_cycles, 0u);
    irq_handler();
    fake_set_cycles(now_cycles, 400u);
}

static void test_counts_come_from_the_right_results(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    fake_put(COUNT_A, 11u);
    fake_put(COUNT_B, 22u);
    fake_put(COUNT_C, 33u);
    fake_put(COUNT_BUS, 44u);
    fake_set_cycles(66u, 0u);
    lode_counts_t counts;
    board_read(&counts);
    TEST_ASSERT_EQUAL_UINT16(11u, counts.i[0]);
    TEST_ASSERT_EQUAL_UINT16(22u, counts.i[1]);
    TEST_ASSERT_EQUAL_UINT16(33u, counts.i[2]);
    TEST_ASSERT_EQUAL_UINT16(44u, counts.v_bus);
    TEST_ASSERT_EQUAL_UINT32(66u, counts.stamp);
}

static void test_bootstrap_capacitors_are_charged_first(void) {
    TEST_ASSERT_TRUE(app_start());
    put_counts(0.0f);
    app_mode = BRINGUP_SIGNS;
    app_armed = 1u;
    for (int n = 0; n < 60000 && !fake_gates_on(); n++) {
        one_period();
        app_poll();
    }
    int periods = 0;
    while (fake_get(EPWM(0) + EPWM_AQCSFRC) == AQCSFRC_A_LOW && periods < 30000) {
        TEST_ASSERT_TRUE(fake_gates_on());
        one_period();
        periods++;
    }
    CHECK_NEAR(1.5, (double)VARIANT_PRECHARGE_s * PORT_F_CALL_Hz, periods);
}

static void expect_gates_off_in_one_call(const char *check) {
    const int from = fake_count();
    one_period();
    TEST_ASSERT_TRUE(fake_all_tripped());
    const int off = fake_first(EPWM(0) + EPWM_TZFRC, TZFRC_OST, TZFRC_OST, from);
    const int compare = fake_first(EPWM(0) + EPWM_CMPA, 0u, 0u, from);
    TEST_ASSERT_TRUE(off >= from && compare > off); // before anything else is written
    TEST_ASSERT_EQUAL_STRING(check, lode_check_name((lode_check_t)app_telemetry().fault.check));
}

// While a debugger holds the core its cycle counter stands still: without the ADC's overflow the
// next period would look like any other, with an angle from before the halt.
static void test_periods_missed_while_the_counter_stood_still_are_a_fault(void) {
    gates_on_by_the_drive();
    one_period();
    TEST_ASSERT_TRUE(fake_gates_on());
    fake_put(ADC(0) + ADC_INTOVF, ADCINT1);
    expect_gates_off_in_one_call("LODE_CHECK_HARDWARE_TRIP");
}

static void test_missed_interrupt_is_a_fault(void) {
    gates_on_by_the_drive();
    now_cycles += PERIOD;
    expect_gates_off_in_one_call("LODE_CHECK_TIMING");
}

static void test_flags_are_cleared_around_the_period(void) {
    TEST_ASSERT_TRUE(app_start());
    int from = fake_count();
    one_period();
    TEST_ASSERT_EQUAL_INT(from, fake_first(VIM_STS(146), ~0u, 1u << 18, from));
    TEST_ASSERT_EQUAL_INT(from + 1, fake_first(ADC(0) + ADC_INTFLGCLR, ~0u, 1u, from));
    TEST_ASSERT_EQUAL_INT(fake_count() - 1, fake_first(VIM_IRQVEC, ~0u, 0u, from)); // the last
    fake_put(ADC(0) + ADC_INTOVF, ADCINT1); // a late one must not keep the next away
    from = fake_count();
    one_period();
    TEST_ASSERT_TRUE(fake_first(ADC(0) + ADC_INTOVFCLR, ~0u, ADCINT1, from) > from);
}

// --- supervision and serial port ---

static void test_watchdog_is_started_last_and_fed_by_steps(void) {
    TEST_ASSERT_TRUE(app_start());
    const int started = first(WDT_ENABLE, ~0u, 0xA98559DAu);
    TEST_ASSERT_TRUE(started > first(WDT_REACTION, ~0u, 5u));
    TEST_ASSERT_TRUE(started > first(EPWM(2) + EPWM_LOCK, 0u, 0u));
    put_counts(0.0f);
    app_mode = APP_MODE_OFF;
    one_period();
    int from = fake_count();
    app_poll();
    const int key = fake_first(WDT_KEY, ~0u, 0xE51Au, from);
    TEST_ASSERT_TRUE(key >= from && fake_first(WDT_KEY, ~0u, 0xA35Cu, key) == key + 1);
    from = fake_count();
    app_poll(); // no period since
    TEST_ASSERT_EQUAL_INT(-1, fake_first(WDT_KEY, 0u, 0u, from));
}

static void test_failed_init_is_reported_and_stops(void) {
    fake_set_fault(true);
    TEST_ASSERT_FALSE(app_start());
    for (int n = 0; n < 10; n++) {
        app_poll();
    }
    TEST_ASSERT_NOT_NULL(strstr(&fake_serial_text()[1], "START FAIL BOARD 0\r\n"));
    TEST_ASSERT_EQUAL_INT(-1, fake_first(WDT_ENABLE, 0u, 0u, 0)); // nor reset for ever
}

static void test_cause_of_a_reset(void) {
    fake_put(TOP_RCM_WARM_RST_CAUSE, 0x41u); // power
    TEST_ASSERT_FALSE(board_reset_by_watchdog());
    fake_put(TOP_RCM_WARM_RST_CAUSE, 0x42u); // the watchdog of R5FSS0 core 0
    TEST_ASSERT_TRUE(board_reset_by_watchdog());
    TEST_ASSERT_FALSE(board_reset_by_watchdog()); // cleared: the next reset speaks for itself
}

static void test_serial_port(void) {
    static const uint16_t octets[] = {'a', 'b'};
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    // 48 MHz/16/115200, while the divisor's registers are open
    const int open = first(UART0 + UART_LCR, ~0u, 0x83u);
    TEST_ASSERT_EQUAL_INT(open + 1, fake_first(UART0 + UART_DLL, ~0u, 26u, open));
    TEST_ASSERT_EQUAL_INT(open + 2, fake_first(UART0 + UART_DLH, ~0u, 0u, open));
    TEST_ASSERT_EQUAL_UINT32(2u, board_send(octets, 2u));
    TEST_ASSERT_EQUAL_STRING("ab", &fake_serial_text()[1]); // behind the divisor at its address
    fake_put(UART0 + UART_SSR, UART_SSR_TX_FULL);
    TEST_ASSERT_EQUAL_UINT32(0u, board_send(octets, 2u));
}

int main(void) {
    UNITY_BEGIN();
    if (VARIANT_DOUBLE_UPDATE && !IN_LINE) {
        RUN_TEST(test_double_update_with_low_side_shunts_is_refused);
        return UNITY_END();
    }
    RUN_TEST(test_configuration_is_accepted);
    RUN_TEST(test_outputs_are_held_low_before_the_pins_are_theirs);
    RUN_TEST(test_trip_path_is_armed_before_the_pins_and_before_the_driver);
    RUN_TEST(test_start_enables_the_interrupt_then_counts_and_leaves_the_gates_off);
    RUN_TEST(test_pwm_that_does_not_answer_keeps_everything_off);
    RUN_TEST(test_counters_and_dead_band);
    RUN_TEST(test_adcs_are_triggered_at_zero_of_every_period);
    RUN_TEST(test_duties_become_compare_values);
    RUN_TEST(test_thresholds_on_both_sides);
    RUN_TEST(test_every_source_switches_all_six_off_and_latches);
    RUN_TEST(test_low_sides_alone);
    RUN_TEST(test_bootstrap_capacitors_are_charged_first);
    RUN_TEST(test_trip_path_is_tested);
    RUN_TEST(test_threshold_follows_the_motor);
    RUN_TEST(test_gates_off_by_software_is_no_trip);
    RUN_TEST(test_active_trip_at_power_up_is_a_failed_init);
    RUN_TEST(test_sample_at_the_wrong_end_is_a_trip);
    RUN_TEST(test_compare_value_that_does_not_stay_is_a_trip);
    RUN_TEST(test_each_call_has_its_own_pulse);
    RUN_TEST(test_counts_come_from_the_right_results);
    RUN_TEST(test_over_temperature_switches_off);
    RUN_TEST(test_missing_sensor_is_too_hot);
    RUN_TEST(test_over_current_reaches_the_gates_in_the_same_call);
    RUN_TEST(test_hardware_trip_is_a_fault_in_the_same_call);
    RUN_TEST(test_periods_missed_while_the_counter_stood_still_are_a_fault);
    RUN_TEST(test_missed_interrupt_is_a_fault);
    RUN_TEST(test_flags_are_cleared_around_the_period);
    RUN_TEST(test_watchdog_is_started_last_and_fed_by_steps);
    RUN_TEST(test_failed_init_is_reported_and_stops);
    RUN_TEST(test_cause_of_a_reset);
    RUN_TEST(test_serial_port);
    return UNITY_END();
}
