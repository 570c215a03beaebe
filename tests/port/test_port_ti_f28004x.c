// The F28004x port on a recorded driverlib: which call, with which value, in which order; and the ways of
// a trip, which the fake follows from the comparator or the pin to the six outputs.
#include "app.h"
#include "board.h"
#include "chip.h"
#include "f28004x.h"
#include "figures.h"
#include "support/check.h"

#define STEPS (CHIP_F_CPU_Hz / VARIANT_F_PWM_Hz / 2u)
#define HALF STEPS
#define PERIOD (VARIANT_DOUBLE_UPDATE ? HALF : 2u * HALF)
#define SERIAL_TEXT fake_serial_text()
#define SOURCES 6 // three comparators, nFAULT, lost clock, halted core
#ifdef VARIANT_NTC_POINTS
#define PUT_T(count) fake_set_result(VARIANT_T_RESULT, ADC_SOC_NUMBER1, (uint16_t)(count))
#endif
#include "ti_cases.h"

static const uint32_t pwm[] = VARIANT_PWM;
static const lode_drive_out_t on = {.duty = {0.5f, 0.5f, 0.5f}, .gates = true};
static uint32_t now_cycles;

void setUp(void) {
    fake_reset();
    now_cycles = 0u;
    counts_down = false;
}

void tearDown(void) {}

static int first(const char *name, uint32_t a, uint32_t b, uint32_t c) {
    const int at = fake_first(name, a, b, c, 0);
    if (at < 0) {
        TEST_FAIL_MESSAGE(name);
    }
    return at;
}

static uint32_t third(const char *name, uint32_t a, uint32_t b) {
    const int at = fake_last(name, a, b, FAKE_ANY);
    TEST_ASSERT_TRUE(at >= 0);
    return fake_arguments(at)[2];
}

static uint32_t second(const char *name, uint32_t a) {
    const int at = fake_last(name, a, FAKE_ANY, FAKE_ANY);
    TEST_ASSERT_TRUE(at >= 0);
    return fake_arguments(at)[1];
}

// --- figures ---

static void test_dead_time_is_never_shorter(void) {
    static const uint32_t clocks[] = {100000000u, 200000000u};
    for (int c = 0; c < COUNT_OF(clocks); c++) {
        const double tick_ns = 1.0e9 / (double)clocks[c];
        for (uint32_t ns = 0u; ns < 20000u; ns++) {
            uint16_t counts = 0u;
            TEST_ASSERT_TRUE(ti_dead_time(clocks[c], ns, &counts));
            CHECK_AT_LEAST((double)ns - 1.0e-3, counts * tick_ns);
            CHECK_AT_MOST((double)ns + tick_ns, counts * tick_ns);
        }
    }
    uint16_t counts = 0u;
    TEST_ASSERT_FALSE(ti_dead_time(200000000u, 100000u, &counts)); // 20000 counts: 14 bits
    TEST_ASSERT_FALSE(ti_dead_time(200000000u, UINT32_MAX, &counts));
}

static void test_period_in_steps(void) {
    TEST_ASSERT_EQUAL_UINT16(2500u, port_pwm_steps(100000000u, 20000u));
    TEST_ASSERT_EQUAL_UINT16(5000u, port_pwm_steps(200000000u, 20000u));
    TEST_ASSERT_EQUAL_UINT16(0u, port_pwm_steps(200000000u, 1000u)); // beyond 16 bits
    TEST_ASSERT_EQUAL_UINT16(0u, port_pwm_steps(200000000u, 0u));
}

// A low side that is on for `low_s` around t_k has settled before t_k and is sampled before its end; and
// at the voltage that is then left, the second largest duty leaves its phase sampled at every angle.
static void test_sampling_window(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    const double duty_max = (double)config.sense.duty_max;
    const double half_low_ns = 0.5 * (1.0 - duty_max) * 1.0e9 / (double)VARIANT_F_PWM_Hz;
    if (!IN_LINE) {
        CHECK_AT_LEAST(VARIANT_SETTLE_ns * 0.9999f, half_low_ns);
        CHECK_AT_LEAST(CHIP_SAMPLE_ns * 0.9999f, half_low_ns);
    }
    CHECK_AT_LEAST(10.0 * (3.0 + CHIP_WINDOW_cycles), CHIP_SAMPLE_ns);
    TEST_ASSERT_TRUE(IN_LINE ? duty_max > 0.9999 : duty_max > 0.8 && duty_max < 1.0);
    CHECK_CLOSE(1e-6, 0.95, port_voltage_use(1.0f));
    for (int limit = 60; limit <= 100; limit += 5) {
        const double u = (double)port_voltage_use((float)limit / 100.0f) / sqrt(3.0);
        for (int n = 0; n < 360; n++) {
            double v[3];
            for (int x = 0; x < 3; x++) {
                v[x] = u * cos(n * CHECK_DEG - x * 2.0 * CHECK_PI / 3.0);
            }
            const double high = fmax(v[0], fmax(v[1], v[2])), low = fmin(v[0], fmin(v[1], v[2]));
            const double middle = -high - low;
            CHECK_AT_MOST(limit / 100.0 + 1e-6, middle + 0.5 - 0.5 * (high + low));
        }
    }
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
    CHECK_CLOSE(1e-3, 42.857, -config.sense.i_gain_A_count * 4096.0f); // full scale of the board
    CHECK_NEAR(8.0, 2048.0, config.sense.i_offset_count);
    CHECK_CLOSE(1e-3, 57.53, config.sense.v_bus_gain_V_count * 4096.0f);
}

