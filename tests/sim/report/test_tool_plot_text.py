"""Names out of files and of files reach pictures, generated C, printed commands and tables as text only: nothing in them is run."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import xml.dom.minidom

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, RECORDINGS, SOURCE, TOOL, Checks, Folder, refused

# What gnuplot's shells, strings, commands, enhanced text and XML make something of. A phase's name
# has at most 31 characters and ends at a bracket, a file's name has no slash.
TEXTS = ["`touch ran`", "$(touch ran)", "\" `touch ran`", "' . system(\"touch ran\") . '",
         "\"; system('touch ran'); x=\"", "a\\\"`touch ran`", "!touch ran", "@x", "%s%n", "a\\", "\\n",
         "it's", "''", "x^2_{3}", "{/Symbol a}", "&amp;<b>", "µ Ω"]
FILES_ONLY = ["a\n!touch ran\n", "a\"\n!touch ran\n#", "a'\nsystem(\"touch ran\")\n#", "a\r!touch ran\r",
              "a\x01b\x7f", b"a\xff\xc3(b\xed\xa0\x80", "x" * 200]


def shown(svg):
    """All text of a picture, one string per text element."""
    document = xml.dom.minidom.parseString(svg.read_bytes())

    def text(node):
        return node.data if node.nodeType == node.TEXT_NODE else "".join(map(text, node.childNodes))

    return [text(node).strip().replace("\u00a0", " ") for node in document.getElementsByTagName("text")]


def drawn(checks, folder, what, arguments):
    """The texts of the picture p.svg that these arguments draw, after which nothing else was made."""
    before = set(folder.names())
    done = subprocess.run([TOOL, *arguments, "--plot", "p.svg"], cwd=folder.path, capture_output=True,
                          stdin=subprocess.DEVNULL, check=False)
    checks.equal(done.returncode, 0, f"{what}: exit code; {done.stderr[-300:]}")
    checks.equal(set(folder.names()) - before, {"p.svg"}, f"{what}: files")
    try:
        texts = shown(folder.path / "p.svg")
    except (OSError, xml.parsers.expat.ExpatError, UnicodeDecodeError) as error:
        checks.true(False, f"{what}: {error}")
        texts = []
    (folder.path / "p.svg").unlink(missing_ok=True)
    (folder.path / "ran").unlink(missing_ok=True)
    return texts


def phases(checks, folder):
    """Every text as a phase's name and as the scenario's title; each is shown, a ' as its likeness."""
    names = [text for text in TEXTS if "]" not in text and len(text.encode()) <= 31]
    for name in names:
        folder.write("s.ini", f"; {name}\n[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n"
                              f"[phase.{name}]\nduration_s = 0.01\n")
        texts = drawn(checks, folder, f"phase {name!r}", ["run", "s.ini"])
        checks.equal(texts.count(name.replace("'", "\u2019")), 2, f"title and phase {name!r}, in {texts[:8]}")


