// Signal check before a start: what pulses show on a salient machine, behind a bridge and sensors that may be wrong.
#include "support/ipmsm.h"

#include "lodestar/signal_check.h"

#include <stdlib.h>
#include <string.h>

void setUp(void) {}

void tearDown(void) {}

#define V_BUS_V 200.0
#define I_MAX_A 12.0
#define A_PER_COUNT 0.01
#define COUNT_A (A_PER_COUNT / LODE_COUNT_FRACTION)
#define NOISE_COUNTS 3.0 // rms, of three numbers of an even spread
#define PERIODS (6 * 6)  // of a set
#define ANGLES 24

static const lode_inverter_config_t inverter = {
    .v_bus_V = (float)V_BUS_V, .i_max_A = (float)I_MAX_A, .dead_time_s = 2.0e-6f};
static const lode_sense_config_t adc = {.i_gain_A_count = (float)A_PER_COUNT, .duty_max = 1.0f};
static const lode_start_config_t start = {.catch_s = 0.05f};
static const lode_signal_check_given_t usual = {PAPER_TS_s, true, true};
static const lode_sense_tuning_t sense = {.i_gain = (float)COUNT_A,
                                          .alpha_gain = (float)(COUNT_A / 3.0),
                                          .beta_gain = (float)(COUNT_A / 1.7320508)};

static lode_signal_check_tuning_t tuned_to(double Ld_H, double Lq_H) {
    lode_motor_t motor = paper_motor();
    motor.Ld_H = (float)Ld_H;
    motor.Lq_H = (float)Lq_H;
    lode_signal_check_tuning_t tuning;
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(lode_signal_check_tune(
                                            &tuning, &start, &inverter, &motor, &adc, usual)));
    return tuning;
}

static lode_signal_check_tuning_t tuned(void) {
    return tuned_to(3.5e-3, 9.8e-3);
}

/// Bridge and sensors. `see`: which phase each sensor shows, by which gain.
typedef struct {
    ipmsm_t motor;
    int see[3];
    double gain[3];
    double offset_A[3];
    double stuck_A[3]; ///< less than 1e3: what it shows whatever flows
    int rail;          ///< leg that keeps to its low side; 0: none
    int dead;          ///< leg whose high side stays off; negative: whose low side does
    bool open;         ///< phase a
    int late;          ///< periods that duties act later
    double e[4][3];    ///< voltages per bus volt on their way, of the legs
    double peak_A;
    random_t *noise; ///< of NOISE_COUNTS on each sensor; NULL: none
} board_t;

static board_t board_at(double theta) {
    board_t self = {.motor = ipmsm_paper(0.0),
                    .see = {0, 1, 2},
                    .gain = {1.0, 1.0, 1.0},
                    .stuck_A = {1e6, 1e6, 1e6}};
    self.motor.theta = theta;
    return self;
}

static void phases_of(const ipmsm_t *m, double i[3]) {
    for (int x = 0; x < 3; x++) {
        const double at = m->theta - 2.0 * CHECK_PI / 3.0 * x;
        i[x] = m->id * cos(at) - m->iq * sin(at);
    }
}

static void sample(const board_t *self, int32_t counts[LODE_PHASES]) {
    double i[3];
    phases_of(&self->motor, i);
    for (int x = 0; x < 3; x++) {
        double seen = self->gain[x] * i[self->see[x]] + self->offset_A[x];
        seen = self->stuck_A[x] < 1e3 ? self->stuck_A[x] : seen;
        for (int n = 0; self->noise != NULL && n < 3; n++) {
            seen +=
                (double)random_float(self->noise, -3.0f, 3.0f) * NOISE_COUNTS / 3.0 * A_PER_COUNT;
        }
        counts[x] = (int32_t)lrint(seen / A_PER_COUNT) * LODE_COUNT_FRACTION;
    }
}

// What a leg makes of its duty at the current out of it.
static double leg(const board_t *self, int x, double e, double i_A) {
    const int number = x + 1;
    if (self->rail == number) {
        return -0.5;
    }
    if ((self->dead == number && i_A >= 0.05) || (self->dead == -number && i_A <= -0.05)) {
        return self->dead > 0 ? -0.5 : 0.5; // by the diode of the other side
    }
    return e;
}

// Phase `x` has no current: what flows does so between the other two.
static void move_without(board_t *self, int x, const double u[3], double h) {
    ipmsm_t *m = &self->motor;
    const double at =
        2.0 * CHECK_PI / 3.0 * x + 0.5 * CHECK_PI - m->theta; // across, from the d axis
    const double along = m->id * cos(at) + m->iq * sin(at);
    const double L = m->Ld * cos(at) * cos(at) + m->Lq * sin(at) * sin(at);
    const double more = h / L * ((u[(x + 1) % 3] - u[(x + 2) % 3]) / sqrt(3.0) - m->R * along);
    m->id = (along + more) * cos(at);
    m->iq = (along + more) * sin(at);
}

// The leg whose current neither its switch nor a diode takes: -1: none.
static int blocked(const board_t *self, const double i[3]) {
    const int x = abs(self->dead) - 1;
    if (self->open) {
        return 0;
    }
    if (self->dead == 0 || fabs(i[x]) >= 0.05) {
        return -1;
    }
    const double rest = 0.5 * (self->e[0][(x + 1) % 3] + self->e[0][(x + 2) % 3]);
    return (self->dead > 0 ? self->e[0][x] > rest : self->e[0][x] < rest) ? x : -1;
}

// One period with all gates on, or none.
static void move(board_t *self, bool gates) {
    const double h = (double)PAPER_TS_s / 16.0;
    for (int n = 0; n < 16; n++) {
        double i[3];
        double u[3];
        phases_of(&self->motor, i);
        const int without = blocked(self, i);
        for (int x = 0; x < 3; x++) {
            u[x] = V_BUS_V * leg(self, x, self->e[0][x], i[x]);
        }
        if (!gates) {
            self->motor.id = self->motor.iq = 0.0;
        } else if (without >= 0) {
            move_without(self, without, u, h);
        } else {
            ipmsm_move(&self->motor, (2.0 * u[0] - u[1] - u[2]) / 3.0, (u[1] - u[2]) / sqrt(3.0),
                       h);
        }
        self->peak_A = fmax(self->peak_A, hypot(self->motor.id, self->motor.iq));
    }
}

static void keep(board_t *self, lode_ab_t e) {
    for (int k = 0; k < 3; k++) {
        memcpy(self->e[k], self->e[k + 1], sizeof self->e[k]);
    }
    const lode_abc_t legs = lode_clarke_inverse(e);
    const double voltages[3] = {(double)legs.a, (double)legs.b, (double)legs.c};
    memcpy(self->e[self->late], voltages, sizeof voltages);
}

