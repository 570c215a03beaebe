"""usage: LODE_TOOL=... observer_choice.py write | print [GROUP...]

Runs the EMF observers through recordings, scenarios and errors of every motor and prints the tables that say
which one is the best default; write: into docs/observer-choice.md, the groups named or all, and the
comparison of all that stands there. Takes some ten minutes on two cores.
Groups: recordings, scenarios, errors, starts, plls. Every gain is the default.
"""
import concurrent.futures
import math
import os
import pathlib
import re
import statistics
import sys

os.environ.setdefault("LODE_SOURCE_DIR", str(pathlib.Path(__file__).parents[1]))
from support.tool import RECORDINGS, SOURCE, Folder

PAGE = SOURCE / "docs/observer-choice.md"
DATA = SOURCE / "sim/data"
TABLE = (SOURCE / "include/lodestar/observers.def").read_text()
ALL = re.findall(r'^LODE_OBSERVER\(.*"(.*)"', TABLE, re.MULTILINE)
TODAY = ALL[0]
CANDIDATE = "r-leso"
COMPARED = ["c-leso", "fa-leso", "r-leso"]  # in the long tables
SEEDS = [101, 102, 103]
PLL_SEEDS = range(101, 106)
STARTS = range(1001, 1061)
# A figure is better or worse than another one by at least so much, of it and in degrees; below that the
# noise of one run against the next decides.
SHARE, DEGREES = 0.1, 0.05
HEAD = f"[scenario]\nmotor = {DATA}/motors/jiang2022.ini\ndrive = {DATA}/drives/jiang2022.ini\n" \
       f"plant = {DATA}/plants/jiang2022.ini\n"
# duration, rpm, Nm: steps of load at three speeds.
STEPS = [(2.5, 300, 0), (1, 300, 5), (1, 300, -5), (1.5, 900, -5), (1, 900, 5), (1.5, 1500, 5), (1, 1500, 0),
         (1, 1500, -5)]
SCENARIOS = ["main", "steady_ideal", "steady_switched", "steady_correction_off_20", "dynamics", "reversal",
             "field_weakening", "mtpv", "servo", "traction", "drone", "dtp", "dtp_open_phase"]
PLLS = ["leso-qpll", "qpll"]
ERRORS = ["steps", "servo", "traction", "drone"]  # a scenario of each three-phase motor
MOTORS = {"steps": "jiang2022", "servo": "servo_48V", "traction": "traction_400V", "drone": "drone_900KV"}


def value_of(kind, name, key):
    text = (DATA / kind / f"{name}.ini").read_text()
    return float(re.search(rf"^{key} = (\S+)", text, re.MULTILINE).group(1))


def variants(motor):
    """name -> what the machine is and the drive does not know."""
    of = lambda key: value_of("motors", motor, key)
    drive = lambda key: value_of("drives", motor, key)
    noise, dead = 0.01 * drive("i_max_A"), drive("dead_time_s")
    cases = {"no error": {}}
    for name, key, factors in (("Rs", "Rs_Ohm", (0.8, 1.2)), ("Lq", "Lq_H", (0.85, 1.15)),
                               ("psi", "psi_Wb", (0.97, 1.03)), ("J", "J_kgm2", (0.5, 2.0))):
        cases.update({f"{name} x{f}": {f"plant.{key}": f * of(key)} for f in factors})
    cases.update({f"dead time x{f}": {"plant.dead_time_s": f * dead} for f in (0.8, 1.2)})
    cases["noise 1 % of i_max"] = {"plant.i_noise_A": noise}
    cases["offset 1 % of i_max"] = {"plant.i_offset_a_A": noise, "plant.i_offset_b_A": -noise}
    cases["EMF 5th 6 %, 7th 4 %"] = {"plant.emf5_ratio": 0.06, "plant.emf7_ratio": 0.04}
    return cases


def scenario_file(folder, name):
    path = folder.path / "steps.ini"
    if name != "steps":
        return str(DATA / f"scenarios/{name}.ini")
    if path.exists(): # others may be reading it
        return str(path)
    text = "".join(f"[phase.p{n}]\nduration_s = {d}\nspeed_rpm = {rpm}\nload_Nm = {load}\n"
                   for n, (d, rpm, load) in enumerate(STEPS))
    return str(folder.write("steps.ini", HEAD + text))


def measure(folder, job):
    """(largest error after the start, largest mean, largest pp, error in the start, good) of a run."""
    number, name, observer, seed, values = job
    out = f"r{number}.json"
    words = [word for key, value in {**values, "estimator.emf": observer}.items()
             for word in ("--set", f"{key}={value:.6g}" if key != "estimator.emf" else f"{key}={value}")]
    done = folder.run("run", scenario_file(folder, name), "--seed", str(seed), "--json", out, *words)
    if "LODE_ERROR_WEAKENING_ESTIMATOR" in done.stderr:
        return math.nan, math.nan, math.nan, math.nan, True
    if not (folder.path / out).exists():
        sys.exit(f"{name} with {observer}, {values}: {done.stderr}")
    result = folder.json(out)
    (folder.path / out).unlink()
    rows = [row for row in result["phases"]
            if row["angle_error_max_deg"] is not None and row["angle_error_deg"]["mean"] is not None]
    later = rows[1:]
    worst = lambda pick: max((pick(row) for row in later), default=math.nan)
    if result["fault"] is not None and name != "faults":
        return math.inf, math.inf, math.inf, math.inf, False
    return (worst(lambda row: row["angle_error_max_deg"]), worst(lambda row: abs(row["angle_error_deg"]["mean"])),
            worst(lambda row: row["angle_error_deg"]["pp"]), rows[0]["angle_error_max_deg"] if rows else math.nan,
            done.returncode == 0)


