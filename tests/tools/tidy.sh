#!/usr/bin/env bash
# clang-tidy over the core (.clang-tidy says what is checked and what is not, and why).
set -eu -o pipefail
. tests/tools/sources.sh
command -v clang-tidy >/dev/null || { echo "skipped: no clang-tidy"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Findings come on stdout; stderr has real errors and a count of the warnings in system headers.
printf '%s\0' "${sources[@]}" | xargs -0 -n 1 -P "$(nproc)" sh -c \
    'clang-tidy --quiet --warnings-as-errors="*" "$2" -- -std=c99 -Iinclude -Isrc \
        >"$1/$$" 2>"$1/$$.err" || { cat "$1/$$"; grep -v generated "$1/$$.err"; exit 1; }' tidy "$work"
