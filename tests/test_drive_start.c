// The drive from rest, or from a rotor that turns already, into RUN: the check of bridge and sensors, the attempts, the hand-over.
#include "mode_parts.h"
#include "support/drive_cases.h"

void setUp(void) {}

void tearDown(void) {}

static lode_drive_tuning_t other_tuning;

/// (S8): a d current that takes more than 0.4 of the flux falls before the hand-over.
static void test_hand_over_waits_for_the_flux_of_a_salient_rotor(void) {
    lode_drive_config_t config = rig_config();
    config.start.current_A = 12.0f;
    rig_t rig;
    rig_init(&rig, &other_tuning, &config);
    run_up(&rig, 100.0, 8.0);
    const double most_A = 0.4 * 0.142 / 6.3e-3;
    CHECK_AT_MOST(1.05 * most_A, rig.motor.id);
    CHECK_AT_MOST(rig.motor.id, 0.8 * most_A); // and no later than the lock takes
}

/// Volts by which the voltage leaves its turn in this period.
static double jump_of(rig_t *rig) {
    const lode_ab_t before = lode_clarke(rig->applied);
    rig_step(rig);
    const lode_ab_t now = lode_clarke(rig->applied);
    const lode_ab_t turned = lode_park_inverse((lode_dq_t){before.alpha, before.beta},
                                               lode_sincos((float)(rig->motor.omega * RIG_TS_s)));
    return (double)PAPER_V_BUS *
           hypot((double)(now.alpha - turned.alpha), (double)(now.beta - turned.beta));
}

/// From the start to the run the voltage does not jump: current control goes on from what both frames call the same, and
/// until the references' slot from the current that there is.
static void test_no_jump_at_hand_over(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig.load_Nm = 0.8;
        rig_command(&rig, run_at(80.0 * sign));
        double jump_V = 0.0;
        for (int n = 0; n < 40000 && rig_telemetry(&rig).mode != LODE_MODE_RUN; n++) {
            jump_V = jump_of(&rig);
        }
        rig_expect(&rig, LODE_MODE_RUN);
        const lode_running_t *run = &rig.drive.state.run;
        const lode_dq_t i_A = rig.drive.ref_A;
        CHECK_NEAR(0.3, rig.motor.id, i_A.d); // 8 A in a frame that is 2 degrees off
        CHECK_NEAR(0.3, rig.motor.iq, i_A.q);
        CHECK_NEAR(0.0, i_A.d, run->references.id_A);
        CHECK_NEAR(0.0, 1.0, run->fade);
        CHECK_NEAR(1.0, rig.motor.omega / 3.0, lode_drive_speed_ref_rad_s(&rig.drive));
        CHECK_NEAR(0.15, ipmsm_torque(&rig.motor), run->speed.torque_Nm);
        for (int n = 0; n < 2; n++) {
            jump_V = fmax(jump_V, jump_of(&rig));
        }
        CHECK_AT_MOST(1.0, jump_V);
    }
}

/// The duties of a start too act one and a half periods after the sample: its vector is led by what it turns until then.
static void test_the_vector_of_a_start_is_led_by_one_and_a_half_periods(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig_command(&rig, run_at(80.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.5));
        for (int n = 0; n < 20000 && fabs((double)rig.drive.state.start.omega_rad_s) < 20.0; n++) {
            rig_step(&rig);
        }
        rig_expect(&rig, LODE_MODE_START);
        lode_drive_t drive = rig.drive;
        const lode_sincos_t lead = lode_mode_control_frame(&drive).lead;
        CHECK_CLOSE(0.01, 1.5 * RIG_TS_s * (double)drive.state.start.omega_rad_s,
                    atan2((double)lead.sin, (double)lead.cos));
    }
}

/// A start whose rotor does not follow is given up in the first round beyond its time, and sooner where the EMF says so (S42).
static void test_a_start_has_its_time(void) {
    for (int seen = 0; seen <= 1; seen++) {
        rig_t rig = fresh();
        rig_command(&rig, run_at(80.0));
        rig.blocked = true;
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.5));
        for (uint32_t n = 0u; n < 500000u && rig.drive.mode == LODE_MODE_START; n++) {
            rig_step(&rig);
            rig.drive.state.start.slips = seen == 0 ? 0u : rig.drive.state.start.slips;
        }
        const uint32_t last = rig.drive.tuning->start.timeout_rounds + 1u;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&rig).fault.check);
        if (seen == 0) {
            TEST_ASSERT_EQUAL_UINT32(last, rig.drive.start_rounds);
        } else {
            CHECK_AT_MOST(0.8 * last, (double)rig.drive.start_rounds);
        }
    }
}

/// The start of a rig that comes to no hand-over.
static lode_telemetry_t failed_start(rig_t *rig) {
    rig_command(rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(rig, LODE_MODE_FAULT, 40.0));
    const lode_telemetry_t t = rig_telemetry(rig);
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_START", lode_check_name((lode_check_t)t.fault.check));
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_START", lode_mode_name((lode_mode_t)t.fault.state));
    TEST_ASSERT_EQUAL_INT(LODE_START_NONE, t.start_stage);
    return t;
}

static void check_why(const lode_fault_t *why, const char *stage, const char *criterion) {
    TEST_ASSERT_EQUAL_STRING(stage, lode_start_stage_name((lode_start_stage_t)why->stage));
    TEST_ASSERT_EQUAL_STRING(criterion, lode_criterion_name((lode_criterion_t)why->criterion));
    const bool above = why->criterion == (uint_least8_t)LODE_CRITERION_FLUX;
    TEST_ASSERT_TRUE(above ? why->measured > why->limit : why->measured < why->limit);
}

/// A jammed rotor, and one whose load is too large, make no EMF. Each attempt says so as it fails, and the start goes on.
static void test_a_rotor_that_does_not_follow_is_reported_by_its_emf(void) {
    for (int jams = 0; jams <= 1; jams++) {
        rig_t rig = fresh();
        rig.blocked = jams == 1;
        rig.load_Nm = 10.0;
        rig_command(&rig, run_at(80.0));
        for (uint_least8_t failed = 1u; failed <= 2u; failed++) {
            while (rig_telemetry(&rig).retries < failed) {
                rig_step(&rig);
            }
            const lode_telemetry_t t = rig_telemetry(&rig);
            rig_expect(&rig, LODE_MODE_START);
            TEST_ASSERT_EQUAL_INT(LODE_START_HALF, t.start_stage);
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, t.fault.check);
            check_why(&t.fault, "LODE_START_TURN", "LODE_CRITERION_EMF");
        }
        if (jams == 1) { // of an attempt that is at speed it is told what it does not meet itself
            rig.drive.guard.fault.criterion = (uint_least8_t)LODE_CRITERION_PROOF;
        }
        const lode_telemetry_t t = failed_start(&rig);
        check_why(&t.fault, "LODE_START_TURN", "LODE_CRITERION_EMF");
        CHECK_CLOSE(1.0e-6, 0.45 * 0.142 * (double)tuning.start.omega_handover, t.fault.limit);
        TEST_ASSERT_EQUAL_UINT(2u, t.retries);
        rig_command(&rig, clear);
        rig_run(&rig, 0.01);
        TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
        TEST_ASSERT_EQUAL_INT(LODE_CRITERION_NONE, rig_telemetry(&rig).fault.criterion);
    }
}

/// A psi in the configuration that is half as large again as the magnets' leaves an EMF, but no lock.
static void test_a_wrong_psi_is_reported_by_the_lock(void) {
    rig_t rig = fresh();
    rig.motor.psi *= 0.7;
    const lode_telemetry_t t = failed_start(&rig);
    check_why(&t.fault, "LODE_START_TURN", "LODE_CRITERION_LOCK");
    TEST_ASSERT_EQUAL_FLOAT(LODE_LOCK_HANDOVER, t.fault.limit);
}

/// A time-out that is too short, wherever it falls; and where it falls on an attempt that is not at speed yet, it is the one
/// before that tells why.
static void test_a_start_with_too_little_time_tells_where_it_was(void) {
    static const struct {
        float timeout_s;
        const char *stage;
        const char *criterion;
    } cases[] = {
        {0.05f, "LODE_START_HALF", "LODE_CRITERION_CURRENT"},
        {0.1f, "LODE_START_HALF", "LODE_CRITERION_REST"},
        {0.2f, "LODE_START_FULL", "LODE_CRITERION_CURRENT"},
        {0.6f, "LODE_START_TURN", "LODE_CRITERION_RAMP"},
        {1.5f, "LODE_START_TURN", "LODE_CRITERION_EMF"},
        {3.0f, "LODE_START_TURN", "LODE_CRITERION_EMF"}, // the second attempt's ramp
    };
    for (int k = 0; k < COUNT_OF(cases); k++) {
        lode_drive_config_t config = rig_config();
        config.start.timeout_s = cases[k].timeout_s;
        config.start.lock_s = 0.04f;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        rig.blocked = true;
        const lode_telemetry_t t = failed_start(&rig);
        check_why(&t.fault, cases[k].stage, cases[k].criterion);
        TEST_ASSERT_EQUAL_UINT(k == COUNT_OF(cases) - 1 ? 1u : 0u, t.retries);
    }
}

