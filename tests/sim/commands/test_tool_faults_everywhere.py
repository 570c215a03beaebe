"""lodestar faults: all kinds of faults on the whole catalogue, none silent. *Long*: other phases and loads too."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import FULL, SOURCE, Checks, Folder

MOTORS = sorted(path.stem for path in (SOURCE / "sim/data/drives").glob("*.ini") if (SOURCE / "sim/data/motors" / path.name).exists())
AT_ONCE = 5  # motors in one campaign, of the eight that it takes


def none_is_silent(checks, folder, *more):
    for first in range(0, len(MOTORS), AT_ONCE):
        motors = MOTORS[first:first + AT_ONCE]
        done = folder.run("faults", "--motors", ",".join(motors), *more, "--json", "f.json", timeout=1200)
        cases = folder.json("f.json")["cases"]
        silent = [(case["motor"], case["kind"], case["at"]) for case in cases if case["silent"]]
        checks.equal(silent, [], f"silent with {more}")
        checks.equal(done.returncode, 0, f"exit code with {motors}, {more}")
        for motor in motors:
            count = sum(case["motor"] == motor for case in cases)
            checks.true(count >= 50 * 4, f"{count} cases of {motor}, {more}")


checks = Checks()
with Folder() as folder:
    none_is_silent(checks, folder)
    if FULL:
        for place in ("a1", "b1", "c1"):
            for load in ("0.1", "0.6"):
                none_is_silent(checks, folder, "--in", place, "--load", load, "--seed", "2")
checks.done()
