// Self-commissioning with six phases: what it finds on a simulated motor whose data sheet is wrong, and what it refuses.
#include "support/check.h"

#include "lodestar/commission6.h"
#include "plant/plant.h"

void setUp(void) {}

void tearDown(void) {}

/// What stands between the plant and the drive, once a period after the counts were sampled; NULL: nothing.
typedef void (*meddle_t)(lode_counts6_t *counts);

static struct {
    plant_t plant;
    lode_commission6_t commission;
    lode_drive6_t drive;
    lode_drive6_tuning_t tuning[2];
    meddle_t meddle;
    double i_max_A;
    double time_s;
} rig;

/// Of no drive of the catalogue: paper 1's motor wound in two sets, with little leakage.
static plant_config_t machine(void) {
    plant_config_t c = plant_config_jiang2022();
    c.sets = 2;
    c.Lxy_H = 1.2e-3;
    c.v_transistor_V = 1.0;
    c.v_diode_V = 1.0;
    c.r_on_Ohm = 0.05;
    c.theta_e_rad = 2.1;
    c.keeps_accounts = false;
    return c;
}

static lode_drive6_config_t sheet(void) {
    return (lode_drive6_config_t){
        .drive = {.f_pwm_Hz = 5.0e3f,
                  .motor = {.pole_pairs = 3.0f,
                            .Rs_Ohm = 0.9f,
                            .Ld_H = 3.0e-3f,
                            .Lq_H = 11.0e-3f,
                            .psi_Wb = 0.155f,
                            .J_kgm2 = 0.012f,
                            .omega_rated_rad_s = 471.0f},
                  .inverter = {.v_bus_V = 200.0f,
                               .i_max_A = 12.0f,
                               .dead_time_s = 3.5e-6f,
                               .v_drop_V = 0.8f},
                  .sense = {.i_gain_A_count = 50.0f / 4096.0f,
                            .i_offset_count = 2048.0f,
                            .v_bus_gain_V_count = 0.1f}},
        .Lxy_H = 1.5e-3f,
    };
}

static lode_status_t init(const lode_drive6_config_t *config) {
    return lode_commission6_init(&rig.commission, &rig.drive, rig.tuning, config);
}

static void begin(const plant_config_t *plant, const lode_drive6_config_t *config,
                  meddle_t meddle) {
    memset(&rig, 0, sizeof rig);
    TEST_ASSERT_NULL(plant_init(&rig.plant, plant));
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(init(config)));
    rig.meddle = meddle;
}

static lode_counts_t counts_of(const plant_counts_t *sampled) {
    return (lode_counts_t){.i = {sampled->i[0], sampled->i[1], sampled->i[2]},
                           .v_bus = sampled->v_bus,
                           .temperature = sampled->temperature};
}

/// To its end, at most 30 s.
static lode_commission_result_t go_on(void) {
    lode_commission_result_t result = LODE_COMMISSION_RUNNING;
    while (result == LODE_COMMISSION_RUNNING && rig.time_s < 30.0) {
        plant_counts_t sampled[2];
        plant_truth_t truth;
        plant_sample(&rig.plant, sampled, &truth);
        lode_counts6_t counts = {{counts_of(&sampled[0]), counts_of(&sampled[1])}};
        if (rig.meddle != NULL) {
            rig.meddle(&counts);
        }
        const lode_drive6_out_t out = lode_commission6_step(&rig.commission, &counts);
        for (int set = 0; set < 2; set++) {
            const lode_abc_t d = out.set[set].duty;
            const double duty[3] = {(double)d.a, (double)d.b, (double)d.c};
            plant_write_set(&rig.plant, set, duty, (plant_gates_t)out.set[set].gates);
        }
        plant_advance(&rig.plant);
        rig.time_s = truth.t_s;
        rig.i_max_A = fmax(rig.i_max_A, hypot(truth.id_A, truth.iq_A));
        result = lode_commission6_work(&rig.commission);
    }
    return result;
}

static void expect(lode_commission_result_t wanted) {
    const lode_commission_result_t result = go_on();
    if (result != wanted) {
        const lode_fault_t *fault = &rig.drive.drive.guard.fault;
        printf("  %s at %.3f s: fault %s, %g, limit %g\n",
               lode_commission_name(rig.commission.machine.quantity), rig.time_s,
               lode_check_name(fault->check), (double)fault->measured, (double)fault->limit);
    }
    TEST_ASSERT_EQUAL_STRING(lode_commission_result_name(wanted),
                             lode_commission_result_name(result));
}

static double value(lode_commission_quantity_t quantity) {
    const lode_commission_value_t *found = &rig.commission.machine.found[quantity];
    CHECK_AT_LEAST(LODE_COMMISSION_SURE, found->confidence);
    return (double)found->value;
}

