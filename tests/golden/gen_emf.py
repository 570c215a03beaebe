"""Prints emf.h: the C-LESO on an exactly solved R-Lq circuit with a rotating EMF, in float64.

Circuit: di/dt = -mu i + (u - e)/Lq, mu = R/Lq, e = E exp(j (w t + phi)); u held over each period:
    i[k+1] = a i[k] + b u[k] - (e[k+1] - a e[k])/(Lq (mu + j w)),  a = exp(-mu Ts), b = (1-a)/R.
Observer, two forms that must agree:
    m = u[k-1] - (i[k] - a i[k-1])/b - e_sal;  y += (1-p)(m-y);  e += (1-p)(y-e),  p = exp(-w0 Ts)
    (z1, z2): z1' = z1 + (a-1) i[k-1] + b (u[k-1] - e_sal + z2);  err = i[k] - z1';
              z1 = z1' + (1-p^2) err;  z2 = z2 + (1-p)^2/b err;  e = -z2      (paper 1, eqs. 6, 11, 12)
"""
import cmath
import math
import random

PAPER = dict(R=0.75, Ld=3.5e-3, Lq=9.8e-3, psi=0.142)
SMALL = dict(R=0.032, Ld=21e-6, Lq=34e-6, psi=0.0027)
NO_R = dict(R=0.0, Ld=5e-3, Lq=5e-3, psi=0.1)
STEPS = 60
CASES = [  # motor, Ts, w0, w, active flux
    (PAPER, 2e-4, 2000.0, 471.238898, False),
    (PAPER, 2e-4, 2000.0, -94.2477796, True),
    (PAPER, 1e-4, 600.0, 900.0, True),
    (SMALL, 2.5e-5, 9000.0, 4000.0, True),
    (NO_R, 2e-4, 1500.0, 300.0, False),
]
LAG_SPEEDS_RPM = [100, 300, 900, 1500, 3000]


def circuit(m, ts):
    mu = m["R"] / m["Lq"]
    a = math.exp(-mu * ts)
    b = (1 - a) / m["R"] if m["R"] else ts / m["Lq"]
    return mu, a, b


def drive(m, ts, w, steps, u_of):
    """(u[k-1], i[k], e[k]) for k = 1 .. steps, from no current."""
    mu, a, b = circuit(m, ts)
    amplitude = abs(w) * m["psi"]
    i = 0j
    e = amplitude * 1j
    for k in range(steps):
        u = u_of(k)
        after = e * cmath.exp(1j * w * ts)
        if mu or w:
            i = a * i + b * u - (after - a * e) / (m["Lq"] * (mu + 1j * w))
        e = after
        yield u, i, e


def observe(m, ts, w0, samples, salient):
    mu, a, b = circuit(m, ts)
    p = math.exp(-w0 * ts)
    y = e = z1 = z2 = before = 0j
    for k, (u, i, _) in enumerate(samples):
        u = u - salient(k, i, before)
        dead_beat = u - (i - a * before) / b
        y += (1 - p) * (dead_beat - y)
        e += (1 - p) * (y - e)
        predicted = z1 + (a - 1) * before + b * (u + z2)
        error = i - predicted
        z1 = predicted + (1 - p * p) * error
        z2 += (1 - p) ** 2 / b * error
        before = i
        assert abs(e + z2) < 1e-7 * (1 + abs(e)), (e, -z2)
        yield e


def salient_term(m, ts, angles, w):
    """(Ld-Lq)(id[k] - id[k-1])/Ts exp(j(theta - w Ts/2)), id[k-1] at the angle turned back."""
    def term(k, i, before):
        theta = angles[k]
        d_now = (i * cmath.exp(-1j * theta)).real
        d_before = (before * cmath.exp(-1j * (theta - w * ts))).real
        return (m["Ld"] - m["Lq"]) * (d_now - d_before) / ts * cmath.exp(1j * (theta - w * ts / 2))
    return term


