"""`lodestar reproduce jiang2022`: every value against golden/reproduce_jiang2022.json.

Each expectation there names its independent source, or is called ours. Those in closed form are
computed here again, so that what is stored is no copy of what the tool says.

`lodestar reproduce li-fa-leso`: what the estimators must reach, against recursions and closed forms
written here anew.
"""
import cmath
import contextlib
import csv
import io
import itertools
import json
import math
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, FULL, MOTOR, RECORDINGS, SOURCE, Checks, Folder, refused

sys.path.insert(0, str(SOURCE / "tests/tools"))
import papers_page

GOLDEN = SOURCE / "tests/golden/reproduce_jiang2022.json"
TIME_MAX_s = 1500 if FULL else 300
SEEDS = [] if FULL else ["--seeds", "1-1"]  # the default is 1-5
FIGURES = ["fig12", "fig13", "fig14", "fig15", "fig16", "fig17", "fig18", "fig19"]
TABLES = ["table1", "table2", "fig7", "acceleration", "eq14", "start"]
GONE = ["lost", "stalls"]

# Paper 1, Table 3 and Section 5; drops of sim/data/plants/jiang2022.ini.
TS, NP, RS, LD, LQ, PSI, J, B = 2e-4, 3, 0.75, 3.5e-3, 9.8e-3, 0.142, 0.0174, 7.5e-4
W0, SIGMA, DEAD_TIME, BUS, DROP, R_ON = 2000.0, 150.0, 4e-6, 200.0, 1.0, 0.05


# ---- Closed forms -------------------------------------------------------------------------------

def omega(rpm):
    return NP * rpm * math.pi / 30


def euler_lag(rpm):
    turn = omega(rpm) * TS
    return math.degrees(2 * cmath.phase(cmath.exp(1j * turn) - 1 + W0 * TS) - turn / 2)


def eq30(rpm):
    w = omega(rpm)
    return math.degrees(math.atan(2 * W0 * w / (W0 ** 2 - w ** 2)))


def current_for(torque, lag):
    """The current on the estimated q axis, `lag` behind the rotor's, that makes the torque."""
    low, high = 0.0, 40.0
    for _ in range(80):
        middle = (low + high) / 2
        psi_a = PSI + (LD - LQ) * middle * math.sin(lag)
        low, high = ((middle, high) if 1.5 * NP * psi_a * middle * math.cos(lag) < torque
                     else (low, middle))
    return low, PSI + (LD - LQ) * low * math.sin(lag)


def rated_dc(rpm, compensated):
    """The lag that is left, with the voltage lost along the current; by bisection on the angle."""
    left = math.radians(euler_lag(rpm) - (eq30(rpm) if compensated else 0))
    torque = 5 + B * omega(rpm) / NP

    def surplus(delta):
        current, psi_a = current_for(torque, delta)
        phi = left - RS * current * TS / (2 * psi_a)
        lost = 4 / math.pi * (DEAD_TIME / TS * BUS + DROP) + R_ON * current
        return delta - phi - math.asin(lost * math.sin(phi) / (omega(rpm) * psi_a))

    low, high = -0.3, 0.7
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if surplus(middle) < 0 else (low, middle)
    return -math.degrees(low)


def mismatch(rpm, factor):
    """The least angle that carries the load: with s = sin(delta), I = psi s/(dL - (Lq - Ld) s^2)."""
    torque = 5 + B * omega(rpm) / NP
    off = (1 - factor) * LQ
    best = None
    for k in range(1, 10000):
        s = math.copysign(k / 10000, off)
        current = PSI * s / (off - (LQ - LD) * s * s)
        psi_a = PSI + (LQ - LD) * current * s
        if current <= 0 or psi_a <= 0:
            break
        if 1.5 * NP * psi_a * current * math.sqrt(1 - s * s) >= torque:
            best = math.degrees(math.asin(s))
            break
    return best


def sampled_loop(sigma, k=0.1, w_re=600.0):
    """Crossover and margin of the library's PLL with notch, as built (docs/theory/pll.md)."""
    q = math.exp(-sigma * TS)
    l1, l2, l3 = 1 - q ** 3, 1.5 * (1 - q) ** 2 * (1 + q) / TS, (1 - q) ** 3 / TS ** 2

    def gain(w):
        z = cmath.exp(1j * w * TS)
        f = l3 / (z - 1)
        v = (l2 + TS * f) / (z - 1)
        x = (l1 + TS * v + TS ** 2 / 2 * f) / (z - 1)
        # The bilinear transform, prewarped to w_re.
        s = w_re / math.tan(w_re * TS / 2) * (z - 1) / (z + 1)
        return (x + TS * v + TS ** 2 / 2 * f) * (s * s + w_re ** 2) / (s * s + k * w_re * s
                                                                       + w_re ** 2)

    return crossover(gain, sigma)


