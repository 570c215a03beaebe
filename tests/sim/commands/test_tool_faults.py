"""lodestar faults: faults are injected, found or not, and reported; wrong input is refused."""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import SOURCE, Checks, Folder, refused


def cases_of(folder, *arguments):
    """Exit code and {(kind, point): case} of a campaign."""
    done = folder.run("faults", *arguments, "--json", "f.json")
    cases = folder.json("f.json")["cases"]
    return done, {(case["kind"], case["at"]): case for case in cases}


def finds(checks, folder):
    done, cases = cases_of(folder, "--motors", "jiang2022",
                           "--kinds", "none,adc-high,bus-reads-0,irq-missed,rotor-jammed")
    checks.equal(done.returncode, 0, "exit code where nothing is silent")
    checks.equal(len(cases), 5 * 6, "cases")
    running = ["10 %", "50 %", "100 %", "weakening"]
    for point in ["standstill", "start", *running]:
        checks.equal(cases["none", point]["found"], "NONE", f"no fault at {point}")
        checks.true(not cases["none", point]["silent"], f"not silent at {point}")
    for point in ["start", *running]:
        checks.equal(cases["adc-high", point]["found"], "OVER_CURRENT", f"rail at {point}")
        checks.equal(cases["bus-reads-0", point]["found"], "UNDER_VOLTAGE", f"bus at {point}")
        checks.equal(cases["irq-missed", point]["found"], "TIMING", f"interrupt at {point}")
        checks.at_most(cases["irq-missed", point]["found_s"], 4.5e-4, "the next call")
    checks.equal(cases["rotor-jammed", "start"]["found"], "START", "a rotor that cannot start")
    for point in running:
        checks.true(cases["rotor-jammed", point]["found"] != "NONE", f"jammed at {point}")
        checks.at_most(cases["rotor-jammed", point]["found_s"], 0.1, f"jammed at {point}")
    checks.true("| the rotor is jammed | START " in done.stdout, "the table")


def tries_bridge_and_sensors_before_a_start(checks, folder):
    """Within 15 ms of the calibration, and with less than half of i_max."""
    expected = {"adc-last": "CURRENT_STUCK", "adc-mid-all": "CURRENT_STUCK", "gain-0.7": "CURRENT_SUM",
                "gains-0.4": "INDUCTANCE", "offsets-25": "OFFSET", "sensors-swapped": "SIGNALS",
                "sensors-rotated": "SIGNALS", "switch-high-dead": "OPEN_PHASE", "switch-low-dead": "OPEN_PHASE",
                "phase-open": "OPEN_PHASE", "duties-late": "SIGNALS", "duties-early": "SIGNALS", "register-1": "SIGNALS"}
    for motor, i_max_A in [("jiang2022", 12), ("eldeeb2017", 15), ("servo_48V", 20), ("fan_325V", 1.5)]:
        _, cases = cases_of(folder, "--motors", motor, "--kinds", ",".join(["none", *expected]))
        checks.equal(cases["none", "standstill"]["found"], "NONE", f"{motor} in order")
        for kind, check in expected.items():
            case = cases[kind, "standstill"]
            checks.equal(case["found"], check, f"{kind} of {motor}")
            again_s = 7.5e-3 if check == "CURRENT_SUM" else 0  # a second set of pulses (S48)
            checks.at_most(case["found_s"], 0.115 + again_s, f"{kind} of {motor}: calibration and 15 ms")
            checks.at_most(case["peak_A"], 0.5 * i_max_A, f"{kind} of {motor}")


def finds_sensors_that_come_to_show_less_in_a_start(checks, folder):
    """(K38) and (S43), with little and with much inductance and resistance, and six phases."""
    for motor in ("jiang2022", "eldeeb2017", "servo_48V", "highspeed_100krpm", "ultrazohm6"):
        for seed in ("1", "2"):
            _, cases = cases_of(folder, "--motors", motor, "--kinds", "none,gains-0.4", "--seed", seed)
            checks.equal(cases["none", "start"]["found"], "NONE", f"{motor} in order")
            case = cases["gains-0.4", "start"]
            checks.true(case["found"] in ("CURRENT_GAIN", "RESISTANCE"), f"{motor}, seed {seed}: {case}")
            checks.at_most(case["found_s"], 0.01, f"{motor}, seed {seed}")


