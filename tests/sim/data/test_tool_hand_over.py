"""From the start's current vector to the estimator: how far the motor's torque falls below its load. Prints its table.

Every motor of the catalogue starts from random angles under a passive load, with the switched inverter. What counts
is the true torque of the plant for WINDOW_s from the hand-over on: the start current fades for 0.1 s at most by
default, and whatever answers to that has as long again. A mean over FILTER_s takes away what the ADC's noise
does to it: a fiftieth of the shortest fade by default.
"""
import concurrent.futures
import csv
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import FULL, SOURCE, Checks, Folder

DATA = SOURCE / "sim/data"
LOAD = 0.4  # of the torque of i_max/1.5 with id = 0
SPEED = 1.5  # over the least one, so that speed control has somewhere to go
WINDOW_s = 0.2
FILTER_s = 1e-3
ROW_s = 2e-4
DIP = 0.2  # of the load, at most
SEEDS = range(1, 9 if FULL else 4)


def scenario(motor, designed, seed, duration_s, log_s):
    verdict, drive = designed["verdict"], designed["config"]["drive"]
    noise_A = drive["i_range_A"] / 2 ** drive["adc_bits"]  # half a count, as in monte-carlo: without any it is stuck
    return (f"[scenario]\nmotor = {DATA}/motors/{motor}.ini\ndrive = {DATA}/drives/{motor}.ini\n"
            f"seed = {seed}\nlog_s = {log_s}\n[hfi]\nmode = off\n"  # the vector starts reluctance machines, too
            "[plant]\ninverter = switched\nload_kind = passive\ntheta0_deg = random\n"
            f"i_noise_A = {noise_A}\n"
            f"[phase.start]\nduration_s = {duration_s}\nload_Nm = {LOAD * verdict['rated_torque_Nm']}\n"
            f"speed_rpm = {SPEED * verdict['lowest_rpm']}\n")


def torques(path, handover_s):
    """Mean torques that end in the window before the hand-over, and after it."""
    with open(path, newline="", encoding="utf-8") as file:
        header = next(csv.reader([file.readline()]))
        time, torque = header.index("t_s"), header.index("torque_Nm")
        rows = [(float(cell[time]), float(cell[torque])) for cell in (line.split(",") for line in file)
                if float(cell[time]) > handover_s - WINDOW_s - FILTER_s]
    n = max(1, round(FILTER_s / (rows[1][0] - rows[0][0])))
    means = [(rows[k][0], sum(row[1] for row in rows[k + 1 - n:k + 1]) / n) for k in range(n - 1, len(rows))]
    return ([mean for t, mean in means if handover_s - WINDOW_s <= t < handover_s],
            [mean for t, mean in means if handover_s <= t <= handover_s + WINDOW_s])


def hand_over(folder, motor, designed, seed):
    """Least torque after the hand-over over the load; and as long before it, and when; None: there was none."""
    name = f"{motor}-{seed}"
    folder.write(f"{name}.ini", scenario(motor, designed, seed, designed["config"]["start"]["timeout_s"] + 1, 1))
    folder.run("run", f"{name}.ini", "--json", f"{name}.json")
    at_s = folder.json(f"{name}.json")["handover_s"]
    if at_s is None:
        return None
    folder.write(f"{name}.ini", scenario(motor, designed, seed, at_s + 1.1 * WINDOW_s, ROW_s))
    folder.run("run", f"{name}.ini", "--csv", f"{name}.csv")
    before, after = torques(folder.path / f"{name}.csv", at_s)
    (folder.path / f"{name}.csv").unlink()
    load_Nm = LOAD * designed["verdict"]["rated_torque_Nm"]
    return at_s, min(before) / load_Nm, min(after) / load_Nm


def one_motor(folder, motor):
    folder.run("design", "--motor", motor, "--drive", motor, "--set", "hfi.mode=off", f"--json={motor}.json")
    designed = folder.json(f"{motor}.json")
    return designed["usable_emf"], [hand_over(folder, motor, designed, seed) for seed in SEEDS]


def catalogue(checks, folder):
    motors = sorted({path.stem for path in (DATA / "motors").glob("*.ini")} &
                    {path.stem for path in (DATA / "drives").glob("*.ini")})
    checks.true(len(motors) >= 15, f"motors of the catalogue: {motors}")
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda motor: one_motor(folder, motor), motors))
    print(f"least torque in {WINDOW_s} s before and after the hand-over, over the load; worst of {len(SEEDS)} starts")
    for motor, (usable, starts) in zip(motors, found):
        done = [start for start in starts if start is not None]
        least = [min((start[k] for start in done), default=float("nan")) for k in (1, 2)]
        note = "" if usable else "  no usable EMF: not held to the bar"
        print(f"{motor:20} before {least[0]:6.2f} after {least[1]:6.2f}  {len(done)} of {len(starts)} handed over{note}")
        if usable:
            checks.equal(len(done), len(starts), f"{motor}: hand-overs")
            checks.at_most(1 - least[1], DIP, f"{motor}: dip of the torque")


with Folder() as place:
    tally = Checks()
    catalogue(tally, place)
    tally.done()
