/// The smallest firmware around one drive, to see what it takes of flash and RAM. Never run.
#include "lodestar/lodestar.h"

lode_drive_t firmware_drive;
#ifdef FIRMWARE_TUNING_IN_FLASH // as `lodestar design --c` writes one; what it says does not matter here
const lode_drive_tuning_t firmware_tuning = {.estimator.pll.ts_s = 1.0e-4f};
#else
lode_drive_tuning_t firmware_tuning;
#endif
lode_drive_config_t firmware_config; // in RAM, so that nothing is computed by the compiler
lode_command_t firmware_command;
lode_telemetry_t firmware_telemetry;
lode_counts_t firmware_counts;
lode_drive_out_t firmware_out;

// By their addresses, or -flto would make them a part of the function here, which is not counted.
static lode_status_t (*volatile firmware_begin)(lode_drive_t *,
                                                const lode_drive_tuning_t *) = lode_drive_begin;
static lode_status_t (*volatile firmware_post)(lode_drive_t *,
                                               const lode_command_t *) = lode_drive_post_command;
static lode_drive_out_t (*volatile firmware_step)(lode_drive_t *,
                                                  const lode_counts_t *) = lode_drive_step;
static bool (*volatile firmware_read)(const lode_drive_t *,
                                      lode_telemetry_t *) = lode_drive_telemetry;

void firmware_interrupt(void);
int firmware(void);

void firmware_interrupt(void) {
    firmware_out = firmware_step(&firmware_drive, &firmware_counts);
}

int firmware(void) {
#ifdef FIRMWARE_TUNING_IN_FLASH
    const lode_status_t initialised = LODE_OK;
    firmware_begin(&firmware_drive, &firmware_tuning);
#else
    const lode_status_t initialised =
        lode_drive_init(&firmware_drive, &firmware_tuning, &firmware_config);
#endif
    const lode_status_t posted = firmware_post(&firmware_drive, &firmware_command);
    const bool whole = firmware_read(&firmware_drive, &firmware_telemetry);
    return initialised == LODE_OK && posted == LODE_OK && whole ? 0 : 1;
}
