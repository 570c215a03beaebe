"""usage: budget.py write | check | print

write: measures everything and rewrites docs/budget.json and the tables of docs/budget.md; with
       another compiler than theirs it only prints.
check: measures the Cortex-M4F at -O2 and compares; fails where a figure moved by more than 2 %.
print: measures as check does and prints, with any compiler.
Exit code 77: something to measure with is missing.
"""
import json
import sys

import build

try:
    import count
    import places
    import sizes
    from emulator import Image
except ImportError as error:
    print(f"skipped: {error} (tests/run bench tries to install it)")
    sys.exit(77)

DOCS = build.ROOT / "docs"
PAGE, FIGURES = DOCS / "budget.md", DOCS / "budget.json"
REMEDY = "if that is meant, run `tests/run bench` and commit docs/budget.md and docs/budget.json"
TOLERANCE = 0.02
SLACK = 1.0  # in any unit: figures of a few cycles or bytes

WARM, CALLS = 100, 300
RECORDED = 512  # rows of a recording, BENCH_ROWS: of a start every one is counted
# name: warm-up calls, counted calls
STEPS = {
    "c_leso_qpll": (WARM, CALLS),
    **{f"{observer}_leso_qpll": (WARM, CALLS) for _, observer in build.OBSERVERS},
    "enhanced": (WARM, CALLS),
    "all_options": (WARM, CALLS),
    "salient_c_leso_qpll": (WARM, CALLS),
    "salient_enhanced": (WARM, CALLS),
    "board_c_leso_qpll": (WARM, CALLS),
    "board_enhanced": (WARM, CALLS),
    "board_mtpa": (WARM, CALLS),
    "unwatched": (WARM, CALLS),
    "board_unwatched": (WARM, CALLS),
    "injecting": (WARM, CALLS),
    "board_injecting": (WARM, CALLS),
    "fast_speed": (WARM, CALLS),
    "rise": (0, RECORDED),
    "start": (0, RECORDED),
    "saturated": (WARM, CALLS),
    "fault": (190, 30),  # around the trip, from period 200 on
    "off": (WARM, CALLS),
}
# Plausibility checks: what each finds, its setting, its step without it, its state.
CHECKS = [("ADC channels that are stuck, frozen vector", "check_stuck = off", "without_stuck",
           ["lode_plausibility_t", "lode_frozen_t"]),
          ("gains that change at once", "check_gain = off", "without_gain", ["lode_jump_t"]),
          ("phase without a half-wave", "check_half_waves = off", "without_half_waves", ["lode_half_waves_t"]),
          ("sum of the currents", "i_sum_A = none", "without_sum", []),
          ("load beyond all torque", "overload_s = none", "without_overload", ["lode_load_t"]),
          ("flux", "flux_share = none", "without_flux", []),
          ("all of them", "plausibility = off", "unwatched", [])]
WITH_CHECKS = "-DBENCH_CHECKS"
STEPS6 = ["c_leso_qpll", "fa_leso_leso_qpll", "enhanced"]
PHASES = {"steady": "enhanced", "start at standstill": "rise", "start, hand-over": "start",
          "limit of current, of voltage": "saturated", "over-voltage, trip, fault": "fault",
          "off": "off"}
BLOCKS = ["estimator_c_leso_qpll", "estimator_fa_leso_leso_qpll", "estimator_enhanced", "sense",
          "emf_c_leso", "pll", "lag", "speed", "references", "references_mtpa",
          "references_weak_id0", "references_weak_mtpa", "current", "modulator", "guard",
          "modulator6", "xy", "open_phase", "start", "sincos", "atan2", "pi", "sogi",
          "clarke_park", "nothing"]
