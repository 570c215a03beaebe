"""usage: extract_readme.py ROOT FOLDER COMPILER: the examples for firmware compile as they stand.

They are the first ```c block of each of PAGES, and go to FOLDER; one that has a main is linked with the
core and run as well.
"""
import pathlib
import re
import subprocess
import sys


def run(*command):
    print("+", *command)
    code = subprocess.run([str(word) for word in command], timeout=60).returncode
    if code != 0:
        sys.exit(f"ended with code {code}")


PAGES = ["README.md", "docs/theory/dual.md", "docs/commissioning.md"]


def check(root, folder, compiler, page):
    text = (root / page).read_text() if (root / page).exists() else ""
    match = re.search(r"^```c[ \t]*\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    if not match:
        sys.exit(f"{page}:1: expected a block of C between ```c and ```")
    line = text.count("\n", 0, match.start(1)) + 1
    source = folder / f"{pathlib.Path(page).stem.lower()}.c"
    source.write_text(f'#line {line} "{page}"\n{match.group(1)}')
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{root / 'include'}"]
    run(compiler, *flags, "-fsyntax-only", source)
    if re.search(r"\bmain\s*\(", match.group(1)):
        core = sorted((root / "src").glob("*.c"))
        program = source.with_suffix("")
        run(compiler, *flags, "-ffp-contract=off", "-fno-math-errno", "-O1", source, *core,
            "-o", program, "-lm")
        run(program)


def main(root, folder, compiler):
    root, folder = pathlib.Path(root), pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for page in PAGES:
        check(root, folder, compiler, page)


main(*sys.argv[1:])
