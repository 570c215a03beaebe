#!/usr/bin/env bash
# usage: fuzz.sh build | fuzz.sh seeds | fuzz.sh run NAME | fuzz.sh night [INPUTS] | fuzz.sh keep NAME
# build: all libFuzzer programs. seeds: each of them over its seeds, tests/fuzz/corpus/*.hex, once.
# run: one of them, for 20 s or 1 000 000 inputs, for five minutes in a campaign (LODE_TEST_FULL=1), for
# LODE_FUZZ_SECONDS where that is given. night: builds all and runs them in turns of a minute, one on each
# processor, until they have tried INPUTS in all (10^9 unless told); each goes on from what it has found.
# keep: of what a program has found, the seeds are joined by the inputs that reach branches which no other
# reaches. An input that fails is left beside the program.
set -eu -o pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
cd "$root"
skip() { echo "skipped: $*"; exit 77; }
case "${1:-}:$#" in
build:1 | seeds:1 | run:2 | keep:2 | night:1 | night:2) ;;
*)
    sed -n 's/^# //; 2p' "$0" >&2
    exit 2
    ;;
esac

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

if [ "$1" = night ]; then
    inputs=${2:-1000000000}
    [[ $inputs =~ ^[1-9][0-9]*$ ]] || { echo "fuzz.sh night: INPUTS is a number of inputs, not '$inputs'" >&2; exit 2; }
    bash "$0" build
    turn() { # program: what it tried goes to its log
        LODE_FUZZ_SECONDS=60 LODE_FUZZ_SEED=$RANDOM bash "$0" run "$1" >"$work/night-$1.log" 2>&1 || {
            tail -n 40 "$work/night-$1.log"
            echo "failed: $1"
            touch "$work/night-failed"
        }
    }
    total=0
    rm -f "$work/night-failed"
    while [ "$total" -lt "$inputs" ]; do
        for program in tests/fuzz/fuzz_*.c; do
            while [ "$(jobs -rp | wc -l)" -ge "$(nproc)" ]; do
                wait -n
            done
            turn "$(basename "$program" .c)" &
        done
        wait
        [ ! -e "$work/night-failed" ] || exit 1
        tried=$(cat "$work"/night-fuzz_*.log | awk '/number_of_executed_units/ { n += $2 } END { print n + 0 }')
        total=$((total + tried))
        echo "$(date +%T) $total inputs of $inputs"
        [ "$tried" -gt 0 ] || { echo "no program tried anything" >&2; exit 1; }
    done
    exit
fi

# The seeds' folder; programs that run at the same time have each their own.
unpack_seeds() { # program, folder
    python3 tests/tools/fuzz_seeds.py unpack "tests/fuzz/corpus/${1#fuzz_}.hex" "$2"
}

# libFuzzer would end with 77 on a finding, which is the code for a skipped test.
options=(-timeout=10 -error_exitcode=1)

if [ "$1" = seeds ]; then
    for program in tests/fuzz/fuzz_*.c; do
        name=$(basename "$program" .c)
        [ -x "$work/tests/fuzz/$name" ] || skip "$name was not built"
        unpack_seeds "$name" "$work/replayed-$name"
        inputs=("$work/replayed-$name"/*)
        "$work/tests/fuzz/$name" "${options[@]}" "${inputs[@]}" >"$work/$name-seeds.log" 2>&1 || {
            tail -n 60 "$work/$name-seeds.log"
            exit 1
        }
        echo "$name: ${#inputs[@]} seeds"
    done
    exit
fi

name=$2
program=$work/tests/fuzz/$name
[ -x "$program" ] || skip "$program was not built"
seeds=$work/seeds-$name
unpack_seeds "$name" "$seeds"
corpus=$work/corpus-$name
mkdir -p "$corpus"
if [ "$1" = keep ]; then
    "$program" "${options[@]}" -merge=1 -use_counters=0 "$seeds" "$corpus" 2>&1 | tail -n 1
    python3 tests/tools/fuzz_seeds.py pack "$seeds" "tests/fuzz/corpus/${name#fuzz_}.hex"
    exit
fi
budget=(-runs=1000000 -max_total_time=20)
if [ "${LODE_TEST_FULL:-0}" = 1 ]; then
    budget=(-max_total_time=300)
fi
if [ -n "${LODE_FUZZ_SECONDS:-}" ]; then
    budget=(-max_total_time="$LODE_FUZZ_SECONDS")
fi
"$program" "${options[@]}" -seed="${LODE_FUZZ_SEED:-1}" -print_final_stats=1 -artifact_prefix="$work/$name-" \
    "${budget[@]}" "$corpus" "$seeds" 2>&1 | tail -n 60
