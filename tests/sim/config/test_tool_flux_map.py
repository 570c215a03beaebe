"""Flux maps: a map of a linear machine gives that machine's run; a bad map is refused with its line."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, Checks, Folder, refused

HEAD = "i_d,i_q,psi_d,psi_q"


def grid(flux_d=lambda d, q: 0.142 + 3.5e-3 * d, flux_q=lambda d, q: 9.8e-3 * q, d_from=-12, q_from=0):
    """A map over -12 .. 12 A in steps of 3 A, one half plane of i_q unless told."""
    return [HEAD] + [f"{d},{q},{flux_d(d, q):.9g},{flux_q(d, q):.9g}"
                     for d in range(d_from, 13, 3) for q in range(q_from, 13, 3)]


def scenario(folder, lines):
    """A scenario whose plant file, in a folder of its own, names the map relative to itself."""
    pathlib.Path(folder.path, "plants").mkdir(exist_ok=True)
    folder.write("plants/map.csv", "\n".join(lines) + "\n")
    folder.write("plants/p.ini", "[plant]\ninverter = ideal\nflux_map = map.csv\n")
    folder.write("s.ini",
        f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\nplant = plants/p.ini\nlog_s = 0.01\n"
        "[phase.up]\nduration_s = 0.3\nmode = current\nd = 4\nq = 5\n")
    return "s.ini"


def linear(checks, folder):
    straight = grid()
    backwards = [HEAD] + grid(q_from=-12)[:0:-1]  # any order, both half planes
    spaced = ["# a comment", "psi_q;extra;i_d;i_q;psi_d"] + [
        f"{b};x;{d};{q};{a}".replace(".", ",") for d, q, a, b in (row.split(",") for row in straight[1:])]
    texts = []
    for lines in (straight, backwards, spaced):
        done = folder.run("run", scenario(folder, lines), "--csv", "out.csv")
        checks.equal(done.returncode, 0, "a good map runs: " + done.stderr)
        texts.append(pathlib.Path(folder.path, "out.csv").read_text())
    done = folder.run("run", "s.ini", "--csv", "out.csv", "--set", "plant.flux_map=plants/map.csv")
    checks.equal(done.returncode, 0, "--set takes a path from here: " + done.stderr)
    checks.true(texts[0] == texts[1], "any order of the rows, one half plane or both")
    checks.true(texts[0] == texts[2], "decimal commas, other columns, any order of the columns")


def bad(checks, folder):
    good = grid()
    lost = [row for row in good if not row.startswith("3,6,")]
    for lines, pattern in [
        ([], r"map.csv: empty; expected a line with i_d"),
        (["i_d,i_q,psi_d"] + good[1:], r"map.csv:1: no column psi_q; expected a header"),
        ([HEAD], r"map.csv: no rows; expected one for each node"),
        (good + ["3,x,0,0"], r"map.csv:47: i_q = x: expected a number"),
        (good + ["3,3,0"], r"map.csv:47: 3 columns; expected as many as in the header"),
        (good + ["3,3,0,0"], r"map.csv:47: i_d = 3, i_q = 3 is in line 28 too"),
        (lost, r"map.csv: no row with i_d = 3, i_q = -6; expected each of 9 i_d with each of 9 i_q"),
        (grid(d_from=3), r"map.csv: i_d from 3 to 12 A; expected a grid around zero"),
        (grid(d_from=6), r"map.csv: 3 values of i_d; expected a grid with 4"),
        (grid(flux_d=lambda d, q: 0.142 - 3.5e-3 * d), r"map.csv:\d+: expected fluxes that rise"),
        (grid(flux_d=lambda d, q: 0.142 + 3.5e-3 * d - 1e-3 * q, q_from=-12),
         r"map.csv:2: expected dpsi_q/di_d equal to dpsi_d/di_q; found 0.001 H between i_d = -12 and -9"),
        (grid(flux_q=lambda d, q: 9.8e-3 * q + 0.01, q_from=-12), r"expected the magnet's flux on the d axis"),
        (grid(flux_d=lambda d, q: 3.5e-3 * d - 0.142), r"expected the magnet's flux on the d axis"),
    ]:
        refused(checks, folder, ["run", scenario(folder, lines)], pattern)
    refused(checks, folder, ["run", scenario(folder, good), "--set", "plant.flux_map=none.csv"],
            r"none.csv: No such file or directory; expected a CSV file")
    small = [HEAD] + [row for row in good[1:] if max(map(abs, map(int, row.split(",")[:2]))) <= 3]
    small += [f"{d},{q},{0.142 + 3.5e-3 * d},{9.8e-3 * q}" for d in (-3, 0, 3) for q in (1,)]
    small += [f"1,{q},{0.142 + 3.5e-3},{9.8e-3 * q}" for q in (0, 1, 3)]
    refused(checks, folder, ["run", scenario(folder, small)],
            r"flux_map: at .* s the currents were .*expected a map that covers them")


def main():
    checks = Checks()
    with Folder() as folder:
        linear(checks, folder)
        bad(checks, folder)
    checks.done()


main()
