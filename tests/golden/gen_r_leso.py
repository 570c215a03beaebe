"""Prints r_leso.h: the R-LESO as a filter of the dead-beat EMF, in float64.

p = exp(-w0 Ts), rho = exp(j w Ts), w the speed that the observer is tuned to. In the frame that turns by w Ts
in every period, from any start on, e/m = ((1 - p)/(1 - p/z))^2: the C-LESO. Written here as the recursion
    e[k] = 2 p e[k-1] - p^2 e[k-2] + (1 - p)^2 m[k]
of the vectors seen from that frame, the firmware has two stages in the stationary one.
"""
import cmath
import math

TS = 2e-4
STEPS, EVERY = 3000, 75
BANDWIDTHS = [200.0, 2000.0, 9000.0]
SPEEDS = [(300.0, 300.0), (-300.0, -300.0), (90.0, 440.0), (-440.0, -90.0), (250.0, -250.0), (0.0, 0.0)]


def inputs(w_from, w_to):
    """(m, w): an EMF of 60 V with 6 % of 5th and 4 % of 7th harmonic, offset and a chirp as noise."""
    angle = 0.0
    for k in range(STEPS):
        w = w_from + (w_to - w_from) * k / STEPS
        angle += w * TS
        m = 60 * cmath.exp(1j * angle) + 3.6 * cmath.exp(-5j * angle) + 2.4 * cmath.exp(7j * angle)
        chirp = 1.7 * (k % 1000) ** 2
        yield m + (2 - 1j) + complex(math.cos(chirp), math.sin(0.6 * chirp)), w


def estimates(w0, w_from, w_to):
    p = math.exp(-w0 * TS)
    frame = 0.0
    before = [0j, 0j]
    for m, w in inputs(w_from, w_to):
        frame += w * TS
        seen = 2 * p * before[0] - p * p * before[1] + (1 - p) ** 2 * m * cmath.exp(-1j * frame)
        before = [seen, before[0]]
        yield seen * cmath.exp(1j * frame)


def main():
    print("// Printed by gen_r_leso.py.")
    print(f"#define R_LESO_STEPS {STEPS}\n#define R_LESO_EVERY {EVERY}\n#define R_LESO_TS_s {TS}\n")
    print("typedef struct {\n    double w0;\n    double w_from, w_to; ///< speed, changing evenly\n"
          "    double e_alpha[R_LESO_STEPS / R_LESO_EVERY], e_beta[R_LESO_STEPS / R_LESO_EVERY];\n"
          "} r_leso_case_t;\n")
    print("static const r_leso_case_t r_leso_cases[] = {")
    for w0 in BANDWIDTHS:
        for w_from, w_to in SPEEDS:
            kept = list(estimates(w0, w_from, w_to))[EVERY - 1::EVERY]
            print(f"    {{.w0 = {w0:g},\n     .w_from = {w_from:g},\n     .w_to = {w_to:g},")
            print("     .e_alpha = {" + ", ".join(f"{e.real:.8f}" for e in kept) + "},")
            print("     .e_beta = {" + ", ".join(f"{e.imag:.8f}" for e in kept) + "}},")
    print("};")


main()
