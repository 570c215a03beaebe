/// The papers' own forms against closed forms and against figures computed by others (docs/papers.md).
#include "rig/euler.h"

#include "support/check.h"

void setUp(void) {}

void tearDown(void) {}

#define TS 2.0e-4

static euler_config_t config_of(euler_emf_t emf, euler_pll_t pll) {
    return (euler_config_t){
        .emf = emf,
        .pll = pll,
        .ts_s = TS,
        .pole_pairs = 3.0,
        .Rs_Ohm = 0.75,
        .Ld_H = 3.5e-3,
        .Lq_H = 9.8e-3,
        .psi_Wb = 0.142,
        .J_kgm2 = 0.0174,
        .B_Nms = 7.5e-4,
        .w0_rad_s = 2000.0,
        .gi_Kr = 2.0 * 2000.0 * 2000.0,
        .gi_wc_rad_s = CHECK_PI,
        .k1_rad2_s2 = 10.0 * CHECK_PI,
        .k2_rad_s = 100.0 * CHECK_PI,
        .sigma_rad_s = 150.0,
        .notch_k = 0.5,
    };
}

static double degrees(double rad) {
    return rad / CHECK_DEG;
}

/// The EMF of psi = 1 Vs at the angle given.
static double complex emf_at(double omega, double angle) {
    return I * omega * cexp(I * angle);
}

/// Rotation at constant speed with the current I cexp(j(angle + quarter turn)), the voltage held over each
/// period, the R-Lq circuit solved exactly. Returns the phase of the observed EMF behind the true one.
static double observed_lag(const euler_config_t *config, double omega, double current_A,
                           int periods) {
    const double mu = config->Rs_Ohm / config->Lq_H;
    const double a = exp(-mu * TS);
    const double b = mu > 0.0 ? (1.0 - a) / config->Rs_Ohm : TS / config->Lq_H;
    const double complex rho = cexp(I * omega * TS);
    // What the EMF of one period, exp(j w s), does to the current at its end.
    const double complex drive = (rho - a) / (config->Lq_H * (mu + I * omega));
    euler_t self;
    double lag = NAN;
    double complex i_A = I * current_A;
    euler_reset(&self, i_A);
    for (int k = 0; k < periods; ++k) {
        const double angle = omega * TS * k;
        const double complex next_A = i_A * rho;
        const double complex u_V =
            (next_A - a * i_A + config->psi_Wb * emf_at(omega, angle) * drive) / b;
        euler_hold(&self, config, 0.0, omega); // adaptive ones are tuned to it
        const euler_out_t out = euler_step(&self, config, u_V, next_A);
        i_A = next_A;
        lag = angle_error(carg(emf_at(omega, angle + omega * TS)), carg(out.e_V));
    }
    return lag;
}

static void test_lag_of_the_conventional_observer_as_computed_by_others(void) {
    static const double rpm[] = {100.0, 300.0, 900.0, 1500.0, 3000.0};
    static const double lag_deg[] = {1.619, 4.857, 14.524, 24.058, 46.811};
    static const double eq30_deg[] = {1.800, 5.396, 16.093, 26.516, 50.463};
    const euler_config_t config = config_of(EULER_C_LESO, EULER_QPLL);
    for (int k = 0; k < COUNT_OF(rpm); ++k) {
        // Those figures hold with the resistance in the plant, worth some hundredths of a degree.
        CHECK_NEAR(0.02, lag_deg[k], degrees(euler_lag_rad(&config, paper_omega(rpm[k]))));
        CHECK_NEAR(0.001, eq30_deg[k], degrees(euler_eq30_rad(2000.0, paper_omega(rpm[k]))));
        CHECK_NEAR(1e-12, -euler_lag_rad(&config, paper_omega(rpm[k])),
                   euler_lag_rad(&config, -paper_omega(rpm[k])));
    }
    CHECK_NEAR(1e-12, 0.0, euler_lag_rad(&config, 0.0));
    // Beyond w0 the arc tangent of eq. 30 would jump by half a turn.
    CHECK_NEAR(1e-9, 2.0 * atan(1.5), euler_eq30_rad(2000.0, 3000.0));
}

