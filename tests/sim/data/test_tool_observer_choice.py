"""docs/observer-choice.md: which scenarios pass with which observer and PLL is what the tool gives.

The page is written by tests/observer_choice.py, whose runs take minutes. The ordinary run reads the page only: its table
has every pair and every scenario. The long campaign (LODE_TEST_FULL=1) makes a fifth of the runs of that table again:
those of its first seed, with the default PLL or the default observer. They fail nowhere where the page has all seeds pass.
"""
import concurrent.futures
import os
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import FULL, SOURCE, Checks, Folder

PAGE = (SOURCE / "docs/observer-choice.md").read_text()
SECTION = PAGE.split("## Every observer with either PLL\n", 1)[1].split("\n## ", 1)[0]
OBSERVERS = re.findall(r'^LODE_OBSERVER\(.*"(.*)"', (SOURCE / "include/lodestar/observers.def").read_text(), re.MULTILINE)
PLLS = ("leso-qpll", "qpll")
PAIRS = [(observer, pll) for observer in OBSERVERS for pll in PLLS]
SCENARIOS = {path.stem for path in (SOURCE / "sim/data/scenarios").glob("*.ini")}
WRITE = "tests/observer_choice.py write pairs"


def claims(checks):
    """{(observer, pll): (failed, number refused)}, the scenarios, the first seed and those that any error refuses, of the page."""
    total, left_out = re.search(r"^All (\d+) scenarios but (.*?); seeds (?:\d+)", SECTION, re.MULTILINE).groups()
    names = SCENARIOS - {part.split(" (")[0] for part in re.split(r", (?=\w+ \()", left_out)}
    checks.equal(int(total), len(SCENARIOS), f"scenarios of the page; {WRITE}")
    seed = int(re.search(r"seeds (\d+) \.\. ", SECTION).group(1))
    refused = set().union(*(set(listed.split(", ")) for listed in re.findall(r"^`LODE_ERROR_\w+`: (.*)\.$", SECTION, re.MULTILINE)))
    table = {}
    for observer, pll, passed, count, bad in re.findall(r"^\| ([\w-]+) \| ([\w-]+) \| (\d+) \| (\d+) \| (.*) \|$", SECTION, re.MULTILINE):
        failed = set(re.findall(r"(\w+) \(\d+ of \d+: ", bad))
        checks.equal(int(passed) + int(count) + len(failed), len(names), f"scenarios of {observer} with {pll}")
        table[observer, pll] = (failed, int(count))
    checks.equal(sorted(table), sorted(PAIRS), f"pairs of the page; {WRITE}")
    return table, sorted(names), seed, refused


def verdict(folder, job):
    """How a run ended: "pass", "fail" or "refused"."""
    name, observer, pll, seed = job
    done = folder.run("run", name, "--seed", str(seed), "--set", f"estimator.emf={observer}", "--set", f"estimator.pll={pll}",
                      timeout=1200)
    return "refused" if done.returncode == 2 and "LODE_ERROR_" in done.stderr else {0: "pass", 1: "fail"}[done.returncode]


def main():
    checks = Checks()
    table, names, seed, refused = claims(checks)
    if FULL:
        pairs = [pair for pair in PAIRS if pair[0] == OBSERVERS[0] or pair[1] == PLLS[0]]
        jobs = [(name, *pair, seed) for name in names for pair in pairs]
        found = {pair: {"pass": set(), "fail": set(), "refused": set()} for pair in pairs}
        with Folder() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for job, how in zip(jobs, pool.map(lambda job: verdict(folder, job), jobs)):
                found[job[1:3]][how].add(job[0])
        for pair in pairs:
            failed, count = table[pair]
            checks.equal(found[pair]["fail"] - failed, set(), f"scenarios that fail with {pair}, but not on the page; {WRITE}")
            checks.equal(len(found[pair]["refused"]), count, f"refused with {pair}; {WRITE}")
            checks.true(found[pair]["refused"] <= refused, f"refused with {pair}, but not on the page; {WRITE}")
    checks.done()


main()
