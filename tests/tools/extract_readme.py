"""usage: extract_readme.py ROOT FOLDER COMPILER: README's first ```c block compiles as it stands.

It goes to FOLDER/readme.c; where it has a main it is linked with the core and run as well.
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


def main(root, folder, compiler):
    root, folder = pathlib.Path(root), pathlib.Path(folder)
    readme = root / "README.md"
    text = readme.read_text() if readme.exists() else ""
    match = re.search(r"^```c[ \t]*\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    if not match:
        sys.exit(f"{readme}:1: expected a block of C between ```c and ```")
    line = text.count("\n", 0, match.start(1)) + 1
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / "readme.c"
    source.write_text(f'#line {line} "README.md"\n{match.group(1)}')
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{root / 'include'}"]
    run(compiler, *flags, "-fsyntax-only", source)
    if re.search(r"\bmain\s*\(", match.group(1)):
        core = sorted((root / "src").glob("*.c"))
        program = folder / "readme"
        run(compiler, *flags, "-ffp-contract=off", "-fno-math-errno", "-O1", source, *core,
            "-o", program, "-lm")
        run(program)


main(*sys.argv[1:])
