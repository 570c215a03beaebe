"""`lodestar design` for a motor of one's own: data-sheet keys, speeds, and what is assumed."""
import json
import math
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, SOURCE, WASHER, Checks, Folder, refused

# A motor of 7 pole pairs at 36 V: its estimator could follow 13642 rpm, its voltage allows 8979.
SMALL = """[motor]
pole_pairs = 7
Rs_Ohm = 0.05
Ld_H = 30e-6
Lq_H = 35e-6
psi_Wb = 0.003
J_kgm2 = 3e-5
[drive]
f_pwm_Hz = 20000
v_bus_V = 36
i_max_A = 20
"""
RPM = math.pi / 30
OZIN = 0.028349523125 * 9.80665 * 0.0254


def designed(checks, folder, text, *sets):
    folder.write("m.ini", text)
    done = folder.run("design", "--motor", "m.ini", *[x for s in sets for x in ("--set", s)], "--json")
    if not checks.equal(done.returncode, 0, f"exit code of design {text} {sets}: {done.stderr}"):
        return {}
    return json.loads(done.stdout)


def data_sheets(checks, folder):
    """Each key against its definition, worked out here for 7 pole pairs."""
    np = 7
    motor = {"pole_pairs": "pole_pairs = 7", "Rs_Ohm": "Rs_Ohm = 0.05", "Ld_H": "Ld_H = 30e-6",
             "Lq_H": "Lq_H = 35e-6", "psi_Wb": "psi_Wb = 0.003", "J_kgm2": "J_kgm2 = 3e-5"}
    drive = "[drive]\nf_pwm_Hz = 20000\nv_bus_V = 36\ni_max_A = 20\n"
    sheets = [
        ("poles = 14", {"pole_pairs": 7}),
        ("Rs_mOhm = 62", {"Rs_Ohm": 0.062}),
        ("R_line_line_Ohm = 0.11", {"Rs_Ohm": 0.055}),
        ("R_line_line_mOhm = 110", {"Rs_Ohm": 0.055}),
        ("R_winding_Ohm = 0.15\nwinding = delta", {"Rs_Ohm": 0.05}),
        ("R_winding_Ohm = 0.05\nwinding = star", {"Rs_Ohm": 0.05}),
        ("R_winding_mOhm = 150\nwinding = delta", {"Rs_Ohm": 0.05}),
        ("Ld_mH = 0.031", {"Ld_H": 31e-6}),
        ("Ld_uH = 31", {"Ld_H": 31e-6}),
        ("Lq_mH = 0.036", {"Lq_H": 36e-6}),
        ("Lq_uH = 36", {"Lq_H": 36e-6}),
        ("Ld_line_line_mH = 0.062", {"Ld_H": 31e-6}),
        ("Ld_line_line_uH = 62", {"Ld_H": 31e-6}),
        ("Lq_line_line_mH = 0.072", {"Lq_H": 36e-6}),
        ("Lq_line_line_uH = 72", {"Lq_H": 36e-6}),
        ("L_mH = 0.033", {"Ld_H": 33e-6, "Lq_H": 33e-6}),
        ("L_uH = 33", {"Ld_H": 33e-6, "Lq_H": 33e-6}),
        ("L_line_line_mH = 0.066", {"Ld_H": 33e-6, "Lq_H": 33e-6}),
        ("L_line_line_uH = 66", {"Ld_H": 33e-6, "Lq_H": 33e-6}),
        ("L_winding_mH = 0.099\nwinding = delta", {"Ld_H": 33e-6, "Lq_H": 33e-6}),
        ("L_winding_uH = 33\nwinding = star", {"Ld_H": 33e-6, "Lq_H": 33e-6}),
        ("psi_mWb = 2.9", {"psi_Wb": 2.9e-3}),
        # At 270 rpm the peak between two terminals is 1 V.
        ("KV_rpm_V = 270", {"psi_Wb": 1 / math.sqrt(3) / (270 * RPM * np)}),
        ("ke_Vrms_krpm = 2.6", {"psi_Wb": 2.6 * math.sqrt(2 / 3) / (1000 * RPM * np)}),
        ("ke_Vpk_krpm = 3.7", {"psi_Wb": 3.7 / math.sqrt(3) / (1000 * RPM * np)}),
        ("ke_V_Hz = 0.0188", {"psi_Wb": 0.0188 / (2 * math.pi)}),
        ("kt_Nm_A = 0.0315", {"psi_Wb": 0.0315 / (1.5 * np)}),
        ("kt_mNm_A = 31.5", {"psi_Wb": 0.0315 / (1.5 * np)}),
        ("kt_Nm_Arms = 0.0445", {"psi_Wb": 0.0445 / math.sqrt(2) / (1.5 * np)}),
        ("kt_ozin_A = 4.46", {"psi_Wb": 4.46 * OZIN / (1.5 * np)}),
        ("J_gcm2 = 310", {"J_kgm2": 3.1e-5}),
        ("J_kgcm2 = 0.31", {"J_kgm2": 3.1e-5}),
        ("J_ozins2 = 0.0044", {"J_kgm2": 0.0044 * OZIN}),
    ]
    for line, wanted in sheets:
        kept = [text for key, text in motor.items() if key not in wanted]
        config = designed(checks, folder, "[motor]\n" + "\n".join([line, *kept]) + "\n" + drive)
        for key, value in wanted.items():
            found = config.get("config", {}).get("motor", {}).get(key, math.nan)
            checks.at_most(abs(found / value - 1), 1e-6, f"{line!r}: {key} = {found}, off {value}")
    # All of them are in the test, and documented.
    listed = folder.run("design", "--motor", "m.ini", "--set", "motor.x=1").stderr
    keys = set(listed.split("expected one of ")[1].strip().split(", "))
    plain = {*motor, "B_Nms", "sets", "Lxy_H", "speed_rated_rpm"}
    tested = {word.split(" = ")[0] for line, _ in sheets for word in line.split("\n")}
    checks.equal(keys - plain, tested, "keys of data sheets")
    text = (SOURCE / "docs/configuration.md").read_text()
    checks.equal([k for k in tested if f"`{k}" not in text], [], "keys that configuration.md lacks")
    # The whole of a hobby motor's sheet, with the place that gave each value.
    folder.write("sheet.ini", "[motor]\npoles = 14\nKV_rpm_V = 750\nR_line_line_mOhm = 110\n"
                              "L_line_line_uH = 60\nJ_gcm2 = 300\n" + drive.replace("36", "14.8"))
    done = folder.run("design", "--motor", "sheet.ini")
    checks.equal(done.returncode, 0, f"exit code of design with a data sheet: {done.stderr}")
    for wanted in ["psi_Wb                 = 0.00105015   ; sheet.ini:3: KV_rpm_V",
                   "Lq_H                   = 3e-05        ; sheet.ini:5: L_line_line_uH"]:
        checks.true(wanted in done.stdout, f"{wanted!r} is printed")


