// I-f start: profile of the vector, damping of the rotor's swing, conditions of the hand-over.
#include "support/fields.h"

#include "lodestar/current.h"
#include "start_inline.h"

void setUp(void) {}

void tearDown(void) {}

static const lode_inverter_config_t inverter = {.v_bus_V = 200.0f, .i_max_A = 12.0f};
#define OMEGA_MAX 1178.0f

static lode_start_config_t sound(void) {
    return (lode_start_config_t){.current_A = 8.0f,
                                 .current_last_A = 10.0f,
                                 .omega_handover_rad_s = 47.0f,
                                 .ramp_rad_s2 = 100.0f,
                                 .current_rise_s = 0.2f,
                                 .damping = 0.3f,
                                 .lock_s = 0.05f,
                                 .catch_s = 0.05f,
                                 .timeout_s = 3.0f,
                                 .measure = LODE_OFF,
                                 .fade_s = 0.1f};
}

/// The same, with resistance and dead time measured, and no look for a rotor that turns already.
static lode_start_config_t measuring(void) {
    lode_start_config_t config = sound();
    config.measure = LODE_ON;
    config.catch_s = LODE_NONE;
    return config;
}

static lode_start_tuning_t tuned(const lode_start_config_t *config) {
    const lode_motor_t motor = paper_motor();
    lode_start_tuning_t tuning;
    TEST_ASSERT_EQUAL_STRING("LODE_OK",
                             lode_status_name(lode_start_tune(&tuning, config, &inverter, &motor,
                                                              OMEGA_MAX, PAPER_TS_s)));
    return tuning;
}

static lode_status_t try_one(size_t offset, float value);

static const lode_ab_t no_emf = {0.0f, 0.0f};

#define ROUND ((int)LODE_SLOW_PERIODS)

static double angle_of(lode_sincos_t vector) {
    return (double)lode_atan2(vector.sin, vector.cos);
}

/// As a drive in START does it.
static void aim(lode_start_t *start, const lode_start_tuning_t *tuning, float omega,
                float current) {
    if (lode_start_aim(start, tuning, omega, current)) {
        lode_start_again(start, tuning);
    }
}

/// Period `n` of a drive in START; returns the angle of the vector.
static float step(lode_start_t *start, const lode_start_tuning_t *tuning, int n, float omega,
                  float current, lode_ab_t e) {
    if (n % ROUND == 1) {
        aim(start, tuning, omega, current);
    }
    (void)lode_start_step(start, tuning, e, PAPER_TS_s);
    return (float)angle_of(lode_start_vector(start));
}

/// (K35): a step of the vector's speed may be less than that speed's last digit, 2.4e-4 at 4000 rad/s.
static void test_no_step_of_the_vector_is_lost_to_rounding(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.0f), 4000.0f * (float)sign, 8.0f);
        start.current_target = 8.0f;
        start.stage = LODE_START_TURN;
        start.omega_target = 5000.0f * (float)sign;
        start.omega_step = 5.0e-5f;
        for (int n = 0; n < 1000000; n++) {
            (void)lode_start_step(&start, &tuning, no_emf, 1.0e-5f);
        }
        CHECK_NEAR(1.0e-3, 4050.0 * sign, start.omega_rad_s);
    }
}

static void test_current_rises_first_then_the_vector_turns(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 0.0f);
        for (int n = 1; n <= 3600; n++) {
            (void)step(&start, &tuning, n, 47.0f * (float)sign, 8.0f, no_emf);
            const double t = 2.0e-4 * n;
            // Two periods of slack where one ramp ends and the other begins; float sums.
            CHECK_NEAR(0.03, fmin(8.0, 8.0 * t / 0.2), start.current_A);
            CHECK_NEAR(0.06, sign * fmin(47.0, fmax(0.0, 100.0 * (t - 0.2))), start.omega_rad_s);
        }
    }
}

static void test_angle_is_the_integral_of_the_speed(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.5f), 0.0f, 8.0f); // the current is there already
        double theta = 0.5;
        for (int n = 1; n <= 4000; n++) {
            const float angle = step(&start, &tuning, n, 47.0f * (float)sign, 8.0f, no_emf);
            theta += 2.0e-4 * (double)start.omega_rad_s;
            // 4000 additions to a wrapped angle of float resolution.
            CHECK_NEAR(5.0e-4, 0.0, angle_error(theta, (double)angle));
        }
    }
}

static void test_the_vector_sweeps_while_the_current_rises(void) {
    // A rotor that lies opposite to a standing vector feels no torque: it must not stand still,
    // and it turns the way that is wanted.
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 0.0f);
        double swept = 0.0;
        float before = 0.0f;
        for (int n = 1; n <= 1000; n++) { // 0.2 s
            const float angle = step(&start, &tuning, n, 47.0f * (float)sign, 8.0f, no_emf);
            swept += sign * angle_error((double)angle, (double)before);
            before = angle;
        }
        CHECK_CLOSE(0.01, 4.0 / 3.0 * CHECK_PI, swept); // from phase axis to phase axis
    }
}

/// (S29): to half of the current 240 degrees, to all of it 60 more.
static void test_a_vector_that_is_measured_sweeps_to_two_axes(void) {
    lode_start_config_t config = measuring();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    double swept = 0.0;
    double at_half = 0.0;
    float before = 0.0f;
    for (int n = 1; n <= 5000 && start.stage != LODE_START_TURN; n++) {
        lode_start_found_t found;
        if (n % ROUND == 2) {
            (void)lode_start_measure(&start, &tuning, no_emf, &found);
        }
        const float angle = step(&start, &tuning, n, 47.0f, 8.0f, no_emf);
        swept += angle_error((double)angle, (double)before);
        before = angle;
        at_half = start.stage == LODE_START_HALF ? swept : at_half;
    }
    TEST_ASSERT_EQUAL_INT(LODE_START_TURN, start.stage);
    CHECK_CLOSE(0.02, 4.0 / 3.0 * CHECK_PI, at_half);
    CHECK_CLOSE(0.02, 5.0 / 3.0 * CHECK_PI, swept);
}

/// (S40). Ahead of the axis in the direction asked for, and no sweep, with half of the current and with all of it; in the attempt
/// that follows, and after a stop, nothing is known of the rotor any more.
static void test_a_vector_that_leads_the_axis_stands(void) {
    const lode_start_config_t config = measuring();
    const lode_start_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int k = 0; k < 6; k++) {
            lode_start_t start;
            lode_start_begin(&start, &tuning);
            lode_start_lead(&start, lode_sincos((float)(k * CHECK_PI / 3.0)), 5.0f * (float)sign);
            const double ahead = k * CHECK_PI / 3.0 + sign * 2.0 * CHECK_PI / 3.0;
            int n = 1;
            for (; n <= 5000 && start.stage != LODE_START_TURN; n++) {
                lode_start_found_t found;
                if (n % ROUND == 2) {
                    (void)lode_start_measure(&start, &tuning, no_emf, &found);
                }
                const float angle = step(&start, &tuning, n, 47.0f * (float)sign, 8.0f, no_emf);
                CHECK_NEAR(1.0e-5, 0.0, angle_error(ahead, (double)angle));
            }
            TEST_ASSERT_EQUAL_INT(LODE_START_TURN, start.stage);
            CHECK_NEAR(0.01, 8.0, start.current_A);
            lode_start_t again = start;
            lode_start_again(&again, &tuning);
            TEST_ASSERT_EQUAL_UINT(0u, again.stands);
            (void)lode_start_aim(&start, &tuning, 0.0f, 8.0f);
            TEST_ASSERT_EQUAL_UINT(1u, start.stands);
            (void)lode_start_aim(&start, &tuning, 0.0f, 0.0f);
            TEST_ASSERT_EQUAL_UINT(0u, start.stands);
        }
    }
}

/// What the first vectors turn.
typedef struct {
    double J_kgm2;         ///< told
    double error;          ///< times that is true
    double load;           ///< of the largest torque, against any motion
    double rise_s;         ///< of the current; 0: 0.2
    unsigned int attempts; ///< that the rotor is given
} shaft_t;

/// One period of a rotor that is pulled by `pull`, of the largest torque, with what the load leaves.
static double speed_after(const shaft_t *shaft, double omega, double pull, double swing) {
    const bool rests = !(fabs(omega) > 0.0);
    if (rests && fabs(pull) <= shaft->load) {
        return 0.0;
    }
    const double left = pull - copysign(shaft->load, rests ? pull : omega);
    const double after = omega + (double)PAPER_TS_s * swing * swing / shaft->error * left;
    return shaft->load > 0.0 && after * omega < 0.0 ? 0.0 : after;
}

/// Degrees by which a rotor turns back until its vector has its speed, or the attempts are over.
/// The first vector sweeps, or leads by `lead_rad` of either sign.
static double turned_back_deg(const shaft_t *shaft, double theta0_rad, double lead_rad) {
    lode_motor_t motor = paper_motor();
    motor.Lq_H = motor.Ld_H;
    motor.J_kgm2 = (float)shaft->J_kgm2;
    const double K = 1.5 * 3.0 * (double)motor.psi_Wb * 8.0;
    const double swing = sqrt(3.0 * K / shaft->J_kgm2);
    lode_start_config_t config = measuring();
    config.damping = 0.5f;
    config.omega_handover_rad_s = (float)(2.0 * swing);
    config.ramp_rad_s2 = (float)(0.1 * swing * swing);
    config.timeout_s = 100.0f;
    config.current_rise_s = lode_given_or((float)shaft->rise_s, config.current_rise_s);
    lode_start_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_start_tune(&tuning, &config, &inverter, &motor, 1.0e4f, PAPER_TS_s));
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    if (fabs(lead_rad) > 0.0) {
        const double axis = theta0_rad + lead_rad - 2.0 * CHECK_PI / 3.0;
        lode_start_lead(&start, lode_sincos((float)axis), 1.0f);
    }
    double theta = theta0_rad;
    double omega = 0.0;
    double lowest = theta0_rad;
    for (int n = 1; start.failed < shaft->attempts; n++) {
        if (start.failed + 1u == shaft->attempts && start.omega_rad_s >= 2.0f * (float)swing) {
            break;
        }
        const double e_V = (double)motor.psi_Wb * omega;
        const lode_ab_t seen_V = {(float)(-e_V * sin(theta)), (float)(e_V * cos(theta))};
        lode_start_found_t found;
        if (n % ROUND == 2) {
            (void)lode_start_measure(&start, &tuning, seen_V, &found);
        }
        (void)step(&start, &tuning, n, (float)(2.0 * swing), 8.0f, seen_V);
        const double lag = theta - (double)angle_of(lode_start_vector(&start));
        omega = speed_after(shaft, omega, -(double)start.current_A / 8.0 * sin(lag), swing);
        theta += (double)PAPER_TS_s * omega;
        lowest = fmin(lowest, theta);
    }
    return (theta0_rad - lowest) * 180.0 / CHECK_PI;
}

/// (S29): rotors from paper 1's to 25 times lighter ones, from anywhere; their inertia is known within a factor of 2.
static void test_a_free_rotor_hardly_turns_back_by_more_than_half_a_turn(void) {
    int beyond = 0;
    int all = 0;
    for (double lighter = 1.0; lighter <= 26.0; lighter *= 1.71) {
        for (double error = 0.5; error <= 2.0; error *= 2.0) {
            for (int k = -18; k < 18; k++) {
                const shaft_t shaft = {.J_kgm2 = 0.0174 / lighter, .error = error, .attempts = 1u};
                const double back_deg = turned_back_deg(&shaft, (double)k * CHECK_PI / 18.0, 0.0);
                beyond += back_deg > 200.0 ? 1 : 0;
                all++;
            }
        }
    }
    TEST_ASSERT_EQUAL_INT(756, all);
    CHECK_AT_MOST(4.0, (double)beyond);
}

/// Of rotors with 3 to 9 times their inertia and up to a third of the torque as a load, from anywhere, those that turn back by
/// more than 190 degrees.
static int rotors_turned_back(double rise_s) {
    int beyond = 0;
    for (double lighter = 1.0; lighter <= 13.0; lighter *= 3.5) {
        for (double error = 3.0; error <= 9.0; error += 2.0) {
            for (double load = 0.0; load <= 0.31; load += 0.1) {
                for (int k = -12; k < 12; k++) {
                    const shaft_t shaft = {.J_kgm2 = 0.0174 / lighter,
                                           .error = error,
                                           .load = load,
                                           .rise_s = rise_s,
                                           .attempts = 1u};
                    const double back_deg =
                        turned_back_deg(&shaft, (double)k * CHECK_PI / 12.0, 0.0);
                    beyond += back_deg > 190.0 ? 1 : 0;
                }
            }
        }
    }
    return beyond;
}

/// (S29): the current of a heavy round rotor rises in 0.4 s.
static void test_a_slower_rise_turns_fewer_rotors_back(void) {
    const int quick = rotors_turned_back(0.2);
    const int slow = rotors_turned_back(0.4);
    CHECK_AT_LEAST(20.0, (double)quick);
    CHECK_AT_MOST(0.25 * (double)quick, (double)slow);
}

/// (S40): the same rotors, with an axis that is known to 25 degrees. The vector is 65 to 175 degrees ahead of the one polarity, and
/// 115 to 5 degrees behind the other.
static void test_a_rotor_whose_axis_is_known_turns_back_by_less(void) {
    double most_deg = 0.0;
    for (double lighter = 1.0; lighter <= 26.0; lighter *= 1.71) {
        for (double error = 0.5; error <= 2.0; error *= 2.0) {
            for (int lead_deg = 65; lead_deg <= 175; lead_deg += 10) {
                const double ahead = lead_deg * CHECK_PI / 180.0;
                const shaft_t shaft = {.J_kgm2 = 0.0174 / lighter, .error = error, .attempts = 1u};
                CHECK_AT_MOST(20.0, turned_back_deg(&shaft, 0.3, ahead));
                most_deg = fmax(most_deg, turned_back_deg(&shaft, 0.3, ahead - CHECK_PI));
            }
        }
    }
    CHECK_AT_MOST(200.0, most_deg);
    CHECK_AT_LEAST(115.0, most_deg);
}

/// (S41): rotors with several times their inertia, which a load holds next to the point opposite to the vector until it leaves
/// and pulls them back as it passes. The next attempt's vector is next to them.
static void test_a_rotor_that_was_held_opposite_is_not_pulled_back_twice(void) {
    double most_deg = 0.0;
    for (double error = 4.0; error <= 8.0; error += 2.0) {
        for (double load = 0.35; load <= 0.51; load += 0.05) {
            const shaft_t shaft = {.J_kgm2 = 0.0174, .error = error, .load = load, .attempts = 2u};
            for (int k = 105; k <= 135; k += 5) {
                const double back_deg = turned_back_deg(&shaft, k * CHECK_PI / 180.0, 0.0);
                most_deg = fmax(most_deg, back_deg);
            }
        }
    }
    CHECK_AT_MOST(120.0, most_deg);
}

static void test_way_back_takes_up_a_turning_vector(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(10.0f), 50.0f, 3.0f);
    CHECK_NEAR(1.0e-5, 10.0 - 4.0 * CHECK_PI, angle_of(start.at));
    double theta = 10.0;
    for (int n = 1; n <= 6000; n++) {
        const float angle = step(&start, &tuning, n, 0.0f, 8.0f, no_emf);
        theta += 2.0e-4 * (double)start.omega_rad_s;
        CHECK_NEAR(1.0e-3, 0.0, angle_error(theta, (double)angle));
        TEST_ASSERT_TRUE(start.omega_rad_s >= 0.0f && start.omega_rad_s <= 50.0f);
    }
    TEST_ASSERT_TRUE(start.omega_rad_s == 0.0f);
}

/// A rotor on the vector's spring: J/np dw/dt = K sin(vector - theta), K = current kt. Starts 0.4 rad
/// off; returns the largest deviation in the last half of `seconds`.
static double swing_after(float damping, double omega, double seconds) {
    lode_start_config_t config = sound();
    config.damping = damping;
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), (float)omega, 8.0f);
    const double stiffness = 3.0 / 0.0174 * 8.0 * 0.639;
    double theta = -0.4;
    double w = omega;
    worst_t worst = {0.0};
    const int count = (int)(seconds / 2.0e-4);
    for (int n = 1; n <= count; n++) {
        const lode_ab_t e = {(float)(-0.142 * w * sin(theta)), (float)(0.142 * w * cos(theta))};
        const double vector = (double)step(&start, &tuning, n, (float)omega, 8.0f, e);
        w += 2.0e-4 * stiffness * sin(vector - theta);
        theta += 2.0e-4 * w;
        if (n > count / 2) {
            worst_note(&worst, angle_error(angle_of(start.at), theta));
        }
    }
    return worst.value;
}

