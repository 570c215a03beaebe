// Faults of the drive: the guard, memory that changes by itself, what is kept of a trip.
#include "support/drive_cases.h"

#include "lodestar/channel.h"

void setUp(void) {}

void tearDown(void) {}

static lode_drive_tuning_t other_tuning;

/// Any one bit of an order that flips shows in its check, whatever the others are.
static void test_every_bit_of_an_order_counts(void) {
    random_t random = random_seed(7);
    for (int n = 0; n < 20; n++) {
        uint32_t bits[4];
        for (int k = 0; k < 4; k++) {
            bits[k] = random_bits(&random);
        }
        for (int bit = -1; bit < 128 + 8 + 8; bit++) { // four floats, the mode, the flags
            static uint_least16_t check;
            lode_order_t order = {.mode = (uint_least8_t)(n % 7), .flags = (uint_least8_t)(n % 8)};
            uint32_t flipped[4];
            for (int k = 0; k < 4; k++) {
                flipped[k] = bits[k] ^ (bit >= 0 && bit / 32 == k ? 1u << bit % 32 : 0u);
            }
            memcpy(&order.speed_rad_s, &flipped[0], sizeof flipped[0]);
            memcpy(&order.theta_rad, &flipped[1], sizeof flipped[1]);
            memcpy(&order.value.vector, &flipped[2], 2u * sizeof flipped[2]);
            if (bit >= 128 && bit < 136) {
                order.mode = (uint_least8_t)(order.mode ^ 1u << (bit - 128));
            }
            if (bit >= 136) {
                order.flags = (uint_least8_t)(order.flags ^ 1u << (bit - 136));
            }
            if (bit < 0) {
                check = lode_mode_order_check(&order);
            } else {
                TEST_ASSERT_TRUE(lode_mode_order_check(&order) != check);
            }
        }
    }
}

/// Of a mode that has its gates off no period is driven, though it be whole: each of its words has changed.
static void test_a_driven_mode_that_became_another_trips_at_once(void) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {2.0f, 0.0f}});
    rig_run(&rig, 0.1);
    rig.drive.mode = (uint_least8_t)LODE_MODE_OFF;
    rig.drive.mode_not = (uint_least8_t)(MODE_BITS ^ (uint32_t)LODE_MODE_OFF);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_MEMORY, rig_telemetry(&rig).fault.check);
}

/// Mail is read once, and the drive is steady again.
static void test_mail_is_read_once(void) {
    rig_t rig = steady();
    rig_command(&rig, run_at(90.0));
    TEST_ASSERT_TRUE(rig.drive.mail);
    TEST_ASSERT_FALSE(rig.drive.steady);
    rig_step(&rig);
    TEST_ASSERT_FALSE(rig.drive.mail);
    TEST_ASSERT_TRUE(rig.drive.steady);
    TEST_ASSERT_EQUAL_FLOAT(90.0f, rig.drive.command.speed_rad_s);
}

/// The current that trips is the one that telemetry tells.
static void test_the_current_of_a_trip_is_reported(void) {
    rig_t rig = running(80.0, 8.0);
    rig_run(&rig, 1.0);
    rig.motor.id = -25.0;
    rig.motor.iq = 3.0;
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_FAULT);
    const lode_telemetry_t t = rig_telemetry(&rig);
    CHECK_NEAR(1.0, -25.0, t.i_A.d); // the angle is a period old
    CHECK_NEAR(0.1, hypot(25.0, 3.0), hypot((double)t.i_A.d, (double)t.i_A.q));
    // In the channels of a recorder too.
    CHECK_NEAR(0.1, hypot(25.0, 3.0),
               hypot((double)lode_channel_read(&rig.drive, LODE_CHANNEL_I_ALPHA),
                     (double)lode_channel_read(&rig.drive, LODE_CHANNEL_I_BETA)));
}

/// A flag of the mailbox that is neither full nor empty trips; then the mailbox is empty, the command is OFF, and all is as
/// after any other fault.
static void test_after_a_mailbox_that_lies_the_drive_can_be_started_again(void) {
    rig_t rig = running(80.0, 8.0);
    rig.drive.command_posted = (uint_least8_t)(LODE_POST_FULL ^ 4u);
    rig_run(&rig, 16.0 * RIG_TS_s);
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_MEMORY, fault.check);
    CHECK_NEAR(0.0, 2.0, fault.measured);
    CHECK_NEAR(0.0, 0.0, fault.limit);
    TEST_ASSERT_EQUAL_INT(LODE_POST_NONE, rig.drive.command_posted);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig.drive.command.mode);
    TEST_ASSERT_EQUAL_UINT(lode_mode_order_check(&rig.drive.command), rig.drive.command.check);
    rig_command(&rig, clear);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
    run_up(&rig, 80.0, 8.0);
}

/// Whatever lock it finds after that: a third of the guard's time is left.
static void test_an_estimate_of_no_motor_is_a_lost_lock(void) {
    const float values[] = {1.8e20f, -1.8e20f, NAN, INFINITY};
    for (int n = 0; n < 2 * COUNT_OF(values); n++) {
        rig_t rig = running(80.0, 8.0);
        rig_run(&rig, 2.0); // the start is proven
        lode_estimator_t *estimator = &rig.drive.estimator;
        float *word = n % 2 == 0 ? &estimator->emf.observer.e_V.alpha : &estimator->pll.omega_rad_s;
        *word = values[n / 2];
        rig_run(&rig, 5.0e-3 + ((double)LODE_SLOW_PERIODS + 2.0) * RIG_TS_s);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_LOST_LOCK",
                                 lode_check_name(rig_telemetry(&rig).fault.check));
    }
}

/// A post that the flags hide from a steady drive is found within a round.
static void test_a_post_that_is_not_notified_is_found(void) {
    rig_t rig = steady();
    rig_command(&rig, off);
    rig.drive.mail = false;
    rig.drive.steady = true;
    rig_run(&rig, 2.0 * (double)LODE_SLOW_PERIODS * RIG_TS_s);
    rig_expect(&rig, LODE_MODE_OFF);
}

/// What the guard had counted before the low sides come does not count.
static void test_the_guard_counts_anew_from_the_low_sides_on(void) {
    rig_t rig = coasting(0.0);
    rig.drive.guard.bus = rig.drive.guard.rail = 3u;
    rig_command(&rig, run_at(80.0));
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_PRECHARGE);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.bus);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.rail);
}