def conflicts(checks, folder):
    base = SMALL.split("[drive]")[0]
    for more, pattern in [
        ("KV_rpm_V = 270\n", r"m.ini:8: \[motor\] KV_rpm_V: sets the same quantity as psi_Wb in m.ini:6; "),
        ("L_uH = 30\n", r"m.ini:8: \[motor\] L_uH: sets the same quantity as Ld_H in m.ini:4; expected one"),
        ("poles = 14\n", r"m.ini:8: \[motor\] poles: sets the same quantity as pole_pairs in m.ini:2; "),
    ]:
        folder.write("m.ini", base + more)
        refused(checks, folder, ["design", "--motor", "m.ini"], pattern)
    folder.write("m.ini", base.replace("psi_Wb = 0.003", "ke_V_Hz = 1") + "kt_Nm_A = 1\n")
    refused(checks, folder, ["design", "--motor", "m.ini"],
            r"m.ini:8: \[motor\] kt_Nm_A: sets the same quantity as ke_V_Hz in m.ini:6; expected one of them")
    folder.write("m.ini", base)
    refused(checks, folder, ["design", "--motor", "m.ini", "--set", "motor.Rs_mOhm=50", "--set", "motor.Rs_Ohm=0.05"],
            r"--set: \[motor\] Rs_mOhm: sets the same quantity as Rs_Ohm in --set; expected one of them")
    folder.write("m.ini", base.replace("Rs_Ohm = 0.05", "R_winding_Ohm = 0.1"))
    refused(checks, folder, ["design", "--motor", "m.ini"],
            r"m.ini:3: \[motor\] R_winding_Ohm: expected winding = star or winding = delta as well")
    folder.write("m.ini", base.replace("J_kgm2 = 3e-5", ""))
    refused(checks, folder, ["design", "--motor", "m.ini"], r"J_kgm2: missing.*J_gcm2")


def held_current(folder, rpm, sets):
    """q current that flows with the shaft held at this speed and all torque asked for."""
    folder.write("held.ini", "[scenario]\nmotor = m.ini\n[phase.up]\nduration_s = 3\n"
                             "speed_rpm = 7000\n[phase.held]\nduration_s = 1\nspeed_rpm = 12000\n"
                             f"dyno_rpm = {rpm}\n")
    folder.run("run", "held.ini", "--json", "h.json", *[x for s in sets for x in ("--set", s)])
    return folder.json("h.json")["phases"][-1]


def speeds(checks, folder):
    """Where the plant runs out of voltage, and what design says of it."""
    plain = designed(checks, folder, SMALL)
    checks.at_most(abs(plain["estimator_limit_rpm"] - 10000 / 7 / RPM), 0.1, "estimator limit")
    no_load = 0.95 * 36 / math.sqrt(3) / 0.003 / 7 / RPM
    checks.at_most(abs(plain["no_load_limit_rpm"] - no_load), 0.1, "no-load limit")
    folder.write("free.ini", "[scenario]\nmotor = m.ini\n[phase.up]\nduration_s = 2\n"
                             "speed_rpm = 2000\n[phase.high]\nduration_s = 3\nspeed_rpm = 12000\n")
    folder.run("run", "free.ini", "--json", "f.json")
    reached = folder.json("f.json")["phases"][-1]["speed_rpm"]["mean"]
    checks.at_most(abs(reached / no_load - 1), 0.01, f"{reached} rpm without load, off {no_load}")
    for sets in [["motor.Rs_Ohm=0.1"], ["motor.Lq_H=60e-6"],
                 ["motor.Lq_H=60e-6", "references.strategy=mtpa"]]:
        base = designed(checks, folder, SMALL, *sets)["base_speed_rpm"]
        below, above = (held_current(folder, share * base, sets) for share in (0.98, 1.02))
        for phase, what in [(below, "below"), (above, "above")]:
            checks.equal(phase["mode"], "RUN", f"mode {what} {base} rpm, {sets}")
        least = 0.995 * math.sqrt(400 - below["id_A"]["rms"] ** 2)
        checks.true(below["iq_A"]["rms"] > least, f"all current below base speed, {sets}: {below}")
        checks.true(above["iq_A"]["rms"] < 0.97 * least, f"not above base speed, {sets}: {above}")
    checks.equal(plain["weakened_limit_rpm"], None, "no field weakening, no such limit")
    weak = designed(checks, folder, SMALL, "references.field_weakening=on")
    used = 0.95 * 0.95 * 36 / math.sqrt(3)
    limit = math.sqrt(used ** 2 - 1) / (0.003 - 30e-6 * 20) / 7 / RPM
    checks.at_most(abs(weak["weakened_limit_rpm"] / limit - 1), 1e-5, "limit with a weakened field")
    done = folder.run("design", "--motor", "m.ini")
    for row in ["rated               6195.9   assumed: ", "base speed          8312.1   ",
                "no-load limit       8978.8   ", "estimator limit    13641.9   omega_max_rad_s"]:
        checks.true(row in done.stdout, f"{row!r} is printed")
    checks.true("highest" not in done.stdout, "no speed is called highest")


def assumed(checks, folder):
    """What nobody gave is marked where it stands: on the screen, in JSON and in C."""
    open_keys = {"motor.B_Nms", "motor.speed_rated_rpm", "drive.dead_time_s", "drive.v_drop_V",
                 "drive.r_on_Ohm", "drive.pwm_ticks", "drive.shunts", "drive.adc_bits",
                 "drive.i_range_A", "drive.v_range_V"}
    load = {"plant.emf5_ratio", "plant.emf7_ratio", "plant.i_noise_A"}
    drive = {"drive.f_pwm_Hz", "drive.v_bus_V", "drive.i_max_A"}
    alone = designed(checks, folder, SMALL.split("[drive]")[0])
    checks.equal(set(alone["assumed"]), open_keys | load | drive, "assumed for a motor alone")
    some = designed(checks, folder, SMALL, "drive.dead_time_s=0", "motor.B_Nms=0",
                    "plant.emf5_ratio=0.01", "motor.speed_rated_rpm=6000")
    given = {"drive.dead_time_s", "motor.B_Nms", "plant.emf5_ratio", "motor.speed_rated_rpm"}
    checks.equal(set(some["assumed"]), (open_keys | load) - given, "what is given is not assumed")
    checks.equal(some["fa_guideline"]["load_step_assumed"], "half the torque at i_max", "the load")
    folder.write("m.ini", SMALL)
    done = folder.run("design", "--motor", "m.ini", "--set", "drive.i_range_A=40", "--set",
                      "drive.v_range_V=60", "--json=d.json", "--c", "my.c")
    checks.equal((done.returncode, done.stderr), (0, ""), "design --c")
    source = (folder.path / "my.c").read_text()
    for key in open_keys - {"drive.i_range_A", "drive.v_range_V"}:
        section, name = key.split(".")
        line = f"assumed: [{section}] {name} = "
        checks.true(f"\n{line}" in f"\n{done.stdout}", f"{line!r} on the screen")
        checks.true(f"// {line}" in source, f"{line!r} in C")
        checks.true(key in folder.json("d.json")["assumed"], f"{key} in JSON")
    checks.true("[plant]" not in source, "nothing of the plant in C")
    checks.true("r_on_Ohm               = 0            ; assumed: switches without" in done.stdout, "in the list")
    checks.true("(assumed)" in done.stdout.split("FA-LESO: gain k2")[1], "in the guideline")
    done = folder.run("design", "--motor", MOTOR, "--drive", DRIVE)
    checks.true("dead time takes 5.09 V" in done.stdout, "dead time that is given")
    checks.equal([line for line in done.stdout.splitlines() if line.startswith("assumed: [drive]")],
                 ["assumed: [drive] shunts = three: a current sensor in each phase"],
                 "assumed of a drive that is described")


