#!/usr/bin/env bash
# The unit tests with the address and undefined-behaviour sanitizers: clang's, which check more, or the default compiler's.
set -eu
CC=$(command -v clang || command -v "${CC:-cc}")
export CC
exec bash tests/tools/preset.sh debug-sanitize test -L unit