static void check_found(const plant_config_t *c) {
    CHECK_NEAR(0.0, 6.0, value(LODE_COMMISSION_SIGNALS));
    CHECK_CLOSE(0.02, c->Rs_Ohm + c->r_on_Ohm, value(LODE_COMMISSION_RS_Ohm));
    CHECK_CLOSE(0.02, c->v_bus_V * c->dead_time_s / c->period_s + c->v_transistor_V,
                value(LODE_COMMISSION_DEAD_V));
    CHECK_CLOSE(0.05, c->Ld_H, value(LODE_COMMISSION_LD_H));
    CHECK_CLOSE(0.05, c->Lq_H, value(LODE_COMMISSION_LQ_H));
    CHECK_CLOSE(0.05, c->Lxy_H, value(LODE_COMMISSION_LXY_H));
    CHECK_CLOSE(0.01, c->psi_Wb, value(LODE_COMMISSION_PSI_Wb));
    CHECK_CLOSE(0.10, c->J_kgm2, value(LODE_COMMISSION_J_kgm2));
    // What the run was made with: the tuning that was not in use, made of what was found at standstill.
    const lode_commission_t *machine = &rig.commission.machine;
    TEST_ASSERT_EQUAL_PTR(&rig.tuning[(machine->runs + machine->lost) % 2u], rig.drive.tuning);
    CHECK_NEAR(0.0, machine->config.motor.Rs_Ohm, machine->designed.motor.Rs_Ohm);
    CHECK_CLOSE(1.0e-6, value(LODE_COMMISSION_LQ_H), rig.drive.tuning->drive.references.Lq_H);
    CHECK_AT_MOST(16.0, rig.time_s); // where the run is made again
    CHECK_AT_MOST(12.1, rig.i_max_A);
}

/// Wherever the rotor lies: near to opposite and opposite to either direction too.
static void test_finds_the_machine(void) {
    static const double angles[] = {0.3, 1.9, -1.3, -2.9};
    for (int k = 0; k < COUNT_OF(angles); k++) {
        plant_config_t c = machine();
        lode_drive6_config_t config = sheet();
        config.open_phase = LODE_OPEN_PHASE_GO_ON;
        c.theta_e_rad = angles[k];
        begin(&c, &config, NULL);
        expect(LODE_COMMISSION_DONE);
        check_found(&c);
        const lode_drive6_config_t *found = lode_commission6_config(&rig.commission);
        CHECK_NEAR(0.0, value(LODE_COMMISSION_RS_Ohm), found->drive.motor.Rs_Ohm);
        CHECK_NEAR(0.0, value(LODE_COMMISSION_J_kgm2), found->drive.motor.J_kgm2);
        CHECK_NEAR(0.0, value(LODE_COMMISSION_LXY_H), found->Lxy_H);
        TEST_ASSERT_EQUAL(LODE_OPEN_PHASE_GO_ON, found->open_phase);
        lode_drive6_tuning_t tuning;
        TEST_ASSERT_EQUAL(LODE_OK, lode_drive6_tune(&tuning, found));
    }
}

/// With flux and inertia told right one run is enough.
static void test_finds_it_in_one_run(void) {
    const plant_config_t c = machine();
    lode_drive6_config_t config = sheet();
    config.drive.motor.psi_Wb = (float)c.psi_Wb;
    config.drive.motor.J_kgm2 = (float)c.J_kgm2;
    begin(&c, &config, NULL);
    expect(LODE_COMMISSION_DONE);
    TEST_ASSERT_EQUAL(1, rig.commission.machine.runs);
    check_found(&c);
    CHECK_AT_MOST(10.0, rig.time_s);
}

/// Offsets of all six, noise, and a leakage that is told 40 % too small.
static void test_finds_it_through_real_sensors(void) {
    static const double offset_A[6] = {0.2, -0.3, 0.1, -0.2, 0.4, -0.1};
    plant_config_t c = machine();
    lode_drive6_config_t config = sheet();
    config.Lxy_H = 0.72e-3f;
    c.i_noise_A = 0.02;
    for (int x = 0; x < 6; x++) {
        c.i_offset_A[x] = offset_A[x];
    }
    begin(&c, &config, NULL);
    expect(LODE_COMMISSION_DONE);
    check_found(&c);
    for (int x = 0; x < 6; x++) {
        CHECK_NEAR(0.3, 2048.0 + offset_A[x] / c.i_A_per_count,
                   value((lode_commission_quantity_t)((int)LODE_COMMISSION_OFFSET_A + x)));
    }
}

/// Iron whose Lq is down by a third at i_max.
static void test_finds_the_fall(void) {
    plant_config_t c = machine();
    const lode_drive6_config_t config = sheet();
    c.i_sat_A = 12.0;
    c.Lq_sat_H = 0.5 * c.Lq_H;
    begin(&c, &config, NULL);
    expect(LODE_COMMISSION_DONE);
    plant_iron_t iron;
    plant_iron_init(&iron, &c);
    const double at_most_H = plant_iron_at(&iron, 0.0, 12.0).psi_q_Wb / 12.0;
    const double fall_1_A = (c.Lq_H / at_most_H - 1.0) / 12.0;
    CHECK_CLOSE(0.15, fall_1_A, value(LODE_COMMISSION_LQ_FALL_1_A));
    CHECK_CLOSE(0.05, c.Lxy_H, value(LODE_COMMISSION_LXY_H));
}