/// A whole check, of `sets` that are alike; `periods` that it took.
static lode_finding_t checked_by(lode_signal_check_t *check, board_t *self,
                                 const lode_signal_check_tuning_t *tuning, int *periods) {
    lode_signal_check_begin(check, tuning, true);
    *periods = 0;
    while (lode_signal_check_goes_on(check, tuning)) {
        int32_t i[LODE_PHASES];
        sample(self, i);
        const lode_ab_t e = lode_signal_check_step(check, tuning, &sense, i);
        const lode_finding_t found =
            lode_signal_check_judge(check, tuning, (float)V_BUS_V, PAPER_TS_s);
        ++*periods;
        if (found.check != LODE_CHECK_NONE) {
            return found;
        }
        move(self, lode_signal_check_drives(check));
        keep(self, e);
    }
    return (lode_finding_t){LODE_CHECK_NONE, 0.0f, 0.0f};
}

/// The same, where nothing else of it is looked at.
static lode_finding_t checked(board_t *self, const lode_signal_check_tuning_t *tuning,
                              int *periods) {
    lode_signal_check_t check;
    return checked_by(&check, self, tuning, periods);
}

static lode_finding_t once(board_t self) {
    const lode_signal_check_tuning_t tuning = tuned();
    int periods;
    return checked(&self, &tuning, &periods);
}

static double angle_of(int n) {
    return 2.0 * CHECK_PI * n / ANGLES;
}

static void expect(lode_check_t check, board_t self) {
    TEST_ASSERT_EQUAL_STRING(lode_check_name(check), lode_check_name(once(self).check));
}

static void test_what_is_in_order_passes(void) {
    const lode_signal_check_tuning_t tuning = tuned();
    for (int n = 0; n < ANGLES; n++) {
        board_t self = board_at(angle_of(n));
        int periods;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, checked(&self, &tuning, &periods).check);
        TEST_ASSERT_EQUAL_INT(PERIODS, periods);
        CHECK_AT_MOST(0.3 * I_MAX_A, self.peak_A);
        CHECK_AT_LEAST(0.2 * I_MAX_A, self.peak_A); // of the smaller inductance a quarter
    }
}

static void test_gains_two_per_cent_apart_pass(void) {
    for (int n = 0; n < ANGLES; n++) {
        board_t self = board_at(angle_of(n));
        self.gain[0] = self.gain[1] = 1.02;
        self.gain[2] = 0.98;
        expect(LODE_CHECK_NONE, self);
    }
}

static void test_one_gain_that_is_off_shows_in_the_sum(void) {
    static const double gains[] = {0.4, 0.7, 1.5};
    for (int n = 0; n < ANGLES; n++) {
        board_t self = board_at(angle_of(n));
        self.gain[n % 3] = gains[n % COUNT_OF(gains)];
        const lode_finding_t found = once(self);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_SUM", lode_check_name(found.check));
        TEST_ASSERT_TRUE(found.measured > found.limit);
        CHECK_AT_LEAST(0.1, (double)found.limit);
    }
}

/// Where the three add up to none by themselves, or need not.
static void test_sums_that_are_none_of_its_business(void) {
    const lode_motor_t motor = paper_motor();
    lode_signal_check_given_t given = usual;
    given.sums = false;
    lode_signal_check_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_signal_check_tune(&tuning, &start, &inverter, &motor, &adc, given));
    board_t self = board_at(0.3);
    self.gain[0] = 0.7;
    int periods;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, checked(&self, &tuning, &periods).check);
}

/// All gains, or the motor: by the mean of all angles, so wherever the rotor lies.
static void test_an_inductance_that_is_not_the_motors(void) {
    static const struct {
        double gain;
        lode_check_t check;
    } table[] = {{0.4, LODE_CHECK_INDUCTANCE}, {0.45, LODE_CHECK_INDUCTANCE},
                 {0.55, LODE_CHECK_NONE},      {1.0, LODE_CHECK_NONE},
                 {2.3, LODE_CHECK_NONE},       {2.7, LODE_CHECK_INDUCTANCE}};
    const double mean_H = 2.0 / (1.0 / 3.5e-3 + 1.0 / 9.8e-3);
    for (int k = 0; k < COUNT_OF(table); k++) {
        for (int n = 0; n < ANGLES; n++) {
            board_t self = board_at(angle_of(n));
            self.gain[0] = self.gain[1] = self.gain[2] = table[k].gain;
            const lode_finding_t found = once(self);
            TEST_ASSERT_EQUAL_STRING(lode_check_name(table[k].check), lode_check_name(found.check));
            if (found.check != LODE_CHECK_NONE) {
                CHECK_NEAR(0.1 * mean_H / table[k].gain, mean_H / table[k].gain,
                           (double)found.measured);
                CHECK_NEAR(1.0e-5, (table[k].gain < 1.0 ? 2.0 : 0.4) * mean_H, (double)found.limit);
            }
        }
    }
}

static void test_sensors_in_the_wrong_place_or_the_wrong_way(void) {
    static const int places[][3] = {{1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}};
    for (int k = 0; k < COUNT_OF(places); k++) {
        for (int n = 0; n < 2 * ANGLES; n++) {
            board_t self = board_at(angle_of(n));
            memcpy(self.see, places[k], sizeof self.see);
            const double way = n < ANGLES ? 1.0 : -1.0;
            self.gain[0] = self.gain[1] = self.gain[2] = way;
            const lode_finding_t found = once(self);
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_SIGNALS", lode_check_name(found.check));
            TEST_ASSERT_TRUE(found.measured < found.limit);
        }
    }
    for (int n = 0; n < ANGLES; n++) {
        board_t all = board_at(angle_of(n));
        all.gain[0] = all.gain[1] = all.gain[2] = -1.0;
        expect(LODE_CHECK_SIGNALS, all);
        board_t one = board_at(angle_of(n));
        one.gain[n % 3] = -1.0;
        expect(LODE_CHECK_CURRENT_SUM, one);
    }
}

/// Without saliency, and with twice as much of it.
static void test_sensors_in_the_wrong_place_of_other_motors(void) {
    static const int places[][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1},
                                    {2, 1, 0}, {1, 2, 0}, {2, 0, 1}};
    static const double Lq_H[] = {3.5e-3, 17.5e-3};
    for (int m = 0; m < COUNT_OF(Lq_H); m++) {
        const lode_signal_check_tuning_t tuning = tuned_to(3.5e-3, Lq_H[m]);
        for (int k = 0; k < COUNT_OF(places); k++) {
            for (int n = 0; n < 2 * ANGLES; n++) {
                board_t self = board_at(angle_of(n));
                self.motor.Lq = Lq_H[m];
                memcpy(self.see, places[k], sizeof self.see);
                self.gain[0] = self.gain[1] = self.gain[2] = n < ANGLES ? 1.0 : -1.0;
                const lode_check_t right =
                    k == 0 && n < ANGLES ? LODE_CHECK_NONE : LODE_CHECK_SIGNALS;
                int periods;
                TEST_ASSERT_EQUAL_STRING(lode_check_name(right),
                                         lode_check_name(checked(&self, &tuning, &periods).check));
            }
        }
    }
}

