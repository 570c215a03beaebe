"""Closed loop, switched inverter, correction on: parameter errors one at a time, and the steps,
ramps and harmonics that the enhanced estimator is built for. Prints its tables.

The bars are those of the requirements; the steps of load are full steps from no load, which is
more than a steady load asks for. All figures are electrical degrees, estimate less truth.
"""
import concurrent.futures
import csv
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import FULL, SOURCE, Checks, Folder

DATA = SOURCE / "sim/data"
HEAD = f"""[scenario]
motor = {DATA}/motors/jiang2022.ini
drive = {DATA}/drives/jiang2022.ini
plant = {DATA}/plants/jiang2022.ini
"""
RATED_RPM, RATED_NM = 1500, 5
BAR_DEG = 10.0

NONE = {}
ALL = {"plant.Rs_Ohm": 0.9, "plant.Lq_H": 9.8e-3 / 1.15, "plant.J_kgm2": 0.0174 / 1.5,
       "plant.psi_Wb": 0.142 / 1.03, "plant.i_noise_A": 0.1, "plant.i_offset_a_A": 0.2}
ONE_BY_ONE = {
    "no error": NONE,
    "Rs -20 %": {"plant.Rs_Ohm": 0.6},
    "Rs +20 %": {"plant.Rs_Ohm": 0.9},
    "Lq x0.85": {"plant.Lq_H": 0.85 * 9.8e-3},
    "Lq x1.15": {"plant.Lq_H": 1.15 * 9.8e-3},
    "J x0.5": {"plant.J_kgm2": 0.5 * 0.0174},
    "J x2": {"plant.J_kgm2": 2 * 0.0174},
    "psi -3 %": {"plant.psi_Wb": 0.97 * 0.142},
    "psi +3 %": {"plant.psi_Wb": 1.03 * 0.142},
    "noise 0.1 A": {"plant.i_noise_A": 0.1},
    "offset 0.2 A": {"plant.i_offset_a_A": 0.2, "plant.i_offset_b_A": -0.2},
}


def settings(values):
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


def phases(*steps):
    """Text of phases (duration_s, speed_rpm, load_Nm)."""
    return "".join(f"[phase.p{n}]\nduration_s = {d}\nspeed_rpm = {s}\nload_Nm = {l}\n"
                   for n, (d, s, l) in enumerate(steps))


def run(folder, name, text, values, *more):
    """The phases of one run and whether it lost lock, or failed otherwise."""
    folder.write(f"{name}.ini", HEAD + text)
    done = folder.run("run", f"{name}.ini", "--json", f"{name}.json", *settings(values), *more)
    result = folder.json(f"{name}.json")
    return result["phases"], done.returncode != 0 or result["fault"] is not None


def one_case(folder, number, case):
    emf, share, direction, load, values = case
    text = phases((3, direction * share * RATED_RPM, 0),
                  (2, direction * share * RATED_RPM, direction * load * RATED_NM))
    done, lost = run(folder, f"case{number}", text, {"estimator.emf": emf, **values})
    error = done[-1]["angle_error_max_deg"]
    return math.inf if lost or error is None else error  # None: it still starts


def worst_of(folder, emf, shares, values):
    cases = [(emf, share, direction, load, values)
             for share in shares for direction in (1, -1) for load in (-1, 0, 1)]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return max(pool.map(lambda n: one_case(folder, f"{emf}{n}", cases[n]), range(len(cases))))


def parameter_errors(checks, folder):
    """0.25 to 1 of rated speed, both directions, load -1 to 1: none lost, none beyond 10 degrees."""
    shares = (0.25, 0.5, 0.75, 1.0) if FULL else (0.25, 1.0)
    print(f"largest error in a full step of load, {shares} of rated speed; at 0.1 of it")
    for emf in ("c-leso", "fa-leso"):
        for name, values in {**ONE_BY_ONE, "all together": ALL}.items():
            worst = worst_of(folder, emf, shares, values)
            low = worst_of(folder, emf, (0.1,), values) if FULL or name in ("no error",
                                                                          "all together") else None
            shown = "" if low is None else ("    lost" if math.isinf(low) else f"{low:8.2f}")
            print(f"  {emf:8} {name:14} {worst:8.2f} {shown}")
            if name != "all together":
                checks.at_most(worst, BAR_DEG, f"{emf}, {name}")


# 100 rad/s from 300 rpm on; the hand-over at 150 rpm wants less.
SIGMA = {"estimator.sigma_rad_s": 100, "estimator.sigma_low_rad_s": 50}
ENHANCED = {"estimator.pll": "enhanced", **SIGMA}
CHAINS = {"enhanced": ENHANCED, "leso-qpll": SIGMA, "qpll": {"estimator.pll": "qpll", **SIGMA}}