static void test_over_current_of_either_sign_in_the_same_call(void) {
    for (int phase = 0; phase < 3; phase++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            rig_t rig = holding();
            lode_counts_t counts = rig_counts(&rig);
            counts.i[phase] = (uint16_t)(2048 + sign * 1500); // 18.75 A of 18 A
            const lode_drive_out_t out = lode_drive_step(&rig.drive, &counts);
            TEST_ASSERT_TRUE(is_idle(out));
            const lode_fault_t fault = rig_telemetry(&rig).fault;
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, fault.check);
            TEST_ASSERT_EQUAL_INT(LODE_MODE_CURRENT, fault.state);
            CHECK_NEAR(1.0e-3, sign * 18.75, fault.measured);
            CHECK_NEAR(1.0e-3, 18.0, fault.limit);
            rig_expect(&rig, LODE_MODE_FAULT);
        }
    }
}

static void test_hardware_trip_in_the_same_call(void) {
    rig_t rig = holding();
    rig.trip = true;
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, rig_telemetry(&rig).fault.check);
}

static bool is_shorted(lode_drive_out_t out) {
    return out.gates == LODE_GATES_LOW && out.duty.a == 0.0f && out.duty.b == 0.0f &&
           out.duty.c == 0.0f;
}

/// Low sides on from the call of the fault on, until somebody says otherwise.
static void test_a_fault_shorts_the_motor_where_that_is_commanded(void) {
    rig_t rig = holding();
    rig_command(&rig, (lode_command_t){
                          .mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}, .active_short = true});
    rig_run(&rig, 0.01);
    TEST_ASSERT_EQUAL_INT(LODE_GATES_ON, rig.out.gates);
    rig.sag_V = 150.0;
    for (int n = 0; n < 100 && rig.out.gates == LODE_GATES_ON; n++) {
        rig_step(&rig);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_UNDER_VOLTAGE, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_TRUE(is_shorted(rig.out));
    rig_run(&rig, 0.01);
    TEST_ASSERT_TRUE(is_shorted(rig.out));
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF});
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .active_short = true});
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_shorted(rig.out));
    rig_command(&rig,
                (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true, .active_short = true});
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out)); // OFF is off
    rig_expect(&rig, LODE_MODE_OFF);
}

/// A switch may be shorted: the low sides come only when somebody has looked at it, and says OFF.
static void test_a_trip_by_current_shorts_nothing_by_itself(void) {
    for (int by_hardware = 0; by_hardware <= 1; by_hardware++) {
        rig_t rig = holding();
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT,
                                           .vector = {4.0f, 0.0f},
                                           .active_short = true});
        rig_run(&rig, 0.01);
        lode_counts_t counts = rig_counts(&rig);
        counts.trip = by_hardware == 1;
        counts.i[0] = by_hardware == 1 ? counts.i[0] : 548u;
        TEST_ASSERT_TRUE(is_idle(lode_drive_step(&rig.drive, &counts)));
        counts.i[0] = 2048u;
        TEST_ASSERT_TRUE(is_idle(lode_drive_step(&rig.drive, &counts)));
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .active_short = true});
        TEST_ASSERT_TRUE(is_shorted(lode_drive_step(&rig.drive, &counts)));
    }
}

/// The current of phase a, 18.75 A of 18 A, that flows on after a trip for so many periods: the check.
static uint32_t after_current(rig_t *rig, int sign, int periods) {
    lode_counts_t counts = rig_counts(rig);
    counts.i[0] = (uint16_t)(2048 + sign * 1500);
    counts.i[1] = counts.i[2] = (uint16_t)(2048 - sign * 750);
    for (int n = 0; n < periods; n++) {
        (void)lode_drive_step(&rig->drive, &counts);
    }
    return rig_telemetry(rig).fault.check;
}

/// A sound bridge stops the current; 1 ms is five periods, and the decay four more.
static void test_a_current_that_flows_on_is_a_shorted_switch(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = holding();
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, sign, 9));
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, sign, 1));
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        CHECK_NEAR(1.0e-3, sign * 18.75, fault.measured);
        CHECK_NEAR(1.0e-3, 18.0, fault.limit);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_CURRENT, fault.state);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, -sign, 20));
        CHECK_NEAR(1.0e-3, sign * 18.75, rig_telemetry(&rig).fault.measured);
    }
    rig_t rig = holding();
    rig.trip = true;
    rig_step(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, 1, 9));
    CHECK_NEAR(1.0e-3, 18.0, rig_telemetry(&rig).fault.limit);
}

/// What was counted after one fault does not count after the next.
static void test_each_fault_has_a_count_of_its_own(void) {
    rig_t rig = holding();
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, 1, 9));
    lode_mode_switch_off(&rig.drive);
    lode_guard_reset(&rig.drive.guard);
    lode_mode_fault(&rig.drive, LODE_CHECK_CURRENT_GAIN, 0.5f, 1.0f);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_GAIN, after_current(&rig, 1, 9));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, 1, 1));
}

/// With a high side shorted the low sides would short the bus, whatever is commanded.
static void test_a_shorted_high_side_is_never_joined_by_the_low_sides(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int says_off = 0; says_off <= 1; says_off++) {
            rig_t rig = holding();
            rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT,
                                               .vector = {4.0f, 0.0f},
                                               .active_short = true});
            rig_step(&rig);
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, sign, 10));
            if (says_off == 1) {
                rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .active_short = true});
            }
            const lode_counts_t counts = rig_counts(&rig);
            const lode_drive_out_t out = lode_drive_step(&rig.drive, &counts);
            TEST_ASSERT_EQUAL_INT(says_off == 1 && sign < 0, is_shorted(out));
            TEST_ASSERT_EQUAL_INT(says_off == 0 || sign > 0, is_idle(out));
        }
    }
}

/// What a short may show first, and nothing else, waits for a look and is named by it.
static void test_what_a_short_may_show_first_is_suspect(void) {
    static const lode_check_t suspects[] = {LODE_CHECK_HARDWARE_TRIP, LODE_CHECK_OVER_CURRENT,
                                            LODE_CHECK_CURRENT_RAIL, LODE_CHECK_CURRENT_GAIN};
    for (int check = 1; check < (int)LODE_CHECK_COUNT; check++) {
        bool suspect = false;
        for (int n = 0; n < COUNT_OF(suspects); n++) {
            suspect = suspect || check == (int)suspects[n];
        }
        rig_t rig = holding();
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT,
                                           .vector = {4.0f, 0.0f},
                                           .active_short = true});
        rig_step(&rig);
        rig.trip = true;
        rig_step(&rig);
        rig.drive.guard.fault.check = (uint_least8_t)check;
        rig.drive.guard.fault.measured = -1.0f;
        const lode_counts_t counts = rig_counts(&rig);
        rig_t looks = rig;
        const bool named = check == (int)LODE_CHECK_SWITCH_SHORTED;
        TEST_ASSERT_EQUAL_INT(!suspect && !named, is_shorted(lode_drive_step(&rig.drive, &counts)));
        TEST_ASSERT_EQUAL_INT(suspect || named,
                              after_current(&looks, -1, 9) == (uint32_t)LODE_CHECK_SWITCH_SHORTED);
    }
}

