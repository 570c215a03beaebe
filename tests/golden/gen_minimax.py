"""Prints minimax.h: the polynomials of lode_sincos and lode_atan2, and how far they are off.

Each is the interpolation at Chebyshev nodes in t = r^2, which is within a few per cent of minimax.
"""
import math

QUARTER = (math.pi / 4 * 1.0005) ** 2  # a little more than the reduction leaves


def solve(rows):
    """Gauss-Jordan with partial pivoting on the rows [a | b]."""
    n = len(rows)
    for c in range(n):
        p = max(range(c, n), key=lambda r: abs(rows[r][c]))
        rows[c], rows[p] = rows[p], rows[c]
        for r in range(n):
            if r != c:
                k = rows[r][c] / rows[c][c]
                rows[r] = [a - k * b for a, b in zip(rows[r], rows[c])]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def interpolate(f, end, n):
    nodes = [end / 2 * (1 + math.cos(math.pi * (2 * i + 1) / (2 * n))) for i in range(n)]
    return solve([[t ** j for j in range(n)] + [f(t)] for t in nodes])


def horner(coefficients, t):
    value = 0.0
    for c in reversed(coefficients):
        value = value * t + c
    return value


def series(terms, t):
    return sum(c * t ** j for j, c in enumerate(terms))


def sin_part(t):
    if t < 1e-3:
        return series([-1 / 6, 1 / 120, -1 / 5040, 1 / 362880], t)
    r = math.sqrt(t)
    return (math.sin(r) / r - 1) / t


def cos_part(t):
    if t < 1e-3:
        return series([-1 / 2, 1 / 24, -1 / 720, 1 / 40320], t)
    return (math.cos(math.sqrt(t)) - 1) / t


def atan_part(t):
    if t < 1e-3:
        return series([-1 / 3, 1 / 5, -1 / 7, 1 / 9], t)
    r = math.sqrt(t)
    return (math.atan(r) / r - 1) / t


def worst(model, truth, end):
    return max(abs(model(end * i / 20000) - truth(end * i / 20000)) for i in range(20001))


def show(name, text, coefficients, bound):
    print(f"/// {text}")
    print(f"static const double {name}[] = {{")
    for c in coefficients:
        print(f"    {c:.10e},")
    print("};")
    print(f"/// Largest error of it in exact arithmetic, rounded up.")
    print(f"static const double {name}_error = {bound:.1e};\n")


def rounded_up(x):
    digits = 10 ** (1 - math.floor(math.log10(x)))
    return math.ceil(x * digits) / digits


def main():
    s = interpolate(sin_part, QUARTER, 3)
    c = interpolate(cos_part, QUARTER, 4)
    c[0] = -0.5  # exact for small angles
    a = interpolate(atan_part, 1.0, 7)
    end = math.sqrt(QUARTER)
    sin_error = worst(lambda r: r * (1 + r * r * horner(s, r * r)), math.sin, end)
    cos_error = worst(lambda r: 1 + r * r * horner(c, r * r), math.cos, end)
    atan_error = worst(lambda r: r * (1 + r * r * horner(a, r * r)), math.atan, 1.0)
    print("// Printed by gen_minimax.py.")
    show("minimax_sin", "sin(r) = r + r t (c0 + c1 t + c2 t^2), t = r^2, |r| <= pi/4", s,
         rounded_up(sin_error))
    show("minimax_cos", "cos(r) = 1 + t (c0 + c1 t + c2 t^2 + c3 t^3), c0 set to -1/2", c,
         rounded_up(cos_error))
    show("minimax_atan", "atan(r) = r + r t (c0 + .. + c6 t^6), |r| <= 1", a, rounded_up(atan_error))


main()
