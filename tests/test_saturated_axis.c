// A q axis that saturates, as the EMF observer sees it: a machine in double whose fluxes are given, not simulated.
#include "support/rig.h"

#include "drive_inline.h"
#include "drive_slots_inline.h"

#include <complex.h>

void setUp(void) {}

void tearDown(void) {}

static const double fall = 0.05; // of Lq, 1/A

static lode_drive_tuning_t tuning;

typedef struct {
    double theta, omega, id, iq;
} machine_t;

static complex double current_of(const machine_t *m) {
    return (m->id + I * m->iq) * cexp(I * m->theta);
}

/// Paper 1's motor, Lq falling as (R2).
static complex double flux_of(const machine_t *m) {
    const double q = 9.8e-3 * m->iq / (1.0 + fall * fabs(m->iq));
    return (0.142 + 3.5e-3 * m->id + I * q) * cexp(I * m->theta);
}

static lode_ab_t vector(complex double x) {
    return (lode_ab_t){(float)creal(x), (float)cimag(x)};
}

/// A period of `machine` on to the currents (id, iq), and the drive's estimator behind it. Returns the error of the
/// angle, rad.
static double step(lode_drive_t *drive, machine_t *machine, bool known, double id, double iq) {
    const complex double flux = flux_of(machine);
    const complex double current = current_of(machine);
    machine->theta += RIG_TS_s * machine->omega;
    machine->id = id;
    machine->iq = iq;
    const double r = (double)(tuning.estimator.emf.inv_b - tuning.estimator.emf.a_over_b);
    const complex double u =
        (flux_of(machine) - flux) / RIG_TS_s + 0.5 * r * (current + current_of(machine));
    const lode_ab_t i_A = vector(current_of(machine));
    if (known) {
        lode_drive_lessen_saturated(drive, i_A);
    }
    const lode_estimate_t seen =
        lode_estimator_step(&drive->estimator, &tuning.estimator, vector(u), i_A);
    return angle_error((double)lode_estimate_theta_rad(&seen), machine->theta);
}

/// A drive whose estimator begins at `machine`'s angle and speed.
static void begin(rig_t *rig, const lode_drive_config_t *config, const machine_t *machine) {
    rig_init(rig, &tuning, config);
    lode_estimator_begin_at(&rig->drive.estimator, &tuning.estimator,
                            lode_sincos((float)machine->theta), (float)machine->omega);
    lode_estimator_set_current(&rig->drive.estimator, vector(current_of(machine)));
}

static lode_drive_config_t saturating(void) {
    lode_drive_config_t config = rig_config();
    config.references.Lq_fall = (float)fall;
    return config;
}

/// Largest error while 8 A are held, and while they change their sign within 2 ms, in degrees.
static void errors(const lode_drive_config_t *config, bool known, double omega, double *held,
                   double *reversed) {
    machine_t machine = {.theta = 0.4, .omega = omega, .iq = 8.0};
    rig_t rig;
    begin(&rig, config, &machine);
    for (int n = 0; n < 2000; n++) {
        (void)step(&rig.drive, &machine, known, 0.0, 8.0);
    }
    worst_t worst = {0.0};
    for (int n = 0; n < 200; n++) {
        worst_note(&worst, step(&rig.drive, &machine, known, 0.0, 8.0) / CHECK_DEG);
    }
    *held = worst.value;
    worst = (worst_t){0.0};
    for (int n = 0; n < 300; n++) {
        const double iq = fmax(8.0 - 16.0 * n / 10.0, -8.0);
        worst_note(&worst, step(&rig.drive, &machine, known, 0.0, iq) / CHECK_DEG);
    }
    *reversed = worst.value;
}

/// (E31). Without it the observed flux lies 10 degrees behind, and swings to 10 ahead.
static void test_current_that_reverses_turns_no_angle(void) {
    const lode_emf_kind_t kinds[] = {LODE_EMF_C_LESO, LODE_EMF_FA_LESO, LODE_EMF_R_LESO};
    for (int n = 0; n < 2 * COUNT_OF(kinds); n++) {
        lode_drive_config_t config = saturating();
        config.estimator.emf.kind = kinds[n / 2];
        config.estimator.pll.kind =
            LODE_PLL_QPLL; // knows no torque, by which this machine does not accelerate
        const double omega = n % 2 == 0 ? 300.0 : -300.0;
        double held;
        double reversed;
        errors(&config, false, omega, &held, &reversed);
        CHECK_AT_LEAST(8.0, held);
        errors(&config, true, omega, &held, &reversed);
        CHECK_AT_MOST(0.3, held);
        CHECK_AT_MOST(1.5, reversed);
    }
}

/// The voltage that the observer's last current stands for is that of the lacking flux.
static void test_lacking_flux_in_volts(void) {
    const lode_drive_config_t config = saturating();
    const machine_t machine = {.theta = 0.4, .omega = 300.0, .id = -2.0, .iq = 6.0};
    const machine_t now = {.theta = 0.4 + 300.0 * RIG_TS_s, .id = -1.0, .iq = -3.0};
    rig_t rig;
    begin(&rig, &config, &machine);
    lode_drive_lessen_saturated(&rig.drive, vector(current_of(&now)));
    const double a_over_b = (double)tuning.estimator.emf.a_over_b;
    const lode_ab_t i_A = rig.drive.estimator.emf.i_A;
    const complex double moved = (double)i_A.alpha + I * (double)i_A.beta - current_of(&machine);
    const double lacks_before = 9.8e-3 * 6.0 * (1.0 - 1.0 / 1.3);
    const double lacks_now = -9.8e-3 * 3.0 * (1.0 - 1.0 / 1.15);
    const complex double expected =
        I * (lacks_now * cexp(I * now.theta) - lacks_before * cexp(I * machine.theta)) / RIG_TS_s;
    CHECK_NEAR(0.02, creal(expected), creal(moved) * a_over_b);
    CHECK_NEAR(0.02, cimag(expected), cimag(moved) * a_over_b);
}

