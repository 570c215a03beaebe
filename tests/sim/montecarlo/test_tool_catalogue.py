"""The bars of starts, runs and flying starts over the whole catalogue, with defaults only (docs/evidence.md, wrong parameters).

The ordinary run has a few seeds, of which none may be silent and 95 % must pass. The long campaign (LODE_TEST_FULL=1) has as many as
the bars are for, and takes them from the exit code.
"""
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import FULL, Checks, Folder

# Campaign, and seeds per motor: of the ordinary run, of the long one. Each begins with seed 1.
CAMPAIGNS = (("start", 4, 200), ("run", 2, 200), ("run --errors wide", 2, 60), ("run --errors commissioned", 1, 200), ("fly", 2, 42))
PASSED = 0.95 # of a few: the bar of wide errors


def campaign(checks, folder, arguments, n):
    done = folder.run("monte-carlo", *arguments.split(), "--n", n, "--json", "m.json", timeout=10800)
    what = f"monte-carlo {arguments} --n {n}"
    print(f"{what}: {done.stdout[done.stdout.rindex('all  '):]}")
    rows = json.loads((folder.path / "m.json").read_text())["rows"]
    checks.equal(len(rows), 15 * n, f"{what}: cases")
    if FULL:
        checks.equal(done.returncode, 0, f"{what}: {done.stdout}")
        return
    checks.true("silent:" not in done.stdout, f"{what}: none is silent: {done.stdout}")
    passed = sum(row["result"] == "pass" for row in rows)
    checks.true(passed >= PASSED * len(rows), f"{what}: {passed} of {len(rows)} passed: {done.stdout}")


def main():
    checks = Checks()
    with Folder() as folder:
        for arguments, few, many in CAMPAIGNS:
            campaign(checks, folder, arguments, many if FULL else few)
    checks.done()


main()