def slow_for_its_rotor(checks, folder):
    """A rotor that is too quick for the control rate: a higher one is what helps, and the tool says which."""
    motor = ["design", "--motor", "servo_3kW", "--drive", "servo_3kW"]
    said = folder.run(*motor, "--set", "drive.f_pwm_Hz=4000").stdout
    found = re.search(r"largest load step at \d+ rpm is \d+ % of rated torque: raise drive.f_pwm_Hz to (\d+)", said)
    checks.true(found, f"a higher rate is proposed: {said[-900:]}")
    after = folder.run(*motor, "--set", f"drive.f_pwm_Hz={found[1]}").stdout
    checks.true("verdict" in after and "change: the largest load step" not in after, f"at {found[1]} Hz: {after[-900:]}")


def first_turn(checks, folder):
    """A motor's data sheet and nothing else: it runs, and what was assumed for it is said."""
    folder.write("sheet.ini", "; from a data sheet\n[motor]\npoles = 14\nKV_rpm_V = 750\n"
                              "R_line_line_mOhm = 110\nL_line_line_uH = 60\nJ_gcm2 = 300\n")
    motors = ["sheet.ini", *sorted(p.stem for p in (SOURCE / "sim/data/motors").glob("*.ini"))]
    for motor in motors:
        done = folder.run("run", "--motor", motor, "--json", "t.json")
        checks.equal(done.returncode, 0, f"exit code of run --motor {motor}: {done.stdout}{done.stderr}")
        result = folder.json("t.json")
        phases = {p["name"]: p for p in result["phases"]}
        above = phases["start"]["speed_command_rpm"] >= 0.5 * phases["full_speed"]["speed_command_rpm"]
        checks.equal(list(phases), ["start", *([] if above else ["half_speed"]), "full_speed", "load", "no_load", "stop"],
                     f"phases of {motor}")
        if not above:
            checks.at_most(abs(phases["half_speed"]["speed_command_rpm"] / phases["full_speed"]["speed_command_rpm"] - 0.5),
                           1e-6, f"half speed of {motor}")
        checks.true(not any(p["warning"] for p in phases.values()), f"warnings of {motor}: {phases}")
        checks.equal(phases["stop"]["mode"], "OFF", f"{motor} stops")
        checks.true(phases["load"]["load_Nm"] > 0, f"load of {motor}")
        for key in ["f_pwm_Hz", "i_max_A", "v_bus_V", "dead_time_s"]:
            checks.true(f"assumed: [drive] {key} = " in done.stdout, f"{key} of {motor}, in the table")
            checks.true(f"drive.{key}" in result["assumed"], f"{key} of {motor}, in JSON")
    # With a drive of its own, and over many seeds.
    done = folder.run("run", "--motor", "drone_900KV", "--drive", "drone_900KV", "--seeds", "1-2")
    checks.true("2 of 2 passed" in done.stdout, f"a campaign with a motor: {done.stdout}{done.stderr}")
    checks.equal(done.returncode, 0, "its exit code")
    refused(checks, folder, ["run", "main", "--motor", "sheet.ini"], "expected a scenario or --motor")
    refused(checks, folder, ["run"], "run: expected a scenario file, or --motor F.ini")
    folder.write("both.ini", (folder.path / "sheet.ini").read_text()
                 + "[drive]\nf_pwm_Hz = 20000\nv_bus_V = 12\ni_max_A = 10\n")
    refused(checks, folder, ["run", "both.ini"], "For a file with only a motor use --motor")


def later_sources_win(checks, folder):
    """Of two keys for one quantity in two sources the later one counts: the motor's file, the drive's, --set."""
    folder.write("m.ini", SMALL.split("[drive]")[0].replace("Rs_Ohm = 0.05", "R_winding_Ohm = 0.1\nwinding = star"))
    drive = "[drive]" + SMALL.split("[drive]")[1]
    def found(more, *sets):
        folder.write("d.ini", drive + "[motor]\n" + more)
        arguments = ["design", "--motor", "m.ini", "--drive", "d.ini", *[x for s in sets for x in ("--set", s)]]
        done = folder.run(*arguments, "--json")
        checks.equal(done.returncode, 0, f"exit code with {more!r} {sets}: {done.stderr}")
        return json.loads(done.stdout)["config"]["motor"], folder.run(*arguments).stdout

    for more, sets, key, value, place in [
        ("", [], "Rs_Ohm", 0.1, "m.ini:3: R_winding_Ohm"),
        ("", ["motor.Rs_Ohm=0.07"], "Rs_Ohm", 0.07, "command line"),
        ("", ["motor.Rs_mOhm=60"], "Rs_Ohm", 0.06, "command line: Rs_mOhm"),
        ("Rs_mOhm = 80\n", [], "Rs_Ohm", 0.08, r"d.ini:6: Rs_mOhm"),
        ("Rs_mOhm = 80\n", ["motor.R_line_line_Ohm=0.18"], "Rs_Ohm", 0.09, "command line: R_line_line_Ohm"),
        ("Rs_Ohm = 0.08\n", [], "Rs_Ohm", 0.08, "d.ini:6"),
        ("poles = 10\n", [], "pole_pairs", 5, "d.ini:6: poles"),
        # One key for both axes, of which a later source gives one.
        ("L_uH = 40\n", ["motor.Lq_uH=45"], "Lq_H", 45e-6, "command line: Lq_uH"),
        ("L_uH = 40\n", ["motor.Lq_uH=45"], "Ld_H", 40e-6, "d.ini:6: L_uH"),
        ("L_uH = 40\n", [], "Lq_H", 40e-6, "d.ini:6: L_uH"),
    ]:
        motor, text = found(more, *sets)
        checks.at_most(abs(motor[key] / value - 1), 1e-6, f"{key} with {more!r} {sets}: {motor[key]}")
        checks.true(f"; {place}\n" in text, f"{key} with {more!r} {sets}: {place} in {text}")
    # A winding's value that has lost needs no connection.
    folder.write("m.ini", (folder.path / "m.ini").read_text().replace("winding = star\n", ""))
    found("", "motor.Rs_Ohm=0.07")
    # In a scenario its own keys come after those of the files that it names, and before --set.
    folder.write("s.ini", "[scenario]\nmotor = m.ini\ndrive = d.ini\n[motor]\nRs_Ohm = 0.06\n[start]\nhandover_rpm = 400\n"
                          "[phase.a]\nduration_s = 0.01\n")
    for sets, Rs, omega in ([], 0.06, 400 * RPM * 7), (["motor.Rs_mOhm=65", "start.omega_handover_rad_s=300"], 0.065, 300):
        done = folder.run("run", "s.ini", "--json", "s.json", *[x for s in sets for x in ("--set", s)])
        checks.equal(done.returncode, 0, f"scenario with {sets}: {done.stderr}")
        config = folder.json("s.json")["config"]
        checks.at_most(abs(config["motor"]["Rs_Ohm"] / Rs - 1), 1e-6, f"Rs of a scenario with {sets}")
        checks.at_most(abs(config["start"]["omega_handover_rad_s"] / omega - 1), 1e-6, f"hand-over of a scenario with {sets}")


# Its rated speed is more than the estimator can follow at 5 kHz, and within what the bus allows.
FAST = """[motor]
pole_pairs = 7
Rs_Ohm = 0.1
L_uH = 300
KV_rpm_V = 300
J_gcm2 = 500
speed_rated_rpm = 6000
[drive]
f_pwm_Hz = 5000
v_bus_V = 44
i_max_A = 20
"""


