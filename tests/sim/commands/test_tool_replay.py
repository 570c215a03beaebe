"""`lodestar replay`: the firmware's estimator over recordings of an independent simulator."""
import csv
import math
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, RECORDINGS, Checks, Folder, refused

BAR_DC_deg = 0.05
WINDOW_s = 0.1
HEADER = ["t_s", "theta_e_rad", "omega_e_rad_s", "e_alpha_V", "e_beta_V", "lock"]
COLUMNS = ["t_s", "u_alpha_V", "u_beta_V", "i_alpha_A", "i_beta_A", "theta_e_rad", "omega_e_rad_s"]
MOTOR_ONLY = """[motor]
pole_pairs = 3
Rs_Ohm = 0.75
Ld_H = 3.5e-3
Lq_H = 9.8e-3
psi_Wb = 0.142
J_kgm2 = 0.0174
B_Nms = 7.5e-4
"""


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    return rows[0], rows[1:]


def error_deg(estimate, truth):
    return math.degrees(math.remainder(estimate - truth, 2 * math.pi))


def write(folder, name, header, rows):
    text = "\n".join(",".join(row) for row in [header, *rows]) + "\n"
    return folder.write(name, text)


def every_recording(checks, folder):
    recordings = sorted(RECORDINGS.glob("*.csv"))
    checks.true(len(recordings) >= 5, f"{len(recordings)} recordings in {RECORDINGS}")
    for path in recordings:
        for motor in ["m.ini", MOTOR]:
            for pll in ["leso-qpll", "qpll"]:
                one_recording(checks, folder, path, motor, pll)


def one_recording(checks, folder, path, motor, pll):
    what = f"{path.name} {pll} {pathlib.Path(motor).name}"
    done = folder.run("replay", "--motor", motor, "--recording", path, "--emf", "c-leso", "--pll",
                      pll, "--out", "o.csv", "--json", "o.json")
    if not checks.equal(done.returncode, 0, f"exit code, {what}: {done.stderr}"):
        return
    _, recorded = read(path)
    header, rows = read(folder.path / "o.csv")
    checks.equal(header, HEADER, f"header, {what}")
    checks.equal(len(rows), len(recorded), f"rows, {what}")
    checks.true(all(float(a[0]) == float(b[0]) for a, b in zip(rows, recorded)), f"times, {what}")
    checks.true(all(math.isfinite(float(x)) for row in rows for x in row), f"finite, {what}")
    checks.true(all(0 <= float(row[5]) <= 1 for row in rows), f"lock in 0 .. 1, {what}")
    # The same figures from the files alone.
    period = float(recorded[1][0]) - float(recorded[0][0])
    last = round(WINDOW_s / period)
    errors = [error_deg(float(a[1]), float(b[5])) for a, b in zip(rows[-last:], recorded[-last:])]
    mean = sum(errors) / len(errors)
    results = folder.json("o.json")
    checks.at_most(abs(mean), BAR_DC_deg, f"mean angle error, {what}")
    checks.at_most(abs(results["angle_error_mean_deg"] - mean), 1e-4, f"mean in JSON, {what}")
    checks.at_most(abs(results["angle_error_pp_deg"] - (max(errors) - min(errors))), 1e-4,
                   f"pp in JSON, {what}")
    speed = [abs(float(a[2]) - float(b[6])) for a, b in zip(rows[-last:], recorded[-last:])]
    checks.at_most(max(speed), 0.1, f"speed error, rad/s, {what}")
    checks.true(results["below_1_deg_after_s"] is not None, f"settles, {what}")
    for word in ["f_pwm_Hz", "v_bus_V", "w0_rad_s", "sigma_rad_s", "psi_Wb"]:
        checks.true(word in done.stdout, f"{word} among the values used, {what}")


