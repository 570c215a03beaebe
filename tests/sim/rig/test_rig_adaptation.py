"""lodestar run with [adaptation]: what it finds on plants that are not as configured; table, columns, refusals."""
import csv
import itertools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import FULL, SOURCE, Checks, Folder, refused

DATA = SOURCE / "sim" / "data"
# The last one has six phases.
MACHINES = ["jiang2022", "servo_48V", "fan_325V", "compressor_310V", "drone_900KV", "ultrazohm6"]
ON = [f"--set=adaptation.{name}=on" for name in ("J", "psi", "Rs")]
# Over the configured one; the resistance with the start's measurement off, which would take it.
CASES = {
    "J x0.3": {"J": 0.3},
    "J x3": {"J": 3.0},
    "psi x0.9": {"psi": 0.9},
    "Rs x1.3": {"Rs": 1.3},
}
KEYS = {"J": "plant.J_kgm2", "psi": "plant.psi_Wb", "Rs": "plant.Rs_Ohm"}
# As measured, of the true value: inertia 5.6 % at most, flux 0.9 %; resistance where it is sure.
BARS = {"J": 0.08, "psi": 0.015, "Rs": 0.1}
# `ultrazohm6` with 0.3 of its inertia: 8.6 %; held to what self-commissioning is held to.
SIX_J_BAR = 0.1
# 20 s at rest with a third of i_max: the configured one still has 0.4 of the weight.
SIX_RS_BAR = 0.15
# More, for dead time and drops that are 20 % off, of the rated EMF: these 2 %, and what R makes of the current 1.4 %.
SIX_DEAD_TIME_BAR = 0.034
SIX = {"J": 0.01, "psi": 0.1746, "Rs": 0.8}
COLUMNS = {"J": "adapted_J_kgm2", "psi": "adapted_psi_Wb", "Rs": "adapted_Rs_Ohm"}
SURE = 0.5


def scenario_of(folder, machine, checks):
    """Ramps up and down without load, then with; the speeds and the load are those of the trial run."""
    done = folder.run("run", "--motor", machine, "--drive", machine, *ON, "--json", "trial.json")
    checks.equal(done.returncode, 0, f"{machine}: {done.stdout[-300:]}{done.stderr}")
    trial = folder.json("trial.json")
    phase = {each["name"]: each for each in trial["phases"]}
    # Where the start ends above half of full speed there is no other phase for it.
    half, full = (phase[name]["speed_command_rpm"] for name in ("half_speed" if "half_speed" in phase else "start", "full_speed"))
    seconds = phase["full_speed"]["end_s"] - phase["full_speed"]["start_s"]
    load = phase["load"]["load_Nm"]
    text = f"[scenario]\nmotor = {DATA}/motors/{machine}.ini\ndrive = {DATA}/drives/{machine}.ini\n"
    text += f"[phase.start]\nduration_s = {phase['start']['end_s']}\nload_Nm = 0\nspeed_rpm = {half}\n"
    for n in range(4):
        text += f"[phase.up_{n}]\nduration_s = {seconds}\nspeed_rpm = {full}\n"
        text += f"[phase.load_{n}]\nduration_s = 1\nload_Nm = {load}\n"
        text += f"[phase.free_{n}]\nduration_s = 1\nload_Nm = 0\n"
        text += f"[phase.down_{n}]\nduration_s = {seconds}\nspeed_rpm = {half}\n"
    (folder.path / "ramps.ini").write_text(text)
    return {name: trial["adapted"][name]["configured"] for name in KEYS}