def finds_while_it_injects(checks, folder):
    """(H29), (K42): in the search at rest, which commands no current, and at a tenth of the speed."""
    kinds = ("none", "adc-frozen-noisy", "adc-mid-all", "gains-0.4", "rotor-jammed")
    for motor in ("jiang2022", "pmsyrm_5kW"):
        done, cases = cases_of(folder, "--motors", motor, "--set", "hfi.mode=on", "--kinds", ",".join(kinds))
        checks.equal(done.returncode, 0, f"exit code with {motor}")
        for point in ("start", "10 %"):
            checks.equal(cases["none", point]["found"], "NONE", f"{motor} in order")
            for kind in ("adc-frozen-noisy", "adc-mid-all"):
                checks.equal(cases[kind, point]["found"], "CURRENT_STUCK", f"{kind} of {motor} at {point}")
                checks.at_most(cases[kind, point]["found_s"], 0.006, f"{kind} of {motor} at {point}")
            checks.equal(cases["gains-0.4", point]["found"], "CURRENT_GAIN", f"gains of {motor} at {point}")
            checks.at_most(cases["gains-0.4", point]["found_s"], 0.015, f"gains of {motor} at {point}")
        checks.equal(cases["rotor-jammed", "50 %"]["found"], "OVERLOAD", f"{motor} jams")


def breaks_where_that_is_asked_for(checks, folder):
    """The phase, or all sensors of one set (K36); bus and temperature are those of both sets."""
    done, cases = cases_of(folder, "--motors", "jiang2022", "--kinds", "phase-open,adc-last", "--in", "c1")
    checks.equal(cases["adc-last", "start"]["in"], "c1", "where, in the JSON")
    checks.equal(done.returncode, 0, "exit code of c1")
    checks.equal(cases["phase-open", "100 %"]["found"], "OPEN_PHASE", "c1")
    for place in ("set-1", "set-2"):
        done, cases = cases_of(folder, "--motors", "ultrazohm6", "--kinds", "adc-frozen-noisy,bus-reads-0,ntc-low",
                               "--in", place)
        checks.equal(done.returncode, 0, f"exit code of {place}")
        for point in ("start", "10 %", "50 %"):
            found = cases["adc-frozen-noisy", point]
            checks.equal(found["found"], "CURRENT_STUCK", f"{place} at {point}")
            checks.at_most(found["found_s"], 0.006, f"{place} at {point}")
            checks.equal(cases["bus-reads-0", point]["found"], "UNDER_VOLTAGE", f"bus with {place} at {point}")
    refused(checks, folder, ["faults", "--motors", "jiang2022", "--in", "a2"], "--in a2: expected a motor with six phases")
    refused(checks, folder, ["faults", "--in", "d1"], "--in d1: unknown; expected a1, b1")


def bits_of_more_seeds_are_not_silent(checks, folder):
    """Some of these flip the direction, the upper bits of a mode, or what control has of the q axis."""
    for motor, seed in (("servo_3kW", "7"), ("jiang2022", "10"), ("servo_48V", "10")):
        done, cases = cases_of(folder, "--motors", motor, "--kinds", "flip-state,flip-mode,flip-command", "--seed", seed)
        silent = {case for case, one in cases.items() if one["silent"]}
        checks.equal(silent, set(), f"silent with {motor}, seed {seed}")
        checks.equal(done.returncode, 0, f"exit code with {motor}, seed {seed}")


def finds_a_stuck_temperature_where_it_may_be_looked_for(checks, folder):
    kind = ("--motors", "jiang2022", "--kinds", "ntc-stuck")
    done, cases = cases_of(folder, *kind)
    checks.equal(done.returncode, 0, "exit code")
    checks.equal({case["found"] for case in cases.values()}, {"TEMPERATURE_STUCK"}, "by its count")
    done, cases = cases_of(folder, *kind, "--set", "guard.temperature_still_s=0")
    checks.equal(done.returncode, 1, "exit code where it is silent")
    checks.true(all(case["silent"] for case in cases.values()), "silent without that")


def same_with_any_number_of_processes(checks, folder):
    _, one = cases_of(folder, "--motors", "jiang2022", "--kinds", "flip-state", "--jobs", "1")
    _, two = cases_of(folder, "--motors", "jiang2022", "--kinds", "flip-state", "--jobs", "2")
    _, other = cases_of(folder, "--motors", "jiang2022", "--kinds", "flip-state", "--seed", "9")
    checks.equal(one, two, "one process and two")
    checks.true(one != other, "another seed flips other bits")


