#include "app.h"

#include <stddef.h>

#include "board.h"
#include "kept.h"
#include "measure.h"
#include "record.h"
#include "report.h"

#ifdef LODE_MOTOR_H
#include LODE_MOTOR_H
#else
#include "motor.h"
#endif

// What commissioning measures besides the motor's data; optional in the header.
#ifndef MOTOR_LQ_FALL_1_A
#define MOTOR_LQ_FALL_1_A 0.0f
#endif
#ifndef MOTOR_DEAD_TIME_s // that acts; 0: the board's
#define MOTOR_DEAD_TIME_s 0.0f
#endif

#ifndef APP_MODE
#define APP_MODE APP_MODE_OFF
#endif
#ifndef APP_LINK
#define APP_LINK LINK_REPORT
#endif

#ifndef APP_V_BUS_V // a lower nominal bus voltage, for a careful bring-up; 0: the board's
#define APP_V_BUS_V 0.0f
#endif
#ifndef APP_RESTARTS
#define APP_RESTARTS 0u
#endif

#define HARDWARE_TRIP 1.2f   // times the drive's own over-current trip, which shall act first
#define STOPPED_PERIODS 8.0f // periods without an interrupt
#define LOOP_PERIODS 8u      // the telemetry shows a posted command by then
#define RESTART_PAUSE_s 1.0f // lets the cause die down and the rotor slow down
#define RESTART_GOOD_s 60.0f // time in RUN after which the count of restarts is cleared

volatile uint32_t app_mode = APP_MODE;
volatile uint32_t app_armed;
volatile float app_speed_rad_s = MOTOR_SPEED_rad_s;
volatile float app_angle_rad;
volatile float app_turn_rad_s;
volatile uint32_t app_link = APP_LINK;
volatile uint32_t app_trigger = LODE_TRIGGER_FAULT;

// Only the interrupt writes these while periods come.
static lode_drive_t drive;
static volatile bringup_cycles_t cycles;
static volatile bringup_window_t window;
static volatile bool cycles_restart; // set by the thread, cleared by the interrupt
static volatile bool commissions;    // set by the thread: the interrupt calls measure_step()

// Variables of the thread.
static lode_drive_tuning_t tuning[2]; // the second one is for commissioning
static lode_drive_config_t given;     // open values are computed
static lode_drive_config_t config;    // by lode_drive_design()
static lode_status_t status;
static bringup_t bringup;
static bool started;
static uint32_t mode_now = APP_MODE_OFF;
static uint32_t mode_waiting; // waits for app_armed, and has been reported
static uint32_t steps_seen;
static uint32_t seen_at; // board_cycles() at that time
static lode_supervisor_config_t reactions;
static lode_supervisor_t supervisor;
static uint32_t supervised_at; // steps
static lode_command_t posted;
static bool faulted;
static uint_least16_t told; // lode_telemetry_t.trips of the last fault
static bool stopped;        // by a fault, until armed again
static bool resumes;        // armed before the watchdog's reset

static void note_cycles(uint32_t entered) {
    if (cycles_restart) {
        cycles = (bringup_cycles_t){
            .work_min = UINT32_MAX, .interval_min = UINT32_MAX, .first = entered};
        cycles_restart = false;
    } else {
        const uint32_t interval = entered - cycles.last;
        cycles.interval_min = interval < cycles.interval_min ? interval : cycles.interval_min;
        cycles.interval_max = interval > cycles.interval_max ? interval : cycles.interval_max;
    }
    cycles.last = entered;
    cycles.periods++;
    const uint32_t work = board_cycles() - entered;
    cycles.work_min = work < cycles.work_min ? work : cycles.work_min;
    cycles.work_max = work > cycles.work_max ? work : cycles.work_max;
}

LODE_RAMFUNC void app_period(void) {
    const uint32_t entered = board_cycles();
    lode_counts_t counts;
    board_read(&counts);
    const lode_drive_out_t out =
        commissions ? measure_step(&counts) : lode_drive_step(&drive, &counts);
    board_write(&out);

    record_period(&drive);
    bringup_window_take(&window, &counts, out.duty);
    note_cycles(entered);
}

// Each fault is followed by a new start, as often as APP_RESTARTS allows. So is a reset by the watchdog, if the
// motor was armed and starts remain. Otherwise the user must arm.
static lode_status_t start_supervisor(bool by_watchdog) {
    const lode_telemetry_t off = {.mode = LODE_MODE_OFF};
    reactions = (lode_supervisor_config_t){
        .attempts = APP_RESTARTS, .wait_s = RESTART_PAUSE_s, .good_s = RESTART_GOOD_s};
    for (uint32_t n = 0u; n < (uint32_t)LODE_CHECK_COUNT; n++) {
        reactions.reaction[n] = LODE_REACTION_AGAIN;
    }
    const lode_status_t done =
        lode_supervisor_init(&supervisor, &reactions, &tuning[0], kept_attempts(), by_watchdog);
    resumes = done == LODE_OK && by_watchdog && kept_was_armed() &&
              app_mode == APP_MODE_APPLICATION && !lode_supervisor_is_latched(&supervisor, &off);
    app_armed = resumes ? 1u : 0u;
    return done;
}

