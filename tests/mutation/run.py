"""usage: run.py ROOT FOLDER [--sample N] [--seed S] [--only REGEX] [--again JSON] [--tests REGEX] [--jobs N] [--json FILE] [--list] [--check]

Mutation test of src/ and include/ against the unit tests, tests/test_*.c. FOLDER keeps the build. Of all
mutants N are drawn (0: all) with seed S; with --only, of those in whose name it is found; with
--again, of those that lived in the run that wrote JSON. Each is run with the tests that reach it, one by one, the quickest
first, until one fails; with --tests, with those of the programs in whose name it is found, for a quick look at one room. Exit 1 if fewer than KILLED_MIN of those that
are not equivalent are killed, or more than 3 % are declared equivalent (tests/mutation/equivalent.txt: key and
reason). --check, and any run without LODE_TEST_FULL=1 or one of these options: compiles the sources with
every mutant in them, and no more.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import time

import mutants

KILLED_MIN = 0.98  # reached by two fresh samples
EQUIVALENT_MAX = 0.03
# What the build takes as it is; src and include come with mutants, and tests includes some of them as ../src.
LINKED = ("CMakeLists.txt", "sim", "port")
COPIED = ("src", "include", "tests")
FLAGS = "-w -O1 -fsanitize=bounds-strict -fsanitize-undefined-trap-on-error"


def fresh_tree(root, folder):
    tree = folder / "tree"
    shutil.rmtree(folder, ignore_errors=True)
    tree.mkdir(parents=True)
    for name in LINKED:
        if (root / name).exists():
            (tree / name).symlink_to(root / name)
    for name in COPIED:
        shutil.copytree(root / name, tree / name)
    return tree


def run(command, log, **more):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    if done.returncode:
        log.write_text(done.stdout)
    return done


def build(root, folder, chosen, tests):
    """Names of the unit tests' programs, built with the mutants."""
    tree = fresh_tree(root, folder)
    mutants.write(root, tree, chosen)
    for path in (tree / "tests").glob("test_*.c"):
        path.write_text(path.read_text().replace("RUN_TEST(", "LODE_RUN_TEST("))
    names = sorted(path.stem for path in (root / "tests").glob("test_*.c") if re.search(tests, path.stem))
    out = folder / "build"
    flags = f"{FLAGS} -include {tree}/mutant.h"
    for command in (["cmake", "-S", tree, "-B", out, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None", f"-DCMAKE_C_FLAGS={flags}",
                     "-DLODE_BUILD_TESTS=ON", "-DLODE_BUILD_GATES=OFF", "-DLODE_WERROR=OFF"],
                    ["cmake", "--build", out, "--target", *names]):
        done = run([str(word) for word in command], folder / "log")
        if done.returncode:
            sys.exit(f"{done.stdout[-3000:]}\nthe mutants do not build, see {folder / 'log'}")
    return {name: out / "tests" / name for name in names}


def check(root, folder, every):
    """Compiles every source with every mutant. Exit code."""
    tree = fresh_tree(root, folder)
    mutants.write(root, tree, {m: k for k, m in enumerate(every)})
    good = True
    for path in sorted((tree / "src").glob("*.c")):
        done = run(["cc", "-std=c99", "-w", "-fsyntax-only", "-include", str(tree / "mutant.h"), "-I", str(tree / "include"),
                    "-I", str(tree / "src"), str(path)], folder / "log")
        good = good and done.returncode == 0
        print(done.stdout, end="")
    print(f"{len(every)} mutants, {'all of them C' if good else 'not all of them C'}")
    return 0 if good else 1


def run_test(test, number, timeout_s, reached=None):
    """(killed, seconds) of one test: (program, its name)."""
    program, name = test
    env = {**os.environ, "LODE_MUTANT": str(number), "LODE_TEST": name}
    if reached:
        env["LODE_REACHED"] = str(reached)
    start = time.monotonic()
    try:
        done = subprocess.run([program], cwd=program.parent, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              timeout=timeout_s)
        killed = done.returncode != 0
    except subprocess.TimeoutExpired:
        killed = True
    return killed, time.monotonic() - start


def tests_of(program):
    """Every test of a program, each to be run alone."""
    done = subprocess.run([program], cwd=program.parent, env={**os.environ, "LODE_LIST": "1"}, stdout=subprocess.PIPE, text=True)
    return [(program, line.split()[1]) for line in done.stdout.splitlines() if line.startswith("LODE_LIST ")]