def leaves_out_where_the_speed_does_not_settle(checks, folder):
    """The load of a compressor ripples; so does its speed, just above the least."""
    done, cases = cases_of(folder, "--motors", "compressor_310V", "--kinds", "none,bus-reads-0")
    checks.equal(done.returncode, 0, f"exit code: {done.stderr}")
    points = {point for _, point in cases}
    checks.true("10 %" not in points and {"standstill", "start", "100 %"} <= points, f"{points}")
    checks.equal(len(cases), 2 * len(points), "cases")
    checks.true(f"{len(cases)} cases: " in done.stdout and " - |" in done.stdout, f"the table: {done.stdout}")
    checks.true("-: left out, because the speed does not settle there" in done.stdout, "its note")
    refused(checks, folder, ["faults", "--motors", "jiang2022", "--set", "start.timeout_s=0.2"],
            "expected a drive that reaches the state")


def tells_starts_that_were_given_up(checks, folder):
    done, cases = cases_of(folder, "--motors", "jiang2022", "--kinds", "none,gains-0.7")
    checks.true(all(case["given_up"] >= 0 for case in cases.values()), "counted")
    given_up = sum(case["given_up"] > 0 for case in cases.values())
    checks.equal(done.stdout.count(", given up "), given_up, "cells that tell it")


def keeps_a_long_current_of_a_start_given_up(checks, folder):
    """Telemetry tells that a start was given up, but not that the current was beyond 1.2 i_max for seconds before."""
    blind = [word for key in ("a", "b", "c") for word in ("--set", f"plant.i_gain_error_{key}=-0.25")]
    blind += ["--set", "guard.plausibility=off", "--set", "start.signal_check=off", "--set", "start.current_A=12"]
    _, cases = cases_of(folder, "--motors", "jiang2022", "--kinds", "offset-12", *blind)
    case = cases["offset-12", "standstill"]
    checks.true(case["given_up"] > 0 and case["found"] == "NONE", f"given up, then it runs: {case}")
    checks.true(case["silent"] and case["harm"] == "current" and case["over_s"] > 1.0, f"told: {case}")


def names_a_shorted_switch(checks, folder):
    """Over-current comes first; with the gates off the current that flows on shows why."""
    done, cases = cases_of(folder, "--motors", "jiang2022,servo_48V", "--kinds", "switch-low-shorted,adc-high")
    for point in ("100 %", "weakening"):
        case = cases["switch-low-shorted", point]
        checks.equal((case["found"], case["named"]), ("OVER_CURRENT", "SWITCH_SHORTED"), f"low side at {point}")
        case = cases["adc-high", point]
        checks.equal((case["found"], case["named"]), ("OVER_CURRENT", "OVER_CURRENT"), f"a sensor at {point}")
    checks.true(re.search(r" OVER_CURRENT [0-9.]+ ms, then SWITCH_SHORTED, ", done.stdout), f"the table: {done.stdout}")


def counts_current_in_pulses(checks, folder):
    """A dead switch lets a vector beyond 1.2 i_max pass for a part of each turn only: never for 10 ms in one piece."""
    done, cases = cases_of(folder, "--motors", "jiang2022", "--kinds", "none,switch-high-dead", "--load", "0.9")
    case = cases["switch-high-dead", "weakening"]
    checks.true(case["harm"] == "current" and 0.01 < case["over_s"] < 0.2, f"pulses: {case}")
    checks.equal((case["found"], done.returncode), ("CURRENT_CONTROL", 0), "found (K49), which is the exit code")
    _, cases = cases_of(folder, "--motors", "jiang2022", "--kinds", "none,switch-high-dead")
    for (kind, point), case in cases.items():
        checks.true(kind != "none" or case["over_s"] < 0.01, f"in order at {point}: {case}")
    case = cases["switch-high-dead", "start"]
    checks.true(case["found"] == "OPEN_PHASE" and case["over_s"] > 0.01, f"before it was found: {case}")
    # Shown, in the row of the kind.
    checks.true("A, beyond 1.2 i_max for " in done.stdout, f"the table: {done.stdout}")


def takes_another_load(checks, folder):
    """Up to the base speed the current is that of the load; in field weakening the power is."""
    arguments = ["--motors", "jiang2022", "--kinds", "none"]
    peak = {load: {at: case["peak_A"] for (_, at), case in cases_of(folder, *arguments, "--load", load)[1].items()}
            for load in ("0", "0.3", "0.6")}
    for at in ("50 %", "100 %"):
        checks.true(peak["0"][at] < 0.5 * peak["0.3"][at], f"{at}, no load: {peak}")
        checks.at_most(abs(peak["0.6"][at] / peak["0.3"][at] - 2.0), 0.3, f"{at}: twice the load")
    checks.true(peak["0.3"]["weakening"] < peak["0.6"]["weakening"], f"weakening: {peak}")
    checks.equal(peak["0"]["start"], peak["0.6"]["start"], "no load in the start")