/// A clear that was posted before the fault does not hide it.
static void test_a_fault_is_told_for_a_period_at_least(void) {
    rig_t rig = holding();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true});
    rig.trip = true;
    rig_step(&rig);
    rig.trip = false;
    rig_expect(&rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_EQUAL_UINT(1u, rig_telemetry(&rig).trips);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
    TEST_ASSERT_EQUAL_UINT(1u, rig_telemetry(&rig).trips);
    // Nor does one that was taken clear the next fault with a later command.
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
    TEST_ASSERT_FALSE(((uint32_t)rig.drive.posted.flags & (uint32_t)LODE_ORDER_CLEAR_FAULT) != 0u);
}

/// A fault of 62 A and more is beyond what 12 bits show: the phase in the middle still tells the side.
static void test_samples_at_the_rails_tell_the_side_too(void) {
    for (int high = 0; high <= 1; high++) {
        rig_t rig = holding();
        rig.trip = true;
        rig_step(&rig);
        rig.trip = false;
        lode_counts_t counts = rig_counts(&rig);
        counts.i[0] = high == 1 ? 0u : 4095u;
        counts.i[1] = high == 1 ? 4095u : 0u;
        counts.i[2] = high == 1 ? 1548u : 2548u;
        for (int n = 0; n < 9; n++) {
            (void)lode_drive_step(&rig.drive, &counts);
        }
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, fault.check);
        TEST_ASSERT_TRUE(high == 1 ? fault.measured > 25.0f : fault.measured < -25.0f);
    }
}

/// A side that changes, or a current in two phases alone, is no shorted switch.
static void test_a_shorted_switch_shows_one_side(void) {
    rig_t rig = holding();
    (void)after_current(&rig, 1, 1);
    for (int n = 0; n < 10; n++) {
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, n % 2 == 0 ? 1 : -1, 8));
    }
    rig = holding();
    (void)after_current(&rig, 1, 1);
    const lode_counts_t sound = rig_counts(&rig);
    for (int k = -1; k <= 1; k++) { // the third one has a little by its offset
        rig_t two_phases = rig;
        lode_counts_t counts = sound;
        counts.i[0] = 3548u;
        counts.i[1] = 548u;
        counts.i[2] = (uint16_t)(2048 + 20 * k);
        for (int n = 0; n < 50; n++) {
            (void)lode_drive_step(&two_phases.drive, &counts);
        }
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, rig_telemetry(&two_phases).fault.check);
    }
}

static void test_other_currents_with_the_gates_off_are_no_shorted_switch(void) {
    rig_t rig = holding();
    rig.trip = true;
    rig_run(&rig, 0.01); // a trip input that stays, without current
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, rig_telemetry(&rig).fault.check);
    rig = holding();
    rig.sag_V = 150.0;
    rig_run(&rig, 0.01); // of another cause
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_UNDER_VOLTAGE, after_current(&rig, 1, 50));
    // 221 V between the lines, by the diodes of a sound bridge: a sixth of a turn each way.
    rig = holding();
    (void)after_current(&rig, 1, 1);
    rig.drive.estimator.pll.omega_rad_s = 900.0f;
    for (int n = 0; n < 50; n++) {
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, n % 2 == 0 ? 1 : -1, 6));
    }
    // One that keeps its side for half a turn, 17 periods, and what it takes below.
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, 1, 25));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, 1, 1));
    rig = holding();
    (void)after_current(&rig, 1, 1);
    rig.drive.estimator.pll.omega_rad_s = -800.0f; // 197 V of 200 V
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, 1, 10));
    rig = holding();
    (void)after_current(&rig, 1, 1);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .active_short = true});
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, 1, 50)); // its own
    rig = fresh();
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, after_current(&rig, 1, 50)); // OFF
}

static void test_a_single_sample_at_the_rail_passes(void) {
    lode_drive_config_t config = rig_config();
    config.guard.i_trip_A = 2047.0f * (float)RIG_GAIN_A; // what the highest count says
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
    rig_run(&rig, 0.1);
    lode_counts_t counts = rig_counts(&rig);
    counts.i[0] = 4095u;
    TEST_ASSERT_TRUE(lode_drive_step(&rig.drive, &counts).gates);
    rig_run(&rig, 0.1);
    rig_expect(&rig, LODE_MODE_CURRENT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    for (int n = 0; n < 10; n++) { // of the 5 periods in 1 ms
        (void)lode_drive_step(&rig.drive, &counts);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_RAIL, rig_telemetry(&rig).fault.check);
}

static void test_a_call_that_is_late_trips_at_once(void) {
    lode_drive_config_t config = rig_config();
    config.guard.stamp_per_period = 1000.0f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
    rig_run(&rig, 0.1);
    TEST_ASSERT_TRUE(rig.out.gates);
    rig.stamp += 1000u; // one was left out
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_TIMING, fault.check);
    TEST_ASSERT_EQUAL_FLOAT(2000.0f, fault.measured);
}

static void test_bus_out_of_range_trips_after_its_debounce(void) {
    const uint16_t buses[] = {2600, 1100}; // 260 V of 250 V, 110 V of 120 V
    const lode_check_t checks[] = {LODE_CHECK_OVER_VOLTAGE, LODE_CHECK_UNDER_VOLTAGE};
    for (int i = 0; i < COUNT_OF(buses); i++) {
        rig_t rig = holding();
        lode_counts_t counts = rig_counts(&rig);
        counts.v_bus = buses[i];
        // 1 ms are two looks of the slow checks, each 0.8 ms: one is under way.
        int periods = 1;
        while (lode_drive_step(&rig.drive, &counts).gates && periods < 100) {
            periods++;
        }
        CHECK_AT_LEAST(0.5 * LODE_SLOW_PERIODS + 1.0, periods);
        CHECK_AT_MOST(LODE_SLOW_PERIODS, periods);
        TEST_ASSERT_EQUAL_INT(checks[i], rig_telemetry(&rig).fault.check);
    }
}

