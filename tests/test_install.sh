#!/usr/bin/env bash
# Uses the source tree by add_subdirectory() and FetchContent; installs the library, uses it by
# find_package() and pkg-config, moves it, and does so again. All from C99 and from C++17.
set -eu -o pipefail
command -v c++ >/dev/null || { echo "no C++ compiler here" && exit 77; }
command -v ninja >/dev/null && export CMAKE_GENERATOR=Ninja
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $1" >&2
    exit 1
}

version=$(sed -n 's/#define LODE_VERSION_M[A-Z]* //p' "${LODE_SOURCE_DIR:?}/include/lodestar/version.h" |
    paste -sd.)
mkdir "$work/consumer"
cat >"$work/consumer/main.c" <<'END'
#include <stdio.h>

#include "lodestar/lodestar.h"

static lode_drive_tuning_t tuning;
static lode_drive_t drive;

int main(void) {
    lode_drive_config_t config = {0};
    config.f_pwm_Hz = 5.0e3f;
    config.motor.pole_pairs = 3.0f;
    config.motor.Rs_Ohm = 0.75f;
    config.motor.Ld_H = 3.5e-3f;
    config.motor.Lq_H = 9.8e-3f;
    config.motor.psi_Wb = 0.142f;
    config.motor.J_kgm2 = 0.0174f;
    config.inverter.v_bus_V = 200.0f;
    config.inverter.i_max_A = 12.0f;
    config.sense.i_gain_A_count = 0.0125f;
    config.sense.i_offset_count = 2048.0f;
    config.sense.v_bus_gain_V_count = 0.1f;
    const lode_status_t status = lode_drive_init(&drive, &tuning, &config);
    lode_counts_t counts = {{2048, 2048, 2048}, 2000, 0, false, 0};
    lode_drive_out_t out = lode_drive_step(&drive, &counts);
    printf("%s %g\n", lode_status_name(status), (double)out.duty.a);
    return status != LODE_OK;
}
END
cp "$work/consumer/main.c" "$work/consumer/main.cpp"
cat >"$work/consumer/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.18)
project(consumer C CXX)
if(HOW STREQUAL "subdirectory")
  add_subdirectory("${LODESTAR}" lodestar)
elseif(HOW STREQUAL "fetch")
  include(FetchContent)
  FetchContent_Declare(lodestar SOURCE_DIR "${LODESTAR}")
  FetchContent_MakeAvailable(lodestar)
else()
  find_package(lodestar ${VERSION} REQUIRED)
endif()
foreach(source main.c main.cpp)
  string(MAKE_C_IDENTIFIER ${source} name)
  add_executable(${name} ${source})
  set_target_properties(${name} PROPERTIES CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON C_STANDARD 99)
  target_link_libraries(${name} lodestar::lodestar)
endforeach()
END

build_consumer() { # build_consumer CMAKE-OPTIONS...
    rm -rf "$work/use"
    # Without optimisation sqrtf is a call.
    cmake -S "$work/consumer" -B "$work/use" -DCMAKE_BUILD_TYPE=Debug "$@" >"$work/log" 2>&1 &&
        cmake --build "$work/use" >>"$work/log" 2>&1 || fail "$*: $(tail -n 5 "$work/log")"
    for program in main_c main_cpp; do
        [ "$("$work/use/$program")" = "LODE_OK 0.5" ] || fail "$program says '$("$work/use/$program")'"
    done
}

use() { # use PREFIX
    build_consumer -DCMAKE_PREFIX_PATH="$1" -DVERSION="$version"
    if command -v pkg-config >/dev/null; then
        local flags
        flags=$(PKG_CONFIG_PATH=$(dirname "$(find "$1" -name lodestar.pc)") \
            pkg-config --static --cflags --libs lodestar)
        # shellcheck disable=SC2086
        cc -std=c99 "$work/consumer/main.c" $flags -o "$work/by_pc"
        [ "$("$work/by_pc")" = "LODE_OK 0.5" ] || fail "by pkg-config: '$("$work/by_pc")'"
        case "$flags" in *-ffp-contract=off*) ;; *) fail "pkg-config's flags: $flags" ;; esac
    else
        echo "pkg-config is not here: left out"
    fi
}

for how in subdirectory fetch; do
    build_consumer -DHOW=$how -DLODESTAR="$LODE_SOURCE_DIR"
done
# As a user does it, without an option of ours. Any way to the network would be one to a refusing proxy.
env http_proxy=http://127.0.0.1:9 https_proxy=http://127.0.0.1:9 \
    cmake -S "$LODE_SOURCE_DIR" -B "$work/build" -DCMAKE_INSTALL_PREFIX="$work/prefix" >"$work/log" 2>&1 &&
    cmake --build "$work/build" >>"$work/log" 2>&1 &&
    cmake --install "$work/build" >>"$work/log" 2>&1 || fail "install: $(tail -n 5 "$work/log")"
if grep -q "unity_DIR" "$work/build/CMakeCache.txt" || [ -e "$work/build/tests" ]; then
    fail "a plain build configures the tests"
fi
[ -n "$(find "$work/prefix/share/doc" -name LICENSE)" ] || fail "LICENSE is not installed"
use "$work/prefix"
mv "$work/prefix" "$work/moved"
use "$work/moved"
if grep -rn "$LODE_SOURCE_DIR" "$work/moved" --include='*.cmake' --include='*.pc'; then
    fail "the installed files name the source folder"
fi
if [ -x "$work/moved/bin/lodestar" ]; then
    # With the data installed beside it: the source tree has no motor of this name.
    mv "$work/moved/share/lodestar/motors/jiang2022.ini" "$work/moved/share/lodestar/motors/of_the_tool.ini"
    (cd "$work" && moved/bin/lodestar design --motor of_the_tool >"$work/log" 2>&1) ||
        fail "the installed tool: $(tail -n 5 "$work/log")"
else
    grep -q "Without the tool" "$work/log" || echo "the tool was not built: left out"
fi
echo "used from the source tree; installed, used, moved, used"