def voltage_of_the_row_before(checks, folder):
    """A wrong row would cost 5 degrees at 1500 rpm; shifted by hand it does."""
    path = RECORDINGS / "steady-1500rpm-5Nm.csv"
    header, rows = read(path)
    for shift in (-1, 1):
        moved = [row[:1] + rows[min(max(k + shift, 0), len(rows) - 1)][1:3] + row[3:]
                 for k, row in enumerate(rows)]
        write(folder, "shifted.csv", header, moved)
        folder.run("replay", "--motor", "m.ini", "--recording", "shifted.csv", "--json", "o.json")
        error = abs(folder.json("o.json")["angle_error_mean_deg"])
        checks.true(3 < error < 8, f"voltage moved by {shift} row: {error} deg, expected 3 .. 8")


def layouts(checks, folder):
    """Other orders of columns, others besides, other line ends: the same result to the bit."""
    path = RECORDINGS / "steady-300rpm-5Nm.csv"
    header, rows = read(path)
    folder.run("replay", "--motor", "m.ini", "--recording", path, "--out", "reference.csv")
    reference = (folder.path / "reference.csv").read_bytes()
    order = list(range(len(header)))
    random.Random(7).shuffle(order)
    variants = {
        "shuffled": ([header[k] for k in order], [[row[k] for k in order] for row in rows]),
        "with others": (header + ["note"], [row + ["text"] for row in rows]),
        "without truth": (header[:5], [row[:5] for row in rows]),
        "blanks": ([f" {name} " for name in header], [[f" {x}" for x in row] for row in rows]),
    }
    for name, (some_header, some_rows) in variants.items():
        write(folder, "v.csv", some_header, some_rows)
        done = folder.run("replay", "--motor", "m.ini", "--recording", "v.csv", "--out", "v.out")
        checks.equal(done.returncode, 0, f"{name}: exit code, {done.stderr}")
        checks.true((folder.path / "v.out").read_bytes() == reference, f"{name}: same estimates")
    checks.true("no angle to compare with" in
                folder.run("replay", "--motor", "m.ini", "--recording",
                           write(folder, "v.csv", *variants["without truth"])).stdout,
                "says that there is no true angle")
    text = path.read_text()
    for name, data in {"CRLF": text.replace("\n", "\r\n").encode(),
                       "byte order mark": b"\xef\xbb\xbf" + text.encode(),
                       "blank line at the end": (text + "\n\n").encode(),
                       "no line end at the end": text.rstrip("\n").encode()}.items():
        folder.write("v.csv", data)
        done = folder.run("replay", "--motor", "m.ini", "--recording", "v.csv", "--out", "v.out")
        checks.equal(done.returncode, 0, f"{name}: exit code, {done.stderr}")
        checks.true((folder.path / "v.out").read_bytes() == reference, f"{name}: same estimates")


def reverse(checks, folder):
    """Mirrored at the alpha axis a recording turns the other way."""
    header, rows = read(RECORDINGS / "ramp-300-1500-300rpm-1Nm.csv")
    sign = [1, 1, -1, 1, -1, -1, -1]
    write(folder, "r.csv", header,
          [[str(s * float(x)) for s, x in zip(sign, row)] for row in rows])
    for pll in ["leso-qpll", "qpll"]:
        done = folder.run("replay", "--motor", "m.ini", "--recording", "r.csv", "--pll", pll,
                          "--json", "o.json")
        checks.equal(done.returncode, 0, f"reverse {pll}: exit code")
        checks.at_most(abs(folder.json("o.json")["angle_error_mean_deg"]), BAR_DC_deg,
                       f"reverse {pll}: mean angle error")


def from_the_middle(checks, folder):
    """Cut out of the run: at speed and with current from the first row on, no start value."""
    for name in ["steady-300rpm-5Nm", "steady-1500rpm-5Nm", "load-step-300rpm"]:
        header, rows = read(RECORDINGS / f"{name}.csv")
        for start in (777, 1201, 1500):
            write(folder, "cut.csv", header, rows[start:])
            folder.run("replay", "--motor", "m.ini", "--recording", "cut.csv", "--json", "o.json")
            what = f"{name} from row {start}"
            results = folder.json("o.json")
            checks.at_most(abs(results["angle_error_mean_deg"]), BAR_DC_deg, f"{what}: mean")
            checks.true(results["below_1_deg_after_s"] is not None, f"{what}: settles")


