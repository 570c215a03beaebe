"""Output files appear complete or not at all: bad paths, full disks, Ctrl-C, no gnuplot."""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import MOTOR, DRIVE, RECORDINGS, SOURCE, TOOL, Checks, Folder, refused

REPLAY = ["replay", "--motor", MOTOR, "--recording", RECORDINGS / "steady-300rpm-5Nm.csv"]
LONG = f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n[phase.a]\nduration_s = 9000\nspeed_rpm = 300\n"


def bad_paths(checks, folder):
    for option in ["--csv", "--json"]:
        refused(checks, folder, ["run", "main", option, "no/such/folder/a"],
                "no/such/folder/a: cannot write: No such file or directory; expected a path in")
        refused(checks, folder, ["run", "main", option, "."], "cannot write: it is a folder")
        refused(checks, folder, ["run", "main", option, ""], "cannot write: the name is empty; expected a path")
    refused(checks, folder, ["run", "main", "--csv", "a", "--json", "a"], "another output of this command has this name")
    refused(checks, folder, [*REPLAY, "--out", "no/o.csv", "--json", "o.json"], "cannot write")
    if os.geteuid() != 0:  # root may write anywhere
        (folder.path / "closed").mkdir(mode=0o500)
        refused(checks, folder, ["run", "main", "--csv", "closed/a"], "Permission denied")
    if pathlib.Path("/dev/full").exists():
        refused(checks, folder, ["run", "main", "--csv", "/dev/full"], "/dev/full: cannot write: .*; expected room")
        refused(checks, folder, [*REPLAY, "--out", "/dev/full", "--json", "never.json"],
                "/dev/full: cannot write")
    done = folder.run(*REPLAY, "--out", "/dev/null")
    checks.equal(done.returncode, 0, "exit code with /dev/null")


def nothing_half_written(checks, folder):
    folder.write("keep.csv", "old")
    refused(checks, folder, ["run", "main", "--csv", "keep.csv", "--json", "no/x"], "cannot write")
    refused(checks, folder, [*REPLAY, "--out", "keep.csv", "--set", "motor.Lq_H=0"], "LODE_ERROR")
    checks.equal((folder.path / "keep.csv").read_text(), "old", "an old file after a refusal")
    checks.equal(folder.run(*REPLAY, "--out", "keep.csv").returncode, 0, "exit code, replacing")
    checks.true((folder.path / "keep.csv").stat().st_size > 1000, "the old file was replaced")
    target = folder.write("target.csv", "old")
    (folder.path / "link.csv").symlink_to("target.csv")
    folder.run(*REPLAY, "--out", "link.csv")
    checks.true((folder.path / "link.csv").is_symlink(), "a link stays a link")
    checks.true(target.stat().st_size > 1000, "and its target is written")
    umask = os.umask(0o027)
    folder.run(*REPLAY, "--out", "mode.csv")
    os.umask(umask)
    checks.equal(oct((folder.path / "mode.csv").stat().st_mode & 0o777), "0o640", "rights by umask")


def plots_are_whole(checks, folder):
    """gnuplot says nothing where it has no room; a part of a picture is not taken for one."""
    commands = [["run", "start"], REPLAY, ["decode", "plots.bin"]]
    folder.run("run", "start", "--ring", "plots.bin")
    folder.run("analyse", "--plots", "pictures")
    *others, last = sorted((folder.path / "pictures").iterdir())
    checks.true(others, "pictures of analyse")
    if pathlib.Path("/dev/full").exists():
        for command in commands:
            done = refused(checks, folder, [*command, "--plot", "/dev/full"],
                           "/dev/full: cannot write: No space left on device")
            checks.true("written" not in done.stdout, f"{command[0]}: not written")
        for path in others:
            path.write_text("old")
        last.unlink()
        last.symlink_to("/dev/full")
        refused(checks, folder, ["analyse", "--plots", "pictures"],
                f"{last.name}: cannot write: No space left on device")
        checks.true(all(path.read_bytes() == b"old" for path in others), "its other pictures stay")
    # As on a disk that is full: no file grows beyond 32 * 512 bytes, gnuplot's neither.
    full = ["sh", "-c", "trap '' XFSZ; ulimit -f 32; exec \"$@\"", "sh", TOOL]
    for command in commands:
        for name in ["plot.svg", "plot.png", "plot.html"]:
            path = folder.write(name, "old")
            done = subprocess.run([*full, *map(str, command), "--plot", name], cwd=folder.path,
                                  capture_output=True, text=True, timeout=300, check=False)
            checks.equal(done.returncode, 2, f"exit code of {command[0]} --plot {name} without room")
            checks.true("gnuplot drew only a part of the plot; expected more space" in done.stderr, f"says {done.stderr!r}")
            checks.true(path.read_bytes() == b"old", f"{command[0]}: {name} stays")


