// Angle and speed from voltages and currents: synthetic motor, recordings, recovery from any state.
#include "support/fields.h"
#include "support/ipmsm.h"
#include "support/recording.h"

#include "estimator_inline.h"

void setUp(void) {}

void tearDown(void) {}

static const lode_pll_kind_t both_plls[] = {LODE_PLL_LESO, LODE_PLL_QPLL};

/// Completed from nothing but the PLL's kind.
static lode_estimator_config_t designed(lode_pll_kind_t pll) {
    const lode_motor_t motor = paper_motor();
    lode_estimator_config_t config = {.pll = {.kind = pll}};
    lode_estimator_design(&config, &motor, PAPER_TS_s);
    return config;
}

static lode_estimator_tuning_t tuned(const lode_estimator_config_t *config) {
    const lode_motor_t motor = paper_motor();
    lode_estimator_tuning_t tuning;
    TEST_ASSERT_EQUAL_STRING(
        "LODE_OK", lode_status_name(lode_estimator_tune(&tuning, config, &motor, PAPER_TS_s)));
    return tuning;
}

/// A motor and the estimator that watches it.
typedef struct {
    ipmsm_t motor;
    lode_estimator_tuning_t tuning;
    lode_estimator_t estimator;
    lode_estimate_t last;
    bool reseeded; ///< at least once
} watch_t;

static watch_t watch(const lode_estimator_config_t *config, double omega, double iq) {
    watch_t w = {.motor = ipmsm_paper(omega), .tuning = tuned(config)};
    w.motor.iq = iq;
    lode_estimator_reset(&w.estimator, &w.tuning);
    return w;
}

/// One period with the motor held at (id, iq); returns the angle's error, rad.
static double watch_step(watch_t *w, double id, double iq) {
    const double ts = 2.0e-4;
    const lode_ab_t u = ipmsm_voltage(&w->motor, id, iq, ts);
    ipmsm_step(&w->motor, (double)u.alpha, (double)u.beta, ts);
    w->last = lode_estimator_step(&w->estimator, &w->tuning, u, ipmsm_current(&w->motor));
    w->reseeded = w->reseeded || w->last.reseeded;
    return angle_error((double)lode_estimate_theta_rad(&w->last), w->motor.theta);
}

static void check_steady(const lode_estimator_config_t *config, double rpm, double iq) {
    watch_t w = watch(config, paper_omega(rpm), iq);
    for (int k = 0; k < 4000; k++) { // 0.8 s: 60 time constants L/R of the open-loop currents
        (void)watch_step(&w, 0.0, iq);
    }
    double sum = 0.0;
    worst_t speed = {0.0};
    for (int k = 0; k < 500; k++) {
        sum += watch_step(&w, 0.0, iq);
        worst_note(&speed, (double)w.last.omega_rad_s - w.motor.omega);
    }
    // What the exact compensation is to leave: 0.02 degree.
    CHECK_NEAR(0.02 * CHECK_DEG, 0.0, sum / 500.0);
    CHECK_AT_MOST(1.0e-3 * fabs(w.motor.omega) + 0.05, speed.value); // float noise of 0.1 %
    // The EMF's amplitude comes with the observer's gain, 0.95 at 1500 rpm.
    CHECK_AT_LEAST(0.85, w.last.lock);
    // Its current is the motor's, in the rotor's frame, within that angle and float rounding.
    CHECK_NEAR(5.0e-3, w.motor.id, w.last.i_A.d);
    CHECK_NEAR(5.0e-3, w.motor.iq, w.last.i_A.q);
    // At constant speed the load takes the torque that friction leaves (LESO-QPLL only).
    const bool leso = config->pll.kind == LODE_PLL_LESO;
    const double load = ipmsm_torque(&w.motor) - 7.5e-4 * w.motor.omega / 3.0;
    CHECK_NEAR(0.05, leso ? load : 0.0, w.last.load_torque_Nm);
}

static void test_steady_angle_open_loop(void) {
    const double rpms[] = {300.0, 600.0, 900.0, 1200.0, 1500.0};
    const double rated = 5.0 / 0.639;
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        const lode_estimator_config_t config = designed(both_plls[p]);
        for (int r = 0; r < COUNT_OF(rpms); r++) {
            for (int sign = -1; sign <= 1; sign += 2) {
                check_steady(&config, sign * rpms[r], 0.0);
                check_steady(&config, sign * rpms[r], sign * rated);
                check_steady(&config, sign * rpms[r], -sign * rated); // braking
            }
        }
    }
}

static void test_paper_settings(void) {
    // w0 = 2000 rad/s, sigma = 150 rad/s at all speeds: with the active-flux term it holds.
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        lode_estimator_config_t config = {.emf = {.w0_rad_s = 2000.0f},
                                          .pll = {.kind = both_plls[p], .sigma_rad_s = 150.0f}};
        const lode_motor_t motor = paper_motor();
        lode_estimator_design(&config, &motor, PAPER_TS_s);
        check_steady(&config, 300.0, 5.0 / 0.639);
        check_steady(&config, 1500.0, 5.0 / 0.639);
    }
}

static void test_without_compensation_the_angle_lags_as_computed(void) {
    // Degrees at w0 = 2000 rad/s, from the table of the exact current form.
    const double table[][2] = {{300.0, 4.926}, {900.0, 14.685}, {1500.0, 24.169}};
    const lode_motor_t motor = paper_motor();
    for (int i = 0; i < COUNT_OF(table); i++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            lode_estimator_config_t config = {.emf = {.w0_rad_s = 2000.0f},
                                              .compensation = LODE_LAG_NONE};
            lode_estimator_design(&config, &motor, PAPER_TS_s);
            watch_t w = watch(&config, sign * paper_omega(table[i][0]), 0.0);
            double error = 0.0;
            for (int k = 0; k < 4000; k++) {
                error = watch_step(&w, 0.0, 0.0);
            }
            CHECK_NEAR(0.05, -sign * table[i][1], error / CHECK_DEG); // single samples carry noise
        }
    }
}

static void test_acquisition_from_reset_takes_milliseconds(void) {
    const double rpms[] = {-3000.0, -1500.0, -300.0, 150.0, 300.0, 1500.0, 3000.0};
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        const lode_estimator_config_t config = designed(both_plls[p]);
        for (int r = 0; r < COUNT_OF(rpms); r++) {
            for (int start = 0; start < 8; start++) {
                watch_t w = watch(&config, paper_omega(rpms[r]), 0.0);
                w.motor.theta = start * CHECK_PI / 4.0 - CHECK_PI;
                double error = 0.0;
                for (int k = 0; k < 500; k++) { // 0.1 s
                    error = watch_step(&w, 0.0, 0.0);
                }
                CHECK_NEAR(2.0 * CHECK_DEG, 0.0, error);
                CHECK_AT_LEAST(LODE_LOCK_LOST, w.last.lock);
            }
        }
    }
}

/// A load that holds 10 A of torque on a rotor so light that the current alone would double its speed
/// within 3 ms: found all the same, from nothing.
static void test_acquisition_under_load_of_a_light_rotor(void) {
    lode_motor_t light = paper_motor();
    light.J_kgm2 *= 0.02f;
    lode_estimator_config_t config = designed(LODE_PLL_LESO);
    for (int sign = -1; sign <= 1; sign += 2) {
        watch_t w = watch(&config, sign * paper_omega(300.0), sign * 10.0);
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_estimator_tune(&w.tuning, &config, &light, PAPER_TS_s));
        lode_estimator_reset(&w.estimator, &w.tuning);
        double error = 0.0;
        for (int k = 0; k < 1000; k++) { // 0.2 s
            error = watch_step(&w, 0.0, sign * 10.0);
        }
        CHECK_NEAR(3.0 * CHECK_DEG, 0.0, error);
        CHECK_AT_LEAST(LODE_LOCK_LOST, w.last.lock);
    }
}

/// Steady lock quality at the speed `omega`, no load.
static double steady_lock(const lode_estimator_config_t *config, double omega) {
    watch_t w = watch(config, omega, 0.0);
    for (int k = 0; k < 4000; k++) {
        (void)watch_step(&w, 0.0, 0.0);
    }
    return (double)w.last.lock;
}

