"""What the tool says to bad input: exit code 2, the place, and what was expected."""
import json
import pathlib
import random
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, RECORDINGS, SOURCE, Checks, Folder, refused

STEADY = RECORDINGS / "steady-300rpm-5Nm.csv"
OBSERVERS = (SOURCE / "include/lodestar/observers.def").read_text()
BUILT = {"--emf": re.findall(r'^LODE_OBSERVER\(.*"(.*)"', OBSERVERS, re.MULTILINE),
         "--pll": ["leso-qpll", "qpll", "enhanced"]}
# The papers' own forms, which go together.
EULER = {"--emf": ["c-leso-euler", "gi-leso-euler", "fa-leso-euler"],
         "--pll": ["leso-qpll-euler", "qpll-euler", "enhanced-euler"]}


def command_line(checks, folder):
    for arguments, pattern in [
        (["foo"], "foo: unknown command; expected list, run, replay, design"),
        (["--foo"], "--foo: unknown here; expected one of --set, --seed"),
        (["list", "--seed", "1"], "--seed: unknown here; list takes no options$"),
        (["run", "main", "--drive", "servo_48V"], "run: expected a scenario or --drive, not both: a scenario names its"),
        (["run"], "run: expected a scenario file"),
        (["run", "a.ini", "b.ini"], "b.ini: expected no argument here"),
        (["run", "nofile.ini"], r"nofile.ini: No such file.*expected an INI file"),
        (["run", "main", "--set"], "--set: missing value; expected one after the option"),
        (["run", "main", "--set", "x"], "--set x: expected section.key=value"),
        (["run", "main", "--set", "a=1"], "--set a=1: expected section.key=value"),
        (["run", "main", "--seed", "1.5"], "--seed 1.5: expected a whole number"),
        (["run", "main", "--seed", "-1"], "--seed -1: expected a whole number"),
        (["run", "main", "--seed", "18446744073709551615"], "expected a whole number, 0"),
        (["run", "start", "--seeds", "5-1"], "--seeds 5-1: expected two whole numbers"),
        (["run", "start", "--seeds", "1-2", "--seed", "1"], "--seed or --seeds, not both"),
        (["run", "start", "--seeds", "1-2", "--jobs", "0"], "--jobs 0: expected a whole number"),
        (["run", "start", "--seeds", "1-2", "--jobs", "2x"], "--jobs 2x: expected a whole number"),
        (["run", "start", "--jobs", "2"], "--jobs: expected only with --seeds"),
        (["run", "start", "--seeds", "1-2", "--csv", "a.csv"], "expected no --csv"),
        (["run", "main", "--seed", "1", "--seed", "2"], "--seed: given twice; expected it once"),
        (["run", "main", "--json", "a.json", "--json", "b.json"], "--json: given twice"),
        (["faults", "--motors", "jiang2022", "--motors", "eldeeb2017"], "--motors: given twice"),
        (["run", "main", "--trigger", "fault"], "^lodestar: --trigger: expected only with --scope$"),
        (["run", "main", "--trigger", "fault", "--ring", "r.bin"], "--trigger: expected only with --scope"),
        (["run", "main", "--channels", "iq_A"], "--channels: expected only with --ring or --scope"),
        (["run", "main", "--every", "2"], "--every: expected only with --ring or --scope"),
        (["run", "start", "--seeds", "1-2", "--every", "2"], "--every: expected only with --ring or --scope"),
        (["analyse", "--format", "png"], "--format: expected only with --plots"),
        (["reproduce", "jiang2022", "--format", "png"], "--format: expected only with --plots"),
        (["run", "/dev/zero"], "^/dev/zero: Invalid argument; expected an INI file"),
        (["run", "main", "--set", "plant.flux_map=/dev/zero"], "/dev/zero: Invalid argument; expected a CSV"),
        (["monte-carlo", "merge", "/dev/zero"], "/dev/zero: Invalid argument"),
        (["replay", "--motor", MOTOR], "replay: expected --recording"),
        (["replay", "--recording", STEADY], "replay: expected --motor"),
        (["design"], "design: expected --motor"),
        (["design", "--motor", MOTOR, "--json", "a.json"], "or --json=a.json"),
    ]:
        refused(checks, folder, arguments, pattern)