static void test_damping_calms_the_rotor(void) {
    const double speeds[] = {-47.0, -20.0, 0.0, 20.0, 47.0};
    for (int i = 0; i < COUNT_OF(speeds); i++) {
        // Natural frequency 30 rad/s. In half a second a ratio of 0.3, if half of it gets through
        // mean and filter, leaves exp(-0.15 30 0.5) = 0.1 of 0.4 rad.
        CHECK_AT_MOST(0.06, swing_after(0.3f, speeds[i], 1.0));
        // Without it the swing stays.
        CHECK_AT_LEAST(0.3, swing_after(LODE_NONE, speeds[i], 1.0));
    }
}

/// A round rotor that lags by 0.85 rad under load, at speed, with less inertia than the drive knows of. Begins
/// 0.1 rad off; returns the largest deviation after 0.3 s, of the 0.7 that the attempt leaves at full current.
static double swing_under_load(double sign, double psi_share) {
    lode_motor_t motor = paper_motor();
    motor.Ld_H = motor.Lq_H;
    lode_start_config_t config = sound();
    config.damping = 0.5f;
    lode_start_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_start_tune(&tuning, &config, &inverter, &motor, OMEGA_MAX, PAPER_TS_s));
    const double omega = sign * 150.0; // from 80 rad/s on, the angle would show more
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), (float)omega, 8.0f);
    const double stiffness = 3.0 / (0.4 * 0.0174) * 8.0 * 0.639;
    double theta = sign * -0.75;
    double w = omega;
    worst_t worst = {0.0};
    const double psi = psi_share * 0.142;
    start.mean_V = (float)(psi * omega); // as the ramp leaves it
    for (int n = 1; n <= 3500; n++) {
        const lode_ab_t e = {(float)(-psi * w * sin(theta)), (float)(psi * w * cos(theta))};
        const double vector = (double)step(&start, &tuning, n, (float)omega, 8.0f, e);
        w += 2.0e-4 * stiffness * (sin(vector - theta) - sign * sin(0.85));
        theta += 2.0e-4 * w;
        if (n > 1500) {
            const double behind = sign * angle_error(angle_of(start.at), theta);
            worst_note(&worst, behind - 0.85);
        }
    }
    return worst.value;
}

/// The EMF across the vector would show the angle of such a rotor more than its speed, late, and feed the swing.
static void test_a_loaded_rotor_at_speed_is_calmed(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int k = -1; k <= 1; k++) {
            CHECK_AT_MOST(0.5 * 0.1, swing_under_load(sign, 1.0 + 0.1 * k));
        }
    }
}

/// The more flux the current takes from a salient rotor, the more its EMF's size shows the angle, too.
static void test_the_size_of_the_emf_comes_in_with_speed(void) {
    const lode_start_config_t config = sound();
    lode_start_tuning_t tuning = tuned(&config);
    tuning.current_last_A = 1000.0f;
    const lode_motor_t motor = paper_motor();
    const double lost_per_A = (double)(motor.Lq_H - motor.Ld_H) / 0.142;
    const struct {
        float omega, current_A;
        double share;
    } cases[] = {{0.0f, 4.0f, 0.0},
                 {0.25f, 4.0f, 0.5 * (1.0 - 4.0 * lost_per_A)},
                 {-0.5f, 4.0f, -(1.0 - 4.0 * lost_per_A)},
                 {-8.0f, 8.0f, -(1.0 - 8.0 * lost_per_A)},
                 {8.0f, 1000.0f, 0.5}}; // of the angle both show as much, there
    for (int k = 0; k < COUNT_OF(cases); k++) {
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.0f), cases[k].omega * tuning.omega_ready,
                         cases[k].current_A);
        aim(&start, &tuning, 47.0f, cases[k].current_A);
        CHECK_NEAR(1.0e-4, cases[k].share, start.by_size);
    }
}

static void test_damping_gives_way_to_a_bound(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    random_t random = random_seed(1);
    lode_start_reset(&start, lode_sincos(0.0f), 30.0f, 8.0f);
    for (int n = 1; n <= 20000; n++) {
        const lode_ab_t e = {random_float(&random, -1.0e5, 1.0e5),
                             random_float(&random, -1.0e5, 1.0e5)};
        const float angle = step(&start, &tuning, n, 47.0f, 8.0f, e);
        TEST_ASSERT_TRUE(lode_in_range(angle, -LODE_PI, LODE_PI));
        // Less than a quarter turn, beyond which the torque would fall again.
        CHECK_AT_MOST(CHECK_PI / 2.0, fabs(angle_error((double)angle, angle_of(start.at))));
    }
}

static void test_any_emf_gives_an_angle(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    random_t random = random_seed(2);
    lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 0.0f);
    for (int n = 1; n <= 100000; n++) {
        const lode_ab_t e = {random_any(&random), random_any(&random)};
        const float angle = step(&start, &tuning, n, 47.0f, 8.0f, e);
        TEST_ASSERT_TRUE(lode_in_range(angle, -LODE_PI, LODE_PI));
        TEST_ASSERT_TRUE(lode_in_range(start.current_A, 0.0f, inverter.i_max_A));
    }
}

static void test_a_failed_attempt_begins_again_at_rest(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 0.0f);
    int again = 0;
    float before = 0.0f;
    for (int n = 1; n <= 15000; n++) { // the 3 s of the time-out
        (void)step(&start, &tuning, n, 47.0f, 8.0f, no_emf);
        if (start.current_A < before - 1.0f) {
            again++;
            CHECK_NEAR(0.05, 0.0, start.current_A); // of which a period may have passed
        }
        before = start.current_A;
        if (start.current_A < 0.1f) {
            TEST_ASSERT_TRUE(start.omega_rad_s == 0.0f);
        }
    }
    // An attempt takes 0.2 + 0.47 + 0.05 s and at least as long to settle.
    CHECK_AT_LEAST(1, again);
    CHECK_AT_MOST(3, again);
}

/// A target of less than 1 rad/s is one: its attempts are counted, and it is handed over at.
static void test_a_slow_target_is_started_to(void) {
    const lode_start_config_t config = sound();
    lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 0.0f);
    for (int n = 1; n <= 15000; n++) {
        (void)step(&start, &tuning, n, 0.5f, 8.0f, no_emf);
    }
    CHECK_AT_LEAST(1.0, (double)start.failed);
    tuning.omega_ready = 0.4f;
    lode_start_reset(&start, lode_sincos(0.0f), 0.5f, 8.0f);
    lode_start_judge(&start, &tuning, 0.5f, 0.9f);
    TEST_ASSERT_EQUAL_UINT(1u, start.locked);
    tuning.steepens = 4.0f / 47.0f; // and begun as gently as any: with a sixteenth of the ramp
    lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 8.0f);
    aim(&start, &tuning, 0.5f, 8.0f);
    CHECK_CLOSE(1.0e-5, 100.0 * (double)PAPER_TS_s / 16.0, start.omega_step);
}

/// A vector at hand-over speed and an estimate that agrees with it.
static lode_start_t turning(double omega) {
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), (float)omega, 8.0f);
    return start;
}

/// One round of LODE_SLOW_PERIODS.
static bool ready(lode_start_t *start, const lode_start_tuning_t *tuning,
                  const lode_estimate_t *estimate) {
    lode_start_judge(start, tuning, estimate->omega_rad_s, estimate->lock);
    return lode_start_is_ready(start, tuning);
}

static void test_hand_over_needs_the_lock_for_its_time(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    const int rounds = 250 / ROUND; // 0.05 s, to the nearest round
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_start_t start = turning(47.0 * sign);
        lode_estimate_t estimate = {.omega_rad_s = 47.0f * (float)sign, .lock = LODE_LOCK_HANDOVER};
        int n = 1;
        TEST_ASSERT_FALSE(lode_start_is_ready(&start, &tuning));
        while (!ready(&start, &tuning, &estimate) && n < 10000) {
            n++;
        }
        TEST_ASSERT_EQUAL_INT(rounds, n);
        // A single bad round starts the time anew.
        start = turning(47.0 * sign);
        for (n = 0; n < rounds - 1; n++) {
            TEST_ASSERT_FALSE(ready(&start, &tuning, &estimate));
        }
        estimate.lock = LODE_LOCK_HANDOVER - 0.01f;
        TEST_ASSERT_FALSE(ready(&start, &tuning, &estimate));
        estimate.lock = 1.0f;
        for (n = 0; n < rounds - 1; n++) {
            TEST_ASSERT_FALSE(ready(&start, &tuning, &estimate));
        }
        TEST_ASSERT_TRUE(ready(&start, &tuning, &estimate));
        // So does a vector that is to stop, or to go the other way.
        const float elsewhere[] = {0.0f, -47.0f * (float)sign};
        for (int k = 0; k < COUNT_OF(elsewhere); k++) {
            aim(&start, &tuning, elsewhere[k], 8.0f);
            TEST_ASSERT_FALSE(ready(&start, &tuning, &estimate));
        }
    }
}

static bool ever_ready(double omega_vector, lode_estimate_t estimate) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start = turning(omega_vector);
    for (int n = 0; n < 2000; n++) {
        if (ready(&start, &tuning, &estimate)) {
            return true;
        }
    }
    return false;
}

static void test_hand_over_needs_speed_and_direction(void) {
    TEST_ASSERT_TRUE(ever_ready(47.0, (lode_estimate_t){.omega_rad_s = 45.0f, .lock = 0.9f}));
    TEST_ASSERT_FALSE(ever_ready(40.0, (lode_estimate_t){.omega_rad_s = 40.0f, .lock = 0.9f}));
    TEST_ASSERT_FALSE(ever_ready(47.0, (lode_estimate_t){.omega_rad_s = -47.0f, .lock = 0.9f}));
    TEST_ASSERT_FALSE(ever_ready(47.0, (lode_estimate_t){.omega_rad_s = 94.0f, .lock = 0.9f}));
    TEST_ASSERT_FALSE(ever_ready(47.0, (lode_estimate_t){.omega_rad_s = 20.0f, .lock = 0.9f}));
    TEST_ASSERT_FALSE(ever_ready(47.0, (lode_estimate_t){.omega_rad_s = 47.0f, .lock = 0.6f}));
    TEST_ASSERT_FALSE(ever_ready(47.0, (lode_estimate_t){.omega_rad_s = 47.0f, .lock = NAN}));
    TEST_ASSERT_FALSE(ever_ready(47.0, (lode_estimate_t){.omega_rad_s = NAN, .lock = 0.9f}));
    // A quarter of the vector's own speed, in which a load that swings within a turn swings the rotor.
    TEST_ASSERT_TRUE(ever_ready(94.0, (lode_estimate_t){.omega_rad_s = 115.0f, .lock = 0.9f}));
    TEST_ASSERT_FALSE(ever_ready(94.0, (lode_estimate_t){.omega_rad_s = 120.0f, .lock = 0.9f}));
}

/// Only from standstill the vector sweeps while its current rises: one that turns, however slowly, rests until it is there.
static void test_a_vector_that_turns_does_not_sweep(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    for (int slow = 0; slow < 2; slow++) {
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.0f), slow > 0 ? 0.5f : 0.0f, 2.0f);
        aim(&start, &tuning, 47.0f, 8.0f);
        const double turned = (double)lode_start_step(&start, &tuning, no_emf, PAPER_TS_s);
        CHECK_NEAR(1.0e-8, slow > 0 ? 0.5 * 2.0e-4 : (double)tuning.sweep_step_rad, turned);
    }
}

/// (S53): after an attempt that has failed current and sweep rise at half the rate; the current falls as fast as ever.
/// Wherever it comes from, the current is not beyond that of the last attempt.
static void test_the_current_has_a_bound(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    const float last_A = tuning.current_last_A;
    const float set_A[] = {4.0f * last_A, 0.9f * last_A};
    for (int n = 0; n < COUNT_OF(set_A); n++) {
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.0f), 20.0f, set_A[n]);
        aim(&start, &tuning, 47.0f, 2.0f);
        CHECK_CLOSE(1.0e-6, fmin((double)set_A[n], (double)last_A), start.current_A);
    }
}

static void test_a_later_attempt_rises_at_half_the_rate(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 2.0f);
    for (unsigned int failed = 0u; failed < 3u; failed++) {
        aim(&start, &tuning, 47.0f, 8.0f);
        const double rate = failed > 0u ? 0.5 : 1.0;
        const double before_A = (double)start.current_A;
        const double swept = (double)lode_start_step(&start, &tuning, no_emf, PAPER_TS_s);
        CHECK_NEAR(1.0e-8, rate * (double)tuning.sweep_step_rad, swept);
        CHECK_NEAR(1.0e-6, rate * (double)tuning.current_step, (double)start.current_A - before_A);
        aim(&start, &tuning, 47.0f, 0.0f);
        (void)lode_start_step(&start, &tuning, no_emf, PAPER_TS_s);
        CHECK_NEAR(1.0e-6, fmax(before_A - (1.0 - rate) * (double)tuning.current_step, 0.0),
                   (double)start.current_A);
        lode_start_again(&start, &tuning);
    }
}

/// Where the vector will be a period on, and the angle by which it gets there.
static void test_the_next_vector_is_known(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start = turning(-47.0);
    start.swing_V = 2.0f;
    (void)lode_start_step(&start, &tuning, no_emf, PAPER_TS_s);
    const double shift = (double)lode_start_shift_rad(&start);
    const lode_sincos_t next = lode_start_next(&start, PAPER_TS_s);
    CHECK_NEAR(1.0e-8, -47.0 * 2.0e-4, lode_start_step(&start, &tuning, no_emf, PAPER_TS_s));
    CHECK_NEAR(1.0e-6, angle_of(start.at) + shift, angle_of(next));
}

/// Looks for a rotor that turns already as `estimate` says; the rounds until it is held, or 0.
static int caught_after(lode_estimate_t estimate) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    memset(&start, 0xff, sizeof start);
    lode_start_begin(&start, &tuning);
    TEST_ASSERT_TRUE(start.current_A == 0.0f && start.omega_rad_s == 0.0f && start.at.sin == 0.0f);
    int n = 0;
    while (lode_start_catches(&start) && n < 10000) {
        n++;
        if (ready(&start, &tuning, &estimate)) {
            return n;
        }
    }
    TEST_ASSERT_EQUAL_INT(250 / ROUND, n); // 0.05 s, and no longer
    TEST_ASSERT_EQUAL_UINT32(0, start.locked);
    return 0;
}

/// Rounds until the hand-over of a vector at 47 rad/s; 0: it does not come.
static int ready_after(const lode_start_tuning_t *tuning, unsigned failed, float omega_rad_s) {
    const lode_estimate_t estimate = {.omega_rad_s = omega_rad_s, .lock = LODE_LOCK_HANDOVER};
    lode_start_t start = turning(47.0);
    start.failed = (uint_least8_t)failed;
    for (int n = 1; n < 1000; n++) {
        if (ready(&start, tuning, &estimate)) {
            return n;
        }
    }
    return 0;
}

/// (S32).
static void test_the_last_attempt_takes_what_lock_there_is(void) {
    const lode_start_config_t config = sound();
    lode_start_tuning_t tuning = tuned(&config);
    const int rounds = 250 / ROUND;
    TEST_ASSERT_EQUAL_INT(rounds, ready_after(&tuning, 1u, 47.0f));
    TEST_ASSERT_EQUAL_INT(0, ready_after(&tuning, 1u, 47.0f * 0.7f));
    // Of a vector that takes just all of the flux; one that takes more is not believed sooner.
    tuning.lost_per_A = 1.0f / tuning.current_last_A;
    TEST_ASSERT_EQUAL_INT((rounds + 1) / 2, ready_after(&tuning, 2u, 47.0f));
    TEST_ASSERT_EQUAL_INT((rounds + 1) / 2, ready_after(&tuning, 2u, 47.0f * 1.49f));
    TEST_ASSERT_EQUAL_INT(0, ready_after(&tuning, 2u, 47.0f * 1.51f));
    tuning.lost_per_A = 1.1f / tuning.current_last_A;
    TEST_ASSERT_EQUAL_INT(rounds, ready_after(&tuning, 2u, 47.0f));
    TEST_ASSERT_EQUAL_INT(0, ready_after(&tuning, 2u, 47.0f * 1.49f));
    // The shortest lock is a round in any attempt.
    tuning.lock_rounds = 1u;
    tuning.lost_per_A = 0.0f;
    TEST_ASSERT_EQUAL_INT(1, ready_after(&tuning, 2u, 47.0f));
}