static void swap(uint16_t *x, uint16_t *y) {
    const uint16_t kept = *x;
    *x = *y;
    *y = kept;
}
static void swap_within_2(lode_counts6_t *counts) {
    swap(&counts->set[1].i[0], &counts->set[1].i[2]);
}
static void swap_sets(lode_counts6_t *counts) {
    for (int x = 0; x < 3; x++) {
        swap(&counts->set[0].i[x], &counts->set[1].i[x]);
    }
}
static void swap_first(lode_counts6_t *counts) {
    swap(&counts->set[0].i[0], &counts->set[1].i[0]);
}
static void turn_round(lode_counts6_t *counts) {
    counts->set[1].i[1] = (uint16_t)(4096u - counts->set[1].i[1]);
}
static void still(lode_counts6_t *counts) {
    counts->set[1].i[2] = 2048u;
}

/// Before anything turns: by the pulses, or the drive's own checks.
static void test_wrong_sensors_are_refused(void) {
    static const struct {
        const char *name;
        meddle_t meddle;
    } cases[] = {{"two of set 2 swapped", swap_within_2},
                 {"the sets swapped", swap_sets},
                 {"the first of each swapped", swap_first},
                 {"one of set 2 turned round", turn_round},
                 {"one of set 2 dead", still}};
    for (int k = 0; k < COUNT_OF(cases); k++) {
        const plant_config_t c = machine();
        const lode_drive6_config_t config = sheet();
        begin(&c, &config, cases[k].meddle);
        const lode_commission_result_t result = go_on();
        printf("  %s: %s, %s, %.3f s\n", cases[k].name, lode_commission_result_name(result),
               lode_commission_name(rig.commission.machine.quantity), rig.time_s);
        TEST_ASSERT_TRUE(result == LODE_COMMISSION_UNSURE || result == LODE_COMMISSION_FAULT);
        TEST_ASSERT_EQUAL(LODE_COMMISSION_SIGNALS, rig.commission.machine.quantity);
        CHECK_AT_MOST(1.0, rig.time_s);
    }
}

static void scatter(lode_counts6_t *counts) {
    (void)counts;
    lode_commission_t *machine = &rig.commission.machine;
    machine->sums.steps.yy *= machine->quantity == LODE_COMMISSION_LXY_H ? 1.05f : 1.0f;
}

/// A leakage whose steps do not agree with each other.
static void test_a_leakage_that_scatters_is_refused(void) {
    const plant_config_t c = machine();
    const lode_drive6_config_t config = sheet();
    begin(&c, &config, scatter);
    expect(LODE_COMMISSION_UNSURE);
    TEST_ASSERT_EQUAL(LODE_COMMISSION_LXY_H, rig.commission.machine.quantity);
    CHECK_AT_MOST(LODE_COMMISSION_SURE,
                  rig.commission.machine.found[LODE_COMMISSION_LXY_H].confidence);
}

static void test_configurations_that_are_refused(void) {
    lode_drive6_config_t config = sheet();
    lode_commission6_t *self = &rig.commission;
    TEST_ASSERT_EQUAL(LODE_ERROR_NULL,
                      lode_commission6_init(NULL, &rig.drive, rig.tuning, &config));
    TEST_ASSERT_EQUAL(LODE_ERROR_NULL, lode_commission6_init(self, NULL, rig.tuning, &config));
    TEST_ASSERT_EQUAL(LODE_ERROR_NULL, lode_commission6_init(self, &rig.drive, NULL, &config));
    TEST_ASSERT_EQUAL(LODE_ERROR_NULL, lode_commission6_init(self, &rig.drive, rig.tuning, NULL));
    memset(&rig, 0x5a, sizeof rig);
    static lode_commission6_t before;
    before = *self;
    config.Lxy_H = 0.0f;
    TEST_ASSERT_EQUAL(LODE_ERROR_XY_INDUCTANCE, init(&config));
    TEST_ASSERT_EQUAL_MEMORY(&before, self, sizeof before);
}

/// What the drive refuses of what was found: it ends with that, at rest.
static void test_what_was_found_may_be_refused(void) {
    const plant_config_t c = machine();
    const lode_drive6_config_t config = sheet();
    begin(&c, &config, NULL);
    rig.commission.config.xy.bandwidth_rad_s = 1.0e6f; // none that was there at the begin
    expect(LODE_COMMISSION_REFUSED);
    TEST_ASSERT_EQUAL(LODE_ERROR_XY_BANDWIDTH, rig.commission.machine.status);
    TEST_ASSERT_EQUAL(LODE_MODE_OFF, rig.drive.drive.mode);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_finds_the_machine);
    RUN_TEST(test_finds_it_in_one_run);
    RUN_TEST(test_finds_it_through_real_sensors);
    RUN_TEST(test_finds_the_fall);
    RUN_TEST(test_wrong_sensors_are_refused);
    RUN_TEST(test_a_leakage_that_scatters_is_refused);
    RUN_TEST(test_configurations_that_are_refused);
    RUN_TEST(test_what_was_found_may_be_refused);
    return UNITY_END();
}
