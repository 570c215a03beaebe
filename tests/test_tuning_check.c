// A tuning of the drive: refused where it is no number, and watched for bits that flip while it is in use.
#include "support/drive_cases.h"

#include "design/tuning_fields.h"
#include "lodestar/drive6.h"

#include <stdlib.h>

void setUp(void) {}

void tearDown(void) {}

static lode_drive_tuning_t other_tuning;

#define PLACE_FLOAT(type, member) offsetof(lode_drive_tuning_t, member),
#define PLACE_INTEGER(type, member)
#define PLACE_WHOLE(type, member)
#define PLACE_OBSERVER(place, member) PLACE_FLOAT(float, member)
#define PLACE(kind, type, member) PLACE_##kind(type, member)
static const size_t floats_of_a_tuning[] = {TUNING_FIELDS(PLACE)};

#define NAME_FLOAT(type, member) #member,
#define NAME_INTEGER(type, member)
#define NAME_WHOLE(type, member)
#define NAME_OBSERVER(place, member) NAME_FLOAT(float, member)
#define NAME(kind, type, member) NAME_##kind(type, member)
static const char *const names_of_a_tuning[] = {TUNING_FIELDS(NAME)};

/// A period with whatever a tuning may hold: with the gates on a duty is a duty, with them off idle.
static bool driven_by_duties(rig_t *rig) {
    rig_step(rig);
    const lode_abc_t d = rig->out.duty;
    return (rig->out.gates && lode_in_range(d.a, 0.0f, 1.0f) && lode_in_range(d.b, 0.0f, 1.0f) &&
            lode_in_range(d.c, 0.0f, 1.0f)) ||
           is_idle(rig->out);
}

/// The same drive while one float of its tuning has changed by itself; how many of them tripped for what is no duty.
static int trips_of_bad_floats(const rig_t *sound) {
    const lode_drive_tuning_t good = *sound->drive.tuning;
    int tripped = 0;
    for (int n = 0; n < COUNT_OF(floats_of_a_tuning) * COUNT_OF(check_not_finite); n++) {
        const int field = n / COUNT_OF(check_not_finite);
        rig_t rig = *sound;
        other_tuning = good;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
        rig_step(&rig);
        memcpy((char *)&other_tuning + floats_of_a_tuning[field],
               &check_not_finite[n % COUNT_OF(check_not_finite)], sizeof(float));
        for (int k = 0; k < 100; k++) {
            TEST_ASSERT_TRUE_MESSAGE(driven_by_duties(&rig), names_of_a_tuning[field]);
        }
        tripped += rig_telemetry(&rig).fault.check == LODE_CHECK_NON_FINITE ? 1 : 0;
        // Nothing of it stays once the tuning is sound again.
        rig.motor = sound->motor;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &tuning));
        rig_command(&rig, clear);
        rig_run(&rig, 0.002);
        rig.motor.omega = 0.0;
        rig.blocked = true;
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
        rig_run(&rig, 0.05);
        rig_expect(&rig, LODE_MODE_CURRENT);
        CHECK_NEAR(0.05, 4.0, ipmsm_current(&rig.motor).alpha);
    }
    return tripped;
}

static void test_a_float_of_a_tuning_that_is_no_number_makes_no_duty(void) {
    for (int grid = 0; grid < 2; grid++) {
        lode_drive_config_t config = rig_config();
        config.inverter.pwm_ticks = grid == 0 ? 0.0f : 8400.0f;
        config.inverter.dead_time_s = 2.0e-6f;
        config.guard.v_bus_max_V = 400.0f;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        const lode_command_t commands[] = {
            {.mode = LODE_MODE_VOLTAGE, .vector = {5.0f, 0.0f}, .omega_rad_s = 100.0f},
            {.mode = LODE_MODE_CURRENT, .vector = {3.0f, 0.0f}, .omega_rad_s = 10.0f},
            run_at(100.0)};
        for (int c = 0; c < COUNT_OF(commands); c++) {
            rig_command(&rig, off);
            rig_run(&rig, 0.01);
            rig.motor.omega = 0.0;
            rig_command(&rig, commands[c]);
            rig_run(&rig, 0.15);
            TEST_ASSERT_TRUE(c == 2 || rig.out.gates);
            if (c == 2) {
                TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 8.0));
                rig_run(&rig, 0.1);
                CHECK_AT_LEAST(1, trips_of_bad_floats(&rig));
                TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
                rig_run(&rig, 0.5);
            }
            CHECK_AT_LEAST(1, trips_of_bad_floats(&rig));
        }
    }
}

