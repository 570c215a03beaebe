"""usage: misra.py ROOT [write]: MISRA C:2012 over the core, by cppcheck's addon.

Each finding needs a line in tests/tools/misra_deviations.txt that explains it, and each line a finding.
docs/misra.md, the statement of compliance, is that file as a table; `write` makes it. Exit 77: no cppcheck,
or one without the addon.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

PAGE = "docs/misra.md"
DEVIATIONS = "tests/tools/misra_deviations.txt"
ADVISORY = {"2.3", "2.4", "2.5", "2.6", "2.7", "4.2", "5.9", "8.7", "8.9", "8.11", "8.13", "10.5", "11.4", "11.5", "12.1",
            "12.3", "12.4", "13.3", "13.4", "15.1", "15.4", "15.5", "17.5", "17.8", "18.4", "18.5", "19.2", "20.1", "20.5",
            "20.10", "21.12"}
MANDATORY = {"9.1", "12.5", "13.6", "17.3", "17.4", "17.6", "19.1", "21.13", "21.17", "21.18", "21.19", "21.20", "22.2",
             "22.4", "22.5", "22.6"}
TEXT = """\
# MISRA C:2012

<!-- Written by tests/tools/misra.py from tests/tools/misra_deviations.txt; change that. -->

Statement of compliance for `src/` and `include/`, by the addon of cppcheck 2.10, without the texts of the rules: `tests/run gate_misra`. It finds breaches of the rules that it knows and nothing else; directives, and rules that need a reader, have not been reviewed by anybody. Firmware in `port/`, tests and tools are not in scope.

No mandatory rule is broken. Of the required ones each finding is explained below, of the advisory ones too; a rule that is not named has no finding. The gate fails for a finding without a line here, and for a line without a finding.

| rule | category | where | why |
|---|---|---|---|
"""


def category(rule):
    return "mandatory" if rule in MANDATORY else "advisory" if rule in ADVISORY else "required"


def deviations(root):
    """(line number, rule, where, reason)"""
    for number, line in enumerate(pathlib.Path(root, DEVIATIONS).read_text().splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        rule, _, rest = line.partition(" | ")
        where, _, reason = rest.rpartition(" | ")
        if not re.fullmatch(r"\d+\.\d+", rule) or not where or not reason:
            sys.exit(f"{DEVIATIONS}:{number}: expected 'rule | where | reason', found '{line}'")
        yield number, rule, where, reason


def findings(root):
    """(rule, file, line) of each, sorted."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            ["cppcheck", "--quiet", "--std=c99", "--addon=misra", f"-j{os.cpu_count()}", f"--cppcheck-build-dir={folder}",
             "--template=misra:{file}:{line}:{id}", "-Iinclude", "-Isrc", "src"], cwd=root, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if "Did not find addon" in done.stdout or "No such file" in done.stdout:
        print("skipped: this cppcheck has no misra addon")
        sys.exit(77)
    found = re.findall(r"^misra:([^:\n]+):(\d+):misra-c2012-([\d.]+)", done.stdout, re.M)
    return sorted({(rule, name, int(line)) for name, line, rule in found})


def page(root):
    rows = []
    for _, rule, where, reason in deviations(root):
        shown = "all" if where == "." else "`" + where.replace("|", "\\|") + "`"
        rows.append(f"| {rule} | {category(rule)} | {shown} | {reason} |")
    return TEXT + "\n".join(rows) + "\n"


def problems(root):
    """Yields findings without a reason, reasons without a finding, and a page that is not as they are."""
    known = list(deviations(root))
    used = set()
    found = findings(root)
    for rule, name, line in found:
        text = f"{name}: {pathlib.Path(root, name).read_text().splitlines()[line - 1].strip()}"
        lines = [number for number, other, where, _ in known if other == rule and re.search(where, text)]
        used.update(lines)
        if not lines or category(rule) == "mandatory":
            yield f"{name}:{line}: rule {rule}, {category(rule)}: {text.partition(': ')[2]}"
    for number, rule, where, _ in known:
        if number not in used:
            yield f"{DEVIATIONS}:{number}: nothing breaks rule {rule} at '{where}'"
    if not pathlib.Path(root, PAGE).is_file() or pathlib.Path(root, PAGE).read_text() != page(root):
        yield f"{PAGE}:1: not what tests/tools/misra.py makes of its source; run it with `write`"
    print(f"{len(found)} findings, {sum(category(rule) == 'required' for rule, _, _ in found)} of required rules")


def main(root, what=None):
    if not shutil.which("cppcheck"):
        print("skipped: no cppcheck")
        return 77
    if what == "write":
        pathlib.Path(root, PAGE).write_text(page(root))
    wrong = list(problems(root))
    for text in wrong:
        print(text)
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["write"]):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
