"""Prints leso.h: the extended state observers as filters of the dead-beat EMF, in float64.

rho = exp(j w Ts), p = exp(-w0 Ts), q = exp(-k2 Ts), w the speed that the observer is tuned to:
    C      y += (1 - p)(m - y);  e += (1 - p)(y - e)
    GI     eps = p^2 eps1 + (m - e1);  e = e1 + (1 - p)^2 (eps + kappa BP(eps)), the index 1 one period
           back. BP is 2 wc s/(s^2 + 2 wc s + w^2) as two integrators,
               band' = 2 wc (eps - band) - w low,   low' = w band,
           solved by the trapezoidal rule with the gains prewarped at w: g = tan(w Ts/2) for w Ts/2
           and wc Ts (1 + g^2) for wc Ts. Gain exactly 1 at w; the states keep their meaning where w
           changes.
    FA     k1 = 0: e = q rho e1 + (1 - q) m
           k1 > 0: z1, z2 = exp(s1 Ts), exp(s2 Ts), s1, s2 the roots of s^2 + (k2 - j w) s + k1,
           H = 1 - c (z - 1)(z - rho)/((z - z1)(z - z2)), c = z1 z2/rho, as two modes in parallel,
           each of which keeps its state where w changes
    multi  modes at w, 0, -5 w, 7 w, each turned on by its own angle, share the error m - sum:
           gain (1 - q) of the first, kh Ts (1 - j k2/(wm - w)) of the others, half of it at DC,
           kh = min(20, 0.15 |w|). While the distance |wm - w| falls from 1.4 times NOTCH to NOTCH, the
           gain of a mode fades to 0, and in its place the mode leaks away at 20 rad/s.
"""
import cmath
import math

TS = 2e-4
STEPS, EVERY = 3000, 75
NOTCH = 250.0  # rad/s, 2.5 times the sigma of a PLL
PAPER_FA = dict(k1=10 * math.pi, k2=100 * math.pi)
SPEEDS = [(300.0, 300.0), (-300.0, -300.0), (90.0, 440.0), (-440.0, -90.0), (250.0, -250.0)]
KINDS = [  # name in C, and parameters
    ("LODE_EMF_C_LESO", dict(w0=2000.0)),
    ("LODE_EMF_GI_LESO", dict(w0=500 * math.pi, kappa=2.0, wc=math.pi)),
    ("LODE_EMF_GI_LESO", dict(w0=4000.0, kappa=6.0, wc=40.0)),
    ("LODE_EMF_FA_LESO", dict(k2=100 * math.pi)),
    ("LODE_EMF_FA_LESO", PAPER_FA),
    ("LODE_EMF_FA_LESO", dict(k1=4000.0, k2=300.0)),
    ("LODE_EMF_FA_MULTI", dict(k2=1000.0)),
]
DEFAULTS = dict(w0=2000.0, kappa=2.0, wc=math.pi, k1=0.0, k2=300.0)


def speed_at(case, k):
    return case["w_from"] + (case["w_to"] - case["w_from"]) * k / STEPS


def inputs(case):
    """(m, w): an EMF of 60 V with 6 % of 5th and 4 % of 7th harmonic, offset and a chirp as noise."""
    angle = 0.0
    for k in range(STEPS):
        w = speed_at(case, k)
        angle += w * TS
        m = 60 * cmath.exp(1j * angle) + 3.6 * cmath.exp(-5j * angle) + 2.4 * cmath.exp(7j * angle)
        chirp = 1.7 * (k % 1000) ** 2
        yield m + (2 - 1j) + complex(math.cos(chirp), math.sin(0.6 * chirp)), w


def conventional(case):
    p = math.exp(-case["w0"] * TS)
    y = e = 0j
    for m, _ in inputs(case):
        y += (1 - p) * (m - y)
        e += (1 - p) * (y - e)
        yield e


def generalised(case):
    p = math.exp(-case["w0"] * TS)
    e = eps = band = low = 0j
    for m, w in inputs(case):
        eps = p * p * eps + (m - e)
        g = math.tan(w * TS / 2)
        width = case["wc"] * TS * (1 + g * g)
        # middle = band + width (eps - middle) - g (low + g middle), the mean over the step
        middle = (band + width * eps - g * low) / (1 + width + g * g)
        band, low = 2 * middle - band, low + 2 * g * middle
        e += (1 - p) ** 2 * (eps + case["kappa"] * middle)
        yield e


def direct_generalised(case):
    """The same at constant speed: BP = b (1 - z^-2)/(1 - 2 cos(w Ts) (1 - b) z^-1 + (1 - 2 b) z^-2)."""
    p, al = math.exp(-case["w0"] * TS), case["wc"] * TS
    b, cosine = al / (1 + al), math.cos(case["w_from"] * TS)
    e = eps1 = eps2 = band1 = band2 = 0j
    for m, _ in inputs(case):
        eps = p * p * eps1 + (m - e)
        band = b * (eps - eps2) + 2 * cosine * (1 - b) * band1 - (1 - 2 * b) * band2
        e += (1 - p) ** 2 * (eps + case["kappa"] * band)
        eps1, eps2, band1, band2 = eps, eps1, band, band1
        yield e


