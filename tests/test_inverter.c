// Dead-time error, reciprocal of the bus, and which duty and which bus voltage made the voltage that the observer is given.
#include "support/fields.h"

#include "inverter_inline.h"

void setUp(void) {}

void tearDown(void) {}

static lode_inverter_config_t sound(void) {
    return (lode_inverter_config_t){.v_bus_V = 200.0f,
                                    .i_max_A = 12.0f,
                                    .dead_time_s = 4.0e-6f,
                                    .v_drop_V = 1.2f,
                                    .r_on_Ohm = 0.05f,
                                    .i_dead_A = 0.5f,
                                    .pwm_ticks = 10000.0f,
                                    .dead_time_correction = LODE_ON,
                                    .dead_time_model = LODE_OFF};
}

static lode_inverter_tuning_t tuned(const lode_inverter_config_t *config) {
    lode_inverter_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_inverter_tune(&tuning, config, PAPER_TS_s));
    return tuning;
}

static void test_voltage_is_of_the_call_before_last_at_the_bus_of_the_last(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    lode_inverter_t inverter;
    lode_inverter_reset(&inverter);
    random_t random = random_seed(1);
    double bus[1000];
    lode_ab_t written[1000];
    for (int k = 0; k < COUNT_OF(bus); k++) {
        bus[k] = random_between(&random, 100.0, 300.0);
        const lode_ab_t u = lode_inverter_realised(&inverter, (uint32_t)k);
        lode_inverter_follow_bus(&inverter, &tuning, (float)bus[k]);
        const double alpha = k < 2 ? 0.0 : bus[k - 1] * (double)written[k - 2].alpha;
        const double beta = k < 2 ? 0.0 : bus[k - 1] * (double)written[k - 2].beta;
        CHECK_NEAR(3.0e-5, alpha, u.alpha); // one product of up to 180 V
        CHECK_NEAR(3.0e-5, beta, u.beta);
        written[k] =
            (lode_ab_t){random_float(&random, -0.6, 0.6), random_float(&random, -0.6, 0.6)};
        lode_inverter_write(&inverter, (uint32_t)k, written[k]);
    }
}

static void test_reset_forgets_what_is_on_its_way(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    lode_inverter_t inverter;
    lode_inverter_reset(&inverter);
    for (uint32_t k = 0u; k < 3u; k++) {
        lode_inverter_follow_bus(&inverter, &tuning, 200.0f);
        lode_inverter_write(&inverter, k, (lode_ab_t){0.3f, -0.2f});
    }
    lode_inverter_reset(&inverter);
    for (uint32_t k = 0u; k < 2u; k++) {
        lode_inverter_follow_bus(&inverter, &tuning, 200.0f);
        const lode_ab_t u = lode_inverter_realised(&inverter, k);
        TEST_ASSERT_TRUE(u.alpha == 0.0f && u.beta == 0.0f);
    }
}

/// Duty that a phase which carries `i` loses.
static double error_of(const lode_inverter_tuning_t *tuning, double i, double span, double bus) {
    const lode_dead_time_t dead_time =
        lode_inverter_dead_time(tuning, 0.0f, (float)span, (float)(1.0 / bus));
    return (double)lode_inverter_error(&dead_time, (float)i);
}

// The on-state slope is no part of the error: it counts as winding resistance.
static void test_error_at_full_modulation_is_a_ramp_to_a_constant(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    // Beyond 0.5 A: 4 us of 200 us, 1.2 V of 200 V. 2 %, 0.6 %. Sums of 10 A and 0.5 A round to 1e-6 A.
    CHECK_NEAR(6.0e-8, 0.02 + 0.006, error_of(&tuning, 10.0, 1.0, 200.0));
    CHECK_NEAR(1.0e-8, 0.02 + 0.006, error_of(&tuning, 0.5, 1.0, 200.0));
    // In the dead band in proportion.
    CHECK_NEAR(1.0e-8, 0.4 * (0.02 + 0.006), error_of(&tuning, 0.2, 1.0, 200.0));
    // Half the bus: the drops count double, dead time does not.
    CHECK_NEAR(1.0e-8, 0.02 + 0.012, error_of(&tuning, 2.0, 1.0, 100.0));
    TEST_ASSERT_TRUE(error_of(&tuning, 0.0, 1.0, 200.0) == 0.0);
}

