"""usage: check_layers.py ROOT: a module of the core includes only its own layer or a lower one."""
import re
import sys

from csource import files, includes_of

# Bottom up. A module is a public header and the source of the same name.
LAYERS = [
    ["platform", "status", "version", "wire"],
    ["scalar", "frames", "config"],
    ["schedule"],
    ["chopper", "motor", "options", "pi", "ramp", "sogi", "observer", "vsd"],
    ["sense", "inverter", "modulator", "modulator6", "xy",
     "open_phase", "emf", "pll", "lag", "notch", "hfi"],
    ["estimator", "current", "speed", "references", "start", "start_design", "start_parts", "fly", "guard", "plausibility", "signal_check"],
    ["drive", "drive_config", "drive_parts", "drive_slots", "drive_speed", "drive_watch", "mode", "mode_parts", "mode_idle", "mode_start",
     "mode_inject", "tuning_check"],
    ["adaptation", "adaptation_machine", "commission", "commission_machine", "commission_parts", "commission_sensors",
     "commission_resistance", "commission_inductances", "commission_run", "derate", "drive6", "drive6_config",
     "encoder", "fault_log", "learn", "single_shunt", "supervisor", "supply"],
    ["adaptation6", "commission6"],
    ["channel"],
    ["ring", "scope"],
    ["lodestar"],
]
SYSTEM = {"stdbool.h", "stddef.h", "stdint.h", "math.h", "float.h"}

rank = {module: number for number, layer in enumerate(LAYERS) for module in layer}


def module_of(name):
    """x of x.h, x.c and x_inline.h; the rooms of the EMF observers and their table are its parts."""
    module = re.sub(r"_inline$", "", name.rsplit("/", 1)[-1].rsplit(".", 1)[0])
    return "observer" if re.match("observer(s$|_)", module) else module


def problems_of(path):
    module = module_of(path.name)
    if module not in rank:
        yield 1, f"module '{module}' is not in the table of layers (LAYERS in check_layers.py)"
        return
    for line, name, quoted in includes_of(path):
        if not quoted:
            if name not in SYSTEM:
                yield line, f"<{name}>: expected one of {', '.join(sorted(SYSTEM))}"
        elif not name.startswith("lodestar/") and not (path.parent / name).is_file():
            yield line, f'"{name}": expected "lodestar/<module>.h", or a header beside it'
        elif module_of(name) not in rank:
            yield line, f"module '{module_of(name)}' is not in the table of layers"
        elif rank[module_of(name)] > rank[module]:
            yield line, (f"'{module}' (layer {rank[module]}) includes '{module_of(name)}' "
                         f"(layer {rank[module_of(name)]}): expected its own layer or a lower one")


def main(root):
    count = failed = 0
    for path in files(root, "include", "src"):
        count += 1
        for line, text in problems_of(path):
            failed += 1
            print(f"{path}:{line}: {text}")
    print(f"{count} files, {failed} breaches")
    return 1 if failed or not count else 0


sys.exit(main(sys.argv[1]))