/// As a corrupted state may have it.
static void test_no_rounds_left_to_look_for_a_rotor_are_over(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    TEST_ASSERT_TRUE(lode_start_catches(&start));
    start.attempt = 0u;
    lode_start_judge(&start, &tuning, 0.0f, 0.0f);
    TEST_ASSERT_FALSE(lode_start_catches(&start));
    lode_start_begin(&start, &tuning); // as ever: the attempt's own rounds begin with none
    start.attempt = 1u;
    lode_start_judge(&start, &tuning, 0.0f, 0.0f);
    TEST_ASSERT_FALSE(lode_start_catches(&start));
    TEST_ASSERT_EQUAL_UINT32(0u, start.attempt);
}

static void test_a_rotor_that_turns_already_is_caught(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        const float s = (float)sign;
        const int n = caught_after((lode_estimate_t){.omega_rad_s = 300.0f * s, .lock = 0.9f});
        TEST_ASSERT_EQUAL_INT(250 / ROUND / 5 + 1, n); // a lock of more than a fifth of the time
        TEST_ASSERT_EQUAL_INT(
            0, caught_after((lode_estimate_t){.omega_rad_s = 300.0f * s, .lock = 0.6f}));
        TEST_ASSERT_EQUAL_INT(
            0, caught_after((lode_estimate_t){.omega_rad_s = 5.0f * s, .lock = 0.9f}));
    }
    TEST_ASSERT_EQUAL_INT(0, caught_after((lode_estimate_t){.omega_rad_s = NAN, .lock = 0.9f}));
    TEST_ASSERT_EQUAL_INT(0, caught_after((lode_estimate_t){.omega_rad_s = 300.0f, .lock = NAN}));
}

static void test_range_of_the_time_to_catch(void) {
    const size_t offset = offsetof(lode_start_config_t, catch_s);
    const float good[] = {LODE_NONE, 0.0f, 0.05f, 10.0f};
    const float bad[] = {-1.001f, -0.999f, -0.05f, 10.01f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(good); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, good[i]));
    }
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_START_RAMP, try_one(offset, bad[i]));
    }
}

static void test_times_become_rounds(void) {
    lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    TEST_ASSERT_EQUAL_UINT32(31, tuning.lock_rounds); // 250 periods
    config.lock_s = 255.0f * PAPER_TS_s;              // to the nearest
    TEST_ASSERT_EQUAL_UINT32(32, tuned(&config).lock_rounds);
    TEST_ASSERT_EQUAL_UINT32(1875, tuning.timeout_rounds);
    CHECK_CLOSE(1.0e-6, 1.0 / 500.0, tuning.fade_step);
    config.lock_s = PAPER_TS_s;
    config.catch_s = LODE_NONE;
    config.timeout_s = 1000.0f;
    const lode_start_tuning_t far = tuned(&config);
    TEST_ASSERT_EQUAL_UINT32(1, far.lock_rounds);
    TEST_ASSERT_EQUAL_UINT32(0, far.catch_rounds);
    CHECK_CLOSE(1.0e-6, 5.0e6 / ROUND, far.timeout_rounds);
}

// 16 bits hold 65535 rounds of catch and lock.
static void test_times_have_room_in_their_counters(void) {
    const float ts_s = 5.0e-6f;
    const size_t offsets[] = {offsetof(lode_start_config_t, catch_s),
                              offsetof(lode_start_config_t, lock_s)};
    const lode_motor_t motor = paper_motor();
    for (int i = 0; i < COUNT_OF(offsets); i++) {
        lode_start_config_t config = sound();
        lode_start_tuning_t tuning;
        field_set(&config, offsets[i], 2.62f);
        TEST_ASSERT_EQUAL_INT(
            LODE_OK, lode_start_tune(&tuning, &config, &inverter, &motor, OMEGA_MAX, ts_s));
        TEST_ASSERT_EQUAL_UINT32(65500, i == 0 ? tuning.catch_rounds : tuning.lock_rounds);
        field_set(&config, offsets[i], 2.63f);
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_START_RAMP, lode_start_tune(&tuning, &config, &inverter,
                                                                     &motor, OMEGA_MAX, ts_s));
    }
}

static lode_status_t try_one(size_t offset, float value) {
    lode_start_config_t config = sound();
    field_set(&config, offset, value);
    const lode_motor_t motor = paper_motor();
    lode_start_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_start_tuning_t before = tuning;
    const lode_status_t status =
        lode_start_tune(&tuning, &config, &inverter, &motor, OMEGA_MAX, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

/// Refused from `lo` down and from `hi` up; NaN and Inf too. `good` passes.
static void check_bounds(size_t offset, float lo, float good, float hi, lode_status_t error) {
    const float bad[] = {lo, -good, hi, NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        char text[60];
        (void)snprintf(text, sizeof text, "offset %u, %g", (unsigned)offset, (double)bad[i]);
        TEST_ASSERT_EQUAL_STRING_MESSAGE(lode_status_name(error),
                                         lode_status_name(try_one(offset, bad[i])), text);
    }
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, good));
}

static void test_every_field_at_its_limits(void) {
    check_bounds(offsetof(lode_start_config_t, current_A), 0.0f, 10.0f, nextafterf(10.0f, 13.0f),
                 LODE_ERROR_START_CURRENT); // the last attempt's 10 A is no less
    check_bounds(offsetof(lode_start_config_t, current_last_A), nextafterf(8.0f, 0.0f), 12.0f,
                 nextafterf(12.0f, 13.0f), LODE_ERROR_START_CURRENT);
    check_bounds(offsetof(lode_start_config_t, omega_handover_rad_s), 0.0f, OMEGA_MAX,
                 nextafterf(OMEGA_MAX, INFINITY), LODE_ERROR_START_SPEED);
    check_bounds(offsetof(lode_start_config_t, ramp_rad_s2), 0.0f, 1.0f, 1.0e9f,
                 LODE_ERROR_START_RAMP);
    check_bounds(offsetof(lode_start_config_t, current_rise_s), 0.0f, PAPER_TS_s, 1.0e6f,
                 LODE_ERROR_START_RAMP);
    check_bounds(offsetof(lode_start_config_t, lock_s), 0.0f, PAPER_TS_s, 1.0e6f,
                 LODE_ERROR_START_RAMP);
    check_bounds(offsetof(lode_start_config_t, fade_s), 0.0f, PAPER_TS_s, 1.0e6f,
                 LODE_ERROR_START_RAMP);
    static const struct {
        size_t offset;
        float lo, hi;
    } ends[] = {
        {offsetof(lode_start_config_t, current_A), 1.0e-3f * 12.0f, 10.0f},
        {offsetof(lode_start_config_t, omega_handover_rad_s), 1.0e-3f * OMEGA_MAX, OMEGA_MAX},
        {offsetof(lode_start_config_t, ramp_rad_s2), 1.0e-3f, 1.0e7f},
        {offsetof(lode_start_config_t, current_rise_s), PAPER_TS_s, 100.0f},
        {offsetof(lode_start_config_t, lock_s), PAPER_TS_s, 3.0f},
        {offsetof(lode_start_config_t, fade_s), PAPER_TS_s, 10.0f},
    };
    for (int i = 0; i < COUNT_OF(ends); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(ends[i].offset, ends[i].lo));
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(ends[i].offset, ends[i].hi));
        TEST_ASSERT_NOT_EQUAL_INT(LODE_OK, try_one(ends[i].offset, nextafterf(ends[i].lo, 0.0f)));
        TEST_ASSERT_NOT_EQUAL_INT(LODE_OK,
                                  try_one(ends[i].offset, nextafterf(ends[i].hi, INFINITY)));
    }
    check_bounds(offsetof(lode_start_config_t, timeout_s), 0.0f, 10.0f, 1.0e6f,
                 LODE_ERROR_START_RAMP);
    const size_t damping = offsetof(lode_start_config_t, damping);
    const float good[] = {LODE_NONE, 0.0f, 0.7f, 2.0f};
    const float bad[] = {-1.001f, -0.999f, -0.5f, -1.0e-6f, 2.001f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(good); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(damping, good[i]));
    }
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_START_DAMPING, try_one(damping, bad[i]));
    }
}

/// Where 1.2 times the flux that the current takes is more than (S8) allows: two electrical turns at hand-over speed.
static void test_a_salient_rotor_is_seen_locked_within_a_turn(void) {
    lode_motor_t motor = paper_motor();
    const double most_H = 0.4 * 0.142 / (1.2 * 8.4);
    const struct {
        double omega, Lq_H, lock_s;
    } cases[] = {
        {180.0, 1.001 * most_H, 4.0 * 3.14159265 / 180.0},
        {180.0, 0.999 * most_H, 0.1},
        {100.0, 1.001 * most_H, 0.1},
        {400.0, 1.001 * most_H, 0.05},
    };
    for (int i = 0; i < COUNT_OF(cases); i++) {
        lode_start_config_t config = {.omega_handover_rad_s = (float)cases[i].omega};
        motor.Lq_H = motor.Ld_H + (float)cases[i].Lq_H;
        lode_start_design(&config, &inverter, &motor, PAPER_TS_s);
        CHECK_CLOSE(1.0e-5, 8.4, config.current_A);
        CHECK_CLOSE(1.0e-5, cases[i].lock_s, config.lock_s);
        CHECK_CLOSE(1.0e-5, 0.1, config.fade_s);
    }
}