def values(checks, folder):
    for assignment, pattern in [
        ("foo.bar=1", r"--set: \[foo\] bar: unknown; expected one of motor, drive, estimator"),
        ("motor.foo=1", r"--set: \[motor\] foo: unknown; expected one of pole_pairs, Rs_Ohm"),
        ("motor.R_line_Ohm=1", r"unknown; did you mean \[motor\] R_line_line_Ohm\? Otherwise expected one of"),
        ("motor.kv=1", r"unknown; did you mean \[motor\] KV_rpm_V\?"),
        ("motor.J=1", r"unknown; did you mean \[motor\] J_kgm2\?"),
        ("motor.i_max_A=1", r"unknown; did you mean \[drive\] i_max_A\?"),
        ("motor.Rs_Ohm=", "expected a finite number, not ''"),
        ("motor.Rs_Ohm=0.75x", "expected a finite number, not '0.75x'"),
        ("motor.Rs_Ohm=nan", "expected a finite number"),
        ("motor.poles=10 # of them", r"expected a number in 2 \.\. 200, not '10 # of them'; comments begin with ;$"),
        ("motor.poles=1", r"expected a number in 2 \.\. 200, not '1'$"),
        ("motor.poles=202", r"expected a number in 2 \.\. 200, not '202'$"),
        ("motor.poles=11", r"gives \[motor\] pole_pairs = 5.5; expected a whole number, 1 \.\. 100"),
        ("drive.shunts=two # or three", "expected three or two, not 'two # or three'; comments begin with ;"),
        ("phase.start.duration_s=1 #s", "not '1 #s'; comments begin with ;"),
        ("motor.Rs_Ohm=1e999", "expected a finite number"),
        ("motor.Rs_Ohm=1e-60", "expected a finite number"),
        ("motor.Rs_Ohm=auto", "expected a finite number"),
        ("drive.shunts=four", "expected three or two, not 'four'"),
        ("estimator.emf=nonsense", "expected c-leso"),
        ("plant.inverter=perfect", "expected ideal or switched, not 'perfect'"),
        ("plant.Rs_Ohm=-1", r"expected a number in 0 \.\. "),
        ("plant.theta0_deg=north", "or random, not 'north'"),
        ("phase.nowhere.load_Nm=1", r"expected the name of a phase of the scenario: start, ramp, rated_load, .*, stop$"),
        ("phase.start.lod=1", r"\[phase.start\] lod: unknown; did you mean \[phase\] load_Nm\? .*one of duration_s"),
        ("phase.start.end_mode=stop", "expected off, calibrate, voltage"),
        ("scenario.motor=x.ini", "expected in a scenario file only"),
        ("scenario.seed=-1", "expected a number in 0"),
    ]:
        refused(checks, folder, ["run", "main", "--set", assignment], pattern)
    # Two units for one thing.
    refused(checks, folder, ["run", "main", "--set", "start.handover_rpm=150", "--set",
                             "start.omega_handover_rad_s=50"], "expected one of them")


