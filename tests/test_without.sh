#!/bin/sh
# Every observer of the table can be left out of the build, and all but the first together, without a
# warning;
# what is left out is not in the object.
set -eu
root=${LODE_SOURCE_DIR:?}
object=$(mktemp)
trap 'rm -f "$object"' EXIT
rows=$(sed -n 's/^LODE_OBSERVER(\([A-Z_]*\), \([a-z_]*\), .*/\1:\2/p' "$root/include/lodestar/observers.def")
build() {
    ${CC:-cc} -std=c99 -O2 -fno-inline -Wall -Wextra -Wconversion -Werror -I"$root/include" "$@" \
        -c "$root/src/observer.c" -o "$object"
}
has() {
    nm "$object" | grep -Eq " [tT] (lode_)?$1_"
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

# The same for what the references and the notches are made of; init says so.
sources() {
    ${CC:-cc} -std=c99 -O2 -Wall -Wextra -Wconversion -Werror -ffp-contract=off -fno-math-errno \
        -I"$root/include" "$@" -x c - "$root"/src/*.c -lm -o "$object" << 'END'
#include "lodestar/drive.h"
#include <stdio.h>
static void say(const char *what, lode_drive_config_t config) {
    lode_drive_t drive;
    lode_drive_tuning_t tuning;
    printf("%s %s\n", what, lode_status_name(lode_drive_init(&drive, &tuning, &config)));
}
int main(void) {
    lode_drive_config_t config = {
        .f_pwm_Hz = 10e3f,
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
    return 0;
}
END
}
says() { # option, expected lines
    sources ${1:+"$1"}
    said=$("$object" | tr '\n' ' ')
    [ "$said" = "$2 " ] || { echo "built with '$1': $said, expected $2"; exit 1; }
}
no=LODE_ERROR_REFERENCES
says "" "plain LODE_OK mtpa LODE_OK weakening LODE_OK regen LODE_OK notch LODE_OK"
says -DLODE_WITHOUT_FIELD_WEAKENING "plain LODE_OK mtpa LODE_OK weakening $no regen LODE_OK notch LODE_OK"
says -DLODE_WITHOUT_OPTIMAL_REFERENCES "plain LODE_OK mtpa $no weakening $no regen $no notch LODE_OK"
absent lode_references_optimal LODE_WITHOUT_OPTIMAL_REFERENCES
says -DLODE_WITHOUT_NOTCH "plain LODE_OK mtpa LODE_OK weakening LODE_OK regen LODE_OK notch LODE_ERROR_NOTCH"
