"""usage: check_evidence.py ROOT: each command on docs/evidence.md is one: its tests and commands exist."""
import pathlib
import re
import sys

PAGE = "docs/evidence.md"
WORDS = {"full", "bench", "figures", "list"}  # of tests/run itself


def tests(root):
    """Names of all tests, as far as files and lists of CMake tell."""
    folder = pathlib.Path(root, "tests")
    names = {path.stem for pattern in ("test_*", "sim/*/test_*", "port/test_*", "fuzz/fuzz_*") for path in folder.glob(pattern)}
    names |= {f"golden_{path.stem.removeprefix('gen_')}" for path in (folder / "golden").glob("gen_*.py")}
    for path in (*folder.rglob("CMakeLists.txt"), *folder.rglob("*.cmake")):
        text = path.read_text()
        names |= set(re.findall(r"add_test\(NAME\s+(\w+)", text))
        names |= {f"gate_{name}" for name in re.findall(r"lode_gate\((\w+)\s", text)}
    return names


def problems(root):
    known = tests(root)
    commands = set(re.findall(r'^\s*\{"([\w-]+)", COMMAND_', pathlib.Path(root, "sim/support/options.c").read_text(), re.M))
    text = pathlib.Path(root, PAGE).read_text()
    found = 0
    for number, line in enumerate(text.splitlines(), 1):
        for command in re.findall(r"`((?:tests|sim)/run[^`]*)`", line):
            found += 1
            program, *words = command.split()
            if program == "sim/run" and words and words[0] not in commands:
                yield f"{PAGE}:{number}: '{command}': expected one of {', '.join(sorted(commands))}"
            for word in words if program == "tests/run" else ():
                if word not in WORDS and word != "NAME" and not any(word in name for name in known):
                    yield f"{PAGE}:{number}: '{command}': no test has '{word}' in its name"
    if found < 20:
        yield f"{PAGE}:1: expected commands, found {found}"


found = list(problems(sys.argv[1]))
for line in found:
    print(line)
sys.exit(1 if found else 0)
