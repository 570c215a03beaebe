"""usage: run.py ROOT FOLDER

Abstract interpretation (Frama-C EVA) of tests/eva/step.c, the whole step, and of tests/eva/step6.c, that of six phases:
with any counts, stamps, trips and commands in any order, and of three phases with LODE_TEST_FULL=1 two tunings that take
turns, otherwise one that is posted again. Floats may be anything, NaN and infinities too. Shown is that nothing
undefined happens (no overflow of a signed integer, no float that does not fit the integer it is converted to, no access
outside an object or to a value never written, no division by zero of an integer) and that the assertions of the driver
hold: every duty lies in [0, 1]. Prints every alarm; exit 1 if there is one, or an assertion that is not proven. Exit 77 without frama-c. FOLDER keeps the sources as they were read, and the log.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

# Where the branches of a comparison must be kept apart for longer.
PRECISE = ("measure_start", "lode_start_measure", "lode_in_range", "lode_sincos", "lode_wrap", "act", "lode_drive_accept",
           "take_flight", "lode_clamp", "act_0", "accept")
FLAGS = ("-machdep", "gcc_x86_64", "-warn-special-float", "none", "-eva-slevel", "10", "-eva-auto-loop-unroll", "70",
         "-eva-split-return", "auto", "-eva-slevel-function", ",".join(f"{name}:500" for name in PRECISE),
         "-eva-msg-key=-initial-state,-final-states")
CPP = "-std=c99 -Iinclude -Isrc -include tests/eva/compiler.h"
SCALAR = "include/lodestar/scalar.h"
DRIVE = "src/drive.c"
DRIVE6 = "src/drive6.c"

# What is written for it in another way: (file, as it stands, as it is read). Frama-C 25 keeps NaN among the values of a
# variable of which a comparison was true, takes a size by sizeof for none, and does not see that bits and float of a
# union are one value, or of what a copy was that a function was given. None of them takes a behaviour away: a comparison with NaN is false; of the duties, tests/eva/bits.c
# shows (LODE_TEST_FULL=1) that the two ways to look at them agree, for every float there is.
REWRITTEN = (
    ("include/lodestar/observer.h", "[sizeof(lode_observer_numbers_t)]", "[5]"),
    ("include/lodestar/observer.h", "[sizeof(lode_observer_vectors_t)]", "[3]"),
    (SCALAR, "return x >= lo && x <= hi;",
     "if (x >= lo && x <= hi) { /*@ admit ordered: !\\is_NaN(x); */ return true; } return false;"),
    (SCALAR, "return a < b ? a : b;", "if (a < b) { /*@ admit ordered: !\\is_NaN(a); */ return a; } return b;"),
    (SCALAR, "return a > b ? a : b;", "if (a > b) { /*@ admit ordered: !\\is_NaN(a); */ return a; } return b;"),
    (SCALAR, "return x > lo ? (x < hi ? x : hi) : lo;",
     "if (x > lo) { if (x < hi) { /*@ admit ordered: !\\is_NaN(x); */ return x; } return hi; } return lo;"),
    (DRIVE, "!lode_modulator_is_within(duty, tuning->sense.duty_max)",
     "!EVA_BOTH_WITHIN(duty, self, tuning->sense.duty_max)"),
    (DRIVE, "!lode_drive_accept(self, &self->omitted, &self->duty)", "!lode_drive_accept(self, &self->omitted, &duty)"),
    (DRIVE, "!lode_modulator_is_sound(*duty)", "!EVA_BOTH_WITHIN(*duty, self, 1.0f)"),
    # When the duties of set 2 are looked at those of set 1 have been accepted.
    (DRIVE6, "accept(lode_drive6_t *self, lode_abc6_t duty)", "accept(lode_drive6_t *self, const lode_abc6_t *duty)"),
    (DRIVE6, "!accept(self, duty)", "!accept(self, &duty)"),
    (DRIVE6, "!lode_modulator_is_within(duty.set[0], most)", "!EVA_BOTH_WITHIN(duty->set[0], drive, most)"),
    (DRIVE6, "!lode_drive_accept(drive, &drive->omitted, &drive->duty)",
     "!lode_drive_accept(drive, &drive->omitted, &duty->set[0])"),
    (DRIVE6, "lode_modulator_is_within(duty.set[1], most)", "EVA_WITHIN(duty->set[1], most)"),
    (DRIVE6, "lode_drive_accept(drive, &self->omitted_2, &self->duty_2)",
     "lode_drive_accept(drive, &self->omitted_2, &duty->set[1])"),
)
# The sizes above, held by the compiler.
SIZES = ("#include \"lodestar/observer.h\"\n"
         "typedef char numbers[sizeof(lode_observer_numbers_t) == 5 ? 1 : -1];\n"
         "typedef char vectors[sizeof(lode_observer_vectors_t) == 3 ? 1 : -1];\n")
# Not part of the step: what a host or a thread reads.
LEFT_OUT = ("wire.c", "fault_log.c")


def rewritten(root, tree):
    shutil.rmtree(tree, ignore_errors=True)
    for name in ("src", "include", "tests/eva"):
        shutil.copytree(root / name, tree / name)
    for file, old, new in REWRITTEN:
        text = (tree / file).read_text()
        if text.count(old) != 1:
            sys.exit(f"{file}: expected once, for {__file__}: {old}")
        (tree / file).write_text(text.replace(old, new))


def shell(command, **more):
    return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          **more)


def bits_agree(root, folder):
    """Over all floats."""
    program = folder / "bits"
    for command in (["cc", "-std=c99", "-O2", f"-I{root / 'include'}", f"-I{root / 'src'}", root / "tests/eva/bits.c",
                     "-o", program, "-lm"], [program]):
        done = shell(command)
        print(done.stdout, end="")
        if done.returncode:
            return False
    return True


def sizes_fit(root):
    done = shell(["cc", "-std=c99", "-fsyntax-only", f"-I{root / 'include'}", "-x", "c", "-"], input=SIZES)
    print(done.stdout, end="")
    return done.returncode == 0


def alarms_of(log):
    """Each with the lines that belong to it."""
    return ["\n".join(line.rstrip() for line in match.splitlines())
            for match in re.findall(r"^\[eva:alarm\] .*(?:\n  .*)*", log, re.MULTILINE)]


def judge(log):
    alarms = sorted(set(alarms_of(log)))
    print("".join(f"{alarm}\n" for alarm in alarms), end="")
    done = re.search(r"(\d+) functions analyzed", log)
    reached = re.search(r"(\d+) statements reached \(out of (\d+)\)", log)
    proven = re.search(r"Assertions +(\d+) valid +(\d+) unknown +(\d+) invalid", log)
    if "done for function main" not in log or not done or not reached or not proven:
        print("the analysis did not end")
        return 1
    print(f"{done[1]} functions, {reached[1]} of their {reached[2]} statements reached; {proven[1]} assertions proven, "
          f"{int(proven[2]) + int(proven[3])} not; {len(alarms)} alarms")
    return 0 if not alarms and int(proven[2]) + int(proven[3]) == 0 and int(proven[1]) > 0 else 1


def analysed(driver, sources, preprocessor, tree, log):
    """True: all of it is proven."""
    # Frama-C finds the sources by PWD, its preprocessor by where it is.
    done = shell(["frama-c", f"-cpp-extra-args={preprocessor}", f"tests/eva/{driver}", *sources, "-eva", *FLAGS], cwd=tree,
                 env={**os.environ, "PWD": str(tree)})
    log.write_text(done.stdout)
    if done.returncode:
        print(done.stdout[-3000:])
        return False
    print(f"{driver}:")
    return judge(done.stdout) == 0


def main():
    if shutil.which("frama-c") is None:
        print("skipped: no frama-c")
        return 77
    root, folder = (pathlib.Path(name).resolve() for name in sys.argv[1:3])
    full = os.environ.get("LODE_TEST_FULL") == "1"
    tree = folder / "tree"
    rewritten(root, tree)
    if not sizes_fit(root) or (full and not bits_agree(root, folder)):
        return 1
    sources = sorted(f"src/{path.name}" for path in (tree / "src").glob("*.c") if path.name not in LEFT_OUT)
    preprocessor = CPP if full else f"{CPP} -DEVA_PLAIN"
    good = [analysed(driver, sources, preprocessor, tree, folder / f"{driver}.log") for driver in ("step.c", "step6.c")]
    return 0 if all(good) else 1


sys.exit(main())
