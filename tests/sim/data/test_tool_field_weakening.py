"""Field weakening in closed loop: sim/data/scenarios/field_weakening.ini and mtpv.ini, and what they must reach."""
import csv
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import FULL, Checks, Folder

IDEAL = ["plant.inverter=ideal", "drive.dead_time_s=0", "drive.v_drop_V=0", "drive.r_on_Ohm=0"]
RUN = "5"  # lode_mode_t
# Everything from the load on, but for the way through standstill.
WATCHED = ["load", "entry", "high", "high_brake", "exit"]
WATCHED += ["reverse_" + name for name in WATCHED]


def run(folder, scenario, sets, seed=1):
    arguments = [x for s in sets for x in ("--set", s)]
    done = folder.run("run", scenario, "--seed", seed, "--csv", "f.csv", "--json", "f.json", *arguments)
    with open(folder.path / "f.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["mode"] == RUN]
    return done, folder.json("f.json"), rows


def largest(rows, x, y):
    return max(math.hypot(float(row[x]), float(row[y])) for row in rows)


def both_ways(checks, folder, name, sets, seed=1):
    done, result, rows = run(folder, "field_weakening", sets, seed)
    checks.equal(done.returncode, 0, f"{name}: exit code\n{done.stdout}")
    phases = {phase["name"]: phase for phase in result["phases"]}
    if not checks.true(set(WATCHED) <= set(phases), f"{name}: all phases, without a fault"):
        return
    worst = max(phases[phase]["angle_error_max_deg"] for phase in WATCHED)
    checks.at_most(worst, 2, f"{name}: largest angle error, degrees")
    for phase, wanted in [("high", 3883), ("reverse_high", -3883)]:
        checks.at_most(abs(phases[phase]["speed_rpm"]["mean"] - wanted), 5, f"{name}: {phase} off {wanted} rpm")
    asked, flowing = largest(rows, "i1_ref_A", "i2_ref_A"), largest(rows, "i1_A", "i2_A")
    checks.at_most(asked, 16.001, f"{name}: references within 16 A")
    # Transients with the voltage used up: an eighth more, far from the 24 A of the trip. With id0 the seeds from 1 to
    # 12 have 16.9 to 17.7 A.
    checks.at_most(flowing, 18.0, f"{name}: measured current, A")
    print(f"{name}, seed {seed}: largest angle error {worst:.2f} deg, references {asked:.3f} A, "
          f"measured {flowing:.2f} A")


def without_weakening(checks, folder):
    """The same without: the speed is not reached."""
    done, result, _ = run(folder, "field_weakening", ["references.field_weakening=off"])
    fastest = max(abs(phase["speed_rpm"]["mean"]) for phase in result["phases"])
    checks.true(done.returncode != 0 and fastest < 3500, f"without weakening {fastest:.0f} rpm are reached")
    print(f"without weakening: {fastest:.0f} rpm")


def with_mtpv(checks, folder):
    done, result, rows = run(folder, "mtpv", [])
    checks.equal(done.returncode, 0, f"mtpv: exit code\n{done.stdout}")
    checks.at_most(largest(rows, "i1_ref_A", "i2_ref_A"), 300.01, "mtpv: references within 300 A")
    worst = {phase["name"]: phase["angle_error_max_deg"] for phase in result["phases"]}
    print(f"mtpv: largest angle errors {worst}")


def main():
    checks = Checks()
    with Folder() as folder:
        for seed in range(1, 21 if FULL else 4):
            both_ways(checks, folder, "switched, mtpa", [], seed)
        both_ways(checks, folder, "switched, id0", ["references.strategy=id0"])
        both_ways(checks, folder, "ideal, mtpa", IDEAL)
        both_ways(checks, folder, "ideal, id0", IDEAL + ["references.strategy=id0"])
        without_weakening(checks, folder)
        with_mtpv(checks, folder)
    checks.done()


main()