BLOCK_CALLS = 100
# What the steps were meant to cost on average: figures of a case, what of them, target, bar; what two sets of features that came
# later may add to each bar; and what the step cost before them (commit 61386906).
LATER_CYCLES = 30 + 40
BARS = [("steps", "c_leso_qpll", "cycles", 608, 640, 673),
        ("steps", "fa_leso_leso_qpll", "cycles", 660, 690, 721),
        ("steps", "enhanced", "cycles", 699, 730, 762),
        ("steps", "board_c_leso_qpll", "cycles", 687, 720, 780),
        ("steps", "board_enhanced", "cycles", 779, 815, 869),
        ("steps", "board_mtpa", "cycles", 837, 875, 929),
        ("steps6", "c_leso_qpll", "cycles", 1090, 1135, 1125),
        ("steps6", "fa_leso_leso_qpll", "cycles", None, 1185, 1169),
        ("steps6", "enhanced", "cycles", None, 1230, 1214)]
# Running without a fault: the costliest call over the mean, and the stack.
RUNNING = ["c_leso_qpll", "fa_leso_leso_qpll", "enhanced", "board_c_leso_qpll", "board_enhanced", "board_mtpa",
           "unwatched", "board_unwatched"]
COSTLIEST_SHARE, COSTLIEST_RARE, STACK, LEAST_FLASH = 1.15, 1400, 236, 11500
# 370 and 960, and 60 bytes each for two sets of features that came later.
STATE, STATE_AND_TUNING = 370 + 2 * 60, 960 + 2 * 60
BOUND = [("steps", name) for name in STEPS6] + [("steps6", name) for name in STEPS6]
# Mean cycles of whole steps of other projects, by the same method.
PEERS = {"MESC": 1057, "ODrive 0.5": 1287, "TI eSMO": 1407, "VESC": 2458}
# What an application places in RAM: type, and what else there is to say.
OBJECTS = [("lode_drive_t", ""), ("lode_drive_tuning_t", ", may lie in flash"),
           ("lode_drive_config_t", ", only for init"), ("lode_drive6_t", ""), ("lode_drive6_tuning_t", ""),
           ("lode_drive6_config_t", ", only for init"), ("lode_telemetry_t", ", a row of the fault log"),
           ("lode_adaptation_t", ", with two tunings"), ("lode_adaptation6_t", ", with two tunings"),
           ("lode_commission_t", ", only while it runs"), ("lode_commission6_t", ", only while it runs"),
           ("lode_learn_t", ""), ("lode_fault_log_t", ", besides its rows"),
           ("lode_ring_t", ", besides its buffer"), ("lode_scope_t", ", besides its buffer")]
OBJECT_BUILDS = {"one observer": build.ONE_OBSERVER, "all observers": ()}
LEVELS = ["-Os", "-O2", "-O3"]
COMPARED = ["c_leso_qpll", "fa_leso_leso_qpll", "enhanced"]
OTHER_CORES = ["m7", "m33", "m3", "m0", "r5f"]
CORE_NAMES = {"m4f": "Cortex-M4F", "m7": "Cortex-M7", "m33": "Cortex-M33", "m3": "Cortex-M3",
              "m0": "Cortex-M0", "r5f": "Cortex-R5F"}

# Clocks of the ports, MHz; a Cortex-M3 and a Cortex-M0 as they are usual.
CHIPS = [("STM32G431, G474", "m4f", 170), ("STM32F405", "m4f", 168), ("RP2350", "m33", 150), ("STM32H743", "m7", 400),
         ("AM263x", "r5f", 400), ("without FPU", "m3", 72), ("without FPU", "m0", 48)]
RATES_kHz = [10, 20, 40]
IN_RUN, COSTLIEST = "board_enhanced", ["board_enhanced", "rise", "start", "saturated", "fault"]
ENTRY_CYCLES = 24  # of the interrupt, and its exit


def measure_steps(machine, names, calls=None, of=None):
    steps = {}
    for name in names:
        warm, counted = STEPS[name]
        steps[name] = count.measure(machine, f"bench_step_{name}", "lode_drive_step",
                                    calls or counted, warm,
                                    of=of if name in STEPS6 else None)
    return steps


