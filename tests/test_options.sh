#!/bin/sh
# A program and a library with different options do not link (include/lodestar/options.h): every option that changes
# a public header changes the names of the functions that begin a drive, and no other option does.
set -eu
root=${LODE_SOURCE_DIR:?}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

fail() { echo "$*"; exit 1; }
compiled() { ${CC:-cc} -std=c99 -Wall -Wextra -Wpedantic -Werror -ffp-contract=off -fno-math-errno \
    -I"$root/include" "$@"; }
# The headers as a program sees them with some options, but for the names in question; these follow MARK.
seen() { compiled "$@" -E -P -x c - -o "$folder/raw" << 'END' && sed '/^MARK/!s/\(lode_[a-z0-9_]*_\(init\|begin\)\)_no_[a-z_]*/\1/g' "$folder/raw"
#include "lodestar/lodestar.h"
MARK lode_drive_begin
MARK lode_drive_init
MARK lode_drive6_begin
MARK lode_drive6_init
#ifndef LODE_WITHOUT_COMMISSIONING
MARK lode_commission_init
MARK lode_commission6_init
#endif
END
}
observers=" $(sed -n 's/^LODE_OBSERVER(\([A-Z_]*\), .*/LODE_WITHOUT_\1/p' "$root/include/lodestar/observers.def" | tr '\n' ' ')"
options=$({
    grep -oh 'LODE_WITHOUT_[A-Z0-9_]*[A-Z0-9]' "$root"/src/*.[ch] "$root"/include/lodestar/*.h
    printf '%s\n' $observers
} | sort -u)

# One option at a time, however it is defined. A name and the headers that it stands for make a line.
seen > "$folder/plain"
grep -v ^MARK "$folder/plain" > "$folder/plain_headers"
count=0
for option in $options; do
    for value in "" =1 =0 =; do
        case $observers:$value in *" $option "*:=0 | *" $option "*:=)
            ! seen "-D$option$value" > "$folder/now" 2>&1 || fail "$option$value is no error"
            continue ;;
        esac
        seen "-D$option$value" > "$folder/now"
        grep -v ^MARK "$folder/now" > "$folder/headers"
        plain=$(grep ^MARK "$folder/now" | grep -cxFf "$folder/plain" || true)
        if cmp -s "$folder/headers" "$folder/plain_headers"; then
            [ "$plain" = 6 ] || fail "$option$value changes no header, but a name"
        else
            [ "$plain" = 0 ] || fail "$option$value changes a header, but not all names"
            count=$((count + 1))
        fi
        grep -h '^MARK lode_drive_init' "$folder/now" | tr '\n' ' ' >> "$folder/names"
        cksum < "$folder/headers" >> "$folder/names"
    done
done
[ $count -ge 50 ] || fail "only $count options and values change a header"
twice=$(sort -u "$folder/names" | cut -d' ' -f2 | uniq -d)
[ -z "$twice" ] || fail "the same name for several forms of the headers: $twice"

# The compiler and the linker agree: same options link, others do not.
program='#include "lodestar/lodestar.h"
static lode_drive_t drive;
static lode_drive_tuning_t tuning;
int main(void) {
    const lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    return lode_drive_init(&drive, &tuning, &config) == LODE_ERROR_F_PWM ? 0 : 1;
}'
library() { # folder, options...
    mkdir "$folder/$1"
    at=$folder/$1
    shift
    for source in "$root"/src/*.c; do
        compiled "$@" -O0 -c "$source" -o "$at/$(basename "$source" .c).o"
    done
    ar rcs "$at/lodestar.a" "$at"/*.o
}
linked() { # folder, options...
    at=$folder/$1
    shift
    printf '%s\n' "$program" | compiled "$@" -x c - -x none "$at/lodestar.a" -lm -o "$at/program" 2> "$folder/said"
}
library all
library less -DLODE_WITHOUT_HFI -DLODE_WITHOUT_R_LESO
linked all || fail "does not link: $(cat "$folder/said")"
"$folder/all/program" || fail "does not run"
linked less -DLODE_WITHOUT_HFI -DLODE_WITHOUT_R_LESO || fail "does not link with the same options: $(cat "$folder/said")"
"$folder/less/program" || fail "does not run with options"
for options in "-DLODE_WITHOUT_HFI" "-DLODE_WITHOUT_HFI -DLODE_WITHOUT_R_LESO -DLODE_WITHOUT_NOTCH" ""; do
    # shellcheck disable=SC2086 # a list of options
    ! linked less $options || fail "links with a library of other options: '$options'"
    grep -q "undefined reference to .lode_drive_init" "$folder/said" || fail "expected lode_drive_init in $(cat "$folder/said")"
done
echo "$count options and values change a header and the names"
