#include "measure.h"

#include <stddef.h>

#include "app.h"
#include "report.h"

static const lode_drive_out_t off = {{0.0f, 0.0f, 0.0f}, LODE_GATES_OFF};

#if !defined LODE_WITHOUT_COMMISSIONING && !defined APP_WITHOUT_COMMISSIONING

// The lines of the motor file, in the tool's units.
typedef struct {
    const char *section; // where one begins
    const char *key;
    size_t field; // of lode_drive_config_t, a float
    lode_commission_quantity_t quantity;
} row_t;

#define ROW(section, key, field, quantity)                                                         \
    { section, key, offsetof(lode_drive_config_t, field), LODE_COMMISSION_##quantity }

static const row_t rows[] = {
    ROW("[motor]", "pole_pairs", motor.pole_pairs, QUANTITIES),
    ROW(NULL, "Rs_Ohm", motor.Rs_Ohm, RS_Ohm),
    ROW(NULL, "Ld_H", motor.Ld_H, LD_H),
    ROW(NULL, "Lq_H", motor.Lq_H, LQ_H),
    ROW(NULL, "psi_Wb", motor.psi_Wb, PSI_Wb),
    ROW(NULL, "J_kgm2", motor.J_kgm2, J_kgm2),
    ROW(NULL, "B_Nms", motor.B_Nms, B_Nms),
    ROW("[drive]", "dead_time_s", inverter.dead_time_s, DEAD_V),
    ROW("[references]", "Lq_fall", references.Lq_fall, LQ_FALL_1_A),
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static lode_commission_t commission;
static volatile bool ready; // set by the thread: the interrupt uses `commission`
static uint32_t rows_sent;
static bool section_sent;
static bool ended; // the thread has seen and checked the result

lode_drive_out_t measure_step(const lode_counts_t *counts) {
    return ready ? lode_commission_step(&commission, counts) : off;
}

bool measure_begin(lode_drive_t *drive, lode_drive_tuning_t tuning[2],
                   const lode_drive_config_t *given) {
    measure_end();
    rows_sent = 0u;
    section_sent = false;
    ended = false;
    const lode_status_t status = lode_commission_init(&commission, drive, tuning, given);
    if (status != LODE_OK) {
        commission = (lode_commission_t){.result = LODE_COMMISSION_REFUSED, .status = status};
        return false;
    }
    LODE_SIGNAL_FENCE();
    ready = true;
    return true;
}

void measure_end(void) {
    ready = false;
    LODE_SIGNAL_FENCE();
}

const lode_drive_config_t *measure_config(void) {
    return ended && commission.result == LODE_COMMISSION_DONE ? lode_commission_config(&commission)
                                                              : NULL;
}

// A line per pass.
static void send_row(const row_t *row) {
    if (row->section != NULL && !section_sent) {
        report_line(row->section);
        section_sent = true;
        return;
    }
    const char *config = (const char *)measure_config();
    const float *value = (const float *)(const void *)(config + row->field);
    const bool given = row->quantity == LODE_COMMISSION_QUANTITIES;
    report_setting(row->key, *value,
                   given ? REPORT_GIVEN : commission.found[row->quantity].confidence);
    section_sent = false;
    rows_sent++;
}

static bringup_result_t failed(bringup_reason_t reason, float measured, float limit) {
    return (bringup_result_t){.mode = APP_MODE_COMMISSION,
                              .state = (uint_least8_t)BRINGUP_FAIL,
                              .reason = (uint_least8_t)reason,
                              .measured = measured,
                              .limit = limit};
}

static bringup_result_t fault(void) {
    const lode_fault_t *cause = &commission.drive->guard.fault;
    bringup_result_t result = failed(BRINGUP_FAULT, cause->measured, cause->limit);
    result.check = cause->check;
    return result;
}

static bringup_result_t result_now(void) {
    const uint32_t quantity = (uint32_t)commission.quantity;
    const bool counted = quantity < (uint32_t)LODE_COMMISSION_QUANTITIES;
    switch (commission.result) {
    case LODE_COMMISSION_FAULT:
        return fault();
    case LODE_COMMISSION_UNSURE:
        return failed(BRINGUP_UNSURE, counted ? commission.found[quantity].confidence : 0.0f,
                      LODE_COMMISSION_SURE);
    case LODE_COMMISSION_NO_CURRENT:
        return failed(BRINGUP_NO_CURRENT, commission.reached_A, commission.current_A);
    case LODE_COMMISSION_UNSETTLED:
        return failed(BRINGUP_UNSETTLED, 0.0f, 0.0f);
    case LODE_COMMISSION_REFUSED:
        return failed(BRINGUP_REFUSED, (float)(int32_t)commission.status, 0.0f);
    case LODE_COMMISSION_NO_START:
        return failed(BRINGUP_NO_START, commission.reached_rad_s, commission.wanted_rad_s);
    case LODE_COMMISSION_RUNNING:
    case LODE_COMMISSION_DONE:
    default:
        return (bringup_result_t){.mode = APP_MODE_COMMISSION,
                                  .state = (uint_least8_t)(commission.result == LODE_COMMISSION_DONE
                                                               ? BRINGUP_PASS
                                                               : BRINGUP_RUNNING)};
    }
}

// The library has checked what was measured at standstill; here the drive says whether it takes all of it.
static void check_whole(void) {
    lode_drive_tuning_t *unused =
        &commission.tuning[commission.drive->tuning == &commission.tuning[0] ? 1 : 0];
    commission.designed = commission.config;
    lode_drive_design(&commission.designed);
    commission.status = lode_drive_tune(unused, &commission.designed);
    if (commission.status != LODE_OK) {
        commission.result = LODE_COMMISSION_REFUSED;
    }
}

static void tell_why(void) {
    if (commission.result == LODE_COMMISSION_UNSURE) {
        report_event("UNSURE", lode_commission_name(commission.quantity),
                     (uint32_t)commission.quantity);
    } else if (commission.result == LODE_COMMISSION_NO_START &&
               !lode_guard_is_good(&commission.drive->guard)) {
        const uint32_t check = commission.drive->guard.fault.check;
        report_event("NO_START", lode_check_name((lode_check_t)check), check);
    } else if (commission.result == LODE_COMMISSION_REFUSED) {
        report_event("REFUSED", lode_status_name(commission.status), (uint32_t)commission.status);
    }
}

bringup_result_t measure_poll(void) {
    if (ready) {
        (void)lode_commission_work(&commission);
    }
    if (!ended && commission.result != LODE_COMMISSION_RUNNING) {
        ended = true;
        if (commission.result == LODE_COMMISSION_DONE) {
            check_whole();
        }
        tell_why();
    }
    if (commission.result == LODE_COMMISSION_DONE && rows_sent < (uint32_t)ROWS &&
        report_is_sent()) {
        send_row(&rows[rows_sent]);
    }
    return result_now();
}

#else

lode_drive_out_t measure_step(const lode_counts_t *counts) {
    (void)counts;
    return off;
}

bool measure_begin(lode_drive_t *drive, lode_drive_tuning_t tuning[2],
                   const lode_drive_config_t *given) {
    (void)drive;
    (void)tuning;
    (void)given;
    return false;
}

void measure_end(void) {}

const lode_drive_config_t *measure_config(void) {
    return NULL;
}

bringup_result_t measure_poll(void) {
    return (bringup_result_t){.mode = APP_MODE_COMMISSION,
                              .state = (uint_least8_t)BRINGUP_FAIL,
                              .reason = (uint_least8_t)BRINGUP_REFUSED};
}

#endif
