"""For the tests of the command line tool: runs it in a folder of its own and collects failures.

LODE_TOOL names the program, LODE_SOURCE_DIR the source tree (or the first and second argument do).
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

TOOL = os.environ.get("LODE_TOOL") or (sys.argv[1] if len(sys.argv) > 1 else None)
SOURCE = pathlib.Path(os.environ.get("LODE_SOURCE_DIR") or
                      (sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).parents[2]))
RECORDINGS = pathlib.Path(os.environ.get("RECORDINGS_DIR") or SOURCE / "tests/recordings")
# Direct drive of a washing machine, a heavy rotor: 773 of its rated 1200 rpm without load, 378 with the current of rated torque.
WASHER = """[motor]
poles = 48
R_winding_Ohm = 6.5
winding = star
L_winding_mH = 38
ke_V_Hz = 0.55
J_kgm2 = 0.35
speed_rated_rpm = 1200
[drive]
f_pwm_Hz = 16e3
v_bus_V = 310
i_max_A = 6
dead_time_s = 1.5e-6
v_drop_V = 1.5
"""

MOTOR = SOURCE / "sim/data/motors/jiang2022.ini"
DRIVE = SOURCE / "sim/data/drives/jiang2022.ini"
FULL = os.environ.get("LODE_TEST_FULL") == "1"

if not TOOL:
    print("skipped: LODE_TOOL does not name the program")
    sys.exit(77)
TOOL = str(pathlib.Path(TOOL).resolve())


class Checks:
    """Counts what was checked and prints what failed."""

    def __init__(self):
        self.count = self.failed = 0

    def true(self, condition, text):
        self.count += 1
        if not condition:
            self.failed += 1
            print(f"FAILED: {text}")
        return bool(condition)

    def equal(self, value, wanted, text):
        return self.true(value == wanted, f"{text}: {value!r}, expected {wanted!r}")

    def at_most(self, value, bar, text):
        good = isinstance(value, (int, float)) and value <= bar
        return self.true(good, f"{text}: {value}, expected at most {bar}")

    def done(self):
        print(f"{self.count} checks, {self.failed} failed")
        sys.exit(1 if self.failed or not self.count else 0)


class Folder:
    """A temporary folder in which the tool runs."""

    def __init__(self):
        self._temporary = tempfile.TemporaryDirectory(prefix="lodestar-test-")
        self.path = pathlib.Path(self._temporary.name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._temporary.cleanup()

    def write(self, name, text):
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    def run(self, *arguments, env=None, timeout=300):
        return subprocess.run([TOOL, *map(str, arguments)], cwd=self.path, capture_output=True,
                              text=True, timeout=timeout, stdin=subprocess.DEVNULL,
                              env={**os.environ, **(env or {})}, check=False)

    def json(self, name):
        return json.loads((self.path / name).read_text())

    def names(self):
        return sorted(p.name for p in self.path.iterdir())


def refused(checks, folder, arguments, pattern, env=None):
    """The tool ends with 2 and a message on stderr that matches; nothing is written."""
    before = folder.names()
    done = folder.run(*arguments, env=env)
    shown = " ".join(map(str, arguments))
    checks.equal(done.returncode, 2, f"exit code of `{shown}`")
    checks.true(re.search(pattern, done.stderr), f"`{shown}` says {done.stderr!r}, "
                                                 f"expected /{pattern}/")
    checks.equal(folder.names(), before, f"files after `{shown}`")
    return done
