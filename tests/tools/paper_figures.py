"""usage: paper_figures.py ROOT JIANG.json LI.json [write]: figures of the papers' experiments in the docs.

What README.md and docs/papers.md say of a run of `lodestar reproduce` is compared with the JSON that it
writes: each figure to one unit of its last digit. `write` puts today's in.
"""
import json
import pathlib
import re
import sys

SLOT = re.compile(r"\{([012h])\}")  # {0}: without a decimal, {1}, {2}: that many; {h}: a rotor that hunts
HUNTING = 0.3  # where the angle hunts in the dead band, any change of the arithmetic gives another swing
NUMBER = r"([-−]?\d+(?:\.\d+)?|lost|stalls)"


def sentences(jiang, li):
    """(file, text with slots, the values in them). A text is found by all that is not a slot."""
    def j(name, column="as_printed"):
        return jiang["row"][name][column]

    def l(name, column="as_printed"):
        return li["row"][name][column]

    def speeds(figures, observer, column, quantity="mean"):
        return [abs(l(f"{figure}_{observer}_{rpm}_{quantity}", column))
                for figure, rpm in zip(figures, (300, 600, 840))]

    no_load, loaded = ("fig10", "fig11", "fig12"), ("load80",) * 3
    free = speeds(no_load, "fa", "corrected")
    held = speeds(loaded, "fa", "corrected")
    papers, readme = "docs/papers.md", "README.md"
    most = [max(abs(l(f"xy_{kind}_{rpm}", column)) for rpm in (300, 600, 840))
            for kind, column in (("resonator", "exact"), ("resonator", "corrected"))]
    yield readme, "| {0} claims: {0} reproduced, {0} contradicted, each with its reason | `sim/run reproduce jiang2022`", \
        jiang["count"]
    yield readme, "| {0} claims: {0} reproduced, {0} contradicted, each with its reason. FA-LESO at", li["count"]
    yield readme, "with 2 µs of dead time, corrected, at most {1} without load and {1} with 80 %", [max(free), max(held)]
    for rpm, figure in ((300, "fig16"), (1500, "fig17")):
        steps = [j(f"{figure}_{pll}_{rpm}_step", column) for column in ("as_printed", "corrected")
                 for pll in ("qpll", "enhanced")]
        yield papers, f"load 5 → 0 Nm at {rpm} rpm: QPLL / enhanced | {'75 / 18' if rpm == 300 else '8 / 5'} " \
            "| | measured: {1} / {1} as printed, {1} / {1} corrected (c)".replace("{1}", "{h}" if rpm == 300 else "{1}"), \
            steps
    for name, text, theory in (("c", "C-LESO, $\\omega_0 = 500\\pi$, 25 / 50 / 70 Hz | 14 / 23 / 34", True),
                               ("gi", "GI-LESO, the same | 7 / 10 / 12", True)):
        yield papers, text + " | {1} / {1} / {1} | measured: {1} / {1} / {1} (b)", \
            speeds(no_load, name, "theory") + speeds(no_load, name, "as_printed")
    yield papers, "measured: {1} / {1} / {1} in forward Euler, {2} compensated (b)", \
        speeds(no_load, "fa", "as_printed") + [max(speeds(no_load, "fa", "exact"))]
    yield papers, "| {2}, {2} with Table II's gains | measured: {2}, {2}; a $k_2$ of {0} to {0} rad/s", \
        [l(f"fig13_fa_per_c_{n}", column) / 100 for column in ("theory", "exact") for n in (5, 7)] + \
        [l("k2_for_7", "exact"), l("k2_for_5", "exact")]
    yield papers, "\n{0} claims: {0} reproduced, {0} contradicted. Angles in degrees:", li["count"]
    for name, text in (("c", "C-LESO, mean at 25 / 50 / 70 Hz, no load | 14 / 23 / 34"),
                       ("gi", "GI-LESO, the same | 7 / 10 / 12")):
        yield papers, text + " | {1} / {1} / {1} | {2} |", \
            speeds(no_load, name, "as_printed") + [max(speeds(no_load, name, "exact"))]
    yield papers, "≈ 0, pp ≤ 2.3 | {1} / {1} / {1}, pp {1} | {2} |", speeds(no_load, "fa", "as_printed") + \
        [max(speeds(no_load, "fa", "as_printed", "pp")), max(speeds(no_load, "fa", "exact"))]
    yield papers, "80 % load | | | {1} / {1} / {1}, pp ≤ {1}; {1} / {1} / {1}, pp ≤ {1} |", \
        free + [max(speeds(no_load, "fa", "corrected", "pp"))] + \
        held + [max(speeds(loaded, "fa", "corrected", "pp"))]
    yield papers, "| 15, 12 % | {0}, {0} % | {0}, {0} % | contradicted: with Table II's gains (26) gives {0}, {0} %", \
        [l(f"fig13_fa_per_c_{n}", column) for column in ("as_printed", "exact", "theory") for n in (5, 7)]
    ratios = [[l(f"fig{figure}_gi_per_c_{n}", column) for figure in (13, 14) for n in (5, 7)]
              for column in ("as_printed", "exact")]
    yield papers, "| 64 .. 68 % | {0} .. {0} % | {0} .. {0} % |", [end(part) for part in ratios for end in (min, max)]
    yield papers, "| ≤ 4.5, ≤ 13 rpm | {1}, {1} rpm | {2}, {1} rpm; with dead time, corrected {1}, {0} rpm |", \
        [l(f"fig16_fa_{what}", column) for column in ("as_printed", "exact", "corrected")
         for what in ("swing", "rpm")]
    yield papers, "| ≤ 3.2, ≤ 5 rpm | {1}, {0} rpm | {1}, {0} rpm; with $k_2$ = 600 rad/s {1}, {0} rpm; C-LESO {1}, {0} rpm |", \
        [l("fig17_fa_on"), l("fig17_fa_rpm")] + \
        [l(f"fig17_{name}_{what}", "exact") for name in ("fa", "fa_fast", "c") for what in ("on", "rpm")]
    yield papers, '| "significant" | {1}; {1} | {1}; {1} (theory {1}; {1}) |', \
        [l(f"fig18_Lq_{percent}_load_100", column) for column in ("as_printed", "exact", "theory")
         for percent in (50, 150)]
    yield papers, "forward Euler is stable up to {0} Hz only", [l("table1_euler")]
    yield papers, "(36): gain of the C-LESO at 50 Hz | 1 | {2} | {2} | contradicted: (17) gives {2}", \
        [l("table2_c_gain", column) for column in ("as_printed", "exact_uncompensated", "theory")]
    yield papers, "{0} rad/s gives the ratio of the 5th, {0} rad/s that of the 7th ({0} and {0} by theory)", \
        [l(f"k2_for_{n}", column) for column in ("exact", "theory") for n in (5, 7)]
    yield papers, "With Table II's 314 rad/s it turns it by {1}°, with 600 rad/s by {1}°", \
        [l("fig17_fa_on", "exact"), l("fig17_fa_fast_on", "exact")]
    yield papers, "the xy current is at most {2} A, under 1 % of the rated current, with the resonators, and " \
        "{1} / {1} / {1} A with PI controllers alone; behind dead time {1} A at most", \
        [most[0], *(l(f"xy_pi_{rpm}", "exact") for rpm in (300, 600, 840)), most[1]]