def steady(checks, folder):
    text = phases((2, 300, 0), *[(2, rpm, load) for rpm in (300, 600, 900, 1200, 1500)
                                 for load in (5, -5)])
    for name, values in CHAINS.items():
        done, lost = run(folder, f"steady-{name}", text, values)
        dc = max(abs(p["angle_error_deg"]["mean"] or math.inf) for p in done[1:])
        pp = max(p["angle_error_deg"]["pp"] or math.inf for p in done[1:])
        print(f"steady, 300..1500 rpm, +-5 Nm, {name}: |DC| {dc:.3f}, pp {pp:.2f}"
              f"{', LOST' if lost else ''}")
        if name == "enhanced":
            checks.true(not lost, "steady: enhanced loses lock")
            checks.at_most(dc, 0.5, "steady |DC|, enhanced")
            checks.at_most(pp, 1.0, "steady pp, enhanced")


def deviation(folder, name, values, rpm):
    """Largest deviation from the error before, when 5 Nm go."""
    text = phases((2, 300, 0), (3, rpm, 5), (1, rpm, 0))
    done, lost = run(folder, name, text, values, "--csv", f"{name}.csv", "--set",
                     "scenario.log_s=0.0002")
    if lost:
        return math.inf
    rows = list(csv.DictReader((folder.path / f"{name}.csv").open()))
    before = done[1]["angle_error_deg"]["mean"]
    return max(abs(float(row["angle_error_deg"]) - before) for row in rows if float(row["t_s"]) > 5)


def dynamics(checks, folder):
    for name, values in CHAINS.items():
        for rpm in (300, 1500):
            moved = deviation(folder, f"step-{name}-{rpm}", values, rpm)
            print(f"load 5 -> 0 Nm at {rpm} rpm, {name}: deviation {moved:.2f}")
            if name == "enhanced":
                checks.at_most(moved, 2.0, f"load step at {rpm} rpm, enhanced")
        text = phases((2, 300, 0), (2, 1500, 0), (2, 300, 0))
        done, lost = run(folder, f"ramp-{name}", text, {"speed.ramp_rpm_s": 2000, **values})
        worst = math.inf if lost else max(p["angle_error_max_deg"] for p in done[1:])
        print(f"ramp 300-1500-300 rpm at 2000 rpm/s, {name}: {worst:.2f}")
        if name == "enhanced":
            checks.at_most(worst, 4.0, "ramp, enhanced")


def sixth(folder, name, values):
    """Amplitude of the 6th order in the angle error over the last second at 900 rpm."""
    # In phase at the motor's zero angle, both turn the EMF the same way.
    harmonics = {"plant.emf5_ratio": 0.03, "plant.emf7_ratio": 0.03}
    text = phases((2, 300, 0), (4, 900, 5))
    _, lost = run(folder, name, text, {**harmonics, **values}, "--csv", f"{name}.csv", "--set",
                  "scenario.log_s=0.0002")
    if lost:
        return math.inf
    rows = [(float(r["theta_e_rad"]), float(r["angle_error_deg"]))
            for r in csv.DictReader((folder.path / f"{name}.csv").open()) if float(r["t_s"]) >= 5]
    mean = sum(e for _, e in rows) / len(rows)
    in_phase = sum((e - mean) * math.cos(6 * t) for t, e in rows)
    quadrature = sum((e - mean) * math.sin(6 * t) for t, e in rows)
    return 2 * math.hypot(in_phase, quadrature) / len(rows)


def harmonics(checks, folder):
    without = sixth(folder, "harmonics-without", CHAINS["leso-qpll"])
    with_notch = sixth(folder, "harmonics-with", ENHANCED)
    print(f"3 % 5th and 7th at 900 rpm, 6th order of the error: {with_notch:.3f} with the notch, "
          f"{without:.2f} without")
    checks.at_most(with_notch, 0.05, "6th order with the notch")
    # Closed form: 3 % of 57.3 degrees each, through C-LESO 1/(1 + (n w/w0)^2) and the PLL's
    # 3 sigma/(6 w). The current control's own response is not in it: 15 %.
    omega, w0, sigma = 900 * math.pi / 30 * 3, 2000, 100
    passed = sum(1 / (1 + (n * omega / w0) ** 2) for n in (5, 7))
    expected = math.degrees(0.03) * passed * 3 * sigma / (6 * omega)
    checks.true(abs(without - expected) < 0.15 * expected,
                f"6th order without the notch: {without}, closed form {expected:.3f}")


def main():
    checks = Checks()
    with Folder() as folder:
        steady(checks, folder)
        dynamics(checks, folder)
        harmonics(checks, folder)
        parameter_errors(checks, folder)
    checks.done()


main()
