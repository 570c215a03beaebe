"""`lodestar run` with [supervisor]: what follows a fault, and the fault log."""
import csv
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, SOURCE, Checks, Folder, refused


def restarts(checks, folder):
    """A sag is ridden through, a surge followed by a start, and the third fault in a row stays."""
    done = folder.run("run", "restart", "--json", "r.json")
    checks.equal(done.returncode, 0, f"exit code: {done.stdout}{done.stderr}")
    result = folder.json("r.json")
    checks.equal([fault["check"] for fault in result["fault_log"]],
                 ["LODE_CHECK_UNDER_VOLTAGE", "LODE_CHECK_OVER_VOLTAGE", "LODE_CHECK_OVER_VOLTAGE"], "causes")
    starts = [event["t_s"] for event in result["events"] if event["text"] == "FAULT -> OFF"]
    checks.equal(len(starts), 2, "attempts")
    checks.at_most(starts[0] - 2.05, 0.003, "s from the end of the sag to the attempt")
    checks.at_most(abs(starts[1] - result["fault_log"][1]["t_s"] - 0.2), 0.003, "s off wait_s")
    # The estimate of the call that leaves PRECHARGE for RUN is still that of open gates.
    worst = max(phase["angle_error_max_deg"] for phase in result["phases"] if phase["mode"] == "RUN")
    checks.at_most(worst, 20, "deg in RUN, behind each start too")
    checks.true("the drive's fault log" in done.stdout, "the log is printed")
    more = folder.run("run", "restart", "--set", "supervisor.attempts=3", "--json", "m.json")
    checks.equal(more.returncode, 1, "with one attempt more it does not stay off, as the scenario expects")
    checks.equal(folder.json("m.json")["phases"][-1]["mode"], "RUN", "mode after three attempts of three")


def without(checks, folder):
    """Nothing configured: the fault stays and ends the run, as ever."""
    sets = [word for key in ("under_voltage", "over_voltage") for word in ("--set", f"supervisor.{key}=latch")]
    done = folder.run("run", "restart", *sets, "--json", "n.json")
    result = folder.json("n.json")
    checks.equal([phase["name"] for phase in result["phases"]], ["run", "sag"], "phases up to the fault")
    checks.equal(len(result["fault_log"]), 1, "faults")
    checks.true("the drive's fault log" not in done.stdout, "one fault needs no log on the screen")


