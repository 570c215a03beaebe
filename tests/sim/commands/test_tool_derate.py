"""`lodestar run` with [derate]: heat of the winding and of the power stage reduce the torque."""
import csv
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, Checks, Folder, refused

CONTINUOUS_A, WINDING_s = 6.0, 3.0  # of derate.ini
Nm_per_A = 1.5 * 3 * 0.142  # of the motor


def near(checks, value, wanted, off, text):
    checks.at_most(abs(value - wanted), off, f"{text}: {value}, expected {wanted}; off by")


def phases(folder, *sets):
    words = [word for one in sets for word in ("--set", one)]
    done = folder.run("run", "derate", *words, "--json", "d.json", "--csv", "d.csv")
    return done, {phase["name"]: phase for phase in folder.json("d.json")["phases"]}


def limits(checks, folder):
    """The torque falls to that of the continuous current, further with a hot power stage, and comes back."""
    done, phase = phases(folder)
    checks.equal(done.returncode, 0, f"exit code: {done.stdout}{done.stderr}")
    near(checks, phase["overload"]["torque_Nm"]["mean"], Nm_per_A * CONTINUOUS_A, 0.05, "Nm of the continuous current")
    near(checks, phase["overload"]["winding_heat_max"], 1, 0.03, "heat of the continuous current")
    near(checks, phase["hot_stage"]["torque_Nm"]["mean"], Nm_per_A * 12 / 4, 0.05, "Nm at 95 of 80 .. 100 degC")
    near(checks, phase["hot_stage"]["derated_share_min"], 0.25, 0.01, "share at 95 of 80 .. 100 degC")
    near(checks, phase["rest"]["torque_Nm"]["mean"], 1, 0.02, "Nm as commanded")
    checks.true("derating permits 25 % of the torque" in done.stdout, f"the reason is told: {done.stdout}")
    checks.true("derating: winding at most 1.00 of its continuous heat, torque down to 50 %" in done.stdout, "the line of a phase")
    done, phase = phases(folder, "derate.i_continuous_A=12")
    near(checks, phase["overload"]["torque_Nm"]["mean"], 6, 0.05, "Nm of a winding that bears it")
    done, phase = phases(folder, "phase.overload.bar_heat=0.5")
    checks.equal(done.returncode, 1, "exit code with a bar that is missed")
    checks.true("BAR MISSED: heat of the winding 1, bar 0.5" in done.stdout, f"which is told: {done.stdout}")
    _, phase = phases(folder, "derate.heat=1")
    checks.at_most(1, phase["start"]["winding_heat_max"], "heat of a winding that is hot at the start")


def heat(checks, folder):
    """The heat is that of the true currents behind the winding's time constant."""
    phases(folder)
    with open(folder.path / "d.csv", newline="") as file:
        rows = [{name: float(row[name]) for name in ("t_s", "id_A", "iq_A", "winding_heat")} for row in csv.DictReader(file)]
    h, worst = 0.0, 0.0
    for before, now in zip(rows, rows[1:]):
        squared = (before["id_A"] ** 2 + before["iq_A"] ** 2) / CONTINUOUS_A**2
        h += (1 - math.exp(-(now["t_s"] - before["t_s"]) / WINDING_s)) * (squared - h)
        worst = max(worst, abs(h - now["winding_heat"]))
    checks.at_most(0.5, max(row["winding_heat"] for row in rows), "heat")
    checks.at_most(worst, 0.03, "heat off by")


def with_supply(checks, folder):
    """The lower one of both limits holds."""
    done, phase = phases(folder, "supply.battery_A=2")
    checks.at_most(phase["overload"]["battery_A"], 2 * 1.04, "A out of the supply")
    checks.at_most(phase["overload"]["torque_Nm"]["mean"], 3.2, "Nm: limited by the supply")
    near(checks, phase["hot_stage"]["torque_Nm"]["mean"], 1.92, 0.05, "Nm: limited by the hot power stage")


def nothing(checks, folder):
    """A run that does not ask for it tells nothing of it."""
    folder.write("n.ini", f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n[phase.a]\nduration_s = 0.01\n")
    done = folder.run("run", "n.ini", "--json", "n.json", "--csv", "n.csv")
    checks.equal(done.returncode, 0, f"exit code: {done.stderr}")
    checks.true("derating" not in done.stdout, "no line")
    checks.equal(folder.json("n.json")["phases"][0]["winding_heat_max"], None, "no heat")
    checks.true("winding_heat" not in (folder.path / "n.csv").read_text(), "no column")


def keys(checks, folder):
    refused(checks, folder, ["run", "derate", "--set", "derate.i_continuous_A=13"], r"\[derate\]: LODE_ERROR_DERATE: expected i_continuous_A up to i_max_A = 12")
    refused(checks, folder, ["run", "derate", "--set", "derate.to_degC=110"], "at most .guard. temperature_max_degC = 100")
    refused(checks, folder, ["run", "derate", "--set", "derate.from_degC=100"], "from_degC below to_degC = 100")
    refused(checks, folder, ["run", "derate", "--set", "derate.winding_s=0"], "expected a number in 0.1")


checks = Checks()
with Folder() as folder:
    limits(checks, folder)
    heat(checks, folder)
    with_supply(checks, folder)
    nothing(checks, folder)
    keys(checks, folder)
checks.done()