/// Any check that trips in START tells the stage; one that trips in RUN has none.
static void test_a_trip_in_a_start_tells_the_stage(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(80.0));
    lode_start_stage_t before = LODE_START_NONE;
    unsigned seen = 0u;
    for (int n = 0; n < 100000 && rig_telemetry(&rig).mode != LODE_MODE_RUN; n++) {
        const lode_start_stage_t stage = rig_telemetry(&rig).start_stage;
        if (stage != before && stage != LODE_START_NONE) {
            rig_t tripped = rig;
            tripped.trip = true;
            rig_step(&tripped);
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, rig_telemetry(&tripped).fault.check);
            TEST_ASSERT_EQUAL_INT(stage, rig_telemetry(&tripped).fault.stage);
            TEST_ASSERT_EQUAL_INT(LODE_CRITERION_NONE, rig_telemetry(&tripped).fault.criterion);
            seen++;
        }
        before = stage;
        rig_step(&rig);
    }
    TEST_ASSERT_EQUAL_UINT(5u, seen); // all but LODE_START_ALONE
    rig.trip = true;
    rig_step(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_START_NONE, rig_telemetry(&rig).fault.stage);
}

/// The rotor at `theta`, the vector of a start when its current begins. Until it turns it stands, or sweeps where `sweeps`.
static double first_vector(lode_drive_config_t config, double theta, float direction, bool sweeps) {
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.motor.theta = theta;
    rig_command(&rig, run_at(80.0f * direction));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 1.0));
    const lode_start_t *start = &rig.drive.state.start;
    while (!(start->current_A > 0.0f)) {
        rig_step(&rig);
    }
    const double first = atan2((double)start->at.sin, (double)start->at.cos);
    double moved = 0.0;
    while (start->stage != (uint_least8_t)LODE_START_TURN) {
        rig_step(&rig);
        rig_expect(&rig, LODE_MODE_START);
        const double now = atan2((double)start->at.sin, (double)start->at.cos);
        moved = fmax(moved, fabs(angle_error(now, first)));
    }
    TEST_ASSERT_EQUAL_INT(sweeps, moved > 1.0);
    TEST_ASSERT_TRUE(sweeps || moved < 1.0e-3);
    return first;
}

/// (S40). From every angle, with either polarity and direction: the first vector is 90 to 150 degrees ahead of the rotor's
/// d axis, or of its opposite. Not so of a rotor that is told round or hardly salient, or without the signal check.
static void test_the_first_vector_leads_the_axis_of_a_salient_rotor(void) {
    for (int k = 0; k < 24; k++) {
        const double theta = (k + 0.3) * CHECK_PI / 12.0;
        for (int sign = -1; sign <= 1; sign += 2) {
            const double at = first_vector(rig_config(), theta, (float)sign, false);
            const double lead = remainder(sign * (at - theta) - 2.0 * CHECK_PI / 3.0, CHECK_PI);
            CHECK_NEAR(31.0 * CHECK_PI / 180.0, 0.0, lead);
        }
    }
    lode_drive_config_t config = rig_config();
    config.start.signal_check = LODE_OFF;
    CHECK_NEAR(0.1, 0.0, first_vector(config, 1.5, 1.0f, true));
    config = rig_config();
    for (int n = 0; n < 3; n++) { // with both 20 % off the rotor may have the larger Ld
        static const float ratio[] = {1.0f, 1.4f, 1.6f};
        config.motor.Ld_H = config.motor.Lq_H / ratio[n];
        const double first = first_vector(config, 1.5, 1.0f, ratio[n] < 1.5f);
        TEST_ASSERT_EQUAL_INT(ratio[n] < 1.5f, fabs(first) < 0.1);
    }
}

/// A winding of twice the resistance is corrected by as much as one may be warmer, and no more: 0.75 of it. Two rest
/// positions in three at least let it be measured; with one current alone, what no dead time has counts as resistance.
static void test_much_resistance_is_corrected_in_part(void) {
    int measured = 0;
    for (int k = 0; k < 12; k++) {
        rig_t rig = fresh();
        const double R = rig.motor.R;
        rig.motor.R = 2.0 * R;
        rig.motor.theta = (double)k * CHECK_PI / 6.0;
        run_up(&rig, 80.0, 8.0);
        const double more_Ohm = (double)rig.drive.inverter.r_more_Ohm;
        CHECK_AT_MOST(0.7501 * R, more_Ohm);
        measured += more_Ohm > 0.65 * R ? 1 : 0;
    }
    CHECK_AT_LEAST(8.0, (double)measured);
}

static void test_a_rotor_that_turns_already_is_taken_over(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.2));
        rig.motor.omega = 3.0 * 80.0 * sign; // coasting
        rig_command(&rig, run_at(80.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.1)); // no I-f start in so short a time
        CHECK_AT_LEAST(70.0, sign * rig.motor.omega / 3.0);
        rig_run(&rig, 2.0);
        check_running(&rig, 80.0 * sign);
    }
}

static void test_pulses_find_a_rotor_that_turns(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = coasting(150.0 * sign);
        double most = 0.0;
        rig_command(&rig, run_at(150.0 * sign));
        rig_step(&rig);
        rig_expect(&rig, LODE_MODE_PRECHARGE);
        // No pulse by the duties that are in force when the low sides come.
        TEST_ASSERT_TRUE(rig.out.gates == LODE_GATES_OFF && !(rig.out.duty.a < 1.0f));
        for (int k = 0; k < 100 && rig_telemetry(&rig).mode == LODE_MODE_PRECHARGE; k++) {
            rig_step(&rig);
        }
        rig_expect(&rig, LODE_MODE_RUN);
        TEST_ASSERT_EQUAL_INT(LODE_GATES_OFF, rig.out.gates);
        CHECK_NEAR(5.0, 450.0 * sign, rig.drive.estimator.pll.omega_rad_s);
        for (int k = 0; k < 8; k++) { // the first duties are the EMF's
            rig_step(&rig);
            TEST_ASSERT_EQUAL_INT(LODE_GATES_ON, rig.out.gates);
            CHECK_NEAR(0.03, 0.0, rig.angle_error);
            if (!(fabs((double)rig.drive.ref_A.q) > 0.0)) { // until speed control asks for torque
                most = fmax(most, fmax(fabs(rig.motor.id), fabs(rig.motor.iq)));
            }
        }
        CHECK_NEAR(0.1, 0.0, most);
        rig_run(&rig, 2.0);
        check_running(&rig, 150.0 * sign);
    }
}

/// A rotor that was found by pulses is run from its EMF: no current, and neither torque nor a fade of a start that never was.
/// Until the first duties act the voltage at the terminals is the EMF, in the middle of each period.
static void test_a_flight_begins_with_the_emf(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = coasting(150.0 * sign);
        const lode_drive_t *drive = &rig.drive;
        rig_command(&rig, run_at(120.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
        // What the run before left where the pulses have nothing.
        memset((char *)&rig.drive.state + sizeof rig.drive.state.precharge, 0x41,
               sizeof rig.drive.state - sizeof rig.drive.state.precharge);
        rig.drive.ref_A = rig.drive.i_A = (lode_dq_t){-3.0f, 4.0f};
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.2));
        const lode_running_t *run = &drive->state.run;
        const double emf_V = 0.142 * rig.motor.omega;
        CHECK_NEAR(0.0, 0.0, drive->u_V.d);
        CHECK_CLOSE(0.01, emf_V, drive->u_V.q);
        CHECK_NEAR(0.0, 0.0, drive->i_A.d);
        CHECK_NEAR(0.0, 0.0, drive->i_A.q);
        CHECK_NEAR(0.0, 0.0, drive->ref_A.d);
        CHECK_NEAR(0.0, 0.0, drive->ref_A.q);
        CHECK_NEAR(0.0, 0.0, run->fade);
        CHECK_NEAR(0.0, 0.0, run->id_A);
        CHECK_NEAR(0.0, 0.0, run->references.id_A);
        CHECK_NEAR(0.0, 0.0, run->speed.torque_Nm);
        CHECK_CLOSE(0.01, rig.motor.omega / 3.0, lode_drive_speed_ref_rad_s(drive));
        for (int n = 0; n < 2; n++) {
            const lode_ab_t u_V =
                lode_inverter_realised(&drive->inverter, drive->steps + (uint32_t)n);
            const double middle = rig.motor.theta + ((double)n - 0.5) * RIG_TS_s * rig.motor.omega;
            CHECK_NEAR(0.02 * fabs(emf_V), -emf_V * sin(middle), u_V.alpha);
            CHECK_NEAR(0.02 * fabs(emf_V), emf_V * cos(middle), u_V.beta);
        }
    }
}