def page(checks, folder):
    done = folder.run("faults", "--motors", "jiang2022", "--kinds", "none", "--out", "f.md")
    checks.equal(done.returncode, 0, "exit code")
    text = (folder.path / "f.md").read_text()
    checks.true(text.startswith("# Faults\n") and "| nothing | harmless" in text, "the page")


def takes_a_file_with_motor_and_drive(checks, folder):
    """The same cases as of the names whose files make it up."""
    def texts(kind):
        return (SOURCE / f"sim/data/{kind}/servo_48V.ini").read_text()
    folder.write("sub/a_servo_with_quite_a_long_name.ini", texts("motors") + texts("drives"))
    arguments = ["--kinds", "none,adc-high", "--seed", "3"]
    _, named = cases_of(folder, "--motors", "servo_48V", *arguments)
    done, own = cases_of(folder, "--motors", "sub/a_servo_with_quite_a_long_name.ini", *arguments)
    checks.equal(done.returncode, 0, f"exit code: {done.stderr}")
    checks.true("## sub/a_servo_with_quite_a_long_name.ini\n" in done.stdout, "its name in the table")
    checks.equal([{**case, "motor": ""} for case in own.values()], [{**case, "motor": ""} for case in named.values()],
                 "cases of the file")
    folder.write("motor.ini", texts("motors"))
    refused(checks, folder, ["faults", "--motors", "motor.ini"], r"^motor.ini: \[drive\] f_pwm_Hz: missing")


def names_weak_magnets(checks, folder):
    """(P25): 30 % of the flux is gone, with a PLL whose speed the EMF bounds (P35). It hid that at half speed of eldeeb2017."""
    for motor in ("jiang2022", "eldeeb2017", "servo_48V", "ultrazohm6"):
        _, cases = cases_of(folder, "--motors", motor, "--kinds", "flux-70")
        for point in ("50 %", "100 %"):
            checks.equal(cases["flux-70", point]["found"], "FLUX", f"weak magnets of {motor} at {point}")
            checks.at_most(cases["flux-70", point]["found_s"], 0.1, f"weak magnets of {motor} at {point}")


def refuses(checks, folder):
    for arguments, says in [(["--kinds", "none,nonsense"], "--kinds nonsense: unknown; expected one or more of none, adc-frozen"),
                            *((["--kinds", names], "--kinds: expected names separated by commas, each name once")
                              for names in ("", ",", "none,", ",none", "none,,bus-reads-0", "none,none")),
                            *((["--motors", names], "--motors: expected names separated by commas, each name once")
                              for names in ("", "jiang2022,", "jiang2022,jiang2022")),
                            (["--motors", "m" * 256], "--motors: expected names separated by commas"),
                            *((["--motors", name], f"--motors {name}: not found; expected the name of a motor that has a drive of "
                               "the same name .*, or an INI file with .motor. and .drive.") for name in ("nobody", "nobody.ini")),
                            *(([option, names], f"{option}: expected names separated by commas")
                              for option, name in (("--motors", "jiang2022"), ("--kinds", "none"))
                              for names in ("", ",", f"{name},", f",{name}", f"{name},,{name}")),
                            (["--jobs", "0"], "--jobs 0: expected"),
                            *((["--load", share], f"--load {share}: expected a share of the torque of i_max, 0 .. 0.9")
                              for share in ("-0.1", "0.91", "1", "x", "0.5x", "nan", "")),
                            (["more"], "more: expected no argument here")]:
        refused(checks, folder, ["faults", *arguments, "--json", "no.json"], says)


