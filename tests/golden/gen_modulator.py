"""Prints modulator.h: space-vector duties from sectors and dwell times.

The reference vector lies between two active vectors V_n at (n-1) 60 degrees, of length 2/3 of the bus.
Their dwell times follow from the law of sines; the rest is shared equally by both zero vectors.
"""
import math
import random

# Phases on, for the active vectors V1 .. V6.
ACTIVE = [(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 1)]


def duties(alpha, beta):
    """Of a vector in volts per bus volt inside the hexagon's inner circle."""
    length, angle = math.hypot(alpha, beta), math.atan2(beta, alpha) % (2 * math.pi)
    sector = min(int(angle / (math.pi / 3)), 5)
    rest = angle - sector * math.pi / 3
    first = math.sqrt(3) * length * math.sin(math.pi / 3 - rest)
    second = math.sqrt(3) * length * math.sin(rest)
    zero = 1 - first - second
    return [first * a + second * b + zero / 2
            for a, b in zip(ACTIVE[sector], ACTIVE[(sector + 1) % 6])]


def main():
    random.seed(9)
    print("// Printed by gen_modulator.py.")
    print("typedef struct {\n    double alpha; ///< volts per bus volt\n    double beta;\n"
          "    double duty[3];\n} modulator_case_t;\n")
    print("static const modulator_case_t modulator_cases[] = {")
    for i in range(240):
        length = random.uniform(0, 1) / math.sqrt(3)
        if i % 8 == 0:
            length = 0.999999 / math.sqrt(3)
        angle = math.radians(i * 1.5)
        a, b = length * math.cos(angle), length * math.sin(angle)
        d = ", ".join(f"{x:.9f}" for x in duties(a, b))
        print(f"    {{{a:.9f}, {b:.9f}, {{{d}}}}},")
    print("};")


main()