static void test_off_ends_the_pulses(void) {
    rig_t rig = coasting(150.0);
    rig_command(&rig, run_at(150.0));
    rig_run(&rig, 13.0 * RIG_TS_s); // noise is measured first
    TEST_ASSERT_EQUAL_INT(LODE_GATES_LOW, rig.out.gates);
    rig_command(&rig, off);
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_expect(&rig, LODE_MODE_OFF);
}

/// Before a start: `swapped`: the sensors of phases a and b; the bus as sampled. Until the start or a fault; periods with all
/// gates on.
static int driven_before(rig_t *rig, bool swapped, bool bus) {
    int driven = 0;
    for (int n = 0; n < 1000 && rig->drive.mode != (uint_least8_t)LODE_MODE_START &&
                    rig->drive.mode != (uint_least8_t)LODE_MODE_FAULT;
         n++) {
        lode_counts_t counts = rig_counts(rig);
        const uint16_t a = counts.i[0];
        counts.i[0] = swapped ? counts.i[1] : a;
        counts.i[1] = swapped ? a : counts.i[1];
        counts.v_bus = bus ? counts.v_bus : (uint16_t)0u;
        rig->out = lode_drive_step(&rig->drive, &counts);
        driven +=
            rig->drive.mode == (uint_least8_t)LODE_MODE_PRECHARGE && rig->out.gates == LODE_GATES_ON
                ? 1
                : 0;
        rig_move(rig);
        CHECK_AT_MOST(0.4 * 12.0, hypot(rig->motor.id, rig->motor.iq));
    }
    return driven;
}

#define PULSE_PERIODS 4 // with the gates on, of each of six pulses

/// (S37), before the first attempt and without turning the rotor.
static void test_a_start_tries_bridge_and_sensors(void) {
    rig_t rig = fresh();
    const double theta = rig.motor.theta;
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_EQUAL_INT(6 * PULSE_PERIODS, driven_before(&rig, false, true));
    rig_expect(&rig, LODE_MODE_START);
    CHECK_NEAR(1.0 * CHECK_DEG, theta, rig.motor.theta);
    TEST_ASSERT_TRUE(rig_telemetry(&rig).signals_checked);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
    TEST_ASSERT_TRUE(rig_telemetry(&rig).signals_checked);
}

/// Of the start's first attempt it is told whether it was checked, and of one that follows what that has shown.
static void test_a_start_without_its_signal_check_is_reported(void) {
    for (int n = 0; n < 4; n++) {
        rig_t rig = fresh();
        TEST_ASSERT_FALSE(rig_telemetry(&rig).signals_checked);
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.2));
        TEST_ASSERT_TRUE(lode_drive_knows(&rig.drive, LODE_KNOWN_OFFSETS));
        rig.drive.known |= (uint_least8_t)LODE_KNOWN_SIGNALS;
        rig.drive.losses = n == 3 ? 1u : 0u;
        rig_command(&rig, n == 0 ? (lode_command_t){.mode = LODE_MODE_CURRENT} : run_at(100.0));
        rig.motor.omega = n == 2 ? 30.0 : 0.0; // slower than a rotor that is caught
        for (int k = 0; k < 3; k++) {
            rig_step(&rig);
        }
        TEST_ASSERT_EQUAL_INT(n == 0 || n == 3, rig_telemetry(&rig).signals_checked);
        TEST_ASSERT_TRUE(lode_drive_knows(&rig.drive, LODE_KNOWN_OFFSETS));
        if (n > 0) {
            TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.5));
            TEST_ASSERT_EQUAL_INT(n != 2, rig_telemetry(&rig).signals_checked);
        }
    }
}

/// Another attempt relies on the check of the first one, unless a phase has seemed open since. While the rotor turns that is
/// the fault (S28).
static void test_a_phase_that_seemed_open_is_looked_at_before_the_next_attempt(void) {
    for (int n = 0; n < 4; n++) {
        const bool open = n % 2 == 1;
        rig_t rig = fresh();
        run_up(&rig, 80.0, 8.0);
        lode_fault_t why = {.criterion = (uint_least8_t)LODE_CRITERION_PROOF, .measured = 2.0f};
        why.criterion = open ? (uint_least8_t)LODE_CRITERION_OPEN_PHASE : why.criterion;
        lode_mode_end_attempt(&rig.drive, &why, 1u, 0u);
        rig.motor.omega = n < 2 ? 0.0 : 30.0; // slower than a rotor that is caught
        TEST_ASSERT_EQUAL_INT(n == 1 ? 6 * PULSE_PERIODS : 0, driven_before(&rig, false, true));
        rig_expect(&rig, n == 3 ? LODE_MODE_FAULT : LODE_MODE_START);
        if (n == 3) {
            const lode_fault_t fault = rig_telemetry(&rig).fault;
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE", lode_check_name(fault.check));
            CHECK_NEAR(0.0, 2.0, fault.measured);
            CHECK_NEAR(0.0, 0.0, fault.limit);
        }
    }
}

static void test_swapped_sensors_end_the_start_before_it_begins(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_EQUAL_INT(6 * PULSE_PERIODS, driven_before(&rig, true, true));
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_SIGNALS", lode_check_name(fault.check));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_PRECHARGE, fault.state);
    TEST_ASSERT_TRUE(fault.measured < fault.limit);
    TEST_ASSERT_FALSE(rig_telemetry(&rig).signals_checked);
    TEST_ASSERT_TRUE(is_idle(rig.out));
}

/// What sensors in the phases may do: swapped, the other way, one with a share of the current, one that shows none.
typedef enum { SOUND, SWAPPED, REVERSED, LESS, DEAD } sensors_t;

/// The first attempt of a drive without pulses of the low sides, until START or a fault.
static lode_check_t tried_alone(const lode_drive_config_t *config, sensors_t sensors, double omega,
                                int *driven) {
    rig_t rig;
    rig_init(&rig, &tuning, config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.2));
    rig.motor.omega = omega;
    rig_command(&rig, run_at(100.0));
    *driven = 0;
    for (int n = 0; n < 500 && rig.drive.mode != (uint_least8_t)LODE_MODE_START &&
                    rig.drive.mode != (uint_least8_t)LODE_MODE_FAULT;
         n++) {
        lode_counts_t counts = rig_counts(&rig);
        const uint16_t a = counts.i[0];
        const double zero = 2048.0;
        for (int x = 0; x < 3 && sensors == REVERSED; x++) {
            counts.i[x] = rig_count(2.0 * zero - (double)counts.i[x]);
        }
        counts.i[0] = sensors == SWAPPED ? counts.i[1] : counts.i[0];
        counts.i[1] = sensors == SWAPPED ? a : counts.i[1];
        counts.i[2] =
            sensors == LESS ? rig_count(zero + 0.6 * ((double)counts.i[2] - zero)) : counts.i[2];
        counts.i[2] = sensors == DEAD ? rig_count(zero) : counts.i[2];
        rig.out = lode_drive_step(&rig.drive, &counts);
        TEST_ASSERT_NOT_EQUAL(LODE_GATES_LOW, rig.out.gates);
        *driven += rig.out.gates == LODE_GATES_ON && rig_telemetry(&rig).mode != LODE_MODE_START;
        rig_move(&rig);
        CHECK_AT_MOST(0.5 * 12.0, hypot(rig.motor.id, rig.motor.iq));
    }
    return (lode_check_t)rig_telemetry(&rig).fault.check;
}

/// With double update, and where it is asked for on a board whose low sides cannot come alone.
static void test_bridge_and_sensors_are_tried_without_low_side_pulses(void) {
    static const lode_check_t found[] = {LODE_CHECK_NONE, LODE_CHECK_SIGNALS, LODE_CHECK_SIGNALS,
                                         LODE_CHECK_CURRENT_SUM, LODE_CHECK_CURRENT_STUCK};
    for (int n = 0; n < 2; n++) {
        lode_drive_config_t config = rig_config();
        config.inverter.double_update = n == 0 ? LODE_ON : LODE_AUTO;
        config.start.pulses = n == 0 ? LODE_AUTO : LODE_OFF;
        config.start.signal_check = n == 0 ? LODE_AUTO : LODE_ON;
        int driven;
        for (int k = 0; k < COUNT_OF(found); k++) {
            TEST_ASSERT_EQUAL_STRING(
                lode_check_name(found[k]),
                lode_check_name(tried_alone(&config, (sensors_t)k, 0.0, &driven)));
            const int sets = found[k] == LODE_CHECK_CURRENT_SUM ? 2 : 1; // (S48)
            TEST_ASSERT_EQUAL_INT(sets * 6 * PULSE_PERIODS, driven);
        }
        // A rotor that turns is left to the start, whatever the sensors.
        for (int way = -1; way <= 1; way += 2) {
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE,
                                  tried_alone(&config, SWAPPED, 300.0 * way, &driven));
            CHECK_AT_MOST(PULSE_PERIODS, driven);
        }
        config.start.signal_check = LODE_OFF;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, tried_alone(&config, SWAPPED, 0.0, &driven));
        TEST_ASSERT_EQUAL_INT(0, driven);
    }
}