def inputs_stay(checks, folder):
    """No output takes the place of what the command reads, by whatever name; nothing else is written."""
    folder.write("m.ini", MOTOR.read_text())
    folder.write("d.ini", DRIVE.read_text())
    folder.write("r.csv", (RECORDINGS / "steady-300rpm-5Nm.csv").read_text())
    folder.write("s.ini", "[scenario]\nmotor = m.ini\ndrive = d.ini\n[phase.a]\nduration_s = 0.01\n")
    folder.run("run", "s.ini", "--ring", "b.bin")
    folder.run("monte-carlo", "start", "--motors", "jiang2022", "--n", "1", "--json", "c.json")
    (folder.path / "sub").mkdir()
    names = {"m.ini": "m.ini", "./d.ini": "d.ini", "sub/../r.csv": "r.csv", "s.ini": "s.ini",
             str(folder.path / "b.bin"): "b.bin", "soft": "m.ini", "hard": "r.csv", "./c.json": "c.json"}
    (folder.path / "soft").symlink_to("m.ini")
    (folder.path / "hard").hardlink_to(folder.path / "r.csv")
    before = {path: path.read_bytes() for path in folder.path.rglob("*") if path.is_file()}
    run, decode = ["run", "s.ini"], ["decode", "b.bin"]
    replay = ["replay", "--motor", "m.ini", "--drive", "d.ini", "--recording", "r.csv"]
    design = ["design", "--motor", "m.ini", "--drive", "d.ini"]
    for command, options, inputs in [
        (run, ["--csv", "--json", "--plot", "--ring", "--scope"], {"s.ini", "m.ini", "d.ini"}),
        ([*run, "--seeds", "1-2"], ["--json"], {"s.ini", "m.ini", "d.ini"}),
        (replay, ["--out", "--json", "--plot"], {"m.ini", "d.ini", "r.csv"}),
        (["commission", "s.ini"], ["--json", "--out"], {"s.ini", "m.ini", "d.ini"}),
        (["commission", *design[1:]], ["--json", "--out"], {"m.ini", "d.ini"}),
        (["monte-carlo", "merge", "c.json"], ["--json"], {"c.json"}),
        (design, ["--json=", "--c"], {"m.ini", "d.ini"}),
        (["analyse", *design[1:]], ["--csv", "--json"], {"m.ini", "d.ini"}),
        (decode, ["--csv", "--json", "--plot"], {"b.bin"}),
    ]:
        for option in options:
            for name in [name for name, file in names.items() if file in inputs]:
                output = [option + name] if option.endswith("=") else [option, name]
                done = refused(checks, folder, [*command, *output], "it is an input of this command; expected a separate file")
                checks.equal(done.stdout, "", f"{command[0]} {output}: printed before it was refused")
    # The tuning in C has a name of its own, which a link may point to an input.
    (folder.path / "t.c").symlink_to("m.ini")
    refused(checks, folder, [*design, "--c", "t.c"], "t.c: cannot write: it is an input of this command")
    # A figure of `analyse` in the place of the motor's file.
    figure = folder.write("figures/jiang2022-fig4.svg", MOTOR.read_text())
    refused(checks, folder, ["analyse", "--motor", figure, "--drive", "d.ini", "--plots", "figures"],
            "jiang2022-fig4.svg: cannot write: it is an input of this command")
    checks.equal(figure.read_text(), MOTOR.read_text(), "the motor in the place of a figure")
    for one, other in [("new", "./new"), ("new", "sub/../new"), ("r2", "link"), ("r2", "r3")]:
        (folder.path / "r2").write_text("old")
        for path, make in [("link", "symlink_to"), ("r3", "hardlink_to")]:
            (folder.path / path).unlink(missing_ok=True)
            getattr(folder.path / path, make)("r2" if make == "symlink_to" else folder.path / "r2")
        refused(checks, folder, [*replay, "--out", one, "--json", other], "another output of this command has this name")
    for path, data in before.items():
        checks.true(path.read_bytes() == data, f"{path.name}: changed")
    checks.equal([name for name in folder.names() if "tmp" in name or name == "new"], [], "left")