def full_speed(checks, folder):
    """Of a motor without a scenario: no more than the estimator can follow, and a warning where that is less."""
    folder.write("fast.ini", FAST)
    limit_rpm = 0.5 * 5000 / 7 * 30 / math.pi
    slow_drone = ["drone_900KV", "--drive", "drone_900KV", "--set", "drive.f_pwm_Hz=6000"]
    for motor, limit in ((["fast.ini"], limit_rpm), (slow_drone, 1.2 * limit_rpm)):
        done = folder.run("run", "--motor", *motor, "--json", "t.json")
        checks.equal(done.returncode, 0, f"{motor[0]}: {done.stdout}{done.stderr}")
        phases = {p["name"]: p for p in folder.json("t.json")["phases"]}
        for name in ("full_speed", "load", "no_load"):
            rpm = phases[name]["speed_rpm"]["mean"]
            checks.at_most(abs(rpm / (0.95 * limit) - 1), 0.005, f"{motor[0]}, {name}: {rpm} rpm of {limit:.0f}")
        said = {name: p["warning"] for name, p in phases.items() if p["warning"]}
        checks.equal(list(said), ["full_speed"], f"{motor[0]}: warnings {said}")
        checks.true(f"rpm is above 0.95 of the estimator's limit of {limit:.0f} rpm, lowered to {0.95 * limit:.0f} rpm"
                    in said.get("full_speed", ""), f"{motor[0]}: {said}")
    folder.run("run", "--motor", "fast.ini", "--set", "drive.f_pwm_Hz=20000", "--json", "t.json")
    checks.true(not any(p["warning"] for p in folder.json("t.json")["phases"]), "a quicker drive follows")


# A rotor so light that half of its torque at once would stop it at any speed it reaches.
LIGHT = """[motor]
poles = 10
R_line_line_Ohm = 0.62
L_line_line_mH = 0.75
ke_Vrms_krpm = 3.6
J_kgcm2 = 0.06
speed_rated_rpm = 3000
[drive]
v_bus_V = 24
i_max_A = 15
f_pwm_Hz = 20000
"""


def trial_load(checks, folder):
    """No more than (K18) allows, and said beside it; --set has the last word on every phase."""
    folder.write("light.ini", LIGHT)
    def trial(*arguments):
        done = folder.run("run", *arguments, "--json", "t.json")
        said = [line for line in done.stdout.splitlines() if line.startswith("load of the trial: ")]
        checks.equal(len(said), 1, f"{arguments}: a line with the load: {done.stdout}{done.stderr}")
        return done, {p["name"]: p for p in folder.json("t.json")["phases"]}, said[0]

    for motor in (["--motor", "light.ini"], ["--motor", "gimbal_12V", "--drive", "gimbal_12V"],
                  ["--motor", "servo_48V", "--drive", "servo_48V"]):
        config = json.loads(folder.run("design", *motor, "--json").stdout)["config"]
        done, phases, said = trial(*motor)
        checks.equal(done.returncode, 0, f"{motor}: {done.stdout}")
        load, rpm = phases["load"]["load_Nm"], phases["load"]["speed_command_rpm"]
        most = 1.5 * config["motor"]["pole_pairs"] * config["motor"]["psi_Wb"] * config["drive"]["i_max_A"]
        span = config["speed"].get("gain_rise")
        step = min(step_as_k18(config, rpm, 1.0 if not isinstance(span, float) else span), most / (1 + math.exp(-2)))
        checks.at_most(abs(load / min(0.5 * most, step) - 1), 1e-3, f"{motor}: load {load} Nm, step {step} Nm")
        words = (f": the largest load step at {rpm:.0f} rpm" if load < 0.499 * most
                 else f"; the largest load step is {step:.3g} Nm at {rpm:.0f} rpm")
        checks.equal(said, f"load of the trial: {load:.3g} Nm, {100 * load / most:.0f} % of the torque at i_max{words} (see `design`)",
                     f"{motor}")
        if motor[1] == "light.ini":
            checks.equal(list(phases), ["start", "full_speed", "load", "no_load", "stop"], "no half speed above full speed's half")
            allowed = load
    done, phases, said = trial("--motor", "light.ini", "--set", "phase.load.load_Nm=0.5", "--set", "motor.B_Nms=1e-7",
                               "--set", "phase.full_speed.duration_s=0.5")
    checks.equal(phases["load"]["load_Nm"], 0.5, "a load that was set")
    checks.equal(done.returncode, 1, "more than it stands")
    checks.true(f"; {0.5 / allowed:.3g} times the largest load step of {allowed:.3g} Nm at " in said, said)
    checks.at_most(abs(phases["full_speed"]["end_s"] - phases["full_speed"]["start_s"] - 0.5), 1e-3, "a duration that was set")
    campaign = folder.run("run", "--motor", "light.ini", "--seeds", "1-2", "--set", "phase.load.bar_speed_rpm=20")
    checks.true("\n2 of 2 passed\n" in campaign.stdout, f"a bar for the trial: {campaign.stdout}{campaign.stderr}")
    refused(checks, folder, ["run", "--motor", "light.ini", "--set", "phase.foo.duration_s=3"],
            r"^--set: \[phase.foo\] duration_s: expected the name of a phase of the scenario: start, full_speed, load, no_load, stop$")
    refused(checks, folder, ["design", "--motor", "light.ini", "--set", "phase.load.load_Nm=3"],
            r"^--set: \[phase.load\] load_Nm: expected no phase, there is no scenario here$")


# WASHER: speed control is slower than a 10000th of the PWM frequency, and the voltage ends far below rated speed.
def heavy(checks, folder):
    """Its loops have margins, and the base speed says with which d current it is reached."""
    found = designed(checks, folder, WASHER)
    for loop in found["verdict"]["loops"]:
        if loop["loop"] == "speed":
            checks.at_most(abs(loop["crossover_rad_s"] / found["speed_bandwidth_rad_s"] - 1), 0.1, f"crossover: {loop}")
            checks.true(60 < loop["phase_margin_deg"] < 90, f"margin: {loop}")
    text = folder.run("design", "--motor", "m.ini").stdout
    checks.true("i_max uses up the voltage (6 A, id0: id* = -1.33 A)" in text, "the bias at base speed")
    bare = folder.run("design", "--motor", "m.ini", "--set", "references.id_bias_A=none").stdout
    checks.true("i_max uses up the voltage (6 A, id0: id* = 0 A)" in bare, "none")
    analysed = folder.run("analyse", "--motor", "m.ini").stdout
    rows = [line for line in analysed.splitlines() if line.startswith("speed, PI alone")]
    checks.true(rows and not any("nan" in row or " -" in row for row in rows), f"loops of analyse: {rows}")


def open_fields(checks, folder):
    """What a field stands for that the design leaves open."""
    expected = [([], {"double_update": "off", "ramp_down_rad_s2": "as ramp_rad_s2", "pulses": "on", "signal_check": "on"}),
                (["--set", "drive.double_update=on"], {"pulses": "off", "signal_check": "on"}),
                (["--set", "start.catch_s=none"], {"pulses": "off", "signal_check": "off"})]
    for arguments, fields in expected:
        text = folder.run("design", "--motor", "jiang2022", "--drive", "jiang2022", *arguments).stdout
        for key, means in fields.items():
            checks.true(re.search(rf"^{key} += \w+ +; default or computed: {means}$", text, re.M), f"{key} with {arguments}")


