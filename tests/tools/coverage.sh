#!/usr/bin/env bash
# Branch coverage of the core by its own tests; see check_coverage.py.
set -eu
command -v gcov >/dev/null || { echo "skipped: no gcov (it comes with gcc)"; exit 77; }
[ ! -d build/coverage ] || find build/coverage -name '*.gcda' -delete
bash tests/tools/preset.sh coverage test -L unit
exec python3 tests/tools/check_coverage.py . build/coverage tests/coverage_exceptions.txt