static void test_the_dead_band_falls_with_the_modulation(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    CHECK_CLOSE(1.0e-6, 0.5, tuning.i_dead_min_A + tuning.i_dead_span_A);
    CHECK_AT_LEAST(1.0e-3, tuning.i_dead_min_A);
    for (int n = 0; n <= 10; n++) {
        const double span = 0.1 * n;
        const double band = (double)tuning.i_dead_min_A + (double)tuning.i_dead_span_A * span;
        const double i = 0.02 + 0.03 * n;
        const double share = fmin(1.0, i / band);
        CHECK_NEAR(2.0e-8, share * 0.026, error_of(&tuning, i, span, 200.0));
    }
}

static void test_adapting_follows_modulation_and_bus(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    lode_inverter_t inverter;
    random_t random = random_seed(2);
    for (int n = 0; n < 20000; n++) {
        const double bus = n % 10 == 0 ? 0.0 : random_between(&random, 1.0, 300.0);
        const double length = random_between(&random, 0.0, 150.0);
        const double angle = random_between(&random, -CHECK_PI, CHECK_PI);
        lode_inverter_reset(&inverter);
        inverter.written[n % 2] = (lode_ab_t){0.1f, 0.2f};
        inverter.v_bus_V = (float)bus;
        lode_inverter_adapt(
            &inverter, &tuning,
            (lode_dq_t){(float)(length * cos(angle)), (float)(length * sin(angle))});
        // Largest less smallest duty at the worst angle; the least bus that is divided by is 20 V.
        const double divided = fmax(bus, 20.0);
        const double span = fmin(1.0, sqrt(3.0) * length / divided);
        CHECK_CLOSE(1.0e-6, 0.5 * (0.05 + 0.95 * span), inverter.dead_time.i_dead_A);
        CHECK_CLOSE(1.0e-6, 0.02 + 1.2 / divided,
                    2.0f * inverter.dead_time.i_dead_A * inverter.dead_time.slope_A);
        CHECK_CLOSE(1.0e-7, 1.0 / divided, inverter.per_V);
        const lode_ab_t written = inverter.written[n % 2];
        TEST_ASSERT_TRUE(written.alpha == 0.1f && written.beta == 0.2f);
    }
}

static void test_adapting_is_total(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    random_t random = random_seed(3);
    for (int n = 0; n < CHECK_TRIES(100000); n++) {
        lode_inverter_t inverter;
        lode_inverter_reset(&inverter);
        const lode_dq_t u = {random_any(&random), random_any(&random)};
        inverter.v_bus_V = random_any(&random);
        lode_inverter_adapt(&inverter, &tuning, u);
        TEST_ASSERT_TRUE(lode_in_range(inverter.dead_time.i_dead_A, 0.02f, 0.51f));
        TEST_ASSERT_TRUE(lode_in_range(inverter.dead_time.slope_A, 0.0f, 10.0f));
        // Never more than dead time and drops at the least bus, whatever the voltage was.
        CHECK_AT_MOST(1.00001 * (0.02 + 1.2 / 20.0),
                      lode_inverter_error(&inverter.dead_time, 5.0f));
    }
}

/// A bus of 200 V that has been divided by.
static lode_inverter_t at_200_V(const lode_inverter_tuning_t *tuning) {
    lode_inverter_t inverter;
    lode_inverter_reset(&inverter);
    inverter.v_bus_V = 200.0f;
    lode_inverter_divide(&inverter, tuning);
    return inverter;
}

static void test_the_reciprocal_follows_the_bus(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    // By a step of Newton's method, which leaves the square of a move: 0.01 % after 1 %.
    for (int n = -240; n <= 240; n++) {
        const double move = 1.0e-3 * n;
        lode_inverter_t inverter = at_200_V(&tuning);
        lode_inverter_follow_bus(&inverter, &tuning, (float)(200.0 * (1.0 + move)));
        CHECK_NEAR(2.0e-7, 1.0 - move * move, inverter.v_bus_V * inverter.per_V);
        TEST_ASSERT_EQUAL_FLOAT((float)(200.0 * (1.0 + move)), inverter.v_bus_V);
    }
    // A ripple of 5 % in a triangle of 20 periods, 1 % per period: never off by more than 0.03 %.
    lode_inverter_t inverter = at_200_V(&tuning);
    for (int n = 0; n < 10000; n++) {
        const int phase = n % 20;
        const double share = 1.0e-2 * (phase < 10 ? phase : 20 - phase);
        lode_inverter_follow_bus(&inverter, &tuning, (float)(200.0 * (1.0 + share)));
        CHECK_NEAR(3.0e-4, 1.0, inverter.v_bus_V * inverter.per_V);
    }
}