static void test_a_fault_stays_until_it_is_cleared(void) {
    rig_t rig = holding();
    rig.trip = true;
    rig_step(&rig);
    rig.trip = false;
    const lode_fault_t first = rig_telemetry(&rig).fault;
    const lode_command_t commands[] = {off,
                                       run_at(50.0),
                                       {.mode = LODE_MODE_CURRENT, .vector = {1.0f, 0.0f}},
                                       {.mode = LODE_MODE_CALIBRATE}};
    for (int i = 0; i < COUNT_OF(commands); i++) {
        rig_command(&rig, commands[i]);
        rig_run(&rig, 0.3);
        rig_expect(&rig, LODE_MODE_FAULT);
        TEST_ASSERT_TRUE(is_idle(rig.out));
        const lode_fault_t now = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_INT(first.check, now.check);
        TEST_ASSERT_EQUAL_INT(first.state, now.state);
        TEST_ASSERT_TRUE(first.measured == now.measured && first.limit == now.limit);
    }
    const lode_command_t both = {.mode = LODE_MODE_RUN, .speed_rad_s = 50.0f, .clear_fault = true};
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_COMMAND, lode_drive_post_command(&rig.drive, &both));
    rig_command(&rig, clear);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {1.0f, 0.0f}});
    rig_step(&rig);
    rig_step(&rig);
    TEST_ASSERT_TRUE(rig.out.gates);
}

/// A command that replaces one which clears a fault, before it is taken, clears it too; but it alone, and no fault after it.
static void test_a_fault_is_cleared_by_a_command_that_is_replaced(void) {
    for (int n = 0; n < 3; n++) {
        rig_t rig = holding();
        rig.trip = n < 2;
        rig_step(&rig);
        rig.trip = false;
        rig_command(&rig, clear);
        if (n == 1) {
            rig_command(&rig, off);
        }
        rig_command(&rig, run_at(50.0));
        rig_step(&rig);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
        rig_run(&rig, 0.3);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
        TEST_ASSERT_TRUE(rig.out.gates);
        rig.trip = true; // the command is RUN still
        rig_step(&rig);
        rig.trip = false;
        rig_run(&rig, 0.3);
        rig_expect(&rig, LODE_MODE_FAULT);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, rig_telemetry(&rig).fault.check);
    }
}

/// The dead time that a start may have measured is limited. One beyond that trips within a round; a tuning that allows less
/// is none.
static void test_a_measured_dead_time_has_become_another(void) {
    const rig_t sound = running(80.0, 8.0);
    const float most = sound.drive.tuning->inverter.dead_more_max;
    TEST_ASSERT_TRUE(most > 0.0f);
    const float wrong[] = {1.01f * most, -1.01f * most, NAN};
    for (int n = 0; n < COUNT_OF(wrong); n++) {
        rig_t rig = sound;
        rig.drive.inverter.dead_more = wrong[n];
        rig_run(&rig, 9.0 * RIG_TS_s);
        rig_expect(&rig, LODE_MODE_FAULT);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_MEMORY, rig_telemetry(&rig).fault.check);
    }
    for (int n = 0; n < 2; n++) {
        rig_t rig = sound;
        const float sign = n == 0 ? 1.0f : -1.0f;
        rig.drive.inverter.dead_more = sign * most;
        rig_step(&rig);
        static lode_drive_tuning_t less;
        less = *sound.drive.tuning;
        less.inverter.dead_more_max = 0.9f * most;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &less));
        rig_step(&rig);
        TEST_ASSERT_EQUAL_FLOAT(0.9f * sign * most, rig.drive.inverter.dead_more);
    }
}

/// One bit of the drive flips, `offset` bytes from its beginning. Gates off within a round, and the fault says
/// what it was.
static void check_flip(const rig_t *sound, size_t offset, int bit, float which) {
    rig_t rig = *sound;
    const lode_mode_t before = rig_telemetry(&rig).mode;
    unsigned char *octet = (unsigned char *)&rig.drive + offset;
    *octet = (unsigned char)(*octet ^ (1u << bit));
    for (uint32_t k = 0; k <= LODE_SLOW_PERIODS; k++) {
        rig_step(&rig);
    }
    char text[60];
    (void)snprintf(text, sizeof text, "%s, byte %d, bit %d", lode_mode_name(before), (int)offset,
                   bit);
    const lode_telemetry_t after = rig_telemetry(&rig);
    TEST_ASSERT_TRUE_MESSAGE(is_idle(rig.out), text);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("LODE_CHECK_MEMORY", lode_check_name(after.fault.check), text);
    TEST_ASSERT_TRUE_MESSAGE(after.fault.measured == which, text);
    rig_command(&rig, clear);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
}