static void test_design_fills_what_is_open(void) {
    const lode_motor_t motor = paper_motor();
    lode_start_config_t config = {.current_A = 0.0f};
    lode_start_design(&config, &inverter, &motor, PAPER_TS_s);
    CHECK_CLOSE(1.0e-6, 0.7 * 12.0, config.current_A);
    CHECK_CLOSE(1.0e-6, 12.0, config.current_last_A); // twice that is more than i_max
    lode_motor_t salient = motor;
    salient.Lq_H = motor.Ld_H + 0.01f;
    lode_start_config_t bounded = {.current_A = 0.0f};
    lode_start_design(&bounded, &inverter, &salient, PAPER_TS_s);
    CHECK_CLOSE(1.0e-5, 0.5 * 0.142 / 0.01, bounded.current_A);
    CHECK_CLOSE(1.0e-6, 0.05, bounded.lock_s); // half, where reluctance bounds the current
    CHECK_CLOSE(1.0e-6, 0.05, bounded.fade_s);
    CHECK_CLOSE(1.0e-6, 12.0, bounded.current_last_A);
    salient.Lq_H = motor.Ld_H + 0.04f; // twice the current is less than what a round rotor takes
    bounded = (lode_start_config_t){.current_A = 0.0f};
    lode_start_design(&bounded, &inverter, &salient, PAPER_TS_s);
    CHECK_CLOSE(1.0e-6, 0.7 * 12.0, bounded.current_last_A);
    lode_start_config_t given = {.current_A = 3.0f}; // in every attempt
    lode_start_design(&given, &inverter, &motor, PAPER_TS_s);
    CHECK_CLOSE(1.0e-6, 3.0, given.current_last_A);
    CHECK_CLOSE(1.0e-6, 0.1 * PAPER_OMEGA_RATED, config.omega_handover_rad_s); // 150 rpm
    // A tenth of the start torque on the inertia, electrical.
    CHECK_CLOSE(1.0e-5, 8.4 * 0.639 * 0.1 / 0.0174 * 3.0, config.ramp_rad_s2);
    CHECK_CLOSE(1.0e-6, 0.2, config.current_rise_s);
    lode_motor_t round = motor;
    round.Lq_H = motor.Ld_H;
    const float lighter[] = {1.0f, 12.0f, 100.0f}; // the first swings with 30.4 rad/s
    const double rise_s[] = {0.4, 35.0 / (sqrt(12.0 * 3.0 * 8.4 * 0.639 / 0.0174)), 0.2};
    for (int n = 0; n < 3; n++) {
        lode_start_config_t rising = {.current_A = 0.0f};
        round.J_kgm2 = motor.J_kgm2 / lighter[n];
        lode_start_design(&rising, &inverter, &round, PAPER_TS_s);
        CHECK_CLOSE(1.0e-5, rise_s[n], rising.current_rise_s);
    }
    CHECK_CLOSE(1.0e-6, 0.5, config.damping);
    CHECK_CLOSE(1.0e-6, 0.1, config.lock_s);
    CHECK_CLOSE(1.0e-6, 0.05, config.catch_s);
    CHECK_CLOSE(1.0e-6, 0.1, config.fade_s);
    // Three attempts, each with a quarter of the ramp before: twice the profile, or 0.4 s more.
    const double ramp_s = (double)config.omega_handover_rad_s / (double)config.ramp_rad_s2;
    const double still_s = 0.3 + 2.0 * 0.15;               // with the measurement at two currents
    const double gentle = (log(16.0) - 15.0 / 16.0) / 4.0; // (S35), rounded up
    const double later_s = 2.0 * 0.2;                      // (S53)
    const double profiles_s = 3.0 * still_s + later_s + (21.0 + 3.0 * gentle) * ramp_s;
    CHECK_CLOSE(1.0e-3, 2.0 * profiles_s, config.timeout_s);
    lode_motor_t heavy = motor;
    heavy.J_kgm2 = 10.0f;
    lode_start_config_t patient = {.current_A = 0.0f};
    lode_start_design(&patient, &inverter, &heavy, PAPER_TS_s);
    TEST_ASSERT_EQUAL_FLOAT(1000.0f, patient.timeout_s); // as much as init takes
    const lode_start_config_t all = sound();
    lode_start_config_t kept = all;
    lode_start_design(&kept, &inverter, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_MEMORY(&all, &kept, sizeof all);
}

/// EMF at hand-over: twice what 1 us of dead time and 30 % of R may come to, from 0.1 to 0.5 of rated.
static void test_hand_over_speed_follows_what_is_not_known(void) {
    lode_motor_t motor = paper_motor();
    motor.psi_Wb = 0.05f;
    lode_inverter_config_t board = inverter;
    board.r_on_Ohm = 0.05f;
    lode_start_config_t config = {.current_A = 6.0f};
    lode_start_design(&config, &board, &motor, PAPER_TS_s);
    const double unknown_V =
        4.0 / CHECK_PI * (double)board.v_bus_V * 1.0e-6 / 2.0e-4 + 0.3 * 0.8 * 6.0;
    CHECK_CLOSE(1.0e-5, 2.0 * unknown_V / 0.05, config.omega_handover_rad_s);
    // Dead time and drops count where nothing takes them into account.
    board.dead_time_s = 0.5e-6f;
    board.v_drop_V = 0.2f;
    const double lost_V = 4.0 / CHECK_PI * ((double)board.v_bus_V * 0.5e-6 / 2.0e-4 + 0.2);
    for (int corrected = 0; corrected <= 1; corrected++) {
        for (int modelled = 0; modelled <= 1; modelled++) {
            board.dead_time_correction = corrected == 1 ? LODE_ON : LODE_OFF;
            board.dead_time_model = modelled == 1 ? LODE_ON : LODE_OFF;
            lode_start_config_t lossy = {.current_A = 6.0f};
            lode_start_design(&lossy, &board, &motor, PAPER_TS_s);
            const double more_V = corrected + modelled == 0 ? lost_V : 0.0;
            CHECK_CLOSE(1.0e-5, 2.0 * (unknown_V + more_V) / 0.05, lossy.omega_handover_rad_s);
        }
    }
    motor.psi_Wb = 0.006f;
    lode_start_config_t weak = {.current_A = 6.0f};
    lode_start_design(&weak, &board, &motor, PAPER_TS_s);
    CHECK_CLOSE(1.0e-5, 0.5 * PAPER_OMEGA_RATED, weak.omega_handover_rad_s);
    // A resistance that takes most of the voltage, warm: half of the speed at which the bus is used up.
    const lode_inverter_config_t small = {.v_bus_V = 12.0f, .i_max_A = 1.0f};
    lode_motor_t gimbal = motor;
    gimbal.psi_Wb = 8.0e-3f;
    gimbal.Rs_Ohm = 3.8f;
    gimbal.Ld_H = gimbal.Lq_H = 2.2e-3f;
    lode_start_config_t slow = {.current_A = 0.0f};
    lode_start_design(&slow, &small, &gimbal, PAPER_TS_s);
    const double base = 2.0 * (double)slow.omega_handover_rad_s;
    CHECK_CLOSE(1.0e-4, 0.95 * 12.0 / sqrt(3.0), hypot(1.3 * 3.8 + 8.0e-3 * base, 2.2e-3 * base));
    // None at all: a quarter of the drop, or a tenth of rated speed.
    gimbal.Rs_Ohm = 10.0f;
    lode_start_config_t none = {.current_A = 0.0f};
    lode_start_design(&none, &small, &gimbal, PAPER_TS_s);
    CHECK_CLOSE(1.0e-5, 0.25 * 10.0 * 0.7 / 8.0e-3, none.omega_handover_rad_s);
    lode_start_config_t little = {.current_A = 0.1f};
    lode_start_design(&little, &small, &gimbal, PAPER_TS_s);
    CHECK_CLOSE(1.0e-5, 0.1 * PAPER_OMEGA_RATED, little.omega_handover_rad_s);
}

/// (S18): a load step must not stop the rotor. The estimator may take over at the speed of (S12) already, on the
/// way to a speed that nobody gave.
static void test_a_light_salient_rotor_hands_over_later(void) {
    lode_motor_t motor = paper_motor();
    motor.J_kgm2 *= 0.25f;
    for (int sign = -1; sign <= 1; sign++) {
        motor.Lq_H = motor.Ld_H + 6.0e-3f * (float)sign;
        lode_start_config_t config = {.current_A = 6.0f};
        lode_start_design(&config, &inverter, &motor, PAPER_TS_s);
        const double lost = fabs(6.0e-3 * sign) * 6.0 / (double)motor.psi_Wb;
        const double acc = (double)motor.pole_pairs * 12.0 * (double)lode_motor_kt_Nm_A(&motor) /
                           (double)motor.J_kgm2;
        const double least = 0.1 * PAPER_OMEGA_RATED;
        CHECK_CLOSE(1.0e-4, fmax(least, sqrt(4.5 * lost * acc)), config.omega_handover_rad_s);
        lode_start_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(
            LODE_OK, lode_start_tune(&tuning, &config, &inverter, &motor, OMEGA_MAX, PAPER_TS_s));
        CHECK_CLOSE(1.0e-5, least, tuning.omega_ready);
        config.omega_handover_rad_s *= 1.01f; // given
        TEST_ASSERT_EQUAL_INT(
            LODE_OK, lode_start_tune(&tuning, &config, &inverter, &motor, OMEGA_MAX, PAPER_TS_s));
        TEST_ASSERT_EQUAL_FLOAT(config.omega_handover_rad_s, tuning.omega_ready);
    }
}

/// (S52): from Lq i_max/psi = 1.25 on 0.08 of it, of rated speed; the angle is no better before.
static void test_a_reluctance_machine_hands_over_later(void) {
    lode_motor_t motor = paper_motor();
    for (double Lq_H = 10.0e-3; Lq_H < 40.0e-3; Lq_H *= 1.5) {
        motor.Lq_H = (float)Lq_H;
        motor.J_kgm2 = 10.0f; // (S18) asks for nothing
        lode_start_config_t config = {.current_A = 0.0f};
        lode_start_design(&config, &inverter, &motor, PAPER_TS_s);
        const double share = 0.08 * Lq_H * 12.0 / (double)motor.psi_Wb;
        CHECK_CLOSE(1.0e-4, fmax(0.1, share) * PAPER_OMEGA_RATED, config.omega_handover_rad_s);
        lode_start_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(
            LODE_OK, lode_start_tune(&tuning, &config, &inverter, &motor, OMEGA_MAX, PAPER_TS_s));
        TEST_ASSERT_EQUAL_FLOAT(config.omega_handover_rad_s, tuning.omega_ready);
    }
}

/// Each attempt begins at rest, with a quarter of the ramp; the last one takes its own current.
static void test_each_attempt_is_easier(void) {
    lode_start_config_t config = sound();
    config.current_A = 5.0f;
    const lode_start_tuning_t tuning = tuned(&config);
    const float ease[] = {1.0f, 0.25f, 0.0625f, 0.0625f}; // and so on until the time-out
    const float current[] = {5.0f, 5.0f, 10.0f, 10.0f};
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 0.0f);
    int n = 1;
    for (int k = 0; k < COUNT_OF(ease); k++) {
        TEST_ASSERT_EQUAL_FLOAT(ease[k], lode_start_ease(&start));
        float most_A = 0.0f;
        float most_step = 0.0f;
        int periods = 0;
        for (bool fresh = false; !fresh; n++, periods++) {
            const float before = start.omega_rad_s;
            (void)step(&start, &tuning, n, 47.0f, 5.0f, no_emf);
            most_A = lode_max(most_A, start.current_A);
            most_step = lode_max(most_step, start.omega_rad_s - before);
            fresh = start.omega_rad_s < before - 1.0f; // at rest again
        }
        CHECK_CLOSE(1.0e-4, current[k], most_A);
        CHECK_CLOSE(1.0e-3, ease[k] * tuning.omega_step, most_step);
        // Rise, ramp and lock, and as long again, here at least 0.4 s.
        const double rise_s = (k > 0 ? 2.0 : 1.0) * (double)config.current_rise_s; // (S53)
        const double profile_s =
            rise_s + (double)config.lock_s + 47.0 / (double)(config.ramp_rad_s2 * ease[k]);
        const double expected_s = profile_s + fmax(profile_s, 0.4);
        CHECK_NEAR(0.02 * expected_s + 0.01, expected_s, periods * 2.0e-4);
    }
    // Nothing for a stop.
    aim(&start, &tuning, 0.0f, 0.0f);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, start.current_target);
    TEST_ASSERT_EQUAL_FLOAT(0.0625f, lode_start_ease(&start));
    lode_start_begin(&start, &tuning);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, lode_start_ease(&start));
}

/// (S35): by default a ramp begins with a sixteenth and steepens with the speed, up to the attempt's share of it.
static void test_a_default_ramp_begins_gently(void) {
    const float ease[] = {1.0f, 0.25f, 0.0625f};
    lode_start_config_t config = sound();
    config.ramp_rad_s2 = 0.0f;
    config.measure = LODE_OFF;
    const lode_motor_t motor = paper_motor();
    lode_start_design(&config, &inverter, &motor, PAPER_TS_s);
    const lode_start_tuning_t tuning = tuned(&config);
    for (int k = 0; k < COUNT_OF(ease); k++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            lode_start_t start;
            lode_start_reset(&start, lode_sincos(0.0f), 0.0f,
                             12.0f); // the current is there already
            start.failed = (uint_least8_t)k;
            double omega = 0.0;
            double share = 0.0;
            int n = 0;
            for (; lode_abs(start.omega_rad_s) < tuning.omega_handover; n++) {
                (void)step(&start, &tuning, n, (float)sign * tuning.omega_handover, 8.0f, no_emf);
                if (n % ROUND == 1) { // as step()
                    share = 0.0625 + 4.0 * omega / (double)tuning.omega_handover;
                }
                omega += fmin((double)ease[k], share) * (double)tuning.omega_step;
                omega = fmin(omega, (double)tuning.omega_handover);
                CHECK_NEAR(1.0e-3 * (double)tuning.omega_handover, sign * omega, start.omega_rad_s);
            }
            // Until the share is the attempt's: an exponential; from there on a straight line.
            const double first = (double)tuning.omega_handover / (double)tuning.omega_step;
            const double bend = ((double)ease[k] - 0.0625) / 4.0;
            const double periods =
                first * (log((double)ease[k] * 16.0) / 4.0 + (1.0 - bend) / (double)ease[k]);
            const double rounds = 8.0; // for the first step and for each change
            CHECK_NEAR(0.01 * periods + rounds, periods, n);
            // A rotor that is stopped has followed: no gentle end.
            start.omega_rad_s = 0.0f;
            aim(&start, &tuning, 0.0f, 8.0f);
            CHECK_CLOSE(1.0e-6, (double)(ease[k] * tuning.omega_step), start.omega_step);
        }
    }
    // An attempt has the time for it.
    const double longer_s = 0.46 * (double)config.omega_handover_rad_s / (double)config.ramp_rad_s2;
    CHECK_CLOSE(1.0e-5, (double)(config.current_rise_s + config.lock_s) + longer_s,
                ROUND * PAPER_TS_s * tuning.still_rounds);
}

/// (S17): where no lock comes at speed the current falls to 0.3 until the attempt ends; not on the way up.
static void test_the_current_falls_where_no_lock_comes(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    for (int slow = 0; slow <= 1; slow++) {
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 0.0f);
        const float target = slow > 0 ? 40.0f : 47.0f; // below the speed of hand-over
        const double profile_s = 0.2 + 0.47 + 0.05;
        for (int n = 1; n <= 7190; n++) { // the attempt ends at 7200
            (void)step(&start, &tuning, n, target, 8.0f, no_emf);
            const double late = fmax(0.0, PAPER_TS_s * (double)n - profile_s) / profile_s;
            const double share = slow > 0 ? 1.0 : 1.0 - 0.7 * late;
            if (n > 1000) {
                CHECK_NEAR(0.03, 8.0 * share, start.current_A);
            }
        }
    }
}

/// (S17) with three times the start's current: what is left is a share of twice that.
static void test_the_current_of_the_last_attempt_falls_as_far(void) {
    const lode_start_config_t config = sound();
    lode_start_tuning_t tuning = tuned(&config);
    tuning.current_A = 3.0f;
    for (int third = 0; third <= 1; third++) {
        tuning.current_last_A = third > 0 ? 9.0f : 6.0f;
        lode_start_t start;
        lode_start_reset(&start, lode_sincos(0.0f), 47.0f, tuning.current_last_A);
        start.failed =
            3u; // 0.2 + 0.075 for 3 A at half the rate + 4 * 0.47 + 0.05 s, and as long again
        start.attempt = (uint32_t)(2.0 * 2.205 / (ROUND * (double)PAPER_TS_s)) - 3u;
        aim(&start, &tuning, 47.0f, 3.0f);
        CHECK_NEAR(0.02, 0.3 * 2.0 * 3.0, start.current_target);
        start.attempt /= 4u; // within the profile
        aim(&start, &tuning, 47.0f, 3.0f);
        CHECK_CLOSE(1.0e-6, (double)tuning.current_last_A, start.current_target);
    }
}

/// Rad by which the vector gives way to a swing of 0.01 V, at this speed in an attempt with this current.
static double give_at(const lode_start_tuning_t *tuning, float omega, float current_A) {
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), omega, current_A);
    aim(&start, tuning, 47.0f, current_A);
    start.swing_V = 0.01f;
    return -angle_of(lode_start_vector(&start));
}

static void test_damping_gives_way_to_current_and_speed(void) {
    lode_start_config_t config = sound();
    config.damping = 0.5f;
    config.current_last_A = 12.0f;
    const lode_motor_t motor = paper_motor();
    const lode_start_tuning_t tuning = tuned(&config);
    const double swing = sqrt(3.0 * 8.0 * 0.639 / 0.0174);
    const double salient = (double)(motor.Lq_H - motor.Ld_H);
    CHECK_CLOSE(2.0e-3, 0.01 / (swing * 0.142), give_at(&tuning, 47.0f, 4.0f));
    CHECK_CLOSE(2.0e-3, 0.01 / (3.0 * swing * salient * 12.0), give_at(&tuning, 0.0f, 12.0f));
    lode_motor_t round = motor;
    round.Ld_H = round.Lq_H;
    lode_start_tuning_t plain;
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_start_tune(&plain, &config, &inverter, &round, OMEGA_MAX, PAPER_TS_s));
    CHECK_CLOSE(2.0e-3, 0.01 / (swing * 0.142), give_at(&plain, 47.0f, 12.0f));
    CHECK_CLOSE(2.0e-3, 0.01 * 2.0 / (0.142 * 200.0), give_at(&plain, -200.0f, 12.0f));
}

#define DWELLS 2
#define CALM_ROUNDS ((int)(0.4 / (ROUND * PAPER_TS_s) + 0.5) / 20)

/// What a rotor shows while its vector stands: across the vector always, along it once in 60 ms.
typedef struct {
    double across_V;
    double along_V;
} moving_t;

static const moving_t at_rest = {0.0, 0.0};

/// Standard deviations of a mean, in calm_V: of a rotor that rests, and of one that may still move.
#define SURE 0.25
#define LOOSE (1.0 / sqrt(0.44))

/// A mean voltage along the vector; no deviation: there is none.
typedef struct {
    double mean_V;
    double deviation; // in calm_V
} mean_t;

typedef struct {
    double r_Ohm;
    double dead_V;
} likely_t;

/// (S33) in another form: the two voltages at all of the current and their covariance, corrected by one mean after the
/// other. The configured values are off by 20 % of the resistance and by 0.5 us.
static likely_t likely(const lode_start_config_t *config, const lode_start_tuning_t *tuning,
                       mean_t half, mean_t full) {
    const double drop_V =
        ((double)paper_motor().Rs_Ohm + (double)inverter.r_on_Ohm) * (double)config->current_A;
    const double dead_V = 4.0 / CHECK_PI * (double)inverter.v_bus_V * 0.5e-6 / PAPER_TS_s;
    const mean_t means[] = {half, full};
    const double shares[] = {0.5, 1.0};
    double x[2] = {0.0, 0.0};
    double p[2][2] = {{0.04 * drop_V * drop_V, 0.0}, {0.0, dead_V * dead_V}};
    for (int n = 0; n < 2; n++) {
        if (!(means[n].deviation > 0.0)) {
            continue;
        }
        const double h = shares[n];
        const double noise_V = means[n].deviation * (double)tuning->calm_V;
        const double ph[2] = {p[0][0] * h + p[0][1], p[1][0] * h + p[1][1]};
        const double variance = h * ph[0] + ph[1] + noise_V * noise_V;
        const double off_V = means[n].mean_V - h * x[0] - x[1];
        for (int i = 0; i < 2; i++) {
            x[i] += ph[i] / variance * off_V;
        }
        for (int i = 0; i < 2; i++) {
            for (int j = 0; j < 2; j++) {
                p[i][j] -= ph[i] * ph[j] / variance;
            }
        }
    }
    return (likely_t){x[0] / (double)config->current_A, x[1]};
}

static void check_likely(likely_t expected, lode_start_found_t found) {
    CHECK_NEAR(2.0e-5, expected.r_Ohm, found.r_Ohm);
    CHECK_NEAR(2.0e-4, expected.dead_V, found.dead_V);
}

