#!/usr/bin/env bash
# usage: preset.sh PRESET build            configure and build a preset
#        preset.sh PRESET test [ctest..]   and run its tests
# Quiet while all is well; the whole log when something fails.
set -eu -o pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
preset=$1
action=$2
shift 2
cd "$root"
tree=build/$preset
# A tree that was copied or moved would still point at its old place.
if [ -f "$tree/CMakeCache.txt" ] &&
    ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$tree/CMakeCache.txt"; then
    rm -rf "$tree"
fi
mkdir -p "$tree"
log=$tree/build.log
if ! { cmake --preset "$preset" && cmake --build "$tree" -j "$(nproc)" -- -k 0; } >"$log" 2>&1; then
    cat "$log"
    echo "preset $preset: configure or build failed"
    exit 1
fi
if [ "$action" = test ]; then
    ctest --test-dir "$tree" --output-on-failure --no-tests=error -j "$(nproc)" "$@"
fi