/// Switched off; of another attempt; and by a bus that is none, which the guard names in START.
static void test_starts_that_try_nothing(void) {
    lode_drive_config_t config = rig_config();
    config.start.signal_check = LODE_OFF;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_EQUAL_INT(0, driven_before(&rig, true, true));
    rig_expect(&rig, LODE_MODE_START);
    rig_t again = fresh();
    rig_command(&again, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&again, LODE_MODE_PRECHARGE, 0.2));
    again.drive.losses = 1u;
    TEST_ASSERT_EQUAL_INT(0, driven_before(&again, true, true));
    rig_expect(&again, LODE_MODE_START);
    rig_t dark = fresh();
    rig_command(&dark, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&dark, LODE_MODE_PRECHARGE, 0.2));
    TEST_ASSERT_EQUAL_INT(6 * PULSE_PERIODS, driven_before(&dark, true, false));
    rig_expect(&dark, LODE_MODE_START);
}

// Whatever a memory that has flipped says of the share.
static void test_duties_of_pulses_stay_in_range(void) {
    const float shares[] = {1.5f, -0.5f, NAN, INFINITY, -INFINITY};
    rig_t searching = coasting(150.0);
    rig_command(&searching, run_at(150.0));
    TEST_ASSERT_TRUE(reach(&searching, LODE_MODE_PRECHARGE, 0.2));
    rig_run(&searching, 2.0 * RIG_TS_s);
    for (int k = 0; k < COUNT_OF(shares); k++) {
        rig_t rig = searching;
        rig.drive.state.precharge.by.fly.share = shares[k];
        rig.drive.state.precharge.by.fly.wait = 2u; // it stays for a period
        rig_step(&rig);
        TEST_ASSERT_TRUE(rig.out.duty.a >= 0.0f && rig.out.duty.a <= 1.0f);
        TEST_ASSERT_EQUAL_FLOAT(rig.out.duty.a, rig.out.duty.b);
        TEST_ASSERT_EQUAL_FLOAT(rig.out.duty.a, rig.out.duty.c);
    }
}

/// Pulses that find a rotor go on for as long as the low sides are on in the time that the capacitors have: 0.2 of it.
static void test_capacitors_are_charged_by_the_pulses_themselves(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.precharge_s = (float)(200.0 * RIG_TS_s);
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.2));
    rig.motor.omega = 3.0 * 150.0;
    rig_command(&rig, run_at(120.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
    double on = 0.0;
    double before = 0.0; // the coasting that follows has none
    for (int n = 0; n < 2000 && rig_telemetry(&rig).mode == LODE_MODE_PRECHARGE; n++) {
        before = on;
        rig_step(&rig);
        on += rig_telemetry(&rig).mode == LODE_MODE_PRECHARGE ? 1.0 - (double)rig.out.duty.a : 0.0;
    }
    rig_expect(&rig, LODE_MODE_RUN);
    CHECK_NEAR(0.6, 40.3, on);
    CHECK_NEAR(0.0, on, before);
}

static void test_capacitors_are_charged_after_pulses_that_find_nothing(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.precharge_s = (float)(PRECHARGE_PERIODS * RIG_TS_s);
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.blocked = true;
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
    int charged = 0;
    for (int k = 0; k < 400 && rig_telemetry(&rig).mode == LODE_MODE_PRECHARGE; k++) {
        rig_step(&rig);
        charged += is_low(rig.out, 0.8f) ? 1 : 0;
    }
    rig_expect(&rig, LODE_MODE_START);
    TEST_ASSERT_EQUAL_INT(PRECHARGE_PERIODS, charged);
}

static void test_a_blocked_rotor_ends_in_a_start_fault(void) {
    rig_t rig = fresh();
    rig.blocked = true;
    rig_command(&rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_FAULT, 30.0)); // three attempts
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_START", lode_check_name((lode_check_t)fault.check));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_START, fault.state);
    TEST_ASSERT_TRUE(is_idle(rig.out));
}

/// One that has just handed over, by a start that looks for no rotor that turns already.
static rig_t handed_over(void) {
    lode_drive_config_t config = rig_config();
    config.start.pulses = LODE_OFF;
    config.start.catch_s = LODE_NONE;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 80.0, 8.0);
    return rig;
}

/// Loses the lock, and with it the gates without a fault; the next attempt begins from rest.
static void lose_an_attempt(rig_t *rig, unsigned attempt) {
    const int looks = (int)(tuning.guard.lock_checks * LODE_GUARD_PERIODS);
    const int steps = steps_until_off(rig, 0.3f, 1.0f, 1000);
    CHECK_NEAR(2.0 * LODE_GUARD_PERIODS, 2.0 / 3.0 * looks, steps);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig_telemetry(rig).mode);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(rig).fault.check);
    TEST_ASSERT_TRUE(is_idle(rig->out));
    TEST_ASSERT_EQUAL_UINT(attempt, rig_telemetry(rig).retries);
    rig->motor.omega = 0.0;
    TEST_ASSERT_TRUE(reach(rig, LODE_MODE_START, 0.1));
    const lode_fault_t why =
        rig_telemetry(rig).fault; // of the attempt, while the next one is under way
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, why.state);
    check_why(&why, "LODE_START_NONE", "LODE_CRITERION_PROOF");
    TEST_ASSERT_EQUAL_FLOAT(LODE_LOCK_LOST, why.limit);
    TEST_ASSERT_EQUAL_UINT(attempt, rig_telemetry(rig).retries);
    TEST_ASSERT_EQUAL_UINT(attempt, rig->drive.state.start.failed);
}

/// (S28). Three attempts, the last one once more, then the fault.
static void test_a_lock_lost_right_after_the_hand_over_is_an_attempt(void) {
    rig_t rig = handed_over();
    TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
    TEST_ASSERT_FALSE(rig_telemetry(&rig).gains_halved);
    for (unsigned attempt = 1u; attempt <= 3u; attempt++) {
        lose_an_attempt(&rig, attempt);
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
        TEST_ASSERT_EQUAL_UINT(attempt, rig_telemetry(&rig).retries);
        TEST_ASSERT_TRUE(rig_telemetry(&rig).gains_halved); // (K51)
        TEST_ASSERT_EQUAL_UINT(attempt > 1u ? 2u : 1u, rig.drive.state.run.speed.calmed);
    }
    rig_t steady_rig = rig;
    rig_run(&steady_rig, 1.0);
    TEST_ASSERT_EQUAL_UINT(3u, rig_telemetry(&steady_rig).retries); // of the last start
    (void)steps_until_off(&rig, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, rig_telemetry(&rig).fault.state);
}

/// (K51). Neither a reversal nor an attempt that fails otherwise ends what lost rotors or a swing (K48) have halved; OFF does.
static void test_gains_are_halved_until_the_drive_is_off(void) {
    for (uint_least8_t calmed = 0u; calmed <= 2u; calmed++) {
        rig_t rig = handed_over();
        for (uint_least8_t lost = 1u; lost <= calmed; lost++) {
            lose_an_attempt(&rig, lost);
            TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
            TEST_ASSERT_EQUAL_UINT(lost, rig.drive.state.run.speed.calmed);
        }
        rig_run(&rig, 0.5);
        if (calmed == 0u) {
            rig.drive.state.run.speed.calmed = 1u; // as by a swing
        }
        const uint_least8_t kept = rig.drive.state.run.speed.calmed;
        rig_command(&rig, run_at(-80.0));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 4.0));
        rig.drive.guard.fault.criterion = (uint_least8_t)LODE_CRITERION_EMF; // as a failed attempt
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
        TEST_ASSERT_EQUAL_UINT(kept, rig.drive.state.run.speed.calmed);
        TEST_ASSERT_TRUE(rig_telemetry(&rig).gains_halved);
        rig_command(&rig, off);
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.01));
        rig.motor.omega = 0.0;
        rig_command(&rig, run_at(80.0));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
        TEST_ASSERT_FALSE(rig_telemetry(&rig).gains_halved);
    }
}