def printed_loop(sigma, k=0.1, w_re=600.0):
    """The same of eq. 35 as it stands."""
    def gain(w):
        s = 1j * w
        return (1 + sigma / s) ** 3 * (s * s + w_re ** 2) / (s * s + k * w_re * s + w_re ** 2)

    return crossover(gain, sigma)


def crossover(gain, sigma):
    """Where the gain falls through one below the notch at 600 rad/s, and the phase margin there."""
    low, high = sigma, 590.0
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if abs(gain(middle)) > 1 else (low, middle)
    return low, 180 + math.degrees(cmath.phase(gain(low)))


def closed_forms():
    d = NP * 5 / J
    ramp = omega(2000)
    q = math.exp(-SIGMA * TS)
    golden = (1 + math.sqrt(5)) / 2
    values = {"table1_3": {"as_printed": -math.degrees(ramp / SIGMA ** 2),
                           "exact": -math.degrees(ramp * TS ** 2 * q ** 2 / (1 - q) ** 2)}}
    for sigma in (80, 120, 160):
        for k, (exact, printed) in enumerate(zip(sampled_loop(sigma), printed_loop(sigma))):
            values[f"table2_{sigma}_{k + 1}"] = {"exact": exact, "as_printed": printed}
    for rpm in (300, 600, 900, 1200, 1500):
        values[f"fig14_qpll_{rpm}_dc"] = {"theory": -euler_lag(rpm)}
        values[f"fig14_enhanced_{rpm}_dc"] = {"theory": eq30(rpm) - euler_lag(rpm)}
    values["fig14_enhanced_300_ideal_dc"] = {"as_printed": eq30(300) - euler_lag(300)}
    for rpm in (300, 1500):
        values[f"fig15_qpll_{rpm}_dc"] = {"theory": rated_dc(rpm, False)}
        values[f"fig15_enhanced_{rpm}_dc"] = {"theory": rated_dc(rpm, True)}
        figure = "fig18" if rpm == 300 else "fig19"
        for percent in (50, 75, 125, 200):
            values[f"{figure}_enhanced_{rpm}_Lq_{percent}"] = {
                "theory": mismatch(rpm, percent / 100)}
        figure = "fig16" if rpm == 300 else "fig17"
        for pll, angle, speed in (("qpll", 1, 2),
                                  ("enhanced", 2 * math.exp(-2),
                                   (golden + golden ** 2) * math.exp(-golden))):
            values[f"{figure}_{pll}_{rpm}_swing"] = {"theory": math.degrees(angle * d / SIGMA ** 2)}
            values[f"{figure}_{pll}_{rpm}_estimate"] = {
                "theory": speed * d / SIGMA * 30 / math.pi / NP}
    return values


IDEAL = """[drive]
dead_time_s = 0
v_drop_V = 0
r_on_Ohm = 0
[plant]
inverter = ideal
load_kind = signed
"""


# ---- The papers' forms in replay and run ---------------------------------------------------------

def replayed(checks, folder, rpm, emf, pll, *more):
    recording = RECORDINGS / f"steady-{rpm}rpm-5Nm.csv"
    done = folder.run("replay", "--motor", MOTOR, "--recording", recording, "--emf", emf, "--pll",
                      pll, "--set", f"estimator.w0_rad_s={W0}", "--set",
                      f"estimator.sigma_rad_s={SIGMA}", "--json", "e.json", *more)
    checks.equal(done.returncode, 0, f"exit code, {emf} {pll}: {done.stderr}")
    return folder.json("e.json")["angle_error_mean_deg"]


def replays(checks, folder):
    """Recordings of another simulator: what Euler leaves is its lag, and Rs i half a period late."""
    for rpm in (300, 1500):
        late = math.degrees(RS * 5 / (1.5 * NP * PSI) * TS / (2 * PSI))
        printed = late - euler_lag(rpm)
        for pll, wanted in (("qpll-euler", printed), ("leso-qpll-euler", printed),
                            ("enhanced-euler", printed + eq30(rpm))):
            error = replayed(checks, folder, rpm, "c-leso-euler", pll)
            checks.true(abs(error - wanted) <= 0.03,
                        f"{pll} at {rpm} rpm: {error}, expected {wanted}")
        for emf in ("c-leso-euler", "fa-leso-euler"):
            error = replayed(checks, folder, rpm, emf, "enhanced-euler", "--set",
                             "estimator.compensation=exact")
            checks.true(abs(error - late) <= 0.03, f"{emf} at {rpm} rpm: {error}, expected {late}")
        error = replayed(checks, folder, rpm, "c-leso-euler", "enhanced-euler", "--set",
                         "estimator.compensation=none")
        checks.true(abs(error - printed) <= 0.03, f"no eq. 30 at {rpm} rpm: {error}")