def heavy_trial(checks, folder):
    """Phases that fit a slow loop: a start no longer than it takes, loads until the speed is back, a stop that comes to rest."""
    folder.write("m.ini", WASHER)
    def trial(*arguments):
        done = folder.run("run", "--motor", "m.ini", *arguments, "--json", "t.json")
        checks.equal(done.returncode, 0, f"{arguments}: {done.stdout}{done.stderr}")
        result = folder.json("t.json")
        return done.stdout, {p["name"]: p for p in result["phases"]}, result

    text, phases, result = trial()
    checks.equal([p["warning"] for p in phases.values() if p["warning"]], [], "warnings")
    checks.equal(result["warnings"], 0, "their number")
    start = phases["start"]
    checks.at_most(start["end_s"] - result["handover_s"], 4.0, "what remains of the start after the hand-over, s")
    checks.at_most(abs(start["speed_rpm"]["mean"] / 240 - 1), 0.002, f"start: {start}")
    checks.true(24 / 5 < phases["load"]["end_s"] - phases["load"]["start_s"] < 24 / 4, f"24 time constants and more: {phases['load']}")
    checks.equal(phases["stop"]["mode"], "OFF", "the stop")
    checks.true("\nfull speed of the trial: 241 of the rated 1200 rpm: bus voltage; it is 0.9 of the base speed of 267 rpm\n" in text, text)
    text, phases, result = trial("--set", "phase.start.duration_s=12", "--set", "phase.stop.duration_s=2")
    checks.at_most(abs(phases["start"]["end_s"] - 12), 1e-3, "a duration that was set lasts whole")
    checks.true(re.search(r"^0 rpm not reached: \d+(\.\d+)? rpm at the end, in START$", phases["stop"]["warning"]), f"a stop of 2 s: {phases['stop']}")
    checks.true("; 1 warning above\n" in text, text[-300:])
    text, phases, _ = trial("--set", "motor.speed_rated_rpm=200", "--set", "motor.J_kgm2=0.02")
    checks.true("full speed of the trial" not in text, "a rated speed that is reached")


def injection(checks, folder):
    """Whether signal injection is possible, and what it would be, worked out here for paper 1's motor."""
    command = ["design", "--motor", "jiang2022", "--drive", "jiang2022", "--set", "hfi.noise_A=0.02",
               "--set", "hfi.V_h_V=25"]
    found = json.loads(folder.run(*command, "--json").stdout)["injection"]
    Ts, Ld, Lq, V, sigma = 2e-4, 3.5e-3, 9.8e-3, 25, 100
    noise = math.sqrt(6) / 2 * 0.02 / V * Ld / Ts * Lq / (Lq - Ld)
    wanted = {"saliency": Lq / Ld, "V_h_V": V, "ripple_A": V * Ts / Ld, "tone_Hz": 0.5 / Ts, "id_A": 0,
              "circle_share": V / (0.95 * 200 / math.sqrt(3)),
              "ripple_Nm": 1.5 * 3 * (Lq - Ld) * 12 * V * Ts / Ld,
              "noise_deg": math.degrees(noise * math.sqrt(8 / 3 * 33 / 16 * sigma * Ts)),
              "dead_time_rad": (200 * 4e-6 / Ts + 1) / (V * (Lq / Ld - 1)), "sigma_rad_s": sigma}
    checks.equal([found["on"], found["status"]], [False, "LODE_OK"], "possible, and off")
    for key, value in wanted.items():
        checks.at_most(abs(found[key] - value), 1e-4 * max(value, 1), f"{key}: {found[key]}")
    checks.at_most(found["w1_rad_s"] / found["w2_rad_s"], 0.651, "the blend")
    # Signs at random: 2 in place of 8/3. Two calls a carrier: half of the dead time's edges in each.
    silent = json.loads(folder.run(*command, "--set", "hfi.silent=on", "--json").stdout)["injection"]
    checks.at_most(abs(silent["noise_deg"] / found["noise_deg"] - math.sqrt(3 / 4)), 1e-5, "noise of signs at random")
    twice = json.loads(folder.run(*command, "--set", "drive.double_update=on", "--json").stdout)["injection"]
    checks.at_most(abs(twice["dead_time_rad"] - (100 * 4e-6 / Ts + 1) / (V * (Lq / Ld - 1))), 1e-4, "dead time")
    # The angle by a load that turns round (P7), and who does not follow it.
    acc = 2 * 3 * (1.5 * 3 * 0.142 * 12) / 0.0174
    checks.at_most(abs(found["torque_Nm"] / (1.5 * 3 * 0.142 * 12) - 1), 1e-3, f"torque {found['torque_Nm']}")
    checks.at_most(abs(found["step_deg"] - math.degrees(2 * math.exp(-2) * acc / sigma ** 2)), 0.01, "step, LESO-QPLL")
    second = json.loads(folder.run(*command, "--set", "estimator.pll=qpll", "--json").stdout)["injection"]
    checks.at_most(abs(second["step_deg"] - math.degrees(acc / second["sigma_rad_s"] ** 2)), 0.01, "step, QPLL")
    checks.at_most(abs(second["step_emf_deg"] - math.degrees(acc / (1.65 * sigma) ** 2)), 0.01, "step, QPLL, by the EMF")
    for motor, pll, loses in [("jiang2022", "qpll", False), ("pmsyrm_5kW", "qpll", True),
                              ("pmsyrm_5kW", "leso-qpll", False), ("traction_400V", "qpll", False)]:
        light = ["design", "--motor", motor, "--drive", motor, "--set", f"estimator.pll={pll}"]
        checks.equal(json.loads(folder.run(*light, "--json").stdout)["injection"]["loses_steps"], loses, f"{motor}, {pll}")
        said = "does not follow so light a rotor; expected estimator.pll = leso-qpll" in folder.run(*light).stdout
        checks.equal(said, loses, f"{motor}, {pll}: the warning")
    text = folder.run(*command).stdout
    checks.true("zero and low speed: off (hfi.mode)\npossible: hfi.mode = on\n" in text, "said to be possible")
    for motor in ("jiang2022", "pmsyrm_5kW", "traction_100kW", "traction_400V"):  # (S54), worked out here
        values = json.loads(folder.run("design", "--motor", motor, "--drive", motor, "--json").stdout)
        m = values["config"]["motor"]
        share = (m["Lq_H"] - m["Ld_H"]) * values["config"]["drive"]["i_max_A"] / m["psi_Wb"]
        checks.equal(values["injection"]["recommended"], 1.5 * share > 1 / (0.8 * 2 / 3),
                     f"{motor}: recommended")
        checks.equal(values["injection"]["on"], values["injection"]["recommended"], f"{motor}: the default")
    reluctance = ("design", "--motor", "pmsyrm_5kW", "--drive", "pmsyrm_5kW")
    checks.true("zero and low speed: on\nin use\n" in folder.run(*reluctance).stdout, "the default is said to be in use")
    checks.true("zero and low speed: off (hfi.mode)\nrecommended, and the default: the current vector of a start"
                in folder.run(*reluctance, "--set", "hfi.mode=off").stdout, "said to be recommended")
    text = folder.run(*command, "--set", "hfi.mode=on").stdout
    checks.true("zero and low speed: on\nin use\n" in text, "said to be used")
    round_rotor = folder.run("design", "--motor", "ebike_hub", "--drive", "ebike_hub").stdout
    checks.true("not possible: the rotor is not salient enough" in round_rotor
                and "LODE_ERROR_HFI_SALIENCY" in round_rotor, "why not")
    other = folder.run(*command, "--set", "hfi.w2_rad_s=50", "--set", "hfi.w1_rad_s=60").stdout
    checks.true("not possible: w1 and w2 do not lie" in other, "why not, of a setting")
    other = folder.run(*command, "--set", "hfi.sigma_rad_s=9000").stdout
    checks.true("not possible: the library refuses the configuration with it (LODE_ERROR_HFI_SIGMA)" in other,
                "why not, of another")
    six = folder.run("design", "--motor", "ultrazohm6", "--drive", "ultrazohm6").stdout
    checks.true("possible: hfi.mode = on" in six, "six phases, too")