/// A start that is given up while its next attempt is due leaves nothing to a later one.
static void test_a_start_that_is_given_up_is_over(void) {
    static const lode_command_t stop = {.mode = LODE_MODE_RUN};
    for (int n = 0; n < 2; n++) {
        rig_t rig = handed_over();
        if (n == 0) { // a stop from speed, in which the lock is lost
            rig_command(&rig, run_at(150.0));
            rig_run(&rig, 1.0);
            rig.drive.state.run.proving = 1000u;
            rig_command(&rig, stop);
            rig_step(&rig);
        }
        (void)steps_until_off(&rig, 0.3f, 1.0f, 1000);
        rig_expect(&rig, LODE_MODE_OFF);
        rig_command(&rig, n == 0 ? stop : off);
        rig.motor.omega = 0.0;
        rig_run(&rig, 0.1);
        rig_expect(&rig, LODE_MODE_OFF);
        TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
        rig_command(&rig, run_at(80.0));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.2));
        TEST_ASSERT_EQUAL_UINT32(0u, rig.drive.start_rounds);
        TEST_ASSERT_EQUAL_INT(LODE_CRITERION_NONE, rig_telemetry(&rig).fault.criterion);
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
        TEST_ASSERT_FALSE(rig_telemetry(&rig).gains_halved);
    }
}

/// (K51). A rotor that is caught after a lost lock has no other inertia.
static void test_gains_are_halved_for_a_rotor_that_is_caught_again(void) {
    rig_t rig = fresh();
    run_up(&rig, 80.0, 8.0);
    (void)steps_until_off(&rig, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig_telemetry(&rig).mode);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.1));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, rig.drive.state.run.fade); // not by a start's current
    TEST_ASSERT_EQUAL_UINT(1u, rig_telemetry(&rig).retries);
    TEST_ASSERT_TRUE(rig_telemetry(&rig).gains_halved);
}

/// (K41): a suspected phase gives a lock that is lost before the proof its name, if it can be checked before the next attempt.
static void test_a_lost_lock_before_the_proof_is_that_of_a_suspected_phase(void) {
    for (int phase = 0; phase < 2 * LODE_PHASES; phase++) {
        const bool checked = phase < LODE_PHASES;
        rig_t rig = checked ? fresh() : handed_over();
        run_up(&rig, 80.0, 8.0);
        for (int n = 0; n < 1000 && rig.drive.mode == (uint_least8_t)LODE_MODE_RUN; n++) {
            rig.drive.state.run.waves = (lode_half_waves_t){.lacks = {0u}};
            rig.drive.state.run.waves.lacks[phase % LODE_PHASES] = 5000u;
            (void)steps_until_off(&rig, 0.3f, 1.0f, 1);
        }
        const lode_fault_t why = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, why.check);
        TEST_ASSERT_EQUAL_STRING(checked ? "LODE_CRITERION_OPEN_PHASE" : "LODE_CRITERION_PROOF",
                                 lode_criterion_name((lode_criterion_t)why.criterion));
        CHECK_NEAR(1.0e-6, checked ? phase + 1.0 : 0.3, why.measured);
        CHECK_NEAR(0.0, checked ? 0.0 : 0.5, why.limit);
    }
}

/// (S28). What the attempts before have used up is gone; after a commanded OFF and in a reversal it is another start.
static void test_all_attempts_of_a_start_have_one_time(void) {
    rig_t rig = handed_over();
    const uint32_t first = rig.drive.start_rounds;
    CHECK_AT_LEAST(100.0, (double)first);
    lose_an_attempt(&rig, 1u);
    CHECK_AT_LEAST((double)first, (double)rig.drive.start_rounds);
    rig_t late = rig;
    late.drive.start_rounds = tuning.start.timeout_rounds - 100u;
    TEST_ASSERT_TRUE(reach(&late, LODE_MODE_FAULT, 0.5));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&late).fault.check);
    const lode_fault_t why = rig_telemetry(&late).fault;
    check_why(&why, "LODE_START_NONE", "LODE_CRITERION_PROOF");
    TEST_ASSERT_EQUAL_UINT(1u, rig_telemetry(&late).retries);
    rig_t again = rig;
    rig_command(&again, off);
    TEST_ASSERT_TRUE(reach(&again, LODE_MODE_OFF, 0.01));
    rig_command(&again, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&again, LODE_MODE_START, 0.2));
    TEST_ASSERT_EQUAL_UINT32(0u, again.drive.start_rounds);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    rig_run(&rig, 0.5);
    rig_command(&rig, run_at(-80.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 4.0));
    TEST_ASSERT_EQUAL_UINT32(0u, rig.drive.start_rounds);
}

/// To the last round.
static void test_a_start_is_proven_to_the_round(void) {
    rig_t rig = handed_over();
    rig.drive.guard.lock = (uint_least16_t)tuning.guard.lock_checks;
    rig.drive.losses = 1u;
    for (int left = 0; left <= 1; left++) {
        rig_t lost = rig;
        lost.drive.state.run.proving = (uint_least16_t)left;
        rig_t back = lost;
        lode_mode_prove_start(&lost.drive);
        TEST_ASSERT_EQUAL_INT(left == 1 ? LODE_MODE_OFF : LODE_MODE_RUN, lost.drive.mode);
        lode_mode_hand_back(&back.drive);
        TEST_ASSERT_EQUAL_UINT(left, back.drive.losses);
        TEST_ASSERT_EQUAL_UINT(left, back.drive.state.start.failed);
    }
}

/// Hall switches may contradict the EMF for a moment only; an encoder that does will do so again.
static void test_a_start_is_repeated_with_hall_switches_only(void) {
    rig_t rig = handed_over();
    rig.drive.guard.lock = (uint_least16_t)tuning.guard.lock_checks;
    rig.drive.state.run.proving = 100u;
    rig.drive.sensored = 9u;
    for (int edges = 0; edges <= 1; edges++) {
        rig_t at = rig;
        at.drive.edges = edges == 1;
        lode_mode_prove_start(&at.drive);
        TEST_ASSERT_EQUAL_INT(edges == 1 ? LODE_MODE_OFF : LODE_MODE_RUN, at.drive.mode);
    }
}

/// What the same check finds besides the lock stays latched.
static void test_a_lock_that_is_lost_hides_no_other_fault(void) {
    rig_t rig = handed_over();
    rig.drive.guard.lock = (uint_least16_t)tuning.guard.lock_checks;
    rig.drive.state.run.proving = 100u;
    for (int n = 0; n < 3; n++) {
        rig_t at = rig;
        const lode_check_t check = n == 0   ? LODE_CHECK_NONE
                                   : n == 1 ? LODE_CHECK_LOST_LOCK
                                            : LODE_CHECK_OVER_VOLTAGE;
        at.drive.guard.fault.check = (uint_least8_t)check;
        at.drive.guard.trips = 7u;
        lode_mode_prove_start(&at.drive);
        TEST_ASSERT_EQUAL_UINT(n == 1 ? 6u : 7u, at.drive.guard.trips);
        TEST_ASSERT_EQUAL_INT(n < 2 ? LODE_MODE_OFF : LODE_MODE_RUN, at.drive.mode);
        TEST_ASSERT_EQUAL_INT(n < 2 ? LODE_CHECK_NONE : LODE_CHECK_OVER_VOLTAGE,
                              at.drive.guard.fault.check);
    }
}

/// Periods of a start with an estimate of this speed, of that of hand-over, and a vector of that, until its attempt ends; 0: it
/// does not.
static int periods_until_it_ends(rig_t *rig, float omega, float vector, float lock) {
    const float ready = tuning.start.omega_ready;
    for (int n = 1; n <= 4000; n++) {
        rig->drive.estimator.pll.omega_rad_s = omega * ready;
        rig->drive.estimator.lock = lock;
        rig->drive.state.start.omega_rad_s = vector * ready;
        rig->drive.state.start.locked = 0u;
        rig_step(rig);
        if (rig->drive.mode != (uint_least8_t)LODE_MODE_START) {
            return n;
        }
    }
    return 0;
}

/// A start towards a positive speed, its vector on its way, after so many attempts that failed.
static rig_t on_its_way(const lode_drive_config_t *config, uint_least8_t failed) {
    rig_t rig;
    rig_init(&rig, &tuning, config);
    rig.motor.theta = CALM_rad;
    rig_command(&rig, run_at(80.0));
    for (int n = 0; n < 20000 && !(rig.drive.mode == (uint_least8_t)LODE_MODE_START &&
                                   rig.drive.state.start.omega_rad_s > 1.0f);
         n++) {
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_START);
    rig.drive.state.start.failed = failed;
    return rig;
}