static void test_sensors_that_are_stuck(void) {
    for (int n = 0; n < ANGLES; n++) {
        board_t one = board_at(angle_of(n));
        one.stuck_A[n % 3] = 0.02;
        const lode_finding_t found = once(one);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_STUCK", lode_check_name(found.check));
        CHECK_NEAR(0.0, n % 3 + 1, (double)found.measured);
        board_t all = board_at(angle_of(n));
        all.stuck_A[0] = all.stuck_A[1] = all.stuck_A[2] = 0.0;
        const lode_finding_t none = once(all);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_STUCK", lode_check_name(none.check));
        CHECK_NEAR(0.0, 0.0, (double)none.measured);
    }
}

/// In any phase. As much as may be is in none of the pulses.
static void test_an_offset_that_came_after_the_calibration(void) {
    for (int n = 0; n < 6 * ANGLES; n++) {
        const int x = n / ANGLES % 3;
        const double sign = n / ANGLES < 3 ? 1.0 : -1.0;
        board_t self = board_at(angle_of(n));
        self.offset_A[x] = sign * 0.045 * I_MAX_A;
        expect(LODE_CHECK_NONE, self);
        self.offset_A[x] = sign * 0.055 * I_MAX_A;
        const lode_finding_t found = once(self);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OFFSET", lode_check_name(found.check));
        CHECK_NEAR(0.01, 0.055 * I_MAX_A, (double)found.measured);
        CHECK_NEAR(1.0e-6, 0.05 * I_MAX_A, (double)found.limit);
        lode_signal_check_tuning_t just = tuned();
        just.off_A = found.measured;
        int periods;
        TEST_ASSERT_TRUE(checked(&self, &just, &periods).check != LODE_CHECK_OFFSET);
    }
}

static void test_a_phase_that_is_open(void) {
    for (int n = 0; n < ANGLES; n++) {
        board_t self = board_at(angle_of(n));
        self.open = true;
        // Where its axis is that of the rotor, its current is as much as the other two have left.
        const lode_finding_t found = once(self);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE", lode_check_name(found.check));
        CHECK_NEAR(0.0, 1.0, (double)found.measured);
    }
}

static void test_a_switch_that_stays_off(void) {
    for (int n = 0; n < ANGLES; n++) {
        for (int leg_number = -3; leg_number <= 3; leg_number++) {
            board_t self = board_at(angle_of(n));
            self.dead = leg_number;
            const lode_finding_t found = once(self);
            if (leg_number == 0) {
                TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, found.check);
                continue;
            }
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE", lode_check_name(found.check));
            CHECK_NEAR(0.0, abs(leg_number), (double)found.measured);
        }
    }
}

/// At once, before it has more current than a pulse makes.
static void test_a_leg_that_keeps_to_a_rail(void) {
    const lode_signal_check_tuning_t tuning = tuned();
    for (int n = 0; n < ANGLES; n++) {
        board_t self = board_at(angle_of(n));
        self.rail = n % 3 + 1;
        int periods;
        const lode_finding_t found = checked(&self, &tuning, &periods);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_SIGNALS", lode_check_name(found.check));
        TEST_ASSERT_TRUE(found.measured < found.limit);
        CHECK_NEAR(1.0e-5, -0.35 * V_BUS_V * (double)tuning.mean_A_V, (double)found.limit);
        TEST_ASSERT_EQUAL_INT(3, periods);
        CHECK_AT_MOST(I_MAX_A, self.peak_A);
    }
}

static void test_duties_that_act_a_period_late(void) {
    for (int n = 0; n < ANGLES; n++) {
        board_t self = board_at(angle_of(n));
        self.late = 1;
        expect(LODE_CHECK_SIGNALS, self);
    }
}

/// Its EMF flows as current while all gates are on. Without an answer: the start finds it.
static void test_a_rotor_that_turns_after_all_is_passed_over(void) {
    const lode_signal_check_tuning_t tuning = tuned();
    for (int sign = -1; sign <= 1; sign += 2) {
        board_t self = board_at(0.5);
        self.motor.omega = sign * 40.0;
        int periods;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, checked(&self, &tuning, &periods).check);
        TEST_ASSERT_EQUAL_INT(3, periods);
        CHECK_AT_LEAST(0.0147 * I_MAX_A, self.peak_A);
        board_t slow = board_at(0.5);
        slow.motor.omega = sign * 20.0; // 0.12 A: in the sum of three
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, checked(&slow, &tuning, &periods).check);
        TEST_ASSERT_EQUAL_INT(2 * 6 + 3, periods);
        board_t slower = board_at(0.5);
        slower.motor.omega = sign * 5.0;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, checked(&slower, &tuning, &periods).check);
        TEST_ASSERT_EQUAL_INT(PERIODS, periods);
    }
    lode_signal_check_t check;
    lode_signal_check_begin(&check, &tuning, false); // known before
    TEST_ASSERT_FALSE(lode_signal_check_goes_on(&check, &tuning));
    TEST_ASSERT_FALSE(lode_signal_check_drives(&check));
}

static double off_deg(lode_sincos_t axis, double theta);

/// What is in order passes, and is looked at to the end with its axis known; what is not is found as ever.
static void test_noise_of_three_counts_is_no_rotor(void) {
    const lode_signal_check_tuning_t tuning = tuned();
    random_t random = random_seed(21);
    for (int n = 0; n < CHECK_TRIES(1000); n++) {
        board_t self = board_at(angle_of(n));
        self.noise = &random;
        lode_signal_check_t check;
        int periods;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, checked_by(&check, &self, &tuning, &periods).check);
        TEST_ASSERT_EQUAL_INT(PERIODS, periods);
        CHECK_AT_MOST(33.0, off_deg(lode_signal_check_axis(&check), angle_of(n)));
        board_t swapped = board_at(angle_of(n));
        swapped.noise = &random;
        swapped.see[0] = 1;
        swapped.see[1] = 0;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SIGNALS, checked(&swapped, &tuning, &periods).check);
        board_t open = board_at(angle_of(n));
        open.noise = &random;
        open.open = true;
        TEST_ASSERT_NOT_EQUAL(LODE_CHECK_NONE, checked(&open, &tuning, &periods).check);
    }
}

static void test_a_current_before_the_pulse_that_may_be(void) {
    static const int32_t none[LODE_PHASES] = {0, 0, 0};
    static const int32_t some[LODE_PHASES] = {20 * 256, -10 * 256, -10 * 256};
    for (int more = 0; more <= 1; more++) {
        lode_signal_check_tuning_t tuning = tuned();
        lode_signal_check_t check;
        tuning.turns_A = 0.0f;
        for (int pass = 0; pass < 2; pass++) {
            lode_signal_check_begin(&check, &tuning, true);
            for (int n = 0; n < 3; n++) {
                (void)lode_signal_check_step(&check, &tuning, &sense, n == 2 ? some : none);
            }
            CHECK_NEAR(1.0e-4, 0.2, (double)check.before_A);
            tuning.turns_A = more == 1 ? 0.99f * check.before_A : check.before_A;
        }
        TEST_ASSERT_EQUAL_INT(more == 0, lode_signal_check_goes_on(&check, &tuning));
    }
}