/// Of a motor as told there is nothing beyond the magnets' EMF, whatever the speed, the current and the direction; of one with
/// less flux than told what it lacks is.
static void test_the_EMF_beyond_that_of_the_magnets(void) {
    static const double omegas[] = {100.0, 300.0, 470.0, -100.0, -470.0};
    for (int n = 0; n < 5; n++) {
        const double omega = omegas[n];
        const lode_estimator_config_t config = designed(LODE_PLL_LESO);
        watch_t w = watch(&config, omega, 4.0);
        for (int k = 0; k < 4000; k++) {
            (void)watch_step(&w, -2.0, 4.0);
        }
        const double e_V = (double)lode_ab_length(w.last.e_V);
        const lode_ab_t none_V = lode_estimator_beyond_V(&w.estimator, &w.tuning);
        CHECK_AT_MOST(0.01 * e_V, (double)lode_ab_length(none_V));
        w.tuning.psi_Wb *= 1.25f;
        const lode_ab_t less_V = lode_estimator_beyond_V(&w.estimator, &w.tuning);
        const lode_dq_t seen_V = lode_park(less_V, w.estimator.pll.frame);
        const double more_V = omega * 0.2 * (double)w.tuning.psi_Wb /
                              (1.0 + omega * omega * (double)w.tuning.droop_s2);
        CHECK_NEAR(0.01 * e_V, 0.0, (double)seen_V.d);
        CHECK_NEAR(0.01 * e_V, -more_V, (double)seen_V.q);
    }
}

static void test_sound_running_keeps_its_lock_at_all_speeds(void) {
    // Whatever bandwidth is accepted: an ideal motor within omega_max must never look lost. 0.7 is
    // what a start asks for before it hands over.
    const lode_motor_t motor = paper_motor();
    const float w0s[] = {0.0f, 1000.0f, 2500.0f};
    const double shares[] = {0.1, 0.5, 1.0};
    for (int i = 0; i < COUNT_OF(w0s); i++) {
        lode_estimator_config_t config = {.emf = {.w0_rad_s = w0s[i]}};
        lode_estimator_design(&config, &motor, PAPER_TS_s);
        for (int n = 0; n < COUNT_OF(shares); n++) {
            CHECK_AT_LEAST(0.7, steady_lock(&config, shares[n] * (double)config.omega_max_rad_s));
        }
    }
}

static void test_standstill_is_no_lock(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, 0.0, 0.0);
    for (int k = 0; k < 5000; k++) {
        (void)watch_step(&w, 0.0, 0.0);
        TEST_ASSERT_TRUE(w.last.lock < LODE_LOCK_LOST);
    }
}

static void test_ramps_and_load_steps(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        const lode_estimator_config_t config = designed(LODE_PLL_LESO);
        watch_t w = watch(&config, sign * paper_omega(600.0), 0.0);
        for (int k = 0; k < 2000; k++) {
            (void)watch_step(&w, 0.0, 0.0);
        }
        worst_t ramp = {0.0};
        w.motor.acc = sign * 628.0; // 2000 rpm/s
        for (int k = 0; k < 2000; k++) {
            worst_note(&ramp, watch_step(&w, 0.0, 0.0));
        }
        w.motor.acc = 0.0;
        worst_t step = {0.0};
        for (int k = 0; k < 2000; k++) { // currents of rated torque come and go with L/R
            worst_note(&step, watch_step(&w, 0.0, k < 1000 ? 7.8 : 0.0));
        }
        CHECK_AT_MOST(6.0 * CHECK_DEG, ramp.value);
        CHECK_AT_MOST(6.0 * CHECK_DEG, step.value);
        CHECK_AT_LEAST(0.9, w.last.lock);
    }
}

/// id steps up and down by 6 A while the rotor turns evenly; the worst error after settling in.
static double worst_with_changing_id(lode_choice_t active_flux) {
    lode_estimator_config_t config = designed(LODE_PLL_QPLL);
    config.active_flux = active_flux;
    watch_t w = watch(&config, paper_omega(900.0), 0.0);
    worst_t worst = {0.0};
    for (int k = 0; k < 6000; k++) {
        const double error = watch_step(&w, k % 200 < 100 ? -3.0 : 3.0, 0.0);
        if (k > 2000) {
            worst_note(&worst, error);
        }
    }
    return worst.value;
}

static void test_changing_id_does_not_turn_the_angle(void) {
    const double with = worst_with_changing_id(LODE_ON);
    const double without = worst_with_changing_id(LODE_OFF);
    // What is left: the observer turns a changing amplitude a little. 0.32 and 7.8 degrees.
    CHECK_AT_MOST(0.5 * CHECK_DEG, with);
    CHECK_AT_LEAST(10.0 * with, without);
}

// --- Recordings -------------------------------------------------------------------------------

static recording_t recording;

/// Mean error of the angle over the last 0.1 s, row k with row k-1's voltage, from reset.
static double replayed(lode_pll_kind_t pll, bool mirrored) {
    const lode_estimator_config_t config = designed(pll);
    const lode_estimator_tuning_t tuning = tuned(&config);
    lode_estimator_t estimator;
    lode_estimator_reset(&estimator, &tuning);
    const float turn = mirrored ? -1.0f : 1.0f;
    double sum = 0.0;
    for (int k = 1; k < recording.rows; k++) {
        const lode_ab_t u = {(float)recording.u_alpha[k - 1],
                             turn * (float)recording.u_beta[k - 1]};
        const lode_ab_t i = {(float)recording.i_alpha[k], turn * (float)recording.i_beta[k]};
        const lode_estimate_t e = lode_estimator_step(&estimator, &tuning, u, i);
        if (k >= recording.rows - 500) {
            sum +=
                angle_error((double)lode_estimate_theta_rad(&e), (double)turn * recording.theta[k]);
        }
    }
    return sum / 500.0;
}

static void test_recordings_of_an_independent_simulator(void) {
    static const char *const names[] = {"steady-300rpm-5Nm.csv", "steady-1500rpm-5Nm.csv",
                                        "load-step-300rpm.csv", "ramp-300-1500-300rpm-1Nm.csv",
                                        "carrier-pwm-300rpm-5Nm.csv"};
    for (int n = 0; n < COUNT_OF(names); n++) {
        TEST_ASSERT_TRUE_MESSAGE(recording_load(&recording, names[n]), names[n]);
        for (int p = 0; p < COUNT_OF(both_plls); p++) {
            for (int mirrored = 0; mirrored < 2; mirrored++) {
                // The bar for every recording.
                CHECK_NEAR(0.05 * CHECK_DEG, 0.0, replayed(both_plls[p], mirrored != 0));
            }
        }
    }
}

// --- Recovery ---------------------------------------------------------------------------------

#define LOCK_STEPS 2500 // 0.5 s
#define RATED_STEPS 5000

/// One second of the motor at rated speed and half of rated torque, made once.
static struct {
    lode_ab_t u[RATED_STEPS], i[RATED_STEPS];
    double theta[RATED_STEPS];
    double omega;
} rated;

static void make_rated(double omega) {
    ipmsm_t motor = ipmsm_paper(omega);
    motor.iq = omega > 0.0 ? 4.0 : -4.0;
    const double iq = motor.iq;
    for (int k = -2000; k < RATED_STEPS; k++) {
        const lode_ab_t u = ipmsm_voltage(&motor, 0.0, iq, 2.0e-4);
        ipmsm_step(&motor, (double)u.alpha, (double)u.beta, 2.0e-4);
        if (k >= 0) {
            rated.u[k] = u;
            rated.i[k] = ipmsm_current(&motor);
            rated.theta[k] = motor.theta;
        }
    }
    rated.omega = omega;
}

typedef struct {
    bool flagged; ///< reseeded at least once
    bool finite;  ///< every output
    bool locked;  ///< to angle and speed over the last 0.1 s
} recovery_t;

static bool is_finite_estimate(const lode_estimate_t *e) {
    return lode_in_range(lode_estimate_theta_rad(e), -LODE_PI, LODE_PI) &&
           lode_is_finite(e->omega_rad_s) && lode_is_finite(e->rotor.sin) &&
           lode_is_finite(e->rotor.cos) && lode_is_finite(e->i_A.d) && lode_is_finite(e->i_A.q) &&
           lode_is_finite(e->e_V.alpha) && lode_is_finite(e->e_V.beta) &&
           lode_is_finite(e->load_torque_Nm);
}