/// (S36). Where the estimate is sure, and the rotor turns against a vector that does not turn its way, or much faster.
static void test_a_rotor_that_the_load_turns_ends_the_attempt(void) {
    const struct {
        float omega, vector, lock;
        bool ends;
        float most; // speed with which it would not have ended
    } table[] = {
        {-1.3f, 0.0f, 0.9f, true, 0.0f},   {-1.3f, 0.5f, 0.9f, true, 0.0f},
        {-1.3f, -0.1f, 0.9f, false, 0.0f}, {-0.7f, 0.5f, 0.9f, false, 0.0f},
        {-1.3f, 0.5f, 0.5f, false, 0.0f},  {2.3f, 0.5f, 0.9f, true, 2.0f},
        {1.7f, 0.5f, 0.9f, false, 0.0f},   {3.3f, 1.5f, 0.9f, true, 3.0f},
        {2.7f, 1.5f, 0.9f, false, 0.0f},   {-2.3f, -0.5f, 0.9f, true, 0.0f},
        {-1.7f, -0.5f, 0.9f, false, 0.0f}, // given back, and not held
    };
    const lode_drive_config_t config = rig_config();
    for (int n = 0; n < COUNT_OF(table); n++) {
        rig_t rig = on_its_way(&config, 1u);
        const int rounds = (int)tuning.start.lock_rounds;
        const int periods =
            periods_until_it_ends(&rig, table[n].omega, table[n].vector, table[n].lock);
        if (table[n].ends) {
            CHECK_NEAR(3.5, 8.0 * rounds - 3.5,
                       periods); // the last round, wherever the first began
            rig_expect(&rig, LODE_MODE_OFF);
            TEST_ASSERT_EQUAL_UINT(2u, rig.drive.losses);
            const lode_fault_t why = rig_telemetry(&rig).fault;
            const double ready = (double)tuning.start.omega_ready;
            TEST_ASSERT_EQUAL_STRING("LODE_CRITERION_SPEED",
                                     lode_criterion_name((lode_criterion_t)why.criterion));
            CHECK_NEAR(0.2 * ready, (double)table[n].omega * ready, why.measured);
            CHECK_NEAR(0.02 * ready, (double)table[n].most * ready, why.limit);
        } else {
            TEST_ASSERT_EQUAL_INT(0, periods);
        }
    }
}

/// A stop is no attempt.
static void test_a_rotor_that_the_load_turns_does_not_end_a_stop(void) {
    const lode_drive_config_t config = rig_config();
    rig_t rig = on_its_way(&config, 1u);
    rig_command(&rig, run_at(0.0));
    TEST_ASSERT_EQUAL_INT(0, periods_until_it_ends(&rig, -2.3f, 0.5f, 0.9f));
}

/// After the last attempt, and where nobody looks for a rotor that turns, it is a fault.
static void test_a_rotor_that_the_load_turns_on_and_on_is_a_fault(void) {
    for (int catches = 0; catches <= 1; catches++) {
        lode_drive_config_t config = rig_config();
        config.start.catch_s = catches == 1 ? config.start.catch_s : LODE_NONE;
        rig_t rig = on_its_way(&config, catches == 1 ? 3u : 0u);
        CHECK_AT_LEAST(1, periods_until_it_ends(&rig, -2.0f, 0.5f, 0.9f));
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_WRONG_WAY", lode_check_name(fault.check));
        CHECK_CLOSE(0.2, -2.0 * (double)tuning.start.omega_ready, fault.measured);
        CHECK_NEAR(0.0, 0.0, fault.limit);
    }
}

/// A hoist whose brake is open from the beginning: nothing holds its load while the offsets are calibrated.
static void test_a_hoist_with_an_open_brake_is_caught_and_started(void) {
    for (int pull = -4; pull <= 4; pull++) {
        rig_t rig = fresh();
        rig.pull_Nm = (double)pull;
        rig_command(&rig, run_at(60.0));
        rig_run(&rig, 12.0);
        rig_expect(&rig, LODE_MODE_RUN);
        CHECK_NEAR(1.0, 60.0, rig.motor.omega / 3.0);
    }
}

/// A start is proven by a rotor that turns as it is asked to: one that is caught as it turns the other way is still of the same
/// start when it is given back.
static void test_a_rotor_that_turns_the_other_way_has_not_started(void) {
    for (int n = 0; n < 6; n++) {
        const int way = n % 3 - 1; // 0: by so little that it is hardly any
        lode_drive_config_t config = rig_config();
        config.start.pulses = n < 3 ? LODE_AUTO : LODE_OFF; // else it is caught with currents
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        TEST_ASSERT_EQUAL_UINT(n < 3 ? 6u : 0u, tuning.signal_check.pulses); // after those alone
        const double patience = tuning.start.patience_rounds;
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
        rig_run(&rig, 0.15);
        rig.motor.omega = 200.0;
        rig_command(&rig, run_at(way == 0 ? 0.001 : 60.0 * way));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.1));
        rig.drive.losses = 1u;
        CHECK_NEAR(way < 0 ? 1.0 : patience, way < 0 ? 65535.0 : 0.0, rig.drive.state.run.proving);
        rig_run(&rig, 0.5);
        if (way < 0) {
            TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 4.0));
            TEST_ASSERT_EQUAL_UINT(1u, rig.drive.state.start.failed);
        }
    }
}

/// The proof goes on where the rotor comes to turn as commanded without another start.
static void test_a_command_the_other_way_lets_the_proof_begin(void) {
    const lode_drive_config_t config = rig_config();
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    rig_run(&rig, 0.15);
    rig.motor.omega = 200.0;
    rig_command(&rig, run_at(-60.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.1));
    rig_run(&rig, 0.02);
    TEST_ASSERT_EQUAL_UINT(65535u, rig.drive.state.run.proving);
    rig_command(&rig, run_at(60.0));
    rig_run(&rig, 0.01);
    CHECK_NEAR(10.0, (double)tuning.start.patience_rounds, (double)rig.drive.state.run.proving);
    rig_run(&rig, 8.0 * RIG_TS_s * ((double)tuning.start.patience_rounds + 2.0));
    rig_expect(&rig, LODE_MODE_RUN);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.state.run.proving);
}

/// A stop that comes while a rotor is caught is no speed the other way.
static void test_a_rotor_that_is_caught_for_a_stop_has_patience(void) {
    lode_drive_config_t config = rig_config();
    config.start.pulses = LODE_OFF;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    rig_run(&rig, 0.15);
    rig.motor.omega = -200.0;
    rig_command(&rig, run_at(60.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.1));
    rig_command(&rig, run_at(0.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.1));
    TEST_ASSERT_EQUAL_UINT(tuning.start.patience_rounds, rig.drive.state.run.proving);
}

/// The last attempt, repeated, has a ramp of a quarter again.
static void test_the_last_attempt_is_repeated_faster(void) {
    rig_t rig = handed_over();
    const float ease[] = {0.25f, 0.0625f, 0.25f};
    for (unsigned attempt = 1u; attempt <= 3u; attempt++) {
        lose_an_attempt(&rig, attempt);
        TEST_ASSERT_EQUAL_FLOAT(ease[attempt - 1u], lode_start_ease(&rig.drive.state.start));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    }
}

static void test_a_start_that_is_over_is_no_attempt(void) {
    const rig_t rig = handed_over();
    rig_t early = rig;
    rig_run(&early, 0.37);
    (void)steps_until_off(&early, 0.3f, 1.0f, 1000);

    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig_telemetry(&early).mode);
    rig_t late = rig;
    rig_run(&late, 0.4);
    (void)steps_until_off(&late, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&late).fault.check);
    rig_t fast = rig; // any other fault is one
    (void)steps_until_off(&fast, 0.9f, 10.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_FAULT, rig_telemetry(&fast).mode);
}

static void test_a_commanded_off_forgets_the_attempts(void) {
    rig_t rig = handed_over();
    lose_an_attempt(&rig, 1u);
    rig_command(&rig, off);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.01));
    TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
    rig_command(&rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.2));
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.state.start.failed);
    TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
    TEST_ASSERT_EQUAL_INT(LODE_CRITERION_NONE, rig_telemetry(&rig).fault.criterion);
}

/// An attempt that fails in START counts as one that fails after it, and a reversal is another start. Where the last
/// one, repeated, does not come up, that is the end.
static void test_attempts_that_fail_in_the_start_count(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.2));
    rig.drive.state.start.failed = 2u;
    TEST_ASSERT_EQUAL_UINT(2u, rig_telemetry(&rig).retries);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    TEST_ASSERT_EQUAL_UINT(2u, rig_telemetry(&rig).retries);
    rig_t reversed = rig;
    lose_an_attempt(&rig, 3u);
    rig_t stuck = rig;
    stuck.blocked = true;
    TEST_ASSERT_TRUE(reach(&stuck, LODE_MODE_FAULT, 30.0));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&stuck).fault.check);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    (void)steps_until_off(&rig, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&rig).fault.check);
    rig_run(&reversed, 0.5);
    rig_command(&reversed, run_at(-80.0));
    TEST_ASSERT_TRUE(reach(&reversed, LODE_MODE_START, 4.0));
    TEST_ASSERT_TRUE(reach(&reversed, LODE_MODE_RUN, 4.0));
    TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&reversed).retries);
}

