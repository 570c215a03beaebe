#!/usr/bin/env bash
# usage: board.sh PRESET REPLAY_HOST: configures and builds a target preset and runs its tests.
set -eu -o pipefail
preset=$1
replay_host=$2
root=$(cd "$(dirname "$0")/../.." && pwd)
for tool in arm-none-eabi-gcc qemu-system-arm; do
    command -v "$tool" >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
echo '#include <math.h>' | arm-none-eabi-gcc -E -x c - >/dev/null 2>&1 ||
    { echo "skipped: no C library for arm-none-eabi-gcc (libnewlib-arm-none-eabi)"; exit 77; }
cd "$root"
tree=build/$preset
# A tree that was copied or moved would still point at its old place.
if [ -f "$tree/CMakeCache.txt" ] &&
    ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$tree/CMakeCache.txt"; then
    rm -rf "$tree"
fi
mkdir -p "$tree"
log=$tree/build.log
if ! { cmake --preset "$preset" -DLODE_REPLAY_HOST="$replay_host" &&
    cmake --build --preset "$preset" -- -k 0; } >"$log" 2>&1; then
    cat "$log"
    echo "preset $preset: configure or build failed"
    exit 1
fi
ctest --preset "$preset" --no-tests=error -j 2