static lode_status_t init_drive(void) {
    config = given;
    lode_drive_design(&config);
    return lode_drive_init(&drive, &tuning[0], &config);
}

bool app_start(void) {
    board_gates_off();
    started = false;
    commissions = false;
    app_armed = 0u;
    mode_now = APP_MODE_OFF;
    mode_waiting = APP_MODE_OFF;
    stopped = false;
    resumes = false;
    const bool by_watchdog = board_reset_by_watchdog();
    const uint32_t resets = kept_watchdog_resets(by_watchdog);
    if (resets > 0u) {
        report_event("START", "WATCHDOG_RESETS", resets);
    }
    given = (lode_drive_config_t){.f_pwm_Hz = 0.0f};
    board_describe(&given);
    given.motor = motor_data();
    given.references.Lq_fall = MOTOR_LQ_FALL_1_A;
    if (MOTOR_DEAD_TIME_s > 0.0f) {
        given.inverter.dead_time_s = MOTOR_DEAD_TIME_s;
    }
    if (APP_V_BUS_V > 0.0f && APP_V_BUS_V < given.inverter.v_bus_V) {
        given.inverter.v_bus_V = APP_V_BUS_V; // the guard's limits are shares of it
        report_event("START", "LOW_BUS", (uint32_t)APP_V_BUS_V);
    }
    given.inverter.i_max_A = lode_min(given.inverter.i_max_A, MOTOR_I_MAX_A);
    status = init_drive();
    if (status == LODE_OK) {
        status = record_init(config.f_pwm_Hz);
    }
    if (status == LODE_OK) {
        status = start_supervisor(by_watchdog);
    }
    const bool up = board_init(
        HARDWARE_TRIP *
        config.guard.i_trip_A); // a refused configuration is also reported over its serial port
    if (status != LODE_OK || !up) {
        board_gates_off();
        report_event("START FAIL", status != LODE_OK ? lode_status_name(status) : "BOARD", 0u);
        return false;
    }
    bringup = (bringup_t){.drive = &drive, .config = &config, .window = &window};
    cycles_restart = true;
    board_start();
    started = true;
    return true;
}

lode_motor_t app_motor(void) {
    return config.motor;
}

LODE_RAMFUNC const lode_drive_t *app_drive(void) {
    return &drive;
}

lode_status_t app_status(void) {
    return status;
}

bringup_result_t app_result(void) {
    return bringup.result;
}

bringup_cycles_t app_cycles(void) {
    return (bringup_cycles_t){.work_min = cycles.work_min,
                              .work_max = cycles.work_max,
                              .interval_min = cycles.interval_min,
                              .interval_max = cycles.interval_max,
                              .first = cycles.first,
                              .last = cycles.last,
                              .periods = cycles.periods};
}

lode_telemetry_t app_telemetry(void) {
    lode_telemetry_t now;
    while (!lode_drive_telemetry(&drive, &now)) { // an interrupt in each of three tries
    }
    return now;
}

static void post(lode_command_t command) {
    posted = command;
    (void)lode_drive_post_command(&drive, &command);
}

// The user has armed, or switched off.
static void forget_restarts(const lode_telemetry_t *now) {
    const lode_command_t clear = {.mode = LODE_MODE_OFF, .clear_fault = true};
    (void)lode_supervisor_step(&supervisor, now, clear, 0.0f);
}

static void begin_commissioning(void) {
    commissions = true; // gates off until it has begun
    LODE_SIGNAL_FENCE();
    bringup.result = (bringup_result_t){.mode = APP_MODE_COMMISSION};
    const bool begun = measure_begin(&drive, tuning, &given); // its result says why not
    LODE_SIGNAL_FENCE();
    commissions = begun; // otherwise the drive is as it was
}

// The drive begins anew, with what has been measured.
static void end_commissioning(void) {
    const lode_drive_config_t *found = measure_config();
    measure_end();
    if (found != NULL) {
        given = *found;
    }
    status = init_drive();
    LODE_SIGNAL_FENCE();
    commissions = false;
}

