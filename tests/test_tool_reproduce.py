"""`lodestar reproduce jiang2022`: every value against golden/reproduce_jiang2022.json.

Each expectation there names its independent source, or is called ours. Those in closed form are
computed here again, so that what is stored is no copy of what the tool says.
"""
import cmath
import csv
import json
import math
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent / "support"))
from tool import DRIVE, MOTOR, RECORDINGS, SOURCE, Checks, Folder, refused

GOLDEN = SOURCE / "tests/golden/reproduce_jiang2022.json"
TIME_MAX_s = 180
FIGURES = ["fig12", "fig13", "fig14", "fig15", "fig16", "fig17", "fig18", "fig19"]
TABLES = ["table1", "table2", "acceleration", "eq14"]
GONE = ["lost", "stalls"]

# Paper 1, Table 3 and Section 5; drops of sim/plants/jiang2022.ini.
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

    # Below the notch: where the library's loop crosses with these numbers.
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
        for k, value in enumerate(sampled_loop(sigma)):
            values[f"table2_{sigma}_{k + 1}"] = {"exact": value}
    for rpm in (300, 600, 900, 1200, 1500):
        values[f"fig14_qpll_{rpm}_dc"] = {"theory": -euler_lag(rpm)}
        values[f"fig14_enhanced_{rpm}_dc"] = {"theory": eq30(rpm) - euler_lag(rpm)}
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
    """From standstill: the library's estimate makes the start, then the papers' form takes over."""
    text = f"""[scenario]
motor = {MOTOR}
drive = {DRIVE}
[estimator]
emf = c-leso-euler
w0_rad_s = {W0}
sigma_rad_s = 100
{IDEAL}[phase.start]
duration_s = 2
speed_rpm = 300
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


def verdicts(checks, rows):
    """The verdict follows from the numbers, and a claim that does not hold says why."""
    for name, row in rows.items():
        if row["claim"] == "none":
            checks.true(row["verdict"] in ("", "improved"), f"{name}: {row['verdict']}")
            continue
        size = abs(row["claimed"])
        value = row["theory"] if row["claim"] == "formula" else row["as_printed"]
        good = isinstance(value, (int, float)) and {
            "about": lambda: abs(value - row["claimed"]) <= max(1.5, 0.3 * size),
            "size": lambda: abs(abs(value) - size) <= max(1.5, 0.3 * size),
            "at most": lambda: abs(value) <= size,
            "exactly": lambda: abs(value - row["claimed"]) <= max(0.01, 0.02 * size),
            "formula": lambda: abs(value - row["claimed"]) <= max(0.01, 0.02 * size),
        }[row["claim"]]()
        checks.equal(row["verdict"].split(",")[0], "reproduced" if good else "contradicted",
                     f"{name}: verdict")
        checks.equal(bool(row["why"]), not good, f"{name}: says why if and only if contradicted")


def files(checks, folder, rows, text):
    with open(folder.path / "r.csv", newline="") as file:
        lines = list(csv.DictReader(file))
    checks.equal([line["id"] for line in lines], list(rows), "CSV has the rows of the JSON")
    for line in lines:
        value = rows[line["id"]]["exact"]
        same = line["exact"] == (value or "") if not isinstance(value, (int, float)) else \
            abs(float(line["exact"]) - value) <= 1e-5 * max(1, abs(value))
        checks.true(same, f"{line['id']}: CSV {line['exact']}, JSON {value}")
    for word in ["as printed", "exact", "corrected", "own gains", "verdict", "2.99 Nm",
                 "seeded at the true angle"]:
        checks.true(word in text, f"'{word}' in the table")
    checks.at_most(max(len(line) for line in text.splitlines()), 140, "longest line of the table")
    for name in FIGURES:
        path = folder.path / "plots" / f"{name}.svg"
        if path.exists():
            svg = path.read_text()
            checks.true("</svg>" in svg and len(svg) > 20000, f"{name}.svg is whole")


def main():
    checks = Checks()
    expectations = json.loads(GOLDEN.read_text())["expectations"]
    stored_is_right(checks, expectations)
    with Folder() as folder:
        start = time.monotonic()
        arguments = ["reproduce", "jiang2022", "--json", "r.json", "--csv", "r.csv"]
        done = folder.run(*arguments, "--plots", "plots")
        if done.returncode == 2 and "gnuplot" in done.stderr:
            done = folder.run(*arguments)
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
        files(checks, folder, rows, done.stdout)
        replays(checks, folder)
        closed_loop(checks, folder)
        mismatch_under_way(checks, folder)
        refused(checks, folder, ["reproduce"], "reproduce: expected the name of a paper: jiang2022")
        refused(checks, folder, ["reproduce", "li"], "reproduce li: unknown; expected jiang2022")
        refused(checks, folder, ["reproduce", "jiang2022", "more"], "more: expected nothing there")
    checks.done()


main()