/// Returns the rounds that the measurement took.
static int measure(const lode_start_config_t *config, double r_Ohm, double dead_V, moving_t moving,
                   bool *known, lode_start_found_t *found) {
    lode_start_config_t at_once = *config;
    at_once.catch_s = LODE_NONE;
    const lode_start_tuning_t tuning = tuned(&at_once);
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    *known = false;
    double least_A = 0.0;
    int dwelt = 0;
    for (int n = 1; n <= 10000 && !(start.omega_rad_s > 0.0f); n++) {
        const double wave_V = moving.along_V * sin(2.0 * CHECK_PI * (double)n / 300.0);
        const double along_V = r_Ohm * (double)start.current_A + dead_V + wave_V;
        const lode_dq_t e = {(float)along_V, (float)moving.across_V};
        const lode_ab_t e_V = lode_park_inverse(e, lode_start_vector(&start));
        if (n % ROUND == 1) {
            lode_start_found_t now;
            if (lode_start_measure(&start, &tuning, e_V, &now)) {
                TEST_ASSERT_FALSE(*known);
                *known = true;
                *found = now;
            }
            aim(&start, &tuning, 47.0f, config->current_A);
            dwelt += start.current_A >= start.current_target ? 1 : 0;
        }
        TEST_ASSERT_TRUE((double)start.current_A >= least_A); // it only rises
        least_A = (double)start.current_A;
        (void)lode_start_step(&start, &tuning, e_V, PAPER_TS_s);
    }
    CHECK_CLOSE(1.0e-5, config->current_A, start.current_A);
    TEST_ASSERT_TRUE(start.omega_rad_s > 0.0f); // and goes on
    // What is seen at rest and of a vector that turns shares its place.
    TEST_ASSERT_EQUAL_UINT(0u, start.seen.turn.waves.seen);
    TEST_ASSERT_EQUAL_UINT(0u, start.seen.turn.waves.lacking);
    CHECK_NEAR(0.0, 0.0, start.seen.turn.waves.turn_rad);
    start.seen.turn.waves.turn_rad = 3.0f;
    while (start.stage == LODE_START_TURN && start.failed == 0u) {
        aim(&start, &tuning, 47.0f, config->current_A);
    }
    TEST_ASSERT_EQUAL_INT(config->measure == LODE_ON ? LODE_START_HALF : LODE_START_TURN,
                          start.stage);
    CHECK_NEAR(0.0, 0.0, start.seen.rest.sum_V); // a new attempt, and its half-waves
    return dwelt;
}

static void test_resistance_and_dead_time_are_measured_at_rest(void) {
    lode_start_config_t config = sound();
    config.measure = LODE_ON;
    config.damping = LODE_NONE;
    lode_start_found_t found = {0.0f, 0.0f};
    bool known = false;
    // A mean of 20 ms after 10 ms to settle, at two currents.
    CHECK_NEAR(6.0, DWELLS * 30.0e-3 / (ROUND * 2.0e-4),
               measure(&config, 0.3, -1.2, at_rest, &known, &found));
    TEST_ASSERT_TRUE(known);
    // In 30 ms this rotor has not swung far: half of the current tells little.
    const lode_start_tuning_t tuning = tuned(&config);
    const double at_full_V = 0.3 * (double)config.current_A;
    check_likely(likely(&config, &tuning, (mean_t){0.5 * at_full_V - 1.2, LOOSE},
                        (mean_t){at_full_V - 1.2, SURE}),
                 found);
    // A rotor that moves has an EMF of its own along the vector: given up after 0.15 s at each current.
    const int given_up = 2 * (int)(0.15 / (ROUND * 2.0e-4));
    const moving_t moves = {5.0, 5.0};
    CHECK_NEAR(4.0, given_up, measure(&config, 0.3, -1.2, moves, &known, &found));
    TEST_ASSERT_FALSE(known);
    config.measure = LODE_OFF;
    CHECK_AT_MOST(4.0, measure(&config, 0.3, -1.2, at_rest, &known, &found));
    TEST_ASSERT_FALSE(known);
}

/// (S30): a rotor that swings shows along the vector no more than a ripple, whose mean is taken after 0.15 s at each
/// current.
static void test_resistance_is_measured_while_the_rotor_swings(void) {
    lode_start_config_t config = sound();
    config.measure = LODE_ON;
    config.damping = LODE_NONE;
    const double calm_V = (double)tuned(&config).calm_V;
    lode_start_found_t found = {0.0f, 0.0f};
    bool known = false;
    const moving_t swings = {5.0, calm_V};
    const int both = DWELLS * (int)(0.15 / (ROUND * 2.0e-4));
    CHECK_NEAR(6.0, both, measure(&config, 0.3, -1.2, swings, &known, &found));
    TEST_ASSERT_TRUE(known);
    const lode_start_tuning_t tuning = tuned(&config);
    const double at_full_V = 0.3 * (double)config.current_A;
    const likely_t expected = likely(&config, &tuning, (mean_t){0.5 * at_full_V - 1.2, LOOSE},
                                     (mean_t){at_full_V - 1.2, LOOSE});
    CHECK_NEAR(0.3 * calm_V / 4.0, expected.r_Ohm, found.r_Ohm);
    CHECK_NEAR(0.5 * calm_V, expected.dead_V, found.dead_V);
}

/// (S30): past a right angle to the vector a falling rotor shows nothing across it, and along it ever more. The mean is
/// of the voltage after it.
static void test_a_rotor_that_falls_past_a_right_angle_is_not_at_rest(void) {
    lode_start_config_t config = measuring();
    config.damping = LODE_NONE;
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    int dwelt = 0;
    for (int n = 1; n <= 5000 && start.stage == LODE_START_HALF; n++) {
        const double fall_V = dwelt < 30 ? 0.15 * (double)tuning.calm_V * (double)dwelt : 0.0;
        const lode_ab_t e_V =
            lode_park_inverse((lode_dq_t){(float)(1.0 + fall_V), 0.0f}, lode_start_vector(&start));
        if (n % ROUND == 2) {
            lode_start_found_t found;
            (void)lode_start_measure(&start, &tuning, e_V, &found);
            dwelt += start.seen.rest.dwelt > 0u ? 1 : 0;
        }
        (void)step(&start, &tuning, n, 47.0f, 8.0f, e_V);
    }
    TEST_ASSERT_EQUAL_INT(LODE_START_FULL, start.stage);
    CHECK_NEAR(0.05 * (double)tuning.calm_V, 1.0, start.seen.rest.half_V);
}

/// Rounds that the vector dwells at the first current, with the voltages of round `n`, 1 .. : along and across its axis.
typedef lode_dq_t (*seen_at_t)(const lode_start_tuning_t *tuning, int n);

static float quicker = 1.0f; // a swing of so many times the natural frequency

static int rounds_at_half(seen_at_t seen_at, lode_start_t *start, lode_start_tuning_t *tuning) {
    lode_start_config_t config = measuring();
    config.damping = LODE_NONE;
    *tuning = tuned(&config);
    tuning->swing_weight *= quicker;
    lode_start_begin(start, tuning);
    start->current_A = start->current_target = 4.0f; // as it comes to be
    int rounds = 0;
    while (start->stage == LODE_START_HALF && rounds < 20000) {
        lode_start_found_t found;
        rounds++;
        (void)lode_start_measure(start, tuning,
                                 lode_park_inverse(seen_at(tuning, rounds), start->at), &found);
    }
    return rounds;
}

static lode_dq_t rests(const lode_start_tuning_t *tuning, int n) {
    const bool settles = n < tuning->dwell_rounds / 15; // the last round of it too would do
    return settles ? (lode_dq_t){9.0f, 0.0f} : (lode_dq_t){0.3f * tuning->calm_V, 0.0f};
}

static lode_dq_t never_rests(const lode_start_tuning_t *tuning, int n) {
    return (lode_dq_t){(n & 4) != 0 ? 9.0f : -9.0f, 5.0f * tuning->calm_V};
}

static lode_dq_t falls_once(const lode_start_tuning_t *tuning, int n) {
    return (lode_dq_t){n <= tuning->dwell_rounds / 8 ? 9.0f : 3.0f, 0.0f};
}

/// To the round: a tenth of the dwell to settle, then as many as a mean takes; with none, the dwell.
static void test_a_dwell_ends_with_its_mean(void) {
    lode_start_t start;
    lode_start_tuning_t tuning;
    int rounds = rounds_at_half(rests, &start, &tuning);
    TEST_ASSERT_EQUAL_INT(tuning.dwell_rounds / 15 + CALM_ROUNDS, rounds);
    TEST_ASSERT_EQUAL_INT(LODE_START_FULL, start.stage);
    CHECK_CLOSE(1.0e-5, 0.3 * (double)tuning.calm_V, start.seen.rest.half_V);
    TEST_ASSERT_EQUAL_UINT(0u, start.seen.rest.dwelt); // the next current's are its own
    TEST_ASSERT_EQUAL_UINT(0u, start.seen.rest.calm);
    CHECK_NEAR(0.0, 0.0, start.seen.rest.summed);
    CHECK_NEAR(0.0, 0.0, start.seen.rest.sum_V);
    rounds = rounds_at_half(falls_once, &start, &tuning);
    TEST_ASSERT_EQUAL_INT(tuning.dwell_rounds / 8 + CALM_ROUNDS,
                          rounds); // anew with the first voltage that is another
    CHECK_CLOSE(1.0e-5, 3.0, start.seen.rest.half_V);
    rounds = rounds_at_half(never_rests, &start, &tuning);
    TEST_ASSERT_EQUAL_INT(tuning.dwell_rounds, rounds);
    TEST_ASSERT_EQUAL_INT(LODE_START_ALONE, start.stage);
}

/// Times that can be parted evenly: 90 rounds have settled after 6, of 240 of patience 12 are calm ones.
static void test_a_dwell_of_even_parts(void) {
    const lode_start_config_t config = measuring();
    lode_start_tuning_t tuning = tuned(&config);
    tuning.dwell_rounds = 90u;
    tuning.patience_rounds = 240u;
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    start.current_A = start.current_target = 4.0f;
    int rounds = 0;
    while (start.stage == LODE_START_HALF && rounds < 90) {
        lode_start_found_t found;
        (void)lode_start_measure(&start, &tuning, no_emf, &found);
        rounds++;
    }
    TEST_ASSERT_EQUAL_INT(6 + 12, rounds);
    tuning.dwell_rounds = 1u; // is one, too
    lode_start_begin(&start, &tuning);
    TEST_ASSERT_EQUAL_INT(LODE_START_HALF, start.stage);
}

static int steady_from; // round
static lode_dq_t becomes_steady(const lode_start_tuning_t *tuning, int n) {
    return (lode_dq_t){n < steady_from ? 99.0f - 9.0f * (float)(n % 2) : 3.0f,
                       5.0f * tuning->calm_V};
}

static int steps_at; // round
static lode_dq_t steps_once(const lode_start_tuning_t *tuning, int n) {
    return (lode_dq_t){n < steps_at ? 3.0f : 3.0f + tuning->calm_V, 5.0f * tuning->calm_V};
}

/// (S30), to the round: a swing's mean needs two radians of it, and in the first half of the dwell no step of a calm voltage.
static void test_a_swing_is_watched_to_the_round(void) {
    lode_start_t start;
    lode_start_tuning_t tuning;
    (void)rounds_at_half(never_rests, &start, &tuning); // for its times
    const double swing = sqrt(3.0 * 8.0 * 0.639 / 0.0174);
    // The filter's weight is what a period takes of its corner, a little less than the corner itself.
    const int steady = (int)ceil(2.0 * 3.0 / (ROUND * (1.0 - exp(-3.0 * swing * PAPER_TS_s))));
    CHECK_NEAR(1.0, 2.0 / (swing * ROUND * PAPER_TS_s), (double)steady);
    CHECK_AT_LEAST(2.0 * CALM_ROUNDS, (double)steady);
    for (int late = 0; late <= 1; late++) {
        steady_from = tuning.dwell_rounds - steady + 1 + late;
        (void)rounds_at_half(becomes_steady, &start, &tuning);
        TEST_ASSERT_EQUAL_INT(late == 0 ? LODE_START_FULL : LODE_START_ALONE, start.stage);
        quicker = 10.0f; // a light rotor: twice the time of a calm mean is more than two radians
        steady_from = tuning.dwell_rounds - 2 * CALM_ROUNDS + 1 + late;
        (void)rounds_at_half(becomes_steady, &start, &tuning);
        TEST_ASSERT_EQUAL_INT(late == 0 ? LODE_START_FULL : LODE_START_ALONE, start.stage);
        quicker = 1.0f;
        steps_at = tuning.dwell_rounds / 2 + late;
        (void)rounds_at_half(steps_once, &start, &tuning);
        TEST_ASSERT_EQUAL_INT(LODE_START_FULL, start.stage);
        const double after = late == 0 ? 1.0
                                       : (double)(tuning.dwell_rounds - steps_at + 1) /
                                             (double)(tuning.dwell_rounds * 14 / 15 + 1);
        CHECK_NEAR(0.01 * (double)tuning.calm_V, 3.0 + after * (double)tuning.calm_V,
                   start.seen.rest.half_V);
    }
}

/// (S33): of a rotor that comes to rest at one of the currents alone, the voltage counts as resistance's and dead time's as
/// it is known that they are off; a mean that is missing counts nothing.
static void test_one_of_two_means_tells_the_sum(void) {
    lode_start_config_t config = measuring();
    const lode_start_tuning_t tuning = tuned(&config);
    static const int stages[] = {LODE_START_HALF, LODE_START_FULL, LODE_START_TURN}; // or never
    const double half[] = {0.0, LOOSE, LOOSE};
    const double full[] = {SURE, 0.0, SURE};
    for (int k = 0; k < COUNT_OF(stages); k++) {
        const int moves_at = stages[k];
        lode_start_t start;
        lode_start_begin(&start, &tuning);
        lode_start_found_t found = {0.0f, 0.0f};
        bool known = false;
        int rounds[2] = {0, 0};
        for (int n = 1; start.stage != LODE_START_TURN && n < 20000; n++) {
            const bool moves = start.stage == moves_at;
            const float along_V = moves && n % 32 < 16 ? 8.0f : 3.0f;
            const lode_dq_t e = {along_V, moves ? 5.0f : 0.0f};
            const lode_ab_t e_V = lode_park_inverse(e, start.at);
            if (n % ROUND == 1) {
                rounds[0] += start.stage == LODE_START_HALF ? 1 : 0;
                rounds[1] += start.stage > LODE_START_HALF ? 1 : 0;
                known = lode_start_measure(&start, &tuning, e_V, &found) || known;
                aim(&start, &tuning, 47.0f, config.current_A);
            }
            (void)lode_start_step(&start, &tuning, e_V, PAPER_TS_s);
        }
        TEST_ASSERT_EQUAL_INT(LODE_START_TURN, start.stage);
        TEST_ASSERT_TRUE(known);
        check_likely(likely(&config, &tuning, (mean_t){3.0, half[k]}, (mean_t){3.0, full[k]}),
                     found);
        const int dwell = (int)(0.15 / (ROUND * 2.0e-4));
        CHECK_AT_LEAST(dwell, rounds[0] + (moves_at == LODE_START_HALF ? 0 : dwell));
        CHECK_AT_LEAST(dwell, rounds[1] + (moves_at == LODE_START_FULL ? 0 : dwell));
    }
}

/// Dead time shows along the phase that the vector waits at, by however much the damping has turned it.
static void test_dead_time_is_measured_with_a_vector_that_gives_way(void) {
    lode_start_config_t config = measuring();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    lode_start_found_t found = {0.0f, 0.0f};
    bool known = false;
    bool moved =
        false; // a rotor, as long as its EMF is neither along the phase nor along the current
    for (int n = 1; n <= 5000 && !known; n++) {
        start.swing_V = 0.3f / tuning.damping; // 0.3 rad
        const lode_dq_t e = {4.0f, n < 1000 ? 1.0f : 0.0f};
        const lode_ab_t e_V = lode_park_inverse(e, start.at);
        if (n % ROUND == 1) {
            known = lode_start_measure(&start, &tuning, e_V, &found);
            aim(&start, &tuning, 47.0f, config.current_A);
            moved = moved || (n < 1000 && start.seen.rest.calm > 0u);
        }
        (void)lode_start_step(&start, &tuning, e_V, PAPER_TS_s);
    }
    TEST_ASSERT_TRUE(known);
    TEST_ASSERT_FALSE(moved);
    const likely_t expected = likely(&config, &tuning, (mean_t){4.0, LOOSE}, (mean_t){4.0, SURE});
    CHECK_NEAR(0.02, expected.r_Ohm, found.r_Ohm);
    CHECK_NEAR(0.15, expected.dead_V, found.dead_V);
}

