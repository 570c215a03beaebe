#!/usr/bin/env bash
# Complete images for Arm: the STM32 boards and the template link, and the STM32F405's starts in qemu,
# where two bring-up steps pass. Prints the sizes. Runs at the project's root.
set -eu -o pipefail
for tool in arm-none-eabi-gcc cmake ninja; do
    command -v "$tool" >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
echo '#include <math.h>' | arm-none-eabi-gcc -E -x c - >/dev/null 2>&1 ||
    { echo "skipped: no C library for arm-none-eabi-gcc (libnewlib-arm-none-eabi)"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# build FOLDER OPTION...: configures and builds; false where it fails, with the log in $log. What shares
# a folder shares the core's objects.
log=$work/build.log
build() {
    local folder=$work/$1
    shift
    rm -f "$folder/CMakeCache.txt" # CMake warns of a toolchain file that it is told again
    cmake -G Ninja -S . -B "$folder" -DCMAKE_TOOLCHAIN_FILE=port/cmake/arm-none-eabi.cmake \
        -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2 \
        -DLODE_CMSIS_DIR="$PWD/tests/port/fakes" "$@" >"$log" 2>&1 &&
        ninja -C "$folder" >>"$log" 2>&1
}
must_build() { build "$@" || { cat "$log"; exit 1; }; }

# sections NAME ELF: the columns of arm-none-eabi-size.
sections() {
    arm-none-eabi-size "$2" |
        awk -v name="$1" 'NR == 2 { print name ": text " $1 ", data " $2 ", bss " $3 }'
}
# Flash holds code, constants and what is copied to RAM; .bss, .data and stack are RAM.
sizes() {
    sections "$@"
    arm-none-eabi-size -A "$2" | awk -v name="$1" '
        { size[$1] = $2 }
        END { printf "%s: flash %d B, of it run from fast memory %d B; RAM %d B with %d B of stack\n",
                  name, size[".vectors"] + size[".text"] + size[".ARM.exidx"] + size[".ccmram"] + size[".data"],
                  size[".ccmram"], size[".bss"] + size[".data"] + size[".stack"], size[".stack"] }'
}

. tests/port/kept.sh
boards=(generic_g431_link b_g431b_esc1 nucleo_ihm16m1)
for board in "${boards[@]}"; do
    must_build g4 -DLODE_PORT=stm32g4 -DLODE_BOARD="$board" # with the step in the CCM SRAM
    sizes "$board" "$work/g4/port/stm32g4/lodestar_stm32g4.elf"
    if grep -i 'warning' "$log"; then
        echo "expected no warning"
        exit 1
    fi
done
# Bootstrap capacitors behind a driver that makes its low sides itself could not be charged.
sed 's/\(#define VARIANT_LOW_SIDES false\).*/\1\n#define VARIANT_PRECHARGE_s 10.0e-3f/' \
    port/stm32g4/boards/nucleo_ihm16m1.h >"$work/bootstrap.h"
if build g4 -DLODE_PORT=stm32g4 -DLODE_BOARD="$work/bootstrap.h" || ! grep -q "no VARIANT_PRECHARGE_s" "$log"; then
    echo "bootstrap capacitors without low sides: expected a refusal that names VARIANT_PRECHARGE_s"
    exit 1
fi
# Two calls in a period: one shunt has no time for it, and the emulated board no turning points.
refused_double() { # refused_double FOLDER BOARD OPTION...
    sed 's/\(#define VARIANT_F_PWM_Hz .*\)/\1\n#define VARIANT_DOUBLE_UPDATE true/' "$2" >"$work/double.h"
    if build "$1" -DLODE_BOARD="$work/double.h" "${@:3}" || ! grep -q "no VARIANT_DOUBLE_UPDATE" "$log"; then
        echo "$2 ${*:3}: expected a refusal that names VARIANT_DOUBLE_UPDATE"
        exit 1
    fi
}
refused_double g4 port/stm32g4/boards/generic_g431_link.h -DLODE_PORT=stm32g4
refused_double f4 port/stm32f4/boards/generic_f405.h -DLODE_PORT=stm32f4 -DLODE_EMULATED=ON
must_build g4 -DLODE_PORT=stm32g4 -DLODE_BOARD=nucleo_ihm16m1
kept "$work/g4/port/stm32g4/lodestar_stm32g4.elf"
must_build g4 -DLODE_PORT=stm32g4 -DLODE_CORDIC=ON
sizes "nucleo_ihm16m1 with CORDIC" "$work/g4/port/stm32g4/lodestar_stm32g4.elf"
# The larger chip has room for every observer and for signal injection in its fast memory.
must_build g474 -DLODE_PORT=stm32g4 -DLODE_CHIP=g474 -DLODE_BOARD=nucleo_ihm16m1 -DLODE_OTHER_OBSERVERS=ON -DLODE_HFI=ON
sizes "g474, all observers, injection" "$work/g474/port/stm32g4/lodestar_stm32g4.elf"
if build refused_chip -DLODE_PORT=stm32g4 -DLODE_CHIP=g999 || ! grep -q "expected g431 or g474" "$log"; then
    echo "a chip that is none: expected a refusal that names g431 and g474"
    exit 1
fi
# The STM32H7: the step in the ITCM, at no address 0, data and stack in the DTCM.
must_build h7 -DLODE_PORT=stm32h7 -DLODE_CORE=cortex-m7
sizes stm32h7 "$work/h7/port/stm32h7/lodestar_stm32h7.elf"
kept "$work/h7/port/stm32h7/lodestar_stm32h7.elf"
arm-none-eabi-nm "$work/h7/port/stm32h7/lodestar_stm32h7.elf" | awk '
    { at[$3] = $1 }
    END { for (name in at) if (at[name] == "00000000" && name !~ /^\$/) exit 1
          split("ADC_IRQHandler app_period lode_drive_step board_read board_write board_gates_off", hot, " ")
          for (n in hot) if (at[hot[n]] !~ /^0000[0-9a-f]+$/) exit 1
          exit !(at["drive"] ~ /^2000/ && at["stack_end"] == "20020000" && at["outputs_off"] ~ /^080/) }' ||
    { echo "stm32h7: expected the step in the ITCM, data in the DTCM, the word for the DMA in flash"; exit 1; }
must_build h7 -DLODE_PORT=stm32h7 -DLODE_CORE=cortex-m7 -DCMAKE_BUILD_TYPE=Debug
sizes "stm32h7 Debug" "$work/h7/port/stm32h7/lodestar_stm32h7.elf"
if build refused_core -DLODE_PORT=stm32h7 || ! grep -q "expected cortex-m7" "$log"; then
    echo "the STM32H7 with another core: expected a refusal that names cortex-m7"
    exit 1
fi
sed -e 's/PORT_LOW_SIDE_THREE/PORT_IN_LINE_THREE/' -e 's/\(#define VARIANT_F_PWM_Hz .*\)/\1\n#define VARIANT_DOUBLE_UPDATE true/' \
    port/stm32f4/boards/generic_f405.h >"$work/double.h"
must_build f4 -DLODE_PORT=stm32f4 -DLODE_EMULATED=OFF -DLODE_BOARD="$work/double.h"
sizes "stm32f4, two calls in a period" "$work/f4/port/stm32f4/lodestar_stm32f4.elf"
must_build f4 -DLODE_PORT=stm32f4
sizes stm32f4 "$work/f4/port/stm32f4/lodestar_stm32f4.elf"
kept "$work/f4/port/stm32f4/lodestar_stm32f4.elf"
# The fast memory holds the step whatever the optimisation; in a Debug build it runs from flash.
for board in "${boards[@]}"; do
    for flags in -Os -O3; do
        must_build "g4$flags" -DLODE_PORT=stm32g4 -DLODE_BOARD="$board" -DCMAKE_C_FLAGS_RELEASE="$flags"
        sizes "$board $flags" "$work/g4$flags/port/stm32g4/lodestar_stm32g4.elf"
    done
    must_build g4-debug -DLODE_PORT=stm32g4 -DLODE_BOARD="$board" -DCMAKE_BUILD_TYPE=Debug
    sizes "$board Debug" "$work/g4-debug/port/stm32g4/lodestar_stm32g4.elf"
done
must_build f4-debug -DLODE_PORT=stm32f4 -DCMAKE_BUILD_TYPE=Debug
sizes "stm32f4 Debug" "$work/f4-debug/port/stm32f4/lodestar_stm32f4.elf"
if build refused -DLODE_PORT=stm32g4 -DLODE_CMSIS_DIR=/nowhere ||
    ! grep -q "expected stm32g4xx.h" "$log"; then
    echo "a folder without ST's headers: expected a refusal that names stm32g4xx.h"
    exit 1
fi
must_build f4 -DLODE_PORT=template
sections template "$work/f4/port/template/lodestar_template.elf"

command -v qemu-system-arm >/dev/null || { echo "no qemu-system-arm: the images were linked only"; exit 0; }
# say MODE: the first line of the image in the file of its mode. The image runs for ever, so qemu is
# ended after that line. Instructions, not time, drive it.
mkfifo "$work/serial"
say() {
    local line='' pid
    qemu-system-arm -M netduinoplus2 -display none -monitor none -serial null -serial null \
        -serial stdio -icount shift=3,sleep=off -kernel "$work/mode$1.elf" \
        </dev/null >"$work/serial" 2>"$work/qemu.log" &
    pid=$!
    read -r -t 60 line <"$work/serial" || true
    kill "$pid" 2>/dev/null || true
    wait "$pid" || true
    printf '%s' "${line%$'\r'}"
}

for mode in 1 2; do
    must_build f4 -DLODE_PORT=stm32f4 -DLODE_EMULATED=ON -DLODE_APP_MODE=$mode
    cp "$work/f4/port/stm32f4/lodestar_stm32f4.elf" "$work/mode$mode.elf"
    sections "netduinoplus2, step $mode" "$work/mode$mode.elf"
    said=$(say $mode)
    echo "netduinoplus2: $said"
    case "$said" in
    "$mode PASS OK "*) ;;
    *)
        cat "$work/qemu.log"
        echo "expected '$mode PASS OK ...'"
        exit 1
        ;;
    esac
done
