"""usage: papers_page.py ROOT JIANG.json LI.json [write]: docs/papers.md from two runs of `lodestar reproduce`.

The page is tests/tools/papers_page.md with figures in its slots and the tables of all claims. Without
`write` it is compared with what is there. Runs with fewer seeds than the page's have the same columns but
not the same verdicts: then a verdict may only not be the opposite. `tests/run figures` writes it too.

Slots: {{j ID COLUMN DIGITS}} a figure of paper 1's run, {{l ...}} of paper 2's; with a fifth word abs
without its sign. {{seeds j}}, {{count j}} and {{rows j}} stand for the seeds, the number of verdicts and
the tables.
"""
import json
import pathlib
import re
import sys

PAGE = "docs/papers.md"
TEMPLATE = "tests/tools/papers_page.md"
SLOT = re.compile(r"\{\{([^{}]+)\}\}")
NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?")
COUNTED = ("reproduced", "contradicted", "depends", "not comparable")
# Where the current rests in the dead band the angle hunts, and any change of the arithmetic gives another
# swing, or loses the rotor: these rows are as of the day of the page.
HUNTING = {"fig12", "fig14", "fig16", "fig18", "start", "acceleration", "fig10", "fig11", "load20", "load80"}
# And shares of what is next to nothing.
HUNTING_ROWS = ("fig15_fa_per_",)


def count(run):
    """How many claims have each verdict; identities are not counted."""
    verdicts = [row["verdict"] for row in run["rows"]]
    found = {name: verdicts.count(name) for name in COUNTED}
    return {"claims": sum(found.values()), **found}


def count_text(found):
    """`found`: what count() gives."""
    return (f"{found['claims']} claims: {found['reproduced']} reproduced, {found['contradicted']} contradicted, "
            f"{found['depends']} depend on what the paper leaves open, {found['not comparable']} not comparable")


def figure(value, digits):
    if isinstance(value, str):
        return value
    if value is None:
        return ""
    text = f"{value:.{digits}f}"
    return text.replace("-", "−" if float(text) != 0.0 else "")


def cell(value):
    return figure(value, 2 if value is None or isinstance(value, str) or abs(value) < 99.95 else 1)


def claimed(row):
    marks = {"none": "", "about": "~", "size": "~ ±", "at most": "≤ ", "at least": "≥ ", "exactly": "", "formula": ""}
    if row["claim"] == "none":
        return ""
    text = f"{marks[row['claim']]}{row['claimed']:.4g}".replace("-", "−")
    return text + (f" (+{row['reading']:g})" if row["reading"] and row["claim"] == "at most" else "")


def verdict(row):
    if not row["verdict"]:
        return ""
    share = f" ({row['held']} of {row['of']})" if row["of"] else ""
    why = f": {row['why']}" if row["why"] else ""
    return f"**{row['verdict']}**{share}{why}".replace("|", "\\|")


# What the tool calls its columns on the screen.
HEADINGS = {"as_printed": "printed", "as_printed_dead_time_corrected": "printed, corrected", "exact": "exact",
            "corrected": "corrected", "own_gains": "own gains", "as_printed_dead_time": "printed, dead time",
            "exact_uncompensated": "exact raw", "as_printed_qpll": "printed, QPLL"}


def tables(run):
    """One per figure of the paper: lines, each with whether it is as of its day only."""
    columns = [key for key in run["rows"][0] if key in HEADINGS]
    for part in run["figures"]:
        hunts = part["figure"] in HUNTING
        yield f"**{part['title']}**", False
        yield "", False
        note = " ".join(part["note"].split())
        if note:
            yield from ((note, False), ("", False))
        yield "| | paper | theory | " + " | ".join(HEADINGS[key] for key in columns) + " | verdict |", False
        yield "|---" * (len(columns) + 4) + "|", False
        for row in (row for row in run["rows"] if row["figure"] == part["figure"]):
            unit = f", {row['unit']}" if row["unit"] else ""
            yield (f"| {row['what']}{unit} | {claimed(row)} | {cell(row['theory'])} | " +
                   " | ".join(cell(row[key]) for key in columns) + f" | {verdict(row)} |").replace("  ", " "), \
                hunts or row["id"].startswith(HUNTING_ROWS)
        yield "", False


def filled(slot, runs):
    words = slot.split()
    if words[0] in ("seeds", "count"):
        run = runs[words[1]]
        return f"{run['first_seed']} to {run['first_seed'] + run['seeds'] - 1}" if words[0] == "seeds" else \
            count_text(count(run))
    row = next((row for row in runs[words[0]]["rows"] if row["id"] == words[1]), None)
    if row is None or words[2] not in row:
        sys.exit(f"{TEMPLATE}: {{{{{slot}}}}}: expected a row and a column of the run")
    value = row[words[2]]
    return figure(abs(value) if "abs" in words and isinstance(value, float) else value, int(words[3]))


def page(root, jiang, li):
    """Its lines, each with whether it is as of its day only."""
    runs = {"j": jiang, "l": li}
    for line in pathlib.Path(root, TEMPLATE).read_text().splitlines():
        slots = SLOT.findall(line)
        if slots and slots[0].startswith("rows "):
            yield from list(tables(runs[slots[0].split()[1]]))[:-1]
            continue
        hunts = any(slot.startswith(("seeds", "count")) or slot.split()[1].split("_")[0] in HUNTING for slot in slots)
        yield SLOT.sub(lambda m: filled(m[1], runs), line), hunts


def write(root, jiang, li):
    pathlib.Path(root, PAGE).write_text("\n".join(line for line, _ in page(root, jiang, li)) + "\n")


# ---- Comparison ---------------------------------------------------------------------------------

def near(is_, should):
    """The same text, with figures to one unit of their last digit."""
    if NUMBER.sub("#", is_) != NUMBER.sub("#", should):
        return False
    for a, b in zip(NUMBER.findall(is_), NUMBER.findall(should)):
        digits = len(b.partition(".")[2])
        if abs(float(a.replace("−", "-")) - float(b.replace("−", "-"))) > 1.0001 * 10.0 ** -digits:
            return False
    return True


def without_verdict(line):
    return line.rpartition(" | ")[0] if line.startswith("| ") else line


def opposite(is_, should):
    return any(f"**{a}**" in is_ and f"**{b}**" in should
               for a, b in (("reproduced", "contradicted"), ("contradicted", "reproduced")))


def problems(root, jiang, li):
    """Yields what of the page is not as the runs have it."""
    is_, should = pathlib.Path(root, PAGE).read_text().splitlines(), list(page(root, jiang, li))
    if len(is_) != len(should):
        yield f"{PAGE}: {len(is_)} lines, expected {len(should)}; tests/tools/papers_page.py writes it"
        return
    for number, (a, (b, hunts)) in enumerate(zip(is_, should), 1):
        if opposite(a, b) or not (hunts or near(without_verdict(a), without_verdict(b))):
            yield f"{PAGE}:{number}: '{a[:200]}', the run gave '{b[:200]}'"


def main(root, jiang, li, what=None):
    runs = [json.loads(pathlib.Path(name).read_text()) for name in (jiang, li)]
    if what == "write":
        write(root, *runs)
        return 0
    found = list(problems(root, *runs))
    for text in found:
        print(text)
    return 1 if found else 0


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
