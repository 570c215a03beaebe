#!/usr/bin/env bash
# usage: python.sh SCRIPT ARGS...   runs the script with a python that has the counter's packages
#        python.sh --venv           prints where tests/run puts that python
#        python.sh --packages       prints what it needs
set -eu
venv=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/lodestar/counter
case "$1" in
--venv) echo "$venv" && exit ;;
--packages) echo "unicorn==2.1.4 capstone==5.0.9 pyelftools==0.33" && exit ;;
esac
modules='{"unicorn", "capstone", "elftools"}'
for python in "$venv/bin/python" python3; do
    if "$python" -c "import importlib.util as u, sys; sys.exit(any(not u.find_spec(m) for m in $modules))" 2>/dev/null; then
        exec "$python" "$@"
    fi
done
echo "skipped: no python with unicorn, capstone and pyelftools (tests/run tries to install them in $venv)"
exit 77
