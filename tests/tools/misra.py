"""usage: misra.py ROOT [write]: MISRA C:2012 over the core, by cppcheck's addon.
       misra.py ROOT planted: and what is planted in files that have deviations is found there.

Each finding needs a line in tests/tools/misra_deviations.txt that explains it, and each line a finding.
docs/misra.md, the statement of compliance, is that file as a table; `write` makes it. Exit 77: no cppcheck,
or one without the addon.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

PAGE = "docs/misra.md"
DEVIATIONS = "tests/tools/misra_deviations.txt"
LIBRARY = "tests/tools/misra.xml"
ADVISORY = {"2.3", "2.4", "2.5", "2.6", "2.7", "4.2", "5.9", "8.7", "8.9", "8.11", "8.13", "10.5", "11.4", "11.5", "12.1",
            "12.3", "12.4", "13.3", "13.4", "15.1", "15.4", "15.5", "17.5", "17.8", "18.4", "18.5", "19.2", "20.1", "20.5",
            "20.10", "21.12"}
MANDATORY = {"9.1", "12.5", "13.6", "17.3", "17.4", "17.6", "19.1", "21.13", "21.17", "21.18", "21.19", "21.20", "22.2",
             "22.4", "22.5", "22.6"}
# A breach of each required rule with deviations, as somebody might write it without a reason.
PLANTED = {
    "10.1": "uint32_t planted_1(int32_t all) { return (uint32_t)(all << 2); }",
    "10.4": "uint32_t planted_2(uint32_t all, int32_t some) { return all - some; }",
    "10.6": "uint32_t planted_3(bool on) { const uint32_t step = on ? 1u : 0u; return step; }",
    "10.8": "float planted_4(int32_t one, int32_t other) { return (float)(one - other); }",
    "14.4": "int32_t planted_5(int32_t all) { if (all) { return 1; } return 0; }",
    "13.5": "bool planted_6(bool on, int32_t *all) { return on && --*all == 0; }",
    "16.3": "void planted_7(int32_t *all) { switch (*all) { case 1: *all = 2; default: break; } }",
}
TEXT = """\
# MISRA C:2012

<!-- Written by tests/tools/misra.py from tests/tools/misra_deviations.txt; change that. -->

This is the statement of compliance for `src/` and `include/`. `tests/run gate_misra` checks them with the addon of cppcheck 2.10, without the texts of the rules. The addon finds only breaches of the rules that it implements. If a line breaks several rules, it reports each of them. Nobody has reviewed the directives and the rules that require a human reader. Firmware in `port/`, tests and tools are not in scope.

No mandatory rule is broken. The table explains each finding of a required or advisory rule; a rule that is not listed has no finding. The gate fails for a finding without a line here, and for a line without a finding.

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


def findings(root, sources):
    """(rule, file, line) of each in the folder `sources`, sorted."""
    with tempfile.TemporaryDirectory() as folder:
        # Of two findings on one line with the same text cppcheck tells one; so each rule has its own.
        rules = [f"{chapter}.{rule}" for chapter in range(1, 23) for rule in range(1, 23)]
        texts = pathlib.Path(folder, "texts")
        texts.write_text("Appendix A Summary of guidelines\n"
                         + "".join(f"Rule {rule} Required\nBreach of {rule}\n" for rule in rules))
        addon = pathlib.Path(folder, "misra.json")
        addon.write_text(json.dumps({"script": "misra.py", "args": [f"--rule-texts={texts}"]}))
        done = subprocess.run(
            ["cppcheck", "--quiet", "--std=c99", f"--addon={addon}", f"-j{os.cpu_count()}", f"--cppcheck-build-dir={folder}",
             f"--library={pathlib.Path(root, LIBRARY).resolve()}", "--template=misra:{file}:{line}:{id}",
             "-Iinclude", "-Isrc", "src"], cwd=sources, text=True,
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


def lines_for(known, rule, text):
    """Lines of the deviations that explain the finding at 'file: source line'."""
    return [number for number, other, where, _ in known if other == rule and re.search(where, text)]


def problems(root):
    """Yields findings without a reason, reasons without a finding, and a page that is not as they are."""
    known = list(deviations(root))
    used = set()
    found = findings(root, root)
    for rule, name, line in found:
        text = f"{name}: {pathlib.Path(root, name).read_text().splitlines()[line - 1].strip()}"
        lines = lines_for(known, rule, text)
        used.update(lines)
        if not lines or category(rule) == "mandatory":
            yield f"{name}:{line}: rule {rule}, {category(rule)}: {text.partition(': ')[2]}"
    for number, rule, where, _ in known:
        if number not in used:
            yield f"{DEVIATIONS}:{number}: nothing breaks rule {rule} at '{where}'"
    if not pathlib.Path(root, PAGE).is_file() or pathlib.Path(root, PAGE).read_text() != page(root):
        yield f"{PAGE}:1: not what tests/tools/misra.py makes of its source; run it with `write`"
    print(f"{len(found)} findings, {sum(category(rule) == 'required' for rule, _, _ in found)} of required rules")


def planted(root):
    """Exit code: 1 where a breach that is planted in a file with deviations is not found, or explained by one of them."""
    known = list(deviations(root))
    files = sorted({name for _, _, where, _ in known for name in re.findall(r"src/\w+\.[ch]", where)} | {"src/other.c"})
    missed = []
    count = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in files:
            path = pathlib.Path(folder, name)
            path.parent.mkdir(exist_ok=True)
            path.write_text("#include <stdbool.h>\n#include <stdint.h>\n" + "\n".join(PLANTED.values()) + "\n")
            if name.endswith(".h"):
                path.with_suffix(".c").write_text(f'#include "{path.name}"\n')
        found = set(findings(root, folder))
        for name in files:
            for number, (rule, text) in enumerate(PLANTED.items(), 3):
                if rule == "16.3" and name.endswith(".h"):
                    continue  # cppcheck looks for it in the file that it is given alone
                count += 1
                if (rule, name, number) not in found or lines_for(known, rule, f"{name}: {text}"):
                    missed.append(f"{name}: rule {rule}: {text}")
    print("\n".join(missed + [f"{count} breaches planted, {len(missed)} missed"]))
    return 1 if missed else 0


def main(root, what=None):
    if not shutil.which("cppcheck"):
        print("skipped: no cppcheck")
        return 77
    if what == "planted":
        return planted(root)
    if what == "write":
        pathlib.Path(root, PAGE).write_text(page(root))
    wrong = list(problems(root))
    for text in wrong:
        print(text)
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["write"], ["planted"]):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