/// True if (E31) is applied. `weight` of injection while it injects; below 0: it does not inject.
static bool is_lessened(bool aligned, lode_hfi_mode_t mode, float weight) {
    const machine_t machine = {.theta = 0.4, .omega = 300.0, .iq = 6.0};
    lode_drive_config_t config = saturating();
    config.references.Lq_fall = 0.03f; // leaves saliency enough
    config.hfi.mode = mode;
    rig_t rig;
    begin(&rig, &config, &machine);
    rig.drive.estimator.aligned = aligned;
    rig.drive.estimator.by.hfi.active = weight >= 0.0f;
    rig.drive.estimator.by.hfi.weight = weight;
    const lode_ab_t before = rig.drive.estimator.emf.i_A;
    lode_drive_lessen_saturated(&rig.drive, (lode_ab_t){1.0f, -6.0f});
    const lode_ab_t now = rig.drive.estimator.emf.i_A;
    return now.alpha != before.alpha && now.beta != before.beta;
}

/// Not while the angle is not known, nor while injection alone gives it.
static void test_left_alone_without_an_angle_and_where_only_injection_gives_it(void) {
    TEST_ASSERT_FALSE(is_lessened(false, LODE_HFI_OFF, -1.0f));
    TEST_ASSERT_TRUE(is_lessened(true, LODE_HFI_OFF, -1.0f));
    TEST_ASSERT_FALSE(is_lessened(true, LODE_HFI_ON, 1.0f));
    TEST_ASSERT_TRUE(is_lessened(true, LODE_HFI_ON, 0.99f));
    TEST_ASSERT_TRUE(is_lessened(true, LODE_HFI_ON, 0.0f));
    TEST_ASSERT_TRUE(is_lessened(true, LODE_HFI_ON, -1.0f));
}

/// (R17) is for as long as (E31) waits for an angle: never both.
static void test_angle_is_turned_by_one_of_both(void) {
    const lode_drive_config_t config = saturating();
    const machine_t machine = {.theta = 0.4, .omega = 300.0, .iq = 8.0};
    for (int aligned = 0; aligned <= 1; aligned++) {
        rig_t rig;
        begin(&rig, &config, &machine);
        rig.drive.estimator.aligned = aligned != 0;
        rig.drive.estimator.pll.omega_rad_s = 330.0f; // as it has become
        const double lag = (double)lode_lag_rad(&tuning.estimator.lag, 330.0f);
        lode_drive_adapt_lag(&rig.drive, &tuning);
        const lode_sincos_t at = rig.drive.estimator.lag.at;
        const double lacks = 9.8e-3 * 8.0 * (1.0 - 1.0 / 1.4);
        const double turned = aligned != 0 ? 0.0 : atan(lacks / 0.142);
        CHECK_NEAR(0.02, turned, atan2((double)at.sin, (double)at.cos) - lag);
    }
}

/// In the closed loop: the step calls it where the q axis saturates, and there alone.
static void test_step_takes_it_out(void) {
    for (int saturates = 0; saturates <= 1; saturates++) {
        lode_drive_config_t config = rig_config();
        config.references.Lq_fall = saturates != 0 ? (float)fall : 0.0f;
        machine_t machine = {.theta = 0.4, .omega = 300.0, .iq = 8.0};
        rig_t rig;
        begin(&rig, &config, &machine);
        double error = 0.0;
        for (int n = 0; n < 2000; n++) {
            const complex double flux = flux_of(&machine);
            machine.theta += RIG_TS_s * machine.omega;
            const complex double u =
                (flux_of(&machine) - flux) / RIG_TS_s +
                (double)(tuning.estimator.emf.inv_b - tuning.estimator.emf.a_over_b) *
                    current_of(&machine);
            const lode_estimate_t seen =
                lode_drive_find(&rig.drive, &tuning, vector(u), vector(current_of(&machine)));
            if (n % 8 == 0) {
                lode_estimator_note_lock(&rig.drive.estimator, &tuning.estimator);
                lode_drive_adapt_lag(&rig.drive, &tuning);
            }
            error = angle_error((double)lode_estimate_theta_rad(&seen), machine.theta);
        }
        CHECK_NEAR(saturates != 0 ? 0.3 : 3.0, saturates != 0 ? 0.0 : -9.0, error / CHECK_DEG);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_current_that_reverses_turns_no_angle);
    RUN_TEST(test_lacking_flux_in_volts);
    RUN_TEST(test_left_alone_without_an_angle_and_where_only_injection_gives_it);
    RUN_TEST(test_angle_is_turned_by_one_of_both);
    RUN_TEST(test_step_takes_it_out);
    return UNITY_END();
}
