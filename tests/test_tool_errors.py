"""What the tool says to bad input: exit code 2, the place, and what was expected."""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent / "support"))
from tool import DRIVE, MOTOR, RECORDINGS, SOURCE, Checks, Folder, refused

STEADY = RECORDINGS / "steady-300rpm-5Nm.csv"
OBSERVERS = (SOURCE / "include/lodestar/observers.def").read_text()
BUILT = {"--emf": re.findall(r'^LODE_OBSERVER\(.*"(.*)"', OBSERVERS, re.MULTILINE),
         "--pll": ["leso-qpll", "qpll", "enhanced"]}
# The papers' own forms, which go together.
EULER = {"--emf": ["c-leso-euler", "gi-leso-euler", "fa-leso-euler"],
         "--pll": ["leso-qpll-euler", "qpll-euler", "enhanced-euler"]}


def command_line(checks, folder):
    for arguments, pattern in [
        (["foo"], "foo: unknown command; expected list, run, replay, design"),
        (["--foo"], "--foo: unknown here; expected one of --set, --seed"),
        (["list", "--seed", "1"], "--seed: unknown here"),
        (["run"], "run: expected a scenario file"),
        (["run", "a.ini", "b.ini"], "b.ini: expected nothing there"),
        (["run", "nofile.ini"], r"nofile.ini: No such file.*expected an INI file"),
        (["run", "main", "--set"], "--set: expected a value after it"),
        (["run", "main", "--set", "x"], "--set x: expected section.key=value"),
        (["run", "main", "--set", "a=1"], "--set a=1: expected section.key=value"),
        (["run", "main", "--seed", "1.5"], "--seed 1.5: expected a whole number"),
        (["run", "main", "--seed", "-1"], "--seed -1: expected a whole number"),
        (["run", "main", "--seed", "18446744073709551615"], "expected a whole number, 0"),
        (["run", "start", "--seeds", "5-1"], "--seeds 5-1: expected two whole numbers"),
        (["run", "start", "--seeds", "1-2", "--seed", "1"], "--seed or --seeds, not both"),
        (["run", "start", "--seeds", "1-2", "--jobs", "0"], "--jobs 0: expected a whole number"),
        (["run", "start", "--seeds", "1-2", "--jobs", "2x"], "--jobs 2x: expected a whole number"),
        (["run", "start", "--jobs", "2"], "--jobs: expected with --seeds only"),
        (["run", "start", "--seeds", "1-2", "--csv", "a.csv"], "expected no --csv"),
        (["replay", "--motor", MOTOR], "replay: expected --recording"),
        (["replay", "--recording", STEADY], "replay: expected --motor"),
        (["design"], "design: expected --motor"),
        (["design", "--motor", MOTOR, "--json", "a.json"], "or --json=a.json"),
    ]:
        refused(checks, folder, arguments, pattern)


def values(checks, folder):
    for assignment, pattern in [
        ("foo.bar=1", r"--set: \[foo\] bar: unknown; expected one of motor, drive, estimator"),
        ("motor.foo=1", r"--set: \[motor\] foo: unknown; expected one of pole_pairs, Rs_Ohm"),
        ("motor.Rs_Ohm=", "expected a finite number, not ''"),
        ("motor.Rs_Ohm=0.75x", "expected a finite number, not '0.75x'"),
        ("motor.Rs_Ohm=nan", "expected a finite number"),
        ("motor.Rs_Ohm=1e999", "expected a finite number"),
        ("motor.Rs_Ohm=1e-60", "expected a finite number"),
        ("motor.Rs_Ohm=auto", "expected a finite number"),
        ("motor.Rs_Ohm=-1", r"\[motor\] Rs_Ohm: LODE_ERROR_MOTOR_RS: expected 0 .. 1e3"),
        ("motor.pole_pairs=2.5", "LODE_ERROR_MOTOR_POLE_PAIRS"),
        ("drive.f_pwm_Hz=100", r"\[drive\] f_pwm_Hz: LODE_ERROR_F_PWM"),
        ("drive.i_range_A=1", r"\[drive\] i_range_A: LODE_ERROR_SENSE_CURRENT"),
        ("drive.shunts=four", "expected three or two, not 'four'"),
        ("estimator.sigma_rad_s=900", r"\[estimator\] sigma_rad_s: LODE_ERROR_PLL_OBSERVER"),
        ("estimator.emf=nonsense", "expected c-leso"),
        ("start.current_A=1000", "LODE_ERROR_START_CURRENT"),
        ("plant.inverter=perfect", "expected ideal or switched, not 'perfect'"),
        ("plant.Rs_Ohm=-1", r"expected a number in 0 \.\. "),
        ("plant.theta0_deg=north", "or random, not 'north'"),
        ("phase.nowhere.load_Nm=1", "expected the name of a phase of the scenario"),
        ("phase.start.lod=1", r"\[phase.start\] lod: unknown; expected one of duration_s"),
        ("phase.start.end_mode=stop", "expected off, calibrate, voltage"),
        ("scenario.motor=x.ini", "expected in a scenario file only"),
        ("scenario.seed=-1", "expected a number in 0"),
    ]:
        refused(checks, folder, ["run", "main", "--set", assignment], pattern)
    # Two units for one thing.
    refused(checks, folder, ["run", "main", "--set", "start.handover_rpm=150", "--set",
                             "start.omega_handover_rad_s=50"], "expected one of them")