static void test_the_reciprocal_of_a_bus_that_jumps_is_exact_at_once(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    const float jumps[] = {400.0f, 100.0f, 270.0f, 149.0f, 2000.0f, 20.0f};
    for (int n = 0; n < COUNT_OF(jumps); n++) {
        lode_inverter_t inverter = at_200_V(&tuning);
        lode_inverter_follow_bus(&inverter, &tuning, jumps[n]);
        CHECK_CLOSE(2.0e-7, 1.0 / (double)jumps[n], inverter.per_V);
        lode_inverter_follow_bus(&inverter, &tuning, 200.0f); // and back
        CHECK_CLOSE(2.0e-7, 1.0 / 200.0, inverter.per_V);
    }
}

static void test_the_reciprocal_of_any_bus_stays_in_range(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    const float buses[] = {0.0f, -0.0f, 1.0e-40f, 1.0f, 14.9f, -200.0f, NAN};
    for (int n = 0; n < COUNT_OF(buses); n++) {
        lode_inverter_t inverter = at_200_V(&tuning);
        for (int k = 0; k < 100; k++) {
            lode_inverter_follow_bus(&inverter, &tuning, buses[n]);
            CHECK_CLOSE(2.0e-7, 1.0 / 20.0, inverter.per_V); // the least that is divided by
        }
        lode_inverter_follow_bus(&inverter, &tuning, 200.0f);
        CHECK_CLOSE(2.0e-7, 1.0 / 200.0, inverter.per_V);
    }
    // Whatever comes after whatever: a number, and a voltage inside the circle of its bus never becomes
    // longer than the circle per bus volt.
    random_t random = random_seed(4);
    lode_inverter_t inverter = at_200_V(&tuning);
    float bus = 200.0f;
    for (int n = 0; n < CHECK_TRIES(100000); n++) {
        bus = n % 3 == 0 ? random_any(&random)
                         : (n % 3 == 1 ? random_float(&random, 0.0, 400.0)
                                       : bus * random_float(&random, 0.7, 1.4));
        lode_inverter_follow_bus(&inverter, &tuning, bus);
        TEST_ASSERT_TRUE(lode_in_range(inverter.per_V, 0.0f, FLT_MAX));
        TEST_ASSERT_FALSE(bus * inverter.per_V > 1.0f + 2.0e-7f); // also of a bus that is no number
    }
}

static void test_after_reset_nothing_is_lost(void) {
    lode_inverter_t inverter;
    lode_inverter_reset(&inverter);
    for (int n = -100; n <= 100; n++) {
        TEST_ASSERT_TRUE(lode_inverter_error(&inverter.dead_time, 0.3f * (float)n) == 0.0f);
    }
}

static void test_error_is_odd_and_rises_with_the_current(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    double before = error_of(&tuning, -15.0, 0.7, 200.0);
    for (int n = -1500; n <= 1500; n++) {
        const double i = 0.01 * n;
        const double error = error_of(&tuning, i, 0.7, 200.0);
        TEST_ASSERT_TRUE(error == -error_of(&tuning, -i, 0.7, 200.0));
        // Constant beyond the dead band but for the last bits of i + i_dead and i - i_dead.
        CHECK_AT_LEAST(before - 5.0e-8, error);
        before = fmax(before, error);
    }
}

/// (I10): half of the loss, at the ripple of a carrier period of two calls.
static void test_double_update_has_one_edge_a_call(void) {
    lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t once = tuned(&config);
    config.double_update = LODE_ON;
    const lode_inverter_tuning_t twice = tuned(&config);
    CHECK_CLOSE(1.0e-6, 0.5 * (double)once.dead_duty, twice.dead_duty);
    CHECK_CLOSE(1.0e-6, 0.5 * (double)once.dead_more_max, twice.dead_more_max);
    CHECK_CLOSE(1.0e-6, 2.5e3, lode_inverter_carrier_Hz(&config, 5.0e3f));
    const lode_motor_t motor = {.Ld_H = 3.5e-3f, .Lq_H = 9.8e-3f};
    config.i_dead_A = 0.0f;
    lode_inverter_design(&config, &motor, 1.0e-4f);
    lode_inverter_config_t slow = sound();
    slow.i_dead_A = 0.0f;
    slow.double_update = LODE_AUTO;
    lode_inverter_design(&slow, &motor, 2.0e-4f);
    CHECK_CLOSE(1.0e-6, slow.i_dead_A, config.i_dead_A);
}

