"""Prints pll.h: both PLLs following a given motion, in float64.

QPLL:      th' = th + Ts w; er = sin(theta - th'); th = th' + (1-s^2) er; w += (1-s)^2 er/Ts
LESO-QPLL: th' = th + Ts w + Ts^2/2 (f+acc); w += Ts (f+acc); er = sin(theta - th');
           th = th' + (1-s^3) er; w += 1.5 (1-s)^2 (1+s) er/Ts; f += (1-s)^3 er/Ts^2
with s = exp(-sigma Ts). The motion is a mechanical one: J/np dw/dt = Te - TL - B w/np, with a known
torque acceleration acc = np Te/J and a friction that acc holds too; f is to find -np TL/J.
"""
import math

# Speed from, torque acceleration, load acceleration (np TL/J) from step 200 on; electrical.
MOTIONS = [(300.0, 0.0, 0.0), (94.0, 1200.0, 400.0), (-250.0, -800.0, -900.0), (20.0, -2500.0, 0.0)]
GAINS = [(2e-4, 150.0), (2e-4, 60.0), (5e-5, 400.0)]  # Ts, sigma
STEPS, EVERY = 1000, 25


def motion(ts, omega, torque, load):
    """theta, acc over the period before, for each t_k; exact for constant acceleration."""
    theta = 0.4
    for k in range(STEPS):
        acc = torque - (load if k >= 200 else 0.0)
        theta += ts * omega + ts * ts / 2 * acc
        omega += ts * acc
        yield theta, torque


def follow(ts, sigma, leso, samples, omega):
    s = math.exp(-sigma * ts)
    th, w, f = 0.0, omega, 0.0
    for theta, acc in samples:
        if leso:
            th += ts * w + ts * ts / 2 * (f + acc)
            w += ts * (f + acc)
        else:
            th += ts * w
        er = math.sin(theta - th)
        if leso:
            th += (1 - s ** 3) * er
            w += 1.5 * (1 - s) ** 2 * (1 + s) * er / ts
            f += (1 - s) ** 3 * er / ts ** 2
        else:
            th += (1 - s * s) * er
            w += (1 - s) ** 2 * er / ts
        yield th, w, f


def main():
    print("// Printed by gen_pll.py.")
    print(f"#define PLL_STEPS {STEPS}\n#define PLL_EVERY {EVERY}\n")
    print("typedef struct {\n    int third_order;\n    double ts_s, sigma_rad_s;\n"
          "    double omega_rad_s, torque_rad_s2, load_rad_s2; ///< the motion\n"
          "    double theta[PLL_STEPS / PLL_EVERY]; ///< modulo 2 pi, every PLL_EVERY steps\n"
          "    double omega[PLL_STEPS / PLL_EVERY];\n    double f[PLL_STEPS / PLL_EVERY];\n"
          "} pll_case_t;\n")
    print("static const pll_case_t pll_cases[] = {")
    for leso in (1, 0):
        for ts, sigma in GAINS:
            for omega, torque, load in MOTIONS:
                samples = list(motion(ts, omega, torque, load))
                states = list(follow(ts, sigma, leso, samples, omega))[EVERY - 1::EVERY]
                print(f"    {{{leso}, {ts}, {sigma}, {omega}, {torque}, {load},")
                wrapped = [math.remainder(x[0], 2 * math.pi) for x in states]
                print("     {" + ", ".join(f"{x:.8f}" for x in wrapped) + "},")
                print("     {" + ", ".join(f"{x[1]:.8g}" for x in states) + "},")
                print("     {" + ", ".join(f"{x[2]:.8g}" for x in states) + "}},")
    print("};")


main()