/// A rotor that swings fast has come to rest: both currents tell. `times`: as fast as paper 1's.
static void test_two_means_of_a_rotor_at_rest_part_resistance_and_dead_time(void) {
    const lode_start_config_t config = measuring();
    const lode_start_tuning_t slow = tuned(&config);
    const int rounds = slow.dwell_rounds / 15 + CALM_ROUNDS;
    const double swung_rad = (double)(rounds * ROUND) / 3.0 * (double)slow.swing_weight;
    const double times[] = {1.0, 0.97 * 5.0 / swung_rad, 1.03 * 5.0 / swung_rad};
    for (int k = 0; k < COUNT_OF(times); k++) {
        lode_start_tuning_t tuning = slow;
        tuning.swing_weight = (float)(times[k] * (double)slow.swing_weight);
        lode_start_t start;
        lode_start_begin(&start, &tuning);
        lode_start_found_t found = {0.0f, 0.0f};
        const double full_V = 0.3 * (double)config.current_A - 1.2;
        const double half_V = 0.15 * (double)config.current_A - 1.2;
        bool known = false;
        for (int n = 1; n <= 10000 && !known; n++) {
            const double along_V = 0.3 * (double)start.current_A - 1.2;
            const lode_ab_t e_V = lode_park_inverse((lode_dq_t){(float)along_V, 0.0f}, start.at);
            if (n % ROUND == 1) {
                known = lode_start_measure(&start, &tuning, e_V, &found);
                aim(&start, &tuning, 47.0f, config.current_A);
            }
            (void)lode_start_step(&start, &tuning, e_V, PAPER_TS_s);
        }
        TEST_ASSERT_TRUE(known);
        const mean_t half = {half_V, k == 2 ? SURE : LOOSE};
        check_likely(likely(&config, &tuning, half, (mean_t){full_V, SURE}), found);
        if (k == 2) {
            CHECK_NEAR(0.1, 0.3, found.r_Ohm);
            CHECK_NEAR(0.5, -1.2, found.dead_V);
        }
    }
}

static void test_a_new_attempt_measures_again(void) {
    lode_start_config_t config = measuring();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    int first = 0;
    for (int n = 1; start.failed == 0u; n++) {
        lode_start_found_t found;
        if (n % ROUND == 1) {
            first += lode_start_measure(&start, &tuning, no_emf, &found) ? 1 : 0;
        }
        (void)step(&start, &tuning, n, 47.0f, 8.0f, no_emf);
    }
    TEST_ASSERT_EQUAL_INT(1, first);
    CHECK_NEAR(
        0.01, -0.5,
        start.at.cos); // on a phase again, 120 degrees on (S41), of which a period may have passed
    CHECK_NEAR(0.01, sqrt(0.75), start.at.sin);
    int second = 0;
    for (int n = 1; n <= 5000; n++) {
        lode_start_found_t found;
        if (n % ROUND == 1) {
            second += lode_start_measure(&start, &tuning, no_emf, &found) ? 1 : 0;
        }
        (void)step(&start, &tuning, n, 47.0f, 8.0f, no_emf);
    }
    TEST_ASSERT_EQUAL_INT(1, second);
    // On the way to a stop there is nothing to measure.
    lode_start_begin(&start, &tuning);
    aim(&start, &tuning, 0.0f, 0.0f);
    TEST_ASSERT_TRUE(start.current_target == 0.0f);
}

/// Between what makes the resistance known and the round in which it is worked out.
static void test_a_stop_ends_the_measurement(void) {
    lode_start_config_t config = measuring();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_found_t found = {7.0f, 8.0f};
    lode_start_begin(&start, &tuning);
    for (int n = 1; start.stage != LODE_START_FOUND && n < 20000; n++) {
        if (n % ROUND == 1) {
            TEST_ASSERT_FALSE(lode_start_measure(&start, &tuning, no_emf, &found));
        }
        (void)step(&start, &tuning, n, 47.0f, 8.0f, no_emf);
    }
    TEST_ASSERT_EQUAL_INT(LODE_START_FOUND, start.stage);
    lode_start_t measured = start;
    TEST_ASSERT_TRUE(lode_start_measure(&measured, &tuning, no_emf, &found));
    CHECK_NEAR(1.0e-6, 0.0, found.r_Ohm);
    TEST_ASSERT_EQUAL_INT(LODE_START_TURN, measured.stage);
    found = (lode_start_found_t){7.0f, 8.0f};
    aim(&start, &tuning, 0.0f, 0.0f);
    start.current_A = 0.0f;
    TEST_ASSERT_FALSE(lode_start_measure(&start, &tuning, no_emf, &found));
    TEST_ASSERT_TRUE(found.r_Ohm == 7.0f && found.dead_V == 8.0f);
    TEST_ASSERT_EQUAL_INT(LODE_START_TURN, start.stage);
}

/// (S31)
static void test_the_vector_gives_way_by_24_degrees_at_most(void) {
    lode_start_t start;
    lode_start_reset(&start, (lode_sincos_t){0.0f, 1.0f}, 0.0f, 1.0f);
    start.give = 1.0f;
    for (int sign = -1; sign <= 1; sign += 2) {
        start.swing_V = -0.41f * (float)sign;
        CHECK_NEAR(1.0e-6, 0.41 * sign, lode_start_shift_rad(&start));
        start.swing_V = -9.0f * (float)sign;
        CHECK_NEAR(2.0e-3, sign * 24.0 * CHECK_DEG, lode_start_shift_rad(&start));
    }
}

/// The damping turns the vector too; while it rests for a measurement it has not turned.
static void test_a_vector_turns_by_its_damping_too(void) {
    lode_start_t start;
    lode_start_reset(&start, (lode_sincos_t){0.0f, 1.0f}, 10.0f, 1.0f);
    start.give = 2.0f;
    start.swing_V = -0.1f;
    CHECK_NEAR(1.0e-6, 0.2, (double)lode_start_shifted_rad(&start, false));
    CHECK_NEAR(1.0e-6, 0.0, (double)lode_start_shifted_rad(&start, false));
    start.swing_V = 0.05f;
    CHECK_NEAR(1.0e-6, -0.3, (double)lode_start_shifted_rad(&start, false));
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    start.swing_V = -0.2f;
    aim(&start, &tuning, 0.0f, 0.0f); // nor is a stop a stage that begins
    const double turned = (double)lode_start_shift_rad(&start) + 0.1;
    CHECK_AT_LEAST(0.11, turned);
    CHECK_NEAR(1.0e-6, turned, (double)lode_start_shifted_rad(&start, false));
    CHECK_NEAR(1.0e-6, turned - 0.1,
               (double)lode_start_shifted_rad(&start, true)); // each set by itself
    start.stage = (uint_least8_t)LODE_START_HALF;
    TEST_ASSERT_TRUE(lode_start_shifted_rad(&start, false) == 0.0f);
}

static void test_measuring_is_a_choice(void) {
    const lode_motor_t motor = paper_motor();
    lode_start_config_t config = sound();
    config.measure = LODE_AUTO;
    lode_start_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, lode_start_tune(&tuning, &config, &inverter, &motor,
                                                             OMEGA_MAX, PAPER_TS_s));
    lode_start_design(&config, &inverter, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_ON, config.measure);
    config.measure = LODE_OFF;
    lode_start_design(&config, &inverter, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, config.measure);
}

/// Periods of an attempt of a drive that measures or not, by its configuration.
static int attempt_periods(const lode_start_config_t *config) {
    const lode_start_tuning_t tuning = tuned(config);
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.0f), 0.0f, 0.0f);
    int n = 1;
    while (start.failed == 0u && n < 100000) {
        (void)step(&start, &tuning, n++, config->omega_handover_rad_s, config->current_A, no_emf);
    }
    TEST_ASSERT_EQUAL_UINT16(0u, start.attempt); // the next one has all of its time
    return n - 1;
}

/// Twice what the profile takes, with what is measured in it; of a short one 0.4 s more.
static void test_time_of_an_attempt(void) {
    lode_start_config_t config = sound();
    CHECK_NEAR(ROUND, 2.0 * 0.72 / PAPER_TS_s, attempt_periods(&config));
    config.measure = LODE_ON; // twice 0.15 s
    CHECK_NEAR(ROUND, 2.0 * 1.02 / PAPER_TS_s, attempt_periods(&config));
    config.measure = LODE_OFF;
    config.current_rise_s = 0.1f;
    config.ramp_rad_s2 = 470.0f; // 0.1 + 0.1 + 0.05 s
    CHECK_NEAR(ROUND, (0.25 + 0.4) / PAPER_TS_s, attempt_periods(&config));
}

/// The rotor's swing on the vector has the natural frequency sqrt(np K/J), K its stiffness. The mean EMF is taken at 0.3
/// of it, the swing at 3 times.
static void test_corners_of_the_damping(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    const lode_motor_t motor = paper_motor();
    const double stiffness = 8.0 * 1.5 * 3.0 * 0.142;
    const double swing = sqrt(3.0 * stiffness / (double)motor.J_kgm2);
    CHECK_CLOSE(1.0e-3, 0.3 * swing, -log(1.0 - (double)tuning.mean_weight) / PAPER_TS_s);
    CHECK_CLOSE(1.0e-3, 3.0 * swing, -log(1.0 - (double)tuning.swing_weight) / PAPER_TS_s);
}

/// As much of an EMF across the vector is calm as is a tenth of what nobody knows: a microsecond of dead time, and 0.3 of
/// the drop.
static void test_how_calm_a_rotor_is_at_rest(void) {
    const lode_start_config_t given = sound();
    lode_start_config_t config = given;
    config.measure = LODE_ON;
    const lode_motor_t motor = paper_motor();
    const double calm_V =
        0.1 * (4.0 / CHECK_PI * 200.0 * 1.0e-6 * 5.0e3 + 0.3 * (double)motor.Rs_Ohm * 8.0);
    lode_start_found_t found;
    bool known = false;
    const moving_t calm = {0.97 * calm_V, 0.0};
    CHECK_NEAR(6.0, DWELLS * 30.0e-3 / (ROUND * 2.0e-4),
               measure(&config, 0.3, -1.2, calm, &known, &found));
    const moving_t swings = {1.03 * calm_V, 0.0};
    CHECK_NEAR(6.0, DWELLS * 150.0e-3 / (ROUND * 2.0e-4),
               measure(&config, 0.3, -1.2, swings, &known, &found));
}

/// A small motor's current of less than an ampere is one too.
static void test_a_start_of_half_an_ampere(void) {
    lode_start_config_t config = sound();
    config.current_A = 0.5f;
    config.current_last_A = 0.7f;
    config.measure = LODE_ON;
    lode_start_found_t found = {0.0f, 0.0f};
    bool known = false;
    (void)measure(&config, 0.3, -1.2, at_rest, &known, &found);
    TEST_ASSERT_TRUE(known);
    const lode_start_tuning_t tuning = tuned(&config);
    check_likely(likely(&config, &tuning, (mean_t){0.075 - 1.2, LOOSE}, (mean_t){0.15 - 1.2, SURE}),
                 found);
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    start.failed = 2u;
    start.stage = LODE_START_TURN;
    aim(&start, &tuning, 47.0f, 0.5f);
    TEST_ASSERT_EQUAL_FLOAT(0.7f, start.current_target);
}

/// Nothing that an earlier stage has seen is left: neither its half-waves, nor its shift, which is no turn of the vector.
static void test_a_stage_begins_anew(void) {
    lode_start_config_t config = measuring();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    memset(&start, 0xff, sizeof start);
    lode_start_begin(&start, &tuning);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, start.at.cos);
    TEST_ASSERT_EQUAL_INT(LODE_START_HALF, start.stage);
    TEST_ASSERT_EQUAL_UINT(0u, start.seen.rest.dwelt);
    TEST_ASSERT_EQUAL_UINT(0u, start.seen.rest.calm);
    CHECK_NEAR(0.0, 0.0, start.seen.rest.half_V);
    lode_start_found_t found;
    start.swing_V = 0.2f / tuning.damping;
    for (int n = 1; start.stage != LODE_START_TURN && n < 20000; n++) {
        const lode_ab_t e_V = lode_park_inverse((lode_dq_t){3.0f, 0.0f}, lode_start_vector(&start));
        if (n % ROUND == 1) {
            (void)lode_start_measure(&start, &tuning, e_V, &found);
        }
        if (start.stage != LODE_START_TURN) {
            (void)step(&start, &tuning, n, 47.0f, 8.0f, e_V);
            start.swing_V = 0.2f / tuning.damping;
        }
    }
    TEST_ASSERT_EQUAL_INT(LODE_START_TURN, start.stage);
    TEST_ASSERT_TRUE(lode_abs(lode_start_shift_rad(&start)) > 0.05f);
    CHECK_NEAR(1.0e-6, 0.0, lode_start_shifted_rad(&start, false));
    TEST_ASSERT_EQUAL_UINT(0u, start.seen.turn.waves.seen);
    CHECK_NEAR(0.0, 0.0, start.seen.turn.waves.turn_rad);
    // An attempt that begins at rest takes the current away: it has not fallen.
    start.drop = (lode_drop_t){.i_A2 = 64.0f, .held = 8u, .rounds = 2u};
    lode_start_again(&start, &tuning);
    TEST_ASSERT_EQUAL_UINT(0u, start.drop.rounds);
    TEST_ASSERT_EQUAL_UINT(0u, start.drop.held);
}

/// A rotor that is just being caught when the time is over gets the rest of the time that a lock takes. What lock there was
/// does not count for the start. One round alone to look for a rotor that turns is one.
static void test_a_late_lock_catches_too(void) {
    lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    const int last = 250 / ROUND;
    for (int lasts = 0; lasts <= 1; lasts++) {
        lode_start_t start;
        lode_start_begin(&start, &tuning);
        int n = 1;
        for (; n < 2 * last && lode_start_catches(&start) && !lode_start_is_ready(&start, &tuning);
             n++) {
            const bool locks = n > last - 3 && (lasts == 1 || n < last + 2);
            lode_start_judge(&start, &tuning, 300.0f, locks ? 0.9f : 0.0f);
        }
        TEST_ASSERT_EQUAL_INT(lasts == 1, lode_start_is_ready(&start, &tuning));
        TEST_ASSERT_EQUAL_INT(lasts == 1, lode_start_catches(&start));
        CHECK_NEAR(3.0, lasts == 1 ? 1.2 * last : last + 2, n);
        TEST_ASSERT_EQUAL_INT(lasts == 1, start.locked > 0u);
    }
    lode_start_t start;
    config.catch_s = (float)ROUND * PAPER_TS_s;
    const lode_start_tuning_t once = tuned(&config);
    lode_start_begin(&start, &once);
    TEST_ASSERT_TRUE(lode_start_catches(&start));
    lode_start_judge(&start, &once, 0.0f, 0.0f);
    TEST_ASSERT_FALSE(lode_start_catches(&start));
}

/// A stop lasts as long as it does: it is no attempt.
static void test_a_stop_is_no_attempt(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start = turning(40.0);
    start.attempt = 500u; // nor does one go on after it
    for (int n = 0; n < 5000; n++) {
        aim(&start, &tuning, 0.0f, 8.0f);
        TEST_ASSERT_EQUAL_UINT16(0u, start.attempt);
        TEST_ASSERT_EQUAL_UINT(0u, start.failed);
    }
}

/// The vector keeps its length, whatever each period's rounding adds to it.
static void test_the_vector_keeps_its_length(void) {
    const lode_start_config_t config = sound();
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start = turning(47.0);
    start.at = (lode_sincos_t){0.0f, 1.001f};
    for (int n = 1; n <= 10 * ROUND; n++) {
        (void)step(&start, &tuning, n, 47.0f, 8.0f, no_emf);
    }
    CHECK_NEAR(1.0e-5, 1.0, hypot((double)start.at.sin, (double)start.at.cos));
}