# What makes the library refuse, with the key to be named first; the others make it possible.
REFUSALS = {
    "F_PWM": ["drive.f_pwm_Hz=100"],
    "MOTOR_POLE_PAIRS": ["motor.pole_pairs=2.5"],
    "MOTOR_RS": ["motor.Rs_Ohm=-1"],
    "MOTOR_LD": ["motor.Ld_H=20"],
    "MOTOR_LQ": ["motor.Lq_H=0"],
    "MOTOR_PSI": ["motor.psi_Wb=200"],
    "MOTOR_J": ["motor.J_kgm2=0"],
    "MOTOR_B": ["motor.B_Nms=-1", "motor.B_Nms=100"],
    "MOTOR_OMEGA": ["motor.speed_rated_rpm=1e6"],
    "MOTOR_SETS": ["motor.sets=3"],
    "MOTOR_PERIOD": ["motor.Rs_Ohm=100"],
    "V_BUS": ["drive.v_bus_V=3000"],
    "I_MAX": ["drive.i_max_A=0"],
    "DEAD_TIME": ["drive.dead_time_s=1e-3", "drive.f_pwm_Hz=199999"],
    "V_DROP": ["drive.v_drop_V=11"],
    "R_ON": ["drive.r_on_Ohm=-1"],
    "I_DEAD": ["drive.i_dead_A=13"],
    "PWM_TICKS": ["drive.pwm_ticks=70000"],
    "PRECHARGE": ["drive.precharge_s=2"],
    "DOUBLE_UPDATE": ["drive.double_update=on drive.duty_max=0.9"],
    "SENSE_CURRENT": ["drive.i_range_A=1"],
    "SENSE_BUS": ["drive.v_range_V=10"],
    "SENSE_OFFSET": ["drive.i_offset_tol_count=1e5"],
    "SENSE_WINDOW": ["drive.duty_max=0.2", "current.voltage_use=0.9 drive.shunts=two drive.duty_max=0.9"],
    "SENSE_CALIBRATION": ["drive.calibrate_s=100"],
    "EMF_W0": ["estimator.w0_rad_s=1e6"],
    "EMF_GI": ["estimator.gi_kappa=8", "estimator.gi_wc_rad_s=1e3"],
    "EMF_FA": ["estimator.k2_rad_s=1e5", "estimator.k1_rad2_s2=1e5"],
    "EMF_PLL": ["estimator.k2_rad_s=20 estimator.emf=fa-leso"],
    "NOTCH": ["estimator.notch_k=3", "estimator.notch12_k=3"],
    "W_FILTER": ["estimator.w_filter_rad_s=1e6"],
    "PLL_SIGMA": ["estimator.sigma_rad_s=2000", "estimator.sigma_rad_s=110 estimator.sigma_low_rad_s=200"],
    "PLL_OBSERVER": ["estimator.sigma_rad_s=900", "estimator.w0_rad_s=300"],
    "PLL_SCHEDULE": ["estimator.omega_low_rad_s=200"],
    "LAG": ["estimator.w0_rad_s=510"],
    "EMIN": ["estimator.emin_V=1e4", "motor.psi_Wb=2e-6"],
    "OMEGA_MAX": ["estimator.omega_max_rad_s=1e4", "estimator.speed_max_rpm=1e5"],
    "LOCK_TIME": ["estimator.lock_s=2"],
    "CURRENT_BANDWIDTH": ["current.bandwidth_rad_s=1e5"],
    "CURRENT_GAINS": ["current.kp_d_V_A=1000", "current.ki_q_V_As=1e9 current.kp_d_V_A=3"],
    "CURRENT_VOLTAGE": ["current.voltage_use=2"],
    "SPEED_GAINS": ["speed.kp_Nms=-1", "speed.gain_rise=11 speed.ki_Nm=1", "speed.dip_gain=11",
                    "speed.kp_A_s_rad=1e9",
                    "speed.ki_Nm=1e7 speed.kp_Nms=0.2"],
    "SPEED_BANDWIDTH": ["speed.bandwidth_rad_s=1000", "speed.kp_Nms=5", "speed.kp_A_s_rad=10"],
    "SPEED_RAMP": ["speed.ramp_rad_s2=1e9", "speed.ramp_rpm_s=1e9", "speed.ramp_down_rad_s2=1e9",
                   "speed.jerk_rad_s3=0.1"],
    "SPEED_FEED_FORWARD": ["speed.load_feed_forward=2", "speed.inertia_feed_forward=2"],
    "ID_BIAS": ["references.id_bias_A=20", "hfi.id_A=20 hfi.mode=on", "references.omega_low_rad_s=300"],
    "FIELD_WEAKENING": ["references.voltage_use=2", "references.trim_rad_s=1e5",
                        "references.release_s=100 references.trim_rad_s=10",
                        "references.id_max_A=100"],
    "WEAKENING_ESTIMATOR": ["references.field_weakening=on estimator.emf=gi-leso",
                            "references.field_weakening=on estimator.pll=qpll"],
    "LQ_FALL": ["references.Lq_fall=10"],
    "BUS_FADE": ["references.v_regen_V=100", "references.v_motor_V=300"],
    "START_CURRENT": ["start.current_A=1000"],
    "START_SPEED": ["start.omega_handover_rad_s=1e4", "start.handover_rpm=1e5",
                    "speed.omega_min_rad_s=1"],
    "START_RAMP": ["start.ramp_rad_s2=1e9 start.lock_s=0.1", "start.lock_s=100", "start.align_s=11",
                   "motor.J_kgm2=1e-9 motor.B_Nms=0 start.lock_s=0.1"],
    "START_DAMPING": ["start.damping=3"],
    "HFI_SALIENCY": ["hfi.Lq_i_max_H=4e-3 hfi.mode=on"],
    "HFI_VOLTAGE": ["hfi.V_h_V=60 hfi.mode=on", "hfi.noise_A=20 hfi.V_h_V=20 hfi.mode=on"],
    "HFI_DEAD_TIME": ["hfi.V_h_V=5 hfi.mode=on"],
    "HFI_SPEEDS": ["hfi.w1_rad_s=130 hfi.mode=on", "hfi.w2_rad_s=1e4 hfi.mode=on"],
    "HFI_SIGMA": ["hfi.sigma_rad_s=2000 hfi.mode=on"],
    "HFI_AXIS": ["hfi.k_x_rad_A=0.05 hfi.mode=on"],
    "HFI_LEARN": ["hfi.learn=on", "hfi.learn=on hfi.mode=on motor.sets=2 motor.Lxy_H=1e-3"],
    "HFI_FLUX": ["estimator.active_flux=off hfi.mode=on"],
    "XY_INDUCTANCE": ["motor.Lxy_H=20 motor.sets=2"],
    "XY_BANDWIDTH": ["xy.bandwidth_rad_s=1e5 motor.sets=2 motor.Lxy_H=1e-3"],
    "XY_VOLTAGE": ["xy.voltage_share=1 motor.sets=2 motor.Lxy_H=1e-3"],
    "GUARD_CURRENT": ["guard.i_trip_A=5", "guard.i_trip_A=1000", "guard.i_sum_A=1000"],
    "GUARD_FLUX": ["guard.flux_share=0.05"],
    "GUARD_BUS": ["guard.v_bus_max_V=100", "guard.v_bus_min_V=300"],
    "GUARD_TEMPERATURE": ["guard.temperature_max_degC=1e4", "guard.temperature_min_degC=200"],
    "GUARD_SPEED": ["guard.omega_max_rad_s=1e7"],
    "GUARD_TIME": ["guard.bus_s=100", "guard.lock_s=100", "guard.stamp_per_period=1e10"],
}
# Choices are read by their names, from a build that has all of them.
UNREACHABLE = {"SENSE_SHUNTS", "EMF_KIND", "PLL_KIND", "CHOICE", "REFERENCES", "SOURCE", "OPEN_PHASE",
               "HFI_MODE"}