def options(checks, folder):
    path = RECORDINGS / "steady-300rpm-5Nm.csv"
    base = ["replay", "--motor", "m.ini", "--recording", path, "--json", "o.json"]
    done = folder.run(*base, "--set", "estimator.w0_rad_s=1234", "--set", "drive.v_bus_V=200")
    checks.true("w0_rad_s = 1234  (command line)" in done.stdout, "shows what --set has set")
    checks.equal(folder.json("o.json")["config"]["estimator"]["w0_rad_s"], 1234, "w0 in JSON")
    folder.run(*base, "--set", "estimator.compensation=none")
    uncorrected = folder.json("o.json")["angle_error_mean_deg"]
    checks.true(-8 < uncorrected < -3, f"without compensation {uncorrected} deg, expected about -5")
    refused(checks, folder, [*base, "--set", "motor.Lq_H=-1"], r"\[motor\] Lq_H = -1: LODE_ERROR_MOTOR_LQ")


def bad_recordings(checks, folder):
    header, rows = read(RECORDINGS / "steady-300rpm-5Nm.csv")
    rows = rows[:400]
    arguments = ["replay", "--motor", "m.ini", "--recording", "b.csv", "--out", "never.csv"]

    def changed(row, column, value):
        copy = [list(r) for r in rows]
        copy[row][column] = value
        return copy

    for text in ["nan", "inf", "-inf", "1e999", "", "abc", "1.0x"]:
        for column in range(len(COLUMNS)):
            write(folder, "b.csv", header, changed(100, column, text))
            refused(checks, folder, arguments, rf"b.csv:102: {COLUMNS[column]}: '{text}'; "
                                               "expected a finite number")
    step = float(rows[1][0]) - float(rows[0][0])
    for late in (1.02, 0.98, 2, 0, -1):
        copy = [list(r) for r in rows]
        for k in range(200, len(copy)):
            copy[k][0] = repr(float(copy[k][0]) + (late - 1) * step)
        write(folder, "b.csv", header, copy)
        refused(checks, folder, arguments,
                r"b.csv:202: t_s: a step of .*" + ("within 1 %" if late > 0 else "rising times"))
    write(folder, "b.csv", header, changed(100, 0, repr(float(rows[100][0]) + 0.005 * step)))
    checks.equal(folder.run(*arguments[:-2]).returncode, 0, "0.5 % of jitter: exit code")
    for k, name in enumerate(COLUMNS[:5]):
        write(folder, "b.csv", header[:k] + header[k + 1:], [r[:k] + r[k + 1:] for r in rows])
        refused(checks, folder, arguments, f"b.csv:1: no column {name}; expected a header")
    write(folder, "b.csv", header, rows[:50] + [rows[50][:4]] + rows[51:])
    refused(checks, folder, arguments, "b.csv:52: 4 values; expected 7")
    write(folder, "b.csv", header, rows[:50] + [rows[50] + ["1"]] + rows[51:])
    refused(checks, folder, arguments, "b.csv:52: 8 values; expected 7")
    write(folder, "b.csv", header + ["t_s"], [r + ["1"] for r in rows])
    refused(checks, folder, arguments, "b.csv:1: column t_s: expected each column once")
    write(folder, "b.csv", header, rows[:2])
    refused(checks, folder, arguments, "b.csv: 2 rows; expected at least 3")
    folder.write("b.csv", "")
    refused(checks, folder, arguments, "b.csv: empty; expected a CSV file")
    write(folder, "b.csv", header, [[str(0.01 * k), *r[1:]] for k, r in enumerate(rows)])
    refused(checks, folder, arguments, "b.csv: t_s: steps of 0.01 s; expected .*scenario.log_s")
    refused(checks, folder, arguments[:4] + ["nowhere.csv"], "nowhere.csv: No such file")
    folder.write("b.csv", "")
    (folder.path / "b.csv").unlink()
    write(folder, "b.csv", header, rows)
    folder.write("m.ini", MOTOR_ONLY.replace("psi_Wb = 0.142\n", ""))
    refused(checks, folder, arguments, r"m.ini: \[motor\] psi_Wb: missing; expected it in a file")


