"""Prints references.h: the best currents for a torque, found by trying every id.

For a given id the circle i_max and the voltage |R i + j w psi| = V, a quadratic in iq, leave a range of
iq. Where the torque lies in it for some id, the best of them makes it with the least current (MTPA), or
with the id nearest to 0 (id0); elsewhere the largest torque counts. Two grids, the second within the
first one's best step. Torque is over its factor (1.5 pole pairs), A Wb.
"""
import math
import random

# R, Ld, Lq, psi, i_max, V: paper 1; no saliency, psi/L = 1.25 i_max; psi/Ld = 0.67 i_max (MTPV).
MOTORS = [(0.75, 3.5e-3, 9.8e-3, 0.142, 16.0, 104.2), (0.05, 4e-4, 4e-4, 0.02, 40.0, 25.0),
          (0.012, 6e-4, 1.6e-3, 0.12, 300.0, 208.0)]
COARSE, FINE = 3000, 2000


def tau_of(motor, i_d, i_q):
    return (motor[3] + (motor[1] - motor[2]) * i_d) * i_q


def voltage(motor, w, i_d, i_q):
    R, Ld, Lq, psi = motor[:4]
    return math.hypot(R * i_d - w * Lq * i_q, R * i_q + w * (psi + Ld * i_d))


def span(motor, w, i_d):
    """Least and largest iq that circle and voltage allow, or None."""
    R, Ld, Lq, psi, i_max, V = motor
    psi_d = psi + Ld * i_d
    a = R * R + (w * Lq) ** 2
    b = R * w * (psi_d - Lq * i_d)
    c = (R * i_d) ** 2 + (w * psi_d) ** 2 - V * V
    root = b * b - a * c
    if root < 0 or abs(i_d) > i_max:
        return None
    r = math.sqrt(i_max ** 2 - i_d ** 2)
    low, high = max((-b - math.sqrt(root)) / a, -r), min((-b + math.sqrt(root)) / a, r)
    return (low, high) if low <= high else None


def best_of(motor, w, tau, mtpa, ids):
    """(rank, id, iq) of the best point; rank sorts reachable torques first."""
    found = None
    for i_d in ids:
        limits = span(motor, w, i_d)
        if limits is None:
            continue
        active = motor[3] + (motor[1] - motor[2]) * i_d
        wanted = tau / active
        i_q = min(max(wanted, limits[0]), limits[1])
        if i_q == wanted:
            rank = (0, i_d * i_d + i_q * i_q if mtpa else -i_d)
        else:
            rank = (1, abs(tau - active * i_q))
        if found is None or rank < found[0]:
            found = rank, i_d, i_q
    return found


def best(motor, w, tau, mtpa):
    i_max = motor[4]
    step = i_max / COARSE
    found = best_of(motor, w, tau, mtpa, [-i_max + k * step for k in range(COARSE + 1)])
    if found is None:
        return None
    near = found[1]
    grid = [min(near + step * (2 * k / FINE - 1), 0.0) for k in range(FINE + 1)]
    return min(found, best_of(motor, w, tau, mtpa, grid) or found)


def main():
    random.seed(11)
    print("// Printed by gen_references.py.")
    print("typedef struct {\n    int motor;\n    int mtpa;\n    double omega_rad_s;\n"
          "    double tau; ///< asked for, A Wb\n    double id_A;\n    double iq_A;\n"
          "    int reached;\n} references_case_t;\n")
    print("static const double references_motors[][6] = {")
    for motor in MOTORS:
        print("    {" + ", ".join(f"{x:.9g}" for x in motor) + "},")
    print("};\n\nstatic const references_case_t references_cases[] = {")
    for number, motor in enumerate(MOTORS):
        full = motor[4] * motor[3]
        for speed in (0.4, 0.8, 1.0, 1.2, 1.5, 2.0, 3.0, 5.0):
            for share in (0.03, 0.2, 0.5, 0.9, 1.6):
                w = random.choice((-1, 1)) * speed * motor[5] / motor[3]
                tau = random.choice((-1, 1)) * share * full
                for mtpa in (1, 0):
                    found = best(motor, w, tau, mtpa)
                    # id* = 0 is never asked for more than psi i_max, and need not reach it.
                    if found is None or (not mtpa and (share > 1 or found[0][0])):
                        continue
                    print(f"    {{{number}, {mtpa}, {w:.6f}, {tau:.7f}, {found[1]:.6f}, "
                          f"{found[2]:.6f}, {1 - found[0][0]}}},")
    print("};")


if __name__ == "__main__":
    main()