def closed_loop(checks, folder):
    """From standstill: the library's estimate makes the start, then the papers' form takes over.

    At 300 rpm: below, it is 60 to 76 degrees off on its way in, and whether it keeps the rotor is chance.
    """
    text = f"""[scenario]
motor = {MOTOR}
drive = {DRIVE}
[estimator]
emf = c-leso-euler
w0_rad_s = {W0}
sigma_rad_s = 100
{IDEAL}[start]
handover_rpm = 300
[phase.start]
duration_s = 2.5
speed_rpm = 400
end_mode = run
[phase.900]
duration_s = 1.5
speed_rpm = 900
load_Nm = 2
"""
    for pll, wanted in (("enhanced-euler", eq30(900) - euler_lag(900)), (None, -euler_lag(900)),
                        ("qpll-euler", -euler_lag(900))):
        folder.write("e.ini", text)
        more = [] if pll is None else ["--set", f"estimator.pll={pll}"]
        done = folder.run("run", "e.ini", "--json", "e.json", *more)
        checks.equal(done.returncode, 0, f"exit code with {pll}: {done.stdout}{done.stderr}")
        phase = folder.json("e.json")["phases"][-1]
        error = phase["angle_error_deg"]["mean"]
        checks.true(error is not None and abs(error - wanted) <= 0.6,
                    f"{pll} at 900 rpm: {error}, expected {wanted}")
        checks.at_most(abs(phase["speed_rpm"]["mean"] - 900), 5, f"{pll}: rpm off 900")


def mismatch_under_way(checks, folder):
    """Lq_factor of a phase is posted to the running drive."""
    text = f"""[scenario]
motor = {MOTOR}
drive = {DRIVE}
[estimator]
source = seeded
seeded_s = 1.5
{IDEAL}[references]
id_bias_A = none
[phase.start]
duration_s = 2.5
speed_rpm = 900
load_Nm = 0
[phase.load]
duration_s = 1
load_Nm = 5
[phase.wrong]
duration_s = 1
Lq_factor = 0.75
[phase.right]
duration_s = 1
Lq_factor = 1
"""
    folder.write("e.ini", text)
    done = folder.run("run", "e.ini", "--json", "e.json")
    checks.equal(done.returncode, 0, f"exit code: {done.stdout}{done.stderr}")
    phases = {phase["name"]: phase["angle_error_deg"]["mean"]
              for phase in folder.json("e.json")["phases"]}
    for name, wanted in (("load", 0), ("wrong", mismatch(900, 0.75)), ("right", 0)):
        checks.true(abs(phases[name] - wanted) <= 0.1, f"{name}: {phases[name]}, {wanted}")


# ---- Paper 2 ------------------------------------------------------------------------------------

# Stand-in: sim/data/motors/eldeeb2017.ini; Table II.
TS6, NP6, RS6, LD6, LQ6, PSI6, J6, B6 = 1e-4, 5, 0.8, 6.4e-3, 17.4e-3, 0.1746, 0.01, 1e-3
W06, KAPPA6, K16, K26, SIGMA6 = 500 * math.pi, 2.0, 10 * math.pi, 100 * math.pi, 150.0
RATED6 = 6.25  # Nm, the project's choice: the paper's load steps of 80 % are 5 Nm
RATED6_A = RATED6 / (3 * NP6 * PSI6)
LI_SPEEDS = {300: "fig10", 600: "fig11", 840: "fig12"}
LI_FIGURES = ["table1", "table2", "fig4", "fig10", "fig11", "fig12", "load80", "load20", "fig13", "fig14", "fig15",
              "fig16", "fig17", "fig18", "eq42", "xy", "k2"]
SPECTRA = {("li", "fig13"), ("li", "fig14"), ("li", "fig15")}
LI_PLOTS = ["fig10", "fig11", "fig12", "fig13", "fig14", "fig15", "fig16", "fig17", "fig18", "k2"]
LI_TIME_MAX_s = 1500 if FULL else 300


def degrees(gain):
    return math.degrees(cmath.phase(gain))


def printed6(observer, w, tuned):
    """Eqs. 17, 29, 26."""
    s = 1j * w
    if observer == "fa":
        return (K16 + K26 * s) / (s * s - 1j * tuned * s + K16 + K26 * s)
    g = 0
    if observer == "gi":
        g = 2 * KAPPA6 * W06 ** 2 * math.pi * s / (s * s + 2 * math.pi * s + tuned ** 2)
    return (g + W06 ** 2) / (s * s + 2 * W06 * s + g + W06 ** 2)


