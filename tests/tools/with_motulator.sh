#!/usr/bin/env bash
# usage: with_motulator.sh SCRIPT ARGS...   runs the script with a python that has motulator
#        with_motulator.sh --venv           prints where tests/run puts that python
set -eu
venv=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/lodestar/motulator
if [ "$1" = --venv ]; then
    echo "$venv"
    exit
fi
for python in "$venv/bin/python" python3; do
    if "$python" -c 'import importlib.util as u, sys; sys.exit(not u.find_spec("motulator"))' 2>/dev/null; then
        exec "$python" "$@"
    fi
done
echo "skipped: no python with motulator (tests/run tries to install it in $venv)"
exit 77