def refusals(checks, folder):
    """Every status of the library that a configuration can have: the key, its value and its place."""
    known = set(re.findall(r"\{LODE_ERROR_(\w+)", (SOURCE / "sim/config/refusal.c").read_text()))
    checks.equal(known, set(REFUSALS) | UNREACHABLE, "refusals that are tested")
    header = (SOURCE / "include/lodestar/status.h").read_text()
    every = set(re.findall(r"LODE_ERROR_(\w+)", header))
    # No configuration of the tool leads to these: pointers, commands, recorders, a sensor of its own.
    checks.equal(every - known, {"NULL", "COMMAND", "COMMAND_SPEED", "TUNING", "CHANNELS", "BUFFER", "TRIGGER",
                                 "PRE_SHARE", "SENSE_TEMPERATURE", "ENCODER_COUNTS", "ENCODER_ANGLE",
                                 "ENCODER_BANDWIDTH", "ENCODER_CHECK", "DERATE", "SUPERVISOR",
                                 "ACTIVE_SHORT", "SUPPLY", "CHOPPER"}, "statuses without words")
    scenario = (f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n"
                "[phase.a]\nduration_s = 0.01\n")
    for status, cases in REFUSALS.items():
        for case in cases:
            sets = case.split()
            section, key, value = re.match(r"(\w+)\.(\w+)=(.*)", sets[0]).groups()
            said = rf"\[{section}\] {key} = \S+: LODE_ERROR_{status}: .*expected "
            folder.write("s.ini", scenario)
            done = refused(checks, folder, ["run", "s.ini", *[x for s in sets for x in ("--set", s)]],
                           f"^--set: {said}")
            shown = done.stderr.split(" = ")[1].split(":")[0]
            if value.isalpha():
                checks.equal(shown, value, f"value of {case}")
            elif float(shown) != 0.0:
                checks.at_most(abs(float(shown) / float(value or 1) - 1), 1e-6, f"value of {case}")
            text = scenario
            for assignment in reversed(sets):
                other, rest = assignment.split(".", 1)
                text += f"[{other}]\n{rest}\n"
            folder.write("s.ini", text)
            refused(checks, folder, ["run", "s.ini"], rf"^s.ini:{len(text.splitlines())}: {said}")


# Numbers below zero where a word stands for none: what else makes the library look at the key.
BELOW_ZERO = {"hfi.id_A": "hfi.mode=on", "xy.resonance_rad_s": "motor.sets=2 motor.Lxy_H=1e-3"}