static recovery_t recover(lode_estimator_t *estimator, const lode_estimator_tuning_t *tuning,
                          int steps) {
    recovery_t r = {.flagged = false, .finite = true, .locked = true};
    for (int k = 0; k < steps; k++) {
        const lode_estimate_t e = lode_estimator_step(estimator, tuning, rated.u[k], rated.i[k]);
        r.flagged = r.flagged || e.reseeded;
        // The lock quality is renewed once in LODE_SLOW_PERIODS: until then it is what it was set to.
        const bool renewed = k >= (int)LODE_SLOW_PERIODS;
        r.finite =
            r.finite && is_finite_estimate(&e) && (!renewed || lode_in_range(e.lock, 0.0f, 1.0f));
        if (k >= steps - 500) {
            const double angle = angle_error((double)lode_estimate_theta_rad(&e), rated.theta[k]);
            r.locked = r.locked && fabs(angle) < 1.0 * CHECK_DEG && e.lock >= LODE_LOCK_LOST &&
                       fabs((double)e.omega_rad_s - rated.omega) < 0.01 * fabs(rated.omega);
        }
    }
    return r;
}

static lode_ab_t random_vector(random_t *random, double length) {
    const double angle = random_between(random, -CHECK_PI, CHECK_PI);
    const double l = random_between(random, 0.0, length);
    return (lode_ab_t){(float)(l * cos(angle)), (float)(l * sin(angle))};
}

/// |w| up to twice the highest, f and EMF up to ten times rated, everything else anywhere.
static lode_estimator_t random_state(random_t *random, const lode_estimator_tuning_t *tuning) {
    const double e_rated = PAPER_OMEGA_RATED * 0.142;
    const double f_rated = 3.0 / 0.0174 * 5.0; // np T/J
    const double omega_max = 0.5 * (double)tuning->omega_limit;
    lode_estimator_t s;
    lode_estimator_reset(&s, tuning);
    s.emf.observer.e_V = random_vector(random, 10.0 * e_rated);
    s.emf.observer.own[0] = random_vector(random, 10.0 * e_rated);
    s.emf.i_A = random_vector(random, 80.0);
    s.pll.frame = sincos_of(random_between(random, -CHECK_PI, CHECK_PI));
    s.pll.omega_rad_s = random_float(random, -2.0 * omega_max, 2.0 * omega_max);
    s.pll.f_rad_s2 = random_float(random, -10.0 * f_rated, 10.0 * f_rated);
    s.pll.rise_rad_s = tuning->pll.ts_s * random_float(random, -20.0 * f_rated, 20.0 * f_rated);
    s.omega_tune = random_float(random, -2.0 * omega_max, 2.0 * omega_max);
    s.gains = lode_pll_gains(&tuning->pll, random_float(random, -omega_max, omega_max));
    s.lag = lode_lag_line(&tuning->lag, random_float(random, -omega_max, omega_max));
    s.per_V = random_float(random, -1.0, 1.0) / tuning->emin_V;
    s.id_A = random_float(random, -80.0, 80.0);
    s.locked = random_bits(random) % 2u == 0u;
    s.slot = (uint_least8_t)random_bits(random);
    s.by.alone.rotation = random_vector(random, e_rated * e_rated);
    s.lock = random_float(random, 0.0, 1.0);
    s.by.alone.wait = (uint_least16_t)(random_bits(random) % (tuning->settle_rounds + 1u));
    return s;
}

static void test_reconvergence_from_1000_random_states(void) {
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        const lode_estimator_config_t config = designed(both_plls[p]);
        const lode_estimator_tuning_t tuning = tuned(&config);
        random_t random = random_seed(7);
        int relocked = 0;
        for (int n = 0; n < 1000; n++) {
            if (n % 500 == 0) {
                make_rated(n == 0 ? PAPER_OMEGA_RATED : -PAPER_OMEGA_RATED);
            }
            lode_estimator_t state = random_state(&random, &tuning);
            const recovery_t r = recover(&state, &tuning, LOCK_STEPS);
            TEST_ASSERT_TRUE(r.finite);
            relocked += r.locked ? 1 : 0;
        }
        TEST_ASSERT_EQUAL_INT(1000, relocked);
    }
}

static bool is_in_range(const lode_estimator_t *s, const lode_estimator_tuning_t *t) {
    return lode_ab_in_range(s->emf.observer.e_V, FLT_MAX) &&
           lode_ab_in_range(s->emf.observer.own[0], FLT_MAX) &&
           lode_ab_in_range(s->emf.i_A, FLT_MAX) && lode_in_range(s->pll.frame.sin, -1.0f, 1.0f) &&
           lode_in_range(s->pll.frame.cos, -1.0f, 1.0f) &&
           lode_in_range(s->pll.omega_rad_s, -t->omega_limit, t->omega_limit) &&
           lode_is_finite(s->pll.f_rad_s2) && lode_is_finite(s->pll.rise_rad_s);
}

static void test_any_state_is_detected_flagged_and_relocked(void) {
    make_rated(PAPER_OMEGA_RATED);
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        const lode_estimator_config_t config = designed(both_plls[p]);
        const lode_estimator_tuning_t tuning = tuned(&config);
        random_t random = random_seed(8);
        for (int n = 0; n < 1000; n++) {
            lode_estimator_t state;
            lode_estimator_reset(&state, &tuning);
            float *const fields[] = {&state.emf.i_A.alpha,
                                     &state.emf.i_A.beta,
                                     &state.emf.observer.own[0].alpha,
                                     &state.emf.observer.own[0].beta,
                                     &state.emf.observer.e_V.alpha,
                                     &state.emf.observer.e_V.beta,
                                     &state.omega_tune,
                                     &state.pll.frame.sin,
                                     &state.pll.frame.cos,
                                     &state.pll.omega_rad_s,
                                     &state.pll.f_rad_s2,
                                     &state.pll.rise_rad_s,
                                     &state.id_A,
                                     &state.by.alone.rotation.alpha,
                                     &state.by.alone.rotation.beta,
                                     &state.by.alone.before_V.alpha,
                                     &state.by.alone.before_V.beta,
                                     &state.lock};
            // First every field alone with every odd number, then all of them at random.
            const int single =
                n < COUNT_OF(fields) * COUNT_OF(check_odd_floats) ? n % COUNT_OF(fields) : -1;
            for (int f = 0; f < COUNT_OF(fields); f++) {
                if (single < 0) {
                    *fields[f] = random_any(&random);
                } else if (f == single) {
                    *fields[f] = check_odd_floats[n / COUNT_OF(fields)];
                }
            }
            if (single < 0) {
                state.by.alone.wait = (uint_least16_t)random_bits(&random);
                state.slot = (uint_least8_t)random_bits(&random);
                state.locked = random_bits(&random) % 2u == 0u;
            }
            const bool sound = is_in_range(&state, &tuning);
            // An EMF of 1e38 V takes its time to leave an observer that is not clamped.
            const recovery_t r = recover(&state, &tuning, RATED_STEPS);
            char text[40];
            (void)snprintf(text, sizeof text, "state %d", n);
            TEST_ASSERT_TRUE_MESSAGE(r.finite, text);
            TEST_ASSERT_TRUE_MESSAGE(r.locked, text);
            TEST_ASSERT_TRUE_MESSAGE(sound || r.flagged, text);
        }
    }
}

static void test_what_is_derived_is_renewed(void) {
    // Gains, lag and the reciprocal of the EMF follow from speed and EMF: whatever they are, they are so
    // for LODE_SLOW_PERIODS at most.
    make_rated(PAPER_OMEGA_RATED);
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        const lode_estimator_config_t config = designed(both_plls[p]);
        const lode_estimator_tuning_t tuning = tuned(&config);
        for (int n = 0; n < 6 * COUNT_OF(check_odd_floats); n++) {
            lode_estimator_t state;
            lode_estimator_reset(&state, &tuning);
            (void)recover(&state, &tuning, 1000 + n % 8);
            float *const fields[] = {&state.gains.theta, &state.gains.omega_s, &state.gains.f_s2,
                                     &state.lag.at.sin,  &state.lag.at.cos,    &state.per_V};
            *fields[n % 6] = check_odd_floats[n / 6];
            for (int k = 0; k < (int)LODE_SLOW_PERIODS; k++) {
                (void)lode_estimator_step(&state, &tuning, rated.u[0], rated.i[0]);
            }
            const recovery_t r = recover(&state, &tuning, LOCK_STEPS);
            TEST_ASSERT_TRUE(r.finite);
            TEST_ASSERT_TRUE(r.locked);
        }
    }
}

