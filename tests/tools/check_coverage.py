"""usage: check_coverage.py ROOT BUILD EXCEPTIONS: every branch of the core is taken by a test.

Reads gcov's JSON for the objects of BUILD. A branch that no test takes must be excused by a line

    file:function: reason        every branch of that function
    file:source line: reason     every branch of the lines that read so (spaces at the ends aside)

of EXCEPTIONS ('#' starts a comment). A line that excuses nothing is an error too: it is out of date.
"""
import collections
import json
import pathlib
import subprocess
import sys


def measure(root, build):
    """{(file, line, function): [taken?]} for src/ and include/, merged over all programs."""
    taken = collections.defaultdict(list)
    objects = sorted(str(p.resolve()) for p in build.rglob("*.gcda"))
    for start in range(0, len(objects), 20):
        gcov = subprocess.run(["gcov", "--json-format", "--stdout", "--branch-probabilities",
                               *objects[start:start + 20]],
                              cwd=build, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        for document in filter(str.strip, gcov.stdout.splitlines()):
            for entry in json.loads(document)["files"]:
                path = pathlib.Path(build, entry["file"]).resolve()
                if not path.is_relative_to(root):
                    continue
                name = path.relative_to(root).as_posix()
                if name.startswith(("src/", "include/")):
                    merge(taken, name, entry["lines"])
    return taken


def merge(taken, name, lines):
    for line in lines:
        counts = [branch["count"] > 0 for branch in line["branches"]]
        old = taken[(name, line["line_number"], line.get("function_name", ""))]
        old += [False] * (len(counts) - len(old))
        for index, hit in enumerate(counts):
            old[index] |= hit


def read_exceptions(path):
    """[line number, file, rest of the line, used?]"""
    rows = []
    for number, line in enumerate(path.read_text().splitlines() if path.exists() else [], 1):
        if line.strip() and not line.startswith("#"):
            name, _, rest = line.partition(":")
            rows.append([number, name.strip(), rest.strip(), False])
    return rows


def excused(rows, name, function, text):
    found = False
    for row in rows:
        for key in (function, text):
            prefix = key + ":"
            if row[1] == name and key and row[2].startswith(prefix) and row[2][len(prefix):].strip():
                row[3] = found = True
    return found


def main(root, build, exceptions):
    root, build, exceptions = (pathlib.Path(p).resolve() for p in (root, build, exceptions))
    taken = measure(root, build)
    rows = read_exceptions(exceptions)
    totals = collections.defaultdict(lambda: [0, 0, 0])
    failed = 0
    for (name, number, function), branches in sorted(taken.items()):
        total = totals[name]
        total[0] += len(branches)
        total[1] += sum(branches)
        missed = branches.count(False)
        if missed:
            text = (root / name).read_text().splitlines()[number - 1].strip()
            if excused(rows, name, function, text):
                total[2] += missed
            else:
                failed += 1
                print(f"{name}:{number}: in {function}: {missed} of {len(branches)} branches not taken: "
                      f"{text}")
    for number, name, rest, used in rows:
        if not used:
            failed += 1
            print(f"{exceptions.name}:{number}: excuses no branch (or gives no reason): {name}:{rest}")
    print(f"{'file':44} branches taken excused")
    for name, (count, hit, allowed) in sorted(totals.items()):
        print(f"{name:44} {count:8} {hit:5} {allowed:7}")
    count, hit, allowed = (sum(column) for column in zip(*totals.values())) if totals else (0, 0, 0)
    print(f"{'all':44} {count:8} {hit:5} {allowed:7}  ({100.0 * hit / max(count, 1):.1f} %)")
    return 1 if failed or not count else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