// --- order of the initialisation ---

static void test_outputs_are_held_low_before_the_pins_are_theirs(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    static const uint32_t pins[] = {GPIO_10_EPWM6_A, GPIO_11_EPWM6_B, GPIO_8_EPWM5_A,
                                    GPIO_9_EPWM5_B,  GPIO_4_EPWM3_A,  GPIO_5_EPWM3_B};
    const int stopped = first("SysCtl_disablePeripheral", SYSCTL_PERIPH_CLK_TBCLKSYNC, 0u, 0u);
    for (int p = 0; p < COUNT_OF(pwm); p++) {
        const int clock = first("SysCtl_enablePeripheral", (const uint32_t[])VARIANT_PWM_CLOCKS[p],
                                FAKE_ANY, FAKE_ANY);
        const int held =
            fake_first("EPWM_forceTripZoneEvent", pwm[p], EPWM_TZ_FORCE_EVENT_OST, FAKE_ANY, clock);
        const int locked = first("EPWM_lockRegisters", pwm[p], EPWM_REGISTER_GROUP_TRIP_ZONE, 0u);
        TEST_ASSERT_TRUE(stopped < clock && clock < held);
        TEST_ASSERT_TRUE(held < first("EPWM_setTimeBasePeriod", pwm[p], STEPS, FAKE_ANY));
        TEST_ASSERT_TRUE(first("EPWM_setTripZoneAction", pwm[p], EPWM_TZ_ACTION_EVENT_TZA,
                               EPWM_TZ_ACTION_LOW) < locked);
        TEST_ASSERT_TRUE(first("EPWM_setTripZoneAction", pwm[p], EPWM_TZ_ACTION_EVENT_TZB,
                               EPWM_TZ_ACTION_LOW) < locked);
        TEST_ASSERT_TRUE(first("EPWM_setFallingEdgeDelayCount", pwm[p], FAKE_ANY, FAKE_ANY) <
                         locked);
        for (int n = 0; n < COUNT_OF(pins); n++) {
            TEST_ASSERT_TRUE(first("GPIO_setPinConfig", pins[n], FAKE_ANY, FAKE_ANY) > locked);
        }
    }
    TEST_ASSERT_FALSE(fake_gates_on());
    TEST_ASSERT_TRUE(fake_all_tripped());
}

static void test_trip_path_is_armed_before_the_pins_and_before_the_driver(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    const int pins = first("GPIO_setPinConfig", GPIO_10_EPWM6_A, FAKE_ANY, FAKE_ANY);
    const int driver = first("GPIO_writePin", VARIANT_ENABLE_GPIO, 1u, FAKE_ANY);
    static const uint32_t cmpss[] = {CMPSS5_BASE, CMPSS3_BASE, CMPSS1_BASE};
    for (int n = 0; n < COUNT_OF(cmpss); n++) {
        const int thresholds = first("CMPSS_setDACValueHigh", cmpss[n], FAKE_ANY, FAKE_ANY);
        const int enabled = first("CMPSS_enableModule", cmpss[n], FAKE_ANY, FAKE_ANY);
        TEST_ASSERT_TRUE(thresholds < enabled && enabled < pins);
    }
    for (int p = 0; p < COUNT_OF(pwm); p++) {
        TEST_ASSERT_TRUE(first("EPWM_enableTripZoneSignals", pwm[p], FAKE_ANY, FAKE_ANY) < pins);
        // Neither waits for a clock.
        const uint32_t *source = fake_arguments(
            first("EPWM_setDigitalCompareEventSource", pwm[p], EPWM_DC_MODULE_A, EPWM_DC_EVENT_1));
        const uint32_t *sync = fake_arguments(first("EPWM_setDigitalCompareEventSyncMode", pwm[p],
                                                    EPWM_DC_MODULE_A, EPWM_DC_EVENT_1));
        TEST_ASSERT_EQUAL_UINT32(EPWM_DC_EVENT_SOURCE_ORIG_SIGNAL, source[3]);
        TEST_ASSERT_EQUAL_UINT32(EPWM_DC_EVENT_INPUT_NOT_SYNCED, sync[3]);
    }
    TEST_ASSERT_TRUE(first("XBAR_enableEPWMMux", XBAR_TRIP4, FAKE_ANY, FAKE_ANY) < pins);
    TEST_ASSERT_TRUE(first("XBAR_setInputPin", XBAR_INPUT1, VARIANT_FAULT_GPIO, FAKE_ANY) < pins);
    TEST_ASSERT_TRUE(pins < driver);
    TEST_ASSERT_EQUAL_INT(-1,
                          fake_first("EPWM_clearTripZoneFlag", FAKE_ANY, FAKE_ANY, FAKE_ANY, 0));
}