static void test_alias_of_the_speed_is_caught(void) {
    // w + 2 pi/Ts turns the sampled EMF alike: only the range tells.
    make_rated(PAPER_OMEGA_RATED);
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    const lode_estimator_tuning_t tuning = tuned(&config);
    for (int n = -2; n <= 2; n++) {
        lode_estimator_t state;
        lode_estimator_reset(&state, &tuning);
        (void)recover(&state, &tuning, LOCK_STEPS);
        state.pll.frame = sincos_of(rated.theta[0]);
        state.pll.omega_rad_s += (float)(n * 2.0 * CHECK_PI / 2.0e-4);
        const recovery_t r = recover(&state, &tuning, LOCK_STEPS);
        TEST_ASSERT_TRUE(r.locked);
        TEST_ASSERT_TRUE(n == 0 || r.flagged);
    }
}

static void test_half_a_turn_off_is_no_rest(void) {
    make_rated(-PAPER_OMEGA_RATED);
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        const lode_estimator_config_t config = designed(both_plls[p]);
        const lode_estimator_tuning_t tuning = tuned(&config);
        lode_estimator_t state;
        lode_estimator_reset(&state, &tuning);
        (void)recover(&state, &tuning, LOCK_STEPS);
        state.pll.frame = sincos_of(rated.theta[0] + CHECK_PI);
        TEST_ASSERT_TRUE(recover(&state, &tuning, LOCK_STEPS).locked);
    }
}

static void test_inputs_that_are_no_numbers_are_flagged(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    const float bad[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX};
    for (int n = 0; n < 4 * COUNT_OF(bad); n++) {
        watch_t w = watch(&config, PAPER_OMEGA_RATED, 0.0);
        for (int k = 0; k < 1000; k++) {
            (void)watch_step(&w, 0.0, 0.0);
        }
        float in[4] = {10.0f, 5.0f, 1.0f, -1.0f};
        in[n % 4] = bad[n / 4];
        const lode_estimate_t e = lode_estimator_step(
            &w.estimator, &w.tuning, (lode_ab_t){in[0], in[1]}, (lode_ab_t){in[2], in[3]});
        TEST_ASSERT_TRUE(e.reseeded);
        TEST_ASSERT_TRUE(is_finite_estimate(&e));
        TEST_ASSERT_TRUE(e.lock < LODE_LOCK_LOST);
        double error = 0.0;
        for (int k = 0; k < 500; k++) {
            error = watch_step(&w, 0.0, 0.0);
        }
        CHECK_NEAR(1.0 * CHECK_DEG, 0.0, error); // there again within 0.1 s
    }
}

static void test_outputs_are_in_range_for_any_input(void) {
    const lode_motor_t motor = paper_motor();
    const float omega_maxima[] = {0.0f, 100.0f}; // the default, and one below a jump of the PLL
    for (int m = 0; m < COUNT_OF(omega_maxima); m++) {
        lode_estimator_config_t config = {.omega_max_rad_s = omega_maxima[m]};
        lode_estimator_design(&config, &motor, PAPER_TS_s);
        const lode_estimator_tuning_t tuning = tuned(&config);
        lode_estimator_t estimator;
        lode_estimator_reset(&estimator, &tuning);
        random_t random = random_seed(9);
        for (int n = 0; n < 200000; n++) {
            // Any bit pattern now and then, plausible in between: so that states build up too.
            const bool wild = random_bits(&random) % 8u == 0u;
            lode_ab_t u = random_vector(&random, 1.0e6);
            lode_ab_t i = random_vector(&random, 1.0e6);
            if (wild) {
                u = (lode_ab_t){random_any(&random), random_any(&random)};
                i = (lode_ab_t){random_any(&random), random_any(&random)};
            }
            const lode_estimate_t e = lode_estimator_step(&estimator, &tuning, u, i);
            TEST_ASSERT_TRUE(is_finite_estimate(&e));
            TEST_ASSERT_TRUE(lode_in_range(e.lock, 0.0f, 1.0f));
            TEST_ASSERT_TRUE(lode_in_range(e.omega_rad_s, -tuning.omega_limit, tuning.omega_limit));
        }
    }
}

// --- Hold, reset, configuration ---------------------------------------------------------------

static void test_hold_takes_the_angle_given(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, 0.0, 0.0);
    for (int k = 0; k < 100; k++) {
        const double theta = remainder(0.02 * k, 2.0 * CHECK_PI);
        lode_estimator_hold(&w.estimator, &w.tuning, lode_sincos((float)theta), 100.0f);
        (void)watch_step(&w, 0.0, 0.0);
        // One period on at 100 rad/s; no EMF to argue with.
        CHECK_NEAR(1.0e-4, 0.0,
                   angle_error(theta + 0.02, (double)lode_estimate_theta_rad(&w.last)));
        CHECK_NEAR(0.1, 100.0, w.last.omega_rad_s);
    }
}

/// At the angle and the speed given, with nothing of a motion before; the lag follows, and the rotor counts as found.
static void test_hold_begins_at_rest_in_its_frame(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    const float omegas[] = {-300.0f, -0.5f, 0.0f, 0.5f, 300.0f};
    for (int n = 0; n < COUNT_OF(omegas); n++) {
        watch_t w = watch(&config, 0.0, 0.0);
        lode_estimator_t *self = &w.estimator;
        self->pll.f_rad_s2 = 500.0f;
        self->pll.rise_rad_s = 5.0f;
        self->per_V = n % 2 == 0 ? 0.25f : -0.25f;
        self->emf.i_A = (lode_ab_t){3.0f, -2.0f};
        const lode_sincos_t rotor = lode_sincos(0.7f);
        lode_estimator_hold(self, &w.tuning, rotor, omegas[n]);
        CHECK_NEAR(1.0e-6, 0.7, lode_estimator_theta_rad(self));
        CHECK_NEAR(0.0, omegas[n], self->pll.omega_rad_s);
        CHECK_NEAR(0.0, omegas[n], self->omega_tune);
        CHECK_NEAR(0.0, 0.0, self->pll.f_rad_s2);
        CHECK_NEAR(0.0, 0.0, self->pll.rise_rad_s);
        CHECK_NEAR(0.0, n < 2 ? 0.25 : -0.25, self->per_V);
        CHECK_NEAR(1.0e-5, 3.0 * cos(0.7) - 2.0 * sin(0.7), self->id_A);
        TEST_ASSERT_EQUAL_UINT(w.tuning.patience_rounds, self->by.alone.wait);
        TEST_ASSERT_EQUAL_UINT(1u, self->found);
    }
}

/// As if it had run at that angle and speed for long, whatever it did before.
static void test_beginning_at_a_speed_is_having_run_there(void) {
    for (int p = 0; p < 2 * (int)LODE_EMF_KINDS; p++) {
        lode_estimator_config_t config = designed(both_plls[p % 2]);
        config.emf.kind = (lode_emf_kind_t)(p / 2);
        const double omegas[] = {-paper_omega(1500.0), paper_omega(300.0), paper_omega(1500.0)};
        for (int n = 0; n < COUNT_OF(omegas); n++) {
            watch_t w = watch(&config, omegas[n], 0.0);
            for (int k = 0; k < 2000; k++) {
                (void)watch_step(&w, 0.0, 0.0);
            }
            watch_t again = w;
            memset(&again.estimator, 0x41, sizeof again.estimator);
            lode_estimator_begin_at(&again.estimator, &w.tuning, lode_estimator_rotor(&w.estimator),
                                    (float)omegas[n]);
            const lode_estimator_t *ran = &w.estimator;
            const lode_estimator_t *begun = &again.estimator;
            const double e_V = (double)lode_ab_length(ran->emf.observer.e_V);
            CHECK_NEAR(0.05 * e_V, ran->emf.observer.e_V.alpha, begun->emf.observer.e_V.alpha);
            CHECK_NEAR(0.05 * e_V, ran->emf.observer.e_V.beta, begun->emf.observer.e_V.beta);
            CHECK_CLOSE(0.05, ran->per_V, begun->per_V);
            CHECK_CLOSE(0.02, ran->gains.theta, begun->gains.theta);
            CHECK_CLOSE(0.02, ran->gains.omega_s, begun->gains.omega_s);
            CHECK_NEAR(0.0, 1.0, begun->lock);
            TEST_ASSERT_TRUE(begun->locked && begun->aligned);
            CHECK_NEAR(0.0, 0.0, begun->id_A);
            for (int k = 0; k < 500; k++) {
                CHECK_NEAR(0.3 * CHECK_DEG, 0.0, watch_step(&again, 0.0, 0.0));
                TEST_ASSERT_TRUE(again.estimator.locked && !again.last.reseeded);
            }
        }
    }
}