def keys(checks, folder):
    """Each check has its key, by its name."""
    header = (SOURCE / "include/lodestar/guard.h").read_text()
    names = set(re.findall(r"LODE_CHECK_(\w+)", header)) - {"NONE", "COUNT"}
    sets = [word for name in sorted(names) for word in ("--set", f"supervisor.{name.lower()}=again")]
    folder.write("k.ini", f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n[phase.a]\nduration_s = 0.01\n")
    done = folder.run("run", "k.ini", *sets)
    checks.equal(done.returncode, 0, f"a reaction to each check: {done.stderr}")
    refused(checks, folder, ["run", "k.ini", "--set", "supervisor.lost_lock=ignore"],
            "expected latch, again or ride-through")
    refused(checks, folder, ["run", "k.ini", "--set", "supervisor.attempts=256"], "expected .*255")


def largest(folder, name, since_s):
    """(bus voltage, phase current, sampled) from then on."""
    with open(folder.path / name, newline="") as file:
        rows = [row for row in csv.DictReader(file) if float(row["t_s"]) >= since_s]
    return (max(float(row["v_bus_V"]) for row in rows),
            max(abs(float(row[phase])) for row in rows for phase in ("ia_A", "ib_A", "ic_A")))


def shorts(checks, folder):
    """With the field weakened the bus is not charged, and the current stays below the guard's limit."""
    often = ["--set", "scenario.log_s=1e-4", "--csv", "s.csv"]
    done = folder.run("run", "active_short", *often)
    checks.equal(done.returncode, 0, f"exit code: {done.stdout}{done.stderr}")
    bus_V, current_A = largest(folder, "s.csv", 5.0)
    checks.at_most(bus_V, 405, "V of the bus of 400 V")
    checks.at_most(current_A, 450, "A, of the guard's limit")
    checks.at_most(abs(largest(folder, "s.csv", 5.45)[1] - 200), 10, "A off psi/Ld at the end")
    folder.run("run", "active_short", *often, "--set", "supervisor.active_short=off")
    checks.at_most(500, largest(folder, "s.csv", 5.0)[0], "the bus without it, at least 500 V")
    refused(checks, folder, ["run", "main", "--set", "supervisor.active_short=on"],
            "ACTIVE_SHORT: expected a motor whose psi/Ld, 40.57 A, is at most i_max, 12 A")


# Of an electrical turn at 3000 rpm, four pole pairs.
TURN_s = 5.0e-3
INSTANTS = 18


def shorted(folder, side, short, up_s):
    """The fault, and the largest current from 20 ms after the switch is shorted."""
    data = SOURCE / "sim/data"
    folder.write("w.ini", f"[scenario]\nmotor = {data}/motors/mtpv_400V.ini\ndrive = {data}/drives/traction_400V.ini\n"
                          "[plant]\ninverter = switched\nload_kind = passive\n"
                          f"[phase.up]\nduration_s = {up_s}\nspeed_rpm = 3000\nend_mode = run\n"
                          "[phase.broken]\nduration_s = 0.1\nend_mode = fault\n")
    folder.run("run", "w.ini", "--set", f"phase.broken.shorted_switch={side}", "--set", "scenario.log_s=1e-4",
               "--set", f"supervisor.active_short={short}", "--csv", "w.csv", "--json", "w.json")
    return folder.json("w.json")["fault_log"][-1], largest(folder, "w.csv", up_s + 0.02)[1]


def shorted_above_the_bus(checks, folder):
    """With an EMF of 1.3 times the bus: the side is named before the low sides may go on."""
    for side in ("low", "high"):
        for k in range(INSTANTS):
            folder.run("run", "active_short", "--set", "phase.hot.temperature_degC=40", "--set", f"phase.hot.shorted_switch={side}",
                       "--set", f"phase.up.duration_s={3.0 + k * TURN_s / INSTANTS}", "--json", "w.json")
            last = folder.json("w.json")["fault_log"][-1]
            checks.equal(last["check"], "LODE_CHECK_SWITCH_SHORTED", f"the {side} side is shorted")
            checks.true((last["measured"] < 0) == (side == "low"), f"{side}: {last['measured']} A")


def shorted_switches(checks, folder):
    """The side is named; a low side is joined by the others, a high side is not."""
    ratios = {"low": [], "high": []}
    for side in ratios:
        for k in range(INSTANTS):  # one electrical turn: the angle at the fault decides by how much
            current_A = {}
            for short in ("on", "off"):
                last, current_A[short] = shorted(folder, side, short, 3.0 + k * TURN_s / INSTANTS)
                checks.equal(last["check"], "LODE_CHECK_SWITCH_SHORTED", f"the {side} side is shorted")
                checks.true((last["measured"] < 0) == (side == "low"), f"{side}: {last['measured']} A")
            ratios[side].append(current_A["on"] / current_A["off"])
    checks.at_most(sum(ratios["low"]) / INSTANTS, 0.6, f"current of the short of all over that of one: {ratios['low']}")
    # The start comes with the main loop's pass: another angle. Low sides on would short the bus: 12 times the current.
    checks.at_most(max(ratios["high"]), 1.05, f"a shorted high side is left alone: {ratios['high']}")


checks = Checks()
with Folder() as folder:
    restarts(checks, folder)
    without(checks, folder)
    keys(checks, folder)
    shorts(checks, folder)
    shorted_switches(checks, folder)
    shorted_above_the_bus(checks, folder)
checks.done()
