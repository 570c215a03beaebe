"""usage: check_mcdc.py ROOT JSON EXCEPTIONS: each condition of the core is seen to decide alone.

Reads what llvm-cov exports. Of each decision with more than one condition: some test has to show of each condition
that it, with the others as they are, turns the decision (masking MC/DC). Decisions of one condition are branches:
check_coverage.py. A condition that no test shows must be excused by a line as those of check_coverage.py. A line that
excuses nothing is an error too.
"""
import collections
import json
import pathlib
import sys

import check_coverage


def place_of(record):
    """Line, column, number of the file and conditions of a decision, as clang 18 writes it, or 23."""
    line, column = record[:2]
    return (line, column, record[4], record[6]) if len(record) == 7 else (line, column, record[6], record[9])


def measure(root, path):
    """{(file, line, column): [shown?]} for src/ and include/: by any copy of an inline function."""
    shown = {}
    for function in json.loads(path.read_text())["data"][0]["functions"]:
        for line, column, file, conditions in map(place_of, function.get("mcdc_records", [])):
            name = pathlib.Path(function["filenames"][file]).resolve()
            if not name.is_relative_to(root):
                continue
            key = (name.relative_to(root).as_posix(), line, column)
            if key[0].startswith(("src/", "include/")):
                old = shown.get(key, conditions)
                shown[key] = [a or b for a, b in zip(old, conditions)]
    return shown


def main(root, path, exceptions):
    root, path, exceptions = (pathlib.Path(p).resolve() for p in (root, path, exceptions))
    rows = check_coverage.read_exceptions(exceptions)
    totals = collections.defaultdict(lambda: [0, 0, 0, 0])
    failed = 0
    for (name, number, _), conditions in sorted(measure(root, path).items()):
        missed = conditions.count(False)
        # Of a decision in a macro's argument llvm-cov tells the line of the macro, but not its file.
        lines = (root / name).read_text().splitlines()
        text = lines[number - 1].strip() if number <= len(lines) else "in a macro's argument"
        allowed = missed if missed and check_coverage.excused(rows, name, "", text) else 0
        for k, more in enumerate((1, len(conditions), sum(conditions), allowed)):
            totals[name][k] += more
        if missed > allowed:
            failed += 1
            which = ", ".join(str(k + 1) for k, good in enumerate(conditions) if not good)
            print(f"{name}:{number}: condition {which} of {len(conditions)} never decides alone: {text}")
    for number, name, rest, used in rows:
        if not used:
            failed += 1
            print(f"{exceptions.name}:{number}: excuses no condition (or gives no reason): {name}:{rest}")
    print(f"{'file':36} decisions conditions shown excused")
    totals["all"] = [sum(column) for column in zip(*totals.values())] or [0, 0, 0, 0]
    for name, (decisions, count, hit, allowed) in totals.items():
        print(f"{name:36} {decisions:9} {count:10} {hit:5} {allowed:7}")
    _, count, hit, _ = totals["all"]
    print(f"{100.0 * hit / max(count, 1):.1f} % of the conditions")
    return 1 if failed or not count else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