def lag_formula(m, ts, w0, w):
    mu, a, b = circuit(m, ts)
    rho, p = cmath.exp(1j * w * ts), math.exp(-w0 * ts)
    gamma = (rho - a) / ((mu + 1j * w) * b * m["Lq"])
    return 2 * cmath.phase(rho - p) - w * ts - cmath.phase(gamma)


def lag_simulated(m, ts, w0, w):
    samples = list(drive(m, ts, w, 4000, lambda k: 0j))
    estimate = list(observe(m, ts, w0, samples, lambda *_: 0))[-1]
    # Unwrapped towards the formula: an angle from a complex number knows no whole turns.
    lag, near = -cmath.phase(estimate / samples[-1][2]), lag_formula(m, ts, w0, w)
    return lag + 2 * math.pi * round((near - lag) / (2 * math.pi))


def row(name, values):
    print(f"     .{name} = {{" + ", ".join(values) + "},")


def print_case(m, ts, w0, w, active):
    amplitude = abs(w) * m["psi"]
    u_of = lambda k: complex(random.uniform(-1, 1), random.uniform(-1, 1)) * 2 * amplitude
    samples = list(drive(m, ts, w, STEPS, u_of))
    angles = [random.uniform(-math.pi, math.pi) for _ in range(STEPS)]
    term = salient_term(m, ts, angles, w) if active else lambda *_: 0
    estimates = list(observe(m, ts, w0, samples, term))
    print(f"    {{.Rs_Ohm = {m['R']}, .Ld_H = {m['Ld']}, .Lq_H = {m['Lq']}, .psi_Wb = {m['psi']},")
    print(f"     .ts_s = {ts}, .w0_rad_s = {w0}, .omega_rad_s = {w},")
    print(f"     .active_flux = {int(active)},")
    for name, index in (("u", 0), ("i", 1)):
        row(name + "_alpha", (f"{s[index].real:.10g}" for s in samples))
        row(name + "_beta", (f"{s[index].imag:.10g}" for s in samples))
    row("theta", (f"{x:.9f}" for x in angles))
    row("e_alpha", (f"{e.real:.10g}" for e in estimates))
    row("e_beta", (f"{e.imag:.10g}" for e in estimates))
    print("    },")


def print_lags():
    print("/// Lag behind the true EMF, read off the simulated observer once it is steady.")
    print("typedef struct {\n    double Rs_Ohm;\n    double Lq_H;\n    double ts_s;\n"
          "    double w0_rad_s;\n    double omega_rad_s;\n    double lag_rad;\n} lag_case_t;\n")
    print("static const lag_case_t lag_cases[] = {")
    cases = [(PAPER, 2e-4, 2000.0, rpm * math.pi / 10) for rpm in LAG_SPEEDS_RPM]
    cases += [(m, ts, w0, share * w) for m, ts, w0, w, _ in CASES for share in (-1, 0.3, 2)]
    for m, ts, w0, w in cases:
        lag = lag_simulated(m, ts, w0, w)
        assert abs(lag - lag_formula(m, ts, w0, w)) < 1e-9
        print(f"    {{{m['R']}, {m['Lq']}, {ts}, {w0}, {w:.9g}, {lag:.10f}}},")
    print("};")


def main():
    random.seed(11)
    print("// Printed by gen_emf.py.")
    print(f"#define EMF_STEPS {STEPS}\n")
    print("typedef struct {\n    double Rs_Ohm, Ld_H, Lq_H, psi_Wb, ts_s, w0_rad_s, omega_rad_s;\n"
          "    int active_flux;\n    double u_alpha[EMF_STEPS], u_beta[EMF_STEPS];\n"
          "    double i_alpha[EMF_STEPS], i_beta[EMF_STEPS];\n"
          "    double theta[EMF_STEPS]; ///< angle of the active-flux term\n"
          "    double e_alpha[EMF_STEPS], e_beta[EMF_STEPS]; ///< estimate\n} emf_case_t;\n")
    print("static const emf_case_t emf_cases[] = {")
    for case in CASES:
        print_case(*case)
    print("};\n")
    print_lags()


main()