static void test_every_observer_lags_as_its_closed_form(void) {
    static const euler_emf_t emf[] = {EULER_C_LESO, EULER_GI_LESO, EULER_FA_LESO};
    static const double omega[] = {60.0, 300.0, 471.0, 900.0, -300.0};
    for (int e = 0; e < COUNT_OF(emf); ++e) {
        for (int k = 0; k < COUNT_OF(omega); ++k) {
            euler_config_t config = config_of(emf[e], EULER_QPLL);
            config.Rs_Ohm = 0.0;
            config.k1_rad2_s2 = e == 2 && k == 1 ? 5000.0 : 0.0;
            const double lag = observed_lag(&config, omega[k], 0.0, 60000);
            CHECK_NEAR(1e-5, euler_lag_rad(&config, omega[k]), lag);
        }
    }
}

static void test_continuous_time_lags_as_the_printed_transfer_functions(void) {
    static const double omega[] = {94.0, 283.0, 471.0};
    for (int k = 0; k < COUNT_OF(omega); ++k) {
        euler_config_t config = config_of(EULER_C_LESO, EULER_QPLL);
        config.continuous = true;
        config.sigma_rad_s = 0.0; // the observers are tuned to w, not to what a PLL makes of it
        // What is left comes from the current's bend between samples: far less than the half period,
        // w Ts/2, that forward Euler adds.
        const double bend = omega[k] * TS / 40.0;
        // Paper 1, eq. 29.
        CHECK_NEAR(bend, euler_eq30_rad(2000.0, omega[k]),
                   observed_lag(&config, omega[k], 7.8, 6000));
        config.emf = EULER_FA_LESO; // paper 2, eq. 26: none at its own speed
        config.k1_rad2_s2 = 0.0;    // whose pole takes half a minute
        CHECK_NEAR(bend, 0.0, observed_lag(&config, omega[k], 7.8, 6000));
        config.emf = EULER_GI_LESO; // paper 2, eq. 29, with G = Kr there
        const double n = config.gi_Kr + config.w0_rad_s * config.w0_rad_s;
        const double lag = atan2(2.0 * config.w0_rad_s * omega[k], n - omega[k] * omega[k]);
        CHECK_NEAR(bend, lag, observed_lag(&config, omega[k], 7.8, 60000));
    }
}

static void test_continuous_time_locks_to_a_turning_rotor(void) {
    static const euler_pll_t plls[] = {EULER_QPLL, EULER_LESO_QPLL, EULER_ENHANCED};
    const double omega = 471.0;
    for (int p = 0; p < COUNT_OF(plls); ++p) {
        euler_config_t config = config_of(EULER_C_LESO, plls[p]);
        config.continuous = true;
        config.compensation = EULER_LAG_EQ30;
        euler_t self;
        euler_out_t out = {.theta_rad = 0.0};
        euler_reset(&self, 0.0);
        euler_hold(&self, &config, 0.1, omega);
        const double complex mean = (cexp(I * omega * TS) - 1.0) / (I * omega * TS);
        for (int k = 0; k < 8000; ++k) {
            out = euler_step(&self, &config, config.psi_Wb * emf_at(omega, omega * TS * k) * mean,
                             0.0);
        }
        CHECK_NEAR(2e-4, 0.0, angle_error(out.theta_rad, omega * TS * 8000));
        CHECK_NEAR(0.05, omega, out.omega_rad_s);
    }
}

static void test_resistance_is_taken_half_a_period_late(void) {
    euler_config_t config = config_of(EULER_C_LESO, EULER_QPLL);
    const double lag = observed_lag(&config, paper_omega(1500.0), 7.8, 4000);
    const double without = observed_lag(&config, paper_omega(1500.0), 0.0, 4000);
    CHECK_NEAR(0.01, -degrees(0.5 * config.Rs_Ohm * 7.8 * TS / config.psi_Wb),
               degrees(lag - without));
}

static double growth_of_adaptive(double f_Hz) {
    euler_config_t config = config_of(EULER_FA_LESO, EULER_QPLL);
    config.Rs_Ohm = 0.0;
    config.k1_rad2_s2 = 0.0;
    const double omega = 2.0 * CHECK_PI * f_Hz;
    euler_t self;
    euler_reset(&self, 1.0); // a current error to begin with, and no EMF
    double complex e_V = 0.0;
    for (int k = 0; k < 20000; ++k) {
        euler_hold(&self, &config, 0.0, omega);
        e_V = euler_step(&self, &config, 0.0, 0.0).e_V;
    }
    return cabs(e_V);
}