/// Where no more than half of the speeds may go by before hand-over, that is of the base speed: there the largest
/// current's drop in a winding 30 % warmer and the EMF of all flux use up the bus.
/// (S27), from its two sides: the speed at which the EMF is a quarter of the start current's drop, and half of the one
/// at which i_max in a warm winding and the EMF use up the bus.
static void test_an_emf_below_the_drop_is_of_no_use(void) {
    const double psi = 8.0e-3, Lq = 2.2e-3, i_max_A = 1.0, v_bus_V = 12.0;
    const lode_inverter_config_t bridge = {.v_bus_V = (float)v_bus_V, .i_max_A = (float)i_max_A};
    int of_use = 0;
    for (int k = 0; k <= 100; k++) {
        const double R = 2.0 + 0.04 * k;
        lode_motor_t motor = {.pole_pairs = 11.0f,
                              .Rs_Ohm = (float)R,
                              .Ld_H = (float)Lq,
                              .Lq_H = (float)Lq,
                              .psi_Wb = (float)psi,
                              .omega_rated_rad_s = 1.0e4f};
        const lode_start_config_t config = {.current_A = 0.7f};
        // u^2 = (1.3 R i + w psi)^2 + (w Lq i)^2 is above the bus's at the speed where it is used up.
        const double omega = 2.0 * R * 0.7 / (4.0 * psi);
        const double u_V = (double)LODE_VOLTAGE_USE * v_bus_V / sqrt(3.0);
        const double needed_V = hypot(1.3 * R * i_max_A + omega * psi, omega * Lq * i_max_A);
        if (fabs(needed_V - u_V) > 0.02 * u_V) {
            TEST_ASSERT_EQUAL_INT(needed_V < u_V, lode_start_has_emf(&config, &bridge, &motor));
            of_use += needed_V < u_V ? 1 : 0;
        }
        motor.omega_rated_rad_s = (float)(0.99 * omega); // half of rated speed bounds it too
        TEST_ASSERT_FALSE(lode_start_has_emf(&config, &bridge, &motor));
    }
    TEST_ASSERT_TRUE(of_use > 10 && of_use < 90); // both kinds were there
    // Less bus than the drop, however little of both: there is no base speed.
    const lode_inverter_config_t flat = {.v_bus_V = 0.01f, .i_max_A = 1.0f};
    const lode_motor_t strong = {.pole_pairs = 11.0f,
                                 .Rs_Ohm = 0.1f,
                                 .Ld_H = 1.0e-3f,
                                 .Lq_H = 1.0e-3f,
                                 .psi_Wb = 0.142f,
                                 .omega_rated_rad_s = 1.0e4f};
    const lode_start_config_t small = {.current_A = 0.7f};
    TEST_ASSERT_FALSE(lode_start_has_emf(&small, &flat, &strong));
}

static void test_hand_over_by_half_of_the_base_speed(void) {
    lode_motor_t motor = paper_motor();
    motor.Rs_Ohm = 1.5f;
    motor.omega_rated_rad_s = 200.0f;
    const lode_inverter_config_t low = {.v_bus_V = 60.0f, .i_max_A = 12.0f};
    lode_start_config_t config = {.current_A = 8.0f};
    // As of a rotor so light that it would hand over much later.
    motor.J_kgm2 = 1.0e-5f;
    lode_start_design(&config, &low, &motor, PAPER_TS_s);
    const double base = 2.0 * (double)config.omega_handover_rad_s;
    const double psi = (double)motor.psi_Wb;
    const double along_V = 1.3 * 1.5 * 12.0 + base * psi;
    const double across_V = base * (double)motor.Lq_H * 12.0;
    CHECK_CLOSE(1.0e-3, (double)LODE_VOLTAGE_USE * 60.0 / sqrt(3.0), hypot(along_V, across_V));
}

// --- What an attempt does not meet -------------------------------------------------------------

/// At hand-over speed, with an estimate and an EMF that would do.
typedef struct {
    lode_start_t start;
    lode_start_tuning_t tuning;
    lode_estimator_t estimator;
    lode_estimator_tuning_t estimator_tuning;
} attempt_t;

static attempt_t sound_attempt(void) {
    const lode_start_config_t config = sound();
    attempt_t it = {.tuning = tuned(&config), .start = turning(47.0)};
    it.start.omega_target = 47.0f;
    it.estimator.pll.omega_rad_s = 47.0f;
    it.estimator.lock = 0.9f;
    it.estimator.emf.observer.e_V = (lode_ab_t){0.0f, 47.0f * 0.142f};
    it.estimator_tuning.psi_Wb = 0.142f;
    it.estimator_tuning.pll.ts_s = PAPER_TS_s;
    return it;
}

static void check_unmet(const attempt_t *it, const char *criterion, double measured, double limit) {
    const lode_start_unmet_t unmet =
        lode_start_unmet(&it->start, &it->tuning, &it->estimator, &it->estimator_tuning);
    TEST_ASSERT_EQUAL_STRING(criterion, lode_criterion_name(unmet.criterion));
    CHECK_NEAR(1.0e-4, measured, unmet.measured);
    CHECK_NEAR(1.0e-4, limit, unmet.limit);
}

static void expect_hold(const attempt_t *it) {
    check_unmet(it, "LODE_CRITERION_HOLD", 0.0,
                (double)it->tuning.lock_rounds * ROUND * (double)PAPER_TS_s);
}

static void test_what_a_waiting_vector_does_not_meet_is_reported(void) {
    const double round_s = ROUND * (double)PAPER_TS_s;
    attempt_t it = sound_attempt();
    it.start.current_A = 3.0f;
    it.start.current_target = 8.0f;
    check_unmet(&it, "LODE_CRITERION_CURRENT", 3.0, 8.0);
    it = sound_attempt();
    it.start.stage = LODE_START_HALF;
    it.start.seen.rest = (lode_start_rest_t){.calm = 4u};
    check_unmet(&it, "LODE_CRITERION_REST", 4.0 * round_s, 12.0 * round_s); // 20 ms, whole rounds
    it.start.seen.rest.calm = 12u; // it has rested, and the time was over before the vector turned
    check_unmet(&it, "LODE_CRITERION_RAMP", 0.0, 47.0);
    it = sound_attempt();
    it.start.omega_rad_s = 20.0f;
    check_unmet(&it, "LODE_CRITERION_RAMP", 20.0, 47.0);
    it.start.omega_rad_s = -47.0f; // of a drive that has run the other way
    check_unmet(&it, "LODE_CRITERION_RAMP", -47.0, 47.0);
}

/// The same either way.
static void test_what_a_turning_vector_does_not_meet_is_reported(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        attempt_t it = sound_attempt();
        it.start.omega_rad_s *= (float)sign;
        it.start.omega_target *= (float)sign;
        it.estimator.pll.omega_rad_s *= (float)sign;
        const attempt_t met = it;
        const double lock_s = (double)it.tuning.lock_rounds * ROUND * (double)PAPER_TS_s;
        check_unmet(&it, "LODE_CRITERION_HOLD", 0.0, lock_s);
        it.start.locked = 5u;
        check_unmet(&it, "LODE_CRITERION_HOLD", 5.0 * ROUND * (double)PAPER_TS_s, lock_s);
        it.estimator.emf.observer.e_V = (lode_ab_t){1.0f, 0.0f};
        check_unmet(&it, "LODE_CRITERION_EMF", 1.0, 0.45 * 47.0 * 0.142);
        it.estimator_tuning.droop_s2 = 1.0e-4f; // what the observer takes is given back
        check_unmet(&it, "LODE_CRITERION_EMF", 1.0 + 0.2209, 0.45 * 47.0 * 0.142);
        it = met;
        it.estimator.pll.omega_rad_s = 30.0f * (float)sign;
        check_unmet(&it, "LODE_CRITERION_SPEED", 30.0 * sign, 0.75 * 47.0 * sign);
        it.estimator.pll.omega_rad_s = 60.0f * (float)sign;
        check_unmet(&it, "LODE_CRITERION_SPEED", 60.0 * sign, 1.25 * 47.0 * sign);
        it.estimator.pll.omega_rad_s = NAN;
        it.estimator.emf.observer.e_V = (lode_ab_t){NAN, 0.0f};
        TEST_ASSERT_EQUAL_INT(
            LODE_CRITERION_EMF,
            lode_start_unmet(&it.start, &it.tuning, &it.estimator, &it.estimator_tuning).criterion);
        it = met;
        it.tuning.lost_per_A = 0.05f;
        it.estimator.id_A = 9.0f;
        check_unmet(&it, "LODE_CRITERION_FLUX", 0.45, 0.4);
        it = met;
        it.estimator.lock = 0.6f;
        check_unmet(&it, "LODE_CRITERION_LOCK", 0.6, 0.7);
    }
}

/// What is just at a limit meets it.
static void test_what_is_at_its_limit_is_met(void) {
    static const float speeds[] = {30.0f, 60.0f}; // below and above what is asked for
    for (int n = 0; n < COUNT_OF(speeds); n++) {
        attempt_t it = sound_attempt();
        it.estimator.pll.omega_rad_s = speeds[n];
        const lode_start_unmet_t unmet =
            lode_start_unmet(&it.start, &it.tuning, &it.estimator, &it.estimator_tuning);
        it.estimator.pll.omega_rad_s = unmet.limit;
        expect_hold(&it);
    }
    attempt_t it = sound_attempt();
    it.tuning.lost_per_A = 1.0f;
    it.estimator.id_A = LODE_START_LOST_MAX;
    it.estimator.lock = LODE_LOCK_HANDOVER;
    expect_hold(&it);
    it.estimator.emf.observer.e_V = (lode_ab_t){1.0f, 0.0f};
    const lode_start_unmet_t unmet =
        lode_start_unmet(&it.start, &it.tuning, &it.estimator, &it.estimator_tuning);
    it.estimator.emf.observer.e_V.alpha = unmet.limit;
    expect_hold(&it);
}

/// The last attempt is content with twice the speed's tolerance where it takes no more than the flux (S32), but not below
/// the least speed.
static void test_the_last_attempt_tells_its_own_limits(void) {
    attempt_t it = sound_attempt();
    it.start.failed = 2u;
    it.tuning.lost_per_A = 0.01f;
    it.estimator.pll.omega_rad_s = 65.0f;
    check_unmet(&it, "LODE_CRITERION_HOLD", 0.0,
                (double)it.tuning.lock_rounds * ROUND * (double)PAPER_TS_s);
    it.estimator.pll.omega_rad_s = 75.0f;
    check_unmet(&it, "LODE_CRITERION_SPEED", 75.0, 1.5 * 47.0);
    it.estimator.pll.omega_rad_s = 30.0f;
    check_unmet(&it, "LODE_CRITERION_SPEED", 30.0, 0.75 * 47.0);
}

// ---- A rotor that slips (S42) --------------------------------------------------------------------

/// Of a rotor that has no saliency.
static attempt_t round_attempt(void) {
    attempt_t it = sound_attempt();
    it.tuning.lost_per_A = 0.0f;
    return it;
}

/// Rounds until the attempt has failed, of at most `most`, with an EMF of the share `emf` of the rotor's at the vector's speed.
static int rounds_until_failed(attempt_t *it, float emf, int most) {
    const float e_V = emf * lode_abs(it->start.omega_rad_s) * it->estimator_tuning.psi_Wb;
    it->estimator.emf.observer.e_V = (lode_ab_t){0.6f * e_V, -0.8f * e_V};
    // As long as the profile takes no attempt ends.
    it->start.attempt = (uint32_t)it->tuning.still_rounds;
    for (int n = 1; n <= most; n++) {
        lode_start_note_slip(&it->start, &it->tuning, &it->estimator, &it->estimator_tuning);
        if (lode_start_aim(&it->start, &it->tuning, it->start.omega_target, 8.0f)) {
            return n;
        }
        it->start.attempt = (uint32_t)it->tuning.still_rounds;
    }
    return most + 1;
}

/// For half of the patience and 10 radians of the swing; the same either way.
static void test_a_rotor_that_slips_ends_the_attempt(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        attempt_t it = round_attempt();
        it.start.omega_rad_s *= (float)sign;
        it.start.omega_target *= (float)sign;
        const double swing =
            sqrt(3.0 / 0.0174 * 8.0 * 0.639); // 29.6 rad/s: 10 radians take longer than 0.2 s
        const int rounds = rounds_until_failed(&it, 0.59f, 1000);
        CHECK_NEAR(2.0 * ROUND * (double)PAPER_TS_s + 0.01 * 10.0 / swing, 10.0 / swing,
                   rounds * ROUND * (double)PAPER_TS_s);
        lode_start_again(&it.start, &it.tuning);
        TEST_ASSERT_EQUAL_UINT(0u, it.start.slips);
        it = round_attempt();
        it.tuning.swing_weight *= 10.0f; // a light rotor
        const double patience_s = 0.5 * it.tuning.patience_rounds * ROUND * (double)PAPER_TS_s;
        CHECK_NEAR(2.0 * ROUND * (double)PAPER_TS_s, patience_s,
                   rounds_until_failed(&it, 0.59f, 1000) * ROUND * (double)PAPER_TS_s);
        it = round_attempt();
        TEST_ASSERT_EQUAL_INT(1001, rounds_until_failed(&it, 0.61f, 1000));
    }
}

/// What the current may take of the flux is allowed for; where next to nothing is left, nothing is said.
static void test_a_slip_is_reported_with_flux_that_is_left(void) {
    attempt_t it = sound_attempt();
    it.start.current_A = 8.0f;
    it.tuning.lost_per_A = 0.05f; // 0.4, or 0.56 with inductances that are off
    const float left = 1.0f - 1.4f * 0.4f;
    TEST_ASSERT_EQUAL_INT(1001, rounds_until_failed(&it, 0.61f * left, 1000));
    CHECK_AT_MOST(1000, rounds_until_failed(&it, 0.59f * left, 1000));
    it.start.slips = 0u;
    it.tuning.lost_per_A = 0.072f;
    TEST_ASSERT_EQUAL_INT(1001, rounds_until_failed(&it, 0.0f, 1000));
    it.tuning.lost_per_A = 0.071f;
    CHECK_AT_MOST(1000, rounds_until_failed(&it, 0.0f, 1000));
    it.start.slips = 0u;
    it.start.omega_rad_s = 46.0f; // too slow for an EMF
    TEST_ASSERT_EQUAL_INT(1001, rounds_until_failed(&it, 0.0f, 1000));
    it.start.omega_rad_s = -60.0f; // of a drive that has run the other way
    TEST_ASSERT_EQUAL_INT(1001, rounds_until_failed(&it, 0.0f, 1000));
}

/// A rotor that swings lacks the EMF at times, and has it at others; what the observer takes is given back. A stop begins anew.
static void test_a_swing_is_no_slip(void) {
    attempt_t it = round_attempt();
    const lode_ab_t enough_V = it.estimator.emf.observer.e_V;
    for (int n = 0; n < 3000; n++) {
        it.estimator.emf.observer.e_V = n / 100 % 2 == 0 ? no_emf : enough_V;
        lode_start_note_slip(&it.start, &it.tuning, &it.estimator, &it.estimator_tuning);
        CHECK_AT_MOST(100, it.start.slips);
    }
    TEST_ASSERT_EQUAL_UINT(0u, it.start.slips);
    it.estimator.emf.observer.e_V = (lode_ab_t){0.6f * 47.0f * 0.142f, 0.0f}; // just enough
    lode_start_note_slip(&it.start, &it.tuning, &it.estimator, &it.estimator_tuning);
    TEST_ASSERT_EQUAL_UINT(0u, it.start.slips);
    it.estimator_tuning.droop_s2 = 1.0f / (47.0f * 47.0f);
    TEST_ASSERT_EQUAL_INT(1001, rounds_until_failed(&it, 0.31f, 1000));
    CHECK_AT_MOST(1000, rounds_until_failed(&it, 0.29f, 1000));
    (void)lode_start_aim(&it.start, &it.tuning, 0.0f, 8.0f);
    TEST_ASSERT_EQUAL_UINT(0u, it.start.slips);
    it.estimator.emf.observer.e_V = (lode_ab_t){NAN, 0.0f};
    it.start.omega_target = 47.0f;
    it.start.slips = 65535u;
    lode_start_note_slip(&it.start, &it.tuning, &it.estimator, &it.estimator_tuning);
    TEST_ASSERT_EQUAL_UINT(65535u, it.start.slips);
}

/// The attempt after one that slipped has the last one's current at once, where that is much more; one that ended by its time
/// alone, and a start from the beginning, have not.
static void test_after_a_slip_the_current_is_the_last_ones(void) {
    for (int n = 0; n < 3; n++) {
        static const float last_A[] = {10.0f, 12.0f, 12.1f}; // 12 is 1.5 times the start's
        attempt_t it = round_attempt();
        it.tuning.current_last_A = last_A[n];
        const double more_A = n == 2 ? 12.1 : 8.0;
        CHECK_AT_MOST(1000, rounds_until_failed(&it, 0.0f, 1000));
        TEST_ASSERT_EQUAL_UINT(0u, it.start.more);
        lode_start_again(&it.start, &it.tuning);
        (void)lode_start_aim(&it.start, &it.tuning, 47.0f, 8.0f);
        CHECK_CLOSE(1.0e-6, more_A, it.start.current_target);
        TEST_ASSERT_EQUAL_UINT(1u, it.start.failed);
        (void)lode_start_aim(&it.start, &it.tuning, 0.0f, 0.0f); // a stop
        TEST_ASSERT_TRUE(it.start.current_target == 0.0f);
        it.start.failed = 0u;
        lode_start_again(&it.start, &it.tuning); // which did not slip
        (void)lode_start_aim(&it.start, &it.tuning, 47.0f, 8.0f);
        CHECK_CLOSE(1.0e-6, 8.0, it.start.current_target);
        it.start.more = 1u;
        lode_start_begin(&it.start, &it.tuning);
        TEST_ASSERT_EQUAL_UINT(0u, it.start.more);
    }
}

