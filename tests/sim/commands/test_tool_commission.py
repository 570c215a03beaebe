"""lodestar commission: every three-phase machine of the catalogue within its bars, files, and refusals."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import SOURCE, Checks, Folder, refused

# Of the value, exact sensors, free shaft.
BARS = {"Rs_Ohm": 0.02, "dead_V": 0.05, "Ld_H": 0.05, "Lq_H": 0.05, "psi_Wb": 0.01, "J_kgm2": 0.10}
NAMES = ["offset_a_count", "offset_b_count", "offset_c_count", "signals", "Rs_Ohm", "dead_V", "Ld_H",
         "Lq_H", "psi_Wb", "J_kgm2", "B_Nms"]
DATA = SOURCE / "sim" / "data"


def values(*files):
    """{key: number} of INI files, the last one's where there are several."""
    found = {}
    for path in files:
        for line in path.read_text().splitlines():
            key, equal, value = line.partition("=")
            if equal:
                found[key.strip()] = value.strip()
    return found


def truth_of(table):
    """{name: value of the plant} of the table."""
    rows = [line.split() for line in table.splitlines()]
    return {row[0]: float(row[3]) for row in rows if len(row) == 5 and row[0] in NAMES}


def catalogue(checks, folder):
    machines = 0
    for motor in sorted((DATA / "motors").glob("*.ini")):
        name = motor.stem
        if not (DATA / "drives" / motor.name).is_file():
            continue
        arguments = ["commission", "--motor", name, "--drive", name]
        if float(values(motor).get("sets", 1.0)) > 1.0:
            refused(checks, folder, arguments, r"commission: expected a motor with three phases")
            continue
        machines += 1
        done = folder.run(*arguments, "--set", "plant.theta0_deg=130", "--json", "out.json")
        if not checks.equal(done.returncode, 0, f"{name}: {done.stdout[-200:]}{done.stderr}"):
            continue
        found, truth = folder.json("out.json"), truth_of(done.stdout)
        checks.equal(list(found), NAMES, f"{name}: names")
        for key, bar in BARS.items():
            off = abs(found[key]["value"] / truth[key] - 1.0)
            checks.at_most(off, bar, f"{name}: {key} {found[key]['value']} of {truth[key]}")
            checks.true(found[key]["confidence"] >= 0.5, f"{name}: confidence of {key}")
        took = float(done.stdout.split("DONE after ")[1].split()[0])
        checks.at_most(took, 10.0, f"{name}: seconds")
        largest, limit = done.stdout.split("largest current ")[1].split()[0::3][:2]
        checks.at_most(float(largest), float(limit), f"{name}: largest current, A")
    checks.true(machines >= 12, f"{machines} machines")


def files_and_refusals(checks, folder):
    done = folder.run("commission", "--out", "found.ini", "--json", "found.json")
    checks.equal(done.returncode, 0, "the main job's scenario: " + done.stderr)
    found = folder.json("found.json")
    written = values(pathlib.Path(folder.path, "found.ini"))
    checks.at_most(abs(float(written["psi_Wb"]) - found["psi_Wb"]["value"]), 1e-6, "motor file")
    again = folder.run("run", "--motor", "found.ini", "--drive", DATA / "drives" / "jiang2022.ini")
    checks.equal(again.returncode, 0, "a run with the motor file: " + again.stderr)
    before = folder.names()
    held = folder.run("commission", "--set", "plant.load_kind=passive", "--set", "plant.stiction_Nm=1000",
                      "--out", "none.ini")
    checks.equal(held.returncode, 1, "a shaft that is held")
    checks.true("while looking for psi_Wb" in held.stdout, held.stdout[-300:])
    checks.equal(folder.names(), before, "nothing is written of what is not whole")
    refused(checks, folder, ["commission", "main", "--motor", "jiang2022"],
            r"commission: expected a scenario or --motor, not both")
    refused(checks, folder, ["commission", "--drive", "jiang2022"],
            r"commission: expected --motor F.ini")
    refused(checks, folder, ["commission", "--motor", "none.ini"], r"none.ini: No such file")


def main():
    checks = Checks()
    with Folder() as folder:
        catalogue(checks, folder)
        files_and_refusals(checks, folder)
    checks.done()


main()