/// Before pulse k the sum of k may be 0.006 of i_max times the root of 6 k; of the second set as of the first.
static void test_what_may_flow_before_the_pulses_of_a_set(void) {
    lode_signal_check_tuning_t tuning = tuned();
    tuning.pulses = 12u;
    for (uint32_t pulse = 0u; pulse < 12u; pulse++) {
        const double most_A = 0.006 * I_MAX_A * sqrt(6.0 * (pulse % 6u + 1u));
        for (int more = -1; more <= 1; more += 2) {
            lode_signal_check_t check;
            lode_signal_check_begin(&check, &tuning, true);
            check.pulse = (uint_least8_t)pulse;
            check.axis = 1u;
            const double least_A = 0.01; // of the last one: a count
            check.moves_A.alpha = (float)(most_A + 0.001 * more - least_A);
            const int32_t one[LODE_PHASES] = {256, -128, -128};
            const int32_t none[LODE_PHASES] = {0, 0, 0};
            for (int n = 0; n < 3; n++) {
                (void)lode_signal_check_step(&check, &tuning, &sense, n == 2 ? one : none);
            }
            TEST_ASSERT_EQUAL_INT(more < 0, lode_signal_check_goes_on(&check, &tuning));
            TEST_ASSERT_EQUAL_UINT(more < 0 ? 1u : 0u, check.axis);
        }
    }
}

/// Of six phases the second set comes after the first, and has numbers of its own.
static void test_the_second_set(void) {
    lode_signal_check_tuning_t tuning = tuned();
    tuning.pulses *= 2u;
    int periods;
    board_t both = board_at(0.2);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, checked(&both, &tuning, &periods).check);
    TEST_ASSERT_EQUAL_INT(2 * PERIODS, periods);
    for (int stuck = 0; stuck <= 1; stuck++) {
        lode_signal_check_t check;
        lode_signal_check_begin(&check, &tuning, true);
        board_t self = board_at(0.2);
        lode_finding_t found = {LODE_CHECK_NONE, 0.0f, 0.0f};
        for (int n = 0; n < 2 * PERIODS && found.check == LODE_CHECK_NONE; n++) {
            self.open = n >= PERIODS && stuck == 0;
            self.stuck_A[1] = n >= PERIODS && stuck == 1 ? 0.0 : 1e6;
            int32_t i[LODE_PHASES];
            sample(&self, i);
            const lode_ab_t e = lode_signal_check_step(&check, &tuning, &sense, i);
            found = lode_signal_check_judge(&check, &tuning, (float)V_BUS_V, PAPER_TS_s);
            move(&self, lode_signal_check_drives(&check));
            keep(&self, e);
        }
        TEST_ASSERT_EQUAL_STRING(stuck == 1 ? "LODE_CHECK_CURRENT_STUCK" : "LODE_CHECK_OPEN_PHASE",
                                 lode_check_name(found.check));
        CHECK_NEAR(0.0, stuck == 1 ? 5.0 : 4.0, (double)found.measured);
    }
}

#define MEAN_A 4.0f // that a pulse shows
#define LEAST_A 1.5f

#define BUS_V 200.0f

/// What is said after the last pulse of a set, of what the pulses have shown, with a bus that reads `v_bus_V`.
static lode_finding_t said_at(lode_signal_check_t *shown, uint32_t pulses, float v_bus_V) {
    const lode_signal_check_tuning_t tuning = {.pulse = 0.25f,
                                               .mean_A_V = MEAN_A / BUS_V,
                                               .least_A_V = LEAST_A / BUS_V,
                                               .off_A = 0.5f,
                                               .sum_most = 0.28f,
                                               .turns_A = FLT_MAX,
                                               .moves_A = 0.1f,
                                               .before_most = 0.35f,
                                               .pulses = 12u};
    shown->pulse = (uint_least8_t)pulses;
    return lode_signal_check_judge(shown, &tuning, v_bus_V, 1.0e-4f);
}

static lode_finding_t said_by(lode_signal_check_t *shown, uint32_t pulses) {
    return said_at(shown, pulses, BUS_V);
}

static lode_finding_t said(lode_signal_check_t shown, uint32_t pulses) {
    return said_by(&shown, pulses);
}

/// Three phases alike, and each pulse along its axis.
static lode_signal_check_t sound(void) {
    return (lode_signal_check_t){
        .along = {6.0f * MEAN_A, 0.0f}, .phase_A = {16.0f, 16.0f, 16.0f}, .least_A = LEAST_A};
}

static void expect_said(lode_check_t check, double measured, double limit, lode_finding_t found) {
    TEST_ASSERT_EQUAL_STRING(lode_check_name(check), lode_check_name(found.check));
    CHECK_CLOSE(1.0e-5, measured, found.measured);
    CHECK_CLOSE(1.0e-5, limit, found.limit);
}

/// Of a phase that lacks, of a sum that flows and of currents that do not, whichever phase it is. At a limit nothing is
/// said.
static void test_limits_of_the_sensors(void) {
    for (int x = 0; x < 3; x++) {
        lode_signal_check_t shown = sound();
        shown.phase_A[x] = 0.08f * 16.0f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said(shown, 6u).check);
        shown.phase_A[x] = 0.079f * 16.0f;
        shown.sum_A[x] = -0.1f * 16.0f;
        expect_said(LODE_CHECK_OPEN_PHASE, x + 1, 0.0, said(shown, 6u));
        expect_said(LODE_CHECK_OPEN_PHASE, x + 4, 0.0, said(shown, 12u));
        shown.sum_A[x] = -0.101f * 16.0f;
        expect_said(LODE_CHECK_CURRENT_STUCK, x + 1, 0.0, said(shown, 6u));
        expect_said(LODE_CHECK_CURRENT_STUCK, x + 4, 0.0, said(shown, 12u));
        shown.phase_A[x] = 8.0f; // shows least
        shown.sum_A[x] = 0.28f * 8.0f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said(shown, 6u).check);
        shown.sum_A[x] = 0.2f * 8.0f;
        shown.sum_A[(x + 1) % 3] = -0.081f * 8.0f;
        shown.again = 1u;
        expect_said(LODE_CHECK_CURRENT_SUM, 0.281 * 8.0, 0.28 * 8.0, said(shown, 6u));
        expect_said(LODE_CHECK_CURRENT_SUM, 0.281 * 8.0, 0.28 * 8.0, said(shown, 12u));
        shown = sound();
        for (int y = 0; y < 3; y++) {
            shown.phase_A[y] = 0.5f * MEAN_A;
        }
        shown.phase_A[x] = 0.6f * MEAN_A; // shows most, of six pulses
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said(shown, 6u).check);
        shown.phase_A[x] = 0.59f * MEAN_A;
        expect_said(LODE_CHECK_CURRENT_STUCK, 0.0, 0.0, said(shown, 6u));
        expect_said(LODE_CHECK_CURRENT_STUCK, 0.0, 0.0, said(shown, 12u));
        shown = sound();
        for (int y = 0; y < 3; y++) {
            shown.phase_A[y] = 4.0f;
        }
        shown.phase_A[x] = 50.0f; // beside the one that shows most the others lack nothing yet
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said(shown, 6u).check);
        shown.phase_A[x] = 51.0f;
        expect_said(LODE_CHECK_OPEN_PHASE, x == 0 ? 2.0 : 1.0, 0.0, said(shown, 6u));
    }
}