def words_are_not_said_for_numbers(checks, folder):
    """Every key with a word for a value: a number that is refused is shown as the number that was typed."""
    keys = (SOURCE / "sim/config/schema_keys.c").read_text()
    or_none = re.findall(r'FLOAT_OR_NONE\("(\w+)", "(\w+)"', keys)
    or_none += re.findall(r'PLAIN\("(\w+)", "(\w+)", \S+, RIG_KEY_FLOAT_OR_NONE\)', keys)
    or_word = re.findall(r'NUMBER_OR\("(\w+)", "(\w+)", \S+, \S+, \S+, "(\w+)"\)', keys)
    or_word += [("phase.start", *found) for found in re.findall(r'PHASE_NUMBER_OR\("(\w+)", .*"(\w+)"\)', keys)]
    checks.equal((len(or_none), len(or_word)), (13, 3), "keys with a word")
    for section, key in or_none:
        more = BELOW_ZERO.get(f"{section}.{key}", "").split()
        for typed in ("-5", "-2.5", "-1e30"):
            sets = [word for one in [f"{section}.{key}={typed}", *more] for word in ("--set", one)]
            refused(checks, folder, ["run", "main", *sets],
                    rf"^--set: \[{section}\] {key} = {re.escape(typed.replace('1e30', '1e+30'))}: LODE_ERROR_")
        sets = [word for one in [f"{section}.{key}=none", *more] for word in ("--set", one)]
        design = folder.run("design", "--motor", MOTOR, "--drive", DRIVE, *sets)
        checks.equal(design.returncode, 0, f"exit code with {section}.{key} = none: {design.stderr}")
    for section, key, word in or_word:
        refused(checks, folder, ["run", "main", "--set", f"{section}.{key}=-2e9"],
                rf"\[{section}\] {key}: expected a number in .* or {word}, not '-2e9'")


def defaults_that_are_refused(checks, folder):
    """Where a default is refused, what it was computed from is named: nobody wrote the default."""
    motor = ("[motor]\npoles = 14\nR_line_line_mOhm = 110\nL_line_line_uH = 60\nJ_gcm2 = 300\n"
             "KV_rpm_V = {KV}\n[drive]\nf_pwm_Hz = {f}\nv_bus_V = {v}\ni_max_A = {i}\n")
    folder.write("s.ini", "[scenario]\nmotor = m.ini\n[phase.a]\nduration_s = 0.001\n")
    for values, pattern in [
        ({"KV": 750, "f": 2500, "v": 36, "i": 20},
         r"^m.ini:9: \[drive\] v_bus_V = 36: LODE_ERROR_START_SPEED: gives \[start\] "
         r"omega_handover_rad_s = \d+.*; expected .*\[estimator\] omega_max_rad_s = 1250.*; with .*"
         r"\[motor\] KV_rpm_V = 750 \(m.ini:6\).*\[drive\] i_max_A = 20 \(m.ini:10\)"
         r"; \[motor\] speed_rated_rpm = 17\d\d\d\S* is assumed, and may be given"),
        ({"KV": 0, "f": 20000, "v": 36, "i": 20},
         r"^m.ini:6: \[motor\] KV_rpm_V = 0: LODE_ERROR_MOTOR_PSI: gives \[motor\] psi_Wb = inf; "),
    ]:
        folder.write("m.ini", motor.format(**values))
        refused(checks, folder, ["run", "s.ini"], pattern)
    # At 0.6 rad a period the PLL's default keeps to what the observer bears; one that is given is refused.
    light = motor.replace("J_gcm2 = 300", "J_gcm2 = 30")  # so that it needs all of it
    folder.write("m.ini", light.format(KV=750, f=20000, v=36, i=20))
    checks.equal(folder.run("run", "s.ini").returncode, 0, "exit code of a fast motor with all defaults")
    refused(checks, folder, ["run", "s.ini", "--set", "estimator.w0_rad_s=9000"],
            r"^--set: \[estimator\] w0_rad_s = 9000: LODE_ERROR_PLL_OBSERVER: expected .*; "
            r"here \[estimator\] sigma_rad_s = 1998")
    # Whatever the figures: a place and a key that somebody wrote.
    draw = random.Random(1)
    refusals_seen = 0
    for _ in range(120):
        values = {"KV": 10 ** draw.uniform(0, 4), "f": 10 ** draw.uniform(3, 5.3),
                  "v": 10 ** draw.uniform(0, 3.3), "i": 10 ** draw.uniform(-3, 3)}
        folder.write("m.ini", motor.format(**values))
        done = folder.run("run", "s.ini")
        if done.returncode == 2:
            refusals_seen += 1
            checks.true(re.match(r"m.ini:\d+: \[(motor|drive)\] \w+ = \S+: LODE_ERROR_\w+: .*expected ",
                                 done.stderr), f"{values}: {done.stderr!r}")
    checks.true(20 < refusals_seen < 110, f"{refusals_seen} of 120 refused")