def worst_of(results):
    return tuple(max(r[k] for r in results) for k in range(4)) + (all(r[4] for r in results),)


def median_of(results):
    """Medians, and how many runs ended in a fault."""
    return tuple(statistics.median(r[k] for r in results) for k in range(4)) + (
        sum(math.isinf(r[0]) for r in results),)


def run_all(folder, jobs, summary=worst_of):
    """key -> summary over its seeds; `jobs`: (key, scenario, observer, seed, values)."""
    found = {}
    scenario_file(folder, "steps")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        tasks = [(n, *job[1:]) for n, job in enumerate(jobs)]
        for job, result in zip(jobs, pool.map(lambda task: measure(folder, task), tasks)):
            found.setdefault(job[0], []).append(result)
    return {key: summary(results) for key, results in found.items()}


def number(value):
    return "lost" if math.isinf(value) else "-" if math.isnan(value) else f"{value:.3f}" if value < 0.1 else f"{value:.2f}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def recordings(folder):
    rows = []
    for path in sorted(RECORDINGS.glob("*.csv")):
        figures = {}
        for observer in ALL:
            folder.run("replay", "--motor", "jiang2022", "--recording", str(path), "--emf", observer, "--pll",
                       "leso-qpll", "--json", "p.json")
            figures[observer] = folder.json("p.json")["angle_error_max_deg"]
        rows.append([path.stem, *(number(figures[o]) for o in ALL)])
    return "## Recordings\n\nLargest error after 0.2 s; no inverter, no noise.\n\n" + table(["", *ALL], rows)


def scenarios(folder):
    jobs = [((name, observer), name, observer, seed, {}) for name in SCENARIOS for observer in ALL for seed in SEEDS]
    found = run_all(folder, jobs)
    parts = ["## Scenarios\n\nWorst of seeds " + ", ".join(map(str, SEEDS)) +
             ". Bars: whether all phases meet the scenario's.\n"]
    for title, k in (("Largest error after the phase of the start", 0), ("Largest mean of a phase's end", 1),
                     ("Largest peak-to-peak of a phase's end", 2)):
        rows = []
        for name in SCENARIOS:
            figures = {o: found[name, o][k] for o in ALL}
            rows.append([name, *(number(figures[o]) + ("" if k or found[name, o][4] else ", misses bars") for o in ALL)])
        parts.append(f"{title}.\n\n" + table(["", *ALL], rows))
    return "\n".join(parts)


def errors(folder):
    jobs = [((name, case, o), name, o, seed, values) for name in ERRORS
            for case, values in variants(MOTORS[name]).items() for o in COMPARED for seed in SEEDS]
    found = run_all(folder, jobs, median_of)
    parts = ["## Errors of the configuration, noise, offsets, dead time, harmonics\n\nWhat the drive does not know of, "
             f"one at a time. Largest error after the phase of the start, then largest peak-to-peak of a phase's "
             f"end; medians of {len(SEEDS)} seeds. In brackets how many of them ended in a fault.\n"]
    for name in ERRORS:
        rows = []
        for case in variants(MOTORS[name]):
            lost = {o: found[name, case, o][4] for o in COMPARED}
            rows.append([case, *(number(found[name, case, o][0]) + (f" ({lost[o]})" if lost[o] else "")
                                 for o in COMPARED),
                         *(number(found[name, case, o][2]) for o in COMPARED)])
        steps = "300, 900, 1500 rpm, steps of 5 and 10 Nm" if name == "steps" else f"scenario {name}"
        parts.append(f"`{MOTORS[name]}`, {steps}:\n\n" +
                     table(["", *(f"{o}, max" for o in COMPARED), *(f"{o}, pp" for o in COMPARED)], rows))
    return "\n".join(parts)


def starts(folder):
    jobs = [((o, seed), "start", o, seed, {}) for o in COMPARED for seed in STARTS]
    found = run_all(folder, jobs)
    rows = []
    for o in COMPARED:
        peaks = sorted(found[o, seed][3] for seed in STARTS)
        good = sum(found[o, seed][4] for seed in STARTS)
        rows.append([o, f"{good} of {len(peaks)}", *(number(peaks[int(q * (len(peaks) - 1))]) for q in (0.5, 0.9, 1.0))])
    return (f"## Starts\n\nScenario start, seeds {STARTS[0]} .. {STARTS[-1]}: random angle, load, resistance, inductance, offsets. "
            "Error in RUN until the hand-over has settled.\n\n" +
            table(["", "reach 900 rpm", "median", "90 %", "worst"], rows))


