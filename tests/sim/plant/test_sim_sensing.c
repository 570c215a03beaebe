// Ways to measure the currents, each with what it cannot see, in front of the switching inverter: three and
// two low-side shunts, sensors in the phases, one shunt in the DC link.
#include "modulator_inline.h"
#include "plant/plant.h"
#include "sense_inline.h"
#include "support/check.h"

#include "lodestar/single_shunt.h"

#define F_PWM 20000.0
#define T_s (1.0 / F_PWM)
#define V_BUS 24.0
#define GAIN_A (1.0 / 128.0)
#define DEAD_s 0.5e-6
#define DEAD_MOST_s (1.2 * DEAD_s) // that a start may measure
#define SETTLE_s 3.0e-6            // of a shunt's amplifier, dead time included
#define SAMPLE_s 0.3e-6
#define CONVERT_s 2.0e-6 // from t_k to the end of the last low-side sample
#define ROUNDING_s 1.0e-9
#define DUTY_MAX (1.0 - 2.0 * SETTLE_s * F_PWM)
#define NO_CURRENT 2048u

typedef enum { LOW_THREE, LOW_TWO, IN_LINE, SINGLE, SINGLE_AS_SAMPLED } way_t;

/// What the link's ADC channel may do: show the current the other way, a share of it, none, or its two samples in each other's place.
typedef enum { LINK_SOUND, LINK_REVERSED, LINK_LESS, LINK_DEAD, LINK_EXCHANGED } link_t;

typedef struct {
    plant_t plant;
    lode_drive_t drive;
    lode_drive_tuning_t tuning;
    lode_single_shunt_t shunt;
    lode_single_shunt_tuning_t shunt_tuning;
    way_t way;
    double low_s[3]; // for which each low side has been on before t_k
    double next_low_s[3];
    link_t link;
} bench_t;

void setUp(void) {}

void tearDown(void) {}

// A 24 V servo motor.
static const plant_config_t motor = {.pole_pairs = 4,
                                     .Rs_Ohm = 0.6,
                                     .Ld_H = 0.6e-3,
                                     .Lq_H = 0.6e-3,
                                     .psi_Wb = 6.5e-3,
                                     .J_kgm2 = 3.0e-5,
                                     .B_Nms = 1.0e-5,
                                     .load_is_passive = true,
                                     .level = PLANT_SWITCHING,
                                     .period_s = T_s,
                                     .v_bus_V = V_BUS,
                                     .dead_time_s = DEAD_s,
                                     .adc_bits = 12,
                                     .i_A_per_count = GAIN_A,
                                     .v_bus_V_per_count = 0.01,
                                     .temperature_degC_per_count = 1.0,
                                     .seed = 1,
                                     .stamp_Hz = 1.0e6};

static bool is_single(way_t way) {
    return way == SINGLE || way == SINGLE_AS_SAMPLED;
}

static lode_single_shunt_config_t shunt_config(way_t way) {
    return (lode_single_shunt_config_t){.f_pwm_Hz = (float)F_PWM,
                                        .i_gain_A_count = (float)GAIN_A,
                                        .window_s = (float)(SETTLE_s + SAMPLE_s),
                                        .sample_s = (float)SAMPLE_s,
                                        .L_H = way == SINGLE ? (float)motor.Ld_H : 0.0f};
}

static float voltage_use(const bench_t *bench) {
    if (is_single(bench->way)) {
        return lode_single_shunt_voltage_use(&bench->shunt_tuning);
    }
    if (bench->way == LOW_TWO) {
        return 0.0f; // the drive's own
    }
    return bench->way == LOW_THREE
               ? (float)fmin(0.95, (DUTY_MAX - DEAD_MOST_s * F_PWM - 0.5) / (sqrt(3.0) / 4.0))
               : 0.95f;
}