static void test_start_enables_the_interrupt_then_counts_and_leaves_the_gates_off(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_INT(-1, fake_first("Interrupt_enable", FAKE_ANY, FAKE_ANY, FAKE_ANY, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first("EINT", FAKE_ANY, FAKE_ANY, FAKE_ANY, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first("SysCtl_enablePeripheral", SYSCTL_PERIPH_CLK_TBCLKSYNC,
                                         FAKE_ANY, FAKE_ANY, 0));
    const int from = fake_count();
    board_start();
    const int cleared =
        fake_first("ADC_clearInterruptStatus", VARIANT_BUS_ADC, FAKE_ANY, FAKE_ANY, from);
    const int enabled = first("Interrupt_enable", INT_ADCB1, FAKE_ANY, FAKE_ANY);
    const int counting = first("SysCtl_enablePeripheral", SYSCTL_PERIPH_CLK_TBCLKSYNC, 0u, 0u);
    TEST_ASSERT_TRUE(cleared >= from && cleared < enabled && enabled < counting);
    TEST_ASSERT_TRUE(first("EINT", FAKE_ANY, FAKE_ANY, FAKE_ANY) < counting);
    TEST_ASSERT_FALSE(fake_gates_on());
}

static void test_clock_that_does_not_come_keeps_everything_off(void) {
    fake_kill_clock();
    TEST_ASSERT_FALSE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_INT(-1,
                          fake_first("GPIO_setPinConfig", GPIO_10_EPWM6_A, FAKE_ANY, FAKE_ANY, 0));
    TEST_ASSERT_EQUAL_INT(-1, fake_first("GPIO_writePin", VARIANT_ENABLE_GPIO, 1u, FAKE_ANY, 0));
    TEST_ASSERT_FALSE(app_start());
    TEST_ASSERT_EQUAL_INT(-1, fake_first("EINT", FAKE_ANY, FAKE_ANY, FAKE_ANY, 0));
}

// --- timer, dead-band, trigger ---

static void test_counters_and_dead_band(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    for (int p = 0; p < COUNT_OF(pwm); p++) {
        const uint32_t base = pwm[p];
        // A halt trips; the counter must not stop before that.
        TEST_ASSERT_EQUAL_UINT32(EPWM_EMULATION_FREE_RUN, second("EPWM_setEmulationMode", base));
        TEST_ASSERT_EQUAL_UINT32(EPWM_COUNTER_MODE_UP_DOWN,
                                 second("EPWM_setTimeBaseCounterMode", base));
        TEST_ASSERT_EQUAL_UINT32(STEPS, second("EPWM_setTimeBasePeriod", base));
        TEST_ASSERT_EQUAL_UINT32(0u, second("EPWM_setTimeBaseCounter", base)); // start together
        TEST_ASSERT_EQUAL_UINT32(
            VARIANT_DOUBLE_UPDATE ? EPWM_COMP_LOAD_ON_CNTR_ZERO_PERIOD
                                  : EPWM_COMP_LOAD_ON_CNTR_ZERO,
            third("EPWM_setCounterCompareShadowLoadMode", base, EPWM_COUNTER_COMPARE_A));
        // 200 ns of 10 ns, on both edges; B is the complement of A.
        TEST_ASSERT_EQUAL_UINT32(20u, second("EPWM_setRisingEdgeDelayCount", base));
        TEST_ASSERT_EQUAL_UINT32(20u, second("EPWM_setFallingEdgeDelayCount", base));
        TEST_ASSERT_EQUAL_UINT32(1u, third("EPWM_setDeadBandDelayMode", base, EPWM_DB_RED));
        TEST_ASSERT_EQUAL_UINT32(1u, third("EPWM_setDeadBandDelayMode", base, EPWM_DB_FED));
        TEST_ASSERT_EQUAL_UINT32(EPWM_DB_POLARITY_ACTIVE_HIGH,
                                 third("EPWM_setDeadBandDelayPolarity", base, EPWM_DB_RED));
        TEST_ASSERT_EQUAL_UINT32(EPWM_DB_POLARITY_ACTIVE_LOW,
                                 third("EPWM_setDeadBandDelayPolarity", base, EPWM_DB_FED));
        // High sides on around the upper turning point.
        const int high =
            first("EPWM_setActionQualifierAction", base, EPWM_AQ_OUTPUT_A, EPWM_AQ_OUTPUT_HIGH);
        const int low =
            first("EPWM_setActionQualifierAction", base, EPWM_AQ_OUTPUT_A, EPWM_AQ_OUTPUT_LOW);
        TEST_ASSERT_EQUAL_UINT32(EPWM_AQ_OUTPUT_ON_TIMEBASE_UP_CMPA, fake_arguments(high)[3]);
        TEST_ASSERT_EQUAL_UINT32(EPWM_AQ_OUTPUT_ON_TIMEBASE_DOWN_CMPA, fake_arguments(low)[3]);
    }
}

// At zero all low sides are on: the middle of the zero vector, where the shunts carry the currents.
static void test_adcs_are_triggered_at_zero_of_every_period(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_UINT32(VARIANT_DOUBLE_UPDATE ? EPWM_SOC_TBCTR_ZERO_OR_PERIOD
                                                   : EPWM_SOC_TBCTR_ZERO,
                             third("EPWM_setADCTriggerSource", pwm[0], EPWM_SOC_A));
    TEST_ASSERT_EQUAL_UINT32(1u, third("EPWM_setADCTriggerEventPrescale", pwm[0], EPWM_SOC_A));
    (void)first("EPWM_enableADCTrigger", pwm[0], EPWM_SOC_A, FAKE_ANY);
    static const struct {
        uint32_t adc, channel;
    } currents[] = {{ADCA_BASE, 14u}, {ADCC_BASE, 7u}, {ADCB_BASE, 7u}};
    for (int n = 0; n < COUNT_OF(currents); n++) { // the same trigger, first in each: one instant
        const uint32_t *soc = fake_arguments(
            first("ADC_setupSOC", currents[n].adc, ADC_SOC_NUMBER0, ADC_TRIGGER_EPWM6_SOCA));
        TEST_ASSERT_EQUAL_UINT32(currents[n].channel, soc[3]);
        CHECK_AT_LEAST(8u, soc[4]); // 75 ns
    }
    (void)first("ADC_setupSOC", ADCB_BASE, ADC_SOC_NUMBER1, ADC_TRIGGER_EPWM6_SOCA);
    // The interrupt comes with the last of all results, at the end of its conversion.
    TEST_ASSERT_EQUAL_UINT32(ADC_SOC_NUMBER1,
                             third("ADC_setInterruptSource", ADCB_BASE, ADC_INT_NUMBER1));
    TEST_ASSERT_EQUAL_UINT32(ADC_PULSE_END_OF_CONV, second("ADC_setInterruptPulseMode", ADCB_BASE));
}

static void test_duties_become_compare_values(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_write(&(lode_drive_out_t){.duty = {0.0f, 0.25f, 1.0f}});
    TEST_ASSERT_EQUAL_UINT32(VARIANT_DOUBLE_UPDATE ? STEPS - 1u : STEPS,
                             third("EPWM_setCounterCompareValue", pwm[0], 0u));
    TEST_ASSERT_EQUAL_UINT32(STEPS - STEPS / 4u, third("EPWM_setCounterCompareValue", pwm[1], 0u));
    TEST_ASSERT_EQUAL_UINT32(1u, third("EPWM_setCounterCompareValue", pwm[2], 0u));
    // Every other step of the grid hits its own value.
    for (uint32_t k = VARIANT_DOUBLE_UPDATE ? 1u : 0u; k < STEPS; k++) {
        TEST_ASSERT_EQUAL_UINT16(
            STEPS - k, ti_compare((float)k / (float)STEPS, (uint16_t)STEPS, VARIANT_DOUBLE_UPDATE));
    }
}

// --- trip ---

static void test_thresholds_on_both_sides(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    static const uint32_t cmpss[] = {CMPSS5_BASE, CMPSS3_BASE, CMPSS1_BASE};
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    const float gain = config.sense.i_gain_A_count, offset = config.sense.i_offset_count;
    for (int n = 0; n < COUNT_OF(cmpss); n++) {
        const float high = (float)second("CMPSS_setDACValueHigh", cmpss[n]);
        const float low = (float)second("CMPSS_setDACValueLow", cmpss[n]);
        CHECK_NEAR(0.02, -VARIANT_TRIP_MAX_A, (high - offset) * gain);
        CHECK_NEAR(0.02, VARIANT_TRIP_MAX_A, (low - offset) * gain);
        // The low comparator's output is inverted: it trips below.
        TEST_ASSERT_EQUAL_HEX32(CMPSS_INSRC_DAC, second("CMPSS_configHighComparator", cmpss[n]));
        TEST_ASSERT_EQUAL_HEX32(CMPSS_INSRC_DAC | CMPSS_INV_INVERTED,
                                second("CMPSS_configLowComparator", cmpss[n]));
    }
    TEST_ASSERT_EQUAL_UINT32(4u, second("ASysCtl_selectCMPHPMux", ASYSCTL_CMPHPMUX_SELECT_5));
    TEST_ASSERT_EQUAL_UINT32(4u, second("ASysCtl_selectCMPLPMux", ASYSCTL_CMPLPMUX_SELECT_1));
}

static void set_source(int n, bool active) {
    static const uint32_t cmpss[] = {CMPSS5_BASE, CMPSS3_BASE, CMPSS1_BASE};
    if (n < COUNT_OF(cmpss)) {
        fake_set_comparator(cmpss[n], active);
    } else if (n == 3) {
        fake_set_fault(active);
    } else if (n == 4) {
        fake_set_clock_lost(active);
    } else {
        fake_set_halted(active);
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
        TEST_ASSERT_EQUAL_INT(
            -1, fake_first("EPWM_clearTripZoneFlag", FAKE_ANY, FAKE_ANY, FAKE_ANY, from));
        TEST_ASSERT_TRUE(board_clear_trip());
        TEST_ASSERT_TRUE(fake_all_tripped()); // cleared is not on
        TEST_ASSERT_FALSE(trip_in_next_call());
        board_write(&on);
        TEST_ASSERT_TRUE(fake_gates_on());
    }
}

// An ePWM's two outputs while no trip holds them: by the dead-band, which makes B the complement of A, or
// past it, where A is forced and B has actions of its own.
static void expect_outputs(uint32_t base, bool below, bool a, bool b) {
    const bool banded = third("EPWM_setDeadBandDelayMode", base, EPWM_DB_RED) != 0u;
    TEST_ASSERT_EQUAL_UINT32(banded, third("EPWM_setDeadBandDelayMode", base, EPWM_DB_FED));
    const bool forced = third("EPWM_setActionQualifierContSWForceAction", base, EPWM_AQ_OUTPUT_A) ==
                        EPWM_AQ_SW_OUTPUT_LOW;
    TEST_ASSERT_EQUAL_UINT32(EPWM_AQ_SW_IMMEDIATE_LOAD,
                             second("EPWM_setActionQualifierContSWForceShadowMode", base));
    const int low =
        fake_last("EPWM_setActionQualifierAction", base, EPWM_AQ_OUTPUT_B, EPWM_AQ_OUTPUT_LOW);
    const int high =
        fake_last("EPWM_setActionQualifierAction", base, EPWM_AQ_OUTPUT_B, EPWM_AQ_OUTPUT_HIGH);
    TEST_ASSERT_EQUAL_UINT32(EPWM_AQ_OUTPUT_ON_TIMEBASE_UP_CMPA, fake_arguments(low)[3]);
    TEST_ASSERT_EQUAL_UINT32(EPWM_AQ_OUTPUT_ON_TIMEBASE_DOWN_CMPA, fake_arguments(high)[3]);
    const bool input_a = !below && !forced;
    TEST_ASSERT_EQUAL_INT(a, input_a);
    TEST_ASSERT_EQUAL_INT(b, banded ? !input_a : below);
}

static void test_low_sides_alone(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    board_write(&on);
    for (int p = 0; p < COUNT_OF(pwm); p++) {
        expect_outputs(pwm[p], true, false, true);
        expect_outputs(pwm[p], false, true, false);
    }
    const int from = fake_count();
    const lode_drive_out_t low = {.duty = {0.8f, 0.8f, 0.8f}, .gates = LODE_GATES_LOW};
    board_write(&low);
    TEST_ASSERT_TRUE(fake_gates_on());
    for (int p = 0; p < COUNT_OF(pwm); p++) {
        expect_outputs(pwm[p], true, false, true);
        expect_outputs(pwm[p], false, false, false);
        // All off while the outputs change, A low before the dead-band lets it through.
        const int off = fake_first("EPWM_forceTripZoneEvent", pwm[p], FAKE_ANY, FAKE_ANY, from);
        const int forced =
            fake_first("EPWM_setActionQualifierContSWForceAction", pwm[p], 0u, 1u, from);
        const int past = fake_first("EPWM_setDeadBandDelayMode", pwm[p], FAKE_ANY, 0u, from);
        const int cleared = fake_first("EPWM_clearTripZoneFlag", pwm[p], FAKE_ANY, FAKE_ANY, from);
        TEST_ASSERT_TRUE(off >= from && forced > off && past > forced && cleared > past);
    }
    const int again = fake_count();
    board_write(&low); // steady: nothing goes off in between
    TEST_ASSERT_EQUAL_INT(
        -1, fake_first("EPWM_forceTripZoneEvent", FAKE_ANY, FAKE_ANY, FAKE_ANY, again));
    set_source(0, true); // a trip counts here too
    set_source(0, false);
    board_write(&low);
    TEST_ASSERT_TRUE(fake_all_tripped());
    TEST_ASSERT_TRUE(board_clear_trip());
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
    expect_outputs(pwm[0], false, true, false);
}

static void test_trip_path_is_tested(void) {
    static const uint32_t cmpss[] = {CMPSS5_BASE, CMPSS3_BASE, CMPSS1_BASE};
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
    const int from = fake_count();
    TEST_ASSERT_TRUE(board_test_trip());
    TEST_ASSERT_TRUE(fake_all_tripped()); // off, by itself before the first threshold moves
    const int off = fake_first("EPWM_forceTripZoneEvent", pwm[2], FAKE_ANY, FAKE_ANY, from);
    const int moved = fake_first("CMPSS_setDACValueHigh", cmpss[0], 0u, FAKE_ANY, from);
    TEST_ASSERT_TRUE(off >= from && moved > off);
    lode_counts_t counts;
    board_read(&counts);
    TEST_ASSERT_FALSE(counts.trip);     // leaves no trip behind
    for (uint32_t n = 0; n < 6u; n++) { // each sign of each phase
        fake_reset();
        TEST_ASSERT_TRUE(board_init(TRIP_A));
        fake_kill_comparator(cmpss[n / 2u], n % 2u == 0u);
        TEST_ASSERT_FALSE(board_test_trip());
    }
}

static void test_threshold_follows_the_motor(void) {
    TEST_ASSERT_TRUE(board_init(5.0f));
    const float high = (float)second("CMPSS_setDACValueHigh", CMPSS5_BASE);
    CHECK_NEAR(0.02, 5.0, (high - VARIANT_I_OFFSET_count) * -VARIANT_I_GAIN_A_count);
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
    board_write(&on);
    TEST_ASSERT_TRUE(fake_gates_on());
}

static void test_clearing_resets_the_driver_and_waits_for_it(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_write(&on);
    set_source(3, true);
    set_source(3, false);
    const int from = fake_count();
    TEST_ASSERT_TRUE(board_clear_trip());
    const int low = fake_first("GPIO_writePin", VARIANT_ENABLE_GPIO, 0u, FAKE_ANY, from);
    const int high = fake_first("GPIO_writePin", VARIANT_ENABLE_GPIO, 1u, FAKE_ANY, from);
    const int cleared =
        fake_first("EPWM_clearOneShotTripZoneFlag", FAKE_ANY, FAKE_ANY, FAKE_ANY, from);
    TEST_ASSERT_TRUE(low >= from && high > low && cleared > high);
    // 8 .. 40 us low, 1 ms to wake up; a count of the delay is 50 ns.
    const uint32_t pulse =
        fake_arguments(fake_first("SysCtl_delay", FAKE_ANY, FAKE_ANY, FAKE_ANY, low))[0];
    const uint32_t wake =
        fake_arguments(fake_first("SysCtl_delay", FAKE_ANY, FAKE_ANY, FAKE_ANY, high))[0];
    TEST_ASSERT_TRUE(pulse >= 160u && pulse <= 800u);
    CHECK_AT_LEAST(20000u, wake);
}

// --- periods ---

static void put_counts(float i_A) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    const float offset = config.sense.i_offset_count, gain = config.sense.i_gain_A_count;
    fake_set_result(ADCARESULT_BASE, ADC_SOC_NUMBER0, (uint16_t)(offset + i_A / gain));
    fake_set_result(ADCCRESULT_BASE, ADC_SOC_NUMBER0, (uint16_t)(offset - 0.5f * i_A / gain));
    fake_set_result(ADCBRESULT_BASE, ADC_SOC_NUMBER0, (uint16_t)(offset - 0.5f * i_A / gain));
    fake_set_result(ADCBRESULT_BASE, ADC_SOC_NUMBER1,
                    (uint16_t)(VARIANT_V_BUS_V / config.sense.v_bus_gain_V_count));
    fake_set_result(ADCARESULT_BASE, ADC_SOC_NUMBER1, 2048u); // 25 degC, with a sensor
}

static void next_turn(void) {
    now_cycles += HALF;
    fake_set_cycles(now_cycles);
    counts_down = !counts_down;
    fake_set_direction((uint16_t)(counts_down ? EPWM_TIME_BASE_STATUS_COUNT_DOWN
                                              : EPWM_TIME_BASE_STATUS_COUNT_UP));
}

static bool is_triggered(void) {
    const uint32_t at = third("EPWM_setADCTriggerSource", pwm[0], EPWM_SOC_A);
    return at == EPWM_SOC_TBCTR_ZERO_OR_PERIOD || (at == EPWM_SOC_TBCTR_ZERO && !counts_down);
}

static bool is_taken_over(int x) {
    const uint32_t at =
        third("EPWM_setCounterCompareShadowLoadMode", pwm[x], EPWM_COUNTER_COMPARE_A);
    return at == EPWM_COMP_LOAD_ON_CNTR_ZERO_PERIOD ||
           (at == EPWM_COMP_LOAD_ON_CNTR_ZERO && !counts_down);
}

static uint32_t compare_shadow(int x) {
    return third("EPWM_setCounterCompareValue", pwm[x], EPWM_COUNTER_COMPARE_A);
}

static void change_compare(int x) {
    EPWM_setCounterCompareValue(pwm[x], EPWM_COUNTER_COMPARE_A, (uint16_t)(compare_shadow(x) ^ 1u));
}

static void one_period(void) {
    next_turn();
    if (!VARIANT_DOUBLE_UPDATE) {
        next_turn();
    }
    fake_handler(INT_ADCB1)();
}

static void test_counts_come_from_the_right_results(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    fake_set_result(ADCARESULT_BASE, ADC_SOC_NUMBER0, 11u);
    fake_set_result(ADCCRESULT_BASE, ADC_SOC_NUMBER0, 22u);
    fake_set_result(ADCBRESULT_BASE, ADC_SOC_NUMBER0, 33u);
    fake_set_result(ADCBRESULT_BASE, ADC_SOC_NUMBER1, 44u);
    fake_set_cycles(66u);
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
    while (third("EPWM_setActionQualifierContSWForceAction", pwm[0], EPWM_AQ_OUTPUT_A) ==
               EPWM_AQ_SW_OUTPUT_LOW &&
           periods < 30000) {
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
    const int off =
        fake_first("EPWM_forceTripZoneEvent", pwm[0], EPWM_TZ_FORCE_EVENT_OST, 0u, from);
    const int compare =
        fake_first("EPWM_setCounterCompareValue", FAKE_ANY, FAKE_ANY, FAKE_ANY, from);
    TEST_ASSERT_TRUE(off >= from && compare > off); // before anything else is written
    TEST_ASSERT_EQUAL_STRING(check, lode_check_name((lode_check_t)app_telemetry().fault.check));
}

static void test_result_that_nobody_took_is_a_fault(void) {
    gates_on_by_the_drive();
    fake_set_overflow();
    expect_gates_off_in_one_call("LODE_CHECK_HARDWARE_TRIP");
}

static void test_missed_interrupt_is_a_fault(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_EQUAL_UINT32(CPUTIMER_EMULATIONMODE_RUNFREE,
                             second("CPUTimer_setEmulationMode", CPUTIMER1_BASE)); // in a halt too
    gates_on_by_the_drive();
    now_cycles += PERIOD;
    expect_gates_off_in_one_call("LODE_CHECK_TIMING");
}

static void test_flags_are_cleared_around_the_period(void) {
    TEST_ASSERT_TRUE(app_start());
    int from = fake_count();
    one_period();
    const int acknowledged =
        fake_last("Interrupt_clearACKGroup", INTERRUPT_ACK_GROUP1, FAKE_ANY, FAKE_ANY);
    TEST_ASSERT_EQUAL_INT(
        from, fake_first("ADC_clearInterruptStatus", ADCB_BASE, ADC_INT_NUMBER1, FAKE_ANY, from));
    TEST_ASSERT_EQUAL_INT(fake_count() - 1, acknowledged);
    fake_set_overflow(); // a late one must not keep the next away
    from = fake_count();
    one_period();
    TEST_ASSERT_TRUE(fake_first("ADC_clearInterruptOverflowStatus", ADCB_BASE, ADC_INT_NUMBER1,
                                FAKE_ANY, from) > from);
}

// --- supervision and serial port ---

static void test_unexpected_interrupts_have_a_handler(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    TEST_ASSERT_TRUE(fake_handler(INT_NMI) != NULL);
    TEST_ASSERT_TRUE(fake_handler(INT_ILLEGAL) == fake_handler(INT_NMI));
}

static void test_watchdog_is_started_last_and_fed_by_steps(void) {
    TEST_ASSERT_TRUE(app_start());
    TEST_ASSERT_EQUAL_UINT32(SYSCTL_WD_MODE_RESET,
                             fake_arguments(first("SysCtl_setWatchdogMode", FAKE_ANY, 0u, 0u))[0]);
    const int started = first("SysCtl_enableWatchdog", FAKE_ANY, FAKE_ANY, FAKE_ANY);
    TEST_ASSERT_TRUE(started > first("Device_init", FAKE_ANY, FAKE_ANY, FAKE_ANY)); // it stops it
    TEST_ASSERT_TRUE(started > first("EPWM_lockRegisters", pwm[2], FAKE_ANY, FAKE_ANY));
    put_counts(0.0f);
    app_mode = APP_MODE_OFF;
    one_period();
    int from = fake_count();
    app_poll();
    TEST_ASSERT_TRUE(fake_first("SysCtl_serviceWatchdog", FAKE_ANY, FAKE_ANY, FAKE_ANY, from) >=
                     from);
    from = fake_count();
    app_poll(); // no period since
    TEST_ASSERT_EQUAL_INT(-1,
                          fake_first("SysCtl_serviceWatchdog", FAKE_ANY, FAKE_ANY, FAKE_ANY, from));
}

static void expect_report_of_a_failed_init(uint32_t f_serial_Hz) {
    TEST_ASSERT_FALSE(app_start());
    for (int n = 0; n < 10; n++) {
        app_poll();
    }
    TEST_ASSERT_NOT_NULL(strstr(fake_serial_text(), "START FAIL BOARD 0\r\n"));
    TEST_ASSERT_EQUAL_UINT32(f_serial_Hz, second("SCI_setConfig", SCIA_BASE));
    // Nor reset for ever.
    TEST_ASSERT_EQUAL_INT(-1, fake_first("SysCtl_enableWatchdog", FAKE_ANY, FAKE_ANY, FAKE_ANY, 0));
}

static void test_failed_init_is_reported_and_stops(void) {
    fake_set_fault(true);
    expect_report_of_a_failed_init(25000000u);
    fake_reset();
    fake_kill_clock();
    expect_report_of_a_failed_init(DEVICE_OSCSRC_FREQ / 8u); // by the clock that there is
}

static void test_cause_of_a_reset(void) {
    fake_set_reset_cause(SYSCTL_CAUSE_XRS);
    TEST_ASSERT_FALSE(board_reset_by_watchdog());
    fake_set_reset_cause(SYSCTL_CAUSE_XRS | SYSCTL_CAUSE_WDRS);
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

int main(void) {
    UNITY_BEGIN();
    if (VARIANT_DOUBLE_UPDATE && !IN_LINE) {
        RUN_TEST(test_double_update_with_low_side_shunts_is_refused);
        return UNITY_END();
    }
    RUN_TEST(test_dead_time_is_never_shorter);
    RUN_TEST(test_period_in_steps);
    RUN_TEST(test_sampling_window);
    RUN_TEST(test_configuration_is_accepted);
    RUN_TEST(test_outputs_are_held_low_before_the_pins_are_theirs);
    RUN_TEST(test_trip_path_is_armed_before_the_pins_and_before_the_driver);
    RUN_TEST(test_start_enables_the_interrupt_then_counts_and_leaves_the_gates_off);
    RUN_TEST(test_clock_that_does_not_come_keeps_everything_off);
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
    RUN_TEST(test_clearing_resets_the_driver_and_waits_for_it);
    RUN_TEST(test_sample_at_the_wrong_end_is_a_trip);
    RUN_TEST(test_compare_value_that_does_not_stay_is_a_trip);
    RUN_TEST(test_each_call_has_its_own_pulse);
    RUN_TEST(test_counts_come_from_the_right_results);
#ifdef VARIANT_NTC_POINTS
    RUN_TEST(test_over_temperature_switches_off);
    RUN_TEST(test_missing_sensor_is_too_hot);
#endif
    RUN_TEST(test_over_current_reaches_the_gates_in_the_same_call);
    RUN_TEST(test_hardware_trip_is_a_fault_in_the_same_call);
    RUN_TEST(test_result_that_nobody_took_is_a_fault);
    RUN_TEST(test_missed_interrupt_is_a_fault);
    RUN_TEST(test_flags_are_cleared_around_the_period);
    RUN_TEST(test_unexpected_interrupts_have_a_handler);
    RUN_TEST(test_watchdog_is_started_last_and_fed_by_steps);
    RUN_TEST(test_failed_init_is_reported_and_stops);
    RUN_TEST(test_cause_of_a_reset);
    RUN_TEST(test_serial_port_takes_what_it_has_room_for);
    return UNITY_END();
}
