#!/usr/bin/env bash
# Everything but the tests of the ports once more with clang: no warning, and the unit tests pass.
set -eu
command -v clang >/dev/null || { echo "skipped: no clang"; exit 77; }
exec bash tests/tools/preset.sh clang test -L unit