/// An amplitude of next to nothing is of a rotor that turns forwards, where none is known to turn back.
static void test_the_amplitude_has_the_sense_of_rotation(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    const float omegas[] = {-0.5f, 0.0f, 0.5f};
    for (int n = 0; n < COUNT_OF(omegas); n++) {
        watch_t w = watch(&config, 0.0, 0.0);
        lode_estimator_begin_at(&w.estimator, &w.tuning, lode_sincos(0.7f), omegas[n]);
        CHECK_CLOSE(1.0e-6, (n == 0 ? 1.0 : -1.0) / (double)config.emin_V, w.estimator.per_V);
    }
}

/// A restart keeps the current, where that is one, and the slot of the slow jobs; all else is as after a reset.
static void test_a_restart_keeps_current_and_slot(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    for (int bad = 0; bad <= 1; bad++) {
        watch_t w = watch(&config, 300.0, 3.0);
        for (int k = 0; k < 1003; k++) {
            (void)watch_step(&w, 0.0, 3.0);
        }
        lode_estimator_t wanted;
        memset(&wanted, 0, sizeof wanted);
        lode_estimator_reset(&wanted, &w.tuning);
        wanted.slot = w.estimator.slot;
        TEST_ASSERT_TRUE(wanted.slot != 0u);
        if (bad == 1) {
            w.estimator.emf.i_A = (lode_ab_t){NAN, 1.0f};
        } else {
            wanted.emf.i_A = w.estimator.emf.i_A;
            wanted.id_A = wanted.emf.i_A.alpha; // at an angle of nothing
        }
        TEST_ASSERT_TRUE(bad == 1 || lode_ab_length(wanted.emf.i_A) > 2.0f);
        lode_estimator_restart(&w.estimator, &w.tuning);
        TEST_ASSERT_EQUAL_MEMORY(&wanted, &w.estimator, sizeof wanted);
    }
}

/// A speed beyond the limit or a rotation that is none, either alone: the look at the lock begins anew. Not so at a
/// speed and a length that a motor may have.
static void test_what_is_no_motion_begins_anew(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    const struct {
        float speed_share, length;
        bool sound;
    } cases[] = {{0.99f, 1.0f, true},      {-0.99f, 1.0f, true},      {1.01f, 1.0f, false},
                 {-1.01f, 1.0f, false},    {(float)NAN, 1.0f, false}, {0.5f, 1.1f, true},
                 {0.5f, 0.9f, true},       {0.5f, 1.13f, false},      {0.5f, 0.85f, false},
                 {0.5f, (float)NAN, false}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        watch_t w = watch(&config, 300.0, 0.0);
        w.estimator.pll.omega_rad_s = cases[n].speed_share * w.tuning.omega_limit;
        w.estimator.pll.frame = (lode_sincos_t){0.6f * cases[n].length, 0.8f * cases[n].length};
        w.estimator.id_A = 1.0f;
        lode_estimator_t begun = w.estimator;
        lode_estimator_restart(&begun, &w.tuning);
        lode_estimator_note_lock(&w.estimator, &w.tuning);
        const bool same = memcmp(&begun, &w.estimator, sizeof begun) == 0;
        TEST_ASSERT_EQUAL_INT(cases[n].sound, !same);
    }
}

/// At rest: amplitude, lag and gains are those of no speed.
static void test_a_reset_is_at_rest(void) {
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        const lode_estimator_config_t config = designed(both_plls[p]);
        const watch_t w = watch(&config, 0.0, 0.0);
        const lode_lag_line_t lag = lode_lag_line(&w.tuning.lag, 0.0f);
        const lode_pll_gains_t gains = lode_pll_gains(&w.tuning.pll, 0.0f);
        CHECK_CLOSE(1.0e-6, -1.0 / (double)config.emin_V, w.estimator.per_V);
        TEST_ASSERT_EQUAL_MEMORY(&lag, &w.estimator.lag, sizeof lag);
        TEST_ASSERT_EQUAL_MEMORY(&gains, &w.estimator.gains, sizeof gains);
    }
}

/// A large error is looked at again without the notches, which had no part in it.
static void test_a_second_look_is_without_the_notches(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, 300.0, 0.0);
    lode_estimator_t *self = &w.estimator;
    memset(&self->by.alone.notch.sogi, 0x41, sizeof self->by.alone.notch.sogi);
    memset(&self->by.alone.notch12.sogi, 0x41, sizeof self->by.alone.notch12.sogi);
    self->emf.observer.e_V = (lode_ab_t){3.0f, 4.0f};
    self->pll.omega_rad_s = 100.0f;
    CHECK_CLOSE(1.0e-6, -0.6,
                lode_estimator_recompute(self, &w.tuning, (lode_sincos_t){0.0f, 1.0f}));
    const lode_sogi_t none = {0.0f, 0.0f};
    TEST_ASSERT_EQUAL_MEMORY(&none, &self->by.alone.notch.sogi, sizeof none);
    TEST_ASSERT_EQUAL_MEMORY(&none, &self->by.alone.notch12.sogi, sizeof none);
}

static void test_hold_at_the_true_angle_is_seamless(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, paper_omega(300.0), 0.0);
    for (int k = 0; k < 2000; k++) {
        (void)watch_step(&w, 0.0, 0.0);
    }
    lode_estimator_hold(&w.estimator, &w.tuning, lode_sincos((float)w.motor.theta),
                        (float)w.motor.omega);
    for (int k = 0; k < 500; k++) {
        CHECK_NEAR(0.1 * CHECK_DEG, 0.0, watch_step(&w, 0.0, 0.0));
    }
}

static void test_a_lock_is_not_believed_before_the_rotor_was_found(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, paper_omega(600.0), 0.0);
    for (int k = 0; k < 2000; k++) {
        (void)watch_step(&w, 0.0, 0.0);
    }
    TEST_ASSERT_TRUE(w.estimator.locked);
    // As after a reset, but for a loop that happens to be where the rotor is.
    w.estimator.found = 0u;
    w.estimator.by.alone.wait = w.tuning.settle_rounds;
    w.reseeded = false;
    for (int k = 0; k < (w.tuning.settle_rounds - 1) * (int)LODE_SLOW_PERIODS; k++) {
        (void)watch_step(&w, 0.0, 0.0);
        TEST_ASSERT_TRUE(w.last.lock > LODE_LOCK_LOST);
        TEST_ASSERT_TRUE(k < (int)LODE_SLOW_PERIODS || !w.estimator.locked);
    }
    TEST_ASSERT_FALSE(w.reseeded);
    for (int k = 0; k < 2 * (int)LODE_SLOW_PERIODS; k++) {
        CHECK_NEAR(1.0 * CHECK_DEG, 0.0, watch_step(&w, 0.0, 0.0));
    }
    TEST_ASSERT_TRUE(w.reseeded && w.estimator.locked);
}

static void test_reset_is_idempotent_and_complete(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, 300.0, 0.0);
    const lode_estimator_t fresh = w.estimator;
    for (int k = 0; k < 1000; k++) {
        (void)watch_step(&w, 0.0, 3.0);
    }
    lode_estimator_reset(&w.estimator, &w.tuning);
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &w.estimator, sizeof fresh);
    lode_estimator_reset(&w.estimator, &w.tuning);
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &w.estimator, sizeof fresh);
}