def own_records(checks, folder):
    """What a drive records of itself goes in as it is: the run's CSV, and ring and scope decoded."""
    folder.write("s.ini", f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\nlog_s = 2e-4\n"
                          "[phase.start]\nduration_s = 2.4\nspeed_rpm = 450\nload_Nm = 1\n")
    folder.run("run", "s.ini", "--csv", "run.csv", "--ring", "r.bin", "--scope", "s.bin",
               "--channels", "mode,i_beta_A,u_beta_V,i_alpha_A,u_alpha_V,theta_rad",
               "--trigger", "omega_rad_s>120")
    folder.run("decode", "r.bin", "--csv", "ring.csv")
    folder.run("decode", "s.bin", "--csv", "scope.csv")
    base = ["replay", "--motor", MOTOR, "--drive", DRIVE, "--out", "o.csv", "--recording"]
    estimates, done_of = {}, {}
    for name in ["run.csv", "ring.csv", "scope.csv"]:
        done = folder.run(*base, name, "--json", "o.json")
        done_of[name] = done
        if checks.equal(done.returncode, 0, f"exit code, {name}: {done.stderr}"):
            estimates[name] = read(folder.path / "o.csv")[1]
        if name == "run.csv":
            checks.at_most(abs(folder.json("o.json")["angle_error_mean_deg"]), 1.0,
                           "the drive's own record: mean angle error")
    checks.equal(estimates["ring.csv"], estimates["run.csv"], "ring and run: the same estimates")
    header, rows = read(folder.path / "run.csv")
    theta, mode = header.index("theta_est_rad"), header.index("mode")
    # Zeros in all four are the gates off: no estimate, as in the drive, whose estimator is reset then.
    off = [k for k, row in enumerate(rows) if row[mode] in ("0", "1")]
    checks.true(len(off) > 400 and "gates off: " in done_of["run.csv"].stdout, "gates off")
    checks.true(all(estimates["run.csv"][k][1:] == ["0"] * 5 for k in off), "no estimate with them off")
    late = [k for k, row in enumerate(rows) if row[mode] == "5"][1000:]
    off = [abs(error_deg(float(estimates["run.csv"][k][1]), float(rows[k][theta]))) for k in late]
    # Not to the bit: the slow jobs fall into other periods than in the drive.
    checks.at_most(max(off), 0.01, f"the drive's own angle again, degrees, {len(late)} rows of RUN")
    checks.true(len(late) > 2500, f"{len(late)} rows of RUN")


def own_record_of_a_fault(checks, folder):
    """After a trip a drive's record keeps the current that tripped: the gates are off all the same."""
    folder.write("f.ini", f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\nlog_s = 2e-4\n"
                          "[phase.start]\nduration_s = 1.9\nspeed_rpm = 450\nload_Nm = 1\n"
                          "[phase.trip]\nduration_s = 0.1\ntrip = on\nend_mode = fault\n")
    done = folder.run("run", "f.ini", "--csv", "fault.csv")
    checks.equal(done.returncode, 0, f"exit code of the run: {done.stderr}")
    done = folder.run("replay", "--motor", MOTOR, "--drive", DRIVE, "--out", "o.csv", "--recording",
                      "fault.csv")
    checks.equal(done.returncode, 0, f"exit code of replay: {done.stderr}")
    header, rows = read(folder.path / "fault.csv")
    mode, current = header.index("mode"), header.index("i_alpha_A")
    tripped = [k for k, row in enumerate(rows) if row[mode] == "6"]
    checks.true(len(tripped) > 400 and float(rows[tripped[-1]][current]) != 0.0,
                f"{len(tripped)} rows of FAULT, and their current is kept")
    estimates = read(folder.path / "o.csv")[1]
    checks.true(all(estimates[k][1:] == ["0"] * 5 for k in tripped[1:]), "no estimate after the trip")


# ---- Other people's tables ------------------------------------------------------------------------