static void test_a_mode_or_command_that_changes_by_itself_trips(void) {
    rig_t rigs[4];
    rigs[0] = fresh();
    rigs[1] = fresh();
    rig_command(&rigs[1], (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    rig_step(&rigs[1]);
    rigs[2] = holding();
    rigs[3] = fresh();
    rig_command(&rigs[3], run_at(100.0));
    TEST_ASSERT_TRUE(reach(&rigs[3], LODE_MODE_RUN, 8.0));
    for (int n = 0; n < COUNT_OF(rigs); n++) {
        for (int bit = 0; bit < 8; bit++) {
            check_flip(&rigs[n], offsetof(lode_drive_t, mode), bit, 1.0f);
            check_flip(&rigs[n], offsetof(lode_drive_t, mode_not), bit, 1.0f);
        }
        check_flip(&rigs[n], offsetof(lode_drive_t, gates), 0, 1.0f);
        if (n < 3) { // running, the flag is set
            check_flip(&rigs[n], offsetof(lode_drive_t, steady), 0, 1.0f);
        }
        const size_t order = offsetof(lode_drive_t, command);
        const size_t speed = order + offsetof(lode_order_t, speed_rad_s);
        const size_t value = order + offsetof(lode_order_t, value);
        for (int bit = 0; bit < 32; bit++) {
            check_flip(&rigs[n], speed + (size_t)bit / 8u, bit % 8, 2.0f);
            check_flip(&rigs[n], value + (size_t)bit / 8u, bit % 8, 2.0f);
        }
        for (int bit = 0; bit < 8; bit++) {
            check_flip(&rigs[n], order + offsetof(lode_order_t, flags), bit, 2.0f);
            check_flip(&rigs[n], order + offsetof(lode_order_t, mode), bit, 2.0f);
        }
        for (int bit = 0; bit < 8; bit++) {
            check_flip(&rigs[n], offsetof(lode_drive_t, command_posted), bit, 2.0f);
        }
        for (int bit = 0; bit < 31; bit++) { // without its sign
            check_flip(&rigs[n], offsetof(lode_drive_t, direction) + (size_t)bit / 8u, bit % 8,
                       1.0f);
        }
    }
}

/// A drive in RUN whose speed control runs more often than its slot.
static rig_t running_with_fast_speed(void) {
    lode_drive_config_t config = rig_config();
    config.motor.omega_rated_rad_s = 400.0f;
    config.speed.bandwidth_rad_s = 70.0f;
    config.speed.gain_rise = 1.0f;
    config.estimator.pll.sigma_rad_s = 300.0f;
    config.start.omega_handover_rad_s = 100.0f; // where there is EMF enough for so wide a PLL
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
    rig_run(&rig, 0.1);
    TEST_ASSERT_FALSE(rig.drive.steady);
    return rig;
}

/// It has no steady way, which would leave speed control out for good.
static void test_speed_control_that_is_left_out_trips(void) {
    const rig_t rig = running_with_fast_speed();
    check_flip(&rig, offsetof(lode_drive_t, steady), 0, 1.0f);
}

/// One that has run for this long, and whose next call does the job of `slot`.
static rig_t before_slot(lode_slot_t slot, double run_s) {
    rig_t rig = running(80.0, 8.0);
    rig_run(&rig, run_s);
    for (uint32_t n = 0; n < LODE_SLOW_PERIODS && lode_slot_of(rig.drive.steps) != slot; n++) {
        rig_step(&rig);
    }
    TEST_ASSERT_EQUAL_INT(slot, lode_slot_of(rig.drive.steps));
    TEST_ASSERT_TRUE(rig.drive.estimator.locked);
    return rig;
}

/// The next step trips for corrupted memory of this kind; 0: it does not.
static void check_memory(rig_t rig, float which) {
    rig_step(&rig);
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    const lode_check_t check = which > 0.0f ? LODE_CHECK_MEMORY : LODE_CHECK_NONE;
    TEST_ASSERT_EQUAL_STRING(lode_check_name(check), lode_check_name(fault.check));
    TEST_ASSERT_TRUE(fault.measured == which);
    TEST_ASSERT_EQUAL_INT(which > 0.0f, is_idle(rig.out));
}

/// A flipped bit of the application's limits; they hold no torque back that is allowed, and none is allowed that is not.
static void test_a_torque_limit_that_changes_by_itself_trips(void) {
    const float shares[] = {1.0f, 0.7f, 0.3f, 0.0f};
    rig_t sound = before_slot(SLOT_DEAD_TIME, 0.1);
    for (int n = 0; n < COUNT_OF(shares); n++) {
        lode_drive_limit_torques(&sound.drive, shares[n], shares[COUNT_OF(shares) - 1 - n]);
        check_memory(sound, 0.0f);
        for (uint32_t bit = 0u; bit < 32u; bit++) {
            rig_t rig = sound;
            rig.drive.torque_share[bit / 16u] =
                (uint_least16_t)(rig.drive.torque_share[bit / 16u] ^ (1u << bit % 16u));
            check_memory(rig, 6.0f);
        }
    }
}

/// (P30), from the configuration: the longest vector of currents below the trip limit, and no friction.
static double most_acceleration(void) {
    const lode_drive_config_t c = rig_config();
    const double i_A = 2.0 / sqrt(3.0) * 1.5 * (double)c.inverter.i_max_A;
    const double np = (double)c.motor.pole_pairs;
    const double flux_Wb =
        (double)c.motor.psi_Wb + fabs((double)c.motor.Ld_H - (double)c.motor.Lq_H) * i_A;
    const double friction = (double)c.motor.B_Nms / (double)c.motor.J_kgm2;
    return 1.6 * 1.5 * np * np / (double)c.motor.J_kgm2 * flux_Wb * i_A +
           friction * (double)tuning.estimator.omega_limit;
}

/// Speed and disturbance of the estimate move no more than the PLL can move them in a round, whatever the error.
static void test_a_motion_that_changes_by_itself_trips(void) {
    const rig_t sound = before_slot(SLOT_GAINS, 1.5);
    const lode_estimator_t *estimator = &sound.drive.estimator;
    const double round_s = 8.0 * RIG_TS_s;
    const double errors = 8.0 * 1.65;
    const double f_moves = errors * (double)estimator->gains.f_s2;
    const double acc = fabs((double)estimator->f_noted) + f_moves + most_acceleration();
    const double omega_moves = errors * (double)estimator->gains.omega_s + round_s * acc;
    CHECK_NEAR(1.0e-4 * most_acceleration(), most_acceleration(), tuning.estimator.acc_most);
    TEST_ASSERT_TRUE(omega_moves < 0.5 * fabs((double)estimator->omega_noted)); // a sign shows
    check_memory(sound, 0.0f);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int n = 0; n < 2; n++) {
            const double share = (double)sign * (n == 0 ? 0.95 : 1.05);
            rig_t rig = sound;
            rig.drive.estimator.pll.f_rad_s2 = estimator->f_noted + (float)(share * f_moves);
            check_memory(rig, n == 0 ? 0.0f : 4.0f);
            rig = sound;
            rig.drive.estimator.pll.omega_rad_s =
                estimator->omega_noted + (float)(share * omega_moves);
            check_memory(rig, n == 0 ? 0.0f : 4.0f);
            rig = sound; // without a lock, all of it is acquired anew
            rig.drive.estimator.locked = false;
            rig.drive.estimator.pll.f_rad_s2 = estimator->f_noted + (float)(share * f_moves);
            check_memory(rig, 0.0f);
        }
    }
}

