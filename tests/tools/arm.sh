#!/usr/bin/env bash
# usage: arm.sh FLAGS...: the core compiles without a warning for the cores it is meant for, calls
# no double-precision helper and nothing of libm but sqrtf.
set -eu -o pipefail
. tests/tools/sources.sh
command -v arm-none-eabi-gcc >/dev/null || { echo "skipped: no arm-none-eabi-gcc"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
code=0
while read -r name flags; do
    mkdir "$work/$name"
    for source in "${sources[@]}"; do
        # shellcheck disable=SC2086
        arm-none-eabi-gcc $flags -std=c99 -O2 -Wall -Wextra -Wconversion -Wdouble-promotion -Werror \
            "$@" -Iinclude -Isrc -c "$source" -o "$work/$name/$(basename "$source" .c).o" || code=1
    done
    wrong=$(arm-none-eabi-nm -A -u "$work/$name"/*.o | sed "s|^$work/||" | grep -vE \
        ' U (lode_[A-Za-z0-9_]+|sqrtf|memcpy|memset|__aeabi_(f(add|sub|rsub|mul|div|cmp(eq|lt|le|ge|gt|un)|2iz|2uiz)|(i|ui|l|ul)2f|f2lz|f2ulz|u?idiv(mod)?|u?ldivmod|lmul|llsl|llsr|lasr|memcpy4?|memset|memclr4?|memclr)|__gnu_thumb1_case_[a-z0-9]+)$' || true)
    if [ -n "$wrong" ]; then
        printf '%s: expected no call but to single-precision helpers and sqrtf, found\n%s\n' "$name" "$wrong"
        code=1
    fi
    echo "$name: $(arm-none-eabi-size -t "$work/$name"/*.o | awk 'END { print $1 " B text, " $2 + $3 " B static data" }')"
done <<'CORES'
cortex-m0 -mcpu=cortex-m0 -mthumb -mfloat-abi=soft
cortex-m3 -mcpu=cortex-m3 -mthumb -mfloat-abi=soft
cortex-m4f -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard
cortex-m7 -mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard
cortex-m33 -mcpu=cortex-m33 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard
cortex-r5f -mcpu=cortex-r5 -marm -mfpu=vfpv3-d16 -mfloat-abi=hard
CORES
exit $code