static void test_a_grid_that_is_no_number_trips_in_the_same_call(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.pwm_ticks = 8400.0f;
    rig_t rig = holding_without(0, &config);
    tuning.inverter.inv_ticks = NAN; // by itself: the post refuses it
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NON_FINITE, rig_telemetry(&rig).fault.check);
    CHECK_NEAR(0.0, 1.0, rig_telemetry(&rig).fault.measured);
    CHECK_NEAR(0.0, 0.0, rig_telemetry(&rig).fault.limit);
}

#define INTEGER_FLOAT(type, member)
#define INTEGER_INTEGER(type, member) offsetof(lode_drive_tuning_t, member),
#define INTEGER_WHOLE(type, member) INTEGER_INTEGER(type, member)
#define INTEGER_OBSERVER(place, member)
#define INTEGER_PLACE(kind, type, member) INTEGER_##kind(type, member)
static const size_t integers_of_a_tuning[] = {TUNING_FIELDS(INTEGER_PLACE)};

/// Nothing of such a tuning is taken, neither running nor at the beginning.
static void test_a_tuning_with_a_float_that_is_no_number_is_refused(void) {
    const rig_t sound = running(90.0, 8.0);
    for (int n = 0; n < COUNT_OF(floats_of_a_tuning) * COUNT_OF(check_not_finite); n++) {
        const int field = n / COUNT_OF(check_not_finite);
        other_tuning = tuning;
        memcpy((char *)&other_tuning + floats_of_a_tuning[field],
               &check_not_finite[n % COUNT_OF(check_not_finite)], sizeof(float));
        rig_t rig = sound;
        TEST_ASSERT_EQUAL_STRING_MESSAGE(
            "LODE_ERROR_TUNING",
            lode_status_name(lode_drive_post_tuning(&rig.drive, &other_tuning)),
            names_of_a_tuning[field]);
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_TUNING, lode_drive_begin(&rig.drive, &other_tuning));
        TEST_ASSERT_EQUAL_MEMORY(&sound.drive, &rig.drive, sizeof rig.drive);
    }
}

static void test_an_integer_of_a_tuning_may_be_any(void) {
    rig_t rig = fresh();
    for (int n = 0; n < COUNT_OF(integers_of_a_tuning); n++) {
        other_tuning = tuning;
        const size_t word = integers_of_a_tuning[n] / sizeof(uint32_t) * sizeof(uint32_t);
        memset((char *)&other_tuning + word, 0xff, sizeof(uint32_t));
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    }
}

/// A bit of a word of the tuning in use flips, in another octet from word to word, and stays so for `time_s`.
static lode_fault_t after_flip(const rig_t *sound, size_t word, double time_s) {
    rig_t rig = *sound;
    unsigned char *octet =
        (unsigned char *)&other_tuning + word * sizeof(float) + word % sizeof(float);
    const unsigned bit = 1u << word / sizeof(float) % 8u;
    *octet = (unsigned char)(*octet ^ bit);
    rig_run(&rig, time_s);
    *octet = (unsigned char)(*octet ^ bit);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    return rig_telemetry(&rig).fault;
}

#define WORDS_OF_A_TUNING (sizeof other_tuning / sizeof(float))

static bool is_of_the_guard(size_t word) {
    const size_t from = offsetof(lode_drive_tuning_t, guard);
    return word * sizeof(float) - from < sizeof other_tuning.guard; // wraps round below it
}