def tables(checks, folder):
    """The same recording as other tools write it: the same estimates."""
    path = RECORDINGS / "steady-300rpm-5Nm.csv"
    header, rows = read(path)
    base = ["replay", "--motor", "m.ini", "--drive", "f.ini", "--recording"]
    folder.write("f.ini", "[drive]\nf_pwm_Hz = 5000\nv_bus_V = 200\ni_max_A = 12\n")
    folder.run(*base, path, "--out", "reference.csv")
    reference = read(folder.path / "reference.csv")[1]

    def scaled(factors):
        return [[repr(float(x) * f) for x, f in zip(row, factors)] for row in rows]

    def table(names, lines, separator=",", head=""):
        text = head + "\n".join(separator.join(line) for line in ([names] if names else []) + lines)
        folder.write("v.csv", text + "\n")

    def same(what, *options, bar_deg=0.0, columns=(0, 1, 2, 3, 4, 5)):
        done = folder.run(*base, "v.csv", "--out", "v.out", "--json", "v.json", *options)
        if not checks.equal(done.returncode, 0, f"{what}: exit code, {done.stderr}"):
            return
        got = read(folder.path / "v.out")[1]
        checks.equal(len(got), len(reference), f"{what}: rows")
        if bar_deg == 0.0:
            checks.true([[r[c] for c in columns] for r in got] ==
                        [[r[c] for c in columns] for r in reference], f"{what}: same estimates")
        else:
            off = max(abs(error_deg(float(a[1]), float(b[1])))
                      for a, b in zip(got[1000:], reference[1000:]))
            checks.at_most(off, bar_deg, f"{what}: angle beside the reference's, degrees")

    comma = [[x.replace(".", ",") for x in row] for row in rows]
    table(header, comma, ";")
    same("semicolon and decimal comma")
    table(header, comma, "\t")
    same("tab and decimal comma")
    table(header, rows, ";")
    same("semicolon and decimal point")
    table(header, rows, "  ")
    same("blanks", "--separator", "blank")
    table([f'"{x}"' for x in header], [[f'"{x}"' for x in row] for row in rows])
    same("quotes")
    table(header, rows, head="# logger 1.2\n\n% of today, with a comma\n")
    same("comments above the header")
    table(header, rows[:50] + [["# a note, with a comma"]] + rows[50:])
    same("a comment on the way")
    table(header, [["s", "V", "V", "A", "A", "rad", "rad/s"]] + rows,
          head="Logger 1.2\nmade, today, by, me\n")
    same("a title, and units below the header", "--header", 3, "--data", 5)
    table(None, rows)
    same("no header", "--header", "none", *(x for k, name in enumerate(
        ["t", "u_alpha", "u_beta", "i_alpha", "i_beta", "theta_e", "omega_e"])
        for x in ("--column", f"{name}=#{k + 1}")))
    table(["Time", "U alpha", "U:beta", "I, alpha", "Ibeta", "", "w"],
          [[f'"{x}"' for x in row] for row in rows])
    folder.write("v.csv", (folder.path / "v.csv").read_text().replace("I, alpha", '"I, alpha"', 1))
    maps = ["t=Time", "u_alpha=U alpha", "u_beta=U:beta:V", "i_alpha=I, alpha", "i_beta=Ibeta",
            "omega_e=w:rad_s"]
    same("names of their own", *(x for m in maps for x in ("--column", m)))
    # Units: by name, by mapping, by factor.
    factors = [1e6, 1e3, 1e-3, 1e3, -2.0, 180 / math.pi, 30 / math.pi]
    table(["t_us", "u_alpha_mV", "u_beta_kV", "i_alpha_mA", "Ib", "theta_e_deg", "omega_e_rpm"],
          scaled(factors))
    same("units", "--column", "i_beta=Ib:-0.5", bar_deg=1e-3)
    result = folder.json("v.json")
    checks.at_most(abs(result["angle_error_mean_deg"]), BAR_DC_deg, "true angle in degrees")
    checks.at_most(abs(result["speed_error_mean_rad_s"]), 0.1, "true speed in rpm, electrical")
    table(["t_s", "u_alpha_V", "u_beta_V", "i_alpha_A", "i_beta_A", "speed_rpm"],
          [row[:5] + [row[6]] for row in scaled([1, 1, 1, 1, 1, 1, 10 / math.pi])])
    same("mechanical speed")
    checks.at_most(abs(folder.json("v.json")["speed_error_mean_rad_s"]), 0.1, "mechanical speed")
    sheet = MOTOR.read_text().replace("pole_pairs = 3", "poles = 6")
    folder.write("sheet.ini", sheet)
    done = folder.run("replay", "--motor", "sheet.ini", "--recording", "v.csv", "--json", "sheet.json")
    checks.equal(("poles = 6" in sheet, done.returncode), (True, 0), f"a count of poles: {done.stderr}")
    checks.at_most(abs(folder.json("sheet.json")["speed_error_mean_rad_s"]), 0.1, "mechanical speed, and a count of poles")
    # Phases: with any voltage common to all three, and with two currents.
    def phases(alpha, beta, common=0.0):
        a, b = float(alpha), float(beta)
        return [repr(x + common) for x in (a, -a / 2 + math.sqrt(3) / 2 * b,
                                           -a / 2 - math.sqrt(3) / 2 * b)]
    names = ["t_s", "u_a_V", "u_b_V", "u_c_V", "i_a_A", "i_b_A"]
    lines = [[r[0], *phases(r[1], r[2], 57.3), *phases(r[3], r[4])[:2]] for r in rows]
    table(names, lines)
    same("phases, two currents", bar_deg=1e-3)
    table([*names, "i_c_A"], [[*x, phases(*r[3:5])[2]] for x, r in zip(lines, rows)])
    same("phases, three currents", bar_deg=1e-3)
    table([*names, "u_alpha_V", "u_beta_V"], [[r[0], "1", "2", "3", *x[4:], *r[1:3]]
                                              for x, r in zip(lines, rows)])
    same("stator axes win over phases", bar_deg=1e-3)