def accuracy(checks, folder):
    for machine in MACHINES:
        configured = scenario_of(folder, machine, checks)
        for case, truth in CASES.items():
            sets = [f"--set={KEYS[name]}={share * configured[name]}" for name, share in truth.items()]
            sets += ["--set=start.measure=off"] if "Rs" in truth else []
            done = folder.run("run", "ramps.ini", *ON, *sets, "--json", "out.json")
            if not checks.equal(done.returncode, 0, f"{machine}, {case}: {done.stdout[-300:]}"):
                continue
            for name, found in folder.json("out.json")["adapted"].items():
                true = truth.get(name, 1.0) * configured[name]
                off = abs(found["value"] / true - 1.0)
                text = f"{machine}, {case}: {name} {found['value'] / true:.3f} of the true one ({found['confidence']:.2f})"
                print(text)
                if name != "Rs":
                    checks.true(found["confidence"] >= SURE, f"{text}: expected to be sure")
                if found["confidence"] >= SURE:
                    checks.at_most(off, SIX_J_BAR if name == "J" and machine == "ultrazohm6" else BARS[name], text)


def resistance(checks, folder):
    """Where it shows: at low speed with much current, after the flux has been seen."""
    text = (f"[scenario]\nmotor = {DATA}/motors/jiang2022.ini\ndrive = {DATA}/drives/jiang2022.ini\n"
            "[phase.start]\nduration_s = 4\nspeed_rpm = 1500\nload_Nm = 0\n"
            "[phase.flux]\nduration_s = 10\nload_Nm = 5\n"
            "[phase.slow]\nduration_s = 30\nspeed_rpm = 240\n")
    (folder.path / "slow.ini").write_text(text)
    for measure in ("on", "off"):
        done = folder.run("run", "slow.ini", *ON, "--set=plant.Rs_Ohm=0.975",
                          f"--set=start.measure={measure}", "--json", "out.json")
        checks.equal(done.returncode, 0, f"measure {measure}: {done.stdout[-300:]}")
        found = folder.json("out.json")["adapted"]["Rs"]
        print(f"measure {measure}: {found}")
        checks.at_most(abs(found["value"] / 0.975 - 1.0), BARS["Rs"], f"measure {measure}: {found}")
        checks.true(found["confidence"] >= SURE, f"measure {measure}: {found}: expected to be sure")