/// A motion that is set from outside is none that the PLL has made.
static void test_a_motion_that_is_set_is_no_change_by_itself(void) {
    const rig_t sound = before_slot(SLOT_GAINS, 1.5);
    rig_t rig = sound;
    rig.drive.estimator.pll.f_rad_s2 += 1.0e5f;
    check_memory(rig, 4.0f);
    lode_estimator_forget_motion(&rig.drive.estimator);
    check_memory(rig, 0.0f);
    rig = sound;
    rig.drive.estimator.pll.f_rad_s2 += 1.0e5f;
    lode_estimator_retune(&rig.drive.estimator, &tuning.estimator, &tuning.estimator);
    check_memory(rig, 0.0f);
    rig = sound;
    const lode_counts_t counts = rig_counts(&rig);
    const lode_sample_t sample = lode_drive_sense(&rig.drive, &counts);
    lode_estimate_t external = lode_drive_estimate(&rig.drive, &sample);
    external.source = LODE_ESTIMATE_EXTERNAL;
    external.load_torque_Nm += 100.0f;
    (void)lode_drive_act(&rig.drive, &sample, &external);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    // From the end of the slot on the own estimate counts again, unless it has no lock.
    TEST_ASSERT_TRUE(rig.drive.estimator.omega_noted == rig.drive.estimator.pll.omega_rad_s);
    TEST_ASSERT_TRUE(rig.drive.estimator.f_noted == rig.drive.estimator.pll.f_rad_s2);
    rig = sound;
    rig.drive.estimator.locked = false;
    rig_step(&rig);
    TEST_ASSERT_TRUE(rig.drive.estimator.omega_noted == 0.0f);
}

/// Integral and reference of speed control are kept twice. Whichever slot comes next, a flipped bit ends RUN before it moves the
/// torque.
static void check_speed_flips(rig_t sound) {
    const size_t speed = offsetof(lode_drive_t, state) + offsetof(lode_running_t, speed);
    const size_t copy = speed + offsetof(lode_speed_t, copy);
    const size_t fields[] = {speed + offsetof(lode_speed_t, pi),
                             speed + offsetof(lode_speed_t, reference_rad_s),
                             copy + offsetof(lode_speed_copy_t, integral_Nm),
                             copy + offsetof(lode_speed_copy_t, reference_rad_s)};
    for (uint32_t slot = 0u; slot < LODE_SLOW_PERIODS; slot++) {
        for (int n = 0; n < COUNT_OF(fields); n++) {
            for (int bit = 0; bit < 32; bit++) {
                check_flip(&sound, fields[n] + (size_t)bit / 8u, bit % 8, 5.0f);
            }
        }
        rig_step(&sound);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, sound.drive.mode);
    }
}

/// The resistance that a start may have measured is limited too, and what a new tuning leaves of it.
static void test_a_measured_resistance_has_become_another(void) {
    const rig_t sound = before_slot(SLOT_DEAD_TIME, 0.5);
    const float most = 2.0f * sound.drive.tuning->start.R_Ohm;
    const float wrong[] = {1.01f * most, -1.01f * most, NAN, 0.99f * most, -0.99f * most};
    for (int n = 0; n < COUNT_OF(wrong); n++) {
        rig_t rig = sound;
        rig.drive.inverter.r_more_Ohm = wrong[n];
        check_memory(rig, n < 3 ? 7.0f : 0.0f);
    }
    for (int n = 0; n < 2; n++) {
        rig_t rig = sound;
        const float sign = n == 0 ? 1.0f : -1.0f;
        rig.drive.inverter.r_more_Ohm = sign * 0.9f * most;
        static lode_drive_tuning_t other;
        other = *sound.drive.tuning;
        other.start.R_Ohm *= n == 0 ? 0.5f : 1.5f;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other));
        rig_step(&rig);
        // 1.8 R + 0.5 R, of at most 2 x 0.5 R; -1.8 R - 0.5 R, of at most 2 x 1.5 R
        CHECK_CLOSE(1.0e-5, (n == 0 ? 0.5 : -1.15) * (double)most, rig.drive.inverter.r_more_Ohm);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    }
}

/// What rounding has left out of the reference is less than its last digit: more would move the reference.
static void test_a_rest_beyond_rounding_trips(void) {
    const rig_t sound = before_slot(SLOT_DEAD_TIME, 0.5);
    const float rests[] = {0.009f, 0.011f, -0.011f, 1.0e30f, NAN};
    for (int n = 0; n < COUNT_OF(rests); n++) {
        rig_t rig = sound;
        rig.drive.state.run.speed.left_rad_s = rests[n];
        rig_step(&rig);
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_STRING(lode_check_name(n > 0 ? LODE_CHECK_MEMORY : LODE_CHECK_NONE),
                                 lode_check_name(fault.check));
        TEST_ASSERT_EQUAL_FLOAT(n > 0 ? 5.0f : 0.0f, fault.measured);
    }
}

/// A tuning with another observer, posted in FAULT, leaves what telemetry says of the trip.
static void test_a_tuning_leaves_what_it_was_at_the_trip(void) {
    rig_t rig = running(80.0, 8.0);
    rig.trip = true;
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_FAULT);
    const lode_telemetry_t before = rig_telemetry(&rig);
    TEST_ASSERT_TRUE(lode_abs(before.e_V.alpha) + lode_abs(before.e_V.beta) > 1.0f);
    lode_drive_config_t config = rig_config();
    config.estimator.emf.kind = LODE_EMF_FA_LESO;
    lode_drive_tuning_t other;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other, &config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other));
    rig_run(&rig, 2.0 * LODE_SLOW_PERIODS * RIG_TS_s);
    TEST_ASSERT_TRUE(lode_drive_tuning_taken(&rig.drive));
    const lode_telemetry_t after = rig_telemetry(&rig);
    TEST_ASSERT_EQUAL_FLOAT(before.e_V.alpha, after.e_V.alpha);
    TEST_ASSERT_EQUAL_FLOAT(before.e_V.beta, after.e_V.beta);
    TEST_ASSERT_EQUAL_FLOAT(before.omega_rad_s, after.omega_rad_s);
    TEST_ASSERT_EQUAL_FLOAT(before.lock, after.lock);
}

static void test_a_speed_control_that_changes_by_itself_trips(void) {
    rig_t rig = before_slot(SLOT_DEAD_TIME, 0.5);
    TEST_ASSERT_TRUE(rig.drive.state.run.speed.pi.integral != 0.0f);
    check_speed_flips(rig);
    rig.drive.command.flags |= (uint_least8_t)LODE_ORDER_TORQUE;
    rig.drive.command.value.torque_Nm = 0.3f;
    rig.drive.command.check = lode_mode_order_check(&rig.drive.command);
    rig_run(&rig, 0.01);
    check_speed_flips(rig);
    check_speed_flips(running_with_fast_speed());
}

/// The other direction than that in which the rotor turns: it slows down as for a reversal, and starts anew.
static void test_a_direction_that_turns_over_starts_anew(void) {
    rig_t rig = running(80.0, 8.0);
    rig.drive.direction = -rig.drive.direction;
    rig_run(&rig, 0.1);
    rig_expect(&rig, LODE_MODE_START);
    run_up(&rig, 80.0, 8.0);
    CHECK_NEAR(0.0, 1.0, rig.drive.direction);
}