def times(checks, folder):
    """Gaps, uneven and faster rows."""
    header, rows = read(RECORDINGS / "load-step-300rpm.csv")
    base = ["replay", "--motor", "m.ini", "--recording", "v.csv", "--out", "v.out", "--json", "v.json"]
    write(folder, "v.csv", header, rows)
    folder.run(*base)
    reference = read(folder.path / "v.out")[1]
    # What is even stays as it is.
    folder.run(*base, "--resample")
    checks.equal(read(folder.path / "v.out")[1], reference, "even rows resampled")
    checks.equal(folder.json("v.json")["gaps"], 0, "no gaps")
    # A gap: refused with its line, and with --resample left open.
    holes = rows[:1500] + rows[1540:2200] + rows[2201:]
    write(folder, "v.csv", header, holes)
    refused(checks, folder, base, r"v.csv:1502: t_s: a step of 0.0082 s; expected 0.0002 s .*--resample")
    done = folder.run(*base, "--resample")
    checks.equal(done.returncode, 0, f"gaps: exit code, {done.stderr}")
    result, got = folder.json("v.json"), read(folder.path / "v.out")[1]
    checks.equal([result["gaps"], result["resampled_rows"]], [2, 0], "gaps in JSON")
    checks.at_most(abs(result["gaps_s"] - 41 * 2e-4), 1e-9, "time that is missing")
    checks.true("gaps: 2, 0.0082 s in all; the estimator restarts" in done.stdout, done.stdout)
    checks.equal(got[:1500], reference[:1500], "before the gap the same")
    for at in (1500, 2160):
        checks.equal(got[at][1:], ["0"] * 5, "behind a gap nothing is known")
    errors = [abs(error_deg(float(a[1]), float(b[5]))) for a, b in zip(got[-500:], holes[-500:])]
    checks.at_most(max(errors), 1.0, "behind the gaps it finds the angle again")
    # Four rows per period, at uneven times.
    rng = random.Random(3)
    step = float(rows[1][0]) - float(rows[0][0])

    def between(k, share):
        """Row at k + share: voltage of row k, which acts until the next one."""
        mix = [(1 - share) * float(a) + share * float(b) for a, b in zip(rows[k], rows[k + 1])]
        turned = float(rows[k][5]) + share * math.remainder(
            float(rows[k + 1][5]) - float(rows[k][5]), 2 * math.pi)
        return [repr(x) for x in (mix[0], float(rows[k][1]), float(rows[k][2]), mix[3], mix[4],
                                  turned, mix[6])]

    folder.write("f.ini", f"[drive]\nf_pwm_Hz = {1 / step!r}\n")
    fast = [between(k, n / 4 + (rng.uniform(0, 0.2) if n else 0)) for k in range(len(rows) - 1)
            for n in range(4)]
    write(folder, "v.csv", header, fast)
    with_drive = [*base, "--drive", "f.ini"]
    refused(checks, folder, with_drive, r"v.csv:3: t_s: a row every .* expected one per PWM period, "
                                        r"every 0.0002 s by f_pwm_Hz = 5000; use --resample")
    done = folder.run(*with_drive, "--resample")
    checks.equal(done.returncode, 0, f"faster rows: exit code, {done.stderr}")
    got = read(folder.path / "v.out")[1]
    checks.true(abs(len(got) - len(rows)) <= 1, f"{len(got)} rows of {len(rows)} periods")
    off = max(abs(error_deg(float(a[1]), float(b[1]))) for a, b in zip(got[1000:], reference[1000:]))
    checks.at_most(off, 0.05, "four rows per period resampled, degrees beside the reference")
    checks.equal(folder.json("v.json")["resampled_rows"], len(fast), "rows resampled, in JSON")
    # Slower rows: nothing can be made of them.
    write(folder, "v.csv", header, rows[::3])
    for options in ([], ["--resample"]):
        refused(checks, folder, [*with_drive, *options],
                r"v.csv:3: t_s: a row every 0.0006 s; .*every 0.0002 s .*record every period")
    # A drive started anew, and times that do not rise.
    write(folder, "v.csv", header, rows[:900] + rows[:900])
    for options in ([], ["--resample"]):
        refused(checks, folder, [*base, *options], "^v.csv:902: t_s: a step of -.*rising times")
        for wrong in (rows[0][0], "0"): # all the same, or from the second row on
            write(folder, "w.csv", header, [rows[0]] + [[wrong, *row[1:]] for row in rows[1:900]])
            refused(checks, folder, ["replay", "--motor", "m.ini", "--recording", "w.csv", *options],
                    "^w.csv:3: t_s: a step of .*rising times")
        write(folder, "w.csv", header, rows[899::-1])
        refused(checks, folder, ["replay", "--motor", "m.ini", "--recording", "w.csv", *options],
                "^w.csv:3: t_s: a step of -0.0002 s; expected rising times")


