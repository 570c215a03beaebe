#!/usr/bin/env bash
# A project that adds Lodestar with add_subdirectory gets the library alone: no tests, no simulator.
set -eu
root=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.18)
project(user LANGUAGES C)
add_subdirectory("$root" lodestar)
add_executable(user user.c)
target_link_libraries(user PRIVATE lodestar::lodestar)
CMAKE
cat >"$work/user.c" <<'C'
#include "lodestar/lodestar.h"

int main(void) {
    return LODE_VERSION_MAJOR < 0;
}
C
if ! { cmake -S "$work" -B "$work/build" && cmake --build "$work/build"; } >"$work/log" 2>&1; then
    cat "$work/log"
    exit 1
fi
"$work/build/user"
if [ -e "$work/build/lodestar/tests" ] || [ -e "$work/build/lodestar/sim" ]; then
    echo "expected only the library, found the tests or the simulator in the build"
    exit 1
fi
