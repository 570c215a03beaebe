#!/usr/bin/env bash
# cppcheck with the sizes of a machine whose char has 16 bits: shifts and constants that do not fit.
set -eu
. tests/tools/sources.sh
command -v cppcheck >/dev/null || { echo "skipped: no cppcheck"; exit 77; }
cppcheck --quiet --std=c99 --platform=tests/tools/char16.xml --enable=warning,portability \
    --inline-suppr --error-exitcode=1 --suppress=missingIncludeSystem -Iinclude -Isrc src
