"""usage: build.py [CORE [-Olevel]]: builds build/bench/lodestar-bench-CORE.elf (m4f, -O2).

The image is what budget.py counts. Needs cc and arm-none-eabi-gcc.
"""
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = ROOT / "tests" / "bench"
OUT = ROOT / "build" / "bench"
GCC = "arm-none-eabi-gcc"
TABLE_VERSION = "12.2"  # of the compiler whose figures are in docs/budget.md

FLOAT = ["-fno-math-errno", "-ffp-contract=off"]
COMMON = ["-std=c99", "-ffunction-sections", "-fdata-sections", *FLOAT]
CORES = {
    "m0": ["-mcpu=cortex-m0", "-mthumb", "-mfloat-abi=soft"],
    "m3": ["-mcpu=cortex-m3", "-mthumb", "-mfloat-abi=soft"],
    "m4f": ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
    "m7": ["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16"],
    "m33": ["-mcpu=cortex-m33", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"],
    "r5f": ["-mcpu=cortex-r5", "-marm", "-mfloat-abi=hard", "-mfpu=vfpv3-d16"],
}
DEBUG = "-gdwarf-4"  # says where instructions come from, and changes none
IN_FLASH = ["-DFIRMWARE_TUNING_IN_FLASH"]  # of firmware.c
LEAST = [*IN_FLASH, "-DLODE_SMALL", "-DLODE_WITHOUT_OPTIMAL_REFERENCES", "-DLODE_WITHOUT_NOTCH",
         "-DLODE_WITHOUT_HFI", "-DLODE_WITHOUT_COMMISSIONING", "-DLODE_WITHOUT_SHUNT_WINDOW",
         "-DLODE_WITHOUT_PLAUSIBILITY", "-DLODE_WITHOUT_TUNING_CHECK",
         "-DLODE_WITHOUT_START_MEASUREMENT", "-DLODE_WITHOUT_HANDOVER_RETRY",
         "-DLODE_WITHOUT_PRECHARGE", "-DLODE_WITHOUT_FAST_SPEED",
         "-DLODE_WITHOUT_TORQUE_CONTROL", "-DLODE_WITHOUT_ANGLE_SENSOR",
         "-DLODE_WITHOUT_ACTIVE_SHORT", "-DLODE_WITHOUT_TORQUE_LIMITS",
         "-DLODE_WITHOUT_BRAKE_SLIP", "-DLODE_WITHOUT_GENTLE_START", "-DLODE_WITHOUT_SHAPED_RAMP",
         "-flto"]
OBSERVERS = re.findall(r"^LODE_OBSERVER\((\w+), (\w+)",
                       (ROOT / "include/lodestar/observers.def").read_text(), re.MULTILINE)
ONE_OBSERVER = [f"-DLODE_WITHOUT_{upper}" for upper, _ in OBSERVERS[1:]]


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(str(part) for part in command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def missing():
    """What the machine lacks to build and count, or None."""
    for tool in ("cc", GCC):
        if shutil.which(tool) is None:
            return f"no {tool}"
    if "No such file" in subprocess.run([GCC, "-E", "-include", "math.h", "-x", "c", "/dev/null"],
                                        capture_output=True, text=True).stderr:
        return "no C library for arm-none-eabi-gcc"
    return None


def compiler_version():
    return run(GCC, "-dumpfullversion").strip()


def core_sources():
    return sorted((ROOT / "src").glob("*.c"))


def includes():
    return ["-I", ROOT / "include", "-I", ROOT / "src", "-I", HERE]


def recording(*options):
    """The ADC results of closed-loop runs on this machine, as C tables."""
    OUT.mkdir(parents=True, exist_ok=True)
    program, tables = OUT / "record", OUT / f"recording{''.join(options)}.c"
    sources = [HERE / name for name in ("record.c", "record6.c", "motor.c", "drives.c", "drives6.c")]
    run("cc", "-std=c99", "-O2", *FLOAT, *includes(), *options, *sources, *core_sources(), "-lm", "-o", program)
    tables.write_text(run(program))
    return tables


def link(core, level, out, sources, *options):
    run(GCC, *CORES[core], level, *COMMON, *includes(), *options, *sources, "-nostartfiles",
        "--specs=nosys.specs", "-T", HERE / "image.ld", "-Wl,--gc-sections",
        f"-Wl,-Map={out.with_suffix('.map')}", "-lm", "-o", out)
    return out


def image(core="m4f", level="-O2", tables=None, *options):
    name = f"lodestar-bench-{core}{'' if level == '-O2' else level}.elf"
    sources = [HERE / f for f in ("image.c", "blocks.c", "drives.c", "drives6.c")] + core_sources()
    if core != "r5f":
        sources.append(HERE / "qemu.c")
    return link(core, level, OUT / name, [*sources, tables or recording()], DEBUG, *options)


def firmware(core="m4f", level="-O2", options=ONE_OBSERVER, phases=3):
    name = "firmware6" if phases == 6 else "firmware"
    sources = [HERE / f"{name}.c", *core_sources()]
    return link(core, level, OUT / f"lodestar-{name}-{core}{level}.elf", sources, *options,
                "-Wl,-u,firmware,-u,firmware_interrupt,--emit-relocs")


def objects(types, options=(), core="m4f"):
    """An object file with an array `size_TYPE` of as many bytes as each type takes."""
    OUT.mkdir(parents=True, exist_ok=True)
    source, out = OUT / "objects.c", OUT / "objects.o"
    arrays = "".join(f"char size_{name}[sizeof({name})];\n" for name in types)
    source.write_text(f'#include "lodestar/lodestar.h"\n{arrays}')
    run(GCC, *CORES[core], "-O2", *COMMON, *includes(), *options, "-c", source, "-o", out)
    return out


if __name__ == "__main__":
    if len(sys.argv) > 3 or "-h" in sys.argv or not re.match("|".join(CORES), (sys.argv + ["m4f"])[1]):
        raise SystemExit(__doc__)
    if missing():
        print(f"skipped: {missing()}")
        sys.exit(77)
    print(image(*sys.argv[1:]))