/// fe = sqrt(2 k2 fs - k2^2)/2 pi: 278 Hz at 5 kHz with k2 = 100 pi.
static void test_adaptive_observer_is_unstable_above_278_Hz(void) {
    CHECK_AT_MOST(1e-3, growth_of_adaptive(273.0));
    CHECK_AT_LEAST(1e3, growth_of_adaptive(283.0));
}

typedef struct {
    double mean, size, span, omega, f;
} tracked_t;

/// The PLL alone for 1.5 s on an angle that moves with the speed and acceleration given; `fifth`: a harmonic
/// of the EMF, which turns backwards. `current_A`: on the q axis. Figures of the last 0.2 s.
static tracked_t track(const euler_config_t *config, double omega, double acceleration,
                       double fifth, double current_A) {
    euler_t self;
    double least = INFINITY, most = -INFINITY, sum = 0.0;
    tracked_t out = {0};
    euler_reset(&self, 0.0);
    euler_hold(&self, config, 0.1 - omega * TS, omega);
    for (int k = 0; k < 7500; ++k) {
        const double t = k * TS;
        const double angle = omega * t + 0.5 * acceleration * t * t;
        const double complex e_V = I * cexp(I * angle) + I * fifth * cexp(-5.0 * I * angle);
        self.i_A = I * current_A * cexp(I * angle);
        const euler_out_t now = euler_track(&self, config, e_V * omega);
        const double error = angle_error(now.theta_rad, angle);
        if (k >= 6500) {
            least = fmin(least, error);
            most = fmax(most, error);
            sum += error;
            out.size += fabs(error) / 1000.0;
        }
        out.omega = now.omega_rad_s - (omega + acceleration * t);
        out.f = now.f_rad_s2;
    }
    out.mean = sum / 1000.0;
    out.span = most - least;
    return out;
}

static void test_qpll_lags_behind_a_ramp_by_table_1(void) {
    euler_config_t config = config_of(EULER_C_LESO, EULER_QPLL);
    CHECK_NEAR(1e-6, 0.0, track(&config, 100.0, 0.0, 0.0, 0.0).mean);
    CHECK_NEAR(1e-6, -200.0 / (150.0 * 150.0), track(&config, 100.0, 200.0, 0.0, 0.0).mean);
    // The integral part runs behind by 2 sigma times that angle: what the PI controller adds.
    CHECK_NEAR(0.05, -2.0 * 200.0 / 150.0, track(&config, 100.0, 200.0, 0.0, 0.0).omega);
    config.speed_of_eq14 = true;
    CHECK_NEAR(0.05, 0.0, track(&config, 100.0, 200.0, 0.0, 0.0).omega);
}

static void test_leso_qpll_follows_a_ramp(void) {
    const euler_config_t config = config_of(EULER_C_LESO, EULER_LESO_QPLL);
    const tracked_t unknown = track(&config, 100.0, 200.0, 0.0, 0.0);
    CHECK_NEAR(1e-5, 0.0, unknown.mean);
    // The disturbance takes what is not known; friction B/J w is.
    CHECK_NEAR(1.0, 200.0 + 7.5e-4 / 0.0174 * 400.0, unknown.f);
    // 200 rad/s^2 of torque and friction: nothing is left for it.
    const double current_A = (200.0 + 7.5e-4 / 0.0174 * 400.0) * 0.0174 / (3.0 * 1.5 * 3.0 * 0.142);
    CHECK_NEAR(1.0, 0.0, track(&config, 100.0, 200.0, 0.0, current_A).f);
}

/// The notch takes the ripple at 6 w; what is left comes from its centre, 0.6 % off at 900 rpm.
static void test_notch_removes_the_sixth_harmonic(void) {
    euler_config_t config = config_of(EULER_C_LESO, EULER_LESO_QPLL);
    const double plain = track(&config, paper_omega(900.0), 0.0, 0.05, 0.0).span;
    config.pll = EULER_ENHANCED;
    const double enhanced = track(&config, paper_omega(900.0), 0.0, 0.05, 0.0).span;
    CHECK_AT_LEAST(0.02, plain);
    CHECK_AT_MOST(0.05 * plain, enhanced);
    CHECK_NEAR(1e-6, 0.0, track(&config, paper_omega(900.0), 0.0, 0.0, 0.0).mean);
}

