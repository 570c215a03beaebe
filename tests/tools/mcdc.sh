#!/usr/bin/env bash
# MC/DC of the core by its own tests; see check_mcdc.py. It takes clang 18 or later with its llvm-cov.
set -eu -o pipefail
. tests/tools/modern_clang.sh
tree=build/mcdc
can_build "$tree" -fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc ||
    skip "$LODE_CLANG has no profile runtime"

profiles=$PWD/$tree/profiles
rm -rf "$profiles"
export LLVM_PROFILE_FILE=$profiles/%m.profraw # one per program
bash tests/tools/preset.sh mcdc test -L unit
"llvm-profdata$clang_version" merge -o "$tree/profdata" "$profiles"/*.profraw
objects=()
while read -r program; do
    objects+=(-object "$program")
done < <(ctest --test-dir "$tree" -L unit --show-only=json-v1 |
    python3 -c 'import json, sys; print(*sorted({t["command"][0] for t in json.load(sys.stdin)["tests"]}), sep="\n")')
"llvm-cov$clang_version" export -instr-profile="$tree/profdata" "${objects[@]:1}" >"$tree/coverage.json"
exec python3 tests/tools/check_mcdc.py . "$tree/coverage.json" tests/mcdc_exceptions.txt