def titles(checks, folder):
    """Of a motor or a scenario without a comment in its first line, or with an empty one: the file's name."""
    motor = MOTOR.read_text().split("\n", 1)[1] + DRIVE.read_text().split("\n", 1)[1]
    for begin, title in (("", "my servo.ini"), (";\n", "my servo.ini"), ("; Mine\n", "Mine")):
        folder.write("sub/my servo.ini", begin + motor)
        texts = drawn(checks, folder, f"a motor that begins {begin!r}", ["run", "--motor", "sub/my servo.ini"])
        checks.equal(texts.count(title), 1, f"title {title!r}, in {texts[:8]}")
    folder.write("s.ini", f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n[phase.a]\nduration_s = 0.01\n")
    checks.equal(drawn(checks, folder, "a scenario without a title", ["run", "s.ini"]).count("s.ini"), 1, "its name")
    subprocess.run([TOOL, "run", "s.ini", "--plot", "p.html"], cwd=folder.path, capture_output=True, check=False)
    checks.true("<title>s.ini</title>" in (folder.path / "p.html").read_text(), "title of a page")
    (folder.path / "p.html").unlink()


def recordings(checks, folder):
    """The title of a replay's picture is its recording's file name: control characters are blanks."""
    lines = (RECORDINGS / "steady-300rpm-5Nm.csv").read_bytes().splitlines(keepends=True)
    for name in [*(text for text in TEXTS if "/" not in text), *FILES_ONLY]:
        path = folder.path / (name.decode("utf-8", "surrogateescape") if isinstance(name, bytes) else name)
        path.write_bytes(b"".join(lines[:400]))
        texts = drawn(checks, folder, f"recording {name!r}", ["replay", "--motor", MOTOR, "--recording", path])
        if isinstance(name, str):
            wanted = " ".join(re.sub(r"[\x00-\x1f\x7f]", " ", name).replace("'", "\u2019").split())
            checks.true(wanted in [" ".join(text.split()) for text in texts], f"{wanted!r} in {texts[:3]}")
        path.unlink()


def records(checks, folder):
    """The same of what is decoded: the title is the path."""
    folder.run("run", "main", "--ring", "ring.bin", "--set", "phase.start.duration_s=0.1")
    data = (folder.path / "ring.bin").read_bytes()[:20000]
    for name in ["`touch ran`", "a\"\n!touch ran\n#", "a'\nsystem(\"touch ran\")\n#"]:
        path = folder.write(name, data)
        drawn(checks, folder, f"record {name!r}", ["decode", path.name])
        path.unlink()


def pages(checks, folder):
    """In a page of HTML too a name is text: of its title, of the picture, of the table."""
    name = "<i>&`touch ran`</title>'\\"
    folder.write("s.ini", f"; {name}\n[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n"
                          f"[phase.{name}]\nduration_s = 0.01\n")
    before = set(folder.names())
    done = folder.run("run", "s.ini", "--plot", "p.html")
    checks.equal((done.returncode, set(folder.names()) - before), (0, {"p.html"}), "exit code and files")
    page = (folder.path / "p.html").read_text()
    checks.true("<i>" not in page and page.count("</title>'") == 0, "a name as mark-up in the page")
    checks.true("<title>&lt;i&gt;&amp;`touch ran`&lt;/title&gt;" in page, f"title of the page: {page[:300]}")
    (folder.path / "p.html").unlink()


def generated_c(checks, folder):
    """The first line of a tuning as C names the motor's file: a line break does not end the comment."""
    path = folder.write("m\n#error from a file name\n.ini", MOTOR.read_text())
    done = folder.run("design", "--motor", path.name, "--drive", DRIVE, "--c", "t.c")
    checks.equal(done.returncode, 0, f"exit code of design --c: {done.stderr}")
    lines = (folder.path / "t.c").read_text().splitlines()
    checks.true("#error from a file name" in lines[0] and lines[0].startswith("//"), f"first line {lines[0]}")


def motor_files(folder):
    """The same motor and drive under each name; a comma would separate names."""
    own = (SOURCE / "sim/data/motors/servo_48V.ini").read_text() + (SOURCE / "sim/data/drives/servo_48V.ini").read_text()
    for name in [*TEXTS, *FILES_ONLY]:
        if isinstance(name, str) and not {"/", ","} & set(name) and len(name) < 100:
            yield folder.write(f"{name}.ini", own)


def commands(checks, folder):
    """The command that repeats a failed case is pasted into a shell: it repeats the case, and runs nothing else."""
    fails = ["--n", "1", "--set", "start.timeout_s=0.2"]
    for path in motor_files(folder):
        before = set(folder.names())
        done = folder.run("monte-carlo", "start", "--motors", path.name, *fails)
        checks.equal(done.returncode, 1, f"a case that fails, {path.name!r}: {done.stderr}")
        checks.true(not re.search(r"[\x00-\x09\x0b-\x1f\x7f]", done.stdout), f"control characters: {done.stdout!r}")
        command = re.search(r" lodestar (monte-carlo start .*)\n", done.stdout)
        checks.true(command, f"a command in {done.stdout!r}")
        for shell in ("sh", "bash") if command else ():
            again = subprocess.run([shell, "-c", f"exec '{TOOL}' {command.group(1)}"], cwd=folder.path, text=True,
                                   capture_output=True, stdin=subprocess.DEVNULL, check=False)
            exact = not re.search(r"[\x00-\x1f\x7f]", path.name)
            checks.true(again.stdout == done.stdout or not exact, f"{command.group(1)!r} again: {again.stderr}")
        checks.equal(set(folder.names()), before, f"files after {path.name!r}")
        path.unlink()
    # Quotes in a setting too; what shells make nothing of stays as it is.
    done = folder.run("monte-carlo", "start", "--motors", "servo_48V", *fails, "--set", "estimator.emf=c-leso", "--json", "m.json")
    checks.true("--motors servo_48V --errors start --n 1 --seed 1 --set 'start.timeout_s=0.2' --set 'estimator.emf=c-leso'\n"
                in done.stdout, f"a plain name: {done.stdout}")
    folder.write("it's a map.csv", "i_d,i_q,psi_d,psi_q\n" + "".join(
        f"{d},{q},{0.02 + 1e-4 * d},{1e-4 * q}\n" for d in (-60, -20, 20, 60) for q in (-60, -20, 20, 60)))
    done = folder.run("monte-carlo", "start", "--motors", "servo_48V", *fails, "--set", "plant.flux_map=it's a map.csv")
    checks.true("--set 'plant.flux_map=it'\\''s a map.csv'\n" in done.stdout, f"a quote in a setting: {done.stdout} {done.stderr}")
    for setting in ("x; touch ran", " --set $(touch ran)", " --set 'a'`touch ran`", " --set 'open", " --set '\x1b'", "x" * 5000):
        folder.write("bad.json", json.dumps({**json.loads((folder.path / "m.json").read_text()), "set": setting}))
        refused(checks, folder, ["monte-carlo", "merge", "bad.json"], "expected a file that monte-carlo --json has written")
    many = [word for _ in range(60) for word in ("--set", "start.timeout_s=0.2" + "0" * 80)]
    refused(checks, folder, ["monte-carlo", "start", "--motors", "servo_48V", "--n", "1", *many], "--set: expected fewer or shorter ones")


def tables(checks, folder):
    """A name is text in the table of `faults`: of Markdown, and of the terminal."""
    for name, heading in (("a|<b>\x1b[31m\x07`x`*.ini", "## a\\|&lt;b&gt; \\[31m \\`x\\`\\*.ini\n"), ("\u00b5_m.ini", "## \u00b5_m.ini\n")):
        path = folder.write(name, (SOURCE / "sim/data/motors/servo_48V.ini").read_text() +
                            (SOURCE / "sim/data/drives/servo_48V.ini").read_text())
        done = folder.run("faults", "--motors", name, "--kinds", "none", "--out", "f.md")
        for text in (done.stdout, (folder.path / "f.md").read_text()):
            checks.true(heading in text and not re.search(r"[\x00-\x09\x0b-\x1f\x7f]", text), f"{heading!r} in {text!r}")
        path.unlink()


def main():
    checks = Checks()
    with Folder() as folder:
        generated_c(checks, folder)
        commands(checks, folder)
        tables(checks, folder)
        if shutil.which("gnuplot"):
            phases(checks, folder)
            titles(checks, folder)
            recordings(checks, folder)
            records(checks, folder)
            pages(checks, folder)
    checks.done()


main()