def adaptive(case):
    q = math.exp(-case["k2"] * TS)
    e = 0j
    for m, w in inputs(case):
        e = q * cmath.exp(1j * w * TS) * e + (1 - q) * m
        yield e


def poles(case, w):
    b = case["k2"] - 1j * w
    root = cmath.sqrt(b * b - 4 * case["k1"])
    return [cmath.exp(s * TS) for s in ((-b - root) / 2, (-b + root) / 2)]


def adaptive_slow(case):
    state = [0j, 0j]
    for m, w in inputs(case):
        z = poles(case, w)
        rho = cmath.exp(1j * w * TS)
        c = z[0] * z[1] / rho
        for n in range(2):
            # Residue of H/z at z[n]: there only the second part of H counts.
            other = z[1 - n]
            gain = -c * (z[n] - 1) * (z[n] - rho) / (z[n] * (z[n] - other))
            state[n] = z[n] * state[n] + gain * m
        yield sum(state)


def direct_slow(case):
    """The same at constant speed, without modes: e = m - c (z - 1)(z - rho)/((z - z1)(z - z2)) m."""
    z1, z2 = poles(case, case["w_from"])
    rho = cmath.exp(1j * case["w_from"] * TS)
    c = z1 * z2 / rho
    x1 = x2 = d1 = d2 = 0j
    for m, _ in inputs(case):
        d = c * (m - (1 + rho) * x1 + rho * x2) + (z1 + z2) * d1 - z1 * z2 * d2
        x1, x2, d1, d2 = m, x1, d, d1
        yield m - d


def multi(case):
    orders = (1, 0, -5, 7)
    q = math.exp(-case["k2"] * TS)
    modes = [0j] * 4
    for m, w in inputs(case):
        shares = [min(1.0, max(0.0, (abs((n - 1) * w) / NOTCH - 1) / 0.4)) for n in orders]
        modes = [x * cmath.exp(1j * n * w * TS) for x, n in zip(modes, orders)]
        modes[1:] = [x * (1 - (1 - share) * 20 * TS) for x, share in zip(modes[1:], shares[1:])]
        error = m - sum(modes)
        modes[0] += (1 - q) * error
        for index, n in enumerate(orders[1:], 1):
            if shares[index]:
                kh = min(20, 0.15 * abs(w)) * (0.5 if n == 0 else 1)
                modes[index] += shares[index] * kh * TS * (1 - 1j * case["k2"] / ((n - 1) * w)) * error
        yield modes[0]


def observer(case):
    return {"LODE_EMF_C_LESO": conventional, "LODE_EMF_GI_LESO": generalised,
            "LODE_EMF_FA_LESO": adaptive_slow if case["k1"] else adaptive,
            "LODE_EMF_FA_MULTI": multi}[case["kind"]](case)


def print_case(case):
    estimates = list(observer(case))
    if case["w_from"] == case["w_to"]:
        direct = direct_slow if case["k1"] else direct_generalised
        if case["k1"] or case["kind"] == "LODE_EMF_GI_LESO":
            assert all(abs(a - b) < 1e-6 for a, b in zip(estimates, direct(case)))
    if case["k1"]:
        other = list(adaptive(case))
        assert max(abs(a - b) for a, b in zip(estimates, other)) > 0.01  # k1 shows
    kept = estimates[EVERY - 1::EVERY]
    print(f"    {{.kind = {case['kind']},")
    for name in ("w0", "kappa", "wc", "k1", "k2", "w_from", "w_to"):
        print(f"     .{name} = {case[name]:.12g},")
    print("     .e_alpha = {" + ", ".join(f"{e.real:.8f}" for e in kept) + "},")
    print("     .e_beta = {" + ", ".join(f"{e.imag:.8f}" for e in kept) + "}},")


def main():
    print("// Printed by gen_leso.py.")
    print(f"#define LESO_STEPS {STEPS}\n#define LESO_EVERY {EVERY}\n#define LESO_TS_s {TS}\n")
    print("typedef struct {\n    lode_emf_kind_t kind;\n    double w0, kappa, wc, k1, k2;\n"
          "    double w_from, w_to; ///< speed, changing evenly\n"
          "    double e_alpha[LESO_STEPS / LESO_EVERY], e_beta[LESO_STEPS / LESO_EVERY];\n"
          "} leso_case_t;\n")
    print("static const leso_case_t leso_cases[] = {")
    for kind, parameters in KINDS:
        for w_from, w_to in SPEEDS:
            print_case({**DEFAULTS, **parameters, "kind": kind, "w_from": w_from, "w_to": w_to})
    print("};")


main()
