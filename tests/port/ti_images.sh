#!/usr/bin/env bash
# The AM263x as a complete image for the Cortex-R5F: linked from this tree alone, its vectors at the reset
# address, the interrupt in tightly coupled memory; prints the sizes. The F28004x port compiles with gcc
# through CMake, and is refused without TI's headers. Runs at the project's root.
set -eu -o pipefail
for tool in arm-none-eabi-gcc cmake ninja python3; do
    command -v "$tool" >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
echo '#include <math.h>' | arm-none-eabi-gcc -E -x c - >/dev/null 2>&1 ||
    { echo "skipped: no C library for arm-none-eabi-gcc (libnewlib-arm-none-eabi)"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
log=$work/build.log

r5() { # r5 FOLDER OPTION...
    cmake -G Ninja -S . -B "$work/$1" -DCMAKE_TOOLCHAIN_FILE=port/cmake/arm-none-eabi.cmake \
        -DLODE_CORE=cortex-r5f -DLODE_PORT=ti_am263x "${@:2}" >"$log" 2>&1 && ninja -C "$work/$1" >>"$log" 2>&1 ||
        { cat "$log"; exit 1; }
}
r5 debug -DCMAKE_BUILD_TYPE=Debug # links
r5 r5 -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2
elf=$work/r5/port/ti_am263x/lodestar_am263x.elf
arm-none-eabi-size -A "$elf" | awk '
    { size[$1] = $2 }
    END { printf "ti_am263x: code and constants %d B, of it in tightly coupled memory %d B; RAM %d B with %d B of stack\n",
              size[".vectors"] + size[".hot"] + size[".text"] + size[".ARM.exidx"], size[".vectors"] + size[".hot"],
              size[".data"] + size[".bss"] + size[".stack"], size[".stack"] }'
arm-none-eabi-readelf -h -A "$elf" >"$work/head"
for wanted in "hard-float ABI" "Tag_CPU_arch: v7$" "Tag_CPU_arch_profile: Realtime"; do
    grep -q "$wanted" "$work/head" || { cat "$work/head"; echo "expected '$wanted'"; exit 1; }
done
arm-none-eabi-nm "$elf" >"$work/symbols"
tcm() { # tcm SYMBOL: below 32 KB
    grep -Eq "^0000[0-7][0-9a-f]{3} . $1\$" "$work/symbols" ||
        { grep " $1\$" "$work/symbols"; echo "$1: expected in TCMA"; exit 1; }
}
grep -q "^00000000 . vectors$" "$work/symbols" || { echo "vectors: expected at 0"; exit 1; }
for symbol in irq_entry irq_handler app_period lode_drive_step board_write chip_pwm_off; do
    tcm "$symbol"
done

. tests/port/kept.sh
kept "$elf"

# The F28004x's memories, and a checker that is not blind: TI's generic file, which gives .bss and the
# code in RAM one block each, must fail.
arm-none-eabi-size -A "$elf" >"$work/sizes"
cmd=port/ti_f28004x/f28004x.cmd
python3 tests/port/check_cmd.py "$cmd" "$work/sizes"
for breach in 's/\(RAMLS .*length = \)0x004000/\10x000800/' 's/\(RAMGS01 .*length = \)0x004000/\10x000800/' \
    's/stack_size=0x600/stack_size=0x800/' 's/\(RAMM .*length = \)0x000702/\10x00070A/' '/\.TI\.noinit/d'; do
    sed "$breach" "$cmd" >"$work/breach.cmd"
    cmp -s "$cmd" "$work/breach.cmd" && { echo "$breach: expected to change $cmd"; exit 1; }
    if python3 tests/port/check_cmd.py "$work/breach.cmd" "$work/sizes" >/dev/null 2>&1; then
        echo "$breach: expected to be found"
        exit 1
    fi
done

# The stand-ins have no code, so the F28004x is compiled but not linked.
f28004x() {
    cmake -G Ninja -S . -B "$work/c28x" -DCMAKE_BUILD_TYPE=Release -DLODE_PORT=ti_f28004x \
        -DLODE_C2000WARE_DIR="$1" >"$log" 2>&1
}
if f28004x /nowhere || ! grep -q "expected driverlib.h" "$log"; then
    cat "$log"
    echo "a folder without TI's headers: expected a refusal that names driverlib.h"
    exit 1
fi
f28004x "$PWD/tests/port/fakes/ti" || { cat "$log"; exit 1; }
objects=$work/c28x/port/ti_f28004x/CMakeFiles/lodestar_f28004x.dir
for file in board pwm analog startup; do
    echo "port/ti_f28004x/CMakeFiles/lodestar_f28004x.dir/$file.c.o"
done | xargs ninja -C "$work/c28x" >"$log" 2>&1 || { cat "$log"; exit 1; }
[ -f "$objects/board.c.o" ]

# The start-up code in qemu: a Cortex-R5F with nothing but RAM, 2 GB so that registers are there too. They
# read back what was written; only the trip flags are preset. The image must get through board_init() and
# board_start(): watchdog on, the three ePWM clocked.
command -v qemu-system-arm >/dev/null || { echo "no qemu-system-arm: the image was linked only"; exit 0; }
preset=()
for pwm in 0 1 2; do preset+=(-device "loader,addr=0x5000${pwm}126,data=4,data-len=2"); done
{ sleep 2; echo 'xp /1xw 0x52100090'; echo 'xp /1xw 0x502F0010'; echo q; } |
    timeout 30 qemu-system-arm -M none -cpu cortex-r5f -m 2048M -display none -serial none -monitor stdio \
        -device "loader,file=$elf,cpu-num=0" "${preset[@]}" >"$work/qemu.log" 2>&1 || true
for wanted in "52100090: 0xa98559da" "502f0010: 0x00000007"; do
    grep -q "$wanted" "$work/qemu.log" || { cat "$work/qemu.log"; echo "expected '$wanted'"; exit 1; }
done
echo "cortex-r5f: start-up, board_init() and board_start() pass on registers of RAM"
