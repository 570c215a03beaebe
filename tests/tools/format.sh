#!/usr/bin/env bash
# clang-format agrees with every C file that a person wrote.
set -eu -o pipefail
command -v clang-format >/dev/null || { echo "skipped: no clang-format"; exit 77; }
folders=()
for folder in include src port sim tests; do
    [ ! -d "$folder" ] || folders+=("$folder")
done
find "${folders[@]}" -path tests/golden -prune -o -path '*/build' -prune -o -name '*.[ch]' -print0 |
    xargs -0 -r clang-format --dry-run -Werror