def hostile_tables(checks, folder):
    header, rows = read(RECORDINGS / "steady-300rpm-5Nm.csv")
    rows = rows[:300]
    write(folder, "b.csv", header, rows)
    base = ["replay", "--motor", "m.ini", "--recording", "b.csv", "--out", "never.csv"]
    for option, pattern in {
            "i_alpha": "--column i_alpha: expected NAME=COLUMN",
            "=x": "--column =x: expected NAME=COLUMN",
            "i_alpha=": "--column i_alpha=: expected NAME=COLUMN",
            "current=x": "NAME is one of t, u_alpha, u_beta",
            "i_alpha=" + "x" * 300: "expected NAME=COLUMN",
            "i_alpha=Ialpha": r"b.csv:1: no column 'Ialpha' \(--column i_alpha=Ialpha\); "
                              "expected one of 't_s', 'u_alpha_V'",
            "i_alpha=i_alpha_A:V": "unit 'V'; expected A, mA, kA, or a factor",
            "i_alpha=i_alpha_A:": "unit ''; expected A, mA, kA",
            "i_alpha=i_alpha_A:0": "unit '0'; expected A",
            "i_alpha=i_alpha_A:nan": "unit 'nan'; expected A",
            "i_alpha=i_alpha_A:1e308": "b.csv:[0-9]+: i_alpha_A: .* expected a finite number",
            "i_alpha=#0": "no column '#0'", "i_alpha=#8": "no column '#8'",
            "i_alpha=#3x": "no column '#3x'",
            "i_alpha=$(touch never.csv)": r"no column '\$\(touch never.csv\)'"}.items():
        refused(checks, folder, [*base, "--column", option], pattern)
    refused(checks, folder, [*base, "--column", "t=t_s", "--column", "t=t_s"], "each NAME once")
    refused(checks, folder, [*base, *["--column", "t=t_s"] * 40], "expected at most 32 of them")
    refused(checks, folder, [*base, "--separator", "pipe"], "--separator pipe: expected auto, comma")
    refused(checks, folder, [*base, "--separator", "tab"], "b.csv:1: no column t_s")
    for option in ("--header", "--data"):
        for text in ("0", "-1", "x", "1x", "", "99999999999999999999999"):
            refused(checks, folder, [*base, option, text], f"{option} {text}: expected a line number")
    refused(checks, folder, [*base, "--header", "9999"], "b.csv: empty from the given line on")
    refused(checks, folder, [*base, "--header", "3"], "b.csv:3: no column t_s")
    refused(checks, folder, [*base, "--header", "none"], "b.csv:1: no column t_s")
    refused(checks, folder, [*base, "--data", "9999"], "b.csv: 0 rows; expected at least 3")
    write(folder, "b.csv", ["t_s", "x", "x", *header[1:]], [[r[0], "1", "2", *r[1:]] for r in rows])
    refused(checks, folder, [*base, "--column", "i_alpha=x"], "b.csv:1: several columns 'x'")
    write(folder, "b.csv", ["t_s", "t_ms", *header[1:]], [[r[0], *r] for r in rows])
    refused(checks, folder, base, "b.csv:1: column t_ms: expected each column once")
    write(folder, "b.csv", header[:3] + ["i_a_A"], [r[:4] for r in rows])
    refused(checks, folder, base, "b.csv:1: no column i_b_A; expected")
    write(folder, "b.csv", header[:1] + ["u_a_V", "u_b_V"] + header[3:], rows)
    refused(checks, folder, base, "b.csv:1: no column u_c_V; expected")
    write(folder, "b.csv", header + [f"c{k}" for k in range(300)], [r + ["1"] * 300 for r in rows])
    refused(checks, folder, base, "b.csv:1: expected at most 256 columns")
    text = "\n".join(";".join(r) for r in [header, *rows])
    folder.write("b.csv", text.replace(";" + rows[50][3] + ";", ";1.234,5;", 1))
    refused(checks, folder, base, "b.csv:52: i_alpha_A: '1.234,5'; expected a finite number")
    folder.write("b.csv", text.encode("utf-16"))
    refused(checks, folder, base, r"b.csv:1: a zero octet; expected text in UTF-8 or ASCII \(not UTF-16\)")
    folder.write("b.csv", text.encode() + b"\n1;2\0;3")
    refused(checks, folder, base, r"b.csv:302: a zero octet")
    folder.write("b.csv", '"' + text)
    refused(checks, folder, base, "b.csv:1: no column t_s")
    folder.write("b.csv", "t_s" + ",x" * 200000 + "\n")
    refused(checks, folder, base, "b.csv:1: expected at most 256 columns")
    rng = random.Random(11)
    for size in (1, 100, 10000):
        folder.write("b.csv", bytes(rng.randrange(1, 256) for _ in range(size)))
        refused(checks, folder, base, "b.csv")
    (folder.path / "b.csv").unlink()
    (folder.path / "b.csv").mkdir()
    refused(checks, folder, base, "b.csv: Is a directory; expected a CSV file")
    (folder.path / "b.csv").rmdir()


def main():
    checks = Checks()
    with Folder() as folder:
        folder.write("m.ini", MOTOR_ONLY)
        every_recording(checks, folder)
        voltage_of_the_row_before(checks, folder)
        layouts(checks, folder)
        reverse(checks, folder)
        from_the_middle(checks, folder)
        options(checks, folder)
        own_records(checks, folder)
        own_record_of_a_fault(checks, folder)
        tables(checks, folder)
        times(checks, folder)
        hostile_tables(checks, folder)
        bad_recordings(checks, folder)
    checks.done()


main()
