#!/bin/sh
# Every observer but C-LESO can be left out of the build, alone and all together, without a warning;
# what is left out is not in the object.
set -eu
root=${LODE_SOURCE_DIR:?}
object=$(mktemp)
trap 'rm -f "$object"' EXIT
build() {
    ${CC:-cc} -std=c99 -O2 -fno-inline -Wall -Wextra -Wconversion -Werror -I"$root/include" "$@" \
        -c "$root/src/leso.c" -o "$object"
}
absent() {
    if nm "$object" | grep -Eq " t $1(\.|$)"; then
        echo "$1 is still in the object built with $2"
        exit 1
    fi
}
build
nm "$object" | grep -Eq ' t step_gi(\.|$)' || { echo "step_gi is not found where it should be"; exit 1; }
build -DLODE_WITHOUT_GI_LESO
absent step_gi LODE_WITHOUT_GI_LESO
build -DLODE_WITHOUT_FA_LESO
absent step_fa LODE_WITHOUT_FA_LESO
build -DLODE_WITHOUT_FA_MULTI
absent step_multi LODE_WITHOUT_FA_MULTI
build -DLODE_WITHOUT_GI_LESO -DLODE_WITHOUT_FA_LESO -DLODE_WITHOUT_FA_MULTI
for name in step_gi step_fa step_multi; do
    absent $name "all three options"
done
