"""usage: check_sim_layers.py ROOT: which folder of sim/ includes which, as its README's table says.

The table goes bottom up: a folder may name only those above it in the table, so there are no circles.
The plant includes nothing of the library, which it judges. Only support/ opens files: it knows what is
read, so that no output takes its place, and lets outputs appear complete or not at all.
"""
import pathlib
import re
import sys

from csource import code_of, files, includes_of

ROW = re.compile(r"^\| `(\w+)/` \|.*\| *([^|]*?) *\|$", re.M)
PLANT = "plant"  # physics of its own
OPENING = re.compile(r"\b(?:fopen|freopen|open|creat)\s*\(")
FILES = "support"


def table_of(readme):
    """Folder -> folders that it may include; problems of the table itself."""
    table, problems = {}, []
    for folder, text in ROW.findall(readme):
        named = list(table) if text == "all" else re.findall(r"\w+", text) if text != "none" else []
        for name in named:
            if name not in table:
                problems.append(f"{folder}/ may include {name}/, which is not above it in the table")
        table[folder] = set(named)
    return table, problems


def breach(folder, name, quoted, table, private=()):
    """What is wrong with one #include in one of the folder's files, or None. `private`: headers of src/."""
    if not quoted:
        return None
    target = name.split("/")[0] if "/" in name else None
    if target == "lodestar" or name in private:
        return f'"{name}": expected nothing of the library' if folder == PLANT else None
    if target not in table:
        return f'"{name}": expected "folder/file.h" with a folder of sim/'
    if target != folder and target not in table[folder]:
        return f'"{name}": expected one of {", ".join([folder, *sorted(table[folder])])}'
    return None


def finds_breaches():
    """A gate that lets these pass is worth nothing."""
    table, wrong = table_of("| `low/` | | none |\n| `plant/` | | none |\n| `high/` | | low |\n")
    _, circle = table_of("| `low/` | | high |\n| `high/` | | low |\n")
    bad = [("low", "high/a.h"), ("low", "a.h"), ("low", "nowhere/a.h"), ("high", "plant/a.h"),
           ("plant", "lodestar/frames.h"), ("plant", "low/a.h")]
    good = [("low", "low/a.h"), ("high", "low/a.h"), ("high", "lodestar/frames.h")]
    return (not wrong and circle and breach("plant", "a_inline.h", True, table, ["a_inline.h"]) and OPENING.search('x = fopen(a, "r")') and all(breach(*one, True, table) for one in bad)
            and not any(breach(*one, True, table) for one in good))


def main(root):
    sim = pathlib.Path(root, "sim")
    table, problems = table_of((sim / "README.md").read_text())
    count = 0
    private = {path.name for path in files(root, "src")}
    for path in files(root, "sim"):
        count += 1
        folder = path.relative_to(sim).parts[0]
        if folder not in table:
            problems.append(f"{path}:1: not in a folder of the table in sim/README.md")
            continue
        for line, name, quoted in includes_of(path):
            text = breach(folder, name, quoted, table, private)
            if text:
                problems.append(f"{path}:{line}: {text}")
        for line, text in enumerate(code_of(path.read_text()).splitlines(), 1):
            if folder != FILES and OPENING.search(text):
                problems.append(f"{path}:{line}: {text.strip()}: expected inputs_open() or outputs_open()")
    if not finds_breaches():
        problems.append("this gate does not find the breaches that it plants")
    for text in problems:
        print(text)
    print(f"{count} files, {len(problems)} breaches")
    return 1 if problems or not count else 0


sys.exit(main(sys.argv[1]))