/// Given back to the vector before the start is over it is the same start; after, another one.
static void test_a_way_back_before_the_start_is_over_is_of_the_same_start(void) {
    rig_t rig = handed_over();
    lose_an_attempt(&rig, 1u);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    for (int late = 0; late <= 1; late++) {
        rig_t back = rig;
        rig_run(&back, late == 1 ? 0.41 : 0.0);
        rig_expect(&back, LODE_MODE_RUN);
        lode_mode_hand_back(&back.drive);
        TEST_ASSERT_EQUAL_UINT(late == 1 ? 0u : 1u, rig_telemetry(&back).retries);
        TEST_ASSERT_EQUAL_UINT(late == 1 ? 0u : 1u, back.drive.state.start.failed);
    }
}

/// A rotor that pulses have found may be lost as soon.
static void test_a_lock_lost_right_after_the_pulses_is_an_attempt(void) {
    rig_t rig = coasting(80.0);
    run_up(&rig, 80.0, 0.2);
    TEST_ASSERT_TRUE(rig.drive.steps < 3000u); // no start by a vector is so quick
    rig_t late = rig;
    (void)steps_until_off(&rig, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig_telemetry(&rig).mode);
    TEST_ASSERT_EQUAL_UINT(1u, rig_telemetry(&rig).retries);
    rig_run(&late, 0.41);
    (void)steps_until_off(&late, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&late).fault.check);
}

/// A start of a motor with `times` the configured resistance.
static lode_fault_t with_resistance(double times, double theta_rad) {
    rig_t rig = fresh();
    rig.motor.R *= times;
    rig.motor.theta = theta_rad;
    rig_command(&rig, run_at(100.0));
    rig_run(&rig, 2.0);
    return rig_telemetry(&rig).fault;
}

/// Where the rotor came to rest in time: in a third of its positions at least. With one current alone some of it counts as
/// dead time's.
static void test_a_resistance_of_no_winding_ends_the_start(void) {
    int ended = 0;
    for (int k = 0; k < 12; k++) {
        const double theta_rad = (double)k * CHECK_PI / 6.0;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_resistance(1.6, theta_rad).check);
        const lode_fault_t wrong = with_resistance(2.6, theta_rad);
        if (wrong.check != LODE_CHECK_NONE) {
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_RESISTANCE", lode_check_name(wrong.check));
            TEST_ASSERT_EQUAL_INT(LODE_MODE_START, wrong.state);
            CHECK_AT_LEAST(1.2 * 0.75, (double)wrong.measured);
            CHECK_AT_MOST(1.1 * 1.6 * 0.75, (double)wrong.measured);
            CHECK_CLOSE(0.01, 1.2 * 0.75, wrong.limit);
            ended++;
        }
    }
    CHECK_AT_LEAST(4.0, (double)ended);
}

/// Without a correction what dead time takes counts as resistance: 2 us, and 1.5 us that nobody knows, of 200 V at 5 kHz.
static void test_a_dead_time_that_is_not_corrected_is_no_resistance(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.dead_time_correction = LODE_OFF;
    config.inverter.dead_time_s = 2.0e-6f;
    config.inverter.v_drop_V = 0.0f;
    int ended = 0;
    for (int k = 0; k < 12; k++) {
        for (int much = 0; much <= 1; much++) {
            rig_t rig;
            rig_init(&rig, &tuning, &config);
            rig.motor.R *= much > 0 ? 3.4 : 2.6;
            rig.motor.theta = (double)k * CHECK_PI / 6.0;
            rig_command(&rig, run_at(100.0));
            rig_run(&rig, 2.0);
            const lode_fault_t fault = rig_telemetry(&rig).fault;
            if (fault.check == LODE_CHECK_RESISTANCE) {
                TEST_ASSERT_EQUAL_INT(1, much);
                const double lost_Ohm = 4.0 / CHECK_PI * 3.5 / (double)tuning.start.current_A;
                CHECK_CLOSE(0.01, 1.2 * 0.75 + lost_Ohm, fault.limit);
                ended++;
            }
        }
    }
    CHECK_AT_LEAST(4.0, (double)ended);
}

/// A start of which nothing is measured at rest, with sensors that show `gain` of the currents.
static lode_fault_t with_gains(double gain, lode_choice_t plausibility) {
    lode_drive_config_t config = rig_config();
    config.start.signal_check = LODE_OFF; // which finds it before
    config.start.measure = LODE_OFF;
    config.guard.plausibility = plausibility;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(100.0));
    for (int n = 0; n < 7500 && rig_telemetry(&rig).mode != LODE_MODE_FAULT; n++) {
        lode_counts_t counts = rig_counts(&rig);
        for (int k = 0; k < LODE_PHASES; k++) {
            counts.i[k] = rig_count(2048.0 + gain * ((double)counts.i[k] - 2048.0));
        }
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    return rig_telemetry(&rig).fault;
}

/// (S34)
static void test_more_current_than_is_measured_ends_the_start(void) {
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_gains(1.0, LODE_ON).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_gains(0.8, LODE_ON).check);
    const lode_fault_t wrong = with_gains(0.4, LODE_ON);
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_FLUX", lode_check_name(wrong.check));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_START, wrong.state);
    CHECK_AT_LEAST((double)wrong.limit, (double)wrong.measured);
    TEST_ASSERT_NOT_EQUAL(LODE_CHECK_FLUX, with_gains(0.4, LODE_OFF).check);
}

/// How many rounds the vector of a start turns on with the observer's EMF at `times` of what the motor's own flux induces,
/// `off_rad` beside the rotor's q axis, at `share` of the vector's speed, with a d current that leaves `left` of the
/// flux. The check that ended it, or none after 1000.
typedef struct {
    uint32_t rounds;
    lode_check_t check;
} rounds_t;

static rounds_t goes_on_by_flux(rig_t *rig, float times, float off_rad, float share, float left) {
    lode_drive_t *drive = &rig->drive;
    lode_estimator_t *estimator = &drive->estimator;
    const lode_estimator_tuning_t *own = &drive->tuning->estimator;
    const float lock = estimator->lock;
    rounds_t seen = {0u, LODE_CHECK_NONE};
    drive->state.start.omega_rad_s = drive->tuning->start.omega_handover;
    const float omega = share * drive->tuning->start.omega_handover;
    while (drive->mode == (uint_least8_t)LODE_MODE_START && seen.rounds < 1000u) {
        const float e_V = times * own->psi_Wb * omega / (1.0f + omega * omega * own->droop_s2);
        const lode_dq_t at = {-e_V * sinf(off_rad), e_V * cosf(off_rad)};
        estimator->emf.observer.e_V = lode_park_inverse(at, estimator->pll.frame);
        estimator->pll.omega_rad_s = omega;
        estimator->id_A = (left - 1.0f) * own->psi_Wb / own->salient_H;
        estimator->lock = lock;
        drive->steps = (uint32_t)SLOT_LAG;
        lode_mode_follow(drive);
        seen.rounds++;
    }
    seen.check = (lode_check_t)rig_telemetry(rig).fault.check;
    return seen;
}

static rounds_t by_flux(rig_t rig, float times, float off_rad, float share, float left) {
    return goes_on_by_flux(&rig, times, off_rad, share, left);
}

/// (S34): twice the active flux, of which 0.6 of the magnets' is expected at least, for as long as a lock would have to
/// hold, and of a rotor that follows.
static void test_a_flux_of_no_motor_is_one_for_as_long_as_a_lock(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(100.0));
    while (rig.drive.mode != (uint_least8_t)LODE_MODE_START ||
           rig.drive.state.start.stage != (uint_least8_t)LODE_START_TURN) {
        rig_step(&rig);
    }
    const float whole = 1.0f;
    rig.drive.estimator.lock = 0.99f * LODE_LOCK_LOST;
    const rounds_t wrong = by_flux(rig, 2.02f, 0.0f, 1.0f, whole);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, wrong.check);
    TEST_ASSERT_EQUAL_UINT32(tuning.start.lock_rounds, wrong.rounds);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 1.98f, 0.0f, 1.0f, whole).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_flux(rig, 1.42f, 0.0f, 1.0f, 0.7f).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 1.38f, 0.0f, 1.0f, 0.7f).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_flux(rig, 1.22f, 0.0f, 1.0f, 0.2f).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 1.18f, 0.0f, 1.0f, 0.2f).check);
    rig_t locked = rig; // by the next round its lock may have gone
    locked.drive.estimator.lock = LODE_LOCK_LOST;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(locked, 2.2f, 0.0f, 1.0f, whole).check);
    // 25 degrees beside, and a quarter of the speed.
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_flux(rig, 2.2f, 0.44f, 1.0f, whole).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 2.2f, 0.46f, 1.0f, whole).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_flux(rig, 2.2f, 0.0f, 1.24f, whole).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 2.2f, 0.0f, 1.26f, whole).check);
    // It begins anew.
    rig.drive.guard.lock = (uint_least16_t)(tuning.start.lock_rounds - 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, by_flux(rig, 2.2f, 0.0f, 1.0f, whole).rounds);
    rig_t good = rig;
    (void)goes_on_by_flux(&good, 1.0f, 0.0f, 1.0f, whole);
    TEST_ASSERT_EQUAL_UINT32(0u, good.drive.guard.lock);
    TEST_ASSERT_EQUAL_UINT32(tuning.start.lock_rounds,
                             by_flux(good, 2.2f, 0.0f, 1.0f, whole).rounds);
    lode_drive_t *drive = &rig.drive;
    drive->state.start.omega_rad_s = 0.9f * tuning.start.omega_ready;
    drive->steps = (uint32_t)SLOT_LAG;
    lode_mode_follow(drive);
    TEST_ASSERT_EQUAL_UINT32(0u, drive->guard.lock);
}