def beside_learning(checks, folder):
    """R, psi and Lq wrong at once: R at rest, psi and Lq at 600 rpm, and none of them drifts from there."""
    for seed, Rs, psi in [(1, 0.975, 0.1278), (2, 0.525, 0.1562)]:
        done = folder.run("run", "zero_adapt", "--seed", seed, "--set", f"plant.Rs_Ohm={Rs}",
                          "--set", f"plant.psi_Wb={psi}", "--set", "scenario.log_s=0.1",
                          "--json", "out.json", "--csv", "out.csv")
        checks.equal(done.returncode, 0, f"seed {seed}: {done.stdout[-300:]}{done.stderr}")
        with open(folder.path / "out.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        held = [row for row in rows if 10 < float(row["t_s"]) < 11]
        for row in held:
            # Mostly 1 %; up to 9 % where a phase current lies near its zero, by what is not known of the dead time.
            checks.at_most(abs(float(row["adapted_Rs_Ohm"]) / Rs - 1), 0.10, "resistance at rest")
            checks.true(float(row["adapted_Rs_confidence"]) >= SURE, "resistance is sure")
        for row in [row for row in rows if float(row["t_s"]) > 31]:
            checks.at_most(abs(float(row["adapted_psi_Wb"]) / psi - 1), BARS["psi"], "flux")
            checks.true(float(row["adapted_psi_confidence"]) >= SURE, "flux is sure")
            checks.at_most(abs(float(row["Lq_est_H"]) / float(row["Lq_H"]) - 1), 0.05, "Lq of a moment")
        # The last moment's values, as the telemetry has them.
        adapted = folder.json("out.json")["adapted"]
        checks.equal(list(adapted), ["psi", "Rs", "Lq"], "what is told")
        for name, column in [("psi", "adapted_psi_Wb"), ("Rs", "adapted_Rs_Ohm"), ("Lq", "Lq_est_H")]:
            checks.at_most(abs(adapted[name]["value"] / float(rows[-1][column]) - 1), 0.01, f"{name} at the end")
            checks.true(0 <= adapted[name]["confidence"] <= 1, f"{name}: {adapted[name]}")
        checks.true(adapted["Lq"]["confidence"] >= SURE and "\nLq   H " in done.stdout, f"Lq is told: {done.stdout}")


def six_phases(checks, folder):
    """R, psi and J wrong at once, alone or with the dead time and drops that the drive goes by. A phase that breaks
    leaves all as it is. In a campaign all signs."""
    signs = [(2.0, 0.9, 1.3), (0.5, 1.1, 0.7)]
    if FULL:
        signs = list(itertools.product((0.5, 2.0), (0.9, 1.1), (0.7, 1.3)))
    for seed, shares in enumerate(signs, 1):
        one_of_six_phases(checks, folder, seed, dict(zip(SIX, shares)))
    for share, shares in itertools.product((0.8, 1.2) if FULL else (), signs):
        # At rest an error of the dead time is as large as what R makes, and trips FLUX: R is not looked for there.
        one_of_six_phases(checks, folder, 1, dict(zip(SIX, shares)), f"--set=drive.dead_time_s={share * 2e-6}",
                          f"--set=drive.v_drop_V={share}", "--set=phase.held.speed_rpm=400")


def one_of_six_phases(checks, folder, seed, truth, *more):
    sets = [f"--set={KEYS[name]}={share * SIX[name]}" for name, share in truth.items()]
    done = folder.run("run", "dtp_adapt", "--seed", seed, *sets, *more, "--set=scenario.log_s=0.05",
                      "--json", "out.json", "--csv", "out.csv")
    label = f"six phases, {truth} {' '.join(more)}"
    if not checks.equal(done.returncode, 0, f"{label}: {done.stdout[-300:]}{done.stderr}"):
        return
    names = [phase["name"] for phase in folder.json("out.json")["phases"]]
    with open(folder.path / "out.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    of = {name: [row for row in rows if int(row["phase"]) == k] for k, name in enumerate(names)}
    room = SIX_DEAD_TIME_BAR if more else 0.0
    bars = [("fast", "J", BARS["J"] + room), ("fast", "psi", BARS["psi"] + room), ("held", "Rs", SIX_RS_BAR)]
    for phase, name, bar in bars:
        row = of[phase][-1]
        found, sure = float(row[COLUMNS[name]]) / (truth[name] * SIX[name]), float(row[f"adapted_{name}_confidence"])
        text = f"{label}: {name} {found:.3f} of the true one ({sure:.2f})"
        print(text)
        if name != "Rs" or not more:
            checks.at_most(abs(found - 1.0), bar, text)
            checks.true(sure >= SURE, f"{text}: expected to be sure")
    alone = [tuple(row[column] for column in row if column.startswith("adapted_")) for row in of["broken"][2:]]
    checks.equal(len(set(alone)), 1, f"{label}: values and confidences while a set is out")


def output(checks, folder):
    """Each for itself, by default none."""
    for on in ([], ["J"], ["psi"], ["Rs"]):
        sets = [f"--set=adaptation.{name}=on" for name in on]
        done = folder.run("run", "servo", *sets, "--csv", "out.csv", "--json", "out.json")
        checks.equal(list(folder.json("out.json").get("adapted", {})), on, f"{on}: JSON")
        rows = [line.split()[0] for line in done.stdout.partition("\nadapted ")[2].splitlines()[1:4]
                if line.strip()]
        checks.equal(rows[:1], on, f"{on}: table {done.stdout}")
        header = (folder.path / "out.csv").read_text().partition("\n")[0].split(",")
        names = [name for name in header if name.startswith("adapted_")]
        checks.equal(len(names), 6 if on else 0, f"{on}: columns {names}")


with Folder() as place:
    tally = Checks()
    accuracy(tally, place)
    resistance(tally, place)
    output(tally, place)
    beside_learning(tally, place)
    six_phases(tally, place)
    refused(tally, place, ["run", "servo", "--set", "adaptation.J=yes"], r"off, on|off\|on|off or on")
    (place.path / "factor.ini").write_text((place.path / "slow.ini").read_text() + "Rs_factor = 1.1\n")
    refused(tally, place, ["run", "factor.ini", "--set", "adaptation.J=on"], r"Rs_factor: expected none")
    tally.done()
