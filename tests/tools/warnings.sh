#!/usr/bin/env bash
# usage: warnings.sh COMPILER FLAGS...: the core compiles without a warning, optimised (some
# warnings need the data flow).
set -eu
. tests/tools/sources.sh
compiler=$1
shift
command -v "$compiler" >/dev/null || { echo "skipped: no $compiler"; exit 77; }
code=0
for source in "${sources[@]}"; do
    "$compiler" -std=c99 -O2 "$@" -Werror -Iinclude -Isrc -c "$source" -o /dev/null || code=1
done
exit $code
