"""usage: check_tree.py ROOT: what may lie in the tree and what its text must not say.

The entries of the root, no file over 1 MB, no path or host of one person's machine, no unfinished
mark, no test that cannot fail; what a port's README says first, and that porting.md names every fault's
number. The patterns are spelt so that they do not find themselves.
"""
import pathlib
import re
import shutil
import subprocess
import sys

ENTRIES = {"CMakeLists.txt", "CMakePresets.json", "README.md", "LICENSE", "include", "src", "port",
           "tests", "sim", "docs"}
OPTIONAL = {"port"}
CODE = ("include/", "src/", "port/", "tests/", "sim/")

PATTERNS = [
    ("", re.compile(r"/(?:wor[k]|far[m])/|(?<![\w.$}~)*-])/(?:hom[e]|Users|roo[t])/"),
     "a path that other machines do not have"),
    ("", re.compile(r"artifactor[y]|\.\./share[d]", re.I), "a path or host of a workplace"),
    (CODE, re.compile(r"\b(TOD[O]|FIXM[E]|XX[X]|HAC[K])\b|not implemente[d]|placeholde[r]", re.I),
     "an unfinished mark"),
    ("tests/", re.compile(r"TEST_IGNOR[E]|TEST_ASSERT_TRUE\((1|true)\)|TEST_PAS[S]\("),
     "a test that cannot fail or is switched off"),
]

# The first paragraph of a README of a port with boards.
TRIED = re.compile(r"\*\*Never run on hardware\b[^*]*\*\* Tested: .* Not tested: ")


def tree_files(root):
    """Tracked files and new ones that git would take; without git, everything but build/."""
    git = None
    if shutil.which("git") and (root / ".git").exists():
        git = subprocess.run(["git", "-C", str(root), "ls-files", "-z", "-co", "--exclude-standard"],
                             stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    if git and git.returncode == 0:
        names = [name.decode() for name in git.stdout.split(b"\0") if name]
    else:
        names = [str(p.relative_to(root)) for p in root.rglob("*")
                 if not p.relative_to(root).parts[0] in ("build", ".git", ".cache")
                 and "__pycache__" not in p.parts]
    return sorted(name for name in names if (root / name).is_file())


def untold(root, names):
    for port in sorted({name.split("/")[1] for name in names if re.match(r"port/[^/]+/boards/", name)}):
        readme = root / "port" / port / "README.md"
        lines = readme.read_text().splitlines() if readme.exists() else []
        if not TRIED.match("".join(lines[2:3])):
            yield f"port/{port}/README.md:3: expected what has been tested, on what, and that no hardware was"


def unnamed_checks(root):
    """The table of faults in docs/porting.md has every number of lode_check_t."""
    enumerators = re.findall(r"^    LODE_CHECK_(\w+)", (root / "include/lodestar/guard.h").read_text(), re.M)
    text = (root / "docs/porting.md").read_text()
    table = text[text.index("### Faults"):text.index("What each means")]
    named = {int(number) for number in re.findall(r"\| (\d+) \|", table)}
    for number in sorted(set(range(1, enumerators.index("COUNT"))) - named):
        yield f"docs/porting.md:1: the table of faults lacks check {number}, {enumerators[number]}"


def problems(root):
    names = tree_files(root)
    yield from untold(root, names)
    yield from unnamed_checks(root)
    entries = {name.split("/")[0] for name in names}
    for entry in sorted(entries - ENTRIES):
        if not entry.startswith("."):
            yield f"{entry}:1: not an entry of the root; expected {', '.join(sorted(ENTRIES))}"
    for entry in sorted(ENTRIES - OPTIONAL - entries):
        yield f"{entry}:1: missing in the root"
    for name in names:
        path = root / name
        if path.stat().st_size > 1 << 20:
            yield f"{name}:1: {path.stat().st_size} bytes; expected at most 1 MB"
        data = path.read_bytes()
        if b"\0" in data:
            continue
        for number, line in enumerate(data.decode(errors="replace").splitlines(), 1):
            for where, pattern, text in PATTERNS:
                if name.startswith(where) and pattern.search(line):
                    yield f"{name}:{number}: {text}: {line.strip()[:100]}"
    for script in ("sim/run", "tests/run", ".ci/run"):
        if not (root / script).stat().st_mode & 0o100:
            yield f"{script}:1: expected to be executable"


def main(root):
    found = list(problems(pathlib.Path(root)))
    for text in found:
        print(text)
    print(f"{len(found)} problems")
    return 1 if found else 0


sys.exit(main(sys.argv[1]))
