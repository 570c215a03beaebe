#!/usr/bin/env bash
# usage: fuzz.sh build | fuzz.sh run NAME | fuzz.sh all
# Builds all libFuzzer programs, or runs one: 10 s or 200 000 inputs, five minutes in a campaign
# (LODE_TEST_FULL=1), or LODE_FUZZ_RUNS inputs or LODE_FUZZ_SECONDS, whichever is given and comes first. all: builds them
# and runs one after the other, each as long. An input that fails is left beside the program.
set -eu -o pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
cd "$root"
skip() { echo "skipped: $*"; exit 77; }

if ! command -v clang >/dev/null; then
    skip "clang is not installed"
fi
work=build/fuzz
if [ "$1" = build ]; then
    mkdir -p "$work"
    echo 'int LLVMFuzzerTestOneInput(const char *d, unsigned long n) { return d && n > 9; }' >"$work/try.c"
    clang -fsanitize=fuzzer,address "$work/try.c" -o "$work/try" 2>/dev/null ||
        skip "clang has no libFuzzer runtime (Debian: libclang-rt-<version>-dev)"
    bash tests/tools/preset.sh fuzz build
    exit
fi

if [ "$1" = all ]; then
    bash "$0" build
    failed=
    for program in tests/fuzz/fuzz_*.c; do
        name=$(basename "$program" .c)
        echo "== $name"
        bash "$0" run "$name" || failed="$failed $name"
    done
    [ -z "$failed" ] || { echo "failed:$failed"; exit 1; }
    exit
fi

name=$2
program=$work/tests/fuzz/$name
[ -x "$program" ] || skip "$program was not built"
budget=(-runs=200000 -max_total_time=10)
if [ "${LODE_TEST_FULL:-0}" = 1 ]; then
    budget=(-max_total_time=300)
fi
if [ -n "${LODE_FUZZ_RUNS:-}${LODE_FUZZ_SECONDS:-}" ]; then
    budget=(-runs="${LODE_FUZZ_RUNS:--1}" -max_total_time="${LODE_FUZZ_SECONDS:-0}")
fi
corpus=$work/corpus-$name
seeds=tests/fuzz/corpus/${name#fuzz_}
mkdir -p "$corpus"
folders=("$corpus")
if [ -d "$seeds" ]; then
    folders+=("$seeds")
fi
# libFuzzer would end with 77 on a finding, which is the code for a skipped test.
"$program" -seed=1 -timeout=10 -error_exitcode=1 -print_final_stats=1 -artifact_prefix="$work/$name-" \
    "${budget[@]}" "${folders[@]}" 2>&1 | tail -n 60