static void start(bench_t *bench, way_t way, const plant_config_t *plant) {
    *bench = (bench_t){.way = way};
    const plant_config_t config = *plant;
    TEST_ASSERT_NULL(plant_init(&bench->plant, &config));
    const lode_single_shunt_config_t shunt = shunt_config(way);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_single_shunt_tune(&bench->shunt_tuning, &shunt));
    lode_single_shunt_reset(&bench->shunt);
    const bool low_side = way == LOW_THREE || way == LOW_TWO;
    const lode_drive_config_t drive = {
        .f_pwm_Hz = (float)F_PWM,
        .motor = {.pole_pairs = 4.0f,
                  .Rs_Ohm = (float)motor.Rs_Ohm,
                  .Ld_H = (float)motor.Ld_H,
                  .Lq_H = (float)config.Lq_H,
                  .psi_Wb = (float)motor.psi_Wb,
                  .J_kgm2 = (float)motor.J_kgm2,
                  .B_Nms = (float)motor.B_Nms},
        .inverter = {.v_bus_V = (float)V_BUS, .i_max_A = 5.0f, .dead_time_s = (float)DEAD_s},
        .sense = {.shunts = way == LOW_TWO ? LODE_SHUNTS_TWO : LODE_SHUNTS_THREE,
                  .i_gain_A_count = (float)GAIN_A,
                  .i_offset_count = (float)NO_CURRENT,
                  .v_bus_gain_V_count = 0.01f,
                  .duty_max = low_side ? (float)DUTY_MAX : 1.0f},
        .current = {.voltage_use = voltage_use(bench)},
        .start = {.pulses = is_single(way) ? LODE_OFF : LODE_AUTO, .signal_check = LODE_ON},
    };
    TEST_ASSERT_EQUAL_STRING(
        "LODE_OK", lode_status_name(lode_drive_init(&bench->drive, &bench->tuning, &drive)));
}

static void read_link(link_t link, uint16_t count[2]) {
    const uint16_t first = count[0];
    for (int n = 0; n < 2; n++) {
        const double shown = (double)count[n] - (double)NO_CURRENT;
        const double gain = link == LINK_REVERSED ? -1.0 : (link == LINK_LESS ? 0.4 : 1.0);
        count[n] = link == LINK_DEAD ? (uint16_t)NO_CURRENT
                                     : (uint16_t)lrint((double)NO_CURRENT + gain * shown);
    }
    if (link == LINK_EXCHANGED) {
        count[0] = count[1];
        count[1] = first;
    }
}

// What the ADC delivers at t_k. A low-side shunt shows nothing if its switch has not been on for long, or goes off too soon.
static lode_counts_t read_board(bench_t *bench) {
    plant_counts_t raw;
    plant_sample(&bench->plant, &raw, NULL);
    lode_counts_t counts = {.i = {raw.i[0], raw.i[1], raw.i[2]},
                            .v_bus = raw.v_bus,
                            .temperature = raw.temperature,
                            .stamp = raw.stamp};
    for (int x = 0; x < 3; x++) {
        const bool blind = bench->low_s[x] < SETTLE_s - ROUNDING_s ||
                           bench->next_low_s[x] < CONVERT_s - ROUNDING_s ||
                           (bench->way == LOW_TWO && x == 2);
        if (blind && (bench->way == LOW_THREE || bench->way == LOW_TWO)) {
            counts.i[x] = NO_CURRENT;
        }
        bench->low_s[x] = bench->next_low_s[x];
    }
    if (is_single(bench->way)) {
        read_link(bench->link, raw.link);
        lode_single_shunt_read(&bench->shunt, &bench->shunt_tuning, raw.link,
                               bench->drive.sense.offset[0], bench->drive.inverter.v_bus_V,
                               counts.i);
    }
    return counts;
}

static void write_board(bench_t *bench, const lode_drive_out_t *out) {
    const double duty[3] = {(double)out->duty.a, (double)out->duty.b, (double)out->duty.c};
    for (int x = 0; x < 3; x++) {
        bench->next_low_s[x] = 0.5 * (1.0 - duty[x]) * T_s;
    }
    plant_write(&bench->plant, duty, (plant_gates_t)out->gates);
    if (is_single(bench->way)) {
        const lode_single_shunt_plan_t plan =
            lode_single_shunt_write(&bench->shunt, &bench->shunt_tuning, out->duty, out->gates);
        const double rise[3] = {(double)plan.rise.a, (double)plan.rise.b, (double)plan.rise.c};
        const double fall[3] = {(double)plan.fall.a, (double)plan.fall.b, (double)plan.fall.c};
        plant_write_halves(&bench->plant, rise, fall, (plant_gates_t)out->gates);
        plant_set_link_samples(&bench->plant,
                               (const double[]){(double)plan.sample[0], (double)plan.sample[1]});
    }
}

typedef struct {
    double i_A;       // largest error of the current vector
    double angle_deg; // largest error of the estimate
    double share;     // of the voltage circle that was needed, largest
    bool running;
} errors_t;

