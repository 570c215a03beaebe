#include "lodestar/lodestar.h"

static lode_drive_tuning_t tuning;
static lode_drive_t drive;

/// Links with the library: an empty configuration is refused, and the refusal has a name.
int main(void) {
    const lode_drive_config_t config = {0};
    const lode_status_t status = lode_drive_init(&drive, &tuning, &config);
    return status == LODE_ERROR_F_PWM && lode_status_name(status)[0] != 0 ? 0 : 1;
}