/// (P16): a torque of less than a free rotor would run away by is that of a free rotor, but where something holds it.
static void test_a_rotor_that_is_held_keeps_its_speed(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, 300.0, 3.0);
    for (int k = 0; k < 4000; k++) {
        (void)watch_step(&w, 0.0, 3.0);
    }
    w.estimator.by.alone.rotation = (lode_ab_t){cosf(0.06f), sinf(0.06f)}; // 300 rad/s
    w.estimator.by.alone.wait = 0u;
    TEST_ASSERT_TRUE(lode_estimator_seed(&w.estimator, &w.tuning, false));
    CHECK_NEAR(0.0, 0.0, w.estimator.pll.f_rad_s2);
    w.estimator.by.alone.wait = 0u;
    TEST_ASSERT_TRUE(lode_estimator_seed(&w.estimator, &w.tuning, true));
    // The currents as seen from the EMF's angle, without the lag of the observer.
    const double friction = (double)w.tuning.acc_per_omega * 300.0;
    CHECK_CLOSE(0.1, friction - 3.0 * 3.0 * 0.639 / 0.0174, w.estimator.pll.f_rad_s2);
}

/// The rotor is looked for once it has waited, or where no waiting was ever so long; the mean rotation goes on, the speed
/// begins without a rise.
static void test_looking_for_the_rotor(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, 300.0, 0.0);
    for (int k = 0; k < 2000; k++) {
        (void)watch_step(&w, 0.0, 0.0);
    }
    lode_estimator_alone_t *alone = &w.estimator.by.alone;
    const uint32_t longest = (uint32_t)w.tuning.settle_rounds + w.tuning.patience_rounds;
    const uint32_t waits[] = {0u, 1u, longest, longest + 1u};
    for (int n = 0; n < COUNT_OF(waits); n++) {
        alone->rotation = (lode_ab_t){cosf(0.06f), sinf(0.06f)};
        alone->wait = (uint_least16_t)waits[n];
        w.estimator.pll.rise_rad_s = 7.0f;
        w.estimator.per_V = 7.0f;
        const bool due = n == 0 || n == 3;
        TEST_ASSERT_EQUAL_INT(due, lode_estimator_seed(&w.estimator, &w.tuning, false));
        CHECK_NEAR(0.0, due ? 0.0 : 7.0, w.estimator.pll.rise_rad_s);
        if (due) { // the size of an error is that of the EMF at hand, with the sign of the rotation
            CHECK_CLOSE(1.0e-5, -1.0 / (double)lode_ab_length(w.estimator.emf.observer.e_V),
                        w.estimator.per_V);
        }
        CHECK_NEAR(0.0, sinf(0.06f), alone->rotation.beta);
    }
}

/// (P24): what a slip makes of the position error, of eight periods; nothing where the rotor drives.
static void test_a_slip_of_a_braked_rotor_is_no_angle(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    for (int sign = -1; sign <= 1; sign += 2) {
        watch_t w = watch(&config, sign * 200.0, -sign * 6.0);
        for (int k = 0; k < 4000; k++) {
            (void)watch_step(&w, -1.0, -sign * 6.0);
        }
        const double share = (3.5e-3 - 9.8e-3) * -sign * 6.0 / (0.142 + (3.5e-3 - 9.8e-3) * -1.0);
        const struct {
            double slip, taken;
        } cases[] = {{0.0, 0.0}, {0.1, 0.1}, {0.8, 0.8}, {1.5, 0.8}};
        for (int n = 0; n < COUNT_OF(cases); n++) {
            lode_estimator_t slipped = w.estimator;
            lode_estimator_brake_slip(&slipped, &w.tuning, 0.2f + (float)cases[n].slip);
            const double error = -8.0 * share * cases[n].taken;
            const lode_sincos_t turned =
                lode_angle_subtract(slipped.pll.frame, w.estimator.pll.frame);
            CHECK_NEAR(2.0e-3, (double)w.estimator.gains.theta * error,
                       (double)lode_atan2(turned.sin, turned.cos));
            CHECK_NEAR(0.05 + 0.01 * fabs((double)w.estimator.gains.omega_s * error),
                       (double)w.estimator.gains.omega_s * error,
                       (double)slipped.pll.omega_rad_s - (double)w.estimator.pll.omega_rad_s);
            CHECK_NEAR(1.0 + 0.01 * fabs((double)w.estimator.gains.f_s2 * error),
                       (double)w.estimator.gains.f_s2 * error,
                       (double)slipped.pll.f_rad_s2 - (double)w.estimator.pll.f_rad_s2);
        }
        // At any speed that induces.
        lode_estimator_t slow = w.estimator;
        slow.pll.omega_rad_s = 2.0f * (float)sign;
        lode_estimator_brake_slip(&slow, &w.tuning, 1.0f);
        TEST_ASSERT_TRUE(lode_abs(slow.pll.omega_rad_s - 2.0f * (float)sign) > 0.1f);
        // However wide the loop, by an eighth of a turn at most.
        lode_estimator_t wide = w.estimator;
        wide.gains.theta = 1.0f;
        wide.gains.omega_s = 100.0f;
        lode_estimator_brake_slip(&wide, &w.tuning, 1.0f);
        const lode_sincos_t most = lode_angle_subtract(wide.pll.frame, w.estimator.pll.frame);
        CHECK_NEAR(1.0e-5, share > 0.0 ? -0.25 * CHECK_PI : 0.25 * CHECK_PI,
                   (double)lode_atan2(most.sin, most.cos));
        TEST_ASSERT_FALSE(lode_lag_is_far(&wide.lag, wide.pll.omega_rad_s)); // follows that speed
        lode_estimator_t driven = w.estimator;
        driven.emf.i_A = (lode_ab_t){-driven.emf.i_A.alpha, -driven.emf.i_A.beta};
        const lode_estimator_t before = driven;
        lode_estimator_brake_slip(&driven, &w.tuning, 1.0f);
        TEST_ASSERT_EQUAL_MEMORY(&before, &driven, sizeof before);
    }
}

/// (P35): the speed is at most 1.2 times what the EMF shows, but not below that of the frame.
static void test_the_emf_bounds_the_speed(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    for (int sign = -1; sign <= 1; sign += 2) {
        watch_t w = watch(&config, sign * 200.0, 0.0);
        for (int k = 0; k < 4000; k++) {
            (void)watch_step(&w, 0.0, 0.0);
        }
        w.tuning.acc_most = 1.0e6f;
        const double per_rad = (double)(w.estimator.gains.theta * w.tuning.pll.inv_ts);
        const struct {
            double omega, slip, behind_rad, bound;
        } cases[] = {
            {200.0, 0.3, 0.4, 200.0 * 1.2 / 1.3},
            {200.0, 0.5, 0.4, 200.0 * 1.2 / 1.5},
            {200.0, 1.0, 0.2, 200.0 - per_rad * sin(0.2)},
            {200.0, 1.0, asin(34.0 / per_rad), 166.0}, // a sixth behind
            {200.0, 1.0, asin(33.0 / per_rad), 200.0},
            {200.0, 0.5, -0.05, 200.0}, // the rotor is ahead
            {200.0, 0.5, 0.47, 200.0},  // beyond 25 degrees the angle is not known
            {200.0, 1.0e3, 0.44, 200.0 - per_rad * sin(0.44)},
            {20.0, 1.0e3, 0.44, 0.024}, // the frame turns backwards
        };
        for (int n = 0; n < COUNT_OF(cases); n++) {
            const float slip = (float)cases[n].slip;
            const float turn_rad = (float)sign * (float)cases[n].behind_rad;
            lode_estimator_t before = w.estimator;
            before.pll.omega_rad_s = (float)(sign * cases[n].omega);
            before.omega_noted = 0.5f * (float)sign;
            before.pll.frame = lode_angle_add(before.pll.frame, lode_sincos(turn_rad));
            lode_estimator_t slipped = before;
            lode_estimator_limit_slip(&slipped, &w.tuning, slip);
            const double omega = sign * (double)slipped.pll.omega_rad_s;
            CHECK_NEAR(0.005 * cases[n].omega, cases[n].bound, omega);
            // (P30) counts from there
            CHECK_NEAR(1.0e-3, omega - cases[n].omega + 0.5, sign * (double)slipped.omega_noted);
            TEST_ASSERT_TRUE(omega >= cases[n].omega ||
                             !lode_lag_is_far(&slipped.lag, slipped.pll.omega_rad_s));
            lode_estimator_t unnoted = before;
            unnoted.omega_noted = 0.0f;
            lode_estimator_limit_slip(&unnoted, &w.tuning, slip);
            TEST_ASSERT_EQUAL_FLOAT(0.0f, unnoted.omega_noted);
            lode_estimator_tuning_t heavy = w.tuning;
            heavy.acc_most = 1.0f / (8.0f * heavy.pll.ts_s);
            lode_estimator_t slow = before;
            lode_estimator_limit_slip(&slow, &heavy, slip);
            CHECK_NEAR(1.0e-3, fmax(omega, cases[n].omega - 1.0),
                       sign * (double)slow.pll.omega_rad_s);
            lode_estimator_t lost = before;
            lost.locked = false;
            lode_estimator_limit_slip(&lost, &w.tuning, slip);
            before.locked = false;
            TEST_ASSERT_EQUAL_MEMORY(&before, &lost, sizeof before);
        }
    }
}