/// What current control has of the q axis, beside the tuning, is renewed in each round.
static void test_a_q_axis_that_changes_by_itself_does_not_last(void) {
    rig_t rig = running(80.0, 8.0);
    const lode_current_t sound = rig.drive.current;
    rig.drive.current.kp_q_V_A = 1.01f * sound.kp_q_V_A;
    rig.drive.current.Lq_H = -sound.Lq_H;
    for (uint32_t n = 0; n < LODE_SLOW_PERIODS; n++) {
        rig_step(&rig);
    }
    TEST_ASSERT_EQUAL_FLOAT(sound.kp_q_V_A, rig.drive.current.kp_q_V_A);
    TEST_ASSERT_EQUAL_FLOAT(sound.Lq_H, rig.drive.current.Lq_H);
    TEST_ASSERT_EQUAL_FLOAT(tuning.references.Lq_H, rig.drive.current.Lq_H);
}

/// A bit of the mailbox flips between a post and the call that takes it: the command is followed, or the drive
/// says that it is lost.
static void test_a_posted_command_is_not_lost_by_a_flip(void) {
    const lode_command_t calibrate = {.mode = LODE_MODE_CALIBRATE};
    for (int bit = 0; bit < 8; bit++) {
        rig_t rig = fresh();
        rig_command(&rig, calibrate);
        unsigned char *flag = (unsigned char *)&rig.drive.command_posted;
        *flag = (unsigned char)(*flag ^ (1u << bit));
        rig_step(&rig);
        rig_step(&rig);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_MEMORY",
                                 lode_check_name(rig_telemetry(&rig).fault.check));
    }
    rig_t rig = fresh();
    rig_command(&rig, calibrate);
    rig.drive.mail = false;
    rig_step(&rig);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_CALIBRATE);
    rig = fresh();
    rig_command(&rig, calibrate);
    rig.drive.mail = false;
    rig.drive.mode = (uint_least8_t)LODE_MODE_START;
    rig_step(&rig); // what is wrong besides is named
    TEST_ASSERT_TRUE(rig_telemetry(&rig).fault.measured == 1.0f);
    rig = fresh();
    run_up(&rig, 100.0, 8.0);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF});
    rig.drive.mail = false;
    for (uint32_t n = 0; n <= 2u * LODE_SLOW_PERIODS; n++) {
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_OFF);
}

static void test_after_a_trip_the_telemetry_keeps_what_the_drive_was_doing(void) {
    rig_t rig = fresh();
    rig.load_Nm = 1.0;
    run_up(&rig, 100.0, 8.0);
    rig_run(&rig, 1.0);
    const lode_telemetry_t before = rig_telemetry(&rig);
    rig.trip = true;
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_run(&rig, 0.1);
    const lode_telemetry_t after = rig_telemetry(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_FAULT, after.mode);
    TEST_ASSERT_TRUE(lode_abs(before.i_A.q) > 1.0f && lode_abs(before.u_V.q) > 10.0f);
    // Within what a period moves them.
    CHECK_NEAR(0.5, before.i_A.q, after.i_A.q);
    CHECK_NEAR(0.5, before.ref_A.q, after.ref_A.q);
    CHECK_NEAR(5.0, before.u_V.q, after.u_V.q);
    CHECK_CLOSE(0.01, before.omega_rad_s, after.omega_rad_s);
    CHECK_NEAR(0.5, before.load_torque_Nm, after.load_torque_Nm);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, after.duty.a); // but the legs stand idle
    TEST_ASSERT_TRUE(after.steps > before.steps + 400u);
    rig.trip = false;
    rig_command(&rig, clear);
    rig_step(&rig);
    const lode_telemetry_t cleared = rig_telemetry(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, cleared.mode);
    const float zeros[] = {cleared.i_A.d, cleared.i_A.q,       cleared.ref_A.d,
                           cleared.u_V.d, cleared.u_V.q,       cleared.ref_A.q,
                           cleared.lock,  cleared.omega_rad_s, cleared.load_torque_Nm};
    for (int n = 0; n < COUNT_OF(zeros); n++) {
        TEST_ASSERT_TRUE(zeros[n] == 0.0f);
    }
}

/// Makes `check` trip a drive that runs; `counts` are those of the period.
static void provoke(lode_check_t check, rig_t *rig, lode_counts_t *counts) {
    lode_guard_tuning_t *guard = &other_tuning.guard;
    counts->trip = check == LODE_CHECK_HARDWARE_TRIP;
    counts->i[0] = check == LODE_CHECK_OVER_CURRENT ? 400u : counts->i[0];
    counts->i[0] = check == LODE_CHECK_CURRENT_RAIL ? 4095u : counts->i[0];
    counts->v_bus = check == LODE_CHECK_OVER_VOLTAGE ? 2600u : counts->v_bus;
    counts->v_bus = check == LODE_CHECK_UNDER_VOLTAGE ? 1100u : counts->v_bus;
    counts->temperature = check == LODE_CHECK_OVER_TEMPERATURE ? 2000u : 500u;
    counts->stamp += check == LODE_CHECK_TIMING ? 1000u : 0u;
    guard->omega_max = check == LODE_CHECK_OVER_SPEED ? 1.0f : guard->omega_max;
    rig->drive.direction = check == LODE_CHECK_WRONG_WAY ? -1.0f : rig->drive.direction;
    rig->drive.estimator.lock = check == LODE_CHECK_LOST_LOCK ? 0.2f : rig->drive.estimator.lock;
    other_tuning.inverter.inv_ticks =
        check == LODE_CHECK_NON_FINITE ? NAN : other_tuning.inverter.inv_ticks;
}

