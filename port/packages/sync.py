#!/usr/bin/env python3
"""usage: sync.py [--check]: brings every package description in line with the tree.

The version is that of include/lodestar/version.h, the pack's list of files that of include/ and src/.
With --check nothing is written: each difference is printed and the exit code is 1.
"""
import argparse
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERSION_H = "include/lodestar/version.h"
PDSC = "port/packages/cmsis/Lodestar.Lodestar.pdsc"
# Where the version stands besides: file, then a pattern whose second group is the version.
PLACES = [
    ("CMakeLists.txt", r'(set\(lode_version ")([^"$]*)(")'),
    ("port/packages/platformio/library.json", r'("version": ")([^"]*)(")'),
    ("port/packages/esp-idf/lodestar/idf_component.yml", r'(^version: ")([^"]*)(")'),
    (PDSC, r'(<release version=")([^"]*)(")'),
    (PDSC, r'(Cversion=")([^"]*)(")'),
    ("docs/changelog.md", r"(^## \[?)(\d[^] ]*)(\]?)"),
]
FILES = re.compile(r'(?:^ *<file category="(?:header|sourceC|other)" .*\n)+', re.MULTILINE)


def version():
    text = (ROOT / VERSION_H).read_text()
    numbers = [re.search(rf"^#define LODE_VERSION_{part} (\d+)$", text, re.MULTILINE)
               for part in ("MAJOR", "MINOR", "PATCH")]
    if None in numbers:
        sys.exit(f"{VERSION_H}:1: expected '#define LODE_VERSION_<MAJOR, MINOR, PATCH> <number>'")
    return ".".join(number.group(1) for number in numbers)


def file_lines():
    """The pack's entries for all headers and sources, a line each."""
    names = [("header", path) for path in sorted((ROOT / "include/lodestar").glob("*.h"))]
    names += [("other", path) for path in sorted((ROOT / "include/lodestar").glob("*.def"))]
    # "other": no folder of the user's include path.
    names += [("other", path) for path in sorted((ROOT / "src").glob("*.h"))]
    names += [("sourceC", path) for path in sorted((ROOT / "src").glob("*.c"))]
    return "".join(f'        <file category="{category}" name="{path.relative_to(ROOT)}"/>\n'
                   for category, path in names)


def in_line(name, text):
    """The text as it should be, and what is wrong with it."""
    problems = []
    for place, pattern in PLACES:
        if place != name:
            continue
        match = re.search(pattern, text, re.MULTILINE)
        if not match:
            sys.exit(f"{name}:1: expected a version, as in {pattern}")
        if match.group(2) != version():
            line = text.count("\n", 0, match.start()) + 1
            problems.append(f"{name}:{line}: version {match.group(2)}; expected {version()}")
            text = text[:match.start(2)] + version() + text[match.end(2):]
    if name == PDSC:
        match = FILES.search(text)
        if not match:
            sys.exit(f"{name}:1: expected entries <file category=\"header\" .../>")
        for entry in sorted(set(match.group().splitlines()) ^ set(file_lines().splitlines())):
            line = text.count("\n", 0, match.start()) + 1
            kind = "no such file" if entry in match.group() else "missing"
            problems.append(f"{name}:{line}: {kind}: {entry.strip()}")
        text = text[:match.start()] + file_lines() + text[match.end():]
    return text, problems


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="change nothing")
    check = parser.parse_args().check
    count = 0
    for name in sorted({name for name, _ in PLACES}):
        path = ROOT / name
        text, problems = in_line(name, path.read_text())
        count += len(problems)
        print("\n".join(problems), end="\n" if problems else "")
        if problems and not check and not name.startswith("docs/"):
            path.write_text(text)
    print(f"version {version()}: {count} differences")
    return 1 if check and count else 0


sys.exit(main())
