"""`lodestar run` with [supervisor]: what follows a fault, and the fault log."""
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


checks = Checks()
with Folder() as folder:
    restarts(checks, folder)
    without(checks, folder)
    keys(checks, folder)
checks.done()
