"""`lodestar replay`: the firmware's estimator over recordings of an independent simulator."""
import csv
import math
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent / "support"))
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
    refused(checks, folder, [*base, "--set", "motor.Lq_H=-1"], r"\[motor\] Lq_H: LODE_ERROR_MOTOR_LQ")


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
        refused(checks, folder, arguments, r"b.csv:202: t_s: a step of .*within 1 %")
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
    refused(checks, folder, arguments, "b.csv: t_s: steps of 0.01 s; expected")
    refused(checks, folder, arguments[:4] + ["nowhere.csv"], "nowhere.csv: No such file")
    folder.write("b.csv", "")
    (folder.path / "b.csv").unlink()
    write(folder, "b.csv", header, rows)
    folder.write("m.ini", MOTOR_ONLY.replace("psi_Wb = 0.142\n", ""))
    refused(checks, folder, arguments, r"m.ini: \[motor\] psi_Wb: missing; expected it in a file")


def own_records(checks, folder):
    """What a drive records of itself goes in as it is: the run's CSV, and ring and scope decoded."""
    folder.write("s.ini", f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\nlog_s = 2e-4\n"
                          "[phase.start]\nduration_s = 2\nspeed_rpm = 450\nload_Nm = 1\n")
    folder.run("run", "s.ini", "--csv", "run.csv", "--ring", "r.bin", "--scope", "s.bin",
               "--channels", "mode,i_beta_A,u_beta_V,i_alpha_A,u_alpha_V,theta_rad",
               "--trigger", "omega_rad_s>120")
    folder.run("decode", "r.bin", "--csv", "ring.csv")
    folder.run("decode", "s.bin", "--csv", "scope.csv")
    base = ["replay", "--motor", MOTOR, "--drive", DRIVE, "--out", "o.csv", "--recording"]
    estimates = {}
    for name in ["run.csv", "ring.csv", "scope.csv"]:
        done = folder.run(*base, name, "--json", "o.json")
        if checks.equal(done.returncode, 0, f"exit code, {name}: {done.stderr}"):
            estimates[name] = read(folder.path / "o.csv")[1]
        if name == "run.csv":
            checks.at_most(abs(folder.json("o.json")["angle_error_mean_deg"]), 1.0,
                           "the drive's own record: mean angle error")
    checks.equal(estimates["ring.csv"], estimates["run.csv"], "ring and run: the same estimates")
    header, rows = read(folder.path / "run.csv")
    theta, mode = header.index("theta_est_rad"), header.index("mode")
    late = [k for k, row in enumerate(rows) if row[mode] == "5"][1000:]
    off = [abs(error_deg(float(estimates["run.csv"][k][1]), float(rows[k][theta]))) for k in late]
    # Not to the bit: the slow parts fall into other periods than in the drive.
    checks.at_most(max(off), 0.01, f"the drive's own angle again, degrees, {len(late)} rows of RUN")
    checks.true(len(late) > 3000, f"{len(late)} rows of RUN")


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
        bad_recordings(checks, folder)
    checks.done()


main()