static void begin_mode(uint32_t mode, const lode_telemetry_t *now) {
    if (commissions) {
        end_commissioning();
    }
    mode_now = mode;
    mode_waiting = APP_MODE_OFF;
    if (!resumes) {
        forget_restarts(now);
    }
    resumes = false;
    faulted = false;
    stopped = false;
    supervised_at = app_telemetry().steps; // by the next pass an earlier fault is cleared
    posted = (lode_command_t){.mode = LODE_MODE_OFF};
    cycles_restart = true;
    (void)board_clear_trip();
    bringup.speed_rad_s = app_speed_rad_s;
    bringup.angle_rad = app_angle_rad;
    bringup.turn_rad_s = app_turn_rad_s;
    record_arm(app_trigger == (uint32_t)LODE_TRIGGER_IMMEDIATE ? LODE_TRIGGER_IMMEDIATE
                                                               : LODE_TRIGGER_FAULT);
    bringup_begin(&bringup, mode < (uint32_t)BRINGUP_COUNT ? (bringup_mode_t)mode : BRINGUP_NONE);
    if (mode == APP_MODE_COMMISSION) {
        begin_commissioning();
    }
}

static void note_fault(const lode_telemetry_t *now) {
    const bool before = faulted && told == now->trips;
    faulted = now->mode == LODE_MODE_FAULT;
    told = now->trips;
    if (faulted && !before) {
        stopped = lode_supervisor_is_latched(&supervisor, now);
        app_armed = stopped ? 0u : app_armed;
        report_event("FAULT", lode_check_name((lode_check_t)now->fault.check), now->fault.check);
    }
}

static bool is_posted(const lode_command_t *command) {
    return command->mode == posted.mode && command->clear_fault == posted.clear_fault &&
           command->active_short == posted.active_short &&
           !(lode_abs(command->speed_rad_s - posted.speed_rad_s) > 0.0f);
}

// A fault is cleared only after the hardware trip; if the trip is still active the start has failed.
static void run_application(const lode_telemetry_t *now) {
    const uint32_t periods = now->steps - supervised_at;
    if (periods < LOOP_PERIODS) {
        return;
    }
    supervised_at = now->steps;
    note_fault(now);
    const lode_command_t wanted = {.mode = LODE_MODE_RUN, .speed_rad_s = app_speed_rad_s};
    const lode_command_t command =
        lode_supervisor_step(&supervisor, now, wanted, (float)periods / config.f_pwm_Hz);
    if (!is_posted(&command) && (!command.clear_fault || board_clear_trip())) {
        post(command);
    }
}

// A stopped interrupt lets the watchdog expire; the gates are switched off before that.
static void supervise(uint32_t steps) {
    const float patience = STOPPED_PERIODS * config.guard.stamp_per_period; // 0: no time base
    if (steps != steps_seen) {
        steps_seen = steps;
        seen_at = board_cycles();
        board_feed_watchdog();
    } else if (patience > 0.0f && (float)(board_cycles() - seen_at) > patience) {
        board_gates_off();
    }
}

// A mode that switches runs only while armed.
static void wait_for_arming(uint32_t mode, const lode_telemetry_t *now) {
    if (mode_now != APP_MODE_OFF) {
        begin_mode(APP_MODE_OFF, now);
    }
    if (mode_waiting != mode) {
        mode_waiting = mode;
        report_event("WAIT", "ARM", mode);
    }
}

// The gates go on only after a successful test of the trip path.
static void begin_if_safe(uint32_t mode, const lode_telemetry_t *now) {
    if (mode >= (uint32_t)BRINGUP_SIGNS && !board_test_trip()) {
        app_armed = 0u;
        report_event("FAIL", "TRIP_PATH", mode);
        return;
    }
    begin_mode(mode, now);
}

static void step_mode(uint32_t mode, const bringup_view_t *view) {
    app_armed = mode == APP_MODE_OFF ? 0u : app_armed;
    const bool armed = mode < (uint32_t)BRINGUP_SIGNS || app_armed != 0u;
    if (armed && (mode != mode_now || stopped)) {
        begin_if_safe(mode, &view->now);
    } else if (!armed && !stopped) {
        wait_for_arming(mode, &view->now);
    } else if (mode_now == APP_MODE_APPLICATION) {
        run_application(&view->now);
    } else if (mode_now == APP_MODE_COMMISSION) {
        bringup.result = measure_poll();
    } else if (mode_now > 0u && mode_now < (uint32_t)BRINGUP_COUNT) {
        (void)bringup_step(&bringup, view);
    }
}

void app_poll(void) {
    if (!started) {
        report_poll(&bringup.result);
        return;
    }
    const bringup_view_t view = {.now = app_telemetry(), .cycles = app_cycles()};
    supervise(view.now.steps);
    step_mode(app_mode, &view);
    kept_note_armed(app_armed != 0u && mode_now == APP_MODE_APPLICATION);
    if (!record_poll((link_t)app_link)) {
        report_poll(&bringup.result);
    }
}