def recursion6(observer, w, euler):
    """Gain at w by running the recursions themselves on a current that turns: no formula in common."""
    mu = RS6 / LQ6
    a = math.exp(-mu * TS6)
    b = (1 - a) / RS6
    rho = cmath.exp(1j * w * TS6)
    p = math.exp(-W06 * TS6)
    # u = 0: the current that an EMF of 1 V drives, at t_k; exact.
    def current(k):
        return -rho ** k / (RS6 + 1j * w * LQ6)
    e = z1 = z2 = stage = eps = 0
    band = low = 0
    before = current(0)
    z1 = before
    steps = 30000 if observer == "gi" else 4000
    for k in range(1, steps):
        now = current(k)
        if euler:
            error = z1 - before
            if observer == "fa":
                x2 = -(K16 * z2 + K26 * error)
                z1 += TS6 * (x2 - mu * z1 + (mu + 1j * w) * error)
                z2 += TS6 * error
                e = LQ6 * (K16 * z2 + K26 * (z1 - now))
            else:
                extra = band if observer == "gi" else 0
                if observer == "gi":
                    band += TS6 * (2 * KAPPA6 * W06 ** 2 * math.pi * error - 2 * math.pi * band
                                   - w * w * low)
                    low += TS6 * band
                z1, z2 = (z1 + TS6 * (z2 - RS6 / LQ6 * before - 2 * W06 * error),
                          z2 - TS6 * (W06 ** 2 * error + extra))
                e = -LQ6 * z2
        else:
            m = -(now - a * before) / b
            if observer == "c":
                stage += (1 - p) * (m - stage)
                e += (1 - p) * (stage - e)
            elif observer == "fa":
                q = math.exp(-K26 * TS6)
                e = q * rho * e + (1 - q) * m
            else:
                # The band-pass passes eps, at its own speed, once settled.
                eps = p * p * eps + (m - e)
                e += (1 - p) ** 2 * (1 + KAPPA6) * eps
        before = now
    return e / rho ** (steps - 1)


def held6(load, factor):
    """The angle that carries the load with a wrong Lq; None: there is none."""
    torque = load + B6 * 10 * math.pi
    off = (1 - factor) * LQ6
    for k in range(1, 20000):
        s = math.copysign(k / 20000, off)
        current = PSI6 * s / (off - (LQ6 - LD6) * s * s)
        psi_a = PSI6 + (LQ6 - LD6) * current * s
        if current <= 0 or psi_a <= 0:
            return None
        if 3 * NP6 * psi_a * current * math.sqrt(1 - s * s) >= torque:
            return math.degrees(math.asin(s))
    return None


def near(checks, value, wanted, most, what):
    """Neither "lost" nor nothing, and at most `most` off."""
    off = abs(value - wanted) if isinstance(value, (int, float)) else math.inf
    checks.at_most(off, most, f"{what} ({value})")


def missed6(checks, value, bar, most, what, why):
    """A bar that this machine does not meet is named, with its cause; `most` holds."""
    near(checks, value, 0, most, what)
    if isinstance(value, (int, float)) and abs(value) > bar:
        print(f"missed: {what}: {value:.2f}, wanted {bar}: {why}")


def steady6(checks, rows):
    """Uncompensated: the lag of the recursion. Compensated: nothing. Dead time, corrected: little."""
    for rpm, figure in LI_SPEEDS.items():
        w = NP6 * rpm * math.pi / 30
        for observer in ("c", "gi", "fa"):
            raw = degrees(recursion6(observer, w, False))
            euler = degrees(recursion6(observer, w, True))
            for load in (figure, "load80"):
                row = rows[f"{load}_{observer}_{rpm}_mean"]
                name = row["id"]
                checks.true(abs(row["theory"] - degrees(printed6(observer, w, w))) <= 0.01,
                            f"{name}: theory {row['theory']}")
                near(checks, row["exact"], 0, 0.1, f"{name}: |mean| exact")
                near(checks, row["exact_uncompensated"], raw, 0.05,
                     f"{name}: exact raw off the recursion's {raw}")
                # Under load Euler takes Rs i a period late: Rs I w Ts/E = 0.05 deg.
                near(checks, row["as_printed"], euler, 0.05 if load == figure else 0.1,
                     f"{name}: printed off the recursion's {euler}")
        near(checks, rows[f"{figure}_fa_{rpm}_mean"]["corrected"], 0, 1.0,
             f"FA {figure} {rpm} rpm: |mean| behind dead time, corrected")
        missed6(checks, rows[f"load80_fa_{rpm}_mean"]["corrected"], 0.5, 0.5 if rpm == 300 else 1.0,
                f"FA 80 % load {rpm} rpm: |mean| behind dead time, corrected",
                "the ripple of the phase currents, as the xy plane has only 0.9 mH")
        near(checks, rows[f"load80_fa_{rpm}_pp"]["corrected"], 0, 2.3, f"FA {rpm} rpm: pp, 80 % load")
        near(checks, rows[f"load20_fa_{rpm}_mean"]["exact"], 0, 0.1, f"FA {rpm} rpm, 20 % load")


