#!/usr/bin/env bash
# Each public header compiles alone, as C99, C11 and C++17, and twice in a row, without an extension of the
# compiler's: a C++ program may have -Wpedantic -Werror on.
set -eu
. tests/tools/sources.sh
flags=(-Wall -Wextra -Wpedantic -Werror -fsyntax-only -Iinclude)
code=0
for header in "${headers[@]}"; do
    name=${header#include/}
    text=$(printf '#include "%s"\n#include "%s"\ntypedef int lode_not_empty;\n' "$name" "$name")
    for standard in c99 c11; do
        cc -x c -std=$standard "${flags[@]}" - <<<"$text" || { echo "$header: not $standard on its own"; code=1; }
    done
    for compiler in c++ clang++; do
        command -v $compiler >/dev/null || continue
        $compiler -x c++ -std=c++17 "${flags[@]}" - <<<"$text" ||
            { echo "$header: not C++17 on its own, says $compiler"; code=1; }
    done
done
exit $code
