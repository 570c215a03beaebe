"""usage: tuning_fields.py: prints sim/design/tuning_fields.h, every scalar of a lode_drive_tuning_t, from the
headers in include/lodestar. A member that would leave padding on some machine ends it: a tuning, that of six phases
too, is made of floats, 32-bit integers and pairs of 16-bit ones."""
import pathlib
import re
import sys

from csource import code_of

INCLUDE = pathlib.Path(__file__).resolve().parents[2] / "include" / "lodestar"
TOP = "lode_drive_tuning_t"
TOP_6 = "lode_drive6_tuning_t"
HALF = "uint_least16_t"
SCALARS = {"float": "FLOAT", "int32_t": "INTEGER", "uint32_t": "WHOLE", HALF: "WHOLE"}
STRUCT = re.compile(r"typedef struct \{([^{}]*)\} (\w+);")
MEMBER = re.compile(r"(\w+) (\w+)(?:\[([\w()]+)\])?")
OBSERVER = re.compile(r"^LODE_OBSERVER\(.*, (\d+)\)$", re.M)

text = "\n".join(code_of(path.read_text()) for path in sorted(INCLUDE.glob("*.h")))
structs = {name: body for body, name in STRUCT.findall(text)}
constants = dict(re.findall(r"#define (LODE_\w+) (\d+)\s", text))
numbers = OBSERVER.findall((INCLUDE / "observers.def").read_text())
constants["sizeof(lode_observer_numbers_t)"] = max(int(number) for number in numbers)


def members(struct):
    """(type, name, number of elements or None) of each."""
    body = re.sub(r"^#.*", "", structs[struct], flags=re.M)  # what a build may leave out is there
    for line in body.split(";"):
        line = " ".join(line.split())
        if line:
            match = MEMBER.fullmatch(line)
            if match is None:
                sys.exit(f"{struct}: `{line}` is no member that this script can read")
            kind, name, count = match.groups()
            yield kind, name, count and int(constants.get(count, count))


def scalars(struct, prefix=""):
    halves = 0
    for kind, name, count in members(struct):
        if kind != HALF and halves % 2 != 0:
            sys.exit(f"{struct}.{name}: comes after a single {HALF}, expected pairs")
        halves += int(kind == HALF)
        for place in [name] if count is None else [f"{name}[{k}]" for k in range(count)]:
            if kind in structs:
                yield from scalars(kind, f"{prefix}{place}.")
            elif kind in SCALARS:
                # How many numbers of its tuning an observer uses depends on which it is.
                used = (SCALARS[kind], kind)
                if struct == "lode_observer_tuning_t" and count:
                    used = ("OBSERVER", re.search(r"\d+", place).group())
                yield *used, prefix + place
            else:
                sys.exit(f"{struct}.{name}: {kind}, expected one of {', '.join(SCALARS)}")
    if halves % 2 != 0:
        sys.exit(f"{struct}: ends in a single {HALF}, expected pairs")


print("// Printed by tests/tools/tuning_fields.py from the headers; the test gate_tuning_fields compares.")
print("// ROW(kind, type, member) of every scalar of a lode_drive_tuning_t; OBSERVER: the place for the type. TUNING6_FIELDS: of")
print("// those that a lode_drive6_tuning_t has besides two of these.")
print("// clang-format off")
print("#ifndef RIG_TUNING_FIELDS_H\n#define RIG_TUNING_FIELDS_H\n")
rows = [f"    ROW({kind}, {type_}, {place})" for kind, type_, place in scalars(TOP)]
rows6 = [f"    ROW({kind}, {type_}, {place})" for kind, type_, place in scalars(TOP_6)
         if not place.startswith(("drive.", "alone."))]
print("#define TUNING_FIELDS(ROW) \\\n" + " \\\n".join(rows))
print("\n#define TUNING6_FIELDS(ROW) \\\n" + " \\\n".join(rows6))
print("\n#endif")