/// The same in the loop: the current is held in the estimator's frame, which slips over a rotor that slows down by more
/// than its torque alone. Without (P24) 24 to 58 degrees.
static void test_a_braked_rotor_that_slows_down_more_than_expected(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    for (int n = 0; n < 6; n++) {
        const double sign = n % 2 == 0 ? 1.0 : -1.0;
        const double acc = 5000.0 + 2000.0 * (double)(n / 2);
        watch_t w = watch(&config, sign * 250.0, 0.0);
        for (int k = 0; k < 2000; k++) {
            (void)watch_step(&w, 0.0, 0.0);
        }
        double error = 0.0;
        worst_t worst = {0.0};
        for (int k = 0; sign * w.motor.omega > 100.0; k++) {
            const double iq = -sign * 11.0 * fmin((double)k / 10.0, 1.0);
            w.motor.acc = -sign * acc;
            error = watch_step(&w, -iq * sin(error), iq * cos(error));
            worst_note(&worst, error);
        }
        CHECK_AT_MOST(16.0 * CHECK_DEG, worst.value);
    }
}

static void test_a_mean_rotation_that_is_no_number_begins_anew(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    watch_t w = watch(&config, 300.0, 0.0);
    w.estimator.by.alone.rotation = (lode_ab_t){NAN, NAN};
    w.estimator.by.alone.wait = 0u; // it has waited for long enough
    TEST_ASSERT_FALSE(lode_estimator_seed(&w.estimator, &w.tuning, false));
    CHECK_NEAR(0.0, 0.0, w.estimator.by.alone.rotation.alpha);
    CHECK_NEAR(0.0, 0.0, w.estimator.by.alone.rotation.beta);
}

static lode_status_t try_config(const lode_estimator_config_t *config, const lode_motor_t *motor) {
    lode_estimator_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_estimator_tuning_t before = tuning;
    const lode_status_t status = lode_estimator_tune(&tuning, config, motor, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_estimator_config_t config = designed(LODE_PLL_LESO);
    field_set(&config, offset, value);
    const lode_motor_t motor = paper_motor();
    return try_config(&config, &motor);
}

/// What a period is asked for, and no more of it: each costs it some time.
static void test_what_is_asked_of_a_period(void) {
    static const struct {
        float salient_H, w_filter_rad_s, notch_k, notch12_k;
        lode_pll_kind_t kind;
        int options;
    } cases[] = {
        {0.0f, 0.0f, 0.0f, 0.0f, LODE_PLL_QPLL, 0},
        {1.0e-5f, 0.0f, 0.0f, 0.0f, LODE_PLL_QPLL, LODE_ESTIMATOR_SALIENT},
        {-1.0e-5f, 0.0f, 0.0f, 0.0f, LODE_PLL_QPLL, LODE_ESTIMATOR_SALIENT},
        {0.0f, 100.0f, 0.0f, 0.0f, LODE_PLL_QPLL, LODE_ESTIMATOR_FILTERED},
        {0.0f, 0.5f, 0.0f, 0.0f, LODE_PLL_QPLL, LODE_ESTIMATOR_FILTERED},
        {0.0f, 0.0f, 0.1f, 0.0f, LODE_PLL_QPLL, LODE_ESTIMATOR_NOTCH},
        {0.0f, 0.0f, 0.0f, 0.1f, LODE_PLL_QPLL, LODE_ESTIMATOR_NOTCH | LODE_ESTIMATOR_NOTCH12},
        {0.0f, 0.0f, 0.0f, 0.0f, LODE_PLL_LESO, LODE_ESTIMATOR_THIRD_ORDER},
    };
    for (int n = 0; n < COUNT_OF(cases); n++) {
        lode_motor_t motor = paper_motor();
        motor.Lq_H = motor.Ld_H + cases[n].salient_H;
        lode_estimator_config_t config = {.pll.kind = cases[n].kind};
        lode_estimator_design(&config, &motor, PAPER_TS_s);
        config.w_filter_rad_s = cases[n].w_filter_rad_s;
        config.notch_k = cases[n].notch_k;
        config.notch12_k = cases[n].notch12_k;
        lode_estimator_tuning_t tuning;
        TEST_ASSERT_EQUAL_STRING(
            "LODE_OK", lode_status_name(lode_estimator_tune(&tuning, &config, &motor, PAPER_TS_s)));
        TEST_ASSERT_EQUAL_UINT32((uint32_t)cases[n].options, tuning.options);
        CHECK_CLOSE(1.0e-6, 2.0 * (double)config.omega_max_rad_s, tuning.omega_limit);
        const bool predicts = cases[n].kind == LODE_PLL_LESO; // a QPLL knows no acceleration
        TEST_ASSERT_EQUAL_INT(predicts, lode_abs(tuning.acc_per_torque) > 0.0f);
        TEST_ASSERT_EQUAL_INT(predicts, lode_abs(tuning.acc_per_omega) > 0.0f);
        TEST_ASSERT_EQUAL_INT(predicts, lode_abs(tuning.load_per_f_Nm) > 0.0f);
    }
}

/// After a reset the rotor is looked for once the observer has settled, eight of its time constants, and the mean
/// rotation, three; a try has the time of the lock. A round more at most.
static void test_times_of_waiting(void) {
    static const float locks_s[] = {PAPER_TS_s, 0.02f};
    const lode_motor_t motor = paper_motor();
    for (int n = 0; n < COUNT_OF(locks_s); n++) {
        lode_estimator_config_t config = designed(LODE_PLL_LESO);
        config.lock_s = locks_s[n];
        lode_estimator_tuning_t tuning;
        TEST_ASSERT_EQUAL_STRING(
            "LODE_OK", lode_status_name(lode_estimator_tune(&tuning, &config, &motor, PAPER_TS_s)));
        const double round_s = (double)LODE_SLOW_PERIODS * (double)PAPER_TS_s;
        const double settle_s =
            fmax(8.0 / (double)config.emf.w0_rad_s, 3.0 * (double)config.lock_s);
        CHECK_NEAR(0.5, settle_s / round_s + 0.5, tuning.settle_rounds);
        CHECK_NEAR(0.5, (double)config.lock_s / round_s + 0.5, tuning.patience_rounds);
        lode_estimator_t self;
        lode_estimator_reset(&self, &tuning);
        TEST_ASSERT_EQUAL_UINT(tuning.settle_rounds, self.by.alone.wait);
    }
}

/// Where injection ends the rotor has been found, and the EMF has the time of a try to be of use.
static void test_after_injection_the_rotor_is_known(void) {
    const lode_motor_t motor = paper_motor();
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    lode_estimator_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_estimator_tune(&tuning, &config, &motor, PAPER_TS_s));
    lode_estimator_t self;
    lode_estimator_reset(&self, &tuning);
    self.by.hfi.active = true;
    self.by.hfi.step = (uint_least8_t)LODE_HFI_RIGHT;
    self.found = 0u;
    lode_estimator_end_injection(&self, &tuning);
    TEST_ASSERT_FALSE(lode_estimator_injects(&self));
    TEST_ASSERT_EQUAL_UINT(1u, self.found);
    TEST_ASSERT_EQUAL_UINT(tuning.patience_rounds, self.by.alone.wait);
    TEST_ASSERT_EQUAL_UINT(LODE_HFI_RIGHT, self.by.alone.step);
    CHECK_NEAR(0.0, 0.0, self.by.alone.reserve_V);
}