/// With the winding that is configured, one 30 % warmer and one colder, from 12 rest positions: at least one start in three
/// lets the rotor come to rest in time, and what is measured then is 0.1 of it off, root of the mean square (S30).
static void test_a_resistance_that_is_measured_is_right(void) {
    const double times[] = {0.7, 1.0, 1.3};
    double square = 0.0;
    int measured = 0;
    for (int n = 0; n < 3 * 12; n++) {
        rig_t rig = fresh();
        const double R = rig.motor.R;
        rig.motor.R = times[n / 12] * R;
        rig.motor.theta = (double)(n % 12) * CHECK_PI / 6.0;
        run_up(&rig, 80.0, 8.0);
        const double more = (double)rig.drive.inverter.r_more_Ohm / R;
        if (fabs(more) > 0.0) {
            const double error = more - (times[n / 12] - 1.0);
            square += error * error;
            measured++;
        }
    }
    CHECK_AT_LEAST(12.0, (double)measured);
    CHECK_AT_MOST(0.1, sqrt(square / (double)measured));
}

/// A start in which one phase has no positive current, as with a dead high switch.
static lode_fault_t with_a_dead_switch(int phase, uint32_t noise) {
    lode_drive_config_t config = rig_config();
    config.guard.i_sum_A =
        LODE_NONE; // only the counts are changed here: of a real one the sum is zero
    config.start.signal_check = LODE_OFF; // which finds it before
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(100.0));
    for (int n = 0; n < 10000 && rig_telemetry(&rig).mode != LODE_MODE_RUN; n++) {
        lode_counts_t counts = rig_counts(&rig);
        if (phase >= 0 && counts.i[phase] > 2048u) {
            noise = noise * 1664525u + 1013904223u;
            counts.i[phase] = (uint16_t)(2048u + (noise >> 30)); // 1.1 counts rms
        }
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    return rig_telemetry(&rig).fault;
}

static void test_a_dead_switch_ends_the_start(void) {
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_a_dead_switch(-1, 0u).check);
    for (int n = 0; n < 4 * LODE_PHASES; n++) {
        const int phase = n % LODE_PHASES;
        const lode_fault_t dead = with_a_dead_switch(phase, (uint32_t)n);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE", lode_check_name(dead.check));
        TEST_ASSERT_TRUE(dead.measured == (float)(phase + 1));
        CHECK_NEAR(0.0, 0.0, dead.limit);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_START, dead.state);
    }
}

/// Noise of a count in some phases (a bit each) while the offsets are calibrated.
static lode_telemetry_t with_noise(unsigned noisy) {
    lode_drive_config_t config = rig_config();
    config.sense.i_noise_count = 0.5f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    for (unsigned n = 0; n < 600; n++) {
        lode_counts_t counts = rig_counts(&rig);
        for (unsigned k = 0; k < 3; k++) {
            counts.i[k] = (uint16_t)(counts.i[k] + (noisy >> k & n & 1u));
        }
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    return rig_telemetry(&rig);
}

static void test_a_current_without_its_noise_is_refused_at_calibration(void) {
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, with_noise(7u).mode);
    for (unsigned noisy = 0; noisy < 7; noisy++) {
        const lode_fault_t fault = with_noise(noisy).fault;
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_STUCK", lode_check_name(fault.check));
        TEST_ASSERT_EQUAL_INT(LODE_MODE_CALIBRATE, fault.state);
        const float first = (noisy & 1u) == 0u ? 1.0f : ((noisy & 2u) == 0u ? 2.0f : 3.0f);
        TEST_ASSERT_TRUE(fault.measured == first && fault.limit == 0.0f);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_hand_over_waits_for_the_flux_of_a_salient_rotor);
    RUN_TEST(test_no_jump_at_hand_over);
    RUN_TEST(test_the_vector_of_a_start_is_led_by_one_and_a_half_periods);
    RUN_TEST(test_a_start_has_its_time);
    RUN_TEST(test_a_rotor_that_does_not_follow_is_reported_by_its_emf);
    RUN_TEST(test_a_wrong_psi_is_reported_by_the_lock);
    RUN_TEST(test_a_start_with_too_little_time_tells_where_it_was);
    RUN_TEST(test_a_trip_in_a_start_tells_the_stage);
    RUN_TEST(test_much_resistance_is_corrected_in_part);
    RUN_TEST(test_the_first_vector_leads_the_axis_of_a_salient_rotor);
    RUN_TEST(test_a_rotor_that_turns_already_is_taken_over);
    RUN_TEST(test_pulses_find_a_rotor_that_turns);
    RUN_TEST(test_a_flight_begins_with_the_emf);
    RUN_TEST(test_off_ends_the_pulses);
    RUN_TEST(test_a_start_tries_bridge_and_sensors);
    RUN_TEST(test_a_start_without_its_signal_check_is_reported);
    RUN_TEST(test_swapped_sensors_end_the_start_before_it_begins);
    RUN_TEST(test_bridge_and_sensors_are_tried_without_low_side_pulses);
    RUN_TEST(test_starts_that_try_nothing);
    RUN_TEST(test_duties_of_pulses_stay_in_range);
    RUN_TEST(test_capacitors_are_charged_by_the_pulses_themselves);
    RUN_TEST(test_capacitors_are_charged_after_pulses_that_find_nothing);
    RUN_TEST(test_a_blocked_rotor_ends_in_a_start_fault);
    RUN_TEST(test_a_lock_lost_right_after_the_hand_over_is_an_attempt);
    RUN_TEST(test_gains_are_halved_until_the_drive_is_off);
    RUN_TEST(test_a_start_that_is_given_up_is_over);
    RUN_TEST(test_a_lost_lock_before_the_proof_is_that_of_a_suspected_phase);
    RUN_TEST(test_a_phase_that_seemed_open_is_looked_at_before_the_next_attempt);
    RUN_TEST(test_gains_are_halved_for_a_rotor_that_is_caught_again);
    RUN_TEST(test_all_attempts_of_a_start_have_one_time);
    RUN_TEST(test_a_start_is_proven_to_the_round);
    RUN_TEST(test_a_start_is_repeated_with_hall_switches_only);
    RUN_TEST(test_a_lock_that_is_lost_hides_no_other_fault);
    RUN_TEST(test_a_rotor_that_the_load_turns_ends_the_attempt);
    RUN_TEST(test_a_rotor_that_the_load_turns_does_not_end_a_stop);
    RUN_TEST(test_a_rotor_that_the_load_turns_on_and_on_is_a_fault);
    RUN_TEST(test_a_hoist_with_an_open_brake_is_caught_and_started);
    RUN_TEST(test_a_rotor_that_turns_the_other_way_has_not_started);
    RUN_TEST(test_a_command_the_other_way_lets_the_proof_begin);
    RUN_TEST(test_a_rotor_that_is_caught_for_a_stop_has_patience);
    RUN_TEST(test_the_last_attempt_is_repeated_faster);
    RUN_TEST(test_a_start_that_is_over_is_no_attempt);
    RUN_TEST(test_a_commanded_off_forgets_the_attempts);
    RUN_TEST(test_attempts_that_fail_in_the_start_count);
    RUN_TEST(test_a_way_back_before_the_start_is_over_is_of_the_same_start);
    RUN_TEST(test_a_lock_lost_right_after_the_pulses_is_an_attempt);
    RUN_TEST(test_a_dead_switch_ends_the_start);
    RUN_TEST(test_a_current_without_its_noise_is_refused_at_calibration);
    RUN_TEST(test_a_resistance_of_no_winding_ends_the_start);
    RUN_TEST(test_a_dead_time_that_is_not_corrected_is_no_resistance);
    RUN_TEST(test_more_current_than_is_measured_ends_the_start);
    RUN_TEST(test_a_flux_of_no_motor_is_one_for_as_long_as_a_lock);
    RUN_TEST(test_a_resistance_that_is_measured_is_right);
    return UNITY_END();
}