def dynamics6(checks, rows):
    for observer in ("c", "fa"):
        for column in ("exact", "corrected"):
            # Behind dead time by the instant at which the ramps begin: 2.1 and 3.9 degrees have been seen. The paper claims 4.5.
            bar = 4.5 if column == "corrected" else 2.5
            near(checks, rows[f"fig16_{observer}_swing"][column], 0, bar, f"ramps, {observer}, {column}")
    for name in ("fig17_c", "fig17_fa_fast"):
        for when in ("on", "off"):
            near(checks, rows[f"{name}_{when}"]["exact"], 0, 4.0, f"{name}, load {when}")
    checks.true(rows["fig17_fa_on"]["exact"] > rows["fig17_fa_fast_on"]["exact"] + 1,
                "the paper's k2 costs more than a degree")
    print(f"load step of 5 Nm, FA-LESO with the paper's k2: {rows['fig17_fa_on']['exact']:.2f} deg")
    d = NP6 * 0.8 * RATED6 / J6
    bound = math.degrees(2 * math.exp(-2) * d / SIGMA6 ** 2)
    near(checks, rows["fig17_c_on"]["theory"], bound, 0.01, "theory of the PLL alone")


def mismatch6(checks, rows):
    for percent in (50, 150):
        near(checks, rows[f"fig18_Rs_{percent}"]["exact"], 0, 0.3, f"Rs at {percent} %: change")
    for percent in (50, 80, 120, 150):
        for load in (50, 100):
            row = rows[f"fig18_Lq_{percent}_load_{load}"]
            wanted = held6(load / 100 * RATED6, percent / 100)
            near(checks, row["theory"], wanted, 0.05, f"{row['id']}: theory off {wanted}")
            near(checks, row["exact"], wanted, 0.5, f"{row['id']}: exact off {wanted}")
    for name in ("eq42_Rs_50", "eq42_Rs_150", "eq43_Lq_80", "eq43_Lq_120"):
        row = rows[name]
        checks.true(abs(row["theory"]) > 1.5, f"{name}: {row['theory']} is worth a check")
        near(checks, row["exact"], row["theory"], 0.05, f"{name}: exact off the formula")


def harmonics6(checks, rows):
    for observer in ("c", "gi", "fa"):
        for order in (5, 7):
            for column in ("as_printed", "exact", "corrected"):
                near(checks, rows[f"fig15_{observer}_{order}"][column], 0, 0.5,
                     f"VSD, {observer}, {order}th, {column}")
    for figure, rpm in (("fig13", 300), ("fig14", 600)):
        w = NP6 * rpm * math.pi / 30
        for order in (-5, 7):
            row = rows[f"{figure}_fa_{abs(order)}"]
            wanted = 6 * abs(printed6("fa", order * w, w))
            near(checks, row["theory"], wanted, 0.01, f"{row['id']}: theory off {wanted}")
            near(checks, row["exact"], wanted, 0.1 * wanted, f"{row['id']}: exact off {wanted}")
    for rpm in LI_SPEEDS:
        near(checks, rows[f"xy_resonator_{rpm}"]["exact"], 0, 0.03 * RATED6_A, f"xy current at {rpm} rpm")
        plain = rows[f"xy_pi_{rpm}"]["exact"]
        checks.true(plain > 1.5, f"xy current with a plain PI at {rpm} rpm: {plain}")
        print(f"xy current with a plain PI at {rpm} rpm: {plain:.2f} A")
    for order, low, high in ((5, 105, 145), (7, 70, 80)):
        row = rows[f"k2_for_{order}"]
        checks.equal(row["verdict"], "", f"{row['id']} is no claim")
        for column in ("theory", "exact"):
            near(checks, row[column], (low + high) / 2, (high - low) / 2, f"{row['id']}: {column}")


def qpll6(checks, rows):
    """The column of the QPLL is the variant with it; a load step moves it as far as its closed form says."""
    for name, row in rows.items():
        choice = ("Euler", "ideal", "QPLL")
        variants = [v for v in row["variants"] if (v["form"], v["inverter"], v["PLL"]) == choice]
        if variants and isinstance(row["as_printed_qpll"], float):
            low, high = variants[0]["least"], variants[0]["largest"]
            checks.true(low - 1e-9 <= row["as_printed_qpll"] <= high + 1e-9,
                        f"{name}: QPLL {row['as_printed_qpll']}, the variant {low} .. {high}")
    both = [rows["fig17_c_rpm"][column] for column in ("as_printed", "as_printed_qpll")]
    checks.true(both[1] > 1.5 * both[0], f"speed error in a load step: LESO-QPLL {both[0]}, QPLL {both[1]} rpm")


def tables6(checks, rows):
    checks.equal(rows["table1_routh"]["as_printed"], 0, "eq. 24 against roots")
    limit = math.sqrt(2 * K26 / TS6 - K26 ** 2) / (2 * math.pi)
    near(checks, rows["table1_euler"]["as_printed"], limit, 0.5, f"Euler's limit off {limit}")
    for observer in ("c", "gi", "fa"):
        w = 100 * math.pi
        checks.at_most(abs(rows[f"table2_{observer}_gain"]["theory"] - abs(printed6(observer, w, w))),
                       1e-3, f"Table II, {observer}")


