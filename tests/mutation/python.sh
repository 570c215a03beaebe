#!/usr/bin/env bash
# usage: python.sh SCRIPT ARGS...   runs the script with a python that has the parser's packages
#        python.sh --venv           prints where tests/run puts that python
#        python.sh --packages       prints what it needs
set -eu
venv=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/lodestar/mutation
case "$1" in
--venv) echo "$venv" && exit ;;
--packages) echo "tree-sitter==0.26.1 tree-sitter-c==0.24.2" && exit ;;
esac
modules='{"tree_sitter", "tree_sitter_c"}'
for python in "$venv/bin/python" python3; do
    if "$python" -c "import importlib.util as u, sys; sys.exit(any(not u.find_spec(m) for m in $modules))" 2>/dev/null; then
        exec "$python" "$@"
    fi
done
echo "skipped: no python with tree-sitter and tree-sitter-c (tests/run tries to install them in $venv)"
exit 77