/// After the last attempt nothing is left to try; one that ends by its time alone is repeated.
static void test_the_last_attempt_that_slips_is_lost(void) {
    for (unsigned failed = 0u; failed <= 3u; failed++) {
        attempt_t it = round_attempt();
        it.start.failed = (uint_least8_t)failed;
        TEST_ASSERT_FALSE(lode_start_is_lost(&it.start, &it.tuning));
        CHECK_AT_MOST(1000, rounds_until_failed(&it, 0.0f, 1000));
        TEST_ASSERT_EQUAL_INT(failed >= 2u, lode_start_is_lost(&it.start, &it.tuning));
        it.tuning.swing_weight *=
            10.0f; // a light rotor: half of the patience is not yet more than it
        it.tuning.patience_rounds = 100u;
        it.start.slips = 50u;
        TEST_ASSERT_FALSE(lode_start_is_lost(&it.start, &it.tuning));
        it.start.slips = 51u;
        TEST_ASSERT_EQUAL_INT(failed >= 2u, lode_start_is_lost(&it.start, &it.tuning));
        it.tuning.swing_weight = 0.0625f; // 60 rounds of 8 periods are 10 radians
        it.start.slips = 59u;
        TEST_ASSERT_FALSE(lode_start_is_lost(&it.start, &it.tuning));
        it.start.slips = 60u;
        TEST_ASSERT_EQUAL_INT(failed >= 2u, lode_start_is_lost(&it.start, &it.tuning));
    }
}

static void test_stages_and_criteria_have_names(void) {
    TEST_ASSERT_EQUAL_STRING("LODE_START_NONE", lode_start_stage_name(LODE_START_NONE));
    TEST_ASSERT_EQUAL_STRING("LODE_START_CATCH", lode_start_stage_name(LODE_START_CATCH));
    TEST_ASSERT_EQUAL_STRING("LODE_START_HALF", lode_start_stage_name(LODE_START_HALF));
    TEST_ASSERT_EQUAL_STRING("LODE_START_FULL", lode_start_stage_name(LODE_START_FULL));
    TEST_ASSERT_EQUAL_STRING("LODE_START_ALIGN", lode_start_stage_name(LODE_START_ALIGN));
    TEST_ASSERT_EQUAL_STRING("LODE_START_ALONE", lode_start_stage_name(LODE_START_ALONE));
    TEST_ASSERT_EQUAL_STRING("LODE_START_FOUND", lode_start_stage_name(LODE_START_FOUND));
    TEST_ASSERT_EQUAL_STRING("LODE_START_TURN", lode_start_stage_name(LODE_START_TURN));
    TEST_ASSERT_EQUAL_STRING("LODE_START_UNKNOWN",
                             lode_start_stage_name((lode_start_stage_t)(LODE_START_TURN + 1)));
    TEST_ASSERT_EQUAL_STRING("LODE_CRITERION_NONE", lode_criterion_name(LODE_CRITERION_NONE));
    TEST_ASSERT_EQUAL_STRING("LODE_CRITERION_PROOF", lode_criterion_name(LODE_CRITERION_PROOF));
    TEST_ASSERT_EQUAL_STRING("LODE_CRITERION_OPEN_PHASE",
                             lode_criterion_name(LODE_CRITERION_OPEN_PHASE));
    TEST_ASSERT_EQUAL_STRING("LODE_CRITERION_POLARITY",
                             lode_criterion_name(LODE_CRITERION_POLARITY));
    TEST_ASSERT_EQUAL_STRING("LODE_CRITERION_UNKNOWN", lode_criterion_name(LODE_CRITERION_COUNT));
}

/// An attempt up to where the vector turns.
typedef struct {
    lode_start_t start;
    int stood;        ///< rounds with all of the current at LODE_START_ALIGN
    int rounds;       ///< of all
    double moved_rad; ///< the vector, while it stood
} aligned_t;

static aligned_t aligned(lode_start_t start, const lode_start_tuning_t *tuning, float sign) {
    aligned_t run = {.start = start};
    double angle = 0.0;
    for (int n = 1; n <= 20000 && run.start.stage != LODE_START_TURN; n++) {
        lode_start_found_t found;
        if (n % ROUND == 2) {
            (void)lode_start_measure(&run.start, tuning, no_emf, &found);
        }
        const bool stands = run.start.stage == LODE_START_ALIGN && run.start.current_A > 0.0f &&
                            !(run.start.current_A < run.start.current_target);
        const uint32_t attempt = run.start.attempt;
        const double now = (double)step(&run.start, tuning, n, 47.0f * sign, 8.0f, no_emf);
        if (stands && n % ROUND == 1) {
            TEST_ASSERT_EQUAL_UINT(attempt, run.start.attempt); // none of its time
            run.stood++;
        }
        run.moved_rad = stands ? fmax(run.moved_rad, fabs(angle_error(now, angle))) : 0.0;
        angle = now;
        run.rounds = n / ROUND;
    }
    TEST_ASSERT_EQUAL_INT(LODE_START_TURN, run.start.stage);
    CHECK_AT_MOST(0.05, lode_abs(run.start.omega_rad_s)); // it has just begun
    return run;
}

/// (S47): with resistance measured and without, in the first attempt alone.
static void test_the_first_vector_stands_for_the_time_that_is_asked_for(void) {
    for (int n = 0; n < 4; n++) {
        lode_start_config_t config = measuring();
        config.measure = n < 2 ? LODE_ON : LODE_OFF;
        config.align_s = 0.4005f; // no whole number of rounds
        const float sign = n % 2 == 0 ? 1.0f : -1.0f;
        const lode_start_tuning_t tuning = tuned(&config);
        lode_start_t start;
        lode_start_begin(&start, &tuning);
        const aligned_t first = aligned(start, &tuning, sign);
        TEST_ASSERT_EQUAL_INT((int)ceil(0.4005 / (ROUND * 2.0e-4)), first.stood);
        CHECK_NEAR(8.0e-3, 8.0, first.start.current_A);
        CHECK_NEAR(1.0e-5, 0.0, first.moved_rad);
        start = first.start;
        lode_start_again(&start, &tuning);
        TEST_ASSERT_LESS_OR_EQUAL_INT(1, aligned(start, &tuning, sign).stood);
        // Nor in one that follows on a lock that went in RUN, whose current rises for 0.2 s more.
        lode_start_begin(&start, &tuning);
        start.failed = 1u;
        const aligned_t next = aligned(start, &tuning, sign);
        TEST_ASSERT_LESS_OR_EQUAL_INT(1, next.stood);
        const int later = (int)(0.2 / (ROUND * 2.0e-4));
        TEST_ASSERT_INT_WITHIN(1, first.stood - later, first.rounds - next.rounds);
    }
}

static void test_a_vector_that_turns_already_is_not_stopped_to_stand(void) {
    lode_start_config_t config = measuring();
    config.align_s = 0.4f;
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_reset(&start, lode_sincos(0.5f), 40.0f, 8.0f);
    for (int n = 1; n <= 10; n++) {
        aim(&start, &tuning, 47.0f, 8.0f);
        TEST_ASSERT_EQUAL_INT(LODE_START_TURN, start.stage);
    }
    TEST_ASSERT_EQUAL_UINT(10u, start.attempt);
}

static void test_a_vector_that_stands_ends_with_a_stop_and_tells_where_it_is(void) {
    lode_start_config_t config = measuring();
    config.measure = LODE_OFF;
    config.align_s = 0.4f;
    const lode_start_tuning_t tuning = tuned(&config);
    lode_start_t start;
    lode_start_begin(&start, &tuning);
    TEST_ASSERT_EQUAL_INT(LODE_START_ALIGN, start.stage);
    for (int n = 1; n <= 2000; n++) {
        (void)step(&start, &tuning, n, 47.0f, 8.0f, no_emf);
    }
    // 0.2 s for the current, then 0.2 s.
    const lode_estimator_t estimator = {.lock = 0.0f};
    const lode_estimator_tuning_t estimator_tuning = {.pll.ts_s = PAPER_TS_s};
    const lode_start_unmet_t unmet =
        lode_start_unmet(&start, &tuning, &estimator, &estimator_tuning);
    TEST_ASSERT_EQUAL_INT(LODE_CRITERION_REST, unmet.criterion);
    CHECK_NEAR(4.0e-3, 0.2, unmet.measured);
    CHECK_NEAR(1.0e-5, 0.4, unmet.limit);
    (void)lode_start_aim(&start, &tuning, 0.0f, 0.0f);
    TEST_ASSERT_EQUAL_INT(LODE_START_TURN, start.stage);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, start.current_target);
}

static void test_range_of_the_time_to_stand(void) {
    const size_t align = offsetof(lode_start_config_t, align_s);
    const float good[] = {0.0f, 1.0e-4f, 10.0f};
    const float bad[] = {-1.0e-4f, 10.001f, NAN, INFINITY, -INFINITY};
    for (int n = 0; n < COUNT_OF(good); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(align, good[n]));
    }
    for (int n = 0; n < COUNT_OF(bad); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_START_RAMP, try_one(align, bad[n]));
    }
    // The longest that the counter tells, at whatever rate, comes to an end.
    lode_start_config_t config = sound();
    config.align_s = 65535.0f * (float)LODE_SLOW_PERIODS * 1.0e-5f;
    const lode_motor_t motor = paper_motor();
    lode_start_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_start_tune(&tuning, &config, &inverter, &motor, OMEGA_MAX, 1.0e-5f));
    CHECK_AT_MOST(65535.0, tuning.align_rounds);
    // All attempts have one time-out, which is as much longer.
    lode_start_config_t without = {.measure = LODE_ON};
    lode_start_config_t with = {.measure = LODE_ON, .align_s = 2.0f};
    lode_start_design(&without, &inverter, &motor, PAPER_TS_s);
    lode_start_design(&with, &inverter, &motor, PAPER_TS_s);
    CHECK_CLOSE(1.0e-6, (double)without.timeout_s + 2.0, with.timeout_s);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_resistance_and_dead_time_are_measured_at_rest);
    RUN_TEST(test_damping_gives_way_to_current_and_speed);
    RUN_TEST(test_resistance_is_measured_while_the_rotor_swings);
    RUN_TEST(test_a_rotor_that_falls_past_a_right_angle_is_not_at_rest);
    RUN_TEST(test_a_dwell_ends_with_its_mean);
    RUN_TEST(test_a_dwell_of_even_parts);
    RUN_TEST(test_a_swing_is_watched_to_the_round);
    RUN_TEST(test_one_of_two_means_tells_the_sum);
    RUN_TEST(test_two_means_of_a_rotor_at_rest_part_resistance_and_dead_time);
    RUN_TEST(test_dead_time_is_measured_with_a_vector_that_gives_way);
    RUN_TEST(test_a_new_attempt_measures_again);
    RUN_TEST(test_a_stop_ends_the_measurement);
    RUN_TEST(test_the_vector_gives_way_by_24_degrees_at_most);
    RUN_TEST(test_a_vector_turns_by_its_damping_too);
    RUN_TEST(test_measuring_is_a_choice);
    RUN_TEST(test_hand_over_speed_follows_what_is_not_known);
    RUN_TEST(test_a_light_salient_rotor_hands_over_later);
    RUN_TEST(test_a_reluctance_machine_hands_over_later);
    RUN_TEST(test_each_attempt_is_easier);
    RUN_TEST(test_a_default_ramp_begins_gently);
    RUN_TEST(test_the_current_falls_where_no_lock_comes);
    RUN_TEST(test_the_current_of_the_last_attempt_falls_as_far);
    RUN_TEST(test_current_rises_first_then_the_vector_turns);
    RUN_TEST(test_no_step_of_the_vector_is_lost_to_rounding);
    RUN_TEST(test_angle_is_the_integral_of_the_speed);
    RUN_TEST(test_the_vector_sweeps_while_the_current_rises);
    RUN_TEST(test_a_vector_that_is_measured_sweeps_to_two_axes);
    RUN_TEST(test_a_free_rotor_hardly_turns_back_by_more_than_half_a_turn);
    RUN_TEST(test_a_slower_rise_turns_fewer_rotors_back);
    RUN_TEST(test_a_rotor_whose_axis_is_known_turns_back_by_less);
    RUN_TEST(test_a_rotor_that_was_held_opposite_is_not_pulled_back_twice);
    RUN_TEST(test_a_vector_that_leads_the_axis_stands);
    RUN_TEST(test_way_back_takes_up_a_turning_vector);
    RUN_TEST(test_damping_calms_the_rotor);
    RUN_TEST(test_a_loaded_rotor_at_speed_is_calmed);
    RUN_TEST(test_the_size_of_the_emf_comes_in_with_speed);
    RUN_TEST(test_damping_gives_way_to_a_bound);
    RUN_TEST(test_any_emf_gives_an_angle);
    RUN_TEST(test_a_slow_target_is_started_to);
    RUN_TEST(test_a_failed_attempt_begins_again_at_rest);
    RUN_TEST(test_hand_over_needs_the_lock_for_its_time);
    RUN_TEST(test_the_last_attempt_takes_what_lock_there_is);
    RUN_TEST(test_hand_over_needs_speed_and_direction);
    RUN_TEST(test_a_vector_that_turns_does_not_sweep);
    RUN_TEST(test_the_current_has_a_bound);
    RUN_TEST(test_a_later_attempt_rises_at_half_the_rate);
    RUN_TEST(test_the_next_vector_is_known);
    RUN_TEST(test_a_rotor_that_turns_already_is_caught);
    RUN_TEST(test_no_rounds_left_to_look_for_a_rotor_are_over);
    RUN_TEST(test_range_of_the_time_to_catch);
    RUN_TEST(test_times_become_rounds);
    RUN_TEST(test_times_have_room_in_their_counters);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_a_salient_rotor_is_seen_locked_within_a_turn);
    RUN_TEST(test_design_fills_what_is_open);
    RUN_TEST(test_time_of_an_attempt);
    RUN_TEST(test_corners_of_the_damping);
    RUN_TEST(test_how_calm_a_rotor_is_at_rest);
    RUN_TEST(test_a_start_of_half_an_ampere);
    RUN_TEST(test_a_stage_begins_anew);
    RUN_TEST(test_a_late_lock_catches_too);
    RUN_TEST(test_a_stop_is_no_attempt);
    RUN_TEST(test_the_vector_keeps_its_length);
    RUN_TEST(test_an_emf_below_the_drop_is_of_no_use);
    RUN_TEST(test_hand_over_by_half_of_the_base_speed);
    RUN_TEST(test_what_a_waiting_vector_does_not_meet_is_reported);
    RUN_TEST(test_what_a_turning_vector_does_not_meet_is_reported);
    RUN_TEST(test_what_is_at_its_limit_is_met);
    RUN_TEST(test_the_last_attempt_tells_its_own_limits);
    RUN_TEST(test_a_rotor_that_slips_ends_the_attempt);
    RUN_TEST(test_a_slip_is_reported_with_flux_that_is_left);
    RUN_TEST(test_a_swing_is_no_slip);
    RUN_TEST(test_after_a_slip_the_current_is_the_last_ones);
    RUN_TEST(test_the_last_attempt_that_slips_is_lost);
    RUN_TEST(test_stages_and_criteria_have_names);
    RUN_TEST(test_the_first_vector_stands_for_the_time_that_is_asked_for);
    RUN_TEST(test_a_vector_that_turns_already_is_not_stopped_to_stand);
    RUN_TEST(test_a_vector_that_stands_ends_with_a_stop_and_tells_where_it_is);
    RUN_TEST(test_range_of_the_time_to_stand);
    return UNITY_END();
}