/// Standing, a word is looked at in each period, running in every eighth.
static void test_a_tuning_that_changes_by_itself_trips(void) {
    for (int running = 0; running < 2; running++) {
        rig_t rig = fresh();
        other_tuning = *rig.drive.tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
        rig_step(&rig);
        if (running == 1) {
            rig_command(&rig, run_at(100.0));
            TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
            rig_run(&rig, 0.5);
        }
        const uint32_t periods = running == 1 ? LODE_SLOW_PERIODS : 1u;
        const double walk_s = (double)((WORDS_OF_A_TUNING + 2) * periods) * (double)PAPER_TS_s;
        const rig_t sound = rig;
        rig_run(&rig, 5.0 * walk_s);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
        for (size_t word = 0; word < WORDS_OF_A_TUNING; word += running == 1 ? 7 : 1) {
            const lode_fault_t fault = after_flip(&sound, word, 2.0 * walk_s);
            if (is_of_the_guard(word) && fault.check != (uint_least8_t)LODE_CHECK_MEMORY) {
                TEST_ASSERT_TRUE(fault.check != (uint_least8_t)LODE_CHECK_NONE);
                continue; // a limit that is passed trips at once
            }
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_MEMORY", lode_check_name(fault.check));
            TEST_ASSERT_TRUE(fault.measured == 3.0f);
        }
    }
}

/// Two of its bits flip while nothing is driven.
static void check_pair(const rig_t *sound, uint32_t a, uint32_t b) {
    rig_t rig = *sound;
    unsigned char *octets = (unsigned char *)&other_tuning;
    octets[a / 8u] = (unsigned char)(octets[a / 8u] ^ 1u << a % 8u);
    octets[b / 8u] = (unsigned char)(octets[b / 8u] ^ 1u << b % 8u);
    rig_run(&rig, 2.0 * (double)(WORDS_OF_A_TUNING + 2) * RIG_TS_s);
    octets[a / 8u] = (unsigned char)(octets[a / 8u] ^ 1u << a % 8u);
    octets[b / 8u] = (unsigned char)(octets[b / 8u] ^ 1u << b % 8u);
    TEST_ASSERT_EQUAL_STRING(a == b ? "LODE_CHECK_NONE" : "LODE_CHECK_MEMORY",
                             lode_check_name(rig_telemetry(&rig).fault.check));
}

static void test_two_bits_of_a_tuning_that_change_by_themselves_trip(void) {
    rig_t rig = fresh();
    other_tuning = tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    rig_step(&rig);
    check_pair(&rig, 0u, 0u);
    random_t random = random_seed(9u);
    const uint32_t bits = 32u * (uint32_t)WORDS_OF_A_TUNING;
    for (int n = 0; n < 300; n++) {
        const uint32_t a = random_bits(&random) % bits;
        check_pair(&rig, a, (a + 1u + random_bits(&random) % (bits - 1u)) % bits);
    }
    for (uint32_t bit = 0; bit < 32u; bit++) { // in the next word beside it
        check_pair(&rig, 320u + bit, 351u + bit);
        check_pair(&rig, 320u + bit, 352u + bit);
        check_pair(&rig, 320u + bit, 353u + bit);
    }
}

/// Of two in a row only the second is taken, with its own check.
static void test_a_tuning_posted_twice_is_watched_by_its_own_check(void) {
    rig_t rig = fresh();
    lode_drive_config_t config = rig_config();
    config.speed.ramp_rad_s2 = 100.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, rig.drive.tuning));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    rig_run(&rig, 0.2);
    TEST_ASSERT_TRUE(rig.drive.tuning == &other_tuning);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
}

#define WORDS_OF_SIX_PHASES (sizeof(lode_drive6_tuning_t) / sizeof(uint32_t))
#define BITS_OF_A_CHECK 32u

static uint32_t check_of(const uint32_t words[], size_t count) {
    lode_drive_t drive;
    lode_tuning_post_check(&drive, (lode_words_t){(const unsigned char *)words, (uint32_t)count});
    return drive.posted_check;
}