/// Of the three sensors, in the two pulses of each axis: what has the pulse's sign counts, and what does not cancels (S48).
static void test_sums_have_the_sign_of_their_pulse(void) {
    const lode_signal_check_tuning_t tuning = tuned();
    for (int with = 0; with <= 1; with++) {
        lode_signal_check_t check;
        lode_signal_check_begin(&check, &tuning, true);
        for (int n = 0; n < PERIODS; n++) {
            const int pulse = n / 6;
            const int32_t way = with == 1 && pulse >= 3 ? -1 : 1;
            const int32_t some = n % 6 == 3 ? way * 1000 * (pulse % 3 + 1) : 0; // its weight is 2
            const int32_t i[LODE_PHASES] = {some, some, some};
            (void)lode_signal_check_step(&check, &tuning, &sense, i);
        }
        for (int axis = 0; axis < 3; axis++) {
            const double each = 2.0 * 3.0 * 1000.0 * (axis + 1) * fabs((double)sense.i_gain);
            CHECK_NEAR(1.0e-4 * each, with == 1 ? 2.0 * each : 0.0, check.sum_A[axis]);
        }
    }
}

/// A sum beyond its limit may be noise: the set is made once more, and what it has shown is forgotten (S48).
static void test_a_sum_is_believed_when_it_is_seen_twice(void) {
    for (uint32_t set = 1u; set <= 2u; set++) {
        lode_signal_check_t shown = sound();
        shown.sum_A[set] = 0.29f * 16.0f;
        shown.axis = 2u;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said_by(&shown, 6u * set).check);
        TEST_ASSERT_EQUAL_UINT(6u * (set - 1u), shown.pulse);
        TEST_ASSERT_EQUAL_UINT(2u, shown.axis);
        CHECK_NEAR(0.0, 0.0, shown.sum_A[set]);
        const lode_signal_check_t twice = shown;
        shown = sound();
        shown.again = twice.again;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said_by(&shown, 6u * set).check);
        TEST_ASSERT_EQUAL_UINT(6u * set, shown.pulse); // it passes; the next set has its own two
        TEST_ASSERT_EQUAL_UINT(0u, shown.again);
        shown = sound();
        shown.again = twice.again;
        shown.sum_A[set] = 0.29f * 16.0f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_SUM, said_by(&shown, 6u * set).check);
    }
}

static void test_limits_of_the_bridge(void) {
    lode_signal_check_t shown = sound();
    expect_said(LODE_CHECK_NONE, 1.0, 0.0, said(shown, 6u)); // 1: the pulse that shows least
    shown.before_A = 0.349f * MEAN_A;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said(shown, 6u).check);
    shown.before_A = 0.351f * MEAN_A;
    expect_said(LODE_CHECK_SIGNALS, -0.351 * (double)MEAN_A, -0.35 * (double)MEAN_A,
                said(shown, 6u));
    shown = sound();
    shown.mirrored.beta = 6.0f * 0.6f * MEAN_A;
    shown.along.beta = -6.0f * 0.34f * MEAN_A;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said(shown, 6u).check);
    shown.along.beta = -6.0f * 0.36f * MEAN_A;
    expect_said(LODE_CHECK_SIGNALS, 0.04 * (double)MEAN_A, 0.05 * (double)MEAN_A, said(shown, 6u));
    shown = sound();
    shown.along.alpha =
        6.0f * (0.05f * MEAN_A); // far too little of an inductance, but along its axis
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_INDUCTANCE, said(shown, 6u).check);
    shown = sound();
    shown.least = 4u; // to the negative side of c
    shown.least_A = 0.99f * LEAST_A;
    expect_said(LODE_CHECK_OPEN_PHASE, 3.0, 0.0, said(shown, 6u));
    expect_said(LODE_CHECK_OPEN_PHASE, 6.0, 0.0, said(shown, 12u));
}

/// A pulse may show much less than an ampere.
static void test_a_small_motor_is_in_order(void) {
    lode_signal_check_t shown = {
        .along = {0.6f * MEAN_A, 0.0f}, .phase_A = {1.6f, 1.6f, 1.6f}, .least_A = 0.11f * LEAST_A};
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, said_at(&shown, 6u, 0.1f * BUS_V).check);
}

/// Without a bus there is no current to expect: whatever flowed, nothing is divided by it.
static void test_a_bus_that_reads_nothing_shows_nothing(void) {
    lode_signal_check_t shown = sound();
    expect_said(LODE_CHECK_SIGNALS, (double)MEAN_A, 0.0, said_at(&shown, 6u, 0.0f));
    shown = sound();
    shown.along.alpha = 0.0f;
    expect_said(LODE_CHECK_SIGNALS, 0.0, 0.0, said_at(&shown, 6u, 0.0f));
}

/// Neither before the first period nor within a pulse.
static void test_nothing_is_said_before_the_last_pulse(void) {
    const lode_signal_check_tuning_t tuning = tuned();
    lode_signal_check_t check;
    lode_signal_check_begin(&check, &tuning, true);
    expect_said(LODE_CHECK_NONE, 0.0, 0.0,
                lode_signal_check_judge(&check, &tuning, (float)V_BUS_V, PAPER_TS_s));
    lode_signal_check_t shown = {.period = 0u};
    expect_said(LODE_CHECK_NONE, 0.0, 0.0, said(shown, 5u));
    expect_said(LODE_CHECK_CURRENT_STUCK, 0.0, 0.0, said(shown, 6u));
    shown.period = 1u;
    expect_said(LODE_CHECK_NONE, 0.0, 0.0, said(shown, 6u));
}