def measure_steps6(machine, of):
    return {name: count.measure(machine, f"bench_step6_{name}", "lode_drive6_step", CALLS, WARM,
                                of=of) for name in STEPS6}


def measure_m4f(tables):
    machine = count.start(Image(build.image("m4f", "-O2", tables)))
    of = places.Places(machine.image)
    figures = {"steps": measure_steps(machine, STEPS, of=of),
               "steps6": measure_steps6(machine, of),
               "blocks": {name: count.measure(machine, f"bench_{name}", None, BLOCK_CALLS, WARM)
                          for name in BLOCKS}}
    count.check(machine)
    figures["firmware"] = {
        "m4f -O2": sizes.firmware_sizes(build.firmware()),
        "m4f -O2, six phases": sizes.firmware_sizes(build.firmware(phases=6), "lode_drive6_step")}
    figures["objects"] = measure_objects()
    return figures


def measure_objects():
    types, found = [name for name, _ in OBJECTS], {}
    for kind, options in OBJECT_BUILDS.items():
        bytes_of = sizes.object_sizes(build.objects(types, options))
        found[kind] = {name: bytes_of[name] for name in types}
    return found


def measure_checks():
    machine = count.start(Image(build.image("m4f", "-O2", build.recording(WITH_CHECKS), WITH_CHECKS)))
    found = {}
    for _, _, name, types in CHECKS:
        step = count.measure(machine, f"bench_step_{name}", "lode_drive_step", CALLS, WARM)
        found[name] = {"cycles": step["cycles"], "state": sum(sizes.object_sizes(build.objects(types)).values())}
    return found


