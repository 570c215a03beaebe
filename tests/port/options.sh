#!/usr/bin/env bash
# What the options of a firmware may be: CMake refuses all else while it configures, and says what it
# expected. Runs at the project's root.
set -eu -o pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp port/example/motor.h "$work/my motor.h"
mkdir "$work/folder"

configures() { # options of CMake
    rm -rf "$work/build"
    cmake -G Ninja -S . -B "$work/build" -DLODE_PORT=template -DLODE_BUILD_SIM=OFF -DLODE_BUILD_TESTS=OFF "$@" \
        >"$work/log" 2>&1
}
taken() {
    configures "$@" || { cat "$work/log"; echo "$*: expected to be taken"; exit 1; }
}
refused() { # option, its value, what is said of it
    ! configures "-D$1=$2" || { echo "$1=$2: expected to be refused"; exit 1; }
    # CMake breaks long lines.
    tr -s ' \n' ' ' <"$work/log" | grep -qF -- "$1=$2: expected $3" ||
        { cat "$work/log"; echo "$1=$2: expected a message with '$3'"; exit 1; }
}

taken -DLODE_APP_MODE=9 -DLODE_APP_LINK=2 -DLODE_APP_RESTARTS=255 -DLODE_APP_V_BUS_V=10.5 \
    "-DLODE_MOTOR_H=$work/my motor.h"
taken -DLODE_APP_MODE=0 -DLODE_APP_LINK=0 -DLODE_APP_RESTARTS=0 -DLODE_APP_V_BUS_V=0 -DLODE_MOTOR_H=
for value in 10 -1 1.5 01 x 1u ''; do
    refused LODE_APP_MODE "$value" "a whole number, 0 .. 9"
done
refused LODE_APP_LINK 3 "a whole number, 0 .. 2"
refused LODE_APP_LINK ring "a whole number, 0 .. 2"
refused LODE_APP_RESTARTS 256 "a whole number, 0 .. 255"
for value in 24V -10 010 1e1 . 2000.5 ''; do
    refused LODE_APP_V_BUS_V "$value" "volts as a decimal number, 0 .. 2000"
done
refused LODE_MOTOR_H "$work/nowhere.h" "a header file"
refused LODE_MOTOR_H "$work/folder" "a header file"
refused LODE_PORT nowhere "one of"
echo "options of a firmware: all as expected"
