/// The application: one drive on one board. Nothing here knows which board.
///
/// The variable app_mode selects the action, set in a debugger or with -DAPP_MODE=n at build time. app_result()
/// has the result. Nothing switches until app_armed is set.
#ifndef LODESTAR_PORT_APP_H
#define LODESTAR_PORT_APP_H

#include "bringup.h"
#include "lodestar/lodestar.h"

/// Values of app_mode in addition to those of bringup_mode_t (1 .. 7).
#define APP_MODE_OFF 0u
#define APP_MODE_APPLICATION 8u ///< turn at app_speed_rad_s
/// Measure motor and inverter, measure.h; the shaft must be free. Once it has passed, all modes use the measured values until
/// the next reset.
#define APP_MODE_COMMISSION 9u

extern volatile uint32_t app_mode;
/// The modes that switch the gates, 3 .. 9, wait until this is not 0, and end when it is 0 again. It is 0 after
/// a reset, with mode 0, and after a fault in the mode "application" that is not restarted: then only the user
/// starts the motor again. With -DAPP_RESTARTS=n, n faults and resets by the watchdog in a row are
/// followed by a new start of that mode.
extern volatile uint32_t app_armed;
/// Mechanical rad/s for the modes "run" and "application"; 0 stops.
extern volatile float app_speed_rad_s;
/// Angle of the vector in the modes "voltage" and "current", electrical rad; read when the mode begins.
extern volatile float app_angle_rad;
/// Electrical speed at which that vector turns, rad/s.
extern volatile float app_turn_rad_s;

/// Data on the serial port: link_t of record.h.
extern volatile uint32_t app_link;
/// Trigger of the scope from the next start of a mode on: LODE_TRIGGER_FAULT or
/// LODE_TRIGGER_IMMEDIATE.
extern volatile uint32_t app_trigger;

/// Configures board and drive and starts the periods. Thread, once, first of all. False: app_status() names the
/// wrong field, or is LODE_OK and the board failed to start. Gates and watchdog stay off permanently, and
/// app_poll() only sends the line that reports this.
bool app_start(void);

/// One pass of the main loop, without waiting: watchdog, mode, faults. Thread, as often as possible and at
/// least once within the watchdog's time.
void app_poll(void);

/// Status of lode_drive_init().
lode_status_t app_status(void);
/// Result of the last bring-up mode, or of the mode "commission".
bringup_result_t app_result(void);
/// The drive's telemetry of the last period.
lode_telemetry_t app_telemetry(void);
/// Duration of the periods since app_start() or the last start of a mode.
bringup_cycles_t app_cycles(void);

#endif
