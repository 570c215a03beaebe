"""usage: safety_page.py ROOT [write]: docs/safety.md from its template and tests/tools/safety_requirements.txt.
       safety_page.py ROOT planted: and the check finds what is planted in these files.

The page is tests/tools/safety_page.md with the table of requirements and tests in its slot. Without
`write` it is compared with what is there. Each test named is a Unity test that its program runs, a gate
or a fuzzer; each check of the guard is named by a requirement; each identifier (S1, A2 ...) that the page
cites is one of its own.
"""
import pathlib
import re
import sys

from csource import code_of

PAGE = "docs/safety.md"
TEMPLATE = "tests/tools/safety_page.md"
REQUIREMENTS = "tests/tools/safety_requirements.txt"
HEADING = "<!-- Written by tests/tools/safety_page.py from tests/tools/safety_page.md and safety_requirements.txt; change those. -->"
PLANTED = {}  # name of a file -> text in its place
IDENTIFIER = re.compile(r"\b[ADEIPS]\d+\b")


def read(root, name):
    return PLANTED[name] if name in PLANTED else pathlib.Path(root, name).read_text()


def requirements(root):
    """(line number, identifier, promise, tests) of each; exits with what a line lacks."""
    for number, line in enumerate(read(root, REQUIREMENTS).splitlines(), 1):
        if line.strip() and not line.startswith("#"):
            cells = [cell.strip() for cell in line.split("|")]
            if len(cells) != 3 or not IDENTIFIER.fullmatch(cells[0]) or not cells[2]:
                sys.exit(f"{REQUIREMENTS}:{number}: expected 'ID | promise | tests', found '{line}'")
            yield number, cells[0], cells[1], cells[2].split()


def programs(root):
    """Files, relative to the root, that run each Unity test."""
    found = {}
    for path in sorted(pathlib.Path(root, "tests").rglob("test_*.c")):
        for name in re.findall(r"\bRUN_TEST\(\s*(\w+)\s*\)", code_of(path.read_text())):
            found.setdefault(name, []).append(path.relative_to(root).as_posix())
    return found


def where(root, test, run_by):
    """Files that hold a test; none: there is no such test."""
    if test.startswith("gate_"):
        gates = "tests/cmake/gates.cmake"
        text = pathlib.Path(root, gates).read_text()
        return [gates] if re.search(rf"lode_gate\({test.removeprefix('gate_')}\s", text) else []
    if test.startswith("fuzz_"):
        path = f"tests/fuzz/{test}.c"
        return [path] if pathlib.Path(root, path).is_file() else []
    return run_by.get(test, [])


def cell(test, paths):
    """Of the ports only the folder, so that one more of them leaves the page as it is."""
    path = "tests/port" if paths[0].startswith("tests/port/") else paths[0]
    return f"`{test}` ([{pathlib.Path(path).name}](../{path}))"


def page(root):
    run_by = programs(root)
    rows = ["| | the library promises | shown by |", "|---|---|---|"]
    for _, name, promise, tests in requirements(root):
        shown = "<br>".join(cell(test, where(root, test, run_by) or ["nowhere"]) for test in tests)
        rows.append(f"| {name} | {promise} | {shown} |")
    title, _, text = read(root, TEMPLATE).partition("\n")
    return f"{title}\n\n{HEADING}\n" + text.replace("{{requirements}}", "\n".join(rows))


def problems(root):
    """Yields what is wrong with the requirements or the page."""
    run_by = programs(root)
    seen = {}
    for number, name, promise, tests in requirements(root):
        at = f"{REQUIREMENTS}:{number}"
        if name in seen:
            yield f"{at}: {name} is in line {seen[name]} already"
        seen[name] = number
        for test in tests:
            if not where(root, test, run_by):
                yield f"{at}: {test}: expected a test that a program of tests/ runs, a gate or a fuzzer"
    text = read(root, REQUIREMENTS)
    header = read(root, "include/lodestar/guard.h")
    for check in re.findall(r"\bLODE_CHECK_(\w+)\b[ ,=]", code_of(header).partition("lode_check_t;")[0]):
        if check not in ("NONE", "COUNT") and not re.search(rf"\b{check}\b", text):
            yield f"{REQUIREMENTS}:1: no requirement names the check {check} of include/lodestar/guard.h"
    template = read(root, TEMPLATE)
    known = set(seen) | set(re.findall(r"^\| (A\d+) \|", template, re.M))
    for number, line in enumerate(template.splitlines(), 1):
        for name in IDENTIFIER.findall(re.sub(r"`[^`]*`", "", line)):
            if name not in known:
                yield f"{TEMPLATE}:{number}: {name} is neither a requirement nor an assumption"
    if read(root, PAGE) != page(root):
        yield f"{PAGE}:1: not what tests/tools/safety_page.py makes of its sources; run it with `write`"


def planted(root):
    """Yields what was planted and not found."""
    for name, old, new in ((REQUIREMENTS, "test_off_stays_off", "test_that_nobody_wrote"),
                           (REQUIREMENTS, "gate_symbols", "gate_that_nobody_keeps"),
                           (REQUIREMENTS, "OVER_SPEED", "too fast"),
                           (TEMPLATE, "A12", "A99"),
                           (PAGE, "(A1)", "(A2)")):
        text = read(root, name)
        PLANTED[name] = text.replace(old, new, 1)
        if text == PLANTED[name] or not list(problems(root)):
            yield f"{name}: '{new}' for '{old}' was not found"
        del PLANTED[name]


def main(root, what=None):
    if what == "write":
        pathlib.Path(root, PAGE).write_text(page(root))
    found = list(planted(root) if what == "planted" else problems(root))
    for text in found:
        print(text)
    return 1 if found else 0


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["write"], ["planted"]):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
