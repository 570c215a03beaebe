/// board.h with the simulated plant instead of ADCs and PWM.
#include "board.h"

#include "app.h"
#include "emulator.h"
#include "judge.h"
#include "machine.h"
#include "plant.h"
#include "semihost.h"

#define LOAD_Nm 2.0f      // from the start on: two fifths of rated
#define OVERLONG_AT 7000u // well in RUN
#define OVERLONG_STAMP (5u * PLANT_STAMP_PER_PERIOD / 2u)

static plant_t plant;
static lode_drive_out_t written;
static bool overlong;
static uint32_t periods;

void emulator_overlong(void) {
    overlong = true;
}

void board_describe(lode_drive_config_t *config) {
    plant_describe(config);
}

bool board_reset_by_watchdog(void) {
    return false;
}

bool board_init(float i_trip_A) {
    (void)i_trip_A;
    plant_init(&plant);
    plant.load_Nm = LOAD_Nm;
    return true;
}

void board_start(void) {
    machine_start();
}

// Longer than two periods: the tick after the pending one is lost.
static void linger(void) {
    const uint32_t since = machine_stamp();
    while (machine_stamp() - since < OVERLONG_STAMP) {
    }
}

void emulator_period(void) {
    app_period();
    const lode_telemetry_t now = app_telemetry();
    judge_note(&plant, &now);
    plant_period(&plant, &written);
    periods++;
    if (overlong && periods == OVERLONG_AT) {
        linger();
    }
}

void board_read(lode_counts_t *counts) {
    *counts = plant_counts(&plant);
    counts->stamp = board_cycles();
}

void board_write(const lode_drive_out_t *out) {
    written = *out;
}

void board_gates_off(void) {
    written.gates = false;
}

bool board_clear_trip(void) {
    return true;
}

bool board_test_trip(void) {
    return true;
}

void board_feed_watchdog(void) {}

uint32_t board_cycles(void) {
    return machine_stamp();
}

uint32_t board_send(const uint16_t *octets, uint32_t count) {
    for (uint32_t k = 0u; k < count; k++) {
        const char text[2] = {(char)octets[k], '\0'};
        semihost_print(text);
    }
    return count;
}