/// Without the sign of speed in eq. 13.
static void test_backwards_it_locks_half_a_turn_off(void) {
    const euler_config_t config = config_of(EULER_C_LESO, EULER_QPLL);
    CHECK_NEAR(1e-6, CHECK_PI, track(&config, -100.0, 0.0, 0.0, 0.0).size);
}

static void test_compensation_is_added_to_the_angle_only(void) {
    static const euler_lag_t kinds[] = {EULER_LAG_NONE, EULER_LAG_EQ30, EULER_LAG_EXACT};
    const double omega = paper_omega(900.0);
    euler_config_t config = config_of(EULER_C_LESO, EULER_LESO_QPLL);
    const double wanted[] = {0.0, euler_eq30_rad(2000.0, omega), euler_lag_rad(&config, omega)};
    for (int k = 0; k < COUNT_OF(kinds); ++k) {
        config.compensation = kinds[k];
        const tracked_t out = track(&config, omega, 0.0, 0.0, 0.0);
        CHECK_NEAR(1e-6, wanted[k], out.mean);
        CHECK_NEAR(1e-3, 0.0, out.omega);
    }
}

static void test_hold_gives_the_angle_back(void) {
    euler_config_t config = config_of(EULER_C_LESO, EULER_ENHANCED);
    config.compensation = EULER_LAG_EQ30;
    euler_t self;
    euler_reset(&self, 0.0);
    euler_hold(&self, &config, 1.0, 200.0);
    const euler_out_t out = euler_track(&self, &config, 0.0);
    CHECK_NEAR(1e-9, 1.0 + 200.0 * TS, out.theta_rad);
    CHECK_NEAR(1e-9, 200.0, out.omega_rad_s);
}

static void test_acquires_from_the_emf(void) {
    const euler_config_t config = config_of(EULER_C_LESO, EULER_QPLL);
    euler_t self;
    euler_reset(&self, 0.0);
    for (int k = 0; k < 200; ++k) {
        (void)euler_track(&self, &config, emf_at(300.0, 300.0 * TS * k));
    }
    euler_acquire(&self, &config);
    const euler_out_t out = euler_track(&self, &config, emf_at(300.0, 300.0 * TS * 200.0));
    CHECK_NEAR(1e-6, 0.0, angle_error(out.theta_rad, 300.0 * TS * 200.0));
    CHECK_NEAR(0.1, 300.0, out.omega_rad_s);
}

static void test_without_emf_it_coasts(void) {
    const euler_config_t config = config_of(EULER_GI_LESO, EULER_ENHANCED);
    euler_t self;
    euler_reset(&self, 0.0);
    euler_out_t out = {0};
    for (int k = 0; k < 100; ++k) {
        out = euler_step(&self, &config, 0.0, 0.0);
    }
    CHECK_NEAR(1e-12, 0.0, out.theta_rad);
    CHECK_NEAR(1e-12, 0.0, out.omega_rad_s);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_lag_of_the_conventional_observer_as_computed_by_others);
    RUN_TEST(test_every_observer_lags_as_its_closed_form);
    RUN_TEST(test_continuous_time_lags_as_the_printed_transfer_functions);
    RUN_TEST(test_continuous_time_locks_to_a_turning_rotor);
    RUN_TEST(test_resistance_is_taken_half_a_period_late);
    RUN_TEST(test_adaptive_observer_is_unstable_above_278_Hz);
    RUN_TEST(test_qpll_lags_behind_a_ramp_by_table_1);
    RUN_TEST(test_leso_qpll_follows_a_ramp);
    RUN_TEST(test_notch_removes_the_sixth_harmonic);
    RUN_TEST(test_backwards_it_locks_half_a_turn_off);
    RUN_TEST(test_compensation_is_added_to_the_angle_only);
    RUN_TEST(test_hold_gives_the_angle_back);
    RUN_TEST(test_acquires_from_the_emf);
    RUN_TEST(test_without_emf_it_coasts);
    return UNITY_END();
}
