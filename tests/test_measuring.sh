#!/usr/bin/env bash
# The code of docs/measuring.md: run against stand-ins of the registers, compiled for the cores it is for.
set -eu -o pipefail
root=${LODE_SOURCE_DIR:?}
here=$root/tests/measuring
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $1"
    exit 1
}
# The page's blocks of C, in order.
awk -v work="$work" 'BEGIN { split("cortex_m c28x cortex_r5f collect more", name) }
    /^```c$/ { n++; inside = 1; next }
    /^```$/ { inside = 0 }
    inside { print > (work "/" name[n] ".h") }' "$root/docs/measuring.md"
if [ ! -f "$work/collect.h" ] || [ -f "$work/more.h" ]; then
    fail "docs/measuring.md: expected four blocks of C"
fi
common=(-std=c99 -Wall -Wextra -Wconversion -Wsign-conversion -Werror -I"$root/include" -I"$here" -I"$work")

for registers in cortex_m c28x; do
    cc "${common[@]}" "-D${registers^^}" "-DCOUNTER=\"$registers.h\"" "$here/host.c" \
        -o "$work/host" || fail "$registers: does not compile"
    "$work/host" >"$work/said" || fail "$registers: $(cat "$work/said")"
    echo "$registers: on stand-ins"
done

if command -v clang >/dev/null; then # a machine with an int of 16 bits
    clang --target=msp430 -ffreestanding -fsyntax-only "${common[@]}" \
        -I"$root/tests/tools/freestanding" -DC28X '-DCOUNTER="c28x.h"' "$here/target.c" || fail "C28x: does not compile"
else
    echo "no clang: the 16-bit compile is left out"
fi
gcc=arm-none-eabi-gcc
if ! command -v $gcc >/dev/null || ! echo '#include <math.h>' | $gcc -E -xc - >/dev/null 2>&1; then
    echo "no $gcc with its library: the target compiles are left out"
    exit 0
fi
for core in 3 4 7 33; do
    $gcc "${common[@]}" -O2 "-mcpu=cortex-m$core" -mthumb -DCORTEX_M "-D__CORTEX_M=${core}U" \
        '-DCOUNTER="cortex_m.h"' -c "$here/target.c" -o "$work/m.o" || fail "Cortex-M$core: does not compile"
    unlocks=0
    ! arm-none-eabi-objdump -d "$work/m.o" | grep -i c5acce55 >/dev/null || unlocks=1
    [ $unlocks = $((core == 7)) ] || fail "Cortex-M$core: the key to the lock is for the M7 alone"
done
r5f=(-mcpu=cortex-r5 -marm -mfpu=vfpv3-d16 -mfloat-abi=hard '-DCOUNTER="cortex_r5f.h"' -O2)
$gcc "${common[@]}" "${r5f[@]}" -c "$here/target.c" -o "$work/r5f.o" || fail "Cortex-R5F: does not compile"
echo "compiled for Cortex-M3, M4, M7, M33, R5F"
if ! command -v qemu-system-arm >/dev/null; then
    echo "no qemu-system-arm: the R5F's counter is left out"
    exit 0
fi
$gcc "${common[@]}" "${r5f[@]}" -nostdlib -Wl,-Ttext=0,--section-start=.start=0x8000,-e,_start "$here/r5f.c" \
    -o "$work/r5f.elf" || fail "Cortex-R5F: does not link"
timeout 60 qemu-system-arm -M none -cpu cortex-r5f -m 16M -display none -monitor none -serial none \
    -semihosting-config enable=on,target=native -icount shift=6,sleep=off \
    -device "loader,file=$work/r5f.elf,cpu-num=0" || fail "Cortex-R5F: its counter in the emulator"
echo "cortex_r5f: in the emulator"
