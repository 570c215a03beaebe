"""usage: check_equations.py ROOT: the equation tables of docs/theory agree with docs, code and tests.

That of equations.md, and those of pages that bring rows of their own, have the columns: paper equation |
docs equation | function | test. Each docs label (X1) stands in a page of docs/theory outside of these
tables; each function, in backticks, exists in include/ or src/; each test, in backticks, is a function
in tests/.
"""
import pathlib
import re
import sys

from csource import code_of, files

COLUMNS = ["paper equation", "docs equation", "function", "test"]


def rows_of(page):
    """(line number, cells) of the rows of every table with these columns."""
    columns = None
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if not line.lstrip().startswith("|"):
            columns = None
            continue
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]
        if columns is None:
            columns = cells
            named = [cell.lower() for cell in cells] == COLUMNS
        elif named and not all(re.fullmatch(r":?-+:?", cell) for cell in cells):
            yield number, cells


def names_in(cell):
    return [re.sub(r"\(.*", "", name) for name in re.findall(r"`([^`]+)`", cell)]


def has_function(text, name):
    return re.search(rf"\b{re.escape(name)}\s*\(", text) is not None


def main(root):
    root = pathlib.Path(root)
    page = root / "docs/theory/equations.md"
    if not page.exists():
        return f"{page}: missing; expected a table: {' | '.join(COLUMNS)}"
    rows, text = [], []
    for path in sorted(page.parent.glob("*.md")):
        own = dict(rows_of(path))
        rows += [(path, number, cells) for number, cells in own.items()]
        lines = enumerate(path.read_text().splitlines(), 1)
        text += [line for number, line in lines if path != page and number not in own]
    theory = "\n".join(text)
    core = "\n".join(code_of(p.read_text()) for p in files(root, "include", "src"))
    tests = "\n".join(code_of(p.read_text()) for p in files(root, "tests"))
    tests += "\n".join(p.read_text() for p in sorted((root / "tests").rglob("*.py")))
    count = failed = 0
    for path, number, cells in rows:
        count += 1
        problems = []
        if len(cells) != len(COLUMNS):
            problems.append(f"{len(cells)} cells; expected {len(COLUMNS)}")
        else:
            labels = re.findall(r"\(([A-Z]+[0-9]+[a-z]?)\)", cells[1])
            functions, cases = names_in(cells[2]), names_in(cells[3])
            for what, found in (("docs equation like (X1)", labels), ("function in backticks", functions),
                                ("test in backticks", cases)):
                if not found:
                    problems.append(f"expected a {what}")
            problems += [f"({x}) is in no page of docs/theory" for x in labels
                         if not re.search(rf"\(\s*{x}\s*\)|\\tag\{{\s*{x}\s*\}}", theory)]
            problems += [f"function '{x}' is not in include/ or src/" for x in functions
                         if not has_function(core, x)]
            problems += [f"test '{x}' is no function in tests/" for x in cases
                         if not has_function(tests, x)]
        for problem in problems:
            failed += 1
            print(f"{path}:{number}: {problem}")
    if not any(path == page for path, _, _ in rows):
        return f"{page}:1: no row found; expected a table: {' | '.join(COLUMNS)}"
    print(f"{count} equations, {failed} problems")
    return 1 if failed else 0


sys.exit(main(sys.argv[1]))