def shipped_files_stay(checks, folder):
    """The same of the tool's own files, which `faults`, `monte-carlo` and `reproduce` read by their names."""
    data = shutil.copytree(SOURCE / "sim/data", folder.path / "data")
    env = {"LODESTAR_DATA": str(data)}
    before = {path: path.read_bytes() for path in data.rglob("*.ini")}
    (folder.path / "own").symlink_to("data/motors/jiang2022.ini")
    names = ["own", "data/motors/jiang2022.ini", "data/drives/jiang2022.ini", "data/plants/jiang2022.ini"]
    paper = ["reproduce", "jiang2022", "--seeds", "1-1"]
    for command, options, inputs in [
        (["faults", "--motors", "jiang2022", "--kinds", "none"], ["--json", "--out"], names),
        (["monte-carlo", "start", "--motors", "jiang2022", "--n", "1"], ["--json"], names),
        (paper, ["--csv", "--json"], [*names, "data/reproduce/jiang2022.ini"]),
        (["reproduce", "li-fa-leso", "--seeds", "1-1"], ["--csv", "--json"], ["data/reproduce/li-fa-leso.ini"]),
    ]:
        for option in options:
            for name in inputs:
                done = refused(checks, folder, [*command, option, name], "it is an input of this command; expected a separate file", env)
                checks.equal(done.stdout, "", f"{command[0]} {option} {name}: printed before it was refused")
    figure = folder.path / "of-paper/fig12.svg"
    figure.parent.mkdir()
    figure.symlink_to(data / "motors/jiang2022.ini")
    refused(checks, folder, [*paper, "--plots", "of-paper"], "it is an input of this command", env)
    for path, content in before.items():
        checks.true(path.read_bytes() == content, f"{path.name}: changed")


