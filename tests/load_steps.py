"""usage: LODE_TOOL=... load_steps.py write | print

The largest load step from no load that simulated drives of the catalogue survive, beside what `design` says (K18), each
with the values it was told; write: into docs/theory/control.md. Takes a minute on two cores.
Survived: after 1.9 s three seeds still run, and within 5 % of the speed. A step is found to 1 % of the
torque of i_max/1.5.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import sys

os.environ.setdefault("LODE_SOURCE_DIR", str(pathlib.Path(__file__).parents[1]))
from support.tool import SOURCE, Folder

PAGE = SOURCE / "docs/theory/control.md"
DATA = SOURCE / "sim/data"
MOTORS = ["jiang2022", "servo_48V", "compressor_310V", "ebike_hub", "fan_325V", "servo_3kW", "pmsyrm_5kW",
          "traction_400V", "flat_30W", "drone_900KV"]
SEEDS = ["1", "2", "3"]
HEAD = "| motor | hand-over: (K18) | survived | base speed: (K18) | survived |\n|---|---|---|---|---|\n"
MOST = 3.0  # of that torque: beyond what any of them has


def survives(folder, motor, rpm, load_Nm):
    plant = DATA / "plants" / f"{motor}.ini"
    folder.write("step.ini", f"[scenario]\nmotor = {DATA}/motors/{motor}.ini\ndrive = {DATA}/drives/{motor}.ini\n"
                 + (f"plant = {plant}\n" if plant.exists() else "")
                 + "[plant]\ninverter = switched\nload_kind = signed\nload_ripple = 0\n"
                 f"[phase.start]\nduration_s = 20\nspeed_rpm = {rpm}\n[phase.step]\nduration_s = 1.9\n"
                 f"load_Nm = {load_Nm}\nbar_speed_rpm = {0.05 * rpm}\nend_mode = run\n")
    return all(folder.run("run", "step.ini", "--seed", seed).returncode == 0 for seed in SEEDS)


def most(folder, motor, step, rated_Nm):
    """In shares of the torque."""
    low, high = 0.0, MOST
    while high - low > 0.01:
        share = 0.5 * (low + high)
        low, high = (share, high) if survives(folder, motor, 1.005 * step["speed_rpm"], share * rated_Nm) else (low, share)
    return low


def row(motor):
    with Folder() as folder:
        found = json.loads(folder.run("design", "--motor", motor, "--drive", motor, "--json").stdout)["verdict"]
        cells = [motor]
        for step in (found["step_at_handover"], found["step_at_base"]):
            cells += [f"{step['share']:.2f}", f"{most(folder, motor, step, found['rated_torque_Nm']):.2f}"]
    return "| `{}` | {} | {} | {} | {} |\n".format(*cells)


def main():
    if sys.argv[1:] not in (["write"], ["print"]):
        sys.exit(__doc__)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        table = HEAD + "".join(pool.map(row, MOTORS))
    if sys.argv[1] == "print":
        print(table, end="")
        return
    text = PAGE.read_text()
    text, tables = re.subn(re.escape(HEAD) + r"(\|.*\n)+", lambda _: table, text)
    if tables != 1:
        sys.exit(f"{PAGE}: {tables} tables begin with {HEAD.splitlines()[0]}; expected one")
    PAGE.write_text(text)
    print(f"written: {PAGE}")


main()
