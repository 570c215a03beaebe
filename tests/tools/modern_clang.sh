# Sourced by the gates that need clang 18 or later: from PyPI (`tests/run full` and `tests/run gate_mcdc gate_memory` install it),
# or the system's. Puts its folder first in PATH; LODE_CLANG is its name, `clang_version` the suffix of its tools.
skip() { echo "skipped: $*"; exit 77; }

clang_venv=$(bash tests/tools/python.sh clang --venv)
"$clang_venv/bin/python" -c pass 2>/dev/null || true # its first start links the packages' libraries
export PATH=$clang_venv/bin:$PATH
is_modern() { # suffix of the commands
    local number
    number=$("clang$1" -dumpversion 2>/dev/null | cut -d. -f1)
    [ "${number:-0}" -ge 18 ] && command -v "llvm-cov$1" >/dev/null && command -v "llvm-profdata$1" >/dev/null
}
for clang_version in "" -18 -19 -20 -21 none; do
    is_modern "$clang_version" && break
done
[ "$clang_version" != none ] || skip "no clang 18 or later with llvm-cov (PyPI: $(bash tests/tools/python.sh clang --packages))"
export LODE_CLANG=clang$clang_version

# Compiles and links an empty program with these options.
can_build() { # folder, options...
    mkdir -p "$1"
    echo 'int main(void) { return 0; }' >"$1/try.c"
    "$LODE_CLANG" "${@:2}" "$1/try.c" -o "$1/try" 2>/dev/null
}
