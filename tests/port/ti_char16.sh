#!/usr/bin/env bash
# What a C28x would break, with its 16-bit char and int: the core is checked by gates of its own
# (tests/tools/char16_*.sh); these are the F28004x port, the example application and, against a blind
# checker, two breaches that must be found.
set -eu
ports=(port/common/*.c port/ti/*.c port/ti_f28004x/*.c port/example/*.c)
includes=(-Iinclude -Iport -Iport/common -Iport/ti -Iport/ti_f28004x -Iport/example -Itests/port/fakes/ti)
command -v clang >/dev/null || { echo "skipped: no clang"; exit 77; }
int16() {
    clang --target=msp430 -std=c99 -ffreestanding -fsyntax-only -Wall -Wextra -Wconversion \
        -Wshift-overflow -Wconstant-conversion -Werror \
        -isystem tests/tools/freestanding "${includes[@]}" "$@"
}
int16 "${ports[@]}" src/*.c

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
echo '#include <stdint.h>
uint32_t f(void); uint32_t f(void) { return 1 << 20; }' >"$work/shift.c"
if int16 "$work/shift.c" 2>/dev/null; then echo "a shift beyond 16 bits: expected to be found"; exit 1; fi

# No type of exactly eight bits, no bit-fields (unlike '? :'), no size in octets; sizeof only as a number
# of elements.
breaches() {
    sed 's://.*::' "$@" | grep -nE '\b(u?int8_t|memcpy|memset)\b|:[[:space:]]*[0-9]+u?;|sizeof' |
        grep -vE 'sizeof ([a-z_]+) / sizeof \1\[0\]|\?'
}
if breaches "${ports[@]}" port/common/*.h port/ti/*.h port/ti_f28004x/*.h port/ti_f28004x/boards/*.h port/example/*.h \
    port/board.h; then
    echo "expected nothing of the above"
    exit 1
fi
echo 'struct { unsigned low : 8; };' >"$work/field.c"
if ! breaches "$work/field.c" >/dev/null; then echo "a bit-field: expected to be found"; exit 1; fi

command -v cppcheck >/dev/null || { echo "no cppcheck: checked with clang only"; exit 0; }
char16() {
    cppcheck --quiet --std=c99 --platform=tests/tools/char16.xml --enable=warning,portability \
        --inline-suppr --error-exitcode=1 --suppress=missingIncludeSystem "${includes[@]}" "$@"
}
char16 -D__TMS320C28XX__ "${ports[@]}" src
