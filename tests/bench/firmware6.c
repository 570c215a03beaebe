/// As firmware.c, for six phases.
#include "lodestar/lodestar.h"

lode_drive6_t firmware_drive;
lode_drive6_tuning_t firmware_tuning;
lode_drive6_config_t firmware_config; // in RAM, so that nothing is computed by the compiler
lode_command_t firmware_command;
lode_telemetry6_t firmware_telemetry;
lode_counts6_t firmware_counts;
lode_drive6_out_t firmware_out;

void firmware_interrupt(void);
int firmware(void);

void firmware_interrupt(void) {
    firmware_out = lode_drive6_step(&firmware_drive, &firmware_counts);
}

int firmware(void) {
    const lode_status_t initialised =
        lode_drive6_init(&firmware_drive, &firmware_tuning, &firmware_config);
    const lode_status_t posted = lode_drive_post_command(&firmware_drive.drive, &firmware_command);
    const bool whole = lode_drive6_telemetry(&firmware_drive, &firmware_telemetry);
    return initialised == LODE_OK && posted == LODE_OK && whole ? 0 : 1;
}