def reach(programs, folder, workers):
    """{test: (seconds, numbers of the mutants that it reaches)} of a run without a mutant, of each test alone."""
    def one(test):
        file = folder / f"{test[0].name}.{test[1]}.reached"
        failed, took_s = run_test(test, -1, 900, file)
        if failed:
            sys.exit(f"{test[0].name}: {test[1]} fails without a mutant")
        return test, (took_s, {k for k, byte in enumerate(file.read_bytes()) if byte})

    return dict(workers.map(one, [test for program in programs.values() for test in tests_of(program)]))


def judge(number, seen):
    """The test that kills a mutant; '': none reaches it; None: it lives."""
    by_time = sorted((took_s, test) for test, (took_s, numbers) in seen.items() if number in numbers)
    for took_s, test in by_time:
        if run_test(test, number, 10 * took_s + 5)[0]:
            return f"{test[0].name}: {test[1]}"
    return None if by_time else ""


def equivalents(root):
    """{key: reason} of the mutants that change nothing."""
    path = root / "tests/mutation/equivalent.txt"
    found = {}
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.strip() and not line.startswith("#"):
            key, _, reason = line.rpartition(" | ")
            if not key or not reason:
                sys.exit(f"{path}:{number}: expected 'file | change | source line | [function |] reason'")
            found[key] = reason
    return found


def options():
    parser = argparse.ArgumentParser(usage=__doc__.replace("%", "%%"))
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--sample", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--again", type=pathlib.Path)
    parser.add_argument("--tests", default="")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--check", action="store_true")
    args = parser.parse_args()
    args.check |= args.sample is None and not args.only and not args.list and os.environ.get("LODE_TEST_FULL") != "1"
    args.sample = 500 if args.sample is None else args.sample
    return args


def drawn(args):
    every = mutants.all_mutants(args.root)
    for key in sorted(set(equivalents(args.root)) - {m.key() for m in every}):
        sys.exit(f"tests/mutation/equivalent.txt: there is no mutant '{key}'")
    every = [m for m in every if re.search(args.only, m.name())]
    if args.again:
        lived = set(json.loads(args.again.read_text())["live_keys"])
        every = [m for m in every if m.key() in lived]
    chosen = every if args.sample == 0 else random.Random(args.seed).sample(every, min(args.sample, len(every)))
    return every, {m: k for k, m in enumerate(sorted(chosen, key=lambda m: (m.file, m.start, m.change)))}


def report(args, total, chosen, killer, took_s):
    reasons = equivalents(args.root)
    alive = [m for m, k in chosen.items() if not killer[k]]
    equal = [m for m in alive if m.key() in reasons]
    real = [m for m in alive if m.key() not in reasons]
    killed = len(chosen) - len(alive)
    rate = killed / max(1, len(chosen) - len(equal))
    for m in equal:
        print(f"equivalent: {m.name()}: {reasons[m.key()]}")
    for kind in sorted({m.kind for m in chosen}):
        of = [m for m in chosen if m.kind == kind]
        print(f"{kind}: {sum(m not in alive for m in of)} of {len(of)} killed")
    print(f"{len(chosen)} of {total} mutants, seed {args.seed}: {killed} killed, {len(equal)} equivalent, {len(real)} live; "
          f"{100 * rate:.1f} % of those that are not equivalent are killed; {took_s:.0f} s")
    if args.json:
        args.json.write_text(json.dumps({
            "mutants": total, "drawn": len(chosen), "seed": args.seed, "killed": killed, "rate": rate,
            "live": [m.name() for m in real], "live_keys": [m.key() for m in real], "equivalent": {m.name(): reasons[m.key()] for m in equal},
            "killers": {m.name(): killer[k] for m, k in chosen.items()}}, indent=1) + "\n")
    return 0 if rate >= KILLED_MIN and len(equal) <= EQUIVALENT_MAX * len(chosen) else 1


def main():
    args = options()
    args.root, args.folder = args.root.resolve(), args.folder.resolve()
    every, chosen = drawn(args)
    if args.list:
        print("\n".join(m.name() for m in chosen))
        return 0
    if args.check:
        return check(args.root, args.folder, every)
    start = time.monotonic()
    programs = build(args.root, args.folder, chosen, args.tests)
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as workers:
        seen = reach(programs, args.folder, workers)
        print(f"built; the tests take {sum(s for s, _ in seen.values()):.0f} s", flush=True)
        killer = {}
        for mutant, killed_by in zip(chosen, workers.map(lambda k: judge(k, seen), chosen.values())):
            killer[chosen[mutant]] = killed_by
            if not killed_by:
                print(f"{'lives' if killed_by is None else 'not reached'}: {mutant.name()}", flush=True)
    return report(args, len(every), chosen, killer, time.monotonic() - start)


sys.exit(main())
