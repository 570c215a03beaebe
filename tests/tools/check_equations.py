"""usage: check_equations.py ROOT: the equation tables of docs/theory agree with docs, code and tests.
       check_equations.py ROOT --planted: and the check finds unknown labels that are planted in a copy.

That of equations.md, and those of pages that bring rows of their own, have the columns: paper equation |
docs equation | function | test. Each docs label (X1) stands in a page of docs/theory outside of these
tables; each function, in backticks, exists in include/, src/ or sim/; each test, in backticks, is a
function in tests/.
Each label is that of one equation: no two pages, and no two lines, have the same tag.
The other way round, every label that code of these folders cites stands in a table: (E5), (P4, P6),
(B6-B8), or in brackets that name a page, (docs/theory/emf.md, E10).
"""
import contextlib
import io
import pathlib
import re
import shutil
import sys
import tempfile

from csource import code_of, files

COLUMNS = ["paper equation", "docs equation", "function", "test"]
CODE = ["include", "src", "sim"]
LABEL = r"[A-Z]{1,2}[0-9]{1,2}[a-d]?"


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


def cited(root):
    """(file, line, label) of each label that code cites."""
    for folder in CODE:
        for path in sorted(pathlib.Path(root, folder).rglob("*")):
            if path.suffix not in (".c", ".h", ".def"):
                continue
            for number, line in enumerate(path.read_text().splitlines(), 1):
                for brackets in re.findall(r"\(([^()]*)\)", line):
                    if not re.match(rf"\s*{LABEL}(?!\w)", brackets) and "docs/theory/" not in brackets:
                        continue
                    for first, last in re.findall(rf"\b({LABEL})\b(?:\s*-\s*({LABEL})\b)?", brackets):
                        for label in range_of(first, last):
                            yield path, number, label


def range_of(first, last):
    """B6, B8: also B7."""
    letters, begin = re.match(r"([A-Z]+)([0-9]+)", first).groups()
    if not last:
        return [first]
    end = re.match(r"[A-Z]+([0-9]+)", last).group(1)
    return [f"{letters}{n}" for n in range(int(begin), int(end) + 1)]


def tagged_twice(pages):
    """(file, line, label) of each tag that an equation before it has already."""
    first = {}
    for path in pages:
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for label in re.findall(rf"\\tag\{{\s*({LABEL})\s*\}}", line):
                if first.setdefault(label, (path, number)) != (path, number):
                    yield path, number, label, first[label]


def planted(root):
    """Whether the check fails on a copy of the tree in which code cites what is not there."""
    root = pathlib.Path(root)
    lines = {"src/planted.c": "/// As (Z99) has it.\n", "include/planted.h": "// (E5), (E98)\n",
             "sim/plant/planted.c": "// Behind it (docs/theory/emf.md, E97).\n",
             "docs/theory/planted.md": "$$x = 1 \\tag{E5}$$\n"}
    output = io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder)
        for part in ["docs/theory", "tests", *CODE]:
            shutil.copytree(root / part, copy / part, ignore=shutil.ignore_patterns("__pycache__"))
        for name, line in lines.items():
            (copy / name).write_text(line)
        with contextlib.redirect_stdout(output):
            code = main(copy)
    missed = [f"{name}: '{line.strip()}'" for name, line in lines.items()
              if f"{name}:1: " not in output.getvalue()]
    for text in missed:
        print(f"{text} passed; expected it to fail")
    print(f"{len(lines)} labels planted, {len(missed)} missed")
    return 1 if missed or code != 1 else 0


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
    core = "\n".join(code_of(p.read_text()) for p in files(root, *CODE))
    tests = "\n".join(code_of(p.read_text()) for p in files(root, "tests"))
    tests += "\n".join(p.read_text() for p in sorted((root / "tests").rglob("*.py")))
    count = failed = 0
    listed = set()
    for path, number, cells in rows:
        count += 1
        problems = []
        if len(cells) != len(COLUMNS):
            problems.append(f"{len(cells)} cells; expected {len(COLUMNS)}")
        else:
            labels = re.findall(r"\(([A-Z]+[0-9]+[a-z]?)\)", cells[1])
            listed.update(labels)
            functions, cases = names_in(cells[2]), names_in(cells[3])
            for what, found in (("docs equation like (X1)", labels), ("function in backticks", functions),
                                ("test in backticks", cases)):
                if not found:
                    problems.append(f"expected a {what}")
            problems += [f"({x}) is in no page of docs/theory" for x in labels
                         if not re.search(rf"\(\s*{x}\s*\)|\\tag\{{\s*{x}\s*\}}", theory)]
            problems += [f"function '{x}' is not in include/, src/ or sim/" for x in functions
                         if not has_function(core, x)]
            problems += [f"test '{x}' is no function in tests/" for x in cases
                         if not has_function(tests, x)]
        for problem in problems:
            failed += 1
            print(f"{path}:{number}: {problem}")
    for path, number, label in cited(root):
        if label not in listed:
            failed += 1
            print(f"{path}:{number}: ({label}) is in no table of docs/theory; expected a row for it")
    for path, number, label, (other, line) in tagged_twice(sorted(page.parent.glob("*.md"))):
        failed += 1
        print(f"{path}:{number}: ({label}) is the tag of {other}:{line} already; expected another one")
    if not any(path == page for path, _, _ in rows):
        return f"{page}:1: no row found; expected a table: {' | '.join(COLUMNS)}"
    print(f"{count} equations, {failed} problems")
    return 1 if failed else 0


sys.exit(planted(sys.argv[1]) if "--planted" in sys.argv else main(sys.argv[1]))
