"""`lodestar design --c`: tuning and configuration as C constants compile without a warning for the host and for a
Cortex-M4F, and lie in read-only memory there."""
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, SOURCE, TOOL, Checks, Folder, refused

WARNINGS = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
HOST = "cc"
TARGET = "arm-none-eabi-gcc"
# What a build may leave out of the members of a tuning.
OPTIONS = set(re.findall(r'^ +ROW\("[\w.]+", "(\w+)"\)', (SOURCE / "sim/design/tuning_fields.h").read_text(), re.M))
M4F = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-ffreestanding"]


def compiled(checks, source, compiler, flags):
    if shutil.which(compiler) is None:
        print(f"left out: no {compiler}")
        return None
    out = source.with_suffix(".o")
    run = subprocess.run([compiler, *WARNINGS, *flags, f"-I{SOURCE}/include", "-c", source, "-o", out],
                         capture_output=True, text=True)
    return out if checks.true(run.returncode == 0, f"{compiler}: {run.stderr}") else None


checks = Checks()
with Folder() as folder:
    run = subprocess.run([TOOL, "design", "--motor", MOTOR, "--drive", DRIVE, "--c", "out.c"],
                         cwd=folder.path, capture_output=True, text=True)
    source = folder.path / "out.c"
    checks.true(run.returncode == 0 and "written: out.c" in run.stdout, f"design --c: {run.stderr}")
    text = source.read_text()
    checks.true("const lode_drive_tuning_t out = {" in text, "the constant is named like the file")
    checks.true("const lode_drive_config_t out_config = {" in text, "and so is its configuration")
    compiled(checks, source, HOST, [])
    # For a build without what the tuning does not ask for, which has no members for that.
    compiled(checks, source, HOST, ["-DLODE_SMALL", "-DLODE_WITHOUT_NOTCH", "-DLODE_WITHOUT_HFI",
                                    "-DLODE_WITHOUT_COMMISSIONING",
                                    "-DLODE_WITHOUT_GI_LESO", "-DLODE_WITHOUT_FA_MULTI"])
    for part in sorted(OPTIONS):
        compiled(checks, source, HOST, [f"-DLODE_WITHOUT_{part}"])
    image = compiled(checks, source, TARGET, M4F)
    if image is not None:
        symbols = subprocess.run(["arm-none-eabi-nm", image], capture_output=True, text=True).stdout
        checks.true(re.search(r" R out$", symbols, re.M), f"not in read-only memory: {symbols}")
    # Injection that the firmware's build does not have would be left out without a word.
    subprocess.run([TOOL, "design", "--motor", MOTOR, "--drive", DRIVE, "--set", "hfi.mode=on", "--c", "hfi.c"],
                   cwd=folder.path, capture_output=True, check=True)
    bare = subprocess.run([HOST, f"-I{SOURCE}/include", "-DLODE_WITHOUT_HFI", "-fsyntax-only",
                           folder.path / "hfi.c"], capture_output=True, text=True)
    checks.true(bare.returncode != 0 and "LODE_WITHOUT_HFI" in bare.stderr, "a build without injection is refused")
    subprocess.run([TOOL, "design", "--motor", MOTOR, "--drive", DRIVE, "--set", "speed.every_period=on",
                     "--set", "drive.precharge_s=0.01", "--set", "speed.ramp_down_rad_s2=100", "--c", "fast.c"],
                   cwd=folder.path, capture_output=True, check=True)
    for part in ("FAST_SPEED", "PRECHARGE", "SHAPED_RAMP"):
        bare = subprocess.run([HOST, f"-I{SOURCE}/include", f"-DLODE_WITHOUT_{part}", "-fsyntax-only",
                               folder.path / "fast.c"], capture_output=True, text=True)
        checks.true(bare.returncode != 0 and f"LODE_WITHOUT_{part}" in bare.stderr, f"a build without {part}")
    # Another version of the library: what the members mean may have changed.
    source.write_text(text.replace("LODE_VERSION_MINOR != ", "LODE_VERSION_MINOR != 9"))
    stale = subprocess.run([HOST, f"-I{SOURCE}/include", "-fsyntax-only", source],
                           capture_output=True, text=True)
    checks.true(stale.returncode != 0 and "another version" in stale.stderr, "a stale one is refused")
    (folder.path / "small.ini").write_text("[drive]\nf_pwm_Hz = 5000\nv_bus_V = 200\ni_max_A = 12\n")
    for arguments, pattern in [
        (["--drive", DRIVE, "--c", "2.c"], "--c 2.c: expected a file whose name"),
        (["--drive", DRIVE, "--c", "no/where.c"], "where.c"),
        (["--c"], "--c: missing value; expected one after the option"),
        (["--c", "x.c"], r"\[drive\] f_pwm_Hz: missing"),  # not assumed for firmware
        (["--drive", "small.ini", "--c", "x.c"], r"\[drive\] i_range_A: missing"),
    ]:
        refused(checks, folder, ["design", "--motor", MOTOR, *arguments], pattern)
    # Names that C, its library or this one has already: none of them would compile.
    for name in ("int", "for", "restrict", "inline", "bool", "true", "alignas", "thread_local", "nullptr", "constexpr",
                 "typeof", "static_assert", "asm", "main", "LODE_OK", "lode_drive_tuning_t", "lode_mine", "_Bool",
                 "_mine", "exp", "gamma", "sqrtf", "logl", "y0", "isnan", "uint32_t", "int_fast8_t", "float_t"):
        refused(checks, folder, ["design", "--motor", MOTOR, "--drive", DRIVE, "--c", f"{name}.c"],
                f"--c {name}.c: the constant would be called {name}; expected a file whose name without extension is free in C: no keyword")
    for name in ("integer", "form", "mainly", "lodestar", "expo", "f", "sqrtfl", "my_t", "int8"):
        run = subprocess.run([TOOL, "design", "--motor", MOTOR, "--drive", DRIVE, "--c", f"{name}.c"],
                             cwd=folder.path, capture_output=True, text=True)
        checks.true(run.returncode == 0, f"--c {name}.c: {run.stderr}")
        compiled(checks, folder.path / f"{name}.c", HOST, [])
    # Six phases.
    six = ["design", "--motor", "ultrazohm6", "--drive", "ultrazohm6"]
    run = folder.run(*six, "--set", "speed.every_period=off", "--c", "six.c")
    checks.true(run.returncode == 0 and "written: six.c" in run.stdout, f"six phases: {run.stderr}")
    source = folder.path / "six.c"
    text = source.read_text()
    checks.true("const lode_drive6_tuning_t six = {" in text, "the constant is that of six phases")
    checks.true("const lode_drive6_config_t six_config = {" in text, "and so is its configuration")
    checks.true("measured" not in text.lower(), "design measures nothing")
    compiled(checks, source, HOST, [])
    compiled(checks, source, HOST, [f"-DLODE_WITHOUT_{part}" for part in OPTIONS])
    image = compiled(checks, source, TARGET, M4F)
    if image is not None:
        symbols = subprocess.run(["arm-none-eabi-nm", image], capture_output=True, text=True).stdout
        for name in ("six", "six_config"):
            checks.true(re.search(rf" R {name}$", symbols, re.M), f"not in read-only memory: {symbols}")
    # What both sets need and one alone does not, and the other way round.
    for key, part in (("hfi.mode=on", "HFI"), ("motor.Lxy_H=0.05", "OPTIMAL_REFERENCES")):
        run = folder.run(*six, "--set", key, "--c", "six.c")
        checks.equal(run.returncode, 0, f"{key}: {run.stderr}")
        checks.true(f"#ifdef LODE_WITHOUT_{part}\n#error" in source.read_text(), f"six phases: {part}")
    # Every name of a choice is one of the library's.
    run = folder.run(*six, "--set", "estimator.winding=set-2", "--set", "guard.open_phase=ignore", "--set",
                     "references.strategy=mtpa", "--set", "estimator.pll=qpll", "--set", "hfi.mode=auto", "--set",
                     "estimator.compensation=none", "--set", "xy.resonance_rad_s=none", "--c", "six.c")
    checks.equal(run.returncode, 0, f"choices: {run.stderr}")
    compiled(checks, source, HOST, [])
    for line in (".source = LODE_SOURCE_SET_2,", ".open_phase = LODE_OPEN_PHASE_IGNORE,",
                 ".drive.references.kind = LODE_REFERENCES_MTPA,", ".drive.estimator.pll.kind = LODE_PLL_QPLL,",
                 ".drive.hfi.mode = LODE_HFI_AUTO,", ".drive.estimator.compensation = LODE_LAG_NONE,",
                 ".xy.resonance_rad_s = -0x1p+0f, // -1"):
        checks.true(f"    {line}\n" in source.read_text(), f"{line} is missing")
    # What lode_drive6_init() refuses.
    for key, pattern in (("motor.Lxy_H=1e-9", r"\[motor\] Lxy_H = 1e-09: LODE_ERROR_XY_INDUCTANCE"),
                         ("xy.voltage_share=0.9", r"\[xy\] voltage_share = 0.9: LODE_ERROR_XY_VOLTAGE")):
        for more in ([], ["--c", "none.c"]):
            refused(checks, folder, [*six, "--set", key, *more], pattern)
            refused(checks, folder, ["commission", *six[1:], "--set", key, *more], pattern)
checks.done()
