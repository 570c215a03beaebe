"""usage: figures.py write TOOL | render | check

The figures of README.md between the marks <!-- figures --> and <!-- /figures -->, and the bytes of a type
in docs/ between <!-- size TYPE, BUILD --> and <!-- /size -->, with a type and a build of docs/budget.json.
write: runs the commands of the table with the host tool TOOL, notes what they gave in docs/figures.json
and writes the lines anew from that and from docs/budget.json, and docs/papers.md from the same runs. Takes
some minutes. How many times real time the tool runs depends on what else the machine does: run it where
nothing else does.
render: the lines and sizes anew from the two files as they are; nothing is run.
check: the lines and sizes are those that the two files give; nothing is run.
"""
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import papers_page

ROOT = pathlib.Path(__file__).resolve().parents[2]
FIGURES = ROOT / "docs/figures.json"
BUDGET = ROOT / "docs/budget.json"
PAGE = ROOT / "README.md"
BEGIN, END = "<!-- figures -->", "<!-- /figures -->"
SIZE = re.compile(r"(<!-- size (\w+), ([\w ]+) -->)(\d+)(?=<!-- /size -->)")

# Names as the table spells them; the built-in kinds of estimator that are not the default have a column.
EMF = {"c-leso": "C-LESO", "gi-leso": "GI-LESO", "fa-leso": "FA-LESO", "fa-multi": "FA multi",
       "r-leso": "R-LESO"}
PLL = {"leso-qpll": "LESO-QPLL", "qpll": "QPLL"}
SCENARIOS = ["main", "steady_switched", "dynamics", "reversal", "steady_correction_off_20",
             "steady_ideal", "drone", "servo", "traction", "field_weakening", "mtpv", "dtp",
             "dtp_open_phase", "dtp_open_phase_300", "dtp_correction", "start"]
SHARES = (0.7, 0.8, 1.0, 1.1, 1.2)  # of the right correction of dead time and drops
REMEDY = "`python3 tests/tools/figures.py render` writes it"
PAPERS = ("jiang2022", "li-fa-leso")
CATALOGUE = {"start": ("start",), "narrow": ("run",), "wide": ("run", "--errors", "wide")}  # campaigns on all machines
CATALOGUE_N = 40  # runs of each
SPEED_RUNS = 3  # the best of so many: what disturbs only slows down