def step_as_k18(config, speed_rpm, gain=1.0):
    """(K18), worked out here: the load that leaves half of the hand-over speed; with (K47) beyond 30 % of the speed."""
    np, speed = config["motor"]["pole_pairs"], config["speed"]
    fed, dip = [0.0 if isinstance(x, str) else max(x, 0) for x in (speed["load_feed_forward"], speed["dip_gain"])]
    room = speed_rpm * RPM * np - 0.5 * config["start"]["omega_handover_rad_s"]
    room += 0.5 * dip * max(room - 0.3 * speed_rpm * RPM * np, 0.0)
    return room * gain * speed["kp_Nms"] / (1.2 * 2 / math.e * np * (1 - 0.5 * fed))


def verdict_of(checks, folder, text, *sets):
    return designed(checks, folder, text, *sets).get("verdict", {})


def verdict_numbers(checks, folder):
    """The verdict on paper 1's motor, worked out here."""
    done = folder.run("design", "--motor", MOTOR, "--drive", DRIVE, "--json")
    found = json.loads(done.stdout)
    verdict, config = found["verdict"], found["config"]
    checks.equal(set(verdict), {"lowest_rpm", "highest_rpm", "base_speed_rpm", "rated_torque_speed_rpm",
                                "weakened_limit_rpm", "estimator_limit_rpm", "rated_torque_Nm",
                                "step_at_handover", "step_at_base", "loops", "changes"}, "keys of the verdict")
    checks.at_most(abs(verdict["lowest_rpm"] - 150), 0.1, "lowest speed")
    checks.at_most(abs(verdict["highest_rpm"] - found["no_load_limit_rpm"]), 0.1, "highest speed")
    checks.true(found["base_speed_rpm"] < verdict["rated_torque_speed_rpm"] < found["no_load_limit_rpm"],
                "a smaller current is reached up to a higher speed")
    rated = 1.5 * 3 * 0.142 * 12 / 1.5
    checks.at_most(abs(verdict["rated_torque_Nm"] / rated - 1), 1e-5, "rated torque")
    low, base = verdict["step_at_handover"], verdict["step_at_base"]
    checks.at_most(abs(low["torque_Nm"] / step_as_k18(config, low["speed_rpm"]) - 1), 1e-4, "step at hand-over")
    checks.at_most(abs(low["share"] - low["torque_Nm"] / rated), 1e-4, "its share of rated torque")
    checks.at_most(abs(base["torque_Nm"] / (1.5 * rated / (1 + math.exp(-2))) - 1), 1e-3, "step at base speed")
    checks.equal([low["bound_by"], base["bound_by"]], ["speed", "current"], "what bounds the steps")
    loops = {(x["loop"], round(x["speed_rpm"])): x for x in verdict["loops"]}
    checks.equal(set(loops), {(name, rpm) for name in ("current", "pll", "speed") for rpm in (150, 1500)}, "loops")
    folder.run("analyse", "--motor", MOTOR, "--drive", DRIVE, "--json", "a.json")
    own = {(x["loop"], round(x["speed_rpm"] or 0)): x for x in folder.json("a.json")["loops"]}
    for rpm in (150, 1500):
        for name, of in [("current", ("current, d axis", 0)), ("pll", ("PLL with observer", rpm)),
                         ("speed", ("speed, PI alone", rpm))]:
            pair = loops[name, rpm], own[of]
            for ours, theirs in [("crossover_rad_s", "crossover_rad_s"), ("phase_margin_deg", "phase_margin_deg")]:
                checks.at_most(abs(pair[0][ours] / pair[1][theirs] - 1), 1e-3, f"{name} at {rpm} rpm, {ours}")
    checks.equal(verdict["changes"], [], "what to change of it")


def signal_check(checks, folder):
    """Whether bridge and sensors are tried before a start: a quarter of i_max in a period of Ld, or why not."""
    command = ["design", "--motor", "jiang2022", "--drive", "jiang2022"]
    found = json.loads(folder.run(*command, "--json").stdout)
    checks.at_most(abs(found["signal_check_A"] / (0.25 * 12) - 1), 1e-5, f"current {found['signal_check_A']}")
    checks.at_most(abs(found["signal_check_V"] / (0.25 * 12 * 3.5e-3 * 5000) - 1), 1e-5, f"{found['signal_check_V']} V")
    for assignment, words in [("start.signal_check=auto", "tested with pulses of 52.5 V, which drive up to 3 A"),
                              ("start.signal_check=off", "not tested: start.signal_check is off"),
                              ("start.pulses=off", "not tested: start.pulses or start.catch_s is off, and start.signal_check is not on"),
                              ("drive.dead_time_s=2e-5", "not tested: dead time takes too much of a pulse")]:
        done = folder.run(*command, "--set", assignment)
        checks.true(f"before a start: bridge and sensors are {words}" in done.stdout, f"{assignment}: {words}")
    for assignments in [["start.pulses=off", "start.signal_check=on"], ["drive.double_update=on"]]:
        sets = [word for assignment in assignments for word in ("--set", assignment)]
        checks.true("bridge and sensors are tested with pulses" in folder.run(*command, *sets).stdout, f"{assignments}")
    off = json.loads(folder.run(*command, "--set", "start.pulses=off", "--json").stdout)
    checks.equal([off["signal_check_V"], off["signal_check_A"]], [None, None], "none")
    six = folder.run("design", "--motor", "eldeeb2017", "--drive", "eldeeb2017").stdout
    checks.true("before a start:" not in six, "two sets have pulses of their own")