def estimator_names(checks, folder):
    listed = folder.run("list").stdout
    replay = ["replay", "--motor", MOTOR, "--recording", STEADY]
    for option in BUILT:
        done = refused(checks, folder, [*replay, option, "nonsense"],
                       f"{option}: .*expected .* or .*, not 'nonsense'")
        for name in BUILT[option] + EULER[option]:
            checks.true(name in done.stderr, f"{done.stderr!r} names {name}")
            checks.true(name in listed, f"{name} is in `lodestar list`")
    for names in (BUILT, EULER):
        for emf in names["--emf"]:
            for pll in names["--pll"]:
                checks.equal(folder.run(*replay, "--emf", emf, "--pll", pll).returncode, 0,
                             f"exit code with {emf} and {pll}")
    for emf, pll in [("c-leso", "qpll-euler"), ("c-leso-euler", "qpll")]:
        refused(checks, folder, [*replay, "--emf", emf, "--pll", pll],
                "expected an observer and a PLL that both end in -euler, or neither")
    refused(checks, folder, [*replay, "--emf", "fa-leso", "--set", "estimator.k2_rad_s=20"],
            "k2_rad_s: LODE_ERROR_EMF_PLL: expected k2_rad_s at least 0.549")


def ini_files(checks, folder):
    scenario = (f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n"
                "[phase.a]\nduration_s = 0.01\n")
    for text, pattern in [
        (scenario + "bogus = 1\n", r"s.ini:6: \[phase.a\] bogus: unknown"),
        (scenario + "[motor]\nRs_Ohm = 0,75\n", r"s.ini:7: \[motor\] Rs_Ohm: expected a finite"),
        (scenario + "[motors]\nRs_Ohm = 1\n", r"s.ini:7: \[motors\] Rs_Ohm: unknown"),
        (scenario + "[motor]\nRs_Ohm = 1\nRs_Ohm = 2\n", r"s.ini:8: .*given twice, first in line 7"),
        (scenario + "load_Nm = 1\nload_Nm = 2\n", r"s.ini:7: .*given twice, first in line 6"),
        (scenario + "no equals sign\n", r"s.ini:6: expected `\[section\]`"),
        (scenario + "[phase.b]\nload_Nm = 1\n", r"\[phase.b\] duration_s: missing"),
        (scenario + "[estimator]\nemf = fa-leso\nk2_rad_s = 5\n",
         r"s.ini:8: \[estimator\] k2_rad_s: LODE_ERROR_EMF_PLL"),
        (scenario + "[estimator]\nsigma_rad_s = 900\n",
         r"s.ini:7: \[estimator\] sigma_rad_s: LODE_ERROR_PLL_OBSERVER"),
        (scenario + "# " + 300 * "x" + "\n", r"s.ini:6: expected lines of at most"),
        (scenario + f"[phase.{40 * 'x'}]\nduration_s = 1\n", r"s.ini:7: .*names of 1 to 31"),
        (scenario.replace("duration_s = 0.01", "duration_s = 0"), r"s.ini:5: .*expected a number"),
        (scenario.replace("[phase.a]\nduration_s = 0.01\n", ""), "no .phase.NAME."),
        (scenario.replace(str(MOTOR), "nowhere.ini"), r"s.ini:2: \[scenario\] motor: expected the path"),
        (scenario.replace(f"motor = {MOTOR}\n", ""), r"\[motor\] pole_pairs: missing"),
        (scenario.replace(f"drive = {DRIVE}\n", ""), r"\[drive\] f_pwm_Hz: missing"),
        ("", "missing|no .phase.NAME."),
        (b"\x00\xff\x00\n", "expected"),
    ]:
        path = folder.write("s.ini", text)
        refused(checks, folder, ["run", path], pattern)
    # What counts is the place that said it: here the motor's file, not the scenario.
    folder.write("m.ini", MOTOR.read_text().replace("psi_Wb = 0.142", "psi_Wb = 0"))
    folder.write("s.ini", scenario.replace(str(MOTOR), "m.ini"))
    refused(checks, folder, ["run", "s.ini"], r"m.ini:7: \[motor\] psi_Wb: LODE_ERROR_MOTOR_PSI")
    # Parts hold no scenario.
    folder.write("m.ini", MOTOR.read_text() + "[scenario]\nseed = 1\n")
    refused(checks, folder, ["run", "s.ini"], r"m.ini:\d+: \[scenario\] seed: expected in a scenario")
    refused(checks, folder, ["run", folder.path], "expected an INI file")


