#!/usr/bin/env bash
# The RP2350 as a complete image for the Cortex-M33: linked from this tree alone, with what the boot ROM looks
# for in the first 4 KB, the interrupt in SRAM; prints the sizes. A Debug build links too. A driver without one
# of its three protections, one with bootstrap capacitors, two calls in a period and a wrong core are refused.
# Runs at the project's root.
set -eu -o pipefail
for tool in arm-none-eabi-gcc cmake ninja; do
    command -v "$tool" >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
echo '#include <math.h>' | arm-none-eabi-gcc -E -x c - >/dev/null 2>&1 ||
    { echo "skipped: no C library for arm-none-eabi-gcc (libnewlib-arm-none-eabi)"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
log=$work/build.log
configure() { # configure OPTION...
    rm -f "$work/m33/CMakeCache.txt"
    cmake -G Ninja -S . -B "$work/m33" -DCMAKE_TOOLCHAIN_FILE=port/cmake/arm-none-eabi.cmake \
        -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2 -DLODE_PORT=rp2350 "$@" >"$log" 2>&1
}

configure -DLODE_CORE=cortex-m33 && ninja -C "$work/m33" >>"$log" 2>&1 || { cat "$log"; exit 1; }
if grep -i 'warning' "$log"; then
    echo "expected no warning"
    exit 1
fi
elf=$work/m33/port/rp2350/lodestar_rp2350.elf
arm-none-eabi-size -A "$elf" | awk '
    { size[$1] = $2 }
    END { printf "rp2350: flash %d B, of it run from SRAM %d B; RAM %d B with %d B of stack\n",
              size[".vectors"] + size[".text"] + size[".ARM.exidx"] + size[".hot"] + size[".data"], size[".hot"],
              size[".hot"] + size[".data"] + size[".bss"] + size[".stack"], size[".stack"] }'
# The five words that make it a program, behind the vectors; the first vector is the top of the stack.
arm-none-eabi-objcopy -O binary --only-section=.vectors "$elf" "$work/vectors.bin"
[ "$(od -A n -t x4 -j 272 -N 20 "$work/vectors.bin" | xargs)" = "ffffded3 10210142 000001ff 00000000 ab123579" ] ||
    { od -A d -t x4 "$work/vectors.bin"; echo "expected the image definition behind 68 vectors"; exit 1; }
[ "$(od -A n -t x4 -N 4 "$work/vectors.bin" | xargs)" = 20080000 ] || { echo "expected the stack's end"; exit 1; }
arm-none-eabi-nm "$elf" >"$work/symbols"
for symbol in adc_fifo_handler app_period board_read board_write lode_drive_step chip_gates_off \
    port_sequential_read; do
    grep -Eq "^2000[0-9a-f]{4} . $symbol\$" "$work/symbols" || { echo "$symbol: expected in SRAM"; exit 1; }
done

. tests/port/kept.sh
kept "$elf"

configure -DLODE_CORE=cortex-m33 -DCMAKE_BUILD_TYPE=Debug && ninja -C "$work/m33" >>"$log" 2>&1 || { cat "$log"; exit 1; }

refused() { # refused EDIT WHY: the example header, edited, does not compile
    sed "$1" port/rp2350/boards/generic_rp2350.h >"$work/board.h"
    cmp -s "$work/board.h" port/rp2350/boards/generic_rp2350.h && { echo "$1: nothing edited"; exit 1; }
    configure -DLODE_CORE=cortex-m33 -DLODE_BOARD="$work/board.h" || { cat "$log"; exit 1; }
    if ninja -C "$work/m33" port/rp2350/CMakeFiles/lodestar_rp2350.dir/driver.c.obj >"$log" 2>&1 ||
        ! grep -q "$2" "$log"; then
        echo "$1: expected a refusal, '$2'"
        exit 1
    fi
}
for protection in INTERLOCK DEAD_TIME LATCHED_TRIP; do
    refused "s/\(VARIANT_DRIVER_$protection \)1/\10/" "interlock, dead time and latched over-current"
done
refused 's/\(#define VARIANT_F_PWM_Hz .*\)/\1\n#define VARIANT_PRECHARGE_s 10.0e-3f/' "take a driver with a charge pump"
refused 's/\(#define VARIANT_F_PWM_Hz .*\)/\1\n#define VARIANT_DOUBLE_UPDATE true/' "no VARIANT_DOUBLE_UPDATE"
if configure || ! grep -q "expected cortex-m33" "$log"; then
    echo "another core: expected a refusal that names cortex-m33"
    exit 1
fi
