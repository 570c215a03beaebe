"""Pictures: which kinds of files there are, and that no line is drawn where there is no data."""
import csv
import html.parser
import re
import shutil
import struct
import sys
import pathlib
import xml.dom.minidom

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, RECORDINGS, Checks, Folder, refused

SCENARIO = (f"; Twice <b>&amp; \"once\"\n[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\nlog_s = 1e-3\n"
            "[phase.first]\nduration_s = 2\nspeed_rpm = 450\nload_Nm = 1\nmode = run\n"
            "[phase.rest]\nduration_s = 1\nmode = off\nload_Nm = 2\n"
            "[phase.second]\nduration_s = 2\nmode = run\nload_Nm = 1\n")
KINDS = {"p.svg": b"<?xml", "p.png": b"\x89PNG\r\n\x1a\n", "p.html": b"<!DOCTYPE html>", "p": b"<?xml"}


def curves(svg):
    """{legend: [[(x, y) ...] ...]}: the unbroken lines of each curve of gnuplot's SVG, in pixels."""
    found = {}
    for group in xml.dom.minidom.parseString(svg).getElementsByTagName("g"):
        titles = [n for n in group.childNodes if n.nodeName == "title"]
        if not titles or not group.getAttribute("id").startswith("gnuplot_plot_"):
            continue
        title = titles[0].firstChild
        lines = []
        for path in group.getElementsByTagName("path"):
            for move in re.findall(r"M([^M]*)", path.getAttribute("d")):
                points = [tuple(map(float, p.split(","))) for p in re.findall(r"[-\d.]+,[-\d.]+", move)]
                if lines and lines[-1][-1] == points[0]:
                    lines[-1] += points[1:]  # gnuplot cuts long paths
                else:
                    lines.append(points)
        name = title.data.replace("\\n", " ").replace("\u00a0", " ") if title else ""
        found.setdefault(name, []).extend(lines[1:])  # the first one is the legend's
    return found


def steps(lines, axis):
    """Lengths of the lines' segments along an axis, pixels."""
    return [abs(b[axis] - a[axis]) for line in lines for a, b in zip(line, line[1:])]


