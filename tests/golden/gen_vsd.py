"""Prints tests/golden/vsd.h: the 6 x 6 transform of docs/theory/dual.md (V3), in float64.

The matrix is written out as numbers; the C code works with the vectors of the two sets instead.
"""
import math
import random

S = math.sqrt(3.0) / 2.0
T = [
    [1, -0.5, -0.5, S, -S, 0],
    [0, S, -S, 0.5, 0.5, -1],
    [1, -0.5, -0.5, -S, S, 0],
    [0, -S, S, 0.5, 0.5, -1],
    [1, 1, 1, 0, 0, 0],
    [0, 0, 0, 1, 1, 1],
]


def main():
    random.seed(6)
    print("// From gen_vsd.py.\n#ifndef GOLDEN_VSD_H\n#define GOLDEN_VSD_H\n")
    print("typedef struct {\n    double phase[6];\n    double plane[6];\n} vsd_case_t;\n")
    print("static const vsd_case_t vsd_cases[] = {")
    for _ in range(20):
        x = [random.uniform(-10.0, 10.0) for _ in range(6)]
        y = [sum(a * b for a, b in zip(row, x)) / 3.0 for row in T]
        print("    {{%s},\n     {%s}}," % (", ".join(f"{v:.17g}" for v in x),
                                           ", ".join(f"{v:.17g}" for v in y)))
    print("};\n\n#endif")


main()