def plausible(checks, folder):
    """The motor in other units, and a line for what no motor has: a figure in the wrong unit."""
    found = designed(checks, folder, SMALL)
    sheet = {"poles": 14, "R_line_line_Ohm": 0.1, "Ld_line_line_mH": 0.06, "Lq_line_line_mH": 0.07,
             "KV_rpm_V": 1 / math.sqrt(3) / 0.003 / 7 / RPM, "ke_Vpk_krpm": 1000 * math.sqrt(3) * 0.003 * 7 * RPM,
             "ke_Vrms_krpm": 1000 * math.sqrt(1.5) * 0.003 * 7 * RPM, "kt_Nm_A": 1.5 * 7 * 0.003,
             "kt_Nm_Arms": 1.5 * math.sqrt(2) * 7 * 0.003, "no_load_rpm": found["no_load_limit_rpm"]}
    checks.equal(set(found["data_sheet"]), set(sheet), "keys of the data sheet")
    for key, value in sheet.items():
        checks.at_most(abs(found["data_sheet"][key] / value - 1), 1e-6, f"{key} in the terms of data sheets")
    rated = found["rated_rpm"] * RPM
    values = {"time_constant": 0.7, "short_circuit_current": 5, "resistive_drop": 100 * 0.05 * 20 / 36 * math.sqrt(3),
              "run_up": 1e3 * 3e-5 * rated / (sheet["kt_Nm_A"] * 20),
              "no_load_speed": found["no_load_limit_rpm"] / found["rated_rpm"]}
    for ratio in found["plausible"]:
        checks.at_most(abs(ratio["value"] / values[ratio["key"]] - 1), 1e-6, f"{ratio['key']}: {ratio}")
        checks.equal(ratio["doubtful"], False, f"{ratio['key']} of a sound motor")
    rated = SMALL.replace("[drive]", "speed_rated_rpm = 6000\n[drive]")
    both = "Ld_H = 30e-6\nLq_H = 35e-6"
    for line, wrong, keys in [  # accepted
        ("Rs_Ohm = 0.05", "Rs_Ohm = 0.05e-3", {"resistive_drop", "time_constant"}),
        (both, "Ld_H = 30e-3\nLq_H = 35e-3", {"short_circuit_current", "time_constant"}),
        ("i_max_A = 20", "i_max_A = 0.02", {"resistive_drop", "short_circuit_current", "run_up"}),
        ("J_kgm2 = 3e-5", "J_kgcm2 = 300", {"run_up"}),  # g cm2
        ("speed_rated_rpm = 6000", "speed_rated_rpm = 600", {"no_load_speed"}),  # rad/s for rpm
    ]:
        done = designed(checks, folder, rated.replace(line, wrong))
        doubtful = {r["key"] for r in done.get("plausible", []) if r["doubtful"]}
        checks.equal(doubtful, keys, f"what is doubtful with {wrong!r}")
        text = folder.run("design", "--motor", "m.ini").stdout
        checks.equal(sum(row.startswith("check: ") for row in text.splitlines()), len(keys), f"lines with {wrong!r}")
    for line, wrong, names in [  # refused, for what was computed from them
        ("Rs_Ohm = 0.05", "Rs_Ohm = 50", ["time constant", "i_max across Rs"]),
        (both, "Ld_H = 3\nLq_H = 3.5", ["time constant", "short-circuit current"]),
        ("psi_Wb = 0.003", "psi_Wb = 3", ["short-circuit current", "run-up"]),
        ("J_kgm2 = 3e-5", "J_kgm2 = 3e-8", ["run-up"]),
        ("J_kgm2 = 3e-5", "J_kgm2 = 300", ["run-up"]),
    ]:
        folder.write("m.ini", rated.replace(line, wrong))
        done = folder.run("design", "--motor", "m.ini")
        checks.equal(done.returncode, 2, f"exit code with {wrong!r}")
        found = [row for row in done.stderr.splitlines() if row.startswith("check: ")]
        for name in names:
            checks.true(any(name in row for row in found), f"{name} of {wrong!r}: {done.stderr}")
    for motor in sorted(p.stem for p in (SOURCE / "sim/data/drives").glob("*.ini")):
        done = json.loads(folder.run("design", "--motor", motor, "--drive", motor, "--json").stdout)
        checks.equal([r for r in done["plausible"] if r["doubtful"]], [], f"nothing is doubtful of {motor}")
    # A figure that nothing needs is not infinite.
    text = folder.run("design", "--motor", "ebike_hub", "--drive", "ebike_hub").stdout
    checks.true("V_h_V                  = 0  " in text and " inf" not in text, "no voltage to inject into a round rotor")


def verdict_steps(checks, folder):
    """The rotor that is simulated stands the step that is printed, and a sensible multiple of it not."""
    found = json.loads(folder.run("design", "--motor", MOTOR, "--drive", DRIVE, "--json").stdout)
    step = found["verdict"]["step_at_handover"]
    for factor, stood in [(1.0, True), (2.0, False)]:
        folder.write("step.ini", f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\n[plant]\nload_kind = signed\n"
                                 "[phase.start]\nduration_s = 4\nspeed_rpm = 151\n[phase.step]\nduration_s = 0.4\n"
                                 f"load_Nm = {factor * step['torque_Nm']}\n[phase.after]\nduration_s = 1\n")
        folder.run("run", "step.ini", "--json", "s.json")
        result = folder.json("s.json")
        checks.equal(result["fault"] is None, stood, f"{factor} times the largest step: {result['fault']}")
        if stood:
            least = result["phases"][1]["speed_rpm"]["min"] / step["speed_rpm"]
            checks.at_most(abs(least - 0.5), 0.1, f"share of the speed that is left: {least}")


def verdict_changes(checks, folder):
    """A motor for each line."""
    slow = ["drive.f_pwm_Hz=5000", "motor.speed_rated_rpm=6000"]
    low_bus = ["drive.v_bus_V=4", "drive.i_max_A=40"]  # the resistance takes half of it
    for sets, key, word in [
        (slow, "rated_above_estimator", "raise drive.f_pwm_Hz to "),
        (["motor.speed_rated_rpm=9500"], "rated_above_voltage", "set references.field_weakening = on"),
        (["motor.speed_rated_rpm=9500", "references.field_weakening=on", "references.id_max_A=4"], "rated_above_voltage",
         "raise references.id_max_A to "),
        (["motor.speed_rated_rpm=8800"], "rated_torque_above_voltage", "rated torque is possible up to"),
        (low_bus, "base_below_handover", "lower drive.i_max_A to "),
        (["speed.kp_Nms=1e-4"], "step_at_handover", "kp_Nms"),
        (["speed.kp_Nms=1e-5"], "step_at_base", "gain_rise"),
        (["current.kp_q_V_A=0.1", "current.ki_q_V_As=800"], "margin_current", "lower current.ki_q_V_As to "),
        (low_bus, "margin_pll", "sigma_rad_s"),
        (["speed.ki_Nm=10"], "margin_speed", "set speed.ki_Nm = auto"),
        (low_bus, "no_usable_emf", "angle sensor"),
    ]:
        verdict = verdict_of(checks, folder, SMALL, *sets)
        lines = {x["key"]: x["text"] for x in verdict.get("changes", [])}
        checks.true(word in lines.get(key, ""), f"{key} of {sets}: {lines}")
        done = folder.run("design", "--motor", "m.ini", *[x for s in sets for x in ("--set", s)])
        checks.true(f"change: {lines.get(key)}\n" in done.stdout, f"{key} is printed")
        checks.true("nothing to change" not in done.stdout, f"something to change with {sets}")
    # A step that is short and a PLL that is tight would have sigma moved either way: w0 helps both.
    for motor in (["light.ini"], ["gimbal_12V", "--drive", "gimbal_12V"]):
        folder.write("light.ini", LIGHT)
        before = json.loads(folder.run("design", "--motor", *motor, "--json").stdout)
        lines = {x["key"]: x["text"] for x in before["verdict"]["changes"]}
        checks.true(": raise estimator.w0_rad_s to " in lines.get("margin_pll", ""), f"{motor[0]}: {lines}")
        w0 = 1.3 * before["config"]["estimator"]["w0_rad_s"]
        after = json.loads(folder.run("design", "--motor", *motor, "--set", f"estimator.w0_rad_s={w0}", "--json").stdout)["verdict"]
        left = [x["text"] for x in after["changes"] if x["key"] == "margin_pll"]
        checks.equal(left, [], f"margins of {motor[0]} with that")
        checks.true(after["step_at_handover"]["share"] >= before["verdict"]["step_at_handover"]["share"] * 0.99, f"step of {motor[0]}")
    done = folder.run("design", "--motor", "fan_325V", "--drive", "fan_325V")
    checks.true(done.stdout.endswith("nothing to change\n"), "a motor without a line")
    checks.equal(done.stdout.count("\nverdict\n"), 1, "one verdict")
    raised = json.loads(folder.run("design", "--motor", MOTOR, "--drive", DRIVE, "--set", "speed.omega_min_rad_s=60",
                                   "--json").stdout)["verdict"]
    checks.equal(raised["changes"], [], "with a higher least speed paper 1's motor stands half of its torque")
    hfi = json.loads(folder.run("design", "--motor", MOTOR, "--drive", DRIVE, "--set", "hfi.mode=on",
                                "--json").stdout)["verdict"]
    checks.equal([hfi["lowest_rpm"], hfi["step_at_handover"]["bound_by"]], [0, "current"], "with injection any speed")