/// The row of the fault, in telemetry and in the channels of ring and scope, is that of a drive at work.
static void test_the_row_of_every_fault_keeps_the_values_of_its_step(void) {
    lode_drive_config_t config = rig_config();
    config.guard.stamp_per_period = 1000.0f;
    config.guard.i_trip_A = 20.0f;
    config.sense.temperature_gain_degC_count = 0.1f;
    config.inverter.pwm_ticks = 8400.0f;
    rig_t running;
    rig_init(&running, &tuning, &config);
    running.motor.theta = CALM_rad;
    running.load_Nm = 1.0;
    run_up(&running, 100.0, 8.0);
    rig_run(&running, 1.0);
    for (int check = LODE_CHECK_HARDWARE_TRIP; check <= LODE_CHECK_WRONG_WAY; check++) {
        rig_t rig = running;
        other_tuning = tuning;
        // Whatever the rail is called: the trip's own limit is beyond it.
        other_tuning.guard.i_trip = check == LODE_CHECK_CURRENT_RAIL ? 30.0f : tuning.guard.i_trip;
        rig.drive.tuning = &other_tuning;
        lode_telemetry_t before = rig_telemetry(&rig);
        for (int n = 0; n < 200 && rig.out.gates; n++) {
            rig.stamp += 1000u;
            lode_counts_t counts = rig_counts(&rig);
            provoke((lode_check_t)check, &rig, &counts);
            before = rig_telemetry(&rig);
            rig.out = lode_drive_step(&rig.drive, &counts);
            rig_move(&rig);
        }
        const lode_telemetry_t row = rig_telemetry(&rig);
        TEST_ASSERT_EQUAL_STRING(lode_check_name((lode_check_t)check),
                                 lode_check_name((lode_check_t)row.fault.check));
        const char *name = lode_check_name((lode_check_t)check);
        TEST_ASSERT_TRUE_MESSAGE(lode_abs(row.i_A.q) > 0.5f, name);
        TEST_ASSERT_TRUE_MESSAGE(lode_abs(row.ref_A.q) > 0.1f, name);
        TEST_ASSERT_TRUE_MESSAGE(lode_abs(row.u_V.d) + lode_abs(row.u_V.q) > 10.0f, name);
        TEST_ASSERT_TRUE_MESSAGE(lode_abs(row.u_V.q - before.u_V.q) < 10.0f, name);
        TEST_ASSERT_TRUE_MESSAGE(row.v_bus_V > 100.0f && row.omega_rad_s > 200.0f, name);
        const lode_channel_t alpha = LODE_CHANNEL_I_ALPHA;
        const lode_channel_t beta = LODE_CHANNEL_I_BETA;
        const lode_ab_t i_A = {lode_channel_read(&rig.drive, alpha),
                               lode_channel_read(&rig.drive, beta)};
        TEST_ASSERT_TRUE_MESSAGE(lode_ab_length(i_A) > 0.5f, name);
    }
}

static void test_lost_lock_and_wrong_way_trip_in_20_ms(void) {
    rig_t rig = running(100.0, 8.0);
    rig_run(&rig, 1.0);
    rig_t lost = rig;
    CHECK_AT_MOST(100, steps_until_off(&lost, 0.3f, 1.0f, 1000));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&lost).fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, rig_telemetry(&lost).fault.state);
    rig_t wrong = rig;
    lode_drive_config_t config = rig_config();
    config.guard.overload_s = LODE_NONE; // it sees sooner that all the torque is against that speed
    lode_drive_design(&config);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&wrong.drive, &other_tuning));
    CHECK_AT_MOST(108, steps_until_off(&wrong, 0.9f, -1.0f, 1000));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_WRONG_WAY, rig_telemetry(&wrong).fault.check);
    rig_t fast = rig;
    CHECK_AT_MOST(100, steps_until_off(&fast, 0.9f, 10.0f, 1000));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_SPEED, rig_telemetry(&fast).fault.check);
    rig_t sound = rig;
    TEST_ASSERT_EQUAL_INT(1001, steps_until_off(&sound, 0.9f, 1.0f, 1000));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_every_bit_of_an_order_counts);
    RUN_TEST(test_a_driven_mode_that_became_another_trips_at_once);
    RUN_TEST(test_mail_is_read_once);
    RUN_TEST(test_a_measured_dead_time_has_become_another);
    RUN_TEST(test_a_measured_resistance_has_become_another);
    RUN_TEST(test_the_current_of_a_trip_is_reported);
    RUN_TEST(test_after_a_mailbox_that_lies_the_drive_can_be_started_again);
    RUN_TEST(test_an_estimate_of_no_motor_is_a_lost_lock);
    RUN_TEST(test_a_post_that_is_not_notified_is_found);
    RUN_TEST(test_the_guard_counts_anew_from_the_low_sides_on);
    RUN_TEST(test_over_current_of_either_sign_in_the_same_call);
    RUN_TEST(test_hardware_trip_in_the_same_call);
    RUN_TEST(test_a_fault_shorts_the_motor_where_that_is_commanded);
    RUN_TEST(test_a_trip_by_current_shorts_nothing_by_itself);
    RUN_TEST(test_a_current_that_flows_on_is_a_shorted_switch);
    RUN_TEST(test_each_fault_has_a_count_of_its_own);
    RUN_TEST(test_a_shorted_high_side_is_never_joined_by_the_low_sides);
    RUN_TEST(test_what_a_short_may_show_first_is_suspect);
    RUN_TEST(test_a_fault_is_told_for_a_period_at_least);
    RUN_TEST(test_samples_at_the_rails_tell_the_side_too);
    RUN_TEST(test_a_shorted_switch_shows_one_side);
    RUN_TEST(test_other_currents_with_the_gates_off_are_no_shorted_switch);
    RUN_TEST(test_a_single_sample_at_the_rail_passes);
    RUN_TEST(test_a_call_that_is_late_trips_at_once);
    RUN_TEST(test_bus_out_of_range_trips_after_its_debounce);
    RUN_TEST(test_a_fault_stays_until_it_is_cleared);
    RUN_TEST(test_a_fault_is_cleared_by_a_command_that_is_replaced);
    RUN_TEST(test_a_mode_or_command_that_changes_by_itself_trips);
    RUN_TEST(test_speed_control_that_is_left_out_trips);
    RUN_TEST(test_a_motion_that_changes_by_itself_trips);
    RUN_TEST(test_a_motion_that_is_set_is_no_change_by_itself);
    RUN_TEST(test_a_speed_control_that_changes_by_itself_trips);
    RUN_TEST(test_a_rest_beyond_rounding_trips);
    RUN_TEST(test_a_tuning_leaves_what_it_was_at_the_trip);
    RUN_TEST(test_a_direction_that_turns_over_starts_anew);
    RUN_TEST(test_a_q_axis_that_changes_by_itself_does_not_last);
    RUN_TEST(test_a_posted_command_is_not_lost_by_a_flip);
    RUN_TEST(test_a_torque_limit_that_changes_by_itself_trips);
    RUN_TEST(test_after_a_trip_the_telemetry_keeps_what_the_drive_was_doing);
    RUN_TEST(test_the_row_of_every_fault_keeps_the_values_of_its_step);
    RUN_TEST(test_lost_lock_and_wrong_way_trip_in_20_ms);
    return UNITY_END();
}
