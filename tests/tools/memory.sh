#!/usr/bin/env bash
# The unit tests with the memory sanitizer: nothing reads what was never written. Left out are the tests that read the tool's data
# files: this clang does not know that stat() writes.
set -eu -o pipefail
. tests/tools/modern_clang.sh
tree=build/memory
can_build "$tree" -fsanitize=memory || skip "$LODE_CLANG has no memory sanitizer"
export LD_LIBRARY_PATH=$clang_venv/lib/x86_64-unknown-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
MSAN_OPTIONS=exit_code=0:halt_on_error=0 bash tests/tools/preset.sh memory build # runs the tool, which reads its files
MSAN_OPTIONS=halt_on_error=1 ctest --test-dir "$tree" --output-on-failure --no-tests=error -j "$(nproc)" -L unit \
    -E '^(test_plant_linear|test_sim_tuning6?|test_rig_six)$'