def load(path):
    rows = json.loads(pathlib.Path(path).read_text())["rows"]
    verdicts = [row["verdict"].split(",")[0] for row in rows if row["claim"] != "none"]
    return {"row": {row["id"]: row for row in rows},
            "count": [len(verdicts), verdicts.count("reproduced"), verdicts.count("contradicted")]}


def shown(value, digits, minus="−"):
    if isinstance(value, str):
        return value
    text = f"{value:.{0 if digits == 'h' else digits}f}"
    return text.replace("-", minus if float(text) != 0.0 else "")


def differs(text, value, digits):
    if isinstance(value, str) or text in ("lost", "stalls"):
        return text != value
    slack = HUNTING * abs(value) if digits == "h" else 1.0001 * 10.0 ** -int(digits)
    return abs(float(text.replace("−", "-")) - value) > slack


def problems(root, jiang, li, write=False):
    """Yields what is wrong, after putting it right where that was asked for."""
    texts = {}
    for name, template, values in sentences(jiang, li):
        path = pathlib.Path(root, name)
        text = texts.setdefault(path, path.read_text())
        digits = SLOT.findall(template)
        parts = SLOT.sub("\0", template).split("\0")
        found = list(re.finditer(NUMBER.join(map(re.escape, parts)), text))
        if len(found) != 1 or len(digits) != len(values):
            yield f"{name}: '{template}' with {len(values)} values: {len(found)} times, expected once"
            continue
        for number, (value, digit) in enumerate(zip(values, digits), 1):
            if differs(found[0][number], value, digit):
                yield f"{name}: '{found[0][0].strip()[:70]}...': {found[0][number]}, the run gave {value}"
        if write:
            filled = "".join(part + gap for part, gap in zip(parts, [*map(shown, values, digits), ""]))
            texts[path] = text[:found[0].start()] + filled + text[found[0].end():]
    for path, text in texts.items():
        if write:
            path.write_text(text)


def main(root, jiang, li, write=None):
    found = list(problems(root, load(jiang), load(li), write == "write"))
    for text in found:
        print(text)
    return 1 if found and write != "write" else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
