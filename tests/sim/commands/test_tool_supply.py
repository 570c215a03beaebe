"""`lodestar run` with [supply] and [chopper]: limits of the supply's current, the brake chopper, a bus that fills."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, Checks, Folder, refused


def phases(folder, scenario, *sets):
    words = [word for one in sets for word in ("--set", one)]
    done = folder.run("run", scenario, *words, "--json", "r.json")
    return done, {phase["name"]: phase for phase in folder.json("r.json")["phases"]}


def limits(checks, folder):
    """Each limit is held, and reached; without them the same run takes more than twice as much."""
    done, phase = phases(folder, "supply")
    checks.equal(done.returncode, 0, f"exit code: {done.stdout}{done.stderr}")
    checks.true("supply: at most" in done.stdout, "the currents are printed")
    checks.at_most(phase["up"]["battery_A"], 60 * 1.03, "A out of the battery, limit 60")
    checks.at_most(60 * 0.97, phase["up"]["battery_A"], "which is reached")
    checks.at_most(phase["down"]["regen_A"], 25 * 1.03, "A into the battery, limit 25")
    checks.at_most(25 * 0.97, phase["down"]["regen_A"], "which is reached")
    done, phase = phases(folder, "supply", "supply.battery_A=0", "supply.regen_A=0")
    checks.equal(done.returncode, 1, "without limits the bars are missed")
    checks.at_most(120, phase["up"]["battery_A"], "without limits: out of the battery")
    checks.at_most(50, phase["down"]["regen_A"], "without limits: into the battery")
    # Magnets 8 % weaker or stronger than believed: the current corrects the torque.
    for psi_Wb in ("0.11", "0.13"):
        _, phase = phases(folder, "supply", f"plant.psi_Wb={psi_Wb}")
        checks.at_most(phase["up"]["battery_A"], 60 * 1.04, f"A out of the battery with psi = {psi_Wb} Wb")
        checks.at_most(phase["down"]["regen_A"], 25 * 1.04, f"A into the battery with psi = {psi_Wb} Wb")
    _, phase = phases(folder, "supply", "supply.regen_A=none")
    checks.at_most(phase["down"]["regen_A"], 1, "A into a battery that shall take none")
    checks.at_most(phase["down"]["speed_rpm"]["mean"], 5900, "rpm at the end: the losses brake")


def chopper(checks, folder):
    """With the resistor the bus stays below full_V; without it, and with one that gets too hot, the drive trips."""
    done, phase = phases(folder, "chopper")
    checks.equal(done.returncode, 0, f"exit code: {done.stdout}{done.stderr}")
    checks.at_most(phase["down"]["v_bus_max_V"], 460, "V of the bus, full_V 460")
    checks.at_most(440, phase["down"]["v_bus_max_V"], "V of the bus: the chopper is needed")
    for sets in (("chopper.on_V=1999", "chopper.full_V=2000"), ("chopper.power_W=50",)):
        done, phase = phases(folder, "chopper", *sets)
        checks.equal(done.returncode, 1, f"exit code with {sets}")
        checks.true("LODE_CHECK_OVER_VOLTAGE" in done.stdout, f"the bus trips with {sets}: {done.stdout}")


def fade(checks, folder):
    """Braking torque is gone before the guard trips; where its fade ends at the guard's limit, it trips."""
    for farads in ("0.0005", "0.001", "0.005"):
        for begins in ("205", "230"):
            sets = (f"plant.bus_C_F={farads}", f"references.v_regen_V={begins}")
            done, phase = phases(folder, "regen", *sets, "phase.down.bar_v_bus_V=250")
            checks.equal(done.returncode, 0, f"exit code with {sets}: {done.stdout}{done.stderr}")
            checks.at_most(float(begins), phase["down"]["v_bus_max_V"], f"V of the bus with {sets}: the fade is needed")
    done, _ = phases(folder, "regen", "references.v_bus_max_V=250")
    checks.equal(done.returncode, 1, "exit code with a fade up to the guard's limit")
    checks.true("LODE_CHECK_OVER_VOLTAGE" in done.stdout, f"the bus trips then: {done.stdout}")


def nothing(checks, folder):
    """A run that asks for neither tells nothing of the supply."""
    folder.write("n.ini", f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n[phase.a]\nduration_s = 0.01\n")
    done, phase = phases(folder, "n.ini")
    checks.equal(done.returncode, 0, f"exit code: {done.stderr}")
    checks.true("supply:" not in done.stdout, "no line")
    checks.equal(phase["a"]["battery_A"], None, "no current")
    done, phase = phases(folder, "n.ini", "phase.a.bar_v_bus_V=150")
    checks.equal(done.returncode, 1, "a bar for the bus, missed")
    checks.equal(phase["a"]["v_bus_max_V"], 200, "V of the bus")


def keys(checks, folder):
    run = ["run", "chopper", "--set"]
    refused(checks, folder, [*run, "chopper.full_V=410"], "CHOPPER: expected all of on_V, full_V above it")
    refused(checks, folder, ["run", "supply", "--set", "chopper.on_V=410"], "CHOPPER: expected all of")
    refused(checks, folder, [*run, "plant.bus_C_F=0"], "needs bus_C_F")
    refused(checks, folder, [*run, "supply.regen_A=-1"], "expected .*none")
    refused(checks, folder, [*run, "supply.correct_s=0"], "expected a number in 0.001")


checks = Checks()
with Folder() as folder:
    limits(checks, folder)
    chopper(checks, folder)
    fade(checks, folder)
    nothing(checks, folder)
    keys(checks, folder)
checks.done()
