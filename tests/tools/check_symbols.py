"""usage: check_symbols.py LIBRARY: what the built library needs from outside and what it holds.

It needs nothing but what compilers call by themselves and sqrtf; every global name starts with
lode_; it has no variable, only functions and constants.
"""
import os
import re
import subprocess
import sys

OUTSIDE = {"sqrtf", "memcpy", "memset", "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"}


def main(library):
    nm = subprocess.run([os.environ.get("NM", "nm"), "-A", library], stdout=subprocess.PIPE, text=True)
    if nm.returncode != 0:
        return f"nm {library}: code {nm.returncode}"
    rows = []
    for line in nm.stdout.splitlines():
        match = re.match(r".*:([^:]+\.o(?:bj)?):\s*[0-9a-f]*\s+(\w) (\S+)$", line)
        if match:
            rows.append(match.groups())
    defined = {name for _, kind, name in rows if kind not in "Uw"}
    failed = 0
    for unit, kind, name in rows:
        text = None
        if kind == "U" and name not in defined and name not in OUTSIDE:
            text = f"needs '{name}'; expected only {', '.join(sorted(OUTSIDE))}"
        elif kind in "bBdDC":
            text = f"holds the variable '{name}'; expected functions and constants"
        elif kind in "TR" and not name.startswith("lode_"):
            text = f"global name '{name}'; expected lode_..."
        if text:
            failed += 1
            print(f"{unit}:1: {text}")
    print(f"{len(defined)} symbols, {failed} problems")
    return 1 if failed or not defined else 0


sys.exit(main(sys.argv[1]))