static void test_tuning_of_a_configuration(void) {
    lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    CHECK_CLOSE(1.0e-6, 0.02, tuning.dead_duty);
    TEST_ASSERT_EQUAL_FLOAT(10000.0f, tuning.ticks);
    TEST_ASSERT_TRUE(tuning.correct == 1u && tuning.free > 0.0f);
    config.pwm_ticks = 0.0f;
    config.dead_time_correction = LODE_OFF;
    config.dead_time_model = LODE_ON;
    const lode_inverter_tuning_t other = tuned(&config);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, other.ticks);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, other.inv_ticks);
    TEST_ASSERT_TRUE(other.correct == 0u && other.dead_duty > 0.0f && other.free < 0.0f);
    // With the correction on, the loss is made good: it is not taken out as well.
    config.dead_time_correction = LODE_ON;
    const lode_inverter_tuning_t both = tuned(&config);
    TEST_ASSERT_TRUE(both.correct == 1u && both.free > 0.0f);
    TEST_ASSERT_TRUE(tuning.v_min_V > 0.0f && tuning.v_min_V < 100.0f);
}

/// A vector as long as what is free for current control has all its duties between the rails, after the worst that
/// the correction may add at the least bus; one that is 0.2 % longer has not.
static void test_what_is_free_leaves_room_for_the_correction(void) {
    for (int corrects = 0; corrects <= 1; corrects++) {
        lode_inverter_config_t config = sound();
        config.dead_time_correction = corrects == 1 ? LODE_ON : LODE_OFF;
        const lode_inverter_tuning_t tuning = tuned(&config);
        // 4 us of 200 us and 1.5 us more; 1.2 V of a tenth of 200 V.
        const double error = corrects == 1 ? 0.02 + 0.0075 + 0.06 : 0.0;
        double highest = 0.0;
        for (int n = 0; n < 360; n++) {
            double u[3];
            for (int phase = 0; phase < 3; phase++) {
                u[phase] = (double)tuning.free * cos(n * CHECK_DEG - 2.0 * CHECK_PI / 3.0 * phase);
            }
            const double most = fmax(u[0], fmax(u[1], u[2]));
            const double least = fmin(u[0], fmin(u[1], u[2]));
            highest = fmax(highest, 0.5 + 0.5 * (most - least) + error);
        }
        TEST_ASSERT_TRUE(tuning.free > 0.0f);
        CHECK_AT_MOST(1.0, highest);
        CHECK_AT_LEAST(0.999, highest);
        TEST_ASSERT_TRUE((tuning.dead_duty > 0.0f) == (corrects == 1));
        TEST_ASSERT_TRUE((tuning.v_drop_V > 0.0f) == (corrects == 1));
    }
}

/// What the correction rounds by, at a current, is taken of it: half a step of a float at 2 i for each of two terms.
static void test_what_is_free_leaves_room_for_rounding(void) {
    lode_inverter_config_t config = sound();
    config.i_dead_A = 0.02f; // a steep slope
    for (int corrects = 0; corrects <= 1; corrects++) {
        config.dead_time_correction = corrects == 1 ? LODE_ON : LODE_OFF;
        const lode_inverter_tuning_t before = tuned(&config);
        lode_inverter_tuning_t tuning = before;
        lode_inverter_bound_current(&tuning, 1000.0f);
        const double slope = 0.5 * (0.02 + 0.0075 + 0.06) / (0.05 * 0.02);
        const double room = 2.0 / sqrt(3.0) * slope * ldexp(1.0, -23) * 2.0 * 1000.0;
        CHECK_NEAR(2.0e-4 * room, corrects == 1 ? room : 0.0,
                   (double)before.free - (double)tuning.free);
    }
}

static void test_periods_and_ticks(void) {
    lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    CHECK_CLOSE(1.0e-6, 1.0e-4, tuning.inv_ticks);
    TEST_ASSERT_EQUAL_UINT(1u, tuning.grid);
    for (uint32_t n = 0u; n <= 100u; n++) { // however the quotient rounds
        config.precharge_s = (float)n * PAPER_TS_s;
        TEST_ASSERT_EQUAL_UINT(n, tuned(&config).precharge_periods);
    }
    config.pwm_ticks = 0.0f;
    TEST_ASSERT_EQUAL_UINT(0u, tuned(&config).grid);
    config.pwm_ticks = 1.0f; // the coarsest
    TEST_ASSERT_EQUAL_UINT(1u, tuned(&config).grid);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, tuned(&config).inv_ticks);
}

