#!/bin/sh
# Every observer of the table can be left out of the build, and all but the first together, without a
# warning;
# what is left out is not in the object.
set -eu
root=${LODE_SOURCE_DIR:?}
object=$(mktemp)
said=$(mktemp)
trap 'rm -f "$object" "$said"' EXIT
rows=$(sed -n 's/^LODE_OBSERVER(\([A-Z_]*\), \([a-z_]*\), .*/\1:\2/p' "$root/include/lodestar/observers.def")
build() {
    ${CC:-cc} -std=c99 -O2 -fno-inline -Wall -Wextra -Wconversion -Werror -I"$root/include" "$@" \
        -c "$root/src/observer.c" -o "$object"
}
has() {
    nm "$object" | grep -Eq " [tTW] (lode_)?$1(_|$)"
}
absent() {
    if has "$1"; then
        echo "$1 is still in the object built with $2"
        exit 1
    fi
}
all=
count=0
build
for row in $rows; do
    has "${row#*:}" || { echo "${row#*:} is not found where it should be"; exit 1; }
done
for row in $rows; do
    build "-DLODE_WITHOUT_${row%:*}"
    absent "${row#*:}" "LODE_WITHOUT_${row%:*}"
    count=$((count + 1))
    [ $count = 1 ] || all="$all -DLODE_WITHOUT_${row%:*}"
done
[ $count -ge 4 ] || { echo "only $count observers found in the table"; exit 1; }
# shellcheck disable=SC2086 # a list of options
build $all
for row in $(echo "$rows" | tail -n +2); do
    absent "${row#*:}" "all options but the first"
done