/// Gates on for four periods of six, voltage in the third and the fourth, to both sides of each axis.
static void test_pulses_in_their_order(void) {
    static const double degrees[] = {0.0, 300.0, 120.0, 180.0, 60.0, 240.0};
    static const int32_t none[LODE_PHASES] = {0, 0, 0};
    const lode_signal_check_tuning_t tuning = tuned();
    lode_signal_check_t check;
    lode_signal_check_begin(&check, &tuning, true);
    bool seen[6] = {false};
    for (int n = 0; n < PERIODS; n++) {
        TEST_ASSERT_EQUAL_INT(n % 6 >= 1 && n % 6 <= 4, lode_signal_check_drives(&check));
        const lode_ab_t e = lode_signal_check_step(&check, &tuning, &sense, none);
        const double length = hypot((double)e.alpha, (double)e.beta);
        const double sign = n % 6 == 1 ? 1.0 : (n % 6 == 2 ? -1.0 : 0.0);
        CHECK_NEAR(1.0e-6, fabs(sign) * (double)tuning.pulse, length);
        for (int k = 0; k < 6 && n % 6 == 1; k++) {
            const double at = degrees[k] * CHECK_DEG;
            seen[k] = seen[k] || hypot((double)e.alpha - length * cos(at),
                                       (double)e.beta - length * sin(at)) < 1.0e-6;
        }
    }
    for (int k = 0; k < 6; k++) {
        TEST_ASSERT_TRUE(seen[k]);
    }
    TEST_ASSERT_FALSE(lode_signal_check_goes_on(&check, &tuning));
}

/// With numbers whose products are exact: 8 A of a pulse are 64 counts of 0.125 A.
static void test_sixty_four_counts_are_enough(void) {
    lode_motor_t motor = paper_motor();
    motor.Ld_H = motor.Lq_H = 1.0f / 256.0f;
    const lode_inverter_config_t bridge = {.v_bus_V = 1024.0f, .i_max_A = 16.0f};
    const lode_signal_check_given_t given = {1.0f / 8192.0f, true, true};
    for (int more = 0; more <= 1; more++) {
        const lode_sense_config_t seen = {.i_gain_A_count = more == 1 ? 0.1251f : 0.125f,
                                          .duty_max = 1.0f};
        lode_signal_check_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(
            LODE_OK, lode_signal_check_tune(&tuning, &start, &bridge, &motor, &seen, given));
        CHECK_NEAR(1.0e-6, 0.125, (double)tuning.pulse);
        TEST_ASSERT_EQUAL_UINT(more == 1 ? 0u : 6u, tuning.pulses);
    }
}

/// `pulses`: of the low sides.
static lode_signal_check_tuning_t tuned_with(lode_choice_t choice, lode_inverter_config_t bridge,
                                             lode_sense_config_t seen, bool pulses,
                                             lode_status_t expected) {
    const lode_motor_t motor = paper_motor();
    lode_start_config_t config = start;
    config.signal_check = choice;
    config.pulses = pulses ? LODE_AUTO : LODE_OFF;
    lode_signal_check_given_t given = usual;
    given.pulses = pulses;
    lode_signal_check_tuning_t tuning = {.pulses = 99u};
    TEST_ASSERT_EQUAL_STRING(
        lode_status_name(expected),
        lode_status_name(lode_signal_check_tune(&tuning, &config, &bridge, &motor, &seen, given)));
    return tuning;
}

/// Auto: off where it would tell nothing. On: refused there, and the tuning left alone.
static void test_where_there_is_no_check(void) {
    lode_inverter_config_t slow = inverter;
    slow.dead_time_s = 2.0e-5f; // 10 % of the period
    lode_sense_config_t coarse = adc;
    coarse.i_gain_A_count = 0.05f;
    TEST_ASSERT_EQUAL_UINT(6u, tuned_with(LODE_AUTO, inverter, adc, true, LODE_OK).pulses);
    TEST_ASSERT_EQUAL_UINT(6u, tuned_with(LODE_ON, inverter, adc, true, LODE_OK).pulses);
    TEST_ASSERT_EQUAL_UINT(0u, tuned_with(LODE_OFF, inverter, adc, true, LODE_OK).pulses);
    TEST_ASSERT_EQUAL_UINT(0u, tuned_with(LODE_AUTO, inverter, adc, false, LODE_OK).pulses);
    lode_inverter_config_t twice = inverter;
    twice.double_update = LODE_ON;
    for (int n = 0; n < 4; n++) { // without low-side pulses, whoever says so
        const bool both = n == 3;
        const lode_motor_t motor = paper_motor();
        const lode_start_config_t board = {.pulses = n % 2 == 1 ? LODE_AUTO : LODE_OFF};
        const lode_signal_check_given_t given = {PAPER_TS_s, false, true};
        lode_signal_check_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK,
                              lode_signal_check_tune(&tuning, &board, n < 2 ? &inverter : &twice,
                                                     &motor, &adc, given));
        TEST_ASSERT_EQUAL_UINT(both ? 6u : 0u, tuning.pulses);
    }
    TEST_ASSERT_EQUAL_UINT(0u, tuned_with(LODE_AUTO, slow, adc, true, LODE_OK).pulses);
    TEST_ASSERT_EQUAL_UINT(0u, tuned_with(LODE_AUTO, inverter, coarse, true, LODE_OK).pulses);
    const lode_status_t no = LODE_ERROR_CHOICE;
    TEST_ASSERT_EQUAL_UINT(6u, tuned_with(LODE_ON, inverter, adc, false, LODE_OK).pulses);
    TEST_ASSERT_EQUAL_UINT(99u, tuned_with(LODE_ON, slow, adc, true, no).pulses);
    TEST_ASSERT_EQUAL_UINT(99u, tuned_with(LODE_ON, inverter, coarse, true, no).pulses);
    TEST_ASSERT_EQUAL_UINT(99u, tuned_with((lode_choice_t)7, inverter, adc, true, no).pulses);
}

/// Nobody has looked whether the rotor turns. A current before the pulse says so, however large; else all is as ever.
static void test_a_rotor_that_turns_where_nobody_has_looked(void) {
    const lode_signal_check_tuning_t alone = tuned_with(LODE_ON, inverter, adc, false, LODE_OK);
    for (int sign = -1; sign <= 1; sign += 2) {
        int periods;
        board_t fast = board_at(0.5);
        fast.motor.omega = sign * 471.0; // rated
        const lode_signal_check_tuning_t known = tuned();
        board_t other = fast;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SIGNALS, checked(&other, &known, &periods).check);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, checked(&fast, &alone, &periods).check);
        TEST_ASSERT_EQUAL_INT(3, periods);
        // One that turns too slowly to be passed over: 0.52 of the 0.61 A that may flow before. Its EMF is in none of the rest.
        for (int n = 0; n < ANGLES; n++) {
            board_t slow = board_at(angle_of(n));
            slow.motor.omega = sign * 90.0;
            lode_signal_check_t check;
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE,
                                  checked_by(&check, &slow, &alone, &periods).check);
            TEST_ASSERT_EQUAL_INT(PERIODS, periods);
        }
        board_t rests = board_at(0.5);
        rests.gain[0] = rests.gain[1] = rests.gain[2] = -1.0;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SIGNALS, checked(&rests, &alone, &periods).check);
    }
}

