"""`lodestar decode`: what ring and scope record of a simulated drive comes back as its CSV has it.

The layouts are read and written here once more, from docs/telemetry.md and with zlib's CRC-32.
"""
import csv
import math
import pathlib
import random
import re
import struct
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "support"))
from tool import DRIVE, MOTOR, Checks, Folder, refused

F_PWM = 5000.0
# Channel, its number, and the column of the run's CSV that shows the same.
CHANNELS = [("mode", 0, "mode"), ("duty_a", 2, "duty_a"), ("id_A", 5, "i1_A"), ("iq_A", 6, "i2_A"),
            ("id_ref_A", 7, "i1_ref_A"), ("uq_V", 10, "u2_V"), ("v_bus_V", 11, "v_bus_V"),
            ("theta_rad", 13, "theta_est_rad"), ("ud_V", 9, "u1_V"),
            ("lock", 17, "lock"), ("e_alpha_V", 18, "e_alpha_V")]
NAMES = ",".join(name for name, _, _ in CHANNELS)
N = len(CHANNELS)
FRAME = 4 * (N + 2)
DESCRIPTION = 4 * (N + 6)
SCENARIO = (f"[scenario]\nmotor = {MOTOR}\ndrive = {DRIVE}\nlog_s = 2e-4\n"
            "[phase.start]\nduration_s = 2.4\nspeed_rpm = 450\nload_Nm = 1\n")
EVENT = "[phase.trip]\nduration_s = 0.1\ntrip = on\nend_mode = fault\n"


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def frames_of(data):
    """[(offset, describes, number's low half, payload words)], by the documentation."""
    found, at = [], 0
    while at < len(data):
        assert data[at] == 0xA5 and data[at + 1] & 0x60 == 0x20, hex(at)
        words = data[at + 1] & 31
        body = data[at:at + 4 * (words + 1)]
        assert zlib.crc32(body) == struct.unpack_from("<I", data, at + len(body))[0], hex(at)
        found.append((at, bool(data[at + 1] & 0x80), struct.unpack_from("<H", data, at + 2)[0],
                      struct.unpack_from(f"<{words}I", data, at + 4)))
        at += 4 * (words + 2)
    return found


def frame(kind, number, words):
    body = struct.pack(f"<BBH{len(words)}I", 0xA5, kind | len(words), number & 0xFFFF, *words)
    return body + struct.pack("<I", zlib.crc32(body))


def bits(x):
    return struct.unpack("<I", struct.pack("<f", x))[0]


def decode(checks, folder, name, *options, code=0):
    done = folder.run("decode", name, "--csv", "d.csv", "--json", "d.json", *options)
    if not checks.equal(done.returncode, code, f"exit code of decode {name}: {done.stderr}"):
        return None, None, done.stdout
    return rows_of(folder.path / "d.csv"), folder.json("d.json"), done.stdout


# By the enumerations of drive.h and guard.h.
NAMED = {"mode": ["OFF", "CALIBRATE", "VOLTAGE", "CURRENT", "START", "RUN", "FAULT", "PRECHARGE"],
         "check": ["NONE", "HARDWARE_TRIP"]}


def value_of(row, name):
    """The number in a cell; of a mode or a check, which stand there by name, the enumerator's."""
    return float(NAMED[name].index(row[name]) if name in NAMED else row[name])


# ---- Against the run ----------------------------------------------------------------------------

def compare(checks, recorded, wanted, what):
    """Each row has the values of the run's row at its time."""
    by_time = {round(float(row["t_s"]) * F_PWM): row for row in wanted}

    def off(row, name, truth, column):
        x, y = value_of(row, name), float(truth[column])
        error = math.remainder(x - y, 2 * math.pi) if name == "theta_rad" else x - y
        return abs(error) / max(1.0, abs(y))

    worst = (0.0, "")
    for row in recorded:
        period = round(float(row["t_s"]) * F_PWM)
        truth = by_time[period]
        for name, _, column in CHANNELS:
            if name == "theta_rad" and row["mode"] != "RUN":
                continue  # in the start the estimator is put on the vector after the run's row
            error = off(row, name, truth, column)
            if name == "lock":  # renewed after the run's row: it is that of the next one in this mode
                following = by_time.get(period + 1, {"mode": None})
                known = following["mode"] == truth["mode"]
                error = min(error, off(row, name, following, column)) if known else 0.0
            worst = max(worst, (error, name))
    checks.at_most(worst[0], 1e-5, f"{what}: worst deviation from the run's CSV, {worst[1]}")