def others_than_the_library(checks, folder):
    """The plant, and the firmware's motor as a phase changes it."""
    refused(checks, folder, ["run", "main", "--set", "plant.i_sat_A=5", "--set",
                              "plant.Lq_sat_H=0.02"],
            r"^--set: \[plant\] Lq_sat_H = 0.02: refused by the plant: Lq_sat_H must be")
    refused(checks, folder, ["run", "main", "--set", "plant.i_cross_A=5", "--set",
                              "plant.Ldq_H=0.01"],
            r"^--set: \[plant\] Ldq_H = 0.01: refused by the plant: Ldq_H, too large")
    refused(checks, folder, ["commission", "--motor", MOTOR, "--drive", DRIVE, "--set", "motor.pole_pairs=1e30"],
            r"^--set: \[motor\] pole_pairs = 1e\+30: LODE_ERROR_MOTOR_POLE_PAIRS: expected a whole number, 1 .. 100")
    refused(checks, folder, ["commission", "--motor", MOTOR, "--drive", DRIVE, "--set", "plant.sample_offset_s=0.5"],
            r"^--set: \[plant\] sample_offset_s = 0.5: refused by the plant")
    refused(checks, folder, ["run", "main", "--set", "plant.stiction_Nm=1"],
            r"^--set: \[plant\] stiction_Nm = 1: applies only to a passive load; expected load_kind = passive")
    refused(checks, folder, ["run", "main", "--set", "start.signal_check=on", "--set", "drive.dead_time_s=2e-5"],
            r"^--set: \[start\] signal_check = on: LODE_ERROR_CHOICE: expected .*dead_time_s of at most a quarter")
    refused(checks, folder, ["run", "encoder", "--set", "encoder.bandwidth_rad_s=6000"],
            r"\[encoder\] bandwidth_rad_s = 6000: LODE_ERROR_ENCODER_BANDWIDTH: expected 1 .. 5000")
    refused(checks, folder, ["run", "main", "--set", "plant.sample_offset_s=0.5"],
            r"^--set: \[plant\] sample_offset_s = 0.5: refused by the plant")
    refused(checks, folder, ["run", "main", "--set", "phase.ramp.Lq_factor=0.01"],
            r"\[phase.ramp\] Lq_factor = 0.01, Rs_factor = 1: expected factors with which the library")


def estimator_names(checks, folder):
    listed = folder.run("list").stdout
    replay = ["replay", "--motor", MOTOR, "--recording", STEADY]
    for option in BUILT:
        done = refused(checks, folder, [*replay, option, "nonsense"],
                       f"{option}: .*expected .* or .*, not 'nonsense'")
        for name in BUILT[option] + EULER[option]:
            checks.true(name in done.stderr, f"{done.stderr!r} names {name}")
            checks.true(name in listed, f"{name} is in `lodestar list`")
    for names in (BUILT, EULER):
        for emf in names["--emf"]:
            for pll in names["--pll"]:
                checks.equal(folder.run(*replay, "--emf", emf, "--pll", pll).returncode, 0,
                             f"exit code with {emf} and {pll}")
    for emf, pll in [("c-leso", "qpll-euler"), ("c-leso-euler", "qpll")]:
        refused(checks, folder, [*replay, "--emf", emf, "--pll", pll],
                "expected an observer and a PLL that both end in -euler, or neither")
    refused(checks, folder, [*replay, "--emf", "fa-leso", "--set", "estimator.k2_rad_s=20"],
            "k2_rad_s = 20: LODE_ERROR_EMF_PLL: expected k2_rad_s at least 0.549")