def names_of_data(checks, folder):
    """A motor by its name, its path, and the path it had before sim/data/: the same design."""
    said = [folder.run("design", "--motor", name, "--drive", DRIVE, "--json")
            for name in ["jiang2022", "jiang2022.ini", MOTOR, SOURCE / "sim/motors/jiang2022.ini"]]
    checks.equal([done.returncode for done in said], [0, 0, 0, 0], "exit codes")
    checks.equal(len({done.stdout for done in said}), 1, "designs")
    refused(checks, folder, ["design", "--motor", SOURCE / "sim/motors/none.ini", "--drive", DRIVE],
            "sim/motors/none.ini: No such file")


def every_key_is_there(checks, folder):
    """No float field of a configuration of the library without its key."""
    derived = {"omega_rated_rad_s", "i_gain_A_count", "i_offset_count", "count_max",
               "v_bus_gain_V_count", "temperature_gain_degC_count", "temperature_offset_degC",
               "level", "pre_share"}  # the last two are a scope's
    design = folder.run("design", "--motor", MOTOR, "--drive", DRIVE, "--json")
    checks.equal(design.returncode, 0, "exit code of design --json")
    keys = set(re.findall(r'"(\w+)":', design.stdout))
    fields = set()
    for header in sorted((SOURCE / "include/lodestar").glob("*.h")):
        for body in re.findall(r"typedef struct \{([^}]*)\} lode_\w+_config_t;", header.read_text()):
            body = re.sub(r"//.*", "", body)
            fields |= set(re.findall(r"\bfloat\s+(\w+);", body))
    checks.true(len(fields) > 40, f"{len(fields)} fields found in the headers, expected over 40")
    missing = sorted(fields - derived - keys)
    checks.equal(missing, [], "fields of the library's configuration without a key in INI files")
    # Each key is in the rig's README: the tool itself lists them.
    text = (SOURCE / "sim/README.md").read_text()
    for section in ["motor", "drive", "estimator", "current", "references", "speed", "start",
                    "guard", "plant", "scenario", "phase.start"]:
        said = folder.run("run", "main", "--set", f"{section}.unknown=1").stderr
        listed = said.split("expected one of ")[1].strip().split(", ")
        missing = [key for key in listed if not re.search(rf"\b{key}\b", text)]
        checks.equal(missing, [], f"keys of [{section}] that sim/README.md does not name")


def main():
    checks = Checks()
    with Folder() as folder:
        command_line(checks, folder)
        values(checks, folder)
        estimator_names(checks, folder)
        ini_files(checks, folder)
        names_of_data(checks, folder)
        every_key_is_there(checks, folder)
    checks.done()


main()
