#!/usr/bin/env bash
# The core compiles where int has 16 bits and no C library is there (clang's MSP430 target, as a
# stand-in for TI C28x). tests/tools/freestanding holds the few declarations of <math.h>.
set -eu
. tests/tools/sources.sh
command -v clang >/dev/null || { echo "skipped: no clang"; exit 77; }
clang --target=msp430 -std=c99 -ffreestanding -fsyntax-only -Wall -Wextra -Wconversion \
    -Wshift-overflow -Wconstant-conversion -Werror \
    -isystem tests/tools/freestanding -Iinclude -Isrc "${sources[@]}"