def paper_2(checks, folder):
    start = time.monotonic()
    arguments = ["reproduce", "li-fa-leso", *SEEDS, "--json", "l.json", "--csv", "l.csv"]
    done = folder.run(*arguments, "--plots", "li", timeout=5 * TIME_MAX_s)
    if done.returncode == 2 and "gnuplot" in done.stderr:
        done = folder.run(*arguments, timeout=5 * TIME_MAX_s)
    taken_s = time.monotonic() - start
    checks.equal(done.returncode, 0, f"exit code: {done.stderr}")
    checks.at_most(taken_s, LI_TIME_MAX_s, "wall clock of paper 2, s")
    print(f"{taken_s:.0f} s")
    rows = {row["id"]: row for row in folder.json("l.json")["rows"]}
    checks.equal(len(rows), len(folder.json("l.json")["rows"]), "ids are unique")
    checks.equal({row["figure"] for row in rows.values()}, set(LI_FIGURES), "figures of paper 2")
    for part in (tables6, steady6, dynamics6, mismatch6, harmonics6, qpll6, verdicts):
        part(checks, rows)
    files(checks, folder, rows, done.stdout, "l.csv",
          ["printed", "dead time", "exact raw", "corrected", "verdict", "STAND-IN"])
    pictures(checks, folder, "li", LI_PLOTS)
    bode(checks, folder.json("l.json"), done.stdout)
    if FULL:
        other_seeds(checks, folder, "li-fa-leso", rows)


# ---- Checks -------------------------------------------------------------------------------------

def stored_is_right(checks, expectations):
    """What is stored as closed form is the closed form."""
    known = closed_forms()
    used = set()
    for item in expectations:
        checks.true(item.get("source"), f"{item['id']} {item['column']}: has a source")
        value = known.get(item["id"], {}).get(item["column"], "none here")
        if value == "none here" or "expected" not in item:
            continue
        used.add((item["id"], item["column"]))
        what = f"stored {item['id']} {item['column']}: {item['expected']}, closed form {value}"
        if value is None or item["expected"] is None:
            checks.true(value is None and item["expected"] is None, what)
        else:
            checks.true(abs(value - item["expected"]) <= item["tolerance"], what)
    for name, columns in known.items():
        for column in columns:
            checks.true((name, column) in used, f"{name} {column}: closed form is an expectation")


def expectation(checks, rows, item):
    row = rows.get(item["id"])
    if not checks.true(row is not None, f"{item['id']} is there"):
        return
    value = row[item["column"]]
    what = f"{item['id']} {item['column']}: {value} ({item['source']})"
    if "at_most" in item:
        checks.true(isinstance(value, (int, float)) and abs(value) <= item["at_most"],
                    f"{what}, expected at most {item['at_most']}")
    elif item["expected"] == "lost":
        checks.true(value in GONE, f"{what}, expected no estimate")
    elif item["expected"] is None:
        checks.true(value is None, f"{what}, expected no solution")
    else:
        checks.true(isinstance(value, (int, float)) and
                    abs(value - item["expected"]) <= item["tolerance"],
                    f"{what}, expected {item['expected']} +- {item['tolerance']}")


def holds(row, value):
    """A claim and one value, by the words of the introduction."""
    if value is None:
        return False
    size = abs(row["claimed"])
    return {
        "about": lambda: abs(value - row["claimed"]) <= max(1.5, 0.3 * size),
        "size": lambda: abs(abs(value) - size) <= max(1.5, 0.3 * size),
        "at most": lambda: abs(value) <= size + row["reading"],
        "at least": lambda: value >= row["claimed"] - row["reading"],
        "exactly": lambda: abs(value - row["claimed"]) <= max(0.01, 0.02 * size),
        "formula": lambda: abs(value - row["claimed"]) <= max(0.01, 0.02 * size),
    }[row["claim"]]()


def judged(row):
    """Verdict of a row, from its variants."""
    if row["claim"] == "none":
        return ""
    if row["claim"] == "formula":
        return "identity"
    held = sum(variant["holds"] for variant in row["variants"])
    if not row["variants"]:
        return "not comparable"
    return {0: "contradicted", sum(variant["of"] for variant in row["variants"]): "reproduced"}.get(held, "depends")


def fewest_axes(row):
    """The least number of axes that tell where a claim holds, and whether some seeds only decide."""
    variants = row["variants"]
    state = [0 if v["holds"] == 0 else 1 if v["holds"] == v["of"] else 2 for v in variants]
    axes = [key for key in variants[0] if isinstance(variants[0][key], str)]

    def tell(subset):
        groups = {}
        for variant, now in zip(variants, state):
            groups.setdefault(tuple(variant[key] for key in subset), set()).add(now)
        return all(len(group) == 1 for group in groups.values())

    least = next(n for n in range(len(axes) + 1) if any(map(tell, itertools.combinations(axes, n))))
    return least, 2 in state