class Tool:
    """Runs the host tool, each command once."""

    def __init__(self, path):
        self.path = os.path.abspath(path)
        self.done = {}

    def json_of(self, *arguments):
        if arguments not in self.done:
            with tempfile.TemporaryDirectory() as folder:
                out = pathlib.Path(folder, "out.json")
                print("+ sim/run", *arguments, flush=True)
                run = subprocess.run([self.path, *arguments, "--json", str(out)], cwd=ROOT,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                if run.returncode not in (0, 1):  # 1: a bar is missed, which is a figure too
                    sys.exit(f"figures: ended with code {run.returncode}: {run.stderr}")
                self.done[arguments] = json.loads(out.read_text())
        return self.done[arguments]

    def scenario(self, name, *settings):
        options = [word for setting in settings for word in ("--set", setting)]
        return self.json_of("run", name, *options)


def phases(run, *names):
    """Those named; without names those under load."""
    found = [p for p in run["phases"] if (p["name"] in names if names else p["load_Nm"] != 0)]
    if not found or len(found) < len(names):
        sys.exit(f"figures: {run['scenario']}: expected the phases {' '.join(names)}")
    return found


def worst(run, *names):
    """Mean, peak to peak and largest error of the phases, whichever is worst."""
    of = phases(run, *names)
    return {"mean": max(abs(p["angle_error_deg"]["mean"]) for p in of),
            "pp": max(p["angle_error_deg"]["pp"] for p in of),
            "max": max(p["angle_error_max_deg"] for p in of)}


def main_job(tool):
    run = tool.scenario("main")
    driven = [p for p in run["phases"] if p["mode"] == "RUN"]
    peak = max(driven, key=lambda p: p["angle_error_max_deg"])
    return {"passed": run["passed"], "max": peak["angle_error_max_deg"], "phase": peak["name"]}


def idling(tool):
    """Without load at 300, 600 and 1500 rpm."""
    dynamics, reversal = tool.scenario("dynamics"), tool.scenario("reversal")
    return [worst(dynamics, "start", "ramp_down"), worst(reversal, "forward", "backward"),
            worst(dynamics, "ramp_up", "load_off")]


def found_open_s(run):
    times = {event["text"].split(":")[0]: event["t_s"] for event in run["events"]}
    return times["found open by the drive"] - next(
        t for text, t in times.items() if text.endswith(" is open"))


def open_phases(tool, name):
    """The worst of the six phases, each broken in a run of its own."""
    runs = [tool.scenario(name, f"phase.broken.open_phase={letter}{number}") for number in (1, 2) for letter in "abc"]
    return {"found_s": max(map(found_open_s, runs)), "max": max(worst(run, "broken")["max"] for run in runs)}


def six_correction(tool, share, seeds=5):
    """What a correction of dead time and drops that is `share` of the right one makes of starts and of 5 Nm at once."""
    runs = [tool.scenario("dtp_correction", f"scenario.seed={seed}", f"drive.dead_time_s={2e-6 * share:g}",
                          f"drive.v_drop_V={share:g}") for seed in range(1, seeds + 1)]
    ended = [{p["name"]: p for p in run["phases"]} for run in runs]
    held = [p["least_load"] for p in ended if p.get("least_load", {}).get("mode") == "RUN"]
    return {"starts": seeds, "started": sum("least_load" in p for p in ended), "held": len(held),
            "max": max((p["angle_error_max_deg"] for p in held), default=None)}


def fa_leso(run):
    """Worst mean error of paper 2's FA-LESO at 300, 600 and 840 rpm."""
    rows = {row["id"]: row for row in run["rows"]}
    speeds = ("300", "600", "840")
    free = [rows[f"fig1{n}_fa_{rpm}_mean"] for n, rpm in enumerate(speeds)]
    loaded = [rows[f"load80_fa_{rpm}_mean"] for rpm in speeds]
    return {"ideal": max(abs(row["exact"]) for row in free),
            "free": max(abs(row["corrected"]) for row in free),
            "loaded": max(abs(row["corrected"]) for row in loaded)}


def replays(tool):
    worst_deg = 0.0
    recordings = sorted((ROOT / "tests/recordings").glob("*.csv"))
    for recording in recordings:
        for pll in PLL:
            run = tool.json_of("replay", "--motor", "jiang2022", "--recording",
                               str(recording.relative_to(ROOT)), "--pll", pll)
            worst_deg = max(worst_deg, abs(run["angle_error_mean_deg"]))
    return {"count": len(recordings), "mean": worst_deg}


def campaign(tool, name, last):
    run = tool.json_of("run", name, "--seeds", f"1-{last}")
    return {"cases": run["cases"], "passed": run["passed"]}


def catalogue(tool, campaign_of):
    rows = tool.json_of("monte-carlo", *campaign_of, "--n", str(CATALOGUE_N))["rows"]
    return {"machines": len({row["motor"] for row in rows}), "cases": len(rows),
            "passed": sum(row["result"] == "pass" for row in rows),
            "silent": sum(row["cause"].startswith("silent") for row in rows)}


def speeds(tool):
    print(f"load of the machine before: {os.getloadavg()[0]:.1f}")
    best = {}
    for name in SCENARIOS:
        for _ in range(SPEED_RUNS):
            tool.done.pop(("run", name), None)
            best[name] = max(best.get(name, 0.0), tool.scenario(name)["times_real_time"])
    return {name: round(value, 1) for name, value in best.items()}


def measure(tool):
    f = {"times_real_time": speeds(tool), "main": main_job(tool)}
    chosen = tool.scenario("steady_switched")["config"]["estimator"]
    f["emf"], f["pll"] = chosen["emf"], chosen["pll"]
    f["switched"] = worst(tool.scenario("steady_switched"))
    kinds = [f"emf={k}" for k in EMF if k != f["emf"]] + [f"pll={k}" for k in PLL if k != f["pll"]]
    f["kinds"] = {k: worst(tool.scenario("steady_switched", f"estimator.{k}")) for k in kinds}
    f["idling"] = idling(tool)
    off_20 = tool.scenario("steady_correction_off_20")
    f["off_20"], f["off_20_start"] = worst(off_20), worst(off_20, "start")
    f["ideal"] = worst(tool.scenario("steady_ideal"))
    f["dynamics"] = worst(tool.scenario("dynamics"), "ramp_up", "load_on", "load_off", "ramp_down")
    bare = tool.scenario("steady_ideal", "estimator.pll=qpll", "estimator.compensation=none")
    f["bare"] = {name: phases(bare, name)[0]["angle_error_deg"]["mean"] for name in ("300", "1500")}
    f["machines"] = {name: worst(tool.scenario(name)) for name in ("drone", "servo", "traction")}
    for paper in PAPERS:
        f[paper] = papers_page.count(tool.json_of("reproduce", paper))
    f["fa_leso"] = fa_leso(tool.json_of("reproduce", "li-fa-leso"))
    f["replays"] = replays(tool)
    weak = tool.scenario("field_weakening")
    f["weakening"] = worst(weak, *[before + name for name in ("entry", "high", "high_brake", "exit")
                                   for before in ("", "reverse_")])
    f["weakening_high"] = worst(weak, "high", "high_brake", "reverse_high", "reverse_high_brake")
    f["weakening_start"] = worst(weak, "start", "reverse")
    six = tool.scenario("dtp")
    f["six"] = worst(six, "ramp", "rated_load", "braking", "unloaded", "weakening", "weak_load",
                     "weak_unloaded", "back")
    f["six_weakening"] = worst(six, "weakening", "weak_load", "weak_unloaded", "back")
    f["six_braking"], f["six_start"] = worst(six, "braking"), worst(six, "start")
    f["open"], f["open_300"] = open_phases(tool, "dtp_open_phase"), open_phases(tool, "dtp_open_phase_300")
    f["six_correction"] = {str(share): six_correction(tool, share) for share in SHARES}
    f["starts"] = campaign(tool, "start", 220)
    f["starts_100"] = campaign(tool, "start_100rpm", 200)
    f["catalogue"] = {name: catalogue(tool, campaign_of) for name, campaign_of in CATALOGUE.items()}
    return f


def up(value, digits):
    """Rounded away from zero: "at most"."""
    return f"{math.ceil(round(value * 10**digits, 6)) / 10**digits:.{digits}f}"


def corrections(shares):
    """Of each share in turn; one figure where all have the same."""
    def each(what):
        figures = [str(of[what]) for of in shares]
        return figures[0] if len(set(figures)) == 1 else ", ".join(figures)
    text = f"{each('started')} of {each('starts')} start"
    held = [of for of in shares if of["started"] > 0 and of["held"]]
    if held:
        text += f", {each('held')} hold the load, at most {up(max(of['max'] for of in held), 1)} off"
    return text


def of_catalogue(f):
    """What the campaigns on all machines gave."""
    start, narrow, wide = (f["catalogue"][name] for name in CATALOGUE)
    quiet = sum(of["silent"] for of in f["catalogue"].values())
    passed = ", ".join(f"{of['passed']} of {of['cases']}" for of in (start, narrow, wide))
    return (f"{start['machines']} machines, 10 W to 100 kW, all gains by default; what the drive is told of them is wrong at random. "
            "Starts with $R$ 0.7 to 1.5 times, $L$ ±20 %, $\\psi$ ±10 %, dead time ±1 µs, $J$ 0.3 to 10 times; load steps, slams and "
            "reversals with ±15, 10, 5 % and $J$ 0.5 to 2 times; the same with twice as much",
            f"{passed} pass, {quiet or 'none'} of the others without a fault ([more](docs/evidence.md#wrong-parameters))",
            f"`sim/run monte-carlo start --n {CATALOGUE_N}`, `run`, `run --errors wide`")


def table_rows(f):
    kinds = list(f["kinds"])
    names = {f"emf={k}": v for k, v in EMF.items()} | {f"pll={k}": v for k, v in PLL.items()}
    kind_mean = up(max(f["kinds"][k]["mean"] for k in kinds), 2)
    kind_pp = " / ".join(up(f["kinds"][k]["pp"], 2) for k in kinds)
    idle = [", ".join(f"{of[what]:.1f}" for of in f["idling"]) for what in ("mean", "pp")]
    machines = f["machines"].values()
    jiang, li, fa = f["jiang2022"], f["li-fa-leso"], f["fa_leso"]
    return [
        ("Main job, switched", f"{'all bars met' if f['main']['passed'] else 'bars missed'}; error "
         f"in RUN at most {up(f['main']['max'], 1)}, in its phase {f['main']['phase']}", "`sim/run`"),
        of_catalogue(f),
        ("600, 900, 1500 rpm, ±5 Nm, switched", f"mean at most {up(f['switched']['mean'], 2)}, pp at "
         f"most {up(f['switched']['pp'], 2)}", "`sim/run run steady_switched`"),
        (f"the same with {' / '.join(names[k] for k in kinds)}",
         f"mean at most {kind_mean}; pp at most {kind_pp}",
         "`... --set " + "`, `--set ".join(f"estimator.{k}" for k in kinds) + "`"),
        ("no load, switched: 300, 600, 1500 rpm", f"mean {idle[0]}; pp {idle[1]} (at 600 rpm all three "
         "currents are in the dead band)", "`sim/run run dynamics`, `sim/run run reversal`"),
        ("600 .. 1500 rpm, ±5 Nm, correction 20 % too small", f"mean at most "
         f"{up(f['off_20']['mean'], 2)}, pp at most {up(f['off_20']['pp'], 2)}; at 300 rpm without load "
         f"{f['off_20_start']['mean']:.1f} and {f['off_20_start']['pp']:.1f}",
         "`sim/run run steady_correction_off_20`"),
        ("100 .. 1500 rpm, 5 Nm, ideal inverter", f"mean at most {up(f['ideal']['mean'], 3)}",
         "`sim/run run steady_ideal`"),
        ("±2000 rpm/s, and ±5 Nm at once at 1500 rpm, switched", f"at most {up(f['dynamics']['max'], 1)}",
         "`sim/run run dynamics`"),
        ("no compensation of the lag, QPLL, ideal inverter: misses the bars of the scenario", f"mean {f['bare']['300']:.1f} at 300, "
         f"{f['bare']['1500']:.1f} at 1500 rpm", "`sim/run run steady_ideal --set estimator.pll=qpll "
         "--set estimator.compensation=none`"),
        ("three other machines by default gains (drone, 48 V servo, 400 V traction), load steps",
         f"mean at most {up(max(m['mean'] for m in machines), 2)}, pp at most "
         f"{up(max(m['pp'] for m in machines), 1)} under load", "`sim/run run drone`, `servo`, `traction`"),
        ("paper 1 figure by figure, over what it leaves open", papers_page.count_text(jiang) +
         ", each with its [reason](docs/papers.md)", "`sim/run reproduce jiang2022`"),
        ("paper 2 figure by figure, on a stand-in for its motor", papers_page.count_text(li) + ". FA-LESO at "
         f"300, 600, 840 rpm: mean {fa['ideal']:.2f} with an ideal inverter; with 2 µs of dead time, corrected, at "
         f"most {fa['free']:.1f} without load and {fa['loaded']:.1f} with 80 %",
         "`sim/run reproduce li-fa-leso`"),
        (f"{f['replays']['count']} recordings of another simulator, either PLL", "mean of the last 0.1 s "
         f"at most {up(f['replays']['mean'], 3)}",
         "`sim/run replay --motor jiang2022 --recording tests/recordings/F.csv --pll qpll`"),
        ("field weakening to 1.5 times the speed of the voltage (3883 rpm), 16 A, ±1 Nm, both ways, MTPA, "
         "switched", f"at most {up(f['weakening']['max'], 1)} from entry to exit, steady mean at most "
         f"{up(f['weakening_high']['mean'], 2)}; {up(f['weakening_start']['max'], 1)} for some 10 ms after "
         "the hand-over of the start and of the reversal", "`sim/run run field_weakening`"),
        ("six phases, stand-in motor, 300 V, 10 kHz, 2 µs, switched: 1200 rpm, ±6.25 Nm; field weakening to "
         "2841 rpm and back", f"mean at most {up(f['six']['mean'], 1)}; at most "
         f"{up(f['six_weakening']['max'], 1)} on the way in and out, {up(f['six_braking']['max'], 1)} in a "
         f"step from 6.25 to -6.25 Nm, {up(f['six_start']['max'], 1)} after the hand-over from the start",
         "`sim/run run dtp`, [picture](docs/images/dtp.svg)"),
        ("six phases, one broken at 600, 300 rpm under half load: the worst of the six",
         f"found in at most {1e3 * f['open']['found_s']:.0f}, {1e3 * f['open_300']['found_s']:.0f} ms, angle at most "
         f"{up(f['open']['max'], 1)}, {up(f['open_300']['max'], 1)} off, the other set carries on",
         "`sim/run run dtp_open_phase`, `dtp_open_phase_300` with `--set phase.broken.open_phase=a1` .. `c2`, "
         "[picture](docs/images/dtp_open_phase.svg)"),
        ("six phases, dead time and drops corrected by " + ", ".join(f"{100 * float(k):.0f}" for k in f["six_correction"]) +
         " % of the right figure: 5 starts each, then 5 Nm at once at the least speed, "
         "402 rpm",
         corrections(list(f["six_correction"].values())),
         "`sim/run run dtp_correction --set drive.dead_time_s=2.4e-6 --set drive.v_drop_V=1.2`"),
        (f"{f['starts']['cases']} starts: random angle, load 0 .. 2 Nm, $R$ ±20 %, $L_q$ ±15 %, noise, "
         "offset", f"{f['starts']['passed']} reach 900 rpm",
         f"`sim/run run start --seeds 1-{f['starts']['cases']}`"),
        ("the same with paper 1's hand-over at 100 rpm", f"{f['starts_100']['passed']} of "
         f"{f['starts_100']['cases']}",
         f"`sim/run run start_100rpm --seeds 1-{f['starts_100']['cases']}`"),
    ]


def cost(budget):
    """What a step costs, from the counts of tests/run bench."""
    steps, six = budget["steps"], budget["steps6"]
    words = [steps["c_leso_qpll"][what]["avg"] for what in ("instructions", "cycles")]
    notch = [steps["enhanced"][what]["avg"] for what in ("instructions", "cycles")]
    six_cycles = [six[name]["cycles"]["avg"] for name in ("c_leso_qpll", "enhanced")]
    ram, least_ram = budget["objects"]["all observers"], budget["objects"]["one observer"]
    at_170 = 100 * 20e3 / 170e6  # a share of a period of 20 kHz at 170 MHz, per cycle
    entry = 24  # of the interrupt, and its exit: as in tests/bench/budget.py
    costliest = max(steps[name]["cycles"]["max"] for name in ("board_enhanced", "rise", "start", "saturated", "fault"))
    flash = [budget["firmware"][f"m4f {name}"]["text"] / 1e3 for name in ("-O2", "-O2, tuning in flash", "-Os, least")]
    more_flash = budget["firmware"]["m4f -O2, all observers"]["text"] / 1e3 - flash[0]
    return (f"**Does it fit?** At 20 kHz a Cortex-M4F of 170 MHz is busy with the drive for "
            f"{at_170 * (steps['board_enhanced']['cycles']['avg'] + entry):.0f} % of the time; its costliest call takes "
            f"{at_170 * (costliest + entry):.0f} % of a period. Flash, with one EMF observer: {flash[0]:.0f} kB with "
            f"design and checks, {flash[1]:.0f} kB on a tuning made on the PC, {flash[2]:.0f} kB at the least; all "
            f"observers take {more_flash:.0f} kB more. Other cores and rates: "
            f"[docs/budget.md](docs/budget.md#does-it-fit). All of it is modelled, nothing measured on a chip.\n\n"
            f"The whole step costs a Cortex-M4F some {words[0]:.0f} (C-LESO, QPLL) to {notch[0]:.0f} "
            f"instructions (with the notch), {words[1]:.0f} to {notch[1]:.0f} cycles by the timing tables; "
            f"with six phases {six_cycles[0]:.0f} to {six_cycles[1]:.0f} cycles. RAM: "
            f"{ram['lode_drive_t']} bytes of state and {ram['lode_drive_tuning_t']} of tuning, "
            f"{ram['lode_drive_t'] + ram['lode_drive_tuning_t']} in all as in the example above, built with all EMF "
            f"observers; with six phases {ram['lode_drive6_t']} and {ram['lode_drive6_tuning_t']}. With one observer "
            f"alone: {least_ram['lode_drive_t']} and {least_ram['lode_drive_tuning_t']}, six phases "
            f"{least_ram['lode_drive6_t']} and {least_ram['lode_drive6_tuning_t']}. The tuning may "
            "lie in flash instead (`sim/run design --c`). [docs/budget.md](docs/budget.md#flash-and-ram), "
            "`tests/run bench`.")


def pace(f):
    times = f["times_real_time"]
    slow, fast = min(times, key=times.get), max(times, key=times.get)
    return (f"These scenarios run at {times[slow]:.0f} (`{slow}`) to {times[fast]:.0f} (`{fast}`) times "
            f"real time, the main job at {times['main']:.0f}: simulated time over processor time of one core, the "
            f"best of {SPEED_RUNS} runs of the tool that `sim/run` builds, on an idle machine. A processor shared "
            "with others shows down to half of it. Each run prints its own figure.")


def lines(figures, budget):
    rows = [("what", "result", "command"), ("---", "---", "---"), *table_rows(figures)]
    text = "\n".join("| " + " | ".join(row) + " |" for row in rows).replace("| --- | --- | --- |", "|---|---|---|")
    return f"{BEGIN}\n{text}\n\n{cost(budget)}\n\n{pace(figures)}\n{END}"


def sized(text, budget):
    """The text with the bytes of every size in it that docs/budget.json has."""
    return SIZE.sub(lambda m: f"{m[1]}{budget['objects'][m[3]][m[2]]}", text)


def pages_with_sizes():
    return [page for page in sorted((ROOT / "docs").rglob("*.md")) if SIZE.search(page.read_text())]


def wrong_sizes(budget):
    for page in pages_with_sizes():
        text = page.read_text()
        for number, (is_, should) in enumerate(zip(text.splitlines(), sized(text, budget).splitlines()), 1):
            if is_ != should:
                yield f"{page.relative_to(ROOT)}:{number}: a size is not that of docs/budget.json ({REMEDY})"


def main():
    if len(sys.argv) < 2 or (sys.argv[1], len(sys.argv)) not in (("write", 3), ("render", 2),
                                                               ("check", 2)):
        sys.exit(__doc__)
    page = PAGE.read_text()
    if page.count(BEGIN) != 1 or page.count(END) != 1 or page.index(BEGIN) > page.index(END):
        sys.exit(f"{PAGE}:1: expected one {BEGIN} and, after it, one {END}")
    if sys.argv[1] == "write":
        tool = Tool(sys.argv[2])
        measured = json.dumps(measure(tool), indent=1)
        papers_page.write(ROOT, *(tool.json_of("reproduce", paper) for paper in PAPERS))
        FIGURES.write_text(re.sub(r"(\.\d{6})\d+", r"\1", measured) + "\n")
        print(f"written: {FIGURES.relative_to(ROOT)}")
    budget = json.loads(BUDGET.read_text())
    wanted = lines(json.loads(FIGURES.read_text()), budget)
    before, rest = page.split(BEGIN)
    has = BEGIN + rest.split(END)[0] + END
    if sys.argv[1] != "check":
        PAGE.write_text(before + wanted + rest.split(END)[1])
        for sizes in pages_with_sizes():
            sizes.write_text(sized(sizes.read_text(), budget))
            print(f"written: {sizes.relative_to(ROOT)}")
        print(f"written: {PAGE.relative_to(ROOT)}")
        return
    first = page.count("\n", 0, page.index(BEGIN)) + 1
    wrong = 0
    for number, (is_, should) in enumerate(zip(has.splitlines(), wanted.splitlines()), first):
        if is_ != should:
            wrong += 1
            print(f"{PAGE.name}:{number}: '{is_}'; expected '{should}' (tests/run figures writes it)")
    if len(has.splitlines()) != len(wanted.splitlines()):
        wrong += 1
        print(f"{PAGE.name}:{first}: expected {len(wanted.splitlines())} lines up to {END}")
    for text in wrong_sizes(budget):
        wrong += 1
        print(text)
    print(f"{len(wanted.splitlines())} lines, {len(pages_with_sizes())} pages with sizes, {wrong} wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
