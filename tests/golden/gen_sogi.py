"""Prints sogi.h: the prewarped SOGI notch as a direct-form recursion in float64.

al = k sin(wn Ts)/2, c = cos(wn Ts),
y = (x - 2c x1 + x2 + 2c y1 - (1-al) y2)/(1+al).
"""
import math
import random

CASES = [(0.5, 0.12), (0.1, 0.5655), (1.4, 1.0), (2.0, 2.4), (0.05, 0.02)]
STEPS = 120


def notch(k, wn_ts, inputs):
    al, c = k * math.sin(wn_ts) / 2, math.cos(wn_ts)
    x1 = x2 = y1 = y2 = 0.0
    for x in inputs:
        y = (x - 2 * c * x1 + x2 + 2 * c * y1 - (1 - al) * y2) / (1 + al)
        x1, x2, y1, y2 = x, x1, y, y1
        yield y


def main():
    random.seed(6)
    print("// Printed by gen_sogi.py.")
    print("typedef struct {\n    double k;\n    double wn_Ts;\n"
          f"    double input[{STEPS}];\n    double notch[{STEPS}];\n}} sogi_case_t;\n")
    print("static const sogi_case_t sogi_cases[] = {")
    for k, wn_ts in CASES:
        inputs = [round(random.uniform(-1, 1), 6) for _ in range(STEPS)]
        print(f"    {{{k}, {wn_ts},\n     {{" + ", ".join(f"{x:.6f}" for x in inputs) + "},")
        print("     {" + ", ".join(f"{y:.9f}" for y in notch(k, wn_ts, inputs)) + "}},")
    print("};")


main()