def interrupt(checks, folder):
    folder.write("long.ini", LONG)
    folder.write("keep.json", "old")
    for number, code in [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]:
        before = folder.names()
        process = subprocess.Popen(
            [TOOL, "run", "long.ini", "--csv", "new.csv", "--json", "keep.json"], cwd=folder.path,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        deadline = time.monotonic() + 20
        while folder.names() == before and time.monotonic() < deadline:
            time.sleep(0.01)
        checks.true(folder.names() != before, f"signal {number}: under way")
        process.send_signal(number)
        checks.equal(process.wait(timeout=20), code, f"exit code after signal {number}")
        checks.equal(folder.names(), before, f"files after signal {number}")
        checks.equal((folder.path / "keep.json").read_text(), "old", "the old file")


def closed_pipe(checks, folder):
    before = folder.names()
    with subprocess.Popen([TOOL, "run", "start", "--seeds", "1-200", "--json", "c.json"],
                          cwd=folder.path, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL) as process:
        process.stdout.readline()
        process.stdout.close()
        checks.equal(process.wait(timeout=60), 128 + signal.SIGPIPE, "exit code, closed pipe")
    checks.equal(folder.names(), before, "files after a closed pipe")


def campaign(checks, folder):
    """What comes out does not depend on how many processes there are; none of them stays behind."""
    base = ["run", "start", "--seeds", "3-9", "--json", "c.json"]
    alone = folder.run(*base, "--jobs", "1")
    document = (folder.path / "c.json").read_bytes()
    checks.equal(re.findall(r"^seed (\d+)", alone.stdout, re.MULTILINE), list("3456789"), "seeds")
    for jobs in [["--jobs", "2"], ["--jobs", "3"], ["--jobs", "200"], []]:
        done = folder.run(*base, *jobs)
        checks.equal((done.returncode, done.stdout, done.stderr),
                     (alone.returncode, alone.stdout, ""), f"what is printed with {jobs}")
        checks.true((folder.path / "c.json").read_bytes() == document, f"JSON with {jobs}")
    # A seed alone gives the same.
    one = folder.run("run", "start", "--seeds", "5-5").stdout.splitlines()[0]
    checks.equal(one, alone.stdout.splitlines()[2], "seed 5 alone")
    # What no process can do is said once.
    done = refused(checks, folder, ["run", "start", "--seeds", "1-9", "--jobs", "3", "--set",
                                    "drive.duty_max=0.2"], "LODE_ERROR_SENSE_WINDOW")
    checks.equal(len(done.stderr.splitlines()), 1, f"lines of {done.stderr!r}")
    (folder.path / "c.json").unlink()
    before = folder.names()
    with subprocess.Popen([TOOL, "run", "start", "--seeds", "1-5000", "--json", "c.json", "--jobs",
                           "3"], cwd=folder.path, stdout=subprocess.PIPE, text=True,
                          stderr=subprocess.DEVNULL, start_new_session=True) as process:
        process.stdout.readline()
        checks.true(folder.names() != before, "the campaign is under way")
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does on Ctrl-C
        checks.equal(process.wait(timeout=20), 130, "exit code after Ctrl-C")
        process.stdout.read()  # ends when the last process has gone
    checks.equal(folder.names(), before, "files after Ctrl-C in a campaign")


def no_gnuplot(checks, folder):
    (folder.path / "empty").mkdir()
    env = {"PATH": str(folder.path / "empty")}
    done = folder.run(*REPLAY, "--plot", "p.svg", env=env)
    checks.equal(done.returncode, 2, "exit code, --plot without gnuplot")
    checks.true("expected it to be installed" in done.stderr, f"says {done.stderr!r}")
    checks.true(not (folder.path / "p.svg").exists(), "no file")
    done = folder.run(env=env)
    checks.equal(done.returncode, 0, f"main job without gnuplot: {done.stderr}")
    checks.true("gnuplot" in done.stderr, "the main job says that there is no plot")
    checks.true((folder.path / "lodestar-out/main.json").exists(), "and writes the rest")
    checks.equal(sorted(p.name for p in (folder.path / "lodestar-out").iterdir()),
                 ["main.csv", "main.json"], "no leftovers")
    # One that fails.
    broken = folder.write("empty/gnuplot", "#!/bin/sh\ntest \"$1\" = --version && exit 0\nexit 1\n")
    broken.chmod(0o755)
    done = folder.run(*REPLAY, "--plot", "p.svg", "--json", "q.json",
                      env={"PATH": f"{folder.path}/empty:{os.environ['PATH']}"})
    checks.equal(done.returncode, 2, "exit code, gnuplot fails")
    checks.true("gnuplot failed" in done.stderr, f"says {done.stderr!r}")
    checks.true(not {"p.svg", "q.json"} & set(folder.names()), "no file")


def main():
    checks = Checks()
    with Folder() as folder:
        bad_paths(checks, folder)
        nothing_half_written(checks, folder)
        plots_are_whole(checks, folder)
        inputs_stay(checks, folder)
        shipped_files_stay(checks, folder)
        interrupt(checks, folder)
        closed_pipe(checks, folder)
        campaign(checks, folder)
        no_gnuplot(checks, folder)
    checks.done()


main()