def verdicts(checks, rows):
    """The verdict follows from the variants, these from their values, and what does not hold says why."""
    for name, row in rows.items():
        checks.equal(row["verdict"], judged(row), f"{name}: verdict")
        checks.equal(bool(row["why"]), row["verdict"] in ("contradicted", "depends", "not comparable") or
                     (row["verdict"] == "identity" and not holds(row, row["theory"])), f"{name}: says why")
        if row["verdict"] == "depends":
            named = row["why"].removeprefix("on ").split(".")[0].split(" and ")
            least, noise = fewest_axes(row)
            checks.equal((len(named) - noise, "noise" in named), (least, noise), f"{name}: axes in '{row['why'][:60]}'")
        if row["verdict"] == "not comparable":
            checks.true("missing: " in row["why"], f"{name}: {row['why']}")
        for variant in row["variants"]:
            ends = {holds(row, variant[end]) for end in ("least", "largest")}
            if row["claim"] in ("at most", "at least") and variant["lost"] == 0:
                checks.true((variant["holds"] == variant["of"]) == (ends == {True}) or
                            variant["least"] < 0 < variant["largest"], f"{name}: {variant}")
            checks.true(variant["holds"] <= variant["of"] - variant["lost"], f"{name}: {variant}")
        if row["claim"] in ("at most", "at least"):
            checks.true(0 <= row["reading"] <= 0.5, f"{name}: accuracy of reading {row['reading']}")


def no_row_swaps(checks, runs, what):
    """Reproduced with some seeds, contradicted with others: then it was neither."""
    for name in runs[0]:
        seen = {rows[name]["verdict"] for rows in runs}
        checks.true(not {"reproduced", "contradicted"} <= seen, f"{what}: {name} is {' and '.join(sorted(seen))}")


def other_seeds(checks, folder, paper, rows):
    """Two more sets of seeds, that have none in common with the first."""
    runs = [rows]
    for seeds in ("6-10", "11-15") if FULL else ("2-2", "3-3"):
        done = folder.run("reproduce", paper, "--seeds", seeds, "--json", "s.json", timeout=5 * TIME_MAX_s)
        checks.equal(done.returncode, 0, f"exit code, {paper} --seeds {seeds}: {done.stderr}")
        runs.append({row["id"]: row for row in folder.json("s.json")["rows"]})
    no_row_swaps(checks, runs, paper)
    # It does find a row that swaps.
    swapped = {name: {**row, "verdict": {"reproduced": "contradicted"}.get(row["verdict"], row["verdict"])}
               for name, row in rows.items()}
    found = Checks()
    with contextlib.redirect_stdout(io.StringIO()):
        no_row_swaps(found, [rows, swapped], paper)
    checks.equal(found.failed, sum(row["verdict"] == "reproduced" for row in rows.values()), "swaps that are found")




def bode(checks, run, text):
    """The figures that `analyse` draws are named, with the files that it writes."""
    source = (SOURCE / "sim/report/plot_bode.c").read_text()
    checks.true(run["bode"], "names Bode diagrams")
    for figure, name in run["bode"].items():
        checks.true(f'"{name}"' in source and f"{figure} {name}" in text, f"{figure}: {name}")


def variant_of(row, form, inverter):
    return next(v for v in row["variants"] if (v["form"], v["inverter"]) == (form, inverter))


def what_forms_and_inverters_decide(checks, rows):
    """Against closed forms: where a claim hangs on the discretisation or on the inverter alone."""
    for rpm in (600, 900, 1200, 1500):  # in continuous time eq. 30 is the lag
        row = rows[f"fig14_enhanced_{rpm}_dc"]
        for form, wanted in (("Euler", eq30(rpm) - euler_lag(rpm)), ("continuous", 0), ("exact", 0)):
            seen = variant_of(row, form, "ideal")
            near(checks, seen["largest"], wanted, 0.1, f"{row['id']}: {form}, ideal inverter")
    # At 300 rpm the loop through the current swings, which shifts the mean.
    late = math.degrees(RS * 5 / (1.5 * NP * PSI) * TS / (2 * PSI))
    for form, wanted in (("Euler", late - euler_lag(1500)), ("continuous", -eq30(1500))):
        seen = variant_of(rows["fig13_qpll_1500_dc"], form, "ideal")
        near(checks, seen["largest"], wanted, 0.3, f"Fig. 13 at 1500 rpm: {form}, ideal inverter")
    checks.equal(rows["fig19_enhanced_1500_Lq_sides"]["verdict"], "contradicted", "Lq x0.5 and x1.25 differ in sign")
    checks.equal(rows["fig16_qpll_300_step"]["verdict"], "contradicted", "Fig. 16, QPLL")
    for figure, rpm in (("fig16", 300), ("fig17", 1500)):
        for pll in ("qpll", "enhanced"):
            checks.equal(rows[f"{figure}_{pll}_{rpm}_estimate"]["verdict"], "contradicted",
                         f"{figure}, {pll}: speed error")
    # Below 2.04 sigma the notch for k = 0.5 takes the loop's phase (docs/theory/pll.md, P13).
    near(checks, rows["fig7_lowest"]["as_printed"], 2.04 * SIGMA / 6 / NP * 30 / math.pi, 3, "Fig. 7: stable from, rpm")