static void test_every_field_at_its_limits(void) {
    static const field_t fields[] = {
        {FIELD(lode_estimator_config_t, emin_V), .lo = 1.0e-4f, .hi = 1.0e3f,
         .error = LODE_ERROR_EMIN},
        {FIELD(lode_estimator_config_t, omega_max_rad_s), .lo = 1.0f, .hi = 2500.0f,
         .computed = true, .coupled = true, .error = LODE_ERROR_OMEGA_MAX}, // 0.5/Ts
        {FIELD(lode_estimator_config_t, lock_s), .lo = PAPER_TS_s, .hi = 1.0f,
         .error = LODE_ERROR_LOCK_TIME},
    };
    field_check(&fields[0], try_one);
    field_check(&fields[2], try_one);
    const float bad[] = {0.9f, 2510.0f, -100.0f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        field_refused(&fields[1], try_one, bad[i]);
    }
    field_accepted(&fields[1], try_one, 1.0f);
    field_accepted(&fields[1], try_one, 2499.0f);
}

static void test_errors_of_the_parts_come_through(void) {
    const lode_motor_t motor = paper_motor();
    lode_estimator_config_t config = designed(LODE_PLL_LESO);
    config.emf.w0_rad_s = 0.5f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_EMF_W0, try_config(&config, &motor));
    config = designed(LODE_PLL_LESO);
    config.pll.sigma_rad_s = NAN;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_SIGMA, try_config(&config, &motor));
    config = designed(LODE_PLL_LESO);
    config.compensation = (lode_lag_kind_t)5;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_LAG, try_config(&config, &motor));
    config = designed(LODE_PLL_LESO);
    config.active_flux = (lode_choice_t)7;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, try_config(&config, &motor));
    config = designed(LODE_PLL_LESO);
    config.pll.sigma_rad_s = 0.5f * config.emf.w0_rad_s;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_OBSERVER, try_config(&config, &motor));
    lode_motor_t bad = motor;
    bad.psi_Wb = 0.0f;
    config = designed(LODE_PLL_LESO);
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_PSI, try_config(&config, &bad));
}

static void test_design_fills_what_is_open(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    CHECK_CLOSE(1.0e-5, 0.03 * PAPER_OMEGA_RATED * 0.142, config.emin_V); // 2 V
    CHECK_CLOSE(1.0e-5, 2.5 * PAPER_OMEGA_RATED, config.omega_max_rad_s);
    CHECK_CLOSE(1.0e-6, 5.0e-3, config.lock_s);
    TEST_ASSERT_EQUAL_INT(LODE_ON, config.active_flux);
    const lode_motor_t motor = paper_motor();
    lode_estimator_config_t kept = config;
    lode_estimator_design(&kept, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_MEMORY(&config, &kept, sizeof config);
}

/// An error of the angle changes the torque as the same currents seen from a frame that is off by it do; what would
/// swing up is left out.
static void test_the_torque_swings_with_the_error(void) {
    const lode_estimator_config_t config = designed(LODE_PLL_LESO);
    const lode_estimator_tuning_t tuning = tuned(&config);
    const double error = 0.01;
    const double ids[] = {-4.0, -1.0, 3.0};
    for (int n = 0; n < COUNT_OF(ids); n++) {
        const double id = ids[n];
        const double iq = 3.0;
        const lode_dq_t i_A = {(float)id, (float)iq};
        const lode_dq_t off_A = {(float)(id * cos(error) + iq * sin(error)),
                                 (float)(iq * cos(error) - id * sin(error))};
        const double sound = (double)lode_estimator_acceleration(&tuning, i_A, 0.0f, 100.0f);
        const double seen = (double)lode_estimator_acceleration(&tuning, off_A, 0.0f, 100.0f);
        const double by_error =
            (double)lode_estimator_acceleration(&tuning, i_A, (float)error, 100.0f);
        CHECK_NEAR(0.05 * fabs(seen - sound), seen > sound ? seen - sound : 0.0, by_error - sound);
    }
}

/// A lock forgets what an acquisition would go by, and a loop of second order the disturbance that it has none of.
static void test_what_has_no_use_is_forgotten(void) {
    for (int p = 0; p < COUNT_OF(both_plls); p++) {
        const lode_estimator_config_t config = designed(both_plls[p]);
        watch_t w = watch(&config, 300.0, 0.0);
        for (int k = 0; k < 4000; k++) {
            (void)watch_step(&w, 0.0, 0.0);
        }
        TEST_ASSERT_TRUE(w.estimator.locked);
        w.estimator.by.alone.rotation = (lode_ab_t){1.0f, 2.0f};
        w.estimator.by.alone.before_V = (lode_ab_t){3.0f, 4.0f};
        lode_estimator_note_lock(&w.estimator, &w.tuning);
        CHECK_NEAR(0.0, 0.0, lode_ab_length(w.estimator.by.alone.rotation));
        CHECK_NEAR(0.0, 0.0, lode_ab_length(w.estimator.by.alone.before_V));
        w.estimator.pll.f_rad_s2 = w.estimator.pll.rise_rad_s = 0.25f;
        lode_estimator_adapt_gains(&w.estimator, &w.tuning);
        const double left = both_plls[p] == LODE_PLL_QPLL ? 0.0 : 0.25;
        CHECK_NEAR(0.0, left, w.estimator.pll.f_rad_s2);
        CHECK_NEAR(0.0, left, w.estimator.pll.rise_rad_s);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_steady_angle_open_loop);
    RUN_TEST(test_paper_settings);
    RUN_TEST(test_without_compensation_the_angle_lags_as_computed);
    RUN_TEST(test_acquisition_from_reset_takes_milliseconds);
    RUN_TEST(test_acquisition_under_load_of_a_light_rotor);
    RUN_TEST(test_the_EMF_beyond_that_of_the_magnets);
    RUN_TEST(test_sound_running_keeps_its_lock_at_all_speeds);
    RUN_TEST(test_standstill_is_no_lock);
    RUN_TEST(test_ramps_and_load_steps);
    RUN_TEST(test_changing_id_does_not_turn_the_angle);
    RUN_TEST(test_recordings_of_an_independent_simulator);
    RUN_TEST(test_reconvergence_from_1000_random_states);
    RUN_TEST(test_any_state_is_detected_flagged_and_relocked);
    RUN_TEST(test_what_is_derived_is_renewed);
    RUN_TEST(test_alias_of_the_speed_is_caught);
    RUN_TEST(test_half_a_turn_off_is_no_rest);
    RUN_TEST(test_inputs_that_are_no_numbers_are_flagged);
    RUN_TEST(test_outputs_are_in_range_for_any_input);
    RUN_TEST(test_hold_takes_the_angle_given);
    RUN_TEST(test_hold_begins_at_rest_in_its_frame);
    RUN_TEST(test_beginning_at_a_speed_is_having_run_there);
    RUN_TEST(test_the_amplitude_has_the_sense_of_rotation);
    RUN_TEST(test_a_restart_keeps_current_and_slot);
    RUN_TEST(test_what_is_no_motion_begins_anew);
    RUN_TEST(test_a_reset_is_at_rest);
    RUN_TEST(test_a_second_look_is_without_the_notches);
    RUN_TEST(test_looking_for_the_rotor);
    RUN_TEST(test_hold_at_the_true_angle_is_seamless);
    RUN_TEST(test_a_lock_is_not_believed_before_the_rotor_was_found);
    RUN_TEST(test_reset_is_idempotent_and_complete);
    RUN_TEST(test_a_rotor_that_is_held_keeps_its_speed);
    RUN_TEST(test_a_slip_of_a_braked_rotor_is_no_angle);
    RUN_TEST(test_the_emf_bounds_the_speed);
    RUN_TEST(test_a_braked_rotor_that_slows_down_more_than_expected);
    RUN_TEST(test_a_mean_rotation_that_is_no_number_begins_anew);
    RUN_TEST(test_what_is_asked_of_a_period);
    RUN_TEST(test_times_of_waiting);
    RUN_TEST(test_after_injection_the_rotor_is_known);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_errors_of_the_parts_come_through);
    RUN_TEST(test_design_fills_what_is_open);
    RUN_TEST(test_the_torque_swings_with_the_error);
    RUN_TEST(test_what_has_no_use_is_forgotten);
    return UNITY_END();
}