def hexagon(checks, folder):
    """Over-modulation: the fundamental of a line voltage, worked out here by its cosine; as much more speed in a run."""
    def of(use):
        done = folder.run("design", "--motor", MOTOR, "--drive", DRIVE, "--set", f"current.voltage_use={use}")
        found = json.loads(folder.run("design", "--motor", MOTOR, "--drive", DRIVE, "--set", f"current.voltage_use={use}",
                                      "--json").stdout)
        return done.stdout, found["hexagon_fundamental"], found["hexagon_ripple"]

    for use in (0.95, 1.0):
        text, *values = of(use)
        checks.equal(("over-modulation: " in text, values), (False, [None, None]), f"within the hexagon, {use}")
    for use in (1.01, 1.1, 1.1547):
        sum_V, n = 0.0, 3000
        for k in range(n):
            angle = 2 * math.pi * (k + 0.5) / n
            u = [use / math.sqrt(3) * math.cos(angle - 2 * math.pi * leg / 3) for leg in range(3)]
            duty = [min(max(0.5 + x - 0.5 * (min(u) + max(u)), 0), 1) for x in u]
            sum_V += 2 / n * (duty[0] - duty[1]) * math.cos(angle + math.pi / 6)
        text, fundamental, ripple = of(use)
        checks.at_most(abs(fundamental / sum_V - 1), 1e-3, f"fundamental at {use}: {fundamental}, {sum_V}")
        checks.true(1 < fundamental < use and 0 < ripple < 0.1, f"{use}: {fundamental}, {ripple}")
        checks.true(f"over-modulation: voltage_use {use} gives at most {fundamental:.3f} v_bus/sqrt(3), with a ripple of "
                    f"{100 * ripple:.1f} % six times" in text, f"the line for {use}")


def slow_commands(checks, folder):
    """What becomes of a command below the hand-over speed: with injection any speed is kept."""
    text = folder.run("design", "--motor", "pmsyrm_5kW", "--drive", "pmsyrm_5kW").stdout
    checks.true(re.search(r"^hand-over .* slower commands are kept, by signal injection$", text, re.MULTILINE) and
                "speeds: 0 .. " in text and "raised to omega_min_rad_s" not in text, f"with injection: {text[-3000:]}")
    text = folder.run("design", "--motor", MOTOR, "--drive", DRIVE).stdout
    checks.true(re.search(r"^hand-over .* slower commands are raised to omega_min_rad_s$", text, re.MULTILINE), "without")


HUB = """[motor]
poles = 30
R_line_line_mOhm = 240
L_line_line_mH = 0.45
KV_rpm_V = 13.5
J_kgcm2 = 80
speed_rated_rpm = 260
[drive]
f_pwm_Hz = 20e3
v_bus_V = 24
i_max_A = 25
"""


def advice(checks, folder):
    """Every way that a line offers is gone here: the complaint goes, and no other one comes."""
    folder.write("m.ini", SMALL)
    folder.write("light.ini", LIGHT)
    folder.write("hub.ini", HUB)
    small = ["--motor", "m.ini"]
    low_bus = ["drive.v_bus_V=4", "drive.i_max_A=40"]
    cases = [(small, sets) for sets in (["drive.f_pwm_Hz=5000", "motor.speed_rated_rpm=6000"], ["motor.speed_rated_rpm=9500"],
                                        ["motor.speed_rated_rpm=8800"], low_bus, ["speed.kp_Nms=1e-4"], ["speed.ki_Nm=10"],
                                        ["current.kp_q_V_A=0.1", "current.ki_q_V_As=800"])]
    cases += [(["--motor", "hub.ini"], []), (["--motor", "light.ini"], [])]
    cases += [(["--motor", name, "--drive", name], []) for name in ("ebike_hub", "flat_30W", "gimbal_12V", "servo_3kW", "servo_48V")]
    seen, several = set(), 0
    for motor, given in cases:
        def changes(sets):
            done = folder.run("design", *motor, *[x for s in sets for x in ("--set", s)], "--json")
            checks.equal(done.returncode, 0, f"{motor} {sets}: {done.stderr}")
            return json.loads(done.stdout)["verdict"]["changes"] if done.returncode == 0 else []
        before = changes(given)
        for change in before:
            for way in change["ways"]:
                what = f"{change['key']} of {motor[1]} {given} with {way}"
                for one in way:
                    key, value = one.split("=")
                    checks.true(f"{key} to {value}" in change["text"] or f"{key} = {value}" in change["text"], f"text of {what}: {change}")
                names = {one.split("=")[0] for one in way}
                after = {x["key"] for x in changes([s for s in given if s.split("=")[0] not in names] + way)}
                checks.true(change["key"] not in after, f"{what}: still there")
                checks.true(after <= {x["key"] for x in before}, f"{what}: {after} has come")
                seen.add(change["key"])
                several += len(way) > 1
    checks.equal(seen, {"rated_above_estimator", "rated_above_voltage", "rated_torque_above_voltage", "base_below_handover",
                        "step_at_handover", "step_at_base", "margin_current", "margin_pll", "margin_speed"}, "lines with ways")
    checks.true(several > 0, "ways with more than one value")
    # The catalogue's value of a rated speed is rounded: 260 rpm where rated torque is possible up to 259 rpm.
    found = json.loads(folder.run("design", "--motor", "hub.ini", "--json").stdout)["verdict"]
    checks.true(258 < found["rated_torque_speed_rpm"] < 260, f"{found['rated_torque_speed_rpm']} rpm")
    checks.equal({x["key"] for x in found["changes"]}, {"margin_pll"}, "what there is to change of the hub motor")
    checks.true(any("is 26.9 degrees: raise estimator.w0_rad_s to " in x["text"] for x in found["changes"]), f"{found['changes']}")


def main():
    checks = Checks()
    with Folder() as folder:
        data_sheets(checks, folder)
        conflicts(checks, folder)
        later_sources_win(checks, folder)
        speeds(checks, folder)
        assumed(checks, folder)
        first_turn(checks, folder)
        slow_for_its_rotor(checks, folder)
        full_speed(checks, folder)
        trial_load(checks, folder)
        heavy(checks, folder)
        open_fields(checks, folder)
        heavy_trial(checks, folder)
        injection(checks, folder)
        signal_check(checks, folder)
        plausible(checks, folder)
        hexagon(checks, folder)
        slow_commands(checks, folder)
        verdict_numbers(checks, folder)
        verdict_steps(checks, folder)
        verdict_changes(checks, folder)
        advice(checks, folder)
    checks.done()


main()