def ending(folder, job):
    """How a run ended: "", a fault's name, "bars" or "refused"."""
    name, observer, pll, seed = job
    done = folder.run("run", str(DATA / f"scenarios/{name}.ini"), "--seed", str(seed), "--set",
                      f"estimator.emf={observer}", "--set", f"estimator.pll={pll}")
    fault = re.search(r"^FAULT .*LODE_CHECK_(\w+)", done.stdout, re.MULTILINE)
    if "LODE_ERROR_WEAKENING_ESTIMATOR" in done.stderr:
        return "refused"
    return fault.group(1) if fault else "" if done.returncode == 0 else "bars"


def ended(endings):
    if set(endings) == {"refused"}:
        return "refused"
    bad = [e for e in endings if e]
    return f"{len(bad)} of {len(endings)}: {', '.join(sorted(set(bad)))}" if bad else "passes"


def plls(folder):
    names = [*SCENARIOS, "start", "torque"]
    jobs = [(name, o, pll, seed) for name in names for o in ALL for pll in PLLS for seed in PLL_SEEDS]
    found = {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for job, how in zip(jobs, pool.map(lambda j: ending(folder, j), jobs)):
            found.setdefault(job[:3], []).append(how)
    parts = [f"## Every observer with either PLL\n\nHow many of seeds {PLL_SEEDS[0]} .. {PLL_SEEDS[-1]} miss a bar or "
             "end in a fault, and which; refused: by init, as the theory pages say of [the QPLL](theory/pll.md#qpll) "
             "and [the GI-LESO](theory/emf.md#gi-leso).\n"]
    for pll in PLLS:
        parts.append(f"With {pll}:\n\n" + table(
            ["", *ALL], [[name, *(ended(found[name, o, pll]) for o in ALL)] for name in names]))
    return "\n".join(parts)


def figure(cell):
    """The number of a cell, infinite where the drive was lost in more than half of the runs."""
    match = re.match(r"-?[\d.]+", cell)
    return float(match.group()) if match else math.inf if cell.startswith("lost") else math.nan


def compared(page, other):
    """(where, today's figure, the other's) of every cell of the page's tables."""
    place, columns = "", []
    for line in page.split("## Against")[0].split("## Every observer")[0].splitlines():
        if not line.startswith("|"):
            columns = []
            place = line.strip("#:. ") or place
        elif not columns:
            columns = [cell.strip() for cell in line.strip("|").split("|")]
        elif not line.startswith("|---"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            for kind in ("", ", max", ", pp"):
                if TODAY + kind in columns and other + kind in columns:
                    pair = [figure(cells[columns.index(o + kind)]) for o in (TODAY, other)]
                    yield f"{place.split(',')[0].split(';')[0]}: {cells[0]}{kind}", *pair


def verdict(page):
    rows, lists = [], []
    for other in ALL[1:]:
        better, worse = [], []
        for where, base, value in compared(page, other):
            clear = max(SHARE * min(base, value), DEGREES)
            if value < base - clear or (math.isinf(base) and not math.isinf(value)):
                better.append([where, number(base), number(value)])
            elif value > base + clear or (math.isinf(value) and not math.isinf(base)):
                worse.append([where, number(base), number(value)])
        rows.append([other, str(len(better)), str(len(worse))])
        if other == CANDIDATE:
            for title, cases in (("better", better), ("worse", worse)):
                lists.append(f"Where {other} is {title}:\n\n" +
                             (table(["", TODAY, other], cases) if cases else "nowhere.\n"))
    head = (f"## Against {TODAY}\n\nFigures above that are smaller or larger by at least {SHARE:.0%} and "
            f"{DEGREES} degrees; gi-leso and fa-multi are in recordings and scenarios only.\n")
    return "\n".join([head, table(["", "better", "worse"], rows), *lists])


GROUPS = {"recordings": recordings, "scenarios": scenarios, "errors": errors, "starts": starts, "plls": plls}


def put(page, section):
    """The page with this section, by its heading: anew, or before the verdict."""
    heading = section.split("\n", 1)[0]
    parts = re.split(r"^(?=## )", page.split("## Against")[0], flags=re.MULTILINE)
    for k, part in enumerate(parts):
        if part.startswith(heading + "\n"):
            parts[k] = section.rstrip() + "\n\n"
            return "".join(parts)
    return "".join(parts).rstrip() + "\n\n" + section.rstrip() + "\n\n"


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in ("write", "print") or not set(sys.argv[2:]) <= set(GROUPS):
        sys.exit(__doc__)
    page = PAGE.read_text() if PAGE.exists() else "# Which EMF observer is the default\n"
    with Folder() as folder:
        for name in sys.argv[2:] or GROUPS:
            section = GROUPS[name](folder)
            page = put(page, section)
            print(section, flush=True)
    page += verdict(page)
    print(verdict(page))
    if sys.argv[1] == "write":
        PAGE.write_text(page)


main()