static void note(bench_t *bench, errors_t *worst) {
    plant_truth_t truth;
    plant_sample(&bench->plant, NULL, &truth);
    const lode_counts_t counts = read_board(bench);
    const uint_least8_t omitted = bench->drive.omitted & 3u; // that of the next sample
    const lode_sample_t seen =
        lode_sense_step(&bench->drive.sense, &bench->tuning.sense, &counts, omitted);
    const lode_drive_out_t out = lode_drive_step(&bench->drive, &counts);
    lode_telemetry_t t;
    (void)lode_drive_telemetry(&bench->drive, &t);
    const double angle = remainder((double)t.theta_rad - truth.theta_e_rad, 2.0 * CHECK_PI);
    worst->i_A = fmax(worst->i_A, hypot((double)seen.i_A.alpha - truth.i_alpha_A,
                                        (double)seen.i_A.beta - truth.i_beta_A));
    worst->angle_deg = fmax(worst->angle_deg, fabs(angle) / CHECK_DEG);
    worst->share = fmax(worst->share, hypot((double)t.u_V.d, (double)t.u_V.q) * sqrt(3.0) / V_BUS);
    worst->running = t.mode == LODE_MODE_RUN;
    write_board(bench, &out);
    plant_advance(&bench->plant);
}

// From standstill to a speed, then under load; what was worst over the last 0.2 s.
static errors_t run_at(way_t way, double omega_m, double load_Nm) {
    static bench_t bench;
    start(&bench, way, &motor);
    const lode_command_t go = {.mode = LODE_MODE_RUN, .speed_rad_s = (float)omega_m};
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_command(&bench.drive, &go));
    errors_t worst = {.i_A = 0.0};
    for (int k = 0; k < (int)(5.0 * F_PWM); k++) {
        if (k == (int)(4.5 * F_PWM)) {
            plant_set_load(&bench.plant, load_Nm);
        }
        if (k == (int)(4.8 * F_PWM)) {
            worst = (errors_t){.i_A = 0.0};
        }
        note(&bench, &worst);
    }
    TEST_ASSERT_TRUE(worst.running);
    return worst;
}

static void expect_runs(way_t way, const char *name, double i_limit_A) {
    static const double speeds[] = {150.0, -150.0, 400.0, -400.0};
    for (int n = 0; n < COUNT_OF(speeds); n++) {
        const errors_t worst = run_at(way, speeds[n], 0.08);
        printf("  %-24s %5.0f rad/s: %.2f of the circle, current %.3f A, angle %.2f degrees\n",
               name, speeds[n], worst.share, worst.i_A, worst.angle_deg);
        CHECK_AT_MOST(i_limit_A, worst.i_A);
        CHECK_AT_MOST(3.0, worst.angle_deg);
    }
}

static void test_three_low_side_shunts(void) {
    expect_runs(LOW_THREE, "three low-side shunts", 0.03);
}

static void test_two_low_side_shunts(void) {
    expect_runs(LOW_TWO, "two low-side shunts", 0.03);
}

static void test_sensors_in_the_phases(void) {
    expect_runs(IN_LINE, "in the phases", 0.03);
}

static void test_one_shunt_in_the_link(void) {
    expect_runs(SINGLE, "one shunt in the link", 0.12);
}

static void test_link_as_sampled(void) {
    expect_runs(SINGLE_AS_SAMPLED, "the same, as sampled", 0.25);
}

// Of all angles of a voltage with this share of the circle, those at which a way sees less than two phases.
static double blind_share(way_t way, double use, const lode_single_shunt_tuning_t *tuning) {
    const int angles = 3600;
    int blind = 0;
    lode_single_shunt_t shunt;
    lode_single_shunt_reset(&shunt);
    for (int n = 0; n < angles; n++) {
        const double angle = (n + 0.5) * 2.0 * CHECK_PI / angles;
        const lode_ab_t u = {(float)(use / sqrt(3.0) * cos(angle)),
                             (float)(use / sqrt(3.0) * sin(angle))};
        const lode_abc_t d = lode_modulator_duties(lode_clarke_inverse(u));
        const float most = lode_max(lode_max(d.a, d.b), d.c);
        const float least = lode_min(lode_min(d.a, d.b), d.c);
        const float middle = d.a + d.b + d.c - most - least;
        const float end = (float)DUTY_MAX + 1.0e-6f;
        if (way == LOW_THREE) {
            blind += middle > end ? 1 : 0;
        } else if (way == LOW_TWO) {
            blind += d.a > end || d.b > end ? 1 : 0;
        } else if (way == SINGLE_AS_SAMPLED) { // the edges where the drive put them
            blind += most - middle < tuning->window || middle - least < tuning->window ? 1 : 0;
        } else if (way == SINGLE) {
            blind += lode_single_shunt_write(&shunt, tuning, d, LODE_GATES_ON).blind ? 1 : 0;
        }
    }
    return (double)blind / angles;
}