static void test_the_check_is_the_remainder_of_its_polynomial(void) {
    uint32_t words[10];
    random_t random = random_seed(1u);
    for (int n = 0; n < 100; n++) {
        uint32_t crc = 0xffffffffu;
        for (int w = 0; w < COUNT_OF(words); w++) {
            words[w] = random_bits(&random);
            for (int bit = 0; bit < 32; bit++) {
                const uint32_t out = (crc ^ words[w] >> bit) & 1u;
                crc = crc >> 1 ^ out * 0x98880000u; // x^12 + x^8 + x^4 + x^3 + 1, x^31 at the right
            }
        }
        TEST_ASSERT_EQUAL_HEX32(crc, check_of(words, COUNT_OF(words)));
    }
}

/// By what each bit of the words changes the check, then each of the check itself.
static void find_changes(uint32_t changes[]) {
    static uint32_t words[WORDS_OF_SIX_PHASES];
    const uint32_t check = check_of(words, WORDS_OF_SIX_PHASES);
    for (size_t bit = 0; bit < 32u * WORDS_OF_SIX_PHASES; bit++) {
        words[bit / 32u] = 1u << bit % 32u;
        changes[bit] = check ^ check_of(words, WORDS_OF_SIX_PHASES);
        words[bit / 32u] = 0u;
    }
    for (uint32_t bit = 0; bit < BITS_OF_A_CHECK; bit++) {
        changes[32u * WORDS_OF_SIX_PHASES + bit] = 1u << bit;
    }
}

static int by_size(const void *a, const void *b) {
    const uint32_t x = *(const uint32_t *)a;
    const uint32_t y = *(const uint32_t *)b;
    return x < y ? -1 : (x > y ? 1 : 0);
}

/// Any two: no two bits change the check alike. Any odd number: each changes an odd number of its bits.
static void test_the_check_finds_any_three_bits_of_six_phases(void) {
    static uint32_t changes[32u * WORDS_OF_SIX_PHASES + BITS_OF_A_CHECK];
    find_changes(changes);
    qsort(changes, COUNT_OF(changes), sizeof changes[0], by_size);
    for (int n = 0; n < COUNT_OF(changes); n++) {
        uint32_t odd = 0u;
        for (uint32_t left = changes[n]; left > 0u; left >>= 1) {
            odd ^= left & 1u;
        }
        TEST_ASSERT_EQUAL_UINT32(1u, odd);
        TEST_ASSERT_TRUE(n == 0 || changes[n] > changes[n - 1]);
    }
}

/// Of a burst the first and the last bit have flipped, and any between.
static void test_the_check_finds_bursts_of_a_word(void) {
    uint32_t words[20] = {0u};
    const uint32_t check = check_of(words, COUNT_OF(words));
    random_t random = random_seed(3u);
    for (int n = 0; n < 50000; n++) {
        const uint32_t length = 1u + random_bits(&random) % 32u;
        const uint32_t ends = 1u | 1u << (length - 1u);
        const uint64_t burst = (random_bits(&random) >> (32u - length)) | ends;
        const uint32_t from = random_bits(&random) % (32u * 19u);
        const uint64_t moved = burst << from % 32u;
        words[from / 32u] = (uint32_t)moved;
        words[from / 32u + 1u] = (uint32_t)(moved >> 32);
        TEST_ASSERT_TRUE(check_of(words, COUNT_OF(words)) != check);
        words[from / 32u] = words[from / 32u + 1u] = 0u;
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_float_of_a_tuning_that_is_no_number_makes_no_duty);
    RUN_TEST(test_a_grid_that_is_no_number_trips_in_the_same_call);
    RUN_TEST(test_a_tuning_with_a_float_that_is_no_number_is_refused);
    RUN_TEST(test_an_integer_of_a_tuning_may_be_any);
    RUN_TEST(test_a_tuning_that_changes_by_itself_trips);
    RUN_TEST(test_two_bits_of_a_tuning_that_change_by_themselves_trip);
    RUN_TEST(test_a_tuning_posted_twice_is_watched_by_its_own_check);
    RUN_TEST(test_the_check_is_the_remainder_of_its_polynomial);
    RUN_TEST(test_the_check_finds_any_three_bits_of_six_phases);
    RUN_TEST(test_the_check_finds_bursts_of_a_word);
    return UNITY_END();
}