def measure_others(figures, tables):
    figures["levels"], figures["cores"] = {}, {}
    figures["checks"] = measure_checks()
    for level in LEVELS:
        machine = count.start(Image(build.image("m4f", level, tables)))
        figures["levels"][level] = measure_steps(machine, COMPARED)
        count.check(machine)
    for core in OTHER_CORES:
        machine = count.start(Image(build.image(core, "-O2", tables)), core)
        figures["cores"][core] = measure_steps(machine, COMPARED, calls=CALLS // 10)
        count.check(machine)
    firmware = figures["firmware"]
    for core, level in [("m4f", "-Os"), ("m4f", "-O3")] + [(core, "-Os") for core in OTHER_CORES]:
        firmware[f"{core} {level}"] = sizes.firmware_sizes(build.firmware(core, level))
    for name, options in (("tuning in flash", build.IN_FLASH), ("least", build.LEAST)):
        for level in ("-O2", "-Os"):
            firmware[f"m4f {level}, {name}"] = sizes.firmware_sizes(
                build.firmware("m4f", level, [*build.ONE_OBSERVER, *options]))
    firmware["m4f -O2, all observers"] = sizes.firmware_sizes(build.firmware(options=[]))


def table(head, rows):
    """A Markdown table that can also be read as it is."""
    cells = [[str(cell) for cell in line] for line in [head, *rows]]
    widths = [max(len(line[k]) for line in cells) for k in range(len(head))]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    padded = [[cell.ljust(width) if k == 0 else cell.rjust(width)
               for k, (cell, width) in enumerate(zip(line, widths))] for line in cells]
    return "".join("| " + " | ".join(line) + " |\n" for line in [padded[0], rule, *padded[1:]])


def three(figure):
    return f"{figure['min']} / {figure['avg']:.0f} / {figure['max']}"


def step_table(figures, which="steps"):
    head = ["step", "instructions", "cycles", "max/min", "loads", "stores", "text B", "executed B",
            "lines", "RAM B", "stack B"]
    rows = []
    for name, f in figures[which].items():
        ratio = f"{f['cycles']['max'] / f['cycles']['min']:.2f}"
        rows.append([f"`{name}`", three(f["instructions"]), three(f["cycles"]), ratio,
                     f"{f['loads']['avg']:.0f}", f"{f['stores']['avg']:.0f}", f["text"],
                     f["executed"], f["lines"], f["ram"], f["stack"]])
    return table(head, rows)


def step6_table(figures):
    return step_table(figures, "steps6")


def phase_table(figures):
    usual = figures["steps"][PHASES["steady"]]["cycles"]["max"]
    rows = []
    for phase, name in PHASES.items():
        cycles = figures["steps"][name]["cycles"]
        rows.append([phase, f"`{name}`", cycles["min"], f"{cycles['avg']:.0f}", cycles["max"],
                     f"{cycles['max'] / usual:.2f}"])
    return table(["phase", "step", "least cycles", "mean", "most", "most / steady"], rows)


def block_table(figures):
    rows = [[f"`{name}`", three(f["instructions"]), three(f["cycles"]), f["text"], f["stack"]]
            for name, f in figures["blocks"].items()]
    return table(["block", "instructions", "cycles", "text B", "stack B"], rows)


def level_table(figures):
    rows = []
    for name in COMPARED:
        for what in ("instructions", "cycles", "text", "stack"):
            found = [figures["levels"][level][name][what] for level in LEVELS]
            rows.append([f"`{name}`, {what}", *(three(f) if isinstance(f, dict) else f
                                                for f in found)])
    return table(["step", *(f"`{level}`" for level in LEVELS)], rows)


def core_table(figures):
    rows = []
    for core in ["m4f", *OTHER_CORES]:
        found = figures["steps"] if core == "m4f" else figures["cores"][core]
        flags = " ".join(build.CORES[core])
        rows.append([CORE_NAMES[core], *(f"{found[name]['instructions']['avg']:.0f}"
                                         for name in COMPARED),
                     found["enhanced"]["text"], found["enhanced"]["stack"], f"`{flags}`"])
    return table(["core", *(f"`{name}`" for name in COMPARED), "text B", "stack B", "flags"], rows)


def firmware_table(figures):
    rows = []
    for name, f in figures["firmware"].items():
        core, rest = name.split(" ", 1)
        rows.append([f"{CORE_NAMES[core]} {rest}", f["step"], f["init"], f["constants"],
                     f["libraries"], f["text"]])
    return table(["firmware", "step path", "init, design, mailboxes", "constants", "libraries",
                  "text B"], rows)


def object_table(figures):
    rows = [[f"`{name}`{note}", *(figures["objects"][kind][name] for kind in OBJECT_BUILDS)]
            for name, note in OBJECTS]
    return table(["object, bytes", *OBJECT_BUILDS], rows)


def fit_table(figures):
    """Shares of a processor: mean in RUN, and the costliest call."""
    steps = figures["steps"]
    in_run = steps[IN_RUN]["cycles"]["avg"] + ENTRY_CYCLES
    costliest = max(steps[name]["cycles"]["max"] for name in COSTLIEST) + ENTRY_CYCLES
    basis = {"m4f": "cycles, modelled", "m33": "the same cycles", "m7": "the same, as a bound",
             "r5f": "the same, as a bound"}
    rows = []
    for chip, core, mhz in CHIPS:
        cells = [chip, CORE_NAMES[core], mhz]
        for rate in RATES_kHz:
            share = 100 * rate * 1e3 / (mhz * 1e6)
            if core in basis:
                cells.append(f"{share * in_run:.0f}, {share * costliest:.0f} %")
            else:  # an instruction takes a cycle at least
                least = share * figures["cores"][core]["enhanced"]["instructions"]["avg"]
                cells.append(f"over {least:.0f} %")
        rows.append([*cells, basis.get(core, "instructions")])
    return table(["chip", "core", "MHz", *(f"{rate} kHz" for rate in RATES_kHz), "basis"], rows)


def check_table(figures):
    cycles, rows = figures["steps"]["enhanced"]["cycles"], []
    for what, setting, name, _ in CHECKS:
        without = figures["checks"][name]["cycles"]
        rows.append([what, f"`{setting}`", f"{cycles['avg'] - without['avg']:.0f}", cycles["max"] - without["max"],
                     figures["checks"][name]["state"] or ""])
    return table(["check", "off by `guard.`", "mean cycles", "costliest call", "state B"], rows)


def memory_table(figures):
    firmware, steps = figures["firmware"], figures["steps"]
    three_phases, six = firmware["m4f -O2"], firmware["m4f -O2, six phases"]
    rows = [["flash: drive, design and checks", three_phases["text"], firmware["m4f -Os"]["text"], six["text"]],
            ["flash: drive, with the tuning in flash", firmware["m4f -O2, tuning in flash"]["text"],
             firmware["m4f -Os, tuning in flash"]["text"], ""],
            ["flash: the same, with the fewest options", firmware["m4f -O2, least"]["text"],
             firmware["m4f -Os, least"]["text"], ""]]
    objects = figures["objects"]["one observer"]
    for what, name in (("", "RAM: drive"), ("_tuning", "RAM, or flash: tuning")):
        of_three, of_six = (objects[f"lode_drive{phases}{what}_t"] for phases in ("", "6"))
        rows.append([name, of_three, of_three, of_six])
    rows.append(["stack of a step", max(steps[name]["stack"] for name in COSTLIEST),
                 figures["levels"]["-Os"]["enhanced"]["stack"], max(f["stack"] for f in figures["steps6"].values())])
    return table(["Cortex-M4F, bytes", "`-O2`", "`-Os`", "six phases, `-O2`"], rows)


def named(which, name):
    return f"`{name}`" + (", six" if which == "steps6" else "")


def bar_table(figures):
    rows = []
    for which, name, what, target, earlier, before in BARS:
        bar = earlier + LATER_CYCLES
        mean = figures[which][name][what]["avg"]
        rows.append([f"{named(which, name)}, {what}", f"{mean:.0f}", target or "", bar,
                     f"{mean / bar:.2f}", before, f"{mean - before:.0f}"])
    return table(["step, mean", "measured", "target", "bar", "mean / bar", "before", "added"], rows)


def aim_table(figures):
    steps, firmware = figures["steps"], figures["firmware"]
    objects = figures["objects"]["one observer"]
    state, tuning = objects["lode_drive_t"], objects["lode_drive_tuning_t"]
    aims = [(f"`{name}`, costliest call / mean", steps[name]["cycles"]["max"] / steps[name]["cycles"]["avg"],
             COSTLIEST_SHARE) for name in RUNNING]
    aims += [(f"`{name}`, costliest call, cycles", steps[name]["cycles"]["max"], COSTLIEST_RARE)
             for name in ("rise", "start", "fault")]
    aims += [(f"`{name}`, stack, bytes", steps[name]["stack"], STACK) for name in RUNNING]
    aims += [("least image, bytes", firmware["m4f -Os, least"]["text"], LEAST_FLASH),
             ("drive object, bytes", state, STATE),
             ("the same with its tuning, bytes", state + tuning, STATE_AND_TUNING)]
    rows = [[what, f"{value:.2f}" if isinstance(value, float) else value, bar,
             "met" if round(value, 2) <= bar else "missed"] for what, value, bar in aims]
    return table(["what", "measured", "bar", ""], rows)


def bound_table(figures, what, rows):
    found = [figures[which][name][what] for which, name in BOUND]
    cells = [[row, *(f"{f[row]:.0f}" for f in found)] for row in rows]
    cells.append(["sum", *(f"{sum(f.values()):.0f}" for f in found)])
    return table(["mean cycles", *(named(*case) for case in BOUND)], cells)


def kind_table(figures):
    return bound_table(figures, "kinds", places.KINDS)


def part_table(figures):
    return bound_table(figures, "parts", places.PARTS)


def peer_table(figures):
    """What the parts cost that such a step usually has, beside the whole steps of others."""
    rows = []
    for which, name in BOUND[:len(STEPS6)]:
        parts = figures[which][name]["parts"]
        more = sum(parts[part] for part in places.MORE)
        whole = sum(parts.values())
        rows.append([named(which, name), f"{whole:.0f}", f"{more:.0f}", f"{whole - more:.0f}",
                     *(f"{(whole - more) / peer:.2f}" for peer in PEERS.values())])
    return table(["mean cycles", "whole step", "lower parts", "without them",
                  *(f"/ {peer} ({cycles})" for peer, cycles in PEERS.items())], rows)


TABLES = {"fit": fit_table, "memory": memory_table, "bars": bar_table, "aims": aim_table,
          "checks": check_table, "kinds": kind_table, "parts": part_table, "peers": peer_table,
          "steps": step_table, "steps6": step6_table, "phases": phase_table,
          "blocks": block_table, "levels": level_table,
          "cores": core_table, "firmware": firmware_table, "objects": object_table}


def page_with(figures):
    page = PAGE.read_text()
    for name, make in TABLES.items():
        begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->\n"
        head, found, rest = page.partition(begin)
        tail = rest.partition(end)
        if not found or not tail[1]:
            raise SystemExit(f"{PAGE}: expected '{begin.strip()}' and '{end.strip()}'")
        page = head + begin + make(figures) + end + tail[2]
    return page


def flat(figures, prefix=""):
    for name, value in figures.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}, ")
        elif isinstance(value, (int, float)):
            yield f"{prefix}{name}", value