/// Of another set's pulses a current may still flow that an EMF has driven: twice the one from before.
static void test_a_current_that_is_left_is_no_offset(void) {
    static const int32_t some[LODE_PHASES] = {100 * 256, -50 * 256, -50 * 256};
    lode_signal_check_tuning_t tuning = tuned();
    tuning.pulses = 12u;
    lode_signal_check_t check;
    for (int n = 0; n < 12; n++) {
        lode_signal_check_begin(&check, &tuning, true);
        check.pulse = (uint_least8_t)n;
        (void)lode_signal_check_step(&check, &tuning, &sense, some);
        CHECK_NEAR(1.0e-5, n % 6 == 0 ? 1.0 : 0.0, (double)check.off_A); // the first of a set
    }
    for (int more = 0; more < 2; more++) {
        lode_signal_check_begin(&check, &tuning, true);
        check.pulse = 6u;
        check.before_A = (more == 1 ? 0.51f : 0.49f) * tuning.off_A;
        (void)lode_signal_check_step(&check, &tuning, &sense, some);
        CHECK_NEAR(1.0e-5, more == 1 ? 0.0 : 1.0, (double)check.off_A);
    }
    check.before_A = 1.0f;
    lode_signal_check_begin(&check, &tuning, true);
    CHECK_AT_MOST(0.0, (double)check.before_A);
}

/// A current that an EMF drives by 0.1 A in each period, and 0.5 A by the pulse, of which twice is seen: with no voltage 0.2 A
/// have flowed, when it ends 0.8 A do.
static void test_what_rises_is_without_the_emf(void) {
    static const int32_t shown[] = {0, 10, 20, 80};
    const lode_signal_check_tuning_t tuning = tuned_with(LODE_ON, inverter, adc, false, LODE_OK);
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_signal_check_t check;
        lode_signal_check_begin(&check, &tuning, true);
        check.pulse = sign > 0 ? 0u : 3u; // along a, and against it
        for (int n = 0; n < COUNT_OF(shown); n++) {
            const int32_t a = shown[n] * sign * LODE_COUNT_FRACTION;
            const int32_t i[LODE_PHASES] = {a, -a / 2, -a / 2};
            (void)lode_signal_check_step(&check, &tuning, &sense, i);
        }
        CHECK_NEAR(1.0e-5, 0.2, (double)check.before_A);
        CHECK_NEAR(1.0e-5, 2.0 * 0.5, (double)check.least_A);
    }
}

/// (I10): a call has half of the dead time of a carrier period, and the whole drop.
static void test_dead_time_of_double_update(void) {
    lode_inverter_config_t bridge = inverter;
    bridge.dead_time_s = 1.9e-5f;
    bridge.v_drop_V = 1.0f;
    bridge.double_update = LODE_ON;
    const double least_V =
        4.0 * 4.0 / 3.0 * (1.0 + V_BUS_V * (1.9e-5 + 1.0e-6) / (2.0 * (double)PAPER_TS_s));
    const lode_signal_check_tuning_t found = tuned_with(LODE_AUTO, bridge, adc, true, LODE_OK);
    CHECK_NEAR(1.0e-5, least_V / V_BUS_V, (double)found.pulse);
    TEST_ASSERT_EQUAL_UINT(6u, found.pulses);
    bridge.double_update = LODE_OFF;
    TEST_ASSERT_EQUAL_UINT(0u, tuned_with(LODE_AUTO, bridge, adc, true, LODE_OK).pulses);
}

/// A quarter of i_max through the smaller inductance; more where dead time takes more than a quarter of that, up to what a
/// duty and low-side shunts leave.
static void test_voltage_of_a_pulse(void) {
    const double quarter_V = 0.25 * I_MAX_A * 3.5e-3 / (double)PAPER_TS_s;
    CHECK_NEAR(1.0e-5, quarter_V / V_BUS_V, (double)tuned().pulse);
    lode_inverter_config_t dead = inverter;
    dead.dead_time_s = 9.0e-6f;
    dead.v_drop_V = 1.0f;
    const double least_V = 4.0 * 4.0 / 3.0 * (1.0 + V_BUS_V * 1.0e-5 / (double)PAPER_TS_s);
    TEST_ASSERT_TRUE(least_V > quarter_V);
    const lode_signal_check_tuning_t more = tuned_with(LODE_AUTO, dead, adc, true, LODE_OK);
    CHECK_NEAR(1.0e-5, least_V / V_BUS_V, (double)more.pulse);
    lode_sense_config_t window = adc;
    window.duty_max = 0.7f;
    const lode_signal_check_tuning_t less = tuned_with(LODE_AUTO, inverter, window, true, LODE_OK);
    CHECK_NEAR(1.0e-6, 0.98 * 0.2, (double)less.pulse);
    // What it shows, of both inductances.
    CHECK_NEAR(1.0e-6, (double)less.pulse * (double)PAPER_TS_s * (1.0 / 3.5e-3 + 1.0 / 9.8e-3),
               (double)less.mean_A_V);
    CHECK_NEAR(1.0e-6, 0.3 * 2.0 * (double)less.pulse * (double)PAPER_TS_s / 9.8e-3,
               (double)less.least_A_V);
}

static void expect_nothing(lode_finding_t found) {
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_NONE", lode_check_name(found.check));
}

/// The axis that a check of `self` finds; no sine and no cosine: none.
static lode_sincos_t axis_seen(board_t self, const lode_signal_check_tuning_t *tuning) {
    lode_signal_check_t check;
    int periods;
    expect_nothing(checked_by(&check, &self, tuning, &periods));
    return lode_signal_check_axis(&check);
}

/// Degrees from the axis to the d axis or its opposite, by size.
static double off_deg(lode_sincos_t axis, double theta) {
    CHECK_NEAR(1.0e-6, 1.0, hypot((double)axis.sin, (double)axis.cos));
    const double at = atan2((double)axis.sin, (double)axis.cos);
    return fabs(remainder(theta - at, CHECK_PI)) * 180.0 / CHECK_PI;
}

/// (S40). Of six axes 60 degrees apart the next one is within 30 degrees; gains that differ as sensors' do add little.
static void test_the_axis_next_to_the_rotor_is_found(void) {
    const lode_signal_check_tuning_t tuning = tuned();
    for (int k = 0; k < 72; k++) {
        const double theta = (double)k * CHECK_PI / 36.0;
        board_t board = board_at(theta);
        CHECK_AT_MOST(30.5, off_deg(axis_seen(board, &tuning), theta));
        board.gain[0] = 1.02;
        board.gain[1] = board.gain[2] = 0.98;
        CHECK_AT_MOST(31.5, off_deg(axis_seen(board, &tuning), theta));
    }
}