def ini_files(checks, folder):
    scenario = (f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n"
                "[phase.a]\nduration_s = 0.01\n")
    for text, pattern in [
        (scenario + "bogus = 1\n", r"s.ini:6: \[phase.a\] bogus: unknown"),
        (scenario + "[motor]\nRs_Ohm = 0,75\n", r"s.ini:7: \[motor\] Rs_Ohm: expected a finite"),
        (scenario + "[motors]\nRs_Ohm = 1\n", r"s.ini:7: \[motors\] Rs_Ohm: unknown"),
        (scenario + "[motor]\nRs_Ohm = 1\nRs_Ohm = 2\n", r"s.ini:8: .*given twice, first in line 7"),
        (scenario + "load_Nm = 1\nload_Nm = 2\n", r"s.ini:7: .*given twice, first in line 6"),
        (scenario + "no equals sign\n", r"s.ini:6: expected `\[section\]`"),
        ("[scenario\nseed = 1\n", r"^s.ini:1: expected a \] after the name of the section, not '\[scenario'$"),
        ("\ufeff [scenario ; ]\nseed = 1\n", r"^s.ini:1: expected a \] after the name of the section, not '\[scenario ; '$"),
        (scenario + "[motor\nRs_Ohm = 1\n", r"^s.ini:6: expected a \] after the name of the section, not '\[motor'$"),
        (scenario + "[phase.b]\nload_Nm = 1\n", r"\[phase.b\] duration_s: missing"),
        (scenario + "[estimator]\nemf = fa-leso\nk2_rad_s = 5\n",
         r"s.ini:8: \[estimator\] k2_rad_s = 5: LODE_ERROR_EMF_PLL"),
        (scenario + "[estimator]\nsigma_rad_s = 900\n",
         r"s.ini:7: \[estimator\] sigma_rad_s = 900: LODE_ERROR_PLL_OBSERVER"),
        (scenario.replace("\n", "\r"), r"^s.ini:1: a carriage return within the line; expected lines that end with a line feed"),
        (scenario + "a = 1\rb = 2\n", r"^s.ini:6: a carriage return within the line"),
        (scenario + "# " + 300 * "x" + "\n", r"s.ini:6: expected lines of at most"),
        (scenario + f"[phase.{40 * 'x'}]\nduration_s = 1\n", r"s.ini:7: .*names of 1 to 31"),
        (scenario.replace("duration_s = 0.01", "duration_s = 0"), r"s.ini:5: .*expected a number"),
        (scenario.replace("[phase.a]\nduration_s = 0.01\n", ""), "no .phase.NAME."),
        (scenario.replace(str(MOTOR), "nowhere.ini"), r"s.ini:2: \[scenario\] motor: expected the path"),
        (scenario.replace(f"motor = {MOTOR}\n", ""), r"\[motor\] pole_pairs: missing"),
        (scenario.replace(f"drive = {DRIVE}\n", ""), r"\[drive\] f_pwm_Hz: missing; expected it in the motor.s file \(`run`, `design` and `commission` take a file of its own: --drive F.ini\), or"),
        ("Rs_Ohm = 1\n" + scenario, r"s.ini:1: Rs_Ohm: stands before the first \[section\]; did you mean \[motor\] Rs_Ohm"),
        ("", "missing|no .phase.NAME."),
        (b"\x00\xff\x00\n", "s.ini:1: a zero octet; expected text"),
        (1000 * b"\x00", "s.ini:1: a zero octet; expected text"),
    ]:
        folder.write("s.ini", text)
        refused(checks, folder, ["run", "s.ini"], pattern)
    # What counts is the place that said it: here the motor's file, not the scenario.
    folder.write("m.ini", MOTOR.read_text().replace("psi_Wb = 0.142", "psi_Wb = 0"))
    folder.write("s.ini", scenario.replace(str(MOTOR), "m.ini"))
    refused(checks, folder, ["run", "s.ini"], r"m.ini:7: \[motor\] psi_Wb = 0: LODE_ERROR_MOTOR_PSI")
    # Parts hold no scenario.
    folder.write("m.ini", MOTOR.read_text() + "[scenario]\nseed = 1\n")
    refused(checks, folder, ["run", "s.ini"], r"m.ini:\d+: \[scenario\] seed: expected in a scenario")
    refused(checks, folder, ["run", folder.path], "expected an INI file")


def names_of_data(checks, folder):
    """A motor by its name, its path, and the path it had before sim/data/: the same design."""
    said = [folder.run("design", "--motor", name, "--drive", DRIVE, "--json")
            for name in ["jiang2022", "jiang2022.ini", MOTOR, SOURCE / "sim/motors/jiang2022.ini"]]
    checks.equal([done.returncode for done in said], [0, 0, 0, 0], "exit codes")
    checks.equal(len({done.stdout for done in said}), 1, "designs")
    refused(checks, folder, ["design", "--motor", SOURCE / "sim/motors/none.ini", "--drive", DRIVE],
            "sim/motors/none.ini: No such file")