# The same for every other option; init or lode_drive_post_command() says so.
sources() {
    ${CC:-cc} -std=c99 -O0 -Wall -Wextra -Wconversion -Werror -ffp-contract=off -fno-math-errno \
        -I"$root/include" "$@" -x c - "$root"/src/*.c -lm -o "$object" << 'END'
#include "lodestar/supervisor.h"
#include <stdio.h>
static lode_drive_t drive;
static lode_drive_tuning_t tuning;
static void say(const char *what, lode_drive_config_t config) {
    printf("%s %s\n", what, lode_status_name(lode_drive_init(&drive, &tuning, &config)));
}
static void post(lode_mode_t mode) {
    const lode_command_t command = {.mode = mode};
    printf("%d %s\n", (int)mode, lode_status_name(lode_drive_post_command(&drive, &command)));
}
int main(void) {
    lode_drive_config_t config = {
        .f_pwm_Hz = 20e3f,
        .motor = {.pole_pairs = 4.0f, .Rs_Ohm = 0.05f, .Ld_H = 1e-4f, .Lq_H = 2e-4f, .psi_Wb = 0.02f, .J_kgm2 = 1e-4f},
        .inverter = {.v_bus_V = 48.0f, .i_max_A = 20.0f},
        .sense = {.i_gain_A_count = 0.02f, .i_offset_count = 2048.0f, .v_bus_gain_V_count = 0.02f}};
    say("plain", config);
    config.references.kind = LODE_REFERENCES_MTPA;
    say("mtpa", config);
    config.references.field_weakening = LODE_ON;
    say("weakening", config);
    config.references = (lode_references_config_t){.v_regen_V = 50.0f};
    say("regen", config);
    config.references = (lode_references_config_t){.kind = LODE_REFERENCES_ID0};
    config.estimator.notch12_k = 0.5f;
    say("notch", config);
    config.estimator.notch12_k = 0.0f;
    config.sense.duty_max = 0.9f;
    say("window", config);
    config.sense.duty_max = 1.0f;
    config.sense.shunts = LODE_SHUNTS_TWO;
    say("shunts", config);
    config.sense.shunts = LODE_SHUNTS_THREE;
    config.guard.plausibility = LODE_ON;
    say("plausibility", config);
    config.guard.plausibility = LODE_AUTO;
    config.guard.bus_still_s = 0.1f;
    say("still", config);
    config.guard.bus_still_s = 0.0f;
    config.guard.overload_s = 0.1f;
    say("overload", config);
    config.guard.overload_s = 0.0f;
    config.guard.flux_share = 0.3f;
    say("flux", config);
    config.guard.flux_share = 0.0f;
    config.guard.check_stuck = LODE_ON;
    say("stuck", config);
    config.guard.check_stuck = LODE_AUTO;
    config.guard.check_gain = LODE_ON;
    say("gain", config);
    config.guard.check_gain = LODE_AUTO;
    config.guard.check_half_waves = LODE_ON;
    say("half-waves", config);
    config.guard.check_half_waves = LODE_AUTO;
    config.inverter.precharge_s = 0.01f;
    say("precharge", config);
    config.inverter.precharge_s = 0.0f;
    config.start.measure = LODE_ON;
    say("measurement", config);
    config.start.measure = LODE_AUTO;
    config.start.pulses = LODE_ON;
    say("pulses", config);
    config.start.pulses = LODE_AUTO;
    config.start.signal_check = LODE_ON;
    say("signals", config);
    config.start.signal_check = LODE_AUTO;
    config.speed.every_period = LODE_ON;
    say("fast", config);
    config.speed.every_period = LODE_AUTO;
    config.speed.ramp_down_rad_s2 = 100.0f;
    say("down", config);
    config.speed.ramp_down_rad_s2 = 0.0f;
    config.speed.jerk_rad_s3 = 1e6f;
    say("jerk", config);
    config.speed.jerk_rad_s3 = 0.0f;
    config.hfi.mode = LODE_HFI_ON;
    say("hfi", config);
    const lode_command_t torque = {.mode = LODE_MODE_RUN, .control = LODE_CONTROL_TORQUE};
    printf("torque %s\n", lode_status_name(lode_drive_post_command(&drive, &torque)));
    const lode_supervisor_config_t shorts = {.active_short = LODE_ON};
    lode_attempts_t attempts = {.count = 0u};
    lode_supervisor_t supervisor;
    lode_drive_tuning_t strong = tuning;
    strong.references.i_max_A = 1000.0f;
    printf("short %s\n", lode_status_name(lode_supervisor_init(&supervisor, &shorts, &strong, &attempts, false)));
    post(LODE_MODE_VOLTAGE);
    post(LODE_MODE_CURRENT);
    post(LODE_MODE_CALIBRATE);
    return 0;
}
END
}
# What is refused by the build with the options $1, of all that the program tries.
refuses() {
    # shellcheck disable=SC2086 # a list of options
    sources $1
    "$object" > "$said"
    refused=$(sed -n '/ LODE_OK$/!p' "$said" | tr '\n' ' ')
    [ "$refused" = "$2" ] || { echo "built with '$1', refused: $refused, expected: $2"; exit 1; }
    [ "$(grep -c . "$said")" = 27 ] || { echo "built with '$1', the program says:"; cat "$said"; exit 1; }
}
references=LODE_ERROR_REFERENCES
window=LODE_ERROR_SENSE_WINDOW
command=LODE_ERROR_COMMAND
weakening="weakening $references "
optimal="mtpa $references weakening $references regen $references "
notch="notch LODE_ERROR_NOTCH "
phases="window $window shunts $window "
plausibility="plausibility LODE_ERROR_CHOICE still LODE_ERROR_GUARD_TIME overload LODE_ERROR_GUARD_TIME \
flux LODE_ERROR_GUARD_FLUX stuck LODE_ERROR_CHOICE gain LODE_ERROR_CHOICE half-waves LODE_ERROR_CHOICE "
injection="hfi LODE_ERROR_HFI_MODE "
precharge="precharge LODE_ERROR_PRECHARGE "
signals="signals LODE_ERROR_CHOICE "
pulses="pulses LODE_ERROR_CHOICE $signals"
measurement="measurement LODE_ERROR_CHOICE "
fast="fast LODE_ERROR_SPEED_BANDWIDTH "
shaped="down LODE_ERROR_SPEED_RAMP jerk LODE_ERROR_SPEED_RAMP "
torque="torque $command "
short="short LODE_ERROR_ACTIVE_SHORT "
vectors="2 $command 3 $command "
refuses "" ""
refuses -DLODE_WITHOUT_FIELD_WEAKENING "$weakening"
refuses -DLODE_WITHOUT_OPTIMAL_REFERENCES "$optimal"
absent lode_references_optimal LODE_WITHOUT_OPTIMAL_REFERENCES
refuses -DLODE_WITHOUT_NOTCH "$notch"
refuses -DLODE_WITHOUT_SHUNT_WINDOW "$phases"
refuses -DLODE_WITHOUT_COMMISSIONING "$vectors"
absent lode_commission_step LODE_WITHOUT_COMMISSIONING
absent lode_commission6_step LODE_WITHOUT_COMMISSIONING
refuses -DLODE_WITHOUT_PLAUSIBILITY "$plausibility"
absent lode_drive_suspect LODE_WITHOUT_PLAUSIBILITY
refuses "-DLODE_WITHOUT_PRECHARGE -DLODE_WITHOUT_START_MEASUREMENT" "$precharge$measurement$pulses"
absent lode_start_measure LODE_WITHOUT_START_MEASUREMENT
refuses -DLODE_WITHOUT_FLYING_START "$pulses"
absent lode_fly_step LODE_WITHOUT_FLYING_START
refuses -DLODE_WITHOUT_SIGNAL_CHECK "$signals"
absent lode_signal_check_step LODE_WITHOUT_SIGNAL_CHECK
refuses "-DLODE_WITHOUT_FAST_SPEED -DLODE_WITHOUT_TORQUE_CONTROL -DLODE_WITHOUT_ANGLE_SENSOR" "$fast$torque"
absent lode_speed_torque_target LODE_WITHOUT_TORQUE_CONTROL
refuses -DLODE_WITHOUT_SHAPED_RAMP "$shaped"
absent lode_speed_shaped_step LODE_WITHOUT_SHAPED_RAMP
refuses -DLODE_WITHOUT_HFI "$injection"
absent lode_mode_inject LODE_WITHOUT_HFI
refuses -DLODE_WITHOUT_TUNING_CHECK ""
refuses -DLODE_WITHOUT_ACTIVE_SHORT "$short"
least="-DLODE_WITHOUT_OPTIMAL_REFERENCES -DLODE_WITHOUT_NOTCH -DLODE_WITHOUT_SHUNT_WINDOW -DLODE_WITHOUT_PLAUSIBILITY -DLODE_WITHOUT_TUNING_CHECK -DLODE_WITHOUT_COMMISSIONING -DLODE_WITHOUT_HFI -DLODE_WITHOUT_PRECHARGE -DLODE_WITHOUT_START_MEASUREMENT -DLODE_WITHOUT_FAST_SPEED -DLODE_WITHOUT_TORQUE_CONTROL -DLODE_WITHOUT_ANGLE_SENSOR -DLODE_WITHOUT_ACTIVE_SHORT -DLODE_WITHOUT_TORQUE_LIMITS -DLODE_WITHOUT_BRAKE_SLIP -DLODE_WITHOUT_GENTLE_START -DLODE_WITHOUT_SHAPED_RAMP -DLODE_WITHOUT_HANDOVER_RETRY"
refuses "$least$all" "$optimal$notch$phases$plausibility$precharge$measurement$pulses$fast$shaped$injection$torque$short$vectors"

# LODE_SMALL is a matter of size alone: the same periods to the bit.
periods() {
    ${CC:-cc} -std=c99 -O2 -ffp-contract=off -fno-math-errno -I"$root/include" -I"$root/src" "$@" \
        "$root"/tests/bench/record.c "$root"/tests/bench/record6.c "$root"/tests/bench/motor.c \
        "$root"/tests/bench/drives.c "$root"/tests/bench/drives6.c "$root"/src/*.c -lm -o "$object"
    "$object" > "$said" || exit 1
    cksum < "$said"
}
plain=$(periods)
small=$(periods -DLODE_SMALL)
[ "$plain" = "$small" ] || { echo "LODE_SMALL does something else"; exit 1; }
has pll_gains || { echo "LODE_SMALL makes no functions of what is shared"; exit 1; }
unwatched=$(periods -DLODE_WITHOUT_TUNING_CHECK)
[ "$plain" = "$unwatched" ] || { echo "LODE_WITHOUT_TUNING_CHECK does something else"; exit 1; }
# Off, injection changes nothing.
off=$(periods -DBENCH_WITHOUT_INJECTING)
without=$(periods -DBENCH_WITHOUT_INJECTING -DLODE_WITHOUT_HFI)
[ "$off" = "$without" ] || { echo "LODE_WITHOUT_HFI does something else to a drive that does not inject"; exit 1; }
