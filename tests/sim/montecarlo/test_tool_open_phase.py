"""`lodestar monte-carlo open-phase`: what breaks in RUN is found, whichever phase, at any moment, speed and load."""
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import FULL, SOURCE, Checks, Folder


def campaign(checks, folder):
    done = folder.run("monte-carlo", "open-phase", "--n", 60 if FULL else 4, "--json", "m.json")
    print(done.stdout[done.stdout.rindex("all  "):])
    text = (folder.path / "m.json").read_text()
    rows = json.loads(text)["rows"]
    late = [row for row in rows if row["result"] == "fail"]
    for row in rows:
        checks.true(row["found_ms"] is not None, f"found within a second: {row}")
    checks.true(len(late) <= 0.03 * len(rows), f"{len(late)} of {len(rows)} late")
    longest = max(row["found_ms"] or 0.0 for row in rows)
    checks.true(f"{longest:.1f} ms at most" in done.stdout, f"{longest} in {done.stdout}")
    again = folder.run("monte-carlo", "merge", "m.json", "--json", "again.json")
    checks.true(done.stdout.replace("m.json", "again.json").endswith(again.stdout), f"merged: {again.stdout}{again.stderr}")
    checks.equal((folder.path / "again.json").read_text(), text, "the file, merged")


def goes_on(checks, folder):
    done = folder.run("monte-carlo", "open-phase", "--motors", "ultrazohm6,eldeeb2017", "--n", 60 if FULL else 3,
                      "--set", "guard.open_phase=go-on")
    checks.equal(done.returncode, 0, f"what goes on drives on: {done.stdout}")


def before_the_proof(checks, folder):
    """A wire that breaks 0.1 s after the hand-over: the gates go off at once, and the next attempt names it."""
    for name, rpm, load_Nm in [("jiang2022", 600, 1.5), ("traction_100kW", 1000, 20), ("compressor_310V", 900, 0.6)]:
        def run(duration_s, wire):
            folder.write("b.ini", f"[scenario]\nmotor = {SOURCE}/sim/data/motors/{name}.ini\ndrive = {SOURCE}/sim/data/drives/{name}.ini\n"
                                  f"[phase.start]\nduration_s = {duration_s}\nspeed_rpm = {rpm}\nload_Nm = {load_Nm}\n{wire}")
            folder.run("run", "b.ini", "--json", "b.json", "--set", "plant.load_kind=passive", "--set", "plant.i_noise_share=0.003")
            return folder.json("b.json")

        broken_s = run(5, "")["handover_s"] + 0.1
        for phase in "abc":
            result = run(broken_s, f"[phase.broken]\nduration_s = 3\nopen_phase = {phase}1\n")
            off = [event["t_s"] for event in result["events"] if event["text"] in ("RUN -> OFF", "RUN -> FAULT")]
            checks.true(off and off[0] - broken_s <= 0.05, f"{name} {phase}: gates off, {result['events']}")
            checks.true(result["fault"] and result["fault"]["check"] == "LODE_CHECK_OPEN_PHASE", f"{name} {phase}: {result['events']}")


def nothing_looks(checks, folder):
    none = folder.run("monte-carlo", "open-phase", "--motors", "jiang2022", "--n", 8, "--set", "guard.plausibility=off")
    checks.equal(none.returncode, 1, "exit code")
    for words in ("silent: not found, a dead high switch", "found late, a dead high switch", "at most"):
        checks.true(words in none.stdout, f"'{words}' in {none.stdout}")


def main():
    checks = Checks()
    with Folder() as folder:
        campaign(checks, folder)
        goes_on(checks, folder)
        before_the_proof(checks, folder)
        nothing_looks(checks, folder)
    checks.done()


main()
