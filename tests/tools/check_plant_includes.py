"""usage: check_plant_includes.py ROOT: the simulated plant shares no code with the library.

Of the library it may include the plain types in ALLOWED; of sim/ what keeps to the same rule.
"""
import pathlib
import sys

from csource import includes_of

ALLOWED = {"lodestar/platform.h", "lodestar/status.h", "lodestar/types.h"}


def main(root):
    sim = pathlib.Path(root, "sim")
    queue = sorted(sim.glob("plant/*.[ch]"))
    seen = set(queue)
    failed = 0
    while queue:
        path = queue.pop(0)
        for line, name, quoted in includes_of(path):
            if name.startswith("lodestar/"):
                if name not in ALLOWED:
                    failed += 1
                    print(f"{path}:{line}: \"{name}\": expected at most {', '.join(sorted(ALLOWED))}")
            elif quoted:
                target = sim / name
                if not target.exists():
                    failed += 1
                    print(f"{path}:{line}: \"{name}\": expected a header of sim/")
                elif target not in seen:
                    seen.add(target)
                    queue.append(target)
    if not seen:
        print(f"{sim}/plant: no C there")
    print(f"{len(seen)} files of the plant, {failed} breaches")
    return 1 if failed or not seen else 0


sys.exit(main(sys.argv[1]))
