#!/usr/bin/env bash
# cppcheck over the core and the host rig.
set -eu
. tests/tools/sources.sh
command -v cppcheck >/dev/null || { echo "skipped: no cppcheck"; exit 77; }
folders=()
for folder in src port sim; do
    [ ! -d "$folder" ] || folders+=("$folder")
done
# redundantCondition does not know that NaN makes both x > 0 and x <= 0 false.
# unusedStructMember sees one file at a time; a library's users are elsewhere.
cppcheck --quiet --std=c99 --enable=warning,style,performance,portability --inline-suppr \
    --error-exitcode=1 --suppress=missingIncludeSystem --suppress=unusedStructMember \
    --suppress=redundantCondition \
    -j "$(nproc)" -Iinclude -Isrc -Isim "${folders[@]}"
