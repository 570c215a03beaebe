# Source it: the core's files, or a failure that says there are none.
# shellcheck shell=bash
shopt -s nullglob
sources=(src/*.c)
headers=(include/lodestar/*.h)
if [ ${#sources[@]} = 0 ] || [ ${#headers[@]} = 0 ]; then
    echo "no src/*.c or no include/lodestar/*.h"
    exit 1
fi