def names_beside_files(checks, folder):
    """A bare name is that of the catalogue, whatever is called so in the current folder; only regular files are read."""
    design = ["design", "--motor", "servo_48V", "--drive", "servo_48V", "--json"]
    before = folder.run(*design).stdout
    run = folder.run("run", "start", "--csv", "a.csv")
    checks.equal(run.returncode, 0, f"exit code of start: {run.stdout}")
    for make in (lambda name: folder.write(f"{name}/x", ""), lambda name: folder.write(name, "no INI file\n")):
        for name in ("servo_48V", "start"):
            make(name)
        checks.equal(folder.run(*design).stdout, before, "the catalogue's servo beside a file of its name")
        checks.equal(folder.run("run", "start", "--csv", "b.csv").returncode, 0, "start beside a file of its name")
        checks.equal((folder.path / "b.csv").read_bytes(), (folder.path / "a.csv").read_bytes(), "its signals")
        refused(checks, folder, ["run", "./start"], r"^\./start(:1)?: .*expected ")
        for name in ("servo_48V", "start"):
            path = folder.path / name
            if path.is_dir():
                (path / "x").unlink()
                path.rmdir()
            else:
                path.unlink()
    # With .ini or a folder before it, and where the catalogue has none of that name, it is the file.
    mine = MOTOR.read_text().replace("psi_Wb = 0.142", "psi_Wb = 0.1")
    for name, given in [("jiang2022.ini", "jiang2022.ini"), ("jiang2022", "./jiang2022"), ("mine", "mine")]:
        path = folder.write(name, mine)
        said = json.loads(folder.run("design", "--motor", given, "--drive", DRIVE, "--json").stdout)
        checks.equal(said["config"]["motor"]["psi_Wb"], 0.1, f"flux of {given}")
        path.unlink()
    # Motor and drive in one file may be named as both.
    both = folder.write("both.ini", mine + DRIVE.read_text())
    checks.equal(folder.run("design", "--motor", both, "--drive", both, "--json").stdout,
                 folder.run("design", "--motor", both, "--json").stdout, "one file as motor and drive")
    folder.write("s.ini", "[scenario]\nmotor = both.ini\ndrive = both.ini\n[phase.a]\nduration_s = 0.01\n")
    checks.equal(folder.run("run", "s.ini").returncode, 0, "one file as motor and drive of a scenario")
    (folder.path / "jiang2022.ini").mkdir()
    checks.equal(folder.run("design", "--motor", "jiang2022.ini").returncode, 0, "a folder that ends in .ini")
    (folder.path / "jiang2022.ini").rmdir()


def headers_of_the_drives(name="drive6.h"):
    """That header and those it includes; recorders and other blocks beside the step have no keys."""
    folder = SOURCE / "include/lodestar"
    found, waiting = {}, [name]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = (folder / name).read_text()
            waiting += re.findall(r'#include "lodestar/(\w+\.h)"', found[name])
    return [found[name] for name in sorted(found)]


def every_key_is_there(checks, folder):
    """No float field of a drive's configuration without its key."""
    derived = {"omega_rated_rad_s", "i_gain_A_count", "i_offset_count", "count_max",
               "v_bus_gain_V_count", "temperature_gain_degC_count", "temperature_offset_degC"}
    design = folder.run("design", "--motor", MOTOR, "--drive", DRIVE, "--json")
    checks.equal(design.returncode, 0, "exit code of design --json")
    keys = set(re.findall(r'"(\w+)":', design.stdout))
    fields = set(re.findall(r"^LODE_OBSERVER_FIELD\((\w+)\)", OBSERVERS, re.MULTILINE))
    checks.true(len(fields) >= 5, f"{len(fields)} fields found in observers.def, expected at least 5")
    for header in headers_of_the_drives():
        for body in re.findall(r"typedef struct \{([^}]*)\} lode_\w+_config_t;", header):
            body = re.sub(r"//.*|#.*", "", body)
            fields |= set(re.findall(r"\bfloat\s+(\w+);", body))
    checks.true(len(fields) > 40, f"{len(fields)} fields found in the headers, expected over 40")
    missing = sorted(fields - derived - keys)
    checks.equal(missing, [], "fields of the library's configuration without a key in INI files")
    # Each key is in the rig's README: the tool itself lists them.
    text = (SOURCE / "sim/README.md").read_text()
    for section in ["motor", "drive", "estimator", "current", "references", "speed", "start",
                    "guard", "plant", "scenario", "phase.start"]:
        said = folder.run("run", "main", "--set", f"{section}.unknown=1").stderr
        listed = said.split("expected one of ")[1].strip().split(", ")
        missing = [key for key in listed if not re.search(rf"\b{key}\b", text)]
        checks.equal(missing, [], f"keys of [{section}] that sim/README.md does not name")


def main():
    checks = Checks()
    with Folder() as folder:
        command_line(checks, folder)
        values(checks, folder)
        refusals(checks, folder)
        words_are_not_said_for_numbers(checks, folder)
        defaults_that_are_refused(checks, folder)
        others_than_the_library(checks, folder)
        estimator_names(checks, folder)
        ini_files(checks, folder)
        names_of_data(checks, folder)
        names_beside_files(checks, folder)
        every_key_is_there(checks, folder)
    checks.done()


main()