def round_trip(checks, folder):
    for every in (1, 7):
        done = folder.run("run", "s.ini", "--csv", "run.csv", "--ring", "r.bin", "--scope", "s.bin",
                          "--channels", NAMES, "--every", every, "--trigger", "omega_rad_s>100")
        checks.equal(done.returncode, 0, f"exit code of run: {done.stdout}{done.stderr}")
        wanted = rows_of(folder.path / "run.csv")
        rows, result, text = decode(checks, folder, "r.bin")
        checks.equal(len(rows), -(-len(wanted) // every), f"frames, one in {every} periods")
        compare(checks, rows, wanted, f"ring, one in {every}")
        checks.equal([result["kind"], result["missing"], result["damaged_places"],
                      result["overruns"], result["order"], result["row_s"]],
                     ["frames", 0, 0, 0, "little endian", every / F_PWM], "JSON of a ring")
        checks.equal([(c["name"], c["number"]) for c in result["channels"]],
                     [(name, number) for name, number, _ in CHANNELS], "channels")
        for word in ["frames of a telemetry ring", "missing: 0 frames", "theta_rad"]:
            checks.true(word in text, f"'{word}' in {text}")
        # The documented layout, read here.
        frames = frames_of((folder.path / "r.bin").read_bytes())
        data = [f for f in frames if not f[1]]
        checks.equal([f[2] for f in data], [k & 0xFFFF for k in range(len(rows))], "numbers")
        same = all(bits(value_of(row, c[0])) == w for f, row in zip(data, rows)
                   for w, c in zip(f[3], CHANNELS))
        checks.true(same, "the same floats to the bit")
        checks.equal([k for k, f in enumerate(frames) if f[1]], list(range(0, len(frames), 65)),
                     "a description before every 64 frames")
        checks.equal(frames[0][3], (bits(F_PWM), every, 0, 0, *(n for _, n, _ in CHANNELS)),
                     "description")
        rows, result, text = decode(checks, folder, "s.bin")
        compare(checks, rows, wanted, f"scope, one in {every}")
        checks.equal([result["kind"], result["state"], result["trigger"], result["checked"]],
                     ["scope", "done", "rising", True], "JSON of a scope")
        checks.equal(len(rows), (8192 - 14 - N) // N, "rows of the scope")
        event = result["event_row"]
        checks.equal(float(rows[event]["t_event_s"]), 0.0, "time of the event's row")
        checks.true(abs(event - len(rows) // 2) <= 1, f"half of {len(rows)} rows before: {event}")
        checks.true("event at" in text and "CRC-32 is right" in text, text)


def fault(checks, folder):
    folder.write("f.ini", SCENARIO + EVENT)
    folder.run("run", "f.ini", "--csv", "run.csv", "--scope", "s.bin", "--channels",
               NAMES + ",check", "--every", "1")
    rows, result, text = decode(checks, folder, "s.bin")
    checks.equal([result["state"], result["trigger"]], ["done", "fault"], "trigger on a fault")
    checks.true(re.search(r"mode +name +RUN, FAULT; last FAULT\n", text) and
                re.search(r"check +name +NONE, HARDWARE_TRIP; last HARDWARE_TRIP\n", text), text)
    checks.equal([c.get("values") for c in result["channels"] if c["name"] in ("mode", "check", "id_A")],
                 [["RUN", "FAULT"], None, ["NONE", "HARDWARE_TRIP"]], "names in JSON")
    event = result["event_row"]
    checks.equal([(r["mode"], r["check"]) for r in rows[event - 1:event + 1]],
                 [("RUN", "NONE"), ("FAULT", "HARDWARE_TRIP")], "mode and check before and at the fault")
    checks.equal(result["event_s"], 2.4, "time of the fault")
    compare(checks, rows, rows_of(folder.path / "run.csv"), "fault")


def not_triggered(checks, folder):
    folder.run("run", "s.ini", "--csv", "run.csv", "--scope", "s.bin", "--channels", NAMES)
    rows, result, text = decode(checks, folder, "s.bin")
    checks.equal([result["state"], result["event_row"], result["checked"]], ["armed", None, False],
                 "a dump of an armed scope")
    checks.true("not yet triggered" in text and rows[0]["t_event_s"] == "", text)
    compare(checks, rows, rows_of(folder.path / "run.csv"), "armed")
    checks.equal(float(rows[-1]["t_s"]), 2.3998, "the newest row is that of the last period")


def values_without_name(checks, folder):
    """What this version has no name for stays a number."""
    modes = [5, 99, 5.5, -1, float("nan"), float("inf")]
    data = frame(0xA0, 0, [bits(F_PWM), 1, 0, 0, 0, 1]) + b"".join(
        frame(0x20, k, [bits(mode), bits(14 if k else 300)]) for k, mode in enumerate(modes))
    folder.write("n.bin", data)
    rows, result, text = decode(checks, folder, "n.bin")
    checks.equal([r["mode"].lstrip("-") for r in rows], ["RUN", "99", "5.5", "1", "nan", "inf"],
                 "modes in the CSV")
    checks.equal([r["check"] for r in rows[:2]], ["300", "OPEN_PHASE"], "checks in the CSV")
    checks.equal(result["channels"][0]["values"][:4], ["RUN", 99, 5.5, -1], "modes in JSON")
    checks.true("RUN, 99, 5.5, -1, nan, inf; last inf" in text, text)


# ---- Frames, damaged ----------------------------------------------------------------------------

def offset_of(good, k):
    return frames_of(good)[k][0]


def damaged_frames(checks, folder, good):
    rows = len([f for f in frames_of(good) if not f[1]])
    rng = random.Random(5)

    def look(data, code=0):
        folder.write("b.bin", bytes(data))
        return decode(checks, folder, "b.bin", code=code)

    # One octet changed, anywhere: that frame is missing and its place is told.
    for k in (3, 10, 40, 64, 70, 129, 131):
        at = offset_of(good, k)
        describes = frames_of(good)[k][1]
        size = DESCRIPTION if describes else FRAME
        data = bytearray(good)
        data[at + rng.randrange(size)] ^= 1 << rng.randrange(8)
        found, result, text = look(data, 1)
        checks.equal(result["damage"], [{"offset": at, "octets": size}], f"frame {k}: damage")
        checks.equal(len(found), rows - (0 if describes else 1), f"frame {k}: rows")
        checks.equal(result["missing"], 0 if describes else 1, f"frame {k}: missing")
        checks.true(f"offset {at}: {size} octets" in text and "DAMAGED: 1 places" in text, text)
    # Octets lost or put in.
    at = offset_of(good, 20) + 17
    for data, octets in [(good[:at] + good[at + 1:], FRAME - 1),
                         (good[:at] + b"\xA5" + good[at:], FRAME + 1),
                         (good[:at] + b"\xA5\x2B\xA5\x2B" * 100 + good[at:], FRAME + 400),
                         (good[:at] + good[at + 3 * FRAME:], FRAME)]:
        found, result, _ = look(data, 1)
        checks.equal(result["damage"], [{"offset": offset_of(good, 20), "octets": octets}], "damage")
        checks.equal(result["missing"], rows - len(found), "as many missing as rows")
    # Whole frames lost: nothing is damaged, the gap is told.
    first, last = offset_of(good, 100), offset_of(good, 110)
    found, result, text = look(good[:first] + good[last:])
    checks.equal([len(found), result["missing"], result["gaps"]],
                 [rows - 10, 10, [{"offset": first, "missing": 10}]], "ten frames lost")
    checks.true(f"offset {first}: 10 missing after" in text, text)
    # More than 16 bits count, told by the next description.
    words = list(range(N))
    setup = [bits(F_PWM), 1]
    numbers = [number for _, number, _ in CHANNELS]
    far = (frame(0xA0, 5, [*setup, 5, 0, *numbers]) + frame(0x20, 5, words) +
           frame(0xA0, 100000, [*setup, 100000, 77, *numbers]) + frame(0x20, 100000, words))
    found, result, _ = look(far)
    checks.equal([r["frame"] for r in found], ["5", "100000"], "numbers across a long gap")
    checks.equal([result["missing"], result["overruns"]], [99994, 77], "long gap")
    checks.equal(float(found[1]["t_s"]), 20.0, "time across a long gap")
    # Listening in: from within a frame, before the first description, up to within a frame.
    found, result, text = look(good[offset_of(good, 30) + 5:-7])
    checks.equal([result["octets_before"], result["undescribed"], result["octets_after"]],
                 [FRAME - 5, 34, FRAME - 7], "begun and ended within a frame")
    checks.equal(int(found[0]["frame"]), 64, "first frame behind a description")
    # Started anew.
    found, result, text = look(good + good)
    checks.equal([len(found), result["restarts"], result["missing"]], [2 * rows, 1, 0], "started anew")
    checks.true("restarted 1 times" in text, text)
    # Random octets between and random flips: never more rows than were sent, no crash.
    for seed in range(40):
        rng.seed(seed)
        data = bytearray(good[:6000])
        for _ in range(rng.randrange(1, 60)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        folder.write("b.bin", bytes(data))
        done = folder.run("decode", "b.bin")
        checks.true(done.returncode in (0, 1, 2), f"seed {seed}: exit code {done.returncode}")


def refused_frames(checks, folder, good):
    def look(data, pattern, *options):
        folder.write("b.bin", bytes(data))
        refused(checks, folder, ["decode", "b.bin", "--csv", "never.csv", *options], pattern)

    numbers = [number for _, number, _ in CHANNELS]
    first = [bits(F_PWM), 1, 0, 0, *numbers]
    look(b"", r"b.bin: offset 0: no frame in 0 octets; expected those of lode_ring_drain")
    look(bytes(1000), "offset 0: no frame in 1000 octets")
    look(good[DESCRIPTION:DESCRIPTION + 10 * FRAME], "10 frames and no description before them")
    look(frame(0x40, 0, [0] * N), "offset 0: a frame of version 2; expected 1")
    for change, pattern in [({0: bits(10.0)}, "offset 4: a PWM rate of 10 Hz; expected 1e3"),
                            ({0: bits(math.nan)}, "offset 4: a PWM rate of"),
                            ({1: 0}, "offset 8: a decimation of 0; expected 1 .. 65535"),
                            ({1: 65536}, "offset 8: a decimation of 65536"),
                            ({5: 256}, "offset 24: channel number 256; expected 0 .. 255")]:
        words = [change.get(k, word) for k, word in enumerate(first)]
        look(frame(0xA0, 0, words) + frame(0x20, 0, [0] * N), pattern)
    for other in ([bits(F_PWM), 2, 0, 0, *numbers], [bits(4e3), 1, 0, 0, *numbers],
                  [bits(F_PWM), 1, 0, 0, *numbers[1:], 0], [bits(F_PWM), 1, 0, 0, *numbers[1:]]):
        look(good + frame(0xA0, 0, other), f"offset {len(good)}: other channels, decimation or PWM")
    look(frame(0xA0, 0, first) + frame(0x20, 0, [0] * (N - 1)),
         f"offset {DESCRIPTION}: a frame of {N - 1} channels; expected {N} as described")
    look(good, "no scope in .* expected a dump of its buffer", "--kind", "scope")


# ---- Buffers ------------------------------------------------------------------------------------

ORDERS = {"little endian": (0, 1, 2, 3), "big endian": (3, 2, 1, 0), "low one first": (1, 0, 3, 2),
          "high one first": (2, 3, 0, 1)}


def reordered(data, order):
    return b"".join(bytes(data[k + order[n]] for n in range(4)) for k in range(0, len(data), 4))


def changed(data, word, value):
    return data[:4 * word] + struct.pack("<I", value) + data[4 * word + 4:]


def scope_buffers(checks, folder, good):
    reference, _, _ = decode(checks, folder, folder.write("b.bin", good).name)
    for name, order in ORDERS.items():
        for before in (b"", b"LoScLo\x01", bytes(5)):
            folder.write("b.bin", before + reordered(good, order))
            rows, result, text = decode(checks, folder, "b.bin", "--kind", "scope")
            checks.true(rows == reference, f"{name}: same rows")
            checks.true(name in result["order"] and name in text, f"{name}: named, {text}")
            checks.equal(result["octets_before"], len(before), f"{name}: octets before")
    folder.write("b.bin", good + b"spare")
    checks.true(decode(checks, folder, "b.bin")[0] == reference, "spare octets behind it")
    dump = changed(good[:-4], 6, 3)
    folder.write("b.bin", dump)
    rows, result, _ = decode(checks, folder, "b.bin")
    checks.true(rows == reference and not result["checked"], "a dump without the check")

    def look(data, pattern, *options):
        folder.write("b.bin", bytes(data))
        refused(checks, folder, ["decode", "b.bin", "--csv", "never.csv", *options], pattern)

    total = len(good)
    rng = random.Random(3)
    for size in [12, 13, 55, 56, 57, 99, 100, 101, total - 5, total - 4, total - 1,
                 *(rng.randrange(12, total) for _ in range(20))]:
        look(good[:size], rf"b.bin: offset {size}: the file ends; expected")
    for _ in range(30):
        data = bytearray(good)
        at = rng.randrange(32, total)
        data[at] ^= 1 << rng.randrange(8)
        folder.write("b.bin", bytes(data))
        refused(checks, folder, ["decode", "b.bin", "--csv", "never.csv"], "b.bin: offset \\d+: ")
    look(good[:700] + bytes([good[700] ^ 1]) + good[701:],
         rf"offset {total - 4}: CRC-32 [0-9a-f]+; expected [0-9a-f]+: an octet")
    for word, value, pattern in [
            (1, 2, "offset 4: a buffer of version 2; expected 1"),
            (3, 1, "offset 12: 1 rows; expected at least 2"),
            (3, 0xFFFFFFFF, "offset 12: 4294967295 rows"),
            (3, 0xFFFFFFFE, "the file ends; expected 188978560[0-9]+ octets from offset 100 on"),
            (4, bits(math.inf), "offset 16: a PWM rate of inf Hz"),
            (5, 0, "offset 20: a decimation of 0"),
            (6, 4, "offset 24: state 4; expected 0 .. 3"),
            (7, 10 ** 6, "offset 28: rows written 1000000; expected at most"),
            (7, 0, "offset 28: no row was written; expected a scope that had been armed"),
            (8, 10 ** 6, "offset 32: next row 1000000; expected at most"),
            (10, 4, "offset 40: trigger 4; expected at most 3"),
            (13, 10 ** 6, "offset 52: row of the event 1000000; expected at most"),
            (14, 300, "offset 56: channel number 300; expected 0 .. 255")]:
        look(changed(dump, word, value), pattern)
    look(dump, "no frame in", "--kind", "ring")
    # A channel of a newer library keeps its number.
    folder.write("b.bin", changed(dump, 14, 99))
    rows, result, _ = decode(checks, folder, "b.bin")
    checks.true("channel99" in rows[0] and result["channels"][0]["unit"] == "?", "unknown channel")


def ring_buffers(checks, folder, good):
    data = [f for f in frames_of(good) if not f[1]]

    def buffer(slots, frames, overruns=0):
        """As it stands in memory when the last ones of `frames` are in its slots."""
        held = [[0] * (N + 1)] * slots
        for k, f in enumerate(frames):
            held[k % slots] = [f[2], *f[3]]
        words = [0x69526F4C, 1, N, slots, bits(F_PWM), 1, len(frames), overruns,
                 *(number for _, number, _ in CHANNELS), *(w for slot in held for w in slot)]
        return struct.pack(f"<{len(words)}I", *words)

    reference, _, _ = decode(checks, folder, folder.write("b.bin", good).name)
    for count, order in [(5, (0, 1, 2, 3)), (16, (3, 2, 1, 0)), (41, (1, 0, 3, 2))]:
        folder.write("b.bin", reordered(buffer(16, data[:count]), order))
        rows, result, _ = decode(checks, folder, "b.bin", "--kind", "ring")
        checks.true(rows == reference[max(0, count - 16):count], f"ring of 16, {count} written")
        checks.equal([result["kind"], result["missing"]], ["ring", 0], "JSON of a ring's buffer")
    folder.write("b.bin", buffer(16, data[:7] + data[9:19], overruns=2))
    rows, result, _ = decode(checks, folder, "b.bin")
    checks.equal([len(rows), result["missing"], result["overruns"]], [16, 2, 2], "overruns")

    def look(data, pattern):
        folder.write("b.bin", bytes(data))
        refused(checks, folder, ["decode", "b.bin", "--csv", "never.csv"], pattern)

    whole = buffer(16, data[:20])
    look(whole[:-1], f"offset {len(whole) - 1}: the file ends; expected")
    look(changed(whole, 3, 1), "offset 12: 1 frames, 20 written; expected a ring of at least 2")
    look(changed(whole, 6, 0), "offset 12: 16 frames, 0 written")
    look(changed(whole, 8 + N + 5 * (N + 1), 4), "frame number 4; expected at least 5")


# ---- Command line -------------------------------------------------------------------------------

def command_line(checks, folder):
    for arguments, pattern in [
            (["decode"], "decode: expected a file; see `lodestar decode --help`"),
            (["decode", "a", "b"], "b: expected no argument here"),
            (["decode", "nowhere"], "nowhere: No such file or directory; expected octets"),
            (["decode", "."], "Is a directory"),
            (["decode", "r.bin", "--kind", "wave"], "--kind wave: expected auto, ring or scope"),
            (["decode", "r.bin", "--csv", "no/x.csv"], "cannot write"),
            (["decode", "r.bin", "--set", "a.b=1"], "--set: unknown here"),
            (["run", "s.ini", "--ring", "n", "--channels", "id_A,x"], "--channels: 'x'; expected at"),
            (["run", "s.ini", "--ring", "n", "--channels", ","], "--channels: expected some of mode"),
            (["run", "s.ini", "--ring", "n", "--channels", ",".join(["lock"] * 17)], "at most 16"),
            (["run", "s.ini", "--ring", "n", "--every", "0"], "--every 0: expected a whole number"),
            (["run", "s.ini", "--ring", "n", "--every", "65536"], "--every 65536: expected"),
            (["run", "s.ini", "--ring", "n", "--every", "2x"], "--every 2x: expected"),
            (["run", "s.ini", "--scope", "n", "--trigger", "lock"], "--trigger lock: expected fault"),
            (["run", "s.ini", "--scope", "n", "--trigger", "lock>"], "--trigger lock>: expected"),
            (["run", "s.ini", "--scope", "n", "--trigger", "lock>x"], "--trigger lock>x: expected"),
            (["run", "s.ini", "--scope", "n", "--trigger", "lock>inf"], "--trigger lock>inf"),
            (["run", "s.ini", "--scope", "n", "--trigger", "x>1"], "--trigger x>1: expected"),
            (["run", "s.ini", "--ring", "no/n"], "cannot write"),
            (["run", "start", "--seeds", "1-2", "--ring", "n"], "expected no --csv, --plot, --ring")]:
        refused(checks, folder, arguments, pattern)
    text = folder.run("decode", "--help").stdout
    for word in ["--kind", "--csv", "--json", "--plot", "lode_ring_drain"]:
        checks.true(word in text, f"'{word}' in the help: {text}")


def plots(checks, folder):
    for name in ("r.bin", "s.bin"):
        done = folder.run("decode", name, "--plot", "p.svg")
        if done.returncode == 2 and "gnuplot" in done.stderr:
            print("no gnuplot: plots left out")
            return
        checks.equal([done.returncode, done.stderr], [0, ""], f"plot of {name}")
        text = (folder.path / "p.svg").read_text()
        for word in ["</svg>", "theta_rad", "time", "v_bus_V", name]:
            checks.true(word in text, f"'{word}' in the plot of {name}")
    # One constant row, with what is no number in it.
    channels = [bits(F_PWM), 1, 0, 0, 0, 17]
    folder.write("one.bin", frame(0xA0, 0, channels) + frame(0x20, 0, [bits(5.0), bits(math.nan)]))
    done = folder.run("decode", "one.bin", "--plot", "p.svg")
    checks.equal([done.returncode, done.stderr], [0, ""], "plot of a single row")


def main():
    checks = Checks()
    with Folder() as folder:
        folder.write("s.ini", SCENARIO)
        round_trip(checks, folder)
        fault(checks, folder)
        not_triggered(checks, folder)
        values_without_name(checks, folder)
        folder.run("run", "s.ini", "--ring", "r.bin", "--scope", "s.bin", "--channels", NAMES,
                   "--trigger", "duty_a>0.55")
        frames = (folder.path / "r.bin").read_bytes()
        frames = frames[:offset_of(frames, 200)]
        damaged_frames(checks, folder, frames)
        refused_frames(checks, folder, frames)
        scope_buffers(checks, folder, (folder.path / "s.bin").read_bytes())
        ring_buffers(checks, folder, frames)
        command_line(checks, folder)
        plots(checks, folder)
    checks.done()


main()