def files(checks, folder, rows, text, name, words):
    with open(folder.path / name, newline="") as file:
        lines = list(csv.DictReader(file))
    checks.equal([line["id"] for line in lines], list(rows), "CSV has the rows of the JSON")
    for line in lines:
        value = rows[line["id"]]["exact"]
        same = line["exact"] == (value or "") if not isinstance(value, (int, float)) else \
            abs(float(line["exact"]) - value) <= 1e-5 * max(1, abs(value))
        checks.true(same, f"{line['id']}: CSV {line['exact']}, JSON {value}")
    for word in words:
        checks.true(word in text, f"'{word}' in the table")
    checks.at_most(max(len(line) for line in text.splitlines()), 140, "longest line of the table")


def docs(checks, folder):
    """docs/papers.md says what the two runs gave; tests/tools/papers_page.py writes it."""
    studies = [folder.json(name) for name in ("r.json", "l.json")]
    for text in papers_page.problems(SOURCE, *studies):
        checks.true(False, text)
    # It does find a figure that is not today's, wherever it stands, and a verdict that is the opposite.
    rows = {row["id"]: row for row in studies[1]["rows"]}
    rows["fig13_fa_5"]["exact"] -= 1.0
    rows["fig15_c_5"]["verdict"] = "contradicted"
    found = list(papers_page.problems(SOURCE, *studies))
    checks.equal(len(found), 2, f"a figure off by 1 and an opposite verdict that are found: {found}")


def pictures(checks, folder, name, figures):
    for figure in figures:
        path = folder.path / name / f"{figure}.svg"
        if path.exists():
            svg = path.read_text()
            checks.true("</svg>" in svg and len(svg) > 20000, f"{figure}.svg is whole")
            checks.equal(">order<" in svg, (name, figure) in SPECTRA, f"{figure}.svg: a panel of spectra")


def main():
    checks = Checks()
    expectations = json.loads(GOLDEN.read_text())["expectations"]
    stored_is_right(checks, expectations)
    with Folder() as folder:
        start = time.monotonic()
        arguments = ["reproduce", "jiang2022", *SEEDS, "--json", "r.json", "--csv", "r.csv"]
        done = folder.run(*arguments, "--plots", "plots", timeout=5 * TIME_MAX_s)
        if done.returncode == 2 and "gnuplot" in done.stderr:
            done = folder.run(*arguments, timeout=5 * TIME_MAX_s)
        taken_s = time.monotonic() - start
        checks.equal(done.returncode, 0, f"exit code: {done.stderr}")
        checks.equal(done.stderr, "", "no message, no progress where there is no terminal")
        checks.at_most(taken_s, TIME_MAX_s, "wall clock, s")
        print(f"{taken_s:.0f} s")
        rows = {row["id"]: row for row in folder.json("r.json")["rows"]}
        checks.equal(len(rows), len(folder.json("r.json")["rows"]), "ids are unique")
        checks.equal({row["figure"] for row in rows.values()}, {*FIGURES, *TABLES}, "figures")
        for item in expectations:
            expectation(checks, rows, item)
        verdicts(checks, rows)
        files(checks, folder, rows, done.stdout, "r.csv",
              ["printed", "p. corr.", "exact", "corrected", "own gains", "verdict", "2.99 Nm",
               "seeded at the true angle"])
        pictures(checks, folder, "plots", FIGURES)
        bode(checks, folder.json("r.json"), done.stdout)
        what_forms_and_inverters_decide(checks, rows)
        other_seeds(checks, folder, "jiang2022", rows)
        replays(checks, folder)
        closed_loop(checks, folder)
        mismatch_under_way(checks, folder)
        paper_2(checks, folder)
        docs(checks, folder)
        refused(checks, folder, ["reproduce"], "reproduce: expected the name of a paper: jiang2022 or li-fa-leso")
        refused(checks, folder, ["reproduce", "li"], "reproduce li: unknown; expected jiang2022 or li-fa-leso")
        refused(checks, folder, ["reproduce", "jiang2022", "--seeds", "1-21"], "reproduce --seeds: expected at most 20")
        refused(checks, folder, ["reproduce", "jiang2022", "more"], "more: expected no argument here")
    checks.done()


main()