static void expect_blind(way_t way, double limit, const lode_single_shunt_tuning_t *tuning) {
    for (double use = 0.02; use < limit; use += 0.02) {
        TEST_ASSERT_TRUE(blind_share(way, use, tuning) == 0.0);
    }
    if (limit < 0.94) { // else the drive asks for no more
        TEST_ASSERT_TRUE(blind_share(way, limit + 0.02, tuning) > 0.0);
    }
}

static void test_blind_sectors(void) {
    const lode_single_shunt_config_t config = shunt_config(SINGLE);
    lode_single_shunt_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_single_shunt_tune(&tuning, &config));
    expect_blind(LOW_THREE, (DUTY_MAX - 0.5) / (sqrt(3.0) / 4.0), &tuning);
    expect_blind(LOW_TWO, 2.0 * DUTY_MAX - 1.0, &tuning);
    expect_blind(IN_LINE, 1.0, &tuning);
    const double limit = (double)lode_single_shunt_voltage_use(&tuning);
    TEST_ASSERT_TRUE(limit > 0.8);
    expect_blind(SINGLE, limit, &tuning);
    TEST_ASSERT_TRUE(blind_share(SINGLE, 1.1, &tuning) > 0.0); // beyond the circle
    // Edges left where they are: blind around every switching state, and everywhere at little voltage.
    TEST_ASSERT_TRUE(blind_share(SINGLE_AS_SAMPLED, 0.05, &tuning) == 1.0);
    printf("  share of a turn that is blind (window %.1f us of 50):\n"
           "  of the circle  three  two  link  link, edges shifted\n",
           SETTLE_s * 1.0e6);
    for (double use = 0.2; use < 1.01; use += 0.2) {
        printf("  %.1f            %.2f   %.2f  %.2f  %.2f\n", use,
               blind_share(LOW_THREE, use, &tuning), blind_share(LOW_TWO, use, &tuning),
               blind_share(SINGLE_AS_SAMPLED, use, &tuning), blind_share(SINGLE, use, &tuning));
        TEST_ASSERT_TRUE(blind_share(SINGLE_AS_SAMPLED, use, &tuning) > 0.1);
    }
}

/// A start's check of bridge and sensors by one shunt, until START or a fault; `driven`: periods with all gates on.
static lode_check_t tried(way_t way, const plant_config_t *plant, link_t link, int *driven) {
    static bench_t bench;
    start(&bench, way, plant);
    const lode_command_t go = {.mode = LODE_MODE_RUN, .speed_rad_s = 150.0f};
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_command(&bench.drive, &go));
    *driven = 0;
    lode_telemetry_t t = {.mode = LODE_MODE_OFF};
    for (int k = 0; k < (int)(0.5 * F_PWM) && t.mode != LODE_MODE_START; k++) {
        const lode_counts_t counts = read_board(&bench);
        const lode_drive_out_t out = lode_drive_step(&bench.drive, &counts);
        (void)lode_drive_telemetry(&bench.drive, &t);
        bench.link = t.mode == LODE_MODE_PRECHARGE ? link : bench.link; // after the calibration
        *driven += t.mode == LODE_MODE_PRECHARGE && out.gates == LODE_GATES_ON;
        write_board(&bench, &out);
        plant_advance(&bench.plant);
        if (t.mode == LODE_MODE_FAULT) {
            break;
        }
    }
    return (lode_check_t)t.fault.check;
}

// A dead one shows what brings its samples to t_k.
static void test_one_shunt_is_tried_before_a_start(void) {
    static const lode_check_t found[] = {LODE_CHECK_NONE, LODE_CHECK_SIGNALS, LODE_CHECK_INDUCTANCE,
                                         LODE_CHECK_SIGNALS, LODE_CHECK_SIGNALS};
    for (int salient = 0; salient < 2; salient++) {
        for (int n = 0; n < 12; n++) {
            plant_config_t plant = motor;
            plant.Lq_H = salient == 1 ? 2.5 * motor.Ld_H : motor.Lq_H;
            plant.theta_e_rad = n * CHECK_PI / 6.0 + 0.1;
            for (int k = 0; k < COUNT_OF(found); k++) {
                int driven;
                const lode_check_t check = tried(SINGLE, &plant, (link_t)k, &driven);
                TEST_ASSERT_EQUAL_STRING(lode_check_name(found[k]), lode_check_name(check));
                TEST_ASSERT_EQUAL_INT(6 * 4, driven);
            }
        }
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_blind_sectors);
    RUN_TEST(test_three_low_side_shunts);
    RUN_TEST(test_two_low_side_shunts);
    RUN_TEST(test_sensors_in_the_phases);
    RUN_TEST(test_one_shunt_in_the_link);
    RUN_TEST(test_link_as_sampled);
    RUN_TEST(test_one_shunt_is_tried_before_a_start);
    return UNITY_END();
}