static lode_status_t try_config(const lode_inverter_config_t *config) {
    lode_inverter_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_inverter_tuning_t before = tuning;
    const lode_status_t status = lode_inverter_tune(&tuning, config, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_inverter_config_t config = sound();
    field_set(&config, offset, value);
    return try_config(&config);
}

static void test_every_field_at_its_limits(void) {
    static const field_t fields[] = {
        {FIELD(lode_inverter_config_t, v_bus_V), .lo = 1.0f, .hi = 2000.0f,
         .error = LODE_ERROR_V_BUS},
        {FIELD(lode_inverter_config_t, i_max_A), .lo = 1.0e-3f, .hi = 1.0e4f, .coupled = true,
         .error = LODE_ERROR_I_MAX},
        {FIELD(lode_inverter_config_t, dead_time_s), .lo = 0.0f, .hi = 4.0e-5f, .computed = true,
         .error = LODE_ERROR_DEAD_TIME},
        {FIELD(lode_inverter_config_t, v_drop_V), .lo = 0.0f, .hi = 10.0f,
         .error = LODE_ERROR_V_DROP},
        {FIELD(lode_inverter_config_t, r_on_Ohm), .lo = 0.0f, .hi = 10.0f,
         .error = LODE_ERROR_R_ON},
        {FIELD(lode_inverter_config_t, i_dead_A), .lo = 0.012f, .hi = 12.0f, .computed = true,
         .error = LODE_ERROR_I_DEAD},
        {FIELD(lode_inverter_config_t, pwm_ticks), .lo = 0.0f, .hi = 65535.0f,
         .error = LODE_ERROR_PWM_TICKS},
        {FIELD(lode_inverter_config_t, precharge_s), .lo = 0.0f, .hi = 1.0f,
         .error = LODE_ERROR_PRECHARGE},
    };
    for (int i = 0; i < COUNT_OF(fields); i++) {
        if (fields[i].computed && fields[i].lo == 0.0f) {
            field_accepted(&fields[i], try_one, 0.0f);
            field_accepted(&fields[i], try_one, 0.999f * fields[i].hi);
            field_refused(&fields[i], try_one, 1.001f * fields[i].hi);
            field_refused(&fields[i], try_one, -1.0e-9f);
            field_refused(&fields[i], try_one, NAN);
            field_refused(&fields[i], try_one, INFINITY);
        } else {
            field_check(&fields[i], try_one);
        }
    }
}

static void test_choices_must_be_made(void) {
    const int bad[] = {LODE_AUTO, 3, 77};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        lode_inverter_config_t config = sound();
        config.dead_time_correction = (lode_choice_t)bad[i];
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, try_config(&config));
        config = sound();
        config.dead_time_model = (lode_choice_t)bad[i];
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, try_config(&config));
        config = sound();
        config.double_update = (lode_choice_t)bad[i]; // of which auto is off
        TEST_ASSERT_EQUAL_INT(bad[i] == LODE_AUTO ? LODE_OK : LODE_ERROR_CHOICE,
                              try_config(&config));
    }
}

static void test_design_decides(void) {
    const lode_motor_t motor = paper_motor();
    lode_inverter_config_t config = {.v_bus_V = 200.0f, .i_max_A = 12.0f, .dead_time_s = 4.0e-6f};
    lode_inverter_design(&config, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_ON, config.dead_time_correction);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, config.dead_time_model);
    // Three quarters of the ripple, v_bus Ts/(6 L) with the mean of both axes.
    CHECK_CLOSE(1.0e-5, 0.75 * 200.0 * 2.0e-4 / (6.0 * 6.65e-3), config.i_dead_A);
    lode_inverter_config_t ideal = {.v_bus_V = 200.0f, .i_max_A = 12.0f};
    lode_inverter_design(&ideal, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_ON, ideal.dead_time_correction); // of what the start may find
    // Of a motor that has hardly any ripple, a hundredth of i_max.
    const lode_motor_t smooth = {.Ld_H = 1.0f, .Lq_H = 1.0f};
    lode_inverter_config_t calm = {.v_bus_V = 200.0f, .i_max_A = 12.0f};
    lode_inverter_design(&calm, &smooth, PAPER_TS_s);
    CHECK_CLOSE(1.0e-6, 0.12, calm.i_dead_A);
    const lode_inverter_config_t all = sound();
    lode_inverter_config_t kept = all;
    lode_inverter_design(&kept, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_MEMORY(&all, &kept, sizeof all);
}