def flips_the_bits_that_are_asked_for(checks, folder):
    """Each of a range, once, on any number of processes; what was silent is listed bit by bit."""
    # Sensors that show four fifths, no check that finds it, and a start with all of i_max: silent without any flip.
    blind = [word for key in ("a", "b", "c") for word in ("--set", f"plant.i_gain_error_{key}=-0.2")]
    blind += ["--set", "guard.plausibility=off", "--set", "start.signal_check=off", "--set", "start.current_A=12"]
    state = ("--motors", "jiang2022", "--kinds", "none,flip-state", *blind)
    done, all_of_them = cases_of(folder, *state, "--bits", "30-119", "--jobs", "1")
    checks.equal(done.returncode, 1, "exit code")
    found = {}
    for bits in ("30-80", "81-119"):  # each in one piece of work, together in two
        _, cases = cases_of(folder, *state, "--bits", bits, "--jobs", "2")
        for key, case in cases.items():
            found.setdefault(key, []).extend(case.get("silent_bits", []))
    for key, case in all_of_them.items():
        flips = case["kind"] == "flip-state"
        checks.equal(case["tried"], 90 if flips else 1, f"tried, {key}")
        checks.equal("silent_bits" in case, flips, f"a list, {key}")
        if flips:
            checks.equal(case["silent_bits"], found[key], f"in one range and in two, {key}")
            checks.equal(len(case["silent_bits"]), case["silent_of_tried"], f"all are listed, {key}")
    silent = all_of_them["flip-state", "standstill"]["silent_bits"]
    checks.true(len(silent) > 10, f"{len(silent)} silent ones")
    checks.equal({bit["at"] for bit in silent}, {"standstill"}, "their point")
    checks.equal([bit["bit"] for bit in silent], [bit["number"] % 8 for bit in silent], "their place in the octet")
    checks.equal(len({bit["offset"] - bit["number"] // 8 for bit in silent}), 1, "their octets")
    listed = " ".join(f"{bit['offset']}.{bit['bit']}" for bit in silent[:40])
    checks.true(f"\nSilent bits of flip-state at standstill: {listed}" in done.stdout, done.stdout)
    done, whole = cases_of(folder, "--motors", "jiang2022", "--kinds", "flip-mode", "--bits", "every")
    checks.equal({case["tried"] for case in whole.values()}, {8}, "every bit of the mode")
    checks.true("| a bit of the mode flips |" in done.stdout, done.stdout)
    for text, says in [("some", "--bits some: expected random, every, or numbers as in 0-63"), ("5", "--bits 5: expected random"),
                       ("9-3", "--bits 9-3: expected random"), ("-3", "--bits -3: expected"), ("0-8", "--bits 0-8: flip-mode has the bits 0 to 7")]:
        refused(checks, folder, ["faults", "--motors", "jiang2022", "--kinds", "flip-mode", "--bits", text], says)
    refused(checks, folder, ["faults", "--motors", "jiang2022", "--kinds", "none", "--bits", "every"],
            "--bits every: expected a kind that flips bits in --kinds, such as flip-state")
    _, drawn = cases_of(folder, "--motors", "jiang2022", "--kinds", "flip-mode")
    _, random = cases_of(folder, "--motors", "jiang2022", "--kinds", "flip-mode", "--bits", "random")
    checks.equal(drawn, random, "the default")


def lists_its_kinds(checks, folder):
    """The names that --kinds takes, and what they are."""
    text = folder.run("faults", "--help").stdout
    message = folder.run("faults", "--kinds", "nonsense").stderr
    names = message.split("expected one or more of ")[1].split(", separated")[0].split(", ")
    checks.true(len(names) > 40, f"{len(names)} kinds")
    rows = text.split("\nkinds:\n")[1].splitlines()
    checks.equal([row.split()[0] for row in rows], names, "kinds in the help")
    checks.true(all(len(row.split()) > 1 for row in rows), "each with words")
    checks.true("kinds:" not in folder.run("run", "--help").stdout, "not of another command")


checks = Checks()
with Folder() as folder:
    lists_its_kinds(checks, folder)
    flips_the_bits_that_are_asked_for(checks, folder)
    finds(checks, folder)
    tries_bridge_and_sensors_before_a_start(checks, folder)
    finds_sensors_that_come_to_show_less_in_a_start(checks, folder)
    finds_while_it_injects(checks, folder)
    names_weak_magnets(checks, folder)
    breaks_where_that_is_asked_for(checks, folder)
    tells_starts_that_were_given_up(checks, folder)
    keeps_a_long_current_of_a_start_given_up(checks, folder)
    names_a_shorted_switch(checks, folder)
    counts_current_in_pulses(checks, folder)
    bits_of_more_seeds_are_not_silent(checks, folder)
    finds_a_stuck_temperature_where_it_may_be_looked_for(checks, folder)
    same_with_any_number_of_processes(checks, folder)
    leaves_out_where_the_speed_does_not_settle(checks, folder)
    takes_another_load(checks, folder)
    page(checks, folder)
    takes_a_file_with_motor_and_drive(checks, folder)
    refuses(checks, folder)
checks.done()