class Page(html.parser.HTMLParser):
    """What a page has of each tag, and every attribute that could fetch something."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.fetched, self.text, self.inside = {}, [], {}, ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags[tag] = self.tags.get(tag, 0) + 1
        self.inside = tag
        self.fetched += [value for name, value in attrs
                         if name in ("src", "href", "xlink:href", "data") and not value.startswith("#")]

    def handle_data(self, data):
        self.text[self.inside] = self.text.get(self.inside, "") + data


def kinds(checks, folder):
    for name, magic in KINDS.items():
        done = folder.run("run", "s.ini", "--plot", name)
        checks.equal(done.returncode, 0, f"{name}: exit code, {done.stderr}")
        data = (folder.path / name).read_bytes()
        checks.true(data.startswith(magic), f"{name} begins with {data[:16]!r}")
    data = (folder.path / "p.png").read_bytes()
    checks.equal(struct.unpack(">II", data[16:24]), (2400, 2524), "pixels of the PNG")
    checks.true(data.endswith(b"IEND\xaeB`\x82") and len(data) > 50000, "a whole PNG with something in it")
    text = (folder.path / "p.html").read_text()
    page = Page(text)
    checks.equal([page.tags.get(t, 0) for t in ("html", "svg", "pre", "script", "link", "img", "iframe")],
                 [1, 1, 1, 0, 0, 0, 0], "tags of the page")
    checks.equal(page.fetched, [], "nothing is fetched")
    checks.true("<b>" not in text and "url(" not in text, "no markup out of a file")
    checks.true(page.text["pre"].startswith(str(folder.path / "s.ini")) or "s.ini: " in page.text["pre"],
                "the page has the table")
    checks.true("times real time" in page.text["pre"].strip().splitlines()[-1], "to its last line")
    checks.true(text.rstrip().endswith("</html>"), "a whole page")
    for name in ("p.jpg", "p.pdf", "p.svg.gz", "p.", "p.PNG"):
        refused(checks, folder, ["run", "s.ini", "--plot", name],
                rf"{re.escape(name)}: unknown picture format; expected a name ending in .svg")


def folders(checks, folder):
    for kind, magic in (("png", KINDS["p.png"]), ("html", KINDS["p.html"]), ("svg", KINDS["p.svg"])):
        done = folder.run("analyse", "--plots", kind, "--format", kind)
        checks.equal(done.returncode, 0, f"analyse --format {kind}: exit code, {done.stderr}")
        files = sorted((folder.path / kind).iterdir())
        checks.true(len(files) >= 7 and all(f.name.endswith("." + kind) for f in files), f"{files}")
        checks.true(all(f.read_bytes().startswith(magic) for f in files), f"what {kind} files hold")
        checks.true(all(f"written: {kind}/{f.name}" in done.stdout for f in files), "names on the screen")
    for kind in ("jpg", "", "x/png", "../png"):
        refused(checks, folder, ["analyse", "--plots", "never", "--format", kind],
                f"--format {re.escape(kind)}: expected svg, png or html")


def gaps_of_a_run(checks, folder):
    """Two runs with a rest between them: no estimate is drawn across it."""
    folder.run("run", "s.ini", "--plot", "p.svg")
    found = curves((folder.path / "p.svg").read_bytes())
    width = max(p[0] for line in found["true"] for p in line) - found["true"][0][0][0]
    for name in ("estimated", "estimate - truth", "load, estimated", "raw estimate"):
        lines = found.get(name, [])
        checks.true(len(lines) >= 2, f"{name}: {len(lines)} lines")
        checks.at_most(max(steps(lines, 0), default=0), 0.02 * width, f"{name}: longest stride, pixels")
    checks.at_most(len(found["true"]), 2, "what is there throughout is one line per panel")
    of_load, of_current = ([p[1] for line in found[name] for p in line] for name in ("load", "iq"))
    checks.true(min(of_load) > max(of_current) or max(of_load) < min(of_current), "load has its own axis")


def gaps_of_a_replay(checks, folder):
    with open(RECORDINGS / "steady-300rpm-5Nm.csv", newline="") as file:
        rows = list(csv.reader(file))
    cut = rows[:1000] + rows[1300:]
    folder.write("r.csv", "\n".join(",".join(r) for r in cut) + "\n")
    folder.run("replay", "--motor", MOTOR, "--recording", "r.csv", "--resample", "--plot", "p.svg")
    found = curves((folder.path / "p.svg").read_bytes())
    gap = 300 / (len(rows) - 1)
    for name in ("true", "estimated", "raw estimate", "recorded", "lock"):
        all_x = [p[0] for line in found[name] for p in line]
        checks.equal(len(found[name]), 2, f"{name}: lines before and behind a gap")
        checks.at_most(max(steps(found[name], 0)), 0.5 * gap * (max(all_x) - min(all_x)),
                       f"{name}: longest stride, pixels")


def angles_of_a_record(checks, folder):
    """In RUN, no line from one end of an angle's range to the other; names on the axes of modes."""
    folder.run("run", "s.ini", "--scope", "s.bin", "--channels", "mode,theta_rad,iq_A,v_bus_V",
               "--trigger", "speed_ref_rad_s>30")
    folder.run("decode", "s.bin", "--plot", "p.svg")
    svg = (folder.path / "p.svg").read_bytes()
    found = curves(svg)
    angles = found["theta_rad"]
    height = max(p[1] for line in angles for p in line) - min(p[1] for line in angles for p in line)
    checks.true(len(angles) >= 3, f"{len(angles)} turns")
    checks.at_most(max(steps(angles, 1)), 0.1 * height, "steepest stride of the angle, pixels")
    checks.equal(len(found["iq_A"]), 1, "other channels do not break")
    texts = [t.firstChild.data for n in xml.dom.minidom.parseString(svg).getElementsByTagName("text")
             for t in n.getElementsByTagName("tspan") or [n] if t.firstChild and t.firstChild.nodeType == 3]
    for word in ("RUN", "bus [V]", "A"):
        checks.true(any(word == t.strip().replace("\u00a0", " ") for t in texts), f"{word} in {texts}")


def angles_that_turn_fast(checks, folder):
    """All of a range is filled where lines of turns would run together: at 600 to 1500 rpm of 13 s, not at 150 to 300 rpm."""
    folder.run("run", "main", "--ring", "r.bin", "--channels", "theta_rad,omega_rad_s")
    folder.run("decode", "r.bin", "--plot", "r.svg")
    found = curves((folder.path / "r.svg").read_bytes())
    points = [p for line in found["theta_rad"] for p in line]
    left, right = min(p[0] for p in points), max(p[0] for p in points)
    low, high = min(p[1] for p in points), max(p[1] for p in points)
    spans = {}
    for x, y in points:
        t = 13.0 * (x - left) / (right - left)
        if 2.3 < t < 9.9:
            spans.setdefault(int(x), []).append(y)
    least = min((max(ys) - min(ys)) / (high - low) for ys in list(spans.values())[1:-1])
    checks.true(len(spans) > 100 and least > 0.97, f"{len(spans)} columns, the least filled has {least:.3f} of the range")
    slow = [line for line in found["theta_rad"] if 13.0 * (line[0][0] - left) / (right - left) > 10.2]
    checks.true(len(slow) > 10 and max(steps(slow, 1), default=high) < 0.5 * (high - low), f"{len(slow)} lines of slow turns")


def main():
    if shutil.which("gnuplot") is None:
        print("skipped: no gnuplot")
        sys.exit(77)
    checks = Checks()
    with Folder() as folder:
        folder.write("s.ini", SCENARIO)
        kinds(checks, folder)
        folders(checks, folder)
        gaps_of_a_run(checks, folder)
        gaps_of_a_replay(checks, folder)
        angles_of_a_record(checks, folder)
        angles_that_turn_fast(checks, folder)
    checks.done()


main()