/// The voltage along the current that a phase's share of lost time makes, averaged over its directions.
static double along_V(double dead_s) {
    return 4.0 / CHECK_PI * 200.0 * dead_s / PAPER_TS_s;
}

static void test_what_is_measured_is_shared_out(void) {
    const lode_inverter_config_t config = sound();
    const lode_inverter_tuning_t tuning = tuned(&config);
    lode_inverter_t inverter;
    lode_inverter_reset(&inverter);
    inverter.v_bus_V = 200.0f;
    lode_inverter_adapt(&inverter, &tuning, (lode_dq_t){0.0f, 0.0f});
    lode_inverter_correct(&inverter, &tuning, 0.2f, (float)along_V(0.6e-6), 8.0f);
    lode_inverter_correct(&inverter, &tuning, 0.1f, (float)along_V(-0.2e-6), 8.0f);
    CHECK_CLOSE(1.0e-4, 0.3, inverter.r_more_Ohm);
    CHECK_CLOSE(1.0e-4, 0.4e-6 / PAPER_TS_s, inverter.dead_more);
    // It is what the dead time's loss is made of.
    lode_inverter_adapt(&inverter, &tuning, (lode_dq_t){0.0f, 0.0f});
    CHECK_CLOSE(1.0e-4, 4.4e-6 / PAPER_TS_s + 1.2 / 200.0,
                2.0f * inverter.dead_time.i_dead_A * inverter.dead_time.slope_A);
    // Up to 1.5 us; the rest counts as resistance, at the current that it was measured with.
    lode_inverter_correct(&inverter, &tuning, 0.0f, (float)along_V(2.1e-6), 8.0f);
    CHECK_CLOSE(1.0e-4, 1.5e-6 / PAPER_TS_s, inverter.dead_more);
    CHECK_CLOSE(1.0e-4, 0.3 + along_V(1.0e-6) / 8.0, inverter.r_more_Ohm);
    // Without a correction all of it.
    lode_inverter_config_t plain = sound();
    plain.dead_time_correction = LODE_OFF;
    const lode_inverter_tuning_t off = tuned(&plain);
    lode_inverter_reset(&inverter);
    inverter.v_bus_V = 200.0f;
    lode_inverter_adapt(&inverter, &off, (lode_dq_t){0.0f, 0.0f});
    lode_inverter_correct(&inverter, &off, 0.2f, (float)along_V(0.5e-6), 8.0f);
    TEST_ASSERT_TRUE(inverter.dead_more == 0.0f);
    CHECK_CLOSE(1.0e-4, 0.2 + along_V(0.5e-6) / 8.0, inverter.r_more_Ohm);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_what_is_measured_is_shared_out);
    RUN_TEST(test_voltage_is_of_the_call_before_last_at_the_bus_of_the_last);
    RUN_TEST(test_reset_forgets_what_is_on_its_way);
    RUN_TEST(test_error_at_full_modulation_is_a_ramp_to_a_constant);
    RUN_TEST(test_the_dead_band_falls_with_the_modulation);
    RUN_TEST(test_adapting_follows_modulation_and_bus);
    RUN_TEST(test_adapting_is_total);
    RUN_TEST(test_the_reciprocal_follows_the_bus);
    RUN_TEST(test_the_reciprocal_of_a_bus_that_jumps_is_exact_at_once);
    RUN_TEST(test_the_reciprocal_of_any_bus_stays_in_range);
    RUN_TEST(test_after_reset_nothing_is_lost);
    RUN_TEST(test_error_is_odd_and_rises_with_the_current);
    RUN_TEST(test_double_update_has_one_edge_a_call);
    RUN_TEST(test_tuning_of_a_configuration);
    RUN_TEST(test_what_is_free_leaves_room_for_the_correction);
    RUN_TEST(test_what_is_free_leaves_room_for_rounding);
    RUN_TEST(test_periods_and_ticks);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_choices_must_be_made);
    RUN_TEST(test_design_decides);
    return UNITY_END();
}