/// As long as there is more of it than of gains that differ: to within 25 degrees, or it is not known.
static void test_an_axis_is_known_by_enough_saliency(void) {
    int known[3] = {0, 0, 0};
    const double Lq_H[] = {3.5e-3, 3.75e-3, 4.6e-3};
    for (int n = 0; n < COUNT_OF(Lq_H); n++) {
        const lode_signal_check_tuning_t tuning = tuned_to(3.5e-3, Lq_H[n]);
        for (int k = 0; k < ANGLES; k++) {
            for (int x = 0; x < 3; x++) {
                const double theta = (double)k * 2.0 * CHECK_PI / ANGLES;
                board_t board = board_at(theta);
                board.motor.Lq = Lq_H[n];
                board.gain[0] = board.gain[1] = board.gain[2] = 0.98;
                board.gain[x] = 1.02;
                const lode_sincos_t axis = axis_seen(board, &tuning);
                if (hypot((double)axis.sin, (double)axis.cos) > 0.0) {
                    known[n]++;
                    CHECK_AT_MOST(55.0, off_deg(axis, theta));
                }
            }
        }
    }
    TEST_ASSERT_EQUAL_INT(0, known[0]);
    TEST_ASSERT_TRUE(known[1] > 0 && known[1] < 3 * ANGLES);
    TEST_ASSERT_EQUAL_INT(3 * ANGLES, known[2]);
}

/// Another set, and another check, say nothing of it; a rotor that turns after all has none.
static void test_the_axis_is_that_of_set_1_at_rest(void) {
    lode_signal_check_tuning_t tuning = tuned();
    lode_signal_check_t check;
    int periods;
    board_t board = board_at(1.0);
    tuning.pulses = 12u;
    expect_nothing(checked_by(&check, &board, &tuning, &periods));
    TEST_ASSERT_EQUAL_INT(2 * PERIODS, periods);
    CHECK_AT_MOST(30.5, off_deg(lode_signal_check_axis(&check), 1.0));
    lode_signal_check_t turns = check;
    turns.pulse = 6u; // of set 2
    const int32_t none[LODE_PHASES] = {0, 0, 0};
    const int32_t some[LODE_PHASES] = {80 * 256, -40 * 256, -40 * 256};
    for (int n = 0; n < 3; n++) {
        (void)lode_signal_check_step(&turns, &tuning, &sense, n == 2 ? some : none);
    }
    TEST_ASSERT_FALSE(lode_signal_check_goes_on(&turns, &tuning));
    TEST_ASSERT_EQUAL_UINT(0u, turns.axis);
    lode_signal_check_begin(&check, &tuning, false);
    TEST_ASSERT_EQUAL_UINT(0u, check.axis);
    const lode_sincos_t unknown = lode_signal_check_axis(&check);
    CHECK_NEAR(0.0, 0.0, hypot((double)unknown.sin, (double)unknown.cos));
}

/// Of what is along the axes 0.03 and 1.6 times 0.1 A of noise; of set 1, in which nothing is wrong.
static void test_limits_of_the_axis(void) {
    const double least = 0.03 * 6.0 * (double)MEAN_A + 0.16;
    const double deg[] = {0.0, 59.0, 61.0, 179.0, 181.0, 299.0, 301.0};
    const uint32_t wanted[] = {1u, 1u, 2u, 2u, 3u, 3u, 1u};
    for (int n = 0; n < COUNT_OF(deg); n++) {
        const double at = deg[n] * CHECK_PI / 180.0;
        lode_signal_check_t shown = sound();
        shown.mirrored =
            (lode_ab_t){(float)(1.01 * least * cos(at)), (float)(1.01 * least * sin(at))};
        lode_signal_check_t first = shown;
        expect_nothing(said_by(&first, 6u));
        TEST_ASSERT_EQUAL_UINT(wanted[n], first.axis);
        lode_signal_check_t second = shown;
        expect_nothing(said_by(&second, 12u));
        TEST_ASSERT_EQUAL_UINT(0u, second.axis);
        lode_signal_check_t wrong = shown;
        wrong.off_A = 0.6f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OFFSET, said_by(&wrong, 6u).check);
        TEST_ASSERT_EQUAL_UINT(0u, wrong.axis);
        shown.mirrored.alpha *= 0.98f;
        shown.mirrored.beta *= 0.98f;
        expect_nothing(said_by(&shown, 6u));
        TEST_ASSERT_EQUAL_UINT(0u, shown.axis);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_limits_of_the_axis);
    RUN_TEST(test_the_axis_next_to_the_rotor_is_found);
    RUN_TEST(test_an_axis_is_known_by_enough_saliency);
    RUN_TEST(test_the_axis_is_that_of_set_1_at_rest);
    RUN_TEST(test_what_is_in_order_passes);
    RUN_TEST(test_gains_two_per_cent_apart_pass);
    RUN_TEST(test_one_gain_that_is_off_shows_in_the_sum);
    RUN_TEST(test_sums_that_are_none_of_its_business);
    RUN_TEST(test_an_inductance_that_is_not_the_motors);
    RUN_TEST(test_sensors_in_the_wrong_place_or_the_wrong_way);
    RUN_TEST(test_sensors_in_the_wrong_place_of_other_motors);
    RUN_TEST(test_sensors_that_are_stuck);
    RUN_TEST(test_an_offset_that_came_after_the_calibration);
    RUN_TEST(test_a_phase_that_is_open);
    RUN_TEST(test_a_switch_that_stays_off);
    RUN_TEST(test_a_leg_that_keeps_to_a_rail);
    RUN_TEST(test_duties_that_act_a_period_late);
    RUN_TEST(test_a_rotor_that_turns_after_all_is_passed_over);
    RUN_TEST(test_noise_of_three_counts_is_no_rotor);
    RUN_TEST(test_what_may_flow_before_the_pulses_of_a_set);
    RUN_TEST(test_a_current_before_the_pulse_that_may_be);
    RUN_TEST(test_the_second_set);
    RUN_TEST(test_limits_of_the_sensors);
    RUN_TEST(test_sums_have_the_sign_of_their_pulse);
    RUN_TEST(test_a_sum_is_believed_when_it_is_seen_twice);
    RUN_TEST(test_limits_of_the_bridge);
    RUN_TEST(test_a_small_motor_is_in_order);
    RUN_TEST(test_a_bus_that_reads_nothing_shows_nothing);
    RUN_TEST(test_nothing_is_said_before_the_last_pulse);
    RUN_TEST(test_pulses_in_their_order);
    RUN_TEST(test_sixty_four_counts_are_enough);
    RUN_TEST(test_where_there_is_no_check);
    RUN_TEST(test_a_rotor_that_turns_where_nobody_has_looked);
    RUN_TEST(test_a_current_that_is_left_is_no_offset);
    RUN_TEST(test_what_rises_is_without_the_emf);
    RUN_TEST(test_dead_time_of_double_update);
    RUN_TEST(test_voltage_of_a_pulse);
    return UNITY_END();
}