def differences(figures, documented):
    now, then = dict(flat(figures)), dict(flat(documented))
    for name in sorted(now.keys() | then.keys()):
        if name not in then or name not in now:
            yield f"{name}: {'not in docs/budget.json' if name in now else 'no longer measured'}"
        elif abs(now[name] - then[name]) > max(TOLERANCE * abs(then[name]), SLACK):
            yield f"{name}: {now[name]}, in docs/budget.json {then[name]}"


def check(figures):
    documented = json.loads(FIGURES.read_text())
    found = []
    if page_with(documented) != PAGE.read_text():
        found.append("the tables of docs/budget.md are not those of docs/budget.json")
    gated = {name: documented.get(name, {}) for name in ("steps", "steps6", "blocks", "objects")}
    firmware = documented.get("firmware", {})
    gated["firmware"] = {name: firmware.get(name, {}) for name in figures["firmware"]}
    found.extend(differences(figures, gated))
    for text in found:
        print(text)
    print(f"{len(found)} figures moved by more than {100 * TOLERANCE:.0f} %"
          + (f"; {REMEDY}" if found else ""))
    return 1 if found else 0


def write(figures):
    FIGURES.write_text(json.dumps(figures, indent=1) + "\n")
    PAGE.write_text(page_with(figures))


def main():
    if len(sys.argv) != 2 or sys.argv[1] not in ("write", "check", "print"):
        raise SystemExit(__doc__)
    mode, lack = sys.argv[1], build.missing()
    version = None if lack else build.compiler_version()
    if not lack and not version.startswith(build.TABLE_VERSION + "."):
        differs = f"{build.GCC} is {version}, the figures in docs are of {build.TABLE_VERSION}"
        if mode == "check":
            lack = differs
        else:
            print(f"{differs}: nothing is written")
            mode = "print"
    if lack:
        print(f"skipped: {lack}")
        return 77
    tables = build.recording()
    figures = {"compiler": f"{build.GCC} {version}", **measure_m4f(tables)}
    if mode == "write":
        measure_others(figures, tables)
        write(figures)
    print(step_table(figures), step6_table(figures), bar_table(figures), kind_table(figures),
          part_table(figures), phase_table(figures), block_table(figures),
          firmware_table(figures), object_table(figures), sep="\n")
    return check(figures) if mode == "check" else 0


if __name__ == "__main__":
    sys.exit(main())
