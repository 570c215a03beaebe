#!/usr/bin/env bash
# Each public header compiles alone, as C99, C11 and C++17, and twice in a row.
set -eu
. tests/tools/sources.sh
flags=(-Wall -Wextra -Werror -fsyntax-only -Iinclude)
code=0
for header in "${headers[@]}"; do
    name=${header#include/}
    text=$(printf '#include "%s"\n#include "%s"\n' "$name" "$name")
    cc -x c -std=c99 "${flags[@]}" - <<<"$text" || { echo "$header: not C99 on its own"; code=1; }
    cc -x c -std=c11 "${flags[@]}" - <<<"$text" || { echo "$header: not C11 on its own"; code=1; }
    c++ -x c++ -std=c++17 "${flags[@]}" - <<<"$text" || { echo "$header: not C++17 on its own"; code=1; }
done
exit $code
